/*
 * profiler: what every thread did in the last frames, always on. A stand-alone library: C17 and Linux, no other part
 * of Stilb. This header also compiles as C++17.
 *
 * What it is.   PROFILE("name") times the rest of its scope. A thread that called stilb_prof_thread_begin owns a ring
 *               of 16-byte events and writes one event at the end of each zone; the oldest are overwritten, so memory is
 *               fixed, nothing blocks and nothing needs to be switched on. stilb_prof_trace_write turns what is still
 *               held into a Chrome trace, while all threads go on recording.
 * Life cycle.   stilb_prof_thread_begin on each thread -> zones -> stilb_prof_thread_end on each thread;
 *               stilb_prof_trace_write at any time; stilb_prof_shutdown last.
 * Per frame.    stilb_prof_frame_mark, once, by one thread.
 * Threads.      [any-thread] may be called anywhere, at any time. [one-writer] has one thread as its caller.
 *               Zones write only what belongs to the calling thread: no lock, no allocation, no system call.
 *               Not for signal handlers: a handler's zone could fall into the middle of the same thread's.
 * Errors.       0 or a negative errno. Nothing here prints.
 * Clock.        rdtsc where the CPU says that it is invariant, else CLOCK_MONOTONIC. rdtsc is not serialising: the CPU
 *               may read it before the last instructions of a zone retire, so a zone reads some 20 ns short.
 * Off.          With STILB_PROFILE_OFF defined (CMake: STILB_PROFILE=OFF) every macro here expands to nothing; the
 *               functions stay and link, and a trace has its frames and no zones.
 *
 * The library is static and keeps its state once per linked program or shared object; zones of one image are recorded
 * by the copy that is linked into it.
 */
#ifndef STILB_PROF_H
#define STILB_PROF_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- zones ---------------------------------------------------------------------------------------------------- */

/* One place in the source. Make them with the macros below; the strings must live as long as the program. */
typedef struct stilb_prof_site {
	const char *name;     /* what the viewer shows; UTF-8 */
	const char *function; /* "" when made by STILB_PROF_SITE */
	const char *file;
	uint32_t line;
	uint32_t color;       /* 0xRRGGBB; 0: the viewer chooses */
	uint64_t reserved[4]; /* 0 */
} __attribute__((aligned(64))) stilb_prof_site;

/* The linker lays all sites of an image out as one array: no gaps allowed. */
static_assert(sizeof(stilb_prof_site) == 64, "sites form an array");

#ifndef STILB_PROFILE_OFF

/* A zone from here to the end of the enclosing scope; several in one scope nest in the order written. The name is a
 * string literal. Left by return, break, goto or a C++ exception alike. [any-thread] */
#define PROFILE(name) STILB_PROF_SCOPE_(__COUNTER__, "" name, 0)

/* The same with a colour, 0xRRGGBB. [any-thread] */
#define PROFILE_COLOR(name, rgb) STILB_PROF_SCOPE_(__COUNTER__, "" name, rgb)

/* The same, named after the enclosing function. [any-thread] */
#define PROFILE_FUNCTION() STILB_PROF_SCOPE_(__COUNTER__, __func__, 0)

/* Defines a static site for stilb_prof_zone_begin, at file scope or in a function. */
#define STILB_PROF_SITE(variable, name, rgb)                                                                           \
	static const stilb_prof_site variable STILB_PROF_SECTION_ = STILB_PROF_SITE_INIT_("" name, "", rgb)

/* A zone whose two ends lie in different functions (hooks). stilb_prof_zone_end ends the zone that this thread began
 * last; without one it does nothing. Zones nested more than 64 deep are not recorded. [any-thread] */
void stilb_prof_zone_begin(const stilb_prof_site *site);
void stilb_prof_zone_end(void);

#else
#define PROFILE(name)
#define PROFILE_COLOR(name, rgb)
#define PROFILE_FUNCTION()
#define STILB_PROF_SITE(variable, name, rgb) extern const stilb_prof_site variable
#define stilb_prof_zone_begin(site) ((void)0)
#define stilb_prof_zone_end() ((void)0)
#endif

/* All sites of this image, whether they have run or not; *count of them. g++ cannot place the sites of C++ code in the
 * array (it refuses one section for inline and other functions): those are recorded, but not listed. [any-thread] */
const stilb_prof_site *stilb_prof_sites(size_t *count);

/* ---- threads and frames --------------------------------------------------------------------------------------- */

/* Gives the calling thread a ring: a ring left by an ended thread of that name, with what it holds, or a new one. Until
 * then its zones are not recorded. name is copied, 63 bytes at most; NULL counts as "thread".
 * -EALREADY: it has one; -ENOMEM: no memory, and its zones stay unrecorded. [any-thread] */
int stilb_prof_thread_begin(const char *name);

/* Takes the ring away again; what it holds stays for later traces. Must be called before the thread exits. Without a
 * ring it does nothing. At most 64 rings of ended threads are kept, then the next thread of another name takes over the
 * one that ended first, so memory does not grow with the number of threads that come and go. [any-thread] */
void stilb_prof_thread_end(void);

/* Events in rings made from now on: a power of two, 64..2^24; 65,536 (1 MiB) unless set. -EINVAL otherwise. [any-thread] */
int stilb_prof_ring_events_set(uint32_t events);

/* Begins a new frame and so ends the one before. The last 1,024 are remembered. [one-writer] */
void stilb_prof_frame_mark(void);

/* ---- traces --------------------------------------------------------------------------------------------------- */

typedef struct stilb_prof_trace_desc {
	uint32_t last_frames;     /* whole frames to go back; 0, or more than are remembered: all that is still held */
	const char *process_name; /* NULL: the program's */
} stilb_prof_trace_desc;

/* Writes what is held as Chrome trace JSON (Google's "Trace Event Format") through write(user, data, size), which
 * returns 0, or anything else to stop. desc may be NULL for {0}. In the trace:
 *  - one thread a ring, in the order they were made, and "frames", with one slice for each whole frame and one mark where
 *    each began;
 *  - zones as X events, parents before children, times in microseconds with three decimals (nanoseconds) since the
 *    profiler's first call; a zone that touches the next one or its parent's end is written 1 ns shorter, because viewers
 *    that add ts and dur as doubles lose it otherwise; zones that are still open as B events without an E;
 *  - otherData: clock, hz, resolution_ns, and the accounts: events_recorded = events_lost (overwritten) + events_held;
 *    events_written is less than held when last_frames leaves some out.
 * Takes a copy first and then writes from it, so threads that record are not held up; threads that begin or end wait for
 * the copy. A first trace within 10 ms of the profiler's first call waits that time out to calibrate the clock.
 * Returns 0, what write returned, or -ENOMEM. [any-thread] */
int stilb_prof_trace_write(const stilb_prof_trace_desc *desc, int (*write)(void *user, const void *data, size_t size),
                           void *user);

/* Frees all rings and forgets the frames. The calling thread's ring is ended; no other thread may have one or be in any
 * call. Recording may begin anew afterwards. [one-writer] */
void stilb_prof_shutdown(void);

/* ---- what the macros expand to: not for use by name ------------------------------------------------------------ */

/* begin: begin << 12 | offset bits 6..11 | depth (6 bits); end: duration << 18 | offset bits 12..29. Times are in ticks
 * of the clock; the offset is that of the site from the start of the section. */
typedef struct stilb_prof_event {
	uint64_t begin;
	uint64_t end;
} stilb_prof_event;

#define STILB_PROF_DEPTH_MAX 64
#define STILB_PROF_DURATION_MAX ((UINT64_C(1) << 46) - 1) /* ticks; almost four hours at 5 GHz, then it is cut */

/* Written by its thread, read by stilb_prof_trace_write: all accesses are atomic, orders as said in prof_ring.c. */
typedef struct stilb_prof_ring {
	uint64_t head; /* events ever written; the next goes to events[head & mask] */
	stilb_prof_event *events;
	uint32_t mask;
	uint32_t tsc;   /* the clock is rdtsc */
	uint32_t depth; /* open zones */
	uint32_t reserved;
	struct {
		uint64_t begin;
		const stilb_prof_site *site;
	} open[STILB_PROF_DEPTH_MAX]; /* the open zones, outermost first */
} stilb_prof_ring;

typedef struct stilb_prof_scope {
	const stilb_prof_site *site;
	uint64_t begin; /* 0: not recorded */
	uint32_t depth;
} stilb_prof_scope;

#define STILB_PROF_SITE_INIT_(name, function, rgb)                                                                     \
	{                                                                                                                  \
		name, function, __FILE__, __LINE__, rgb,                                                                       \
		{                                                                                                              \
			0, 0, 0, 0                                                                                                 \
		}                                                                                                              \
	}

#if defined(__cplusplus) && !defined(__clang__)
#define STILB_PROF_SECTION_
#else
#define STILB_PROF_SECTION_ __attribute__((section("stilb_prof_section")))
#endif

#define STILB_PROF_SCOPE_AT_(n, name, rgb)                                                                             \
	static const stilb_prof_site stilb_prof_site_##n STILB_PROF_SECTION_ = STILB_PROF_SITE_INIT_(name, __func__, rgb); \
	stilb_prof_scope stilb_prof_scope_##n __attribute__((cleanup(stilb_prof_scope_end), unused)) =                     \
		stilb_prof_scope_begin(&stilb_prof_site_##n)
#define STILB_PROF_SCOPE_(n, name, rgb) STILB_PROF_SCOPE_AT_(n, name, rgb)

/* The linker makes these two, the array's bounds. */
extern const stilb_prof_site __start_stilb_prof_section[] __attribute__((visibility("hidden")));
extern const stilb_prof_site __stop_stilb_prof_section[] __attribute__((visibility("hidden")));

/* NULL: this thread does not record. */
extern __thread stilb_prof_ring *stilb_prof_thread_ring
	__attribute__((visibility("hidden"), tls_model("initial-exec")));

/* CLOCK_MONOTONIC in nanoseconds. */
uint64_t stilb_prof_clock_monotonic(void);

/* Between two compiler barriers: memory accesses of a zone stay inside it. */
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

/* Opens a zone at depth. */
static inline void stilb_prof_open(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t begin, uint32_t depth)
{
	if (__builtin_expect(depth < STILB_PROF_DEPTH_MAX, 1)) {
		__atomic_store_n(&ring->open[depth].begin, begin, __ATOMIC_RELEASE);
		__atomic_store_n(&ring->open[depth].site, site, __ATOMIC_RELEASE);
	}
	__atomic_store_n(&ring->depth, depth + 1, __ATOMIC_RELEASE);
}

/* Closes the zone at depth, which lasted from begin to end, and writes its event. */
static inline void stilb_prof_close(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t begin, uint64_t end,
                                    uint32_t depth)
{
	const uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED);
	const uint64_t offset = (uint64_t)((uintptr_t)site - (uintptr_t)__start_stilb_prof_section);
	const uint64_t level = depth < STILB_PROF_DEPTH_MAX ? depth : STILB_PROF_DEPTH_MAX - 1;
	stilb_prof_event *event = &ring->events[head & ring->mask];
	uint64_t duration = end - begin;

	if (__builtin_expect(duration > STILB_PROF_DURATION_MAX, 0))
		duration = (int64_t)duration < 0 ? 0 : STILB_PROF_DURATION_MAX; /* the clock stepped back, or hours went by */
	__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE);
	__atomic_store_n(&event->begin, begin << 12 | (offset & 0xfc0) | level, __ATOMIC_RELEASE);
	__atomic_store_n(&event->end, duration << 18 | (offset >> 12 & 0x3ffff), __ATOMIC_RELEASE);
	__atomic_store_n(&ring->head, head + 1, __ATOMIC_RELEASE);
}

static inline stilb_prof_scope stilb_prof_scope_begin(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	stilb_prof_scope scope = {site, 0, 0};
	if (__builtin_expect(ring != NULL, 1)) {
		scope.depth = __atomic_load_n(&ring->depth, __ATOMIC_RELAXED);
		scope.begin = stilb_prof_clock(ring);
		stilb_prof_open(ring, site, scope.begin, scope.depth);
	}
	return scope;
}

/* The ring is looked up again, and must still hold the zone: the thread may have begun or ended inside the scope. */
static inline void stilb_prof_scope_end(const stilb_prof_scope *scope)
{
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	if (__builtin_expect(ring != NULL && scope->begin != 0, 1)) {
		const uint64_t end = stilb_prof_clock(ring);
		if (__builtin_expect(__atomic_load_n(&ring->depth, __ATOMIC_RELAXED) > scope->depth, 1))
			stilb_prof_close(ring, scope->site, scope->begin, end, scope->depth);
	}
}

#ifdef __cplusplus
}
#endif
#endif
