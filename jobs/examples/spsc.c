/*
 * One thread feeds one other thread: the reader of a sensor hands its readings to the main thread. Neither end waits
 * for the other; the consumer decides what to do when the queue is empty.
 *
 * Prints: 1000 readings, highest 99
 */
#include <stilb/job_spsc.h>

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>

enum { READINGS = 1000 };

typedef struct reading {
	int time, value;
} reading;

static void *read_sensor(void *data)
{
	static reading readings[READINGS];
	for (int i = 0; i < READINGS; i++) {
		readings[i] = (reading){.time = i, .value = i * 37 % 100};
		if (stilb_job_spsc_push(data, &readings[i]) != 0)
			break;
	}
	stilb_job_spsc_close(data);
	return NULL;
}

int main(void)
{
	stilb_job_spsc *queue;
	pthread_t reader;
	if (stilb_job_spsc_create(&queue) != 0 || pthread_create(&reader, NULL, read_sensor, queue) != 0)
		return 1;

	int count = 0, highest = 0, error;
	void *item;
	while ((error = stilb_job_spsc_pop(queue, &item)) != -EPIPE) { /* -EPIPE: closed and empty */
		if (error == -EAGAIN) {                                    /* empty for now */
			sched_yield();
			continue;
		}
		const reading *got = item; /* all that the reader wrote is visible here */
		count++;
		if (got->value > highest)
			highest = got->value;
	}

	pthread_join(reader, NULL);
	stilb_job_spsc_destroy(queue);
	printf("%d readings, highest %d\n", count, highest);
	return 0;
}
