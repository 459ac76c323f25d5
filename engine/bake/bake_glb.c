#include "bake/bake_glb.h"

#include "base/base_file.h"
#include "base/base_json.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GLB_FLOAT = 5126, GLB_INDEX = 5125 }; /* component types of glTF */

/* A vertex of the file: position, normal, two uv. */
typedef struct glb_vertex {
	float position[3], normal[3], uv[2], atlas[2];
} glb_vertex;

/* One part of one page; a part with charts on several pages is several. */
typedef struct glb_piece {
	uint32_t part, page;
	uint32_t vertex_count, index_count;
	uint64_t vertex_offset, index_offset; /* bytes in the buffer */
	float low[3], high[3];
} glb_piece;

typedef struct glb_write {
	const stilb_scene *scene;
	const stilb_bake_atlas *atlas;
	const stilb_bake_glb_files *files;
	glb_piece *pieces;
	uint32_t piece_count, piece_room;
	/* Of the part that is being cut into pieces. */
	glb_vertex *vertices; /* room for 3 for each triangle */
	uint32_t *indices;
	uint32_t *first, *next; /* vertices of the file made of a mesh's vertex: a list from first[vertex] on */
	uint32_t room;          /* triangles that these have room for */
	uint32_t vertex_room;
} glb_write;

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

/* Makes room for a mesh. False: no memory. */
static bool write_room(glb_write *w, uint32_t triangles, uint32_t vertices)
{
	if (triangles > w->room) {
		free(w->vertices);
		free(w->indices);
		free(w->next);
		w->vertices = stilb_memory_alloc(3 * (size_t)triangles, sizeof *w->vertices);
		w->indices = stilb_memory_alloc(3 * (size_t)triangles, sizeof *w->indices);
		w->next = stilb_memory_alloc(3 * (size_t)triangles, sizeof *w->next);
		w->room = triangles;
	}
	if (vertices > w->vertex_room) {
		free(w->first);
		w->first = stilb_memory_alloc(vertices, sizeof *w->first);
		w->vertex_room = vertices;
	}
	return w->vertices && w->indices && w->next && w->first;
}

/* The vertex of the file for a mesh's vertex at this place of the page. */
static uint32_t vertex_at(glb_write *w, glb_piece *piece, const stilb_scene_mesh *mesh, uint32_t vertex,
                          const float corner[2])
{
	float side = (float)w->atlas->side, atlas[2] = {corner[0] / side, corner[1] / side};
	for (uint32_t i = w->first[vertex]; i != UINT32_MAX; i = w->next[i])
		if (w->vertices[i].atlas[0] == atlas[0] && w->vertices[i].atlas[1] == atlas[1])
			return i;
	const stilb_scene_vertex *from = &mesh->vertices[vertex];
	uint32_t made = piece->vertex_count++;
	glb_vertex *to = &w->vertices[made];
	memcpy(to->position, from->position, sizeof to->position);
	memcpy(to->normal, from->normal, sizeof to->normal);
	memcpy(to->uv, from->uv, sizeof to->uv);
	memcpy(to->atlas, atlas, sizeof to->atlas);
	for (int k = 0; k < 3; k++) {
		piece->low[k] = fminf(piece->low[k], from->position[k]);
		piece->high[k] = fmaxf(piece->high[k], from->position[k]);
	}
	w->next[made] = w->first[vertex];
	w->first[vertex] = made;
	return made;
}

/* Fills w's vertices and indices with the part's triangles on the page. */
static glb_piece piece_make(glb_write *w, uint32_t part, uint32_t page)
{
	const stilb_scene_mesh *mesh = &w->scene->meshes[w->scene->part_mesh[part]];
	glb_piece piece = {.part = part, .page = page};
	for (int k = 0; k < 3; k++) {
		piece.low[k] = FLT_MAX;
		piece.high[k] = -FLT_MAX;
	}
	memset(w->first, 0xff, mesh->vertex_count * sizeof *w->first);
	for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
		float corners[3][2];
		uint32_t on;
		if (!stilb_bake_atlas_corners(w->atlas, part, t, &on, corners) || on != page)
			continue;
		for (uint32_t i = 0; i < 3; i++)
			w->indices[piece.index_count++] = vertex_at(w, &piece, mesh, mesh->indices[3 * (size_t)t + i], corners[i]);
	}
	return piece;
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static void put_floats(stilb_json *json, const char *key, const float *values, uint32_t count)
{
	stilb_json_begin(json, key, '[');
	for (uint32_t i = 0; i < count; i++)
		stilb_json_float(json, NULL, values[i]);
	stilb_json_end(json, ']');
}

static void put_view(stilb_json *json, uint64_t offset, uint64_t size, uint32_t stride, uint32_t target)
{
	stilb_json_begin(json, NULL, '{');
	stilb_json_int(json, "buffer", 0);
	stilb_json_int(json, "byteOffset", (int64_t)offset);
	stilb_json_int(json, "byteLength", (int64_t)size);
	if (stride > 0)
		stilb_json_int(json, "byteStride", stride);
	stilb_json_int(json, "target", target);
	stilb_json_end(json, '}');
}

static void put_accessor(stilb_json *json, uint32_t view, size_t offset, int type, uint32_t count, const char *kind,
                         const glb_piece *bounds)
{
	stilb_json_begin(json, NULL, '{');
	stilb_json_int(json, "bufferView", view);
	stilb_json_int(json, "byteOffset", (int64_t)offset);
	stilb_json_int(json, "componentType", type);
	stilb_json_int(json, "count", count);
	stilb_json_string(json, "type", kind);
	if (bounds) {
		put_floats(json, "min", bounds->low, 3);
		put_floats(json, "max", bounds->high, 3);
	}
	stilb_json_end(json, '}');
}

static void put_meshes(stilb_json *json, const glb_write *w)
{
	stilb_json_begin(json, "accessors", '[');
	for (uint32_t i = 0; i < w->piece_count; i++) {
		const glb_piece *p = &w->pieces[i];
		uint32_t n = p->vertex_count;
		put_accessor(json, 2 * i, offsetof(glb_vertex, position), GLB_FLOAT, n, "VEC3", p);
		put_accessor(json, 2 * i, offsetof(glb_vertex, normal), GLB_FLOAT, n, "VEC3", NULL);
		put_accessor(json, 2 * i, offsetof(glb_vertex, uv), GLB_FLOAT, n, "VEC2", NULL);
		put_accessor(json, 2 * i, offsetof(glb_vertex, atlas), GLB_FLOAT, n, "VEC2", NULL);
		put_accessor(json, 2 * i + 1, 0, GLB_INDEX, p->index_count, "SCALAR", NULL);
	}
	stilb_json_end(json, ']');
	stilb_json_begin(json, "meshes", '[');
	for (uint32_t i = 0; i < w->piece_count; i++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_begin(json, "primitives", '[');
		stilb_json_begin(json, NULL, '{');
		stilb_json_begin(json, "attributes", '{');
		stilb_json_int(json, "POSITION", 5 * (int64_t)i);
		stilb_json_int(json, "NORMAL", 5 * (int64_t)i + 1);
		stilb_json_int(json, "TEXCOORD_0", 5 * (int64_t)i + 2);
		stilb_json_int(json, "TEXCOORD_1", 5 * (int64_t)i + 3);
		stilb_json_end(json, '}');
		stilb_json_int(json, "indices", 5 * (int64_t)i + 4);
		stilb_json_int(json, "material", i);
		stilb_json_end(json, '}');
		stilb_json_end(json, ']');
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static void put_views(stilb_json *json, const glb_write *w)
{
	stilb_json_begin(json, "bufferViews", '[');
	for (uint32_t i = 0; i < w->piece_count; i++) {
		const glb_piece *p = &w->pieces[i];
		put_view(json, p->vertex_offset, p->vertex_count * sizeof(glb_vertex), sizeof(glb_vertex), 34962);
		put_view(json, p->index_offset, p->index_count * sizeof(uint32_t), 0, 34963);
	}
	stilb_json_end(json, ']');
}

static void put_nodes(stilb_json *json, const glb_write *w)
{
	stilb_json_begin(json, "nodes", '[');
	for (uint32_t i = 0; i < w->piece_count; i++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "mesh", i);
		put_floats(json, "matrix", w->scene->part_transform[w->pieces[i].part].m, 16);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	stilb_json_begin(json, "scenes", '[');
	stilb_json_begin(json, NULL, '{');
	stilb_json_begin(json, "nodes", '[');
	for (uint32_t i = 0; i < w->piece_count; i++)
		stilb_json_int(json, NULL, i);
	stilb_json_end(json, ']');
	stilb_json_end(json, '}');
	stilb_json_end(json, ']');
	stilb_json_int(json, "scene", 0);
}

/* A file's name, with the page's number in place of %u. */
static void page_name(const char *pattern, uint32_t page, char *name, size_t size)
{
	const char *at = strstr(pattern, "%u");
	STILB_ASSERT(at);
	snprintf(name, size, "%.*s%u%s", (int)(at - pattern), pattern, page, at + 2);
}

static void put_material(stilb_json *json, const glb_write *w, const glb_piece *piece)
{
	uint32_t index = w->scene->part_material[piece->part];
	stilb_scene_material material = {.roughness = 1.0f};
	if (index < w->scene->material_count)
		material = w->scene->materials[index];
	float color[4] = {material.diffuse[0], material.diffuse[1], material.diffuse[2], 1.0f}, emission[3];
	for (int k = 0; k < 3; k++)
		emission[k] = fminf(material.emission[k], 1.0f);
	stilb_json_begin(json, NULL, '{');
	stilb_json_begin(json, "pbrMetallicRoughness", '{');
	put_floats(json, "baseColorFactor", color, 4);
	stilb_json_int(json, "metallicFactor", 0);
	stilb_json_float(json, "roughnessFactor", material.roughness);
	stilb_json_end(json, '}');
	put_floats(json, "emissiveFactor", emission, 3);
	stilb_json_bool(json, "doubleSided", w->scene->both_sides);
	if (w->files->occlusion) {
		stilb_json_begin(json, "occlusionTexture", '{');
		stilb_json_int(json, "index", piece->page);
		stilb_json_int(json, "texCoord", 1);
		stilb_json_end(json, '}');
	}
	if (w->files->lightmap) {
		char name[256];
		page_name(w->files->lightmap, piece->page, name, sizeof name);
		stilb_json_begin(json, "extras", '{');
		stilb_json_string(json, "lightmap", name);
		stilb_json_int(json, "lightmapTexCoord", 1);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, '}');
}

static void put_materials(stilb_json *json, const glb_write *w)
{
	stilb_json_begin(json, "materials", '[');
	for (uint32_t i = 0; i < w->piece_count; i++)
		put_material(json, w, &w->pieces[i]);
	stilb_json_end(json, ']');
	if (!w->files->occlusion || w->atlas->page_count == 0)
		return;
	stilb_json_begin(json, "textures", '[');
	for (uint32_t page = 0; page < w->atlas->page_count; page++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "source", page);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	stilb_json_begin(json, "images", '[');
	for (uint32_t page = 0; page < w->atlas->page_count; page++) {
		char name[256];
		page_name(w->files->occlusion, page, name, sizeof name);
		stilb_json_begin(json, NULL, '{');
		stilb_json_string(json, "uri", name);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static void put_document(stilb_json *json, const glb_write *w, uint64_t size)
{
	stilb_json_begin(json, NULL, '{');
	stilb_json_begin(json, "asset", '{');
	stilb_json_string(json, "version", "2.0");
	stilb_json_string(json, "generator", "Stilb " STILB_VERSION);
	stilb_json_end(json, '}');
	put_nodes(json, w);
	if (w->piece_count > 0) {
		put_meshes(json, w);
		put_materials(json, w);
		put_views(json, w);
		stilb_json_begin(json, "buffers", '[');
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "byteLength", (int64_t)size);
		stilb_json_end(json, '}');
		stilb_json_end(json, ']');
	}
	stilb_json_end(json, '}');
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

static bool piece_add(glb_write *w, const glb_piece *piece)
{
	if (w->piece_count == w->piece_room) {
		uint32_t room = 2 * w->piece_room + 16;
		glb_piece *more = realloc(w->pieces, room * sizeof *more);
		if (!more)
			return false;
		w->pieces = more;
		w->piece_room = room;
	}
	w->pieces[w->piece_count++] = *piece;
	return true;
}

/* Goes through all pieces: counts them if body is NULL, else writes their vertices and indices. */
static stilb_result write_pieces(glb_write *w, stilb_file *body, uint64_t *size)
{
	uint32_t count = 0;
	*size = 0;
	for (uint32_t part = 0; part < w->atlas->part_count; part++) {
		uint32_t uv = w->atlas->parts[part].uv;
		if (uv == STILB_BAKE_NO_CHART)
			continue;
		const stilb_scene_mesh *mesh = &w->scene->meshes[w->scene->part_mesh[part]];
		if (!write_room(w, mesh->index_count / 3, mesh->vertex_count))
			return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a mesh of %u vertices", mesh->vertex_count);
		uint8_t pages[STILB_BAKE_MAX_PAGES / 8] = {0}; /* those that the part has charts on */
		for (uint32_t c = 0; c < w->atlas->uvs[uv].chart_count; c++) {
			uint32_t page = w->atlas->places[w->atlas->parts[part].first_place + c].page;
			pages[page / 8] |= (uint8_t)(1u << page % 8);
		}
		for (uint32_t page = 0; page < w->atlas->page_count; page++) {
			if (!(pages[page / 8] >> page % 8 & 1))
				continue;
			glb_piece piece = piece_make(w, part, page);
			if (piece.index_count == 0)
				continue;
			piece.vertex_offset = *size;
			piece.index_offset = *size + piece.vertex_count * sizeof(glb_vertex);
			*size = piece.index_offset + piece.index_count * sizeof(uint32_t);
			if (body) {
				stilb_file_write(body, w->vertices, piece.vertex_count * sizeof *w->vertices);
				stilb_file_write(body, w->indices, piece.index_count * sizeof *w->indices);
			} else if (!piece_add(w, &piece)) {
				return stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u parts", count);
			}
			count++;
		}
	}
	return STILB_OK;
}

static stilb_result write_file(glb_write *w, const stilb_json *json, uint64_t size, const char *path)
{
	static const char spaces[4] = "   ";
	size_t text = (json->length + 3) / 4 * 4;
	bool body = size > 0;
	uint32_t head[5] = {0x46546c67, 2, (uint32_t)(20 + text + (body ? 8 + size : 0)), (uint32_t)text, 0x4e4f534a};
	uint32_t second[2] = {(uint32_t)size, 0x004e4942};
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	stilb_file_write(&file, head, sizeof head);
	stilb_file_write(&file, json->text, json->length);
	stilb_file_write(&file, spaces, text - json->length);
	if (body) {
		stilb_file_write(&file, second, sizeof second);
		result = write_pieces(w, &file, &size);
	}
	if (result == STILB_OK)
		return stilb_file_commit(&file);
	stilb_file_finish(&file);
	return result;
}

stilb_result stilb_bake_glb_save(const stilb_scene *scene, const stilb_bake_atlas *atlas,
                                 const stilb_bake_glb_files *files, const char *path)
{
	glb_write w = {.scene = scene, .atlas = atlas, .files = files};
	stilb_json json = {0};
	uint64_t size;
	stilb_result result = write_pieces(&w, NULL, &size);
	if (result == STILB_OK)
		put_document(&json, &w, size);
	if (result == STILB_OK && json.failed)
		result = stilb_fail(STILB_ERROR_MEMORY, "out of memory for '%s'", path);
	if (result == STILB_OK && 28 + json.length + 4 + size > UINT32_MAX)
		result = stilb_fail(STILB_ERROR_FILE, "cannot write '%s': it would be larger than 4 GiB, which .glb cannot be",
		                    path);
	if (result == STILB_OK)
		result = write_file(&w, &json, size, path);
	stilb_json_finish(&json);
	free(w.pieces);
	free(w.vertices);
	free(w.indices);
	free(w.first);
	free(w.next);
	return result;
}
