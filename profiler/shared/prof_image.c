/*
 * Images: the program, and the shared objects in it, that record in the profiler of libstilb.so (STILB_PROF_SHARED).
 * Each has sites of its own. Events hold the distance of their site from this library's array of sites in 30 bits, and
 * images lie further apart than that; so each gets a range of distances as long as its memory, behind the ranges of
 * those before. Only the library's own range begins where its memory does.
 */
#include "profiler/prof_internal.h"

#include <dlfcn.h>
#include <link.h>

#define PROF_IMAGES_MAX 64
#define PROF_OFFSET_MAX (INT64_C(1) << 29) /* of events */

typedef struct prof_image {
	const char *begin;
	uintptr_t size;
	int64_t offset; /* of a site at begin */
	/* The image's array of sites; first is stored last, release, and loaded first, acquire. NULL: none is known. */
	const stilb_prof_site *first, *stop;
} prof_image;

/* Entries below count do not change but for first and stop. count is stored release under the lock and loaded acquire
 * without it. Entry 0 is this library. */
static struct {
	prof_mutex lock;
	uint32_t count;
	prof_image images[PROF_IMAGES_MAX];
} prof_images = {.lock = PROF_MUTEX_INIT};

static const uint32_t prof_image_never; /* the session of images that do not record */

static uint32_t prof_image_count(void)
{
	return __atomic_load_n(&prof_images.count, __ATOMIC_ACQUIRE); /* pairs with prof_image_add */
}

/* The entry with this address in its memory, or NULL. */
static prof_image *prof_image_at(const void *address)
{
	uint32_t count = prof_image_count();
	for (uint32_t i = 0; i < count; i++)
		if ((uintptr_t)address - (uintptr_t)prof_images.images[i].begin < prof_images.images[i].size)
			return &prof_images.images[i];
	return NULL;
}

/* For dl_iterate_phdr: true if the image has image->begin in its memory, which *image then is. */
static int prof_image_match(struct dl_phdr_info *info, size_t size, void *user)
{
	prof_image *image = user;
	uintptr_t low = UINTPTR_MAX, high = 0, address = (uintptr_t)image->begin;
	(void)size;
	for (int i = 0; i < info->dlpi_phnum; i++) {
		if (info->dlpi_phdr[i].p_type != PT_LOAD)
			continue;
		uintptr_t begin = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr, end = begin + info->dlpi_phdr[i].p_memsz;
		low = begin < low ? begin : low;
		high = end > high ? end : high;
	}
	if (address < low || address >= high)
		return 0;
	low &= ~(uintptr_t)63; /* sites lie at multiples of 64 */
	image->begin -= address - low;
	image->size = high - low;
	return 1;
}

/* Finds the image with this address, which then stays in memory. False: there is none. Takes the loader's lock, which
 * is held around constructors too: to be called without ours. */
static bool prof_image_find(const void *address, prof_image *image)
{
	Dl_info file;
	*image = (prof_image){.begin = address};
	if (!dl_iterate_phdr(prof_image_match, image))
		return false;
	if (dladdr(address, &file) != 0 && file.dli_fname &&
	    !dlopen(file.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE))
		dlerror(); /* the program itself is not found by its name, and stays anyway; forget that */
	return true;
}

/* Adds an image that is not this library. NULL: there is no room. */
static prof_image *prof_image_add(const prof_image *image)
{
	assert(prof_mutex_is_mine(&prof_images.lock) && prof_images.count > 0);
	uint32_t count = prof_images.count;
	const prof_image *last = &prof_images.images[count - 1];
	int64_t offset = (last->offset + (int64_t)last->size + 63) & ~INT64_C(63);
	if (count == PROF_IMAGES_MAX || offset + (int64_t)image->size > PROF_OFFSET_MAX)
		return NULL;
	prof_images.images[count] = *image;
	prof_images.images[count].offset = offset;
	__atomic_store_n(&prof_images.count, count + 1, __ATOMIC_RELEASE); /* pairs with prof_image_count */
	return &prof_images.images[count];
}

/* Makes entry 0. */
static void prof_image_add_self(void)
{
	prof_image self;
	bool found = prof_image_find(&prof_images, &self);
	prof_mutex_lock(&prof_images.lock);
	if (found && prof_images.count == 0) {
		self.offset = self.begin - (const char *)__start_stilb_prof_section;
		prof_images.images[0] = self;
		__atomic_store_n(&prof_images.count, 1, __ATOMIC_RELEASE); /* pairs with prof_image_count */
	}
	prof_mutex_unlock(&prof_images.lock);
}

/* The entry of the image with this address, which is added if need be. NULL: there is none, or no room. */
static prof_image *prof_image_of(const void *address)
{
	prof_image image;
	if (prof_image_count() == 0)
		prof_image_add_self();
	prof_image *known = prof_image_at(address);
	if (known || prof_image_count() == 0 || !prof_image_find(address, &image))
		return known;
	prof_mutex_lock(&prof_images.lock);
	known = prof_image_at(address); /* another thread was faster */
	if (!known)
		known = prof_image_add(&image);
	prof_mutex_unlock(&prof_images.lock);
	return known;
}

const uint32_t *stilb_prof_image_join(stilb_prof_image *image)
{
	assert(image && (image->stop - image->first) >= 0);
	prof_image *known = prof_image_of(image);
	prof_mutex_lock(&prof_images.lock);
	if (!image->session) {
		const uint32_t *session = known ? &stilb_prof_session : &prof_image_never;
		if (known) {
			image->begin = (uintptr_t)known->begin;
			image->size = known->size;
			image->offset = (uint64_t)known->offset;
			known->stop = image->stop;
			if (image->first != image->stop)
				__atomic_store_n(&known->first, image->first, __ATOMIC_RELEASE); /* pairs with prof_image_first */
		}
		__atomic_store_n(&image->session, session, __ATOMIC_RELEASE); /* pairs with stilb_prof_session_now */
	}
	prof_mutex_unlock(&prof_images.lock);
	return image->session;
}

uint64_t stilb_prof_site_offset_of(const stilb_prof_site *site)
{
	if (site >= __start_stilb_prof_section && site < __stop_stilb_prof_section)
		return stilb_prof_site_offset(site);
	const prof_image *image = prof_image_of(site);
	return image ? (uint64_t)(image->offset + ((const char *)site - image->begin))
	             : stilb_prof_site_offset(&prof_site_more);
}

const stilb_prof_site *prof_site_at(int64_t offset)
{
	uint32_t count = prof_image_count();
	for (uint32_t i = 0; i < count; i++) {
		const prof_image *image = &prof_images.images[i];
		if (offset >= image->offset && offset - image->offset < (int64_t)image->size)
			return (const stilb_prof_site *)(const void *)(image->begin + (offset - image->offset));
	}
	if (count > 0)
		return &prof_site_more;
	return (const stilb_prof_site *)(const void *)((const char *)__start_stilb_prof_section + offset);
}

/* ---- walking ----------------------------------------------------------------------------------------------------- */

static const stilb_prof_site *prof_image_first(const prof_image *image)
{
	return __atomic_load_n(&image->first, __ATOMIC_ACQUIRE); /* pairs with stilb_prof_image_join */
}

bool prof_image_has_site(const stilb_prof_site *site)
{
	const prof_image *image = prof_image_at(site);
	return image && prof_image_first(image) && site >= prof_image_first(image) && site < image->stop;
}

const stilb_prof_site *prof_image_site_next(const stilb_prof_site *previous)
{
	uint32_t count = prof_image_count(), i = 0;
	if (previous) {
		const prof_image *image = prof_image_at(previous);
		assert(image);
		if (previous + 1 < image->stop)
			return previous + 1;
		i = (uint32_t)(image - prof_images.images) + 1;
	}
	for (; i < count; i++)
		if (prof_image_first(&prof_images.images[i]))
			return prof_image_first(&prof_images.images[i]);
	return NULL;
}
