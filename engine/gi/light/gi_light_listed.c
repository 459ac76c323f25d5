#include "gi/light/gi_light_listed.h"

#include "gi/gi_vector.h"
#include "shading/shade_constants.h"
#include "shading/shade_frame.h"
#include "shading/shade_light.h"

#include <math.h>
#include <string.h>

gi_light_listed gi_light_listed_make(const stilb_scene_light *light)
{
	STILB_ASSERT(!stilb_scene_light_mistake(light));
	gi_light_listed listed = {.light = *light};
	if (light->kind != STILB_SCENE_LIGHT_RECTANGLE)
		return listed;
	stilb_vec3 x = gi_vector(light->half_x), y = gi_vector(light->half_y), across = stilb_vec3_cross(x, y);
	if (stilb_vec3_dot(across, gi_vector(light->direction)) < 0.0f)
		y = -y;
	stilb_vec3 corner = gi_vector(light->position) - x - y;
	gi_light_shape *shape = &listed.shape;
	*shape = (gi_light_shape){.corner = corner,
	                          .edge_1 = 2.0f * x,
	                          .edge_2 = 2.0f * y,
	                          .normal = gi_vector(light->direction),
	                          .center = gi_vector(light->position),
	                          .length_1 = 2.0f * gi_length(x),
	                          .length_2 = 2.0f * gi_length(y),
	                          .rectangle = true};
	shape->unit_1 = shape->edge_1 * (1.0f / shape->length_1);
	shape->unit_2 = shape->edge_2 * (1.0f / shape->length_2);
	shape->area = shape->length_1 * shape->length_2;
	shape->emission = gi_vector(light->intensity) * (1.0f / shape->area);
	return listed;
}

/* ---- sampling ---------------------------------------------------------------------------------------------------- */

static bool sample_distant(const stilb_scene_light *light, gi_light_sample *sample)
{
	STILB_ASSERT(light->kind == STILB_SCENE_LIGHT_DIRECTIONAL);
	*sample = (gi_light_sample){
		.direction = -gi_vector(light->direction),
		.distance = INFINITY,
		.radiance = gi_vector(light->intensity),
		.pdf = 1.0f,
		.delta = true,
	};
	return true;
}

static bool sample_point(const stilb_scene_light *light, stilb_vec3 position, gi_light_sample *sample)
{
	stilb_vec3 to_light = gi_vector(light->position) - position;
	float distance2 = stilb_vec3_dot(to_light, to_light), distance = sqrtf(distance2);
	stilb_vec3 direction = to_light * (1.0f / distance);
	bool spot = light->kind == STILB_SCENE_LIGHT_SPOT;
	float share = spot ? shade_spot_share(-stilb_vec3_dot(gi_vector(light->direction), direction), light->cos_inner,
	                                      light->cos_outer)
	                   : 1.0f;
	*sample = (gi_light_sample){
		.direction = direction,
		.distance = distance,
		.radiance = gi_vector(light->intensity) * (share / distance2),
		.pdf = 1.0f,
	};
	return distance2 > 0.0f && share > 0.0f;
}

/* From inside the sphere a hemisphere of it is seen, around the direction to its centre, so that nothing jumps at its
 * surface. */
static bool sample_sphere(const stilb_scene_light *light, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample)
{
	stilb_vec3 to_light = gi_vector(light->position) - position;
	float distance2 = stilb_vec3_dot(to_light, to_light), radius2 = light->radius * light->radius;
	if (!(distance2 > 0.0f))
		return false;
	float sine2 = fminf(radius2 / distance2, 1.0f), depth = sine2 / (1.0f + sqrtf(1.0f - sine2)); /* 1 - cosine */
	float below = u[0] * depth, cosine = 1.0f - below, sine = sqrtf(below * (2.0f - below));
	float phi = 2.0f * SHADE_PI * u[1], distance = sqrtf(distance2);
	shade_frame frame = shade_frame_from_normal(to_light * (1.0f / distance));
	float inside2 = radius2 - distance2 * sine * sine; /* the square of half the chord */
	*sample = (gi_light_sample){
		.direction = frame.t * (sine * cosf(phi)) + frame.b * (sine * sinf(phi)) + frame.n * cosine,
		.distance = fmaxf(distance * cosine - sqrtf(fmaxf(inside2, 0.0f)), 0.0f),
		.radiance = shade_radiance_from_intensity(gi_vector(light->intensity), light->radius),
		.pdf = 1.0f / (2.0f * SHADE_PI * depth),
	};
	return true;
}

static bool sample_disk(const stilb_scene_light *light, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample)
{
	stilb_vec3 normal = gi_vector(light->direction);
	shade_frame frame = shade_frame_from_normal(normal);
	float radius = light->radius * sqrtf(u[0]), phi = 2.0f * SHADE_PI * u[1];
	stilb_vec3 to_light = gi_vector(light->position) - position;
	float height = -stilb_vec3_dot(to_light, normal);
	if (!(height > 0.0f))
		return false;
	to_light += frame.t * (radius * cosf(phi)) + frame.b * (radius * sinf(phi));
	float distance = gi_length(to_light), area = SHADE_PI * light->radius * light->radius;
	*sample = (gi_light_sample){
		.direction = to_light * (1.0f / distance),
		.distance = distance,
		.radiance = shade_radiance_from_intensity(gi_vector(light->intensity), light->radius),
		.pdf = distance * distance * distance / (height * area),
	};
	return true;
}

static bool sample_kind(const gi_light_listed *listed, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample)
{
	const stilb_scene_light *light = &listed->light;
	switch (light->kind) {
	case STILB_SCENE_LIGHT_SPHERE:
		return sample_sphere(light, position, u, sample);
	case STILB_SCENE_LIGHT_DISK:
		return sample_disk(light, position, u, sample);
	case STILB_SCENE_LIGHT_RECTANGLE:
		return gi_light_shape_sample(&listed->shape, position, u, sample);
	default:
		return sample_point(light, position, sample);
	}
}

/* The share of the light that its falloff leaves at position. */
static float share_at(const stilb_scene_light *light, stilb_vec3 position)
{
	stilb_vec3 away = gi_vector(light->position) - position;
	bool round = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
	return shade_falloff_share((int)light->falloff, stilb_vec3_dot(away, away), round ? light->radius : 0.0f,
	                           light->reach);
}

bool gi_light_listed_sample(const gi_light_listed *listed, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample)
{
	const stilb_scene_light *light = &listed->light;
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL)
		return sample_distant(light, sample);
	bool found = sample_kind(listed, position, u, sample);
	sample->delta = true;
	if (!found || light->falloff == STILB_SCENE_LIGHT_PHYSICAL)
		return found;
	float share = share_at(light, position);
	sample->radiance *= share;
	return share > 0.0f;
}

/* ---- the tree ---------------------------------------------------------------------------------------------------- */

/* Half of the light's box along each axis. */
static void half_box(const stilb_scene_light *light, float half[3])
{
	for (int i = 0; i < 3; i++)
		switch (light->kind) {
		case STILB_SCENE_LIGHT_SPHERE:
		case STILB_SCENE_LIGHT_DISK:
			half[i] = light->radius;
			break;
		case STILB_SCENE_LIGHT_RECTANGLE:
			half[i] = fabsf(light->half_x[i]) + fabsf(light->half_y[i]);
			break;
		default:
			half[i] = 0.0f;
		}
}

/* A sphere counts as a light without a size in a box. */
gi_light_node gi_light_listed_node(const gi_light_listed *listed)
{
	const stilb_scene_light *light = &listed->light;
	bool spot = light->kind == STILB_SCENE_LIGHT_SPOT;
	bool flat = light->kind == STILB_SCENE_LIGHT_DISK || light->kind == STILB_SCENE_LIGHT_RECTANGLE;
	float half[3];
	half_box(light, half);
	gi_light_node node = {.cos_cone = spot || flat ? 1.0f : -1.0f, .cos_beam = spot ? light->cos_outer : -1.0f};
	if (flat)
		node.cos_beam = 0.0f;
	for (int i = 0; i < 3; i++) {
		node.low[i] = light->position[i] - half[i];
		node.high[i] = light->position[i] + half[i];
		node.axis[i] = light->direction[i];
	}
	node.power = gi_brightness(gi_vector(light->intensity));
	node.lamps = flat ? 0.0f : node.power;
	return node;
}
