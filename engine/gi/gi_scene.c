/*
 * gi_scene: from the scene's parts to triangles that rays can meet.
 *
 * A part becomes triangles in the world's space, which trace fastest. Only where that would multiply a mesh beyond
 * SCENE_COPIES triangles do its parts stay instances of one.
 */
#include "gi/gi_world.h"

#include "profiler/prof.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define SCENE_COPIES 65536u        /* triangles more than the mesh has itself */
#define SCENE_COORDINATE_MAX 1e10f /* metres; products of three edges between such places are still numbers */
#define SCENE_TRIANGLES_MAX (1u << 30)

static_assert(sizeof(stilb_scene_vertex) == 32, "gi_primary loads whole vertices");

/* ---- transforms --------------------------------------------------------------------------------------------------- */

static stilb_vec3 scene_point(const stilb_mat4 *m, const float p[3])
{
	stilb_vec3 world;
	for (int i = 0; i < 3; i++)
		world[i] = m->m[i] * p[0] + m->m[4 + i] * p[1] + m->m[8 + i] * p[2] + m->m[12 + i];
	world[3] = 0.0f;
	return world;
}

/* The cofactors of the upper 3x3: the transposed inverse times the determinant, which is returned. In double: what is
 * small in one direction keeps its digits. */
static double scene_cofactors(const stilb_mat4 *m, double cofactors[9])
{
	for (int column = 0; column < 3; column++) {
		const float *a = m->m + (column + 1) % 3 * 4, *b = m->m + (column + 2) % 3 * 4;
		for (int row = 0; row < 3; row++) {
			int i = (row + 1) % 3, j = (row + 2) % 3;
			cofactors[column * 3 + row] = (double)a[i] * (double)b[j] - (double)a[j] * (double)b[i];
		}
	}
	return (double)m->m[0] * cofactors[0] + (double)m->m[1] * cofactors[1] + (double)m->m[2] * cofactors[2];
}

/* Normals to the world but for their length, which is about kept. A flat transform has none: then 0. */
static void scene_normal_matrix(const stilb_mat4 *m, float out[9])
{
	double cofactors[9];
	double determinant = scene_cofactors(m, cofactors);
	for (int i = 0; i < 9; i++)
		out[i] = determinant != 0.0 ? (float)(cofactors[i] / determinant) : 0.0f;
}

/* The root of the sum of all squares: at least the largest singular value. */
static float scene_stretch(const stilb_mat4 *m)
{
	float square = 0.0f;
	for (int column = 0; column < 3; column++)
		for (int row = 0; row < 3; row++)
			square += m->m[column * 4 + row] * m->m[column * 4 + row];
	return sqrtf(square);
}

/* Takes a transform to the mesh's space and back few digits: is it a turn and a scale, more or less? Of those the product is 3. */
static bool scene_keeps_shape(const stilb_mat4 *m)
{
	float normal[9], square = 0.0f;
	scene_normal_matrix(m, normal);
	for (int i = 0; i < 9; i++)
		square += normal[i] * normal[i];
	float product = sqrtf(square) * scene_stretch(m);
	return product > 0.0f && product < 6.0f;
}

static bool scene_mirrored(const stilb_mat4 *m)
{
	double cofactors[9];
	return scene_cofactors(m, cofactors) < 0.0;
}

/* Unit, or 0 where there is no direction in it. */
static void scene_normal(const float matrix[9], const float n[3], float out[3])
{
	double world[3], square = 0.0;
	for (int i = 0; i < 3; i++) {
		world[i] = (double)matrix[i] * (double)n[0] + (double)matrix[3 + i] * (double)n[1] +
		           (double)matrix[6 + i] * (double)n[2];
		square += world[i] * world[i];
	}
	double scale = square > 0.0 && square < (double)INFINITY ? 1.0 / sqrt(square) : 0.0;
	for (int i = 0; i < 3; i++)
		out[i] = scale > 0.0 ? (float)(world[i] * scale) : 0.0f;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------- */

/* Which meshes are shared, and how much there will be. */
typedef struct scene_plan {
	uint32_t *uses;   /* of each of the scene's meshes, by parts that may be instances */
	uint32_t *shared; /* 1 + its number in the world where it is shared; 0: each part has its own */
	uint64_t vertices, triangles;
	uint32_t meshes;
} scene_plan;

static bool scene_emits(const stilb_scene_material *material)
{
	return material->emission[0] > 0.0f || material->emission[1] > 0.0f || material->emission[2] > 0.0f;
}

static bool scene_part_emits(const stilb_scene *scene, uint32_t part)
{
	return scene_emits(&scene->materials[scene->part_material[part]]);
}

static bool scene_part_may_share(const stilb_scene *scene, uint32_t part)
{
	const stilb_mat4 *to_world = &scene->part_transform[part];
	for (int i = 12; i < 15; i++)
		if (!(fabsf(to_world->m[i]) <= SCENE_COORDINATE_MAX))
			return false; /* its triangles are looked at one by one */
	return !scene_part_emits(scene, part) && scene_keeps_shape(to_world);
}

static void scene_plan_finish(scene_plan *plan)
{
	free(plan->uses);
	free(plan->shared);
}

static void scene_plan_mesh(scene_plan *plan, const stilb_scene_mesh *mesh)
{
	plan->vertices += mesh->vertex_count;
	plan->triangles += mesh->index_count / 3;
	plan->meshes++;
}

static stilb_result scene_plan_make(const stilb_scene *scene, scene_plan *plan)
{
	*plan = (scene_plan){0};
	plan->uses = calloc((size_t)scene->mesh_count + 1, sizeof *plan->uses);
	plan->shared = calloc((size_t)scene->mesh_count + 1, sizeof *plan->shared);
	if (!plan->uses || !plan->shared)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u meshes", scene->mesh_count);
	for (uint32_t part = 0; part < scene->part_count; part++)
		if (scene_part_may_share(scene, part))
			plan->uses[scene->part_mesh[part]]++;
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++) {
		uint64_t copies = plan->uses[mesh] ? plan->uses[mesh] - 1 : 0;
		if (copies * (scene->meshes[mesh].index_count / 3) <= SCENE_COPIES)
			continue;
		scene_plan_mesh(plan, &scene->meshes[mesh]);
		plan->shared[mesh] = plan->meshes;
	}
	for (uint32_t part = 0; part < scene->part_count; part++) {
		uint32_t mesh = scene->part_mesh[part];
		if (!plan->shared[mesh] || !scene_part_may_share(scene, part))
			scene_plan_mesh(plan, &scene->meshes[mesh]);
	}
	if (plan->triangles > SCENE_TRIANGLES_MAX)
		return stilb_fail(STILB_ERROR_ARGUMENT, "the scene has %llu triangles; at most %u can be traced",
		                  (unsigned long long)plan->triangles, SCENE_TRIANGLES_MAX);
	return STILB_OK;
}

static bool scene_position_fine(const stilb_scene_vertex *vertex)
{
	for (int i = 0; i < 3; i++)
		if (!(fabsf(vertex->position[i]) <= SCENE_COORDINATE_MAX))
			return false;
	return true;
}

/* Is the triangle's area more than 0 in float arithmetic, which is what rays are traced in? */
static bool scene_triangle_has_area(const stilb_scene_vertex *v0, const stilb_scene_vertex *v1,
                                    const stilb_scene_vertex *v2)
{
	float a[3], b[3];
	for (int i = 0; i < 3; i++) {
		a[i] = v1->position[i] - v0->position[i];
		b[i] = v2->position[i] - v0->position[i];
	}
	float x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
	return fabsf(x) + fabsf(y) + fabsf(z) >= FLT_MIN;
}

static void scene_box_empty(float low[3], float high[3])
{
	for (int axis = 0; axis < 3; axis++) {
		low[axis] = INFINITY;
		high[axis] = -INFINITY;
	}
}

static void scene_box_add(float low[3], float high[3], const float point[3])
{
	for (int axis = 0; axis < 3; axis++) {
		low[axis] = point[axis] < low[axis] ? point[axis] : low[axis];
		high[axis] = point[axis] > high[axis] ? point[axis] : high[axis];
	}
}

/* Only vertices of triangles count: others may be no numbers. */
static void scene_mesh_box(gi_mesh *mesh)
{
	scene_box_empty(mesh->low, mesh->high);
	for (uint32_t k = 0; k < mesh->triangle_count; k++)
		for (int corner = 0; corner < 3; corner++)
			scene_box_add(mesh->low, mesh->high, mesh->vertices[mesh->triangles[k].vertex[corner]].position);
}

/* Appends a mesh, moved by transform, without what cannot be hit. */
static void scene_mesh_add(stilb_gi_scene *world, const stilb_scene_mesh *mesh, const stilb_mat4 *transform)
{
	gi_mesh *out = &world->meshes[world->mesh_count];
	stilb_scene_vertex *vertices = world->vertices;
	gi_triangle *triangles = world->triangles;
	if (world->mesh_count > 0) {
		const gi_mesh *last = out - 1;
		vertices = (stilb_scene_vertex *)last->vertices + last->vertex_count;
		triangles = (gi_triangle *)last->triangles + last->triangle_count;
	}
	float normal_matrix[9];
	scene_normal_matrix(transform, normal_matrix);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const stilb_scene_vertex *vertex = &mesh->vertices[i];
		stilb_vec3 position = scene_point(transform, vertex->position);
		vertices[i] = (stilb_scene_vertex){.position = {position[0], position[1], position[2]},
		                                   .uv = {vertex->uv[0], vertex->uv[1]}};
		scene_normal(normal_matrix, vertex->normal, vertices[i].normal);
	}
	bool mirrored = scene_mirrored(transform);
	uint32_t count = 0, invalid = 0;
	for (uint32_t i = 0; i + 2 < mesh->index_count; i += 3) {
		uint32_t a = mesh->indices[i], b = mesh->indices[i + 1 + mirrored], c = mesh->indices[i + 2 - mirrored];
		if (a >= mesh->vertex_count || b >= mesh->vertex_count || c >= mesh->vertex_count ||
		    !scene_position_fine(&vertices[a]) || !scene_position_fine(&vertices[b]) ||
		    !scene_position_fine(&vertices[c])) {
			invalid++;
			continue;
		}
		if (!scene_triangle_has_area(&vertices[a], &vertices[b], &vertices[c]))
			continue;
		triangles[count++] = (gi_triangle){
			.vertex = {a, b, c},
			.error = gi_triangle_shape_error(vertices[a].position, vertices[b].position, vertices[c].position)};
	}
	*out = (gi_mesh){.vertices = vertices,
	                 .triangles = triangles,
	                 .vertex_count = mesh->vertex_count,
	                 .triangle_count = count,
	                 .invalid_count = invalid};
	scene_mesh_box(out);
	world->mesh_count++;
}

/* ---- parts -------------------------------------------------------------------------------------------------------- */

static void scene_part_add(stilb_gi_scene *world, const stilb_scene *scene, const scene_plan *plan, uint32_t index)
{
	gi_part *part = &world->parts[index];
	uint32_t mesh = scene->part_mesh[index];
	bool emits = scene_part_emits(scene, index);
	*part = (gi_part){.material = scene->part_material[index],
	                  .first_light = GI_NO_LIGHT,
	                  .instance = plan->shared[mesh] && scene_part_may_share(scene, index),
	                  .to_world = scene->part_transform[index]};
	scene_normal_matrix(&part->to_world, part->normal_to_world);
	part->stretch = scene_stretch(&part->to_world);
	const stilb_scene_material *material = &world->materials[part->material];
	part->plain = !part->instance && !material->diffuse_texture;
	for (int i = 0; i < 3; i++)
		part->albedo[i] = material->diffuse[i] + material->specular[i];
	if (part->instance) {
		part->mesh = plan->shared[mesh] - 1;
	} else {
		part->mesh = world->mesh_count;
		scene_mesh_add(world, &scene->meshes[mesh], &part->to_world);
	}
	part->vertices = world->meshes[part->mesh].vertices;
	part->triangles = world->meshes[part->mesh].triangles;
	const uint32_t count = world->meshes[part->mesh].triangle_count;
	const uint32_t invalid = world->meshes[part->mesh].invalid_count;
	if (emits) {
		part->first_light = world->info.lights;
		world->info.lights += count;
	}
	world->info.triangles += count;
	world->info.invalid += invalid;
	world->info.flat += scene->meshes[mesh].index_count / 3 - count - invalid;
}

/* Around the boxes of all parts' meshes: of an instance that is turned, more than it fills. */
static void scene_box(stilb_gi_scene *world)
{
	scene_box_empty(world->info.low, world->info.high);
	for (uint32_t i = 0; i < world->part_count; i++) {
		const gi_part *part = &world->parts[i];
		const gi_mesh *mesh = &world->meshes[part->mesh];
		for (uint32_t corner = 0; mesh->triangle_count > 0 && corner < 8; corner++) {
			float point[3];
			for (int axis = 0; axis < 3; axis++)
				point[axis] = corner >> axis & 1 ? mesh->high[axis] : mesh->low[axis];
			stilb_vec3 placed =
				part->instance ? scene_point(&part->to_world, point) : stilb_vec3_make(point[0], point[1], point[2]);
			scene_box_add(world->info.low, world->info.high, (float[3]){placed[0], placed[1], placed[2]});
		}
	}
}

static stilb_result scene_lights(stilb_gi_scene *world, const stilb_scene *scene)
{
	PROFILE("gi.lights");
	gi_emitter *emitters = stilb_memory_alloc((size_t)world->info.lights + 1, sizeof *emitters);
	if (!emitters)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", world->info.lights);
	for (uint32_t i = 0; i < world->part_count; i++) {
		const gi_part *part = &world->parts[i];
		const gi_mesh *mesh = &world->meshes[part->mesh];
		for (uint32_t k = 0; part->first_light != GI_NO_LIGHT && k < mesh->triangle_count; k++) {
			gi_emitter *emitter = &emitters[part->first_light + k];
			for (int corner = 0; corner < 3; corner++)
				memcpy(emitter->position[corner], mesh->vertices[mesh->triangles[k].vertex[corner]].position,
				       sizeof emitter->position[corner]);
			memcpy(emitter->emission, world->materials[part->material].emission, sizeof emitter->emission);
		}
	}
	stilb_result result = gi_lights_create(scene, emitters, world->info.lights, &world->lights);
	free(emitters);
	world->info.lights += world->lights.point_count;
	return result;
}

/* ---- life cycle --------------------------------------------------------------------------------------------------- */

static stilb_result scene_allocate(stilb_gi_scene *world, const stilb_scene *scene, const scene_plan *plan)
{
	size_t meshes = (size_t)plan->meshes + 1, parts = (size_t)scene->part_count + 1;
	/* Embree reads 16 bytes at the last vertex's position, and more at the last triangle. */
	size_t vertices = (size_t)plan->vertices + 1, triangles = (size_t)plan->triangles + 2;
	world->meshes = calloc(meshes, sizeof *world->meshes);
	world->parts = calloc(parts, sizeof *world->parts);
	world->materials = calloc((size_t)scene->material_count + 1, sizeof *world->materials);
	world->vertices = stilb_memory_alloc(vertices, sizeof *world->vertices);
	world->triangles = stilb_memory_alloc(triangles, sizeof *world->triangles);
	if (!world->meshes || !world->parts || !world->materials || !world->vertices || !world->triangles)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %llu triangles",
		                  (unsigned long long)plan->triangles);
	world->info.bytes = vertices * sizeof *world->vertices + triangles * sizeof *world->triangles +
	                    parts * sizeof *world->parts + meshes * sizeof *world->meshes;
	return STILB_OK;
}

static stilb_result scene_fill(stilb_gi_scene *world, const stilb_scene *scene, const scene_plan *plan)
{
	PROFILE("gi.triangles");
	stilb_result result = scene_allocate(world, scene, plan);
	if (result != STILB_OK)
		return result;
	memcpy(world->materials, scene->materials, scene->material_count * sizeof *world->materials);
	world->material_count = scene->material_count;
	world->textures = scene->textures;
	world->texture_count = scene->texture_count;
	stilb_mat4 identity = stilb_mat4_identity();
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++)
		if (plan->shared[mesh])
			scene_mesh_add(world, &scene->meshes[mesh], &identity);
	world->part_count = scene->part_count;
	for (uint32_t part = 0; part < scene->part_count; part++)
		scene_part_add(world, scene, plan, part);
	scene_box(world);
	return STILB_OK;
}

static stilb_result scene_make(stilb_gi_scene *world, const stilb_scene *scene, const stilb_gi_scene_desc *desc)
{
	scene_plan plan;
	stilb_result result = scene_plan_make(scene, &plan);
	if (result == STILB_OK)
		result = scene_fill(world, scene, &plan);
	scene_plan_finish(&plan);
	if (result == STILB_OK)
		result = scene_lights(world, scene);
	if (result == STILB_OK)
		result = desc->intersector->create(world, desc, &world->tracer, &world->info);
	return result;
}

stilb_result stilb_gi_scene_create(const stilb_scene *scene, const stilb_gi_scene_desc *desc, stilb_gi_scene **out)
{
	PROFILE("gi.scene");
	*out = NULL;
	stilb_gi_scene *world = calloc(1, sizeof *world);
	if (!world)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene");
	world->intersector = desc->intersector;
	stilb_result result = scene_make(world, scene, desc);
	if (result != STILB_OK) {
		stilb_gi_scene_destroy(world);
		return result;
	}
	*out = world;
	return STILB_OK;
}

void stilb_gi_scene_destroy(stilb_gi_scene *scene)
{
	if (!scene)
		return;
	scene->intersector->destroy(&scene->tracer);
	gi_lights_destroy(&scene->lights);
	free(scene->meshes);
	free(scene->parts);
	free(scene->materials);
	free(scene->vertices);
	free(scene->triangles);
	free(scene);
}

const stilb_gi_scene_info *stilb_gi_scene_info_of(const stilb_gi_scene *scene)
{
	return &scene->info;
}
