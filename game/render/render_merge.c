#include "render_merge.h"

#include "base/base_file.h"
#include "game/cli/flags.h"
#include "gi/gi_farm.h"
#include "image/image.h"
#include "jobs/job.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool offline_merge_is_asked(int argc, char **argv)
{
	bool asked = false;
	for (int i = 0; i < argc; i++) {
		if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
			return false; /* the help of `stilb render` tells of it */
		asked |= strcmp(argv[i], "--merge") == 0;
	}
	return asked;
}

static bool merge_check(const flag_words *parts, const char *output)
{
	if (parts->count == 0)
		stilb_log("--merge: no parts; give all of them: stilb render --merge *.part -o FILE");
	else if (!output)
		stilb_log("--merge: no output; give -o FILE.exr or -o FILE.png");
	else if (stilb_image_path_check(output) != STILB_OK)
		stilb_log("%s", stilb_error_message());
	else
		return true;
	return false;
}

/* Refuses an output that is one of the parts. */
static bool merge_outputs_differ(const flag_words *parts, const char *output)
{
	for (uint32_t i = 0; i < parts->count; i++)
		if (stilb_file_same(parts->words[i], output)) {
			stilb_log("the output would replace '%s'; give it another name", output);
			return false;
		}
	return true;
}

static int merge_run(const flag_words *parts, const char *output)
{
	stilb_gi_farm_merged merged;
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	int error = stilb_job_pool_create(&desc, &pool);
	if (error != 0) {
		stilb_fail_threads(desc.worker_count, -error);
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	stilb_result result = stilb_gi_farm_merge(parts->words, parts->count, output, pool, &merged);
	stilb_job_pool_destroy(pool);
	if (result != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return exit_code_of(result);
	}
	FILE *out = stilb_file_is_stdout(output) ? stderr : stdout;
	fprintf(out, "%" PRIu32 " part%s, %" PRIu32 "x%" PRIu32 ", %" PRIu32 " sample%s a pixel, %.3g rays in %.2f s\n",
	        parts->count, parts->count == 1 ? "" : "s", merged.width, merged.height, merged.samples,
	        merged.samples == 1 ? "" : "s", (double)merged.rays, merged.seconds);
	fprintf(out, "picture: %s\n", output);
	return EXIT_DONE;
}

int offline_merge(int argc, char **argv)
{
	bool merge = false;
	const char *output = NULL;
	flag_words parts = {.words = calloc((size_t)argc, sizeof *parts.words)};
	if (!parts.words) {
		stilb_log("no memory for the names of parts");
		return EXIT_FAILED;
	}
	flag flags[] = {
		{"parts", FLAG_WORDS, &parts, NULL, NULL, 0, 0, NULL},
		{"--merge", FLAG_SWITCH, &merge, NULL, "", 0, 0, NULL},
		{"-o", FLAG_TEXT, &output, "FILE", "the picture", 0, 0, NULL},
	};
	int code = EXIT_REFUSED;
	if (flags_parse(flags, sizeof flags / sizeof *flags, argc, argv) == FLAGS_OK && merge_check(&parts, output) &&
	    merge_outputs_differ(&parts, output))
		code = merge_run(&parts, output);
	free(parts.words);
	return code;
}
