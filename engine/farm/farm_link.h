/*
 * farm_link: messages between the machines of a farm, whatever carries them. Machine 0 is the host; it alone sends to
 * all, and the others send to it alone.
 *
 * Threads.  open and close: the main thread. All others: one thread at a time.
 */
#ifndef FARM_LINK_H
#define FARM_LINK_H

#include "base/base.h"

typedef struct stilb_farm_link {
	uint32_t machine, count; /* this one's number, and how many there are */
	uint32_t neighbours;     /* how many of them run on this computer, with this one */
	char name[64];           /* of this computer, for messages */
	void *user;
	/* Sends a message, later if need be; takes data, which came from malloc, over. Messages of one machine to another
	 * arrive in order. */
	void (*send)(void *user, uint32_t to, void *data, size_t size);
	/* The next message that has arrived, which is free()d by the caller; false: there is none. Never waits for one. */
	bool (*receive)(void *user, uint32_t *from, void **data, size_t *size);
	/* True if all that was sent has left. */
	bool (*is_sent)(void *user);
	/* Ends all machines at once, with that exit code; for when they do not answer. Does not return. */
	void (*abort)(void *user, int code);
	/* Says farewell to the others; all must call it. */
	void (*close)(void *user);
} stilb_farm_link;

/* True if this process was started as one of several, by mpirun. */
bool stilb_farm_link_is_asked(void);

/* After is_asked: true if it was started as the host. It knows before stilb_farm_link_open, so that only one of the
 * processes complains of a command that all were given. */
bool stilb_farm_link_is_host(void);

/* Joins the others. Open MPI is loaded here, by a module of its own that a build may lack. Its mpirun binds a process
 * to one core unless it is told otherwise, which is not for programs with threads: without --bind-to on its command
 * line this process may use all CPUs again. STILB_ERROR_FILE: there is no
 * such module, or it cannot be loaded; STILB_ERROR_DEVICE: Open MPI refuses. [main-thread] */
stilb_result stilb_farm_link_open(stilb_farm_link *link);

/* What the module exports: fills *link, or writes why not. */
#define FARM_MPI_FILE "stilb-farm-mpi.so"
#define FARM_MPI_SYMBOL "stilb_farm_mpi_open"
typedef bool farm_mpi_open_fn(stilb_farm_link *link, char *why, size_t size);

#endif
