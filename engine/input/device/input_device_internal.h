/*
 * input_device: hidraw nodes (/dev/hidrawN, Linux's access to a HID device's raw reports): what sysfs says of them, and
 * two ways to talk to one, called backends: the kernel's interface directly, and the library hidapi. hidapi is never
 * asked to list devices: its enumeration crashes if a pad is unplugged meanwhile.
 *
 * Life cycle.  input_device_info -> input_device_open -> the backend's read, write, get_feature -> its close.
 * Threads.     A device belongs to one thread at a time; the rest is [any-thread].
 * Errors.      0 or a negative errno.
 */
#ifndef STILB_INPUT_DEVICE_INTERNAL_H
#define STILB_INPUT_DEVICE_INTERNAL_H

#include "input/input_pad.h"

/* The folders in which devices are looked for: "/sys" and "/dev"; tests give folders with made-up devices. */
typedef struct input_roots {
	const char *sys, *dev;
} input_roots;

/* True if name is "hidraw" and a decimal number. */
bool input_device_is_hidraw(const char *name);

/* Fills *info with what sysfs knows of the node `name` ("hidraw3"). -ENODEV: it is gone. Asserts that name is
 * one of a hidraw node. */
int input_device_info(const input_roots *roots, const char *name, stilb_input_pad_info *info);

struct input_backend;

/* An open node. */
typedef struct input_device {
	const struct input_backend *backend;
	union {
		int fd;    /* used by input_hidraw.c: the node's descriptor */
		void *hid; /* used by input_hidapi.c: hidapi's device */
	};
} input_device;

/* One way to talk to a node. */
typedef struct input_backend {
	const char *name; /* "hidraw", "hidapi" */
	/* fd is the node at path, open, and known to be a hidraw node. The backend owns it from here on, also after an
	 * error. */
	int (*open)(const char *path, int fd, input_device *device);
	void (*close)(input_device *device);
	/* Waits at most timeout_ms (-1: without limit) until there is a report or wake_fd is readable. Returns the report's
	 * bytes; 0: there is no report; a negative errno: the device was unplugged or failed, close it. */
	int (*read)(input_device *device, int wake_fd, int timeout_ms, uint8_t *report, size_t size);
	/* Sends an output report of size bytes. Returns the bytes written, or a negative errno. */
	int (*write)(input_device *device, const uint8_t *report, size_t size);
	/* Reads a feature report of up to size bytes, whose id the caller has put into report[0]. Returns the bytes read,
	 * or a negative errno. */
	int (*get_feature)(input_device *device, uint8_t *report, size_t size);
} input_backend;

extern const input_backend input_backend_hidraw, input_backend_hidapi;

/* Opens the node at path. -EACCES, -EPERM: no permission; -ENODEV: it is gone, or is not a hidraw node. */
int input_device_open(const input_backend *backend, const char *path, input_device *device);

#endif
