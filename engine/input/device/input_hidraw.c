/* Talks to a node by the kernel's own interface. Source: Linux, Documentation/hid/hidraw.rst. */
#include "input/device/input_device_internal.h"

#include <errno.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

static int hidraw_open(const char *path, int fd, input_device *device)
{
	(void)path;
	device->fd = fd;
	return 0;
}

static void hidraw_close(input_device *device)
{
	close(device->fd);
}

static int hidraw_read(input_device *device, int wake_fd, int timeout_ms, uint8_t *report, size_t size)
{
	STILB_ASSERT(device->fd >= 0 && size > 0);
	struct pollfd fds[2] = {{.fd = device->fd, .events = POLLIN}, {.fd = wake_fd, .events = POLLIN}};
	if (poll(fds, 2, timeout_ms) < 0)
		return errno == EINTR ? 0 : -errno;
	if (fds[0].revents == 0)
		return 0;
	/* Reports that came before the device was unplugged can still be read; after the last one read fails. */
	ssize_t got = read(device->fd, report, size);
	if (got > 0)
		return (int)got;
	if (got < 0 && (errno == EAGAIN || errno == EINTR))
		return fds[0].revents & (POLLERR | POLLHUP | POLLNVAL) ? -ENODEV : 0;
	return got < 0 ? -errno : -ENODEV;
}

static int hidraw_write(input_device *device, const uint8_t *report, size_t size)
{
	STILB_ASSERT(device->fd >= 0 && size > 0);
	ssize_t put = write(device->fd, report, size);
	return put < 0 ? -errno : (int)put;
}

static int hidraw_get_feature(input_device *device, uint8_t *report, size_t size)
{
	STILB_ASSERT(device->fd >= 0 && size > 0);
	int got = ioctl(device->fd, HIDIOCGFEATURE(size), report);
	return got < 0 ? -errno : got;
}

const input_backend input_backend_hidraw = {
	.name = "hidraw",
	.open = hidraw_open,
	.close = hidraw_close,
	.read = hidraw_read,
	.write = hidraw_write,
	.get_feature = hidraw_get_feature,
};
