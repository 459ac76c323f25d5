#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require

const int WIDTH = 64; // of the map, as STILB_SCENE_BACKDROP_WIDTH and _HEIGHT
const int HEIGHT = 32;
const int SIDE = 64; // of the floor's cells, as STILB_SCENE_FLOOR_SIDE
const float REACH = 2.0; // as STILB_SCENE_FLOOR_REACH
const float SHADOW = 0.8; // how dark the floor is where nothing reaches it: some light always does

// As backdrop_data.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Backdrop {
	float covered[SIDE * SIDE];
	vec4 map[WIDTH * HEIGHT];
};

// What is shown, as render_backdrop_kind: the code of the rest is left out, since software devices compute every
// branch. BACKDROP_PANORAMA: a panorama, which alone has an image.
#define FLOOR 0u
#define SKY 1u
#define MAP 3u
layout(constant_id = 0) const uint kind = MAP;
#define HDR_CONSTANT 1
#include "hdr/hdr.glsl"

#ifdef BACKDROP_PANORAMA
layout(set = 0, binding = 0) uniform sampler2D panorama;
#endif

// As render_backdrop_push. Constants and texels, which software devices load at once, and buffers lane by lane.
layout(push_constant, std430) uniform Push {
	vec4 ahead; // direction at the picture's middle, and what a step of 1 in clip space adds to it
	vec4 across;
	vec4 down;
	vec4 camera;       // of a floor
	vec4 shown_color;  // of a floor; of a sky that above
	vec4 floor_radius; // of a floor its center; of a sky that below
	vec2 turn;         // of the panorama: sine and cosine of its rotation
	Backdrop backdrop;
	float exposure; // factor of radiance, where it is kept as exposed
} push;

layout(location = 0) in vec2 uv; // of the picture, 0..1
layout(location = 0) out vec4 color;

vec3 texel(int x, int y)
{
	return push.backdrop.map[clamp(y, 0, HEIGHT - 1) * WIDTH + (x + WIDTH) % WIDTH].rgb;
}

// Between the middles of four texels, linearly, as gi_backdrop.c.
vec3 map_at(vec3 direction)
{
	const float PI = 3.14159265;
	float x = (atan(direction.x, -direction.z) / (2.0 * PI) + 0.5) * WIDTH - 0.5;
	float y = acos(clamp(direction.y, -1.0, 1.0)) / PI * HEIGHT - 0.5;
	int column = int(floor(x)), row = int(floor(y));
	vec2 part = vec2(x, y) - floor(vec2(x, y));
	return mix(mix(texel(column, row), texel(column + 1, row), part.x),
		mix(texel(column, row + 1), texel(column + 1, row + 1), part.x), part.y);
}

#ifdef BACKDROP_PANORAMA
// The texel that rays see, too (gi_environment.c).
vec3 panorama_at(vec3 direction)
{
	const float PI = 3.14159265;
	vec2 turn = push.turn;
	ivec2 size = textureSize(panorama, 0);
	float right = turn.y * direction.x - turn.x * direction.z;
	float back = turn.x * direction.x + turn.y * direction.z;
	int x = int(clamp(atan(right, -back) / (2.0 * PI) + 0.5, 0.0, 1.0) * float(size.x));
	int y = int(acos(clamp(direction.y, -1.0, 1.0)) / PI * float(size.y));
	return texelFetch(panorama, min(ivec2(x, y), size - 1), 0).xyz;
}
#endif

float covered(int x, int z)
{
	return push.backdrop.covered[clamp(z, 0, SIDE - 1) * SIDE + clamp(x, 0, SIDE - 1)];
}

// The share of the light above the floor that models take away where the ray meets it; 0 where it does not.
float shadow_at(vec3 direction)
{
	vec4 center = push.floor_radius;
	vec4 camera = push.camera;
	float above = camera.y - center.y;
	if (above <= 0.0 || direction.y >= 0.0)
		return 0.0;
	vec2 from = (camera.xz + direction.xz * (above / -direction.y) - center.xz) / center.w;
	float away = length(from);
	if (!(away < REACH))
		return 0.0;
	vec2 at = (from / REACH * 0.5 + 0.5) * SIDE - 0.5;
	int x = int(floor(at.x)), z = int(floor(at.y));
	vec2 part = at - floor(at);
	float share = mix(mix(covered(x, z), covered(x + 1, z), part.x),
		mix(covered(x, z + 1), covered(x + 1, z + 1), part.x), part.y);
	return SHADOW * share * (1.0 - smoothstep(0.6 * REACH, REACH, away));
}

void main()
{
	vec2 clip = uv * 2.0 - 1.0;
	vec3 direction = normalize(push.ahead.xyz + clip.x * push.across.xyz + clip.y * push.down.xyz);
#ifdef BACKDROP_PANORAMA
	vec3 radiance = panorama_at(direction);
#else
	vec3 radiance;
	if (kind == FLOOR)
		radiance = push.shown_color.rgb * (1.0 - shadow_at(direction));
	else if (kind == SKY)
		radiance = mix(push.floor_radius.rgb, push.shown_color.rgb,
			clamp(direction.y / max(fwidth(direction.y), 1e-9) + 0.5, 0.0, 1.0)); // an edge one pixel wide
	else
		radiance = map_at(direction);
#endif
	color = hdr == HDR_HALF ? vec4(radiance, 1.0) : hdr_encoded(radiance * push.exposure);
}
