#include "numeric/numeric_vmf.h"

#include <math.h>

/* Weighted sum of the unit directions, and of the weights. */
typedef struct direction_sum {
	double v[3], weight;
} direction_sum;

static double size_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static stilb_result add(direction_sum *sum, stilb_vec3 direction, float weight, size_t index)
{
	double d[3] = {(double)direction[0], (double)direction[1], (double)direction[2]};
	double size = size_of(d);
	if (!(size > 0.0 && isfinite(size)))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot fit directions: number %zu is (%g, %g, %g); a direction is finite and not 0", index,
		                  d[0], d[1], d[2]);
	if (!(weight >= 0.0f && isfinite(weight)))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot fit directions: weight %zu is %g; weights are finite and not negative", index,
		                  (double)weight);
	for (int k = 0; k < 3; k++)
		sum->v[k] += (double)weight * d[k] / size;
	sum->weight += (double)weight;
	return STILB_OK;
}

stilb_result stilb_numeric_vmf_fit(const stilb_vec3 *directions, const float *weights, size_t count, shade_vmf *fit)
{
	STILB_ASSERT(fit);
	STILB_ASSERT(directions || count == 0);
	direction_sum sum = {.weight = 0.0};
	for (size_t i = 0; i < count; i++) {
		stilb_result added = add(&sum, directions[i], weights ? weights[i] : 1.0f, i);
		if (added != STILB_OK)
			return added;
	}
	if (!(sum.weight > 0.0))
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot fit directions: %s",
		                  count ? "all weights are 0; at least one must count" : "there are none");
	double size = size_of(sum.v);
	shade_mean_direction mean = {.axis = {0.0f, 0.0f, 1.0f}, .variance = (float)fmax(1.0 - size / sum.weight, 0.0)};
	if (size > 0.0)
		mean.axis = stilb_vec3_make((float)(sum.v[0] / size), (float)(sum.v[1] / size), (float)(sum.v[2] / size));
	*fit = shade_vmf_from_mean(mean);
	return STILB_OK;
}
