/* The container of a glTF file: .glb or .gltf, its JSON, its buffers and their views. */
#include "scene/importer/gltf/gltf.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- the file ---------------------------------------------------------------------------------------------------- */

#define SCENE_JSON_CHUNK 0x4E4F534Au  /* "JSON" */
#define GLTF_BINARY_CHUNK 0x004E4942u /* "BIN" */
#define GLTF_HEADER 12u               /* bytes: "glTF", version, length */
#define GLTF_CHUNK_HEADER 8u          /* bytes: length, kind */

static uint32_t gltf_u32(const unsigned char *data)
{
	return (uint32_t)data[0] | (uint32_t)data[1] << 8 | (uint32_t)data[2] << 16 | (uint32_t)data[3] << 24;
}

static bool gltf_is_binary(const importer_bytes *bytes)
{
	return bytes->size >= GLTF_HEADER && memcmp(bytes->data, "glTF", 4) == 0;
}

/* True if the asset's version begins with 1, as in {"asset":{"version":"1.0"}} or, of early files, as a number. */
static bool gltf_is_first_version(const importer_bytes *bytes)
{
	scene_json json;
	char version[8] = "";
	if (scene_json_parse(&json, (const char *)bytes->data, bytes->size) != STILB_OK)
		return false;
	uint32_t asset = json.tokens[SCENE_JSON_ROOT].kind == SCENE_JSON_OBJECT
	                     ? scene_json_member(&json, SCENE_JSON_ROOT, "asset")
	                     : GLTF_NONE;
	uint32_t token = scene_json_member(&json, asset, "version");
	bool number = token != GLTF_NONE && json.tokens[token].kind == SCENE_JSON_NUMBER;
	if (number)
		version[0] = json.text[json.tokens[token].at];
	else
		scene_json_copy(&json, token, version, sizeof version);
	/* Files of version 1 without a version have objects where those of version 2 have arrays. */
	uint32_t meshes = asset == GLTF_NONE ? scene_json_member(&json, SCENE_JSON_ROOT, "meshes") : GLTF_NONE;
	bool first = version[0] == '1' || (meshes != GLTF_NONE && json.tokens[meshes].kind == SCENE_JSON_OBJECT);
	scene_json_finish(&json);
	return first;
}

bool gltf_is(const char *path, const importer_bytes *bytes)
{
	const char *dot = strrchr(path, '.');
	if (gltf_is_binary(bytes))
		return gltf_u32(bytes->data + 4) != 1;
	return dot && strcasecmp(dot, ".gltf") == 0 && !gltf_is_first_version(bytes);
}

/* Finds the JSON and the binary part of a .glb. */
static stilb_result gltf_split(gltf *from, const importer_bytes *bytes, importer_bytes *json)
{
	uint32_t version = gltf_u32(bytes->data + 4);
	size_t at = GLTF_HEADER;
	if (version != 2)
		return stilb_fail(STILB_ERROR_FILE, "it is of version %u of binary glTF; versions 1 and 2 can be read",
		                  version);
	while (bytes->size - at >= GLTF_CHUNK_HEADER) {
		size_t size = gltf_u32(bytes->data + at);
		uint32_t kind = gltf_u32(bytes->data + at + 4);
		at += GLTF_CHUNK_HEADER;
		if (size > bytes->size - at)
			return stilb_fail(STILB_ERROR_FILE, "it is cut off: a part of it has %zu bytes, of which %zu are there",
			                  size, bytes->size - at);
		importer_bytes *part = kind == SCENE_JSON_CHUNK ? json : kind == GLTF_BINARY_CHUNK ? &from->binary : NULL;
		if (part && !part->data)
			*part = (importer_bytes){bytes->data + at, size};
		at += size;
	}
	return json->data ? STILB_OK : stilb_fail(STILB_ERROR_FILE, "it is a .glb without JSON");
}

static stilb_result gltf_check_version(gltf *from)
{
	char version[16];
	scene_json *json = &from->json;
	if (json->tokens[SCENE_JSON_ROOT].kind != SCENE_JSON_OBJECT)
		return stilb_fail(STILB_ERROR_FILE, "its JSON is not an object, as that of glTF is");
	uint32_t asset = scene_json_member(json, SCENE_JSON_ROOT, "asset");
	scene_json_string(json, asset, "version", version, sizeof version);
	if (version[0] == '2')
		return scene_json_check(json);
	if (json->fault[0])
		return scene_json_check(json);
	return stilb_fail(STILB_ERROR_FILE,
	                  version[0] ? "it is of glTF version %s; versions 1 and 2 can be read"
	                             : "it does not name its version of glTF%s",
	                  version);
}

stilb_result gltf_list_items(gltf *from, uint32_t object, const char *key, gltf_list *list)
{
	scene_json *json = &from->json;
	uint32_t array = scene_json_array(json, object, key), count = 0;
	for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at))
		count++;
	list->items = malloc((count + 1ull) * sizeof *list->items);
	if (!list->items)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its %s", key);
	for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at)) {
		if (json->tokens[at].kind != SCENE_JSON_OBJECT)
			scene_json_blame(json, at, "a value of '%s' is not of type object", key);
		list->items[list->count++] = at;
	}
	return scene_json_check(json);
}

static stilb_result gltf_make_lists(gltf *from)
{
#define GLTF_LIST_KEY(name, key) key,
	static const char *const keys[GLTF_LIST_COUNT] = {GLTF_LISTS(GLTF_LIST_KEY)};
#undef GLTF_LIST_KEY
	uint32_t lights = gltf_extension(from, SCENE_JSON_ROOT, "KHR_lights_punctual");
	uint32_t variants = gltf_extension(from, SCENE_JSON_ROOT, "KHR_materials_variants");
	stilb_result result = STILB_OK;
	for (int kind = 0; result == STILB_OK && kind < GLTF_LIST_COUNT; kind++)
		result = gltf_list_items(from,
		                         kind == GLTF_LIGHTS     ? lights
		                         : kind == GLTF_VARIANTS ? variants
		                                                 : SCENE_JSON_ROOT,
		                         keys[kind], &from->lists[kind]);
	return result;
}

uint32_t gltf_reference(gltf *from, uint32_t object, const char *key, gltf_list_kind kind)
{
	uint64_t index = scene_json_size(&from->json, object, key, UINT64_MAX);
	if (index == UINT64_MAX)
		return GLTF_NONE;
	if (index < from->lists[kind].count)
		return (uint32_t)index;
	scene_json_blame(&from->json, scene_json_member(&from->json, object, key),
	                 "'%s' is %llu, but there are %u of these", key, (unsigned long long)index,
	                 from->lists[kind].count);
	return GLTF_NONE;
}

uint32_t gltf_extension(gltf *from, uint32_t object, const char *name)
{
	return scene_json_member(&from->json, scene_json_member(&from->json, object, "extensions"), name);
}

void gltf_name(gltf *from, gltf_list_kind kind, uint32_t index, char name[static 96])
{
	STILB_ASSERT(index < from->lists[kind].count);
	if (scene_json_string(&from->json, from->lists[kind].items[index], "name", name, 96) == 0)
		snprintf(name, 96, "number %u", index);
}

/* ---- names of files ---------------------------------------------------------------------------------------------- */

/* The value of a digit of base64 (RFC 4648, or its alphabet for names of files); 64: it is none. */
static unsigned gltf_base64_digit(unsigned char c)
{
	if (c >= 'A' && c <= 'Z')
		return c - 'A';
	if (c >= 'a' && c <= 'z')
		return c - 'a' + 26u;
	if (c >= '0' && c <= '9')
		return c - '0' + 52u;
	return c == '+' || c == '-' ? 62u : c == '/' || c == '_' ? 63u : 64u;
}

/* True if a string token begins with these letters, upper or lower case. */
static bool gltf_begins(const gltf *from, uint32_t token, const char *with)
{
	const scene_json_token *string = &from->json.tokens[token];
	size_t size = strlen(with);
	return string->kind == SCENE_JSON_STRING && string->size >= size &&
	       strncasecmp(from->json.text + string->at, with, size) == 0;
}

unsigned char *gltf_unpack(gltf *from, uint32_t uri, size_t *size)
{
	const scene_json_token *token = &from->json.tokens[uri];
	if (!gltf_begins(from, uri, "data:"))
		return NULL;
	const unsigned char *text = (const unsigned char *)from->json.text + token->at, *end = text + token->size;
	const unsigned char *comma = memchr(text, ',', token->size);
	const unsigned char *digits = comma ? comma + 1 : end;
	unsigned char *out = malloc((size_t)(end - digits) / 4 * 3 + 4);
	uint32_t bits = 0, held = 0;
	*size = 0;
	for (const unsigned char *c = digits; out && c < end; c++) {
		unsigned digit = gltf_base64_digit(*c);
		if (digit == 64)
			continue; /* the = at the end, line ends, and the \ before a / */
		bits = bits << 6 | digit;
		held += 6;
		if (held >= 8) {
			held -= 8;
			out[(*size)++] = (unsigned char)(bits >> held);
		}
	}
	return out;
}

bool gltf_file_name(gltf *from, uint32_t uri, char *name, size_t room)
{
	size_t size = scene_json_copy(&from->json, uri, name, room);
	char *out = name;
	if (size == 0 || size >= room)
		return false;
	for (const char *c = name; *c; c++) {
		unsigned code = 0;
		if (c[0] == '%' && isxdigit((unsigned char)c[1]) && isxdigit((unsigned char)c[2]))
			sscanf(c + 1, "%2x", &code);
		*out++ = (char)(code ? (int)code : *c);
		c += code ? 2 : 0;
	}
	*out = '\0';
	return name[0] != '\0';
}

/* ---- buffers ----------------------------------------------------------------------------------------------------- */

/* Reads the file that a buffer names. */
static stilb_result gltf_buffer_file(gltf *from, uint32_t index, uint32_t uri, importer_bytes *bytes)
{
	char name[SCENE_MESSAGE_TEXT], why[256];
	if (!gltf_file_name(from, uri, name, sizeof name))
		return stilb_fail(STILB_ERROR_FILE, "buffer %u has no name of a file", index);
	int file = importer_files_ask(name, true, why);
	if (file < 0)
		return stilb_fail(STILB_ERROR_FILE, "its file '%s': %s", name, why);
	if (!importer_bytes_read(file, bytes))
		return stilb_fail(STILB_ERROR_FILE, "its file '%s' cannot be read, or is too large", name);
	return STILB_OK;
}

static stilb_result gltf_buffer_open(gltf *from, uint32_t index)
{
	gltf_buffer *buffer = &from->buffers[index];
	uint32_t item = from->lists[GLTF_BUFFERS].items[index], uri = scene_json_member(&from->json, item, "uri");
	importer_bytes bytes = {0};
	stilb_result result = STILB_OK;
	buffer->size = scene_json_size(&from->json, item, "byteLength", 0);
	if (uri == GLTF_NONE && (index > 0 || !from->binary.data))
		return scene_json_check(&from->json); /* without data: only compressed views may be of it */
	if (uri == GLTF_NONE)
		bytes = from->binary;
	else if (gltf_begins(from, uri, "data:"))
		buffer->own = bytes.data = gltf_unpack(from, uri, &bytes.size);
	else {
		result = gltf_buffer_file(from, index, uri, &bytes);
		buffer->own = bytes.data;
	}
	if (result == STILB_OK && !bytes.data)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for buffer %u", index);
	if (result == STILB_OK && bytes.size < buffer->size)
		return stilb_fail(STILB_ERROR_FILE, "buffer %u has %zu of its %llu bytes", index, bytes.size,
		                  (unsigned long long)buffer->size);
	buffer->data = bytes.data;
	from->bytes += buffer->own ? bytes.size : 0;
	return result == STILB_OK ? scene_json_check(&from->json) : result;
}

stilb_result gltf_view_use(gltf *from, uint32_t index, const gltf_view **out)
{
	STILB_ASSERT(index < from->lists[GLTF_VIEWS].count);
	scene_json *json = &from->json;
	gltf_view *view = &from->views[index];
	uint32_t item = from->lists[GLTF_VIEWS].items[index];
	*out = view;
	if (view->data)
		return STILB_OK;
	uint32_t packed = gltf_extension(from, item, "EXT_meshopt_compression");
	if (packed == GLTF_NONE)
		packed = gltf_extension(from, item, "KHR_meshopt_compression");
	uint32_t object = packed == GLTF_NONE ? item : packed,
			 number = gltf_reference(from, object, "buffer", GLTF_BUFFERS);
	uint64_t offset = scene_json_size(json, object, "byteOffset", 0),
			 size = scene_json_size(json, object, "byteLength", 0);
	uint64_t stride = scene_json_size(json, object, "byteStride", 0);
	if (number == GLTF_NONE && !json->fault[0])
		return stilb_fail(STILB_ERROR_FILE, "buffer view %u is of no buffer", index);
	if (json->fault[0])
		return scene_json_check(json);
	const gltf_buffer *buffer = &from->buffers[number];
	if (!buffer->data)
		return stilb_fail(STILB_ERROR_FILE, "buffer view %u is of buffer %u, which has no data", index, number);
	if (offset > buffer->size || size > buffer->size - offset || stride > 4096)
		return stilb_fail(STILB_ERROR_FILE, "buffer view %u, %llu bytes from byte %llu on, is not inside buffer %u",
		                  index, (unsigned long long)size, (unsigned long long)offset, number);
	*view = (gltf_view){.data = buffer->data + offset, .size = size, .stride = (uint32_t)stride};
	return packed == GLTF_NONE ? STILB_OK : gltf_meshopt_decode(from, packed, view);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

stilb_result gltf_open(gltf *from, const importer_bytes *bytes)
{
	importer_bytes text = *bytes;
	stilb_result result = STILB_OK;
	from->bytes = bytes->size;
	if (gltf_is_binary(bytes)) {
		text = (importer_bytes){0};
		result = gltf_split(from, bytes, &text);
	}
	if (result == STILB_OK)
		result = scene_json_parse(&from->json, (const char *)text.data, text.size);
	if (result == STILB_OK)
		result = gltf_check_version(from);
	if (result == STILB_OK)
		result = gltf_make_lists(from);
	if (result != STILB_OK)
		return result;
	from->buffers = calloc(from->lists[GLTF_BUFFERS].count + 1ull, sizeof *from->buffers);
	from->views = calloc(from->lists[GLTF_VIEWS].count + 1ull, sizeof *from->views);
	from->shown = calloc(from->lists[GLTF_MATERIALS].count + 1ull, sizeof *from->shown);
	if (!from->buffers || !from->views || !from->shown)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its buffers");
	for (uint32_t i = 0; result == STILB_OK && i < from->lists[GLTF_BUFFERS].count; i++)
		result = gltf_buffer_open(from, i);
	return result;
}

void gltf_close(gltf *from)
{
	for (uint32_t i = 0; from->buffers && i < from->lists[GLTF_BUFFERS].count; i++)
		free(from->buffers[i].own);
	for (uint32_t i = 0; from->views && i < from->lists[GLTF_VIEWS].count; i++)
		free(from->views[i].own);
	for (uint32_t i = 0; from->unpacked && i < from->lists[GLTF_IMAGES].count; i++)
		free(from->unpacked[i]);
	for (uint32_t i = 0; i < from->parts.count; i++) {
		stilb_scene_mesh_finish(&from->parts.parts[i].mesh);
		scene_deform_finish(&from->parts.parts[i].deform);
	}
	for (int kind = 0; kind < GLTF_LIST_COUNT; kind++)
		free(from->lists[kind].items);
	free(from->buffers);
	free(from->views);
	free(from->shown);
	free(from->nodes);
	free(from->picture);
	free(from->unpacked);
	free(from->parts.parts);
	free(from->parts.first);
	scene_json_finish(&from->json);
	*from = (gltf){0};
}

stilb_result gltf_import(importer *import, const importer_bytes *bytes)
{
	static stilb_result (*const steps[])(gltf *) = {gltf_list_nodes,    gltf_load_textures, gltf_add_meshes,
	                                                gltf_add_materials, gltf_add_variants,  gltf_add_animation,
	                                                gltf_add_view};
	gltf from = {.import = import};
	stilb_result result = gltf_open(&from, bytes);
	for (size_t s = 0; result == STILB_OK && s < sizeof steps / sizeof *steps; s++) {
		result = steps[s](&from);
		if (result == STILB_OK)
			result = scene_json_check(&from.json);
	}
	if (result == STILB_OK)
		gltf_tell_extensions(&from);
	gltf_close(&from);
	return result;
}
