/* Hordes: which models are given an impostor by themselves, and which are not. */
#include "geometry/geometry_levels.h"
#include "geometry/horde/geometry_horde.h"
#include "geometry/mesh_made.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"

#define MANY (STILB_GEOMETRY_HORDE_MODELS + 3)

static stilb_job_pool *pool;

static int pool_make(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = {.worker_count = 1};
	return stilb_job_pool_create(&desc, &pool);
}

static int pool_free(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

/* Models of two parts each, turned and sized in their own way. few: so many more of them have their second part
 * elsewhere. levels: meshes have levels. */
typedef struct made {
	uint32_t models, few;
	uint32_t side; /* squares along a side of the mesh of each part */
	bool levels;
	float emission;
} made;

static stilb_scene *make_scene(made how)
{
	stilb_scene_mesh torus = mesh_grid(how.side, how.side, mesh_place_torus);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	if (how.levels)
		assert_int_equal(stilb_geometry_levels(&torus, &desc, pool, 0), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material paint[2];
	for (int i = 0; i < 2; i++)
		paint[i] = stilb_scene_material_make((float[3]){0.5f, 0.4f, 0.3f}, (float[3]){0}, 0.5f);
	paint[1].emission[1] = how.emission;
	uint32_t mesh = stilb_scene_build_mesh(build, &torus), materials[2];
	for (int i = 0; i < 2; i++)
		materials[i] = stilb_scene_build_material(build, &paint[i]);
	for (uint32_t m = 0; m < how.models + how.few; m++) {
		stilb_scene_pose pose = {.scale = {1, 1, 1}, .rotation = {0, sinf((float)m), 0, cosf((float)m)}};
		for (int i = 0; i < 3; i++)
			pose.scale[i] = 1.0f + 0.01f * (float)m;
		pose.translation[0] = 10.0f * (float)m;
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_build_part parts[2] = {{mesh, materials[0]}, {mesh, materials[1]}};
		uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place);
		stilb_scene_build_model(build, node, parts, 2);
	}
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	for (uint32_t m = how.models; m < how.models + how.few; m++)
		scene->part_transform[2 * m + 1].m[13] += 0.1f; /* as a node that moves one part would */
	stilb_scene_mesh_finish(&torus);
	return scene;
}

static stilb_geometry_horde_desc small(void)
{
	stilb_geometry_horde_desc desc = stilb_geometry_horde_desc_default();
	desc.impostor.grid = 3;
	desc.impostor.side = 16;
	desc.impostor.samples = 1;
	return desc;
}

static uint32_t hordes(stilb_scene *scene, stilb_geometry_horde_desc desc)
{
	uint32_t count = UINT32_MAX;
	assert_int_equal(stilb_geometry_hordes(scene, &desc, pool, 0, &count), STILB_OK);
	assert_int_equal(count, scene->impostor_count);
	return count;
}

static uint32_t given(const stilb_scene *scene)
{
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->impostor_model_count; m++)
		count += scene->model_impostor[m] > 0;
	return count;
}

static void models_that_are_many_and_alike_have_one(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene((made){.models = MANY, .few = 3, .side = 20});
	assert_int_equal(hordes(scene, small()), 1);
	assert_true(stilb_scene_impostors_are_current(scene));
	assert_int_equal(given(scene), MANY);
	for (uint32_t m = 0; m < MANY; m++)
		assert_int_equal(scene->model_impostor[m], 1);
	/* Another call adds none; after an edit of a material it makes them anew. */
	uint32_t count = UINT32_MAX;
	stilb_geometry_horde_desc desc = small();
	assert_int_equal(stilb_geometry_hordes(scene, &desc, pool, 0, &count), STILB_OK);
	assert_int_equal(count, 0);
	assert_int_equal(given(scene), MANY);
	stilb_scene_material paint = scene->materials[0];
	paint.diffuse[0] = 0.1f;
	float before = scene->impostors[0].material.diffuse[0];
	assert_int_equal(stilb_scene_set_material(scene, 0, &paint), STILB_OK);
	assert_false(stilb_scene_impostors_are_current(scene));
	assert_int_equal(hordes(scene, small()), 1);
	assert_true(stilb_scene_impostors_are_current(scene));
	assert_true(scene->impostors[0].material.diffuse[0] < before);
	assert_int_equal(given(scene), MANY);
	stilb_scene_destroy(scene);
}

static bool at_once(void *user)
{
	(void)user;
	return true;
}

static void others_have_none(void **state)
{
	(void)state;
	static const made none[] = {
		{.models = STILB_GEOMETRY_HORDE_MODELS - 1, .few = 20, .side = 20}, /* too few of them are alike */
		{.models = MANY, .side = 3},                                        /* 36 triangles */
		{.models = MANY, .side = 40, .levels = true}, /* levels have few triangles where an impostor would be drawn */
		{.models = MANY, .side = 20, .emission = 1.0f},
	};
	for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
		stilb_scene *scene = make_scene(none[i]);
		stilb_geometry_horde_desc far = small();
		far.impostor.side = 8;
		if (hordes(scene, far) != 0)
			fail_msg("case %zu", i);
		stilb_scene_destroy(scene);
	}
	stilb_scene *scene = make_scene((made){.models = MANY, .side = 20});
	stilb_geometry_horde_desc desc = small();
	desc.bytes = 3 * 16 * 3 * 16 * 16 - 1;
	assert_int_equal(hordes(scene, desc), 0);
	desc.bytes++;
	desc.give_up = at_once;
	assert_int_equal(hordes(scene, desc), 0);
	desc.give_up = NULL;
	assert_int_equal(hordes(scene, desc), 1);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(models_that_are_many_and_alike_have_one),
		cmocka_unit_test(others_have_none),
	};
	return cmocka_run_group_tests(tests, pool_make, pool_free);
}
