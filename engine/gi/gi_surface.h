/*
 * gi_surface: the point that a ray hit, as shading needs it, and where the next ray may start. [any-thread]
 */
#ifndef STILB_GI_SURFACE_H
#define STILB_GI_SURFACE_H

#include "gi/gi_maps.h"
#include "gi/gi_scene_internal.h"

/* What gi_bsdf_make makes of layers for one viewer: probabilities of the lobes, 1 together, and what layers leave. */
typedef struct gi_lobes {
	float diffuse, highlight, sheen, coat, through;
	float coat_share, sheen_left; /* shade_layers.h */
	float eta;                    /* gi_glass.h; of a thin wall 1 */
	/* Probability that a light is asked for what it sends from the viewer's side, and from beyond. Both are 0 inside of
	 * a volume, whose walls would block every shadow ray; from beyond a volume nothing is asked either. */
	float ask, ask_beyond;
	stilb_vec3 beyond; /* origin of rays that leave on the other side */
} gi_lobes;

/* What lies on a surface, what goes through it, and how it is brushed: shade_layers.h. */
typedef struct gi_layers {
	stilb_vec3 coat_normal; /* as gi_surface.normal */
	stilb_vec3 sheen;       /* colour, [0, 1] */
	stilb_vec3 brushed;     /* direction along the surface, of any length; of anisotropy > 0 */
	stilb_vec3 through;     /* factor on what facets let through: colour and transmission, [0, 1] */
	stilb_vec3 passed; /* of a pane: factor on the light of a ray that goes straight through, its greatest is pass */
	stilb_vec3 left;   /* of a volume: what it has left of the light of the ray that came through it, [0, 1] */
	float roughness;   /* of what light goes through, whatever is brushed */
	float coat, coat_roughness, sheen_roughness, anisotropy; /* [0, 1] */
	float pass; /* of a pane, a thin wall that is smooth: probability that rays do not meet it, [0, 1); else 0 */
	float ior;  /* of a volume, > 1: index of refraction */
	gi_lobes lobes;
	bool solid; /* light goes into a volume, or out of it: front says which; false: the wall is thin */
} gi_layers;

/* The point where a ray hit. */
typedef struct gi_surface {
	stilb_vec3 position;          /* on the triangle */
	stilb_vec3 geometric;         /* unit normal of the triangle, on the side that the ray came from */
	stilb_vec3 normal;            /* shading normal, unit, on the same side */
	stilb_vec3 diffuse, specular; /* reflectance, textures included */
	stilb_vec3 emission;          /* towards the ray's origin; 0 on the back */
	stilb_vec3 unlit;             /* radiance that camera rays see, and no others: it lights nothing */
	float roughness, anisotropy;
	float
		error; /* metres: a ray that starts farther than this from the triangle, along geometric, cannot hit it again */
	stilb_vec2 uv;
	uint32_t part, triangle; /* indices: of the part in the scene, of the triangle in its mesh */
	bool front;              /* the ray came from the front side */
	bool layered;            /* the next member is set; else it is anything */
	gi_layers layers;
} gi_surface;

/* Roughest surface of a pane: it spreads what is behind by a few thousandths. */
#define GI_PANE_ROUGHNESS 0.05f
/* Square of a length: an interpolated normal that is not longer has no direction, and the triangle's own is used. */
#define GI_NORMAL_NONE 1e-12f
/* Smallest cosine between the shading normal and the direction to the viewer, and, where maps turn normals, between the
 * viewer's mirrored direction and the triangle's normal. */
#define GI_NORMAL_LOWEST 1e-3f

/* What the surface reflects, and lets through, of even light, about: diffuse, specular and transmitted colour. */
static inline stilb_vec3 gi_surface_albedo(const gi_surface *surface)
{
	stilb_vec3 albedo = surface->diffuse + surface->specular;
	return surface->layered ? albedo + surface->layers.through : albedo;
}

/* Fills surface for a ray that hit something: gi_is_hit(ray). */
void gi_surface_at(const stilb_gi_scene *scene, const gi_ray_hit *ray, gi_surface *surface);

/* A point of a part's triangle, as maps see it; u and v: barycentric. */
gi_place gi_place_at(const gi_part *part, uint32_t triangle, float u, float v);

/* The interpolated tangent, in world space, of any length, of a part with extras; 0: there is none. *sign: of the
 * bitangent. */
stilb_vec3 gi_tangent_at(const gi_part *part, const gi_ray_hit *ray, float *sign);

/* The origin of a ray that leaves the surface in this direction: surface->position, moved along the triangle's normal
 * (surface->geometric), to the side where the direction points, by surface->error and no more. From there the ray's
 * t_min may be 0: it does not hit this triangle again, and does not slip through a neighbouring one. */
stilb_vec3 gi_surface_ray_origin(const gi_surface *surface, stilb_vec3 direction);

/* The part of gi_surface.error that depends on the triangle's shape alone, metres in the space of its corners. For
 * gi_triangle.error. */
float gi_triangle_shape_error(const float v0[3], const float v1[3], const float v2[3]);

/* An upper bound of gi_surface.error over all points of a triangle in world space, metres. */
float gi_triangle_error(const float v0[3], const float v1[3], const float v2[3]);

/* The rounding error, metres, of two transforms of an instance: of a point to world space, and, in the intersector, of
 * the ray to mesh space. */
float gi_transform_error(const gi_part *part, stilb_vec3 position);

/* t_max of a shadow ray to a point on a light's triangle: the distance, shortened just enough that the ray does not hit
 * that triangle. error: gi_triangle_error of the triangle, metres; cosine > 0: between the ray and the triangle's
 * normal. 2^-21 of the distance is for the rounding of the ray's direction. */
static inline float gi_shadow_distance(float distance, float error, float cosine)
{
	STILB_ASSERT(distance >= 0.0f && error >= 0.0f && cosine >= 0.0f);
	float end = distance - (error + 0x1p-21f * distance) / cosine;
	return end > 0.0f ? end : 0.0f;
}

#endif
