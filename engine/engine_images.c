/* Shows one after another the images of the frame's plan in the place of the picture, and tells in the corner which. */
#include "engine_internal.h"
#include "render/device/render_images.h"

#include <stdio.h>
#include <string.h>

/* True if a resource of the plan is an image that can be shown; the picture itself always can. */
static bool images_can_show(const stilb_gpu_plan *plan, uint16_t resource)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, resource);
	return extent->format != STILB_GPU_NONE &&
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

void engine_images_act(stilb_engine *engine, const stilb_input_state *input)
{
	const stilb_gpu_plan *plan = stilb_render_plan(engine->render);
	const stilb_gpu_step *steps;
	int step = (int)input->actions[STILB_ENGINE_IMAGE] - (int)input->actions[STILB_ENGINE_IMAGE_BACK];
	if (step == 0 || stilb_gpu_plan_steps(plan, &steps) == 0)
		return;
	const char *shown = engine->image[0] ? engine->image : STILB_RENDER_IMAGE_PICTURE;
	uint16_t image = images_after(plan, shown, step > 0 ? 1 : -1);
	if (image == 0)
		return;
	const char *name = stilb_gpu_plan_name(plan, image);
	if (strcmp(name, STILB_RENDER_IMAGE_PICTURE) == 0) {
		engine->image[0] = '\0';
		stilb_render_show_image(engine->render, NULL);
		images_caption(engine, NULL);
		return;
	}
	snprintf(engine->image, sizeof engine->image, "%s", name);
	stilb_render_show_image(engine->render, &(stilb_render_shown){.name = engine->image, .optional = true});
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, image);
	char text[sizeof engine->caption];
	snprintf(text, sizeof text, "%s, %u x %u %s, mip 0 of %u, layer 0 of %u, 0..1", name, extent->width, extent->height,
	         stilb_gpu_format_describe(extent->format)->name, extent->mips, extent->layers);
	images_caption(engine, text);
}
