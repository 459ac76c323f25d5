/* Pictures that the engine writes beside the frames: in order, told of on the main thread, waited for at the end, and
 * of one that cannot be written nothing is left. */
#include "engine_internal.h"
#include "support/folder.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"

#include <dirent.h>
#include <semaphore.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static stilb_engine *engine;
static sem_t gate;          /* a picture is written when it is let through */
static uint32_t told_count; /* of what the engine told */
static char told[16][64];

static void on_pictured(void *user, const stilb_engine_pictured *pictured)
{
	assert_ptr_equal(user, &gate);
	assert_true(told_count < 16);
	snprintf(told[told_count++], sizeof told[0], "%s %d %s", pictured->path, pictured->result, pictured->message);
}

/* Writes the picture's one code of grey as text; one of 13 is too many for the disk. */
static stilb_result save(const stilb_scene_look *look, const stilb_image *image, const char *path)
{
	(void)look;
	sem_wait(&gate);
	uint8_t code = *(const uint8_t *)image->pixels;
	FILE *file = code == 13 ? NULL : fopen(path, "w");
	if (!file)
		return stilb_fail(STILB_ERROR_FILE, "cannot write '%s': full", path);
	fprintf(file, "%d", code);
	fclose(file);
	return STILB_OK;
}

static void let_through(int count)
{
	for (int i = 0; i < count; i++)
		sem_post(&gate);
}

static int begin(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	desc.profile_ring_mib = 1;
	desc.pictured = on_pictured;
	desc.user = &gate;
	told_count = 0;
	sem_init(&gate, 0, 0);
	if (folder_make(state) != 0 ||
	    stress_engine_create(&desc, &(stress_engine){.models = 1, .seed = 1}, &engine) != STILB_OK)
		return -1;
	engine->pictures = engine_pictures_create(save);
	return engine->pictures ? 0 : -1;
}

static int end(void **state)
{
	(void)state;
	let_through(16); /* so that the end does not wait for pictures of a test that has failed */
	stress_engine_destroy(engine);
	engine = NULL;
	sem_destroy(&gate);
	folder_clear();
	return folder_remove();
}

static int entries(void)
{
	int count = 0;
	DIR *folder = opendir(".");
	assert_non_null(folder);
	for (struct dirent *entry; (entry = readdir(folder));)
		count += entry->d_name[0] != '.';
	closedir(folder);
	return count;
}

static void add(const char *path, uint8_t code, bool created)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 1, 1, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	*(uint8_t *)image.pixels = code;
	if (created)
		fclose(fopen(path, "w"));
	assert_int_equal(engine_pictures_add(engine->pictures, &image, &(stilb_scene_look){0}, path, created), STILB_OK);
	assert_null(image.pixels);
}

static void run_frame(void)
{
	stilb_engine_report report;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
}

static int written(const char *path)
{
	int code = -1;
	FILE *file = fopen(path, "r");
	if (file && fscanf(file, "%d", &code) != 1)
		code = -2;
	if (file)
		fclose(file);
	return code;
}

static void frames_go_on_meanwhile(void **state)
{
	(void)state;
	add("a", 1, true);
	add("b", 13, true);
	add("c", 13, false);
	add("d", 4, false);
	for (int i = 0; i < 3; i++)
		run_frame();
	assert_int_equal(told_count, 0);
	assert_int_equal(written("a"), -2); /* its name is taken, and nothing else is there */
	let_through(1);
	for (int i = 0; i < 2000 && told_count == 0; i++, usleep(1000))
		run_frame();
	assert_int_equal(told_count, 1);
	let_through(3);
	stilb_engine_pictures_wait(engine);
	assert_int_equal(told_count, 4);
	assert_string_equal(told[0], "a 0 ");
	char wanted[64];
	snprintf(wanted, sizeof wanted, "b %d cannot write 'b': full", STILB_ERROR_FILE);
	assert_string_equal(told[1], wanted);
	assert_string_equal(told[3], "d 0 ");
	assert_true(written("a") == 1 && written("d") == 4);
	assert_int_equal(entries(), 2);
}

/* The fifth waits until one of the four is written: pictures are large. */
static void few_are_pending(void **state)
{
	(void)state;
	let_through(1);
	for (uint8_t i = 0; i < ENGINE_PICTURES + 1; i++)
		add((const char[]){(char)('a' + i), '\0'}, (uint8_t)(20 + i), false);
	assert_int_equal(written("a"), 20);
	assert_int_equal(entries(), 1);
	let_through(ENGINE_PICTURES);
	stilb_engine_pictures_wait(engine);
	assert_int_equal(told_count, ENGINE_PICTURES + 1);
	for (uint8_t i = 0; i < ENGINE_PICTURES + 1; i++)
		assert_int_equal(told[i][0], 'a' + i);
}

/* The engine's end waits for what is being written, and tells of it. */
static void the_end_waits(void **state)
{
	(void)state;
	add("a", 1, false);
	add("b", 13, true);
	add("c", 3, false);
	let_through(3);
	stress_engine_destroy(engine);
	engine = NULL;
	assert_int_equal(told_count, 3);
	assert_true(written("a") == 1 && written("b") == -1 && written("c") == 3);
}

/* A device without pictures: the name that was taken for one is free again. */
static void what_cannot_be_read_back(void **state)
{
	(void)state;
	run_frame();
	fclose(fopen("a.png", "w"));
	fclose(fopen("b.png", "w"));
	assert_int_equal(stilb_engine_picture(engine, "a.png", true), STILB_ERROR_DEVICE);
	assert_int_equal(stilb_engine_picture(engine, "b.png", false), STILB_ERROR_DEVICE);
	assert_true(written("a.png") == -1 && written("b.png") == -2);
	assert_int_equal(told_count, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(frames_go_on_meanwhile, begin, end),
		cmocka_unit_test_setup_teardown(few_are_pending, begin, end),
		cmocka_unit_test_setup_teardown(the_end_waits, begin, end),
		cmocka_unit_test_setup_teardown(what_cannot_be_read_back, begin, end),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
