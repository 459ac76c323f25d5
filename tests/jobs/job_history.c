#include "job_history.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

uint64_t history_now(void)
{
	/* Acquire-release, pairs with itself: a call that has taken its second stamp happened before every call with a
	 * later first stamp. A weaker order would not do, since a push in a store buffer is not finished, and a clock would
	 * need the same fences. */
	static _Atomic uint64_t clock;
	return atomic_fetch_add_explicit(&clock, 1, memory_order_acq_rel);
}

/* An interval of time: of one call, or of several. */
typedef struct span {
	uint64_t begin, end;
} span;

/* The calls that pushed and popped a value. Calls that were not made lie at the end of time. */
typedef struct life {
	span push, pop;
} life;

#define NEVER ((span){UINT64_MAX, UINT64_MAX})

static bool before(span a, span b)
{
	return a.end < b.begin;
}

static history_violation read_lives(const history_op *ops, size_t count, uint32_t value_limit, life *lives)
{
	for (uint32_t i = 0; i < value_limit; i++)
		lives[i] = (life){NEVER, NEVER};
	for (size_t i = 0; i < count; i++) {
		if (ops[i].call == HISTORY_EMPTY)
			continue;
		if (ops[i].value >= value_limit)
			return HISTORY_FRESH;
		span *call = ops[i].call == HISTORY_PUSH ? &lives[ops[i].value].push : &lives[ops[i].value].pop;
		if (call->begin != UINT64_MAX)
			return HISTORY_REPEATED;
		*call = (span){ops[i].begin, ops[i].end};
	}
	for (uint32_t i = 0; i < value_limit; i++)
		if (before(lives[i].pop, lives[i].push))
			return HISTORY_FRESH; /* a value that was never pushed counts as pushed at the end of time */
	return HISTORY_LINEARISABLE;
}

static int by_begin(const void *left, const void *right)
{
	const span *a = left, *b = right;
	return (a->begin > b->begin) - (a->begin < b->begin);
}

static int by_push_begin(const void *left, const void *right)
{
	return by_begin(&((const life *)left)->push, &((const life *)right)->push);
}

static int by_push_end(const void *left, const void *right)
{
	const life *a = left, *b = right;
	return (a->push.end > b->push.end) - (a->push.end < b->push.end);
}

/* True if a later value overtook an earlier one. Walks over the values in the order in which their pushes began, and in
 * parallel over those whose push had ended by then: none of these may have its pop after the end of the first value's
 * pop. */
static bool overtaken(life *lives, life *ended, uint32_t count)
{
	qsort(lives, count, sizeof *lives, by_push_begin);
	qsort(ended, count, sizeof *ended, by_push_end);
	span latest = {0, 0};
	uint32_t next = 0;
	for (uint32_t i = 0; i < count; i++) {
		for (; next < count && before(ended[next].push, lives[i].push); next++)
			if (ended[next].pop.begin > latest.begin)
				latest = ended[next].pop;
		if (before(lives[i].pop, latest))
			return true;
	}
	return false;
}

/* A value is certainly in the queue from the end of its push to the beginning of its pop. Writes the union of these
 * intervals as disjoint intervals in ascending order, and returns their number. A moment at which one ends and the next
 * begins is not covered, since the pop may come before the push there. */
static uint32_t cover(const life *lives, uint32_t count, span *covered)
{
	uint32_t certain = 0, joined = 0;
	for (uint32_t i = 0; i < count; i++)
		if (before(lives[i].push, lives[i].pop))
			covered[certain++] = (span){lives[i].push.end, lives[i].pop.begin};
	qsort(covered, certain, sizeof *covered, by_begin);
	for (uint32_t i = 0; i < certain; i++) {
		span *last = joined ? &covered[joined - 1] : NULL;
		if (!last || covered[i].begin >= last->end)
			covered[joined++] = covered[i];
		else if (covered[i].end > last->end)
			last->end = covered[i].end;
	}
	return joined;
}

/* True if the call lies inside one covered interval. */
static bool never_empty(const span *covered, uint32_t count, const history_op *call)
{
	uint32_t low = 0, high = count; /* the last interval that began before the call */
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (covered[middle].begin < call->begin)
			low = middle + 1;
		else
			high = middle;
	}
	return low > 0 && call->end < covered[low - 1].end;
}

static history_violation check_with(const history_op *ops, size_t count, uint32_t value_limit, life *lives, life *ended,
                                    span *covered)
{
	history_violation violation = read_lives(ops, count, value_limit, lives);
	if (violation != HISTORY_LINEARISABLE)
		return violation;
	for (uint32_t i = 0; i < value_limit; i++)
		ended[i] = lives[i];
	if (overtaken(lives, ended, value_limit))
		return HISTORY_OVERTAKEN;
	uint32_t covers = cover(lives, value_limit, covered);
	for (size_t i = 0; i < count; i++)
		if (ops[i].call == HISTORY_EMPTY && never_empty(covered, covers, &ops[i]))
			return HISTORY_NEVER_EMPTY;
	return HISTORY_LINEARISABLE;
}

history_violation history_check(const history_op *ops, size_t count, uint32_t value_limit)
{
	size_t room = (size_t)value_limit + 1; /* at least 1, since malloc(0) may return NULL */
	life *lives = malloc(room * sizeof *lives), *ended = malloc(room * sizeof *ended);
	span *covered = malloc(room * sizeof *covered);
	history_violation violation = HISTORY_NO_MEMORY;
	if (lives && ended && covered)
		violation = check_with(ops, count, value_limit, lives, ended, covered);
	free(covered);
	free(ended);
	free(lives);
	return violation;
}

const char *history_violation_name(history_violation violation)
{
	static const char *const names[] = {"linearisable", "popped what was not pushed", "popped twice",
	                                    "overtaken",    "found empty, but never was", "out of memory"};
	return names[violation];
}
