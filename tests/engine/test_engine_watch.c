/* Shaders whose files change while frames are drawn: the picture changes with them, or stays if they are wrong, and the
 * message names file and line. On the device given by WATCH_DEVICE, Vulkan's under its validation layer, with a copy of
 * the sources. */
#include "engine_internal.h"
#include "image/image.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"
#include "watch/engine_watch.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#ifndef WATCH_DEVICE
#define WATCH_DEVICE STILB_RENDER_DEVICE_VULKAN
#endif

#define DRAWS (WATCH_DEVICE == STILB_RENDER_DEVICE_VULKAN)
#define SIDE 48u
#define WAIT_S 60.0 /* on a busy machine, under a sanitizer */
#define TONE "render/shaders/tone.frag"
#define LAST_LINE "color = vec4(shown * texel.a, texel.a); // premultiplied"

static char folder[PATH_MAX];
static char logged[16384];

static void take_log(void *user, const char *line)
{
	(void)user;
	size_t used = strlen(logged);
	snprintf(logged + used, sizeof logged - used, "%s\n", line);
}

static int set_up(void **state)
{
	(void)state;
	char command[2 * PATH_MAX];
	snprintf(folder, sizeof folder, "/tmp/stilb-watch-XXXXXX");
	if (!mkdtemp(folder))
		return -1;
	snprintf(command, sizeof command,
	         "cd '%s' && cp -r --parents render/shaders gpu/shaders shading base/glsl_types.h '%s'", SHADER_SOURCES,
	         folder);
	setenv("GALLIVM_PERF", "nopt", 0); /* Mesa's software device compiles shaders in half the time */
	stilb_log_set(take_log, NULL);
	return system(command);
}

static int tear_down(void **state)
{
	(void)state;
	char command[PATH_MAX + 16];
	snprintf(command, sizeof command, "rm -r '%s'", folder);
	stilb_log_set(NULL, NULL);
	return system(command);
}

static stilb_engine *make_engine(stilb_engine_watch watch, const char *shaders)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.width = desc.height = SIDE;
	desc.device = WATCH_DEVICE;
	desc.validate = DRAWS;
	desc.watch_shaders = watch;
	desc.shaders = shaders;
	logged[0] = '\0';
	if (stress_engine_create(&desc, &(stress_engine){.models = 50, .seed = 5}, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL); /* times of files may be a tick of the kernel old */
	return engine;
}

static void end_engine(stilb_engine *engine)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

static void draw(stilb_engine *engine)
{
	stilb_engine_report report;
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* The pixels of another frame. */
static stilb_image picture(stilb_engine *engine)
{
	stilb_image image = {0};
	draw(engine);
	if (DRAWS && stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* Draws frames until the log says this. */
static void wait_for(stilb_engine *engine, const char *text)
{
	uint64_t since = stilb_time_ns();
	while (!strstr(logged, text)) {
		draw(engine);
		nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
		if ((double)(stilb_time_ns() - since) * 1e-9 > WAIT_S)
			fail_msg("no '%s' in: %s", text, logged);
	}
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Reads a file of the copy; the caller frees it. */
static char *read_source(const char *name)
{
	char path[2 * PATH_MAX], *text = calloc(1, 65536);
	snprintf(path, sizeof path, "%s/%s", folder, name);
	FILE *file = fopen(path, "r");
	assert_true(text && file && fread(text, 1, 65535, file) > 0);
	fclose(file);
	return text;
}

/* Writes it as editors do: in place, or beside and renamed. */
static void write_source(const char *name, const char *text, bool renamed)
{
	char path[2 * PATH_MAX], beside[2 * PATH_MAX + 8];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	snprintf(beside, sizeof beside, "%s%s", path, renamed ? ".new" : "");
	FILE *file = fopen(beside, "w");
	assert_non_null(file);
	fputs(text, file);
	assert_int_equal(fclose(file), 0);
	if (renamed)
		assert_int_equal(rename(beside, path), 0);
}

static uint32_t edited_line; /* of what edit has changed */

/* Puts `to` in the place of `from`, and returns the text that was there before, which the caller frees. */
static char *edit(const char *name, const char *from, const char *to, bool renamed)
{
	char *before = read_source(name), *at = strstr(before, from), *after = NULL;
	assert_non_null(at);
	assert_true(asprintf(&after, "%.*s%s%s", (int)(at - before), before, to, at + strlen(from)) > 0);
	edited_line = 1;
	for (const char *c = before; c < at; c++)
		edited_line += *c == '\n';
	logged[0] = '\0';
	write_source(name, after, renamed);
	free(after);
	return before;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static bool same(const stilb_image *a, const stilb_image *b)
{
	return stilb_image_size(a) == stilb_image_size(b) && memcmp(a->pixels, b->pixels, stilb_image_size(a)) == 0;
}

/* Each channel of b is 1 less that of a, in linear light; within two codes. */
static void assert_inverted(const stilb_image *a, const stilb_image *b)
{
	const uint8_t *from = a->pixels, *to = b->pixels;
	uint32_t middle = 0;
	assert_int_equal(stilb_image_size(a), stilb_image_size(b));
	for (size_t i = 0; i < stilb_image_size(a); i++) {
		float light = 1.0f - shade_srgb_to_linear((float)from[i] / 255.0f);
		float step = 1.2f * fabsf(shade_srgb_to_linear(((float)from[i] + 1.0f) / 255.0f) + light - 1.0f);
		float low = 255.0f * shade_srgb_from_linear(fmaxf(light - step, 0.0f)) - 1.0f;
		float high = 255.0f * shade_srgb_from_linear(fminf(light + step, 1.0f)) + 1.0f;
		if ((float)to[i] < low || (float)to[i] > high)
			fail_msg("channel %zu: %u became %u, not %.1f..%.1f", i, from[i], to[i], (double)low, (double)high);
		middle += from[i] > 20 && from[i] < 200;
	}
	assert_true(middle > 100); /* not all black or white */
}

static void the_picture_follows(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_ENGINE_WATCH_ON, folder),
				 *plain = make_engine(STILB_ENGINE_WATCH_OFF, NULL);
	stilb_image first = picture(engine);
	char *before = edit(TONE, LAST_LINE, "color = vec4(vec3(texel.a) - shown * texel.a, texel.a);", false);
	wait_for(engine, TONE " compiled for 1 program in ");
	stilb_image inverted = picture(engine);
	if (DRAWS)
		assert_inverted(&first, &inverted);
	/* What is wrong is told with file and line, and the old shader stays. */
	char *good = edit(TONE, "void main()\n", "void main() nonsense\n", true);
	wait_for(engine, "syntax error");
	char wrong[128];
	snprintf(wrong, sizeof wrong, TONE ":%u: error", edited_line);
	assert_non_null(strstr(logged, wrong));
	stilb_image still = picture(engine);
	if (DRAWS)
		assert_true(same(&still, &inverted));
	/* With the next change it is compiled again, for it was not replaced. */
	free(edit("render/shaders/flat.frag", "void main()", "void main( )", false));
	wait_for(engine, wrong);
	assert_null(strstr(logged, "compiled for"));
	/* A program that is made later has the shader that took its own's place. */
	stilb_engine_scene(engine)->camera.tone = SHADE_TONE_FILMIC;
	stilb_engine_scene(plain)->camera.tone = SHADE_TONE_FILMIC;
	stilb_image other = picture(engine), filmic = picture(plain);
	if (DRAWS)
		assert_inverted(&filmic, &other);
	/* And back again. */
	stilb_engine_scene(engine)->camera.tone = SHADE_TONE_KNEE;
	logged[0] = '\0';
	write_source(TONE, before, true);
	wait_for(engine, "render/shaders/flat.frag, " TONE " compiled for ");
	logged[0] = '\0';
	write_source(TONE, before, false);
	wait_for(engine, " compiled for ");
	assert_memory_equal(logged, TONE " compiled for 2 programs in ", sizeof TONE " compiled for 2 programs in " - 1);
	stilb_image last = picture(engine);
	if (DRAWS)
		assert_true(same(&last, &first));
	stilb_image *all[] = {&first, &inverted, &still, &other, &filmic, &last};
	for (size_t i = 0; i < sizeof all / sizeof *all; i++)
		stilb_image_finish(all[i]);
	free(before);
	free(good);
	end_engine(engine);
	end_engine(plain);
}

/* A file that is included changes all that include it, also through another file; and is compiled again if the fault is
 * put right elsewhere. */
static void shared_files(void **state)
{
	(void)state;
	static const char luminance[] = "shading/shade_luminance.h", tonemap[] = "shading/shade_tonemap.h";
	stilb_engine *engine = make_engine(STILB_ENGINE_WATCH_ON, folder);
	stilb_image first = picture(engine);
	char *before = edit(tonemap, "	color = min(color, SHADE_TONEMAP_ABOVE_MAX);\n",
	                    "	if (tone >= 0)\n		return EXTRA(color);\n", true);
	wait_for(engine, "EXTRA");
	char wrong[128];
	snprintf(wrong, sizeof wrong, "render/shaders/../../%s:%u: error", tonemap, edited_line + 1);
	assert_non_null(strstr(logged, wrong));
	/* The same shaders, and no word of the others, from a second file: what failed is compiled with it. */
	logged[0] = '\0';
	char *other = edit(luminance, "#define SHADE_LUMINANCE_H\n",
	                   "#define SHADE_LUMINANCE_H\n#define EXTRA(c) (vec3(1.0f) - c)\n", false);
	wait_for(engine, " compiled for ");
	assert_non_null(strstr(logged, TONE));
	assert_non_null(strstr(logged, "render/shaders/flat.frag"));
	stilb_image second = picture(engine);
	if (DRAWS)
		assert_false(same(&first, &second));
	logged[0] = '\0';
	write_source(tonemap, before, false);
	wait_for(engine, " compiled for ");
	assert_null(strstr(logged, "mesh.vert"));
	stilb_image last = picture(engine);
	if (DRAWS)
		assert_true(same(&last, &first));
	write_source(luminance, other, false);
	stilb_image_finish(&first);
	stilb_image_finish(&second);
	stilb_image_finish(&last);
	free(before);
	free(other);
	end_engine(engine);
}

/* In a window with input, a panel shows the error until it is right. */
static void a_panel(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_ENGINE_WATCH_ON, folder);
	stilb_window_state input = {.width = 640, .height = 360};
	assert_int_equal(stilb_engine_input(engine, &input), STILB_OK);
	stilb_image without = picture(engine);
	char *before = edit(TONE, LAST_LINE, "colour = vec4(shown * texel.a, texel.a);", false);
	wait_for(engine, "error");
	assert_non_null(engine->overlay.shader_error);
	char wrong[128];
	snprintf(wrong, sizeof wrong, TONE ":%u: error: 'colour' : undeclared identifier", edited_line);
	assert_non_null(strstr(engine->overlay.shader_error, wrong));
	stilb_image with = picture(engine);
	if (DRAWS) {
		assert_false(same(&without, &with));
		if (getenv("WATCH_PICTURE"))
			assert_int_equal(stilb_image_save(&with, getenv("WATCH_PICTURE")), STILB_OK);
	}
	logged[0] = '\0';
	write_source(TONE, before, false);
	wait_for(engine, " compiled for ");
	assert_null(engine->overlay.shader_error);
	assert_int_equal(engine->overlay.toasts.count, 1);
	stilb_image_finish(&without);
	stilb_image_finish(&with);
	free(before);
	end_engine(engine);
}

/* The engine ends while glslc runs, here one that would for minutes. */
static void it_ends_at_once(void **state)
{
	(void)state;
	char *path = strdup(getenv("PATH")), *slow = NULL, command[2 * PATH_MAX];
	snprintf(command, sizeof command, "mkdir '%s/bin'", folder);
	assert_int_equal(system(command), 0);
	write_source("bin/glslc", "#!/bin/sh\necho started >&2\nexec sleep 1000\n", false);
	snprintf(command, sizeof command, "chmod +x '%s/bin/glslc'", folder);
	assert_int_equal(system(command), 0);
	assert_true(asprintf(&slow, "%s/bin:%s", folder, path) > 0);
	setenv("PATH", slow, 1);
	for (int round = 0; round < 3; round++) {
		stilb_engine *engine = make_engine(STILB_ENGINE_WATCH_ON, folder);
		draw(engine);
		draw(engine);
		free(edit("shading/shade_constants.h", "#define SHADE_PI", "#define SHADE_PI", false));
		nanosleep(&(struct timespec){.tv_nsec = round * 150000000}, NULL);
		uint64_t since = stilb_time_ns();
		end_engine(engine);
		assert_true((double)(stilb_time_ns() - since) * 1e-9 < WAIT_S);
		assert_string_equal(logged, "");
	}
	setenv("PATH", path, 1);
	free(path);
	free(slow);
}

static void where_it_is_impossible(void **state)
{
	(void)state;
	char *path = strdup(getenv("PATH"));
	stilb_engine *engine = make_engine(STILB_ENGINE_WATCH_ON, "/nowhere");
	assert_string_equal(logged, "--watch-shaders: no shader sources at '/nowhere'; give --shaders DIR, the folder "
	                            "'engine' of Stilb's sources\n");
	draw(engine);
	end_engine(engine);
	engine = make_engine(STILB_ENGINE_WATCH_AUTO, "/nowhere");
	assert_string_equal(logged, "");
	end_engine(engine);
	engine = make_engine(STILB_ENGINE_WATCH_OFF, folder);
	assert_null(engine->watch);
	end_engine(engine);
	setenv("PATH", "/nowhere", 1);
	engine = make_engine(STILB_ENGINE_WATCH_ON, folder);
	assert_non_null(strstr(logged, "--watch-shaders: glslc, which compiles shaders, is not in PATH; install it"));
	draw(engine);
	end_engine(engine);
	/* It goes while the engine runs. */
	setenv("PATH", path, 1);
	engine = make_engine(STILB_ENGINE_WATCH_ON, folder);
	draw(engine);
	draw(engine);
	setenv("PATH", "/nowhere", 1);
	free(edit(TONE, "void main()", "void main()", false));
	wait_for(engine, "is not in PATH");
	end_engine(engine);
	setenv("PATH", path, 1);
	free(path);
}

/* ---- includes ---------------------------------------------------------------------------------------------------- */

static void includes_are_found(void **state)
{
	(void)state;
	static const char *const texts[3] = {"#include \"b.glsl\"\n# include<sub/c.glsl>\nvoid main() {}\n",
	                                     "  #  include  \"a.frag\" // a circle\n#include \"missing.glsl\"\n#include\n",
	                                     "// #include \"b.glsl\"\n#include \"../b.glsl"};
	static const char *const names[3] = {"a.frag", "b.glsl", "sub/c.glsl"};
	char command[PATH_MAX + 16], path[PATH_MAX + 16];
	snprintf(command, sizeof command, "mkdir '%s/sub'", folder);
	assert_int_equal(system(command), 0);
	for (int f = 0; f < 3; f++)
		write_source(names[f], texts[f], false);
	engine_files files = {0};
	snprintf(path, sizeof path, "%s/sub/../a.frag", folder);
	engine_files_add(&files, path);
	assert_int_equal(files.count, 3);
	for (int f = 0; f < 3; f++) {
		char real[PATH_MAX];
		snprintf(path, sizeof path, "%s/%s", folder, names[f]);
		assert_non_null(realpath(path, real));
		assert_true(engine_files_have(&files, real));
	}
	engine_files_finish(&files);
	engine_files_add(&files, "/nowhere/a.frag");
	assert_int_equal(files.count, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(includes_are_found), cmocka_unit_test(the_picture_follows),
		cmocka_unit_test(shared_files),       cmocka_unit_test(a_panel),
		cmocka_unit_test(it_ends_at_once),    cmocka_unit_test(where_it_is_impossible),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
