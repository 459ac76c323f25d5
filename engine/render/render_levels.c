/* Levels of meshes as the heaps hold them. */
#include "render/render_clusters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

stilb_result render_levels_check(const stilb_scene_mesh *mesh)
{
	if (mesh->level_count > STILB_SCENE_MAX_LEVELS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a mesh with %u levels; at most %u are possible", mesh->level_count,
		                  STILB_SCENE_MAX_LEVELS);
	float error = 0.0f;
	for (uint32_t l = 0; l < mesh->level_count; l++) {
		const stilb_scene_level *level = &mesh->levels[l];
		if (level->index_count == 0 || level->first_index > mesh->level_index_count ||
		    level->index_count > mesh->level_index_count - level->first_index ||
		    level->vertex_count > mesh->vertex_count || !(level->error >= error) || !isfinite(level->error))
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "level %u of a mesh has %u indices from %u of %u, %u of its %u vertices, and an error of "
			                  "%g m after %g",
			                  l, level->index_count, level->first_index, mesh->level_index_count, level->vertex_count,
			                  mesh->vertex_count, (double)level->error, (double)error);
		error = level->error;
		for (uint32_t i = 0; i < level->index_count; i++)
			if (mesh->level_indices[level->first_index + i] >= level->vertex_count)
				return stilb_fail(STILB_ERROR_ARGUMENT, "index %u of level %u of a mesh is vertex %u, but it has %u", i,
				                  l, mesh->level_indices[level->first_index + i], level->vertex_count);
	}
	return render_clusters_check(mesh);
}

/* The indices of a level, 0: of the mesh in full. */
static const uint32_t *levels_source(const stilb_scene_mesh *mesh, uint32_t level, uint32_t *count)
{
	*count = level == 0 ? mesh->index_count : mesh->levels[level - 1].index_count;
	return level == 0 ? mesh->indices : mesh->level_indices + mesh->levels[level - 1].first_index;
}

/* How many of the mesh's vertices a level uses, 0: the mesh in full. */
static uint32_t levels_vertices(const stilb_scene_mesh *mesh, uint32_t level)
{
	return level == 0 ? mesh->vertex_count : mesh->levels[level - 1].vertex_count;
}

/* How many levels have 32 bit indices, the mesh in full counted: the first, since no level uses more vertices than the
 * one before it. With clusters the mesh in full is one of them. */
static uint32_t levels_wide(const stilb_scene_mesh *mesh, bool pairs)
{
	uint32_t wide = mesh->cluster_count > 0 ? 1 : 0;
	while (wide <= mesh->level_count && levels_vertices(mesh, wide) > RENDER_NARROW_VERTICES >> pairs)
		wide++;
	return wide;
}

/* Adds a level's indices to those so far; with pairs they count pairs, and those of vertices from `moving` on name the
 * second of a pair. at: the next place for indices of 32 and of 16 bits. */
static render_level levels_copy(const stilb_scene_mesh *mesh, uint32_t level, uint32_t moving, bool pairs,
                                render_levels_data *data, uint32_t at[2])
{
	uint32_t count;
	const uint32_t *from = levels_source(mesh, level, &count);
	bool narrow = level >= data->levels->wide;
	uint32_t first = at[narrow];
	for (uint32_t i = 0; i < count; i++) {
		uint32_t index = pairs ? 2 * from[i] + (from[i] >= moving) : from[i];
		if (narrow)
			data->narrow[first + i] = (uint16_t)index;
		else
			data->indices[first + i] = index;
	}
	at[narrow] += count;
	return (render_level){.index_count = count, .instance_count = 1, .first_index = first};
}

static void levels_put_vertices(const stilb_scene_mesh *mesh, stilb_scene_vertex *out)
{
	uint32_t kept = mesh->levels[mesh->level_count - 1].vertex_count;
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		out[2 * (size_t)v] = mesh->vertices[v];
		out[2 * (size_t)v + 1] = v < kept ? mesh->vertices[v] : mesh->morph[v];
	}
}

/* The bits of a float, which for positive ones grow with it: as its logarithm to the base 2 does at powers of 2, and in
 * a straight line between them. */
static int32_t levels_bits(float value)
{
	int32_t bits;
	memcpy(&bits, &value, sizeof bits);
	return bits;
}

/* Where each level begins to morph to the next: where the next one's error is twice what is allowed, or if that is
 * before the level itself begins, there. */
static void levels_put_begins(render_levels *levels)
{
	const float *squared = render_levels_squared(levels);
	render_morph *begins = (render_morph *)render_levels_begins(levels);
	for (uint32_t l = 0; l <= levels->count; l++) {
		float most =
			l > 0 && l < levels->count && squared[l] < 4.0f * squared[l - 1] ? squared[l] / squared[l - 1] : 4.0f;
		int32_t begin = levels_bits(most), length = begin - levels_bits(1.0f);
		begins[l] = (render_morph){begin, length > 0 ? 64.0f / (float)length : 0.0f};
	}
}

/* Fills in levels and indices. */
static void levels_put(const stilb_scene_mesh *mesh, bool pairs, render_levels_data *data)
{
	render_levels *levels = data->levels;
	float *squared = (float *)(levels + 1);
	render_level *level = (render_level *)(squared + (size_t)4 * levels->groups);
	uint32_t *vertices = (uint32_t *)render_levels_vertices(levels);
	uint32_t at[2] = {0, 0};
	for (uint32_t l = 0; l < levels->count; l++)
		vertices[l] = mesh->levels[l].vertex_count;
	for (uint32_t l = 0; l < 4 * levels->groups; l++)
		squared[l] = l < levels->count ? mesh->levels[l].error * mesh->levels[l].error : INFINITY;
	for (uint32_t l = 0; l <= levels->count; l++)
		level[l] = levels_copy(mesh, l, UINT32_MAX, pairs, data, at);
	for (uint32_t l = 0; l < levels->count && pairs; l++)
		level[levels->count + 1 + l] = levels_copy(mesh, l, mesh->levels[l].vertex_count, true, data, at);
	if (mesh->cluster_index_count > 0)
		memcpy(data->indices + at[0], mesh->cluster_indices, mesh->cluster_index_count * sizeof *data->indices);
	STILB_ASSERT(at[0] + mesh->cluster_index_count == data->index_count && at[1] == data->narrow_count);
	levels_put_begins(levels);
}

bool render_levels_make(const stilb_scene_mesh *mesh, bool morph, render_levels_data *data)
{
	bool pairs = morph && mesh->morph && mesh->cluster_count == 0; /* from clusters there is nothing to morph to */
	uint32_t count = mesh->level_count, groups = count / 4 + 1;    /* one infinite error at least */
	uint32_t all = pairs ? 2 * count + 1 : count + 1;
	uint32_t wide = levels_wide(mesh, pairs);
	uint64_t indices[2] = {0, 0}; /* of 32 bits, of 16 bits */
	for (uint32_t l = 0; l <= count; l++) {
		uint64_t own = l == 0 ? mesh->index_count : mesh->levels[l - 1].index_count;
		indices[l >= wide] += pairs && l < count ? 2 * own : own;
	}
	uint32_t coarser = indices[0] < INT32_MAX ? (uint32_t)indices[0] : 0;
	indices[0] += mesh->cluster_index_count;
	uint64_t vertices = pairs ? 2 * (uint64_t)mesh->vertex_count : mesh->vertex_count;
	*data = (render_levels_data){.vertices = mesh->vertices};
	if (indices[0] > INT32_MAX || indices[1] > INT32_MAX || vertices > INT32_MAX)
		return false;
	data->vertex_count = (uint32_t)vertices;
	data->index_count = (uint32_t)indices[0];
	data->narrow_count = (uint32_t)indices[1];
	data->vertices = pairs ? stilb_memory_alloc(vertices, sizeof *data->vertices) : mesh->vertices;
	data->indices = stilb_memory_alloc(indices[0], sizeof *data->indices);
	data->narrow = stilb_memory_alloc(indices[1], sizeof *data->narrow);
	data->levels =
		stilb_memory_alloc(1, sizeof *data->levels + (size_t)4 * groups * sizeof(float) + all * sizeof(render_level) +
	                              count * sizeof(uint32_t) + (count + 1) * sizeof(render_morph));
	render_clusters *clusters = mesh->cluster_count > 0 ? render_clusters_make(mesh, coarser) : NULL;
	if (!data->vertices || !data->indices || !data->narrow || !data->levels ||
	    !clusters != (mesh->cluster_count == 0)) {
		free(data->levels);
		render_clusters_free(clusters);
		render_levels_finish(data, mesh);
		return false;
	}
	*data->levels =
		(render_levels){.count = count, .groups = groups, .morphs = pairs, .wide = wide, .clusters = clusters};
	levels_put(mesh, pairs, data);
	if (pairs)
		levels_put_vertices(mesh, data->vertices);
	return true;
}

void render_levels_free(render_levels *levels)
{
	if (levels)
		render_clusters_free(levels->clusters);
	free(levels);
}

void render_levels_finish(render_levels_data *data, const stilb_scene_mesh *mesh)
{
	if (data->vertices != mesh->vertices)
		free(data->vertices);
	free(data->indices);
	free(data->narrow);
	*data = (render_levels_data){0};
}
