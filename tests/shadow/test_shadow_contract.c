/* The contract of shadow plans, each broken on purpose. */
#include "shadow/shadow.h"
#include "support/contract.h"
#include "support/test.h"

static void test_arguments(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	stilb_shadow_desc desc = {.page = 256, .pages = 4, .maps = 8, .cascades = 2, .filter = 1}, wrong;
	stilb_shadow_view view = {.height = 100, .bounds = {0.0f, 0.0f, 0.0f, 1.0f}}, nowhere = view;
	stilb_scene_light light = {0};
	contract_breaks("plan && desc", stilb_shadow_plan_make(NULL, &desc, &view, &light, 1));
	contract_breaks("plan && desc", stilb_shadow_plan_make(&plan, NULL, &view, &light, 1));
	contract_breaks("lights || count == 0", stilb_shadow_plan_make(&plan, &desc, &view, NULL, 1));
#define WRONG(member, value)                                                                                           \
	wrong = desc;                                                                                                      \
	wrong.member = value;                                                                                              \
	contract_breaks("desc_is_sound", stilb_shadow_plan_make(&plan, &wrong, &view, &light, 1))
	WRONG(page, 300);
	WRONG(page, 32);
	WRONG(page, 16384);
	WRONG(pages, 0);
	WRONG(pages, STILB_SHADOW_MAX_PAGES + 1);
	WRONG(maps, 0);
	WRONG(cascades, 0);
	WRONG(cascades, STILB_SHADOW_MAX_CASCADES + 1);
	WRONG(distance, -1.0f);
	WRONG(filter, 0);
	WRONG(filter, 4);
	nowhere.bounds.radius = 0.0f;
	contract_breaks("bounds.radius", stilb_shadow_plan_make(&plan, &desc, &nowhere, &light, 1));
}

static void test_casters(void **state)
{
	(void)state;
	stilb_shadow_view view = {.height = 100, .bounds = {0.0f, 0.0f, 0.0f, 1.0f}};
	stilb_shadow_map map = {0}, wrong = {.caster_count = STILB_SHADOW_CASTER_PLANES + 1};
	contract_breaks("kept && now && view", stilb_shadow_casters_hold(NULL, &map, &view));
	contract_breaks("kept && now && view", stilb_shadow_casters_hold(&map, &map, NULL));
	contract_breaks("map->caster_count <=", stilb_shadow_casters_have(&wrong, (stilb_sphere){0}));
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(test_arguments), cmocka_unit_test(test_casters)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
