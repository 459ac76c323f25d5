/* Pictures through the irradiance cache: the same bits for every number of workers, live as good as frozen, files. */
#include "gi_render_fixture.h"
#include "support/folder.h"

#include "gi/cache/gi_cache_fill.h"

#include <math.h>

static const char path[] = "a.cache";

static int tear_down(void **state)
{
	(void)state;
	remove(path);
	return folder_remove();
}

static stilb_gi_settings cached(const render_fixture *fixture)
{
	stilb_gi_settings settings = render_fixture_settings(fixture);
	settings.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	settings.width = 19;
	settings.height = 17;
	settings.samples = 2;
	settings.depth = 64;
	settings.cache.rays = 32;
	return settings;
}

/* ---- bits -------------------------------------------------------------------------------------------------------- */

static void frozen_has_the_same_bits_for_every_worker_count(void **state)
{
	(void)state;
	for (int radius = STILB_GI_CACHE_SPLIT_SPHERE; radius <= STILB_GI_CACHE_HARMONIC; radius++) {
		static const uint32_t workers[] = {0, 6, 1, 2};
		uint64_t first = 0;
		for (int w = 0; w < (TEST_TSAN ? 2 : 4); w++) {
			render_fixture fixture = render_fixture_make("cornell", workers[w]);
			stilb_gi_settings settings = cached(&fixture);
			settings.cache.radius = (stilb_gi_cache_radius)radius;
			uint64_t hash = render_whole(&fixture, &settings);
			if (w == 0)
				first = hash;
			assert_true(hash == first);
			render_fixture_finish(&fixture);
		}
	}
}

typedef struct overture {
	gi_view view;
	gi_cache_fill *fill;
	uint32_t reports, stop_after;
} overture;

static overture overture_make(const render_fixture *fixture, const stilb_gi_settings *settings)
{
	overture o = {.view = {.scene = fixture->gi, .settings = *settings}, .stop_after = UINT32_MAX};
	o.view.sampler = gi_sampler_make(settings->sampler, settings->seed, settings->samples);
	return o;
}

static bool report(void *user, const gi_cache_progress *progress)
{
	overture *o = user;
	assert_true(progress->done >= 0.0 && progress->done <= 1.0);
	return ++o->reports % o->stop_after != 0;
}

/* A hash of the saved file's bytes, which are the records' values in their order. */
static uint64_t file_hash(void)
{
	static char bytes[1 << 20];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	assert_in_range(size, 1, sizeof bytes - 1);
	return stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size);
}

static void stopped_overture_ends_with_the_same_records(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = cached(&fixture);
	settings.cache.save = path;
	uint64_t hashes[2];
	for (uint32_t stops = 0; stops < 2; stops++) {
		overture o = overture_make(&fixture, &settings);
		if (stops)
			o.stop_after = 1;
		assert_int_equal(gi_cache_fill_create(&o.view, fixture.pool, &o.fill), STILB_OK);
		uint32_t calls = 0;
		do
			assert_int_equal(gi_cache_fill_run(o.fill, report, &o), STILB_OK);
		while (++calls < 1000 && gi_cache_fill_progress(o.fill).done < 1.0);
		assert_true(stops ? calls > 3 : calls == 1);
		assert_int_equal(gi_cache_fill_save(o.fill), STILB_OK);
		hashes[stops] = file_hash();
		gi_cache_fill_destroy(o.fill);
	}
	assert_true(hashes[0] == hashes[1]);
	render_fixture_finish(&fixture);
}

/* Light is reflected at most twice: at the record, and where the ray through a cell of its hemisphere hits. So a cell
 * has that ray, and at its hit a shadow ray and one that may find a light; each record is gathered once. */
static void records_are_gathered_once(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = cached(&fixture);
	settings.depth = 2;
	overture o = overture_make(&fixture, &settings);
	assert_int_equal(gi_cache_fill_create(&o.view, fixture.pool, &o.fill), STILB_OK);
	assert_int_equal(gi_cache_fill_run(o.fill, NULL, NULL), STILB_OK);
	gi_cache_progress progress = gi_cache_fill_progress(o.fill);
	uint32_t cells = gi_cache_strata_cells(&gi_cache_fill_records(o.fill)->strata);
	assert_true(progress.records > 10);
	assert_in_range(progress.shadow_rays, 1, progress.records * cells);
	assert_in_range(progress.rays - progress.shadow_rays, progress.records * cells, progress.records * cells * 2);
	gi_cache_fill_destroy(o.fill);
	render_fixture_finish(&fixture);
}

/* ---- live -------------------------------------------------------------------------------------------------------- */

static double mean_of(const render_fixture *fixture, const stilb_gi_settings *settings, uint32_t *records)
{
	stilb_gi_render *render = render_fixture_create(fixture, settings);
	if (stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	if (records)
		*records = progress_of(render).records;
	stilb_gi_film film = stilb_gi_render_film(render);
	double sum = 0.0;
	size_t numbers = (size_t)film.width * film.height * 3;
	for (size_t i = 0; i < numbers; i++)
		sum += (double)film.radiance[i];
	stilb_gi_render_destroy(render);
	return sum / (double)numbers;
}

/* Pictures of a LIVE cache with an overture and without, on several threads, are as bright as that of a FROZEN one,
 * within the noise of few rays. */
static void live_is_as_bright_as_frozen(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 3);
	stilb_gi_settings settings = cached(&fixture);
	settings.only = STILB_GI_ONLY_INDIRECT;
	uint32_t records[3];
	double frozen = mean_of(&fixture, &settings, &records[0]);
	settings.cache.mode = STILB_GI_CACHE_LIVE;
	double live = mean_of(&fixture, &settings, &records[1]);
	settings.cache.overture = false;
	double blocky = mean_of(&fixture, &settings, &records[2]);
	assert_true(frozen > 0.0 && fabs(live / frozen - 1.0) < 0.2 && fabs(blocky / frozen - 1.0) < 0.2);
	for (int i = 0; i < 3; i++)
		assert_in_range(records[i], 10, 2000);
	render_fixture_finish(&fixture);
}

static void final_pass_adds_no_record(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = cached(&fixture);
	overture o = overture_make(&fixture, &settings);
	assert_int_equal(gi_cache_fill_create(&o.view, fixture.pool, &o.fill), STILB_OK);
	assert_int_equal(gi_cache_fill_run(o.fill, NULL, NULL), STILB_OK);
	uint32_t after_overture = gi_cache_fill_progress(o.fill).records, after_picture;
	gi_cache_fill_destroy(o.fill);
	settings.samples = 8;
	mean_of(&fixture, &settings, &after_picture);
	assert_true(after_overture > 10);
	assert_int_equal(after_overture, after_picture);
	render_fixture_finish(&fixture);
}

/* A furnace's irradiance is the same everywhere, so interpolation has no error. */
static void furnace_stays_even(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("furnace:0.5", 0);
	stilb_gi_settings settings = cached(&fixture);
	settings.width = settings.height = 6;
	settings.cache.rays = 64;
	double radiance = mean_of(&fixture, &settings, NULL);
	if (!(fabs(radiance - 2.0) < 0.06))
		fail_msg("radiance %.4f, not 2", radiance);
	render_fixture_finish(&fixture);
}

static void records_are_shown_in_red(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = cached(&fixture);
	settings.cache.show_records = true;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	stilb_gi_film film = stilb_gi_render_film(render);
	uint32_t red = 0;
	for (size_t i = 0; i < (size_t)film.width * film.height; i++)
		red += film.radiance[3 * i] >= 1.0f && film.radiance[3 * i + 1] <= 0.02f;
	assert_true(red >= 5 && red < film.width * film.height / 2);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void loaded_cache_gives_the_same_bits(void **state)
{
	(void)state;
	for (int radius = STILB_GI_CACHE_SPLIT_SPHERE; radius <= STILB_GI_CACHE_HARMONIC; radius++) {
		render_fixture fixture = render_fixture_make("cornell", 1);
		stilb_gi_settings settings = cached(&fixture);
		settings.cache.radius = (stilb_gi_cache_radius)radius;
		settings.cache.save = path;
		uint64_t made = render_whole(&fixture, &settings);
		settings.cache.save = NULL;
		settings.cache.load = path;
		assert_true(render_whole(&fixture, &settings) == made);
		settings.cache.overture = false; /* nothing was missing */
		assert_true(render_whole(&fixture, &settings) == made);
		render_fixture_finish(&fixture);
	}
}

static void expect_refused(const render_fixture *fixture, const stilb_gi_settings *settings, const char *why)
{
	stilb_gi_render *render;
	assert_int_equal(stilb_gi_render_create(fixture->gi, settings, fixture->pool, &render), STILB_ERROR_FILE);
	if (!strstr(stilb_error_message(), why) || !strstr(stilb_error_message(), path))
		fail_msg("\"%s\" does not say \"%s\" of %s", stilb_error_message(), why, path);
	assert_null(render);
}

static void file_change(long offset, bool truncate_there)
{
	FILE *file = fopen(path, "r+b");
	assert_non_null(file);
	fseek(file, offset, offset < 0 ? SEEK_END : SEEK_SET);
	if (truncate_there) {
		assert_int_equal(ftruncate(fileno(file), ftell(file)), 0);
	} else {
		int byte = fgetc(file);
		fseek(file, -1, SEEK_CUR);
		fputc(byte ^ 1, file);
	}
	assert_int_equal(fclose(file), 0);
}

static void foreign_and_damaged_files_are_refused(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0), other = render_fixture_make("plane-wall", 0);
	stilb_gi_settings settings = cached(&fixture), changed;
	settings.cache.save = path;
	render_whole(&fixture, &settings);
	settings.cache.save = NULL;
	settings.cache.load = path;
	changed = cached(&other);
	changed.cache.load = path;
	expect_refused(&other, &changed, "another scene");
	changed = settings;
	changed.depth = 3;
	expect_refused(&fixture, &changed, "another depth");
	changed = settings;
	changed.cache.error = 0.25f;
	expect_refused(&fixture, &changed, "another error");
	changed = settings;
	changed.cache.radius = STILB_GI_CACHE_SPLIT_SPHERE;
	expect_refused(&fixture, &changed, "kind of radius");
	changed = settings;
	changed.cache.gradients = false;
	expect_refused(&fixture, &changed, "with gradients");
	file_change(-100, false);
	expect_refused(&fixture, &settings, "damaged");
	file_change(-1, true);
	expect_refused(&fixture, &settings, "cut short");
	file_change(40, true);
	expect_refused(&fixture, &settings, "cut short");
	file_change(3, false);
	expect_refused(&fixture, &settings, "not an irradiance cache");
	remove(path);
	expect_refused(&fixture, &settings, "No such file");
	render_fixture_finish(&fixture);
	render_fixture_finish(&other);
}

static void settings_are_checked(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("plane-wall", 0);
	stilb_gi_settings settings = cached(&fixture);
	settings.cache.overture = false;
	overture o = overture_make(&fixture, &settings);
	assert_int_equal(gi_cache_fill_create(&o.view, fixture.pool, &o.fill), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "live"));
	assert_null(o.fill);
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(frozen_has_the_same_bits_for_every_worker_count),
		test_one_thread(stopped_overture_ends_with_the_same_records),
		cmocka_unit_test(records_are_gathered_once),
		cmocka_unit_test(live_is_as_bright_as_frozen),
		cmocka_unit_test(final_pass_adds_no_record),
		test_one_thread(furnace_stays_even),
		test_one_thread(records_are_shown_in_red),
		cmocka_unit_test(loaded_cache_gives_the_same_bits),
		test_one_thread(foreign_and_damaged_files_are_refused),
		cmocka_unit_test(settings_are_checked),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
