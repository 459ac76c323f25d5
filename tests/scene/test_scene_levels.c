/* Levels and clusters of meshes: the spheres' own levels, their errors against sampled distances, copies, and what is
 * refused. */
#include "scene/edit/scene_edit.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the sphere's levels ----------------------------------------------------------------------------------------- */

/* A surface of triangles about the origin. */
typedef struct surface {
	const stilb_scene_vertex *vertices;
	const uint32_t *indices;
	uint32_t index_count;
} surface;

static surface level_surface(const stilb_scene_mesh *mesh, uint32_t level)
{
	if (level == 0)
		return (surface){mesh->vertices, mesh->indices, mesh->index_count};
	const stilb_scene_level *l = &mesh->levels[level - 1];
	return (surface){mesh->vertices, mesh->level_indices + l->first_index, l->index_count};
}

static void corner(const surface *s, uint32_t index, double p[3])
{
	for (int i = 0; i < 3; i++)
		p[i] = (double)s->vertices[s->indices[index]].position[i];
}

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double squared_to_segment(const double p[3], const double a[3], const double b[3])
{
	double ab[3], ap[3], away[3];
	for (int i = 0; i < 3; i++) {
		ab[i] = b[i] - a[i];
		ap[i] = p[i] - a[i];
	}
	double t = fmin(fmax(dot(ap, ab) / dot(ab, ab), 0.0), 1.0);
	for (int i = 0; i < 3; i++)
		away[i] = ap[i] - t * ab[i];
	return dot(away, away);
}

/* The squared distance of a point from a triangle: of its projection if that lies inside, else of the nearest edge. */
static double squared_to_triangle(const double p[3], double c[3][3])
{
	double u[3], v[3], w[3], n[3];
	for (int i = 0; i < 3; i++) {
		u[i] = c[1][i] - c[0][i];
		v[i] = c[2][i] - c[0][i];
		w[i] = p[i] - c[0][i];
	}
	for (int i = 0; i < 3; i++)
		n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
	double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v), det = uu * vv - uv * uv;
	double s = (vv * wu - uv * wv) / det, t = (uu * wv - uv * wu) / det;
	if (s >= 0.0 && t >= 0.0 && s + t <= 1.0)
		return dot(w, n) * dot(w, n) / dot(n, n);
	return fmin(squared_to_segment(p, c[0], c[1]),
	            fmin(squared_to_segment(p, c[1], c[2]), squared_to_segment(p, c[2], c[0])));
}

static double distance_to(const surface *s, const double p[3])
{
	double least = (double)INFINITY;
	for (uint32_t i = 0; i < s->index_count; i += 3) {
		double c[3][3];
		for (uint32_t k = 0; k < 3; k++)
			corner(s, i + k, c[k]);
		least = fmin(least, squared_to_triangle(p, c));
	}
	return sqrt(least);
}

/* The largest distance of a grid of points of each of a's triangles from b. */
static double farthest(const surface *a, const surface *b, int side)
{
	double most = 0.0;
	for (uint32_t i = 0; i < a->index_count; i += 3) {
		double c[3][3], p[3];
		for (uint32_t k = 0; k < 3; k++)
			corner(a, i + k, c[k]);
		for (int x = 0; x <= side; x++)
			for (int y = 0; x + y <= side; y++) {
				for (int k = 0; k < 3; k++)
					p[k] = (c[0][k] * x + c[1][k] * y + c[2][k] * (side - x - y)) / side;
				most = fmax(most, distance_to(b, p));
			}
	}
	return most;
}

static void errors_are_true_and_tight(void **state)
{
	(void)state;
	for (uint32_t splits = 1; splits <= (TEST_ASAN ? 1u : 2u); splits++) {
		stilb_scene_mesh mesh;
		assert_int_equal(stilb_scene_mesh_sphere(splits, &mesh), STILB_OK);
		assert_int_equal(mesh.level_count, splits + 1);
		surface full = level_surface(&mesh, 0);
		for (uint32_t l = 1; l <= splits + 1; l++) {
			surface coarse = level_surface(&mesh, l);
			double there = farthest(&full, &coarse, 2), back = farthest(&coarse, &full, 2 << l);
			double error = (double)mesh.levels[l - 1].error, most = fmax(there, back);
			if (most > error || most < 0.9 * error)
				fail_msg("%u splits, level %u: %g there and %g back, stated %g", splits, l, there, back, error);
		}
		stilb_scene_mesh_finish(&mesh);
	}
}

/* Every edge of a level is used once in each direction, and bends outwards: it is closed and convex. */
static void assert_closed_and_convex(const surface *s)
{
	for (uint32_t i = 0; i < s->index_count; i++) {
		uint32_t next = i % 3 == 2 ? i - 2 : i + 1, a = s->indices[i], b = s->indices[next], twins = 0;
		for (uint32_t j = 0; j < s->index_count; j++) {
			uint32_t after = j % 3 == 2 ? j - 2 : j + 1, across = j % 3 == 0 ? j + 2 : j - 1;
			if (s->indices[j] != b || s->indices[after] != a)
				continue;
			twins++;
			double c[3][3], p[3], u[3], v[3], n[3];
			corner(s, i, c[0]);
			corner(s, next, c[1]);
			corner(s, i % 3 == 0 ? i + 2 : i - 1, c[2]);
			corner(s, across, p);
			for (int k = 0; k < 3; k++) {
				u[k] = c[1][k] - c[0][k];
				v[k] = c[2][k] - c[0][k];
				p[k] -= c[0][k];
			}
			for (int k = 0; k < 3; k++)
				n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
			assert_true(dot(n, p) < 0.0);
		}
		assert_int_equal(twins, 1);
	}
}

/* Asserts that level l + 1 of a sphere is the sphere of fewer splits. */
static void assert_level_is_sphere(const stilb_scene_mesh *mesh, uint32_t l, uint32_t splits)
{
	stilb_scene_mesh alone;
	const stilb_scene_level *level = &mesh->levels[l];
	assert_int_equal(stilb_scene_mesh_sphere(splits, &alone), STILB_OK);
	assert_int_equal(level->index_count, alone.index_count);
	assert_int_equal(level->vertex_count, alone.vertex_count);
	assert_memory_equal(mesh->level_indices + level->first_index, alone.indices,
	                    alone.index_count * sizeof *alone.indices);
	assert_memory_equal(mesh->vertices, alone.vertices, alone.vertex_count * sizeof *alone.vertices);
	stilb_scene_mesh_finish(&alone);
}

static void levels_are_spheres_of_fewer_splits_and_an_octahedron(void **state)
{
	(void)state;
	for (uint32_t splits = 0; splits <= 6; splits++) {
		stilb_scene_mesh mesh;
		assert_int_equal(stilb_scene_mesh_sphere(splits, &mesh), STILB_OK);
		uint32_t count = splits > 0 ? splits + 1 : 0;
		assert_int_equal(mesh.level_count, count);
		float error = 0.0f;
		for (uint32_t l = 0; l < count; l++) {
			assert_true(mesh.levels[l].error > error);
			error = mesh.levels[l].error;
			if (l < splits)
				assert_level_is_sphere(&mesh, l, splits - 1 - l);
			surface s = level_surface(&mesh, l + 1);
			if (s.index_count <= 960)
				assert_closed_and_convex(&s);
		}
		if (count > 0) {
			assert_int_equal(mesh.levels[splits].index_count, 24);
			assert_int_equal(mesh.levels[splits].vertex_count, 6);
		}
		stilb_scene_mesh_finish(&mesh);
		assert_null(mesh.levels);
	}
}

/* With the vertices of the last split where they morph to, the four triangles lie on the one that they came from, and
 * have its normals and uv. */
static void vertices_morph_onto_the_coarser_level(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(3, &mesh), STILB_OK);
	for (uint32_t l = 1; l <= 3; l++) {
		surface fine = level_surface(&mesh, l - 1), coarse = level_surface(&mesh, l);
		uint32_t kept = mesh.levels[l - 1].vertex_count;
		for (uint32_t i = 0; i < fine.index_count; i++) {
			uint32_t v = fine.indices[i], matches = 0;
			if (v < kept)
				continue;
			const uint32_t *parent = coarse.indices + i / 12 * 3;
			for (int k = 0; k < 3; k++) {
				const float *a = (const float *)&mesh.vertices[parent[k]];
				const float *b = (const float *)&mesh.vertices[parent[(k + 1) % 3]];
				const float *m = (const float *)&mesh.morph[v];
				bool same = true;
				for (int f = 0; f < 8; f++)
					same &= m[f] == 0.5f * (a[f] + b[f]);
				matches += same;
			}
			assert_int_equal(matches, 1);
		}
	}
	stilb_scene_mesh_finish(&mesh);
}

/* The six vertices that only the icosahedron has move along edges onto those of the octahedron, and the 8 triangles
 * that are left are the coarsest level's. */
static void the_icosahedron_morphs_onto_the_octahedron(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(1, &mesh), STILB_OK);
	surface fine = level_surface(&mesh, 1), coarse = level_surface(&mesh, 2);
	uint32_t to[12], left = 0;
	for (uint32_t v = 0; v < 12; v++) {
		to[v] = v;
		for (uint32_t k = 0; k < 6 && v >= 6; k++)
			if (memcmp(&mesh.morph[v], &mesh.vertices[k], sizeof mesh.morph[v]) == 0)
				to[v] = k;
		assert_true(to[v] < 6);
		double way = 0.0;
		for (int i = 0; i < 3; i++)
			way += pow((double)mesh.vertices[v].position[i] - (double)mesh.vertices[to[v]].position[i], 2.0);
		assert_true(v < 6 || fabs(sqrt(way) - 1.0514622242382672) < 1e-6); /* an edge of the icosahedron */
	}
	for (uint32_t t = 0; t < fine.index_count; t += 3) {
		uint32_t a = to[fine.indices[t]], b = to[fine.indices[t + 1]], c = to[fine.indices[t + 2]], same = 0;
		if (a == b || b == c || c == a)
			continue;
		for (uint32_t u = 0; u < coarse.index_count; u += 3)
			for (uint32_t k = 0; k < 3; k++)
				same += coarse.indices[u + k] == a && coarse.indices[u + (k + 1) % 3] == b &&
				        coarse.indices[u + (k + 2) % 3] == c;
		assert_int_equal(same, 1);
		left++;
	}
	assert_int_equal(left, 8);
	stilb_scene_mesh_finish(&mesh);
}

/* ---- scenes of programs ------------------------------------------------------------------------------------------ */

static void assert_levels_equal(const stilb_scene_mesh *a, const stilb_scene_mesh *b)
{
	assert_int_equal(a->level_count, b->level_count);
	assert_int_equal(a->level_index_count, b->level_index_count);
	assert_true(a->levels != b->levels && a->level_indices != b->level_indices && a->morph != b->morph);
	assert_memory_equal(a->levels, b->levels, a->level_count * sizeof *a->levels);
	assert_memory_equal(a->level_indices, b->level_indices, a->level_index_count * sizeof *a->level_indices);
	assert_memory_equal(a->morph, b->morph, a->vertex_count * sizeof *a->morph);
}

static void scenes_copy_levels(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	stilb_scene *scene;
	uint32_t added;
	assert_int_equal(stilb_scene_mesh_sphere(2, &mesh), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	assert_int_equal(stilb_scene_build_mesh(build, &mesh), 0);
	stilb_scene_vertex *morph = mesh.morph;
	mesh.morph = NULL; /* it may be unknown */
	assert_int_equal(stilb_scene_build_mesh(build, &mesh), 1);
	mesh.morph = morph;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_levels_equal(&scene->meshes[0], &mesh);
	assert_int_equal(scene->meshes[1].level_count, 3);
	assert_null(scene->meshes[1].morph);
	assert_int_equal(stilb_scene_add_mesh(scene, &mesh, &added), STILB_OK);
	assert_levels_equal(&scene->meshes[added], &mesh);
	assert_int_equal(stilb_scene_set_mesh(scene, 1, &mesh), STILB_OK);
	assert_levels_equal(&scene->meshes[1], &mesh);
	stilb_scene_destroy(scene);
	stilb_scene_mesh_finish(&mesh);
}

/* Vertices that have moved take the levels with them, and the mesh is listed as a whole once; then its ranges are. */
static void moved_vertices_drop_levels(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(4, 1, &scene), STILB_OK);
	stilb_scene_vertex vertex = scene->meshes[0].vertices[5];
	assert_int_equal(scene->meshes[0].level_count, 3);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 5, 0, &vertex), STILB_OK); /* none: nothing changes */
	assert_int_equal(scene->meshes[0].level_count, 3);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 5, 1, &vertex), STILB_OK);
	assert_int_equal(scene->meshes[0].level_count, 0);
	assert_null(scene->meshes[0].morph);
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	assert_int_equal(changes.mesh_count, 1);
	assert_int_equal(changes.vertices_count, 0);
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 7, 1, &vertex), STILB_OK);
	changes = stilb_scene_changes_read(scene);
	assert_int_equal(changes.mesh_count, 0);
	assert_int_equal(changes.vertices_count, 1);
	stilb_scene_destroy(scene);
}

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

static stilb_scene_mesh wrong; /* a sphere, in which a test spoils something */

static void refuses(const char *words)
{
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_mesh(build, &wrong);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), words))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), words);
}

/* Spoils a member for one check. */
#define refuses_with(member, value, words)                                                                             \
	do {                                                                                                               \
		__auto_type before = member;                                                                                   \
		member = value;                                                                                                \
		refuses(words);                                                                                                \
		member = before;                                                                                               \
	} while (0)

static void mistakes_are_named(void **state)
{
	(void)state;
	assert_int_equal(stilb_scene_mesh_sphere(2, &wrong), STILB_OK);
	stilb_scene_level *fine = &wrong.levels[0], *coarse = &wrong.levels[1];
	refuses_with(wrong.level_count, 0, "mesh 0: 0 levels of 324 indices");
	refuses_with(wrong.level_count, 33, "33 levels of 324 indices; there are 1..32");
	refuses_with(wrong.levels, NULL, "3 levels of 324 indices");
	refuses_with(wrong.level_indices, NULL, "3 levels of 324 indices");
	refuses_with(fine->index_count, 960, "its level 0 has 960 indices; that takes a multiple of 3 below the finer");
	refuses_with(fine->index_count, 241, "its level 0 has 241 indices");
	refuses_with(coarse->index_count, 0, "its level 1 has 0 indices");
	refuses_with(coarse->index_count, 240, "its level 1 has 240 indices");
	refuses_with(fine->first_index, 85, "indices 85 to 324 of its level 0; its levels have 324");
	refuses_with(fine->first_index, UINT32_MAX, "of its level 0; its levels have 324");
	refuses_with(fine->vertex_count, 163, "its level 0 has 163 vertices, the finer one 162");
	refuses_with(coarse->vertex_count, 0, "its level 1 has 0 vertices");
	refuses_with(coarse->vertex_count, 11, "is vertex 11, but it has 11");
	refuses_with(fine->error, NAN, "the error of its level 0 is nan m");
	refuses_with(fine->error, -1.0f, "the error of its level 0 is -1 m, the finer one's 0");
	refuses_with(coarse->error, 0.01f, "the error of its level 1 is 0.01 m");
	refuses_with(coarse->error, INFINITY, "the error of its level 1 is inf m");
	refuses_with(wrong.level_indices[24 + 3], 12, "index 3 of its level 1 is vertex 12, but it has 12");
	refuses_with(wrong.level_indices[3], 6, "index 3 of its level 2 is vertex 6, but it has 6");
	refuses_with(wrong.morph[12].position[1], NAN, "vertex 12 morphs to what is no vertex");
	refuses_with(wrong.morph[161].normal[0], 1.1f, "vertex 161 morphs to what is no vertex");
	refuses_with(wrong.morph[161].uv[0], INFINITY, "vertex 161 morphs to what is no vertex");
	wrong.morph[5].uv[0] = NAN; /* nobody reads it */
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_mesh(build, &wrong);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_scene_destroy(scene);
	stilb_scene_mesh_finish(&wrong);
}

/* ---- clusters ---------------------------------------------------------------------------------------------------- */

/* A square of 2 x 2 m and 8 triangles: two clusters in a group, and what replaces them: a fan of 6, which leaves the
 * vertex in the middle out. */
static void clusters_make(stilb_scene_mesh *mesh)
{
	static const uint32_t own[24] = {0, 3, 1, 1, 3, 4, 3, 6, 4, 4, 6, 7, 1, 4, 2, 2, 4, 5, 4, 7, 5, 5, 7, 8};
	static const uint32_t coarser[18] = {0, 3, 6, 0, 6, 7, 0, 7, 8, 0, 8, 5, 0, 5, 2, 0, 2, 1};
	assert_int_equal(scene_mesh_create(mesh, 9, 24), STILB_OK);
	assert_int_equal(scene_mesh_add_clusters(mesh, 3, 2, 18), STILB_OK);
	for (uint32_t v = 0; v < 9; v++)
		mesh->vertices[v] = (stilb_scene_vertex){{(float)(v % 3) - 1, 0, (float)(v / 3) - 1}, {0, 1, 0}, {0, 0}};
	memcpy(mesh->indices, own, sizeof own);
	memcpy(mesh->cluster_indices, coarser, sizeof coarser);
	for (uint32_t c = 0; c < 2; c++)
		mesh->clusters[c] = (stilb_scene_cluster){.center = {(float)c - 0.5f, 0, 0},
		                                          .radius = 1.2f,
		                                          .first_index = 12 * c,
		                                          .index_count = 12,
		                                          .from = STILB_SCENE_NONE};
	mesh->clusters[2] = (stilb_scene_cluster){.radius = 1.42f, .index_count = 18, .from = 0};
	mesh->groups[0] = (stilb_scene_cluster_group){.radius = 1.42f, .error = 0.1f, .cluster_count = 2};
	mesh->groups[1] =
		(stilb_scene_cluster_group){.radius = 1.42f, .error = INFINITY, .first_cluster = 2, .cluster_count = 1};
}

static void assert_clusters_equal(const stilb_scene_mesh *a, const stilb_scene_mesh *b)
{
	assert_true(a->clusters != b->clusters && a->groups != b->groups && a->cluster_indices != b->cluster_indices);
	assert_int_equal(a->cluster_count, b->cluster_count);
	assert_int_equal(a->group_count, b->group_count);
	assert_int_equal(a->cluster_index_count, b->cluster_index_count);
	assert_memory_equal(a->clusters, b->clusters, a->cluster_count * sizeof *a->clusters);
	assert_memory_equal(a->groups, b->groups, a->group_count * sizeof *a->groups);
	assert_memory_equal(a->cluster_indices, b->cluster_indices, a->cluster_index_count * sizeof *a->cluster_indices);
}

/* Scenes copy clusters, and lose them with the first vertex that moves. */
static void scenes_copy_clusters(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	stilb_scene *scene;
	uint32_t added;
	clusters_make(&mesh);
	stilb_scene_build *build = stilb_scene_build_begin();
	assert_int_equal(stilb_scene_build_mesh(build, &mesh), 0);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_clusters_equal(&scene->meshes[0], &mesh);
	assert_int_equal(stilb_scene_add_mesh(scene, &mesh, &added), STILB_OK);
	assert_clusters_equal(&scene->meshes[added], &mesh);
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 4, 1, &mesh.vertices[4]), STILB_OK);
	assert_int_equal(stilb_scene_changes_read(scene).mesh_count, 1);
	const stilb_scene_mesh *left = &scene->meshes[0];
	assert_int_equal(left->cluster_count + left->group_count + left->cluster_index_count, 0);
	assert_true(!left->clusters && !left->groups && !left->cluster_indices);
	stilb_scene_destroy(scene);
	stilb_scene_mesh_finish(&mesh);
}

static void mistakes_of_clusters_are_named(void **state)
{
	(void)state;
	clusters_make(&wrong);
	stilb_scene_cluster *clusters = wrong.clusters, *top = &clusters[2];
	stilb_scene_cluster_group *groups = wrong.groups;
	refuses_with(wrong.group_count, 0, "mesh 0: 3 clusters of 18 indices in 0 groups; some of these are missing");
	refuses_with(wrong.clusters, NULL, "3 clusters of 18 indices in 2 groups");
	refuses_with(wrong.groups, NULL, "some of these are missing");
	refuses_with(wrong.cluster_indices, NULL, "some of these are missing");
	refuses_with(wrong.group_count, 1, "its groups have 2 of 3 clusters, and these 24 of its 24 indices and 0 of 18");
	refuses_with(wrong.cluster_index_count, 21, "these 24 of its 24 indices and 18 of 21");
	refuses_with(wrong.cluster_count, 2, "group 1 has 1 clusters from 2 on; it takes some, from 2 on, of 2");
	refuses_with(groups[1].first_cluster, 1, "group 1 has 1 clusters from 1 on; it takes some, from 2 on, of 3");
	refuses_with(groups[0].cluster_count, 0, "group 0 has 0 clusters");
	refuses_with(groups[0].cluster_count, UINT32_MAX, "group 0 has 4294967295 clusters");
	refuses_with(groups[0].radius, -1.0f, "group 0 has a radius of -1 m");
	refuses_with(groups[0].error, NAN, "group 0 has a radius of 1.42 m and an error of nan m");
	refuses_with(groups[0].error, INFINITY, "cluster 2 of it is from group 0 with inf");
	refuses_with(groups[1].error, 0.05f,
	             "group 1 has an error of 0.05 m, and cluster 2 of it is from group 0 with 0.1");
	refuses_with(groups[0].radius, 1.6f, "the sphere of group 1 is not around that of group 0");
	refuses_with(groups[0].center[1], 2.0f, "of cluster 0 is outside of its sphere or of that of its group 0");
	refuses_with(top->from, 1, "cluster 2 of group 1 is from group 1, not one before");
	refuses_with(top->from, STILB_SCENE_NONE, "cluster 2 has 18 indices from 0 on");
	refuses_with(top->index_count, 0, "cluster 2 has 0 indices");
	refuses_with(top->index_count, 17, "cluster 2 has 17 indices");
	refuses_with(top->index_count, 21, "cluster 2 has 21 indices from 0 on; that takes a multiple of 3, and from 0,");
	refuses_with(top->index_count, 15, "these 24 of its 24 indices and 15 of 18");
	refuses_with(clusters[1].first_index, 9,
	             "cluster 1 has 12 indices from 9 on; that takes a multiple of 3, and from 12");
	refuses_with(clusters[0].radius, 1.1f, "of cluster 0 is outside of its sphere");
	refuses_with(clusters[0].center[0], NAN, "cluster 0 has a sphere of radius 1.2 about nan");
	refuses_with(wrong.cluster_indices[5], 9, "index 5 of cluster 2 is vertex 9, but it has 9");
	refuses_with(wrong.vertices[8].position[0], 1.5f, "vertex 8 of cluster 1 is outside of its sphere");
	stilb_scene_mesh_finish(&wrong);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(levels_are_spheres_of_fewer_splits_and_an_octahedron),
		cmocka_unit_test(errors_are_true_and_tight),
		cmocka_unit_test(vertices_morph_onto_the_coarser_level),
		cmocka_unit_test(the_icosahedron_morphs_onto_the_octahedron),
		cmocka_unit_test(scenes_copy_levels),
		cmocka_unit_test(moved_vertices_drop_levels),
		cmocka_unit_test(mistakes_are_named),
		cmocka_unit_test(scenes_copy_clusters),
		cmocka_unit_test(mistakes_of_clusters_are_named),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
