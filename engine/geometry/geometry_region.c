/* Simplifies a piece of a mesh: a queue of vertices by the cost of their cheapest collapse. A collapse costs what it
 * changes of the surface as it is then. */
#include "geometry/geometry_region.h"

#include "geometry/geometry_fan.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT16_MAX
#define RING GEOMETRY_FAN  /* neighbours of a position that may be removed, at most */
#define WEDGES 96          /* vertices at such a position, at most */
#define BUCKETS 4096       /* costs of one bucket differ by a sixteenth at most */
#define BORDER_WEIGHT 4.0f /* what leaving a border counts against leaving the surface */
#define SEAM_WEIGHT 1.0f
#define NEARLY 1.25f /* a collapse that has become dearer by less than this is made at once */

typedef struct region {
	const geometry_round *round;
	uint32_t triangle_count, vertex_count, position_count, live;
	uint32_t groups;
	float root_area;                            /* metres: the square root of round->area */
	stilb_vec4 limited[STILB_GEOMETRY_STREAMS]; /* [groups] 1 for each number whose cost has a limit, else 0 */
	/* Of corners: corner k of triangle t is 4 t + k. Numbers of two bytes keep a region in the cache. */
	uint16_t *vertex; /* NONE: the triangle is gone */
	uint16_t *position;
	uint16_t *next; /* the next corner at its position */
	/* of vertices */
	uint32_t *vertex_global;
	uint16_t *vertex_position;
	uint16_t *vertex_next; /* the next vertex at the same position */
	uint16_t *vertex_seam; /* the first vertex at this position with the same values in all streams with seams */
	stilb_vec4 *values;    /* [vertex][groups] times their scales */
	/* of positions */
	stilb_vec3 *point; /* from the middle of the region */
	uint16_t *head;    /* the first corner */
	uint16_t *first;   /* the first vertex */
	float *cost;
	uint16_t *best; /* the neighbour onto which it goes at this cost */
	uint16_t *queue_next;
	uint32_t *mark; /* serial << 8 | place in the ring, if it is in the ring gathered last */
	uint32_t *seen; /* seen_serial, if it is a neighbour of the other end, too */
	uint8_t *fixed, *dirty, *queued;
	uint8_t *shared;              /* it has triangles in other regions */
	uint32_t serial, seen_serial; /* of gather's and link_is_sound's last call */
	/* what gather has found at one position */
	uint32_t ring_count, corner_count, wedge_count, border_count;
	uint16_t ring[RING + 2]; /* the neighbours: the other ends of edges */
	uint16_t uses[RING + 2]; /* triangles at each edge */
	uint16_t corners[RING];
	uint16_t sides[RING][2]; /* of each corner's triangle: the edges in ring to its next and its previous corner */
	uint16_t wedges[WEDGES];
	geometry_fan fan;
	uint64_t exact[RING / 64 + 1]; /* bits of edges: the cost has that of values; else it is less than the cost */
	/* the queue */
	uint16_t bucket_head[BUCKETS], bucket_tail[BUCKETS];
	uint64_t bucket_used[BUCKETS / 64];
	uint32_t bucket_least; /* none before this word of bucket_used has a bit */
	void *build_memory, *memory;
	geometry_record *record;
} region;

/* The other two corners of a corner's triangle, in their order: without branches, which could not be predicted. */
static inline uint32_t corner_after(uint32_t corner)
{
	return (corner & ~3u) | (0x09u >> 2 * (corner & 3) & 3); /* 0, 1, 2: 1, 2, 0 */
}

static inline uint32_t corner_before(uint32_t corner)
{
	return (corner & ~3u) | (0x12u >> 2 * (corner & 3) & 3); /* 0, 1, 2: 2, 0, 1 */
}

/* ---- building ---------------------------------------------------------------------------------------------------- */

/* Numbers the keys in the order of their arrival. */
typedef struct number_table {
	uint32_t *keys, *numbers;
	uint32_t mask, count;
} number_table;

static uint32_t number_of(number_table *table, uint32_t key)
{
	for (uint32_t i = key * 2654435769u >> 7 & table->mask;; i = (i + 1) & table->mask) {
		if (table->keys[i] == key)
			return table->numbers[i];
		if (table->keys[i] == UINT32_MAX) {
			table->keys[i] = key;
			table->numbers[i] = table->count;
			return table->count++;
		}
	}
}

/* The next part of a block. */
static void *take(unsigned char **at, size_t count, size_t size)
{
	void *part = *at;
	*at += (count * size + 63) & ~(size_t)63;
	return part;
}

static const float *position_of(const geometry_round *round, uint32_t vertex)
{
	return (const float *)((const char *)round->mesh->positions + vertex * round->mesh->position_stride);
}

/* Numbers the vertices. */
static bool region_build_corners(region *r, const uint32_t (*triangles)[3], uint32_t count)
{
	uint32_t corners = 3 * count, capacity = 64;
	while (capacity < 4 * count)
		capacity *= 2;
	size_t size = (size_t)capacity * 8 + (size_t)corners * 6 + (size_t)count * 3 * 8 + (size_t)8 * 64;
	unsigned char *at = r->build_memory = stilb_memory_alloc(size, 1);
	if (!at)
		return false;
	number_table table = {.mask = capacity - 1};
	table.keys = take(&at, capacity, 4);
	table.numbers = take(&at, capacity, 4);
	memset(table.keys, 0xff, (size_t)capacity * 4);
	r->vertex = take(&at, count, 8);
	r->position = take(&at, count, 8);
	r->next = take(&at, count, 8);
	r->vertex_global = take(&at, corners, 4);
	r->vertex_position = take(&at, corners, 2);
	for (uint32_t t = 0; t < count; t++)
		for (uint32_t k = 0; k < 3; k++) {
			uint32_t vertex = number_of(&table, triangles[t][k]);
			r->vertex[4 * t + k] = (uint16_t)vertex;
			r->vertex_global[vertex] = triangles[t][k];
		}
	r->vertex_count = table.count;
	memset(table.keys, 0xff, (size_t)capacity * 4);
	table.count = 0;
	for (uint32_t v = 0; v < r->vertex_count; v++)
		r->vertex_position[v] = (uint16_t)number_of(&table, r->round->canonical[r->vertex_global[v]]);
	r->position_count = table.count;
	for (uint32_t t = 0; t < count; t++)
		for (uint32_t k = 0; k < 3; k++)
			r->position[4 * t + k] = r->vertex_position[r->vertex[4 * t + k]];
	return true;
}

static bool region_allocate(region *r)
{
	size_t v = r->vertex_count, p = r->position_count;
	size_t size = v * (4 + r->groups * sizeof *r->values) + p * (sizeof *r->point + 24) + (size_t)24 * 64;
	unsigned char *at = r->memory = stilb_memory_alloc(size, 1);
	if (!at)
		return false;
	r->values = take(&at, v * r->groups, sizeof *r->values);
	r->point = take(&at, p, sizeof *r->point);
	r->vertex_next = take(&at, v, 2);
	r->vertex_seam = take(&at, v, 2);
	r->head = take(&at, p, 2);
	r->first = take(&at, p, 2);
	r->cost = take(&at, p, 4);
	r->best = take(&at, p, 2);
	r->queue_next = take(&at, p, 2);
	unsigned char *zeroed = at;
	r->mark = take(&at, p, 4);
	r->seen = take(&at, p, 4);
	r->fixed = take(&at, p, 1);
	r->dirty = take(&at, p, 1);
	r->queued = take(&at, p, 1);
	r->shared = take(&at, p, 1);
	memset(zeroed, 0, (size_t)(at - zeroed));
	memset(r->head, 0xff, p * sizeof *r->head);
	memset(r->first, 0xff, p * sizeof *r->first);
	return true;
}

/* Reads the values of a vertex, times their scales. */
static void read_values(const region *r, uint32_t vertex)
{
	const stilb_geometry_mesh *mesh = r->round->mesh;
	float *out = (float *)&r->values[(size_t)vertex * r->groups];
	uint32_t n = 0;
	for (uint32_t s = 0; s < mesh->stream_count; s++) {
		const stilb_geometry_stream *stream = &mesh->streams[s];
		const float *in = (const float *)((const char *)stream->values + r->vertex_global[vertex] * stream->stride);
		for (uint32_t k = 0; k < stream->components; k++) {
			float value = in[k] * r->round->scale[s];
			out[n++] = isfinite(value) ? value : 0.0f;
		}
	}
	for (; n < 4 * r->groups; n++)
		out[n] = 0.0f;
}

/* Differences of directions are bounded by themselves. */
static void find_limited(region *r)
{
	const stilb_geometry_mesh *mesh = r->round->mesh;
	float *limited = (float *)r->limited;
	for (uint32_t s = 0, n = 0; s < mesh->stream_count; s++)
		for (uint32_t k = 0; k < mesh->streams[s].components; k++)
			limited[n++] = mesh->streams[s].kind == STILB_GEOMETRY_DIRECTION ? 0.0f : 1.0f;
}

/* True if two vertices have the same values in all streams that have seams. */
static bool same_seam(const region *r, uint32_t a, uint32_t b)
{
	const stilb_geometry_mesh *mesh = r->round->mesh;
	for (uint32_t s = 0; s < mesh->stream_count; s++) {
		const stilb_geometry_stream *stream = &mesh->streams[s];
		if (stream->seam && memcmp((const char *)stream->values + r->vertex_global[a] * stream->stride,
		                           (const char *)stream->values + r->vertex_global[b] * stream->stride,
		                           (size_t)stream->components * 4) != 0)
			return false;
	}
	return true;
}

static void region_build_vertices(region *r, uint32_t id)
{
	const geometry_round *round = r->round;
	const float *middle = position_of(round, r->vertex_global[0]);
	for (uint32_t v = 0; v < r->vertex_count; v++) {
		uint32_t p = r->vertex_position[v], canonical = round->canonical[r->vertex_global[v]];
		if (r->first[p] == NONE) {
			const float *at = position_of(round, canonical);
			r->point[p] = stilb_vec3_make(at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]);
			r->shared[p] = round->owner && round->owner[canonical] != id;
			r->fixed[p] = r->shared[p] || (round->locked && round->locked[canonical]);
		}
		r->vertex_seam[v] = (uint16_t)v;
		for (uint32_t w = r->first[p]; w != NONE; w = r->vertex_next[w])
			if (r->vertex_seam[w] == w && same_seam(r, v, w)) {
				r->vertex_seam[v] = (uint16_t)w;
				break;
			}
		r->vertex_next[v] = r->first[p];
		r->first[p] = (uint16_t)v;
		if (r->groups > 0)
			read_values(r, v);
	}
	for (uint32_t t = r->triangle_count; t-- > 0;)
		for (uint32_t k = 0; k < 3; k++) {
			uint32_t corner = 4 * t + k, p = r->position[corner];
			r->next[corner] = r->head[p];
			r->head[p] = (uint16_t)corner;
		}
}

/* ---- the ring of a position -------------------------------------------------------------------------------------- */

/* Notes that a triangle has an edge to position q; returns its place in the ring. Without branches, since whether q was
 * there already could not be predicted. */
static inline uint32_t ring_note(region *r, uint32_t serial, uint32_t *ring_count, uint32_t q)
{
	uint32_t mark = r->mark[q];
	bool known = mark >> 8 == serial;
	uint32_t slot = known ? mark & 0xff : *ring_count, uses = r->uses[slot];
	r->mark[q] = serial << 8 | slot;
	r->ring[slot] = (uint16_t)q;
	r->uses[slot] = (uint16_t)(known ? uses + 1 : 1);
	*ring_count += !known;
	return slot;
}

/* The place of a neighbour in the ring. */
static uint32_t slot_of(const region *r, uint32_t q)
{
	return r->mark[q] & 0xff;
}

static bool ring_note_wedge(region *r, uint32_t vertex)
{
	for (uint32_t i = 0; i < r->wedge_count; i++)
		if (r->wedges[i] == vertex)
			return true;
	if (r->wedge_count == WEDGES)
		return false;
	r->wedges[r->wedge_count++] = (uint16_t)vertex;
	return true;
}

/* Finds neighbours, corners and vertices of a position, and forgets corners of triangles that are gone. False: its
 * triangles are no disk or half disk around it, or they are too many, so it cannot be removed. */
static bool region_gather(region *r, uint32_t p)
{
	if (++r->serial == 1u << 24) { /* marks have no room for more */
		memset(r->mark, 0, r->position_count * sizeof *r->mark);
		r->serial = 1;
	}
	uint32_t serial = r->serial, ring_count = 0, corner_count = 0;
	bool is_sheet = true; /* at each edge are one or two triangles */
	r->wedge_count = 0;
	for (uint16_t *link = &r->head[p]; *link != NONE;) {
		uint32_t corner = *link, vertex = r->vertex[corner];
		if (vertex == NONE) {
			*link = r->next[corner];
			continue;
		}
		uint32_t a = ring_note(r, serial, &ring_count, r->position[corner_after(corner)]);
		uint32_t b = ring_note(r, serial, &ring_count, r->position[corner_before(corner)]);
		if (ring_count > RING || corner_count == RING || !ring_note_wedge(r, vertex))
			return false;
		is_sheet &= r->uses[a] <= 2 && r->uses[b] <= 2;
		r->sides[corner_count][0] = (uint16_t)a;
		r->sides[corner_count][1] = (uint16_t)b;
		r->corners[corner_count++] = (uint16_t)corner;
		link = &r->next[corner];
	}
	r->ring_count = ring_count;
	r->corner_count = corner_count;
	r->border_count = 2 * (ring_count - corner_count); /* if it is a sheet: each triangle has two edges */
	/* One fan of triangles has as many neighbours as triangles, or one more with two edges at the border. Two closed
	 * fans have as many, too: ring_is_one finds them. */
	return is_sheet && ring_count > 0 && (ring_count == corner_count || ring_count == corner_count + 1);
}

/* True if the neighbours hang together: walks from triangle to triangle. */
static bool ring_is_one(const region *r)
{
	bool reached[RING] = {[0] = true};
	uint32_t count = 1;
	for (bool found = true; found && count < r->ring_count;) {
		found = false;
		for (uint32_t i = 0; i < r->corner_count; i++) {
			uint32_t a = r->sides[i][0], b = r->sides[i][1];
			if (reached[a] == reached[b])
				continue;
			reached[a] = reached[b] = found = true;
			count++;
		}
	}
	return count == r->ring_count;
}

/* ---- the cost of a collapse -------------------------------------------------------------------------------------- */

/* Where the vertices at a position go in a collapse. */
typedef struct wedge_map {
	uint32_t to[WEDGES];
	float cost;
} wedge_map;

/* The vertices at both ends of an edge, in each of its triangles; their count. */
static uint32_t edge_vertices(const region *r, uint32_t slot, uint32_t from[2], uint32_t to[2])
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < r->corner_count && count < 2; i++) {
		if (r->sides[i][0] != slot && r->sides[i][1] != slot)
			continue;
		uint32_t corner = r->corners[i];
		from[count] = r->vertex[corner];
		to[count++] = r->vertex[r->sides[i][0] == slot ? corner_after(corner) : corner_before(corner)];
	}
	return count;
}

/* True if the values with seams differ between the two sides of an edge. */
static bool edge_is_seam(const region *r, uint32_t slot)
{
	uint32_t from[2], to[2];
	return edge_vertices(r, slot, from, to) == 2 &&
	       (r->vertex_seam[from[0]] != r->vertex_seam[from[1]] || r->vertex_seam[to[0]] != r->vertex_seam[to[1]]);
}

/* Borders and seams hold the gathered position: planes through them, perpendicular to the surface. */
static void fan_add_edges(region *r)
{
	for (uint32_t slot = 0; slot < r->ring_count; slot++) {
		bool seam = r->uses[slot] != 1;
		if (seam && !edge_is_seam(r, slot))
			continue;
		stilb_vec3 along = r->fan.edge[slot];
		float weight = stilb_vec3_dot(along, along) * (seam ? SEAM_WEIGHT : BORDER_WEIGHT);
		for (uint32_t i = 0; i < r->corner_count; i++) {
			if (r->sides[i][0] != slot && r->sides[i][1] != slot)
				continue;
			stilb_vec3 out = stilb_vec3_cross(along, geometry_fan_normal(&r->fan, i));
			float square = stilb_vec3_dot(out, out);
			if (square > FLT_MIN)
				geometry_fan_add_plane(&r->fan, out, weight / square);
		}
	}
}

/* Measures the triangles at the gathered position. */
static void region_measure(region *r, uint32_t p)
{
	geometry_fan *fan = &r->fan;
	stilb_vec3 here = r->point[p];
	for (uint32_t i = 0; i < r->ring_count; i++)
		fan->edge[i] = r->point[r->ring[i]] - here;
	for (uint32_t i = r->corner_count; i % 4 != 0; i++)
		r->sides[i][0] = r->sides[i][1] = 0;
	geometry_fan_measure(fan, r->corner_count, (const uint16_t(*)[2])r->sides);
	if (r->border_count > 0 || r->wedge_count > 1)
		fan_add_edges(r);
}

/* What the values of a vertex cost when it goes to `to`, at the place that the fan was asked for last, m^4: each of its
 * triangles predicts the values there. A texture that lies wrong by some triangles is wrong, and not more wrong with
 * each triangle: without a limit a strip into which a whole texture is squeezed would be kept at any price. */
static float wedge_cost(const region *r, uint32_t wedge, uint32_t to)
{
	uint32_t groups = r->groups;
	const stilb_vec4 *values = r->values, *here = &values[(size_t)wedge * groups],
					 *there = &values[(size_t)to * groups];
	stilb_vec4 sum = {0}, limited = {0};
	float areas = 0.0f;
	for (uint32_t i = 0; i < r->corner_count; i++) {
		uint32_t corner = r->corners[i], a = r->vertex[corner_after(corner)], b = r->vertex[corner_before(corner)];
		if (r->vertex[corner] != wedge)
			continue;
		float area = r->fan.area[i], along_a = r->fan.along_a[i], along_b = r->fan.along_b[i];
		areas += area;
		if (a == to || b == to)
			continue;
		for (uint32_t g = 0; g < groups; g++) {
			stilb_vec4 off =
				(values[a * groups + g] - here[g]) * along_a + (values[b * groups + g] - here[g]) * along_b;
			off += here[g] - there[g];
			stilb_vec4 square = area * off * off;
			sum += square;
			limited += square * r->limited[g];
		}
	}
	float all = geometry_sum4(sum), part = geometry_sum4(limited), most = r->round->value_limit * areas;
	return part < most ? all : all - part + most;
}

/* The vertex at the other end of an edge where `wedge` belongs: on its side of all seams, and the cheapest of these.
 * NONE: there is none, or the seam begins at the other end, and the wedge would belong to both sides of it. */
static uint32_t wedge_target(const region *r, uint32_t slot, uint32_t wedge, float *cost)
{
	uint32_t from[2], to[2], side = NONE, uses = edge_vertices(r, slot, from, to);
	for (uint32_t i = 0; i < uses; i++) {
		if (r->vertex_seam[from[i]] != r->vertex_seam[wedge])
			continue;
		uint32_t seam = r->vertex_seam[to[i]];
		if (side != NONE && side != seam)
			return NONE;
		side = seam;
	}
	if (side == NONE)
		return NONE;
	uint32_t best = NONE;
	for (uint32_t v = r->first[r->ring[slot]]; v != NONE; v = r->vertex_next[v]) {
		if (r->vertex_seam[v] != side)
			continue;
		float c = r->groups > 0 ? wedge_cost(r, wedge, v) : 0.0f;
		if (best == NONE || c < *cost) {
			best = v;
			*cost = c;
		}
	}
	return best;
}

/* The only vertex at both ends of an edge, its own; NONE: one of them has several. */
static uint32_t only_target(const region *r, uint32_t slot)
{
	uint32_t only = r->first[r->ring[slot]];
	return r->wedge_count == 1 && r->vertex_next[only] == NONE ? only : NONE;
}

/* Finds where all vertices of the gathered position go along an edge. False: one has no place there. */
static bool map_wedges(region *r, uint32_t slot, wedge_map *map)
{
	geometry_fan_place(&r->fan, r->fan.edge[slot]);
	map->cost = 0.0f;
	for (uint32_t i = 0; i < r->wedge_count; i++) {
		float cost = 0.0f;
		map->to[i] = wedge_target(r, slot, r->wedges[i], &cost);
		if (map->to[i] == NONE)
			return false;
		map->cost += cost;
	}
	return true;
}

/* The part of an edge's cost that values have, m^4; FLT_MAX: a vertex has no place at the other end. */
static float edge_value_cost(region *r, uint32_t slot)
{
	uint32_t only = only_target(r, slot);
	if (only != NONE) {
		if (r->groups == 0)
			return 0.0f;
		geometry_fan_place(&r->fan, r->fan.edge[slot]);
		return wedge_cost(r, r->wedges[0], only);
	}
	wedge_map map;
	return map_wedges(r, slot, &map) ? map.cost : FLT_MAX;
}

/* ---- what may be collapsed --------------------------------------------------------------------------------------- */

/* True if both ends have no common neighbours but those that the edge's triangles have, so that a manifold remains one.
 * The ring of one end is gathered. */
static bool link_is_sound(region *r, uint32_t slot)
{
	uint32_t end = r->ring[slot], serial = r->serial, seen_serial = ++r->seen_serial, *seen = r->seen;
	uint32_t common = 0, corners = 0, opposite = 0;
	const uint32_t *mark = r->mark;
	for (uint16_t *link = &r->head[end]; *link != NONE;) {
		uint32_t corner = *link, on_ring = 0;
		if (r->vertex[corner] == NONE) {
			*link = r->next[corner];
			continue;
		}
		for (uint32_t i = 0; i < 2; i++) {
			uint32_t q = r->position[i == 0 ? corner_after(corner) : corner_before(corner)];
			if (mark[q] >> 8 != serial)
				continue;
			on_ring++;
			common += seen[q] != seen_serial;
			seen[q] = seen_serial;
		}
		corners++;
		opposite += on_ring == 2;
		link = &r->next[corner];
	}
	if (common != r->uses[slot] || corners + r->corner_count == 2 * common)
		return false;   /* the last: nothing would be left */
	if (r->shared[end]) /* two that are shared may be neighbours in another region */
		for (uint32_t i = 0; i < r->ring_count; i++) {
			uint32_t q = r->ring[i];
			if (q != end && r->shared[q] && seen[q] != seen_serial)
				return false;
		}
	/* One triangle alone between two edges of the border: if the third corner is shared, it would not be in this region
	 * any more, and could go in another one while this one is still what it was (clusters). */
	if (r->corner_count == 1)
		for (uint32_t i = 0; i < r->ring_count; i++)
			if (r->ring[i] != end && r->shared[r->ring[i]])
				return false;
	/* A closed fan of three triangles is a corner of a tetrahedron if its ring is a triangle, too. */
	return !(r->corner_count == 3 && r->border_count == 0 && opposite > 0);
}

/* True if a triangle at the gathered position turns over, or nearly so, when the position moves along an edge. */
static bool turns_over(const region *r, uint32_t slot)
{
	stilb_vec3 d = r->fan.edge[slot];
	for (uint32_t i = 0; i < r->fan.triangles; i += 4) {
		geometry_mask turns = geometry_fan_turns(&r->fan, i, d);
		for (uint32_t k = 0; k < 4; k++) /* those at the edge vanish */
			if (turns[k] != 0 && r->sides[i + k][0] != slot && r->sides[i + k][1] != slot)
				return true;
	}
	return false;
}

static bool edge_is_allowed(region *r, uint32_t slot)
{
	return !turns_over(r, slot) && link_is_sound(r, slot);
}

/* The place of the least of some numbers, which are not negative, or of one that is larger by less than 2^-16 of it. */
static uint32_t cheapest(const float *cost, uint32_t count)
{
	uint32_t least = UINT32_MAX;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t bits; /* of such numbers they ascend with the numbers */
		memcpy(&bits, &cost[i], sizeof bits);
		bits = (bits & ~0x7fu) | i;
		least = bits < least ? bits : least;
	}
	return least & 0x7f;
}

/* Finds the cheapest collapse of the gathered position; if that would cost no more than `checked_to`, the cheapest that
 * is allowed. Values are looked at only where the planes alone do not make an edge dearer. */
static bool region_evaluate(region *r, uint32_t p, float checked_to)
{
	float inverse = r->fan.whole > 0.0f ? 1.0f / (sqrtf(r->fan.whole) * r->root_area) : 1.0f;
	float *cost = r->fan.cost;
	geometry_fan_costs(&r->fan, r->ring_count, inverse);
	for (size_t i = 0; i < sizeof r->exact / sizeof *r->exact; i++)
		r->exact[i] = 0;
	for (uint32_t i = 0; i < r->ring_count && r->border_count > 0; i++)
		if (r->uses[i] != 1)
			cost[i] = FLT_MAX;
	for (;;) {
		uint32_t best = cheapest(cost, r->ring_count);
		uint64_t *exact = &r->exact[best / 64], bit = (uint64_t)1 << best % 64;
		if (!(cost[best] < FLT_MAX))
			return false;
		if ((*exact & bit) == 0) {
			*exact |= bit;
			float values = edge_value_cost(r, best);
			cost[best] = values < FLT_MAX ? cost[best] + values * inverse : FLT_MAX;
			continue;
		}
		if (cost[best] > checked_to || edge_is_allowed(r, best)) {
			r->best[p] = r->ring[best];
			r->cost[p] = cost[best];
			return true;
		}
		cost[best] = FLT_MAX;
	}
}

/* ---- the queue --------------------------------------------------------------------------------------------------- */

static uint32_t bucket_of(float cost)
{
	uint32_t bits;
	memcpy(&bits, &cost, sizeof bits);
	return bits >> 19;
}

/* The largest cost in the bucket of a cost. */
static float bucket_end(float cost)
{
	uint32_t bits;
	memcpy(&bits, &cost, sizeof bits);
	bits |= (1u << 19) - 1;
	memcpy(&cost, &bits, sizeof cost);
	return cost;
}

static void queue_push(region *r, uint32_t p)
{
	uint32_t bucket = bucket_of(r->cost[p]), word = bucket / 64;
	uint64_t bit = (uint64_t)1 << bucket % 64;
	if (r->bucket_used[word] & bit)
		r->queue_next[r->bucket_tail[bucket]] = (uint16_t)p;
	else
		r->bucket_head[bucket] = (uint16_t)p;
	r->bucket_used[word] |= bit;
	r->bucket_tail[bucket] = (uint16_t)p;
	r->queue_next[p] = NONE;
	r->queued[p] = 1;
	r->bucket_least = word < r->bucket_least ? word : r->bucket_least;
}

static uint32_t queue_pop(region *r)
{
	for (; r->bucket_least < BUCKETS / 64; r->bucket_least++) {
		uint64_t *used = &r->bucket_used[r->bucket_least];
		if (*used == 0)
			continue;
		uint32_t bucket = r->bucket_least * 64 + (uint32_t)__builtin_ctzll(*used), p = r->bucket_head[bucket];
		r->bucket_head[bucket] = r->queue_next[p];
		if (r->queue_next[p] == NONE)
			*used &= *used - 1;
		r->queued[p] = 0;
		return p;
	}
	return NONE;
}

/* ---- collapsing -------------------------------------------------------------------------------------------------- */

static bool is_wedge(const region *r, uint32_t vertex)
{
	for (uint32_t k = 0; k < r->wedge_count; k++)
		if (r->wedges[k] == vertex)
			return true;
	return false;
}

/* Notes where the vertices of position p go. Those that only triangles have that are gone go along: such a triangle is
 * known later by two corners at one position. */
static void record_collapse(region *r, uint32_t p, const wedge_map *map, uint32_t removed, float cost)
{
	geometry_record *record = r->record;
	uint32_t i = record->count++, end = i > 0 ? record->maps_end[i - 1] : 0;
	for (uint32_t k = 0; k < r->wedge_count; k++) {
		record->from[end] = r->vertex_global[r->wedges[k]];
		record->to[end++] = r->vertex_global[map->to[k]];
	}
	for (uint32_t v = r->first[p]; v != NONE; v = r->vertex_next[v])
		if (!is_wedge(r, v)) {
			record->from[end] = r->vertex_global[v];
			record->to[end++] = r->vertex_global[map->to[0]];
		}
	record->maps_end[i] = end;
	record->triangles[i] = removed + (i > 0 ? record->triangles[i - 1] : 0);
	record->cost[i] = i > 0 && record->cost[i - 1] > cost ? record->cost[i - 1] : cost;
}

/* After a collapse at this cost: what a neighbour has computed is old, and what could not go may go now. */
static void neighbour_changed(region *r, uint32_t q, float cost)
{
	if (r->fixed[q])
		return;
	r->dirty[q] = 1;
	if (!r->queued[q]) {
		r->cost[q] = cost;
		queue_push(r, q);
	}
}

/* Moves the gathered position p to its neighbour r->best[p]. */
static void region_collapse(region *r, uint32_t p)
{
	uint32_t to = r->best[p];
	uint32_t gone = slot_of(r, to);
	wedge_map map;
	map.to[0] = only_target(r, gone);
	bool mapped = map.to[0] != NONE || map_wedges(r, gone, &map);
	STILB_ASSERT(r->wedge_count > 0 && mapped && "a collapse that was allowed maps all vertices");
	(void)mapped;
	uint32_t removed = 0;
	for (uint32_t i = 0; i < r->corner_count; i++) {
		uint32_t corner = r->corners[i], wedge = 0;
		if (r->sides[i][0] == gone || r->sides[i][1] == gone) {
			r->vertex[corner] = r->vertex[corner_after(corner)] = r->vertex[corner_before(corner)] = NONE;
			removed++;
			continue;
		}
		while (r->wedges[wedge] != r->vertex[corner])
			wedge++;
		STILB_ASSERT(wedge < r->wedge_count);
		r->vertex[corner] = (uint16_t)map.to[wedge];
		r->position[corner] = (uint16_t)to;
		r->next[corner] = r->head[to];
		r->head[to] = (uint16_t)corner;
	}
	r->live -= removed;
	r->head[p] = NONE;
	record_collapse(r, p, &map, removed, r->cost[p]);
	for (uint32_t i = 0; i < r->ring_count; i++)
		neighbour_changed(r, r->ring[i], r->cost[p]);
}

/* Gathers each position for the first time: what cannot go ever is fixed. */
static void region_start(region *r)
{
	for (uint32_t p = 0; p < r->position_count; p++) {
		if (r->fixed[p])
			continue;
		if (!region_gather(r, p) || (r->border_count == 0 && !ring_is_one(r))) {
			r->fixed[p] = 1;
			continue;
		}
		region_measure(r, p);
		if (region_evaluate(r, p, -1.0f))
			queue_push(r, p);
	}
}

static void region_run(region *r, geometry_stop stop)
{
	region_start(r);
	while (r->live > stop.triangles) {
		uint32_t p = queue_pop(r);
		if (p == NONE || r->cost[p] > stop.cost)
			return;
		if (!region_gather(r, p))
			continue; /* it has too many neighbours now */
		region_measure(r, p);
		if (r->dirty[p] || !edge_is_allowed(r, slot_of(r, r->best[p]))) {
			float cost = bucket_end(NEARLY * r->cost[p]);
			r->dirty[p] = 0;
			if (!region_evaluate(r, p, cost))
				continue;
			if (r->cost[p] > cost) {
				queue_push(r, p);
				continue;
			}
		}
		region_collapse(r, p);
	}
}

static bool record_allocate(geometry_record *record, uint32_t positions, uint32_t vertices)
{
	size_t size = (size_t)positions * 12 + (size_t)vertices * 8 + (size_t)5 * 64;
	unsigned char *at = record->memory = stilb_memory_alloc(size, 1);
	if (!at)
		return false;
	record->cost = take(&at, positions, 4);
	record->triangles = take(&at, positions, 4);
	record->maps_end = take(&at, positions, 4);
	record->from = take(&at, vertices, 4);
	record->to = take(&at, vertices, 4);
	return true;
}

bool geometry_region_collapse(const geometry_round *round, uint32_t id, const uint32_t (*triangles)[3], uint32_t count,
                              geometry_stop stop, geometry_record *record)
{
	STILB_ASSERT(round && record && count <= GEOMETRY_REGION_MOST);
	*record = (geometry_record){0};
	if (count == 0)
		return true;
	region *r = calloc(1, sizeof *r);
	if (!r)
		return false;
	*r = (region){.round = round, .triangle_count = count, .live = count, .groups = round->groups, .record = record};
	r->root_area = round->area > 0.0f ? sqrtf(round->area) : 1.0f;
	bool made = region_build_corners(r, triangles, count) && region_allocate(r) &&
	            record_allocate(record, r->position_count, r->vertex_count);
	if (made) {
		find_limited(r);
		region_build_vertices(r, id);
		region_run(r, stop);
	}
	free(r->build_memory);
	free(r->memory);
	free(r);
	return made;
}

uint32_t geometry_record_prefix(const geometry_record *record, float cost)
{
	uint32_t low = 0, high = record->count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (record->cost[middle] <= cost)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

void geometry_record_finish(geometry_record *record)
{
	free(record->memory);
	*record = (geometry_record){0};
}
