#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
// The velocity of what is seen where no model is: infinitely far away, or on the floor of a studio.
#include "../velocity.glsl"

const float REACH = 2.0; // as STILB_SCENE_FLOOR_REACH

// As render_velocity_data.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer View { mat4 last_view_projection; };

// As render_velocity_push.
layout(push_constant, std430) uniform Push {
	vec4 ahead; // direction at the picture's middle, and what a step of 1 in clip space adds to it
	vec4 across;
	vec4 down;
	vec4 camera;
	vec4 floor_radius; // center of the floor and its radius, 0: there is none
	vec2 half_size;    // of the picture, pixels
	View view;
} push;

layout(location = 0) in vec2 uv; // of the picture, 0..1

void main()
{
	vec2 clip = uv * 2.0 - 1.0;
	vec3 direction = push.ahead.xyz + clip.x * push.across.xyz + clip.y * push.down.xyz;
	vec4 place = vec4(direction, 0.0);
	float above = push.camera.y - push.floor_radius.y;
	if (push.floor_radius.w > 0.0 && above > 0.0 && direction.y < 0.0) {
		vec3 point = push.camera.xyz + direction * (above / -direction.y);
		if (distance(point.xz, push.floor_radius.xz) < REACH * push.floor_radius.w)
			place = vec4(point, 1.0);
	}
	velocity = velocity_from((push.view.last_view_projection * place).xyw, push.half_size);
}
