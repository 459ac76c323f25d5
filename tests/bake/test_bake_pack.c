/* Rectangles on pages: all there, none over another, none over the edge. */
#include "bake_made.h"

#include "bake/bake_pack.h"

#define SIDE 256u

/* Marks a rectangle's texels; fails where one is marked already. */
static void mark(uint8_t *pages, const stilb_bake_rect *rect)
{
	assert_true(rect->x + rect->width <= SIDE && rect->y + rect->height <= SIDE);
	for (uint32_t y = rect->y; y < rect->y + rect->height; y++)
		for (uint32_t x = rect->x; x < rect->x + rect->width; x++) {
			uint8_t *texel = &pages[((size_t)rect->page * SIDE + y) * SIDE + x];
			assert_int_equal(*texel, 0);
			*texel = 1;
		}
}

static void assert_packs(stilb_bake_rect *rects, uint32_t count, uint32_t most_pages)
{
	uint32_t pages;
	assert_int_equal(stilb_bake_pack(rects, count, SIDE, &pages), STILB_OK);
	assert_true(pages <= most_pages);
	uint8_t *marks = calloc((size_t)pages + 1, (size_t)SIDE * SIDE);
	assert_non_null(marks);
	for (uint32_t i = 0; i < count; i++) {
		assert_true(rects[i].page < pages);
		mark(marks, &rects[i]);
	}
	free(marks);
}

static void test_sizes_of_all_kinds(void **state)
{
	(void)state;
	static stilb_bake_rect rects[3000];
	uint64_t random = 1, area = 0;
	for (uint32_t i = 0; i < 3000; i++) {
		float size = made_random(&random);
		rects[i].width = 1 + (uint32_t)(60.0f * size * size * size);
		rects[i].height = 1 + (uint32_t)((float)rects[i].width * made_random(&random));
		area += rects[i].width * rects[i].height;
	}
	assert_packs(rects, 3000, (uint32_t)(area / (SIDE * SIDE)) * 5 / 4 + 2);
}

static void test_more_than_one_page(void **state)
{
	(void)state;
	stilb_bake_rect rects[9];
	for (uint32_t i = 0; i < 9; i++)
		rects[i] = (stilb_bake_rect){.width = SIDE / 2, .height = SIDE / 2};
	assert_packs(rects, 9, 3);
	for (uint32_t i = 0; i < 4; i++)
		rects[i] = (stilb_bake_rect){.width = SIDE, .height = SIDE - i};
	assert_packs(rects, 4, 4);
}

static void test_single_texels_fill_pages(void **state)
{
	(void)state;
	static stilb_bake_rect rects[SIDE * SIDE + 1];
	for (uint32_t i = 0; i <= SIDE * SIDE; i++)
		rects[i] = (stilb_bake_rect){.width = 1, .height = 1};
	assert_packs(rects, SIDE * SIDE + 1, 2);
}

static void test_nothing(void **state)
{
	(void)state;
	assert_packs(NULL, 0, 0);
}

int main(void)
{
	static const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sizes_of_all_kinds),
		cmocka_unit_test(test_more_than_one_page),
		cmocka_unit_test(test_single_texels_fill_pages),
		cmocka_unit_test(test_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
