#include "gi/integrate/gi_backdrop.h"

#include "gi/gi_vector.h"
#include "gi/trace/gi_ray.h"
#include "profiler/prof.h"
#include "scene/scene_light_shade.h"
#include "shading/shade_light_area.h"

#include <math.h>
#include <stdlib.h>

#define BACKDROP_NEAR 1.6f /* distance from below the models, in their radii, up to which the floor shows all of its */
#define BACKDROP_FAR 7.0f  /* shadow, and from which on none: so it has no horizon */
#define BACKDROP_ABOVE 1e-4f /* height above the floor at which shadow rays begin, in radii */
#define BACKDROP_RAYS 64     /* shadow rays that are traced together */

struct gi_backdrop {
	stilb_scene_backdrop scene; /* map and floor are copies */
	shade_light *lights;        /* [light_count] */
	uint32_t light_count;
	stilb_vec3 sky, ground;
};

/* ---- making ------------------------------------------------------------------------------------------------------ */

static void *backdrop_copy(const void *from, size_t size)
{
	void *copy = stilb_memory_alloc(1, size);
	if (copy)
		memcpy(copy, from, size);
	return copy;
}

stilb_result gi_backdrop_create(const stilb_scene *scene, gi_backdrop **out)
{
	STILB_ASSERT(scene && out);
	const stilb_scene_backdrop *from = &scene->backdrop;
	const stilb_scene_surroundings *around = &scene->surroundings;
	*out = NULL;
	gi_backdrop *backdrop = stilb_memory_alloc(1, sizeof *backdrop);
	if (!backdrop)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a backdrop");
	*backdrop = (gi_backdrop){.scene = *from,
	                          .sky = stilb_vec3_make(around->sky[0], around->sky[1], around->sky[2]),
	                          .ground = stilb_vec3_make(around->ground[0], around->ground[1], around->ground[2])};
	size_t map = sizeof(float[STILB_SCENE_BACKDROP_HEIGHT][STILB_SCENE_BACKDROP_WIDTH][3]);
	backdrop->scene.map = from->map ? backdrop_copy(from->map, map) : NULL;
	backdrop->scene.floor = from->floor ? backdrop_copy(from->floor, sizeof *from->floor) : NULL;
	backdrop->lights = stilb_memory_alloc(scene->light_count, sizeof *backdrop->lights);
	if ((from->map && !backdrop->scene.map) || (from->floor && !backdrop->scene.floor) || !backdrop->lights) {
		gi_backdrop_destroy(backdrop);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a backdrop");
	}
	for (uint32_t i = 0; i < scene->light_count; i++)
		backdrop->lights[backdrop->light_count++] = scene_light_shade(&scene->lights[i]);
	*out = backdrop;
	return STILB_OK;
}

void gi_backdrop_destroy(gi_backdrop *backdrop)
{
	if (!backdrop)
		return;
	free(backdrop->scene.map);
	free(backdrop->scene.floor);
	free(backdrop->lights);
	free(backdrop);
}

uint64_t gi_backdrop_hash(uint64_t hash, const gi_backdrop *backdrop)
{
	const stilb_scene_backdrop *scene = &backdrop->scene;
	if (scene->kind == STILB_SCENE_BACKDROP_SURROUNDINGS)
		return hash;
	uint32_t kind = scene->kind;
	hash = stilb_hash_fnv1a64(hash, &kind, sizeof kind);
	hash = stilb_hash_fnv1a64(hash, scene->color, sizeof scene->color);
	if (scene->map)
		hash = stilb_hash_fnv1a64(hash, scene->map,
		                          sizeof(float[STILB_SCENE_BACKDROP_HEIGHT][STILB_SCENE_BACKDROP_WIDTH][3]));
	return scene->floor ? stilb_hash_fnv1a64(hash, scene->floor, sizeof *scene->floor) : hash;
}

bool gi_backdrop_is_nothing(const gi_backdrop *backdrop)
{
	return backdrop->scene.kind == STILB_SCENE_BACKDROP_NOTHING;
}

/* ---- the map ----------------------------------------------------------------------------------------------------- */

static stilb_vec3 map_texel(const gi_backdrop *backdrop, int x, int y)
{
	int width = STILB_SCENE_BACKDROP_WIDTH, height = STILB_SCENE_BACKDROP_HEIGHT;
	y = y < 0 ? 0 : y >= height ? height - 1 : y;
	const float *texel = backdrop->scene.map + 3 * (size_t)(y * width + (x + width) % width);
	return stilb_vec3_make(texel[0], texel[1], texel[2]);
}

/* Between the middles of four texels, linearly. */
static stilb_vec3 map_at(const gi_backdrop *backdrop, stilb_vec3 direction)
{
	float x = (atan2f(direction[0], -direction[2]) * (0.5f * SHADE_INV_PI) + 0.5f) * STILB_SCENE_BACKDROP_WIDTH - 0.5f;
	float y = acosf(fminf(fmaxf(direction[1], -1.0f), 1.0f)) * SHADE_INV_PI * STILB_SCENE_BACKDROP_HEIGHT - 0.5f;
	float left = floorf(x), top = floorf(y);
	int column = (int)left, row = (int)top;
	float across = x - left, down = y - top;
	stilb_vec3 above =
		map_texel(backdrop, column, row) * (1.0f - across) + map_texel(backdrop, column + 1, row) * across;
	stilb_vec3 below =
		map_texel(backdrop, column, row + 1) * (1.0f - across) + map_texel(backdrop, column + 1, row + 1) * across;
	return above * (1.0f - down) + below * down;
}

/* ---- the floor --------------------------------------------------------------------------------------------------- */

/* The luminance of the irradiance on the floor without the models. */
static float floor_unblocked(const gi_backdrop *backdrop, stilb_vec3 at)
{
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	float sum = shade_luminance(shade_hemisphere_irradiance(1.0f, backdrop->sky, backdrop->ground));
	for (uint32_t i = 0; i < backdrop->light_count; i++) {
		const shade_light *light = &backdrop->lights[i];
		if (shade_light_is_sized(light->kind)) {
			sum += shade_luminance(shade_area_irradiance(*light, at, up));
			continue;
		}
		shade_sun seen = shade_light_at(*light, at);
		sum += fmaxf(seen.direction[1], 0.0f) * shade_luminance(seen.irradiance);
	}
	return sum;
}

/* Where the ray meets the floor, and how much of the shadow it shows there. 0: it does not, or too far away. */
static float floor_meet(const stilb_scene_floor *floor, const gi_ray *ray, stilb_vec3 *at)
{
	stilb_vec3 origin = gi_ray_origin(ray), direction = gi_ray_direction(ray);
	float above = origin[1] - floor->center[1];
	if (!(above > 0.0f && direction[1] < 0.0f))
		return 0.0f;
	*at = origin + direction * (above / -direction[1]);
	(*at)[1] = floor->center[1] + BACKDROP_ABOVE * floor->radius;
	float x = (*at)[0] - floor->center[0], z = (*at)[2] - floor->center[2];
	float far = (sqrtf(x * x + z * z) / floor->radius - BACKDROP_NEAR) / (BACKDROP_FAR - BACKDROP_NEAR);
	far = fminf(fmaxf(far, 0.0f), 1.0f); /* NaN, of a point beyond all floats, becomes 1 */
	return 1.0f - far * far * (3.0f - 2.0f * far);
}

/* Shadow rays that are traced together. */
typedef struct floor_rays {
	gi_ray rays[BACKDROP_RAYS]; /* id: the sample's index */
	float dark[BACKDROP_RAYS];  /* share of the color that is taken off if the ray is blocked */
	uint32_t count;
} floor_rays;

static void floor_ask(const gi_batch *batch, uint32_t i, floor_rays *asked)
{
	const gi_view *view = batch->view;
	const gi_backdrop *backdrop = view->scene->backdrop;
	stilb_vec3 at, up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	float numbers[GI_DIMENSIONS_VERTEX], share = floor_meet(backdrop->scene.floor, &batch->rays[i].ray, &at);
	if (!(share > 0.0f))
		return;
	gi_sample_8(&view->sampler, batch->points[i], GI_DIMENSION_OF(0), numbers);
	stilb_vec2 u = {numbers[GI_DIMENSION_LIGHT], numbers[GI_DIMENSION_LIGHT + 1]};
	float unblocked = floor_unblocked(backdrop, at);
	for (gi_light_group group = 0; group < GI_LIGHT_GROUPS; group++) {
		const gi_lights *lights = gi_view_lights(view);
		gi_light_sample light;
		if (!gi_light_is_asked(lights, group, true) ||
		    !gi_light_sample_at(lights, group, true, at, up, numbers[GI_DIMENSION_CHOICE], u, &light))
			continue;
		float sent = fmaxf(light.direction[1], 0.0f) * shade_luminance(light.radiance) / light.pdf;
		if (!(sent > 0.0f && unblocked > 0.0f))
			continue;
		STILB_ASSERT(asked->count < BACKDROP_RAYS);
		asked->rays[asked->count] = gi_ray_make(at, light.direction, light.distance, numbers[GI_DIMENSION_CHANCE]);
		asked->rays[asked->count].id = i;
		asked->dark[asked->count++] = share * sent / unblocked;
	}
}

static void floor_flush(gi_batch *batch, floor_rays *asked)
{
	const gi_tracer *tracer = &batch->view->scene->tracer;
	stilb_vec3 color = gi_vector(batch->view->scene->backdrop->scene.color);
	tracer->occluded(tracer, asked->rays, asked->count);
	batch->rays_traced += asked->count;
	batch->shadow_rays += asked->count;
	for (uint32_t r = 0; r < asked->count; r++)
		if (asked->rays[r].t_max < 0.0f)
			batch->radiance[asked->rays[r].id] -= color * asked->dark[r];
	asked->count = 0;
}

static void floor_shade(gi_batch *batch)
{
	PROFILE("gi.floor");
	floor_rays asked = {.count = 0};
	for (uint32_t i = 0; i < batch->count; i++) {
		if (gi_is_hit(&batch->rays[i]))
			continue;
		floor_ask(batch, i, &asked);
		if (asked.count + GI_LIGHT_GROUPS > BACKDROP_RAYS)
			floor_flush(batch, &asked);
	}
	floor_flush(batch, &asked);
}

void gi_backdrop_shade(gi_batch *batch)
{
	const gi_backdrop *backdrop = batch->view->scene->backdrop;
	const stilb_gi_settings *settings = &batch->view->settings;
	stilb_scene_backdrop_kind kind = backdrop->scene.kind;
	bool light = settings->only != STILB_GI_ONLY_INDIRECT && settings->integrator != STILB_GI_INTEGRATOR_COLOR &&
	             settings->integrator != STILB_GI_INTEGRATOR_AO && settings->integrator != STILB_GI_INTEGRATOR_CHANNEL;
	if (kind == STILB_SCENE_BACKDROP_SURROUNDINGS || (!light && kind != STILB_SCENE_BACKDROP_NOTHING))
		return;
	const float *c = backdrop->scene.color;
	for (uint32_t i = 0; i < batch->count; i++) {
		if (gi_is_hit(&batch->rays[i]))
			continue;
		if (kind == STILB_SCENE_BACKDROP_MAP)
			batch->radiance[i] = map_at(backdrop, gi_ray_direction(&batch->rays[i].ray));
		else
			batch->radiance[i] =
				kind == STILB_SCENE_BACKDROP_COLOR ? stilb_vec3_make(c[0], c[1], c[2]) : (stilb_vec3){0};
	}
	if (kind == STILB_SCENE_BACKDROP_COLOR && backdrop->scene.floor && !settings->no_shadows)
		floor_shade(batch);
}
