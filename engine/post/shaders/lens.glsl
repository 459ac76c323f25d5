// What all passes of depth of field have (post_lens.c). A circle of confusion is the radius over which the light of a
// point spreads in the picture, in pixels of the picture; below 0 that of what is nearer than the plane in focus. Such
// points spread over the aperture's mirror image.

layout(constant_id = 0) const uint blades = 0; // corners of the aperture; 0: it is round

// As lens_push.
layout(push_constant, std430) uniform Push
{
	float at_infinity; // circle of confusion at depth 0
	float slope;       // and what a depth of 1 adds to it
	float largest;     // pixels; circles are cut there
	uint levels;       // of the light in smaller sizes
	float radius;      // of a blur of one radius; pixels
}
push;

// Circles below SHARP are gathered in the picture's size, those above SOFT in smaller ones; in between both.
const float SHARP = 1.0, SOFT = 2.0; // pixels

float lens_softness(float circle)
{
	return smoothstep(SHARP, SOFT, abs(circle));
}
