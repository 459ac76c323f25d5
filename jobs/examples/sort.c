/*
 * A stable sort: a million draws by material. Draws of one material keep their order.
 *
 * Prints: material 0 begins with draws 0, 7, 14; material 6 ends with draw 999998
 */
#include <stilb/job_sort.h>

#include <stdio.h>

typedef struct draw {
	uint32_t material, index;
} draw;

static int by_material(const void *a, const void *b, void *context)
{
	const draw *l = a, *r = b;
	(void)context;
	return (l->material > r->material) - (l->material < r->material);
}

int main(void)
{
	static draw draws[1000000];
	for (uint32_t i = 0; i < 1000000; i++)
		draws[i] = (draw){.material = i % 7, .index = i};
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	int error = stilb_job_sort(pool, draws, 1000000, sizeof *draws, by_material, NULL, 0);
	stilb_job_pool_destroy(pool);
	if (error)
		return 1;
	printf("material 0 begins with draws %u, %u, %u; ", draws[0].index, draws[1].index, draws[2].index);
	printf("material %u ends with draw %u\n", draws[999999].material, draws[999999].index);
	return 0;
}
