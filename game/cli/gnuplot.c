#include "gnuplot.h"

#include "base/base_file.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Exit status 0? What gnuplot says goes to stderr, unless quiet. */
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

/* Errors of writing are reported by commit. */
static void copy(FILE *from, stilb_file *to)
{
	char block[65536];
	for (size_t size; (size = fread(block, 1, sizeof block, from)) > 0;)
		stilb_file_write(to, block, size);
}

/* gnuplot calls every picture "Gnuplot", and leaves groups with nothing in them, an eighth of the file. */
static void copy_svg(FILE *from, stilb_file *to, const char *title)
{
	char *line = NULL, *group = NULL; /* group: an opened one that may be empty */
	size_t line_room = 0, group_room = 0;
	bool opened = false;
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

/* gnuplot draws into folder; the picture is copied to where it belongs. */
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
		result = stilb_fail(STILB_ERROR_FILE, "cannot draw '%s': gnuplot failed", path);
	} else {
		result = stilb_fail(STILB_ERROR_FILE, "cannot draw '%s': no room for gnuplot's script in '%s'", path, folder);
	}
	unlink(picture_name);
	unlink(script_name);
	return result;
}

stilb_result gnuplot_save(const char *path, const char *terminal, const char *svg_title, gnuplot_script *script,
                          const void *context)
{
	char folder[] = "/tmp/stilb-plot-XXXXXX";
	if (!mkdtemp(folder))
		return stilb_fail(STILB_ERROR_FILE, "cannot draw '%s': no temporary folder: %s", path, strerror(errno));
	stilb_result result = draw(folder, path, terminal, svg_title, script, context);
	rmdir(folder);
	return result;
}
