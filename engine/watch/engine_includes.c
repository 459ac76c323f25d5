/* Which files a shader is made of. */
#include "watch/engine_watch.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool engine_files_have(const engine_files *files, const char *path)
{
	for (uint32_t f = 0; f < files->count; f++)
		if (strcmp(files->paths[f], path) == 0)
			return true;
	return false;
}

/* The name that a line includes, cut out of it; NULL: it includes none. */
static char *include_name(char *line)
{
	char *at = line + strspn(line, " \t");
	if (*at++ != '#')
		return NULL;
	at += strspn(at, " \t");
	if (strncmp(at, "include", 7) != 0)
		return NULL;
	at += 7 + strspn(at + 7, " \t");
	char *end = *at == '"' ? strchr(at + 1, '"') : *at == '<' ? strchr(at + 1, '>') : NULL;
	if (!end)
		return NULL;
	*end = '\0';
	return at + 1;
}

/* Files that a file includes are named from its folder. */
static void include_all(engine_files *files, const char *path, FILE *stream)
{
	char *line = NULL, *name;
	size_t size = 0;
	while (getline(&line, &size, stream) > 0) {
		char included[PATH_MAX];
		name = include_name(line);
		int folder = (int)(strrchr(path, '/') - path);
		if (name && snprintf(included, sizeof included, "%.*s/%s", folder, path, name) < (int)sizeof included)
			engine_files_add(files, included);
	}
	free(line);
}

void engine_files_add(engine_files *files, const char *path)
{
	char *whole = realpath(path, NULL);
	char **grown =
		whole && !engine_files_have(files, whole) ? realloc(files->paths, (files->count + 1) * sizeof(*grown)) : NULL;
	if (!grown) {
		free(whole);
		return;
	}
	files->paths = grown;
	grown[files->count++] = whole;
	FILE *stream = fopen(whole, "re");
	if (!stream)
		return;
	include_all(files, whole, stream);
	fclose(stream);
}

void engine_files_finish(engine_files *files)
{
	for (uint32_t f = 0; f < files->count; f++)
		free(files->paths[f]);
	free(files->paths);
	*files = (engine_files){0};
}
