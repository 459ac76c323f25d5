/*
 * A dedicated render thread: one thread owns the renderer, and the main thread sends it every object through a queue
 * (for a single producer and consumer, the fastest kind). The main thread may be a frame ahead.
 *
 *   main    culls a frame, pushes a pointer to the id of each visible model, then the end of the frame
 *   render  pops and records; at the end of the frame it replays and returns the list of ids
 */
#include "bench/threads/threads_hand.h"
#include "bench/threads/threads_run.h"

#include "jobs/job_spsc.h"
#include "jobs/job_sys.h"
#include "profiler/prof.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>

#define FRAMES_IN_FLIGHT 2u
#define WARM_UP_FRAMES 10u /* not measured */

typedef struct dedicated_frame {
	stilb_cull_visible visible;
	uint64_t begin_ns; /* time at which the main thread began the frame */
} dedicated_frame;

typedef struct dedicated {
	threads_run *run;
	threads_hand hand;
	stilb_job_spsc *queue;
	dedicated_frame frames[FRAMES_IN_FLIGHT];
	sem_t free_frames;
	_Atomic bool over;                   /* enough frames measured; relaxed: orders nothing, more are harmless */
	uint32_t frame_count;                /* frames drawn so far, the warm-up included */
	threads_series intervals, latencies; /* written by the render thread, read after it is joined */
} dedicated;

/* Its address is the item that is pushed after the last model of a frame. */
static uint32_t end_of_frame;

static const uint32_t *take_model(dedicated *d)
{
	void *model;
	uint32_t turns = 0;
	int error;
	while ((error = stilb_job_spsc_pop(d->queue, &model)) == -EAGAIN)
		job_sys_relax(&turns);
	return error ? NULL : model;
}

/* Records a frame's models, from this first one to the end of the frame. */
static void record_frame(dedicated *d, const uint32_t *model)
{
	threads_hand_begin(&d->hand, 1);
	PROFILE("record");
	stilb_render_context *context = threads_hand_list_begin(&d->hand, 0);
	for (; model != &end_of_frame; model = take_model(d))
		threads_hand_draw_model(&d->hand, context, *model);
	threads_hand_list_end(context);
}

static void count_frame(dedicated *d, uint64_t begin_ns, uint64_t last_ns)
{
	uint64_t now = bench_child_now_ns();
	double interval = (double)(now - last_ns) * 1e-6;
	if (threads_run_frame(d->run, interval)) {
		threads_series_add(&d->intervals, interval);
		threads_series_add(&d->latencies, (double)(now - begin_ns) * 1e-6);
	}
	if (threads_run_over(d->run, d->intervals.count))
		atomic_store_explicit(&d->over, true, memory_order_relaxed);
}

/* The render thread. The time of a frame is counted from the end of the previous frame to its own end. */
static void *render_main(void *data)
{
	dedicated *d = data;
	stilb_render_own(d->hand.render);
	const uint32_t *model;
	uint64_t last_ns = bench_child_now_ns();
	stilb_prof_thread_begin("render");
	stilb_prof_frame_mark();
	for (; (model = take_model(d)); d->frame_count++) {
		record_frame(d, model);
		threads_hand_replay(&d->hand);
		count_frame(d, d->frames[d->frame_count % FRAMES_IN_FLIGHT].begin_ns, last_ns);
		last_ns = bench_child_now_ns(); /* read again: count_frame may have spent time on writing a timeline */
		stilb_prof_frame_mark();
		sem_post(&d->free_frames);
	}
	stilb_prof_thread_end();
	return NULL;
}

static void feed_frame(dedicated *d, dedicated_frame *frame)
{
	PROFILE("frame");
	frame->begin_ns = bench_child_now_ns();
	threads_hand_cull(&d->hand, &frame->visible);
	PROFILE("feed");
	int error = 0;
	for (uint32_t i = 0; i < frame->visible.count && !error; i++)
		error = stilb_job_spsc_push(d->queue, &frame->visible.ids[i]);
	if (error || stilb_job_spsc_push(d->queue, &end_of_frame) != 0)
		bench_child_fail("out of memory for the queue");
}

static void feed(dedicated *d)
{
	for (uint32_t frame = 0; !atomic_load_explicit(&d->over, memory_order_relaxed); frame++) {
		while (sem_wait(&d->free_frames) != 0) {
		}
		feed_frame(d, &d->frames[frame % FRAMES_IN_FLIGHT]);
	}
	stilb_job_spsc_close(d->queue);
}

void threads_run_dedicated(threads_run *run)
{
	static dedicated d;
	pthread_t render;
	d.run = run;
	threads_hand_open(&d.hand, 1);
	if (stilb_job_spsc_create(&d.queue) != 0)
		bench_child_fail("out of memory for the queue");
	sem_init(&d.free_frames, 0, FRAMES_IN_FLIGHT);
	stilb_prof_thread_begin("main");
	threads_run_begin(run);
	run->calm = WARM_UP_FRAMES;
	threads_usage before = threads_usage_now();
	if (pthread_create(&render, NULL, render_main, &d) != 0)
		bench_child_fail("cannot create a thread");
	feed(&d);
	pthread_join(render, NULL);
	stilb_render_own(d.hand.render);
	threads_usage after = threads_usage_now();
	threads_run_check(run, STILB_SCENE_VIEW_ALL, stilb_render_stream_hash(d.hand.render));
	threads_print_frames(&d.intervals);
	bench_child_metric("latency", threads_series_quantile(&d.latencies, 0.5));
	bench_child_metric("cpu", (after.cpu_ms - before.cpu_ms) / (double)d.frame_count);
	for (uint32_t i = 0; i < FRAMES_IN_FLIGHT; i++)
		stilb_cull_visible_finish(&d.frames[i].visible);
	stilb_job_spsc_destroy(d.queue);
	threads_hand_close(&d.hand);
}
