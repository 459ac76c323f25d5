/* Whether a function of surfaces fits the programs that it may be in. */
#include "render/render_internal.h"

#include <stdio.h>
#include <string.h>

/* The shader must write what its passes draw into: light also what is seen, beside it. */
static stilb_result function_check_output(const stilb_gpu_shader *shader, render_function_kind kind, const char *name)
{
	gpu_spirv found;
	static const uint8_t written[] = {
		[RENDER_FUNCTION_MAPS] = 0xf,  [RENDER_FUNCTION_THROUGH] = 0xf,  [RENDER_FUNCTION_CHANNEL] = 0x1,
		[RENDER_FUNCTION_DEPTH] = 0x0, [RENDER_FUNCTION_VELOCITY] = 0x1, [RENDER_FUNCTION_SEEN] = 0x7};
	uint32_t outputs = written[kind]; /* bits */
	if (!gpu_spirv_read(shader, &found) || found.no_memory)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for reading the shaders of '%s'", name);
	if (found.outputs == outputs)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT, "'%s': a fragment shader writes other colours than its passes have", name);
}

/* Checks one of its shaders in a program like those that it will be in. */
static stilb_result function_check_code(render_device *device, const stilb_scene_function *from, const char *name,
                                        uint32_t code)
{
	render_function_kind kind = code >= RENDER_FUNCTION_SEEN       ? RENDER_FUNCTION_SEEN
	                            : code >= RENDER_FUNCTION_VELOCITY ? RENDER_FUNCTION_VELOCITY
	                            : code >= RENDER_FUNCTION_DEPTH    ? RENDER_FUNCTION_DEPTH
	                            : code >= RENDER_FUNCTION_CHANNEL  ? RENDER_FUNCTION_CHANNEL
	                            : code >= RENDER_FUNCTION_THROUGH  ? RENDER_FUNCTION_THROUGH
	                                                               : RENDER_FUNCTION_MAPS;
	bool extras = code & 1u, channel = kind == RENDER_FUNCTION_CHANNEL, through = kind == RENDER_FUNCTION_THROUGH;
	bool depth = code >= RENDER_FUNCTION_DEPTH;
	bool layers = through || (kind == RENDER_FUNCTION_MAPS && code & 8u) || (depth && code & 2u);
	bool gloss = (kind == RENDER_FUNCTION_MAPS && code & 4u) || (through && code & 2u);
	stilb_gpu_program_desc desc = {
		.name = name,
		.vertex = channel ? render_function_channel_vertex[device->packed][extras]
	                      : render_function_vertex[layers][device->packed][extras],
		.fragment = {.words = from->codes[code].words, .bytes = from->codes[code].bytes},
		.samplers = (uint8_t)(3 * gloss + (!depth && !channel) + through), /* in between: of shadows */
		.set_items = layers ? RENDER_MAPS : RENDER_MAPS_PLAIN,
		.depth = STILB_GPU_COMPARE_GREATER,
	};
	render_program_vertices(device, RENDER_SURFACE_TEXTURE, &desc);
	for (uint32_t c = 0; c < 9; c++)
		desc.constants[desc.constant_count++].id = 1 + c;
	stilb_result result = gpu_check_program(device->gpu, &desc);
	return result == STILB_OK ? function_check_output(&desc.fragment, kind, name) : result;
}

stilb_result render_function_make(render_device *device, const stilb_scene_function *from, render_function **out)
{
	const char *mistake = stilb_scene_function_mistake(from);
	char name[STILB_SCENE_FUNCTION_NAME + 32];
	*out = NULL;
	snprintf(name, sizeof name, "surface function %.63s", from->name ? from->name : "");
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "'%s': %s", name, mistake);
	stilb_result result = STILB_OK;
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES && result == STILB_OK; c++)
		result = function_check_code(device, from, name, c);
	if (result != STILB_OK)
		return result;
	render_function *function = calloc(1, sizeof *function);
	if (!function)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for '%s'", name);
	result = stilb_scene_function_copy(from, &function->own);
	if (result != STILB_OK) {
		free(function);
		return result;
	}
	function->hash = render_function_hash(from);
	memcpy(function->program, name, sizeof name);
	*out = function;
	return STILB_OK;
}
