/* Places in blocks of memory, against a reference that knows every byte's owner, and 100,000 things of many sizes. */
#include "gpu/gpu_memory_internal.h"
#include "support/test.h"

#include <stdlib.h>
#include <string.h>

#define UNIT GPU_TLSF_UNIT
#define MOST 600u

static uint64_t random_state = 1;

static uint32_t random_below(uint32_t count)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (uint32_t)((random_state >> 33) % count);
}

/* ---- one block --------------------------------------------------------------------------------------------------- */

#define BLOCK_UNITS 4096u

typedef struct taken {
	uint32_t range, first, count;
} taken;

/* Checks the block against the owners of its units: ranges lie behind each other without gaps, no two holes touch, and
 * the largest hole is the one that is told. */
static void check_block(const gpu_tlsf *tlsf, const uint16_t owners[BLOCK_UNITS])
{
	uint32_t largest = 0, hole = 0, free_units = 0;
	for (uint32_t u = 0; u < BLOCK_UNITS; u++) {
		hole = owners[u] == 0 ? hole + 1 : 0;
		free_units += owners[u] == 0;
		largest = hole > largest ? hole : largest;
	}
	assert_int_equal(tlsf->free_units, free_units);
	assert_int_equal(gpu_tlsf_largest(tlsf), (uint64_t)largest * UNIT);
}

/* One of the things is taken or given in each step; nothing may overlap or lie askew, and what fits for certain is
 * found. */
static void random_ranges(void **state)
{
	(void)state;
	static uint16_t owners[BLOCK_UNITS];
	static taken things[MOST];
	uint32_t count = 0, steps = TEST_TSAN ? 20000 : 1000000, refused = 0;
	gpu_tlsf tlsf;
	assert_true(gpu_tlsf_create(&tlsf, (uint64_t)BLOCK_UNITS * UNIT));
	for (uint32_t step = 0; step < steps; step++) {
		/* Waves of filling and of emptying. */
		bool take = random_below(8) < (step / 5000 % 2 == 0 ? 5u : 3u);
		if (take && count < MOST) {
			uint32_t bytes = 1 + random_below(random_below(16) == 0 ? 300 * UNIT : 12 * UNIT);
			uint64_t align = random_below(4) == 0 ? UNIT << random_below(7) : 1u << random_below(9), offset;
			uint32_t units = (bytes + UNIT - 1) / UNIT, step_units = align > UNIT ? (uint32_t)(align / UNIT) : 1;
			uint64_t largest = gpu_tlsf_largest(&tlsf) / UNIT;
			uint32_t range = gpu_tlsf_take(&tlsf, bytes, align, &offset);
			if (range == GPU_TLSF_NONE) {
				/* A sixteenth may be missed, where the list that fits by chance is not looked at. */
				assert_true(largest < units + step_units + (units + step_units) / 16 + 1);
				refused++;
				continue;
			}
			assert_int_equal(offset % align, 0);
			taken thing = {range, (uint32_t)(offset / UNIT), units};
			assert_true(thing.first + units <= BLOCK_UNITS);
			for (uint32_t u = 0; u < units; u++) {
				if (owners[thing.first + u] != 0)
					fail_msg("step %u: unit %u is used twice", step, thing.first + u);
				owners[thing.first + u] = 1;
			}
			things[count++] = thing;
		} else if (count > 0) {
			uint32_t which = random_below(count);
			memset(&owners[things[which].first], 0, things[which].count * sizeof *owners);
			gpu_tlsf_give(&tlsf, things[which].range);
			things[which] = things[--count];
		}
		if (step % 97 == 0)
			check_block(&tlsf, owners);
	}
	assert_true(refused > 0);
	while (count > 0)
		gpu_tlsf_give(&tlsf, things[--count].range);
	assert_int_equal(gpu_tlsf_largest(&tlsf), (uint64_t)BLOCK_UNITS * UNIT); /* one hole again */
	assert_int_equal(tlsf.used_ranges, 0);
	gpu_tlsf_finish(&tlsf);
}

static void the_ends_of_a_block(void **state)
{
	(void)state;
	gpu_tlsf tlsf;
	uint64_t offset;
	assert_true(gpu_tlsf_create(&tlsf, UNIT));
	assert_int_equal(gpu_tlsf_take(&tlsf, UNIT + 1, 1, &offset), GPU_TLSF_NONE);
	assert_int_equal(gpu_tlsf_take(&tlsf, UINT64_MAX, 1, &offset), GPU_TLSF_NONE);
	assert_int_equal(gpu_tlsf_take(&tlsf, 1, 2 * UNIT, &offset), GPU_TLSF_NONE);
	uint32_t all = gpu_tlsf_take(&tlsf, UNIT, UNIT, &offset);
	assert_true(all != GPU_TLSF_NONE && offset == 0);
	assert_int_equal(gpu_tlsf_take(&tlsf, 1, 1, &offset), GPU_TLSF_NONE);
	assert_int_equal(gpu_tlsf_largest(&tlsf), 0);
	gpu_tlsf_give(&tlsf, all);
	gpu_tlsf_finish(&tlsf);
}

/* ---- blocks of a driver ------------------------------------------------------------------------------------------ */

typedef struct driver {
	uint64_t blocks, bytes, most_bytes, next, largest_block;
	uint64_t room; /* no more bytes than this; 0: no limit */
} driver;

#define NO_ROOM (-2)
#define NO_MEMORY (-1)

static int32_t driver_make(void *user, uint32_t pool, uint64_t bytes, gpu_memory_handle *handle)
{
	driver *d = user;
	(void)pool;
	if (d->room > 0 && d->bytes + bytes > d->room)
		return NO_ROOM;
	/* The handle tells the size. */
	*handle = (gpu_memory_handle){.memory = ++d->next << 40 | bytes};
	d->blocks++;
	d->bytes += bytes;
	d->most_bytes = d->bytes > d->most_bytes ? d->bytes : d->most_bytes;
	d->largest_block = bytes > d->largest_block ? bytes : d->largest_block;
	return 0;
}

static void driver_drop(void *user, gpu_memory_handle handle)
{
	driver *d = user;
	d->blocks--;
	d->bytes -= handle.memory & (((uint64_t)1 << 40) - 1);
}

static void memory_open(gpu_memory *memory, driver *d)
{
	*d = (driver){0};
	assert_true(gpu_memory_init(memory, (gpu_memory_source){d, driver_make, driver_drop, NO_MEMORY}));
}

static void a_hundred_thousand(void **state)
{
	(void)state;
	enum { COUNT = TEST_TSAN ? 5000 : 100000 };
	static gpu_memory_place places[COUNT];
	static gpu_memory memory;
	driver d;
	memory_open(&memory, &d);
	uint64_t bytes = 0;
	for (uint32_t i = 0; i < COUNT; i++) {
		uint64_t size = (uint64_t)1024 << random_below(8);
		assert_int_equal(gpu_memory_take(&memory, 3 + i % 2, size, 4096, &places[i]), 0);
		bytes += size;
	}
	stilb_gpu_memory_report report = gpu_memory_measure(&memory);
	assert_int_equal(report.allocations, COUNT);
	assert_int_equal(report.used_bytes, bytes);
	assert_int_equal(report.blocks, d.blocks);
	assert_int_equal(report.block_bytes, d.bytes);
	assert_true(d.blocks < 10 + bytes / GPU_MEMORY_BLOCK * 2);
	assert_int_equal(d.largest_block, TEST_TSAN ? d.largest_block : GPU_MEMORY_BLOCK);
	/* Every second one goes: what is free is in pieces. */
	for (uint32_t i = 0; i < COUNT; i += 2)
		gpu_memory_give(&memory, &places[i]);
	report = gpu_memory_measure(&memory);
	assert_true(report.fragmentation > 0.0 && report.fragmentation <= 1.0);
	assert_true(report.largest_free_bytes > 0 && report.largest_free_bytes < report.block_bytes);
	for (uint32_t i = 1; i < COUNT; i += 2)
		gpu_memory_give(&memory, &places[i]);
	report = gpu_memory_measure(&memory);
	assert_int_equal(report.used_bytes, 0);
	assert_true(report.blocks <= 2); /* an empty block of each pool waits for what comes */
	gpu_memory_finish(&memory);
	assert_int_equal(d.blocks, 0);
	assert_int_equal(d.bytes, 0);
}

static void large_things_are_alone(void **state)
{
	(void)state;
	static gpu_memory memory;
	driver d;
	gpu_memory_place large, small, more;
	memory_open(&memory, &d);
	assert_int_equal(gpu_memory_take(&memory, 0, GPU_MEMORY_BLOCK / 2 + 1, 256, &large), 0);
	assert_int_equal(d.bytes, GPU_MEMORY_BLOCK / 2 + 1);
	assert_int_equal(large.offset, 0);
	assert_int_equal(gpu_memory_take(&memory, 0, 100, 256, &small), 0);
	assert_int_equal(d.blocks, 2);
	assert_int_equal(d.bytes, GPU_MEMORY_BLOCK / 2 + 1 + GPU_MEMORY_FIRST_BLOCK);
	/* Another pool shares nothing with it. */
	assert_int_equal(gpu_memory_take(&memory, 1, 100, 256, &more), 0);
	assert_int_equal(d.blocks, 3);
	assert_true(more.handle.memory != small.handle.memory);
	gpu_memory_give(&memory, &large);
	assert_int_equal(d.blocks, 2);
	gpu_memory_give(&memory, &small);
	gpu_memory_give(&memory, &more);
	gpu_memory_give(&memory, &more); /* {0} */
	gpu_memory_finish(&memory);
	assert_int_equal(d.blocks, 0);
}

static void small_heaps_and_full_ones(void **state)
{
	(void)state;
	static gpu_memory memory;
	driver d;
	gpu_memory_place places[16];
	memory_open(&memory, &d);
	gpu_memory_pool_set(&memory, 5, (uint64_t)32 << 20); /* a sixteenth of it: 2 MiB */
	assert_int_equal(gpu_memory_take(&memory, 5, 1000, 256, &places[0]), 0);
	assert_int_equal(d.largest_block, (uint64_t)2 << 20);
	assert_int_equal(gpu_memory_take(&memory, 5, ((uint64_t)1 << 20) + 1, 256, &places[1]), 0);
	assert_int_equal(places[1].block, GPU_TLSF_NONE);
	/* A driver that has little left gives smaller blocks, and says no in the end. */
	d.room = d.bytes + ((uint64_t)1 << 20);
	uint32_t count = 2;
	while (count < 16 && gpu_memory_take(&memory, 7, 300000, 256, &places[count]) == 0)
		count++;
	assert_in_range(count, 4, 15);
	assert_int_equal(gpu_memory_take(&memory, 7, 300000, 256, &places[count]), NO_ROOM);
	assert_int_equal(places[count].bytes, 0);
	while (count > 0)
		gpu_memory_give(&memory, &places[--count]);
	gpu_memory_finish(&memory);
	assert_int_equal(d.bytes, 0);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(random_ranges),
		cmocka_unit_test(the_ends_of_a_block),
		cmocka_unit_test(a_hundred_thousand),
		cmocka_unit_test(large_things_are_alone),
		cmocka_unit_test(small_heaps_and_full_ones),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
