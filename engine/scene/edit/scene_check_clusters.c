/* Are a mesh's clusters what scene.h says? */
#include "scene/edit/scene_check.h"

#include "scene/scene_internal.h"

#include <math.h>

#define CLUSTERS_SLACK 1.0001 /* spheres may be this much too small: rounding */

/* Indices that the clusters before have taken. */
typedef struct cluster_places {
	uint32_t own, coarser; /* in indices and in cluster_indices */
} cluster_places;

static bool sphere_is_sound(const float center[3], float radius)
{
	return scene_is_within(center, 3, -SCENE_FAR, SCENE_FAR) && radius >= 0.0f && radius <= SCENE_FAR;
}

/* True if the sphere of radius `inner` about p is inside the sphere of radius `outer` about center. */
static bool sphere_holds(const float center[3], float outer, const float p[3], float inner)
{
	double x = (double)p[0] - (double)center[0], y = (double)p[1] - (double)center[1];
	double z = (double)p[2] - (double)center[2];
	double size = fabs((double)center[0]) + fabs((double)center[1]) + fabs((double)center[2]);
	return sqrt(x * x + y * y + z * z) + (double)inner <= (double)outer * CLUSTERS_SLACK + size * 1e-6;
}

/* Cluster c of group g: where its indices are, and what they name. */
static stilb_result check_cluster(const stilb_scene_mesh *mesh, uint32_t g, uint32_t c, cluster_places *places,
                                  uint32_t id)
{
	const stilb_scene_cluster *cluster = &mesh->clusters[c];
	bool own = cluster->from == STILB_SCENE_NONE;
	uint32_t count = cluster->index_count, most = own ? mesh->index_count : mesh->cluster_index_count;
	uint32_t *first = own ? &places->own : &places->coarser;
	if (!own && cluster->from >= g)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: cluster %u of group %u is from group %u, not one before", id,
		                  c, g, cluster->from);
	if (count == 0 || count % 3 != 0 || cluster->first_index != *first || count > most - *first)
		return stilb_fail(
			STILB_ERROR_ARGUMENT,
			"mesh %u: cluster %u has %u indices from %u on; that takes a multiple of 3, and from %u, where "
			"the one before ends, up to %u",
			id, c, count, cluster->first_index, *first, most);
	if (!sphere_is_sound(cluster->center, cluster->radius))
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: cluster %u has a sphere of radius %g about %g, %g, %g", id, c,
		                  (double)cluster->radius, (double)cluster->center[0], (double)cluster->center[1],
		                  (double)cluster->center[2]);
	const uint32_t *indices = (own ? mesh->indices : mesh->cluster_indices) + *first;
	for (uint32_t i = 0; i < count; i++) {
		if (indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: index %u of cluster %u is vertex %u, but it has %u", id,
			                  i, c, indices[i], mesh->vertex_count);
		const float *position = mesh->vertices[indices[i]].position;
		if (!sphere_holds(cluster->center, cluster->radius, position, 0.0f) ||
		    !sphere_holds(mesh->groups[g].center, mesh->groups[g].radius, position, 0.0f))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: vertex %u of cluster %u is outside of its sphere or of that of its group %u",
			                  id, indices[i], c, g);
	}
	*first += count;
	return STILB_OK;
}

/* What group g says, against the groups that its clusters are from, whose places are known to be before it. */
static stilb_result check_group(const stilb_scene_mesh *mesh, uint32_t g, uint32_t id)
{
	const stilb_scene_cluster_group *group = &mesh->groups[g];
	for (uint32_t c = group->first_cluster; c < group->first_cluster + group->cluster_count; c++) {
		uint32_t from = mesh->clusters[c].from;
		if (from == STILB_SCENE_NONE)
			continue;
		const stilb_scene_cluster_group *finer = &mesh->groups[from];
		if (!(finer->error < INFINITY && group->error >= finer->error))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: group %u has an error of %g m, and cluster %u of it is from group %u with %g",
			                  id, g, (double)group->error, c, from, (double)finer->error);
		if (!sphere_holds(group->center, group->radius, finer->center, finer->radius))
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: the sphere of group %u is not around that of group %u",
			                  id, g, from);
	}
	return STILB_OK;
}

stilb_result scene_check_clusters(const stilb_scene_mesh *mesh, uint32_t id)
{
	uint32_t clusters = mesh->cluster_count, groups = mesh->group_count, indices = mesh->cluster_index_count;
	if (clusters == 0 && groups == 0 && indices == 0)
		return STILB_OK;
	if (clusters == 0 || groups == 0 || !mesh->clusters || !mesh->groups || (indices > 0 && !mesh->cluster_indices))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "mesh %u: %u clusters of %u indices in %u groups; some of these are missing", id, clusters,
		                  indices, groups);
	cluster_places places = {0};
	uint32_t next = 0;
	for (uint32_t g = 0; g < groups; g++) {
		const stilb_scene_cluster_group *group = &mesh->groups[g];
		if (group->cluster_count == 0 || group->first_cluster != next || group->cluster_count > clusters - next)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "mesh %u: group %u has %u clusters from %u on; it takes some, from %u on, of %u", id, g,
			                  group->cluster_count, group->first_cluster, next, clusters);
		if (!sphere_is_sound(group->center, group->radius) || !(group->error >= 0.0f))
			return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: group %u has a radius of %g m and an error of %g m", id,
			                  g, (double)group->radius, (double)group->error);
		stilb_result result = STILB_OK;
		for (uint32_t end = next + group->cluster_count; next < end && result == STILB_OK; next++)
			result = check_cluster(mesh, g, next, &places, id);
		if (result == STILB_OK)
			result = check_group(mesh, g, id);
		if (result != STILB_OK)
			return result;
	}
	if (next != clusters || places.own != mesh->index_count || places.coarser != indices)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "mesh %u: its groups have %u of %u clusters, and these %u of its %u indices and %u of %u", id,
		                  next, clusters, places.own, mesh->index_count, places.coarser, indices);
	return STILB_OK;
}
