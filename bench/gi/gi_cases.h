/* The cases of the suite `gi`: X(NAME, TITLE, METRICS) with METRICS a list of bench_metric in bench_gi.c. */
#ifndef GI_CASES_H
#define GI_CASES_H

#define GI_CASES(X)                                                                                                    \
	X("build", "tree of 1,037,244 triangles: our workers' join, rtcCommitScene", build)                                \
	X("primary", "camera rays with G-buffer, rtcIntersect16 on the same rays", rate)                                   \
	X("path", "diffuse paths, Embree alone on the same rays", path)                                                    \
	X("sobol", "path tracing with Owen-scrambled Sobol points, with independent numbers", samples)                     \
	X("efficiency", "Cornell box, 64 samples: 1 / (mean square error x s), beside the baseline", efficiency)           \
	X("cache-time", "Cornell box by irradiance cache, one thread: until an RMSE of .0112", cache_time)                 \
	X("cache-0.25s", "indirect light in 0.25 s: irradiance cache, path tracer", equal_time)                            \
	X("cache-1s", "indirect light in 1 s: irradiance cache, path tracer", equal_time)                                  \
	X("hessian", "indirect light from as many records: occlusion Hessian, split sphere plain, bounded", hessian)       \
	X("workers", "path tracing with one thread, with two", workers)                                                    \
	X("pathtracer", "paths of depth 5 in Embree's own Cornell box, beside its example program", rate)

#endif
