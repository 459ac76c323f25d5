/* Finds and loads the module with OpenImageIO, once. */
#include "image/image_internal.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static pthread_once_t codec_once = PTHREAD_ONCE_INIT;
static const image_codec *codec; /* written once, before pthread_once returns to anybody */
static image_message codec_trouble;

/* The folder of the running program, without a slash at its end. */
static bool codec_program_folder(char folder[PATH_MAX])
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

static void codec_load_once(void)
{
	/* Beside the program; where the build puts it, seen from a test; where an installation puts it. */
	static const char *const places[] = {"", "/..", "/../lib/stilb"};
	char folder[PATH_MAX], path[PATH_MAX + 64];
	void *module = NULL;
	bool found = false; /* then its own error is the one to tell */
	if (!codec_program_folder(folder))
		folder[0] = '\0';
	for (size_t i = 0; i < sizeof places / sizeof *places && !module && !found; i++) {
		snprintf(path, sizeof path, "%s%s/" IMAGE_CODEC_FILE, folder, places[i]);
		found = access(path, F_OK) == 0;
		if (found)
			module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
	}
	codec = module ? dlsym(module, IMAGE_CODEC_SYMBOL) : NULL;
	if (codec)
		return;
	const char *error = found ? dlerror() : NULL;
	snprintf(codec_trouble.text, sizeof codec_trouble.text, "the module for pictures, " IMAGE_CODEC_FILE ", %s%s",
	         found ? "cannot be loaded: " : "is neither beside the program nor in ../lib/stilb", error ? error : "");
}

const image_codec *image_codec_load(image_message *message)
{
	pthread_once(&codec_once, codec_load_once);
	if (!codec)
		*message = codec_trouble;
	return codec;
}
