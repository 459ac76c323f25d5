// What the passes of occlusion have (post_occlusion.c). They look at the scene in half the size: a texel stands for the
// left upper one of four pixels.

// As occlusion_push.
layout(push_constant, std430) uniform Push {
	mat4 from_clip; // to the world's directions, around the camera
	float radius;   // metres
	float strength;
	float smallest; // depth that is still something
} push;

// Where the pixel's middle and its depth are, from the camera, metres. size: of the picture.
vec3 occlusion_place(vec2 pixel, float depth, vec2 size)
{
	vec4 p = push.from_clip * vec4(2.0 * pixel / size - 1.0, depth, 1.0);
	return p.xyz / p.w;
}
