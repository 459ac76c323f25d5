/* Shows one after another the images of the frame's plan in the place of the picture, and tells in the corner which;
 * and the channels of surfaces in the place of light, which a toast names. */
#include "engine_internal.h"
#include "render/device/render_images.h"

#include <stdio.h>
#include <string.h>

/* True if a resource of the plan is an image that can be shown; the picture itself always can. */
static bool images_can_show(const stilb_gpu_plan *plan, uint16_t resource)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, resource);
	bool none = strcmp(stilb_gpu_plan_name(plan, resource), STILB_RENDER_IMAGE_NO_SHADOWS) == 0;
	return !none && extent->format != STILB_GPU_NONE && !stilb_gpu_format_has_stencil(extent->format) &&
	       (extent->shape == STILB_GPU_SHAPE_2D || extent->shape == STILB_GPU_SHAPE_CUBE);
}

/* The image `step` places after the one that is shown, around the plan's end; 0: there is none. */
static uint16_t images_after(const stilb_gpu_plan *plan, const char *shown, int step)
{
	int count = (int)stilb_gpu_plan_resources(plan), at = stilb_gpu_plan_find(plan, shown);
	for (int tried = 0; tried < count; tried++) {
		at = (at - 1 + step + count) % count + 1;
		if (images_can_show(plan, (uint16_t)at))
			return (uint16_t)at;
	}
	return 0;
}

/* Shows the line in the corner; NULL: none. */
static void images_caption(stilb_engine *engine, const char *text)
{
	engine->overlay.caption_open = false;
	if (text && engine_overlay_create(engine) == STILB_OK)
		engine->overlay.caption_open = snprintf(engine->caption, sizeof engine->caption, "%s", text) > 0;
}

/* Shows a mip of a layer of an image of the plan: part = mip + layer * mips. */
static void images_show(stilb_engine *engine, const stilb_gpu_plan *plan, uint16_t image, uint32_t part)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, image);
	uint32_t mip = part % extent->mips, layer = part / extent->mips;
	char text[sizeof engine->caption];
	snprintf(engine->image, sizeof engine->image, "%s", stilb_gpu_plan_name(plan, image));
	engine->image_part = part;
	stilb_render_shown shown = {.name = engine->image, .mip = mip, .layer = layer, .optional = true};
	stilb_render_show_image(engine->render, &shown);
	snprintf(text, sizeof text, "%s, %u x %u %s, mip %u of %u, layer %u of %u, 0..1", engine->image, extent->width,
	         extent->height, stilb_gpu_format_describe(extent->format)->name, mip, extent->mips, layer, extent->layers);
	images_caption(engine, text);
}

/* The image `step` places on takes the place of the one that is shown. */
static void images_step(stilb_engine *engine, const stilb_gpu_plan *plan, int step)
{
	const char *shown = engine->image[0] ? engine->image : STILB_RENDER_IMAGE_PICTURE;
	uint16_t image = images_after(plan, shown, step);
	if (image != 0 && strcmp(stilb_gpu_plan_name(plan, image), STILB_RENDER_IMAGE_PICTURE) != 0) {
		images_show(engine, plan, image, 0);
	} else if (image != 0) {
		engine->image[0] = '\0';
		stilb_render_show_image(engine->render, NULL);
		images_caption(engine, NULL);
	}
}

/* The mip or layer `step` places on of the image that is shown, around its end. */
static void images_step_part(stilb_engine *engine, const stilb_gpu_plan *plan, int step)
{
	uint16_t image = engine->image[0] ? stilb_gpu_plan_find(plan, engine->image) : 0;
	if (image == 0 || !images_can_show(plan, image))
		return;
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, image);
	uint32_t parts = extent->mips * extent->layers;
	images_show(engine, plan, image, (engine->image_part + (step > 0 ? 1 : parts - 1)) % parts);
}

static int images_direction(const stilb_input_state *input, int forward, int back)
{
	int step = (int)input->actions[forward] - (int)input->actions[back];
	return (step > 0) - (step < 0);
}

/* What pictures show is the one `step` places on, around the end. */
static void images_step_show(stilb_engine *engine, int step)
{
	char text[128];
	int next = ((int)engine->desc.show + step + STILB_RENDER_SHOWS) % STILB_RENDER_SHOWS;
	engine->desc.show = (stilb_render_show)next;
	snprintf(text, sizeof text, "%s: %s", stilb_render_show_names[next], stilb_render_show_words[next]);
	engine_overlay_tell(engine, text);
}

/* Likewise how pixels find their lights. */
static void images_step_lighting(stilb_engine *engine, int step)
{
	char text[128];
	int next = ((int)engine->desc.lighting + step + STILB_RENDER_LIGHTING_WAYS) % STILB_RENDER_LIGHTING_WAYS;
	engine->desc.lighting = (stilb_render_lighting)next;
	bool several =
		stilb_render_lighting_is_of_one_sample(engine->desc.lighting) && stilb_render_samples(engine->render) > 1;
	snprintf(text, sizeof text, "lights %s: %s", stilb_render_lighting_names[next],
	         several ? "with several samples a pixel as auto (--msaa 1)" : stilb_render_lighting_words[next]);
	engine_overlay_tell(engine, text);
}

void engine_images_act(stilb_engine *engine, const stilb_input_state *input)
{
	const stilb_gpu_plan *plan = stilb_render_plan(engine->render);
	const stilb_gpu_step *steps;
	int show = images_direction(input, STILB_ENGINE_SHOW, STILB_ENGINE_SHOW_BACK);
	if (show != 0)
		images_step_show(engine, show);
	int lighting = images_direction(input, STILB_ENGINE_LIGHTING, STILB_ENGINE_LIGHTING_BACK);
	if (lighting != 0)
		images_step_lighting(engine, lighting);
	int step = images_direction(input, STILB_ENGINE_IMAGE, STILB_ENGINE_IMAGE_BACK);
	int part = images_direction(input, STILB_ENGINE_IMAGE_PART, STILB_ENGINE_IMAGE_PART_BACK);
	if ((step == 0 && part == 0) || stilb_gpu_plan_steps(plan, &steps) == 0)
		return;
	if (step != 0)
		images_step(engine, plan, step);
	if (part != 0)
		images_step_part(engine, plan, part);
}
