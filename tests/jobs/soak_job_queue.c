/*
 * A long run of each kind of queue: every item is popped exactly once, and those of one producer in order. Run it
 * before a release, or after a change of a queue: `cmake --build --preset release --target soak`.
 */
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "jobs/job_queue.h"

/* SIDE: number of producers, and of consumers. BATCH: items of every second call. CAPACITY: bounds the memory of a
 * queue. */
enum { SIDE = 4, BATCH = 16, CAPACITY = 1 << 20 };

static const char usage[] = "usage: soak_job_queue [low-lock|lock-free|all [ITEMS]]\n"
							"\n"
							"  %d threads push ITEMS items (100000000) singly and in batches, %d others pop them. "
							"Every item must come out exactly\n"
							"  once, those of one producer in order. Takes ITEMS / 8 bytes for each consumer. Exit "
							"status 0: so it was; 1: not.\n";

typedef struct soak {
	stilb_job_queue *queue;
	uint32_t each; /* items of each producer */
} soak;

typedef struct soldier {
	soak *soak;
	pthread_t thread;
	uint32_t number;
	uint64_t popped, disorder, repeated, forged;
	uint32_t newest[SIDE]; /* the last number popped of each producer, plus one */
	uint8_t *seen;         /* a bit for each item, set if this consumer popped it */
} soldier;

static void *produce(void *data)
{
	soldier *self = data;
	void *items[BATCH];
	for (uint32_t done = 0, calls = 0; done < self->soak->each; calls++) {
		size_t left = self->soak->each - done, count = calls % 2 ? 1 : left < BATCH ? left : BATCH;
		for (size_t i = 0; i < count; i++)
			items[i] = (void *)((uintptr_t)self->number * self->soak->each + done + i + 1);
		int pushed = stilb_job_queue_push_n(self->soak->queue, items, count, self->number);
		if (pushed > 0)
			done += (uint32_t)pushed;
		else
			sched_yield();
	}
	return NULL;
}

static void receive(soldier *self, void *item)
{
	uint64_t value = (uint64_t)(uintptr_t)item - 1;
	uint32_t producer = (uint32_t)(value / self->soak->each), number = (uint32_t)(value % self->soak->each);
	self->popped++;
	if (producer >= SIDE) {
		self->forged++;
		return;
	}
	self->disorder += number < self->newest[producer];
	self->newest[producer] = number + 1;
	uint8_t bit = (uint8_t)(1u << value % 8);
	self->repeated += (self->seen[value / 8] & bit) != 0;
	self->seen[value / 8] |= bit;
}

static void *consume(void *data)
{
	soldier *self = data;
	void *items[BATCH];
	for (uint32_t calls = 0;; calls++) {
		int popped = stilb_job_queue_pop_n(self->soak->queue, items, calls % 2 ? 1 : BATCH, self->number);
		if (popped == -EPIPE)
			return NULL;
		for (int i = 0; i < popped; i++)
			receive(self, items[i]);
		if (popped <= 0)
			sched_yield();
	}
}

/* Combines the consumers' bits: true if every item was popped exactly once. */
static bool sum_up(soldier *consumers, uint64_t items)
{
	uint64_t popped = 0, missing = 0, wrong = 0;
	for (uint32_t i = 0; i < SIDE; i++) {
		popped += consumers[i].popped;
		wrong += consumers[i].disorder + consumers[i].repeated + consumers[i].forged;
	}
	for (uint64_t value = 0; value < items; value++) {
		uint32_t times = 0;
		for (uint32_t i = 0; i < SIDE; i++)
			times += consumers[i].seen[value / 8] >> value % 8 & 1;
		missing += times == 0;
		wrong += times > 1;
	}
	if (missing + wrong > 0)
		printf("%llu items missing, %llu repeated, forged or in disorder; ", (unsigned long long)missing,
		       (unsigned long long)wrong);
	return missing + wrong == 0 && popped == items;
}

static double now_s(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + (double)now.tv_nsec / 1e9;
}

static bool soak_kind(stilb_job_queue_kind kind, const char *name, uint64_t items)
{
	soak run = {.each = (uint32_t)(items / SIDE)};
	stilb_job_queue_desc desc = {.kind = kind, .capacity = CAPACITY, .thread_count = 2 * SIDE};
	soldier soldiers[2 * SIDE];
	bool fine = stilb_job_queue_create(&desc, &run.queue) == 0;
	for (uint32_t i = 0; i < 2 * SIDE; i++) {
		soldiers[i] = (soldier){.soak = &run, .number = i, .seen = i < SIDE ? NULL : calloc(items / 8 + 1, 1)};
		fine = fine && (i < SIDE || soldiers[i].seen);
	}
	if (!fine) {
		fprintf(stderr, "soak_job_queue: out of memory\n");
		exit(1);
	}
	double start = now_s();
	for (uint32_t i = 0; i < 2 * SIDE; i++)
		if (pthread_create(&soldiers[i].thread, NULL, i < SIDE ? produce : consume, &soldiers[i]) != 0) {
			fprintf(stderr, "soak_job_queue: cannot create a thread\n");
			exit(1);
		}
	for (uint32_t i = 0; i < 2 * SIDE; i++) {
		if (i == SIDE)
			stilb_job_queue_close(run.queue);
		pthread_join(soldiers[i].thread, NULL);
	}
	double took = now_s() - start;
	fine = sum_up(soldiers + SIDE, (uint64_t)run.each * SIDE);
	printf("%s: %llu items in %.1f s: %s\n", name, (unsigned long long)run.each * SIDE, took, fine ? "fine" : "FAILED");
	for (uint32_t i = SIDE; i < 2 * SIDE; i++)
		free(soldiers[i].seen);
	stilb_job_queue_destroy(run.queue);
	return fine;
}

int main(int argc, char **argv)
{
	static const char *const names[] = {
		[STILB_JOB_QUEUE_LOW_LOCK] = "low-lock", [STILB_JOB_QUEUE_LOCK_FREE] = "lock-free", "all"};
	const char *wanted = argc > 1 ? argv[1] : "all";
	char *end = "";
	uint64_t items = argc > 2 ? strtoull(argv[2], &end, 10) : 100000000;
	bool known = argc <= 3 && *end == '\0' && items >= SIDE && items <= (uint64_t)SIDE * UINT32_MAX;
	bool fine = true, any = false;
	for (int kind = STILB_JOB_QUEUE_LOW_LOCK; known && kind <= STILB_JOB_QUEUE_LOCK_FREE; kind++)
		if (strcmp(wanted, names[kind]) == 0 || strcmp(wanted, "all") == 0) {
			any = true;
			fine = soak_kind((stilb_job_queue_kind)kind, names[kind], items) && fine;
		}
	if (any)
		return fine ? 0 : 1;
	fprintf(stderr, usage, SIDE, SIDE);
	return 2;
}
