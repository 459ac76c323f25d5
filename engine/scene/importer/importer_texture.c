/* Textures: in the file itself, or as files beside it. */
#include "scene/importer/importer.h"

#include "scene/scene_picture.h"
#include "shading/shade_srgb.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Writes what in folder is called name, but for capitals, over name; false: nothing is. */
static bool texture_recall(const char *folder, char *name)
{
	DIR *directory = opendir(folder);
	bool found = false;
	for (struct dirent *entry; directory && !found && (entry = readdir(directory));)
		if (strcasecmp(entry->d_name, name) == 0) {
			memcpy(name, entry->d_name, strlen(name));
			found = true;
		}
	if (directory)
		closedir(directory);
	return found;
}

/* The file at names, which are relative to folder, in whatever capitals it has; false: there is none. */
static bool texture_walk(const char *folder, const char *names, char path[static PATH_MAX])
{
	size_t length = strlen(folder);
	if (length + strlen(names) + 2 > PATH_MAX)
		return false;
	memcpy(path, folder, length + 1);
	while (*names) {
		size_t name = strcspn(names, "/");
		path[length] = '/';
		memcpy(path + length + 1, names, name);
		path[length + 1 + name] = '\0';
		if (access(path, F_OK) != 0) {
			path[length] = '\0';
			if (!texture_recall(path, path + length + 1))
				return false;
			path[length] = '/';
		}
		length += 1 + name;
		names += name + (names[name] == '/');
	}
	return access(path, R_OK) == 0;
}

/* Where the file is: as named, seen from the scene's folder; there by its last name, since many scenes name files of
 * the disk that they were made on. */
static bool texture_find(const char *scene, const char *given, char path[static PATH_MAX])
{
	char folder[PATH_MAX], name[MAXLEN];
	const char *slash = strrchr(scene, '/');
	snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - scene) : 1, slash ? scene : ".");
	snprintf(name, sizeof name, "%s", given);
	for (char *c = name; *c; c++)
		if (*c == '\\')
			*c = '/';
	char *start = name;
	if (strncmp(name, "//", 2) == 0) /* Blender: the scene's folder */
		start = name + 2;
	if (start[0] == '/' && texture_walk("", start + 1, path))
		return true;
	if (texture_walk(folder, start, path))
		return true;
	char *last = strrchr(start, '/');
	return last && last[1] && texture_walk(folder, last + 1, path);
}

/* ---- in the file ------------------------------------------------------------------------------------------------- */

/* "*N" is the file's Nth; others are known by their names. NULL: it is no texture of the file. */
static const struct aiTexture *texture_embedded(const importer *import, const char *name)
{
	const struct aiScene *from = import->from;
	if (name[0] == '*') {
		char *end;
		unsigned long index = strtoul(name + 1, &end, 10);
		return end > name + 1 && index < from->mNumTextures ? from->mTextures[index] : NULL;
	}
	const char *slash = strrchr(name, '/'), *last = slash ? slash + 1 : name;
	for (uint32_t i = 0; i < from->mNumTextures; i++) {
		const char *own = from->mTextures[i]->mFilename.data, *own_slash = strrchr(own, '/');
		if (own[0] && strcmp(own_slash ? own_slash + 1 : own, last) == 0)
			return from->mTextures[i];
	}
	return NULL;
}

static stilb_result texture_from_memory(const struct aiTexture *texture, const char *name, stilb_image *image)
{
	char called[MAXLEN + HINTMAXTEXTURELEN + 2];
	if (!texture->pcData)
		return stilb_fail(STILB_ERROR_FILE, "it is empty");
	if (texture->mHeight == 0) { /* a file, mWidth bytes long */
		snprintf(called, sizeof called, "%s.%.*s", name, HINTMAXTEXTURELEN, texture->achFormatHint);
		return stilb_image_import_memory(called, texture->pcData, texture->mWidth, image);
	}
	stilb_result result = stilb_image_create(image, texture->mWidth, texture->mHeight, 3, STILB_IMAGE_U8_SRGB);
	uint8_t *out = image->pixels;
	for (size_t i = 0; result == STILB_OK && i < (size_t)texture->mWidth * texture->mHeight; i++) {
		*out++ = texture->pcData[i].r;
		*out++ = texture->pcData[i].g;
		*out++ = texture->pcData[i].b;
	}
	return result;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static void texture_average(importer_texture *texture)
{
	const stilb_image *image = &texture->image;
	double sum[3] = {0}, stored[3] = {0};
	float table[256];
	for (int code = 0; code < 256; code++)
		table[code] = shade_srgb_to_linear((float)code / 255.0f);
	const uint8_t *codes = image->format == STILB_IMAGE_U8_SRGB ? image->pixels : NULL;
	const float *floats = image->pixels;
	const size_t count = (size_t)image->width * image->height;
	for (size_t i = 0; i < 3 * count; i++) {
		sum[i % 3] += (double)(codes ? table[codes[i]] : floats[i]);
		stored[i % 3] += codes ? codes[i] / 255.0 : (double)floats[i];
	}
	for (int i = 0; i < 3; i++) {
		texture->mean[i] = (float)(sum[i] / (double)count);
		texture->stored_mean[i] = (float)(stored[i] / (double)count);
	}
}

static stilb_result texture_load(const importer *import, importer_texture *texture)
{
	char path[PATH_MAX];
	const struct aiTexture *embedded = texture_embedded(import, texture->name);
	stilb_result result;
	if (embedded)
		result = texture_from_memory(embedded, texture->name, &texture->image);
	else if (texture_find(import->path, texture->name, path))
		result = stilb_image_import(path, &texture->image);
	else
		return stilb_fail(STILB_ERROR_FILE, "there is no such file in the scene's folder");
	if (result == STILB_OK)
		result = scene_picture_to_rgb(&texture->image);
	if (result == STILB_OK)
		texture_average(texture);
	return result;
}

uint32_t importer_texture_of(importer *import, const char *name, const char *material)
{
	uint32_t i = 0;
	while (i < import->texture_count && strcmp(import->textures[i].name, name))
		i++;
	if (i == import->texture_count) {
		if (i == import->textures_room) {
			uint32_t room = 2 * i + 16;
			importer_texture *more = realloc(import->textures, room * sizeof *more);
			if (!more)
				return UINT32_MAX;
			import->textures = more;
			import->textures_room = room;
		}
		importer_texture *texture = &import->textures[import->texture_count++];
		*texture = (importer_texture){0};
		snprintf(texture->name, sizeof texture->name, "%s", name);
		if (texture_load(import, texture) != STILB_OK)
			importer_warn("material '%s': texture '%s': %s; what it would cover is magenta", material, name,
			              stilb_error_message());
	}
	return import->textures[i].image.pixels ? i : UINT32_MAX;
}
