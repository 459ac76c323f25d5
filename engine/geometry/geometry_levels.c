#include "geometry/geometry_levels.h"

#include "geometry/geometry_clusters.h"
#include "geometry/geometry_plan.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

stilb_geometry_levels_desc stilb_geometry_levels_desc_default(void)
{
	stilb_geometry_levels_desc desc = {.ratio = 0.5f, .least = 20, .cluster_least = 100000};
	for (uint32_t s = 0; s < STILB_SCENE_VERTEX_STREAMS; s++)
		desc.weights[s] = stilb_scene_vertex_streams.streams[s].weight;
	return desc;
}

/* ---- with clusters ----------------------------------------------------------------------------------------------- */

/* A mesh of the cut alone, of which levels are made as of any other. */
typedef struct cut_mesh {
	stilb_scene_mesh mesh;
	uint8_t *locked;
	uint32_t *vertex; /* [mesh.vertex_count] its vertices in the whole mesh */
	uint32_t *number; /* [vertex_count of the whole mesh] the number there in the end; NONE: not known yet */
	geometry_plan plan;
} cut_mesh;

static void cut_finish(cut_mesh *cut)
{
	stilb_scene_mesh_finish(&cut->mesh);
	free(cut->locked);
	free(cut->vertex);
	free(cut->number);
	geometry_plan_finish(&cut->plan);
}

/* Copies the cut. False: no memory. */
static bool cut_copy(const stilb_scene_mesh *mesh, const geometry_clusters *clusters, const uint8_t *locked,
                     cut_mesh *cut)
{
	uint32_t count = clusters->cut_index_count, used = 0;
	cut->number = stilb_memory_alloc(mesh->vertex_count, sizeof *cut->number);
	cut->mesh.indices = stilb_memory_alloc(count, sizeof *cut->mesh.indices);
	if (!cut->number || !cut->mesh.indices)
		return false;
	cut->mesh.index_count = count;
	memset(cut->number, 0xff, mesh->vertex_count * sizeof *cut->number);
	for (uint32_t i = 0; i < count; i++) {
		uint32_t *number = &cut->number[clusters->cut[i]];
		if (*number == NONE)
			*number = used++;
		cut->mesh.indices[i] = *number;
	}
	cut->mesh.vertices = stilb_memory_alloc(used, sizeof *cut->mesh.vertices);
	cut->vertex = stilb_memory_alloc(used, sizeof *cut->vertex);
	cut->mesh.extras = mesh->extras ? stilb_memory_alloc(used, sizeof *cut->mesh.extras) : NULL;
	cut->locked = locked ? stilb_memory_alloc(used, sizeof *cut->locked) : NULL;
	if (!cut->mesh.vertices || !cut->vertex || (locked && !cut->locked) || (mesh->extras && !cut->mesh.extras))
		return false;
	cut->mesh.vertex_count = used;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t v = clusters->cut[i], own = cut->mesh.indices[i];
		cut->vertex[own] = v;
		cut->mesh.vertices[own] = mesh->vertices[v];
		if (mesh->extras)
			cut->mesh.extras[own] = mesh->extras[v];
		if (locked)
			cut->locked[own] = locked[v];
	}
	return true;
}

/* Numbers the vertices: those of levels first, in their order, then what clusters add, the coarsest first. */
static void number_vertices(const geometry_clusters *clusters, cut_mesh *cut, geometry_plan *plan)
{
	uint32_t next = 0, vertex_count = plan->vertex_count, *number = cut->number;
	for (; next < cut->mesh.vertex_count; next++) {
		uint32_t v = cut->vertex[cut->plan.level_count > 0 ? cut->plan.order[next] : next];
		number[v] = next;
		plan->order[next] = v;
	}
	for (uint32_t c = clusters->cluster_count; c-- > 0;) {
		const stilb_scene_cluster *cluster = &clusters->clusters[c];
		const uint32_t *indices =
			(cluster->from == STILB_SCENE_NONE ? clusters->indices : clusters->cluster_indices) + cluster->first_index;
		for (uint32_t i = 0; i < cluster->index_count; i++)
			if (number[indices[i]] == NONE) {
				number[indices[i]] = next;
				plan->order[next++] = indices[i];
			}
	}
	for (uint32_t v = 0; v < vertex_count; v++)
		if (number[v] == NONE) {
			number[v] = next;
			plan->order[next++] = v;
		}
}

typedef struct renumber {
	const uint32_t *number;
	uint32_t *indices;
} renumber;

static void renumber_indices(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const renumber *r = context;
	for (uint32_t i = begin; i < end; i++)
		r->indices[i] = r->number[r->indices[i]];
}

/* The cut as the first level, and its own levels after that. */
static void write_levels(const cut_mesh *cut, float error, geometry_plan *plan)
{
	const uint32_t *first = cut->plan.level_count > 0 ? cut->plan.indices : cut->mesh.indices;
	uint32_t count = cut->mesh.index_count;
	plan->levels[0] = (stilb_scene_level){
		.first_index = 0, .index_count = count, .vertex_count = cut->mesh.vertex_count, .error = error};
	memcpy(plan->level_indices, first, count * sizeof *first);
	for (uint32_t l = 1; l < plan->level_count; l++) {
		plan->levels[l] = cut->plan.levels[l - 1];
		plan->levels[l].first_index += count;
		plan->levels[l].error += error;
	}
	memcpy(plan->level_indices + count, cut->plan.level_indices,
	       (plan->level_index_count - count) * sizeof *plan->level_indices);
}

/* Makes the plan of clusters and of the levels of the cut; the clusters' arrays go to the plan. False: no memory. */
static bool write_clusters(const stilb_scene_mesh *mesh, stilb_job_pool *pool, uint32_t worker,
                           geometry_clusters *clusters, cut_mesh *cut, geometry_plan *plan)
{
	uint32_t levels = cut->plan.level_count;
	levels = levels < STILB_SCENE_MAX_LEVELS ? levels : STILB_SCENE_MAX_LEVELS - 1;
	*plan = (geometry_plan){.vertex_count = mesh->vertex_count,
	                        .index_count = mesh->index_count,
	                        .level_count = levels + 1,
	                        .level_index_count = cut->mesh.index_count,
	                        .cluster_count = clusters->cluster_count,
	                        .group_count = clusters->group_count,
	                        .cluster_index_count = clusters->cluster_index_count};
	for (uint32_t l = 0; l < levels; l++)
		plan->level_index_count += cut->plan.levels[l].index_count;
	plan->order = stilb_memory_alloc(plan->vertex_count, sizeof *plan->order);
	plan->levels = stilb_memory_alloc(plan->level_count, sizeof *plan->levels);
	plan->level_indices = stilb_memory_alloc(plan->level_index_count, sizeof *plan->level_indices);
	if (!plan->order || !plan->levels || !plan->level_indices)
		return false;
	number_vertices(clusters, cut, plan);
	renumber own = {cut->number, clusters->indices}, coarser = {cut->number, clusters->cluster_indices};
	geometry_for(pool, worker, plan->index_count, 65536, renumber_indices, &own);
	geometry_for(pool, worker, plan->cluster_index_count, 65536, renumber_indices, &coarser);
	write_levels(cut, clusters->cut_error, plan);
	plan->clusters = clusters->clusters;
	plan->groups = clusters->groups;
	plan->indices = clusters->indices;
	plan->cluster_indices = clusters->cluster_indices;
	clusters->clusters = NULL;
	clusters->groups = NULL;
	clusters->indices = clusters->cluster_indices = NULL;
	return true;
}

/* Makes the plan of a mesh with clusters; {0} if none can be made. */
static stilb_result make_clusters(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                  stilb_job_pool *pool, uint32_t worker, geometry_plan *plan)
{
	stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS];
	stilb_geometry_mesh view = geometry_view_of(mesh, desc, streams);
	geometry_clusters_desc own = {.cut_most = desc->cluster_least,
	                              .triangles = GEOMETRY_CLUSTER_MOST,
	                              .clusters = GEOMETRY_GROUP_MOST,
	                              .give_up = desc->give_up,
	                              .user = desc->user};
	geometry_clusters clusters;
	stilb_result result = geometry_clusters_make(&view, &own, pool, worker, &clusters);
	if (result != STILB_OK || clusters.cluster_count == 0)
		return result;
	cut_mesh cut = {0};
	bool made = cut_copy(mesh, &clusters, desc->locked, &cut);
	if (made) {
		stilb_geometry_levels_desc levels = *desc;
		levels.locked = cut.locked;
		result = geometry_chain_make(&cut.mesh, &levels, pool, worker, &cut.plan);
	}
	if (made && result == STILB_OK)
		made = write_clusters(mesh, pool, worker, &clusters, &cut, plan);
	if (!made)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the clusters of a mesh of %u triangles",
		                    mesh->index_count / 3);
	cut_finish(&cut);
	geometry_clusters_finish(&clusters);
	if (result != STILB_OK)
		geometry_plan_finish(plan);
	return result;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

/* Positions at which colours of vertices differ stay: a patch of one colour has no gradient, so the simplifier does not
 * see its border move. *locked: to be freed; NULL if there are none. */
static stilb_result lock_colors(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, uint8_t **locked)
{
	stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS];
	stilb_geometry_mesh view = geometry_view_of(mesh, desc, streams);
	bool colors = false, differ = false;
	for (uint32_t s = 0; s < view.stream_count; s++)
		colors |= streams[s].kind == STILB_GEOMETRY_VALUE;
	*locked = NULL;
	if (!colors)
		return STILB_OK;
	uint8_t *made = stilb_memory_alloc(mesh->vertex_count, sizeof *made);
	uint32_t *same = stilb_memory_alloc(mesh->vertex_count, sizeof *same);
	bool memory = made && same && geometry_weld(&view, NULL, 0, same);
	for (uint32_t v = 0; memory && v < mesh->vertex_count; v++) {
		made[v] = desc->locked ? desc->locked[v] : 0;
		if (memcmp(mesh->extras[v].color, mesh->extras[same[v]].color, sizeof mesh->extras->color) != 0)
			made[v] = made[same[v]] = differ = true;
	}
	free(same);
	if (memory && differ)
		*locked = made;
	else
		free(made);
	return memory ? STILB_OK
	              : stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of %u vertices", mesh->vertex_count);
}

stilb_result geometry_plan_make(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                stilb_job_pool *pool, uint32_t worker, geometry_plan *plan)
{
	*plan = (geometry_plan){0};
	stilb_geometry_levels_desc own = *desc;
	uint8_t *locked = NULL;
	stilb_result result = mesh->extras && mesh->vertex_count > 0 ? lock_colors(mesh, desc, &locked) : STILB_OK;
	own.locked = locked ? locked : desc->locked;
	if (result == STILB_OK && mesh->index_count / 3 > desc->cluster_least)
		result = make_clusters(mesh, &own, pool, worker, plan);
	if (result == STILB_OK && plan->cluster_count == 0)
		result = geometry_chain_make(mesh, &own, pool, worker, plan);
	free(locked);
	return result;
}

stilb_result geometry_levels_check(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc)
{
	if (!(desc->ratio >= 0.1f && desc->ratio <= 0.9f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "levels of %g times the triangles: it takes 0.1 to 0.9",
		                  (double)desc->ratio);
	stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS];
	stilb_geometry_mesh view = geometry_view_of(mesh, desc, streams);
	return geometry_mesh_check(&view);
}

stilb_result stilb_geometry_levels(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, stilb_job_pool *pool,
                                   uint32_t worker)
{
	STILB_ASSERT(mesh && desc);
	geometry_plan plan = {0};
	stilb_result result = geometry_levels_check(mesh, desc);
	if (result == STILB_OK)
		result = geometry_plan_make(mesh, desc, pool, worker, &plan);
	if (result == STILB_OK)
		result = geometry_plan_apply(&plan, mesh);
	geometry_plan_finish(&plan);
	return result;
}
