/* The pictures that materials need. */
#include "scene/importer/gltf/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- which picture ----------------------------------------------------------------------------------------------- */

/* The image of a texture: its own, or else that of an extension for other formats of pictures; GLTF_NONE: none. */
static uint32_t texture_image(gltf *from, uint32_t texture)
{
	static const char *const formats[] = {"EXT_texture_webp", "MSFT_texture_dds", "KHR_texture_basisu"};
	uint32_t item = from->lists[GLTF_TEXTURES].items[texture];
	uint32_t image = gltf_reference(from, item, "source", GLTF_IMAGES);
	for (size_t i = 0; image == GLTF_NONE && i < sizeof formats / sizeof *formats; i++)
		image = gltf_reference(from, gltf_extension(from, item, formats[i]), "source", GLTF_IMAGES);
	return image;
}

uint32_t gltf_texture_picture(gltf *from, uint32_t info)
{
	uint32_t texture = gltf_reference(from, info, "index", GLTF_TEXTURES);
	uint32_t image = texture == GLTF_NONE ? GLTF_NONE : texture_image(from, texture);
	return image == GLTF_NONE || from->picture[image] == 0 ? GLTF_NONE : from->picture[image] - 1;
}

/* Finds the bytes of an image in the file itself, or asks for its file. */
static stilb_result texture_find(gltf *from, uint32_t image, importer_texture *texture)
{
	scene_json *json = &from->json;
	uint32_t item = from->lists[GLTF_IMAGES].items[image], uri = scene_json_member(json, item, "uri");
	uint32_t number = gltf_reference(from, item, "bufferView", GLTF_VIEWS);
	const gltf_view *view;
	gltf_name(from, GLTF_IMAGES, image, texture->name);
	if (number != GLTF_NONE) {
		stilb_result result = gltf_view_use(from, number, &view);
		if (result == STILB_OK)
			texture->inside = (importer_bytes){(unsigned char *)view->data, view->size};
		return result;
	}
	if (uri == GLTF_NONE) {
		snprintf(texture->trouble, sizeof texture->trouble, "it has neither a file nor a buffer view");
		return scene_json_check(json);
	}
	from->unpacked[image] = gltf_unpack(from, uri, &texture->inside.size);
	texture->inside.data = from->unpacked[image];
	if (texture->inside.data)
		return STILB_OK;
	if (gltf_file_name(from, uri, texture->name, sizeof texture->name))
		texture->file = importer_files_ask(texture->name, true, texture->trouble);
	else
		snprintf(texture->trouble, sizeof texture->trouble, "the name of its file is too long or empty");
	return scene_json_check(json);
}

/* Lists the picture of a texture info, if there is one and it is not in the list yet. */
static stilb_result texture_list_info(gltf *from, uint32_t info)
{
	importer *import = from->import;
	uint32_t texture = gltf_reference(from, info, "index", GLTF_TEXTURES);
	uint32_t image = texture == GLTF_NONE ? GLTF_NONE : texture_image(from, texture);
	if (image == GLTF_NONE || from->picture[image] > 0)
		return scene_json_check(&from->json);
	importer_texture *made = &import->textures[import->texture_count++];
	made->file = -1;
	from->picture[image] = import->texture_count;
	return texture_find(from, image, made);
}

/* Lists the pictures of a material's maps. */
static stilb_result texture_list_material(gltf *from, uint32_t item)
{
	stilb_result result = STILB_OK;
	for (int kind = 0; result == STILB_OK && kind < STILB_SCENE_MAPS; kind++)
		result = texture_list_info(from, gltf_map_info(from, item, (stilb_scene_map_kind)kind));
	return result;
}

stilb_result gltf_load_textures(gltf *from)
{
	uint32_t images = from->lists[GLTF_IMAGES].count;
	importer *import = from->import;
	STILB_ASSERT(!import->textures);
	import->textures = calloc(images + 1ull, sizeof *import->textures);
	from->picture = calloc(images + 1ull, sizeof *from->picture);
	from->unpacked = calloc(images + 1ull, sizeof *from->unpacked);
	if (!import->textures || !from->picture || !from->unpacked)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its textures");
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; result == STILB_OK && m < from->lists[GLTF_MATERIALS].count; m++)
		result = texture_list_material(from, from->lists[GLTF_MATERIALS].items[m]);
	if (result == STILB_OK)
		importer_decode_textures(import);
	return result;
}
