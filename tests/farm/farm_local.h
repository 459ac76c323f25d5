/* A link between machines that are threads of one process: messages in memory, and machines that can be cut off. */
#ifndef FARM_LOCAL_H
#define FARM_LOCAL_H

#include "farm/farm_link.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#define LOCAL_MOST 8u

typedef struct local_message {
	struct local_message *next;
	uint32_t from;
	void *data;
	size_t size;
} local_message;

typedef struct local_machine {
	struct local_farm *farm;
	uint32_t number;
	local_message *first, **last;
	_Atomic bool cut; /* what it sends is lost; relaxed: nothing goes with it */
} local_machine;

typedef struct local_farm {
	pthread_mutex_t lock;
	uint32_t count;
	local_machine machines[LOCAL_MOST];
	uint32_t aborted;
} local_farm;

static inline void local_send(void *user, uint32_t to, void *data, size_t size)
{
	local_machine *machine = user;
	local_farm *farm = machine->farm;
	if (atomic_load_explicit(&machine->cut, memory_order_relaxed)) {
		free(data);
		return;
	}
	local_message *message = malloc(sizeof *message);
	*message = (local_message){NULL, machine->number, data, size};
	pthread_mutex_lock(&farm->lock);
	*farm->machines[to].last = message;
	farm->machines[to].last = &message->next;
	pthread_mutex_unlock(&farm->lock);
}

static inline bool local_receive(void *user, uint32_t *from, void **data, size_t *size)
{
	local_machine *machine = user;
	pthread_mutex_lock(&machine->farm->lock);
	local_message *message = machine->first;
	if (message && !(machine->first = message->next))
		machine->last = &machine->first;
	pthread_mutex_unlock(&machine->farm->lock);
	if (!message)
		return false;
	*from = message->from;
	*data = message->data;
	*size = message->size;
	free(message);
	return true;
}

static inline bool local_is_sent(void *user)
{
	(void)user;
	return true;
}

static inline void local_close(void *user)
{
	(void)user;
}

static inline void local_make(local_farm *farm, uint32_t count)
{
	*farm = (local_farm){.count = count};
	pthread_mutex_init(&farm->lock, NULL);
	for (uint32_t i = 0; i < count; i++) {
		farm->machines[i] = (local_machine){.farm = farm, .number = i};
		farm->machines[i].last = &farm->machines[i].first;
	}
}

static inline stilb_farm_link local_link(local_farm *farm, uint32_t machine)
{
	stilb_farm_link link = {.machine = machine,
	                        .count = farm->count,
	                        .neighbours = farm->count,
	                        .user = &farm->machines[machine],
	                        .send = local_send,
	                        .receive = local_receive,
	                        .is_sent = local_is_sent,
	                        .close = local_close};
	snprintf(link.name, sizeof link.name, "m%u", machine);
	return link;
}

/* Drops what nobody has read. */
static inline void local_finish(local_farm *farm)
{
	for (uint32_t i = 0; i < farm->count; i++) {
		uint32_t from;
		void *data;
		size_t size;
		while (local_receive(&farm->machines[i], &from, &data, &size))
			free(data);
	}
	pthread_mutex_destroy(&farm->lock);
}

#endif
