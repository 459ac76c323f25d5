#version 460
#extension GL_GOOGLE_include_directive : require
// A material with five maps under a panorama, straight on: what the engine's shader computes of it, and nothing else.
#include "../../engine/shading/shade_environment.h"
#include "../../engine/shading/shade_gltf.h"
#include "../../engine/shading/shade_surface.h"
#include "textured.glsl"

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) in vec3 world_tangent;
layout(location = 3) flat in float tangent_sign;
layout(location = 4) in vec2 place;
layout(location = 0) out vec4 color;

#ifdef TEXTURED_ARRAYS
#define MAP sampler2DArray
#define AT(place) vec3(place, 0.0)
#else
#define MAP sampler2D
#define AT(place) place
#endif
layout(set = 0, binding = 0) uniform MAP color_map;
layout(set = 0, binding = 1) uniform MAP reflection_map;
layout(set = 0, binding = 2) uniform MAP normal_map;
layout(set = 0, binding = 3) uniform MAP occlusion_map;
layout(set = 0, binding = 4) uniform MAP emission_map;
layout(set = 0, binding = 5) uniform samplerCube panorama_cube;
layout(set = 0, binding = 6) uniform sampler2D gloss_table;
layout(set = 0, binding = 7) uniform sampler2D irradiance_map;
layout(set = 0, binding = 9, std430) readonly buffer Table { vec4 at[]; } irradiance;
#ifdef TEXTURED_FETCHED
#define IRRADIANCE(i) texelFetch(irradiance_map, ivec2((i) % 256, (i) / 256), 0).xyz
#elif defined(TEXTURED_ADDRESS)
#define IRRADIANCE(i) Parts(material.table).at[i].xyz
#else
#define IRRADIANCE(i) irradiance.at[i].xyz
#endif
#ifdef TEXTURED_HANDED
layout(location = 5) flat in vec4 parts[4];
#define PART(i) parts[i]
#else
#define PART(i) material.parts[i]
#endif
#ifdef TEXTURED_EXTRAS
layout(location = 9) in vec4 surface_color;
#else
const vec4 surface_color = vec4(1.0);
#endif

vec3 panorama_own(vec3 d)
{
	return vec3(material.turn.y * d.x - material.turn.x * d.z, d.y, material.turn.x * d.x + material.turn.y * d.z);
}

vec3 panorama_irradiance(vec3 n)
{
	vec3 own = panorama_own(n);
	float longitude = own.x == 0.0 && own.z == 0.0 ? 0.0 : atan(own.x, -own.z);
	float x = clamp(longitude / (2.0 * SHADE_PI) + 0.5, 0.0, 1.0) * 256.0;
	float y = atan(length(own.xz), own.y) / SHADE_PI * 128.0;
#ifdef TEXTURED_SAMPLED
	return textureLod(irradiance_map, vec2((x + 0.5) / 256.0, (y + 0.5) / 129.0), 0.0).xyz;
#else
	int column = int(floor(x)), row = clamp(int(floor(y)), 0, 127);
	int left = row * 256 + column % 256, next = row * 256 + (column + 1) % 256;
	float across = x - float(column);
	vec3 above = mix(IRRADIANCE(left), IRRADIANCE(next), across);
	vec3 below = mix(IRRADIANCE(left + 256), IRRADIANCE(next + 256), across);
	return mix(above, below, y - float(row));
#endif
}

vec3 normal_here(vec3 texel, vec3 flat_normal, vec3 to_camera)
{
	vec3 n = shade_gltf_turned(shade_gltf_normal(texel, PART(3).x), world_tangent, tangent_sign, world_normal);
#ifdef TEXTURED_SIDES
	vec3 own = normalize(world_normal), facing = dot(flat_normal, to_camera) < 0.0 ? -flat_normal : flat_normal;
	float along = dot(own, facing);
	if (abs(along) > 1e-3 * length(facing) ? along < 0.0 : !gl_FrontFacing)
		n = -n;
#endif
	float lacking = 1e-3 - dot(n, to_camera);
	n = lacking > 0.0 ? normalize(n + to_camera * lacking) : n;
	float square = dot(flat_normal, flat_normal), side = dot(flat_normal, to_camera);
	vec3 mirrored = reflect(-to_camera, n), up = flat_normal * (sign(side) * inversesqrt(max(square, 1e-30)));
	lacking = 1e-3 - dot(mirrored, up);
	return lacking > 0.0 && square > 0.0 ? normalize(normalize(mirrored + up * lacking) + to_camera) : n;
}

// How far the normals below a texel spread, in a footprint of this shape.
float spread_of(float variance, vec2 texels)
{
	vec2 right = dFdx(texels), down = dFdy(texels);
	float one = dot(right, right), other = dot(down, down);
	return clamp(1.0 - variance, 0.0, 1.0) * sqrt(0.5 + 0.5 * min(min(one, other) / max(max(one, other), 1e-20), 1.0));
}

void main()
{
	vec3 flat_normal = cross(dFdx(world_position), dFdy(world_position));
	vec3 to_camera = normalize(push.camera.xyz - world_position);
	vec3 base_color = clamp(texture(color_map, AT(place)).xyz * PART(0).xyz * surface_color.xyz, 0.0, 1.0);
	vec4 reflection = texture(reflection_map, AT(place)), normal = texture(normal_map, AT(place));
	float occlusion = shade_gltf_occlusion(texture(occlusion_map, AT(place)).x, PART(3).y);
	vec3 radiance = PART(2).xyz * texture(emission_map, AT(place)).xyz;
#ifdef TEXTURED_SIDES
	radiance = gl_FrontFacing ? radiance : vec3(0.0);
#endif
	vec3 n = normal_here(normal.xyz, flat_normal, to_camera);
	shade_gltf_base base = shade_gltf_metallic(base_color, PART(2).w * reflection.z,
		PART(1).w * reflection.y, PART(1).xyz);
	float spread = spread_of(normal.w, place * vec2(textureSize(normal_map, 0).xy));
	float roughness = shade_gltf_widened(base.roughness, min(spread * abs(PART(3).x), 1.0));
	shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
	shade_material seen =
		shade_surface_seen(model, shade_material(base.diffuse, base.specular, roughness, 0.0, 0.0), dot(n, to_camera));
	radiance += shade_lambert(seen.diffuse) * panorama_irradiance(n) * occlusion;
	vec2 dfg = textureLod(gloss_table, shade_dfg_texel(shade_dfg_place(dot(n, to_camera), roughness), 64.0), 0.0).xy;
	shade_environment_look look = shade_environment_look_of(n, to_camera, roughness);
	vec3 mirrored =
		textureLod(panorama_cube, panorama_own(look.toward), shade_environment_mip(look.roughness, 6.0)).xyz;
	color = vec4(radiance + mirrored * (seen.specular * dfg.x + dfg.y), 1.0);
}
