#include "gi/gi_settings.h"

#include "scene/scene_look.h"
#include "shading/shade_specular.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

stilb_gi_settings stilb_gi_settings_default(const stilb_scene *scene)
{
	STILB_ASSERT(scene);
	return (stilb_gi_settings){
		.integrator = STILB_GI_INTEGRATOR_PATH,
		.width = 512,
		.height = 512,
		.samples = 64,
		.sampler = STILB_GI_SAMPLER_SOBOL,
		.filter = STILB_GI_FILTER_BOX,
		.camera = scene->camera,
		.exposure = scene->camera.exposure,
		.tone = scene->camera.tone,
		.lens = {.focus = 1.0f},
		.depth = 64,
		.model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK},
		.rays = 16,
		.cache = {.radius = STILB_GI_CACHE_HESSIAN, .error = 0.05f, .rays = 1024, .gradients = true, .overture = true},
	};
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

typedef enum field_kind {
	FIELD_U32,
	FIELD_U64,
	FIELD_BOOL,
	FIELD_FLOAT,
	FIELD_DOUBLE,
	FIELD_NAME, /* an enum: its names are names[value] */
} field_kind;

typedef struct field {
	const char *name;
	field_kind kind;
	gi_setting_role role;
	size_t offset;
	double low, high; /* the range, both ends included; unused for FIELD_BOOL and FIELD_U64 */
	const char *const *names;
} field;

#define FIELD_NAME_1(id, name, ...) #name,
#define FIELD_NAME_2(number, name) #name,
static const char *const INTEGRATOR_NAMES[] = {STILB_GI_INTEGRATORS(FIELD_NAME_1)};
static const char *const SAMPLER_NAMES[] = {STILB_GI_SAMPLERS(FIELD_NAME_1)};
static const char *const FILTER_NAMES[] = {STILB_GI_FILTERS(FIELD_NAME_1)};
static const char *const BRDF_NAMES[] = {SHADE_BRDFS(FIELD_NAME_2)};
static const char *const ONLY_NAMES[] = {"all", "indirect"};
static const char *const MODE_NAMES[] = {"frozen", "live"};
static const char *const RADIUS_NAMES[] = {"split_sphere", "hessian", "harmonic"};

#define AT(member) offsetof(stilb_gi_settings, member)
#define ROW(kind, role, member, low, high)                                                                             \
	{                                                                                                                  \
#member, kind, role, AT(member), low, high, NULL                                                               \
	}
#define NUMBER(kind, member, low, high) ROW(kind, GI_SETTING_SAMPLE, member, low, high)
#define LIMIT(kind, member, low, high) ROW(kind, GI_SETTING_LIMIT, member, low, high)
#define VIEW(kind, member, low, high) ROW(kind, GI_SETTING_VIEW, member, low, high)
#define SWITCH(member) ROW(FIELD_BOOL, GI_SETTING_SAMPLE, member, 0, 1)
#define NAMED(member, names)                                                                                           \
	{                                                                                                                  \
#member, FIELD_NAME, GI_SETTING_SAMPLE, AT(member), 0, (int)(sizeof names / sizeof *names) - 1, names          \
	}
/* Largest distance in the settings, metres: far beyond the largest coordinate of a triangle (1e10), so that a camera
 * may see all of them; its square is finite in a float. */
#define FARTHEST 1e12

static const field FIELDS[] = {
	NAMED(integrator, INTEGRATOR_NAMES),
	{"channel", FIELD_NAME, GI_SETTING_SAMPLE, AT(channel), 0, STILB_SCENE_CHANNELS_OF_RAYS - 1,
     stilb_scene_channel_names},
	NUMBER(FIELD_U32, width, 1, 65536),
	NUMBER(FIELD_U32, height, 1, 65536),
	LIMIT(FIELD_U32, samples, 1, 65536), /* for some samplers GI_SETTING_SAMPLE: gi_settings_get changes that */
	LIMIT(FIELD_DOUBLE, seconds, 0, 1e9),
	LIMIT(FIELD_FLOAT, error, 0, 1e9),
	NUMBER(FIELD_U64, seed, 0, 0),
	NAMED(sampler, SAMPLER_NAMES),
	NAMED(filter, FILTER_NAMES),
	NUMBER(FIELD_FLOAT, camera.position[0], -FARTHEST, FARTHEST),
	NUMBER(FIELD_FLOAT, camera.position[1], -FARTHEST, FARTHEST),
	NUMBER(FIELD_FLOAT, camera.position[2], -FARTHEST, FARTHEST),
	NUMBER(FIELD_FLOAT, camera.yaw, -1e6, 1e6),
	NUMBER(FIELD_FLOAT, camera.pitch, -1e6, 1e6),
	NUMBER(FIELD_FLOAT, camera.roll, -1e6, 1e6),
	NUMBER(FIELD_FLOAT, camera.fov_y, 1e-4, 3.14),
	NUMBER(FIELD_FLOAT, camera.near_z, 1e-30, FARTHEST),
	NUMBER(FIELD_FLOAT, camera.far_z, 1e-30, 1e4 * FARTHEST),
	NUMBER(FIELD_FLOAT, lens.radius, 0, FARTHEST),
	NUMBER(FIELD_FLOAT, lens.focus, 1e-9, FARTHEST),
	NUMBER(FIELD_U32, lens.blades, 0, 16),
	NUMBER(FIELD_FLOAT, lens.rotation, -1e6, 1e6),
	NUMBER(FIELD_U32, depth, 0, 1024),
	NAMED(model.kind, BRDF_NAMES),
	NUMBER(FIELD_U32, model.ndf, 0, SHADE_NDF_COUNT - 1),
	NUMBER(FIELD_U32, model.g, 0, SHADE_G_COUNT - 1),
	NUMBER(FIELD_U32, model.f, 0, SHADE_F_COUNT - 1),
	NAMED(only, ONLY_NAMES),
	SWITCH(no_shadows),
	SWITCH(firefly_weight),
	SWITCH(denoise),
	NUMBER(FIELD_FLOAT, roulette, 0, 1),
	NUMBER(FIELD_U32, rays, 1, 65536),
	NUMBER(FIELD_FLOAT, ao_distance, 0, FARTHEST),
	SWITCH(ao_weighted),
	VIEW(FIELD_BOOL, progressive, 0, 1),
	VIEW(FIELD_FLOAT, exposure, -100, 100),
	{"tone", FIELD_NAME, GI_SETTING_VIEW, AT(tone), 0, SHADE_TONE_COUNT - 1, stilb_scene_tone_names},
	NAMED(cache.mode, MODE_NAMES),
	NAMED(cache.radius, RADIUS_NAMES),
	NUMBER(FIELD_FLOAT, cache.error, 1e-4, 1),
	NUMBER(FIELD_U32, cache.rays, 16, 65536),
	SWITCH(cache.gradients),
	SWITCH(cache.overture),
	SWITCH(cache.show_records),
};

uint32_t gi_settings_count(void)
{
	return sizeof FIELDS / sizeof *FIELDS;
}

/* Enums and the integers of shade_brdf_model have four bytes, like FIELD_U32. */
static double field_number(const stilb_gi_settings *settings, const field *f)
{
	const char *at = (const char *)settings + f->offset;
	uint32_t integer;
	float single;
	double number = 0.0;
	switch (f->kind) {
	case FIELD_U32:
	case FIELD_NAME:
		memcpy(&integer, at, sizeof integer);
		return integer;
	case FIELD_FLOAT:
		memcpy(&single, at, sizeof single);
		return (double)single;
	case FIELD_DOUBLE:
		memcpy(&number, at, sizeof number);
		return number;
	case FIELD_BOOL:
		return *(const bool *)at;
	case FIELD_U64:
		break; /* every value is valid, and a double could not hold it */
	}
	return number;
}

/* True if a sampler's points depend on how many samples each pixel will have, as those of gi_sampler.c's grids do. */
static bool sampler_plans(stilb_gi_sampler_kind sampler)
{
	return sampler == STILB_GI_SAMPLER_STRATIFIED || sampler == STILB_GI_SAMPLER_BLUE_NOISE;
}

gi_setting gi_settings_get(const stilb_gi_settings *settings, uint32_t index)
{
	STILB_ASSERT(index < gi_settings_count());
	const field *f = &FIELDS[index];
	gi_setting setting = {.name = f->name, .role = f->role};
	double number = field_number(settings, f);
	uint64_t integer;
	if (f->offset == AT(samples) && sampler_plans(settings->sampler))
		setting.role = GI_SETTING_SAMPLE;
	STILB_ASSERT(strlen(f->name) < GI_SETTING_TEXT);
	switch (f->kind) {
	case FIELD_U64:
		memcpy(&integer, (const char *)settings + f->offset, sizeof integer);
		snprintf(setting.value, sizeof setting.value, "%llu", (unsigned long long)integer);
		break;
	case FIELD_NAME:
		snprintf(setting.value, sizeof setting.value, "%s", number <= f->high ? f->names[(uint32_t)number] : "?");
		break;
	case FIELD_BOOL:
		snprintf(setting.value, sizeof setting.value, "%s", number != 0.0 ? "yes" : "no");
		break;
	default:
		if (f->kind == FIELD_FLOAT)
			stilb_float_text((float)number, setting.value);
		else
			snprintf(setting.value, sizeof setting.value, "%.17g", number);
		break;
	}
	return setting;
}

/* The index of a name among those of a FIELD_NAME; UINT32_MAX: it is none of them. */
static uint32_t field_named(const field *f, const char *text)
{
	for (uint32_t i = 0; i <= (uint32_t)f->high; i++)
		if (strcmp(f->names[i], text) == 0)
			return i;
	return UINT32_MAX;
}

bool gi_settings_put(stilb_gi_settings *settings, uint32_t index, const char *text)
{
	STILB_ASSERT(settings && text && index < gi_settings_count());
	const field *f = &FIELDS[index];
	char *at = (char *)settings + f->offset, *end = NULL;
	uint64_t integer = f->kind == FIELD_U32 || f->kind == FIELD_U64 ? strtoull(text, &end, 10) : 0;
	double number = f->kind == FIELD_DOUBLE ? strtod(text, &end) : 0.0;
	float single = f->kind == FIELD_FLOAT ? strtof(text, &end) : 0.0f;
	uint32_t small = f->kind == FIELD_NAME ? field_named(f, text) : (uint32_t)integer;
	if ((end && (end == text || *end)) || text[0] == '\0')
		return false;
	switch (f->kind) {
	case FIELD_U32:
	case FIELD_NAME:
		memcpy(at, &small, sizeof small);
		return f->kind == FIELD_NAME ? small != UINT32_MAX : integer <= UINT32_MAX;
	case FIELD_U64:
		memcpy(at, &integer, sizeof integer);
		return true;
	case FIELD_FLOAT:
		memcpy(at, &single, sizeof single);
		return true;
	case FIELD_DOUBLE:
		memcpy(at, &number, sizeof number);
		return true;
	case FIELD_BOOL:
		break;
	}
	*(bool *)at = strcmp(text, "yes") == 0;
	return *(bool *)at || strcmp(text, "no") == 0;
}

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

static stilb_result field_check(const stilb_gi_settings *settings, const field *f)
{
	double number = field_number(settings, f);
	if (f->kind == FIELD_U64 || (number >= f->low && number <= f->high)) /* false for NaN */
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT, "cannot render: %s is %g; it must be %g to %g", f->name, number, f->low,
	                  f->high);
}

stilb_result gi_settings_check(const stilb_gi_settings *settings)
{
	STILB_ASSERT(settings);
	for (uint32_t i = 0; i < gi_settings_count(); i++) {
		stilb_result result = field_check(settings, &FIELDS[i]);
		if (result != STILB_OK)
			return result;
	}
	if ((uint64_t)settings->width * settings->height > STILB_GI_MAX_PIXELS)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot render: width x height is %u x %u; at most %u pixels are possible", settings->width,
		                  settings->height, STILB_GI_MAX_PIXELS);
	if (settings->camera.near_z >= settings->camera.far_z)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot render: camera.near_z is %g, not below camera.far_z, %g",
		                  (double)settings->camera.near_z, (double)settings->camera.far_z);
	if (settings->lens.blades == 1 || settings->lens.blades == 2)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot render: lens.blades is %u; an aperture is round (0) or has 3 to 16",
		                  settings->lens.blades);
	if (settings->no_shadows && settings->integrator != STILB_GI_INTEGRATOR_DIRECT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot render: no_shadows is for the integrator direct alone");
	if (settings->denoise && settings->samples < 2)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot render: denoise compares the halves of a pixel's samples; samples "
		                  "is 1, and it must be 2 or more");
	if (settings->denoise &&
	    (settings->integrator == STILB_GI_INTEGRATOR_COLOR || settings->integrator == STILB_GI_INTEGRATOR_CHANNEL))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot render: denoise is for pictures of light, not for the integrators "
		                  "color and channel");
	if (settings->ao_weighted && !(settings->ao_distance > 0.0f))
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot render: ao_weighted needs an ao_distance above 0");
	return STILB_OK;
}
