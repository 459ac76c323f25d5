/* SPIR-V of reflections. */
#include "post/post_internal.h"
#include "shader_sources.h"

static const uint32_t reflections_light_frag[] =
#include "reflections_light.frag.inc"
	;
static const uint32_t reflections_nearest_frag[] =
#include "reflections_nearest.frag.inc"
	;
static const uint32_t reflections_place_frag[] =
#include "reflections_place.frag.inc"
	;
static const uint32_t reflections_trace_frag[] =
#include "reflections_trace.frag.inc"
	;
static const uint32_t reflections_apply_frag[] =
#include "reflections_apply.frag.inc"
	;

const stilb_gpu_shader post_shader_reflections_light = {reflections_light_frag, sizeof reflections_light_frag,
                                                        SOURCE_reflections_light_frag};
const stilb_gpu_shader post_shader_reflections_nearest = {reflections_nearest_frag, sizeof reflections_nearest_frag,
                                                          SOURCE_reflections_nearest_frag};
const stilb_gpu_shader post_shader_reflections_place = {reflections_place_frag, sizeof reflections_place_frag,
                                                        SOURCE_reflections_place_frag};
const stilb_gpu_shader post_shader_reflections_trace = {reflections_trace_frag, sizeof reflections_trace_frag,
                                                        SOURCE_reflections_trace_frag};
const stilb_gpu_shader post_shader_reflections_apply = {reflections_apply_frag, sizeof reflections_apply_frag,
                                                        SOURCE_reflections_apply_frag};
