#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes that fade where depth alone is drawn; others need no fragment shader there. MESH_VELOCITY: all meshes where
// velocities are.
#include "mesh.glsl"
#include "faded.glsl"

layout(location = 2) flat in uint material_word;

#ifdef MESH_VELOCITY
#include "velocity.glsl"
layout(location = 4) in vec3 last_clip;
#endif

void main()
{
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
#ifdef MESH_VELOCITY
	velocity = velocity_from(last_clip, vec2(push.view.rest.half_width, push.view.rest.half_height));
#endif
}
