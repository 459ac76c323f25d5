/* A floor under lamps: the case `floor-18` of the suite `lights`. */
#ifndef LIGHTS_FLOOR_H
#define LIGHTS_FLOOR_H

#include "bench/harness/bench_child.h"

/* Cuts a floor of two triangles at the bounds of the lamps above it (geometry_lights.h), and prints what that takes and
 * adds. */
void lights_floor_measure(const bench_child *child);

#endif
