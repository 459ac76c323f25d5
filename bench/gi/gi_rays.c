/* Times stages of the offline renderer, and Embree alone on the same rays; the difference is the renderer's own cost.
 * Rays are traced on one thread. */
#include "bench/gi/gi_run.h"
#include "gi/film/gi_primary.h"
#include "gi/gi_scene_internal.h"
#include "gi/trace/gi_embree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 512u /* of the pictures traced, pixels */
#define PATH_SIDE 256u
#define PATH_DEPTH 8u

/* ---- building ---------------------------------------------------------------------------------------------------- */

typedef struct geometry {
	float *positions;
	uint32_t *indices;
	uint32_t vertex_count, triangle_count;
} geometry;

static geometry geometry_of(const stilb_scene_mesh *mesh)
{
	geometry g = {
		.vertex_count = mesh->vertex_count, .triangle_count = mesh->index_count / 3, .indices = mesh->indices};
	/* Embree reads 16 bytes for each vertex, beyond the last one too. */
	g.positions = malloc(((size_t)mesh->vertex_count * 3 + 4) * sizeof(float));
	if (!g.positions)
		bench_child_fail("no memory for the scene");
	for (uint32_t i = 0; i < mesh->vertex_count; i++)
		memcpy(g.positions + 3 * (size_t)i, mesh->vertices[i].position, sizeof mesh->vertices[i].position);
	return g;
}

/* The time of rtcCommitScene on Embree's own threads, one for each CPU, in seconds. */
static double embree_build(const geometry *geometries, uint32_t count)
{
	char config[64];
	snprintf(config, sizeof config, "threads=%u", bench_child_cpu_count());
	RTCDevice device = rtcNewDevice(config);
	RTCScene scene = rtcNewScene(device);
	for (uint32_t i = 0; i < count; i++) {
		RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
		rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, geometries[i].positions, 0, 12,
		                           geometries[i].vertex_count);
		rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, geometries[i].indices, 0, 12,
		                           geometries[i].triangle_count);
		rtcCommitGeometry(g);
		rtcAttachGeometryByID(scene, g, i);
		rtcReleaseGeometry(g);
	}
	uint64_t begin = bench_child_now_ns();
	rtcCommitScene(scene);
	double seconds = 1e-9 * (double)(bench_child_now_ns() - begin);
	rtcReleaseScene(scene);
	rtcReleaseDevice(device);
	return seconds;
}

void gi_run_build(const bench_child *child)
{
	stilb_scene *scene = gi_run_million();
	geometry *geometries = calloc(scene->part_count, sizeof *geometries);
	if (!geometries)
		bench_child_fail("no memory for the scene");
	for (uint32_t p = 0; p < scene->part_count; p++)
		geometries[p] = geometry_of(&scene->meshes[scene->part_mesh[p]]);
	double own = (double)INFINITY, theirs = (double)INFINITY, spent = 0.0;
	for (uint32_t turn = 0; turn < 3 || spent < child->seconds; turn++) {
		/* The least time of the renderer's builds and of Embree's is kept: each build is the same work, so longer times
		 * are disturbances. */
		stilb_job_pool *pool;
		stilb_job_pool_desc desc = stilb_job_pool_desc_default();
		desc.worker_count = bench_child_cpu_count() - 1;
		if (stilb_job_pool_create(&desc, &pool) != 0)
			bench_child_fail("cannot start worker threads");
		stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(pool);
		stilb_gi_scene *gi;
		gi_run_check(stilb_gi_scene_create(scene, &gi_desc, &gi), "the scene");
		double seconds = stilb_gi_scene_info_of(gi)->build_s;
		if (stilb_gi_scene_info_of(gi)->triangles != 1037244)
			bench_child_fail("wrong result: the scene has %llu triangles",
			                 (unsigned long long)stilb_gi_scene_info_of(gi)->triangles);
		own = fmin(own, seconds);
		stilb_gi_scene_destroy(gi);
		stilb_job_pool_destroy(pool);
		double other = embree_build(geometries, scene->part_count);
		theirs = fmin(theirs, other);
		spent += seconds + other;
	}
	for (uint32_t p = 0; p < scene->part_count; p++)
		free(geometries[p].positions);
	free(geometries);
	bench_child_metric("stilb", 1e3 * own);
	bench_child_metric("embree", 1e3 * theirs);
	bench_child_metric("ratio", own / theirs);
}

/* ---- recording --------------------------------------------------------------------------------------------------- */

/* Stands in for the renderer's tracer: records rays in the order in which they are traced, and passes them on. */
typedef struct tape {
	gi_tracer behind; /* the renderer's tracer, which finds the hits */
	gi_ray_hit *closest;
	gi_ray *shadow;
	size_t closest_count, closest_room, shadow_count, shadow_room;
} tape;

static void *grown(void *array, size_t *room, size_t size)
{
	*room = *room ? 2 * *room : 1 << 16;
	array = realloc(array, *room * size);
	if (!array)
		bench_child_fail("no memory for the rays");
	return array;
}

static void record_closest(tape *t, const gi_ray_hit *ray)
{
	if (t->closest_count == t->closest_room)
		t->closest = grown(t->closest, &t->closest_room, sizeof *t->closest);
	t->closest[t->closest_count++] = *ray;
}

static void tape_intersect(const gi_tracer *tracer, gi_ray_hit *ray)
{
	tape *t = tracer->state;
	record_closest(t, ray);
	t->behind.intersect(&t->behind, ray);
}

static void tape_intersect16(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *rays)
{
	tape *t = tracer->state;
	for (uint32_t i = 0; i < 16; i++)
		if (valid[i]) {
			gi_ray_hit ray = gi_ray_of(rays, i);
			ray.hit = (gi_hit){.part = GI_NO_PART, .instance = GI_NO_PART}; /* no hit: not traced yet */
			record_closest(t, &ray);
		}
	t->behind.intersect16(&t->behind, valid, rays);
}

static void tape_occluded(const gi_tracer *tracer, gi_ray *rays, uint32_t count)
{
	tape *t = tracer->state;
	for (uint32_t i = 0; i < count; i++) {
		if (t->shadow_count == t->shadow_room)
			t->shadow = grown(t->shadow, &t->shadow_room, sizeof *t->shadow);
		t->shadow[t->shadow_count++] = rays[i];
	}
	t->behind.occluded(&t->behind, rays, count);
}

/* Renders a picture and returns all rays that the renderer traced for it. */
static tape record(gi_run_world *world, const stilb_gi_settings *settings)
{
	tape t = {.behind = world->gi->tracer};
	world->gi->tracer = (gi_tracer){tape_intersect, tape_intersect16, tape_occluded, &t};
	gi_run_picture picture = gi_run_render(world, settings);
	gi_run_picture_finish(&picture);
	world->gi->tracer = t.behind;
	return t;
}

/* ---- raw Embree -------------------------------------------------------------------------------------------------- */

static void raw_closest(RTCScene scene, const tape *t)
{
	for (size_t i = 0; i < t->closest_count; i++) {
		gi_ray_hit ray = t->closest[i];
		struct RTCIntersectContext context;
		rtcInitIntersectContext(&context);
		rtcIntersect1(scene, &context, gi_embree_ray_hit(&ray));
	}
}

static void raw_shadow(RTCScene scene, const tape *t)
{
	for (size_t i = 0; i < t->shadow_count; i++) {
		gi_ray ray = t->shadow[i];
		struct RTCIntersectContext context;
		rtcInitIntersectContext(&context);
		rtcOccluded1(scene, &context, gi_embree_ray(&ray));
	}
}

/* Traces the packets of sixteen rays by Embree alone, in their order. */
static void raw_packets(RTCScene scene, const gi_ray_hit16 *packets, size_t count)
{
	static const int valid[16]
		__attribute__((aligned(64))) = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
	for (size_t i = 0; i < count; i++) {
		gi_ray_hit16 rays = packets[i];
		struct RTCIntersectContext context;
		rtcInitIntersectContext(&context);
		context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
		rtcIntersect16(valid, scene, &context, gi_embree_ray_hit16(&rays));
	}
}

/* ---- the cases --------------------------------------------------------------------------------------------------- */

static double seconds_since(uint64_t begin)
{
	return 1e-9 * (double)(bench_child_now_ns() - begin);
}

/* Prints rates in million rays a second and their ratio. own, raw: the least times, in seconds, that the renderer and
 * Embree alone took for so many rays. */
static void report_rates(double rays, double own, double raw)
{
	bench_child_metric("stilb", 1e-6 * rays / own);
	bench_child_metric("embree", 1e-6 * rays / raw);
	bench_child_metric("ratio", raw / own);
}

/* The samples of a picture in the renderer's order: tile by tile, in a tile by blocks of 4 x 4 pixels. */
typedef struct samples {
	uint16_t x[SIDE * SIDE], y[SIDE * SIDE];
	gi_point points[SIDE * SIDE];
} samples;

static samples *samples_make(const gi_view *view)
{
	samples *s = stilb_memory_alloc(1, sizeof *s);
	if (!s)
		bench_child_fail("no memory for the samples");
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		uint32_t tile = i / GI_BATCH, block = i % GI_BATCH / 16, at = i % 16;
		s->x[i] = (uint16_t)(tile % (SIDE / 32) * 32 + block % 8 * 4 + at % 4);
		s->y[i] = (uint16_t)(tile / (SIDE / 32) * 32 + block / 8 * 4 + at / 4);
		s->points[i] = gi_sampler_point(&view->sampler, s->x[i], s->y[i], 0);
	}
	return s;
}

/* Runs the renderer's camera stage (camera rays and the surfaces that they hit) over the picture; returns its time in
 * seconds. */
static double primary_pass(const gi_view *view, const gi_camera *camera, const samples *s, gi_primary *primary)
{
	stilb_isa isa;
	const gi_primary_kernels *kernels =
		gi_primary_kernels_for(stilb_cpu_isa(&isa) == STILB_OK ? isa : STILB_ISA_SCALAR);
	uint64_t begin = bench_child_now_ns();
	for (uint32_t i = 0; i < SIDE * SIDE; i += GI_BATCH) {
		gi_primary_samples batch = {GI_BATCH, s->x + i, s->y + i, s->points + i};
		gi_primary_trace(kernels, view, camera, &batch, primary);
	}
	return seconds_since(begin);
}

/* Packs the tape's rays into packets of sixteen. */
static gi_ray_hit16 *packets_of(const tape *t)
{
	gi_ray_hit16 *packets = stilb_memory_alloc(t->closest_count / 16, sizeof *packets);
	if (!packets)
		bench_child_fail("no memory for the rays");
	for (size_t i = 0; i < t->closest_count / 16 * 16; i++) {
		const gi_ray *from = &t->closest[i].ray;
		gi_ray16 *to = &packets[i / 16].ray;
		size_t lane = i % 16;
		for (int axis = 0; axis < 3; axis++) {
			to->origin[axis][lane] = from->origin[axis];
			to->direction[axis][lane] = from->direction[axis];
		}
		to->t_min[lane] = from->t_min, to->t_max[lane] = from->t_max, to->time[lane] = from->time;
		to->mask[lane] = from->mask, to->id[lane] = from->id, to->flags[lane] = from->flags;
		packets[i / 16].hit.part[lane] = packets[i / 16].hit.instance[lane] = GI_NO_PART;
	}
	return packets;
}

void gi_run_primary(const bench_child *child)
{
	gi_run_world world = gi_run_world_make(gi_run_million(), 0);
	gi_view view = {.scene = world.gi, .settings = stilb_gi_settings_default(world.scene)};
	view.settings.width = view.settings.height = SIDE;
	view.sampler = gi_sampler_make(view.settings.sampler, child->round, 1);
	gi_camera camera = gi_camera_make(&view.settings.camera, &view.settings.lens, SIDE, SIDE);
	gi_primary *primary = stilb_memory_alloc(1, sizeof *primary);
	if (!primary)
		bench_child_fail("no memory for a batch");

	tape t = {.behind = world.gi->tracer};
	world.gi->tracer = (gi_tracer){tape_intersect, tape_intersect16, tape_occluded, &t};
	samples *all = samples_make(&view);
	primary_pass(&view, &camera, all, primary);
	world.gi->tracer = t.behind;
	if (t.closest_count != (size_t)SIDE * SIDE)
		bench_child_fail("wrong result: %zu camera rays instead of %u", t.closest_count, SIDE * SIDE);
	gi_ray_hit16 *packets = packets_of(&t);

	RTCScene scene = gi_embree_scene(world.gi);
	double own = (double)INFINITY, raw = (double)INFINITY, spent = 0.0;
	while (spent < child->seconds) {
		double a = primary_pass(&view, &camera, all, primary);
		uint64_t begin = bench_child_now_ns();
		raw_packets(scene, packets, t.closest_count / 16);
		double b = seconds_since(begin);
		own = fmin(own, a);
		raw = fmin(raw, b);
		spent += a + b;
	}
	report_rates(SIDE * SIDE, own, raw);
}

void gi_run_path(const bench_child *child)
{
	gi_run_world world = gi_run_world_make(gi_run_million(), 0);
	stilb_gi_settings settings = stilb_gi_settings_default(world.scene);
	settings.integrator = STILB_GI_INTEGRATOR_PATH;
	settings.width = settings.height = PATH_SIDE;
	settings.samples = 1;
	settings.depth = PATH_DEPTH;
	settings.seed = child->round;
	tape t = record(&world, &settings);
	RTCScene scene = gi_embree_scene(world.gi);
	double own = (double)INFINITY, raw = (double)INFINITY, spent = 0.0;
	while (spent < child->seconds) {
		gi_run_picture picture = gi_run_render(&world, &settings);
		if (picture.rays != t.closest_count + t.shadow_count)
			bench_child_fail("wrong result: the renderer counted %llu rays, %zu were recorded",
			                 (unsigned long long)picture.rays, t.closest_count + t.shadow_count);
		uint64_t begin = bench_child_now_ns();
		raw_closest(scene, &t);
		raw_shadow(scene, &t);
		double b = seconds_since(begin);
		own = fmin(own, picture.seconds);
		raw = fmin(raw, b);
		spent += picture.seconds + b;
		gi_run_picture_finish(&picture);
	}
	double rays = (double)(t.closest_count + t.shadow_count);
	report_rates(rays, own, raw);
	bench_child_metric("shadow", 100.0 * (double)t.shadow_count / rays);
}
