/* Bakes impostors: checks and gathers the parts, finds the sphere, and draws the pictures on jobs. */
#include "geometry/geometry_impostor_internal.h"

#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define IMPOSTOR_FAR 1e18f /* metres: squares of longer distances overflow */

stilb_geometry_impostor_desc stilb_geometry_impostor_desc_default(void)
{
	return (stilb_geometry_impostor_desc){.grid = 13, .side = 64, .samples = 4};
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

static stilb_result impostor_check_desc(const stilb_geometry_impostor_desc *desc)
{
	if (desc->grid < STILB_SCENE_IMPOSTOR_MIN_GRID || desc->grid % 2 == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an impostor's grid of %u directions a side is not an odd number of 3 "
		                  "or more",
		                  desc->grid);
	if (desc->side < STILB_SCENE_IMPOSTOR_MIN_SIDE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "pictures of an impostor have 4 texels a side at least, not %u",
		                  desc->side);
	if (desc->grid > STILB_SCENE_IMPOSTOR_MAX_TEXELS || desc->side > STILB_SCENE_IMPOSTOR_MAX_TEXELS / desc->grid)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an impostor of %u x %u pictures of %u texels a side is wider than %u "
		                  "texels; take fewer directions or smaller pictures",
		                  desc->grid, desc->grid, desc->side, STILB_SCENE_IMPOSTOR_MAX_TEXELS);
	if (desc->samples < 1 || desc->samples > STILB_GEOMETRY_IMPOSTOR_MAX_SAMPLES ||
	    desc->side * desc->samples > STILB_GEOMETRY_IMPOSTOR_MAX_POINTS)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "%u x %u points a texel are not in 1 to %u, or more than %u a side of "
		                  "a picture",
		                  desc->samples, desc->samples, STILB_GEOMETRY_IMPOSTOR_MAX_SAMPLES,
		                  STILB_GEOMETRY_IMPOSTOR_MAX_POINTS);
	return STILB_OK;
}

static bool impostor_is_finite(const float *values, int count, float most)
{
	for (int i = 0; i < count; i++)
		if (!(fabsf(values[i]) <= most))
			return false;
	return true;
}

static stilb_result impostor_check_mesh(const stilb_scene_mesh *mesh, uint32_t part)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const stilb_scene_vertex *vertex = &mesh->vertices[v];
		const char *what = !impostor_is_finite(vertex->position, 3, IMPOSTOR_FAR) ? "position"
		                   : !impostor_is_finite(vertex->normal, 3, IMPOSTOR_FAR) ? "normal"
		                   : !impostor_is_finite(vertex->uv, 2, IMPOSTOR_FAR)     ? "texture coordinate"
		                                                                          : NULL;
		if (what)
			return stilb_fail(STILB_ERROR_ARGUMENT, "the %s of vertex %u of part %u of an impostor is not finite", what,
			                  v, part);
	}
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "index %u of part %u of an impostor is vertex %u, but it has %u", i,
			                  part, mesh->indices[i], mesh->vertex_count);
	return STILB_OK;
}

static stilb_result impostor_check_part(const stilb_geometry_impostor_part *part, uint32_t index)
{
	const stilb_scene_material *material = part->material;
	if (part->transform && !impostor_is_finite(part->transform->m, 16, IMPOSTOR_FAR))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the transform of part %u of an impostor is not finite", index);
	if (!impostor_is_finite(material->diffuse, 3, 1.0f) || !impostor_is_finite(material->specular, 3, 1.0f) ||
	    !(material->roughness >= 0.0f && material->roughness <= 1.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the material of part %u of an impostor is out of range", index);
	for (int c = 0; c < 3; c++)
		if (material->emission[c] != 0.0f)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "the material of part %u emits light, which impostors cannot show; "
			                  "keep its meshes at every distance",
			                  index);
	if (part->texture && (!part->texture->pixels || part->texture->width == 0 || part->texture->height == 0))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the texture of part %u of an impostor has no pixels", index);
	return impostor_check_mesh(part->mesh, index);
}

/* ---- gathering --------------------------------------------------------------------------------------------------- */

/* Everything that a bake allocates. */
typedef struct impostor_work {
	impostor_model model;
	impostor_texture *textures; /* [part_count] the first texture_count are used */
	uint32_t texture_count;
	impostor_canvas *canvases; /* [canvas_count] one for each thread of the pool */
	uint32_t canvas_count;
	const stilb_geometry_impostor_desc *desc;
	stilb_image *maps;
} impostor_work;

static void impostor_work_finish(impostor_work *work)
{
	free(work->model.vertices);
	free(work->model.triangles);
	free(work->model.textures);
	for (uint32_t t = 0; t < work->texture_count; t++)
		geometry_impostor_texture_finish(&work->textures[t]);
	free(work->textures);
	for (uint32_t c = 0; work->canvases && c < work->canvas_count; c++) {
		free(work->canvases[c].places);
		free(work->canvases[c].heights);
		free(work->canvases[c].triangles);
		free(work->canvases[c].texels);
		free(work->canvases[c].spread);
	}
	free(work->canvases);
}

static stilb_vec3 impostor_transformed(const stilb_mat4 *transform, const float p[3], float w)
{
	if (!transform)
		return stilb_vec3_make(p[0], p[1], p[2]);
	const float *m = transform->m;
	return stilb_vec3_make(m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12] * w,
	                       m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13] * w,
	                       m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14] * w);
}

/* Normals go by the cofactor matrix, which is right also for scales that differ by axis; of a mirrored space its sign
 * is that of the triangles' sides, as shaders/mesh.vert has it. Unit, or 0 if it has no length. */
static stilb_vec3 impostor_turned(const stilb_mat4 *transform, const float n[3])
{
	stilb_vec3 normal = stilb_vec3_make(n[0], n[1], n[2]);
	if (transform) {
		const float *m = transform->m;
		stilb_vec3 x = stilb_vec3_make(m[0], m[1], m[2]), y = stilb_vec3_make(m[4], m[5], m[6]);
		stilb_vec3 z = stilb_vec3_make(m[8], m[9], m[10]);
		normal = stilb_vec3_cross(y, z) * n[0] + stilb_vec3_cross(z, x) * n[1] + stilb_vec3_cross(x, y) * n[2];
	}
	float length2 = stilb_vec3_dot(normal, normal);
	return length2 > 0.0f && length2 < INFINITY ? normal * (1.0f / sqrtf(length2)) : stilb_vec3_make(0, 0, 0);
}

static void impostor_gather(impostor_model *model)
{
	uint32_t first = 0, triangle = 0;
	for (uint32_t p = 0; p < model->part_count; p++) {
		const stilb_scene_mesh *mesh = model->parts[p].mesh;
		const stilb_mat4 *transform = model->parts[p].transform;
		for (uint32_t v = 0; v < mesh->vertex_count; v++) {
			const stilb_scene_vertex *from = &mesh->vertices[v];
			stilb_vec3 at = impostor_transformed(transform, from->position, 1.0f);
			stilb_vec3 normal = impostor_turned(transform, from->normal);
			model->vertices[first + v] =
				(impostor_vertex){{at[0], at[1], at[2]}, {normal[0], normal[1], normal[2]}, {from->uv[0], from->uv[1]}};
		}
		for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
			const uint32_t *corner = &mesh->indices[3 * (size_t)t];
			model->triangles[triangle++] =
				(impostor_triangle){{first + corner[0], first + corner[1], first + corner[2]}, p};
		}
		first += mesh->vertex_count;
	}
}

/* Parts that have the same image share a texture. */
static stilb_result impostor_take_texture(impostor_work *work, uint32_t part)
{
	const stilb_image *image = work->model.parts[part].texture;
	work->model.textures[part] = NULL;
	if (!image)
		return STILB_OK;
	uint32_t found = 0;
	while (found < work->texture_count && work->textures[found].image->pixels != image->pixels)
		found++;
	if (found == work->texture_count) {
		stilb_result result = geometry_impostor_texture_make(image, &work->textures[found]);
		if (result != STILB_OK)
			return result;
		work->texture_count++;
	}
	work->model.textures[part] = &work->textures[found];
	return STILB_OK;
}

static stilb_result impostor_take_parts(impostor_work *work)
{
	impostor_model *model = &work->model;
	uint64_t vertices = 0, triangles = 0;
	for (uint32_t p = 0; p < model->part_count; p++) {
		stilb_result result = impostor_check_part(&model->parts[p], p);
		if (result != STILB_OK)
			return result;
		vertices += model->parts[p].mesh->vertex_count;
		triangles += model->parts[p].mesh->index_count / 3;
	}
	if (triangles == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "an impostor of no triangles shows nothing");
	if (vertices > UINT32_MAX || triangles >= UINT32_MAX)
		return stilb_fail(STILB_ERROR_ARGUMENT, "the parts of an impostor have more than 2^32 vertices or triangles");
	model->vertex_count = (uint32_t)vertices;
	model->triangle_count = (uint32_t)triangles;
	model->vertices = stilb_memory_alloc(vertices, sizeof *model->vertices);
	model->triangles = stilb_memory_alloc(triangles, sizeof *model->triangles);
	model->textures = stilb_memory_alloc(model->part_count, sizeof *model->textures);
	work->textures = stilb_memory_alloc(model->part_count, sizeof *work->textures);
	if (!model->vertices || !model->triangles || !model->textures || !work->textures)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to bake an impostor of %u vertices", model->vertex_count);
	stilb_result result = STILB_OK;
	for (uint32_t p = 0; p < model->part_count && result == STILB_OK; p++)
		result = impostor_take_texture(work, p);
	impostor_gather(model);
	return result;
}

/* ---- the sphere and the material --------------------------------------------------------------------------------- */

/* Squared distance of the triangles' corner that is the farthest from a point. */
static float impostor_farthest(const impostor_model *model, const float from[3])
{
	float most = 0.0f;
	for (uint32_t t = 0; t < model->triangle_count; t++)
		for (int c = 0; c < 3; c++) {
			const float *p = model->vertices[model->triangles[t].vertices[c]].position;
			float x = p[0] - from[0], y = p[1] - from[1], z = p[2] - from[2], distance = x * x + y * y + z * z;
			most = distance <= most ? most : distance;
		}
	return most;
}

/* The box about all corners of triangles, and the sphere about its middle. */
static stilb_result impostor_find_sphere(const impostor_model *model, stilb_scene_impostor *impostor)
{
	float *center = impostor->center;
	for (int axis = 0; axis < 3; axis++) {
		float low = INFINITY, high = -INFINITY;
		for (uint32_t t = 0; t < model->triangle_count; t++)
			for (int c = 0; c < 3; c++) {
				float p = model->vertices[model->triangles[t].vertices[c]].position[axis];
				low = p < low ? p : low;
				high = p > high ? p : high;
			}
		center[axis] = 0.5f * low + 0.5f * high;
		impostor->half[axis] = fmaxf(high - center[axis], center[axis] - low);
	}
	impostor->radius = sqrtf(impostor_farthest(model, center)) * 1.0001f; /* rounding */
	float size = fabsf(center[0]) + fabsf(center[1]) + fabsf(center[2]);
	if (impostor->radius > size * 1e-6f && impostor->radius > 1e-18f && impostor->radius <= IMPOSTOR_FAR)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "an impostor needs a model with an extent: the radius of this one is %g m "
	                  "about (%g, %g, %g)",
	                  (double)impostor->radius, (double)center[0], (double)center[1], (double)center[2]);
}

static void impostor_center(impostor_model *model, const stilb_scene_impostor *impostor)
{
	for (uint32_t v = 0; v < model->vertex_count; v++)
		for (int axis = 0; axis < 3; axis++) {
			float *p = &model->vertices[v].position[axis];
			*p = (*p - impostor->center[axis]) / impostor->radius;
			*p = *p < -1.0f ? -1.0f : *p > 1.0f ? 1.0f : *p; /* vertices without a triangle */
		}
}

static double impostor_area(const impostor_model *model, const impostor_triangle *triangle)
{
	const float *a = model->vertices[triangle->vertices[0]].position;
	const float *b = model->vertices[triangle->vertices[1]].position;
	const float *c = model->vertices[triangle->vertices[2]].position;
	double u[3], v[3];
	for (int i = 0; i < 3; i++) {
		u[i] = (double)b[i] - (double)a[i];
		v[i] = (double)c[i] - (double)a[i];
	}
	double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
	return sqrt(x * x + y * y + z * z);
}

/* Means over the area of the triangles, which lie in radii. */
static void impostor_find_material(impostor_model *model, stilb_scene_material *mean)
{
	double sum[9] = {0}, all = 0.0;
	for (uint32_t t = 0; t < model->triangle_count; t++) {
		const stilb_scene_material *m = model->parts[model->triangles[t].part].material;
		double area = impostor_area(model, &model->triangles[t]);
		all += area;
		for (int c = 0; c < 3; c++) {
			sum[c] += area * (double)m->diffuse[c];
			sum[3 + c] += area * (double)m->specular[c];
		}
		sum[6] += area * (double)m->roughness;
		sum[7] += area * (double)m->anisotropy;
		sum[8] += area * (double)m->wrap;
	}
	double share = all > 0.0 ? 1.0 / all : 0.0;
	*mean = (stilb_scene_material){
		.roughness = (float)(sum[6] * share), .anisotropy = (float)(sum[7] * share), .wrap = (float)(sum[8] * share)};
	for (int c = 0; c < 3; c++) {
		mean->specular[c] = (float)(sum[3 + c] * share);
		model->most[c] = 1.0f - mean->specular[c];
		mean->diffuse[c] = fminf((float)(sum[c] * share), model->most[c]);
	}
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

static stilb_result impostor_make_canvases(impostor_work *work, uint32_t count)
{
	size_t points = (size_t)work->desc->side * work->desc->samples,
		   texels = (size_t)work->desc->side * work->desc->side;
	work->canvases = calloc(count, sizeof *work->canvases);
	work->canvas_count = count;
	bool made = work->canvases;
	for (uint32_t c = 0; c < count && made; c++) {
		impostor_canvas *canvas = &work->canvases[c];
		canvas->places = stilb_memory_alloc(work->model.vertex_count, sizeof *canvas->places);
		canvas->heights = stilb_memory_alloc(points * points, sizeof *canvas->heights);
		canvas->triangles = stilb_memory_alloc(points * points, sizeof *canvas->triangles);
		canvas->texels = stilb_memory_alloc(texels, sizeof *canvas->texels);
		canvas->spread = stilb_memory_alloc(texels, sizeof *canvas->spread);
		made = canvas->places && canvas->heights && canvas->triangles && canvas->texels && canvas->spread;
	}
	return made ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory for the pictures of an impostor of %u texels a side",
	                         work->desc->side);
}

static void impostor_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const impostor_work *work = context;
	uint32_t grid = work->desc->grid;
	for (uint32_t i = begin; i < end; i++) {
		PROFILE("impostor picture");
		geometry_impostor_draw(&work->model, work->desc, i % grid, i / grid, &work->canvases[worker], work->maps);
	}
}

static stilb_result impostor_bake(impostor_work *work, stilb_job_pool *pool, uint32_t worker,
                                  stilb_scene_impostor *impostor)
{
	uint32_t texels = work->desc->grid * work->desc->side;
	stilb_result result = impostor_take_parts(work);
	if (result == STILB_OK)
		result = impostor_find_sphere(&work->model, impostor);
	if (result == STILB_OK)
		result = impostor_make_canvases(work, stilb_job_pool_worker_count(pool) + 1);
	if (result == STILB_OK)
		result = stilb_image_create(&impostor->maps, texels, 2 * texels, 4, STILB_IMAGE_F16_LINEAR);
	if (result != STILB_OK)
		return result;
	impostor_center(&work->model, impostor);
	impostor_find_material(&work->model, &impostor->material);
	impostor->grid = work->desc->grid;
	impostor->side = work->desc->side;
	work->maps = &impostor->maps;
	stilb_job_parallel_for(pool, work->desc->grid * work->desc->grid, 1, impostor_slice, work, worker);
	STILB_ASSERT(!stilb_scene_impostor_mistake(impostor));
	return STILB_OK;
}

stilb_result stilb_geometry_impostor_bake(const stilb_geometry_impostor_part *parts, uint32_t part_count,
                                          const stilb_geometry_impostor_desc *desc, stilb_job_pool *pool,
                                          uint32_t worker, stilb_scene_impostor *impostor)
{
	PROFILE("bake an impostor");
	STILB_ASSERT(parts && part_count > 0 && desc && pool && impostor);
	STILB_ASSERT(worker <= stilb_job_pool_worker_count(pool) && "a thread of the pool");
	*impostor = (stilb_scene_impostor){0};
	impostor_work work = {.model = {.parts = parts, .part_count = part_count}, .desc = desc};
	stilb_result result = impostor_check_desc(desc);
	if (result == STILB_OK)
		result = impostor_bake(&work, pool, worker, impostor);
	impostor_work_finish(&work);
	if (result != STILB_OK)
		stilb_scene_impostor_finish(impostor);
	return result;
}

/* ---- a scene's model --------------------------------------------------------------------------------------------- */

/* The inverse of an affine matrix; false: it has none. */
bool geometry_impostor_invert(const stilb_mat4 *matrix, stilb_mat4 *out)
{
	const float *m = matrix->m;
	double a[3][3], c[3][3];
	for (int row = 0; row < 3; row++)
		for (int column = 0; column < 3; column++)
			a[row][column] = (double)m[4 * column + row];
	for (int row = 0; row < 3; row++)
		for (int column = 0; column < 3; column++) {
			int r = (column + 1) % 3, s = (column + 2) % 3, u = (row + 1) % 3, v = (row + 2) % 3;
			c[row][column] = a[r][u] * a[s][v] - a[r][v] * a[s][u];
		}
	double determinant = a[0][0] * c[0][0] + a[0][1] * c[1][0] + a[0][2] * c[2][0];
	if (!(fabs(determinant) > 1e-300) || !isfinite(determinant))
		return false;
	*out = stilb_mat4_identity();
	for (int row = 0; row < 3; row++) {
		double moved = 0.0;
		for (int column = 0; column < 3; column++) {
			out->m[4 * column + row] = (float)(c[row][column] / determinant);
			moved -= c[row][column] / determinant * (double)m[12 + column];
		}
		out->m[12 + row] = (float)moved;
	}
	return true;
}

/* Fills parts[count] and transforms[count] with those of a model. */
static stilb_result impostor_list_parts(const stilb_scene *scene, uint32_t first, uint32_t count,
                                        stilb_geometry_impostor_part *parts, stilb_mat4 *transforms)
{
	stilb_mat4 to_first;
	if (!geometry_impostor_invert(&scene->part_transform[first], &to_first))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the transform of part %u has no inverse: its model gets no impostor",
		                  first);
	for (uint32_t p = 0; p < count; p++) {
		uint32_t mesh = scene->part_mesh[first + p], material = scene->part_material[first + p];
		if (mesh == STILB_SCENE_NONE || material == STILB_SCENE_NONE)
			return stilb_fail(STILB_ERROR_ARGUMENT, "part %u was removed, or its mesh: its model gets no impostor",
			                  first + p);
		uint32_t texture = scene->materials[material].diffuse_texture;
		transforms[p] =
			p == 0 ? stilb_mat4_identity() : stilb_mat4_multiply(to_first, scene->part_transform[first + p]);
		parts[p] = (stilb_geometry_impostor_part){
			.mesh = &scene->meshes[mesh],
			.material = &scene->materials[material],
			.texture = texture && scene->textures[texture - 1].pixels ? &scene->textures[texture - 1] : NULL,
			.transform = &transforms[p],
		};
	}
	return STILB_OK;
}

stilb_result stilb_geometry_impostor_of_model(const stilb_scene *scene, uint32_t model,
                                              const stilb_geometry_impostor_desc *desc, stilb_job_pool *pool,
                                              uint32_t worker, stilb_scene_impostor *impostor)
{
	STILB_ASSERT(scene && model < scene->model_count);
	uint32_t first = scene->first_part[model], count = scene->first_part[model + 1] - first;
	stilb_geometry_impostor_desc sides = *desc;
	sides.both_sides = scene->both_sides;
	*impostor = (stilb_scene_impostor){0};
	if (count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "model %u has no parts: it gets no impostor", model);
	stilb_geometry_impostor_part *parts = stilb_memory_alloc(count, sizeof *parts);
	stilb_mat4 *transforms = stilb_memory_alloc(count, sizeof *transforms);
	stilb_result result = parts && transforms ? impostor_list_parts(scene, first, count, parts, transforms)
	                                          : stilb_fail(STILB_ERROR_MEMORY, "no memory for %u parts", count);
	if (result == STILB_OK)
		result = stilb_geometry_impostor_bake(parts, count, &sides, pool, worker, impostor);
	free(parts);
	free(transforms);
	return result;
}
