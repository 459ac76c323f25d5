/*
 * umockdev: runs a program in a test bed with devices that are not there: its /sys, /dev and the ioctls of its nodes
 * are umockdev's (package umockdev). The program sees them through its C library and needs no change.
 */
#ifndef STILB_UMOCKDEV_H
#define STILB_UMOCKDEV_H

#include "support/program.h"

#define UMOCKDEV_RUN "/usr/bin/umockdev-run"

/* The root of the test bed, NULL: this program does not run in one. */
static inline const char *umockdev_root(void)
{
	return getenv("UMOCKDEV_DIR");
}

/* False: umockdev is not installed. Say so and exit with 77. */
static inline bool umockdev_is_installed(void)
{
	return access(UMOCKDEV_RUN, X_OK) == 0;
}

/* A description of devices as umockdev-record writes them, what a node answers to ioctls, and what it sends and
 * expects. */
typedef struct umockdev_bed {
	const char *node; /* "/dev/hidraw7" */
	const char *devices, *ioctls;
	const void *script;
	size_t script_size;
} umockdev_bed;

static inline bool umockdev_write(const char *path, const void *bytes, size_t size)
{
	FILE *file = fopen(path, "w");
	bool wrote = file && fwrite(bytes, 1, size, file) == size;
	return (!file || fclose(file) == 0) && wrote;
}

/* Runs words in the test bed, whose files go into `folder`, which is there. False: it could not be started. */
static inline bool umockdev_run(program_run *run, const umockdev_bed *bed, const char *folder, const char *const *words)
{
	char paths[3][256], arguments[2][512];
	const char *const names[3] = {"devices", "ioctls", "script"};
	const char *all[24] = {UMOCKDEV_RUN, "-d", paths[0], "-i", arguments[0], "-s", arguments[1], "--"};
	for (int i = 0; i < 3; i++)
		snprintf(paths[i], sizeof paths[i], "%s/%s", folder, names[i]);
	for (int i = 0; i < 2; i++)
		snprintf(arguments[i], sizeof arguments[i], "%s=%s", bed->node, paths[1 + i]);
	for (size_t i = 0; i + 9 < sizeof all / sizeof *all && words[i]; i++)
		all[8 + i] = words[i];
	bool ready = umockdev_write(paths[0], bed->devices, strlen(bed->devices)) &&
	             umockdev_write(paths[1], bed->ioctls, strlen(bed->ioctls)) &&
	             umockdev_write(paths[2], bed->script, bed->script_size) && program_start(run, all, NULL, -1);
	if (ready)
		program_wait(run);
	for (int i = 0; i < 3; i++)
		unlink(paths[i]);
	return ready;
}

#endif
