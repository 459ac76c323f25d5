/* shade_environment.h: the cube against Vulkan's own table of faces, the other formulas against what they were derived
 * from, in double, and the direction of gloss against the lobe's mean by quadrature. */
#include "numeric/numeric_quadrature.h"
#include "shading/shade_environment.h"
#include "shading/shade_frame.h"
#include "shading/shade_sampling.h"
#include "support/shade_proof.h"

/* ---- cubes ------------------------------------------------------------------------------------------------------- */

/* "Cube map face and coordinate selection" of Vulkan 1.3, 16.5.4: the numbers are 1 + the axis, with a sign. */
static const struct {
	int major, s, t;
} faces[6] = {{1, -3, -2}, {-1, 3, -2}, {2, 1, 3}, {-2, 1, -3}, {3, 1, -2}, {-3, -1, -2}};

static double signed_axis(stilb_vec3 d, int axis)
{
	return axis > 0 ? (double)d[axis - 1] : -(double)d[-axis - 1];
}

static void assert_place(stilb_vec3 d)
{
	int face = 0;
	for (int i = 1; i < 6; i++)
		if (signed_axis(d, faces[i].major) > signed_axis(d, faces[face].major))
			face = i;
	double size = signed_axis(d, faces[face].major);
	shade_cube_place place = shade_cube_place_of(d);
	assert_int_equal(place.face, face);
	SHADE_PROOF_NEAR(place.s, signed_axis(d, faces[face].s) / size, 1e-6, 1e-7);
	SHADE_PROOF_NEAR(place.t, signed_axis(d, faces[face].t) / size, 1e-6, 1e-7);
	stilb_vec3 back = shade_cube_direction(place.face, place.s, place.t);
	for (int c = 0; c < 3; c++)
		SHADE_PROOF_NEAR(back[c], (double)d[c] / size, 1e-6, 1e-7);
}

static void places_are_those_of_vulkan(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int i = 0; i < 3000; i++)
		assert_place(shade_proof_random_direction(&random) * (0.1f + 3.0f * shade_proof_uniform(&random)));
	/* Of equal axes z counts before y and y before x. */
	assert_int_equal(shade_cube_place_of(stilb_vec3_make(1.0f, 1.0f, -1.0f)).face, 5);
	assert_int_equal(shade_cube_place_of(stilb_vec3_make(-1.0f, 1.0f, 0.5f)).face, 2);
	assert_int_equal(shade_cube_place_of(stilb_vec3_make(1.0f, 0.5f, 1.0f)).face, 4);
}

static void roughness_has_its_mip(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_environment_mip(0.25f, 9.0f), 2.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_environment_mip(1.0f, 7.0f), 6.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_environment_roughness(2.0f, 9.0f), 0.25, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_environment_roughness(6.0f, 7.0f), 1.0, 1e-6, 0.0);
}

/* ---- direction --------------------------------------------------------------------------------------------------- */

static void direction_is_between(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int i = 0; i < 500; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), v = shade_proof_random_above(&random, n);
		float roughness = shade_proof_uniform(&random);
		double c = (double)stilb_vec3_dot(n, v), alpha = fmax((double)(roughness * roughness), 1e-3);
		double share = (1.0 - alpha) / (1.0 + 1.25 * alpha * (1.0 - c)), d[3], length = 0.0;
		for (int k = 0; k < 3; k++) {
			d[k] = (double)n[k] * (1.0 - share) + share * (2.0 * c * (double)n[k] - (double)v[k]);
			length += d[k] * d[k];
		}
		length = sqrt(length);
		SHADE_PROOF_NEAR3(shade_environment_direction(n, v, roughness), d[0] / length, d[1] / length, d[2] / length,
		                  0.0, 2e-6);
	}
	/* From behind the normal it is as at the horizon. */
	stilb_vec3 n = stilb_vec3_make(0.0f, 0.0f, 1.0f), v = stilb_vec3_make(0.6f, 0.0f, -0.8f);
	double share = (1.0 - 0.25) / (1.0 + 1.25 * 0.25), x = -0.6 * share, z = 1.0 - share - 0.8 * share;
	SHADE_PROOF_NEAR(shade_environment_direction(n, v, 0.5f)[0], x / sqrt(x * x + z * z), 0.0, 1e-2);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static void places_have_their_formula(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	double least = sqrt((double)SHADE_ALPHA_MIN);
	for (int i = 0; i < 2000; i++) {
		float n_dot_v = shade_proof_uniform(&random), roughness = shade_proof_uniform(&random);
		double r = fmax((double)roughness, least), x = sqrt((double)n_dot_v);
		stilb_vec2 place = shade_dfg_place(n_dot_v, roughness);
		SHADE_PROOF_NEAR(place[0], 0.5 * (x + x / (x + r * (1.0 - x))), 1e-6, 0.0);
		SHADE_PROOF_NEAR(place[1], (r - least) / (1.0 - least), 1e-5, 1e-6);
		stilb_vec2 back = shade_dfg_from_place(place);
		SHADE_PROOF_NEAR(back[0], (double)n_dot_v, 2e-5, 1e-9);
		SHADE_PROOF_NEAR(back[1], r, 1e-6, 0.0);
	}
	/* Corners. */
	assert_true(shade_dfg_place(0.0f, 1.0f)[0] == 0.0f && shade_dfg_place(1.0f, 0.0f)[0] == 1.0f);
	assert_true(shade_dfg_place(-0.1f, 1.0f)[0] == 0.0f && shade_dfg_place(1.1f, 0.0f)[0] == 1.0f);
	assert_true(shade_dfg_place(0.5f, 0.0f)[1] == 0.0f && shade_dfg_place(0.5f, 1.0f)[1] == 1.0f);
	stilb_vec2 first = {0.0f, 0.0f}, last = {1.0f, 1.0f};
	SHADE_PROOF_NEAR(shade_dfg_texel(first, 64.0f)[0], 0.5 / 64, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_dfg_texel(last, 64.0f)[1], 63.5 / 64, 1e-6, 0.0);
}

static void reflectance_has_its_formula(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int i = 0; i < 1000; i++) {
		stilb_vec3 f0 = shade_proof_random_color(&random, 1.0f);
		double white = (double)shade_proof_range(&random, 0.3f, 1.0f), b = 0.3 * (double)shade_proof_uniform(&random);
		double a = white - b, want[3], more[3];
		stilb_vec2 dfg = {(float)a, (float)b};
		for (int c = 0; c < 3; c++) {
			more[c] = 1.0 + (double)f0[c] * (1.0 / white - 1.0);
			want[c] = ((double)f0[c] * a + b) * more[c];
		}
		SHADE_PROOF_NEAR3(shade_energy_compensation(f0, dfg), more[0], more[1], more[2], 2e-6, 0.0);
		SHADE_PROOF_NEAR3(shade_environment_reflectance(f0, dfg), want[0], want[1], want[2], 2e-6, 0.0);
	}
	/* A table that has not been filled gives no infinity. */
	stilb_vec2 empty = {0.0f, 0.0f};
	assert_true(isfinite(shade_environment_reflectance(stilb_vec3_make(1.0f, 1.0f, 1.0f), empty)[0]));
}

/* Smooth lobes shrink by n.v, about the mirrored direction; rough ones stay, about their middle. */
static void looks_are_narrow_at_a_slant(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 6};
	for (int i = 0; i < 500; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), v = shade_proof_random_above(&random, n);
		float roughness = shade_proof_uniform(&random);
		double c = (double)stilb_vec3_dot(n, v), alpha = fmax((double)(roughness * roughness), 1e-3);
		double slim = fmax(1.0 - 1.7 * alpha, 0.0), d[3], length = 0.0;
		stilb_vec3 middle = shade_environment_direction(n, v, roughness);
		shade_environment_look look = shade_environment_look_of(n, v, roughness);
		for (int k = 0; k < 3; k++) {
			d[k] = (double)middle[k] * (1.0 - slim) + slim * (2.0 * c * (double)n[k] - (double)v[k]);
			length += d[k] * d[k];
		}
		length = sqrt(length);
		SHADE_PROOF_NEAR3(look.toward, d[0] / length, d[1] / length, d[2] / length, 0.0, 2e-6);
		SHADE_PROOF_NEAR(look.roughness, (double)roughness * sqrt(1.0 - slim * (1.0 - c)), 0.0, 2e-6);
	}
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

typedef struct mean_lobe {
	stilb_vec3 v;
	float alpha;
	int lane; /* of the direction that is averaged; 3: of 1 */
} mean_lobe;

/* Reflected light from the direction that v's mirror image at h has, over half vectors h about z. */
static double mean_at(const double h[3], const void *context)
{
	const mean_lobe *lobe = context;
	stilb_vec3 half = stilb_vec3_make((float)h[0], (float)h[1], (float)h[2]), v = lobe->v;
	float v_dot_h = stilb_vec3_dot(v, half);
	stilb_vec3 l = half * (2.0f * v_dot_h) - v;
	if (h[2] <= 0.0 || v_dot_h <= 0.0f || l[2] <= 0.0f)
		return 0.0;
	float sin2_h = half[0] * half[0] + half[1] * half[1];
	double light = (double)(shade_dv_ggx(sin2_h, l[2], v[2], lobe->alpha) * l[2] * 4.0f * v_dot_h);
	return lobe->lane == 3 ? light : light * (double)l[lobe->lane];
}

static double cosine_of_lobe(double cosine, const void *context)
{
	double alpha = *(const double *)context, sine2 = 0.5 * (1.0 - cosine);
	double bracket = alpha * alpha + sine2 * (1.0 - alpha * alpha);
	return cosine / (bracket * bracket);
}

static double squared_of_lobe(double cosine, const void *context)
{
	return cosine * cosine_of_lobe(cosine, context);
}

/* Distance of the mean of what the lobe reflects, and of the cube's lobe about this direction. */
static double mean_error(stilb_vec3 v, double alpha, stilb_vec3 toward)
{
	double mean[4], length = stilb_numeric_integrate(squared_of_lobe, &alpha, 0.0, 1.0, 200) /
	                         stilb_numeric_integrate(cosine_of_lobe, &alpha, 0.0, 1.0, 200);
	for (int lane = 0; lane < 4; lane++) {
		mean_lobe lobe = {v, (float)alpha, lane};
		mean[lane] = stilb_numeric_integrate_lobe(mean_at, &lobe, alpha);
	}
	double sum = 0.0;
	for (int c = 0; c < 3; c++)
		sum += pow(mean[c] / mean[3] - length * (double)toward[c], 2.0);
	return sqrt(sum);
}

/* The header's numbers for the fit, and that it is better than the mirrored direction. */
static void direction_meets_the_mean(void **state)
{
	(void)state;
	double sum = 0.0, mirrored = 0.0, most = 0.0;
	stilb_vec3 n = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	for (int k = 1; k <= 7; k++)
		for (int i = 0; i < 6; i++) {
			double roughness = 0.15 * k - 0.05, c = 0.05 + 0.19 * i;
			stilb_vec3 v = stilb_vec3_make((float)sqrt(1.0 - c * c), 0.0f, (float)c);
			stilb_vec3 mirror = stilb_vec3_make(-v[0], 0.0f, v[2]);
			double error = mean_error(v, roughness * roughness, shade_environment_direction(n, v, (float)roughness));
			sum += error * error;
			most = fmax(most, error);
			mirrored += pow(mean_error(v, roughness * roughness, mirror), 2.0);
		}
	assert_true(sqrt(sum / 42.0) < 0.07 && most < 0.16);
	assert_true(sqrt(mirrored / 42.0) > 0.35);
}

/* The share of a lobe that sees a lamp, a round one of this direction. The lobe is GGX of v about n: facets as v sees
 * them, each weighed by the shadowing of the light. Where v is n it is the cube's. */
static double lamp_share(stilb_vec3 n, stilb_vec3 v, float alpha, stilb_vec3 lamp)
{
	shade_frame frame = shade_frame_from_normal(n);
	stilb_vec3 local = shade_frame_to_local(frame, v);
	double lit = 0.0, all = 0.0;
	for (int i = 0; i < 1024; i++) {
		stilb_vec2 u = {((float)i + 0.5f) / 1024.0f, (float)fmod(0.6180339887 * i, 1.0)};
		stilb_vec3 sampled = shade_sample_ggx_visible((shade_alphas){alpha, alpha}, local, u).direction;
		float z = sampled[2];
		stilb_vec3 l = shade_frame_to_world(frame, sampled);
		double weight = z > 0.0f ? 2.0 * (double)(z * shade_v1_smith_ggx(z, alpha)) : 0.0;
		all += weight;
		lit += stilb_vec3_dot(l, lamp) > 0.95f ? weight : 0.0;
	}
	return lit / fmax(all, 1e-9);
}

/* Lamps about the mirrored direction, seen at a slant: the look is nearer to the lobe than the wide one that the cube
 * has of this roughness, about the lobe's middle. */
static void looks_are_nearer_to_the_lobe(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 8};
	stilb_vec3 n = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	double narrow = 0.0, wide = 0.0;
	for (int i = 0; i < 300; i++) {
		float roughness = shade_proof_range(&random, 0.2f, 0.65f), c = shade_proof_range(&random, 0.1f, 0.6f);
		stilb_vec3 v = stilb_vec3_make(sqrtf(1.0f - c * c), 0.0f, c), mirrored = stilb_vec3_make(-v[0], 0.0f, c);
		stilb_vec3 lamp = stilb_vec3_normalize(mirrored + shade_proof_random_direction(&random) * 0.6f);
		double truth = lamp_share(n, v, shade_alpha_from_roughness(roughness), lamp);
		shade_environment_look look = shade_environment_look_of(n, v, roughness);
		stilb_vec3 middle = shade_environment_direction(n, v, roughness);
		narrow +=
			pow(lamp_share(look.toward, look.toward, shade_alpha_from_roughness(look.roughness), lamp) - truth, 2.0);
		wide += pow(lamp_share(middle, middle, shade_alpha_from_roughness(roughness), lamp) - truth, 2.0);
	}
	narrow = sqrt(narrow / 300);
	wide = sqrt(wide / 300);
	print_message("lamps by the look: %.3f off, by the wide lobe %.3f\n", narrow, wide);
	assert_true(narrow < 0.8 * wide);
}

static void reflectance_is_at_most_one(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 f0 = shade_proof_random_color(&random, 1.0f);
		float white = shade_proof_range(&random, 0.01f, 1.0f), b = white * shade_proof_uniform(&random);
		stilb_vec3 got = shade_environment_reflectance(f0, (stilb_vec2){white - b, b});
		for (int c = 0; c < 3; c++)
			assert_true(got[c] >= 0.0f && got[c] <= 1.0f + 1e-5f);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(places_are_those_of_vulkan),  cmocka_unit_test(roughness_has_its_mip),
		cmocka_unit_test(direction_is_between),        cmocka_unit_test(places_have_their_formula),
		cmocka_unit_test(reflectance_has_its_formula), cmocka_unit_test(looks_are_narrow_at_a_slant),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(direction_meets_the_mean),
		cmocka_unit_test(looks_are_nearer_to_the_lobe),
		cmocka_unit_test(reflectance_is_at_most_one),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
