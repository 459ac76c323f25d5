/* The integrator channel: what the first hit is made of, as frames show it (render/shaders/channel.glsl). */
#include "gi/gi_maps.h"
#include "gi/integrate/gi_integrator.h"
#include "gi/trace/gi_ray.h"
#include "shading/shade_srgb.h"

#include <math.h>

/* What a channel is read from. */
typedef struct channel_at {
	const gi_part *part;
	const gi_ray_hit *ray;
	gi_surface surface;
	gi_place place;
	gi_maps maps; /* its surface is NULL where the material has none */
} channel_at;

static stilb_vec3 channel_grey(float value)
{
	return stilb_vec3_make(value, value, value);
}

static stilb_vec3 channel_direction(stilb_vec3 direction)
{
	return 0.5f + 0.5f * direction;
}

static stilb_vec3 channel_place(stilb_vec2 uv)
{
	return stilb_vec3_make(uv[0] - floorf(uv[0]), uv[1] - floorf(uv[1]), 0.0f);
}

static stilb_vec3 channel_base(const channel_at *at)
{
	if (!at->maps.surface)
		return shade_gltf_unmixed(at->surface.diffuse, at->surface.specular).color;
	stilb_vec4 color = gi_maps_color(&at->maps, &at->place);
	return stilb_vec3_make(color[0], color[1], color[2]);
}

static stilb_vec3 channel_tangent(const channel_at *at)
{
	float sign;
	if (!at->part->extras || !at->maps.surface)
		return channel_grey(0.0f);
	stilb_vec3 tangent = gi_tangent_at(at->part, at->ray, &sign);
	float square = stilb_vec3_dot(tangent, tangent);
	return square > GI_NORMAL_NONE ? channel_direction(tangent * (1.0f / sqrtf(square))) : channel_grey(0.0f);
}

/* Of an unlit surface, which has colour and alpha alone, these are 0, but for occlusion. */
static float channel_number(const channel_at *at, stilb_scene_surface_channel channel)
{
	const stilb_scene_surface *surface = at->maps.surface;
	bool unlit = surface && surface->unlit;
	if (channel == STILB_SCENE_CHANNEL_ROUGHNESS)
		return unlit ? 0.0f : at->surface.roughness;
	if (channel == STILB_SCENE_CHANNEL_OCCLUSION)
		return surface && !unlit ? gi_maps_occlusion(&at->maps, &at->place) : 1.0f;
	if (channel == STILB_SCENE_CHANNEL_ALPHA)
		return surface && surface->alpha != STILB_SCENE_OPAQUE ? gi_maps_color(&at->maps, &at->place)[3] : 1.0f;
	STILB_ASSERT(channel == STILB_SCENE_CHANNEL_METALNESS);
	if (!surface)
		return shade_gltf_unmixed(at->surface.diffuse, at->surface.specular).metalness;
	return unlit ? 0.0f : gi_maps_metalness(&at->maps, &at->place);
}

static stilb_vec3 channel_value(const channel_at *at, stilb_scene_surface_channel channel)
{
	switch (channel) {
	case STILB_SCENE_CHANNEL_BASE:
		return channel_base(at);
	case STILB_SCENE_CHANNEL_NORMAL:
		return channel_direction(at->surface.normal);
	case STILB_SCENE_CHANNEL_TANGENT:
		return channel_tangent(at);
	case STILB_SCENE_CHANNEL_EMISSION: /* without what a coat takes */
		return at->surface.layered && at->surface.front ? gi_maps_emission(&at->maps, &at->place)
		                                                : at->surface.emission;
	case STILB_SCENE_CHANNEL_UV0:
		return channel_place(at->place.uv[0]);
	case STILB_SCENE_CHANNEL_UV1:
		return channel_place(at->maps.surface ? at->place.uv[1] : (stilb_vec2){0.0f, 0.0f});
	default:
		return channel_grey(channel_number(at, channel));
	}
}

static void channel_shade(gi_batch *batch)
{
	const stilb_gi_scene *scene = batch->view->scene;
	stilb_scene_surface_channel channel = batch->view->settings.channel;
	for (uint32_t i = 0; i < batch->count; i++) {
		const gi_ray_hit *ray = &batch->rays[i];
		batch->radiance[i] = channel_grey(0.0f);
		if (!gi_is_hit(ray))
			continue;
		const gi_part *part = &scene->parts[ray->hit.part];
		channel_at at = {.part = part, .ray = ray, .maps = {NULL, scene->textures, scene->texture_count}};
		uint32_t surface = scene->materials[part->material].surface; /* gi_part.surface lacks those that are even */
		if (surface > 0)
			at.maps.surface = &scene->surfaces[surface - 1];
		gi_surface_at(scene, ray, &at.surface);
		at.place = gi_place_at(part, ray->hit.triangle, ray->hit.u, ray->hit.v);
		batch->radiance[i] = channel_value(&at, channel);
	}
}

const gi_integrator gi_integrator_channel = {.shade = channel_shade};

bool gi_shows_data(const stilb_gi_settings *settings)
{
	return settings->integrator == STILB_GI_INTEGRATOR_CHANNEL &&
	       stilb_scene_channel_kind_of(settings->channel) == STILB_SCENE_CHANNEL_DATA;
}

void gi_data_to_light(float *rgb, size_t pixels)
{
	for (size_t i = 0; i < 3 * pixels; i++)
		rgb[i] = shade_srgb_to_linear(fminf(fmaxf(rgb[i], 0.0f), 1.0f));
}
