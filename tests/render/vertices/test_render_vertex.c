/* Packed vertices: what packing rounds is within the bounds that render_vertex.h states, all else keeps its bits, and
 * a stream that a table has and another has not is packed without a line of render's. */
#include "render/render_dump_format.h"
#include "render/render_vertex.h"
#include "support/test.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if TEST_TSAN || TEST_ASAN
#define DIRECTIONS 20000u
#else
#define DIRECTIONS 1000000u
#endif
#define BLOCK 1000u

static double angle(const float a[3], const float b[3])
{
	double cross[3], square = 0.0;
	for (int c = 0; c < 3; c++) {
		int d = (c + 1) % 3, e = (c + 2) % 3;
		cross[c] = (double)a[d] * (double)b[e] - (double)a[e] * (double)b[d];
		square += cross[c] * cross[c];
	}
	return asin(fmin(sqrt(square), 1.0));
}

/* Directions spread over the sphere; every seventh one lies in a plane of two axes or on an axis. */
static void direction(uint32_t i, float n[3])
{
	double square = 0.0, d[3];
	for (uint32_t c = 0; c < 3; c++) {
		d[c] = 2.0 * (double)stilb_random_float(c + 1, i) - 1.0;
		if (i % 7 == 0 && (i / 7 % 3 == c || (i / 7 % 9 < 3 && i / 7 % 3 == (c + 1) % 3)))
			d[c] = 0.0;
		square += d[c] * d[c];
	}
	for (int c = 0; c < 3; c++)
		n[c] = (float)(d[c] / sqrt(square > 0.0 ? square : 1.0));
	if (square == 0.0)
		n[2] = -1.0f;
}

static void test_normals_within_their_bound(void **state)
{
	(void)state;
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, true);
	double worst = 0.0;
	assert_int_equal(layout.size, 24);
	for (uint32_t first = 0; first < DIRECTIONS; first += BLOCK) {
		stilb_scene_vertex in[BLOCK], out[BLOCK], again[BLOCK];
		uint8_t packed[BLOCK * 24];
		for (uint32_t i = 0; i < BLOCK; i++) {
			direction(first + i, in[i].normal);
			for (uint32_t c = 0; c < 3; c++)
				in[i].position[c] = 1e3f * stilb_random_float(c + 4, first + i) - 500.0f;
			in[i].uv[0] = 40.0f * stilb_random_float(7, first + i) - 20.0f;
			in[i].uv[1] = (float)i;
		}
		render_vertices_pack(&layout, in, BLOCK, false, packed);
		render_vertices_unpack(&layout, packed, BLOCK, false, out);
		for (uint32_t i = 0; i < BLOCK; i++) {
			const float *n = out[i].normal;
			worst = fmax(worst, angle(in[i].normal, n));
			assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-6f);
			assert_true(n[0] * in[i].normal[0] + n[1] * in[i].normal[1] + n[2] * in[i].normal[2] > 0.99f);
			assert_memory_equal(in[i].position, out[i].position, sizeof in[i].position);
			assert_memory_equal(in[i].uv, out[i].uv, sizeof in[i].uv);
		}
		/* What has been rounded once stays. */
		render_vertices_pack(&layout, out, BLOCK, false, packed);
		render_vertices_unpack(&layout, packed, BLOCK, false, again);
		assert_memory_equal(out, again, sizeof out);
	}
	assert_true(worst <= (double)RENDER_PACKED_ANGLE);
	assert_true(worst > 0.5 * (double)RENDER_PACKED_ANGLE);
}

static void test_axes_are_exact(void **state)
{
	(void)state;
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, true);
	for (int axis = 0; axis < 6; axis++) {
		stilb_scene_vertex in = {{0.0f}, {0.0f}, {0.0f}}, out;
		uint8_t packed[24];
		in.normal[axis / 2] = axis % 2 ? -1.0f : 1.0f;
		render_vertices_pack(&layout, &in, 1, false, packed);
		render_vertices_unpack(&layout, packed, 1, false, &out);
		assert_true(in.normal[0] == out.normal[0] && in.normal[1] == out.normal[1] && in.normal[2] == out.normal[2]);
	}
}

/* The second of a pair may have any length up to 1, and keeps it. */
static void test_morphs_within_their_bound(void **state)
{
	(void)state;
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, true);
	double worst = 0.0;
	for (uint32_t i = 0; i < DIRECTIONS / 4; i++) {
		stilb_scene_vertex in[2] = {0}, out[2], again[2];
		uint8_t packed[48];
		direction(i, in[0].normal);
		direction(i, in[1].normal);
		for (int c = 0; c < 3; c++)
			in[1].normal[c] *= i % 3 == 0 ? 1.0f : stilb_random_float(9, i);
		render_vertices_pack(&layout, in, 2, true, packed);
		render_vertices_unpack(&layout, packed, 2, true, out);
		double square = 0.0;
		for (int c = 0; c < 3; c++)
			square += pow((double)in[1].normal[c] - (double)out[1].normal[c], 2.0);
		worst = fmax(worst, sqrt(square));
		assert_true(angle(in[0].normal, out[0].normal) <= (double)RENDER_PACKED_ANGLE);
		render_vertices_pack(&layout, out, 2, true, packed);
		render_vertices_unpack(&layout, packed, 2, true, again);
		assert_memory_equal(out, again, sizeof out);
	}
	assert_true(worst <= (double)RENDER_PACKED_MORPH);
	assert_true(worst > 0.5 * (double)RENDER_PACKED_MORPH);
}

/* What is no direction becomes one. */
static void test_no_directions(void **state)
{
	(void)state;
	static const float wrong[][3] = {
		{0.0f, 0.0f, 0.0f}, {NAN, 0.0f, 1.0f}, {INFINITY, 0.0f, 0.0f}, {3e38f, 3e38f, 1.0f}};
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, true);
	for (size_t w = 0; w < sizeof wrong / sizeof *wrong; w++)
		for (uint32_t pairs = 0; pairs < 2; pairs++) {
			stilb_scene_vertex in[2] = {0}, out[2];
			uint8_t packed[48];
			memcpy(in[0].normal, wrong[w], sizeof wrong[w]);
			memcpy(in[1].normal, wrong[w], sizeof wrong[w]);
			render_vertices_pack(&layout, in, 2, pairs, packed);
			render_vertices_unpack(&layout, packed, 2, pairs, out);
			for (int c = 0; c < 3; c++)
				assert_true(fabsf(out[0].normal[c]) <= 1.0f && fabsf(out[1].normal[c]) <= 1.0f);
		}
}

static void test_floats_are_copied(void **state)
{
	(void)state;
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, false);
	stilb_scene_vertex in[2] = {{{1.0f, 2.0f, 3.0f}, {4.0f, 5.0f, 6.0f}, {7.0f, 8.0f}}}, out[2];
	assert_int_equal(layout.size, sizeof *in);
	render_vertices_pack(&layout, in, 2, true, out);
	assert_memory_equal(in, out, sizeof in);
}

/* Vertices with tangents and two more numbers. */
typedef struct wide_vertex {
	stilb_scene_vertex base;
	float tangent[3], colour[4], blend;
} wide_vertex;

static void test_more_streams(void **state)
{
	(void)state;
	stilb_scene_stream rows[STILB_SCENE_VERTEX_STREAMS + 3];
	memcpy(rows, stilb_scene_vertex_streams.streams, STILB_SCENE_VERTEX_STREAMS * sizeof *rows);
	rows[3] = (stilb_scene_stream){.name = "tangent",
	                               .kind = STILB_SCENE_STREAM_DIRECTION,
	                               .components = 3,
	                               .offset = offsetof(wide_vertex, tangent),
	                               .packing = STILB_SCENE_STREAM_OCTAHEDRAL};
	rows[4] = (stilb_scene_stream){
		.name = "colour", .kind = STILB_SCENE_STREAM_VALUE, .components = 4, .offset = offsetof(wide_vertex, colour)};
	rows[5] = (stilb_scene_stream){
		.name = "blend", .kind = STILB_SCENE_STREAM_VALUE, .components = 1, .offset = offsetof(wide_vertex, blend)};
	stilb_scene_streams table = {6, sizeof(wide_vertex), rows};
	render_layout layout = render_layout_make(&table, true), plain = render_layout_make(&table, false);
	assert_int_equal(layout.count, 6);
	assert_int_equal(layout.size, 24 + 4 + 16 + 4);
	assert_int_equal(layout.attributes[3].to, 24);
	assert_true(layout.attributes[3].octahedral && !layout.attributes[4].octahedral);
	assert_int_equal(layout.attributes[5].to, 44);
	assert_int_equal(plain.size, sizeof(wide_vertex));
	assert_int_equal(plain.attributes[4].to, offsetof(wide_vertex, colour));
	/* Frame dumps of one are refused by the other. */
	assert_int_equal(render_dump_streams(&stilb_scene_vertex_streams),
	                 render_dump_streams(&stilb_scene_vertex_streams));
	assert_int_not_equal(render_dump_streams(&table), render_dump_streams(&stilb_scene_vertex_streams));
	uint32_t code = render_dump_streams(&table);
	rows[5].name = "weight";
	assert_int_not_equal(render_dump_streams(&table), code);
	wide_vertex in[600], out[600];
	uint8_t *packed = malloc((size_t)600 * layout.size);
	assert_non_null(packed);
	for (uint32_t v = 0; v < 600; v++) {
		float *values = (float *)&in[v];
		for (uint32_t f = 0; f < sizeof in[v] / sizeof(float); f++)
			values[f] = stilb_random_float(f + 1, v);
		direction(v, in[v].base.normal);
		direction(v + 600, in[v].tangent);
	}
	render_vertices_pack(&layout, in, 600, false, packed);
	render_vertices_unpack(&layout, packed, 600, false, out);
	for (uint32_t v = 0; v < 600; v++) {
		assert_true(angle(in[v].tangent, out[v].tangent) <= (double)RENDER_PACKED_ANGLE);
		assert_memory_equal(in[v].colour, out[v].colour, sizeof in[v].colour);
		assert_true(in[v].blend == out[v].blend && in[v].base.uv[1] == out[v].base.uv[1]);
		assert_memory_equal(in[v].base.position, out[v].base.position, sizeof in[v].base.position);
	}
	free(packed);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_normals_within_their_bound), cmocka_unit_test(test_axes_are_exact),
		cmocka_unit_test(test_morphs_within_their_bound),  cmocka_unit_test(test_no_directions),
		cmocka_unit_test(test_floats_are_copied),          cmocka_unit_test(test_more_streams),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
