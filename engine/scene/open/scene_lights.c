#include "scene/open/scene_lights.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "scene/edit/scene_check.h"
#include "scene/open/scene_json.h"
#include "scene/open/scene_lights_file.h"
#include "scene/scene_internal.h"
#include "shading/shade_luminance.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define LIGHTS_BYTES (64u << 20) /* of a file, at most */
#define LIGHTS_COLDEST 1000.0    /* kelvin, of shade_color_of_temperature */
#define LIGHTS_HOTTEST 15000.0

const char *const stilb_scene_light_kind_names[] = {
	[STILB_SCENE_LIGHT_POINT] = "point",
	[STILB_SCENE_LIGHT_SPOT] = "spot",
	[STILB_SCENE_LIGHT_DIRECTIONAL] = "directional",
	[STILB_SCENE_LIGHT_SPHERE] = "sphere",
	[STILB_SCENE_LIGHT_DISK] = "disk",
	[STILB_SCENE_LIGHT_RECTANGLE] = "rectangle",
	NULL,
};
static_assert(sizeof stilb_scene_light_kind_names / sizeof(char *) == STILB_SCENE_LIGHT_KINDS + 1, "every kind");

const char *stilb_scene_light_unit_name(const stilb_scene_light *light)
{
	bool across = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL;
	if (light->unit == STILB_SCENE_LIGHT_PHOTOMETRIC)
		return across ? "lx" : "cd";
	return across ? "W/m2" : "W/sr";
}

static float lights_brightest(const float color[3])
{
	return fmaxf(color[0], fmaxf(color[1], color[2]));
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* The mount of a light on a node; NULL: it hangs on none. */
static stilb_scene_mount *lights_mount(const stilb_scene *scene, uint32_t light)
{
	bool hangs = scene->light_mounts && scene->light_mounts[light].node > 0;
	return hangs ? &scene->light_mounts[light] : NULL;
}

/* Where the light is: in the world, or in the space of its node. */
static const float *lights_place(const stilb_scene *scene, uint32_t light)
{
	const stilb_scene_mount *mount = lights_mount(scene, light);
	return mount ? mount->position : scene->lights[light].position;
}

/* Moves a light to such a place; false as of stilb_scene_move_light. */
static bool lights_put(stilb_scene *scene, uint32_t light, const float place[3])
{
	stilb_scene_mount *mount = lights_mount(scene, light);
	stilb_scene_light placed = scene->lights[light];
	if (placed.kind == STILB_SCENE_LIGHT_DIRECTIONAL || !scene_is_within(place, 3, -SCENE_FAR, SCENE_FAR))
		return false;
	memcpy(placed.position, place, sizeof placed.position);
	if (mount) {
		stilb_scene_mount moved = *mount;
		memcpy(moved.position, place, sizeof moved.position);
		if (!scene_mount_light(&moved, &scene->nodes.to_world[mount->node - 1], &placed))
			return false;
		*mount = moved;
	}
	scene->lights[light] = placed;
	return true;
}

bool stilb_scene_move_light(stilb_scene *scene, uint32_t light, const float position[3])
{
	STILB_ASSERT(light < scene->light_count);
	const stilb_scene_mount *mount = lights_mount(scene, light);
	if (!mount)
		return lights_put(scene, light, position);
	stilb_mat4 to_node = stilb_mat4_inverse(&scene->nodes.to_world[mount->node - 1]);
	float place[3];
	if (to_node.m[15] == 0.0f)
		return false;
	for (int row = 0; row < 3; row++) {
		const float *m = to_node.m + row;
		place[row] = m[0] * position[0] + m[4] * position[1] + m[8] * position[2] + m[12];
	}
	return lights_put(scene, light, place);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Whether a member of a light is what the light has. */
static void read_is(scene_json *json, uint32_t value, const char *key, const char *want)
{
	char text[32];
	scene_json_copy(json, value, text, sizeof text);
	if (!scene_json_is(json, value, want))
		scene_json_blame(json, value, "its %s is '%s', the scene's light has '%s': is it of another scene?", key, text,
		                 want);
}

static double read_number(scene_json *json, uint32_t value, const char *key, double low, double high)
{
	double number = scene_json_value(json, value);
	if (!(number >= low && number <= high))
		scene_json_blame(json, value, "'%s' is no number from %g to %g", key, low, high);
	return number;
}

/* A light's members, as they are read. */
typedef struct read_light {
	double intensity; /* below 0: it says nothing */
	float color[3];   /* below 0: likewise */
	float place[3];
	bool has_place;
	uint32_t seen; /* a bit for each of read_members */
} read_light;

/* What a light may have. */
enum { READ_LIGHT, READ_KIND, READ_UNIT, READ_INTENSITY, READ_COLOR, READ_TEMPERATURE, READ_PLACE, READ_MEMBERS };
static const char *const read_members[READ_MEMBERS] = {"light", "kind",        "unit", "intensity",
                                                       "color", "temperature", "place"};

static void read_member(scene_json *json, uint32_t object, uint32_t key, const stilb_scene_light *light,
                        read_light *out)
{
	uint32_t value = key + 1, which = 0;
	char name[32];
	while (which < READ_MEMBERS && !scene_json_is(json, key, read_members[which]))
		which++;
	scene_json_copy(json, key, name, sizeof name);
	if (which == READ_MEMBERS) {
		scene_json_blame(json, key,
		                 "'%s' is no member of a light: light, kind, unit, intensity, color, temperature, place", name);
		return;
	}
	if (out->seen >> which & 1u) {
		scene_json_blame(json, key, "'%s' was there before", name);
		return;
	}
	out->seen |= 1u << which;
	switch (which) {
	case READ_KIND:
		read_is(json, value, "kind", stilb_scene_light_kind_names[light->kind]);
		break;
	case READ_UNIT:
		read_is(json, value, "unit", stilb_scene_light_unit_name(light));
		break;
	case READ_INTENSITY:
		out->intensity = read_number(json, value, "intensity", 0.0, (double)SCENE_FAR);
		break;
	case READ_TEMPERATURE: {
		stilb_vec3 color =
			shade_color_of_temperature((float)read_number(json, value, "temperature", LIGHTS_COLDEST, LIGHTS_HOTTEST));
		for (int c = 0; c < 3; c++)
			out->color[c] = color[c];
		break;
	}
	case READ_COLOR:
		scene_json_numbers(json, object, "color", out->color, 3);
		if (!scene_is_within(out->color, 3, 0.0f, SCENE_FAR) || !(lights_brightest(out->color) > 0.0f))
			scene_json_blame(json, value, "'color' is not three numbers >= 0, one of them above 0");
		break;
	case READ_PLACE:
		out->has_place = scene_json_numbers(json, object, "place", out->place, 3);
		if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL)
			scene_json_blame(json, value, "a directional light has no place");
		break;
	default:
		break;
	}
	if (out->seen >> READ_COLOR & out->seen >> READ_TEMPERATURE & 1u)
		scene_json_blame(json, value, "it has a color and a temperature; leave one out");
}

static void read_apply(scene_json *json, uint32_t object, stilb_scene *scene, uint32_t index, const read_light *from)
{
	stilb_scene_light light = scene->lights[index];
	float now = lights_brightest(light.intensity);
	double intensity = from->intensity < 0.0 ? (double)now : from->intensity;
	bool colored = from->color[0] >= 0.0f;
	if (light.face && (colored || from->intensity >= 0.0))
		scene_json_blame(json, object, "light %u shines from a surface, whose material says how brightly", index);
	for (int c = 0; c < 3; c++) {
		float share = colored      ? from->color[c] / lights_brightest(from->color)
		              : now > 0.0f ? light.intensity[c] / now
		                           : 1.0f;
		light.intensity[c] = (float)(intensity * (double)share);
	}
	if (stilb_scene_light_mistake(&light))
		scene_json_blame(json, object, "light %u: %s", index, stilb_scene_light_mistake(&light));
	if (json->fault[0])
		return;
	scene->lights[index] = light;
	if (from->has_place && !lights_put(scene, index, from->place))
		scene_json_blame(json, object, "light %u: its place is not within 1e18 m", index);
}

/* Reads one light. seen: of each light, whether an earlier one was it. */
static void read_one(scene_json *json, uint32_t object, stilb_scene *scene, bool *seen)
{
	uint32_t which = scene_json_member(json, object, "light");
	uint64_t index = which == SCENE_JSON_NONE ? UINT64_MAX : scene_json_whole(json, which);
	if (which == SCENE_JSON_NONE)
		scene_json_blame(json, object, "it does not say which light: 'light'");
	else if (index >= scene->light_count)
		scene_json_blame(json, which, "there is no such light; the scene has %u, from 0 on", scene->light_count);
	else if (seen[index])
		scene_json_blame(json, which, "light %u was there before", (uint32_t)index);
	if (json->fault[0])
		return;
	seen[index] = true;
	read_light light = {.intensity = -1.0, .color = {-1.0f, -1.0f, -1.0f}};
	for (uint32_t key = scene_json_first(json, object); key != SCENE_JSON_NONE && !json->fault[0];) {
		read_member(json, object, key, &scene->lights[index], &light);
		uint32_t next = json->tokens[key + 1].next;
		key = next < json->tokens[object].next ? next : SCENE_JSON_NONE;
	}
	if (!json->fault[0])
		read_apply(json, object, scene, (uint32_t)index, &light);
}

/* Applies the text to the scene. *count: lights that it names. */
static stilb_result read_text(stilb_scene *scene, const char *text, size_t size, uint32_t *count)
{
	scene_json json;
	stilb_result result = scene_json_parse(&json, text, size);
	if (result != STILB_OK)
		return result;
	bool *seen = calloc(scene->light_count + 1, sizeof *seen);
	uint32_t list = scene_json_array(&json, SCENE_JSON_ROOT, "lights");
	if (list == SCENE_JSON_NONE)
		scene_json_blame(&json, SCENE_JSON_ROOT, "it has no list 'lights'");
	else if (json.tokens[list].next < json.tokens[SCENE_JSON_ROOT].next ||
	         scene_json_first(&json, SCENE_JSON_ROOT) + 1 != list)
		scene_json_blame(&json, SCENE_JSON_ROOT, "it has more than one list 'lights', which is all that it may have");
	*count = 0;
	for (uint32_t at = scene_json_first(&json, list); seen && at != SCENE_JSON_NONE && !json.fault[0];
	     at = scene_json_after(&json, list, at), *count += 1)
		read_one(&json, at, scene, seen);
	result =
		seen ? scene_json_check(&json) : stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", scene->light_count);
	free(seen);
	scene_json_finish(&json);
	return result;
}

/* The whole file. *text: to be freed. */
static stilb_result read_file(const char *path, char **text, size_t *size)
{
	FILE *stream;
	*text = NULL;
	stilb_result result = stilb_file_read_open(path, &stream);
	if (result != STILB_OK)
		return result;
	long end = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : -1;
	rewind(stream);
	if (end < 0 || end > (long)LIGHTS_BYTES)
		result = stilb_fail(STILB_ERROR_FILE, "'%s': it is larger than %u MiB", path, LIGHTS_BYTES >> 20);
	*size = end > 0 ? (size_t)end : 0;
	*text = result == STILB_OK ? malloc(*size + 1) : NULL;
	if (result == STILB_OK && !*text)
		result = stilb_fail(STILB_ERROR_MEMORY, "'%s': no memory for %zu bytes", path, *size);
	if (result == STILB_OK && fread(*text, 1, *size, stream) != *size)
		result = stilb_fail(STILB_ERROR_FILE, "'%s': %s", path, strerror(errno));
	fclose(stream);
	return result;
}

/* Reads the file and applies it. */
static stilb_result lights_read(stilb_scene *scene, const char *path, uint32_t *count)
{
	char *text;
	size_t size;
	bool whole = true;
	stilb_result result = read_file(path, &text, &size);
	if (result == STILB_OK) {
		result = read_text(scene, text, size, count);
		whole = result == STILB_OK;
	}
	if (!whole) {
		char words[512];
		snprintf(words, sizeof words, "%s", stilb_error_message());
		stilb_fail(result, "'%s': %s; mend the file or move it away", path, words);
	}
	free(text);
	return result;
}

/* ---- the lights of the scene's file ------------------------------------------------------------------------------ */

/* Keeps the lights as they are. */
static stilb_result lights_keep(stilb_scene *scene, const char *path)
{
	struct stilb_scene_lights_file *file = calloc(1, sizeof *file);
	size_t room = strlen(path) + sizeof STILB_SCENE_LIGHTS_SUFFIX;
	uint32_t count = scene->light_count;
	scene->lights_file = file;
	if (file) {
		file->count = count;
		file->path = malloc(room);
		file->lights = malloc((count + 1) * sizeof *file->lights);
		file->mounts = scene->light_mounts ? malloc((count + 1) * sizeof *file->mounts) : NULL;
	}
	if (!file || !file->path || !file->lights || (scene->light_mounts && !file->mounts))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lights of '%s'", path);
	snprintf(file->path, room, "%s%s", path, STILB_SCENE_LIGHTS_SUFFIX);
	if (count > 0)
		memcpy(file->lights, scene->lights, count * sizeof *file->lights);
	if (file->mounts)
		memcpy(file->mounts, scene->light_mounts, count * sizeof *file->mounts);
	return STILB_OK;
}

/* Remembers which file is on the disk now. */
static void lights_know(struct stilb_scene_lights_file *file)
{
	if (stat(file->path, &file->known) != 0)
		file->known = (struct stat){0};
}

bool stilb_scene_lights_changed(const stilb_scene *scene)
{
	STILB_ASSERT(scene);
	const struct stilb_scene_lights_file *file = scene->lights_file;
	if (!file)
		return false;
	struct stat now;
	if (stat(file->path, &now) != 0)
		now = (struct stat){0};
	const struct stat *known = &file->known;
	return now.st_ino != known->st_ino || now.st_size != known->st_size ||
	       now.st_mtim.tv_sec != known->st_mtim.tv_sec || now.st_mtim.tv_nsec != known->st_mtim.tv_nsec;
}

stilb_result scene_lights_open(stilb_scene *scene, const char *path, bool quiet,
                               void (*opened)(void *user, const char *path), void *user)
{
	uint32_t count;
	stilb_result result = lights_keep(scene, path);
	if (result != STILB_OK)
		return result;
	if (opened)
		opened(user, scene->lights_file->path);
	lights_know(scene->lights_file); /* before it is read: a later change is one */
	if (access(scene->lights_file->path, F_OK) != 0 && (errno == ENOENT || errno == ENAMETOOLONG))
		return STILB_OK; /* there is none */
	result = lights_read(scene, scene->lights_file->path, &count);
	if (result == STILB_OK && !quiet)
		stilb_log("%s: %u light%s as this file has %s", scene->lights_file->path, count, count == 1 ? "" : "s",
		          count == 1 ? "it" : "them");
	return result;
}

/* True if the scene's list of lights is still that of its file: each is of the same kind and unit, and hangs where it
 * hung. */
static bool lights_are_of_file(const stilb_scene *scene)
{
	const struct stilb_scene_lights_file *file = scene->lights_file;
	if (!file || scene->studio || scene->light_count != file->count || !scene->light_mounts != !file->mounts)
		return false;
	for (uint32_t i = 0; i < file->count; i++) {
		const stilb_scene_light *now = &scene->lights[i], *then = &file->lights[i];
		if (now->kind != then->kind || now->face != then->face ||
		    stilb_scene_light_unit_name(now) != stilb_scene_light_unit_name(then) ||
		    (file->mounts && scene->light_mounts[i].node != file->mounts[i].node))
			return false;
	}
	return true;
}

void stilb_scene_lights_restore(stilb_scene *scene, uint32_t light)
{
	STILB_ASSERT(light < scene->light_count);
	const struct stilb_scene_lights_file *file = scene->lights_file;
	if (!lights_are_of_file(scene))
		return;
	memcpy(scene->lights[light].intensity, file->lights[light].intensity, sizeof file->lights->intensity);
	bool hung = file->mounts && file->mounts[light].node > 0;
	lights_put(scene, light, hung ? file->mounts[light].position : file->lights[light].position);
}

/* Writes one light, if it is not as the file has it. */
static void save_one(stilb_json *json, const stilb_scene *scene, uint32_t index)
{
	const struct stilb_scene_lights_file *file = scene->lights_file;
	const stilb_scene_light *light = &scene->lights[index], *from = &file->lights[index];
	bool hung = file->mounts && file->mounts[index].node > 0;
	const float *was = hung ? file->mounts[index].position : from->position;
	const float *place = lights_place(scene, index);
	float brightest = lights_brightest(light->intensity);
	bool lit = memcmp(light->intensity, from->intensity, sizeof from->intensity) != 0;
	bool moved = light->kind != STILB_SCENE_LIGHT_DIRECTIONAL && memcmp(place, was, 3 * sizeof *place) != 0;
	if (!lit && !moved)
		return;
	stilb_json_begin(json, NULL, '{');
	stilb_json_int(json, "light", index);
	stilb_json_string(json, "kind", stilb_scene_light_kind_names[light->kind]);
	if (lit) {
		stilb_json_string(json, "unit", stilb_scene_light_unit_name(light));
		stilb_json_float(json, "intensity", brightest);
	}
	if (lit && brightest > 0.0f) {
		stilb_json_begin(json, "color", '[');
		for (int c = 0; c < 3; c++)
			stilb_json_float(json, NULL, light->intensity[c] / brightest);
		stilb_json_end(json, ']');
	}
	if (moved) {
		stilb_json_begin(json, "place", '[');
		for (int i = 0; i < 3; i++)
			stilb_json_float(json, NULL, place[i]);
		stilb_json_end(json, ']');
	}
	stilb_json_end(json, '}');
}

stilb_result stilb_scene_lights_save(const stilb_scene *scene, const char **path)
{
	STILB_ASSERT(scene);
	struct stilb_scene_lights_file *file = scene->lights_file;
	if (!file)
		return stilb_fail(STILB_ERROR_ARGUMENT, "lights are saved beside a scene's file, and this scene is of none");
	if (!lights_are_of_file(scene))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the lights are not those of the scene's file, which has %u",
		                  file->count);
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_begin(&json, "lights", '[');
	for (uint32_t i = 0; i < scene->light_count; i++)
		save_one(&json, scene, i);
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	if (path)
		*path = file->path;
	stilb_result result = stilb_json_save(&json, file->path);
	lights_know(file);
	return result;
}
