// What images hold of the surface that each pixel shows, for passes over the picture that light it
// (device/render_images.h). Wide: its normal, octahedral, anisotropy and wrap; diffuse and roughness; specular.
// In 8 bits: depth in 16, the normal's x and y as the viewer sees it; diffuse and roughness; specular and anisotropy.
// GBUFFER_SLIM: of PREPASS and PRELIGHT, whose surfaces are drawn again: the first image alone; where it is in 16 bits
// roughness in the place of anisotropy. Where lights have shadows, also whether they fall on the surface: wide beside
// specular; in 8 bits the last one of depth; of the slim one in 16 bits above wrap.
#include "../../../shading/shade_impostor.h"

struct GbufferSurface {
	shade_material material; // as it stands, not as it is seen (shade_surface_seen)
	vec3 normal;             // unit
	bool receives;           // shadows
};

const bool gbuffer_narrow = (lights & 32768u) != 0; // RENDER_LIGHTS_GBUFFER8
const bool gbuffer_shadows = (lights & (1u << 30)) != 0; // RENDER_LIGHTS_SHADOWS

// Axes across a pixel's ray, whose unit direction is ahead: to the right of the picture, and down.
struct GbufferAxes {
	vec3 right, down;
};

// The unit direction of the ray that shows a point; of a parallel view the same everywhere: depth falls along it.
vec3 gbuffer_ahead(vec3 place)
{
	mat4 m = push.view.rest.view_projection;
	vec3 w = vec3(m[0].w, m[1].w, m[2].w);
	return normalize(dot(w, w) > 0.0 ? place - push.view.camera_position.xyz : -vec3(m[0].z, m[1].z, m[2].z));
}

GbufferAxes gbuffer_axes(vec3 ahead)
{
	mat4 m = push.view.rest.view_projection;
	vec3 right = vec3(m[0].x, m[1].x, m[2].x);
	right /= max(max(abs(right.x), abs(right.y)), max(abs(right.z), 1e-30)); // whose squares are finite
	right = normalize(right - ahead * dot(right, ahead));
	return GbufferAxes(right, cross(ahead, right));
}

// A normal's x and y on these, 0 .. 1; its z, towards the viewer, is what is left of 1. On the camera's own axes z
// could be below 0, at the silhouettes of what is beside the middle of the picture.
vec2 gbuffer_seen(vec3 n, vec3 ahead)
{
	GbufferAxes axes = gbuffer_axes(ahead);
	vec2 xy = vec2(dot(n, axes.right), dot(n, axes.down));
	if (dot(n, ahead) > 0.0) // of a coarse mesh, between its vertices: bent until it is at the silhouette
		xy = normalize(xy);
	return xy * 0.5 + 0.5;
}

vec3 gbuffer_unseen(vec2 seen, vec3 ahead)
{
	GbufferAxes axes = gbuffer_axes(ahead);
	vec2 xy = seen * 2.0 - 1.0;
	float z = sqrt(max(1.0 - dot(xy, xy), 0.0));
	return normalize(axes.right * xy.x + axes.down * xy.y - ahead * z);
}

// The w of a point in clip space: its depth along the view, times what the view's matrix scales it by; in parallel
// views the same everywhere, so that there depth alone tells the place.
float gbuffer_w(vec3 place)
{
	mat4 m = push.view.rest.view_projection;
	return m[0].w * place.x + m[1].w * place.y + m[2].w * place.z + m[3].w;
}

// A w as two numbers of 8 bits, and back: on a logarithmic scale, by steps of 2.5e-4 of it, from 1e-7 of the far end;
// with shadows of 5e-4, and the last bit is set on a surface that receives none.
const float GBUFFER_OCTAVES = 23.253497; // log2(1e7)
const float GBUFFER_FAR = gbuffer_shadows ? 32767.0 : 65535.0;

vec2 gbuffer_depth_codes(float w, bool receives)
{
	float octaves = log2(max(w / push.view.rest.far, 1e-30));
	float code = floor(clamp(1.0 + octaves / GBUFFER_OCTAVES, 0.0, 1.0) * GBUFFER_FAR + 0.5);
	code = gbuffer_shadows ? 2.0 * code + (receives ? 0.0 : 1.0) : code;
	float high = floor(code / 256.0);
	return vec2(high, code - 256.0 * high) / 255.0;
}

float gbuffer_depth(vec2 codes)
{
	vec2 code = floor(codes * 255.0 + 0.5);
	float both = code.x * 256.0 + code.y, share = (gbuffer_shadows ? floor(both * 0.5) : both) / GBUFFER_FAR;
	return share == 1.0 ? push.view.rest.far : exp2((share - 1.0) * GBUFFER_OCTAVES) * push.view.rest.far;
}

bool gbuffer_receives(vec2 codes)
{
	return !gbuffer_shadows || mod(floor(codes.y * 255.0 + 0.5), 2.0) < 0.5;
}

// What reflects nothing.
GbufferSurface gbuffer_none()
{
	return GbufferSurface(shade_material(vec3(0.0), vec3(0.0), 1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), true);
}

#ifdef GBUFFER_SLIM
#define GBUFFER_OUTPUTS
// With shadows, of 16 bits: wrap 1; and what is added where the surface receives none.
const float GBUFFER_WRAP = 32767.0 / 65535.0, GBUFFER_REFUSES = 32768.0 / 65535.0;

vec4 gbuffer_slim(GbufferSurface surface)
{
	if (gbuffer_narrow)
		return vec4(gbuffer_depth_codes(gbuffer_w(world_position), surface.receives),
			gbuffer_seen(surface.normal, gbuffer_ahead(world_position)));
	float wrap = surface.material.wrap;
	wrap = gbuffer_shadows ? GBUFFER_WRAP * wrap + (surface.receives ? 0.0 : GBUFFER_REFUSES) : wrap;
	return vec4(shade_octahedral_from_direction(surface.normal) * 0.5 + 0.5, surface.material.roughness, wrap);
}

GbufferSurface gbuffer_of_slim(vec4 slim, vec3 ahead)
{
	if (gbuffer_narrow)
		return GbufferSurface(shade_material(vec3(1.0), vec3(1.0), 0.0, 0.0, 0.0), gbuffer_unseen(slim.zw, ahead),
			gbuffer_receives(slim.xy));
	bool receives = !gbuffer_shadows || slim.w < 0.5;
	float wrap = gbuffer_shadows ? (slim.w - (receives ? 0.0 : GBUFFER_REFUSES)) / GBUFFER_WRAP : slim.w;
	return GbufferSurface(shade_material(vec3(1.0), vec3(1.0), slim.z, 0.0, clamp(wrap, 0.0, 1.0)),
		shade_direction_from_octahedral(slim.xy * 2.0 - 1.0), receives);
}
#else
// Behind the radiance.
#define GBUFFER_OUTPUTS \
	layout(location = 1) out vec4 gbuffer_normal; \
	layout(location = 2) out vec4 gbuffer_diffuse; \
	layout(location = 3) out vec4 gbuffer_specular; \
	void gbuffer_write(GbufferSurface surface) \
	{ \
		shade_material m = surface.material; \
		float turned = m.anisotropy * 0.5 + 0.5; \
		gbuffer_diffuse = vec4(m.diffuse, m.roughness); \
		gbuffer_specular = vec4(m.specular, gbuffer_narrow ? turned : surface.receives ? 1.0 : 0.0); \
		gbuffer_normal = vec4(shade_octahedral_from_direction(surface.normal) * 0.5 + 0.5, turned, m.wrap); \
		if (gbuffer_narrow) { \
			vec3 ahead = gbuffer_ahead(world_position); \
			gbuffer_normal = \
				vec4(gbuffer_depth_codes(gbuffer_w(world_position), surface.receives), \
					gbuffer_seen(surface.normal, ahead)); \
		} \
	}
#endif

// ahead: the unit direction of the pixel's ray.
GbufferSurface gbuffer_surface(vec4 normal, vec4 diffuse, vec4 specular, vec3 ahead)
{
	if (gbuffer_narrow)
		return GbufferSurface(shade_material(diffuse.xyz, specular.xyz, diffuse.w, specular.w * 2.0 - 1.0, 0.0),
			gbuffer_unseen(normal.zw, ahead), gbuffer_receives(normal.xy));
	vec3 place = normal.xyz * 2.0 - 1.0;
	return GbufferSurface(shade_material(diffuse.xyz, specular.xyz, diffuse.w, place.z, normal.w),
		shade_direction_from_octahedral(place.xy), specular.w > 0.5);
}
