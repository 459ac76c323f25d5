#include "farm/farm_schedule.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_FOR_THREAD 2u /* units for each thread of a machine whose rate is unknown */
#define OVERDUE 2.0         /* times the time that a machine needs for all it holds */
#define OVERDUE_LOOKS 4096u /* units that are looked at, the oldest, when machines ask for what others are late with */
#define UNIT_COPIES 4u      /* machines that have a unit at the same time, at most */
#define SPARE 2.0           /* times farm_flush_s: a machine has units for so long besides those its threads compute */
#define FLUSH_LEAST_S 0.01
#define FLUSH_MACHINE_S 40e-6 /* the host's time for a message of each machine, with room for it to compute */
#define FLUSH_DRY 0.75
#define QUIET_S 0.01 /* nothing was overdue: nobody looks again before */

typedef struct schedule_unit {
	uint32_t machines[UNIT_COPIES]; /* [copies] that have it, each once: else two threads of one computed it at once */
	uint32_t copies;                /* how often it was given out and not back */
	float since;                    /* when it was given out last, to the last of them */
	bool done, listed;              /* listed: in the array out */
} schedule_unit;

typedef struct schedule_machine {
	uint32_t held; /* units that it was given, without a result */
	uint32_t done, firsts;
	double began, rate; /* results a second; 0: unknown */
} schedule_machine;

struct farm_schedule {
	uint32_t unit_count, machine_count, left; /* left: units without a result */
	uint32_t next;                            /* the first unit that was never given out */
	uint32_t out_first, out_count;            /* of the array out */
	uint32_t back_count;
	double rate;  /* of all machines together */
	double quiet; /* until then nothing is overdue */
	schedule_unit *units;
	schedule_machine *machines;
	uint32_t *out;  /* [unit_count] units that were given out, the oldest first */
	uint32_t *back; /* [unit_count] units that were given back */
};

farm_schedule *farm_schedule_create(uint32_t units, uint32_t machines)
{
	STILB_ASSERT(units > 0 && machines > 0);
	farm_schedule *s = calloc(1, sizeof *s);
	if (!s)
		return NULL;
	s->unit_count = s->left = units;
	s->machine_count = machines;
	s->units = calloc(units, sizeof *s->units);
	s->machines = calloc(machines, sizeof *s->machines);
	s->out = malloc(units * sizeof *s->out);
	s->back = malloc(units * sizeof *s->back);
	if (s->units && s->machines && s->out && s->back)
		return s;
	farm_schedule_destroy(s);
	return NULL;
}

void farm_schedule_destroy(farm_schedule *s)
{
	if (!s)
		return;
	free(s->units);
	free(s->machines);
	free(s->out);
	free(s->back);
	free(s);
}

void farm_schedule_whole(farm_schedule *s, uint32_t unit)
{
	STILB_ASSERT(unit < s->unit_count && !s->units[unit].done && s->next == 0);
	s->units[unit].done = true;
	s->left--;
}

/* ---- giving out -------------------------------------------------------------------------------------------------- */

/* Units that were never given out, and those that came back; some of the first may be done already. */
static uint32_t units_fresh(const farm_schedule *s)
{
	return s->unit_count - s->next + s->back_count;
}

/* How many more units the machine should hold. */
static uint32_t units_wanted(const farm_schedule *s, const schedule_machine *m, uint32_t threads)
{
	double share = m->rate > 0.0 && s->rate > 0.0 ? m->rate / s->rate : 1.0 / s->machine_count;
	double ahead = m->rate * FARM_AHEAD_S + threads; /* what its threads compute now is no supply */
	if (m->rate <= 0.0)
		ahead = (double)FIRST_FOR_THREAD * threads;
	double most = 0.5 * share * units_fresh(s);
	double least = threads + floor(m->rate * SPARE * farm_flush_s(s->machine_count) + 0.5);
	double wanted = fmax(fmin(ahead, most), least) - m->held;
	return wanted < 1.0 ? 0 : wanted < (double)UINT32_MAX ? (uint32_t)wanted : UINT32_MAX;
}

static void give(farm_schedule *s, uint32_t machine, uint32_t unit, double now)
{
	schedule_unit *u = &s->units[unit];
	STILB_ASSERT(u->copies < UNIT_COPIES);
	u->machines[u->copies++] = machine;
	u->since = (float)now;
	s->machines[machine].held++;
	if (u->listed)
		return;
	STILB_ASSERT(s->out_count < s->unit_count);
	u->listed = true;
	s->out[(s->out_first + s->out_count++) % s->unit_count] = unit;
}

/* True if a machine of the mean rate, or this one if it is faster, would have computed all it holds twice by now. A
 * slow one loses the unit to another that has nothing to do. */
static bool is_overdue(const farm_schedule *s, const schedule_unit *u, double now)
{
	const schedule_machine *m = &s->machines[u->machines[u->copies - 1]];
	double rate = fmax(m->rate, s->rate / s->machine_count);
	return rate > 0.0 && now - (double)u->since > OVERDUE * (m->held + 1) / rate;
}

/* The next unit that nobody computes. False: there is none. */
static bool fresh_next(farm_schedule *s, uint32_t *unit)
{
	while (s->back_count > 0) {
		*unit = s->back[--s->back_count];
		if (!s->units[*unit].done)
			return true;
	}
	while (s->next < s->unit_count) {
		*unit = s->next++;
		if (!s->units[*unit].done)
			return true;
	}
	return false;
}

/* Takes what is done off the list of what is out, so that the rest is found soon. */
static void out_compact(farm_schedule *s)
{
	uint32_t kept = 0;
	for (uint32_t i = 0; i < s->out_count; i++) {
		uint32_t unit = s->out[(s->out_first + i) % s->unit_count];
		if (!s->units[unit].done)
			s->out[(s->out_first + kept++) % s->unit_count] = unit;
	}
	s->out_count = kept;
}

static bool has_unit(const schedule_unit *u, uint32_t machine)
{
	for (uint32_t i = 0; i < u->copies; i++)
		if (u->machines[i] == machine)
			return true;
	return false;
}

/* A unit that is overdue elsewhere. */
static bool overdue_next(farm_schedule *s, uint32_t machine, double now, uint32_t *unit)
{
	if (now < s->quiet)
		return false;
	if (s->out_count / 2 > s->left)
		out_compact(s);
	for (uint32_t i = 0; i < s->out_count && i < OVERDUE_LOOKS; i++) {
		*unit = s->out[(s->out_first + i) % s->unit_count];
		const schedule_unit *u = &s->units[*unit];
		bool may = !u->done && u->copies > 0 && u->copies < UNIT_COPIES && !has_unit(u, machine);
		if (may && is_overdue(s, u, now))
			return true;
	}
	s->quiet = now + QUIET_S;
	return false;
}

uint32_t farm_schedule_take(farm_schedule *s, uint32_t machine, uint32_t threads, double now, uint32_t *units,
                            uint32_t most)
{
	STILB_ASSERT(machine < s->machine_count && threads >= 1 && most >= 1);
	schedule_machine *m = &s->machines[machine];
	if (s->left == 0)
		return 0;
	if (m->began == 0.0)
		m->began = now > 0.0 ? now : DBL_MIN;
	uint32_t wanted = units_wanted(s, m, threads), count = 0;
	wanted = wanted < most ? wanted : most;
	while (count < wanted && fresh_next(s, &units[count]))
		give(s, machine, units[count++], now);
	/* without anything to do: at most a unit for each thread of what others are late with */
	while (units_fresh(s) == 0 && m->held < threads && count < most && overdue_next(s, machine, now, &units[count]))
		give(s, machine, units[count++], now);
	return count;
}

bool farm_schedule_is_alone(const farm_schedule *s, uint32_t unit)
{
	STILB_ASSERT(unit < s->unit_count && s->units[unit].copies > 0);
	return s->units[unit].copies == 1;
}

/* ---- coming back ------------------------------------------------------------------------------------------------- */

void farm_schedule_answer(farm_schedule *s, uint32_t machine, double now)
{
	STILB_ASSERT(machine < s->machine_count);
	schedule_machine *m = &s->machines[machine];
	m->held -= m->held > 0;
	m->done++;
	double spent = now - m->began;
	if (spent <= 0.0)
		return;
	s->rate -= m->rate;
	m->rate = m->done / spent;
	s->rate += m->rate;
}

bool farm_schedule_done(farm_schedule *s, uint32_t machine, uint32_t unit, double now)
{
	if (unit >= s->unit_count || s->units[unit].copies == 0)
		return false;
	farm_schedule_answer(s, machine, now);
	if (s->units[unit].done)
		return false;
	s->units[unit].done = true;
	s->left--;
	s->machines[machine].firsts++;
	return true;
}

void farm_schedule_back(farm_schedule *s, uint32_t machine, uint32_t unit)
{
	STILB_ASSERT(machine < s->machine_count && unit < s->unit_count && s->units[unit].copies > 0);
	schedule_unit *u = &s->units[unit];
	s->machines[machine].held--;
	uint32_t place = 0;
	while (place + 1 < u->copies && u->machines[place] != machine)
		place++;
	u->copies--;
	memmove(&u->machines[place], &u->machines[place + 1], (u->copies - place) * sizeof *u->machines);
	if (!u->done && u->copies == 0)
		s->back[s->back_count++] = unit;
}

bool farm_schedule_is_finished(const farm_schedule *s)
{
	return s->left == 0;
}

uint32_t farm_schedule_count(const farm_schedule *s, uint32_t machine)
{
	STILB_ASSERT(machine < s->machine_count);
	return s->machines[machine].firsts;
}

double farm_flush_s(uint32_t machines)
{
	return FLUSH_LEAST_S + machines * FLUSH_MACHINE_S;
}

bool farm_flush_is_due(uint32_t ready, double passed, uint32_t queued, uint32_t threads, uint32_t machines)
{
	double wait = farm_flush_s(machines) * (queued < threads ? FLUSH_DRY : 1.0);
	return ready > 0 && (ready >= FARM_FLUSH_UNITS || passed >= wait);
}
