/* The schedule by itself, on simulated clocks: everything is computed, uneven machines end together, and what silent
 * machines hold is computed by others. */
#include "farm/farm_schedule.h"
#include "support/test.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define MOST_MACHINES 8u

typedef struct machine {
	double speed; /* units a second */
	double dies;  /* at that time; 0: never */
	double free;  /* when it is done with its unit */
	uint32_t queue[4096], first, count;
	bool computing;
	uint32_t unit;
} machine;

typedef struct run {
	double end, work; /* when all was there; seconds in which machines computed */
	uint32_t twice;   /* units that were computed for nothing */
	uint32_t counts[MOST_MACHINES];
} run;

/* Lets the machines compute in steps of 1 ms, with messages that take no time. */
static run simulate(uint32_t units, machine *machines, uint32_t count, uint32_t whole)
{
	run r = {0};
	farm_schedule *s = farm_schedule_create(units, count);
	for (uint32_t u = 0; u < whole; u++)
		farm_schedule_whole(s, u * 2);
	double now = 0.001;
	for (; !farm_schedule_is_finished(s); now += 0.001) {
		assert_true(now < 1e4);
		for (uint32_t i = 0; i < count; i++) {
			machine *m = &machines[i];
			if (m->dies > 0.0 && now > m->dies)
				continue;
			if (m->computing && now >= m->free) {
				m->computing = false;
				r.work += 1.0 / m->speed;
				r.twice += !farm_schedule_done(s, i, m->unit, now);
			}
			uint32_t got[64], more = farm_schedule_take(s, i, 1, now, got, 64);
			for (uint32_t k = 0; k < more; k++) {
				assert_true(got[k] < units && (got[k] % 2 == 1 || got[k] / 2 >= whole));
				m->queue[(m->first + m->count++) % 4096] = got[k];
			}
			if (!m->computing && m->count > 0) {
				m->unit = m->queue[m->first++ % 4096];
				m->first %= 4096;
				m->count--;
				m->computing = true;
				m->free = now + 1.0 / m->speed;
			}
		}
	}
	for (uint32_t i = 0; i < count; i++)
		r.counts[i] = farm_schedule_count(s, i);
	r.end = now;
	farm_schedule_destroy(s);
	return r;
}

static uint32_t sum(const run *r)
{
	uint32_t all = 0;
	for (uint32_t i = 0; i < MOST_MACHINES; i++)
		all += r->counts[i];
	return all;
}

static void one_machine_computes_all(void **state)
{
	(void)state;
	static machine m[1];
	m[0] = (machine){.speed = 100.0};
	run r = simulate(500, m, 1, 0);
	assert_int_equal(r.counts[0], 500);
	assert_true(r.end < 500.0 / 100.0 * 1.15); /* steps of 1 ms in units of 10 */
	assert_int_equal(r.twice, 0);
}

static void uneven_machines_end_together(void **state)
{
	(void)state;
	static machine m[4];
	const double speeds[] = {200.0, 100.0, 50.0, 10.0};
	memset(m, 0, sizeof m);
	for (int i = 0; i < 4; i++)
		m[i].speed = speeds[i];
	run r = simulate(3600, m, 4, 0);
	assert_int_equal(sum(&r), 3600);
	assert_true(r.end < 10.0 * 1.25); /* 10 s if nobody ever waited, and the steps */
	for (int i = 0; i < 4; i++) {
		double fair = 3600 * speeds[i] / 360.0;
		assert_true(r.counts[i] > 0.75 * fair && r.counts[i] < 1.4 * fair);
	}
	assert_true(r.twice <= 4);
}

static void what_is_there_is_not_given_out(void **state)
{
	(void)state;
	static machine m[2];
	memset(m, 0, sizeof m);
	m[0].speed = m[1].speed = 100.0;
	run r = simulate(400, m, 2, 150); /* units 0, 2, ..., 298; simulate asserts */
	assert_int_equal(sum(&r), 250);
}

/* Machines that die, with what they hold, at any time: the others compute all of it. */
static void the_dead_cost_their_units(void **state)
{
	(void)state;
	static machine m[4];
	for (double dies = 0.002; dies < 5.0; dies += 0.37) {
		memset(m, 0, sizeof m);
		for (int i = 0; i < 4; i++)
			m[i] = (machine){.speed = 100.0, .dies = i == 3 ? dies : i == 2 ? 2.0 * dies : 0.0};
		run r = simulate(1000, m, 4, 0);
		assert_int_equal(sum(&r), 1000);
		assert_true(r.end < 8.5); /* two machines alone take 5 s; then what the dead hold is waited for */
	}
}

static void results_that_nobody_waits_for(void **state)
{
	(void)state;
	uint32_t units[4];
	farm_schedule *s = farm_schedule_create(4, 2);
	assert_false(farm_schedule_done(s, 1, 2, 0.1)); /* never given out */
	assert_false(farm_schedule_done(s, 1, 4, 0.1)); /* no unit */
	assert_int_equal(farm_schedule_take(s, 0, 4, 0.1, units, 2), 2);
	assert_true(units[0] == 0 && units[1] == 1);
	assert_true(farm_schedule_done(s, 0, 1, 0.2));
	assert_false(farm_schedule_done(s, 0, 1, 0.2)); /* twice */
	farm_schedule_back(s, 0, 0);
	assert_int_equal(farm_schedule_take(s, 1, 4, 0.3, units, 1), 1);
	assert_int_equal(units[0], 0); /* what came back is next */
	assert_false(farm_schedule_is_finished(s));
	farm_schedule_destroy(s);
}

static void when_results_are_sent(void **state)
{
	(void)state;
	double wait = farm_flush_s(2);
	assert_false(farm_flush_is_due(0, 1.0, 0, 1, 2));
	assert_false(farm_flush_is_due(1, 0.9 * wait, 1, 1, 2));
	assert_true(farm_flush_is_due(1, 0.9 * wait, 0, 1, 2)); /* it will run dry */
	assert_true(farm_flush_is_due(1, wait, 9, 1, 2));
	assert_true(farm_flush_is_due(FARM_FLUSH_UNITS, 0.0, 99, 1, 2)); /* they are many */
	assert_true(farm_flush_s(1000) * 20000 >= 1000);                 /* what a host can handle */
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(one_machine_computes_all),       cmocka_unit_test(uneven_machines_end_together),
		cmocka_unit_test(what_is_there_is_not_given_out), cmocka_unit_test(the_dead_cost_their_units),
		cmocka_unit_test(results_that_nobody_waits_for),  cmocka_unit_test(when_results_are_sent),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
