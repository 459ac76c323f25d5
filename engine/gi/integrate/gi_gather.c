/* gi_gather: vertex 0 of a path is a point that the caller chose, on a surface that reflects all light evenly; so what
 * the path finds times pi is irradiance. From where its ray ends gi_path_gather goes on. */
#include "gi/gi_gather.h"

#include "gi/gi_settings.h"
#include "gi/gi_vector.h"
#include "gi/integrate/gi_direct.h"
#include "gi/sample/gi_counter.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include "shading/shade_constants.h"

#include <stdlib.h>

static_assert(1 + GI_LIGHT_GROUPS <= STILB_GI_GATHER_FOUND / STILB_GI_GATHER_POINTS, "room for what is found");
static_assert(STILB_GI_GATHER_POINTS <= GI_BATCH, "points are one batch");

/* One thread's memory. */
typedef struct gather_thread {
	gi_surface surfaces[GI_BATCH];
	gi_point points[GI_BATCH];
	gi_ray_hit rays[GI_BATCH];
	gi_direct_left left[GI_BATCH];
	uint32_t ray_of[GI_BATCH]; /* index of the point */
	stilb_vec3 radiance[GI_BATCH], factor[GI_BATCH];
	gi_ray shadows[GI_LIGHT_GROUPS * GI_BATCH]; /* id: index of the point */
	stilb_vec3 direct[GI_LIGHT_GROUPS * GI_BATCH];
	void *scratch;           /* gi_integrator_path.scratch_size bytes */
	_Atomic uint64_t traced; /* only this thread adds; relaxed: for display */
} __attribute__((aligned(STILB_CACHE_LINE))) gather_thread;

struct stilb_gi_gather {
	gi_view view;
	uint32_t thread_count;
	gather_thread *threads; /* [thread_count] */
};

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result stilb_gi_gather_create(const stilb_gi_scene *scene, const stilb_gi_settings *settings, uint32_t threads,
                                    stilb_gi_gather **out)
{
	STILB_ASSERT(scene && settings && threads >= 1 && out);
	*out = NULL;
	stilb_gi_settings checked = *settings; /* but for the camera, which nobody looks through */
	checked.camera = (stilb_scene_camera){.fov_y = 1.0f, .near_z = 0.1f, .far_z = 1.0f};
	stilb_result result = gi_settings_check(&checked);
	if (result != STILB_OK)
		return result;
	stilb_gi_gather *gather = calloc(1, sizeof *gather);
	if (gather)
		gather->threads = stilb_memory_alloc(threads, sizeof *gather->threads);
	for (uint32_t i = 0; gather && gather->threads && i < threads; i++) {
		gather->threads[i].traced = 0;
		gather->threads[i].scratch = stilb_memory_alloc(1, gi_integrator_path.scratch_size);
		if (!gather->threads[i].scratch)
			break;
		gather->thread_count++;
	}
	if (!gather || gather->thread_count < threads) {
		stilb_gi_gather_destroy(gather);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u threads that gather light", threads);
	}
	gather->view.scene = scene;
	gather->view.settings = *settings;
	gather->view.sampler = gi_sampler_make(settings->sampler, settings->seed, settings->samples);
	*out = gather;
	return STILB_OK;
}

void stilb_gi_gather_destroy(stilb_gi_gather *gather)
{
	if (!gather)
		return;
	for (uint32_t i = 0; i < gather->thread_count; i++)
		free(gather->threads[i].scratch);
	free(gather->threads);
	free(gather);
}

uint64_t stilb_gi_gather_rays(const stilb_gi_gather *gather)
{
	uint64_t sum = 0;
	for (uint32_t i = 0; i < gather->thread_count; i++)
		sum += atomic_load_explicit(&gather->threads[i].traced, memory_order_relaxed); /* relaxed: gather_thread */
	return sum;
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

/* The point as a white surface. */
static void surface_of(const stilb_gi_scene *scene, const stilb_gi_gather_point *point, gi_surface *surface)
{
	STILB_ASSERT(point->part < scene->part_count);
	const gi_part *part = &scene->parts[point->part];
	stilb_vec3 a = gi_vector(point->corners[0]), ab = gi_vector(point->corners[1]) - a,
			   ac = gi_vector(point->corners[2]) - a;
	stilb_vec3 cross = stilb_vec3_cross(ab, ac);
	float length = gi_length(cross);
	*surface = (gi_surface){.position = a + (ab * point->u + ac * point->v),
	                        .geometric = cross * (1.0f / length),
	                        .normal = gi_vector(point->normal),
	                        .diffuse = stilb_vec3_make(1.0f, 1.0f, 1.0f),
	                        .roughness = 1.0f,
	                        .error = gi_triangle_error(point->corners[0], point->corners[1], point->corners[2]),
	                        .part = point->part,
	                        .front = true};
	if (part->instance)
		surface->error = 2.0f * surface->error + gi_transform_error(part, surface->position);
}

static void points_begin(const stilb_gi_gather *gather, gather_thread *thread, const stilb_gi_gather_point *points,
                         uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		surface_of(gather->view.scene, &points[i], &thread->surfaces[i]);
		thread->points[i] = gi_sampler_point(&gather->view.sampler, points[i].x, points[i].y, points[i].sample);
	}
}

static stilb_gi_gathered found_make(stilb_vec3 radiance, stilb_vec3 direction, uint32_t point)
{
	stilb_vec3 irradiance = radiance * SHADE_PI;
	return (stilb_gi_gathered){.irradiance = {irradiance[0], irradiance[1], irradiance[2]},
	                           .direction = {direction[0], direction[1], direction[2]},
	                           .distance = INFINITY,
	                           .point = point};
}

/* ---- light ------------------------------------------------------------------------------------------------------- */

/* Chooses lights and a ray at each point. Returns how many shadow rays there are; *rays: how many others. */
static uint32_t points_shade(const stilb_gi_gather *gather, gather_thread *thread, uint32_t count, uint32_t *rays)
{
	PROFILE("gi.shade");
	const gi_view *view = &gather->view;
	bool direct = view->settings.only != STILB_GI_ONLY_INDIRECT && view->settings.depth > 0;
	uint32_t shadows = 0;
	*rays = 0;
	for (uint32_t i = 0; i < count; i++) {
		gi_surface *surface = &thread->surfaces[i];
		float numbers[8];
		gi_bsdf bsdf;
		gi_bsdf_sample next;
		gi_sample_8(&view->sampler, thread->points[i], GI_DIMENSION_OF(0), numbers);
		gi_bsdf_make(&view->settings.model, surface, surface->normal, &bsdf);
		stilb_vec3 origin = gi_surface_ray_origin(surface, surface->geometric);
		if (direct) {
			uint32_t asked = gi_direct_ask(view, &bsdf, surface->part, origin, numbers, GI_DIRECT_WITH_RAY,
			                               &thread->shadows[shadows], &thread->direct[shadows]);
			for (uint32_t k = 0; k < asked; k++)
				thread->shadows[shadows++].id = i;
		}
		stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
		if (!gi_bsdf_sample_direction(&bsdf, numbers[GI_DIMENSION_LOBE], u, &next))
			continue;
		thread->left[*rays] = gi_direct_leave(&bsdf, &next, GI_DIRECT_WITH_RAY);
		thread->rays[*rays] = gi_ray_hit_make_by(origin, next.direction, numbers[GI_DIMENSION_CHANCE]);
		thread->rays[*rays].ray.id = surface->part;
		thread->ray_of[(*rays)++] = i;
	}
	return shadows;
}

static uint32_t shadows_find(const stilb_gi_gather *gather, gather_thread *thread, uint32_t count,
                             stilb_gi_gathered *found)
{
	PROFILE("gi.shadow");
	uint32_t n = 0;
	gi_through_occluded(gather->view.scene, thread->shadows, thread->direct, count);
	for (uint32_t s = 0; s < count; s++)
		if (thread->shadows[s].t_max >= 0.0f) {
			found[n] = found_make(thread->direct[s], gi_ray_direction(&thread->shadows[s]), thread->shadows[s].id);
			found[n++].asked = true;
		}
	return n;
}

/* What the points' rays meet: its emission, as far as it counts, goes to radiance. */
static void rays_trace(const stilb_gi_gather *gather, gather_thread *thread, uint32_t count, uint64_t *traced)
{
	PROFILE("gi.bounce");
	const gi_view *view = &gather->view;
	bool direct = view->settings.only != STILB_GI_ONLY_INDIRECT && view->settings.depth > 0;
	for (uint32_t i = 0; i < count; i++) {
		gi_ray_hit *ray = &thread->rays[i];
		const gi_direct_left *left = &thread->left[i];
		bool apart = view->scene->flagged && left->pdf > 0.0f; /* rays towards lights may end elsewhere */
		stilb_vec3 emitted = {0};
		if (direct && apart)
			emitted = gi_direct_find(view, left, ray->ray.id, ray, traced);
		thread->factor[i] = gi_through_intersect(view->scene, ray, traced);
		if (direct && !apart) {
			gi_surface surface;
			bool hit = gi_is_hit(ray);
			if (hit)
				gi_surface_at(view->scene, ray, &surface);
			emitted = thread->factor[i] * gi_direct_found(view, left, ray, hit ? &surface : NULL);
		}
		thread->radiance[i] = emitted;
	}
	*traced += count;
}

uint32_t stilb_gi_gather_light(stilb_gi_gather *gather, uint32_t thread_index, const stilb_gi_gather_point *points,
                               uint32_t count, stilb_gi_gathered *found)
{
	STILB_ASSERT(thread_index < gather->thread_count && count <= STILB_GI_GATHER_POINTS);
	gather_thread *thread = &gather->threads[thread_index];
	uint32_t depth = gather->view.settings.depth, rays;
	points_begin(gather, thread, points, count);
	uint32_t shadows = points_shade(gather, thread, count, &rays), n = shadows_find(gather, thread, shadows, found);
	uint64_t traced = shadows;
	rays_trace(gather, thread, rays, &traced);
	if (depth > 1) {
		stilb_vec3 reflected[GI_BATCH];
		gi_point paths[GI_BATCH];
		for (uint32_t i = 0; i < rays; i++)
			paths[i] = thread->points[thread->ray_of[i]];
		gi_batch batch = {.view = &gather->view,
		                  .worker = thread_index,
		                  .count = rays,
		                  .points = paths,
		                  .rays = thread->rays,
		                  .radiance = reflected,
		                  .scratch = thread->scratch};
		gi_path_gather(&batch, 1, depth - 1);
		for (uint32_t i = 0; i < rays; i++)
			thread->radiance[i] += thread->factor[i] * reflected[i];
		traced += batch.rays_traced;
	}
	for (uint32_t i = 0; i < rays; i++) {
		const gi_ray_hit *ray = &thread->rays[i];
		stilb_vec3 direction = gi_ray_direction(&ray->ray);
		found[n] = found_make(thread->radiance[i], direction, thread->ray_of[i]);
		found[n].distance = gi_is_hit(ray) ? ray->ray.t_max : INFINITY;
		found[n++].back = gi_is_hit(ray) && stilb_vec3_dot(gi_vector(ray->hit.normal), direction) > 0.0f;
	}
	gi_counter_add(&thread->traced, traced);
	return n;
}

/* ---- openness ---------------------------------------------------------------------------------------------------- */

void stilb_gi_gather_open(stilb_gi_gather *gather, uint32_t thread_index, const stilb_gi_gather_point *points,
                          uint32_t count, float distance, float *open)
{
	STILB_ASSERT(thread_index < gather->thread_count && count <= STILB_GI_GATHER_POINTS && distance > 0.0f);
	PROFILE("gi.shadow");
	gather_thread *thread = &gather->threads[thread_index];
	const gi_view *view = &gather->view;
	uint32_t rays = 0;
	points_begin(gather, thread, points, count);
	for (uint32_t i = 0; i < count; i++) {
		const gi_surface *surface = &thread->surfaces[i];
		float numbers[8];
		open[i] = 0.0f;
		gi_sample_8(&view->sampler, thread->points[i], GI_DIMENSION_OF(0), numbers);
		shade_sample chosen =
			shade_sample_cosine((stilb_vec2){numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]});
		stilb_vec3 direction = shade_frame_to_world(shade_frame_from_normal(surface->normal), chosen.direction);
		if (!(stilb_vec3_dot(direction, surface->geometric) > 0.0f))
			continue;
		thread->shadows[rays] =
			gi_ray_make_of(view->scene->parts[surface->part].lit_by, gi_surface_ray_origin(surface, direction),
		                   direction, distance, numbers[GI_DIMENSION_CHANCE]);
		thread->shadows[rays++].id = i;
	}
	view->scene->tracer.occluded(&view->scene->tracer, thread->shadows, rays);
	for (uint32_t s = 0; s < rays; s++)
		open[thread->shadows[s].id] = thread->shadows[s].t_max >= 0.0f ? 1.0f : 0.0f;
	gi_counter_add(&thread->traced, rays);
}
