/* What passes keep light in: RGBM and LogLuv beside half floats, with one and four samples a pixel and at any exposure;
 * bands on a dark and on a bright saturated ramp; who adds light keeps half floats; decals that multiply; the mean of
 * four texels as a bilinear filter takes it. */
#include "engine_internal.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "shading/shade_encoding.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 90, PIXELS = WIDTH * HEIGHT, STEPS = 40, WIDE = WIDTH / STEPS };
enum { DARK, BRIGHT, RAMPS };

typedef float picture[PIXELS][3];

static const float darkest = 0.03f, brightest = 40.0f; /* of the ramps, of display white */
static const float white = 16.0f; /* radiance that is shown as it: without exposure RGBM would hold no tenth of these */
static picture half, kept;

/* ---- the scene --------------------------------------------------------------------------------------------------- */

/* A square from -1 to 1 that looks to +Z. */
static stilb_scene_mesh square(void)
{
	static stilb_scene_vertex vertices[4];
	static uint32_t indices[6] = {0, 1, 2, 2, 1, 3};
	for (int v = 0; v < 4; v++)
		vertices[v] = (stilb_scene_vertex){.position = {v % 2 ? 1.0f : -1.0f, v / 2 ? 1.0f : -1.0f, 0.0f},
		                                   .normal = {0.0f, 0.0f, 1.0f}};
	return (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 4, .index_count = 6};
}

/* What the step of a ramp shines, of display white. */
static void ramp_light(uint32_t ramp, uint32_t step, float light[3])
{
	float share = (float)(step + 1) / STEPS;
	light[0] = share * (ramp == DARK ? darkest : brightest);
	light[1] = light[0] * (ramp == DARK ? 0.8f : 0.02f);
	light[2] = light[0] * (ramp == DARK ? 0.6f : 0.01f);
}

/* Two ramps before a bright sky. blends: with a pane before them. */
static stilb_scene *ramps(bool blends)
{
	static const float none[3] = {0};
	float high = 2.0f * tanf(0.3f), wide = high * WIDTH / HEIGHT; /* half of what is seen at a distance of 2 */
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh mesh = square();
	uint32_t shape = stilb_scene_build_mesh(build, &mesh);
	for (uint32_t i = 0; i < RAMPS * STEPS; i++) {
		uint32_t ramp = i / STEPS, step = i % STEPS;
		stilb_scene_material paint = stilb_scene_material_make(none, none, 1.0f);
		ramp_light(ramp, step, paint.emission);
		for (int c = 0; c < 3; c++)
			paint.emission[c] *= white;
		stilb_scene_pose pose = {.scale = {wide / STEPS, 0.4f * high, 1.0f},
		                         .rotation = {0, 0, 0, 1},
		                         .translation = {wide * ((float)(2 * step + 1) / STEPS - 1.0f),
		                                         ramp == DARK ? 0.5f * high : -0.5f * high, -2.0f}};
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_build_part part = {.mesh = shape, .material = stilb_scene_build_material(build, &paint)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	if (blends) {
		stilb_scene_surface pane = stilb_scene_surface_make();
		pane.alpha = STILB_SCENE_BLEND;
		pane.color[3] = 0.5f;
		stilb_scene_pose pose = {
			.scale = {0.2f, 0.2f, 1.0f}, .rotation = {0, 0, 0, 1}, .translation = {0.0f, 0.0f, -1.0f}};
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_material paint = stilb_scene_material_make(none, none, 1.0f);
		paint.surface = 1 + stilb_scene_build_surface(build, &pane);
		stilb_scene_build_part part = {.mesh = shape, .material = stilb_scene_build_material(build, &paint)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_camera camera = {.fov_y = 0.6f, .near_z = 0.1f, .far_z = 100.0f, .exposure = -log2f(white)};
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (int c = 0; c < 3; c++)
		scene->surroundings.sky[c] = scene->surroundings.ground[c] = 0.5f * white;
	return scene;
}

typedef struct stage {
	stilb_scene *scene;
	stilb_engine *engine;
} stage;

static stage opened(uint32_t samples, bool blends)
{
	stage s = {.scene = ramps(blends)};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = samples;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	if (stilb_engine_create(&desc, &s.engine) != STILB_OK || stilb_engine_set_scene(s.engine, s.scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return s;
}

/* The light of the next frame, of display white, kept in `hdr` as far as frames allow it; returns what it was in. */
static stilb_render_hdr drawn(stage *s, stilb_render_hdr hdr, picture out)
{
	stilb_engine_report report;
	stilb_image image = {0};
	s->engine->desc.hdr = hdr;
	if (stilb_engine_frame(s->engine, &report) != STILB_OK ||
	    stilb_render_read_image(s->engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (uint32_t i = 0; i < PIXELS; i++)
		for (uint32_t c = 0; c < 3; c++)
			out[i][c] =
				stilb_image_half_to_float(((const uint16_t *)image.pixels)[image.channels * (size_t)i + c]) / white;
	stilb_image_finish(&image);
	return report.render.hdr;
}

static void closed(stage *s)
{
	assert_int_equal(stilb_engine_validation_messages(s->engine), 0);
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
}

/* ---- the ramps --------------------------------------------------------------------------------------------------- */

static const float *step_of(const picture light, uint32_t ramp, uint32_t step)
{
	return light[(ramp == DARK ? HEIGHT / 4 : HEIGHT - 1 - HEIGHT / 4) * WIDTH + step * WIDE + WIDE / 2];
}

static double code_of(float light)
{
	return 255.0 * (double)shade_srgb_from_linear(light);
}

/* How far the ramp's colours are off, of the largest channel each; and its codes, as the tone map shows them. */
typedef struct bands {
	double channel, codes;
} bands;

static bands bands_of(uint32_t ramp)
{
	bands worst = {0};
	for (uint32_t s = 0; s < STEPS; s++) {
		const float *a = step_of(half, ramp, s), *b = step_of(kept, ramp, s);
		float wanted[3];
		ramp_light(ramp, s, wanted);
		stilb_vec3 shown[2] = {shade_tone(SHADE_TONE_KNEE, stilb_vec3_make(a[0], a[1], a[2])),
		                       shade_tone(SHADE_TONE_KNEE, stilb_vec3_make(b[0], b[1], b[2]))};
		for (int c = 0; c < 3; c++) {
			assert_true(fabsf(a[c] - wanted[c]) <= 2e-3f * wanted[0]);
			worst.channel = fmax(worst.channel, fabs((double)(b[c] - a[c])) / (double)a[0]);
			worst.codes = fmax(worst.codes, fabs(code_of(shown[0][c]) - code_of(shown[1][c])));
		}
	}
	return worst;
}

/* RGBM's largest channel is right within 0.44 %, in the dark 0.85 % (shade_encoding.h); LogLuv's luminance within
 * 0.07 %, its channels within 2.1 % of the largest. It is kept as exposed: shown a quarter as bright it is as right. */
static void ramps_are_right(stage *s, uint32_t samples)
{
	static const double most[STILB_RENDER_HDRS][RAMPS][2] = {
		[STILB_RENDER_HDR_RGBM] = {{0.0085, 0.2}, {0.005, 0.8}},
		[STILB_RENDER_HDR_LOGLUV] = {{0.022, 0.6}, {0.005, 4.0}},
	};
	static const char *const names[RAMPS] = {"dark", "bright"};
	float exposure = s->scene->camera.exposure;
	for (int dimmed = 1; dimmed >= 0; dimmed--) {
		s->scene->camera.exposure = exposure - 2.0f * (float)dimmed;
		assert_int_equal(drawn(s, STILB_RENDER_HDR_HALF, half), STILB_RENDER_HDR_HALF);
		for (int hdr = STILB_RENDER_HDR_RGBM; hdr < STILB_RENDER_HDRS; hdr++) {
			assert_int_equal(drawn(s, (stilb_render_hdr)hdr, kept), hdr);
			for (uint32_t r = 0; r < RAMPS; r++) {
				bands is = bands_of(r);
				printf("%s, %u samples, %s: off by %.2f %% of the largest channel, %.2f codes\n",
				       stilb_render_hdr_names[hdr], samples, names[r], 100.0 * is.channel, is.codes);
				if (is.channel > most[hdr][r][0] || is.codes > most[hdr][r][1])
					fail_msg("%s, %s: off by %f, %f codes", stilb_render_hdr_names[hdr], names[r], is.channel,
					         is.codes);
			}
		}
	}
}

/* ---- who adds light ---------------------------------------------------------------------------------------------- */

static void is_close(const char *name)
{
	for (uint32_t i = 0; i < PIXELS; i++)
		for (int c = 0; c < 3; c++)
			if (fabsf(half[i][c] - kept[i][c]) > 0.0095f * fmaxf(half[i][0], half[i][1]))
				fail_msg("%s: pixel %u is %g of %g", name, i, (double)kept[i][c], (double)half[i][c]);
}

/* Of one sample a pixel. */
static void who_adds_keeps_half_floats(stage *s)
{
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_MULTIPASS, STILB_RENDER_LIGHTING_DEFERRED,
	                                             STILB_RENDER_LIGHTING_PRELIGHT};
	drawn(s, STILB_RENDER_HDR_HALF, half);
	for (uint32_t w = 0; w < sizeof ways / sizeof *ways; w++) {
		stilb_engine_set_lighting(s->engine, ways[w]);
		for (uint32_t frame = 0; frame < 100 && s->engine->views[0].lighting != ways[w]; frame++)
			drawn(s, STILB_RENDER_HDR_RGBM, kept); /* until its programs are there */
		assert_int_equal(s->engine->views[0].lighting, ways[w]);
		bool adds = ways[w] != STILB_RENDER_LIGHTING_PRELIGHT;
		assert_int_equal(drawn(s, STILB_RENDER_HDR_RGBM, kept), adds ? STILB_RENDER_HDR_HALF : STILB_RENDER_HDR_RGBM);
		is_close(stilb_render_lighting_names[ways[w]]);
	}
	stilb_post_settings occlusion = {.occlusion = 1.0f};
	stilb_engine_set_post(s->engine, &occlusion);
	assert_int_equal(drawn(s, STILB_RENDER_HDR_RGBM, kept), STILB_RENDER_HDR_HALF);
	stilb_post_settings none = {0};
	stilb_engine_set_post(s->engine, &none);
	stilb_engine_set_lighting(s->engine, STILB_RENDER_LIGHTING_AUTO);
	stilb_scene *pane = ramps(true);
	assert_int_equal(stilb_engine_set_scene(s->engine, pane), STILB_OK);
	assert_int_equal(drawn(s, STILB_RENDER_HDR_RGBM, kept), STILB_RENDER_HDR_HALF);
	assert_int_equal(stilb_engine_set_scene(s->engine, s->scene), STILB_OK);
	stilb_scene_destroy(pane);
	assert_int_equal(drawn(s, STILB_RENDER_HDR_RGBM, kept), STILB_RENDER_HDR_RGBM);
}

/* ---- decals ------------------------------------------------------------------------------------------------------ */

typedef struct decal {
	stilb_gpu_program program;
	float factors[4];
} decal;

static const float tint[3] = {0.9f, 0.5f, 0.07f};

/* Multiplies what the upper half of the picture has been drawn with. */
static stilb_result decal_add(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	const decal *d = user;
	stilb_gpu_pass row = {.name = "decal",
	                      .kind = STILB_GPU_PASS_FULLSCREEN,
	                      .program = d->program.id,
	                      .color_count = 1,
	                      .color = {{.image = *image, .load = STILB_GPU_LOAD_KEEP}},
	                      .area = {0, 0, WIDTH, HEIGHT / 2},
	                      .constant_bytes = sizeof d->factors};
	memcpy(row.constants, d->factors, sizeof d->factors);
	stilb_gpu_plan_pass(plan, &row);
	return STILB_OK;
}

/* Light of a frame with decals in it. */
static void decals_of(stage *s, decal *d, stilb_render_hdr hdr, picture out)
{
	stilb_vec3 factors = shade_rgbm_tint(stilb_vec3_make(tint[0], tint[1], tint[2]), SHADE_RGBM_GAMMA);
	d->factors[3] = 0.25f; /* leaves the multiplier as it is */
	for (int c = 0; c < 3; c++)
		d->factors[c] = hdr == STILB_RENDER_HDR_RGBM ? factors[c] : tint[c];
	assert_int_equal(drawn(s, hdr, out), hdr);
}

/* Within 1/255 of display white of the dark ramp times the tint, which is also what half floats have. */
static void decals_multiply(stage *s, uint32_t samples)
{
	static const uint32_t code[] =
#include "color.frag.inc"
		;
	double worst = 0.0, relative = 0.0;
	decal d = {0};
	stilb_gpu *gpu = stilb_render_gpu(s->engine->render);
	stilb_gpu_program_desc program = {
		.name = "decal", .fragment = {.words = code, .bytes = sizeof code}, .blend = STILB_GPU_BLEND_MULTIPLY};
	assert_int_equal(stilb_gpu_program_create(gpu, &program, &d.program), STILB_OK);
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_DRAWN, .add = decal_add, .user = &d};
	assert_int_equal(stilb_render_add_feature(s->engine->render, &feature), STILB_OK);
	decals_of(s, &d, STILB_RENDER_HDR_HALF, half);
	decals_of(s, &d, STILB_RENDER_HDR_RGBM, kept);
	for (uint32_t step = 0; step < STEPS; step++) {
		const float *a = step_of(half, DARK, step), *b = step_of(kept, DARK, step);
		float light[3];
		ramp_light(DARK, step, light);
		for (int c = 0; c < 3; c++) {
			if (fabsf(a[c] - tint[c] * light[c]) > 2e-3f * light[0])
				fail_msg("half floats, step %u: %g of %g", step, (double)a[c], (double)(tint[c] * light[c]));
			worst = fmax(worst, fabs((double)(b[c] - tint[c] * light[c])));
			relative = fmax(relative, fabs((double)(b[c] - tint[c] * light[c])) / (double)light[0]);
		}
	}
	printf("decals, %u samples: off by %.4f / 255 of white, %.2f %% of the largest channel\n", samples, 255.0 * worst,
	       100.0 * relative);
	assert_true(worst <= 1.0 / 255.0 && relative <= 0.01);
	const float *bright = step_of(kept, BRIGHT, STEPS - 1); /* below the decal */
	assert_true(fabsf(bright[0] - brightest) <= 0.0054f * brightest);
	stilb_render_remove_feature(s->engine->render, &d);
	stilb_gpu_program_destroy(gpu, d.program);
}

static void one_sample(void **state)
{
	(void)state;
	stage s = opened(1, false);
	ramps_are_right(&s, 1);
	decals_multiply(&s, 1);
	who_adds_keeps_half_floats(&s);
	closed(&s);
}

static void four_samples(void **state)
{
	(void)state;
	stage s = opened(4, false);
	ramps_are_right(&s, 4);
	decals_multiply(&s, 4);
	closed(&s);
}

/* ---- the mean of four texels ------------------------------------------------------------------------------------- */

/* What a bilinear filter takes for the mean of 2 x 2 texels in 8 bits, beside the mean of their light; root of the mean
 * square, of the mean. next: by how much texels beside each other differ. */
static double halved(stilb_render_hdr hdr, float next)
{
	enum { COUNT = 4000 };
	double sum = 0.0;
	for (uint32_t i = 0; i < COUNT; i++) {
		stilb_vec4 stored = {0};
		stilb_vec3 mean = {0}, base;
		for (int c = 0; c < 3; c++)
			base[c] = exp2f(-8.0f + 12.0f * stilb_random_float(i, (uint32_t)c)) * 0.5f;
		for (uint32_t t = 0; t < 4; t++) {
			stilb_vec3 light = base * exp2f(next * (2.0f * stilb_random_float(i, 3 + t) - 1.0f));
			stilb_vec4 code = shade_unorm8(hdr == STILB_RENDER_HDR_RGBM
			                                   ? shade_rgbm_encode(light, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA)
			                                   : shade_logluv_encode(light));
			stored += 0.25f * code;
			mean += 0.25f * light;
		}
		stilb_vec3 back = hdr == STILB_RENDER_HDR_RGBM ? shade_rgbm_decode(stored, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA)
		                                               : shade_logluv_decode(stored);
		double largest = fmax(fmax((double)mean[0], (double)mean[1]), (double)mean[2]), off = 0.0;
		for (int c = 0; c < 3; c++)
			off = fmax(off, fabs((double)(back[c] - mean[c])));
		sum += off * off / (largest * largest);
	}
	return sqrt(sum / COUNT);
}

/* Karis calls RGBM's error negligible: so it is where texels beside each other are alike. LogLuv's two bytes of the
 * level carry over from one into the other, and their mean is another light. */
static void four_texels_at_once(void **state)
{
	static const float nexts[4] = {0.05f, 0.5f, 1.0f, 3.0f}; /* stops */
	static const double most[4] = {0.006, 0.05, 0.12, 0.5};
	(void)state;
	for (uint32_t n = 0; n < 4; n++) {
		double rgbm = halved(STILB_RENDER_HDR_RGBM, nexts[n]), logluv = halved(STILB_RENDER_HDR_LOGLUV, nexts[n]);
		printf("four texels within %g stops: rgbm off by %.2f %%, logluv by %.2f %%\n", (double)(2.0f * nexts[n]),
		       100.0 * rgbm, 100.0 * logluv);
		assert_true(rgbm <= most[n]);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(one_sample),
		cmocka_unit_test(four_samples),
		cmocka_unit_test(four_texels_at_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
