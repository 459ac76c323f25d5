/* Frames of a floor under 1,000 lamps, some eight at each pixel, by each way of lighting; beside frames under lights
 * that every pixel asks. */
#ifndef LIGHTS_FRAMES_H
#define LIGHTS_FRAMES_H

#include "bench/harness/bench_child.h"

void lights_frames_measure(const bench_child *child);

#endif
