/* Pads on a real kernel: pads simulated through /dev/uhid are found, read, made to rumble and lost by both backends at
 * once. Runs in the virtual machine of boot.sh, as root, with the modules that init.sh loads. */
#include "support/input_descriptors.h"
#include "support/test.h"
#include "vm/vm_ds4.h"
#include "vm/vm_fixture.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/input.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define USB "00:00:00:00:00:01"

static const input_test_descriptor *ds4(uint16_t bus)
{
	const input_test_descriptor *kind = input_test_descriptor_find(bus, 0x054c, 0x05c4);
	assert_non_null(kind);
	return kind;
}

/* ---- finding pads ------------------------------------------------------------------------------------------------ */

/* HID 1.11, appendix E.10: a mouse of three buttons. */
static const uint8_t mouse_bytes[] = {0x05, 0x01, 0x09, 0x02, 0xa1, 0x01, 0x09, 0x01, 0xa1, 0x00, 0x05, 0x09, 0x19,
                                      0x01, 0x29, 0x03, 0x15, 0x00, 0x25, 0x01, 0x95, 0x03, 0x75, 0x01, 0x81, 0x02,
                                      0x95, 0x01, 0x75, 0x05, 0x81, 0x01, 0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15,
                                      0x81, 0x25, 0x7f, 0x75, 0x08, 0x95, 0x02, 0x81, 0x06, 0xc0, 0xc0};
static const input_test_descriptor mouse = {"Mouse", mouse_bytes, sizeof mouse_bytes, BUS_USB, 0x1234, 0x5678};

static void check_info(const vm_heard *heard, const input_test_descriptor *kind)
{
	assert_non_null(heard);
	assert_false(heard->denied);
	assert_true(heard->is_pad);
	assert_string_equal(heard->info.name, kind->name);
	assert_int_equal(heard->info.bus, kind->bus);
	assert_int_equal(heard->info.vendor, kind->vendor);
	assert_int_equal(heard->info.product, kind->product);
	assert_int_equal(heard->info.descriptor_size, kind->size);
	assert_memory_equal(heard->info.descriptor, kind->bytes, kind->size);
	assert_memory_equal(heard->info.path, "/dev/hidraw", 11);
	assert_memory_equal(heard->info.device, "/sys/devices/", 13);
}

#define AT_ONCE 8u

static void find_pads(vm_fixture *fixture, const input_test_descriptor *kinds, uint32_t count)
{
	vm_fixture *late;
	uhid_pad *pads[AT_ONCE];
	char unique[AT_ONCE][16];
	for (uint32_t i = 0; i < count; i++) {
		snprintf(unique[i], sizeof unique[i], "pad %u", i);
		pads[i] = vm_fixture_plug(fixture, &kinds[i], unique[i]);
	}
	vm_fixture_open((void **)&late); /* finds pads that are plugged in already, like a program that starts */
	for (uint32_t i = 0; i < count; i++) {
		vm_fixture_wait(fixture, unique[i], true);
		vm_fixture_wait(late, unique[i], true);
		for (int side = 0; side < VM_SIDES; side++) {
			check_info(vm_fixture_find(fixture, side, unique[i]), &kinds[i]);
			check_info(vm_fixture_find(late, side, unique[i]), &kinds[i]);
		}
		printf("  %-40s %s\n", kinds[i].name, vm_fixture_find(fixture, 0, unique[i])->layout.recognised);
	}
	vm_fixture_close((void **)&late);
	for (uint32_t i = 0; i < count; i++) {
		vm_fixture_pull(fixture, pads[i]);
		vm_fixture_wait(fixture, unique[i], false);
	}
}

static void test_every_pad_is_found(void **state)
{
	vm_fixture *fixture = *state;
	vm_fixture_plug(fixture, &mouse, "mouse");
	uint32_t count = (uint32_t)input_test_descriptor_count;
	for (uint32_t i = 0; i < count; i += AT_ONCE)
		find_pads(fixture, input_test_descriptors + i, count - i < AT_ONCE ? count - i : AT_ONCE);
	for (int side = 0; side < VM_SIDES; side++)
		assert_null(vm_fixture_find(fixture, side, "mouse"));
}

/* A pad whose node this user may not open is DENIED, with the udev rule that would permit it; once the node's mode
 * allows it the pad is ADDED. Runs in a child process as another user. */
static int denied_then_granted(const char *path)
{
	vm_fixture *fixture;
	if (setresuid(1000, 1000, 1000) != 0)
		return 2;
	vm_fixture_open((void **)&fixture);
	vm_fixture_wait(fixture, USB, true);
	for (int side = 0; side < VM_SIDES; side++) {
		const vm_heard *heard = vm_fixture_find(fixture, side, USB);
		char rule[1024];
		stilb_input_udev_rule(&heard->info, rule, sizeof rule);
		if (!heard->denied || strcmp(heard->info.path, path) != 0 || !strstr(rule, "054C:05C4"))
			return 3;
	}
	puts("denied"); /* the parent now changes the mode, as udev does */
	fflush(stdout);
	for (int i = 0; i < 500; i++) {
		vm_fixture_run(fixture, 10000);
		const vm_heard *a = vm_fixture_find(fixture, 0, USB), *b = vm_fixture_find(fixture, 1, USB);
		if (a && b && !a->denied && !b->denied)
			return vm_fixture_close((void **)&fixture);
	}
	return 4;
}

static void test_no_permission(void **state)
{
	vm_fixture *fixture = *state;
	vm_fixture_plug(fixture, ds4(BUS_USB), USB);
	vm_fixture_wait(fixture, USB, true); /* root may open it */
	char path[64];
	snprintf(path, sizeof path, "%s", vm_fixture_find(fixture, 0, USB)->info.path);
	assert_int_equal(chmod(path, 0600), 0);
	int said[2];
	assert_int_equal(pipe2(said, O_CLOEXEC), 0);
	pid_t child = fork();
	if (child == 0) {
		dup2(said[1], STDOUT_FILENO);
		execl("/proc/self/exe", "denied", "denied", path, NULL);
		_exit(127);
	}
	close(said[1]);
	char word[8];
	assert_int_equal(read(said[0], word, sizeof word), 7);
	assert_int_equal(chmod(path, 0666), 0);
	int status;
	assert_int_equal(waitpid(child, &status, 0), child);
	assert_int_equal(status, 0);
	close(said[0]);
}

/* ---- reports ----------------------------------------------------------------------------------------------------- */

#define FLIGHT 500u
#define CORRUPT 10u
#define SHAKE_BYTES 10u /* of a rumble report: all bytes with strengths */

static size_t forward(uint32_t number, uint8_t *report)
{
	return vm_ds4_usb(number, 0, report);
}

/* At rest; one in fifty reports pushes the stick forward and has one wrong bit. */
static size_t rest_or_corrupt(uint32_t number, uint8_t *report)
{
	bool corrupt = number % (FLIGHT / CORRUPT) == 0;
	size_t size = vm_ds4_bluetooth(number, corrupt ? 0 : 128, report);
	report[size - 1 - number / (FLIGHT / CORRUPT)] ^= corrupt ? 0x10 : 0;
	return size;
}

static uint32_t missing(const vm_heard *heard, uint32_t count)
{
	uint32_t lost = 0;
	for (uint32_t number = 1; number <= count; number++)
		lost += heard->stamped_us[number] == 0;
	return lost;
}

/* Time from the pad's write to the backend's stamp. */
typedef struct latency {
	int64_t median, p99, longest; /* us; p99: 99 % of the reports took less */
} latency;

static latency print_latency(const vm_side *side, const vm_heard *heard, const vm_sender *sender)
{
	static int64_t took[VM_REPORTS];
	uint32_t count = 0;
	for (uint32_t number = 1; number <= sender->count; number++) {
		if (heard->stamped_us[number] != 0)
			took[count++] = heard->stamped_us[number] - sender->sent_us[number];
	}
	assert_true(count > 0);
	latency all = {.median = vm_median(took, count)}; /* sorts `took`, as p99 needs it */
	all.p99 = took[count * 99 / 100];
	all.longest = took[count - 1];
	printf("  %s: %u sent, %u lost, sent to stamped: median %lld us, p99 %lld us, max %lld us\n", side->name,
	       sender->count, sender->count - count, (long long)all.median, (long long)all.p99, (long long)all.longest);
	return all;
}

static bool moved(const stilb_input_pose *pose)
{
	return pose->position[0] != 0 || pose->position[1] != 0 || pose->position[2] != 0 || pose->yaw != 0 ||
	       pose->pitch != 0;
}

/* Two DualShock 4 with the driver hid-generic, and two with hid-sony, which requests features, writes reports of its
 * own and drops corrupt ones. Those on USB push forward all the time; those on Bluetooth are at rest, except in their
 * corrupt reports. */
static const struct flyer {
	const char *unique;
	uint16_t bus;
	bool sony;
} flyers[] = {{"00:00:00:00:00:01", BUS_USB, false},
              {"00:00:00:00:00:02", BUS_BLUETOOTH, false},
              {"00:00:00:00:00:03", BUS_USB, true},
              {"00:00:00:00:00:04", BUS_BLUETOOTH, true}};
#define FLYERS 4

static void check_driver(const vm_heard *heard, const char *wanted)
{
	char link[512], target[512];
	snprintf(link, sizeof link, "%s/driver", heard->info.device);
	ssize_t size = readlink(link, target, sizeof target - 1);
	assert_true(size > 0);
	target[size] = '\0';
	assert_string_equal(strrchr(target, '/') + 1, wanted);
}

static void plug_flyers(vm_fixture *fixture, uhid_pad *pads[FLYERS])
{
	for (int i = 0; i < FLYERS; i++) {
		vm_module_set("hid", "ignore_special_drivers", flyers[i].sony ? "0" : "1");
		pads[i] = vm_fixture_plug(fixture, ds4(flyers[i].bus), flyers[i].unique);
	}
	vm_module_set("hid", "ignore_special_drivers", "1");
	for (int i = 0; i < FLYERS; i++) {
		vm_fixture_wait(fixture, flyers[i].unique, true);
		check_driver(vm_fixture_find(fixture, 0, flyers[i].unique), flyers[i].sony ? "sony" : "hid-generic");
	}
}

/* Each backend makes each pad rumble with other strengths, and the rumble stops after its time. */
static void shake_flyers(vm_fixture *fixture, uhid_pad *const pads[FLYERS])
{
	uint8_t wanted[FLYERS][STILB_INPUT_OUTPUT_MAX];
	for (int side = 0; side < VM_SIDES; side++) {
		float heavy = side == 0, light = side == 1;
		for (int i = 0; i < FLYERS; i++) {
			const vm_heard *heard = vm_fixture_find(fixture, side, flyers[i].unique);
			assert_true(stilb_input_rumble_report(&heard->layout, heavy, light, 0, wanted[i]) > SHAKE_BYTES);
			stilb_input_pads_rumble(fixture->sides[side].pads, heard->pad, heavy, light, 50);
		}
		vm_fixture_run(fixture, 200000);
		for (int i = 0; i < FLYERS; i++)
			assert_int_equal(uhid_pad_outputs(pads[i], wanted[i], SHAKE_BYTES), 1);
	}
	for (int i = 0; i < FLYERS; i++) {
		stilb_input_rumble_report(&vm_fixture_find(fixture, 0, flyers[i].unique)->layout, 0, 0, 0, wanted[i]);
		assert_int_equal(uhid_pad_outputs(pads[i], wanted[i], SHAKE_BYTES), VM_SIDES);
	}
}

static void check_cable(const vm_side *side, const vm_heard *heard, const vm_sender *sender)
{
	print_latency(side, heard, sender);
	assert_int_equal(heard->decoded, FLIGHT);
	assert_int_equal(missing(heard, FLIGHT), 0);
	assert_int_equal(heard->disorders, 0);
	assert_true(heard->pose.position[2] < -1); /* forward is -Z */
}

static void check_corrupt(const vm_side *side, const vm_heard *heard, bool sony)
{
	printf("  %s: %u sent over Bluetooth, %u of them corrupt: %u good, %u rejected here, %u by hid-sony\n", side->name,
	       FLIGHT, CORRUPT, heard->decoded, heard->corrupt, FLIGHT - heard->decoded - heard->corrupt);
	assert_int_equal(heard->decoded, FLIGHT - CORRUPT);
	assert_int_equal(heard->corrupt, sony ? 0 : CORRUPT);
	assert_int_equal(heard->disorders, 0);
	assert_false(moved(&heard->pose));
}

static void test_flight(void **state)
{
	static vm_sender senders[FLYERS];
	vm_fixture *fixture = *state;
	uhid_pad *pads[FLYERS];
	fixture->number = vm_ds4_number;
	plug_flyers(fixture, pads);
	shake_flyers(fixture, pads);
	for (int i = 0; i < FLYERS; i++) {
		bool cable = flyers[i].bus == BUS_USB;
		assert_true(cable || uhid_pad_features(pads[i]) > 0); /* else it would go on sending short reports */
		senders[i] = (vm_sender){
			.pad = pads[i], .count = FLIGHT, .period_us = 4000, .report = cable ? forward : rest_or_corrupt};
		vm_sender_start(&senders[i]);
	}
	for (int i = 0; i < FLYERS; i++) {
		while (vm_sender_runs(&senders[i]))
			vm_fixture_run(fixture, VM_FRAME_US);
		vm_sender_finish(&senders[i]);
	}
	vm_fixture_run(fixture, 3 * VM_FRAME_US);
	for (int i = 0; i < FLYERS; i++) {
		for (int side = 0; side < VM_SIDES; side++) {
			const vm_heard *heard = vm_fixture_find(fixture, side, flyers[i].unique);
			if (flyers[i].bus == BUS_USB)
				check_cable(&fixture->sides[side], heard, &senders[i]);
			else
				check_corrupt(&fixture->sides[side], heard, flyers[i].sony);
		}
	}
}

static void test_pulled_in_flight(void **state)
{
	static vm_sender sender;
	vm_fixture *fixture = *state;
	stilb_input_pose stopped[VM_SIDES];
	fixture->number = vm_ds4_number;
	for (int round = 0; round < 2; round++) { /* in the second round it is plugged in again */
		uhid_pad *pad = vm_fixture_plug(fixture, ds4(BUS_USB), USB);
		vm_fixture_wait(fixture, USB, true);
		sender = (vm_sender){.pad = pad, .count = 25, .period_us = 4000, .report = forward};
		vm_sender_start(&sender);
		while (vm_sender_runs(&sender))
			vm_fixture_run(fixture, VM_FRAME_US);
		vm_sender_finish(&sender);
		vm_fixture_pull(fixture, pad); /* the stick is still pushed */
		vm_fixture_wait(fixture, USB, false);
		for (int k = 0; k < 2; k++) {
			for (int i = 0; i < VM_SIDES; i++) {
				const vm_heard *heard = &fixture->sides[i].heard[0];
				assert_true(heard->removed);
				assert_true(heard->pose.position[2] < 0);
				if (k == 0)
					stopped[i] = heard->pose;
				else
					assert_memory_equal(&stopped[i], &heard->pose, sizeof stopped[i]);
			}
			vm_fixture_run(fixture, 50000);
		}
	}
}

/* ---- a frame that takes too long --------------------------------------------------------------------------------- */

/* For comparison: a program without a reader thread, which reads once a frame. */
typedef struct per_frame {
	int fd;
	uint32_t count, last_number;
} per_frame;

static void per_frame_read(per_frame *naive)
{
	uint8_t report[STILB_INPUT_REPORT_MAX];
	ssize_t size;
	while ((size = read(naive->fd, report, sizeof report)) > 0) {
		uint32_t number = vm_ds4_number(report, (size_t)size);
		naive->count += number != 0;
		naive->last_number = number;
	}
}

#define STALLED 1000u
#define RING_US 60000 /* a program that does not read for longer loses reports: the kernel keeps 64, one in a ms */
#define STATE_US 5000 /* the state after a stall may be this far behind the pad, or as far as 1 % of all reports are */
#define STALL_TRIES 5

typedef struct stall {
	int64_t us;
	int64_t frame_us[VM_SIDES], naive_us; /* time of the first frame after the stall, of each side and of per_frame */
	uint32_t newest[VM_SIDES], naive_newest;
} stall;

static void stall_frame(vm_fixture *fixture, per_frame *naive, stall *at)
{
	per_frame_read(naive);
	vm_sleep_until_us(vm_now_us() + at->us);
	per_frame_read(naive);
	at->naive_us = vm_now_us();
	at->naive_newest = naive->last_number;
	vm_fixture_frame(fixture);
	for (int i = 0; i < VM_SIDES; i++) {
		at->frame_us[i] = fixture->sides[i].frame_us;
		at->newest[i] = vm_fixture_find(fixture, i, USB)->last_number;
	}
}

static void run_frames(vm_fixture *fixture, per_frame *naive, int frames)
{
	for (int i = 0; i < frames; i++) {
		per_frame_read(naive);
		vm_fixture_run(fixture, VM_FRAME_US);
	}
}

/* How far a side's newest report is behind the pad at the time us: how long ago the pad had sent the report after it;
 * 0: it had sent none. (The age of the newest report would include the delay of the pad's own thread.) */
static int64_t behind_us(const vm_sender *sender, uint32_t newest, int64_t us)
{
	int64_t next_us = newest < sender->count ? sender->sent_us[newest + 1] : us;
	return next_us < us ? us - next_us : 0;
}

#define STALLS 2
#define ALL_PROVED ((1u << VM_SIDES * STALLS) - 1)

/* Sends a thousand reports in a second, while two frames take long. Returns a bit for each side (backend) and long
 * frame after which the pad's state was up to date: on a busy machine the readers may not have run. */
static uint32_t stalls_prove(vm_fixture *fixture, uhid_pad *pad, per_frame *naive)
{
	static vm_sender sender;
	stall stalls[STALLS] = {{.us = 300000}, {.us = 500000}};
	sender = (vm_sender){.pad = pad, .count = STALLED, .period_us = 1000, .report = forward};
	vm_sender_start(&sender);
	for (int i = 0; i < STALLS; i++) {
		run_frames(fixture, naive, 3);
		stall_frame(fixture, naive, &stalls[i]);
	}
	bool sent_all_the_time = vm_sender_runs(&sender);
	while (vm_sender_runs(&sender))
		run_frames(fixture, naive, 1);
	run_frames(fixture, naive, 3);
	vm_sender_finish(&sender);

	printf("  1000 reports a second, a frame of 300 ms and one of 500 ms\n");
	printf("  a read per frame: %u of %u lost, state after them %.1f and %.1f ms behind\n", STALLED - naive->count,
	       STALLED, (double)behind_us(&sender, stalls[0].naive_newest, stalls[0].naive_us) / 1000,
	       (double)behind_us(&sender, stalls[1].naive_newest, stalls[1].naive_us) / 1000);
	assert_true(naive->count < STALLED); /* else the kernel's ring is larger than this test assumes */
	uint32_t proved = 0;
	for (int side = 0; side < VM_SIDES; side++) {
		const vm_heard *heard = vm_fixture_find(fixture, side, USB);
		latency all = print_latency(&fixture->sides[side], heard, &sender);
		int64_t limit = all.p99 > STATE_US ? all.p99 : STATE_US;
		int64_t behind[STALLS];
		for (int i = 0; i < STALLS; i++) {
			behind[i] = behind_us(&sender, stalls[i].newest[side], stalls[i].frame_us[side]);
			proved |= (uint32_t)(sent_all_the_time && behind[i] < limit) << (side * STALLS + i);
		}
		printf("  %s: state after them %.1f and %.1f ms behind\n", fixture->sides[side].name, (double)behind[0] / 1000,
		       (double)behind[1] / 1000);
		assert_true(missing(heard, STALLED) == 0 || all.longest >= RING_US);
		assert_int_equal(heard->disorders, 0);
		assert_int_equal(stilb_input_pads_stats_get(fixture->sides[side].pads).lost, 0);
	}
	return proved;
}

static void test_stalled_frames(void **state)
{
	vm_fixture *fixture = *state;
	uint32_t proved = 0;
	fixture->number = vm_ds4_number;
	for (int tries = 0; tries < STALL_TRIES && proved != ALL_PROVED; tries++) {
		uhid_pad *pad = vm_fixture_plug(fixture, ds4(BUS_USB), USB);
		vm_fixture_wait(fixture, USB, true);
		per_frame naive = {.fd = open(vm_fixture_find(fixture, 0, USB)->info.path, O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
		assert_true(naive.fd >= 0);
		proved |= stalls_prove(fixture, pad, &naive);
		close(naive.fd);
		vm_fixture_pull(fixture, pad);
		vm_fixture_wait(fixture, USB, false);
	}
	assert_int_equal(proved, ALL_PROVED);
}

int main(int argc, char **argv)
{
	if (argc == 3 && strcmp(argv[1], "denied") == 0)
		return denied_then_granted(argv[2]);
	vm_module_set("hid", "ignore_special_drivers", "1"); /* hid-generic takes every pad */
	static const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_every_pad_is_found, vm_fixture_open, vm_fixture_close),
		cmocka_unit_test_setup_teardown(test_no_permission, vm_fixture_open, vm_fixture_close),
		cmocka_unit_test_setup_teardown(test_flight, vm_fixture_open, vm_fixture_close),
		cmocka_unit_test_setup_teardown(test_pulled_in_flight, vm_fixture_open, vm_fixture_close),
		cmocka_unit_test_setup_teardown(test_stalled_frames, vm_fixture_open, vm_fixture_close),
	};
	setvbuf(stdout, NULL, _IOLBF, 0);
	return cmocka_run_group_tests(tests, NULL, NULL);
}
