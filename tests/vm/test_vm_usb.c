/* Pads on the kernel's real USB stack: a gadget of the kernel (configfs, usb_f_hid) at a simulated host controller
 * (dummy_hcd), so that usbhid reads descriptors and polls as it does with a real device. Runs in the virtual
 * machine of boot.sh, as root. */
#include "support/test.h"
#include "vm/vm_ds4.h"
#include "vm/vm_fixture.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define GADGETS "/sys/kernel/config/usb_gadget"
#define REPORTS 100u
#define OUTPUT_US 5000000 /* the longest a simulated host may take to send an output report */

static void put(const char *gadget, const char *leaf, const void *bytes, size_t size)
{
	char path[256];
	snprintf(path, sizeof path, GADGETS "/%s/%s", gadget, leaf);
	int fd = open(path, O_WRONLY | O_CLOEXEC);
	if (fd < 0 || write(fd, bytes, size) != (ssize_t)size)
		fail_msg("%s: %s", path, strerror(errno));
	close(fd);
}

static void put_text(const char *gadget, const char *leaf, const char *text)
{
	put(gadget, leaf, text, strlen(text));
}

static void put_number(const char *gadget, const char *leaf, unsigned number)
{
	char text[16];
	snprintf(text, sizeof text, "%u", number);
	put_text(gadget, leaf, text);
}

static void make(const char *gadget, const char *folder)
{
	char path[256];
	snprintf(path, sizeof path, GADGETS "/%s/%s", gadget, folder);
	if (mkdir(path, 0755) != 0)
		fail_msg("%s: %s", path, strerror(errno));
}

/* Creates a gadget; its serial number is its name. Source: Linux, Documentation/usb/gadget_configfs.rst. */
static void gadget_plug(const char *gadget, const char *controller, const input_test_descriptor *kind, unsigned report)
{
	make(gadget, "");
	put_number(gadget, "idVendor", kind->vendor);
	put_number(gadget, "idProduct", kind->product);
	make(gadget, "strings/0x409");
	put_text(gadget, "strings/0x409/manufacturer", "Stilb");
	put_text(gadget, "strings/0x409/product", kind->name);
	put_text(gadget, "strings/0x409/serialnumber", gadget);
	make(gadget, "functions/hid.0");
	put_number(gadget, "functions/hid.0/report_length", report);
	put(gadget, "functions/hid.0/report_desc", kind->bytes, kind->size);
	make(gadget, "configs/c.1");
	char from[256], to[256];
	snprintf(from, sizeof from, GADGETS "/%s/functions/hid.0", gadget);
	snprintf(to, sizeof to, GADGETS "/%s/configs/c.1/hid.0", gadget);
	assert_int_equal(symlink(from, to), 0);
	put_text(gadget, "UDC", controller);
}

/* Lets the host remove the pad. (Unbinding the gadget from its controller instead crashes dummy_hcd of Linux 6.1 while
 * a report is being sent.) */
static void gadget_pull(const vm_heard *heard)
{
	char path[512], *slash;
	snprintf(path, sizeof path, "%s", heard->info.device); /* .../usb1/1-1/1-1:1.0/0003:054C:05C4.0001 */
	for (int i = 0; i < 2; i++) {
		slash = strrchr(path, '/');
		assert_non_null(slash);
		*slash = '\0';
	}
	strcat(path, "/remove");
	int fd = open(path, O_WRONLY | O_CLOEXEC);
	assert_true(fd >= 0);
	assert_int_equal(write(fd, "1", 1), 1);
	close(fd);
}

static void check_info(const vm_heard *heard, const input_test_descriptor *kind)
{
	char name[128];
	snprintf(name, sizeof name, "Stilb %s", kind->name);
	assert_true(heard->is_pad);
	assert_false(heard->denied);
	assert_string_equal(heard->info.name, name);
	assert_int_equal(heard->info.bus, STILB_INPUT_BUS_USB);
	assert_int_equal(heard->info.vendor, kind->vendor);
	assert_int_equal(heard->info.product, kind->product);
	assert_int_equal(heard->info.descriptor_size, kind->size);
	assert_memory_equal(heard->info.descriptor, kind->bytes, kind->size);
	assert_non_null(strstr(heard->info.device, "/usb"));
}

static void send_all(vm_fixture *fixture, const char *node)
{
	int fd = open(node, O_RDWR | O_CLOEXEC | O_NONBLOCK);
	assert_true(fd >= 0);
	for (uint32_t number = 1; number <= REPORTS;) {
		uint8_t report[VM_DS4_USB_BYTES];
		size_t size = vm_ds4_usb(number, 0, report);
		if (write(fd, report, size) == (ssize_t)size)
			number++; /* else the host has not polled the last report yet: send it again */
		vm_sleep_until_us(vm_now_us() + 2000);
		vm_fixture_frame(fixture);
	}
	vm_fixture_run(fixture, 100000);
	close(fd);
}

/* Reads the next output report that arrived at the gadget (the simulated USB device), as soon as there is one. */
static ssize_t next_output(vm_fixture *fixture, int fd, uint8_t report[static STILB_INPUT_OUTPUT_MAX])
{
	ssize_t got = -1;
	for (int64_t end = vm_now_us() + OUTPUT_US; got < 0 && vm_now_us() < end;) {
		vm_fixture_run(fixture, 10000);
		got = read(fd, report, STILB_INPUT_OUTPUT_MAX);
	}
	return got;
}

/* Checks the output reports that a side's rumble sends. */
static void check_rumble(vm_fixture *fixture, int side, const char *unique, const char *node)
{
	int fd = open(node, O_RDWR | O_CLOEXEC | O_NONBLOCK);
	assert_true(fd >= 0);
	const vm_heard *heard = vm_fixture_find(fixture, side, unique);
	uint8_t wanted[STILB_INPUT_OUTPUT_MAX], got[STILB_INPUT_OUTPUT_MAX];
	size_t size = stilb_input_rumble_report(&heard->layout, 1, 0.0f, 0, wanted);
	stilb_input_pads_rumble(fixture->sides[side].pads, heard->pad, 1, 0, 50);
	assert_int_equal(next_output(fixture, fd, got), size);
	assert_memory_equal(got, wanted, size);
	stilb_input_rumble_report(&heard->layout, 0, 0, 1, wanted);
	assert_int_equal(next_output(fixture, fd, got), size); /* the report that stops the rumble */
	assert_memory_equal(got, wanted, size);
	close(fd);
}

static void test_usb_pads(void **state)
{
	vm_fixture *fixture = *state;
	const input_test_descriptor *ds4 = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	const input_test_descriptor *asus = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x18d1, 0x2c40);
	vm_module_set("hid", "ignore_special_drivers", "1");
	fixture->number = vm_ds4_number;
	gadget_plug("ds4", "dummy_udc.0", ds4, VM_DS4_USB_BYTES);
	gadget_plug("asus", "dummy_udc.1", asus, 9);
	vm_fixture_wait(fixture, "ds4", true);
	vm_fixture_wait(fixture, "asus", true);
	for (int side = 0; side < VM_SIDES; side++) {
		check_info(vm_fixture_find(fixture, side, "ds4"), ds4);
		check_info(vm_fixture_find(fixture, side, "asus"), asus);
	}
	send_all(fixture, "/dev/hidg0");
	for (int side = 0; side < VM_SIDES; side++) {
		const vm_heard *heard = vm_fixture_find(fixture, side, "ds4");
		printf("  %s: %u reports over USB, %u came\n", fixture->sides[side].name, REPORTS, heard->decoded);
		assert_int_equal(heard->decoded, REPORTS);
		assert_int_equal(heard->last_number, REPORTS);
		assert_int_equal(heard->disorders, 0);
		assert_true(heard->pose.position[2] < 0);
		check_rumble(fixture, side, "ds4", "/dev/hidg0");
	}
	gadget_pull(vm_fixture_find(fixture, 0, "ds4"));
	vm_fixture_wait(fixture, "ds4", false);
	for (int side = 0; side < VM_SIDES; side++)
		assert_non_null(vm_fixture_find(fixture, side, "asus")); /* not the other one */
	gadget_pull(vm_fixture_find(fixture, 0, "asus"));
	vm_fixture_wait(fixture, "asus", false);
}

int main(void)
{
	setvbuf(stdout, NULL, _IOLBF, 0);
	static const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_usb_pads, vm_fixture_open, vm_fixture_close),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
