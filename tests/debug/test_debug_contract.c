/* The asserts of debug drawing, each made to fail on purpose. */
#include "support/contract.h"
#include "tests/debug/debug_world.h"

#include <pthread.h>

static void *draw_frame(void *debug)
{
	stilb_debug_count(debug);
	return NULL;
}

static void on_another_thread(stilb_debug *debug)
{
	pthread_t thread;
	pthread_create(&thread, NULL, draw_frame, debug);
	pthread_join(thread, NULL);
}

static void broken_contracts(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	world w = world_open(desc);
	static const float a[3] = {0, 0, -1}, up[3] = {0, 1, 0}, broken[3] = {0, NAN, 0};
	stilb_debug_style style = {.rgba = 0xffffffff};
	contract_breaks("style.width <= 64.0f", stilb_debug_line(w.debug, a, up, (stilb_debug_style){.width = 65.0f}));
	contract_breaks("style.width >= 0.0f", stilb_debug_line(w.debug, a, up, (stilb_debug_style){.width = -1.0f}));
	contract_breaks("seconds >= 0.0f", stilb_debug_line(w.debug, a, up, (stilb_debug_style){.seconds = -1.0f}));
	contract_breaks("debug_is_finite", stilb_debug_line(w.debug, a, broken, style));
	contract_breaks("debug_is_finite", stilb_debug_text(w.debug, broken, style, "x"));
	contract_breaks("radius >= 0.0f", stilb_debug_sphere(w.debug, a, -1.0f, style));
	contract_breaks("points || count == 0", stilb_debug_lines(w.debug, NULL, 1, style));
	contract_breaks("transform", stilb_debug_axes(w.debug, NULL, 1.0f, style));
	contract_breaks("owner's thread", on_another_thread(w.debug));
	contract_breaks("pool", stilb_debug_frame(w.debug, NULL, 0, 0.0, NULL, 0));
	world_close(&w);
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(broken_contracts)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
