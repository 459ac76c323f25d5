/* Opens scenes by name: the table of built-ins, and files for all other names. */
#include "profiler/prof.h"
#include "scene/open/scene_builtin.h"
#include "scene/open/scene_import.h"
#include "scene/open/scene_lights_file.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"
#include "shading/shade_tonemap.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct scene_builtin {
	const char *name; /* if it ends in ':', a number follows */
	stilb_result (*create)(float number, stilb_scene **scene);
} scene_builtins[] = {
	{"cornell", scene_create_cornell},       {"outdoor", scene_create_outdoor},
	{"furnace:", scene_create_furnace},      {"plane-wall", scene_create_plane_wall},
	{"stress", scene_create_stress_default}, {"spheres", scene_create_spheres},
};

const char *stilb_scene_builtin_names(void)
{
#define SCENE_BUILTIN_NAME(name, text) ", " name
	static const char names[] = STILB_SCENE_BUILTINS(SCENE_BUILTIN_NAME);
#undef SCENE_BUILTIN_NAME
	return &names[2]; /* without the first comma */
}

static stilb_result scene_open_furnace_number(const char *text, float *number)
{
	char *end;
	*number = strtof(text, &end);
	if (end != text && *end == '\0' && *number >= 0.0f && *number < 1.0f)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "furnace:%s: the reflectance of its walls must be at least 0 and below 1; try furnace:0.5", text);
}

stilb_result stilb_scene_open(const char *name, stilb_scene **scene)
{
	return stilb_scene_open_with(name, &(stilb_scene_open_options){0}, scene);
}

/* Makes figure 0, whose skins may put its meshes where they were not: a camera that was to see all is set again. */
static stilb_result scene_open_figures(stilb_scene *scene)
{
	stilb_result result = scene_play_begin(scene);
	if (result == STILB_OK && scene->figures && scene->framed)
		scene->camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, 1.0f);
	return result;
}

/* The scene in a file. A name that is no file is STILB_ERROR_ARGUMENT. */
static stilb_result scene_open_file(const char *path, const stilb_scene_open_options *options, stilb_scene **scene)
{
	scene_import_limits limits = scene_import_limits_default();
	limits.allow_outside = options->allow_outside;
	limits.give_up = options->give_up;
	limits.opened = options->opened;
	limits.progress = options->progress;
	limits.user = options->user;
	limits.quiet = options->quiet;
	limits.most_bytes = options->import_bytes;
	if (access(path, F_OK) != 0 && errno == ENOENT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "'%s': no such file, and no built-in scene (%s)", path,
		                  stilb_scene_builtin_names());
	stilb_result result = scene_import_within(path, &limits, scene);
	if (result == STILB_OK)
		result = scene_open_figures(*scene);
	if (result == STILB_OK)
		result = scene_lights_open(*scene, path, options->quiet, options->opened, options->user);
	if (result != STILB_OK) {
		stilb_scene_destroy(*scene);
		*scene = NULL;
		return result;
	}
	(*scene)->camera.tone = SHADE_TONE_NEUTRAL;
	for (uint32_t i = 0; i < (*scene)->camera_count; i++)
		(*scene)->cameras[i].camera.tone = SHADE_TONE_NEUTRAL;
	if (scene_is_lit(*scene))
		return result;
	(*scene)->unlit = true;
	if (options->dark)
		return result;
	if (!options->quiet)
		stilb_log("%s: it has no light: a grey sky shines on it", path);
	(*scene)->surroundings = (stilb_scene_surroundings){.sky = {1, 1, 1}, .ground = {0.4f, 0.4f, 0.4f}};
	return result;
}

stilb_result stilb_scene_open_with(const char *name, const stilb_scene_open_options *options, stilb_scene **scene)
{
	PROFILE("scene open");
	STILB_ASSERT(name && options && scene);
	*scene = NULL;
	if (options->import_bytes)
		*options->import_bytes = 0;
	for (size_t i = 0; i < sizeof scene_builtins / sizeof *scene_builtins; i++) {
		const struct scene_builtin *builtin = &scene_builtins[i];
		size_t length = strlen(builtin->name);
		bool takes_number = builtin->name[length - 1] == ':';
		float number = 0.0f;
		bool named = takes_number ? strncmp(name, builtin->name, length) == 0 : strcmp(name, builtin->name) == 0;
		if (!named)
			continue;
		stilb_result result = takes_number ? scene_open_furnace_number(name + length, &number) : STILB_OK;
		return result == STILB_OK ? builtin->create(number, scene) : result;
	}
	return scene_open_file(name, options, scene);
}
