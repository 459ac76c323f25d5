/* A light of a scene's list as the formulas of shade_light.h take it. */
#ifndef STILB_SCENE_LIGHT_SHADE_H
#define STILB_SCENE_LIGHT_SHADE_H

#include "scene/scene.h"
#include "shading/shade_light.h"

/* [any-thread] */
static inline shade_light scene_light_shade(const stilb_scene_light *from)
{
	shade_light light = {
		.kind = (int)from->kind,
		.falloff = (int)from->falloff,
		.position = stilb_vec3_make(from->position[0], from->position[1], from->position[2]),
		.direction = stilb_vec3_make(from->direction[0], from->direction[1], from->direction[2]),
		.intensity = stilb_vec3_make(from->intensity[0], from->intensity[1], from->intensity[2]),
		.cos_inner = from->cos_inner,
		.cos_outer = from->cos_outer,
		.radius = from->radius,
		.half_x = stilb_vec3_make(from->half_x[0], from->half_x[1], from->half_x[2]),
		.half_y = stilb_vec3_make(from->half_y[0], from->half_y[1], from->half_y[2]),
		.reach = from->reach,
	};
	return light;
}

#endif
