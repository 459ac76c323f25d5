/*
 * prof_inline: the inline code that the macros of prof.h expand to, and its data. prof.h includes it; nothing here is
 * for use by name.
 */
#ifndef STILB_PROF_INLINE_H
#define STILB_PROF_INLINE_H

#ifndef STILB_PROF_H
#error "include prof.h"
#endif

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One event: begin is time << 12 | offset bits 6..11 | low (6 bits); end is payload << 18 | offset bits 12..29. time is
 * in ticks of the clock, its low 52 bits; offset is the distance in bytes of the site from the start of the section of
 * sites, signed. By the kind of the site:
 *   zones      time: the begin     low: the depth           payload: the duration in ticks
 *   counters   time: the moment    low, payload: bits 12..17 and 18..63 of the double
 *   instants   time: the moment    low: 0                   payload: 0
 *   flows      time: the moment    low: open zones          payload: the flow's id
 * Events stand in the order of the zones' ends and of the moments. */
typedef struct stilb_prof_event {
	uint64_t begin;
	uint64_t end;
} stilb_prof_event;

#define STILB_PROF_DEPTH_MAX 64
#define STILB_PROF_DURATION_MAX ((UINT64_C(1) << 46) - 1) /* ticks; almost four hours at 5 GHz, then it is cut */

/* A zone that has begun and not ended. */
typedef struct stilb_prof_open_zone {
	uint64_t begin;
	const stilb_prof_site *site;
} stilb_prof_open_zone;

/* The events and open zones of one thread. Written by that thread, read by snapshots. All accesses are atomic;
 * prof_ring.c explains the orders. */
typedef struct stilb_prof_ring {
	uint64_t head; /* events ever written; the next goes to events[head & mask] */
	stilb_prof_event *events;
	uint32_t mask;
	uint32_t tsc;                                    /* the clock is rdtsc */
	uint32_t depth;                                  /* open zones */
	uint32_t session;                                /* stilb_prof_session when the zones in open were begun */
	uint64_t too_deep;                               /* zones not recorded because they were nested too deep */
	uint32_t lane;                                   /* number of the ring; part of the ids of flows */
	uint32_t flows;                                  /* number of flows begun on this thread; part of their ids */
	stilb_prof_open_zone open[STILB_PROF_DEPTH_MAX]; /* outermost first */
} stilb_prof_ring;

#define STILB_PROF_SITE_INIT_(name, function, rgb, kind)                                                               \
	{                                                                                                                  \
		name, function, __FILE__, __LINE__, rgb, kind, 0, NULL,                                                        \
		{                                                                                                              \
			0, 0                                                                                                       \
		}                                                                                                              \
	}

/* In C, sites are constants in one section, which the linker lays out as an array. In C++, g++ refuses to put sites of
 * inline and of other functions into one section, so a site enters a list when it is first used, or before main if it
 * stands outside of functions. */
#ifdef __cplusplus
#define STILB_PROF_STATIC_ static
#define STILB_PROF_SECTION_
#define STILB_PROF_LIST_(variable, sites, count)                                                                       \
	;                                                                                                                  \
	static const bool variable##_is_listed __attribute__((unused)) = stilb_prof_site_list(sites, count)
#else
#define STILB_PROF_STATIC_ static const
#define STILB_PROF_SECTION_ __attribute__((section("stilb_prof_section")))
#define STILB_PROF_LIST_(variable, sites, count)
#endif

#define STILB_PROF_SITE_AT_(variable, name, function, rgb, kind)                                                       \
	STILB_PROF_STATIC_ stilb_prof_site variable STILB_PROF_SECTION_ =                                                  \
		STILB_PROF_SITE_INIT_(name, function, rgb, STILB_PROF_KIND_##kind)

#define STILB_PROF_SCOPE_AT_(n, name, rgb, kind, end)                                                                  \
	STILB_PROF_SITE_AT_(stilb_prof_site_##n, name, __func__, rgb, kind);                                               \
	uint32_t stilb_prof_scope_##n __attribute__((cleanup(end), unused)) =                                              \
		stilb_prof_scope_begin(stilb_prof_site_use(&stilb_prof_site_##n))
#define STILB_PROF_SCOPE_(n, name, rgb, kind, end) STILB_PROF_SCOPE_AT_(n, name, rgb, kind, end)

#define STILB_PROF_HERE_ (stilb_prof_site_use(&stilb_prof_site_here))
#define STILB_PROF_AT_(name, kind, call)                                                                               \
	do {                                                                                                               \
		STILB_PROF_SITE_AT_(stilb_prof_site_here, "" name, __func__, 0, kind);                                         \
		call;                                                                                                          \
	} while (0)

/* The bounds of the array of sites. The linker defines them, and their names. */
#ifdef STILB_PROF_SHARED
#define STILB_PROF_BOUND_ __attribute__((weak, visibility("hidden"))) /* NULL in an image without an array */
#else
#define STILB_PROF_BOUND_ __attribute__((visibility("hidden")))
#endif
extern const stilb_prof_site __start_stilb_prof_section[] /* NOLINT(clang-diagnostic-reserved-identifier) */
	STILB_PROF_BOUND_;
extern const stilb_prof_site __stop_stilb_prof_section[] /* NOLINT(clang-diagnostic-reserved-identifier) */
	STILB_PROF_BOUND_;

/* A program, or a shared object of it, that records in the profiler of another: of libstilb.so. */
typedef struct stilb_prof_image {
	const uint32_t *session;             /* stilb_prof_session of that profiler; NULL until the image has joined it */
	uintptr_t begin, size;               /* where the image lies in memory */
	uint64_t offset;                     /* what events hold for a site at begin */
	const stilb_prof_site *first, *stop; /* the image's array of sites; NULL: it has none */
} stilb_prof_image;

#ifdef STILB_PROF_SHARED

/* One for each image, of which all files that include this header have the same. */
__attribute__((weak, visibility("hidden")))
stilb_prof_image stilb_prof_this_image = {NULL, 0, 0, 0, __start_stilb_prof_section, __stop_stilb_prof_section};

/* Lets the image take part: fills the members in and returns its session. From then on the image stays in memory, also
 * after dlclose, because events refer to its sites. An image that does not fit (prof.h) never records. [any-thread] */
const uint32_t *stilb_prof_image_join(stilb_prof_image *image);

/* What events hold for a site of any image. [any-thread] */
uint64_t stilb_prof_site_offset_of(const stilb_prof_site *site);

#define stilb_prof_thread_ring stilb_prof_ring_shared
extern __thread stilb_prof_ring *stilb_prof_thread_ring __attribute__((tls_model("initial-exec")));

#else

/* 0 while recording is off; else the number of the session, which is the time from one switching-on of recording to the
 * next switching-off; each has another number. Zones that were begun in an earlier session are lost. */
extern uint32_t stilb_prof_session __attribute__((visibility("hidden")));

/* The calling thread's ring, never NULL: threads without one share a ring that belongs to no session, so it is never
 * written. */
extern __thread stilb_prof_ring *stilb_prof_thread_ring
	__attribute__((visibility("hidden"), tls_model("initial-exec")));

#endif

/* CLOCK_MONOTONIC in nanoseconds. [any-thread] */
uint64_t stilb_prof_clock_monotonic(void);

/* Adds sites that are not in the array to the list, each once. Returns true, so that it can be an initialiser.
 * [any-thread] */
bool stilb_prof_site_list(stilb_prof_site *sites, size_t count);

/* The slow path of stilb_prof_recorder: makes the calling thread's ring if it has none, and forgets open zones of an
 * earlier session. session is not 0 (asserted). NULL: no memory for a ring, and the event is counted as lost.
 * [any-thread] */
stilb_prof_ring *stilb_prof_ring_enter(uint32_t session);

#ifdef __cplusplus
static inline const stilb_prof_site *stilb_prof_site_use(stilb_prof_site *site)
{
	/* Relaxed: an old 0 only costs a call, since stilb_prof_site_list decides by an exchange who adds the site. */
	if (__builtin_expect(__atomic_load_n(&site->listed, __ATOMIC_RELAXED) == 0, 0))
		stilb_prof_site_list(site, 1);
	return site;
}
#else
static inline const stilb_prof_site *stilb_prof_site_use(const stilb_prof_site *site)
{
	return site;
}
#endif

/* Reads the clock between two compiler barriers, so that the compiler moves no memory access of a zone out of it. */
static inline uint64_t stilb_prof_clock(const stilb_prof_ring *ring)
{
	uint64_t now;
	__asm__ volatile("" ::: "memory");
#if defined(__x86_64__)
	now = __builtin_expect(ring->tsc != 0, 1) ? __builtin_ia32_rdtsc() : stilb_prof_clock_monotonic();
#else
	(void)ring;
	now = stilb_prof_clock_monotonic();
#endif
	__asm__ volatile("" ::: "memory");
	return now;
}

/* Reads the clock after all earlier instructions have finished: rdtscp waits for them. */
static inline uint64_t stilb_prof_clock_precise(const stilb_prof_ring *ring)
{
#if defined(__x86_64__)
	if (__builtin_expect(ring->tsc != 0, 1)) {
		uint32_t cpu;
		__asm__ volatile("" ::: "memory");
		uint64_t now = __builtin_ia32_rdtscp(&cpu);
		__asm__ volatile("" ::: "memory");
		return now;
	}
#endif
	return stilb_prof_clock(ring);
}

/* The value of stilb_prof_session. Relaxed: no data depends on it. */
static inline uint32_t stilb_prof_session_now(void)
{
#ifdef STILB_PROF_SHARED
	/* Acquire: pairs with the release in stilb_prof_image_join. */
	const uint32_t *session = __atomic_load_n(&stilb_prof_this_image.session, __ATOMIC_ACQUIRE);
	if (__builtin_expect(!session, 0))
		session = stilb_prof_image_join(&stilb_prof_this_image);
	return __atomic_load_n(session, __ATOMIC_RELAXED);
#else
	return __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED);
#endif
}

/* What events hold for a site: its distance from the array of sites; from that of libstilb.so as if all images that
 * record there lay behind one another. */
static inline uint64_t stilb_prof_site_offset(const stilb_prof_site *site)
{
#ifdef STILB_PROF_SHARED
	uintptr_t inside = (uintptr_t)site - stilb_prof_this_image.begin;
	if (__builtin_expect(inside >= stilb_prof_this_image.size, 0)) /* of another image: stilb_prof_site_make */
		return stilb_prof_site_offset_of(site);
	return stilb_prof_this_image.offset + inside;
#else
	return (uint64_t)((uintptr_t)site - (uintptr_t)__start_stilb_prof_section);
#endif
}

static inline bool stilb_prof_is_recording(void)
{
	/* The compiler is told to expect "off": see stilb_prof_recorder. */
	return __builtin_expect(stilb_prof_session_now() != 0, 0);
}

/* The ring to record to, in the current session; NULL: nothing is to be recorded. The compiler is told to expect NULL,
 * so that the code falls through while recording is off; while it is on, the taken branch costs nothing beside the
 * clock. */
static inline stilb_prof_ring *stilb_prof_recorder(void)
{
	uint32_t session = stilb_prof_session_now();
	if (__builtin_expect(session == 0, 1))
		return NULL;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	return __builtin_expect(ring->session == session, 1) ? ring : stilb_prof_ring_enter(session);
}

/* The ring whose innermost zone is to end; NULL: no zone is open. */
static inline stilb_prof_ring *stilb_prof_ender(void)
{
	uint32_t session = stilb_prof_session_now();
	if (__builtin_expect(session == 0, 1))
		return NULL;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	return __builtin_expect(ring->session == session && ring->depth > 0, 1) ? ring : NULL;
}

/* Writes one event of the site that has this offset. Release stores: they pair with the acquire loads of
 * prof_event_load and prof_copy_events. */
static inline void stilb_prof_write_at(stilb_prof_ring *ring, uint64_t offset, uint64_t time, uint64_t low,
                                       uint64_t payload)
{
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED);
	assert((uint64_t)((int64_t)(offset << 34) >> 34) == offset && "sites lie in the program, not in allocated memory");
	assert(low < 64 && payload >> 46 == 0);
	stilb_prof_event *event = &ring->events[head & ring->mask];
	__atomic_store_n(&event->begin, time << 12 | (offset & 0xfc0) | low, __ATOMIC_RELEASE);
	__atomic_store_n(&event->end, payload << 18 | (offset >> 12 & 0x3ffff), __ATOMIC_RELEASE);
	__atomic_store_n(&ring->head, head + 1, __ATOMIC_RELEASE);
}

static inline void stilb_prof_write(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t time, uint64_t low,
                                    uint64_t payload)
{
	stilb_prof_write_at(ring, stilb_prof_site_offset(site), time, low, payload);
}

/* Opens a zone at depth. Release stores: they pair with prof_copy_open_zone. */
static inline void stilb_prof_open(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t begin, uint32_t depth)
{
	assert(depth < STILB_PROF_DEPTH_MAX && site && site->kind <= STILB_PROF_KIND_PRECISE && "a site of zones");
	__atomic_store_n(&ring->open[depth].begin, begin, __ATOMIC_RELEASE);
	__atomic_store_n(&ring->open[depth].site, site, __ATOMIC_RELEASE);
	__atomic_store_n(&ring->depth, depth + 1, __ATOMIC_RELEASE);
}

/* Closes the zone at depth and all zones inside it, and writes the event of the zone at depth. */
static inline void stilb_prof_close(stilb_prof_ring *ring, uint32_t depth, uint64_t end)
{
	assert(depth < ring->depth && "the zone is open");
	const stilb_prof_open_zone *zone = &ring->open[depth];
	uint64_t begin = __atomic_load_n(&zone->begin, __ATOMIC_RELAXED); /* the thread's own */
	const stilb_prof_site *site = __atomic_load_n(&zone->site, __ATOMIC_RELAXED);
	uint64_t duration = end - begin;
	if (__builtin_expect(duration > STILB_PROF_DURATION_MAX, 0))
		duration = (int64_t)duration < 0 ? 0 : STILB_PROF_DURATION_MAX; /* the clock stepped back, or it is too long */
	__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE);
	stilb_prof_write(ring, site, begin, depth, duration);
}

/* Begins a zone and returns the number of open zones, this one included. A zone nested too deep is only counted. */
static inline uint32_t stilb_prof_push(stilb_prof_ring *ring, const stilb_prof_site *site)
{
	uint32_t depth = __atomic_load_n(&ring->depth, __ATOMIC_RELAXED); /* the thread's own */
	if (__builtin_expect(depth < STILB_PROF_DEPTH_MAX, 1)) {
		stilb_prof_open(ring, site, stilb_prof_clock(ring), depth);
	} else {
		__atomic_store_n(&ring->too_deep, ring->too_deep + 1, __ATOMIC_RELAXED); /* a number: no data depends on it */
		__atomic_store_n(&ring->depth, depth + 1, __ATOMIC_RELEASE);
	}
	return depth + 1;
}

/* Ends the zone at depth; one that was nested too deep to be recorded is only counted out. */
static inline void stilb_prof_pop(stilb_prof_ring *ring, uint32_t depth, uint64_t end)
{
	if (__builtin_expect(depth < STILB_PROF_DEPTH_MAX, 1))
		stilb_prof_close(ring, depth, end);
	else
		__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE); /* pairs with prof_copy_open_zone */
}

/* The beginning of PROFILE. Returns the number of open zones, this one included; 0: recording is off, or there is no
 * memory for a ring. */
static inline uint32_t stilb_prof_scope_begin(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_recorder();
	return ring ? stilb_prof_push(ring, site) : 0;
}

/* The end of PROFILE. The ring is looked up again and may no longer hold the zone: inside the scope the thread may have
 * given up its ring or got another one. */
static inline void stilb_prof_scope_end(const uint32_t *scope)
{
	if (__builtin_expect(*scope == 0, 1))
		return;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	uint64_t end = stilb_prof_clock(ring);
	if (__builtin_expect(__atomic_load_n(&ring->depth, __ATOMIC_RELAXED) >= *scope, 1))
		stilb_prof_pop(ring, *scope - 1, end);
}

static inline void stilb_prof_scope_end_precise(const uint32_t *scope)
{
	if (__builtin_expect(*scope == 0, 1))
		return;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	uint64_t end = stilb_prof_clock_precise(ring);
	if (__builtin_expect(__atomic_load_n(&ring->depth, __ATOMIC_RELAXED) >= *scope, 1))
		stilb_prof_pop(ring, *scope - 1, end);
}

static inline void stilb_prof_zone_begin(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_recorder();
	if (ring)
		stilb_prof_push(ring, site);
}

static inline void stilb_prof_zone_end(void)
{
	stilb_prof_ring *ring = stilb_prof_ender();
	if (ring)
		stilb_prof_pop(ring, ring->depth - 1, stilb_prof_clock(ring));
}

static inline void stilb_prof_zone_next(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_ender();
	if (!ring)
		return;
	uint32_t depth = ring->depth - 1;
	if (__builtin_expect(depth < STILB_PROF_DEPTH_MAX, 1)) {
		uint64_t now = stilb_prof_clock(ring);
		stilb_prof_close(ring, depth, now);
		stilb_prof_open(ring, site, now, depth);
	} else {
		__atomic_store_n(&ring->too_deep, ring->too_deep + 1, __ATOMIC_RELAXED); /* a number: no data depends on it */
	}
}

static inline void stilb_prof_counter(const stilb_prof_site *site, double value)
{
	stilb_prof_ring *ring = stilb_prof_recorder();
	if (!ring)
		return;
	assert(site && site->kind == STILB_PROF_KIND_COUNTER);
	uint64_t bits;
	__builtin_memcpy(&bits, &value, sizeof bits);
	if (__builtin_expect((bits >> 52 & 0x7ff) != 0x7ff, 1)) /* infinity and NaN are not rounded */
		bits += UINT64_C(1) << 11;
	stilb_prof_write(ring, site, stilb_prof_clock(ring), bits >> 12 & 0x3f, bits >> 18);
}

static inline void stilb_prof_instant(const stilb_prof_site *site)
{
	assert(site && site->kind == STILB_PROF_KIND_INSTANT);
	stilb_prof_ring *ring = stilb_prof_recorder();
	if (ring)
		stilb_prof_write(ring, site, stilb_prof_clock(ring), 0, 0);
}

#ifdef __cplusplus
}
#endif
#endif
