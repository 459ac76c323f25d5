/* Sites (places in the source that record, prof.h): the linker's array of the sites of C code, the list of all others,
 * and sites that are made at run time. */
#include "profiler/prof_internal.h"

#include <stdlib.h>
#include <string.h>

#define PROF_SITES_MADE_MAX 1024

const stilb_prof_site prof_site_more STILB_PROF_SECTION_ =
	STILB_PROF_SITE_INIT_("more names", "", 0, STILB_PROF_KIND_ZONE);

/* Head of the list: the newest site. Sites are added at the head and never removed. */
static stilb_prof_site *prof_sites;

/* The sites made at run time. Static, because events hold the distance of a site from the section of sites in 30 bits:
 * .bss is near enough, the heap is not. */
static struct {
	prof_mutex lock;
	uint32_t count;
	stilb_prof_site sites[PROF_SITES_MADE_MAX];
} prof_made = {.lock = PROF_MUTEX_INIT};

static bool prof_site_is_in_array(const stilb_prof_site *site)
{
	return site >= __start_stilb_prof_section && site < __stop_stilb_prof_section;
}

const stilb_prof_site *stilb_prof_site_next(const stilb_prof_site *previous)
{
	if (!previous)
		return __start_stilb_prof_section;
	bool own = prof_site_is_in_array(previous);
	if (!own && !prof_image_has_site(previous)) {
		/* Relaxed: the site was reached by the acquire load of the list's head, and its next was stored before that. */
		assert(__atomic_load_n(&previous->listed, __ATOMIC_RELAXED) == 1 && "a site that stilb_prof_site_next gave");
		return previous->next;
	}
	if (own && previous + 1 < __stop_stilb_prof_section)
		return previous + 1;
	const stilb_prof_site *next = prof_image_site_next(own ? NULL : previous);
	if (next)
		return next;
	return __atomic_load_n(&prof_sites, __ATOMIC_ACQUIRE); /* pairs with the release in stilb_prof_site_list */
}

bool stilb_prof_site_list(stilb_prof_site *sites, size_t count)
{
	assert(sites && count > 0 && !prof_site_is_in_array(sites));
	stilb_prof_site_offset_of(sites); /* from now on their image stays in memory */
	for (size_t i = 0; i < count; i++) {
		/* Relaxed: only decides which thread adds the site; no data depends on it. */
		if (__atomic_exchange_n(&sites[i].listed, 1, __ATOMIC_RELAXED) != 0)
			continue;
		stilb_prof_site *head = __atomic_load_n(&prof_sites, __ATOMIC_RELAXED); /* checked by the exchange */
		do
			sites[i].next = head;
		/* Release: pairs with stilb_prof_site_next. */
		while (!__atomic_compare_exchange_n(&prof_sites, &head, &sites[i], true, __ATOMIC_RELEASE, __ATOMIC_RELAXED));
	}
	return true;
}

static const stilb_prof_site *prof_site_find(const char *name, uint32_t rgb)
{
	assert(prof_mutex_is_mine(&prof_made.lock));
	for (uint32_t i = 0; i < prof_made.count; i++)
		if (prof_made.sites[i].color == rgb && strcmp(prof_made.sites[i].name, name) == 0)
			return &prof_made.sites[i];
	return NULL;
}

static const stilb_prof_site *prof_site_add(const char *name, uint32_t rgb)
{
	assert(prof_mutex_is_mine(&prof_made.lock));
	char *copy = prof_made.count < PROF_SITES_MADE_MAX ? strdup(name) : NULL;
	if (!copy)
		return &prof_site_more;
	stilb_prof_site *site = &prof_made.sites[prof_made.count++];
	*site = (stilb_prof_site){.name = copy, .function = "", .file = "", .color = rgb, .kind = STILB_PROF_KIND_ZONE};
	stilb_prof_site_list(site, 1);
	return site;
}

const stilb_prof_site *stilb_prof_site_make(const char *name, uint32_t rgb)
{
	assert(name && rgb <= 0xffffff);
	prof_mutex_lock(&prof_made.lock);
	const stilb_prof_site *site = prof_site_find(name, rgb);
	if (!site)
		site = prof_site_add(name, rgb);
	prof_mutex_unlock(&prof_made.lock);
	return site;
}
