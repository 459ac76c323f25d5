/*
 * input_reader: one pad that is plugged in: the thread that reads and writes it (the reader), and the functions by
 * which the frame's thread takes its events. The watcher is the thread of input_pads.c that finds pads.
 *
 *   watcher   create, then start (or denied) -> the reader lives -> join, destroy
 *   reader    sends the layout's first messages to the pad, stamps reports with their time, rumbles; ends when the pad
 *             is unplugged or when it is told to
 *   frame     peek, take -> until the pad's REMOVED was taken; from then on the reader is the watcher's again
 *
 * Between threads.  Reports go through the ring. Everything else is one atomic word each: stop and rumble (frame or
 *                   watcher to reader, which is woken by wake_fd), ended (reader to frame and watcher).
 */
#ifndef STILB_INPUT_READER_INTERNAL_H
#define STILB_INPUT_READER_INTERNAL_H

#include "base/base_contract.h"
#include "input/device/input_device_internal.h"
#include "input/device/input_pads.h"
#include "input/device/input_ring_internal.h"
#include "input/hid/input_layout.h"

#include <pthread.h>

/* Shared by all readers of one stilb_input_pads. */
typedef struct input_hub {
	int arrived_fd;   /* an eventfd that wakes stilb_input_pads_wait */
	uint32_t waiting; /* 1 while somebody is in stilb_input_pads_wait */
	/* Counts since create: atomic, relaxed, because no other data depends on them. */
	stilb_input_pads_stats stats;
} input_hub;

/* Wakes stilb_input_pads_wait if somebody is in it: to be called after an event was published. [any-thread] */
void input_hub_tell(input_hub *hub);

/* CLOCK_MONOTONIC in microseconds. [any-thread] */
int64_t input_now_us(void);

/* pthread_create with all signals blocked but those that a fault of the thread itself raises, so that the program's
 * signal handlers run on its own threads. 0 or a negative errno. [any-thread] */
int input_thread_create(pthread_t *thread, void *(*run)(void *), void *user);

/* The newest report that did not fit into the ring. */
typedef struct input_late {
	int64_t time_us;
	uint32_t size; /* bytes; 0: there is no such report */
	uint8_t bytes[STILB_INPUT_REPORT_MAX];
} input_late;

typedef struct input_reader {
	/* Set up before the frame sees the reader, then unchanged until it is destroyed. */
	input_hub *hub;
	uint32_t number;
	bool denied; /* no permission: there is no device and no thread */
	int64_t added_us;
	stilb_input_pad_info info;
	stilb_input_layout layout;
	int wake_fd; /* an eventfd that wakes the reader thread; -1 if denied */
	pthread_t thread;

	/* Atomic; each use says order and partner. */
	input_ring ring;
	uint32_t stop;
	uint32_t ended;
	uint64_t rumble; /* the newest request; 0: none since the last one was taken */

	/* Used by the reader thread, and once that has ended by the frame. */
	input_late late;
	int64_t ended_us;

	/* The reader thread's own. */
	stilb_owner owner;
	input_device device;
	struct {
		float heavy, light; /* the strength to write */
		int64_t until_us;   /* time at which the motors are to stop; 0: they are stopped */
		int64_t written_us; /* time at which the last rumble report was written */
		bool is_new;        /* heavy and light were not written yet */
		bool moves;         /* the last report turned a motor on */
		uint32_t sequence;  /* number of rumble reports written so far */
	} motors;

	/* The frame's own. */
	bool announced;            /* ADDED or DENIED was taken */
	struct input_reader *next; /* in stilb_input_pads.returned */
} input_reader;

/* Allocates a reader of the hub, all else zero. -ENOMEM: *reader is then NULL. [one-writer], the watcher */
int input_reader_create(input_hub *hub, input_reader **reader);

/* Frees a reader that has no thread, or whose thread was joined. NULL is allowed. [one-writer], the watcher */
void input_reader_destroy(input_reader *reader);

/* Starts the thread that reads reader->device, which is closed by the thread, or here after an error. 0 or a negative
 * errno. [one-writer], the watcher */
int input_reader_start(input_reader *reader, uint64_t ring_bytes);

/* Tells the reader's thread to stop the motors and end; does not wait for it. [any-thread] */
void input_reader_stop(input_reader *reader);

/* The pad is gone at time_us: after the reports that are in the ring REMOVED follows. Once for each reader; by its own
 * thread, or by the watcher if it was denied. */
void input_reader_end(input_reader *reader, int64_t time_us);

/* True once input_reader_end was called: the last report is in the ring. [any-thread] */
bool input_reader_has_ended(const input_reader *reader);

/* Asks for strengths heavy and light, both 0..1, for duration_ms <= 65535; replaces what was asked for and not done
 * yet. [one-writer], the frame */
void input_reader_rumble(input_reader *reader, float heavy, float light, uint32_t duration_ms);

/* The oldest event that was not taken; false: there is none. It is valid until it is taken. [one-writer], the frame */
bool input_reader_peek(const input_reader *reader, stilb_input_event *event);

/* Removes the event that peek gave, which was of this kind. [one-writer], the frame */
void input_reader_take(input_reader *reader, stilb_input_event_kind kind);

#endif
