/* Places in shared memory: nothing that lives at the same time overlaps, and few items take no more than they must,
 * which a search through all orders finds. */
#include "gpu/gpu_plan_internal.h"

#include "support/test.h"

#include <stdlib.h>
#include <string.h>

#define MOST 400u

/* ---- a search through all orders -------------------------------------------------------------------------------- */

static bool share_a_step(const gpu_item *a, const gpu_item *b)
{
	return !(a->last < b->first || b->last < a->first);
}

/* The lowest offset at which an item fits beside those in `placed`. */
static uint64_t lowest(const gpu_item *items, const uint32_t *placed, uint32_t count, const gpu_item *item)
{
	uint64_t best = UINT64_MAX;
	for (uint32_t c = 0; c <= count; c++) { /* it is 0, or just after one of them */
		uint64_t at = c == count ? 0 : items[placed[c]].offset + items[placed[c]].bytes;
		at = (at + item->align - 1) / item->align * item->align;
		bool fits = at < best;
		for (uint32_t i = 0; i < count && fits; i++) {
			const gpu_item *other = &items[placed[i]];
			fits =
				!share_a_step(item, other) || at + item->bytes <= other->offset || other->offset + other->bytes <= at;
		}
		best = fits ? at : best;
	}
	return best;
}

static uint64_t search(gpu_item *items, uint32_t count, uint32_t *placed, uint32_t depth, uint64_t total, uint64_t best)
{
	if (total >= best)
		return best;
	if (depth == count)
		return total;
	for (uint32_t i = 0; i < count; i++) {
		bool taken = false;
		for (uint32_t k = 0; k < depth; k++)
			taken = taken || placed[k] == i;
		if (taken)
			continue;
		items[i].offset = lowest(items, placed, depth, &items[i]);
		uint64_t end = items[i].offset + items[i].bytes;
		placed[depth] = i;
		best = search(items, count, placed, depth + 1, end > total ? end : total, best);
	}
	return best;
}

/* ---- random items ----------------------------------------------------------------------------------------------- */

static int by_first(const void *a, const void *b)
{
	const gpu_item *x = a, *y = b;
	return (x->first > y->first) - (x->first < y->first);
}

/* kind 0: any sizes, 1: powers of two, as images of a chain have them, 2: many of one size. */
static void make_items(gpu_item *items, uint32_t count, uint64_t seed)
{
	uint32_t kind = (uint32_t)(seed % 3), steps = 2 + (uint32_t)(stilb_random_u64(seed, 0) % (2 * count));
	for (uint32_t i = 0; i < count; i++) {
		uint64_t a = stilb_random_u64(seed, 3 * i + 1), b = stilb_random_u64(seed, 3 * i + 2);
		uint32_t first = (uint32_t)(a % steps), length = (uint32_t)(a >> 32) % (a >> 60 == 0 ? steps : 1 + steps / 3);
		uint64_t bytes = kind == 0 ? 1 + b % 100000 : kind == 1 ? 256ull << b % 8 : b % 4 == 0 ? 5000 : 4096;
		items[i] = (gpu_item){.bytes = bytes,
		                      .align = kind == 0 ? 1ull << (b >> 40) % 9 : 256,
		                      .first = first,
		                      .last = first + length,
		                      .resource = (uint16_t)(i + 1)};
	}
	qsort(items, count, sizeof *items, by_first);
}

static void check_sound(const gpu_item *items, uint32_t count, uint64_t total)
{
	uint64_t end = 0;
	for (uint32_t i = 0; i < count; i++) {
		assert_int_equal(items[i].offset % items[i].align, 0);
		end = items[i].offset + items[i].bytes > end ? items[i].offset + items[i].bytes : end;
		for (uint32_t k = 0; k < i; k++)
			if (share_a_step(&items[i], &items[k]) && items[i].offset < items[k].offset + items[k].bytes &&
			    items[k].offset < items[i].offset + items[i].bytes)
				fail_msg("items %u and %u overlap", k, i);
	}
	assert_int_equal(end, total);
}

static void test_best(void **state)
{
	(void)state;
	gpu_array scratch = {0};
	double worst = 1;
	uint32_t plans = TEST_ASAN || TEST_EMULATED ? 300 : 2000, exact = 0;
	for (uint32_t i = 0; i < plans; i++) {
		uint32_t count = i % 200 == 0 ? 8 : 1 + i % 7;
		gpu_item items[8], copy[8];
		make_items(items, count, i);
		memcpy(copy, items, sizeof copy);
		uint64_t total = gpu_place(items, count, &scratch);
		check_sound(items, count, total);
		uint32_t placed[8];
		uint64_t best = search(copy, count, placed, 0, 0, UINT64_MAX);
		double ratio = (double)total / (double)best;
		worst = ratio > worst ? ratio : worst;
		exact += total == best;
	}
	print_message("%u of %u plans take the least memory; the worst takes %.3f times\n", exact, plans, worst);
	assert_true(worst <= 1.01 && exact > plans * 9 / 10);
	free(scratch.items);
}

/* The bytes that live in one step are a bound that many items come near to. */
static void test_many(void **state)
{
	(void)state;
	gpu_array scratch = {0};
	double sum = 0, worst = 1;
	uint64_t slowest = 0;
	uint32_t plans = TEST_ASAN || TEST_EMULATED ? 30 : 300;
	for (uint32_t i = 0; i < plans; i++) {
		static gpu_item items[MOST];
		uint32_t count = 9 + i * (MOST - 9) / plans;
		make_items(items, count, 1000 + i);
		uint64_t start = stilb_time_ns();
		uint64_t total = gpu_place(items, count, &scratch), least = 0;
		start = stilb_time_ns() - start;
		slowest = start > slowest ? start : slowest;
		check_sound(items, count, total);
		for (uint32_t k = 0; k < count; k++) {
			uint64_t live = 0;
			for (uint32_t m = 0; m < count; m++)
				live += items[m].first <= items[k].first && items[k].first <= items[m].last ? items[m].bytes : 0;
			least = live > least ? live : least;
		}
		assert_true(total >= least);
		double ratio = (double)total / (double)least;
		sum += ratio;
		worst = ratio > worst ? ratio : worst;
	}
	print_message("9 to %u items: %.3f times the bound on average, %.3f at worst; %.0f us at most\n", MOST, sum / plans,
	              worst, (double)slowest / 1000);
	assert_true(sum / plans < 1.08);
	free(scratch.items);
}

/* In a plan: an image after another takes its place, heaps are apart, and the device's sizes count. */
static stilb_result needs_of(void *user, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	(*(uint32_t *)user)++;
	*needs = (stilb_gpu_needs){
		.bytes = extent->width * 1000ull, .align = 512, .heap = extent->format == STILB_GPU_D32_F ? 2 : 0};
	return STILB_OK;
}

static stilb_result buffer_needs(void *user, uint64_t bytes, stilb_gpu_needs *needs)
{
	(void)user;
	*needs = (stilb_gpu_needs){.bytes = bytes + 1, .align = 64, .heap = 1};
	return STILB_OK;
}

static uint16_t add_image(stilb_gpu_plan *plan, const char *name, stilb_gpu_format format, uint32_t width, bool output)
{
	return stilb_gpu_plan_image(
		plan,
		&(stilb_gpu_plan_image_row){.name = name, .format = format, .width = width, .height = 8, .output = output});
}

static void add_copy(stilb_gpu_plan *plan, uint16_t from, uint16_t to)
{
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "copy",
	                                            .kind = STILB_GPU_PASS_COPY,
	                                            .uses = {{.resource = from, .how = STILB_GPU_USE_COPY_FROM},
	                                                     {.resource = to, .how = STILB_GPU_USE_COPY_TO}},
	                                            .use_count = 2});
}

static void test_plan(void **state)
{
	(void)state;
	uint32_t asked = 0;
	stilb_gpu_planner planner = {.user = &asked, .image_needs = needs_of, .buffer_needs = buffer_needs};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (uint32_t frame = 0; frame < 4; frame++) {
		stilb_gpu_plan_begin(plan, 8, 8);
		uint16_t source = stilb_gpu_plan_image(
			plan, &(stilb_gpu_plan_image_row){
					  .name = "source", .format = STILB_GPU_RGBA8_U, .width = 8, .height = 8, .owned = 1});
		uint16_t a = add_image(plan, "a", STILB_GPU_RGBA8_U, 8, false);
		uint16_t b = add_image(plan, "b", STILB_GPU_RGBA8_U, 8, false);
		uint16_t c = add_image(plan, "c", STILB_GPU_RGBA8_U, 8, false);
		uint16_t out = add_image(plan, "out", STILB_GPU_RGBA8_U, 8, true);
		uint16_t buffer = stilb_gpu_plan_buffer(plan, &(stilb_gpu_plan_buffer_row){.name = "buffer", .bytes = 999});
		add_copy(plan, source, a);
		add_copy(plan, a, b);
		add_copy(plan, b, c);
		add_copy(plan, c, buffer);
		add_copy(plan, buffer, out);
		assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_OK);
		const stilb_gpu_placed *at[3] = {stilb_gpu_plan_place(plan, a), stilb_gpu_plan_place(plan, b),
		                                 stilb_gpu_plan_place(plan, c)};
		for (uint32_t i = 0; i < 3; i++) {
			assert_int_equal(at[i]->bytes, 8000);
			assert_int_equal(at[i]->heap, 0);
			assert_true(at[i]->shared);
			assert_int_equal(at[i]->first_step, i);
			assert_int_equal(at[i]->last_step, i + 1);
			assert_int_equal(at[i]->offset, i == 1 ? 8192 : 0); /* 8,000 rounded up to 512 */
		}
		assert_int_equal(stilb_gpu_plan_heaps(plan), 2);
		assert_int_equal(stilb_gpu_plan_heap_bytes(plan, 0), 8192 + 8000);
		assert_int_equal(stilb_gpu_plan_heap_bytes(plan, 1), 1000);
		assert_false(stilb_gpu_plan_place(plan, out)->shared);
		assert_false(stilb_gpu_plan_place(plan, source)->shared);
		assert_int_equal(stilb_gpu_plan_place(plan, source)->owned, 1);
	}
	assert_int_equal(asked, 3); /* for each of three images once */
	stilb_gpu_plan_destroy(plan);
}

int main(void)
{
	const struct CMUnitTest tests[] = {test_one_thread(test_best), test_one_thread(test_many),
	                                   cmocka_unit_test(test_plan)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
