/* The simulated caches: who has which line of memory, and what it costs to get it. */
#include "bench/sim/sim_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { WORDS = SIM_CPUS_MAX / 64, OTHERS = 1 << 16 };

typedef struct cpu_set {
	uint64_t word[WORDS];
} cpu_set;

/* A line of memory. All zero: CPU 0 has it, whose thread has set up everything. */
typedef struct line {
	uint64_t busy;      /* until when it is on its way to its owner */
	cpu_set sharers;    /* that can read it, the owner included */
	uint16_t owner;     /* that can write it; the last one to have done so if `shared` */
	bool known, shared; /* known: not as in the beginning; shared: nobody can write it */
	uint32_t transfers; /* since sim_lines_reset */
	uint64_t waited;    /* time spent on these */
	const void *code;   /* that missed last */
	uintptr_t number;   /* address / SIM_LINE, for lines outside the arena */
} line;

static struct {
	const sim_machine *machine;
	uint64_t smt, near, socket, far, rmw, ahead;
	/* For each CPU: those of the same core, cluster and socket. */
	cpu_set core[SIM_CPUS_MAX], cluster[SIM_CPUS_MAX], node[SIM_CPUS_MAX];
	uint64_t stores[SIM_CPUS_MAX]; /* when the stores of each CPU will all have been made */
	/* The line that was last taken from each CPU, and until when it can still use that. */
	struct {
		const line *line;
		uint64_t until;
	} leaving[SIM_CPUS_MAX];
	line *lines;        /* of the arena */
	line other[OTHERS]; /* hash table of lines outside the arena */
} mem;

/* ---- where CPUs are ---------------------------------------------------------------------------------------------- */

sim_place sim_place_of(uint32_t cpu)
{
	const sim_machine *m = mem.machine;
	uint32_t cores = m->cores * m->sockets, core = cpu;
	if (cpu >= cores && cpu < cores * m->threads)
		core = cpu - cores; /* Linux numbers the first threads of all cores first */
	return (sim_place){.core = core, .cluster = core / m->cluster * m->cluster, .socket = core / m->cores};
}

static void set_add(cpu_set *set, uint32_t cpu)
{
	set->word[cpu / 64] |= UINT64_C(1) << cpu % 64;
}

static bool set_has(const cpu_set *set, uint32_t cpu)
{
	return set->word[cpu / 64] >> cpu % 64 & 1;
}

static bool set_meets(const cpu_set *a, const cpu_set *b)
{
	uint64_t both = 0;
	for (int i = 0; i < WORDS; i++)
		both |= a->word[i] & b->word[i];
	return both;
}

/* True if a has CPUs that b has not. */
static bool set_exceeds(const cpu_set *a, const cpu_set *b)
{
	uint64_t more = 0;
	for (int i = 0; i < WORDS; i++)
		more |= a->word[i] & ~b->word[i];
	return more;
}

static void lines_begin(const sim_machine *machine, uint32_t cpus)
{
	size_t size = SIM_ARENA_SIZE / SIM_LINE * sizeof(line);
	if (!mem.lines) {
		mem.lines = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
		if (mem.lines == MAP_FAILED)
			abort();
	}
	line *lines = mem.lines;
	madvise(lines, size, MADV_DONTNEED); /* zero again */
	memset(&mem, 0, sizeof mem);
	mem.lines = lines;
	mem.machine = machine;
	mem.smt = (uint64_t)(machine->smt * 1000.0);
	mem.near = (uint64_t)(machine->near * 1000.0);
	mem.socket = (uint64_t)(machine->socket * 1000.0);
	mem.far = (uint64_t)(machine->far * 1000.0);
	mem.rmw = (uint64_t)(machine->rmw * 1000.0);
	mem.ahead = mem.near;
	for (uint32_t a = 0; a < cpus; a++)
		for (uint32_t b = 0; b < cpus; b++) {
			sim_place p = sim_place_of(a), q = sim_place_of(b);
			if (p.core == q.core) {
				set_add(&mem.core[a], b);
				mem.ahead = a == b ? mem.ahead : mem.smt;
			}
			if (p.cluster == q.cluster && p.socket == q.socket)
				set_add(&mem.cluster[a], b);
			if (p.socket == q.socket)
				set_add(&mem.node[a], b);
		}
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static line *find(const volatile void *at)
{
	uintptr_t address = (uintptr_t)at;
	line *l;
	if (address - SIM_ARENA < SIM_ARENA_SIZE) {
		l = &mem.lines[(address - SIM_ARENA) / SIM_LINE];
	} else {
		uintptr_t number = address / SIM_LINE, i = (number ^ number >> 16) % OTHERS;
		while (mem.other[i].number && mem.other[i].number != number)
			i = (i + 1) % OTHERS;
		l = &mem.other[i];
		l->number = number;
	}
	if (!l->known) {
		l->known = true;
		set_add(&l->sharers, 0);
	}
	return l;
}

/* The time to get the line from the nearest of its sharers. */
static uint64_t nearest(const line *l, uint32_t cpu)
{
	return set_meets(&l->sharers, &mem.core[cpu])      ? mem.smt
	       : set_meets(&l->sharers, &mem.cluster[cpu]) ? mem.near
	       : set_meets(&l->sharers, &mem.node[cpu])    ? mem.socket
	                                                   : mem.far;
}

/* The time to get the line from all of its sharers, which lose it. */
static uint64_t farthest(const line *l, uint32_t cpu)
{
	cpu_set self = {{0}};
	set_add(&self, cpu);
	return set_exceeds(&l->sharers, &mem.node[cpu])      ? mem.far
	       : set_exceeds(&l->sharers, &mem.cluster[cpu]) ? mem.socket
	       : set_exceeds(&l->sharers, &mem.core[cpu])    ? mem.near
	       : set_exceeds(&l->sharers, &self)             ? mem.smt
	                                                     : 0;
}

static bool can_write(const line *l, uint32_t cpu)
{
	return !l->shared && l->owner == cpu;
}

/* Notes a transfer for which a CPU has waited from `begin` to `end`. */
static void note(line *l, uint64_t begin, uint64_t end, const void *code)
{
	sim_count_transfer();
	l->transfers++;
	l->waited += end - begin;
	l->code = code;
}

/* True if the CPU can write, since the request for the line has not arrived there yet. */
static bool is_leaving(const line *l, uint32_t cpu, uint64_t time)
{
	return mem.leaving[cpu].line == l && time <= mem.leaving[cpu].until;
}

/* Asks for the line at `time`; it comes in `cost`. Returns when it is there. It leaves its owner half that time before,
 * so that even when many ask for it, its owner can do something with it. */
static uint64_t request(line *l, uint32_t cpu, uint64_t time, uint64_t cost, const void *code)
{
	uint64_t begin = time > l->busy ? time : l->busy;
	if (!l->shared && l->owner != cpu) {
		mem.leaving[l->owner].line = l;
		mem.leaving[l->owner].until = begin + cost / 2;
	}
	note(l, time, begin + cost, code);
	return begin + cost;
}

/* Takes the line for writing, in a request made at `time`. Returns when it is there. */
static uint64_t take(line *l, uint32_t cpu, uint64_t time, const void *code)
{
	uint64_t cost = farthest(l, cpu), end = cost > 0 ? request(l, cpu, time, cost, code) : time;
	memset(&l->sharers, 0, sizeof l->sharers);
	set_add(&l->sharers, cpu);
	l->owner = (uint16_t)cpu;
	l->shared = false;
	return end;
}

void sim_read(const volatile void *at, const void *code)
{
	if (!sim_running())
		return;
	line *l = find(at);
	uint64_t *clock = sim_clock();
	if (set_has(&l->sharers, sim_cpu()) || is_leaving(l, sim_cpu(), *clock)) {
		sim_turn(mem.ahead);
		return;
	}
	sim_turn(0);
	uint32_t cpu = sim_cpu();
	clock = sim_clock();
	if (set_has(&l->sharers, cpu))
		return;
	*clock = request(l, cpu, *clock, nearest(l, cpu), code);
	set_add(&l->sharers, cpu);
	l->shared = true;
	sim_turn(0); /* the value is that of the time when the line is there */
}

void sim_write(const volatile void *at, const void *code)
{
	if (!sim_running())
		return;
	line *l = find(at);
	bool hit = can_write(l, sim_cpu()) || is_leaving(l, sim_cpu(), *sim_clock());
	sim_turn(hit ? mem.ahead : 0);
	uint32_t cpu = sim_cpu();
	if (hit || can_write(l, cpu))
		return;
	uint64_t end = take(l, cpu, *sim_clock(), code);
	l->busy = end;
	if (mem.stores[cpu] < end)
		mem.stores[cpu] = end;
}

void sim_rmw(const volatile void *at, const void *code)
{
	if (!sim_running())
		return;
	line *l = find(at);
	uint64_t *clock = sim_clock();
	if (*clock < mem.stores[sim_cpu()])
		*clock = mem.stores[sim_cpu()];
	if (can_write(l, sim_cpu()) || is_leaving(l, sim_cpu(), *clock)) {
		*clock += mem.rmw;
		sim_turn(mem.ahead);
		return;
	}
	sim_turn(0);
	uint32_t cpu = sim_cpu();
	clock = sim_clock();
	*clock = take(l, cpu, *clock, code) + mem.rmw;
	l->busy = *clock;
	sim_turn(0); /* it reads and writes when the line is there */
}

void sim_run(const sim_machine *machine, uint32_t cpus, void (*main)(void *), void *data)
{
	lines_begin(machine, cpus);
	sim_core_run(machine, cpus, main, data);
}

/* ---- which lines cost most --------------------------------------------------------------------------------------- */

static size_t lines_in_use(void)
{
	return (sim_arena_end() - SIM_ARENA) / SIM_LINE;
}

void sim_lines_reset(void)
{
	for (size_t i = 0; i < lines_in_use(); i++)
		if (mem.lines[i].known) {
			mem.lines[i].waited = 0;
			mem.lines[i].transfers = 0;
		}
}

void sim_lines_print(uint32_t count)
{
	for (uint64_t below = UINT64_MAX; count > 0; count--) {
		const line *most = NULL;
		for (size_t i = 0; i < lines_in_use(); i++) {
			const line *l = &mem.lines[i];
			if (l->known && l->waited < below && (!most || l->waited > most->waited))
				most = l;
		}
		if (!most || most->waited == 0)
			return;
		below = most->waited;
		printf("    line %#zx: %u transfers, %.1f us in all, the last one by the code at %p\n",
		       (size_t)SIM_ARENA + (size_t)(most - mem.lines) * SIM_LINE, most->transfers, (double)below / 1e6,
		       most->code);
	}
}
