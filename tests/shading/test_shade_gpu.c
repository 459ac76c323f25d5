/* The shading functions of one topic on the GPU against the same text compiled as C: each row (a call of a function) of
 * cases/cases_<topic>.h on many inputs, within the bound that stands beside it. Built once for each topic. */
#include "shade_topic.h"
#include "support/shade_gpu.h"

static const uint32_t code[] =
#include "shade_gpu.inc"
	;

static const struct {
	const char *name;
	double relative, absolute;
} rows[] = {
#define ROW(row, name, relative, absolute) {#name, (double)relative, (double)absolute},
	SHADE_TOPIC_CASES(ROW)
#undef ROW
};

static stilb_vec4 in_c(int row, stilb_vec4 a, stilb_vec4 b)
{
	return shade_topic_case(row, a, b);
}

static int start(void **state)
{
	(void)state;
	shade_gpu_start(code, sizeof code);
	shade_gpu_specialise(NULL, 0);
	return 0;
}

static void gpu_and_c_agree(void **state)
{
	(void)state;
	bool good = true;
	for (int32_t row = 0; row < SHADE_TOPIC_COUNT; row++) {
		size_t where[2] = {0, 0};
		shade_gpu_run(row);
		double worst = shade_gpu_worst(in_c, row, rows[row].relative, rows[row].absolute, where);
		printf("%-44s %8.2g of max(%.0e relative, %.0e)\n", rows[row].name, worst, rows[row].relative,
		       rows[row].absolute);
		if (worst <= 1.0)
			continue;
		shade_gpu_print_worst(in_c, row, where);
		good = false;
	}
	assert_true(good);
}

int main(void)
{
	if (!shade_gpu_present())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(gpu_and_c_agree),
		cmocka_unit_test(shade_gpu_layer_said_nothing),
	};
	return cmocka_run_group_tests(tests, start, shade_gpu_end);
}
