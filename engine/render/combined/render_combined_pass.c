/* The models of a pass, by which their lights are chosen: see render_combined.h. */
#include "render/combined/render_combined.h"

#include "render/render_internal.h"

#include <string.h>

stilb_result render_combined_note(render_combined_pass *pass, const stilb_scene *scene, const uint32_t *visible,
                                  uint32_t visible_count)
{
	uint32_t before = pass->state_capacity;
	if (!render_reserve((void **)&pass->models, &pass->model_capacity, visible_count, sizeof *pass->models) ||
	    !render_reserve((void **)&pass->states, &pass->state_capacity, scene->model_count, sizeof *pass->states))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lights of %u models", scene->model_count);
	if (pass->state_capacity > before)
		memset(pass->states + before, 0, (pass->state_capacity - before) * sizeof *pass->states);
	const stilb_scene_bounds *bounds = &scene->bounds;
	for (uint32_t i = 0; i < visible_count; i++) {
		uint32_t m = visible[i];
		pass->models[i] = (render_combined_model){m, {bounds->x[m], bounds->y[m], bounds->z[m]}, bounds->radius[m]};
	}
	pass->model_count = visible_count;
	pass->scene_models = scene->model_count;
	return STILB_OK;
}

void render_combined_renew(render_combined_pass *pass)
{
	if (pass->state_capacity > 0)
		memset(pass->states, 0, pass->state_capacity * sizeof *pass->states);
}

void render_combined_pass_finish(render_combined_pass *pass)
{
	free(pass->models);
	free(pass->states);
	*pass = (render_combined_pass){0};
}
