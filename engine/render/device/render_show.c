/* An image of the plan in the place of the picture: for each kind of image a program. */
#include "render/device/render_images.h"
#include "render/render_internal.h"
#include "shader_sources.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const uint32_t show_frag[] =
#include "show.frag.inc"
	;
static const uint32_t show_samples_frag[] =
#include "show_samples.frag.inc"
	;
static const uint32_t show_integers_frag[] =
#include "show_integers.frag.inc"
	;

static const uint32_t show_layers_frag[] =
#include "show_layers.frag.inc"
	;

typedef struct show_push {
	float low, high;
	float columns, rows, side[2]; /* of show_layers_frag alone */
} show_push;

/* Channels of a format; 1 of depth. */
static uint32_t show_channels(stilb_gpu_format format)
{
	const char *name = stilb_gpu_format_describe(format)->name;
	bool two = strncmp(name, "rg", 2) == 0 && name[2] >= '0' && name[2] <= '9';
	bool one = (name[0] == 'r' || name[0] == 'd') && name[1] >= '0' && name[1] <= '9';
	return two || strcmp(name, "bc5_u") == 0 ? 2 : one || strcmp(name, "bc4_u") == 0 ? 1 : 4;
}

/* True of an image that a program can read. */
static bool show_can(const stilb_gpu_extent *extent)
{
	return extent->format != STILB_GPU_NONE && !stilb_gpu_format_has_stencil(extent->format);
}

/* Sets a message that names the images of the frame so far. */
static stilb_result show_unknown(const render_device *device, const stilb_render_shown *shown)
{
	char names[512] = "";
	size_t used = 0;
	for (uint32_t r = 1; r <= stilb_gpu_plan_resources(device->plan); r++) {
		bool image = show_can(stilb_gpu_plan_extent(device->plan, (uint16_t)r));
		const char *name = stilb_gpu_plan_name(device->plan, (uint16_t)r);
		if (image && used + strlen(name) + 3 < sizeof names)
			used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", name);
	}
	for (const char *const *kind = stilb_render_show_names; *kind && used + strlen(*kind) + 3 < sizeof names; kind++)
		used += (size_t)snprintf(names + used, sizeof names - used, ", %s", *kind);
	return stilb_fail(STILB_ERROR_ARGUMENT, "there is no image '%s' to show; this frame has %s", shown->name, names);
}

static stilb_result show_check(const stilb_render_shown *shown, const stilb_gpu_extent *extent)
{
	if (extent->shape == STILB_GPU_SHAPE_3D || extent->shape == STILB_GPU_SHAPE_1D)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' is 3D or 1D and cannot be shown; show one that is 2D",
		                  shown->name);
	if (shown->mip >= extent->mips || shown->layer >= extent->layers)
		return stilb_fail(STILB_ERROR_ARGUMENT, "image '%s' has %u mips and %u layers; there is no mip %u, layer %u",
		                  shown->name, extent->mips, extent->layers, shown->mip, shown->layer);
	return STILB_OK;
}

/* The program for an image. */
static stilb_result show_program(render_device *device, const stilb_gpu_extent *extent, stilb_gpu_program *program)
{
	bool integers = stilb_gpu_format_describe(extent->format)->kind == STILB_GPU_FORMAT_INTEGER;
	uint32_t kind = integers ? 2 : extent->samples > 1, channels = show_channels(extent->format);
	static const stilb_gpu_shader shaders[3] = {
		{show_frag, sizeof show_frag, SOURCE_show_frag},
		{show_samples_frag, sizeof show_samples_frag, SOURCE_show_samples_frag},
		{show_integers_frag, sizeof show_integers_frag, SOURCE_show_integers_frag}};
	stilb_gpu_program_desc desc = {.name = "show", .fragment = shaders[kind], .samplers = 1, .constant_count = 1};
	desc.constants[0].value = channels;
	stilb_gpu_program *made = &device->programs.shows[kind][channels - 1];
	stilb_result result = made->id != 0 ? STILB_OK : stilb_gpu_program_create(device->gpu, &desc, made);
	*program = *made;
	return result;
}

stilb_result render_show_image(render_device *device, const stilb_render_shown *shown)
{
	uint16_t image = stilb_gpu_plan_find(device->plan, shown->name);
	if (image == 0 || !show_can(stilb_gpu_plan_extent(device->plan, image)))
		return shown->optional ? STILB_OK : show_unknown(device, shown);
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(device->plan, image);
	stilb_gpu_program program;
	stilb_result result = show_check(shown, &extent);
	if (result == STILB_OK)
		result = show_program(device, &extent, &program);
	if (result != STILB_OK)
		return result;
	bool range = shown->low != 0.0f || shown->high != 0.0f;
	show_push push = {.low = shown->low, .high = range ? shown->high : 1.0f};
	stilb_gpu_pass pass = {
		.name = "show",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = program.id,
		.color = {{.image = device->frame.picture, .load = STILB_GPU_LOAD_DISCARD}},
		.color_count = 1,
		.uses = {{.resource = image,
	              .how = STILB_GPU_USE_SAMPLED,
	              .mip = (uint8_t)shown->mip,
	              .mips = 1,
	              .layer = (uint16_t)shown->layer,
	              .layers = 1}},
		.use_count = 1,
		.constant_bytes = sizeof push,
	};
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &pass);
	device->frame.shown = true;
	return STILB_OK;
}

/* How so many squares fill the picture with the largest sides. */
static show_push show_squares(const render_device *device, uint32_t count)
{
	show_push best = {0};
	float width = (float)device->width, height = (float)device->height, most = 0.0f;
	for (uint32_t columns = 1; columns <= count; columns++) {
		uint32_t rows = (count + columns - 1) / columns;
		float side = fminf(width / (float)columns, height / (float)rows);
		if (side > most)
			best = (show_push){0.0f, 1.0f, (float)columns, (float)rows, {side / width, side / height}};
		most = fmaxf(side, most);
	}
	return best;
}

stilb_result render_show_layers(render_device *device, uint16_t image)
{
	stilb_gpu_program *program = &device->programs.show_layers;
	stilb_gpu_program_desc desc = {.name = "show layers",
	                               .fragment = {show_layers_frag, sizeof show_layers_frag, SOURCE_show_layers_frag},
	                               .samplers = 1};
	stilb_result result = program->id != 0 ? STILB_OK : stilb_gpu_program_create(device->gpu, &desc, program);
	if (result != STILB_OK)
		return result;
	show_push push = show_squares(device, stilb_gpu_plan_extent(device->plan, image)->layers);
	stilb_gpu_pass pass = {
		.name = "show",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = program->id,
		.color = {{.image = device->frame.picture, .load = STILB_GPU_LOAD_DISCARD}},
		.color_count = 1,
		.uses = {{.resource = image, .how = STILB_GPU_USE_SAMPLED, .array = true}},
		.use_count = 1,
		.constant_bytes = sizeof push,
	};
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &pass);
	device->frame.shown = true;
	return STILB_OK;
}
