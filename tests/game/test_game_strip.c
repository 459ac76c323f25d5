/* The rows of stilb shade spheres: what they say of their spheres, and bumps by three methods. */
#include "game/shade/shade_strip.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const strip *strip_named(const char *name)
{
	for (int i = 0; i < strip_count; i++)
		if (strcmp(strips[i].name, name) == 0)
			return &strips[i];
	fail_msg("no strip %s", name);
	return NULL;
}

/* The last row of the strip `classic` mixes a diffuse part and a highlight. The text below a sphere gives their shares
 * of the light, which sum to all of it. */
static void shares_of_the_light_sum_to_one(void **state)
{
	(void)state;
	const strip *classic = strip_named("classic");
	const strip_row *row = &classic->rows[classic->row_count - 1];
	strip_sphere all, sphere;
	strip_words words;
	row->make(row, 0, &all, words); /* diffuse alone */
	for (int c = 0; c < classic->column_count; c++) {
		int diffuse, specular;
		row->make(row, c, &sphere, words);
		assert_int_equal(sscanf(words, "%d %% + %d %%", &diffuse, &specular), 2);
		assert_int_equal(diffuse + specular, 100);
		assert_true(fabsf(sphere.highlight.specular[0] * 100.0f - (float)specular) < 0.01f);
		assert_true(fabsf(sphere.diffuse[0] / all.diffuse[0] * 100.0f - (float)diffuse) < 0.01f);
	}
}

/* The rows of the strip `bump` compute the same normals: by differences of the height to the next sample, by the chain
 * rule, and by derivatives along u and v. */
static void bumps_are_the_same_by_any_method(void **state)
{
	(void)state;
	const strip *bump = strip_named("bump");
	float most = 0.0f, farthest = 0.0f;
	for (int c = 0; c < bump->column_count; c++)
		for (float x = -0.6f; x < 0.65f; x += 0.15f)
			for (float y = -0.6f; y < 0.65f; y += 0.15f) {
				stilb_vec3 smooth = strip_normal(x, y), n[3];
				for (int r = 0; r < 3; r++) {
					strip_sphere sphere;
					strip_words words;
					float roughness = 0.4f;
					bump->rows[r].make(&bump->rows[r], c, &sphere, words);
					n[r] = smooth;
					sphere.relief(&sphere, (strip_place){x, y, 5e-4f}, 0, &n[r], &roughness);
					stilb_vec3 apart = n[r] - n[0], bent = n[r] - smooth;
					most = fmaxf(most, sqrtf(stilb_vec3_dot(apart, apart)));
					farthest = fmaxf(farthest, sqrtf(stilb_vec3_dot(bent, bent)));
				}
			}
	print_message("apart %g, bent %g\n", (double)most, (double)farthest);
	assert_true(most < 0.02f);
	assert_true(farthest > 0.3f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(shares_of_the_light_sum_to_one),
		cmocka_unit_test(bumps_are_the_same_by_any_method),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
