/* Rays against the scene as it lies: bounding spheres, then triangles. */
#include "scene/scene_pick.h"

#include <math.h>

static double pick_dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void pick_cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

stilb_scene_ray stilb_scene_camera_ray(const stilb_scene_camera *camera, uint32_t width, uint32_t height, double x,
                                       double y)
{
	STILB_ASSERT(camera && width > 0 && height > 0);
	/* The rows of the matrix from world to clip space are the camera's axes, scaled. */
	stilb_mat4 clip = stilb_scene_camera_matrix(camera, 1.0f);
	double half_height = tan(0.5 * (double)camera->fov_y), half_width = half_height * width / height;
	double across = (2.0 * x / width - 1.0) * half_width, down = (2.0 * y / height - 1.0) * half_height;
	double row[3][3], length[3] = {0.0, 0.0, 0.0};
	for (int axis = 0; axis < 3; axis++) { /* right, down, forward */
		for (int i = 0; i < 3; i++)
			row[axis][i] = (double)clip.m[i * 4 + (axis == 2 ? 3 : axis)];
		length[axis] = sqrt(pick_dot(row[axis], row[axis]));
	}
	stilb_scene_ray ray = {.near_t = (double)camera->near_z, .far_t = (double)camera->far_z};
	for (int i = 0; i < 3; i++) {
		ray.origin[i] = (double)camera->position[i];
		ray.direction[i] = row[2][i] / length[2] + across * row[0][i] / length[0] + down * row[1][i] / length[1];
	}
	return ray;
}

/* True if the ray's line may meet the model's bounding sphere in front of its origin: false only if the distance is
 * beyond all rounding of the bounds, or if the model is hidden. */
static bool pick_may_meet(const stilb_scene_bounds *bounds, uint32_t model, const stilb_scene_ray *ray)
{
	double to[3] = {(double)bounds->x[model] - ray->origin[0], (double)bounds->y[model] - ray->origin[1],
	                (double)bounds->z[model] - ray->origin[2]};
	double along = pick_dot(to, ray->direction), square = pick_dot(ray->direction, ray->direction);
	double distance = pick_dot(to, to), radius = (double)bounds->radius[model];
	if (isnan(radius))
		return false;
	double far_out =
		fabs(to[0]) + fabs(to[1]) + fabs(to[2]) + fabs(ray->origin[0]) + fabs(ray->origin[1]) + fabs(ray->origin[2]);
	radius = radius * (1.0 + 1e-5) + far_out * 1e-6;
	return !(distance > radius * radius &&
	         (along <= 0.0 || distance * square - along * along > radius * radius * square));
}

/* A point of a mesh in the world, in float as the renderer computes it. */
static void pick_corner(const stilb_mat4 *transform, const stilb_scene_vertex *vertex, double out[3])
{
	const float *m = transform->m, *p = vertex->position;
	for (int row = 0; row < 3; row++)
		out[row] = (double)(m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
}

/* Intersects the ray with the front of a triangle: t, u, v. False: no hit within the segment. Source: Moeller and
 * Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997). */
static bool pick_triangle(double corner[3][3], const stilb_scene_ray *ray, double far_t, double tuv[3])
{
	double e1[3], e2[3], from[3], p[3], q[3];
	for (int i = 0; i < 3; i++) {
		e1[i] = corner[1][i] - corner[0][i];
		e2[i] = corner[2][i] - corner[0][i];
		from[i] = ray->origin[i] - corner[0][i];
	}
	pick_cross(ray->direction, e2, p);
	double determinant = pick_dot(e1, p);
	if (!(determinant > 0.0)) /* seen from behind, from its edge, or NaN */
		return false;
	tuv[1] = pick_dot(from, p) / determinant;
	if (!(tuv[1] >= 0.0 && tuv[1] <= 1.0))
		return false;
	pick_cross(from, e1, q);
	tuv[2] = pick_dot(ray->direction, q) / determinant;
	tuv[0] = pick_dot(e2, q) / determinant;
	return tuv[2] >= 0.0 && tuv[1] + tuv[2] <= 1.0 && tuv[0] > ray->near_t && tuv[0] <= far_t;
}

/* Looks for a triangle of the part that is nearer than far_t; true: *hit and *far_t are its. */
static bool pick_part(const stilb_scene *scene, uint32_t part, const stilb_scene_ray *ray, double *far_t,
                      stilb_scene_hit *hit)
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	double corner[3][3], tuv[3];
	bool found = false;
	for (uint32_t triangle = 0; triangle < mesh->index_count / 3; triangle++) {
		const uint32_t *indices = &mesh->indices[(size_t)3 * triangle];
		for (int i = 0; i < 3; i++)
			pick_corner(&scene->part_transform[part], &mesh->vertices[indices[i]], corner[i]);
		if (!pick_triangle(corner, ray, *far_t, tuv) || (tuv[0] == *far_t && hit->part != UINT32_MAX))
			continue;
		found = true;
		*far_t = tuv[0];
		hit->part = part;
		hit->triangle = triangle;
		hit->u = (float)tuv[1];
		hit->v = (float)tuv[2];
	}
	return found;
}

bool stilb_scene_pick(const stilb_scene *scene, const stilb_scene_ray *ray, stilb_scene_hit *hit)
{
	STILB_ASSERT(scene && ray && hit);
	stilb_scene_hit nearest = {.part = UINT32_MAX};
	double far_t = ray->far_t;
	for (uint32_t model = 0; model < scene->model_count; model++) {
		if (!pick_may_meet(&scene->bounds, model, ray))
			continue;
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++)
			if (pick_part(scene, part, ray, &far_t, &nearest))
				nearest.model = model;
	}
	if (nearest.part == UINT32_MAX)
		return false;
	nearest.distance = far_t * sqrt(pick_dot(ray->direction, ray->direction));
	for (int i = 0; i < 3; i++)
		nearest.position[i] = (float)(ray->origin[i] + far_t * ray->direction[i]);
	*hit = nearest;
	return true;
}
