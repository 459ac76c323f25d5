/*
 * The cases `rays-*`: the renderer, and Embree alone on the very rays of its picture, in the order in which the
 * renderer traced them and by the same tree; the difference is the renderer's own cost. One thread; times are CPU
 * times, the least of many passes that take turns. Embree traces each kind of ray one by one and sixteen at a time; the
 * faster counts.
 */
#include "bench/gi/gi_run.h"
#include "gi/film/gi_primary.h"
#include "gi/gi_scene_internal.h"
#include "gi/trace/gi_embree.h"
#include "gi/trace/gi_packet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 192u /* of the picture, pixels */
#define SAMPLES 4u
#define PASSES 5u /* at least */
#define TILE 16u  /* of the renderer, pixels */
#define DEPTH 8u
#define PIXELS (SIDE * SIDE)
#define CAMERA_RAYS (PIXELS * SAMPLES)

/* ---- recording --------------------------------------------------------------------------------------------------- */

typedef struct rays {
	gi_ray_hit *at; /* [room] as they are before they are traced; a shadow ray's hit is "none" */
	size_t count, room;
	gi_ray_hit16 *packets; /* the same, sixteen at a time; the last rays of all may be missing */
} rays;

/* Stands in for the renderer's tracer: records rays, and passes them on. */
typedef struct tape {
	gi_tracer behind; /* the renderer's tracer, which finds the hits */
	rays camera, bounce, shadow;
	size_t shadow_call; /* rays of the longest call of occluded */
} tape;

static void record(rays *r, const gi_ray *ray)
{
	if (r->count == r->room) {
		r->room = r->room ? 2 * r->room : 1 << 16;
		r->at = realloc(r->at, r->room * sizeof *r->at);
		if (!r->at)
			bench_child_fail("no memory for the rays");
	}
	r->at[r->count++] = (gi_ray_hit){*ray, {.part = GI_NO_PART, .instance = GI_NO_PART}};
}

static void tape_intersect(const gi_tracer *tracer, gi_ray_hit *ray)
{
	tape *t = tracer->state;
	record(&t->bounce, &ray->ray);
	t->behind.intersect(&t->behind, ray);
}

static void tape_intersect16(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *packet)
{
	tape *t = tracer->state;
	for (uint32_t i = 0; i < 16; i++)
		if (valid[i]) {
			gi_ray_hit ray = gi_ray_of(packet, i);
			record(&t->camera, &ray.ray);
		}
	t->behind.intersect16(&t->behind, valid, packet);
}

static void tape_occluded(const gi_tracer *tracer, gi_ray *shadows, uint32_t count)
{
	tape *t = tracer->state;
	for (uint32_t i = 0; i < count; i++)
		record(&t->shadow, &shadows[i]);
	t->shadow_call = count > t->shadow_call ? count : t->shadow_call;
	t->behind.occluded(&t->behind, shadows, count);
}

static void rays_pack(rays *r)
{
	r->packets = stilb_memory_alloc(r->count / 16 + 1, sizeof *r->packets);
	if (!r->packets)
		bench_child_fail("no memory for the rays");
	for (size_t i = 0; i < r->count / 16; i++) {
		gi_packet_load_rays(&r->at[16 * i].ray, sizeof *r->at, &r->packets[i].ray);
		for (size_t lane = 0; lane < 16; lane++)
			r->packets[i].hit.part[lane] = r->packets[i].hit.instance[lane] = GI_NO_PART;
	}
}

/* All rays that the renderer traces for a picture. */
static tape tape_of(gi_run_world *world, const stilb_gi_settings *settings)
{
	tape t = {.behind = world->gi->tracer};
	world->gi->tracer = (gi_tracer){tape_intersect, tape_intersect16, tape_occluded, &t};
	gi_run_picture picture = gi_run_render(world, settings);
	if (picture.rays != t.camera.count + t.bounce.count + t.shadow.count || t.camera.count != CAMERA_RAYS)
		bench_child_fail("wrong result: the renderer counted %llu rays, %zu + %zu + %zu were recorded",
		                 (unsigned long long)picture.rays, t.camera.count, t.bounce.count, t.shadow.count);
	gi_run_picture_finish(&picture);
	world->gi->tracer = t.behind;
	rays_pack(&t.camera);
	rays_pack(&t.bounce);
	rays_pack(&t.shadow);
	return t;
}

/* ---- Embree alone ------------------------------------------------------------------------------------------------ */

static const int all_lanes[16]
	__attribute__((aligned(64))) = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

static double cpu_since(double begin)
{
	return gi_run_now().thread_seconds - begin;
}

static double alone_closest(RTCScene scene, const rays *r)
{
	double begin = gi_run_now().thread_seconds;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	for (size_t i = 0; i < r->count; i++) {
		gi_ray_hit ray = r->at[i];
		rtcIntersect1(scene, &context, gi_embree_ray_hit(&ray));
	}
	return cpu_since(begin);
}

static double alone_closest16(RTCScene scene, const rays *r, enum RTCIntersectContextFlags flags)
{
	double begin = gi_run_now().thread_seconds;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	context.flags = flags;
	for (size_t i = 0; i < r->count / 16; i++) {
		gi_ray_hit16 packet = r->packets[i];
		rtcIntersect16(all_lanes, scene, &context, gi_embree_ray_hit16(&packet));
	}
	return cpu_since(begin);
}

static double alone_any(RTCScene scene, const rays *r)
{
	double begin = gi_run_now().thread_seconds;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	for (size_t i = 0; i < r->count; i++) {
		gi_ray ray = r->at[i].ray;
		rtcOccluded1(scene, &context, gi_embree_ray(&ray));
	}
	return cpu_since(begin);
}

static double alone_any16(RTCScene scene, const rays *r)
{
	double begin = gi_run_now().thread_seconds;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	for (size_t i = 0; i < r->count / 16; i++) {
		gi_ray16 packet = r->packets[i].ray;
		rtcOccluded16(all_lanes, scene, &context, gi_embree_ray16(&packet));
	}
	return cpu_since(begin);
}

/* ---- the renderer's stages --------------------------------------------------------------------------------------- */

/* The samples of a picture in the renderer's order: tile by tile, in a tile in Morton order, and all samples of a pixel
 * together. */
typedef struct samples {
	uint16_t x[CAMERA_RAYS], y[CAMERA_RAYS];
	gi_point points[CAMERA_RAYS];
	gi_primary found; /* of the batch that was traced last */
} samples;

/* Every second bit of a Morton code. */
static uint32_t morton_x(uint32_t code)
{
	uint32_t x = 0;
	for (uint32_t bit = 0; 1u << 2 * bit < TILE * TILE; bit++)
		x |= (code >> 2 * bit & 1) << bit;
	return x;
}

static samples *samples_make(const gi_view *view)
{
	samples *s = stilb_memory_alloc(1, sizeof *s);
	if (!s)
		bench_child_fail("no memory for the samples");
	for (uint32_t i = 0; i < CAMERA_RAYS; i++) {
		uint32_t pixel = i / SAMPLES, tile = pixel / (TILE * TILE), at = pixel % (TILE * TILE);
		s->x[i] = (uint16_t)(tile % (SIDE / TILE) * TILE + morton_x(at));
		s->y[i] = (uint16_t)(tile / (SIDE / TILE) * TILE + morton_x(at >> 1));
		s->points[i] = gi_sampler_point(&view->sampler, s->x[i], s->y[i], i % SAMPLES);
	}
	return s;
}

/* Camera rays and the surfaces that they hit. */
static double own_camera(const gi_view *view, const gi_camera *camera, samples *s)
{
	stilb_isa isa;
	const gi_primary_kernels *kernels =
		gi_primary_kernels_for(stilb_cpu_isa(&isa) == STILB_OK ? isa : STILB_ISA_SCALAR);
	double begin = gi_run_now().thread_seconds;
	for (uint32_t i = 0; i < CAMERA_RAYS; i += GI_BATCH) {
		gi_primary_samples batch = {GI_BATCH, s->x + i, s->y + i, s->points + i};
		gi_primary_trace(kernels, view, camera, &batch, &s->found);
	}
	return cpu_since(begin);
}

/* Shadow rays in batches, from the layout in which the integrators keep them. */
static double own_shadow(const gi_tracer *tracer, const rays *r, gi_ray *batch, size_t batch_count)
{
	double begin = gi_run_now().thread_seconds;
	for (size_t first = 0; first < r->count; first += batch_count) {
		size_t count = r->count - first < batch_count ? r->count - first : batch_count;
		for (size_t i = 0; i < count; i++)
			batch[i] = r->at[first + i].ray;
		tracer->occluded(tracer, batch, (uint32_t)count);
	}
	return cpu_since(begin);
}

/* ---- the cases --------------------------------------------------------------------------------------------------- */

/* Least times of passes over the picture's rays, seconds. */
typedef struct times {
	double picture, camera, shadow;                                     /* the renderer's */
	double camera_alone, bounce_alone, shadow_alone, shadow_one_by_one; /* Embree's */
} times;

static void least_of(double *least, double seconds)
{
	*least = *least > 0.0 ? fmin(*least, seconds) : seconds;
}

/* Prints the rate in million rays a second, and what share of Embree's it is. */
static void report(const char *rate, const char *share, size_t count, double own, double alone)
{
	bench_child_metric(rate, 1e-6 * (double)count / own);
	bench_child_metric(share, alone / own);
}

void gi_run_rays(const bench_child *child)
{
	const char *name = child->case_name + strlen(GI_RUN_RAYS);
	gi_run_world world = gi_run_world_make(gi_run_row_scene(name), 0);
	gi_view view = {.scene = world.gi, .settings = gi_run_cornell(world.scene)};
	view.settings.width = view.settings.height = SIDE;
	view.settings.samples = SAMPLES;
	view.settings.depth = DEPTH;
	view.settings.seed = child->round;
	view.sampler = gi_sampler_make(view.settings.sampler, child->round, SAMPLES);
	gi_camera camera = gi_camera_make(&view.settings.camera, &view.settings.lens, SIDE, SIDE);
	samples *all = samples_make(&view);
	tape t = tape_of(&world, &view.settings);
	gi_ray *batch = stilb_memory_alloc(t.shadow_call + 1, sizeof *batch);
	if (!batch)
		bench_child_fail("no memory for a batch");
	RTCScene scene = gi_embree_scene(world.gi);
	times l = {0};
	double begin = gi_run_now().seconds;
	for (uint32_t pass = 0; pass < PASSES || gi_run_now().seconds - begin < child->seconds; pass++) {
		gi_run_picture picture = gi_run_render(&world, &view.settings);
		least_of(&l.picture, picture.thread_seconds);
		gi_run_picture_finish(&picture);
		least_of(&l.camera_alone, alone_closest(scene, &t.camera));
		least_of(&l.camera_alone, alone_closest16(scene, &t.camera, RTC_INTERSECT_CONTEXT_FLAG_COHERENT));
		least_of(&l.camera, own_camera(&view, &camera, all));
		least_of(&l.bounce_alone, alone_closest(scene, &t.bounce));
		least_of(&l.bounce_alone, alone_closest16(scene, &t.bounce, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT));
		least_of(&l.shadow_one_by_one, alone_any(scene, &t.shadow));
		least_of(&l.shadow_alone, alone_any16(scene, &t.shadow));
		least_of(&l.shadow, own_shadow(&world.gi->tracer, &t.shadow, batch, t.shadow_call));
	}
	l.shadow_alone = fmin(l.shadow_alone, l.shadow_one_by_one);
	size_t count = t.camera.count + t.bounce.count + t.shadow.count;
	report("path", "path-share", count, l.picture, l.camera_alone + l.bounce_alone + l.shadow_alone);
	report("primary", "primary-share", t.camera.count, l.camera, l.camera_alone);
	report("shadow", "shadow-share", t.shadow.count, l.shadow, l.shadow_alone);
	bench_child_metric("shadow-one", 1e-6 * (double)t.shadow.count / l.shadow_one_by_one);
	bench_child_metric("bounce-alone", 1e-6 * (double)t.bounce.count / l.bounce_alone);
}
