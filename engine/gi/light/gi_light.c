#include "gi/light/gi_light.h"

#include "gi/gi_vector.h"
#include "gi/light/gi_environment.h"
#include "gi/light/gi_light_listed.h"
#include "shading/shade_constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SUN_FACING_MIN 0.02f /* least cosine at the surface, for choosing; the same as FACING_MIN of gi_light_lanes.h */

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* True if the colour, which may come from a file, is finite and above 0. */
static bool shines(const float color[3])
{
	return gi_brightness(gi_vector(color)) > 0.0f && isfinite(gi_brightness(gi_vector(color)));
}

/* faces: copy the lights with a face, too. */
static void copy_listed(const stilb_scene *scene, bool faces, gi_lights *lights)
{
	for (uint32_t i = 0; i < scene->light_count; i++)
		if (shines(scene->lights[i].intensity) && (faces || !scene->lights[i].face))
			lights->listed[lights->listed_count++] = gi_light_listed_make(&scene->lights[i]);
}

static void make_shapes(const gi_emitter *emitters, uint32_t count, gi_lights *lights)
{
	uint32_t glow_count = 0;
	for (uint32_t i = 0; i < count; i++) {
		gi_light_shape *shape = &lights->shapes[lights->shape_count];
		lights->shape_of[i] = lights->shape_count++;
		if (i + 1 < count && gi_light_shape_join(&emitters[i], &emitters[i + 1], shape)) {
			lights->shape_of[i + 1] = lights->shape_of[i];
			i++;
		} else {
			*shape = gi_light_shape_make(&emitters[i]);
			if (emitters[i].glow.maps.surface) {
				shape->glow = &lights->glows[glow_count];
				lights->glows[glow_count++] = emitters[i].glow;
			}
		}
	}
}

static gi_light_node shape_node(const gi_light_shape *shape)
{
	stilb_vec3 far = shape->rectangle ? shape->corner + shape->edge_1 + shape->edge_2 : shape->corner;
	stilb_vec3 one = shape->corner + shape->edge_1, two = shape->corner + shape->edge_2;
	gi_light_node node = {.cos_cone = 1.0f};
	for (int i = 0; i < 3; i++) {
		node.low[i] = fminf(fminf(shape->corner[i], far[i]), fminf(one[i], two[i]));
		node.high[i] = fmaxf(fmaxf(shape->corner[i], far[i]), fmaxf(one[i], two[i]));
		node.axis[i] = shape->normal[i];
	}
	float emission[3] = {shape->emission[0], shape->emission[1], shape->emission[2]};
	node.power = shape->area * (shines(emission) ? gi_brightness(gi_vector(emission)) : 0.0f);
	return node;
}

/* Shapes and lights with a position become leaves of the tree, numbered shapes first; directional lights are listed
 * apart. False: no memory. */
static bool make_choice(gi_lights *lights, gi_light_node *leaves)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < lights->shape_count; i++) {
		gi_light_node node = shape_node(&lights->shapes[i]);
		node.light = i;
		if (node.power > 0.0f)
			leaves[count++] = node;
	}
	for (uint32_t i = 0; i < lights->listed_count; i++) {
		if (lights->listed[i].light.kind == STILB_SCENE_LIGHT_DIRECTIONAL) {
			lights->suns[lights->sun_count++] = i;
			continue;
		}
		leaves[count] = gi_light_listed_node(&lights->listed[i]);
		leaves[count++].light = lights->shape_count + i;
	}
	lights->placed_count = count;
	for (uint32_t i = 0; i < lights->shape_count; i++)
		lights->leaf_of[i] = GI_LIGHT_LEAF;
	if (count == 0)
		return true;
	if (!gi_light_tree_build(leaves, count, &lights->tree))
		return false;
	for (uint32_t i = 0; i < lights->tree.node_count; i++)
		if (lights->tree.nodes[i].child == GI_LIGHT_LEAF && lights->tree.nodes[i].light < lights->shape_count)
			lights->leaf_of[lights->tree.nodes[i].light] = i;
	return true;
}

/* Every emitter has a shape, every leaf of the tree stands for the light that refers to it, every distant light exists.
 * For STILB_CHECK. */
static bool lights_are_sound(const gi_lights *lights)
{
	for (uint32_t i = 0; i < lights->emitter_count; i++)
		if (lights->shape_of[i] >= lights->shape_count)
			return false;
	for (uint32_t i = 0; i < lights->shape_count; i++) {
		uint32_t leaf = lights->leaf_of[i];
		if (leaf != GI_LIGHT_LEAF && (leaf >= lights->tree.node_count || lights->tree.nodes[leaf].light != i))
			return false;
	}
	for (uint32_t i = 0; i < lights->sun_count; i++)
		if (lights->suns[i] >= lights->listed_count)
			return false;
	return true;
}

/* Fills in lights, whose emitter_count and environment are set. */
static stilb_result lights_fill(const stilb_scene *scene, const gi_emitter *emitters, bool faces, gi_lights *lights)
{
	uint32_t emitter_count = lights->emitter_count;
	STILB_ASSERT(emitters || emitter_count == 0);
	stilb_result result = STILB_OK;
	size_t listed = scene->light_count, placed = listed + emitter_count;
	gi_light_node *leaves = stilb_memory_alloc(placed, sizeof *leaves);
	lights->listed = stilb_memory_alloc(listed, sizeof *lights->listed);
	lights->suns = stilb_memory_alloc(listed, sizeof *lights->suns);
	size_t glows = 0;
	for (uint32_t i = 0; i < emitter_count; i++)
		glows += emitters[i].glow.maps.surface ? 1 : 0;
	lights->glows = stilb_memory_alloc(glows, sizeof *lights->glows);
	lights->shapes = stilb_memory_alloc(emitter_count, sizeof *lights->shapes);
	lights->shape_of = stilb_memory_alloc(emitter_count, sizeof *lights->shape_of);
	lights->leaf_of = stilb_memory_alloc(emitter_count, sizeof *lights->leaf_of);
	bool filled = leaves && lights->listed && lights->suns && lights->glows && lights->shapes && lights->shape_of &&
	              lights->leaf_of;
	if (filled) {
		copy_listed(scene, faces, lights);
		make_shapes(emitters, emitter_count, lights);
		filled = make_choice(lights, leaves);
	}
	if (filled) {
		STILB_CHECK(lights_are_sound(lights));
	} else {
		gi_lights_destroy(lights);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", emitter_count + scene->light_count);
	}
	free(leaves);
	return result;
}

stilb_result gi_lights_create(const stilb_scene *scene, const gi_emitter *emitters, uint32_t emitter_count,
                              gi_lights *lights)
{
	STILB_ASSERT(scene && lights);
	STILB_ASSERT(emitters || emitter_count == 0);
	*lights = (gi_lights){.emitter_count = emitter_count};
	stilb_result result = gi_environment_create(scene, &lights->environment);
	if (result == STILB_OK)
		return lights_fill(scene, emitters, false, lights);
	*lights = (gi_lights){0};
	return result;
}

stilb_result gi_lights_create_open(const stilb_scene *scene, const gi_lights *lights, gi_lights *open)
{
	STILB_ASSERT(scene && lights && lights->environment && open);
	*open = (gi_lights){.environment = lights->environment, .shares_environment = true};
	return lights_fill(scene, NULL, true, open);
}

void gi_lights_destroy(gi_lights *lights)
{
	if (!lights->shares_environment)
		gi_environment_destroy(lights->environment);
	free(lights->listed);
	free(lights->suns);
	free(lights->glows);
	free(lights->shapes);
	free(lights->shape_of);
	free(lights->leaf_of);
	gi_light_tree_finish(&lights->tree);
	*lights = (gi_lights){0};
}

/* ---- suns -------------------------------------------------------------------------------------------------------- */

/* Estimate of the irradiance that a directional light gives to a surface. */
static float sun_importance(const gi_lights *lights, uint32_t sun, stilb_vec3 normal)
{
	const stilb_scene_light *light = &lights->listed[lights->suns[sun]].light;
	float facing = -stilb_vec3_dot(gi_vector(light->direction), normal);
	return gi_brightness(gi_vector(light->intensity)) * (facing > SUN_FACING_MIN ? facing : SUN_FACING_MIN);
}

/* Half of the probability is shared equally, since nothing is known of what hides them, half by estimated
 * irradiance. */
static uint32_t choose_sun(const gi_lights *lights, stilb_vec3 normal, float u, float *probability)
{
	STILB_ASSERT(lights->sun_count > 0);
	*probability = 1.0f;
	float all = 0.0f;
	for (uint32_t sun = 0; sun < lights->sun_count && lights->sun_count > 1; sun++)
		all += sun_importance(lights, sun, normal);
	uint32_t chosen = 0;
	for (uint32_t sun = 0; sun < lights->sun_count && lights->sun_count > 1; sun++) {
		chosen = sun;
		*probability = 0.5f / (float)lights->sun_count + 0.5f * sun_importance(lights, sun, normal) / all;
		if (u < *probability)
			break;
		u -= *probability;
	}
	return lights->suns[chosen];
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

uint32_t gi_light_choose(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, float u_choice,
                         float *probability)
{
	STILB_ASSERT(lights->placed_count > 0);
	uint32_t leaf = gi_light_tree_choose(&lights->tree, position, normal, u_choice, probability);
	return leaf == GI_LIGHT_LEAF ? GI_LIGHT_LEAF : lights->tree.nodes[leaf].light;
}

const struct gi_light_shape *gi_light_rectangle(const gi_lights *lights, uint32_t light)
{
	return light < lights->shape_count && lights->shapes[light].rectangle ? &lights->shapes[light] : NULL;
}

bool gi_light_sample_chosen(const gi_lights *lights, uint32_t light, stilb_vec3 position, stilb_vec2 u,
                            gi_light_sample *sample)
{
	STILB_ASSERT(light < lights->shape_count + lights->listed_count);
	return light < lights->shape_count
	           ? gi_light_shape_sample(&lights->shapes[light], position, u, sample)
	           : gi_light_listed_sample(&lights->listed[light - lights->shape_count], position, u, sample);
}

static bool sample_placed(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, float u_choice, stilb_vec2 u,
                          gi_light_sample *sample)
{
	float probability;
	uint32_t light = gi_light_choose(lights, position, normal, u_choice, &probability);
	if (light == GI_LIGHT_LEAF || !gi_light_sample_chosen(lights, light, position, u, sample))
		return false;
	sample->pdf *= probability;
	return true;
}

bool gi_light_is_asked(const gi_lights *lights, gi_light_group group, bool all)
{
	if (group == GI_LIGHT_PLACED)
		return lights->placed_count > 0;
	if (group == GI_LIGHT_SUNS)
		return lights->sun_count > 0;
	return gi_environment_is_sampled(lights->environment, all);
}

bool gi_light_sample_at(const gi_lights *lights, gi_light_group group, bool all, stilb_vec3 position, stilb_vec3 normal,
                        float u_choice, stilb_vec2 u, gi_light_sample *sample)
{
	STILB_ASSERT(gi_light_is_asked(lights, group, all));
	STILB_ASSERT(u_choice >= 0.0f && u_choice < 1.0f);
	STILB_ASSERT(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
	if (group == GI_LIGHT_PLACED)
		return sample_placed(lights, position, normal, u_choice, u, sample);
	if (group == GI_LIGHT_AROUND)
		return gi_environment_sample(lights->environment, all, normal, u, sample);
	float probability;
	uint32_t sun = choose_sun(lights, normal, u_choice, &probability);
	if (!gi_light_listed_sample(&lights->listed[sun], position, u, sample))
		return false;
	sample->pdf *= probability;
	return true;
}

float gi_light_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, uint32_t light, float distance)
{
	STILB_ASSERT(light < lights->emitter_count);
	uint32_t shape = lights->shape_of[light];
	if (lights->leaf_of[shape] == GI_LIGHT_LEAF)
		return 0.0f;
	return gi_light_shape_density(&lights->shapes[shape], position, distance) *
	       gi_light_tree_probability(&lights->tree, position, normal, lights->leaf_of[shape]);
}

float gi_environment_pdf(const gi_lights *lights, stilb_vec3 normal, stilb_vec3 direction, bool all)
{
	return gi_environment_density(lights->environment, all, normal, direction);
}

stilb_vec3 gi_environment_radiance(const gi_lights *lights, stilb_vec3 direction)
{
	STILB_ASSERT(lights->environment);
	return gi_environment_at(lights->environment, direction);
}
