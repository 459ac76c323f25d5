// Which lights reach what is seen, for passes that shorten lists. A light that may send more than nothing is kept.

// The share of a point's distance from the viewer by which depth may place it wrongly.
const float REACH_ROUNDING = 1e-3;

// What a light reaches: a ball, and of that what lies in a cone.
struct Reach {
	vec3 center, axis;
	float radius, cosine; // of half the cone's angle; -1: all of the ball
	float size;           // of the lamp itself, from its centre; 0: a point
};

Reach reach_of(uint index)
{
	vec4 position_kind = push.view.lights.lights[index].position_kind;
	vec4 direction_reach = push.view.lights.lights[index].direction_reach;
	vec4 half_x_outer = push.view.lights.lights[index].half_x_outer;
	vec4 half_y_radius = push.view.lights.lights[index].half_y_radius;
	int kind = int(position_kind.w) & 7;
	bool spot = kind == SHADE_LIGHT_SPOT;
	return Reach(position_kind.xyz, direction_reach.xyz, direction_reach.w * (1.0 + REACH_ROUNDING),
		spot ? half_x_outer.w - REACH_ROUNDING : -1.0,
		shade_light_is_sized(kind) ? half_y_radius.w + length(half_x_outer.xyz) + length(half_y_radius.xyz) : 0.0);
}
