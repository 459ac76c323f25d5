/* Camera rays and surfaces with AVX-512. */
#if defined(__x86_64__)
#define KERNELS gi_primary_kernels_avx512
#include "gi/film/gi_primary_lanes.h"
#endif
