/*
 * stilb-scene-import BYTES SECONDS: reads scenes and pictures on request. Requests come through the socket that is its
 * descriptor 3 (scene_stream.h); it may use BYTES of memory, and SECONDS for each request. Started by scene_import.c
 * only.
 */
#include "scene/importer/importer_motion.h"

#include "image/image_import.h"
#include "scene/importer/gltf/gltf.h"
#include "scene/importer/importer_sandbox.h"
#include "scene/open/scene_stream.h"

#include <assimp/cimport.h>
#include <assimp/version.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define IMPORTER_SOCKET 3 /* the same in scene_import.c */

static void importer_say(scene_message_kind kind, stilb_result result, const char *format, va_list arguments)
{
	scene_message message = {.kind = kind, .result = result};
	vsnprintf(message.text, sizeof message.text, format, arguments);
	if (!scene_stream_write_message(importer_stream.file, &message, -1))
		_exit(1); /* Stilb is gone */
}

void importer_warn(const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	importer_say(SCENE_MESSAGE_WARNING, STILB_OK, format, arguments);
	va_end(arguments);
}

#define IMPORTER_TELL_NS 20000000u

static void importer_tell(float done)
{
	static uint64_t told_ns;
	uint64_t now = stilb_time_ns();
	if (now - told_ns < IMPORTER_TELL_NS)
		return;
	told_ns = now;
	scene_message message = {.kind = SCENE_MESSAGE_PROGRESS, .done = done};
	if (!scene_stream_write_message(importer_stream.file, &message, -1))
		_exit(1); /* Stilb is gone */
}

void importer_advance_textures(uint32_t done, uint32_t count)
{
	STILB_ASSERT(done <= count && count > 0);
	importer_tell(0.5f * (float)done / (float)count);
}

void importer_advance_meshes(const importer *import, uint32_t done, uint32_t count)
{
	STILB_ASSERT(done <= count && count > 0);
	float before = import->texture_count > 0 ? 0.5f : 0.0f;
	importer_tell(before + (1.0f - before) * (float)done / (float)count);
}

static void importer_send(scene_message_kind kind, stilb_result result, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

static void importer_send(scene_message_kind kind, stilb_result result, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	importer_say(kind, result, format, arguments);
	va_end(arguments);
}

/* Reads the file by Assimp and converts it. */
static stilb_result importer_convert_foreign(importer *import)
{
	static stilb_result (*const steps[])(importer *) = {
		importer_list_nodes, importer_add_meshes, importer_add_materials, importer_add_view, importer_add_animation};
	stilb_result result = importer_read(import);
	if (result != STILB_OK)
		return result;
	import->gltf = importer_is_format(import->from, "glTF");
	import->world.to_world = importer_axes(import->from, import->up_is_y);
	importer_load_textures(import);
	for (size_t s = 0; result == STILB_OK && s < sizeof steps / sizeof *steps; s++)
		result = steps[s](import);
	return result;
}

static stilb_result importer_convert(importer *import, const char *path)
{
	STILB_ASSERT(!import->from && !import->scene);
	char why[256];
	importer_bytes bytes = {0};
	int file = importer_files_ask(path, true, why);
	if (file < 0 || !importer_bytes_read(file, &bytes))
		return stilb_fail(STILB_ERROR_FILE, "it cannot be read, or is too large");
	import->path = path;
	bool own = gltf_is(path, &bytes);
	import->up_is_y = !own && importer_up_is_y(path, &bytes);
	if (!own)
		importer_bytes_free(&bytes); /* Assimp reads it itself */
	stilb_result result = own ? gltf_import(import, &bytes) : importer_convert_foreign(import);
	importer_bytes_free(&bytes);
	importer_tell_losses(import);
	if (import->bad_nodes)
		importer_warn("%u of its nodes have a transform that is NaN or infinite: they are left out", import->bad_nodes);
	STILB_CHECK(result != STILB_OK || scene_is_sound(import->scene));
	return result;
}

static void importer_finish(importer *import)
{
	importer_free_textures(import);
	free(import->colored);
	free(import->nodes);
	importer_motion_finish(import->motion);
	stilb_scene_destroy(import->scene);
	if (import->from)
		aiReleaseImport(import->from);
}

/* Sends the picture's shape with the descriptor of its memory. */
static void importer_send_shape(const stilb_image *picture, int file)
{
	scene_message message = {.kind = SCENE_MESSAGE_PICTURE,
	                         .width = picture->width,
	                         .height = picture->height,
	                         .channels = picture->channels,
	                         .format = picture->format,
	                         .levels = stilb_image_level_count(picture)};
	if (!scene_stream_write_message(importer_stream.file, &message, file))
		_exit(1); /* Stilb is gone */
}

/* Hands a picture of stilb_image_create_shared over to Stilb; it is {0} afterwards. */
static stilb_result importer_send_picture(stilb_image *picture)
{
	stilb_image shape = *picture;
	int file = stilb_image_share(picture);
	if (file < 0)
		return STILB_ERROR_FILE;
	importer_send_shape(&shape, file);
	close(file);
	return STILB_OK;
}

static stilb_result importer_send_scene(stilb_scene *scene)
{
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; result == STILB_OK && i < scene->texture_count; i++)
		result = importer_send_picture(&scene->textures[i]);
	if (result != STILB_OK)
		return result;
	importer_send(SCENE_MESSAGE_SCENE, STILB_OK, "%s", "");
	if (!scene_stream_write(importer_stream.file, scene))
		_exit(1);
	return STILB_OK;
}

static stilb_result importer_do_scene(const char *path)
{
	importer import = {0};
	stilb_result result = importer_convert(&import, path);
	if (result == STILB_OK)
		result = importer_send_scene(import.scene);
	importer_finish(&import);
	return result;
}

/* Decodes the request's picture. flags and picture: as stilb_image_import_memory has them. */
static stilb_result importer_do_picture(const char *path, uint32_t flags, stilb_image *picture)
{
	char why[256];
	importer_bytes bytes = {0};
	int file = importer_files_ask(path, true, why);
	if (file < 0 || !importer_bytes_read(file, &bytes))
		return stilb_fail(STILB_ERROR_FILE, "it cannot be read, or is too large");
	stilb_result result = importer_decode(path, &bytes, flags, picture);
	importer_bytes_free(&bytes);
	return result;
}

/* Small pictures are lent, and the next one gets their memory: Stilb has its copy before it sends another request. */
static stilb_result importer_do_codes(const char *path)
{
	static stilb_image picture;
	stilb_result result = importer_do_picture(path, STILB_IMAGE_IMPORT_AGAIN, &picture);
	if (result == STILB_OK && stilb_image_size(&picture) > STILB_IMAGE_LEND_MAX)
		return importer_send_picture(&picture);
	if (result == STILB_OK)
		importer_send_shape(&picture, stilb_image_lend(&picture));
	return result;
}

static stilb_result importer_do_light(const char *path)
{
	stilb_image picture = {0};
	stilb_result result = importer_do_picture(path, STILB_IMAGE_IMPORT_FOR_LIGHT, &picture);
	if (result == STILB_OK)
		result = importer_picture_to_light(&picture);
	return result == STILB_OK ? importer_send_picture(&picture) : result;
}

/* Handles one request and sends its result. */
static void importer_serve(const scene_message *request, int file)
{
	stilb_result result = STILB_OK;
	importer_files_begin(request->text, file);
	if (request->kind == SCENE_MESSAGE_READ_SCENE)
		result = importer_do_scene(request->text);
	else if (request->kind == SCENE_MESSAGE_READ_PICTURE)
		result = importer_do_codes(request->text);
	else if (request->kind == SCENE_MESSAGE_READ_LIGHT)
		result = importer_do_light(request->text);
	else
		importer_send(SCENE_MESSAGE_VERSION, STILB_OK, "Assimp %u.%u.%u\nOpenImageIO %s\n", aiGetVersionMajor(),
		              aiGetVersionMinor(), aiGetVersionPatch(), stilb_image_library_version());
	if (result != STILB_OK)
		importer_send(SCENE_MESSAGE_ERROR, result, "%s", stilb_error_message());
	importer_files_end();
}

int main(int argc, char **argv)
{
	scene_message message = {.kind = SCENE_MESSAGE_HELLO};
	if (argc != 3 || fcntl(IMPORTER_SOCKET, F_SETFD, FD_CLOEXEC) != 0) {
		fprintf(stderr,
		        "stilb: stilb-scene-import is started by other programs of Stilb, to read scenes and pictures\n");
		return 2;
	}
#if !IMPORTER_SANITIZED
	dup2(STDOUT_FILENO, STDERR_FILENO); /* to /dev/null, because libraries print debug messages */
#endif
	importer_stream = (scene_stream){.file = IMPORTER_SOCKET, .deadline_ns = UINT64_MAX};
	message.flags = importer_sandbox_enter(strtoull(argv[1], NULL, 10));
	scene_stream_version(message.text);
	if (!scene_stream_write_message(IMPORTER_SOCKET, &message, -1))
		_exit(1);
	for (int file; scene_stream_read_message(&importer_stream, &message, &file);) {
		importer_sandbox_allow_time(strtoull(argv[2], NULL, 10));
		importer_serve(&message, file);
	}
	_exit(0);
}
