/*
 * profiler: records what every thread of a program did in its last frames, all the time. A stand-alone library for C17
 * and Linux; it uses no other part of Stilb. This header also compiles as C++17.
 *
 * What it is.   PROFILE("name") measures the rest of its scope: a zone. Each thread owns a ring of 16-byte events and
 *               writes one event at the end of each zone. The oldest events are overwritten, so memory is bounded and
 *               recording can always be on. A snapshot (prof_snapshot.h) is a copy of what the rings hold, taken while
 *               all threads go on recording.
 * Life cycle.   Zones and snapshots in any order, then stilb_prof_shutdown. Nothing has to be initialised: a thread
 *               gets its ring with its first zone and gives it up when it exits. stilb_prof_thread_begin makes the ring
 *               earlier and names it.
 * Per frame.    One thread calls stilb_prof_frame_mark once.
 * Example.
 *                   while (running) {
 *                       stilb_prof_frame_mark();
 *                       PROFILE("frame");                  // to the end of this scope
 *                       {
 *                           PROFILE("simulate");
 *                           simulate();
 *                       }
 *                       PROFILE_COUNTER("bodies", body_count);
 *                   }
 *                   stilb_prof_snapshot snapshot = {0};    // prof_snapshot.h
 *                   if (stilb_prof_snapshot_take(&snapshot, NULL) == 0)
 *                       stilb_prof_trace_save(&snapshot, "my program", "trace.json"); // prof_trace.h
 *                   stilb_prof_snapshot_finish(&snapshot);
 *                   stilb_prof_shutdown();
 *
 * Threads.      [any-thread]: any thread may call it at any time. [one-writer]: one thread is its only caller (frame
 *               marks and captures assert that no two calls overlap). A zone writes only memory of the calling thread:
 *               no lock, no allocation and no system call, except for the first event of a thread that has not called
 *               stilb_prof_thread_begin.
 * Not for.      Signal handlers: the handler's zone could interrupt the write of a zone of the same thread. Nor for a
 *               child of fork in a program with threads, before it calls exec: its first zone may take a lock that a
 *               thread held which the child does not have.
 * Errors.       0 or a negative errno. Nothing here prints.
 * Clock.        rdtsc if the CPU says that it is invariant (CPUID), else CLOCK_MONOTONIC. rdtsc does not serialise: the
 *               CPU may read it before the last instructions of a zone have retired, so a zone reads about 20 ns too
 *               short. A snapshot says how much it is on this machine. PROFILE_PRECISE waits for those instructions.
 * Switching.    At run time: stilb_prof_record_set(false). At compile time: if STILB_PROFILE_OFF is defined (CMake:
 *               STILB_PROFILE=OFF), every macro here expands to nothing. The functions remain and link, and a snapshot
 *               has frames but no zones.
 * Asserts.      In programs compiled without NDEBUG, the macros and inline functions check their arguments, which costs
 *               some nanoseconds an event.
 *
 * Copies.       The library is static and keeps its state once per linked program or shared object. The zones of a
 *               shared object are recorded by the copy of the library that is linked into it. The copy in libstilb.so,
 *               Stilb's shared library, also records for the program and all shared objects that are compiled with
 *               STILB_PROF_SHARED, which Stilb's CMake and pkg-config packages define then. That is up to 63 of them,
 *               of 512 MiB together; more do not record. They stay in memory when they are closed.
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

/* The kind of events that a site records. */
typedef enum stilb_prof_kind {
	STILB_PROF_KIND_ZONE,
	STILB_PROF_KIND_PRECISE, /* a zone whose end is read after all of its instructions have retired */
	STILB_PROF_KIND_COUNTER,
	STILB_PROF_KIND_INSTANT,
	STILB_PROF_KIND_FLOW_BEGIN,
	STILB_PROF_KIND_FLOW_END,
} stilb_prof_kind;

/* One place in the source that records. The macros below define sites, and stilb_prof_site_make makes them at run time.
 * A site in memory of one's own (malloc) does not work: events hold the distance of their site from the program's
 * other sites, at most 512 MiB (asserted). The strings must live as long as the program. */
typedef struct stilb_prof_site {
	const char *name;     /* as viewers show it; UTF-8 */
	const char *function; /* the enclosing function; "" if the site stands outside of functions */
	const char *file;
	uint32_t line;
	uint32_t color;  /* 0xRRGGBB; 0: the viewer chooses */
	uint32_t kind;   /* a stilb_prof_kind */
	uint32_t listed; /* 1: in the list, linked by next, of the sites that the linker could not put into the array */
	const struct stilb_prof_site *next;
	uint64_t reserved[2]; /* 0 */
} __attribute__((aligned(64))) stilb_prof_site;

/* The linker lays out all sites of an image's C code as one array, which must have no gaps. */
static_assert(sizeof(stilb_prof_site) == 64, "sites form an array");

/* Walks all sites of this image: NULL gives the first, each site the next, the last site NULL. First come the sites of
 * C code, executed or not; then those of C++ code that have been executed (g++ refuses to put these into the array);
 * and among the latter those made at run time. previous must come from this function (asserted). [any-thread] */
const stilb_prof_site *stilb_prof_site_next(const stilb_prof_site *previous);

/* The site of a zone whose name is known only at run time; the same name and colour give the same site. name is not
 * NULL and is copied; the copy is kept until the program ends. rgb is 0xRRGGBB (asserted). After 1,024 such sites, or
 * without memory, a site named "more names" stands for all others. Takes a lock and compares names: call it once per
 * name, not once per zone. [any-thread] */
const stilb_prof_site *stilb_prof_site_make(const char *name, uint32_t rgb);

/* ---- zones ------------------------------------------------------------------------------------------------------- */

/* A zone from here to the end of the enclosing scope. Several in one scope nest in the order written. name is a string
 * literal. The zone ends however the scope is left: by return, break, goto or a C++ exception. Costs about two reads of
 * the clock. [any-thread] */
#define PROFILE(name) STILB_PROF_SCOPE_(__COUNTER__, "" name, 0, ZONE, stilb_prof_scope_end)

/* PROFILE with a colour: rgb is 0xRRGGBB. [any-thread] */
#define PROFILE_COLOR(name, rgb) STILB_PROF_SCOPE_(__COUNTER__, "" name, rgb, ZONE, stilb_prof_scope_end)

/* PROFILE with the name of the enclosing function. [any-thread] */
#define PROFILE_FUNCTION() STILB_PROF_SCOPE_(__COUNTER__, __func__, 0, ZONE, stilb_prof_scope_end)

/* PROFILE whose end is read by rdtscp, after all instructions of the zone have finished: for short zones whose exact
 * length matters. Costs half as much again as PROFILE, plus the wait. [any-thread] */
#define PROFILE_PRECISE(name) STILB_PROF_SCOPE_(__COUNTER__, "" name, 0, PRECISE, stilb_prof_scope_end_precise)

/* A zone from PROFILE_BEGIN to PROFILE_END, which ends the zone that this thread began last; without an open zone it
 * does nothing. Zones that were begun inside a PROFILE scope and not ended end with that scope. [any-thread] */
#define PROFILE_BEGIN(name) STILB_PROF_AT_(name, ZONE, stilb_prof_zone_begin(STILB_PROF_HERE_))
#define PROFILE_END() stilb_prof_zone_end()

/* Ends the zone that this thread began last, by PROFILE_BEGIN or by PROFILE, and begins another in its place: for steps
 * that follow one another, with one read of the clock between. Without an open zone it does nothing. [any-thread] */
#define PROFILE_NEXT(name) STILB_PROF_AT_(name, ZONE, stilb_prof_zone_next(STILB_PROF_HERE_))

/* Records the value of a quantity at this moment; viewers draw a curve. value is a double of which 40 bits of mantissa
 * are kept: integers up to 2^41 are exact. value is not evaluated while recording is off. [any-thread] */
#define PROFILE_COUNTER(name, value)                                                                                   \
	do {                                                                                                               \
		if (stilb_prof_is_recording())                                                                                 \
			STILB_PROF_AT_(name, COUNTER, stilb_prof_counter(STILB_PROF_HERE_, value));                                \
	} while (0)

/* Records that something happened at this moment. [any-thread] */
#define PROFILE_INSTANT(name) STILB_PROF_AT_(name, INSTANT, stilb_prof_instant(STILB_PROF_HERE_))

/* Defines a static site named variable for stilb_prof_zone_begin and stilb_prof_lane_zone, at file scope or in a
 * function. name is a string literal, rgb a constant 0xRRGGBB. */
#define STILB_PROF_SITE(variable, name, rgb)                                                                           \
	STILB_PROF_STATIC_ stilb_prof_site variable STILB_PROF_SECTION_ =                                                  \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_ZONE) STILB_PROF_LIST_(variable, &variable, 1)

/* PROFILE_BEGIN and PROFILE_END for a zone whose ends lie in different functions (hooks), or whose name is known only
 * at run time. site is a site of zones (asserted), from STILB_PROF_SITE or stilb_prof_site_make. Zones nested more than
 * 64 deep are counted (stilb_prof_snapshot.too_deep) and not recorded. [any-thread] */
static inline void stilb_prof_zone_begin(const stilb_prof_site *site);
static inline void stilb_prof_zone_end(void);

/* ---- flows: arrows from where a job was submitted to where it ran ------------------------------------------------ */

/* Defines a static flow for the two functions below, at file scope or in a function. One flow serves all arrows of a
 * kind, for example all jobs. name is a string literal, rgb a constant 0xRRGGBB. */
#define STILB_PROF_FLOW(variable, name, rgb)                                                                           \
	STILB_PROF_STATIC_ stilb_prof_site variable[2] STILB_PROF_SECTION_ = {                                             \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_FLOW_BEGIN),                                           \
		STILB_PROF_SITE_INIT_("" name, "", rgb, STILB_PROF_KIND_FLOW_END)} STILB_PROF_LIST_(variable, variable, 2)

/* Begins an arrow in the zone that is open on this thread. Returns the arrow's id, which travels with the job; 0 while
 * recording is off. The id contains the number of the current frame: the job's time is charged to the frame that
 * submitted it. flow is not NULL (asserted); with a site that is not a flow it returns 0. [any-thread] */
uint64_t stilb_prof_flow_begin(const stilb_prof_site *flow);

/* Ends the arrow id in the zone that is open on this thread: call it first in the job's zone. An arrow may have several
 * ends. An id of 0 does nothing. flow is not NULL (asserted); a site that is not a flow does nothing. [any-thread] */
void stilb_prof_flow_end(const stilb_prof_site *flow, uint64_t id);

/* ---- threads and frames ------------------------------------------------------------------------------------------ */

/* Switches recording on or off for all threads; it is on at the start. While it is off a macro costs one load and one
 * branch. Zones that are open at the moment of the change are lost. [any-thread] */
void stilb_prof_record_set(bool on);

/* Gives the calling thread a ring: the ring of an ended thread of that name, with its events, or a new one. name is
 * copied and cut to 63 bytes; NULL and "" stand for "thread".
 * A thread that has not called this gets a ring at its first event, which then takes about twenty microseconds. Its
 * name is "main" in the main thread, else the name given by pthread_setname_np, else "thread 1", "thread 2" and so on.
 * A later stilb_prof_thread_begin renames that ring. If there is no memory for the ring, the thread's events are
 * counted (stilb_prof_snapshot.without_ring), and it tries again every 1,024 events.
 * Returns 0; -EALREADY: the thread has called this before; -ENOMEM: no memory. [any-thread] */
int stilb_prof_thread_begin(const char *name);

/* Gives up the calling thread's ring; later snapshots still show its events. Does nothing without a ring. A thread that
 * exits does this by itself. At most 64 rings of ended threads and lanes are kept; then a thread or lane with a new
 * name takes over the ring whose owner ended first, so memory does not grow with the number of threads that come and
 * go. [any-thread] */
void stilb_prof_thread_end(void);

/* Sets the number of events in rings that are made from now on: a power of two in 64..2^26; 65,536 (1 MiB) unless set.
 * Rings of up to 1 MiB made by stilb_prof_thread_begin are resident from the start; pages of all other rings are
 * allocated when they are first written. Returns 0, or -EINVAL if events is out of range. [any-thread] */
int stilb_prof_ring_events_set(uint32_t events);

/* Sets if threads that begin from now on also record their context switches (perf_event_open); off unless set. If the
 * kernel refuses, snapshots say why (stilb_prof_lane.no_switches). [any-thread] */
void stilb_prof_switches_set(bool on);

/* Ends the current frame and begins the next. The last 1,024 marks are remembered. Frames are numbered from 0; what was
 * recorded before the first mark belongs to no frame. [one-writer] */
void stilb_prof_frame_mark(void);

/* ---- lanes of devices -------------------------------------------------------------------------------------------- */

/* A lane: a row of zones in viewers, like a thread's, but timed elsewhere, for example on a GPU. Created by
 * stilb_prof_lane_create. */
typedef struct stilb_prof_lane_handle stilb_prof_lane_handle;

/* Creates a lane; name and errors as for stilb_prof_thread_begin. lane is not NULL (asserted). Returns 0, or -ENOMEM,
 * and then *lane is NULL. [any-thread] */
int stilb_prof_lane_create(const char *name, stilb_prof_lane_handle **lane);

/* Records a zone. begin_ns and end_ns are nanoseconds of CLOCK_MONOTONIC; an end before the begin counts as the begin.
 * depth is the number of zones around it, 0..63; deeper ones are counted, not recorded. Call it for children before
 * their parent, in the order of their ends. site is a site of zones (asserted). A lane of NULL does nothing; one that
 * was destroyed is an error of the program (asserted). [one-writer] per lane */
void stilb_prof_lane_zone(stilb_prof_lane_handle *lane, const stilb_prof_site *site, uint32_t depth, uint64_t begin_ns,
                          uint64_t end_ns);

/* Ends the lane; later snapshots still show its zones. Call it once (asserted), while nobody records to the lane. NULL
 * does nothing. [any-thread] */
void stilb_prof_lane_destroy(stilb_prof_lane_handle *lane);

/* Forgets all that was recorded and frees the rings of the calling thread, of ended threads and of lanes; those lanes
 * must not be used afterwards. A living thread keeps its ring, now empty; the next shutdown after the thread's end
 * frees it. Captures have been stopped (prof_capture.h; asserted). Meanwhile other threads may record but call nothing
 * else here. Recording may begin anew afterwards. [one-writer] */
void stilb_prof_shutdown(void);

/* ---- what the macros expand to ----------------------------------------------------------------------------------- */

#include "prof_inline.h"

/* ---- off --------------------------------------------------------------------------------------------------------- */

/* Everything that records disappears from the source; the functions for threads, frames and snapshots stay. */
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
