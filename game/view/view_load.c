#include "view_load.h"

#include "geometry/geometry_detail.h"
#include "geometry/horde/geometry_horde.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct view_load {
	char *name;
	const picture_flags *picture;
	bool again, wait;
	uint64_t start_ns;
	pthread_t thread;
	atomic_bool given_up; /* set by the main thread, read by the other; relaxed: nothing else depends on it */
	_Atomic float done;   /* set by the other thread, read by the main thread; relaxed: it is only shown */
	/* Set by the other thread: release, and acquire where it is read, so that the files are seen, too. */
	atomic_bool ended;
	/* The outcome, written by the other thread and read after joining it. */
	stilb_result result;
	stilb_scene *scene;
	view_load_cost cost;
	char message[1024];
	char **files; /* [file_count] paths that the scene's file names */
	uint32_t file_count;
};

#define LOAD_FILES 1024u /* kept at most: a scene of more is watched in part */

static void load_opened(void *user, const char *path)
{
	view_load *load = user;
	for (uint32_t i = 0; i < load->file_count; i++)
		if (strcmp(load->files[i], path) == 0)
			return;
	if (load->file_count == LOAD_FILES)
		return;
	if (!load->files)
		load->files = calloc(LOAD_FILES, sizeof *load->files);
	char *copy = load->files ? strdup(path) : NULL;
	if (copy)
		load->files[load->file_count++] = copy;
}

static bool load_is_given_up(void *user)
{
	view_load *load = user;
	return atomic_load_explicit(&load->given_up, memory_order_relaxed);
}

static void load_advances(void *user, float done)
{
	view_load *load = user;
	atomic_store_explicit(&load->done, done, memory_order_relaxed);
}

/* Gives the scene what frames need to show less of it than there is: levels, which in a window may come later, and
 * impostors of hordes. */
static void load_detail(view_load *load)
{
	(load->wait ? stilb_geometry_detail_make : stilb_geometry_detail_find)(load->scene);
	stilb_geometry_horde_desc desc = stilb_geometry_horde_desc_default();
	desc.give_up = load_is_given_up;
	desc.user = load;
	stilb_job_pool_desc workers = stilb_job_pool_desc_default();
	workers.name = "stilb-horde";
	workers.affinity = STILB_JOB_AFFINITY_NONE;
	stilb_job_pool *pool;
	if (load->scene->model_count < STILB_GEOMETRY_HORDE_MODELS || stilb_job_pool_create(&workers, &pool) != 0)
		return;
	uint32_t made;
	stilb_geometry_hordes(load->scene, &desc, pool, 0, &made); /* without memory they are drawn as meshes */
	stilb_job_pool_destroy(pool);
}

/* The file of the scene's look is watched, too. */
static void load_look(view_load *load)
{
	char path[PATH_MAX];
	snprintf(path, sizeof path, "%s" STILB_POST_PRESET_SUFFIX, load->name);
	if (access(path, F_OK) == 0)
		load_opened(load, path);
}

static void *load_run(void *data)
{
	view_load *load = data;
	stilb_scene_open_options options = {.allow_outside = load->picture->allow_outside,
	                                    .give_up = load_is_given_up,
	                                    .opened = load_opened,
	                                    .progress = load_advances,
	                                    .user = load,
	                                    .quiet = load->picture->quiet,
	                                    .dark = true,
	                                    .import_bytes = &load->cost.import_bytes};
	load->result = stilb_scene_open_with(load->name, &options, &load->scene);
	load_look(load);
	if (load->result == STILB_OK)
		load->result = picture_flags_pose(load->picture, load->scene);
	if (load->result == STILB_OK)
		load->result = picture_flags_surroundings(load->picture, load->name, load->scene);
	if (load->result == STILB_OK && load->picture->detail != STILB_RENDER_DETAIL_OFF)
		load_detail(load);
	if (load->result == STILB_OK && load_is_given_up(load))
		load->result = stilb_fail(STILB_ERROR_FILE, "'%s' was given up", load->name);
	if (load->result != STILB_OK) {
		snprintf(load->message, sizeof load->message, "%s", stilb_error_message());
		stilb_scene_destroy(load->scene);
		load->scene = NULL;
	}
	load->cost.seconds = view_load_seconds(load);
	atomic_store_explicit(&load->ended, true, memory_order_release);
	return NULL;
}

stilb_result view_load_start(const char *name, const picture_flags *picture, bool again, bool wait, view_load **out)
{
	STILB_ASSERT(name && picture && out);
	*out = NULL;
	view_load *load = calloc(1, sizeof *load);
	if (load && !(load->name = strdup(name))) {
		free(load);
		load = NULL;
	}
	if (!load)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to open '%s'", name);
	load->picture = picture;
	load->again = again;
	load->wait = wait;
	load->start_ns = stilb_time_ns();
	int error = pthread_create(&load->thread, NULL, load_run, load);
	if (error != 0) {
		free(load->name);
		free(load);
		return stilb_fail(STILB_ERROR_THREAD,
		                  "no thread to open '%s': %s; see the limits of 'ulimit -u' and 'ulimit -v'", name,
		                  strerror(error));
	}
	*out = load;
	return STILB_OK;
}

const char *view_load_name(const view_load *load)
{
	return load->name;
}

bool view_load_again(const view_load *load)
{
	return load->again;
}

double view_load_seconds(const view_load *load)
{
	return (double)(stilb_time_ns() - load->start_ns) * 1e-9;
}

float view_load_done(const view_load *load)
{
	return atomic_load_explicit(&load->done, memory_order_relaxed);
}

bool view_load_ended(const view_load *load)
{
	return atomic_load_explicit(&load->ended, memory_order_acquire);
}

const char *const *view_load_files(const view_load *load, uint32_t *count)
{
	STILB_ASSERT(view_load_ended(load));
	*count = load->file_count;
	return (const char *const *)load->files;
}

void view_load_give_up(view_load *load)
{
	atomic_store_explicit(&load->given_up, true, memory_order_relaxed);
}

stilb_result view_load_take(view_load *load, stilb_scene **scene, view_load_cost *cost)
{
	STILB_ASSERT(load && scene);
	pthread_join(load->thread, NULL);
	stilb_result result = load->result;
	*scene = load->scene;
	if (cost)
		*cost = load->cost;
	if (result != STILB_OK)
		stilb_fail(result, "%s", load->message);
	for (uint32_t i = 0; i < load->file_count; i++)
		free(load->files[i]);
	free(load->files);
	free(load->name);
	free(load);
	return result;
}
