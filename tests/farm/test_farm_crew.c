/* Crews of threads in one process: the host has every result, whatever machines, threads and losses there are. */
#include "farm/farm_crew.h"
#include "farm_local.h"
#include "support/test.h"

#include <string.h>
#include <time.h>

#define UNITS 300u

/* The work: unit u has the result {u * u + 1}; one that was begun has {u} and goes on from there. */
typedef struct squares {
	uint64_t results[UNITS];
	_Atomic uint32_t computed; /* relaxed: read after all threads have ended */
	_Atomic bool stop;         /* relaxed: a thread that sees it late computes one unit more */
	_Atomic uint64_t others;   /* relaxed: read after the crew has ended */
} squares;

static stilb_farm_state squares_state(void *user, uint32_t unit)
{
	uint64_t result = ((squares *)user)->results[unit];
	return result == 0 ? STILB_FARM_NEW : result == unit && unit > 0 ? STILB_FARM_BEGUN : STILB_FARM_WHOLE;
}

static void squares_get(void *user, uint32_t unit, void *result)
{
	memcpy(result, &((squares *)user)->results[unit], 8);
}

static bool squares_set(void *user, uint32_t unit, const void *result, bool whole)
{
	uint64_t number;
	memcpy(&number, result, sizeof number);
	if (whole != (number == (uint64_t)unit * unit + 1))
		return false;
	((squares *)user)->results[unit] = number;
	return true;
}

static void squares_stop(void *user)
{
	atomic_store_explicit(&((squares *)user)->stop, true, memory_order_relaxed);
}

static void host_count(void *user, uint64_t notes[STILB_FARM_NOTES])
{
	atomic_fetch_add_explicit(&((squares *)user)->others, notes[0], memory_order_relaxed);
}

static void guest_count(void *user, uint64_t notes[STILB_FARM_NOTES])
{
	notes[0] = atomic_load_explicit(&((squares *)user)->computed, memory_order_relaxed);
}

/* One machine. */
typedef struct member {
	local_farm *farm;
	uint32_t number, threads, slow; /* slow: the first of so many units of it take 1 ms each */
	uint32_t dies;                  /* after so many units it is cut off; 0: never */
	const char *identity, *trouble; /* trouble: it has no work */
	squares squares;
	stilb_farm_feed feed;
	pthread_t thread;
	double farewell_s;
	bool all; /* of end */
	char said[256];
	uint32_t begun_here; /* units that were computed from what was begun */
	uint32_t count;      /* host: its own results */
} member;

static void *compute(void *data)
{
	member *m = data;
	squares *s = &m->squares;
	while (!atomic_load_explicit(&s->stop, memory_order_relaxed)) {
		uint32_t unit;
		stilb_farm_taken taken = m->feed.take(m->feed.user, &unit);
		if (taken == STILB_FARM_NO_MORE)
			return NULL;
		if (taken == STILB_FARM_LATER ||
		    (m->dies && atomic_load_explicit(&s->computed, memory_order_relaxed) >= m->dies)) {
			nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
			continue;
		}
		uint32_t number = atomic_fetch_add_explicit(&s->computed, 1, memory_order_relaxed) + 1;
		if (number <= m->slow)
			nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
		s->results[unit] = (uint64_t)unit * unit + 1;
		m->feed.done(m->feed.user, unit);
		if (number == m->dies)
			atomic_store_explicit(&m->farm->machines[m->number].cut, true, memory_order_relaxed);
	}
	return NULL;
}

static void *member_main(void *data)
{
	member *m = data;
	stilb_farm_link link = local_link(m->farm, m->number);
	stilb_farm_work work = {.identity = m->identity,
	                        .unit_count = UNITS,
	                        .unit_size = 8,
	                        .state = squares_state,
	                        .get = squares_get,
	                        .set = squares_set,
	                        .user = &m->squares};
	stilb_farm_crew_desc desc = {.link = &link,
	                             .work = m->trouble ? NULL : &work,
	                             .trouble = m->trouble,
	                             .threads = m->threads,
	                             .farewell_s = m->farewell_s,
	                             .stop = squares_stop,
	                             .count = m->number == 0 ? host_count : guest_count,
	                             .user = &m->squares};
	stilb_farm_crew *crew;
	if (stilb_farm_crew_start(&desc, &crew) != STILB_OK)
		return NULL;
	pthread_t threads[8];
	if (!m->trouble) {
		m->feed = stilb_farm_crew_feed(crew);
		for (uint32_t i = 0; i < m->threads; i++)
			pthread_create(&threads[i], NULL, compute, m);
		for (uint32_t i = 0; i < m->threads; i++)
			pthread_join(threads[i], NULL);
	}
	if (m->number == 0) {
		stilb_farm_crew_hold(crew);
		stilb_farm_crew_release(crew);
		stilb_farm_crew_trouble(crew, m->said, sizeof m->said);
		m->count = stilb_farm_crew_count(crew, 0);
	}
	m->all = stilb_farm_crew_end(crew);
	return NULL;
}

static member members[LOCAL_MOST];

static void members_make(uint32_t count, uint32_t threads)
{
	memset(members, 0, sizeof members);
	for (uint32_t i = 0; i < count; i++)
		members[i] =
			(member){.number = i, .threads = 1 + (i + threads) % 3, .slow = 40, .identity = "version 1\nseed 5\n"};
}

/* Runs the members to their end; those that die are let go by the host's patience alone. */
static void members_run(uint32_t count)
{
	local_farm farm;
	local_make(&farm, count);
	for (uint32_t i = 0; i < count; i++) {
		members[i].farm = &farm;
		pthread_create(&members[i].thread, NULL, member_main, &members[i]);
	}
	for (uint32_t i = 0; i < count; i++)
		pthread_join(members[i].thread, NULL);
	local_finish(&farm);
}

static void host_has_all(void)
{
	for (uint32_t u = 0; u < UNITS; u++)
		assert_true(members[0].squares.results[u] == (uint64_t)u * u + 1);
	assert_string_equal(members[0].said, "");
}

static void any_machines_and_threads(void **state)
{
	(void)state;
	for (uint32_t count = 1; count <= 5; count++)
		for (uint32_t threads = 0; threads < 2; threads++) {
			members_make(count, threads);
			members[0].slow = count > 1 ? UNITS : 0; /* so that guests have begun before it has all */
			members_run(count);
			host_has_all();
			assert_true(members[0].all);
			uint64_t guests = 0;
			for (uint32_t i = 1; i < count; i++)
				guests += atomic_load(&members[i].squares.computed);
			assert_true(atomic_load(&members[0].squares.others) == guests); /* every note has arrived, once */
			assert_true(count == 1 || (guests > 0 && members[0].count < UNITS));
			assert_true(members[0].count + guests >= UNITS);
		}
}

/* What is whole is not computed again, and what is begun goes along. */
static void goes_on(void **state)
{
	(void)state;
	members_make(3, 0);
	for (uint32_t u = 0; u < UNITS; u++)
		members[0].squares.results[u] = u % 3 == 0 ? (uint64_t)u * u + 1 : u % 3 == 1 ? u : 0;
	members[0].squares.results[1] = 2; /* unit 1 looks begun and whole alike: 1 * 1 + 1 */
	members_run(3);
	host_has_all();
	uint32_t computed = 0;
	for (int i = 0; i < 3; i++)
		computed += atomic_load(&members[i].squares.computed);
	assert_in_range(computed, UNITS - 102, UNITS - 100 + 10); /* 100 and unit 1 were whole; a few may be done twice */
}

/* A machine that goes silent with what it holds: the others compute that. It is missed at the farewell. */
static void a_lost_machine_costs_its_units(void **state)
{
	(void)state;
	members_make(3, 0);
	members[2].dies = 30;
	members[0].farewell_s = 0.3;
	members[2].slow = UNITS;
	members[0].slow = members[1].slow = UNITS;
	members_run(3);
	host_has_all();
	assert_false(members[0].all);
}

static void refused(uint32_t machine, const char *identity, const char *trouble, const char *said)
{
	members_make(3, 0);
	members[machine].identity = identity;
	members[machine].trouble = trouble;
	for (int i = 0; i < 3; i++)
		members[i].slow = UNITS;
	members_run(3);
	if (!strstr(members[0].said, said))
		fail_msg("'%s', not '%s'", members[0].said, said);
	assert_true(members[0].all); /* and everybody has ended */
}

static void who_does_not_belong(void **state)
{
	(void)state;
	refused(1, "version 1\nseed 6\n", NULL, "rank 1 (m1) has seed 6, not 5 as rank 0");
	refused(2, "version 1\nbinary 4\nseed 5\n", NULL, "rank 2 (m2) runs another build of the program");
	refused(2, "version 1\nscene 4\nseed 5\n", NULL, "rank 2 (m2) has another scene in that file");
	refused(1, "version 1\nseed 5\nisa sse2\n", NULL,
	        "rank 1 (m1) has isa sse2, not  as rank 0; give all the same --isa");
	refused(1, "", "cannot read 'a.gltf': no such file", "rank 1 (m1): cannot read 'a.gltf': no such file");
}

/* A host without work lets its guests go. */
static void a_host_that_cannot(void **state)
{
	(void)state;
	members_make(3, 0);
	members[0].trouble = "cannot read 'a.gltf'";
	members_run(3);
	assert_true(members[0].all);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(any_machines_and_threads),
		cmocka_unit_test(goes_on),
		cmocka_unit_test(who_does_not_belong),
		cmocka_unit_test(a_host_that_cannot),
		cmocka_unit_test(a_lost_machine_costs_its_units),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
