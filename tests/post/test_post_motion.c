/* Motion blur beside the mean of 64 frames of the time while the shutter is open, and beside a blur by 8 taps that
 * knows the camera's movement alone. */
#include "post_scenes.h"

#define TRUTH 64u /* frames */

static const stilb_scene_camera front = {.position = {0, 0, 12}, .fov_y = 0.55f, .near_z = 0.1f, .far_z = 200.0f};

/* Where all is at a time, in frames. */
typedef void blur_move(stilb_scene *scene, const scene_thing *things, uint32_t count, float time);

typedef struct blur_case {
	const char *name;
	uint32_t seed;
	float shutter;
	blur_move *things, *camera;
	double most; /* of the error of the taps */
} blur_case;

static scene_thing things[16];

static void fill(uint32_t seed)
{
	things[0] = (scene_thing){
		0, {0.3f, 0.35f, 0.4f}, {.scale = {20, 20, 0.5f}, .translation = {0, 0, -5}, .rotation = {0, 0, 0, 1}}};
	for (uint32_t t = 1; t < 16; t++) {
		float size = 0.25f + 0.6f * stilb_random_float(seed, 8 * t), turn = 3.0f * stilb_random_float(seed, 8 * t + 1);
		things[t] = (scene_thing){t % 2,
		                          {stilb_random_float(seed, 8 * t + 2), stilb_random_float(seed, 8 * t + 3),
		                           stilb_random_float(seed, 8 * t + 4)},
		                          {.scale = {size, size, size},
		                           .translation = {8.0f * stilb_random_float(seed, 8 * t + 5) - 4.0f,
		                                           5.0f * stilb_random_float(seed, 8 * t + 7) - 2.5f,
		                                           6.0f * stilb_random_float(seed, 8 * t + 6) - 4.0f},
		                           .rotation = {0, sinf(turn), 0, cosf(turn)}}};
	}
}

/* Every third thing moves, each its own way. */
static void things_move(stilb_scene *scene, const scene_thing *from, uint32_t count, float time)
{
	for (uint32_t t = 1; t < count; t += 3) {
		stilb_scene_pose pose = from[t].pose;
		pose.translation[0] += (t % 2 ? 0.9f : -0.6f) * time;
		pose.translation[1] += (t % 4 ? 0.3f : -0.4f) * time;
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		assert_int_equal(stilb_scene_set_transform(scene, t, &place), STILB_OK);
	}
}

static void camera_passes(stilb_scene *scene, const scene_thing *from, uint32_t count, float time)
{
	(void)from;
	(void)count;
	scene->camera.position[0] = 0.6f * time;
	scene->camera.position[2] = front.position[2] - 0.3f * time;
}

static void camera_turns(stilb_scene *scene, const scene_thing *from, uint32_t count, float time)
{
	(void)from;
	(void)count;
	scene->camera.yaw = 0.06f * time;
	scene->camera.pitch = 0.01f * time;
}

static void nothing_moves(stilb_scene *scene, const scene_thing *from, uint32_t count, float time)
{
	(void)scene;
	(void)from;
	(void)count;
	(void)time;
}

static const blur_case cases[] = {
	{"things", 1, 0.5f, things_move, nothing_moves, 0.5},    {"things", 2, 1.0f, things_move, nothing_moves, 0.5},
	{"passing", 3, 0.5f, nothing_moves, camera_passes, 0.9}, {"turning", 4, 0.5f, nothing_moves, camera_turns, 0.9},
	{"both", 5, 0.5f, things_move, camera_passes, 0.8},      {"both", 6, 1.0f, things_move, camera_turns, 0.9},
};

static float sharp[3 * SCENE_PIXELS], blurred[3 * SCENE_PIXELS], truth[3 * SCENE_PIXELS], taps[3 * SCENE_PIXELS];
static uint16_t halves[2 * SCENE_PIXELS];

static void read_velocity(stilb_engine *engine)
{
	stilb_gpu *gpu = stilb_engine_gpu(engine);
	const stilb_gpu_plan *plan = stilb_engine_plan(engine);
	uint64_t ticket, frame;
	const void *bytes;
	assert_int_equal(
		stilb_gpu_read_begin(gpu, plan, stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_VELOCITY), 0, 0, &ticket),
		STILB_OK);
	assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
	memcpy(halves, bytes, sizeof halves);
	stilb_gpu_read_end(gpu, ticket);
}

/* The mean of 8 samples along each pixel's way by the camera, nearest texels: of what cannot know how things move. */
static void blur_by_taps(const blur_case *c)
{
	static const stilb_post_settings tiny = {.motion_blur = 1e-6f};
	stilb_scene *scene = scene_of(things, 16, &front);
	stilb_engine *engine = scene_engine(scene, 1, &tiny);
	c->things(scene, things, 16, 0.0f);
	for (int f = -1; f <= 0; f++) {
		c->camera(scene, things, 16, (float)f);
		scene_frame(engine, taps, NULL);
	}
	read_velocity(engine);
	scene_close(engine);
	stilb_scene_destroy(scene);
	memset(taps, 0, sizeof taps);
	for (int y = 0; y < SCENE_HEIGHT; y++)
		for (int x = 0; x < SCENE_WIDTH; x++)
			for (int t = 0; t < 8; t++) {
				int p = y * SCENE_WIDTH + x;
				float along = (((float)t + 0.5f) / 8.0f - 0.5f) * c->shutter;
				float at_x = (float)x + 0.5f + along * stilb_image_half_to_float(halves[2 * p]);
				float at_y = (float)y + 0.5f + along * stilb_image_half_to_float(halves[2 * p + 1]);
				int from_x = (int)fminf(fmaxf(floorf(at_x), 0.0f), SCENE_WIDTH - 1.0f);
				int from_y = (int)fminf(fmaxf(floorf(at_y), 0.0f), SCENE_HEIGHT - 1.0f);
				for (int i = 0; i < 3; i++)
					taps[3 * p + i] += sharp[3 * (from_y * SCENE_WIDTH + from_x) + i] / 8.0f;
			}
}

static void draw_case(const blur_case *c)
{
	static float frame[3 * SCENE_PIXELS];
	stilb_post_settings off = {0}, on = {.motion_blur = c->shutter, .motion_blur_most = 0.5f};
	fill(c->seed);
	stilb_scene *scene = scene_of(things, 16, &front);
	stilb_engine *engine = scene_engine(scene, 1, &off);
	memset(truth, 0, sizeof truth);
	for (uint32_t f = 0; f < TRUTH; f++) {
		float time = (((float)f + 0.5f) / TRUTH - 0.5f) * c->shutter;
		c->things(scene, things, 16, time);
		c->camera(scene, things, 16, time);
		scene_frame(engine, frame, NULL);
		for (uint32_t i = 0; i < 3 * SCENE_PIXELS; i++)
			truth[i] += frame[i] / TRUTH;
	}
	c->things(scene, things, 16, 0.0f);
	c->camera(scene, things, 16, 0.0f);
	scene_frame(engine, sharp, NULL);
	scene_close(engine);
	stilb_scene_destroy(scene);
	scene = scene_of(things, 16, &front);
	engine = scene_engine(scene, 1, &on);
	for (int f = -1; f <= 0; f++) {
		c->things(scene, things, 16, (float)f);
		c->camera(scene, things, 16, (float)f);
		scene_frame(engine, blurred, NULL);
	}
	scene_close(engine);
	stilb_scene_destroy(scene);
	blur_by_taps(c);
}

static void blur_is_near_the_mean_of_frames(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		draw_case(&cases[i]);
		double off = scene_error(blurred, truth, NULL, 0.0f), by_taps = scene_error(taps, truth, NULL, 0.0f);
		double without = scene_error(sharp, truth, NULL, 0.0f);
		scene_save(truth, "motion-truth", i);
		scene_save(blurred, "motion-blurred", i);
		scene_save(taps, "motion-taps", i);
		print_message("%s %u, shutter %g: off by %.4f, 8 taps by %.4f (%.2f), without by %.4f\n", cases[i].name,
		              cases[i].seed, (double)cases[i].shutter, off, by_taps, off / by_taps, without);
		if (off > cases[i].most * by_taps || off > 0.5 * without)
			fail_msg("more than %g of the taps', or half of none's", cases[i].most);
	}
}

/* Nothing is blurred where nothing moves; a way cut to a pixel is hardly seen; and the shutter's share counts. */
static void only_what_moves_is_blurred(void **state)
{
	(void)state;
	static float whole[3 * SCENE_PIXELS], cut[3 * SCENE_PIXELS];
	stilb_post_settings posts[3] = {{0}, {.motion_blur = 0.8f}, {.motion_blur = 0.8f, .motion_blur_most = 0.0001f}};
	float *out[3] = {sharp, whole, cut};
	fill(7);
	for (uint32_t p = 0; p < 3; p++) {
		stilb_scene *scene = scene_of(things, 16, &front);
		stilb_engine *engine = scene_engine(scene, 1, &posts[p]);
		for (int f = -3; f <= 0; f++) {
			things_move(scene, things, 16, (float)(f < 0 ? f : -1));
			scene_frame(engine, out[p], NULL);
			if (f == -1) /* it moves, and stands still in the next frame */
				memcpy(p == 1 ? blurred : taps, out[p], sizeof blurred);
		}
		scene_close(engine);
		stilb_scene_destroy(scene);
	}
	assert_memory_equal(sharp, whole, sizeof sharp);
	assert_true(scene_error(blurred, sharp, NULL, 0.0f) > 0.01);
	assert_true(scene_error(taps, sharp, NULL, 0.0f) < 0.5 * scene_error(blurred, sharp, NULL, 0.0f));
}

/* While clips are paused frames keep the blur of the last step, until the camera moves. */
static void what_is_paused_stays_blurred(void **state)
{
	(void)state;
	stilb_post_settings on = {.motion_blur = 0.8f}, off = {0};
	fill(8);
	stilb_scene *scene = scene_of(things, 16, &front);
	stilb_engine *engine = scene_engine(scene, 1, &on);
	for (int f = -2; f <= 0; f++) {
		things_move(scene, things, 16, (float)f);
		scene_frame(engine, blurred, NULL);
	}
	engine->playing.pace = 0.0f;
	for (int f = 0; f < 3; f++) {
		scene_frame(engine, taps, NULL);
		assert_memory_equal(blurred, taps, sizeof taps);
	}
	scene->camera.yaw += 0.05f;
	scene_frame(engine, blurred, NULL);
	scene_frame(engine, taps, NULL);
	stilb_engine_set_post(engine, &off);
	scene_frame(engine, sharp, NULL);
	assert_memory_equal(sharp, taps, sizeof taps);
	assert_memory_not_equal(sharp, blurred, sizeof blurred);
	scene_close(engine);
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(blur_is_near_the_mean_of_frames),
		cmocka_unit_test(only_what_moves_is_blurred),
		cmocka_unit_test(what_is_paused_stays_blurred),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
