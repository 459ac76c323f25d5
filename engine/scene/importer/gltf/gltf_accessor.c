/* Accessors: the numbers of a glTF file. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* glTF's componentType. */
enum { GLTF_BYTE = 5120, GLTF_UBYTE, GLTF_SHORT, GLTF_USHORT, GLTF_INT, GLTF_UINT, GLTF_FLOAT };

#define ACCESSOR_MOST (1ull << 28) /* elements: a mesh may not have more vertices (scene_stream.c) */

/* Elements of an accessor without a view, which are 0 and take no room in the file: this many, or so many times the
 * bytes of the file. Those of sparse accessors stand beside others that have data. */
#define ACCESSOR_EMPTY_MOST 65536ull
#define ACCESSOR_EMPTY_TIMES 64ull

/* Bytes of a component; 0: there is no such type. */
static uint32_t accessor_bytes(uint64_t type)
{
	static const uint32_t bytes[] = {1, 1, 2, 2, 4, 4, 4};
	return type >= GLTF_BYTE && type <= GLTF_FLOAT ? bytes[type - GLTF_BYTE] : 0;
}

/* The numbers of an element; 0: there is no such kind. */
static uint32_t accessor_components(gltf *from, uint32_t item)
{
	static const struct {
		const char *name;
		uint32_t components;
	} kinds[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
	uint32_t token = scene_json_member(&from->json, item, "type");
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		if (scene_json_is(&from->json, token, kinds[i].name))
			return kinds[i].components;
	return 0;
}

/* Points *data to `count` elements of `bytes` bytes each that begin `offset` bytes into the view of the object's key
 * bufferView. *stride: as the view has it, or bytes. whose: for messages. */
static stilb_result accessor_range(gltf *from, uint32_t index, uint32_t object, uint64_t count, uint64_t bytes,
                                   const unsigned char **data, uint32_t *stride)
{
	const gltf_view *view;
	uint32_t number = gltf_reference(from, object, "bufferView", GLTF_VIEWS);
	uint64_t offset = scene_json_size(&from->json, object, "byteOffset", 0);
	if (from->json.fault[0] || number == GLTF_NONE)
		return from->json.fault[0] ? scene_json_check(&from->json)
		                           : stilb_fail(STILB_ERROR_FILE, "accessor %u names no buffer view", index);
	stilb_result result = gltf_view_use(from, number, &view);
	if (result != STILB_OK)
		return result;
	*stride = view->stride ? view->stride : (uint32_t)bytes;
	uint64_t needed = count ? (count - 1) * *stride + bytes : 0; /* count <= 2^28, stride <= 4096 */
	if (offset > view->size || needed > view->size - offset)
		return stilb_fail(
			STILB_ERROR_FILE, "accessor %u needs %llu bytes from byte %llu on, but buffer view %u has %llu", index,
			(unsigned long long)needed, (unsigned long long)offset, number, (unsigned long long)view->size);
	*data = view->data + offset;
	return STILB_OK;
}

/* The place of a sparse accessor's element i in the accessor, which must be < count. */
static stilb_result accessor_place(uint32_t index, const gltf_accessor *places, uint64_t i, uint64_t count,
                                   uint64_t *place)
{
	*place = gltf_accessor_index(places, i);
	return *place < count ? STILB_OK
	                      : stilb_fail(STILB_ERROR_FILE, "accessor %u is sparse and replaces its element %llu of %llu",
	                                   index, (unsigned long long)*place, (unsigned long long)count);
}

/* Replaces the accessor's data by a copy in floats, with the elements that `sparse` replaces. */
static stilb_result accessor_make_dense(gltf *from, uint32_t index, uint32_t sparse, gltf_accessor *accessor)
{
	scene_json *json = &from->json;
	gltf_accessor places = {.components = 1}, values = *accessor;
	uint32_t where = scene_json_member(json, sparse, "indices"), what = scene_json_member(json, sparse, "values");
	uint64_t count = scene_json_size(json, sparse, "count", 0), type = scene_json_size(json, where, "componentType", 0);
	uint32_t bytes = accessor_bytes(type), size = accessor->components;
	if (json->fault[0])
		return scene_json_check(json);
	if (where == GLTF_NONE || what == GLTF_NONE || bytes == 0 || type == GLTF_FLOAT || count > accessor->count)
		return stilb_fail(STILB_ERROR_FILE, "accessor %u is sparse without sound indices and values", index);
	places.type = (uint32_t)type;
	places.count = values.count = count;
	stilb_result result = accessor_range(from, index, where, count, bytes, &places.data, &places.stride);
	if (result == STILB_OK)
		result = accessor_range(from, index, what, count, (uint64_t)accessor_bytes(accessor->type) * size, &values.data,
		                        &values.stride);
	if (result != STILB_OK)
		return result;
	float *dense = malloc((accessor->count * size + 1) * sizeof *dense);
	if (!dense)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for accessor %u", index);
	for (uint64_t i = 0; i < accessor->count; i++)
		gltf_accessor_read(accessor, i, dense + i * size);
	for (uint64_t i = 0, place = 0; result == STILB_OK && i < count; i++) {
		result = accessor_place(index, &places, i, accessor->count, &place);
		if (result == STILB_OK)
			gltf_accessor_read(&values, i, dense + place * size);
	}
	accessor->own = dense;
	accessor->data = (const unsigned char *)dense;
	accessor->type = GLTF_FLOAT;
	accessor->stride = size * (uint32_t)sizeof *dense;
	return result;
}

stilb_result gltf_accessor_open(gltf *from, uint32_t index, uint32_t components, gltf_accessor *accessor)
{
	STILB_ASSERT(index < from->lists[GLTF_ACCESSORS].count);
	scene_json *json = &from->json;
	uint32_t item = from->lists[GLTF_ACCESSORS].items[index], sparse = scene_json_member(json, item, "sparse");
	uint64_t type = scene_json_size(json, item, "componentType", 0);
	gltf_accessor made = {
		.count = scene_json_size(json, item, "count", 0),
		.components = accessor_components(from, item),
		.type = (uint32_t)type,
		.normalized = scene_json_bool(json, item, "normalized", false),
	};
	*accessor = (gltf_accessor){0};
	if (json->fault[0])
		return scene_json_check(json);
	if (accessor_bytes(type) == 0 || made.components == 0)
		return stilb_fail(STILB_ERROR_FILE, "accessor %u has no known type", index);
	if (!(components >> (made.components - 1) & 1))
		return stilb_fail(STILB_ERROR_FILE, "accessor %u has %u numbers an element, which is wrong for its use", index,
		                  made.components);
	if (made.count > ACCESSOR_MOST)
		return stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu elements; %llu is the most", index,
		                  (unsigned long long)made.count, ACCESSOR_MOST);
	bool empty = scene_json_member(json, item, "bufferView") == GLTF_NONE;
	if (empty && made.count > ACCESSOR_EMPTY_MOST && made.count / ACCESSOR_EMPTY_TIMES > from->bytes)
		return stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu elements without data, in a file of %llu bytes",
		                  index, (unsigned long long)made.count, (unsigned long long)from->bytes);
	stilb_result result = STILB_OK;
	if (!empty)
		result = accessor_range(from, index, item, made.count, (uint64_t)accessor_bytes(type) * made.components,
		                        &made.data, &made.stride);
	if (result == STILB_OK && sparse != GLTF_NONE)
		result = accessor_make_dense(from, index, sparse, &made);
	if (result == STILB_OK)
		*accessor = made;
	else
		gltf_accessor_finish(&made);
	return result;
}

void gltf_accessor_finish(gltf_accessor *accessor)
{
	free(accessor->own);
	*accessor = (gltf_accessor){0};
}

/* The component at data as it is stored. Data may lie at any byte. */
static float accessor_component(const unsigned char *data, uint32_t type)
{
	union {
		int8_t byte;
		uint8_t ubyte;
		int16_t half;
		uint16_t uhalf;
		int32_t whole;
		uint32_t uwhole;
		float real;
	} value = {0};
	memcpy(&value, data, accessor_bytes(type));
	switch (type) {
	case GLTF_BYTE:
		return (float)value.byte;
	case GLTF_UBYTE:
		return (float)value.ubyte;
	case GLTF_SHORT:
		return (float)value.half;
	case GLTF_USHORT:
		return (float)value.uhalf;
	case GLTF_INT:
		return (float)value.whole;
	case GLTF_UINT:
		return (float)value.uwhole;
	default:
		return value.real;
	}
}

void gltf_accessor_read(const gltf_accessor *accessor, uint64_t i, float *out)
{
	STILB_ASSERT(i < accessor->count);
	/* glTF 2.0, 3.11: c / 127, c / 255, ..., those of signed types at least -1. */
	static const float scales[] = {1.0f / 127.0f,   1.0f / 255.0f,        1.0f / 32767.0f,
	                               1.0f / 65535.0f, 1.0f / 2147483647.0f, 1.0f / 4294967295.0f};
	uint32_t count = accessor->components;
	if (!accessor->data) {
		memset(out, 0, count * sizeof *out);
		return;
	}
	const unsigned char *data = accessor->data + i * accessor->stride;
	if (accessor->type == GLTF_FLOAT) {
		memcpy(out, data, count * sizeof *out);
		return;
	}
	uint32_t bytes = accessor_bytes(accessor->type);
	for (uint32_t k = 0; k < count; k++) {
		out[k] = accessor_component(data + (size_t)k * bytes, accessor->type);
		if (accessor->normalized)
			out[k] = fmaxf(out[k] * scales[accessor->type - GLTF_BYTE], -1.0f);
	}
}

uint32_t gltf_accessor_index(const gltf_accessor *accessor, uint64_t i)
{
	STILB_ASSERT(i < accessor->count);
	if (!accessor->data)
		return 0;
	const unsigned char *data = accessor->data + i * accessor->stride;
	uint32_t value;
	switch (accessor->type) {
	case GLTF_UBYTE:
		return data[0];
	case GLTF_USHORT:
		return (uint32_t)data[0] | (uint32_t)data[1] << 8;
	case GLTF_UINT:
		memcpy(&value, data, sizeof value);
		return value;
	default: {
		float number = accessor_component(data, accessor->type);
		return number >= 0.0f && number < 16777217.0f ? (uint32_t)number : GLTF_NONE;
	}
	}
}
