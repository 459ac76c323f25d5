/* scene_tangents: the same splits, signs and directions as the public implementation of MikkTSpace on random and
 * classic meshes, glTF's convention, and numbers that are none. */
#include "support/failing_alloc.h"
#include "support/test.h"
#include "tangents_meshes.h"
#include "tangents_reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of each, since they are large. */
static tangents_mesh the_mesh;
static float the_tangents[TANGENTS_MOST_INDICES][4];

static void make(const tangents_mesh *mesh, float (*tangents)[4])
{
	assert_true(mesh->vertex_count <= TANGENTS_MOST_VERTICES && mesh->index_count <= TANGENTS_MOST_INDICES);
	scene_tangents_mesh view = tangents_view(mesh);
	assert_int_equal(scene_tangents_make(&view, tangents), STILB_OK);
}

/* ---- the reference ----------------------------------------------------------------------------------------------- */

static bool same_floats(const float *a, const float *b, int count)
{
	for (int i = 0; i < count; i++)
		if (a[i] != b[i])
			return false;
	return true;
}

/* The first corner with the same values and the same tangent. */
static uint32_t first_alike(const tangents_mesh *mesh, const float (*tangents)[4], uint32_t corner)
{
	uint32_t v = mesh->indices[corner], c = 0;
	for (;; c++) {
		uint32_t w = mesh->indices[c];
		if (same_floats(tangents[c], tangents[corner], 4) && same_floats(mesh->positions[w], mesh->positions[v], 3) &&
		    same_floats(mesh->normals[w], mesh->normals[v], 3) && same_floats(mesh->uvs[w], mesh->uvs[v], 2))
			return c;
	}
}

static tangents_sum sum_up(const tangents_mesh *mesh, const float (*tangents)[4])
{
	tangents_sum sum = {.splits = STILB_FNV1A64_START};
	for (uint32_t c = 0; c < mesh->index_count; c++) {
		uint32_t words[2] = {first_alike(mesh, tangents, c), tangents[c][3] < 0.0f};
		sum.splits = stilb_hash_fnv1a64(sum.splits, words, sizeof words);
		for (uint32_t k = 0; k < 3; k++)
			for (int j = 0; j < 2; j++) {
				uint32_t byte = (3 * c + k + 1) * 2654435761u >> (8 + 8 * j) & 255;
				sum.sums[j] += ((double)byte / 128 - 1) * (double)tangents[c][k];
			}
	}
	return sum;
}

static void test_random_meshes(void **state)
{
	(void)state;
	for (uint32_t seed = 0; seed < TANGENTS_RANDOM; seed += TEST_ASAN ? 5 : 1) {
		tangents_random(&the_mesh, seed);
		make(&the_mesh, the_tangents);
		tangents_sum ours = sum_up(&the_mesh, (const float(*)[4])the_tangents);
		const tangents_sum *theirs = &tangents_sums[seed];
		for (uint32_t c = 0; c < the_mesh.index_count; c++)
			for (int k = 0; k < 3; k++) /* no -0, so that equal tangents have equal bits */
				assert_false(the_tangents[c][k] == 0.0f && signbit(the_tangents[c][k]));
		if (ours.splits != theirs->splits)
			fail_msg("mesh %u has other splits or signs", seed);
		for (int j = 0; j < 2; j++)
			if (!(fabs(ours.sums[j] - theirs->sums[j]) <= 1e-6))
				fail_msg("mesh %u has other directions: %.9f is not %.9f", seed, ours.sums[j], theirs->sums[j]);
	}
}

static void test_classic_meshes(void **state)
{
	(void)state;
	uint32_t row = 0;
	for (tangents_classic classic = 0; classic < TANGENTS_CLASSICS; classic++) {
		float theirs[TANGENTS_MOST_INDICES][4];
		tangents_make_classic(&the_mesh, classic);
		make(&the_mesh, the_tangents);
		memcpy(theirs, tangents_classic_bits[row], the_mesh.index_count * sizeof *theirs);
		row += the_mesh.index_count;
		for (uint32_t c = 0; c < the_mesh.index_count; c++) {
			for (int k = 0; k < 3; k++)
				assert_true(fabsf(the_tangents[c][k] - theirs[c][k]) <= 1e-6f);
			assert_true(the_tangents[c][3] == theirs[c][3]);
			assert_int_equal(first_alike(&the_mesh, (const float(*)[4])the_tangents, c),
			                 first_alike(&the_mesh, (const float(*)[4])theirs, c));
		}
	}
}

/* ---- what must hold ---------------------------------------------------------------------------------------------- */

/* A tangent is unit and perpendicular to a normal of any length, as the header says. */
static void check_tangent(const float normal[3], const float tangent[4])
{
	double square = 0.0, along = 0.0, length = 0.0;
	for (int k = 0; k < 3; k++) {
		assert_true(isfinite(tangent[k]));
		square += (double)tangent[k] * (double)tangent[k];
		along += (double)normal[k] * (double)tangent[k];
		length += (double)normal[k] * (double)normal[k];
	}
	assert_true(fabs(square - 1.0) <= 1.001e-3);
	if (isfinite(length) && length > 0.0)
		assert_true(fabs(along) <= 1.001e-3 * sqrt(length));
	assert_true(fabsf(tangent[3]) == 1.0f);
}

static void check_all(const tangents_mesh *mesh, const float (*tangents)[4])
{
	for (uint32_t c = 0; c < mesh->index_count; c++)
		check_tangent(mesh->normals[mesh->indices[c]], tangents[c]);
}

/* On a square in the plane of x and y whose texture stands upright (v = 1 - y, as glTF has it) tangent and bitangent
 * are the axes; mirrored, the tangent is turned and the bitangent is not. */
static void test_the_convention_of_gltf(void **state)
{
	(void)state;
	static const float positions[4][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, normal[3] = {0, 0, 1};
	static const float upright[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}},
					   mirrored[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	for (int turned = 0; turned < 2; turned++) {
		scene_tangents_mesh mesh = {
			.positions = positions[0],
			.normals = normal, /* one for all */
			.uvs = turned ? mirrored[0] : upright[0],
			.position_stride = sizeof positions[0],
			.uv_stride = sizeof upright[0],
			.indices = indices,
			.vertex_count = 4,
			.index_count = 6,
		};
		assert_int_equal(scene_tangents_make(&mesh, the_tangents), STILB_OK);
		for (int c = 0; c < 6; c++) {
			float expected[4] = {turned ? -1 : 1, 0, 0, turned ? -1 : 1};
			assert_memory_equal(the_tangents[c], expected, sizeof expected);
			/* The bitangent cross(normal, tangent) * w is +Y. */
			assert_true(the_tangents[c][0] * the_tangents[c][3] == 1.0f);
		}
	}
}

/* Triangles in another order, beginning with another corner, have the same tangents. */
static void test_the_order_of_triangles_does_not_matter(void **state)
{
	(void)state;
	for (tangents_classic classic = 0; classic < TANGENTS_CLASSICS; classic++) {
		tangents_mesh other;
		float tangents[TANGENTS_MOST_INDICES][4];
		tangents_make_classic(&the_mesh, classic);
		make(&the_mesh, the_tangents);
		other = the_mesh;
		uint32_t count = other.index_count / 3;
		for (uint32_t f = 0; f < count; f++)
			for (uint32_t k = 0; k < 3; k++)
				other.indices[3 * (f * 7 % count) + (k + f) % 3] = the_mesh.indices[3 * f + k];
		make(&other, tangents);
		for (uint32_t f = 0; f < count; f++)
			for (uint32_t k = 0; k < 3; k++)
				for (int i = 0; i < 4; i++)
					assert_true(fabsf(tangents[3 * (f * 7 % count) + (k + f) % 3][i] - the_tangents[3 * f + k][i]) <=
					            1e-6f);
	}
}

/* Each corner with a vertex of its own, all numbers in one array, and zeros with either sign: the same bits. */
static void test_indices_and_strides_do_not_matter(void **state)
{
	(void)state;
	static float vertices[TANGENTS_MOST_INDICES][9], tangents[TANGENTS_MOST_INDICES][4];
	uint32_t indices[TANGENTS_MOST_INDICES];
	for (uint32_t seed = 0; seed < 100; seed++) {
		tangents_random(&the_mesh, seed);
		make(&the_mesh, the_tangents);
		for (uint32_t c = 0; c < the_mesh.index_count; c++) {
			uint32_t v = the_mesh.indices[c];
			memcpy(vertices[c], the_mesh.positions[v], 12);
			memcpy(vertices[c] + 3, the_mesh.normals[v], 12);
			memcpy(vertices[c] + 6, the_mesh.uvs[v], 8);
			vertices[c][8] = NAN; /* not to be read */
			for (int i = 0; i < 8; i++)
				if (vertices[c][i] == 0.0f)
					vertices[c][i] = c % 2 == 0 ? -0.0f : 0.0f;
			indices[c] = c;
		}
		scene_tangents_mesh mesh = {
			.positions = vertices[0],
			.normals = vertices[0] + 3,
			.uvs = vertices[0] + 6,
			.position_stride = sizeof vertices[0],
			.normal_stride = sizeof vertices[0],
			.uv_stride = sizeof vertices[0],
			.indices = indices,
			.vertex_count = the_mesh.index_count,
			.index_count = the_mesh.index_count,
		};
		assert_int_equal(scene_tangents_make(&mesh, tangents), STILB_OK);
		assert_memory_equal(tangents, the_tangents, the_mesh.index_count * sizeof *tangents);
	}
}

/* ---- numbers that are none --------------------------------------------------------------------------------------- */

static void test_any_numbers_give_tangents(void **state)
{
	(void)state;
	static const float odd[] = {NAN, -NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-40f, 1e-30f, -1e-22f, 1e20f, 0.0f};
	for (uint32_t seed = 0; seed < 1000; seed++) {
		tangents_random(&the_mesh, seed);
		for (uint32_t i = 0; i < 1 + seed % 40; i++) {
			uint64_t draw = stilb_random_u64(seed, i);
			uint32_t v = (uint32_t)(draw % (the_mesh.vertex_count - 3)); /* all but the last triangle */
			float value = odd[draw / 1000 % (sizeof odd / sizeof *odd)];
			float *numbers[8] = {the_mesh.positions[v], the_mesh.positions[v] + 1, the_mesh.positions[v] + 2,
			                     the_mesh.normals[v],   the_mesh.normals[v] + 1,   the_mesh.normals[v] + 2,
			                     the_mesh.uvs[v],       the_mesh.uvs[v] + 1};
			*numbers[draw >> 32 & 7] = value;
		}
		make(&the_mesh, the_tangents);
		check_all(&the_mesh, (const float(*)[4])the_tangents);
		/* The last triangle is as before. */
		float expected[4] = {1, 0, 0, -1};
		for (uint32_t c = the_mesh.index_count - 3; c < the_mesh.index_count; c++)
			assert_memory_equal(the_tangents[c], expected, sizeof expected);
	}
}

/* Meshes that are all too small or too large for the squares of their edges. */
static void test_any_size_gives_tangents(void **state)
{
	(void)state;
	static const float scales[] = {1e-36f, 1e-25f, 1e-18f, 1e18f, 1e25f, 1e36f};
	for (size_t i = 0; i < sizeof scales / sizeof *scales; i++)
		for (tangents_classic classic = 0; classic < TANGENTS_CLASSICS; classic++) {
			tangents_make_classic(&the_mesh, classic);
			for (uint32_t v = 0; v < the_mesh.vertex_count; v++)
				for (int k = 0; k < 3; k++)
					the_mesh.positions[v][k] *= scales[i];
			make(&the_mesh, the_tangents);
			check_all(&the_mesh, (const float(*)[4])the_tangents);
		}
}

/* Fills *mesh with vertices whose normals point to +Z. */
static void set_vertices(tangents_mesh *mesh, uint32_t count, const float (*places)[5])
{
	*mesh = (tangents_mesh){.vertex_count = count};
	for (uint32_t v = 0; v < count; v++) {
		memcpy(mesh->positions[v], places[v], sizeof mesh->positions[v]);
		mesh->normals[v][2] = 1.0f;
		memcpy(mesh->uvs[v], places[v] + 3, sizeof mesh->uvs[v]);
	}
}

static void set_indices(tangents_mesh *mesh, uint32_t count, const uint32_t *indices)
{
	mesh->index_count = count;
	memcpy(mesh->indices, indices, count * sizeof *indices);
}

static void check_corner(uint32_t corner, float x, float y, float z, float w)
{
	float expected[4] = {x, y, z, w};
	for (int k = 0; k < 4; k++)
		assert_true(fabsf(the_tangents[corner][k] - expected[k]) <= 1e-6f);
}

/* A triangle keeps its tangents whatever its neighbour's third vertex is. */
static void test_bad_numbers_stay_in_their_triangles(void **state)
{
	(void)state;
	static const float places[4][5] = {{0, 0, 0, 0, 0}, {0, 1, 0, 1, 0}, {-1, 1, 0, 1, 1}, {-1, 0, 0, 0, 1}};
	static const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	for (size_t i = 0; i < 5 * sizeof odd / sizeof *odd; i++) {
		set_vertices(&the_mesh, 4, places);
		set_indices(&the_mesh, 6, indices);
		*(i % 5 < 3 ? &the_mesh.positions[3][i % 5] : &the_mesh.uvs[3][i % 5 - 3]) = odd[i / 5];
		make(&the_mesh, the_tangents);
		for (uint32_t c = 0; c < 3; c++)
			check_corner(c, 0, 1, 0, -1);
		check_corner(5, 1, 0, 0, 1); /* in no group */
	}
}

/* With an area on the texture, but u or v does not move on the triangle. Then it has no direction; on a line, where
 * both do, it has. */
static void test_triangles_on_a_line(void **state)
{
	(void)state;
	static const uint32_t indices[3] = {0, 1, 2};
	static const float without_v[3][5] = {{0, 0, 0, 0, 0}, {0, 1, 0, 1, 1}, {0, 2, 0, 2, 0}};
	static const float without_u[3][5] = {{0, 0, 0, 0, 0}, {0, 1, 0, 1, 1}, {0, 2, 0, 0, 2}};
	static const float with_both[3][5] = {{0, 0, 0, 0, 0}, {0, 1, 0, 1, 1}, {0, 2, 0, 3, 1}};
	set_vertices(&the_mesh, 3, without_v);
	set_indices(&the_mesh, 3, indices);
	make(&the_mesh, the_tangents);
	check_corner(0, 1, 0, 0, 1);
	set_vertices(&the_mesh, 3, without_u);
	set_indices(&the_mesh, 3, indices);
	make(&the_mesh, the_tangents);
	check_corner(0, 1, 0, 0, 1);
	set_vertices(&the_mesh, 3, with_both);
	set_indices(&the_mesh, 3, indices);
	make(&the_mesh, the_tangents);
	check_corner(1, 0, 1, 0, 1);
}

/* Vertex 0 has a mapped triangle and two without directions. The second of those, of which no other corner is in a
 * group, has a mirrored neighbour on the far side: it stays mapped, whichever of its corners comes first. */
static void test_a_triangle_without_direction_takes_one_side(void **state)
{
	(void)state;
	static const float places[6][5] = {{0, 0, 0, 0, 0},  {1, 0, 0, 1, 0},   {1, 1, 0, 1, 1},
	                                   {-1, 1, 0, 2, 2}, {-1, -1, 0, 3, 3}, {-2, 0, 0, 2, 4}};
	for (uint32_t turn = 0; turn < 3; turn++) {
		uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 0, 0, 0, 4, 3, 5};
		static const uint32_t triangle[3] = {0, 3, 4};
		for (uint32_t k = 0; k < 3; k++)
			indices[6 + (k + turn) % 3] = triangle[k];
		set_vertices(&the_mesh, 6, places);
		set_indices(&the_mesh, 12, indices);
		make(&the_mesh, the_tangents);
		check_corner(0, 1, 0, 0, -1);
		check_corner(3, 1, 0, 0, -1);
		check_corner(6 + turn, 1, 0, 0, -1);
		check_corner(6 + (1 + turn) % 3, 1, 0, 0, 1); /* in no group */
		check_corner(6 + (2 + turn) % 3, 1, 0, 0, 1);
		assert_true(the_tangents[9][3] == 1.0f && the_tangents[9][0] < 0.9f);
	}
}

/* u grows along the normal but for a millionth of it, so that most of the projection is rounding. */
static void test_directions_along_the_normal(void **state)
{
	(void)state;
	static const float normal[3] = {2 / 7.0f, 3 / 7.0f, 6 / 7.0f}, across[3] = {6 / 7.0f, 2 / 7.0f, -3 / 7.0f};
	static const float places[3][5] = {{0, 0, 0, 0, 0}, {0, 0, 0, 1, 0}, {3 / 7.0f, -6 / 7.0f, 2 / 7.0f, 0, 1}};
	static const uint32_t indices[3] = {0, 1, 2};
	for (float tilt = 1e-2f; tilt > 5e-6f; tilt *= 0.8f) {
		set_vertices(&the_mesh, 3, places);
		set_indices(&the_mesh, 3, indices);
		for (int k = 0; k < 3; k++)
			the_mesh.positions[1][k] = normal[k] + tilt * across[k];
		for (int v = 0; v < 3; v++)
			memcpy(the_mesh.normals[v], normal, sizeof normal);
		make(&the_mesh, the_tangents);
		check_all(&the_mesh, (const float(*)[4])the_tangents);
		for (int k = 0; k < 3; k++)
			assert_true(fabsf(the_tangents[0][k] - across[k]) <= 3e-7f / tilt);
	}
}

static void test_normals_of_any_length(void **state)
{
	(void)state;
	float expected[TANGENTS_MOST_INDICES][4];
	tangents_make_classic(&the_mesh, TANGENTS_HELMET);
	make(&the_mesh, expected);
	static const float scales[] = {1e-38f, 0.5f, 1.01f, 3.0f, 3e38f};
	for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
		tangents_make_classic(&the_mesh, TANGENTS_HELMET);
		for (uint32_t v = 0; v < the_mesh.vertex_count; v++)
			for (int k = 0; k < 3; k++)
				the_mesh.normals[v][k] *= scales[i];
		make(&the_mesh, the_tangents);
		for (uint32_t c = 0; c < the_mesh.index_count; c++)
			for (int k = 0; k < 4; k++)
				assert_true(fabsf(the_tangents[c][k] - expected[c][k]) <= 1e-5f);
	}
}

/* Many vertices with NaN take no longer: if each was compared with those before it, this would take minutes. */
static void test_many_vertices_without_numbers(void **state)
{
	(void)state;
	uint32_t count = 600000;
	static const float nothing[3] = {NAN, NAN, NAN}, up[3] = {0, 0, 1};
	uint32_t *indices = malloc(count * sizeof *indices);
	float(*tangents)[4] = malloc(count * sizeof *tangents);
	assert_true(indices && tangents);
	for (uint32_t c = 0; c < count; c++)
		indices[c] = c;
	scene_tangents_mesh mesh = {
		.positions = nothing,
		.normals = up,
		.uvs = up,
		.indices = indices,
		.vertex_count = count,
		.index_count = count,
	};
	assert_int_equal(scene_tangents_make(&mesh, tangents), STILB_OK);
	float expected[4] = {1, 0, 0, 1};
	for (uint32_t c = 0; c < count; c++)
		assert_memory_equal(tangents[c], expected, sizeof expected);
	free(indices);
	free(tangents);
}

/* ---- large fans -------------------------------------------------------------------------------------------------- */

/* A fan in the plane of x and y: `half` triangles over 45 degrees with u along x, one without an angle, and `half` over
 * 90 degrees with u against x; v grows along (shear, 1) and (shear, -1). True if the first half has a
 * tangent of its own in the middle; else all have that of the second half. */
static bool middle_of_fan(uint32_t half, float shear)
{
	uint32_t outer = 2 * half + 2, count = outer - 1;
	float(*positions)[3] = calloc(outer + 1, sizeof *positions), (*uvs)[2] = calloc(outer + 1, sizeof *uvs);
	uint32_t *indices = malloc(3 * (size_t)count * sizeof *indices);
	float(*tangents)[4] = malloc(3 * (size_t)count * sizeof *tangents);
	static const float up[3] = {0, 0, 1};
	assert_true(positions && uvs && indices && tangents);
	for (uint32_t i = 0; i < outer; i++) {
		bool first = i <= half;
		float along = (float)(first ? i : i - half - 1) / (float)half;
		positions[i + 1][0] = first ? 1 : 2 - 4 * along;
		positions[i + 1][1] = first ? along : 2;
		uvs[i + 1][0] = (first ? positions[i + 1][0] : -positions[i + 1][0]) - shear * positions[i + 1][1];
		uvs[i + 1][1] = first ? positions[i + 1][1] : -positions[i + 1][1];
	}
	for (uint32_t i = 0; i < count; i++)
		memcpy(indices + 3 * (size_t)i, (const uint32_t[3]){0, i + 1, i + 2}, 3 * sizeof *indices);
	scene_tangents_mesh mesh = {
		.positions = positions[0],
		.normals = up,
		.uvs = uvs[0],
		.position_stride = sizeof *positions,
		.uv_stride = sizeof *uvs,
		.indices = indices,
		.vertex_count = outer + 1,
		.index_count = 3 * count,
	};
	assert_int_equal(scene_tangents_make(&mesh, tangents), STILB_OK);
	for (uint32_t i = 0; i < count; i++) {
		float expected[4] = {i < half && tangents[0][0] > 0 ? 1 : -1, 0, 0, -1};
		for (int k = 0; k < 4; k++)
			assert_true(fabsf(tangents[3 * (size_t)i][k] - expected[k]) <= 1e-3f);
	}
	bool own = tangents[0][0] > 0;
	free(positions);
	free(uvs);
	free(indices);
	free(tangents);
	return own;
}

static void test_opposite_directions_are_not_summed(void **state)
{
	(void)state;
	assert_true(middle_of_fan(1, 0.0f));
	assert_true(middle_of_fan(50, 0.0f));
	assert_true(middle_of_fan(50, 4.0f));    /* only u is opposite */
	assert_true(middle_of_fan(2047, 0.0f));  /* 4,095 triangles */
	assert_false(middle_of_fan(2048, 0.0f)); /* too many to compare */
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

static void test_without_memory(void **state)
{
	(void)state;
	tangents_make_classic(&the_mesh, TANGENTS_HELMET);
	scene_tangents_mesh view = tangents_view(&the_mesh);
	allocated = 0;
	assert_int_equal(scene_tangents_make(&view, the_tangents), STILB_OK);
	int count = allocated;
	assert_true(count > 10);
	for (int i = 0; i < count; i++) {
		fail_after = i;
		assert_int_equal(scene_tangents_make(&view, the_tangents), STILB_ERROR_MEMORY);
		assert_string_equal(stilb_error_message(), "no memory for the tangents of 65 triangles");
	}
	fail_after = -1;
}

static void test_no_triangles(void **state)
{
	(void)state;
	assert_int_equal(scene_tangents_make(&(scene_tangents_mesh){0}, NULL), STILB_OK);
}

/* For the script of tangents_reference.h: of each mesh the counts of vertices and indices, positions, normals, uv and
 * indices, in the machine's order of bytes. */
static int write_meshes(const char *path)
{
	FILE *file = fopen(path, "wb");
	for (uint32_t i = 0; file && i < TANGENTS_RANDOM + TANGENTS_CLASSICS; i++) {
		if (i < TANGENTS_RANDOM)
			tangents_random(&the_mesh, i);
		else
			tangents_make_classic(&the_mesh, i - TANGENTS_RANDOM);
		fwrite(&the_mesh.vertex_count, sizeof the_mesh.vertex_count, 1, file);
		fwrite(&the_mesh.index_count, sizeof the_mesh.index_count, 1, file);
		fwrite(the_mesh.positions, sizeof the_mesh.positions[0], the_mesh.vertex_count, file);
		fwrite(the_mesh.normals, sizeof the_mesh.normals[0], the_mesh.vertex_count, file);
		fwrite(the_mesh.uvs, sizeof the_mesh.uvs[0], the_mesh.vertex_count, file);
		fwrite(the_mesh.indices, sizeof the_mesh.indices[0], the_mesh.index_count, file);
	}
	bool good = file && !ferror(file);
	return file && fclose(file) == 0 && good ? 0 : 1;
}

int main(int argc, char **argv)
{
	if (argc > 1)
		return write_meshes(argv[1]);
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_random_meshes),
		cmocka_unit_test(test_classic_meshes),
		cmocka_unit_test(test_the_convention_of_gltf),
		cmocka_unit_test(test_the_order_of_triangles_does_not_matter),
		cmocka_unit_test(test_indices_and_strides_do_not_matter),
		cmocka_unit_test(test_any_numbers_give_tangents),
		cmocka_unit_test(test_any_size_gives_tangents),
		cmocka_unit_test(test_bad_numbers_stay_in_their_triangles),
		cmocka_unit_test(test_triangles_on_a_line),
		cmocka_unit_test(test_a_triangle_without_direction_takes_one_side),
		cmocka_unit_test(test_directions_along_the_normal),
		cmocka_unit_test(test_normals_of_any_length),
		cmocka_unit_test(test_many_vertices_without_numbers),
		cmocka_unit_test(test_opposite_directions_are_not_summed),
		cmocka_unit_test(test_without_memory),
		cmocka_unit_test(test_no_triangles),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
