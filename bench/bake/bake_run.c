/* The program of the suite `bake`. One thread and two must find the same. */
#include "bake/bake_pack.h"
#include "bake/bake_texels.h"
#include "bench/bake/bake_cases.h"
#include "bench/harness/bench_child.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <string.h>

static uint64_t cpu_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no worker starts");
	return pool;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static void place_land(float s, float t, float p[3])
{
	p[0] = 2.0f * s;
	p[1] = 0.15f * sinf(9.0f * s + 2.0f * t) + 0.1f * cosf(14.0f * t - 3.0f * s * s) + 0.04f * sinf(50.0f * s * t);
	p[2] = -2.0f * t;
}

/* A trefoil; the tube's frame is not turned evenly, which does not matter. */
static void place_knot(float s, float t, float p[3])
{
	float a = 6.2831853f * (s < 1.0f ? s : 0.0f), b = 6.2831853f * (t < 1.0f ? t : 0.0f);
	float center[3] = {sinf(a) + 2.0f * sinf(2.0f * a), cosf(a) - 2.0f * cosf(2.0f * a), -sinf(3.0f * a)};
	float along[3] = {cosf(a) + 4.0f * cosf(2.0f * a), -sinf(a) + 4.0f * sinf(2.0f * a), -3.0f * cosf(3.0f * a)};
	float r = 0.4f + 0.02f * sinf(7.0f * b) * sinf(60.0f * a), flat = hypotf(along[0], along[1]);
	float length = hypotf(flat, along[2]);
	float x[3] = {along[1] / flat, -along[0] / flat, 0.0f};
	float y[3] = {along[0] * along[2] / (flat * length), along[1] * along[2] / (flat * length), -flat / length};
	for (int k = 0; k < 3; k++)
		p[k] = center[k] + r * (cosf(b) * x[k] + sinf(b) * y[k]);
}

/* A scene of one part: w x h squares of two triangles. */
static stilb_scene *grid(uint32_t w, uint32_t h, void (*place)(float s, float t, float p[3]))
{
	stilb_scene *scene;
	if (scene_create(1, 1, 1, 1, &scene) != STILB_OK ||
	    scene_mesh_create(&scene->meshes[0], (w + 1) * (h + 1), 6 * w * h) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	scene->first_part[1] = 1;
	scene->part_mesh[0] = scene->part_material[0] = 0;
	scene->part_transform[0] = stilb_mat4_identity();
	stilb_scene_mesh *mesh = &scene->meshes[0];
	uint32_t *out = mesh->indices;
	for (uint32_t j = 0; j <= h; j++)
		for (uint32_t i = 0; i <= w; i++)
			place((float)i / (float)w, (float)j / (float)h, mesh->vertices[j * (w + 1) + i].position);
	for (uint32_t j = 0; j < h; j++)
		for (uint32_t i = 0; i < w; i++) {
			uint32_t a = j * (w + 1) + i, b = a + 1, c = a + w + 1, d = c + 1;
			const uint32_t square[6] = {a, b, c, b, d, c};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	return scene;
}

/* ---- cases ------------------------------------------------------------------------------------------------------- */

static stilb_bake_uv unwrap(const stilb_bake_mesh *mesh, stilb_job_pool *pool)
{
	stilb_bake_uv uv;
	if (stilb_bake_unwrap(mesh, NULL, pool, 0, &uv) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	return uv;
}

/* The least of several times each, in turn. */
static void run_unwrap(const bench_child *child, const stilb_scene *scene)
{
	const stilb_scene_mesh *from = &scene->meshes[0];
	stilb_bake_mesh mesh = {from->vertices->position, sizeof *from->vertices, from->indices, from->vertex_count,
	                        from->index_count / 3};
	stilb_job_pool *one = pool_of(0), *other = pool_of(1);
	double core = HUGE_VAL, two = HUGE_VAL, stretch = 0.0;
	uint32_t charts = 0;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 2 || bench_child_now_ns() < end; i++) {
		uint64_t start = cpu_ns();
		stilb_bake_uv alone = unwrap(&mesh, one);
		core = fmin(core, (double)(cpu_ns() - start));
		start = bench_child_now_ns();
		stilb_bake_uv both = unwrap(&mesh, other);
		two = fmin(two, (double)(bench_child_now_ns() - start));
		if (memcmp(alone.corners, both.corners, 3 * (size_t)alone.triangle_count * sizeof *alone.corners) != 0)
			bench_child_fail("two threads find other places than one");
		stretch = stilb_bake_stretch(&mesh, &alone);
		charts = alone.chart_count;
		stilb_bake_uv_finish(&alone);
		stilb_bake_uv_finish(&both);
	}
	bench_child_metric("core", core * 1e-6);
	bench_child_metric("two", two * 1e-6);
	bench_child_metric("stretch", stretch);
	bench_child_metric("charts", charts);
	stilb_job_pool_destroy(one);
	stilb_job_pool_destroy(other);
}

static void run_pack(void)
{
	uint32_t count = 1000000, pages;
	stilb_bake_rect *rects = stilb_memory_alloc(count, sizeof *rects);
	if (!rects)
		bench_child_fail("no memory");
	for (uint32_t i = 0; i < count; i++)
		rects[i] = (stilb_bake_rect){.width = 7, .height = 7}; /* a texel with a border of 3 */
	uint64_t start = cpu_ns();
	if (stilb_bake_pack(rects, count, 4096, &pages) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	bench_child_metric("core", (double)(cpu_ns() - start) * 1e-6);
	bench_child_metric("pages", pages);
	free(rects);
}

static void run_texels(const bench_child *child, const stilb_scene *scene)
{
	stilb_job_pool *one = pool_of(0);
	stilb_bake_atlas *atlas;
	stilb_bake_atlas_options options = stilb_bake_atlas_options_default();
	options.side = 2048;
	if (stilb_bake_atlas_create(scene, &options, one, &atlas) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	double core = HUGE_VAL, covered = 0.0;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 2 || bench_child_now_ns() < end; i++) {
		stilb_bake_texels *texels;
		uint64_t start = cpu_ns();
		if (stilb_bake_texels_create(atlas, 0, one, &texels) != STILB_OK)
			bench_child_fail("%s", stilb_error_message());
		core = fmin(core, (double)(cpu_ns() - start));
		covered = (double)texels->covered;
		stilb_bake_texels_destroy(texels);
	}
	bench_child_metric("core", core * 1e-6);
	bench_child_metric("texels", covered / core * 1e3);
	stilb_bake_atlas_destroy(atlas);
	stilb_job_pool_destroy(one);
}

static void run(const bench_child *child, bake_case kind)
{
	stilb_scene *scene = kind == BAKE_KNOT    ? grid(1000, 50, place_knot)
	                     : kind == BAKE_LARGE ? grid(3, 3, place_land)
	                                          : grid(224, 224, place_land);
	if (kind == BAKE_PACK)
		run_pack();
	else if (kind == BAKE_LARGE || kind == BAKE_SMALL)
		run_texels(child, scene);
	else
		run_unwrap(child, scene);
	stilb_scene_destroy(scene);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, KIND)                                                                                        \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, KIND);                                                                                             \
		return 0;                                                                                                      \
	}
	BAKE_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
