/*
 * fake_hidraw: pads without hardware and without a kernel of their own, for tests that are linked with --wrap=open and
 * --wrap=ioctl; include it in one file of a test.
 *
 * A folder for each test holds "sys" and "dev" as input_roots names them. A plugged pad is its files there and a pair
 * of sockets that keep messages apart as hidraw does: opening its node gives one end, the test has the other. The end
 * of a pad is told as the kernel tells it: what it sent can still be read, then reading fails, and the waiting ends.
 */
#ifndef FAKE_HIDRAW_H
#define FAKE_HIDRAW_H

#include "input_descriptors.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define FAKE_NODES 64
#define FAKE_FEATURES 32

typedef struct fake_node {
	int device; /* the pad's end; -1: there is none */
	int host;   /* who opens the node gets this end; -1: somebody has */
} fake_node;

static struct {
	char folder[64], sys[96], dev[96];
	pthread_mutex_t lock; /* of what follows: opened by the watcher, plugged by the test */
	fake_node nodes[FAKE_NODES];
	uint8_t features[FAKE_FEATURES]; /* ids that were asked for, in order */
	uint32_t feature_count;
	int feature_ms; /* how long a pad thinks about one; set before it is plugged */
} fake = {.lock = PTHREAD_MUTEX_INITIALIZER};

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_ioctl(int fd, unsigned long request, ...);
int __wrap_ioctl(int fd, unsigned long request, ...);

/* The node at a path, -1: it is none of ours. */
static inline int fake_number(const char *path)
{
	unsigned number = FAKE_NODES;
	size_t length = strlen(fake.dev);
	if (length > 0 && strncmp(path, fake.dev, length) == 0 && path[length] == '/')
		sscanf(path + length + 1, "hidraw%u", &number);
	return number < FAKE_NODES ? (int)number : -1;
}

/* Tests run as root, whom no mode stops: here it does. */
static inline int fake_open(const char *path, int number)
{
	struct stat info;
	if (stat(path, &info) != 0)
		return -1;
	if ((info.st_mode & 0600) != 0600)
		return errno = EACCES, -1;
	pthread_mutex_lock(&fake.lock);
	int fd = fake.nodes[number].host;
	fake.nodes[number].host = -1;
	pthread_mutex_unlock(&fake.lock);
	if (fd < 0)
		errno = ENODEV;
	return fd;
}

int __wrap_open(const char *path, int flags, ...)
{
	va_list arguments;
	va_start(arguments, flags);
	mode_t mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
	va_end(arguments);
	int number = fake_number(path);
	return number >= 0 && !(flags & O_CREAT) ? fake_open(path, number) : __real_open(path, flags, mode);
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
	va_list arguments;
	va_start(arguments, request);
	uint8_t *bytes = va_arg(arguments, uint8_t *);
	va_end(arguments);
	int kind;
	if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &kind, &(socklen_t){sizeof kind}) != 0 || kind != SOCK_SEQPACKET)
		return __real_ioctl(fd, request, bytes);
	if (request == HIDIOCGRDESCSIZE)
		return 0;
	if (_IOC_NR(request) != _IOC_NR(HIDIOCGFEATURE(0)))
		return errno = EINVAL, -1;
	pthread_mutex_lock(&fake.lock);
	if (fake.feature_count < FAKE_FEATURES)
		fake.features[fake.feature_count++] = bytes[0];
	int ms = fake.feature_ms;
	pthread_mutex_unlock(&fake.lock);
	poll(NULL, 0, ms);
	return (int)_IOC_SIZE(request);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static inline void fake_write(const char *path, const void *bytes, size_t size, mode_t mode)
{
	int fd = __real_open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
	if (fd < 0 || write(fd, bytes, size) != (ssize_t)size)
		abort();
	close(fd);
}

static inline void fake_path(char path[PATH_MAX], const char *folder, const char *format, int number)
{
	int length = snprintf(path, PATH_MAX, "%s/", folder);
	snprintf(path + length, (size_t)(PATH_MAX - length), format, number);
}

static inline void fake_begin(void)
{
	fake = (typeof(fake)){.lock = PTHREAD_MUTEX_INITIALIZER};
	snprintf(fake.folder, sizeof fake.folder, "/tmp/stilb-pads-XXXXXX");
	if (!mkdtemp(fake.folder))
		abort();
	snprintf(fake.sys, sizeof fake.sys, "%s/sys", fake.folder);
	snprintf(fake.dev, sizeof fake.dev, "%s/dev", fake.folder);
	char path[PATH_MAX];
	mkdir(fake.sys, 0700);
	mkdir(fake.dev, 0700);
	for (int i = 0; i < 3; i++) {
		fake_path(path, fake.sys, (const char *const[]){"class", "class/hidraw", "devices"}[i], 0);
		mkdir(path, 0700);
	}
	for (int i = 0; i < FAKE_NODES; i++)
		fake.nodes[i] = (fake_node){.device = -1, .host = -1};
}

/* What the kernel's sysfs tells of a pad. uevent NULL: that of the descriptor's. */
static inline void fake_describe(int number, const input_test_descriptor *pad, const char *uevent)
{
	char path[PATH_MAX], target[PATH_MAX], text[512];
	snprintf(text, sizeof text, "DRIVER=hid-generic\nHID_ID=%04X:%08X:%08X\nHID_NAME=%s\nHID_UNIQ=serial %d\n",
	         pad->bus, pad->vendor, pad->product, pad->name, number);
	fake_path(path, fake.sys, "devices/pad%d", number);
	mkdir(path, 0700);
	fake_path(path, fake.sys, "devices/pad%d/uevent", number);
	fake_write(path, uevent ? uevent : text, strlen(uevent ? uevent : text), 0600);
	fake_path(path, fake.sys, "devices/pad%d/report_descriptor", number);
	fake_write(path, pad->bytes, pad->size, 0600);
	fake_path(path, fake.sys, "class/hidraw/hidraw%d", number);
	mkdir(path, 0700);
	fake_path(path, fake.sys, "class/hidraw/hidraw%d/device", number);
	snprintf(target, sizeof target, "../../../devices/pad%d", number);
	if (symlink(target, path) != 0)
		abort();
}

/* mode 0: it may not be opened. */
static inline void fake_plug_mode(int number, const input_test_descriptor *pad, mode_t mode)
{
	int ends[2];
	char path[PATH_MAX];
	if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0)
		abort();
	pthread_mutex_lock(&fake.lock);
	fake.nodes[number] = (fake_node){.device = ends[0], .host = ends[1]};
	pthread_mutex_unlock(&fake.lock);
	fake_describe(number, pad, NULL);
	fake_path(path, fake.dev, "hidraw%d", number);
	fake_write(path, "", 0, mode);
}

static inline void fake_plug(int number, const input_test_descriptor *pad)
{
	fake_plug_mode(number, pad, 0600);
}

static inline void fake_chmod(int number, mode_t mode)
{
	char path[PATH_MAX];
	fake_path(path, fake.dev, "hidraw%d", number);
	chmod(path, mode);
}

static inline void fake_unplug(int number)
{
	static const char *const files[] = {"devices/pad%d/uevent", "devices/pad%d/report_descriptor", "devices/pad%d",
	                                    "class/hidraw/hidraw%d/device", "class/hidraw/hidraw%d"};
	char path[PATH_MAX];
	pthread_mutex_lock(&fake.lock);
	fake_node node = fake.nodes[number];
	fake.nodes[number] = (fake_node){.device = -1, .host = -1};
	pthread_mutex_unlock(&fake.lock);
	if (node.device >= 0)
		close(node.device);
	if (node.host >= 0)
		close(node.host);
	for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
		fake_path(path, fake.sys, files[i], number);
		remove(path);
	}
	fake_path(path, fake.dev, "hidraw%d", number);
	unlink(path);
}

static inline void fake_end(void)
{
	char path[PATH_MAX];
	for (int i = 0; i < FAKE_NODES; i++)
		fake_unplug(i);
	for (int i = 2; i >= 0; i--) {
		fake_path(path, fake.sys, (const char *const[]){"class", "class/hidraw", "devices"}[i], 0);
		rmdir(path);
	}
	rmdir(fake.dev);
	rmdir(fake.sys);
	rmdir(fake.folder);
}

/* ---- what a pad does --------------------------------------------------------------------------------------------- */

/* Sends a report; waits where the reader is behind. False: nobody has the node open. */
static inline bool fake_send(int number, const void *report, size_t size)
{
	int fd = fake.nodes[number].device;
	while (send(fd, report, size, MSG_NOSIGNAL) < 0) {
		if (errno != EAGAIN)
			return false;
		poll(&(struct pollfd){.fd = fd, .events = POLLOUT}, 1, 100);
	}
	return true;
}

/* The next output report; its size, or 0: none came in time, or the node was closed. */
static inline size_t fake_receive(int number, void *report, size_t size, int timeout_ms)
{
	int fd = fake.nodes[number].device;
	poll(&(struct pollfd){.fd = fd, .events = POLLIN}, 1, timeout_ms);
	ssize_t got = recv(fd, report, size, 0);
	return got > 0 ? (size_t)got : 0;
}

#endif
