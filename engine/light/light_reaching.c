/* Which lights reach a view, and where they are in it. */
#include "light/light_lists.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>

#define LIGHT_COUNT_MAX 0x7fff0000u /* below LIGHT_WITH_CONE */
#define HALF_SPACE_MAX 1e-4f        /* cosines from minus this on are those of flat lights */
#define LIGHT_QUICK_GROWTH 1.00001  /* of a reach: more than light_bounds_within adds, but for what a place needs */
#define HALF_SPACE_PULL 2e-5        /* share of the radius: more than cosines of flat lights are below 0 */

void light_spread(light_build *build, uint32_t count, stilb_job_range_fn *fn)
{
	const light_view *view = &build->scratch->view;
	uint64_t work = ((uint64_t)build->count + LIGHT_CELLS_WORK) * light_bands(view) * view->slices;
	if (build->pool && work >= build->scratch->serial_below)
		stilb_job_parallel_for(build->pool, count, 1, fn, build, build->worker);
	else
		fn(0, count, 0, build);
}

void light_reaching_finish(light_reaching *r)
{
	free(r->x);
	free(r->first_slice);
	free(r->cones);
	free(r->number);
	free(r->chunks);
	*r = (light_reaching){0};
}

static bool reaching_reserve(light_reaching *r, uint32_t count)
{
	uint32_t chunks = count / LIGHT_CHUNK + 1;
	if (chunks * LIGHT_CHUNK <= r->capacity)
		return true;
	light_reaching_finish(r);
	chunks += chunks / 4;
	size_t room = (size_t)chunks * LIGHT_CHUNK;
	r->x = stilb_memory_alloc(5 * room, sizeof *r->x);
	r->first_slice = stilb_memory_alloc(2 * room, sizeof *r->first_slice);
	r->cones = stilb_memory_alloc(room, sizeof *r->cones);
	r->number = stilb_memory_alloc(3 * room, sizeof *r->number);
	r->chunks = stilb_memory_alloc(chunks, sizeof *r->chunks);
	if (!r->x || !r->first_slice || !r->cones || !r->number || !r->chunks) {
		light_reaching_finish(r);
		return false;
	}
	r->y = r->x + room;
	r->w = r->y + room;
	r->depth = r->w + room;
	r->radius = r->depth + room;
	r->last_slice = r->first_slice + room;
	r->index = r->number + room;
	r->everywhere = r->index + room;
	r->capacity = (uint32_t)room;
	return true;
}

/* Four affine functions of a point. */
static light_four affine(const light_four functions[4], const float p[3])
{
	light_four sum = functions[3];
	for (int k = 0; k < 3; k++) {
		light_two factor = {(double)p[k], (double)p[k]};
		sum.low += functions[k].low * factor;
		sum.high += functions[k].high * factor;
	}
	return sum;
}

/* What is added to a radius, metres: covers the rounding of all that follows. */
static double slack_of(const light_view *view, const float p[3], double radius)
{
	return LIGHT_RELATIVE * (view->growth * (light_size(p) + radius) + view->reach);
}

/* True if a sphere reaches the space that the view shows. */
static bool reaches_view(const light_view *view, const float p[3], double radius)
{
	light_four sides = affine(view->sides, p);
	double depth = view->depth[0] * (double)p[0] + view->depth[1] * (double)p[1] + view->depth[2] * (double)p[2];
	return light_smaller(light_smaller(sides.low[0], sides.low[1]), light_smaller(sides.high[0], sides.high[1])) >=
	           -radius &&
	       depth + view->depth[3] >= -radius;
}

static light_cone cone_of(const light_view *view, const stilb_light_bounds *bounds, double slack)
{
	light_cone cone = {.some = bounds->cos_angle >= -HALF_SPACE_MAX};
	if (!cone.some)
		return cone;
	double cosine = light_larger((double)bounds->cos_angle, 0.0);
	double pull = bounds->cos_angle < 0.0f ? HALF_SPACE_PULL * (double)bounds->sphere.radius : 0.0;
	cone.cosine = (float)cosine;
	cone.sine = (float)sqrt(1.0 - cosine * cosine);
	cone.slack = (float)slack;
	for (int i = 0; i < 3; i++) {
		cone.axis[i] = bounds->axis[i];
		cone.base[i] = (float)(view->base[i] - (double)bounds->apex[i] + (double)bounds->axis[i] * pull);
	}
	return cone;
}

/* Stores a light with an end as number `at`. */
static void reaching_store(const light_view *view, light_reaching *r, uint32_t at, const stilb_light_bounds *bounds)
{
	const float p[3] = {bounds->sphere.x, bounds->sphere.y, bounds->sphere.z};
	double slack = slack_of(view, p, (double)bounds->sphere.radius);
	light_four clip = affine(view->functions, p);
	r->x[at] = (float)clip.low[0];
	r->y[at] = (float)clip.low[1];
	r->w[at] = (float)clip.high[0];
	r->depth[at] = (float)clip.high[1];
	r->radius[at] = (float)((double)bounds->sphere.radius + slack);
	r->cones[at] = cone_of(view, bounds, slack);
	r->number[at] = at | (r->cones[at].some ? LIGHT_WITH_CONE : 0);
}

/* False if a light with a place cannot reach the view: a quick test, without its cone. */
static bool may_reach(const light_build *build, const stilb_scene_light *light, double reach)
{
	const light_view *view = &build->scratch->view;
	double radius = reach * LIGHT_QUICK_GROWTH;
	return reaches_view(view, light->position, radius + 2.0 * slack_of(view, light->position, radius));
}

/* What the light reaches of the view, but for what ends in `reach`. False: nothing. */
static bool light_reaches(const light_build *build, const stilb_scene_light *light, stilb_light_bounds *bounds)
{
	const light_view *view = &build->scratch->view;
	double reach = (double)INFINITY;
	if (light->use == STILB_SCENE_LIGHT_BAKED)
		return false;
	if (light->kind != STILB_SCENE_LIGHT_DIRECTIONAL) {
		bool endless = light->falloff == STILB_SCENE_LIGHT_PHYSICAL;
		reach = light_reach(light, endless ? build->irradiance : 0.0);
		if (!(reach > 0.0) || !may_reach(build, light, reach))
			return false;
	}
	light_bounds_within(light, reach, bounds);
	if (bounds->cos_angle <= -1.0f || isinf(bounds->sphere.radius))
		return bounds->sphere.radius >= 0.0f;
	const float p[3] = {bounds->sphere.x, bounds->sphere.y, bounds->sphere.z};
	double radius = (double)bounds->sphere.radius;
	return reaches_view(view, p, radius + slack_of(view, p, radius)); /* the cone has made the sphere smaller */
}

/* Sorts the candidates of chunks begin .. end - 1; each chunk's results begin where its candidates do. */
static void light_job_reaching(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.reaching");
	(void)worker;
	const light_build *build = context;
	struct light_scratch *scratch = build->scratch;
	light_reaching *r = &scratch->reaching;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t first = chunk * LIGHT_CHUNK, at = first, everywhere = first;
		uint32_t last = build->count - first < LIGHT_CHUNK ? build->count : first + LIGHT_CHUNK;
		for (uint32_t i = first; i < last; i++) {
			uint32_t index = build->candidates ? build->candidates[i] : i;
			stilb_light_bounds bounds;
			if (!light_reaches(build, &build->lights[index], &bounds))
				continue;
			if (isinf(bounds.sphere.radius)) {
				r->everywhere[everywhere++] = index;
			} else {
				reaching_store(&scratch->view, r, at, &bounds);
				r->index[at++] = index;
			}
		}
		scratch->kernels->slices(&scratch->view.depths, r->depth + first, r->radius + first, at - first,
		                         r->first_slice + first, r->last_slice + first);
		r->chunks[chunk] = (light_found){.count = at - first, .everywhere_count = everywhere - first};
	}
}

stilb_result light_reaching_find(light_build *build)
{
	light_reaching *r = &build->scratch->reaching;
	if (build->count > LIGHT_COUNT_MAX || !reaching_reserve(r, build->count))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights", build->count);
	r->chunk_count = (build->count + LIGHT_CHUNK - 1) / LIGHT_CHUNK;
	light_spread(build, r->chunk_count, light_job_reaching);
	r->count = r->everywhere_count = 0;
	for (uint32_t c = 0; c < r->chunk_count; c++) {
		r->chunks[c].gap = c * LIGHT_CHUNK - r->count;
		r->count += r->chunks[c].count;
		r->everywhere_count += r->chunks[c].everywhere_count;
	}
	return STILB_OK;
}
