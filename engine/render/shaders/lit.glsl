// What the fragment shaders of meshes and impostors share: a surface's material, and the light that it sends to the
// viewer. Who includes it has declared `vec3 world_position`, the point that is lit.
#include "faded.glsl"
#include "../../shading/shade_energy.h"
#include "../../shading/shade_environment.h"
#include "../../shading/shade_surface.h"

// The materials that the program draws: 0 all, 1 those with an even index, 2 those with an odd one; others are black.
// 3: the one whose address is bound.
layout(constant_id = 1) const uint drawn = 0;
// The formulas, in the order of render_formula. They are compile-time constants: code of other formulas is removed.
layout(constant_id = 2) const int brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED;
layout(constant_id = 3) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 4) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 5) const int f = SHADE_F_SCHLICK;

// The kinds of light in the view's list, 1 << SHADE_LIGHT_... each, and five more bits (RENDER_LIGHTS_... of
// render_internal.h). Only the code of these is left: software devices compute every branch for every pixel.
layout(constant_id = 6) const uint lights = 1u << SHADE_LIGHT_DIRECTIONAL;
const bool lights_end = (lights & 64u) != 0;    // some have a falloff that is not physical
const bool lights_gloss = (lights & 128u) != 0; // highlights mirror sky and ground
const bool lights_panorama = (lights & 256u) != 0; // its light in place of theirs
const bool both_sides = (lights & 512u) != 0;   // triangles are seen from behind, too
const bool lights_one = (lights & 1024u) != 0;  // the list has one light
const bool adds_lights = (lights & 65536u) != 0; // they are added to what has been drawn, which has all else
const bool lights_lists = (lights & 8192u) != 0; // lights that end somewhere are found by lists

Material stored_material(uint index)
{
#ifdef MAPS_HANDED_ON
	return Material(vec4(0.0), vec4(vec3(0.0), record_rest.y), vec4(vec3(0.0), record_rest.z), uvec4(0u));
#endif
	return push.materials.materials[drawn == 3u ? 0u : index];
}

// A material with these reflectances and roughness plus the view's additions.
shade_material material_with(Material m, vec3 diffuse, vec3 specular, float roughness)
{
	vec4 added = push.view.added;
	shade_reflectance reflectance = {diffuse, specular};
	if (added.w != 0.0)
		reflectance = shade_limit_to_one(diffuse, reflectance.specular + added.w);
	return shade_material(reflectance.diffuse, reflectance.specular,
		clamp(roughness + added.x, 0.0, 1.0),
		clamp(m.specular_anisotropy.w + added.y, -1.0, 1.0),
		clamp(m.emission_wrap.w + added.z, 0.0, 1.0));
}

// The same with the material's own specular reflectance.
shade_material material_here(Material m, vec3 diffuse, float roughness)
{
	return material_with(m, diffuse, m.specular_anisotropy.xyz, roughness);
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

// MESH_GBUFFER: programs that leave the light of lights to a pass over the picture (deferred.frag), and write what that
// needs of the surface.
#ifdef MESH_GBUFFER
#include "deferred/gbuffer.glsl"
GBUFFER_OUTPUTS
GbufferSurface gbuffer = gbuffer_none(); // of this pixel
#endif

// LIT_LAYERS: programs of surfaces with layers.
#ifdef LIT_LAYERS
#include "layers.glsl"
#endif

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
#ifdef LIT_LAYERS
	bool sized = lamp || shade_light_is_sized(light.kind);
	return layers_lit(shade_surface_lit(model, material, frame, seen, sized, spread, v), material, frame.n, seen, v);
#else
	return shade_surface_lit(model, material, frame, seen, lamp || shade_light_is_sized(light.kind), spread, v);
#endif
}

// Where the list of the cell that has the point that is lit begins and ends, among the words of the lists.
uvec2 list_here()
{
	uvec2 grid = push.view.grid, tiles = uvec2(grid.x & 0xffffu, grid.x >> 16);
	uint slices = grid.y >> 8;
	uvec2 tile = uvec2(gl_FragCoord.xy) >> (grid.y & 0xffu);
	vec4 plane = push.view.lists.depth_plane;
	vec4 scale = push.view.lists.slice;
	float depth = max(dot(plane.xyz, world_position) + plane.w, 1e-30);
	uint slice = min(uint(max(log2(depth) * scale.x + scale.y, 0.0)), slices - 1u);
	uint cell = tile.x + tiles.x * (tile.y + tiles.y * slice);
	uint first = tiles.x * tiles.y * slices + 1u;
	return first + uvec2(push.view.lists.words[cell], push.view.lists.words[cell + 1u]);
}

// What the view's lights send to v.
vec3 from_lights(shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	if (lights_one) // with a loop, even of one turn, frames take software devices some 3 % longer
		return from_light(light_of(0), model, material, frame, v);
	vec3 radiance = vec3(0.0);
	for (uint i = 0; (lights & 63u) != 0 && i < push.view.light_count; i++)
		radiance += from_light(light_of(i), model, material, frame, v);
	if (lights_lists) {
		uvec2 list = list_here();
		for (uint i = list.x; i < list.y; i++)
			radiance +=
				from_light(light_of(push.view.light_count + push.view.lists.words[i]), model, material, frame, v);
	}
	return radiance;
}

// A direction of the world in the panorama's own axes, turned back by its rotation.
vec3 panorama_own(vec3 d)
{
	vec2 turn = push.view.turn;
	return vec3(turn.y * d.x - turn.x * d.z, d.y, turn.x * d.x + turn.y * d.z);
}

const int PANORAMA_COLUMNS = 256; // as RENDER_PANORAMA_COLUMNS and _ROWS
const int PANORAMA_ROWS = 129;

// LIT_GLOSS: programs whose highlights mirror the panorama; they alone have its images. Software devices read texels at
// once, and a table by its address lane by lane.
#ifdef LIT_GLOSS
layout(set = 0, binding = 0) uniform samplerCube panorama_cube; // without its lamps
layout(set = 0, binding = 1) uniform sampler2D gloss_table;
layout(set = 0, binding = 2) uniform sampler2D panorama_light;

vec3 panorama_entry(int column, int row)
{
	return texelFetch(panorama_light, ivec2(column, row), 0).xyz;
}
#else
vec3 panorama_entry(int column, int row)
{
	return push.view.panorama.table[row * PANORAMA_COLUMNS + column].xyz;
}
#endif

// The panorama's irradiance at a normal, between four of the table; its lamps are lights of the list.
vec3 panorama_irradiance(vec3 n)
{
	vec3 own = panorama_own(n);
	float right = own.x;
	float back = own.z;
	float longitude = right == 0.0 && back == 0.0 ? 0.0 : atan(right, -back);
	float x = clamp(longitude / (2.0 * SHADE_PI) + 0.5, 0.0, 1.0) * float(PANORAMA_COLUMNS);
	float y = atan(length(vec2(right, back)), n.y) / SHADE_PI * float(PANORAMA_ROWS - 1);
	int column = int(floor(x));
	int row = clamp(int(floor(y)), 0, PANORAMA_ROWS - 2);
	int left = column % PANORAMA_COLUMNS;
	int next = (column + 1) % PANORAMA_COLUMNS;
	float across = x - float(column);
	vec3 above = mix(panorama_entry(left, row), panorama_entry(next, row), across);
	vec3 below = mix(panorama_entry(left, row + 1), panorama_entry(next, row + 1), across);
	return mix(above, below, y - float(row));
}

#ifdef LIT_GLOSS
// A place of the table: what a lobe reflects of a white environment is f0 x + y.
vec2 gloss_shares(vec3 n, vec3 v, float roughness)
{
	const float SIDE = 64.0; // as RENDER_PANORAMA_DFG
	return textureLod(gloss_table, shade_dfg_texel(shade_dfg_place(dot(n, v), roughness), SIDE), 0.0).xy;
}

// The panorama's light that a lobe of this roughness has on average whose middle is toward.
vec3 gloss_light(vec3 toward, float roughness)
{
	const float MIPS = 6.0; // as RENDER_PANORAMA_MIPS
	return textureLod(panorama_cube, panorama_own(toward), shade_environment_mip(roughness, MIPS)).xyz;
}

// That of a highlight's lobe. Other models than microfacets have lobes that stay as round as the cube's.
vec3 gloss_mirrored(vec3 n, vec3 v, float roughness)
{
	if (brdf != SHADE_BRDF_MICROFACET)
		return gloss_light(shade_environment_direction(n, v, roughness), roughness);
	shade_environment_look look = shade_environment_look_of(n, v, roughness);
	return gloss_light(look.toward, look.roughness);
}

// What share of that light a highlight sends on.
vec3 gloss_reflectance(shade_material material, vec2 dfg)
{
	bool fresnel = brdf == SHADE_BRDF_MICROFACET && f != SHADE_F_NONE;
	return fresnel ? material.specular * dfg.x + dfg.y : material.specular * (dfg.x + dfg.y);
}

// The panorama as a highlight mirrors it: the cube and the table of GGX at the material's roughness, for other models
// an approximation. What has no Fresnel term has the reflectance f0 at every angle. Light that facets hand on to others
// is left out, as lamps and rays have it.
vec3 panorama_highlight(shade_material material, vec3 n, vec3 v)
{
	vec2 dfg = gloss_shares(n, v, material.roughness);
	return gloss_mirrored(n, v, material.roughness) * gloss_reflectance(material, dfg);
}
#endif

// Sky and ground as a highlight mirrors them.
vec3 sky_highlight(shade_material material, shade_sky sky, vec3 n, vec3 v)
{
	float exponent = shade_exponent_from_alpha(shade_alpha_from_roughness(material.roughness));
	return material.specular *
		shade_hemisphere_radiance(reflect(-v, n).y, shade_exponent_about_r(exponent), sky.sky, sky.ground);
}

// What a surface with the unit normal n sends to the viewer. open: the share of the surroundings' even light that
// arrives.
vec3 lit_radiance_open(shade_material material, vec3 emission, float open, vec3 n, vec3 to_camera)
{
	shade_brdf_model model = {brdf, ndf, g, f};
	shade_sky sky = {push.view.rest.sky.xyz, push.view.rest.ground.xyz};
#ifdef MESH_GBUFFER
	gbuffer = GbufferSurface(material, n);
	material = shade_surface_seen(model, material, dot(n, to_camera));
	vec3 radiance = vec3(0.0);
#else
	material = shade_surface_seen(model, material, dot(n, to_camera));
	vec3 radiance = from_lights(model, material, frame_here(n), to_camera);
#endif
	if (adds_lights)
		return radiance;
	if (lights_panorama)
		radiance += shade_lambert(material.diffuse) * panorama_irradiance(n) * open;
	else
		radiance += shade_surface_sky(material, sky, n) * open;
	radiance += emission;
#ifdef LIT_GLOSS
	radiance += panorama_highlight(material, n, to_camera);
#else
	if (lights_gloss && !lights_panorama && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED)
		radiance += sky_highlight(material, sky, n, to_camera);
#endif
	return radiance;
}

#ifdef LIT_LAYERS
#include "layers_around.glsl"
#endif

vec3 lit_radiance(shade_material material, vec3 emission, vec3 n, vec3 to_camera)
{
	return lit_radiance_open(material, emission, 1.0, n, to_camera);
}

// The normal bent towards the viewer if it faces away, as rays have it (gi_surface.c).
vec3 bent_normal(vec3 n, vec3 to_camera)
{
	float lacking = 1e-3 - dot(n, to_camera);
	return lacking > 0.0 ? normalize(n + to_camera * lacking) : n;
}

// The normal of a map, turned so far that the mirrored viewer is above the triangle, as rays have it (gi_surface.c): a
// smooth surface would mirror what is behind it. flat_normal: the triangle's, of any length, on any side.
vec3 lifted_normal(vec3 n, vec3 flat_normal, vec3 to_camera)
{
	float square = dot(flat_normal, flat_normal), side = dot(flat_normal, to_camera);
	vec3 mirrored = reflect(-to_camera, n), up = flat_normal * (sign(side) * inversesqrt(max(square, 1e-30)));
	float lacking = 1e-3 - dot(mirrored, up);
	return lacking > 0.0 && square > 0.0 ? normalize(normalize(mirrored + up * lacking) + to_camera) : n;
}

// True if the interpolated normal n is on the other side than the one of the triangle that is seen. flat_normal: the
// triangle's, on any side.
bool is_turned_over(vec3 n, vec3 flat_normal, vec3 to_camera)
{
	if (dot(flat_normal, to_camera) < 0.0)
		flat_normal = -flat_normal;
	float along = dot(n, flat_normal);
	bool clear = abs(along) > 1e-3 * length(flat_normal); // else the derivatives' rounding would choose, pixel by pixel
	return clear ? along < 0.0 : !gl_FrontFacing;
}

// The material's index and how the draw fades, which the vertex shader packs into one word.
uint material_of_word(uint word)
{
	bool both = detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW;
	return both ? word & ((1u << DETAIL_MATERIAL_SHIFT) - 1u) : word;
}

// A colour for each level of detail, lit from the viewer.
vec3 level_color(uint word, vec3 n, vec3 to_camera)
{
	const vec3 colors[7] = vec3[7](vec3(0.9), vec3(0.8, 0.08, 0.05), vec3(0.9, 0.35, 0.03), vec3(0.8, 0.7, 0.05),
		vec3(0.1, 0.6, 0.1), vec3(0.05, 0.25, 0.85), vec3(0.45, 0.1, 0.75));
	uint level = word >> DETAIL_MATERIAL_SHIFT;
	vec3 color = level == 0u ? vec3(0.25) : level == 1u ? colors[0] : colors[1u + (level - 2u) % 6u];
	return adds_lights ? vec3(0.0) : color * (0.35 + 0.65 * abs(dot(n, to_camera)));
}

// A draw's radiance as the picture has it. material: its index.
vec4 picture_color(vec3 radiance, uint material)
{
	bool black = (drawn == 1u || drawn == 2u) && (material & 1) != drawn - 1;
#ifdef MESH_GBUFFER
	if (black || detail_kind == DETAIL_SHOW)
		gbuffer = gbuffer_none();
	gbuffer_write(gbuffer);
#endif
	return vec4(black ? vec3(0.0) : radiance, adds_lights ? 0.0 : 1.0);
}
