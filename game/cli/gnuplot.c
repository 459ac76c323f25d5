#include "gnuplot.h"

#include "base/base_file.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Runs gnuplot with one argument; true if its exit status is 0. Its output goes to stderr, or nowhere if quiet. */
static bool gnuplot_run(const char *argument, bool quiet)
{
	char *argv[] = {"gnuplot", (char *)argument, NULL};
	posix_spawn_file_actions_t actions;
	posix_spawn_file_actions_init(&actions);
	if (quiet)
		posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
	else
		posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
	pid_t child;
	int error = posix_spawnp(&child, "gnuplot", &actions, NULL, argv, environ), status = -1;
	posix_spawn_file_actions_destroy(&actions);
	while (!error && waitpid(child, &status, 0) < 0 && errno == EINTR) {
	}
	return !error && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool gnuplot_found(void)
{
	return gnuplot_run("--version", true);
}

/* Errors of writing are kept in the file; stilb_file_commit reports them. */
static void copy(FILE *from, stilb_file *to)
{
	char block[65536];
	for (size_t size; (size = fread(block, 1, sizeof block, from)) > 0;)
		stilb_file_write(to, block, size);
}

/* Copies an SVG picture, with title in place of the title "Gnuplot" that every picture gets, and without its empty
 * groups <g ...></g>, which are an eighth of the file. gnuplot writes the title, <g ...> and </g> each on a line of its
 * own. */
static void copy_svg(FILE *from, stilb_file *to, const char *title)
{
	char *line = NULL, *group = NULL;
	size_t line_room = 0, group_room = 0;
	bool opened = false; /* group is the line of an opening <g>; the next line will show whether it is empty */
	while (getline(&line, &line_room, from) > 0) {
		if (opened && strcmp(line, "</g>\n") == 0) {
			opened = false;
			continue;
		}
		if (opened)
			stilb_file_write(to, group, strlen(group));
		opened = strncmp(line, "<g ", 3) == 0;
		if (opened) {
			char *swapped = group;
			size_t room = group_room;
			group = line, group_room = line_room;
			line = swapped, line_room = room;
		} else if (strcmp(line, "<title>Gnuplot</title>\n") == 0) {
			stilb_file_write(to, "<title>", strlen("<title>"));
			stilb_file_write(to, title, strlen(title));
			stilb_file_write(to, "</title>\n", strlen("</title>\n"));
		} else {
			stilb_file_write(to, line, strlen(line));
		}
	}
	if (opened)
		stilb_file_write(to, group, strlen(group));
	free(line);
	free(group);
}

static stilb_result copy_to(const char *path, FILE *from, const char *svg_title)
{
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	if (svg_title)
		copy_svg(from, &file, svg_title);
	else
		copy(from, &file);
	return stilb_file_commit(&file);
}

/* Writes the script into folder, has gnuplot draw there, copies the picture to path, and empties folder again. */
static stilb_result draw(const char *folder, const char *path, const char *terminal, const char *svg_title,
                         gnuplot_script *write, const void *context)
{
	char script_name[64], picture_name[64];
	snprintf(script_name, sizeof script_name, "%s/script", folder);
	snprintf(picture_name, sizeof picture_name, "%s/picture", folder);
	FILE *script = fopen(script_name, "we");
	bool written = false;
	if (script) {
		fprintf(script, "set terminal %s\nset output '%s'\n", terminal, picture_name);
		write(script, context);
		fprintf(script, "unset output\n");
		written = !ferror(script);
		written &= fclose(script) == 0;
	}
	stilb_result result;
	FILE *picture = written && gnuplot_run(script_name, false) ? fopen(picture_name, "re") : NULL;
	if (picture) {
		result = copy_to(path, picture, svg_title);
		fclose(picture);
	} else if (written) {
		result = stilb_fail(STILB_ERROR_FILE, "cannot draw '%s': gnuplot failed; its message is above", path);
	} else {
		result =
			stilb_fail(STILB_ERROR_FILE,
		               "cannot draw '%s': gnuplot's script cannot be written in '%s'; is the disk full?", path, folder);
	}
	unlink(picture_name);
	unlink(script_name);
	return result;
}

stilb_result gnuplot_save(const char *path, const char *terminal, const char *svg_title, gnuplot_script *script,
                          const void *context)
{
	STILB_ASSERT(path && terminal && script);
	STILB_ASSERT(!svg_title || !strpbrk(svg_title, "<&"));
	char folder[] = "/tmp/stilb-plot-XXXXXX";
	if (!mkdtemp(folder))
		return stilb_fail(STILB_ERROR_FILE, "cannot draw '%s': cannot make a temporary folder in /tmp: %s", path,
		                  strerror(errno));
	stilb_result result = draw(folder, path, terminal, svg_title, script, context);
	rmdir(folder);
	return result;
}
