#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "impostor_seen.glsl"

#ifndef MESH_SEEN
layout(location = 0) out vec4 color;
#endif
#ifdef LIT_BESIDE
#include "velocity/beside.glsl"
#endif

vec3 world_position;

#include "lit.glsl"
#ifdef MESH_CHANNEL
#include "channel.glsl"
#endif

void main()
{
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
	Pictures p = look_at_pictures();
	world_position = place_of(p);
	vec3 weights = p.weights;
	vec3 model_normal = p.a.normal * weights.x + p.b.normal * weights.y + p.c.normal * weights.z;
	vec3 n = normalize(vec3(dot(normal_x, model_normal), dot(normal_y, model_normal), dot(normal_z, model_normal)));
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	if (both_sides)
		n = bent_normal(n, to_camera);

#ifdef LIT_BESIDE
	beside_write((beside & BESIDE_VELOCITY) != 0u ? last_place(world_position) : vec3(0.0), n, model_id);
#endif
#ifdef MESH_SEEN
	gl_FragDepth = depth_of(world_position);
#else
	uint index = material_of_word(material_word);
	Material stored = stored_material(index);
	vec3 diffuse = p.a.color.rgb * weights.x + p.b.color.rgb * weights.y + p.c.color.rgb * weights.z;
	float roughness = dot(weights, vec3(p.a.roughness, p.b.roughness, p.c.roughness));
#ifdef MESH_CHANNEL
	gl_FragDepth = depth_of(world_position);
	shade_material material = shade_material(diffuse, stored.specular_anisotropy.xyz, roughness, 0.0, 0.0);
	color = channel_color(channels_of(material, vec3(0.0), n, vec4(0.0)), index);
	return;
#endif
	vec3 radiance = lit_radiance(material_here(stored, diffuse, roughness), vec3(0.0), n, to_camera);
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(material_word, n, to_camera);
	gl_FragDepth = depth_of(world_position);
	color = picture_color(radiance, index);
#endif
}
