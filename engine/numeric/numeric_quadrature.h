/*
 * numeric_quadrature: integrals in double: the reference for formulas, lobes and samplers.
 *
 * Use.      stilb_numeric_integrate for a function of one number, stilb_numeric_integrate_sphere for a function of
 *           direction, stilb_numeric_integrate_lobe if that function is narrow. All are for smooth functions: split the
 *           range at a kink, and choose enough panels to resolve the narrowest feature.
 *
 *   static double square(double x, const void *context) { return x * x; }
 *   double third = stilb_numeric_integrate(square, NULL, 0.0, 1.0, 1);
 *
 * Context.  Passed on to f unchanged; may be NULL.
 * Space.    Directions are unit, as three doubles in a tangent frame: x and y along the surface, z along its normal.
 * Threads.  Pure functions: [any-thread], if f is.
 */
#ifndef STILB_NUMERIC_QUADRATURE_H
#define STILB_NUMERIC_QUADRATURE_H

typedef double stilb_numeric_function(double x, const void *context);
typedef double stilb_numeric_direction_function(const double direction[3], const void *context);

/* Integral of f(x) dx from low to high, both finite, by the Gauss-Legendre rule of 16 points (exact for polynomials up
 * to degree 31) in each of `panels` >= 1 equal panels. Source: Press et al., "Numerical Recipes", 3rd ed. (2007),
 * 4.6. */
double stilb_numeric_integrate(stilb_numeric_function *f, const void *context, double low, double high, int panels);

/* A point and what a function's value there counts in the rule above. */
typedef struct stilb_numeric_point {
	double x, weight;
} stilb_numeric_point;

/* The 16 x panels points of the rule above between low and high, in rising order: for several functions at once. */
void stilb_numeric_points(double low, double high, int panels, stilb_numeric_point *points);

/* Integral of f(w) dw over the directions whose z is in [low, high], within [-1, 1]: [-1, 1] is the sphere, [0, 1] the
 * upper hemisphere. In z the rule above with `panels` >= 1 panels; in the azimuth the rectangle rule with 32 x panels
 * points, exact for harmonics of lower order. */
double stilb_numeric_integrate_sphere(stilb_numeric_direction_function *f, const void *context, double low, double high,
                                      int panels);

/* Integral of f(w) dw over the sphere, for an f that is a lobe about z of about this width (radians, (0, 1]) with a
 * tail. The substitution tan(theta / 2) = width sinh(t) resolves core and tail alike; 64 points in the azimuth. */
double stilb_numeric_integrate_lobe(stilb_numeric_direction_function *f, const void *context, double width);

#endif
