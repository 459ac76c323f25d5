/* Inside post/: the sizes in which bloom spreads light. */
#ifndef POST_LEVELS_H
#define POST_LEVELS_H

#include <math.h>
#include <stdint.h>

#define POST_LEVELS 12u
#define POST_LEVELS_SMALLEST 4u /* texels of a level's shorter side, at least, but for the first one's */
#define POST_LEVELS_ROWS 360.0f /* of a picture whose first level scatters light */

typedef struct post_levels {
	uint32_t count;                 /* 1..POST_LEVELS */
	uint32_t sizes[POST_LEVELS][2]; /* each half of the one before, the first half of the picture; rounded up */
	uint32_t first;                 /* that scatters light; finer ones lead to it alone */
} post_levels;

/* Of a picture of 1 x 1 pixels or more. */
static inline post_levels post_levels_of(uint32_t width, uint32_t height)
{
	float first = roundf(log2f((float)height / POST_LEVELS_ROWS));
	post_levels levels = {.first = first > 0.0f ? (uint32_t)first : 0};
	do {
		width = levels.sizes[levels.count][0] = (width + 1) / 2;
		height = levels.sizes[levels.count][1] = (height + 1) / 2;
		levels.count++;
	} while (levels.count < POST_LEVELS && width >= 2 * POST_LEVELS_SMALLEST && height >= 2 * POST_LEVELS_SMALLEST);
	return levels;
}

#endif
