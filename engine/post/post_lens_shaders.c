/* SPIR-V of depth of field. */
#include "post/post_internal.h"
#include "shader_sources.h"

static const uint32_t lens_light_frag[] =
#include "lens_light.frag.inc"
	;
static const uint32_t lens_halve_frag[] =
#include "lens_halve.frag.inc"
	;
static const uint32_t lens_tiles_frag[] =
#include "lens_tiles.frag.inc"
	;
static const uint32_t lens_reach_frag[] =
#include "lens_reach.frag.inc"
	;
static const uint32_t lens_gather_frag[] =
#include "lens_gather.frag.inc"
	;
static const uint32_t lens_combine_frag[] =
#include "lens_combine.frag.inc"
	;
static const uint32_t lens_blur_frag[] =
#include "lens_blur.frag.inc"
	;
static const uint32_t lens_lerp_frag[] =
#include "lens_lerp.frag.inc"
	;

const stilb_gpu_shader post_shader_lens_light = {lens_light_frag, sizeof lens_light_frag, SOURCE_lens_light_frag};
const stilb_gpu_shader post_shader_lens_halve = {lens_halve_frag, sizeof lens_halve_frag, SOURCE_lens_halve_frag};
const stilb_gpu_shader post_shader_lens_tiles = {lens_tiles_frag, sizeof lens_tiles_frag, SOURCE_lens_tiles_frag};
const stilb_gpu_shader post_shader_lens_reach = {lens_reach_frag, sizeof lens_reach_frag, SOURCE_lens_reach_frag};
const stilb_gpu_shader post_shader_lens_gather = {lens_gather_frag, sizeof lens_gather_frag, SOURCE_lens_gather_frag};
const stilb_gpu_shader post_shader_lens_combine = {lens_combine_frag, sizeof lens_combine_frag,
                                                   SOURCE_lens_combine_frag};
const stilb_gpu_shader post_shader_lens_blur = {lens_blur_frag, sizeof lens_blur_frag, SOURCE_lens_blur_frag};
const stilb_gpu_shader post_shader_lens_lerp = {lens_lerp_frag, sizeof lens_lerp_frag, SOURCE_lens_lerp_frag};
