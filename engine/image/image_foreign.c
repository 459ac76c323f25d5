/* Finds the module with OpenImageIO and loads it once. */
#include "image/image_internal.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static pthread_once_t foreign_once = PTHREAD_ONCE_INIT;
static const image_foreign *foreign; /* written by foreign_load_once, read after pthread_once */
static image_message foreign_trouble;

/* The folder of the running program, without a slash at its end. False: unknown. */
static bool foreign_program_folder(char folder[PATH_MAX])
{
	ssize_t length = readlink("/proc/self/exe", folder, PATH_MAX - 1);
	if (length <= 0)
		return false;
	folder[length] = '\0';
	char *slash = strrchr(folder, '/');
	if (!slash)
		return false;
	*slash = '\0';
	return true;
}

static void foreign_load_once(void)
{
	/* Relative to the program: of a build, of a build as seen from a test, and of an installation. */
	static const char *const places[] = {"", "/..", "/../lib/stilb"};
	char folder[PATH_MAX], path[PATH_MAX + 64];
	void *module = NULL;
	bool found = false; /* the file exists: the message is the loader's */
	if (!foreign_program_folder(folder))
		folder[0] = '\0';
	for (size_t i = 0; i < sizeof places / sizeof *places && !module && !found; i++) {
		snprintf(path, sizeof path, "%s%s/" IMAGE_FOREIGN_FILE, folder, places[i]);
		found = access(path, F_OK) == 0;
		if (found)
			module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
	}
	foreign = module ? dlsym(module, IMAGE_FOREIGN_SYMBOL) : NULL;
	if (foreign)
		return;
	const char *error = found ? dlerror() : NULL;
	snprintf(foreign_trouble.text, sizeof foreign_trouble.text,
	         "the module for such pictures, " IMAGE_FOREIGN_FILE ", %s%s",
	         found ? "cannot be loaded: " : "is neither beside the program nor in ../lib/stilb", error ? error : "");
}

const image_foreign *image_foreign_load(image_message *message)
{
	STILB_ASSERT(message);
	pthread_once(&foreign_once, foreign_load_once);
	STILB_ASSERT(foreign || foreign_trouble.text[0]);
	if (!foreign)
		*message = foreign_trouble;
	return foreign;
}
