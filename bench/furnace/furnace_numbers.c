/* Four sources of random numbers: Stilb's Sobol points, PCG, and rand() of two C libraries. */
#include "bench/furnace/furnace_cases.h"
#include "bench/furnace/furnace_run.h"

#include "gi/sample/gi_sampler.h"

#include <stdlib.h>
#include <string.h>

static void three_of(float (*next)(void), float numbers[3])
{
	for (int i = 0; i < 3; i++)
		numbers[i] = next();
}

/* ---- Owen-scrambled Sobol points of the engine: an experiment is a pixel, a path one of its samples -------------- */

static gi_sampler owen_sampler;
static gi_point owen_point;

static void owen_seed(uint32_t seed)
{
	owen_sampler = gi_sampler_make(STILB_GI_SAMPLER_SOBOL, seed, FURNACE_RUNS);
}

static void owen_run(uint32_t experiment, uint32_t run)
{
	owen_point = gi_sampler_point(&owen_sampler, experiment, 0, run);
}

static void owen_vertex(uint32_t vertex, float numbers[3])
{
	float eight[8];
	gi_sample_8(&owen_sampler, owen_point, GI_DIMENSION_OF(vertex), eight);
	numbers[0] = eight[GI_DIMENSION_DIRECTION];
	numbers[1] = eight[GI_DIMENSION_DIRECTION + 1];
	numbers[2] = eight[GI_DIMENSION_ROULETTE];
}

/* ---- PCG --------------------------------------------------------------------------------------------------------- */

/* PCG-XSH-RR 64/32. Source: O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for
 * Random Number Generation" (2014). */
static uint64_t pcg_state;

static float pcg_next(void)
{
	uint64_t old = pcg_state;
	pcg_state = old * 6364136223846793005u + 1442695040888963407u;
	uint32_t shifted = (uint32_t)((old >> 18 ^ old) >> 27), turn = (uint32_t)(old >> 59);
	return (float)((shifted >> turn | shifted << (-turn & 31)) >> 8) * 0x1p-24f;
}

static void pcg_seed(uint32_t seed)
{
	pcg_state = stilb_random_u64(seed, 0);
}

static void pcg_vertex(uint32_t vertex, float numbers[3])
{
	(void)vertex;
	three_of(pcg_next, numbers);
}

/* ---- rand() of this C library ------------------------------------------------------------------------------------ */

static float rand_next(void)
{
	return (float)((uint32_t)rand() >> 7) * 0x1p-24f; /* RAND_MAX is 2^31 - 1 */
}
_Static_assert(RAND_MAX == 0x7fffffff, "rand_next assumes glibc's RAND_MAX");

static void rand_vertex(uint32_t vertex, float numbers[3])
{
	(void)vertex;
	three_of(rand_next, numbers);
}

/* ---- rand() of Microsoft's C library: bits 16 to 30 of a linear congruential generator --------------------------- */

static uint32_t rand15_state;

static float rand15_next(void)
{
	rand15_state = rand15_state * 214013u + 2531011u;
	return (float)(rand15_state >> 16 & 0x7fff) * 0x1p-15f;
}

static void rand15_seed(uint32_t seed)
{
	rand15_state = seed;
}

static void rand15_vertex(uint32_t vertex, float numbers[3])
{
	(void)vertex;
	three_of(rand15_next, numbers);
}

/* ------------------------------------------------------------------------------------------------------------------ */

const furnace_numbers *furnace_numbers_find(const char *name)
{
	static const furnace_numbers all[] = {
		{"stilb", owen_seed, owen_run, owen_vertex},
		{"pcg", pcg_seed, NULL, pcg_vertex},
		{"rand", srand, NULL, rand_vertex},
		{"rand-15-bit", rand15_seed, NULL, rand15_vertex},
	};
	for (size_t i = 0; i < sizeof all / sizeof *all; i++)
		if (strcmp(all[i].name, name) == 0)
			return &all[i];
	return NULL;
}
