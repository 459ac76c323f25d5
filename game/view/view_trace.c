#include "view_trace.h"

#include "base/base_contract.h"
#include "job_prof/job_prof.h"
#include "profiler/prof.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRACE_SLICE 0.003 /* seconds; a batch of samples that has begun makes it some milliseconds longer */

struct view_trace {
	stilb_owner owner; /* the main thread */
	const stilb_scene *scene;
	stilb_job_pool *shared; /* NULL: it makes a pool of its own, of `workers` threads with its own one */
	uint32_t workers;
	const stilb_gi_intersector *intersector;
	pthread_t thread;
	/* Ends a build of the tree: set by the main thread, and read by threads that build. Relaxed: no other data goes
	 * with it. */
	_Atomic bool give_up;
	pthread_mutex_t lock;
	pthread_cond_t asked; /* the thread has something to do */
	pthread_cond_t idle;  /* it is not busy any more */
	/* Under the lock. */
	view_trace_stage stage;
	stilb_gi_settings settings; /* of the next picture, if one is wanted */
	bool wanted, ending;
	bool again;              /* the picture that was rested goes on */
	bool stale;              /* the scene was edited, or was never read */
	bool held;               /* the scene may be edited: nothing reads it */
	bool busy;               /* the thread reads the scene, or renders a picture of it */
	stilb_gi_render *render; /* the thread's; NULL: there is none */
	stilb_result result;     /* of VIEW_TRACE_FAILED */
	char message[512];
};

/* What the thread has made. */
typedef struct trace_own {
	stilb_job_pool *pool;
	uint32_t caller; /* this thread's index in it */
	stilb_gi_scene *scene;
	uint64_t places; /* the scene's count of moves when it was read */
	bool movable;    /* its models have moved */
} trace_own;

static void trace_fail(view_trace *trace, stilb_result result)
{
	pthread_mutex_lock(&trace->lock);
	trace->stage = VIEW_TRACE_FAILED;
	trace->result = result;
	snprintf(trace->message, sizeof trace->message, "%s", stilb_error_message());
	trace->busy = false;
	pthread_cond_signal(&trace->idle);
	pthread_mutex_unlock(&trace->lock);
}

/* A shared pool without workers has nobody to trace, and this thread may not. */
static stilb_result trace_pool(const view_trace *trace, trace_own *own)
{
	own->caller = STILB_JOB_OUTSIDE;
	own->pool = trace->shared;
	if (trace->shared && stilb_job_pool_worker_count(trace->shared) > 0)
		return STILB_OK;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = trace->workers - 1;
	desc.affinity = STILB_JOB_AFFINITY_NONE;
	desc.hooks = stilb_job_prof_hooks("tracer");
	own->caller = 0;
	int error = stilb_job_pool_create(&desc, &own->pool);
	return error == 0 ? STILB_OK : stilb_fail_threads(trace->workers, -error);
}

/* stilb_gi_scene_desc.give_up */
static bool trace_gives_up(void *user)
{
	view_trace *trace = user;
	return atomic_load_explicit(&trace->give_up, memory_order_relaxed);
}

/* Makes the scene ready for rays, or brings it up to date. Once a model has moved, more moves are expected. */
static stilb_result trace_build(view_trace *trace, trace_own *own)
{
	PROFILE("build the tree");
	stilb_result result = own->pool ? STILB_OK : trace_pool(trace, own);
	if (result != STILB_OK)
		return result;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(own->pool);
	desc.caller = own->caller;
	desc.intersector = trace->intersector;
	desc.give_up = trace_gives_up;
	desc.user = trace;
	stilb_scene_revisions before = trace->scene->revisions;
	own->movable = own->movable || (own->scene && before.places != own->places);
	desc.movable = own->movable;
	result = own->scene ? stilb_gi_scene_update(own->scene, trace->scene, &desc)
	                    : stilb_gi_scene_create(trace->scene, &desc, &own->scene);
	own->places = before.places;
	STILB_ASSERT(before.models == trace->scene->revisions.models && before.places == trace->scene->revisions.places &&
	             before.geometry == trace->scene->revisions.geometry &&
	             before.materials == trace->scene->revisions.materials && "view_trace_hold comes before edits");
	return result;
}

typedef enum trace_task { TRACE_END, TRACE_BUILD, TRACE_PICTURE, TRACE_GO_ON } trace_task;

/* Waits for something to do, and is busy then. */
static trace_task trace_wait(view_trace *trace, stilb_gi_settings *settings)
{
	pthread_mutex_lock(&trace->lock);
	trace->busy = false;
	pthread_cond_signal(&trace->idle);
	while (!trace->ending && (trace->held || !(trace->stale || trace->wanted || trace->again)))
		pthread_cond_wait(&trace->asked, &trace->lock);
	trace_task task = trace->ending   ? TRACE_END
	                  : trace->stale  ? TRACE_BUILD
	                  : trace->wanted ? TRACE_PICTURE
	                                  : TRACE_GO_ON;
	if (task == TRACE_BUILD)
		trace->stale = false;
	if (task == TRACE_PICTURE)
		trace->wanted = false;
	if (task != TRACE_BUILD)
		trace->again = false;
	*settings = trace->settings;
	trace->busy = task != TRACE_END;
	pthread_mutex_unlock(&trace->lock);
	return task;
}

/* Puts a render in place of the one before, which is freed. NULL: none. */
static void trace_publish(view_trace *trace, stilb_gi_render *render)
{
	pthread_mutex_lock(&trace->lock);
	stilb_gi_render *before = trace->render;
	trace->render = render;
	pthread_mutex_unlock(&trace->lock);
	stilb_gi_render_destroy(before);
}

/* Builds the tree, if nobody gives it up. */
static stilb_result trace_ready(view_trace *trace, trace_own *own)
{
	trace_publish(trace, NULL); /* it is of the scene as it was */
	stilb_result result = trace_build(trace, own);
	pthread_mutex_lock(&trace->lock);
	bool given_up = result == STILB_ERROR_GIVEN_UP;
	trace->stale = trace->stale || given_up;
	if (result == STILB_OK && trace->stage == VIEW_TRACE_BUILDING && !trace->stale)
		trace->stage = trace->wanted ? VIEW_TRACE_RENDERING : VIEW_TRACE_WAITING;
	pthread_mutex_unlock(&trace->lock);
	return given_up ? STILB_OK : result;
}

static bool trace_may_run(view_trace *trace)
{
	pthread_mutex_lock(&trace->lock);
	bool may = !trace->wanted && !trace->ending && trace->stage == VIEW_TRACE_RENDERING;
	pthread_mutex_unlock(&trace->lock);
	return may;
}

/* Renders the picture until it is finished or given up. It may also have been stopped for a moment, or before it
 * ran. */
static stilb_result trace_run(view_trace *trace, stilb_gi_render *render)
{
	stilb_result result = STILB_OK;
	stilb_gi_progress progress = {0};
	while (result == STILB_OK && !progress.finished && trace_may_run(trace)) {
		result = stilb_gi_render_run(render);
		stilb_gi_render_progress(render, &progress);
	}
	pthread_mutex_lock(&trace->lock);
	if (progress.finished && !trace->wanted && trace->stage == VIEW_TRACE_RENDERING)
		trace->stage = VIEW_TRACE_FINISHED;
	pthread_mutex_unlock(&trace->lock);
	return result;
}

/* Begins a picture. */
static stilb_result trace_picture(view_trace *trace, const trace_own *own, const stilb_gi_settings *settings)
{
	stilb_gi_render *render;
	trace_publish(trace, NULL);
	stilb_result result = stilb_gi_render_create(own->scene, settings, own->pool, &render);
	if (result != STILB_OK)
		return result;
	stilb_gi_render_share(render, own->caller, TRACE_SLICE);
	trace_publish(trace, render);
	return trace_run(trace, render);
}

static stilb_result trace_do(view_trace *trace, trace_own *own, trace_task task, const stilb_gi_settings *settings)
{
	if (task == TRACE_BUILD)
		return trace_ready(trace, own);
	return task == TRACE_PICTURE ? trace_picture(trace, own, settings) : trace_run(trace, trace->render);
}

static void *trace_main(void *data)
{
	view_trace *trace = data;
	trace_own own = {0};
	stilb_gi_settings settings;
	trace_task task;
	stilb_result result = STILB_OK;
	stilb_prof_thread_begin("tracer");
	while (result == STILB_OK && (task = trace_wait(trace, &settings)) != TRACE_END)
		result = trace_do(trace, &own, task, &settings);
	if (result != STILB_OK)
		trace_fail(trace, result);
	trace_publish(trace, NULL);
	stilb_gi_scene_destroy(own.scene);
	if (own.pool != trace->shared)
		stilb_job_pool_destroy(own.pool);
	stilb_prof_thread_end();
	return NULL;
}

/* ---- the main thread's side -------------------------------------------------------------------------------------- */

/* Signals go to the main thread, and not to this one and those that it starts. */
static int trace_create_thread(view_trace *trace)
{
	sigset_t all, before;
	sigfillset(&all);
	pthread_sigmask(SIG_BLOCK, &all, &before);
	int error = pthread_create(&trace->thread, NULL, trace_main, trace);
	pthread_sigmask(SIG_SETMASK, &before, NULL);
	return error;
}

stilb_result view_trace_start(const stilb_scene *scene, stilb_job_pool *pool, uint32_t workers,
                              const stilb_gi_intersector *intersector, view_trace **out)
{
	STILB_ASSERT(scene && intersector && out && workers >= 1);
	*out = NULL;
	view_trace *trace = calloc(1, sizeof *trace);
	if (!trace)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to trace with");
	stilb_owner_take(&trace->owner);
	trace->scene = scene;
	trace->shared = pool;
	trace->workers = workers;
	trace->intersector = intersector;
	trace->stale = true;
	pthread_mutex_init(&trace->lock, NULL);
	pthread_cond_init(&trace->asked, NULL);
	pthread_cond_init(&trace->idle, NULL);
	int error = trace_create_thread(trace);
	if (error != 0) {
		pthread_cond_destroy(&trace->idle);
		pthread_cond_destroy(&trace->asked);
		pthread_mutex_destroy(&trace->lock);
		free(trace);
		return stilb_fail(STILB_ERROR_THREAD, "no thread to trace with: %s", strerror(error));
	}
	*out = trace;
	return STILB_OK;
}

/* Stops the picture that is being rendered. Under the lock. */
static void trace_stop(view_trace *trace)
{
	if (trace->render)
		stilb_gi_render_stop(trace->render);
}

static bool trace_is_built(const view_trace *trace)
{
	return trace->stage != VIEW_TRACE_BUILDING && trace->stage != VIEW_TRACE_FAILED;
}

void view_trace_look(view_trace *trace, const stilb_gi_settings *settings)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	STILB_ASSERT(!trace->held && "view_trace_follow comes first");
	trace->settings = *settings;
	trace->wanted = true;
	if (trace_is_built(trace))
		trace->stage = VIEW_TRACE_RENDERING;
	trace_stop(trace);
	pthread_cond_signal(&trace->asked);
	pthread_mutex_unlock(&trace->lock);
}

void view_trace_rest(view_trace *trace)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	trace->wanted = trace->again = false;
	if (trace_is_built(trace))
		trace->stage = VIEW_TRACE_WAITING;
	trace_stop(trace);
	pthread_mutex_unlock(&trace->lock);
}

bool view_trace_go_on(view_trace *trace)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	bool there = trace->stage == VIEW_TRACE_WAITING && trace->render && !trace->held && !trace->stale;
	if (there) {
		trace->again = true;
		trace->stage = VIEW_TRACE_RENDERING;
		pthread_cond_signal(&trace->asked);
	}
	pthread_mutex_unlock(&trace->lock);
	return there;
}

void view_trace_hold(view_trace *trace)
{
	STILB_ASSERT_OWNER(trace->owner);
	view_trace_rest(trace);
	atomic_store_explicit(&trace->give_up, true, memory_order_relaxed); /* see struct view_trace */
	pthread_mutex_lock(&trace->lock);
	trace->held = true;
	while (trace->busy)
		pthread_cond_wait(&trace->idle, &trace->lock);
	pthread_mutex_unlock(&trace->lock);
	atomic_store_explicit(&trace->give_up, false, memory_order_relaxed); /* nothing is built before the next call */
}

void view_trace_follow(view_trace *trace)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	STILB_ASSERT(trace->held && "view_trace_hold comes before the edits");
	trace->held = false;
	trace->stale = true;
	if (trace->stage != VIEW_TRACE_FAILED)
		trace->stage = VIEW_TRACE_BUILDING;
	pthread_cond_signal(&trace->asked);
	pthread_mutex_unlock(&trace->lock);
}

view_trace_stage view_trace_state(view_trace *trace, stilb_gi_progress *progress)
{
	STILB_ASSERT_OWNER(trace->owner);
	*progress = (stilb_gi_progress){0};
	pthread_mutex_lock(&trace->lock);
	view_trace_stage stage = trace->stage;
	if (trace->render && !trace->wanted)
		stilb_gi_render_progress(trace->render, progress);
	pthread_mutex_unlock(&trace->lock);
	return stage;
}

stilb_result view_trace_error(view_trace *trace, const char **message)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	STILB_ASSERT(trace->stage == VIEW_TRACE_FAILED);
	stilb_result result = trace->result;
	*message = trace->message; /* it stays as it is after a failure */
	pthread_mutex_unlock(&trace->lock);
	return result;
}

bool view_trace_preview(view_trace *trace, float *rgb)
{
	STILB_ASSERT_OWNER(trace->owner);
	pthread_mutex_lock(&trace->lock);
	bool there = trace->render && !trace->wanted;
	if (there)
		stilb_gi_render_preview(trace->render, rgb);
	pthread_mutex_unlock(&trace->lock);
	return there;
}

void view_trace_end(view_trace *trace)
{
	if (!trace)
		return;
	STILB_ASSERT_OWNER(trace->owner);
	atomic_store_explicit(&trace->give_up, true, memory_order_relaxed); /* see struct view_trace */
	pthread_mutex_lock(&trace->lock);
	trace->ending = true;
	trace_stop(trace);
	pthread_cond_signal(&trace->asked);
	pthread_mutex_unlock(&trace->lock);
	pthread_join(trace->thread, NULL);
	pthread_cond_destroy(&trace->idle);
	pthread_cond_destroy(&trace->asked);
	pthread_mutex_destroy(&trace->lock);
	free(trace);
}
