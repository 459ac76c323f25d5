/*
 * gi_path: one path for each sample, to any depth, with next-event estimation and multiple importance sampling at
 * every vertex and Russian roulette from the third bounce.
 *
 * Paths run in waves: all paths of a batch advance together, one bounce at a time. The shadow rays of a bounce are
 * traced together, in packets, which takes less than half the time in the Cornell box; closest-hit rays are traced one
 * by one, since packets of incoherent rays gain nothing. A path reads and writes its own state only, so its result does
 * not depend on which paths run with it.
 *
 * Depth. At most `depth` reflections: 0 leaves what is seen of the lights themselves, 1 adds light that is reflected
 * once, ...
 */
#include "gi/integrate/gi_direct.h"
#include "gi/lanes/gi_lanes.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include "base/glsl_types.h"

#define VERTICES 32       /* that are shaded together: their data fits into the first-level cache */
#define CACHED 16384      /* bytes of a scene's triangles and vertices that stay in the first-level cache */
#define ROULETTE_BOUNCE 3 /* first bounce at which a path may end by Russian roulette */
/* The probability of surviving is this times the square root of the throughput; measured in eight scenes (gi.md). */
#define ROULETTE_SCALE 1.5f

/* The state of a path; its ray is in path_wave.rays. */
typedef struct path_state {
	stilb_vec3 throughput;
	stilb_vec3 normal; /* of the surface that the ray left, on which the light's density depends */
	gi_point point;
	float pdf;     /* density of the ray's direction; 0: no light was sampled there, and emission counts in full */
	uint32_t slot; /* index in path_wave.radiance, unique in the wave */
} path_state;

/* Paths that run together. When paths end the others move up, so that the arrays stay dense and in order. */
typedef struct path_wave {
	const gi_view *view;
	uint32_t vertex; /* number of the vertex where the rays arrive, for random numbers */
	uint32_t bounce; /* reflections so far */
	uint32_t depth;  /* reflections at most */
	/* Light counts only if it is reflected at least so often on its way to the camera: direct_from is for lights that
	 * are sampled, emission_from for emitters that the path's ray hits. */
	uint32_t direct_from, emission_from;
	uint32_t count, shadow_count;
	path_state *paths;    /* [count] */
	gi_ray_hit *rays;     /* [count] id: part of the surface that the ray left */
	gi_ray *shadows;      /* [shadow_count] id: slot of the path */
	stilb_vec3 *direct;   /* [shadow_count] radiance to add if nothing is on the shadow ray */
	stilb_vec3 *radiance; /* [slots] sum of each path, by path_state.slot */
	uint64_t rays_traced, shadow_rays;
} path_wave;

/* The end of a path's ray, while it is shaded. */
typedef struct path_vertex {
	gi_surface surface;
	gi_bsdf bsdf;
	stilb_vec3 origin; /* of rays that leave the surface */
	float numbers[8];
	uint32_t path; /* index in path_wave.paths */
	bool matt;     /* lanes choose its next ray */
	/* The light that a matt vertex has chosen, GI_LIGHT_LEAF: none; the probability of that, and whether lanes ask it,
	 * as it is a rectangle. */
	uint32_t light;
	float chance;
	bool rectangle;
} path_vertex;

/* Vertices whose lanes are computed together. */
typedef struct path_group {
	path_vertex *vertices; /* [count] */
	uint32_t count;        /* 1 .. GI_LANES */
	gi_lanes lanes;
} path_group;

/* ---- one vertex -------------------------------------------------------------------------------------------------- */

/* Russian roulette. False: the path ends; true: its throughput is divided by the probability of surviving. Unless the
 * settings name that probability, it is taken from the square root of the throughput: the throughput itself would end
 * too many paths at the first chance. */
static bool roulette(const gi_view *view, path_state *path, float u)
{
	STILB_ASSERT(u >= 0.0f && u < 1.0f);
	float survival = view->settings.roulette;
	if (survival == 0.0f) {
		stilb_vec3 t = path->throughput;
		survival = glsl_min_1(ROULETTE_SCALE * sqrtf(glsl_max_1(glsl_max_1(t[0], t[1]), t[2])), 1.0f);
	}
	STILB_ASSERT(!(survival < 0.0f) && !(survival > 1.0f));
	if (u >= survival)
		return false;
	path->throughput *= 1.0f / survival;
	return true;
}

static bool reflects(const gi_surface *surface)
{
	stilb_vec3 all = surface->diffuse + surface->specular;
	return all[0] + all[1] + all[2] > 0.0f || surface->layered;
}

/* Adds the light emitted where path i's ray ends to the path's radiance, and fills surface. False: the path ends
 * there. */
static bool path_found(const path_wave *wave, uint32_t i, gi_surface *surface)
{
	STILB_ASSERT(i < wave->count && wave->paths[i].slot < GI_BATCH);
	const path_state *path = &wave->paths[i];
	const gi_ray_hit *ray = &wave->rays[i];
	bool hit = gi_is_hit(ray);
	if (hit)
		gi_surface_at(wave->view->scene, ray, surface);
	bool found = wave->view->scene->flagged && path->pdf > 0.0f; /* by wave_find */
	if (wave->bounce >= wave->emission_from && !found) {
		gi_direct_left left = {path->normal, path->pdf, GI_DIRECT_WITH_RAY};
		wave->radiance[path->slot] += path->throughput * gi_direct_found(wave->view, &left, ray, hit ? surface : NULL);
	}
	if (hit && wave->vertex == 0 && wave->emission_from == 0)
		wave->radiance[path->slot] += surface->unlit;
	return hit && wave->bounce < wave->depth && reflects(surface);
}

/* Samples lights and adds their shadow rays to the wave. */
static void path_ask_lights(path_wave *wave, const path_state *path, const path_vertex *vertex)
{
	STILB_ASSERT(wave->shadow_count + GI_LIGHT_GROUPS <= GI_LIGHT_GROUPS * GI_BATCH);
	gi_ray *shadows = &wave->shadows[wave->shadow_count];
	stilb_vec3 *direct = &wave->direct[wave->shadow_count];
	uint32_t count = gi_direct_ask(wave->view, &vertex->bsdf, vertex->surface.part, vertex->origin, vertex->numbers,
	                               GI_DIRECT_WITH_RAY, shadows, direct);
	for (uint32_t i = 0; i < count; i++) {
		direct[i] *= path->throughput;
		shadows[i].id = path->slot;
	}
	wave->shadow_count += count;
}

/* Chooses the path's next ray. False: the path ends here; the shadow ray that it has added at this vertex is still
 * traced. */
static bool path_go_on(const path_wave *wave, const path_vertex *vertex, path_state *path, gi_ray_hit *ray)
{
	const float *numbers = vertex->numbers;
	gi_bsdf_sample next;
	stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	if (!gi_bsdf_sample_direction(&vertex->bsdf, numbers[GI_DIMENSION_LOBE], u, &next))
		return false;
	path->throughput *= next.weight;
	if (wave->bounce + 1 >= ROULETTE_BOUNCE && !roulette(wave->view, path, numbers[GI_DIMENSION_ROULETTE]))
		return false;
	gi_direct_left left = gi_direct_leave(&vertex->bsdf, &next, GI_DIRECT_WITH_RAY);
	path->pdf = left.pdf;
	path->normal = left.normal;
	*ray = gi_ray_hit_make_by(gi_bsdf_origin(&vertex->bsdf, vertex->origin, next.direction), next.direction,
	                          numbers[GI_DIMENSION_CHANCE]);
	ray->ray.id = vertex->surface.part;
	return true;
}

/* ---- vertices by lanes ------------------------------------------------------------------------------------------- */

/* As path_ask_lights, of a matt vertex that has asked one light. light: direction to it, and in [3] t_max of the shadow
 * ray; weight: gi_lanes.weight. */
static void path_lit(path_wave *wave, const path_state *path, const path_vertex *vertex, stilb_vec3 origin,
                     stilb_vec4 light, stilb_vec3 radiance, float weight)
{
	STILB_ASSERT(wave->shadow_count < GI_LIGHT_GROUPS * GI_BATCH);
	stilb_vec3 sent = vertex->surface.diffuse * radiance * weight;
	if (!(sent[0] + sent[1] + sent[2] > 0.0f))
		return;
	gi_ray *shadow = &wave->shadows[wave->shadow_count];
	*shadow = gi_ray_make(origin, light, light[3], vertex->numbers[GI_DIMENSION_CHANCE]);
	shadow->id = path->slot;
	wave->direct[wave->shadow_count++] = sent * path->throughput;
}

/* As path_lit, of a sample of a light that no lane has weighed. */
static void path_lit_by(path_wave *wave, const path_state *path, const path_vertex *vertex, stilb_vec3 origin,
                        const gi_light_sample *light)
{
	float cosine = stilb_vec3_dot(vertex->surface.normal, light->direction);
	if (!(cosine > 0.0f) || !(stilb_vec3_dot(vertex->surface.geometric, light->direction) > 0.0f))
		return;
	float ratio = cosine * SHADE_INV_PI / light->pdf; /* the next ray has the density cosine / pi */
	stilb_vec4 towards = light->direction;
	towards[3] = light->distance;
	path_lit(wave, path, vertex, origin, towards, light->radiance,
	         light->delta ? ratio : ratio * gi_direct_weight(light->pdf, cosine * SHADE_INV_PI));
}

/* Asks a matt vertex's lights but for a rectangle. */
static void path_ask_others(path_wave *wave, const path_state *path, const path_vertex *vertex, stilb_vec3 origin)
{
	const gi_lights *lights = gi_view_lights(wave->view);
	const float *numbers = vertex->numbers;
	stilb_vec2 u = {numbers[GI_DIMENSION_LIGHT], numbers[GI_DIMENSION_LIGHT + 1]};
	gi_light_sample light;
	if (!vertex->rectangle && vertex->light != GI_LIGHT_LEAF &&
	    gi_light_sample_chosen(lights, vertex->light, origin, u, &light)) {
		light.pdf *= vertex->chance;
		path_lit_by(wave, path, vertex, origin, &light);
	}
	for (gi_light_group group = GI_LIGHT_PLACED + 1; group < GI_LIGHT_GROUPS; group++)
		if (gi_light_is_asked(lights, group, false) &&
		    gi_light_sample_at(lights, group, false, origin, vertex->surface.normal, numbers[GI_DIMENSION_CHOICE], u,
		                       &light))
			path_lit_by(wave, path, vertex, origin, &light);
}

/* As path_go_on, of a matt vertex. */
static bool path_go_on_by_lane(const path_wave *wave, const path_group *group, uint32_t lane, path_state *path,
                               gi_ray_hit *ray)
{
	const path_vertex *vertex = &group->vertices[lane];
	stilb_vec4 next = group->lanes.next[lane];
	if (!(next[3] > 0.0f))
		return false;
	path->throughput *= vertex->surface.diffuse;
	if (wave->bounce + 1 >= ROULETTE_BOUNCE && !roulette(wave->view, path, vertex->numbers[GI_DIMENSION_ROULETTE]))
		return false;
	path->pdf = next[3];
	path->normal = vertex->surface.normal;
	*ray = gi_ray_hit_make_by(group->lanes.origin[lane], next, vertex->numbers[GI_DIMENSION_CHANCE]);
	ray->ray.id = vertex->surface.part;
	return true;
}

/* Chooses directions and origins of the group's matt vertices. */
static void group_leave(const gi_view *view, path_group *group)
{
	bool any = false;
	for (uint32_t k = 0; k < GI_LANES; k++) {
		path_vertex *vertex = &group->vertices[k < group->count ? k : 0];
		vertex->matt = gi_bsdf_is_matt(&view->settings.model, &vertex->surface);
		group->lanes.surfaces[k] = &vertex->surface;
		group->lanes.numbers[k] = vertex->numbers;
		any |= vertex->matt;
	}
	if (any)
		view->scene->lanes->leave(&group->lanes);
}

/* Chooses lights for the group's matt vertices, and asks those that are rectangles. */
static void group_ask(const gi_view *view, path_group *group)
{
	const gi_lights *lights = gi_view_lights(view);
	gi_lanes *lanes = &group->lanes;
	const gi_light_shape *any = NULL;
	bool placed = gi_light_is_asked(lights, GI_LIGHT_PLACED, false);
	for (uint32_t k = 0; k < GI_LANES; k++) {
		lanes->shapes[k] = NULL;
		lanes->chance[k] = 0.0f;
		if (k >= group->count)
			continue;
		path_vertex *vertex = &group->vertices[k];
		vertex->light = GI_LIGHT_LEAF;
		vertex->rectangle = false;
		if (!placed || !vertex->matt)
			continue;
		vertex->light = gi_light_choose(lights, lanes->origin[k], vertex->surface.normal,
		                                vertex->numbers[GI_DIMENSION_CHOICE], &vertex->chance);
		const gi_light_shape *rectangle = gi_light_rectangle(lights, vertex->light);
		STILB_ASSERT(!rectangle || !rectangle->unmet);
		vertex->rectangle = rectangle;
		if (rectangle) {
			any = lanes->shapes[k] = rectangle;
			lanes->chance[k] = vertex->chance;
		}
	}
	if (!any)
		return;
	for (uint32_t k = 0; k < GI_LANES; k++)
		lanes->shapes[k] = lanes->shapes[k] ? lanes->shapes[k] : any;
	view->scene->lanes->ask(lanes);
}

/* Adds shadow rays of the group's vertices to the wave, and makes the BSDFs that its lanes do without. */
static void group_light(path_wave *wave, path_group *group)
{
	const gi_view *view = wave->view;
	const gi_lanes *lanes = &group->lanes;
	bool ask = wave->bounce + 1 >= wave->direct_from, matt_ask = ask && !view->scene->flagged;
	if (matt_ask)
		group_ask(view, group);
	for (uint32_t k = 0; k < group->count; k++) {
		path_vertex *vertex = &group->vertices[k];
		const path_state *path = &wave->paths[vertex->path];
		if (vertex->matt && matt_ask) {
			if (vertex->rectangle)
				path_lit(wave, path, vertex, lanes->origin[k], lanes->light[k], lanes->shapes[k]->emission,
				         lanes->weight[k]);
			path_ask_others(wave, path, vertex, lanes->origin[k]);
		}
		if (vertex->matt && (matt_ask || !ask))
			continue;
		stilb_vec3 to_viewer = -gi_ray_direction(&wave->rays[vertex->path].ray);
		gi_bsdf_make(&view->settings.model, &vertex->surface, to_viewer, &vertex->bsdf);
		vertex->origin = gi_surface_ray_origin(&vertex->surface, vertex->surface.geometric);
		if (ask)
			path_ask_lights(wave, path, vertex);
	}
}

/* Moves paths that continue to index `kept` and following; returns the index behind the last of these. */
static uint32_t group_go_on(path_wave *wave, const path_group *group, uint32_t kept)
{
	for (uint32_t k = 0; k < group->count; k++) {
		const path_vertex *vertex = &group->vertices[k];
		path_state *path = &wave->paths[kept];
		gi_ray_hit *ray = &wave->rays[kept];
		*path = wave->paths[vertex->path];
		kept += vertex->matt ? path_go_on_by_lane(wave, group, k, path, ray) : path_go_on(wave, vertex, path, ray);
	}
	return kept;
}

/* ---- waves ------------------------------------------------------------------------------------------------------- */

/* Shades paths first .. first + count - 1, each stage for all of them before the next, so that one vertex's
 * arithmetic hides another's memory latency. Paths that continue are moved to index `kept` and following; returns the
 * index behind the last of these. */
static uint32_t wave_shade_some(path_wave *wave, uint32_t first, uint32_t count, uint32_t kept)
{
	STILB_ASSERT(count <= VERTICES && first + count <= wave->count);
	STILB_ASSERT(kept <= first && "a path is not overwritten before it is shaded");
	const gi_view *view = wave->view;
	path_vertex vertices[VERTICES];
	uint32_t live = 0;
	for (uint32_t i = first; i < first + count; i++) {
		vertices[live].path = i;
		live += path_found(wave, i, &vertices[live].surface);
	}
	for (uint32_t k = 0; k < live; k++)
		gi_sample_8(&view->sampler, wave->paths[vertices[k].path].point, GI_DIMENSION_OF(wave->vertex),
		            vertices[k].numbers);
	for (uint32_t k = 0; k < live; k += GI_LANES) {
		path_group group; /* not cleared: lanes are large */
		group.vertices = &vertices[k];
		group.count = live - k < GI_LANES ? live - k : GI_LANES;
		group_leave(view, &group);
		group_light(wave, &group);
		kept = group_go_on(wave, &group, kept);
	}
	return kept;
}

/* In a large scene the triangle and vertices of a hit are rarely in a cache when it is shaded. So they are prefetched
 * while other paths are shaded: triangles first, then, when these have arrived, their vertices. Always inline: gcc
 * removes a call of a function that only prefetches, as it takes it for one without effect. */
static inline __attribute__((always_inline)) void wave_fetch_triangles(const path_wave *wave, uint32_t first)
{
	for (uint32_t i = first; i < first + VERTICES && i < wave->count; i++) {
		const gi_ray_hit *ray = &wave->rays[i];
		if (gi_is_hit(ray))
			__builtin_prefetch(&wave->view->scene->parts[ray->hit.part].triangles[ray->hit.triangle]);
	}
}

static inline __attribute__((always_inline)) void wave_fetch_vertices(const path_wave *wave, uint32_t first)
{
	for (uint32_t i = first; i < first + VERTICES && i < wave->count; i++) {
		const gi_ray_hit *ray = &wave->rays[i];
		if (!gi_is_hit(ray))
			continue;
		const gi_part *part = &wave->view->scene->parts[ray->hit.part];
		for (int k = 0; k < 3; k++)
			__builtin_prefetch(&part->vertices[part->triangles[ray->hit.triangle].vertex[k]]);
	}
}

static void wave_shade(path_wave *wave)
{
	PROFILE("gi.shade");
	uint32_t kept = 0;
	bool large = wave->view->scene->own_bytes > CACHED;
	if (large) {
		wave_fetch_triangles(wave, 0);
		wave_fetch_triangles(wave, VERTICES);
		wave_fetch_vertices(wave, 0);
	}
	for (uint32_t first = 0; first < wave->count; first += VERTICES) {
		uint32_t rest = wave->count - first;
		if (large) {
			wave_fetch_triangles(wave, first + 2 * VERTICES);
			wave_fetch_vertices(wave, first + VERTICES);
		}
		kept = wave_shade_some(wave, first, rest < VERTICES ? rest : VERTICES, kept);
	}
	wave->count = kept;
}

static void wave_shadows(path_wave *wave)
{
	PROFILE("gi.shadow");
	gi_through_occluded(wave->view->scene, wave->shadows, wave->direct, wave->shadow_count);
	for (uint32_t s = 0; s < wave->shadow_count; s++)
		if (wave->shadows[s].t_max >= 0.0f)
			wave->radiance[wave->shadows[s].id] += wave->direct[s];
	wave->rays_traced += wave->shadow_count;
	wave->shadow_rays += wave->shadow_count;
	wave->shadow_count = 0;
}

/* What glass between two vertices takes from the paths' light. Not inlined: scenes without glass do not come here. */
static __attribute__((noinline)) void wave_through(path_wave *wave)
{
	for (uint32_t i = 0; i < wave->count; i++)
		wave->paths[i].throughput *= gi_through(wave->view->scene, &wave->rays[i], &wave->rays_traced);
}

/* Adds the light that the paths' next rays would find, were they rays towards lights. Only in scenes where these differ
 * from rays that look. */
static __attribute__((noinline)) void wave_find(path_wave *wave)
{
	for (uint32_t i = 0; i < wave->count; i++) {
		const path_state *path = &wave->paths[i];
		gi_direct_left left = {path->normal, path->pdf, GI_DIRECT_WITH_RAY};
		if (path->pdf > 0.0f)
			wave->radiance[path->slot] += path->throughput * gi_direct_find(wave->view, &left, wave->rays[i].ray.id,
			                                                                &wave->rays[i], &wave->rays_traced);
	}
}

static void wave_intersect(path_wave *wave)
{
	PROFILE("gi.bounce");
	if (wave->view->scene->flagged && wave->bounce + 1 >= wave->emission_from)
		wave_find(wave);
	const gi_tracer *tracer = &wave->view->scene->tracer;
	for (uint32_t i = 0; i < wave->count; i++)
		tracer->intersect(tracer, &wave->rays[i]);
	wave->rays_traced += wave->count;
	if (wave->view->scene->passes)
		wave_through(wave);
}

/* Runs until every path has ended. The rays are traced already. */
static void wave_run(path_wave *wave)
{
	STILB_ASSERT(wave->shadow_count == 0);
	for (;;) {
		wave_shade(wave);
		wave_shadows(wave);
		if (wave->count == 0)
			return;
		wave_intersect(wave);
		wave->vertex++;
		wave->bounce++;
	}
}

/* ---- the integrators --------------------------------------------------------------------------------------------- */

typedef struct path_scratch {
	gi_ray_hit rays[GI_BATCH];
	path_state paths[GI_BATCH];
	gi_ray shadows[GI_LIGHT_GROUPS * GI_BATCH];
	stilb_vec3 direct[GI_LIGHT_GROUPS * GI_BATCH];
	stilb_vec3 radiance[GI_BATCH]; /* for split */
} path_scratch;

static path_wave wave_begin(gi_batch *batch)
{
	STILB_ASSERT(batch->scratch && (uintptr_t)batch->scratch % STILB_CACHE_LINE == 0);
	const stilb_gi_settings *settings = &batch->view->settings;
	path_scratch *scratch = batch->scratch;
	bool indirect = settings->only == STILB_GI_ONLY_INDIRECT;
	return (path_wave){.view = batch->view,
	                   .depth = settings->depth,
	                   .direct_from = indirect ? 2 : 1,
	                   .emission_from = indirect ? 2 : 0,
	                   .paths = scratch->paths,
	                   .rays = scratch->rays,
	                   .shadows = scratch->shadows,
	                   .direct = scratch->direct,
	                   .radiance = batch->radiance};
}

/* Adds a path with this ray, whose slot is its index in the wave. */
static void wave_add(path_wave *wave, const gi_ray_hit *ray, gi_point point)
{
	STILB_ASSERT(wave->count < GI_BATCH);
	uint32_t slot = wave->count++;
	wave->radiance[slot] = (stilb_vec3){0};
	wave->rays[slot] = *ray;
	wave->paths[slot] = (path_state){.throughput = stilb_vec3_make(1.0f, 1.0f, 1.0f), .point = point, .slot = slot};
}

static void wave_end(const path_wave *wave, gi_batch *counters)
{
	counters->rays_traced += wave->rays_traced;
	counters->shadow_rays += wave->shadow_rays;
}

static void path_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->count <= GI_BATCH);
	path_wave wave = wave_begin(batch);
	for (uint32_t i = 0; i < batch->count; i++)
		wave_add(&wave, &batch->rays[i], batch->points[i]);
	wave_run(&wave);
	wave_end(&wave, batch);
}

const gi_integrator gi_integrator_path = {.shade = path_shade, .scratch_size = sizeof(path_scratch)};

/* The N paths of a sample share the camera ray's hit; their random numbers are N stratified points branched off the
 * sample's. Each path samples a light of its own at the first hit, too. */
static void split_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->count <= GI_BATCH && batch->view->settings.rays >= 1);
	path_scratch *scratch = batch->scratch;
	const gi_view *view = batch->view;
	uint32_t branches = view->settings.rays;
	for (uint32_t i = 0; i < batch->count; i++)
		batch->radiance[i] = (stilb_vec3){0};
	for (uint64_t first = 0, end = (uint64_t)batch->count * branches; first < end; first += GI_BATCH) {
		path_wave wave = wave_begin(batch);
		uint32_t count = end - first < GI_BATCH ? (uint32_t)(end - first) : GI_BATCH;
		wave.radiance = scratch->radiance;
		for (uint32_t i = 0; i < count; i++) {
			uint32_t sample = (uint32_t)((first + i) / branches), branch = (uint32_t)((first + i) % branches);
			wave_add(&wave, &batch->rays[sample],
			         gi_sampler_branch(&view->sampler, batch->points[sample], GI_DIMENSION_OF(0), branch, branches));
		}
		wave_run(&wave);
		wave_end(&wave, batch);
		for (uint32_t i = 0; i < count; i++)
			batch->radiance[(first + i) / branches] += scratch->radiance[i];
	}
	for (uint32_t i = 0; i < batch->count; i++)
		batch->radiance[i] /= (float)branches;
}

const gi_integrator gi_integrator_split = {.shade = split_shade, .scratch_size = sizeof(path_scratch)};

/* ---- for other integrators --------------------------------------------------------------------------------------- */

void gi_path_gather(gi_batch *batch, uint32_t vertex, uint32_t depth)
{
	STILB_ASSERT(batch->count <= GI_BATCH);
	path_wave wave = wave_begin(batch);
	wave.vertex = vertex;
	wave.depth = depth;
	wave.direct_from = wave.emission_from = 1;
	for (uint32_t i = 0; i < batch->count; i++)
		wave_add(&wave, &batch->rays[i], batch->points[i]);
	wave_run(&wave);
	wave_end(&wave, batch);
}
