/* Camera rays and surfaces with AVX2. */
#if defined(__x86_64__)
#define KERNELS gi_primary_kernels_avx2
#include "gi/film/gi_primary_lanes.h"
#endif
