/* Meshes with clusters, and what is drawn of them. */
#ifndef GEOMETRY_CUTS_MADE_H
#define GEOMETRY_CUTS_MADE_H

#include "geometry/geometry_clusters.h"
#include "geometry/mesh_made.h"

static inline stilb_geometry_mesh view_of(const stilb_scene_mesh *mesh, stilb_geometry_stream streams[2])
{
	streams[0] = (stilb_geometry_stream){
		"normal", STILB_GEOMETRY_DIRECTION, 3, 0.15f, false, mesh->vertices->normal, sizeof *mesh->vertices};
	streams[1] = (stilb_geometry_stream){
		"uv", STILB_GEOMETRY_TEXTURE, 2, 0.1f, true, mesh->vertices->uv, sizeof *mesh->vertices};
	return (stilb_geometry_mesh){.vertex_count = mesh->vertex_count,
	                             .index_count = mesh->index_count,
	                             .indices = mesh->indices,
	                             .positions = mesh->vertices->position,
	                             .position_stride = sizeof *mesh->vertices,
	                             .stream_count = 2,
	                             .streams = streams};
}

static const geometry_clusters_desc small_desc = {.cut_most = 300, .triangles = 16, .clusters = 8};

/* Gives the mesh small clusters. False: it can have none. */
static inline bool make_clusters(stilb_scene_mesh *mesh)
{
	stilb_geometry_stream streams[2];
	stilb_geometry_mesh view = view_of(mesh, streams);
	geometry_clusters clusters;
	assert_int_equal(geometry_clusters_make(&view, &small_desc, NULL, 0, &clusters), STILB_OK);
	if (clusters.cluster_count == 0)
		return false;
	assert_int_equal(clusters.cut_index_count % 3, 0);
	assert_in_range(clusters.cut_index_count, 3, mesh->index_count);
	memcpy(mesh->indices, clusters.indices, mesh->index_count * sizeof *mesh->indices);
	mesh->cluster_count = clusters.cluster_count;
	mesh->group_count = clusters.group_count;
	mesh->cluster_index_count = clusters.cluster_index_count;
	mesh->clusters = clusters.clusters;
	mesh->groups = clusters.groups;
	mesh->cluster_indices = clusters.cluster_indices;
	free(clusters.cut);
	free(clusters.indices);
	return true;
}

/* ---- cuts -------------------------------------------------------------------------------------------------------- */

typedef struct cut {
	uint8_t *suffices;        /* [group_count] */
	uint32_t *indices, *from; /* of each index the group that its cluster is from */
	uint32_t count;
	float error; /* the largest of groups that are replaced */
} cut;

static inline cut cut_create(const stilb_scene_mesh *mesh)
{
	cut c = {.suffices = calloc(mesh->group_count, 1)};
	c.indices = calloc(mesh->index_count + mesh->cluster_index_count, sizeof *c.indices);
	c.from = calloc(mesh->index_count + mesh->cluster_index_count, sizeof *c.from);
	assert_non_null(c.suffices);
	assert_non_null(c.indices);
	assert_non_null(c.from);
	return c;
}

static inline void cut_finish(cut *c)
{
	free(c->suffices);
	free(c->indices);
	free(c->from);
}

/* Chooses groups, by their errors as seen from a point, or by chance alone, and lists what is drawn. */
static inline void cut_choose(const stilb_scene_mesh *mesh, uint32_t number, cut *c)
{
	const float *eye = mesh->vertices[stilb_random_u64(1, number) % mesh->vertex_count].position;
	float limit = powf(10.0f, -5.0f + 5.0f * stilb_random_float(2, number)), chance = stilb_random_float(3, number);
	c->count = 0;
	c->error = 0.0f;
	for (uint32_t g = 0; g < mesh->group_count; g++) {
		const stilb_scene_cluster_group *group = &mesh->groups[g];
		float square = 0.0f;
		for (int axis = 0; axis < 3; axis++)
			square += (group->center[axis] - eye[axis]) * (group->center[axis] - eye[axis]);
		float near = fmaxf(sqrtf(square) - group->radius, 0.01f);
		bool suffices = number % 2 == 0
		                    ? group->error <= limit * near
		                    : group->error < INFINITY && stilb_random_float(4 + number, g) < 1.0f - 0.3f * chance;
		for (uint32_t i = group->first_cluster; i < group->first_cluster + group->cluster_count; i++) {
			uint32_t from = mesh->clusters[i].from;
			if (number % 2 == 0) /* errors and spheres ascend, so that no other rule is needed */
				assert_true(!suffices || from == STILB_SCENE_NONE || c->suffices[from]);
			suffices = suffices && (from == STILB_SCENE_NONE || c->suffices[from]);
		}
		c->suffices[g] = suffices;
		if (suffices)
			c->error = fmaxf(c->error, group->error);
		for (uint32_t i = group->first_cluster; i < group->first_cluster + group->cluster_count && !suffices; i++) {
			const stilb_scene_cluster *cluster = &mesh->clusters[i];
			if (cluster->from != STILB_SCENE_NONE && !c->suffices[cluster->from])
				continue;
			const uint32_t *indices = cluster->from == STILB_SCENE_NONE ? mesh->indices : mesh->cluster_indices;
			memcpy(c->indices + c->count, indices + cluster->first_index, cluster->index_count * sizeof *indices);
			for (uint32_t k = 0; k < cluster->index_count; k++)
				c->from[c->count++] = cluster->from;
		}
	}
}

static inline uint32_t *canonical_of(const stilb_scene_mesh *mesh)
{
	uint32_t *canonical = malloc(sizeof *canonical * (mesh->vertex_count + 1));
	assert_non_null(canonical);
	stilb_geometry_mesh view = {.vertex_count = mesh->vertex_count,
	                            .positions = mesh->vertices->position,
	                            .position_stride = sizeof *mesh->vertices};
	assert_true(geometry_weld(&view, NULL, 0, canonical));
	return canonical;
}

static inline stilb_scene_mesh torus_of(uint32_t w, uint32_t h)
{
	stilb_scene_mesh mesh = mesh_grid(w, h, mesh_place_torus);
	uint32_t *canonical = canonical_of(&mesh);
	mesh_smooth(&mesh, canonical);
	free(canonical);
	return mesh;
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/* Each cluster's triangles are within the error of the group that they are from; no point of the mesh is farther from
 * the cut than the largest error in it. */
static inline void check_errors(const stilb_scene_mesh *mesh, uint32_t cuts, uint32_t points)
{
	cut c = cut_create(mesh);
	for (uint32_t i = 0, checked = 0; checked < cuts; i++) {
		cut_choose(mesh, 2 * i, &c);
		if (c.error == 0.0f)
			continue; /* the mesh itself */
		checked++;
		float back = mesh_farthest(mesh, mesh->indices, mesh->index_count, c.indices, c.count, points, i);
		if (!(back <= c.error))
			print_message("cut %u: %g > %g\n", i, (double)back, (double)c.error);
		assert_true(back <= c.error);
		for (uint32_t first = 0, end; first < c.count; first = end) {
			for (end = first; end < c.count && c.from[end] == c.from[first];)
				end++;
			if (c.from[first] == STILB_SCENE_NONE)
				continue;
			float error = mesh->groups[c.from[first]].error;
			float there = mesh_farthest(mesh, c.indices + first, end - first, mesh->indices, mesh->index_count,
			                            (uint32_t)((uint64_t)points * (end - first) / c.count), i);
			if (!(there <= error))
				print_message("cut %u, from group %u: %g > %g\n", i, c.from[first], (double)there, (double)error);
			assert_true(there <= error);
		}
	}
	cut_finish(&c);
}

#endif
