/*
 * scene_look: how a picture shows a scene: the exposure that its light needs, and a studio for what has none.
 *
 * Threads.  [one-writer] where a scene is changed, else [any-thread].
 * Errors.   A result and a message; the scene is then as before.
 * Example.  What `stilb view` does with a file:
 *
 *   stilb_scene *scene;
 *   stilb_result result = stilb_scene_open_with("model.obj", &(stilb_scene_open_options){.dark = true}, &scene);
 *   if (result == STILB_OK && scene->unlit)
 *       result = stilb_scene_set_studio(scene, scene->camera.yaw);
 *   if (result == STILB_OK)
 *       result = stilb_scene_meter(scene, &scene->camera, &scene->camera.exposure);
 */
#ifndef STILB_SCENE_LOOK_H
#define STILB_SCENE_LOOK_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The tone maps of stilb_scene_camera.tone by number: "knee", "none", "neutral", "filmic", "luminance", "piecewise",
 * "hable"; NULL-terminated. */
extern const char *const stilb_scene_tone_names[];

/* The exposure, stops, that suits the light on what this camera sees, in hundredths of a stop: an incident light meter,
 * so that white stays white and black stays black. Of a picture of 96 x 96 pixels with the camera's angle it takes the
 * irradiance E at each pixel whose surface is lit: all lights and surroundings as the formulas of shade_light.h have
 * it, without shadows; a panorama as two halves of its mean radiance above and below the horizon. With E90 the
 * irradiance that a tenth of these pixels exceeds, luminance, the exposure is
 *   log2(pi / E90),
 * which shows a white diffuse surface there as radiance 1. Where no pixel is lit, E90 / pi is the radiance of emission
 * that a tenth of the emitting pixels exceeds; without those it is 0. -32..32. One thread, no timing: the same scene
 * and camera give the same number. Takes 10 to 20 ns a triangle; of more than 2^22 triangles it looks at every second,
 * third, ... [any-thread] STILB_ERROR_MEMORY; then *exposure is 0. */
stilb_result stilb_scene_meter(const stilb_scene *scene, const stilb_scene_camera *camera, float *exposure);

/* Puts the scene into a studio: a key light from the left and above, a fill light from the right and a rim light from
 * behind, all disks far enough away to be even, with grey surroundings, take the place of its lights and surroundings
 * (`studio` then says so); what is behind the models is a grey that a floor below them darkens with their shadow. A
 * white ball in their place is shown with half of the display's range on average, no part of it clipped, and about
 * 3 : 1 between its bright and its dark side. yaw: of the camera that the lights are placed for, radians.
 * STILB_ERROR_MEMORY. [one-writer] */
stilb_result stilb_scene_set_studio(stilb_scene *scene, float yaw);

/* Makes a color, or nothing, the backdrop; without a floor. color: radiance, finite, >= 0. NULL: nothing.
 * [one-writer] */
void stilb_scene_set_backdrop(stilb_scene *scene, const float color[3]);

/* Shows the surroundings behind the models, the floor away: out of focus if blurred, by a lobe of some 10 degrees about
 * each direction. Takes some 30 ms for that, and some nanoseconds for each pixel of a panorama. STILB_ERROR_MEMORY.
 * [one-writer] */
stilb_result stilb_scene_show_surroundings(stilb_scene *scene, bool blurred);

/* What is written into the file of a picture for display: how it shows the scene. */
typedef struct stilb_scene_look {
	float exposure;        /* stops */
	uint32_t tone;         /* SHADE_TONE_... */
	char environment[160]; /* in words: see stilb_scene_environment_words */
} stilb_scene_look;

/* The surroundings in words: "meadow.hdr", "meadow.hdr turned by 90 degrees", "studio", "1,1,1" of one radiance, "1,1,1
 * over 0.4,0.4,0.4" of two. words: [size], with its end. [any-thread] */
void stilb_scene_environment_words(const stilb_scene_surroundings *surroundings, char *words, size_t size);

/* stilb_image_save with these texts in the file: "stilb:exposure" ("1.5"), "stilb:tone" ("neutral") and
 * "stilb:environment". [any-thread] Its errors. */
stilb_result stilb_scene_look_save(const stilb_scene_look *look, const stilb_image *image, const char *path);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
