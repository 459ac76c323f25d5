/* A new folder, the current one while a group of tests runs. Include it in one file of a test. */
#ifndef FOLDER_H
#define FOLDER_H

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char folder_name[128];

/* The group's set-up. */
static int folder_make(void **state)
{
	(void)state;
	snprintf(folder_name, sizeof folder_name, "%s_XXXXXX", program_invocation_short_name);
	return mkdtemp(folder_name) && chdir(folder_name) == 0 ? 0 : -1;
}

/* What its tear-down ends with. Fails where a test left a file: a temporary one of what it tests, for example. */
static int folder_remove(void)
{
	if (chdir("..") != 0 || rmdir(folder_name) != 0) {
		perror(folder_name);
		return -1;
	}
	return 0;
}

#endif
