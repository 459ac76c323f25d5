/* Reading presets. */
#include "post/post_preset.h"

#include "base/base_contract.h"
#include "base/base_file.h"
#include "base/base_json.h"
#include "scene/open/scene_json.h"
#include "scene/scene_look.h"
#include "shading/shade_tonemap.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PRESET_BYTES (1u << 20) /* of a file, at most */
#define PRESET_FAR 1e6f         /* metres, either way, of an area */
#define PRESET_MOST 1000.0f     /* of what has no other end */
#define PRESET_STOPS 32.0f

typedef struct preset_reader {
	const char *path;
	scene_json json;
	stilb_post_preset *preset;
	stilb_result result; /* of files of tables */
} preset_reader;

/* ---- values ------------------------------------------------------------------------------------------------------ */

static float preset_number(preset_reader *r, uint32_t key, float low, float high)
{
	char name[32];
	double number = scene_json_value(&r->json, key + 1);
	scene_json_copy(&r->json, key, name, sizeof name);
	if (!(number >= (double)low && number <= (double)high))
		scene_json_blame(&r->json, key + 1, "'%s' is no number from %g to %g", name, (double)low, (double)high);
	return (float)number;
}

/* The index of a word in a NULL-terminated list. */
static uint32_t preset_choice(preset_reader *r, uint32_t key, const char *const *words)
{
	char name[32], list[256] = "";
	size_t used = 0;
	for (uint32_t i = 0; words[i]; i++) {
		if (scene_json_is(&r->json, key + 1, words[i]))
			return i;
		if (used < sizeof list)
			used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "", words[i]);
	}
	scene_json_copy(&r->json, key, name, sizeof name);
	scene_json_blame(&r->json, key + 1, "'%s' is none of %s", name, list);
	return 0;
}

/* Numbers of an array, each in its range. */
static void preset_numbers(preset_reader *r, uint32_t object, uint32_t key, float *out, uint32_t count, float low,
                           float high)
{
	char name[32];
	scene_json_copy(&r->json, key, name, sizeof name);
	bool good = scene_json_numbers(&r->json, object, name, out, count);
	for (uint32_t i = 0; good && i < count; i++)
		good = out[i] >= low && out[i] <= high;
	if (!good)
		scene_json_blame(&r->json, key + 1, "'%s' is not %u numbers from %g to %g", name, count, (double)low,
		                 (double)high);
}

/* The table of a file beside the preset; *name: of the file, to be freed. */
static stilb_post_table *preset_table(preset_reader *r, uint32_t key, char **name)
{
	char file[PATH_MAX], path[PATH_MAX];
	const char *slash = strrchr(r->path, '/');
	stilb_post_table *table = NULL;
	size_t size = scene_json_copy(&r->json, key + 1, file, sizeof file);
	if (r->json.fault[0])
		return NULL;
	int folder = slash && file[0] != '/' ? (int)(slash - r->path + 1) : 0;
	if (size >= sizeof file || snprintf(path, sizeof path, "%.*s%s", folder, r->path, file) >= (int)sizeof path)
		scene_json_blame(&r->json, key + 1, "the name of the table is too long");
	else
		r->result = stilb_post_table_open(path, &table);
	*name = table ? strdup(path) : NULL;
	if (table && !*name)
		r->result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the name of a table");
	return table;
}

/* ---- members ----------------------------------------------------------------------------------------------------- */

typedef enum preset_kind { PRESET_NUMBER, PRESET_COUNT, PRESET_PAIR, PRESET_CHOICE } preset_kind;

/* Members that are settings. */
typedef struct preset_field {
	const char *key;
	preset_kind kind;
	size_t at; /* in stilb_post_settings; of a pair that of the first float, behind which the second stands */
	float low, high;
	const char *const *words;
} preset_field;

#define AT(member) offsetof(stilb_post_settings, member)
static_assert(AT(exposure_high) == AT(exposure_low) + sizeof(float) &&
                  AT(exposure_brightest) == AT(exposure_darkest) + sizeof(float),
              "pairs");
static_assert(sizeof(stilb_post_bloom_format) == sizeof(uint32_t) && sizeof(stilb_post_dither) == sizeof(uint32_t) &&
                  sizeof(stilb_post_place) == sizeof(uint32_t),
              "choices are written as such");

static const preset_field preset_fields[] = {
	{"ao", PRESET_NUMBER, AT(occlusion), 0.0f, 1.0f, NULL},
	{"ao_radius", PRESET_NUMBER, AT(occlusion_radius), 0.0f, PRESET_FAR, NULL},
	{"bloom", PRESET_NUMBER, AT(bloom), 0.0f, 1.0f, NULL},
	{"bloom_width", PRESET_NUMBER, AT(bloom_width), 0.0f, 1.0f, NULL},
	{"bloom_format", PRESET_CHOICE, AT(bloom_format), 0.0f, 0.0f, stilb_post_bloom_format_names},
	{"post", PRESET_CHOICE, AT(place), 0.0f, 0.0f, stilb_post_place_names},
	{"dither", PRESET_CHOICE, AT(dither), 0.0f, 0.0f, stilb_post_dither_names},
	{"aa", PRESET_CHOICE, AT(aa), 0.0f, 0.0f, stilb_post_aa_names},
	{"motion_blur", PRESET_NUMBER, AT(motion_blur), 0.0f, 1.0f, NULL},
	{"motion_blur_most", PRESET_NUMBER, AT(motion_blur_most), 0.0f, 1.0f, NULL},
	{"motion_blur_of", PRESET_CHOICE, AT(motion), 0.0f, 0.0f, stilb_post_motion_names},
	{"motion_blur_far", PRESET_NUMBER, AT(motion_blur_far), 0.0f, PRESET_FAR, NULL},
	{"reflections", PRESET_CHOICE, AT(reflections), 0.0f, 0.0f, stilb_post_reflections_names},
	{"dof", PRESET_CHOICE, AT(dof), 0.0f, 0.0f, stilb_post_dof_names},
	{"aperture", PRESET_NUMBER, AT(aperture), 0.0f, PRESET_FAR, NULL},
	{"focus", PRESET_NUMBER, AT(focus), 0.0f, PRESET_FAR, NULL},
	{"blades", PRESET_COUNT, AT(blades), 0.0f, 16.0f, NULL},
	{"exposure_percentiles", PRESET_PAIR, AT(exposure_low), 0.0f, 1.0f, NULL},
	{"exposure_speed", PRESET_NUMBER, AT(exposure_speed), 0.0f, PRESET_MOST, NULL},
	{"exposure_rate", PRESET_NUMBER, AT(exposure_rate), 0.0f, PRESET_MOST, NULL},
	{"exposure_range", PRESET_PAIR, AT(exposure_darkest), -PRESET_STOPS, PRESET_STOPS, NULL},
};
#undef AT
enum { PRESET_FIELDS = sizeof preset_fields / sizeof *preset_fields };

/* The members of the preset that are more than a setting, and those of an area. */
enum { PRESET_EXPOSURE = PRESET_FIELDS, PRESET_TONE, PRESET_GRADE, PRESET_AREAS, PRESET_MEMBERS };
static const char *const preset_others[] = {"exposure", "tone", "grade", "areas"};
enum { AREA_LOW, AREA_HIGH, AREA_BLEND, AREA_EXPOSURE, AREA_GRADE, AREA_MEMBERS };
static const char *const area_members[AREA_MEMBERS] = {"low", "high", "blend", "exposure", "grade"};

static const char *preset_member(uint32_t which)
{
	return which < PRESET_FIELDS ? preset_fields[which].key : preset_others[which - PRESET_FIELDS];
}

/* The number of a member by its key; a fault if there is none of that name, or if it was seen before. */
static uint32_t preset_which(preset_reader *r, uint32_t key, bool area, uint32_t *seen)
{
	uint32_t count = area ? AREA_MEMBERS : PRESET_MEMBERS, which = 0;
	char name[48], list[160] = "";
	size_t used = 0;
	while (which < count && !scene_json_is(&r->json, key, area ? area_members[which] : preset_member(which)))
		which++;
	scene_json_copy(&r->json, key, name, sizeof name);
	for (uint32_t i = 0; area && i < count && used < sizeof list; i++)
		used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "", area_members[i]);
	if (which == count)
		scene_json_blame(&r->json, key, "'%s' is no member of %s%s", name, area ? "an area: " : "a preset", list);
	else if (*seen >> which & 1u)
		scene_json_blame(&r->json, key, "'%s' was there before", name);
	*seen |= which < count ? 1u << which : 0u;
	return which;
}

/* The next key of an object; SCENE_JSON_NONE: there is none, or there was a fault. */
static uint32_t preset_next(const preset_reader *r, uint32_t object, uint32_t key)
{
	uint32_t next = r->json.tokens[key + 1].next;
	bool more = next < r->json.tokens[object].next && r->json.fault[0] == '\0' && r->result == STILB_OK;
	return more ? next : SCENE_JSON_NONE;
}

static bool preset_is_object(preset_reader *r, uint32_t token, const char *what)
{
	bool is = r->json.tokens[token].kind == SCENE_JSON_OBJECT;
	if (!is)
		scene_json_blame(&r->json, token, "%s is no object { ... }", what);
	return is;
}

static void preset_area(preset_reader *r, uint32_t object)
{
	stilb_post_preset *p = r->preset;
	uint32_t seen = 0, number = p->area_count;
	if (number == STILB_POST_MAX_AREAS) {
		scene_json_blame(&r->json, object, "there are more than %u areas", STILB_POST_MAX_AREAS);
		return;
	}
	stilb_post_area *area = &p->areas[number];
	*area = (stilb_post_area){.blend = 1.0f};
	p->area_count++;
	if (!preset_is_object(r, object, "an area"))
		return;
	for (uint32_t key = scene_json_first(&r->json, object); key != SCENE_JSON_NONE; key = preset_next(r, object, key))
		switch (preset_which(r, key, true, &seen)) {
		case AREA_LOW:
			preset_numbers(r, object, key, area->low, 3, -PRESET_FAR, PRESET_FAR);
			break;
		case AREA_HIGH:
			preset_numbers(r, object, key, area->high, 3, -PRESET_FAR, PRESET_FAR);
			break;
		case AREA_BLEND:
			area->blend = preset_number(r, key, 0.0f, PRESET_FAR);
			break;
		case AREA_EXPOSURE:
			area->exposure = preset_number(r, key, -PRESET_STOPS, PRESET_STOPS);
			break;
		case AREA_GRADE:
			area->table = p->area_grades[number] = preset_table(r, key, &p->area_files[number]);
			break;
		default:
			break;
		}
	for (int c = 0; c < 3; c++)
		if (!(area->low[c] < area->high[c]))
			scene_json_blame(&r->json, object, "the area's 'low' is not below its 'high' in each of three numbers");
}

static void preset_setting(preset_reader *r, uint32_t object, uint32_t key, const preset_field *field)
{
	char *at = (char *)&r->preset->settings + field->at;
	float pair[2];
	if (field->kind == PRESET_CHOICE) {
		uint32_t choice = preset_choice(r, key, field->words);
		memcpy(at, &choice, sizeof choice);
		return;
	}
	if (field->kind == PRESET_COUNT) {
		float number = preset_number(r, key, field->low, field->high);
		uint32_t count = number > 0.0f ? (uint32_t)number : 0;
		if ((float)count != number && r->json.fault[0] == '\0')
			scene_json_blame(&r->json, key + 1, "'%s' is no whole number", field->key);
		memcpy(at, &count, sizeof count);
		return;
	}
	if (field->kind == PRESET_NUMBER) {
		pair[0] = preset_number(r, key, field->low, field->high);
		memcpy(at, pair, sizeof *pair);
		return;
	}
	preset_numbers(r, object, key, pair, 2, field->low, field->high);
	if (!(pair[0] < pair[1]))
		scene_json_blame(&r->json, key + 1, "'%s' is not a lower and a higher number", field->key);
	memcpy(at, pair, sizeof pair);
}

static void preset_exposure(preset_reader *r, uint32_t key)
{
	stilb_post_preset *p = r->preset;
	p->has_exposure = true;
	p->settings.exposure_adapts = scene_json_is(&r->json, key + 1, "adapt");
	if (p->settings.exposure_adapts)
		return;
	if (r->json.tokens[key + 1].kind == SCENE_JSON_NUMBER)
		p->exposure = preset_number(r, key, -PRESET_STOPS, PRESET_STOPS);
	else
		scene_json_blame(&r->json, key + 1, "'exposure' is neither \"adapt\" nor a number of stops");
}

static void preset_areas(preset_reader *r, uint32_t object)
{
	uint32_t list = scene_json_array(&r->json, object, "areas");
	for (uint32_t at = scene_json_first(&r->json, list);
	     at != SCENE_JSON_NONE && r->json.fault[0] == '\0' && r->result == STILB_OK;
	     at = scene_json_after(&r->json, list, at))
		preset_area(r, at);
}

static void preset_read(preset_reader *r)
{
	stilb_post_preset *p = r->preset;
	uint32_t seen = 0, root = SCENE_JSON_ROOT;
	if (!preset_is_object(r, root, "a preset"))
		return;
	for (uint32_t key = scene_json_first(&r->json, root); key != SCENE_JSON_NONE; key = preset_next(r, root, key)) {
		uint32_t which = preset_which(r, key, false, &seen);
		if (which < PRESET_FIELDS)
			preset_setting(r, root, key, &preset_fields[which]);
		else if (which == PRESET_EXPOSURE)
			preset_exposure(r, key);
		else if (which == PRESET_GRADE)
			p->grade = preset_table(r, key, &p->grade_file);
		else if (which == PRESET_AREAS)
			preset_areas(r, root);
		else if (which == PRESET_TONE)
			p->tone = preset_choice(r, key, stilb_scene_tone_names);
		p->has_tone |= which == PRESET_TONE;
	}
	const stilb_post_settings *s = &p->settings;
	if (r->json.fault[0] == '\0' && s->blades > 0 && s->blades < 3)
		scene_json_blame(&r->json, root, "'blades' are 3 to 16, or 0: a circle");
	if (r->json.fault[0] == '\0' && s->dof != STILB_POST_DOF_OFF && s->aperture > 0.0f && s->focus == 0.0f)
		scene_json_blame(&r->json, root, "'dof' with an 'aperture' needs a 'focus'");
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* All bytes of the file; to be freed. */
static stilb_result preset_text(const char *path, char **text, size_t *size)
{
	FILE *file;
	*text = NULL;
	stilb_result result = stilb_file_read_open(path, &file);
	if (result != STILB_OK)
		return result;
	*text = malloc(PRESET_BYTES + 1);
	*size = *text ? fread(*text, 1, PRESET_BYTES + 1, file) : 0;
	int error = ferror(file) ? errno : 0;
	fclose(file);
	if (*text && error == 0 && *size <= PRESET_BYTES)
		return STILB_OK;
	result = !*text       ? stilb_fail(STILB_ERROR_MEMORY, "%s: no memory to read it", path)
	         : error != 0 ? stilb_fail(STILB_ERROR_FILE, "%s: cannot be read: %s", path, strerror(error))
	                      : stilb_fail(STILB_ERROR_FILE, "%s: it is larger than 1 MiB: it is no preset", path);
	free(*text);
	*text = NULL;
	return result;
}

/* The outcome of what was read, with the file's name. */
static stilb_result preset_outcome(const preset_reader *r)
{
	char words[512];
	if (r->result != STILB_OK || r->json.fault[0] == '\0') {
		snprintf(words, sizeof words, "%s", stilb_error_message());
		return r->result == STILB_OK ? STILB_OK : stilb_fail(r->result, "%s: %s", r->path, words);
	}
	return stilb_fail(STILB_ERROR_FILE, "%s: %s", r->path, r->json.fault);
}

stilb_result stilb_post_preset_open(const char *path, stilb_post_preset **preset)
{
	STILB_ASSERT(path && preset);
	char *text;
	size_t size;
	*preset = NULL;
	stilb_result result = preset_text(path, &text, &size);
	if (result != STILB_OK)
		return result;
	preset_reader r = {.path = path, .preset = calloc(1, sizeof *r.preset)};
	if (!r.preset) {
		free(text);
		return stilb_fail(STILB_ERROR_MEMORY, "%s: no memory for a preset", path);
	}
	r.result = scene_json_parse(&r.json, text, size);
	if (r.result == STILB_OK)
		preset_read(&r);
	result = preset_outcome(&r);
	scene_json_finish(&r.json);
	free(text);
	if (result != STILB_OK) {
		stilb_post_preset_destroy(r.preset);
		return result;
	}
	STILB_ASSERT(stilb_post_settings_are_valid(&r.preset->settings));
	*preset = r.preset;
	return STILB_OK;
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

static void preset_put_numbers(stilb_json *json, const char *key, const float *numbers, uint32_t count)
{
	stilb_json_begin(json, key, '[');
	for (uint32_t i = 0; i < count; i++)
		stilb_json_float(json, NULL, numbers[i]);
	stilb_json_end(json, ']');
}

/* A setting, unless it is as in {0}. */
static void preset_put_setting(stilb_json *json, const stilb_post_settings *settings, const preset_field *field)
{
	const char *at = (const char *)settings + field->at;
	float pair[2] = {0};
	uint32_t word = 0;
	memcpy(pair, at, field->kind == PRESET_PAIR ? sizeof pair : sizeof *pair);
	memcpy(&word, at, sizeof word);
	if (word == 0 && pair[1] == 0.0f)
		return;
	if (field->kind == PRESET_CHOICE)
		stilb_json_string(json, field->key, field->words[word]);
	else if (field->kind == PRESET_COUNT)
		stilb_json_int(json, field->key, word);
	else if (field->kind == PRESET_PAIR)
		preset_put_numbers(json, field->key, pair, 2);
	else
		stilb_json_float(json, field->key, pair[0]);
}

/* The name that a preset of this path has for a table's file. False: it has none, or there is no such file. */
static bool preset_put_table(stilb_json *json, const char *path, const char *file)
{
	char folder[PATH_MAX], whole[PATH_MAX], beside[PATH_MAX];
	const char *slash = strrchr(path, '/');
	snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
	if (!file || !realpath(file, whole) || !realpath(folder, beside))
		return false;
	size_t length = strlen(beside);
	bool here = strncmp(whole, beside, length) == 0 && whole[length] == '/' && !strchr(whole + length + 1, '/');
	stilb_json_string(json, "grade", here ? whole + length + 1 : whole);
	return true;
}

static bool preset_put_areas(stilb_json *json, const stilb_post_preset *preset, const char *path)
{
	bool named = true;
	stilb_json_begin(json, "areas", '[');
	for (uint32_t a = 0; a < preset->area_count; a++) {
		const stilb_post_area *area = &preset->areas[a];
		stilb_json_begin(json, NULL, '{');
		preset_put_numbers(json, "low", area->low, 3);
		preset_put_numbers(json, "high", area->high, 3);
		stilb_json_float(json, "blend", area->blend);
		if (area->exposure != 0.0f)
			stilb_json_float(json, "exposure", area->exposure);
		if (area->table)
			named &= preset_put_table(json, path, preset->area_files[a]);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	return named;
}

stilb_result stilb_post_preset_save(const stilb_post_preset *preset, const char *path)
{
	STILB_ASSERT(preset && path && stilb_post_settings_are_valid(&preset->settings));
	STILB_ASSERT(preset->area_count <= STILB_POST_MAX_AREAS);
	stilb_json json = {0};
	bool named = true;
	stilb_json_begin(&json, NULL, '{');
	if (preset->settings.exposure_adapts)
		stilb_json_string(&json, "exposure", "adapt");
	else if (preset->has_exposure)
		stilb_json_float(&json, "exposure", preset->exposure);
	for (uint32_t f = 0; f < PRESET_FIELDS; f++)
		preset_put_setting(&json, &preset->settings, &preset_fields[f]);
	if (preset->has_tone)
		stilb_json_string(&json, "tone", stilb_scene_tone_names[preset->tone]);
	if (preset->grade)
		named = preset_put_table(&json, path, preset->grade_file);
	if (preset->area_count > 0)
		named &= preset_put_areas(&json, preset, path);
	stilb_json_end(&json, '}');
	if (named)
		return stilb_json_save(&json, path);
	stilb_json_finish(&json);
	return stilb_fail(STILB_ERROR_ARGUMENT, "'%s': a table of colours has no file that it could be named by", path);
}

void stilb_post_preset_destroy(stilb_post_preset *preset)
{
	if (!preset)
		return;
	stilb_post_table_destroy(preset->grade);
	free(preset->grade_file);
	for (uint32_t a = 0; a < STILB_POST_MAX_AREAS; a++) {
		stilb_post_table_destroy(preset->area_grades[a]);
		free(preset->area_files[a]);
	}
	free(preset);
}
