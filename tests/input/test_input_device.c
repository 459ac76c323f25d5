/* input_device: reading a hidraw node's description from sysfs, also a broken one, and opening files that are no hidraw
 * nodes; on simulated files. */
#include "input/device/input_device_internal.h"
#include "input/device/input_pads.h"
#include "support/fake_hidraw.h"
#include "support/test.h"

#include <dirent.h>
#include <signal.h>
#include <stddef.h>

static const uint8_t bytes[4100] = {0x05, 0x01, 0x09, 0x05, 0xa1, 0x01};
static const input_test_descriptor pad = {
	.name = "Wireless Controller", .bytes = bytes, .size = 507, .bus = 5, .vendor = 0x054c, .product = 0x09cc};

static stilb_input_pad_info info;

static int set_up(void **state)
{
	(void)state;
	fake_begin();
	return 0;
}

static int tear_down(void **state)
{
	(void)state;
	fake_end();
	return 0;
}

static int look(const char *name)
{
	memset(&info, 0xa5, sizeof info);
	return input_device_info(&(input_roots){.sys = fake.sys, .dev = fake.dev}, name, &info);
}

static void names_of_nodes(void **state)
{
	(void)state;
	static const char *const no[] = {"",         "hidraw", "hidraw1a",   "hidraw-1", "hidraw ",
	                                 "xhidraw1", "js0",    "hidraw1/..", "HIDRAW1"};
	assert_true(input_device_is_hidraw("hidraw0") && input_device_is_hidraw("hidraw4294967296"));
	for (size_t i = 0; i < sizeof no / sizeof *no; i++)
		assert_false(input_device_is_hidraw(no[i]));
}

static void what_sysfs_says_is_read(void **state)
{
	(void)state;
	char path[PATH_MAX];
	fake_describe(3, &pad, NULL);
	assert_int_equal(look("hidraw3"), 0);
	fake_path(path, fake.dev, "hidraw%d", 3);
	assert_string_equal(info.path, path);
	fake_path(path, fake.sys, "devices/pad%d", 3);
	assert_string_equal(info.device, path);
	assert_string_equal(info.name, "Wireless Controller");
	assert_string_equal(info.unique, "serial 3");
	assert_int_equal(info.bus, STILB_INPUT_BUS_BLUETOOTH);
	assert_int_equal(info.vendor, 0x054c);
	assert_int_equal(info.product, 0x09cc);
	assert_int_equal(info.descriptor_size, 507);
	assert_memory_equal(info.descriptor, bytes, 507);
}

/* A uevent file may lack the name and the serial number, have lines that look like others, and no last line end. */
static void a_uevent_file_may_say_little(void **state)
{
	(void)state;
	fake_describe(0, &pad, "XHID_NAME=no\nHID_NAMES=no\nHID_ID=0003:0000045E:000002FD");
	assert_int_equal(look("hidraw0"), 0);
	assert_string_equal(info.name, "");
	assert_string_equal(info.unique, "");
	assert_int_equal(info.bus, 3);
	assert_int_equal(info.vendor, 0x045e);
	assert_int_equal(info.product, 0x02fd);
	fake_unplug(0);
	fake_describe(0, &pad, "HID_UNIQ=\nHID_ID=0005:0000057E:00002009\nHID_NAME=\n");
	assert_int_equal(look("hidraw0"), 0);
	assert_string_equal(info.name, "");
	assert_int_equal(info.product, 0x2009);
}

/* A pad's name may contain any bytes. */
static void names_are_made_fit(void **state)
{
	(void)state;
	fake_describe(0, &pad, "HID_ID=3:1:2\nHID_NAME=a\033[31mb\xff\xc3\xa9\xe2\x82\n");
	assert_int_equal(look("hidraw0"), 0);
	assert_string_equal(info.name, "a?[31mb?\xc3\xa9??");
	fake_unplug(0);
	char uevent[1024];
	memset(uevent, 0, sizeof uevent);
	snprintf(uevent, sizeof uevent, "HID_ID=3:1:2\nHID_NAME=");
	memset(uevent + strlen(uevent), 'n', 600);
	memcpy(uevent + strlen(uevent), "\nHID_UNIQ=after", 15);
	fake_describe(0, &pad, uevent);
	assert_int_equal(look("hidraw0"), 0);
	assert_int_equal(strlen(info.name), sizeof info.name - 1);
	assert_string_equal(info.unique, "after");
}

static void what_is_not_there_is_no_pad(void **state)
{
	(void)state;
	static const char *const uevents[] = {"", "HID_NAME=x\n", "HID_ID=\n", "HID_ID=3:1\n", "HID_ID=x:y:z\n", "\n\n\n"};
	assert_int_equal(look("hidraw9"), -ENODEV);
	for (size_t i = 0; i < sizeof uevents / sizeof *uevents; i++) {
		fake_describe(0, &pad, uevents[i]);
		assert_int_equal(look("hidraw0"), -ENODEV);
		fake_unplug(0);
	}
	char path[PATH_MAX];
	fake_describe(0, &pad, NULL); /* the pad is unplugged while its files are read: one of them is gone */
	fake_path(path, fake.sys, "devices/pad%d/report_descriptor", 0);
	unlink(path);
	assert_int_equal(look("hidraw0"), -ENODEV);
}

static void descriptors_of_any_size(void **state)
{
	(void)state;
	static const size_t sizes[] = {0, 1, 4096, 4100};
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		input_test_descriptor other = pad;
		other.size = sizes[i];
		fake_describe(0, &other, NULL);
		assert_int_equal(look("hidraw0"), 0);
		size_t kept = sizes[i] < STILB_INPUT_DESCRIPTOR_MAX ? sizes[i] : STILB_INPUT_DESCRIPTOR_MAX;
		assert_int_equal(info.descriptor_size, kept);
		fake_unplug(0);
	}
}

static void paths_that_are_too_long_are_refused(void **state)
{
	(void)state;
	char name[PATH_MAX + 1], dev[80];
	memset(name, '1', sizeof name - 1);
	memcpy(name, "hidraw", 6);
	name[sizeof name - 1] = '\0';
	memset(dev, 'd', sizeof dev - 1);
	dev[sizeof dev - 1] = '\0';
	assert_int_equal(look(name), -ENAMETOOLONG);
	assert_int_equal(input_device_info(&(input_roots){.sys = name, .dev = "/dev"}, "hidraw0", &info), -ENAMETOOLONG);
	assert_int_equal(input_device_info(&(input_roots){.sys = fake.sys, .dev = dev}, "hidraw0", &info), -ENAMETOOLONG);
}

static uint32_t open_files(void)
{
	uint32_t count = 0;
	DIR *folder = opendir("/proc/self/fd");
	assert_non_null(folder);
	while (readdir(folder))
		count++;
	closedir(folder);
	return count;
}

/* hidapi 0.13.1 by itself crashes on the first two. */
static void what_is_no_hidraw_is_refused(void **state)
{
	(void)state;
	static const input_backend *const backends[] = {&input_backend_hidraw, &input_backend_hidapi};
	static const char *const paths[] = {"/dev/null", "/dev/zero", "/nonexistent", "/proc/self/status", "/dev/null/x"};
	uint32_t files = open_files();
	for (size_t b = 0; b < 2; b++)
		for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
			input_device device;
			assert_true(input_device_open(backends[b], paths[i], &device) < 0);
		}
	assert_int_equal(open_files(), files);
}

/* The hidraw backend: read, write, wake, and the error of a node that is gone. */
static void a_device_is_read_until_it_is_gone(void **state)
{
	(void)state;
	uint8_t report[64] = {1, 2, 3};
	char path[PATH_MAX];
	input_device device;
	int wake[2];
	assert_int_equal(pipe(wake), 0);
	fake_plug(0, &pad);
	fake_path(path, fake.dev, "hidraw%d", 0);
	assert_int_equal(input_device_open(&input_backend_hidraw, path, &device), 0);
	assert_int_equal(input_backend_hidraw.read(&device, wake[0], 5, report, sizeof report), 0); /* nothing comes */
	assert_true(fake_send(0, "\1\2\3", 3));
	assert_true(fake_send(0, "\4\5", 2));
	assert_int_equal(write(wake[1], "", 1), 1);
	assert_int_equal(input_backend_hidraw.read(&device, wake[0], -1, report, sizeof report), 3);
	assert_memory_equal(report, "\1\2\3", 3);
	assert_int_equal(input_backend_hidraw.write(&device, report, 3), 3);
	assert_int_equal(fake_receive(0, report, sizeof report, 1000), 3);
	report[0] = 0x12;
	assert_int_equal(input_backend_hidraw.get_feature(&device, report, 16), 16);
	assert_int_equal(fake.features[0], 0x12);
	fake_unplug(0);
	assert_int_equal(input_backend_hidraw.read(&device, wake[0], -1, report, sizeof report), 2); /* sent before */
	assert_int_equal(input_backend_hidraw.read(&device, wake[0], -1, report, sizeof report), -ENODEV);
	assert_true(input_backend_hidraw.write(&device, report, 3) < 0);
	input_backend_hidraw.close(&device);
	close(wake[0]);
	close(wake[1]);
}

static void the_rule_names_the_kind_of_pad(void **state)
{
	(void)state;
	char rule[128], cut[8];
	info = (stilb_input_pad_info){.vendor = 0x45e, .product = 0x2fd};
	assert_string_equal(stilb_input_udev_rule(&info, rule, sizeof rule),
	                    "KERNEL==\"hidraw*\", KERNELS==\"*:045E:02FD.*\", MODE=\"0660\", TAG+=\"uaccess\"");
	assert_string_equal(stilb_input_udev_rule(&info, cut, sizeof cut), "KERNEL=");
}

int main(void)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)
	struct CMUnitTest tests[] = {
		TEST(names_of_nodes),
		TEST(what_sysfs_says_is_read),
		TEST(a_uevent_file_may_say_little),
		TEST(names_are_made_fit),
		TEST(what_is_not_there_is_no_pad),
		TEST(descriptors_of_any_size),
		TEST(paths_that_are_too_long_are_refused),
		TEST(what_is_no_hidraw_is_refused),
		TEST(a_device_is_read_until_it_is_gone),
		TEST(the_rule_names_the_kind_of_pad),
	};
	signal(SIGPIPE, SIG_IGN); /* raised by a write to a closed socket, which stands in for a hidraw node here */
	return cmocka_run_group_tests_name("input_device", tests, NULL, NULL);
}
