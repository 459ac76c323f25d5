/* The text on a render's progress: its number of samples is never 0 once there is a coarse picture. */
#include "game/render/render_progress.h"
#include "support/test.h"

#include <string.h>

static const char *said(const stilb_gi_progress *at)
{
	static char text[64];
	offline_progress_samples(at, text, sizeof text);
	return text;
}

static void test_samples_in_words(void **state)
{
	(void)state;
	stilb_gi_progress at = {.pass_count = 1, .passes = {{.block = 32, .sample_count = 16}}};
	assert_string_equal(said(&at), "the first pixels");
	at.passes[0].finished = true;
	at.block = 32;
	assert_string_equal(said(&at), "16 samples in 1 of 1024 pixels");
	at.passes[at.pass_count++] = (stilb_gi_pass){.block = 16, .sample_count = 16};
	assert_string_equal(said(&at), "16 samples in 1 of 1024 pixels");
	at.block = 2;
	at.passes[0].sample_count = 1;
	assert_string_equal(said(&at), "1 sample in 1 of 4 pixels");
	at.block = 1;
	at.samples = 1;
	assert_string_equal(said(&at), "1 sample a pixel");
	at.samples = 64;
	assert_string_equal(said(&at), "64 samples a pixel");
	at.passes[at.pass_count++] = (stilb_gi_pass){.block = 1, .first_sample = 64, .sample_count = 64};
	assert_string_equal(said(&at), "64 samples a pixel");
	at.pass_done = 0.429;
	assert_string_equal(said(&at), "64 samples a pixel, 128 in 42 % of them");
	at.passes[at.pass_count - 1].finished = true;
	at.samples = 128;
	assert_string_equal(said(&at), "128 samples a pixel");
	at = (stilb_gi_progress){.pass_count = 1, .passes = {{.block = 1, .sample_count = 200}}};
	assert_string_equal(said(&at), "the first pixels");
	at.pass_done = 0.07;
	assert_string_equal(said(&at), "200 samples in 7 % of the pixels");
}

static void test_a_line_of_progress(void **state)
{
	(void)state;
	stilb_gi_progress at = {.pass_count = 1,
	                        .passes = {{.block = 4, .sample_count = 16, .finished = true}},
	                        .block = 4,
	                        .stage = "pass 5",
	                        .done = 0.06};
	offline_progress progress = {0};
	char text[192];
	offline_progress_words(&progress, RENDER_RENDERING, &at, text, sizeof text);
	assert_non_null(strstr(text, "6 %, pass 5, 16 samples in 1 of 16 pixels, 0.00 Mrays/s, "));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_samples_in_words),
		cmocka_unit_test(test_a_line_of_progress),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
