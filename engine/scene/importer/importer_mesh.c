#include "scene/importer/importer_motion.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMPORTER_NO_MESH UINT32_MAX

static bool mesh_is_triangle(const struct aiMesh *mesh, const struct aiFace *face)
{
	if (face->mNumIndices != 3)
		return false; /* a point or a line; Assimp splits larger polygons into triangles */
	for (int i = 0; i < 3; i++)
		if (face->mIndices[i] >= mesh->mNumVertices || !importer_is_point(&mesh->mVertices[face->mIndices[i]]))
			return false;
	return true;
}

static uint32_t mesh_triangles(const struct aiMesh *mesh)
{
	uint32_t count = 0;
	for (uint32_t f = 0; mesh->mVertices && f < mesh->mNumFaces; f++)
		count += mesh_is_triangle(mesh, &mesh->mFaces[f]);
	return count;
}

/* The normal of the triangle of these vertices; +Y if its area is 0. */
static stilb_vec3 mesh_normal(const struct aiMesh *mesh, const uint32_t index[3])
{
	stilb_vec3 p[3];
	for (int i = 0; i < 3; i++)
		p[i] = importer_vector(&mesh->mVertices[index[i]]);
	stilb_vec3 normal = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
	float length = sqrtf(stilb_vec3_dot(normal, normal));
	return length > 0.0f && length < INFINITY ? normal * (1.0f / length) : stilb_vec3_make(0, 1, 0);
}

static float mesh_texture_coordinate(float value)
{
	return fabsf(value) < 1e6f ? value
	                           : 0.0f; /* 0 also for NaN; larger floats are too coarse for a place in a texture */
}

/* The normal is 0 if the file has none, or one that is not finite. */
static stilb_scene_vertex mesh_vertex(const struct aiMesh *mesh, uint32_t v)
{
	stilb_scene_vertex vertex = {.position = {mesh->mVertices[v].x, mesh->mVertices[v].y, mesh->mVertices[v].z}};
	if (mesh->mNormals) {
		stilb_vec3 normal = importer_vector(&mesh->mNormals[v]);
		float length = sqrtf(stilb_vec3_dot(normal, normal));
		for (int i = 0; length > 1e-18f && length < 1e18f && i < 3; i++)
			vertex.normal[i] = normal[i] / length;
	}
	if (mesh->mTextureCoords[0]) {
		vertex.uv[0] = mesh_texture_coordinate(mesh->mTextureCoords[0][v].x);
		vertex.uv[1] = mesh_texture_coordinate(mesh->mTextureCoords[0][v].y);
	}
	return vertex;
}

/* ---- normals of vertices that triangles share ------------------------------------------------------------------- */

#define MESH_CREASE 0.5f      /* the cosine of the angle from which on an edge is sharp */
#define MESH_MOST_AROUND 256u /* triangles around a vertex; of more, all make one normal: else it would take too long */

/* The triangles of a mesh of Assimp's, and which of them are around each vertex. */
typedef struct mesh_fans {
	const struct aiMesh *from;
	const struct aiFace **faces; /* [triangles] */
	stilb_vec3 *normals;         /* [triangles] unit */
	float *areas;                /* [triangles] */
	uint32_t *first;             /* [vertices + 1]: around[first[v]] .. around[first[v + 1] - 1] */
	uint32_t *around;            /* [3 * triangles] */
	uint32_t *made;              /* [3 * triangles] of each place in around: the vertex that was made for it */
	uint32_t *source;            /* [3 * triangles] of each vertex that was made: the file's */
} mesh_fans;

static void mesh_fans_finish(mesh_fans *fans)
{
	free(fans->faces);
	free(fans->normals);
	free(fans->areas);
	free(fans->first);
	free(fans->around);
	free(fans->made);
	free(fans->source);
}

/* False: no memory. */
static bool mesh_fans_make(const struct aiMesh *from, uint32_t triangles, mesh_fans *fans)
{
	size_t corners = 3 * (size_t)triangles, vertices = from->mNumVertices;
	*fans = (mesh_fans){.from = from,
	                    .faces = malloc(triangles * sizeof *fans->faces),
	                    .normals = aligned_alloc(16, triangles * sizeof *fans->normals),
	                    .areas = malloc(triangles * sizeof *fans->areas),
	                    .first = calloc(vertices + 2, sizeof *fans->first),
	                    .around = malloc(corners * sizeof *fans->around),
	                    .made = malloc(corners * sizeof *fans->made),
	                    .source = malloc(corners * sizeof *fans->source)};
	if (!fans->faces || !fans->normals || !fans->areas || !fans->first || !fans->around || !fans->made || !fans->source)
		return false;
	uint32_t used = 0;
	for (uint32_t f = 0; f < from->mNumFaces; f++) {
		if (!mesh_is_triangle(from, &from->mFaces[f]))
			continue;
		const uint32_t *corner = from->mFaces[f].mIndices;
		stilb_vec3 p[3];
		for (int i = 0; i < 3; i++) {
			p[i] = importer_vector(&from->mVertices[corner[i]]);
			fans->first[corner[i] + 2]++;
		}
		stilb_vec3 cross = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		float area = sqrtf(stilb_vec3_dot(cross, cross));
		fans->faces[used] = &from->mFaces[f];
		fans->normals[used] = mesh_normal(from, corner);
		fans->areas[used++] = area > 0.0f && area < INFINITY ? area : 0.0f;
	}
	for (size_t v = 2; v < vertices + 2; v++)
		fans->first[v] += fans->first[v - 1];
	for (uint32_t t = 0; t < used; t++)
		for (int i = 0; i < 3; i++)
			fans->around[fans->first[fans->faces[t]->mIndices[i] + 1]++] = t;
	return true;
}

/* The normal of triangle t at vertex v: the mean, by area, of those around v that meet it at less than the crease. */
static stilb_vec3 mesh_fans_normal(const mesh_fans *fans, uint32_t v, uint32_t t)
{
	stilb_vec3 sum = {0};
	uint32_t first = fans->first[v], end = fans->first[v + 1];
	bool all = end - first > MESH_MOST_AROUND;
	for (uint32_t a = first; a < end; a++) {
		uint32_t other = fans->around[a];
		if (all || stilb_vec3_dot(fans->normals[t], fans->normals[other]) > MESH_CREASE)
			sum += fans->normals[other] * fans->areas[other];
	}
	float length = sqrtf(stilb_vec3_dot(sum, sum));
	return length > 0.0f && length < INFINITY ? sum * (1.0f / length) : fans->normals[t];
}

/* The vertex of triangle t at vertex v of the file: one that was made for v with the same normal, or a new one. */
static uint32_t mesh_fans_vertex(const mesh_fans *fans, uint32_t v, uint32_t t, uint32_t place, stilb_scene_mesh *mesh)
{
	stilb_vec3 normal = mesh_fans_normal(fans, v, t);
	uint32_t first = fans->first[v], look = place - first > MESH_MOST_AROUND ? first + MESH_MOST_AROUND : place;
	for (uint32_t a = first; a < look; a++) {
		const float *n = mesh->vertices[fans->made[a]].normal;
		if (n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2] > 0.99999f)
			return fans->made[a];
	}
	stilb_scene_vertex *vertex = &mesh->vertices[mesh->vertex_count];
	*vertex = mesh_vertex(fans->from, v);
	for (int k = 0; k < 3; k++)
		vertex->normal[k] = normal[k];
	fans->source[mesh->vertex_count] = v;
	return mesh->vertex_count++;
}

/* Converts a mesh whose triangles share vertices, and which has no normals: edges are sharp from 60 degrees on.
 * triangles: of mesh_triangles, > 0. *source: for each vertex that of the file, of malloc. */
static stilb_result mesh_convert_shared(const struct aiMesh *from, uint32_t triangles, stilb_scene_mesh *mesh,
                                        uint32_t **source)
{
	mesh_fans fans;
	stilb_result result = scene_mesh_create(mesh, 3 * triangles, 3 * triangles);
	if (result == STILB_OK && !mesh_fans_make(from, triangles, &fans)) {
		mesh_fans_finish(&fans);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the normals of %u triangles", triangles);
	}
	if (result != STILB_OK)
		return result;
	mesh->vertex_count = 0;
	/* Around a vertex at a time, so that equal normals are found. Triangles' corners stand at their own place. */
	uint32_t *corner_of = mesh->indices;
	for (uint32_t v = 0; v < from->mNumVertices; v++)
		for (uint32_t a = fans.first[v]; a < fans.first[v + 1]; a++) {
			uint32_t t = fans.around[a], made = mesh_fans_vertex(&fans, v, t, a, mesh);
			fans.made[a] = made;
			for (uint32_t i = 0; i < 3; i++)
				if (fans.faces[t]->mIndices[i] == v)
					corner_of[3 * t + i] = made;
		}
	*source = fans.source;
	fans.source = NULL;
	mesh_fans_finish(&fans);
	return STILB_OK;
}

/* What the triangles of a mesh say of its sides. */
typedef struct mesh_sides {
	double agree;  /* how far normals and triangles face the same way, by area: from all, 1, to none, -1 */
	double volume; /* of what they enclose, > 0 if they face outwards; in cubes of the root of their area */
} mesh_sides;

static mesh_sides mesh_find_sides(const stilb_scene_mesh *mesh)
{
	stilb_vec3 middle = {0};
	double area = 0.0, agree = 0.0, volume = 0.0;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int k = 0; k < 3; k++)
			middle[k] += mesh->vertices[v].position[k] / (float)mesh->vertex_count;
	for (uint32_t i = 0; i < mesh->index_count; i += 3) {
		stilb_vec3 p[3], sum = {0};
		for (int c = 0; c < 3; c++) {
			const stilb_scene_vertex *vertex = &mesh->vertices[mesh->indices[i + (uint32_t)c]];
			p[c] = stilb_vec3_make(vertex->position[0], vertex->position[1], vertex->position[2]) - middle;
			sum += stilb_vec3_make(vertex->normal[0], vertex->normal[1], vertex->normal[2]);
		}
		stilb_vec3 cross = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		double length = (double)sqrtf(stilb_vec3_dot(cross, cross)), facing = (double)stilb_vec3_dot(cross, sum);
		area += length;
		agree += facing > 0.0 ? length : facing < 0.0 ? -length : 0.0;
		volume += (double)stilb_vec3_dot(cross, p[0]) / 6.0;
	}
	bool usable = area > 0.0 && area < 1e30;
	return usable ? (mesh_sides){agree / area, volume / pow(0.5 * area, 1.5)} : (mesh_sides){1.0, 0.0};
}

#define MESH_CLOSED 0.02 /* of mesh_sides.volume: of more, which way is out is clear; a sphere has 0.09 */

/* Makes triangles and normals face the same way where they say the opposite: some files, and some of Assimp's readers,
 * have one of the two wrong. Outwards is right, else what the normals say. True: the normals are turned around. */
static bool mesh_settle_sides(stilb_scene_mesh *mesh)
{
	mesh_sides sides = mesh_find_sides(mesh);
	if (!(sides.agree < -0.5))
		return false;
	bool triangles_are_right = sides.volume > MESH_CLOSED;
	for (uint32_t v = 0; triangles_are_right && v < mesh->vertex_count; v++)
		for (int k = 0; k < 3; k++)
			mesh->vertices[v].normal[k] *= -1.0f;
	for (uint32_t i = 0; !triangles_are_right && i < mesh->index_count; i += 3) {
		uint32_t second = mesh->indices[i + 1];
		mesh->indices[i + 1] = mesh->indices[i + 2];
		mesh->indices[i + 2] = second;
	}
	return triangles_are_right;
}

/* Vertices without a normal get that of the first of their triangles. triangles: of mesh_triangles, > 0. */
static stilb_result mesh_convert(const struct aiMesh *from, uint32_t triangles, stilb_scene_mesh *mesh)
{
	STILB_ASSERT(triangles > 0);
	stilb_result result = scene_mesh_create(mesh, from->mNumVertices, 3 * triangles);
	if (result != STILB_OK)
		return result;
	for (uint32_t v = 0; v < from->mNumVertices; v++)
		mesh->vertices[v] = mesh_vertex(from, v);
	uint32_t *index = mesh->indices;
	for (uint32_t f = 0; f < from->mNumFaces; f++) {
		if (!mesh_is_triangle(from, &from->mFaces[f]))
			continue;
		stilb_vec3 normal = mesh_normal(from, from->mFaces[f].mIndices);
		for (int i = 0; i < 3; i++) {
			float *own = mesh->vertices[ *index++ = from->mFaces[f].mIndices[i]].normal;
			for (int k = 0; own[0] == 0.0f && own[1] == 0.0f && own[2] == 0.0f && k < 3; k++)
				own[k] = normal[k];
		}
	}
	STILB_ASSERT(index == mesh->indices + mesh->index_count);
	return STILB_OK;
}

/* ---- colours and tangents ---------------------------------------------------------------------------------------- */

/* Colours of vertices are those of displays, sRGB, but for glTF 1.0. */
static void mesh_read_color(const importer *import, const struct aiColor4D *from, float out[4])
{
	const float values[4] = {from->r, from->g, from->b, from->a};
	for (int i = 0; i < 4; i++) {
		float value = importer_clamp(values[i], 0.0f, 1.0f);
		out[i] = i == 3 || import->gltf ? value : shade_srgb_to_linear(value);
	}
}

/* Adds what the mesh's material needs of vertices. *source: for each vertex that of the file; NULL: it is the same. It
 * is another array where vertices had to be split. */
static stilb_result mesh_add_extras(importer *import, const struct aiMesh *from, uint32_t **source,
                                    stilb_scene_mesh *mesh)
{
	uint32_t materials = import->from->mNumMaterials;
	uint32_t material = from->mMaterialIndex < materials ? from->mMaterialIndex : 0;
	bool colors = from->mColors[0];
	bool normals =
		materials > 0 && from->mTextureCoords[0] && importer_material_has_normals(import->from->mMaterials[material]);
	if (!colors && !normals)
		return STILB_OK;
	stilb_result result = scene_mesh_add_extras(mesh);
	for (uint32_t v = 0; result == STILB_OK && colors && v < mesh->vertex_count; v++)
		mesh_read_color(import, &from->mColors[0][*source ? (*source)[v] : v], mesh->extras[v].color);
	import->colored[material] |= colors;
	if (result != STILB_OK || !normals)
		return result;
	stilb_scene_map as_it_is = {.to_u = {1, 0, 0}, .to_v = {0, 1, 0}};
	uint32_t *split = NULL;
	result = importer_make_tangents(mesh, &as_it_is, &split);
	if (result != STILB_OK)
		return result;
	for (uint32_t v = 0; *source && v < mesh->vertex_count; v++)
		split[v] = (*source)[split[v]];
	free(*source);
	*source = split;
	return STILB_OK;
}

/* Converts mesh m of Assimp's, with triangles > 0 of mesh_triangles, into mesh `place` of the scene. */
static stilb_result mesh_add(importer *import, uint32_t m, uint32_t triangles, uint32_t place)
{
	const struct aiMesh *from = import->from->mMeshes[m];
	stilb_scene_mesh *mesh = &import->scene->meshes[place];
	uint32_t *source = NULL;
	stilb_result result =
		import->shares ? mesh_convert_shared(from, triangles, mesh, &source) : mesh_convert(from, triangles, mesh);
	bool flipped = result == STILB_OK && mesh_settle_sides(mesh);
	if (result == STILB_OK)
		result = mesh_add_extras(import, from, &source, mesh);
	if (result == STILB_OK)
		result = importer_read_deform(import, m, source, flipped, place, mesh);
	free(source);
	return result;
}

/* What the scene will have. The two arrays are indexed by the number of Assimp's mesh. */
typedef struct mesh_plan {
	uint32_t *place;                /* the mesh's index in the scene; IMPORTER_NO_MESH: it has no triangles */
	uint32_t *triangles;            /* its number of triangles */
	uint32_t meshes, models, parts; /* numbers in the scene */
} mesh_plan;

/* The scene's index of a node's mesh i; IMPORTER_NO_MESH: it does not exist or has no triangles. */
static uint32_t mesh_place(const mesh_plan *plan, const importer *import, const struct aiNode *node, uint32_t i)
{
	STILB_ASSERT(i < node->mNumMeshes);
	uint32_t mesh = node->mMeshes[i];
	return mesh < import->from->mNumMeshes ? plan->place[mesh] : IMPORTER_NO_MESH;
}

static stilb_result mesh_plan_make(const importer *import, mesh_plan *plan)
{
	uint32_t count = import->from->mNumMeshes;
	plan->place = malloc((count + 1) * sizeof *plan->place);
	plan->triangles = malloc((count + 1) * sizeof *plan->triangles);
	if (!plan->place || !plan->triangles)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its meshes");
	for (uint32_t m = 0; m < count; m++) {
		plan->triangles[m] = mesh_triangles(import->from->mMeshes[m]);
		plan->place[m] = plan->triangles[m] ? plan->meshes++ : IMPORTER_NO_MESH;
	}
	for (uint32_t n = 0; n < import->node_count; n++) {
		const struct aiNode *node = import->nodes[n].node;
		uint32_t own = 0;
		for (uint32_t i = 0; i < node->mNumMeshes; i++)
			own += mesh_place(plan, import, node, i) != IMPORTER_NO_MESH;
		plan->parts += own;
		plan->models += own > 0;
		if (plan->parts > STILB_SCENE_MAX_MODELS)
			return stilb_fail(STILB_ERROR_FILE, "it shows more than %u meshes", STILB_SCENE_MAX_MODELS);
	}
	if (plan->parts == 0)
		return stilb_fail(STILB_ERROR_FILE, "it has no triangles, and nothing else is shown");
	return STILB_OK;
}

/* Fills parts, models and bounds. */
static void mesh_add_parts(importer *import, const mesh_plan *plan)
{
	stilb_scene *scene = import->scene;
	uint32_t part = 0, model = 0;
	for (uint32_t n = 0; n < import->node_count; n++) {
		const struct aiNode *node = import->nodes[n].node;
		uint32_t first = part;
		for (uint32_t i = 0; i < node->mNumMeshes; i++) {
			uint32_t place = mesh_place(plan, import, node, i);
			if (place == IMPORTER_NO_MESH)
				continue;
			uint32_t material = import->from->mMeshes[node->mMeshes[i]]->mMaterialIndex;
			scene->part_mesh[part] = place;
			scene->part_material[part] = material < scene->material_count ? material : 0;
			scene->part_transform[part++] = import->nodes[n].to_world;
		}
		if (part == first)
			continue;
		if (scene->names.models)
			snprintf(scene->names.models[model], STILB_SCENE_NAME, "%.*s", STILB_SCENE_NAME - 1, node->mName.data);
		scene->model_node[model] = 1 + n;
		scene->first_part[++model] = part;
	}
	STILB_ASSERT(part == scene->part_count && model == scene->model_count);
	scene_fit_all_bounds(scene);
}

stilb_result importer_add_meshes(importer *import)
{
	STILB_ASSERT(!import->scene && import->node_count > 0);
	mesh_plan plan = {0};
	const struct aiScene *from = import->from;
	stilb_result result = mesh_plan_make(import, &plan);
	import->colored = calloc(from->mNumMaterials + 1ull, sizeof *import->colored);
	if (result == STILB_OK && !import->colored)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for its materials");
	uint32_t materials = from->mNumMaterials ? from->mNumMaterials : 1;
	if (result == STILB_OK)
		result = scene_create(plan.models, plan.parts, plan.meshes, materials, &import->scene);
	if (result == STILB_OK)
		result = scene_add_names(import->scene);
	if (result == STILB_OK)
		result = importer_plan_skins(import, plan.place, plan.meshes);
	for (uint32_t m = 0; result == STILB_OK && m < from->mNumMeshes; m++) {
		if (plan.place[m] != IMPORTER_NO_MESH)
			result = mesh_add(import, m, plan.triangles[m], plan.place[m]);
		importer_advance_meshes(import, m + 1, from->mNumMeshes);
	}
	if (result == STILB_OK)
		result = importer_add_nodes(import);
	if (result == STILB_OK)
		mesh_add_parts(import, &plan);
	free(plan.place);
	free(plan.triangles);
	return result;
}
