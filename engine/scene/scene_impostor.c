#include "scene/scene_impostor.h"

#include <math.h>

const char *stilb_scene_impostor_mistake(const stilb_scene_impostor *impostor)
{
	const stilb_image *maps = &impostor->maps;
	uint32_t grid = impostor->grid, side = impostor->side;
	for (int axis = 0; axis < 3; axis++)
		if (!(fabsf(impostor->center[axis]) <= 1e18f))
			return "its centre is not within 1e18 m";
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
