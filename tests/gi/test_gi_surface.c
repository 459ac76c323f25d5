/* Where rays go on after a hit: none is lost in a closed sphere of any size anywhere, none meets the triangle it starts
 * on, shadow rays end at the light and not before; and what a surface says about itself. */

#include "gi/gi_scene_hash.h"
#include "gi/gi_texture.h"
#include "gi/light/gi_light_shape.h"
#include "gi_world_fixture.h"

static stilb_vec3 cosine_direction(stilb_vec3 normal, shade_proof_random *random)
{
	for (;;) {
		stilb_vec3 direction = world_direction(random) + normal;
		if (stilb_vec3_dot(direction, direction) > 1e-8f && stilb_vec3_dot(direction, normal) > 0.0f)
			return stilb_vec3_normalize(direction);
	}
}

/* Paths inside a sphere. Its triangles are flat, so that one hit twice in a row is a ray that met what it started on.
 * error_scale: how much of the offset is used. */
static uint32_t rays_lost(const stilb_gi_scene *gi, stilb_vec3 center, uint32_t count, float error_scale)
{
	shade_proof_random random = {.seed = 11};
	stilb_vec3 origin = center, direction = world_direction(&random);
	uint32_t lost = 0, last = UINT32_MAX;
	for (uint32_t i = 0; i < count; i++) {
		gi_ray_hit ray = gi_ray_hit_make(origin, direction);
		gi->tracer.intersect(&gi->tracer, &ray);
		gi_surface surface = {0};
		if (gi_is_hit(&ray))
			gi_surface_at(gi, &ray, &surface);
		if (!gi_is_hit(&ray) || surface.front || ray.hit.triangle == last) {
			lost++;
			origin = center;
			direction = world_direction(&random);
			last = UINT32_MAX;
			continue;
		}
		last = ray.hit.triangle;
		surface.error *= error_scale;
		direction = cosine_direction(surface.geometric, &random);
		origin = gi_surface_ray_origin(&surface, direction);
	}
	return lost;
}

static stilb_scene *sphere_scene(float radius, stilb_vec3 center, uint32_t splits)
{
	stilb_scene *scene = world_scene(1, 1, 1);
	assert_int_equal(stilb_scene_mesh_sphere(splits, &scene->meshes[0]), STILB_OK);
	scene->part_transform[0] = stilb_mat4_scale_translate(radius, center[0], center[1], center[2]);
	return scene;
}

static void furnaces_lose_no_ray(void **state)
{
	(void)state;
	static const struct {
		float radius, away;
		uint32_t splits;
	} rows[] = {{1e-3f, 0.0f, 3}, {1.0f, 0.0f, 0},  {1.0f, 0.0f, 3},   {1.0f, 0.0f, 6}, {1e4f, 0.0f, 3},
	            {1e-3f, 1.0f, 3}, {1e-3f, 1e2f, 2}, {1.0f, 1e3f, 3},   {1.0f, 1e5f, 2}, {1e4f, 1e6f, 3},
	            {1e-3f, 1e2f, 0}, {1e-9f, 0.0f, 2}, {1e-5f, 1e-4f, 4}, {1e9f, 1e9f, 3}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_vec3 center = stilb_vec3_make(1.0f, -0.3f, 0.7f) * rows[i].away;
		world_fixture world = world_trace(sphere_scene(rows[i].radius, center, rows[i].splits), &stilb_gi_embree, 0);
		uint32_t lost = rays_lost(world.gi, center, 50000, 1.0f);
		if (lost)
			fail_msg("radius %g at %g: %u rays lost", (double)rows[i].radius, (double)rows[i].away, lost);
		world_finish(&world);
	}
}

/* Turned about x and then z, and twice as wide as high. */
static stilb_mat4 turned(float about_x, float about_z, float scale)
{
	float cx = cosf(about_x), sx = sinf(about_x), cz = cosf(about_z), sz = sinf(about_z);
	stilb_mat4 x = {{2.0f * scale, 0, 0, 0, 0, cx * scale, sx * scale, 0, 0, -sx * scale, cx * scale, 0, 0, 0, 0, 1}};
	stilb_mat4 z = {{cz, sz, 0, 0, -sz, cz, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
	return stilb_mat4_multiply(z, x);
}

/* A box, turned and far from the origin: at its edges a point of the floor that is off by a rounding lies behind the
 * wall. */
static void boxes_lose_no_ray(void **state)
{
	(void)state;
	static const float rows[][2] = {{1e-3f, 0.0f},  {1.0f, 0.0f},   {1e4f, 0.0f},
	                                {1.0f, 100.0f}, {1e-3f, 10.0f}, {1.0f, 1e4f}};
	static const uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
	                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
	for (size_t row = 0; row < sizeof rows / sizeof *rows; row++)
		for (int angle = 0; angle < 2; angle++) {
			stilb_scene *scene = world_scene(1, 1, 1);
			assert_int_equal(scene_mesh_create(&scene->meshes[0], 8, 36), STILB_OK);
			for (uint32_t i = 0; i < 8; i++)
				scene->meshes[0].vertices[i] = (stilb_scene_vertex){
					.position = {i & 1 ? 1.0f : -1.0f, i & 2 ? 1.3f : -1.3f, i & 4 ? 0.7f : -0.7f}};
			for (uint32_t i = 0; i < 36; i++)
				scene->meshes[0].indices[i] = faces[i / 6][(uint32_t[]){0, 1, 2, 0, 2, 3}[i % 6]];
			stilb_vec3 center = stilb_vec3_make(1.0f, -0.3f, 0.7f) * rows[row][1];
			stilb_mat4 m = turned(0.7f * (float)angle, 1.1f * (float)angle, rows[row][0]);
			memcpy(m.m + 12, &center, 3 * sizeof(float));
			scene->part_transform[0] = m;
			world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
			uint32_t lost = rays_lost(world.gi, center, 100000, 1.0f);
			if (lost)
				fail_msg("size %g at %g: %u rays lost", (double)rows[row][0], (double)rows[row][1], lost);
			world_finish(&world);
		}
}

/* Without the offset that gi_surface_ray_origin adds rays are lost, so the tests above can fail. */
static void without_an_offset_rays_are_lost(void **state)
{
	(void)state;
	stilb_vec3 center = stilb_vec3_make(1.0f, -0.3f, 0.7f);
	world_fixture world = world_trace(sphere_scene(1.0f, center, 3), &stilb_gi_embree, 0);
	assert_in_range(rays_lost(world.gi, center, 2000, 0.0f), 100, 2000);
	world_finish(&world);
}

/* Instances far from the origin, turned and scaled: rays go to the mesh's space and back. */
static void instances_lose_no_ray(void **state)
{
	(void)state;
	stilb_scene *scene = world_scene(60, 1, 1);
	assert_int_equal(stilb_scene_mesh_sphere(3, &scene->meshes[0]), STILB_OK);
	for (uint32_t part = 0; part < 60; part++) {
		stilb_mat4 m = turned(0.7f * (float)part, 1.1f * (float)part, 0.05f);
		m.m[12] = 1000.0f, m.m[13] = 30.0f * (float)part, m.m[14] = -500.0f;
		scene->part_transform[part] = m;
	}
	world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
	assert_true(world.gi->parts[7].instance);
	for (uint32_t part = 0; part < 60; part++)
		assert_int_equal(rays_lost(world.gi, stilb_vec3_make(1000.0f, 30.0f * (float)part, -500.0f), 2000, 1.0f), 0);
	world_finish(&world);
}

/* Needles and flat obtuse triangles, whose computed normal is nearly noise. */
static void slivers_are_not_met_again(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int i = 0; i < 300; i++) {
		float corners[3][3], along = shade_proof_uniform(&random);
		for (int k = 0; k < 3; k++) {
			corners[0][k] = shade_proof_range(&random, -1.0f, 1.0f);
			corners[1][k] = shade_proof_range(&random, -1.0f, 1.0f);
			corners[2][k] =
				corners[0][k] + (corners[1][k] - corners[0][k]) * along + shade_proof_log_range(&random, 1e-5f, 1e-1f);
		}
		stilb_scene *scene = world_scene(1, 1, 1);
		world_triangle(&scene->meshes[0], corners);
		world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
		for (int k = 0; k < 100; k++) {
			float u = shade_proof_uniform(&random), v = shade_proof_uniform(&random) * (1.0f - u);
			stilb_vec3 at = {0};
			for (int c = 0; c < 3; c++)
				at[c] = corners[0][c] * (1.0f - u - v) + corners[1][c] * u + corners[2][c] * v;
			stilb_vec3 towards = world_direction(&random);
			gi_ray_hit ray = gi_ray_hit_make(at - towards, towards);
			world.gi->tracer.intersect(&world.gi->tracer, &ray);
			if (!gi_is_hit(&ray))
				continue;
			gi_surface surface;
			gi_surface_at(world.gi, &ray, &surface);
			stilb_vec3 direction = cosine_direction(surface.geometric, &random);
			gi_ray_hit again = gi_ray_hit_make(gi_surface_ray_origin(&surface, direction), direction);
			world.gi->tracer.intersect(&world.gi->tracer, &again);
			assert_false(gi_is_hit(&again));
		}
		world_finish(&world);
	}
}

/* The offset is some roundings, and no more: what lies farther off is not passed. */
static void offsets_are_small(void **state)
{
	(void)state;
	world_fixture world = world_trace(sphere_scene(1.0f, stilb_vec3_make(0.0f, 0.0f, 0.0f), 3), &stilb_gi_embree, 0);
	gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.0f, 0.1f, 3.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
	world.gi->tracer.intersect(&world.gi->tracer, &ray);
	gi_surface surface;
	gi_surface_at(world.gi, &ray, &surface);
	assert_true(surface.front && surface.error > 0x1p-24f && surface.error < 10.0f * 0x1p-24f);
	stilb_vec3 outside = gi_surface_ray_origin(&surface, surface.geometric),
			   inside = gi_surface_ray_origin(&surface, -surface.geometric);
	assert_true(stilb_vec3_dot(outside - surface.position, surface.geometric) > 0.0f);
	assert_true(stilb_vec3_dot(inside - surface.position, surface.geometric) < 0.0f);
	world_finish(&world);
}

/* From points anywhere to points of a triangle far from the origin, ours and those that the light itself chooses:
 * nothing is in between. */
static void shadow_rays_end_at_the_light(void **state)
{
	(void)state;
	const float corners[3][3] = {{100.0f, 1.0f, 0.0f}, {103.0f, 1.5f, 0.5f}, {100.5f, 4.0f, 1.0f}};
	shade_proof_random random = {.seed = 9};
	stilb_scene *scene = world_scene(1, 1, 1);
	world_triangle(&scene->meshes[0], corners);
	world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
	const gi_tracer *tracer = &world.gi->tracer;
	stilb_vec3 corner[3];
	for (int i = 0; i < 3; i++)
		corner[i] = stilb_vec3_make(corners[i][0], corners[i][1], corners[i][2]);
	stilb_vec3 normal = stilb_vec3_normalize(stilb_vec3_cross(corner[1] - corner[0], corner[2] - corner[0]));
	gi_emitter emitter = {.emission = {1.0f, 1.0f, 1.0f}};
	memcpy(emitter.position, corners, sizeof corners);
	gi_light_shape light = gi_light_shape_make(&emitter);
	float error = gi_triangle_error(corners[0], corners[1], corners[2]);
	assert_true(error < 1e-4f);
	int asked = 0;
	for (int i = 0; i < 100000; i++) {
		float u = shade_proof_uniform(&random), v = shade_proof_uniform(&random) * (1.0f - u);
		stilb_vec3 at = corner[0] + ((corner[1] - corner[0]) * u + (corner[2] - corner[0]) * v);
		stilb_vec3 origin = at + world_direction(&random) * shade_proof_log_range(&random, 1e-2f, 1e3f);
		stilb_vec3 towards = at - origin;
		float distance = sqrtf(stilb_vec3_dot(towards, towards));
		stilb_vec3 direction = towards * (1.0f / distance);
		float cosine = fabsf(stilb_vec3_dot(direction, normal));
		if (cosine < 1e-3f)
			continue;
		gi_ray shadow = gi_ray_hit_make(origin, direction).ray;
		shadow.t_max = gi_shadow_distance(distance, error, cosine);
		tracer->occluded(tracer, &shadow, 1);
		assert_true(shadow.t_max >= 0.0f);
		gi_light_sample sample;
		if (!gi_light_shape_sample(&light, origin, (stilb_vec2){u, v}, &sample))
			continue;
		shadow = gi_ray_make(origin, sample.direction, sample.distance, 0.0f);
		tracer->occluded(tracer, &shadow, 1);
		assert_true(shadow.t_max >= 0.0f);
		asked++;
	}
	assert_true(asked > 40000);
	world_finish(&world);
}

/* ---- what a surface says ----------------------------------------------------------------------------------------- */

static const float unit_corners[3][3] = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};

static gi_surface surface_from(const stilb_gi_scene *gi, float z, float slant)
{
	gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.25f - slant * z, 0.5f, z),
	                                 stilb_vec3_normalize(stilb_vec3_make(slant * z, 0.0f, -z)));
	gi->tracer.intersect(&gi->tracer, &ray);
	assert_true(gi_is_hit(&ray));
	gi_surface surface;
	gi_surface_at(gi, &ray, &surface);
	return surface;
}

static void both_sides(void **state)
{
	(void)state;
	stilb_scene *scene = world_scene(1, 1, 1);
	world_triangle(&scene->meshes[0], unit_corners);
	scene->materials[0].emission[1] = 3.0f;
	scene->materials[0].specular[2] = 0.25f;
	world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
	gi_surface front = surface_from(world.gi, 1.0f, 0.0f), back = surface_from(world.gi, -1.0f, 0.0f);
	assert_true(front.front && !back.front);
	SHADE_PROOF_NEAR3(front.geometric, 0.0, 0.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(back.geometric, 0.0, 0.0, -1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(back.normal, 0.0, 0.0, -1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(front.emission, 0.0, 3.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(back.emission, 0.0, 0.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(front.position, 0.25, 0.5, 0.0, 0.0, 1e-7);
	SHADE_PROOF_NEAR3(front.diffuse, 0.5, 0.5, 0.5, 0.0, 0.0);
	SHADE_PROOF_NEAR3(front.specular, 0.0, 0.0, 0.25, 0.0, 0.0);
	SHADE_PROOF_NEAR(front.uv[0], 0.25, 0.0, 1e-7);
	SHADE_PROOF_NEAR(front.uv[1], 0.5, 0.0, 1e-7);
	world_finish(&world);
}

/* A file's normals may point the other way, be none, or lean so far that the viewer is below their horizon. */
static void shading_normals_see_the_viewer(void **state)
{
	(void)state;
	static const float normals[][3] = {{0.0f, 0.0f, -1.0f},   {0.0f, 0.0f, 0.0f}, {NAN, 1.0f, 0.0f},
	                                   {0.999f, 0.0f, 0.04f}, {0.6f, 0.0f, 0.8f}, {INFINITY, 0.0f, 0.0f}};
	for (size_t i = 0; i < sizeof normals / sizeof *normals; i++) {
		stilb_scene *scene = world_scene(1, 1, 1);
		world_triangle(&scene->meshes[0], unit_corners);
		for (int k = 0; k < 3; k++)
			memcpy(scene->meshes[0].vertices[k].normal, normals[i], sizeof normals[i]);
		world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
		for (float slant = 0.0f; slant < 3.0f; slant += 1.0f) {
			gi_surface surface = surface_from(world.gi, 1.0f, slant); /* from -x */
			stilb_vec3 to_viewer = stilb_vec3_normalize(stilb_vec3_make(-slant, 0.0f, 1.0f));
			SHADE_PROOF_NEAR(stilb_vec3_dot(surface.normal, surface.normal), 1.0, 0.0, 1e-6);
			assert_true(stilb_vec3_dot(surface.normal, to_viewer) > 0.0f);
			assert_true(surface.normal[2] > 0.0f);
			if (i < 3 || i == 5)
				SHADE_PROOF_NEAR3(surface.normal, 0.0, 0.0, 1.0, 0.0, 1e-6);
			if (i == 4 && slant == 0.0f)
				SHADE_PROOF_NEAR3(surface.normal, 0.6, 0.0, 0.8, 0.0, 1e-6);
		}
		world_finish(&world);
	}
}

/* A texture of 2 x 2 texels: at their middles their own colour, between them the mean, and repeated. */
static void textures(void **state)
{
	(void)state;
	static float texels[2][2][3] = {{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}}, {{0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.0f}}};
	static uint8_t codes[2][2][1] = {{{255}, {0}}, {{188}, {255}}};
	stilb_image linear = {2, 2, 3, STILB_IMAGE_F32_LINEAR, texels, 0}, srgb = {2, 2, 1, STILB_IMAGE_U8_SRGB, codes, 0};
	static uint16_t halves[2][2][1] = {{{0x3c00}, {0x0001}}, {{0xb800}, {0x7bff}}};
	stilb_image half = {2, 2, 1, STILB_IMAGE_F16_LINEAR, halves, 0};
	stilb_image data = {2, 2, 1, STILB_IMAGE_U8_LINEAR, codes, 0};
	static uint16_t words[2][2][1] = {{{65535}, {0}}, {{48316}, {13107}}};
	stilb_image fine = {2, 2, 1, STILB_IMAGE_U16_SRGB, words, 0},
				fine_data = {2, 2, 1, STILB_IMAGE_U16_LINEAR, words, 0};
	for (float turn = -2.0f; turn < 3.0f; turn += 1.0f) {
		SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){0.25f + turn, 0.25f}), 1.0, 0.0, 0.0, 0.0, 1e-6);
		SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){0.75f, 0.25f + turn}), 0.0, 1.0, 0.0, 0.0, 1e-6);
		SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){0.25f + turn, 0.75f}), 0.0, 0.0, 1.0, 0.0, 1e-6);
	}
	SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){0.5f, 0.25f}), 0.5, 0.5, 0.0, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){0.0f, 0.5f}), 0.5, 0.5, 0.5, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(gi_texture_at(&linear, (stilb_vec2){NAN, INFINITY}), 0.5, 0.5, 0.5, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(gi_texture_at(&srgb, (stilb_vec2){0.25f, 0.75f}), 0.5029, 0.5029, 0.5029, 0.0, 1e-4);
	SHADE_PROOF_NEAR3(gi_texture_at(&fine, (stilb_vec2){0.25f, 0.75f}), 0.5029, 0.5029, 0.5029, 0.0, 1e-4);
	SHADE_PROOF_NEAR(gi_texture_at(&data, (stilb_vec2){0.25f, 0.75f})[0], 188.0 / 255.0, 0.0, 1e-6);
	SHADE_PROOF_NEAR(gi_texture_at(&fine_data, (stilb_vec2){0.75f, 0.75f})[0], 0.2, 0.0, 1e-6);
	SHADE_PROOF_NEAR(gi_texture_at(&fine_data, (stilb_vec2){0.25f, 0.25f})[0], 1.0, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(gi_texture_at(&half, (stilb_vec2){0.25f, 0.25f}), 1.0, 1.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(gi_texture_at(&half, (stilb_vec2){0.75f, 0.25f})[0], ldexp(1.0, -24), 0.0, 1e-12);
	SHADE_PROOF_NEAR(gi_texture_at(&half, (stilb_vec2){0.25f, 0.75f})[0], -0.5, 0.0, 0.0);
	SHADE_PROOF_NEAR(gi_texture_at(&half, (stilb_vec2){0.75f, 0.75f})[0], 65504.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(gi_texture_at(&(stilb_image){0}, (stilb_vec2){0.0f, 0.0f}), 1.0, 1.0, 1.0, 0.0, 0.0);
}

static void textures_colour_the_surface(void **state)
{
	(void)state;
	static float texel[3] = {1.0f, 0.5f, 0.0f};
	stilb_scene *scene = world_scene(1, 1, 1);
	world_triangle(&scene->meshes[0], unit_corners);
	scene->materials[0].diffuse_texture = 1;
	stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
	scene->texture_count = 1;
	scene->textures = &image;
	world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
	SHADE_PROOF_NEAR3(surface_from(world.gi, 1.0f, 0.0f).diffuse, 0.5, 0.25, 0.0, 0.0, 1e-6);
	scene->texture_count = 0;
	scene->textures = NULL;
	world_finish(&world);
}

/* The same codes as colour and as data, and as other channels, are other scenes: no checkpoint of one is another's. */
static void the_hash_knows_formats(void **state)
{
	(void)state;
	static uint8_t codes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
	static const stilb_image images[] = {{2, 1, 2, STILB_IMAGE_U8_SRGB, codes, 0},
	                                     {2, 1, 2, STILB_IMAGE_U8_LINEAR, codes, 0},
	                                     {2, 1, 1, STILB_IMAGE_U16_SRGB, codes, 0},
	                                     {2, 1, 1, STILB_IMAGE_F16_LINEAR, codes, 0}};
	uint64_t hashes[4];
	for (int i = 0; i < 4; i++) {
		stilb_scene *scene = world_scene(1, 1, 1);
		stilb_image image = images[i];
		world_triangle(&scene->meshes[0], unit_corners);
		scene->materials[0].diffuse_texture = 1;
		scene->texture_count = 1;
		scene->textures = &image;
		world_fixture world = world_trace(scene, &stilb_gi_embree, 0);
		hashes[i] = gi_scene_hash(world.gi);
		for (int k = 0; k < i; k++)
			assert_true(hashes[k] != hashes[i]);
		scene->texture_count = 0;
		scene->textures = NULL;
		world_finish(&world);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(furnaces_lose_no_ray),
		cmocka_unit_test(boxes_lose_no_ray),
		cmocka_unit_test(without_an_offset_rays_are_lost),
		cmocka_unit_test(instances_lose_no_ray),
		cmocka_unit_test(slivers_are_not_met_again),
		cmocka_unit_test(offsets_are_small),
		cmocka_unit_test(shadow_rays_end_at_the_light),
		cmocka_unit_test(both_sides),
		cmocka_unit_test(shading_normals_see_the_viewer),
		cmocka_unit_test(textures),
		cmocka_unit_test(textures_colour_the_surface),
		cmocka_unit_test(the_hash_knows_formats),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
