/* Maps of lamps that keep their sizes and places from plan to plan, as long as these are not far from what is wanted:
 * what stays where it was need not be drawn anew. */
#include "shadow/shadow_internal.h"

#define KEEP_LEAST 0.9f /* of the texels that are wanted: a smaller map becomes larger */
#define KEEP_MOST 2.2f  /* a larger one becomes smaller */
#define KEEP_CHANGES 4u /* lamps whose maps change their size in a plan, at most */

static const shadow_place *keep_find(const stilb_shadow_plan *plan, const shadow_lamp *lamp)
{
	for (uint32_t p = 0; p < plan->place_count; p++)
		if (plan->places[p].light == lamp->light && plan->places[p].maps == lamp->maps)
			return &plan->places[p];
	return NULL;
}

/* The size of the lamp's maps: the one that they had, or its own if that is too far from what is wanted. */
static uint32_t keep_size(const shadow_lamp *lamp, const shadow_place *before, float wanted, uint32_t *changes)
{
	float had = (float)before->size;
	bool near = before->size == lamp->size || (had >= KEEP_LEAST * wanted && had <= KEEP_MOST * wanted);
	if (near || *changes == KEEP_CHANGES)
		return before->size;
	*changes += 1;
	return lamp->size;
}

/* The first square from which so many are free, at a multiple of that; all that are placed so far are
 * places[0 .. count - 1], of the last one `maps` maps. False: there is none. */
static bool keep_room(const shadow_place *places, uint32_t count, uint64_t squares, uint64_t room, uint64_t *first)
{
	bool moved;
	*first = 0;
	do {
		moved = false;
		for (uint32_t p = 0; p < count; p++) {
			uint64_t each = shadow_place_squares(&places[p]);
			for (uint32_t m = 0; m < places[p].placed; m++) {
				uint64_t from = places[p].squares[m], end = from + each;
				if (*first >= end || from >= *first + squares)
					continue;
				*first = (end + squares - 1) / squares * squares;
				moved = true;
			}
		}
	} while (moved);
	return *first + squares <= room;
}

bool shadow_keep(const stilb_shadow_plan *plan, shadow_lamp *lamps, uint32_t count, uint64_t room, shadow_place *places)
{
	uint32_t changes = 0;
	for (uint32_t l = 0; l < count; l++) { /* first those that stay */
		const shadow_place *before = keep_find(plan, &lamps[l]);
		shadow_place *place = &places[l];
		*place = (shadow_place){.light = lamps[l].light, .maps = lamps[l].maps};
		place->size = before ? keep_size(&lamps[l], before, shadow_lamp_wanted(&lamps[l], plan->halved), &changes)
		                     : lamps[l].size;
		if (before && before->size == place->size)
			*place = *before;
		for (uint32_t m = 0; m < place->placed; m++)
			if (place->squares[m] + shadow_place_squares(place) > room)
				return false;
		lamps[l].size = place->size;
	}
	for (uint32_t l = 0; l < count; l++)
		for (; places[l].placed < places[l].maps; places[l].placed++)
			if (!keep_room(places, count, shadow_place_squares(&places[l]), room, &places[l].squares[places[l].placed]))
				return false;
	return true;
}
