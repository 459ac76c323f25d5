/* Convolution by spherical harmonics: from rings to harmonics, and from harmonics to the rings of each mip.
 *
 * The harmonic of degree l and order m is P(l, m)(cos theta) exp(i m phi), P being the associated Legendre functions
 * normalised to 1 over the sphere. In the longitude that is a Fourier transform; in theta it is a sum over the rings
 * for each l and m, with P by its recurrence in l:
 *   P(m, m) = sqrt((2 m + 1) / (4 pi) (1 3 ... (2 m - 1)) / (2 4 ... 2 m)) sin^m(theta)
 *   P(l, m) = a (cos(theta) P(l - 1, m) - b P(l - 2, m)),  a(l)^2 = (4 l^2 - 1) / (l^2 - m^2), b(l) = 1 / a(l - 1)
 * which is stable. P(l, m) of the mirrored ring is (-1)^(l + m) P(l, m), so both are summed with one P.
 * Source: Press et al., "Numerical Recipes", 3rd ed. (2007), 6.7. */
#include "numeric/numeric_prefilter_internal.h"

#include "shading/shade_specular.h"

#include <stdlib.h>

/* ---- Fourier transform ------------------------------------------------------------------------------------------- */

void numeric_prefilter_make_turns(stilb_numeric_prefilter *work)
{
	for (uint32_t k = 0; k < work->turn_columns / 2; k++) {
		double angle = 2.0 * M_PI * k / work->turn_columns;
		work->turns[k] = (prefilter_turn){(float)cos(angle), (float)-sin(angle)};
	}
}

/* Puts number k to the place of k with its bits in reversed order. */
static void reverse(uint32_t columns, prefilter_wave *waves)
{
	for (uint32_t i = 1, j = 0; i < columns; i++) {
		uint32_t bit = columns >> 1;
		for (; (j & bit) != 0; bit >>= 1)
			j ^= bit;
		j ^= bit;
		if (i < j) {
			prefilter_wave kept = waves[i];
			waves[i] = waves[j];
			waves[j] = kept;
		}
	}
}

/* In place: waves[k] becomes the sum over j of waves[j] exp(-2 pi i j k / columns), of exp(+...) if inverse. Source:
 * Cooley and Tukey, "An algorithm for the machine calculation of complex Fourier series" (1965). */
void numeric_prefilter_transform(const stilb_numeric_prefilter *work, uint32_t columns, prefilter_wave *waves,
                                 bool inverse)
{
	STILB_ASSERT(columns >= 2 && (columns & (columns - 1)) == 0 && columns <= work->turn_columns);
	float sign = inverse ? -1.0f : 1.0f;
	reverse(columns, waves);
	for (uint32_t half = 1; half < columns; half *= 2) {
		uint32_t stride = work->turn_columns / (2 * half);
		for (uint32_t begin = 0; begin < columns; begin += 2 * half)
			for (uint32_t k = 0; k < half; k++) {
				prefilter_turn turn = work->turns[(size_t)k * stride];
				prefilter_wave *low = &waves[begin + k], *high = low + half;
				float im = turn.im * sign;
				stilb_vec4 re_part = high->re * turn.re - high->im * im, im_part = high->re * im + high->im * turn.re;
				*high = (prefilter_wave){low->re - re_part, low->im - im_part};
				*low = (prefilter_wave){low->re + re_part, low->im + im_part};
			}
	}
}

/* ---- the lobe ---------------------------------------------------------------------------------------------------- */

#define SHARE_STEPS 16 /* of theta for each degree, at least */

/* D(h) G1(l), h half as far from n as l: what GGX seen along its normal reflects, over some constant. */
static double lobe(double theta, double alpha)
{
	double alpha2 = alpha * alpha, sine = sin(0.5 * theta), cosine = cos(theta);
	double bracket = alpha2 + sine * sine * (1.0 - alpha2);
	double shadow = 2.0 * cosine / (cosine + sqrt(alpha2 + (1.0 - alpha2) * cosine * cosine));
	return alpha2 / (bracket * bracket) * shadow;
}

/* The lobe's Legendre coefficients over that of degree 0, by Simpson's rule in theta with Bonnet's recurrence. Source:
 * Ramamoorthi and Hanrahan (2002), of radially symmetric BRDFs. */
void numeric_prefilter_make_share(float roughness, uint32_t degree, float *share)
{
	STILB_ASSERT(roughness > 0.0f && roughness <= 1.0f && degree <= PREFILTER_DEGREE_MAX);
	double alpha = (double)shade_alpha_from_roughness(roughness), sums[PREFILTER_DEGREE_MAX + 1] = {0};
	uint32_t steps = SHARE_STEPS * (degree + 16);
	for (uint32_t i = 1; i < steps; i++) { /* the integrand is 0 at both ends */
		double theta = 0.5 * M_PI * i / steps, x = cos(theta), last = 0.0, now = 1.0;
		double value = lobe(theta, alpha) * sin(theta) * (i % 2 == 1 ? 4.0 : 2.0);
		for (uint32_t l = 0; l <= degree; l++) {
			sums[l] += value * now;
			double next = ((2 * l + 1) * x * now - l * last) / (l + 1);
			last = now;
			now = next;
		}
	}
	for (uint32_t l = 0; l <= degree; l++)
		share[l] = (float)(sums[l] / sums[0]);
}

/* ---- Legendre functions ------------------------------------------------------------------------------------------ */

typedef double legendre_lanes __attribute__((vector_size(PREFILTER_BLOCK * sizeof(double))));

/* The recurrence's a and b of one order, by l - m. */
typedef struct legendre_steps {
	double first;
	double a[PREFILTER_DEGREE_MAX + 2], b[PREFILTER_DEGREE_MAX + 2];
} legendre_steps;

/* P(l - 1, m) and P(l, m) on four rings. */
typedef struct legendre {
	legendre_lanes cosine, last, now;
} legendre;

static void legendre_prepare(uint32_t degree, uint32_t m, legendre_steps *steps)
{
	double square = (2.0 * m + 1.0) / (4.0 * M_PI);
	for (uint32_t k = 1; k <= m; k++)
		square *= (2.0 * k - 1.0) / (2.0 * k);
	steps->first = sqrt(square);
	double b = 0.0;
	for (uint32_t l = m + 1; l <= degree; l++) {
		double a = sqrt((4.0 * l * l - 1.0) / ((double)l * l - (double)m * m));
		steps->a[l - m] = a;
		steps->b[l - m] = b;
		b = 1.0 / a;
	}
}

static void legendre_begin(const legendre_steps *steps, const prefilter_grid *grid, uint32_t pair, uint32_t m,
                           legendre *p)
{
	for (uint32_t q = 0; q < PREFILTER_BLOCK; q++) {
		double theta = prefilter_angle(grid, pair + q);
		p->cosine[q] = cos(theta);
		p->last[q] = 0.0;
		p->now[q] = steps->first * pow(sin(theta), m);
	}
}

static inline void legendre_step(const legendre_steps *steps, uint32_t distance, legendre *p)
{
	legendre_lanes next = (p->cosine * p->now - p->last * steps->b[distance]) * steps->a[distance];
	p->last = p->now;
	p->now = next;
}

/* ---- from rings to harmonics ------------------------------------------------------------------------------------- */

/* Sums and differences of the northern and the southern ring: what even l + m see, and what odd ones do. */
typedef struct ring_sums {
	prefilter_wave part[2];
} ring_sums;

/* Of order m, from the transform of north + i south: north = (Z(m) + Z*(-m)) / 2, south = (Z(m) - Z*(-m)) / 2 i. */
static ring_sums ring_take_apart(const prefilter_wave *row, uint32_t columns, uint32_t m)
{
	prefilter_wave z = row[m], y = row[(columns - m) & (columns - 1)];
	prefilter_wave north = {0.5f * (z.re + y.re), 0.5f * (z.im - y.im)};
	prefilter_wave south = {0.5f * (z.im + y.im), 0.5f * (y.re - z.re)};
	return (ring_sums){{{north.re + south.re, north.im + south.im}, {north.re - south.re, north.im - south.im}}};
}

void numeric_prefilter_analyse(stilb_numeric_prefilter *work, uint32_t m)
{
	const prefilter_grid *in = &work->in;
	prefilter_wave *sum = work->harmonics + prefilter_order_begin(in->degree, m), zero = {{0.0f}, {0.0f}};
	for (uint32_t l = m; l <= in->degree; l++)
		sum[l - m] = zero;
	legendre_steps steps;
	legendre_prepare(in->degree, m, &steps);
	for (uint32_t pair = 0; pair < in->pairs; pair += PREFILTER_BLOCK) {
		ring_sums sums[PREFILTER_BLOCK];
		for (uint32_t q = 0; q < PREFILTER_BLOCK; q++)
			sums[q] = ring_take_apart(in->waves + (size_t)(pair + q) * in->columns, in->columns, m);
		legendre p;
		legendre_begin(&steps, in, pair, m, &p);
		for (uint32_t l = m;; l++) {
			prefilter_wave add = sum[l - m];
			for (uint32_t q = 0; q < PREFILTER_BLOCK; q++) {
				const prefilter_wave *of = &sums[q].part[(l - m) & 1];
				add.re += of->re * (float)p.now[q];
				add.im += of->im * (float)p.now[q];
			}
			sum[l - m] = add;
			if (l == in->degree)
				break;
			legendre_step(&steps, l + 1 - m, &p);
		}
	}
}

/* ---- from harmonics to the rings of a mip ------------------------------------------------------------------------ */

/* The inverse of ring_take_apart. */
static void ring_put_together(ring_sums sums, uint32_t columns, uint32_t m, prefilter_wave *row)
{
	const prefilter_wave *even = &sums.part[0], *odd = &sums.part[1];
	prefilter_wave north = {even->re + odd->re, even->im + odd->im}, south = {even->re - odd->re, even->im - odd->im};
	row[(columns - m) & (columns - 1)] = (prefilter_wave){north.re + south.im, south.re - north.im};
	row[m] = (prefilter_wave){north.re - south.im, north.im + south.re};
}

void numeric_prefilter_synthesise(stilb_numeric_prefilter *work, uint32_t mip, uint32_t m)
{
	const prefilter_grid *out = &work->out[mip];
	const prefilter_wave *from = work->harmonics + prefilter_order_begin(work->in.degree, m);
	legendre_steps steps;
	legendre_prepare(out->degree, m, &steps);
	for (uint32_t pair = 0; pair < out->pairs; pair += PREFILTER_BLOCK) {
		ring_sums sums[PREFILTER_BLOCK] = {0};
		legendre p;
		legendre_begin(&steps, out, pair, m, &p);
		for (uint32_t l = m;; l++) {
			float share = work->share[mip][l];
			prefilter_wave add = {from[l - m].re * share, from[l - m].im * share};
			for (uint32_t q = 0; q < PREFILTER_BLOCK; q++) {
				prefilter_wave *to = &sums[q].part[(l - m) & 1];
				to->re += add.re * (float)p.now[q];
				to->im += add.im * (float)p.now[q];
			}
			if (l == out->degree)
				break;
			legendre_step(&steps, l + 1 - m, &p);
		}
		for (uint32_t q = 0; q < PREFILTER_BLOCK; q++)
			ring_put_together(sums[q], out->columns, m, out->waves + (size_t)(pair + q) * out->columns);
	}
}

void numeric_prefilter_finish_pair(stilb_numeric_prefilter *work, uint32_t mip, uint32_t pair)
{
	const prefilter_grid *out = &work->out[mip];
	prefilter_wave *row = out->waves + (size_t)pair * out->columns, zero = {{0.0f}, {0.0f}};
	for (uint32_t k = out->degree + 1; k + out->degree < out->columns; k++)
		row[k] = zero;
	numeric_prefilter_transform(work, out->columns, row, true);
}
