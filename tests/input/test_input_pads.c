/* input_pads: gamepads plugged in and out, their reports, rumble, and failures, on simulated hidraw nodes. */
#include "input/device/input_pads.h"

#include "input/device/input_reader_internal.h"
#include "input/hid/input_layout.h"
#include "support/fake_hidraw.h"
#include "support/test.h"

#include <dirent.h>
#include <stddef.h>
#include <sys/resource.h>
#include <time.h>

/* Replaces the real hidapi backend, so that hidapi is not loaded: the thread sanitizer does not see into that. */
const input_backend input_backend_hidapi = {.name = "none"};

static stilb_input_pads *pads;
static const input_test_descriptor *ds4, *asus;

static int set_up(void **state)
{
	(void)state;
	ds4 = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	asus = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x18d1, 0x2c40);
	fake_begin();
	return !ds4 || !asus;
}

static int tear_down(void **state)
{
	(void)state;
	stilb_input_pads_destroy(pads);
	pads = NULL;
	fake_end();
	return 0;
}

static void begin_kib(uint32_t ring_kib)
{
	stilb_input_pads_desc desc = {.sys = fake.sys, .dev = fake.dev, .ring_kib = ring_kib};
	assert_int_equal(stilb_input_pads_create(&desc, &pads), STILB_OK);
	stilb_input_pads_wait(pads, 300000);
}

static void begin(void)
{
	begin_kib(0);
}

static void sleep_ms(int ms)
{
	nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L}, NULL);
}

/* Waits for the next event, as long as a slow machine may need, and returns it. */
static stilb_input_event next(void)
{
	stilb_input_event event;
	int64_t until_us = input_now_us() + 300000000;
	while (!stilb_input_pads_next(pads, input_now_us(), &event)) {
		assert_true(input_now_us() < until_us);
		stilb_input_pads_wait(pads, 100);
	}
	return event;
}

static stilb_input_event next_of(stilb_input_event_kind kind)
{
	stilb_input_event event = next();
	assert_int_equal(event.kind, kind);
	return event;
}

static bool is_quiet(int ms)
{
	stilb_input_event event;
	int64_t until_us = input_now_us() + 1000 * (int64_t)ms;
	while (input_now_us() < until_us) {
		if (stilb_input_pads_next(pads, INT64_MAX, &event))
			return false;
		sleep_ms(1);
	}
	return true;
}

static uint32_t count_entries(const char *path)
{
	uint32_t count = 0;
	DIR *folder = opendir(path);
	assert_non_null(folder);
	while (readdir(folder))
		count++;
	closedir(folder);
	return count;
}

/* A DualShock 4's report with a number in it. */
static void send_number(int node, uint32_t number)
{
	uint8_t report[64] = {1, 128, 128, 128, 128, 8};
	memcpy(report + 40, &number, sizeof number);
	assert_true(fake_send(node, report, sizeof report));
}

static uint32_t number_of(const stilb_input_event *event)
{
	uint32_t number;
	assert_int_equal(event->kind, STILB_INPUT_PAD_REPORT);
	assert_int_equal(event->size, 64);
	memcpy(&number, event->bytes + 40, sizeof number);
	return number;
}

/* ---- coming and going -------------------------------------------------------------------------------------------- */

static void pads_there_at_the_start_are_added(void **state)
{
	(void)state;
	fake_plug(3, ds4);
	fake_plug(12, asus);
	int64_t before_us = input_now_us();
	begin();
	stilb_input_event event;
	uint32_t seen = 0;
	while (stilb_input_pads_next(pads, input_now_us(), &event)) { /* no waiting: all pads were found */
		char path[PATH_MAX], device[PATH_MAX], serial[16];
		assert_int_equal(event.kind, STILB_INPUT_PAD_ADDED);
		int node = event.info->vendor == ds4->vendor ? 3 : 12;
		const input_test_descriptor *pad = node == 3 ? ds4 : asus;
		seen |= 1u << node;
		fake_path(path, fake.dev, "hidraw%d", node);
		fake_path(device, fake.sys, "devices/pad%d", node);
		snprintf(serial, sizeof serial, "serial %d", node);
		assert_string_equal(event.info->path, path);
		assert_string_equal(event.info->device, device);
		assert_string_equal(event.info->name, pad->name);
		assert_string_equal(event.info->unique, serial);
		assert_int_equal(event.info->bus, pad->bus);
		assert_int_equal(event.info->product, pad->product);
		assert_int_equal(event.info->descriptor_size, pad->size);
		assert_memory_equal(event.info->descriptor, pad->bytes, pad->size);
		assert_in_range(event.time_us, before_us, input_now_us());
	}
	assert_int_equal(seen, 1u << 3 | 1u << 12);
}

static void a_pad_comes_reports_and_goes(void **state)
{
	(void)state;
	begin();
	for (uint32_t life = 1; life <= 3; life++) { /* on the same node: a number of its own each time */
		fake_plug(0, ds4);
		assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, life);
		for (uint32_t i = 0; i < 20; i++)
			send_number(0, i);
		fake_unplug(0);
		for (uint32_t i = 0; i < 20; i++) { /* the reports that it sent come before its REMOVED */
			stilb_input_event event = next();
			assert_int_equal(number_of(&event), i);
			assert_int_equal(event.pad, life);
		}
		assert_int_equal(next_of(STILB_INPUT_PAD_REMOVED).pad, life);
	}
	stilb_input_pads_stats stats = stilb_input_pads_stats_get(pads);
	assert_int_equal(stats.added, 3);
	assert_int_equal(stats.removed, 3);
	assert_int_equal(stats.reports, 60);
	assert_int_equal(stats.lost, 0);
}

/* HID 1.11, appendix B: the boot keyboard. */
static const uint8_t keyboard_bytes[] = {0x05, 0x01, 0x09, 0x06, 0xa1, 0x01, 0x05, 0x07, 0x19, 0xe0, 0x29, 0xe7,
                                         0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0x95, 0x01,
                                         0x75, 0x08, 0x81, 0x01, 0x95, 0x06, 0x75, 0x08, 0x15, 0x00, 0x25, 0x65,
                                         0x05, 0x07, 0x19, 0x00, 0x29, 0x65, 0x81, 0x00, 0xc0};
static const input_test_descriptor keyboard = {.name = "keyboard",
                                               .bytes = keyboard_bytes,
                                               .size = sizeof keyboard_bytes,
                                               .bus = 3,
                                               .vendor = 0x1234,
                                               .product = 1};

static void what_is_no_pad_is_left_alone(void **state)
{
	(void)state;
	static const char *const names[] = {"hidraw", "hidraw1x", "hidrawx", "hidraw99999999999999999999", "tty1"};
	fake_plug(0, &keyboard);
	begin();
	fake_plug(1, &keyboard);
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		char path[PATH_MAX];
		snprintf(path, sizeof path, "%s/%s", fake.dev, names[i]);
		fake_write(path, "", 0, 0600);
		unlink(path);
	}
	fake_plug(2, ds4);
	assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, 1);
	assert_true(fake.nodes[0].host >= 0 && fake.nodes[1].host >= 0); /* nobody has opened them */
	fake_unplug(1);
	assert_true(is_quiet(20));
}

static void a_pad_that_is_gone_at_once_is_no_pad(void **state)
{
	(void)state;
	begin();
	for (int i = 0; i < 20; i++) { /* sysfs is complete, incomplete or gone when it is read */
		fake_plug(0, ds4);
		fake_unplug(0);
	}
	fake_plug(1, asus);
	bool is_next = false;
	for (int alive = 0; alive != 0 || !is_next;) { /* each ADDED has its REMOVED */
		stilb_input_event event = next();
		assert_true(event.kind == STILB_INPUT_PAD_ADDED || event.kind == STILB_INPUT_PAD_REMOVED);
		if (event.info->vendor == asus->vendor)
			is_next = true;
		else
			alive += event.kind == STILB_INPUT_PAD_ADDED ? 1 : -1;
	}
}

/* A new pad is at the node before the frame has taken the old one's REMOVED. */
static void a_node_is_used_again_at_once(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin();
	assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, 1);
	fake_unplug(0);
	while (stilb_input_pads_stats_get(pads).removed == 0)
		sleep_ms(1);
	fake_plug(0, asus);
	while (stilb_input_pads_stats_get(pads).added == 1)
		sleep_ms(1);
	assert_int_equal(next_of(STILB_INPUT_PAD_REMOVED).pad, 1);
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	assert_int_equal(added.pad, 2);
	assert_int_equal(added.info->vendor, asus->vendor);
}

/* ---- permission -------------------------------------------------------------------------------------------------- */

static void a_pad_without_permission_is_told_of(void **state)
{
	(void)state;
	char rule[256];
	fake_plug_mode(5, ds4, 0);
	begin();
	stilb_input_event denied = next_of(STILB_INPUT_PAD_DENIED);
	assert_string_equal(stilb_input_udev_rule(denied.info, rule, sizeof rule),
	                    "KERNEL==\"hidraw*\", KERNELS==\"*:054C:05C4.*\", MODE=\"0660\", TAG+=\"uaccess\"");
	stilb_input_pads_rumble(pads, denied.pad, 1, 1, 100); /* does nothing for a denied pad */
	fake_chmod(5, 0200);
	assert_true(is_quiet(20));
	fake_chmod(5, 0600);
	assert_int_equal(next_of(STILB_INPUT_PAD_REMOVED).pad, denied.pad);
	uint32_t added = next_of(STILB_INPUT_PAD_ADDED).pad;
	assert_true(added > denied.pad);
	send_number(5, 7);
	stilb_input_event event = next();
	assert_int_equal(number_of(&event), 7);
	assert_int_equal(event.pad, added);
	assert_int_equal(stilb_input_pads_stats_get(pads).denied, 1);
}

static void a_denied_pad_goes(void **state)
{
	(void)state;
	fake_plug_mode(5, ds4, 0);
	begin();
	uint32_t denied = next_of(STILB_INPUT_PAD_DENIED).pad;
	fake_unplug(5);
	assert_int_equal(next_of(STILB_INPUT_PAD_REMOVED).pad, denied);
	fake_plug(5, ds4);
	next_of(STILB_INPUT_PAD_ADDED);
}

/* udev grants permission some time after the kernel has created the node. */
static void a_new_node_has_time_to_be_opened_up(void **state)
{
	(void)state;
	begin();
	int64_t before_us = input_now_us();
	fake_plug_mode(0, ds4, 0);
	fake_plug_mode(1, asus, 0);
	sleep_ms(30);
	fake_chmod(0, 0600);
	assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).info->vendor, ds4->vendor);
	stilb_input_event denied = next_of(STILB_INPUT_PAD_DENIED); /* permission did not come in its time of grace */
	assert_int_equal(denied.info->vendor, asus->vendor);
	assert_in_range(denied.time_us - before_us, 500000, 5000000);
	fake_plug_mode(2, ds4, 0);
	sleep_ms(10);
	fake_unplug(2); /* within the time for which a new node may still get permission */
	assert_true(is_quiet(10));
}

/* ---- reports ----------------------------------------------------------------------------------------------------- */

static void events_come_in_time_order_until_a_time(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	fake_plug(1, ds4);
	begin();
	next_of(STILB_INPUT_PAD_ADDED);
	next_of(STILB_INPUT_PAD_ADDED);
	int64_t before_us = input_now_us();
	for (uint32_t i = 0; i < 40; i++) {
		send_number((int)(i & 1), i);
		do /* until the pad's reader has read the report */
			sleep_ms(1);
		while (stilb_input_pads_stats_get(pads).reports <= i);
	}
	stilb_input_event event;
	assert_false(stilb_input_pads_next(pads, before_us, &event));
	int64_t last_us = before_us;
	uint32_t count = 0;
	for (int64_t until_us = before_us; until_us < input_now_us(); until_us += 5000)
		for (; stilb_input_pads_next(pads, until_us, &event); count++) {
			assert_in_range(event.time_us, last_us, until_us);
			assert_int_equal(number_of(&event), count); /* those of both pads in turns, as they were sent */
			last_us = event.time_us;
		}
	for (; stilb_input_pads_next(pads, INT64_MAX, &event); count++)
		assert_int_equal(number_of(&event), count);
	assert_int_equal(count, 40);
}

/* Without asserts, which belong to the main thread; who has been closed meanwhile sends no more. */
static void *stall_send(void *user)
{
	int64_t *sent_us = user;
	for (uint32_t i = 0; i < 600; i++) {
		uint8_t report[64] = {1, 128, 128, 128, 128, 8};
		memcpy(report + 40, &i, sizeof i);
		sent_us[i] = input_now_us();
		if (!fake_send(0, report, sizeof report))
			break;
		usleep(700);
	}
	return NULL;
}

/* The frame stalls until a pad has reported 300 times: no report is lost, and each has the time of its own. */
static void a_stalled_frame_loses_nothing(void **state)
{
	(void)state;
	static int64_t sent_us[600];
	pthread_t sender;
	fake_plug(0, ds4);
	begin();
	next_of(STILB_INPUT_PAD_ADDED);
	assert_int_equal(pthread_create(&sender, NULL, stall_send, sent_us), 0);
	while (stilb_input_pads_stats_get(pads).reports < 300)
		sleep_ms(1);
	int64_t stalled_until_us = input_now_us(), times_us[600];
	stilb_input_event event;
	uint32_t count = 0;
	for (; count < 600 && stilb_input_pads_next(pads, INT64_MAX, &event); count++) {
		assert_int_equal(number_of(&event), count);
		times_us[count] = event.time_us;
	}
	assert_in_range(count, 300, 600); /* the frame gets all reports of the stall at once */
	for (; count < 600; count++) {
		event = next();
		assert_int_equal(number_of(&event), count);
		times_us[count] = event.time_us;
	}
	pthread_join(sender, NULL);
	assert_int_equal(stilb_input_pads_stats_get(pads).lost, 0);
	for (uint32_t i = 0; i < 600; i++)
		assert_true(times_us[i] >= sent_us[i]);
	for (uint32_t i = 0; i < 300; i++) /* not the time of the frame that takes it */
		assert_true(times_us[i] <= stalled_until_us);
}

/* With a full ring reports are lost and counted, but never the newest. */
static void a_full_ring_keeps_the_newest(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin_kib(16);
	next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_event event;
	assert_false(stilb_input_pads_next(pads, INT64_MAX, &event));
	for (uint32_t i = 0; i < 1000; i++)
		send_number(0, i);
	while (stilb_input_pads_stats_get(pads).reports < 1000)
		sleep_ms(1);
	uint32_t count = 0, last = 0;
	for (; last != 999; count++) {
		event = next();
		last = number_of(&event);
		assert_true(last == count || last == 999); /* first the oldest ones in order, then the newest of all */
	}
	assert_in_range(count, 16384 / (64 + 32), 16384 / 64 + 1);
	assert_int_equal(stilb_input_pads_stats_get(pads).lost, 1000 - count);
	send_number(0, 1000);
	event = next();
	assert_int_equal(number_of(&event), 1000);
}

static void a_full_ring_ends_with_the_newest(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin_kib(16);
	next_of(STILB_INPUT_PAD_ADDED);
	for (uint32_t i = 0; i < 1000; i++)
		send_number(0, i);
	fake_unplug(0);
	while (stilb_input_pads_stats_get(pads).removed == 0)
		sleep_ms(1);
	stilb_input_event event;
	uint32_t last = 0;
	for (event = next(); event.kind == STILB_INPUT_PAD_REPORT; event = next())
		last = number_of(&event);
	assert_int_equal(last, 999);
	assert_int_equal(event.kind, STILB_INPUT_PAD_REMOVED);
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static void assert_shakes(int node, const stilb_input_layout *layout, float heavy, float light, uint32_t sequence)
{
	uint8_t wanted[STILB_INPUT_OUTPUT_MAX], got[STILB_INPUT_OUTPUT_MAX];
	size_t size = stilb_input_rumble_report(layout, heavy, light, sequence, wanted);
	assert_true(size > 0);
	assert_int_equal(fake_receive(node, got, sizeof got, 5000), size);
	assert_memory_equal(got, wanted, size);
}

static stilb_input_layout layout_of(const stilb_input_pad_info *info)
{
	stilb_input_layout layout;
	assert_int_equal(stilb_input_layout_find(info, &layout), STILB_OK);
	return layout;
}

static void a_pad_shakes_for_a_while(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin();
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_layout layout = layout_of(added.info);
	uint32_t pad = added.pad;
	int64_t before_us = input_now_us();
	stilb_input_pads_rumble(pads, pad, 1.0f, 0.25f, 60);
	assert_shakes(0, &layout, 1.0f, 0.25f, 0);
	assert_shakes(0, &layout, 0, 0, 1);
	assert_in_range(input_now_us() - before_us, 60000, 5000000);
	stilb_input_pads_rumble(pads, pad, 1.5f, 0, 60000); /* values beyond the ranges */
	stilb_input_pads_rumble(pads, pad + 1, 1, 1, 100);  /* no such pad */
	assert_shakes(0, &layout, 1, 0, 2);
	stilb_input_pads_rumble(pads, pad, __builtin_nanf(""), 1, 0); /* for no time: it stops at once */
	assert_shakes(0, &layout, 0, 0, 3);
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	assert_int_equal(fake_receive(0, report, sizeof report, 50), 0); /* stopped already: no further report at the end */
	assert_int_equal(stilb_input_pads_stats_get(pads).written, 4);
}

/* Requests come faster than rumble reports may be sent: those in between are skipped, and the newest is sent. */
static void rumble_is_limited_in_rate(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin();
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_layout layout = layout_of(added.info);
	stilb_input_pads_rumble(pads, added.pad, 0.5f, 0, 5000);
	assert_shakes(0, &layout, 0.5f, 0, 0);
	int64_t before_us = input_now_us();
	for (int i = 0; i <= 500; i++) {
		stilb_input_pads_rumble(pads, added.pad, (float)i / 500, (float)i / 500, 5000);
		usleep(100);
	}
	uint8_t report[STILB_INPUT_OUTPUT_MAX], newest[STILB_INPUT_OUTPUT_MAX];
	uint32_t count = 0;
	size_t size;
	do { /* until the report of the newest request has come, which depends on the number of reports */
		size = stilb_input_rumble_report(&layout, 1, 1, ++count, newest);
		assert_int_equal(fake_receive(0, report, sizeof report, 5000), size);
	} while (memcmp(report, newest, size) != 0);
	assert_in_range(count, 1, 1 + (input_now_us() - before_us) / 30000); /* of 501 requests one in 30 ms is sent */
}

/* A Switch Pro stops by itself unless the report is repeated. */
static void what_forgets_to_shake_is_reminded(void **state)
{
	(void)state;
	fake_plug(0, input_test_descriptor_find(STILB_INPUT_BUS_BLUETOOTH, 0x057e, 0x2009));
	begin();
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_layout layout = layout_of(added.info);
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	for (const stilb_input_hello *hello = layout.hello; hello->kind != STILB_INPUT_HELLO_END; hello++)
		assert_int_equal(fake_receive(0, report, sizeof report, 5000), hello->size);
	uint8_t wanted[STILB_INPUT_OUTPUT_MAX];
	uint32_t count = 0;
	size_t size;
	stilb_input_pads_rumble(pads, added.pad, 1, 0.5f, 200);
	do {
		size = stilb_input_rumble_report(&layout, 1, 0.5f, count, wanted);
		assert_int_equal(fake_receive(0, report, sizeof report, 5000), size);
		count++;
	} while (memcmp(report, wanted, size) == 0);
	assert_in_range(count, 3, 6); /* at 0, 40, ... 160 ms, or later; then it is still, and stays so */
	stilb_input_rumble_report(&layout, 0, 0, count - 1, wanted);
	assert_memory_equal(report, wanted, size);
	assert_int_equal(fake_receive(0, report, sizeof report, 60), 0);
}

static void what_shakes_is_stopped_at_the_end(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin();
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_layout layout = layout_of(added.info);
	stilb_input_pads_rumble(pads, added.pad, 1, 1, 5000);
	assert_shakes(0, &layout, 1, 1, 0);
	stilb_input_pads_destroy(pads);
	pads = NULL;
	assert_shakes(0, &layout, 0, 0, 1);
	uint8_t report[1];
	assert_int_equal(recv(fake.nodes[0].device, report, 1, 0), 0); /* and the node is closed */
}

/* The program ends while the report that stops a rumble has to wait, as reports may be 30 ms apart at least. */
static void what_should_have_stopped_is_stopped_at_the_end(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	begin();
	stilb_input_event added = next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_layout layout = layout_of(added.info);
	stilb_input_pads_rumble(pads, added.pad, 1, 1, 5);
	assert_shakes(0, &layout, 1, 1, 0);
	sleep_ms(10);
	stilb_input_pads_destroy(pads);
	pads = NULL;
	assert_shakes(0, &layout, 0, 0, 1);
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	assert_int_equal(fake_receive(0, report, sizeof report, 0), 0); /* the stop was sent only once */
}

static void a_pad_that_does_not_answer_is_waited_for(void **state)
{
	(void)state;
	uint32_t fds = count_entries("/proc/self/fd");
	fake.feature_ms = 100;
	fake_plug(0, input_test_descriptor_find(STILB_INPUT_BUS_BLUETOOTH, 0x054c, 0x05c4));
	begin();
	next_of(STILB_INPUT_PAD_ADDED);
	stilb_input_pads_destroy(pads);
	pads = NULL;
	assert_int_equal(count_entries("/proc/self/fd"), fds + 1); /* only the simulated pad's end is open */
}

static void a_pad_is_greeted(void **state)
{
	(void)state;
	const input_test_descriptor *bluetooth = input_test_descriptor_find(STILB_INPUT_BUS_BLUETOOTH, 0x054c, 0x05c4);
	assert_non_null(bluetooth);
	fake_plug(0, bluetooth);
	begin();
	stilb_input_layout layout = layout_of(next_of(STILB_INPUT_PAD_ADDED).info);
	assert_int_equal(layout.hello[0].kind, STILB_INPUT_HELLO_GET_FEATURE);
	send_number(0, 0); /* read after the greeting */
	next_of(STILB_INPUT_PAD_REPORT);
	pthread_mutex_lock(&fake.lock);
	assert_true(fake.feature_count > 0);
	assert_int_equal(fake.features[0], layout.hello[0].bytes[0]);
	pthread_mutex_unlock(&fake.lock);
}

/* ---- many -------------------------------------------------------------------------------------------------------- */

static uint32_t lives = 100; /* how many times a pad comes and goes; the program's argument replaces it */

static void many_lives_leave_nothing(void **state)
{
	(void)state;
	uint32_t before = count_entries("/proc/self/fd");
	begin();
	uint32_t fds = count_entries("/proc/self/fd"), threads = count_entries("/proc/self/task");
	for (uint32_t i = 0; i < lives; i++) {
		fake_plug((int)(i % 3), ds4);
		assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, i + 1);
		fake_unplug((int)(i % 3));
		next_of(STILB_INPUT_PAD_REMOVED);
	}
	assert_true(is_quiet(1)); /* takes the last REMOVED, so that the reader can be destroyed */
	for (int i = 0; i < 5000 && count_entries("/proc/self/fd") > fds; i++)
		sleep_ms(1); /* the last pad's descriptors are closed after its REMOVED was taken */
	assert_int_equal(count_entries("/proc/self/task"), threads);
	assert_int_equal(count_entries("/proc/self/fd"), fds);
	stilb_input_pads_destroy(pads);
	pads = NULL;
	assert_int_equal(count_entries("/proc/self/fd"), before);
}

/* More pads than slots: the others are added when some have gone. */
static void a_crowd_waits_for_room(void **state)
{
	(void)state;
	begin();
	for (int i = 0; i < 40; i++)
		fake_plug(i, ds4);
	for (int i = 0; i < 32; i++)
		next_of(STILB_INPUT_PAD_ADDED);
	assert_true(is_quiet(20));
	for (int i = 0; i < 40; i++)
		if (fake.nodes[i].host < 0)
			fake_unplug(i);
	uint32_t added = 0, removed = 0;
	while (added < 8 || removed < 32) {
		stilb_input_event event = next();
		added += event.kind == STILB_INPUT_PAD_ADDED;
		removed += event.kind == STILB_INPUT_PAD_REMOVED;
	}
	assert_int_equal(added + removed, 40);
}

/* When inotify's queue overflows all nodes are scanned. */
static void a_flood_of_events_hides_no_pad(void **state)
{
	(void)state;
	uint32_t kept = 0;
	FILE *file = fopen("/proc/sys/fs/inotify/max_queued_events", "r");
	if (!file || fscanf(file, "%u", &kept) != 1 || kept > 100000)
		skip();
	fclose(file);
	char denied[PATH_MAX], plugged[PATH_MAX], path[PATH_MAX];
	fake_path(denied, fake.dev, "hidraw%d", 1);
	fake_path(plugged, fake.dev, "hidraw%d", 2);
	fake_plug_mode(1, asus, 0);
	fake_plug(2, ds4);
	unlink(plugged); /* the node is missing in /dev, while sysfs has the device */
	begin();
	next_of(STILB_INPUT_PAD_DENIED);
	pthread_mutex_lock(&fake.lock); /* holds the watcher up when it opens the next node */
	fake_describe(7, ds4, NULL);
	fake_path(path, fake.dev, "hidraw%d", 7);
	fake_write(path, "", 0, 0600);
	for (uint32_t i = 0; i < kept; i++) {
		fake_path(path, fake.dev, "other%d", (int)(i & 1));
		fake_write(path, "", 0, 0600);
		unlink(path);
	}
	fake_write(plugged, "", 0, 0600); /* no inotify event for these two */
	unlink(denied);
	fake_path(path, fake.sys, "class/hidraw/hidraw%d/device", 1);
	unlink(path);
	*strrchr(path, '/') = '\0';
	rmdir(path);
	pthread_mutex_unlock(&fake.lock);
	bool is_added = false, is_removed = false;
	while (!is_added || !is_removed) {
		stilb_input_event event = next();
		is_added |= event.kind == STILB_INPUT_PAD_ADDED;
		is_removed |= event.kind == STILB_INPUT_PAD_REMOVED;
	}
}

/* ---- waiting ----------------------------------------------------------------------------------------------------- */

static void *answer(void *user)
{
	(void)user;
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	for (uint32_t i = 0; fake_receive(0, report, sizeof report, 100) == 0 && i < 2000; i++)
		;
	for (uint32_t i = 0; i < 500; i++) {
		send_number(0, i);
		if (i % 50 == 0)
			sleep_ms(1); /* sometimes the waiter sleeps, sometimes it is about to */
	}
	return NULL;
}

static void who_waits_is_told(void **state)
{
	(void)state;
	pthread_t sender;
	fake_plug(0, ds4);
	begin();
	uint32_t pad = next_of(STILB_INPUT_PAD_ADDED).pad;
	assert_int_equal(pthread_create(&sender, NULL, answer, NULL), 0);
	stilb_input_pads_rumble(pads, pad, 1, 1, 5000);
	for (uint32_t i = 0; i < 500;) {
		int64_t before_us = input_now_us();
		stilb_input_pads_wait(pads, 30000);
		assert_true(input_now_us() - before_us < 15000000);
		for (stilb_input_event event; stilb_input_pads_next(pads, INT64_MAX, &event); i++)
			assert_int_equal(number_of(&event), i);
	}
	pthread_join(sender, NULL);
}

/* ---- failures ---------------------------------------------------------------------------------------------------- */

/* Read by the watcher: atomic, relaxed, because no other data depends on them. */
static int threads_before_failure = -1; /* so many threads are created, then one fails; -1: none fails */
static bool memory_fails;

static void fail_thread(int threads_before)
{
	__atomic_store_n(&threads_before_failure, threads_before, __ATOMIC_RELAXED);
}

static void fail_memory(bool fails)
{
	__atomic_store_n(&memory_fails, fails, __ATOMIC_RELAXED);
}

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *user);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *user);
void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *user)
{
	int before = __atomic_load_n(&threads_before_failure, __ATOMIC_RELAXED);
	if (before >= 0)
		fail_thread(before - 1);
	if (before == 0)
		return EAGAIN;
	return __real_pthread_create(thread, attributes, run, user);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return __atomic_load_n(&memory_fails, __ATOMIC_RELAXED) ? NULL : __real_stilb_memory_alloc(count, size);
}

/* After a failure to read a pad nothing leaks, and the next pad is still read. */
static void a_pad_that_cannot_be_read_is_left(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	fail_thread(1);
	begin();
	fail_thread(-1);
	assert_true(is_quiet(1));
	uint8_t report[1];
	assert_int_equal(recv(fake.nodes[0].device, report, 1, 0), 0); /* the node is closed again */
	fake_unplug(0);
	fake_plug(1, ds4);
	assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, 1);
}

static void a_pad_without_memory_is_left(void **state)
{
	(void)state;
	fake_plug(0, ds4);
	fail_memory(true);
	begin();
	fail_memory(false);
	assert_true(is_quiet(1));
	fake_chmod(0, 0600); /* the watcher looks at the node again when its mode changes */
	assert_int_equal(next_of(STILB_INPUT_PAD_ADDED).pad, 1);
}

static void assert_is_refused(stilb_result result, const char *text)
{
	stilb_input_pads_desc desc = {.sys = fake.sys, .dev = fake.dev};
	assert_int_equal(stilb_input_pads_create(&desc, &pads), result);
	assert_null(pads);
	assert_non_null(strstr(stilb_error_message(), text));
}

static void nothing_to_watch_with_is_said(void **state)
{
	(void)state;
	uint32_t fds = count_entries("/proc/self/fd");
	fail_thread(0);
	assert_is_refused(STILB_ERROR_THREAD, fake.dev);
	struct rlimit limit, none;
	assert_int_equal(getrlimit(RLIMIT_NOFILE, &limit), 0);
	none = (struct rlimit){.rlim_cur = 0, .rlim_max = limit.rlim_max};
	assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
	assert_is_refused(STILB_ERROR_DEVICE, "ulimit -n");
	assert_int_equal(setrlimit(RLIMIT_NOFILE, &limit), 0);
	assert_int_equal(count_entries("/proc/self/fd"), fds);
}

static void nothing_to_watch_is_said(void **state)
{
	(void)state;
	stilb_input_pads_desc desc = {.sys = fake.sys, .dev = "/nonexistent/dev"};
	uint32_t fds = count_entries("/proc/self/fd");
	assert_int_equal(stilb_input_pads_create(&desc, &pads), STILB_ERROR_DEVICE);
	assert_null(pads);
	assert_non_null(strstr(stilb_error_message(), "/nonexistent/dev"));
	assert_int_equal(count_entries("/proc/self/fd"), fds);
	stilb_input_pads_destroy(NULL);
}

static void a_machine_without_hid_has_no_pads(void **state)
{
	(void)state;
	stilb_input_pads_desc desc = {.sys = "/nonexistent/sys", .dev = fake.dev};
	assert_int_equal(stilb_input_pads_create(&desc, &pads), STILB_OK);
	stilb_input_pads_wait(pads, 300000);
	assert_true(is_quiet(1));
	int64_t before_us = input_now_us();
	stilb_input_pads_wait(pads, 20);
	assert_true(input_now_us() - before_us >= 20000);
}

/* Argument: how many pads come and go; with it the long tests run too. */
int main(int argc, char **argv)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)
	struct CMUnitTest tests[] = {
		TEST(pads_there_at_the_start_are_added),
		TEST(a_pad_comes_reports_and_goes),
		TEST(what_is_no_pad_is_left_alone),
		TEST(a_pad_that_is_gone_at_once_is_no_pad),
		TEST(a_node_is_used_again_at_once),
		TEST(a_pad_without_permission_is_told_of),
		TEST(a_denied_pad_goes),
		TEST(a_new_node_has_time_to_be_opened_up),
		TEST(events_come_in_time_order_until_a_time),
		TEST(a_stalled_frame_loses_nothing),
		TEST(a_full_ring_keeps_the_newest),
		TEST(a_full_ring_ends_with_the_newest),
		TEST(a_pad_shakes_for_a_while),
		TEST(rumble_is_limited_in_rate),
		TEST(what_forgets_to_shake_is_reminded),
		TEST(what_shakes_is_stopped_at_the_end),
		TEST(what_should_have_stopped_is_stopped_at_the_end),
		TEST(a_pad_that_does_not_answer_is_waited_for),
		TEST(a_pad_is_greeted),
		TEST(many_lives_leave_nothing),
		TEST(a_crowd_waits_for_room),
		TEST(who_waits_is_told),
		TEST(a_pad_that_cannot_be_read_is_left),
		TEST(a_pad_without_memory_is_left),
		TEST(nothing_to_watch_with_is_said),
		TEST(nothing_to_watch_is_said),
		TEST(a_machine_without_hid_has_no_pads),
	};
	struct CMUnitTest long_tests[] = {
		TEST(many_lives_leave_nothing),
		TEST(a_flood_of_events_hides_no_pad),
	};
	if (argc < 2)
		return cmocka_run_group_tests_name("input_pads", tests, NULL, NULL);
	lives = (uint32_t)strtoul(argv[1], NULL, 10);
	return cmocka_run_group_tests_name("input_pads, long", long_tests, NULL, NULL);
}
