/* Camera rays and surfaces in the instructions that every CPU has: the truth that the others are tested against. */
#define KERNELS gi_primary_kernels_scalar
#include "gi/film/gi_primary_lanes.h"
