/*
 * shadow_truth: what the tests of live shadows are held against: for each pixel of a picture whether the surface in its
 * middle sees a light, by rays, where the edges of shadows are, and whether a live shadow is wrong near such edges
 * alone.
 *
 *   shadow_asked asked = {&scene->camera, 320, 180, &scene->lights[0], false};
 *   shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
 *   shadow_edges edges = shadow_edges_find(&truth, 0.0f);
 *   for each pixel: allowed[pixel] = texel[pixel] + filter[pixel];       metres on the surface
 *   shadow_compared compared = shadow_compare(gi, &asked, &truth, &edges, live, 0.5f, allowed);
 *   assert_int_equal(compared.outside, 0);
 *
 * Results depend on the arguments alone, not on the number of workers. Failures of memory end the test.
 */
#ifndef SHADOW_TRUTH_H
#define SHADOW_TRUTH_H

#include "gi/gi_scene.h"

/* What is asked for. */
typedef struct shadow_asked {
	const stilb_scene_camera *camera;
	uint32_t width, height;         /* pixels, 1..4096 */
	const stilb_scene_light *light; /* of any kind */
	/* A light with a size is asked all over, by 512 rays or more, until the standard error is at most 1/255; where
	 * 32,768 are not enough, as at the horizon of a lamp that hardly rises, nothing is known. Else, and where it has
	 * none, one ray goes to its centre. */
	bool soft;
} shadow_asked;

/* Rows from the top. */
typedef struct shadow_truth {
	uint32_t width, height;
	/* [height][width] The share of the light's irradiance that arrives, [0, 1]: 0 in full shadow. NaN: nothing is
	 * there, or no light would arrive if nothing were in between, as where the surface faces away, or it is not
	 * known. */
	float *visible;
	float (*position)[3]; /* of the surface in the pixel's middle, metres; where visible is no NaN */
	float (*normal)[3];   /* of its triangle, unit, on the camera's side */
	float eye[3];         /* the camera's place */
	float error;          /* the largest standard error of a pixel: 0 without soft */
} shadow_truth;

/* gi: of the scene that is asked for; may be read by other threads, too. pool: its calling thread's index is 0. */
shadow_truth shadow_truth_trace(const stilb_gi_scene *gi, const shadow_asked *asked, stilb_job_pool *pool);

void shadow_truth_finish(shadow_truth *truth);

/* Between two pixels, neighbours in a row or a column, one of which sees more of the light. */
typedef struct shadow_edge {
	uint32_t x, y;          /* the middle between them, in half pixels: pixel (x, y) is at 2 x, 2 y */
	float one[3], other[3]; /* their positions: the edge of the shadow is somewhere between */
} shadow_edge;

typedef struct shadow_edges {
	uint32_t count;
	shadow_edge *edges; /* [count] in the order of rows */
} shadow_edges;

/* All edges at which visible differs by more than step. There is none where one of both is NaN, nor where something
 * stands before the other: the shadow may end anywhere behind it. */
shadow_edges shadow_edges_find(const shadow_truth *truth, float step);

void shadow_edges_finish(shadow_edges *edges);

/* distance: [height][width] from each pixel's middle to the nearest edge, pixels, exact; INFINITY: there is none. */
void shadow_edges_pixels(const shadow_edges *edges, uint32_t width, uint32_t height, float *distance);

/* From a point to the nearest edge, metres: to the straight line between its two positions. INFINITY: there is none. */
float shadow_edges_distance(const shadow_edges *edges, const float at[3]);

typedef struct shadow_compared {
	uint32_t compared; /* pixels of which visible is no NaN */
	uint32_t wrong;    /* of these the live ones that differ by more than the tolerance */
	uint32_t hidden;   /* of these, those that are near an edge that the picture does not show, behind something else */
	uint32_t touching; /* of the others, lit ones that something nearer than allowed, on the way to the light, hides */
	uint32_t outside;  /* of the others, those that are farther from every edge than allowed, */
	uint32_t acne;     /* and of these, those that are darker than the traced ones */
	float worst;       /* the largest distance of one of these from an edge as a multiple of what is allowed; 0: none */
	uint32_t worst_x, worst_y; /* where that is */
} shadow_compared;

/* Compares a live picture, [height][width], with a traced one. tolerance: how far a pixel may differ without being
 * wrong. allowed: [height][width] how far an edge may be from a wrong pixel, metres, > 0. gi and asked: those of truth;
 * edges that the picture does not show are looked for by hard shadow rays within that distance, in the surface's plane,
 * and so is what a pixel touches; gi NULL: they are not. */
shadow_compared shadow_compare(const stilb_gi_scene *gi, const shadow_asked *asked, const shadow_truth *truth,
                               const shadow_edges *edges, const float *live, float tolerance, const float *allowed);

#endif
