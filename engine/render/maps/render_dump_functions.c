/* The parts of a dump that functions of surfaces need: their names, and the code of each. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <string.h>

static const render_function *dump_function(const stilb_render *render, uint32_t index)
{
	const render_function *function = render->device->programs.functions[index];
	STILB_ASSERT(function && "a material names it");
	return function;
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

void render_dump_functions_note(const stilb_render *render, uint32_t material, render_dump_functions *functions)
{
	uint32_t index = render_dump_surface_function(&render->resources, material);
	if (index == 0 || functions->place[index] > 0)
		return;
	const render_function *function = dump_function(render, index);
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++)
		functions->bytes += function->own.codes[c].bytes;
	functions->index[functions->count] = (uint16_t)index;
	functions->place[index] = (uint16_t)++functions->count;
}

void render_dump_functions_put(const stilb_render *render, const render_dump_functions *functions,
                               render_dump_function *out, uint8_t *code)
{
	for (uint32_t f = 0; f < functions->count; f++, out++) {
		const stilb_scene_function *own = &dump_function(render, functions->index[f])->own;
		memcpy(out->name, own->name, strlen(own->name));
		out->shaders = own->shaders;
		for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++) {
			out->bytes[c] = (uint32_t)own->codes[c].bytes;
			memcpy(code, own->codes[c].words, own->codes[c].bytes);
			code += own->codes[c].bytes;
		}
	}
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* The function, which points into the file's bytes from `code` on; its sizes are sound. Returns the end of its code. */
static const uint8_t *dump_function_get(const render_dump_function *from, const uint8_t *code, stilb_scene_function *to)
{
	*to = (stilb_scene_function){.name = from->name, .shaders = from->shaders};
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++) {
		to->codes[c] = (stilb_scene_function_code){(const uint32_t *)(const void *)code, from->bytes[c]};
		code += from->bytes[c];
	}
	return code;
}

stilb_result render_dump_check_functions(const stilb_render_dump *dump)
{
	uint64_t bytes = 0;
	const uint8_t *code = dump->code;
	if (dump->header->functions > STILB_SCENE_MAX_FUNCTIONS)
		return stilb_fail(STILB_ERROR_FILE, "header: %u surface functions; there are 0..%u", dump->header->functions,
		                  STILB_SCENE_MAX_FUNCTIONS);
	for (uint32_t f = 0; f < dump->header->functions; f++) {
		const render_dump_function *function = &dump->functions[f];
		for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++) {
			if (function->bytes[c] % 4 != 0)
				return stilb_fail(STILB_ERROR_FILE, "surface function %u: code of %u bytes, no multiple of 4", f,
				                  function->bytes[c]);
			bytes += function->bytes[c];
		}
		if (!memchr(function->name, 0, sizeof function->name))
			return stilb_fail(STILB_ERROR_FILE, "surface function %u: its name has no end", f);
	}
	if (bytes != dump->header->function_bytes)
		return stilb_fail(STILB_ERROR_FILE, "header: %llu bytes of surface functions, but these have %llu",
		                  (unsigned long long)dump->header->function_bytes, (unsigned long long)bytes);
	for (uint32_t f = 0; f < dump->header->functions; f++) {
		stilb_scene_function function;
		code = dump_function_get(&dump->functions[f], code, &function);
		const char *mistake = stilb_scene_function_mistake(&function);
		if (mistake)
			return stilb_fail(STILB_ERROR_FILE, "surface function %u: %s", f, mistake);
	}
	return STILB_OK;
}

/* ---- playing ----------------------------------------------------------------------------------------------------- */

stilb_result render_dump_functions_upload(const stilb_render_dump *dump, stilb_render *render, uint32_t *indices)
{
	const uint8_t *code = dump->code;
	stilb_result result = STILB_OK;
	for (uint32_t f = 0; f < dump->header->functions && result == STILB_OK; f++) {
		stilb_scene_function function;
		code = dump_function_get(&dump->functions[f], code, &function);
		result = render_function_create(render, &function, &indices[f]);
	}
	return result;
}
