/* The simulated threads and CPUs, and the kernel. Lines of memory: sim_lines.c. */
#include "bench/sim/sim_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define NEVER UINT64_MAX
#define STACK_SIZE ((size_t)256 << 10)
#define HEAP_BEGIN (SIM_ARENA + SIM_THREADS_MAX * STACK_SIZE)

typedef struct thread thread;
struct thread {
	char *sp;
	void *(*fn)(void *);
	void *data;
	uint32_t cpu; /* that it runs on, or ran on last, or is bound to */
	bool done;
	const volatile uint32_t *futex; /* that it sleeps on; `sleeping` for other sleeps; NULL: it does not sleep */
	uint64_t timer;                 /* when it wakes up by itself, or NEVER */
	uint64_t ready;                 /* not before this time does it run */
	thread *next;                   /* in its CPU's queue */
};

typedef struct cpu {
	uint64_t clock;
	thread *running;
	thread *first, **end; /* threads that wait for this CPU */
	uint64_t slice_end;   /* when a waiting thread may take the CPU */
	uint32_t place;       /* in the heap plus one; 0: not there */
} cpu;

static struct {
	const sim_machine *machine;
	uint32_t cpu_count, thread_count;
	cpu cpus[SIM_CPUS_MAX];
	thread threads[SIM_THREADS_MAX];
	cpu *heap[SIM_CPUS_MAX]; /* CPUs with threads, without the one that runs, the next to run first */
	uint32_t heap_count;
	uint64_t timer;   /* the first of all threads' timers */
	uint64_t horizon; /* the time of the next thing that is not done by the running thread */
	cpu *now;         /* the CPU of the running thread */
	char *outside;    /* stack pointer of sim_run */
	uintptr_t heap_at;
	sim_counts counts;
} sim;

static const volatile uint32_t sleeping;

static uint64_t ps(double ns)
{
	return (uint64_t)(ns * 1000.0);
}

/* ---- coroutines -------------------------------------------------------------------------------------------------- */

#if defined(__x86_64__)
/* Pushes the registers that a callee must preserve, stores the stack pointer in *save, and continues on the stack
 * `load`. */
void sim_switch(char **save, char *load);
__asm__(".text\n.globl sim_switch\n.type sim_switch,@function\nsim_switch:\n"
        "push %rbp\npush %rbx\npush %r12\npush %r13\npush %r14\npush %r15\n"
        "mov %rsp,(%rdi)\nmov %rsi,%rsp\n"
        "pop %r15\npop %r14\npop %r13\npop %r12\npop %rbx\npop %rbp\nret\n"
        ".size sim_switch,.-sim_switch\n");
#else
#error "the switch between coroutines is written for x86-64"
#endif

/* ---- which CPU is next ------------------------------------------------------------------------------------------- */

/* When the CPU can do something next. */
static uint64_t cpu_time(const cpu *c)
{
	return c->running || c->first->ready < c->clock ? c->clock : c->first->ready;
}

static void heap_put(uint32_t at, cpu *c)
{
	sim.heap[at] = c;
	c->place = at + 1;
}

/* Moves the CPU at this place of the heap up or down to where it belongs. */
static void heap_sift(uint32_t at)
{
	cpu *c = sim.heap[at];
	uint64_t time = cpu_time(c);
	for (; at > 0 && time < cpu_time(sim.heap[(at - 1) / 2]); at = (at - 1) / 2)
		heap_put(at, sim.heap[(at - 1) / 2]);
	for (uint32_t child; (child = 2 * at + 1) < sim.heap_count; at = child) {
		if (child + 1 < sim.heap_count && cpu_time(sim.heap[child + 1]) < cpu_time(sim.heap[child]))
			child++;
		if (time <= cpu_time(sim.heap[child]))
			break;
		heap_put(at, sim.heap[child]);
	}
	heap_put(at, c);
}

static void heap_add(cpu *c)
{
	if (c->place == 0)
		heap_put(sim.heap_count++, c);
	heap_sift(c->place - 1);
}

static void heap_remove(cpu *c)
{
	uint32_t at = c->place - 1;
	cpu *last = sim.heap[--sim.heap_count];
	c->place = 0;
	if (c != last) {
		heap_put(at, last);
		heap_sift(at);
	}
}

static void set_horizon(void)
{
	uint64_t next = sim.heap_count > 0 ? cpu_time(sim.heap[0]) : NEVER;
	sim.horizon = next < sim.timer ? next : sim.timer;
}

/* ---- threads on CPUs --------------------------------------------------------------------------------------------- */

static cpu *cpu_of(const thread *t)
{
	return &sim.cpus[t->cpu];
}

static void enqueue(cpu *c, thread *t)
{
	t->next = NULL;
	*c->end = t;
	c->end = &t->next;
}

static void find_timer(void)
{
	sim.timer = NEVER;
	for (uint32_t i = 0; i < sim.thread_count; i++)
		if (sim.threads[i].futex && sim.threads[i].timer < sim.timer)
			sim.timer = sim.threads[i].timer;
}

/* The thread, which sleeps or is new, may run from `time` on. It goes before the thread that runs on its CPU. */
static void make_ready(thread *t, uint64_t time)
{
	cpu *c = cpu_of(t);
	bool timed = t->timer != NEVER;
	t->futex = NULL;
	t->timer = NEVER;
	t->ready = time;
	if (c->running && c->slice_end > time)
		c->slice_end = time;
	enqueue(c, t);
	if (c != sim.now)
		heap_add(c);
	if (timed)
		find_timer();
	set_horizon();
}

static void fire_timers(void)
{
	uint64_t time = sim.timer;
	for (uint32_t i = 0; i < sim.thread_count; i++) {
		thread *t = &sim.threads[i];
		if (t->futex && t->timer == time)
			make_ready(t, time + ps(sim.machine->latency - sim.machine->wake));
	}
}

/* Gives the CPU, which has no running thread, to the first of those that wait for it. */
static void dispatch(cpu *c)
{
	thread *t = c->first;
	c->clock = cpu_time(c);
	c->first = t->next;
	if (!c->first)
		c->end = &c->first;
	c->running = t;
	c->slice_end = c->clock + ps(sim.machine->timeslice);
}

/* Leaves the running thread's CPU as it is and continues with the CPU that is next. */
static void next_cpu(char **save)
{
	while (sim.timer < (sim.heap_count > 0 ? cpu_time(sim.heap[0]) : NEVER))
		fire_timers();
	if (sim.heap_count == 0) {
		fprintf(stderr, "stilb-bench-sim: every simulated thread sleeps\n");
		abort();
	}
	cpu *c = sim.heap[0];
	heap_remove(c);
	if (!c->running)
		dispatch(c);
	sim.now = c;
	set_horizon();
	if (save != &c->running->sp)
		sim_switch(save, c->running->sp);
}

/* Another thread may be first on this CPU, and other CPUs may be behind this one by more than `ahead`: lets them run.
 * Returns when the calling thread is the next. */
static void turn(uint64_t ahead)
{
	cpu *c = sim.now;
	thread *self = c->running;
	if (c->first && c->clock >= c->slice_end && c->first->ready <= c->clock) {
		self->ready = c->clock;
		enqueue(c, self);
		c->running = NULL;
		c->clock += ps(sim.machine->call);
	} else if (c->clock <= sim.horizon || c->clock - sim.horizon <= ahead) {
		return;
	}
	heap_add(c);
	sim.now = NULL;
	next_cpu(&self->sp);
}

/* The running thread gives up its CPU until another one makes it ready. */
static void block(void)
{
	cpu *c = sim.now;
	thread *self = c->running;
	c->running = NULL;
	if (c->first)
		heap_add(c);
	sim.now = NULL;
	next_cpu(&self->sp);
}

static void thread_entry(void)
{
	thread *self = sim.now->running;
	self->fn(self->data);
	sim_turn(0);
	self->done = true;
	if (self == &sim.threads[0]) {
		sim.now = NULL;
		sim_switch(&self->sp, sim.outside);
	}
	for (uint32_t i = 0; i < sim.thread_count; i++)
		if (sim.threads[i].futex == (const volatile uint32_t *)self)
			make_ready(&sim.threads[i], sim.now->clock + ps(sim.machine->latency));
	block();
	abort();
}

/* Makes a thread on this CPU, to be made ready by the caller. */
static thread *new_thread(void *(*fn)(void *), void *data, uint32_t on)
{
	if (sim.thread_count == SIM_THREADS_MAX) {
		fprintf(stderr, "stilb-bench-sim: too many threads\n");
		abort();
	}
	thread *t = &sim.threads[sim.thread_count++];
	char *top = (char *)SIM_ARENA + sim.thread_count * STACK_SIZE;
	void *entry = (void *)thread_entry;
	top -= 2 * sizeof entry; /* the entry function then sees the stack alignment of a call */
	memcpy(top, &entry, sizeof entry);
	*t = (thread){.sp = top - 6 * sizeof entry, .fn = fn, .data = data, .cpu = on, .timer = NEVER};
	return t;
}

/* ---- a run ------------------------------------------------------------------------------------------------------- */

typedef struct first_thread {
	void (*main)(void *);
	void *data;
} first_thread;

static void *first_main(void *data)
{
	first_thread *first = data;
	first->main(first->data);
	return NULL;
}

void sim_core_run(const sim_machine *machine, uint32_t cpus, void (*main)(void *), void *data)
{
	static bool mapped;
	if (!mapped &&
	    mmap((void *)SIM_ARENA, SIM_ARENA_SIZE, PROT_READ | PROT_WRITE,
	         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE, -1, 0) != (void *)SIM_ARENA) {
		fprintf(stderr, "stilb-bench-sim: cannot map memory at a fixed address\n");
		abort();
	}
	mapped = true;
	madvise((void *)SIM_ARENA, SIM_ARENA_SIZE, MADV_DONTNEED); /* zero again */
	memset(&sim, 0, sizeof sim);
	sim.machine = machine;
	sim.cpu_count = cpus;
	sim.timer = NEVER;
	sim.heap_at = HEAP_BEGIN;
	for (uint32_t i = 0; i < cpus; i++)
		sim.cpus[i].end = &sim.cpus[i].first;
	first_thread first = {main, data};
	make_ready(new_thread(first_main, &first, 0), 0);
	next_cpu(&sim.outside);
	sim.machine = NULL;
}

bool sim_running(void)
{
	return sim.now;
}

const sim_machine *sim_this(void)
{
	return sim.machine;
}

uint32_t sim_cpus(void)
{
	return sim.cpu_count;
}

sim_counts sim_take_counts(void)
{
	sim_counts counts = sim.counts;
	sim.counts = (sim_counts){0};
	return counts;
}

void *sim_allocate(size_t alignment, size_t size)
{
	if (alignment < 16)
		alignment = 16;
	uintptr_t at = (sim.heap_at + alignment - 1) & ~(uintptr_t)(alignment - 1);
	if (at + size > SIM_ARENA + SIM_ARENA_SIZE)
		return NULL;
	sim.heap_at = at + size;
	return (void *)at;
}

uintptr_t sim_arena_end(void)
{
	return sim.heap_at;
}

/* ---- for sim_lines.c --------------------------------------------------------------------------------------------- */

void sim_turn(uint64_t ahead)
{
	turn(ahead);
}

uint64_t *sim_clock(void)
{
	return &sim.now->clock;
}

void sim_count_transfer(void)
{
	sim.counts.transfers++;
}

uint32_t sim_cpu(void)
{
	return (uint32_t)(sim.now - sim.cpus);
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

double sim_now(void)
{
	turn(0);
	return (double)sim.now->clock / 1000.0;
}

void sim_work(double ns)
{
	/* In pieces, between which another thread may take the CPU. */
	for (double piece = 20000.0; ns > 0.0; ns -= piece) {
		sim.now->clock += ps(ns < piece ? ns : piece);
		turn(0);
	}
}

void sim_block(void)
{
	if (sim.now)
		sim.now->clock += ps(sim.machine->block);
}

void sim_function(void)
{
	if (sim.now)
		sim.now->clock += ps(sim.machine->function);
}

void sim_pause(void)
{
	sim.now->clock += ps(sim.machine->pause);
	turn(0);
}

void sim_yield(void)
{
	cpu *c = sim.now;
	c->clock += ps(sim.machine->call);
	c->slice_end = c->clock;
	turn(0);
	sim.now->slice_end = sim.now->clock + ps(sim.machine->timeslice);
}

static void sleep_on(const volatile uint32_t *word, uint64_t timer)
{
	thread *self = sim.now->running;
	self->futex = word;
	self->timer = timer;
	if (timer < sim.timer)
		sim.timer = timer;
	block();
}

void sim_sleep(double ns)
{
	sim.now->clock += ps(sim.machine->sleep);
	turn(0);
	sleep_on(&sleeping, sim.now->clock + ps(ns));
}

/* ---- the kernel -------------------------------------------------------------------------------------------------- */

void sim_futex_wait(const volatile uint32_t *word, uint32_t expected, uint64_t timeout_ns)
{
	sim.now->clock += ps(sim.machine->call);
	turn(0);
	if (*word != expected)
		return;
	uint64_t timer = timeout_ns == UINT64_MAX ? NEVER : sim.now->clock + timeout_ns * 1000;
	sim.now->clock += ps(sim.machine->sleep);
	sleep_on(word, timer);
}

uint32_t sim_futex_wake(const volatile uint32_t *word, uint32_t count)
{
	turn(0);
	uint32_t woken = 0;
	for (uint32_t i = 0; i < sim.thread_count && woken < count; i++) {
		thread *t = &sim.threads[i];
		if (t->futex != word)
			continue;
		make_ready(t, sim.now->clock + ps(sim.machine->latency));
		woken++;
		sim.counts.wakes++;
		sim.now->clock += ps(sim.machine->wake);
	}
	if (woken == 0)
		sim.now->clock += ps(sim.machine->call);
	return woken;
}

void sim_membarrier(void)
{
	sim.now->clock += ps(sim.machine->call + 2 * sim.machine->far);
	turn(0);
}

/* A CPU for a new thread: one without threads if there is one. */
static uint32_t free_cpu(void)
{
	uint32_t loads[SIM_CPUS_MAX] = {0}, best = 0;
	for (uint32_t i = 0; i < sim.thread_count; i++)
		loads[sim.threads[i].cpu] += !sim.threads[i].done;
	for (uint32_t i = 1; i < sim.cpu_count; i++)
		if (loads[i] < loads[best])
			best = i;
	return best;
}

uint32_t sim_thread_create(void *(*fn)(void *), void *data)
{
	sim.now->clock += ps(sim.machine->create);
	turn(0);
	thread *t = new_thread(fn, data, free_cpu());
	make_ready(t, sim.now->clock + ps(sim.machine->latency));
	return sim.thread_count - 1;
}

void sim_thread_join(uint32_t number)
{
	thread *t = &sim.threads[number];
	sim.now->clock += ps(sim.machine->call);
	turn(0);
	if (!t->done)
		sleep_on((const volatile uint32_t *)t, NEVER);
}

uint32_t sim_thread(void)
{
	return (uint32_t)(sim.now->running - sim.threads);
}

/* Takes a thread that is ready but does not run out of its CPU's queue; false if it is not in there. */
static bool unqueue(thread *t)
{
	cpu *c = cpu_of(t);
	thread **link = &c->first;
	while (*link && *link != t)
		link = &(*link)->next;
	if (!*link)
		return false;
	*link = t->next;
	if (!t->next)
		c->end = link;
	if (!c->first && !c->running && c->place > 0)
		heap_remove(c);
	return true;
}

/* A thread that sleeps, or runs on another CPU at this moment, moves when it wakes up next. */
void sim_thread_bind(uint32_t number, uint32_t to)
{
	thread *t = &sim.threads[number];
	sim.now->clock += ps(sim.machine->call);
	turn(0);
	cpu *c = sim.now;
	uint64_t ready = c->clock + ps(sim.machine->latency);
	if (t->cpu == to)
		return;
	bool self = t == c->running, ready_elsewhere = !self && unqueue(t);
	t->cpu = to;
	if (ready_elsewhere)
		make_ready(t, ready > t->ready ? ready : t->ready);
	if (!self)
		return;
	c->running = NULL;
	if (c->first)
		heap_add(c);
	sim.now = NULL;
	make_ready(t, ready);
	next_cpu(&t->sp);
}
