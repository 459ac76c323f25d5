/* What tests of many lights share: a field of balls under lamps of every kind and falloff, and frames of it in each way
 * of stilb_render_lighting, under the validation layer. */
#ifndef LIGHTS_FIELD_H
#define LIGHTS_FIELD_H

#include "render/maps/maps_stage.h"

#define WIDTH 99u /* odd: the last cells of a row are narrow */
#define HEIGHT 67u
#define LAMPS 60u

/* What deferred lighting may be off by, a share of the light: reflectances in steps of 1 / 65535 with a rounding of
 * half a step, normals likewise, a half float's 11 bits, each taken twice as its pixel adds two. Highlights of the
 * least roughness here multiply an angle's error by some 50. */
#define DEFERRED_OFF 2e-3
#define DEFERRED_ADDED 3.0  /* times as much where each light is rounded: up to 16 a pixel, each by 2^-12 */
#define DEFERRED_FLOOR 1e-4 /* radiance: half floats are coarse beside nothing */

typedef struct field {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_scene_light lights[LAMPS + 8];
	const stilb_scene_light *own_lights; /* [view.light_count] in place of `lights`; NULL: there are none */
	uint32_t light_count;
	stilb_render_view view;
	stilb_render_target target;
} field;

static inline stilb_scene_light lamp(stilb_scene_light_kind kind, stilb_scene_light_falloff falloff, float x, float z)
{
	stilb_scene_light light = {.kind = kind,
	                           .position = {x, 1.2f, z},
	                           .direction = {0.0f, -1.0f, 0.0f},
	                           .intensity = {3.0f, 2.0f, 4.0f},
	                           .cos_inner = 0.9f,
	                           .cos_outer = 0.6f,
	                           .radius = 0.3f,
	                           .half_x = {0.3f, 0.0f, 0.0f},
	                           .half_y = {0.0f, 0.0f, 0.4f},
	                           .falloff = falloff,
	                           .reach = 2.5f};
	assert_null(stilb_scene_light_mistake(&light));
	return light;
}

/* Lamps as of stilb demo --lights, a light of each other kind with each falloff that ends, a sun among them, and a lamp
 * that ends nowhere. */
static inline void field_lights(field *f)
{
	memcpy(f->lights, f->scene->lights + 1, LAMPS * sizeof *f->lights);
	f->light_count = LAMPS;
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_SUBTRACTED, -3.0f, 2.0f);
	f->lights[f->light_count++] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.6f, -0.8f, 0.0f}, .intensity = {0.1f, 0.1f, 0.2f}};
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_RECTANGLE, STILB_SCENE_LIGHT_RANGED, 4.0f, 1.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_PHYSICAL, 0.0f, 6.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_RANGED, 1.0f, 7.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_SPOT, STILB_SCENE_LIGHT_SUBTRACTED, -2.0f, 7.0f);
	f->lights[f->light_count] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_WINDOWED, 0.0f, 2.0f);
	f->lights[f->light_count++].use = STILB_SCENE_LIGHT_BAKED;
}

/* desc: what is not of every field's renderer. */
static inline field field_open_desc(stilb_render_desc desc, uint32_t workers)
{
	field f = {0};
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.context_count = workers + 1;
	desc.validate = true;
	if (stilb_render_create(&desc, &f.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &f.pool), 0);
	assert_int_equal(stilb_scene_create_stress(64, 7, &f.scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(f.scene, LAMPS), STILB_OK);
	assert_int_equal(stilb_render_set_scene(f.render, f.scene), STILB_OK);
	field_lights(&f);
	reference_camera camera =
		reference_camera_at((dvec){1, 2.5, 12}, (dvec){0, 0, 3}, (dvec){0, 1, 0}, 1.2, WIDTH, HEIGHT);
	f.view = (stilb_render_view){.view_projection = reference_matrix(&camera),
	                             .camera_position = {1.0f, 2.5f, 12.0f},
	                             .light_count = f.light_count,
	                             .surroundings = f.scene->surroundings,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS},
	                             .shading = stilb_render_shading_default()};
	return f;
}

static inline field field_open(stilb_render_output output, uint32_t workers, uint32_t samples)
{
	return field_open_desc((stilb_render_desc){.samples = samples, .output = output}, workers);
}

static inline void field_close(field *f)
{
	assert_int_equal(stilb_render_wait(f->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(f->render), 0);
	stilb_render_destroy(f->render);
	stilb_scene_destroy(f->scene);
	stilb_job_pool_destroy(f->pool);
}

/* Frames of the view lit in that way; passes: how often it draws the field into the same target. */
static inline void field_frame(field *f, stilb_render_lighting lighting, uint32_t passes)
{
	stilb_render_pass table[4] = {{.name = "main"}, {.name = "again"}, {.name = "once more"}};
	uint32_t ids[64];
	for (uint32_t m = 0; m < 64; m++)
		ids[m] = m;
	f->view.lighting = lighting;
	f->view.lights = f->own_lights ? f->own_lights : f->lights;
	assert_int_equal(stilb_render_frame_begin(f->render), STILB_OK);
	for (uint32_t p = 0; p < passes; p++)
		assert_int_equal(stilb_render_record(f->render, p, f->scene, ids + 32 * p, passes == 1 ? 64 : 32, f->pool, 0),
		                 STILB_OK);
	if (stilb_render_replay(f->render, table, passes, &f->view, 1, f->pool, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static inline stilb_image field_picture(field *f, stilb_render_lighting lighting, uint32_t passes)
{
	stilb_image image;
	field_frame(f, lighting, passes);
	if (stilb_render_read_image(f->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static inline void assert_same_bits(const char *what, const stilb_image *a, const stilb_image *b)
{
	assert_int_equal(stilb_image_size(a), stilb_image_size(b));
	if (memcmp(a->pixels, b->pixels, stilb_image_size(a)) != 0)
		fail_msg("%s: pictures differ", what);
}

/* How far the pictures are apart, as a multiple of what deferred lighting may be off by; at most 1 is good. */
static inline double deferred_off(const stilb_image *want, const stilb_image *got)
{
	double worst = 0.0;
	for (uint32_t y = 0; y < want->height; y++)
		for (uint32_t x = 0; x < want->width; x++)
			for (int c = 0; c < 3; c++) {
				double a = picture_value(want, x, y, c), b = picture_value(got, x, y, c);
				worst = fmax(worst, fabs(a - b) / (DEFERRED_FLOOR + DEFERRED_OFF * a));
			}
	return worst;
}

/* times: what is allowed. */
static inline void assert_near_deferred(const char *what, const stilb_image *want, const stilb_image *got, double times)
{
	double off = deferred_off(want, got);
	if (!(off <= times))
		fail_msg("%s: off by %.2f, allowed are %.2f", what, off, times);
}

static inline void assert_deferred(const char *what, const stilb_image *want, const stilb_image *got)
{
	assert_near_deferred(what, want, got, 1.0);
}

/* How near a way's pictures are to those of FORWARD. */
typedef enum nearness {
	SAME_BITS,
	ROUNDED, /* by what images of surfaces hold */
	ADDED,   /* by many sums in half floats */
	OWN,     /* they have highlights of their own */
} nearness;

static inline nearness way_nearness(stilb_render_lighting way)
{
	static const nearness of[STILB_RENDER_LIGHTING_WAYS] = {
		[STILB_RENDER_LIGHTING_MULTIPASS] = ADDED,        [STILB_RENDER_LIGHTING_DEFERRED] = ROUNDED,
		[STILB_RENDER_LIGHTING_TILED_DEFERRED] = ROUNDED, [STILB_RENDER_LIGHTING_PREPASS] = OWN,
		[STILB_RENDER_LIGHTING_PRELIGHT] = OWN,
	};
	return of[way];
}

/* got: lit in that way. */
static inline void assert_as_forward(const char *what, stilb_render_lighting way, const stilb_image *forward,
                                     const stilb_image *got)
{
	char text[96];
	snprintf(text, sizeof text, "%s, %s", what, stilb_render_lighting_names[way]);
	if (way_nearness(way) == SAME_BITS)
		assert_same_bits(text, forward, got);
	else if (way_nearness(way) != OWN)
		assert_near_deferred(text, forward, got, way_nearness(way) == ADDED ? DEFERRED_ADDED : 1.0);
}

#endif
