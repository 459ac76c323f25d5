/* stilb bench: runs the program stilb-bench, which is installed beside this one, with the same arguments. */
#include "game/cli/flags.h"
#include "game/commands.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Writes the path of stilb-bench, in the folder of this program. False, with errno: that folder is not known, or the
 * path is too long. */
static bool program_path(char path[PATH_MAX])
{
	static const char name[] = "stilb-bench";
	ssize_t length = readlink("/proc/self/exe", path, PATH_MAX - 1);
	if (length < 0)
		return false;
	path[length] = '\0';
	char *file = strrchr(path, '/') + 1;
	if (file + sizeof name > path + PATH_MAX) {
		errno = ENAMETOOLONG;
		return false;
	}
	memcpy(file, name, sizeof name);
	return true;
}

int bench_command(int argc, char **argv)
{
	char path[PATH_MAX];
	char **words = calloc((size_t)argc + 2, sizeof *words);
	if (!words || !program_path(path)) {
		stilb_log("bench: cannot find the folder of this program: %s", strerror(errno));
		free(words);
		return EXIT_FAILED;
	}
	words[0] = path;
	memcpy(words + 1, argv, (size_t)argc * sizeof *words);
	execv(path, words);
	bool missing = errno == ENOENT;
	stilb_log("bench: cannot start '%s': %s%s", path, strerror(errno),
	          missing ? "; './dev build' builds it, and so does cmake with STILB_BENCH=ON" : "");
	free(words);
	return missing ? EXIT_REFUSED : EXIT_FAILED;
}
