/* The shaders of test_gpu_replace.c and test_gpu_replace_null.c: shaders/replace.frag and replace.vert with
 * definitions. */
#ifndef REPLACE_SHADERS_H
#define REPLACE_SHADERS_H

#include "gpu/gpu.h"

static const uint32_t quarter_frag[] =
#include "replace_quarter.frag.inc"
	;
static const uint32_t half_frag[] =
#include "replace_half.frag.inc"
	;
static const uint32_t binding_frag[] =
#include "replace_binding.frag.inc"
	;
static const uint32_t place_frag[] =
#include "replace_place.frag.inc"
	;
static const uint32_t push_frag[] =
#include "replace_push.frag.inc"
	;
static const uint32_t wide_frag[] =
#include "replace_wide.frag.inc"
	;
static const uint32_t plain_vert[] =
#include "replace_plain.vert.inc"
	;
static const uint32_t place_vert[] =
#include "replace_place.vert.inc"
	;
static const uint32_t input_vert[] =
#include "replace_input.vert.inc"
	;
static const uint32_t integer_vert[] =
#include "replace_integer.vert.inc"
	;

#define SHADER_OF(code, from)                                                                                          \
	{                                                                                                                  \
		.words = code, .bytes = sizeof code, .source = from                                                            \
	}

#define FRAG "value.frag"
#define VERT "area.vert"

static const uint32_t replace_nonsense[] = {1, 2, 3, 4, 5, 6};

/* Shaders that no program of the tests fits, and what the message must say. */
static const struct {
	stilb_gpu_shader shader;
	const char *says;
} replace_wrong[] = {
	{SHADER_OF(binding_frag, FRAG), "binding 0 of set 0 of its fragment shader is not declared"},
	{SHADER_OF(place_frag, FRAG), "its fragment shader reads location 2, which"},
	{SHADER_OF(push_frag, FRAG), "more than 128 bytes of push constants"},
	{SHADER_OF(wide_frag, FRAG), "specialization constant 4 of its fragment shader has not 32 bits"},
	{SHADER_OF(replace_nonsense, FRAG), "no SPIR-V"},
};
#define REPLACE_WRONG (sizeof replace_wrong / sizeof *replace_wrong)

#endif
