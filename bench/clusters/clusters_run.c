/* The program of the suite `clusters`: makes a large mesh, gives it clusters and levels once, and looks at points of
 * the mesh to see whether cuts are as near as is said. */
#include "bench/clusters/clusters_cases.h"
#include "bench/harness/bench_child.h"
#include "geometry/geometry_levels.h"
#include "geometry/geometry_tree.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#define SIDE 2236u /* squares of a mesh of 10 million triangles */
#define POINTS 1000000u
#define CUTS 3u
#define CACHE 16u

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static stilb_scene_mesh mesh_of(uint32_t vertex_count, uint32_t index_count)
{
	stilb_scene_mesh mesh = {.vertex_count = vertex_count, .index_count = index_count};
	mesh.vertices = stilb_memory_alloc(vertex_count, sizeof *mesh.vertices);
	mesh.indices = stilb_memory_alloc(index_count, sizeof *mesh.indices);
	if (!mesh.vertices || !mesh.indices)
		bench_child_fail("no memory");
	return mesh;
}

/* w x h squares over uv in [0, 1]; place computes the position. Normals are those of the surface as it is without
 * noise, by differences. */
static stilb_scene_mesh grid(uint32_t w, uint32_t h, void (*place)(float u, float v, float at[3]))
{
	stilb_scene_mesh mesh = mesh_of((w + 1) * (h + 1), w * h * 6);
	for (uint32_t i = 0; i < mesh.vertex_count; i++) {
		stilb_scene_vertex *vertex = &mesh.vertices[i];
		float u = (float)(i % (w + 1)) / (float)w, v = (float)(i / (w + 1)) / (float)h, near[2][3], step = 1e-3f;
		place(u, v, vertex->position);
		place(u < 0.5f ? u + step : u - step, v, near[0]);
		place(u, v < 0.5f ? v + step : v - step, near[1]);
		stilb_vec3 e[2];
		for (int k = 0; k < 2; k++) {
			float sign = (k == 0 ? u : v) < 0.5f ? 1.0f : -1.0f;
			e[k] = stilb_vec3_make((near[k][0] - vertex->position[0]) * sign, (near[k][1] - vertex->position[1]) * sign,
			                       (near[k][2] - vertex->position[2]) * sign);
		}
		stilb_vec3 n = stilb_vec3_cross(e[1], e[0]);
		float length = sqrtf(stilb_vec3_dot(n, n));
		for (int axis = 0; axis < 3; axis++)
			vertex->normal[axis] = length > 0.0f ? n[axis] / length : 0.0f;
		vertex->uv[0] = u;
		vertex->uv[1] = v;
	}
	for (uint32_t s = 0; s < w * h; s++) {
		uint32_t a = s / w * (w + 1) + s % w, b = a + 1, c = a + w + 1, d = c + 1;
		const uint32_t square[6] = {a, c, b, b, c, d};
		memcpy(mesh.indices + 6 * (size_t)s, square, sizeof square);
	}
	return mesh;
}

static void place_sphere(float u, float v, float at[3])
{
	float a = 6.2831853f * (u < 1.0f ? u : 0.0f), b = 3.1415927f * v;
	float ring = v > 0.0f && v < 1.0f ? sinf(b) : 0.0f;
	float x = ring * cosf(a), y = cosf(b), z = ring * sinf(a);
	float r = 1.0f + 0.05f * sinf(11.0f * x) * sinf(13.0f * y + 1.0f) * sinf(9.0f * z + 2.0f) +
	          0.002f * sinf(141.0f * x) * sinf(137.0f * y) * sinf(143.0f * z);
	at[0] = r * x;
	at[1] = r * y;
	at[2] = r * z;
}

/* A number in [-1, 1] for a place, continuous, with hills of size 1. */
static float noise(float x, float z)
{
	float fx = floorf(x), fz = floorf(z), sum = 0.0f;
	for (int corner = 0; corner < 4; corner++) {
		float cx = fx + (float)(corner & 1), cz = fz + (float)(corner >> 1);
		float dx = 1.0f - fabsf(x - cx), dz = 1.0f - fabsf(z - cz);
		sum += (2.0f * stilb_random_float((uint64_t)(int64_t)cx, (uint64_t)(int64_t)cz) - 1.0f) * dx * dx *
		       (3.0f - 2.0f * dx) * dz * dz * (3.0f - 2.0f * dz);
	}
	return sum;
}

/* A kilometre of hills, down to stones. */
static void place_terrain(float u, float v, float at[3])
{
	at[0] = 1000.0f * u;
	at[1] = 0.0f;
	at[2] = 1000.0f * v;
	for (float size = 250.0f; size > 0.5f; size *= 0.45f)
		at[1] += 0.2f * size * noise(at[0] / size, at[2] / size);
}

static void place_torus(float u, float v, float at[3])
{
	u = u < 1.0f ? u : 0.0f;
	v = v < 1.0f ? v : 0.0f;
	float a = 6.2831853f * u, b = 6.2831853f * v;
	float chance = stilb_random_float((uint64_t)(u * 1e6f), (uint64_t)(v * 1e6f)) - 0.5f;
	float r = 0.4f * (1.0f + 0.1f * sinf(9.0f * a) * sinf(6.0f * b) + 0.03f * sinf(31.0f * a) * cosf(26.0f * b)) +
	          5e-4f * chance;
	at[0] = (1.0f + r * cosf(b)) * cosf(a);
	at[1] = r * sinf(b);
	at[2] = (1.0f + r * cosf(b)) * sinf(a);
}

static stilb_scene_mesh make_sphere(void)
{
	return grid(SIDE, SIDE, place_sphere);
}

static stilb_scene_mesh make_terrain(void)
{
	return grid(SIDE, SIDE, place_terrain);
}

static stilb_scene_mesh make_torus(void)
{
	return grid(SIDE, SIDE, place_torus);
}

static stilb_scene_mesh make_small(void)
{
	return grid(400, 250, place_torus);
}

static stilb_scene_mesh make_debris(void)
{
	stilb_scene_mesh sphere;
	if (stilb_scene_mesh_sphere(2, &sphere) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	uint32_t count = 30000;
	stilb_scene_mesh mesh = mesh_of(count * sphere.vertex_count, count * sphere.index_count);
	for (uint32_t i = 0; i < mesh.vertex_count; i++) {
		uint32_t which = i / sphere.vertex_count;
		mesh.vertices[i] = sphere.vertices[i % sphere.vertex_count];
		for (uint32_t axis = 0; axis < 3; axis++)
			mesh.vertices[i].position[axis] = 0.3f * mesh.vertices[i].position[axis] * stilb_random_float(9, which) +
			                                  100.0f * stilb_random_float(axis, which);
	}
	for (uint32_t i = 0; i < mesh.index_count; i++)
		mesh.indices[i] = sphere.indices[i % sphere.index_count] + i / sphere.index_count * sphere.vertex_count;
	stilb_scene_mesh_finish(&sphere);
	return mesh;
}

static stilb_scene_mesh make_facets(void)
{
	stilb_scene_mesh from = grid(1265, 1265, place_sphere), mesh = mesh_of(from.index_count, from.index_count);
	for (uint32_t i = 0; i < from.index_count; i++) {
		mesh.vertices[i] = from.vertices[from.indices[i]];
		mesh.indices[i] = i;
	}
	stilb_scene_mesh_finish(&from);
	return mesh;
}

typedef struct clusters_case {
	const char *name;
	stilb_scene_mesh (*make)(void);
} clusters_case;

static const clusters_case cases[] = {
#define CASE(NAME, TITLE, MESH) {NAME, make_##MESH},
	CLUSTERS_CASES(CASE)
#undef CASE
};

/* ---- what errors say --------------------------------------------------------------------------------------------- */

typedef struct clusters_cut {
	bool *suffices; /* [group_count] */
	uint32_t *indices;
	uint32_t count;
	float error; /* metres: the largest of groups that are replaced */
} clusters_cut;

static float distance_of(const float a[3], const float b[3])
{
	float square = 0.0f;
	for (int axis = 0; axis < 3; axis++)
		square += (a[axis] - b[axis]) * (a[axis] - b[axis]);
	return sqrtf(square);
}

/* What is drawn as seen from a vertex; the limit is such that about half of the groups suffice in the middle of the
 * mesh, or more. */
static void choose_cut(const stilb_scene_mesh *mesh, uint32_t number, clusters_cut *cut)
{
	const float *eye = mesh->vertices[stilb_random_u64(1, number) % mesh->vertex_count].position;
	float far = distance_of(eye, mesh->groups[mesh->group_count - 1].center);
	float limit = mesh->groups[mesh->group_count / 2 + mesh->group_count / 4 * number / CUTS].error / far;
	cut->count = 0;
	cut->error = 0.0f;
	for (uint32_t g = 0; g < mesh->group_count; g++) {
		const stilb_scene_cluster_group *group = &mesh->groups[g];
		float near = fmaxf(distance_of(eye, group->center) - group->radius, 1e-3f * far);
		cut->suffices[g] = group->error <= limit * near;
		if (cut->suffices[g])
			cut->error = fmaxf(cut->error, group->error);
		for (uint32_t c = group->first_cluster; c < group->first_cluster + group->cluster_count; c++) {
			const stilb_scene_cluster *own = &mesh->clusters[c];
			bool leaf = own->from == STILB_SCENE_NONE;
			if (cut->suffices[g] || !(leaf || cut->suffices[own->from]))
				continue;
			memcpy(cut->indices + cut->count, (leaf ? mesh->indices : mesh->cluster_indices) + own->first_index,
			       own->index_count * sizeof *cut->indices);
			cut->count += own->index_count;
		}
	}
}

/* The farthest of random points of the mesh's triangles from the cut. */
static float farthest_of(const stilb_scene_mesh *mesh, const clusters_cut *cut, uint32_t number)
{
	geometry_tree tree;
	if (!geometry_tree_create(mesh->vertices->position, sizeof *mesh->vertices, cut->indices, cut->count / 3, NULL, 0,
	                          &tree))
		bench_child_fail("no memory");
	float farthest = 0.0f;
	uint32_t hint = UINT32_MAX;
	for (uint32_t i = 0; i < POINTS; i++) {
		uint32_t t = (uint32_t)((uint64_t)(mesh->index_count / 3) * i / POINTS);
		const uint32_t *corner = mesh->indices + 3 * (size_t)t;
		float u = stilb_random_float(number, 2 * (uint64_t)i), v = stilb_random_float(number, 2 * (uint64_t)i + 1);
		if (u + v > 1.0f) {
			u = 1.0f - u;
			v = 1.0f - v;
		}
		float p[3];
		for (int axis = 0; axis < 3; axis++)
			p[axis] = (1.0f - u - v) * mesh->vertices[corner[0]].position[axis] +
			          u * mesh->vertices[corner[1]].position[axis] + v * mesh->vertices[corner[2]].position[axis];
		geometry_nearest nearest =
			geometry_tree_nearest(&tree, stilb_vec3_make(p[0], p[1], p[2]), FLT_MAX, farthest, hint);
		hint = nearest.triangle;
		farthest = fmaxf(farthest, nearest.square);
	}
	geometry_tree_finish(&tree);
	return sqrtf(farthest);
}

/* What is stated by what is found, on the mean of cuts; fails if one is farther than stated. */
static double error_of(const stilb_scene_mesh *mesh)
{
	clusters_cut cut = {.suffices = calloc(mesh->group_count, sizeof *cut.suffices),
	                    .indices = calloc(mesh->index_count + (size_t)mesh->cluster_index_count, sizeof *cut.indices)};
	if (!cut.suffices || !cut.indices)
		bench_child_fail("no memory");
	double sum = 0.0;
	for (uint32_t i = 0; i < CUTS; i++) {
		choose_cut(mesh, i, &cut);
		float farthest = farthest_of(mesh, &cut, i);
		if (!(farthest <= cut.error))
			bench_child_fail("wrong result: a point is %g m away from a cut with an error of %g", (double)farthest,
			                 (double)cut.error);
		sum += (double)(cut.error / farthest) / CUTS;
	}
	free(cut.suffices);
	free(cut.indices);
	return sum;
}

/* Vertices that are transformed for a triangle of the mesh's own clusters. */
static double transformed_of(const stilb_scene_mesh *mesh)
{
	uint32_t cache[CACHE], next = 0;
	uint64_t missed = 0;
	memset(cache, 0xff, sizeof cache);
	for (uint32_t i = 0; i < mesh->index_count; i++) {
		bool found = false;
		for (uint32_t k = 0; k < CACHE; k++)
			found = found || cache[k] == mesh->indices[i];
		if (found)
			continue;
		cache[next++ % CACHE] = mesh->indices[i];
		missed++;
	}
	return 3.0 * (double)missed / mesh->index_count;
}

/* ---- measuring --------------------------------------------------------------------------------------------------- */

/* The most memory that the process has had, bytes. */
static double most_memory(void)
{
	FILE *status = fopen("/proc/self/status", "r");
	unsigned long kib = 0;
	for (char line[256]; status && fgets(line, sizeof line, status);)
		if (sscanf(line, "VmHWM: %lu", &kib) == 1)
			break;
	if (status)
		fclose(status);
	if (kib == 0)
		bench_child_fail("/proc/self/status has no VmHWM");
	return (double)kib * 1024.0;
}

static double cpu_s(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void measure(const clusters_case *on)
{
	stilb_scene_mesh mesh = on->make();
	double size = (double)mesh.vertex_count * sizeof *mesh.vertices + (double)mesh.index_count * sizeof *mesh.indices;
	double before = most_memory() / size; /* making the mesh itself may take more */
	stilb_job_pool_desc pool_desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&pool_desc, &pool) != 0)
		bench_child_fail("no pool");
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	double cpu = cpu_s(CLOCK_PROCESS_CPUTIME_ID), thread = cpu_s(CLOCK_THREAD_CPUTIME_ID);
	uint64_t begin = bench_child_now_ns();
	if (stilb_geometry_levels(&mesh, &desc, pool, 0) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	double elapsed = (double)(bench_child_now_ns() - begin) * 1e-9;
	cpu = cpu_s(CLOCK_PROCESS_CPUTIME_ID) - cpu;
	thread = cpu_s(CLOCK_THREAD_CPUTIME_ID) - thread;
	double memory = most_memory() / size;
	if (mesh.cluster_count == 0 || mesh.level_count == 0)
		bench_child_fail("wrong result: no clusters");
	bench_child_metric("elapsed", elapsed);
	bench_child_metric("cpu", cpu);
	bench_child_metric("thread", thread);
	if (memory > before * 1.01 && size > 1e8) /* of small meshes it is that of the process */
		bench_child_metric("memory", memory);
	bench_child_metric("groups", mesh.group_count);
	bench_child_metric("coarser", (double)mesh.cluster_index_count / mesh.index_count);
	bench_child_metric("level", mesh.levels[0].index_count / 3e3);
	bench_child_metric("error", error_of(&mesh));
	bench_child_metric("transformed", transformed_of(&mesh));
	stilb_job_pool_destroy(pool);
	stilb_scene_mesh_finish(&mesh);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(child.case_name, cases[i].name) == 0) {
			measure(&cases[i]);
			return 0;
		}
	return BENCH_CHILD_SKIP;
}
