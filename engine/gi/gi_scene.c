/*
 * gi_scene: from the parts of a scene (a part is a mesh placed in the world) to triangles that rays can hit.
 *
 * A part's mesh is copied into world space, where rays are traced fastest. Only if the copies for all parts of a mesh
 * would have more than COPIES_MAX triangles beyond the mesh's own do the parts share one mesh, as instances: the
 * triangles stay in the mesh's space, and rays are transformed to it.
 */
#include "gi/gi_surface.h"
#include "gi/integrate/gi_backdrop.h"

#include "profiler/prof.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define COPIES_MAX 65536u    /* triangles that copies of a mesh may add to the mesh's own */
#define COORDINATE_MAX 1e10f /* metres; products of three edges between such points are still finite */
#define TRIANGLES_MAX (1u << 30)

static_assert(sizeof(stilb_scene_vertex) == 32, "gi_primary loads whole vertices");

/* ---- transforms -------------------------------------------------------------------------------------------------- */

static stilb_vec3 point_to_world(const stilb_mat4 *m, const float p[3])
{
	stilb_vec3 world;
	for (int i = 0; i < 3; i++)
		world[i] = m->m[i] * p[0] + m->m[4 + i] * p[1] + m->m[8 + i] * p[2] + m->m[12 + i];
	world[3] = 0.0f;
	return world;
}

/* The cofactors of the upper 3x3, which are the transposed inverse times the determinant; returns the determinant.
 * In double, so that a transform that is nearly flat in one direction keeps its digits. */
static double cofactors_of(const stilb_mat4 *m, double cofactors[9])
{
	for (size_t column = 0; column < 3; column++) {
		const float *a = m->m + (column + 1) % 3 * 4, *b = m->m + (column + 2) % 3 * 4;
		for (size_t row = 0; row < 3; row++) {
			size_t i = (row + 1) % 3, j = (row + 2) % 3;
			cofactors[column * 3 + row] = (double)a[i] * (double)b[j] - (double)a[j] * (double)b[i];
		}
	}
	return (double)m->m[0] * cofactors[0] + (double)m->m[1] * cofactors[1] + (double)m->m[2] * cofactors[2];
}

/* The transposed inverse of the upper 3x3, column by column, which takes normals to world space, scaled so that their
 * length stays about the same. All 0 if the transform flattens space, so that there is no inverse. */
static void normal_matrix_of(const stilb_mat4 *m, float out[9])
{
	double cofactors[9];
	double determinant = cofactors_of(m, cofactors);
	for (int i = 0; i < 9; i++)
		out[i] = determinant != 0.0 ? (float)(cofactors[i] / determinant) : 0.0f;
}

/* The Frobenius norm of the upper 3x3, an upper bound of its largest singular value. */
static float stretch_of(const stilb_mat4 *m)
{
	float square = 0.0f;
	for (int column = 0; column < 3; column++)
		for (int row = 0; row < 3; row++)
			square += m->m[column * 4 + row] * m->m[column * 4 + row];
	return sqrtf(square);
}

/* True if the transform is nearly a similarity, so that going to the mesh's space and back loses few digits: norm(M)
 * * norm(inverse(M)) < 6. It is 3 for a similarity. */
static bool is_near_similarity(const stilb_mat4 *m)
{
	float normal[9], square = 0.0f;
	normal_matrix_of(m, normal);
	for (int i = 0; i < 9; i++)
		square += normal[i] * normal[i];
	float product = sqrtf(square) * stretch_of(m);
	return product > 0.0f && product < 6.0f;
}

static bool is_mirrored(const stilb_mat4 *m)
{
	double cofactors[9];
	return cofactors_of(m, cofactors) < 0.0;
}

/* The normal n in world space, unit; 0 if n is 0 or not finite, or if matrix (of normal_matrix_of) is all 0. */
static void normal_to_world(const float matrix[9], const float n[3], float out[3])
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

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* Decided before anything is copied: which meshes are shared by instances, and how many vertices, triangles and meshes
 * the gi_scene will have. */
typedef struct mesh_plan {
	uint32_t *uses; /* [mesh_count] parts of each mesh that may be instances */
	/* [mesh_count] 1 + the mesh's index in the result if instances share it; 0: each part has a copy */
	uint32_t *shared;
	bool *shown; /* [part_count] false: a part of a hidden or removed model, of which rays see nothing */
	uint64_t vertices, triangles;
	uint32_t meshes;
} mesh_plan;

static bool material_emits(const stilb_scene_material *material)
{
	return material->emission[0] > 0.0f || material->emission[1] > 0.0f || material->emission[2] > 0.0f;
}

static bool part_emits(const stilb_scene *scene, uint32_t part)
{
	STILB_ASSERT(scene->part_material[part] < scene->material_count);
	return material_emits(&scene->materials[scene->part_material[part]]);
}

static bool part_may_share(const stilb_scene *scene, uint32_t part)
{
	STILB_ASSERT(part < scene->part_count);
	const stilb_mat4 *to_world = &scene->part_transform[part];
	for (int i = 12; i < 15; i++)
		if (!(fabsf(to_world->m[i]) <= COORDINATE_MAX))
			return false; /* copied instead: a copy's corners are checked in world space, an instance's are not */
	return !part_emits(scene, part) && is_near_similarity(to_world);
}

/* The mesh of parts that are not shown: they keep their place, since parts have the same ids here as in the scene. */
static const stilb_scene_mesh mesh_of_nothing;

static void plan_finish(mesh_plan *plan)
{
	free(plan->uses);
	free(plan->shared);
	free(plan->shown);
}

static void plan_mesh(mesh_plan *plan, const stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh->indices || mesh->index_count == 0);
	plan->vertices += mesh->vertex_count;
	plan->triangles += mesh->index_count / 3;
	plan->meshes++;
}

static stilb_result plan_make(const stilb_scene *scene, mesh_plan *plan)
{
	*plan = (mesh_plan){0};
	plan->uses = calloc((size_t)scene->mesh_count + 1, sizeof *plan->uses);
	plan->shared = calloc((size_t)scene->mesh_count + 1, sizeof *plan->shared);
	plan->shown = calloc((size_t)scene->part_count + 1, sizeof *plan->shown);
	if (!plan->uses || !plan->shared || !plan->shown)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u meshes", scene->mesh_count);
	for (uint32_t model = 0; model < scene->model_count; model++)
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++)
			plan->shown[part] = !isnan(scene->bounds.radius[model]);
	for (uint32_t part = 0; part < scene->part_count; part++)
		if (plan->shown[part] && part_may_share(scene, part))
			plan->uses[scene->part_mesh[part]]++;
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++) {
		uint64_t copies = plan->uses[mesh] ? plan->uses[mesh] - 1 : 0;
		if (copies * (scene->meshes[mesh].index_count / 3) <= COPIES_MAX)
			continue;
		plan_mesh(plan, &scene->meshes[mesh]);
		plan->shared[mesh] = plan->meshes;
	}
	for (uint32_t part = 0; part < scene->part_count; part++) {
		uint32_t mesh = scene->part_mesh[part];
		if (!plan->shown[part])
			plan_mesh(plan, &mesh_of_nothing);
		else if (!plan->shared[mesh] || !part_may_share(scene, part))
			plan_mesh(plan, &scene->meshes[mesh]);
	}
	if (plan->triangles > TRIANGLES_MAX)
		return stilb_fail(STILB_ERROR_ARGUMENT, "the scene has %llu triangles; at most %u can be traced",
		                  (unsigned long long)plan->triangles, TRIANGLES_MAX);
	return STILB_OK;
}

static bool position_is_usable(const stilb_scene_vertex *vertex)
{
	for (int i = 0; i < 3; i++)
		if (!(fabsf(vertex->position[i]) <= COORDINATE_MAX))
			return false;
	return true;
}

/* True if the triangle's area is above 0 in float arithmetic, which is what rays are traced in. */
static bool triangle_has_area(const stilb_scene_vertex *v0, const stilb_scene_vertex *v1, const stilb_scene_vertex *v2)
{
	float a[3], b[3];
	for (int i = 0; i < 3; i++) {
		a[i] = v1->position[i] - v0->position[i];
		b[i] = v2->position[i] - v0->position[i];
	}
	float x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
	return fabsf(x) + fabsf(y) + fabsf(z) >= FLT_MIN;
}

static void box_empty(float low[3], float high[3])
{
	for (int axis = 0; axis < 3; axis++) {
		low[axis] = INFINITY;
		high[axis] = -INFINITY;
	}
}

static void box_add(float low[3], float high[3], const float point[3])
{
	for (int axis = 0; axis < 3; axis++) {
		low[axis] = point[axis] < low[axis] ? point[axis] : low[axis];
		high[axis] = point[axis] > high[axis] ? point[axis] : high[axis];
	}
}

/* The box around the triangles. Vertices that no triangle uses are left out: they may be NaN. */
static void mesh_box(gi_mesh *mesh)
{
	box_empty(mesh->low, mesh->high);
	for (uint32_t k = 0; k < mesh->triangle_count; k++)
		for (int corner = 0; corner < 3; corner++)
			box_add(mesh->low, mesh->high, mesh->vertices[mesh->triangles[k].vertex[corner]].position);
}

/* Appends a copy of the mesh, transformed, without the triangles that cannot be hit. */
static void mesh_add(stilb_gi_scene *gi, const stilb_scene_mesh *mesh, const stilb_mat4 *transform)
{
	gi_mesh *out = &gi->meshes[gi->mesh_count];
	stilb_scene_vertex *vertices = gi->vertices;
	gi_triangle *triangles = gi->triangles;
	if (gi->mesh_count > 0) {
		const gi_mesh *last = out - 1;
		STILB_ASSERT(last->vertices && last->triangles && "meshes are added in order");
		vertices = (stilb_scene_vertex *)last->vertices + last->vertex_count;
		triangles = (gi_triangle *)last->triangles + last->triangle_count;
	}
	float normal_matrix[9];
	normal_matrix_of(transform, normal_matrix);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const stilb_scene_vertex *vertex = &mesh->vertices[i];
		stilb_vec3 position = point_to_world(transform, vertex->position);
		vertices[i] = (stilb_scene_vertex){.position = {position[0], position[1], position[2]},
		                                   .uv = {vertex->uv[0], vertex->uv[1]}};
		normal_to_world(normal_matrix, vertex->normal, vertices[i].normal);
	}
	bool mirrored = is_mirrored(transform);
	uint32_t count = 0, invalid = 0;
	for (uint32_t i = 0; i + 2 < mesh->index_count; i += 3) {
		uint32_t a = mesh->indices[i], b = mesh->indices[i + 1 + mirrored], c = mesh->indices[i + 2 - mirrored];
		if (a >= mesh->vertex_count || b >= mesh->vertex_count || c >= mesh->vertex_count ||
		    !position_is_usable(&vertices[a]) || !position_is_usable(&vertices[b]) ||
		    !position_is_usable(&vertices[c])) {
			invalid++;
			continue;
		}
		if (!triangle_has_area(&vertices[a], &vertices[b], &vertices[c]))
			continue;
		STILB_ASSERT(a != b && b != c && c != a && "degenerate triangles are left out");
		triangles[count++] = (gi_triangle){
			.vertex = {a, b, c},
			.error = gi_triangle_shape_error(vertices[a].position, vertices[b].position, vertices[c].position)};
	}
	*out = (gi_mesh){.vertices = vertices,
	                 .triangles = triangles,
	                 .vertex_count = mesh->vertex_count,
	                 .triangle_count = count,
	                 .invalid_count = invalid};
	mesh_box(out);
	gi->mesh_count++;
	STILB_ASSERT(count <= mesh->index_count / 3);
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

static void part_add_nothing(stilb_gi_scene *gi, gi_part *part)
{
	*part = (gi_part){.first_light = GI_NO_LIGHT, .mesh = gi->mesh_count, .to_world = stilb_mat4_identity()};
	mesh_add(gi, &mesh_of_nothing, &part->to_world);
	part->vertices = gi->meshes[part->mesh].vertices;
	part->triangles = gi->meshes[part->mesh].triangles;
}

static void part_add(stilb_gi_scene *gi, const stilb_scene *scene, const mesh_plan *plan, uint32_t index)
{
	STILB_ASSERT(index < gi->part_count);
	STILB_ASSERT(!plan->shown[index] || scene->part_mesh[index] < scene->mesh_count);
	gi_part *part = &gi->parts[index];
	if (!plan->shown[index]) {
		part_add_nothing(gi, part);
		return;
	}
	uint32_t mesh = scene->part_mesh[index];
	bool emits = part_emits(scene, index);
	*part = (gi_part){.material = scene->part_material[index],
	                  .first_light = GI_NO_LIGHT,
	                  .instance = plan->shared[mesh] && part_may_share(scene, index),
	                  .to_world = scene->part_transform[index]};
	normal_matrix_of(&part->to_world, part->normal_to_world);
	part->stretch = stretch_of(&part->to_world);
	const stilb_scene_material *material = &gi->materials[part->material];
	part->plain = !part->instance && !material->diffuse_texture;
	for (int i = 0; i < 3; i++)
		part->albedo[i] = material->diffuse[i] + material->specular[i];
	if (part->instance) {
		part->mesh = plan->shared[mesh] - 1;
	} else {
		part->mesh = gi->mesh_count;
		mesh_add(gi, &scene->meshes[mesh], &part->to_world);
	}
	part->vertices = gi->meshes[part->mesh].vertices;
	part->triangles = gi->meshes[part->mesh].triangles;
	uint32_t count = gi->meshes[part->mesh].triangle_count;
	uint32_t invalid = gi->meshes[part->mesh].invalid_count;
	if (emits) {
		part->first_light = gi->info.lights;
		gi->info.lights += count;
	}
	gi->info.triangles += count;
	gi->info.invalid += invalid;
	gi->info.flat += scene->meshes[mesh].index_count / 3 - count - invalid;
}

/* The box around the boxes of all parts. Larger than needed for a rotated instance. */
static void box_of_parts(stilb_gi_scene *gi)
{
	box_empty(gi->info.low, gi->info.high);
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const gi_part *part = &gi->parts[i];
		const gi_mesh *mesh = &gi->meshes[part->mesh];
		for (uint32_t corner = 0; mesh->triangle_count > 0 && corner < 8; corner++) {
			float point[3];
			for (int axis = 0; axis < 3; axis++)
				point[axis] = corner >> axis & 1 ? mesh->high[axis] : mesh->low[axis];
			stilb_vec3 placed =
				part->instance ? point_to_world(&part->to_world, point) : stilb_vec3_make(point[0], point[1], point[2]);
			box_add(gi->info.low, gi->info.high, (float[3]){placed[0], placed[1], placed[2]});
		}
	}
}

static stilb_result lights_make(stilb_gi_scene *gi, const stilb_scene *scene)
{
	PROFILE("gi.lights");
	gi_emitter *emitters = stilb_memory_alloc((size_t)gi->info.lights + 1, sizeof *emitters);
	if (!emitters)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", gi->info.lights);
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const gi_part *part = &gi->parts[i];
		const gi_mesh *mesh = &gi->meshes[part->mesh];
		for (uint32_t k = 0; part->first_light != GI_NO_LIGHT && k < mesh->triangle_count; k++) {
			STILB_ASSERT(part->first_light + k < gi->info.lights && !part->instance);
			gi_emitter *emitter = &emitters[part->first_light + k];
			for (int corner = 0; corner < 3; corner++)
				memcpy(emitter->position[corner], mesh->vertices[mesh->triangles[k].vertex[corner]].position,
				       sizeof emitter->position[corner]);
			memcpy(emitter->emission, gi->materials[part->material].emission, sizeof emitter->emission);
		}
	}
	stilb_result result = gi_lights_create(scene, emitters, gi->info.lights, &gi->lights);
	free(emitters);
	if (result == STILB_OK)
		result = gi_lights_create_open(scene, &gi->lights, &gi->open_lights);
	gi->info.lights += gi->lights.listed_count;
	return result;
}

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

static stilb_result gi_scene_allocate(stilb_gi_scene *gi, const stilb_scene *scene, const mesh_plan *plan)
{
	size_t meshes = (size_t)plan->meshes + 1, parts = (size_t)scene->part_count + 1;
	/* Room at the ends of the arrays: Embree reads 16 bytes where the last vertex's position has 12, and beyond the
	 * last triangle. */
	size_t vertices = (size_t)plan->vertices + 1, triangles = (size_t)plan->triangles + 2;
	gi->meshes = calloc(meshes, sizeof *gi->meshes);
	gi->parts = calloc(parts, sizeof *gi->parts);
	gi->materials = calloc((size_t)scene->material_count + 1, sizeof *gi->materials);
	gi->vertices = stilb_memory_alloc(vertices, sizeof *gi->vertices);
	gi->triangles = stilb_memory_alloc(triangles, sizeof *gi->triangles);
	if (!gi->meshes || !gi->parts || !gi->materials || !gi->vertices || !gi->triangles)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %llu triangles",
		                  (unsigned long long)plan->triangles);
	gi->info.bytes = vertices * sizeof *gi->vertices + triangles * sizeof *gi->triangles + parts * sizeof *gi->parts +
	                 meshes * sizeof *gi->meshes;
	return STILB_OK;
}

static stilb_result gi_scene_fill(stilb_gi_scene *gi, const stilb_scene *scene, const mesh_plan *plan)
{
	PROFILE("gi.triangles");
	stilb_result result = gi_scene_allocate(gi, scene, plan);
	if (result != STILB_OK)
		return result;
	memcpy(gi->materials, scene->materials, scene->material_count * sizeof *gi->materials);
	gi->material_count = scene->material_count;
	gi->textures = scene->textures;
	gi->texture_count = scene->texture_count;
	stilb_mat4 identity = stilb_mat4_identity();
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++)
		if (plan->shared[mesh])
			mesh_add(gi, &scene->meshes[mesh], &identity);
	gi->part_count = scene->part_count;
	for (uint32_t part = 0; part < scene->part_count; part++)
		part_add(gi, scene, plan, part);
	STILB_ASSERT(gi->mesh_count == plan->meshes &&
	             gi->info.triangles + gi->info.flat + gi->info.invalid >= plan->triangles);
	box_of_parts(gi);
	return STILB_OK;
}

static stilb_result gi_scene_make(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc)
{
	mesh_plan plan;
	stilb_result result = plan_make(scene, &plan);
	if (result == STILB_OK)
		result = gi_scene_fill(gi, scene, &plan);
	plan_finish(&plan);
	if (result == STILB_OK)
		result = lights_make(gi, scene);
	if (result == STILB_OK)
		result = gi_backdrop_create(scene, &gi->backdrop);
	if (result == STILB_OK)
		result = desc->intersector->create(gi, desc, &gi->tracer, &gi->info);
	return result;
}

/* All indices are in range, and every triangle can be hit. For STILB_CHECK. */
static bool mesh_is_sound(const gi_mesh *mesh)
{
	if ((uintptr_t)mesh->vertices % sizeof *mesh->vertices != 0)
		return false;
	for (uint32_t i = 0; i < mesh->triangle_count; i++) {
		const gi_triangle *triangle = &mesh->triangles[i];
		if (!(triangle->error > 0.0f))
			return false;
		for (int k = 0; k < 3; k++)
			if (triangle->vertex[k] >= mesh->vertex_count)
				return false;
	}
	return true;
}

static bool part_is_sound(const stilb_gi_scene *gi, const gi_part *part)
{
	if (part->mesh >= gi->mesh_count)
		return false;
	const gi_mesh *mesh = &gi->meshes[part->mesh];
	if (mesh->triangle_count > 0 && part->material >= gi->material_count)
		return false;
	bool lights = part->first_light == GI_NO_LIGHT ||
	              (!part->instance && part->first_light + mesh->triangle_count <= gi->lights.emitter_count);
	return lights && part->vertices == mesh->vertices && part->triangles == mesh->triangles;
}

static bool gi_scene_is_sound(const stilb_gi_scene *gi)
{
	for (uint32_t i = 0; i < gi->mesh_count; i++)
		if (!mesh_is_sound(&gi->meshes[i]))
			return false;
	for (uint32_t i = 0; i < gi->part_count; i++)
		if (!part_is_sound(gi, &gi->parts[i]))
			return false;
	return gi->tracer.intersect && gi->tracer.intersect16 && gi->tracer.occluded;
}

stilb_result stilb_gi_scene_create(const stilb_scene *scene, const stilb_gi_scene_desc *desc, stilb_gi_scene **out)
{
	STILB_ASSERT(scene && out);
	STILB_ASSERT(desc && desc->pool && desc->intersector);
	PROFILE("gi.scene");
	*out = NULL;
	stilb_gi_scene *gi = calloc(1, sizeof *gi);
	if (!gi)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene");
	stilb_owner_take(&gi->owner);
	gi->intersector = desc->intersector;
	stilb_result result = gi_scene_make(gi, scene, desc);
	if (result != STILB_OK) {
		stilb_gi_scene_destroy(gi);
		return result;
	}
	STILB_CHECK(gi_scene_is_sound(gi));
	*out = gi;
	return STILB_OK;
}

void stilb_gi_scene_destroy(stilb_gi_scene *scene)
{
	if (!scene)
		return;
	STILB_ASSERT_OWNER(scene->owner);
	scene->intersector->destroy(&scene->tracer);
	gi_backdrop_destroy(scene->backdrop);
	gi_lights_destroy(&scene->open_lights);
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
	STILB_ASSERT(scene);
	return &scene->info;
}
