/* Frees figures. Needs nothing of the rest of scene/: the import process has it, too. */
#include "scene/play/scene_play_internal.h"

#include <stdlib.h>

void scene_play_free_figure(play_figure *figure)
{
	free(figure->nodes);
	free(figure->models);
	free(figure->meshes);
	free(figure->joints);
	free(figure->weights);
	free(figure->shown_weights);
	free(figure->turned);
	free(figure->row);
	free(figure->cursors);
	free(figure->plays);
	*figure = (play_figure){0};
}

static void play_unshare(const stilb_scene *scene, play_shared *shared)
{
	for (uint32_t d = 0; shared->rests && d < scene->animation->deform_count; d++) {
		free(shared->rests[d].streams);
		free(shared->rests[d].weights);
		free(shared->rests[d].joints);
	}
	free(shared->targets);
	free(shared->channels);
	free(shared->order);
	free(shared->clips);
	free(shared->tracks);
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
	play_unshare(scene, &all->shared);
	free(all->figures);
	free(all->due);
	free(all->work);
	free(all->boxes);
	free(all->ends);
	free(all);
	scene->figures = NULL;
}
