/*
 * numeric_dfg: the table of what GGX reflects of a white environment, for shading/shade_environment.h.
 *
 * Values.   (a, b): with Schlick's Fresnel term the lobe reflects f0 a + b. a + b is its albedo. Its D and V are those
 *           of shade_dv_ggx. Light that facets hand on to others is not in it: shade_energy_compensation adds it.
 * Method.   Quadrature over half vectors as in numeric_albedo.h, in double. Error below 1e-5.
 * Table.    [row][column], by shade_dfg_from_place: its columns are no equal steps of n.v. Interpolated between four
 *           texels a table of 64 x 64 is within 1e-3 of quadrature for every n.v and roughness, one of 32 x 32 within
 *           4e-3 (docs/shading.md). Values are in [0, 1]: 16-bit integers or halves hold them.
 * Threads.  Pure functions: [any-thread]; rows of a table may be made by several threads at the same time.
 */
#ifndef STILB_NUMERIC_DFG_H
#define STILB_NUMERIC_DFG_H

#include <stdint.h>

#define STILB_NUMERIC_DFG_SIDE 64u /* of a table whose error is below 1e-3 */

typedef struct stilb_numeric_dfg {
	double a, b;
} stilb_numeric_dfg;

/* For n.v and perceptual roughness in [0, 1]. Source: Karis, "Real Shading in Unreal Engine 4" (2013). */
stilb_numeric_dfg stilb_numeric_dfg_of(double n_dot_v, double roughness);

/* Rows begin to end of a table of side x side texels, side >= 2; table: [side][side][2]. */
void stilb_numeric_dfg_rows(float *table, uint32_t side, uint32_t begin, uint32_t end);

#endif
