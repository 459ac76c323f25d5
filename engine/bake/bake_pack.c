#include "bake/bake_pack.h"

#include <limits.h>
#include <stdlib.h>

#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_ASSERT(condition) STILB_ASSERT(condition)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wconversion"
#include <stb_rect_pack.h>
#pragma GCC diagnostic pop

typedef struct pack_entry {
	uint32_t width, height, rect;
} pack_entry;

/* Tallest first, of these the widest, of equal ones the first: the order of stb_rect_pack, made total. */
static int tallest_first(const void *a, const void *b)
{
	const pack_entry *l = a, *r = b;
	if (l->height != r->height)
		return l->height > r->height ? -1 : 1;
	if (l->width != r->width)
		return l->width > r->width ? -1 : 1;
	return l->rect < r->rect ? -1 : l->rect > r->rect;
}

/* As many of the first entries as have a page's area together: more cannot fit, and trying them takes time. */
static uint32_t worth_trying(const pack_entry *entries, uint32_t count, uint32_t side)
{
	uint64_t area = 0, page = (uint64_t)side * side;
	uint32_t n = 0;
	while (n < count && area < page) {
		area += (uint64_t)entries[n].width * entries[n].height;
		n++;
	}
	return n;
}

/* Places what fits on one page, and moves the rest to the front. Returns how many are left. */
static uint32_t pack_page(stilb_bake_rect *rects, pack_entry *entries, uint32_t count, uint32_t side, uint32_t page,
                          stbrp_node *nodes, stbrp_rect *places)
{
	stbrp_context context;
	uint32_t tried = worth_trying(entries, count, side), left = 0;
	for (uint32_t i = 0; i < tried; i++)
		places[i] = (stbrp_rect){.id = (int)i, .w = (int)entries[i].width, .h = (int)entries[i].height};
	stbrp_init_target(&context, (int)side, (int)side, nodes, (int)side);
	stbrp_pack_rects(&context, places, (int)tried);
	for (uint32_t i = 0; i < count; i++) {
		if (i >= tried || !places[i].was_packed) {
			entries[left++] = entries[i];
			continue;
		}
		stilb_bake_rect *rect = &rects[entries[i].rect];
		rect->page = page;
		rect->x = (uint32_t)places[i].x;
		rect->y = (uint32_t)places[i].y;
	}
	STILB_ASSERT(left < count && "one rectangle always fits on an empty page");
	return left;
}

stilb_result stilb_bake_pack(stilb_bake_rect *rects, uint32_t count, uint32_t side, uint32_t *page_count)
{
	STILB_ASSERT(side >= 1 && side <= STILB_BAKE_MAX_SIDE);
	STILB_ASSERT(count <= INT_MAX);
	pack_entry *entries = stilb_memory_alloc(count, sizeof *entries);
	stbrp_rect *places = stilb_memory_alloc(count, sizeof *places);
	stbrp_node *nodes = stilb_memory_alloc(side, sizeof *nodes);
	bool good = entries && places && nodes;
	*page_count = 0;
	for (uint32_t i = 0; i < count && good; i++) {
		STILB_ASSERT(rects[i].width >= 1 && rects[i].width <= side && rects[i].height >= 1 && rects[i].height <= side);
		entries[i] = (pack_entry){rects[i].width, rects[i].height, i};
	}
	if (good)
		qsort(entries, count, sizeof *entries, tallest_first);
	for (uint32_t left = count; good && left > 0; (*page_count)++)
		left = pack_page(rects, entries, left, side, *page_count, nodes, places);
	free(entries);
	free(places);
	free(nodes);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "out of memory to pack %u charts", count);
}
