/* Which of 100,000 lights: the case `octree-100000` of the suite `lights`. */
#ifndef LIGHTS_OCTREE_H
#define LIGHTS_OCTREE_H

#include "bench/harness/bench_child.h"
#include "light/light.h"

/* Measures how long it takes to move a tenth of the lights in a loose octree and to choose those that the view of the
 * grid may have, in turn with as many models that move likewise and are culled, and prints the metrics. */
void lights_octree_measure(const bench_child *child, stilb_light_grid *grid, stilb_scene_light *lights, uint32_t count);

#endif
