/* Pictures of parts have the bits of one machine's: any parts, in any order, by any workers, stopped or not. */
#include "gi/film/gi_unit.h"
#include "gi/gi_farm.h"
#include "gi_render_fixture.h"
#include "support/folder.h"

static int tear_down(void **state)
{
	(void)state;
	return folder_remove();
}

static uint64_t hash_of(const char *path)
{
	static char bytes[1 << 20];
	FILE *stream = fopen(path, "rb");
	assert_non_null(stream);
	size_t size = fread(bytes, 1, sizeof bytes, stream);
	fclose(stream);
	assert_in_range(size, 1000, sizeof bytes - 1);
	return stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size);
}

/* ---- units ------------------------------------------------------------------------------------------------------- */

/* Every pixel is in one unit. The units of any range are spread: none of the quarters of the picture gets less than a
 * sixth of those of a range of 64. */
static void units_cover_and_spread(void **state)
{
	(void)state;
	const uint32_t sizes[][2] = {{1, 1}, {8, 8}, {9, 1}, {37, 21}, {640, 360}, {3000, 17}, {17, 3000}, {500, 300}};
	for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
		gi_units units;
		uint32_t width = sizes[k][0], height = sizes[k][1];
		assert_true(gi_units_create(width, height, 1u << k, &units));
		uint8_t *seen = calloc(width, height);
		uint64_t pixels = 0;
		for (uint32_t u = 0; u < units.count; u++) {
			gi_unit_place place = gi_unit_place_of(&units, u);
			assert_true(place.x + place.width <= width && place.y + place.height <= height && place.width > 0);
			for (uint32_t y = 0; y < place.height; y++)
				for (uint32_t x = 0; x < place.width; x++)
					seen[(place.y + y) * width + place.x + x]++;
			pixels += place.width * place.height;
		}
		for (uint32_t i = 0; i < width * height; i++)
			assert_int_equal(seen[i], 1);
		assert_int_equal(pixels, width * height);
		assert_int_equal(units.side, k < 4 ? 16 : k < 6 ? 8 : 4);
		assert_int_equal(gi_unit_pixels(&units, 0, units.count), pixels);
		free(seen);
		free(units.order);
	}
	gi_units units;
	assert_true(gi_units_create(640, 360, 16, &units));
	for (uint32_t first = 0; first + 64 <= units.count; first += 13) {
		uint32_t quarters[4] = {0};
		for (uint32_t u = first; u < first + 64; u++) {
			gi_unit_place place = gi_unit_place_of(&units, u);
			quarters[(place.x >= 320) + 2 * (place.y >= 180)]++;
		}
		for (int q = 0; q < 4; q++)
			assert_in_range(quarters[q], 11, 24);
	}
	free(units.order);
}

/* ---- the same bits ----------------------------------------------------------------------------------------------- */

static void make_part(const stilb_gi_settings *settings, uint32_t index, uint32_t of, const char *path)
{
	render_fixture fixture = render_fixture_make("cornell", index % 3); /* other workers for each */
	stilb_gi_render *render = render_fixture_create(&fixture, settings);
	assert_int_equal(stilb_gi_farm_share(render, index, of), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_true(progress_of(render).finished);
	assert_true(progress_of(render).done == 1.0);
	if (stilb_gi_farm_save_part(render, path) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

static void make_parts(const stilb_gi_settings *settings, uint32_t of, char paths[][32])
{
	for (uint32_t i = 1; i <= of; i++) {
		snprintf(paths[i - 1], sizeof paths[i - 1], "%u-%u.part", i, of);
		make_part(settings, i, of, paths[i - 1]);
	}
}

static uint64_t whole_hash(const stilb_gi_settings *settings, const char *path)
{
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_render *render = render_fixture_create(&fixture, settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(stilb_gi_render_save(render, path), STILB_OK);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
	return hash_of(path);
}

static stilb_result merge_files(const char *const *paths, uint32_t count, const char *output,
                                stilb_gi_farm_merged *merged)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	stilb_result result = stilb_gi_farm_merge(paths, count, output, pool, merged);
	stilb_job_pool_destroy(pool);
	return result;
}

static stilb_result merge(char paths[][32], uint32_t count, uint32_t turn, const char *output)
{
	const char *order[16];
	for (uint32_t i = 0; i < count; i++)
		order[i] = paths[(i * (turn % 2 ? count - 1 : 1) + turn) % count];
	stilb_gi_farm_merged merged;
	stilb_result result = merge_files(order, count, output, &merged);
	if (result == STILB_OK)
		assert_true(merged.width == 37 && merged.height == 21 && merged.rays > 0 && merged.seconds > 0.0);
	return result;
}

static void same_bits(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	render_fixture_finish(&fixture);
	char paths[5][32];
	for (int variant = 0; variant < (TEST_TSAN ? 1 : 4); variant++) {
		settings.firefly_weight = variant == 1;
		settings.integrator = variant == 2 ? STILB_GI_INTEGRATOR_IRRADIANCE_CACHE : STILB_GI_INTEGRATOR_PATH;
		settings.denoise = variant == 1;
		settings.sampler = variant == 3 ? STILB_GI_SAMPLER_BLUE_NOISE : STILB_GI_SAMPLER_SOBOL;
		settings.seed = UINT64_MAX - (uint64_t)variant; /* no double holds it */
		uint64_t whole = whole_hash(&settings, "whole.exr"), shown = whole_hash(&settings, "whole.png");
		for (uint32_t of = 1; of <= 5; of++) {
			make_parts(&settings, of, paths);
			for (uint32_t turn = 0; turn < of; turn++) {
				assert_int_equal(merge(paths, of, turn, "merged.exr"), STILB_OK);
				assert_int_equal(hash_of("merged.exr"), whole);
			}
			assert_int_equal(merge(paths, of, 0, "merged.png"), STILB_OK);
			assert_int_equal(hash_of("merged.png"), shown);
		}
	}
	folder_clear();
}

/* With more parts than units some hold nothing, and are parts all the same. */
static void more_parts_than_units(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.width = 10;
	settings.height = 8;
	render_fixture_finish(&fixture);
	char paths[7][32];
	const char *order[7];
	stilb_gi_farm_merged merged;
	make_parts(&settings, 7, paths); /* of 1 or 2 units */
	for (int i = 0; i < 7; i++)
		order[i] = paths[i];
	assert_int_equal(merge_files(order, 7, "merged.exr", &merged), STILB_OK);
	assert_int_equal(hash_of("merged.exr"), whole_hash(&settings, "whole.exr"));
	folder_clear();
}

/* ---- stopped and continued --------------------------------------------------------------------------------------- */

static bool stop_soon(void *user, const stilb_gi_progress *progress)
{
	(void)progress;
	return --*(int *)user > 0;
}

/* A share that is stopped again and again, as if each time by another process. */
static void a_share_resumes(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 200;
	settings.depth = 2;
	uint32_t stops = 0;
	uint64_t checkpoint = 0;
	make_part(&settings, 2, 3, "whole.part");
	for (bool finished = false; !finished;) {
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_farm_share(render, 2, 3), STILB_OK);
		if (stops > 0)
			assert_int_equal(stilb_gi_render_resume(render, "checkpoint"), STILB_OK);
		double before = progress_of(render).done;
		int looks = 2;
		stilb_gi_render_watch(render, stop_soon, &looks);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		finished = progress_of(render).finished;
		assert_true(progress_of(render).done > before || finished);
		assert_int_equal(stilb_gi_render_checkpoint(render, "checkpoint"), STILB_OK);
		checkpoint = hash_of("checkpoint");
		stops += !finished;
		if (finished)
			assert_int_equal(stilb_gi_farm_save_part(render, "stopped.part"), STILB_OK);
		stilb_gi_render_destroy(render);
	}
	assert_true(stops > 0 && checkpoint != 0);
	make_part(&settings, 1, 3, "1.part");
	make_part(&settings, 3, 3, "3.part");
	stilb_gi_farm_merged merged;
	const char *parts[] = {"1.part", "whole.part", "3.part"};
	assert_int_equal(merge_files(parts, 3, "a.exr", &merged), STILB_OK);
	parts[1] = "stopped.part";
	assert_int_equal(merge_files(parts, 3, "b.exr", &merged), STILB_OK);
	assert_int_equal(hash_of("a.exr"), hash_of("b.exr"));
	/* The checkpoint is of that share alone. */
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_resume(render, "checkpoint"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "it is of part 2/3"));
	assert_int_equal(stilb_gi_farm_share(render, 1, 3), STILB_OK);
	assert_int_equal(stilb_gi_render_resume(render, "checkpoint"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "it is of part 2/3"));
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
	folder_clear();
}

/* ---- what goes wrong --------------------------------------------------------------------------------------------- */

static void foreign_parts(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture), other = settings;
	render_fixture_finish(&fixture);
	other.exposure = 1.0f; /* the picture's file would be another, though its samples are not */
	make_part(&settings, 1, 2, "1.part");
	make_part(&settings, 2, 2, "2.part");
	make_part(&other, 2, 2, "bright.part");
	other = settings;
	other.samples++;
	make_part(&other, 2, 2, "more.part");
	stilb_gi_farm_merged merged;
	const struct {
		const char *part, *said;
	} cases[] = {{"bright.part", "'bright.part' does not belong to '1.part': its exposure is 1, not 0"},
	             {"more.part", "'more.part' does not belong to '1.part': its samples is 7, not 6"},
	             {"1.part", "hold the same units"},
	             {"none.part", "none.part"}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const char *parts[] = {"1.part", cases[i].part};
		assert_int_not_equal(merge_files(parts, 2, "a.exr", &merged), STILB_OK);
		if (!strstr(stilb_error_message(), cases[i].said))
			fail_msg("'%s', not '%s'", stilb_error_message(), cases[i].said);
		assert_int_equal(access("a.exr", F_OK), -1);
	}
	const char *good[] = {"2.part", "1.part"};
	assert_int_equal(merge_files(good, 1, "a.exr", &merged), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "1 of 2 parts is missing: 1/2"));
	assert_int_equal(merge_files(good, 2, "no/such/a.exr", &merged), STILB_ERROR_ARGUMENT);
	folder_clear();
}

static void what_no_share_can_do(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	for (int i = 0; i < 3; i++) {
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.seconds = i == 0 ? 1.0 : 0.0;
		settings.error = i == 1 ? 0.1f : 0.0f;
		settings.integrator = i == 2 ? STILB_GI_INTEGRATOR_IRRADIANCE_CACHE : STILB_GI_INTEGRATOR_PATH;
		settings.cache.mode = i == 2 ? STILB_GI_CACHE_LIVE : STILB_GI_CACHE_FROZEN;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_farm_share(render, 1, 2), STILB_ERROR_ARGUMENT);
		stilb_gi_render_destroy(render);
	}
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(units_cover_and_spread), cmocka_unit_test(same_bits),
		cmocka_unit_test(more_parts_than_units),  cmocka_unit_test(a_share_resumes),
		cmocka_unit_test(foreign_parts),          cmocka_unit_test(what_no_share_can_do),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
