/*
 * Through hidapi. Version 0.13.1, Debian 12's, uses a device it has freed where a node opens and is no hidraw (its pull
 * request 559): that is why the node has been looked at before it comes here. Only a pad that is pulled between two
 * system calls of hid_open_path is left; input_hidraw.c has not even that.
 */
#include "input/device/input_device_internal.h"

#include <errno.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <pthread.h>
#include <unistd.h>

/* hid_read_timeout waits for hidapi's own descriptor, which hidapi does not show: between such slices the other one is
 * looked at. A report ends a slice, so it costs an idle pad 125 wake-ups a second and a busy one none. */
#define HIDAPI_SLICE_MS 8

/* hid_open_path writes a global: the message of its last error. */
static pthread_mutex_t hidapi_lock = PTHREAD_MUTEX_INITIALIZER;

static int hidapi_open(const char *path, int fd, input_device *device)
{
	pthread_mutex_lock(&hidapi_lock);
	device->hid = hid_open_path(path);
	pthread_mutex_unlock(&hidapi_lock);
	close(fd); /* only now: while it is open the kernel gives the node's name to no other device */
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
	int put = hid_write(device->hid, report, size);
	return put < 0 ? -EIO : put;
}

static int hidapi_get_feature(input_device *device, uint8_t *report, size_t size)
{
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
