#include "farm/farm_crew.h"

#include "base/base_contract.h"
#include "farm/farm_schedule.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define CREW_SLEEP_NS 1000000 /* between two looks for messages */
#define CREW_MOST_UNITS 1024u /* in one message */
#define CREW_FAREWELL_S 10.0  /* the host waits for the guests to end */

/* ---- messages ---- */

typedef enum message_kind {
	MESSAGE_HELLO,    /* guest: text is its name, 0, and its identity, or, with `trouble`, why it has none */
	MESSAGE_UNITS,    /* host: `count` of them to compute, each with what there is of its result */
	MESSAGE_RESULTS,  /* guest: `count` of them */
	MESSAGE_STOP,     /* host: no more */
	MESSAGE_FAREWELL, /* guest: its last */
} message_kind;

/* Before each message. UNITS and RESULTS: then uint32_t[count], padded to 8 bytes, numbers of units; then their
 * results. In UNITS the highest bit of a number says that a result, or what there is of it, is in the message; else
 * none is. */
typedef struct message_head {
	uint32_t kind, count, threads, trouble;
	uint64_t notes[STILB_FARM_NOTES]; /* of RESULTS and FAREWELL: what has been added since the last message */
} message_head;

#define MESSAGE_WITH_RESULT 0x80000000u

static size_t numbers_size(uint32_t count)
{
	return ((size_t)count * sizeof(uint32_t) + 7) / 8 * 8;
}

/* ---- the crew ---- */

typedef struct crew_guest {
	char name[64];
	uint32_t threads; /* 0: has not said hello */
	bool wants;       /* has sent something since it was last given units */
	bool gone;        /* has said farewell */
} crew_guest;

struct stilb_farm_crew {
	stilb_farm_crew_desc desc;
	stilb_farm_link link;
	stilb_farm_work work;
	bool has_work;
	pthread_t thread;
	uint64_t started_ns;

	stilb_lock lock;                /* guards the members below */
	bool quit;                      /* end asks the thread to end, once farewells are said */
	bool stopping;                  /* the host has told the guests to end; a guest was told */
	uint64_t stopping_ns, whole_ns; /* since when it is so; whole: all results are there */
	bool finished;
	char trouble[512];

	/* host */
	farm_schedule *schedule;
	crew_guest *guests; /* [link.count]; the first is the host itself */
	uint32_t *here;     /* [desc.threads] units that are computed here now; UINT32_MAX: none */

	/* guest: rings of units */
	uint32_t *queue, *ready; /* [work.unit_count] */
	uint32_t queue_first, queue_count, ready_count;
	uint64_t sent_ns; /* when the last results were sent */
	uint64_t noted[STILB_FARM_NOTES];
	bool told; /* farewell is sent */
};

static double crew_now(const stilb_farm_crew *crew)
{
	return (double)(stilb_time_ns() - crew->started_ns) * 1e-9;
}

static bool crew_is_host(const stilb_farm_crew *crew)
{
	return crew->link.machine == 0;
}

/* A message of that many bytes after its head, or NULL. */
static message_head *message_make(message_kind kind, uint32_t count, size_t size)
{
	message_head *head = calloc(1, sizeof *head + size);
	if (head)
		*head = (message_head){.kind = kind, .count = count};
	return head;
}

/* ---- host: what comes in ----------------------------------------------------------------------------------------- */

static void __attribute__((format(printf, 2, 3))) host_trouble(stilb_farm_crew *crew, const char *format, ...)
{
	STILB_ASSERT_LOCKED(&crew->lock);
	char text[sizeof crew->trouble];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	if (crew->finished) /* nobody needs that machine any more, but its owner should know */
		stilb_log("%s; the others have finished without it", text);
	if (crew->finished || crew->trouble[0])
		return;
	memcpy(crew->trouble, text, sizeof text);
	crew->stopping = true;
	crew->stopping_ns = stilb_time_ns();
	crew->desc.stop(crew->desc.user);
}

/* Says how a guest's identity differs from the host's. */
static void host_refuse(stilb_farm_crew *crew, uint32_t machine, const char *name, const char *identity)
{
	stilb_farm_difference d = {.name = ""};
	stilb_farm_differ(identity, crew->work.identity, &d);
	const char *what = NULL;
	if (strncmp(d.name, "binary ", 7) == 0 || strncmp(d.name, "version ", 8) == 0)
		what = "runs another build of the program; install the same on all machines";
	else if (strncmp(d.name, "scene ", 6) == 0)
		what = "has another scene in that file; copy the same to all machines";
	else if (strncmp(d.name, "cache.load ", 11) == 0)
		what = "has another irradiance cache in that file; copy the same to all machines";
	if (what)
		host_trouble(crew, "rank %" PRIu32 " (%s) %s", machine, name, what);
	else
		host_trouble(crew, "rank %" PRIu32 " (%s) has %.*s %.*s, not %.*s as rank 0%s", machine, name, d.name_length,
		             d.name, d.a_length, d.a ? d.a : "", d.b_length, d.b ? d.b : "",
		             strncmp(d.name, "isa ", 4) == 0 ? "; give all the same --isa" : "");
}

static void host_hello(stilb_farm_crew *crew, uint32_t from, const message_head *head, const char *text, size_t size)
{
	crew_guest *guest = &crew->guests[from];
	size_t name_length = strnlen(text, size);
	const char *rest = name_length + 1 < size ? text + name_length + 1 : "";
	if (size == 0 || text[size - 1] != '\0' || head->threads == 0) {
		host_trouble(crew, "rank %" PRIu32 " does not speak as this program does; run one build on all machines", from);
		return;
	}
	snprintf(guest->name, sizeof guest->name, "%s", text);
	guest->threads = head->threads;
	guest->wants = true;
	if (head->trouble)
		host_trouble(crew, "rank %" PRIu32 " (%s): %s", from, guest->name, rest);
	else if (crew->has_work && strcmp(rest, crew->work.identity) != 0)
		host_refuse(crew, from, guest->name, rest);
}

/* True if a thread here is computing the unit: it alone then writes that. */
static bool host_computes(const stilb_farm_crew *crew, uint32_t unit)
{
	for (uint32_t i = 0; i < crew->desc.threads; i++)
		if (crew->here[i] == unit)
			return true;
	return false;
}

static void host_result(stilb_farm_crew *crew, uint32_t from, uint32_t unit, const char *result)
{
	double now = crew_now(crew);
	if (unit >= crew->work.unit_count)
		host_trouble(crew, "rank %" PRIu32 " (%s) sent a result that nobody asked for", from, crew->guests[from].name);
	else if (host_computes(crew, unit))
		farm_schedule_answer(crew->schedule, from, now);
	else if (farm_schedule_done(crew->schedule, from, unit, now) &&
	         !crew->work.set(crew->work.user, unit, result, true))
		host_trouble(crew, "rank %" PRIu32 " (%s) sent a result with impossible numbers", from,
		             crew->guests[from].name);
}

static void host_results(stilb_farm_crew *crew, uint32_t from, const message_head *head, const char *rest, size_t size)
{
	size_t numbers = numbers_size(head->count);
	if (!crew->has_work || size < numbers || (size - numbers) / crew->work.unit_size != head->count) {
		host_trouble(crew, "rank %" PRIu32 " does not speak as this program does; run one build on all machines", from);
		return;
	}
	const uint32_t *units = (const uint32_t *)rest;
	for (uint32_t i = 0; i < head->count; i++)
		host_result(crew, from, units[i], rest + numbers + (size_t)i * crew->work.unit_size);
	crew->guests[from].wants = true;
}

static void host_take(stilb_farm_crew *crew, uint32_t from, message_head *head, size_t size)
{
	const char *rest = (const char *)(head + 1);
	if (from == 0 || from >= crew->link.count || size < sizeof *head)
		return;
	size -= sizeof *head;
	if (head->kind == MESSAGE_HELLO)
		host_hello(crew, from, head, rest, size);
	else if (head->kind == MESSAGE_RESULTS && crew->guests[from].threads > 0)
		host_results(crew, from, head, rest, size);
	else if (head->kind == MESSAGE_FAREWELL)
		crew->guests[from].gone = true;
	if (head->kind == MESSAGE_RESULTS || head->kind == MESSAGE_FAREWELL)
		crew->desc.count(crew->desc.user, head->notes);
}

/* ---- host: what goes out ----------------------------------------------------------------------------------------- */

/* Gives a guest some units, if it should have more and there are. */
static void host_supply(stilb_farm_crew *crew, uint32_t to)
{
	uint32_t units[CREW_MOST_UNITS];
	crew_guest *guest = &crew->guests[to];
	uint32_t count = farm_schedule_take(crew->schedule, to, guest->threads, crew_now(crew), units, CREW_MOST_UNITS);
	if (count == 0)
		return;
	size_t begun = 0, unit_size = crew->work.unit_size;
	/* What another one is late with, maybe a thread of the host, begins anew: it may be computing it now. */
	for (uint32_t i = 0; i < count; i++)
		if (farm_schedule_is_alone(crew->schedule, units[i]) &&
		    crew->work.state(crew->work.user, units[i]) == STILB_FARM_BEGUN) {
			units[i] |= MESSAGE_WITH_RESULT;
			begun++;
		}
	message_head *head = message_make(MESSAGE_UNITS, count, numbers_size(count) + begun * unit_size);
	if (!head) { /* others may have memory */
		for (uint32_t i = 0; i < count; i++)
			farm_schedule_back(crew->schedule, to, units[i] & ~MESSAGE_WITH_RESULT);
		return;
	}
	char *at = (char *)(head + 1);
	memcpy(at, units, count * sizeof *units);
	at += numbers_size(count);
	for (uint32_t i = 0; i < count; i++)
		if (units[i] & MESSAGE_WITH_RESULT) {
			crew->work.get(crew->work.user, units[i] & ~MESSAGE_WITH_RESULT, at);
			at += unit_size;
		}
	crew->link.send(crew->link.user, to, head, (size_t)(at - (char *)head));
	guest->wants = false;
}

static void host_tell(stilb_farm_crew *crew)
{
	for (uint32_t i = 1; i < crew->link.count; i++) {
		message_head *head = message_make(MESSAGE_STOP, 0, 0);
		if (head)
			crew->link.send(crew->link.user, i, head, sizeof *head);
	}
	crew->told = true;
}

static bool host_is_patient(const stilb_farm_crew *crew, uint64_t since_ns)
{
	double patience = crew->desc.farewell_s > 0.0 ? crew->desc.farewell_s : CREW_FAREWELL_S;
	return (double)(stilb_time_ns() - since_ns) * 1e-9 < patience;
}

/* True if all results are there, and all guests have said who they are: one that does not belong is named even if the
 * others were quick. The farewell would wait for it in any case. */
static bool host_has_finished(stilb_farm_crew *crew)
{
	if (!crew->has_work || !farm_schedule_is_finished(crew->schedule))
		return false;
	if (crew->whole_ns == 0)
		crew->whole_ns = stilb_time_ns();
	bool all = true;
	for (uint32_t i = 1; i < crew->link.count; i++)
		all = all && crew->guests[i].threads > 0;
	return all || !host_is_patient(crew, crew->whole_ns);
}

/* True if all guests are gone, or it is time to go without them. */
static bool host_may_quit(const stilb_farm_crew *crew)
{
	bool all = true;
	for (uint32_t i = 1; i < crew->link.count; i++)
		all = all && crew->guests[i].gone;
	return all || !host_is_patient(crew, crew->stopping_ns);
}

/* After a message, or without one. True: the thread may end. */
static bool host_turn(stilb_farm_crew *crew)
{
	STILB_ASSERT_LOCKED(&crew->lock);
	if (!crew->stopping && host_has_finished(crew))
		crew->finished = true;
	if ((crew->finished || crew->quit || !crew->has_work) && !crew->stopping) {
		crew->stopping = true;
		crew->stopping_ns = stilb_time_ns();
	}
	if (crew->stopping && !crew->told)
		host_tell(crew);
	for (uint32_t i = 1; i < crew->link.count && !crew->stopping; i++)
		if (crew->guests[i].wants)
			host_supply(crew, i);
	return crew->quit && crew->stopping && host_may_quit(crew);
}

/* ---- guest ------------------------------------------------------------------------------------------------------- */

static void guest_hello(stilb_farm_crew *crew)
{
	const char *text = crew->has_work ? crew->work.identity : crew->desc.trouble;
	size_t name = strlen(crew->link.name) + 1, length = strlen(text) + 1;
	message_head *head = message_make(MESSAGE_HELLO, 0, name + length);
	if (!head)
		return;
	head->threads = crew->desc.threads;
	head->trouble = !crew->has_work;
	memcpy(head + 1, crew->link.name, name);
	memcpy((char *)(head + 1) + name, text, length);
	crew->link.send(crew->link.user, 0, head, sizeof *head + name + length);
}

/* Writes what has been counted since the last message. */
static void guest_note(stilb_farm_crew *crew, message_head *head)
{
	uint64_t notes[STILB_FARM_NOTES] = {0};
	crew->desc.count(crew->desc.user, notes);
	for (int i = 0; i < STILB_FARM_NOTES; i++) {
		head->notes[i] = notes[i] - crew->noted[i];
		crew->noted[i] = notes[i];
	}
}

static void guest_flush(stilb_farm_crew *crew)
{
	uint32_t count = crew->ready_count < FARM_FLUSH_UNITS ? crew->ready_count : FARM_FLUSH_UNITS;
	size_t numbers = numbers_size(count), unit_size = crew->work.unit_size;
	message_head *head = message_make(MESSAGE_RESULTS, count, numbers + count * unit_size);
	if (!head)
		return; /* tried again at the next look */
	char *at = (char *)(head + 1);
	memcpy(at, crew->ready, count * sizeof *crew->ready);
	for (uint32_t i = 0; i < count; i++)
		crew->work.get(crew->work.user, crew->ready[i], at + numbers + i * unit_size);
	guest_note(crew, head);
	crew->link.send(crew->link.user, 0, head, sizeof *head + numbers + count * unit_size);
	crew->ready_count -= count;
	memmove(crew->ready, crew->ready + count, crew->ready_count * sizeof *crew->ready);
	crew->sent_ns = stilb_time_ns();
}

/* Takes over units to compute. Several may have the same number, if the host has lost patience with another machine and
 * then with this one. */
static void guest_units(stilb_farm_crew *crew, const message_head *head, size_t size)
{
	size_t numbers = numbers_size(head->count);
	const uint32_t *units = (const uint32_t *)(head + 1);
	const char *at = (const char *)units + numbers, *end = (const char *)(head + 1) + size;
	for (uint32_t i = 0; i < head->count && (size_t)(end - (const char *)units) >= numbers; i++) {
		uint32_t unit = units[i] & ~MESSAGE_WITH_RESULT;
		STILB_ASSERT(unit < crew->work.unit_count);
		if (crew->queue_count == crew->work.unit_count)
			return; /* all of these are in the queue already */
		if (units[i] & MESSAGE_WITH_RESULT) {
			if (crew->work.state(crew->work.user, unit) == STILB_FARM_NEW)
				crew->work.set(crew->work.user, unit, at, false);
			at += crew->work.unit_size;
		}
		crew->queue[(crew->queue_first + crew->queue_count++) % crew->work.unit_count] = unit;
	}
}

static void guest_stopped(stilb_farm_crew *crew)
{
	crew->stopping = crew->finished = true;
	crew->queue_count = crew->ready_count = 0;
	crew->desc.stop(crew->desc.user);
	message_head *head = message_make(MESSAGE_FAREWELL, 0, 0);
	if (!head)
		return;
	guest_note(crew, head);
	crew->link.send(crew->link.user, 0, head, sizeof *head);
}

static void guest_take(stilb_farm_crew *crew, const message_head *head, size_t size)
{
	if (size < sizeof *head || crew->stopping)
		return;
	if (head->kind == MESSAGE_UNITS && crew->has_work)
		guest_units(crew, head, size - sizeof *head);
	else if (head->kind == MESSAGE_STOP)
		guest_stopped(crew);
}

/* After a message, or without one. True: the thread may end. */
static bool guest_turn(stilb_farm_crew *crew)
{
	STILB_ASSERT_LOCKED(&crew->lock);
	double passed = (double)(stilb_time_ns() - crew->sent_ns) * 1e-9;
	if (farm_flush_is_due(crew->ready_count, passed, crew->queue_count, crew->desc.threads, crew->link.count))
		guest_flush(crew);
	return crew->stopping && crew->link.is_sent(crew->link.user);
}

/* ---- the thread -------------------------------------------------------------------------------------------------- */

static void *crew_main(void *data)
{
	stilb_farm_crew *crew = data;
	for (bool end = false; !end;) {
		uint32_t from = 0;
		void *message = NULL;
		size_t size = 0;
		bool received = crew->link.receive(crew->link.user, &from, &message, &size);
		stilb_lock_take(&crew->lock);
		if (received && crew_is_host(crew))
			host_take(crew, from, message, size);
		else if (received)
			guest_take(crew, message, size);
		end = crew_is_host(crew) ? host_turn(crew) : guest_turn(crew);
		stilb_lock_give(&crew->lock);
		free(message);
		if (!end && !received)
			nanosleep(&(struct timespec){.tv_nsec = CREW_SLEEP_NS}, NULL);
	}
	return NULL;
}

/* ---- the feed ---------------------------------------------------------------------------------------------------- */

static stilb_farm_taken host_feed_take(stilb_farm_crew *crew, uint32_t *unit)
{
	uint32_t place = 0;
	while (place < crew->desc.threads && crew->here[place] != UINT32_MAX)
		place++;
	if (place == crew->desc.threads ||
	    farm_schedule_take(crew->schedule, 0, crew->desc.threads, crew_now(crew), unit, 1) == 0)
		return STILB_FARM_LATER;
	crew->here[place] = *unit;
	return STILB_FARM_TAKEN;
}

static stilb_farm_taken guest_feed_take(stilb_farm_crew *crew, uint32_t *unit)
{
	if (crew->queue_count == 0)
		return STILB_FARM_LATER;
	*unit = crew->queue[crew->queue_first];
	crew->queue_first = (crew->queue_first + 1) % crew->work.unit_count;
	crew->queue_count--;
	return STILB_FARM_TAKEN;
}

static stilb_farm_taken crew_feed_take(void *user, uint32_t *unit)
{
	stilb_farm_crew *crew = user;
	stilb_farm_taken taken = STILB_FARM_LATER; /* also while it is stopping: desc.stop ends the computation then */
	stilb_lock_take(&crew->lock);
	if (crew->finished)
		taken = STILB_FARM_NO_MORE;
	else if (!crew->stopping)
		taken = crew_is_host(crew) ? host_feed_take(crew, unit) : guest_feed_take(crew, unit);
	stilb_lock_give(&crew->lock);
	return taken;
}

/* The unit is no longer computed here. */
static void host_leave(stilb_farm_crew *crew, uint32_t unit)
{
	for (uint32_t i = 0; i < crew->desc.threads; i++)
		if (crew->here[i] == unit)
			crew->here[i] = UINT32_MAX;
}

static void crew_feed_done(void *user, uint32_t unit)
{
	stilb_farm_crew *crew = user;
	stilb_lock_take(&crew->lock);
	if (crew_is_host(crew)) {
		host_leave(crew, unit);
		farm_schedule_done(crew->schedule, 0, unit, crew_now(crew));
	} else if (!crew->stopping) {
		crew->ready[crew->ready_count++] = unit;
	}
	stilb_lock_give(&crew->lock);
}

static void crew_feed_back(void *user, uint32_t unit)
{
	stilb_farm_crew *crew = user;
	stilb_lock_take(&crew->lock);
	if (crew_is_host(crew)) {
		host_leave(crew, unit);
		farm_schedule_back(crew->schedule, 0, unit);
	} else if (!crew->stopping) {
		crew->queue[(crew->queue_first + crew->queue_count++) % crew->work.unit_count] = unit;
	}
	stilb_lock_give(&crew->lock);
}

stilb_farm_feed stilb_farm_crew_feed(stilb_farm_crew *crew)
{
	STILB_ASSERT(crew && crew->has_work);
	return (stilb_farm_feed){crew_feed_take, crew_feed_done, crew_feed_back, crew};
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void crew_free(stilb_farm_crew *crew)
{
	farm_schedule_destroy(crew->schedule);
	free(crew->guests);
	free(crew->here);
	free(crew->queue);
	free(crew->ready);
	stilb_lock_finish(&crew->lock);
	free(crew);
}

static bool crew_fill_host(stilb_farm_crew *crew)
{
	crew->guests = calloc(crew->link.count, sizeof *crew->guests);
	crew->here = malloc(crew->desc.threads * sizeof *crew->here);
	crew->schedule = crew->has_work ? farm_schedule_create(crew->work.unit_count, crew->link.count) : NULL;
	if (!crew->guests || !crew->here || (crew->has_work && !crew->schedule))
		return false;
	for (uint32_t i = 0; i < crew->desc.threads; i++)
		crew->here[i] = UINT32_MAX;
	for (uint32_t i = 0; crew->has_work && i < crew->work.unit_count; i++)
		if (crew->work.state(crew->work.user, i) == STILB_FARM_WHOLE)
			farm_schedule_whole(crew->schedule, i);
	return true;
}

static bool crew_fill_guest(stilb_farm_crew *crew)
{
	if (!crew->has_work)
		return true;
	crew->queue = malloc(crew->work.unit_count * sizeof *crew->queue);
	crew->ready = malloc(crew->work.unit_count * sizeof *crew->ready);
	return crew->queue && crew->ready;
}

stilb_result stilb_farm_crew_start(const stilb_farm_crew_desc *desc, stilb_farm_crew **out)
{
	STILB_ASSERT(desc && desc->link && desc->stop && desc->count && out && desc->threads >= 1);
	STILB_ASSERT(desc->work || desc->trouble);
	*out = NULL;
	stilb_farm_crew *crew = calloc(1, sizeof *crew);
	if (!crew || !stilb_lock_init(&crew->lock)) {
		free(crew);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to work with other machines");
	}
	crew->desc = *desc;
	crew->link = *desc->link;
	crew->has_work = desc->work;
	if (desc->work)
		crew->work = *desc->work;
	crew->started_ns = stilb_time_ns();
	if (!(crew_is_host(crew) ? crew_fill_host(crew) : crew_fill_guest(crew))) {
		crew_free(crew);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to work with other machines");
	}
	if (!crew_is_host(crew))
		guest_hello(crew);
	int error = pthread_create(&crew->thread, NULL, crew_main, crew);
	if (error != 0) {
		crew_free(crew);
		return stilb_fail(STILB_ERROR_THREAD, "cannot start a thread: %s", strerror(error));
	}
	*out = crew;
	return STILB_OK;
}

void stilb_farm_crew_hold(stilb_farm_crew *crew)
{
	stilb_lock_take(&crew->lock);
}

void stilb_farm_crew_release(stilb_farm_crew *crew)
{
	stilb_lock_give(&crew->lock);
}

bool stilb_farm_crew_trouble(stilb_farm_crew *crew, char *text, size_t size)
{
	stilb_lock_take(&crew->lock);
	bool trouble = crew->trouble[0];
	if (trouble)
		snprintf(text, size, "%s", crew->trouble);
	stilb_lock_give(&crew->lock);
	return trouble;
}

bool stilb_farm_crew_is_finished(stilb_farm_crew *crew)
{
	stilb_lock_take(&crew->lock);
	bool finished = crew->finished;
	stilb_lock_give(&crew->lock);
	return finished;
}

uint32_t stilb_farm_crew_count(stilb_farm_crew *crew, uint32_t machine)
{
	STILB_ASSERT(crew_is_host(crew) && machine < crew->link.count);
	stilb_lock_take(&crew->lock);
	uint32_t count = crew->schedule ? farm_schedule_count(crew->schedule, machine) : 0;
	stilb_lock_give(&crew->lock);
	return count;
}

bool stilb_farm_crew_end(stilb_farm_crew *crew)
{
	if (!crew)
		return true;
	stilb_lock_take(&crew->lock);
	crew->quit = true;
	stilb_lock_give(&crew->lock);
	pthread_join(crew->thread, NULL);
	bool all = true;
	for (uint32_t i = 1; crew_is_host(crew) && i < crew->link.count; i++)
		all = all && crew->guests[i].gone;
	crew_free(crew);
	return all;
}
