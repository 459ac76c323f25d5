/* Under 100,000 lamps: what --light-tolerance leaves out of lists is at most as much light as it says, at any pixel and
 * all lamps together, whatever the exposure and the shading. And lamps that fade with their size in the picture: the
 * same in each way of lighting, in small steps, down to nothing. Under the validation layer. */
#include "shading/shade_brdf.h"

#include "render/maps/maps_stage.h" /* names a type as these name variables */

#define WIDTH 64u
#define HEIGHT 36u
#define LAMPS 100000u
#define MODELS 6400u
#define HALF 0x1p-10 /* what two pictures of half floats may be apart by besides, a share of their light */

typedef struct city {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_render_view view;
	uint32_t ids[MODELS];
} city;

static city city_open(void)
{
	city c = {0};
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_VULKAN,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .samples = 1,
	                          .output = STILB_RENDER_OUTPUT_LINEAR,
	                          .context_count = 2,
	                          .validate = true};
	if (stilb_render_create(&desc, &c.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &c.pool), 0);
	assert_int_equal(stilb_scene_create_stress(MODELS, 7, &c.scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(c.scene, LAMPS), STILB_OK);
	assert_int_equal(stilb_render_set_scene(c.render, c.scene), STILB_OK);
	stilb_scene_camera camera = stilb_scene_stress_camera(c.scene, STILB_SCENE_VIEW_FEW, (float)WIDTH / (float)HEIGHT);
	c.view = (stilb_render_view){.view_projection = stilb_scene_camera_matrix(&camera, (float)WIDTH / (float)HEIGHT),
	                             .lights = c.scene->lights,
	                             .light_count = c.scene->light_count,
	                             .lighting = STILB_RENDER_LIGHTING_CLUSTERED,
	                             .surroundings = c.scene->surroundings,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS},
	                             .shading = stilb_render_shading_default()};
	memcpy(c.view.camera_position, camera.position, sizeof c.view.camera_position);
	for (uint32_t m = 0; m < MODELS; m++)
		c.ids[m] = m;
	return c;
}

static void city_close(city *c)
{
	assert_int_equal(stilb_render_wait(c->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(c->render), 0);
	stilb_render_destroy(c->render);
	stilb_scene_destroy(c->scene);
	stilb_job_pool_destroy(c->pool);
}

static stilb_image city_picture(city *c, float tolerance, stilb_render_stats *stats)
{
	stilb_image image = {0};
	c->view.light_tolerance = tolerance;
	c->view.light_peak = stilb_render_light_peak(c->scene, &c->view.shading);
	assert_int_equal(stilb_render_frame_begin(c->render), STILB_OK);
	assert_int_equal(stilb_render_record(c->render, 0, c->scene, c->ids, MODELS, c->pool, 0), STILB_OK);
	if (stilb_render_replay(c->render, &(stilb_render_pass){.name = "main"}, 1, &c->view, 1, c->pool, 0) != STILB_OK ||
	    stilb_render_read_image(c->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	*stats = stilb_render_stats_get(c->render);
	return image;
}

/* The least tolerance that would allow what the two pictures are apart by. */
static double tolerance_needed(const city *c, const stilb_image *all, const stilb_image *some)
{
	double worst = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int channel = 0; channel < 3; channel++) {
				double a = picture_value(all, x, y, channel), b = picture_value(some, x, y, channel);
				worst = fmax(worst, fabs(a - b) - HALF * a);
			}
	return worst * exp2((double)c->view.exposure);
}

/* least: the share of the tolerance that must be made use of, lest what is left out be left out of the test, too. */
static void check_tolerance(city *c, const char *what, float tolerance, double least)
{
	stilb_render_stats all_stats, stats;
	stilb_image all = city_picture(c, 0.0f, &all_stats), some = city_picture(c, tolerance, &stats);
	double needed = tolerance_needed(c, &all, &some);
	printf("%s: %.0f pairs, %.0f left out, %.4f of the tolerance needed\n", what, (double)all_stats.light_pairs,
	       (double)stats.light_left_out, needed / (double)tolerance);
	assert_int_equal(all_stats.light_left_out, 0);
	assert_true(stats.light_left_out > 0);
	if (!(needed <= (double)tolerance) || !(needed >= least * (double)tolerance))
		fail_msg("%s: %g of the tolerance", what, needed / (double)tolerance);
	stilb_image_finish(&all);
	stilb_image_finish(&some);
}

static void lamps_that_end(void **state)
{
	(void)state;
	city c = city_open();
	check_tolerance(&c, "1/255", 1.0f / 255.0f, 0.0);
	c.view.exposure = -5.0f;
	check_tolerance(&c, "4/255 at 5 stops less", 4.0f / 255.0f, 0.0);
	c.view.shading.brdf = SHADE_BRDF_LAMBERT;
	check_tolerance(&c, "1, matt, at 5 stops less", 1.0f, 0.001);
	city_close(&c);
}

/* Weak lamps without an end, which the tolerance ends. */
static void lamps_without_an_end(void **state)
{
	(void)state;
	city c = city_open();
	c.view.light_count = 401;
	for (uint32_t i = 1; i < c.view.light_count; i++) {
		c.scene->lights[i].falloff = STILB_SCENE_LIGHT_PHYSICAL;
		for (int channel = 0; channel < 3; channel++)
			c.scene->lights[i].intensity[channel] *= 0.02f;
	}
	check_tolerance(&c, "without an end", 16.0f / 255.0f, 0.005);
	c.view.shading.brdf = SHADE_BRDF_MICROFACET;
	check_tolerance(&c, "without an end, microfacets", 1.0f, 0.0);
	city_close(&c);
}

static double mean_light(const stilb_image *image)
{
	double sum = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			sum += picture_value(image, x, y, 1);
	return sum / (WIDTH * HEIGHT);
}

/* The reach of the scene's lamp number 1 as the picture shows it, pixels. */
static double lamp_pixels(const city *c)
{
	const stilb_scene_light *light = &c->scene->lights[1];
	stilb_scene_camera camera = stilb_scene_stress_camera(c->scene, STILB_SCENE_VIEW_FEW, (float)WIDTH / (float)HEIGHT);
	double squares = 0.0;
	for (int i = 0; i < 3; i++)
		squares += pow((double)light->position[i] - (double)camera.position[i], 2.0);
	return (double)light->reach / sqrt(squares) * 0.5 * HEIGHT / tan(0.5 * (double)camera.fov_y);
}

#define FADE_STEPS 20

static void lamps_that_fade(void **state)
{
	(void)state;
	city c = city_open();
	stilb_render_stats stats;
	c.view.lights = c.scene->lights + 1;
	c.view.light_count = 1;
	c.view.surroundings = (stilb_scene_surroundings){0};
	c.scene->lights[1].position[0] = c.scene->lights[1].position[2] = 0.0f;
	c.scene->lights[1].reach = 6.0f;
	double pixels = lamp_pixels(&c), before = 0.0, whole = 0.0;
	for (int step = 0; step <= FADE_STEPS + 1; step++) {
		/* Its reach is from twice so many pixels to as many. */
		double share = step == 0 ? 0.499 : 0.5 + 0.5 * step / FADE_STEPS;
		c.view.light_fade = (float)(share * pixels);
		stilb_image image = city_picture(&c, 0.0f, &stats);
		double t = fmin(fmax(1.0 / share - 1.0, 0.0), 1.0), now = mean_light(&image);
		whole = step == 0 ? now : whole;
		assert_true(whole > 1e-3);
		if (fabs(now - whole * t * t * (3.0 - 2.0 * t)) > 1e-3 * whole)
			fail_msg("at %.3f: %g of the light in place of %g", share, now / whole, t * t * (3.0 - 2.0 * t));
		if (step > 0 && before - now > 2.0 * whole / FADE_STEPS)
			fail_msg("at %.3f: a step of %g of the light", share, (before - now) / whole);
		before = now;
		assert_int_equal(stats.lights, 1);
		assert_int_equal(stats.light_faded, step > 0);
		assert_true(step == FADE_STEPS || stats.light_gone == (step > FADE_STEPS)); /* the bound may be rounded */
		stilb_image_finish(&image);
	}
	/* Many, of which some are gone, some fade and some do not: each way has the same bits. */
	c.view.light_count = 4000;
	c.view.light_fade = 0.9f * (float)lamp_pixels(&c) * c.scene->lights[2].reach / 6.0f;
	c.view.lighting = STILB_RENDER_LIGHTING_CLUSTERED;
	stilb_image lists = city_picture(&c, 0.0f, &stats);
	assert_int_equal(stats.lights, 4000);
	assert_true(stats.light_gone > 100 && stats.light_faded > stats.light_gone + 10 && stats.light_faded < 4000);
	c.view.lighting = STILB_RENDER_LIGHTING_FORWARD;
	stilb_image all = city_picture(&c, 0.0f, &stats);
	assert_memory_equal(lists.pixels, all.pixels, stilb_image_size(&all));
	assert_true(mean_light(&all) > 1e-4);
	stilb_image_finish(&all);
	stilb_image_finish(&lists);
	city_close(&c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(lamps_that_end), cmocka_unit_test(lamps_without_an_end),
	                                   cmocka_unit_test(lamps_that_fade)};
	return cmocka_run_group_tests_name("render_tolerance", tests, NULL, NULL);
}
