#include "watch/engine_watch.h"
#include "engine_internal.h"

#include "profiler/prof.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define WATCH_QUIET_NS 50000000u                  /* after the last write: editors write in several steps */
#define WATCH_KNOWN "gpu/shaders/fullscreen.vert" /* a file that the sources have */
#define WATCH_OWN "--watch-shaders: "

/* What a shader of programs is made of. */
typedef struct watch_source {
	char *text; /* stilb_gpu_shader.source */
	char *file; /* of it, below the folder or with its whole path */
	char *definitions;
	engine_files files; /* that it is made of; none: there is no such file */
	bool dirty;         /* one of them was written since it was compiled last */
} watch_source;

/* A folder that inotify watches. */
typedef struct watch_folder {
	int number; /* inotify's */
	char *path;
} watch_folder;

typedef struct watch_message {
	engine_watch_news news;
	struct watch_message *next;
} watch_message;

struct engine_watch {
	stilb_gpu *gpu;
	char *folder;
	pthread_t thread;
	int notify, wake, end; /* inotify; events: there are new sources; the thread is to end */
	struct timespec began; /* by the clock of files, whose times may be a tick of the kernel older, never newer */
	uint32_t seen;         /* of the main thread: sources of the device that the thread was told of */

	/* Of the thread alone. */
	watch_source *sources; /* [source_count] */
	watch_folder *folders; /* [folder_count] */
	uint32_t source_count, folder_count;
	uint64_t due_ns; /* when what is dirty is compiled, unless files are written before; 0: nothing is */

	pthread_mutex_t lock;
	watch_message *messages; /* guarded by the lock; the oldest first */
};

/* ---- news -------------------------------------------------------------------------------------------------------- */

/* Hands news to the main thread. text: freed by whoever gets it; NULL: there was no memory for it. */
static void watch_say(engine_watch *watch, bool good, char *text)
{
	watch_message *message = text ? malloc(sizeof *message) : NULL;
	if (!message) {
		free(text);
		return;
	}
	*message = (watch_message){.news = {good, text}};
	pthread_mutex_lock(&watch->lock);
	watch_message **last = &watch->messages;
	while (*last)
		last = &(*last)->next;
	*last = message;
	pthread_mutex_unlock(&watch->lock);
}

static void watch_say_errno(engine_watch *watch, const char *what, const char *way)
{
	char *text;
	if (asprintf(&text, WATCH_OWN "cannot %s: %s%s", what, strerror(errno), way) >= 0)
		watch_say(watch, false, text);
}

bool engine_watch_look(engine_watch *watch, engine_watch_news *news)
{
	uint32_t before = watch->seen;
	while (stilb_gpu_shader_source(watch->gpu, watch->seen))
		watch->seen++;
	if (watch->seen > before)
		eventfd_write(watch->wake, 1);
	pthread_mutex_lock(&watch->lock);
	watch_message *message = watch->messages;
	if (message)
		watch->messages = message->next;
	pthread_mutex_unlock(&watch->lock);
	if (message)
		*news = message->news;
	free(message);
	return message;
}

/* ---- sources and their files ------------------------------------------------------------------------------------- */

/* Lets inotify watch the folder of a file. */
static void watch_add_folder(engine_watch *watch, const char *path)
{
	char *folder = strndup(path, (size_t)(strrchr(path, '/') - path));
	watch_folder *grown = NULL;
	for (uint32_t f = 0; folder && f < watch->folder_count; f++)
		if (strcmp(watch->folders[f].path, folder) == 0) {
			free(folder);
			return;
		}
	int number = folder ? inotify_add_watch(watch->notify, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR) : -1;
	if (folder && number < 0)
		watch_say_errno(watch, folder, "; raise the sysctl fs.inotify.max_user_watches");
	if (number >= 0)
		grown = realloc(watch->folders, (watch->folder_count + 1) * sizeof *grown);
	if (!grown) {
		free(folder);
		return;
	}
	watch->folders = grown;
	grown[watch->folder_count++] = (watch_folder){number, folder};
}

/* Finds the files that a source is made of. */
static void watch_read(engine_watch *watch, watch_source *source)
{
	char path[PATH_MAX];
	engine_files_finish(&source->files);
	bool whole = source->file[0] == '/';
	snprintf(path, sizeof path, "%s%s%s", whole ? "" : watch->folder, whole ? "" : "/", source->file);
	engine_files_add(&source->files, path);
	for (uint32_t f = 0; f < source->files.count; f++)
		watch_add_folder(watch, source->files.paths[f]);
}

static bool watch_take_source(engine_watch *watch, const char *text)
{
	watch_source *grown = realloc(watch->sources, (watch->source_count + 1) * sizeof *grown);
	if (!grown)
		return false;
	watch->sources = grown;
	const char *definitions = strstr(text, " -D");
	watch_source source = {
		.text = strdup(text),
		.file = definitions ? strndup(text, (size_t)(definitions - text)) : strdup(text),
		.definitions = strdup(definitions ? definitions + 1 : ""),
	};
	if (!source.text || !source.file || !source.definitions) {
		free(source.text);
		free(source.file);
		free(source.definitions);
		return false;
	}
	grown[watch->source_count++] = source;
	return true;
}

/* True if a file was written since the watch began. */
static bool watch_is_newer(const engine_watch *watch, const char *path)
{
	struct stat info;
	if (stat(path, &info) != 0)
		return false;
	const struct timespec *written = &info.st_ctim, *began = &watch->began; /* a file that is renamed keeps st_mtim */
	return written->tv_sec > began->tv_sec || (written->tv_sec == began->tv_sec && written->tv_nsec > began->tv_nsec);
}

/* Takes in the sources of programs that are new. Files that they are made of may have been written already. */
static void watch_learn(engine_watch *watch)
{
	const char *text;
	while ((text = stilb_gpu_shader_source(watch->gpu, watch->source_count)) && watch_take_source(watch, text)) {
		watch_source *source = &watch->sources[watch->source_count - 1];
		char *missing;
		watch_read(watch, source);
		for (uint32_t f = 0; f < source->files.count; f++)
			source->dirty = source->dirty || watch_is_newer(watch, source->files.paths[f]);
		if (source->dirty)
			watch->due_ns = stilb_time_ns();
		if (source->files.count == 0 && asprintf(&missing, WATCH_OWN "there is no '%s' in '%s': it is not watched",
		                                         source->file, watch->folder) >= 0)
			watch_say(watch, false, missing);
	}
}

/* ---- files that are written -------------------------------------------------------------------------------------- */

static void watch_event(engine_watch *watch, const struct inotify_event *event)
{
	char path[PATH_MAX] = "";
	for (uint32_t f = 0; f < watch->folder_count && event->len > 0; f++)
		if (watch->folders[f].number == event->wd)
			snprintf(path, sizeof path, "%s/%s", watch->folders[f].path, event->name);
	if (!path[0])
		return;
	for (uint32_t s = 0; s < watch->source_count; s++)
		if (engine_files_have(&watch->sources[s].files, path)) {
			watch->sources[s].dirty = true;
			watch->due_ns = stilb_time_ns() + WATCH_QUIET_NS;
		}
}

static void watch_events(engine_watch *watch)
{
	_Alignas(struct inotify_event) char buffer[4096];
	ssize_t size = read(watch->notify, buffer, sizeof buffer);
	for (char *at = buffer; size > 0 && at < buffer + size;) {
		const struct inotify_event *event = (const struct inotify_event *)at;
		at += sizeof *event + event->len;
		watch_event(watch, event);
	}
}

/* ---- building ---------------------------------------------------------------------------------------------------- */

/* What is compiled, and the sources that it is of. */
typedef struct watch_work {
	engine_glslc *shaders; /* [count] */
	uint32_t *sources;     /* [count] */
	stilb_gpu_shader *made;
	uint32_t count;
} watch_work;

/* Names the files of the work, each once: "shaders/a.frag, shaders/b.frag". */
static void watch_names(const watch_work *work, FILE *out)
{
	for (uint32_t i = 0; i < work->count; i++) {
		uint32_t before = 0;
		while (before < i && strcmp(work->shaders[before].file, work->shaders[i].file) != 0)
			before++;
		if (before == i)
			fprintf(out, "%s%s", i > 0 ? ", " : "", work->shaders[i].file);
	}
}

/* Writes what glslc said of shaders that could not be compiled, each text once. False: all could. */
static bool watch_wrong(const watch_work *work, FILE *out)
{
	bool wrong = false;
	for (uint32_t i = 0; i < work->count; i++) {
		const engine_glslc *shader = &work->shaders[i];
		bool told = shader->words;
		for (uint32_t k = 0; k < i && !told && shader->message; k++)
			told = !work->shaders[k].words && work->shaders[k].message &&
			       strcmp(work->shaders[k].message, shader->message) == 0;
		if (!told)
			fprintf(out, "%s%s", shader->message ? shader->message : "no memory to compile ",
			        shader->message ? "" : shader->file);
		wrong = wrong || !shader->words;
	}
	return wrong;
}

/* Gives the device what was compiled, and says how it went. */
static void watch_replace(engine_watch *watch, const watch_work *work, uint64_t since_ns)
{
	char *text = NULL;
	size_t size;
	uint32_t programs = 0;
	bool good = false;
	FILE *out = open_memstream(&text, &size);
	if (!out)
		return;
	if (!watch_wrong(work, out)) {
		for (uint32_t i = 0; i < work->count; i++)
			work->made[i] = (stilb_gpu_shader){.words = work->shaders[i].words,
			                                   .bytes = work->shaders[i].bytes,
			                                   .source = watch->sources[work->sources[i]].text};
		good = stilb_gpu_shaders_replace(watch->gpu, work->made, work->count, &programs) == STILB_OK;
		watch_names(work, out);
		if (good)
			fprintf(out, " compiled for %u program%s in %.0f ms", programs, programs == 1 ? "" : "s",
			        (double)(stilb_time_ns() - since_ns) * 1e-6);
		else
			fprintf(out, ": %s", stilb_error_message());
	}
	fclose(out);
	for (uint32_t i = 0; i < work->count && good; i++)
		watch->sources[work->sources[i]].dirty = false;
	watch_say(watch, good, text);
}

/* Compiles what is dirty. */
static void watch_build(engine_watch *watch)
{
	PROFILE("build shaders");
	uint64_t since = stilb_time_ns();
	uint32_t most = watch->source_count + 1;
	watch_work work = {calloc(most, sizeof *work.shaders), calloc(most, sizeof *work.sources),
	                   calloc(most, sizeof *work.made), 0};
	for (uint32_t s = 0; work.shaders && work.sources && work.made && s < watch->source_count; s++) {
		watch_source *source = &watch->sources[s];
		if (!source->dirty)
			continue;
		watch_read(watch, source); /* its includes may be others */
		work.sources[work.count] = s;
		work.shaders[work.count++] = (engine_glslc){.file = source->file, .definitions = source->definitions};
	}
	if (work.count > 0 && engine_glslc_run(work.shaders, work.count, watch->folder, watch->end))
		watch_replace(watch, &work, since);
	for (uint32_t i = 0; i < work.count; i++) {
		free(work.shaders[i].words);
		free(work.shaders[i].message);
	}
	free(work.shaders);
	free(work.sources);
	free(work.made);
}

/* ---- the thread -------------------------------------------------------------------------------------------------- */

/* Milliseconds until something is due; -1: nothing is. */
static int watch_wait(const engine_watch *watch)
{
	uint64_t now = stilb_time_ns();
	if (watch->due_ns == 0)
		return -1;
	return watch->due_ns > now ? (int)((watch->due_ns - now) / 1000000u) + 1 : 0;
}

static void *watch_run(void *user)
{
	engine_watch *watch = user;
	stilb_prof_thread_begin("shaders");
	pthread_setname_np(pthread_self(), "shaders");
	struct pollfd polls[3] = {{.fd = watch->end, .events = POLLIN},
	                          {.fd = watch->wake, .events = POLLIN},
	                          {.fd = watch->notify, .events = POLLIN}};
	for (;;) {
		eventfd_t count;
		if (poll(polls, 3, watch_wait(watch)) < 0 && errno != EINTR)
			break;
		if (polls[0].revents != 0)
			break;
		if (polls[1].revents != 0 && eventfd_read(watch->wake, &count) == 0)
			watch_learn(watch);
		if (polls[2].revents != 0)
			watch_events(watch);
		if (watch_wait(watch) == 0) {
			watch->due_ns = 0;
			watch_build(watch);
		}
	}
	stilb_prof_thread_end();
	return NULL;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void watch_free(engine_watch *watch)
{
	const int files[] = {watch->notify, watch->wake, watch->end};
	for (size_t f = 0; f < sizeof files / sizeof *files; f++)
		if (files[f] >= 0)
			close(files[f]);
	for (uint32_t s = 0; s < watch->source_count; s++) {
		free(watch->sources[s].text);
		free(watch->sources[s].file);
		free(watch->sources[s].definitions);
		engine_files_finish(&watch->sources[s].files);
	}
	for (uint32_t f = 0; f < watch->folder_count; f++)
		free(watch->folders[f].path);
	for (watch_message *message; (message = watch->messages);) {
		watch->messages = message->next;
		free(message->news.text);
		free(message);
	}
	pthread_mutex_destroy(&watch->lock);
	free(watch->sources);
	free(watch->folders);
	free(watch->folder);
	free(watch);
}

/* The folder with the sources; NULL: they are not there, and the message says so. */
static char *watch_find(const char *folder)
{
	char known[PATH_MAX];
	snprintf(known, sizeof known, "%s/" WATCH_KNOWN, folder);
	char *whole = access(known, R_OK) == 0 ? realpath(folder, NULL) : NULL;
	if (!whole)
		stilb_fail(STILB_ERROR_FILE,
		           WATCH_OWN "no shader sources at '%s'; give --shaders DIR, the folder 'engine' of Stilb's sources",
		           folder);
	return whole;
}

engine_watch *engine_watch_create(stilb_gpu *gpu, const char *folder)
{
	char *whole = watch_find(folder ? folder : STILB_SHADER_FOLDER);
	if (!whole)
		return NULL;
	if (!engine_glslc_is_there()) {
		stilb_fail(STILB_ERROR_FILE, WATCH_OWN ENGINE_GLSLC_MISSING);
		free(whole);
		return NULL;
	}
	engine_watch *watch = calloc(1, sizeof *watch);
	if (!watch) {
		stilb_fail(STILB_ERROR_MEMORY, WATCH_OWN "no memory");
		free(whole);
		return NULL;
	}
	*watch = (engine_watch){.gpu = gpu, .folder = whole, .lock = PTHREAD_MUTEX_INITIALIZER};
	clock_gettime(CLOCK_REALTIME, &watch->began);
	watch->notify = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
	watch->wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
	watch->end = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
	int error = watch->notify < 0 || watch->wake < 0 || watch->end < 0 ? errno : 0;
	if (error == 0)
		error = engine_thread_start(&watch->thread, watch_run, watch);
	if (error == 0)
		return watch;
	stilb_fail(STILB_ERROR_THREAD, WATCH_OWN "cannot watch files: %s", strerror(error));
	watch_free(watch);
	return NULL;
}

void engine_watch_destroy(engine_watch *watch)
{
	if (!watch)
		return;
	eventfd_write(watch->end, 1);
	pthread_join(watch->thread, NULL);
	watch_free(watch);
}
