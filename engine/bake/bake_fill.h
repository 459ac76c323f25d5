/* bake_fill: gives texels without light of their own that of their neighbours, so that lookups between texels and in
 * mip levels find nothing black. [any-thread] */
#ifndef STILB_BAKE_FILL_H
#define STILB_BAKE_FILL_H

#include "bake/bake_light.h"

#define STILB_BAKE_FILL_CHANNELS 9 /* at most */

/* Fills hidden texels, wherever they are within their chart, and empty ones up to `border` texels away from a chart, in
 * rounds: each round fills those beside texels that have values, with the mean of these. values: [side * side *
 * channels]. What was filled becomes STILB_BAKE_FILLED in `state`, if `mark`: the last call of several. place: of the
 * page's stilb_bake_texels. Hidden texels take from their own chart alone. STILB_ERROR_MEMORY. */
stilb_result stilb_bake_fill(uint32_t side, const uint32_t *place, uint32_t border, uint8_t *state, bool mark,
                             float *values, uint32_t channels);

#endif
