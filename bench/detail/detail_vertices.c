/* Cases of the suite `lod`: packed vertices beside floats, and the memory that levels take. */
#include "bench/detail/detail_run.h"

#include "geometry/geometry_levels.h"
#include "render/render.h"
#include "scene/scene.h"
#include "scene/scene_build.h"

#include <malloc.h>
#include <math.h>
#include <string.h>

#define MOST_ROUNDS 64u

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

typedef struct drawn {
	stilb_scene *scene;
	uint32_t *ids; /* [scene->model_count] all */
	stilb_job_pool *pool;
	stilb_render *render;
	stilb_render_view view;
} drawn;

/* A renderer that shows the scene. */
static void drawn_open(drawn *d, stilb_render_desc desc)
{
	desc.context_count = stilb_job_pool_worker_count(d->pool) + 1;
	check(stilb_render_create(&desc, &d->render));
	check(stilb_render_set_scene(d->render, d->scene));
	d->view.lights = d->scene->lights;
	d->view.light_count = d->scene->light_count;
	d->view.surroundings = d->scene->surroundings;
	d->view.shading = stilb_render_shading_default();
}

/* turned: the camera looks away. */
static void drawn_look(drawn *d, stilb_scene_camera camera, bool turned)
{
	uint32_t width, height;
	stilb_render_size(d->render, &width, &height);
	camera.yaw += turned ? 3.14159265f : 0.0f;
	d->view.view_projection = stilb_scene_camera_matrix(&camera, (float)width / (float)height);
	memcpy(d->view.camera_position, camera.position, sizeof camera.position);
}

/* CPU time of a frame of all models, ms. */
static double drawn_frame(drawn *d, stilb_render_detail_mode mode)
{
	static const stilb_render_pass pass = {.name = "scene"};
	double start = detail_cpu_ms();
	d->view.detail = (stilb_render_detail){mode, 0.5f};
	check(stilb_render_frame_begin(d->render));
	check(stilb_render_record_view(d->render, 0, d->scene, d->ids, d->scene->model_count, &d->view, d->pool, 0));
	check(stilb_render_replay(d->render, &pass, 1, &d->view, 1, d->pool, 0));
	check(stilb_render_wait(d->render));
	return detail_cpu_ms() - start;
}

static void drawn_all(drawn *d)
{
	d->ids = stilb_memory_alloc(d->scene->model_count, sizeof *d->ids);
	if (!d->ids)
		bench_child_fail("no memory");
	for (uint32_t m = 0; m < d->scene->model_count; m++)
		d->ids[m] = m;
}

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no threads");
	return pool;
}

/* ---- one mesh ---------------------------------------------------------------------------------------------------- */

static stilb_scene *scene_of(const stilb_scene_mesh *mesh)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material material = {.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 0.6f};
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, mesh), stilb_scene_build_material(build, &material)};
	stilb_mat4 place = stilb_mat4_identity();
	stilb_scene *scene;
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	check(stilb_scene_build_end(build, &scene));
	return scene;
}

/* rings x segments vertices on a bumpy sphere, with uv. */
static stilb_scene_mesh bumpy(uint32_t rings, uint32_t segments)
{
	stilb_scene_mesh mesh = {.vertex_count = rings * segments, .index_count = (rings - 1) * (segments - 1) * 6};
	mesh.vertices = stilb_memory_alloc(mesh.vertex_count, sizeof *mesh.vertices);
	mesh.indices = stilb_memory_alloc(mesh.index_count, sizeof *mesh.indices);
	if (!mesh.vertices || !mesh.indices)
		bench_child_fail("no memory for a mesh");
	uint32_t *out = mesh.indices;
	for (uint32_t r = 0; r < rings; r++)
		for (uint32_t s = 0; s < segments; s++) {
			float u = (float)s / (float)(segments - 1), v = (float)r / (float)(rings - 1);
			float a = 6.2831853f * u, b = 3.1415927f * v, radius = 1.0f + 0.03f * sinf(40.0f * a) * sinf(40.0f * b);
			stilb_vec3 n = stilb_vec3_make(sinf(b) * sinf(a), cosf(b), sinf(b) * cosf(a));
			mesh.vertices[r * segments + s] =
				(stilb_scene_vertex){{radius * n[0], radius * n[1], radius * n[2]}, {n[0], n[1], n[2]}, {u, v}};
			if (r + 1 == rings || s + 1 == segments)
				continue;
			uint32_t i = r * segments + s, square[6] = {i, i + segments, i + 1, i + 1, i + segments, i + segments + 1};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	return mesh;
}

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

/* Floats and packed vertices, frame by frame in turns; `models`: thousands of the mesh's triangles. */
void detail_run_vertices(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	uint32_t rows = (uint32_t)sqrt(500.0 * models);
	stilb_scene_mesh mesh = bumpy(rows, rows);
	stilb_scene_camera camera = {.position = {0.0f, 0.0f, 3.0f}, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};
	drawn d[2] = {0};
	double upload[2], frames[2][MOST_ROUNDS], away[2][MOST_ROUNDS];
	for (int packed = 0; packed < 2; packed++) {
		d[packed].scene = scene_of(&mesh);
		d[packed].pool = make_pool(1);
		drawn_all(&d[packed]);
		double start = detail_cpu_ms();
		drawn_open(&d[packed],
		           (stilb_render_desc){.width = width, .height = height, .samples = 1, .float_vertices = !packed});
		drawn_look(&d[packed], camera, true);
		drawn_frame(&d[packed], STILB_RENDER_DETAIL_OFF);
		upload[packed] = detail_cpu_ms() - start;
		/* A scene once more, now that the pipelines are there. */
		start = detail_cpu_ms();
		check(stilb_render_set_scene(d[packed].render, d[packed].scene));
		double frame = drawn_frame(&d[packed], STILB_RENDER_DETAIL_OFF);
		upload[packed] = detail_cpu_ms() - start;
		frame = drawn_frame(&d[packed], STILB_RENDER_DETAIL_OFF);
		upload[packed] -= frame;
	}
	uint32_t rounds = 0;
	for (double spent = 0.0; rounds < 5 || (spent < 1e3 * child->seconds && rounds < MOST_ROUNDS); rounds++)
		for (int i = 0; i < 2; i++) {
			int packed = (i + (int)rounds) % 2;
			drawn_look(&d[packed], camera, false);
			spent += frames[packed][rounds] = drawn_frame(&d[packed], STILB_RENDER_DETAIL_OFF);
			drawn_look(&d[packed], camera, true);
			spent += away[packed][rounds] = drawn_frame(&d[packed], STILB_RENDER_DETAIL_OFF);
		}
	double floats = detail_median(frames[0], rounds), packs = detail_median(frames[1], rounds);
	double away_floats = detail_median(away[0], rounds), away_packs = detail_median(away[1], rounds);
	bench_child_metric("floats", floats);
	bench_child_metric("packed", packs);
	bench_child_metric("packed/floats", packs / floats);
	bench_child_metric("away-floats", 1e6 * away_floats / (double)mesh.vertex_count);
	bench_child_metric("away-packed", 1e6 * away_packs / (double)mesh.vertex_count);
	bench_child_metric("upload-floats", upload[0]);
	bench_child_metric("upload-packed", upload[1]);
	for (int i = 0; i < 2; i++) {
		stilb_render_destroy(d[i].render);
		stilb_job_pool_destroy(d[i].pool);
		stilb_scene_destroy(d[i].scene);
		free(d[i].ids);
	}
	stilb_scene_mesh_finish(&mesh);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* MiB that malloc has given out. */
static double heap_mib(void)
{
	struct mallinfo2 info = mallinfo2();
	return (double)(info.uordblks + info.hblkhd) / 1048576.0;
}

/* The stress test, or without models a mesh of a million triangles. levels: with them. */
static stilb_scene *memory_scene(uint32_t models, bool levels)
{
	stilb_scene *scene;
	if (models > 0) {
		check(stilb_scene_create_stress(models, 1, &scene));
		return scene;
	}
	stilb_scene_mesh mesh = bumpy(709, 709);
	stilb_job_pool *pool = make_pool(1);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	if (levels)
		check(stilb_geometry_levels(&mesh, &desc, pool, 0));
	stilb_job_pool_destroy(pool);
	scene = scene_of(&mesh);
	stilb_scene_mesh_finish(&mesh);
	return scene;
}

/* Memory of scene and renderer on the null device, whose frames' memory stands for a device's. */
void detail_run_memory(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	static const struct {
		const char *name;
		stilb_render_detail_mode mode;
		bool levels;
	} runs[] = {
		{"off", STILB_RENDER_DETAIL_OFF, false}, /* once more below: what is made once in a process is there then */
		{"off", STILB_RENDER_DETAIL_OFF, false},
		{"pop", STILB_RENDER_DETAIL_POP, true},
		{"morph", STILB_RENDER_DETAIL_MORPH, true}};
	double off = 0.0;
	(void)child;
	for (size_t r = 0; r < sizeof runs / sizeof *runs; r++) {
		drawn d = {.pool = make_pool(1)};
		char metric[32];
		double start = heap_mib();
		d.scene = memory_scene(models, runs[r].levels);
		double scene = heap_mib() - start;
		drawn_all(&d);
		start = heap_mib();
		drawn_open(&d, (stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL,
		                                   .width = width,
		                                   .height = height,
		                                   .samples = 1,
		                                   .morph = runs[r].mode == STILB_RENDER_DETAIL_MORPH});
		drawn_look(&d, d.scene->camera, false);
		for (int frame = 0; frame < 4; frame++)
			drawn_frame(&d, runs[r].mode);
		double all = scene + heap_mib() - start;
		off = r == 1 ? all : off;
		if (r > 0) {
			snprintf(metric, sizeof metric, "scene-%s", runs[r].name);
			bench_child_metric(metric, scene);
			bench_child_metric(runs[r].name, all);
			snprintf(metric, sizeof metric, "more-%s", runs[r].name);
		}
		if (r > 1)
			bench_child_metric(metric, 100.0 * (all / off - 1.0));
		stilb_render_destroy(d.render);
		stilb_job_pool_destroy(d.pool);
		stilb_scene_destroy(d.scene);
		free(d.ids);
	}
}
