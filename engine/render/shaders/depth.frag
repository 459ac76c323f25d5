#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes that fade where depth alone is drawn; others need no fragment shader there.
#include "mesh.glsl"
#include "faded.glsl"

layout(location = 2) flat in uint material_word;

void main()
{
	if (is_faded_out(material_word))
		discard;
}
