/* The Cornell box: the means of a picture of 256 x 256 against those of a reference of 1,024 samples a pixel, which two
 * engines agree on. */
#include "gi_path_fixture.h"

#include <math.h>
#include <stdio.h>

static void cornell_has_the_reference_means(void **state)
{
	(void)state;
	static const double reference[3] = {0.380699501, 0.354962715, 0.311952810};
	path_fixture fixture = path_fixture_open("cornell");
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 256, 16);
	path_mean mean = path_picture_mean(&view);
	for (int c = 0; c < 3; c++) {
		double off = path_mean_of(&mean, c) / reference[c] - 1.0;
		printf("channel %d: %.6f, %+.4f %%\n", c, path_mean_of(&mean, c), 100.0 * off);
		if (!(fabs(off) <= 1e-3))
			fail_msg("channel %d: %.6f, not %.6f", c, path_mean_of(&mean, c), reference[c]);
	}
	path_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(cornell_has_the_reference_means)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
