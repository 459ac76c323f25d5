/* Clusters of large meshes: their upload and their choice. See render_clusters.h. */
#include "render/render_clusters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the mesh's clusters ----------------------------------------------------------------------------------------- */

static bool cluster_is_sound(const stilb_scene_mesh *mesh, uint32_t group, const stilb_scene_cluster *cluster)
{
	bool own = cluster->from == STILB_SCENE_NONE;
	uint32_t count = own ? mesh->index_count : mesh->cluster_index_count;
	return (own || cluster->from < group) && cluster->index_count > 0 && cluster->first_index <= count &&
	       cluster->index_count <= count - cluster->first_index;
}

stilb_result render_clusters_check(const stilb_scene_mesh *mesh)
{
	uint32_t clusters = 0;
	for (uint32_t g = 0; g < mesh->group_count; g++) {
		const stilb_scene_cluster_group *group = &mesh->groups[g];
		if (group->first_cluster != clusters || group->cluster_count > mesh->cluster_count - clusters)
			return stilb_fail(STILB_ERROR_ARGUMENT, "group %u of a mesh has %u clusters from %u on, not from %u of %u",
			                  g, group->cluster_count, group->first_cluster, clusters, mesh->cluster_count);
		for (uint32_t end = clusters + group->cluster_count; clusters < end; clusters++)
			if (!cluster_is_sound(mesh, g, &mesh->clusters[clusters]))
				return stilb_fail(STILB_ERROR_ARGUMENT,
				                  "cluster %u of a mesh, in group %u, has %u indices from %u on, and is from group %u",
				                  clusters, g, mesh->clusters[clusters].index_count,
				                  mesh->clusters[clusters].first_index, mesh->clusters[clusters].from);
	}
	if (clusters != mesh->cluster_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "the groups of a mesh have %u of its %u clusters", clusters,
		                  mesh->cluster_count);
	for (uint32_t i = 0; i < mesh->cluster_index_count; i++)
		if (mesh->cluster_indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "index %u of the clusters of a mesh is vertex %u, but it has %u", i,
			                  mesh->cluster_indices[i], mesh->vertex_count);
	return STILB_OK;
}

/* What is added to a sphere's radius: as much as scene_check_clusters lets it be too small, and rounding. */
static float clusters_radius(const float center[3], float radius)
{
	return radius * 1.0002f + (fabsf(center[0]) + fabsf(center[1]) + fabsf(center[2])) * 2e-6f;
}

#define CLUSTERS_CONE_MOST 256u /* triangles: larger clusters have no cone */

/* Fills in axis and spread: the mean of the triangles' normals, by area, and the one farthest from it. */
static void clusters_put_cone(const stilb_scene_mesh *mesh, const uint32_t *indices, render_cluster *out)
{
	stilb_vec3 normals[CLUSTERS_CONE_MOST], axis = {0};
	uint32_t count = out->index_count / 3;
	out->spread = 2.0f;
	if (count > CLUSTERS_CONE_MOST || !(out->radius > 0.0f))
		return;
	float scale = 1.0f / out->radius; /* so that no square underflows */
	for (uint32_t t = 0; t < count; t++) {
		stilb_vec3 p[3];
		for (uint32_t k = 0; k < 3; k++) {
			const float *at = mesh->vertices[indices[3 * t + k]].position;
			p[k] = stilb_vec3_make(at[0], at[1], at[2]) * scale;
		}
		normals[t] = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		axis += normals[t];
	}
	float square = stilb_vec3_dot(axis, axis), least = 1.0f; /* of the squares of the cosines */
	axis *= square > 0.0f ? 1.0f / sqrtf(square) : 0.0f;
	for (uint32_t t = 0; t < count; t++) {
		float along = stilb_vec3_dot(axis, normals[t]), length = stilb_vec3_dot(normals[t], normals[t]);
		if (length > 0.0f) /* else it has no sides */
			least = fminf(least, along * fabsf(along) / length);
	}
	for (int i = 0; i < 3; i++)
		out->axis[i] = axis[i];
	if (least > 1e-4f)
		out->spread = sqrtf(1.0f - least) + 1e-3f;
}

/* deepest: scratch, [group_count] the depth of each group's deepest cluster. */
static void clusters_fill(const stilb_scene_mesh *mesh, uint32_t coarser, uint32_t *deepest, render_clusters *out)
{
	for (uint32_t g = mesh->group_count; g < out->group_padded; g++) {
		out->x[g] = out->y[g] = out->z[g] = out->radius[g] = 0.0f;
		out->error[g] = NAN;
	}
	for (uint32_t g = 0; g < mesh->group_count; g++) {
		const stilb_scene_cluster_group *group = &mesh->groups[g];
		out->x[g] = group->center[0];
		out->y[g] = group->center[1];
		out->z[g] = group->center[2];
		out->radius[g] = clusters_radius(group->center, group->radius);
		out->error[g] = group->error < INFINITY ? group->error : NAN;
		out->first_cluster[g] = group->first_cluster;
		deepest[g] = 0;
		for (uint32_t c = group->first_cluster; c < group->first_cluster + group->cluster_count; c++) {
			const stilb_scene_cluster *from = &mesh->clusters[c];
			bool own = from->from == STILB_SCENE_NONE;
			out->clusters[c] = (render_cluster){.radius = clusters_radius(from->center, from->radius),
			                                    .first_index = own ? from->first_index : coarser + from->first_index,
			                                    .index_count = from->index_count,
			                                    .from = own ? mesh->group_count : from->from,
			                                    .depth = own ? 0 : deepest[from->from] + 1};
			memcpy(out->clusters[c].center, from->center, sizeof from->center);
			clusters_put_cone(mesh, (own ? mesh->indices : mesh->cluster_indices) + from->first_index,
			                  &out->clusters[c]);
			deepest[g] = out->clusters[c].depth > deepest[g] ? out->clusters[c].depth : deepest[g];
		}
		out->depth = deepest[g] > out->depth ? deepest[g] : out->depth;
	}
	out->first_cluster[mesh->group_count] = mesh->cluster_count;
}

render_clusters *render_clusters_make(const stilb_scene_mesh *mesh, uint32_t coarser)
{
	STILB_ASSERT(mesh->cluster_count > 0 && mesh->group_count > 0);
	size_t padded = (mesh->group_count / 32u + 1) * (size_t)32;
	render_clusters *out = stilb_memory_alloc(1, sizeof *out);
	render_cluster *clusters = stilb_memory_alloc(mesh->cluster_count, sizeof *clusters);
	float *groups = stilb_memory_alloc(5 * padded + mesh->group_count + 1, sizeof *groups);
	uint32_t *deepest = stilb_memory_alloc(mesh->group_count, sizeof *deepest);
	if (out && clusters && groups && deepest) {
		*out = (render_clusters){.cluster_count = mesh->cluster_count,
		                         .group_count = mesh->group_count,
		                         .group_padded = (uint32_t)padded,
		                         .coarser = coarser,
		                         .x = groups,
		                         .y = groups + padded,
		                         .z = groups + 2 * padded,
		                         .radius = groups + 3 * padded,
		                         .error = groups + 4 * padded,
		                         .first_cluster = (uint32_t *)(groups + 5 * padded),
		                         .clusters = clusters};
		clusters_fill(mesh, coarser, deepest, out);
		free(deepest);
		return out;
	}
	free(out);
	free(clusters);
	free(groups);
	free(deepest);
	return NULL;
}

void render_clusters_free(render_clusters *clusters)
{
	if (!clusters)
		return;
	free(clusters->x);
	free(clusters->clusters);
	free(clusters);
}

/* ---- the view ---------------------------------------------------------------------------------------------------- */

/* The largest factor by which the matrix stretches a vector, rounded up: the root of the largest eigenvalue of its
 * square. Source: O. K. Smith, "Eigenvalues of a symmetric 3 x 3 matrix", Communications of the ACM 4 (4), 1961. */
static float clusters_stretch(const stilb_mat4 *transform)
{
	double a[3][3];
	for (size_t i = 0; i < 3; i++)
		for (size_t j = 0; j < 3; j++) {
			const float *u = transform->m + 4 * i, *v = transform->m + 4 * j;
			a[i][j] = (double)u[0] * (double)v[0] + (double)u[1] * (double)v[1] + (double)u[2] * (double)v[2];
		}
	double mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0, p = 0.0;
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++) {
			a[i][j] -= i == j ? mean : 0.0;
			p += a[i][j] * a[i][j];
		}
	p = sqrt(p / 6.0);
	double most = mean;
	if (p > 0.0) {
		double determinant = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
		                     a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
		                     a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
		double half = determinant / (2.0 * p * p * p);
		most += 2.0 * p * cos(acos(half < -1.0 ? -1.0 : half > 1.0 ? 1.0 : half) / 3.0);
	}
	return (float)(sqrt(most > 0.0 ? most : 0.0) * (1.0 + 1e-6));
}

/* Finds the camera in the mesh's space. False: the transform has no inverse, or mirrors, and the device takes the other
 * side for the front. */
static bool clusters_camera(const stilb_mat4 *transform, const float position[3], float camera[3])
{
	const float *m = transform->m;
	double columns[3][3], rows[3][3], way[3];
	for (int i = 0; i < 3; i++) {
		way[i] = (double)position[i] - (double)m[12 + i];
		for (int j = 0; j < 3; j++)
			columns[i][j] = (double)m[4 * i + j];
	}
	for (int i = 0; i < 3; i++) { /* the adjugate: products of the other two columns */
		const double *a = columns[(i + 1) % 3], *b = columns[(i + 2) % 3];
		for (int j = 0; j < 3; j++)
			rows[i][j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3];
	}
	double determinant = 0.0;
	for (int i = 0; i < 3; i++)
		determinant += columns[0][i] * rows[0][i];
	if (!(determinant > 0.0))
		return false;
	bool finite = true;
	for (int i = 0; i < 3; i++) {
		camera[i] = (float)((rows[i][0] * way[0] + rows[i][1] * way[1] + rows[i][2] * way[2]) / determinant);
		finite &= (bool)isfinite(camera[i]);
	}
	return finite;
}

/* True if the view shows triangles from behind: what lies to the right of a camera, below and ahead of it is
 * right-handed. */
static bool clusters_mirrored(const stilb_mat4 *view_projection)
{
	const float *m = view_projection->m;
	stilb_vec3 right = stilb_vec3_make(m[0], m[4], m[8]), down = stilb_vec3_make(m[1], m[5], m[9]);
	return stilb_vec3_dot(stilb_vec3_cross(right, down), stilb_vec3_make(m[3], m[7], m[11])) < 0.0f;
}

render_cluster_view render_cluster_view_make(const render_detail_view *view, const stilb_render_view *seen,
                                             const stilb_mat4 *transform)
{
	const stilb_mat4 *view_projection = &seen->view_projection;
	render_cluster_view out = {.stretch = clusters_stretch(transform)};
	stilb_mat4 product;
	for (int column = 0; column < 4; column++)
		for (int row = 0; row < 4; row++) {
			double sum = 0.0;
			for (int k = 0; k < 4; k++)
				sum += (double)view_projection->m[4 * k + row] * (double)transform->m[4 * column + k];
			product.m[4 * column + row] = (float)sum;
		}
	out.frustum = stilb_frustum_from_matrix(&product);
	for (int p = 0; p < 6; p++)
		out.frustum.planes[p].distance += fabsf(out.frustum.planes[p].distance) * 2e-6f;
	bool perspective = view->constant == 0.0f;
	for (int row = 0; row < 3; row++) {
		for (int column = 0; column < 4; column++)
			out.rows[row][column] = transform->m[4 * column + row];
		out.rows[row][3] -= view->position[row];
	}
	STILB_ASSERT(view->scale >= 0.0f && "nothing suffices for a view without levels");
	out.backs = perspective && !seen->both_sides && !clusters_mirrored(view_projection) &&
	            clusters_camera(transform, view->position, out.camera);
	out.perspective = perspective ? 1.0f : 0.0f;
	out.reach = perspective ? out.stretch / sqrtf(view->scale) : out.stretch;
	out.near = perspective ? view->near : sqrtf(view->constant);
	return out;
}

/* ---- which groups suffice ---------------------------------------------------------------------------------------- */

/* e reach <= max(near, distance - radius), without a root. */
void render_clusters_suffice_scalar(const render_clusters *clusters, const render_cluster_view *view,
                                    uint32_t *suffices)
{
	for (uint32_t g = 0; g < clusters->group_padded; g++) {
		float square = 0.0f;
		for (int row = 0; row < 3; row++) {
			const float *m = view->rows[row];
			float along = m[0] * clusters->x[g] + m[1] * clusters->y[g] + (m[2] * clusters->z[g] + m[3]);
			square += along * along;
		}
		float from = clusters->error[g] * view->reach, far = from + clusters->radius[g] * view->stretch;
		bool enough = from <= view->near || far * far <= square * view->perspective;
		uint32_t bit = 1u << g % 32;
		suffices[g / 32] = (g % 32 == 0 ? 0 : suffices[g / 32]) | (enough ? bit : 0);
	}
	suffices[clusters->group_count / 32] |= 1u << clusters->group_count % 32;
}

#if defined(__SSE2__)
static inline __m128 clusters_along(const float m[4], __m128 x, __m128 y, __m128 z)
{
	__m128 xy = _mm_add_ps(_mm_mul_ps(_mm_set1_ps(m[0]), x), _mm_mul_ps(_mm_set1_ps(m[1]), y));
	__m128 along = _mm_add_ps(xy, _mm_add_ps(_mm_mul_ps(_mm_set1_ps(m[2]), z), _mm_set1_ps(m[3])));
	return _mm_mul_ps(along, along);
}

void render_clusters_suffice(const render_clusters *clusters, const render_cluster_view *view, uint32_t *suffices)
{
	render_cluster_view v = *view; /* a copy that no store changes */
	for (uint32_t w = 0; w < clusters->group_padded / 32; w++) {
		uint32_t word = 0;
		for (uint32_t g = 32 * w; g < 32 * w + 32; g += 4) {
			__m128 x = _mm_loadu_ps(clusters->x + g), y = _mm_loadu_ps(clusters->y + g);
			__m128 z = _mm_loadu_ps(clusters->z + g);
			__m128 square =
				_mm_add_ps(_mm_add_ps(clusters_along(v.rows[0], x, y, z), clusters_along(v.rows[1], x, y, z)),
			               clusters_along(v.rows[2], x, y, z));
			__m128 from = _mm_mul_ps(_mm_loadu_ps(clusters->error + g), _mm_set1_ps(v.reach));
			__m128 far = _mm_add_ps(from, _mm_mul_ps(_mm_loadu_ps(clusters->radius + g), _mm_set1_ps(v.stretch)));
			__m128 enough =
				_mm_or_ps(_mm_cmple_ps(from, _mm_set1_ps(v.near)),
			              _mm_cmple_ps(_mm_mul_ps(far, far), _mm_mul_ps(square, _mm_set1_ps(v.perspective))));
			word |= (uint32_t)_mm_movemask_ps(enough) << g % 32;
		}
		suffices[w] = word;
	}
	suffices[clusters->group_count / 32] |= 1u << clusters->group_count % 32;
}
#else
void render_clusters_suffice(const render_clusters *clusters, const render_cluster_view *view, uint32_t *suffices)
{
	render_clusters_suffice_scalar(clusters, view, suffices);
}
#endif

/* ---- what is drawn ----------------------------------------------------------------------------------------------- */

typedef enum clusters_place { CLUSTERS_OUTSIDE, CLUSTERS_PARTLY, CLUSTERS_INSIDE } clusters_place;

static inline clusters_place clusters_seen(const stilb_frustum *frustum, float x, float y, float z, float radius)
{
	bool inside = true;
	for (int p = 0; p < 6; p++) {
		const stilb_plane *plane = &frustum->planes[p];
		float distance = plane->x * x + plane->y * y + plane->z * z + plane->distance;
		if (distance < -radius)
			return CLUSTERS_OUTSIDE;
		inside = inside && distance >= radius;
	}
	return inside ? CLUSTERS_INSIDE : CLUSTERS_PARTLY;
}

static inline void clusters_add(render_cluster_cut *cut, const render_cluster *cluster, bool depths)
{
	uint32_t depth = depths ? cluster->depth : 0;
	render_cluster_range *last = cut->ranges + cut->range_count - 1;
	if (cut->range_count > 0 && last->first_index + last->index_count == cluster->first_index && last->depth == depth) {
		last->index_count += cluster->index_count;
		return;
	}
	cut->ranges[cut->range_count++] = (render_cluster_range){cluster->first_index, cluster->index_count, depth};
}

/* Adds the clusters of a group that does not suffice. */
static void clusters_add_group(const render_clusters *clusters, const render_cluster_view *view, uint32_t g,
                               bool depths, render_cluster_cut *cut)
{
	clusters_place place =
		clusters_seen(&view->frustum, clusters->x[g], clusters->y[g], clusters->z[g], clusters->radius[g]);
	if (place == CLUSTERS_OUTSIDE)
		return;
	for (uint32_t c = clusters->first_cluster[g]; c < clusters->first_cluster[g + 1]; c++) {
		const render_cluster *cluster = &clusters->clusters[c];
		const float *at = cluster->center;
		if ((cut->suffices[cluster->from / 32] >> cluster->from % 32 & 1) == 0)
			continue;
		if (place == CLUSTERS_PARTLY &&
		    clusters_seen(&view->frustum, at[0], at[1], at[2], cluster->radius) == CLUSTERS_OUTSIDE)
			continue;
		if (view->backs && render_cluster_is_back(view, cluster))
			continue;
		clusters_add(cut, cluster, depths);
	}
}

bool render_clusters_choose(const render_clusters *clusters, const render_cluster_view *view, bool depths,
                            render_cluster_cut *cut)
{
	cut->range_count = 0;
	if (!render_reserve((void **)&cut->suffices, &cut->word_capacity, clusters->group_padded / 32,
	                    sizeof *cut->suffices) ||
	    !render_reserve((void **)&cut->ranges, &cut->range_capacity, clusters->cluster_count, sizeof *cut->ranges))
		return false;
	render_clusters_suffice(clusters, view, cut->suffices);
	for (uint32_t w = 0; w < clusters->group_padded / 32; w++) {
		uint32_t there = clusters->group_count - 32 * w;
		uint32_t open = ~cut->suffices[w] & (there < 32 ? (1u << there) - 1 : UINT32_MAX);
		for (; open; open &= open - 1)
			clusters_add_group(clusters, view, 32 * w + (uint32_t)__builtin_ctz(open), depths, cut);
	}
	STILB_ASSERT(cut->range_count <= clusters->cluster_count);
	return true;
}

void render_cluster_cut_finish(render_cluster_cut *cut)
{
	free(cut->suffices);
	free(cut->ranges);
	*cut = (render_cluster_cut){0};
}
