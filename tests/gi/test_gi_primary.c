/* Camera rays sixteen at a time: every instruction set gives the bits of plain C, and these are those of single rays
 * and of gi_surface_at. */

#include "gi_world_fixture.h"

#include "gi/film/gi_primary.h"

#define WIDTH 61u /* no multiple of anything */
#define HEIGHT 47u

static gi_primary scalar, wide;
static uint16_t xs[GI_BATCH], ys[GI_BATCH];
static gi_point points[GI_BATCH];

/* A smooth ball, one without normals, one whose normals point inwards, and whose surface has a map, a textured one and
 * instances; and nothing behind. */
static stilb_scene *all_kinds(void)
{
	static float texels[2][2][3] = {{{1.0f, 0.0f, 0.5f}, {0.0f, 1.0f, 0.2f}}, {{0.3f, 0.1f, 1.0f}, {0.9f, 1.0f, 1.0f}}};
	static stilb_image image = {2, 2, 3, STILB_IMAGE_F32_LINEAR, texels, 0};
	stilb_scene *scene = world_scene(84, 4, 3);
	for (uint32_t mesh = 0; mesh < 4; mesh++)
		assert_int_equal(stilb_scene_mesh_sphere(mesh == 3 ? 3 : 2, &scene->meshes[mesh]), STILB_OK);
	for (uint32_t i = 0; i < scene->meshes[1].vertex_count; i++)
		for (int k = 0; k < 3; k++) {
			scene->meshes[1].vertices[i].normal[k] = 0.0f;
			scene->meshes[2].vertices[i].normal[k] *= -1.0f;
		}
	for (uint32_t part = 0; part < 84; part++) {
		scene->part_mesh[part] = part < 3 ? part : 3;
		scene->part_transform[part] =
			stilb_mat4_scale_translate(part < 4 ? 1.0f : 0.4f, 2.2f * (float)(part % 4) - 3.3f, part < 4 ? 0.0f : 2.0f,
		                               part < 4 ? 0.0f : -(float)part);
	}
	scene->part_mesh[3] = 0;
	scene->part_material[3] = 1;
	scene->materials[0].specular[1] = 0.25f;
	scene->materials[1].diffuse_texture = 1;
	assert_int_equal(scene_add_surfaces(scene, 1), STILB_OK);
	scene->surfaces[0] = stilb_scene_surface_make();
	scene->surfaces[0].maps[STILB_SCENE_MAP_COLOR].texture = 1;
	scene->part_material[2] = 2;
	scene->materials[2].surface = 1;
	scene->texture_count = 1;
	scene->textures = &image;
	scene->camera =
		(stilb_scene_camera){.position = {0.0f, 0.5f, 8.0f}, .fov_y = 0.9f, .near_z = 0.1f, .far_z = 100.0f};
	return scene;
}

static void give_back(world_fixture *world)
{
	world->scene->texture_count = 0;
	world->scene->textures = NULL;
	world_finish(world);
}

static gi_view view_of(const world_fixture *world, stilb_gi_sampler_kind sampler, stilb_gi_filter_kind filter)
{
	gi_view view = {.scene = world->gi, .sampler = gi_sampler_make(sampler, 5, 4)};
	view.settings.filter = filter;
	view.settings.width = WIDTH;
	view.settings.height = HEIGHT;
	return view;
}

static void batch(const gi_view *view, uint32_t first, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		xs[i] = (uint16_t)((first + i) % WIDTH);
		ys[i] = (uint16_t)((first + i) / WIDTH % HEIGHT);
		points[i] = gi_sampler_point(&view->sampler, xs[i], ys[i], 3);
	}
}

static void trace(const gi_view *view, const gi_camera *camera, stilb_isa isa, uint32_t count, gi_primary *out)
{
	gi_primary_samples samples = {count, xs, ys, points};
	memset(out, 0xab, sizeof *out);
	gi_primary_trace(gi_primary_kernels_for(isa), view, camera, &samples, out);
}

static void assert_rows_equal(const float a[][4], const float b[][4], uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		assert_memory_equal(a[i], b[i], 3 * sizeof(float));
}

static void instruction_sets_agree(void **state)
{
	(void)state;
	world_fixture world = world_trace(all_kinds(), &stilb_gi_embree, 0);
	static const uint32_t counts[] = {1, 15, 16, 17, 500, GI_BATCH};
	for (stilb_isa isa = STILB_ISA_AVX2; isa <= stilb_cpu_widest_isa(); isa++)
		for (int way = 0; way < 4; way++) {
			int lens = way % 2;
			gi_view view = view_of(&world, STILB_GI_SAMPLER_SOBOL, STILB_GI_FILTER_GAUSSIAN);
			world.scene->camera.near_z = way < 2 ? 0.1f : 7.6f; /* some see into spheres, others nothing any more */
			world.scene->camera.far_z = way < 2 ? 100.0f : 11.0f;
			gi_camera camera = gi_camera_make(
				&world.scene->camera, &(stilb_gi_lens){.radius = 0.1f * (float)lens, .focus = 6.0f}, WIDTH, HEIGHT);
			for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
				batch(&view, 700, counts[c]);
				trace(&view, &camera, STILB_ISA_SCALAR, counts[c], &scalar);
				trace(&view, &camera, isa, counts[c], &wide);
				for (uint32_t i = 0; i < counts[c]; i++) {
					assert_memory_equal(&scalar.rays[i].ray, &wide.rays[i].ray, sizeof scalar.rays[i].ray);
					assert_int_equal(scalar.rays[i].hit.part, wide.rays[i].hit.part);
				}
				assert_rows_equal((const float(*)[4])scalar.albedo, (const float(*)[4])wide.albedo, counts[c]);
				assert_rows_equal((const float(*)[4])scalar.normal, (const float(*)[4])wide.normal, counts[c]);
				assert_memory_equal(scalar.depth, wide.depth, counts[c] * sizeof *scalar.depth);
			}
		}
	give_back(&world);
}

/* Sample i is what a single ray gives that is made, traced and shaded without packets. */
static void assert_sample(const gi_view *view, const gi_camera *camera, const gi_primary *out, uint32_t i)
{
	stilb_vec2 offset =
		gi_filter_offset(view->settings.filter, gi_sample_2d(&view->sampler, points[i], GI_DIMENSION_PIXEL));
	gi_ray_hit ray;
	gi_camera_ray(camera, (float)xs[i] + 0.5f + offset[0], (float)ys[i] + 0.5f + offset[1],
	              gi_sample_2d(&view->sampler, points[i], GI_DIMENSION_LENS), &ray);
	const gi_ray_hit *got = &out->rays[i];
	SHADE_PROOF_NEAR3(stilb_vec3_make(got->ray.direction[0], got->ray.direction[1], got->ray.direction[2]),
	                  ray.ray.direction[0], ray.ray.direction[1], ray.ray.direction[2], 0.0, 3e-7);
	SHADE_PROOF_NEAR3(stilb_vec3_make(got->ray.origin[0], got->ray.origin[1], got->ray.origin[2]), ray.ray.origin[0],
	                  ray.ray.origin[1], ray.ray.origin[2], 0.0, 1e-6);
	stilb_vec3 albedo = {0}, normal = {0};
	float depth = INFINITY;
	if (gi_is_hit(got)) {
		gi_surface surface;
		gi_surface_at(view->scene, got, &surface);
		albedo = surface.diffuse + surface.specular;
		normal = surface.normal;
		depth = stilb_vec3_dot(surface.position - camera->position, camera->forward);
	}
	for (int k = 0; k < 3; k++) {
		assert_true(out->albedo[i][k] == albedo[k]);
		assert_true(out->normal[i][k] == normal[k]);
	}
	if (gi_is_hit(got))
		SHADE_PROOF_NEAR(out->depth[i], depth, 1e-5, 0.0);
	else
		assert_true(out->depth[i] == INFINITY);
}

static void packets_are_single_rays(void **state)
{
	(void)state;
	world_fixture world = world_trace(all_kinds(), &stilb_gi_embree, 0);
	uint32_t hits[84] = {0}, misses = 0;
	for (int sampler = 0; sampler < STILB_GI_SAMPLER_COUNT; sampler++)
		for (int lens = 0; lens < 2; lens++) {
			gi_view view =
				view_of(&world, sampler, sampler == 0 ? STILB_GI_FILTER_BLACKMAN_HARRIS : STILB_GI_FILTER_BOX);
			gi_camera camera = gi_camera_make(
				&world.scene->camera, &(stilb_gi_lens){.radius = 0.1f * (float)lens, .focus = 6.0f, .blades = 5}, WIDTH,
				HEIGHT);
			for (uint32_t first = 0; first < WIDTH * HEIGHT; first += 1000) {
				batch(&view, first, 1000);
				trace(&view, &camera, stilb_cpu_widest_isa(), 1000, &wide);
				for (uint32_t i = 0; i < 1000; i++) {
					assert_sample(&view, &camera, &wide, i);
					if (gi_is_hit(&wide.rays[i]))
						hits[wide.rays[i].hit.part]++;
					else
						misses++;
				}
			}
		}
	for (uint32_t part = 0; part < 5; part++)
		assert_true(hits[part] > 20); /* every kind was seen */
	assert_true(world.gi->parts[4].instance && misses > 100);
	give_back(&world);
}

/* Frames draw what lies between two planes; so do camera rays: with the near plane before everything and the far one
 * behind it nothing changes, else the first surface between both is seen, whose depth is the same. */
static void rays_end_at_the_clip_planes(void **state)
{
	(void)state;
	uint32_t kept = 0, inside = 0, cut = 0;
	world_fixture world = world_trace(all_kinds(), &stilb_gi_embree, 0);
	gi_view view = view_of(&world, STILB_GI_SAMPLER_SOBOL, STILB_GI_FILTER_BOX);
	static const float planes[][2] = {{7.6f, 100.0f}, {7.6f, 7.9f}, {0.1f, 7.9f}, {20.0f, 21.0f}};
	for (size_t p = 0; p < sizeof planes / sizeof *planes; p++)
		for (int lens = 0; lens < 2; lens++) {
			stilb_gi_lens glass = {.radius = 0.1f * (float)lens, .focus = 6.0f};
			stilb_scene_camera clipped = world.scene->camera;
			clipped.near_z = planes[p][0];
			clipped.far_z = planes[p][1];
			gi_camera all = gi_camera_make(&world.scene->camera, &glass, WIDTH, HEIGHT);
			gi_camera between = gi_camera_make(&clipped, &glass, WIDTH, HEIGHT);
			for (uint32_t first = 0; first < WIDTH * HEIGHT; first += 1000) {
				batch(&view, first, 1000);
				trace(&view, &all, stilb_cpu_widest_isa(), 1000, &scalar);
				trace(&view, &between, stilb_cpu_widest_isa(), 1000, &wide);
				for (uint32_t i = 0; i < 1000; i++) {
					float depth = scalar.depth[i], now = wide.depth[i], slack = 1e-5f * depth;
					bool sure = fabsf(depth - clipped.near_z) > slack && fabsf(depth - clipped.far_z) > slack;
					assert_true(now == INFINITY ||
					            (now >= clipped.near_z * 0.99999f && now <= clipped.far_z * 1.00001f));
					if (sure && depth > clipped.near_z && depth < clipped.far_z) {
						assert_true(now == depth && wide.rays[i].hit.triangle == scalar.rays[i].hit.triangle);
						kept++;
					} else if (sure && depth < clipped.near_z && now < INFINITY) {
						assert_true(now > depth);
						inside++;
					} else if (sure && depth < INFINITY) {
						assert_true(now == INFINITY);
						assert_true(wide.albedo[i][0] == 0.0f && wide.normal[i][0] == 0.0f);
						cut++;
					}
				}
			}
		}
	assert_true(kept > 500 && inside > 500 && cut > 500);
	give_back(&world);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(instruction_sets_agree),
		cmocka_unit_test(packets_are_single_rays),
		cmocka_unit_test(rays_end_at_the_clip_planes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
