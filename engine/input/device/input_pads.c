#include "input/device/input_pads.h"
#include "input/device/input_reader_internal.h"
#include "profiler/prof.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <unistd.h>

#define PADS_MAX 32u         /* pads that are plugged in, or whose REMOVED the frame has not taken yet */
#define PADS_GRACE_US 500000 /* time in which udev may still grant permission for a new node */
#define PADS_RETRIES 16u     /* new nodes that wait for permission at a time; further ones are DENIED at once */
#define PADS_NAME_MAX 24u    /* bytes of "hidraw" and a number with its zero */

/* A new node that may not be opened yet, and the time at which it is tried again. */
typedef struct pads_retry {
	char name[PADS_NAME_MAX];
	int64_t due_us;
} pads_retry;

/*
 * The watcher creates a reader and puts it into a slot. The frame takes its events there and, after the last one,
 * empties the slot and puts the reader into the list `returned`; the watcher then destroys it. No thread waits for
 * another.
 */
struct stilb_input_pads {
	/* Set up before the watcher starts, then unchanged until it has ended. */
	stilb_owner owner; /* the frame's thread */
	input_hub hub;
	const input_backend *backend;
	input_roots roots;
	char *root_texts; /* memory of the two strings in `roots` */
	uint64_t ring_bytes;
	pthread_t watcher;
	int inotify_fd, wake_fd;

	/* Atomic; each use says order and partner. */
	input_reader *slots[PADS_MAX];
	input_reader *returned; /* readers whose events were all taken, linked by input_reader.next */
	uint32_t stop;
	uint32_t looked; /* 1 once all pads that were plugged in at the start were found */

	/* The watcher's own. */
	stilb_owner watcher_owner;
	uint32_t number; /* number of the newest pad (stilb_input_event.pad) */
	bool is_crowded; /* a pad was left out for want of a slot: look again when one becomes free */
	uint32_t retry_count;
	pads_retry retries[PADS_RETRIES];

	/* The frame's own. */
	input_reader *held; /* the reader whose event was returned last and is taken in the next call; or NULL */
	stilb_input_event_kind held_kind;
	uint32_t held_slot;
	int64_t last_us; /* time of the event returned last */
	bool has_looked;
};

/* ---- slots ------------------------------------------------------------------------------------------------------- */

static input_reader *pads_slot(const stilb_input_pads *pads, uint32_t i)
{
	/* Acquire: pairs with the release in pads_publish when the frame calls this. The watcher reads what it has stored
	 * itself, or the NULL by which the frame emptied the slot. */
	return __atomic_load_n(&pads->slots[i], __ATOMIC_ACQUIRE);
}

/* Index of an empty slot; PADS_MAX: there is none. Called by the watcher. */
static uint32_t pads_free_slot(const stilb_input_pads *pads)
{
	for (uint32_t i = 0; i < PADS_MAX; i++)
		if (!pads_slot(pads, i))
			return i;
	return PADS_MAX;
}

/* Puts the reader into the slot, where the frame sees it. Called by the watcher. */
static void pads_publish(stilb_input_pads *pads, uint32_t i, input_reader *reader)
{
	STILB_ASSERT(i < PADS_MAX && !pads_slot(pads, i) && reader->number == pads->number);
	__atomic_store_n(&pads->slots[i], reader, __ATOMIC_RELEASE); /* pairs with pads_slot */
	input_hub_tell(&pads->hub);
}

/* Gives a reader whose events were all taken back to the watcher. Called by the frame. */
static void pads_return(stilb_input_pads *pads, uint32_t i)
{
	input_reader *reader = __atomic_load_n(&pads->slots[i], __ATOMIC_RELAXED); /* acquired by pads_slot before */
	STILB_ASSERT(reader && input_reader_has_ended(reader));
	/* Relaxed: the release below orders it, so whoever gets the reader from the list sees the slot empty. */
	__atomic_store_n(&pads->slots[i], (input_reader *)NULL, __ATOMIC_RELAXED);
	reader->next = __atomic_load_n(&pads->returned, __ATOMIC_RELAXED); /* checked by the exchange below */
	/* Release: pairs with pads_reap. Only this thread adds, and pads_reap takes the whole list. */
	while (
		!__atomic_compare_exchange_n(&pads->returned, &reader->next, reader, true, __ATOMIC_RELEASE, __ATOMIC_RELAXED))
		;
	eventfd_write(pads->wake_fd, 1);
}

static void pads_end(input_reader *reader)
{
	if (!reader->denied)
		pthread_join(reader->thread, NULL);
	input_reader_destroy(reader);
}

/* Destroys the readers that the frame gave back. True: there was one. Called by the watcher. */
static bool pads_reap(stilb_input_pads *pads)
{
	/* Acquire: pairs with pads_return. */
	STILB_ASSERT_OWNER(pads->watcher_owner);
	input_reader *first = __atomic_exchange_n(&pads->returned, NULL, __ATOMIC_ACQUIRE);
	for (input_reader *reader = first, *next; reader; reader = next) {
		next = reader->next;
		pads_end(reader);
	}
	return first;
}

/* ---- the watcher: what is plugged in ----------------------------------------------------------------------------- */

/* The reader of the pad at a node, if it has not ended, or NULL. */
static input_reader *pads_find(const stilb_input_pads *pads, const char *name)
{
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		input_reader *reader = pads_slot(pads, i);
		if (reader && !input_reader_has_ended(reader) && strcmp(strrchr(reader->info.path, '/') + 1, name) == 0)
			return reader;
	}
	return NULL;
}

static void pads_deny(stilb_input_pads *pads, uint32_t slot, input_reader *reader)
{
	pads->number++;
	reader->denied = true;
	reader->added_us = input_now_us();
	reader->number = pads->number;
	__atomic_fetch_add(&pads->hub.stats.denied, 1, __ATOMIC_RELAXED); /* no other data depends on it */
	pads_publish(pads, slot, reader);
}

/* Starts the reader and shows it to the frame. After an error, a negative errno, the reader is to be destroyed. */
static int pads_add(stilb_input_pads *pads, uint32_t slot, input_reader *reader)
{
	reader->added_us = input_now_us();
	reader->number = pads->number + 1;
	int error = input_reader_start(reader, pads->ring_bytes);
	if (error != 0)
		return error;
	pads->number++;
	__atomic_fetch_add(&pads->hub.stats.added, 1, __ATOMIC_RELAXED); /* no other data depends on it */
	pads_publish(pads, slot, reader);
	return 0;
}

/* Notes that the node is to be tried again after PADS_GRACE_US. False: too many nodes are waiting. */
static bool pads_wait_for(stilb_input_pads *pads, const char *name)
{
	for (uint32_t i = 0; i < pads->retry_count; i++)
		if (strcmp(pads->retries[i].name, name) == 0)
			return true;
	STILB_ASSERT(strlen(name) < PADS_NAME_MAX);
	if (pads->retry_count == PADS_RETRIES)
		return false;
	pads_retry *retry = &pads->retries[pads->retry_count++];
	snprintf(retry->name, sizeof retry->name, "%s", name);
	retry->due_us = input_now_us() + PADS_GRACE_US;
	return true;
}

static void pads_wait_no_more(stilb_input_pads *pads, const char *name)
{
	for (uint32_t i = 0; i < pads->retry_count; i++)
		if (strcmp(pads->retries[i].name, name) == 0) {
			pads->retry_count--;
			pads->retries[i] = pads->retries[pads->retry_count];
			return;
		}
}

/* Opens the node's device. -ENOTSUP: it is not a gamepad; or another negative errno. */
static int pads_open(const stilb_input_pads *pads, const char *name, input_reader *reader)
{
	int error = input_device_info(&pads->roots, name, &reader->info);
	if (error != 0)
		return error;
	if (stilb_input_layout_find(&reader->info, &reader->layout) != STILB_OK)
		return -ENOTSUP;
	return input_device_open(pads->backend, reader->info.path, &reader->device);
}

/* Brings the frame's view of a node up to date: opens a pad, reports one without permission. has_grace: the node is
 * new, so permission may still come. */
static void pads_look(stilb_input_pads *pads, const char *name, bool has_grace)
{
	PROFILE("pad look");
	STILB_ASSERT_OWNER(pads->watcher_owner);
	input_reader *known = pads_find(pads, name), *reader;
	uint32_t slot = pads_free_slot(pads);
	pads->is_crowded |= slot == PADS_MAX;
	if ((known && !known->denied) || slot == PADS_MAX)
		return;
	int error = input_reader_create(&pads->hub, &reader);
	if (error == 0)
		error = pads_open(pads, name, reader);
	bool is_denied = error == -EACCES || error == -EPERM;
	if (is_denied && (known || (has_grace && pads_wait_for(pads, name)))) {
		input_reader_destroy(reader);
		return;
	}
	pads_wait_no_more(pads, name);
	if (is_denied) {
		pads_deny(pads, slot, reader);
		return;
	}
	if (known) /* the pad was denied before; now it may be opened, or is gone */
		input_reader_end(known, input_now_us());
	if (error == 0)
		error = pads_add(pads, slot, reader);
	if (error == 0)
		return;
	if (error != -ENOTSUP && error != -ENODEV && error != -EIO)
		stilb_log("gamepad at %s/%s cannot be read: %s", pads->roots.dev, name, strerror(-error));
	input_reader_destroy(reader);
}

/* The node is gone. A pad that was opened is ended by its own thread, after its last report. */
static void pads_gone(stilb_input_pads *pads, const char *name)
{
	pads_wait_no_more(pads, name);
	input_reader *known = pads_find(pads, name);
	if (known && known->denied)
		input_reader_end(known, input_now_us());
}

/* Looks at all nodes, and ends the denied pads whose node is gone. */
static void pads_scan(stilb_input_pads *pads)
{
	PROFILE("pads scan");
	char path[PATH_MAX];
	pads->is_crowded = false;
	snprintf(path, sizeof path, "%s/class/hidraw", pads->roots.sys);
	DIR *folder = opendir(path);
	if (!folder && errno != ENOENT)
		stilb_log("gamepads: cannot look into %s: %s", path, strerror(errno));
	for (struct dirent *entry; folder && (entry = readdir(folder));)
		if (input_device_is_hidraw(entry->d_name) && strlen(entry->d_name) < PADS_NAME_MAX)
			pads_look(pads, entry->d_name, false);
	if (folder)
		closedir(folder);
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		input_reader *reader = pads_slot(pads, i);
		if (reader && reader->denied && !input_reader_has_ended(reader) && access(reader->info.path, F_OK) != 0)
			input_reader_end(reader, input_now_us());
	}
}

static void pads_notice(stilb_input_pads *pads, const struct inotify_event *event)
{
	if (event->mask & IN_Q_OVERFLOW) {
		pads_scan(pads);
		return;
	}
	if (event->len == 0 || !input_device_is_hidraw(event->name) || strlen(event->name) >= PADS_NAME_MAX)
		return;
	if (event->mask & (IN_DELETE | IN_MOVED_FROM))
		pads_gone(pads, event->name);
	else
		pads_look(pads, event->name, true);
}

static void pads_notice_all(stilb_input_pads *pads)
{
	_Alignas(struct inotify_event) char bytes[4096];
	ssize_t size;
	while ((size = read(pads->inotify_fd, bytes, sizeof bytes)) > 0)
		for (ssize_t at = 0; at < size;) {
			const struct inotify_event *event = (const struct inotify_event *)(bytes + at);
			pads_notice(pads, event);
			at += (ssize_t)(sizeof *event + event->len);
		}
}

/* Tries the nodes again whose time of grace is over. Returns the milliseconds until the next; -1: there is none. */
static int pads_retry_all(stilb_input_pads *pads)
{
	int64_t now_us = input_now_us(), next_us = INT64_MAX;
	for (uint32_t i = 0; i < pads->retry_count;) {
		pads_retry retry = pads->retries[i];
		if (retry.due_us <= now_us) {
			pads_wait_no_more(pads, retry.name);
			pads_look(pads, retry.name, false);
		} else {
			next_us = retry.due_us < next_us ? retry.due_us : next_us;
			i++;
		}
	}
	return next_us == INT64_MAX ? -1 : (int)((next_us - now_us + 999) / 1000);
}

/* Ends all readers: tells each to stop before it waits for the first, so that they stop at the same time. */
static void pads_end_all(stilb_input_pads *pads)
{
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		input_reader *reader = pads_slot(pads, i);
		if (reader && !reader->denied)
			input_reader_stop(reader);
	}
	pads_reap(pads);
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		input_reader *reader = pads_slot(pads, i);
		if (reader)
			pads_end(reader);
	}
}

static void *pads_watch(void *user)
{
	stilb_input_pads *pads = user;
	stilb_owner_take(&pads->watcher_owner);
	stilb_prof_thread_begin("pads");
	pthread_setname_np(pthread_self(), "pads");
	pads_scan(pads);
	/* Relaxed: input_hub_tell below makes it visible to the frame; read by pads_has_news. */
	__atomic_store_n(&pads->looked, 1, __ATOMIC_RELAXED);
	input_hub_tell(&pads->hub);
	/* Acquire: pairs with stilb_input_pads_destroy, so that the slots are seen as the frame left them. */
	while (__atomic_load_n(&pads->stop, __ATOMIC_ACQUIRE) == 0) {
		struct pollfd fds[2] = {{.fd = pads->inotify_fd, .events = POLLIN}, {.fd = pads->wake_fd, .events = POLLIN}};
		poll(fds, 2, pads_retry_all(pads));
		eventfd_t woken;
		eventfd_read(pads->wake_fd, &woken);
		pads_notice_all(pads);
		if (pads_reap(pads) && pads->is_crowded)
			pads_scan(pads);
	}
	pads_end_all(pads);
	stilb_prof_thread_end();
	return NULL;
}

/* ---- the frame --------------------------------------------------------------------------------------------------- */

/* Removes the event that was returned last from its reader; until now it stayed there for the caller to read. */
static void pads_take(stilb_input_pads *pads)
{
	if (!pads->held)
		return;
	input_reader_take(pads->held, pads->held_kind);
	pads->held = NULL;
	if (pads->held_kind == STILB_INPUT_PAD_REMOVED)
		pads_return(pads, pads->held_slot);
}

bool stilb_input_pads_next(stilb_input_pads *pads, int64_t until_us, stilb_input_event *event)
{
	STILB_ASSERT(pads && event);
	STILB_ASSERT_OWNER(pads->owner);
	pads_take(pads);
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		stilb_input_event first;
		input_reader *reader = pads_slot(pads, i);
		if (!reader || !input_reader_peek(reader, &first) || first.time_us > until_us)
			continue;
		if (!pads->held || first.time_us < event->time_us ||
		    (first.time_us == event->time_us && first.pad < event->pad)) {
			*event = first;
			pads->held = reader;
			pads->held_kind = first.kind;
			pads->held_slot = i;
		}
	}
	if (!pads->held)
		return false;
	/* A report may become visible after a later one of another pad was returned, because readers do not wait for each
	 * other: it gets the later time, so that times do not go back. */
	if (event->time_us < pads->last_us)
		event->time_us = pads->last_us;
	pads->last_us = event->time_us;
	return true;
}

static bool pads_has_news(stilb_input_pads *pads)
{
	if (!pads->has_looked) {
		pads->has_looked = __atomic_load_n(&pads->looked, __ATOMIC_RELAXED) != 0; /* stored by pads_watch */
		return pads->has_looked;
	}
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		stilb_input_event event;
		const input_reader *reader = pads_slot(pads, i);
		if (reader && input_reader_peek(reader, &event))
			return true;
	}
	return false;
}

void stilb_input_pads_wait(stilb_input_pads *pads, int timeout_ms)
{
	STILB_ASSERT(pads && timeout_ms >= 0);
	STILB_ASSERT_OWNER(pads->owner);
	int64_t until_us = input_now_us() + 1000 * (int64_t)timeout_ms;
	pads_take(pads);
	while (true) {
		/* Acquire and release: pairs with input_hub_tell, which says why. */
		__atomic_exchange_n(&pads->hub.waiting, 1, __ATOMIC_ACQ_REL);
		int64_t left_us = until_us - input_now_us();
		if (pads_has_news(pads) || left_us <= 0)
			break;
		struct pollfd arrived = {.fd = pads->hub.arrived_fd, .events = POLLIN};
		poll(&arrived, 1, (int)((left_us + 999) / 1000));
		eventfd_t count;
		eventfd_read(pads->hub.arrived_fd, &count);
	}
	/* An exchange, not a store: a store would break the release sequence of the readers' input_hub_tell. */
	__atomic_exchange_n(&pads->hub.waiting, 0, __ATOMIC_ACQ_REL);
}

/* [0, 1], NaN being 0. */
static float pads_motor(float strength)
{
	return strength > 0.0f ? (strength < 1.0f ? strength : 1.0f) : 0.0f;
}

void stilb_input_pads_rumble(stilb_input_pads *pads, uint32_t pad, float heavy, float light, uint32_t duration_ms)
{
	STILB_ASSERT(pads);
	STILB_ASSERT_OWNER(pads->owner);
	for (uint32_t i = 0; i < PADS_MAX; i++) {
		input_reader *reader = pads_slot(pads, i);
		if (reader && reader->number == pad && !reader->denied)
			input_reader_rumble(reader, pads_motor(heavy), pads_motor(light), duration_ms < 5000 ? duration_ms : 5000);
	}
}

stilb_input_pads_stats stilb_input_pads_stats_get(const stilb_input_pads *pads)
{
	STILB_ASSERT(pads);
	STILB_ASSERT_OWNER(pads->owner);
	const stilb_input_pads_stats *stats = &pads->hub.stats;
	return (stilb_input_pads_stats){
		/* Relaxed: no other data depends on them. */
		.reports = __atomic_load_n(&stats->reports, __ATOMIC_RELAXED),
		.lost = __atomic_load_n(&stats->lost, __ATOMIC_RELAXED),
		.added = __atomic_load_n(&stats->added, __ATOMIC_RELAXED),
		.removed = __atomic_load_n(&stats->removed, __ATOMIC_RELAXED),
		.denied = __atomic_load_n(&stats->denied, __ATOMIC_RELAXED),
		.written = __atomic_load_n(&stats->written, __ATOMIC_RELAXED),
	};
}

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

/* Frees everything; the watcher is not running. */
static void pads_free(stilb_input_pads *pads)
{
	int fds[] = {pads->inotify_fd, pads->wake_fd, pads->hub.arrived_fd};
	for (size_t i = 0; i < sizeof fds / sizeof *fds; i++)
		if (fds[i] >= 0)
			close(fds[i]);
	free(pads->root_texts);
	free(pads);
}

static stilb_result pads_set_up(stilb_input_pads *pads, const stilb_input_pads_desc *desc)
{
	const char *sys = desc->sys ? desc->sys : "/sys", *dev = desc->dev ? desc->dev : "/dev";
	if (asprintf(&pads->root_texts, "%s%c%s", sys, 0, dev) < 0) {
		pads->root_texts = NULL;
		return stilb_fail(STILB_ERROR_MEMORY, "gamepads: out of memory");
	}
	pads->roots = (input_roots){.sys = pads->root_texts, .dev = pads->root_texts + strlen(sys) + 1};
	pads->backend = desc->backend == STILB_INPUT_BACKEND_HIDAPI ? &input_backend_hidapi : &input_backend_hidraw;
	pads->ring_bytes = 16384; /* the smallest ring: room for several of the longest reports */
	while (pads->ring_bytes < 1024 * (uint64_t)(desc->ring_kib > 0 ? desc->ring_kib : 256))
		pads->ring_bytes *= 2;
	pads->inotify_fd = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
	pads->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
	pads->hub.arrived_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
	if (pads->inotify_fd < 0 || pads->wake_fd < 0 || pads->hub.arrived_fd < 0)
		return stilb_fail(STILB_ERROR_DEVICE,
		                  "gamepads: cannot watch %s: %s; see ulimit -n and the sysctl fs.inotify.max_user_instances",
		                  pads->roots.dev, strerror(errno));
	uint32_t events = IN_CREATE | IN_ATTRIB | IN_MOVED_TO | IN_DELETE | IN_MOVED_FROM;
	if (inotify_add_watch(pads->inotify_fd, pads->roots.dev, events) < 0)
		return stilb_fail(STILB_ERROR_DEVICE, "gamepads: cannot watch %s: %s", pads->roots.dev, strerror(errno));
	int error = input_thread_create(&pads->watcher, pads_watch, pads);
	if (error != 0)
		return stilb_fail(STILB_ERROR_THREAD, "gamepads: no thread to watch %s: %s", pads->roots.dev, strerror(-error));
	return STILB_OK;
}

stilb_result stilb_input_pads_create(const stilb_input_pads_desc *desc, stilb_input_pads **pads)
{
	STILB_ASSERT(desc && pads && desc->backend <= STILB_INPUT_BACKEND_HIDAPI);
	*pads = calloc(1, sizeof **pads);
	if (!*pads)
		return stilb_fail(STILB_ERROR_MEMORY, "gamepads: out of memory");
	stilb_owner_take(&(*pads)->owner);
	(*pads)->inotify_fd = (*pads)->wake_fd = (*pads)->hub.arrived_fd = -1;
	stilb_result result = pads_set_up(*pads, desc);
	if (result != STILB_OK) {
		pads_free(*pads);
		*pads = NULL;
	}
	return result;
}

void stilb_input_pads_destroy(stilb_input_pads *pads)
{
	if (!pads)
		return;
	STILB_ASSERT_OWNER(pads->owner);
	__atomic_store_n(&pads->stop, 1, __ATOMIC_RELEASE); /* pairs with pads_watch */
	eventfd_write(pads->wake_fd, 1);
	pthread_join(pads->watcher, NULL);
	pads_free(pads);
}

const char *stilb_input_udev_rule(const stilb_input_pad_info *info, char *text, size_t size)
{
	STILB_ASSERT(info && text && size > 0);
	/* The kernel names a HID device bus:vendor:product.instance, in upper-case hexadecimal, on every bus. */
	snprintf(text, size, "KERNEL==\"hidraw*\", KERNELS==\"*:%04X:%04X.*\", MODE=\"0660\", TAG+=\"uaccess\"",
	         info->vendor, info->product);
	return text;
}
