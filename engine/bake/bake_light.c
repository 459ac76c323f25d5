#include "bake/bake_light.h"

#include "base/base_math.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK 32u           /* texels of one slice of the loop */
#define WATCH_NS 100000000u /* between two calls of the watcher */
#define PAGE_STRIDE 65536u  /* rows of random numbers between two pages */
#define INV_PI 0.318309886f
#define LEAST_COSINE 1e-6f

/* One thread's memory. */
typedef struct light_thread {
	stilb_gi_gather_point points[STILB_GI_GATHER_POINTS];
	uint32_t texel_of[STILB_GI_GATHER_POINTS], cell_of[STILB_GI_GATHER_POINTS]; /* of the block, of the texel */
	stilb_gi_gathered found[STILB_GI_GATHER_FOUND];
	float open[STILB_GI_GATHER_POINTS];
	uint32_t count;
} light_thread;

/* Sums of one texel. */
typedef struct texel_sums {
	double light[STILB_BAKE_CELLS][3], open[STILB_BAKE_CELLS];
	double directional[STILB_BAKE_CELLS][STILB_BAKE_BASIS][3];
	stilb_vec3 basis[STILB_BAKE_CELLS][STILB_BAKE_BASIS]; /* the spots' directions, in the world */
	uint32_t samples[STILB_BAKE_CELLS], backs[STILB_BAKE_CELLS];
} texel_sums;

typedef struct light_bake {
	const stilb_scene *scene;
	const stilb_bake_atlas *atlas;
	const stilb_bake_texels *texels;
	stilb_gi_gather *gather;
	const stilb_bake_light_options *options;
	light_thread *threads;
	uint32_t *list; /* [count] texels that have spots */
	uint32_t count;
	stilb_bake_layers layers;
	float (*normal_to_world)[9]; /* [part_count] column by column */
	bool *mirrored;              /* [part_count] the transform turns right hands into left ones */
	uint64_t watched_ns;         /* of the calling thread */
	/* Blocks that are done, for progress, and whether to give up. Relaxed: no data goes with them. */
	_Atomic uint32_t done;
	_Atomic bool stop;
} light_bake;

/* ---- points ------------------------------------------------------------------------------------------------------ */

/* The matrix by which normals go to the world, up to length and side: the cofactors. Returns whether the transform
 * is mirrored, which turns triangles about: their fronts stay where they are. */
static bool normal_matrix(const stilb_mat4 *transform, float n[9])
{
	const float *m = transform->m;
	for (int a = 0; a < 3; a++)
		for (int k = 0; k < 3; k++) {
			int b = (a + 1) % 3, c = (a + 2) % 3, i = (k + 1) % 3, j = (k + 2) % 3;
			n[3 * a + k] = m[4 * b + i] * m[4 * c + j] - m[4 * b + j] * m[4 * c + i];
		}
	return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < 0.0f;
}

static stilb_vec3 transformed(const stilb_mat4 *transform, const float p[3])
{
	const float *m = transform->m;
	return stilb_vec3_make(m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12],
	                       m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13],
	                       m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14]);
}

/* The surface's normal at the spot: interpolated, on the triangle's front, where the file has one. */
static stilb_vec3 spot_normal(const light_bake *bake, uint32_t part, const stilb_scene_vertex *corners[3],
                              const stilb_gi_gather_point *point, stilb_vec3 geometric)
{
	const float *n = bake->normal_to_world[part], share[3] = {1.0f - point->u - point->v, point->u, point->v};
	float local[3] = {0.0f, 0.0f, 0.0f};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			local[k] += corners[i]->normal[k] * share[i];
	stilb_vec3 normal = stilb_vec3_make(n[0] * local[0] + n[3] * local[1] + n[6] * local[2],
	                                    n[1] * local[0] + n[4] * local[1] + n[7] * local[2],
	                                    n[2] * local[0] + n[5] * local[1] + n[8] * local[2]);
	float square = stilb_vec3_dot(normal, normal), facing = stilb_vec3_dot(normal, geometric);
	if (!(square > 1e-30f && square < 1e30f) || !(facing * facing > 1e-6f * square))
		return geometric;
	return normal * ((facing < 0.0f ? -1.0f : 1.0f) / sqrtf(square));
}

static void spot_point(const light_bake *bake, uint32_t texel, const stilb_bake_spot *spot, uint32_t sample,
                       stilb_gi_gather_point *point)
{
	uint32_t part = bake->texels->part[bake->texels->place[texel]];
	const stilb_mat4 *transform = &bake->scene->part_transform[part];
	const stilb_scene_mesh *mesh = &bake->scene->meshes[bake->scene->part_mesh[part]];
	const stilb_scene_vertex *vertices[3];
	stilb_vec3 corners[3];
	bool mirrored = bake->mirrored[part];
	for (int i = 0; i < 3; i++) {
		int corner = mirrored ? (3 - i) % 3 : i; /* 0, 2, 1 */
		vertices[i] = &mesh->vertices[mesh->indices[3 * (size_t)spot->triangle + (size_t)corner]];
		corners[i] = transformed(transform, vertices[i]->position);
		memcpy(point->corners[i], &corners[i], sizeof point->corners[i]);
	}
	stilb_vec3 cross = stilb_vec3_cross(corners[1] - corners[0], corners[2] - corners[0]);
	stilb_vec3 geometric = cross * (1.0f / sqrtf(fmaxf(stilb_vec3_dot(cross, cross), 1e-37f)));
	point->u = mirrored ? spot->v : spot->u;
	point->v = mirrored ? spot->u : spot->v;
	stilb_vec3 normal = spot_normal(bake, part, vertices, point, geometric);
	memcpy(point->normal, &normal, sizeof point->normal);
	point->part = part;
	point->x = texel % bake->texels->side;
	point->y = texel / bake->texels->side + bake->texels->page * PAGE_STRIDE;
	point->sample = sample;
}

/* The directions of the basis at a spot, in the world: bake_basis.h has the frame. point: of the spot. */
static void spot_basis(const light_bake *bake, uint32_t texel, const stilb_bake_spot *spot,
                       const stilb_gi_gather_point *point, stilb_vec3 basis[STILB_BAKE_BASIS])
{
	float at[3][2];
	uint32_t page;
	stilb_vec3 corners[3], normal = stilb_vec3_make(point->normal[0], point->normal[1], point->normal[2]);
	bool mirrored = bake->mirrored[point->part];
	stilb_bake_atlas_corners(bake->atlas, bake->texels->part[bake->texels->place[texel]], spot->triangle, &page, at);
	for (int i = 0; i < 3; i++) {
		const float *p = point->corners[mirrored ? (3 - i) % 3 : i];
		corners[i] = stilb_vec3_make(p[0], p[1], p[2]);
	}
	/* The page's axes on the triangle, times its area there. */
	float bx = at[1][0] - at[0][0], by = at[1][1] - at[0][1], cx = at[2][0] - at[0][0], cy = at[2][1] - at[0][1];
	stilb_vec3 along_u = (corners[1] - corners[0]) * cy - (corners[2] - corners[0]) * by;
	stilb_vec3 along_v = (corners[2] - corners[0]) * bx - (corners[1] - corners[0]) * cx;
	stilb_vec3 x = along_u - normal * stilb_vec3_dot(normal, along_u);
	x *= 1.0f / sqrtf(fmaxf(stilb_vec3_dot(x, x), 1e-37f));
	stilb_vec3 y = stilb_vec3_cross(normal, x);
	if (stilb_vec3_dot(y, along_v) < 0.0f)
		y = -y;
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
		stilb_vec3 b = stilb_bake_basis(k);
		basis[k] = x * b[0] + y * b[1] + normal * b[2];
	}
}

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

/* What arrives at a surface that faces each direction of the basis, of what arrives at one that faces the normal. */
static void add_directional(texel_sums *sums, uint32_t cell, const stilb_gi_gather_point *point,
                            const stilb_gi_gathered *found)
{
	stilb_vec3 direction = stilb_vec3_make(found->direction[0], found->direction[1], found->direction[2]);
	stilb_vec3 normal = stilb_vec3_make(point->normal[0], point->normal[1], point->normal[2]);
	float cosine = fmaxf(stilb_vec3_dot(normal, direction), LEAST_COSINE);
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
		float share = fmaxf(stilb_vec3_dot(sums->basis[cell][k], direction), 0.0f) / cosine;
		for (int c = 0; c < 3; c++)
			sums->directional[cell][k][c] += (double)(found->irradiance[c] * share);
	}
}

static void batch_end(light_bake *bake, uint32_t worker, texel_sums *sums)
{
	light_thread *thread = &bake->threads[worker];
	if (thread->count == 0)
		return;
	if (bake->layers.light) {
		uint32_t n = stilb_gi_gather_light(bake->gather, worker, thread->points, thread->count, thread->found);
		for (uint32_t i = 0; i < n; i++) {
			const stilb_gi_gathered *found = &thread->found[i];
			texel_sums *to = &sums[thread->texel_of[found->point]];
			uint32_t cell = thread->cell_of[found->point];
			for (int k = 0; k < 3; k++)
				to->light[cell][k] += (double)found->irradiance[k];
			to->backs[cell] += found->back;
			if (bake->layers.directional)
				add_directional(to, cell, &thread->points[found->point], found);
		}
	}
	if (bake->layers.open) {
		stilb_gi_gather_open(bake->gather, worker, thread->points, thread->count, bake->options->ao_distance,
		                     thread->open);
		for (uint32_t i = 0; i < thread->count; i++)
			sums[thread->texel_of[i]].open[thread->cell_of[i]] += (double)thread->open[i];
	}
	for (uint32_t i = 0; i < thread->count; i++)
		sums[thread->texel_of[i]].samples[thread->cell_of[i]]++;
	thread->count = 0;
}

/* The samples of a texel go to its spots in turn, as many that follow one another to each, so that each spot has a
 * well-spread part of the sequence. */
static void texel_sample(light_bake *bake, uint32_t worker, uint32_t index, uint32_t in_block, texel_sums *sums)
{
	light_thread *thread = &bake->threads[worker];
	uint32_t texel = bake->list[index], cells[STILB_BAKE_CELLS], count = 0, samples = bake->options->samples;
	for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++)
		if (bake->texels->spots[texel][c].share > 0.0f)
			cells[count++] = c;
	for (uint32_t i = 0; i < count && bake->layers.directional; i++) {
		stilb_gi_gather_point point;
		const stilb_bake_spot *spot = &bake->texels->spots[texel][cells[i]];
		spot_point(bake, texel, spot, 0, &point);
		spot_basis(bake, texel, spot, &point, sums[in_block].basis[cells[i]]);
	}
	for (uint32_t s = 0; s < samples; s++) {
		uint32_t cell = cells[(uint64_t)s * count / samples];
		spot_point(bake, texel, &bake->texels->spots[texel][cell], s, &thread->points[thread->count]);
		thread->texel_of[thread->count] = in_block;
		thread->cell_of[thread->count++] = cell;
		if (thread->count == STILB_GI_GATHER_POINTS)
			batch_end(bake, worker, sums);
	}
}

/* True if the spot's rays mostly met backs. */
static bool spot_is_hidden(const texel_sums *sums, uint32_t cell)
{
	return 2 * sums->backs[cell] > sums->samples[cell];
}

/* The colours of the basis: bake_basis.h. light: sums of the same samples. */
static void store_directional(float (*to)[3], double (*sums)[3], const double light[3], uint32_t samples)
{
	for (int c = 0; c < 3; c++) {
		double mean = (sums[0][c] + sums[1][c] + sums[2][c]) / 3.0;
		for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++)
			to[k][c] = (float)((mean > 0.0 ? sums[k][c] / mean : 1.0) * light[c] / samples) * INV_PI;
	}
}

/* Means over the spots that see out, or over all if none does. */
static void texel_store(const light_bake *bake, uint32_t texel, const texel_sums *sums)
{
	double light[3] = {0.0, 0.0, 0.0}, directional[STILB_BAKE_BASIS][3] = {{0.0}}, open = 0.0;
	uint32_t samples = 0;
	bool seeing = bake->options->keep_hidden;
	for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++)
		seeing |= sums->samples[c] > 0 && !spot_is_hidden(sums, c);
	for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++) {
		if (seeing && !bake->options->keep_hidden && spot_is_hidden(sums, c))
			continue;
		for (int i = 0; i < 3; i++) {
			light[i] += sums->light[c][i];
			for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++)
				directional[k][i] += sums->directional[c][k][i];
		}
		open += sums->open[c];
		samples += sums->samples[c];
	}
	for (int k = 0; k < 3 && bake->layers.light; k++)
		bake->layers.light[texel][k] = (float)(light[k] / samples) * INV_PI;
	if (bake->layers.directional)
		store_directional(bake->layers.directional[texel], directional, light, samples);
	if (bake->layers.open)
		bake->layers.open[texel] = (float)(open / samples);
	bake->layers.state[texel] = seeing ? STILB_BAKE_LIT : STILB_BAKE_HIDDEN;
}

static void watch(light_bake *bake)
{
	uint64_t now = stilb_time_ns();
	if (!bake->options->watch || now - bake->watched_ns < WATCH_NS)
		return;
	bake->watched_ns = now;
	uint32_t blocks = (bake->count + BLOCK - 1) / BLOCK;
	double done = (double)atomic_load_explicit(&bake->done, memory_order_relaxed) / blocks; /* relaxed: light_bake */
	if (!bake->options->watch(bake->options->user, done))
		atomic_store_explicit(&bake->stop, true, memory_order_relaxed); /* relaxed: light_bake */
}

/* stilb_job_range_fn */
static void bake_blocks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	light_bake *bake = context;
	PROFILE("bake.light");
	for (uint32_t block = begin; block < end; block++) {
		texel_sums sums[BLOCK];
		uint32_t first = block * BLOCK, count = bake->count - first < BLOCK ? bake->count - first : BLOCK;
		if (worker == 0)
			watch(bake);
		if (atomic_load_explicit(&bake->stop, memory_order_relaxed)) /* relaxed: light_bake */
			return;
		memset(sums, 0, sizeof sums);
		for (uint32_t i = 0; i < count; i++)
			texel_sample(bake, worker, first + i, i, sums);
		batch_end(bake, worker, sums);
		for (uint32_t i = 0; i < count; i++)
			texel_store(bake, bake->list[first + i], &sums[i]);
		atomic_fetch_add_explicit(&bake->done, 1, memory_order_relaxed); /* relaxed: light_bake */
	}
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

/* A chart of which all texels are hidden keeps what it has: a tent whose cloth has one side only, say. */
static bool keep_lone_charts(const light_bake *bake)
{
	uint8_t *seen = calloc((size_t)bake->atlas->place_count + 1, 1);
	for (uint32_t i = 0; i < bake->count && seen; i++)
		seen[bake->texels->place[bake->list[i]]] |= bake->layers.state[bake->list[i]] == STILB_BAKE_LIT;
	for (uint32_t i = 0; i < bake->count && seen; i++)
		if (!seen[bake->texels->place[bake->list[i]]])
			bake->layers.state[bake->list[i]] = STILB_BAKE_LIT;
	free(seen);
	return seen;
}

static void list_texels(light_bake *bake, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (bake->texels->place[i] != STILB_BAKE_NO_CHART)
			bake->list[bake->count++] = (uint32_t)i;
	for (uint32_t part = 0; part < bake->atlas->part_count; part++)
		bake->mirrored[part] = normal_matrix(&bake->scene->part_transform[part], bake->normal_to_world[part]);
}

/* Sets the layers to 0, and the list of texels up. */
static void page_clear(light_bake *bake, size_t count)
{
	const stilb_bake_layers *layers = &bake->layers;
	if (layers->light)
		memset(layers->light, 0, count * sizeof *layers->light);
	if (layers->directional)
		memset(layers->directional, 0, count * sizeof *layers->directional);
	if (layers->open)
		memset(layers->open, 0, count * sizeof *layers->open);
	memset(layers->state, STILB_BAKE_EMPTY, count);
	list_texels(bake, count);
}

stilb_result stilb_bake_light(const stilb_scene *scene, const stilb_bake_atlas *atlas, const stilb_bake_texels *texels,
                              stilb_gi_gather *gather, stilb_job_pool *pool, const stilb_bake_light_options *options,
                              const stilb_bake_layers *layers)
{
	STILB_ASSERT(scene->part_count == atlas->part_count && options->samples >= 1 && options->ao_distance > 0.0f);
	STILB_ASSERT(layers->state && (layers->light || !layers->directional));
	size_t count = (size_t)texels->side * texels->side;
	uint32_t threads = stilb_job_pool_worker_count(pool) + 1;
	light_bake bake = {.scene = scene, .atlas = atlas, .texels = texels, .gather = gather, .options = options};
	bake.layers = *layers;
	bake.threads = stilb_memory_alloc(threads, sizeof *bake.threads);
	bake.list = stilb_memory_alloc(texels->covered, sizeof *bake.list);
	bake.normal_to_world = stilb_memory_alloc(atlas->part_count, sizeof *bake.normal_to_world);
	bake.mirrored = stilb_memory_alloc(atlas->part_count, sizeof *bake.mirrored);
	bool good = bake.threads && bake.list && bake.normal_to_world && bake.mirrored;
	if (good) {
		for (uint32_t i = 0; i < threads; i++)
			bake.threads[i].count = 0;
		page_clear(&bake, count);
		stilb_job_parallel_for(pool, (bake.count + BLOCK - 1) / BLOCK, 1, bake_blocks, &bake, 0);
		good = keep_lone_charts(&bake);
	}
	free(bake.threads);
	free(bake.list);
	free(bake.normal_to_world);
	free(bake.mirrored);
	if (!good)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory to bake %zu texels", count);
	if (atomic_load_explicit(&bake.stop, memory_order_relaxed)) /* relaxed: light_bake */
		return stilb_fail(STILB_ERROR_GIVEN_UP, "the bake was stopped");
	return STILB_OK;
}
