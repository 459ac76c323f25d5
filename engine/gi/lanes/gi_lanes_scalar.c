/* Vertices in the instructions that every CPU of the architecture has: the reference for the others. */
#define KERNELS gi_lanes_scalar
#include "gi/lanes/gi_lanes_kernels.h"
