/* Lights that end fade out with the distance: see stilb_render_view.light_fade. */
#include "render/render_internal.h"

#include <math.h>

void render_view_size(const stilb_render *render, const stilb_render_view *view, uint32_t *width, uint32_t *height)
{
	*width = view->target ? view->target->width : render->device->width;
	*height = view->target ? view->target->height : render->device->height;
}

uint32_t render_view_fade_height(const stilb_render *render, const stilb_render_view *view)
{
	uint32_t width, height;
	render_view_size(render, view, &width, &height);
	return view->light_fade_height > 0 ? view->light_fade_height : height;
}

render_lights_fade render_lights_fade_of(const stilb_render *render, const stilb_render_view *view)
{
	uint32_t height = render_view_fade_height(render, view);
	const float *m = view->view_projection.m;
	float up = render_view_scale(&view->view_projection, 1), along = sqrtf(m[3] * m[3] + m[7] * m[7] + m[11] * m[11]);
	bool parallel = !(along > 0.0f);
	return (render_lights_fade){.pixels = view->light_fade,
	                            .scale = 0.5f * (float)height * up / (parallel ? fabsf(m[15]) : along),
	                            .apart = parallel ? 0.0f : 1.0f,
	                            .eye = view->camera_position};
}

float render_light_left(const render_lights_fade *fade, const stilb_scene_light *light)
{
	float square = 0.0f;
	if (!(fade->pixels > 0.0f) || !render_light_ends(light))
		return 1.0f;
	for (int i = 0; i < 3; i++)
		square += (light->position[i] - fade->eye[i]) * (light->position[i] - fade->eye[i]);
	float distance = fade->apart > 0.0f ? fmaxf(sqrtf(square), 1e-6f) : 1.0f;
	float t = light->reach * fade->scale / (distance * fade->pixels) - 1.0f;
	if (!(t < 1.0f)) /* what cannot be told is whole, too */
		return 1.0f;
	t = fmaxf(t, 0.0f);
	return t * t * (3.0f - 2.0f * t);
}
