#include "render_work.h"

#include "base/base_contract.h"
#include "base/base_file.h"
#include "engine.h"
#include "gi/gi_farm.h"
#include "job_prof/job_prof.h"
#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"
#include "profiler/prof_trace.h"
#include "render_progress.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WORK_RING_EVENTS (1u << 22) /* events in the profile of each thread, 16 bytes each: 64 MiB */

struct offline_work {
	const offline_options *options;
	offline_crew *crew;
	stilb_owner owner; /* the thread that started the work */
	pthread_t thread;
	offline_result result; /* written by the thread; read after it has ended */

	pthread_mutex_t lock; /* guards the members below */
	offline_stage stage;
	stilb_gi_render *render; /* NULL before and after rendering */
	bool stop;               /* end the work */
	bool pause;              /* interrupt the render for a checkpoint */
};

/* Everything that one run owns. Only the work's thread uses it. */
typedef struct work_pieces {
	offline_work *work;
	const offline_options *options;
	offline_crew *crew;
	offline_result *result;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi_scene;
	stilb_gi_render *render;
	bool warned;             /* printed that a checkpoint could not be written */
	char *output;            /* the picture's file; NULL: none */
	stilb_post_table *grade; /* NULL: none */
} work_pieces;

static double work_seconds_since(uint64_t start)
{
	return (double)(stilb_time_ns() - start) * 1e-9;
}

/* ---- shared with the main thread --------------------------------------------------------------------------------- */

static void work_enter(offline_work *work, offline_stage stage)
{
	pthread_mutex_lock(&work->lock);
	STILB_ASSERT((stage >= work->stage || work->options->frames) && "the stages follow one another");
	work->stage = stage;
	pthread_mutex_unlock(&work->lock);
}

static void work_publish(offline_work *work, stilb_gi_render *render)
{
	pthread_mutex_lock(&work->lock);
	work->render = render;
	pthread_mutex_unlock(&work->lock);
}

static bool work_is_stopped(offline_work *work)
{
	pthread_mutex_lock(&work->lock);
	bool stop = work->stop;
	pthread_mutex_unlock(&work->lock);
	return stop;
}

/* True, once, if the render was interrupted for a checkpoint and not to end it. */
static bool work_take_pause(offline_work *work)
{
	pthread_mutex_lock(&work->lock);
	bool pause = work->pause && !work->stop;
	work->pause = false;
	pthread_mutex_unlock(&work->lock);
	return pause;
}

offline_stage offline_work_look(offline_work *work, stilb_gi_progress *progress)
{
	STILB_ASSERT_OWNER(work->owner);
	*progress = (stilb_gi_progress){0};
	pthread_mutex_lock(&work->lock);
	if (work->render)
		stilb_gi_render_progress(work->render, progress);
	offline_stage stage = work->stage;
	pthread_mutex_unlock(&work->lock);
	return stage;
}

bool offline_work_preview(offline_work *work, float *rgb, float *exposure, uint32_t *tone)
{
	STILB_ASSERT_OWNER(work->owner);
	pthread_mutex_lock(&work->lock);
	bool there = work->render;
	if (there) {
		stilb_gi_render_preview(work->render, rgb);
		*exposure = work->result.settings.exposure; /* written before the render was published */
		*tone = work->result.settings.tone;
	}
	pthread_mutex_unlock(&work->lock);
	return there;
}

void offline_work_stop(offline_work *work)
{
	STILB_ASSERT_OWNER(work->owner);
	pthread_mutex_lock(&work->lock);
	work->stop = true;
	if (work->render && work->stage == RENDER_RENDERING)
		stilb_gi_render_stop(work->render);
	pthread_mutex_unlock(&work->lock);
}

void offline_work_checkpoint(offline_work *work)
{
	STILB_ASSERT_OWNER(work->owner);
	pthread_mutex_lock(&work->lock);
	work->pause = true;
	if (work->render && work->stage == RENDER_RENDERING)
		stilb_gi_render_stop(work->render);
	pthread_mutex_unlock(&work->lock);
}

/* ---- failures ---------------------------------------------------------------------------------------------------- */

/* Keeps the error for the main thread, since stilb_error_message gives only errors of the calling thread. Returns
 * false. */
static bool work_fail(work_pieces *p, int code)
{
	p->result->code = code;
	snprintf(p->result->message, sizeof p->result->message, "%s", stilb_error_message());
	return false;
}

static bool work_good(work_pieces *p, stilb_result result)
{
	return result == STILB_OK || work_fail(p, exit_code_of(result));
}

/* ---- stages ------------------------------------------------------------------------------------------------------ */

static bool work_pool(work_pieces *p)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	uint32_t asked = p->options->workers;
	p->result->workers = asked == FLAG_WORKERS_AUTO ? offline_crew_threads(p->crew) : asked;
	desc.worker_count = p->result->workers - 1; /* the work's thread renders as well */
	desc.affinity = STILB_JOB_AFFINITY_NONE;    /* the machine may be shared: the kernel places the threads */
	desc.hooks = stilb_job_prof_hooks("worker");
	int error = stilb_job_pool_create(&desc, &p->pool);
	if (error == 0)
		return true;
	stilb_fail_threads(p->result->workers, -error);
	return work_fail(p, EXIT_FAILED);
}

static bool work_open(work_pieces *p)
{
	PROFILE("open the scene");
	uint64_t start = stilb_time_ns();
	work_enter(p->work, RENDER_OPENING);
	stilb_scene_open_options open = {.allow_outside = p->options->picture.allow_outside,
	                                 .quiet = p->options->picture.quiet,
	                                 .dark = true,
	                                 .import_bytes = &p->result->import_bytes};
	if (!work_good(p, stilb_scene_open_with(p->options->scene, &open, &p->scene)) ||
	    !work_good(p, picture_flags_pose(&p->options->picture, p->scene)) ||
	    !work_good(p, picture_flags_surroundings(&p->options->picture, p->options->scene, p->scene)) ||
	    !work_good(p, picture_flags_variant(&p->options->picture, p->scene)))
		return false;
	float aspect = (float)p->options->size[0] / (float)p->options->size[1];
	if (!work_good(p, picture_flags_place(&p->options->picture, aspect, p->scene)) ||
	    !work_good(p, picture_flags_expose(&p->options->picture, p->scene, &p->result->metered)))
		return false;
	p->result->open_s = work_seconds_since(start);
	return true;
}

static stilb_gi_scene_desc work_scene_desc(const work_pieces *p)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(p->pool);
	desc.isa = (stilb_gi_isa)p->options->isa;
	return desc;
}

/* Gives the scene the pose of a time after that of --at, and makes it ready for rays. */
static bool work_pose(work_pieces *p, double seconds)
{
	uint32_t count;
	const stilb_scene_play *playing = stilb_scene_plays_of(p->scene, 0, &count);
	if (count == 0)
		return true;
	stilb_scene_play play = *playing;
	stilb_gi_scene_desc desc = work_scene_desc(p);
	play.time = (double)p->options->picture.at + seconds;
	if (!work_good(p, stilb_scene_set_plays(p->scene, 0, &play, 1)))
		return false;
	stilb_scene_advance(p->scene, 0.0, p->pool, 0);
	stilb_scene_update_nodes(p->scene, p->pool, 0);
	return work_good(p, stilb_gi_scene_update(p->gi_scene, p->scene, &desc));
}

/* Reads the table of --grade: before the work, which would be in vain. */
static bool work_table(work_pieces *p)
{
	const char *grade = p->options->grade;
	return !grade || work_good(p, stilb_post_table_open(grade, &p->grade));
}

static bool work_build(work_pieces *p)
{
	PROFILE("prepare the scene");
	uint64_t start = stilb_time_ns();
	work_enter(p->work, RENDER_BUILDING);
	stilb_gi_scene_desc desc = work_scene_desc(p);
	if (!work_good(p, stilb_gi_scene_create(p->scene, &desc, &p->gi_scene)))
		return false;
	p->result->scene = *stilb_gi_scene_info_of(p->gi_scene);
	unsigned long long invalid = p->result->scene.invalid;
	if (invalid > 0)
		stilb_log("'%s': %llu triangle%s left out: a coordinate is NaN, infinite or beyond 1e10 m", p->options->scene,
		          invalid, invalid == 1 ? " is" : "s are");
	p->result->settings = offline_options_settings(p->options, p->scene);
	p->result->prepared = true;
	if (!work_good(p, stilb_gi_render_create(p->gi_scene, &p->result->settings, p->pool, &p->render)))
		return false;
	const offline_options *o = p->options;
	if (o->part && !work_good(p, stilb_gi_farm_share(p->render, o->part_index, o->part_of)))
		return false;
	if (p->crew->many && !work_good(p, stilb_gi_farm_begin(p->render)))
		return false;
	p->result->build_s = work_seconds_since(start);
	return true;
}

/* Loads the checkpoint if --resume is given; a checkpoint of another picture is refused. Without --resume a checkpoint
 * of an earlier run stays until this run writes its own. */
static bool work_resume(work_pieces *p)
{
	const char *path = p->options->checkpoint;
	bool there = path[0] && access(path, F_OK) == 0;
	if (path[0])
		stilb_file_clean(path); /* removes temporary files of runs that were killed */
	if (!p->options->resume) {
		if (there)
			stilb_log("'%s' of an earlier run is not used; give --resume to continue it", path);
		return true;
	}
	if (there)
		return work_good(p, stilb_gi_render_resume(p->render, path));
	stilb_log("there is no '%s' to resume; starting from the beginning", path);
	return true;
}

/* Writes a checkpoint. An error, like a full disk, is printed once and does not end the render. */
static void work_checkpoint(work_pieces *p)
{
	PROFILE("checkpoint");
	if (!p->options->checkpoint[0])
		return;
	offline_crew_hold(p->crew);
	p->result->checkpointed = stilb_gi_render_checkpoint(p->render, p->options->checkpoint) == STILB_OK;
	offline_crew_release(p->crew);
	if (p->result->checkpointed || p->warned)
		return;
	p->warned = true;
	offline_progress_clear();
	stilb_log("%s", stilb_error_message());
}

/* Renders until the picture is finished or the work is stopped. After an error, for example of --cache-save, the
 * picture so far is still written. */
static void work_render(work_pieces *p)
{
	work_enter(p->work, RENDER_RENDERING);
	work_publish(p->work, p->render);
	while (!work_is_stopped(p->work)) {
		if (stilb_gi_render_run(p->render) != STILB_OK) {
			work_fail(p, EXIT_FAILED);
			break;
		}
		if (offline_crew_trouble(p->crew, p->result->message, sizeof p->result->message)) {
			p->result->code = EXIT_REFUSED;
			break;
		}
		stilb_gi_render_progress(p->render, &p->result->progress);
		if (p->result->progress.finished || !work_take_pause(p->work))
			break;
		work_checkpoint(p);
	}
	stilb_gi_render_progress(p->render, &p->result->progress);
	p->result->stopped = !p->result->progress.finished;
}

/* Renders the frame that begins at `seconds`, sharp or blurred. False: it failed, or the work is stopped. */
static bool work_render_frame(work_pieces *p, double seconds)
{
	const offline_options *o = p->options;
	uint32_t moments = o->shutter > 0.0f ? (uint32_t)o->moments : 1;
	double open_s = (double)o->shutter / (double)o->fps;
	for (uint32_t m = 0; m < moments; m++) {
		double at = seconds + open_s * ((double)m + 0.5) / moments;
		if (moments > 1 && !work_pose(p, at))
			return false;
		if (moments > 1)
			stilb_gi_render_until(p->render, (uint32_t)(o->samples * (m + 1) / moments));
		work_render(p);
		if (p->result->code != EXIT_DONE || work_is_stopped(p->work))
			return false;
	}
	return true;
}

/* The table's colour. */
static void work_grade(const void *user, const float code[3], float out[3])
{
	stilb_post_table_at(user, code, out);
}

/* Writes the part, or the picture, denoised if that is asked for. */
static stilb_result work_write(work_pieces *p)
{
	if (p->options->part)
		return stilb_gi_farm_save_part(p->render, p->output);
	if (p->result->settings.denoise) {
		uint64_t start = stilb_time_ns();
		stilb_result result = stilb_gi_render_denoise(p->render);
		p->result->denoise_s = work_seconds_since(start);
		if (result != STILB_OK)
			return result;
	}
	bool graded = p->grade || p->options->dither;
	stilb_gi_grade grade = {.at = p->grade ? work_grade : NULL, .user = p->grade, .dither = p->options->dither};
	return stilb_gi_render_save_graded(p->render, p->output, graded ? &grade : NULL);
}

/* Writes the picture. If that fails, or the picture is unfinished, the samples are kept in a checkpoint; a finished
 * picture removes the checkpoint. */
static void work_save(work_pieces *p)
{
	PROFILE("write the picture");
	uint64_t start = stilb_time_ns();
	work_enter(p->work, RENDER_WRITING);
	bool picture = p->result->progress.camera_rays > 0;
	if (picture && p->result->stopped)
		work_checkpoint(p); /* first: mpirun gives a process that it ends some seconds at most */
	if (p->options->part && p->result->stopped) {
		p->result->saved = false; /* what a part lacks could not be told in a picture */
	} else if (p->output && (picture || p->options->part)) {
		p->result->saved = work_write(p) == STILB_OK;
		if (!p->result->saved)
			work_fail(p, EXIT_FAILED);
	}
	if (picture && !p->result->stopped && p->output && !p->result->saved)
		work_checkpoint(p);
	else if (p->result->progress.finished && p->options->checkpoint[0])
		unlink(p->options->checkpoint);
	p->result->save_s = work_seconds_since(start) - p->result->denoise_s;
}

/* The name of a frame's picture: its number before the extension. NULL: no memory. */
static char *work_frame_name(const char *output, uint32_t frame)
{
	const char *slash = strrchr(output, '/'), *dot = strrchr(output, '.');
	if (!dot || (slash && dot < slash))
		dot = output + strlen(output);
	char *name;
	return asprintf(&name, "%.*s-%04u%s", (int)(dot - output), output, frame, dot) < 0 ? NULL : name;
}

/* Makes the render of another frame, with the same exposure, from the camera that a node may have moved. */
static bool work_next_render(work_pieces *p)
{
	work_publish(p->work, NULL);
	stilb_gi_render_destroy(p->render);
	p->render = NULL;
	float exposure = p->scene->camera.exposure, aspect = (float)p->options->size[0] / (float)p->options->size[1];
	if (!p->scene->framed && !work_good(p, picture_flags_place(&p->options->picture, aspect, p->scene)))
		return false;
	p->scene->camera.exposure = exposure;
	p->result->settings = offline_options_settings(p->options, p->scene);
	return work_good(p, stilb_gi_render_create(p->gi_scene, &p->result->settings, p->pool, &p->render));
}

/* Renders all frames, each to a file of its own. */
static void work_frames(work_pieces *p)
{
	const offline_options *o = p->options;
	for (uint32_t frame = o->frame_first; frame <= o->frame_last && !work_is_stopped(p->work); frame++) {
		double seconds = (double)frame / (double)o->fps;
		if (!work_pose(p, seconds) || (frame > o->frame_first && !work_next_render(p)))
			return;
		free(p->output);
		p->output = work_frame_name(o->output, frame);
		if (!p->output) {
			stilb_fail(STILB_ERROR_MEMORY, "no memory for a name");
			work_fail(p, EXIT_FAILED);
			return;
		}
		bool whole = work_render_frame(p, seconds);
		if (!whole)
			return; /* a frame that was stopped is no picture of the row */
		work_save(p);
		if (p->result->code != EXIT_DONE)
			return;
		offline_progress_clear();
		fprintf(offline_message_stream(o), "picture: %s\n", p->output);
		fflush(offline_message_stream(o));
		p->result->frames++;
	}
}

static void work_trace(work_pieces *p)
{
	stilb_prof_snapshot snapshot = {0};
	const char *path = p->options->trace;
	int error = stilb_prof_snapshot_take(&snapshot, NULL);
	if (error == 0)
		error = stilb_prof_trace_save(&snapshot, "stilb", path);
	stilb_prof_snapshot_finish(&snapshot);
	if (error == 0)
		return;
	stilb_fail(STILB_ERROR_FILE, "cannot write '%s': %s", path, strerror(-error));
	work_fail(p, EXIT_FAILED);
}

static void work_finish(work_pieces *p)
{
	work_publish(p->work, NULL);
	stilb_gi_render_destroy(p->render);
	stilb_gi_scene_destroy(p->gi_scene);
	stilb_scene_destroy(p->scene);
	if (p->pool)
		stilb_job_pool_get_stats(p->pool, &p->result->jobs);
	stilb_job_pool_destroy(p->pool);
	stilb_post_table_destroy(p->grade);
}

/* Meets the other ranks, also if this one is not ready, so that the host hears why. */
static bool work_crew(work_pieces *p, bool ready)
{
	p->result->ranks = p->crew->many ? p->crew->link.count : 0;
	return work_good(p, offline_crew_begin(p->crew, p->render, p->result->workers, ready ? NULL : p->result->message));
}

/* The function of the work's thread. In the profile, the whole work is one frame. */
static void *work_main(void *data)
{
	offline_work *work = data;
	work_pieces pieces = {.work = work, .options = work->options, .crew = work->crew, .result = &work->result};
	stilb_prof_thread_begin("render");
	stilb_prof_frame_mark();
	bool ready =
		work_pool(&pieces) && work_table(&pieces) && work_open(&pieces) && work_build(&pieces) && work_resume(&pieces);
	if (work_crew(&pieces, ready) && ready) {
		pieces.output = work->options->output ? strdup(work->options->output) : NULL;
		if (work->options->frames) {
			work_frames(&pieces);
		} else {
			work_render_frame(&pieces, 0.0);
			if (pieces.result->code != EXIT_REFUSED) /* a rank that does not belong */
				work_save(&pieces);
		}
	}
	free(pieces.output);
	offline_crew_shares(work->crew, work->result.shares, sizeof work->result.shares);
	offline_crew_end(work->crew);
	stilb_prof_frame_mark();
	if (work->options->trace && pieces.render)
		work_trace(&pieces);
	work_enter(work, RENDER_DONE);
	work_finish(&pieces);
	stilb_prof_thread_end();
	return NULL;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Blocks all signals in the new thread and in the threads that it starts, so that every signal goes to the main thread
 * and wakes it from its sleep. */
static int work_create_thread(offline_work *work)
{
	sigset_t all, before;
	sigfillset(&all);
	pthread_sigmask(SIG_BLOCK, &all, &before);
	int error = pthread_create(&work->thread, NULL, work_main, work);
	pthread_sigmask(SIG_SETMASK, &before, NULL);
	return error;
}

stilb_result offline_work_start(const offline_options *options, offline_crew *crew, offline_work **out)
{
	*out = NULL;
	offline_work *work = calloc(1, sizeof *work);
	if (!work)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to render with");
	stilb_owner_take(&work->owner);
	work->options = options;
	work->crew = crew;
	pthread_mutex_init(&work->lock, NULL);
	stilb_prof_ring_events_set(WORK_RING_EVENTS);
	stilb_prof_record_set(options->trace);
	stilb_prof_switches_set(options->trace);
	int error = work_create_thread(work);
	if (error != 0) {
		pthread_mutex_destroy(&work->lock);
		free(work);
		return stilb_fail(STILB_ERROR_THREAD, "cannot start a thread: %s", strerror(error));
	}
	*out = work;
	return STILB_OK;
}

offline_result offline_work_join(offline_work *work)
{
	STILB_ASSERT_OWNER(work->owner);
	pthread_join(work->thread, NULL);
	offline_result result = work->result;
	pthread_mutex_destroy(&work->lock);
	free(work);
	return result;
}
