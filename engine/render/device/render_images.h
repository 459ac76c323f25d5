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
/* The depth by which that was decided, as "depth"; d32_f, one sample a pixel. There only where rows of their own draw
 * velocities: with several samples a pixel, of channels in the place of light, and with `surfaces` of views whose
 * lights are deferred; else it is "depth". */
#define STILB_RENDER_IMAGE_VELOCITY_DEPTH "velocity depth"

/* The depth of what blends where its alpha is at least its cutoff, and nothing keeps it from being seen but other such
 * surfaces; elsewhere 0. d32_f, one sample a pixel; of the main images' views with `blended`, where there is some. */
#define STILB_RENDER_IMAGE_BLENDED_DEPTH "blended depth"

/* Of the same surfaces as "velocity", by the same passes, of views with `surfaces`, or with `ids` the second one; one
 * sample a pixel. Outputs. At the stages AMBIENT and REFLECTION what can be lit later has been drawn alone.
 *   surface normal  the shading normal, in the world, bent by maps and towards the viewer, and by the program's
 *                   functions: on the octahedral map, times 0.5, plus 0.5; rg16_u. Of what has a coat that below it
 *   id              the scene's model + 1; 0: nothing, or what is drawn by hand; r32_ui
 * Where "velocity depth" is 0 there is none, and both are 0. */
#define STILB_RENDER_IMAGE_SURFACE_NORMAL "surface normal"
#define STILB_RENDER_IMAGE_ID "id"

/* Of views with `ambient_apart`, of what can be lit later or in several passes (opaque, without layers or a function of
 * the program's): what it sends on of the surroundings' light, rgba16_f, one sample a pixel, alpha 1; elsewhere 0. It
 * is radiance of the surface, and not yet in "color" when it is drawn: a row of its own adds both. Outputs.
 *   ambient     scattered evenly
 *   reflection  mirrored by highlights */
#define STILB_RENDER_IMAGE_AMBIENT "ambient"
#define STILB_RENDER_IMAGE_REFLECTION "reflection"

/* Of views with `mirrors`, of the same surfaces, by the same passes, one sample a pixel; elsewhere 0. Outputs.
 *   mirror         which share of the surroundings' light their highlights mirror, by channel, and their roughness;
 *                  rgba8_u
 *   mirror normal  their shading normal, as "surface normal" has it */
#define STILB_RENDER_IMAGE_MIRROR "mirror"
#define STILB_RENDER_IMAGE_MIRROR_NORMAL "mirror normal"

/* With lighting DEFERRED and TILED_DEFERRED, of the surfaces that are lit so (shaders/deferred/gbuffer.glsl), rgba16_u,
 * one sample a pixel; of a target with another name NAME " normal", .... They hold anything where none is.
 *   normal    the shading normal on the octahedral map, x and y; anisotropy; these three times 0.5, plus 0.5; wrap
 *   diffuse   diffuse reflectance, roughness
 *   specular  specular reflectance at normal incidence, 1
 * With STILB_RENDER_GBUFFER_RGBA8, rgba8_u, normal is depth along the view in two numbers, and the normal's x and y
 * across the pixel's ray; specular has the anisotropy behind it. */
#define STILB_RENDER_IMAGE_NORMAL "normal"
#define STILB_RENDER_IMAGE_DIFFUSE "diffuse"
#define STILB_RENDER_IMAGE_SPECULAR "specular"

/* Light on what is lit by PREPASS and PRELIGHT, rgba16_f, before it has the surfaces' colours: radiance that a white
 * surface would scatter. Behind it PREPASS has the luminance of white highlights, and PRELIGHT, in an image of its own,
 * their radiance. Of such surfaces "normal" alone is there: that of PRELIGHT has roughness in the place of anisotropy,
 * that of PREPASS is as with rgba8. */
#define STILB_RENDER_IMAGE_SCATTERED "scattered"
#define STILB_RENDER_IMAGE_HIGHLIGHTS "highlights"

/* Radiance of the same scene and camera by the way of lighting that others are measured by, as "color": of a target
 * with this name, into which another view draws. And of frames that show STILB_RENDER_SHOW_ERROR how far "color" is
 * from it, by channel, rgba16_f, alpha 1, one sample a pixel; an output. */
#define STILB_RENDER_IMAGE_REFERENCE "reference"
#define STILB_RENDER_IMAGE_ERROR "error"

/* Depth as the lights see it, d32_f, layers: see stilb_render_shadows. And what programs read where there is none, a
 * texel for nobody to look at. */
#define STILB_RENDER_IMAGE_SHADOW "shadow"
#define STILB_RENDER_IMAGE_NO_SHADOWS "no shadows"

/* Of views whose shadow_reading has a buffer, one sample a pixel: the square roots of the shares of shadowed lights
 * that arrive, four lights in each layer: directional ones first, then the others, both in the view's order. rgba8_u,
 * layers; of a target with another name NAME " shadow buffer". Of what can be lit later or in several passes; it holds
 * anything where none of that is. */
#define STILB_RENDER_IMAGE_SHADOW_BUFFER "shadow buffer"

/* The share of each shadowed directional light that reaches the pixel where its cascades end: layer k of the k-th one,
 * r8_u, the size of the main images, whose it is. Who knows, writes it, in a row of the stage FIRST
 * (stilb_render_feature): nothing here does, and where there is none, as beyond its layers, all light arrives. Read
 * where the shadow buffer is drawn. With stilb_render_shadow_reading.things in all of the picture: the less of this and
 * the maps' share arrives. */
#define STILB_RENDER_IMAGE_MASK "mask"

/* Reserved: nothing writes these yet. */
#define STILB_RENDER_IMAGE_PROBES "probes" /* rgba16_f, layers: irradiance at the places of probes */

#endif
