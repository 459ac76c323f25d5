/* The contracts of light lists, each broken on purpose. */
#include "light/light.h"
#include "support/contract.h"
#include "support/test.h"

static void test_arguments(void **state)
{
	(void)state;
	stilb_light_grid grid = {0};
	stilb_light_lists lists = {0};
	stilb_scene_light light = {0};
	contract_breaks("lists && grid", stilb_light_lists_build(NULL, &grid, &light, 1, NULL, 0, NULL, 0));
	contract_breaks("lists && grid", stilb_light_lists_build(&lists, NULL, &light, 1, NULL, 0, NULL, 0));
	contract_breaks("lights || count == 0", stilb_light_lists_build(&lists, &grid, NULL, 1, NULL, 0, NULL, 0));
	contract_breaks("light", stilb_light_bounds_of(NULL));
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(test_arguments)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
