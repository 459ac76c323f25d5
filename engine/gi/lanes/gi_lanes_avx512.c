/* Vertices with AVX-512. */
#if defined(__x86_64__)
#define KERNELS gi_lanes_avx512
#include "gi/lanes/gi_lanes_kernels.h"
#endif
