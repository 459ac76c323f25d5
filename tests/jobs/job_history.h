/*
 * job_history: was this recorded run of a concurrent queue linearisable? That is: is there one order of all calls that
 * keeps the order in real time (a call that returned before another was made comes first) and in which every call
 * answers as a FIFO queue used by one thread would?
 *
 * How. With values pushed once each, a run is linearisable exactly if it shows none of four violations (Henzinger,
 * Sezgin, Vafeiadis, "Aspect-Oriented Linearizability Proofs", CONCUR 2013). Each is found by sorting: n log n for a
 * run of n calls, where the search for an order takes exponential time in general.
 */
#ifndef JOB_HISTORY_H
#define JOB_HISTORY_H

#include <stddef.h>
#include <stdint.h>

typedef enum history_call {
	HISTORY_PUSH, /* of value */
	HISTORY_POP,  /* returned value */
	HISTORY_EMPTY /* a pop that found the queue empty */
} history_call;

typedef struct history_op {
	uint64_t begin, end; /* history_now() before the call and after it */
	uint32_t value;      /* below the number of pushes that the run is checked with */
	history_call call;
} history_op;

typedef enum history_violation {
	HISTORY_LINEARISABLE,
	HISTORY_FRESH,       /* popped a value that nobody pushed, or before it was pushed */
	HISTORY_REPEATED,    /* popped a value twice, or pushed it twice: then the run was recorded badly */
	HISTORY_OVERTAKEN,   /* of two values pushed one after the other, the later left before the earlier, or alone */
	HISTORY_NEVER_EMPTY, /* found the queue empty, though there was always something in it meanwhile */
	HISTORY_NO_MEMORY    /* not checked */
} history_violation;

/* A stamp. Stamps agree with real time over all threads: what a thread did before it took one has happened for
 * everybody who takes a later one. [any-thread] */
uint64_t history_now(void);

/* Values are below value_limit; the calls may come in any order. [any-thread] */
history_violation history_check(const history_op *ops, size_t count, uint32_t value_limit);

const char *history_violation_name(history_violation violation);

#endif
