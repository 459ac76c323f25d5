/* Antialiasing beside 64 samples a pixel: edges of still and of moving pictures, what is left of something that has
 * gone, and light that is no number. */
#include "post_scenes.h"
#include "post_stage.h"

#include <stdio.h>

static const stilb_scene_camera front = {.position = {0, 0, 80}, .fov_y = 0.0845f, .near_z = 0.1f, .far_z = 200.0f};

#define NO_TURN                                                                                                        \
	{                                                                                                                  \
		0, 0, 0, 1                                                                                                     \
	}
#define WALL(r, g, b)                                                                                                  \
	{                                                                                                                  \
		0, {r, g, b},                                                                                                  \
		{                                                                                                              \
			.scale = {20, 20, 0.5f}, .translation = {0, 0, -4}, .rotation = NO_TURN                                    \
		}                                                                                                              \
	}

/* A frame's way: where things and the camera are then. */
typedef void scene_move(stilb_scene *scene, uint32_t frame, float pixels);

typedef struct moving {
	const char *name;
	const scene_thing *things;
	uint32_t count;
	scene_move *move;
} moving;

/* Metres that a pixel is wide, so far in front of the camera. */
static float metres_of(float pixels, float ahead)
{
	return pixels * 2.0f * tanf(0.5f * front.fov_y) * ahead / SCENE_HEIGHT;
}

static void put(stilb_scene *scene, uint32_t model, const scene_thing *thing, float x, float y)
{
	stilb_scene_pose pose = thing->pose;
	pose.translation[0] += x;
	pose.translation[1] += y;
	stilb_mat4 place = stilb_scene_pose_matrix(&pose);
	assert_int_equal(stilb_scene_set_transform(scene, model, &place), STILB_OK);
}

/* ---- a ball and a turned box before a wall ----------------------------------------------------------------------- */

static const scene_thing simple[] = {
	WALL(0.1f, 0.15f, 0.3f),
	{1, {0.9f, 0.6f, 0.2f}, {.scale = {1.2f, 1.2f, 1.2f}, .translation = {-1.5f, 0.3f, 0}, .rotation = NO_TURN}},
	{0,
     {0.8f, 0.8f, 0.8f},
     {.scale = {0.9f, 0.9f, 0.1f}, .translation = {1.6f, -0.4f, 0}, .rotation = {0, 0, 0.2f, 0.98f}}},
};

static void simple_move(stilb_scene *scene, uint32_t frame, float pixels)
{
	float way = metres_of(pixels * (float)frame, 80.0f);
	put(scene, 1, &simple[1], way, 0.3f * way);
	put(scene, 2, &simple[2], -0.8f * way, 0.6f * way);
}

/* ---- a heap, seen by a camera that passes ------------------------------------------------------------------------ */

static scene_thing heap[16];

static void heap_fill(uint32_t seed)
{
	heap[0] = (scene_thing){
		0, {0.35f, 0.3f, 0.25f}, {.scale = {20, 1, 20}, .translation = {0, -2.5f, 0}, .rotation = NO_TURN}};
	for (uint32_t t = 1; t < 16; t++) {
		float size = 0.3f + 0.5f * stilb_random_float(seed, 8 * t), turn = 3.0f * stilb_random_float(seed, 8 * t + 1);
		heap[t] = (scene_thing){t % 2,
		                        {stilb_random_float(seed, 8 * t + 2), stilb_random_float(seed, 8 * t + 3),
		                         stilb_random_float(seed, 8 * t + 4)},
		                        {.scale = {size, size, size},
		                         .translation = {8.0f * stilb_random_float(seed, 8 * t + 5) - 4.0f, size - 1.5f,
		                                         5.0f * stilb_random_float(seed, 8 * t + 6) - 4.0f},
		                         .rotation = {0, sinf(turn), 0, cosf(turn)}}};
	}
}

static void heap_move(stilb_scene *scene, uint32_t frame, float pixels)
{
	scene->camera.position[0] = front.position[0] + metres_of(pixels * (float)frame, 80.0f);
}

static const scene_thing flat[] = {
	WALL(0.1f, 0.15f, 0.3f),
	{0,
     {0.8f, 0.8f, 0.8f},
     {.scale = {0.9f, 0.9f, 0.001f}, .translation = {-1.6f, -0.4f, 0}, .rotation = {0, 0, 0.2f, 0.98f}}},
};

static void flat_move(stilb_scene *scene, uint32_t frame, float pixels)
{
	put(scene, 1, &flat[1], metres_of(pixels * (float)frame, 80.0f), 0.0f);
}

static const moving scenes[] = {{"flat", flat, 2, flat_move},
                                {"simple", simple, sizeof simple / sizeof *simple, simple_move},
                                {"heap", heap, 16, heap_move}};

/* ---- edges ------------------------------------------------------------------------------------------------------- */

static float none[3 * SCENE_PIXELS], with[3 * SCENE_PIXELS], truth[3 * SCENE_PIXELS], varies[SCENE_PIXELS];

/* Draws frames until the last one, all three ways: without, with antialiasing, and the last one in 64 samples. */
static void draw_all(const moving *m, stilb_post_aa aa, float pixels, uint32_t frames)
{
	stilb_post_settings off = {0}, on = {.aa = aa};
	stilb_scene *scene = scene_of(m->things, m->count, &front);
	stilb_engine *fine = scene_engine(scene, SCENE_FINE, &off);
	m->move(scene, frames - 1, pixels);
	scene_frame(fine, truth, varies);
	scene_close(fine);
	stilb_engine *engine = scene_engine(scene, 1, &off);
	scene_frame(engine, none, NULL);
	scene_close(engine);
	stilb_scene_destroy(scene);
	scene = scene_of(m->things, m->count, &front);
	engine = scene_engine(scene, 1, &on);
	for (uint32_t f = 0; f < frames; f++) {
		m->move(scene, f, pixels);
		scene_frame(engine, with, NULL);
	}
	scene_close(engine);
	stilb_scene_destroy(scene);
	scene_save(truth, m->name, (uint32_t)(10 * pixels));
	scene_save(none, m->name, (uint32_t)(10 * pixels) + 1);
	scene_save(with, m->name, (uint32_t)(10 * pixels) + 2);
}

#define EDGE 0.05f /* by which samples of a pixel differ, of display white */

/* Of what stands still the error of edges is a quarter at most, and all of the picture within 1 % of 64 samples. */
static void still_edges_are_smooth(void **state)
{
	(void)state;
	for (uint32_t seed = 1; seed <= 2; seed++)
		for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
			heap_fill(seed);
			draw_all(&scenes[s], STILB_POST_AA_TEMPORAL, 0.0f, 16);
			double before = scene_error(none, truth, varies, EDGE), after = scene_error(with, truth, varies, EDGE);
			double all = scene_error(with, truth, NULL, 0.0f);
			print_message("%s, heap %u: edges off by %.4f, without by %.4f; all pixels by %.4f\n", scenes[s].name, seed,
			              after, before, all);
			if (after > 0.25 * before || all > 0.01)
				fail_msg("edges off by more than a quarter, or the picture by more than 1 %%");
		}
}

/* Of what moves it is half at most, where nothing passes in front of anything that moves another way. */
static void moving_edges_are_smooth(void **state)
{
	(void)state;
	static const struct {
		size_t scene;
		uint32_t seed;
		float pixels;
		double most;
	} cases[] = {{0, 1, 1.0f, 0.5}, {0, 1, 4.0f, 0.5}, {0, 1, 0.37f, 0.5}, {0, 1, 2.6f, 0.5}, {1, 1, 1.0f, 0.7},
	             {1, 1, 4.0f, 0.7}, {2, 1, 1.0f, 0.5}, {2, 1, 4.0f, 0.5},  {2, 2, 1.0f, 0.5}, {2, 2, 4.0f, 0.5}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
		const moving *m = &scenes[cases[c].scene];
		heap_fill(cases[c].seed);
		draw_all(m, STILB_POST_AA_TEMPORAL, cases[c].pixels, 16);
		double before = scene_error(none, truth, varies, EDGE), after = scene_error(with, truth, varies, EDGE);
		print_message("%s %u, %g pixels a frame: edges off by %.4f, without by %.4f: %.2f\n", m->name, cases[c].seed,
		              (double)cases[c].pixels, after, before, after / before);
		if (after > cases[c].most * before)
			fail_msg("more than %g", cases[c].most);
	}
}

/* A filter of the shown picture takes a tenth of the error of its edges at least, and leaves nearly all else. */
static void filtered_edges_are_smoother(void **state)
{
	(void)state;
	scene_output = STILB_RENDER_OUTPUT_DISPLAY;
	for (uint32_t seed = 1; seed <= 3; seed++)
		for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
			heap_fill(seed);
			draw_all(&scenes[s], STILB_POST_AA_POST, 0.0f, 1);
			double before = scene_error(none, truth, varies, EDGE), after = scene_error(with, truth, varies, EDGE);
			uint32_t changed = 0;
			for (uint32_t p = 0; p < SCENE_PIXELS; p++) {
				bool edge = false;
				for (int y = -1; y <= 1; y++)
					for (int x = -1; x <= 1; x++) {
						uint32_t at = p + (uint32_t)(y * SCENE_WIDTH + x);
						edge |= at >= SCENE_PIXELS || varies[at] >= 0.02f;
					}
				changed += !edge && memcmp(&with[3 * p], &none[3 * p], 3 * sizeof *with) != 0;
			}
			if (after > 0.9 * before || changed > SCENE_PIXELS / 100)
				fail_msg("edges are hardly smoother, or other pixels are changed");
			print_message("%s, heap %u, filtered: edges off by %.4f, without by %.4f: %.2f; %u others changed\n",
			              scenes[s].name, seed, after, before, after / before, changed);
		}
	scene_output = STILB_RENDER_OUTPUT_LINEAR;
}

/* ---- what has gone ----------------------------------------------------------------------------------------------- */

enum { GONE = 32, AFTER = 8 /* frames */ };

typedef enum gone_kind { GONE_OBJECT, GONE_PART, GONE_CAMERA, GONE_JUMP, GONE_KINDS } gone_kind;

/* Something passes. All numbers are those of its left side and of what is behind it. */
typedef struct gone_way {
	const char *name;
	stilb_scene_camera camera;
	float left, right, z; /* of the box, metres */
	float step;           /* metres a frame, of the box or, to the left, of the camera */
	uint32_t frames;      /* until what it has left is looked at */
	bool joined;          /* the box is a part of the model that is behind it */
} gone_way;

#define AFAR                                                                                                           \
	{                                                                                                                  \
		.position = {0, 0, 80}, .fov_y = 0.0845f, .near_z = 0.1f, .far_z = 200.0f                                      \
	}
#define CLOSE                                                                                                          \
	{                                                                                                                  \
		.position = {0, 0, 12}, .fov_y = 0.5f, .near_z = 0.1f, .far_z = 200.0f                                         \
	}

static const gone_way gone_ways[GONE_KINDS] = {
	[GONE_OBJECT] = {"object", AFAR, -3.0f, -1.0f, 6.0f, 0.42f, 12, false},
	[GONE_PART] = {"part", AFAR, -3.0f, -1.0f, -2.8f, 0.84f, 7, true},     /* by its movement alone it is another one */
	[GONE_CAMERA] = {"camera", CLOSE, -1.8f, -0.6f, 6.0f, 0.34f, 6, true}, /* by its depth alone */
	[GONE_JUMP] = {"jump", AFAR, -1.5f, 1.5f, -2.8f, 0.0f, 8, false},      /* by its number alone */
};

/* A box before slats of its colour on a dark wall: by colours alone nobody could tell it from them. */
static void gone_fill(const gone_way *way, scene_thing things[GONE])
{
	float half = 0.5f * (way->right - way->left);
	things[0] = (scene_thing){
		0,
		{0.9f, 0.6f, 0.2f},
		{.scale = {half, 1.5f, 0.05f}, .translation = {way->left + half, 0, way->z}, .rotation = NO_TURN}};
	things[1] = (scene_thing)WALL(0.1f, 0.15f, 0.3f);
	for (uint32_t t = 2; t < GONE; t++)
		things[t] = (scene_thing){
			0,
			{0.9f, 0.6f, 0.2f},
			{.scale = {0.07f, 6, 0.1f}, .translation = {0.31f * (float)t - 5.0f, 0, -3.0f}, .rotation = NO_TURN}};
}

static void gone_move(stilb_scene *scene, gone_kind kind, const scene_thing *things, uint32_t frame)
{
	float x = gone_ways[kind].step * (float)frame;
	stilb_mat4 places[GONE];
	for (uint32_t t = 0; t < GONE; t++)
		places[t] = stilb_scene_pose_matrix(&things[t].pose);
	places[0].m[12] += kind == GONE_JUMP && frame >= gone_ways[kind].frames ? 100.0f : x;
	if (kind == GONE_CAMERA)
		scene->camera.position[0] = -x;
	else if (kind == GONE_PART)
		assert_int_equal(stilb_scene_set_part_transforms(scene, 0, places), STILB_OK);
	else
		assert_int_equal(stilb_scene_set_transform(scene, 0, &places[0]), STILB_OK);
}

/* The column of a point that moves with the box or, behind, with the wall, so many frames later. */
static float gone_column(gone_kind kind, float x, float z, bool behind, uint32_t frame)
{
	const gone_way *way = &gone_ways[kind];
	float pixel = 2.0f * tanf(0.5f * way->camera.fov_y) * (way->camera.position[2] - z) / SCENE_HEIGHT;
	return 0.5f * SCENE_WIDTH + (x + (behind && kind != GONE_CAMERA ? 0.0f : way->step * (float)frame)) / pixel;
}

/* What the box leaves in frame way->frames: columns *first .. *end - 1, without those beside it now and before, and
 * where they are `later` frames after. */
static void gone_strip(gone_kind kind, uint32_t later, uint32_t *first, uint32_t *end)
{
	const gone_way *way = &gone_ways[kind];
	float side = gone_column(kind, way->left, way->z, false, way->frames);
	float before = gone_column(kind, way->left, way->z, false, way->frames - 1);
	float wall = gone_column(kind, 0.0f, -3.0f, true, 1) - gone_column(kind, 0.0f, -3.0f, true, 0);
	*first = (uint32_t)(before + fmaxf(wall, 0.0f) + 2.0f + wall * (float)later);
	*end = (uint32_t)((kind == GONE_JUMP ? gone_column(kind, way->right, way->z, false, 0) : side) - 2.0f +
	                  wall * (float)later);
}

static double gone_difference(const float *a, const float *b, uint32_t first, uint32_t end, double *worst)
{
	double sum = 0.0;
	*worst = 0.0;
	assert_true(end > first && end <= SCENE_WIDTH);
	for (uint32_t y = 35; y < 55; y++)
		for (uint32_t i = 3 * (y * SCENE_WIDTH + first); i < 3 * (y * SCENE_WIDTH + end); i++) {
			sum += fabs((double)(a[i] - b[i]));
			*worst = fmax(*worst, fabs((double)(a[i] - b[i])));
		}
	return sum;
}

/* Where nothing is left of what was there, frames are like those of a chain that has forgotten everything: they differ
 * by 2 % at most of what the change was in the first frame, and by 1/255 after eight. */
static void what_has_gone_leaves_nothing(void **state)
{
	(void)state;
	static const stilb_post_settings on = {.aa = STILB_POST_AA_TEMPORAL};
	static scene_thing things[GONE];
	static float kept[3 * SCENE_PIXELS], fresh[3 * SCENE_PIXELS], before[3 * SCENE_PIXELS];
	for (gone_kind kind = 0; kind < GONE_KINDS; kind++) {
		const gone_way *way = &gone_ways[kind];
		gone_fill(way, things);
		stilb_scene *scenes_of[2] = {scene_made(things, GONE, &way->camera, way->joined),
		                             scene_made(things, GONE, &way->camera, way->joined)};
		stilb_engine *engines[2] = {scene_engine(scenes_of[0], 1, &on), scene_engine(scenes_of[1], 1, &on)};
		double left = 0.0, change = 1.0, worst = 0.0;
		uint32_t first, end;
		for (uint32_t f = 0; f <= way->frames + AFTER; f++) {
			for (uint32_t e = 0; e < 2; e++)
				gone_move(scenes_of[e], kind, things, f);
			if (f == way->frames)
				stilb_post_forget(engines[1]->post);
			memcpy(before, kept, sizeof before);
			scene_frame(engines[0], kept, NULL);
			scene_frame(engines[1], fresh, NULL);
			scene_save(kept, way->name, f);
			if (f == way->frames)
				assert_memory_not_equal(kept, fresh, sizeof kept); /* it has forgotten */
			if (f < way->frames)
				continue;
			gone_strip(kind, f - way->frames, &first, &end);
			double off = gone_difference(kept, fresh, first, end, &worst);
			if (f == way->frames) {
				left = off;
				change = gone_difference(before, fresh, first, end, &worst);
				assert_true(change > 5.0);
			}
		}
		print_message("%s: %.4f of the change is left, after %d frames %.5f\n", way->name, left / change, AFTER, worst);
		if (left > 0.02 * change || worst > 1.0 / 255.0)
			fail_msg("something is left");
		for (uint32_t e = 0; e < 2; e++) {
			scene_close(engines[e]);
			stilb_scene_destroy(scenes_of[e]);
		}
	}
}

/* ---- light that is none, and sizes ------------------------------------------------------------------------------- */

static void light_random(const post_stage *s, uint64_t seed, float *rgb)
{
	for (uint32_t i = 0; i < 3 * s->width * s->height; i++)
		rgb[i] = stilb_image_half_to_float(stilb_image_half_from_float(stilb_random_float(seed, i)));
}

static void stage_follow(post_stage *s)
{
	static stilb_mat4 still;
	still = stilb_mat4_identity();
	stage_still(s);
	stilb_post_see(s->post, &(stilb_render_view){.view_projection = still, .last = &still});
	stilb_post_set(s->post, &(stilb_post_settings){.aa = STILB_POST_AA_TEMPORAL});
}

/* In pictures of all sizes what stands still and keeps its light keeps it, to the rounding of half floats. */
static void all_sizes_are_means(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {64, 48}, {16384, 1}, {1, 300}};
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, sizes[i][0], sizes[i][1]);
		stage_follow(&s);
		uint32_t values = 3 * s.width * s.height;
		float *light = calloc(values, sizeof *light);
		assert_non_null(light);
		light_random(&s, i, light);
		stage_light(&s, light);
		for (uint32_t f = 0; f < 4; f++) {
			float *shown = stage_shown(&s);
			for (uint32_t v = 0; v < values; v++)
				if (fabsf(shown[v] - light[v]) > 4e-3f)
					fail_msg("%u x %u, frame %u, value %u: %g, not %g", s.width, s.height, f, v, (double)shown[v],
					         (double)light[v]);
			free(shown);
		}
		free(light);
		stage_close(&s);
	}
}

/* Where nothing around is light, nothing is made up. */
static void areas_without_light_are_black(void **state)
{
	(void)state;
	static float light[3 * 48 * 32];
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 48, 32);
	stage_follow(&s);
	light_random(&s, 7, light);
	for (uint32_t i = 0; i < 25; i++)
		for (uint32_t c = 0; c < 3; c++)
			light[3 * ((10 + i / 5) * 48 + 20 + i % 5) + c] = INFINITY;
	stage_light(&s, light);
	for (uint32_t f = 0; f < 5; f++) {
		float *shown = stage_shown(&s);
		for (uint32_t c = 0; c < 3; c++)
			if (!(fabsf(shown[3 * (12 * 48 + 22) + c]) <= 1e-3f))
				fail_msg("frame %u: %g", f, (double)shown[3 * (12 * 48 + 22) + c]);
		free(shown);
	}
	stage_close(&s);
}

/* A pixel that is no light in one frame is like those around it then, and no other pixel knows of it, then or later. */
static void what_is_no_light_is_left_out(void **state)
{
	(void)state;
	static const float values[] = {NAN, INFINITY, -INFINITY};
	for (size_t v = 0; v < sizeof values / sizeof *values; v++)
		for (uint32_t when = 0; when < 3; when += 2) {
			post_stage s;
			stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 48, 32);
			stage_follow(&s);
			static float light[3 * 48 * 32], broken[3 * 48 * 32];
			uint32_t at = 17 * 48 + 21;
			light_random(&s, 7, light);
			memcpy(broken, light, sizeof light);
			broken[3 * at + v] = values[v];
			for (uint32_t f = 0; f < 6; f++) {
				stage_light(&s, f == when ? broken : light);
				float *shown = stage_shown(&s);
				for (uint32_t i = 0; i < 3 * 48 * 32; i++) {
					float allowed = i / 3 == at && f >= when ? 1.0f / (float)(f - when + 1) : 4e-3f;
					if (!(fabsf(shown[i] - light[i]) <= allowed))
						fail_msg("with %g in frame %u, frame %u, pixel %u: %g, not %g", (double)values[v], when, f,
						         i / 3, (double)shown[i], (double)light[i]);
				}
				for (uint32_t c = 0; c < 3 && f == 0 && when == 0; c++) {
					float low = 1.0f, high = 0.0f;
					for (uint32_t n = 0; n < 9; n++) {
						float beside = light[3 * (at + (n / 3) * 48 + n % 3 - 49) + c];
						low = n == 4 ? low : fminf(low, beside);
						high = n == 4 ? high : fmaxf(high, beside);
					}
					assert_true(shown[3 * at + c] > low && shown[3 * at + c] < high);
				}
				free(shown);
			}
			stage_close(&s);
		}
}

/* ---- what jitter leaves alone ------------------------------------------------------------------------------------ */

/* Places are within the pixel, none twice, and the first 4, 16 and 64 have one in each square of as fine a grid. */
static void places_are_spread(void **state)
{
	(void)state;
	for (uint32_t side = 2; side <= 8; side *= 2) {
		bool taken[64] = {false};
		for (uint32_t f = 0; f < side * side; f++) {
			float at[2], again[2];
			stilb_post_jitter(f, at);
			stilb_post_jitter(f + 64, again);
			assert_memory_equal(at, again, sizeof at);
			assert_true(fabsf(at[0]) < 0.5f && fabsf(at[1]) < 0.5f);
			uint32_t x = (uint32_t)((at[0] + 0.5f) * (float)side), y = (uint32_t)((at[1] + 0.5f) * (float)side);
			assert_false(taken[y * side + x]);
			taken[y * side + x] = true;
		}
	}
}

/* Which models are drawn, in which levels and order, is the same in each frame, and so is what views are afterwards.
 * Frames of the same numbers are the same bits, for all numbers of workers. */
static void jitter_moves_pixels_alone(void **state)
{
	(void)state;
	static float pictures[2][3 * SCENE_PIXELS];
	heap_fill(1);
	for (uint32_t aa = 0; aa < STILB_POST_AA_COUNT; aa++)
		for (uint32_t run = 0; run < 2; run++) {
			stilb_post_settings post = {.aa = (stilb_post_aa)aa};
			stilb_scene *scene = scene_of(heap, 16, &front);
			scene_workers = 2 * run;
			stilb_engine *engine = scene_engine(scene, 1, &post);
			scene_workers = 0;
			stilb_mat4 still = stilb_scene_camera_matrix(&front, (float)SCENE_WIDTH / SCENE_HEIGHT);
			uint64_t hash = 0;
			for (uint32_t f = 0; f < 5; f++) {
				scene_frame(engine, pictures[run], NULL);
				assert_true(f == 0 || stilb_engine_stream_hash(engine) == hash);
				hash = stilb_engine_stream_hash(engine);
				assert_memory_equal(&engine->views[0].view_projection, &still, sizeof still);
				assert_memory_equal(&engine->lasts[0].view_projection, &still, sizeof still);
			}
			if (run == 1)
				assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
			scene_close(engine);
			stilb_scene_destroy(scene);
		}
}

/* With several samples a pixel, and when the picture's size or the scene changes, frames are sound. */
static void changes_are_taken(void **state)
{
	(void)state;
	static const stilb_post_settings on = {.aa = STILB_POST_AA_TEMPORAL};
	heap_fill(2);
	stilb_scene *first = scene_of(heap, 16, &front), *second = scene_of(simple, 3, &front);
	scene_samples = 4;
	stilb_engine *engine = scene_engine(first, 1, &on), *fresh;
	for (uint32_t f = 0; f < 3; f++)
		scene_frame(engine, with, NULL);
	assert_int_equal(stilb_engine_set_scene(engine, second), STILB_OK);
	scene_frame(engine, with, NULL); /* frame 3 */
	fresh = scene_engine(second, 1, &on);
	for (uint32_t f = 0; f < 4; f++) {
		stilb_post_forget(fresh->post);
		scene_frame(fresh, none, NULL);
	}
	scene_samples = 1;
	assert_memory_equal(with, none, sizeof with);
	scene_close(engine);
	scene_close(fresh);
	stilb_scene_destroy(first);
	stilb_scene_destroy(second);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(still_edges_are_smooth),        cmocka_unit_test(moving_edges_are_smooth),
		cmocka_unit_test(filtered_edges_are_smoother),   cmocka_unit_test(what_has_gone_leaves_nothing),
		cmocka_unit_test(all_sizes_are_means),           cmocka_unit_test(what_is_no_light_is_left_out),
		cmocka_unit_test(areas_without_light_are_black), cmocka_unit_test(places_are_spread),
		cmocka_unit_test(jitter_moves_pixels_alone),     cmocka_unit_test(changes_are_taken),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
