/* The same bits with Embree: 1, 2, 3 and 7 threads, every integrator and sampler, through checkpoints and without; and
 * in parts, every integrator and built-in scene. */
#include "gi/gi_farm.h"
#include "gi_render_fixture.h"
#include "support/folder.h"

static const char path[] = "a.checkpoint";

static int tear_down(void **state)
{
	(void)state;
	remove(path);
	return folder_remove();
}

static const uint32_t workers[] = {0, 1, 2, 6}; /* beside the thread that asks */
#define WORKER_COUNTS (sizeof workers / sizeof *workers)

static void same_bits_for_workers(void **state)
{
	(void)state;
	enum { COUNT = STILB_GI_INTEGRATOR_COUNT + STILB_GI_SAMPLER_COUNT };
	uint64_t hashes[COUNT];
	for (size_t w = 0; w < WORKER_COUNTS; w++) {
		render_fixture fixture = render_fixture_with("cornell", workers[w], &stilb_gi_embree);
		for (int i = 0; i < COUNT; i++) {
			stilb_gi_settings settings = render_fixture_settings(&fixture);
			settings.samples = 4;
			settings.depth = 3;
			settings.progressive = w % 2;
			if (i < STILB_GI_INTEGRATOR_COUNT)
				settings.integrator = (stilb_gi_integrator)i;
			else
				settings.sampler = (stilb_gi_sampler_kind)(i - STILB_GI_INTEGRATOR_COUNT);
			uint64_t hash = render_whole(&fixture, &settings);
			if (w == 0)
				hashes[i] = hash;
			assert_int_equal(hash, hashes[i]);
		}
		render_fixture_finish(&fixture);
	}
}

/* Half the samples and a checkpoint, and the rest with other threads. */
static void same_bits_with_resume(void **state)
{
	(void)state;
	uint64_t whole = 0;
	for (size_t w = 0; w < WORKER_COUNTS; w++) {
		render_fixture fixture = render_fixture_with("cornell", workers[w], &stilb_gi_embree);
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		if (w > 0 && stilb_gi_render_resume(render, path) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		if (w > 0)
			assert_int_equal(film_hash(render), whole);
		stilb_gi_render_destroy(render);
		whole = render_whole(&fixture, &settings);
		settings.samples /= 2;
		render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
		stilb_gi_render_destroy(render);
		render_fixture_finish(&fixture);
	}
}

/* Renders a part of the picture into a file, or all of it: of 0. */
static void render_file(const render_fixture *fixture, const stilb_gi_settings *settings, uint32_t part, uint32_t of,
                        const char *file)
{
	stilb_gi_render *render = render_fixture_create(fixture, settings);
	if (of > 0)
		assert_int_equal(stilb_gi_farm_share(render, part, of), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	if ((of > 0 ? stilb_gi_farm_save_part(render, file) : stilb_gi_render_save(render, file)) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_render_destroy(render);
}

static void assert_same_files(const char *a, const char *b)
{
	FILE *one = fopen(a, "rb"), *other = fopen(b, "rb");
	assert_true(one && other);
	int x, y;
	do {
		x = getc(one);
		y = getc(other);
		assert_int_equal(x, y);
	} while (x != EOF);
	fclose(one);
	fclose(other);
}

/* Each scene is made anew for the second part, with other threads. */
static void same_bits_in_parts(void **state)
{
	(void)state;
	static const char *const scenes[] = {"cornell", "outdoor", "furnace:0.5", "plane-wall", "stress", "spheres"};
	static const char *const parts[] = {"2.part", "1.part"};
	for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
		render_fixture here = render_fixture_with(scenes[s], 1, &stilb_gi_embree);
		render_fixture there = render_fixture_with(scenes[s], 0, &stilb_gi_embree);
		for (int i = 0; i < STILB_GI_INTEGRATOR_COUNT; i++) {
			stilb_gi_settings settings = render_fixture_settings(&here);
			stilb_gi_farm_merged merged;
			settings.integrator = (stilb_gi_integrator)i;
			settings.samples = 2;
			settings.depth = 2;
			render_file(&here, &settings, 0, 0, "whole.exr");
			render_file(&here, &settings, 1, 2, "1.part");
			render_file(&there, &settings, 2, 2, "2.part");
			if (stilb_gi_farm_merge(parts, 2, "merged.exr", here.pool, &merged) != STILB_OK)
				fail_msg("%s", stilb_error_message());
			assert_same_files("whole.exr", "merged.exr");
		}
		render_fixture_finish(&there);
		render_fixture_finish(&here);
	}
	folder_clear();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(same_bits_for_workers),
		cmocka_unit_test(same_bits_with_resume),
		cmocka_unit_test(same_bits_in_parts),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
