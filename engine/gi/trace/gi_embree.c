/*
 * gi_embree: Embree's tree behind gi_tracer. The only file of the library that calls Embree, so that programs which do
 * not name stilb_gi_embree do not load it.
 *
 * Build.    Embree starts no threads here: the pool's workers help, one pinned job each (gi_embree_team). A worker that
 *           comes late finds the build done and returns at once, so none waits for another to arrive.
 * Small.    Trees of few triangles are built side by side, each by one thread.
 * Movable.  Then every mesh has a tree of its own, and the scene's tree holds instances alone: also of the meshes of
 *           one part, which are in world space and stay where they are. A move builds the scene's tree again, and the
 *           trees of meshes that were made anew.
 * Poses.    A mesh of which only the vertices are others gets its tree anew, or, in a scene that is not movable, the
 *           tree in which it lies: by the same steps as at first, so that it is the same tree as one built now.
 * Robust.   The tree's robust mode: no ray passes between two triangles that share an edge.
 */
#include "gi/trace/gi_embree.h"
#include "gi/gi_scene_internal.h"
#include "gi/trace/gi_cover.h"
#include "gi/trace/gi_embree_team.h"
#include "gi/trace/gi_packet.h"

#include "profiler/prof.h"

#include <assert.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct embree {
	RTCDevice device;
	gi_embree_team *team;
	RTCScene scene;
	RTCScene *shared; /* [mesh_count] tree of a mesh that instances show, else NULL */
	uint32_t *small;  /* [mesh_count] meshes whose trees are built side by side */
	uint32_t mesh_count;
	const stilb_gi_scene *gi;
	const gi_part *parts;
	bool *attached; /* [part_count] rays see it: the scene's tree has a geometry of the part's index */
	uint32_t part_count;
	uint32_t workers; /* threads that build at most: those that the device was made for */
	bool movable;
	bool sieved;                     /* some mesh has a filter */
	const stilb_gi_scene_desc *desc; /* of the create or update that runs; else NULL */
	/* Written by all threads that build. Relaxed: they are read after the wait for the build's jobs, which orders the
	 * stores before the reads. */
	_Atomic int64_t bytes; /* memory that Embree has now */
	_Atomic int error;     /* the first RTCError */
	_Atomic bool given_up; /* by desc->give_up */
	int64_t bytes_max;     /* that it may have */
} embree;

#define EMBREE_ALONE 4096u /* primitives of a tree that is not worth waking the workers */

/* ---- rays -------------------------------------------------------------------------------------------------------- */

#define EMBREE_SAME(ours, our_field, theirs, their_field)                                                              \
	static_assert(offsetof(ours, our_field) == offsetof(struct theirs, their_field),                                   \
	              "Embree has " #their_field " elsewhere")

static_assert(sizeof(gi_ray) == sizeof(struct RTCRay) && _Alignof(gi_ray) == _Alignof(struct RTCRay), "a ray");
EMBREE_SAME(gi_ray, origin[0], RTCRay, org_x);
EMBREE_SAME(gi_ray, origin[1], RTCRay, org_y);
EMBREE_SAME(gi_ray, origin[2], RTCRay, org_z);
EMBREE_SAME(gi_ray, t_min, RTCRay, tnear);
EMBREE_SAME(gi_ray, direction[0], RTCRay, dir_x);
EMBREE_SAME(gi_ray, direction[1], RTCRay, dir_y);
EMBREE_SAME(gi_ray, direction[2], RTCRay, dir_z);
EMBREE_SAME(gi_ray, time, RTCRay, time);
EMBREE_SAME(gi_ray, t_max, RTCRay, tfar);
EMBREE_SAME(gi_ray, mask, RTCRay, mask);
EMBREE_SAME(gi_ray, id, RTCRay, id);
EMBREE_SAME(gi_ray, flags, RTCRay, flags);

static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT == 1 && RTC_INVALID_GEOMETRY_ID == GI_NO_PART, "one instance, or none");
static_assert(sizeof(gi_hit) == sizeof(struct RTCHit) && _Alignof(gi_hit) == _Alignof(struct RTCHit), "a hit");
EMBREE_SAME(gi_hit, normal[0], RTCHit, Ng_x);
EMBREE_SAME(gi_hit, normal[1], RTCHit, Ng_y);
EMBREE_SAME(gi_hit, normal[2], RTCHit, Ng_z);
EMBREE_SAME(gi_hit, u, RTCHit, u);
EMBREE_SAME(gi_hit, v, RTCHit, v);
EMBREE_SAME(gi_hit, triangle, RTCHit, primID);
EMBREE_SAME(gi_hit, part, RTCHit, geomID);
EMBREE_SAME(gi_hit, instance, RTCHit, instID);
static_assert(sizeof(gi_ray_hit) == sizeof(struct RTCRayHit), "a ray and its hit");
EMBREE_SAME(gi_ray_hit, hit, RTCRayHit, hit);

static_assert(sizeof(gi_ray16) == sizeof(struct RTCRay16) && _Alignof(gi_ray16) == _Alignof(struct RTCRay16), "rays");
EMBREE_SAME(gi_ray16, origin[0], RTCRay16, org_x);
EMBREE_SAME(gi_ray16, origin[1], RTCRay16, org_y);
EMBREE_SAME(gi_ray16, origin[2], RTCRay16, org_z);
EMBREE_SAME(gi_ray16, t_min, RTCRay16, tnear);
EMBREE_SAME(gi_ray16, direction[0], RTCRay16, dir_x);
EMBREE_SAME(gi_ray16, direction[1], RTCRay16, dir_y);
EMBREE_SAME(gi_ray16, direction[2], RTCRay16, dir_z);
EMBREE_SAME(gi_ray16, time, RTCRay16, time);
EMBREE_SAME(gi_ray16, t_max, RTCRay16, tfar);
EMBREE_SAME(gi_ray16, mask, RTCRay16, mask);
EMBREE_SAME(gi_ray16, id, RTCRay16, id);
EMBREE_SAME(gi_ray16, flags, RTCRay16, flags);

static_assert(sizeof(gi_hit16) == sizeof(struct RTCHit16) && _Alignof(gi_hit16) == _Alignof(struct RTCHit16), "hits");
EMBREE_SAME(gi_hit16, normal[0], RTCHit16, Ng_x);
EMBREE_SAME(gi_hit16, normal[1], RTCHit16, Ng_y);
EMBREE_SAME(gi_hit16, normal[2], RTCHit16, Ng_z);
EMBREE_SAME(gi_hit16, u, RTCHit16, u);
EMBREE_SAME(gi_hit16, v, RTCHit16, v);
EMBREE_SAME(gi_hit16, triangle, RTCHit16, primID);
EMBREE_SAME(gi_hit16, part, RTCHit16, geomID);
EMBREE_SAME(gi_hit16, instance, RTCHit16, instID);
static_assert(sizeof(gi_ray_hit16) == sizeof(struct RTCRayHit16), "sixteen rays and their hits");
EMBREE_SAME(gi_ray_hit16, hit, RTCRayHit16, hit);

static void embree_intersect(const gi_tracer *tracer, gi_ray_hit *ray)
{
	STILB_ASSERT(!gi_is_hit(ray) && "nothing hit before");
	const embree *state = tracer->state;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	rtcIntersect1(state->scene, &context, gi_embree_ray_hit(ray));
}

static void embree_intersect16(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *rays)
{
	STILB_ASSERT((uintptr_t)valid % 64 == 0 && (uintptr_t)rays % 64 == 0);
	const embree *state = tracer->state;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
	/* Without AVX-512 Embree 3.13 makes a stream of the packet, whose rays count unless they end before they begin. */
	float t_max[16];
	for (int i = 0; i < 16; i++) {
		t_max[i] = rays->ray.t_max[i];
		rays->ray.t_max[i] = valid[i] ? t_max[i] : -INFINITY;
	}
	rtcIntersect16(valid, state->scene, &context, gi_embree_ray_hit16(rays));
	for (int i = 0; i < 16; i++)
		rays->ray.t_max[i] = valid[i] ? rays->ray.t_max[i] : t_max[i];
}

/* gi_tracer.occluded, in packets of sixteen rays. Embree's streams (rtcOccluded1M) sort the rays first, which costs
 * more than it saves: 70 ns a ray against 45 with packets in the Cornell box, 176 against 148 among a million
 * triangles, measured with the path tracer's own rays. Where a filter is asked, packets take longer: 290 ns a ray
 * against 255 in foliage. */
static void embree_occluded(const gi_tracer *tracer, gi_ray *rays, uint32_t count)
{
	STILB_ASSERT(rays || count == 0);
	const embree *state = tracer->state;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	for (uint32_t i = 0; i < count && state->sieved; i++)
		rtcOccluded1(state->scene, &context, gi_embree_ray(&rays[i]));
	for (uint32_t first = 0; first < count && !state->sieved; first += 16) {
		uint32_t lanes = count - first < 16 ? count - first : 16;
		gi_ray padded[16]; /* the last rays, where there are fewer than sixteen */
		const gi_ray *from = rays + first;
		int valid[16] __attribute__((aligned(64)));
		gi_ray16 packet;
		for (uint32_t lane = 0; lane < 16; lane++)
			valid[lane] = lane < lanes ? -1 : 0;
		if (lanes < 16) {
			memset(padded, 0, sizeof padded);
			memcpy(padded, from, lanes * sizeof *padded);
			from = padded;
		}
		gi_packet_load_rays(from, sizeof *from, &packet);
		rtcOccluded16(valid, state->scene, &context, gi_embree_ray16(&packet));
		for (uint32_t lane = 0; lane < lanes; lane++)
			rays[first + lane].t_max = packet.t_max[lane];
	}
}

/* Where a member of a ray or a hit is in the rows of N lanes that a filter gets. */
#define EMBREE_ROW(type, member) (offsetof(type, member) / sizeof(float))

/* Lane i of what a filter gets. All of it is in the space of the mesh, where front and back are as in the world. */
static gi_crossing embree_crossing(const struct RTCFilterFunctionNArguments *args, uint32_t i)
{
	const float *direction = (const float *)args->ray + EMBREE_ROW(gi_ray, direction) * args->N + i;
	const float *normal = (const float *)args->hit + EMBREE_ROW(gi_hit, normal) * args->N + i;
	const uint32_t *ids = (const uint32_t *)args->hit + i;
	size_t lanes = args->N;
	uint32_t instance = ids[EMBREE_ROW(gi_hit, instance) * lanes];
	float into = normal[0] * direction[0] + normal[lanes] * direction[lanes] + normal[2 * lanes] * direction[2 * lanes];
	return (gi_crossing){.part = instance != GI_NO_PART ? instance : ids[EMBREE_ROW(gi_hit, part) * lanes],
	                     .triangle = ids[EMBREE_ROW(gi_hit, triangle) * lanes],
	                     .u = ((const float *)args->hit)[EMBREE_ROW(gi_hit, u) * lanes + i],
	                     .v = ((const float *)args->hit)[EMBREE_ROW(gi_hit, v) * lanes + i],
	                     .chance = ((const float *)args->ray)[EMBREE_ROW(gi_ray, time) * lanes + i],
	                     .front = into <= 0.0f};
}

/* Embree asks it for each triangle of a sieved mesh that a ray crosses. */
static void embree_filter(const struct RTCFilterFunctionNArguments *args)
{
	for (uint32_t i = 0; i < args->N; i++) {
		if (args->valid[i] != -1)
			continue;
		gi_crossing crossing = embree_crossing(args, i);
		if (!gi_cover_meets(args->geometryUserPtr, &crossing))
			args->valid[i] = 0;
	}
}

/* The normal of an instance's triangle from mesh space, in which Embree gives it, to world space. */
static void embree_normal(const gi_part *part, float *x, float *y, float *z)
{
	const float *m = part->normal_to_world, normal[3] = {*x, *y, *z};
	*x = m[0] * normal[0] + m[3] * normal[1] + m[6] * normal[2];
	*y = m[1] * normal[0] + m[4] * normal[1] + m[7] * normal[2];
	*z = m[2] * normal[0] + m[5] * normal[1] + m[8] * normal[2];
}

/* Intersects a ray with a scene that has instances. For a hit on an instance Embree gives two numbers, of the instance
 * and of the mesh in it; the instance's is the part's index, which the caller wants. */
static void embree_intersect_instances(const gi_tracer *tracer, gi_ray_hit *ray)
{
	const embree *state = tracer->state;
	ray->hit.instance = GI_NO_PART;
	embree_intersect(tracer, ray);
	if (!gi_is_hit(ray) || ray->hit.instance == GI_NO_PART)
		return;
	STILB_ASSERT(ray->hit.instance < state->part_count && state->attached[ray->hit.instance]);
	ray->hit.part = ray->hit.instance;
	if (state->parts[ray->hit.part].instance)
		embree_normal(&state->parts[ray->hit.part], &ray->hit.normal[0], &ray->hit.normal[1], &ray->hit.normal[2]);
}

static void embree_intersect16_instances(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *rays)
{
	const embree *state = tracer->state;
	gi_hit16 *hit = &rays->hit;
	for (int i = 0; i < 16; i++)
		hit->instance[i] = GI_NO_PART;
	embree_intersect16(tracer, valid, rays);
	for (int i = 0; i < 16; i++) {
		uint32_t part = hit->instance[i];
		if (!valid[i] || hit->part[i] == GI_NO_PART || part == GI_NO_PART)
			continue;
		STILB_ASSERT(part < state->part_count && state->attached[part]);
		hit->part[i] = part;
		if (state->parts[part].instance)
			embree_normal(&state->parts[part], &hit->normal[0][i], &hit->normal[1][i], &hit->normal[2][i]);
	}
}

/* ---- the device -------------------------------------------------------------------------------------------------- */

static const char *const embree_isa_names[STILB_GI_ISA_COUNT] = {
#define EMBREE_ISA_NAME(id, name) [STILB_GI_ISA_##id] = #name,
	STILB_GI_ISAS(EMBREE_ISA_NAME)
#undef EMBREE_ISA_NAME
};

static bool embree_isa_here(stilb_gi_isa isa)
{
	stilb_cpu_features cpu = stilb_cpu_query();
	switch (isa) {
	case STILB_GI_ISA_SSE42:
		return cpu.sse42;
	case STILB_GI_ISA_AVX:
		return __builtin_cpu_supports("avx");
	case STILB_GI_ISA_AVX2:
		return cpu.avx2 && cpu.fma;
	case STILB_GI_ISA_AVX512:
		return cpu.avx512;
	default:
		return true;
	}
}

/* Replaces AUTO by the widest instruction set that this CPU has, so that the picture's file can name it; refuses one
 * that the CPU lacks. */
static stilb_result embree_isa(stilb_gi_isa *isa)
{
	if (*isa == STILB_GI_ISA_AUTO)
		for (*isa = STILB_GI_ISA_AVX512; !embree_isa_here(*isa);)
			(*isa)--;
	if (*isa < STILB_GI_ISA_COUNT && embree_isa_here(*isa))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT, "this machine has no %s; choose a narrower instruction set, or auto",
	                  *isa < STILB_GI_ISA_COUNT ? embree_isa_names[*isa] : "such instruction set");
}

static void embree_on_error(void *user, enum RTCError code, const char *text)
{
	embree *state = user;
	(void)text;
	int none = RTC_ERROR_NONE;
	atomic_compare_exchange_strong_explicit(&state->error, &none, (int)code, memory_order_relaxed,
	                                        memory_order_relaxed);
}

static bool embree_on_memory(void *user, ssize_t bytes, bool post)
{
	embree *state = user;
	int64_t now = atomic_fetch_add_explicit(&state->bytes, bytes, memory_order_relaxed) + bytes;
	return post || bytes <= 0 || now <= state->bytes_max;
}

/* RTCProgressMonitorFunction: false ends the build. */
static bool embree_on_progress(void *user, double done)
{
	embree *state = user;
	(void)done;
	if (atomic_load_explicit(&state->given_up, memory_order_relaxed))
		return false;
	if (state->desc->give_up(state->desc->user))
		atomic_store_explicit(&state->given_up, true, memory_order_relaxed);
	return !atomic_load_explicit(&state->given_up, memory_order_relaxed);
}

/* Bytes that the machine has free, by /proc/meminfo; INT64_MAX if that cannot be read. */
static int64_t embree_memory(void)
{
	long long kilobytes = 0;
	char line[128];
	FILE *file = fopen("/proc/meminfo", "r");
	while (file && kilobytes == 0 && fgets(line, sizeof line, file))
		sscanf(line, "MemAvailable: %lld kB", &kilobytes);
	if (file)
		fclose(file);
	return kilobytes > 0 ? (int64_t)kilobytes * 1024 : INT64_MAX;
}

static bool embree_is_given_up(const embree *state)
{
	return atomic_load_explicit(&state->given_up, memory_order_relaxed);
}

static stilb_result embree_result(const embree *state)
{
	if (embree_is_given_up(state))
		return stilb_fail(STILB_ERROR_GIVEN_UP, "the tree of the scene's triangles was given up");
	switch (atomic_load_explicit(&state->error, memory_order_relaxed)) {
	case RTC_ERROR_NONE:
		return STILB_OK;
	case RTC_ERROR_OUT_OF_MEMORY:
	case RTC_ERROR_CANCELLED:
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the tree of the scene's triangles; try a smaller scene");
	case RTC_ERROR_UNSUPPORTED_CPU:
		return stilb_fail(STILB_ERROR_DEVICE, "Embree does not support this CPU");
	default:
		return stilb_fail(STILB_ERROR_DEVICE, "Embree failed to build the tree of the scene's triangles");
	}
}

static stilb_result embree_device(embree *state, const char *isa)
{
	char config[96];
	snprintf(config, sizeof config, "threads=%u,isa=%s", state->workers, isa);
	state->team = gi_embree_team_create(state->workers);
	state->device = state->team ? rtcNewDevice(config) : NULL;
	if (!state->device) {
		enum RTCError error = state->team ? rtcGetDeviceError(NULL) : RTC_ERROR_OUT_OF_MEMORY;
		if (error == RTC_ERROR_OUT_OF_MEMORY)
			return stilb_fail(
				STILB_ERROR_MEMORY,
				"no memory to start Embree; raise the limit that 'ulimit -v' shows, or give fewer --workers");
		return stilb_fail(STILB_ERROR_DEVICE, "Embree does not start on this machine (error %d)", (int)error);
	}
	if (state->gi->flagged && rtcGetDeviceProperty(state->device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) == 0)
		return stilb_fail(STILB_ERROR_DEVICE,
		                  "Embree was built without ray masks, which models that are unseen or cast "
		                  "no shadow need");
	rtcSetDeviceErrorFunction(state->device, embree_on_error, state);
	rtcSetDeviceMemoryMonitorFunction(state->device, embree_on_memory, state);
	return STILB_OK;
}

/* ---- building ---------------------------------------------------------------------------------------------------- */

typedef struct embree_help {
	gi_embree_team *team;
	_Atomic uint32_t begun; /* helpers that have; relaxed: they only get different numbers */
} embree_help;

static void embree_help_build(void *data, uint32_t worker)
{
	PROFILE("gi.help");
	(void)worker;
	embree_help *help = data;
	gi_embree_team_help(help->team, atomic_fetch_add_explicit(&help->begun, 1, memory_order_relaxed));
}

/* Builds the tree of an Embree scene of so many primitives; every thread of the pool helps, by a job pinned to it.
 * Where there is no memory for such a job, its thread does not take part. */
static void embree_commit(embree *state, RTCScene scene, uint64_t primitives)
{
	PROFILE("gi.build");
	const stilb_gi_scene_desc *desc = state->desc;
	stilb_job_group group = {0};
	embree_help help = {.team = state->team};
	uint32_t first = desc->caller == STILB_JOB_OUTSIDE ? 2 : 1; /* as many threads as the pool has workers */
	uint32_t workers = stilb_job_pool_worker_count(desc->pool) + 1;
	workers = workers < state->workers ? workers : state->workers; /* an update may come with another pool */
	if (embree_is_given_up(state))
		return;
	rtcSetSceneProgressMonitorFunction(scene, desc->give_up ? embree_on_progress : NULL, state);
	bool helped = primitives >= EMBREE_ALONE && workers > first && gi_embree_team_call(state->team);
	for (uint32_t worker = first; worker < workers && helped; worker++) {
		stilb_job_options options = {.pinned = true, .target = worker};
		stilb_job_submit_with(desc->pool, embree_help_build, &help, &group, &options, desc->caller);
	}
	if (!gi_embree_team_commit(state->team, scene))
		embree_on_error(state, RTC_ERROR_OUT_OF_MEMORY, NULL);
	stilb_job_wait(desc->pool, &group, desc->caller);
}

static RTCScene embree_scene(embree *state)
{
	RTCScene scene = rtcNewScene(state->device);
	rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
	rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
	return scene;
}

static void embree_attach(RTCScene scene, RTCGeometry geometry, uint32_t id)
{
	rtcCommitGeometry(geometry);
	rtcAttachGeometryByID(scene, geometry, id);
	rtcReleaseGeometry(geometry);
}

/* mask: GI_MASK_... of the rays that meet it. */
static void embree_attach_mesh(embree *state, RTCScene scene, const gi_mesh *mesh, uint32_t mask, uint32_t id)
{
	STILB_ASSERT(mesh->triangle_count > 0 && "Embree gets no empty geometry");
	RTCGeometry geometry = rtcNewGeometry(state->device, RTC_GEOMETRY_TYPE_TRIANGLE);
	rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->vertices, 0,
	                           sizeof *mesh->vertices, mesh->vertex_count);
	rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
	                           sizeof *mesh->triangles, mesh->triangle_count);
	rtcSetGeometryMask(geometry, mask);
	if (mesh->sieved) {
		rtcSetGeometryUserData(geometry, (void *)state->gi);
		rtcSetGeometryIntersectFilterFunction(geometry, embree_filter);
		rtcSetGeometryOccludedFilterFunction(geometry, embree_filter);
	}
	embree_attach(scene, geometry, id);
}

/* A slice of the small trees: one after the other, by a team of this thread alone, which wakes no other. */
static void embree_commit_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("gi.build");
	embree *state = context;
	gi_embree_team *team = gi_embree_team_create(1);
	(void)worker;
	if (!team)
		embree_on_error(state, RTC_ERROR_OUT_OF_MEMORY, NULL);
	for (uint32_t i = begin; i < end && team && !embree_is_given_up(state); i++) {
		RTCScene scene = state->shared[state->small[i]];
		rtcSetSceneProgressMonitorFunction(scene, state->desc->give_up ? embree_on_progress : NULL, state);
		if (!gi_embree_team_commit(team, scene))
			embree_on_error(state, RTC_ERROR_OUT_OF_MEMORY, NULL);
	}
	gi_embree_team_destroy(team);
}

/* True if the part is an instance of a mesh that has no tree yet. */
static bool embree_lacks_tree(const embree *state, const stilb_gi_scene *gi, const gi_part *part)
{
	STILB_ASSERT(part->mesh < state->mesh_count);
	return (part->instance || state->movable) && !part->hidden && gi->meshes[part->mesh].triangle_count > 0 &&
	       !state->shared[part->mesh];
}

/* Builds the trees of the meshes that parts are instances of, those that are not there. parts: their indices; NULL: all
 * from 0 on. */
static void embree_share(embree *state, const stilb_gi_scene *gi, const uint32_t *parts, uint32_t count)
{
	const stilb_gi_scene_desc *desc = state->desc;
	uint32_t small = 0;
	for (uint32_t i = 0; i < count && !embree_is_given_up(state); i++) {
		const gi_part *part = &gi->parts[parts ? parts[i] : i];
		if (!embree_lacks_tree(state, gi, part))
			continue;
		const gi_mesh *mesh = &gi->meshes[part->mesh];
		state->shared[part->mesh] = embree_scene(state);
		embree_attach_mesh(state, state->shared[part->mesh], mesh, GI_MASK_ALL, 0);
		if (mesh->triangle_count < EMBREE_ALONE)
			state->small[small++] = part->mesh;
		else
			embree_commit(state, state->shared[part->mesh], mesh->triangle_count);
	}
	stilb_job_group group = {0};
	if (small == 1 ||
	    stilb_job_submit_array(desc->pool, small, 1, embree_commit_slice, state, &group, desc->caller) != 0)
		embree_commit_slice(0, small, 0, state);
	stilb_job_wait(desc->pool, &group, desc->caller);
}

/* Gives an instance of a part its tree and its place. */
static void embree_place(const embree *state, RTCGeometry geometry, const gi_part *part)
{
	STILB_ASSERT(part->mesh < state->mesh_count && state->shared[part->mesh] && "the mesh has a tree of its own");
	stilb_mat4 place = part->instance ? part->to_world : stilb_mat4_identity();
	rtcSetGeometryInstancedScene(geometry, state->shared[part->mesh]);
	rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, place.m);
	rtcSetGeometryMask(geometry, part->mask);
}

static void embree_attach_instance(embree *state, const gi_part *part, uint32_t id)
{
	RTCGeometry geometry = rtcNewGeometry(state->device, RTC_GEOMETRY_TYPE_INSTANCE);
	embree_place(state, geometry, part);
	embree_attach(state->scene, geometry, id);
}

/* Shows a part of the scene in Embree's scene, whose tree the caller builds, as it is now: also if it was another way
 * before, or not there. */
static void embree_show(embree *state, const stilb_gi_scene *gi, uint32_t id)
{
	const gi_part *part = &gi->parts[id];
	const gi_mesh *mesh = &gi->meshes[part->mesh];
	bool shown = !part->hidden && mesh->triangle_count > 0, before = state->attached[id];
	state->attached[id] = shown;
	if (!shown) {
		if (before)
			rtcDetachGeometry(state->scene, id);
		return;
	}
	if (!part->instance && !state->movable) {
		STILB_ASSERT((!before || mesh->fresh) && "where nothing moves");
		if (before)
			rtcDetachGeometry(state->scene, id);
		embree_attach_mesh(state, state->scene, mesh, part->mask, id);
		return;
	}
	if (!before) {
		embree_attach_instance(state, part, id);
		return;
	}
	RTCGeometry geometry = rtcGetGeometry(state->scene, id);
	embree_place(state, geometry, part);
	rtcCommitGeometry(geometry);
}

/* Builds the scene's tree, and says how. */
static stilb_result embree_build(embree *state, uint64_t begin, gi_tracer *tracer, stilb_gi_scene_info *info)
{
	state->sieved = false;
	for (uint32_t i = 0; i < state->mesh_count && !state->sieved; i++)
		state->sieved = state->gi->meshes[i].sieved;
	bool instances = state->movable;
	for (uint32_t i = 0; i < state->part_count && !instances; i++)
		instances = state->parts[i].instance;
	embree_commit(state, state->scene, UINT64_MAX);
	info->build_s = (double)(stilb_time_ns() - begin) * 1e-9;
	info->bytes += (uint64_t)atomic_load_explicit(&state->bytes, memory_order_relaxed);
	tracer->intersect = instances ? embree_intersect_instances : embree_intersect;
	tracer->intersect16 = instances ? embree_intersect16_instances : embree_intersect16;
	tracer->occluded = embree_occluded;
	state->desc = NULL;
	return embree_result(state);
}

static stilb_result embree_create(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                                  stilb_gi_scene_info *info)
{
	STILB_ASSERT(!tracer->state && "a tracer is created once");
	STILB_ASSERT(desc->pool);
	stilb_gi_isa isa = desc->isa;
	uint64_t begin = stilb_time_ns();
	stilb_result result = embree_isa(&isa);
	if (result != STILB_OK)
		return result;
	embree *state = calloc(1, sizeof *state);
	RTCScene *shared = calloc((size_t)gi->mesh_count + 1, sizeof *shared);
	uint32_t *small = calloc((size_t)gi->mesh_count + 1, sizeof *small);
	bool *attached = calloc((size_t)gi->part_count + 1, sizeof *attached);
	if (!state || !shared || !small || !attached) {
		free(state);
		free(shared);
		free(small);
		free(attached);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u meshes", gi->mesh_count);
	}
	*state = (embree){.shared = shared,
	                  .small = small,
	                  .mesh_count = gi->mesh_count,
	                  .gi = gi,
	                  .parts = gi->parts,
	                  .attached = attached,
	                  .part_count = gi->part_count,
	                  .workers = stilb_job_pool_worker_count(desc->pool) + 1,
	                  .movable = desc->movable,
	                  .desc = desc,
	                  .bytes_max = desc->memory ? (int64_t)desc->memory : embree_memory()};
	tracer->state = state;
	info->isa = embree_isa_names[isa];
	result = embree_device(state, info->isa);
	if (result != STILB_OK)
		return result;
	state->scene = embree_scene(state);
	embree_share(state, gi, NULL, gi->part_count);
	for (uint32_t i = 0; i < gi->part_count && !embree_is_given_up(state); i++)
		embree_show(state, gi, i);
	return embree_build(state, begin, tracer, info);
}

/* stilb_gi_intersector.update */
static stilb_result embree_update(const stilb_gi_scene *gi, const uint32_t *moved, uint32_t moved_count,
                                  const stilb_gi_scene_desc *desc, gi_tracer *tracer, stilb_gi_scene_info *info)
{
	embree *state = tracer->state;
	STILB_ASSERT(state->parts == gi->parts && "parts stay where they are");
	uint64_t begin = stilb_time_ns();
	state->desc = desc;
	for (uint32_t i = 0; i < moved_count; i++) {
		uint32_t mesh = gi->parts[moved[i]].mesh;
		if (!gi->meshes[mesh].fresh || !state->shared[mesh])
			continue;
		rtcReleaseScene(state->shared[mesh]);
		state->shared[mesh] = NULL;
	}
	embree_share(state, gi, moved, moved_count);
	for (uint32_t i = 0; i < moved_count && !embree_is_given_up(state); i++)
		embree_show(state, gi, moved[i]);
	return embree_build(state, begin, tracer, info);
}

static void embree_destroy(gi_tracer *tracer)
{
	embree *state = tracer->state;
	if (!state)
		return;
	if (state->scene)
		rtcReleaseScene(state->scene);
	for (uint32_t mesh = 0; mesh < state->mesh_count; mesh++)
		if (state->shared[mesh])
			rtcReleaseScene(state->shared[mesh]);
	if (state->device)
		rtcReleaseDevice(state->device);
	gi_embree_team_destroy(state->team);
	free(state->shared);
	free(state->small);
	free(state->attached);
	free(state);
	*tracer = (gi_tracer){0};
}

const stilb_gi_intersector stilb_gi_embree = {
	.name = "embree", .create = embree_create, .update = embree_update, .destroy = embree_destroy};

stilb_gi_scene_desc stilb_gi_scene_desc_default(stilb_job_pool *pool)
{
	return (stilb_gi_scene_desc){.pool = pool, .intersector = &stilb_gi_embree, .isa = STILB_GI_ISA_AUTO};
}

const char *stilb_gi_library_version(void)
{
	return RTC_VERSION_STRING;
}

RTCScene gi_embree_scene(const stilb_gi_scene *scene)
{
	STILB_ASSERT(scene->intersector == &stilb_gi_embree);
	const embree *state = scene->tracer.state;
	return state->scene;
}
