/*
 * bake_conform: the least-squares conformal map of a patch. With a triangle's corners z in a plane of its own and w in
 * the map, both complex, and W_j = z_(j+2) - z_(j+1), the map is conformal in it where sum W_j w_j = 0. The sum over
 * triangles of |sum W_j w_j|^2 / (2 area) becomes least, two vertices being held: Levy et al. (2002), section 3.
 *
 * Solved by conjugate gradients for the normal equations, which are applied triangle by triangle and never stored, with
 * their diagonal as preconditioner.
 */
#include "bake/unwrap/bake_patch.h"

#include <math.h>
#include <stdlib.h>

#define CONFORM_STEPS 16   /* after so many it is looked how much they have gained */
#define CONFORM_GAIN 2e-5  /* of all that was gained so far: less is the end */
#define CONFORM_MOST 2000u /* steps */

/* A complex number: real and imaginary part. */
typedef double number __attribute__((vector_size(16)));

typedef struct conform {
	const bake_patch *patch;
	number (*weights)[3]; /* [count] W_j / sqrt(2 area) */
	double *diagonal;     /* [vertex_count] 1 / that of the normal equations; 0: the vertex is held */
	number *map, *residual, *step, *product; /* [vertex_count] */
} conform;

static double norm2(number a)
{
	return a[0] * a[0] + a[1] * a[1];
}

static number times(number a, number b)
{
	return (number){a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]};
}

static number conjugate(number a)
{
	return (number){a[0], -a[1]};
}

static bool conform_weights(conform *c)
{
	double most = 0.0;
	for (uint32_t t = 0; t < c->patch->count; t++) {
		bake_flat flat = bake_patch_flat(c->patch, t);
		double scale = 1.0 / sqrt(flat.x1 * flat.y);
		const number z[3] = {{0.0, 0.0}, {flat.x1, 0.0}, {flat.x2, flat.y}};
		for (int j = 0; j < 3; j++) {
			c->weights[t][j] = (z[(j + 2) % 3] - z[(j + 1) % 3]) * scale;
			c->diagonal[c->patch->corner[3 * (size_t)t + (size_t)j]] += norm2(c->weights[t][j]);
		}
	}
	for (uint32_t v = 0; v < c->patch->vertex_count; v++) {
		most = fmax(most, c->diagonal[v]);
		c->diagonal[v] = 1.0 / c->diagonal[v];
	}
	return most < HUGE_VAL;
}

/* Holds the two vertices of the border that are farthest apart along one of four directions. */
static void conform_hold(conform *c)
{
	static const double directions[4][2] = {{1.0, 0.0}, {0.0, 1.0}, {0.7071, 0.7071}, {0.7071, -0.7071}};
	uint32_t held[2] = {0, 0};
	double widest = -1.0;
	for (int d = 0; d < 4; d++) {
		double least = HUGE_VAL, most = -HUGE_VAL;
		uint32_t first = 0, last = 0;
		for (uint32_t i = 0; i < c->patch->border_count; i++) {
			uint32_t v = c->patch->border[i][0];
			double along = c->patch->at[v][0] * directions[d][0] + c->patch->at[v][1] * directions[d][1];
			if (along < least) {
				least = along;
				first = v;
			}
			if (along > most) {
				most = along;
				last = v;
			}
		}
		if (most - least > widest) {
			widest = most - least;
			held[0] = first;
			held[1] = last;
		}
	}
	c->diagonal[held[0]] = c->diagonal[held[1]] = 0.0;
}

/* product = the normal equations times x; held vertices get 0. */
static void conform_apply(const conform *c, const number *x, number *product)
{
	uint32_t count = c->patch->vertex_count;
	for (uint32_t v = 0; v < count; v++)
		product[v] = (number){0.0, 0.0};
	for (uint32_t t = 0; t < c->patch->count; t++) {
		const uint32_t *v = &c->patch->corner[3 * (size_t)t];
		const number *w = c->weights[t];
		number sum = times(w[0], x[v[0]]) + times(w[1], x[v[1]]) + times(w[2], x[v[2]]);
		for (int j = 0; j < 3; j++)
			product[v[j]] += times(conjugate(w[j]), sum);
	}
	for (uint32_t v = 0; v < count; v++)
		if (!(c->diagonal[v] > 0.0))
			product[v] = (number){0.0, 0.0};
}

static double conform_dot(const conform *c, const number *a, const number *b, bool weighed)
{
	double sum = 0.0;
	for (uint32_t v = 0; v < c->patch->vertex_count; v++)
		sum += (a[v][0] * b[v][0] + a[v][1] * b[v][1]) * (weighed ? c->diagonal[v] : 1.0);
	return sum;
}

/* Preconditioned conjugate gradients from the map that is there: Hestenes and Stiefel (1952). A step of length l along
 * a direction lessens the sum of squares by l times the residual's norm, so it is known when the rest is not worth it;
 * wherever it ends there is a map. */
static void conform_solve(conform *c)
{
	uint32_t count = c->patch->vertex_count;
	conform_apply(c, c->map, c->residual);
	for (uint32_t v = 0; v < count; v++) {
		c->residual[v] = -c->residual[v];
		c->step[v] = c->diagonal[v] * c->residual[v];
	}
	double rz = conform_dot(c, c->residual, c->residual, true), gained = 0.0, all = 0.0;
	for (uint32_t i = 1; i <= CONFORM_MOST && rz > 0.0; i++) {
		conform_apply(c, c->step, c->product);
		double curvature = conform_dot(c, c->step, c->product, false);
		if (!(curvature > 0.0))
			return;
		double length = rz / curvature;
		gained += length * rz;
		all += length * rz;
		for (uint32_t v = 0; v < count; v++) {
			c->map[v] += length * c->step[v];
			c->residual[v] -= length * c->product[v];
		}
		if (i % CONFORM_STEPS == 0) {
			if (gained < CONFORM_GAIN * all)
				return;
			gained = 0.0;
		}
		double next = conform_dot(c, c->residual, c->residual, true), ratio = next / rz;
		rz = next;
		for (uint32_t v = 0; v < count; v++)
			c->step[v] = c->diagonal[v] * c->residual[v] + ratio * c->step[v];
	}
}

stilb_result bake_patch_conform(bake_patch *patch)
{
	size_t count = patch->vertex_count;
	conform c = {.patch = patch};
	number *vectors = stilb_memory_alloc(4 * count, sizeof *vectors);
	c.weights = stilb_memory_alloc(patch->count, sizeof *c.weights);
	c.diagonal = calloc(count, sizeof *c.diagonal);
	bool good = vectors && c.weights && c.diagonal;
	if (good && conform_weights(&c)) {
		c.map = vectors;
		c.residual = vectors + count;
		c.step = vectors + 2 * count;
		c.product = vectors + 3 * count;
		for (uint32_t v = 0; v < count; v++)
			c.map[v] = (number){patch->at[v][0], patch->at[v][1]};
		conform_hold(&c);
		conform_solve(&c);
		for (uint32_t v = 0; v < count; v++) {
			patch->at[v][0] = c.map[v][0];
			patch->at[v][1] = c.map[v][1];
		}
	}
	free(vectors);
	free(c.weights);
	free(c.diagonal);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "out of memory for a chart of %u triangles", patch->count);
}
