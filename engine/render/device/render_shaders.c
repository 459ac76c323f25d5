/* SPIR-V that the build makes from shaders/. There is no function here: gcc's analyzer keeps the value of each word,
 * and takes a minute for a file that has both. */
#include "render/render_internal.h"
#include "shader_sources.h"

/* _texture: reads a texture; flat: for 2D passes. */
static const uint32_t mesh_vert[] =
#include "mesh.vert.inc"
	;
static const uint32_t mesh_texture_vert[] =
#include "mesh_texture.vert.inc"
	;
static const uint32_t mesh_packed_vert[] =
#include "mesh_packed.vert.inc"
	;
static const uint32_t mesh_packed_texture_vert[] =
#include "mesh_packed_texture.vert.inc"
	;
static const uint32_t mesh_frag[] =
#include "mesh.frag.inc"
	;
static const uint32_t mesh_texture_frag[] =
#include "mesh_texture.frag.inc"
	;
static const uint32_t mesh_gloss_frag[] =
#include "mesh_gloss.frag.inc"
	;
static const uint32_t mesh_texture_gloss_frag[] =
#include "mesh_texture_gloss.frag.inc"
	;

static const uint32_t maps_vert[] =
#include "maps.vert.inc"
	;
static const uint32_t maps_extras_vert[] =
#include "maps_extras.vert.inc"
	;
static const uint32_t maps_packed_vert[] =
#include "maps_packed.vert.inc"
	;
static const uint32_t maps_packed_extras_vert[] =
#include "maps_packed_extras.vert.inc"
	;
static const uint32_t maps_frag[] =
#include "maps.frag.inc"
	;
static const uint32_t maps_extras_frag[] =
#include "maps_extras.frag.inc"
	;
static const uint32_t maps_coverage_frag[] =
#include "maps_coverage.frag.inc"
	;
static const uint32_t maps_coverage_extras_frag[] =
#include "maps_coverage_extras.frag.inc"
	;
static const uint32_t maps_gloss_frag[] =
#include "maps_gloss.frag.inc"
	;
static const uint32_t maps_extras_gloss_frag[] =
#include "maps_extras_gloss.frag.inc"
	;
static const uint32_t maps_coverage_gloss_frag[] =
#include "maps_coverage_gloss.frag.inc"
	;
static const uint32_t maps_coverage_extras_gloss_frag[] =
#include "maps_coverage_extras_gloss.frag.inc"
	;
static const uint32_t layers_vert[] =
#include "layers.vert.inc"
	;
static const uint32_t layers_extras_vert[] =
#include "layers_extras.vert.inc"
	;
static const uint32_t layers_packed_vert[] =
#include "layers_packed.vert.inc"
	;
static const uint32_t layers_packed_extras_vert[] =
#include "layers_packed_extras.vert.inc"
	;
static const uint32_t layers_frag[] =
#include "layers.frag.inc"
	;
static const uint32_t layers_extras_frag[] =
#include "layers_extras.frag.inc"
	;
static const uint32_t layers_coverage_frag[] =
#include "layers_coverage.frag.inc"
	;
static const uint32_t layers_coverage_extras_frag[] =
#include "layers_coverage_extras.frag.inc"
	;
static const uint32_t layers_gloss_frag[] =
#include "layers_gloss.frag.inc"
	;
static const uint32_t layers_extras_gloss_frag[] =
#include "layers_extras_gloss.frag.inc"
	;
static const uint32_t layers_coverage_gloss_frag[] =
#include "layers_coverage_gloss.frag.inc"
	;
static const uint32_t layers_coverage_extras_gloss_frag[] =
#include "layers_coverage_extras_gloss.frag.inc"
	;
static const uint32_t through_frag[] =
#include "through.frag.inc"
	;
static const uint32_t through_extras_frag[] =
#include "through_extras.frag.inc"
	;
static const uint32_t through_gloss_frag[] =
#include "through_gloss.frag.inc"
	;
static const uint32_t through_extras_gloss_frag[] =
#include "through_extras_gloss.frag.inc"
	;
static const uint32_t mesh_gbuffer_frag[] =
#include "mesh_gbuffer.frag.inc"
	;
static const uint32_t mesh_texture_gbuffer_frag[] =
#include "mesh_texture_gbuffer.frag.inc"
	;
static const uint32_t mesh_gloss_gbuffer_frag[] =
#include "mesh_gloss_gbuffer.frag.inc"
	;
static const uint32_t mesh_texture_gloss_gbuffer_frag[] =
#include "mesh_texture_gloss_gbuffer.frag.inc"
	;
static const uint32_t impostor_gbuffer_frag[] =
#include "impostor_gbuffer.frag.inc"
	;
static const uint32_t impostor_gloss_gbuffer_frag[] =
#include "impostor_gloss_gbuffer.frag.inc"
	;
static const uint32_t maps_gbuffer_frag[] =
#include "maps_gbuffer.frag.inc"
	;
static const uint32_t maps_extras_gbuffer_frag[] =
#include "maps_extras_gbuffer.frag.inc"
	;
static const uint32_t maps_gloss_gbuffer_frag[] =
#include "maps_gloss_gbuffer.frag.inc"
	;
static const uint32_t maps_extras_gloss_gbuffer_frag[] =
#include "maps_extras_gloss_gbuffer.frag.inc"
	;
static const uint32_t deferred_frag[] =
#include "deferred.frag.inc"
	;
static const uint32_t mesh_slim_frag[] =
#include "mesh_slim.frag.inc"
	;
static const uint32_t mesh_texture_slim_frag[] =
#include "mesh_texture_slim.frag.inc"
	;
static const uint32_t impostor_slim_frag[] =
#include "impostor_slim.frag.inc"
	;
static const uint32_t maps_slim_frag[] =
#include "maps_slim.frag.inc"
	;
static const uint32_t maps_extras_slim_frag[] =
#include "maps_extras_slim.frag.inc"
	;
static const uint32_t deferred_terms_frag[] =
#include "deferred_terms.frag.inc"
	;
static const uint32_t deferred_apart_terms_frag[] =
#include "deferred_apart_terms.frag.inc"
	;
static const uint32_t mesh_terms_frag[] =
#include "mesh_terms.frag.inc"
	;
static const uint32_t mesh_texture_terms_frag[] =
#include "mesh_texture_terms.frag.inc"
	;
static const uint32_t impostor_terms_frag[] =
#include "impostor_terms.frag.inc"
	;
static const uint32_t maps_terms_frag[] =
#include "maps_terms.frag.inc"
	;
static const uint32_t maps_extras_terms_frag[] =
#include "maps_extras_terms.frag.inc"
	;
static const uint32_t mesh_images_frag[] =
#include "mesh_images.frag.inc"
	;
static const uint32_t mesh_texture_images_frag[] =
#include "mesh_texture_images.frag.inc"
	;
static const uint32_t mesh_gloss_images_frag[] =
#include "mesh_gloss_images.frag.inc"
	;
static const uint32_t mesh_texture_gloss_images_frag[] =
#include "mesh_texture_gloss_images.frag.inc"
	;
static const uint32_t impostor_images_frag[] =
#include "impostor_images.frag.inc"
	;
static const uint32_t impostor_gloss_images_frag[] =
#include "impostor_gloss_images.frag.inc"
	;
static const uint32_t maps_images_frag[] =
#include "maps_images.frag.inc"
	;
static const uint32_t maps_extras_images_frag[] =
#include "maps_extras_images.frag.inc"
	;
static const uint32_t maps_gloss_images_frag[] =
#include "maps_gloss_images.frag.inc"
	;
static const uint32_t maps_extras_gloss_images_frag[] =
#include "maps_extras_gloss_images.frag.inc"
	;
static const uint32_t deferred_apart_frag[] =
#include "deferred_apart.frag.inc"
	;
static const uint32_t cells_comp[] =
#include "cells.comp.inc"
	;
static const uint32_t cells_fill_comp[] =
#include "cells_fill.comp.inc"
	;
static const uint32_t cells_sum_comp[] =
#include "cells_sum.comp.inc"
	;
static const uint32_t around_frag[] =
#include "around.frag.inc"
	;
static const uint32_t difference_frag[] =
#include "difference.frag.inc"
	;
static const uint32_t mesh_seen_frag[] =
#include "mesh_seen.frag.inc"
	;
static const uint32_t impostor_seen_frag[] =
#include "impostor_seen.frag.inc"
	;
static const uint32_t maps_seen_frag[] =
#include "maps_seen.frag.inc"
	;
static const uint32_t maps_seen_extras_frag[] =
#include "maps_seen_extras.frag.inc"
	;
static const uint32_t tiles_comp[] =
#include "tiles.comp.inc"
	;
static const uint32_t tiles_normals_comp[] =
#include "tiles_normals.comp.inc"
	;
static const uint32_t tiles_gloss_comp[] =
#include "tiles_gloss.comp.inc"
	;
static const uint32_t indices_comp[] =
#include "indices.comp.inc"
	;
static const uint32_t volume_vert[] =
#include "volume.vert.inc"
	;
static const uint32_t volume_depth_frag[] =
#include "volume_depth.frag.inc"
	;
static const uint32_t behind_frag[] =
#include "behind.frag.inc"
	;
static const uint32_t behind_samples_frag[] =
#include "behind_samples.frag.inc"
	;
static const uint32_t behind_half_frag[] =
#include "behind_half.frag.inc"
	;
static const uint32_t maps_depth_frag[] =
#include "maps_depth.frag.inc"
	;
static const uint32_t maps_depth_extras_frag[] =
#include "maps_depth_extras.frag.inc"
	;

static const uint32_t function_vert[] =
#include "function.vert.inc"
	;
static const uint32_t function_extras_vert[] =
#include "function_extras.vert.inc"
	;
static const uint32_t function_packed_vert[] =
#include "function_packed.vert.inc"
	;
static const uint32_t function_packed_extras_vert[] =
#include "function_packed_extras.vert.inc"
	;
static const uint32_t function_layers_vert[] =
#include "function_layers.vert.inc"
	;
static const uint32_t function_layers_extras_vert[] =
#include "function_layers_extras.vert.inc"
	;
static const uint32_t function_layers_packed_vert[] =
#include "function_layers_packed.vert.inc"
	;
static const uint32_t function_layers_packed_extras_vert[] =
#include "function_layers_packed_extras.vert.inc"
	;
static const uint32_t function_channel_vert[] =
#include "function_channel.vert.inc"
	;
static const uint32_t function_extras_channel_vert[] =
#include "function_extras_channel.vert.inc"
	;
static const uint32_t function_packed_channel_vert[] =
#include "function_packed_channel.vert.inc"
	;
static const uint32_t function_packed_extras_channel_vert[] =
#include "function_packed_extras_channel.vert.inc"
	;
static const uint32_t mesh_channel_vert[] =
#include "mesh_channel.vert.inc"
	;
static const uint32_t mesh_packed_channel_vert[] =
#include "mesh_packed_channel.vert.inc"
	;
static const uint32_t maps_channel_vert[] =
#include "maps_channel.vert.inc"
	;
static const uint32_t maps_extras_channel_vert[] =
#include "maps_extras_channel.vert.inc"
	;
static const uint32_t maps_packed_channel_vert[] =
#include "maps_packed_channel.vert.inc"
	;
static const uint32_t maps_packed_extras_channel_vert[] =
#include "maps_packed_extras_channel.vert.inc"
	;
static const uint32_t mesh_channel_frag[] =
#include "mesh_channel.frag.inc"
	;
static const uint32_t mesh_texture_channel_frag[] =
#include "mesh_texture_channel.frag.inc"
	;
static const uint32_t impostor_channel_frag[] =
#include "impostor_channel.frag.inc"
	;
static const uint32_t maps_channel_frag[] =
#include "maps_channel.frag.inc"
	;
static const uint32_t maps_extras_channel_frag[] =
#include "maps_extras_channel.frag.inc"
	;
static const uint32_t maps_coverage_channel_frag[] =
#include "maps_coverage_channel.frag.inc"
	;
static const uint32_t maps_coverage_extras_channel_frag[] =
#include "maps_coverage_extras_channel.frag.inc"
	;

static const uint32_t impostor_vert[] =
#include "impostor.vert.inc"
	;
static const uint32_t impostor_packed_vert[] =
#include "impostor_packed.vert.inc"
	;
static const uint32_t impostor_frag[] =
#include "impostor.frag.inc"
	;
static const uint32_t impostor_gloss_frag[] =
#include "impostor_gloss.frag.inc"
	;

static const uint32_t depth_frag[] =
#include "depth.frag.inc"
	;
static const uint32_t impostor_depth_frag[] =
#include "impostor_depth.frag.inc"
	;

static const uint32_t velocity_frag[] =
#include "velocity.frag.inc"
	;
static const uint32_t maps_velocity_frag[] =
#include "maps_velocity.frag.inc"
	;
static const uint32_t maps_velocity_extras_frag[] =
#include "maps_velocity_extras.frag.inc"
	;
static const uint32_t impostor_velocity_frag[] =
#include "impostor_velocity.frag.inc"
	;
static const uint32_t velocity_far_frag[] =
#include "velocity_far.frag.inc"
	;

static const uint32_t flat_vert[] =
#include "flat.vert.inc"
	;
static const uint32_t flat_texture_vert[] =
#include "flat_texture.vert.inc"
	;
static const uint32_t flat_frag[] =
#include "flat.frag.inc"
	;
static const uint32_t flat_texture_frag[] =
#include "flat_texture.frag.inc"
	;
static const uint32_t flat_picture_vert[] =
#include "flat_picture.vert.inc"
	;
static const uint32_t flat_picture_frag[] =
#include "flat_picture.frag.inc"
	;

static const uint32_t backdrop_frag[] =
#include "backdrop.frag.inc"
	;
static const uint32_t backdrop_panorama_frag[] =
#include "backdrop_panorama.frag.inc"
	;
static const uint32_t resolve_frag[] =
#include "resolve.frag.inc"
	;
static const uint32_t decode_frag[] =
#include "decode.frag.inc"
	;
static const uint32_t tone_frag[] =
#include "tone.frag.inc"
	;
static const uint32_t tone_grade_frag[] =
#include "tone_grade.frag.inc"
	;

#define SHADER(code)                                                                                                   \
	{                                                                                                                  \
		code, sizeof code, SOURCE_##code                                                                               \
	}

const stilb_gpu_shader render_mesh_vertex[2][RENDER_SURFACES] = {
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_vert),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_vert),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_vert),
	},
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_packed_vert),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_packed_texture_vert),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_packed_vert),
	},
};

const stilb_gpu_shader render_mesh_fragment[2][RENDER_SURFACES] = {
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_frag),
	},
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_gloss_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_gloss_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_gloss_frag),
	},
};

const stilb_gpu_shader render_maps_vertex[2][2][2] = {
	{
		{SHADER(maps_vert), SHADER(maps_extras_vert)},
		{SHADER(maps_packed_vert), SHADER(maps_packed_extras_vert)},
	},
	{
		{SHADER(layers_vert), SHADER(layers_extras_vert)},
		{SHADER(layers_packed_vert), SHADER(layers_packed_extras_vert)},
	},
};
const stilb_gpu_shader render_maps_fragment[2][2][2][2] = {
	{
		{
			{SHADER(maps_frag), SHADER(maps_extras_frag)},
			{SHADER(maps_coverage_frag), SHADER(maps_coverage_extras_frag)},
		},
		{
			{SHADER(maps_gloss_frag), SHADER(maps_extras_gloss_frag)},
			{SHADER(maps_coverage_gloss_frag), SHADER(maps_coverage_extras_gloss_frag)},
		},
	},
	{
		{
			{SHADER(layers_frag), SHADER(layers_extras_frag)},
			{SHADER(layers_coverage_frag), SHADER(layers_coverage_extras_frag)},
		},
		{
			{SHADER(layers_gloss_frag), SHADER(layers_extras_gloss_frag)},
			{SHADER(layers_coverage_gloss_frag), SHADER(layers_coverage_extras_gloss_frag)},
		},
	},
};
const stilb_gpu_shader render_through_fragment[2][2] = {
	{SHADER(through_frag), SHADER(through_extras_frag)},
	{SHADER(through_gloss_frag), SHADER(through_extras_gloss_frag)},
};
const stilb_gpu_shader render_gbuffer_mesh_fragment[2][RENDER_SURFACES] = {
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_gbuffer_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_gbuffer_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_gbuffer_frag),
	},
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_gloss_gbuffer_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_gloss_gbuffer_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_gloss_gbuffer_frag),
	},
};
const stilb_gpu_shader render_gbuffer_maps_fragment[2][2] = {
	{SHADER(maps_gbuffer_frag), SHADER(maps_extras_gbuffer_frag)},
	{SHADER(maps_gloss_gbuffer_frag), SHADER(maps_extras_gloss_gbuffer_frag)},
};
const stilb_gpu_shader render_slim_mesh_fragment[RENDER_SURFACES] = {
	[RENDER_SURFACE_PLAIN] = SHADER(mesh_slim_frag),
	[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_slim_frag),
	[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_slim_frag),
};
const stilb_gpu_shader render_slim_maps_fragment[2] = {SHADER(maps_slim_frag), SHADER(maps_extras_slim_frag)};
const stilb_gpu_shader render_terms_mesh_fragment[RENDER_SURFACES] = {
	[RENDER_SURFACE_PLAIN] = SHADER(mesh_terms_frag),
	[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_terms_frag),
	[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_terms_frag),
};
const stilb_gpu_shader render_terms_maps_fragment[2] = {SHADER(maps_terms_frag), SHADER(maps_extras_terms_frag)};
const stilb_gpu_shader render_images_mesh_fragment[2][RENDER_SURFACES] = {
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_images_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_images_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_images_frag),
	},
	{
		[RENDER_SURFACE_PLAIN] = SHADER(mesh_gloss_images_frag),
		[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_gloss_images_frag),
		[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_gloss_images_frag),
	},
};
const stilb_gpu_shader render_images_maps_fragment[2][2] = {
	{SHADER(maps_images_frag), SHADER(maps_extras_images_frag)},
	{SHADER(maps_gloss_images_frag), SHADER(maps_extras_gloss_images_frag)},
};
const stilb_gpu_shader render_around_fragment = SHADER(around_frag);
const stilb_gpu_shader render_difference_fragment = SHADER(difference_frag);
const stilb_gpu_shader render_seen_mesh_fragment[RENDER_SURFACES] = {
	[RENDER_SURFACE_PLAIN] = SHADER(mesh_seen_frag),
	[RENDER_SURFACE_TEXTURE] = SHADER(mesh_seen_frag),
	[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_seen_frag),
};
const stilb_gpu_shader render_seen_maps_fragment[2] = {SHADER(maps_seen_frag), SHADER(maps_seen_extras_frag)};
const stilb_gpu_shader render_deferred_fragment[2] = {SHADER(deferred_frag), SHADER(deferred_apart_frag)};
const stilb_gpu_shader render_deferred_terms_fragment[2] = {SHADER(deferred_terms_frag),
                                                            SHADER(deferred_apart_terms_frag)};
const stilb_gpu_shader render_cells_compute[RENDER_CELLS_PASSES] = {
	[RENDER_CELLS_COUNT] = SHADER(cells_comp),
	[RENDER_CELLS_SUM] = SHADER(cells_sum_comp),
	[RENDER_CELLS_FILL] = SHADER(cells_fill_comp),
};
const stilb_gpu_shader render_tiles_compute[RENDER_TILES_KINDS] = {
	[RENDER_TILES_DEPTH] = SHADER(tiles_comp),
	[RENDER_TILES_NORMALS] = SHADER(tiles_normals_comp),
	[RENDER_TILES_GLOSS] = SHADER(tiles_gloss_comp),
	[RENDER_TILES_INDICES] = SHADER(indices_comp),
};
const stilb_gpu_shader render_volume_vertex = SHADER(volume_vert);
const stilb_gpu_shader render_volume_depth_fragment = SHADER(volume_depth_frag);
const stilb_gpu_shader render_behind_fragment[2] = {SHADER(behind_frag), SHADER(behind_samples_frag)};
const stilb_gpu_shader render_behind_half_fragment = SHADER(behind_half_frag);
const stilb_gpu_shader render_channel_vertex[2][RENDER_CHANNEL_VERTICES] = {
	{SHADER(mesh_channel_vert), SHADER(maps_channel_vert), SHADER(maps_extras_channel_vert)},
	{SHADER(mesh_packed_channel_vert), SHADER(maps_packed_channel_vert), SHADER(maps_packed_extras_channel_vert)},
};
const stilb_gpu_shader render_channel_mesh_fragment[RENDER_SURFACES] = {
	[RENDER_SURFACE_PLAIN] = SHADER(mesh_channel_frag),
	[RENDER_SURFACE_TEXTURE] = SHADER(mesh_texture_channel_frag),
	[RENDER_SURFACE_IMPOSTOR] = SHADER(impostor_channel_frag),
};
const stilb_gpu_shader render_channel_maps_fragment[2][2] = {
	{SHADER(maps_channel_frag), SHADER(maps_extras_channel_frag)},
	{SHADER(maps_coverage_channel_frag), SHADER(maps_coverage_extras_channel_frag)},
};
const stilb_gpu_shader render_function_vertex[2][2][2] = {
	{
		{SHADER(function_vert), SHADER(function_extras_vert)},
		{SHADER(function_packed_vert), SHADER(function_packed_extras_vert)},
	},
	{
		{SHADER(function_layers_vert), SHADER(function_layers_extras_vert)},
		{SHADER(function_layers_packed_vert), SHADER(function_layers_packed_extras_vert)},
	},
};
const stilb_gpu_shader render_function_channel_vertex[2][2] = {
	{SHADER(function_channel_vert), SHADER(function_extras_channel_vert)},
	{SHADER(function_packed_channel_vert), SHADER(function_packed_extras_channel_vert)},
};
const stilb_gpu_shader render_maps_depth[2][2] = {
	{SHADER(maps_depth_frag), SHADER(maps_depth_extras_frag)},
	{SHADER(maps_velocity_frag), SHADER(maps_velocity_extras_frag)},
};

const stilb_gpu_shader render_flat_shaders[RENDER_FLATS][2] = {
	[RENDER_FLAT_PLAIN] = {SHADER(flat_vert), SHADER(flat_frag)},
	[RENDER_FLAT_TEXTURE] = {SHADER(flat_texture_vert), SHADER(flat_texture_frag)},
	[RENDER_FLAT_PICTURE] = {SHADER(flat_picture_vert), SHADER(flat_picture_frag)},
};

const stilb_gpu_shader render_depth_fragment[2] = {SHADER(depth_frag), SHADER(velocity_frag)};
const stilb_gpu_shader render_impostor_depth_fragment[2] = {SHADER(impostor_depth_frag),
                                                            SHADER(impostor_velocity_frag)};
const stilb_gpu_shader render_velocity_far_fragment = SHADER(velocity_far_frag);
const stilb_gpu_shader render_backdrop_fragment[2] = {SHADER(backdrop_frag), SHADER(backdrop_panorama_frag)};
const stilb_gpu_shader render_resolve_fragment = SHADER(resolve_frag);
const stilb_gpu_shader render_decode_fragment = SHADER(decode_frag);
const stilb_gpu_shader render_tone_fragment[2] = {SHADER(tone_frag), SHADER(tone_grade_frag)};
