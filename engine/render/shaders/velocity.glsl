// The velocity of what a pixel shows: pixels from its middle to where the same point was in the frame before.
layout(location = 0) out vec2 velocity;

const float FASTEST = 32768.0; // what the camera has passed was nowhere in the picture

// last: x, y, w of that place in clip space. half_size: of the picture, pixels.
vec2 velocity_from(vec3 last, vec2 half_size)
{
	vec2 place = (last.xy / max(last.z, 1e-6) + 1.0) * half_size;
	return clamp(place - gl_FragCoord.xy, -FASTEST, FASTEST);
}

// MESH_SEEN: programs that also write what else later passes want to know of what a pixel shows.
#ifdef MESH_SEEN
#include "../../shading/shade_impostor.h"

layout(location = 1) out vec2 seen_normal; // on the octahedral map, times 0.5, plus 0.5
layout(location = 2) out uint seen_id;

// n: the unit shading normal; model: 1 + the scene's, 0: none.
void seen_write(vec3 n, uint model)
{
	seen_normal = shade_octahedral_from_direction(n) * 0.5 + 0.5;
	seen_id = model;
}
#endif
