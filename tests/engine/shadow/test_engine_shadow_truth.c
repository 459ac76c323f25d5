/* Shadows of frames against traced ones: where pixels are wrong there is an edge within a texel and the filter's
 * radius, for every kind of light, from random places in several scenes. Edges of lamps with a size are as wide as
 * those of rays. With the argument `long` from 200 places, else from a few. */
#include "gi/gi_scene.h"
#include "support/shadow/shadow_stage.h"
#include "support/shadow/shadow_truth.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const stilb_engine_shadows maps = {.kind = STILB_ENGINE_SHADOWS_MAP};
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

static stilb_gi_scene *traced(const stilb_scene *scene)
{
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return gi;
}

/* How far the edge may be from each pixel that is wrong: a texel and the filter's radius, along the diagonal, as long
 * as they are on a slanted surface. */
static void allow(const shadow_stage *stage, const shadow_truth *truth, float *allowed)
{
	const stilb_scene_light *light = &stage->scene->lights[0];
	for (uint32_t i = 0; i < truth->width * truth->height; i++) {
		const float *at = truth->position[i], *normal = truth->normal[i];
		float to_light[3], cosine = 0.0f, length = 0.0f;
		for (int c = 0; c < 3; c++) {
			to_light[c] =
				light->kind == STILB_SCENE_LIGHT_DIRECTIONAL ? -light->direction[c] : light->position[c] - at[c];
			length += to_light[c] * to_light[c];
			cosine += to_light[c] * normal[c];
		}
		cosine = fmaxf(cosine / sqrtf(length), 0.05f);
		float samples = (float)(stage->shadows.samples > 0 ? stage->shadows.samples : 16);
		bool compares = stage->shadows.filter == STILB_ENGINE_SHADOW_FILTER_COMPARE; /* 1, 2, 3 texels */
		float radius = 1.0f + (compares ? samples > 4.0f ? 3.0f : samples > 1.0f ? 2.0f : 1.0f : 0.5f * sqrtf(samples));
		allowed[i] = isnan(truth->visible[i]) ? 0.0f : 1.41422f * radius * shadow_stage_texel(stage, at) / cosine;
	}
}

typedef struct sums {
	uint32_t views, compared, wrong, hidden, touching, outside, acne;
	float worst;
} sums;

/* Of a view, with one light. Pixels may differ by the tolerance without being wrong. */
static void compare(shadow_stage *stage, const stilb_gi_scene *gi, bool soft, float tolerance, sums *all)
{
	size_t pixels = (size_t)stage->width * stage->height;
	shadow_asked asked = {&stage->scene->camera, stage->width, stage->height, &stage->scene->lights[0], soft};
	shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
	shadow_edges edges = shadow_edges_find(&truth, 0.0f);
	float *allowed = malloc(pixels * sizeof *allowed), *live = malloc(pixels * sizeof *live);
	assert_true(allowed && live);
	memcpy(live, shadow_stage_share(stage), pixels * sizeof *live);
	for (size_t i = 0; i < pixels;
	     i++) /* smooth normals face the light where triangles do not, and the other way round */
		live[i] = isnan(live[i]) ? truth.visible[i] : live[i];
	allow(stage, &truth, allowed);
	shadow_compared result = shadow_compare(gi, &asked, &truth, &edges, live, tolerance, allowed);
	all->views++;
	all->compared += result.compared;
	all->wrong += result.wrong;
	all->hidden += result.hidden;
	all->touching += result.touching;
	all->outside += result.outside;
	all->acne += result.acne;
	all->worst = fmaxf(all->worst, result.worst);
	free(allowed);
	free(live);
	shadow_edges_finish(&edges);
	shadow_truth_finish(&truth);
}

static const char *const kind_names[] = {"sun", "point", "spot", "sphere", "disk", "rectangle"};
static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_POINT,
                                               STILB_SCENE_LIGHT_SPOT,        STILB_SCENE_LIGHT_SPHERE,
                                               STILB_SCENE_LIGHT_DISK,        STILB_SCENE_LIGHT_RECTANGLE};
static const char *const scene_names[] = {"balls", "hall", "clutter"};

/* Random views of each scene by each kind of light. */
static void wrong_pixels_are_near_edges(void **state)
{
	(void)state;
	uint64_t random = 25;
	for (int s = 0; s < 3; s++)
		for (int k = 0; k < 6; k++) {
			bool soft = k >= 3;
			uint32_t views = !is_long ? (soft ? 0 : 1) : soft ? 2 : 21;
			uint32_t width = soft ? 80 : 160, height = soft ? 45 : 90;
			stilb_scene_light light = shadow_stage_light(&random, kinds[k], 0.15f);
			shadow_stage stage = shadow_stage_open((shadow_stage_kind)s, 7, &light, maps, width, height);
			stilb_gi_scene *gi = traced(stage.scene);
			sums all = {0};
			for (uint32_t v = 0; v < views; v++) {
				stage.scene->camera = shadow_stage_camera(&random);
				stage.scene->lights[0] = shadow_stage_light(&random, kinds[k], 0.15f);
				compare(&stage, gi, soft, soft ? 0.25f : 1.0f / 32.0f, &all);
			}
			print_message("%s, %s: %u views, %u of %u pixels differ, %u of them near edges out of sight, %u at what "
			              "touches, %u outside, %u of these too dark; worst %.2f\n",
			              scene_names[s], kind_names[k], all.views, all.wrong, all.compared, all.hidden, all.touching,
			              all.outside, all.acne, (double)all.worst);
			/* Where two surfaces meet in the middle of a pixel, rays may find the one and frames the other. */
			assert_true(all.outside <= (is_long ? 3u : 1u));
			assert_true(views == 0 || all.compared > 1000 * views);
			assert_true(views == 0 || all.wrong > 0);
			stilb_gi_scene_destroy(gi);
			shadow_stage_close(&stage);
		}
}

/* Of a sheet the light sees the front alone; of balls and boxes either side stops it. Counted are pixels that are wrong
 * though no edge is near, by which sides are drawn. */
static void faces_are_chosen(void **state)
{
	(void)state;
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.6f, -0.8f, 0.0f}};
	for (int f = 0; f < STILB_ENGINE_SHADOW_FACES_COUNT; f++) {
		stilb_engine_shadows chosen = maps;
		chosen.faces = (stilb_engine_shadow_faces)f;
		shadow_stage sheet = shadow_stage_open(SHADOW_STAGE_BOARD, 0, &sun, chosen, 160, 90);
		sheet.scene->camera = (stilb_scene_camera){.position = {3.0f, 0.7f, 0.0f},
		                                           .yaw = 1.57079633f,
		                                           .pitch = -0.3f,
		                                           .fov_y = 0.8f,
		                                           .near_z = 0.05f,
		                                           .far_z = 90};
		const float *share = shadow_stage_share(&sheet);
		uint32_t dark = 0;
		for (uint32_t i = 0; i < 160 * 90; i++)
			dark += share[i] < 0.5f;
		assert_true(f == STILB_ENGINE_SHADOW_FACES_BACK ? dark == 0 : dark > 1000);
		shadow_stage_close(&sheet);

		uint64_t random = 77;
		shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BALLS, 7, &sun, chosen, 160, 90);
		stilb_gi_scene *gi = traced(stage.scene);
		sums all = {0};
		for (int v = 0; v < (is_long ? 40 : 3); v++) {
			stage.scene->camera = shadow_stage_camera(&random);
			stage.scene->lights[0] = shadow_stage_light(&random, kinds[v % 3], 0.15f);
			compare(&stage, gi, false, 1.0f / 32.0f, &all);
		}
		print_message(
			"--shadow-faces %s: of %u pixels %u differ, %u at what touches, %u outside, %u of these too dark\n",
			stilb_engine_shadow_faces_names[f], all.compared, all.wrong, all.touching, all.outside, all.acne);
		assert_true(all.outside <= all.compared / (f == STILB_ENGINE_SHADOW_FACES_BACK ? 50 : 1000));
		stilb_gi_scene_destroy(gi);
		shadow_stage_close(&stage);
	}
}

/* One sample is all or nothing; more are in between at edges. */
static void samples_are_chosen(void **state)
{
	(void)state;
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.6f, -0.8f, 0.0f}};
	static const uint32_t samples[] = {1, 4, 16, 36};
	uint32_t last = 0;
	for (int s = 0; s < 4; s++) {
		uint64_t random = 6;
		stilb_engine_shadows chosen = maps;
		chosen.samples = samples[s];
		shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BALLS, 7, &sun, chosen, 160, 90);
		stage.scene->camera = shadow_stage_camera(&random);
		stilb_gi_scene *gi = traced(stage.scene);
		sums all = {0};
		compare(&stage, gi, false, 1.0f / 32.0f, &all);
		uint32_t between = 0;
		for (uint32_t i = 0; i < 160 * 90; i++)
			between += stage.share[i] > 0.02f && stage.share[i] < 0.98f;
		print_message("--shadow-samples %u: %u pixels in between, %u of %u differ, %u outside\n", samples[s], between,
		              all.wrong, all.compared, all.outside);
		assert_true(all.outside <= all.compared / 1000);
		assert_true(s == 0 ? between <= 20 : between > last); /* where cascades blend, two may differ */
		last = between;
		stilb_gi_scene_destroy(gi);
		shadow_stage_close(&stage);
	}
}

/* Root of the mean square by which shares differ from those of rays. */
static double rms_of(const shadow_truth *truth, const float *share)
{
	double squares = 0.0;
	uint32_t count = 0;
	for (uint32_t i = 0; i < truth->width * truth->height; i++) {
		if (isnan(truth->visible[i]) || isnan(share[i]))
			continue;
		double off = (double)share[i] - (double)truth->visible[i];
		squares += off * off;
		count++;
	}
	return sqrt(squares / (count > 0 ? count : 1));
}

/* Few comparisons in an alternating pattern: wrong near edges alone, as the filters are; more of them differ less from
 * rays than one does. Beside them the filters, for the table in docs. */
static void comparisons_are_chosen(void **state)
{
	(void)state;
	static const struct {
		stilb_engine_shadow_filter filter;
		uint32_t samples;
	} ways[] = {{STILB_ENGINE_SHADOW_FILTER_GATHER, 1},  {STILB_ENGINE_SHADOW_FILTER_GATHER, 4},
	            {STILB_ENGINE_SHADOW_FILTER_GATHER, 16}, {STILB_ENGINE_SHADOW_FILTER_GATHER, 36},
	            {STILB_ENGINE_SHADOW_FILTER_COMPARE, 1}, {STILB_ENGINE_SHADOW_FILTER_COMPARE, 4},
	            {STILB_ENGINE_SHADOW_FILTER_COMPARE, 12}};
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.6f, -0.8f, 0.0f}};
	for (size_t w = is_long ? 0 : 4; w < sizeof ways / sizeof *ways; w++) {
		stilb_engine_shadows chosen = maps;
		chosen.filter = ways[w].filter;
		chosen.samples = ways[w].samples;
		double squares = 0.0;
		uint32_t views = is_long ? 6 : 1, between = 0;
		sums all = {0};
		for (int s = 0; s < 3; s += is_long ? 1 : 2) {
			uint64_t random = 6;
			shadow_stage stage = shadow_stage_open((shadow_stage_kind)s, 7, &sun, chosen, 160, 90);
			stilb_gi_scene *gi = traced(stage.scene);
			for (uint32_t v = 0; v < views; v++) {
				stage.scene->camera = shadow_stage_camera(&random);
				compare(&stage, gi, false, 1.0f / 32.0f, &all);
				shadow_asked asked = {&stage.scene->camera, 160, 90, &sun, false};
				shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
				double rms = rms_of(&truth, stage.share);
				squares += rms * rms;
				shadow_truth_finish(&truth);
				for (uint32_t i = 0; i < 160 * 90; i++)
					between += stage.share[i] > 0.02f && stage.share[i] < 0.98f;
			}
			stilb_gi_scene_destroy(gi);
			shadow_stage_close(&stage);
		}
		print_message("--shadow-filter %s --shadow-samples %u: off by %.4f, %u pixels in between, %u of %u differ, "
		              "%u outside\n",
		              stilb_engine_shadow_filter_names[ways[w].filter], ways[w].samples,
		              sqrt(squares / (views * (is_long ? 3 : 2))), between, all.wrong, all.compared, all.outside);
		assert_true(all.outside <= all.compared / 1000);
		assert_true(between > 100 || ways[w].filter == STILB_ENGINE_SHADOW_FILTER_GATHER);
	}
}

/* ---- lamps with a size ------------------------------------------------------------------------------------------- */

#define BINS 48
#define ACROSS 1.2f /* metres of the floor in the bins, about the edge */

/* Metres from where a tenth of the light arrives to where nine tenths do, of the mean along the edge. */
static double width_of(const shadow_truth *truth, const float *share)
{
	double shares[BINS] = {0}, first = 0.0, last = 0.0;
	uint32_t counts[BINS] = {0};
	for (uint32_t i = 0; i < truth->width * truth->height; i++) {
		float bin = (truth->position[i][0] / ACROSS + 0.5f) * BINS;
		if (isnan(truth->visible[i]) || isnan(share[i]) || truth->position[i][1] > 0.5f || !(bin >= 0.0f && bin < BINS))
			continue;
		shares[(int)bin] += (double)share[i];
		counts[(int)bin]++;
	}
	for (int b = 0; b < BINS; b++)
		assert_true(counts[b] > 20);
	for (int b = 1; b < BINS; b++) {
		double before = shares[b - 1] / counts[b - 1], now = shares[b] / counts[b];
		if (before < 0.1 && now >= 0.1)
			first = b - (now - 0.1) / (now - before);
		if (before < 0.9 && now >= 0.9 && last == 0.0)
			last = b - (now - 0.9) / (now - before);
	}
	return (last - first) * (double)ACROSS / BINS;
}

/* Half a plane, 1 m above a floor, under lamps over its edge: the width of the shadow's edge is that of rays, to a
 * tenth. */
static void edges_are_as_wide(void **state)
{
	(void)state;
	static const float radii[2] = {0.15f, 0.3f};
	uint32_t width = is_long ? 320 : 48, height = is_long ? 180 : 270; /* rows are nearer to each other than bins */
	for (int k = 3; k < (is_long ? 6 : 4); k++)
		for (int r = is_long ? 0 : 1; r < 2; r++) {
			stilb_scene_light light = {.kind = kinds[k],
			                           .position = {0, 3, 0},
			                           .direction = {0, -1, 0},
			                           .intensity = {30, 30, 30},
			                           .radius = radii[r],
			                           .half_x = {radii[r], 0, 0},
			                           .half_y = {0, 0, radii[r]}};
			shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BOARD, 0, &light, maps, width, height);
			stage.scene->camera = (stilb_scene_camera){.position = {2.6f, 1.3f, 0.0f},
			                                           .yaw = 1.57079633f,
			                                           .pitch = -0.45f,
			                                           .fov_y = 0.5f,
			                                           .near_z = 0.05f,
			                                           .far_z = 100.0f};
			stilb_gi_scene *gi = traced(stage.scene);
			shadow_asked asked = {&stage.scene->camera, width, height, &light, true};
			shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
			double want = width_of(&truth, truth.visible), got = width_of(&truth, shadow_stage_share(&stage));
			print_message("%s of %.2f m: the edge is %.3f m wide, by rays %.3f\n", kind_names[k], (double)radii[r], got,
			              want);
			assert_true(truth.error <= 1.0f / 255.0f);
			assert_true(want > 0.05 && fabs(got - want) <= 0.1 * want);
			shadow_truth_finish(&truth);
			stilb_gi_scene_destroy(gi);
			shadow_stage_close(&stage);
		}
}

/* True if a pixel is lit and the four beside it are dark, or the other way round. */
static bool stands_alone(const float *share, int width, int i)
{
	float low = fminf(fminf(share[i - 1], share[i + 1]), fminf(share[i - width], share[i + width]));
	float high = fmaxf(fmaxf(share[i - 1], share[i + 1]), fmaxf(share[i - width], share[i + width]));
	return (share[i] > 0.6f && high < 0.2f) || (share[i] < 0.4f && low > 0.8f);
}

/* A lamp far above balls, which are small in its map: their shadows have no lit specks, nor have what is in light dark
 * ones. */
static void far_lamps_have_whole_shadows(void **state)
{
	(void)state;
	enum { COLUMNS = 80, ROWS = 180 }; /* maps are as fine as pictures are high */
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_RECTANGLE,
	                           .position = {3.0f, 9.0f, 2.0f},
	                           .direction = {0, -1, 0},
	                           .intensity = {1000, 1000, 1000},
	                           .half_x = {0.4f, 0, 0},
	                           .half_y = {0, 0, 0.4f}};
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BALLS, 7, &light, maps, COLUMNS, ROWS);
	stage.scene->camera = (stilb_scene_camera){
		.position = {0.5f, 4.0f, 5.5f}, .pitch = -0.65f, .fov_y = 0.9f, .near_z = 0.05f, .far_z = 100.0f};
	const float *share = shadow_stage_share(&stage);
	uint32_t dark = 0, lit = 0, alone = 0;
	for (int i = COLUMNS + 1; i < COLUMNS * (ROWS - 1) - 1; i++) {
		dark += share[i] < 0.1f;
		lit += share[i] > 0.9f;
		alone += stands_alone(share, COLUMNS, i);
	}
	print_message("a lamp 9 m away: %u pixels dark, %u lit, %u stand alone\n", dark, lit, alone);
	assert_true(dark > 100 && lit > 1000);
	assert_true(alone <= 4);
	shadow_stage_close(&stage);
}

/* Of many things in front of each other: shadows of lamps are nearer to those of rays than shadows of points in their
 * places, over all scenes together; of one scene they may be off by a tenth more, and where no edge is in sight by .03.
 * References are to a standard error of 1 / 255. */
static void sizes_lessen_the_error(void **state)
{
	(void)state;
	uint64_t random = 4;
	double all_soft = 0.0, all_hard = 0.0;
	for (int s = 0; s < 3 && is_long; s++)
		for (int k = 3; k < 6; k++) {
			stilb_scene_light light = shadow_stage_light(&random, kinds[k], 0.3f);
			shadow_stage stage = shadow_stage_open((shadow_stage_kind)s, 7, &light, maps, 320, 180);
			stage.scene->camera = shadow_stage_camera(&random);
			stilb_gi_scene *gi = traced(stage.scene);
			shadow_asked asked = {&stage.scene->camera, 320, 180, &light, true};
			shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
			double soft = rms_of(&truth, shadow_stage_share(&stage));
			stage.scene->lights[0].kind = STILB_SCENE_LIGHT_POINT;
			double hard = rms_of(&truth, shadow_stage_share(&stage));
			print_message("%s, %s: off by %.4f, that of a point by %.4f; error of the rays %.4f\n", scene_names[s],
			              kind_names[k], soft, hard, (double)truth.error);
			assert_true(truth.error <= 1.0f / 255.0f);
			assert_true(truth.error > 0.0f ? soft < 1.1 * hard : soft < 0.03); /* 0: no edge is in sight */
			all_soft += soft;
			all_hard += hard;
			shadow_truth_finish(&truth);
			stilb_gi_scene_destroy(gi);
			shadow_stage_close(&stage);
		}
	assert_true(!is_long || all_soft < 0.9 * all_hard);
}

int main(int argc, char **argv)
{
	is_long = argc > 1 && strcmp(argv[1], "long") == 0;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wrong_pixels_are_near_edges),  cmocka_unit_test(faces_are_chosen),
		cmocka_unit_test(samples_are_chosen),           cmocka_unit_test(edges_are_as_wide),
		cmocka_unit_test(sizes_lessen_the_error),       cmocka_unit_test(comparisons_are_chosen),
		cmocka_unit_test(far_lamps_have_whole_shadows),
	};
	return cmocka_run_group_tests(tests, begin, end);
}
