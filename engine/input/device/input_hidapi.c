/*
 * Talks to a node through hidapi. Version 0.13.1, Debian 12's, uses freed memory if it opens a node that is not a
 * hidraw node (its pull request 559), so input_device_open checks the node first. A pad that is unplugged between two
 * system calls of hid_open_path can still trigger the fault; input_hidraw.c does not have this race.
 */
#include "input/device/input_device_internal.h"

#include <errno.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <pthread.h>
#include <unistd.h>

/* hid_read_timeout waits for hidapi's file descriptor, which the library does not expose, so the wait is cut into
 * slices of this length and wake_fd is polled between them. A report ends a slice early: an idle pad costs 125 wake-ups
 * a second, a busy one none. */
#define HIDAPI_SLICE_MS 8

/* Held around hid_open_path, which writes the message of its last error to a global of the library. */
static pthread_mutex_t hidapi_lock = PTHREAD_MUTEX_INITIALIZER;

static int hidapi_open(const char *path, int fd, input_device *device)
{
	pthread_mutex_lock(&hidapi_lock);
	device->hid = hid_open_path(path);
	pthread_mutex_unlock(&hidapi_lock);
	close(fd); /* after hid_open_path: as long as fd is open the kernel gives the node's name to no other device */
	return device->hid ? 0 : -ENODEV;
}

static void hidapi_close(input_device *device)
{
	hid_close(device->hid);
}

static bool hidapi_is_woken(int wake_fd)
{
	struct pollfd wake = {.fd = wake_fd, .events = POLLIN};
	return poll(&wake, 1, 0) > 0;
}

static int hidapi_read(input_device *device, int wake_fd, int timeout_ms, uint8_t *report, size_t size)
{
	STILB_ASSERT(device->hid && size > 0);
	bool is_endless = timeout_ms < 0;
	while (true) {
		int slice = is_endless || timeout_ms > HIDAPI_SLICE_MS ? HIDAPI_SLICE_MS : timeout_ms;
		int got = hid_read_timeout(device->hid, report, size, slice);
		if (got != 0)
			return got > 0 ? got : -ENODEV;
		timeout_ms -= is_endless ? 0 : slice;
		if (timeout_ms == 0 || hidapi_is_woken(wake_fd))
			return 0;
	}
}

static int hidapi_write(input_device *device, const uint8_t *report, size_t size)
{
	STILB_ASSERT(device->hid && size > 0);
	int put = hid_write(device->hid, report, size);
	return put < 0 ? -EIO : put;
}

static int hidapi_get_feature(input_device *device, uint8_t *report, size_t size)
{
	STILB_ASSERT(device->hid && size > 0);
	int got = hid_get_feature_report(device->hid, report, size);
	return got < 0 ? -EIO : got;
}

const input_backend input_backend_hidapi = {
	.name = "hidapi",
	.open = hidapi_open,
	.close = hidapi_close,
	.read = hidapi_read,
	.write = hidapi_write,
	.get_feature = hidapi_get_feature,
};
