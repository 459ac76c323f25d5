/*
 * numeric_vmf: fits the von Mises-Fisher distribution to directions: of light samples, photons, or normals of a patch.
 *
 *   shade_vmf lobe;
 *   if (stilb_numeric_vmf_fit(normals, NULL, normal_count, &lobe) != STILB_OK)
 *       stilb_log("%s", stilb_error_message());
 *
 * Precision. Sums are double, so that a bundle of directions a millionth of a radian wide keeps its width. The formulas
 *            are in shading/shade_vmf.h.
 * Threads.   Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_VMF_H
#define STILB_NUMERIC_VMF_H

#include "base/base.h"
#include "shading/shade_vmf.h"

/* Fits by the mean direction, which is the maximum-likelihood fit. directions: [count], finite, of any length but 0;
 * count >= 1. weights: [count], finite and >= 0, or NULL for 1 each; only their ratios matter. If the directions cancel
 * out (|mean| below SHADE_VMF_MEAN_MIN) the fit is nearly uniform, 1 / sharpness about 3333, about the remaining mean
 * or +Z. Errors: STILB_ERROR_ARGUMENT, with the index of the first direction or weight that is refused: none given,
 * length 0, not finite, negative, all weights 0. Then fit is not written. [any-thread]
 * Source: Banerjee et al., "Clustering on the Unit Hypersphere using von Mises-Fisher Distributions" (2005), whose
 * approximation is refined by Newton's method. */
stilb_result stilb_numeric_vmf_fit(const stilb_vec3 *directions, const float *weights, size_t count, shade_vmf *fit);

#endif
