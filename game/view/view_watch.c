#include "view_watch.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/inotify.h>
#include <unistd.h>

#define WATCH_QUIET_NS 300000000u

/* The path of the folder that a file is in; freed by the caller. NULL: out of memory. */
static char *watch_folder(const char *path)
{
	const char *slash = strrchr(path, '/');
	if (!slash)
		return strdup(".");
	return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

static const char *watch_file(const char *path)
{
	const char *slash = strrchr(path, '/');
	return slash ? slash + 1 : path;
}

void view_watch_finish(view_watch *watch)
{
	if (watch->notify >= 0)
		close(watch->notify);
	for (uint32_t i = 0; i < watch->file_count; i++)
		free(watch->files[i].name);
	free(watch->files);
	watch->files = NULL;
	watch->file_count = 0;
	watch->notify = -1;
	watch->due_ns = 0;
}

/* The number by which inotify watches the file's folder; -1: it cannot. */
static int watch_number(const view_watch *watch, const char *path)
{
	uint32_t events = IN_CLOSE_WRITE | IN_MODIFY | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE;
	char *folder = watch_folder(path);
	int number = folder && watch->notify >= 0 ? inotify_add_watch(watch->notify, folder, events) : -1;
	free(folder);
	return number;
}

void view_watch_add(view_watch *watch, const char *path)
{
	STILB_ASSERT(watch && path);
	int number = watch_number(watch, path);
	for (uint32_t i = 0; i < watch->file_count; i++)
		if (watch->files[i].folder == number && strcmp(watch->files[i].name, watch_file(path)) == 0)
			return;
	view_watch_file *more = number >= 0 ? realloc(watch->files, (watch->file_count + 1) * sizeof *more) : NULL;
	if (!more)
		return;
	watch->files = more;
	more[watch->file_count] = (view_watch_file){number, strdup(watch_file(path))};
	watch->file_count += more[watch->file_count].name ? 1 : 0;
}

void view_watch_set(view_watch *watch, const char *path)
{
	STILB_ASSERT(watch && path);
	view_watch_finish(watch);
	if (access(path, F_OK) != 0)
		return;
	watch->notify = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
	view_watch_add(watch, path);
	if (watch->file_count == 0)
		view_watch_finish(watch);
}

/* The number of the file that the event is about, or file_count. */
static uint32_t watch_which(const view_watch *watch, const struct inotify_event *event)
{
	uint32_t i = 0;
	while (i < watch->file_count &&
	       (event->len == 0 || event->wd != watch->files[i].folder || strcmp(event->name, watch->files[i].name) != 0))
		i++;
	return i;
}

/* What an event means. A file that the scene names may go: its writer may be about to put another in its place. */
static void watch_take(view_watch *watch, const struct inotify_event *event, view_watch_news *news)
{
	uint32_t which = watch_which(watch, event);
	bool gone = event->mask & (IN_MOVED_FROM | IN_DELETE);
	if (which == watch->file_count || (gone && which > 0))
		return;
	watch->which = watch->due_ns == 0 || watch->which == which ? which : 0;
	if (which == 0)
		*news = gone ? VIEW_WATCH_GONE : VIEW_WATCH_NOTHING;
	watch->due_ns = gone ? 0 : stilb_time_ns() + WATCH_QUIET_NS;
}

view_watch_news view_watch_look(view_watch *watch)
{
	STILB_ASSERT(watch);
	_Alignas(struct inotify_event) char buffer[4096];
	ssize_t size;
	view_watch_news news = VIEW_WATCH_NOTHING;
	while (watch->notify >= 0 && (size = read(watch->notify, buffer, sizeof buffer)) > 0)
		for (char *at = buffer; at < buffer + size;) {
			const struct inotify_event *event = (const struct inotify_event *)at;
			at += sizeof *event + event->len;
			watch_take(watch, event, &news);
		}
	if (watch->due_ns == 0 || stilb_time_ns() < watch->due_ns)
		return news;
	watch->due_ns = 0;
	return VIEW_WATCH_CHANGED;
}

bool view_watch_is(const view_watch *watch, const char *ending)
{
	STILB_ASSERT(watch && ending);
	if (watch->which == 0 || watch->which >= watch->file_count)
		return false;
	const char *name = watch->files[watch->which].name;
	size_t length = strlen(name), end = strlen(ending);
	return length >= end && strcmp(name + length - end, ending) == 0;
}

/* ---- neighbours -------------------------------------------------------------------------------------------------- */

/* The extensions of scene files. Some that Assimp reads are left out, because other files have them: .xml, .raw. */
static const char *const watch_extensions[] = {
	"3d",      "3ds", "3mf", "ac",   "ac3d", "amf", "ase", "b3d",  "blend", "bvh", "cob", "csm", "dae",
	"dxf",     "fbx", "glb", "gltf", "hmp",  "ifc", "iqm", "irr",  "lwo",   "lws", "m3d", "md2", "md3",
	"md5mesh", "mdc", "mdl", "ms3d", "nff",  "obj", "off", "ogex", "ply",   "q3o", "q3s", "scn", "sib",
	"smd",     "stl", "ter", "vta",  "wrl",  "x",   "x3d", "xgl",  "zae",   "zgl",
};

static int watch_is_scene(const struct dirent *entry)
{
	const char *dot = strrchr(entry->d_name, '.');
	if (!dot || dot == entry->d_name)
		return 0;
	for (size_t i = 0; i < sizeof watch_extensions / sizeof *watch_extensions; i++)
		if (strcasecmp(dot + 1, watch_extensions[i]) == 0)
			return 1;
	return 0;
}

/* The index of the file that is step places after `name` among the sorted entries, in which `name` may be missing. */
static int watch_after(struct dirent **entries, int count, const char *name, int step)
{
	int place = 0;
	while (place < count && strverscmp(entries[place]->d_name, name) < 0)
		place++;
	bool there = place < count && strcmp(entries[place]->d_name, name) == 0;
	int to = place + step - (!there && step > 0);
	return (to % count + count) % count;
}

char *view_watch_neighbour(const char *path, int step)
{
	STILB_ASSERT(path);
	struct dirent **entries;
	char *found = NULL, *folder = watch_folder(path);
	int count = folder ? scandir(folder, &entries, watch_is_scene, versionsort) : -1;
	if (count > 0) {
		const char *name = entries[watch_after(entries, count, watch_file(path), step)]->d_name;
		int length = (int)(watch_file(path) - path);
		if (strcmp(name, watch_file(path)) != 0 && asprintf(&found, "%.*s%s", length, path, name) < 0)
			found = NULL;
	}
	for (int i = 0; i < count; i++)
		free(entries[i]);
	if (count >= 0)
		free(entries);
	free(folder);
	return found;
}
