#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require

const int WIDTH = 64; // of the map, as STILB_SCENE_BACKDROP_WIDTH and _HEIGHT
const int HEIGHT = 32;
const int SIDE = 64; // of the floor's cells, as STILB_SCENE_FLOOR_SIDE
const float REACH = 2.0; // as STILB_SCENE_FLOOR_REACH
const float SHADOW = 0.8; // how dark the floor is where nothing reaches it: some light always does

// Half floats, row after row.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Texels { uvec2 texels[]; };

// As backdrop_data.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Backdrop {
	vec4 ahead;          // direction at the picture's middle, and what a step of 1 in clip space adds to it
	vec4 across;
	vec4 down;
	vec4 camera;
	vec4 shown_color;
	vec4 floor_radius;   // its center; w: 0: there is no floor, the map is shown
	vec4 sky; // w: 1: it and the ground are shown
	vec4 ground;
	float covered[SIDE * SIDE];
	vec4 map[WIDTH * HEIGHT];
	uvec2 size; // of the panorama in texels; 0: it is not shown
	vec2 turn;  // sine and cosine of its rotation
	Texels panorama;
};

layout(push_constant, std430) uniform Push {
	Backdrop backdrop;
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

// The texel that rays see, too (gi_environment.c).
vec3 panorama_at(vec3 direction)
{
	const float PI = 3.14159265;
	vec2 turn = push.backdrop.turn;
	uvec2 size = push.backdrop.size;
	float right = turn.y * direction.x - turn.x * direction.z;
	float back = turn.x * direction.x + turn.y * direction.z;
	uint x = uint(clamp(atan(right, -back) / (2.0 * PI) + 0.5, 0.0, 1.0) * float(size.x));
	uint y = uint(acos(clamp(direction.y, -1.0, 1.0)) / PI * float(size.y));
	uvec2 bits = push.backdrop.panorama.texels[min(y, size.y - 1) * size.x + min(x, size.x - 1)];
	return vec3(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y).x);
}

float covered(int x, int z)
{
	return push.backdrop.covered[clamp(z, 0, SIDE - 1) * SIDE + clamp(x, 0, SIDE - 1)];
}

// The share of the light above the floor that models take away where the ray meets it; 0 where it does not.
float shadow_at(vec3 direction)
{
	vec4 center = push.backdrop.floor_radius;
	vec4 camera = push.backdrop.camera;
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
	vec4 across = push.backdrop.across, down = push.backdrop.down;
	vec2 clip = uv * 2.0 - 1.0;
	vec3 direction = normalize(push.backdrop.ahead.xyz + clip.x * across.xyz + clip.y * down.xyz);
	vec3 radiance;
	if (push.backdrop.floor_radius.w > 0.0)
		radiance = push.backdrop.shown_color.rgb * (1.0 - shadow_at(direction));
	else if (push.backdrop.sky.w > 0.0)
		radiance = mix(push.backdrop.ground.rgb, push.backdrop.sky.rgb,
			clamp(direction.y / max(fwidth(direction.y), 1e-9) + 0.5, 0.0, 1.0)); // an edge one pixel wide
	else if (push.backdrop.size.x > 0)
		radiance = panorama_at(direction);
	else
		radiance = map_at(direction);
	color = vec4(radiance, 1.0);
}
