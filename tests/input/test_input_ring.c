/* input_ring, the queue of reports: records come out in order and whole, and as many fit as its capacity allows. */
#include "input/device/input_ring_internal.h"
#include "support/test.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#define CAPACITY 1024u
#define LONGEST 300u

/* Record `number` as it is pushed: its size and its bytes follow from its number. */
static uint32_t make(uint64_t number, uint8_t bytes[LONGEST])
{
	uint32_t size = (uint32_t)(stilb_random_u64(1, number) % (LONGEST + 1));
	for (uint32_t i = 0; i < size; i++)
		bytes[i] = (uint8_t)(number + i);
	return size;
}

static bool push(input_ring *ring, uint64_t number)
{
	uint8_t bytes[LONGEST];
	uint32_t size = make(number, bytes);
	return input_ring_push(ring, (int64_t)number, ~number, bytes, size);
}

static bool is_record(const input_record *record, uint64_t number)
{
	uint8_t bytes[LONGEST];
	uint32_t size = make(number, bytes);
	return record->time_us == (int64_t)number && record->flow == ~number && record->size == size &&
	       memcmp(record->bytes, bytes, size) == 0;
}

/* Compares the ring with a model of it: the number of records in the queue and their lengths. */
static void it_is_a_queue_of_whole_records(void **state)
{
	(void)state;
	input_ring ring;
	uint64_t pushed = 0, popped = 0, used = 0;
	assert_int_equal(input_ring_init(&ring, CAPACITY, LONGEST), 0);
	assert_null(input_ring_peek(&ring));
	for (uint64_t step = 0; step < 200000; step++) {
		uint8_t bytes[LONGEST];
		/* For 1000 steps pushes are more likely, so that the ring is mostly full, for the next 1000 pops. */
		if (stilb_random_u64(2, step) % 100 < (step / 1000 % 2 ? 70 : 30)) {
			uint64_t length = (sizeof(input_record) + make(pushed, bytes) + 7) / 8 * 8;
			bool fits = used + length <= CAPACITY;
			assert_int_equal(push(&ring, pushed), fits);
			pushed += fits;
			used += fits ? length : 0;
		} else if (pushed > popped) {
			const input_record *record = input_ring_peek(&ring);
			assert_true(record && is_record(record, popped));
			assert_ptr_equal(input_ring_peek(&ring), record);
			used -= (sizeof(input_record) + record->size + 7) / 8 * 8;
			input_ring_pop(&ring);
			popped++;
		} else {
			assert_null(input_ring_peek(&ring));
		}
	}
	assert_in_range(pushed, 10000, 200000);
	input_ring_finish(&ring);
}

#define MANY 30000u

static void *push_many(void *user)
{
	for (uint64_t i = 0; i < MANY; i++)
		while (!push(user, i))
			sched_yield();
	return NULL;
}

static void two_threads_agree(void **state)
{
	(void)state;
	input_ring ring;
	pthread_t reader;
	assert_int_equal(input_ring_init(&ring, CAPACITY, LONGEST), 0);
	assert_int_equal(pthread_create(&reader, NULL, push_many, &ring), 0);
	for (uint64_t i = 0; i < MANY; i++) {
		const input_record *record;
		while (!(record = input_ring_peek(&ring)))
			sched_yield();
		assert_true(is_record(record, i));
		input_ring_pop(&ring);
	}
	assert_null(input_ring_peek(&ring));
	pthread_join(reader, NULL);
	input_ring_finish(&ring);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(it_is_a_queue_of_whole_records),
		cmocka_unit_test(two_threads_agree),
	};
	return cmocka_run_group_tests_name("input_ring", tests, NULL, NULL);
}
