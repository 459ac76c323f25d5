#include "scene/function/scene_function.h"

#include <stdlib.h>
#include <string.h>

/* SCENE_FUNCTION_SHADERS is given by CMakeLists.txt. */

/* Khronos, SPIR-V Specification 1.6, section 2.3: physical layout. */
#define SPIRV_MAGIC 0x07230203u
#define SPIRV_VERSION_MOST 0x00010600u /* what Vulkan 1.3 takes */
#define SPIRV_HEADER 5u                /* words */
#define SPIRV_MOST_IDS (1u << 20)
enum { OP_ENTRY_POINT = 15, OP_FUNCTION_END = 56, MODEL_FRAGMENT = 4 };

uint64_t stilb_scene_function_shaders(void)
{
	return SCENE_FUNCTION_SHADERS;
}

static bool function_name_is_sound(const char *name)
{
	size_t length = name ? strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") : 0;
	return length > 0 && length <= STILB_SCENE_FUNCTION_NAME && name[length] == '\0';
}

/* True if the instruction of so many words is the entry point "main" of a fragment shader. */
static bool code_is_entry(const uint32_t *words, uint32_t count)
{
	static const char name[8] = "main"; /* with zeros to the end of the word */
	return (words[0] & 0xffffu) == OP_ENTRY_POINT && count >= 5 && words[1] == MODEL_FRAGMENT &&
	       memcmp(words + 3, name, sizeof name) == 0;
}

static const char *code_mistake(const stilb_scene_function_code *code)
{
	if (!code->words || code->bytes == 0)
		return "a shader is missing";
	size_t count = code->bytes / sizeof *code->words;
	if (code->bytes % sizeof *code->words != 0 || code->bytes > STILB_SCENE_FUNCTION_CODE_BYTES)
		return "a shader's size is no multiple of 4, or above 16 MiB";
	if (count < SPIRV_HEADER || code->words[0] != SPIRV_MAGIC)
		return "a shader is not SPIR-V";
	if (code->words[1] > SPIRV_VERSION_MOST || code->words[1] < 0x00010000u || code->words[1] & 0xffu)
		return "a shader is SPIR-V of another version than 1.0 to 1.6";
	if (code->words[3] == 0 || code->words[3] > SPIRV_MOST_IDS || code->words[4] != 0)
		return "a shader's header is damaged";
	uint32_t entries = 0, last = OP_FUNCTION_END;
	for (size_t at = SPIRV_HEADER; at < count;) {
		uint32_t words = code->words[at] >> 16;
		if (words == 0 || words > count - at)
			return "a shader is cut off, or its instructions are damaged";
		entries += code_is_entry(code->words + at, words);
		last = code->words[at] & 0xffffu;
		at += words;
	}
	if (last != OP_FUNCTION_END)
		return "a shader is cut off: its last function has no end";
	return entries == 1 ? NULL : "a shader has no entry point 'main' for fragments, or several";
}

const char *stilb_scene_function_mistake(const stilb_scene_function *function)
{
	STILB_ASSERT(function);
	const char *mistake = NULL;
	if (!function_name_is_sound(function->name))
		return "its name is not 1 to 63 letters, digits and _";
	if (function->shaders != SCENE_FUNCTION_SHADERS)
		return "it was compiled with the shaders of another Stilb; build the program again";
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES && !mistake; c++)
		mistake = code_mistake(&function->codes[c]);
	return mistake;
}

stilb_result stilb_scene_function_copy(const stilb_scene_function *from, stilb_scene_function *to)
{
	STILB_ASSERT(from && to && !stilb_scene_function_mistake(from));
	size_t name = strlen(from->name) + 1, bytes = name;
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++)
		bytes += from->codes[c].bytes;
	uint8_t *at = malloc(bytes);
	*to = (stilb_scene_function){0};
	if (!at)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the surface function '%s' of %zu bytes", from->name,
		                  bytes);
	to->shaders = from->shaders;
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++) { /* the first one begins the block */
		to->codes[c] = (stilb_scene_function_code){(const uint32_t *)(const void *)at, from->codes[c].bytes};
		memcpy(at, from->codes[c].words, from->codes[c].bytes);
		at += from->codes[c].bytes;
	}
	to->name = memcpy(at, from->name, name);
	return STILB_OK;
}

void stilb_scene_function_finish(stilb_scene_function *copy)
{
	STILB_ASSERT(copy);
	free((void *)copy->codes[0].words);
	*copy = (stilb_scene_function){0};
}
