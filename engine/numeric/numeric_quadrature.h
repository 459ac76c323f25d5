/*
 * numeric_quadrature: integrals in double: the truth that formulas, lobes and samplers are held against.
 *
 * Use.      stilb_numeric_integrate for a function of one number, stilb_numeric_integrate_sphere for a function of a direction,
 *           stilb_numeric_integrate_lobe where the function is narrow. All are made for smooth functions: split the range where
 *           the function has a kink, and choose enough panels for its narrowest feature.
 * Space.    Directions are unit, as three doubles in a tangent frame: x and y along the surface, z along its normal.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_NUMERIC_QUADRATURE_H
#define STILB_NUMERIC_QUADRATURE_H

typedef double stilb_numeric_function(double x, const void *context);
typedef double stilb_numeric_direction_function(const double direction[3], const void *context);

/* Integral of f(x) dx over [low, high], by Gauss and Legendre's rule of 16 points (exact for polynomials of degree 31) in
 * each of `panels` equal panels, at least 1. Source: Press et al., "Numerical Recipes", 3rd ed. (2007), 4.6. */
double stilb_numeric_integrate(stilb_numeric_function *f, const void *context, double low, double high, int panels);

/* Integral of f(w) dw over the directions whose z is in [low, high]: [-1, 1] is the sphere, [0, 1] the upper hemisphere.
 * The rule above in z with `panels` panels, and the rectangle rule (exact for harmonics below its count) with
 * 32 * `panels` points around. */
double stilb_numeric_integrate_sphere(stilb_numeric_direction_function *f, const void *context, double low, double high,
                                      int panels);

/* Integral of f(w) dw over the sphere where f is a lobe about z of about this `width` (radians, in (0, 1]) and with a tail:
 * tan(theta / 2) = width sinh(t), so that equal steps of t meet core and tail alike; 64 points around. */
double stilb_numeric_integrate_lobe(stilb_numeric_direction_function *f, const void *context, double width);

#endif
