/* glTF files that a test writes, with known contents, and what opening them gives and logs. Include it in one file of a
 * test, whose group has folder_make and glb_clear. */
#ifndef GLB_MADE_H
#define GLB_MADE_H

#include "scene/scene.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static unsigned char data[1 << 22]; /* the file's binary part */
static size_t data_size;
static char views[1 << 19]; /* JSON of its buffer views */

/* A new file without data. */
static inline void begin(void)
{
	data_size = 0;
	views[0] = '\0';
}

/* Adds bytes as the next buffer view; rest: further JSON of the view, after a comma, or "". */
static inline void put_with(const void *bytes, size_t size, const char *rest)
{
	assert_true(data_size + size + 4 <= sizeof data);
	memcpy(data + data_size, bytes, size);
	size_t used = strlen(views);
	int length = snprintf(views + used, sizeof views - used, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu%s}",
	                      used > 0 ? "," : "", data_size, size, rest);
	assert_true(length > 0 && (size_t)length < sizeof views - used);
	data_size = (data_size + size + 3) / 4 * 4;
}

static inline void put(const void *bytes, size_t size)
{
	put_with(bytes, size, "");
}

static inline void write_u32(FILE *file, uint32_t value)
{
	assert_int_equal(fwrite(&value, sizeof value, 1, file), 1);
}

/* Writes test.glb: the JSON of everything but asset, buffers and views. */
static inline void write_glb(const char *json)
{
	char *text;
	int length =
		asprintf(&text, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[%s],%s}",
	             data_size, views, json);
	assert_true(length > 0);
	uint32_t padded = ((uint32_t)length + 3) / 4 * 4;
	FILE *file = fopen("test.glb", "wb");
	assert_non_null(file);
	fputs("glTF", file);
	write_u32(file, 2);
	write_u32(file, 12 + 8 + padded + 8 + (uint32_t)data_size);
	write_u32(file, padded);
	write_u32(file, 0x4E4F534A);
	fprintf(file, "%-*s", (int)padded, text);
	write_u32(file, (uint32_t)data_size);
	write_u32(file, 0x004E4942);
	assert_int_equal(fwrite(data, 1, data_size, file), data_size);
	assert_int_equal(fclose(file), 0);
	free(text);
}

static inline void write_file(const char *name, const void *bytes, size_t size)
{
	FILE *file = fopen(name, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static char said[4096]; /* what opening the last file logged */

static inline stilb_result open_file(const char *name, bool quiet, stilb_scene **scene)
{
	FILE *log = tmpfile();
	assert_non_null(log);
	int real = dup(STDERR_FILENO);
	dup2(fileno(log), STDERR_FILENO);
	stilb_result result = stilb_scene_open_with(name, &(stilb_scene_open_options){.quiet = quiet}, scene);
	dup2(real, STDERR_FILENO);
	close(real);
	ssize_t size = pread(fileno(log), said, sizeof said - 1, 0);
	said[size > 0 ? size : 0] = '\0';
	fclose(log);
	return result;
}

static inline stilb_scene *open_glb(const char *json)
{
	stilb_scene *scene;
	write_glb(json);
	if (open_file("test.glb", false, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static inline void assert_said(const char *words)
{
	if (!strstr(said, words))
		fail_msg("'%s' does not say '%s'", said, words);
}

static inline void assert_refused(const char *json, const char *words)
{
	stilb_scene *scene;
	write_glb(json);
	stilb_result result = open_file("test.glb", false, &scene);
	if (result == STILB_OK || !strstr(stilb_error_message(), words) || strstr(stilb_error_message(), "crashed"))
		fail_msg("'%s' does not say '%s'", result == STILB_OK ? "it opens" : stilb_error_message(), words);
	assert_null(scene);
}

static inline bool near(float a, float b)
{
	return fabsf(a - b) < 1e-5f * fmaxf(1.0f, fabsf(b));
}

static inline void assert_numbers(const float *got, const float *wanted, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		if (!near(got[i], wanted[i]))
			fail_msg("number %u of %u is %g instead of %g", i, count, (double)got[i], (double)wanted[i]);
}

/* The mesh has these triangles, in this order, by x and y of their corners. */
static inline void assert_triangles(const stilb_scene_mesh *mesh, const float (*corners)[2], uint32_t count)
{
	assert_int_equal(mesh->index_count, count);
	for (uint32_t i = 0; i < count; i++)
		assert_numbers(mesh->vertices[mesh->indices[i]].position, corners[i], 2);
}

#define NODE "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]"
#define TRIANGLE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"
#define VEC3(view) "{\"bufferView\":" #view ",\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}"

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A PNG of two texels. */
static inline void write_picture(const char *name)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 2, 1, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	memcpy(image.pixels, (const uint8_t[]){255, 0, 128, 255, 0, 128}, 6);
	assert_int_equal(stilb_image_save(&image, name), STILB_OK);
	stilb_image_finish(&image);
}

/* The tear-down of the group. */
static inline int glb_clear(void **state)
{
	(void)state;
	remove("test.glb");
	return folder_remove();
}

#endif
