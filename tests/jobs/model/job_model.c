#include "job_model.h"

#include <assert.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
	THREADS_MAX = 4,
	STACK_SIZE = 16 << 10,
	CELL_SIZE = 64,
	CELLS = 8,
	LARGE_SIZE = 8192,
	CLEARED = 1024 /* bytes */
};

model_fault model_fault_now;
int model_planted;

typedef enum status { UNUSED, READY, IN_FUTEX, IN_JOIN, IN_BLOCK, STOPPED, DONE } status;

/* A store that waits to become visible to other threads. */
typedef struct store {
	void *word;
	uint64_t value;
	uint32_t size;
	bool release;
} store;

/* What a READY thread waits for before its next step: its own buffer has room, holds no store to `word`, is empty. */
typedef enum wish { ANYTHING, ROOM, NONE_TO_WORD, EMPTY } wish;

typedef struct thread {
	char *sp;
	status status;
	wish wish;
	uint32_t value;            /* for IN_BLOCK */
	const volatile void *word; /* for IN_FUTEX, IN_BLOCK and NONE_TO_WORD */
	uint64_t target;           /* for IN_JOIN */
	void *(*fn)(void *);
	void *data;
	const char *what; /* name of the next step, for traces */
	int line;
	uint32_t stores;            /* number of stores in the buffer */
	store buffer[MODEL_BUFFER]; /* oldest first */
} thread;

/* The checker saves and restores states of the program under test. This is the part of a state besides the threads'
 * stacks and the scenario's data. */
static struct world {
	thread threads[THREADS_MAX];
	uint32_t count;
	uint32_t cells_used; /* a bit for each cell */
	uint32_t large_used;
	_Alignas(128) char cell[CELLS][CELL_SIZE];
	char large[LARGE_SIZE]; /* the last member: only its used part is saved and compared */
} world;

static _Alignas(128) char stacks[THREADS_MAX][STACK_SIZE];
static int current = -1;    /* the coroutine that runs; -1: the checker */
static model_memory memory; /* of the scenario */
static bool asserting;      /* inside an assert's condition, in which loads are no steps */
static char *checker_sp;
static const char *failure;

/* ---- coroutines ---------------------------------------------------------------------------------------------- */

#if defined(__x86_64__)
bool model_available(void)
{
	return true;
}

/* Pushes the registers that a callee must preserve, stores the stack pointer in *save, and continues on the stack
 * `load`. */
void model_switch(char **save, char *load);
__asm__(".text\n.globl model_switch\n.type model_switch,@function\nmodel_switch:\n"
        "push %rbp\npush %rbx\npush %r12\npush %r13\npush %r14\npush %r15\n"
        "mov %rsp,(%rdi)\nmov %rsi,%rsp\n"
        "pop %r15\npop %r14\npop %r13\npop %r12\npop %rbx\npop %rbp\nret\n"
        ".size model_switch,.-model_switch\n");
#else
bool model_available(void)
{
	return false;
}

static void model_switch(char **save, char *load)
{
	(void)save;
	(void)load;
	abort();
}
#endif

static void to_checker(void)
{
	model_switch(&world.threads[current].sp, checker_sp);
}

static void thread_entry(void)
{
	thread *self = &world.threads[current];
	self->fn(self->data);
	self->status = DONE;
	to_checker();
	abort();
}

void model_fail(const char *why)
{
	failure = why;
	if (current < 0)
		return;
	to_checker();
	abort();
}

/* ---- operations ---------------------------------------------------------------------------------------------- */

/* The index of the part of size bytes that contains the address, if size bytes at base are cut into equal parts; else
 * -1. */
static int part_of(const volatile void *address, const void *base, size_t size, size_t part)
{
	size_t offset = (uintptr_t)address - (uintptr_t)base; /* wraps around to a large number for addresses below base */
	return offset < size ? (int)(offset / part) : -1;
}

static int cell_of(const volatile void *address)
{
	return part_of(address, world.cell, sizeof world.cell, CELL_SIZE);
}

/* True if the word is in freed memory, or on the stack of a function that has returned. */
static bool word_dead(const volatile void *word)
{
	int cell = cell_of(word), owner = part_of(word, stacks, sizeof stacks, STACK_SIZE);
	if (cell >= 0)
		return !(world.cells_used >> cell & 1);
	if (owner < 0)
		return false;
	const char *at = (const char *)(uintptr_t)word;
	return owner != current && (world.threads[owner].status == DONE || at < world.threads[owner].sp);
}

void model_assert_begin(void)
{
	asserting = true;
}

void model_assert_end(bool holds, const char *condition)
{
	asserting = false;
	if (!holds)
		model_fail(condition);
}

/* Stops before an operation on the word, which may be NULL. */
static void stop_before(const volatile void *word, const char *what, int line, wish wanted)
{
	if (current < 0 || asserting)
		return;
	thread *self = &world.threads[current];
	self->what = what;
	self->line = line;
	self->wish = wanted;
	self->word = wanted == NONE_TO_WORD ? word : NULL;
	to_checker();
	self->wish = ANYTHING;
	self->word = NULL;
	if (word && word_dead(word))
		model_fail("operation on dead memory");
}

void model_step(const volatile void *word, const char *what, int line)
{
	stop_before(word, what, line, ANYTHING);
}

/* ---- store buffers -------------------------------------------------------------------------------------------- */

/* The newest store of the first `stores` in the buffer that is to this word; NULL if there is none. */
static store *store_to(thread *t, const volatile void *word, uint32_t stores)
{
	while (stores > 0 && t->buffer[stores - 1].word != word)
		stores--;
	return stores > 0 ? &t->buffer[stores - 1] : NULL;
}

/* True if store i of the buffer may drain before the older ones. */
static bool may_drain(thread *t, uint32_t i)
{
	return i == 0 ||
	       (i < t->stores && memory == MODEL_PSO && !t->buffer[i].release && !store_to(t, t->buffer[i].word, i));
}

static void drain(thread *t, uint32_t i)
{
	store first = t->buffer[i];
	if (word_dead(first.word)) {
		model_fail("a store drains into dead memory");
		return;
	}
	memcpy(first.word, &first.value, first.size);
	t->stores--;
	memmove(&t->buffer[i], &t->buffer[i + 1], (t->stores - i) * sizeof first);
	memset(&t->buffer[t->stores], 0, sizeof first); /* equal states are equal bytes */
}

static void drain_all(thread *t)
{
	while (t->stores > 0)
		drain(t, 0);
}

static store *own_store(const volatile void *word)
{
	return current >= 0 ? store_to(&world.threads[current], word, world.threads[current].stores) : NULL;
}

void model_load_begin(const volatile void *word, int line)
{
	model_step(word, "load", line); /* also if the value is in the thread's buffer: it may spin until that drains */
}

void *model_load(const volatile void *word)
{
	store *own = own_store(word);
	return own ? (void *)&own->value : (void *)(uintptr_t)word;
}

static bool buffered(memory_order order)
{
	return current >= 0 && memory != MODEL_SC && order != memory_order_seq_cst;
}

void model_store_begin(volatile void *word, memory_order order, int line)
{
	if (!buffered(order))
		stop_before(word, "store", line, EMPTY);
	else if (world.threads[current].stores == MODEL_BUFFER)
		stop_before(word, "store", line, ROOM);
	else if (word_dead(word)) /* no step: other threads see nothing of the store yet */
		model_fail("operation on dead memory");
}

void model_store(volatile void *word, size_t size, uint64_t value, memory_order order)
{
	void *at = (void *)(uintptr_t)word;
	if (!buffered(order)) {
		memcpy(at, &value, size);
		return;
	}
	thread *self = &world.threads[current];
	if (self->stores == MODEL_BUFFER)
		model_fail("more stores than the buffer holds");
	self->buffer[self->stores++] = (store){at, value, (uint32_t)size, order != memory_order_relaxed};
}

void model_rmw(volatile void *word, const char *what, memory_order order, int line)
{
	bool release = order != memory_order_relaxed && order != memory_order_acquire;
	stop_before(word, what, line, release || memory == MODEL_TSO ? EMPTY : NONE_TO_WORD);
}

void model_barrier(void)
{
	if (world.threads[current].stores > 0)
		stop_before(NULL, "barrier", 0, EMPTY);
}

void model_membarrier(void)
{
	model_step(NULL, "membarrier", 0);
	for (uint32_t i = 0; i < world.count; i++)
		drain_all(&world.threads[i]);
}

/* ---- threads, locks and memory -------------------------------------------------------------------------------- */

void model_spawn(void *(*fn)(void *), void *data)
{
	if (world.count == THREADS_MAX)
		model_fail("too many threads");
	if (current >= 0)
		drain_all(&world.threads[current]); /* the new thread sees what this one has stored */
	char *top = stacks[world.count] + STACK_SIZE;
	memset(stacks[world.count], 0, STACK_SIZE);
	void *entry = (void *)thread_entry;
	top -= 2 * sizeof entry; /* the entry function then sees the stack alignment of a call */
	memcpy(top, &entry, sizeof entry);
	world.threads[world.count++] =
		(thread){.sp = top - 6 * sizeof entry, .status = READY, .fn = fn, .data = data, .what = "start"};
}

void model_futex_wait(_Atomic uint32_t *word, uint32_t expected)
{
	stop_before(word, "futex_wait", 0, EMPTY);
	if (*word != expected)
		return;
	world.threads[current].status = IN_FUTEX;
	world.threads[current].word = word;
	to_checker();
}

void model_futex_wake_one(_Atomic uint32_t *word)
{
	stop_before(NULL, "futex_wake", 0, EMPTY); /* uses only the address: the memory may be freed */
	if (model_fault_now == MODEL_FAULT_NO_WAKE)
		return;
	for (uint32_t i = 0; i < world.count; i++) {
		if (world.threads[i].status == IN_FUTEX && world.threads[i].word == word) {
			world.threads[i].status = READY;
			world.threads[i].word = NULL;
			return;
		}
	}
}

void model_block_until(const uint32_t *word, uint32_t value)
{
	world.threads[current].status = IN_BLOCK;
	world.threads[current].word = word;
	world.threads[current].value = value;
	world.threads[current].what = "block";
	to_checker();
	world.threads[current].status = READY;
	world.threads[current].word = NULL;
}

int model_thread_create(pthread_t *created, void *(*fn)(void *), void *data)
{
	model_step(NULL, "create", 0);
	*created = world.count;
	model_spawn(fn, data);
	return 0;
}

int model_thread_join(pthread_t target)
{
	world.threads[current].status = IN_JOIN;
	world.threads[current].target = (uint64_t)target;
	world.threads[current].what = "join";
	to_checker();
	world.threads[current].status = READY;
	world.threads[current].target = 0;
	return 0;
}

pthread_t model_thread_self(void)
{
	return (pthread_t)current;
}

/* Small blocks are cells; the lowest free one is used first, so that freed memory is reused at once. */
static void *take_cell(void)
{
	for (uint32_t i = 0; i < CELLS; i++) {
		if (!(world.cells_used >> i & 1)) {
			world.cells_used |= 1u << i;
			return world.cell[i];
		}
	}
	model_fail("no memory left in the model");
	return NULL;
}

void *model_aligned_alloc(size_t alignment, size_t size)
{
	if (size <= CELL_SIZE && alignment <= CELL_SIZE)
		return take_cell();
	uint32_t begin = (world.large_used + (uint32_t)alignment - 1) / (uint32_t)alignment * (uint32_t)alignment;
	if (begin + size > LARGE_SIZE)
		model_fail("no memory left in the model");
	world.large_used = begin + (uint32_t)size;
	return world.large + begin;
}

void *model_malloc(size_t size)
{
	return model_aligned_alloc(_Alignof(max_align_t), size);
}

void model_free(void *block)
{
	int i = cell_of(block);
	if (i < 0)
		return; /* large blocks are not reused */
	if (current >= 0)
		drain_all(&world.threads[current]);
	if (!(world.cells_used >> i & 1))
		model_fail("freed twice");
	world.cells_used &= ~(1u << i);
	memset(world.cell[i], 0xdd, CELL_SIZE);
}

uint32_t model_heap_blocks(void)
{
	return (uint32_t)__builtin_popcount(world.cells_used);
}

/* ---- states -------------------------------------------------------------------------------------------------- */

typedef struct frame { /* a state on the path from the first state to the current one */
	char *saved;
	uint32_t state;
	uint32_t choices; /* those that are still to be tried, a bit for each: see choice_enabled */
	int chosen;       /* the choice that led to the next frame */
} frame;

typedef struct edge {
	uint32_t from, to;
} edge;

typedef struct seen {
	uint64_t key; /* hash of the state; 0: a free place */
	uint32_t state;
} seen;

static struct search {
	const model_scenario *scenario;
	seen *table;       /* hash table, at most half full; it grows with the states, so that few pages are touched */
	size_t table_size; /* a power of two */
	uint32_t states;
	char *ends_well; /* for each state: true if the end of the run can be reached from it */
	edge *edges;
	size_t edge_count, edge_space;
	frame *path;
	size_t path_count, path_space;
	bool at_top; /* the state of the last frame is the current one */
	uint32_t depth;
} search;

static void *grow(void *array, size_t *space, size_t needed, size_t item)
{
	if (needed <= *space)
		return array;
	*space = needed * 2 + 1024;
	array = realloc(array, *space * item);
	if (!array)
		abort();
	return array;
}

/* Two words with one multiplication of 64 bits by 64. */
static uint64_t hash_pair(uint64_t hash, const char *bytes)
{
	uint64_t word[2];
	memcpy(word, bytes, sizeof word);
	__extension__ unsigned __int128 product =
		(unsigned __int128)(word[0] ^ 0x9e3779b97f4a7c15u) * (hash ^ word[1] ^ 0xa0761d6478bd642fu);
	return (uint64_t)product ^ (uint64_t)(product >> 64);
}

/* Eight hashes side by side, since one alone waits for each multiplication; unrolled, they stay in registers. */
static uint64_t hash_bytes(uint64_t hash, const char *bytes, size_t size)
{
	enum { LANES = 8, PAIR = 2 * sizeof(uint64_t) };
	uint64_t lane[LANES];
	size_t at = 0;
#pragma GCC unroll 8
	for (size_t i = 0; i < LANES; i++)
		lane[i] = hash + i;
	for (; size - at >= LANES * PAIR; at += LANES * PAIR) {
#pragma GCC unroll 8
		for (size_t i = 0; i < LANES; i++)
			lane[i] = hash_pair(lane[i] + at, bytes + at + i * PAIR);
	}
	for (size_t i = 0, step; at < size; i++, at += step) {
		char last[PAIR] = {0};
		step = size - at < PAIR ? size - at : PAIR;
		memcpy(last, bytes + at, step);
		lane[i % LANES] = hash_pair(lane[i % LANES] + at, last);
	}
	for (size_t i = 0; i < LANES; i += 2)
		hash = hash_pair(hash, (const char *)&lane[i]);
	return hash;
}

static size_t world_used(void)
{
	return offsetof(struct world, large) + world.large_used;
}

static size_t stack_used(uint32_t i)
{
	const thread *t = &world.threads[i];
	return t->status == DONE ? 0 : (size_t)(stacks[i] + STACK_SIZE - t->sp);
}

static uint64_t state_hash(void)
{
	uint64_t hash = hash_bytes(0x5851f42d4c957f2du, (const char *)&world, world_used());
	hash = hash_bytes(hash, search.scenario->data, search.scenario->data_size);
	for (uint32_t i = 0; i < world.count; i++)
		hash = hash_bytes(hash, stacks[i] + STACK_SIZE - stack_used(i), stack_used(i));
	return hash ? hash : 1;
}

static char *state_save(void)
{
	size_t size = world_used() + search.scenario->data_size;
	for (uint32_t i = 0; i < world.count; i++)
		size += stack_used(i);
	char *saved = malloc(size), *at = saved;
	if (!saved)
		abort();
	memcpy(at, &world, world_used());
	at += world_used();
	memcpy(at, search.scenario->data, search.scenario->data_size);
	at += search.scenario->data_size;
	for (uint32_t i = 0; i < world.count; i++) {
		memcpy(at, stacks[i] + STACK_SIZE - stack_used(i), stack_used(i));
		at += stack_used(i);
	}
	return saved;
}

static void state_restore(const char *at)
{
	memcpy(&world, at, offsetof(struct world, large));
	at += offsetof(struct world, large);
	memcpy(world.large, at, world.large_used);
	at += world.large_used;
	memcpy(search.scenario->data, at, search.scenario->data_size);
	at += search.scenario->data_size;
	for (uint32_t i = 0; i < world.count; i++) {
		memcpy(stacks[i] + STACK_SIZE - stack_used(i), at, stack_used(i));
		at += stack_used(i);
	}
}

/* The place of a key, or the free one where it belongs. */
static seen *table_find(uint64_t key)
{
	size_t i = key & (search.table_size - 1);
	while (search.table[i].key && search.table[i].key != key)
		i = (i + 1) & (search.table_size - 1);
	return &search.table[i];
}

static void table_grow(void)
{
	seen *old = search.table;
	size_t count = search.table_size;
	search.table_size = count > 0 ? 2 * count : 1024;
	search.table = calloc(search.table_size, sizeof *search.table);
	if (!search.table)
		abort();
	for (size_t i = 0; i < count; i++)
		if (old[i].key)
			*table_find(old[i].key) = old[i];
	free(old);
}

/* The number of the state with this key; *fresh is set if it was not seen before. */
static uint32_t state_number(uint64_t key, bool *fresh)
{
	if (2 * (size_t)search.states >= search.table_size)
		table_grow();
	seen *place = table_find(key);
	*fresh = !place->key;
	if (*fresh)
		*place = (seen){key, search.states++};
	return place->state;
}

/* ---- search -------------------------------------------------------------------------------------------------- */

static bool wish_granted(thread *t)
{
	switch (t->wish) {
	case ROOM:
		return t->stores < MODEL_BUFFER;
	case NONE_TO_WORD:
		return !store_to(t, t->word, t->stores);
	case EMPTY:
		return t->stores == 0;
	default:
		return true;
	}
}

static bool thread_enabled(thread *t)
{
	switch (t->status) {
	case READY:
		return wish_granted(t);
	case IN_JOIN:
		return world.threads[t->target].status == DONE && world.threads[t->target].stores == 0;
	case IN_BLOCK:
		return t->stores == 0 && *(const volatile uint32_t *)t->word == t->value;
	default:
		return false;
	}
}

/* A choice is a thread and what happens to it: choice % world.count and choice / world.count. */
enum { RUNS, STOPS, DRAINS, WHATS = DRAINS + MODEL_BUFFER }; /* runs; stops for ever; store i drains: DRAINS + i */
static_assert(WHATS * THREADS_MAX <= 32, "frame.choices has a bit for each");

static bool choice_enabled(uint32_t choice)
{
	uint32_t i = choice % world.count, what = choice / world.count;
	thread *t = &world.threads[i];
	if (what == RUNS)
		return thread_enabled(t);
	if (what == STOPS)
		return (search.scenario->may_stop >> i & 1) && t->status == READY;
	return t->stores > 0 && may_drain(t, what - DRAINS);
}

static uint32_t choices_enabled(void)
{
	uint32_t choices = 0;
	for (uint32_t choice = 0; choice < WHATS * world.count; choice++)
		choices |= (uint32_t)choice_enabled(choice) << choice;
	return choices;
}

static bool run_over(void)
{
	if (search.scenario->main_ends_all)
		return world.threads[0].status == DONE;
	for (uint32_t i = 0; i < world.count; i++)
		if ((world.threads[i].status != DONE && world.threads[i].status != STOPPED) || world.threads[i].stores > 0)
			return false;
	return true;
}

static void path_push(uint32_t state)
{
	search.path = grow(search.path, &search.path_space, search.path_count + 1, sizeof *search.path);
	search.path[search.path_count++] =
		(frame){.saved = state_save(), .state = state, .choices = choices_enabled(), .chosen = -1};
	search.at_top = true;
	if (search.path_count > search.depth)
		search.depth = (uint32_t)search.path_count;
}

/* Adds the state that was just reached to the path. */
static void state_visit(uint32_t from, bool first)
{
	bool fresh = false, enabled = false;
	uint32_t state = state_number(state_hash(), &fresh);
	if (!first) {
		search.edges = grow(search.edges, &search.edge_space, search.edge_count + 1, sizeof *search.edges);
		search.edges[search.edge_count++] = (edge){from, state};
	}
	if (!fresh)
		return;
	if (search.states >= search.scenario->max_states) {
		failure = "more states than allowed";
		return;
	}
	for (uint32_t i = 0; i < world.count; i++)
		enabled |= thread_enabled(&world.threads[i]) || world.threads[i].stores > 0;
	if (run_over()) {
		search.ends_well[state] = 1;
		if (search.scenario->check)
			search.scenario->check();
	} else if (!enabled) {
		failure = "nobody can go on: lost wake-up or deadlock";
	} else {
		path_push(state);
	}
}

static void thread_run(int i)
{
	/* What functions that have returned left on the stack is no part of the state, but would get into it in the holes
	 * of later frames: equal states would differ. */
	size_t free_size = (size_t)(world.threads[i].sp - stacks[i]);
	size_t cleared = free_size < CLEARED ? free_size : CLEARED;
	memset(world.threads[i].sp - cleared, 0, cleared);
	current = i;
	model_switch(&checker_sp, world.threads[i].sp);
	current = -1;
}

static void choice_take(uint32_t choice)
{
	uint32_t i = choice % world.count, what = choice / world.count;
	if (what == RUNS)
		thread_run((int)i);
	else if (what == STOPS)
		world.threads[i].status = STOPPED;
	else
		drain(&world.threads[i], what - DRAINS);
}

/* Makes one step of the depth-first search. False if the path is empty. */
static bool search_turn(void)
{
	if (search.path_count == 0)
		return false;
	frame *top = &search.path[search.path_count - 1];
	if (top->choices == 0) {
		free(top->saved);
		search.path_count--;
		search.at_top = false;
		return true;
	}
	if (!search.at_top)
		state_restore(top->saved);
	search.at_top = false;
	uint32_t from = top->state, choice = (uint32_t)__builtin_ctz(top->choices);
	top->choices &= top->choices - 1;
	top->chosen = (int)choice;
	choice_take(choice);
	if (!failure)
		state_visit(from, false);
	return true;
}

/* Marks every state from which the end can be reached, by walking over all edges backwards until nothing changes. The
 * edges of a depth-first search are nearly in the best order, so a few rounds are enough. */
static bool all_end_well(void)
{
	for (bool changed = true; changed;) {
		changed = false;
		for (size_t i = search.edge_count; i-- > 0;) {
			const edge *e = &search.edges[i];
			changed |= search.ends_well[e->to] && !search.ends_well[e->from];
			search.ends_well[e->from] |= search.ends_well[e->to];
		}
	}
	return !memchr(search.ends_well, 0, search.states);
}

static void print_choice(uint32_t choice)
{
	uint32_t i = choice % world.count, what = choice / world.count;
	const thread *t = &world.threads[i];
	if (what == RUNS)
		fprintf(stderr, "  %u %s:%d\n", i, t->what, t->line);
	else if (what == STOPS)
		fprintf(stderr, "  %u stops for ever\n", i);
	else
		fprintf(stderr, "  %u's store of %#llx drains into %p\n", i, (unsigned long long)t->buffer[what - DRAINS].value,
		        t->buffer[what - DRAINS].word);
}

static void print_path(void)
{
	fprintf(stderr, "model: %s, after\n", failure);
	for (size_t i = 0; i < search.path_count; i++) {
		state_restore(search.path[i].saved);
		if (search.path[i].chosen >= 0)
			print_choice((uint32_t)search.path[i].chosen);
	}
}

static void search_begin(const model_scenario *scenario)
{
	memset(&search, 0, sizeof search);
	memset(&world, 0, sizeof world);
	memset(scenario->data, 0, scenario->data_size);
	failure = NULL;
	current = -1;
	memory = scenario->memory;
	search.scenario = scenario;
	search.ends_well = calloc(scenario->max_states + 1, 1);
	if (!search.ends_well)
		abort();
}

static void search_end(void)
{
	while (search.path_count > 0)
		free(search.path[--search.path_count].saved);
	free(search.path);
	free(search.edges);
	free(search.ends_well);
	free(search.table);
}

static void *main_entry(void *data)
{
	(void)data;
	search.scenario->main();
	return NULL;
}

model_arguments model_arguments_of(int argc, char **argv)
{
	static const char *const names[] = {[MODEL_SC] = "sc", [MODEL_TSO] = "tso", [MODEL_PSO] = "pso"};
	model_arguments arguments = {.memory = MODEL_PSO, .must_fail = argc > 1 && strcmp(argv[1], "must-fail") == 0};
	if (argc > 2)
		for (arguments.memory = MODEL_SC; strcmp(argv[2], names[arguments.memory]) != 0; arguments.memory++)
			if (arguments.memory == MODEL_PSO)
				abort();
	if (argc > 3)
		model_planted = atoi(argv[3]);
	if (argc > 4)
		arguments.scenario = argv[4];
	return arguments;
}

bool model_chosen(const model_arguments *arguments, const char *scenario)
{
	return !arguments->scenario || strcmp(arguments->scenario, scenario) == 0;
}

/* Runs on the stack of the coroutine that has crashed, which never continues. */
static void crashed(int number)
{
	if (current < 0)
		abort();
	(void)number;
	model_fail("crashed");
}

model_result model_run(const model_scenario *scenario, bool trace)
{
	struct sigaction catch = {.sa_handler = crashed, .sa_flags = SA_NODEFER}, before;
	sigaction(SIGSEGV, &catch, &before);
	search_begin(scenario);
	model_spawn(main_entry, NULL);
	state_visit(0, true);
	while (!failure && search_turn())
		;
	if (failure && trace)
		print_path();
	if (!failure && !all_end_well())
		failure = "states from which the end cannot be reached: livelock";
	model_result result = {failure, search.states, (uint32_t)search.edge_count, search.depth};
	search_end();
	sigaction(SIGSEGV, &before, NULL);
	return result;
}
