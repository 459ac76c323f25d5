/* gi_brute: every ray against every triangle, in double: the reference that Embree is tested against, and the
 * intersector in tests of concurrency, since the thread sanitizer cannot see into Embree. */
#include "gi/gi_scene_internal.h"
#include "gi/trace/gi_cover.h"

#include <stdlib.h>

typedef struct brute_triangle {
	double v0[3], e1[3], e2[3];
	double side; /* -1 where cross(e1, e2) points to the back: of mirrored instances */
	uint32_t part, triangle;
	uint32_t mask; /* of the part */
} brute_triangle;

typedef struct brute {
	const stilb_gi_scene *gi;
	uint64_t count;
	brute_triangle triangles[];
} brute;

static void brute_cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

static double brute_dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Intersects a ray with a triangle: t, u, v; false: no hit. Source: Moeller and Trumbore, "Fast, Minimum Storage
 * Ray/Triangle Intersection" (1997). */
static bool brute_meet(const brute_triangle *triangle, const gi_ray *ray, double tuv[3])
{
	double direction[3], from[3];
	if (!(triangle->mask & ray->mask))
		return false;
	for (int i = 0; i < 3; i++) {
		direction[i] = (double)ray->direction[i];
		from[i] = (double)ray->origin[i] - triangle->v0[i];
	}
	double p[3], q[3];
	brute_cross(direction, triangle->e2, p);
	double determinant = brute_dot(triangle->e1, p);
	if (determinant == 0.0)
		return false;
	tuv[1] = brute_dot(from, p) / determinant;
	brute_cross(from, triangle->e1, q);
	tuv[2] = brute_dot(direction, q) / determinant;
	tuv[0] = brute_dot(triangle->e2, q) / determinant;
	return tuv[1] >= 0.0 && tuv[2] >= 0.0 && tuv[1] + tuv[2] <= 1.0 && tuv[0] > (double)ray->t_min &&
	       tuv[0] <= (double)ray->t_max;
}

/* True if the ray, which crosses the triangle at tuv, ends there. */
static bool brute_ends(const brute *state, const brute_triangle *triangle, const gi_ray *ray, const double tuv[3])
{
	if (!state->gi->parts[triangle->part].sieve)
		return true;
	double normal[3], direction[3] = {(double)ray->direction[0], (double)ray->direction[1], (double)ray->direction[2]};
	brute_cross(triangle->e1, triangle->e2, normal);
	gi_crossing crossing = {.part = triangle->part,
	                        .triangle = triangle->triangle,
	                        .u = (float)tuv[1],
	                        .v = (float)tuv[2],
	                        .chance = ray->time,
	                        .front = triangle->side * brute_dot(normal, direction) <= 0.0};
	return gi_cover_meets(state->gi, &crossing);
}

static void brute_intersect(const gi_tracer *tracer, gi_ray_hit *ray)
{
	STILB_ASSERT(!gi_is_hit(ray) && "nothing hit before");
	const brute *state = tracer->state;
	for (uint64_t i = 0; i < state->count; i++) {
		const brute_triangle *triangle = &state->triangles[i];
		double tuv[3], normal[3];
		if (!brute_meet(triangle, &ray->ray, tuv) || !brute_ends(state, triangle, &ray->ray, tuv))
			continue;
		brute_cross(triangle->e1, triangle->e2, normal);
		ray->ray.t_max = (float)tuv[0];
		ray->hit.u = (float)tuv[1];
		ray->hit.v = (float)tuv[2];
		for (int k = 0; k < 3; k++)
			ray->hit.normal[k] = (float)(triangle->side * normal[k]);
		ray->hit.part = triangle->part;
		ray->hit.triangle = triangle->triangle;
	}
}

static void brute_intersect16(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *rays)
{
	STILB_ASSERT((uintptr_t)valid % 64 == 0 && (uintptr_t)rays % 64 == 0);
	for (uint32_t i = 0; i < 16; i++) {
		STILB_ASSERT(valid[i] == 0 || valid[i] == -1);
		if (!valid[i])
			continue;
		gi_ray_hit ray = gi_ray_of(rays, i);
		brute_intersect(tracer, &ray);
		rays->ray.t_max[i] = ray.ray.t_max;
		rays->hit.u[i] = ray.hit.u;
		rays->hit.v[i] = ray.hit.v;
		for (int k = 0; k < 3; k++)
			rays->hit.normal[k][i] = ray.hit.normal[k];
		rays->hit.part[i] = ray.hit.part;
		rays->hit.triangle[i] = ray.hit.triangle;
	}
}

static bool brute_meets_any(const brute *state, const gi_ray *ray)
{
	double tuv[3];
	for (uint64_t i = 0; i < state->count; i++)
		if (brute_meet(&state->triangles[i], ray, tuv) && brute_ends(state, &state->triangles[i], ray, tuv))
			return true;
	return false;
}

static void brute_occluded(const gi_tracer *tracer, gi_ray *rays, uint32_t count)
{
	STILB_ASSERT(rays || count == 0);
	for (uint32_t i = 0; i < count; i++)
		if (brute_meets_any(tracer->state, &rays[i]))
			rays[i].t_max = -INFINITY;
}

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

/* A corner in world space; an instance's is transformed in double. */
static void brute_corner(const gi_part *part, const float p[3], double out[3])
{
	for (int i = 0; i < 3; i++) {
		out[i] = (double)p[i];
		if (part->instance)
			out[i] = (double)part->to_world.m[i] * (double)p[0] + (double)part->to_world.m[4 + i] * (double)p[1] +
			         (double)part->to_world.m[8 + i] * (double)p[2] + (double)part->to_world.m[12 + i];
	}
}

static void brute_part(const stilb_gi_scene *gi, uint32_t index, brute *state)
{
	STILB_ASSERT(index < gi->part_count);
	const gi_part *part = &gi->parts[index];
	const gi_mesh *mesh = &gi->meshes[part->mesh];
	for (uint32_t k = 0; k < mesh->triangle_count && !part->hidden; k++) {
		brute_triangle *triangle = &state->triangles[state->count++];
		double v1[3], v2[3];
		brute_corner(part, mesh->vertices[mesh->triangles[k].vertex[0]].position, triangle->v0);
		brute_corner(part, mesh->vertices[mesh->triangles[k].vertex[1]].position, v1);
		brute_corner(part, mesh->vertices[mesh->triangles[k].vertex[2]].position, v2);
		for (int i = 0; i < 3; i++) {
			triangle->e1[i] = v1[i] - triangle->v0[i];
			triangle->e2[i] = v2[i] - triangle->v0[i];
		}
		triangle->side = part->mirrored ? -1.0 : 1.0;
		triangle->part = index;
		triangle->triangle = k;
		triangle->mask = part->mask;
	}
}

static stilb_result brute_create(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                                 stilb_gi_scene_info *info)
{
	STILB_ASSERT(!tracer->state && "a tracer is created once");
	(void)desc;
	brute *state = stilb_memory_alloc(1, sizeof *state + info->triangles * sizeof *state->triangles);
	if (!state)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %llu triangles", (unsigned long long)info->triangles);
	state->gi = gi;
	state->count = 0;
	for (uint32_t part = 0; part < gi->part_count; part++)
		brute_part(gi, part, state);
	STILB_ASSERT(state->count == info->triangles);
	*tracer = (gi_tracer){
		.intersect = brute_intersect, .intersect16 = brute_intersect16, .occluded = brute_occluded, .state = state};
	info->isa = "none";
	return STILB_OK;
}

static void brute_destroy(gi_tracer *tracer)
{
	free(tracer->state);
	*tracer = (gi_tracer){0};
}

/* stilb_gi_intersector.update: it has no tree, so all is made anew. */
static stilb_result brute_update(const stilb_gi_scene *gi, const uint32_t *moved, uint32_t moved_count,
                                 const stilb_gi_scene_desc *desc, gi_tracer *tracer, stilb_gi_scene_info *info)
{
	(void)moved;
	(void)moved_count;
	brute_destroy(tracer);
	return brute_create(gi, desc, tracer, info);
}

const stilb_gi_intersector stilb_gi_brute = {
	.name = "brute", .create = brute_create, .update = brute_update, .destroy = brute_destroy};
