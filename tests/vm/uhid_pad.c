#include "vm/uhid_pad.h"

#include "input/hid/input_layout.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/uhid.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#define OUTPUTS_MAX 256u
#define OUTPUT_BYTES 16u /* the first bytes of each output report, which are kept */

struct uhid_pad {
	int fd, stop;
	bool bluetooth;
	uint8_t address[6]; /* in the order of the feature report, last byte first */
	pthread_t thread;
	pthread_mutex_t lock; /* protects the members below */
	pthread_cond_t started_changed;
	bool started;
	uint32_t features, output_count;
	uint8_t outputs[OUTPUTS_MAX][OUTPUT_BYTES];
};

static void die(const char *what)
{
	fprintf(stderr, "uhid_pad: %s: %s\n", what, strerror(errno));
	exit(1);
}

static void tell(const uhid_pad *pad, const struct uhid_event *event)
{
	if (write(pad->fd, event, sizeof *event) != sizeof *event)
		die("/dev/uhid");
}

/* ---- feature reports of a DualShock 4 and a DualSense ------------------------------------------------------------ */

static void put16(uint8_t *at, int value)
{
	at[0] = (uint8_t)value;
	at[1] = (uint8_t)(value >> 8);
}

/* Calibration: the ends of the ranges of the gyroscope (three), its speed and the accelerometer. hid-sony of Linux 6.1
 * divides by each range, and an empty one stops the kernel. Over USB the two ends of a range are adjacent, over
 * Bluetooth all upper ends come first; with ends that alternate no range is empty in either order. */
static void calibrate(uint8_t *report)
{
	for (int i = 0; i < 6; i++)
		put16(report + 7 + 2 * i, i % 2 == 0 ? 1000 : -1000);
	put16(report + 19, 540);
	put16(report + 21, 540);
	for (int i = 0; i < 6; i++)
		put16(report + 23 + 2 * i, i % 2 == 0 ? 8192 : -8192);
}

/* Writes the feature report with this id; returns its size in bytes, id included, 0 if there is none. DualShock 4: 0x02
 * and 0x05 calibration, 0x81 and 0x12 address, 0xa3 version; DualSense: 0x05 calibration, 0x09 address, 0x20 version.
 * Over Bluetooth a feature report ends in a CRC over the byte 0xa3 and all bytes before the CRC. */
static size_t feature(const uhid_pad *pad, uint8_t id, uint8_t *report)
{
	static const struct {
		uint8_t id, size;
	} sizes[] = {{0x02, 37}, {0x05, 41}, {0x09, 20}, {0x12, 16}, {0x20, 64}, {0x81, 7}, {0xa3, 49}};
	size_t size = 0;
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		if (sizes[i].id == id)
			size = sizes[i].size;
	}
	if (size == 0)
		return 0;
	memset(report, 0, size);
	report[0] = id;
	if (id == 0x02 || id == 0x05)
		calibrate(report);
	else if (id == 0x09 || id == 0x12 || id == 0x81)
		memcpy(report + 1, pad->address, sizeof pad->address);
	if (pad->bluetooth) {
		uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, "\xa3", 1), report, size - 4);
		memcpy(report + size - 4, &crc, 4);
	}
	return size;
}

/* ---- the kernel's side ------------------------------------------------------------------------------------------- */

static void answer(uhid_pad *pad, const struct uhid_event *asked)
{
	struct uhid_event reply = {0};
	if (asked->type == UHID_GET_REPORT) {
		reply.type = UHID_GET_REPORT_REPLY;
		reply.u.get_report_reply.id = asked->u.get_report.id;
		size_t size = feature(pad, asked->u.get_report.rnum, reply.u.get_report_reply.data);
		reply.u.get_report_reply.size = (__u16)size;
		reply.u.get_report_reply.err = size > 0 ? 0 : EIO;
	} else {
		reply.type = UHID_SET_REPORT_REPLY;
		reply.u.set_report_reply.id = asked->u.set_report.id;
	}
	if (write(pad->fd, &reply, sizeof reply) < 0 && errno != EINVAL) /* EINVAL: the pad is being unplugged */
		die("answer to the kernel");
}

static void keep_output(uhid_pad *pad, const uint8_t *report, size_t size)
{
	if (pad->output_count < OUTPUTS_MAX)
		memcpy(pad->outputs[pad->output_count++], report, size < OUTPUT_BYTES ? size : OUTPUT_BYTES);
}

static void hear(uhid_pad *pad, const struct uhid_event *event)
{
	if (event->type == UHID_GET_REPORT || event->type == UHID_SET_REPORT)
		answer(pad, event);
	pthread_mutex_lock(&pad->lock);
	if (event->type == UHID_START)
		pad->started = true;
	else if (event->type == UHID_OUTPUT)
		keep_output(pad, event->u.output.data, event->u.output.size);
	else if (event->type == UHID_SET_REPORT)
		keep_output(pad, event->u.set_report.data, event->u.set_report.size);
	else if (event->type == UHID_GET_REPORT)
		pad->features++;
	pthread_mutex_unlock(&pad->lock);
	pthread_cond_broadcast(&pad->started_changed);
}

static void *serve(void *argument)
{
	uhid_pad *pad = argument;
	struct pollfd fds[2] = {{.fd = pad->fd, .events = POLLIN}, {.fd = pad->stop, .events = POLLIN}};
	while (poll(fds, 2, -1) >= 0 && !fds[1].revents) {
		struct uhid_event event;
		if (read(pad->fd, &event, sizeof event) > 0)
			hear(pad, &event);
	}
	return NULL;
}

uhid_pad *uhid_pad_create(const input_test_descriptor *kind, const char *unique)
{
	uhid_pad *pad = calloc(1, sizeof *pad);
	if (!pad)
		die("memory");
	pad->fd = open("/dev/uhid", O_RDWR | O_CLOEXEC | O_NONBLOCK);
	pad->stop = eventfd(0, EFD_CLOEXEC);
	if (pad->fd < 0 || pad->stop < 0)
		die("/dev/uhid");
	pad->bluetooth = kind->bus == STILB_INPUT_BUS_BLUETOOTH;
	uint8_t *a = pad->address; /* the kernel's drivers identify a pad by it; zeros if unique is not an address */
	sscanf(unique, "%hhx:%hhx:%hhx:%hhx:%hhx:%hhx", &a[5], &a[4], &a[3], &a[2], &a[1], &a[0]);
	pthread_mutex_init(&pad->lock, NULL);
	pthread_cond_init(&pad->started_changed, NULL);

	struct uhid_event event = {.type = UHID_CREATE2};
	struct uhid_create2_req *create = &event.u.create2;
	snprintf((char *)create->name, sizeof create->name, "%s", kind->name);
	snprintf((char *)create->uniq, sizeof create->uniq, "%s", unique);
	memcpy(create->rd_data, kind->bytes, kind->size);
	create->rd_size = (__u16)kind->size;
	create->bus = kind->bus;
	create->vendor = kind->vendor;
	create->product = kind->product;
	tell(pad, &event);
	if (pthread_create(&pad->thread, NULL, serve, pad) != 0)
		die("thread");
	pthread_mutex_lock(&pad->lock);
	struct timespec late;
	clock_gettime(CLOCK_REALTIME, &late);
	late.tv_sec += 10;
	while (!pad->started) {
		errno = pthread_cond_timedwait(&pad->started_changed, &pad->lock, &late);
		if (errno != 0)
			die("no driver of the kernel takes the pad");
	}
	pthread_mutex_unlock(&pad->lock);
	return pad;
}

void uhid_pad_destroy(uhid_pad *pad)
{
	if (!pad)
		return;
	tell(pad, &(struct uhid_event){.type = UHID_DESTROY});
	if (write(pad->stop, &(uint64_t){1}, 8) != 8)
		die("eventfd");
	pthread_join(pad->thread, NULL);
	pthread_cond_destroy(&pad->started_changed);
	pthread_mutex_destroy(&pad->lock);
	close(pad->stop);
	close(pad->fd);
	free(pad);
}

void uhid_pad_send(uhid_pad *pad, const uint8_t *report, size_t size)
{
	struct uhid_event event = {.type = UHID_INPUT2, .u.input2.size = (__u16)size};
	memcpy(event.u.input2.data, report, size);
	size_t all = offsetof(struct uhid_event, u.input2.data) + size; /* the kernel assumes zeros for the rest */
	if (write(pad->fd, &event, all) != (ssize_t)all)
		die("/dev/uhid");
}

uint32_t uhid_pad_outputs(uhid_pad *pad, const uint8_t *start, size_t size)
{
	uint32_t count = 0;
	pthread_mutex_lock(&pad->lock);
	for (uint32_t i = 0; i < pad->output_count; i++)
		count += memcmp(pad->outputs[i], start, size) == 0;
	pthread_mutex_unlock(&pad->lock);
	return count;
}

uint32_t uhid_pad_features(uhid_pad *pad)
{
	pthread_mutex_lock(&pad->lock);
	uint32_t count = pad->features;
	pthread_mutex_unlock(&pad->lock);
	return count;
}
