#version 460
#extension GL_GOOGLE_include_directive : require
// Impostors where depth alone is drawn; MESH_VELOCITY: where velocities are.
#include "mesh.glsl"
#include "faded.glsl"
#include "impostor_seen.glsl"
#ifdef MESH_VELOCITY
#include "velocity.glsl"
#endif

void main()
{
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
	vec3 place = place_of(look_at_pictures());
	gl_FragDepth = depth_of(place);
#ifdef MESH_VELOCITY
	velocity = velocity_from(last_place(place), vec2(push.view.rest.half_width, push.view.rest.half_height));
#endif
}
