/* SPIR-V that the build makes from shaders/. There is no function here: gcc's analyzer keeps the value of each word. */
#include "post/post_internal.h"
#include "shader_sources.h"

static const uint32_t bloom_halve_frag[] =
#include "bloom_halve.frag.inc"
	;
static const uint32_t bloom_double_frag[] =
#include "bloom_double.frag.inc"
	;
static const uint32_t bloom_add_frag[] =
#include "bloom_add.frag.inc"
	;
static const uint32_t occlusion_frag[] =
#include "occlusion.frag.inc"
	;
static const uint32_t occlusion_smooth_frag[] =
#include "occlusion_smooth.frag.inc"
	;
static const uint32_t occlusion_apply_frag[] =
#include "occlusion_apply.frag.inc"
	;
static const uint32_t exposure_comp[] =
#include "exposure.comp.inc"
	;
static const uint32_t edges_frag[] =
#include "edges.frag.inc"
	;
static const uint32_t motion_kept_frag[] =
#include "motion_kept.frag.inc"
	;
static const uint32_t motion_tile_frag[] =
#include "motion_tile.frag.inc"
	;
static const uint32_t motion_around_frag[] =
#include "motion_around.frag.inc"
	;
static const uint32_t motion_frag[] =
#include "motion.frag.inc"
	;
static const uint32_t motion_far_frag[] =
#include "motion_far.frag.inc"
	;
static const uint32_t motion_far_show_frag[] =
#include "motion_far_show.frag.inc"
	;
static const uint32_t temporal_frag[] =
#include "temporal.frag.inc"
	;

const stilb_gpu_shader post_shader_exposure = {exposure_comp, sizeof exposure_comp, SOURCE_exposure_comp};
const stilb_gpu_shader post_shader_occlusion = {occlusion_frag, sizeof occlusion_frag, SOURCE_occlusion_frag};
const stilb_gpu_shader post_shader_occlusion_smooth = {occlusion_smooth_frag, sizeof occlusion_smooth_frag,
                                                       SOURCE_occlusion_smooth_frag};
const stilb_gpu_shader post_shader_occlusion_apply = {occlusion_apply_frag, sizeof occlusion_apply_frag,
                                                      SOURCE_occlusion_apply_frag};
const stilb_gpu_shader post_shader_edges = {edges_frag, sizeof edges_frag, SOURCE_edges_frag};
const stilb_gpu_shader post_shader_motion_kept = {motion_kept_frag, sizeof motion_kept_frag, SOURCE_motion_kept_frag};
const stilb_gpu_shader post_shader_motion_tile = {motion_tile_frag, sizeof motion_tile_frag, SOURCE_motion_tile_frag};
const stilb_gpu_shader post_shader_motion_around = {motion_around_frag, sizeof motion_around_frag,
                                                    SOURCE_motion_around_frag};
const stilb_gpu_shader post_shader_motion = {motion_frag, sizeof motion_frag, SOURCE_motion_frag};
const stilb_gpu_shader post_shader_motion_far = {motion_far_frag, sizeof motion_far_frag, SOURCE_motion_far_frag};
const stilb_gpu_shader post_shader_motion_far_show = {motion_far_show_frag, sizeof motion_far_show_frag,
                                                      SOURCE_motion_far_show_frag};
const stilb_gpu_shader post_shader_temporal = {temporal_frag, sizeof temporal_frag, SOURCE_temporal_frag};
const stilb_gpu_shader post_shader_bloom_halve = {bloom_halve_frag, sizeof bloom_halve_frag, SOURCE_bloom_halve_frag};
const stilb_gpu_shader post_shader_bloom_double = {bloom_double_frag, sizeof bloom_double_frag,
                                                   SOURCE_bloom_double_frag};
const stilb_gpu_shader post_shader_bloom_add = {bloom_add_frag, sizeof bloom_add_frag, SOURCE_bloom_add_frag};
