/*
 * gi_settings: the fields of stilb_gi_settings as a table of names: to check ranges, to write them into the attributes
 * of a picture's file, to compare them with those of a checkpoint. [any-thread]
 */
#ifndef GI_SETTINGS_H
#define GI_SETTINGS_H

#include "gi/gi_render.h"

#define GI_SETTING_TEXT 64

typedef enum gi_setting_role {
	GI_SETTING_SAMPLE, /* another value gives other samples, so a checkpoint must have been made with the same */
	GI_SETTING_LIMIT,  /* decides when the render ends */
	GI_SETTING_VIEW,   /* decides how the picture is displayed, during the render or in a .png */
} gi_setting_role;

typedef struct gi_setting {
	const char *name;            /* of the field: "lens.radius" */
	char value[GI_SETTING_TEXT]; /* as text that reads back to the same number */
	gi_setting_role role;
} gi_setting;

/* STILB_OK, or STILB_ERROR_ARGUMENT with the first field that is out of its range, and the range. */
stilb_result gi_settings_check(const stilb_gi_settings *settings);

uint32_t gi_settings_count(void);

/* index < gi_settings_count(). The file names of the irradiance cache are not in the table. */
gi_setting gi_settings_get(const stilb_gi_settings *settings, uint32_t index);

/* Sets the field from a text that gi_settings_get wrote; its range is not checked. False: it is no such text. */
bool gi_settings_put(stilb_gi_settings *settings, uint32_t index, const char *text);

#endif
