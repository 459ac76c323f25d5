// Light as scene passes keep it (stilb_render_hdr): with 0 in half floats, else in 8 bits, multiplied by the exposure.
// Who includes it has defined HDR_CONSTANT, the number of the constant that says so.
#include "../../../shading/shade_encoding.h"

layout(constant_id = HDR_CONSTANT) const uint hdr = 0u;
#define HDR_HALF 0u
#define HDR_RGBM 1u

vec4 hdr_encoded(vec3 exposed)
{
	return hdr == HDR_RGBM ? shade_rgbm_encode(exposed, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA)
	                       : shade_logluv_encode(exposed);
}

vec3 hdr_decoded(vec4 stored)
{
	return hdr == HDR_RGBM ? shade_rgbm_decode(stored, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA)
	                       : shade_logluv_decode(stored);
}
