/*
 * vm_fixture: cmocka's fixture of the tests in the virtual machine: a stilb_input_pads for each backend, both reading
 * the same simulated pads at the same time, and a record of what each of them read from every pad.
 *
 * Threads.  All calls from one thread, which plays the frame; senders have threads of their own.
 */
#ifndef STILB_VM_FIXTURE_H
#define STILB_VM_FIXTURE_H

#include "input/device/input_pads.h"
#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "vm/uhid_pad.h"

#include <pthread.h>
#include <stdatomic.h>

#define VM_SIDES 2        /* a side: one of the two backends, hidraw and hidapi, with what it read */
#define VM_REPORTS 2048u  /* most numbered reports of one pad */
#define VM_FRAME_US 16667 /* 60 frames a second */

/* A pad as read by one of the backends, with a control and camera of its own. */
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
	uint32_t disorders;             /* reports whose number is not larger than that of the report before */
	uint32_t last_number;           /* of the newest valid report */
	int64_t stamped_us[VM_REPORTS]; /* time stamp of the report with each number; 0: it did not come */
} vm_heard;

typedef struct vm_side {
	const char *name;
	stilb_input_pads *pads;
	int64_t frame_us; /* all events up to this time were taken */
	vm_heard heard[STILB_INPUT_PADS_MAX];
} vm_side;

typedef struct vm_fixture {
	vm_side sides[VM_SIDES];
	uhid_pad *pads[STILB_INPUT_PADS_MAX];                   /* plugged in now */
	uint32_t (*number)(const uint8_t *report, size_t size); /* number of a test report, from 1; 0: it is none */
} vm_fixture;

/* For cmocka: *state becomes a fixture that reads pads, with nothing plugged in. close unplugs all pads. */
int vm_fixture_open(void **state);
int vm_fixture_close(void **state);

/* Plugs a pad in; unique is its serial number or address. */
uhid_pad *vm_fixture_plug(vm_fixture *fixture, const input_test_descriptor *kind, const char *unique);
void vm_fixture_pull(vm_fixture *fixture, uhid_pad *pad);

/* One frame: takes all events. */
void vm_fixture_frame(vm_fixture *fixture);

/* The pad with this serial number as one side has it, added or denied; NULL: it is not there. */
vm_heard *vm_fixture_find(vm_fixture *fixture, int side, const char *unique);

/* Runs frames until both sides have (or, with there false, have not) the pad. Fails the test after some seconds. */
void vm_fixture_wait(vm_fixture *fixture, const char *unique, bool there);

/* Runs frames for a while. */
void vm_fixture_run(vm_fixture *fixture, int64_t us);

/* CLOCK_MONOTONIC in microseconds; and a sleep until that clock has reached us. */
int64_t vm_now_us(void);
void vm_sleep_until_us(int64_t us);

/* A thread that sends a pad's reports at a fixed rate. After a delay it does not catch up, like a real pad. */
typedef struct vm_sender {
	uhid_pad *pad;
	uint32_t count;
	int64_t period_us;
	size_t (*report)(uint32_t number, uint8_t report[STILB_INPUT_REPORT_MAX]); /* numbers from 1 to count */
	pthread_t thread;
	int64_t sent_us[VM_REPORTS]; /* time at which each report was sent, by number; to be read after finish */
	atomic_bool done;            /* release by the thread, pairs with the acquire of vm_sender_runs */
} vm_sender;

void vm_sender_start(vm_sender *sender);
bool vm_sender_runs(vm_sender *sender);
void vm_sender_finish(vm_sender *sender);

/* The median of count values, which are sorted. */
int64_t vm_median(int64_t *values, uint32_t count);

/* Number of open descriptors and of threads of this process, from /proc. */
int vm_descriptors(void);
int vm_threads(void);

/* Sets a parameter of a kernel module: /sys/module/MODULE/parameters/NAME. */
void vm_module_set(const char *module, const char *name, const char *value);

#endif
