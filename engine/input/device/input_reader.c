#include "input/device/input_reader_internal.h"
#include "profiler/prof.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define READER_RUMBLE_US 30000 /* least time between two output reports; faster ones hang pads: xpadneo, issue 303 */
/* Time after which rumble is sent again, because a Switch pad stops by itself; SDL repeats every 40 ms, hid-nintendo
 * every 50 ms. */
#define READER_REPEAT_US 40000
#define READER_LATE_MS 5 /* time after which a report that did not fit into the ring tries again */

STILB_PROF_FLOW(reader_flow, "pad report", 0x4fa3d1);

/* ---- between threads --------------------------------------------------------------------------------------------- */

void input_hub_tell(input_hub *hub)
{
	/* A read-modify-write that changes nothing, so that it is ordered with the exchange in stilb_input_pads_wait. If it
	 * comes first, its release and the exchange's acquire make the event visible to the waiter. If it comes second, it
	 * reads that somebody waits. */
	if (__atomic_fetch_or(&hub->waiting, 0, __ATOMIC_ACQ_REL) != 0)
		eventfd_write(hub->arrived_fd, 1);
}

static void hub_count(uint64_t *count)
{
	__atomic_fetch_add(count, 1, __ATOMIC_RELAXED); /* no other data depends on it */
}

int64_t input_now_us(void)
{
	return (int64_t)(stilb_time_ns() / 1000);
}

int input_thread_create(pthread_t *thread, void *(*run)(void *), void *user)
{
	static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};
	sigset_t signals, old;
	sigfillset(&signals);
	for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
		sigdelset(&signals, faults[i]);
	pthread_sigmask(SIG_SETMASK, &signals, &old);
	int error = pthread_create(thread, NULL, run, user);
	pthread_sigmask(SIG_SETMASK, &old, NULL);
	return -error;
}

static bool reader_stops(const input_reader *reader)
{
	return __atomic_load_n(&reader->stop, __ATOMIC_RELAXED) != 0; /* no other data goes with it */
}

void input_reader_stop(input_reader *reader)
{
	STILB_ASSERT(!reader->denied && "there is a thread");
	__atomic_store_n(&reader->stop, 1, __ATOMIC_RELAXED); /* no other data goes with it */
	eventfd_write(reader->wake_fd, 1);
}

void input_reader_end(input_reader *reader, int64_t time_us)
{
	STILB_ASSERT(!input_reader_has_ended(reader) && "a pad goes once");
	reader->ended_us = time_us;
	__atomic_store_n(&reader->ended, 1, __ATOMIC_RELEASE); /* pairs with input_reader_has_ended */
	hub_count(&reader->hub->stats.removed);
	input_hub_tell(reader->hub);
}

bool input_reader_has_ended(const input_reader *reader)
{
	return __atomic_load_n(&reader->ended, __ATOMIC_ACQUIRE) != 0; /* pairs with input_reader_end */
}

/* ---- the motors -------------------------------------------------------------------------------------------------- */

/* The request goes to the reader in one word: bit 63 set, so that it is never 0, and 16 bits each for heavy, light and
 * the duration in milliseconds. */
void input_reader_rumble(input_reader *reader, float heavy, float light, uint32_t duration_ms)
{
	STILB_ASSERT(heavy >= 0.0f && heavy <= 1.0f && light >= 0.0f && light <= 1.0f && duration_ms <= UINT16_MAX);
	uint64_t motors[2] = {(uint64_t)(heavy * 65535.0f + 0.5f), (uint64_t)(light * 65535.0f + 0.5f)};
	/* Relaxed: the word is all the data; taken by motors_fetch. */
	__atomic_store_n(&reader->rumble, UINT64_C(1) << 63 | motors[0] << 32 | motors[1] << 16 | duration_ms,
	                 __ATOMIC_RELAXED);
	eventfd_write(reader->wake_fd, 1);
}

static void motors_fetch(input_reader *reader, int64_t now_us)
{
	uint64_t word =
		__atomic_exchange_n(&reader->rumble, 0, __ATOMIC_RELAXED); /* stored by input_reader_rumble; no other data */
	if (word == 0)
		return;
	reader->motors.heavy = (float)(word >> 32 & 0xffff) / 65535.0f;
	reader->motors.light = (float)(word >> 16 & 0xffff) / 65535.0f;
	reader->motors.until_us = now_us + 1000 * (int64_t)(word & 0xffff);
	reader->motors.is_new = true;
}

static void motors_write(input_reader *reader)
{
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	size_t size = stilb_input_rumble_report(&reader->layout, reader->motors.heavy, reader->motors.light,
	                                        reader->motors.sequence, report);
	reader->motors.is_new = false;
	if (size == 0)
		return;
	PROFILE("pad rumble");
	reader->motors.sequence++;
	reader->motors.moves = reader->motors.heavy > 0.0f || reader->motors.light > 0.0f;
	if (reader->device.backend->write(&reader->device, report, size) >= 0)
		hub_count(&reader->hub->stats.written);
	reader->motors.written_us = input_now_us();
}

/* Time at which the next rumble report is to be written; INT64_MAX: none is to be. */
static int64_t motors_due(const input_reader *reader)
{
	bool repeats = reader->layout.rumble == STILB_INPUT_RUMBLE_SWITCH && reader->motors.until_us != 0;
	if (reader->motors.is_new)
		return reader->motors.written_us + READER_RUMBLE_US;
	return repeats ? reader->motors.written_us + READER_REPEAT_US : INT64_MAX;
}

/* Writes a rumble report if one is due. Returns the time at which to call this again; INT64_MAX: not needed. */
static int64_t motors_update(input_reader *reader, int64_t now_us)
{
	motors_fetch(reader, now_us);
	if (reader->motors.until_us != 0 && now_us >= reader->motors.until_us) {
		reader->motors.heavy = reader->motors.light = 0;
		reader->motors.until_us = 0;
		reader->motors.is_new = true;
	}
	if (now_us >= motors_due(reader))
		motors_write(reader);
	int64_t due_us = motors_due(reader);
	int64_t until_us = reader->motors.until_us != 0 ? reader->motors.until_us : INT64_MAX;
	return due_us < until_us ? due_us : until_us;
}

/* Turns the motors off before the pad is closed: some pads would go on for ever. */
static void motors_stop(input_reader *reader)
{
	int64_t wait_us = reader->motors.written_us + READER_RUMBLE_US - input_now_us();
	if (!reader->motors.moves)
		return;
	if (wait_us > 0)
		usleep((useconds_t)wait_us);
	reader->motors.heavy = reader->motors.light = 0;
	motors_write(reader);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Waits ms milliseconds, or until the reader is told to stop. */
static void reader_pause(const input_reader *reader, int ms)
{
	int64_t until_us = input_now_us() + 1000 * (int64_t)ms;
	for (int left_ms = ms; left_ms > 0 && !reader_stops(reader);) {
		struct pollfd wake = {.fd = reader->wake_fd, .events = POLLIN};
		eventfd_t woken;
		poll(&wake, 1, left_ms);
		eventfd_read(reader->wake_fd, &woken); /* rumble, the other reason to be woken, is dealt with by reader_loop */
		left_ms = (int)((until_us - input_now_us() + 999) / 1000);
	}
}

/* Sends the messages of layout.hello. A pad that does not answer them is read all the same. */
static void reader_hello(input_reader *reader)
{
	PROFILE("pad hello");
	const input_backend *backend = reader->device.backend;
	for (size_t i = 0; i < STILB_INPUT_HELLO_MAX && !reader_stops(reader); i++) {
		const stilb_input_hello *hello = &reader->layout.hello[i];
		uint8_t answer[sizeof hello->bytes];
		if (hello->kind == STILB_INPUT_HELLO_END)
			return;
		STILB_ASSERT(hello->size >= 1 && hello->size <= sizeof answer);
		memcpy(answer, hello->bytes, sizeof answer);
		if (hello->kind == STILB_INPUT_HELLO_GET_FEATURE)
			backend->get_feature(&reader->device, answer, hello->size);
		else
			backend->write(&reader->device, hello->bytes, hello->size);
		reader_pause(reader, hello->pause_ms);
	}
}

/* Moves the report that did not fit into the ring there if it fits now. */
static void reader_retry(input_reader *reader)
{
	input_late *late = &reader->late;
	if (late->size > 0 && input_ring_push(&reader->ring, late->time_us, 0, late->bytes, late->size)) {
		late->size = 0;
		input_hub_tell(reader->hub);
	}
}

/* Stores a report for the frame. If the ring is full, the newest report is kept aside, because it has the present
 * position of the sticks, and the one kept aside before is lost. The arrow that the profiler draws from a report's
 * arrival to the frame that takes it has no end if the report did not fit. */
static void reader_keep(input_reader *reader, int64_t now_us, const uint8_t *report, uint32_t size)
{
	PROFILE("pad report");
	STILB_ASSERT_OWNER(reader->owner);
	STILB_ASSERT(size >= 1 && size <= sizeof reader->late.bytes);
	hub_count(&reader->hub->stats.reports);
	reader_retry(reader);
	if (reader->late.size == 0 &&
	    input_ring_push(&reader->ring, now_us, stilb_prof_flow_begin(reader_flow), report, size)) {
		input_hub_tell(reader->hub);
		return;
	}
	if (reader->late.size > 0)
		hub_count(&reader->hub->stats.lost);
	reader->late.time_us = now_us;
	reader->late.size = size;
	memcpy(reader->late.bytes, report, size);
}

/* Milliseconds to wait for a report, rounded up; -1: without limit. */
static int reader_timeout_ms(const input_reader *reader, int64_t now_us, int64_t motors_us)
{
	int64_t wait_us = motors_us == INT64_MAX ? -1 : motors_us > now_us ? motors_us - now_us : 0;
	if (reader->late.size > 0 && (wait_us < 0 || wait_us > INT64_C(1000) * READER_LATE_MS))
		wait_us = INT64_C(1000) * READER_LATE_MS;
	return wait_us < 0 ? -1 : (int)((wait_us + 999) / 1000);
}

/* Reads until the pad is unplugged or the reader is told to stop. */
static void reader_loop(input_reader *reader)
{
	uint8_t report[STILB_INPUT_REPORT_MAX];
	while (!reader_stops(reader)) {
		int64_t before_us = input_now_us();
		int64_t motors_us = motors_update(reader, before_us);
		int timeout_ms = reader_timeout_ms(reader, before_us, motors_us);
		int size = reader->device.backend->read(&reader->device, reader->wake_fd, timeout_ms, report, sizeof report);
		if (size < 0)
			return;
		if (size > 0) {
			reader_keep(reader, input_now_us(), report, (uint32_t)size);
		} else {
			eventfd_t woken;
			eventfd_read(reader->wake_fd, &woken);
			reader_retry(reader);
		}
	}
	motors_stop(reader);
}

static void *reader_run(void *user)
{
	input_reader *reader = user;
	stilb_owner_take(&reader->owner);
	const char *node = strrchr(reader->info.path, '/') + 1;
	char name[80];
	snprintf(name, sizeof name, "pad %s", node);
	stilb_prof_thread_begin(name);
	name[15] = '\0'; /* the kernel's names have at most 15 characters */
	pthread_setname_np(pthread_self(), name);
	reader_hello(reader);
	reader_loop(reader);
	/* Before the node is closed, because from then on the kernel may give its name to the next pad, and by then the
	 * watcher must know that this one has ended. */
	input_reader_end(reader, input_now_us());
	reader->device.backend->close(&reader->device);
	stilb_prof_thread_end();
	return NULL;
}

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

int input_reader_create(input_hub *hub, input_reader **reader)
{
	STILB_ASSERT(hub && reader);
	*reader = stilb_memory_alloc(1, sizeof **reader);
	if (!*reader)
		return -ENOMEM;
	memset(*reader, 0, sizeof **reader);
	(*reader)->hub = hub;
	(*reader)->wake_fd = -1;
	return 0;
}

void input_reader_destroy(input_reader *reader)
{
	if (!reader)
		return;
	STILB_ASSERT((!reader->announced || reader->denied || input_reader_has_ended(reader)) && "nobody reads it");
	input_ring_finish(&reader->ring);
	if (reader->wake_fd >= 0)
		close(reader->wake_fd);
	free(reader);
}

int input_reader_start(input_reader *reader, uint64_t ring_bytes)
{
	STILB_ASSERT(reader->device.backend && !reader->denied && reader->number != 0);
	int error = input_ring_init(&reader->ring, ring_bytes, STILB_INPUT_REPORT_MAX);
	if (error == 0 && (reader->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) < 0)
		error = -errno;
	if (error == 0)
		error = input_thread_create(&reader->thread, reader_run, reader);
	if (error != 0)
		reader->device.backend->close(&reader->device);
	return error;
}

/* ---- the frame's side -------------------------------------------------------------------------------------------- */

bool input_reader_peek(const input_reader *reader, stilb_input_event *event)
{
	*event = (stilb_input_event){.pad = reader->number, .info = &reader->info};
	if (!reader->announced) {
		event->kind = reader->denied ? STILB_INPUT_PAD_DENIED : STILB_INPUT_PAD_ADDED;
		event->time_us = reader->added_us;
		return true;
	}
	/* Asked before the ring is read: if the reader has ended, its last reports are in the ring by now. */
	bool has_ended = input_reader_has_ended(reader);
	const input_record *record = reader->denied ? NULL : input_ring_peek(&reader->ring);
	if (record) {
		event->kind = STILB_INPUT_PAD_REPORT;
		event->time_us = record->time_us;
		event->bytes = record->bytes;
		event->size = record->size;
	} else if (has_ended && reader->late.size > 0) {
		event->kind = STILB_INPUT_PAD_REPORT;
		event->time_us = reader->late.time_us;
		event->bytes = reader->late.bytes;
		event->size = reader->late.size;
	} else if (has_ended) {
		event->kind = STILB_INPUT_PAD_REMOVED;
		event->time_us = reader->ended_us;
	}
	return record || has_ended;
}

void input_reader_take(input_reader *reader, stilb_input_event_kind kind)
{
	STILB_ASSERT(reader->announced == (kind == STILB_INPUT_PAD_REPORT || kind == STILB_INPUT_PAD_REMOVED));
	reader->announced = true;
	if (kind != STILB_INPUT_PAD_REPORT)
		return;
	const input_record *record = input_ring_peek(&reader->ring);
	if (!record) {
		reader->late.size = 0;
		return;
	}
	/* A zone of its own, and a short one, for the end of the arrow: the profiler counts the zone in which an arrow ends
	 * for the frame in which the arrow began. */
	PROFILE("pad report");
	stilb_prof_flow_end(reader_flow, record->flow);
	input_ring_pop(&reader->ring);
}
