/* Plans: what they are made of, and how a mesh gets one. */
#include "geometry/geometry_plan.h"

#include <stdlib.h>
#include <string.h>

bool geometry_plan_allocate(geometry_plan *plan)
{
	plan->levels = stilb_memory_alloc(plan->level_count, sizeof *plan->levels);
	plan->order = stilb_memory_alloc(plan->vertex_count, sizeof *plan->order);
	plan->to = plan->cluster_count == 0 ? stilb_memory_alloc(plan->vertex_count, sizeof *plan->to) : NULL;
	plan->indices = stilb_memory_alloc(plan->index_count, sizeof *plan->indices);
	plan->level_indices = stilb_memory_alloc(plan->level_index_count, sizeof *plan->level_indices);
	plan->clusters = stilb_memory_alloc(plan->cluster_count, sizeof *plan->clusters);
	plan->groups = stilb_memory_alloc(plan->group_count, sizeof *plan->groups);
	plan->cluster_indices = stilb_memory_alloc(plan->cluster_index_count, sizeof *plan->cluster_indices);
	return plan->levels && plan->order && (plan->to || plan->cluster_count > 0) && plan->indices &&
	       plan->level_indices && plan->clusters && plan->groups && plan->cluster_indices;
}

void geometry_plan_finish(geometry_plan *plan)
{
	free(plan->levels);
	free(plan->order);
	free(plan->to);
	free(plan->indices);
	free(plan->level_indices);
	free(plan->clusters);
	free(plan->groups);
	free(plan->cluster_indices);
	*plan = (geometry_plan){0};
}

void geometry_plan_parts(const geometry_plan *plan, geometry_plan_part parts[GEOMETRY_PLAN_PARTS])
{
	size_t v = plan->vertex_count, morphs = plan->cluster_count == 0 ? v : 0;
	const geometry_plan_part all[GEOMETRY_PLAN_PARTS] = {
		{plan->levels, plan->level_count * sizeof *plan->levels},
		{plan->order, v * sizeof *plan->order},
		{plan->to, morphs * sizeof *plan->to},
		{plan->indices, plan->index_count * sizeof *plan->indices},
		{plan->level_indices, plan->level_index_count * sizeof *plan->level_indices},
		{plan->clusters, plan->cluster_count * sizeof *plan->clusters},
		{plan->groups, plan->group_count * sizeof *plan->groups},
		{plan->cluster_indices, plan->cluster_index_count * sizeof *plan->cluster_indices}};
	memcpy(parts, all, sizeof all);
}

/* ---- giving it to a mesh ----------------------------------------------------------------------------------------- */

stilb_result geometry_plan_apply(geometry_plan *plan, stilb_scene_mesh *mesh)
{
	if (plan->level_count == 0 && plan->cluster_count == 0) {
		stilb_scene_mesh_drop_levels(mesh);
		return STILB_OK;
	}
	STILB_ASSERT(plan->vertex_count == mesh->vertex_count && plan->index_count == mesh->index_count);
	stilb_scene_mesh out = {.vertex_count = plan->vertex_count, .index_count = plan->index_count};
	out.vertices = stilb_memory_alloc(out.vertex_count, sizeof *out.vertices);
	if (plan->to)
		out.morph = stilb_memory_alloc(out.vertex_count, sizeof *out.morph);
	if (mesh->extras)
		out.extras = stilb_memory_alloc(out.vertex_count, sizeof *out.extras);
	if (!out.vertices || (plan->to && !out.morph) || (mesh->extras && !out.extras)) {
		stilb_scene_mesh_finish(&out);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of a mesh of %u triangles",
		                  mesh->index_count / 3);
	}
	for (uint32_t v = 0; v < out.vertex_count; v++) {
		out.vertices[v] = mesh->vertices[plan->order[v]];
		if (out.extras)
			out.extras[v] = mesh->extras[plan->order[v]];
		if (out.morph)
			out.morph[v] = mesh->vertices[plan->to[v]];
	}
	out.indices = plan->indices;
	out.level_count = plan->level_count;
	out.level_index_count = plan->level_index_count;
	out.levels = plan->levels;
	out.level_indices = plan->level_indices;
	out.cluster_count = plan->cluster_count;
	out.group_count = plan->group_count;
	out.cluster_index_count = plan->cluster_index_count;
	out.clusters = plan->clusters;
	out.groups = plan->groups;
	out.cluster_indices = plan->cluster_indices;
	if (out.cluster_count == 0) { /* members that count nothing point nowhere */
		free(out.clusters);
		free(out.groups);
		free(out.cluster_indices);
		out.clusters = NULL;
		out.groups = NULL;
		out.cluster_indices = NULL;
	}
	free(plan->order);
	free(plan->to);
	*plan = (geometry_plan){0};
	stilb_scene_mesh_finish(mesh);
	*mesh = out;
	return STILB_OK;
}
