/* gpu: what a shader's SPIR-V says of its bindings, of what its stage is given and hands on, and of its constants
 * (Khronos, SPIR-V Specification 1.6, section 3: binary form). */
#include "gpu/gpu_internal.h"
#include "gpu/spirv/gpu_spirv_words.h"

#include <stdlib.h>

#define SPIRV_ADDRESS 8u /* bytes of a buffer's address */

typedef enum spirv_kind { SPIRV_OTHER, SPIRV_SAMPLED, SPIRV_STORAGE, SPIRV_ARRAY, SPIRV_STRUCT } spirv_kind;

typedef struct spirv_id {
	uint8_t kind;            /* spirv_kind of a type */
	bool integer;            /* of a type: its scalars are */
	bool built_in;           /* of a struct: members are built-in variables */
	bool block;              /* of a struct: it is a buffer's, which is not written */
	uint16_t width;          /* bits of a type's scalars */
	uint32_t set;            /* + 1 of a variable; 0: none */
	uint32_t binding;        /* + 1 */
	uint32_t location;       /* + 1 */
	uint32_t constant;       /* its number + 1, of a specialization constant */
	uint32_t points;         /* the type that a pointer points to */
	uint32_t value;          /* of a constant that is no specialization constant */
	uint32_t places;         /* locations that a value of the type takes */
	uint32_t bytes;          /* that it takes in memory, at least */
	uint32_t stride;         /* of an array */
	uint32_t member, offset; /* of a struct: its last member in memory, and where that begins */
} spirv_id;

/* Bits of so many locations. */
static uint32_t spirv_places(uint32_t first, uint32_t count)
{
	return count >= 32 ? UINT32_MAX << first : ((1u << count) - 1) << first;
}

/* A variable that a stage is given, or that it hands on. */
static void spirv_interface(const spirv_id *ids, uint32_t type, uint32_t variable, uint32_t class, gpu_spirv *out)
{
	const spirv_id *value = &ids[ids[type].points];
	bool in = class == CLASS_INPUT;
	if (ids[variable].location == 0) {
		if (!in && value->kind == SPIRV_STRUCT && !value->built_in)
			out->outputs = UINT32_MAX; /* members have locations: they are not looked at */
		return;
	}
	uint32_t first = ids[variable].location - 1;
	if (first >= 32) {
		out->wrong = "an input or output at a location above 31";
		return;
	}
	uint32_t places = spirv_places(first, in && value->kind == SPIRV_STRUCT ? 0 : value->places);
	if (in)
		out->inputs |= places;
	else
		out->outputs |= value->kind == SPIRV_STRUCT ? UINT32_MAX : places;
	if (in && value->integer)
		out->integer_inputs |= places;
}

/* A uniform buffer. */
static void spirv_uniform(const spirv_id *block, uint32_t set, uint32_t binding, gpu_spirv *out)
{
	if (set == 2)
		out->wrong = "a uniform buffer in set 1";
	out->uniforms |= 1u << (binding - 1);
	out->uniform_bytes = block->bytes > out->uniform_bytes ? block->bytes : out->uniform_bytes;
}

static void spirv_variable(const spirv_id *ids, uint32_t type, uint32_t variable, uint32_t class, gpu_spirv *out)
{
	uint32_t set = ids[variable].set, binding = ids[variable].binding;
	if (class == CLASS_INPUT || class == CLASS_OUTPUT) {
		spirv_interface(ids, type, variable, class, out);
		return;
	}
	if (class == CLASS_PUSH_CONSTANT && ids[ids[type].points].bytes > STILB_GPU_MAX_CONSTANTS) {
		out->wrong = "more than 128 bytes of push constants";
		return;
	}
	const spirv_id *value = &ids[ids[type].points];
	if (class == CLASS_STORAGE_BUFFER || (class == CLASS_UNIFORM && !value->block && value->kind == SPIRV_STRUCT)) {
		out->wrong = "a storage buffer in a set: buffers that are no uniform ones are read by their addresses";
		return;
	}
	if ((class != CLASS_UNIFORM_CONSTANT && class != CLASS_UNIFORM) || binding == 0)
		return;
	uint8_t kind = value->kind;
	if (binding > 32 || set > 2)
		out->wrong = "a binding above 31, or a set above 1";
	else if (kind == SPIRV_ARRAY)
		out->wrong = "an array of images or buffers in a binding";
	else if (class == CLASS_UNIFORM)
		spirv_uniform(value, set, binding, out);
	else if (kind == SPIRV_STORAGE && set == 2)
		out->wrong = "a storage image in set 1";
	else if (kind == SPIRV_OTHER)
		out->wrong = "a binding that is neither a sampler2D or the like nor a storage image";
	else if (set == 2)
		out->items |= 1u << (binding - 1);
	else if (kind == SPIRV_SAMPLED)
		out->sampled |= 1u << (binding - 1);
	else
		out->storage |= 1u << (binding - 1);
}

/* A type of so many of another, which lie this far apart. */
static void spirv_repeat(spirv_id *ids, uint32_t type, uint32_t of, uint32_t count, uint32_t stride)
{
	uint64_t places = (uint64_t)ids[of].places * count,
			 bytes = ids[of].bytes + (uint64_t)(count - (count > 0)) * stride;
	ids[type].integer = ids[of].integer;
	ids[type].width = ids[of].width;
	ids[type].places = places < 32 ? (uint32_t)places : 32;
	ids[type].bytes = bytes < UINT32_MAX ? (uint32_t)bytes : UINT32_MAX;
}

/* The instruction of a type; its words are there, and numbers of other types are below bound. */
static void spirv_type(const uint32_t *words, uint32_t count, spirv_id *ids)
{
	spirv_id *type = &ids[words[1]];
	switch (words[0] & 0xffffu) {
	case OP_TYPE_BOOL:
		type->width = 32;
		break;
	case OP_TYPE_INT:
	case OP_TYPE_FLOAT:
		type->integer = (words[0] & 0xffffu) == OP_TYPE_INT;
		type->width = (uint16_t)words[2];
		type->places = 1;
		type->bytes = words[2] / 8;
		break;
	case OP_TYPE_VECTOR:
		spirv_repeat(ids, words[1], words[2], words[3], ids[words[2]].bytes);
		type->places = ids[words[2]].width > 32 && words[3] > 2 ? 2 : 1;
		break;
	case OP_TYPE_MATRIX:
		spirv_repeat(ids, words[1], words[2], words[3], 16);
		break;
	case OP_TYPE_ARRAY:
		spirv_repeat(ids, words[1], words[2], ids[words[3]].value, type->stride);
		type->kind = SPIRV_ARRAY;
		break;
	case OP_TYPE_RUNTIME_ARRAY:
		type->kind = SPIRV_ARRAY;
		break;
	case OP_TYPE_IMAGE:
		type->kind = words[7] == 2 ? SPIRV_STORAGE : SPIRV_OTHER;
		break;
	case OP_TYPE_SAMPLED_IMAGE:
		type->kind = SPIRV_SAMPLED;
		break;
	case OP_TYPE_STRUCT:
		type->kind = SPIRV_STRUCT;
		if (type->member + 2 < count)
			type->bytes = type->offset + ids[words[2 + type->member]].bytes;
		break;
	case OP_TYPE_FORWARD_POINTER:
		type->bytes = SPIRV_ADDRESS;
		break;
	default:
		type->points = words[3];
		type->bytes = SPIRV_ADDRESS;
		break;
	}
}

static void spirv_decorate(const uint32_t *words, uint32_t count, spirv_id *id)
{
	uint32_t value = count >= 4 ? words[3] : 0;
	id->block |= words[2] == DECORATION_BLOCK;
	switch (count >= 4 ? words[2] : UINT32_MAX) {
	case DECORATION_BINDING:
		id->binding = value < 32 ? value + 1 : 33;
		break;
	case DECORATION_SET:
		id->set = value < 2 ? value + 1 : 3;
		break;
	case DECORATION_LOCATION:
		id->location = value < 32 ? value + 1 : 33;
		break;
	case DECORATION_SPEC_ID:
		id->constant = value < UINT32_MAX ? value + 1 : 0;
		break;
	case DECORATION_ARRAY_STRIDE:
		id->stride = value;
		break;
	default:
		break;
	}
}

static void spirv_member(const uint32_t *words, uint32_t count, spirv_id *id)
{
	id->built_in |= words[3] == DECORATION_BUILT_IN;
	if (words[3] == DECORATION_OFFSET && count >= 5 && words[4] >= id->offset) {
		id->offset = words[4] < UINT32_MAX / 2 ? words[4] : UINT32_MAX / 2;
		id->member = words[2];
	}
}

static void spirv_constant(const spirv_id *id, const spirv_id *type, gpu_spirv *out)
{
	if (id->constant > 0 && type->width != 32)
		out->wide_constant = id->constant;
}

/* Numbers of types are below bound. */
static bool spirv_types_are_below(const uint32_t *words, uint32_t count, uint32_t op, uint32_t bound)
{
	switch (op) {
	case OP_TYPE_VECTOR:
	case OP_TYPE_MATRIX:
		return words[2] < bound;
	case OP_TYPE_ARRAY:
		return words[2] < bound && words[3] < bound;
	case OP_TYPE_POINTER:
		return words[3] < bound;
	case OP_TYPE_STRUCT:
		for (uint32_t m = 2; m < count; m++)
			if (words[m] >= bound)
				return false;
		return true;
	default:
		return true;
	}
}

/* One instruction of `count` words, at least 1. False: it is broken. */
static bool spirv_instruction(const uint32_t *words, uint32_t count, spirv_id *ids, uint32_t bound,
                              uint32_t size_ids[3], gpu_spirv *out)
{
	uint32_t op = words[0] & 0xffffu;
	static const uint8_t least[OP_EXECUTION_MODE_ID + 1] = {
		[OP_EXECUTION_MODE] = 3,       [OP_TYPE_BOOL] = 2,     [OP_TYPE_INT] = 4,           [OP_TYPE_FLOAT] = 3,
		[OP_TYPE_VECTOR] = 4,          [OP_TYPE_MATRIX] = 4,   [OP_TYPE_IMAGE] = 9,         [OP_TYPE_SAMPLED_IMAGE] = 3,
		[OP_TYPE_FORWARD_POINTER] = 3, [OP_TYPE_ARRAY] = 4,    [OP_TYPE_RUNTIME_ARRAY] = 3, [OP_TYPE_STRUCT] = 2,
		[OP_TYPE_POINTER] = 4,         [OP_CONSTANT] = 4,      [OP_SPEC_CONSTANT_TRUE] = 3, [OP_VARIABLE] = 4,
		[OP_SPEC_CONSTANT_FALSE] = 3,  [OP_SPEC_CONSTANT] = 4, [OP_DECORATE] = 3,           [OP_MEMBER_DECORATE] = 4,
		[OP_EXECUTION_MODE_ID] = 3,
	};
	uint32_t needed = op < sizeof least ? least[op] : 0;
	if (needed == 0)
		return true;
	if (count < needed || words[1] >= bound)
		return false;
	switch (op) {
	case OP_EXECUTION_MODE:
		for (uint32_t i = 0; words[2] == MODE_LOCAL_SIZE && count >= 6 && i < 3; i++)
			out->group_size[i] = words[3 + i];
		return true;
	case OP_EXECUTION_MODE_ID: /* constants come later: here are their numbers */
		for (uint32_t i = 0; words[2] == MODE_LOCAL_SIZE_ID && count >= 6 && i < 3; i++)
			size_ids[i] = words[3 + i] < bound ? words[3 + i] : 0;
		return true;
	case OP_CONSTANT:
		if (words[2] < bound)
			ids[words[2]].value = words[3];
		return words[2] < bound;
	case OP_SPEC_CONSTANT:
	case OP_SPEC_CONSTANT_TRUE:
	case OP_SPEC_CONSTANT_FALSE:
		if (words[2] < bound)
			spirv_constant(&ids[words[2]], &ids[words[1]], out);
		return words[2] < bound;
	case OP_DECORATE:
		spirv_decorate(words, count, &ids[words[1]]);
		return true;
	case OP_MEMBER_DECORATE:
		spirv_member(words, count, &ids[words[1]]);
		return true;
	case OP_VARIABLE:
		if (words[2] >= bound)
			return false;
		spirv_variable(ids, words[1], words[2], words[3], out);
		return true;
	default:
		if (!spirv_types_are_below(words, count, op, bound))
			return false;
		spirv_type(words, count, ids);
		return true;
	}
}

bool gpu_spirv_read(const stilb_gpu_shader *shader, gpu_spirv *out)
{
	size_t count = shader->bytes / sizeof *shader->words;
	*out = (gpu_spirv){0};
	if (shader->bytes % sizeof *shader->words != 0 || count < 5 || shader->words[0] != SPIRV_MAGIC)
		return false;
	uint32_t bound = shader->words[3];
	if (bound == 0 || bound > SPIRV_MOST_IDS)
		return false;
	spirv_id *ids = calloc(bound, sizeof *ids);
	if (!ids) {
		out->no_memory = true;
		return true;
	}
	bool good = true;
	uint32_t size_ids[3] = {0};
	for (size_t at = 5; at < count && good;) {
		uint32_t words = shader->words[at] >> 16;
		good =
			words > 0 && words <= count - at && spirv_instruction(shader->words + at, words, ids, bound, size_ids, out);
		at += words;
	}
	for (uint32_t i = 0; i < 3 && size_ids[0] != 0; i++)
		out->group_size[i] = ids[size_ids[i]].value;
	free(ids);
	return good;
}
