/* Surfaces of every kind, for tests of what lights do on each: squares that face up, side by side, with textures for a
 * mask and for normals. */
#ifndef LIGHTS_SURFACES_H
#define LIGHTS_SURFACES_H

#include "render/maps/maps_stage.h"

enum { MATT, GLOSSY, UNLIT, MASKED, BLENDS, COATED, BRUSHED, GLASS, NORMALS, SHEEN, SURFACE_KINDS };

#define SQUARES 9         /* in rows of three, each higher than the one before */
#define SQUARE_HALF 0.4   /* half a square's side */
#define SQUARE_APART 0.6  /* of their middles */
#define SQUARE_ABOVE 0.05 /* of each over the one before */

static const uint8_t surface_bumped[4] = {150, 110, 240, 255}; /* every texel of the map of normals */

/* Textures 1 and 2 of a scene: a mask, of which a quarter is cut out, and normals. */
typedef struct surface_textures {
	stilb_image images[2];
} surface_textures;

static inline void surface_textures_add(surface_textures *textures, stilb_scene_build *build)
{
	textures->images[0] = image_even(4, (uint8_t[4]){200, 180, 160, 255}, STILB_IMAGE_U8_SRGB);
	textures->images[1] = image_even(4, surface_bumped, STILB_IMAGE_U8_LINEAR);
	((uint8_t *)textures->images[0].pixels)[3] = 0;
	for (int t = 0; t < 2; t++)
		stilb_scene_build_texture(build, &textures->images[t]);
}

/* After the scene has been built. */
static inline void surface_textures_finish(surface_textures *textures)
{
	for (int t = 0; t < 2; t++)
		stilb_image_finish(&textures->images[t]);
}

static inline stilb_scene_surface surface_of(int kind)
{
	if (kind == MATT)
		return surface_matt();
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.roughness = 0.4f;
	surface.metalness = kind == GLASS || kind == SHEEN ? 0.0f : 0.3f;
	memcpy(surface.color, (float[4]){0.8f, 0.5f + 0.05f * (float)kind, 0.3f, 1.0f}, sizeof surface.color);
	surface.unlit = kind == UNLIT;
	surface.clearcoat = kind == COATED ? 0.7f : 0.0f;
	surface.anisotropy = kind == BRUSHED ? 0.8f : 0.0f;
	surface.transmission = kind == GLASS ? 0.8f : 0.0f;
	if (kind == MASKED) {
		surface.alpha = STILB_SCENE_MASK;
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
		surface.cutoff = 0.5f;
	} else if (kind == BLENDS) {
		surface.alpha = STILB_SCENE_BLEND;
		surface.color[3] = 0.6f;
	} else if (kind == NORMALS) {
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = 2;
	} else if (kind == SHEEN) {
		memcpy(surface.sheen_color, (float[3]){0.4f, 0.5f, 0.6f}, sizeof surface.sheen_color);
		surface.sheen_roughness = 0.5f;
	}
	return surface;
}

/* The middle of a square; axis 0: x, 1: z. */
static inline double square_place(int number, int axis)
{
	return SQUARE_APART * (axis == 0 ? number % 3 - 1 : number / 3 - 1);
}

/* Shows nine squares: the first eight kinds and `ninth`. Each hides a little of the one before. */
static inline void squares_show(stage *s, int ninth)
{
	surface_textures textures;
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	surface_textures_add(&textures, build);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (int k = 0; k < SQUARES; k++) {
		stilb_scene_surface surface = surface_of(k < SQUARES - 1 ? k : ninth);
		stage_model(build, mesh, stage_material(build, &surface),
		            stilb_mat4_scale_translate((float)SQUARE_HALF, (float)square_place(k, 0),
		                                       (float)SQUARE_ABOVE * (float)k, (float)square_place(k, 1)));
	}
	stage_show(s, build);
	surface_textures_finish(&textures);
}

#endif
