/* Vertices with AVX2. */
#if defined(__x86_64__)
#define KERNELS gi_lanes_avx2
#include "gi/lanes/gi_lanes_kernels.h"
#endif
