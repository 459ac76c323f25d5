/* Hordes: figures that look small are posed less often, and with fewer joints. */
#include "scene/play/scene_play_internal.h"

#include <math.h>
#include <stdlib.h>

/* A node, and those above it, never stand still. */
static void rates_always(const stilb_scene_animation *a, play_shared *shared, uint32_t node)
{
	for (; node != STILB_SCENE_NONE; node = a->nodes[node].parent)
		shared->reach[node] = INFINITY;
}

/* How far what hangs on nodes reaches: from a joint to the vertices that it or one below it carries. What carries
 * models without a skin, lights or cameras always moves, and figures with such models never wait: their size is not
 * known here. Parents come before children. */
static void rates_reach(const stilb_scene *scene, play_shared *shared, stilb_mat4 *places)
{
	const stilb_scene_animation *a = scene->animation;
	for (uint32_t n = 0; n < a->node_count; n++)
		places[n] = a->nodes[n].parent == STILB_SCENE_NONE
		                ? a->nodes[n].local
		                : stilb_mat4_multiply(places[a->nodes[n].parent], a->nodes[n].local);
	for (uint32_t i = 0; i < shared->posed_count; i++) {
		const play_posed *posed = &shared->posed[i];
		const play_rest *rest = &shared->rests[posed->deform];
		uint32_t first = posed->skin == STILB_SCENE_NONE ? 0 : a->skins[posed->skin].first_joint;
		uint32_t eights = posed->skin == STILB_SCENE_NONE ? 0 : rest->stride / PLAY_LANES, eight = 0;
		for (size_t k = 0; eights > 0 && k < (size_t)rest->starts[eights] * PLAY_LANES; k++) {
			if (rest->weights[k] <= 0.0f)
				continue;
			while (rest->starts[eight + 1] <= k / PLAY_LANES)
				eight++;
			uint32_t v = eight * PLAY_LANES + (uint32_t)(k % PLAY_LANES), joint = first + rest->joints[k / PLAY_LANES];
			const float *bind = a->inverse_binds[joint].m;
			float at[3] = {0}, square = 0.0f;
			stilb_mat4 to = stilb_mat4_multiply(places[a->joints[joint]], *(const stilb_mat4 *)bind);
			for (int c = 0; c < 3; c++)
				at[c] = to.m[c] * *play_stream(rest, PLAY_POSITION, v) +
				        to.m[4 + c] * *play_stream(rest, PLAY_POSITION + 1, v) +
				        to.m[8 + c] * *play_stream(rest, PLAY_POSITION + 2, v) + to.m[12 + c];
			for (int c = 0; c < 3; c++)
				square += at[c] * at[c];
			shared->radius = fmaxf(shared->radius, sqrtf(square));
			for (uint32_t n = a->joints[joint]; n != STILB_SCENE_NONE; n = a->nodes[n].parent) {
				const float *origin = &places[n].m[12];
				float x = at[0] - origin[0], y = at[1] - origin[1], z = at[2] - origin[2];
				shared->reach[n] = fmaxf(shared->reach[n], sqrtf(x * x + y * y + z * z));
			}
		}
	}
	for (uint32_t n = 0; n < a->node_count; n++) {
		bool shows = a->nodes[n].model_count > 0 && a->nodes[n].skin == STILB_SCENE_NONE;
		if (shows) {
			shared->radius = INFINITY;
			rates_always(a, shared, n);
		}
		if (a->nodes[n].weight_count > 0) /* of morph targets, which no joint carries */
			shared->reach[n] = INFINITY;
	}
	for (uint32_t i = 0; scene->light_mounts && i < scene->light_count; i++)
		if (scene->light_mounts[i].node > 0 && scene->light_mounts[i].node <= a->node_count)
			rates_always(a, shared, scene->light_mounts[i].node - 1);
	for (uint32_t i = 0; scene->camera_mounts && i < scene->camera_count; i++)
		if (scene->camera_mounts[i].node > 0 && scene->camera_mounts[i].node <= a->node_count)
			rates_always(a, shared, scene->camera_mounts[i].node - 1);
}

stilb_result stilb_scene_set_rates(stilb_scene *scene, const stilb_scene_rates *rates)
{
	STILB_ASSERT(scene && rates);
	stilb_scene_figures *all = scene->figures;
	if (!all)
		return stilb_fail(STILB_ERROR_ARGUMENT, "rates: nothing of the scene moves");
	if (!(rates->angle >= 0.0f && rates->still >= 0.0f && isfinite(rates->angle) && isfinite(rates->still)))
		return stilb_fail(STILB_ERROR_ARGUMENT, "rates: angles %g and %g must be finite and at least 0",
		                  (double)rates->angle, (double)rates->still);
	if (!all->shared.reach) {
		stilb_mat4 *places = calloc(scene->animation->node_count + 1ull, sizeof *places);
		all->shared.reach = calloc(scene->animation->node_count + 1ull, sizeof *all->shared.reach);
		if (places && all->shared.reach)
			rates_reach(scene, &all->shared, places);
		free(places);
		if (!places || !all->shared.reach)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the reach of nodes");
	}
	all->rates = *rates;
	return STILB_OK;
}

bool scene_play_is_due(const stilb_scene *scene, uint32_t index)
{
	stilb_scene_figures *all = scene->figures;
	play_figure *figure = &all->figures[index];
	figure->least = 0.0f;
	if (!all->shared.reach)
		return true;
	float at[3] = {0}, square = 0.0f, scale = 1.0f;
	if (figure->place != STILB_SCENE_NONE) {
		const float *m = scene->nodes.to_world[figure->place].m;
		scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
		for (int i = 0; i < 3; i++)
			at[i] = m[12 + i];
	}
	for (int i = 0; i < 3; i++)
		square += (at[i] - scene->camera.position[i]) * (at[i] - scene->camera.position[i]);
	float distance = fmaxf(sqrtf(square) - scale * all->shared.radius, 0.0f);
	float size = 2.0f * scale * all->shared.radius;
	figure->least = scale > 0.0f ? all->rates.still * distance / scale : 0.0f;
	uint32_t period = 1;
	for (float angle = all->rates.angle; period < 8 && size < angle * distance; angle *= 0.5f)
		period *= 2;
	return (all->calls + index) % period == 0;
}

stilb_scene_play_counts stilb_scene_play_counts_of(const stilb_scene *scene)
{
	STILB_ASSERT(scene);
	return scene->figures ? scene->figures->counts : (stilb_scene_play_counts){0};
}
