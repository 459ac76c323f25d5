// What the passes of motion blur have (post_motion.c). Movement is half the way of a pixel while the shutter is open,
// pixels: to both sides of where it is in the frame. Tiles are squares of the picture, as wide as the longest movement.

// As motion_push.
layout(push_constant, std430) uniform Push {
	vec4 ahead_row; // 1 / metres ahead of the camera = dot(ahead_row, place in clip space)
	ivec2 tile;     // of what is read by the pass, texels that one is made of
	float half_way; // the share of a frame's velocity that movement is
	float longest;  // pixels
} push;

// No longer than the longest.
vec2 motion_of(vec2 velocity)
{
	vec2 movement = velocity * push.half_way;
	float size = length(movement);
	return size > push.longest ? movement * (push.longest / size) : movement;
}

vec2 motion_longer(vec2 a, vec2 b)
{
	return dot(b, b) > dot(a, a) ? b : a;
}
