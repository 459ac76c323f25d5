/*
 * scene_look: how a picture shows a scene: the exposure that its light needs.
 *
 * Threads.  [any-thread]
 * Example.
 *
 *   stilb_result result = stilb_scene_meter(scene, &scene->camera, &scene->camera.exposure);
 */
#ifndef STILB_SCENE_LOOK_H
#define STILB_SCENE_LOOK_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

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

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
