/*
 * The images that passes share, by name: what each holds, in which space and unit, and who writes it. A program's own
 * passes find them by these names (stilb_gpu_plan_find).
 *
 * Sizes are the picture's unless a row says another; of the main images (color, color samples, depth) those of their
 * target, which may be another (render.h). Positions and directions are in the world, distances in metres,
 * radiance in W sr^-1 m^-2.
 */
#ifndef STILB_RENDER_IMAGES_H
#define STILB_RENDER_IMAGES_H

/* Linear radiance of the scene, premultiplied by alpha, the share of the pixel that something covers. rgba16_f, one
 * sample a pixel. Written by scene passes, with several samples a pixel by the resolve. */
#define STILB_RENDER_IMAGE_COLOR "color"
/* The same, with the samples of the picture, where they are several. Written by scene passes. */
#define STILB_RENDER_IMAGE_COLOR_SAMPLES "color samples"
/* Depth in clip space, reversed: 1 at the near plane, 0 infinitely far away. d32_f, with the samples of the picture.
 * Written by scene passes. */
#define STILB_RENDER_IMAGE_DEPTH "depth"
/* What is shown: rgba8_srgb, or with output linear rgba16_f. Written by the tone map and 2D passes. */
#define STILB_RENDER_IMAGE_PICTURE "picture"

/* Pixels from the pixel's middle to where what it shows was in the frame before, x to the right, y down: by movement of
 * the camera, of models and of vertices. rg16_f, one sample a pixel; at most 32,768 either way. Written by passes
 * whose view has `last`, of what does not blend; where nothing is, of what is infinitely far away. An output. */
#define STILB_RENDER_IMAGE_VELOCITY "velocity"
/* The depth by which that was decided, as "depth"; d32_f, one sample a pixel. */
#define STILB_RENDER_IMAGE_VELOCITY_DEPTH "velocity depth"

/* With lighting DEFERRED, of the surfaces that are lit so (shaders/deferred/gbuffer.glsl), rgba16_u, one sample a
 * pixel; of a target with another name NAME " normal", .... They hold anything where none is.
 *   normal    the shading normal on the octahedral map, x and y; anisotropy; these three times 0.5, plus 0.5; wrap
 *   diffuse   diffuse reflectance, roughness
 *   specular  specular reflectance at normal incidence, 1
 * With STILB_RENDER_GBUFFER_RGBA8, rgba8_u, normal is depth along the view in two numbers, and the normal's x and y
 * across the pixel's ray; specular has the anisotropy behind it. */
#define STILB_RENDER_IMAGE_NORMAL "normal"
#define STILB_RENDER_IMAGE_DIFFUSE "diffuse"
#define STILB_RENDER_IMAGE_SPECULAR "specular"

/* Reserved: nothing writes these yet. */
#define STILB_RENDER_IMAGE_ID "id"                 /* r32_ui: model + 1; 0: none */
#define STILB_RENDER_IMAGE_AMBIENT "ambient"       /* rgba16_f: radiance of light from all around */
#define STILB_RENDER_IMAGE_REFLECTION "reflection" /* rgba16_f: radiance of mirrored light */
#define STILB_RENDER_IMAGE_SHADOW "shadow"         /* d32_f, layers: depth as the lights see it */
#define STILB_RENDER_IMAGE_MASK "mask"             /* r8_u, layers: the share of a light that reaches the pixel */
#define STILB_RENDER_IMAGE_PROBES "probes"         /* rgba16_f, layers: irradiance at the places of probes */

#endif
