/*
 * Threads and their rings, frames, and the copy that a trace is made from.
 *
 * Ring protocol (one writer, any readers). The writer stores an event's two words, then head. The reader loads head,
 * the words, then head again; of the events before the first head it keeps those that the writer cannot have begun to
 * overwrite: numbers above (second head - size). All stores are release and all loads of the reader acquire: a reader
 * that sees a word of event n therefore also sees head >= n, because n's words are stored after head = n. On x86 that
 * is plain moves. The frames follow the same protocol.
 *
 * Open zones. A zone is pushed as begin, site, depth and popped as depth, event, head. So as long as head stays the same
 * no entry below depth can be written: a reader that finds the same head before and after has a whole entry.
 */
#include "profiler/prof_internal.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define PROF_RING_EVENTS 65536
#define PROF_RING_EVENTS_MIN 64
#define PROF_RING_EVENTS_MAX (1u << 24)
#define PROF_OPEN_TRIES 64

/* One mapping: this, padded to PROF_HEADER_SIZE, then the events. */
typedef struct prof_thread {
	stilb_prof_ring ring; /* first: stilb_prof_thread_ring points to it */
	char name[PROF_NAME_MAX];
	uint64_t ended; /* 0: alive; else the time order in which threads ended */
	size_t mapping;
} prof_thread;

#define PROF_HEADER_SIZE 4096
static_assert(sizeof(prof_thread) <= PROF_HEADER_SIZE, "header");
static_assert(offsetof(prof_thread, ring) == 0, "the ring comes first");

__thread stilb_prof_ring *stilb_prof_thread_ring;

/* The lock guards everything but what zones and frame marks write. */
static struct {
	pthread_mutex_t lock;
	prof_thread **threads; /* in the order of their lanes in a trace */
	uint32_t count, capacity;
	uint32_t ring_events;
	uint64_t ended;     /* threads that have ended so far */
	uint64_t discarded; /* events in rings that another thread took over */
} prof = {.lock = PTHREAD_MUTEX_INITIALIZER, .ring_events = PROF_RING_EVENTS};

static struct {
	uint64_t count; /* frames begun; number n is at begin[n % PROF_FRAMES_MAX] */
	uint64_t begin[PROF_FRAMES_MAX];
} prof_frames;

/* Every image has at least this site, so the linker always makes the array's bounds. */
static const stilb_prof_site prof_site_first STILB_PROF_SECTION_ __attribute__((used)) =
	STILB_PROF_SITE_INIT_("stilb-profiler", "", 0);

/* ---- threads --------------------------------------------------------------------------------------------------- */

static prof_thread *prof_thread_map(uint32_t events)
{
	const size_t size = PROF_HEADER_SIZE + (size_t)events * sizeof(stilb_prof_event);
	/* Populated now, so that the first lap takes no page faults. */
	void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
	if (memory == MAP_FAILED)
		return NULL;
	prof_thread *thread = memory;
	thread->ring.events = (stilb_prof_event *)((char *)memory + PROF_HEADER_SIZE);
	thread->ring.mask = events - 1;
	thread->ring.tsc = prof_clock_is_tsc();
	thread->mapping = size;
	return thread;
}

/* A new ring at the end of the list, or NULL. */
static prof_thread *prof_thread_add(void)
{
	if (prof.count == prof.capacity) {
		const uint32_t capacity = prof.capacity > 0 ? 2 * prof.capacity : 16;
		prof_thread **threads = realloc(prof.threads, capacity * sizeof *threads);
		if (threads == NULL)
			return NULL;
		prof.threads = threads;
		prof.capacity = capacity;
	}
	prof_thread *thread = prof_thread_map(prof.ring_events);
	if (thread != NULL)
		prof.threads[prof.count++] = thread;
	return thread;
}

/* An ended thread's ring: the one of that name that ended last, or, when too many are kept, the one that ended first. */
static prof_thread *prof_thread_reuse(const char *name)
{
	prof_thread *same = NULL, *oldest = NULL;
	uint32_t ended = 0;
	for (uint32_t i = 0; i < prof.count; i++) {
		prof_thread *thread = prof.threads[i];
		if (thread->ended == 0)
			continue;
		ended++;
		if (strcmp(thread->name, name) == 0 && (same == NULL || thread->ended > same->ended))
			same = thread;
		if (oldest == NULL || thread->ended < oldest->ended)
			oldest = thread;
	}
	if (same != NULL || ended < PROF_ENDED_MAX)
		return same;
	prof.discarded += oldest->ring.head;
	oldest->ring.head = 0; /* the lock orders it: nobody else looks at the ring of an ended thread */
	return oldest;
}

int stilb_prof_thread_begin(const char *name)
{
	char short_name[PROF_NAME_MAX] = "thread";
	if (stilb_prof_thread_ring != NULL)
		return -EALREADY;
	if (name != NULL) {
		const size_t length = strnlen(name, PROF_NAME_MAX - 1);
		memcpy(short_name, name, length);
		short_name[length] = 0;
	}
	pthread_mutex_lock(&prof.lock);
	prof_thread *thread = prof_thread_reuse(short_name);
	if (thread == NULL)
		thread = prof_thread_add();
	if (thread != NULL) {
		memcpy(thread->name, short_name, PROF_NAME_MAX);
		thread->ended = 0;
	}
	pthread_mutex_unlock(&prof.lock);
	if (thread == NULL)
		return -ENOMEM;
	stilb_prof_thread_ring = &thread->ring;
	return 0;
}

void stilb_prof_thread_end(void)
{
	prof_thread *thread = (prof_thread *)stilb_prof_thread_ring;
	if (thread == NULL)
		return;
	stilb_prof_thread_ring = NULL;
	pthread_mutex_lock(&prof.lock);
	thread->ring.depth = 0;
	thread->ended = ++prof.ended;
	pthread_mutex_unlock(&prof.lock);
}

int stilb_prof_ring_events_set(uint32_t events)
{
	if (events < PROF_RING_EVENTS_MIN || events > PROF_RING_EVENTS_MAX || (events & (events - 1)) != 0)
		return -EINVAL;
	pthread_mutex_lock(&prof.lock);
	prof.ring_events = events;
	pthread_mutex_unlock(&prof.lock);
	return 0;
}

uint32_t prof_ring_count(uint32_t *ended)
{
	pthread_mutex_lock(&prof.lock);
	const uint32_t count = prof.count;
	*ended = 0;
	for (uint32_t i = 0; i < count; i++)
		*ended += prof.threads[i]->ended != 0;
	pthread_mutex_unlock(&prof.lock);
	return count;
}

void stilb_prof_shutdown(void)
{
	stilb_prof_thread_end();
	pthread_mutex_lock(&prof.lock);
	for (uint32_t i = 0; i < prof.count; i++)
		munmap(prof.threads[i], prof.threads[i]->mapping);
	free(prof.threads);
	prof.threads = NULL;
	prof.count = prof.capacity = 0;
	prof.ended = prof.discarded = 0;
	prof.ring_events = PROF_RING_EVENTS;
	__atomic_store_n(&prof_frames.count, 0, __ATOMIC_RELAXED); /* no partner: nobody else is in a call */
	pthread_mutex_unlock(&prof.lock);
}

/* ---- zones and frames ------------------------------------------------------------------------------------------- */

const stilb_prof_site *stilb_prof_sites(size_t *count)
{
	*count = ((uintptr_t)__stop_stilb_prof_section - (uintptr_t)__start_stilb_prof_section) / sizeof(stilb_prof_site);
	return __start_stilb_prof_section;
}

void stilb_prof_zone_begin(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	if (ring != NULL)
		stilb_prof_open(ring, site, stilb_prof_clock(ring), ring->depth);
}

void stilb_prof_zone_end(void)
{
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	if (ring == NULL || ring->depth == 0)
		return;
	const uint32_t depth = ring->depth - 1;
	if (depth < STILB_PROF_DEPTH_MAX)
		stilb_prof_close(ring, ring->open[depth].site, ring->open[depth].begin, stilb_prof_clock(ring), depth);
	else
		__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE); /* pairs with prof_copy_open_zone */
}

void stilb_prof_frame_mark(void)
{
	/* Release, as for events: pairs with the loads of prof_copy_frames. */
	const uint64_t count = __atomic_load_n(&prof_frames.count, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_frames.begin[count % PROF_FRAMES_MAX], prof_clock_now(), __ATOMIC_RELEASE);
	__atomic_store_n(&prof_frames.count, count + 1, __ATOMIC_RELEASE);
}

/* ---- copies ---------------------------------------------------------------------------------------------------- */

/* Copies the events [first, head) of a ring into events and returns how many of the first ones are void, because the
 * thread has overwritten them meanwhile or may be about to. */
static uint64_t prof_copy_events(const stilb_prof_ring *ring, uint64_t first, uint64_t head, stilb_prof_event *events)
{
	const uint64_t size = (uint64_t)ring->mask + 1;
	for (uint64_t i = first; i < head; i++) {
		/* Acquire: pair with the stores of stilb_prof_close. */
		const stilb_prof_event *event = &ring->events[i & ring->mask];
		events[i - first].begin = __atomic_load_n(&event->begin, __ATOMIC_ACQUIRE);
		events[i - first].end = __atomic_load_n(&event->end, __ATOMIC_ACQUIRE);
	}
	const uint64_t now = __atomic_load_n(&ring->head, __ATOMIC_RELAXED); /* ordered by the acquire loads before it */
	const uint64_t valid = now >= size ? now - size + 1 : 0;
	return valid <= first ? 0 : valid < head ? valid - first : head - first;
}

/* One entry of the stack of open zones, whole; false when there is none at this depth or the thread is too busy. */
static bool prof_copy_open_zone(const stilb_prof_ring *ring, uint32_t depth, prof_zone *zone)
{
	for (int i = 0; i < PROF_OPEN_TRIES; i++) {
		/* Acquire: pair with the stores of stilb_prof_open and stilb_prof_close; the second head is ordered by them. */
		const uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE);
		if (__atomic_load_n(&ring->depth, __ATOMIC_ACQUIRE) <= depth)
			return false;
		zone->begin = __atomic_load_n(&ring->open[depth].begin, __ATOMIC_ACQUIRE);
		zone->site = __atomic_load_n(&ring->open[depth].site, __ATOMIC_ACQUIRE);
		if (__atomic_load_n(&ring->head, __ATOMIC_RELAXED) == head)
			return true;
	}
	return false;
}

/* The open zones of a ring, deepest first, into zones; returns their number. The stack moves while it is read from the
 * deep end, so an entry found later may be younger than one found before it: then the deeper ones are gone by now. */
uint32_t prof_copy_open(const stilb_prof_ring *ring, prof_zone *zones)
{
	uint32_t depth = __atomic_load_n(&ring->depth, __ATOMIC_ACQUIRE); /* pairs with stilb_prof_open */
	uint32_t count = 0;
	for (depth = depth < STILB_PROF_DEPTH_MAX ? depth : STILB_PROF_DEPTH_MAX; depth-- > 0;) {
		prof_zone zone = {.depth = depth, .open = true};
		const bool whole = prof_copy_open_zone(ring, depth, &zone);
		if (!whole || (count > 0 && zone.begin > zones[count - 1].begin))
			count = 0;
		if (whole)
			zones[count++] = zone;
	}
	return count;
}

/* Takes an event apart. It holds the low 52 bits of the begin: that is the latest such time up to limit, which is right
 * for ten days (5 GHz). */
static prof_zone prof_zone_unpack(stilb_prof_event event, uint64_t limit)
{
	const uint64_t offset = (event.end & 0x3ffff) << 12 | (event.begin & 0xfc0);
	const int64_t distance = (int64_t)(offset << 34) >> 34; /* 30 bits, signed */
	const uint64_t begin = limit - ((limit - (event.begin >> 12)) & ((UINT64_C(1) << 52) - 1));
	return (prof_zone){
		.begin = begin,
		.end = begin + (event.end >> 18),
		.site = (const stilb_prof_site *)((uintptr_t)__start_stilb_prof_section + (uintptr_t)distance),
		.depth = (uint32_t)(event.begin & 0x3f),
	};
}

static int prof_copy_thread(const prof_thread *thread, prof_copy *copy, prof_thread_copy *out)
{
	const stilb_prof_ring *ring = &thread->ring;
	const uint64_t size = (uint64_t)ring->mask + 1;
	const uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE); /* pairs with stilb_prof_close */
	const uint64_t first = head > size ? head - size : 0;
	stilb_prof_event *events = malloc((size_t)(head - first + 1) * sizeof *events);
	out->zones = malloc((size_t)(head - first + STILB_PROF_DEPTH_MAX) * sizeof *out->zones);
	if (events == NULL || out->zones == NULL) {
		free(events);
		return -ENOMEM;
	}
	prof_zone open[STILB_PROF_DEPTH_MAX];
	const uint64_t skip = prof_copy_events(ring, first, head, events);
	const uint32_t open_count = prof_copy_open(ring, open);
	const uint64_t now = prof_clock_now();

	memcpy(out->name, thread->name, PROF_NAME_MAX);
	for (uint64_t i = skip; i < head - first; i++) /* 2^32 ticks: clocks of two CPUs may differ a little */
		out->zones[out->count++] = prof_zone_unpack(events[i], now + (UINT64_C(1) << 32));
	free(events);
	copy->events_recorded += head;
	copy->events_held += out->count;
	for (uint32_t i = 0; i < open_count; i++) {
		open[i].end = now > open[i].begin ? now : open[i].begin;
		out->zones[out->count++] = open[i];
	}
	return 0;
}

static void prof_copy_frames(prof_copy *copy)
{
	/* Acquire: pair with stilb_prof_frame_mark; the second count is ordered by the loads before it. */
	const uint64_t count = __atomic_load_n(&prof_frames.count, __ATOMIC_ACQUIRE);
	uint64_t first = count > PROF_FRAMES_MAX ? count - PROF_FRAMES_MAX : 0;
	for (uint64_t i = first; i < count; i++)
		copy->frame_begin[i - first] = __atomic_load_n(&prof_frames.begin[i % PROF_FRAMES_MAX], __ATOMIC_ACQUIRE);
	const uint64_t now = __atomic_load_n(&prof_frames.count, __ATOMIC_RELAXED);
	const uint64_t valid = now >= PROF_FRAMES_MAX ? now - PROF_FRAMES_MAX + 1 : 0;
	const uint64_t skip = valid <= first ? 0 : valid < count ? valid - first : count - first;
	copy->first_frame = first + skip;
	copy->frame_count = (uint32_t)(count - first - skip);
	memmove(copy->frame_begin, copy->frame_begin + skip, copy->frame_count * sizeof copy->frame_begin[0]);
}

int prof_copy_take(prof_copy *copy)
{
	int error = 0;
	*copy = (prof_copy){0};
	pthread_mutex_lock(&prof.lock);
	copy->threads = calloc((size_t)prof.count + 1, sizeof *copy->threads);
	if (copy->threads == NULL)
		error = -ENOMEM;
	copy->events_recorded = prof.discarded;
	while (error == 0 && copy->thread_count < prof.count) {
		const uint32_t i = copy->thread_count++;
		error = prof_copy_thread(prof.threads[i], copy, &copy->threads[i]);
	}
	prof_copy_frames(copy);
	pthread_mutex_unlock(&prof.lock);
	return error;
}

void prof_copy_free(prof_copy *copy)
{
	for (uint32_t i = 0; i < copy->thread_count; i++)
		free(copy->threads[i].zones);
	free(copy->threads);
	*copy = (prof_copy){0};
}
