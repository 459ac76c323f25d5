/* The programs of all effects, and the rows that run them. */
#include "post/post_internal.h"

#include "render/device/render_images.h"

uint16_t post_velocity_depth(const stilb_gpu_plan *plan)
{
	uint16_t depth = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_VELOCITY_DEPTH);
	return depth != 0 ? depth : stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_DEPTH);
}

void post_row_fill(stilb_gpu_pass *row, const char *name, stilb_gpu_program program, uint32_t colors, uint32_t uses)
{
	row->name = name;
	row->kind = STILB_GPU_PASS_FULLSCREEN;
	row->program = program.id;
	row->color_count = (uint8_t)colors;
	for (uint32_t c = 0; c < colors; c++)
		row->color[c].load = STILB_GPU_LOAD_DISCARD;
	row->use_count = (uint8_t)uses;
	for (uint32_t u = 0; u < uses; u++) {
		row->uses[u].how = STILB_GPU_USE_SAMPLED;
		row->uses[u].slot = (uint16_t)u;
	}
}

stilb_result post_program_get(stilb_post *post, post_program number, stilb_gpu_program *program)
{
	static const struct {
		const char *name;
		const stilb_gpu_shader *shader;
		uint8_t samplers;
	} programs[POST_PROGRAMS] = {
		[POST_BLOOM_HALVE_FIRST] = {"bloom halved", &post_shader_bloom_halve, 1},
		[POST_BLOOM_HALVE] = {"bloom halved", &post_shader_bloom_halve, 1},
		[POST_BLOOM_DOUBLE] = {"bloom doubled", &post_shader_bloom_double, 2},
		[POST_BLOOM_ADD] = {"bloom added", &post_shader_bloom_add, 2},
		[POST_OCCLUSION] = {"occlusion", &post_shader_occlusion, 1},
		[POST_OCCLUSION_SMOOTH] = {"occlusion smoothed", &post_shader_occlusion_smooth, 1},
		[POST_EXPOSURE] = {"exposure", &post_shader_exposure, 1},
		[POST_OCCLUSION_APPLY] = {"ambient occluded", &post_shader_occlusion_apply, 3},
		[POST_EDGES] = {"antialiasing", &post_shader_edges, 1},
		[POST_MOTION_KEPT] = {"velocity kept", &post_shader_motion_kept, 1},
		[POST_MOTION_ROWS] = {"blur rows", &post_shader_motion_tile, 1},
		[POST_MOTION_TILES] = {"blur tiles", &post_shader_motion_tile, 1},
		[POST_MOTION_AROUND] = {"blur tiles around", &post_shader_motion_around, 1},
		[POST_MOTION] = {"motion blur", &post_shader_motion, 4},
		[POST_MOTION_FAR] = {"far blur", &post_shader_motion_far, 2},
		[POST_MOTION_FAR_SHOW] = {"motion blur", &post_shader_motion_far_show, 3},
		[POST_TEMPORAL] = {"temporal antialiasing", &post_shader_temporal, 7},
	};
	stilb_post_bloom_format format =
		number <= POST_BLOOM_ADD ? post->settings.bloom_format : STILB_POST_BLOOM_HALF; /* of others the first alone */
	stilb_gpu_program *made = &post->programs[format][number];
	stilb_result result = STILB_OK;
	if (made->id == 0) {
		stilb_gpu_program_desc desc = {
			.name = programs[number].name,
			.samplers = programs[number].samplers,
			.constant_count = number <= POST_BLOOM_HALVE ? 2
		                      : number <= POST_BLOOM_ADD ? 1
		                                                 : 0,
			.constants = {{0, format == STILB_POST_BLOOM_FIXED}, {1, number == POST_BLOOM_HALVE_FIRST}},
		};
		*(number == POST_EXPOSURE ? &desc.compute : &desc.fragment) = *programs[number].shader;
		if (number == POST_MOTION_TILES) {
			desc.constant_count = 1; /* it reads movements */
			desc.constants[0].id = desc.constants[0].value = 0;
		}
		result = stilb_gpu_program_create(stilb_render_gpu(post->render), &desc, made);
	}
	*program = *made;
	return result;
}
