#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes with a mask where depth alone is drawn; MESH_VELOCITY: where velocities are.
#include "mesh.glsl"
#include "maps_color.glsl"
#include "faded.glsl"
#ifdef MESH_VELOCITY
#include "velocity.glsl"
layout(location = 4) in vec3 last_clip;
#endif

void main()
{
	uint record = push.materials.materials[material_word & MATERIAL_INDEX].ids.y;
	float alpha = raw_color(record).w * record_part(record, 0u).w;
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
	if (alpha < record_part(record, 3u).z)
		discard;
#ifdef MESH_VELOCITY
	velocity = velocity_from(last_clip, vec2(push.view.rest.half_width, push.view.rest.half_height));
#endif
}
