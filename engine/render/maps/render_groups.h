/*
 * Groups of maps: the materials whose draws need the same bound, because their textures are layers of the same images
 * (device/render_arrays.h), their samplers are the same, and their program. A draw's state names its group, so draws of
 * one group that follow one another are one run. Inside render/.
 *
 * Classes.  The groups whose textures have the same sizes and formats are a class. Draws are ordered by class, not by
 *           group: which images textures have got depends on what was there before, and the order must not.
 * Large.    A texture with an image of its own (render_array_is_large) leaves its material alone in group and class: so
 *           all of the material's draws come together.
 * Life.     A group lives while a material is in it. A frame may still draw what a material that has changed left.
 * Threads.  The caller holds the lock of render_resources. Entries never move, and those of living groups do not
 *           change: draws read them without the lock.
 */
#ifndef RENDER_GROUPS_H
#define RENDER_GROUPS_H

#include "render/maps/render_maps.h"

/* The head of an entry that is found by its key, which lies behind it. */
typedef struct render_keyed {
	uint32_t users; /* 0: the entry is free, or waits to be released */
	uint32_t next;  /* 1 + the next one in the chain; 0: none */
} render_keyed;

/* All members of a key count, and unused ones are 0. */
typedef struct render_class {
	render_keyed head;
	struct render_class_key {
		uint64_t bits;               /* RENDER_MAPS_... without _EXTRAS */
		uint32_t alone, zero;        /* 1 + index of the maps of a material that is alone; else 0 */
		uint32_t sizes[RENDER_MAPS]; /* width - 1, and height - 1 in the high 16 bits; 0 if there is no map */
		uint8_t formats[RENDER_MAPS], samplers[RENDER_MAPS], unused[6];
	} key;
} render_class;

typedef struct render_group {
	render_keyed head;
	struct render_group_key {
		uint64_t bits; /* as of its class */
		uint32_t alone, zero;
		uint32_t arrays[RENDER_MAPS]; /* render_array.serial; 0: there is no map */
		uint8_t samplers[RENDER_MAPS], unused[5];
	} key;
	uint32_t class;
	bool retired;  /* it is among the resources that wait to be released */
	uint64_t left; /* the last frame, as render_resources.frame counts, in which a living material left it */
} render_group;

static_assert(sizeof(struct render_class_key) == 16 + 4 * RENDER_MAPS + 36, "no padding");
static_assert(sizeof(struct render_group_key) == 16 + 4 * RENDER_MAPS + 20, "no padding");

/* In the place of the class of a group that blends: its draws are not ordered by class. */
#define RENDER_CLASS_BLENDS (1u << 31)

#define RENDER_CHAINS 4096u

/* Entries of one kind by their keys. */
typedef struct render_table {
	uint8_t *items; /* [RENDER_MAX_MAPS] */
	size_t item, key;
	uint32_t chains[RENDER_CHAINS]; /* 1 + the first one; 0: none */
} render_table;

/* Puts a material into the group of its maps, which is made if there is none; maps_index: of the material's maps.
 * STILB_ERROR_MEMORY; and errors of stilb_gpu_set_create. */
stilb_result render_group_join(stilb_render *render, const render_maps *maps, uint32_t maps_index, uint32_t *group);
/* Takes it out. lives: the material does, so frames may draw it with this group. */
void render_group_leave(stilb_render *render, uint32_t group, bool lives);
/* A group that was retired is due. False: it stays, retired or not. */
bool render_group_release(stilb_render *render, uint32_t group);

#endif
