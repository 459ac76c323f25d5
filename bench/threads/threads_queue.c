/*
 * The worker pool of the article that the suite `threads` repeats (bench_threads.c): the main thread puts every draw
 * into a queue, each worker takes draws out and records them into its own list, and the main thread waits for the
 * workers and replays the lists. Only the queue varies. With several workers the order of the draws depends on timing,
 * as it did in the article, so the stream hash, which depends on the order, is checked only if there is one list.
 *
 *   no-queue          one thread does everything
 *   mutex             a linked list under a mutex
 *   kernel-mutex      the same under a lock that enters the kernel every time, as Windows' mutex objects do
 *   sutter            Herb Sutter's queue, the second that the article tried
 *   stilb-low-lock, stilb-lock-free
 *
 * Workers that find the queue empty look again for a while and then sleep on an event, as in the article; sleeping at
 * once makes no measurable difference. A worker's time from the first push of a frame until the last draw is recorded
 * has three parts: recording; waiting, the time in calls to the queue that returned an item; and the rest, in which the
 * queue was empty. The first two each include one read of the clock for each item, whose cost is subtracted.
 *
 * A draw costs either what it does today or what it did in the article: 50 ms for 20,000 draws on one thread, and 30 ms
 * on two threads with 3.5 ms of replay, so half of a draw's cost lies on each side of the queue.
 */
#include "bench/subjects/queue_subjects.h"
#include "bench/threads/threads_hand.h"
#include "bench/threads/threads_run.h"

#include "jobs/job_sys.h"
#include "profiler/prof.h"

#include <errno.h>
#include <pthread.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <string.h>

#define LINE 128 /* two cache lines: the adjacent-line prefetcher pairs them */
#define MAX_WORKERS 256
#define LOOK_NS 30000            /* a worker looks for work so long before it sleeps, as Stilb's own pool does */
#define PAUSES_BETWEEN_LOOKS 16  /* pause instructions between looks, since a look contends for the queue's lock */
#define HALF_A_DRAW_2009_NS 1250 /* half of 50 ms / 20,000 draws */
#define WARM_UP_FRAMES 3u        /* not measured */

/* ---- events ------------------------------------------------------------------------------------------------------ */

/* What workers without work sleep on; the producer, which is the main thread, wakes one of them for each push. */
typedef struct event {
	/* Number of workers that sleep or are about to. Acquire-release read-modify-writes in event_sleep and event_wake,
	 * which are totally ordered: either the producer, after its push, sees the sleeper, or the sleeper, before its last
	 * look at the queue, sees the push. */
	alignas(LINE) _Atomic uint32_t sleepers;
	alignas(LINE) pthread_mutex_t mutex;
	pthread_cond_t changed;
	uint32_t tickets; /* number of sleepers that may wake up; under mutex */
	bool closed;
} event;

static void event_sleep(event *e, stilb_job_queue *queue, uint32_t thread)
{
	PROFILE("parked");
	atomic_fetch_add_explicit(&e->sleepers, 1, memory_order_acq_rel); /* pairs with event_wake */
	stilb_job_queue_rest(queue, thread);
	if (stilb_job_queue_empty(queue, thread)) {
		pthread_mutex_lock(&e->mutex);
		while (e->tickets == 0 && !e->closed)
			pthread_cond_wait(&e->changed, &e->mutex);
		e->tickets -= e->tickets > 0;
		pthread_mutex_unlock(&e->mutex);
	}
	atomic_fetch_sub_explicit(&e->sleepers, 1, memory_order_relaxed); /* relaxed: a superfluous wake is harmless */
}

static void event_wake(event *e)
{
	uint32_t sleepers = atomic_fetch_add_explicit(&e->sleepers, 0, memory_order_acq_rel); /* pairs with event_sleep */
	if (sleepers == 0)
		return;
	pthread_mutex_lock(&e->mutex);
	if (e->tickets < sleepers) {
		e->tickets++;
		pthread_cond_signal(&e->changed);
	}
	pthread_mutex_unlock(&e->mutex);
}

static void event_close(event *e)
{
	pthread_mutex_lock(&e->mutex);
	e->closed = true;
	pthread_cond_broadcast(&e->changed);
	pthread_mutex_unlock(&e->mutex);
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

/* Reads the clock after all earlier instructions; a plain read may be executed before them. */
static inline uint64_t ticks_then(void)
{
#if defined(__x86_64__)
	uint32_t cpu;
	return __builtin_ia32_rdtscp(&cpu);
#else
	return bench_child_ticks();
#endif
}

/* The least difference of two successive reads of the clock: the cost of one read, in ticks. */
static uint64_t ticks_of_clock(void)
{
	uint64_t least = UINT64_MAX;
	for (int i = 0; i < 1000; i++) {
		uint64_t first = ticks_then(), apart = ticks_then() - first;
		least = apart < least ? apart : least;
	}
	return least;
}

/* ---- workers ----------------------------------------------------------------------------------------------------- */

/* Consecutive draws of a frame. An item without draws ends the frame for the worker that takes it; the main thread
 * pushes one of them for each worker. */
typedef struct item {
	const uint32_t *parts;
	uint32_t count;
} item;

typedef struct pool pool;

typedef struct worker {
	alignas(LINE) pool *pool;
	pthread_t thread;
	uint32_t index;                /* of the worker, and of the command list that it records in each frame */
	stilb_render_context *context; /* that list, while it is recorded; NULL before the frame's first draw */
	uint64_t waited, recorded;     /* ticks since the start that it took to pop items and to record their draws; the
	                                * store to `frames` publishes them to the main thread */
	_Atomic uint32_t frames;       /* frames that it has ended; release, pairs with the acquire in wait_for_all */
} worker;

struct pool {
	threads_hand hand;
	stilb_job_queue *queue;
	event event;
	uint64_t look_ticks;
	uint64_t clock_ticks; /* cost of one read of the clock */
	uint32_t half_a_draw; /* multiplications that stand for preparing a draw, as many for the driver's work; 0: none */
	uint32_t draws_an_item;
	uint32_t worker_count;
	worker workers[MAX_WORKERS];
	stilb_cull_visible visible;
	uint32_t *parts; /* parts of the scene that this frame draws, in order */
	item *items;
	/* Frames that all workers have ended. Release in release_all, pairs with the acquire in end_frame. */
	alignas(LINE) _Atomic uint32_t frames;
};

/* Takes time: each multiplication depends on the one before. */
static void burn(uint32_t multiplications)
{
	uint64_t x = multiplications;
	for (uint32_t i = 0; i < multiplications; i++) {
		x = (x | 1) * UINT64_C(0x9E3779B97F4A7C15);
		__asm__ volatile("" : "+r"(x)); /* keeps the compiler from combining multiplications */
	}
}

/* The number of multiplications that take so many ns, from the fastest of some tries, since disturbances slow it. */
static uint32_t burn_for(double ns)
{
	uint32_t multiplications = 20000;
	uint64_t best = UINT64_MAX;
	for (uint32_t i = 0; i < 50; i++) {
		uint64_t begin = bench_child_now_ns();
		burn(multiplications);
		uint64_t time = bench_child_now_ns() - begin;
		best = time < best ? time : best;
	}
	return (uint32_t)(ns * multiplications / (double)best);
}

static void record_item(const pool *p, stilb_render_context *context, const item *i)
{
	threads_hand_draw_parts(&p->hand, context, i->parts, i->count);
	if (p->half_a_draw)
		burn(i->count * p->half_a_draw);
}

/* A profiler zone from the first item until the queue is empty: a zone for each draw would cost more than the draw. */
STILB_PROF_SITE(site_record, "record", 0);

/* Pops the next item, waiting and sleeping as needed: 0, or -EPIPE if the queue is closed. *since, in ticks: on entry
 * the time now, on return the time at which the successful call began. */
static int take(pool *p, uint32_t thread, void **taken, uint64_t *since)
{
	uint64_t first = *since;
	for (bool looking = false;; looking = true) {
		int error = stilb_job_queue_pop(p->queue, taken, thread);
		if (error != -EAGAIN) {
			if (looking)
				stilb_prof_zone_begin(&site_record);
			return error;
		}
		if (!looking)
			stilb_prof_zone_end();
		if (*since - first > p->look_ticks) {
			event_sleep(&p->event, p->queue, thread);
			first = bench_child_ticks();
		}
		for (int i = 0; i < PAUSES_BETWEEN_LOOKS; i++)
			job_sys_pause();
		*since = bench_child_ticks();
	}
}

static void record(worker *w, const item *i)
{
	pool *p = w->pool;
	if (!w->context)
		w->context = threads_hand_list_begin(&p->hand, w->index);
	if (i->count > 0) {
		record_item(p, w->context, i);
	} else {
		threads_hand_list_end(w->context);
		w->context = NULL;
	}
}

/* Ends the frame for this worker and waits until all have ended it. A worker that continued could take the item that
 * ends the frame for another one. */
static void end_frame(worker *w)
{
	uint32_t turns = 0;
	/* Relaxed: only this worker writes it. */
	uint32_t frames = atomic_load_explicit(&w->frames, memory_order_relaxed) + 1;
	atomic_store_explicit(&w->frames, frames, memory_order_release);               /* pairs with wait_for_all */
	while (atomic_load_explicit(&w->pool->frames, memory_order_acquire) != frames) /* pairs with release_all */
		job_sys_relax(&turns);
}

static void *worker_main(void *data)
{
	worker *w = data;
	pool *p = w->pool;
	void *taken;
	uint64_t since = bench_child_ticks();
	char name[32];
	snprintf(name, sizeof name, "worker %u", w->index + 1);
	stilb_prof_thread_begin(name);
	stilb_prof_zone_begin(&site_record);
	while (take(p, w->index + 1, &taken, &since) == 0) {
		const item *i = taken;
		uint64_t got = ticks_then();
		record(w, i);
		w->waited += got - since;
		since = ticks_then();
		w->recorded += since - got;
		if (i->count == 0) {
			end_frame(w);
			since = ticks_then();
		}
	}
	stilb_prof_thread_end();
	return NULL;
}

/* ---- the main thread --------------------------------------------------------------------------------------------- */

static void open_queue(pool *p, const char *kind)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.thread_count = p->worker_count + 1;
	int error;
	if (strcmp(kind, "sutter") == 0) {
		error = queue_sutter_create(&desc, &p->queue);
	} else if (strcmp(kind, "mutex") == 0) {
		error = queue_mutex_create(&desc, &p->queue);
	} else if (strcmp(kind, "kernel-mutex") == 0) {
		error = queue_kernel_create(&desc, &p->queue);
	} else {
		bool lock_free = strcmp(kind, "stilb-lock-free") == 0;
		desc.kind = lock_free ? STILB_JOB_QUEUE_LOCK_FREE : STILB_JOB_QUEUE_LOW_LOCK;
		error = stilb_job_queue_create(&desc, &p->queue);
	}
	if (error)
		bench_child_fail("cannot create %s: %s", kind, strerror(-error));
}

static void start_workers(pool *p)
{
	pthread_mutex_init(&p->event.mutex, NULL);
	pthread_cond_init(&p->event.changed, NULL);
	p->look_ticks = job_sys_ticks_in(LOOK_NS);
	for (uint32_t i = 0; i < p->worker_count; i++) {
		worker *w = &p->workers[i];
		w->pool = p;
		w->index = i;
		if (pthread_create(&w->thread, NULL, worker_main, w) != 0)
			bench_child_fail("cannot create %u threads", p->worker_count);
	}
}

static void stop_workers(pool *p)
{
	stilb_job_queue_close(p->queue);
	event_close(&p->event);
	for (uint32_t i = 0; i < p->worker_count; i++)
		pthread_join(p->workers[i].thread, NULL);
	stilb_job_queue_destroy(p->queue);
}

/* Spends the time that preparing an item's draws costs the main thread. */
static void prepare(const pool *p, const item *i)
{
	if (p->half_a_draw)
		burn(i->count * p->half_a_draw);
}

static void push(pool *p, item *i)
{
	if (stilb_job_queue_push(p->queue, i, 0) != 0)
		bench_child_fail("out of memory for the queue");
	event_wake(&p->event);
}

static void feed(pool *p, uint32_t items)
{
	PROFILE("feed");
	static item end;
	for (uint32_t i = 0; i < items; i++) {
		prepare(p, &p->items[i]);
		push(p, &p->items[i]);
	}
	for (uint32_t i = 0; i < p->worker_count; i++)
		push(p, &end);
}

static void wait_for_all(pool *p)
{
	PROFILE("wait for the workers");
	/* Relaxed: only this thread writes p->frames. */
	uint32_t turns = 0, frames = atomic_load_explicit(&p->frames, memory_order_relaxed) + 1;
	for (uint32_t i = 0; i < p->worker_count; i++)
		while (atomic_load_explicit(&p->workers[i].frames, memory_order_acquire) != frames) /* pairs with end_frame */
			job_sys_relax(&turns);
}

/* Lets the workers continue with the next frame. */
static void release_all(pool *p)
{
	uint32_t frames = atomic_load_explicit(&p->frames, memory_order_relaxed) + 1; /* relaxed: as in wait_for_all */
	atomic_store_explicit(&p->frames, frames, memory_order_release);              /* pairs with end_frame */
}

/* Records the frame on the main thread, without workers. */
static void record_alone(pool *p, uint32_t items)
{
	PROFILE("record");
	stilb_render_context *context = threads_hand_list_begin(&p->hand, 0);
	for (uint32_t i = 0; i < items; i++) {
		prepare(p, &p->items[i]);
		record_item(p, context, &p->items[i]);
	}
	threads_hand_list_end(context);
}

static uint32_t cut_items(pool *p)
{
	PROFILE("list draws");
	uint32_t draws = threads_hand_list(&p->hand, &p->visible, p->parts), items = 0;
	for (uint32_t first = 0; first < draws; first += p->draws_an_item, items++) {
		uint32_t left = draws - first;
		p->items[items] = (item){p->parts + first, left < p->draws_an_item ? left : p->draws_an_item};
	}
	return items;
}

/* Times in ticks, summed over frames. span: from a frame's first push until its last draw is recorded, for each worker;
 * waited, recorded: the parts of span that workers spent in calls of the queue and on recording; feed: the time that
 * the main thread took to push. */
typedef struct shares {
	uint64_t span, waited, recorded, feed;
} shares;

static shares worker_ticks(const pool *p)
{
	shares sum = {0};
	for (uint32_t i = 0; i < p->worker_count; i++) {
		sum.waited += p->workers[i].waited;
		sum.recorded += p->workers[i].recorded;
	}
	return sum;
}

static shares record_frame(pool *p, uint32_t items)
{
	shares before = worker_ticks(p);
	uint64_t first = bench_child_ticks();
	feed(p, items);
	uint64_t fed = bench_child_ticks();
	wait_for_all(p);
	uint64_t span = bench_child_ticks() - first;
	shares after = worker_ticks(p);
	release_all(p);
	uint64_t clock = (items + p->worker_count) * p->clock_ticks; /* waited and recorded each include it */
	return (shares){
		.span = span * p->worker_count - 2 * clock,
		.waited = after.waited - before.waited - clock,
		.recorded = after.recorded - before.recorded - clock,
		.feed = fed - first,
	};
}

static shares run_frame(pool *p)
{
	stilb_prof_frame_mark();
	PROFILE("frame");
	shares of_frame = {0};
	threads_hand_cull(&p->hand, &p->visible);
	uint32_t items = cut_items(p);
	threads_hand_begin(&p->hand, p->worker_count > 0 ? p->worker_count : 1);
	if (p->worker_count > 0)
		of_frame = record_frame(p, items);
	else
		record_alone(p, items);
	threads_hand_replay(&p->hand);
	return of_frame;
}

static void print_shares(const shares *sum, double feed_ms)
{
	bench_child_metric("feed", feed_ms);
	double percent = 100.0 / (double)sum->span;
	double waited = percent * (double)sum->waited, recorded = percent * (double)sum->recorded;
	bench_child_metric("recording", recorded);
	bench_child_metric("waiting", waited);
	bench_child_metric("no-work", 100.0 - recorded - waited);
}

/* Verifies the stream hash of a single list; of several lists, whose order depends on timing, the number of draws. */
static void check(const threads_run *run, const pool *p)
{
	uint64_t draws = stilb_render_stats_get(p->hand.render).draws;
	if (p->worker_count <= 1)
		threads_run_check(run, STILB_SCENE_VIEW_ALL, stilb_render_stream_hash(p->hand.render));
	else if (draws != p->hand.scene->part_count)
		bench_child_fail("wrong result: %llu draws instead of %u", (unsigned long long)draws,
		                 p->hand.scene->part_count);
}

static void measure(threads_run *run, pool *p)
{
	threads_series frames = {0};
	shares sum = {0};
	uint64_t ticks = bench_child_ticks(), ns = bench_child_now_ns();
	threads_usage before = threads_usage_now();
	uint32_t all = 0;
	run->calm = WARM_UP_FRAMES;
	for (threads_run_begin(run); !threads_run_over(run, frames.count); all++) {
		uint64_t begin = bench_child_now_ns();
		shares of_frame = run_frame(p);
		double ms = (double)(bench_child_now_ns() - begin) * 1e-6;
		if (!threads_run_frame(run, ms))
			continue;
		threads_series_add(&frames, ms);
		sum.span += of_frame.span;
		sum.waited += of_frame.waited;
		sum.recorded += of_frame.recorded;
		sum.feed += of_frame.feed;
	}
	threads_usage after = threads_usage_now();
	double seconds = (double)(bench_child_now_ns() - ns) * 1e-9;
	double ms_per_tick = 1e3 * seconds / (double)(bench_child_ticks() - ticks);
	check(run, p);
	threads_print_frames(&frames);
	if (p->worker_count > 0)
		print_shares(&sum, (double)sum.feed * ms_per_tick / (double)frames.count);
	bench_child_metric("cpu", (after.cpu_ms - before.cpu_ms) / (double)all);
	bench_child_metric("switched-out", (after.switched_out - before.switched_out) / seconds);
	free(frames.at);
}

void threads_run_queue(threads_run *run, const char *kind, uint32_t workers, bool cost_of_2009, uint32_t draws_an_item)
{
	static pool p;
	bool alone = strcmp(kind, "no-queue") == 0;
	p.worker_count = alone ? 0 : workers < MAX_WORKERS ? workers : MAX_WORKERS;
	p.draws_an_item = draws_an_item;
	p.half_a_draw = cost_of_2009 ? burn_for(HALF_A_DRAW_2009_NS) : 0;
	p.clock_ticks = ticks_of_clock();
	stilb_prof_thread_begin("main");
	threads_hand_open(&p.hand, p.worker_count > 0 ? p.worker_count : 1);
	p.parts = malloc(p.hand.scene->part_count * sizeof *p.parts);
	p.items = malloc(p.hand.scene->part_count * sizeof *p.items);
	if (!p.parts || !p.items)
		bench_child_fail("out of memory for the frame's draws");
	if (!alone) {
		open_queue(&p, kind);
		start_workers(&p);
	}
	measure(run, &p);
	if (!alone)
		stop_workers(&p);
	stilb_cull_visible_finish(&p.visible);
	free(p.parts);
	free(p.items);
	threads_hand_close(&p.hand);
}
