/*
 * farm_crew: machines that talk to each other compute one work. The host, machine 0, gives out units as results come in
 * and computes, too; the others, the guests, send their results to it. In the end the host has all.
 *
 * Life cycle.  On every machine: prepare the work -> stilb_farm_crew_start -> compute what stilb_farm_crew_feed gives
 *              until there is no more -> stilb_farm_crew_end. The host then keeps or saves the whole. A machine that
 *              could not prepare the work starts all the same, with the reason, and the host ends everything by that.
 * Who belongs. Each guest sends its work's identity. If that is not the host's, the host ends everything, and
 *              stilb_farm_crew_trouble names the machine and the difference.
 * Who is lost. Nobody waits for a machine that has gone silent: farm_schedule.h.
 * Threads.     start, end, hold, release: one thread. trouble, the feed: [any-thread]. A thread of the crew's own
 *              talks, a thousand times a second at most, and sleeps between.
 */
#ifndef FARM_CREW_H
#define FARM_CREW_H

#include "farm/farm.h"
#include "farm/farm_link.h"

typedef struct stilb_farm_crew stilb_farm_crew;

typedef struct stilb_farm_crew_desc {
	const stilb_farm_link *link; /* outlives the crew */
	const stilb_farm_work *work; /* outlives the crew; NULL: it could not be prepared, and `trouble` says why */
	const char *trouble;
	uint32_t threads;  /* that compute here */
	double farewell_s; /* how long the host waits for its guests to end; 0: 10 s */
	/* Asks the computation here to end now, since nobody wants its results any more. Called by the crew's thread. */
	void (*stop)(void *user);
	/* Guests: writes what the host may show (times, counts), all since the start. Host: adds more of that, of guests.
	 * Called by the crew's thread. */
	void (*count)(void *user, uint64_t notes[STILB_FARM_NOTES]);
	void *user;
} stilb_farm_crew_desc;

/* STILB_ERROR_MEMORY, STILB_ERROR_THREAD: *out is NULL. */
stilb_result stilb_farm_crew_start(const stilb_farm_crew_desc *desc, stilb_farm_crew **out);

/* Valid until end. Host: those units that are whole already (stilb_farm_work.state) are not given out. */
stilb_farm_feed stilb_farm_crew_feed(stilb_farm_crew *crew);

/* Host: from hold to release no result of a guest is taken over, so that what is there can be written as a
 * checkpoint. */
void stilb_farm_crew_hold(stilb_farm_crew *crew);
void stilb_farm_crew_release(stilb_farm_crew *crew);

/* Host: true if everything ended because a machine does not belong, or failed; text, a line for the user, says so.
 * Guest: never. */
bool stilb_farm_crew_trouble(stilb_farm_crew *crew, char *text, size_t size);

/* True if all units have results (host), or the host has said that it wants no more (guest). */
bool stilb_farm_crew_is_finished(stilb_farm_crew *crew);

/* Host: the number of results that machine was the first to give. */
uint32_t stilb_farm_crew_count(stilb_farm_crew *crew, uint32_t machine);

/* Host: tells the guests to end, and waits until they have said farewell, for some seconds at most. False: some have
 * not; they must be ended by stilb_farm_link.abort. Guest: waits for the host to say so. Frees the crew. Accepts
 * NULL. */
bool stilb_farm_crew_end(stilb_farm_crew *crew);

#endif
