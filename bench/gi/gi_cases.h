/* The cases of the suite `gi`: X(NAME, TITLE, METRICS) with METRICS a list of bench_metric in bench_gi.c. */
#ifndef GI_CASES_H
#define GI_CASES_H

/* Scenes that are rendered beside the plain path tracer, and in the cases GI_DENOISE NAME denoised: X(NAME, TITLE). */
#define GI_DENOISE "denoise-"
#define GI_ROWS(X)                                                                                                     \
	X("cornell", "the Cornell box")                                                                                    \
	X("open-sky", "bumpy spheres under an even sky and a small sun")                                                   \
	X("panorama", "balls in a dim panorama with a bright window")                                                      \
	X("mixed", "the same with a sun, a lamp and a point")                                                              \
	X("door", "a room that is lit through a door")                                                                     \
	X("metals", "metals from smooth to rough, two lamps, a dim sky")                                                   \
	X("lights", "1,000 emitting triangles and 1,000 points")                                                           \
	X("foliage", "leaves cut out of a texture, sun and sky")

#define GI_CASES(X)                                                                                                    \
	X("build-100k", "building the BVH of 97,212 triangles: with Stilb's workers, and with Embree's threads", build)    \
	X("build", "the same of 1,037,244 triangles", build)                                                               \
	X("build-10m", "the same of 9,980,940 triangles", build)                                                           \
	X("move", "a model of 1,037,244 triangles and 1,000 of 10,000 small ones moved: a scene made anew, and an update", \
	  move)                                                                                                            \
	X("rays-cornell", "rays of the Cornell box, beside Embree alone on the same rays", rays)                           \
	X("rays-open-sky", "the same of bumpy spheres under a sky and a sun", rays)                                        \
	X("rays-foliage", "the same of leaves cut out of a texture", rays)                                                 \
	X("rays-million", "the same of 1,037,244 triangles", rays)                                                         \
	X("rays-door", "the same of a room lit through a door", rays)                                                      \
	X("rays-metals", "the same of metals, two lamps, a dim sky", rays)                                                 \
	X("sobol", "path tracing with Owen-scrambled Sobol points, beside independent random numbers", samples)            \
	X("choice", "which of 1,000 triangles and 1,000 points to ask: the light tree, any, the best by brute force",      \
	  choice)                                                                                                          \
	X("cache-time", "Cornell box by irradiance cache on one thread: time for an RMSE of 0.0112", cache_time)           \
	X("cache-0.25s", "indirect light in 0.25 s: error of irradiance cache and path tracer", equal_time)                \
	X("cache-1s", "indirect light in 1 s: error of irradiance cache and path tracer", equal_time)                      \
	X("hessian", "indirect light by equally many cache records: occlusion Hessian, plain and bounded split sphere",    \
	  hessian)                                                                                                         \
	X("workers", "path tracing with one thread and with two", workers)                                                 \
	X("pathtracer", "paths of depth 5 in Embree's Cornell box, beside Embree's example program; CPU time", rate)

#endif
