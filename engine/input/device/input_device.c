#include "input/device/input_device_internal.h"
#include "input/input_text_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/hidraw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define UEVENT_MAX 4096u /* bytes: a page, the most that the kernel gives */

bool input_device_is_hidraw(const char *name)
{
	STILB_ASSERT(name);
	static const char prefix[] = "hidraw";
	size_t length = sizeof prefix - 1;
	return strncmp(name, prefix, length) == 0 && name[length] != '\0' &&
	       strspn(name + length, "0123456789") == strlen(name + length);
}

/* ---- sysfs ------------------------------------------------------------------------------------------------------- */

/* Reads at most size bytes of the file `leaf` of the node's HID device. Bytes read, or a negative errno. */
static ssize_t sysfs_read(const input_roots *roots, const char *name, const char *leaf, void *bytes, size_t size)
{
	char path[PATH_MAX];
	if (snprintf(path, sizeof path, "%s/class/hidraw/%s/device/%s", roots->sys, name, leaf) >= (int)sizeof path)
		return -ENAMETOOLONG;
	int fd = open(path, O_RDONLY | O_CLOEXEC);
	if (fd < 0)
		return -errno;
	size_t filled = 0;
	ssize_t got;
	do {
		got = read(fd, (char *)bytes + filled, size - filled);
		filled += got > 0 ? (size_t)got : 0;
	} while ((got > 0 && filled < size) || (got < 0 && errno == EINTR));
	int error = got < 0 ? -errno : 0;
	close(fd);
	return error != 0 ? error : (ssize_t)filled;
}

/* The value of the line KEY=value in a uevent file, not terminated, or NULL. */
static const char *uevent_value(const char *uevent, const char *key, size_t *length)
{
	size_t key_length = strlen(key);
	for (const char *line = uevent; line; line = strchr(line, '\n')) {
		line += *line == '\n';
		if (strncmp(line, key, key_length) == 0 && line[key_length] == '=') {
			*length = strcspn(line + key_length + 1, "\n");
			return line + key_length + 1;
		}
	}
	return NULL;
}

static void uevent_text(const char *uevent, const char *key, char *out, size_t room)
{
	size_t length = 0;
	const char *value = uevent_value(uevent, key, &length);
	input_text_copy(out, room, value, length);
}

/* HID_ID=bus:vendor:product, in hexadecimal: 0003:0000054C:000005C4. */
static int uevent_id(const char *uevent, stilb_input_pad_info *info)
{
	size_t length;
	unsigned bus, vendor, product;
	const char *value = uevent_value(uevent, "HID_ID", &length);
	if (!value || sscanf(value, "%4x:%8x:%8x", &bus, &vendor, &product) != 3)
		return -ENODEV;
	info->bus = (uint16_t)bus;
	info->vendor = (uint16_t)vendor;
	info->product = (uint16_t)product;
	return 0;
}

/* Sets info->device, the device's folder in sysfs with links resolved; it stays empty if the path does not fit. */
static void device_folder(const input_roots *roots, const char *name, stilb_input_pad_info *info)
{
	char path[PATH_MAX];
	int length = snprintf(path, sizeof path, "%s/class/hidraw/%s/device", roots->sys, name);
	char *real = length < (int)sizeof path ? realpath(path, NULL) : NULL;
	if (real && strlen(real) < sizeof info->device)
		memcpy(info->device, real, strlen(real) + 1);
	free(real);
}

int input_device_info(const input_roots *roots, const char *name, stilb_input_pad_info *info)
{
	STILB_ASSERT(roots && info && input_device_is_hidraw(name) && "the name of a node, no path");
	memset(info, 0, sizeof *info);
	if (snprintf(info->path, sizeof info->path, "%s/%s", roots->dev, name) >= (int)sizeof info->path)
		return -ENAMETOOLONG;
	char uevent[UEVENT_MAX + 1];
	ssize_t size = sysfs_read(roots, name, "uevent", uevent, UEVENT_MAX);
	if (size < 0)
		return size == -ENOENT ? -ENODEV : (int)size;
	uevent[size] = '\0';
	if (uevent_id(uevent, info) != 0)
		return -ENODEV;
	uevent_text(uevent, "HID_NAME", info->name, sizeof info->name);
	uevent_text(uevent, "HID_UNIQ", info->unique, sizeof info->unique);
	device_folder(roots, name, info);
	ssize_t described = sysfs_read(roots, name, "report_descriptor", info->descriptor, sizeof info->descriptor);
	if (described < 0)
		return described == -ENOENT ? -ENODEV : (int)described;
	STILB_ASSERT(described <= (ssize_t)sizeof info->descriptor);
	info->descriptor_size = (uint16_t)described;
	return 0;
}

/* ---- the node ---------------------------------------------------------------------------------------------------- */

int input_device_open(const input_backend *backend, const char *path, input_device *device)
{
	STILB_ASSERT(backend && path && device);
	int fd = open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
	if (fd < 0)
		return errno == ENOENT || errno == ENXIO ? -ENODEV : -errno;
	int size; /* of the report descriptor; it is asked for because only a hidraw node answers the question */
	if (ioctl(fd, HIDIOCGRDESCSIZE, &size) < 0) {
		close(fd);
		return -ENODEV;
	}
	device->backend = backend;
	return backend->open(path, fd, device);
}
