/* Pictures of packed vertices beside floats, and of meshes whose indices have 16 and 32 bits beside the same with 16
 * alone. */
#include "render/render.h"
#include "scene/scene.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 320u
#define HEIGHT 180u
#define MODELS 100u

static stilb_render *make_render(bool float_vertices, stilb_render_replay_mode replay)
{
	stilb_render_desc desc = {.replay = replay,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .samples = 1,
	                          .context_count = 1,
	                          .float_vertices = float_vertices,
	                          .morph = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

/* The stress test's near models in a mode, from so far that many of them are in transition. */
static stilb_image picture_of(stilb_render *render, const stilb_scene *scene, stilb_render_detail_mode mode)
{
	static const stilb_render_pass pass = {.name = "scene"};
	uint32_t ids[MODELS];
	for (uint32_t m = 0; m < MODELS; m++)
		ids[m] = m;
	stilb_scene_camera camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, (float)WIDTH / HEIGHT);
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, (float)WIDTH / HEIGHT),
	                          .lights = scene->lights,
	                          .light_count = scene->light_count,
	                          .surroundings = scene->surroundings,
	                          .shading = stilb_render_shading_default(),
	                          .detail = {mode, 1.2f}};
	memcpy(view.camera_position, camera.position, sizeof camera.position);
	stilb_job_pool_desc none = {0};
	stilb_job_pool *pool;
	stilb_image image;
	assert_int_equal(stilb_job_pool_create(&none, &pool), 0);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record_view(render, 0, scene, ids, MODELS, &view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	stilb_job_pool_destroy(pool);
	return image;
}

/* Positions are the same, so each pixel shows the same triangle; its code differs by the normals' rounding alone. */
static void packed_vertices_look_the_same(void **state)
{
	(void)state;
	static const stilb_render_detail_mode modes[] = {STILB_RENDER_DETAIL_OFF, STILB_RENDER_DETAIL_MORPH};
	stilb_scene *scene;
	stilb_render *render[2] = {make_render(false, STILB_RENDER_REPLAY_INDIRECT),
	                           make_render(true, STILB_RENDER_REPLAY_INDIRECT)};
	assert_int_equal(stilb_scene_create_stress(MODELS, 1, &scene), STILB_OK);
	for (int r = 0; r < 2; r++)
		assert_int_equal(stilb_render_set_scene(render[r], scene), STILB_OK);
	for (int m = 0; m < 2; m++) {
		stilb_image images[2] = {picture_of(render[0], scene, modes[m]), picture_of(render[1], scene, modes[m])};
		const uint8_t *a = images[0].pixels, *b = images[1].pixels;
		uint32_t differ = 0;
		for (size_t i = 0; i < stilb_image_size(&images[0]); i++) {
			/* Codes are steps of 4e-3: a difference of 1e-3 changes one of four by one. */
			assert_in_range(abs(a[i] - b[i]), 0, 1);
			differ += a[i] != b[i];
		}
		assert_in_range(differ, 0, stilb_image_size(&images[0]) / 100);
		stilb_image_finish(&images[0]);
		stilb_image_finish(&images[1]);
	}
	for (int r = 0; r < 2; r++)
		stilb_render_destroy(render[r]);
	stilb_scene_destroy(scene);
}

/* ---- indices ----------------------------------------------------------------------------------------------------- */

/* A picture of four spheres in a row; those at odd places have other triangles, and their mesh has `more` vertices that
 * nothing uses. */
static stilb_image row_of_spheres(stilb_render_replay_mode replay, uint32_t more)
{
	stilb_render *render = make_render(false, replay);
	stilb_scene_mesh meshes[2];
	stilb_render_mesh made[2];
	stilb_render_material material;
	stilb_scene_material grey = {.diffuse = {0.6f, 0.5f, 0.4f}, .roughness = 0.5f};
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_scene_mesh_sphere(i == 0 ? 2 : 1, &meshes[i]), STILB_OK);
		meshes[i].level_count = meshes[i].level_index_count = 0;
	}
	uint32_t count = meshes[1].vertex_count + more;
	meshes[1].vertices = realloc(meshes[1].vertices, count * sizeof *meshes[1].vertices);
	assert_non_null(meshes[1].vertices);
	memset(meshes[1].vertices + meshes[1].vertex_count, 0, more * sizeof *meshes[1].vertices);
	meshes[1].vertex_count = count;
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_render_mesh_create(render, &meshes[i], &made[i]), STILB_OK);
		stilb_scene_mesh_finish(&meshes[i]);
	}
	assert_int_equal(stilb_render_material_create(render, &grey, (stilb_render_texture){0}, &material), STILB_OK);
	static const stilb_render_pass pass = {.name = "scene"};
	stilb_scene_camera camera = {.position = {0.0f, 0.0f, 9.0f}, .fov_y = 0.6f, .near_z = 0.1f, .far_z = 50.0f};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, 0.0f, -1.0f}, .intensity = {4.0f, 4.0f, 4.0f}};
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, (float)WIDTH / HEIGHT),
	                          .lights = &sun,
	                          .light_count = 1,
	                          .surroundings = {.sky = {0.5f, 0.6f, 0.7f}, .ground = {0.2f, 0.1f, 0.1f}},
	                          .shading = stilb_render_shading_default()};
	memcpy(view.camera_position, camera.position, sizeof camera.position);
	stilb_job_pool_desc workers = {.worker_count = 1};
	stilb_job_pool *pool;
	stilb_image image;
	assert_int_equal(stilb_job_pool_create(&workers, &pool), 0);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 0, 0);
	for (int i = 0; i < 4; i++) {
		stilb_mat4 place = stilb_mat4_identity();
		place.m[12] = 2.2f * (float)i - 3.3f;
		stilb_render_draw(context, made[i % 2], material, &place);
	}
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	stilb_job_pool_destroy(pool);
	stilb_render_destroy(render);
	return image;
}

static void both_kinds_of_indices(void **state)
{
	(void)state;
	stilb_image narrow = row_of_spheres(STILB_RENDER_REPLAY_DIRECT, 0);
	for (int replay = 0; replay < 3; replay++) {
		stilb_image mixed = row_of_spheres((stilb_render_replay_mode)replay, 70000);
		assert_memory_equal(narrow.pixels, mixed.pixels, stilb_image_size(&narrow));
		stilb_image_finish(&mixed);
	}
	/* There are four spheres, and a background between them. */
	const uint8_t *row = (const uint8_t *)narrow.pixels + (size_t)narrow.channels * WIDTH * (HEIGHT / 2);
	uint32_t edges = 0;
	for (uint32_t x = 1; x < WIDTH; x++)
		edges += abs(row[narrow.channels * x] - row[narrow.channels * (x - 1)]) > 10;
	assert_in_range(edges, 8, 40);
	stilb_image_finish(&narrow);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(packed_vertices_look_the_same),
		cmocka_unit_test(both_kinds_of_indices),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
