/*
 * numeric_vmf: the von Mises-Fisher distribution of many directions: light samples, photons, normals of a patch.
 *
 * Sums are double, so that a bundle of directions a millionth of a radian wide keeps its width; the formulas are
 * shading/shade_vmf.h's.
 * Threads.  [any-thread].
 */
#ifndef STILB_NUMERIC_VMF_H
#define STILB_NUMERIC_VMF_H

#include "base/base.h"
#include "shading/shade_vmf.h"

/* Fits by the mean direction, which is the maximum-likelihood fit. directions: count of them, at least 1, of any length
 * but 0. weights: one >= 0 for each, or NULL for 1 each; only their ratios matter. Directions that cancel out (|mean|
 * below SHADE_VMF_MEAN_MIN) give an even distribution, 1 / sharpness about 3333, about the axis that is left, or +Z.
 * STILB_ERROR_ARGUMENT, with the first that is wrong: no directions, one of length 0 or not finite, a weight below 0 or
 * not finite, all weights 0; then fit stays as it was. [any-thread]
 * Source: Banerjee et al., "Clustering on the Unit Hypersphere using von Mises-Fisher Distributions" (2005), its
 * approximation refined by Newton's method. */
stilb_result stilb_numeric_vmf_fit(const stilb_vec3 *directions, const float *weights, size_t count, shade_vmf *fit);

#endif
