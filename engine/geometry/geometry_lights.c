/* Cuts meshes at the bounds of lights: see geometry_lights.h. */
#include "geometry/geometry_lights.h"

#include "base/base_contract.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LIGHTS_NONE UINT32_MAX

/* A part of the mesh that may be cut further. */
typedef struct lights_piece {
	uint32_t *indices; /* [index_count] */
	uint32_t *lights;  /* [light_count] that may reach it */
	uint32_t index_count, light_count;
} lights_piece;

/* Where an edge is cut, by its ends. */
typedef struct lights_edge {
	uint32_t low, high; /* low < high; low LIGHTS_NONE: the entry is free */
	uint32_t vertex;
} lights_edge;

/* A mesh that is being cut. */
typedef struct lights_cut {
	const stilb_geometry_lights_desc *desc;
	stilb_scene_vertex *vertices;     /* [vertex_count] the mesh's, then those of cuts */
	stilb_scene_vertex_extra *extras; /* likewise; NULL: there are none */
	uint32_t vertex_count, vertex_capacity;
	uint32_t *places; /* [place_capacity] scratch memory of lights_emit, by vertex */
	uint32_t place_capacity;
	lights_edge *edges; /* [edge_capacity] of one plane; a power of 2 */
	uint32_t edge_capacity;
	lights_piece *open; /* [open_count] */
	uint32_t open_count, open_capacity;
	stilb_geometry_pieces *pieces;
	uint32_t piece_capacity;
} lights_cut;

typedef struct lights_box {
	float low[3], high[3];
} lights_box;

typedef struct lights_plane {
	uint32_t axis; /* LIGHTS_NONE: no plane */
	float at;
} lights_plane;

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* Makes *array hold `count` elements of `size` bytes; contents are kept. False: no memory. */
static bool lights_reserve(void **array, uint32_t *capacity, uint64_t count, size_t size)
{
	if (count <= *capacity)
		return true;
	uint64_t larger = count + count / 2 + 16;
	void *grown = larger <= UINT32_MAX ? realloc(*array, larger * size) : NULL;
	if (!grown)
		return false;
	*array = grown;
	*capacity = (uint32_t)larger;
	return true;
}

static bool lights_reserve_vertices(lights_cut *cut, uint64_t count)
{
	uint32_t capacity = cut->vertex_capacity;
	if (cut->extras && !lights_reserve((void **)&cut->extras, &capacity, count, sizeof *cut->extras))
		return false;
	return lights_reserve((void **)&cut->vertices, &cut->vertex_capacity, count, sizeof *cut->vertices);
}

static void lights_piece_finish(lights_piece *piece)
{
	free(piece->indices);
	free(piece->lights);
	*piece = (lights_piece){0};
}

/* Takes over the piece, or frees it. False: no memory. */
static bool lights_push(lights_cut *cut, lights_piece *piece)
{
	bool room = lights_reserve((void **)&cut->open, &cut->open_capacity, cut->open_count + 1, sizeof *cut->open);
	if (room)
		cut->open[cut->open_count++] = *piece;
	else
		lights_piece_finish(piece);
	return room;
}

static void lights_cut_finish(lights_cut *cut)
{
	for (uint32_t i = 0; i < cut->open_count; i++)
		lights_piece_finish(&cut->open[i]);
	free(cut->open);
	free(cut->vertices);
	free(cut->extras);
	free(cut->places);
	free(cut->edges);
}

/* ---- where to cut ------------------------------------------------------------------------------------------------ */

static lights_box lights_box_of(const lights_cut *cut, const lights_piece *piece)
{
	lights_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	for (uint32_t i = 0; i < piece->index_count; i++)
		for (int k = 0; k < 3; k++) {
			float p = cut->vertices[piece->indices[i]].position[k];
			box.low[k] = fminf(box.low[k], p);
			box.high[k] = fmaxf(box.high[k], p);
		}
	return box;
}

static bool lights_reaches(const stilb_sphere *sphere, const lights_box *box)
{
	const float center[3] = {sphere->x, sphere->y, sphere->z};
	float square = 0.0f;
	for (int k = 0; k < 3; k++) {
		float off = center[k] - fminf(fmaxf(center[k], box->low[k]), box->high[k]);
		square += off * off;
	}
	return sphere->radius >= 0.0f && square < sphere->radius * sphere->radius;
}

static uint32_t lights_count(const lights_cut *cut, const lights_piece *piece, const lights_box *box)
{
	uint32_t count = 0;
	for (uint32_t l = 0; l < piece->light_count; l++)
		count += lights_reaches(&cut->desc->lights[piece->lights[l]], box);
	return count;
}

/* Leaves of the piece's lights those that reach it. */
static void lights_keep(const lights_cut *cut, lights_piece *piece, const lights_box *box)
{
	uint32_t kept = 0;
	for (uint32_t l = 0; l < piece->light_count; l++)
		if (lights_reaches(&cut->desc->lights[piece->lights[l]], box))
			piece->lights[kept++] = piece->lights[l];
	piece->light_count = kept;
}

/* The lights that reach the halves, each by its share of the length. */
static double lights_cost(const lights_cut *cut, const lights_piece *piece, const lights_box *box, lights_plane plane)
{
	lights_box low = *box, high = *box;
	low.high[plane.axis] = high.low[plane.axis] = plane.at;
	float length = box->high[plane.axis] - box->low[plane.axis];
	double share = (double)((plane.at - box->low[plane.axis]) / length);
	return share * lights_count(cut, piece, &low) + (1.0 - share) * lights_count(cut, piece, &high);
}

/* The plane that leaves the fewest lights; the first one of those that do. */
static lights_plane lights_choose(const lights_cut *cut, const lights_piece *piece, const lights_box *box)
{
	lights_plane best = {.axis = LIGHTS_NONE};
	double least = (double)piece->light_count;
	for (uint32_t l = 0; l < piece->light_count; l++) {
		const stilb_sphere *sphere = &cut->desc->lights[piece->lights[l]];
		const float center[3] = {sphere->x, sphere->y, sphere->z};
		for (uint32_t side = 0; side < 6; side++) {
			uint32_t axis = side / 2;
			lights_plane plane = {axis, center[axis] + (side % 2 ? sphere->radius : -sphere->radius)};
			if (!(plane.at >= box->low[axis] + cut->desc->least && plane.at <= box->high[axis] - cut->desc->least))
				continue;
			double cost = lights_cost(cut, piece, box, plane);
			if (cost < least) {
				least = cost;
				best = plane;
			}
		}
	}
	return best;
}

/* ---- cutting ----------------------------------------------------------------------------------------------------- */

static void lights_unit(float v[3])
{
	float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
	for (int k = 0; k < 3 && length > 0.0f; k++)
		v[k] /= length;
}

static void lights_mix(const float *a, const float *b, float share, float *out, int count)
{
	for (int k = 0; k < count; k++)
		out[k] = a[k] + (b[k] - a[k]) * share;
}

/* Adds the vertex between two others, the share of the way from a to b. There is room. */
static uint32_t lights_add_vertex(lights_cut *cut, uint32_t a, uint32_t b, lights_plane plane)
{
	const stilb_scene_vertex *from = &cut->vertices[a], *to = &cut->vertices[b];
	uint32_t index = cut->vertex_count++;
	stilb_scene_vertex *out = &cut->vertices[index];
	float start = from->position[plane.axis], share = (plane.at - start) / (to->position[plane.axis] - start);
	lights_mix(from->position, to->position, share, out->position, 3);
	lights_mix(from->normal, to->normal, share, out->normal, 3);
	lights_mix(from->uv, to->uv, share, out->uv, 2);
	out->position[plane.axis] = plane.at;
	lights_unit(out->normal);
	if (!cut->extras)
		return index;
	const stilb_scene_vertex_extra *first = &cut->extras[a], *second = &cut->extras[b];
	stilb_scene_vertex_extra *extra = &cut->extras[index];
	lights_mix(first->tangent, second->tangent, share, extra->tangent, 3);
	lights_unit(extra->tangent);
	extra->tangent[3] = first->tangent[3];
	lights_mix(first->uv, second->uv, share, extra->uv, 2);
	lights_mix(first->color, second->color, share, extra->color, 4);
	return index;
}

/* The vertex where the plane cuts an edge; both triangles of the edge get the same. */
static uint32_t lights_edge_vertex(lights_cut *cut, uint32_t a, uint32_t b, lights_plane plane)
{
	uint32_t low = a < b ? a : b, high = a < b ? b : a;
	uint32_t at = (low * 0x9e3779b1u ^ high * 0x85ebca6bu) & (cut->edge_capacity - 1);
	while (cut->edges[at].low != LIGHTS_NONE && (cut->edges[at].low != low || cut->edges[at].high != high))
		at = (at + 1) & (cut->edge_capacity - 1);
	if (cut->edges[at].low == LIGHTS_NONE)
		cut->edges[at] = (lights_edge){low, high, lights_add_vertex(cut, low, high, plane)};
	return cut->edges[at].vertex;
}

/* Makes room for what a plane may add to a piece: an edge has one vertex, a triangle two such edges. */
static bool lights_room(lights_cut *cut, const lights_piece *piece)
{
	uint64_t most = (uint64_t)piece->index_count / 3 * 2, wanted = 16;
	while (wanted < 2 * most)
		wanted *= 2;
	if (!lights_reserve_vertices(cut, cut->vertex_count + most))
		return false;
	if (wanted > cut->edge_capacity) {
		free(cut->edges);
		cut->edges = wanted <= UINT32_MAX / 2 ? malloc(wanted * sizeof *cut->edges) : NULL;
		cut->edge_capacity = cut->edges ? (uint32_t)wanted : 0;
	}
	for (uint32_t e = 0; e < cut->edge_capacity; e++)
		cut->edges[e].low = LIGHTS_NONE;
	return cut->edges;
}

static void lights_add_triangle(lights_piece *piece, uint32_t a, uint32_t b, uint32_t c)
{
	uint32_t *out = piece->indices + piece->index_count;
	out[0] = a;
	out[1] = b;
	out[2] = c;
	piece->index_count += 3;
}

/* Gives a triangle, or what the plane makes of it, to the halves. The side of a corner: -1, 0 or 1. */
static void lights_cut_triangle(lights_cut *cut, const uint32_t corners[3], lights_plane plane, lights_piece halves[2])
{
	int sides[3], least = 1, most = -1;
	for (int i = 0; i < 3; i++) {
		float p = cut->vertices[corners[i]].position[plane.axis];
		sides[i] = (p > plane.at) - (p < plane.at);
		least = sides[i] < least ? sides[i] : least;
		most = sides[i] > most ? sides[i] : most;
	}
	if (least >= 0 || most <= 0) {
		lights_add_triangle(&halves[least >= 0 && most > 0], corners[0], corners[1], corners[2]);
		return;
	}
	/* The corner that is alone on its side comes first, or, where one lies in the plane, that one. */
	int first = 0;
	bool through = sides[0] == 0 || sides[1] == 0 || sides[2] == 0;
	for (int i = 0; i < 3; i++)
		if (through ? sides[i] == 0 : sides[i] != sides[(i + 1) % 3] && sides[i] != sides[(i + 2) % 3])
			first = i;
	uint32_t a = corners[first], b = corners[(first + 1) % 3], c = corners[(first + 2) % 3];
	if (through) {
		uint32_t middle = lights_edge_vertex(cut, b, c, plane);
		bool high = sides[(first + 1) % 3] > 0;
		lights_add_triangle(&halves[high], a, b, middle);
		lights_add_triangle(&halves[!high], a, middle, c);
		return;
	}
	uint32_t ab = lights_edge_vertex(cut, a, b, plane), ac = lights_edge_vertex(cut, a, c, plane);
	bool high = sides[first] > 0;
	lights_add_triangle(&halves[high], a, ab, ac);
	lights_add_triangle(&halves[!high], ab, b, c);
	lights_add_triangle(&halves[!high], ab, c, ac);
}

/* A half with room for all that the plane can leave of the piece, and with its lights. */
static bool lights_half(const lights_piece *piece, lights_piece *half)
{
	*half = (lights_piece){.light_count = piece->light_count};
	half->indices = malloc(2 * (size_t)piece->index_count * sizeof *half->indices);
	half->lights = malloc((size_t)piece->light_count * sizeof *half->lights);
	if (half->lights)
		memcpy(half->lights, piece->lights, (size_t)piece->light_count * sizeof *half->lights);
	return half->indices && half->lights;
}

/* Cuts a piece in two, which are open then. False: no memory. */
static bool lights_halve(lights_cut *cut, const lights_piece *piece, lights_plane plane)
{
	lights_piece halves[2] = {0};
	bool room = lights_half(piece, &halves[0]) && lights_half(piece, &halves[1]) && lights_room(cut, piece);
	for (uint32_t i = 0; room && i < piece->index_count; i += 3)
		lights_cut_triangle(cut, piece->indices + i, plane, halves);
	for (int h = 1; h >= 0; h--) { /* the low one is next */
		if (room && halves[h].index_count > 0)
			room = lights_push(cut, &halves[h]);
		else
			lights_piece_finish(&halves[h]);
	}
	return room;
}

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* Makes a mesh of a piece that stays as it is. False: no memory. */
static bool lights_emit(lights_cut *cut, const lights_piece *piece)
{
	stilb_geometry_pieces *pieces = cut->pieces;
	if (!lights_reserve((void **)&pieces->meshes, &cut->piece_capacity, pieces->count + 1, sizeof *pieces->meshes) ||
	    !lights_reserve((void **)&cut->places, &cut->place_capacity, cut->vertex_count, sizeof *cut->places))
		return false;
	stilb_scene_mesh *mesh = &pieces->meshes[pieces->count++];
	uint32_t count = 0;
	for (uint32_t i = 0; i < piece->index_count; i++)
		cut->places[piece->indices[i]] = LIGHTS_NONE;
	for (uint32_t i = 0; i < piece->index_count; i++)
		if (cut->places[piece->indices[i]] == LIGHTS_NONE)
			cut->places[piece->indices[i]] = count++;
	*mesh = (stilb_scene_mesh){.vertex_count = count, .index_count = piece->index_count};
	mesh->vertices = stilb_memory_alloc(count, sizeof *mesh->vertices);
	mesh->indices = stilb_memory_alloc(piece->index_count, sizeof *mesh->indices);
	mesh->extras = cut->extras ? stilb_memory_alloc(count, sizeof *mesh->extras) : NULL;
	if (!mesh->vertices || !mesh->indices || (cut->extras && !mesh->extras))
		return false;
	for (uint32_t i = 0; i < piece->index_count; i++) {
		uint32_t from = piece->indices[i], to = cut->places[from];
		mesh->indices[i] = to;
		mesh->vertices[to] = cut->vertices[from];
		if (cut->extras)
			mesh->extras[to] = cut->extras[from];
	}
	pieces->triangles += piece->index_count / 3;
	pieces->most = piece->light_count > pieces->most ? piece->light_count : pieces->most;
	return true;
}

static bool lights_run(lights_cut *cut)
{
	bool room = true;
	while (room && cut->open_count > 0) {
		lights_piece piece = cut->open[--cut->open_count];
		lights_box box = lights_box_of(cut, &piece);
		lights_keep(cut, &piece, &box);
		lights_plane plane = {.axis = LIGHTS_NONE};
		if (piece.light_count > cut->desc->enough)
			plane = lights_choose(cut, &piece, &box);
		room = plane.axis == LIGHTS_NONE ? lights_emit(cut, &piece) : lights_halve(cut, &piece, plane);
		lights_piece_finish(&piece);
	}
	return room;
}

static stilb_result lights_check(const stilb_scene_mesh *mesh, const stilb_geometry_lights_desc *desc)
{
	if (!(desc->least > 0.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "pieces of at least %g m: it must be above 0", (double)desc->least);
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "index %u is %u; the mesh has %u vertices", i, mesh->indices[i],
			                  mesh->vertex_count);
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int k = 0; k < 3; k++)
			if (!isfinite(mesh->vertices[v].position[k]))
				return stilb_fail(STILB_ERROR_ARGUMENT, "the position of vertex %u is not finite", v);
	return STILB_OK;
}

/* The whole mesh as the first piece. False: no memory. */
static bool lights_begin(lights_cut *cut, const stilb_scene_mesh *mesh)
{
	const stilb_geometry_lights_desc *desc = cut->desc;
	size_t vertices = (size_t)mesh->vertex_count, indices = (size_t)mesh->index_count;
	cut->vertices = malloc(vertices * sizeof *cut->vertices);
	cut->extras = mesh->extras ? malloc(vertices * sizeof *cut->extras) : NULL;
	lights_piece whole = {.index_count = mesh->index_count, .light_count = desc->light_count};
	whole.indices = malloc(indices * sizeof *whole.indices);
	whole.lights = malloc(((size_t)desc->light_count + 1) * sizeof *whole.lights);
	if (!cut->vertices || (mesh->extras && !cut->extras) || !whole.indices || !whole.lights) {
		lights_piece_finish(&whole);
		return false;
	}
	memcpy(cut->vertices, mesh->vertices, vertices * sizeof *cut->vertices);
	if (mesh->extras)
		memcpy(cut->extras, mesh->extras, vertices * sizeof *cut->extras);
	memcpy(whole.indices, mesh->indices, indices * sizeof *whole.indices);
	for (uint32_t l = 0; l < desc->light_count; l++)
		whole.lights[l] = l;
	cut->vertex_count = cut->vertex_capacity = mesh->vertex_count;
	return lights_push(cut, &whole);
}

stilb_result stilb_geometry_cut_at_lights(const stilb_scene_mesh *mesh, const stilb_geometry_lights_desc *desc,
                                          stilb_geometry_pieces *pieces)
{
	STILB_ASSERT(mesh && desc && pieces);
	STILB_ASSERT(desc->lights || desc->light_count == 0);
	STILB_ASSERT(mesh->index_count % 3 == 0);
	*pieces = (stilb_geometry_pieces){0};
	stilb_result result = lights_check(mesh, desc);
	if (result != STILB_OK || mesh->index_count == 0)
		return result;
	lights_cut cut = {.desc = desc, .pieces = pieces};
	if (!lights_begin(&cut, mesh) || !lights_run(&cut)) {
		stilb_geometry_pieces_finish(pieces);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory to cut a mesh of %u triangles", mesh->index_count / 3);
	}
	lights_cut_finish(&cut);
	return result;
}

void stilb_geometry_build_pieces(stilb_scene_build *build, uint32_t node, uint32_t material,
                                 const stilb_geometry_pieces *pieces)
{
	for (uint32_t p = 0; p < pieces->count; p++) {
		stilb_scene_build_part part = {stilb_scene_build_mesh(build, &pieces->meshes[p]), material};
		stilb_scene_build_model(build, node, &part, 1);
	}
}

void stilb_geometry_pieces_finish(stilb_geometry_pieces *pieces)
{
	for (uint32_t p = 0; p < pieces->count; p++)
		stilb_scene_mesh_finish(&pieces->meshes[p]);
	free(pieces->meshes);
	*pieces = (stilb_geometry_pieces){0};
}
