/* Which lights reach a view, and where they are in it. */
#include "light/light_lists.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HALF_SPACE_MAX 1e-4f /* cosines from minus this on are those of flat lights */
#define HALF_SPACE_PULL 2e-5 /* share of the radius: more than cosines of flat lights are below 0 */

void light_reaching_finish(struct light_scratch *scratch)
{
	light_reaching *r = &scratch->reaching;
	free(r->x);
	free(r->first_slice);
	free(r->cones);
	free(r->index);
	free(scratch->everywhere);
	free(scratch->chunk_reaching);
	*r = (light_reaching){0};
	scratch->everywhere = scratch->chunk_reaching = scratch->chunk_everywhere = NULL;
}

static bool reaching_reserve(struct light_scratch *scratch, uint32_t count)
{
	light_reaching *r = &scratch->reaching;
	uint32_t chunks = count / LIGHT_CHUNK + 1;
	if (chunks * LIGHT_CHUNK <= r->capacity)
		return true;
	light_reaching_finish(scratch);
	chunks += chunks / 4;
	size_t room = (size_t)chunks * LIGHT_CHUNK, stride = room + LIGHT_LANES;
	r->x = stilb_memory_alloc(5 * stride, sizeof *r->x);
	r->first_slice = stilb_memory_alloc(2 * stride, sizeof *r->first_slice);
	r->cones = stilb_memory_alloc(room, sizeof *r->cones);
	r->index = stilb_memory_alloc(room, sizeof *r->index);
	scratch->everywhere = stilb_memory_alloc(room, sizeof *scratch->everywhere);
	scratch->chunk_reaching = stilb_memory_alloc(2 * (size_t)chunks, sizeof *scratch->chunk_reaching);
	if (!r->x || !r->first_slice || !r->cones || !r->index || !scratch->everywhere || !scratch->chunk_reaching) {
		light_reaching_finish(scratch);
		return false;
	}
	r->y = r->x + stride;
	r->w = r->y + stride;
	r->depth = r->w + stride;
	r->radius = r->depth + stride;
	r->last_slice = r->first_slice + stride;
	scratch->chunk_everywhere = scratch->chunk_reaching + chunks;
	r->capacity = (uint32_t)room;
	return true;
}

static double affine(const double row[4], const float p[3])
{
	return row[0] * (double)p[0] + row[1] * (double)p[1] + row[2] * (double)p[2] + row[3];
}

/* True if a sphere reaches between the outer planes. */
static bool between(const light_planes *planes, uint32_t count, double across, double w, double radius)
{
	return across * (double)planes->inverse[0] - w * (double)planes->offset[0] >= -radius &&
	       across * (double)planes->inverse[count] - w * (double)planes->offset[count] <= radius;
}

/* The first slice that ends at depth or beyond. */
static uint32_t slice_ending(const light_view *view, float depth)
{
	uint32_t low = 0, high = view->slices - 1;
	while (low < high) {
		uint32_t middle = (low + high) / 2;
		if (view->far_z[middle] < depth)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

/* The last slice that begins at depth or before. */
static uint32_t slice_beginning(const light_view *view, float depth)
{
	uint32_t low = 0, high = view->slices - 1;
	while (low < high) {
		uint32_t middle = (low + high + 1) / 2;
		if (view->near_z[middle] > depth)
			high = middle - 1;
		else
			low = middle;
	}
	return low;
}

static light_cone cone_of(const stilb_light_bounds *bounds, double slack)
{
	light_cone cone = {.some = bounds->cos_angle >= -HALF_SPACE_MAX};
	if (!cone.some)
		return cone;
	double cosine = fmax((double)bounds->cos_angle, 0.0);
	double pull = bounds->cos_angle < 0.0f ? HALF_SPACE_PULL * (double)bounds->sphere.radius : 0.0;
	cone.cosine = (float)cosine;
	cone.sine = (float)sqrt(1.0 - cosine * cosine);
	cone.slack = (float)slack;
	for (int i = 0; i < 3; i++) {
		cone.axis[i] = bounds->axis[i];
		cone.apex[i] = (float)((double)bounds->apex[i] - (double)bounds->axis[i] * pull);
	}
	return cone;
}

/* Stores a light with an end as number `at`. False: it does not reach the view. */
static bool reaching_store(const light_view *view, light_reaching *r, uint32_t at, const stilb_light_bounds *bounds)
{
	const float p[3] = {bounds->sphere.x, bounds->sphere.y, bounds->sphere.z};
	double place = fabs((double)p[0]) + fabs((double)p[1]) + fabs((double)p[2]);
	double slack = LIGHT_RELATIVE * (view->growth * (place + (double)bounds->sphere.radius) + view->reach);
	double radius = (double)bounds->sphere.radius + slack;
	double x = affine(view->clip[0], p), y = affine(view->clip[1], p), w = affine(view->clip[2], p);
	double depth = affine(view->depth, p);
	if (depth < -radius || !between(&view->column_planes, view->columns, x, w, radius) ||
	    !between(&view->row_planes, view->rows, y, w, radius))
		return false;
	r->x[at] = (float)x;
	r->y[at] = (float)y;
	r->w[at] = (float)w;
	r->depth[at] = (float)depth;
	r->radius[at] = (float)radius;
	r->first_slice[at] = (uint8_t)slice_ending(view, (float)(depth - radius));
	r->last_slice[at] = (uint8_t)slice_beginning(view, (float)(depth + radius));
	r->cones[at] = cone_of(bounds, slack);
	return true;
}

/* Sorts the candidates of chunks begin .. end - 1; each chunk's results begin where its candidates do. */
static void light_job_reaching(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.reaching");
	(void)worker;
	const light_build *build = context;
	struct light_scratch *scratch = build->scratch;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t first = chunk * LIGHT_CHUNK, at = first, everywhere = first;
		uint32_t last = build->count - first < LIGHT_CHUNK ? build->count : first + LIGHT_CHUNK;
		for (uint32_t i = first; i < last; i++) {
			uint32_t index = build->candidates ? build->candidates[i] : i;
			const stilb_scene_light *light = &build->lights[index];
			if (light->use == STILB_SCENE_LIGHT_BAKED)
				continue;
			double reach = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL ? 0.0 : light_reach(light, build->irradiance);
			stilb_light_bounds bounds = light_bounds_within(light, reach);
			if (bounds.sphere.radius < 0.0f)
				continue;
			if (isinf(bounds.sphere.radius)) {
				scratch->everywhere[everywhere++] = index;
			} else if (reaching_store(&scratch->view, &scratch->reaching, at, &bounds)) {
				scratch->reaching.index[at++] = index;
			}
		}
		scratch->chunk_reaching[chunk] = at - first;
		scratch->chunk_everywhere[chunk] = everywhere - first;
	}
}

static void move_floats(float *floats, uint32_t to, uint32_t from, uint32_t count)
{
	memmove(floats + to, floats + from, count * sizeof *floats);
}

/* Moves count lights to the end of those that are in place. */
static void reaching_append(light_reaching *r, uint32_t from, uint32_t count)
{
	uint32_t to = r->count;
	r->count += count;
	if (to == from || count == 0)
		return;
	move_floats(r->x, to, from, count);
	move_floats(r->y, to, from, count);
	move_floats(r->w, to, from, count);
	move_floats(r->depth, to, from, count);
	move_floats(r->radius, to, from, count);
	memmove(r->first_slice + to, r->first_slice + from, count);
	memmove(r->last_slice + to, r->last_slice + from, count);
	memmove(r->cones + to, r->cones + from, count * sizeof *r->cones);
	memmove(r->index + to, r->index + from, count * sizeof *r->index);
}

stilb_result light_reaching_find(light_build *build)
{
	struct light_scratch *scratch = build->scratch;
	light_reaching *r = &scratch->reaching;
	uint32_t chunks = (build->count + LIGHT_CHUNK - 1) / LIGHT_CHUNK, everywhere = 0;
	if (!reaching_reserve(scratch, build->count))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights", build->count);
	light_spread(build, chunks, light_job_reaching);
	r->count = 0;
	for (uint32_t chunk = 0; chunk < chunks; chunk++) {
		uint32_t first = chunk * LIGHT_CHUNK;
		reaching_append(r, first, scratch->chunk_reaching[chunk]);
		memmove(scratch->everywhere + everywhere, scratch->everywhere + first,
		        scratch->chunk_everywhere[chunk] * sizeof *scratch->everywhere);
		everywhere += scratch->chunk_everywhere[chunk];
	}
	for (uint32_t i = r->count; i < r->count + LIGHT_LANES; i++) { /* what vectors read beyond them is in no slice */
		r->x[i] = r->y[i] = r->w[i] = r->depth[i] = r->radius[i] = 0.0f;
		r->first_slice[i] = UINT8_MAX;
		r->last_slice[i] = 0;
	}
	build->lists->everywhere_count = everywhere;
	build->lists->light_count = everywhere + r->count;
	return STILB_OK;
}
