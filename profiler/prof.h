/*
 * profiler: what every thread did in the last frames, always on. A stand-alone library: C17 and Linux, no other part
 * of Stilb. This header also compiles as C++17.
 *
 * What it is.   PROFILE("name") times the rest of its scope. Each thread owns a ring of 16-byte events and writes one
 *               event at the end of each zone; the oldest are overwritten, so memory is fixed and nothing needs to be
 *               switched on. A snapshot (prof_snapshot.h) is a copy of what is still held, taken while all threads go
 *               on recording.
 * Life cycle.   Zones, snapshots, in any order; stilb_prof_shutdown last. A thread gets its ring at its first zone and
 *               leaves it when it exits; stilb_prof_thread_begin gives it one earlier, with a name.
 * Per frame.    stilb_prof_frame_mark, once, by one thread.
 * Threads.      [any-thread] may be called anywhere, at any time. [one-writer] has one thread as its caller.
 *               Zones write only what belongs to the calling thread: no lock, no allocation, no system call, save
 *               for the first one of a thread that did not call stilb_prof_thread_begin.
 *               Not for signal handlers: a handler's zone could fall into the middle of the same thread's. Nor, before
 *               exec, for the child that a program with threads forks: its first zone takes a lock that a thread which
 *               the child does not have may hold.
 * Errors.       0 or a negative errno. Nothing here prints.
 * Clock.        rdtsc where the CPU says that it is invariant, else CLOCK_MONOTONIC. rdtsc is not serialising: the CPU
 *               may read it before the last instructions of a zone retire, so a zone reads some 20 ns short; a snapshot
 *               says how much on this machine. PROFILE_PRECISE waits for them.
 * Off.          At run time: stilb_prof_record_set(false). At compile time: with STILB_PROFILE_OFF defined (CMake:
 *               STILB_PROFILE=OFF) every macro here expands to nothing; the functions stay and link, and a snapshot has
 *               its frames and no zones.
 *
 * The library is static and keeps its state once per linked program or shared object; zones of one image are recorded
 * by the copy that is linked into it.
 */
#ifndef STILB_PROF_H
#define STILB_PROF_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- sites ------------------------------------------------------------------------------------------------------- */

/* What the events of a site are. */
typedef enum stilb_prof_kind {
	STILB_PROF_KIND_ZONE,
	STILB_PROF_KIND_PRECISE, /* a zone whose end waited for the instructions before it */
	STILB_PROF_KIND_COUNTER,
	STILB_PROF_KIND_INSTANT,
	STILB_PROF_KIND_FLOW_BEGIN,
	STILB_PROF_KIND_FLOW_END,
} stilb_prof_kind;

/* One place in the source. Make them with the macros below; the strings must live as long as the program. */
typedef struct stilb_prof_site {
	const char *name;     /* what the viewer shows; UTF-8 */
	const char *function; /* "" when made by STILB_PROF_SITE */
	const char *file;
	uint32_t line;
	uint32_t color;  /* 0xRRGGBB; 0: the viewer chooses */
	uint32_t kind;   /* stilb_prof_kind */
	uint32_t listed; /* the list of sites that are not in the array holds it */
	const struct stilb_prof_site *next;
	uint64_t reserved[2]; /* 0 */
} __attribute__((aligned(64))) stilb_prof_site;

/* The linker lays all sites of an image's C code out as one array: no gaps allowed. */
static_assert(sizeof(stilb_prof_site) == 64, "sites form an array");

/* All sites of this image: NULL gives the first, each the next, the last NULL. Those of C code, whether they have run
 * or not, then those of C++ code that have run (g++ refuses to put them into the array), and those made at run time.
 * [any-thread] */
const stilb_prof_site *stilb_prof_site_next(const stilb_prof_site *previous);

/* The site of a zone whose name is known only at run time: the same for the same name and colour. name is copied, and
 * kept until the program ends. After 1,024 of them, or without memory, "more names" stands for the rest. Takes a lock:
 * make it once, not per zone. [any-thread] */
const stilb_prof_site *stilb_prof_site_make(const char *name, uint32_t rgb);

/* ---- zones ------------------------------------------------------------------------------------------------------- */

/* A zone from here to the end of the enclosing scope; several in one scope nest in the order written. The name is a
 * string literal. Left by return, break, goto or a C++ exception alike. [any-thread] */
#define PROFILE(name) STILB_PROF_SCOPE_(__COUNTER__, "" name, 0, ZONE, stilb_prof_scope_end)

/* The same with a colour, 0xRRGGBB. [any-thread] */
#define PROFILE_COLOR(name, rgb) STILB_PROF_SCOPE_(__COUNTER__, "" name, rgb, ZONE, stilb_prof_scope_end)

/* The same, named after the enclosing function. [any-thread] */
#define PROFILE_FUNCTION() STILB_PROF_SCOPE_(__COUNTER__, __func__, 0, ZONE, stilb_prof_scope_end)

/* The same, ended by rdtscp, which waits until all that the zone did is done: for short zones whose length matters. It
 * costs about half as much again, and the wait. [any-thread] */
#define PROFILE_PRECISE(name) STILB_PROF_SCOPE_(__COUNTER__, "" name, 0, PRECISE, stilb_prof_scope_end_precise)

/* A zone from here to PROFILE_END, which ends the zone that this thread began last. A scope's end also ends what was
 * begun in it and not ended. [any-thread] */
#define PROFILE_BEGIN(name) STILB_PROF_AT_(name, ZONE, stilb_prof_zone_begin(STILB_PROF_HERE_))
#define PROFILE_END() stilb_prof_zone_end()

/* Ends the zone that this thread began last, by PROFILE_BEGIN or by PROFILE, and begins another in its place: steps
 * that follow one another, with one clock read between them. Without an open zone it does nothing. [any-thread] */
#define PROFILE_NEXT(name) STILB_PROF_AT_(name, ZONE, stilb_prof_zone_next(STILB_PROF_HERE_))

/* A number at this moment: a curve. value is a double, kept with 40 bits of mantissa: integers up to 2^41 exactly. It
 * is not evaluated where nothing is recorded. [any-thread] */
#define PROFILE_COUNTER(name, value)                                                                                   \
	do {                                                                                                               \
		if (stilb_prof_is_recording())                                                                                 \
			STILB_PROF_AT_(name, COUNTER, stilb_prof_counter(STILB_PROF_HERE_, value));                                \
	} while (0)

/* A moment. [any-thread] */
#define PROFILE_INSTANT(name) STILB_PROF_AT_(name, INSTANT, stilb_prof_instant(STILB_PROF_HERE_))

/* Defines a static site for stilb_prof_zone_begin and stilb_prof_lane_zone, at file scope or in a function. */
#define STILB_PROF_SITE(variable, name, rgb)                                                                           \
	STILB_PROF_STATIC_ stilb_prof_site variable STILB_PROF_SECTION_ =                                                  \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_ZONE) STILB_PROF_LIST_(variable, &variable, 1)

/* A zone whose two ends lie in different functions (hooks): PROFILE_BEGIN and PROFILE_END with a site made before, by
 * STILB_PROF_SITE or stilb_prof_site_make. Zones nested more than 64 deep are counted, not recorded. [any-thread] */
static inline void stilb_prof_zone_begin(const stilb_prof_site *site);
static inline void stilb_prof_zone_end(void);

/* ---- flows: a job from where it was submitted to where it ran ---------------------------------------------------- */

/* Defines a static flow for the two calls below, at file scope or in a function: all arrows of one kind. */
#define STILB_PROF_FLOW(variable, name, rgb)                                                                           \
	STILB_PROF_STATIC_ stilb_prof_site variable[2] STILB_PROF_SECTION_ = {                                             \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_FLOW_BEGIN),                                           \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_FLOW_END)} STILB_PROF_LIST_(variable, variable, 2)

/* Begins an arrow inside the zone that is open here. Returns its number, which goes with the job; 0 when nothing is
 * recorded. It holds the frame: what runs as the job is charged to the frame that submitted it. [any-thread] */
uint64_t stilb_prof_flow_begin(const stilb_prof_site *flow);

/* Ends it inside the zone that is open here, which is the job; on any thread. id 0: does nothing. [any-thread] */
void stilb_prof_flow_end(const stilb_prof_site *flow, uint64_t id);

/* ---- threads and frames ------------------------------------------------------------------------------------------ */

/* Recording is on from the start. Off: a macro costs one load and one branch. The zones that are open when it goes off
 * or on are lost. [any-thread] */
void stilb_prof_record_set(bool on);

/* Gives the calling thread a ring: a ring left by an ended thread of that name, with what it holds, or a new one. name
 * is copied, 63 bytes at most; NULL counts as "thread".
 * A thread that records without having called this gets a ring at its first zone, counter, instant or flow, which then
 * takes some twenty microseconds. Its name is "main" in the main thread, else the one that pthread_setname_np gave it,
 * else "thread 1", "thread 2" and so on; a later stilb_prof_thread_begin renames the ring. Where there is no memory for
 * it, what the thread records is counted (stilb_prof_snapshot.without_ring), and now and then the thread tries again.
 * -EALREADY: the thread has begun before; -ENOMEM: no memory. [any-thread] */
int stilb_prof_thread_begin(const char *name);

/* Takes the ring away again; what it holds stays for later snapshots. Without a ring it does nothing. A thread that
 * exits does this by itself. At most 64 rings of ended threads and lanes are kept, then the next of another name takes
 * over the one that ended first, so memory does not grow with the number of threads that come and go. [any-thread] */
void stilb_prof_thread_end(void);

/* Events in rings made from now on: a power of two, 64..2^26; 65,536 (1 MiB) unless set. -EINVAL otherwise. Rings of up
 * to 1 MiB that stilb_prof_thread_begin makes are in memory from the start; of all others a page is taken when it is
 * first written. [any-thread] */
int stilb_prof_ring_events_set(uint32_t events);

/* Whether threads that begin from now on also note when they run and when they do not; off unless set. Where the kernel
 * refuses, a snapshot says why. [any-thread] */
void stilb_prof_switches_set(bool on);

/* Begins a new frame and so ends the one before. The last 1,024 are remembered. [one-writer] */
void stilb_prof_frame_mark(void);

/* ---- lanes of devices -------------------------------------------------------------------------------------------- */

/* A row of zones that were timed elsewhere: a GPU. */
typedef struct stilb_prof_lane_handle stilb_prof_lane_handle;

/* As stilb_prof_thread_begin; *lane is NULL after an error. [any-thread] */
int stilb_prof_lane_create(const char *name, stilb_prof_lane_handle **lane);

/* Records a zone, times on CLOCK_MONOTONIC, depth 0..63: children before their parent, in the order of their ends.
 * A lane of NULL: does nothing. [one-writer] of each lane */
void stilb_prof_lane_zone(stilb_prof_lane_handle *lane, const stilb_prof_site *site, uint32_t depth, uint64_t begin_ns,
                          uint64_t end_ns);

/* What it holds stays for later snapshots. NULL: does nothing. [any-thread], when nobody writes to it */
void stilb_prof_lane_destroy(stilb_prof_lane_handle *lane);

/* Forgets all that was recorded and frees the rings of the calling thread, of ended threads and of lanes, which must
 * not be used any more. A thread that still lives keeps its ring, empty; the next shutdown after its end frees it. No
 * other thread may be in any call but those that record. Recording may begin anew afterwards. [one-writer] */
void stilb_prof_shutdown(void);

/* ---- what the macros expand to: not for use by name -------------------------------------------------------------- */

/* begin: time << 12 | offset bits 6..11 | low (6 bits); end: payload << 18 | offset bits 12..29. The time is in ticks
 * of the clock, the offset is that of the site from the start of the section. By the site's kind:
 *   zones      time: its begin     low: its depth           payload: its duration
 *   counters   time: the moment    low, payload: bits 12..17 and 18..63 of the double
 *   instants   time: the moment    low: open zones          payload: 0
 *   flows      time: the moment    low: open zones          payload: the flow's number
 * Events stand in the order of the zones' ends and of the moments. */
typedef struct stilb_prof_event {
	uint64_t begin;
	uint64_t end;
} stilb_prof_event;

#define STILB_PROF_DEPTH_MAX 64
#define STILB_PROF_DURATION_MAX ((UINT64_C(1) << 46) - 1) /* ticks; almost four hours at 5 GHz, then it is cut */

/* An open zone. */
typedef struct stilb_prof_open_zone {
	uint64_t begin;
	const stilb_prof_site *site;
} stilb_prof_open_zone;

/* Written by its thread, read by snapshots: all accesses are atomic, orders as said in prof_ring.c. */
typedef struct stilb_prof_ring {
	uint64_t head; /* events ever written; the next goes to events[head & mask] */
	stilb_prof_event *events;
	uint32_t mask;
	uint32_t tsc;      /* the clock is rdtsc */
	uint32_t depth;    /* open zones */
	uint32_t session;  /* the one that they belong to */
	uint64_t too_deep; /* zones that were not recorded for that */
	uint32_t lane;     /* its number, and the flows begun: for the numbers of flows */
	uint32_t flows;
	stilb_prof_open_zone open[STILB_PROF_DEPTH_MAX]; /* outermost first */
} stilb_prof_ring;

#define STILB_PROF_SITE_INIT_(name, function, rgb, kind)                                                               \
	{                                                                                                                  \
		name, function, __FILE__, __LINE__, rgb, kind, 0, NULL,                                                        \
		{                                                                                                              \
			0, 0                                                                                                       \
		}                                                                                                              \
	}

/* C: constants in the linker's array. C++: g++ refuses one section for inline and other functions, so a site enters a
 * list when it is first used, or before main when it stands outside functions. */
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

/* The linker makes these two, the array's bounds. */
extern const stilb_prof_site __start_stilb_prof_section[] __attribute__((visibility("hidden")));
extern const stilb_prof_site __stop_stilb_prof_section[] __attribute__((visibility("hidden")));

/* 0: nothing is recorded; else each time that recording is switched on has a number of its own. */
extern uint32_t stilb_prof_session __attribute__((visibility("hidden")));

/* Never NULL: a thread without a ring has one that belongs to no session and is never written. */
extern __thread stilb_prof_ring *stilb_prof_thread_ring
	__attribute__((visibility("hidden"), tls_model("initial-exec")));

/* CLOCK_MONOTONIC in nanoseconds. */
uint64_t stilb_prof_clock_monotonic(void);

/* Puts sites into the list, once; returns true. */
bool stilb_prof_site_list(stilb_prof_site *sites, size_t count);

/* The calling thread's ring, in this session: made now when it has none, without its open zones when they belong to an
 * earlier session. NULL: no memory for one; the event that was to be recorded is counted. */
stilb_prof_ring *stilb_prof_ring_enter(uint32_t session);

#ifdef __cplusplus
static inline const stilb_prof_site *stilb_prof_site_use(stilb_prof_site *site)
{
	/* Relaxed: stilb_prof_site_list looks again. */
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

/* The same, after all instructions before it. */
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

static inline bool stilb_prof_is_recording(void)
{
	/* Relaxed: no data depends on it. Expected to be off, as in stilb_prof_recorder. */
	return __builtin_expect(__atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED) != 0, 0);
}

/* The ring to record to, in the session that is on; NULL: nothing is to be recorded. That is what the compiler is told
 * to expect, so that the code falls through where recording is off: a jump to where it is on costs nothing beside the
 * clock. */
static inline stilb_prof_ring *stilb_prof_recorder(void)
{
	uint32_t session = __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED); /* no data depends on it */
	if (__builtin_expect(session == 0, 1))
		return NULL;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	return __builtin_expect(ring->session == session, 1) ? ring : stilb_prof_ring_enter(session);
}

/* The ring whose innermost zone is to end; NULL: none is open. */
static inline stilb_prof_ring *stilb_prof_ender(void)
{
	uint32_t session = __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED); /* no data depends on it */
	if (__builtin_expect(session == 0, 1))
		return NULL;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	return __builtin_expect(ring->session == session && ring->depth > 0, 1) ? ring : NULL;
}

/* Writes an event. */
static inline void stilb_prof_write(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t time, uint64_t low,
                                    uint64_t payload)
{
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED);
	uint64_t offset = (uint64_t)((uintptr_t)site - (uintptr_t)__start_stilb_prof_section);
	assert((uint64_t)((int64_t)(offset << 34) >> 34) == offset && "sites lie in the program, not in allocated memory");
	assert(low < 64 && payload >> 46 == 0);
	stilb_prof_event *event = &ring->events[head & ring->mask];
	__atomic_store_n(&event->begin, time << 12 | (offset & 0xfc0) | low, __ATOMIC_RELEASE);
	__atomic_store_n(&event->end, payload << 18 | (offset >> 12 & 0x3ffff), __ATOMIC_RELEASE);
	__atomic_store_n(&ring->head, head + 1, __ATOMIC_RELEASE);
}

/* Opens a zone at depth. */
static inline void stilb_prof_open(stilb_prof_ring *ring, const stilb_prof_site *site, uint64_t begin, uint32_t depth)
{
	assert(depth < STILB_PROF_DEPTH_MAX && site && site->kind <= STILB_PROF_KIND_PRECISE && "a site of zones");
	__atomic_store_n(&ring->open[depth].begin, begin, __ATOMIC_RELEASE);
	__atomic_store_n(&ring->open[depth].site, site, __ATOMIC_RELEASE);
	__atomic_store_n(&ring->depth, depth + 1, __ATOMIC_RELEASE);
}

/* Closes the zone at depth and all inside it, and writes its event. */
static inline void stilb_prof_close(stilb_prof_ring *ring, uint32_t depth, uint64_t end)
{
	assert(depth < ring->depth && "the zone is open");
	const stilb_prof_open_zone *zone = &ring->open[depth];
	uint64_t begin = __atomic_load_n(&zone->begin, __ATOMIC_RELAXED); /* the thread's own */
	const stilb_prof_site *site = __atomic_load_n(&zone->site, __ATOMIC_RELAXED);
	uint64_t duration = end - begin;
	if (__builtin_expect(duration > STILB_PROF_DURATION_MAX, 0))
		duration = (int64_t)duration < 0 ? 0 : STILB_PROF_DURATION_MAX; /* the clock stepped back, or hours went by */
	__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE);
	stilb_prof_write(ring, site, begin, depth, duration);
}

/* Begins a zone, whether there is room for it or not; returns the number of open zones then. */
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

/* Ends the zone that made depth + 1 open ones. */
static inline void stilb_prof_pop(stilb_prof_ring *ring, uint32_t depth, uint64_t end)
{
	if (__builtin_expect(depth < STILB_PROF_DEPTH_MAX, 1))
		stilb_prof_close(ring, depth, end);
	else
		__atomic_store_n(&ring->depth, depth, __ATOMIC_RELEASE); /* pairs with prof_copy_open_zone */
}

/* The number of open zones with this one; 0: it is not recorded. */
static inline uint32_t stilb_prof_scope_begin(const stilb_prof_site *site)
{
	stilb_prof_ring *ring = stilb_prof_recorder();
	return ring ? stilb_prof_push(ring, site) : 0;
}

/* The ring is looked up again, and must still hold the zone: the thread may have begun or ended inside the scope. */
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

/* ---- off --------------------------------------------------------------------------------------------------------- */

/* What records is gone from the source; what manages threads, frames and snapshots stays. */
#ifdef STILB_PROFILE_OFF
#undef PROFILE
#undef PROFILE_COLOR
#undef PROFILE_FUNCTION
#undef PROFILE_PRECISE
#undef PROFILE_BEGIN
#undef PROFILE_END
#undef PROFILE_NEXT
#undef PROFILE_COUNTER
#undef PROFILE_INSTANT
#undef STILB_PROF_SITE
#undef STILB_PROF_FLOW
#define PROFILE(name)
#define PROFILE_COLOR(name, rgb)
#define PROFILE_FUNCTION()
#define PROFILE_PRECISE(name)
#define PROFILE_BEGIN(name) ((void)0)
#define PROFILE_END() ((void)0)
#define PROFILE_NEXT(name) ((void)0)
#define PROFILE_COUNTER(name, value) ((void)sizeof(value))
#define PROFILE_INSTANT(name) ((void)0)
#define STILB_PROF_SITE(variable, name, rgb) extern const stilb_prof_site variable
#define STILB_PROF_FLOW(variable, name, rgb) extern const stilb_prof_site variable[2]
#define stilb_prof_zone_begin(site) ((void)0)
#define stilb_prof_zone_end() ((void)0)
#define stilb_prof_flow_begin(flow) ((uint64_t)0)
#define stilb_prof_flow_end(flow, id) ((void)(id))
#define stilb_prof_lane_zone(lane, site, depth, begin_ns, end_ns) ((void)(begin_ns), (void)(end_ns))
#endif

#ifdef __cplusplus
}
#endif
#endif
