/*
 * farm_mpi: messages by Open MPI. A module of its own, so that the program loads MPI only where mpirun has started it.
 *
 * Nothing here waits in MPI, whose waits spin: who has nothing to do sleeps between two looks (farm_crew.c).
 */
#include "farm/farm_link.h"

#include <limits.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

#define MPI_LARGEST (1 << 30) /* bytes of one message; a larger one would be the caller's error */

/* A message that is on its way. */
typedef struct mpi_sending {
	struct mpi_sending *next;
	MPI_Request request;
	void *data;
} mpi_sending;

static mpi_sending *mpi_sendings;

/* Frees what has left. */
static void mpi_clean(void)
{
	for (mpi_sending **at = &mpi_sendings; *at;) {
		mpi_sending *sending = *at;
		int sent = 0;
		MPI_Test(&sending->request, &sent, MPI_STATUS_IGNORE);
		if (!sent) {
			at = &sending->next;
			continue;
		}
		*at = sending->next;
		free(sending->data);
		free(sending);
	}
}

static void mpi_send(void *user, uint32_t to, void *data, size_t size)
{
	(void)user;
	STILB_ASSERT(size <= MPI_LARGEST);
	mpi_sending *sending = malloc(sizeof *sending);
	if (!sending) { /* slower, but it needs no memory */
		MPI_Send(data, (int)size, MPI_BYTE, (int)to, 0, MPI_COMM_WORLD);
		free(data);
		return;
	}
	sending->data = data;
	sending->next = mpi_sendings;
	mpi_sendings = sending;
	MPI_Isend(data, (int)size, MPI_BYTE, (int)to, 0, MPI_COMM_WORLD, &sending->request);
}

static bool mpi_receive(void *user, uint32_t *from, void **data, size_t *size)
{
	(void)user;
	int there = 0, bytes = 0;
	MPI_Status status;
	mpi_clean();
	MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
	if (!there)
		return false;
	MPI_Get_count(&status, MPI_BYTE, &bytes);
	void *memory = malloc(bytes > 0 ? (size_t)bytes : 1);
	if (!memory)
		return false; /* it stays there until there is memory */
	MPI_Recv(memory, bytes, MPI_BYTE, status.MPI_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
	*from = (uint32_t)status.MPI_SOURCE;
	*data = memory;
	*size = (size_t)bytes;
	return true;
}

static bool mpi_is_sent(void *user)
{
	(void)user;
	mpi_clean();
	return !mpi_sendings;
}

static void mpi_abort(void *user, int code)
{
	(void)user;
	MPI_Abort(MPI_COMM_WORLD, code);
	_Exit(code);
}

static void mpi_close(void *user)
{
	(void)user;
	MPI_Finalize();
}

__attribute__((visibility("default"))) farm_mpi_open_fn stilb_farm_mpi_open;

bool stilb_farm_mpi_open(stilb_farm_link *link, char *why, size_t size)
{
	/* A user's own choice of it would be in the environment already. Open MPI's default asks the kernel for shared
	 * memory that containers lack, and says so in every process. */
	setenv("PMIX_MCA_gds", "hash", 0);
	int threads = 0, machine = 0, count = 0, length = 0;
	char name[MPI_MAX_PROCESSOR_NAME + 1] = "";
	if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &threads) != MPI_SUCCESS) {
		snprintf(why, size, "MPI_Init failed");
		return false;
	}
	if (threads < MPI_THREAD_SERIALIZED) {
		snprintf(why, size, "this MPI is built without threads");
		return false;
	}
	MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
	MPI_Comm_rank(MPI_COMM_WORLD, &machine);
	MPI_Comm_size(MPI_COMM_WORLD, &count);
	MPI_Get_processor_name(name, &length);
	*link = (stilb_farm_link){.machine = (uint32_t)machine,
	                          .count = (uint32_t)count,
	                          .send = mpi_send,
	                          .receive = mpi_receive,
	                          .is_sent = mpi_is_sent,
	                          .abort = mpi_abort,
	                          .close = mpi_close};
	snprintf(link->name, sizeof link->name, "%s", name);
	return true;
}
