/* Debug drawing without memory, at any moment: what a call could not do is an error of the frame. The linker redirects
 * allocations to the functions here (--wrap). */
#include "support/failing_memory.h"
#include "tests/debug/debug_world.h"

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_stilb_memory_alloc(count, size);
}

static const stilb_debug_style plain = {.rgba = 0xffffffff};

static stilb_engine_desc null_desc(void)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	return desc;
}

/* Draws two frames; what a call could not do is the frame's error. */
static stilb_result draw_two(const world *w)
{
	static const float at[3] = {0, 0, -2};
	stilb_engine_report report;
	stilb_result result = STILB_OK;
	for (int f = 0; f < 2 && result == STILB_OK; f++) {
		for (int i = 0; i < 20; i++)
			stilb_debug_sphere(w->debug, at, (float)(f + 1), plain);
		stilb_debug_sphere(w->debug, at, 1.0f, (stilb_debug_style){.rgba = 0xffffffff, .seconds = 1.0f});
		stilb_debug_text(w->debug, at, plain, "text");
		result = stilb_engine_frame(w->engine, &report);
	}
	return result;
}

static void memory_runs_out(void **state)
{
	(void)state;
	bool done = false;
	uint32_t failed = 0;
	/* The first text draws glyphs, with thousands of allocations: some of them, and all before. */
	for (int n = 0; !done; n += n < 100 ? (TEST_ASAN ? 3 : 1) : (TEST_ASAN ? 997 : 311)) {
		world w = world_open(null_desc());
		fail_allocation = n;
		stilb_result result = draw_two(&w);
		done = fail_allocation >= 0;
		fail_allocation = -1;
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
		assert_true(!done || result == STILB_OK);
		failed += result == STILB_ERROR_MEMORY;
		world_close(&w);
	}
	assert_true(failed >= 5);
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(memory_runs_out)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
