#include "gi/gi_surface.h"

#include "gi/gi_maps.h"
#include "gi/gi_texture.h"
#include "gi/gi_vector.h"
#include "gi/trace/gi_ray.h"
#include "shading/shade_layers.h"

#include <float.h>
#include <string.h>

/* Half the distance from 1 to the next float: the largest relative error of one rounding. */
#define ROUNDING 0x1p-24f

/* A barycentric coordinate (0 on an edge, 1 at the opposite corner): below this a hit counts as near an edge, and
 * point_inside moves it away from there if it must. */
#define NEAR_EDGE 0x1p-6f

/* The three vertices of a triangle as they lie in memory: position and normal.x, then normal.y, normal.z, u and v. */
typedef struct triangle_corners {
	stilb_vec4 first[3], second[3];
} triangle_corners;

static triangle_corners corners_of(const gi_part *part, uint32_t triangle)
{
	const uint32_t *index = part->triangles[triangle].vertex;
	triangle_corners corners;
	for (int i = 0; i < 3; i++) {
		const stilb_scene_vertex *vertex = &part->vertices[index[i]];
		memcpy(&corners.first[i], vertex, sizeof corners.first[i]);
		memcpy(&corners.second[i], (const char *)vertex + sizeof corners.first[i], sizeof corners.second[i]);
	}
	return corners;
}

static stilb_vec3 transform_point(const stilb_mat4 *m, stilb_vec3 p)
{
	stilb_vec4 column[4];
	memcpy(column, m->m, sizeof column);
	return column[0] * p[0] + column[1] * p[1] + column[2] * p[2] + column[3];
}

static stilb_vec3 rotate(const float m[9], stilb_vec3 n)
{
	return stilb_vec3_make(m[0] * n[0] + m[3] * n[1] + m[6] * n[2], m[1] * n[0] + m[4] * n[1] + m[7] * n[2],
	                       m[2] * n[0] + m[5] * n[1] + m[8] * n[2]);
}

static float smaller(float a, float b)
{
	return a < b ? a : b;
}

static float larger(float a, float b)
{
	return a > b ? a : b;
}

/* Normalised, also if its square would underflow or overflow. */
static stilb_vec3 unit_of(stilb_vec3 v)
{
	float square = stilb_vec3_dot(v, v);
	if (!(square > 1e-30f && square < 1e30f)) {
		v *= 1.0f / larger(larger(fabsf(v[0]), fabsf(v[1])), larger(fabsf(v[2]), FLT_MIN));
		square = stilb_vec3_dot(v, v);
	}
	return v * (1.0f / sqrtf(square));
}

/*
 * The sum of the following errors is how far from the triangle's plane a ray must start so that it does not hit the
 * triangle again; place_error is the first part. v0 is a corner, e1 and e2 the edges from it, u and v the hit's
 * barycentric coordinates, t the hit's distance along the ray, Ng the triangle's normal, not unit. Rounding errors in
 * units of ROUNDING:
 *
 * - The position is v0 + (u e1 + v e2). The last sum has an error of one unit of the position, and so has moving it off
 *   the plane; one more for safety: place_error.
 * - The terms in brackets have an error below 4 units of the edges' length. The intersector computes t from
 *   (v0 - origin) . Ng: difference, products and sum add 4 units of that length, and Ng itself 6 |a| |b| / |a x b|, as
 *   its components are differences of products, which nearly cancel in an obtuse triangle. a and b are the two shorter
 *   edges, as robust intersectors use: gi_triangle_shape_error.
 *
 * Source of the method: Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd ed. (2016), 3.9, which bounds the
 * error of t instead of the distance from the plane.
 */
static float place_error(stilb_vec3 position, stilb_vec3 unit)
{
	return 3.0f * ROUNDING *
	       (fabsf(unit[0] * position[0]) + fabsf(unit[1] * position[1]) + fabsf(unit[2] * position[2]));
}

float gi_triangle_shape_error(const float v0[3], const float v1[3], const float v2[3])
{
	stilb_vec3 corner = stilb_vec3_make(v0[0], v0[1], v0[2]);
	stilb_vec3 e1 = stilb_vec3_make(v1[0], v1[1], v1[2]) - corner, e2 = stilb_vec3_make(v2[0], v2[1], v2[2]) - corner;
	float a = gi_length(e1), b = gi_length(e2), c = gi_length(e2 - e1);
	float longest = larger(larger(a, b), c), area2 = gi_length(stilb_vec3_cross(e1, e2));
	float shorter = a * b * c / longest; /* product of the two shorter edges */
	return ROUNDING * longest * (8.0f + 6.0f * shorter / larger(area2, FLT_MIN));
}

float gi_triangle_error(const float v0[3], const float v1[3], const float v2[3])
{
	stilb_vec3 corner = stilb_vec3_make(v0[0], v0[1], v0[2]), largest = {0};
	stilb_vec3 e1 = stilb_vec3_make(v1[0], v1[1], v1[2]) - corner, e2 = stilb_vec3_make(v2[0], v2[1], v2[2]) - corner;
	for (int i = 0; i < 3; i++)
		largest[i] = larger(larger(fabsf(v0[i]), fabsf(v1[i])), fabsf(v2[i]));
	return place_error(largest, unit_of(stilb_vec3_cross(e1, e2))) + gi_triangle_shape_error(v0, v1, v2);
}

/* A unit normal that faces away from the viewer, bent towards it. */
static stilb_vec3 towards_viewer(stilb_vec3 normal, stilb_vec3 to_viewer)
{
	float seen = stilb_vec3_dot(normal, to_viewer);
	if (seen < GI_NORMAL_LOWEST)
		normal = stilb_vec3_normalize(normal + to_viewer * (GI_NORMAL_LOWEST - seen));
	return normal;
}

/* The interpolated normal, made unit and flipped to the side of the geometric normal (some files have it wrong). Where
 * the viewer sees the triangle's front but would be below the plane of the interpolated normal, that normal is bent
 * towards the viewer. */
static stilb_vec3 shading_normal(stilb_vec3 normal, stilb_vec3 geometric, stilb_vec3 to_viewer)
{
	float square = stilb_vec3_dot(normal, normal);
	if (!(square > GI_NORMAL_NONE))
		return geometric;
	normal *= 1.0f / sqrtf(square);
	if (stilb_vec3_dot(normal, geometric) < 0.0f)
		normal = -normal;
	return towards_viewer(normal, to_viewer);
}

static void material_at(const stilb_gi_scene *scene, const gi_part *part, gi_surface *surface)
{
	STILB_ASSERT(part->material < scene->material_count);
	const stilb_scene_material *material = &scene->materials[part->material];
	surface->diffuse = stilb_vec3_make(material->diffuse[0], material->diffuse[1], material->diffuse[2]);
	surface->specular = stilb_vec3_make(material->specular[0], material->specular[1], material->specular[2]);
	surface->emission = surface->unlit = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	if (surface->front)
		surface->emission = stilb_vec3_make(material->emission[0], material->emission[1], material->emission[2]);
	surface->roughness = material->roughness;
	surface->anisotropy = material->anisotropy;
	if (material->diffuse_texture && material->diffuse_texture <= scene->texture_count)
		surface->diffuse *= gi_texture_at(&scene->textures[material->diffuse_texture - 1], surface->uv);
}

gi_place gi_place_at(const gi_part *part, uint32_t triangle, float u, float v)
{
	const uint32_t *index = part->triangles[triangle].vertex;
	gi_place corners[3];
	for (int i = 0; i < 3; i++)
		corners[i] = gi_place_of(&part->vertices[index[i]], part->extras ? &part->extras[index[i]] : NULL);
	return gi_place_between(corners, u, v);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* A vector turned by an instance's transform, as long as it was. */
static stilb_vec3 turned_alike(const float matrix[9], stilb_vec3 v)
{
	stilb_vec3 turned = rotate(matrix, v);
	float square = stilb_vec3_dot(turned, turned);
	return square > GI_NORMAL_NONE ? turned * sqrtf(stilb_vec3_dot(v, v) / square) : turned;
}

stilb_vec3 gi_tangent_at(const gi_part *part, const gi_ray_hit *ray, float *sign)
{
	STILB_ASSERT(part->extras);
	const uint32_t *index = part->triangles[ray->hit.triangle].vertex;
	const float *a = part->extras[index[0]].tangent, *b = part->extras[index[1]].tangent,
				*c = part->extras[index[2]].tangent;
	stilb_vec3 first = gi_vector(a),
			   tangent = first + ((gi_vector(b) - first) * ray->hit.u + (gi_vector(c) - first) * ray->hit.v);
	*sign = part->mirrored ? -a[3] : a[3];
	if (!part->instance)
		return tangent;
	const float *m = part->to_world.m;
	const float matrix[9] = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
	return turned_alike(matrix, tangent);
}

/* Keeps light where a map turns the normal so far that the viewer, mirrored by it, is below the triangle: there a
 * highlight would be black, as at the rims of bumpy balls. The mirrored direction is lifted to just above the triangle,
 * and the normal is the one that mirrors to there. Source: Keller et al., "The Iray Light Transport Simulation and
 * Rendering System" (2017), A.3. */
static stilb_vec3 lifted_normal(stilb_vec3 normal, stilb_vec3 geometric, stilb_vec3 to_viewer)
{
	stilb_vec3 mirrored = normal * (2.0f * stilb_vec3_dot(normal, to_viewer)) - to_viewer;
	float above = stilb_vec3_dot(mirrored, geometric);
	if (above >= GI_NORMAL_LOWEST)
		return normal;
	mirrored = unit_of(mirrored + geometric * (GI_NORMAL_LOWEST - above));
	return unit_of(mirrored + to_viewer);
}

/* A map's normal `local`; normal: interpolated. */
static stilb_vec3 mapped_normal(const gi_part *part, const gi_ray_hit *ray, stilb_vec3 local, stilb_vec3 normal,
                                const gi_surface *surface)
{
	stilb_vec3 geometric = surface->geometric;
	float sign;
	stilb_vec3 tangent = gi_tangent_at(part, ray, &sign);
	if (!(stilb_vec3_dot(tangent, tangent) > GI_NORMAL_NONE))
		return surface->normal;
	if (!(stilb_vec3_dot(normal, normal) > GI_NORMAL_NONE))
		normal = surface->front ? geometric : -geometric;
	stilb_vec3 mapped = shade_gltf_turned(local, tangent, sign, normal);
	if (stilb_vec3_dot(normal, geometric) < 0.0f)
		mapped = -mapped; /* seen from behind all of it is turned over, with tangent and bitangent */
	stilb_vec3 to_viewer = -gi_ray_direction(&ray->ray);
	return lifted_normal(towards_viewer(mapped, to_viewer), geometric, to_viewer);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

#define GI_IOR_MIN 1.0001f   /* of a volume: below it directions are lost in rounding */
#define GI_PASS_MOST 0.9999f /* keeps the weight of a pane that is met finite */

/* A hit on a part with maps. */
typedef struct maps_hit {
	gi_maps maps;
	gi_place place;
	const gi_part *part;
	const gi_ray_hit *ray;
	stilb_vec3 normal; /* interpolated, of any length, in world space */
	stilb_vec4 color;  /* gi_maps_color */
} maps_hit;

/* Direction and strength of brushing: turned from the mesh's tangent, or, without one, from the tangent that frames
 * without tangents have everywhere, cross(up, normal). */
static void brushed_at(const maps_hit *at, const gi_surface *surface, gi_layers *layers)
{
	const stilb_scene_surface *s = at->maps.surface;
	stilb_vec3 n = surface->normal, tangent = {0};
	stilb_vec4 texel = gi_maps_texel(&at->maps, STILB_SCENE_MAP_ANISOTROPY, &at->place);
	float sign = 1.0f, x = 1.0f, y = 0.0f;
	if (at->part->extras)
		tangent = gi_tangent_at(at->part, at->ray, &sign);
	if (!(stilb_vec3_dot(tangent, tangent) > GI_NORMAL_NONE)) {
		tangent = stilb_vec3_make(n[2], 0.0f, -n[0]);
		sign = 1.0f;
	}
	if (gi_maps_have(&at->maps, STILB_SCENE_MAP_ANISOTROPY)) {
		x = 2.0f * texel[0] - 1.0f;
		y = 2.0f * texel[1] - 1.0f;
	}
	float c = cosf(s->anisotropy_rotation), turn = sinf(s->anisotropy_rotation);
	stilb_vec3 bitangent = stilb_vec3_cross(surface->front ? n : -n, tangent) * sign;
	layers->brushed = tangent * (c * x - turn * y) + bitangent * (turn * x + c * y);
	layers->anisotropy = s->anisotropy * texel[2];
}

/* What goes through the surface, once its other layers are known. */
static void through_at(const maps_hit *at, gi_surface *surface)
{
	const gi_maps *maps = &at->maps;
	const stilb_scene_surface *s = maps->surface;
	gi_layers *layers = &surface->layers;
	float share = s->transmission * gi_maps_texel(maps, STILB_SCENE_MAP_TRANSMISSION, &at->place)[0];
	stilb_vec3 v = -gi_ray_direction(&at->ray->ray);
	float metal = gi_maps_metalness(maps, &at->place);
	layers->through = stilb_vec3_make(at->color[0], at->color[1], at->color[2]) * (share * (1.0f - metal));
	layers->roughness = surface->roughness;
	surface->diffuse *= 1.0f - share;
	layers->solid = gi_maps_are_solid(s);
	if (layers->solid) {
		layers->ior = fmaxf(s->ior, GI_IOR_MIN);
		layers->left = stilb_vec3_make(1.0f, 1.0f, 1.0f);
		for (int i = 0; i < 3 && !surface->front; i++) /* Beer's law, over the ray's length inside */
			layers->left[i] = powf(s->attenuation[i], at->ray->ray.t_max / s->attenuation_distance);
		if (!surface->front) /* coat and sheen are on the outside */
			layers->coat = 0.0f, layers->sheen = (stilb_vec3){0};
		return;
	}
	if (surface->roughness > GI_PANE_ROUGHNESS)
		return;
	float n_dot_v = fminf(stilb_vec3_dot(surface->normal, v), 1.0f);
	float below = (1.0f - shade_coat_share(layers->coat, stilb_vec3_dot(layers->coat_normal, v))) *
	              shade_sheen_left(layers->sheen, n_dot_v, layers->sheen_roughness);
	layers->passed = layers->through * (below * shade_facet_left(surface->specular, n_dot_v));
	layers->pass = fminf(fmaxf(fmaxf(layers->passed[0], layers->passed[1]), layers->passed[2]), GI_PASS_MOST);
}

/* What is on the surface. smooth: the shading normal without maps. */
static __attribute__((noinline)) void layers_at(const maps_hit *at, stilb_vec3 smooth, gi_surface *surface)
{
	const gi_maps *maps = &at->maps;
	const stilb_scene_surface *s = maps->surface;
	const gi_place *place = &at->place;
	gi_layers *layers = &surface->layers;
	*layers = (gi_layers){.coat_normal = smooth};
	surface->layered = true;
	stilb_vec4 sheen = gi_maps_texel(maps, STILB_SCENE_MAP_SHEEN_COLOR, place);
	layers->sheen = gi_vector(s->sheen_color) * sheen;
	layers->sheen_roughness = s->sheen_roughness * gi_maps_texel(maps, STILB_SCENE_MAP_SHEEN_ROUGHNESS, place)[3];
	layers->coat = s->clearcoat * gi_maps_texel(maps, STILB_SCENE_MAP_CLEARCOAT, place)[0];
	layers->coat_roughness =
		s->clearcoat_roughness * gi_maps_texel(maps, STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS, place)[1];
	if (layers->coat > 0.0f && at->part->extras && gi_maps_have(maps, STILB_SCENE_MAP_CLEARCOAT_NORMAL)) {
		stilb_vec3 local = gi_maps_normal(maps, STILB_SCENE_MAP_CLEARCOAT_NORMAL, s->clearcoat_normal_scale, place);
		layers->coat_normal = mapped_normal(at->part, at->ray, local, at->normal, surface);
	}
	if (s->anisotropy > 0.0f)
		brushed_at(at, surface, layers);
	if (s->transmission > 0.0f)
		through_at(at, surface);
	float n_dot_v = -stilb_vec3_dot(layers->coat_normal, gi_ray_direction(&at->ray->ray));
	surface->emission *= (1.0f - shade_coat_share(layers->coat, n_dot_v)) / (1.0f - layers->pass);
}

/* What the part's surface says of the hit, in place of material_at. normal: interpolated, of any length, in world
 * space. Not inlined, so that gi_surface_at keeps its registers where there are no maps. */
static __attribute__((noinline)) void maps_at(const stilb_gi_scene *scene, const gi_part *part, const gi_ray_hit *ray,
                                              stilb_vec3 normal, gi_surface *surface)
{
	STILB_ASSERT(part->surface <= scene->surface_count);
	maps_hit at = {.maps = {&scene->surfaces[part->surface - 1], scene->textures, scene->texture_count},
	               .place = gi_place_at(part, ray->hit.triangle, ray->hit.u, ray->hit.v),
	               .part = part,
	               .ray = ray,
	               .normal = normal};
	const gi_maps *maps = &at.maps;
	at.color = gi_maps_color(maps, &at.place);
	if (maps->surface->unlit) {
		surface->unlit = stilb_vec3_make(at.color[0], at.color[1], at.color[2]);
		surface->diffuse = surface->specular = surface->emission = (stilb_vec3){0};
		return;
	}
	shade_gltf_base base = gi_maps_base(maps, &at.place, at.color);
	surface->diffuse = stilb_vec3_make(base.diffuse[0], base.diffuse[1], base.diffuse[2]);
	surface->specular = stilb_vec3_make(base.specular[0], base.specular[1], base.specular[2]);
	surface->roughness = base.roughness;
	if (surface->front)
		surface->emission = gi_maps_emission(maps, &at.place);
	stilb_vec3 smooth = surface->normal;
	if (part->extras && gi_maps_have(maps, STILB_SCENE_MAP_NORMAL)) {
		stilb_vec3 local = gi_maps_normal(maps, STILB_SCENE_MAP_NORMAL, maps->surface->normal_scale, &at.place);
		surface->normal = mapped_normal(part, ray, local, normal, surface);
	}
	if (gi_maps_are_layered(maps->surface))
		layers_at(&at, smooth, surface);
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* Each number of a transformed point is a sum of three products and a translation. */
float gi_transform_error(const gi_part *part, stilb_vec3 position)
{
	const float *t = part->to_world.m + 12;
	return 8.0f * ROUNDING * (gi_length(position) + gi_length(stilb_vec3_make(t[0], t[1], t[2])));
}

/* The point at the barycentric coordinates u and v, but at least 2 * error metres away from the triangle's edges: where
 * a wall meets a floor, rounding must not put a point of the floor behind the wall. */
static stilb_vec3 point_inside(const gi_part *part, const stilb_vec4 first[3], float u, float v, float error)
{
	stilb_vec3 corner[3];
	for (int i = 0; i < 3; i++)
		corner[i] = part->instance ? transform_point(&part->to_world, first[i]) : first[i];
	stilb_vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
	float share[3] = {1.0f - u - v, u, v};
	float edges[3] = {gi_length(e2 - e1), gi_length(e2), gi_length(e1)};
	float area2 = larger(gi_length(stilb_vec3_cross(e1, e2)), FLT_MIN), sum = 0.0f;
	for (int i = 0; i < 3; i++) {
		float least = 2.0f * error * edges[i] / area2;
		share[i] = larger(share[i], least < 0.25f ? least : 0.25f);
		sum += share[i];
	}
	return corner[0] + (e1 * (share[1] / sum) + e2 * (share[2] / sum));
}

void gi_surface_at(const stilb_gi_scene *scene, const gi_ray_hit *ray, gi_surface *surface)
{
	STILB_ASSERT(gi_is_hit(ray) && ray->hit.part < scene->part_count);
	const gi_part *part = &scene->parts[ray->hit.part];
	STILB_ASSERT(ray->hit.triangle < scene->meshes[part->mesh].triangle_count);
	triangle_corners corners = corners_of(part, ray->hit.triangle);
	float u = ray->hit.u, v = ray->hit.v;
	const stilb_vec4 *a = corners.first, *b = corners.second;
	stilb_vec4 first = a[0] + ((a[1] - a[0]) * u + (a[2] - a[0]) * v);
	stilb_vec4 second = b[0] + ((b[1] - b[0]) * u + (b[2] - b[0]) * v);
	stilb_vec3 from_viewer = stilb_vec3_make(ray->ray.direction[0], ray->ray.direction[1], ray->ray.direction[2]);
	stilb_vec3 geometric = unit_of(stilb_vec3_make(ray->hit.normal[0], ray->hit.normal[1], ray->hit.normal[2]));
	stilb_vec3 normal = stilb_vec3_make(first[3], second[0], second[1]);
	surface->position = first;
	surface->error = part->triangles[ray->hit.triangle].error;
	if (part->instance) {
		surface->position = transform_point(&part->to_world, first);
		surface->error = surface->error * part->stretch + gi_transform_error(part, surface->position);
		normal = part->surface ? turned_alike(part->normal_to_world, normal) : rotate(part->normal_to_world, normal);
	}
	surface->error += place_error(surface->position, geometric);
	if (smaller(smaller(u, v), 1.0f - u - v) < NEAR_EDGE)
		surface->position = point_inside(part, a, u, v, surface->error);
	surface->front = stilb_vec3_dot(geometric, from_viewer) <= 0.0f;
	surface->geometric = surface->front ? geometric : -geometric;
	surface->normal = shading_normal(normal, surface->geometric, -from_viewer);
	surface->uv = (stilb_vec2){second[2], second[3]};
	surface->part = ray->hit.part;
	surface->triangle = ray->hit.triangle;
	surface->layered = false;
	material_at(scene, part, surface);
	if (part->surface)
		maps_at(scene, part, ray, normal, surface);
}

stilb_vec3 gi_surface_ray_origin(const gi_surface *surface, stilb_vec3 direction)
{
	float side = stilb_vec3_dot(surface->geometric, direction) < 0.0f ? -1.0f : 1.0f;
	return surface->position + surface->geometric * (side * surface->error);
}
