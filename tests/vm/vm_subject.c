/*
 * vm_subject hidraw|hidapi|enumerate: a process under test in test_vm_storm.c. Prints "ready" and runs until its
 * standard input ends.
 *
 *   hidraw, hidapi   reads pads with that backend, a frame every 16 ms. Prints at the end how many pads came and went,
 *                    how many reports were read, and how many more descriptors and threads are open than at the start
 *   enumerate        calls hid_enumerate all the time, as a program would that relies on hidapi
 */
#include "input/device/input_pads.h"

#include <dirent.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool storm_is_over(int timeout_ms)
{
	struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
	return poll(&input, 1, timeout_ms) != 0;
}

static void say_ready(void)
{
	puts("ready");
	fflush(stdout);
}

static int entries(const char *path)
{
	int count = 0;
	DIR *folder = opendir(path);
	while (folder && readdir(folder))
		count++;
	if (folder)
		closedir(folder);
	return count;
}

static void hear_all(stilb_input_pads *pads)
{
	stilb_input_event event;
	while (stilb_input_pads_next(pads, INT64_MAX, &event))
		continue;
}

static int listen_to_pads(stilb_input_backend backend)
{
	stilb_input_pads *pads = NULL;
	stilb_input_pads_desc desc = {.backend = backend};
	if (stilb_input_pads_create(&desc, &pads) != STILB_OK)
		return 1;
	stilb_input_pads_wait(pads, 10000); /* until all pads were found */
	int descriptors = entries("/proc/self/fd"), threads = entries("/proc/self/task");
	say_ready();
	while (!storm_is_over(16))
		hear_all(pads);
	stilb_input_pads_stats stats;
	for (int tries = 0; tries < 100; tries++) {
		hear_all(pads);
		stats = stilb_input_pads_stats_get(pads);
		if (stats.added == stats.removed)
			break;
		usleep(20000);
	}
	usleep(100000); /* for readers whose pad has just gone to end */
	hear_all(pads);
	printf("%llu %llu %llu %d %d\n", (unsigned long long)stats.added, (unsigned long long)stats.removed,
	       (unsigned long long)stats.reports, entries("/proc/self/fd") - descriptors,
	       entries("/proc/self/task") - threads);
	stilb_input_pads_destroy(pads);
	return 0;
}

static int enumerate(void)
{
	unsigned long long loops = 0, seen = 0;
	say_ready();
	for (; !storm_is_over(0); loops++) {
		struct hid_device_info *all = hid_enumerate(0, 0);
		seen += all ? 1 : 0;
		hid_free_enumeration(all);
	}
	printf("%llu %llu 0 0 0\n", seen, loops);
	return 0;
}

int main(int argc, char **argv)
{
	const char *kind = argc == 2 ? argv[1] : "";
	if (strcmp(kind, "hidraw") == 0)
		return listen_to_pads(STILB_INPUT_BACKEND_HIDRAW);
	if (strcmp(kind, "hidapi") == 0)
		return listen_to_pads(STILB_INPUT_BACKEND_HIDAPI);
	if (strcmp(kind, "enumerate") == 0)
		return enumerate();
	fprintf(stderr, "usage: vm_subject hidraw|hidapi|enumerate\n");
	return 2;
}
