/* Converts primitives, the parts of a glTF mesh that have one material each, to meshes of triangles. */
#include "scene/edit/scene_check.h"
#include "scene/importer/gltf/gltf.h"
#include "scene/importer/gltf/gltf_draco.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The values of glTF's mode; 0 to 3 are points and lines. */
enum { PRIMITIVE_TRIANGLES = 4, PRIMITIVE_STRIP, PRIMITIVE_FAN };

enum {
	PRIMITIVE_POSITIONS,
	PRIMITIVE_NORMALS,
	PRIMITIVE_UVS,
	PRIMITIVE_SECOND_UVS,
	PRIMITIVE_TANGENTS,
	PRIMITIVE_COLORS,
	PRIMITIVE_ATTRIBUTES
};

/* A primitive while it is read. */
typedef struct primitive_reader {
	gltf *from;
	uint32_t item; /* its token */
	uint32_t mode;
	gltf_sets sets;
	char uvs[2][24]; /* the names of the attributes with the texture coordinates: TEXCOORD_0, ...; "": none */
	gltf_accessor attributes[PRIMITIVE_ATTRIBUTES]; /* {0}: the primitive has none */
	gltf_accessor indices;                          /* {0}: its vertices follow one another */
	gltf_accessor packed[2]; /* joints and weights that were compressed with the others; {0}: there are none */
	uint32_t *source;        /* [vertices of the mesh]: those of the file; corners or shared */
	uint32_t *shared;
	uint32_t *corners; /* [3 * triangles]: vertices in the file */
	uint32_t triangles;
	uint32_t low, high;    /* the range of vertices that corners names; low > high: there are none */
	bool leaves_triangles; /* some have vertices that do not exist */
	bool leaves_infinite;  /* some have coordinates that are NaN or infinite */
} primitive_reader;

/* The numbers that an attribute's elements must have. */
static const uint32_t primitive_components[PRIMITIVE_ATTRIBUTES] = {3, 3, 2, 2, 4, 4};

/* The name of an attribute; "": it is not needed. */
static const char *primitive_attribute(const primitive_reader *reader, int i)
{
	static const char *const names[PRIMITIVE_ATTRIBUTES] = {
		[PRIMITIVE_POSITIONS] = "POSITION", [PRIMITIVE_NORMALS] = "NORMAL", [PRIMITIVE_COLORS] = "COLOR_0"};
	if (i == PRIMITIVE_UVS || i == PRIMITIVE_SECOND_UVS)
		return reader->uvs[i - PRIMITIVE_UVS];
	if (i == PRIMITIVE_TANGENTS)
		return reader->sets.normals ? "TANGENT" : "";
	return names[i];
}

/* Colours may lack alpha. */
static uint32_t primitive_mask(int i)
{
	return 1u << (primitive_components[i] - 1) | (i == PRIMITIVE_COLORS ? 1u << 2 : 0u);
}

/* ---- what the file holds ----------------------------------------------------------------------------------------- */

/* Makes an accessor of numbers of malloc, which it owns from now on. */
static gltf_accessor primitive_own(void *data, uint64_t count, uint32_t components, uint32_t type)
{
	return (gltf_accessor){
		.data = data, .count = count, .stride = 4 * components, .components = components, .type = type, .own = data};
}

/* Decompresses indices and attributes. extension: the token of KHR_draco_mesh_compression. */
static stilb_result primitive_unpack(primitive_reader *reader, uint32_t extension)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	const gltf_view *view;
	uint32_t number = gltf_reference(from, extension, "bufferView", GLTF_VIEWS);
	uint32_t names = scene_json_member(json, extension, "attributes");
	gltf_draco_mesh mesh = {0};
	bool memory;
	if (number == GLTF_NONE && !json->fault[0])
		return stilb_fail(STILB_ERROR_FILE, "a mesh compressed by Draco names no buffer view");
	for (int i = 0; i < PRIMITIVE_ATTRIBUTES; i++) {
		const char *name = primitive_attribute(reader, i);
		uint64_t id = name[0] ? scene_json_size(json, names, name, UINT32_MAX) : UINT32_MAX;
		mesh.values[i] = (gltf_draco_values){.wanted = id < UINT32_MAX,
		                                     .id = (uint32_t)id,
		                                     .components = primitive_components[i],
		                                     .alpha = i == PRIMITIVE_COLORS};
	}
	for (int i = 0; i < 2 && from->lists[GLTF_SKINS].count > 0; i++) {
		uint64_t id = scene_json_size(json, names, i == 0 ? "JOINTS_0" : "WEIGHTS_0", UINT32_MAX);
		mesh.values[PRIMITIVE_ATTRIBUTES + i] =
			(gltf_draco_values){.wanted = id < UINT32_MAX, .id = (uint32_t)id, .components = 4};
	}
	stilb_result result = scene_json_check(json);
	if (result == STILB_OK)
		result = gltf_view_use(from, number, &view);
	if (result != STILB_OK)
		return result;
	const char *why = gltf_draco_decode(view->data, view->size, &mesh, &memory);
	if (why)
		return stilb_fail(memory ? STILB_ERROR_MEMORY : STILB_ERROR_FILE,
		                  "a mesh compressed by Draco, in buffer view %u: %s", number, why);
	reader->indices = primitive_own(mesh.indices, mesh.index_count, 1, 5125);
	for (int i = 0; i < PRIMITIVE_ATTRIBUTES; i++)
		if (mesh.values[i].data)
			reader->attributes[i] = primitive_own(mesh.values[i].data, mesh.point_count, primitive_components[i], 5126);
	for (int i = 0; i < 2; i++)
		if (mesh.values[PRIMITIVE_ATTRIBUTES + i].data)
			reader->packed[i] = primitive_own(mesh.values[PRIMITIVE_ATTRIBUTES + i].data, mesh.point_count, 4, 5126);
	reader->mode = PRIMITIVE_TRIANGLES;
	return STILB_OK;
}

/* Opens the accessors of indices and attributes. */
static stilb_result primitive_open(primitive_reader *reader)
{
	gltf *from = reader->from;
	scene_json *json = &from->json;
	uint32_t names = scene_json_member(json, reader->item, "attributes");
	uint32_t indices = gltf_reference(from, reader->item, "indices", GLTF_ACCESSORS);
	stilb_result result = STILB_OK;
	for (int i = 0; result == STILB_OK && i < PRIMITIVE_ATTRIBUTES; i++) {
		const char *name = primitive_attribute(reader, i);
		uint32_t number = name[0] ? gltf_reference(from, names, name, GLTF_ACCESSORS) : GLTF_NONE;
		if (number != GLTF_NONE)
			result = gltf_accessor_open(from, number, primitive_mask(i), &reader->attributes[i]);
		if (result == STILB_OK && number != GLTF_NONE &&
		    reader->attributes[i].count < reader->attributes[PRIMITIVE_POSITIONS].count)
			result = stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu elements for %llu vertices", number,
			                    (unsigned long long)reader->attributes[i].count,
			                    (unsigned long long)reader->attributes[PRIMITIVE_POSITIONS].count);
	}
	if (result == STILB_OK && indices != GLTF_NONE)
		result = gltf_accessor_open(from, indices, 1, &reader->indices);
	return result == STILB_OK ? scene_json_check(json) : result;
}

static void primitive_finish(primitive_reader *reader)
{
	for (int i = 0; i < PRIMITIVE_ATTRIBUTES; i++)
		gltf_accessor_finish(&reader->attributes[i]);
	gltf_accessor_finish(&reader->indices);
	for (int i = 0; i < 2; i++)
		gltf_accessor_finish(&reader->packed[i]);
	free(reader->corners);
	free(reader->shared);
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

/* Where corner k of triangle t stands in the list of the primitive's vertices. glTF 2.0, 3.7.2.1. */
static uint64_t primitive_corner(uint32_t mode, uint64_t t, uint32_t k)
{
	if (mode == PRIMITIVE_STRIP)
		return t + (k == 0 ? 0 : k == 1 ? 1 + t % 2 : 2 - t % 2);
	if (mode == PRIMITIVE_FAN)
		return k == 2 ? 0 : t + 1 + k;
	return 3 * t + k;
}

static bool primitive_is_finite(const primitive_reader *reader, uint64_t v)
{
	float p[3];
	gltf_accessor_read(&reader->attributes[PRIMITIVE_POSITIONS], v, p);
	return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static bool primitive_all_are_finite(const primitive_reader *reader)
{
	const gltf_accessor *positions = &reader->attributes[PRIMITIVE_POSITIONS];
	bool finite = true;
	for (uint64_t v = 0; v < positions->count && finite; v++)
		finite = primitive_is_finite(reader, v);
	return finite;
}

/* Lists the corners of the triangles, without those whose vertices do not exist or lie nowhere, and those of strips and
 * fans that have a vertex twice: these turn a strip's corner. */
static stilb_result primitive_list_corners(primitive_reader *reader)
{
	bool indexed = reader->indices.components > 0, list = reader->mode == PRIMITIVE_TRIANGLES;
	uint64_t vertices = reader->attributes[PRIMITIVE_POSITIONS].count,
			 count = indexed ? reader->indices.count : vertices;
	uint64_t triangles = list ? count / 3 : count > 2 ? count - 2 : 0;
	uint32_t kept = 0;
	bool finite = primitive_all_are_finite(reader);
	reader->low = UINT32_MAX;
	reader->corners = malloc((3 * triangles + 1) * sizeof *reader->corners);
	if (!reader->corners)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %llu triangles", (unsigned long long)triangles);
	for (uint64_t t = 0; t < triangles; t++) {
		uint32_t *corner = reader->corners + 3ull * kept, most = 0, least = UINT32_MAX;
		for (uint32_t k = 0; k < 3; k++) {
			uint64_t place = primitive_corner(reader->mode, t, k);
			corner[k] = indexed ? gltf_accessor_index(&reader->indices, place) : (uint32_t)place;
			most = corner[k] > most ? corner[k] : most;
			least = corner[k] < least ? corner[k] : least;
		}
		bool flat = !list && (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]);
		reader->leaves_triangles |= most >= vertices;
		if (flat || most >= vertices)
			continue;
		bool lies = finite || (primitive_is_finite(reader, corner[0]) && primitive_is_finite(reader, corner[1]) &&
		                       primitive_is_finite(reader, corner[2]));
		reader->leaves_infinite |= !lies;
		if (!lies)
			continue;
		reader->high = most > reader->high ? most : reader->high;
		reader->low = least < reader->low ? least : reader->low;
		kept++;
	}
	reader->triangles = kept;
	return STILB_OK;
}

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

/* 0 also for NaN; larger numbers are too coarse for a place in a texture. */
static float primitive_uv(float value)
{
	return fabsf(value) < 1e6f ? value : 0.0f;
}

static void primitive_read_uv(const gltf_accessor *uvs, uint32_t v, float out[2])
{
	float uv[2];
	gltf_accessor_read(uvs, v, uv);
	out[0] = primitive_uv(uv[0]);
	out[1] = primitive_uv(uv[1]);
}

/* Vertex v of the file. The normal is 0 if the file has none, or one that has no length. */
static stilb_scene_vertex primitive_vertex(const primitive_reader *reader, uint32_t v)
{
	const gltf_accessor *normals = &reader->attributes[PRIMITIVE_NORMALS], *uvs = &reader->attributes[PRIMITIVE_UVS];
	stilb_scene_vertex vertex = {0};
	gltf_accessor_read(&reader->attributes[PRIMITIVE_POSITIONS], v, vertex.position);
	if (normals->components) {
		float n[3];
		gltf_accessor_read(normals, v, n);
		float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		for (int i = 0; length > 1e-18f && length < 1e18f && i < 3; i++)
			vertex.normal[i] = n[i] / length;
	}
	if (uvs->components)
		primitive_read_uv(uvs, v, vertex.uv);
	return vertex;
}

/* A tangent of the file, made unit; none if it has no direction. */
static void primitive_read_tangent(const gltf_accessor *tangents, uint32_t v, float out[4])
{
	float t[4];
	gltf_accessor_read(tangents, v, t);
	float length = sqrtf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
	if (!(length > 1e-18f && length < 1e18f))
		return;
	for (int i = 0; i < 3; i++)
		out[i] = t[i] / length;
	out[3] = t[3] < 0.0f ? -1.0f : 1.0f;
}

static stilb_scene_vertex_extra primitive_extra(const primitive_reader *reader, uint32_t v)
{
	stilb_scene_vertex_extra extra = {.color = {1, 1, 1, 1}};
	const gltf_accessor *attributes = reader->attributes, *colors = &attributes[PRIMITIVE_COLORS];
	if (attributes[PRIMITIVE_TANGENTS].components)
		primitive_read_tangent(&attributes[PRIMITIVE_TANGENTS], v, extra.tangent);
	if (attributes[PRIMITIVE_SECOND_UVS].components)
		primitive_read_uv(&attributes[PRIMITIVE_SECOND_UVS], v, extra.uv);
	if (colors->components) {
		gltf_accessor_read(colors, v, extra.color);
		for (int i = 0; i < 4; i++)
			extra.color[i] = importer_clamp(extra.color[i], 0.0f, SCENE_BRIGHTEST_COLOR);
	}
	return extra;
}

/* Fills in the mesh's extras, if it needs some. */
static stilb_result primitive_add_extras(const primitive_reader *reader, stilb_scene_mesh *mesh)
{
	if (!reader->sets.normals && !reader->attributes[PRIMITIVE_SECOND_UVS].components &&
	    !reader->attributes[PRIMITIVE_COLORS].components)
		return STILB_OK;
	stilb_result result = scene_mesh_add_extras(mesh);
	for (uint32_t v = 0; result == STILB_OK && v < mesh->vertex_count; v++)
		mesh->extras[v] = primitive_extra(reader, reader->source[v]);
	return result;
}

/* Vertices without a normal get that of their triangle; +Y if its area is 0. */
static void primitive_complete_normals(stilb_scene_mesh *mesh)
{
	for (uint32_t i = 0; i < mesh->index_count; i += 3) {
		stilb_scene_vertex *corner[3];
		bool missing = false;
		for (int k = 0; k < 3; k++) {
			corner[k] = &mesh->vertices[mesh->indices[i + (uint32_t)k]];
			const float *n = corner[k]->normal;
			missing |= n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f;
		}
		if (!missing)
			continue;
		stilb_vec3 p[3];
		for (int k = 0; k < 3; k++)
			p[k] = stilb_vec3_make(corner[k]->position[0], corner[k]->position[1], corner[k]->position[2]);
		stilb_vec3 normal = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		float length = sqrtf(stilb_vec3_dot(normal, normal));
		normal = length > 0.0f && length < INFINITY ? normal * (1.0f / length) : stilb_vec3_make(0, 1, 0);
		for (int k = 0; k < 3; k++) {
			float *n = corner[k]->normal;
			for (int c = 0; n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f && c < 3; c++)
				n[c] = normal[c];
		}
	}
}

/* A mesh in which each triangle has vertices of its own, as flat shading needs. */
static stilb_result primitive_split(primitive_reader *reader, stilb_scene_mesh *mesh)
{
	uint32_t count = 3 * reader->triangles;
	stilb_result result = scene_mesh_create(mesh, count, count);
	for (uint32_t i = 0; result == STILB_OK && i < count; i++) {
		mesh->vertices[i] = primitive_vertex(reader, reader->corners[i]);
		mesh->indices[i] = i;
	}
	reader->source = reader->corners;
	return result;
}

/* A mesh of the vertices that triangles use, in the order of the file. */
static stilb_result primitive_share(primitive_reader *reader, stilb_scene_mesh *mesh)
{
	uint32_t range = reader->high - reader->low + 1, count = 3 * reader->triangles, used = 0;
	uint32_t *place = calloc(range, sizeof *place); /* 1: it is used; then its place in the mesh */
	if (!place)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u vertices", range);
	for (uint32_t i = 0; i < count; i++)
		place[reader->corners[i] - reader->low] = 1;
	for (uint32_t v = 0; v < range; v++)
		used += place[v];
	stilb_result result = scene_mesh_create(mesh, used, count);
	reader->source = reader->shared = malloc((used + 1ull) * sizeof *reader->shared);
	if (result == STILB_OK && !reader->shared)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for %u vertices", range);
	used = 0;
	for (uint32_t v = 0; result == STILB_OK && v < range; v++)
		if (place[v]) {
			mesh->vertices[used] = primitive_vertex(reader, reader->low + v);
			reader->shared[used] = reader->low + v;
			place[v] = used++;
		}
	for (uint32_t i = 0; result == STILB_OK && i < count; i++)
		mesh->indices[i] = place[reader->corners[i] - reader->low];
	free(place);
	return result;
}

/* Makes tangents where the file has none for what needs them. glTF 2.0, 3.7.2.1: by MikkTSpace. */
static stilb_result primitive_make_tangents(primitive_reader *reader, stilb_scene_mesh *mesh)
{
	uint32_t *sources = NULL;
	stilb_result result = importer_make_tangents(mesh, &reader->sets.normal, &sources);
	if (result != STILB_OK)
		return result;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		sources[v] = reader->source[sources[v]];
	free(reader->shared);
	reader->source = reader->shared = sources;
	return STILB_OK;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static stilb_result primitive_convert(primitive_reader *reader, stilb_scene_mesh *mesh)
{
	uint32_t draco = gltf_extension(reader->from, reader->item, "KHR_draco_mesh_compression");
	stilb_result result = draco == GLTF_NONE ? primitive_open(reader) : primitive_unpack(reader, draco);
	if (result == STILB_OK)
		result = primitive_list_corners(reader);
	if (result != STILB_OK || reader->triangles == 0)
		return result;
	if (reader->triangles > UINT32_MAX / 3)
		return stilb_fail(STILB_ERROR_FILE, "one of its meshes has %u triangles", reader->triangles);
	/* glTF 2.0, 3.7.2.1: without normals, flat ones. */
	bool flat = reader->attributes[PRIMITIVE_NORMALS].components == 0;
	result = flat ? primitive_split(reader, mesh) : primitive_share(reader, mesh);
	if (result == STILB_OK)
		primitive_complete_normals(mesh);
	if (result == STILB_OK)
		result = primitive_add_extras(reader, mesh);
	bool tangents = reader->attributes[PRIMITIVE_TANGENTS].components > 0 && !flat;
	bool places = reader->sets.any || reader->attributes[PRIMITIVE_UVS].components > 0;
	if (result == STILB_OK && reader->sets.normals && places && !tangents)
		result = primitive_make_tangents(reader, mesh);
	return result;
}

stilb_result gltf_primitive_convert(gltf *from, uint32_t mesh, uint32_t primitive, gltf_part *part)
{
	scene_json *json = &from->json;
	importer *import = from->import;
	char name[96];
	uint32_t material = gltf_reference(from, primitive, "material", GLTF_MATERIALS);
	uint32_t names = scene_json_member(json, primitive, "attributes");
	uint64_t mode = scene_json_size(json, primitive, "mode", PRIMITIVE_TRIANGLES);
	primitive_reader reader = {.from = from, .item = primitive, .mode = (uint32_t)mode};
	gltf_name(from, GLTF_MESHES, mesh, name);
	reader.sets = gltf_variant_sets(from, primitive, material, name);
	snprintf(reader.uvs[0], sizeof *reader.uvs, "TEXCOORD_%u", reader.sets.set[0]);
	if (reader.sets.second)
		snprintf(reader.uvs[1], sizeof *reader.uvs, "TEXCOORD_%u", reader.sets.set[1]);
	*part = (gltf_part){.item = primitive,
	                    .material = material == GLTF_NONE ? from->lists[GLTF_MATERIALS].count : material};
	if (mode > PRIMITIVE_FAN)
		scene_json_blame(json, primitive, "'mode' is %llu; 6 is the most", (unsigned long long)mode);
	stilb_result result = scene_json_check(json);
	if (result != STILB_OK)
		return result;
	bool positions = scene_json_member(json, names, "POSITION") != GLTF_NONE;
	if (mode < PRIMITIVE_TRIANGLES || !positions) {
		importer_lose(import, positions ? IMPORTER_LOSS_LINES : IMPORTER_LOSS_POSITIONS, name);
		return STILB_OK;
	}
	result = primitive_convert(&reader, &part->mesh);
	if (result == STILB_OK && part->mesh.index_count > 0)
		result = gltf_deform_read(from, reader.source, reader.packed, name, part);
	if (reader.leaves_triangles)
		importer_lose(import, IMPORTER_LOSS_TRIANGLES, name);
	if (reader.leaves_infinite)
		importer_lose(import, IMPORTER_LOSS_INFINITE, name);
	if (part->mesh.index_count > 0 && scene_json_member(json, names, "COLOR_0") != GLTF_NONE)
		gltf_show_materials(from, primitive, part->material, GLTF_SHOWN_COLORED);
	primitive_finish(&reader);
	if (result != STILB_OK)
		stilb_scene_mesh_finish(&part->mesh);
	if (result == STILB_OK && part->mesh.index_count > 0)
		from->needs_default_material |= material == GLTF_NONE;
	return result;
}
