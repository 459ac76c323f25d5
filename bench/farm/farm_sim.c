#include "bench/farm/farm_sim.h"

#include "farm/farm_schedule.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POLL_S 0.001     /* between two looks for messages, farm_crew.c */
#define SUMS_BYTES 112.0 /* of a pixel */
#define SUPPLY 1024u     /* units in a message at most, farm_crew.c */
#define BASE_UNIT 8.0    /* side of the unit that costs and times are given for */

farm_sim_desc farm_sim_default(void)
{
	return (farm_sim_desc){
		.machines = 1024,
		.cores = 8,
		.width = 3840,
		.height = 2160,
		.unit = 4,
		.samples = 4096,
		.core_samples_s = 0.75e6, /* Cornell box, path: 256 x 256 x 64 samples in 5.5 s of CPU time */
		.cost_sigma = 0.5,
		.latency_s = 50e-6,
		.network_bytes_s = 1.25e9, /* 10 Gbit/s */
		.message_s = 20e-6,
		.unit_s = 6e-6,
		.seed = 1,
	};
}

/* ---- random numbers ---------------------------------------------------------------------------------------------- */

static double sim_uniform(uint64_t seed, uint64_t index)
{
	return ((double)(stilb_random_u64(seed, index) >> 11) + 0.5) * 0x1p-53;
}

/* Box and Muller (1958). */
static double sim_normal(uint64_t seed, uint64_t index)
{
	return sqrt(-2.0 * log(sim_uniform(seed, 2 * index))) * cos(2.0 * M_PI * sim_uniform(seed, 2 * index + 1));
}

/* Mean 1. */
static double sim_lognormal(uint64_t seed, uint64_t index, double sigma)
{
	return exp(sigma * sim_normal(seed, index) - 0.5 * sigma * sigma);
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

typedef enum event_kind {
	EVENT_COMPUTED, /* a core has a result */
	EVENT_FLUSH,    /* a guest looks if it should send */
	EVENT_ARRIVED,  /* a message of results is at the host */
	EVENT_HANDLED,  /* the host has taken it over */
	EVENT_SUPPLIED, /* units are at a guest */
	EVENT_TICK,     /* the host looks for guests that want more */
} event_kind;

typedef struct event {
	double time;
	uint64_t order; /* of events at one time */
	event_kind kind;
	uint32_t machine, unit, count;
	uint32_t *units; /* of messages */
} event;

typedef struct sim_machine {
	double speed, dies;
	uint32_t idle; /* cores */
	uint32_t *queue, queue_first, queue_count, queue_room;
	uint32_t *ready, ready_count, ready_room;
	double sent;          /* when it has sent last */
	bool wants, flushing; /* flushing: an EVENT_FLUSH is on its way */
} sim_machine;

typedef struct sim {
	const farm_sim_desc *desc;
	farm_schedule *schedule;
	sim_machine *machines;
	event *heap;
	size_t heap_count, heap_room;
	uint64_t order;
	double now, host_free;
	uint32_t unit_count, wanting;
	farm_sim_result result;
} sim;

static bool event_before(const event *a, const event *b)
{
	return a->time < b->time || (a->time == b->time && a->order < b->order);
}

static void *sim_grow(void *array, size_t count, size_t size)
{
	array = realloc(array, count * size);
	if (!array)
		abort();
	return array;
}

static void event_push(sim *s, event e)
{
	e.order = s->order++;
	if (s->heap_count == s->heap_room) {
		s->heap_room = s->heap_room ? 2 * s->heap_room : 1024;
		s->heap = sim_grow(s->heap, s->heap_room, sizeof *s->heap);
	}
	size_t at = s->heap_count++;
	for (; at > 0 && event_before(&e, &s->heap[(at - 1) / 2]); at = (at - 1) / 2)
		s->heap[at] = s->heap[(at - 1) / 2];
	s->heap[at] = e;
}

static event event_pop(sim *s)
{
	event first = s->heap[0], last = s->heap[--s->heap_count];
	size_t at = 0;
	for (size_t child; (child = 2 * at + 1) < s->heap_count; at = child) {
		child += child + 1 < s->heap_count && event_before(&s->heap[child + 1], &s->heap[child]);
		if (!event_before(&s->heap[child], &last))
			break;
		s->heap[at] = s->heap[child];
	}
	s->heap[at] = last;
	return first;
}

/* ---- the model --------------------------------------------------------------------------------------------------- */

static bool sim_is_dead(const sim *s, uint32_t machine)
{
	return s->now >= s->machines[machine].dies;
}

static double unit_cost_s(const sim *s, uint32_t unit)
{
	const farm_sim_desc *d = s->desc;
	double pixels = (double)d->unit * d->unit, wider = (double)d->unit / BASE_UNIT;
	/* Neighbours cost about the same, so the spread falls with the side and not with the area. */
	double sigma = d->cost_sigma / sqrt(fmax(wider, 1.0));
	return pixels * d->samples / d->core_samples_s * sim_lognormal(d->seed, unit, sigma);
}

static double message_latency(sim *s)
{
	double chance = -log(sim_uniform(s->desc->seed + 3, s->order));
	return s->desc->latency_s * (1.0 + chance) + POLL_S * sim_uniform(s->desc->seed + 4, s->order);
}

static void core_begin(sim *s, uint32_t machine, uint32_t unit)
{
	sim_machine *m = &s->machines[machine];
	m->idle--;
	event_push(s, (event){.time = s->now + unit_cost_s(s, unit) / m->speed,
	                      .kind = EVENT_COMPUTED,
	                      .machine = machine,
	                      .unit = unit});
}

static void cores_begin(sim *s, uint32_t machine)
{
	sim_machine *m = &s->machines[machine];
	while (m->idle > 0 && m->queue_count > 0) {
		uint32_t unit = m->queue[m->queue_first];
		m->queue_first = (m->queue_first + 1) % m->queue_room;
		m->queue_count--;
		core_begin(s, machine, unit);
	}
}

static void host_begin(sim *s)
{
	uint32_t unit;
	while (s->machines[0].idle > 0 && farm_schedule_take(s->schedule, 0, s->desc->cores, s->now, &unit, 1) == 1)
		core_begin(s, 0, unit);
}

/* A guest sends its results, if that is due. */
static void guest_flush(sim *s, uint32_t machine)
{
	sim_machine *m = &s->machines[machine];
	while (
		farm_flush_is_due(m->ready_count, s->now - m->sent + 1e-9, m->queue_count, s->desc->cores, s->desc->machines)) {
		m->sent = s->now;
		uint32_t count = m->ready_count < FARM_FLUSH_UNITS ? m->ready_count : FARM_FLUSH_UNITS;
		uint32_t *units = sim_grow(NULL, count, sizeof *units);
		memcpy(units, m->ready, count * sizeof *units);
		m->ready_count -= count;
		memmove(m->ready, m->ready + count, m->ready_count * sizeof *m->ready);
		event_push(s, (event){.time = s->now + message_latency(s),
		                      .kind = EVENT_ARRIVED,
		                      .machine = machine,
		                      .count = count,
		                      .units = units});
	}
	if (m->ready_count > 0 && !m->flushing) {
		m->flushing = true;
		double wait = farm_flush_s(s->desc->machines);
		double dry = m->sent + 0.25 * wait, late = m->sent + wait; /* looks at both, as the guest always looks */
		event_push(s, (event){.time = dry > s->now ? dry : late, .kind = EVENT_FLUSH, .machine = machine});
	}
}

static void computed(sim *s, const event *e)
{
	sim_machine *m = &s->machines[e->machine];
	m->idle++;
	if (e->machine == 0) {
		s->result.twice += !farm_schedule_done(s->schedule, 0, e->unit, s->now);
		host_begin(s);
		return;
	}
	if (m->ready_count == m->ready_room) {
		m->ready_room = m->ready_room ? 2 * m->ready_room : 64;
		m->ready = sim_grow(m->ready, m->ready_room, sizeof *m->ready);
	}
	m->ready[m->ready_count++] = e->unit;
	cores_begin(s, e->machine);
	guest_flush(s, e->machine);
}

static void guest_queue(sim *s, uint32_t machine, uint32_t unit)
{
	sim_machine *m = &s->machines[machine];
	if (m->queue_count == m->queue_room) {
		uint32_t room = m->queue_room ? 2 * m->queue_room : 64;
		uint32_t *queue = sim_grow(NULL, room, sizeof *queue);
		for (uint32_t i = 0; i < m->queue_count; i++)
			queue[i] = m->queue[(m->queue_first + i) % m->queue_room];
		free(m->queue);
		m->queue = queue;
		m->queue_first = 0;
		m->queue_room = room;
	}
	m->queue[(m->queue_first + m->queue_count++) % m->queue_room] = unit;
}

/* The host gives a guest units if it wants some. */
static void host_supply(sim *s, uint32_t machine)
{
	uint32_t units[SUPPLY];
	uint32_t count = farm_schedule_take(s->schedule, machine, s->desc->cores, s->now, units, SUPPLY);
	if (count == 0)
		return;
	uint32_t *copy = sim_grow(NULL, count, sizeof *copy);
	memcpy(copy, units, count * sizeof *copy);
	s->machines[machine].wants = false;
	s->wanting--;
	s->result.messages++;
	event_push(s, (event){.time = s->now + message_latency(s),
	                      .kind = EVENT_SUPPLIED,
	                      .machine = machine,
	                      .count = count,
	                      .units = copy});
}

static void host_wants(sim *s, uint32_t machine)
{
	s->wanting += !s->machines[machine].wants;
	s->machines[machine].wants = true;
}

/* The host's network and its thread are one queue. */
static void arrived(sim *s, const event *e)
{
	const farm_sim_desc *d = s->desc;
	double pixels = (double)d->unit * d->unit, base = pixels / (BASE_UNIT * BASE_UNIT);
	double bytes = e->count * pixels * SUMS_BYTES;
	double work = d->message_s + e->count * base * d->unit_s;
	s->result.messages++;
	s->host_free = fmax(s->now, s->host_free) + fmax(bytes / d->network_bytes_s, work);
	event_push(
		s,
		(event){
			.time = s->host_free, .kind = EVENT_HANDLED, .machine = e->machine, .count = e->count, .units = e->units});
}

static void event_run(sim *s, const event *e)
{
	switch (e->kind) {
	case EVENT_COMPUTED:
		if (!sim_is_dead(s, e->machine))
			computed(s, e);
		break;
	case EVENT_FLUSH:
		s->machines[e->machine].flushing = false;
		if (!sim_is_dead(s, e->machine))
			guest_flush(s, e->machine);
		break;
	case EVENT_ARRIVED:
		arrived(s, e);
		return; /* the units go on */
	case EVENT_HANDLED:
		for (uint32_t i = 0; i < e->count; i++)
			s->result.twice += !farm_schedule_done(s->schedule, e->machine, e->units[i], s->now);
		host_wants(s, e->machine);
		host_supply(s, e->machine);
		break;
	case EVENT_SUPPLIED:
		for (uint32_t i = 0; i < e->count && !sim_is_dead(s, e->machine); i++)
			guest_queue(s, e->machine, e->units[i]);
		if (!sim_is_dead(s, e->machine))
			cores_begin(s, e->machine);
		break;
	case EVENT_TICK:
		for (uint32_t i = 1; i < s->desc->machines && s->wanting > 0; i++)
			if (s->machines[i].wants)
				host_supply(s, i);
		host_begin(s);
		event_push(s, (event){.time = s->now + POLL_S, .kind = EVENT_TICK});
		break;
	}
	free(e->units);
}

/* ---- a run ------------------------------------------------------------------------------------------------------- */

static void machines_make(sim *s)
{
	const farm_sim_desc *d = s->desc;
	double work = 0.0, speed = 0.0;
	for (uint32_t u = 0; u < s->unit_count; u++)
		work += unit_cost_s(s, u);
	for (uint32_t i = 0; i < d->machines; i++) {
		sim_machine *m = &s->machines[i];
		*m = (sim_machine){.idle = d->cores, .dies = HUGE_VAL};
		m->speed = d->speed_sigma > 0.0 ? sim_lognormal(d->seed + 1, i, d->speed_sigma) : 1.0;
		speed += m->speed * d->cores;
	}
	double ideal = work / speed, lost = 0.0;
	for (uint32_t i = 1; i < d->machines; i++)
		if (sim_uniform(d->seed + 2, 2 * (uint64_t)i) < d->failing) {
			s->machines[i].dies = ideal * sim_uniform(d->seed + 2, 2 * (uint64_t)i + 1);
			lost += s->machines[i].speed * d->cores * (ideal - s->machines[i].dies);
		}
	/* what the others compute meanwhile and then, all together */
	double left = speed;
	for (uint32_t i = 1; i < d->machines; i++)
		left -= s->machines[i].dies < HUGE_VAL ? s->machines[i].speed * d->cores : 0.0;
	s->result.ideal = ideal + lost / left;
}

farm_sim_result farm_sim_run(const farm_sim_desc *desc)
{
	sim s = {.desc = desc};
	s.unit_count = (desc->width + desc->unit - 1) / desc->unit * ((desc->height + desc->unit - 1) / desc->unit);
	s.schedule = farm_schedule_create(s.unit_count, desc->machines);
	s.machines = calloc(desc->machines, sizeof *s.machines);
	if (!s.schedule || !s.machines)
		abort();
	machines_make(&s);
	for (uint32_t i = 1; i < desc->machines; i++) /* they say hello */
		event_push(&s, (event){.time = message_latency(&s), .kind = EVENT_ARRIVED, .machine = i});
	event_push(&s, (event){.time = 0.0, .kind = EVENT_TICK});
	while (!farm_schedule_is_finished(s.schedule)) {
		event e = event_pop(&s);
		s.now = e.time;
		event_run(&s, &e);
	}
	for (size_t i = 0; i < s.heap_count; i++)
		free(s.heap[i].units);
	for (uint32_t i = 0; i < desc->machines; i++) {
		free(s.machines[i].queue);
		free(s.machines[i].ready);
	}
	s.result.units = s.unit_count;
	s.result.seconds = s.now;
	s.result.efficiency = s.result.ideal / s.now;
	farm_schedule_destroy(s.schedule);
	free(s.machines);
	free(s.heap);
	return s.result;
}
