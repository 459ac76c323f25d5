/*
 * gi_settings: every number of stilb_gi_settings by its name: checked, written into pictures, compared with those of a
 * checkpoint. One table; [any-thread].
 */
#ifndef GI_SETTINGS_H
#define GI_SETTINGS_H

#include "gi/gi_render.h"

#define GI_SETTING_TEXT 64

typedef enum gi_setting_role {
	GI_SETTING_SAMPLE, /* another value gives other samples */
	GI_SETTING_LIMIT,  /* it says when to end */
	GI_SETTING_VIEW,   /* it says what to show meanwhile, or of it */
} gi_setting_role;

typedef struct gi_setting {
	const char *name;            /* of the field, "lens.radius" */
	char value[GI_SETTING_TEXT]; /* enough digits to read the same number back */
	gi_setting_role role;
} gi_setting;

/* STILB_ERROR_ARGUMENT names the first field that is out of its range, and the range. */
stilb_result gi_settings_check(const stilb_gi_settings *settings);

uint32_t gi_settings_count(void);

/* index < gi_settings_count(). Files of the irradiance cache are not among them. */
gi_setting gi_settings_get(const stilb_gi_settings *settings, uint32_t index);

#endif
