/* Lamps for the stress test: coloured ones over the tiles, of which some move in circles and some swing. */
#include "base/base_math.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"
#include "scene/scene_internal.h"
#include "shading/shade_luminance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The random numbers of one lamp. */
enum lamp_stream { LAMP_X, LAMP_Z, LAMP_HEIGHT, LAMP_HUE, LAMP_SATURATION, LAMP_PHASE, LAMP_SPEED, LAMP_STREAMS };

#define LAMP_SEED 0x6c616d7073ull /* lamps have other random numbers than models of the same seed */
#define LAMP_TURN 6.2831853f
#define LAMP_OVERLAP 8.0f      /* lamps that reach a point of the ground, on average, if LAMP_REACH_* allow it */
#define LAMP_REACH_MIN 1.5f    /* metres */
#define LAMP_REACH_SHARE 0.25f /* of the field's side, at most */
#define LAMP_SWING 0.5f        /* radians */
#define STRING_LENGTH 30.0f    /* metres */
#define STRING_HEIGHT 3.6f     /* metres, of its ends */
#define STRING_SAG 0.8f        /* metres, of its middle */
#define STRING_REACH 5.0f      /* metres, of a bulb */
#define STRING_INTENSITY 4.0f  /* W sr^-1, of a bulb's brightest channel */
#define STRING_KELVIN 2400.0f
#define CARRIED_REACH 1.2f     /* metres */
#define CARRIED_INTENSITY 0.6f /* W sr^-1, of the brightest channel */

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

/* A bulb of a string, which hangs as a parabola between two posts and sways across; strings are as long as the field,
 * STRING_LENGTH at most. */
static stilb_scene_light bulb_at(const stilb_scene *scene, float field, uint32_t lamp, double seconds)
{
	uint32_t string = lamp / STILB_SCENE_STRING, bulb = lamp % STILB_SCENE_STRING;
	float length = fminf(field, STRING_LENGTH), room = 0.5f * (field - length), half = 0.5f * field;
	float share = ((float)bulb + 0.5f) / (float)STILB_SCENE_STRING, hang = 4.0f * share * (1.0f - share);
	double turns = 0.3 * seconds + (double)lamp_random(scene, string, LAMP_PHASE, 0.0f, 1.0f);
	float sway = 0.15f * hang * sinf(LAMP_TURN * (float)(turns - floor(turns)));
	float along = lamp_random(scene, string, LAMP_X, -room, room + 1e-3f) + (share - 0.5f) * length;
	float across = lamp_random(scene, string, LAMP_Z, -half, half) + sway;
	bool turned = string % 2 == 1; /* every second string runs the other way */
	stilb_vec3 color = shade_color_of_temperature(STRING_KELVIN);
	return (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT,
		.position = {turned ? across : along, STRING_HEIGHT - STRING_SAG * hang, turned ? along : across},
		.intensity = {STRING_INTENSITY * color[0], STRING_INTENSITY * color[1], STRING_INTENSITY * color[2]},
		.falloff = STILB_SCENE_LIGHT_WINDOWED,
		.reach = STRING_REACH,
	};
}

/* Lamp number `lamp` at a time. */
static stilb_scene_light lamp_now(const stilb_scene *scene, float field, float reach, uint32_t lamp, double seconds)
{
	return scene->stress_strings ? bulb_at(scene, field, lamp, seconds) : lamp_at(scene, field, reach, lamp, seconds);
}

/* Puts the lamps into the list, as they are at first. */
static void lamps_write(stilb_scene *scene)
{
	float field = lamp_field(scene), reach = lamp_reach(scene);
	for (uint32_t i = 0; i < scene->stress_lamps; i++)
		scene->lights[1 + i] = lamp_now(scene, field, reach, i, 0.0);
}

void stilb_scene_stress_hang_strings(stilb_scene *scene)
{
	STILB_ASSERT(scene && scene->stress_lamps > 0);
	scene->stress_strings = true;
	lamps_write(scene);
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
	lamps_write(scene);
	return STILB_OK;
}

/* In the space of the figure's head, left and right hand, whose nodes are those of scene_stress_figures.c. */
static const struct {
	uint32_t node;
	float place[3];
} carried_on[STILB_SCENE_CARRIED] = {{3, {0.0f, 0.2f, 0.0f}}, {5, {0.02f, -0.2f, 0.05f}}, {7, {-0.02f, -0.2f, 0.05f}}};

static stilb_scene_light carried_lamp(const stilb_scene *scene, uint32_t number)
{
	stilb_scene_light light = {
		.kind = STILB_SCENE_LIGHT_POINT, .falloff = STILB_SCENE_LIGHT_WINDOWED, .reach = CARRIED_REACH};
	scene_stress_color(lamp_random(scene, UINT32_MAX - number, LAMP_HUE, 0.0f, 1.0f), 0.7f, CARRIED_INTENSITY,
	                   light.intensity);
	memcpy(light.position, carried_on[number % STILB_SCENE_CARRIED].place, sizeof light.position);
	return light;
}

stilb_result stilb_scene_stress_add_carried(stilb_scene *scene)
{
	STILB_ASSERT(scene && scene->stress_models > 0 && scene->figures && scene->stress_carried == 0);
	uint32_t figures = 0, before = 1 + scene->stress_lamps;
	while (stilb_scene_figure_node(scene, 1 + figures, 0) != STILB_SCENE_NONE)
		figures++;
	uint32_t count = figures * STILB_SCENE_CARRIED;
	stilb_scene_light *lights = stilb_memory_alloc((size_t)before + count, sizeof *lights);
	if (!lights)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lamps that figures carry", count);
	memcpy(lights, scene->lights, before * sizeof *lights);
	free(scene->lights);
	scene->lights = lights;
	scene->stress_carried = count;
	for (uint32_t i = 0; i < count; i++)
		lights[before + i] = carried_lamp(scene, i);
	stilb_scene_stress_set_light(scene, STILB_SCENE_STRESS_LIGHT_NIGHT);
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < count && result == STILB_OK; i++) {
		uint32_t node = carried_on[i % STILB_SCENE_CARRIED].node;
		result = stilb_scene_attach_light(scene, before + i,
		                                  stilb_scene_figure_node(scene, 1 + i / STILB_SCENE_CARRIED, node));
	}
	return result;
}

void stilb_scene_stress_move_lamps(stilb_scene *scene, double seconds)
{
	STILB_ASSERT(scene && scene->stress_lamps > 0 && isfinite(seconds));
	float field = lamp_field(scene), reach = lamp_reach(scene);
	for (uint32_t i = 0; i < scene->stress_lamps; i++) {
		stilb_scene_light at = lamp_now(scene, field, reach, i, seconds);
		memcpy(scene->lights[1 + i].position, at.position, sizeof at.position);
		memcpy(scene->lights[1 + i].direction, at.direction, sizeof at.direction);
	}
}
