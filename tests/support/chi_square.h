/*
 * chi_square: does a sampler choose as often as its density says? Pearson's test over cells of what can be chosen: a
 * list of choices, or the unit square that points or directions are mapped to.
 *
 * Cells.    The square is cut into quarters, and these again, until each holds few of the first draws, which are not
 *           counted. So a lobe a thousandth of a radian wide has as many cells as one that fills the sphere. What a
 *           cell expects is the integral of the density over it, by quadrature that cuts on where it must.
 * Pools.    Cells that expect fewer than ten draws count as one. If even that one does, its surplus is judged by
 *           Poisson's distribution, which chi-square's is no approximation of there.
 * Nothing.  A draw may end without a choice (below the surface, say): that is a cell, too, which expects what the
 *           density leaves of 1. So a density that is too small or too large all over is found as well.
 * Level.    A family is all comparisons of a test. A right program fails in a family with the probability
 *           CHI_SQUARE_FALSE_ALARM, whatever the number of comparisons (Sidak's correction). Seeds are fixed, so a test
 *           that has passed passes again.
 * Sources:  Pearson, "On the criterion ..." (1900); Sidak, "Rectangular Confidence Regions" (1967); Subr and Arvo,
 *           "Statistical Hypothesis Testing for Assessing Monte Carlo Estimators" (2007).
 */
#ifndef CHI_SQUARE_H
#define CHI_SQUARE_H

#include "shading/shade_frame.h"
#include "support/shade_proof.h"

#include <stdio.h>
#include <string.h>

#define CHI_SQUARE_FALSE_ALARM 1e-4
#define CHI_SQUARE_LEAST 10.0 /* draws that a cell of its own expects at least */

/* ---- the distribution -------------------------------------------------------------------------------------------- */

/* Probability that chi-square of so many degrees of freedom, > 0, is at least x >= 0: the regularised incomplete gamma
 * function Q(freedom / 2, x / 2), by its series or its continued fraction. Source: Abramowitz and Stegun, "Handbook of
 * Mathematical Functions" (1964), 6.5.29, 6.5.31, 26.4.19. */
static inline double chi_square_tail(double x, double freedom)
{
	double a = 0.5 * freedom, y = 0.5 * x;
	if (y <= 0.0)
		return 1.0;
	double front = exp(a * log(y) - y - lgamma(a));
	if (y < a + 1.0) {
		double term = 1.0 / a, sum = term;
		for (double n = a + 1.0; term > 1e-16 * sum; n += 1.0) {
			term *= y / n;
			sum += term;
		}
		return fmax(1.0 - front * sum, 0.0);
	}
	double b = y + 1.0 - a, c = 1e300, d = 1.0 / b, fraction = d;
	for (int n = 1; n < 10000; n++) {
		double step = -n * (n - a);
		b += 2.0;
		d = 1.0 / (step * d + b);
		c = b + step / c;
		fraction *= c * d;
		if (fabs(c * d - 1.0) < 1e-15)
			break;
	}
	return front * fraction;
}

/* Probability that a number with Poisson's distribution of this mean is at least `count`: A. and S. 26.4.21. */
static inline double chi_square_poisson_tail(double mean, double count)
{
	return count > 0.0 ? 1.0 - chi_square_tail(2.0 * mean, 2.0 * count) : 1.0;
}

/* The probability that draws which are spread as expected differ from that as much as these do. expected: draws, whose
 * sum is the number of all. slack: so many more may be expected of the pool; what quadrature may have missed. */
static inline double chi_square_p(const double *expected, const uint32_t *found, size_t cells, double slack)
{
	double sum = 0.0, pool = 0.0, pool_found = 0.0, freedom = -1.0;
	for (size_t i = 0; i <= cells; i++) {
		double want = i < cells ? expected[i] : pool, got = i < cells ? (double)found[i] : pool_found;
		if (want >= CHI_SQUARE_LEAST) {
			sum += (got - want) * (got - want) / want;
			freedom += 1.0;
		} else if (i < cells) {
			pool += want;
			pool_found += got;
		}
	}
	double p = freedom > 0.0 ? chi_square_tail(sum, freedom) : 1.0;
	double p_pool = pool < CHI_SQUARE_LEAST ? chi_square_poisson_tail(pool + slack, pool_found) : 1.0;
	return fmin(2.0 * fmin(p, p_pool), 1.0);
}

/* ---- families ---------------------------------------------------------------------------------------------------- */

typedef struct chi_square_family {
	uint32_t planned, done; /* comparisons */
	double least;           /* p of them */
} chi_square_family;

static inline chi_square_family chi_square_family_of(uint32_t planned)
{
	return (chi_square_family){.planned = planned, .least = 1.0};
}

/* False: this comparison fails. */
static inline bool chi_square_passes(chi_square_family *family, double p)
{
	assert_true(family->done < family->planned);
	family->done++;
	family->least = fmin(family->least, p);
	return p >= -expm1(log1p(-CHI_SQUARE_FALSE_ALARM) / family->planned);
}

/* All planned comparisons were made. */
static inline void chi_square_end(const chi_square_family *family)
{
	print_message("%u comparisons, least p %.2g\n", family->done, family->least);
	assert_int_equal(family->done, family->planned);
}

/* ---- the unit square --------------------------------------------------------------------------------------------- */

typedef struct chi_square_subject {
	/* Draws a point, [0, 1]^2. False: nothing is chosen. */
	bool (*draw)(const void *context, shade_proof_random *random, double at[2]);
	double (*density)(const void *context, const double at[2]); /* per unit of the square's area */
	const void *context;
} chi_square_subject;

/* What a comparison says. */
typedef struct chi_square_result {
	double p;
	double mass; /* integral of the density: the probability that something is chosen */
} chi_square_result;

#define CHI_SQUARE_NODES 131072u
#define CHI_SQUARE_PILOTS 4096u    /* first draws, */
#define CHI_SQUARE_CELL_PILOTS 32u /* of which a cell holds no more, */
#define CHI_SQUARE_LEAF_PILOTS 8u  /* nor a square that quadrature begins with */
#define CHI_SQUARE_CELL_LEVEL 3    /* 8 x 8 cells at least, so that what is never drawn has cells, too, */
#define CHI_SQUARE_LEAF_LEVEL 5    /* and 32 x 32 leaves */
#define CHI_SQUARE_LEVEL_MOST 24   /* narrower cells hold too few different floats */
#define CHI_SQUARE_CUTS 16         /* of a leaf by quadrature: about a pole of the density they are needed */
#define CHI_SQUARE_CUTS_OFF 5      /* at least, where a horizon goes through */
#define CHI_SQUARE_STRICTER 0.7 /* with each cut: what is left after n cuts along a jump is 2^n errors of either sign */
#define CHI_SQUARE_MASS_ERROR 1e-3 /* of the integral: roundings of the density, and quadrature's */
#define CHI_SQUARE_MISSED 5e-5     /* of the integral: corners of cells that a jump cuts off */
#define CHI_SQUARE_QUADRATURE 0.02 /* error of a cell's expectation, in its standard deviations */

/* A square. Leaves are those that quadrature begins with; a cell is a leaf or holds several. */
typedef struct chi_square_node {
	double low[2], side;
	int level;
	uint32_t pilots; /* in it */
	uint32_t child;  /* the first of four; 0: it is a leaf */
	uint32_t cell;   /* that it is in; CHI_SQUARE_NODES: it holds several */
} chi_square_node;

typedef struct chi_square_tree {
	chi_square_node nodes[CHI_SQUARE_NODES];
	uint32_t node_count, cell_count;
	double expected[CHI_SQUARE_NODES];
	uint32_t found[CHI_SQUARE_NODES];
	double pilots[CHI_SQUARE_PILOTS][2];
} chi_square_tree;

/* Which of the four quarters of a square a point lies in. */
static inline uint32_t chi_square_quarter(const chi_square_node *node, const double at[2])
{
	double half = 0.5 * node->side;
	return (at[0] >= node->low[0] + half ? 1u : 0u) + (at[1] >= node->low[1] + half ? 2u : 0u);
}

static inline void chi_square_corner(const double low[2], double half, uint32_t quarter, double corner[2])
{
	corner[0] = low[0] + (quarter & 1 ? half : 0.0);
	corner[1] = low[1] + (quarter & 2 ? half : 0.0);
}

/* Makes four of a leaf. */
static inline void chi_square_split(chi_square_tree *tree, uint32_t at)
{
	assert_true(tree->node_count + 4 <= CHI_SQUARE_NODES);
	chi_square_node *node = &tree->nodes[at];
	node->child = tree->node_count;
	tree->node_count += 4;
	for (uint32_t quarter = 0; quarter < 4; quarter++) {
		chi_square_node *child = &tree->nodes[node->child + quarter];
		*child = (chi_square_node){.side = 0.5 * node->side, .level = node->level + 1};
		chi_square_corner(node->low, child->side, quarter, child->low);
	}
}

/* Cuts the leaf and what comes of it until each holds few of the pilots, which are those in it. */
static inline void chi_square_cut(chi_square_tree *tree, uint32_t at, double (*pilots)[2], uint32_t count)
{
	int level = tree->nodes[at].level;
	tree->nodes[at].pilots = count;
	if (level >= CHI_SQUARE_LEVEL_MOST || (level >= CHI_SQUARE_LEAF_LEVEL && count <= CHI_SQUARE_LEAF_PILOTS))
		return;
	chi_square_split(tree, at);
	uint32_t begin = 0;
	for (uint32_t quarter = 0; quarter < 4; quarter++) {
		uint32_t end = begin;
		for (uint32_t i = begin; i < count; i++)
			if (chi_square_quarter(&tree->nodes[at], pilots[i]) == quarter) {
				double kept[2] = {pilots[end][0], pilots[end][1]};
				memcpy(pilots[end], pilots[i], sizeof kept);
				memcpy(pilots[i], kept, sizeof kept);
				end++;
			}
		chi_square_cut(tree, tree->nodes[at].child + quarter, pilots + begin, end - begin);
		begin = end;
	}
}

static inline uint32_t chi_square_leaf(const chi_square_tree *tree, const double at[2])
{
	uint32_t leaf = 0;
	while (tree->nodes[leaf].child)
		leaf = tree->nodes[leaf].child + chi_square_quarter(&tree->nodes[leaf], at);
	return leaf;
}

/* Cuts leaves until none is larger than twice its neighbours: beside the small ones of a narrow lobe a large one would
 * miss the lobe's skirt. Leaves that come of it are looked at, too. */
static inline void chi_square_balance(chi_square_tree *tree)
{
	for (uint32_t i = 0; i < tree->node_count; i++)
		for (int k = 0; k < 9 && !tree->nodes[i].child; k++) {
			double side = tree->nodes[i].side, beside[2];
			for (int axis = 0; axis < 2; axis++)
				beside[axis] = tree->nodes[i].low[axis] + side * ((axis ? k / 3 : k % 3) - 0.5);
			if (beside[0] < 0.0 || beside[0] >= 1.0 || beside[1] < 0.0 || beside[1] >= 1.0)
				continue;
			uint32_t leaf = chi_square_leaf(tree, beside);
			while (tree->nodes[leaf].level < tree->nodes[i].level - 1) {
				chi_square_split(tree, leaf);
				if (leaf < i)
					i = leaf; /* its neighbours may have become too large */
				leaf = chi_square_leaf(tree, beside);
			}
		}
}

/* Gives each leaf the cell that it is in. */
static inline void chi_square_name(chi_square_tree *tree, uint32_t at, uint32_t cell)
{
	chi_square_node *node = &tree->nodes[at];
	bool whole = node->level >= CHI_SQUARE_CELL_LEVEL && node->pilots <= CHI_SQUARE_CELL_PILOTS;
	if (cell == CHI_SQUARE_NODES && (whole || !node->child))
		cell = tree->cell_count++;
	node->cell = cell;
	for (uint32_t quarter = 0; quarter < 4 && node->child; quarter++)
		chi_square_name(tree, node->child + quarter, cell);
}

/* What is known of the density in a square. */
typedef struct chi_square_seen {
	double sum;      /* its integral by Gauss' rule of 3 x 3 points */
	bool none, some; /* there are points where it is 0, and where it is not */
} chi_square_seen;

static inline double chi_square_look(const chi_square_subject *subject, const double low[2], double side, double x,
                                     double y, chi_square_seen *seen)
{
	double density = subject->density(subject->context, (double[2]){low[0] + side * x, low[1] + side * y});
	seen->none |= density == 0.0;
	seen->some |= density > 0.0;
	return density;
}

static inline chi_square_seen chi_square_gauss(const chi_square_subject *subject, const double low[2], double side)
{
	static const double places[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
	static const double weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
	chi_square_seen seen = {0};
	for (int i = 0; i < 9; i++)
		seen.sum +=
			weights[i % 3] * weights[i / 3] * chi_square_look(subject, low, side, places[i % 3], places[i / 3], &seen);
	seen.sum *= side * side;
	return seen;
}

/* True if the density is 0 in a part of the square, as far as its quarters and corners tell: a horizon goes through. */
static inline bool chi_square_is_cut_off(const chi_square_subject *subject, const double low[2], double side,
                                         const chi_square_seen quarters[4])
{
	chi_square_seen all = {0};
	for (int i = 0; i < 4; i++) {
		all.none |= quarters[i].none;
		all.some |= quarters[i].some;
	}
	for (int i = 0; i < 4 && !(all.none && all.some); i++)
		chi_square_look(subject, low, side, i & 1 ? 0.999999 : 1e-6, i & 2 ? 0.999999 : 1e-6, &all);
	return all.none && all.some;
}

static inline double chi_square_integral(const chi_square_subject *subject, const double low[2], double side,
                                         double whole, double tolerance, int cuts)
{
	chi_square_seen quarters[4];
	double half = 0.5 * side, sum = 0.0, corner[2];
	for (uint32_t i = 0; i < 4; i++) {
		chi_square_corner(low, half, i, corner);
		quarters[i] = chi_square_gauss(subject, corner, half);
		sum += quarters[i].sum;
	}
	if (cuts == CHI_SQUARE_CUTS ||
	    (fabs(sum - whole) <= tolerance &&
	     (cuts >= CHI_SQUARE_CUTS_OFF || !chi_square_is_cut_off(subject, low, side, quarters))))
		return sum;
	sum = 0.0;
	for (uint32_t i = 0; i < 4; i++) {
		chi_square_corner(low, half, i, corner);
		sum += chi_square_integral(subject, corner, half, quarters[i].sum, CHI_SQUARE_STRICTER * tolerance, cuts + 1);
	}
	return sum;
}

static inline chi_square_result chi_square_compare(const chi_square_subject *subject, uint64_t seed, uint32_t draws)
{
	static chi_square_tree tree;
	shade_proof_random random = {.seed = seed};
	uint32_t pilots = 0;
	for (uint32_t i = 0; i < CHI_SQUARE_PILOTS; i++)
		pilots += subject->draw(subject->context, &random, tree.pilots[pilots]);
	tree.nodes[0] = (chi_square_node){.side = 1.0};
	tree.node_count = 1;
	tree.cell_count = 0;
	chi_square_cut(&tree, 0, tree.pilots, pilots);
	chi_square_balance(&tree);
	chi_square_name(&tree, 0, CHI_SQUARE_NODES);
	memset(tree.expected, 0, (tree.cell_count + 1u) * sizeof *tree.expected);
	memset(tree.found, 0, (tree.cell_count + 1u) * sizeof *tree.found);
	double tolerance = CHI_SQUARE_QUADRATURE * sqrt(1.0 / ((double)tree.cell_count * draws)), mass = 0.0;
	for (uint32_t i = 0; i < tree.node_count; i++) {
		const chi_square_node *node = &tree.nodes[i];
		if (node->child)
			continue;
		double whole = chi_square_gauss(subject, node->low, node->side).sum;
		double share = chi_square_integral(subject, node->low, node->side, whole, tolerance, 0);
		tree.expected[node->cell] += share * draws;
		mass += share;
	}
	uint32_t nothing = tree.cell_count;
	tree.expected[nothing] = fmax(1.0 - mass, 0.0) * draws;
	for (uint32_t i = 0; i < draws; i++) {
		double at[2];
		bool chosen = subject->draw(subject->context, &random, at);
		tree.found[chosen ? tree.nodes[chi_square_leaf(&tree, at)].cell : nothing]++;
	}
	/* If something is chosen always, quadrature's error is not to be counted as draws. */
	bool always = tree.found[nothing] == 0 && mass >= 1.0 - CHI_SQUARE_MASS_ERROR;
	double p = chi_square_p(tree.expected, tree.found, tree.cell_count + (always ? 0u : 1u), CHI_SQUARE_MISSED * draws);
	return (chi_square_result){.p = mass <= 1.0 + CHI_SQUARE_MASS_ERROR ? p : 0.0, .mass = mass};
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

/* The square's point of a direction; areas of the sphere over 4 pi become areas of the square. The left half is the
 * hemisphere above the frame's horizon, the right half the one below: each is flattened to a disk (Lambert's azimuthal
 * map) and that to a square (Shirley and Chiu's, as shade_concentric). So there are no poles, where cells are thin. */
static inline void chi_square_place(shade_frame frame, stilb_vec3 direction, double at[2])
{
	stilb_vec3 local = shade_frame_to_local(frame, direction);
	double x = (double)local[0], y = (double)local[1], z = (double)local[2];
	double radius = hypot(x, y) / sqrt(1.0 + fabs(z));
	bool steep = fabs(y) > fabs(x);
	double longer = copysign(radius, steep ? y : x);
	double other = radius > 0.0 ? longer * atan(steep ? x / y : y / x) * (4.0 / M_PI) : 0.0;
	at[0] = 0.5 * fmin(0.5 + 0.5 * (steep ? other : longer), 0.999999999) + (z < 0.0 ? 0.5 : 0.0);
	at[1] = fmin(0.5 + 0.5 * (steep ? longer : other), 0.999999999);
}

static inline stilb_vec3 chi_square_direction(shade_frame frame, const double at[2])
{
	bool below = at[0] >= 0.5;
	double x = 4.0 * (at[0] - (below ? 0.5 : 0.0)) - 1.0, y = 2.0 * at[1] - 1.0;
	bool steep = fabs(y) > fabs(x);
	double radius = steep ? y : x, angle = radius != 0.0 ? 0.25 * M_PI * (steep ? x : y) / radius : 0.0;
	double across = radius * cos(angle) * sqrt(2.0 - radius * radius);
	double along = radius * sin(angle) * sqrt(2.0 - radius * radius), z = 1.0 - radius * radius;
	stilb_vec3 local = {(float)(steep ? along : across), (float)(steep ? across : along), (float)(below ? -z : z)};
	return shade_frame_to_world(frame, local);
}

#endif
