/* Lights and surroundings. */
#include "scene/edit/scene_check.h"

#include <float.h>

#define LIGHT_NEAR 1e-9f /* metres: sizes whose squares are still above 0 */

static float light_dot(const float a[3], const float b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* False if the cosine of the angle between them is above 1 %. */
static bool light_are_perpendicular(const float a[3], const float b[3])
{
	float product = light_dot(a, b);
	return product * product <= 1e-4f * light_dot(a, a) * light_dot(b, b);
}

static const char *light_rectangle_mistake(const stilb_scene_light *light)
{
	if (!scene_is_within(light->half_x, 3, -SCENE_FAR, SCENE_FAR) ||
	    !scene_is_within(light->half_y, 3, -SCENE_FAR, SCENE_FAR) ||
	    light_dot(light->half_x, light->half_x) < LIGHT_NEAR * LIGHT_NEAR ||
	    light_dot(light->half_y, light->half_y) < LIGHT_NEAR * LIGHT_NEAR)
		return "a half of its sides is not between 1e-9 and 1e18 m";
	if (!light_are_perpendicular(light->half_x, light->half_y) ||
	    !light_are_perpendicular(light->half_x, light->direction) ||
	    !light_are_perpendicular(light->half_y, light->direction))
		return "its sides and its direction are not perpendicular to each other";
	return NULL;
}

/* What is wrong with the members that say where its light ends. */
static const char *light_falloff_mistake(const stilb_scene_light *light, bool round)
{
	if ((uint32_t)light->falloff >= STILB_SCENE_LIGHT_FALLOFFS)
		return "its falloff is unknown";
	if (light->falloff == STILB_SCENE_LIGHT_PHYSICAL || light->kind == STILB_SCENE_LIGHT_DIRECTIONAL)
		return NULL;
	if (!scene_is_within(&light->reach, 1, LIGHT_NEAR, SCENE_FAR) || (round && !(light->reach > light->radius)))
		return "its reach is not above 1e-9 m and its radius, and within 1e18 m";
	return light->face ? "it has a face and a falloff that is not physical" : NULL;
}

const char *stilb_scene_light_mistake(const stilb_scene_light *light)
{
	STILB_ASSERT(light);
	stilb_scene_light_kind kind = light->kind;
	bool round = kind == STILB_SCENE_LIGHT_SPHERE || kind == STILB_SCENE_LIGHT_DISK;
	bool spot = kind == STILB_SCENE_LIGHT_SPOT;
	if ((uint32_t)kind >= STILB_SCENE_LIGHT_KINDS)
		return "its kind is unknown";
	if ((uint32_t)light->unit >= STILB_SCENE_LIGHT_UNITS || (uint32_t)light->use >= STILB_SCENE_LIGHT_USES)
		return "its unit or its use is unknown";
	if (!scene_is_within(light->intensity, 3, 0.0f, FLT_MAX))
		return "its intensity is negative or not finite";
	if (kind != STILB_SCENE_LIGHT_DIRECTIONAL && !scene_is_within(light->position, 3, -SCENE_FAR, SCENE_FAR))
		return "its position is not within 1e18 m";
	if (kind != STILB_SCENE_LIGHT_POINT && kind != STILB_SCENE_LIGHT_SPHERE && !scene_is_unit(light->direction))
		return "its direction is not unit";
	if (spot && !(light->cos_inner <= 1.0f && light->cos_inner >= light->cos_outer && light->cos_outer >= -1.0f))
		return "the cosines of its cone are not 1 >= inner >= outer >= -1";
	if (round && !scene_is_within(&light->radius, 1, LIGHT_NEAR, SCENE_FAR))
		return "its radius is not between 1e-9 and 1e18 m";
	const char *mistake = kind == STILB_SCENE_LIGHT_RECTANGLE ? light_rectangle_mistake(light) : NULL;
	return mistake ? mistake : light_falloff_mistake(light, round);
}
