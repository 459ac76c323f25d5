/* gpu: what a shader's SPIR-V says of its bindings (Khronos, SPIR-V Specification 1.6, section 3: binary form). */
#include "gpu/gpu_internal.h"

#include <stdlib.h>

#define SPIRV_MAGIC 0x07230203u
#define SPIRV_MOST_IDS (1u << 20)

enum {
	OP_EXECUTION_MODE = 16,
	OP_TYPE_IMAGE = 25,
	OP_TYPE_SAMPLED_IMAGE = 27,
	OP_TYPE_ARRAY = 28,
	OP_TYPE_RUNTIME_ARRAY = 29,
	OP_TYPE_POINTER = 32,
	OP_VARIABLE = 59,
	OP_CONSTANT = 43,
	OP_DECORATE = 71,
	OP_EXECUTION_MODE_ID = 331,
	MODE_LOCAL_SIZE_ID = 38,
	MODE_LOCAL_SIZE = 17,
	DECORATION_BINDING = 33,
	DECORATION_SET = 34,
	CLASS_UNIFORM_CONSTANT = 0,
	CLASS_UNIFORM = 2,
	CLASS_STORAGE_BUFFER = 12,
};

typedef enum spirv_kind { SPIRV_OTHER, SPIRV_SAMPLED, SPIRV_STORAGE, SPIRV_ARRAY } spirv_kind;

typedef struct spirv_id {
	uint8_t kind;     /* spirv_kind of a type */
	uint32_t set;     /* + 1 of a variable; 0: none */
	uint32_t binding; /* + 1 */
	uint32_t points;  /* the type that a pointer points to */
	uint32_t value;   /* of a constant that is no specialization constant */
} spirv_id;

static void spirv_variable(const spirv_id *ids, uint32_t type, uint32_t variable, uint32_t class, gpu_spirv *out)
{
	uint32_t set = ids[variable].set, binding = ids[variable].binding;
	if (class == CLASS_UNIFORM || class == CLASS_STORAGE_BUFFER) {
		out->wrong = "a buffer in a set: buffers are read by their addresses";
		return;
	}
	if (class != CLASS_UNIFORM_CONSTANT || binding == 0)
		return;
	uint8_t kind = ids[ids[type].points].kind;
	if (binding > 32 || set > 2)
		out->wrong = "a binding above 31, or a set above 1";
	else if (kind == SPIRV_ARRAY)
		out->wrong = "an array of images in a binding";
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

/* One instruction of `count` words, at least 1. False: it is broken. */
static bool spirv_instruction(const uint32_t *words, uint32_t count, spirv_id *ids, uint32_t bound,
                              uint32_t size_ids[3], gpu_spirv *out)
{
	uint32_t op = words[0] & 0xffffu;
	static const uint8_t least[OP_EXECUTION_MODE_ID + 1] = {
		[OP_EXECUTION_MODE] = 3,     [OP_TYPE_IMAGE] = 9,        [OP_TYPE_SAMPLED_IMAGE] = 3, [OP_TYPE_ARRAY] = 4,
		[OP_TYPE_RUNTIME_ARRAY] = 3, [OP_TYPE_POINTER] = 4,      [OP_CONSTANT] = 4,           [OP_VARIABLE] = 4,
		[OP_DECORATE] = 3,           [OP_EXECUTION_MODE_ID] = 3,
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
	case OP_TYPE_IMAGE:
		ids[words[1]].kind = words[7] == 2 ? SPIRV_STORAGE : SPIRV_OTHER;
		return true;
	case OP_TYPE_SAMPLED_IMAGE:
		ids[words[1]].kind = SPIRV_SAMPLED;
		return true;
	case OP_TYPE_ARRAY:
	case OP_TYPE_RUNTIME_ARRAY:
		ids[words[1]].kind = SPIRV_ARRAY;
		return true;
	case OP_TYPE_POINTER:
		ids[words[1]].points = words[3] < bound ? words[3] : 0;
		return true;
	case OP_DECORATE:
		if (count >= 4 && words[2] == DECORATION_BINDING)
			ids[words[1]].binding = words[3] < 32 ? words[3] + 1 : 33;
		if (count >= 4 && words[2] == DECORATION_SET)
			ids[words[1]].set = words[3] < 2 ? words[3] + 1 : 3;
		return true;
	default:
		if (words[2] >= bound)
			return false;
		spirv_variable(ids, words[1], words[2], words[3], out);
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
