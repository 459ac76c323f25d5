/*
 * gi_denoise: filters the noise out of a film whose pixels keep their samples' halves (gi_film_half).
 *
 * Nonlinearly weighted first-order regression. Around each pixel p, the radiance of one half of the samples is
 * fitted by a plane over what has little noise in the pixels q around it: their place, and albedo, normal and nearness
 * (1 / depth) of their first hits. So edges of textures and shapes stay, where the fitted function has them. In the
 * fit a pixel weighs the more, the more alike the neighbourhoods of p and q are in the other half (non-local means),
 * divided by the albedo so that textures do not hide it:
 *
 *   d(p, q) = mean over 3 x 3 pixels and three channels of ((u_p - u_q)^2 - (V_p + V_q)) / (k^2 (V_p + V_q)),
 *   w(p, q) = (1 - max(d, 0) / 8)^8, or 0 where d >= 8: about exp(-d)
 *
 * with u the other half's means and V their variances. A pixel is the mean, by the same weights, of what the fits
 * around it say of it. As a half chooses the weights of the other one alone, these do not depend on the noise that
 * they average.
 *
 * Strength. The other half is also the judge: in a square of 9 x 9 pixels, the share s of the way from the input a of
 * a half to the filtered f that comes nearest to the other half b is sum((b - a)(f - a)) / sum((f - a)^2), at least 0
 * and at most 1. The mean of both halves has half the variance of a, for which the best share is s / (2 - s). So where
 * the filter does harm it is left out.
 *
 * Variance. Samples that are spread evenly (Sobol points) have less of it than their spread says. The latter is
 * therefore scaled by what the difference of the halves says of it in the square of 5 x 5 pixels around.
 *
 * Kept as they are: pixels of which no sample hits anything, whose halves are not both there, or beyond 1e15.
 *
 * Sources: Buades, Coll, Morel, "A review of image denoising algorithms" (2005): non-local means; Rousselle, Knaus,
 * Zwicker, "Adaptive rendering with non-local means filtering" (2012): two halves, the distance, the scaled variance;
 * Moon, Carr, Yoon, "Adaptive rendering based on weighted local regression" (2014) and Bitterli et al., "Nonlinearly
 * weighted first-order regression for denoising Monte Carlo renderings" (2016): the fit, and the mean of its results.
 */
#ifndef GI_DENOISE_H
#define GI_DENOISE_H

#include "gi/film/gi_film.h"
#include "jobs/job.h"

/* Makes film->denoised of the film's sums and planes, which have no writer meanwhile; a film with halves. caller: index
 * in the pool of the calling thread, or STILB_JOB_OUTSIDE. STILB_ERROR_MEMORY: it is NULL. [any-thread] */
stilb_result gi_denoise(gi_film *film, stilb_job_pool *pool, uint32_t caller);

#endif
