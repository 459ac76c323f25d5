/* The hierarchy of clusters: clusters close to one another are a group; its triangles are halved with its border kept,
 * and become clusters again, which are in other groups with other neighbours. */
#include "geometry/geometry_clusters.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define RUN 65536u     /* triangles, in the order of a curve, that are split into clusters together */
#define BATCH 512u     /* groups between two questions whether all is given up */
#define PROGRESS 0.85f /* a group with more of its triangles left is not replaced; its clusters get other neighbours */
#define LEVELS 64u
#define LARGER 1.00001f /* errors and spheres are this much larger than those below, so that rounding tells no lie */

/* A cluster that no group has yet. */
typedef struct piece {
	uint32_t first, count; /* triangles of the pool */
	uint32_t from;         /* stilb_scene_cluster.from */
	float center[3], radius;
} piece;

typedef struct group_work {
	uint32_t first_piece, piece_count;
	uint32_t first, count; /* triangles, gathered */
	uint32_t (*coarse)[3]; /* [coarse_count]; NULL: it is not replaced */
	uint32_t coarse_count;
	piece *pieces; /* [new_count] of these */
	uint32_t new_count;
	float center[3], radius, error;
} group_work;

typedef struct build {
	geometry_work work;
	geometry_clusters *out;
	const geometry_clusters_desc *desc;
	geometry_round round;
	_Atomic uint32_t *owner; /* [vertex_count] of canonical vertices */
	/* the surface as it is now: clusters, and their triangles one after the other */
	uint32_t (*triangles)[3];
	piece *pieces;
	uint32_t triangle_count, piece_count;
	/* a level */
	uint32_t (*gathered)[3];
	piece *sorted; /* [piece_count] in the order of groups */
	geometry_spot *spots;
	group_work *groups;
	uint32_t group_count, batch;
	geometry_keyed *keyed, *curve;
	uint32_t level, leaf_count; /* triangles in out->indices so far */
	float error;                /* the largest of all groups so far */
	atomic_bool failed;         /* relaxed everywhere: the loop's end publishes it */
} build;

/* ---- places ------------------------------------------------------------------------------------------------------ */

static void middle_of(const stilb_geometry_mesh *mesh, const uint32_t vertex[3], float at[3])
{
	for (uint32_t axis = 0; axis < 3; axis++)
		at[axis] = (geometry_position(mesh, vertex[0])[axis] + geometry_position(mesh, vertex[1])[axis] +
		            geometry_position(mesh, vertex[2])[axis]) *
		           (1.0f / 3.0f);
}

static float distance_of(const float a[3], const float b[3])
{
	double x = (double)a[0] - (double)b[0], y = (double)a[1] - (double)b[1], z = (double)a[2] - (double)b[2];
	return (float)(sqrt(x * x + y * y + z * z) * (double)LARGER);
}

/* A sphere around triangles: about the middle of their box. */
static void sphere_of(const stilb_geometry_mesh *mesh, const uint32_t (*triangles)[3], uint32_t count, float center[3],
                      float *radius)
{
	const uint32_t *corners = (const uint32_t *)triangles;
	float lower[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, upper[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
	for (uint32_t i = 0; i < 3 * count; i++) {
		const float *at = geometry_position(mesh, corners[i]);
		for (uint32_t axis = 0; axis < 3; axis++) {
			lower[axis] = at[axis] < lower[axis] ? at[axis] : lower[axis];
			upper[axis] = at[axis] > upper[axis] ? at[axis] : upper[axis];
		}
	}
	for (uint32_t axis = 0; axis < 3; axis++)
		center[axis] = 0.5f * lower[axis] + 0.5f * upper[axis];
	float square = 0.0f;
	for (uint32_t i = 0; i < 3 * count; i++) {
		const float *at = geometry_position(mesh, corners[i]);
		float x = at[0] - center[0], y = at[1] - center[1], z = at[2] - center[2], own = x * x + y * y + z * z;
		square = own > square ? own : square;
	}
	*radius = sqrtf(square) * LARGER;
	if (!(square > 1e-30f)) /* too small for squares of floats */
		*radius = 0.5f * (upper[0] - lower[0] + upper[1] - lower[1] + upper[2] - lower[2]) * LARGER;
}

static uint32_t clusters_for(const build *b, uint32_t triangles)
{
	return triangles / b->desc->triangles + (triangles % b->desc->triangles != 0);
}

/* Splits triangles into clusters: sorts them, and describes as many pieces as they take. False: no memory. */
static bool split_triangles(const build *b, uint32_t (*triangles)[3], uint32_t count, uint32_t (*sorted)[3],
                            geometry_spot *spots, piece *pieces, uint32_t from)
{
	uint32_t parts = clusters_for(b, count);
	for (uint32_t t = 0; t < count; t++) {
		middle_of(b->work.mesh, triangles[t], spots[t].at);
		spots[t].id = t;
	}
	geometry_split(spots, count, parts, 0);
	for (uint32_t t = 0; t < count; t++)
		memcpy(sorted[t], triangles[spots[t].id], sizeof *sorted);
	for (uint32_t i = 0; i < parts; i++) {
		uint32_t begin = (uint32_t)((uint64_t)count * i / parts), end = (uint32_t)((uint64_t)count * (i + 1) / parts);
		pieces[i] = (piece){.first = begin, .count = end - begin, .from = from};
		sphere_of(b->work.mesh, (const uint32_t(*)[3])sorted + begin, end - begin, pieces[i].center, &pieces[i].radius);
		if (!geometry_order_few(sorted + begin, end - begin))
			return false;
	}
	return true;
}

/* ---- the mesh's own clusters ------------------------------------------------------------------------------------- */

static void key_mesh(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const build *b = context;
	float scale = b->work.extent > 0.0f ? 1023.0f / b->work.extent : 0.0f;
	for (uint32_t t = begin; t < end; t++) {
		float at[3];
		uint32_t cell[3];
		middle_of(b->work.mesh, b->work.triangles[t], at);
		for (uint32_t axis = 0; axis < 3; axis++) {
			float place = (at[axis] - b->work.lower[axis]) * scale;
			cell[axis] = place > 0.0f ? place < 1023.0f ? (uint32_t)place : 1023u : 0u;
		}
		b->keyed[t] = (geometry_keyed){geometry_morton(cell[0], cell[1], cell[2]), t};
	}
}

static void split_runs(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	build *b = context;
	geometry_spot *spots = stilb_memory_alloc(RUN, sizeof *spots);
	uint32_t(*own)[3] = stilb_memory_alloc(RUN, sizeof *own);
	bool made = spots && own;
	for (uint32_t run = begin; made && run < end; run++) {
		uint32_t first = run * RUN, count = b->triangle_count - first < RUN ? b->triangle_count - first : RUN;
		for (uint32_t t = 0; t < count; t++)
			memcpy(own[t], b->work.triangles[b->curve[first + t].value], sizeof *own);
		piece *pieces = b->pieces + (size_t)run * clusters_for(b, RUN);
		made = split_triangles(b, own, count, b->triangles + first, spots, pieces, STILB_SCENE_NONE);
		for (uint32_t i = 0; i < clusters_for(b, count); i++)
			pieces[i].first += first;
	}
	if (!made)
		atomic_store_explicit(&b->failed, true, memory_order_relaxed);
	free(spots);
	free(own);
}

/* Sorts the mesh's triangles by space and splits them into the first clusters. False: no memory. */
static bool split_mesh(build *b)
{
	geometry_work *work = &b->work;
	uint32_t runs = (work->count + RUN - 1) / RUN;
	b->triangle_count = work->count;
	b->piece_count = clusters_for(b, work->count);
	b->keyed = stilb_memory_alloc(work->count, 2 * sizeof *b->keyed);
	b->triangles = stilb_memory_alloc(work->count, sizeof *b->triangles);
	b->pieces = stilb_memory_alloc(b->piece_count, sizeof *b->pieces);
	bool made = b->keyed && b->triangles && b->pieces;
	if (made) {
		geometry_for(work->pool, work->worker, work->count, 8192, key_mesh, b);
		made = geometry_sort(work->pool, work->worker, b->keyed, b->keyed + work->count, work->count, 30, &b->curve);
	}
	if (made)
		geometry_for(work->pool, work->worker, runs, 1, split_runs, b);
	free(b->keyed);
	b->keyed = NULL;
	free(work->triangles);
	work->triangles = NULL;
	return made && !atomic_load_explicit(&b->failed, memory_order_relaxed);
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

static int by_from(const void *a, const void *b)
{
	const piece *l = a, *r = b;
	if (l->from != r->from)
		return l->from < r->from ? -1 : 1;
	return l->first < r->first ? -1 : 1;
}

/* Makes groups of clusters that are close to each other. False: no memory. */
static bool group_pieces(build *b)
{
	b->group_count = (b->piece_count + b->desc->clusters - 1) / b->desc->clusters;
	b->spots = stilb_memory_alloc(b->piece_count, sizeof *b->spots);
	b->sorted = stilb_memory_alloc(b->piece_count, sizeof *b->sorted);
	b->gathered = stilb_memory_alloc(b->triangle_count, sizeof *b->gathered);
	b->groups = calloc(b->group_count + 1u, sizeof *b->groups);
	if (!b->spots || !b->sorted || !b->gathered || !b->groups)
		return false;
	for (uint32_t i = 0; i < b->piece_count; i++) {
		memcpy(b->spots[i].at, b->pieces[i].center, sizeof b->spots[i].at);
		b->spots[i].id = i;
	}
	geometry_split(b->spots, b->piece_count, b->group_count, b->level + 1);
	uint32_t first = 0;
	for (uint32_t g = 0; g < b->group_count; g++) {
		group_work *group = &b->groups[g];
		group->first = first;
		group->first_piece = (uint32_t)((uint64_t)b->piece_count * g / b->group_count);
		group->piece_count = (uint32_t)((uint64_t)b->piece_count * (g + 1) / b->group_count) - group->first_piece;
		piece *pieces = b->sorted + group->first_piece;
		for (uint32_t i = 0; i < group->piece_count; i++) {
			pieces[i] = b->pieces[b->spots[group->first_piece + i].id];
			group->count += pieces[i].count;
		}
		qsort(pieces, group->piece_count, sizeof *pieces, by_from);
		first += group->count;
	}
	free(b->spots);
	b->spots = NULL;
	return true;
}

static void forget_owners(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const build *b = context;
	for (uint32_t v = begin; v < end; v++) /* relaxed: the loop's end publishes it */
		atomic_store_explicit(&b->owner[v], GEOMETRY_SHARED - 1, memory_order_relaxed);
}

/* Brings the triangles of groups together, and notes for each position the group that it is in, or that it is in
 * several. */
static void gather_groups(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const build *b = context;
	for (uint32_t g = begin; g < end; g++) {
		const group_work *group = &b->groups[g];
		uint32_t at = group->first;
		for (uint32_t i = 0; i < group->piece_count; i++) {
			piece *own = &b->sorted[group->first_piece + i];
			memcpy(b->gathered[at], b->triangles[own->first], own->count * sizeof *b->gathered);
			own->first = at;
			at += own->count;
		}
		const uint32_t *corners = (const uint32_t *)(b->gathered + group->first);
		for (uint32_t i = 0; i < 3 * group->count; i++) {
			_Atomic uint32_t *owner = &b->owner[b->work.canonical[corners[i]]];
			/* relaxed: only the value counts, which is the same in the end in whatever order groups come, and the
			 * loop's end publishes it */
			uint32_t now = atomic_load_explicit(owner, memory_order_relaxed);
			while (now != g && now != GEOMETRY_SHARED)
				if (atomic_compare_exchange_weak_explicit(owner, &now, now == GEOMETRY_SHARED - 1 ? g : GEOMETRY_SHARED,
				                                          memory_order_relaxed, memory_order_relaxed))
					break;
		}
	}
}

/* ---- replacing a group ------------------------------------------------------------------------------------------- */

/* Applies the collapses of a group to a copy of its triangles. Returns how many are left. */
static uint32_t apply_collapses(const build *b, const group_work *group, const geometry_record *record,
                                uint32_t (*coarse)[3])
{
	const geometry_work *work = &b->work;
	uint32_t maps = record->count > 0 ? record->maps_end[record->count - 1] : 0, count = 0;
	for (uint32_t i = maps; i-- > 0;) /* backwards: where a vertex goes to is known before it */
		work->target[record->from[i]] = work->target[record->to[i]];
	for (uint32_t t = 0; t < group->count; t++) {
		uint32_t p[3];
		for (uint32_t k = 0; k < 3; k++) {
			coarse[count][k] = work->target[b->gathered[group->first + t][k]];
			p[k] = work->canonical[coarse[count][k]];
		}
		count += p[0] != p[1] && p[1] != p[2] && p[0] != p[2];
	}
	for (uint32_t i = 0; i < maps; i++)
		work->target[record->from[i]] = record->from[i];
	return count;
}

/* Measures how far the group's triangles are from those that replace them. False: no memory. */
static bool measure_group(const build *b, const group_work *group, const geometry_record *record,
                          const uint32_t (*coarse)[3], uint32_t count, float *distance)
{
	geometry_replaced replaced = {.mesh = b->work.mesh,
	                              .canonical = b->work.canonical,
	                              .finer = (const uint32_t(*)[3])b->gathered + group->first,
	                              .finer_count = group->count,
	                              .coarser = coarse,
	                              .coarser_count = count,
	                              .gone = record->from,
	                              .gone_count = record->maps_end[record->count - 1]};
	return geometry_replaced_distance(&replaced, distance);
}

/* The sphere and the least error of a group, from its clusters and the groups that they are from. */
static void bound_group(const build *b, group_work *group)
{
	sphere_of(b->work.mesh, (const uint32_t(*)[3])b->gathered + group->first, group->count, group->center,
	          &group->radius);
	for (uint32_t i = 0; i < group->piece_count; i++) {
		const piece *own = &b->sorted[group->first_piece + i];
		if (own->from == STILB_SCENE_NONE)
			continue;
		const stilb_scene_cluster_group *from = &b->out->groups[own->from];
		group->radius = fmaxf(group->radius, (distance_of(from->center, group->center) + from->radius) * LARGER);
		group->error = fmaxf(group->error, from->error);
	}
}

/* Makes what replaces a group, if it has fewer triangles. False: no memory. */
static bool replace_group(const build *b, uint32_t g)
{
	group_work *group = &b->groups[g];
	geometry_record record;
	uint32_t(*coarse)[3] = stilb_memory_alloc(group->count, sizeof *coarse);
	geometry_spot *spots = stilb_memory_alloc(group->count, sizeof *spots);
	geometry_stop stop = {.triangles = group->count / 2, .cost = FLT_MAX};
	bool made = geometry_region_collapse(&b->round, g, (const uint32_t(*)[3])b->gathered + group->first, group->count,
	                                     stop, &record) &&
	            coarse && spots;
	uint32_t count = made ? apply_collapses(b, group, &record, coarse) : 0;
	bound_group(b, group);
	if (count > 0 && (float)count <= PROGRESS * (float)group->count) {
		float distance;
		group->coarse_count = count;
		group->new_count = clusters_for(b, count);
		group->coarse = stilb_memory_alloc(count, sizeof *group->coarse);
		group->pieces = stilb_memory_alloc(group->new_count, sizeof *group->pieces);
		made = group->coarse && group->pieces &&
		       measure_group(b, group, &record, (const uint32_t(*)[3])coarse, count, &distance);
		if (made) {
			group->error = (group->error + distance) * LARGER;
			made = split_triangles(b, coarse, count, group->coarse, spots, group->pieces, 0);
		}
	}
	geometry_record_finish(&record);
	free(spots);
	free(coarse);
	return made;
}

static void replace_groups(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	build *b = context;
	for (uint32_t g = begin; g < end; g++)
		if (!replace_group(b, b->batch + g))
			atomic_store_explicit(&b->failed, true, memory_order_relaxed);
}

/* ---- what has been made ------------------------------------------------------------------------------------------ */

/* Makes room for so many in the result. False: no memory. */
static bool reserve(geometry_clusters *out, uint64_t groups, uint64_t clusters, uint64_t indices)
{
	if (indices > UINT32_MAX || clusters > UINT32_MAX)
		return false;
	stilb_scene_cluster_group *more_groups = realloc(out->groups, (size_t)(groups + 1) * sizeof *more_groups);
	out->groups = more_groups ? more_groups : out->groups;
	stilb_scene_cluster *more_clusters = realloc(out->clusters, (size_t)(clusters + 1) * sizeof *more_clusters);
	out->clusters = more_clusters ? more_clusters : out->clusters;
	uint32_t *more_indices = realloc(out->cluster_indices, (size_t)(indices + 1) * sizeof *more_indices);
	out->cluster_indices = more_indices ? more_indices : out->cluster_indices;
	return more_groups && more_clusters && more_indices;
}

/* Adds a group that has been made, or that nothing replaces, to the result, which has room for it. */
static void write_group(build *b, const group_work *group, float error)
{
	geometry_clusters *out = b->out;
	stilb_scene_cluster_group *to = &out->groups[out->group_count++];
	*to = (stilb_scene_cluster_group){.radius = group->radius,
	                                  .error = error,
	                                  .first_cluster = out->cluster_count,
	                                  .cluster_count = group->piece_count};
	memcpy(to->center, group->center, sizeof to->center);
	for (uint32_t i = 0; i < group->piece_count; i++) {
		const piece *own = &b->sorted[group->first_piece + i];
		bool leaf = own->from == STILB_SCENE_NONE;
		uint32_t first = leaf ? 3 * b->leaf_count : out->cluster_index_count;
		stilb_scene_cluster *cluster = &out->clusters[out->cluster_count++];
		*cluster = (stilb_scene_cluster){
			.radius = own->radius, .first_index = first, .index_count = 3 * own->count, .from = own->from};
		memcpy(cluster->center, own->center, sizeof cluster->center);
		memcpy((leaf ? out->indices : out->cluster_indices) + first, b->gathered[own->first],
		       own->count * sizeof *b->gathered);
		if (leaf)
			b->leaf_count += own->count;
		else
			out->cluster_index_count += cluster->index_count;
	}
}

/* Makes room in the result for groups of this level, all or those that are replaced. False: no memory. */
static bool reserve_groups(build *b, bool all)
{
	geometry_clusters *out = b->out;
	uint64_t groups = out->group_count, clusters = out->cluster_count, indices = out->cluster_index_count;
	for (uint32_t g = 0; g < b->group_count; g++) {
		const group_work *group = &b->groups[g];
		if (!all && !group->coarse)
			continue;
		groups++;
		clusters += group->piece_count;
		for (uint32_t i = 0; i < group->piece_count; i++)
			if (b->sorted[group->first_piece + i].from != STILB_SCENE_NONE)
				indices += 3 * (uint64_t)b->sorted[group->first_piece + i].count;
	}
	return reserve(out, groups, clusters, indices);
}

/* Writes the groups that are replaced, and what replaces them becomes the surface, beside the clusters of the others.
 * False: no memory. */
static bool keep_level(build *b)
{
	uint32_t triangles = 0, pieces = 0;
	for (uint32_t g = 0; g < b->group_count; g++) {
		const group_work *group = &b->groups[g];
		triangles += group->coarse ? group->coarse_count : group->count;
		pieces += group->coarse ? group->new_count : group->piece_count;
	}
	free(b->triangles);
	free(b->pieces);
	b->triangles = stilb_memory_alloc(triangles, sizeof *b->triangles);
	b->pieces = stilb_memory_alloc(pieces, sizeof *b->pieces);
	if (!b->triangles || !b->pieces || !reserve_groups(b, false))
		return false;
	b->triangle_count = b->piece_count = 0;
	for (uint32_t g = 0; g < b->group_count; g++) {
		const group_work *group = &b->groups[g];
		const piece *from = group->coarse ? group->pieces : b->sorted + group->first_piece;
		uint32_t count = group->coarse ? group->new_count : group->piece_count, id = b->out->group_count;
		const uint32_t(*own)[3] = (const uint32_t(*)[3])(group->coarse ? group->coarse : b->gathered);
		if (group->coarse) {
			write_group(b, group, group->error);
			b->error = fmaxf(b->error, group->error);
		}
		for (uint32_t i = 0; i < count; i++) {
			piece *to = &b->pieces[b->piece_count++];
			*to = from[i];
			to->from = group->coarse ? id : to->from;
			to->first = b->triangle_count;
			memcpy(b->triangles[b->triangle_count], own[from[i].first], from[i].count * sizeof *own);
			b->triangle_count += from[i].count;
		}
	}
	return true;
}

static void level_finish(build *b)
{
	for (uint32_t g = 0; b->groups && g < b->group_count; g++) {
		free(b->groups[g].coarse);
		free(b->groups[g].pieces);
	}
	free(b->groups);
	free(b->sorted);
	free(b->spots);
	free(b->gathered);
	b->groups = NULL;
	b->sorted = NULL;
	b->spots = NULL;
	b->gathered = NULL;
}

/* ---- levels ------------------------------------------------------------------------------------------------------ */

static stilb_result build_no_memory(const build *b)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the clusters of a mesh of %u triangles",
	                  b->work.mesh->index_count / 3);
}

/* Replaces groups of the surface. */
static stilb_result replace_level(build *b)
{
	geometry_work *work = &b->work;
	bool made = group_pieces(b);
	if (made) {
		free(b->pieces);
		b->pieces = NULL;
		geometry_for(work->pool, work->worker, work->mesh->vertex_count, 65536, forget_owners, b);
		geometry_for(work->pool, work->worker, b->group_count, 16, gather_groups, b);
		free(b->triangles);
		b->triangles = NULL;
		work->count = b->triangle_count;
		geometry_round_scale(&b->round, work, work->count / 2);
	}
	for (b->batch = 0; made && b->batch < b->group_count; b->batch += BATCH) {
		uint32_t count = b->group_count - b->batch < BATCH ? b->group_count - b->batch : BATCH;
		geometry_for(work->pool, work->worker, count, 1, replace_groups, b);
		made = !atomic_load_explicit(&b->failed, memory_order_relaxed);
		if (b->desc->give_up && b->desc->give_up(b->desc->user))
			return stilb_fail(STILB_ERROR_GIVEN_UP, "the clusters of a mesh of %u triangles were given up",
			                  work->mesh->index_count / 3);
	}
	return made && keep_level(b) ? STILB_OK : build_no_memory(b);
}

/* Keeps the surface as it is now as the cut. False: no memory. */
static bool keep_cut(build *b)
{
	geometry_clusters *out = b->out;
	out->cut = stilb_memory_alloc(b->triangle_count, sizeof *b->triangles);
	if (!out->cut)
		return false;
	memcpy(out->cut, b->triangles, b->triangle_count * sizeof *b->triangles);
	out->cut_index_count = 3 * b->triangle_count;
	out->cut_error = b->error;
	return true;
}

/* What is left has no coarser version. False: no memory. */
static bool keep_roots(build *b)
{
	if (!group_pieces(b))
		return false;
	geometry_for(NULL, 0, b->group_count, 1, gather_groups, b);
	if (!reserve_groups(b, true))
		return false;
	for (uint32_t g = 0; g < b->group_count; g++) {
		bound_group(b, &b->groups[g]);
		write_group(b, &b->groups[g], INFINITY);
	}
	return true;
}

/* Writes the mesh's triangles of which nothing can be seen as a group that nothing at all replaces, at no error. False:
 * no memory. */
static bool write_unseen(build *b)
{
	const stilb_geometry_mesh *mesh = b->work.mesh;
	geometry_clusters *out = b->out;
	uint32_t first = 3 * b->leaf_count, at = first;
	for (uint32_t t = 0; t < mesh->index_count / 3; t++)
		if (!geometry_work_is_sound(&b->work, &mesh->indices[3 * (size_t)t])) {
			memcpy(out->indices + at, &mesh->indices[3 * (size_t)t], 3 * sizeof *mesh->indices);
			at += 3;
		}
	STILB_ASSERT(at == mesh->index_count && "each triangle is in one cluster");
	uint32_t triangles = (at - first) / 3, count = clusters_for(b, triangles);
	if (count == 0)
		return true;
	if (!reserve(out, out->group_count + 1ull, out->cluster_count + (uint64_t)count, out->cluster_index_count))
		return false;
	const uint32_t(*own)[3] = (const uint32_t(*)[3])(out->indices + first);
	stilb_scene_cluster_group *group = &out->groups[out->group_count++];
	*group = (stilb_scene_cluster_group){.first_cluster = out->cluster_count, .cluster_count = count};
	sphere_of(mesh, own, triangles, group->center, &group->radius);
	for (uint32_t i = 0; i < count; i++) {
		uint32_t begin = i * b->desc->triangles, left = triangles - begin;
		left = left < b->desc->triangles ? left : b->desc->triangles;
		stilb_scene_cluster *cluster = &out->clusters[out->cluster_count++];
		*cluster =
			(stilb_scene_cluster){.first_index = first + 3 * begin, .index_count = 3 * left, .from = STILB_SCENE_NONE};
		sphere_of(mesh, own + begin, cluster->index_count / 3, cluster->center, &cluster->radius);
	}
	return true;
}

static stilb_result build_make(build *b)
{
	geometry_clusters *out = b->out;
	out->indices = stilb_memory_alloc(b->work.mesh->index_count, sizeof *out->indices);
	b->owner = stilb_memory_alloc(b->work.mesh->vertex_count, sizeof *b->owner);
	if (!out->indices || !b->owner || !split_mesh(b))
		return build_no_memory(b);
	b->round = (geometry_round){.mesh = b->work.mesh,
	                            .canonical = b->work.canonical,
	                            .locked = b->work.locked,
	                            .owner = (const uint32_t *)b->owner};
	for (uint32_t stalled = 0; b->level < LEVELS && stalled < 2; b->level++) {
		if (!out->cut && b->triangle_count <= b->desc->cut_most && !keep_cut(b))
			return build_no_memory(b);
		if (b->piece_count <= b->desc->clusters)
			break;
		uint32_t before = b->triangle_count;
		stilb_result result = replace_level(b);
		level_finish(b);
		if (result != STILB_OK)
			return result;
		stalled = before - b->triangle_count < before / 20 + 1 ? stalled + 1 : 0;
	}
	if (out->group_count == 0)
		return STILB_OK; /* nothing can be replaced */
	bool made = (out->cut || keep_cut(b)) && keep_roots(b) && write_unseen(b);
	level_finish(b);
	return made ? STILB_OK : build_no_memory(b);
}

stilb_result geometry_clusters_make(const stilb_geometry_mesh *mesh, const geometry_clusters_desc *desc,
                                    stilb_job_pool *pool, uint32_t worker, geometry_clusters *clusters)
{
	*clusters = (geometry_clusters){0};
	build b = {.out = clusters, .desc = desc};
	stilb_result result = geometry_work_create(mesh, pool, worker, &b.work);
	if (result == STILB_OK)
		result = build_make(&b);
	level_finish(&b);
	free(b.keyed);
	free(b.owner);
	free(b.triangles);
	free(b.pieces);
	geometry_work_finish(&b.work);
	if (result != STILB_OK || clusters->group_count == 0)
		geometry_clusters_finish(clusters);
	return result;
}

void geometry_clusters_finish(geometry_clusters *clusters)
{
	free(clusters->clusters);
	free(clusters->groups);
	free(clusters->indices);
	free(clusters->cluster_indices);
	free(clusters->cut);
	*clusters = (geometry_clusters){0};
}
