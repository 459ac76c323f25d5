/* Buffer views compressed by EXT_meshopt_compression, decompressed with meshoptimizer. */
#include "scene/importer/gltf/gltf.h"

#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

typedef struct meshopt_view {
	uint64_t count, stride;
	char mode[16], filter[16];
} meshopt_view;

/* True if the numbers are such that the format can have them; what the library asserts is among it. Ratios: of a
 * vertex's bytes at least two bits are stored for sixteen, of a triangle at least a byte, as of an index. */
static bool meshopt_is_possible(const meshopt_view *packed, uint64_t size)
{
	if (packed->count > UINT32_MAX || packed->stride == 0)
		return false;
	if (strcmp(packed->mode, "ATTRIBUTES") == 0)
		return packed->stride % 4 == 0 && packed->stride <= 256 && packed->count * packed->stride / 64 <= size;
	bool index = packed->stride == 2 || packed->stride == 4;
	if (strcmp(packed->mode, "TRIANGLES") == 0)
		return index && packed->count % 3 == 0 && packed->count / 3 <= size;
	return strcmp(packed->mode, "INDICES") == 0 && index && packed->count <= size;
}

static int meshopt_unpack(const meshopt_view *packed, const gltf_view *view, void *out)
{
	if (strcmp(packed->mode, "ATTRIBUTES") == 0)
		return meshopt_decodeVertexBuffer(out, packed->count, packed->stride, view->data, view->size);
	if (strcmp(packed->mode, "TRIANGLES") == 0)
		return meshopt_decodeIndexBuffer(out, packed->count, packed->stride, view->data, view->size);
	return meshopt_decodeIndexSequence(out, packed->count, packed->stride, view->data, view->size);
}

/* Applies the filter; false: it is unknown, or not for this stride. */
static bool meshopt_filter(const meshopt_view *packed, void *data)
{
	if (packed->filter[0] == '\0' || strcmp(packed->filter, "NONE") == 0)
		return true;
	if (strcmp(packed->filter, "OCTAHEDRAL") == 0 && (packed->stride == 4 || packed->stride == 8))
		meshopt_decodeFilterOct(data, packed->count, packed->stride);
	else if (strcmp(packed->filter, "QUATERNION") == 0 && packed->stride == 8)
		meshopt_decodeFilterQuat(data, packed->count, packed->stride);
	else if (strcmp(packed->filter, "EXPONENTIAL") == 0 && packed->stride % 4 == 0)
		meshopt_decodeFilterExp(data, packed->count, packed->stride);
	else
		return false;
	return true;
}

stilb_result gltf_meshopt_decode(gltf *from, uint32_t extension, gltf_view *view)
{
	STILB_ASSERT(view->data && !view->own);
	scene_json *json = &from->json;
	meshopt_view packed = {.count = scene_json_size(json, extension, "count", 0), .stride = view->stride};
	scene_json_string(json, extension, "mode", packed.mode, sizeof packed.mode);
	scene_json_string(json, extension, "filter", packed.filter, sizeof packed.filter);
	uint32_t index = (uint32_t)(view - from->views);
	bool possible = !json->fault[0] && meshopt_is_possible(&packed, view->size);
	if (!possible)
		return stilb_fail(STILB_ERROR_FILE, "the compression of buffer view %u has an impossible mode, count or stride",
		                  index);
	/* The filters work on up to eight elements at a time. */
	unsigned char *out = stilb_memory_alloc(packed.count + 8, packed.stride);
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for buffer view %u", index);
	bool good = meshopt_unpack(&packed, view, out) == 0 && meshopt_filter(&packed, out);
	if (!good) {
		free(out);
		return stilb_fail(STILB_ERROR_FILE, "buffer view %u does not decompress: it is damaged", index);
	}
	*view = (gltf_view){.data = out, .size = packed.count * packed.stride, .stride = view->stride, .own = out};
	return STILB_OK;
}
