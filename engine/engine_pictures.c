/*
 * Pictures that are written beside the frames: the main thread reads a picture back, another encodes it and writes the
 * file, and the main thread tells the program how that went. That thread is started with the first picture.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* One picture, in the order in which they came. Whoever has it in a list of its own, or in none, owns it. */
typedef struct picture {
	struct picture *next;
	stilb_image image;
	stilb_scene_look look;
	char *path;
	bool created; /* an empty file of the path's name is there, and goes if the picture cannot be written */
	stilb_result result;
	char message[1024]; /* of the error */
} picture;

struct engine_pictures {
	engine_picture_save *save;
	pthread_t thread;
	bool running; /* the thread; only the main thread looks */
	pthread_mutex_t lock;
	pthread_cond_t changed; /* any of what follows, all guarded by the lock */
	picture *waiting, *written;
	uint32_t pending; /* pictures that wait or are being written */
	bool end;
};

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static void picture_append(picture **list, picture *one)
{
	while (*list)
		list = &(*list)->next;
	one->next = NULL;
	*list = one;
}

static picture *picture_take(picture **list)
{
	picture *first = *list;
	if (first)
		*list = first->next;
	return first;
}

static void picture_free(picture *one)
{
	stilb_image_finish(&one->image);
	free(one->path);
	free(one);
}

/* ---- the thread -------------------------------------------------------------------------------------------------- */

static void picture_write(const engine_pictures *pictures, picture *one)
{
	PROFILE("write the picture");
	one->result = pictures->save(&one->look, &one->image, one->path);
	if (one->result != STILB_OK)
		snprintf(one->message, sizeof one->message, "%s", stilb_error_message());
	if (one->result != STILB_OK && one->created)
		unlink(one->path);
	stilb_image_finish(&one->image);
}

static void *pictures_run(void *user)
{
	engine_pictures *pictures = user;
	stilb_prof_thread_begin("pictures");
	pthread_setname_np(pthread_self(), "pictures");
	pthread_mutex_lock(&pictures->lock);
	for (;;) {
		while (!pictures->waiting && !pictures->end)
			pthread_cond_wait(&pictures->changed, &pictures->lock);
		picture *one = picture_take(&pictures->waiting);
		if (!one)
			break;
		pthread_mutex_unlock(&pictures->lock);
		picture_write(pictures, one);
		pthread_mutex_lock(&pictures->lock);
		picture_append(&pictures->written, one);
		pictures->pending--;
		pthread_cond_broadcast(&pictures->changed);
	}
	pthread_mutex_unlock(&pictures->lock);
	stilb_prof_thread_end();
	return NULL;
}

int engine_thread_start(pthread_t *thread, void *(*run)(void *user), void *user)
{
	static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};
	sigset_t others, before;
	sigfillset(&others);
	for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
		sigdelset(&others, faults[i]);
	pthread_sigmask(SIG_BLOCK, &others, &before);
	int error = pthread_create(thread, NULL, run, user);
	pthread_sigmask(SIG_SETMASK, &before, NULL);
	return error;
}

static void pictures_start(engine_pictures *pictures)
{
	pictures->running = engine_thread_start(&pictures->thread, pictures_run, pictures) == 0;
}

engine_pictures *engine_pictures_create(engine_picture_save *save)
{
	engine_pictures *pictures = calloc(1, sizeof *pictures);
	if (!pictures)
		return NULL;
	pictures->save = save;
	pthread_mutex_init(&pictures->lock, NULL);
	pthread_cond_init(&pictures->changed, NULL);
	return pictures;
}

void engine_pictures_destroy(engine_pictures *pictures)
{
	if (!pictures)
		return;
	pthread_mutex_lock(&pictures->lock);
	pictures->end = true;
	pthread_cond_broadcast(&pictures->changed);
	pthread_mutex_unlock(&pictures->lock);
	if (pictures->running)
		pthread_join(pictures->thread, NULL);
	STILB_ASSERT(!pictures->waiting && pictures->pending == 0);
	for (picture *one; (one = picture_take(&pictures->written));)
		picture_free(one);
	pthread_cond_destroy(&pictures->changed);
	pthread_mutex_destroy(&pictures->lock);
	free(pictures);
}

/* ---- the main thread --------------------------------------------------------------------------------------------- */

/* Waits until at most `most` pictures are pending. */
static void pictures_wait(engine_pictures *pictures, uint32_t most)
{
	PROFILE("wait for pictures");
	pthread_mutex_lock(&pictures->lock);
	while (pictures->pending > most)
		pthread_cond_wait(&pictures->changed, &pictures->lock);
	pthread_mutex_unlock(&pictures->lock);
}

stilb_scene_look engine_look(const stilb_render_view *view)
{
	stilb_scene_look look = {.exposure = view->exposure, .tone = view->tone};
	stilb_scene_environment_words(&view->surroundings, look.environment, sizeof look.environment);
	return look;
}

stilb_result engine_pictures_add(engine_pictures *pictures, stilb_image *image, const stilb_scene_look *look,
                                 const char *path, bool created)
{
	picture *one = calloc(1, sizeof *one);
	char *copy = strdup(path);
	if (!one || !copy) {
		free(one);
		free(copy);
		stilb_image_finish(image);
		if (created)
			unlink(path);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to write '%s'", path);
	}
	*one = (picture){.image = *image, .look = *look, .path = copy, .created = created};
	*image = (stilb_image){0};
	if (!pictures->running)
		pictures_start(pictures);
	if (!pictures->running) { /* no thread: the frame waits for it */
		picture_write(pictures, one);
		picture_append(&pictures->written, one);
		return STILB_OK;
	}
	pictures_wait(pictures, ENGINE_PICTURES - 1);
	pthread_mutex_lock(&pictures->lock);
	picture_append(&pictures->waiting, one);
	pictures->pending++;
	pthread_cond_broadcast(&pictures->changed);
	pthread_mutex_unlock(&pictures->lock);
	return STILB_OK;
}

void engine_pictures_tell(stilb_engine *engine)
{
	engine_pictures *pictures = engine->pictures;
	if (!pictures)
		return;
	pthread_mutex_lock(&pictures->lock);
	picture *written = pictures->written;
	pictures->written = NULL;
	pthread_mutex_unlock(&pictures->lock);
	for (picture *one; (one = picture_take(&written)); picture_free(one))
		if (engine->desc.pictured)
			engine->desc.pictured(engine->desc.user, &(stilb_engine_pictured){one->path, one->result, one->message});
}

void stilb_engine_pictures_wait(stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	if (!engine->pictures)
		return;
	pictures_wait(engine->pictures, 0);
	engine_pictures_tell(engine);
}

stilb_result stilb_engine_picture(stilb_engine *engine, const char *path, bool created)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(path);
	PROFILE("take the picture");
	stilb_image image = {0};
	if (!engine->pictures)
		engine->pictures = engine_pictures_create(stilb_scene_look_save);
	stilb_result result = engine->pictures ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory to write '%s'", path);
	if (result == STILB_OK) {
		PROFILE("read the picture back");
		result = stilb_render_read_for_file(engine->render, path, &image);
	}
	stilb_scene_look look = engine_look(&engine->views[0]);
	if (result == STILB_OK)
		return engine_pictures_add(engine->pictures, &image, &look, path, created);
	stilb_image_finish(&image);
	if (created)
		unlink(path);
	return result;
}
