/*
 * A loop over the tiles of a picture: each tile is drawn by one thread, and neighbours in memory stay together.
 *
 * Prints: 1920 x 1080 pixels, 2073600 drawn
 */
#include <stilb/job_range.h>

#include <stdio.h>

enum { WIDTH = 1920, HEIGHT = 1080 };

static unsigned char picture[HEIGHT][WIDTH];

static void draw(stilb_job_tile tile, uint32_t worker, void *context)
{
	(void)worker;
	(void)context;
	for (uint32_t y = tile.y_begin; y < tile.y_end; y++)
		for (uint32_t x = tile.x_begin; x < tile.x_end; x++)
			picture[y][x]++;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	stilb_job_parallel_for_tiles(pool, WIDTH, HEIGHT, 0, 0, draw, NULL, 0); /* 0: the size of tiles is chosen */
	stilb_job_pool_destroy(pool);
	int drawn = 0;
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++)
			drawn += picture[y][x];
	printf("%d x %d pixels, %d drawn\n", WIDTH, HEIGHT, drawn);
	return 0;
}
