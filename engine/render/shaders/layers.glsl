// What lies over a surface and what goes through it (shade_layers.h), and what of it lights reach. Inside of lit.glsl.
#include "../../shading/shade_layers.h"

struct Layers {
	float coat, coat_roughness; // [0, 1], as sheen, brushed and transmission
	vec3 coat_n;                // its own normal, unit, on the side that is seen
	vec3 sheen;
	float sheen_roughness;
	float brushed; // anisotropy
	vec3 along;    // the direction of the brush, of any length but 0 where brushed is above 0
	float transmission, roughness; // of what light goes through, whatever is brushed
	vec3 tint;       // of what goes through
	vec3 absorption; // per metre
	float thickness; // metres
	float ior;       // 0: a mirror
};

Layers layers; // of this pixel, set before light is added

// The share of what arrives at the coat that it sends back.
float coat_share(vec3 v)
{
	return has_coat ? shade_coat_share(layers.coat, dot(layers.coat_n, v)) : 0.0;
}

// What the sheen leaves of the light of what is below it.
float sheen_left(vec3 n, vec3 v)
{
	return has_sheen ? shade_sheen_left(layers.sheen, dot(n, v), layers.sheen_roughness) : 1.0;
}

// What one light sends to v: below it is what the base sends.
vec3 layers_lit(vec3 below, shade_material material, vec3 n, shade_sun seen, vec3 v)
{
	vec3 lit = below;
	if (lets_through && !is_solid)
		lit += layers.tint * seen.irradiance *
			(layers.transmission * shade_thin_cos(material.specular, layers.roughness, n, seen.direction, v));
	if (has_sheen)
		lit = lit * sheen_left(n, v) +
			layers.sheen * seen.irradiance * shade_sheen_cos(layers.sheen_roughness, n, seen.direction, v);
	if (has_coat) {
		float share = coat_share(v);
		float highlight = shade_coat_cos(layers.coat_roughness, layers.coat_n, seen.direction, v);
		lit = lit * (1.0 - share) + seen.irradiance * (share * highlight);
	}
	return lit;
}
