#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes with a mask where depth alone is drawn.
#include "mesh.glsl"
#include "maps_color.glsl"
#include "faded.glsl"

void main()
{
	uint both = detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW ? (1u << DETAIL_MATERIAL_SHIFT) - 1u : ~0u;
	uint record = push.materials.materials[material_word & both].ids.y;
	float alpha = raw_color(record).w * record_part(record, 0u).w;
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
	if (alpha < record_part(record, 3u).z)
		discard;
}
