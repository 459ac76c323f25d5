/* Importance in the light tree with AVX2. */
#if defined(__x86_64__)
#define WEIGH gi_light_weigh_avx2
#define LANES 8
#include "gi/light/gi_light_lanes.h"
#endif
