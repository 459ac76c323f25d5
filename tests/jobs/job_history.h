/*
 * job_history: is a recorded run of a concurrent queue linearizable? It is if there is one order of all calls that
 * agrees with real time (a call that returned before another one began comes first), and in which every call returns
 * what a FIFO queue used by one thread would return.
 *
 *   op.begin = history_now();
 *   ... push or pop ...
 *   op.end = history_now();
 *   ...
 *   assert(history_check(ops, count, values) == HISTORY_LINEARISABLE);
 *
 * Method. If each value is pushed once, a run is linearizable exactly if it has none of four violations (Henzinger,
 * Sezgin, Vafeiadis, "Aspect-Oriented Linearizability Proofs", CONCUR 2013). Each is found by sorting, in O(n log n)
 * for n calls; a search for the order takes exponential time in general.
 */
#ifndef JOB_HISTORY_H
#define JOB_HISTORY_H

#include <stddef.h>
#include <stdint.h>

typedef enum history_call {
	HISTORY_PUSH, /* pushed `value` */
	HISTORY_POP,  /* returned `value` */
	HISTORY_EMPTY /* a pop that found the queue empty */
} history_call;

typedef struct history_op {
	uint64_t begin, end; /* history_now() before and after the call */
	uint32_t value;      /* below history_check's value_limit */
	history_call call;
} history_op;

typedef enum history_violation {
	HISTORY_LINEARISABLE,
	HISTORY_FRESH,       /* popped a value that was never pushed, or before its push began */
	HISTORY_REPEATED,    /* popped a value twice, or pushed it twice, which is a mistake of the recording */
	HISTORY_OVERTAKEN,   /* of two successive pushes, the later value was popped before the other, or alone */
	HISTORY_NEVER_EMPTY, /* found the queue empty although it certainly contained a value during the whole call */
	HISTORY_NO_MEMORY    /* not checked: out of memory */
} history_violation;

/* A stamp. Stamps agree with real time over all threads: everything that a thread did before it took a stamp happened
 * before everything that any thread does after it took a later stamp. [any-thread] */
uint64_t history_now(void);

/* Checks a run. All values are below value_limit; the calls may be in any order. [any-thread] */
history_violation history_check(const history_op *ops, size_t count, uint32_t value_limit);

const char *history_violation_name(history_violation violation);

#endif
