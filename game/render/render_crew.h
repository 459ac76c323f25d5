/*
 * offline_crew: a render that mpirun has started on several machines: rank 0 is the host, which reads and writes files,
 * shows progress and has the picture; the others are its guests, which read the scene and compute.
 *
 *   offline_crew_join            the main thread, before the work's thread
 *   offline_crew_begin           the work's thread, when the render is prepared, or has failed
 *   ... stilb_gi_render_run ...
 *   offline_crew_end             the work's thread, after the picture is written
 *   offline_crew_leave           the main thread, at the end
 *
 * A crew of one, as most renders are, is {0}: all of these then do nothing.
 */
#ifndef STILB_RENDER_CREW_H
#define STILB_RENDER_CREW_H

#include "farm/farm_crew.h"
#include "gi/gi_farm.h"

typedef struct offline_crew {
	bool many; /* the link is open */
	stilb_farm_link link;
	/* of the work's thread */
	stilb_farm_crew *crew;
	stilb_farm_work work;
	stilb_gi_render *render;
	bool ended_all; /* all guests have said farewell */
} offline_crew;

/* True on ranks other than 0 of a render that mpirun has started: such a process prints nothing and writes no files. */
bool offline_crew_is_guest(void);

/* Joins the other ranks, if mpirun has started this process. False after a line on stderr. */
bool offline_crew_join(offline_crew *crew);

/* Threads that render here if the user has not said: those of this computer, shared by the ranks on it. */
uint32_t offline_crew_threads(const offline_crew *crew);

/* Begins to render with the others. trouble: NULL, or why this rank cannot; render may be NULL then.
 * STILB_ERROR_MEMORY, STILB_ERROR_THREAD. */
stilb_result offline_crew_begin(offline_crew *crew, stilb_gi_render *render, uint32_t threads, const char *trouble);

/* True if the render ended because a rank does not belong, or failed; text says so. */
bool offline_crew_trouble(offline_crew *crew, char *text, size_t size);

/* While held, no result of other ranks comes into the film. */
void offline_crew_hold(offline_crew *crew);
void offline_crew_release(offline_crew *crew);

/* Writes who computed how much: "3 ranks rendered 34, 33 and 33 % of it". */
void offline_crew_shares(offline_crew *crew, char *text, size_t size);

/* Lets the others go. */
void offline_crew_end(offline_crew *crew);

/* The last word to MPI; ends ranks that do not answer, and then does not return, but ends the program with the code. */
void offline_crew_leave(offline_crew *crew, int code);

#endif
