/* Nothing shows through where clusters meet: a closed body of some 20,000 triangles, with clusters of engine/geometry,
 * in views from all around and from near its surface, beside the body in full. The number of views is the argument. */
#include "geometry/geometry_levels.h"
#include "render/render_internal.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 160u
#define EDGE 3 /* pixels: silhouettes may differ by the error, which is at most 2 */

static uint32_t view_count = 50;
static stilb_job_pool *pool;
static stilb_scene *scene;
static stilb_render *render;

static float random_between(uint64_t number, float low, float high)
{
	return low + (high - low) * stilb_random_float(5, number);
}

/* A sphere with bumps, stretched and sheared in the scene. */
static int scene_make(void **state)
{
	(void)state;
	static const stilb_mat4 place = {{1.0f, 0.2f, 0, 0, 0, 1.3f, 0, 0, 0.3f, 0, 0.8f, 0, 0, 0, 0, 1}};
	stilb_job_pool_desc workers = {.worker_count = 1};
	stilb_render_desc desc = {.width = SIDE, .height = SIDE, .samples = 1, .context_count = 2};
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_job_pool_create(&workers, &pool), 0);
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		float *p = mesh.vertices[v].position;
		float size = 1.0f + 0.06f * sinf(9.0f * p[0]) * sinf(7.0f * p[1] + 1.0f) * sinf(8.0f * p[2] + 2.0f);
		for (int i = 0; i < 3; i++)
			p[i] *= size;
	}
	stilb_geometry_levels_desc levels = stilb_geometry_levels_desc_default();
	levels.cluster_least = 500;
	if (stilb_geometry_levels(&mesh, &levels, pool, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(mesh.group_count > 10 && mesh.level_count > 0);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material paint = {.diffuse = {0.6f, 0.3f, 0.2f}, .roughness = 1.0f, .emission = {0.2f, 0.2f, 0.2f}};
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &paint)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	stilb_scene_mesh_finish(&mesh);
	if (stilb_scene_build_end(build, &scene) != STILB_OK || stilb_render_create(&desc, &render) != STILB_OK ||
	    stilb_render_set_scene(render, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return 0;
}

static int scene_free(void **state)
{
	(void)state;
	stilb_render_destroy(render);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
	return 0;
}

/* From a random side and distance, a little past the middle. */
static stilb_scene_camera camera_of(uint32_t number)
{
	uint64_t n = 16 * (uint64_t)number;
	float d[3] = {random_between(n, -1, 1), random_between(n + 1, -1, 1), random_between(n + 2, -1, 1)};
	float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + 1e-3f;
	float near = random_between(n + 3, 0.0f, 1.0f), far = 1.5f + 4.0f * near * near * near;
	stilb_scene_camera camera = {.fov_y = random_between(n + 4, 0.3f, 1.6f), .near_z = 0.01f, .far_z = 100.0f};
	for (int i = 0; i < 3; i++)
		camera.position[i] = far * d[i] / length;
	camera.yaw = atan2f(d[0], d[2]) + random_between(n + 5, -0.4f, 0.4f);
	camera.pitch = -asinf(d[1] / length) + random_between(n + 6, -0.4f, 0.4f);
	return camera;
}

/* Draws the body and takes the coverage of each pixel. Returns its triangles. */
static uint64_t cover(const stilb_render_view *view, bool covered[SIDE][SIDE])
{
	static const stilb_render_pass pass = {.name = "body"};
	static const uint32_t id = 0;
	stilb_image image;
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record_view(render, 0, scene, &id, 1, view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	assert_int_equal(image.channels, 4);
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++)
			covered[y][x] = ((const uint8_t *)image.pixels)[4 * (y * SIDE + x) + 3] > 0;
	stilb_image_finish(&image);
	return stilb_render_triangles(render);
}

/* True if the body in full covers all pixels around, and there are some. */
static bool is_inside(bool full[SIDE][SIDE], int x, int y)
{
	for (int j = y - EDGE; j <= y + EDGE; j++)
		for (int i = x - EDGE; i <= x + EDGE; i++)
			if (i >= 0 && j >= 0 && i < (int)SIDE && j < (int)SIDE && !full[j][i])
				return false;
	return true;
}

static void nothing_shows_through(void **state)
{
	(void)state;
	static bool full[SIDE][SIDE], cut[SIDE][SIDE];
	uint64_t inside = 0;
	uint32_t mixed = 0;
	for (uint32_t v = 0; v < view_count; v++) {
		stilb_scene_camera camera = camera_of(v);
		stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, 1.0f),
		                          .backdrop = {.kind = STILB_SCENE_BACKDROP_NOTHING},
		                          .shading = stilb_render_shading_default()};
		memcpy(view.camera_position, camera.position, sizeof view.camera_position);
		uint64_t all = cover(&view, full);
		view.detail.mode = v % 2 ? STILB_RENDER_DETAIL_POP : STILB_RENDER_DETAIL_FADE;
		view.detail.error = 0.05f * powf(40.0f, random_between(16 * (uint64_t)v + 7, 0.0f, 1.0f));
		uint64_t some = cover(&view, cut);
		mixed += stilb_render_stats_get(render).draws > 2;
		assert_true(some <= all);
		for (uint32_t y = 0; y < SIDE; y++)
			for (uint32_t x = 0; x < SIDE; x++) {
				if (!is_inside(full, (int)x, (int)y))
					continue;
				inside++;
				if (!cut[y][x])
					fail_msg("view %u, %g pixels: a hole at %u, %u", v, (double)view.detail.error, x, y);
			}
	}
	assert_true(inside > (uint64_t)view_count * SIDE * SIDE / 4);
	assert_true(mixed > view_count / 2);
}

int main(int argc, char **argv)
{
	if (argc > 1)
		view_count = (uint32_t)strtoul(argv[1], NULL, 10);
	const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_shows_through)};
	return cmocka_run_group_tests(tests, scene_make, scene_free);
}
