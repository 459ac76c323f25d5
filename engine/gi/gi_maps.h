/*
 * gi_maps: what a surface (scene_surface.h) says of one of its points: factors times texels times the colours of
 * vertices. Occlusion is not for rays, which find it, nor is the map of thickness. [any-thread]
 */
#ifndef STILB_GI_MAPS_H
#define STILB_GI_MAPS_H

#include "base/base_math.h"
#include "scene/scene.h"
#include "shading/shade_gltf.h"

/* A surface and the textures that its maps name. */
typedef struct gi_maps {
	const stilb_scene_surface *surface;
	const stilb_image *textures; /* [texture_count] */
	uint32_t texture_count;
} gi_maps;

/* A point of a surface, as maps see it. */
typedef struct gi_place {
	stilb_vec2 uv[2]; /* both sets */
	stilb_vec4 color; /* of the vertices, with alpha; 1 without */
} gi_place;

/* The place of a vertex; extra: NULL if the mesh has none. */
gi_place gi_place_of(const stilb_scene_vertex *vertex, const stilb_scene_vertex_extra *extra);

/* Between three places; u and v: barycentric, of the second and of the third. */
gi_place gi_place_between(const gi_place corners[3], float u, float v);

/* True if the surface has a map that rays read, so that it is not the same all over. */
bool gi_maps_vary(const stilb_scene_surface *surface);

/* Linear base colour (SPECULAR: diffuse colour) and alpha, [0, 1]. */
stilb_vec4 gi_maps_color(const gi_maps *maps, const gi_place *place);

/* True if the surface is more than its base: coated, sheen, brushed, or light passes through it. */
bool gi_maps_are_layered(const stilb_scene_surface *surface);

/* True if the surface bounds a volume, which light enters by refraction. */
static inline bool gi_maps_are_solid(const stilb_scene_surface *surface)
{
	return surface->transmission > 0.0f && surface->thickness > 0.0f;
}

/* True if rays from behind do not meet the surface; those inside of a volume do, to leave it. */
static inline bool gi_maps_are_one_sided(const stilb_scene_surface *surface)
{
	return surface->one_sided && !gi_maps_are_solid(surface);
}

/* The texel of a map, [0, 1]; 1 where there is none. */
stilb_vec4 gi_maps_texel(const gi_maps *maps, stilb_scene_map_kind kind, const gi_place *place);

/* What is shaded. color: of gi_maps_color. */
shade_gltf_base gi_maps_base(const gi_maps *maps, const gi_place *place, stilb_vec4 color);

/* [0, 1]: metalness, 0 of SPECULAR; and the share of even light that the map of occlusion lets through. */
float gi_maps_metalness(const gi_maps *maps, const gi_place *place);
float gi_maps_occlusion(const gi_maps *maps, const gi_place *place);

/* Radiance; not of a surface that is unlit. */
stilb_vec3 gi_maps_emission(const gi_maps *maps, const gi_place *place);

/* Share of the point that is there, [0, 1]: 1 or 0 of MASK. */
float gi_maps_alpha(const gi_maps *maps, const gi_place *place);

/* The same of a surface that is not OPAQUE, by what it needs of the place: the uv of the colour's map, and the
 * vertices' alpha. */
float gi_maps_alpha_at(const gi_maps *maps, stilb_vec2 uv, float alpha);

static inline bool gi_maps_have(const gi_maps *maps, stilb_scene_map_kind kind)
{
	uint32_t texture = maps->surface->maps[kind].texture;
	return texture > 0 && texture <= maps->texture_count;
}

/* Along tangent, bitangent and normal, unit; of a surface that has this map of normals, which scale is for. */
stilb_vec3 gi_maps_normal(const gi_maps *maps, stilb_scene_map_kind kind, float scale, const gi_place *place);

#endif
