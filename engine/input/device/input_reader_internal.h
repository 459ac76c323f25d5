/*
 * input_reader: one pad that is plugged in: the thread that reads it and writes to it, and what the frame sees of it.
 *
 *   watcher   create, start or deny -> (it lives) -> join, destroy
 *   reader    says hello, stamps reports, shakes the pad, ends when the pad is pulled or when it is told to
 *   frame     peek, take -> until the pad's REMOVED was taken; from then on it is the watcher's again
 *
 * Who tells whom. Reports go through the ring. The rest is a word each: stop, rumble (frame or watcher -> reader, who
 * is woken by wake_fd), ended (reader -> frame and watcher).
 */
#ifndef STILB_INPUT_READER_INTERNAL_H
#define STILB_INPUT_READER_INTERNAL_H

#include "input/device/input_device_internal.h"
#include "input/device/input_pads.h"
#include "input/device/input_ring_internal.h"
#include "input/hid/input_layout.h"

#include <pthread.h>

/* What all readers of one stilb_input_pads share. */
typedef struct input_hub {
	int arrived_fd;   /* an eventfd, written for whoever waits */
	uint32_t waiting; /* somebody does */
	/* Counts since create: atomic, relaxed, as nothing depends on them. */
	stilb_input_pads_stats stats;
} input_hub;

/* To be called after events have come, or after anything else that is waited for. */
void input_hub_tell(input_hub *hub);

/* In microseconds: CLOCK_MONOTONIC. */
int64_t input_now_us(void);

/* pthread_create for a thread that takes no signals but those of its own faults. 0 or a negative errno. */
int input_thread_create(pthread_t *thread, void *(*run)(void *), void *user);

/* The last report that found no room in the ring. */
typedef struct input_late {
	int64_t time_us;
	uint32_t size; /* 0: there is none */
	uint8_t bytes[STILB_INPUT_REPORT_MAX];
} input_late;

typedef struct input_reader {
	/* Set up before the frame sees it, unchanged until it is destroyed. */
	input_hub *hub;
	uint32_t number;
	bool denied; /* has no device and no thread */
	int64_t added_us;
	stilb_input_pad_info info;
	stilb_input_layout layout;
	int wake_fd; /* an eventfd; -1 where denied */
	pthread_t thread;

	/* Between threads: as said where they are used. */
	input_ring ring;
	uint32_t stop;
	uint32_t ended;
	uint64_t rumble; /* 0: nothing new is wanted */

	/* The reader's, and once it has ended the frame's. */
	input_late late;
	int64_t ended_us;

	/* The reader's own. */
	input_device device;
	struct {
		float heavy, light; /* what is wanted */
		int64_t until_us;   /* then it stops; 0: it is still */
		int64_t written_us; /* the last report */
		bool is_new;        /* what is wanted has not been written */
		bool moves;         /* what was written last makes it shake */
		uint32_t sequence;
	} shake;

	/* The frame's own. */
	bool announced;            /* ADDED or DENIED was taken */
	struct input_reader *next; /* in the list of those that it is done with */
} input_reader;

/* *reader has its layout and hub; the rest is to be filled. -ENOMEM. */
int input_reader_create(input_hub *hub, input_reader **reader);

/* Of one that has no thread, or whose thread was joined. NULL is fine. */
void input_reader_destroy(input_reader *reader);

/* Begins to read reader->device, which is the reader's from here on, also after an error. 0 or a negative errno. */
int input_reader_start(input_reader *reader, uint64_t ring_bytes);

/* Asks the thread to end; stops what shakes first. */
void input_reader_stop(input_reader *reader);

/* The pad is gone: nothing comes after what was there. */
void input_reader_end(input_reader *reader, int64_t time_us);
bool input_reader_has_ended(const input_reader *reader);

/* heavy and light are 0..1. [one-writer], the frame */
void input_reader_shake(input_reader *reader, float heavy, float light, uint32_t duration_ms);

/* The oldest event that was not taken yet; false: none. What it points to stays until then. [one-writer], the frame */
bool input_reader_peek(const input_reader *reader, stilb_input_event *event);
void input_reader_take(input_reader *reader, stilb_input_event_kind kind);

#endif
