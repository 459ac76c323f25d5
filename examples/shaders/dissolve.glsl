// Stripes that turn, on a ball that dissolves: for own_surface.c. Parameters: 0: seconds that it takes, stripes around
// it, holes across a metre; 1: colour of the stripes; 2: radiance of the edges. What a function is given and returns
// stands in Stilb's render/shaders/surface.glsl.

float random_at(vec3 cell)
{
	return fract(sin(dot(cell, vec3(12.9898, 78.233, 37.719))) * 43758.5453);
}

// Random numbers at the corners of cubes of side 1, and smooth between them.
float noise_at(vec3 place)
{
	vec3 cell = floor(place), part = smoothstep(0.0, 1.0, place - cell);
	vec4 near, far;
	for (int i = 0; i < 4; i++) {
		vec3 corner = cell + vec3(i & 1, i >> 1, 0);
		near[i] = random_at(corner);
		far[i] = random_at(corner + vec3(0, 0, 1));
	}
	vec4 between = mix(near, far, part.z);
	return mix(mix(between[0], between[1], part.x), mix(between[2], between[3], part.x), part.y);
}

Surface surface_function(Surface surface, SurfacePoint point)
{
	vec4 shape = surface_parameter(0);
	float around = atan(point.local.z, point.local.x) / 6.2831853 + 0.25 * point.time;
	float along = abs(fract(around * shape.y) - 0.5) * 2.0;
	float width = max(2.0 * shape.y * length(vec2(dFdx(point.local.xz).x, dFdy(point.local.xz).x)), 1e-3);
	float stripe = smoothstep(0.5 - width, 0.5 + width, along);
	surface.color = mix(surface.color, surface_parameter(1).rgb, stripe);
	surface.roughness = mix(surface.roughness, 0.2, stripe);
	float left = noise_at(point.local * shape.z) - point.time / shape.x;
	surface.alpha = left > 0.0 ? 1.0 : 0.0;
	surface.emission += surface_parameter(2).rgb * smoothstep(0.06, 0.0, left);
	return surface;
}
