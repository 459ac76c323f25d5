/* Ambient occlusion beside the same by rays, on heaps of balls and boxes: how far it is off; flat floors are bright,
 * and nothing but ambient light is changed. */
#include "engine_internal.h"
#include "gi/gi_render.h"
#include "post_box.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 180, PIXELS = WIDTH * HEIGHT, MOST = 32 /* things */ };

#define RADIUS 1.0f

/* Who computes it in the tests that run now. */
static stilb_post_place computed_by = STILB_POST_PLACE_GPU;

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static float random_of(uint32_t seed, uint32_t use, float low, float high)
{
	return low + (high - low) * stilb_random_float(seed, use);
}

/* A scene of boxes (0) and balls (1), grey below white surroundings: of each kind, place, size and turn. All of it, and
 * the camera, is moved by `away`. */
typedef struct thing {
	uint32_t kind;
	stilb_scene_pose pose;
} thing;

static stilb_scene *scene_of(const thing *things, uint32_t count, stilb_scene_camera camera, float away)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_material paint = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {.material = stilb_scene_build_material(build, &paint)};
	stilb_scene_mesh meshes[2] = {post_box()};
	assert_int_equal(stilb_scene_mesh_sphere(4, &meshes[1]), STILB_OK);
	uint32_t kinds[2];
	for (uint32_t k = 0; k < 2; k++)
		kinds[k] = stilb_scene_build_mesh(build, &meshes[k]);
	for (uint32_t t = 0; t < count; t++) {
		stilb_scene_pose pose = things[t].pose;
		pose.translation[0] += away;
		part.mesh = kinds[things[t].kind];
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	camera.position[0] += away;
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (int c = 0; c < 3; c++)
		scene->surroundings.sky[c] = scene->surroundings.ground[c] = 1.0f;
	stilb_scene_mesh_finish(&meshes[1]);
	return scene;
}

static const thing ground = {0, {.scale = {20, 1, 20}, .translation = {0, -1, 0}, .rotation = {0, 0, 0, 1}}};

/* A floor, and on it so many boxes and balls. */
static stilb_scene *heap_of(uint32_t seed, uint32_t count, float away)
{
	static const stilb_scene_camera camera = {
		.position = {0, 3, 7}, .pitch = -0.4f, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};
	thing things[MOST] = {ground};
	assert_true(count < MOST);
	for (uint32_t m = 1; m <= count; m++) {
		float size = random_of(seed, 4 * m, 0.2f, 0.7f), turn = random_of(seed, 4 * m + 1, 0.0f, 3.0f);
		things[m] = (thing){
			m % 2,
			{.scale = {size, size, size},
		     .translation = {random_of(seed, 4 * m + 2, -3.0f, 3.0f), size, random_of(seed, 4 * m + 3, -3.0f, 3.0f)},
		     .rotation = {0, sinf(turn), 0, cosf(turn)}}};
	}
	return scene_of(things, count + 1, camera, away);
}

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

static float depths[PIXELS]; /* along the view's axis, metres, of the picture that was traced last */

/* The share of the hemisphere that is open at each pixel's first hits, and there whether all samples hit. */
static void traced(stilb_scene *scene, float *visible, bool *inside)
{
	stilb_job_pool_desc desc = {.worker_count = 1};
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(pool);
	assert_int_equal(stilb_gi_scene_create(scene, &gi_desc, &gi), STILB_OK);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_AO;
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = 4;
	settings.rays = 64;
	settings.ao_distance = RADIUS;
	settings.ao_weighted = true;
	assert_int_equal(stilb_gi_render_create(gi, &settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	stilb_gi_film film = stilb_gi_render_film(render);
	for (uint32_t i = 0; i < PIXELS; i++) {
		visible[i] = film.radiance[3 * (size_t)i];
		inside[i] = film.albedo[3 * (size_t)i] > 0.49f;
		depths[i] = film.depth[i];
	}
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
}

static stilb_engine *open_engine(stilb_scene *scene, stilb_post_settings post)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.workers = 0;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.post = post;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

/* The radiance of the next frame, red. */
static void draw(stilb_engine *engine, float *red)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.format, STILB_IMAGE_F16_LINEAR);
	for (uint32_t i = 0; i < PIXELS; i++)
		red[i] = stilb_image_half_to_float(((const uint16_t *)image.pixels)[image.channels * (size_t)i]);
	stilb_image_finish(&image);
}

static void close_engine(stilb_engine *engine)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
}

/* ---- sixteen samples in a sphere --------------------------------------------------------------------------------- */

/* The occlusion that this one is measured by (Mittring, "Finding Next Gen: CryEngine 2", 2007): of sixteen points in a
 * sphere of the radius around what the pixel shows, so many lie behind what the picture shows there; half of them do on
 * a plane. What is farther in front than the radius hides nothing. */
static float sphere_asked(const stilb_scene_camera *camera, uint32_t x, uint32_t y)
{
	float up = tanf(0.5f * camera->fov_y), across = up * WIDTH / HEIGHT, z = depths[y * WIDTH + x], open = 0.0f;
	float place[3] = {(2.0f * ((float)x + 0.5f) / WIDTH - 1.0f) * across * z,
	                  (1.0f - 2.0f * ((float)y + 0.5f) / HEIGHT) * up * z, z};
	for (uint32_t i = 0, use = 0; i < 16; i++) {
		float point[3], square;
		do {
			square = 0.0f;
			for (int c = 0; c < 3; c++) {
				point[c] = random_of(y * WIDTH + x, use++, -1.0f, 1.0f);
				square += point[c] * point[c];
			}
		} while (square > 1.0f);
		for (int c = 0; c < 3; c++)
			point[c] = place[c] + RADIUS * point[c];
		float column = (point[0] / (point[2] * across) + 1.0f) * 0.5f * WIDTH;
		float row = (1.0f - point[1] / (point[2] * up)) * 0.5f * HEIGHT;
		bool shown = point[2] > camera->near_z && column >= 0.0f && row >= 0.0f && column < WIDTH && row < HEIGHT;
		float seen = shown ? depths[(uint32_t)row * WIDTH + (uint32_t)column] : INFINITY;
		open += seen >= point[2] - 1e-3f || seen < z - RADIUS ? 1.0f : 0.0f;
	}
	return open / 8.0f;
}

/* Its mean over the sixteen pixels around, as far as they lie about as far away. */
static float sphere_of(const float *asked, uint32_t x, uint32_t y)
{
	float sum = 0.0f, count = 0.0f, z = depths[y * WIDTH + x];
	for (int j = -2; j < 2; j++)
		for (int i = -2; i < 2; i++) {
			int64_t column = (int64_t)x + i, row = (int64_t)y + j;
			if (column < 0 || row < 0 || column >= WIDTH || row >= HEIGHT)
				continue;
			uint32_t at = (uint32_t)(row * WIDTH + column);
			if (fabsf(depths[at] - z) > 0.02f * z)
				continue;
			sum += asked[at];
			count += 1.0f;
		}
	return fminf(sum / count, 1.0f);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static float visible[PIXELS], before[PIXELS], after[PIXELS];
static bool inside[PIXELS];

/* The root of the mean square by which frames are off where rays find something hidden; by which they are without
 * occlusion; and by which sixteen samples in a sphere are. */
static void errors_of(stilb_scene *scene, double errors[3])
{
	static float asked[PIXELS];
	stilb_engine *engine = open_engine(scene, (stilb_post_settings){0});
	draw(engine, before);
	stilb_post_settings post = {.occlusion = 1.0f, .occlusion_radius = RADIUS, .place = computed_by};
	stilb_engine_set_post(engine, &post);
	draw(engine, after);
	close_engine(engine);
	traced(scene, visible, inside);
	double sums[3] = {0.0, 0.0, 0.0};
	uint32_t count = 0;
	for (uint32_t i = 0; i < PIXELS; i++)
		asked[i] = inside[i] ? sphere_asked(&scene->camera, i % WIDTH, i / WIDTH) : 1.0f;
	for (uint32_t i = 0; i < PIXELS; i++) {
		if (!inside[i] || visible[i] > 0.95f)
			continue;
		double off = (double)(after[i] / before[i] - visible[i]), none = 1.0 - (double)visible[i];
		double sphere = (double)(sphere_of(asked, i % WIDTH, i / WIDTH) - visible[i]);
		sums[0] += off * off;
		sums[1] += none * none;
		sums[2] += sphere * sphere;
		count++;
	}
	assert_true(count > PIXELS / 100);
	for (int e = 0; e < 3; e++)
		errors[e] = sqrt(sums[e] / count);
}

static void pictures_are_near_those_of_rays(void **state)
{
	(void)state;
	for (uint32_t seed = 1; seed <= 4; seed++) {
		stilb_scene *scene = heap_of(seed, 6 * seed, 0.0f);
		double errors[3];
		errors_of(scene, errors);
		printf("heap %u: off by %.3f, without by %.3f, 16 samples in a sphere by %.3f\n", seed, errors[0], errors[1],
		       errors[2]);
		assert_true(errors[0] < 0.4 * errors[1] && errors[0] < 0.5 * errors[2]);
		stilb_scene_destroy(scene);
	}
}

/* A floor alone hides nothing of itself, at no slant. */
static void floors_are_bright(void **state)
{
	(void)state;
	stilb_scene *scene = heap_of(1, 0, 0.0f);
	static const float pitches[3] = {-0.15f, -0.5f, -1.4f};
	for (uint32_t p = 0; p < 3; p++) {
		scene->camera.pitch = pitches[p];
		stilb_engine *engine = open_engine(scene, (stilb_post_settings){0});
		draw(engine, before);
		stilb_post_settings post = {.occlusion = 1.0f, .occlusion_radius = RADIUS, .place = computed_by};
		stilb_engine_set_post(engine, &post);
		draw(engine, after);
		close_engine(engine);
		for (uint32_t y = HEIGHT / 2; y < HEIGHT; y++)
			for (uint32_t i = y * WIDTH; i < (y + 1) * WIDTH; i++)
				if (fabsf(after[i] / before[i] - 1.0f) > 0.03f)
					fail_msg("pitch %g, row %u: %.3f", (double)pitches[p], y, (double)(after[i] / before[i]));
	}
	stilb_scene_destroy(scene);
}

/* Occlusion of half the strength is half as dark; without ambient light, and with strength 0, frames are the same bits;
 * frames of the same scene are always the same. */
static void ambient_light_alone_is_darker(void **state)
{
	(void)state;
	static float third[PIXELS];
	stilb_scene *scene = heap_of(3, 12, 0.0f);
	stilb_post_settings post = {.occlusion = 1.0f, .occlusion_radius = RADIUS, .place = computed_by};
	stilb_engine *engine = open_engine(scene, (stilb_post_settings){0});
	draw(engine, before);
	stilb_engine_set_post(engine, &post);
	draw(engine, after);
	draw(engine, third);
	assert_memory_equal(after, third, sizeof after);
	post.occlusion = 0.5f;
	stilb_engine_set_post(engine, &post);
	draw(engine, third);
	for (uint32_t i = 0; i < PIXELS; i++)
		assert_true(fabsf(third[i] - 0.5f * (before[i] + after[i])) < 2e-3f);
	post.occlusion = 0.0f;
	stilb_engine_set_post(engine, &post);
	draw(engine, third);
	assert_memory_equal(before, third, sizeof before);
	stilb_engine_set_ambient(engine, STILB_RENDER_AMBIENT_NONE);
	draw(engine, before);
	post.occlusion = 1.0f;
	stilb_engine_set_post(engine, &post);
	draw(engine, after);
	assert_memory_equal(before, after, sizeof before);
	close_engine(engine);
	stilb_scene_destroy(scene);
}

/* The share of ambient light that is left at each pixel. */
static void left_of(stilb_scene *scene, float *left)
{
	stilb_engine *engine = open_engine(scene, (stilb_post_settings){0});
	draw(engine, before);
	stilb_post_settings post = {.occlusion = 1.0f, .occlusion_radius = RADIUS, .place = computed_by};
	stilb_engine_set_post(engine, &post);
	draw(engine, left);
	close_engine(engine);
	for (uint32_t i = 0; i < PIXELS; i++)
		left[i] /= before[i];
}

/* A ball far in front of a dark corner is bright up to its outline, and the corner dark. */
static void outlines_are_sharp(void **state)
{
	(void)state;
	static const stilb_scene_camera camera = {
		.position = {0, 6, 9}, .pitch = -0.4636476f, .fov_y = 0.3f, .near_z = 0.1f, .far_z = 100.0f};
	const thing things[3] = {
		ground,
		{0, {.scale = {20, 20, 1}, .translation = {0, 0, -4}, .rotation = {0, 0, 0, 1}}},
		{1, {.scale = {0.2f, 0.2f, 0.2f}, .translation = {0, 4, 5}, .rotation = {0, 0, 0, 1}}},
	};
	stilb_scene *scene = scene_of(things, 3, camera, 0.0f);
	left_of(scene, after);
	traced(scene, visible, inside);
	stilb_scene_destroy(scene);
	uint32_t bright = 0, dark = 0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			float across = (float)x + 0.5f - WIDTH / 2, up = (float)y + 0.5f - HEIGHT / 2;
			float pixel = 2.0f * tanf(0.15f) / HEIGHT, ball = 0.2f / sqrtf(20.0f - 0.04f);
			float outline = hypotf(across, up) * pixel / ball; /* in radii; the corner is level with its middle */
			uint32_t i = y * WIDTH + x;
			if (outline < 0.97f && visible[i] > 0.9f) {
				bright++;
				if (after[i] < 0.965f)
					fail_msg("pixel %u, %u of the ball: %.3f", x, y, (double)after[i]);
			}
			dark += outline > 1.05f && outline < 1.5f && visible[i] < 0.7f && after[i] < 0.8f;
		}
	if (bright < 500 || dark < 50)
		fail_msg("%u pixels of the ball, %u of the corner", bright, dark);
}

/* Far from the world's origin, frames are nearly the same. */
static void distance_from_the_origin_does_not_matter(void **state)
{
	(void)state;
	stilb_scene *scene = heap_of(2, 12, 0.0f), *far = heap_of(2, 12, 2000.0f);
	left_of(scene, after);
	left_of(far, visible);
	double squares = 0.0;
	for (uint32_t i = 0; i < PIXELS; i++)
		squares += (double)((after[i] - visible[i]) * (after[i] - visible[i]));
	if (sqrt(squares / PIXELS) > 0.002)
		fail_msg("off by %.4f", sqrt(squares / PIXELS));
	stilb_scene_destroy(scene);
	stilb_scene_destroy(far);
}

/* By the device's programs and by the CPU's threads pictures are the same within 1/255, but for few pixels, where
 * rounding decides which way a normal is asked or which surface a texel is of. */
static void both_places_agree(void **state)
{
	(void)state;
	for (uint32_t seed = 5; seed < 8; seed++) {
		stilb_scene *scene = heap_of(seed, 4 * seed, 0.0f);
		stilb_post_settings post = {
			.occlusion = 0.9f, .occlusion_radius = 0.4f * (float)(seed - 4), .place = STILB_POST_PLACE_GPU};
		stilb_engine *engine = open_engine(scene, post);
		draw(engine, before);
		post.place = STILB_POST_PLACE_CPU;
		stilb_engine_set_post(engine, &post);
		draw(engine, after);
		close_engine(engine);
		stilb_scene_destroy(scene);
		uint32_t off = 0;
		float most = 0.0f;
		for (uint32_t i = 0; i < PIXELS; i++) {
			most = fmaxf(most, fabsf(before[i] - after[i]));
			off += fabsf(before[i] - after[i]) > 1.0f / 255.0f;
		}
		printf("heap %u: %u of %u pixels are off by more than 1/255, at most by %.4f\n", seed, off, PIXELS,
		       (double)most);
		assert_true(off < PIXELS / 200 && most < 6.0f / 255.0f);
	}
}

static void take_line(void *user, const char *line)
{
	snprintf(user, 200, "%s", line);
}

/* With several samples a pixel there is no occlusion, and somebody says so. */
static void several_samples_are_refused(void **state)
{
	(void)state;
	char said[200] = "";
	stilb_post_settings post = {.occlusion = 1.0f};
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	desc.samples = 4;
	desc.post = post;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(),
	                    "ambient occlusion (post.occlusion) has one sample a pixel, and 4 are asked for");
	desc.post.occlusion = 0.0f;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	stilb_log_set(take_line, said);
	stilb_engine_set_post(engine, &post);
	stilb_log_set(NULL, NULL);
	assert_string_equal(
		said, "ambient occlusion (post.occlusion) has one sample a pixel, and frames have 4: they are without it");
	stilb_engine_destroy(engine);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_near_those_of_rays),
		cmocka_unit_test(floors_are_bright),
		cmocka_unit_test(ambient_light_alone_is_darker),
		cmocka_unit_test(outlines_are_sharp),
		cmocka_unit_test(distance_from_the_origin_does_not_matter),
		cmocka_unit_test(both_places_agree),
		cmocka_unit_test(several_samples_are_refused),
	};
	struct CMUnitTest by_cpu[] = {
		cmocka_unit_test(floors_are_bright),
		cmocka_unit_test(ambient_light_alone_is_darker),
		cmocka_unit_test(outlines_are_sharp),
	};
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	computed_by = STILB_POST_PLACE_CPU;
	return failed + cmocka_run_group_tests_name("by the CPU", by_cpu, NULL, NULL);
}
