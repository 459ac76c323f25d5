/*
 * The two-lock queue in the four steps of Herb Sutter, "Measuring Parallel Performance: Optimizing a Concurrent Queue"
 * (Dr. Dobb's Journal, December 2008), with items that cost something to copy: 10 or 100 strings of 26 characters.
 *
 *   step1  everything is done under the two locks: allocating a node, copying the item in, copying it out; producers
 *          free the nodes that consumers have passed
 *   step2  items are allocated and copied outside the locks: a node holds a pointer to its item
 *   step3  a consumer frees the node that it emptied, so producers no longer touch the front of the list
 *   step4  data of different threads lies on different cache lines: the two ends, their locks, the nodes
 *
 * Written from the article's description, with its spin locks, which have no pause instruction.
 */
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

typedef struct subject_queue {
	struct steps_queue *steps;
} subject_queue;

typedef struct subject_thread {
	struct item *prototype; /* producers push copies of it */
} subject_thread;

#define SUBJECT_BATCH 0
#define QUEUE_LOAD_BACKLOG 4000 /* fewer than for other queues, since items are large */
#include "bench/queue/queue_load.h"

#define LINE 64
#define STRING "abcdefghijklmnopqrstuvwxyz"

/* ---- items ------------------------------------------------------------------------------------------------------- */

typedef struct item {
	void *number; /* the item that queue_load.h pushes, a distinct number by which it verifies the run */
	uint32_t count;
	char *strings[];
} item;

static void *allocate(size_t size)
{
	void *made = malloc(size);
	if (!made)
		bench_child_fail("out of memory");
	return made;
}

static char *string_copy(const char *from)
{
	return memcpy(allocate(sizeof STRING), from, sizeof STRING);
}

static item *item_new(uint32_t count)
{
	item *made = allocate(sizeof *made + count * sizeof *made->strings);
	made->count = count;
	for (uint32_t i = 0; i < count; i++)
		made->strings[i] = string_copy(STRING);
	return made;
}

/* A deep copy. */
static item *item_copy(const item *from)
{
	item *made = allocate(sizeof *made + from->count * sizeof *made->strings);
	made->number = from->number;
	made->count = from->count;
	for (uint32_t i = 0; i < from->count; i++)
		made->strings[i] = string_copy(from->strings[i]);
	return made;
}

static void item_free(item *old)
{
	for (uint32_t i = 0; i < old->count; i++)
		free(old->strings[i]);
	free(old);
}

/* ---- queues ------------------------------------------------------------------------------------------------------ */

/* The article's improvements; each step includes the ones before it. */
typedef enum step { STEP_PLAIN = 1, STEP_SHORT_SECTIONS, STEP_CONSUMER_FREES, STEP_PADDED } step;

typedef struct node {
	item *value;
	struct node *_Atomic next; /* release in append, pairs with the acquire in node_next */
} node;

/* The shared variables lie in one block of memory: in steps 1 to 3 side by side, in step 4 each on its own cache
 * line. */
typedef struct steps_queue {
	step step;
	uint32_t item_strings;
	size_t node_size;
	node **first; /* the oldest node; under the producers' lock in steps 1 and 2, then under the consumers' */
	/* Steps 1 and 2: the last node that consumers emptied. Release in pass, pairs with the acquire in free_emptied. */
	node *_Atomic *divider;
	node **last;                        /* under the producers' lock */
	atomic_bool *consumers, *producers; /* the locks */
} steps_queue;

static void lock(atomic_bool *flag)
{
	while (atomic_exchange_explicit(flag, true, memory_order_acquire)) { /* pairs with unlock */
	}
}

static void unlock(atomic_bool *flag)
{
	atomic_store_explicit(flag, false, memory_order_release); /* pairs with lock */
}

static node *node_new(const steps_queue *queue, item *value)
{
	node *made = allocate(queue->node_size);
	made->value = value;
	atomic_init(&made->next, NULL);
	return made;
}

static void append(steps_queue *queue, node *made)
{
	atomic_store_explicit(&(*queue->last)->next, made, memory_order_release); /* pairs with node_next */
	*queue->last = made;
}

static node *node_next(node *at)
{
	return atomic_load_explicit(&at->next, memory_order_acquire); /* pairs with append */
}

/* Frees the nodes that consumers have passed. The caller holds the producers' lock. */
static void free_emptied(steps_queue *queue)
{
	node *divider = atomic_load_explicit(queue->divider, memory_order_acquire); /* pairs with pass */
	while (*queue->first != divider) {
		node *old = *queue->first;
		*queue->first = node_next(old);
		if (old->value)
			item_free(old->value);
		free(old);
	}
}

/* Makes the emptied node the divider. The caller holds the consumers' lock. */
static void pass(steps_queue *queue, node *emptied)
{
	atomic_store_explicit(queue->divider, emptied, memory_order_release); /* pairs with free_emptied */
}

static void push(steps_queue *queue, const item *from)
{
	if (queue->step == STEP_PLAIN) {
		lock(queue->producers);
		append(queue, node_new(queue, item_copy(from)));
		free_emptied(queue);
		unlock(queue->producers);
		return;
	}
	node *made = node_new(queue, item_copy(from));
	lock(queue->producers);
	append(queue, made);
	if (queue->step == STEP_SHORT_SECTIONS)
		free_emptied(queue);
	unlock(queue->producers);
}

static item *pop_plain(steps_queue *queue)
{
	item *out = NULL;
	lock(queue->consumers);
	node *next =
		node_next(atomic_load_explicit(queue->divider, memory_order_relaxed)); /* relaxed: ordered by the lock */
	if (next) {
		out = item_copy(next->value);
		pass(queue, next);
	}
	unlock(queue->consumers);
	return out;
}

static item *pop(steps_queue *queue)
{
	if (queue->step == STEP_PLAIN)
		return pop_plain(queue);
	bool frees = queue->step >= STEP_CONSUMER_FREES;
	lock(queue->consumers);
	node *old =
		frees ? *queue->first : atomic_load_explicit(queue->divider, memory_order_relaxed); /* ordered by the lock */
	node *next = node_next(old);
	if (!next) {
		unlock(queue->consumers);
		return NULL;
	}
	item *value = next->value;
	next->value = NULL;
	if (frees)
		*queue->first = next;
	else
		pass(queue, next);
	unlock(queue->consumers);
	item *out = item_copy(value); /* in the article, the copy into the caller's variable */
	item_free(value);
	if (frees)
		free(old);
	return out;
}

/* ---- the functions that queue_load.h asks for -------------------------------------------------------------------- */

static void subject_open(subject_queue *subject, const queue_load *load)
{
	static _Alignas(2 * LINE) char memory[8 * LINE];
	steps_queue *queue = allocate(sizeof *queue);
	unsigned number = 0;
	if (sscanf(load->subject, "step%u", &number) != 1 || number < STEP_PLAIN || number > STEP_PADDED)
		bench_child_fail("no step '%s'", load->subject);
	queue->step = (step)number;
	bool padded = queue->step == STEP_PADDED;
	size_t apart = padded ? LINE : sizeof(void *);
	queue->item_strings = strncmp(load->case_name, "large", 5) == 0 ? 100 : 10;
	queue->node_size = padded ? LINE : sizeof(node);
	queue->first = (node **)&memory[0];
	queue->divider = (node * _Atomic *)&memory[apart];
	queue->consumers = (atomic_bool *)&memory[2 * apart];
	queue->last = (node **)&memory[3 * apart];
	queue->producers = (atomic_bool *)&memory[4 * apart];
	*queue->first = *queue->last = node_new(queue, NULL);
	atomic_init(queue->divider, *queue->first);
	subject->steps = queue;
}

static void subject_enter(subject_queue *subject, subject_thread *self, uint32_t thread)
{
	(void)thread;
	self->prototype = item_new(subject->steps->item_strings);
}

static inline bool subject_push(subject_queue *subject, subject_thread *self, void *number)
{
	self->prototype->number = number;
	push(subject->steps, self->prototype);
	return true;
}

static inline bool subject_pop(subject_queue *subject, subject_thread *self, void **number)
{
	(void)self;
	item *out = pop(subject->steps);
	if (!out)
		return false;
	*number = out->number;
	if (memcmp(out->strings[out->count - 1], STRING, sizeof STRING) != 0)
		bench_child_fail("wrong result: a string was damaged");
	item_free(out);
	return true;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
