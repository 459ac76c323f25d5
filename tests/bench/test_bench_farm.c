/* Simulated machines: the numbers of docs/many-machines.md that are goals, and that a run repeats. */
#include "bench/farm/farm_sim.h"
#include "support/test.h"

static farm_sim_result run(uint32_t machines, double speed_sigma, double failing)
{
	farm_sim_desc desc = farm_sim_default();
	desc.machines = machines;
	desc.speed_sigma = speed_sigma;
	desc.failing = failing;
	return farm_sim_run(&desc);
}

static void a_thousand_machines(void **state)
{
	(void)state;
	farm_sim_result equal = run(1024, 0.0, 0.0), again = run(1024, 0.0, 0.0);
	assert_true(equal.efficiency >= 0.9 && equal.efficiency < 1.0);
	assert_true(equal.seconds == again.seconds && equal.messages == again.messages && equal.twice == again.twice);
	assert_int_equal(equal.units, 960 * 540);
	assert_true(run(1024, 0.5, 0.0).efficiency >= 0.85);
	assert_true(run(1024, 0.5, 0.05).efficiency >= 0.85);
}

/* Nothing is lost where nothing is: one machine always computes. */
static void one_machine(void **state)
{
	(void)state;
	farm_sim_result one = run(1, 0.0, 0.0);
	assert_true(one.efficiency > 0.999 && one.efficiency <= 1.0);
	assert_int_equal(one.messages, 0);
	assert_int_equal(one.twice, 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_thousand_machines),
		cmocka_unit_test(one_machine),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
