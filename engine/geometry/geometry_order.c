/* The order of triangles, for the cache of transformed vertices and against overdraw.
 * Source: Sander, Nehab and Barczak, "Fast triangle reordering for vertex locality and reduced overdraw", SIGGRAPH
 * 2007. */
#include "geometry/geometry_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define CACHE 16u         /* transformed vertices that a device is assumed to keep */
#define CLUSTER_LEAST 64u /* triangles of what is moved as one against overdraw */

typedef struct order {
	const uint32_t *indices;
	uint32_t *out;
	uint32_t count, vertex_count;
	uint32_t *first, *triangles; /* the triangles of vertex v: triangles[first[v]] .. */
	uint32_t *left;              /* triangles of a vertex that are not yet out */
	uint32_t *entered;           /* when a vertex came into the cache last; 0: never */
	uint32_t *recent;            /* vertices in the order of use, as a stack */
	uint8_t *done;
	uint32_t time, depth, scanned;
	uint32_t *clusters, cluster_count; /* first triangles, in the order out, of what is connected */
} order;

static bool order_allocate(order *o)
{
	size_t v = (size_t)o->vertex_count + 1, t = o->count / 3;
	o->first = calloc(v, sizeof *o->first);
	o->left = calloc(v, sizeof *o->left);
	o->entered = calloc(v, sizeof *o->entered);
	o->triangles = stilb_memory_alloc(3 * t, sizeof *o->triangles);
	o->recent = stilb_memory_alloc(3 * t, sizeof *o->recent);
	o->done = calloc(t + 1, 1);
	o->clusters = stilb_memory_alloc(t + 1, sizeof *o->clusters);
	return o->first && o->left && o->entered && o->triangles && o->recent && o->done && o->clusters;
}

static void order_finish(order *o)
{
	free(o->first);
	free(o->left);
	free(o->entered);
	free(o->triangles);
	free(o->recent);
	free(o->done);
	free(o->clusters);
}

static void order_adjacency(order *o)
{
	for (uint32_t i = 0; i < o->count; i++)
		o->left[o->indices[i]]++;
	uint32_t sum = 0;
	for (uint32_t v = 0; v < o->vertex_count; v++) {
		o->first[v] = sum;
		sum += o->left[v];
		o->left[v] = 0;
	}
	o->first[o->vertex_count] = sum;
	for (uint32_t i = 0; i < o->count; i++) {
		uint32_t v = o->indices[i];
		o->triangles[o->first[v] + o->left[v]++] = i / 3;
	}
}

/* The vertex to go on with: of those just used the oldest one that stays in the cache while its triangles are drawn;
 * else the last used one that has triangles left; else the next of all. Sets *jumped in the last two cases. */
static uint32_t order_next(order *o, const uint32_t *candidates, uint32_t count, bool *jumped)
{
	uint32_t best = NONE, priority = 0;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t v = candidates[i];
		if (o->left[v] == 0)
			continue;
		uint32_t age = o->time - o->entered[v], own = age + 2 * o->left[v] <= CACHE ? age + 1 : 1;
		if (own > priority) {
			priority = own;
			best = v;
		}
	}
	*jumped = best == NONE;
	while (best == NONE && o->depth > 0) {
		uint32_t v = o->recent[--o->depth];
		best = o->left[v] > 0 ? v : NONE;
	}
	for (; best == NONE && o->scanned < o->vertex_count; o->scanned++)
		best = o->left[o->scanned] > 0 ? o->scanned : NONE;
	return best;
}

static void order_fans(order *o)
{
	uint32_t out = 0, candidates[3 * 256];
	bool jumped = true;
	o->time = CACHE + 1;
	for (uint32_t v = order_next(o, NULL, 0, &jumped); v != NONE;) {
		uint32_t count = 0;
		if (jumped)
			o->clusters[o->cluster_count++] = out;
		for (uint32_t i = o->first[v]; i < o->first[v + 1]; i++) {
			uint32_t t = o->triangles[i];
			if (o->done[t])
				continue;
			o->done[t] = 1;
			for (uint32_t k = 0; k < 3; k++) {
				uint32_t w = o->indices[3 * t + k];
				o->out[3 * out + k] = w;
				o->recent[o->depth++] = w;
				if (count < sizeof candidates / sizeof *candidates)
					candidates[count++] = w;
				o->left[w]--;
				if (o->time - o->entered[w] > CACHE)
					o->entered[w] = o->time++;
			}
			out++;
		}
		v = order_next(o, candidates, count, &jumped);
	}
	STILB_ASSERT(out == o->count / 3 && "all triangles are out");
	o->clusters[o->cluster_count] = out;
}

/* ---- overdraw: what faces outwards comes first, since it hides what lies behind ---------------------------------- */

typedef struct order_cluster {
	uint32_t first, count;
	float outwards;
} order_cluster;

static int by_outwards(const void *a, const void *b)
{
	const order_cluster *l = a, *r = b;
	if (l->outwards != r->outwards)
		return l->outwards > r->outwards ? -1 : 1;
	return l->first < r->first ? -1 : 1;
}

typedef struct order_sum {
	double area, center[3], normal[3];
} order_sum;

static order_sum sum_triangles(const stilb_geometry_mesh *mesh, const uint32_t *indices, uint32_t count)
{
	order_sum sum = {0};
	for (uint32_t t = 0; t < count; t++) {
		const float *p[3];
		double e[2][3], n[3];
		for (int k = 0; k < 3; k++)
			p[k] = geometry_position(mesh, indices[3 * t + (uint32_t)k]);
		for (int axis = 0; axis < 3; axis++) {
			e[0][axis] = (double)p[1][axis] - (double)p[0][axis];
			e[1][axis] = (double)p[2][axis] - (double)p[0][axis];
		}
		for (int axis = 0; axis < 3; axis++)
			n[axis] = e[0][(axis + 1) % 3] * e[1][(axis + 2) % 3] - e[0][(axis + 2) % 3] * e[1][(axis + 1) % 3];
		double area = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		if (!isfinite(area))
			continue;
		sum.area += area;
		for (int axis = 0; axis < 3; axis++) {
			sum.center[axis] += area * ((double)p[0][axis] + (double)p[1][axis] + (double)p[2][axis]) / 3.0;
			sum.normal[axis] += n[axis];
		}
	}
	return sum;
}

static bool order_clusters(order *o, const stilb_geometry_mesh *mesh, uint32_t *indices)
{
	order_cluster *clusters = stilb_memory_alloc(o->cluster_count, sizeof *clusters);
	if (!clusters)
		return false;
	uint32_t count = 0;
	order_sum all = sum_triangles(mesh, o->out, o->count / 3);
	for (uint32_t i = 0; i < o->cluster_count;) {
		uint32_t first = o->clusters[i++];
		while (i < o->cluster_count && o->clusters[i] - first < CLUSTER_LEAST)
			i++;
		order_cluster *cluster = &clusters[count++];
		*cluster = (order_cluster){.first = first, .count = o->clusters[i] - first};
		order_sum own = sum_triangles(mesh, o->out + 3 * (size_t)first, cluster->count);
		double dot = 0.0, length = sqrt(own.normal[0] * own.normal[0] + own.normal[1] * own.normal[1] +
		                                own.normal[2] * own.normal[2]);
		for (int axis = 0; axis < 3 && own.area > 0.0 && length > 0.0; axis++)
			dot += (own.center[axis] / own.area - all.center[axis] / all.area) * own.normal[axis] / length;
		cluster->outwards = (float)dot;
	}
	qsort(clusters, count, sizeof *clusters, by_outwards);
	for (uint32_t i = 0; i < count; i++) {
		memcpy(indices, o->out + 3 * (size_t)clusters[i].first, (size_t)clusters[i].count * 12);
		indices += 3 * (size_t)clusters[i].count;
	}
	free(clusters);
	return true;
}

bool geometry_order(const stilb_geometry_mesh *mesh, uint32_t *indices, uint32_t count)
{
	if (count == 0)
		return true;
	order o = {.indices = indices, .count = count, .vertex_count = mesh->vertex_count};
	o.out = stilb_memory_alloc(count, sizeof *o.out);
	bool made = o.out && order_allocate(&o);
	if (made) {
		order_adjacency(&o);
		order_fans(&o);
		made = order_clusters(&o, mesh, indices);
	}
	order_finish(&o);
	free(o.out);
	return made;
}

/* ---- few triangles ----------------------------------------------------------------------------------------------- */

#define FEW 256u        /* triangles, at most */
#define FEW_TABLE 2048u /* more than twice their corners */

bool geometry_order_few(uint32_t (*triangles)[3], uint32_t count)
{
	STILB_ASSERT(count <= FEW);
	uint32_t table[FEW_TABLE], vertices[3 * FEW] = {0}, indices[3 * FEW] = {0}, out[3 * FEW] = {0};
	uint32_t *corners = (uint32_t *)triangles;
	order o = {.indices = indices, .out = out, .count = 3 * count};
	memset(table, 0xff, sizeof table);
	for (uint32_t i = 0; i < 3 * count; i++) {
		uint32_t vertex = corners[i], at = vertex * 2654435769u >> 21;
		while (table[at] != NONE && vertices[table[at]] != vertex)
			at = (at + 1) % FEW_TABLE;
		if (table[at] == NONE) {
			table[at] = o.vertex_count;
			vertices[o.vertex_count++] = vertex;
		}
		indices[i] = table[at];
	}
	bool made = order_allocate(&o);
	if (made) {
		order_adjacency(&o);
		order_fans(&o);
		for (uint32_t i = 0; i < 3 * count; i++)
			corners[i] = vertices[out[i]];
	}
	order_finish(&o);
	return made;
}
