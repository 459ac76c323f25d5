/*
 * input_pads: the gamepads of this machine, coming and going, as one stream of events in time order.
 *
 *   watcher thread   inotify on /dev, sysfs  -> opens what is a pad, starts its reader, tells of what it may not open
 *   reader thread    one a pad               -> stamps each report, keeps it in the pad's ring; writes rumble
 *   frame            stilb_input_pads_next   <- all that came since the frame before, none lost, each with its own time
 *
 * Nothing but destroy waits for a device on the caller's thread. Reports are not looked into: who reads the events
 * decodes them, so that a recording goes the same way.
 *
 * Life cycle.  create -> next until false, once a frame; rumble -> destroy. All [main-thread], or one thread's.
 */
#ifndef STILB_INPUT_PADS_H
#define STILB_INPUT_PADS_H

#include "input/input_pad.h"

typedef enum stilb_input_backend {
	STILB_INPUT_BACKEND_HIDRAW, /* the kernel's interface directly */
	STILB_INPUT_BACKEND_HIDAPI
} stilb_input_backend;

typedef struct stilb_input_pads stilb_input_pads;

typedef struct stilb_input_pads_desc {
	stilb_input_backend backend;
	const char *sys, *dev; /* NULL: "/sys", "/dev" */
	uint32_t ring_kib;     /* what each pad's ring holds; 0: 256, two seconds of 1000 reports a second of 64 bytes */
} stilb_input_pads_desc;

/* Returns before the first pad is found. STILB_ERROR_THREAD, STILB_ERROR_MEMORY, STILB_ERROR_DEVICE (no inotify). */
stilb_result stilb_input_pads_create(const stilb_input_pads_desc *desc, stilb_input_pads **pads);

/* Closes all; a pad that shakes is stopped first. Waits for the threads: a pad that leaves a question unanswered keeps
 * its own in the kernel for up to 5 s. NULL is fine. */
void stilb_input_pads_destroy(stilb_input_pads *pads);

/* The next event until `until_us` (CLOCK_MONOTONIC); false: none any more. Never waits. */
bool stilb_input_pads_next(stilb_input_pads *pads, int64_t until_us, stilb_input_event *event);

/* Waits, at most timeout_ms: until the first look at what is plugged in is done; once it is, until there are events. */
void stilb_input_pads_wait(stilb_input_pads *pads, int timeout_ms);

/* Shakes a pad for a while: the heavy and the light motor, 0..1, duration_ms 0..5000. What comes faster than the pad
 * can bear (a report in 30 ms) waits, the newest counts. Pads that cannot shake, or are gone, do nothing. */
void stilb_input_pads_rumble(stilb_input_pads *pads, uint32_t pad, float heavy, float light, uint32_t duration_ms);

/* Counts since create. */
typedef struct stilb_input_pads_stats {
	uint64_t reports; /* read */
	uint64_t lost;    /* did not fit into a ring */
	uint64_t added, removed, denied;
	uint64_t written; /* output reports */
} stilb_input_pads_stats;
stilb_input_pads_stats stilb_input_pads_stats_get(const stilb_input_pads *pads);

/* The rule that gives the user of this seat access to pads of this kind: a line for a file in /etc/udev/rules.d whose
 * name sorts before 73-seat-late.rules. Returns text. [any-thread] */
const char *stilb_input_udev_rule(const stilb_input_pad_info *info, char *text, size_t size);

#endif
