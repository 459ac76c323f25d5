// What the fragment shaders of meshes and impostors share: a surface's material, and the light that it sends to the
// viewer. Who includes it has declared `vec3 world_position`, the point that is lit, and `uint model_lights`, the word
// of the model that it is of (mesh.glsl); 0: of none.
#include "../../shading/shade_energy.h"
#include "../../shading/shade_environment.h"
#include "../../shading/shade_sh.h"
#include "../../shading/shade_surface.h"
#include "faded.glsl"
#define HDR_CONSTANT 13
#include "hdr/hdr.glsl"

// The materials that the program draws: 0 all, 1 those with an even index, 2 those with an odd one; others are black.
// 3: the one whose address is bound.
layout(constant_id = 1) const uint drawn = 0;
// The formulas, in the order of render_formula. They are compile-time constants: code of other formulas is removed.
layout(constant_id = 2) const int brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED;
layout(constant_id = 3) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 4) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 5) const int f = SHADE_F_SCHLICK;

// The kinds of light in the view's list, 1 << SHADE_LIGHT_... each, and more bits (RENDER_LIGHTS_... of
// render_internal.h). Only the code of these is left: software devices compute every branch for every pixel.
layout(constant_id = 6) const uint lights = 1u << SHADE_LIGHT_DIRECTIONAL;
const bool lights_end = (lights & 64u) != 0;       // some have a falloff that is not physical
const bool lights_gloss = (lights & 128u) != 0;    // highlights mirror sky and ground, or the harmonics
const bool lights_panorama = (lights & 256u) != 0; // its light in place of theirs
const bool lights_dark = (lights & LIGHTS_AMBIENT) == LIGHTS_DARK;
const bool lights_sh_vertex = (lights & LIGHTS_AMBIENT) == LIGHTS_SH_VERTEX;
const bool lights_sh = (lights & LIGHTS_AMBIENT) >= LIGHTS_SH_VERTEX; // and SH_PIXEL
const bool both_sides = (lights & 512u) != 0;                         // triangles are seen from behind, too
const bool lights_one = (lights & 1024u) != 0;                        // the list has one light
const bool adds_lights = (lights & 65536u) != 0;     // they are added to what has been drawn, which has all else
const bool lights_lists = (lights & 8192u) != 0;     // lights that end somewhere are found by lists
const bool lights_tiles = (lights & 262144u) != 0;   // which are those of tiles
const bool lights_indexed = (lights & 524288u) != 0; // or those of pixels
const bool lights_combined = (lights & LIGHTS_COMBINED) != 0; // models have lights of their own
const bool lights_shadows = (lights & 1073741824u) != 0;      // maps keep some from surfaces
const bool lights_counted = (lights & (1u << 24)) != 0;       // what is asked is counted, in place of its light

float counted = 0.0; // the lights that this pixel has asked

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
	return shade_material(reflectance.diffuse, reflectance.specular, clamp(roughness + added.x, 0.0, 1.0),
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

// Of the light that light_of was asked for last: 0: it has no shadow; else 2 (1 + its first map), + 1: of a cube's six;
// and 512 (1 + its place in the buffer of shadows), where there is one.
uint light_shadow = 0u;

// A light of the view's list; of what its kinds do not have nothing is loaded.
shade_light light_of(uint index)
{
	const bool has_angle = (lights & (1u << SHADE_LIGHT_SPOT)) != 0;
	const bool has_radius = (lights & (1u << SHADE_LIGHT_SPHERE | 1u << SHADE_LIGHT_DISK)) != 0;
	const bool has_sides = (lights & (1u << SHADE_LIGHT_RECTANGLE)) != 0 || lights_panorama;
	Pairs from = Pairs(push.view.lights);
	uint at = LIGHT_PAIRS * index;
	vec4 position_kind = two_pairs_at(from, at);
	vec4 direction_reach = two_pairs_at(from, at + 2u);
	vec4 intensity_inner = two_pairs_at(from, at + 4u);
	vec4 half_x_outer = vec4(0.0);
	vec4 half_y_radius = vec4(0.0);
	if (has_sides)
		half_x_outer = two_pairs_at(from, at + 6u);
	else if (has_angle)
		half_x_outer.zw = pair_at(from, at + 7u);
	if (has_sides)
		half_y_radius = two_pairs_at(from, at + 8u);
	else if (has_radius)
		half_y_radius.zw = pair_at(from, at + 9u);
	int kind = int(position_kind.w);
	light_shadow = uint(kind) >> 5;
	return shade_light(kind & 7, lights_end ? kind >> 3 & 3 : SHADE_FALLOFF_PHYSICAL, position_kind.xyz,
	                   direction_reach.xyz, intensity_inner.xyz, intensity_inner.w, half_x_outer.w, half_y_radius.w,
	                   half_x_outer.xyz, half_y_radius.xyz, direction_reach.w);
}

// MESH_GBUFFER: programs that leave the light of lights to a pass over the picture (deferred.frag), and write what that
// needs of the surface. LIT_SURFACES: such a pass.
#if defined(MESH_GBUFFER) || defined(LIT_SURFACES)
#include "deferred/gbuffer.glsl"
#endif
#ifdef MESH_GBUFFER
GBUFFER_OUTPUTS
GbufferSurface gbuffer = gbuffer_none(); // of this pixel
#endif

// True if shadows fall on the surface.
#ifdef LIT_SURFACES
bool receives = true; // until the surface has been read
#else
bool receives = (material_word & MATERIAL_UNSHADOWED) == 0u;
#endif

// LIT_LAYERS: programs of surfaces with layers.
#ifdef LIT_LAYERS
#include "layers.glsl"
#endif

// LIT_APART: the pass of PREPASS and PRELIGHT that adds up light before surfaces are drawn (deferred/deferred.frag).
#ifdef LIT_APART
#include "deferred/apart.glsl"
#endif

// Programs that add up lights by themselves.
#if !defined(MESH_GBUFFER) && !defined(LIT_IMAGES) && !defined(MESH_CHANNEL) && !defined(MESH_SEEN) &&                 \
	!defined(MAPS_DEPTH) && !defined(LIT_ALONE)
#define LIT_SHADOWS
#include "shadow/shadow.glsl"
#endif

// What a light sends to v. Each kind has code of its own, so that nothing is left of kinds that the list has not.
vec3 from_light(shade_light light, shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	if (lights_counted) {
		counted += 1.0;
		return vec3(0.0);
	}
	shade_sun seen = {vec3(0.0, 0.0, 1.0), vec3(0.0)};
	vec3 spread = vec3(0.0);
#define FROM_LIGHT(of_kind, sized)                                                                                     \
	if ((lights & (1u << of_kind)) != 0 && light.kind == of_kind) {                                                    \
		light.kind = of_kind;                                                                                          \
		seen = shade_light_at(light, world_position);                                                                  \
		if (sized) {                                                                                                   \
			spread = shade_area_irradiance(light, world_position, frame.n);                                            \
			material.roughness = shade_roughness_under(material.roughness, shade_light_share(light, world_position));  \
		}                                                                                                              \
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
#ifdef LIT_SHADOWS
	if (lights_shadows && light_shadow != 0u && receives) {
		vec3 open = shadow_factor(light.kind == SHADE_LIGHT_DIRECTIONAL, light.position, seen.direction, frame.n);
		seen.irradiance *= open;
		spread *= open;
	}
#endif
#ifdef LIT_APART
	return light_apart(material, frame, seen, lamp || shade_light_is_sized(light.kind), spread, v);
#elif defined(LIT_LAYERS)
	bool sized = lamp || shade_light_is_sized(light.kind);
	return layers_lit(shade_surface_lit(model, material, frame, seen, sized, spread, v), material, frame.n, seen, v);
#else
	return shade_surface_lit(model, material, frame, seen, lamp || shade_light_is_sized(light.kind), spread, v);
#endif
}

#ifndef LIT_IMAGES
#include "deferred/lists.glsl"

// The pixel in which the point lies that is lit. Where a triangle covers a part of a pixel's samples that may be the
// one beside it, as devices round.
vec2 pixel_here()
{
	if (samples == 1u)
		return gl_FragCoord.xy;
	vec2 size = 2.0 * vec2(push.view.rest.half_width, push.view.rest.half_height);
	vec4 clip = push.view.rest.view_projection * vec4(world_position, 1.0);
	vec2 place = clip.xy / clip.w - push.view.rest.jitter; // lists are as without
	return clamp((place * 0.5 + 0.5) * size, vec2(0.0), size - 1.0);
}

// Where the list of lights for the point that is lit begins and ends, among the words of the lists.
uvec2 list_here(LightLists lists)
{
	if (!lights_tiles)
		return list_of_cell(lists, pixel_here(), world_position);
	uvec2 tiles = uvec2(push.view.grid.x & 0xffffu, push.view.grid.x >> 16);
	uvec2 at = uvec2(gl_FragCoord.xy) >> (push.view.grid.y & 0xffu);
	uint tile = at.x + tiles.x * at.y;
	return uvec2(lists.words[tile], lists.words[tile + tiles.x * tiles.y]);
}

const uint NO_LIGHT = 0xffffffffu;

// The model's record, of so many parts: see mesh.glsl.
uvec4 model_part(uint part)
{
	return ModelLights(push.view.lists).parts[(model_lights & 0x7fffffffu) + part];
}

// What the model's own lights send to v.
vec3 from_own_lights(shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	uvec4 own = model_part(0u);
	vec4 shares = uintBitsToFloat(model_part(1u));
	vec3 radiance = vec3(0.0);
	for (uint i = 0u; i < 4u && own[i] != NO_LIGHT; i++)
		radiance += shares[i] * from_light(light_of(own[i]), model, material, frame, v);
	return radiance;
}

// What the model's other lights, as their sum has them, send to a surface that reflects evenly, over pi.
vec3 from_others(vec3 n)
{
	if (!lights_combined || (model_lights >> 31) == 0u)
		return vec3(0.0);
	shade_sh y = shade_sh_basis(n);
	vec4 low = vec4(y.c[0], y.c[1], y.c[2], y.c[3]), high = vec4(y.c[4], y.c[5], y.c[6], y.c[7]);
	vec3 irradiance = uintBitsToFloat(model_part(8u)).xyz * y.c[8];
	for (uint c = 0u; c < 3u; c++)
		irradiance[c] +=
			dot(uintBitsToFloat(model_part(2u + 2u * c)), low) + dot(uintBitsToFloat(model_part(3u + 2u * c)), high);
	return shade_lambert(vec3(1.0)) * max(irradiance, 0.0);
}

// What the view's lights send to v.
vec3 from_lights(shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	if (lights_one) // with a loop, even of one turn, frames take software devices some 3 % longer
		return from_light(light_of(0), model, material, frame, v);
	if (lights_combined && model_lights != 0u)
		return from_own_lights(model, material, frame, v);
	vec3 radiance = vec3(0.0);
	for (uint i = 0; (lights & 63u) != 0 && i < push.view.light_count; i++)
		radiance += from_light(light_of(i), model, material, frame, v);
	if (lights_lists) {
		LightLists lists = push.view.lists;
		uvec4 indices = uvec4(LIGHT_INDEX_MORE);
		if (lights_indexed) {
			uint width = uint(2.0 * push.view.rest.half_width);
			LightIndices pixels = LightIndices(lists);
			lists = pixels.lists;
			indices = pixels.pixels[uint(gl_FragCoord.x) + width * uint(gl_FragCoord.y)];
		}
		bool listed = !lights_indexed || indices.x == LIGHT_INDEX_MORE;
		uvec2 list = listed ? list_here(lists) : uvec2(0u, 8u);
		for (uint i = list.x; i < list.y; i++) {
			uint id = listed ? lists.words[i] : indices[i / 2u] >> (i & 1u) * 16u & 0xffffu;
			if (!listed && id == LIGHT_INDEX_NONE)
				break;
			radiance += from_light(light_of(push.view.light_count + id), model, material, frame, v);
		}
	}
	return radiance;
}
#endif

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

// The sum of the harmonics with these weights, which may be negative: light is not.
vec3 harmonics_sum(shade_sh weights)
{
	vec3 sum = vec3(0.0);
	for (int i = 0; i < 9; i++)
		sum += push.view.rest.harmonics[i].xyz * weights.c[i];
	return max(sum, 0.0);
}

// Irradiance of the harmonics at a normal.
vec3 harmonics_irradiance(vec3 n)
{
	return harmonics_sum(shade_sh_convolve_cosine(shade_sh_basis(n)));
}

// LIT_VERTEX: programs of meshes, which have irradiance by vertex.
#ifdef LIT_VERTEX
// Of the side that n is on.
vec3 vertex_irradiance(vec3 n)
{
	bool behind = both_sides && dot(n, world_normal) < 0.0;
	return max(vertex_even + (behind ? -vertex_odd : vertex_odd), 0.0);
}
#endif

// The light of the surroundings that a surface with this diffuse reflectance sends on evenly.
vec3 even_radiance(vec3 diffuse, vec3 n)
{
	if (lights_dark)
		return vec3(0.0);
	if (lights_sh)
		return shade_lambert(diffuse) * harmonics_irradiance(n);
	if (lights_panorama)
		return shade_lambert(diffuse) * panorama_irradiance(n);
	shade_sky sky = {push.view.rest.sky.xyz, push.view.rest.ground.xyz};
	return shade_surface_sky(shade_material(diffuse, vec3(0.0), 1.0, 0.0, 0.0), sky, n);
}

// Of the surface itself, whose vertices may have it.
vec3 own_even_radiance(vec3 diffuse, vec3 n)
{
#ifdef LIT_VERTEX
	if (lights_sh_vertex)
		return shade_lambert(diffuse) * vertex_irradiance(n);
#endif
	return even_radiance(diffuse, n);
}

// Sky and ground, or the harmonics, as a lobe of this roughness about a unit direction has them on average. Bands are
// limited so that no light is negative.
vec3 sky_mirrored(vec3 toward, float roughness)
{
	float exponent = shade_exponent_about_r(shade_exponent_from_alpha(shade_alpha_from_roughness(roughness)));
	if (lights_sh) {
		vec3 bands = min(shade_sh_lobe(exponent), push.view.rest.mirrored.xyz);
		return harmonics_sum(shade_sh_convolve(shade_sh_basis(toward), bands));
	}
	return shade_hemisphere_radiance(toward.y, exponent, push.view.rest.sky.xyz, push.view.rest.ground.xyz);
}

// Sky and ground as a highlight mirrors them.
vec3 sky_highlight(shade_material material, vec3 n, vec3 v)
{
	return material.specular * sky_mirrored(reflect(-v, n), material.roughness);
}

// LIT_IMAGES: programs of surfaces whose lights have been added up before.
#ifdef LIT_IMAGES
#include "deferred/images.glsl"
#endif

// What its highlight mirrors of the surroundings.
vec3 own_highlight(shade_material material, vec3 n, vec3 to_camera)
{
#ifdef LIT_GLOSS
	return panorama_highlight(material, n, to_camera);
#else
	bool mirrors = lights_gloss && !lights_panorama && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED;
	return mirrors ? sky_highlight(material, n, to_camera) : vec3(0.0);
#endif
}

// LIT_TERMS: programs that draw the buffer of shadows: of up to four lights the share that arrives.
#ifdef LIT_TERMS
vec4 terms = vec4(1.0); // of this pixel

vec3 toward_light(shade_light light)
{
#define TOWARD_LIGHT(of_kind)                                                                                          \
	if ((lights & (1u << of_kind)) != 0 && light.kind == of_kind) {                                                    \
		light.kind = of_kind;                                                                                          \
		return shade_light_at(light, world_position).direction;                                                        \
	}
	TOWARD_LIGHT(SHADE_LIGHT_POINT)
	TOWARD_LIGHT(SHADE_LIGHT_SPOT)
	TOWARD_LIGHT(SHADE_LIGHT_SPHERE)
	TOWARD_LIGHT(SHADE_LIGHT_DISK)
	TOWARD_LIGHT(SHADE_LIGHT_RECTANGLE)
#undef TOWARD_LIGHT
	return -light.direction;
}

void terms_write(vec3 n)
{
	for (uint i = 0u; i < push.view.light_count && receives; i++) {
		shade_light light = light_of(ModelWords(push.view.lists).words[i]);
		terms[i] = shadow_factor(light.kind == SHADE_LIGHT_DIRECTIONAL, light.position, toward_light(light), n).x;
	}
}

// As the buffer has them: dark shares in finer steps, like the display's.
vec4 terms_color()
{
	return sqrt(terms);
}
#endif

// LIT_AROUND: programs that may draw what surfaces send on of the surroundings' light apart (velocity/beside.glsl).
#ifdef LIT_AROUND
const bool lights_around = (beside & BESIDE_AROUND) != 0u;

// The share of the surroundings' light that own_highlight mirrors.
vec3 own_mirror(shade_material material, vec3 n, vec3 to_camera)
{
#ifdef LIT_GLOSS
	return gloss_reflectance(material, gloss_shares(n, to_camera, material.roughness));
#else
	bool mirrors = lights_gloss && !lights_panorama && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED;
	return mirrors ? material.specular : vec3(0.0);
#endif
}
#endif

// What a surface with the unit normal n sends to the viewer. open: the share of the surroundings' even light that
// arrives.
vec3 lit_radiance_open(shade_material material, vec3 emission, float open, vec3 n, vec3 to_camera)
{
	shade_brdf_model model = {brdf, ndf, g, f};
#ifdef LIT_TERMS
	terms_write(frame_here(n).n);
	return vec3(0.0);
#else
#ifdef MESH_GBUFFER
	gbuffer = GbufferSurface(material, n, receives);
	material = shade_surface_seen(model, material, dot(n, to_camera));
	vec3 radiance = vec3(0.0);
#else
	material = shade_surface_seen(model, material, dot(n, to_camera));
#ifdef LIT_IMAGES
	vec3 radiance = from_images(material, dot(n, to_camera));
#else
	vec3 radiance = from_lights(model, material, frame_here(n), to_camera) + material.diffuse * from_others(n);
#endif
#endif
	if (adds_lights)
		return radiance;
#ifdef LIT_AROUND
	if (lights_around) {
		around = Around(own_even_radiance(material.diffuse, n) * open, own_highlight(material, n, to_camera),
			own_mirror(material, n, to_camera), n, material.roughness);
		return radiance + emission;
	}
#endif
	radiance += own_even_radiance(material.diffuse, n) * open;
	radiance += emission;
	radiance += own_highlight(material, n, to_camera);
	return radiance;
#endif
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

// The material's index of the word into which the vertex shader packs it, how the draw fades, and whether it receives
// shadows.
uint material_of_word(uint word)
{
	bool more = detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW || lights_shadows;
	return more ? word & MATERIAL_INDEX : word;
}

// A colour for each level of detail, lit from the viewer.
vec3 level_color(uint word, vec3 n, vec3 to_camera)
{
	const vec3 colors[7] = vec3[7](vec3(0.9), vec3(0.8, 0.08, 0.05), vec3(0.9, 0.35, 0.03), vec3(0.8, 0.7, 0.05),
	                               vec3(0.1, 0.6, 0.1), vec3(0.05, 0.25, 0.85), vec3(0.45, 0.1, 0.75));
	uint level = (word & ~MATERIAL_UNSHADOWED) >> DETAIL_MATERIAL_SHIFT;
	vec3 color = level == 0u ? vec3(0.25) : level == 1u ? colors[0] : colors[1u + (level - 2u) % 6u];
	return adds_lights ? vec3(0.0) : color * (0.35 + 0.65 * abs(dot(n, to_camera)));
}

// What is added up where lights are counted: these, and that the pixel was lit once more.
vec4 counted_color()
{
	return vec4(counted, 1.0, 0.0, 0.0);
}

// A draw's radiance as the picture has it. material: its index.
vec4 picture_color(vec3 radiance, uint material)
{
	bool black = (drawn == 1u || drawn == 2u) && (material & 1) != drawn - 1;
#ifdef LIT_TERMS
	return terms_color();
#endif
#ifdef LIT_AROUND
	if (lights_around)
		around_write(black || detail_kind == DETAIL_SHOW);
#endif
#ifdef MESH_GBUFFER
	if (black || detail_kind == DETAIL_SHOW)
		gbuffer = gbuffer_none();
#ifdef GBUFFER_SLIM
	return gbuffer_slim(gbuffer);
#else
	gbuffer_write(gbuffer);
	if (lights_counted)
		return vec4(0.0, 0.0, 0.0, 1.0);
#endif
#elif defined(LIT_IMAGES)
	if (lights_counted)
		return vec4(texelFetch(light_image, ivec2(gl_FragCoord.xy), 0).xy, 0.0, 0.0);
#else
	if (lights_counted)
		return counted_color();
#endif
	if (hdr != HDR_HALF)
		return hdr_encoded(black ? vec3(0.0) : radiance * push.view.rest.exposure);
	return vec4(black ? vec3(0.0) : radiance, adds_lights ? 0.0 : 1.0);
}
