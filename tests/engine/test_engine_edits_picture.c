/* A scene that is edited between frames, on the device and under the validation layer with synchronization checks:
 * pictures and stream hashes are the same for any number of workers and every replay mode, and the picture of the
 * edited scene is the one of the same scene set anew. */
#include "engine_internal.h"
#include "tests/engine/edit_script.h"

#define FRAMES 8
#define WIDTH 96
#define HEIGHT 64

/* Hash of the last frame's picture. */
static uint64_t picture(stilb_engine *engine)
{
	stilb_image image = {0};
	assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_OK);
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, image.pixels, stilb_image_size(&image));
	stilb_image_finish(&image);
	return hash;
}

static uint64_t draw(stilb_engine *engine)
{
	stilb_engine_report report;
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return picture(engine);
}

/* Runs the script on an engine that may have shown other scenes. look: read the picture of each frame, which waits for
 * the device; else only that of the last, so that two frames are in flight. */
static void run(stilb_engine *engine, bool look, uint64_t pictures[FRAMES], uint64_t hashes[FRAMES])
{
	edit_script script;
	stilb_scene *scene = script_begin(&script, 21);
	stilb_engine_report report;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	for (uint32_t f = 0; f < FRAMES; f++) {
		script_step(&script, scene, f);
		if (look || f == FRAMES - 1)
			pictures[f] = draw(engine);
		else
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		hashes[f] = stilb_engine_stream_hash(engine);
	}
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_true(draw(engine) == pictures[FRAMES - 1]);
	assert_int_equal(stilb_engine_set_scene(engine, NULL), STILB_OK);
	stilb_scene_destroy(scene);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
}

static stilb_engine *make_engine(int replay, uint32_t workers)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = workers;
	desc.replay = (stilb_render_replay_mode)replay;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.validate = true;
	desc.profile = false;
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static void pictures_are_the_same(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	uint64_t pictures[FRAMES], hashes[FRAMES], got[FRAMES], got_hashes[FRAMES];
	for (int replay = 0; replay < 3; replay++) {
		stilb_engine *engine = make_engine(replay, 0);
		for (int w = 0; w < 5; w++) {
			assert_int_equal(stilb_engine_set_workers(engine, workers[w]), STILB_OK);
			bool first = replay == 0 && w == 0, look = w % 2 == 0;
			run(engine, look, first ? pictures : got, first ? hashes : got_hashes);
			if (first)
				continue;
			assert_memory_equal(got + (look ? 0 : FRAMES - 1), pictures + (look ? 0 : FRAMES - 1),
			                    (look ? FRAMES : 1) * sizeof *got);
			assert_memory_equal(got_hashes, hashes, sizeof hashes);
		}
		stilb_engine_destroy(engine);
	}
	for (int f = 1; f < FRAMES; f++)
		assert_true(pictures[f] != pictures[f - 1]);
}

/* After 10^4 random edits the device shows what another one shows that is given the scene as it is now. */
static void many_edits_look_like_a_new_scene(void **state)
{
	(void)state;
	edit_script script;
	stilb_scene *scene = script_begin(&script, 33);
	stilb_engine *engine = make_engine(0, 1);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	uint64_t seen = 0, stream;
	for (uint32_t step = 0; step < 400; step++) { /* of 27 edits and more */
		script_step(&script, scene, step);
		if (step % 100 == 99)
			seen = draw(engine);
	}
	stream = stilb_engine_stream_hash(engine);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	engine = make_engine(0, 1);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_true(draw(engine) == seen && stilb_engine_stream_hash(engine) == stream);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_the_same),
		cmocka_unit_test(many_edits_look_like_a_new_scene),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
