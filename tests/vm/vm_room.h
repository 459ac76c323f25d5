/*
 * vm_room: what the tests in the virtual machine have in common: the engine's ears, one pair for each backend, both
 * listening to the same pads at the same time, and what each of them heard of every pad.
 *
 * Threads.  One thread's, which stands for the frame's; senders have their own.
 */
#ifndef STILB_VM_ROOM_H
#define STILB_VM_ROOM_H

#include "input/device/input_pads.h"
#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "vm/uhid_pad.h"

#include <pthread.h>
#include <stdatomic.h>

#define VM_SIDES 2        /* hidraw, hidapi */
#define VM_REPORTS 2048u  /* numbered reports of one pad */
#define VM_FRAME_US 16667 /* 60 frames a second */

/* A pad as one of the backends shows it. It flies a camera of its own. */
typedef struct vm_heard {
	uint32_t pad;
	bool denied, removed;
	bool is_pad; /* it has a layout */
	stilb_input_pad_info info;
	stilb_input_layout layout;
	stilb_input_control *control;
	stilb_input_pose pose;
	stilb_input_pad_state state;
	uint32_t decoded, other, corrupt;
	uint32_t disorders;             /* reports with a number that is not larger than that of the one before */
	uint32_t last_number;           /* of the newest sound report */
	int64_t stamped_us[VM_REPORTS]; /* by number; 0: did not come */
} vm_heard;

typedef struct vm_side {
	const char *name;
	stilb_input_pads *pads;
	int64_t frame_us; /* until when it has heard all */
	vm_heard heard[STILB_INPUT_PADS_MAX];
} vm_side;

typedef struct vm_room {
	vm_side sides[VM_SIDES];
	uhid_pad *pads[STILB_INPUT_PADS_MAX];                   /* that are plugged in */
	uint32_t (*number)(const uint8_t *report, size_t size); /* which test report it is; from 1, 0: none */
} vm_room;

/* cmocka's fixture: *state is a room that listens, with nothing plugged in. close pulls what is. */
int vm_room_open(void **state);
int vm_room_close(void **state);

/* Plugs a pad in; unique is its serial number or address. */
uhid_pad *vm_room_plug(vm_room *room, const input_test_descriptor *kind, const char *unique);
void vm_room_pull(vm_room *room, uhid_pad *pad);

/* One frame: takes all that came. */
void vm_room_frame(vm_room *room);

/* The pad with this serial number on one side, if it is there (or denied); NULL: it is not, or not any more. */
vm_heard *vm_room_find(vm_room *room, int side, const char *unique);

/* Runs frames until both sides have (or, with there false, have not) the pad. Fails the test after some seconds. */
void vm_room_wait(vm_room *room, const char *unique, bool there);

/* Runs frames for a while. */
void vm_room_run(vm_room *room, int64_t us);

/* CLOCK_MONOTONIC. */
int64_t vm_now_us(void);
void vm_sleep_until_us(int64_t us);

/* A thread that has a pad report at a steady rate. A late one does not hurry: neither does a pad. */
typedef struct vm_sender {
	uhid_pad *pad;
	uint32_t count;
	int64_t period_us;
	size_t (*report)(uint32_t number, uint8_t report[STILB_INPUT_REPORT_MAX]); /* numbers from 1 to count */
	pthread_t thread;
	int64_t sent_us[VM_REPORTS]; /* by number; to be read after finish */
	atomic_bool done;            /* release by the thread, pairs with the acquire of vm_sender_runs */
} vm_sender;

void vm_sender_start(vm_sender *sender);
bool vm_sender_runs(vm_sender *sender);
void vm_sender_finish(vm_sender *sender);

/* Of count values; sorts them. */
int64_t vm_median(int64_t *values, uint32_t count);

/* Open descriptors and threads of this process, as /proc counts them. */
int vm_descriptors(void);
int vm_threads(void);

/* A setting of a kernel module: /sys/module/MODULE/parameters/NAME. */
void vm_module_set(const char *module, const char *name, const char *value);

#endif
