/* The formulas that a view chooses, on the GPU, compared with the same headers compiled as C: every model, every light,
 * the values added to materials, in every replay mode. Pipelines are created when they are first needed. */
#include "render/render_internal.h"
#include "shading/shade_energy.h"
#include "shading/shade_surface.h"
#include "support/picture_reference.h"

#define WIDTH 72u
#define HEIGHT 56u
#define PLACES 5

/* What rays through each pixel hit: [0] at its centre, the others up to a hundredth of a pixel beside it. The pixel may
 * show any of these points, because rasterisers snap vertices to a grid of 1/256 pixel. */
static reference_hit hits[HEIGHT][WIDTH][PLACES];
static stilb_scene *scene;
static reference_camera camera;

typedef struct stage {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_render_view view;
} stage;

static float clamped(float value, float low, float high)
{
	return fminf(fmaxf(value, low), high);
}

static stilb_vec3 vec_of(const float v[3])
{
	return stilb_vec3_make(v[0], v[1], v[2]);
}

static stilb_vec3 vec_of_dvec(dvec v)
{
	return stilb_vec3_make((float)v.x, (float)v.y, (float)v.z);
}

/* The lights of this test; a view shows listed of them from first_listed on. */
static const stilb_scene_light list[] = {
	{.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.8f, -0.36f}, .intensity = {3.0f, 2.5f, 2.0f}},
	{.kind = STILB_SCENE_LIGHT_POINT, .position = {0.9f, 1.6f, 1.1f}, .intensity = {2.0f, 0.5f, 0.3f}},
	{.kind = STILB_SCENE_LIGHT_SPOT,
     .position = {-1.5f, 2.5f, 0.5f},
     .direction = {0.48f, -0.8f, -0.36f},
     .intensity = {3.0f, 6.0f, 9.0f},
     .cos_inner = 0.98f,
     .cos_outer = 0.85f},
	{.kind = STILB_SCENE_LIGHT_SPOT,
     .position = {1.0f, 3.0f, 2.0f},
     .direction = {0.0f, -1.0f, 0.0f},
     .intensity = {4.0f, 4.0f, 0.5f},
     .cos_inner = 0.8f,
     .cos_outer = 0.7f,
     .falloff = STILB_SCENE_LIGHT_WINDOWED,
     .reach = 5.0f},
#define LAMP .position = {0.4f, 2.2f, 0.9f}, .direction = {0.0f, -0.8f, -0.6f}, .intensity = {9.0f, 7.0f, 5.0f}
	{.kind = STILB_SCENE_LIGHT_SPHERE, LAMP, .radius = 0.4f},
	{.kind = STILB_SCENE_LIGHT_DISK, LAMP, .radius = 0.4f},
	{.kind = STILB_SCENE_LIGHT_SPHERE, LAMP, .radius = 0.4f, .falloff = STILB_SCENE_LIGHT_WINDOWED, .reach = 2.3f},
	{.kind = STILB_SCENE_LIGHT_SPHERE, LAMP, .radius = 0.4f, .falloff = STILB_SCENE_LIGHT_SUBTRACTED, .reach = 2.3f},
	{.kind = STILB_SCENE_LIGHT_RECTANGLE, LAMP, .half_x = {0.5f, 0.0f, 0.0f}, .half_y = {0.0f, 0.12f, -0.16f}},
};
#define LISTED (sizeof list / sizeof *list)
static uint32_t first_listed, listed = 1;
static bool glossy;

/* ---- the scene: a sphere over a tile, near the lights, with materials that use every term of the formulas
 * ------------- */

static void make_scene(void)
{
	scene = reference_scene(2);
	scene->part_mesh[1] = 1;
	scene->part_transform[0] = stilb_mat4_scale_translate(0.7f, 0.0f, 0.75f, 0.0f);
	scene->materials[0] = (stilb_scene_material){.diffuse = {0.5f, 0.2f, 0.1f},
	                                             .specular = {0.2f, 0.3f, 0.4f},
	                                             .roughness = 0.55f,
	                                             .anisotropy = 0.6f,
	                                             .wrap = 0.3f,
	                                             .emission = {0.05f, 0.0f, 0.1f}};
	scene->materials[1] = (stilb_scene_material){
		.diffuse = {0.1f, 0.3f, 0.6f}, .specular = {0.4f, 0.2f, 0.1f}, .roughness = 0.8f, .anisotropy = -0.3f};
	scene->lights[0] = list[0];
	scene->surroundings = (stilb_scene_surroundings){.sky = {0.3f, 0.45f, 0.8f}, .ground = {0.2f, 0.1f, 0.05f}};
	camera = reference_camera_at((dvec){1.7, 2.6, 3.1}, (dvec){0.1, 0.4, -0.1}, (dvec){0, 1, 0}, 1.9, WIDTH, HEIGHT);
}

static int trace_scene(void **state)
{
	(void)state;
	static const double places[PLACES][2] = {{0.5, 0.5}, {0.49, 0.49}, {0.51, 0.49}, {0.49, 0.51}, {0.51, 0.51}};
	make_scene();
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int p = 0; p < PLACES; p++)
				hits[y][x][p] =
					reference_trace(scene, camera.position, reference_ray(&camera, x + places[p][0], y + places[p][1]));
	return 0;
}

static int drop_scene(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	return 0;
}

/* ---- the expected values, computed in C -------------------------------------------------------------------------- */

static shade_material expected_material(const stilb_scene_material *m, const stilb_render_shading *shading)
{
	shade_reflectance reflectance = {vec_of(m->diffuse), vec_of(m->specular)};
	stilb_vec3 added = stilb_vec3_make(shading->specular, shading->specular, shading->specular);
	if (shading->specular != 0.0f)
		reflectance = shade_limit_to_one(reflectance.diffuse, reflectance.specular + added);
	return (shade_material){
		.diffuse = reflectance.diffuse,
		.specular = reflectance.specular,
		.roughness = clamped(m->roughness + shading->roughness, 0.0f, 1.0f),
		.anisotropy = clamped(m->anisotropy + shading->anisotropy, -1.0f, 1.0f),
		.wrap = clamped(m->wrap + shading->wrap, 0.0f, 1.0f),
	};
}

static shade_light expected_light(const stilb_scene_light *light)
{
	return (shade_light){
		.kind = (int)light->kind,
		.falloff = (int)light->falloff,
		.position = vec_of(light->position),
		.direction = vec_of(light->direction),
		.intensity = vec_of(light->intensity),
		.cos_inner = light->cos_inner,
		.cos_outer = light->cos_outer,
		.radius = light->radius,
		.half_x = vec_of(light->half_x),
		.half_y = vec_of(light->half_y),
		.reach = light->reach,
	};
}

static stilb_vec3 expected_radiance(const reference_hit *hit, const stilb_render_shading *shading)
{
	shade_brdf_model model = {(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
	shade_material material = expected_material(&scene->materials[hit->part], shading);
	shade_sky sky = {vec_of(scene->surroundings.sky), vec_of(scene->surroundings.ground)};
	stilb_vec3 n = vec_of_dvec(hit->normal);
	stilb_vec3 v = vec_of_dvec(dvec_unit(dvec_mad(camera.position, -1.0, hit->position)));
	material = shade_surface_seen(model, material, stilb_vec3_dot(n, v));
	shade_frame frame = shade_frame_from_tangent(n, stilb_vec3_make(n[2], 0.0f, -n[0]));
	stilb_vec3 radiance = shade_surface_sky(material, sky, n) + vec_of(scene->materials[hit->part].emission);
	for (uint32_t i = first_listed; i < first_listed + listed; i++)
		radiance +=
			shade_surface_light(model, material, frame, expected_light(&list[i]), vec_of_dvec(hit->position), v);
	if (glossy && shading->brdf > SHADE_BRDF_WRAPPED) {
		float exponent = shade_exponent_from_alpha(shade_alpha_from_roughness(material.roughness));
		float mirrored_y = 2.0f * stilb_vec3_dot(n, v) * n[1] - v[1];
		radiance += material.specular *
		            shade_hemisphere_radiance(mirrored_y, shade_exponent_about_r(exponent), sky.sky, sky.ground);
	}
	return radiance;
}

/* Checks each pixel whose points (`hits`) all lie on the same part of the model: its value must lie between the least
 * and the highest radiance that C computes for them. */
static void assert_as_in_c(const stilb_image *image, const stilb_render_shading *shading)
{
	uint32_t seen[2] = {0};
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {0};
			uint32_t part = hits[y][x][0].part;
			bool sure = part != REFERENCE_MISS;
			for (int p = 0; p < PLACES && sure; p++) {
				sure = hits[y][x][p].part == part;
				stilb_vec3 radiance = sure ? expected_radiance(&hits[y][x][p], shading) : (stilb_vec3){0};
				for (int c = 0; c < 3; c++) {
					low[c] = fmin(low[c], (double)radiance[c]);
					high[c] = fmax(high[c], (double)radiance[c]);
				}
			}
			if (!sure)
				continue;
			seen[part]++;
			assert_pixel_between(image, x, y, low, high, 3e-3);
		}
	assert_true(seen[0] > 200 && seen[1] > 200);
}

/* ---- on the GPU -------------------------------------------------------------------------------------------------- */

static stage stage_make(int way)
{
	stilb_render_desc desc = {
		.replay = (stilb_render_replay_mode)(way % 3),
		.materials = (stilb_render_materials)(way / 3),
		.output = STILB_RENDER_OUTPUT_LINEAR,
		.width = WIDTH,
		.height = HEIGHT,
		.samples = 1,
		.context_count = 3,
		.validate = true,
	};
	stage s = {.view = {.view_projection = reference_matrix(&camera),
	                    .camera_position = {1.7f, 2.6f, 3.1f},
	                    .lights = list,
	                    .light_count = 1,
	                    .surroundings = scene->surroundings}};
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &s.pool), 0);
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_set_scene(s.render, scene), STILB_OK);
	return s;
}

static void stage_finish(stage *s)
{
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_job_pool_destroy(s->pool);
}

static stilb_image stage_draw(stage *s, const stilb_render_shading *shading)
{
	static const stilb_render_pass pass = {.name = "main"};
	uint32_t model = 0;
	stilb_image image = {0};
	s->view.shading = *shading;
	s->view.lights = list + first_listed;
	s->view.light_count = listed;
	s->view.surroundings.glossy = glossy;
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_record(s->render, 0, scene, &model, 1, s->pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, &s->view, 1, s->pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(s->render, &image), STILB_OK);
	return image;
}

static void assert_drawn(stage *s, const stilb_render_shading *shading)
{
	stilb_image image = stage_draw(s, shading);
	assert_as_in_c(&image, shading);
	stilb_image_finish(&image);
}

static stilb_render_shading microfacets(uint32_t ndf, uint32_t g, uint32_t f)
{
	return (stilb_render_shading){.brdf = SHADE_BRDF_MICROFACET, .ndf = ndf, .g = g, .f = f};
}

static void every_model_is_as_in_c(void **state)
{
	(void)state;
	stage s = stage_make(0);
	for (uint32_t brdf = 0; brdf < SHADE_BRDF_MICROFACET; brdf++)
		assert_drawn(&s, &(stilb_render_shading){.brdf = brdf});
	for (uint32_t ndf = 0; ndf < SHADE_NDF_COUNT; ndf++)
		for (uint32_t g = 0; g < SHADE_G_COUNT; g++) {
			stilb_render_shading shading = microfacets(ndf, g, (ndf + g) % SHADE_F_COUNT);
			assert_drawn(&s, &shading);
		}
	stage_finish(&s);
}

static void draw_two_models(stage *s)
{
	stilb_render_shading shading = microfacets(SHADE_NDF_GGX_ANISOTROPIC, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK);
	assert_drawn(s, &shading);
	assert_drawn(s, &(stilb_render_shading){.brdf = SHADE_BRDF_WRAPPED});
}

static void every_light_is_as_in_c(void **state)
{
	(void)state;
	stage s = stage_make(0);
	for (first_listed = 0; first_listed < LISTED; first_listed++)
		draw_two_models(&s);
	first_listed = listed = 0; /* the sky alone */
	for (int way = 0; way < 2; way++) {
		glossy = way;
		draw_two_models(&s);
	}
	glossy = false;
	listed = 1;
	stage_finish(&s);
}

/* Twice: the first frame has no memory for lights yet, the second has. */
static void a_list_of_lights_is_as_in_c(void **state)
{
	(void)state;
	for (int way = 0; way < 3; way++) {
		stage s = stage_make(way);
		for (listed = way ? LISTED : 2; listed <= LISTED; listed += LISTED - 2) /* all kinds in one shader take long */
			assert_drawn(&s, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT});
		listed = 1;
		stage_finish(&s);
	}
}

static void what_is_added_to_materials(void **state)
{
	(void)state;
	static const float steps[] = {-1.0f, -0.3f, 0.25f, 1.0f};
	stage s = stage_make(0);
	for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
		stilb_render_shading shading = microfacets(SHADE_NDF_GGX_ANISOTROPIC, SHADE_G_SCHLICK_GGX, SHADE_F_SCHLICK);
		shading.roughness = fmaxf(steps[i], -0.3f); /* a mirror's highlight would be smaller than a pixel */
		assert_drawn(&s, &shading);
		shading.anisotropy = 0.7f * steps[i];
		assert_drawn(&s, &shading);
		shading.wrap = steps[i];
		assert_drawn(&s, &shading);
		shading.specular = steps[i];
		assert_drawn(&s, &shading);
	}
	stage_finish(&s);
}

/* With secondary command buffers pipelines are bound on other threads than the one that creates them. */
static void the_same_in_every_way_of_replay(void **state)
{
	(void)state;
	stilb_render_shading choices[] = {
		stilb_render_shading_default(),
		{.brdf = SHADE_BRDF_PHONG},
		microfacets(SHADE_NDF_BECKMANN, SHADE_G_NEUMANN, SHADE_F_COOK_TORRANCE),
		{.brdf = SHADE_BRDF_PHONG}, /* the second choice again */
	};
	enum { CHOICES = sizeof choices / sizeof *choices };
	stilb_image first[CHOICES];
	for (int way = 0; way < 9; way++) {
		stage s = stage_make(way);
		for (int c = 0; c < CHOICES; c++) {
			stilb_image image = stage_draw(&s, &choices[c]);
			if (way == 0) {
				first[c] = image;
				continue;
			}
			assert_memory_equal(image.pixels, first[c].pixels, stilb_image_size(&image));
			stilb_image_finish(&image);
		}
		stage_finish(&s);
	}
	assert_memory_equal(first[1].pixels, first[3].pixels, stilb_image_size(&first[1]));
	assert_memory_not_equal(first[0].pixels, first[1].pixels, stilb_image_size(&first[1]));
	for (int c = 0; c < CHOICES; c++)
		stilb_image_finish(&first[c]);
}

static void record_part(stage *s, uint32_t pass, uint32_t part)
{
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	assert_int_equal(stilb_render_pass_begin(s->render, pass, 1), STILB_OK);
	stilb_render_segment_begin(context, pass, 0);
	stilb_render_draw(context, stilb_render_scene_mesh(s->render, scene->part_mesh[part]),
	                  stilb_render_scene_material(s->render, scene->part_material[part]), &scene->part_transform[part]);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, pass), STILB_OK);
}

/* The sphere in one pass, the tile in another with other formulas. */
static void each_pass_has_its_views_formulas(void **state)
{
	(void)state;
	static const stilb_render_pass passes[2] = {{.name = "sphere"}, {.name = "tile", .view = 1, .order = 1}};
	for (int way = 0; way < 3; way++) {
		stage s = stage_make(way);
		stilb_render_view views[2] = {s.view, s.view};
		stilb_image image;
		views[0].shading = microfacets(SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK);
		views[1].shading = (stilb_render_shading){.brdf = SHADE_BRDF_PHONG};
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		for (uint32_t part = 0; part < 2; part++)
			record_part(&s, part, part);
		assert_int_equal(stilb_render_replay(s.render, passes, 2, views, 2, s.pool, 0), STILB_OK);
		assert_int_equal(stilb_render_read_image(s.render, &image), STILB_OK);
		for (uint32_t part = 0; part < 2; part++) {
			stilb_image whole = stage_draw(&s, &views[part].shading);
			for (uint32_t y = 0; y < HEIGHT; y++)
				for (uint32_t x = 0; x < WIDTH; x++)
					for (int c = 0; c < 3 && hits[y][x][0].part == part && hits[y][x][4].part == part; c++)
						assert_true(picture_value(&image, x, y, c) == picture_value(&whole, x, y, c));
			stilb_image_finish(&whole);
		}
		stilb_image_finish(&image);
		stage_finish(&s);
	}
}

/* ---- pipelines --------------------------------------------------------------------------------------------------- */

static const render_programs *programs_of(const stage *s)
{
	return &s->render->device->programs;
}

static void draw_and_drop(stage *s, const stilb_render_shading *shading)
{
	stilb_image image = stage_draw(s, shading);
	stilb_image_finish(&image);
}

static void pipelines_are_made_when_needed_and_kept(void **state)
{
	(void)state;
	stage s = stage_make(0);
	stilb_render_shading shading = {.brdf = SHADE_BRDF_MINIMALIST};
	assert_int_equal(programs_of(&s)->choice_count, 0);
	draw_and_drop(&s, &shading);
	assert_int_equal(programs_of(&s)->choice_count, 1);
	uint32_t made = programs_of(&s)->choices[0]->programs[0][0][RENDER_DRAWN_ALL].id;
	assert_true(made != 0);
	/* There are no textures. */
	assert_int_equal(programs_of(&s)->choices[0]->programs[0][1][RENDER_DRAWN_ALL].id, 0);
	shading.ndf = shading.g = shading.f = 1; /* not read: the model is no microfacet one */
	shading.roughness = 0.5f;                /* not part of the pipeline */
	draw_and_drop(&s, &shading);
	assert_int_equal(programs_of(&s)->choice_count, 1);
	for (int round = 0; round < 2; round++)
		for (uint32_t g = 0; g < SHADE_G_COUNT; g++) {
			shading = microfacets(SHADE_NDF_GGX, g, SHADE_F_NONE);
			draw_and_drop(&s, &shading);
		}
	assert_int_equal(programs_of(&s)->choice_count, 1 + SHADE_G_COUNT);
	assert_int_equal(programs_of(&s)->choices[0]->programs[0][0][RENDER_DRAWN_ALL].id, made);
	stage_finish(&s);
}

/* A draw with a texture needs another pipeline, also for formulas that have one without a texture. */
static void textures_have_pipelines_of_their_own(void **state)
{
	(void)state;
	static const stilb_render_pass pass = {.name = "main"};
	uint8_t codes[4] = {255, 255, 255, 255};
	stilb_image white = {1, 1, 4, STILB_IMAGE_U8_SRGB, codes, 0};
	stage s = stage_make(0);
	stilb_render_texture texture;
	stilb_render_material material;
	stilb_image image;
	stilb_render_shading shading = microfacets(SHADE_NDF_BLINN, SHADE_G_KELEMEN, SHADE_F_SCHLICK);
	draw_and_drop(&s, &shading);
	assert_int_equal(stilb_render_texture_create(s.render, &white, &texture), STILB_OK);
	assert_int_equal(stilb_render_material_create(s.render, &scene->materials[0], texture, &material), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s.render, 0);
	assert_int_equal(stilb_render_pass_begin(s.render, 0, 1), STILB_OK);
	stilb_render_segment_begin(context, 0, 0);
	stilb_render_draw(context, stilb_render_scene_mesh(s.render, 1), stilb_render_scene_material(s.render, 1),
	                  &scene->part_transform[1]);
	stilb_render_draw(context, stilb_render_scene_mesh(s.render, 0), material, &scene->part_transform[0]);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s.render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s.render, &pass, 1, &s.view, 1, s.pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(s.render, &image), STILB_OK);
	assert_as_in_c(&image, &shading); /* white changes nothing */
	assert_int_equal(programs_of(&s)->choice_count, 1);
	assert_int_not_equal(programs_of(&s)->choices[0]->programs[0][1][RENDER_DRAWN_ALL].id, 0);
	stilb_image_finish(&image);
	stage_finish(&s);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	struct CMUnitTest tests[] = {
		test_no_asan(every_model_is_as_in_c),
		cmocka_unit_test(every_light_is_as_in_c),
		cmocka_unit_test(a_list_of_lights_is_as_in_c),
		cmocka_unit_test(what_is_added_to_materials),
		test_no_asan(the_same_in_every_way_of_replay),
		cmocka_unit_test(each_pass_has_its_views_formulas),
		cmocka_unit_test(pipelines_are_made_when_needed_and_kept),
		cmocka_unit_test(textures_have_pipelines_of_their_own),
	};
	return cmocka_run_group_tests(tests, trace_scene, drop_scene);
}
