/* What threads write: each thread has a slot of its own and appends records to chunks, of which the frame's thread
 * reads what is there; nobody waits for anybody. */
#include "debug/debug_internal.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* ---- threads ----------------------------------------------------------------------------------------------------- */

/* The numbers of the process' threads that draw: a thread takes one with its first call and gives it back when it ends.
 * The next one with the number goes on in the slots where it stopped. */
#define THREAD_WORDS (STILB_DEBUG_THREADS / 64)
static _Atomic uint64_t thread_taken[THREAD_WORDS]; /* a bit for each */
static _Atomic uint32_t thread_count;               /* the largest number so far, + 1 */

/* The calling thread's, + 1; 0: it has none. Without a call in shared objects. */
static __thread uint32_t thread_mine __attribute__((tls_model("initial-exec")));

/* A key whose destructor runs when a thread ends. */
static struct {
	pthread_once_t once;
	pthread_key_t key;
	bool works;
} thread_exit = {.once = PTHREAD_ONCE_INIT};

static void thread_number_give(uint32_t number)
{
	/* Release: partner of the acquire in thread_number_take; the slots are as this thread has left them. */
	atomic_fetch_and_explicit(&thread_taken[number / 64], ~((uint64_t)1 << number % 64), memory_order_release);
}

static void thread_exit_run(void *unused)
{
	(void)unused;
	if (thread_mine > 0)
		thread_number_give(thread_mine - 1);
	thread_mine = 0;
}

static void thread_exit_make(void)
{
	thread_exit.works = pthread_key_create(&thread_exit.key, thread_exit_run) == 0;
}

/* Runs before this code is unloaded (dlclose): threads that end later must not call thread_exit_run. */
__attribute__((destructor)) static void thread_exit_delete(void)
{
	pthread_once(&thread_exit.once, thread_exit_make); /* waits for a thread that is making it */
	if (thread_exit.works)
		pthread_key_delete(thread_exit.key);
}

/* Takes the lowest free number; STILB_DEBUG_THREADS: there is none. */
static uint32_t thread_number_take(void)
{
	for (uint32_t w = 0; w < THREAD_WORDS; w++) {
		/* Relaxed: the exchange below decides. */
		uint64_t taken = atomic_load_explicit(&thread_taken[w], memory_order_relaxed);
		while (taken != UINT64_MAX) {
			uint32_t bit = (uint32_t)__builtin_ctzll(~taken);
			/* Acquire: partner of the release in thread_number_give. */
			if (atomic_compare_exchange_weak_explicit(&thread_taken[w], &taken, taken | (uint64_t)1 << bit,
			                                          memory_order_acquire, memory_order_relaxed))
				return w * 64 + bit;
		}
	}
	return STILB_DEBUG_THREADS;
}

/* Gives the calling thread a number. False: no memory, or there are too many. */
static bool thread_join(stilb_debug *debug)
{
	uint32_t number = thread_number_take();
	if (number == STILB_DEBUG_THREADS) {
		atomic_store_explicit(&debug->too_many, true, memory_order_relaxed); /* see its declaration */
		return false;
	}
	pthread_once(&thread_exit.once, thread_exit_make);
	if (!thread_exit.works || pthread_setspecific(thread_exit.key, &thread_exit) != 0) {
		thread_number_give(number);
		return false;
	}
	/* Relaxed: the frame that must see this thread's records is ordered after it by the program, and others may not. */
	uint32_t count = atomic_load_explicit(&thread_count, memory_order_relaxed);
	while (count <= number && !atomic_compare_exchange_weak_explicit(&thread_count, &count, number + 1,
	                                                                 memory_order_relaxed, memory_order_relaxed))
		;
	thread_mine = number + 1;
	return true;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Appends an empty chunk to the list; false: no memory. */
static bool list_grow(stilb_debug *debug, debug_list *list)
{
	stilb_lock_take(&debug->lock);
	debug_chunk *chunk = debug->unused;
	if (chunk)
		debug->unused = chunk->unused;
	stilb_lock_give(&debug->lock);
	if (!chunk)
		chunk = stilb_memory_alloc(1, sizeof *chunk);
	if (!chunk)
		return false;
	/* Relaxed: nobody sees the chunk yet. */
	atomic_store_explicit(&chunk->next, NULL, memory_order_relaxed);
	atomic_store_explicit(&chunk->count, 0, memory_order_relaxed);
	/* Release: partner of the acquires in list_take. */
	atomic_store_explicit(list->last ? &list->last->next : &list->first, chunk, memory_order_release);
	list->last = chunk;
	list->used = 0;
	return true;
}

/* Where the list's next record goes; NULL: no memory. */
static inline debug_record *list_room(stilb_debug *debug, debug_list *list)
{
	if (__builtin_expect((!list->last || list->used == DEBUG_CHUNK) && !list_grow(debug, list), 0))
		return NULL;
	return &list->last->records[list->used];
}

/* So many records have been written there. */
static inline void list_publish(debug_list *list, uint32_t count)
{
	list->used += count;
	/* Release: partner of the acquire in list_take. */
	atomic_store_explicit(&list->last->count, list->used, memory_order_release);
}

static void debug_failed(stilb_debug *debug)
{
	atomic_store_explicit(&debug->failed, true, memory_order_relaxed); /* see its declaration */
}

/* Appends records; false: no memory. */
static bool list_put(stilb_debug *debug, debug_list *list, const debug_record *records, uint32_t count)
{
	for (uint32_t some; count > 0; records += some, count -= some) {
		debug_record *to = list_room(debug, list);
		if (!to)
			return false;
		some = count < DEBUG_CHUNK - list->used ? count : DEBUG_CHUNK - list->used;
		memcpy(to, records, some * sizeof *records);
		list_publish(list, some);
	}
	return true;
}

/* The same, each followed by how long it stays. A chunk has an even number. */
static bool list_put_staying(stilb_debug *debug, debug_list *list, const debug_record *records, uint32_t count,
                             float seconds)
{
	for (uint32_t r = 0; r < count; r++) {
		debug_record *to = list_room(debug, list);
		if (!to)
			return false;
		to[0] = records[r];
		to[1] = (debug_record){.from = {seconds}};
		list_publish(list, 2);
	}
	return true;
}

void debug_put(stilb_debug *debug, const debug_record *records, uint32_t count, float seconds)
{
	STILB_ASSERT(debug && seconds >= 0.0f);
	bool done = thread_mine > 0 || thread_join(debug);
	if (done) {
		debug_slot *slot = &debug->slots[thread_mine - 1];
		done = seconds > 0.0f ? list_put_staying(debug, &slot->stays, records, count, seconds)
		                      : list_put(debug, &slot->once, records, count);
	}
	if (!done)
		debug_failed(debug);
}

/* The most frequent call: its record is written where it stays, member by member. Copied from a variable it would be
 * read in wider pieces than it was written, for which the CPU waits. */
void stilb_debug_line(stilb_debug *debug, const float from[3], const float to[3], stilb_debug_style style)
{
	STILB_ASSERT(debug);
	uint32_t word = debug_word(style);
	if (__builtin_expect(thread_mine > 0 && style.seconds == 0.0f, 1)) {
		debug_list *list = &debug->slots[thread_mine - 1].once;
		debug_record *out = list_room(debug, list);
		if (out) {
			*out = debug_line_of(from, to, style.rgba, word);
			list_publish(list, 1);
		} else {
			debug_failed(debug);
		}
		return;
	}
	debug_record record = debug_line_of(from, to, style.rgba, word);
	debug_put(debug, &record, 1, style.seconds);
}

/* ---- taking ------------------------------------------------------------------------------------------------------ */

/* Takes what the list has beyond what was taken before, as blocks. A chunk that its thread has left is added to *done.
 * False: no memory. */
static bool list_take(debug_list *list, debug_blocks *blocks, debug_chunk **done)
{
	/* Acquire: partner of the release in list_grow. */
	debug_chunk *chunk = list->read ? list->read : atomic_load_explicit(&list->first, memory_order_acquire);
	while (chunk) {
		/* Acquire: partner of the release in list_publish; the records are there. */
		uint32_t count = atomic_load_explicit(&chunk->count, memory_order_acquire);
		if (count > list->taken && !debug_blocks_add(blocks, chunk->records + list->taken, count - list->taken))
			return false;
		list->read = chunk;
		list->taken = count;
		if (count < DEBUG_CHUNK)
			return true;
		/* Acquire: partner of the release in list_grow. */
		debug_chunk *next = atomic_load_explicit(&chunk->next, memory_order_acquire);
		if (!next)
			return true;
		chunk->unused = *done;
		*done = chunk;
		list->read = chunk = next;
		list->taken = 0;
	}
	return true;
}

bool debug_take(stilb_debug *debug)
{
	/* Relaxed: see thread_join. */
	uint32_t count = atomic_load_explicit(&thread_count, memory_order_relaxed);
	bool done = true;
	for (uint32_t t = 0; t < count && done; t++)
		done = list_take(&debug->slots[t].once, &debug->once, &debug->done) &&
		       list_take(&debug->slots[t].stays, &debug->stays, &debug->done);
	return done;
}

void debug_give(stilb_debug *debug)
{
	debug->once.count = debug->stays.count = 0;
	if (!debug->done)
		return;
	debug_chunk *last = debug->done;
	while (last->unused)
		last = last->unused;
	stilb_lock_take(&debug->lock);
	last->unused = debug->unused;
	debug->unused = debug->done;
	stilb_lock_give(&debug->lock);
	debug->done = NULL;
}

bool debug_blocks_add(debug_blocks *blocks, const debug_record *records, uint32_t count)
{
	STILB_ASSERT(count > 0 && count <= DEBUG_CHUNK);
	if (!debug_reserve((void **)&blocks->blocks, &blocks->capacity, (uint64_t)blocks->count + 1,
	                   sizeof *blocks->blocks))
		return false;
	blocks->blocks[blocks->count++] = (debug_block){.records = records, .count = count};
	return true;
}

bool debug_reserve(void **data, uint32_t *capacity, uint64_t count, size_t element)
{
	if (count <= *capacity)
		return true;
	uint64_t larger = count + count / 2;
	void *grown = larger <= UINT32_MAX ? realloc(*data, larger * element) : NULL;
	if (!grown)
		return false;
	*data = grown;
	*capacity = (uint32_t)larger;
	return true;
}

/* ---- life cycle -------------------------------------------------------------------------------------------------- */

stilb_result stilb_debug_create(stilb_render *render, stilb_debug **out)
{
	STILB_ASSERT(render && out);
	*out = NULL;
	stilb_debug *debug = stilb_memory_alloc(1, sizeof *debug);
	if (!debug)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for debug drawing");
	memset(debug, 0, sizeof *debug);
	bool locked = stilb_lock_init(&debug->lock);
	if (!locked || !stilb_lock_init(&debug->fonts_lock)) {
		if (locked)
			stilb_lock_finish(&debug->lock);
		free(debug);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the locks of debug drawing");
	}
	stilb_owner_take(&debug->owner);
	debug->render = render;
	*out = debug;
	return STILB_OK;
}

/* Frees the chunks that are still in the list. No thread draws any more. */
static void list_free(debug_list *list)
{
	/* Relaxed: the program orders all calls before this one. */
	debug_chunk *chunk = list->read ? list->read : atomic_load_explicit(&list->first, memory_order_relaxed);
	for (debug_chunk *next; chunk; chunk = next) {
		next = atomic_load_explicit(&chunk->next, memory_order_relaxed);
		free(chunk);
	}
}

void stilb_debug_destroy(stilb_debug *debug)
{
	if (!debug)
		return;
	STILB_ASSERT_OWNER(debug->owner);
	debug_device_finish(debug);
	for (uint32_t t = 0; t < STILB_DEBUG_THREADS; t++) {
		list_free(&debug->slots[t].once);
		list_free(&debug->slots[t].stays);
	}
	debug_give(debug);
	for (debug_chunk *chunk = debug->unused, *next; chunk; chunk = next) {
		next = chunk->unused;
		free(chunk);
	}
	free(debug->once.blocks);
	free(debug->stays.blocks);
	free(debug->kept);
	free(debug->ends);
	free(debug->items);
	free(debug->spare);
	ui_fonts_finish(&debug->fonts);
	stilb_lock_finish(&debug->fonts_lock);
	stilb_lock_finish(&debug->lock);
	free(debug);
}
