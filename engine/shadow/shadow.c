/* Which lights have maps, and where these lie. */
#include "shadow/shadow_internal.h"

#include "base/base_contract.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* Makes room for as many elements, at least one. */
static bool plan_resize(void **array, uint32_t count, size_t size)
{
	void *sized = realloc(*array, (count + (size_t)1) * size);
	*array = sized ? sized : *array;
	return sized;
}

static void plan_clear(stilb_shadow_plan *plan)
{
	plan->map_count = plan->light_count = plan->page_count = plan->left_out = plan->faded = plan->halved = 0;
}

void stilb_shadow_plan_finish(stilb_shadow_plan *plan)
{
	if (!plan)
		return;
	free(plan->maps);
	free(plan->lights);
	free(plan->lamps);
	free(plan->places);
	free(plan->next_places);
	*plan = (stilb_shadow_plan){0};
}

/* ---- suns -------------------------------------------------------------------------------------------------------- */

/* Gives the light its cascades, each a page. False: there is no room for them. */
static bool plan_sun(stilb_shadow_plan *plan, const stilb_shadow_desc *desc, const stilb_shadow_view *view,
                     const stilb_scene_light *light, uint32_t index)
{
	const float *e = light->intensity;
	if (light->use == STILB_SCENE_LIGHT_BAKED || !(e[0] > 0.0f || e[1] > 0.0f || e[2] > 0.0f))
		return true;
	if (desc->objects && !(view->near.radius > 0.0f))
		return true;
	if (plan->page_count + desc->cascades > desc->pages || plan->map_count + desc->cascades > desc->maps)
		return false;
	stilb_shadow_map *maps = plan->maps + plan->map_count;
	shadow_sun_fit(desc, view, light->direction, maps);
	for (uint32_t c = 0; c < desc->cascades; c++) {
		maps[c].light = index;
		maps[c].page = (uint16_t)plan->page_count++;
		memcpy(maps[c].area, (uint16_t[4]){0, 0, (uint16_t)desc->page, (uint16_t)desc->page}, sizeof maps[c].area);
	}
	plan->lights[index] = (stilb_shadow_of){.first = plan->map_count, .count = desc->cascades};
	plan->map_count += desc->cascades;
	return true;
}

/* ---- lamps ------------------------------------------------------------------------------------------------------- */

/* Maps are placed from the largest to the smallest along the Z curve, so that each begins at a multiple of its size. */
static int lamp_order(const void *a, const void *b)
{
	const shadow_lamp *one = a, *other = b;
	if (one->size != other->size)
		return one->size > other->size ? -1 : 1;
	return one->light < other->light ? -1 : one->light > other->light;
}

/* From the largest in the picture to the smallest. */
static int lamp_order_seen(const void *a, const void *b)
{
	const shadow_lamp *one = a, *other = b;
	if (one->seen != other->seen)
		return one->seen > other->seen ? -1 : 1;
	return one->light < other->light ? -1 : one->light > other->light;
}

/* Texels of a map's side, halved so often. */
static uint32_t lamp_size(const stilb_shadow_desc *desc, const shadow_lamp *lamp, uint32_t halved)
{
	float wanted = shadow_lamp_wanted(lamp, 0);
	uint32_t size = desc->page;
	while (size > STILB_SHADOW_MIN_SIZE && (float)size * 0.5f >= wanted)
		size /= 2;
	size >>= halved < 16 ? halved : 16;
	return size > STILB_SHADOW_MIN_SIZE ? size : STILB_SHADOW_MIN_SIZE;
}

/* How many pages the lamps need, if their sizes are halved so often, in squares of the smallest map. */
static uint64_t lamps_squares(const stilb_shadow_plan *plan, const stilb_shadow_desc *desc, uint32_t count,
                              uint32_t halved)
{
	uint64_t squares = 0;
	for (uint32_t l = 0; l < count; l++) {
		uint64_t side = lamp_size(desc, &plan->lamps[l], halved) / STILB_SHADOW_MIN_SIZE;
		squares += plan->lamps[l].maps * side * side;
	}
	return squares;
}

/* A number's even bits, of 16, as a number. */
static uint32_t plan_even_bits(uint32_t number)
{
	uint32_t bits = 0;
	for (uint32_t b = 0; b < 16; b++)
		bits |= (number >> 2 * b & 1u) << b;
	return bits;
}

/* Adds a lamp's maps at their places. */
static void plan_lamp(stilb_shadow_plan *plan, const stilb_shadow_desc *desc, const stilb_shadow_view *view,
                      const stilb_scene_light *lights, const shadow_lamp *lamp, const shadow_place *place)
{
	uint32_t side = desc->page / STILB_SHADOW_MIN_SIZE;
	uint64_t a_page = (uint64_t)side * side;
	plan->lights[lamp->light] = (stilb_shadow_of){.first = plan->map_count, .count = lamp->maps, .faded = lamp->faded};
	for (uint32_t m = 0; m < lamp->maps; m++) {
		stilb_shadow_map *map = &plan->maps[plan->map_count++];
		const stilb_scene_light *light = &lights[lamp->light];
		uint32_t at = (uint32_t)(place->squares[m] % a_page), page = (uint32_t)(place->squares[m] / a_page);
		*map = (stilb_shadow_map){.light = lamp->light, .page = (uint16_t)(plan->first_page + page)};
		map->view_projection = shadow_lamp_fit(desc, view, light, lamp, m);
		memcpy(map->eye, light->position, sizeof map->eye);
		map->area[0] = (uint16_t)(plan_even_bits(at) * STILB_SHADOW_MIN_SIZE);
		map->area[1] = (uint16_t)(plan_even_bits(at >> 1) * STILB_SHADOW_MIN_SIZE);
		map->area[2] = map->area[3] = (uint16_t)lamp->size;
		if (plan->page_count <= plan->first_page + page)
			plan->page_count = plan->first_page + page + 1;
	}
}

/* How much of the lamps' shadows has faded, of all but the first `kept`, which are the largest in the picture, all. Of
 * those it is a ramp from the size of the first one without maps, or the desc's, on: so a lamp that shrinks, or that
 * larger ones take the maps from, loses its shadow bit by bit. Three quarters of them keep theirs whole. Returns how
 * many have not lost all. */
static uint32_t plan_fade(stilb_shadow_plan *plan, const stilb_shadow_desc *desc, uint32_t count, uint32_t kept)
{
	float gone = desc->fade, whole = 2.0f * gone;
	if (kept > 0 && kept < count && plan->lamps[kept].seen > gone) {
		gone = plan->lamps[kept].seen;
		whole = fmaxf(fminf((1.0f + SHADOW_LOSS) * gone, plan->lamps[kept - 1 - kept / 4].seen), whole);
	}
	uint32_t left = 0;
	for (uint32_t l = 0; l < kept; l++) {
		shadow_lamp *lamp = &plan->lamps[l];
		float seen = lamp->seen;
		lamp->faded = seen >= whole ? 0.0f : seen > gone ? (whole - seen) / (whole - gone) : 1.0f;
		left += lamp->faded < 1.0f;
	}
	return left;
}

/* Writes places one after the other. */
static void plan_pack(const stilb_shadow_plan *plan, uint32_t count, shadow_place *places)
{
	uint64_t square = 0;
	qsort(plan->lamps, count, sizeof *plan->lamps, lamp_order);
	for (uint32_t l = 0; l < count; l++) {
		const shadow_lamp *lamp = &plan->lamps[l];
		places[l] = (shadow_place){lamp->light, lamp->maps, lamp->size, lamp->maps, {0}};
		for (uint32_t m = 0; m < lamp->maps; m++, square += shadow_place_squares(&places[l]))
			places[l].squares[m] = square;
	}
}

/* What was placed is what the next plan keeps. */
static void plan_swap_places(stilb_shadow_plan *plan, uint32_t count)
{
	shadow_place *places = plan->places;
	plan->places = plan->next_places;
	plan->place_count = count;
	plan->next_places = places;
}

static void plan_lamps(stilb_shadow_plan *plan, const stilb_shadow_desc *desc, const stilb_shadow_view *view,
                       const stilb_scene_light *lights, uint32_t count)
{
	uint32_t side = desc->page / STILB_SHADOW_MIN_SIZE, maps = 0, kept = 0;
	uint64_t a_page = (uint64_t)side * side, room = (desc->pages - plan->page_count) * a_page;
	if (count == 0) {
		plan->place_count = 0;
		return;
	}
	qsort(plan->lamps, count, sizeof *plan->lamps, lamp_order_seen);
	while (count > 0 && plan->lamps[count - 1].seen <= desc->fade) { /* faded out */
		count--;
		plan->faded++;
	}
	while (kept < count && maps + plan->lamps[kept].maps <= desc->maps - plan->map_count)
		maps += plan->lamps[kept++].maps;
	while (desc->page >> plan->halved > STILB_SHADOW_MIN_SIZE && lamps_squares(plan, desc, kept, plan->halved) > room)
		plan->halved++;
	while (kept > 0 && lamps_squares(plan, desc, kept, plan->halved) > room)
		kept--;
	kept = plan_fade(plan, desc, count, kept);
	plan->left_out += count - kept;
	for (uint32_t l = kept; l < count; l++)
		plan->lights[plan->lamps[l].light].left_out = true;
	for (uint32_t l = 0; l < kept; l++)
		plan->lamps[l].size = lamp_size(desc, &plan->lamps[l], plan->halved);
	bool before = desc->keep && plan->first_page == plan->page_count && plan->page == desc->page;
	plan->first_page = plan->page_count;
	plan->page = desc->page;
	if (!before || !shadow_keep(plan, plan->lamps, kept, room, plan->next_places)) {
		for (uint32_t l = 0; l < kept; l++)
			plan->lamps[l].size = lamp_size(desc, &plan->lamps[l], plan->halved);
		plan_pack(plan, kept, plan->next_places);
	}
	for (uint32_t l = 0; l < kept; l++)
		plan_lamp(plan, desc, view, lights, &plan->lamps[l], &plan->next_places[l]);
	plan_swap_places(plan, kept);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static bool desc_is_sound(const stilb_shadow_desc *desc)
{
	return desc->page >= STILB_SHADOW_MIN_SIZE && desc->page <= 8192 && (desc->page & (desc->page - 1)) == 0 &&
	       desc->pages >= 1 && desc->pages <= STILB_SHADOW_MAX_PAGES && desc->maps >= 1 && desc->cascades >= 1 &&
	       desc->cascades <= STILB_SHADOW_MAX_CASCADES && desc->distance >= 0.0f && isfinite(desc->distance) &&
	       (!desc->objects || (desc->cascades == 1 && desc->distance > 0.0f)) && desc->fade >= 0.0f &&
	       isfinite(desc->fade) && desc->filter >= 1 && desc->filter <= 3;
}

stilb_result stilb_shadow_plan_make(stilb_shadow_plan *plan, const stilb_shadow_desc *desc,
                                    const stilb_shadow_view *view, const stilb_scene_light *lights, uint32_t count)
{
	STILB_ASSERT(plan && desc && view && (lights || count == 0));
	STILB_ASSERT(desc_is_sound(desc) && view->height > 0);
	STILB_ASSERT(view->bounds.radius > 0.0f && isfinite(view->bounds.radius));
	plan_clear(plan);
	if (!plan_resize((void **)&plan->lights, count, sizeof *plan->lights) ||
	    !plan_resize((void **)&plan->lamps, count, sizeof *plan->lamps) ||
	    !plan_resize((void **)&plan->next_places, count, sizeof *plan->next_places) ||
	    !plan_resize((void **)&plan->maps, desc->maps, sizeof *plan->maps))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to plan the shadow maps of %u lights", count);
	plan->light_count = count;
	stilb_frustum frustum = stilb_frustum_from_matrix(&view->view_projection);
	uint32_t lamps = 0;
	for (uint32_t i = 0; i < count; i++) {
		plan->lights[i] = (stilb_shadow_of){0};
		shadow_lamp lamp = {.light = i};
		if (lights[i].kind == STILB_SCENE_LIGHT_DIRECTIONAL)
			plan->lights[i].left_out = !plan_sun(plan, desc, view, &lights[i], i);
		else if (shadow_lamp_of(view, &frustum, &lights[i], &lamp))
			plan->lamps[lamps++] = lamp;
		plan->left_out += plan->lights[i].left_out;
	}
	plan_lamps(plan, desc, view, lights, lamps);
	return STILB_OK;
}
