/*
 * input_device: hidraw nodes: which there are (from sysfs, never through hidapi, whose enumeration crashes when a pad
 * goes away under it) and two ways to talk to one: hidapi, and the kernel's interface directly.
 *
 * Threads.  A device belongs to one thread at a time; the rest is [any-thread].
 * Errors.   0 or a negative errno.
 */
#ifndef STILB_INPUT_DEVICE_INTERNAL_H
#define STILB_INPUT_DEVICE_INTERNAL_H

#include "input/input_pad.h"

/* Where the system's files are: "/sys" and "/dev"; tests have their own. */
typedef struct input_roots {
	const char *sys, *dev;
} input_roots;

/* "hidraw" and a number, nothing else. */
bool input_device_is_hidraw(const char *name);

/* Reads what sysfs knows of the node `name` ("hidraw3"). -ENODEV: it is gone. */
int input_device_info(const input_roots *roots, const char *name, stilb_input_pad_info *info);

struct input_backend;

/* An open node. */
typedef struct input_device {
	const struct input_backend *backend;
	union {
		int fd;    /* input_hidraw.c */
		void *hid; /* input_hidapi.c */
	};
} input_device;

/* One way to talk to a node. */
typedef struct input_backend {
	const char *name; /* "hidraw", "hidapi" */
	/* fd is the node at path, opened and found to be a hidraw; the backend's from here on, also after an error. */
	int (*open)(const char *path, int fd, input_device *device);
	void (*close)(input_device *device);
	/* Waits at most timeout_ms (-1: without end) for a report or for wake_fd to become readable. Bytes read; 0: neither
	 * came, or wake_fd did; a negative errno: the device was pulled, or is of no use any more. */
	int (*read)(input_device *device, int wake_fd, int timeout_ms, uint8_t *report, size_t size);
	int (*write)(input_device *device, const uint8_t *report, size_t size);
	int (*get_feature)(input_device *device, uint8_t *report, size_t size); /* report[0]: its id. Bytes read */
} input_backend;

extern const input_backend input_backend_hidraw, input_backend_hidapi;

/* -EACCES: no permission; -ENODEV: it is gone, or was no hidraw. */
int input_device_open(const input_backend *backend, const char *path, input_device *device);

#endif
