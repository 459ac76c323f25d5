/* Shared by the files that bake impostors: the gathered model, and the rasteriser of one picture. */
#ifndef STILB_GEOMETRY_IMPOSTOR_INTERNAL_H
#define STILB_GEOMETRY_IMPOSTOR_INTERNAL_H

#include "geometry/geometry_impostor.h"

#define IMPOSTOR_MAX_LEVELS 18 /* of a texture of STILB_IMAGE_MAX_SIDE, and the last level */

/* A texture and its copies of half the sides each, linear red, green and blue, down to one texel. */
typedef struct impostor_texture {
	const stilb_image *image;
	uint32_t level_count;
	uint32_t width[IMPOSTOR_MAX_LEVELS], height[IMPOSTOR_MAX_LEVELS];
	float *texels[IMPOSTOR_MAX_LEVELS]; /* [height][width][3]; pieces of one allocation, the first's */
} impostor_texture;

/* geometry_impostor_texture.c. STILB_ERROR_MEMORY: *texture is {0}. */
stilb_result geometry_impostor_texture_make(const stilb_image *image, impostor_texture *texture);
/* Accepts {0}. */
void geometry_impostor_texture_finish(impostor_texture *texture);
/* The colour at uv, bilinear, repeated, of the copy whose texels are 2^level times as wide as the texture's, level
 * rounded and clamped to those that exist. */
stilb_vec3 geometry_impostor_texture_at(const impostor_texture *texture, const float uv[2], float level);

typedef struct impostor_vertex {
	float position[3]; /* radii from the centre */
	float normal[3];   /* unit, or 0: the triangle's own */
	float uv[2];
} impostor_vertex;

typedef struct impostor_triangle {
	uint32_t vertices[3];
	uint32_t part;
} impostor_triangle;

/* All parts in one space, from geometry_impostor.c. */
typedef struct impostor_model {
	uint32_t vertex_count, triangle_count, part_count;
	impostor_vertex *vertices;
	impostor_triangle *triangles;
	const stilb_geometry_impostor_part *parts;
	const impostor_texture **textures; /* [part_count] or NULL each */
	float most[3];                     /* diffuse reflectance is at most this: 1 - the impostor's specular */
} impostor_model;

/* A vertex in a picture: points from the left and the top in 1/256, and the height above the plate in radii. */
typedef struct impostor_place {
	int32_t x, y;
	float height;
} impostor_place;

/* A texel's eight numbers, as the maps have them; covered 0 until it has values of its own or of neighbours. */
typedef struct impostor_texel {
	float color[3], coverage;
	float normal[2], height, roughness;
	bool known;
} impostor_texel;

/* What a thread needs to draw a picture. */
typedef struct impostor_canvas {
	impostor_place *places;          /* [vertex_count] */
	float *heights;                  /* [points][points] of the nearest triangle so far */
	uint32_t *triangles;             /* [points][points] 1 + its index, 0: none */
	impostor_texel *texels, *spread; /* [side][side] */
} impostor_canvas;

/* geometry_impostor_draw.c: draws the picture with this place in the grid and writes it to the maps. */
void geometry_impostor_draw(const impostor_model *model, const stilb_geometry_impostor_desc *desc, uint32_t grid_x,
                            uint32_t grid_y, const impostor_canvas *canvas, const stilb_image *maps);

/* geometry_impostor.c: the inverse of an affine matrix; false: it has none. */
bool geometry_impostor_invert(const stilb_mat4 *matrix, stilb_mat4 *out);

#endif
