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
	vec4 place = vec4(place_of(look_at_pictures()), 1.0);
	gl_FragDepth = depth_of(place.xyz);
#ifdef MESH_VELOCITY
	vec4 last = vec4(dot(moved[0], place), dot(moved[1], place), dot(moved[2], place), 1.0);
	velocity = velocity_from((push.view.rest.last_view_projection * last).xyw,
		vec2(push.view.rest.half_width, push.view.rest.half_height));
#endif
}
