/* Lamps for the stress test: coloured ones over the tiles, of which some move in circles and some swing. */
#include "base/base_math.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>

/* The random numbers of one lamp. */
enum lamp_stream { LAMP_X, LAMP_Z, LAMP_HEIGHT, LAMP_HUE, LAMP_SATURATION, LAMP_PHASE, LAMP_SPEED, LAMP_STREAMS };

#define LAMP_SEED 0x6c616d7073ull /* lamps have other random numbers than models of the same seed */
#define LAMP_TURN 6.2831853f
#define LAMP_OVERLAP 8.0f      /* lamps that reach a point of the ground, on average, if LAMP_REACH_* allow it */
#define LAMP_REACH_MIN 1.5f    /* metres */
#define LAMP_REACH_SHARE 0.25f /* of the field's side, at most */
#define LAMP_SWING 0.5f        /* radians */

static float lamp_random(const stilb_scene *scene, uint32_t lamp, enum lamp_stream stream, float low, float high)
{
	uint64_t number = (uint64_t)lamp * LAMP_STREAMS + (uint64_t)stream;
	return low + (high - low) * stilb_random_float(scene->seed ^ LAMP_SEED, number);
}

/* The field's side, metres. */
static float lamp_field(const stilb_scene *scene)
{
	return STILB_SCENE_TILE * ceilf(sqrtf((float)scene->stress_models));
}

/* So that LAMP_OVERLAP circles of this radius lie over each point of the field. */
static float lamp_reach(const stilb_scene *scene)
{
	float field = lamp_field(scene), reach = field * sqrtf(LAMP_OVERLAP / (3.14159265f * (float)scene->stress_lamps));
	return fmaxf(LAMP_REACH_MIN, fminf(reach, LAMP_REACH_SHARE * field));
}

/* Where lamp number `lamp` is and what it sends at a time. field, reach: those of all. Every fourth one is a spot that
 * swings, every fourth one a small sphere; of the others every second one moves in a circle. */
static stilb_scene_light lamp_at(const stilb_scene *scene, float field, float reach, uint32_t lamp, double seconds)
{
	float half = 0.5f * field;
	double turns = seconds * (double)lamp_random(scene, lamp, LAMP_SPEED, 0.1f, 0.4f);
	float angle = LAMP_TURN * (lamp_random(scene, lamp, LAMP_PHASE, 0.0f, 1.0f) + (float)(turns - floor(turns)));
	float height = 1.0f + lamp_random(scene, lamp, LAMP_HEIGHT, 0.15f, 0.4f) * reach;
	float intensity = 4.0f * height * height; /* 4 W m^-2 on the ground below, were there no window */
	stilb_scene_light light = {
		.kind = lamp % 4 == 0   ? STILB_SCENE_LIGHT_SPOT
	            : lamp % 4 == 1 ? STILB_SCENE_LIGHT_SPHERE
	                            : STILB_SCENE_LIGHT_POINT,
		.position = {lamp_random(scene, lamp, LAMP_X, -half, half), height,
	                 lamp_random(scene, lamp, LAMP_Z, -half, half)},
		.direction = {0.0f, -1.0f, 0.0f},
		.cos_inner = 0.85f,
		.cos_outer = 0.7f,
		.radius = 0.05f,
		.falloff = STILB_SCENE_LIGHT_WINDOWED,
		.reach = fmaxf(reach, 1.2f * height),
	};
	scene_stress_color(lamp_random(scene, lamp, LAMP_HUE, 0.0f, 1.0f),
	                   lamp_random(scene, lamp, LAMP_SATURATION, 0.2f, 0.8f), intensity, light.intensity);
	if (light.kind == STILB_SCENE_LIGHT_SPOT) {
		float swing = LAMP_SWING * sinf(angle);
		light.direction[lamp / 4 % 2 == 0 ? 0 : 2] = sinf(swing);
		light.direction[1] = -cosf(swing);
	} else if (lamp % 4 == 3) {
		light.position[0] += 0.4f * reach * cosf(angle);
		light.position[2] += 0.4f * reach * sinf(angle);
	}
	return light;
}

stilb_result stilb_scene_stress_add_lamps(stilb_scene *scene, uint32_t count)
{
	STILB_ASSERT(scene && scene->stress_models > 0 && scene->stress_lamps == 0 &&
	             "a scene of stilb_scene_create_stress");
	STILB_ASSERT(count >= 1 && count <= STILB_SCENE_MAX_LAMPS);
	stilb_scene_light *lights = stilb_memory_alloc(1 + (size_t)count, sizeof *lights);
	if (!lights)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lamps", count);
	lights[0] = scene->lights[0];
	free(scene->lights);
	scene->lights = lights;
	scene->stress_lamps = count;
	stilb_scene_stress_set_light(scene, STILB_SCENE_STRESS_LIGHT_NIGHT);
	stilb_scene_stress_move_lamps(scene, 0.0);
	return STILB_OK;
}

void stilb_scene_stress_move_lamps(stilb_scene *scene, double seconds)
{
	STILB_ASSERT(scene && scene->stress_lamps > 0 && isfinite(seconds));
	float field = lamp_field(scene), reach = lamp_reach(scene);
	for (uint32_t i = 0; i < scene->stress_lamps; i++)
		scene->lights[1 + i] = lamp_at(scene, field, reach, i, seconds);
}
