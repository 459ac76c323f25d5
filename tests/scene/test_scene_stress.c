/* The scene of the stress test against its definition: positions, materials, motion, and the views of its cameras. */
#include "scene/scene.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_scene *make(uint32_t models, uint64_t seed)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(models, seed, &scene), STILB_OK);
	return scene;
}

/* Transforms a vertex with the same operations in the same order as mesh.vert: rows times (position, 1). */
static void world(const stilb_mat4 *transform, const float p[3], float out[3])
{
	const float *m = transform->m;
	for (int row = 0; row < 3; row++)
		out[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row] * 1.0f;
}

/* Vertex v of model m, sphere first, then tile. false: there is none. */
static bool model_vertex(const stilb_scene *scene, uint32_t m, uint32_t v, float out[3])
{
	for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1]; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		if (v < mesh->vertex_count) {
			world(&scene->part_transform[p], mesh->vertices[v].position, out);
			return true;
		}
		v -= mesh->vertex_count;
	}
	return false;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static int compare_u64(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* Every edge is used once each way: no hole, no flap, all triangles turned the same way. Returns the edges. */
static uint32_t assert_closed(const stilb_scene_mesh *mesh)
{
	uint64_t *edges = malloc(mesh->index_count * sizeof *edges), *back = malloc(mesh->index_count * sizeof *back);
	assert_true(edges && back);
	for (uint32_t i = 0; i < mesh->index_count; i++) {
		uint64_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
		assert_true(a < mesh->vertex_count && a != b);
		edges[i] = a << 32 | b;
		back[i] = b << 32 | a;
	}
	qsort(edges, mesh->index_count, sizeof *edges, compare_u64);
	qsort(back, mesh->index_count, sizeof *back, compare_u64);
	for (uint32_t i = 1; i < mesh->index_count; i++)
		assert_true(edges[i] != edges[i - 1]);
	assert_memory_equal(edges, back, mesh->index_count * sizeof *edges);
	free(edges);
	free(back);
	return mesh->index_count / 2;
}

/* Twice the triangle's area along its normal, and six times the volume of its tetrahedron with the origin. */
static void triangle(const stilb_scene_mesh *mesh, uint32_t t, double normal[3], double *volume)
{
	const float *p[3];
	double u[3], v[3];
	for (int i = 0; i < 3; i++)
		p[i] = mesh->vertices[mesh->indices[3 * t + (uint32_t)i]].position;
	for (int i = 0; i < 3; i++) {
		u[i] = (double)p[1][i] - (double)p[0][i];
		v[i] = (double)p[2][i] - (double)p[0][i];
	}
	*volume = 0.0;
	for (int i = 0; i < 3; i++) {
		int j = (i + 1) % 3, k = (i + 2) % 3;
		normal[i] = u[j] * v[k] - u[k] * v[j];
		*volume += normal[i] * (double)p[0][i];
	}
}

static void test_sphere_mesh(void **state)
{
	(void)state;
	double area_before = 0.0;
	for (uint32_t splits = 0; splits <= 6; splits++) {
		stilb_scene_mesh mesh;
		assert_int_equal(stilb_scene_mesh_sphere(splits, &mesh), STILB_OK);
		uint32_t triangles = mesh.index_count / 3;
		assert_int_equal(mesh.index_count % 3, 0);
		assert_int_equal(triangles, 20u << (2 * splits));
		assert_int_equal(mesh.vertex_count + triangles - assert_closed(&mesh), 2); /* Euler */
		for (uint32_t i = 0; i < mesh.vertex_count; i++) {
			const float *p = mesh.vertices[i].position, *n = mesh.vertices[i].normal;
			assert_float_equal(sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), 1.0f, 3e-7f);
			assert_memory_equal(p, n, 3 * sizeof *p);
			/* uv, converted back to a direction, is the position. */
			float u = 6.2831853f * (mesh.vertices[i].uv[0] - 0.5f), v = 3.1415927f * mesh.vertices[i].uv[1];
			assert_float_equal(sinf(v) * sinf(u), p[0], 1e-3f);
			assert_float_equal(cosf(v), p[1], 1e-3f);
			assert_float_equal(sinf(v) * cosf(u), p[2], 1e-3f);
		}
		double area = 0.0, volume = 0.0;
		for (uint32_t t = 0; t < triangles; t++) {
			double normal[3], part;
			triangle(&mesh, t, normal, &part);
			assert_true(part > 0.0); /* counter-clockwise from outside: the normal points away from the origin */
			area += 0.5 * sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
			volume += part / 6.0;
		}
		/* Inscribed, so the volume is too small; each split divides the error nearly by four. */
		double full = 4.0 * 3.14159265358979323846;
		assert_true(area > area_before && area < full && volume < full / 3.0);
		assert_true(full - area < 3.1 * pow(0.3, splits) + 1e-6);
		area_before = area;
		stilb_scene_mesh_finish(&mesh);
		assert_null(mesh.vertices);
	}
}

static void test_plane_mesh(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_plane(&mesh), STILB_OK);
	assert_int_equal(mesh.vertex_count, 4);
	assert_int_equal(mesh.index_count, 6);
	double area = 0.0;
	for (uint32_t t = 0; t < 2; t++) {
		double normal[3], volume;
		triangle(&mesh, t, normal, &volume);
		assert_true(normal[0] == 0.0 && normal[2] == 0.0 && normal[1] > 0.0);
		area += 0.5 * normal[1];
	}
	assert_true(area == 4.0);
	for (uint32_t i = 0; i < 4; i++) {
		const stilb_scene_vertex *v = &mesh.vertices[i];
		assert_true(fabsf(v->position[0]) == 1.0f && v->position[1] == 0.0f && fabsf(v->position[2]) == 1.0f);
		assert_true(v->normal[0] == 0.0f && v->normal[1] == 1.0f && v->normal[2] == 0.0f);
		assert_true(v->uv[0] == 0.5f + 0.5f * v->position[0] && v->uv[1] == 0.5f + 0.5f * v->position[2]);
	}
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_mesh_finish(&mesh); /* accepts {0} */
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static void assert_energy(const stilb_scene_material *material)
{
	for (int i = 0; i < 3; i++) {
		assert_true(material->diffuse[i] >= 0.0f && material->specular[i] >= 0.0f);
		assert_true(material->diffuse[i] + material->specular[i] <= 1.0f);
	}
	assert_true(material->roughness >= 0.0f && material->roughness <= 1.0f);
	assert_true(material->anisotropy == 0.0f && material->wrap == 0.0f);
}

static void test_material_make(void **state)
{
	(void)state;
	const float diffuse[3] = {0.5f, 0.25f, 0.0f}, specular[3] = {0.25f, 0.5f, 1.0f};
	stilb_scene_material material = stilb_scene_material_make(diffuse, specular, 0.375f);
	assert_memory_equal(material.diffuse, diffuse, sizeof diffuse); /* a valid material does not change */
	assert_memory_equal(material.specular, specular, sizeof specular);
	assert_true(material.roughness == 0.375f);
	const float values[] = {0.0f, -1.0f, 1e-30f, 0.3f, 0.7f,     0.999999f, 1.0f,
	                        1.5f, 1e6f,  1e30f,  NAN,  INFINITY, -INFINITY};
	size_t count = sizeof values / sizeof *values;
	for (size_t i = 0; i < count * count * count; i++) {
		const float cd[3] = {values[i % count], values[i / count % count], values[i / count / count]};
		const float cs[3] = {cd[1], cd[2], cd[0]};
		material = stilb_scene_material_make(cd, cs, cd[0]);
		assert_energy(&material);
	}
	const float most[3] = {3.0f, 1.0f, -1.0f}, some[3] = {1.0f, 3.0f, 0.5f};
	material = stilb_scene_material_make(most, some, -0.5f);
	assert_float_equal(material.diffuse[0], 0.75f, 1e-6f); /* scaled with the same ratio */
	assert_float_equal(material.specular[0], 0.25f, 1e-6f);
	assert_float_equal(material.diffuse[1], 0.25f, 1e-6f);
	assert_true(material.diffuse[2] == 0.0f && material.specular[2] == 0.5f);
	assert_true(material.roughness == 0.0f);
	assert_true(stilb_scene_material_make(most, some, 1e9f).roughness == 1.0f);
}

/* The random number of a model in [low, high). Streams: radius 0, lift 1; the sphere's hue, saturation, value,
 * highlight and exponent 2 .. 6; the tile's hue and value 7 and 8. */
static float random_of(uint32_t model, uint32_t stream, float low, float high)
{
	return low + (high - low) * stilb_random_float(7, (uint64_t)model * 9 + stream);
}

/* From the six edges of the colour hexagon: red, yellow, green, cyan, blue, magenta. Source: Smith, "Color Gamut
 * Transform Pairs" (1978). */
static void hue_to_rgb(float hue, float saturation, float value, float rgb[3])
{
	static const int changing[6] = {1, 0, 2, 1, 0, 2}; /* of each edge: rising, falling, rising, ... */
	static const float start[6][3] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}, {1, 0, 1}};
	int edge = (int)(hue * 6.0f);
	float along = hue * 6.0f - (float)edge;
	memcpy(rgb, start[edge], sizeof start[edge]);
	rgb[changing[edge]] = edge % 2 == 0 ? along : 1.0f - along;
	for (int i = 0; i < 3; i++)
		rgb[i] = value * (1.0f - saturation + saturation * rgb[i]);
}

static void assert_material(const stilb_scene_material *got, const float diffuse[3], float specular, float exponent)
{
	stilb_scene_material want = stilb_scene_material_make(diffuse, (const float[3]){specular, specular, specular},
	                                                      powf(2.0f / (exponent + 2.0f), 0.25f));
	for (int i = 0; i < 3; i++) {
		assert_float_equal(got->diffuse[i], want.diffuse[i], 1e-5f);
		assert_float_equal(got->specular[i], want.specular[i], 1e-5f);
	}
	assert_float_equal(got->roughness, want.roughness, 1e-5f);
}

static void test_material_colors(void **state)
{
	(void)state;
	stilb_scene *scene = make(500, 7);
	for (uint32_t m = 0; m < scene->model_count; m++) {
		float diffuse[3];
		hue_to_rgb(random_of(m, 2, 0.0f, 1.0f), random_of(m, 3, 0.45f, 0.9f), random_of(m, 4, 0.35f, 0.85f), diffuse);
		assert_material(&scene->materials[2 * m], diffuse, random_of(m, 5, 0.03f, 0.25f),
		                exp2f(random_of(m, 6, 4.0f, 8.0f)));
		hue_to_rgb(random_of(m, 7, 0.0f, 1.0f), 0.18f, random_of(m, 8, 0.18f, 0.5f), diffuse);
		assert_material(&scene->materials[2 * m + 1], diffuse, 0.02f, 16.0f);
	}
	stilb_scene_destroy(scene);
}

/* ---- the grid ---------------------------------------------------------------------------------------------------- */

static const uint32_t grid_counts[] = {1, 2, 3, 4, 5, 7, 9, 10, 99, 100, 101, 1000, 9999, 10000, 10001};
#define GRID_COUNTS (sizeof grid_counts / sizeof *grid_counts)

static void test_parts_and_materials(void **state)
{
	(void)state;
	for (size_t c = 0; c < GRID_COUNTS; c++) {
		uint32_t n = grid_counts[c];
		stilb_scene *scene = make(n, 1);
		assert_int_equal(scene->model_count, n);
		assert_int_equal(scene->part_count, 2 * n);
		assert_int_equal(scene->material_count, 2 * n);
		assert_int_equal(scene->mesh_count, 2);
		assert_int_equal(scene->moved_count, 0);
		assert_true(scene->meshes[0].vertex_count > scene->meshes[1].vertex_count);
		assert_int_equal(scene->meshes[1].vertex_count, 4);
		uint8_t *used = calloc(2 * n, 1);
		assert_non_null(used);
		for (uint32_t m = 0; m < n; m++) {
			assert_int_equal(scene->first_part[m], 2 * m);
			assert_int_equal(scene->part_mesh[2 * m], 0); /* sphere, then tile */
			assert_int_equal(scene->part_mesh[2 * m + 1], 1);
		}
		assert_int_equal(scene->first_part[n], 2 * n);
		for (uint32_t p = 0; p < 2 * n; p++) {
			assert_true(scene->part_material[p] < 2 * n);
			assert_int_equal(used[scene->part_material[p]]++, 0); /* its own */
			assert_energy(&scene->materials[p]);
		}
		free(used);
		stilb_scene_destroy(scene);
	}
	stilb_scene_destroy(NULL);
}

/* The model in a row and column of the grid; -1: none. */
static int64_t model_at(uint32_t n, uint32_t side, uint32_t row, uint32_t column)
{
	uint64_t m = (uint64_t)row * side + column;
	return column < side && m < n ? (int64_t)m : -1;
}

static void tile_corners(const stilb_scene *scene, uint32_t m, float corners[4][3])
{
	const stilb_scene_mesh *plane = &scene->meshes[1];
	for (uint32_t i = 0; i < 4; i++)
		world(&scene->part_transform[2 * m + 1], plane->vertices[i].position, corners[i]);
}

/* The number of corners of a that are, bit for bit, corners of b. */
static int shared_corners(float a[4][3], float b[4][3])
{
	int shared = 0;
	for (int i = 0; i < 4; i++)
		for (int k = 0; k < 4; k++)
			shared += memcmp(a[i], b[k], sizeof a[i]) == 0;
	return shared;
}

static void assert_tile(const stilb_scene *scene, uint32_t m, uint32_t side)
{
	float corners[4][3], other[4][3], low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
	tile_corners(scene, m, corners);
	for (int i = 0; i < 4; i++) {
		assert_true(corners[i][1] == 0.0f && !signbit(corners[i][1]));
		for (int k = 0; k < 2; k++) {
			float x = corners[i][2 * k];
			assert_true(x == rintf(x) && fabsf(x) <= (float)side);
			low[k] = fminf(low[k], x);
			high[k] = fmaxf(high[k], x);
		}
	}
	assert_true(high[0] - low[0] == STILB_SCENE_TILE && high[1] - low[1] == STILB_SCENE_TILE);
	uint32_t row = m / side, column = m % side;
	assert_true(low[0] == 2.0f * (float)column - (float)side && low[1] == 2.0f * (float)row - (float)side);
	const int64_t next[2] = {model_at(scene->model_count, side, row, column + 1),
	                         model_at(scene->model_count, side, row + 1, column)};
	for (int k = 0; k < 2; k++)
		if (next[k] >= 0) {
			tile_corners(scene, (uint32_t)next[k], other);
			assert_int_equal(shared_corners(corners, other), 2);
		}
}

static void test_tiles_share_their_edges(void **state)
{
	(void)state;
	for (size_t c = 0; c < GRID_COUNTS; c++) {
		stilb_scene *scene = make(grid_counts[c], 3);
		uint32_t side = 1;
		while (side * side < grid_counts[c])
			side++;
		for (uint32_t m = 0; m < grid_counts[c]; m++)
			assert_tile(scene, m, side);
		stilb_scene_destroy(scene);
	}
}

static void test_spheres(void **state)
{
	(void)state;
	stilb_scene *scene = make(10000, 1);
	float least = 1.0f, most = 0.0f;
	for (uint32_t m = 0; m < scene->model_count; m++) {
		const float *s = scene->part_transform[2 * m].m, *t = scene->part_transform[2 * m + 1].m;
		float radius = s[0];
		assert_true(radius >= 0.3f && radius <= 0.9f && s[5] == radius && s[10] == radius && s[15] == 1.0f);
		assert_true(s[12] == t[12] && s[14] == t[14]); /* over the middle of its tile */
		assert_true(s[13] >= radius && s[13] <= radius + 0.3f);
		least = fminf(least, radius);
		most = fmaxf(most, radius);
	}
	assert_true(least < 0.301f && most > 0.899f);
	stilb_scene_destroy(scene);
}

static bool same_scene(const stilb_scene *a, const stilb_scene *b)
{
	return memcmp(a->part_transform, b->part_transform, a->part_count * sizeof *a->part_transform) == 0 &&
	       memcmp(a->materials, b->materials, a->material_count * sizeof *a->materials) == 0 &&
	       memcmp(a->bounds.y, b->bounds.y, a->model_count * sizeof *a->bounds.y) == 0 &&
	       memcmp(a->bounds.radius, b->bounds.radius, a->model_count * sizeof *a->bounds.radius) == 0;
}

static void test_seeds(void **state)
{
	(void)state;
	const uint64_t seeds[] = {0, 1, 2, 1000, UINT64_MAX};
	for (size_t i = 0; i < 5; i++)
		for (size_t k = 0; k <= i; k++) {
			stilb_scene *a = make(100, seeds[i]), *b = make(100, seeds[k]);
			assert_int_equal(same_scene(a, b), i == k);
			int equal = 0;
			for (uint32_t m = 0; m < 100; m++)
				equal += memcmp(&a->materials[2 * m], &b->materials[2 * m], sizeof *a->materials) == 0;
			assert_int_equal(equal, i == k ? 100 : 0);
			stilb_scene_destroy(a);
			stilb_scene_destroy(b);
		}
}

static void test_lights(void **state)
{
	(void)state;
	stilb_scene *scene = make(1, 1);
	const stilb_scene_light *sun = scene->lights;
	const float *d = sun->direction;
	assert_int_equal(scene->light_count, 1);
	assert_int_equal(sun->kind, STILB_SCENE_LIGHT_DIRECTIONAL);
	assert_float_equal(sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 1.0f, 3e-7f);
	assert_true(d[1] < -0.3f && d[1] > -0.95f); /* from above and from one side */
	for (int i = 0; i < 3; i++) {
		assert_true(sun->intensity[i] > 0.0f);
		assert_true(scene->surroundings.sky[i] > 0.0f && scene->surroundings.ground[i] > 0.0f);
	}
	for (int i = 0; i < 2; i++) { /* sun and ground are warm, the sky is blue */
		assert_true(sun->intensity[i] > sun->intensity[i + 1]);
		assert_true(scene->surroundings.ground[i] > scene->surroundings.ground[i + 1]);
		assert_true(scene->surroundings.sky[i] < scene->surroundings.sky[i + 1]);
	}
	stilb_scene_destroy(scene);
}

/* Each choice is one light of its kind and falloff, or none, without a mistake; the sun comes back as it was. */
static void test_light_choices(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		int kind;
		stilb_scene_light_falloff falloff;
	} wanted[] = {
		{"hemisphere", -1, STILB_SCENE_LIGHT_PHYSICAL},
		{"sphere", STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_PHYSICAL},
		{"disk", STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_PHYSICAL},
		{"windowed", STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_WINDOWED},
		{"subtracted", STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_SUBTRACTED},
		{"night", STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_PHYSICAL},
		{"sun", STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_PHYSICAL},
	};
	stilb_scene *scene = make(50, 1);
	stilb_scene_light first = scene->lights[0];
	for (uint32_t i = 0; i < STILB_SCENE_STRESS_LIGHT_COUNT; i++) {
		uint32_t light = (i + 1) % STILB_SCENE_STRESS_LIGHT_COUNT;
		assert_string_equal(stilb_scene_stress_light_names[light], wanted[i].name);
		stilb_scene_stress_set_light(scene, (stilb_scene_stress_light)light);
		assert_int_equal(scene->light_count, wanted[i].kind >= 0);
		assert_int_equal(scene->surroundings.glossy, wanted[i].kind < 0);
		if (wanted[i].kind < 0)
			continue;
		assert_null(stilb_scene_light_mistake(scene->lights));
		assert_int_equal(scene->lights[0].kind, wanted[i].kind);
		assert_int_equal(scene->lights[0].falloff, wanted[i].falloff);
		bool night = light == STILB_SCENE_STRESS_LIGHT_NIGHT; /* blue and dim */
		assert_int_equal(scene->lights[0].intensity[0] > scene->lights[0].intensity[2], !night);
		assert_int_equal(scene->surroundings.sky[2] < 0.1f, night);
	}
	assert_null(stilb_scene_stress_light_names[STILB_SCENE_STRESS_LIGHT_COUNT]);
	assert_memory_equal(&first, scene->lights, sizeof first);
	stilb_scene_destroy(scene);
}

/* Lamps are over the field, coloured, without a mistake, of three kinds, some eight over each point; a moment gives the
 * same bits whatever came before, and what moves at it does so in each kind's way. */
static void test_lamps(void **state)
{
	(void)state;
	enum { LAMPS = 240 };
	stilb_scene *scene = make(10000, 3), *other = make(10000, 3);
	assert_int_equal(stilb_scene_stress_add_lamps(scene, LAMPS), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(other, LAMPS), STILB_OK);
	assert_int_equal(scene->light_count, 1 + LAMPS);
	double area = 0.0;
	uint32_t kinds[STILB_SCENE_LIGHT_KINDS] = {0}, moved = 0, swung = 0;
	stilb_scene_light *before = calloc(LAMPS, sizeof *before);
	assert_non_null(before);
	memcpy(before, scene->lights + 1, LAMPS * sizeof *before);
	for (int i = 0; i < 40; i++)
		stilb_scene_stress_move_lamps(other, 0.31 * i);
	stilb_scene_stress_move_lamps(other, 2.5);
	stilb_scene_stress_move_lamps(scene, 2.5);
	assert_memory_equal(scene->lights, other->lights, (1 + LAMPS) * sizeof *scene->lights);
	for (uint32_t i = 0; i < LAMPS; i++) {
		const stilb_scene_light *lamp = &scene->lights[1 + i];
		assert_null(stilb_scene_light_mistake(lamp));
		float field = 100.0f + 0.4f * lamp->reach; /* circles may leave it */
		assert_true(fabsf(before[i].position[0]) <= field && fabsf(before[i].position[2]) <= field);
		assert_true(lamp->position[1] > 1.0f && lamp->position[1] < lamp->reach);
		assert_true(lamp->falloff == STILB_SCENE_LIGHT_WINDOWED);
		area += 3.14159265 * (double)lamp->reach * (double)lamp->reach;
		kinds[lamp->kind]++;
		moved += memcmp(lamp->position, before[i].position, sizeof lamp->position) != 0;
		swung += memcmp(lamp->direction, before[i].direction, sizeof lamp->direction) != 0;
	}
	assert_true(fabs(area / 200.0 / 200.0 - 8.0) < 0.5);
	assert_int_equal(kinds[STILB_SCENE_LIGHT_SPOT], LAMPS / 4);
	assert_int_equal(kinds[STILB_SCENE_LIGHT_SPHERE], LAMPS / 4);
	assert_int_equal(kinds[STILB_SCENE_LIGHT_POINT], LAMPS / 2);
	assert_int_equal(moved, LAMPS / 4);
	assert_int_equal(swung, LAMPS / 4);
	stilb_scene_stress_set_light(scene, STILB_SCENE_STRESS_LIGHT_HEMISPHERE); /* none but the lamps */
	assert_int_equal(scene->light_count, 1 + LAMPS);
	assert_float_equal(scene->lights[0].intensity[1], 0.0f, 0.0f);
	assert_null(stilb_scene_light_mistake(scene->lights));
	free(before);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(other);
}

/* Bulbs hang on strings of fifty: neighbours equally far apart along one axis, the middle lower than the ends, and the
 * whole string over the field at any time. */
static void test_strings(void **state)
{
	(void)state;
	enum { LAMPS = 230, WHOLE = LAMPS / STILB_SCENE_STRING };
	stilb_scene *scene = make(900, 3);
	assert_int_equal(stilb_scene_stress_add_lamps(scene, LAMPS), STILB_OK);
	stilb_scene_stress_hang_strings(scene);
	float across[WHOLE + 1];
	for (int moment = 0; moment < 20; moment++) {
		stilb_scene_stress_move_lamps(scene, 0.37 * moment);
		assert_int_equal(scene->light_count, 1 + LAMPS);
		for (uint32_t i = 0; i < LAMPS; i++) {
			const stilb_scene_light *bulb = &scene->lights[1 + i], *before = bulb - 1;
			uint32_t string = i / STILB_SCENE_STRING, along = string % 2 == 0 ? 0 : 2, place = i % STILB_SCENE_STRING;
			assert_null(stilb_scene_light_mistake(bulb));
			assert_true(bulb->intensity[0] > bulb->intensity[1] && bulb->intensity[1] > bulb->intensity[2]);
			assert_true(fabsf(bulb->position[0]) < 30.5f && fabsf(bulb->position[2]) < 30.5f);
			assert_true(place != STILB_SCENE_STRING / 2 || bulb->position[1] < 2.81f);
			assert_true(bulb->position[1] > 2.79f && bulb->position[1] < 3.6f);
			if (place == 0) {
				across[string] = bulb->position[2 - along];
				continue;
			}
			assert_true(fabsf(bulb->position[along] - before->position[along] - 30.0f / STILB_SCENE_STRING) < 1e-4f);
			assert_int_equal(bulb->position[1] < before->position[1], place <= STILB_SCENE_STRING / 2 - 1);
			assert_true(fabsf(bulb->position[2 - along] - across[string]) < 0.2f);
		}
	}
	stilb_scene_destroy(scene);
}

/* ---- bounds and animation ---------------------------------------------------------------------------------------- */

/* Bounds hold every vertex and are tight. */
static void assert_bounds(const stilb_scene *scene, uint32_t m)
{
	float p[3];
	double farthest = 0.0, radius = (double)scene->bounds.radius[m];
	const double center[3] = {(double)scene->bounds.x[m], (double)scene->bounds.y[m], (double)scene->bounds.z[m]};
	for (uint32_t v = 0; model_vertex(scene, m, v, p); v++) {
		double distance = 0.0;
		for (int i = 0; i < 3; i++)
			distance += ((double)p[i] - center[i]) * ((double)p[i] - center[i]);
		farthest = fmax(farthest, sqrt(distance));
	}
	assert_true(farthest <= radius && farthest > radius - 0.01);
}

static void test_bounds(void **state)
{
	(void)state;
	stilb_scene *scene = make(2500, 5);
	for (uint32_t m = 0; m < scene->model_count; m++)
		assert_bounds(scene, m);
	for (int step = 0; step < 40; step++) {
		stilb_scene_animate(scene, 0.1 * step);
		for (uint32_t i = 0; i < scene->moved_count; i++)
			assert_bounds(scene, scene->moved[i]);
	}
	stilb_scene_destroy(scene);
}

static void test_animate_moves_a_tenth(void **state)
{
	(void)state;
	const uint32_t counts[] = {1, 2, 9, 10, 11, 1000, 1001};
	for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
		stilb_scene *rest = make(counts[c], 1), *scene = make(counts[c], 1);
		stilb_scene_animate(scene, 1.234);
		assert_int_equal(scene->moved_count, (counts[c] + 9) / 10);
		for (uint32_t i = 0; i < scene->moved_count; i++)
			assert_int_equal(scene->moved[i], 10 * i);
		for (uint32_t m = 0; m < counts[c]; m++) {
			const stilb_mat4 *a = &rest->part_transform[2 * m], *b = &scene->part_transform[2 * m];
			bool moved = memcmp(&a[0], &b[0], sizeof *a) != 0;
			assert_int_equal(moved, m % 10 == 0);
			assert_memory_equal(&a[1], &b[1], sizeof *a); /* tiles lie still */
			assert_true(b->m[12] == a->m[12] && b->m[14] == a->m[14] && b->m[0] == a->m[0]);
			assert_true(b->m[13] >= a->m[13] && b->m[13] <= a->m[13] + 0.61f);
			if (m % 10 != 0)
				assert_true(rest->bounds.y[m] == scene->bounds.y[m] &&
				            rest->bounds.radius[m] == scene->bounds.radius[m]);
		}
		assert_memory_equal(rest->materials, scene->materials, rest->material_count * sizeof *rest->materials);
		stilb_scene_destroy(rest);
		stilb_scene_destroy(scene);
	}
}

static void test_animate_is_a_function_of_time(void **state)
{
	(void)state;
	stilb_scene *once = make(500, 9), *often = make(500, 9);
	stilb_scene_animate(once, 1.25);
	const double times[] = {0.0, 7.0, -3.0, 1e6, 1.25};
	for (size_t i = 0; i < 5; i++) {
		stilb_scene_animate(often, times[i]);
		assert_int_equal(often->moved_count, 50);
		assert_int_equal(same_scene(once, often), i == 4);
	}
	stilb_scene_destroy(once);
	stilb_scene_destroy(often);
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

static const float aspects[] = {0.2f, 0.5f, 9.0f / 16.0f, 1.0f, 4.0f / 3.0f, 16.0f / 9.0f, 21.0f / 9.0f, 5.0f};
#define ASPECTS (sizeof aspects / sizeof *aspects)

/* Every vertex of model m lies in clip space. */
static bool model_in_picture(const stilb_scene *scene, uint32_t m, const float *matrix)
{
	float p[3];
	for (uint32_t v = 0; model_vertex(scene, m, v, p); v++) {
		float clip[4];
		for (int row = 0; row < 4; row++)
			clip[row] = matrix[row] * p[0] + matrix[4 + row] * p[1] + matrix[8 + row] * p[2] + matrix[12 + row];
		if (!(fabsf(clip[0]) <= clip[3] && fabsf(clip[1]) <= clip[3] && clip[2] >= 0.0f && clip[2] <= clip[3]))
			return false;
	}
	return true;
}

static uint32_t models_in_picture(const stilb_scene *scene, const stilb_scene_camera *camera, float aspect)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(camera, aspect);
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++)
		count += model_in_picture(scene, m, matrix.m);
	return count;
}

/* The number of models whose bounds touch the frustum, which culling keeps. */
static uint32_t models_in_frustum(const stilb_scene *scene, const stilb_scene_camera *camera, float aspect)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(camera, aspect);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++) {
		bool inside = true;
		for (int i = 0; i < 6 && inside; i++) {
			stilb_plane p = frustum.planes[i];
			inside = p.x * scene->bounds.x[m] + p.y * scene->bounds.y[m] + p.z * scene->bounds.z[m] + p.distance >=
			         -scene->bounds.radius[m];
		}
		count += inside;
	}
	return count;
}

static void test_view_all_sees_everything(void **state)
{
	(void)state;
	const uint32_t counts[] = {1, 2, 7, 100, 10000};
	for (size_t c = 0; c < 5; c++) {
		stilb_scene *scene = make(counts[c], 1);
		for (size_t a = 0; a < ASPECTS; a++) {
			stilb_scene_camera camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, aspects[a]);
			assert_int_equal(models_in_picture(scene, &camera, aspects[a]), counts[c]);
			assert_int_equal(models_in_frustum(scene, &camera, aspects[a]), counts[c]);
			/* The distance is needed: a fifth nearer, something is outside. */
			for (int i = 0; i < 3; i++)
				camera.position[i] *= 0.8f;
			if (counts[c] == 10000)
				assert_true(models_in_picture(scene, &camera, aspects[a]) < counts[c]);
		}
		for (int step = 0; step < 10; step++) { /* moving spheres stay inside */
			stilb_scene_animate(scene, 0.35 * step);
			stilb_scene_camera camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 1.0f);
			assert_int_equal(models_in_picture(scene, &camera, 1.0f), counts[c]);
		}
		stilb_scene_destroy(scene);
	}
}

static void assert_usable(const stilb_scene_camera *camera)
{
	for (int i = 0; i < 3; i++)
		assert_true(isfinite(camera->position[i]));
	assert_true(camera->position[1] > 0.5f); /* above the ground */
	assert_true(camera->near_z > 0.0f && camera->far_z > camera->near_z && isfinite(camera->far_z));
	assert_true(fabsf(camera->pitch) < 1.55f && camera->fov_y > 0.1f && camera->fov_y < 2.0f);
}

static void test_views_see_their_share(void **state)
{
	(void)state;
	stilb_scene *scene = make(10000, 1);
	for (size_t a = 0; a < ASPECTS; a++) {
		stilb_scene_camera half = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_HALF, aspects[a]);
		stilb_scene_camera few = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_FEW, aspects[a]);
		assert_usable(&half);
		assert_usable(&few);
		assert_in_range(models_in_frustum(scene, &half, aspects[a]), 4500, 5500);
		assert_in_range(models_in_frustum(scene, &few, aspects[a]), 50, 200);
	}
	stilb_scene_destroy(scene);
}

static void test_views_of_few_and_many_models(void **state)
{
	(void)state;
	const uint32_t counts[] = {1, 2, 7, 100, 250001};
	for (size_t c = 0; c < 5; c++) {
		stilb_scene *scene = make(counts[c], 2);
		for (size_t a = 0; a < ASPECTS; a++)
			for (int view = STILB_SCENE_VIEW_ALL; view <= STILB_SCENE_VIEW_FEW; view++) {
				stilb_scene_camera camera = stilb_scene_stress_camera(scene, (stilb_scene_stress_view)view, aspects[a]);
				assert_usable(&camera);
				assert_true(models_in_frustum(scene, &camera, aspects[a]) >= 1); /* never an empty picture */
			}
		stilb_scene_destroy(scene);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sphere_mesh),
		cmocka_unit_test(test_plane_mesh),
		cmocka_unit_test(test_material_make),
		cmocka_unit_test(test_material_colors),
		cmocka_unit_test(test_parts_and_materials),
		cmocka_unit_test(test_tiles_share_their_edges),
		cmocka_unit_test(test_spheres),
		cmocka_unit_test(test_seeds),
		cmocka_unit_test(test_lights),
		cmocka_unit_test(test_light_choices),
		cmocka_unit_test(test_bounds),
		cmocka_unit_test(test_lamps),
		cmocka_unit_test(test_strings),
		cmocka_unit_test(test_animate_moves_a_tenth),
		cmocka_unit_test(test_animate_is_a_function_of_time),
		cmocka_unit_test(test_view_all_sees_everything),
		cmocka_unit_test(test_views_see_their_share),
		cmocka_unit_test(test_views_of_few_and_many_models),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
