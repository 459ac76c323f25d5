/* Times the building of the tree: by the renderer's workers, and by Embree with threads of its own. */
#include "bench/gi/gi_run.h"
#include "gi/gi_scene_internal.h"

#include <embree3/rtcore.h>

#include <dirent.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Bytes that Embree has allocated; relaxed: it is read when the build's threads are done. */
static _Atomic int64_t embree_bytes;

static bool embree_on_memory(void *user, ssize_t bytes, bool post)
{
	(void)user;
	(void)post;
	atomic_fetch_add_explicit(&embree_bytes, bytes, memory_order_relaxed);
	return true;
}

/* Least time, seconds, memory of the tree and of what it was made of, bytes. */
typedef struct built {
	double seconds, bytes;
} built;

/* rtcCommitScene on Embree's own threads, one for each CPU, of the same vertices and with the same flags. */
static built embree_build(const stilb_scene *scene)
{
	char config[64];
	snprintf(config, sizeof config, "threads=%u", bench_child_cpu_count());
	RTCDevice device = rtcNewDevice(config);
	rtcSetDeviceMemoryMonitorFunction(device, embree_on_memory, NULL);
	RTCScene tree = rtcNewScene(device);
	rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
	built b = {0};
	for (uint32_t i = 0; i < scene->part_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[i]];
		RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
		rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->vertices, 0,
		                           sizeof *mesh->vertices, mesh->vertex_count);
		rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
		                           3 * sizeof *mesh->indices, mesh->index_count / 3);
		rtcCommitGeometry(g);
		rtcAttachGeometryByID(tree, g, i);
		rtcReleaseGeometry(g);
		b.bytes += (double)(sizeof *mesh->vertices * mesh->vertex_count + sizeof *mesh->indices * mesh->index_count);
	}
	uint64_t begin = bench_child_now_ns();
	rtcCommitScene(tree);
	b.seconds = 1e-9 * (double)(bench_child_now_ns() - begin);
	b.bytes += (double)atomic_load_explicit(&embree_bytes, memory_order_relaxed);
	rtcReleaseScene(tree);
	rtcReleaseDevice(device);
	return b;
}

/* Threads of this process now. */
static uint32_t thread_count(void)
{
	uint32_t count = 0;
	DIR *tasks = opendir("/proc/self/task");
	for (const struct dirent *entry; tasks && (entry = readdir(tasks));)
		count += entry->d_name[0] != '.';
	if (tasks)
		closedir(tasks);
	return count;
}

/* The renderer's build. *extra: threads that there are besides the pool's and this one. */
static built own_build(const stilb_scene *scene, uint32_t rings, uint32_t *extra)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = bench_child_cpu_count() - 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("cannot start worker threads");
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_scene *gi;
	uint32_t before = thread_count();
	gi_run_check(stilb_gi_scene_create(scene, &gi_desc, &gi), "the scene");
	*extra = thread_count() - before;
	const stilb_gi_scene_info *info = stilb_gi_scene_info_of(gi);
	if (info->triangles != 108ull * rings * rings + 12)
		bench_child_fail("wrong result: the scene has %llu triangles", (unsigned long long)info->triangles);
	built b = {info->build_s, (double)info->bytes};
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
	return b;
}

void gi_run_build(const bench_child *child)
{
	static const struct {
		const char *name;
		uint32_t rings;
	} sizes[] = {{"build-100k", 30}, {"build", 98}, {"build-10m", 304}};
	uint32_t rings = 0, extra = 0;
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
		if (strcmp(child->case_name, sizes[i].name) == 0)
			rings = sizes[i].rings;
	stilb_scene *scene = gi_run_balls(rings);
	/* The least time of each counts: every build is the same work, so longer times are disturbances. The renderer's is
	 * the first, so that threads of Embree's own are not there yet. */
	built own = own_build(scene, rings, &extra), theirs = embree_build(scene);
	double spent = own.seconds + theirs.seconds;
	for (uint32_t turn = 1, ignored; turn < 3 || spent < child->seconds; turn++) {
		double a = own_build(scene, rings, &ignored).seconds;
		double b = embree_build(scene).seconds;
		own.seconds = fmin(own.seconds, a);
		theirs.seconds = fmin(theirs.seconds, b);
		spent += a + b;
	}
	stilb_scene_destroy(scene);
	bench_child_metric("stilb", 1e3 * own.seconds);
	bench_child_metric("embree", 1e3 * theirs.seconds);
	bench_child_metric("ratio", own.seconds / theirs.seconds);
	bench_child_metric("memory", own.bytes / theirs.bytes);
	bench_child_metric("threads", extra);
}
