/*
 * trace_check: a strict judge of Chrome trace JSON, for tests. It reads a file as Perfetto, chrome://tracing and
 * speedscope together would want it and reports the first rule that is broken, in words.
 *
 * Rules. The text is JSON (RFC 8259) in UTF-8, no key twice in an object. The top is an object with displayTimeUnit
 * "ns", an array traceEvents and an object otherData (clock, hz, resolution_ns, bias_ns, zone_cost_ns, epoch_ns, the
 * window from begin_ns to end_ns, too_deep, without_ring, events_recorded = events_lost + events_held, zones_written =
 * the number of zones, X and B). Events are M, X, B, E, i, C, s and f, each with its keys; ts and dur have three
 * decimals, or a fourth that is not 0. One process with a name; each thread has one name and one sort index; one thread
 * is "frames"; a thread "<name>: off the CPU" follows the one of that name. Per thread, in file order: times never
 * decrease; a zone lies inside the one that is open when it begins, so parents come before their children; a zone
 * that has a length ends a tenth of a nanosecond or more before the next one begins and before its parent ends
 * (viewers add ts and dur as doubles: speedscope loses zones that touch); an E closes the B it names. On "frames"
 * only frames that do not overlap, and marks with s "g"; on off-CPU threads only "sleeping" and "preempted" that do
 * not overlap. An arrow has one s and one f, of one name and cat, and does not go back in time.
 */
#ifndef STILB_TRACE_CHECK_H
#define STILB_TRACE_CHECK_H

#include <stddef.h>
#include <stdint.h>

/* Zones (X and B) of one name on the threads of one name. */
typedef struct trace_check_count {
	const char *thread;
	const char *name;
	uint64_t zones;
} trace_check_count;

typedef struct trace_check_report {
	char error[256];        /* the first violation; "" when there is none */
	uint64_t zones;         /* X and B, frames left out */
	uint64_t open_zones;    /* B without E */
	uint64_t frames, marks; /* on the thread "frames" */
	uint64_t instants, counters;
	uint64_t flows;
	uint64_t flow_ends_outside; /* s and f that no zone is around */
	uint64_t switches;          /* times off the CPU */
	uint32_t threads;           /* with a name; "frames" and off-CPU threads left out */
	uint64_t events_recorded, events_lost;
	trace_check_count *counts;
	size_t count_count;
	void *memory; /* what the strings above live in */
} trace_check_report;

/* 0: no rule is broken; -1: report->error says which. Fill-in counts hold up to the violation. Finish in both cases. */
int trace_check_text(const char *text, size_t size, trace_check_report *report);
int trace_check_file(const char *path, trace_check_report *report);
void trace_check_finish(trace_check_report *report);

/* Zones of that name on threads of that name; NULL stands for all threads, or all names. */
uint64_t trace_check_zones(const trace_check_report *report, const char *thread, const char *name);

#endif
