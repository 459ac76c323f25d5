#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "fade.glsl"
#include "../../shading/shade_energy.h"
#include "../../shading/shade_surface.h"
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool tone_map = true;
// The materials that the pipeline draws: 0 all, 1 those with an even index, 2 those with an odd one. Others are black.
layout(constant_id = 1) const uint drawn = 0;
// The formulas, in the order of vulkan_formula. They are compile-time constants: code of other formulas is removed.
layout(constant_id = 2) const int brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED;
layout(constant_id = 3) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 4) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 5) const int f = SHADE_F_SCHLICK;

// The kinds of light in the view's list, 1 << SHADE_LIGHT_... each, and five more bits (RENDER_LIGHTS_... of
// render_internal.h). Only the code of these is left: software devices compute every branch for every pixel.
layout(constant_id = 6) const uint lights = 1u << SHADE_LIGHT_DIRECTIONAL;
const bool lights_end = (lights & 64u) != 0;    // some have a falloff that is not physical
const bool lights_gloss = (lights & 128u) != 0; // highlights mirror sky and ground
const bool lights_panorama = (lights & 256u) != 0; // its irradiance in place of theirs
const bool both_sides = (lights & 512u) != 0;   // triangles are seen from behind, too
const bool lights_one = (lights & 1024u) != 0;  // the list has one light

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) flat in uint material_word; // the material's index, and above it how the draw fades

#ifdef MESH_TEXTURE
layout(location = 3) in vec2 surface_uv;
layout(set = 0, binding = 0) uniform sampler2D diffuse_texture;
#endif

#ifdef MESH_BIND
layout(set = 1, binding = 0, std430) readonly buffer Bound { Material material; } bound;
#endif

layout(location = 0) out vec4 color;

uint material_index()
{
	bool both = detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW;
	return both ? material_word & ((1u << DETAIL_MATERIAL_SHIFT) - 1u) : material_word;
}

Material stored_material()
{
#ifdef MESH_BIND
	return bound.material;
#else
	return push.materials.materials[material_index()];
#endif
}

// The draw's material plus the view's additions.
shade_material material_here(Material m)
{
	vec3 diffuse = m.diffuse_roughness.xyz;
#ifdef MESH_TEXTURE
	diffuse *= texture(diffuse_texture, surface_uv).rgb;
#endif
	vec4 added = push.view.added;
	shade_reflectance reflectance = {diffuse, m.specular_anisotropy.xyz};
	if (added.w != 0.0)
		reflectance = shade_limit_to_one(diffuse, reflectance.specular + added.w);
	return shade_material(reflectance.diffuse, reflectance.specular,
		clamp(m.diffuse_roughness.w + added.x, 0.0, 1.0),
		clamp(m.specular_anisotropy.w + added.y, -1.0, 1.0),
		clamp(m.emission_wrap.w + added.z, 0.0, 1.0));
}

// Meshes have no tangents: anisotropic materials are brushed around the vertical axis, as if turned on a lathe.
shade_frame frame_here(vec3 n)
{
	return shade_frame_from_tangent(n, vec3(n.z, 0.0, -n.x)); // cross(up, n)
}

// A light of the view's list. Whole vec4s are loaded: if .xyz and .w are loaded separately, lavapipe (Mesa 22.3) reads
// .w as 0.
shade_light light_of(uint index)
{
	vec4 position_kind = push.view.lights.lights[index].position_kind;
	vec4 direction_reach = push.view.lights.lights[index].direction_reach;
	vec4 intensity_inner = push.view.lights.lights[index].intensity_inner;
	vec4 half_x_outer = vec4(0.0);
	vec4 half_y_radius = vec4(0.0);
	if ((lights & ~(1u << SHADE_LIGHT_DIRECTIONAL)) != 0) {
		half_x_outer = push.view.lights.lights[index].half_x_outer;
		half_y_radius = push.view.lights.lights[index].half_y_radius;
	}
	int kind = int(position_kind.w);
	return shade_light(kind & 7, lights_end ? kind >> 3 : SHADE_FALLOFF_PHYSICAL, position_kind.xyz,
		direction_reach.xyz, intensity_inner.xyz, intensity_inner.w, half_x_outer.w, half_y_radius.w, half_x_outer.xyz,
		half_y_radius.xyz, direction_reach.w);
}

// What a light sends to v. Each kind has code of its own, so that nothing is left of kinds that the list has not.
vec3 from_light(shade_light light, shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	shade_sun seen = {vec3(0.0, 0.0, 1.0), vec3(0.0)};
	vec3 spread = vec3(0.0);
#define FROM_LIGHT(of_kind, sized)                                                                                     \
	if ((lights & (1u << of_kind)) != 0 && light.kind == of_kind) {                                                    \
		light.kind = of_kind;                                                                                          \
		seen = shade_light_at(light, world_position);                                                                  \
		if (sized)                                                                                                     \
			spread = shade_area_irradiance(light, world_position, frame.n);                                            \
	}
	FROM_LIGHT(SHADE_LIGHT_POINT, false)
	FROM_LIGHT(SHADE_LIGHT_SPOT, false)
	FROM_LIGHT(SHADE_LIGHT_DIRECTIONAL, false)
	bool lamp = lights_panorama && light.kind == SHADE_LIGHT_DIRECTIONAL; // one of its, or a light without a size
	if (lamp)
		spread = light.intensity * shade_distant_share(-light.direction, light.half_x, light.half_y, frame.n);
	FROM_LIGHT(SHADE_LIGHT_SPHERE, true)
	FROM_LIGHT(SHADE_LIGHT_DISK, true)
	FROM_LIGHT(SHADE_LIGHT_RECTANGLE, true)
#undef FROM_LIGHT
	return shade_surface_lit(model, material, frame, seen, lamp || shade_light_is_sized(light.kind), spread, v);
}

// What the lights of the view's list send to v.
vec3 from_lights(shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	if (lights_one) // with a loop, even of one turn, frames take software devices some 3 % longer
		return from_light(light_of(0), model, material, frame, v);
	vec3 radiance = vec3(0.0);
	for (uint i = 0; (lights & 63u) != 0 && i < push.view.light_count; i++)
		radiance += from_light(light_of(i), model, material, frame, v);
	return radiance;
}

// The panorama's irradiance at a normal, between four of the table; its lamps are lights of the list.
vec3 panorama_irradiance(vec3 n)
{
	const int COLUMNS = 256; // as RENDER_PANORAMA_COLUMNS and _ROWS
	const int ROWS = 129;
	vec2 turn = push.view.turn;
	float right = turn.y * n.x - turn.x * n.z;
	float back = turn.x * n.x + turn.y * n.z;
	float longitude = right == 0.0 && back == 0.0 ? 0.0 : atan(right, -back);
	float x = clamp(longitude / (2.0 * SHADE_PI) + 0.5, 0.0, 1.0) * float(COLUMNS);
	float y = atan(length(vec2(right, back)), n.y) / SHADE_PI * float(ROWS - 1);
	int column = int(floor(x));
	int row = clamp(int(floor(y)), 0, ROWS - 2);
	int left = row * COLUMNS + column % COLUMNS;
	int next = row * COLUMNS + (column + 1) % COLUMNS;
	float across = x - float(column);
	vec3 above = mix(push.view.panorama.table[left].xyz, push.view.panorama.table[next].xyz, across);
	left += COLUMNS;
	next += COLUMNS;
	vec3 below = mix(push.view.panorama.table[left].xyz, push.view.panorama.table[next].xyz, across);
	return mix(above, below, y - float(row));
}

// Sky and ground as a highlight mirrors them.
vec3 sky_highlight(shade_material material, shade_sky sky, vec3 n, vec3 v)
{
	float exponent = shade_exponent_from_alpha(shade_alpha_from_roughness(material.roughness));
	return material.specular *
		shade_hemisphere_radiance(reflect(-v, n).y, shade_exponent_about_r(exponent), sky.sky, sky.ground);
}

// The interpolated normal on the side of the triangle that is seen, and bent towards the viewer if it faces away, as
// rays have it (gi_surface.c).
vec3 seen_normal(vec3 n, vec3 to_camera)
{
	vec3 flat_normal = cross(dFdx(world_position), dFdy(world_position));
	if (dot(flat_normal, to_camera) < 0.0)
		flat_normal = -flat_normal;
	float along = dot(n, flat_normal);
	bool clear = abs(along) > 1e-3 * length(flat_normal); // else the derivatives' rounding would choose, pixel by pixel
	if (clear ? along < 0.0 : !gl_FrontFacing)
		n = -n;
	float lacking = 1e-3 - dot(n, to_camera);
	return lacking > 0.0 ? normalize(n + to_camera * lacking) : n;
}

// Of 32 draws' fades the pixel shows those from a threshold on, and else what gives way to them.
bool is_faded_out()
{
	uint detail = material_word >> DETAIL_MATERIAL_SHIFT;
	uint shown = detail & 31u;
	bool there = fade_threshold(uvec2(gl_FragCoord.xy)) < 2u * shown;
	return there == (detail >= 32u);
}

// A colour for each level of detail, lit from the viewer.
vec3 level_color(vec3 n, vec3 to_camera)
{
	const vec3 colors[7] = vec3[7](vec3(0.9), vec3(0.8, 0.08, 0.05), vec3(0.9, 0.35, 0.03), vec3(0.8, 0.7, 0.05),
		vec3(0.1, 0.6, 0.1), vec3(0.05, 0.25, 0.85), vec3(0.45, 0.1, 0.75));
	uint level = material_word >> DETAIL_MATERIAL_SHIFT;
	vec3 color = level == 0u ? vec3(0.25) : level == 1u ? colors[0] : colors[1u + (level - 2u) % 6u];
	return color * (0.35 + 0.65 * abs(dot(n, to_camera)));
}

void main()
{
	if (detail_kind == DETAIL_FADE && is_faded_out())
		discard;
	shade_brdf_model model = {brdf, ndf, g, f};
	Material stored = stored_material();
	shade_material material = material_here(stored);
	shade_sky sky = {push.view.sky.xyz, push.view.ground.xyz};
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	vec3 n = normalize(world_normal);
	if (both_sides)
		n = seen_normal(n, to_camera);
	vec3 radiance = from_lights(model, material, frame_here(n), to_camera);
	if (lights_panorama)
		radiance += shade_lambert(material.diffuse) * panorama_irradiance(n);
	else
		radiance += shade_surface_sky(material, sky, n);
	if (!both_sides || gl_FrontFacing)
		radiance += stored.emission_wrap.xyz;
	if (lights_gloss && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED)
		radiance += sky_highlight(material, sky, n, to_camera);
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(n, to_camera);
	if (drawn != 0 && (material_index() & 1) != drawn - 1)
		radiance = vec3(0.0);
	if (tone_map)
		radiance = shade_tonemap(radiance * push.view.exposure, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	color = vec4(radiance, 1.0);
}
