/*
 * Lights combined in one pass (STILB_RENDER_LIGHTING_COMBINED): each model has at most four lights of its own, and all
 * others that reach it are one sum of spherical harmonics, which lights it by the normal. Inside render/.
 *
 * Object.   A model of the scene, with all of its parts, levels and its impostor. Its sphere is the scene's, so that a
 *           figure's moves with it. What is drawn by hand, and what stilb_render_record records without a view, has no
 *           model, and asks every light as FORWARD does; so do dumps, which draw by hand.
 * Choice.   Each replay chooses for the models that the pass has recorded, on jobs: lights whose sphere and cone touch
 *           the model's sphere reach it; those that send the most to its centre (luminance of the irradiance across the
 *           beam) are its own. The sphere test is a loop over all lights, four at a time. Measured on one thread:
 *           0.5 us a model with 230 lights, 12 us with 10,000. No camera has a say in it.
 * Crossing. A light that becomes one of the four, or ceases to be, moves between its own shape and the sum by a
 *           sixteenth a frame. Four are never exceeded: the one that goes leaves the fourth place first. What is there
 *           stays until another light sends an eighth more. Shares are kept by the pass and the model, and belong to
 *           the light's place among the view's lights. Models that the pass did not record in the frame before start
 *           without a crossing, and so do lights that come to a model which had all of its own by themselves.
 * Sum.      As seen from the model's centre, windowed (SHADE_SH_WINDOW_IRRADIANCE: no surface gets less than nothing),
 *           and convolved with the cosine. It lights the diffuse reflectance of what lies below coats, alone: no
 *           highlights, no sheen, no light through leaves, and wrapped materials have it unwrapped. A light that
 *           touches the model but not its centre, and is none of the four, adds nothing.
 * Equal.    A model that four lights reach, or fewer, has all of them by themselves, in the order in which FORWARD adds
 *           them up: the same bits.
 * Memory.   A word for each model of the scene and 144 bytes for each that is drawn, of the frame; 28 bytes for each
 *           model of the scene that stay.
 * Shaders.  A row has its model (render_row.model), which leads to its word, and that to its record. So draws that are
 *           one device command each have lights of their own. The vertex shader reads the word, pixels the record.
 * Sources.  Karis, "Deferred rendering 2" (2009), "light pass combined forward rendering"; Forsyth, "Spherical
 *           Harmonics in Actual Games" (2003).
 */
#ifndef STILB_RENDER_COMBINED_H
#define STILB_RENDER_COMBINED_H

#include "jobs/job.h"
#include "light/light.h"
#include "scene/scene.h"
#include "shading/shade_light.h"

#define RENDER_COMBINED_OWN 4u          /* lights of a model's own */
#define RENDER_COMBINED_SHARE 16u       /* a light of which nothing is in the sum has so many shares */
#define RENDER_COMBINED_NONE UINT32_MAX /* in the place of a light */

/* A model that a pass draws. */
typedef struct render_combined_model {
	uint32_t model;
	float center[3], radius; /* world space, metres */
} render_combined_model;

/* The lights that a model had of its own when it was drawn last. */
typedef struct render_combined_state {
	uint32_t light[RENDER_COMBINED_OWN]; /* place among the view's lights */
	uint8_t share[RENDER_COMBINED_OWN];  /* 1 .. RENDER_COMBINED_SHARE */
	uint32_t frame;                      /* render_combined_pass.frame */
	uint32_t reaching;                   /* so many lights reached it */
} render_combined_state;

/* What a pass has of it. {0} is empty. */
typedef struct render_combined_pass {
	render_combined_model *models; /* [model_count] that were recorded in this frame */
	render_combined_state *states; /* [state_capacity] by model of the scene */
	uint32_t model_count, model_capacity, state_capacity;
	uint32_t scene_models; /* the scene has so many */
	uint32_t frame;        /* counts the pass's frames */
} render_combined_pass;

/* A record as the shaders read it (shaders/lit.glsl). */
typedef struct render_combined_record {
	uint32_t light[RENDER_COMBINED_OWN]; /* ascending; then RENDER_COMBINED_NONE */
	float share[RENDER_COMBINED_OWN];    /* 1 / RENDER_COMBINED_SHARE .. 1 */
	float sum[3][8], last[4]; /* of red, green and blue the first eight coefficients of the irradiance, and the ninth */
} render_combined_record;

static_assert(sizeof(render_combined_record) == 144, "nine vec4");

/* The high bit of a model's word: its record has a sum. Below it the record's place, counted in vec4; the word 0: the
 * model has no record. */
#define RENDER_COMBINED_SUM 0x80000000u

typedef struct render_combined_reaching render_combined_reaching;

/* Memory of the choice, kept from pass to pass. {0} is empty. */
typedef struct render_combined {
	float *x, *y, *z, *radius;  /* [capacity] of the lights' spheres, x NaN: nowhere; one allocation */
	shade_light *lights;        /* [capacity] */
	stilb_light_bounds *bounds; /* [capacity] */
	uint32_t capacity;
	render_combined_reaching *reaching; /* [worker_count] */
	uint32_t worker_count;
} render_combined;

struct stilb_render;
struct stilb_render_view;
struct render_view_lights;

/* Notes the models that the pass records. STILB_ERROR_MEMORY. [main-thread] */
stilb_result render_combined_note(render_combined_pass *pass, const stilb_scene *scene, const uint32_t *visible,
                                  uint32_t visible_count);
/* Another scene has come: its models were never drawn. */
void render_combined_renew(render_combined_pass *pass);
void render_combined_pass_finish(render_combined_pass *pass);
void render_combined_finish(render_combined *combined);

#endif
