/* What keeps surfaces from shading themselves, counted in pixels against rays: pixels that are too dark though no edge
 * of a traced shadow is near (acne), and such that are lit though something hides the light (detached: what casts the
 * shadow seems to float). By each kind of bias, and by which sides of triangles are in maps. With the argument `long`
 * from more places, and all kinds. */
#include "engine_internal.h"
#include "gi/gi_scene.h"
#include "support/shadow/shadow_stage.h"
#include "support/shadow/shadow_truth.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 160u
#define HEIGHT 90u
#define PIXELS (WIDTH * HEIGHT)
#define DARKER (1.0f / 16.0f) /* of the light's share: so much darker a pixel is too dark */
#define LIGHTER 0.25f         /* likewise */

/* Texels behind a wall that are lit by all bias together: with a part of it fewer, with twice a part more. */
#define LIT_LEAST 1.25
#define LIT_MOST 1.6

static const stilb_engine_shadows coarse = {.kind = STILB_ENGINE_SHADOWS_MAP, .size = 512, .cascades = 2};
static stilb_job_pool *pool;
static bool is_long;

static int begin(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	return stilb_job_pool_create(&desc, &pool);
}

static int end(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

typedef struct counts {
	uint32_t compared, acne, detached;
} counts;

/* A way to draw maps and read them. */
typedef struct mode {
	stilb_engine_shadow_bias bias;
	stilb_engine_shadow_faces faces;
} mode;

/* By bias and faces. */
typedef counts counts_table[STILB_ENGINE_SHADOW_BIAS_COUNT][STILB_ENGINE_SHADOW_FACES_COUNT];

/* So many texels, as long as they are on the surface and along the diagonal: as far an edge may be from a pixel that is
 * wrong. */
static void allow(const shadow_stage *stage, const shadow_truth *truth, float texels, float *allowed)
{
	const stilb_scene_light *light = &stage->scene->lights[0];
	for (uint32_t i = 0; i < PIXELS; i++) {
		const float *at = truth->position[i];
		float to_light[3], cosine = 0.0f, length = 0.0f;
		for (int c = 0; c < 3; c++) {
			to_light[c] =
				light->kind == STILB_SCENE_LIGHT_DIRECTIONAL ? -light->direction[c] : light->position[c] - at[c];
			length += to_light[c] * to_light[c];
			cosine += to_light[c] * truth->normal[i][c];
		}
		cosine = fmaxf(cosine / sqrtf(length), 0.05f);
		allowed[i] = isnan(truth->visible[i]) ? 0.0f : 1.41422f * texels * shadow_stage_texel(stage, at) / cosine;
	}
}

static void count_mode(shadow_stage *stage, const stilb_gi_scene *gi, const shadow_truth *truth,
                       const shadow_edges *edges, mode chosen, counts *all)
{
	static float allowed[PIXELS], live[PIXELS];
	shadow_asked asked = {&stage->scene->camera, WIDTH, HEIGHT, &stage->scene->lights[0], false};
	stage->shadows.bias = chosen.bias;
	stage->shadows.faces = chosen.faces;
	stage->engine->shadows.valid = false; /* what maps hold is drawn otherwise */
	memcpy(live, shadow_stage_share_again(stage), sizeof live);
	for (uint32_t i = 0; i < PIXELS; i++) /* smooth normals face the light where triangles do not, and the other way */
		live[i] = isnan(live[i]) ? truth->visible[i] : live[i];
	allow(stage, truth, 3.0f, allowed); /* a texel, and the filter's radius */
	shadow_compared dark = shadow_compare(gi, &asked, truth, edges, live, DARKER, allowed);
	allow(stage, truth, 1.0f, allowed); /* farther within a shadow the filter sees less light than that */
	shadow_compared light = shadow_compare(gi, &asked, truth, edges, live, LIGHTER, allowed);
	all->compared += dark.compared;
	all->acne += dark.acne;
	all->detached += light.touching + light.outside - light.acne;
}

/* One view by the modes that are asked for. */
static void count_view(shadow_stage *stage, const stilb_gi_scene *gi, bool all_modes, counts_table table)
{
	shadow_asked asked = {&stage->scene->camera, WIDTH, HEIGHT, &stage->scene->lights[0], false};
	shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
	shadow_edges edges = shadow_edges_find(&truth, 0.0f);
	stage->shadows.bias = STILB_ENGINE_SHADOW_BIAS_ALL;
	stage->shadows.faces = STILB_ENGINE_SHADOW_FACES_BOTH;
	shadow_stage_share(stage); /* with the frame that has no shadows */
	for (int b = 0; b < STILB_ENGINE_SHADOW_BIAS_COUNT; b++)
		for (int f = 0; f < STILB_ENGINE_SHADOW_FACES_COUNT; f++)
			if (all_modes || f == STILB_ENGINE_SHADOW_FACES_BOTH)
				count_mode(stage, gi, &truth, &edges, (mode){(stilb_engine_shadow_bias)b, (stilb_engine_shadow_faces)f},
				           &table[b][f]);
	shadow_edges_finish(&edges);
	shadow_truth_finish(&truth);
}

/* Of all scenes together, by a sun, a point and a spot. */
static void count_scenes(uint64_t seed, uint32_t views, bool all_modes, counts_table table)
{
	static const stilb_scene_light_kind kinds[3] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_POINT,
	                                                STILB_SCENE_LIGHT_SPOT};
	uint64_t random = seed;
	for (int s = 0; s < 3; s++)
		for (int k = 0; k < 3; k++) {
			stilb_scene_light light = shadow_stage_light(&random, kinds[k], 0.15f);
			shadow_stage stage = shadow_stage_open((shadow_stage_kind)s, seed, &light, coarse, WIDTH, HEIGHT);
			stilb_gi_scene *gi;
			stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
			if (stilb_gi_scene_create(stage.scene, &desc, &gi) != STILB_OK)
				fail_msg("%s", stilb_error_message());
			for (uint32_t v = 0; v < views; v++) {
				stage.scene->camera = shadow_stage_camera(&random);
				stage.scene->lights[0] = shadow_stage_light(&random, kinds[k], 0.15f);
				count_view(&stage, gi, all_modes, table);
			}
			stilb_gi_scene_destroy(gi);
			shadow_stage_close(&stage);
		}
}

static double share(uint32_t count, const counts *of)
{
	return (double)count / (double)of->compared;
}

/* All that is there leaves hardly a pixel in the wrong; without a part of it surfaces shade themselves, and twice of it
 * would detach twice as many. */
static void bias_is_enough_and_not_more(void **state)
{
	(void)state;
	counts_table table = {0};
	count_scenes(31, is_long ? 4 : 1, is_long, table);
	for (int b = 0; b < STILB_ENGINE_SHADOW_BIAS_COUNT; b++)
		for (int f = 0; f < STILB_ENGINE_SHADOW_FACES_COUNT; f++) {
			const counts *c = &table[b][f];
			if (c->compared > 0)
				print_message("--shadow-bias %s --shadow-faces %s: of %u pixels %u acne, %u detached\n",
				              stilb_engine_shadow_bias_names[b], stilb_engine_shadow_faces_names[f], c->compared,
				              c->acne, c->detached);
		}
	const counts *all = &table[STILB_ENGINE_SHADOW_BIAS_ALL][STILB_ENGINE_SHADOW_FACES_BOTH];
	const counts *none = &table[STILB_ENGINE_SHADOW_BIAS_NONE][STILB_ENGINE_SHADOW_FACES_BOTH];
	assert_true(share(all->acne, all) <= 5e-5);
	assert_true(share(all->detached, all) <= 1e-3);
	assert_true(share(none->acne, none) > 0.1);
	const counts *back = table[STILB_ENGINE_SHADOW_BIAS_NONE] + STILB_ENGINE_SHADOW_FACES_BACK;
	assert_true(!is_long || (100 * back->acne < none->acne && 10 * all->detached < back->detached));
}

/* Metres of the floor that are lit behind the wall, at which the camera looks from above, in the mean over the
 * columns. */
static double lit_width(const shadow_stage *stage, const float *share)
{
	const stilb_scene_camera *camera = &stage->scene->camera;
	float before = 0.0f;
	double width = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++) {
		float up = (0.5f - ((float)y + 0.5f) / HEIGHT) * 2.0f * tanf(0.5f * camera->fov_y);
		float angle = -camera->pitch - atanf(up); /* below the horizon */
		float x = camera->position[0] - camera->position[1] / tanf(angle);
		for (uint32_t c = 0; c < WIDTH && x > 0.0f && before > 0.0f; c++)
			width += (double)((x - before) * share[y * WIDTH + c]) / WIDTH;
		before = x;
	}
	return width;
}

/* Behind a wall without thickness light gets through where it stands: how far, in texels of the map, in the mean
 * along the wall, which the maps' texels meet otherwise everywhere, and over suns of several heights. */
static void walls_stand_on_the_floor(void **state)
{
	(void)state;
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.7071068f, -0.7071068f, 0.0f}};
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_WALL, 0, &sun, coarse, WIDTH, HEIGHT);
	stage.scene->camera = (stilb_scene_camera){.position = {0.6f, 0.8f, 0.0f},
	                                           .yaw = 1.57079633f,
	                                           .pitch = -0.9f,
	                                           .fov_y = 0.6f,
	                                           .near_z = 0.05f,
	                                           .far_z = 100.0f};
	for (int b = 0; b < STILB_ENGINE_SHADOW_BIAS_COUNT; b++) {
		const float heights[] = {0.8f, 0.9f, 1.0f};
		double texels = 0.0;
		for (size_t h = 0; h < sizeof heights / sizeof *heights; h++) {
			stage.shadows.bias = (stilb_engine_shadow_bias)b;
			stage.engine->shadows.valid = false;
			float along = cosf(heights[h]);
			memcpy(stage.scene->lights[0].direction, (float[3]){0.6f * along, -sinf(heights[h]), 0.8f * along},
			       sizeof sun.direction);
			double width = lit_width(&stage, shadow_stage_share(&stage));
			texels += width / (double)shadow_stage_texel(&stage, (float[3]){0.1f, 0.0f, 0.0f});
		}
		texels /= sizeof heights / sizeof *heights;
		print_message("--shadow-bias %s: behind a wall %.2f texels of the floor are lit\n",
		              stilb_engine_shadow_bias_names[b], texels);
		if (b == STILB_ENGINE_SHADOW_BIAS_ALL)
			assert_true(texels > LIT_LEAST && texels < LIT_MOST);
	}
	shadow_stage_close(&stage);
}

int main(int argc, char **argv)
{
	is_long = argc > 1 && strcmp(argv[1], "long") == 0;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(bias_is_enough_and_not_more),
		cmocka_unit_test(walls_stand_on_the_floor),
	};
	return cmocka_run_group_tests(tests, begin, end);
}
