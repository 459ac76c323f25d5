#include "scene/scene_impostor.h"

#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *stilb_scene_impostor_mistake(const stilb_scene_impostor *impostor)
{
	const stilb_image *maps = &impostor->maps;
	uint32_t grid = impostor->grid, side = impostor->side;
	for (int axis = 0; axis < 3; axis++)
		if (!(fabsf(impostor->center[axis]) <= 1e18f))
			return "its centre is not within 1e18 m";
	for (int axis = 0; axis < 3; axis++)
		if (!(impostor->half[axis] >= 0.0f && impostor->half[axis] <= 1e18f))
			return "half a side of its box is not from 0 to 1e18 m";
	if (!(impostor->radius > 0.0f && impostor->radius <= 1e18f))
		return "its radius is not above 0 and within 1e18 m";
	if (grid < STILB_SCENE_IMPOSTOR_MIN_GRID || grid % 2 == 0)
		return "its grid is not an odd number of 3 or more";
	if (side < STILB_SCENE_IMPOSTOR_MIN_SIDE)
		return "its pictures have fewer than 4 texels a side";
	if (grid > STILB_SCENE_IMPOSTOR_MAX_TEXELS || side > STILB_SCENE_IMPOSTOR_MAX_TEXELS / grid)
		return "grid * side is more than 4096 texels";
	if (!maps->pixels || maps->format != STILB_IMAGE_F16_LINEAR || maps->channels != 4)
		return "its maps are not 16-bit floats of 4 channels";
	if (maps->width != grid * side || maps->height != 2 * grid * side)
		return "its maps are not grid * side texels wide and twice as high";
	return NULL;
}

void stilb_scene_impostor_finish(stilb_scene_impostor *impostor)
{
	stilb_image_finish(&impostor->maps);
	*impostor = (stilb_scene_impostor){0};
}

/* ---- impostors of a scene ---------------------------------------------------------------------------------------- */

bool stilb_scene_impostors_are_current(const stilb_scene *scene)
{
	return scene->impostors_geometry == stilb_scene_impostors_revision(scene) &&
	       scene->impostors_materials == scene->revisions.materials;
}

void stilb_scene_remove_impostors(stilb_scene *scene)
{
	for (uint32_t i = 0; i < scene->impostor_count; i++)
		stilb_scene_impostor_finish(&scene->impostors[i]);
	free(scene->impostors);
	free(scene->model_impostor);
	scene->impostors = NULL;
	scene->model_impostor = NULL;
	scene->impostor_count = scene->impostor_model_count = 0;
	scene->impostors_removed++;
}

stilb_result stilb_scene_add_impostor(stilb_scene *scene, stilb_scene_impostor *impostor, uint32_t *id)
{
	STILB_ASSERT(scene && impostor && id);
	const char *mistake = stilb_scene_impostor_mistake(impostor);
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "impostor %u: %s", scene->impostor_count, mistake);
	if (!stilb_scene_impostors_are_current(scene))
		stilb_scene_remove_impostors(scene);
	stilb_scene_impostor *more = realloc(scene->impostors, (scene->impostor_count + (size_t)1) * sizeof *more);
	if (!more)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another impostor");
	scene->impostors = more;
	*id = scene->impostor_count++;
	scene->impostors[*id] = *impostor;
	scene->impostors_geometry = stilb_scene_impostors_revision(scene);
	scene->impostors_materials = scene->revisions.materials;
	*impostor = (stilb_scene_impostor){0};
	return STILB_OK;
}

stilb_result stilb_scene_set_impostor(stilb_scene *scene, uint32_t model, uint32_t impostor)
{
	STILB_ASSERT(scene);
	uint32_t before = scene->impostor_model_count;
	if (model >= scene->model_count || impostor > scene->impostor_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u cannot have impostor %u: there are %u and %u", model,
		                  impostor - 1, scene->model_count, scene->impostor_count);
	if (model >= before && impostor == 0)
		return STILB_OK;
	if (model >= before) {
		uint32_t *more = realloc(scene->model_impostor, scene->model_count * sizeof *more);
		if (!more)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the impostors of %u models", scene->model_count);
		memset(more + before, 0, (scene->model_count - before) * sizeof *more);
		scene->model_impostor = more;
		scene->impostor_model_count = scene->model_count;
	}
	scene->model_impostor[model] = impostor;
	return STILB_OK;
}

void scene_impostor_forget(stilb_scene *scene, uint32_t model)
{
	if (model < scene->impostor_model_count)
		scene->model_impostor[model] = 0;
}
