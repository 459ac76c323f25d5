/*
 * gi_primary_lanes: loops over sixteen camera rays in plain C, which the compiler vectorises. Included by one file
 * for each instruction set, which defines KERNELS as the name of its table.
 */
#ifndef STILB_GI_PRIMARY_LANES_H
#define STILB_GI_PRIMARY_LANES_H

#include "gi/film/gi_primary.h"
#include "gi/sample/gi_sampler_kernels.h"
#include "gi/trace/gi_packet.h"

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void lanes_sobol(const gi_point *points, uint32_t dimension, uint32_t count, float *u, float *v)
{
	STILB_ASSERT(count % 16 == 0 && (uintptr_t)points % 8 == 0);
	for (uint32_t first = 0; first < count; first += 16) {
		uint32_t columns[4][16]; /* the points, transposed: low and high half of the hash; index; count */
		float pair[2][16];
		for (uint32_t lane = 0; lane < 16; lane += 4)
			gi_packet_gather(&points[first + lane], sizeof *points, &columns[0][lane]);
		for (int i = 0; i < 16; i++) {
			uint32_t low = columns[0][i], high = columns[1][i], index = gi_reverse(columns[2][i]);
			uint32_t x = gi_reverse(gi_owen_hash(index, gi_seed_halves(low, high, GI_SEED_SHUFFLE + dimension)));
			pair[0][i] = gi_owen_fraction(x, gi_seed_halves(low, high, dimension));
			pair[1][i] = gi_owen_fraction(gi_sobol_second(x), gi_seed_halves(low, high, dimension + 1));
		}
		memcpy(u + first, pair[0], sizeof pair[0]);
		memcpy(v + first, pair[1], sizeof pair[1]);
	}
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static void lanes_pinhole(const gi_camera *camera, const float *x, const float *y, gi_ray16 *rays)
{
	stilb_vec3 right = camera->right, up = camera->up, forward = camera->forward;
	for (int i = 0; i < 16; i++) {
		float a = x[i] * camera->to_u - camera->half_width, b = camera->half_height - y[i] * camera->to_v;
		float dx = forward[0] + right[0] * a + up[0] * b, dy = forward[1] + right[1] * a + up[1] * b,
			  dz = forward[2] + right[2] * a + up[2] * b;
		float unit = 1.0f / sqrtf(dx * dx + dy * dy + dz * dz);
		rays->origin[0][i] = camera->position[0];
		rays->origin[1][i] = camera->position[1];
		rays->origin[2][i] = camera->position[2];
		rays->direction[0][i] = dx * unit;
		rays->direction[1][i] = dy * unit;
		rays->direction[2][i] = dz * unit;
	}
}

/* Where the rays meet the clip planes, as in gi_camera_ray. */
static void lanes_clip(const gi_camera *camera, gi_ray16 *rays)
{
	stilb_vec3 forward = camera->forward;
	for (int i = 0; i < 16; i++) {
		float cosine = rays->direction[0][i] * forward[0] + rays->direction[1][i] * forward[1] +
		               rays->direction[2][i] * forward[2];
		rays->t_min[i] = camera->near_z / cosine;
		rays->t_max[i] = camera->far_z / cosine;
	}
}

/* Rays through a lens with an aperture, one lane (ray) at a time: the C library's sines and cosines are scalar. */
static void lanes_lens(const gi_camera *camera, const gi_primary_places *places, uint32_t first, gi_ray16 *rays)
{
	for (uint32_t i = 0; i < 16; i++) {
		gi_ray_hit ray;
		stilb_vec2 lens = {places->lens_u[first + i], places->lens_v[first + i]};
		gi_camera_ray(camera, places->x[first + i], places->y[first + i], lens, &ray);
		rays->origin[0][i] = ray.ray.origin[0];
		rays->origin[1][i] = ray.ray.origin[1];
		rays->origin[2][i] = ray.ray.origin[2];
		rays->direction[0][i] = ray.ray.direction[0];
		rays->direction[1][i] = ray.ray.direction[1];
		rays->direction[2][i] = ray.ray.direction[2];
	}
}

static void lanes_rays(const gi_camera *camera, const gi_primary_places *places, uint32_t first, gi_ray_hit16 *rays)
{
	STILB_ASSERT(first % 16 == 0 && first < GI_BATCH);
	if (camera->lens.radius > 0.0f)
		lanes_lens(camera, places, first, &rays->ray);
	else
		lanes_pinhole(camera, places->x + first, places->y + first, &rays->ray);
	lanes_clip(camera, &rays->ray);
	for (int i = 0; i < 16; i++) {
		rays->ray.time[i] = 0.0f;
		rays->ray.mask[i] = GI_MASK_LOOK;
		rays->ray.id[i] = rays->ray.flags[i] = 0;
		rays->hit.part[i] = rays->hit.instance[i] = GI_NO_PART;
	}
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

static stilb_vec4 lanes_four(const float *from)
{
	stilb_vec4 four;
	memcpy(&four, from, sizeof four);
	return four;
}

static void lanes_store(stilb_vec4 four, float *to)
{
	memcpy(to, &four, sizeof four);
}

/* Writes a lane's reflectance and its interpolated normal, not yet unit, with the texture coordinate u in [3], because
 * the vertices are loaded as whole vectors. True if the part is plain (not textured), so that these are final; else
 * lanes_rare writes them again. */
static bool lanes_row(const gi_primary_packet *packet, uint32_t lane, float albedo[4], float normal[4])
{
	const gi_part *part = packet->parts[lane];
	if (!part) {
		lanes_store((stilb_vec4){0}, normal);
		lanes_store((stilb_vec4){0}, albedo);
		return true;
	}
	const uint32_t *index = packet->triangles[lane]->vertex;
	stilb_vec4 a = lanes_four(part->vertices[index[0]].normal);
	stilb_vec4 b = lanes_four(part->vertices[index[1]].normal) - a, c = lanes_four(part->vertices[index[2]].normal) - a;
	stilb_vec4 n = a + (b * packet->rays.hit.u[lane] + c * packet->rays.hit.v[lane]);
	const float *m = part->normal_to_world;
	if (part->instance)
		n = (stilb_vec4){m[0], m[1], m[2]} * n[0] + (stilb_vec4){m[3], m[4], m[5]} * n[1] +
		    (stilb_vec4){m[6], m[7], m[8]} * n[2];
	lanes_store(n, normal);
	lanes_store(lanes_four(part->albedo), albedo);
	return part->plain;
}

/* Makes the normals unit and flips them to the geometric normal's side, which faces the viewer. Marks the lanes that
 * need what only gi_surface_at does, as they have no normal, or one that faces away from the viewer; true if there are
 * some. */
static bool lanes_normals(const gi_ray_hit16 *rays, float normals[3][16], int32_t rare[16])
{
	int32_t some = 0;
	for (int i = 0; i < 16; i++) {
		float x = normals[0][i], y = normals[1][i], z = normals[2][i];
		float dx = rays->ray.direction[0][i], dy = rays->ray.direction[1][i], dz = rays->ray.direction[2][i];
		float gx = rays->hit.normal[0][i], gy = rays->hit.normal[1][i], gz = rays->hit.normal[2][i];
		float square = x * x + y * y + z * z;
		int32_t miss = rays->hit.part[i] == GI_NO_PART, none = !(square > GI_NORMAL_NONE);
		float unit = 1.0f / sqrtf(none ? 1.0f : square);
		float from_viewer = gx * dx + gy * dy + gz * dz, from_normal = gx * x + gy * y + gz * z;
		float side = from_viewer * from_normal > 0.0f ? -unit : unit;
		normals[0][i] = x *= side;
		normals[1][i] = y *= side;
		normals[2][i] = z *= side;
		rare[i] |= (!miss) & (none | !(-(x * dx + y * dy + z * dz) >= GI_NORMAL_LOWEST));
		some |= rare[i];
	}
	return some;
}

/* Infinite where nothing was hit up to the far plane. */
static void lanes_depths(const gi_camera *camera, const gi_ray_hit16 *rays, float *restrict depths)
{
	for (int i = 0; i < 16; i++) {
		float t = rays->hit.part[i] == GI_NO_PART ? INFINITY : rays->ray.t_max[i];
		depths[i] =
			t * (rays->ray.direction[0][i] * camera->forward[0] + rays->ray.direction[1][i] * camera->forward[1] +
		         rays->ray.direction[2][i] * camera->forward[2]);
	}
}

/* Writes lane i again by gi_surface_at: for textures, instances, and normals that need correction. */
static void lanes_rare(const stilb_gi_scene *scene, uint32_t i, gi_primary *out)
{
	gi_surface surface;
	gi_surface_at(scene, &out->rays[i], &surface);
	lanes_store(gi_surface_albedo(&surface) + surface.unlit, out->albedo[i]);
	lanes_store(surface.normal, out->normal[i]);
}

static void lanes_surfaces(const stilb_gi_scene *scene, const gi_camera *camera, const gi_primary_packet *packet,
                           uint32_t first, gi_primary *out)
{
	STILB_ASSERT(first % 16 == 0 && first < GI_BATCH);
	float normals[4][16];
	int32_t rare[16];
	for (uint32_t lane = 0; lane < 16; lane++)
		rare[lane] = !lanes_row(packet, lane, out->albedo[first + lane], out->normal[first + lane]);
	for (uint32_t lane = 0; lane < 16; lane += 4)
		gi_packet_gather(out->normal[first + lane], sizeof *out->normal, &normals[0][lane]);
	bool some = lanes_normals(&packet->rays, normals, rare);
	gi_packet_scatter_all(normals, out->normal[first], sizeof *out->normal);
	lanes_depths(camera, &packet->rays, out->depth + first);
	gi_packet_store_hits(&packet->rays, out->rays + first);
	for (uint32_t lane = 0; some && lane < 16; lane++)
		if (rare[lane])
			lanes_rare(scene, first + lane, out);
}

const gi_primary_kernels KERNELS = {.sobol = lanes_sobol, .rays = lanes_rays, .surfaces = lanes_surfaces};

#endif
