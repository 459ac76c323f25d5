/* stilb shade spheres: saves a strip, which is rows of spheres with captions (shade_strip.h), as a picture. */
#include "shade.h"

#include "base/base_file.h"
#include "shade_strip.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct spheres_options {
	const char *output;
	int strip;
	uint32_t size[2]; /* of the picture; {0, 0}: the size in which spheres are 100 pixels wide */
	uint32_t workers;
} spheres_options;

#define MAX_STRIPS 32

static flags_result spheres_parse(spheres_options *o, int argc, char **argv)
{
	const char *names[MAX_STRIPS + 1] = {NULL};
	for (int i = 0; i < strip_count && i < MAX_STRIPS; i++)
		names[i] = strips[i].name;
	const flag flags[] = {
		{"-o", FLAG_TEXT, &o->output, "FILE", "the picture: .png, or .exr or .hdr with radiance, not tone mapped", 0, 0,
	     NULL},
		{"--strip", FLAG_CHOICE, &o->strip, "NAME", "rows of spheres to draw, see below (classic)", 0, 0, names},
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size, 1x1..16384x16384 (spheres of 100 pixels)", 1, 16384, NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads beside the main one, 0..256 or auto (CPUs - 1)", 0,
	     STILB_JOB_MAX_WORKERS, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf("stilb shade spheres -o FILE [FLAGS]: draws rows of spheres, every pixel by the functions of\n"
		       "engine/shading.\n\n");
		flags_print(flags, count);
		printf("\nStrips:\n");
		for (int i = 0; i < strip_count; i++)
			printf("  %-14s %s\n", strips[i].name, strips[i].title);
	}
	return result;
}

static stilb_result spheres_draw(const strip *s, const uint32_t asked[2], const char *path, stilb_job_pool *pool)
{
	uint32_t size[2] = {asked[0], asked[1]};
	if (size[0] == 0)
		strip_size(s, 100.0f, size);
	stilb_image picture;
	stilb_result result = stilb_image_create(&picture, size[0], size[1], 3, STILB_IMAGE_F32_LINEAR);
	if (result == STILB_OK)
		result = strip_draw(s, &picture, !stilb_image_path_is_light(path), pool);
	if (result == STILB_OK)
		result = stilb_image_save(&picture, path);
	stilb_image_finish(&picture);
	return result;
}

stilb_result strip_save(const strip *s, const uint32_t size[2], uint32_t workers, const char *path)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	if (workers != FLAG_WORKERS_AUTO)
		desc.worker_count = workers;
	int error = stilb_job_pool_create(&desc, &pool);
	if (error)
		return stilb_fail_threads(desc.worker_count, -error);
	stilb_result result = spheres_draw(s, size, path, pool);
	stilb_job_pool_destroy(pool);
	return result;
}

int shade_spheres_command(int argc, char **argv)
{
	spheres_options options = {.workers = FLAG_WORKERS_AUTO};
	flags_result parsed = spheres_parse(&options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (!options.output) {
		stilb_log("shade spheres: no output; give -o FILE.png");
		return EXIT_REFUSED;
	}
	if (stilb_image_path_check(options.output) != STILB_OK)
		return shade_complain(EXIT_REFUSED);
	if (strip_save(&strips[options.strip], options.size, options.workers, options.output) != STILB_OK)
		return shade_complain(EXIT_FAILED);
	fprintf(stilb_file_is_stdout(options.output) ? stderr : stdout, "picture: %s\n", options.output);
	return EXIT_DONE;
}
