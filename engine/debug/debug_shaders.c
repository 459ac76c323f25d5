/* SPIR-V that the build makes from shaders/. There is no function here: gcc's analyzer keeps the value of each word. */
#include "debug/debug_internal.h"
#include "shader_sources.h"

static const uint32_t debug_vert[] =
#include "debug.vert.inc"
	;
static const uint32_t debug_frag[] =
#include "debug.frag.inc"
	;
static const uint32_t debug_samples_frag[] =
#include "debug_samples.frag.inc"
	;

const stilb_gpu_shader debug_shader_vertex = {debug_vert, sizeof debug_vert, SOURCE_debug_vert};
const stilb_gpu_shader debug_shader_fragment[2] = {
	{debug_frag, sizeof debug_frag, SOURCE_debug_frag},
	{debug_samples_frag, sizeof debug_samples_frag, SOURCE_debug_samples_frag},
};
