/* Frees figures, and things that leave their figure. Needs nothing of the rest of scene/: the import process has it,
 * too. */
#include "scene/play/scene_play_internal.h"

#include <stdlib.h>

void scene_play_free_figure(play_figure *figure)
{
	free(figure->nodes);
	free(figure->models);
	free(figure->meshes);
	free(figure->places);
	free(figure->joints);
	free(figure->weights);
	free(figure->shown_weights);
	free(figure->turned);
	free(figure->plays);
	*figure = (play_figure){0};
}

static void play_unshare(const stilb_scene *scene, play_shared *shared)
{
	for (uint32_t d = 0; shared->rests && d < scene->animation->deform_count; d++) {
		free(shared->rests[d].streams);
		free(shared->rests[d].starts);
		free(shared->rests[d].weights);
		free(shared->rests[d].joints);
	}
	free(shared->targets);
	free(shared->channels);
	free(shared->order);
	free(shared->clips);
	free(shared->tracks);
	free(shared->reach);
	free(shared->moved);
	free(shared->carriers);
	free(shared->rests);
	free(shared->posed);
	*shared = (play_shared){0};
}

void scene_play_finish(stilb_scene *scene)
{
	stilb_scene_figures *all = scene->figures;
	if (!all)
		return;
	for (uint32_t f = 0; f < all->count; f++)
		scene_play_free_figure(&all->figures[f]);
	for (uint32_t i = 0; i < all->scratch_count; i++) {
		free(all->scratch[i].row);
		free(all->scratch[i].cursors);
	}
	free(all->scratch);
	play_unshare(scene, &all->shared);
	free(all->figures);
	free(all->due);
	free(all->work);
	free(all->boxes);
	free(all->ends);
	free(all);
	scene->figures = NULL;
}

/* ---- things that leave their figure ------------------------------------------------------------------------------ */

static void play_forget(uint32_t *list, uint32_t count, uint32_t id)
{
	for (uint32_t i = 0; i < count; i++)
		list[i] = list[i] == id ? STILB_SCENE_NONE : list[i];
}

void scene_play_forget_node(stilb_scene *scene, uint32_t figure, uint32_t node)
{
	play_figure *from = &scene->figures->figures[figure - 1];
	from->place = from->place == node ? STILB_SCENE_NONE : from->place;
	play_forget(from->nodes, scene->animation->node_count, node);
}

void scene_play_forget_model(stilb_scene *scene, uint32_t figure, uint32_t model)
{
	play_forget(scene->figures->figures[figure - 1].models, scene->figures->shared.model_count, model);
}

void scene_play_forget_mesh(stilb_scene *scene, uint32_t figure, uint32_t mesh)
{
	play_figure *from = &scene->figures->figures[figure - 1];
	for (uint32_t p = 0; p < scene->figures->shared.posed_count; p++)
		if (from->meshes[p].mesh == mesh)
			from->meshes[p].mesh = STILB_SCENE_NONE;
}
