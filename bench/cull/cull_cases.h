/*
 * cull_cases: the cases (scenes and views) of the suite `cull`, which times finding the models that a camera sees.
 * Included by stilb-bench and by the program that runs them.
 *
 * Scene: bounding spheres of 0.5 to 2 m radius, evenly distributed over a cube, one for each 4 m x 4 m x 4 m. View: 60
 * degrees high, 16:9, oblique to the axes, turning by half a degree a frame and back again. The far plane is set so
 * that exactly the share of models that the case names is visible.
 */
#ifndef CULL_CASES_H
#define CULL_CASES_H

#include <stdbool.h>
#include <stdint.h>

typedef struct cull_case {
	const char *name;
	uint32_t models;
	double share; /* of the models that is visible, 0..1 */
	double back;  /* the camera's distance from the cube's centre, in units of half its side */
	bool moves;   /* a tenth of the models moves in each frame; updating the octree is timed together with culling */
} cull_case;

/* X(name, title, fields of cull_case from models on) */
#define CULL_SHARES(X, NAME, TITLE, MODELS)                                                                            \
	X(NAME "-1", TITLE " models, 1 % visible", MODELS, 0.01, 0.0, false)                                               \
	X(NAME "-10", TITLE " models, 10 % visible", MODELS, 0.10, 0.5, false)                                             \
	X(NAME "-50", TITLE " models, 50 % visible", MODELS, 0.50, 2.0, false)                                             \
	X(NAME "-100", TITLE " models, all visible", MODELS, 1.00, 4.5, false)
#define CULL_CASES(X)                                                                                                  \
	CULL_SHARES(X, "10k", "10,000", 10000)                                                                             \
	CULL_SHARES(X, "100k", "100,000", 100000)                                                                          \
	CULL_SHARES(X, "1M", "1,000,000", 1000000)                                                                         \
	X("10k-move", "10,000 models, 10 % visible, a tenth of all moves", 10000, 0.10, 0.5, true)                         \
	X("100k-move", "100,000 models, 10 % visible, a tenth of all moves", 100000, 0.10, 0.5, true)                      \
	X("1M-move", "1,000,000 models, 10 % visible, a tenth of all moves", 1000000, 0.10, 0.5, true)

#endif
