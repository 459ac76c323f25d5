/* Times the building of the tree: by the renderer's workers, and by Embree with threads of its own. */
#include "bench/gi/gi_run.h"
#include "gi/gi_scene_internal.h"

#include <embree3/rtcore.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
