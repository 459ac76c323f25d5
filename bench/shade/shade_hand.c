/* The reflectance formulas of the suite `shade`, fused by hand: plain floats, nothing computed twice, the half vector
 * h = l + v never normalized. n: normal; l, v: directions to the light and to the viewer, of length 1. */
#include "bench/shade/shade_run.h"

#include <math.h>

#define PI 3.14159265358979323846f

/* Dot products of the three directions, and 1 / |l + v|. */
typedef struct dots {
	float n_l, n_v, n_h, v_h, inverse_h;
} dots;

static inline float dot3(stilb_vec4 a, stilb_vec4 b)
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* |l + v|^2 = 2 + 2 l.v; n.h = (n.l + n.v) / |l + v|; v.h = |l + v| / 2. */
static inline dots dots_of(const shade_run_point *p)
{
	float n_l = dot3(p->n, p->l), n_v = dot3(p->n, p->v), h2 = 2.0f + 2.0f * dot3(p->l, p->v);
	float inverse = 1.0f / sqrtf(h2);
	return (dots){n_l, n_v, (n_l + n_v) * inverse, 0.5f * h2 * inverse, inverse};
}

/* sin^2 of the angle between n and h, from their cross product: where n.h is close to 1, as in a narrow highlight,
 * 1 - (n.h)^2 would lose most of its digits. */
static inline float sine2(const shade_run_point *p, float inverse_h)
{
	stilb_vec4 h = p->l + p->v;
	float x = p->n[1] * h[2] - p->n[2] * h[1];
	float y = p->n[2] * h[0] - p->n[0] * h[2];
	float z = p->n[0] * h[1] - p->n[1] * h[0];
	return (x * x + y * y + z * z) * (inverse_h * inverse_h);
}

static inline float alpha_of(const shade_run_point *p)
{
	float alpha = p->roughness * p->roughness;
	return alpha > SHADE_RUN_ALPHA_MIN ? alpha : SHADE_RUN_ALPHA_MIN;
}

static inline float exponent_of(const shade_run_point *p)
{
	float alpha = alpha_of(p);
	return 2.0f / (alpha * alpha) - 2.0f;
}

static inline stilb_vec4 wrapped(const shade_run_point *p)
{
	float factor = 1.0f / (PI * (1.0f + SHADE_RUN_WRAP) * (1.0f + SHADE_RUN_WRAP));
	return p->f0 * (fmaxf(dot3(p->n, p->l) + SHADE_RUN_WRAP, 0.0f) * factor);
}

static inline stilb_vec4 phong_modified(const shade_run_point *p)
{
	float n = 0.25f * exponent_of(p), n_l = dot3(p->n, p->l);
	float r_v = 2.0f * n_l * dot3(p->n, p->v) - dot3(p->l, p->v);
	return p->f0 * ((n + 2.0f) * (0.5f / PI) * powf(fmaxf(r_v, 0.0f), n) * n_l);
}

static inline stilb_vec4 blinn_phong_modified(const shade_run_point *p)
{
	dots d = dots_of(p);
	float n = exponent_of(p);
	float factor = (n + 2.0f) * (n + 4.0f) / (8.0f * PI * (exp2f(-0.5f * n) + n));
	return p->f0 * (factor * powf(d.n_h, n) * d.n_l);
}

static inline stilb_vec4 minimalist(const shade_run_point *p)
{
	dots d = dots_of(p);
	float n = exponent_of(p);
	return p->f0 * ((n + 1.0f) * powf(d.n_h, n) * d.n_l / (8.0f * PI * d.v_h * d.v_h * d.v_h));
}

/* The GGX BRDF times n.l, F D V n.l, with a single division: Schlick's Fresnel term F, Smith's visibility term V, and
 * the distribution D = a2 / (pi (n.h^2 a2 + s2)^2) with a2 = alpha^2 and s2 = sin^2 of the angle between n and h. */
static inline stilb_vec4 ggx(const shade_run_point *p)
{
	dots d = dots_of(p);
	float a = alpha_of(p), a2 = a * a;
	float t = d.n_h * d.n_h * a2 + sine2(p, d.inverse_h);
	float vl = d.n_l + sqrtf(a2 + (1.0f - a2) * d.n_l * d.n_l);
	float vv = d.n_v + sqrtf(a2 + (1.0f - a2) * d.n_v * d.n_v);
	float dv = a2 * d.n_l / (PI * t * t * vl * vv);
	float x = 1.0f - d.v_h, x2 = x * x, x5 = x2 * x2 * x;
	return (p->f0 + (1.0f - p->f0) * x5) * dv;
}

static inline stilb_vec4 cook_torrance(const shade_run_point *p)
{
	dots d = dots_of(p);
	float a = alpha_of(p), inverse_a2 = 1.0f / (a * a), inverse_c2 = 1.0f / (d.n_h * d.n_h);
	float distribution = expf(-sine2(p, d.inverse_h) * inverse_c2 * inverse_a2) * inverse_a2 * inverse_c2 * inverse_c2;
	float g = fminf(1.0f, 2.0f * d.n_h * fminf(d.n_l, d.n_v) / d.v_h);
	float scale = distribution * g / (4.0f * PI * d.n_v);
	stilb_vec4 result;
	for (int c = 0; c < 3; c++) {
		float root = sqrtf(p->f0[c]), eta = (1.0f + root) / (1.0f - root);
		float k = sqrtf(eta * eta + d.v_h * d.v_h - 1.0f), minus = k - d.v_h, plus = k + d.v_h;
		float s = (plus * d.v_h - 1.0f) / (minus * d.v_h + 1.0f), q = minus / plus;
		result[c] = 0.5f * q * q * (1.0f + s * s) * scale;
	}
	result[3] = 0.0f;
	return result;
}

#define SHADE_HAND_KERNEL(name, title, symbol, divisions, roots, powers)                                               \
	void shade_hand_##symbol(const shade_run_inputs *inputs, shade_run_results *results)                               \
	{                                                                                                                  \
		for (int i = 0; i < SHADE_RUN_COUNT; i++)                                                                      \
			results->points[i] = symbol(&inputs->points[i]);                                                           \
	}
SHADE_BENCH_CASES(SHADE_HAND_KERNEL)
