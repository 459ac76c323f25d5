/*
 * rays_flags: which light rays compute, for the commands that trace them: `stilb render`, and `stilb view` beside its
 * frames.
 *
 *   rays_flags rays = rays_flags_default();
 *   rays_flags_add(&rays, RAYS_INTEGRATOR, &table);
 *   ...
 *   stilb_gi_settings settings = rays_flags_settings(&rays, scene);
 *
 * Threads.  [any-thread] for flags that nobody changes.
 */
#ifndef STILB_RENDER_RAYS_H
#define STILB_RENDER_RAYS_H

#include "game/cli/flags.h"
#include "gi/gi_render.h"

typedef struct rays_flags {
	int integrator; /* a stilb_gi_integrator */
	int channel;    /* of the integrator CHANNEL: a stilb_scene_surface_channel that rays have */
	int shadows;    /* 0: off, with the integrator DIRECT */
} rays_flags;

typedef enum rays_flags_group {
	RAYS_INTEGRATOR, /* --integrator */
	RAYS_SHADOWS,    /* --shadows; frames beside rays have a flag of that name, which counts for both */
} rays_flags_group;

/* The words that --integrator accepts, in the order of its enumeration; NULL-terminated. */
extern const char *const rays_integrators[];

rays_flags rays_flags_default(void);

/* Appends the rows of a group; their values are those of *rays. */
void rays_flags_add(rays_flags *rays, rays_flags_group group, flag_rows *table);

/* The settings that follow from the flags; those that have different defaults for different integrators, so that a
 * picture of the default size takes some seconds, have them. */
stilb_gi_settings rays_flags_settings(const rays_flags *rays, const stilb_scene *scene);

#endif
