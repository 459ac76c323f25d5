/* Depth of field beside the same by rays through a lens: how far it is off, and how far a Gaussian blur by each pixel's
 * circle of confusion is. */
#include "post_stage.h"
#include "post_world.h"

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static const stilb_scene_camera camera = {
	.position = {0, 1.2f, 4}, .pitch = -0.12f, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};
static const stilb_scene_surroundings around = {.sky = {0.35f, 0.4f, 0.5f}, .ground = {0.2f, 0.2f, 0.2f}};

static stilb_scene_material any_paint(uint32_t seed, uint32_t use)
{
	return world_paint(world_random(seed, use, 0.1f, 0.9f), world_random(seed, use + 1, 0.1f, 0.9f),
	                   world_random(seed, use + 2, 0.1f, 0.9f), 0.0f);
}

/* Tiles of two colours on the ground, things at all distances, small bright lamps behind and before the plane in
 * focus. */
static stilb_scene *yard_of(uint32_t seed)
{
	static world_thing things[MOST];
	uint32_t count = 0;
	things[count++] = world_put(WORLD_BOX, 0, -1, 0, 30, 1, 30, world_paint(0.4f, 0.4f, 0.4f, 0));
	for (uint32_t i = 0; i < 24; i++) {
		float x = world_random(seed, 8 * i, -4.0f, 4.0f), z = world_random(seed, 8 * i + 1, -10.0f, 2.0f);
		float size = world_random(seed, 8 * i + 2, 0.15f, 0.45f);
		things[count++] = world_put(i % 2, x, size, z, size, size, size, any_paint(seed, 8 * i + 3));
	}
	for (uint32_t i = 0; i < 30; i++) {
		float x = world_random(seed, 300 + 3 * i, -5.0f, 5.0f), y = world_random(seed, 301 + 3 * i, 0.3f, 3.0f);
		float z = world_random(seed, 302 + 3 * i, -12.0f, 1.0f);
		things[count++] = world_put(WORLD_BALL, x, y, z, 0.1f, 0.1f, 0.1f, world_paint(0.9f, 0.7f, 0.4f, 2));
	}
	for (uint32_t i = 0; i < 4; i++) /* posts near the camera */
		things[count++] =
			world_put(WORLD_BOX, -1.2f + 0.8f * (float)i, 1, 2.4f, 0.04f, 1.2f, 0.04f, any_paint(seed, 600 + 3 * i));
	return world_make(things, count, &camera, &around);
}

/* ---- the comparison ---------------------------------------------------------------------------------------------- */

/* The signed radius of the circle of confusion of each pixel, pixels, from where rays of the CPU hit. */
static void circles_of(stilb_engine *engine, const stilb_post_settings *post, float *circles)
{
	float scale = post->aperture * 0.5f * HEIGHT / tanf(0.5f * camera.fov_y);
	for (uint32_t i = 0; i < PIXELS; i++) {
		stilb_engine_hit hit;
		float x = (float)(i % WIDTH) + 0.5f, y = (float)(i / WIDTH) + 0.5f, inverse = 0.0f;
		if (stilb_engine_pick(engine, (double)x, (double)y, &hit)) {
			float dy = hit.position[1] - camera.position[1], dz = hit.position[2] - camera.position[2];
			inverse = 1.0f / (dy * sinf(camera.pitch) - dz * cosf(camera.pitch));
		}
		circles[i] = scale * (1.0f / post->focus - inverse);
	}
}

/* What is measured against: each pixel the mean around it with the weights of a Gaussian, whose variance along each
 * axis is that of its circle of confusion. */
static void gaussian(const world_picture sharp, const float *circles, world_picture blurred)
{
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++) {
			float sigma = 0.5f * fabsf(circles[y * WIDTH + x]), sum[4] = {0};
			int around_it = (int)ceilf(3.0f * sigma);
			for (int dy = -around_it; dy <= around_it; dy++)
				for (int dx = -around_it; dx <= around_it; dx++) {
					int sx = x + dx < 0 ? 0 : x + dx >= WIDTH ? WIDTH - 1 : x + dx;
					int sy = y + dy < 0 ? 0 : y + dy >= HEIGHT ? HEIGHT - 1 : y + dy;
					float weight = sigma > 0.0f ? expf(-0.5f * (float)(dx * dx + dy * dy) / (sigma * sigma)) : 1.0f;
					for (int c = 0; c < 3; c++)
						sum[c] += weight * sharp[sy * WIDTH + sx][c];
					sum[3] += weight;
				}
			for (int c = 0; c < 3; c++)
				blurred[y * WIDTH + x][c] = sum[c] / sum[3];
		}
}

static world_picture sharp, ours, lerped, naive, truth;
static float circles[PIXELS];

static void compare(stilb_scene *scene, const char *name, stilb_post_settings post, double most)
{
	char path[64];
	post.dof = STILB_POST_DOF_BOKEH;
	stilb_engine *engine = world_open(scene, (stilb_post_settings){0});
	world_draw(engine, sharp);
	stilb_engine_set_post(engine, &post);
	world_draw(engine, ours);
	circles_of(engine, &post, circles);
	post.dof = STILB_POST_DOF_LERP;
	stilb_engine_set_post(engine, &post);
	world_draw(engine, lerped);
	world_close(engine);
	gaussian((const float(*)[3])sharp, circles, naive);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.samples = 64;
	settings.lens = (stilb_gi_lens){.radius = post.aperture, .focus = post.focus, .blades = post.blades};
	world_trace(scene, settings, truth);
	double off = world_rms((const float(*)[3])ours, (const float(*)[3])truth);
	double by_lerp = world_rms((const float(*)[3])lerped, (const float(*)[3])truth);
	double by_gauss = world_rms((const float(*)[3])naive, (const float(*)[3])truth);
	double without = world_rms((const float(*)[3])sharp, (const float(*)[3])truth);
	const struct {
		const char *what;
		float (*picture)[3];
	} kept[] = {{"off", sharp}, {"on", ours}, {"lerp", lerped}, {"gauss", naive}, {"truth", truth}};
	for (size_t k = 0; k < sizeof kept / sizeof *kept; k++) {
		snprintf(path, sizeof path, "lens_%s_%s", name, kept[k].what);
		world_keep((const float(*)[3])kept[k].picture, path);
	}
	print_message("%s: off by %.4f, a Gaussian by %.4f, two blurs by %.4f, without by %.4f\n", name, off, by_gauss,
	              by_lerp, without);
	if (off > 0.5 * by_gauss || off > most)
		fail_msg("%s: off by %.4f, a Gaussian by %.4f, two blurs by %.4f, without by %.4f", name, off, by_gauss,
		         by_lerp, without);
}

/* Made after the program was done: rows of columns in a hall, a wall of tiles, balls near the camera. */
static stilb_scene *hall(void)
{
	static world_thing things[MOST];
	uint32_t count = 0;
	things[count++] = world_put(WORLD_BOX, 0, -1, 0, 30, 1, 30, world_paint(0.55f, 0.5f, 0.4f, 0));
	for (uint32_t i = 0; i < 40; i++)
		things[count++] = world_put(WORLD_BOX, -6.3f + 1.4f * (float)(i % 10), 0.5f + 1.1f * (float)(i / 10), -9, 0.66f,
		                            0.5f, 0.1f, any_paint(7, 3 * i));
	for (uint32_t i = 0; i < 10; i++)
		things[count++] = world_put(i % 3 ? WORLD_BOX : WORLD_BALL, i % 2 ? 1.6f : -1.6f, 0.9f,
		                            1.5f - 1.1f * (float)(i / 2), 0.25f, 0.9f, 0.25f, any_paint(8, 3 * i));
	for (uint32_t i = 0; i < 9; i++)
		things[count++] =
			world_put(WORLD_BALL, -0.8f + 0.2f * (float)i, 0.95f, 3.1f, 0.035f, 0.035f, 0.035f, any_paint(9, 3 * i));
	for (uint32_t i = 0; i < 6; i++)
		things[count++] =
			world_put(WORLD_BALL, -2.5f + (float)i, 2.6f, -4.0f, 0.1f, 0.1f, 0.1f, world_paint(0.9f, 0.8f, 0.6f, 3));
	return world_make(things, count, &camera, &around);
}

static void pictures_are_near_those_of_rays(void **state)
{
	(void)state;
	static const stilb_post_settings round = {.aperture = 0.1f, .focus = 4.0f};
	static const stilb_post_settings other = {.aperture = 0.07f, .focus = 2.5f, .blades = 5};
	stilb_scene *scene = yard_of(1);
	compare(scene, "yard", round, 0.014);
	stilb_scene_destroy(scene);
	scene = hall();
	compare(scene, "hall", other, 0.006);
	stilb_scene_destroy(scene);
	scene = yard_of(3);
	compare(scene, "yard3", other, 0.01);
	stilb_scene_destroy(scene);
}

/* A lamp before the plane in focus has the mirror image of a triangular aperture. */
static void near_lamps_are_mirrored(void **state)
{
	(void)state;
	static const stilb_post_settings triangle = {.aperture = 0.1f, .focus = 4.0f, .blades = 3};
	static const stilb_scene_surroundings dark = {0};
	world_thing lamp = world_put(WORLD_BALL, 0, 1, 2.4f, 0.02f, 0.02f, 0.02f, world_paint(0.9f, 0.9f, 0.9f, 10));
	stilb_scene *scene = world_make(&lamp, 1, &camera, &dark);
	compare(scene, "lamp", triangle, 0.02);
	stilb_scene_destroy(scene);
}

/* ---- light that is all infinitely far away ----------------------------------------------------------------------- */

#define SIDE 128u
#define CIRCLE 10.0f /* pixels */

/* Sees a camera through a lens whose circles of confusion are CIRCLE at infinity. */
static void look(post_stage *s, uint32_t blades)
{
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, 1.0f)};
	memcpy(view.camera_position, camera.position, sizeof view.camera_position);
	stilb_post_see(s->post, &view);
	float aperture = CIRCLE * 2.0f * tanf(0.5f * camera.fov_y) / (float)s->height;
	stilb_post_set(s->post, &(stilb_post_settings){
								.dof = STILB_POST_DOF_BOKEH, .aperture = aperture, .focus = 1.0f, .blades = blades});
}

/* Even light stays as it is, also beside pixels that are not finite; nothing of these spreads. */
static void even_light_stays(void **state)
{
	(void)state;
	static float light[SIDE * SIDE * 3];
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, SIDE, SIDE);
	for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
		light[i] = 0.75f;
	light[3 * (40 * SIDE + 30)] = NAN;
	light[3 * (90 * SIDE + 31) + 1] = INFINITY;
	stage_light(&s, light);
	for (uint32_t blades = 0; blades <= 6; blades += 3) {
		look(&s, blades);
		float *shown = stage_shown(&s);
		for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
			if (!(fabsf(shown[i] - 0.75f) < 3e-3f) && (i / 3 != 40 * SIDE + 30 && i / 3 != 90 * SIDE + 31))
				fail_msg("%u blades, pixel %u, %u: %g", blades, i / 3 % SIDE, i / 3 / SIDE, (double)shown[i]);
		free(shown);
	}
	stage_close(&s);
}

/* Blurs of few pixels by any shape leave even light as it is, also that of two blurs. */
static void small_blurs_leave_light(void **state)
{
	(void)state;
	static float light[SIDE * SIDE * 3];
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, SIDE, SIDE);
	for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
		light[i] = 0.75f;
	stage_light(&s, light);
	for (uint32_t blades = 0; blades <= 6; blades += blades == 0 ? 3 : 1)
		for (int circle = 1; circle <= 7; circle += 2)
			for (int dof = STILB_POST_DOF_OFF + 1; dof < STILB_POST_DOF_COUNT; dof++) {
				look(&s, blades);
				float aperture = (float)circle * 2.0f * tanf(0.5f * camera.fov_y) / (float)s.height;
				stilb_post_set(s.post,
				               &(stilb_post_settings){
								   .dof = (stilb_post_dof)dof, .aperture = aperture, .focus = 1.0f, .blades = blades});
				float *shown = stage_shown(&s);
				for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
					if (!(fabsf(shown[i] - 0.75f) < 3e-3f))
						fail_msg("%s, %u blades, circle %d: %g", stilb_post_dof_names[dof], blades, circle,
						         (double)shown[i]);
				free(shown);
			}
	stage_close(&s);
}

/* True if a point of the picture, from the source on, lies in the aperture's shape of this radius. */
static bool lies_in(uint32_t blades, float radius, float x, float y)
{
	if (blades == 0)
		return hypotf(x, y) < radius;
	for (uint32_t k = 0; k < blades; k++) {
		float a = 2.0f * 3.14159265f * (float)k / (float)blades,
			  b = 2.0f * 3.14159265f * (float)(k + 1) / (float)blades;
		float ax = radius * cosf(a), ay = -radius * sinf(a), bx = radius * cosf(b), by = -radius * sinf(b);
		if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0f)
			return false;
	}
	return true;
}

/* The light of a few pixels spreads over the aperture's shape, evenly, and none is lost. */
static void points_have_the_apertures_shape(void **state)
{
	(void)state;
	static float light[SIDE * SIDE * 3];
	static const uint32_t blades[] = {0, 3, 5, 6};
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, SIDE, SIDE);
	for (uint32_t p = 0; p < 4; p++)
		light[3 * ((63 + p / 2) * SIDE + 63 + p % 2)] = 100.0f;
	stage_light(&s, light);
	for (uint32_t b = 0; b < 4; b++) {
		look(&s, blades[b]);
		float *shown = stage_shown(&s);
		double sum = 0.0, outside = 0.0, area = 0.0;
		uint32_t inside = 0;
		for (uint32_t i = 0; i < SIDE * SIDE; i++)
			area += lies_in(blades[b], CIRCLE, (float)(i % SIDE) - 63.5f, (float)(i / SIDE) - 63.5f);
		for (uint32_t i = 0; i < SIDE * SIDE; i++) {
			float x = (float)(i % SIDE) - 63.5f, y = (float)(i / SIDE) - 63.5f;
			sum += (double)shown[3 * i];
			outside += lies_in(blades[b], CIRCLE + 4.0f, x, y) ? 0.0 : (double)shown[3 * i];
			if (!lies_in(blades[b], CIRCLE - 5.0f, x, y))
				continue;
			inside++;
			double even = (double)shown[3 * i] / (400.0 / area);
			if (even < 0.9 || even > 1.12)
				fail_msg("%u blades, at %g, %g: %.3f of even light", blades[b], (double)x, (double)y, even);
		}
		if (sum < 392.0 || sum > 408.0 || outside > 4.0 || inside < 20)
			fail_msg("%u blades: %.1f of 400, %.1f of it outside", blades[b], sum, outside);
		free(shown);
	}
	stage_close(&s);
}

/* Without an aperture, and without a camera, frames have no such row and are the same bits; pictures of any size. */
static void odd_sizes_and_no_lens(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{1, 1}, {3, 9}, {16384, 9}, {37, 61}};
	for (uint32_t i = 0; i < 4; i++) {
		uint32_t width = sizes[i][0], height = sizes[i][1];
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, width, height);
		float *light = calloc((size_t)width * height, 3 * sizeof *light);
		assert_non_null(light);
		for (uint32_t p = 0; p < 3 * width * height; p++)
			light[p] = 0.25f + 0.5f * (float)(p % 2);
		stage_light(&s, light);
		stilb_post_set(s.post, &(stilb_post_settings){.dof = STILB_POST_DOF_BOKEH, .aperture = 1.0f, .focus = 1.0f});
		float *plain = stage_shown(&s);
		assert_memory_equal(plain, light, (size_t)width * height * 3 * sizeof *light);
		look(&s, 0);
		float *shown = stage_shown(&s), *again = stage_shown(&s);
		assert_memory_equal(shown, again, (size_t)width * height * 3 * sizeof *light);
		for (uint32_t p = 0; p < 3 * width * height; p++)
			assert_true(shown[p] >= 0.248f && shown[p] <= 0.752f);
		stilb_post_set(s.post, &(stilb_post_settings){.dof = STILB_POST_DOF_BOKEH});
		free(again);
		again = stage_shown(&s);
		assert_memory_equal(again, light, (size_t)width * height * 3 * sizeof *light);
		free(plain);
		free(shown);
		free(again);
		free(light);
		stage_close(&s);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_near_those_of_rays),
		cmocka_unit_test(near_lamps_are_mirrored),
		cmocka_unit_test(even_light_stays),
		cmocka_unit_test(small_blurs_leave_light),
		cmocka_unit_test(points_have_the_apertures_shape),
		cmocka_unit_test(odd_sizes_and_no_lens),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
