/* Vertices sixteen at a time: every instruction set gives the bits of plain C; directions are of shade_sampling.h,
 * lights of gi_light_shape_sample, weighed as gi_direct.h says; and sines and cosines are right. */
#include "support/shade_proof.h"
#include "support/test.h"

#include "gi/gi_trigonometry.h"
#include "gi/lanes/gi_lanes.h"
#include "gi/sample/gi_sampler.h"
#include "shading/shade_sampling.h"

#include <math.h>
#include <string.h>

/* Sixteen surfaces before a rectangle that emits. */
typedef struct vertices {
	gi_surface surfaces[GI_LANES];
	float numbers[GI_LANES][8];
	gi_light_shape shapes[GI_LANES];
	gi_lanes lanes;
} vertices;

static vertices plain, wide;

/* A rectangle of random size and place, or one that is seen from very near, or far away. */
static gi_light_shape random_rectangle(shade_proof_random *random)
{
	shade_frame frame = shade_frame_from_normal(shade_proof_random_direction(random));
	float size = shade_proof_log_range(random, 0.02f, 3.0f);
	stilb_vec3 a = frame.t * size, b = frame.b * (size * shade_proof_range(random, 0.2f, 3.0f));
	stilb_vec3 corner = shade_proof_random_direction(random) * shade_proof_log_range(random, 0.05f, 7.0f);
	stilb_vec3 corners[4] = {corner, corner + a, corner + a + b, corner + b};
	gi_emitter halves[2] = {{.emission = {1.0f, 2.0f, 3.0f}}, {.emission = {1.0f, 2.0f, 3.0f}}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			halves[0].position[k][i] = corners[k][i];
			halves[1].position[k][i] = corners[(k + 2) % 4][i];
		}
	gi_light_shape shape;
	if (!gi_light_shape_join(&halves[0], &halves[1], &shape))
		return random_rectangle(random);
	return shape;
}

static void fill(shade_proof_random *random, vertices *out)
{
	memset(out, 0, sizeof *out);
	for (uint32_t i = 0; i < GI_LANES; i++) {
		stilb_vec3 n = shade_proof_random_direction(random),
				   bent = shade_frame_to_world(
					   shade_frame_from_normal(n),
					   stilb_vec3_normalize(stilb_vec3_make(shade_proof_range(random, -0.5f, 0.5f), 0.2f, 1.0f)));
		out->surfaces[i] = (gi_surface){.position = shade_proof_random_direction(random) * 0.1f,
		                                .geometric = n,
		                                .normal = bent,
		                                .diffuse = stilb_vec3_make(0.5f, 0.6f, 0.7f),
		                                .error = 1e-6f};
		for (int k = 0; k < 8; k++)
			out->numbers[i][k] = shade_proof_range(random, 0.0f, 1.0f) * SHADE_UNIFORM_MAX;
		out->shapes[i] = random_rectangle(random);
		out->lanes.surfaces[i] = &out->surfaces[i];
		out->lanes.numbers[i] = out->numbers[i];
		out->lanes.shapes[i] = &out->shapes[i];
		out->lanes.chance[i] = i == 3 ? 0.0f : 0.25f;
	}
	out->numbers[0][GI_DIMENSION_DIRECTION] = out->numbers[0][GI_DIMENSION_DIRECTION + 1] =
		0.5f; /* the disk's middle */
	out->numbers[1][GI_DIMENSION_LIGHT] = out->numbers[1][GI_DIMENSION_DIRECTION] = 0.0f;
	out->numbers[2][GI_DIMENSION_LIGHT] = out->numbers[2][GI_DIMENSION_DIRECTION] = SHADE_UNIFORM_MAX;
}

static void run_by(const gi_lanes_kernels *kernels, vertices *v)
{
	kernels->leave(&v->lanes);
	kernels->ask(&v->lanes);
}

static void instruction_sets_agree(void **state)
{
	(void)state;
	for (stilb_isa isa = STILB_ISA_AVX2; isa <= stilb_cpu_widest_isa(); isa++) {
		shade_proof_random random = {.seed = 1}, again = {.seed = 1};
		for (int round = 0; round < 500; round++) {
			fill(&random, &plain);
			fill(&again, &wide);
			run_by(gi_lanes_for(STILB_ISA_SCALAR), &plain);
			run_by(gi_lanes_for(isa), &wide);
			assert_memory_equal(plain.lanes.origin, wide.lanes.origin, sizeof plain.lanes.origin);
			assert_memory_equal(plain.lanes.next, wide.lanes.next, sizeof plain.lanes.next);
			assert_memory_equal(plain.lanes.weight, wide.lanes.weight, sizeof plain.lanes.weight);
			for (uint32_t i = 0; i < GI_LANES; i++) /* of no weight it may be no number */
				if (plain.lanes.weight[i] > 0.0f)
					assert_memory_equal(&plain.lanes.light[i], &wide.lanes.light[i], sizeof plain.lanes.light[i]);
		}
	}
}

static void assert_next(const vertices *v, uint32_t i)
{
	const gi_surface *surface = &v->surfaces[i];
	const float *u = &v->numbers[i][GI_DIMENSION_DIRECTION];
	shade_sample local = shade_sample_cosine((stilb_vec2){u[0], u[1]});
	stilb_vec3 direction = shade_frame_to_world(shade_frame_from_normal(surface->normal), local.direction);
	float above = stilb_vec3_dot(direction, surface->geometric);
	SHADE_PROOF_NEAR3(v->lanes.next[i], direction[0], direction[1], direction[2], 0.0, 4e-7);
	if (fabsf(above) > 1e-6f)
		SHADE_PROOF_NEAR(v->lanes.next[i][3], above > 0.0f ? local.pdf : 0.0f, 1e-6, 1e-6);
	stilb_vec3 origin = gi_surface_ray_origin(surface, surface->geometric);
	for (int k = 0; k < 3; k++)
		assert_true(v->lanes.origin[i][k] == origin[k]);
}

/* The weight of asking beside a ray that follows the cosine, in double. */
static double weight_of(const gi_surface *surface, const gi_light_sample *light, double chance)
{
	double cosine = (double)stilb_vec3_dot(surface->normal, light->direction), other = cosine / M_PI;
	double pdf = (double)light->pdf * chance;
	if (cosine <= 0.0 || stilb_vec3_dot(surface->geometric, light->direction) <= 0.0f || chance == 0.0)
		return 0.0;
	return other / pdf * pdf * pdf / (pdf * pdf + other * other);
}

/* True if light comes from the rectangle. */
static bool assert_light(const vertices *v, uint32_t i)
{
	const gi_surface *surface = &v->surfaces[i];
	const float *u = &v->numbers[i][GI_DIMENSION_LIGHT];
	gi_light_sample light;
	bool found = gi_light_shape_sample(&v->shapes[i], gi_surface_ray_origin(surface, surface->geometric),
	                                   (stilb_vec2){u[0], u[1]}, &light);
	double weight = found ? weight_of(surface, &light, (double)v->lanes.chance[i]) : 0.0;
	/* Cosines near 0 have lost their digits. */
	SHADE_PROOF_NEAR(v->lanes.weight[i], weight, 3e-5, 1e-7 / (double)fmaxf(found ? light.pdf : 1.0f, 1e-6f));
	if (!(weight > 0.0))
		return false;
	SHADE_PROOF_NEAR3(v->lanes.light[i], light.direction[0], light.direction[1], light.direction[2], 0.0, 1e-6);
	SHADE_PROOF_NEAR(v->lanes.light[i][3], light.distance, 1e-6, 0.0);
	return true;
}

static void lanes_are_what_one_vertex_computes(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 7};
	uint32_t lit = 0, below = 0;
	for (int round = 0; round < 500; round++) {
		fill(&random, &plain);
		run_by(gi_lanes_of_cpu(), &plain);
		for (uint32_t i = 0; i < GI_LANES; i++) {
			assert_next(&plain, i);
			lit += assert_light(&plain, i);
			below += plain.lanes.next[i][3] == 0.0f;
		}
	}
	assert_in_range(lit, 1000, 4000);
	assert_in_range(below, 50, 2000);
}

static void angles(void **state)
{
	(void)state;
	for (int i = 0; i <= 100000; i++) {
		float x = 2.0f * SHADE_PI * (float)i * 1e-5f, sine, cosine,
			  small = 0.25f * SHADE_PI * ((float)i * 2e-5f - 1.0f);
		gi_sine_and_cosine(x, &sine, &cosine);
		assert_true(fabs((double)sine - sin((double)x)) < 1.2e-7);
		assert_true(fabs((double)cosine - cos((double)x)) < 1.2e-7);
		assert_true(fabs((double)gi_sine_small(small) - sin((double)small)) <= 1.2e-7 * fabs(sin((double)small)));
		assert_true(fabs((double)gi_cosine_small(small) - cos((double)small)) < 1.2e-7);
		float y = (float)i * 2e-5f - 1.0f;
		assert_true(fabs((double)gi_arc_cosine(y) - acos((double)y)) < 6e-7);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(instruction_sets_agree),
		cmocka_unit_test(lanes_are_what_one_vertex_computes),
		cmocka_unit_test(angles),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
