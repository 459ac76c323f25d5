/*
 * gi_identity: what the bits of a picture depend on, as lines "name value": in checkpoints and in the parts of
 * gi_farm.h, which are refused where it differs.
 */
#ifndef GI_IDENTITY_H
#define GI_IDENTITY_H

#include "farm/farm.h"
#include "gi/gi_render_internal.h"

struct gi_identity {
	uint32_t length;
	char text[STILB_FARM_MAX_IDENTITY];
};
typedef struct gi_identity gi_identity;

typedef enum gi_identity_kind {
	/* Version, that of samples, instruction set, scene, the loaded irradiance cache, and the settings that samples
	 * depend on. */
	GI_IDENTITY_CHECKPOINT,
	/* Also the program's file, since machines may have different builds; all other settings, since the picture's file
	 * is made of parts alone; what that file says of the surroundings, and if it has alpha. */
	GI_IDENTITY_PART,
} gi_identity_kind;

/* Reads the scene and the file of the loaded irradiance cache. [any-thread] */
void gi_identity_make(const stilb_gi_render *render, gi_identity_kind kind, gi_identity *identity);

#endif
