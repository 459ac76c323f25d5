/* The thresholds of fades, shaders/fade_thresholds.inc: that they are what void-and-cluster makes, each once, spread
 * evenly at every share. `test_render_fade --print` writes the file. */
#include "support/test.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 8
#define CELLS (SIDE * SIDE)
#define ONES 6 /* of the first pattern, about a tenth */

static const int thresholds[CELLS] = {
#include "render/shaders/fade_thresholds.inc"
};

/* ---- void-and-cluster: Ulichney, "The void-and-cluster method for dither array generation" (1993) ---------------- */

static double weight[SIDE][SIDE]; /* of two cells by their distance on the torus: a Gaussian of 1.5 cells */

static void make_weights(void)
{
	for (int y = 0; y < SIDE; y++)
		for (int x = 0; x < SIDE; x++) {
			int dx = x < SIDE - x ? x : SIDE - x, dy = y < SIDE - y ? y : SIDE - y;
			weight[y][x] = exp(-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5));
		}
}

static double energy(const bool ones[CELLS], int cell)
{
	double sum = 0.0;
	for (int c = 0; c < CELLS; c++)
		if (ones[c])
			sum += weight[abs(c / SIDE - cell / SIDE)][abs(c % SIDE - cell % SIDE)];
	return sum;
}

/* The one with the most others about it, or the zero with the fewest ones; of equal ones the first. */
static int tightest(const bool ones[CELLS], bool cluster)
{
	int best = -1;
	double most = 0.0;
	for (int c = 0; c < CELLS; c++) {
		double here = cluster ? energy(ones, c) : -energy(ones, c);
		if (ones[c] == cluster && (best < 0 || here > most + 1e-12)) {
			best = c;
			most = here;
		}
	}
	return best;
}

static void void_and_cluster(int ranks[CELLS])
{
	bool first[CELLS] = {false}, ones[CELLS];
	make_weights();
	for (int i = 0; i < ONES; i++)
		first[i * i * 7 % CELLS] = true; /* any pattern: it is spread next */
	int count = 0;
	for (int c = 0; c < CELLS; c++)
		count += first[c];
	for (int cluster = -1, hole = -2; cluster != hole;) {
		cluster = tightest(first, true);
		first[cluster] = false;
		hole = tightest(first, false);
		first[hole] = true;
	}
	memcpy(ones, first, sizeof ones);
	for (int rank = count - 1; rank >= 0; rank--) {
		int cell = tightest(ones, true);
		ones[cell] = false;
		ranks[cell] = rank;
	}
	memcpy(ones, first, sizeof ones);
	for (int rank = count; rank < CELLS; rank++) {
		int cell = tightest(ones, false);
		ones[cell] = true;
		ranks[cell] = rank;
	}
}

static void thresholds_are_void_and_cluster(void **state)
{
	(void)state;
	int ranks[CELLS];
	void_and_cluster(ranks);
	for (int c = 0; c < CELLS; c++)
		assert_int_equal(thresholds[c], ranks[c]);
}

static void each_rank_is_there_once(void **state)
{
	(void)state;
	bool seen[CELLS] = {false};
	for (int c = 0; c < CELLS; c++) {
		assert_in_range(thresholds[c], 0, CELLS - 1);
		assert_false(seen[thresholds[c]]);
		seen[thresholds[c]] = true;
	}
}

/* ---- evenness ---------------------------------------------------------------------------------------------------- */

/* The largest difference of the number of cells below a threshold between any 4 x 4 cells of the torus and what their
 * share is. */
static double unevenness(const int ranks[CELLS], int threshold)
{
	double most = 0.0;
	for (int at = 0; at < CELLS; at++) {
		int count = 0;
		for (int y = 0; y < 4; y++)
			for (int x = 0; x < 4; x++)
				count += ranks[(at / SIDE + y) % SIDE * SIDE + (at % SIDE + x) % SIDE] < threshold;
		most = fmax(most, fabs(count - threshold / 4.0));
	}
	return most;
}

/* At every share that fades pass through, quarters of the tile have it within two cells. Of random orders none of a
 * thousand does. */
static void every_share_is_spread(void **state)
{
	(void)state;
	double most = 0.0;
	for (int t = 0; t <= CELLS; t += 2)
		most = fmax(most, unevenness(thresholds, t));
	if (most > 2.0)
		fail_msg("a quarter of the tile is off by %g cells", most);
	unsigned seed = 1;
	for (int round = 0; round < 1000; round++) {
		int order[CELLS];
		double here = 0.0;
		for (int c = 0; c < CELLS; c++) {
			seed = seed * 1664525u + 1013904223u;
			int other = (int)(seed >> 8) % (c + 1);
			order[c] = order[other];
			order[other] = c;
		}
		for (int t = 0; t <= CELLS; t += 2)
			here = fmax(here, unevenness(order, t));
		assert_true(here > 2.0);
	}
}

int main(int argc, char **argv)
{
	if (argc > 1 && strcmp(argv[1], "--print") == 0) {
		int ranks[CELLS];
		void_and_cluster(ranks);
		for (int c = 0; c < CELLS; c++)
			printf("%2d,%s", ranks[c], c % SIDE == SIDE - 1 ? "\n" : " ");
		return 0;
	}
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(thresholds_are_void_and_cluster),
		cmocka_unit_test(each_rank_is_there_once),
		cmocka_unit_test(every_share_is_spread),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
