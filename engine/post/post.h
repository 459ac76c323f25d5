/*
 * post: what happens to a frame's light between the scene and the display. Rows in the frame's plan, each of which is
 * there only while its effect is asked for.
 *
 * Chain      In this order, whatever was asked for first:
 *              occlusion  stage AMBIENT  ambient light where surfaces are in each other's way
 *              reflections  stage REFLECTION  surfaces mirror what else the picture shows
 *              temporal   stage LIGHT    antialiasing by the mean of frames
 *              depth of field  stage LIGHT  what is not in focus is blurred
 *              motion     stage LIGHT    what moves while the shutter is open
 *              exposure   stage LIGHT    how bright the light is, before the lens scatters it
 *              bloom      stage LIGHT    light that the lens scatters
 *            The tone map follows, the grade, dither (render.h): one row.
 *              edges      stage PICTURE  antialiasing of what is shown
 * Occlusion  From the frame's depth, in half the size: how much of the hemisphere over each pixel is open, weighted by
 *            the cosine; what is nearer than the radius hides its directions, less the farther it is. It darkens the
 *            image "ambient" alone (render_images.h), so views need ambient_apart, and pictures one sample a pixel: in
 *            others there is no such row. What depth does not show hides nothing.
 * Reflections  What surfaces mirror of the surroundings gives way to what else of the scene the picture shows, where
 *            mirrored rays meet it: rays over a hierarchy of the frame's nearest depths, of rough surfaces several in a
 *            cone. It changes the image "reflection" alone (render_images.h), so views need `mirrors`, pictures one
 *            sample a pixel and cameras a perspective: in others there are no such rows. What is mirrored is all light
 *            of surfaces of "ambient"; it fades towards the picture's edges, and what would be seen from behind is not
 *            there. With CRUDE some steps of equal length, fewer the rougher a surface is, faded towards their end.
 * Depth of   A thin lens of radius `aperture` in focus at the distance `focus`, as rays have it (gi_render.h): what is
 * field      at depth z along the view is spread over the aperture's shape, of radius aperture |1 / focus - 1 / z| in
 *            the picture plane at distance 1, its circle of confusion. Radii above an eighth of the picture's height,
 *            or above 200 pixels, are cut to that. What is nearer than the plane in focus is apart from the rest: it
 *            covers what is behind it as far as it spreads, while what is in focus keeps its edges, and nothing that
 *            lies behind another thing spreads over it. What near things hide is not known, and is taken from around.
 *            What blends counts with its own depth where its alpha is at least its cutoff, and what is seen through it
 *            there with it; elsewhere with that of what lies behind. Frames have one sample a pixel and a
 *            perspective: others are left as they are. NaN and infinite light spreads nowhere.
 *            With LERP light is blurred whatever its depth, by two radii, and each pixel has what lies linearly between
 *            these and its own: small and large blur of Karis, "Uncharted 2" (2010).
 * Bloom      A share of each pixel's light goes to pixels around it, the rest stays: no light is made or lost but at
 *            the picture's edges, where it is mirrored. The pattern is a sum of ever wider ones, each twice as wide as
 *            the one before: the light is halved in size again and again, and added up on the way back. Both ways the
 *            weights are those of a quadratic B-spline, whose sums are the same wherever a pixel lies, so that what
 *            moves does not flicker. NaN and infinite light stays where it is and scatters nothing.
 *            With FIXED the images between hold T(c) = c / (1 + c's largest channel) in 8 bits, half the bytes.
 * Temporal   Each frame samples the scene at another place of the pixel (stilb_post_jitter), by which the caller moves
 *            what the view draws and sees, `last` likewise, and nothing else. A pixel is the mean of what was seen
 *            there in up to 64 frames, of what moves by parts of a pixel in 9, followed back by velocity. Light is
 *            weighted by 1 / (1 + its exposed luma), luma r / 4 + g / 2 + b / 4, so that a lamp does not outweigh all
 *            else of a pixel at its edge. A texel of history counts only if all that it is of is seen around the pixel
 *            in this frame: no model that is not (by 32 and by 24 classes of ids), nothing nearer or farther by 3 %
 *            than all that is, no own movement that differs from theirs by half. What counts is kept within the
 *            colours of the nine pixels. What is no light (NaN, infinite) counts as if it were not there. Views need
 *            `last` and `surfaces`, show SHADED, and have light in half floats: in other frames there is no such row,
 *            nor any history in the next one.
 * Motion     What moves while the shutter is open, around the frame's moment, as velocities say: of camera, models and
 *            vertices. A pixel gathers along the longest movement of the tiles around it what passes over it in front
 *            of what it shows, each for its share of the time; then its own surface along its own movement; and what is
 *            left of the time shows what lies behind, as it is nearest by. Views need `last`, and show SHADED.
 *            With FAR the camera's movement alone blurs, and only what is far away: in half the width and height, 16
 *            samples along the way; what is nearer than `motion_blur_far` stays sharp and gives nothing, from there to
 *            twice as far the blur sets in (Karis, "Uncharted 2", 2010).
 * Edges      A filter of the picture in display codes, not of radiance. An edge is where luma changes by 0.04 and by a
 *            tenth; a pixel next to it takes that share of the one across it which a straight line between the edge's
 *            ends would cover.
 * Place      Occlusion and bloom are computed by programs of the device, or by the CPU's threads between two
 *            submissions: the same pixels but for rounding, which is between images in half floats there and in floats
 *            here; bloom_format is then of no account.
 * Exposure   Each frame the device counts pixels by luminance, 16 classes a stop, from 2^-16 to 2^16 W sr^-1 m^-2;
 *            others, NaN among them, are left out. The mean of log2 of what lies between two percentiles is to be shown
 *            as 0.18 of display white, and the exposure goes there: its distance d from there, in stops, falls by
 *            min(a |d|, r) a second, which far away is r and near by 1 - exp(-a t), and is the same however the time is
 *            cut into frames. What a frame counts is known two frames later, to the CPU, too, which gives all passes
 *            one number. Without such counts the exposure stays.
 * Grade      A table of colours (post_table.h) after the tone map, which views look up (stilb_render_view.grade). Areas
 *            are boxes of the world with tables of their own: at its sides an area weighs a half, half of `blend` in it
 *            1, as far outside 0, by 3 t^2 - 2 t^3; so two rooms that share a wall, or a doorway, together weigh 1
 *            everywhere between. Weights that sum to more than 1 are divided by their sum; what they leave is for the
 *            table of no area. What is seen is the same mean of what these tables show, as the camera stands.
 * Sources    Bavoil, Sainz, Dimitrov, "Image-Space Horizon-Based Ambient Occlusion" (2008), and Jimenez, Wu, Pesce,
 *            Jarabo, "Practical Real-Time Strategies for Accurate Indirect Occlusion" (2016), for occlusion; Uludag,
 *            "Hi-Z Screen-Space Cone-Traced Reflections" (GPU Pro 5, 2014), for reflections; Karis,
 *            "High-Quality Temporal Supersampling" (2014), and Yang, Liu, Salvi, "A Survey of Temporal Antialiasing
 *            Techniques" (2020), for temporal antialiasing; McGuire, Hennessy, Bukowski, Osman, "A Reconstruction
 *            Filter for Plausible Motion Blur" (2012), for motion; Karis, "Tone mapping" (2013), for T; Jimenez, "Next
 *            Generation Post Processing in Call of Duty: Advanced Warfare" (2014), for motion, the chain of
 *            halves, and the near field and tiles of depth of field; Potmesil, Chakravarty, "A Lens and Aperture
 *            Camera Model for Synthetic Image Generation" (1981), for its circles;
 *            Lottes, "FXAA" (2009), and Reshetov, "Morphological Antialiasing" (2009), for edges.
 * Life       stilb_post_create, stilb_post_set whenever settings change, stilb_post_destroy before the renderer.
 * Threads    [main-thread] of the renderer, all of them.
 */
#ifndef STILB_POST_H
#define STILB_POST_H

#include "base/base.h"
#include "jobs/job.h"
#include "post/post_table.h"
#include "render/render.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* In which images bloom adds light up. */
#define STILB_POST_BLOOM_FORMATS(X)                                                                                    \
	X(HALF, "half", "half floats")                                                                                     \
	X(FIXED, "fixed", "8 bits, through a tone curve and back")

#define STILB_POST_BLOOM_ENUM(id, ...) STILB_POST_BLOOM_##id,
typedef enum stilb_post_bloom_format {
	STILB_POST_BLOOM_FORMATS(STILB_POST_BLOOM_ENUM) STILB_POST_BLOOM_FORMATS_COUNT
} stilb_post_bloom_format;

/* Their identifiers, NULL-terminated; the index is the stilb_post_bloom_format. */
extern const char *const stilb_post_bloom_format_names[];
#undef STILB_POST_BLOOM_ENUM

/* How surfaces mirror what the picture shows. */
#define STILB_POST_REFLECTIONS_WAYS(X)                                                                                 \
	X(OFF, "off", "they mirror the surroundings alone")                                                                \
	X(CONES, "cones", "cones, by a hierarchy of depth")                                                                \
	X(CRUDE, "crude", "some steps, fewer the rougher a surface is")                                                    \
	X(LINEAR, "linear", "64 steps, and nothing where they meet nothing: what others are measured by")

#define STILB_POST_REFLECTIONS_ENUM(id, ...) STILB_POST_REFLECTIONS_##id,
typedef enum stilb_post_reflections {
	STILB_POST_REFLECTIONS_WAYS(STILB_POST_REFLECTIONS_ENUM) STILB_POST_REFLECTIONS_COUNT
} stilb_post_reflections;
#undef STILB_POST_REFLECTIONS_ENUM
/* Their identifiers, NULL-terminated; the index is the stilb_post_reflections. */
extern const char *const stilb_post_reflections_names[];

/* What motion blur blurs. */
#define STILB_POST_MOTIONS(X)                                                                                          \
	X(ALL, "all", "what passes a pixel, by tiles")                                                                     \
	X(FAR, "far", "what is far away, by the camera's movement, in a quarter of the pixels")

#define STILB_POST_MOTION_ENUM(id, ...) STILB_POST_MOTION_##id,
typedef enum stilb_post_motion { STILB_POST_MOTIONS(STILB_POST_MOTION_ENUM) STILB_POST_MOTION_COUNT } stilb_post_motion;
#undef STILB_POST_MOTION_ENUM
/* Their identifiers, NULL-terminated; the index is the stilb_post_motion. */
extern const char *const stilb_post_motion_names[];

/* How depth of field blurs. */
#define STILB_POST_DOFS(X)                                                                                             \
	X(OFF, "off", "everything is sharp")                                                                               \
	X(BOKEH, "bokeh", "near and far fields, in the aperture's shape")                                                  \
	X(LERP, "lerp", "between two blurs, whatever the depth")

#define STILB_POST_DOF_ENUM(id, ...) STILB_POST_DOF_##id,
typedef enum stilb_post_dof { STILB_POST_DOFS(STILB_POST_DOF_ENUM) STILB_POST_DOF_COUNT } stilb_post_dof;
#undef STILB_POST_DOF_ENUM
/* Their identifiers, NULL-terminated; the index is the stilb_post_dof. */
extern const char *const stilb_post_dof_names[];

/* Who computes occlusion and bloom. */
#define STILB_POST_PLACES(X)                                                                                           \
	X(AUTO, "auto", "the CPU's threads on software devices, unless bloom is FIXED; else the device")                   \
	X(GPU, "gpu", "programs of the device")                                                                            \
	X(CPU, "cpu", "the CPU's threads, for which the device waits")

#define STILB_POST_PLACE_ENUM(id, ...) STILB_POST_PLACE_##id,
typedef enum stilb_post_place { STILB_POST_PLACES(STILB_POST_PLACE_ENUM) STILB_POST_PLACES_COUNT } stilb_post_place;
#undef STILB_POST_PLACE_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_post_place. */
extern const char *const stilb_post_place_names[];

/* What is done before 8 bits (stilb_render_dither). */
#define STILB_POST_DITHERS(X)                                                                                          \
	X(ORDERED, "ordered", "up to half a code, by a pattern")                                                           \
	X(TRIANGULAR, "triangular", "up to a code, without one")                                                           \
	X(OFF, "off", "codes are the nearest ones")

#define STILB_POST_DITHER_ENUM(id, ...) STILB_POST_DITHER_##id,
typedef enum stilb_post_dither {
	STILB_POST_DITHERS(STILB_POST_DITHER_ENUM) STILB_POST_DITHERS_COUNT
} stilb_post_dither;
#undef STILB_POST_DITHER_ENUM

/* Likewise; the index is the stilb_post_dither. */
extern const char *const stilb_post_dither_names[];
/* How edges are made smooth, besides several samples a pixel. */
#define STILB_POST_AAS(X)                                                                                              \
	X(NONE, "none", "as they are sampled")                                                                             \
	X(POST, "post", "a filter of the shown picture along its edges")                                                   \
	X(TEMPORAL, "temporal", "the mean of frames that sample pixels at other places")

#define STILB_POST_AA_ENUM(id, ...) STILB_POST_AA_##id,
typedef enum stilb_post_aa { STILB_POST_AAS(STILB_POST_AA_ENUM) STILB_POST_AA_COUNT } stilb_post_aa;
#undef STILB_POST_AA_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_post_aa. */
extern const char *const stilb_post_aa_names[];

/* {0}: no effect. */
typedef struct stilb_post_settings {
	float occlusion;        /* by how much ambient light is darker where it is hidden, 0..1; 0: there is no such row */
	float occlusion_radius; /* metres, >= 0 and finite; 0: 1 */
	float bloom;            /* the share of light that is scattered, 0..1; 0: there is no such row. Lenses: .02 to .1 */
	float bloom_width;      /* of what is scattered, the share that each twice as wide pattern gets in place of the one
	                      before it, 0..1; 0: 0.6. The narrowest spans some 3 pixels in a picture of 360 rows, and as
	                      large a part of larger ones; the widest about half of the picture */
	stilb_post_bloom_format bloom_format; /* of the device's programs */
	stilb_post_place place;
	stilb_post_dither dither; /* of pictures of 8 bits */
	bool exposure_adapts;     /* the exposure follows the light of frames; else there is no such row */
	/* Percentiles between which light counts, shares of the pixels that are counted, 0..1, low < high; both 0: 0.7 and
	 * 0.97. */
	float exposure_low, exposure_high;
	float exposure_speed;                       /* a, 1 / seconds, >= 0 and finite; 0: 2 */
	float exposure_rate;                        /* r, stops a second, >= 0 and finite; 0: 4 */
	float exposure_darkest, exposure_brightest; /* what it lies between, stops, -32..32, in order; both 0: -16 and 16 */
	float motion_blur; /* the share of a frame while the shutter is open, 0..1; 0: there is no such row. Films: .5 */
	float motion_blur_most;             /* of the picture's height, what the longest way is cut to, 0..1; 0: 0.1 */
	stilb_post_motion motion;           /* what is blurred by it */
	float motion_blur_far;              /* metres along the view, of FAR, >= 0 and finite; 0: 10 */
	stilb_post_aa aa;                   /* besides several samples a pixel, with which each goes */
	stilb_post_reflections reflections; /* OFF: there are no such rows */
	stilb_post_dof dof;                 /* OFF: there is no such row */
	float aperture;  /* radius of the lens, metres, >= 0; 0: everything is sharp, and there is no such row */
	float focus;     /* distance of the plane in focus along the view, metres, >= 0; with such a row > 0 */
	uint32_t blades; /* corners of the aperture, 3..16; 0: it is round */
} stilb_post_settings;

/* With defaults in place of zeros that stand for them. settings: valid. [any-thread] */
stilb_post_settings stilb_post_settings_filled(const stilb_post_settings *settings);

/* True if all numbers are finite and in their ranges. [any-thread] */
bool stilb_post_settings_are_valid(const stilb_post_settings *settings);

typedef struct stilb_post stilb_post;

/* Adds the chain to the renderer's frames, without effects. STILB_ERROR_ARGUMENT: the renderer has no room for more
 * features. STILB_ERROR_MEMORY. On failure *post is NULL. */
stilb_result stilb_post_create(stilb_render *render, stilb_post **post);
/* Accepts NULL. */
void stilb_post_destroy(stilb_post *post);

/* From the next replay on. settings: valid. Programs that a setting needs for the first time are compiled by that
 * replay. */
void stilb_post_set(stilb_post *post, const stilb_post_settings *settings);

/* Lets the threads of this pool help with what the CPU computes. Its owner is the main thread; it must live until
 * another one is set, or NULL for none, as before the first call. */
void stilb_post_set_pool(stilb_post *post, stilb_job_pool *pool);

/* By how much a frame of this number moves the picture, pixels, -0.5..0.5: 64 places that repeat, of which the first 4,
 * the first 16 and all are spread evenly. Source: Sobol, "On the distribution of points in a cube and the approximate
 * evaluation of integrals" (1967), dimensions 1 and 2. [any-thread] */
void stilb_post_jitter(uint64_t frame, float pixels[2]);

/* Whether frames from the next one on show what was paused: as long as they do, motion blur takes the velocities of the
 * frame before. */
void stilb_post_hold(stilb_post *post, bool held);

/* The height of the picture of which frames from the next one on show a part, pixels; 0, as at first: they show all of
 * it. By it effects measure what is a share of the picture. Such frames have no history of those before, blur nothing
 * by its movement, and count nothing for the exposure. */
void stilb_post_set_whole(stilb_post *post, uint32_t height);

/* What the next replay's view into the main images sees: read are view_projection, jitter, last, camera_position,
 * exposure, show. At first a view of zeros, by which nothing is occluded or blurred. */
void stilb_post_see(stilb_post *post, const stilb_render_view *view);

/* ---- grade ------------------------------------------------------------------------------------------------------- */

typedef struct stilb_post_area {
	float low[3], high[3];         /* the box, metres in the world; low < high */
	float blend;                   /* metres, >= 0 and finite, that are half inside and half outside; 0: a step */
	float exposure;                /* stops that it adds, -32..32 */
	const stilb_post_table *table; /* NULL: that of no area */
} stilb_post_area;

#define STILB_POST_MAX_AREAS 64u

/* Takes copies of the table outside of areas, NULL: colours are as they are, and of the areas, 0..STILB_POST_MAX_AREAS.
 * STILB_ERROR_MEMORY: what was set before stays. */
stilb_result stilb_post_set_grade(stilb_post *post, const stilb_post_table *table, const stilb_post_area *areas,
                                  uint32_t count);

/* Where the camera stands in the next frame: once a frame, before views get stilb_post_grade and stilb_post_exposure.
 * Does nothing while weights stay what they are. Tables of which several weigh are resampled to one of at most 33
 * entries a side. STILB_ERROR_ARGUMENT: the device has no such large images; STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE_LOST; the grade then stays. */
stilb_result stilb_post_stand(stilb_post *post, const float position[3]);

/* For stilb_render_view.grade, until the next stilb_post_stand; NULL: colours are as they are. */
const stilb_render_grade *stilb_post_grade(const stilb_post *post);

/* ---- exposure that adapts ----------------------------------------------------------------------------------------
 * Once a frame, before its views are made: adapt, then, while it is blind, a frame that nobody sees and look; then
 * views get stilb_post_exposure. A program that does not look sees its first two frames at 0 stops. */

/* Takes what the frame before the last has counted, and goes towards it for so long: seconds since the call before, >=
 * 0 and finite. Waits for the device only if it has not finished that frame. The first counts, and those after
 * stilb_post_forget, count at once. Does nothing where settings do not ask for it. STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE_LOST; the exposure then stays. */
stilb_result stilb_post_adapt(stilb_post *post, float seconds);

/* The exposure so far, stops, and what areas add; without either 0. What the program's cameras say comes on top of
 * it. */
float stilb_post_exposure(const stilb_post *post);

/* True while settings ask for exposure and nothing has been counted since the start or stilb_post_forget. */
bool stilb_post_is_blind(const stilb_post *post);

/* Waits for the counts of the last replayed frame, and takes them at once. A frame that has none changes nothing, and
 * it is not blind any more. Errors as stilb_post_adapt. */
stilb_result stilb_post_look(stilb_post *post);

/* Another scene comes, or the camera is somewhere else: nothing of the frames before counts for the next one, and what
 * it counts of light is taken at once. */
void stilb_post_forget(stilb_post *post);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
