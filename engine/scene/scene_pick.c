/* Rays against the scene as it lies: bounding spheres, then triangles; of large meshes those in boxes that the ray
 * meets. */
#include "scene/scene_pick.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct pick_mesh pick_mesh;

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

/* Intersects the ray with the front of a triangle, or with both its sides: t, u, v. False: no hit within the segment.
 * Source: Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997). */
static bool pick_triangle(double corner[3][3], const stilb_scene_ray *ray, bool both_sides, double far_t, double tuv[3])
{
	double e1[3], e2[3], from[3], p[3], q[3];
	for (int i = 0; i < 3; i++) {
		e1[i] = corner[1][i] - corner[0][i];
		e2[i] = corner[2][i] - corner[0][i];
		from[i] = ray->origin[i] - corner[0][i];
	}
	pick_cross(ray->direction, e2, p);
	double determinant = pick_dot(e1, p);
	if (!(determinant > 0.0 || (both_sides && determinant < 0.0))) /* seen from behind, from its edge, or NaN */
		return false;
	tuv[1] = pick_dot(from, p) / determinant;
	if (!(tuv[1] >= 0.0 && tuv[1] <= 1.0))
		return false;
	pick_cross(from, e1, q);
	tuv[2] = pick_dot(ray->direction, q) / determinant;
	tuv[0] = pick_dot(e2, q) / determinant;
	return tuv[2] >= 0.0 && tuv[1] + tuv[2] <= 1.0 && tuv[0] > ray->near_t && tuv[0] <= far_t;
}

/* The search for the nearest triangle on a ray. */
typedef struct pick_search {
	const stilb_scene *scene;
	const stilb_scene_ray *ray;
	double far_t;            /* of the nearest so far, or of the ray's end */
	stilb_scene_hit nearest; /* part UINT32_MAX: none so far */
	uint32_t model, part;    /* being searched */
	pick_mesh *boxes;        /* of the part's mesh; NULL: it has none */
	double inverse[3];       /* of the ray's direction */
} pick_search;

/* Looks for a nearer one among the triangles first .. end - 1 of the part. */
static void pick_triangles(pick_search *search, uint32_t first, uint32_t end)
{
	const stilb_scene *scene = search->scene;
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[search->part]];
	stilb_scene_hit *hit = &search->nearest;
	double corner[3][3], tuv[3];
	for (uint32_t triangle = first; triangle < end; triangle++) {
		const uint32_t *indices = &mesh->indices[(size_t)3 * triangle];
		for (int i = 0; i < 3; i++)
			pick_corner(&scene->part_transform[search->part], &mesh->vertices[indices[i]], corner[i]);
		if (!pick_triangle(corner, search->ray, scene->both_sides, search->far_t, tuv) ||
		    (tuv[0] == search->far_t && hit->part != UINT32_MAX))
			continue;
		search->far_t = tuv[0];
		*hit = (stilb_scene_hit){
			.model = search->model, .part = search->part, .triangle = triangle, .u = (float)tuv[1], .v = (float)tuv[2]};
	}
}

/* ---- boxes of large meshes --------------------------------------------------------------------------------------- */

/* Boxes around PICK_GROUP triangles that follow one another in the mesh, boxes around PICK_GROUP of these, and so on.
 * Files list neighbours one after another, so the boxes are small; nothing is sorted, which is why they are made as
 * fast as triangles are searched. */
#define PICK_GROUP 32u
#define PICK_LEVELS 7         /* 32^7 > 2^32 */
#define PICK_BOXES_FROM 4096u /* triangles of a mesh; smaller ones take less than 50 us anyway */

typedef struct pick_box {
	float low[3], high[3];
} pick_box;

struct pick_mesh {
	pick_box *boxes; /* all levels, the finest first; NULL: not made */
	uint32_t levels;
	uint32_t first[PICK_LEVELS], count[PICK_LEVELS]; /* of each level */
};

struct stilb_scene_pick_index {
	uint32_t count;
	pick_mesh *meshes; /* [count] by the scene's ids */
};

/* The point is in the box afterwards, unless it is NaN. */
static void pick_box_take(pick_box *box, const float point[3])
{
	for (int i = 0; i < 3; i++) {
		box->low[i] = point[i] < box->low[i] ? point[i] : box->low[i];
		box->high[i] = point[i] > box->high[i] ? point[i] : box->high[i];
	}
}

static const pick_box pick_box_none = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void pick_fill_finest(const stilb_scene_mesh *mesh, pick_mesh *made)
{
	uint32_t triangles = mesh->index_count / 3;
	for (uint32_t b = 0; b < made->count[0]; b++) {
		uint32_t end = b + 1 < made->count[0] ? (b + 1) * PICK_GROUP : triangles;
		made->boxes[b] = pick_box_none;
		for (size_t i = (size_t)3 * b * PICK_GROUP; i < (size_t)3 * end; i++)
			pick_box_take(&made->boxes[b], mesh->vertices[mesh->indices[i]].position);
	}
}

static void pick_fill_level(pick_mesh *made, uint32_t level)
{
	const pick_box *finer = &made->boxes[made->first[level - 1]];
	pick_box *boxes = &made->boxes[made->first[level]];
	for (uint32_t b = 0; b < made->count[level]; b++) {
		boxes[b] = pick_box_none;
		for (uint32_t i = b * PICK_GROUP; i < (b + 1) * PICK_GROUP && i < made->count[level - 1]; i++) {
			pick_box_take(&boxes[b], finer[i].low);
			pick_box_take(&boxes[b], finer[i].high);
		}
	}
}

/* Makes the boxes; without memory there are none. */
static void pick_make(const stilb_scene_mesh *mesh, pick_mesh *made)
{
	uint32_t count = mesh->index_count / 3, total = 0;
	*made = (pick_mesh){0};
	do {
		count = (count - 1) / PICK_GROUP + 1;
		made->first[made->levels] = total;
		made->count[made->levels++] = count;
		total += count;
	} while (count > PICK_GROUP);
	made->boxes = stilb_memory_alloc(total, sizeof *made->boxes);
	if (!made->boxes)
		return;
	pick_fill_finest(mesh, made);
	for (uint32_t level = 1; level < made->levels; level++)
		pick_fill_level(made, level);
}

/* The boxes of a mesh, which are made if need be. NULL: it has none. */
static pick_mesh *pick_boxes(stilb_scene_pick_index *index, const stilb_scene *scene, uint32_t mesh)
{
	if (!index || scene->meshes[mesh].index_count / 3 < PICK_BOXES_FROM)
		return NULL;
	if (mesh >= index->count) {
		pick_mesh *more = realloc(index->meshes, scene->mesh_count * sizeof *more);
		if (!more)
			return NULL;
		memset(&more[index->count], 0, (scene->mesh_count - index->count) * sizeof *more);
		index->meshes = more;
		index->count = scene->mesh_count;
	}
	if (!index->meshes[mesh].boxes)
		pick_make(&scene->meshes[mesh], &index->meshes[mesh]);
	return index->meshes[mesh].boxes ? &index->meshes[mesh] : NULL;
}

/* False only if no corner of a triangle in the box, as pick_corner computes it, can lie where the ray passes before
 * far_t: the box in the world, wider by more than all rounding. */
static bool pick_box_may_be_met(const pick_search *search, const pick_box *box)
{
	const float *m = search->scene->part_transform[search->part].m;
	double near_t = search->ray->near_t, far_t = search->far_t;
	for (int row = 0; row < 3; row++) {
		double middle = (double)m[12 + row], half = 0.0, most = fabs(middle);
		for (int i = 0; i < 3; i++) {
			double factor = (double)m[4 * i + row], low = (double)box->low[i], high = (double)box->high[i];
			middle += factor * 0.5 * (low + high);
			half += fabs(factor) * 0.5 * (high - low);
			most += fabs(factor) * fmax(fabs(low), fabs(high));
		}
		double from = middle - search->ray->origin[row];
		half += most * 1e-6 + fabs(search->ray->origin[row]) * 1e-12;
		if (search->ray->direction[row] == 0.0) {
			if (fabs(from) > half)
				return false;
			continue;
		}
		double t = from * search->inverse[row], side = fabs(half * search->inverse[row]), slack = fabs(t) * 1e-12;
		if (t - side - slack > far_t || t + side + slack < near_t)
			return false;
		near_t = fmax(near_t, t - side - slack);
		far_t = fmin(far_t, t + side + slack);
	}
	return !(near_t > far_t);
}

/* Searches what lies in the boxes first .. end - 1 of a level, in the order of the triangles. */
static void pick_level(pick_search *search, uint32_t level, uint32_t first, uint32_t end)
{
	const pick_mesh *mesh = search->boxes;
	uint32_t finer = level > 0 ? mesh->count[level - 1]
	                           : search->scene->meshes[search->scene->part_mesh[search->part]].index_count / 3;
	for (uint32_t b = first; b < end; b++) {
		if (!pick_box_may_be_met(search, &mesh->boxes[mesh->first[level] + b]))
			continue;
		uint32_t last = b + 1 < mesh->count[level] ? (b + 1) * PICK_GROUP : finer;
		if (level > 0)
			pick_level(search, level - 1, b * PICK_GROUP, last);
		else
			pick_triangles(search, b * PICK_GROUP, last);
	}
}

stilb_scene_pick_index *stilb_scene_pick_index_create(void)
{
	return calloc(1, sizeof(stilb_scene_pick_index));
}

void stilb_scene_pick_index_forget(stilb_scene_pick_index *index, uint32_t mesh)
{
	if (!index || mesh >= index->count)
		return;
	free(index->meshes[mesh].boxes);
	index->meshes[mesh].boxes = NULL;
}

void stilb_scene_pick_index_clear(stilb_scene_pick_index *index)
{
	for (uint32_t mesh = 0; index && mesh < index->count; mesh++)
		stilb_scene_pick_index_forget(index, mesh);
}

void stilb_scene_pick_index_destroy(stilb_scene_pick_index *index)
{
	if (!index)
		return;
	stilb_scene_pick_index_clear(index);
	free(index->meshes);
	free(index);
}

/* ---- all models -------------------------------------------------------------------------------------------------- */

bool stilb_scene_pick_indexed(const stilb_scene *scene, const stilb_scene_ray *ray, stilb_scene_pick_index *index,
                              stilb_scene_hit *hit)
{
	STILB_ASSERT(scene && ray && hit);
	pick_search search = {.scene = scene, .ray = ray, .far_t = ray->far_t, .nearest = {.part = UINT32_MAX}};
	for (int i = 0; i < 3; i++)
		search.inverse[i] = 1.0 / ray->direction[i];
	for (uint32_t model = 0; model < scene->model_count; model++) {
		if (scene->model_flags[model] & STILB_SCENE_MODEL_UNSEEN || !pick_may_meet(&scene->bounds, model, ray))
			continue;
		search.model = model;
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++) {
			search.part = part;
			search.boxes = pick_boxes(index, scene, scene->part_mesh[part]);
			if (search.boxes)
				pick_level(&search, search.boxes->levels - 1, 0, search.boxes->count[search.boxes->levels - 1]);
			else
				pick_triangles(&search, 0, scene->meshes[scene->part_mesh[part]].index_count / 3);
		}
	}
	if (search.nearest.part == UINT32_MAX)
		return false;
	*hit = search.nearest;
	hit->distance = search.far_t * sqrt(pick_dot(ray->direction, ray->direction));
	for (int i = 0; i < 3; i++)
		hit->position[i] = (float)(ray->origin[i] + search.far_t * ray->direction[i]);
	return true;
}

bool stilb_scene_pick(const stilb_scene *scene, const stilb_scene_ray *ray, stilb_scene_hit *hit)
{
	return stilb_scene_pick_indexed(scene, ray, NULL, hit);
}
