/* shade_cases: the cases of the suite `shade`, each a BRDF whose evaluation is timed; included by stilb-bench and by
 * the program that it starts. */
#ifndef BENCH_SHADE_CASES_H
#define BENCH_SHADE_CASES_H

/* X(name, title, symbol, divisions, square roots, powers): the numbers of operations that every implementation of the
 * formula needs. */
#define SHADE_BENCH_CASES(X)                                                                                           \
	X("wrapped", "energy-conserving wrapped diffuse", wrapped, 1, 0, 0)                                                \
	X("phong-modified", "modified Phong", phong_modified, 0, 0, 1)                                                     \
	X("blinn-phong-modified", "modified Blinn-Phong", blinn_phong_modified, 1, 1, 2)                                   \
	X("minimalist", "minimalist Cook-Torrance", minimalist, 1, 1, 1)                                                   \
	X("ggx", "GGX, Smith's masking term fused with the denominator, Schlick's Fresnel term", ggx, 1, 2, 0)             \
	X("cook-torrance", "Beckmann, masking and Fresnel terms of Cook and Torrance", cook_torrance, 4, 3, 1)

#endif
