/* Transmission in frames: what is seen through squares before a square whose colour tells the place, and light from
 * behind. */
#include "shading/shade_gltf.h"
#include "shading/shade_layers.h"

#include "maps_stage.h" /* names a type as these name variables */

#define SIDE 64u
#define DEEP 1.0f /* metres from the square with the places, at y = -DEEP, to the one that is seen through */

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* A square behind, of twice the size: red grows from 0 to 1 to the right, green downwards, both linearly. It shows its
 * colour alone. */
static void places_build(stilb_scene_build *build)
{
	square q;
	square_make(&q, 1.0f);
	for (int v = 0; v < 4; v++)
		for (int c = 0; c < 2; c++)
			q.extras[v].color[c] = q.vertices[v].uv[c];
	stilb_scene_surface surface = surface_unlit();
	stilb_mat4 place = stilb_mat4_scale_translate(2.0f, 0.0f, -DEEP, 0.0f);
	stage_model(build, stilb_scene_build_mesh(build, &q.mesh), stage_material(build, &surface), place);
}

/* Adds a square like the stage's at this height, all of which is seen. */
static void pane_build(stilb_scene_build *build, const stilb_scene_surface *surface, float scale, float y)
{
	square q;
	square_make(&q, 1.0f);
	stage_model(build, stilb_scene_build_mesh(build, &q.mesh), stage_material(build, surface),
	            stilb_mat4_scale_translate(scale, 0.0f, y, 0.0f));
}

static stage through_stage(uint32_t samples)
{
	stage s = stage_open((stilb_render_desc){.width = SIDE, .samples = samples}, 0);
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	s.view.shading = (stilb_render_shading){
		.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	return s;
}

/* Glass that reflects nothing but at grazing angles. */
static stilb_scene_surface glass(void)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.specular_weight = 0.0f;
	surface.roughness = 0.0f;
	surface.transmission = 1.0f;
	return surface;
}

/* A frame of a pane in front of the places. */
static stilb_image seen_through(stage *s, const stilb_scene_surface *surface, float scale)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	pane_build(build, surface, scale, 0.0f); /* before what is behind it: the frame turns that around */
	places_build(build);
	stage_show(s, build);
	return stage_picture(s);
}

/* What the square behind shows to the camera in this direction, of any length: [0, 1]. */
static void place_seen(const float d[3], double out[2])
{
	float away = (4.0f + DEEP) / -d[1];
	out[0] = 0.5 + (double)(d[0] * away) / 4.0;
	out[1] = 0.5 + (double)(d[2] * away) / 4.0;
}

static double channel(const stilb_image *image, uint32_t x, uint32_t y, int c)
{
	return picture_value(image, x, y, c);
}

/* Where the middle of a pixel is on the pane, of -1 .. 1. */
static float on_pane(uint32_t pixel)
{
	return 2.0f * ((float)pixel + 0.5f) / (float)SIDE - 1.0f;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Thin and clear: what is behind, tinted; with few samples and several. */
static void thin_walls_tint(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stage s = through_stage(samples);
		stilb_scene_surface surface = glass();
		reference_set3(surface.color, 0.5f, 0.25f, 1.0f);
		stilb_image picture = seen_through(&s, &surface, 1.0f);
		for (uint32_t y = 0; y < SIDE; y += 3)
			for (uint32_t x = 0; x < SIDE; x += 3) {
				double want[2];
				place_seen((float[3]){on_pane(x), -4.0f, on_pane(y)}, want);
				assert_near("red", channel(&picture, x, y, 0), 0.5 * want[0], 2e-3);
				assert_near("green", channel(&picture, x, y, 1), 0.25 * want[1], 2e-3);
			}
		stilb_image_finish(&picture);
		stage_close(&s);
	}
}

/* A share of the diffuse light goes through, the rest stays; where the map says nothing, all of it. */
static void shares_go_through(void **state)
{
	(void)state;
	static const uint8_t codes[4] = {128, 0, 0, 255};
	stage s = through_stage(1);
	reference_set3(s.view.surroundings.sky, 1.0f, 1.0f, 1.0f);
	stilb_image map = image_even(3, codes, STILB_IMAGE_U8_LINEAR);
	stilb_scene_surface surface = glass();
	surface.transmission = 0.5f;
	surface.maps[STILB_SCENE_MAP_TRANSMISSION].texture = 1;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_texture(build, &map);
	places_build(build);
	pane_build(build, &surface, 1.0f, 0.0f);
	stage_show(&s, build);
	stilb_image picture = stage_picture(&s);
	double share = 0.5 * 128.0 / 255.0, want[2];
	place_seen((float[3]){on_pane(40), -4.0f, on_pane(20)}, want);
	assert_near("red", channel(&picture, 40, 20, 0), 1.0 - share + share * want[0], 4e-3);
	assert_near("green", channel(&picture, 40, 20, 1), 1.0 - share + share * want[1], 4e-3);
	stilb_image_finish(&picture);
	stilb_image_finish(&map);
	stage_close(&s);
}

/* Solid: refracted, and darkened by the way inside. Scale 1.25 makes thickness grow with the model. */
static void solids_refract(void **state)
{
	(void)state;
	stage s = through_stage(1);
	stilb_scene_surface surface = glass();
	surface.ior = 1.5f;
	surface.thickness = 1.2f;
	surface.attenuation[0] = 0.5f;
	surface.attenuation_distance = 2.0f;
	stilb_image picture = seen_through(&s, &surface, 1.25f);
	double apart = 0.0;
	for (uint32_t y = 2; y < SIDE - 2; y += 3)
		for (uint32_t x = 2; x < SIDE - 2; x += 3) {
			float px = on_pane(x), pz = on_pane(y), length = sqrtf(px * px + 16.0f + pz * pz);
			/* Snell: what lies along the surface becomes 1 / 1.5 of it. */
			float ix = px / length / 1.5f, iz = pz / length / 1.5f, iy = -sqrtf(1.0f - ix * ix - iz * iz);
			float way = 1.2f * 1.25f, leaves[3] = {px + way * ix, way * iy - 4.0f, pz + way * iz};
			double want[2], left = pow(0.5, (double)way / 2.0), straight[2];
			place_seen(leaves, want);
			place_seen((float[3]){px, -4.0f, pz}, straight);
			apart = fmax(apart, fabs(straight[0] - want[0]));
			assert_near("red", channel(&picture, x, y, 0), left * want[0], 3e-3);
			assert_near("green", channel(&picture, x, y, 1), want[1], 3e-3);
		}
	assert_true(apart > 0.02); /* that it refracts is seen */
	stilb_image_finish(&picture);
	stage_close(&s);
}

/* Blur keeps what grows linearly where it is, and an even colour everywhere; it is no change of brightness. An edge
 * becomes wider the farther it is behind the pane. */
static void rough_ones_blur(void **state)
{
	(void)state;
	stage s = through_stage(1);
	stilb_scene_surface surface = glass();
	surface.roughness = 0.25f;
	stilb_image picture = seen_through(&s, &surface, 1.0f);
	for (uint32_t x = SIDE / 4; x < 3 * SIDE / 4; x++) {
		double want[2];
		place_seen((float[3]){on_pane(x), -4.0f, on_pane(x)}, want);
		assert_near("red", channel(&picture, x, x, 0), want[0], 0.02);
		assert_near("blue", channel(&picture, x, x, 2), 1.0, 0.01);
	}
	stilb_image_finish(&picture);
	double widths[3];
	surface.roughness = 0.5f;
	for (int i = 0; i < 3; i++) { /* black to the left, white to the right */
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_surface white = surface_unlit(), black = surface_unlit();
		float y = -0.1f - 0.4f * (float)i;
		reference_set3(black.color, 0.0f, 0.0f, 0.0f);
		square q;
		square_make(&q, 1.0f);
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
		stage_model(build, mesh, stage_material(build, &black), stilb_mat4_scale_translate(3.0f, -3.0f, y, 0.0f));
		stage_model(build, mesh, stage_material(build, &white), stilb_mat4_scale_translate(3.0f, 3.0f, y, 0.0f));
		pane_build(build, &surface, 1.0f, 0.0f);
		stage_show(&s, build);
		picture = stage_picture(&s);
		widths[i] = 0.0; /* how many pixels are neither black nor white */
		for (uint32_t x = 0; x < SIDE; x++)
			widths[i] += fmin(channel(&picture, x, 32, 0), 1.0 - channel(&picture, x, 32, 0));
		stilb_image_finish(&picture);
	}
	print_message("edges %.2f %.2f %.2f pixels\n", widths[0], widths[1], widths[2]);
	assert_true(widths[0] < 0.6 * widths[1] && widths[1] < 0.8 * widths[2]);
	stage_close(&s);
}

/* What is opaque is seen through a pane wherever it comes in the order; what blends lies over it. */
static void the_order_is_right(void **state)
{
	(void)state;
	for (int sorted = 0; sorted < 2; sorted++) {
		stage s = through_stage(1);
		s.sort = sorted;
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_surface pane = glass(), over = surface_unlit(), red = surface_unlit();
		over.alpha = STILB_SCENE_BLEND;
		over.color[3] = 0.25f;
		reference_set3(red.color, 1.0f, 0.0f, 0.0f);
		reference_set3(pane.color, 0.5f, 0.5f, 0.5f);
		pane_build(build, &over, 1.0f, 0.5f);
		pane_build(build, &pane, 1.25f, 0.0f);
		pane_build(build, &red, 2.0f, -0.5f);
		stage_show(&s, build);
		stilb_image picture = stage_picture(&s);
		assert_near("red", channel(&picture, 32, 32, 0), 0.25 + 0.75 * 0.5, 4e-3);
		assert_near("green", channel(&picture, 32, 32, 1), 0.25, 4e-3);
		stilb_image_finish(&picture);
		stage_close(&s);
	}
}

/* Light from behind thin walls, rough and less so. */
static void lights_behind(void **state)
{
	(void)state;
	static const stilb_scene_light below = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.36f, 0.9f, -0.24f}, .intensity = {3, 3, 3}};
	stage s = through_stage(1);
	stilb_scene_light light = below;
	float length = sqrtf(0.36f * 0.36f + 0.9f * 0.9f + 0.24f * 0.24f);
	for (int c = 0; c < 3; c++)
		light.direction[c] /= length;
	s.view.lights = &light;
	s.view.light_count = 1;
	for (int i = 0; i < 3; i++) {
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.roughness = 0.4f + 0.2f * (float)i;
		surface.transmission = 0.75f;
		reference_set3(surface.color, 1.0f, 0.5f, 0.25f);
		stilb_scene_build *build = stilb_scene_build_begin();
		pane_build(build, &surface, 1.25f, 0.0f);
		stage_show(&s, build);
		stilb_image picture = stage_picture(&s);
		for (uint32_t x = 0; x < SIDE; x += 7) {
			float px = on_pane(x), pz = on_pane(9);
			stilb_vec3 v = stilb_vec3_make(-px, 4.0f, -pz) / sqrtf(px * px + 16.0f + pz * pz);
			stilb_vec3 l = stilb_vec3_make(-light.direction[0], -light.direction[1], -light.direction[2]);
			stilb_vec3 f0 = stilb_vec3_make(0.04f, 0.04f, 0.04f), n = stilb_vec3_make(0.0f, 1.0f, 0.0f);
			double want = 3.0 * 0.75 * (double)shade_thin_cos(f0, surface.roughness, n, l, v);
			assert_true(want > 0.01);
			for (int c = 0; c < 3; c++)
				assert_near("light from behind", channel(&picture, x, 9, c), want / (1 << c), 2e-3 * want + 1e-4);
		}
		stilb_image_finish(&picture);
	}
	stage_close(&s);
}

/* Frames without transmission have neither the copy nor its passes; with some they have it once. */
static void who_has_none_pays_nothing(void **state)
{
	(void)state;
	stage s = through_stage(1);
	for (int through = 0; through < 2; through++) {
		stilb_scene_surface surface = glass();
		surface.transmission = (float)through;
		surface.clearcoat = 0.5f;
		stilb_image picture = seen_through(&s, &surface, 1.0f);
		stilb_image_finish(&picture);
		const stilb_gpu_plan *plan = s.render->device->plan;
		uint32_t behind = 0, scene = 0;
		for (uint32_t p = 0; p < stilb_gpu_plan_passes(plan); p++) {
			behind += strcmp(stilb_gpu_plan_row(plan, p)->name, "behind") == 0;
			scene += strcmp(stilb_gpu_plan_row(plan, p)->name, "main") == 0;
		}
		assert_int_equal(behind, through);
		assert_int_equal(scene, 1 + through);
		assert_int_equal(stilb_gpu_plan_find(plan, "color behind") != 0, through);
	}
	stage_close(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(thin_walls_tint),
		cmocka_unit_test(shares_go_through),
		cmocka_unit_test(solids_refract),
		cmocka_unit_test(rough_ones_blur),
		cmocka_unit_test(the_order_is_right),
		cmocka_unit_test(lights_behind),
		cmocka_unit_test(who_has_none_pays_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
