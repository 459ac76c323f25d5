/* The program of the suite `simplify`: makes a mesh, simplifies it by libmeshoptimizer and by engine/geometry in turn
 * to the same number of triangles, and compares both with what it was. */
#include "bench/harness/bench_child.h"
#include "bench/simplify/simplify_cases.h"
#include "geometry/geometry.h"
#include "geometry/geometry_levels.h"
#include "geometry/geometry_tree.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <meshoptimizer.h>
#include <stdbool.h>
#include <string.h>

#define ROUNDS_MOST 50u
#define POINTS 60000u

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static void *allocate(size_t count, size_t size)
{
	void *memory = calloc(count + 1, size);
	if (!memory)
		bench_child_fail("no memory");
	return memory;
}

/* Smooth normals: of the triangles at each vertex, weighted by area. */
static void set_normals(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		memset(mesh->vertices[v].normal, 0, sizeof mesh->vertices[v].normal);
	for (uint32_t i = 0; i < mesh->index_count; i++) {
		stilb_vec3 p[3];
		for (uint32_t k = 0; k < 3; k++) {
			const float *at = mesh->vertices[mesh->indices[i - i % 3 + k]].position;
			p[k] = stilb_vec3_make(at[0], at[1], at[2]);
		}
		stilb_vec3 n = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		for (int axis = 0; axis < 3; axis++)
			mesh->vertices[mesh->indices[i]].normal[axis] += n[axis];
	}
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		float *n = mesh->vertices[v].normal, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		for (int axis = 0; axis < 3 && length > 0.0f; axis++)
			n[axis] /= length;
	}
}

static stilb_scene_mesh grid(uint32_t w, uint32_t h)
{
	stilb_scene_mesh mesh = {.vertex_count = (w + 1) * (h + 1), .index_count = w * h * 6};
	mesh.vertices = allocate(mesh.vertex_count, sizeof *mesh.vertices);
	mesh.indices = allocate(mesh.index_count, sizeof *mesh.indices);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		mesh.vertices[v].uv[0] = (float)(v % (w + 1)) / (float)w;
		mesh.vertices[v].uv[1] = (float)(v / (w + 1)) / (float)h;
	}
	for (uint32_t s = 0; s < w * h; s++) {
		uint32_t a = s / w * (w + 1) + s % w, b = a + 1, c = a + w + 1, d = c + 1;
		const uint32_t square[6] = {a, c, b, b, c, d};
		memcpy(mesh.indices + 6 * (size_t)s, square, sizeof square);
	}
	return mesh;
}

static stilb_scene_mesh make_hills(void)
{
	stilb_scene_mesh mesh = grid(300, 300);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		float *p = mesh.vertices[v].position, x = mesh.vertices[v].uv[0], z = mesh.vertices[v].uv[1];
		p[0] = 10.0f * x;
		p[1] = 0.3f * sinf(21.0f * x) * cosf(15.0f * z) + 0.1f * sinf(40.0f * x + 3.0f * z) * sinf(31.0f * z) +
		       0.02f * sinf(100.0f * x) * sinf(130.0f * z);
		p[2] = 10.0f * z;
	}
	set_normals(&mesh);
	return mesh;
}

/* Two seams of the texture, where it is closed; the normals of both sides are the same there. */
static stilb_scene_mesh make_torus(void)
{
	stilb_scene_mesh mesh = grid(400, 200);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		stilb_scene_vertex *vertex = &mesh.vertices[v];
		float a = 6.2831853f * (vertex->uv[0] < 1.0f ? vertex->uv[0] : 0.0f);
		float b = 6.2831853f * (vertex->uv[1] < 1.0f ? vertex->uv[1] : 0.0f);
		float r = 0.4f * (1.0f + 0.1f * sinf(9.0f * a) * sinf(6.0f * b) + 0.03f * sinf(31.0f * a) * cosf(26.0f * b));
		vertex->position[0] = (1.0f + r * cosf(b)) * cosf(a);
		vertex->position[1] = r * sinf(b);
		vertex->position[2] = (1.0f + r * cosf(b)) * sinf(a);
	}
	set_normals(&mesh);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		uint32_t i = v % 401 == 400 ? 0 : v % 401, j = v / 401 == 200 ? 0 : v / 401;
		memcpy(mesh.vertices[v].normal, mesh.vertices[j * 401 + i].normal, sizeof mesh.vertices[v].normal);
	}
	return mesh;
}

static stilb_scene_mesh make_sphere(void)
{
	stilb_scene_mesh mesh;
	if (stilb_scene_mesh_sphere(6, &mesh) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	return mesh;
}

static stilb_scene_mesh make_bumpy(void)
{
	stilb_scene_mesh mesh = make_sphere();
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		float *p = mesh.vertices[v].position;
		float r = 1.0f + 0.05f * sinf(11.0f * p[0]) * sinf(13.0f * p[1] + 1.0f) * sinf(9.0f * p[2] + 2.0f) +
		          0.01f * sinf(41.0f * p[0]) * sinf(37.0f * p[1]) * sinf(43.0f * p[2]);
		for (int axis = 0; axis < 3; axis++)
			p[axis] *= r;
	}
	set_normals(&mesh);
	return mesh;
}

/* A trefoil knot with a twisted, ribbed tube, whose texture has two seams. */
static stilb_scene_mesh make_knot(void)
{
	stilb_scene_mesh mesh = grid(900, 80);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		stilb_scene_vertex *vertex = &mesh.vertices[v];
		float a = 6.2831853f * (vertex->uv[0] < 1.0f ? vertex->uv[0] : 0.0f);
		float b = 6.2831853f * (vertex->uv[1] < 1.0f ? vertex->uv[1] : 0.0f);
		stilb_vec3 center =
			stilb_vec3_make(sinf(a) + 2.0f * sinf(2.0f * a), cosf(a) - 2.0f * cosf(2.0f * a), -sinf(3.0f * a));
		stilb_vec3 along = stilb_vec3_normalize(
			stilb_vec3_make(cosf(a) + 4.0f * cosf(2.0f * a), -sinf(a) + 4.0f * sinf(2.0f * a), -3.0f * cosf(3.0f * a)));
		stilb_vec3 side = stilb_vec3_normalize(stilb_vec3_cross(along, stilb_vec3_make(0.0f, 0.0f, 1.0f)));
		stilb_vec3 up = stilb_vec3_cross(side, along);
		float r = 0.35f * (1.0f + 0.12f * sinf(5.0f * b + 9.0f * a) + 0.05f * sinf(60.0f * a));
		stilb_vec3 at = center + side * (r * cosf(b)) + up * (r * sinf(b));
		for (int axis = 0; axis < 3; axis++)
			vertex->position[axis] = at[axis];
	}
	set_normals(&mesh);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		uint32_t i = v % 901 == 900 ? 0 : v % 901, j = v / 901 == 80 ? 0 : v / 901;
		memcpy(mesh.vertices[v].normal, mesh.vertices[j * 901 + i].normal, sizeof mesh.vertices[v].normal);
	}
	return mesh;
}

/* Plains with cliffs between them, and roughness of many sizes. */
static stilb_scene_mesh make_cliffs(void)
{
	stilb_scene_mesh mesh = grid(256, 256);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		float *p = mesh.vertices[v].position, x = 10.0f * mesh.vertices[v].uv[0], z = 10.0f * mesh.vertices[v].uv[1];
		float height = tanhf(4.0f * (sinf(0.9f * x) + cosf(0.7f * z + 0.4f * x))), size = 0.1f;
		for (float wave = 1.7f; wave < 30.0f; wave *= 1.9f, size *= 0.5f)
			height += size * sinf(wave * x + 0.3f * wave * z) * cosf(wave * z - 0.6f * wave * x + wave);
		p[0] = x;
		p[1] = height;
		p[2] = z;
	}
	set_normals(&mesh);
	return mesh;
}

typedef struct simplify_case {
	const char *name;
	stilb_scene_mesh (*make)(void);
	uint32_t parts;
} simplify_case;

static const simplify_case cases[] = {
#define CASE(NAME, TITLE, MESH, PARTS) {NAME, make_##MESH, PARTS},
	SIMPLIFY_CASES(CASE)
#undef CASE
};

/* ---- errors ------------------------------------------------------------------------------------------------------ */

typedef struct simplify_error {
	double rms, farthest, normal, uv;
} simplify_error;

/* Values at a point, and how far the best of points of the other surface are from them. */
typedef struct values_at {
	const stilb_scene_mesh *mesh;
	const uint32_t *indices;
	float normal[3], uv[2];
	float best_normal, best_uv; /* squares */
} values_at;

static void interpolate(const stilb_scene_mesh *mesh, const uint32_t *corner, float u, float v, float normal[3],
                        float uv[2])
{
	const float weight[3] = {1.0f - u - v, u, v};
	float length = 0.0f;
	for (int axis = 0; axis < 3; axis++) {
		normal[axis] = 0.0f;
		for (int k = 0; k < 3; k++)
			normal[axis] += weight[k] * mesh->vertices[corner[k]].normal[axis];
		length += normal[axis] * normal[axis];
	}
	for (int axis = 0; axis < 3 && length > 0.0f; axis++)
		normal[axis] /= sqrtf(length);
	for (int axis = 0; axis < 2; axis++) {
		uv[axis] = 0.0f;
		for (int k = 0; k < 3; k++)
			uv[axis] += weight[k] * mesh->vertices[corner[k]].uv[axis];
	}
}

static void visit(const geometry_tree_triangle *triangle, const geometry_nearest *at, void *user)
{
	values_at *values = user;
	float normal[3], uv[2], normal_square = 0.0f, uv_square = 0.0f;
	interpolate(values->mesh, values->indices + 3 * (size_t)triangle->id, at->at[0], at->at[1], normal, uv);
	for (int axis = 0; axis < 3; axis++)
		normal_square += (normal[axis] - values->normal[axis]) * (normal[axis] - values->normal[axis]);
	for (int axis = 0; axis < 2; axis++)
		uv_square += (uv[axis] - values->uv[axis]) * (uv[axis] - values->uv[axis]);
	values->best_normal = fminf(values->best_normal, normal_square);
	values->best_uv = fminf(values->best_uv, uv_square);
}

static float area_of(const stilb_scene_mesh *mesh, const uint32_t *corner)
{
	stilb_vec3 p[3];
	for (int k = 0; k < 3; k++) {
		const float *at = mesh->vertices[corner[k]].position;
		p[k] = stilb_vec3_make(at[0], at[1], at[2]);
	}
	stilb_vec3 n = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
	return 0.5f * sqrtf(stilb_vec3_dot(n, n));
}

/* Compares points of surface a, spread evenly, with surface b; adds squares to error. */
static void compare(const stilb_scene_mesh *mesh, const uint32_t *a, uint32_t a_count, const uint32_t *b,
                    uint32_t b_count, bool with_values, simplify_error *error)
{
	geometry_tree tree;
	if (!geometry_tree_create(mesh->vertices->position, sizeof *mesh->vertices, b, b_count / 3, NULL, 0, &tree))
		bench_child_fail("no memory");
	double area = 0.0, passed = 0.0;
	for (uint32_t t = 0; t < a_count / 3; t++)
		area += (double)area_of(mesh, a + 3 * (size_t)t);
	uint32_t t = 0, hint = UINT32_MAX;
	double own = (double)area_of(mesh, a);
	for (uint32_t i = 0; i < POINTS; i++) {
		for (double at = ((double)i + 0.5) / POINTS * area; passed + own < at && t + 1 < a_count / 3;) {
			passed += own;
			own = (double)area_of(mesh, a + 3 * (size_t)++t);
		}
		float u = stilb_random_float(7, 2 * (uint64_t)i), v = stilb_random_float(7, 2 * (uint64_t)i + 1);
		if (u + v > 1.0f) {
			u = 1.0f - u;
			v = 1.0f - v;
		}
		const uint32_t *corner = a + 3 * (size_t)t;
		stilb_vec3 p = {0};
		for (int axis = 0; axis < 3; axis++)
			p[axis] = (1.0f - u - v) * mesh->vertices[corner[0]].position[axis] +
			          u * mesh->vertices[corner[1]].position[axis] + v * mesh->vertices[corner[2]].position[axis];
		geometry_nearest nearest = geometry_tree_nearest(&tree, p, FLT_MAX, -1.0f, hint);
		hint = nearest.triangle;
		error->rms += (double)nearest.square;
		error->farthest = fmax(error->farthest, sqrt((double)nearest.square));
		if (!with_values)
			continue;
		values_at values = {.mesh = mesh, .indices = b, .best_normal = FLT_MAX, .best_uv = FLT_MAX};
		interpolate(mesh, corner, u, v, values.normal, values.uv);
		geometry_tree_within(&tree, p, nearest.square * 1.02f + 1e-12f, visit, &values);
		error->normal += (double)values.best_normal;
		error->uv += (double)values.best_uv;
	}
	geometry_tree_finish(&tree);
}

static simplify_error error_of(const stilb_scene_mesh *mesh, const uint32_t *indices, uint32_t count)
{
	simplify_error error = {0};
	compare(mesh, mesh->indices, mesh->index_count, indices, count, true, &error);
	compare(mesh, indices, count, mesh->indices, mesh->index_count, false, &error);
	error.rms = sqrt(error.rms / (2.0 * POINTS));
	error.normal = sqrt(error.normal / POINTS);
	error.uv = sqrt(error.uv / POINTS);
	return error;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static double cpu_ms(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static int ascending(const void *a, const void *b)
{
	double l = *(const double *)a, r = *(const double *)b;
	return (l > r) - (l < r);
}

static double median(double *values, uint32_t count)
{
	qsort(values, count, sizeof *values, ascending);
	return values[count / 2];
}

static stilb_geometry_simplified simplify(const stilb_scene_mesh *mesh, uint32_t triangles, stilb_job_pool *pool)
{
	stilb_geometry_levels_desc levels = stilb_geometry_levels_desc_default();
	const stilb_geometry_stream streams[2] = {{"normal", STILB_GEOMETRY_DIRECTION, 3,
	                                           levels.weights[STILB_SCENE_VERTEX_NORMAL], false, mesh->vertices->normal,
	                                           sizeof *mesh->vertices},
	                                          {"uv", STILB_GEOMETRY_TEXTURE, 2, levels.weights[STILB_SCENE_VERTEX_UV],
	                                           true, mesh->vertices->uv, sizeof *mesh->vertices}};
	stilb_geometry_mesh view = {.vertex_count = mesh->vertex_count,
	                            .index_count = mesh->index_count,
	                            .indices = mesh->indices,
	                            .positions = mesh->vertices->position,
	                            .position_stride = sizeof *mesh->vertices,
	                            .stream_count = 2,
	                            .streams = streams};
	stilb_geometry_simplify_desc desc = {.target_triangles = triangles};
	stilb_geometry_simplified simplified;
	if (stilb_geometry_simplify(&view, &desc, pool, 0, &simplified) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	return simplified;
}

static void measure(const simplify_case *on, double seconds)
{
	static double peer[ROUNDS_MOST], own[ROUNDS_MOST], ratio[ROUNDS_MOST], speedup[ROUNDS_MOST];
	stilb_scene_mesh mesh = on->make();
	uint32_t *indices = allocate(mesh.index_count, sizeof *indices);
	stilb_job_pool_desc pool_desc = stilb_job_pool_desc_default();
	pool_desc.worker_count = 1;
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&pool_desc, &pool) != 0)
		bench_child_fail("no pool");
	uint32_t rounds = 0;
	size_t count = 0;
	stilb_geometry_simplified simplified = {0};
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	while (rounds < 1 || (rounds < ROUNDS_MOST && bench_child_now_ns() < end)) {
		double begin = cpu_ms();
		count = meshopt_simplify(indices, mesh.indices, mesh.index_count, mesh.vertices->position, mesh.vertex_count,
		                         sizeof *mesh.vertices, mesh.index_count / 3 / on->parts * 3, 1e9f, 0, NULL);
		peer[rounds] = cpu_ms() - begin;
		stilb_geometry_simplified_finish(&simplified);
		begin = cpu_ms();
		uint64_t begin_ns = bench_child_now_ns();
		simplified = simplify(&mesh, (uint32_t)count / 3, NULL);
		own[rounds] = cpu_ms() - begin;
		double elapsed = (double)(bench_child_now_ns() - begin_ns);
		begin_ns = bench_child_now_ns();
		stilb_geometry_simplified again = simplify(&mesh, (uint32_t)count / 3, pool);
		speedup[rounds] = elapsed / (double)(bench_child_now_ns() - begin_ns);
		if (again.index_count != simplified.index_count ||
		    memcmp(again.indices, simplified.indices, again.index_count * sizeof *again.indices) != 0)
			bench_child_fail("wrong result: two threads give another mesh than one");
		stilb_geometry_simplified_finish(&again);
		ratio[rounds] = own[rounds] / peer[rounds];
		rounds++;
	}
	simplify_error theirs = error_of(&mesh, indices, (uint32_t)count);
	simplify_error ours = error_of(&mesh, simplified.indices, simplified.index_count);
	bench_child_metric("peer", median(peer, rounds));
	bench_child_metric("stilb", median(own, rounds));
	bench_child_metric("of-time", median(ratio, rounds));
	bench_child_metric("speedup", median(speedup, rounds));
	bench_child_metric("of-rms", ours.rms / theirs.rms);
	bench_child_metric("of-farthest", ours.farthest / theirs.farthest);
	bench_child_metric("of-normals", ours.normal / theirs.normal);
	bench_child_metric("of-texture", ours.uv / theirs.uv);
	bench_child_metric("triangles", (double)(count / 3));
	bench_child_metric("of-triangles", (double)simplified.index_count / (double)count);
	stilb_geometry_simplified_finish(&simplified);
	stilb_job_pool_destroy(pool);
	free(indices);
	stilb_scene_mesh_finish(&mesh);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(child.case_name, cases[i].name) == 0) {
			measure(&cases[i], child.seconds);
			return 0;
		}
	return BENCH_CHILD_SKIP;
}
