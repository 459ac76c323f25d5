/* Finds the module with OpenImageIO and loads it once. */
#include "base/base_file.h"
#include "image/image_internal.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>

static pthread_once_t foreign_once = PTHREAD_ONCE_INIT;
static const image_foreign *foreign; /* written by foreign_load_once, read after pthread_once */
static image_message foreign_trouble;

static void foreign_load_once(void)
{
	char path[STILB_FILE_PART_MAX];
	bool found = stilb_file_find_part(IMAGE_FOREIGN_FILE, path);
	void *module = found ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
	foreign = module ? dlsym(module, IMAGE_FOREIGN_SYMBOL) : NULL;
	if (foreign)
		return;
	const char *error = found ? dlerror() : NULL;
	snprintf(foreign_trouble.text, sizeof foreign_trouble.text,
	         "the module for such pictures, " IMAGE_FOREIGN_FILE ", %s%s",
	         found ? "cannot be loaded: " : "is " STILB_FILE_PART_PLACES, error ? error : "");
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
