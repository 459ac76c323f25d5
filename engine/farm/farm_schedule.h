/*
 * farm_schedule: which machine computes which units: who asks gets some, uneven machines get uneven amounts, and what a
 * machine that has gone silent holds is given to others in the end.
 *
 * Amounts.  A machine is kept supplied for FARM_AHEAD_S seconds at the rate at which it has answered so far, so that it
 *           never waits for a message, but it never holds more than half of its fair share of what is left: amounts
 *           fall towards the end, and all machines end together (guided self-scheduling, Polychronopoulos and Kuck
 *           1987, with rates).
 * Silence.  When all units are given out, machines with nothing to do get those that are overdue: that have been out
 *           for twice as long as a machine of the mean rate needs for all that theirs holds. The first result counts;
 *           the other is the same bits.
 * Clock.    The caller's, so that the same code runs on simulated machines (stilb-bench-farm). Nothing that it decides
 *           changes a bit of a result.
 * Threads.  One at a time.
 */
#ifndef FARM_SCHEDULE_H
#define FARM_SCHEDULE_H

#include "base/base.h"

#define FARM_AHEAD_S 0.5

typedef struct farm_schedule farm_schedule;

/* All units are new, and no machine holds any. NULL: no memory. */
farm_schedule *farm_schedule_create(uint32_t units, uint32_t machines);

/* Accepts NULL. */
void farm_schedule_destroy(farm_schedule *schedule);

/* The result of this unit is there already. Before the first take. */
void farm_schedule_whole(farm_schedule *schedule, uint32_t unit);

/* Gives a machine of so many threads some units, `most` at most (>= 1); 0: it has enough, or there is none now.
 * now: seconds. */
uint32_t farm_schedule_take(farm_schedule *schedule, uint32_t machine, uint32_t threads, double now, uint32_t *units,
                            uint32_t most);

/* True if no other machine has been given the unit, too, and not yet back. unit: it was taken. */
bool farm_schedule_is_alone(const farm_schedule *schedule, uint32_t unit);

/* A machine has a result for a unit that it was given, which is not wanted: another one counts. */
void farm_schedule_answer(farm_schedule *schedule, uint32_t machine, double now);

/* A machine has a result for the unit. False: it was there already, or no machine was given it. */
bool farm_schedule_done(farm_schedule *schedule, uint32_t machine, uint32_t unit, double now);

/* A machine gives a unit back without a result. */
void farm_schedule_back(farm_schedule *schedule, uint32_t machine, uint32_t unit);

bool farm_schedule_is_finished(const farm_schedule *schedule);

/* How many results this machine was the first to have. */
uint32_t farm_schedule_count(const farm_schedule *schedule, uint32_t machine);

/* ---- the other side ---------------------------------------------------------------------------------------------- */

#define FARM_FLUSH_UNITS 256u

/* Seconds between two messages of one of so many machines: few enough messages for the host, which handles all. A
 * machine holds what it computes in twice that time. */
double farm_flush_s(uint32_t machines);

/* True if a machine that holds `queued` units besides those its threads compute, and has `ready` results, sends these
 * now, `passed` seconds after its last message: sooner if it runs dry. */
bool farm_flush_is_due(uint32_t ready, double passed, uint32_t queued, uint32_t threads, uint32_t machines);

#endif
