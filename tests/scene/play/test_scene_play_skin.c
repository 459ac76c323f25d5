/* Skins through the widest instructions of this CPU beside those that every CPU has: the same bits, and nothing written
 * past the last vertex. */
#include "scene/play/scene_play_skin.h"
#include "support/test.h"

#include <stdlib.h>

#define MOST 64u    /* vertices */
#define JOINTS 24u  /* the last three are flat, mirrored and not finite */
#define CARRIERS 5u /* of eight vertices */

typedef struct skin_case {
	float streams[12][MOST], weights[MOST / PLAY_LANES * CARRIERS * PLAY_LANES];
	uint32_t starts[MOST / PLAY_LANES + 1];
	uint16_t indices[MOST / PLAY_LANES * CARRIERS];
	play_rows joints[JOINTS];
} skin_case;

typedef struct skin_result {
	stilb_scene_vertex vertices[MOST + 1];
	stilb_scene_vertex_extra extras[MOST + 1];
	float low[3], high[3];
} skin_result;

static float skin_random(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return (float)(*state >> 8) / 8388608.0f - 1.0f;
}

/* Each eight has one carrier more than the one before, from one on; vertex 3 has a normal of no length. */
static void skin_fill(skin_case *c, uint32_t seed)
{
	uint32_t state = seed;
	for (uint32_t s = 0; s < 12; s++)
		for (uint32_t v = 0; v < MOST; v++)
			c->streams[s][v] = s >= 3 && s < 6 && v == 3 ? 0.0f : skin_random(&state);
	for (uint32_t j = 0; j < JOINTS; j++)
		for (uint32_t k = 0; k < 12; k++)
			c->joints[j].m[k] = (k % 5 == 0 ? 1.0f : 0.0f) + 0.3f * skin_random(&state);
	for (uint32_t k = 0; k < 4; k++) {
		c->joints[JOINTS - 3].m[k] = 0.0f;
		c->joints[JOINTS - 2].m[k] *= -1.0f;
		c->joints[JOINTS - 1].m[k] = INFINITY;
	}
	c->starts[0] = 0;
	for (uint32_t e = 0; e < MOST / PLAY_LANES; e++) {
		uint32_t count = e % CARRIERS + 1, first = c->starts[e];
		c->starts[e + 1] = first + count;
		for (uint32_t k = first; k < first + count; k++) {
			c->indices[k] = (uint16_t)((k * 7 + seed) % JOINTS);
			for (uint32_t v = 0; v < PLAY_LANES; v++)
				c->weights[k * PLAY_LANES + v] = 1.0f / (float)count;
		}
	}
}

static void skin_show(const skin_case *c, play_skin_fn *run, uint32_t count, bool tangents, bool carried,
                      skin_result *to)
{
	memset(to, 0xab, sizeof *to);
	play_skin skin = {.joints = carried ? c->joints : NULL,
	                  .starts = c->starts,
	                  .indices = c->indices,
	                  .weights = c->weights,
	                  .count = count,
	                  .vertices = to->vertices,
	                  .extras = to->extras};
	for (int i = 0; i < 3; i++) {
		skin.position[i] = c->streams[i];
		skin.normal[i] = c->streams[3 + i];
	}
	for (int i = 0; i < 2; i++)
		skin.uv[i] = c->streams[6 + i];
	for (int i = 0; tangents && i < 4; i++)
		skin.tangent[i] = c->streams[8 + i];
	run(&skin);
	memcpy(to->low, skin.low, sizeof to->low);
	memcpy(to->high, skin.high, sizeof to->high);
}

static void assert_untouched(const void *bytes, size_t count)
{
	for (size_t i = 0; i < count; i++)
		assert_int_equal(((const unsigned char *)bytes)[i], 0xab);
}

static void assert_boxed(const skin_result *shown, uint32_t count)
{
	for (int i = 0; i < 3; i++) {
		float low = INFINITY, high = -INFINITY;
		for (uint32_t v = 0; v < count; v++) {
			low = fminf(low, shown->vertices[v].position[i]);
			high = fmaxf(high, shown->vertices[v].position[i]);
		}
		assert_true(shown->low[i] == low && shown->high[i] == high);
	}
}

/* A sum over carriers in another order than the code's would not have the same bits, so it is compared to 1e-6. */
static void assert_placed(const skin_case *c, const skin_result *shown, uint32_t count, bool carried)
{
	for (uint32_t v = 0; v < count; v++)
		for (uint32_t i = 0; i < 3; i++) {
			double at = carried ? 0.0 : (double)c->streams[i][v];
			for (uint32_t k = c->starts[v / 8]; carried && k < c->starts[v / 8 + 1]; k++) {
				const float *row = c->joints[c->indices[k]].m + (size_t)4 * i;
				for (uint32_t x = 0; x < 4; x++)
					at += (double)c->weights[k * 8 + v % 8] * (double)row[x] * (x < 3 ? (double)c->streams[x][v] : 1.0);
			}
			if (isfinite(at))
				assert_true(fabs((double)shown->vertices[v].position[i] - at) < 1e-6);
			else
				assert_false(isfinite(shown->vertices[v].position[i]));
		}
}

static void every_instruction_set_makes_the_same_bits(void **state)
{
	(void)state;
	play_skin_fn *widest = scene_play_skin_choose();
	skin_case *c = malloc(sizeof *c);
	skin_result *plain = malloc(sizeof *plain), *wide = malloc(sizeof *wide);
	assert_true(c && plain && wide);
	for (uint32_t seed = 1; seed <= 24; seed++) {
		skin_fill(c, seed);
		for (uint32_t count = 1; count <= MOST; count += count < 18 ? 1 : 15)
			for (int way = 0; way < 4; way++) {
				skin_show(c, scene_play_skin_plain, count, way & 1, way & 2, plain);
				skin_show(c, widest, count, way & 1, way & 2, wide);
				assert_memory_equal(plain, wide, sizeof *plain);
				assert_untouched(plain->vertices + count, sizeof plain->vertices - count * sizeof *plain->vertices);
				assert_untouched(plain->extras + (way & 1 ? count : 0),
				                 sizeof plain->extras - (way & 1 ? count : 0) * sizeof *plain->extras);
				assert_boxed(plain, count);
				assert_placed(c, plain, count, way & 2);
			}
	}
	free(c);
	free(plain);
	free(wide);
}

int main(void)
{
	if (scene_play_skin_choose() == scene_play_skin_plain)
		print_message("this CPU has no AVX2: only one way of skinning is tested\n");
	const struct CMUnitTest tests[] = {cmocka_unit_test(every_instruction_set_makes_the_same_bits)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
