/*
 * gi_scene: from the parts of a scene (a part is a mesh placed in the world) to triangles that rays can hit.
 *
 * A part's mesh is copied into world space, where rays are traced fastest. Only if the copies for all parts of a mesh
 * would have more than COPIES_MAX triangles beyond the mesh's own do the parts share one mesh, as instances: the
 * triangles stay in the mesh's space, and rays are transformed to it. In a scene whose models will move (desc.movable)
 * all parts are instances that can be, so that what moves is only their transforms.
 */
#include "gi/gi_scene_lights.h"
#include "gi/gi_scene_textures.h"
#include "gi/gi_surface.h"
#include "gi/integrate/gi_backdrop.h"
#include "gi/lanes/gi_lanes.h"

#include "profiler/prof.h"
#include "scene/play/scene_play.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define COPIES_MAX 65536u    /* triangles that copies of a mesh may add to the mesh's own */
#define COORDINATE_MAX 1e10f /* metres; products of three edges between such points are still finite */
#define TRIANGLES_MAX (1u << 30)
#define ASK_TRIANGLES (1u << 18) /* triangles that are copied between two questions whether the scene is given up */

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

/* The upper 3x3, column by column, which takes tangents to world space. */
static void tangent_matrix_of(const stilb_mat4 *m, float out[9])
{
	for (size_t column = 0; column < 3; column++)
		memcpy(out + 3 * column, m->m + 4 * column, 3 * sizeof *out);
}

/* The normal n in world space, unit; 0 if n is 0 or not finite, or if matrix (of normal_matrix_of) is all 0. Of a
 * tangent with tangent_matrix_of. */
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

/* What becomes of a part. */
typedef struct part_plan {
	uint32_t mesh;        /* index of its mesh in the result */
	bool shown, instance; /* shown: rays see it; a hidden model's parts, or a removed one's, are not */
	bool emits;           /* its triangles are lights */
	uint8_t flags;        /* of its model: STILB_SCENE_MODEL_... */
} part_plan;

/* Decided before anything is copied: which meshes are shared by instances, and how many vertices, triangles and meshes
 * the gi_scene will have. */
typedef struct mesh_plan {
	uint32_t *uses; /* [mesh_count] parts of each mesh that may be instances */
	/* [mesh_count] 1 + the mesh's index in the result if instances share it; 0: each part has a copy */
	uint32_t *shared;
	part_plan *parts; /* [part_count] */
	uint64_t vertices, extras, triangles;
	uint32_t meshes;
} mesh_plan;

static bool part_may_share(const stilb_scene *scene, uint32_t part, bool emits)
{
	STILB_ASSERT(part < scene->part_count);
	const stilb_mat4 *to_world = &scene->part_transform[part];
	for (int i = 12; i < 15; i++)
		if (!(fabsf(to_world->m[i]) <= COORDINATE_MAX))
			return false; /* copied instead: a copy's corners are checked in world space, an instance's are not */
	return !emits && is_near_similarity(to_world);
}

/* The mesh of parts that are not shown: they keep their place, since parts have the same ids here as in the scene. */
static const stilb_scene_mesh mesh_of_nothing;

static void plan_finish(mesh_plan *plan)
{
	free(plan->uses);
	free(plan->shared);
	free(plan->parts);
}

static void plan_mesh(mesh_plan *plan, const stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh->indices || mesh->index_count == 0);
	plan->vertices += mesh->vertex_count;
	plan->extras += mesh->extras ? mesh->vertex_count : 0;
	plan->triangles += mesh->index_count / 3;
	plan->meshes++;
}

/* Which parts are shown, and which of them may be instances: of a scene that is movable hidden ones, too, since they
 * may be shown again. */
static void plan_parts(stilb_gi_scene *gi, const stilb_scene *scene, bool movable, mesh_plan *plan)
{
	for (uint32_t model = 0; model < scene->model_count; model++)
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++) {
			part_plan *to = &plan->parts[part];
			to->shown = !isnan(scene->bounds.radius[model]);
			to->flags = scene->model_flags[model];
			bool kept = movable && scene->part_mesh[part] != STILB_SCENE_NONE;
			to->emits = (to->shown || kept) && gi_scene_emits(gi, scene, scene->part_material[part]);
			to->instance = (to->shown || kept) && part_may_share(scene, part, to->emits);
			if (to->instance)
				plan->uses[scene->part_mesh[part]]++;
		}
}

/* Gives the meshes of the result their places: first the shared ones, then the parts' own. */
static void plan_meshes(const stilb_scene *scene, bool movable, mesh_plan *plan)
{
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++) {
		uint64_t copies = plan->uses[mesh] ? plan->uses[mesh] - 1 : 0;
		bool saves = copies * (scene->meshes[mesh].index_count / 3) > COPIES_MAX;
		if (!saves && !(movable && plan->uses[mesh] > 0))
			continue;
		plan_mesh(plan, &scene->meshes[mesh]);
		plan->shared[mesh] = plan->meshes;
	}
	for (uint32_t part = 0; part < scene->part_count; part++) {
		part_plan *to = &plan->parts[part];
		uint32_t mesh = scene->part_mesh[part];
		to->instance = to->instance && plan->shared[mesh] > 0;
		to->mesh = to->instance ? plan->shared[mesh] - 1 : plan->meshes;
		if (!to->instance)
			plan_mesh(plan, to->shown ? &scene->meshes[mesh] : &mesh_of_nothing);
	}
}

static stilb_result plan_make(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc,
                              mesh_plan *plan)
{
	bool movable = desc->movable;
	*plan = (mesh_plan){0};
	stilb_result result = gi_scene_textures_make(gi, scene, desc->pool);
	if (result == STILB_OK)
		result = gi_scene_ask_darkness(gi, scene);
	if (result != STILB_OK)
		return result;
	plan->uses = calloc((size_t)scene->mesh_count + 1, sizeof *plan->uses);
	plan->shared = calloc((size_t)scene->mesh_count + 1, sizeof *plan->shared);
	plan->parts = calloc((size_t)scene->part_count + 1, sizeof *plan->parts);
	if (!plan->uses || !plan->shared || !plan->parts)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u meshes", scene->mesh_count);
	plan_parts(gi, scene, movable, plan);
	plan_meshes(scene, movable, plan);
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

static void mesh_fill_extras(gi_mesh *out, const stilb_scene_mesh *mesh, const stilb_mat4 *transform, bool mirrored)
{
	stilb_scene_vertex_extra *extras = (stilb_scene_vertex_extra *)out->extras;
	float matrix[9];
	tangent_matrix_of(transform, matrix);
	out->colored = false;
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		extras[i] = mesh->extras[i];
		normal_to_world(matrix, mesh->extras[i].tangent, extras[i].tangent);
		extras[i].tangent[3] = mirrored ? -extras[i].tangent[3] : extras[i].tangent[3];
		for (int channel = 0; channel < 4; channel++)
			out->colored |= extras[i].color[channel] != 1.0f;
	}
}

/* Fills the mesh's arrays with a copy of another one, transformed, without the triangles that cannot be hit. */
static void mesh_fill(gi_mesh *out, const stilb_scene_mesh *mesh, const stilb_mat4 *transform)
{
	STILB_ASSERT(out->vertex_count == mesh->vertex_count && out->triangle_room == mesh->index_count / 3);
	stilb_scene_vertex *vertices = (stilb_scene_vertex *)out->vertices;
	gi_triangle *triangles = (gi_triangle *)out->triangles;
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
	if (out->extras)
		mesh_fill_extras(out, mesh, transform, mirrored);
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
	out->triangle_count = count;
	out->invalid_count = invalid;
	mesh_box(out);
	STILB_ASSERT(count <= out->triangle_room);
}

/* Appends a copy of the scene's mesh number `source`, of which mesh_of_nothing has none. */
static void mesh_add(stilb_gi_scene *gi, const stilb_scene_mesh *mesh, uint32_t source, const stilb_mat4 *transform)
{
	gi_mesh *out = &gi->meshes[gi->mesh_count];
	*out = (gi_mesh){.vertices = gi->vertices,
	                 .triangles = gi->triangles,
	                 .vertex_count = mesh->vertex_count,
	                 .triangle_room = mesh->index_count / 3,
	                 .source = source};
	if (gi->mesh_count > 0) {
		const gi_mesh *last = out - 1;
		STILB_ASSERT(last->vertices && last->triangles && "meshes are added in order");
		out->vertices = last->vertices + last->vertex_count;
		out->triangles = last->triangles + last->triangle_room;
	}
	if (mesh->extras) {
		out->extras = gi->extras + gi->extra_count;
		gi->extra_count += mesh->vertex_count;
	}
	mesh_fill(out, mesh, transform);
	gi->mesh_count++;
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

/* gi_part.surface of a part of this material and mesh: that of a material whose surface is not the same all over. */
static uint32_t surface_read(const stilb_gi_scene *gi, const stilb_scene_material *material, const gi_mesh *mesh)
{
	if (!material->surface)
		return 0;
	const stilb_scene_surface *surface = &gi->surfaces[material->surface - 1];
	bool more = mesh->colored || gi_maps_vary(surface) || gi_maps_are_layered(surface);
	return surface->unlit || more ? material->surface : 0;
}

/* True if alpha is 1 all over. */
static bool is_opaque(const gi_maps *maps, bool colored)
{
	const stilb_scene_surface *surface = maps->surface;
	uint32_t texture = surface->maps[STILB_SCENE_MAP_COLOR].texture;
	uint32_t channels = gi_maps_have(maps, STILB_SCENE_MAP_COLOR) ? maps->textures[texture - 1].channels : 3;
	bool varies = colored || channels == 2 || channels == 4;
	float least = surface->alpha == STILB_SCENE_MASK ? surface->cutoff : 1.0f;
	return surface->alpha == STILB_SCENE_OPAQUE || (!varies && surface->color[3] >= least);
}

/* True if rays may go through parts of this surface on such a mesh. */
static bool is_sieve(const gi_maps *maps, bool colored)
{
	return gi_maps_are_one_sided(maps->surface) || !is_opaque(maps, colored);
}

/* Decides whether rays go through a part, hidden ones that may be shown again included. */
static void part_sieve(stilb_gi_scene *gi, gi_part *part, const stilb_scene_material *material)
{
	gi_mesh *mesh = &gi->meshes[part->mesh];
	gi_maps maps = {material->surface ? &gi->surfaces[material->surface - 1] : NULL, gi->textures, gi->texture_count};
	part->sieve = maps.surface && is_sieve(&maps, mesh->colored) ? material->surface : 0;
	mesh->sieved |= part->sieve > 0;
	gi->blends |= part->sieve > 0 && gi->surfaces[part->sieve - 1].alpha == STILB_SCENE_BLEND;
}

/* Decides whether rays may go through a part as glass. Panes need a number for that. */
static void part_passes(stilb_gi_scene *gi, gi_part *part)
{
	if (!part->surface)
		return;
	const stilb_scene_surface *surface = &gi->surfaces[part->surface - 1];
	part->passes = surface->transmission > 0.0f && !surface->unlit;
	gi->passes |= part->passes;
	gi->blends |= part->passes && !gi_maps_are_solid(surface);
}

/* gi_part.mask of a part of a model with these flags. */
static uint32_t mask_of(uint32_t flags)
{
	if (!(flags & (STILB_SCENE_MODEL_UNSEEN | STILB_SCENE_MODEL_CASTS_NO_SHADOW)))
		return GI_MASK_ALL;
	return (flags & STILB_SCENE_MODEL_UNSEEN ? 0 : GI_MASK_LOOK) |
	       (flags & STILB_SCENE_MODEL_CASTS_NO_SHADOW ? 0 : GI_MASK_LIGHT);
}

/* Fills in a part whose mesh is there, and counts what it shows. */
static void part_set(stilb_gi_scene *gi, const stilb_scene *scene, const part_plan *plan, uint32_t index)
{
	STILB_ASSERT(index < gi->part_count && plan->mesh < gi->mesh_count);
	const gi_mesh *mesh = &gi->meshes[plan->mesh];
	gi_part *part = &gi->parts[index];
	*part = (gi_part){.mesh = plan->mesh,
	                  .vertices = mesh->vertices,
	                  .extras = mesh->extras,
	                  .triangles = mesh->triangles,
	                  .first_light = GI_NO_LIGHT,
	                  .instance = plan->instance,
	                  .hidden = !plan->shown,
	                  .mask = mask_of(plan->flags),
	                  .lit_by = plan->flags & STILB_SCENE_MODEL_RECEIVES_NO_SHADOW ? 0 : GI_MASK_LIGHT,
	                  .to_world = plan->shown || plan->instance ? scene->part_transform[index] : stilb_mat4_identity()};
	gi->flagged |= plan->flags != 0;
	if (plan->shown || plan->instance)
		part_sieve(gi, part, &gi->materials[scene->part_material[index]]);
	if (!plan->shown)
		return;
	part->material = scene->part_material[index];
	normal_matrix_of(&part->to_world, part->normal_to_world);
	part->stretch = stretch_of(&part->to_world);
	const stilb_scene_material *material = &gi->materials[part->material];
	part->mirrored = part->instance && is_mirrored(&part->to_world);
	part->surface = surface_read(gi, material, mesh);
	part_passes(gi, part);
	part->plain = !material->diffuse_texture && !part->surface;
	for (int i = 0; i < 3; i++)
		part->albedo[i] = material->diffuse[i] + material->specular[i];
	if (plan->emits) {
		part->first_light = gi->emitter_count;
		gi->emitter_count += mesh->triangle_count;
	}
	gi->info.triangles += mesh->triangle_count;
	gi->info.invalid += mesh->invalid_count;
	gi->info.flat += mesh->triangle_room - mesh->triangle_count - mesh->invalid_count;
}

static void part_add(stilb_gi_scene *gi, const stilb_scene *scene, const part_plan *plan, uint32_t index)
{
	if (!plan->instance && plan->shown)
		mesh_add(gi, &scene->meshes[scene->part_mesh[index]], scene->part_mesh[index], &scene->part_transform[index]);
	else if (!plan->instance)
		mesh_add(gi, &mesh_of_nothing, STILB_SCENE_NONE, &scene->part_transform[index]);
	part_set(gi, scene, plan, index);
}

/* The box around the boxes of all parts. Larger than needed for a rotated instance. */
static void box_of_parts(stilb_gi_scene *gi)
{
	box_empty(gi->info.low, gi->info.high);
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const gi_part *part = &gi->parts[i];
		const gi_mesh *mesh = &gi->meshes[part->mesh];
		for (uint32_t corner = 0; mesh->triangle_count > 0 && !part->hidden && corner < 8; corner++) {
			float point[3];
			for (int axis = 0; axis < 3; axis++)
				point[axis] = corner >> axis & 1 ? mesh->high[axis] : mesh->low[axis];
			stilb_vec3 placed =
				part->instance ? point_to_world(&part->to_world, point) : stilb_vec3_make(point[0], point[1], point[2]);
			box_add(gi->info.low, gi->info.high, (float[3]){placed[0], placed[1], placed[2]});
		}
	}
}

/* What is behind everything, in place of what was. */
static stilb_result backdrop_make(stilb_gi_scene *gi, const stilb_scene *scene)
{
	gi_backdrop *backdrop;
	stilb_result result = gi_backdrop_create(scene, &backdrop);
	gi_backdrop_destroy(gi->backdrop);
	gi->backdrop = backdrop;
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
	gi->surfaces = calloc((size_t)scene->surface_count + 1, sizeof *gi->surfaces);
	gi->vertices = stilb_memory_alloc(vertices, sizeof *gi->vertices);
	gi->extras = stilb_memory_alloc((size_t)plan->extras, sizeof *gi->extras);
	gi->triangles = stilb_memory_alloc(triangles, sizeof *gi->triangles);
	if (!gi->meshes || !gi->parts || !gi->materials || !gi->surfaces || !gi->vertices || !gi->extras || !gi->triangles)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %llu triangles",
		                  (unsigned long long)plan->triangles);
	gi->own_bytes = vertices * sizeof *gi->vertices + plan->extras * sizeof *gi->extras +
	                triangles * sizeof *gi->triangles + parts * sizeof *gi->parts + meshes * sizeof *gi->meshes;
	return STILB_OK;
}

static bool is_given_up(const stilb_gi_scene_desc *desc)
{
	return desc->give_up && desc->give_up(desc->user);
}

static stilb_result fail_given_up(void)
{
	return stilb_fail(STILB_ERROR_GIVEN_UP, "the scene was given up while it was made ready for rays");
}

/* Replaces the constants of a material, which are means, by those of its surface. */
static void material_from_surface(stilb_scene_material *material, const stilb_scene_surface *surface)
{
	gi_maps maps = {.surface = surface};
	gi_place place = {.color = {1.0f, 1.0f, 1.0f, 1.0f}};
	shade_gltf_base base = gi_maps_base(&maps, &place, gi_maps_color(&maps, &place));
	stilb_vec3 emission = gi_maps_emission(&maps, &place);
	for (int i = 0; i < 3; i++) {
		material->diffuse[i] = base.diffuse[i];
		material->specular[i] = base.specular[i];
		material->emission[i] = emission[i];
	}
	material->roughness = base.roughness;
	material->anisotropy = 0.0f;
	material->diffuse_texture = 0;
}

/* Rays lack the functions of surfaces: takes them out of the copies, and says so once for each. */
static void functions_leave(stilb_gi_scene *gi, const stilb_scene *scene)
{
	for (uint32_t s = 0; s < gi->surface_count; s++) {
		stilb_scene_surface *surface = &gi->surfaces[s];
		uint32_t function = surface->function - 1;
		bool there = surface->function > 0;
		surface->function = 0;
		memset(surface->parameters, 0, sizeof surface->parameters);
		if (!there || gi->lacking[function / 32] >> function % 32 & 1u)
			continue;
		gi->lacking[function / 32] |= 1u << function % 32;
		STILB_ASSERT(function < scene->function_count);
		stilb_log("rays lack the surface function '%s': its materials are shown without it",
		          scene->functions[function].name);
	}
}

/* Copies what may change at no cost. There is room for the materials and surfaces. */
static void gi_scene_copy(stilb_gi_scene *gi, const stilb_scene *scene)
{
	if (scene->material_count > 0)
		memcpy(gi->materials, scene->materials, scene->material_count * sizeof *gi->materials);
	if (scene->surface_count > 0)
		memcpy(gi->surfaces, scene->surfaces, scene->surface_count * sizeof *gi->surfaces);
	gi->material_count = scene->material_count;
	gi->surface_count = scene->surface_count;
	functions_leave(gi, scene);
	for (uint32_t i = 0; i < gi->material_count; i++) {
		STILB_ASSERT(gi->materials[i].surface <= gi->surface_count);
		if (gi->materials[i].surface)
			material_from_surface(&gi->materials[i], &gi->surfaces[gi->materials[i].surface - 1]);
	}
	gi->blends = gi->passes = gi->flagged = false;
	gi->emitter_count = 0;
	gi->textures = gi->found.textures;
	gi->texture_count = scene->texture_count;
	gi->info = (stilb_gi_scene_info){.isa = gi->info.isa, .bytes = gi->own_bytes};
}

static stilb_result gi_scene_fill(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc,
                                  const mesh_plan *plan)
{
	PROFILE("gi.triangles");
	uint64_t copied = 0;
	stilb_result result = gi_scene_allocate(gi, scene, plan);
	if (result != STILB_OK)
		return result;
	gi_scene_copy(gi, scene);
	stilb_mat4 identity = stilb_mat4_identity();
	for (uint32_t mesh = 0; mesh < scene->mesh_count; mesh++)
		if (plan->shared[mesh])
			mesh_add(gi, &scene->meshes[mesh], mesh, &identity);
	gi->part_count = scene->part_count;
	for (uint32_t part = 0; part < scene->part_count; part++) {
		part_add(gi, scene, &plan->parts[part], part);
		copied += gi->meshes[gi->parts[part].mesh].triangle_count;
		if (copied < ASK_TRIANGLES)
			continue;
		copied = 0;
		if (is_given_up(desc))
			return fail_given_up();
	}
	STILB_ASSERT(gi->mesh_count == plan->meshes);
	box_of_parts(gi);
	return STILB_OK;
}

/* Counts the changes of meshes but for poses, which leave them as many vertices and the same corners. */
static uint64_t shapes_of(const stilb_scene *scene)
{
	STILB_ASSERT(scene->revisions.poses <= scene->revisions.geometry);
	return scene->revisions.geometry - scene->revisions.poses;
}

static stilb_result gi_scene_make(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc,
                                  const mesh_plan *plan)
{
	gi->lanes = gi_lanes_of_cpu();
	gi->movable = desc->movable;
	gi->geometry = shapes_of(scene);
	gi->poses = scene->revisions.poses;
	stilb_result result = gi_scene_fill(gi, scene, desc, plan);
	if (result == STILB_OK)
		result = gi_scene_lights_make(gi, scene);
	if (result == STILB_OK)
		result = backdrop_make(gi, scene);
	if (result == STILB_OK && is_given_up(desc))
		result = fail_given_up();
	if (result == STILB_OK)
		result = desc->intersector->create(gi, desc, &gi->tracer, &gi->info);
	return result;
}

/* Leaves a scene of nothing. Its owner and intersector stay, and what was found. */
static void gi_scene_clear(stilb_gi_scene *gi)
{
	gi->intersector->destroy(&gi->tracer);
	gi_backdrop_destroy(gi->backdrop);
	gi_scene_lights_clear(gi);
	free(gi->meshes);
	free(gi->parts);
	free(gi->materials);
	free(gi->surfaces);
	free(gi->vertices);
	free(gi->extras);
	free(gi->triangles);
	uint32_t lacking[sizeof gi->lacking / sizeof *gi->lacking];
	memcpy(lacking, gi->lacking, sizeof lacking);
	*gi = (stilb_gi_scene){.owner = gi->owner, .intersector = gi->intersector, .found = gi->found};
	memcpy(gi->lacking, lacking, sizeof lacking);
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
	return lights && part->surface <= gi->surface_count && part->sieve <= gi->surface_count &&
	       part->vertices == mesh->vertices && part->extras == mesh->extras && part->triangles == mesh->triangles;
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
	mesh_plan plan;
	stilb_result result = plan_make(gi, scene, desc, &plan);
	if (result == STILB_OK)
		result = gi_scene_make(gi, scene, desc, &plan);
	plan_finish(&plan);
	if (result != STILB_OK) {
		stilb_gi_scene_destroy(gi);
		return result;
	}
	STILB_CHECK(gi_scene_is_sound(gi));
	*out = gi;
	return STILB_OK;
}

/* ---- updates ----------------------------------------------------------------------------------------------------- */

static bool is_same_place(const stilb_mat4 *a, const stilb_mat4 *b)
{
	return memcmp(a, b, sizeof *a) == 0;
}

/* True if rays will go through a part that is there; its mesh is as it was. */
static bool update_sieve(const stilb_gi_scene *gi, const stilb_scene *scene, uint32_t part)
{
	uint32_t surface = scene->materials[scene->part_material[part]].surface;
	gi_maps maps = {surface ? &scene->surfaces[surface - 1] : NULL, gi->found.textures, scene->texture_count};
	return surface && is_sieve(&maps, gi->meshes[gi->parts[part].mesh].colored);
}

/* True if all parts keep their meshes, so that these need not be made anew; of a scene that is not movable also if no
 * part has moved. */
static bool update_fits(const stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc,
                        const mesh_plan *plan)
{
	if (gi->broken || gi->movable != desc->movable || gi->geometry != shapes_of(scene) ||
	    gi->part_count != scene->part_count || gi->mesh_count != plan->meshes)
		return false;
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const gi_part *part = &gi->parts[i];
		const part_plan *to = &plan->parts[i];
		uint32_t source = to->shown || to->instance ? scene->part_mesh[i] : STILB_SCENE_NONE;
		if (part->mask != mask_of(to->flags))
			return false; /* trees know which rays meet which parts */
		if (part->mesh != to->mesh || part->instance != to->instance || gi->meshes[to->mesh].source != source)
			return false;
		if (source != STILB_SCENE_NONE && update_sieve(gi, scene, i) != (part->sieve > 0))
			return false; /* trees know which parts rays go through */
		bool moved = source != STILB_SCENE_NONE && !is_same_place(&part->to_world, &scene->part_transform[i]);
		if (!gi->movable && moved)
			return false;
	}
	return true;
}

/* Makes the mesh of a part that is there anew, unless another part's turn has done so. */
static void update_mesh(stilb_gi_scene *gi, const stilb_scene *scene, const part_plan *plan, uint32_t part)
{
	stilb_mat4 identity = stilb_mat4_identity();
	gi_mesh *mesh = &gi->meshes[plan->mesh];
	if (!mesh->fresh)
		mesh_fill(mesh, &scene->meshes[scene->part_mesh[part]],
		          plan->instance ? &identity : &scene->part_transform[part]);
	mesh->fresh = true;
}

/* Fills in all parts, and makes the meshes anew that have other poses, and the copies of parts that have moved. *moved:
 * room for all parts; gets those that rays shall see elsewhere, or otherwise, or no more, or again. */
static uint32_t update_parts(stilb_gi_scene *gi, const stilb_scene *scene, const mesh_plan *plan, uint32_t *moved)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < gi->mesh_count; i++)
		gi->meshes[i].fresh = false;
	for (uint32_t i = 0; i < gi->part_count; i++) {
		const gi_part *part = &gi->parts[i];
		const part_plan *to = &plan->parts[i];
		bool there = to->shown || to->instance, hidden = part->hidden;
		bool same = !there || is_same_place(&part->to_world, &scene->part_transform[i]);
		bool posed = there && stilb_scene_mesh_pose(scene, scene->part_mesh[i]) > gi->poses;
		if (posed || (!same && !to->instance))
			update_mesh(gi, scene, to, i);
		part_set(gi, scene, to, i);
		if (!same || posed || hidden != part->hidden)
			moved[count++] = i;
	}
	box_of_parts(gi);
	gi->poses = scene->revisions.poses;
	return count;
}

static stilb_result update_room(stilb_gi_scene *gi, const stilb_scene *scene)
{
	stilb_scene_material *materials =
		realloc(gi->materials, ((size_t)scene->material_count + 1) * sizeof *gi->materials);
	if (!materials)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u materials", scene->material_count);
	gi->materials = materials;
	stilb_scene_surface *surfaces = realloc(gi->surfaces, ((size_t)scene->surface_count + 1) * sizeof *gi->surfaces);
	if (!surfaces)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u surfaces", scene->surface_count);
	gi->surfaces = surfaces;
	return STILB_OK;
}

/* Brings a scene up to date whose parts keep their meshes. */
static stilb_result update_in_place(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc,
                                    const mesh_plan *plan)
{
	uint32_t *moved = malloc(((size_t)gi->part_count + 1) * sizeof *moved);
	if (!moved)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u parts", gi->part_count);
	uint64_t bytes = gi->info.bytes;
	stilb_result result = update_room(gi, scene);
	if (result == STILB_OK) {
		gi_scene_copy(gi, scene);
		uint32_t count = update_parts(gi, scene, plan, moved);
		result = gi_scene_lights_make(gi, scene);
		if (result == STILB_OK)
			result = backdrop_make(gi, scene);
		if (result == STILB_OK && count > 0)
			result = gi->intersector->update(gi, moved, count, desc, &gi->tracer, &gi->info);
		else
			gi->info.bytes = bytes;
	}
	free(moved);
	return result;
}

stilb_result stilb_gi_scene_update(stilb_gi_scene *gi, const stilb_scene *scene, const stilb_gi_scene_desc *desc)
{
	STILB_ASSERT(gi && scene && desc && desc->pool);
	STILB_ASSERT(desc->intersector == gi->intersector && "a scene keeps its intersector");
	STILB_ASSERT_OWNER(gi->owner);
	PROFILE("gi.update");
	mesh_plan plan;
	stilb_result result = plan_make(gi, scene, desc, &plan);
	if (result == STILB_OK && update_fits(gi, scene, desc, &plan)) {
		result = update_in_place(gi, scene, desc, &plan);
	} else if (result == STILB_OK) {
		gi_scene_clear(gi);
		result = gi_scene_make(gi, scene, desc, &plan);
	}
	plan_finish(&plan);
	gi->broken = result != STILB_OK;
	STILB_CHECK(gi->broken || gi_scene_is_sound(gi));
	return result;
}

void stilb_gi_scene_destroy(stilb_gi_scene *scene)
{
	if (!scene)
		return;
	STILB_ASSERT_OWNER(scene->owner);
	gi_scene_clear(scene);
	gi_scene_found_finish(&scene->found);
	free(scene);
}

const stilb_gi_scene_info *stilb_gi_scene_info_of(const stilb_gi_scene *scene)
{
	STILB_ASSERT(scene);
	return &scene->info;
}
