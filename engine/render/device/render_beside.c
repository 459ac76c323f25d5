/* What rows that draw surfaces draw beside the picture, each into an image of its own: the velocity, the model and the
 * normal that a pixel shows, and the surroundings' light on it apart from all other. So that no triangle is drawn
 * twice. What cannot be drawn so has rows of its own (render_velocity.c, render_around.c). */
#include "render/device/render_images.h"
#include "render/render_internal.h"

/* Places are those of shaders/velocity/beside.glsl. */
static const struct {
	const char *name;
	stilb_gpu_format format;
	uint8_t bit;    /* RENDER_BESIDE_... */
	int8_t gbuffer; /* place in rows that draw surfaces into images; -1: it has none there */
} images[RENDER_BESIDE_IMAGES] = {
	[RENDER_BESIDE_IMAGE_VELOCITY] = {STILB_RENDER_IMAGE_VELOCITY, STILB_GPU_RG16_F, RENDER_BESIDE_VELOCITY, 4},
	[RENDER_BESIDE_IMAGE_ID] = {STILB_RENDER_IMAGE_ID, STILB_GPU_R32_UI, RENDER_BESIDE_ID, 5},
	[RENDER_BESIDE_IMAGE_NORMAL] = {STILB_RENDER_IMAGE_SURFACE_NORMAL, STILB_GPU_RG16_U, RENDER_BESIDE_NORMAL, -1},
	[RENDER_BESIDE_IMAGE_AMBIENT] = {STILB_RENDER_IMAGE_AMBIENT, STILB_GPU_RGBA16_F, RENDER_BESIDE_AROUND, 6},
	[RENDER_BESIDE_IMAGE_REFLECTION] = {STILB_RENDER_IMAGE_REFLECTION, STILB_GPU_RGBA16_F, RENDER_BESIDE_AROUND, 7},
	[RENDER_BESIDE_IMAGE_MIRROR] = {STILB_RENDER_IMAGE_MIRROR, STILB_GPU_RGBA8_U, RENDER_BESIDE_MIRROR, -1},
	[RENDER_BESIDE_IMAGE_MIRROR_NORMAL] = {STILB_RENDER_IMAGE_MIRROR_NORMAL, STILB_GPU_RG16_U, RENDER_BESIDE_MIRROR,
                                           -1},
};

static_assert(1 + RENDER_BESIDE_IMAGES <= STILB_GPU_MAX_COLORS, "they are attachments of one row");

uint32_t render_seen_bits(const stilb_render_view *view)
{
	if (!view->last || render_view_is_depth(view))
		return 0;
	return RENDER_BESIDE_VELOCITY | (view->ids || view->surfaces ? RENDER_BESIDE_ID : 0) |
	       (view->surfaces ? RENDER_BESIDE_NORMAL : 0);
}

uint32_t render_around_beside_bits(const render_device *device, const stilb_render_view *view)
{
	return !render_view_is_apart(device, view) ? 0 : RENDER_BESIDE_AROUND | (view->mirrors ? RENDER_BESIDE_MIRROR : 0);
}

uint32_t render_beside_bits(const render_device *device, const stilb_render_view *view)
{
	bool can = stilb_gpu_limits_get(device->gpu)->some_colors && !device->own_rows;
	if (!can || device->samples > 1 || !render_view_is_lit(view) || render_view_counts(view))
		return 0;
	uint32_t seen = render_seen_bits(view), around = render_around_beside_bits(device, view);
	if (render_view_way(device, view).surfaces) { /* four images are its own */
		seen = seen & RENDER_BESIDE_NORMAL ? 0 : seen;
		around = around & RENDER_BESIDE_MIRROR ? 0 : around;
	}
	return seen | around;
}

int render_beside_place(const render_formula_programs *choice, render_beside image)
{
	uint32_t lights = choice->formulas[RENDER_FORMULA_LIGHTS];
	if (!(choice->formulas[RENDER_FORMULA_BESIDE] & images[image].bit))
		return -1;
	return lights & RENDER_LIGHTS_GBUFFER ? images[image].gbuffer
	       : lights & RENDER_LIGHTS_DEPTH ? (int)image
	                                      : (int)image + 1;
}

uint32_t render_beside_formats(const render_formula_programs *choice, stilb_gpu_format formats[STILB_GPU_MAX_COLORS],
                               uint32_t count)
{
	for (uint32_t i = 0; i < RENDER_BESIDE_IMAGES; i++) {
		int place = render_beside_place(choice, (render_beside)i);
		while ((int)count <= place)
			formats[count++] = STILB_GPU_NONE;
		if (place >= 0)
			formats[place] = images[i].format;
	}
	return count;
}

const char *render_beside_name(render_beside image)
{
	return images[image].name;
}

stilb_gpu_format render_beside_format(render_beside image)
{
	return images[image].format;
}
