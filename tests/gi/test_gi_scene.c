/* Scenes made ready for rays: what is counted, what is left out, what is refused, and that the scene may go
 * afterwards. */

#include "gi_world_fixture.h"
#include "scene/edit/scene_edit.h"

static stilb_result create(const stilb_scene *scene, stilb_gi_scene_desc desc, uint32_t workers, stilb_gi_scene **gi)
{
	stilb_job_pool_desc pool_desc = stilb_job_pool_desc_default();
	pool_desc.worker_count = workers;
	assert_int_equal(stilb_job_pool_create(&pool_desc, &desc.pool), 0);
	stilb_result result = stilb_gi_scene_create(scene, &desc, gi);
	stilb_job_pool_destroy(desc.pool);
	return result;
}

/* Triangles of which one is fine and the others are a line, a point, not finite, out of reach, or of vertices that are
 * not. */
static stilb_scene *damaged_scene(void)
{
	static const float positions[][3] = {{0, 0, 0},   {1, 0, 0},        {0, 1, 0},     {2, 0, 0},
	                                     {NAN, 0, 0}, {0, INFINITY, 0}, {2e10f, 0, 0}, {0, 0, -INFINITY}};
	static const uint32_t indices[][3] = {{0, 1, 2}, {0, 1, 3}, {2, 2, 2}, {0, 1, 4}, {5, 1, 0},
	                                      {0, 6, 2}, {7, 1, 2}, {0, 1, 8}, {4, 5, 7}};
	stilb_scene *scene = world_scene(1, 1, 1);
	assert_int_equal(scene_mesh_create(&scene->meshes[0], 8, 27), STILB_OK);
	for (uint32_t i = 0; i < 8; i++) {
		scene->meshes[0].vertices[i] = (stilb_scene_vertex){0};
		memcpy(scene->meshes[0].vertices[i].position, positions[i], sizeof positions[i]);
	}
	memcpy(scene->meshes[0].indices, indices, sizeof indices);
	return scene;
}

static void damaged_triangles_are_left_out(void **state)
{
	(void)state;
	const stilb_gi_intersector *const intersectors[] = {&stilb_gi_embree, &stilb_gi_brute};
	for (int which = 0; which < 2; which++) {
		world_fixture world = world_trace(damaged_scene(), intersectors[which], 0);
		const stilb_gi_scene_info *info = stilb_gi_scene_info_of(world.gi);
		assert_int_equal(info->triangles, 1);
		assert_int_equal(info->flat, 2);
		assert_int_equal(info->invalid, 6);
		assert_true(info->low[0] == 0.0f && info->low[2] == 0.0f && info->high[0] == 1.0f && info->high[1] == 1.0f);
		gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.25f, 0.25f, 1.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
		world.gi->tracer.intersect(&world.gi->tracer, &ray);
		assert_true(gi_is_hit(&ray) && ray.hit.triangle == 0);
		world_finish(&world);
	}
}

static void nothing_to_see(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(scene_create(0, 0, 0, 0, &scene), STILB_OK);
	world_fixture world = world_trace(scene, &stilb_gi_embree, 1);
	const stilb_gi_scene_info *info = stilb_gi_scene_info_of(world.gi);
	assert_int_equal(info->triangles, 0);
	assert_true(info->low[0] > info->high[0]);
	gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.0f, 0.0f, 0.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
	world.gi->tracer.intersect(&world.gi->tracer, &ray);
	assert_false(gi_is_hit(&ray));
	world_finish(&world);
}

/* A transform that flattens, and one that is no numbers: such parts have no triangles. */
static void flat_transforms(void **state)
{
	(void)state;
	stilb_scene *scene = world_scene(3, 1, 1);
	assert_int_equal(stilb_scene_mesh_sphere(1, &scene->meshes[0]), STILB_OK);
	scene->part_transform[1] = stilb_mat4_scale_translate(0.0f, 1.0f, 2.0f, 3.0f);
	scene->part_transform[2].m[5] = NAN;
	world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->triangles, 80);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->flat, 80);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->invalid, 80);
	world_finish(&world);
}

static void the_scene_may_go(void **state)
{
	(void)state;
	stilb_scene *scene = world_scene(1, 1, 1);
	assert_int_equal(stilb_scene_mesh_sphere(2, &scene->meshes[0]), STILB_OK);
	scene->materials[0].emission[0] = 2.0f;
	stilb_gi_scene *gi;
	assert_int_equal(create(scene, stilb_gi_scene_desc_default(NULL), 1, &gi), STILB_OK);
	stilb_scene_destroy(scene);
	gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.1f, 0.2f, 5.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
	gi->tracer.intersect(&gi->tracer, &ray);
	gi_surface surface;
	gi_surface_at(gi, &ray, &surface);
	SHADE_PROOF_NEAR3(surface.emission, 2.0, 0.0, 0.0, 0.0, 0.0);
	assert_int_equal(stilb_gi_scene_info_of(gi)->lights, 320);
	stilb_gi_scene_destroy(gi);
	stilb_gi_scene_destroy(NULL);
}

/* Many parts of a large mesh share it; one that shines does not, nor one that is badly sheared. */
static void which_parts_are_instances(void **state)
{
	(void)state;
	stilb_scene *scene = world_scene(40, 1, 2);
	assert_int_equal(stilb_scene_mesh_sphere(4, &scene->meshes[0]), STILB_OK);
	for (uint32_t part = 0; part < 40; part++)
		scene->part_transform[part] = stilb_mat4_scale_translate(0.4f, (float)part, 0.0f, 0.0f);
	scene->materials[1].emission[2] = 1.0f;
	scene->part_material[3] = 1;
	scene->part_transform[5].m[4] = 30.0f;
	world_fixture world = world_trace(scene, &stilb_gi_embree, 1);
	for (uint32_t part = 0; part < 40; part++) {
		assert_int_equal(world.gi->parts[part].instance, part != 3 && part != 5);
		assert_int_equal(world.gi->parts[part].first_light, part == 3 ? 0 : GI_NO_LIGHT);
	}
	assert_int_equal(world.gi->mesh_count, 3);
	assert_int_equal(stilb_gi_scene_info_of(world.gi)->triangles, 40 * 5120);
	for (uint32_t part = 0; part < 40; part++) {
		gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make((float)part, 0.0f, 5.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
		world.gi->tracer.intersect(&world.gi->tracer, &ray);
		if (part < 5 - 1 || part > 20) /* the sheared one covers its neighbours */
			assert_int_equal(ray.hit.part, part);
	}
	world_finish(&world);
}

/* A hidden model and a removed one: rays pass where they were, and the others keep their ids. */
static void what_is_not_shown(void **state)
{
	(void)state;
	const stilb_gi_intersector *const intersectors[] = {&stilb_gi_embree, &stilb_gi_brute};
	stilb_scene_material shining = {.diffuse = {0.5f, 0.5f, 0.5f}, .emission = {1.0f, 1.0f, 1.0f}};
	for (int which = 0; which < 2; which++) {
		stilb_scene *scene = world_scene(1, 1, 1);
		uint32_t model, material;
		assert_int_equal(stilb_scene_mesh_sphere(1, &scene->meshes[0]), STILB_OK);
		assert_int_equal(stilb_scene_add_material(scene, &shining, &material), STILB_OK);
		for (uint32_t m = 1; m < 4; m++) {
			stilb_mat4 place = stilb_mat4_scale_translate(1.0f, 3.0f * (float)m, 0.0f, 0.0f);
			stilb_scene_build_part part = {0, m == 2 ? material : 0};
			assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &model), STILB_OK);
		}
		assert_int_equal(stilb_scene_show_model(scene, 1, false), STILB_OK);
		assert_int_equal(stilb_scene_remove_model(scene, 2), STILB_OK);
		world_fixture world = world_trace(scene, intersectors[which], 0);
		const stilb_gi_scene_info *info = stilb_gi_scene_info_of(world.gi);
		assert_int_equal(info->triangles, 2 * 80);
		assert_int_equal(info->lights + info->invalid + info->flat, 0);
		for (uint32_t m = 0; m < 4; m++) {
			gi_ray_hit ray =
				gi_ray_hit_make(stilb_vec3_make(3.0f * (float)m, 0.1f, 5.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
			world.gi->tracer.intersect(&world.gi->tracer, &ray);
			assert_int_equal(gi_is_hit(&ray), m == 0 || m == 3);
			if (gi_is_hit(&ray))
				assert_int_equal(ray.hit.part, m);
		}
		world_finish(&world);
	}
}

static void instruction_sets(void **state)
{
	(void)state;
	stilb_cpu_features cpu = stilb_cpu_query();
	stilb_scene *scene = damaged_scene();
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(NULL);
	assert_int_equal(create(scene, desc, 0, &gi), STILB_OK);
	assert_string_equal(stilb_gi_scene_info_of(gi)->isa, cpu.avx512 ? "avx512" : cpu.avx2 ? "avx2" : "sse42");
	stilb_gi_scene_destroy(gi);
	desc.isa = STILB_GI_ISA_SSE2;
	assert_int_equal(create(scene, desc, 0, &gi), STILB_OK);
	assert_string_equal(stilb_gi_scene_info_of(gi)->isa, "sse2");
	stilb_gi_scene_destroy(gi);
	desc.isa = STILB_GI_ISA_AVX512;
	stilb_result result = create(scene, desc, 0, &gi);
	assert_int_equal(result, cpu.avx512 ? STILB_OK : STILB_ERROR_ARGUMENT);
	stilb_gi_scene_destroy(gi);
	desc.isa = STILB_GI_ISA_COUNT;
	assert_int_equal(create(scene, desc, 0, &gi), STILB_ERROR_ARGUMENT);
	assert_null(gi);
	stilb_scene_destroy(scene);
}

/* However many build, and whether the tree is of the scene or of a shared mesh; refused at once, or in the middle. */
static void memory_runs_out(void **state)
{
	(void)state;
	for (uint32_t parts = 1; parts <= 100; parts += 99)
		for (uint32_t workers = 0; workers < 4; workers++) {
			stilb_scene *scene = world_scene(parts, 1, 1);
			assert_int_equal(stilb_scene_mesh_sphere(5, &scene->meshes[0]), STILB_OK);
			stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(NULL);
			stilb_gi_scene *gi;
			for (desc.memory = 100000; desc.memory < 1000000; desc.memory += desc.memory) {
				assert_int_equal(create(scene, desc, workers, &gi), STILB_ERROR_MEMORY);
				assert_null(gi);
				assert_non_null(strstr(stilb_error_message(), "memory"));
			}
			desc.memory = 0;
			assert_int_equal(create(scene, desc, workers, &gi), STILB_OK);
			assert_true(stilb_gi_scene_info_of(gi)->bytes > 1000000);
			stilb_gi_scene_destroy(gi);
			stilb_scene_destroy(scene);
		}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(damaged_triangles_are_left_out),
		cmocka_unit_test(nothing_to_see),
		cmocka_unit_test(flat_transforms),
		cmocka_unit_test(the_scene_may_go),
		cmocka_unit_test(which_parts_are_instances),
		cmocka_unit_test(what_is_not_shown),
		cmocka_unit_test(instruction_sets),
		cmocka_unit_test(memory_runs_out),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
