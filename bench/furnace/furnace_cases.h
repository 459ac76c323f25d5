/*
 * furnace_cases: the cases of the suite `furnace`, which compares path tracing with a known radiance; included by
 * stilb-bench and by the program that it starts. Scene: the inside of a ball that emits Le = 1 everywhere and reflects
 * rho = 1/2, so the radiance is Le / (1 - rho) = 2 in every direction. The lists of numbers below are also parts of
 * metric names (error-3).
 */
#ifndef FURNACE_CASES_H
#define FURNACE_CASES_H

#define FURNACE_REFLECTANCE 0.5
#define FURNACE_RADIANCE (1.0 / (1.0 - FURNACE_REFLECTANCE))

/* Number of paths in one experiment, whose mean is compared with the exact radiance. */
#define FURNACE_RUNS 1000u

/* Numbers of bounces after which paths end. */
#define FURNACE_BOUNCES(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15) X(16)
#define FURNACE_MOST_BOUNCES 16u

/* Survival probabilities of Russian roulette, percent. */
#define FURNACE_SURVIVALS(X)                                                                                           \
	X(5) X(10) X(15) X(20) X(25) X(30) X(35) X(40) X(45) X(50) X(55) X(60) X(65) X(70) X(75) X(80) X(85) X(90) X(95)

/* Numbers of rays at every hit of the integrator `montecarlo`, which is compared with `path` in equal time. */
#define FURNACE_BRANCHES(X) X(1) X(2) X(4) X(8)
#define FURNACE_EQUAL_DEPTH 3u

#define FURNACE_CASE_BOUNCES "bounces"
#define FURNACE_CASE_SURVIVAL "survival"
#define FURNACE_CASE_EQUAL_TIME "equal-time"

/*
 * The variance of the radiance X of a path with survival probability p: X = 1 + (rho / p) X' with probability p, else
 * 1, so E[X] = 1 / (1 - rho) and E[X^2] = (1 + rho) / (1 - rho) / (1 - rho^2 / p). Infinite if p <= rho^2.
 */
static inline double furnace_variance(double survival)
{
	double rho = FURNACE_REFLECTANCE, left = 1.0 - rho * rho / survival;
	return left > 0.0 ? (1.0 + rho) / (1.0 - rho) / left - FURNACE_RADIANCE * FURNACE_RADIANCE : __builtin_inf();
}

#endif
