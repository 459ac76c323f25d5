/* A new folder, the current one while a group of tests runs. Include it in one file of a test. */
#ifndef FOLDER_H
#define FOLDER_H

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder_name[128];

/* The group's set-up. */
static int folder_make(void **state)
{
	(void)state;
	snprintf(folder_name, sizeof folder_name, "%s_XXXXXX", program_invocation_short_name);
	return mkdtemp(folder_name) && chdir(folder_name) == 0 ? 0 : -1;
}

/* Removes all entries beside "." and "..", and returns how many there were. */
static inline int folder_clear(void)
{
	int count = 0;
	DIR *dir = opendir(".");
	for (struct dirent *entry; dir && (entry = readdir(dir));)
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
			count += remove(entry->d_name) == 0;
	closedir(dir);
	return count;
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
