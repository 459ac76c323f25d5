#include "bake/bake_probes.h"

#include "profiler/prof.h"
#include "shading/shade_frame.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define USUAL_PROBES 2000.0f
#define WATCH_NS 100000000u
#define INSIDE 4u         /* a probe is inside of something if more than 1 / INSIDE of its rays meet backs */
#define MOVE_MOST 0.45f   /* of a cell */
#define BEYOND 1.1f       /* a probe moves out by so much of the distance, and */
#define CLEAR 0.02f       /* so much of a cell */
#define FOCUS 50.0f       /* exponent of the cosine by which a ray counts for a direction of `seen` */
#define PULL 1e-4         /* of the rays' weight: keeps a plane of few rays from standing on edge */
#define FAR_CELLS 4.0f    /* distances beyond count as this many cells */
#define LEAST_TRUST 1e-4f /* of a probe that does not see the place */
#define OFF_SURFACE 0.03f /* of a cell: so far off a surface it is looked whether a probe sees it */
#define ROWS 0xfff00000u  /* of random numbers: beyond those of pages */

/* One thread's memory. */
typedef struct probe_thread {
	stilb_gi_gather_point points[STILB_GI_GATHER_POINTS];
	stilb_gi_gathered found[STILB_GI_GATHER_FOUND];
} probe_thread;

typedef struct probe_bake {
	const stilb_bake_probes_options *options;
	stilb_bake_probes *probes;
	stilb_gi_gather *gather;
	probe_thread *threads;
	uint32_t part; /* whose light the probes see: one without flags */
	uint32_t total;
	uint64_t watched_ns; /* of the calling thread */
	/* Probes that are done or moved or dead; whether to give up. Relaxed: no data goes with them. */
	_Atomic uint32_t done, moved, dead;
	_Atomic bool stop;
} probe_bake;

/* ---- directions -------------------------------------------------------------------------------------------------- */

/* Sample i of n: which way the surface faces that takes it. Six ways, as many samples that follow one another to each,
 * so that each has a well-spread part of the sequence. */
static stilb_vec3 facing_of(uint32_t i, uint32_t n)
{
	uint32_t way = (uint32_t)((uint64_t)i * 6 / n);
	stilb_vec3 facing = {0};
	facing[way / 2] = way & 1 ? -1.0f : 1.0f;
	return facing;
}

/* The middle of cell i of the octahedron that is folded out: Cigolle et al., "A Survey of Efficient Representations for
 * Independent Unit Vectors" (JCGT 2014). */
static stilb_vec3 seen_direction(uint32_t i)
{
	uint32_t column = i % STILB_BAKE_SEEN, row = i / STILB_BAKE_SEEN;
	float x = 2.0f * ((float)column + 0.5f) / STILB_BAKE_SEEN - 1.0f;
	float y = 2.0f * ((float)row + 0.5f) / STILB_BAKE_SEEN - 1.0f;
	float z = 1.0f - fabsf(x) - fabsf(y), back = fmaxf(-z, 0.0f);
	x += x >= 0.0f ? -back : back;
	y += y >= 0.0f ? -back : back;
	return stilb_vec3_normalize(stilb_vec3_make(x, y, z));
}

/* How likely it is that the probe sees as far as `distance` in the direction d, unit: by the four cells about it, those
 * beyond the edges being folded over, the least likely. So in a corner of a room all its walls count, each with its own
 * plane. */
static float seen_chance(const stilb_bake_probe *probe, stilb_vec3 d, float distance)
{
	float sum = fabsf(d[0]) + fabsf(d[1]) + fabsf(d[2]), x = d[0] / sum, y = d[1] / sum, least = 1.0f;
	if (d[2] < 0.0f) {
		float ox = x;
		x = (1.0f - fabsf(y)) * (ox >= 0.0f ? 1.0f : -1.0f);
		y = (1.0f - fabsf(ox)) * (y >= 0.0f ? 1.0f : -1.0f);
	}
	float side = (float)STILB_BAKE_SEEN;
	int ix = (int)floorf((x * 0.5f + 0.5f) * side - 0.5f), iy = (int)floorf((y * 0.5f + 0.5f) * side - 0.5f);
	int last = (int)STILB_BAKE_SEEN - 1;
	for (int k = 0; k < 4; k++) {
		int cx = ix + (k & 1), cy = iy + (k >> 1);
		if (cx < 0 || cx > last) { /* beyond an edge comes the same edge, the other way round */
			cx = cx < 0 ? 0 : last;
			cy = last - cy;
		}
		if (cy < 0 || cy > last) {
			cy = cy < 0 ? 0 : last;
			cx = last - cx;
		}
		const float *cell = probe->seen[cy * (int)STILB_BAKE_SEEN + cx];
		float off = cell[0] * d[0] + cell[1] * d[1] + cell[2] * d[2] - 1.0f / distance;
		if (off > 0.0f)
			least = fminf(least, cell[3] / (cell[3] + off * off));
	}
	return least;
}

/* ---- one probe --------------------------------------------------------------------------------------------------- */

/* A small triangle about the place that faces n. */
static void probe_point(const probe_bake *bake, const float position[3], uint32_t probe, uint32_t sample,
                        stilb_gi_gather_point *point)
{
	stilb_vec3 n = facing_of(sample, bake->options->samples);
	shade_frame frame = shade_frame_from_normal(n);
	float reach = fmaxf(fmaxf(fabsf(position[0]), fabsf(position[1])), fabsf(position[2]));
	float size = 1e-3f * bake->probes->spacing + 1e-5f * reach;
	for (int i = 0; i < 3; i++) {
		float x = i == 0 ? 1.0f : -0.5f, y = i == 0 ? 0.0f : i == 1 ? 0.8660254f : -0.8660254f;
		stilb_vec3 corner = (frame.t * x + frame.b * y) * size;
		for (int k = 0; k < 3; k++)
			point->corners[i][k] = position[k] + corner[k];
	}
	memcpy(point->normal, &n, sizeof point->normal);
	point->u = point->v = 1.0f / 3.0f;
	point->part = bake->part;
	point->x = probe & 0xffffu;
	point->y = ROWS + (probe >> 16);
	point->sample = sample;
}

/* Sums over the samples of one probe. */
typedef struct probe_sums {
	double light[3][9];
	/* Sums over rays about a direction: w w^T, w / d, 1 / d^2, the weights. */
	double outer[STILB_BAKE_SEEN * STILB_BAKE_SEEN][6], near[STILB_BAKE_SEEN * STILB_BAKE_SEEN][3],
		squares[STILB_BAKE_SEEN * STILB_BAKE_SEEN], weights[STILB_BAKE_SEEN * STILB_BAKE_SEEN];
	uint32_t rays, backs;
	float nearest; /* back that a ray met */
	stilb_vec3 towards;
} probe_sums;

/* Of radiance from w surfaces that face six ways take (|x| + |y| + |z|) / 6 on the mean: what they take over that adds
 * up to the radiance's integral. */
static void add_light(probe_sums *sums, const stilb_gi_gathered *found, stilb_vec3 direction)
{
	shade_sh basis = shade_sh_basis(direction);
	float share = (fabsf(direction[0]) + fabsf(direction[1]) + fabsf(direction[2])) / 6.0f;
	for (int c = 0; c < 3; c++)
		for (int i = 0; i < 9; i++)
			sums->light[c][i] += (double)(found->irradiance[c] * basis.c[i] / share);
}

static void add_seen(probe_sums *sums, const stilb_gi_gathered *found, stilb_vec3 w, float most)
{
	double near = 1.0 / (double)fminf(found->distance, most);
	sums->rays++;
	sums->backs += found->back;
	if (found->back && found->distance < sums->nearest) {
		sums->nearest = found->distance;
		sums->towards = w;
	}
	for (uint32_t i = 0; i < STILB_BAKE_SEEN * STILB_BAKE_SEEN; i++) {
		float cosine = stilb_vec3_dot(seen_direction(i), w);
		if (!(cosine > 0.0f))
			continue;
		double weight = (double)powf(cosine, FOCUS);
		for (int k = 0; k < 3; k++) {
			sums->outer[i][k] += weight * (double)(w[k] * w[k]);
			sums->outer[i][3 + k] += weight * (double)(w[(k + 1) % 3] * w[(k + 2) % 3]);
			sums->near[i][k] += weight * near * (double)w[k];
		}
		sums->squares[i] += weight * near * near;
		sums->weights[i] += weight;
	}
}

static void probe_gather(const probe_bake *bake, uint32_t worker, uint32_t index, const float position[3],
                         probe_sums *sums)
{
	probe_thread *thread = &bake->threads[worker];
	uint32_t samples = bake->options->samples;
	memset(sums, 0, sizeof *sums);
	sums->nearest = INFINITY;
	for (uint32_t first = 0, count; first < samples; first += count) {
		count = samples - first < STILB_GI_GATHER_POINTS ? samples - first : STILB_GI_GATHER_POINTS;
		for (uint32_t i = 0; i < count; i++)
			probe_point(bake, position, index, first + i, &thread->points[i]);
		uint32_t n = stilb_gi_gather_light(bake->gather, worker, thread->points, count, thread->found);
		for (uint32_t i = 0; i < n; i++) {
			const stilb_gi_gathered *found = &thread->found[i];
			stilb_vec3 direction = stilb_vec3_make(found->direction[0], found->direction[1], found->direction[2]);
			add_light(sums, found, direction);
			if (!found->asked)
				add_seen(sums, found, direction, FAR_CELLS * bake->probes->spacing);
		}
	}
}

static bool is_inside(const probe_sums *sums)
{
	return INSIDE * sums->backs > sums->rays;
}

/* The plane that fits the rays about direction i best, and what is left: least squares of 1 / d over w, a little of it
 * drawn to a plane across the direction, at the mean distance. */
static void fit_plane(const probe_sums *sums, uint32_t i, float plane[4])
{
	const double *o = sums->outer[i], weight = sums->weights[i], pull = PULL * weight;
	stilb_vec3 middle = seen_direction(i);
	double mean = 0.0, m[3][3] = {{o[0] + pull, o[5], o[4]}, {o[5], o[1] + pull, o[3]}, {o[4], o[3], o[2] + pull}},
		   r[3];
	for (int k = 0; k < 3; k++)
		mean += sums->near[i][k] * (double)middle[k];
	for (int k = 0; k < 3; k++)
		r[k] = sums->near[i][k] + PULL * mean * (double)middle[k];
	double minor[3], a[3], left = sums->squares[i];
	for (int k = 0; k < 3; k++)
		minor[k] = m[1][(k + 1) % 3] * m[2][(k + 2) % 3] - m[1][(k + 2) % 3] * m[2][(k + 1) % 3];
	double determinant = m[0][0] * minor[0] + m[0][1] * minor[1] + m[0][2] * minor[2];
	for (int k = 0; k < 3; k++) { /* the inverse of a symmetric matrix, row by row */
		int x = (k + 1) % 3, y = (k + 2) % 3;
		a[k] = 0.0;
		for (int j = 0; j < 3; j++) {
			int u = (j + 1) % 3, v = (j + 2) % 3;
			a[k] += (m[x][u] * m[y][v] - m[x][v] * m[y][u]) * r[j] / determinant;
		}
	}
	for (int k = 0; k < 3; k++) { /* |1/d - a.w|^2, summed */
		left += a[k] * a[k] * o[k] + 2.0 * a[(k + 1) % 3] * a[(k + 2) % 3] * o[3 + k] - 2.0 * a[k] * sums->near[i][k];
		plane[k] = (float)a[k];
	}
	plane[3] = (float)fmax(left / weight, 0.0);
}

static void probe_store(const probe_sums *sums, uint32_t samples, stilb_bake_probe *probe)
{
	shade_sh *channels[3] = {&probe->light.r, &probe->light.g, &probe->light.b};
	for (int c = 0; c < 3; c++)
		for (int i = 0; i < 9; i++)
			channels[c]->c[i] = (float)(sums->light[c][i] / samples);
	for (uint32_t i = 0; i < STILB_BAKE_SEEN * STILB_BAKE_SEEN; i++)
		fit_plane(sums, i, probe->seen[i]);
}

/* Where a probe stands before it moves. */
static void probe_home(const stilb_bake_probes *probes, uint32_t index, float position[3])
{
	uint32_t at[3] = {index % probes->count[0], index / probes->count[0] % probes->count[1],
	                  index / probes->count[0] / probes->count[1]};
	for (int k = 0; k < 3; k++)
		position[k] = probes->low[k] + (float)at[k] * probes->spacing;
}

static void bake_probe(probe_bake *bake, uint32_t worker, uint32_t index)
{
	stilb_bake_probe *probe = &bake->probes->probes[index];
	float cell = bake->probes->spacing;
	probe_sums sums;
	probe_home(bake->probes, index, probe->position);
	probe_gather(bake, worker, index, probe->position, &sums);
	float way = sums.nearest * BEYOND + CLEAR * cell;
	if (is_inside(&sums) && way <= MOVE_MOST * cell) {
		for (int k = 0; k < 3; k++)
			probe->position[k] += way * sums.towards[k];
		probe_gather(bake, worker, index, probe->position, &sums);
		atomic_fetch_add_explicit(&bake->moved, 1, memory_order_relaxed); /* relaxed: probe_bake */
	}
	probe->dead = is_inside(&sums);
	if (probe->dead)
		atomic_fetch_add_explicit(&bake->dead, 1, memory_order_relaxed); /* relaxed: probe_bake */
	probe_store(&sums, bake->options->samples, probe);
}

static void watch_probes(probe_bake *bake)
{
	uint64_t now = stilb_time_ns();
	if (!bake->options->watch || now - bake->watched_ns < WATCH_NS)
		return;
	bake->watched_ns = now;
	double done = (double)atomic_load_explicit(&bake->done, memory_order_relaxed) / bake->total; /* relaxed: above */
	if (!bake->options->watch(bake->options->user, done))
		atomic_store_explicit(&bake->stop, true, memory_order_relaxed); /* relaxed: probe_bake */
}

/* stilb_job_range_fn */
static void bake_some_probes(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	probe_bake *bake = context;
	PROFILE("bake.probes");
	for (uint32_t i = begin; i < end; i++) {
		if (worker == 0)
			watch_probes(bake);
		if (atomic_load_explicit(&bake->stop, memory_order_relaxed)) /* relaxed: probe_bake */
			return;
		bake_probe(bake, worker, i);
		atomic_fetch_add_explicit(&bake->done, 1, memory_order_relaxed); /* relaxed: probe_bake */
	}
}

/* ---- the grid ---------------------------------------------------------------------------------------------------- */

/* Lays the grid over the box: count, low and spacing. */
static stilb_result lay_grid(const stilb_gi_scene_info *info, float spacing, stilb_bake_probes *probes)
{
	float size[3], volume = 1.0f, largest = 0.0f;
	double total = 1.0;
	if (!(info->low[0] <= info->high[0]))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the scene has no triangles that rays can hit: no place for probes");
	for (int k = 0; k < 3; k++)
		largest = fmaxf(largest, info->high[k] - info->low[k]);
	for (int k = 0; k < 3; k++)
		volume *= fmaxf(info->high[k] - info->low[k], 0.05f * largest);
	probes->spacing = spacing > 0.0f ? spacing : fmaxf(cbrtf(volume / USUAL_PROBES), 1e-6f);
	for (int k = 0; k < 3; k++) {
		size[k] = fmaxf(info->high[k] - info->low[k], 2.0f * probes->spacing);
		float cells = fmaxf(floorf(size[k] / probes->spacing + 1e-3f), 1.0f);
		total *= (double)cells;
		probes->count[k] = cells < (float)STILB_BAKE_MAX_PROBES ? (uint32_t)cells : STILB_BAKE_MAX_PROBES;
		probes->low[k] = info->low[k] + 0.5f * (size[k] - (cells - 1.0f) * probes->spacing);
	}
	if (total <= (double)STILB_BAKE_MAX_PROBES)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "probes %g m apart would be %.3g; at most %u are possible: give more metres",
	                  (double)probes->spacing, total, STILB_BAKE_MAX_PROBES);
}

/* The part of a model without flags; 0 if all have some. */
static uint32_t plain_part(const stilb_scene *scene)
{
	for (uint32_t model = 0; model < scene->model_count; model++)
		if (scene->model_flags[model] == 0 && scene->first_part[model] < scene->first_part[model + 1])
			return scene->first_part[model];
	return 0;
}

stilb_result stilb_bake_probes_bake(const stilb_scene *scene, const stilb_gi_scene *gi_scene, stilb_gi_gather *gather,
                                    stilb_job_pool *pool, const stilb_bake_probes_options *options,
                                    stilb_bake_probes *probes)
{
	STILB_ASSERT(options->samples >= 16 && options->spacing >= 0.0f);
	probe_bake bake = {.options = options, .probes = probes, .gather = gather, .part = plain_part(scene)};
	*probes = (stilb_bake_probes){0};
	stilb_result result = lay_grid(stilb_gi_scene_info_of(gi_scene), options->spacing, probes);
	if (result != STILB_OK) {
		*probes = (stilb_bake_probes){0};
		return result;
	}
	bake.total = probes->count[0] * probes->count[1] * probes->count[2];
	bake.threads = stilb_memory_alloc((size_t)stilb_job_pool_worker_count(pool) + 1, sizeof *bake.threads);
	probes->probes = stilb_memory_alloc(bake.total, sizeof *probes->probes);
	bool good = bake.threads && probes->probes;
	if (good)
		stilb_job_parallel_for(pool, bake.total, 1, bake_some_probes, &bake, 0);
	free(bake.threads);
	bool stopped = atomic_load_explicit(&bake.stop, memory_order_relaxed);   /* relaxed: probe_bake */
	probes->moved = atomic_load_explicit(&bake.moved, memory_order_relaxed); /* likewise */
	probes->dead = atomic_load_explicit(&bake.dead, memory_order_relaxed);   /* likewise */
	if (good && !stopped)
		return STILB_OK;
	stilb_bake_probes_finish(probes);
	return good ? stilb_fail(STILB_ERROR_GIVEN_UP, "the bake was stopped")
	            : stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u probes", bake.total);
}

void stilb_bake_probes_finish(stilb_bake_probes *probes)
{
	free(probes->probes);
	*probes = (stilb_bake_probes){0};
}

/* ---- lookups ----------------------------------------------------------------------------------------------------- */

/* The eight probes about a place, and how near each is: weights that are 1 together. */
typedef struct probe_cell {
	const stilb_bake_probe *probes[8];
	float weights[8];
} probe_cell;

static probe_cell cell_about(const stilb_bake_probes *probes, const float position[3])
{
	uint32_t base[3], step[3], stride[3] = {1, probes->count[0], probes->count[0] * probes->count[1]}, first = 0;
	float part[3];
	probe_cell cell;
	for (int k = 0; k < 3; k++) {
		float at = (position[k] - probes->low[k]) / probes->spacing, last = (float)(probes->count[k] - 1);
		at = at > 0.0f ? at < last ? at : last : 0.0f;
		base[k] = (uint32_t)at;
		step[k] = base[k] + 1 < probes->count[k] ? stride[k] : 0;
		part[k] = at - (float)base[k];
		first += base[k] * stride[k];
	}
	for (uint32_t i = 0; i < 8; i++) {
		uint32_t index = first;
		cell.weights[i] = 1.0f;
		for (int k = 0; k < 3; k++) {
			bool next = i >> k & 1;
			index += next ? step[k] : 0;
			cell.weights[i] *= next ? part[k] : 1.0f - part[k];
		}
		cell.probes[i] = &probes->probes[index];
	}
	return cell;
}

/* How much the probe counts for a place with this normal: after Majercik et al. (2019), 5.2. */
static float trust_of(const stilb_bake_probe *probe, stilb_vec3 place, stilb_vec3 normal, float cell)
{
	stilb_vec3 home = stilb_vec3_make(probe->position[0], probe->position[1], probe->position[2]);
	stilb_vec3 to = home - place, from = place + normal * (OFF_SURFACE * cell) - home;
	float length = sqrtf(stilb_vec3_dot(to, to)), distance = sqrtf(stilb_vec3_dot(from, from));
	float front = length > 0.0f ? 0.5f * (stilb_vec3_dot(to, normal) / length + 1.0f) : 1.0f;
	float trust = front * front + 0.2f;
	if (!(distance > 0.0f))
		return trust;
	float chance = seen_chance(probe, from * (1.0f / distance), distance);
	return trust * fmaxf(chance * chance * chance, LEAST_TRUST);
}

static shade_sh_rgb sh_scaled(shade_sh_rgb f, float factor)
{
	return (shade_sh_rgb){shade_sh_scale(f.r, factor), shade_sh_scale(f.g, factor), shade_sh_scale(f.b, factor)};
}

/* The mean over the cell's probes; none counts: nothing is known, and it is dark. */
static shade_sh_rgb cell_mean(const probe_cell *cell)
{
	shade_sh_rgb sum = {0};
	float weights = 0.0f;
	for (int i = 0; i < 8; i++) {
		sum = shade_sh_rgb_add(sum, sh_scaled(cell->probes[i]->light, cell->weights[i]));
		weights += cell->weights[i];
	}
	return weights > 0.0f ? sh_scaled(sum, 1.0f / weights) : (shade_sh_rgb){0};
}

shade_sh_rgb stilb_bake_probes_at_plain(const stilb_bake_probes *probes, const float position[3])
{
	probe_cell cell = cell_about(probes, position);
	return cell_mean(&cell);
}

shade_sh_rgb stilb_bake_probes_at(const stilb_bake_probes *probes, const float position[3], const float normal[3])
{
	probe_cell cell = cell_about(probes, position);
	stilb_vec3 place = stilb_vec3_make(position[0], position[1], position[2]);
	stilb_vec3 n = stilb_vec3_make(normal[0], normal[1], normal[2]);
	for (int i = 0; i < 8; i++) {
		const stilb_bake_probe *probe = cell.probes[i];
		float near = fmaxf(cell.weights[i], 1e-4f); /* where the others see nothing, one far away still counts */
		cell.weights[i] = probe->dead ? 0.0f : near * trust_of(probe, place, n, probes->spacing);
	}
	return cell_mean(&cell);
}
