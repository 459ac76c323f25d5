// The velocity of what a pixel shows: pixels from its middle to where the same point was in the frame before.
// BESIDE_FIRST: the place of its image among what the program draws into (velocity/beside.glsl).
#ifndef BESIDE_FIRST
#define BESIDE_FIRST 0
#endif

layout(location = BESIDE_FIRST) out vec2 velocity;

const float FASTEST = 32768.0; // what the camera has passed was nowhere in the picture

// last: x, y, w of that place in clip space. half_size: of the picture, pixels.
vec2 velocity_from(vec3 last, vec2 half_size)
{
	vec2 place = (last.xy / max(last.z, 1e-6) + 1.0) * half_size;
	return clamp(place - gl_FragCoord.xy, -FASTEST, FASTEST);
}
