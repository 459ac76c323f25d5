/*
 * Threads and the rings of events that they write, lanes of devices, frames, and the raw copy that a snapshot is made
 * from.
 *
 * Ring protocol (one writer, any readers). The writer stores an event's two words, then head. The reader loads head,
 * the words, then head again; of the events before the first head it keeps those that the writer cannot have begun to
 * overwrite: numbers above (second head - size). All stores are release and all loads of the reader acquire. So a
 * reader that sees a word of event n also sees head >= n, because the words of n are stored after head = n. On x86
 * these are plain moves. Frame marks follow the same protocol.
 *
 * Open zones. A zone is pushed as begin, site, depth and popped as depth, event, head; a new session is stored as
 * session, depth. So while head and session stay the same, no entry below depth can be written: a reader that finds
 * both unchanged after reading an entry has read it whole.
 */
#include "profiler/prof_internal.h"

#include "profiler/prof_array.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define PROF_RING_EVENTS 65536
#define PROF_RING_EVENTS_MIN 64
#define PROF_RING_EVENTS_MAX (1u << 26)
#define PROF_OPEN_TRIES 64
#define PROF_COMM_MAX 16        /* bytes of a thread's name in the kernel, with the 0 at its end */
#define PROF_REFUSED_TRIES 1024 /* a thread without memory for a ring tries again after so many events */

/* A ring and its owner, a thread or a lane of a device. Both lie in one memory mapping: first this structure, padded to
 * PROF_HEADER_SIZE bytes, then the events. */
typedef struct prof_thread {
	stilb_prof_ring ring; /* first: stilb_prof_thread_ring points to it */
	char name[PROF_NAME_MAX];
	bool device;
	bool unnamed; /* made at the thread's first event, and stilb_prof_thread_begin has not been called since */
	uint32_t tid;
	prof_switches switches;
	uint64_t ended;              /* 0: in use; else its place in the order in which rings were given up, from 1 */
	uint64_t begun_ns, ended_ns; /* CLOCK_MONOTONIC: when its last owner took it and gave it up; 0: in use */
	uint64_t first;              /* number of the first event since the last shutdown: earlier ones are forgotten */
	uint64_t first_too_deep;     /* likewise: ring.too_deep at the last shutdown */
	size_t mapping;              /* bytes of the memory mapping */
} prof_thread;

#define PROF_HEADER_SIZE 4096
static_assert(sizeof(prof_thread) <= PROF_HEADER_SIZE, "header");
static_assert(offsetof(prof_thread, ring) == 0, "the ring comes first");

/* What stilb_prof_thread_ring points to in threads that have no ring. Its session, 0, is never the current one, so that
 * the first event of a thread takes the slow path (stilb_prof_ring_enter); and it has no open zones. */
static const stilb_prof_ring prof_ring_none;

__thread stilb_prof_ring *stilb_prof_thread_ring = (stilb_prof_ring *)&prof_ring_none;
uint32_t stilb_prof_session = 1;

#ifdef PROF_IMAGES
/* The name by which other images know it: what is hidden within this library for its own files stays so. */
extern __thread stilb_prof_ring *stilb_prof_ring_shared
	__attribute__((alias("stilb_prof_thread_ring"), tls_model("initial-exec")));
#endif

enum prof_lock_state { PROF_UNLOCKED, PROF_SHARED, PROF_LOCKED };

/* State of the calling thread. */
static __thread struct {
	enum prof_lock_state locked; /* how this thread holds prof.lock; for asserts alone */
	uint32_t inside;  /* calls in progress that hold the lock or make a ring: prof_self_enter must not nest in them */
	uint32_t refused; /* events since there was no memory for its ring; 0: it has not been refused one */
} prof_self __attribute__((tls_model("initial-exec"))); /* in a shared object other models may allocate */

/* The lock guards everything except what zones and frame marks write. prof_copy_take holds it shared, so that a
 * snapshot for the screen does not wait for one that becomes a file. */
static struct {
	pthread_rwlock_t lock;
	prof_thread **threads; /* all rings, in the order of the lanes of a snapshot */
	size_t count, capacity;
	uint32_t ring_events;
	uint32_t made;         /* rings made so far: the number of the next one */
	uint64_t ended;        /* rings given up so far */
	uint64_t discarded;    /* events in rings that were taken over under another name */
	uint64_t without_ring; /* events of threads without memory for a ring; atomic, not guarded by the lock */
} prof = {.lock = PTHREAD_RWLOCK_INITIALIZER, .ring_events = PROF_RING_EVENTS};

static struct {
	uint64_t count; /* frames begun; number n is at begin[n % PROF_FRAMES_MAX] */
	prof_anchor begin[PROF_FRAMES_MAX];
	prof_frame_hook *hook;
	prof_exclusive marking; /* stilb_prof_frame_mark is running */
} prof_frames;

static void prof_lock(void)
{
	assert(prof_self.locked == PROF_UNLOCKED && "the lock is not taken twice");
	prof_self.inside++;
	pthread_rwlock_wrlock(&prof.lock);
	prof_self.locked = PROF_LOCKED;
}

static void prof_lock_shared(void)
{
	assert(prof_self.locked == PROF_UNLOCKED && "the lock is not taken twice");
	prof_self.inside++;
	pthread_rwlock_rdlock(&prof.lock);
	prof_self.locked = PROF_SHARED;
}

static void prof_unlock(void)
{
	assert(prof_self.locked != PROF_UNLOCKED && "the caller holds the lock");
	prof_self.locked = PROF_UNLOCKED;
	pthread_rwlock_unlock(&prof.lock);
	prof_self.inside--;
}

/* For asserts: the sizes and numbers of all rings are right. Caller holds prof.lock. Living threads go on recording, so
 * their heads rise meanwhile. */
static bool prof_list_is_sound(void)
{
	bool sound = prof.count <= prof.capacity && prof.count <= prof.made;
	for (size_t i = 0; sound && i < prof.count; i++) {
		const prof_thread *thread = prof.threads[i];
		size_t size = (size_t)thread->ring.mask + 1;
		uint64_t head = __atomic_load_n(&thread->ring.head, __ATOMIC_RELAXED); /* compared alone */
		sound = (size & (size - 1)) == 0 && thread->mapping == PROF_HEADER_SIZE + size * sizeof(stilb_prof_event) &&
		        thread->ring.lane < prof.made && thread->first <= head && thread->ended <= prof.ended &&
		        (thread->ended == 0) == (thread->ended_ns == 0) && memchr(thread->name, 0, PROF_NAME_MAX);
	}
	return sound;
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

/* Maps the memory of a ring for so many events. populate: makes its pages resident now, if it is not larger than the
 * default, so that its first lap takes no page faults; a larger one may never be filled. NULL: no memory. */
static prof_thread *prof_thread_map(uint32_t events, bool populate)
{
	assert(events >= PROF_RING_EVENTS_MIN && (events & (events - 1)) == 0);
	size_t size = PROF_HEADER_SIZE + (size_t)events * sizeof(stilb_prof_event);
	bool now = populate && events <= PROF_RING_EVENTS;
	int flags = MAP_PRIVATE | MAP_ANONYMOUS | (now ? MAP_POPULATE : MAP_NORESERVE);
	void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, flags, -1, 0);
	if (memory == MAP_FAILED)
		return NULL;
	prof_thread *thread = memory;
	thread->ring.events = (stilb_prof_event *)((char *)memory + PROF_HEADER_SIZE);
	thread->ring.mask = events - 1;
	thread->ring.tsc = prof_clock_is_tsc();
	thread->mapping = size;
	return thread;
}

/* Makes a ring at the end of the list. NULL: no memory. Caller holds prof.lock. */
static prof_thread *prof_thread_add(bool populate)
{
	assert(prof_self.locked == PROF_LOCKED);
	if (!prof_array_room(&prof.threads, sizeof *prof.threads, prof.count + 1, &prof.capacity))
		return NULL;
	prof_thread *thread = prof_thread_map(prof.ring_events, populate);
	if (thread) {
		thread->ring.lane = prof.made++;
		prof.threads[prof.count++] = thread;
	}
	return thread;
}

/* Chooses a ring that was given up: the latest of that name; else, if PROF_ENDED_MAX are kept, the oldest of all. NULL:
 * none. Caller holds prof.lock. */
static prof_thread *prof_thread_reuse(const char *name, bool device)
{
	assert(prof_self.locked == PROF_LOCKED);
	prof_thread *same = NULL, *oldest = NULL;
	uint32_t ended = 0;
	for (size_t i = 0; i < prof.count; i++) {
		prof_thread *thread = prof.threads[i];
		if (thread->ended == 0)
			continue;
		ended++;
		if (thread->device == device && strcmp(thread->name, name) == 0 && (!same || thread->ended > same->ended))
			same = thread;
		if (!oldest || thread->ended < oldest->ended)
			oldest = thread;
	}
	if (same || ended < PROF_ENDED_MAX)
		return same;
	prof.discarded += oldest->ring.head - oldest->first;
	/* No memory order is needed: a ring without an owner is only read by prof_copy_take, under the lock. */
	oldest->ring.head = oldest->first = 0;
	return oldest;
}

/* The length of a name without the number at its end. */
static size_t prof_name_stem(const char *name)
{
	size_t length = strlen(name);
	while (length > 0 && name[length - 1] >= '0' && name[length - 1] <= '9')
		length--;
	return length;
}

/* True if the names differ only in the number at their end, and the number of a is larger: "worker 10", "worker 2". */
static bool prof_name_follows(const char *a, const char *b)
{
	size_t stem = prof_name_stem(a);
	if (stem != prof_name_stem(b) || memcmp(a, b, stem) != 0)
		return false;
	size_t digits_a = strlen(a + stem), digits_b = strlen(b + stem);
	return digits_a != digits_b ? digits_a > digits_b : strcmp(a + stem, b + stem) > 0;
}

/* Names the ring and moves it to its place in the list. That is the end of the list, or before the first ring whose
 * name differs only by a larger number at its end: "worker 2" before "worker 10", though workers begin in any order. A
 * main thread that has not called stilb_prof_thread_begin is the first. Caller holds prof.lock. */
static void prof_thread_rename(prof_thread *thread, const char name[PROF_NAME_MAX])
{
	assert(prof_self.locked == PROF_LOCKED);
	assert(prof.count > 0);
	size_t last = prof.count - 1;
	bool first = thread->unnamed && thread->tid == (uint32_t)getpid();
	size_t old = 0, place = 0;
	memcpy(thread->name, name, PROF_NAME_MAX);
	while (prof.threads[old] != thread) {
		assert(old < last && "the ring is in the list");
		old++;
	}
	memmove(&prof.threads[old], &prof.threads[old + 1], (last - old) * sizeof *prof.threads);
	while (!first && place < last && !prof_name_follows(prof.threads[place]->name, name))
		place++;
	memmove(&prof.threads[place + 1], &prof.threads[place], (last - place) * sizeof *prof.threads);
	prof.threads[place] = thread;
}

static bool prof_name_lives(const char *name)
{
	assert(prof_self.locked == PROF_LOCKED);
	for (size_t i = 0; i < prof.count; i++)
		if (prof.threads[i]->ended == 0 && strcmp(prof.threads[i]->name, name) == 0)
			return true;
	return false;
}

/* The first of "thread 1", "thread 2", ... that no living thread has. Caller holds prof.lock. */
static void prof_name_number(char name[PROF_NAME_MAX])
{
	uint32_t number = 1;
	do
		snprintf(name, PROF_NAME_MAX, "thread %u", number++);
	while (prof_name_lives(name));
}

/* Gives a ring to the calling thread or to a device. An empty name becomes "thread 1" and so on. NULL: no memory. */
static prof_thread *prof_thread_take(char name[PROF_NAME_MAX], bool device, bool unnamed)
{
	prof_lock();
	if (name[0] == 0)
		prof_name_number(name);
	prof_thread *thread = prof_thread_reuse(name, device);
	bool added = !thread;
	if (added)
		thread = prof_thread_add(!unnamed);
	if (thread) {
		thread->device = device;
		thread->unnamed = unnamed;
		thread->tid = device ? 0 : (uint32_t)gettid();
		if (added)
			prof_thread_rename(thread, name);
		else
			memcpy(thread->name, name, PROF_NAME_MAX);
		prof_switches_close(&thread->switches);
		if (!device)
			thread->switches.refused = "the thread is only beginning"; /* until prof_thread_watch */
		/* Relaxed: if another session has begun meanwhile, the first zone notices it (stilb_prof_recorder). */
		thread->ring.session = __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED);
		thread->ended = 0;
		thread->begun_ns = stilb_prof_clock_monotonic();
		thread->ended_ns = 0;
	}
	PROF_CHECK(prof_list_is_sound());
	prof_unlock();
	return thread;
}

/* Starts recording the calling thread's context switches, if that was asked for. Without the lock: it opens files. */
static void prof_thread_watch(prof_thread *thread)
{
	assert(!thread->device && thread->tid == (uint32_t)gettid() && "a thread watches itself");
	prof_switches switches = prof_switches_open(thread->name);
	prof_lock();
	prof_switches_close(&thread->switches);
	thread->switches = switches;
	thread->begun_ns = stilb_prof_clock_monotonic();
	prof_unlock();
}

static void prof_thread_leave(prof_thread *thread)
{
	prof_lock();
	assert(thread->ended == 0 && "a ring is left once");
	thread->ring.depth = 0;
	thread->ended = ++prof.ended;
	thread->ended_ns = stilb_prof_clock_monotonic();
	prof_unlock();
}

/* ---- the calling thread ------------------------------------------------------------------------------------------ */

static bool prof_self_has_ring(void)
{
	return stilb_prof_thread_ring != &prof_ring_none;
}

/* A key whose destructor runs when a thread exits. */
static struct {
	pthread_once_t once;
	pthread_key_t key;
	bool works;
} prof_exit = {.once = PTHREAD_ONCE_INIT};

static void prof_exit_run(void *unused)
{
	(void)unused;
	stilb_prof_thread_end();
}

static void prof_exit_make(void)
{
	prof_exit.works = pthread_key_create(&prof_exit.key, prof_exit_run) == 0;
}

/* Runs before this code is unloaded (dlclose): threads that exit later must not call prof_exit_run. */
__attribute__((destructor)) static void prof_exit_delete(void)
{
	pthread_once(&prof_exit.once, prof_exit_make); /* waits for a thread that is making it */
	if (prof_exit.works)
		pthread_key_delete(prof_exit.key);
}

/* From now on the calling thread gives up its ring when it exits. False: no memory. */
static bool prof_exit_watch(void)
{
	pthread_once(&prof_exit.once, prof_exit_make);
	return prof_exit.works && pthread_setspecific(prof_exit.key, &prof_exit) == 0;
}

static int prof_self_begin(char name[PROF_NAME_MAX], bool unnamed)
{
	assert(!prof_self_has_ring() && "a thread has one ring");
	/* A thread that called stilb_prof_thread_begin may also call stilb_prof_thread_end itself. */
	if (!prof_exit_watch() && unnamed)
		return -ENOMEM;
	prof_thread *thread = prof_thread_take(name, false, unnamed);
	if (!thread)
		return -ENOMEM;
	prof_thread_watch(thread);
	prof_self.refused = 0;
	stilb_prof_thread_ring = &thread->ring;
	return 0;
}

/* Names the ring that the calling thread got at its first event. */
static void prof_self_rename(const char name[PROF_NAME_MAX])
{
	prof_thread *thread = (prof_thread *)stilb_prof_thread_ring;
	assert(prof_self_has_ring() && thread->unnamed);
	prof_lock();
	prof_thread_rename(thread, name);
	thread->unnamed = false;
	PROF_CHECK(prof_list_is_sound());
	prof_unlock();
	if (thread->switches.schedstat != 0) /* its counters carry the old name. Only this thread writes switches */
		prof_thread_watch(thread);
}

static void prof_name_copy(char to[PROF_NAME_MAX], const char *name)
{
	size_t length = strnlen(name, PROF_NAME_MAX - 1);
	memcpy(to, name, length);
	memset(to + length, 0, PROF_NAME_MAX - length);
}

int stilb_prof_thread_begin(const char *name)
{
	char copy[PROF_NAME_MAX];
	prof_name_copy(copy, name && name[0] != 0 ? name : "thread");
	if (!prof_self_has_ring())
		return prof_self_begin(copy, false);
	if (!((const prof_thread *)stilb_prof_thread_ring)->unnamed) /* written by this thread alone */
		return -EALREADY;
	prof_self_rename(copy);
	return 0;
}

void stilb_prof_thread_end(void)
{
	if (!prof_self_has_ring())
		return;
	prof_thread *thread = (prof_thread *)stilb_prof_thread_ring;
	stilb_prof_thread_ring = (stilb_prof_ring *)&prof_ring_none;
	prof_thread_leave(thread);
}

/* The name of the calling thread: "main", or the one given by pthread_setname_np. Empty if it is that of the main
 * thread: a thread that was given no name has inherited that one. */
static void prof_self_name(char name[PROF_NAME_MAX])
{
	char main_name[PROF_COMM_MAX + 1] = "";
	memset(name, 0, PROF_NAME_MAX);
	if (gettid() == getpid()) {
		prof_name_copy(name, "main");
		return;
	}
	int file = open("/proc/self/comm", O_RDONLY | O_CLOEXEC);
	if (file >= 0) {
		if (read(file, main_name, PROF_COMM_MAX) < 0)
			main_name[0] = 0;
		close(file);
	}
	main_name[strcspn(main_name, "\n")] = 0;
	if (pthread_getname_np(pthread_self(), name, PROF_COMM_MAX) != 0 || strcmp(name, main_name) == 0)
		memset(name, 0, PROF_NAME_MAX);
}

/* Tries to make the calling thread's ring: at its first event, and after each PROF_REFUSED_TRIES events without memory.
 * False: it has none, and the event is counted. */
static bool prof_self_enter(void)
{
	char name[PROF_NAME_MAX];
	int error = errno; /* kept: the zone may stand between a call that fails and the program's look at errno */
	if (prof_self.inside == 0 && prof_self.refused % PROF_REFUSED_TRIES == 0) {
		prof_self.inside++;
		prof_self_name(name);
		prof_self_begin(name, true);
		prof_self.inside--;
		errno = error;
	}
	if (prof_self_has_ring())
		return true;
	prof_self.refused += prof_self.inside == 0;
	__atomic_add_fetch(&prof.without_ring, 1, __ATOMIC_RELAXED); /* a count: no data depends on it */
	return false;
}

stilb_prof_ring *stilb_prof_ring_enter(uint32_t session)
{
	assert(session != 0 && "something is recorded");
	if (!prof_self_has_ring() && !prof_self_enter())
		return NULL;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	if (ring->session != session) {
		/* Release, in this order: pairs with prof_copy_open_zone. */
		__atomic_store_n(&ring->session, session, __ATOMIC_RELEASE);
		__atomic_store_n(&ring->depth, 0, __ATOMIC_RELEASE);
	}
	return ring;
}

/* ---- all threads ------------------------------------------------------------------------------------------------- */

int stilb_prof_ring_events_set(uint32_t events)
{
	if (events < PROF_RING_EVENTS_MIN || events > PROF_RING_EVENTS_MAX || (events & (events - 1)) != 0)
		return -EINVAL;
	prof_lock();
	prof.ring_events = events;
	prof_unlock();
	return 0;
}

uint32_t prof_ring_count(uint32_t *ended)
{
	assert(ended);
	prof_lock_shared();
	uint32_t count = (uint32_t)prof.count;
	*ended = 0;
	for (uint32_t i = 0; i < count; i++)
		*ended += prof.threads[i]->ended != 0;
	prof_unlock();
	return count;
}

/* Forgets the events of a living thread, which may be recording: its ring stays untouched, and only newer events
 * count. */
static void prof_thread_forget(prof_thread *thread)
{
	assert(prof_self.locked == PROF_LOCKED);
	thread->first = __atomic_load_n(&thread->ring.head, __ATOMIC_RELAXED); /* numbers: no data depends on them */
	thread->first_too_deep = __atomic_load_n(&thread->ring.too_deep, __ATOMIC_RELAXED);
}

void stilb_prof_shutdown(void)
{
	/* Relaxed: no other thread may be in a call of this library but zones. */
	assert(!__atomic_load_n(&prof_frames.hook, __ATOMIC_RELAXED) && "captures have stopped");
	size_t living = 0;
	stilb_prof_thread_end();
	prof_lock();
	for (size_t i = 0; i < prof.count; i++) {
		prof_thread *thread = prof.threads[i];
		if (thread->ended == 0 && !thread->device) {
			prof_thread_forget(thread);
			prof.threads[living++] = thread;
			continue;
		}
		prof_switches_close(&thread->switches);
		munmap(thread, thread->mapping);
	}
	prof.count = living;
	if (living == 0) {
		free(prof.threads);
		prof.threads = NULL;
		prof.capacity = 0;
		prof.made = 0;
	}
	prof.ended = prof.discarded = 0;
	prof.ring_events = PROF_RING_EVENTS;
	__atomic_store_n(&prof.without_ring, 0, __ATOMIC_RELAXED); /* a number: no data depends on it */
	__atomic_store_n(&prof_frames.count, 0, __ATOMIC_RELAXED); /* no other thread marks or reads frames now */
	PROF_CHECK(prof_list_is_sound());
	prof_unlock();
}

/* ---- recording --------------------------------------------------------------------------------------------------- */

void stilb_prof_record_set(bool on)
{
	static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
	static uint32_t sessions = 1; /* so far */
	pthread_mutex_lock(&lock);
	uint32_t session = __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED); /* the lock orders it */
	if (on && session == 0)
		sessions += sessions + 1 != 0 ? 1 : 2;
	/* Relaxed: no data depends on it; pairs with stilb_prof_recorder. */
	__atomic_store_n(&stilb_prof_session, on ? sessions : 0, __ATOMIC_RELAXED);
	pthread_mutex_unlock(&lock);
}

/* The number of zones that are open on the thread now, at an end of a flow; at most 63, which an event can hold. */
static uint32_t prof_flow_level(const stilb_prof_ring *ring)
{
	return ring->depth < STILB_PROF_DEPTH_MAX ? ring->depth : STILB_PROF_DEPTH_MAX - 1;
}

uint64_t stilb_prof_flow_begin(const stilb_prof_site *flow)
{
	assert(flow);
	stilb_prof_ring *ring = flow->kind == STILB_PROF_KIND_FLOW_BEGIN ? stilb_prof_recorder() : NULL;
	if (!ring)
		return 0;
	uint64_t begun = prof_frames_begun();
	uint64_t id = prof_flow_id(begun > 0 ? begun - 1 : 0, ring->lane, ring->flows++);
	stilb_prof_write_at(ring, stilb_prof_site_offset_of(flow), stilb_prof_clock(ring), prof_flow_level(ring), id);
	return id;
}

void stilb_prof_flow_end(const stilb_prof_site *flow, uint64_t id)
{
	assert(flow);
	stilb_prof_ring *ring = id != 0 && flow->kind == STILB_PROF_KIND_FLOW_BEGIN ? stilb_prof_recorder() : NULL;
	if (ring)
		stilb_prof_write_at(ring, stilb_prof_site_offset_of(flow + 1), stilb_prof_clock(ring), prof_flow_level(ring),
		                    id);
}

/* ---- lanes of devices -------------------------------------------------------------------------------------------- */

int stilb_prof_lane_create(const char *name, stilb_prof_lane_handle **lane)
{
	assert(lane);
	char copy[PROF_NAME_MAX];
	prof_name_copy(copy, name && name[0] != 0 ? name : "thread");
	*lane = (stilb_prof_lane_handle *)prof_thread_take(copy, true, false);
	return *lane ? 0 : -ENOMEM;
}

void stilb_prof_lane_zone(stilb_prof_lane_handle *lane, const stilb_prof_site *site, uint32_t depth, uint64_t begin_ns,
                          uint64_t end_ns)
{
	if (!lane || !stilb_prof_is_recording())
		return;
	assert(((const prof_thread *)lane)->device && ((const prof_thread *)lane)->ended == 0 && "the lane lives");
	assert(site && prof_kind_is_zone(site->kind));
	stilb_prof_ring *ring = &((prof_thread *)lane)->ring;
	uint64_t duration = end_ns > begin_ns ? end_ns - begin_ns : 0;
	if (duration > STILB_PROF_DURATION_MAX)
		duration = STILB_PROF_DURATION_MAX;
	if (depth < STILB_PROF_DEPTH_MAX)
		stilb_prof_write_at(ring, stilb_prof_site_offset_of(site), begin_ns, depth, duration);
	else /* a number: no data depends on it */
		__atomic_store_n(&ring->too_deep, ring->too_deep + 1, __ATOMIC_RELAXED);
}

void stilb_prof_lane_destroy(stilb_prof_lane_handle *lane)
{
	if (!lane)
		return;
	assert(((const prof_thread *)lane)->device && "the handle of a lane");
	prof_thread_leave((prof_thread *)lane);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

void stilb_prof_frame_mark(void)
{
	prof_exclusive_begin(&prof_frames.marking);
	uint64_t count = __atomic_load_n(&prof_frames.count, __ATOMIC_RELAXED); /* the thread's own */
	prof_anchor now = prof_clock_anchor();
	prof_anchor *begin = &prof_frames.begin[count % PROF_FRAMES_MAX];
	uint64_t last_ns = prof_frames.begin[(count - 1) % PROF_FRAMES_MAX].ns;
	assert((count == 0 || now.ns >= last_ns) && "frames ascend");
	/* Release, as for events (head of this file): pairs with the loads of prof_frames_copy. */
	__atomic_store_n(&begin->ticks, now.ticks, __ATOMIC_RELEASE);
	__atomic_store_n(&begin->ns, now.ns, __ATOMIC_RELEASE);
	__atomic_store_n(&prof_frames.count, count + 1, __ATOMIC_RELEASE);
	prof_schedstat_mark();
	/* Acquire: pairs with prof_frame_hook_set, so that the hook sees what was initialised before it was set. */
	prof_frame_hook *hook = __atomic_load_n(&prof_frames.hook, __ATOMIC_ACQUIRE);
	if (hook && count > 0)
		hook(count - 1, now.ns - last_ns);
	prof_exclusive_end(&prof_frames.marking);
}

void prof_frame_hook_set(prof_frame_hook *hook)
{
	assert((!hook || !__atomic_load_n(&prof_frames.hook, __ATOMIC_RELAXED)) && "one hook at a time");
	__atomic_store_n(&prof_frames.hook, hook, __ATOMIC_RELEASE); /* pairs with stilb_prof_frame_mark */
}

uint64_t prof_frames_begun(void)
{
	return __atomic_load_n(&prof_frames.count, __ATOMIC_RELAXED); /* no data depends on it */
}

/* Copies the last frame marks, at most max, oldest first; returns how many. *first is the number of frames[0]. */
static uint32_t prof_frames_copy(prof_anchor *frames, uint32_t max, uint64_t *first)
{
	assert(frames && max <= PROF_FRAMES_MAX);
	/* Acquire: pair with stilb_prof_frame_mark; the second count is ordered by the loads before it. */
	uint64_t count = __atomic_load_n(&prof_frames.count, __ATOMIC_ACQUIRE);
	uint64_t oldest = count > max ? count - max : 0;
	for (uint64_t i = oldest; i < count; i++) {
		const prof_anchor *begin = &prof_frames.begin[i % PROF_FRAMES_MAX];
		frames[i - oldest].ticks = __atomic_load_n(&begin->ticks, __ATOMIC_ACQUIRE);
		frames[i - oldest].ns = __atomic_load_n(&begin->ns, __ATOMIC_ACQUIRE);
	}
	uint64_t now = __atomic_load_n(&prof_frames.count, __ATOMIC_RELAXED);
	uint64_t valid = now >= PROF_FRAMES_MAX ? now - PROF_FRAMES_MAX + 1 : 0;
	uint64_t skip = valid <= oldest ? 0 : valid < count ? valid - oldest : count - oldest;
	*first = oldest + skip;
	memmove(frames, frames + skip, (size_t)(count - *first) * sizeof *frames);
	return (uint32_t)(count - *first);
}

uint32_t prof_frames_last(uint64_t *begin_ns, uint32_t max, uint64_t *first)
{
	assert(begin_ns && first);
	prof_anchor frames[PROF_FRAMES_MAX];
	uint32_t count = prof_frames_copy(frames, max < PROF_FRAMES_MAX ? max : PROF_FRAMES_MAX, first);
	for (uint32_t i = 0; i < count; i++)
		begin_ns[i] = frames[i].ns;
	return count;
}

/* ---- copies ------------------------------------------------------------------------------------------------------ */

static stilb_prof_event prof_event_load(const stilb_prof_ring *ring, uint64_t number)
{
	/* Acquire: pair with the stores of stilb_prof_write. */
	const stilb_prof_event *event = &ring->events[number & ring->mask];
	uint64_t begin = __atomic_load_n(&event->begin, __ATOMIC_ACQUIRE);
	return (stilb_prof_event){begin, __atomic_load_n(&event->end, __ATOMIC_ACQUIRE)};
}

/* The number of the oldest event that the writing thread cannot have begun to overwrite. Call it after the events were
 * loaded: their acquire loads order this load of head after them. */
static uint64_t prof_ring_valid(const stilb_prof_ring *ring)
{
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED), size = (uint64_t)ring->mask + 1;
	return head >= size ? head - size + 1 : 0;
}

/* The number of the first event in oldest .. head - 1 that ends at or after begin, by bisection: events are in the
 * order of their ends. */
static uint64_t prof_ring_find(const stilb_prof_ring *ring, uint64_t oldest, uint64_t head, uint64_t begin,
                               uint64_t limit)
{
	assert(oldest <= head);
	uint64_t size = (uint64_t)ring->mask + 1, held = head > size ? head - size : 0;
	uint64_t low = held > oldest ? held : oldest, high = head;
	while (begin > 0 && low < high) {
		uint64_t middle = low + (high - low) / 2;
		stilb_prof_event event = prof_event_load(ring, middle);
		if (middle < prof_ring_valid(ring) || prof_event_unpack(&event, limit).end < begin)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

/* Copies the open zone at depth. False: there is none, or the thread changed it during each of PROF_OPEN_TRIES
 * tries. */
static bool prof_copy_open_zone(const stilb_prof_ring *ring, uint32_t depth, stilb_prof_open_zone *zone)
{
	for (int i = 0; i < PROF_OPEN_TRIES; i++) {
		/* Acquire: pair with stilb_prof_open, stilb_prof_write and stilb_prof_ring_enter; the second loads of session
		 * and head are ordered by them. */
		uint32_t session = __atomic_load_n(&ring->session, __ATOMIC_ACQUIRE);
		uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE);
		if (__atomic_load_n(&ring->depth, __ATOMIC_ACQUIRE) <= depth)
			return false;
		zone->begin = __atomic_load_n(&ring->open[depth].begin, __ATOMIC_ACQUIRE);
		zone->site = __atomic_load_n(&ring->open[depth].site, __ATOMIC_ACQUIRE);
		if (__atomic_load_n(&ring->head, __ATOMIC_RELAXED) == head &&
		    __atomic_load_n(&ring->session, __ATOMIC_RELAXED) == session)
			return true;
	}
	return false;
}

static bool prof_open_is_sound(const stilb_prof_open_zone *zones, uint32_t count)
{
	bool sound = count <= STILB_PROF_DEPTH_MAX;
	for (uint32_t i = 0; sound && i < count; i++)
		sound = zones[i].site && (i == 0 || zones[i - 1].begin <= zones[i].begin);
	return sound;
}

/* Reads the open zones from the deepest one outwards; the thread may end and begin zones meanwhile. If a zone began
 * later than the deeper one that was read before it, the deeper ones have ended meanwhile and are dropped. */
uint32_t prof_copy_open(const stilb_prof_ring *ring, stilb_prof_open_zone *zones)
{
	uint32_t depth = __atomic_load_n(&ring->depth, __ATOMIC_ACQUIRE); /* pairs with stilb_prof_open */
	uint32_t count = 0;
	/* Relaxed: pairs with stilb_prof_record_set. Zones of an earlier session are lost. */
	if (__atomic_load_n(&ring->session, __ATOMIC_RELAXED) != __atomic_load_n(&stilb_prof_session, __ATOMIC_RELAXED))
		return 0;
	for (depth = depth < STILB_PROF_DEPTH_MAX ? depth : STILB_PROF_DEPTH_MAX; depth-- > 0;) {
		stilb_prof_open_zone zone;
		bool whole = prof_copy_open_zone(ring, depth, &zone);
		if (!whole || (count > 0 && zone.begin > zones[depth + 1].begin))
			count = 0;
		if (whole) {
			zones[depth] = zone;
			count++;
		}
	}
	PROF_CHECK(prof_open_is_sound(zones, count));
	return count;
}

/* Appends the ring's events of the window to those of the copy. 0 or -ENOMEM. */
static int prof_copy_events(const prof_thread *thread, prof_copy *copy, prof_lane_copy *lane)
{
	const stilb_prof_ring *ring = &thread->ring;
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE); /* pairs with stilb_prof_write */
	uint64_t begin = lane->device ? copy->begin.ns : copy->begin.ticks;
	uint64_t end = lane->device ? copy->end.ns : copy->end.ticks;
	uint64_t first = prof_ring_find(ring, thread->first, head, begin, lane->limit);
	if (!prof_array_room(&copy->events, sizeof *copy->events, copy->event_count + (size_t)(head - first) + 1,
	                     &copy->event_capacity))
		return -ENOMEM;
	stilb_prof_event *events = copy->events + copy->event_count;
	for (uint64_t i = first; i < head; i++) {
		prof_give_way(i);
		events[i - first] = prof_event_load(ring, i);
	}
	uint64_t valid = prof_ring_valid(ring);
	for (uint64_t i = valid > first ? valid : first; i < head; i++) {
		prof_give_way(i);
		if (end == UINT64_MAX || prof_event_unpack(&events[i - first], lane->limit).begin < end)
			events[lane->event_count++] = events[i - first];
	}
	assert(lane->event_count <= head - first && "no more than there was room for");
	lane->first = copy->event_count;
	copy->event_count += lane->event_count;
	copy->events_recorded += head - thread->first;
	uint64_t held = valid > thread->first ? valid : thread->first;
	copy->events_held += head > held ? head - held : 0;
	return 0;
}

/* Appends the thread's switches since the begin of the window to those of the copy. 0 or -ENOMEM. */
static int prof_copy_switches(const prof_thread *thread, prof_copy *copy, prof_lane_copy *lane)
{
	lane->no_switches = thread->switches.refused;
	if (lane->no_switches)
		return 0;
	if (!prof_array_room(&copy->switches, sizeof *copy->switches, copy->switch_count + PROF_SWITCHES_MAX,
	                     &copy->switch_capacity))
		return -ENOMEM;
	lane->first_switch = copy->switch_count;
	lane->switch_count = prof_switches_copy(&thread->switches, copy->begin.ns, copy->switches + copy->switch_count);
	copy->switch_count += lane->switch_count;
	return 0;
}

static uint64_t prof_lane_now(const prof_lane_copy *lane)
{
	return lane->device ? stilb_prof_clock_monotonic() : prof_clock_now();
}

static int prof_copy_lane(const prof_thread *thread, prof_copy *copy, prof_lane_copy *lane)
{
	assert(prof_self.locked == PROF_SHARED);
	*lane = (prof_lane_copy){
		.device = thread->device,
		.index = thread->ring.lane & 0x3ff,
		.tid = thread->tid,
		.begun_ns = thread->begun_ns,
		.ended_ns = thread->ended_ns,
	};
	memcpy(lane->name, thread->name, PROF_NAME_MAX);
	lane->limit =
		prof_lane_now(lane) + (UINT64_C(1) << 32); /* the clocks of two CPUs may differ a little, and time goes on */
	int error = prof_copy_events(thread, copy, lane);
	if (error == 0)
		error = prof_copy_switches(thread, copy, lane);
	if (!lane->device)
		lane->open_count = prof_copy_open(&thread->ring, lane->open);
	lane->now = prof_lane_now(lane);
	copy->too_deep += __atomic_load_n(&thread->ring.too_deep, __ATOMIC_RELAXED) - thread->first_too_deep; /* a number */
	return error;
}

/* Sets begin, end and the frames of the copy's window; window NULL: all that the rings hold. */
static void prof_copy_window(prof_copy *copy, const stilb_prof_window *window)
{
	uint32_t whole = copy->frame_count > 0 ? copy->frame_count - 1 : 0;
	copy->begin = (prof_anchor){0};
	copy->end = (prof_anchor){UINT64_MAX, UINT64_MAX};
	copy->window_first = 0;
	copy->window_count = whole;
	if (!window)
		return;
	if (window->last_frames > 0 && window->last_frames <= whole) {
		copy->window_count = window->last_frames;
		copy->window_first = whole - window->last_frames;
		copy->begin = copy->frames[copy->window_first];
	} else if (window->last_frames == 0 && window->frame_count > 0) {
		uint64_t from = window->first_frame > copy->first_frame ? window->first_frame - copy->first_frame : 0;
		uint64_t past = window->first_frame + window->frame_count;
		uint64_t to = past > copy->first_frame ? past - copy->first_frame : 0;
		copy->window_first = from < whole ? (uint32_t)from : whole;
		copy->window_count = (to < whole ? (uint32_t)to : whole) - copy->window_first;
		if (to <= from || from >= whole)
			copy->window_count = 0;
		copy->begin = copy->window_count > 0 ? copy->frames[copy->window_first] : copy->end;
		if (copy->window_count > 0)
			copy->end = copy->frames[copy->window_first + copy->window_count];
	}
}

/* For asserts: the events and switches of the lanes follow one another in the copy's arrays, and frames ascend. */
static bool prof_copy_is_sound(const prof_copy *copy)
{
	size_t events = 0, switches = 0;
	bool sound = copy->window_first + copy->window_count <= copy->frame_count && copy->frame_count <= PROF_FRAMES_MAX &&
	             copy->events_held <= copy->events_recorded;
	for (uint32_t i = 0; sound && i < copy->lane_count; i++) {
		const prof_lane_copy *lane = &copy->lanes[i];
		sound = lane->first == events && (lane->switch_count == 0 || lane->first_switch == switches);
		events += lane->event_count;
		switches += lane->switch_count;
	}
	for (uint32_t i = 1; sound && i < copy->frame_count; i++)
		sound = copy->frames[i - 1].ns <= copy->frames[i].ns;
	return sound && events == copy->event_count && switches == copy->switch_count;
}

/* Sets the pointers of the lanes into the arrays, which do not grow, and so do not move, any more. */
static void prof_copy_point(prof_copy *copy)
{
	for (uint32_t i = 0; i < copy->lane_count; i++) {
		copy->lanes[i].events = copy->events + copy->lanes[i].first;
		if (copy->switches)
			copy->lanes[i].switches = copy->switches + copy->lanes[i].first_switch;
	}
}

int prof_copy_take(prof_copy *copy, const stilb_prof_window *window)
{
	int error = 0;
	copy->event_count = copy->switch_count = 0;
	copy->lane_count = 0;
	copy->events_held = copy->too_deep = 0;
	copy->frame_count = prof_frames_copy(copy->frames, PROF_FRAMES_MAX, &copy->first_frame);
	prof_copy_window(copy, window);
	prof_lock_shared();
	copy->events_recorded = prof.discarded;
	copy->without_ring = __atomic_load_n(&prof.without_ring, __ATOMIC_RELAXED); /* a number: no data depends on it */
	if (!prof_array_room(&copy->lanes, sizeof *copy->lanes, prof.count + 1, &copy->lane_capacity))
		error = -ENOMEM;
	while (error == 0 && copy->lane_count < prof.count) {
		uint32_t i = copy->lane_count++;
		error = prof_copy_lane(prof.threads[i], copy, &copy->lanes[i]);
	}
	prof_unlock();
	PROF_CHECK(error != 0 || prof_copy_is_sound(copy));
	if (error == 0)
		prof_copy_point(copy);
	else
		prof_copy_free(copy);
	return error;
}

void prof_copy_free(prof_copy *copy)
{
	free(copy->lanes);
	free(copy->events);
	free(copy->switches);
	*copy = (prof_copy){0};
}
