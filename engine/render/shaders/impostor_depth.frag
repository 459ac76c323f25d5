#version 460
#extension GL_GOOGLE_include_directive : require
// Impostors where depth alone is drawn.
#include "mesh.glsl"
#include "faded.glsl"
#include "impostor_seen.glsl"

void main()
{
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
	gl_FragDepth = depth_of(place_of(look_at_pictures()));
}
