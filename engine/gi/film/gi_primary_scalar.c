/* Camera rays and surfaces in the instructions that every CPU of the architecture has: the reference for the others. */
#define KERNELS gi_primary_kernels_scalar
#include "gi/film/gi_primary_lanes.h"
