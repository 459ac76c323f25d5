/* Importance in the light tree in the instructions that every CPU of the architecture has. */
#define WEIGH gi_light_weigh_scalar
#define LANES 4
#include "gi/light/gi_light_lanes.h"
