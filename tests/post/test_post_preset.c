/* Presets: every member comes where it belongs, and what is wrong is told by its name, its line and its file. */
#include "post/post_preset.h"
#include "shading/shade_tonemap.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

static void file_write(const char *name, const char *text, char path[128])
{
	snprintf(path, 128, "%s/%s", folder, name);
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	assert_int_equal(fputs(text, file) >= 0, 1);
	assert_int_equal(fclose(file), 0);
}

static int folder_make(void **state)
{
	(void)state;
	snprintf(folder, sizeof folder, "/tmp/test_post_preset.XXXXXX");
	return mkdtemp(folder) ? 0 : 1;
}

static int folder_remove(void **state)
{
	(void)state;
	static const char *const names[] = {"warm.cube", "cold.cube", "bad.cube", "p.json", "q.json", "in/q.json"};
	char path[128];
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		snprintf(path, sizeof path, "%s/%s", folder, names[i]);
		unlink(path);
	}
	snprintf(path, sizeof path, "%s/in", folder);
	rmdir(path);
	return rmdir(folder);
}

static void members_come_where_they_belong(void **state)
{
	(void)state;
	char path[128], table[128];
	stilb_post_preset *p;
	file_write("warm.cube", "LUT_1D_SIZE 2\n0.1 0 0\n1 1 0.9\n", table);
	file_write("cold.cube", "LUT_1D_SIZE 3\n0 0 0.1\n.5 .5 .5\n0.9 1 1\n", table);
	file_write("p.json",
	           "{\"exposure\": \"adapt\", \"exposure_percentiles\": [0.25, 0.5], \"exposure_speed\": 1.5,\n"
	           "\"exposure_rate\": 3, \"exposure_range\": [-2, 5], \"ao\": 0.5, \"ao_radius\": 7,\n"
	           "\"bloom\": 0.0625, \"bloom_width\": 0.75, \"bloom_format\": \"fixed\", \"post\": \"gpu\",\n"
	           "\"tone\": \"piecewise\", \"grade\": \"warm.cube\", \"dither\": \"triangular\",\n"
	           "\"areas\": [{\"low\": [-1, -2, -3], \"high\": [1, 2, 3], \"blend\": 0.5, \"exposure\": -1.5,\n"
	           "\"grade\": \"cold.cube\"}, {\"low\": [4, 5, 6], \"high\": [7, 8, 9]}]}\n",
	           path);
	if (stilb_post_preset_open(path, &p) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const stilb_post_settings *s = &p->settings;
	assert_true(s->exposure_adapts && p->has_exposure && p->exposure == 0.0f);
	assert_true(s->exposure_low == 0.25f && s->exposure_high == 0.5f && s->exposure_speed == 1.5f);
	assert_true(s->exposure_rate == 3.0f && s->exposure_darkest == -2.0f && s->exposure_brightest == 5.0f);
	assert_true(s->occlusion == 0.5f && s->occlusion_radius == 7.0f);
	assert_true(s->bloom == 0.0625f && s->bloom_width == 0.75f && s->bloom_format == STILB_POST_BLOOM_FIXED);
	assert_true(s->place == STILB_POST_PLACE_GPU && s->dither == STILB_POST_DITHER_TRIANGULAR);
	assert_true(p->has_tone && p->tone == SHADE_TONE_PIECEWISE);
	assert_true(p->grade && p->grade->size == 2 && p->area_count == 2);
	assert_true(p->areas[0].low[1] == -2.0f && p->areas[0].high[2] == 3.0f && p->areas[0].blend == 0.5f);
	assert_true(p->areas[0].exposure == -1.5f && p->areas[0].table && p->areas[0].table->size == 3);
	assert_true(p->areas[1].low[0] == 4.0f && p->areas[1].blend == 1.0f && p->areas[1].exposure == 0.0f);
	assert_null(p->areas[1].table);
	assert_true(stilb_post_settings_are_valid(s));
	stilb_post_preset_destroy(p);
	file_write("p.json", "{}", path);
	assert_int_equal(stilb_post_preset_open(path, &p), STILB_OK);
	stilb_post_settings none = {0};
	assert_memory_equal(&p->settings, &none, sizeof none);
	assert_false(p->has_exposure || p->has_tone || p->grade || p->area_count > 0);
	stilb_post_preset_destroy(p);
	file_write("p.json", "{\"exposure\": -2.5}", path);
	assert_int_equal(stilb_post_preset_open(path, &p), STILB_OK);
	assert_true(p->has_exposure && p->exposure == -2.5f && !p->settings.exposure_adapts);
	stilb_post_preset_destroy(p);
	stilb_post_preset_destroy(NULL);
}

static void mistakes_are_named(void **state)
{
	(void)state;
	static const struct {
		const char *text, *words;
	} cases[] = {
		{"", "line 1"},
		{"[1]", "a preset is no object"},
		{"{\"bloom\": 0.1,\n\"blom\": 1}", "line 2, column 2: 'blom' is no member of a preset"},
		{"{\"bloom\": 0.1,\n\"bloom\": 0.1}", "line 2, column 2: 'bloom' was there before"},
		{"{\"bloom\": 2}", "'bloom' is no number from 0 to 1"},
		{"{\"bloom\": \"much\"}", "'bloom' is no number from 0 to 1"},
		{"{\"bloom_format\": \"double\"}", "'bloom_format' is none of half, fixed"},
		{"{\"tone\": 3}", "'tone' is none of knee, none, neutral, filmic, luminance, piecewise, hable"},
		{"{\"exposure\": \"auto\"}", "'exposure' is neither \"adapt\" nor a number of stops"},
		{"{\"exposure\": 33}", "'exposure' is no number from -32 to 32"},
		{"{\"exposure_percentiles\": [0.5]}", "'exposure_percentiles'"},
		{"{\"exposure_percentiles\": [0.5, 0.5]}", "'exposure_percentiles' is not a lower and a higher number"},
		{"{\"exposure_range\": [-33, 0]}", "'exposure_range' is not 2 numbers from -32 to 32"},
		{"{\"grade\": \"none.cube\"}", "none.cube"},
		{"{\"grade\": \"bad.cube\"}", "bad.cube: line 2: a colour is three finite numbers"},
		{"{\"grade\": 1}", "line 1"},
		{"{\"areas\": {}}", "line 1"},
		{"{\"areas\": [1]}", "an area is no object"},
		{"{\"areas\": [{\"low\": [0, 0, 0]}]}", "the area's 'low' is not below its 'high'"},
		{"{\"areas\": [{\"low\": [0, 0, 0], \"high\": [1, 1, 0]}]}", "the area's 'low' is not below its 'high'"},
		{"{\"areas\": [{\"low\": [0, 0], \"high\": [1, 1, 1]}]}", "line 1"},
		{"{\"areas\": [{\"hue\": 1}]}", "'hue' is no member of an area: low, high, blend, exposure, grade"},
		{"{\"areas\": [{\"blend\": -1}]}", "'blend' is no number from 0 to"},
	};
	char path[128], table[128];
	stilb_post_preset *p;
	file_write("bad.cube", "LUT_1D_SIZE 2\n0 0\n", table);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		file_write("p.json", cases[i].text, path);
		assert_int_equal(stilb_post_preset_open(path, &p), STILB_ERROR_FILE);
		assert_null(p);
		if (strncmp(stilb_error_message(), path, strlen(path)) != 0 || !strstr(stilb_error_message(), cases[i].words))
			fail_msg("case %zu: '%s' instead of '%s'", i, stilb_error_message(), cases[i].words);
	}
	assert_int_equal(stilb_post_preset_open("no such file.json", &p), STILB_ERROR_FILE);
	static char many[8192] = "{\"areas\": [";
	for (int i = 0; i <= (int)STILB_POST_MAX_AREAS; i++)
		strcat(many, i > 0 ? ",{\"low\":[0,0,0],\"high\":[1,1,1]}" : "{\"low\":[0,0,0],\"high\":[1,1,1]}");
	strcat(many, "]}");
	file_write("p.json", many, path);
	assert_int_equal(stilb_post_preset_open(path, &p), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "there are more than 64 areas"));
}

static void is_same(const stilb_post_preset *a, const stilb_post_preset *b)
{
	assert_memory_equal(&a->settings, &b->settings, sizeof a->settings);
	assert_true(a->has_exposure == b->has_exposure && a->exposure == b->exposure);
	assert_true(a->has_tone == b->has_tone && a->tone == b->tone && a->area_count == b->area_count);
	assert_true((bool)a->grade == (bool)b->grade);
	for (uint32_t i = 0; i < a->area_count; i++) {
		const stilb_post_area *x = &a->areas[i], *y = &b->areas[i];
		assert_memory_equal(x->low, y->low, sizeof x->low);
		assert_memory_equal(x->high, y->high, sizeof x->high);
		assert_true(x->blend == y->blend && x->exposure == y->exposure && (bool)x->table == (bool)y->table);
		assert_true(!x->table || x->table->size == y->table->size);
	}
}

static void file_holds(const char *path, const char *words, bool holds)
{
	char text[4096] = "";
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	text[fread(text, 1, sizeof text - 1, file)] = '\0';
	fclose(file);
	if ((bool)strstr(text, words) != holds)
		fail_msg("'%s' in %s", words, text);
}

/* What is saved is read as what it was: all members, none, and tables that lie elsewhere. */
static void saved_is_read_again(void **state)
{
	(void)state;
	static const char *const texts[] = {
		"{\"exposure\": \"adapt\", \"exposure_percentiles\": [0, 0.5], \"exposure_speed\": 1.5, \"exposure_rate\": 3,"
		"\"exposure_range\": [-2, 5.1], \"ao\": 0.1, \"ao_radius\": 7, \"bloom\": 0.07, \"bloom_width\": 0.75,"
		"\"bloom_format\": \"fixed\", \"post\": \"gpu\", \"aa\": \"temporal\", \"motion_blur\": 0.3,"
		"\"motion_blur_most\": 0.2, \"motion_blur_of\": \"far\", \"motion_blur_far\": 12.5,"
		"\"reflections\": \"crude\", \"dof\": \"lerp\", \"aperture\": 0.01, \"focus\": 3.3,"
		"\"blades\": 6, \"tone\": \"piecewise\", \"grade\": \"warm.cube\", \"dither\": \"triangular\","
		"\"areas\": [{\"low\": [-1, -2, -3], \"high\": [1, 2.2, 3], \"blend\": 0, \"exposure\": -1.5,"
		"\"grade\": \"cold.cube\"}, {\"low\": [4, 5, 6], \"high\": [7, 8, 9]}]}",
		"{\"exposure\": -1.25}", "{}"};
	char path[128], table[128], again[128];
	file_write("warm.cube", "LUT_1D_SIZE 2\n0.1 0 0\n1 1 0.9\n", table);
	file_write("cold.cube", "LUT_1D_SIZE 3\n0 0 0.1\n.5 .5 .5\n0.9 1 1\n", table);
	snprintf(again, sizeof again, "%s/in", folder);
	assert_int_equal(mkdir(again, 0700), 0);
	for (size_t i = 0; i < 2 * sizeof texts / sizeof *texts; i++) {
		stilb_post_preset *p, *q = NULL;
		file_write("p.json", texts[i / 2], path);
		snprintf(again, sizeof again, "%s/%sq.json", folder, i % 2 ? "in/" : "");
		assert_int_equal(stilb_post_preset_open(path, &p), STILB_OK);
		if (stilb_post_preset_save(p, again) != STILB_OK || stilb_post_preset_open(again, &q) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		is_same(p, q);
		if (i < 2)
			file_holds(again, "\"warm.cube\"", i == 0); /* beside it, else by its whole path */
		else
			file_holds(again, "bloom", false);
		free(p->grade_file);
		p->grade_file = NULL;
		if (p->grade) {
			assert_int_equal(stilb_post_preset_save(p, again), STILB_ERROR_ARGUMENT);
			assert_non_null(strstr(stilb_error_message(), "has no file"));
		}
		stilb_post_preset_destroy(p);
		stilb_post_preset_destroy(q);
	}
}

/* Bytes that change and end early: a preset or a message, and nothing else. */
static void damaged_files_are_answered(void **state)
{
	(void)state;
	static const char good[] = "{\"exposure\": 1, \"bloom\": 0.5, \"tone\": \"knee\", \"exposure_range\": [1, 2],"
							   " \"areas\": [{\"low\": [0, 0, 0], \"high\": [1, 1, 1]}]}";
	char path[128];
	uint32_t presets = 0;
	for (uint64_t i = 0; i < 300; i++) {
		char text[sizeof good];
		memcpy(text, good, sizeof good);
		text[stilb_random_u64(5, 3 * i) % (sizeof good - 1)] = good[stilb_random_u64(5, 3 * i + 1) % (sizeof good - 1)];
		if (i % 4 == 0)
			text[stilb_random_u64(5, 3 * i + 2) % (sizeof good - 1)] = '\0';
		file_write("p.json", text, path);
		stilb_post_preset *p;
		stilb_result result = stilb_post_preset_open(path, &p);
		assert_true((result == STILB_OK) == (bool)p);
		presets += (bool)p;
		stilb_post_preset_destroy(p);
	}
	print_message("%u of 300 are presets all the same\n", presets);
	assert_true(presets > 5 && presets < 290);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(members_come_where_they_belong),
		cmocka_unit_test(mistakes_are_named),
		cmocka_unit_test(saved_is_read_again),
		cmocka_unit_test(damaged_files_are_answered),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
