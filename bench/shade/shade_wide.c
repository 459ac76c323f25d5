/* The suite `shade`: the functions of engine/shading on eight points at a time. The functions take plain floats, so the
 * compiler vectorizes a loop over points to eight lanes, with glibc's eight-wide exp and log. Built for AVX2
 * (bench/CMakeLists.txt); the program skips it on CPUs without. */
#include "bench/shade/shade_run.h"

#if defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
/* glibc has eight-wide versions of these, which <math.h> declares only under -ffast-math. */
__attribute__((simd("notinbranch"))) float expf(float);
__attribute__((simd("notinbranch"))) float logf(float);
__attribute__((simd("notinbranch"))) float exp2f(float);
#endif

#include "shading/shade_brdf.h"

/* Tells the compiler that iterations are independent: the arrays do not overlap. */
#ifdef __clang__
#define LANES _Pragma("clang loop vectorize(assume_safety)")
#else
#define LANES _Pragma("GCC ivdep")
#endif

static inline float dot_at(const float a[3][SHADE_RUN_COUNT], const float b[3][SHADE_RUN_COUNT], int i)
{
	return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
}

/* Computes what shade_angles_of (engine/shading) returns for point i, from the arrays by component. */
static inline shade_angles angles_at(const shade_run_lanes *in, int i)
{
	float nx = in->n[0][i], ny = in->n[1][i], nz = in->n[2][i];
	float hx = in->l[0][i] + in->v[0][i], hy = in->l[1][i] + in->v[1][i], hz = in->l[2][i] + in->v[2][i];
	float tx = ny * hz - nz * hy, ty = nz * hx - nx * hz, tz = nx * hy - ny * hx;
	float half_length = 0.5f * sqrtf(hx * hx + hy * hy + hz * hz), inverse = 0.5f / half_length;
	float n_l = dot_at(in->n, in->l, i), n_v = dot_at(in->n, in->v, i);
	return (shade_angles){.n_dot_l = n_l,
	                      .n_dot_v = n_v,
	                      .n_dot_h = (n_l + n_v) * inverse,
	                      .v_dot_h = half_length,
	                      .sin2_h = (tx * tx + ty * ty + tz * tz) * (inverse * inverse)};
}

/* Computes what shade_sin2_r (engine/shading) returns for point i, from the arrays by component. */
static inline float sin2_r_at(const shade_run_lanes *in, int i)
{
	float twice = 2.0f * dot_at(in->n, in->v, i), apart2 = 0.0f;
	for (int c = 0; c < 3; c++) {
		float apart = in->l[c][i] + in->v[c][i] - in->n[c][i] * twice;
		apart2 += apart * apart;
	}
	return apart2 < 2.0f ? apart2 * (1.0f - 0.25f * apart2) : 1.0f;
}

static inline float exponent_at(const shade_run_lanes *in, int i)
{
	return shade_exponent_from_alpha(shade_alpha_from_roughness(in->roughness[i]));
}

/* A kernel whose result is F0 times SCALE in each channel; SCALE is an expression of the point's index i. */
#define SCALED_KERNEL(symbol, SCALE)                                                                                   \
	void shade_wide_##symbol(const shade_run_inputs *inputs, shade_run_results *results)                               \
	{                                                                                                                  \
		const shade_run_lanes *restrict in = &inputs->lanes;                                                           \
		float(*restrict out)[SHADE_RUN_COUNT] = results->lanes;                                                        \
		LANES                                                                                                          \
		for (int i = 0; i < SHADE_RUN_COUNT; i++) {                                                                    \
			float scale = (SCALE);                                                                                     \
			out[0][i] = in->f0[0][i] * scale;                                                                          \
			out[1][i] = in->f0[1][i] * scale;                                                                          \
			out[2][i] = in->f0[2][i] * scale;                                                                          \
		}                                                                                                              \
	}

static inline float blinn_phong_modified_at(const shade_run_lanes *in, int i)
{
	shade_angles a = angles_at(in, i);
	return shade_blinn_phong_modified(a.sin2_h, a.n_dot_l, exponent_at(in, i));
}

static inline float minimalist_at(const shade_run_lanes *in, int i)
{
	shade_angles a = angles_at(in, i);
	return shade_minimalist(a.sin2_h, a.v_dot_h, exponent_at(in, i)) * a.n_dot_l;
}

static inline float phong_modified_at(const shade_run_lanes *in, int i)
{
	float n = shade_exponent_about_r(exponent_at(in, i));
	return shade_phong_modified(sin2_r_at(in, i), dot_at(in->n, in->l, i), n);
}

SCALED_KERNEL(wrapped, shade_wrapped(dot_at(in->n, in->l, i), SHADE_RUN_WRAP))
SCALED_KERNEL(phong_modified, phong_modified_at(in, i))
SCALED_KERNEL(blinn_phong_modified, blinn_phong_modified_at(in, i))
SCALED_KERNEL(minimalist, minimalist_at(in, i))

static inline float f_schlick(float f0, float v_dot_h)
{
	float m = 1.0f - v_dot_h, m2 = m * m;
	return f0 + (1.0f - f0) * (m2 * m2 * m);
}

void shade_wide_ggx(const shade_run_inputs *inputs, shade_run_results *results)
{
	const shade_run_lanes *restrict in = &inputs->lanes;
	float(*restrict out)[SHADE_RUN_COUNT] = results->lanes;
	LANES
	for (int i = 0; i < SHADE_RUN_COUNT; i++) {
		shade_angles a = angles_at(in, i);
		float alpha = shade_alpha_from_roughness(in->roughness[i]);
		float scale = shade_dv_ggx(a.sin2_h, a.n_dot_l, a.n_dot_v, alpha) * a.n_dot_l;
		out[0][i] = f_schlick(in->f0[0][i], a.v_dot_h) * scale;
		out[1][i] = f_schlick(in->f0[1][i], a.v_dot_h) * scale;
		out[2][i] = f_schlick(in->f0[2][i], a.v_dot_h) * scale;
	}
}

void shade_wide_cook_torrance(const shade_run_inputs *inputs, shade_run_results *results)
{
	const shade_run_lanes *restrict in = &inputs->lanes;
	float(*restrict out)[SHADE_RUN_COUNT] = results->lanes;
	LANES
	for (int i = 0; i < SHADE_RUN_COUNT; i++) {
		shade_angles a = angles_at(in, i);
		float alpha = shade_alpha_from_roughness(in->roughness[i]);
		float v = shade_v_cook_torrance(a.n_dot_l, a.n_dot_v, a.n_dot_h, a.v_dot_h);
		float scale = shade_d_beckmann(a.sin2_h, alpha) * v * a.n_dot_l;
		out[0][i] = shade_f_cook_torrance_1(in->f0[0][i], a.v_dot_h) * scale;
		out[1][i] = shade_f_cook_torrance_1(in->f0[1][i], a.v_dot_h) * scale;
		out[2][i] = shade_f_cook_torrance_1(in->f0[2][i], a.v_dot_h) * scale;
	}
}
