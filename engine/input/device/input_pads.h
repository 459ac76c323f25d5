/*
 * input_pads: the gamepads that are plugged into this machine, coming and going, as one stream of events in time order.
 *
 *   watcher thread   inotify on /dev, sysfs  -> opens every pad, starts its reader; reports pads without permission
 *   reader thread    one for each pad        -> stamps each report, stores it in the pad's ring; writes rumble
 *   frame            stilb_input_pads_next   <- everything since the last frame, nothing lost, each with its own time
 *
 * Only destroy waits for a device on the caller's thread. Reports are not decoded here but by whoever takes the events
 * (input_control.h), so that events of a recording are decoded by the same code.
 *
 * Life cycle.  create -> once a frame next until false; rumble at any time -> destroy.
 *
 *     stilb_input_pads_create(&(stilb_input_pads_desc){0}, &pads);
 *     while (stilb_input_pads_next(pads, now_us, &event))
 *         stilb_input_control_event(control, &event);
 *     stilb_input_pads_destroy(pads);
 *
 * Threads.     [owner-thread]: all calls from the thread that created it; asserted.
 */
#ifndef STILB_INPUT_PADS_H
#define STILB_INPUT_PADS_H

#include "input/input_pad.h"

/* The way to talk to a pad's hidraw node: the kernel's interface directly, or the library hidapi. */
typedef enum stilb_input_backend { STILB_INPUT_BACKEND_HIDRAW, STILB_INPUT_BACKEND_HIDAPI } stilb_input_backend;

typedef struct stilb_input_pads stilb_input_pads;

/* {0} is all defaults. */
typedef struct stilb_input_pads_desc {
	stilb_input_backend backend;
	/* Folders to look in; NULL: "/sys" and "/dev". Copied. */
	const char *sys, *dev;
	/* KiB of each pad's ring, rounded up to a power of two, at least 16. 0: 256, which is two seconds of 1000 reports a
	 * second of 64 bytes. */
	uint32_t ring_kib;
} stilb_input_pads_desc;

/* Starts the watcher; returns before the first pad is found. STILB_ERROR_DEVICE (no inotify, or no folder to watch),
 * STILB_ERROR_THREAD, STILB_ERROR_MEMORY; *pads is then NULL. The calling thread becomes the owner. */
stilb_result stilb_input_pads_create(const stilb_input_pads_desc *desc, stilb_input_pads **pads);

/* Stops all motors and closes all pads. Waits for the threads; one whose pad does not answer a request may be in the
 * kernel for up to 5 s. NULL is allowed. [owner-thread] */
void stilb_input_pads_destroy(stilb_input_pads *pads);

/* Takes the next event whose time is at most until_us (CLOCK_MONOTONIC); false: there is none yet. Never waits. A pad's
 * events are ADDED or DENIED, its REPORTs, REMOVED; events of all pads come in time order. What the event points to is
 * valid until the next call of next or wait. [owner-thread] */
bool stilb_input_pads_next(stilb_input_pads *pads, int64_t until_us, stilb_input_event *event);

/* Waits at most timeout_ms >= 0: in the first call until all pads that are plugged in were found, later until there is
 * an event. [owner-thread] */
void stilb_input_pads_wait(stilb_input_pads *pads, int timeout_ms);

/* Makes a pad rumble: strength of the heavy and the light motor, 0..1, for duration_ms, 0..5000; other values count as
 * the range's ends, NaN as 0. A pad gets at most one report in 30 ms; of calls in between the newest counts. Does
 * nothing for a pad that has no motors or is gone. Never waits. [owner-thread] */
void stilb_input_pads_rumble(stilb_input_pads *pads, uint32_t pad, float heavy, float light, uint32_t duration_ms);

/* Counts since create. */
typedef struct stilb_input_pads_stats {
	/* Reports that were read, and those of them that were dropped because a ring was full. */
	uint64_t reports, lost;
	/* Pads: opened; gone again; refused for want of permission. */
	uint64_t added, removed, denied;
	/* Output reports (rumble) that were written. */
	uint64_t written;
} stilb_input_pads_stats;

/* The counts now; each is exact, all together are not of one moment. [owner-thread] */
stilb_input_pads_stats stilb_input_pads_stats_get(const stilb_input_pads *pads);

/* Writes the udev rule that gives whoever sits at the machine access to pads of this kind: a line for a file in
 * /etc/udev/rules.d whose name sorts before 73-seat-late.rules. text has size > 0 bytes; 128 are enough. Returns text.
 * [any-thread] */
const char *stilb_input_udev_rule(const stilb_input_pad_info *info, char *text, size_t size);

#endif
