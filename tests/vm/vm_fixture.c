#include "vm/vm_fixture.h"
#include "support/test.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define WAIT_US 10000000 /* after so long a wait fails: longer than any takes, also on a busy machine */

/* ---- time -------------------------------------------------------------------------------------------------------- */

int64_t vm_now_us(void)
{
	return (int64_t)(stilb_time_ns() / 1000);
}

void vm_sleep_until_us(int64_t us)
{
	struct timespec until = {.tv_sec = us / 1000000, .tv_nsec = us % 1000000 * 1000};
	while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR)
		continue;
}

static int smaller_first(const void *a, const void *b)
{
	int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
	return (x > y) - (x < y);
}

int64_t vm_median(int64_t *values, uint32_t count)
{
	qsort(values, count, sizeof *values, smaller_first);
	return count > 0 ? values[count / 2] : 0;
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

static vm_heard *by_number(vm_side *side, uint32_t pad)
{
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++) {
		if (side->heard[i].pad == pad && !side->heard[i].removed)
			return &side->heard[i];
	}
	return NULL;
}

static void forget(vm_heard *heard)
{
	stilb_input_control_destroy(heard->control);
	*heard = (vm_heard){.removed = true};
}

/* Notes a pad that was added or denied, in a free entry or in that of a pad that was removed. */
static void meet(vm_side *side, const stilb_input_event *event)
{
	vm_heard *heard = by_number(side, event->pad);
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX && !heard; i++) {
		if (side->heard[i].pad == 0 || side->heard[i].removed)
			heard = &side->heard[i];
	}
	assert_non_null(heard);
	forget(heard);
	heard->pad = event->pad;
	heard->removed = false;
	heard->denied = event->kind == STILB_INPUT_PAD_DENIED;
	heard->info = *event->info;
	heard->is_pad = stilb_input_layout_find(event->info, &heard->layout) == STILB_OK;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(stilb_input_control_create(&settings, &heard->pose, vm_now_us(), &heard->control), STILB_OK);
}

static void note(const vm_fixture *fixture, vm_heard *heard, const stilb_input_event *event)
{
	switch (stilb_input_decode(&heard->layout, event->bytes, event->size, &heard->state)) {
	case STILB_INPUT_DECODED:
		heard->decoded++;
		break;
	case STILB_INPUT_OTHER:
		heard->other++;
		return;
	case STILB_INPUT_CORRUPT:
		heard->corrupt++;
		return;
	}
	uint32_t number = fixture->number ? fixture->number(event->bytes, event->size) : 0;
	if (number == 0 || number >= VM_REPORTS)
		return;
	heard->disorders += number <= heard->last_number;
	heard->last_number = number;
	heard->stamped_us[number] = event->time_us;
}

static void hear(const vm_fixture *fixture, vm_side *side, const stilb_input_event *event)
{
	if (event->kind == STILB_INPUT_PAD_ADDED || event->kind == STILB_INPUT_PAD_DENIED)
		meet(side, event);
	vm_heard *heard = by_number(side, event->pad);
	assert_non_null(heard);
	stilb_input_control_event(heard->control, event);
	if (event->kind == STILB_INPUT_PAD_REPORT && heard->is_pad)
		note(fixture, heard, event);
	heard->removed = event->kind == STILB_INPUT_PAD_REMOVED;
}

void vm_fixture_frame(vm_fixture *fixture)
{
	for (int i = 0; i < VM_SIDES; i++) {
		vm_side *side = &fixture->sides[i];
		int64_t now = side->frame_us = vm_now_us();
		stilb_input_event event;
		while (stilb_input_pads_next(side->pads, now, &event))
			hear(fixture, side, &event);
		for (uint32_t k = 0; k < STILB_INPUT_PADS_MAX; k++) {
			stilb_input_state wanted;
			if (side->heard[k].control)
				stilb_input_control_frame(side->heard[k].control, now, &(stilb_input_state){0}, true, &wanted,
				                          &side->heard[k].pose);
		}
	}
}

vm_heard *vm_fixture_find(vm_fixture *fixture, int side, const char *unique)
{
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++) {
		vm_heard *heard = &fixture->sides[side].heard[i];
		if (heard->pad != 0 && !heard->removed && strcmp(heard->info.unique, unique) == 0)
			return heard;
	}
	return NULL;
}

void vm_fixture_run(vm_fixture *fixture, int64_t us)
{
	int64_t now = vm_now_us(), end = now + us;
	for (; now < end; now = vm_now_us()) {
		vm_sleep_until_us(now + VM_FRAME_US < end ? now + VM_FRAME_US : end);
		vm_fixture_frame(fixture);
	}
}

void vm_fixture_wait(vm_fixture *fixture, const char *unique, bool there)
{
	for (int64_t end = vm_now_us() + WAIT_US; vm_now_us() < end; vm_sleep_until_us(vm_now_us() + 2000)) {
		vm_fixture_frame(fixture);
		if (!vm_fixture_find(fixture, 0, unique) != there && !vm_fixture_find(fixture, 1, unique) != there)
			return;
	}
	fail_msg("pad %s is %s: hidraw %d, hidapi %d", unique, there ? "not found" : "still there",
	         vm_fixture_find(fixture, 0, unique), vm_fixture_find(fixture, 1, unique));
}

uhid_pad *vm_fixture_plug(vm_fixture *fixture, const input_test_descriptor *kind, const char *unique)
{
	uint32_t free_one = 0;
	while (fixture->pads[free_one])
		assert_true(++free_one < STILB_INPUT_PADS_MAX);
	return fixture->pads[free_one] = uhid_pad_create(kind, unique);
}

void vm_fixture_pull(vm_fixture *fixture, uhid_pad *pad)
{
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++) {
		if (fixture->pads[i] == pad)
			fixture->pads[i] = NULL;
	}
	uhid_pad_destroy(pad);
}

int vm_fixture_open(void **state)
{
	static const stilb_input_backend backends[VM_SIDES] = {STILB_INPUT_BACKEND_HIDRAW, STILB_INPUT_BACKEND_HIDAPI};
	static const char *const names[VM_SIDES] = {"hidraw", "hidapi"};
	vm_fixture *fixture = calloc(1, sizeof *fixture);
	assert_non_null(fixture);
	for (int i = 0; i < VM_SIDES; i++) {
		fixture->sides[i].name = names[i];
		stilb_input_pads_desc desc = {.backend = backends[i]};
		assert_int_equal(stilb_input_pads_create(&desc, &fixture->sides[i].pads), STILB_OK);
	}
	*state = fixture;
	return 0;
}

int vm_fixture_close(void **state)
{
	vm_fixture *fixture = *state;
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++)
		uhid_pad_destroy(fixture->pads[i]);
	for (int i = 0; i < VM_SIDES; i++) {
		stilb_input_pads_destroy(fixture->sides[i].pads);
		for (uint32_t k = 0; k < STILB_INPUT_PADS_MAX; k++)
			forget(&fixture->sides[i].heard[k]);
	}
	free(fixture);
	return 0;
}

/* ---- senders ----------------------------------------------------------------------------------------------------- */

static void *send_reports(void *argument)
{
	vm_sender *sender = argument;
	uint8_t report[STILB_INPUT_REPORT_MAX];
	int64_t next = vm_now_us();
	for (uint32_t number = 1; number <= sender->count; number++) {
		size_t size = sender->report(number, report);
		vm_sleep_until_us(next);
		sender->sent_us[number] = vm_now_us();
		uhid_pad_send(sender->pad, report, size);
		next += sender->period_us;
		if (next < sender->sent_us[number])
			next = sender->sent_us[number];
	}
	atomic_store_explicit(&sender->done, true, memory_order_release);
	return NULL;
}

void vm_sender_start(vm_sender *sender)
{
	assert_true(sender->count < VM_REPORTS);
	assert_int_equal(pthread_create(&sender->thread, NULL, send_reports, sender), 0);
}

bool vm_sender_runs(vm_sender *sender)
{
	return !atomic_load_explicit(&sender->done, memory_order_acquire);
}

void vm_sender_finish(vm_sender *sender)
{
	pthread_join(sender->thread, NULL);
}

/* ---- the system -------------------------------------------------------------------------------------------------- */

static int entries(const char *path)
{
	int count = 0;
	DIR *folder = opendir(path);
	assert_non_null(folder);
	while (readdir(folder))
		count++;
	closedir(folder);
	return count - 2; /* . and .. */
}

int vm_descriptors(void)
{
	return entries("/proc/self/fd") - 1; /* without the descriptor that opendir uses for counting */
}

int vm_threads(void)
{
	return entries("/proc/self/task");
}

void vm_module_set(const char *module, const char *name, const char *value)
{
	char path[128];
	snprintf(path, sizeof path, "/sys/module/%s/parameters/%s", module, name);
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	assert_true(fputs(value, file) >= 0);
	assert_int_equal(fclose(file), 0);
}
