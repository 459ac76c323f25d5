// Where what a pixel shows is, for passes over the picture: by depth, and by the inverse of the view's matrix.

// The point at this depth in a pixel whose middle is at; w: that of clip space, 0 where there is no such point.
vec4 place_at(vec2 at, float depth)
{
	vec2 size = 2.0 * vec2(push.view.rest.half_width, push.view.rest.half_height);
	vec4 place = push.view.rest.from_clip * vec4(at / size * 2.0 - 1.0, depth, 1.0);
	return place.w == 0.0 ? vec4(0.0) : vec4(place.xyz / place.w, place.w);
}
