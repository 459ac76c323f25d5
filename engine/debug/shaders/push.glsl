// What the two stages of debug drawing share.

// As debug_record: floats as bits, since letters have other things there.
struct Record {
	uvec4 from, to;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Records { Record records[]; };

#define HALO (1u << 29)
#define LETTER (1u << 30)
#define ON_TOP (1u << 31)

// As debug_place: pixels left, top, right, bottom.
struct Place {
	uvec4 place, inner;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Places { Place places[]; };

// As device_push.
layout(push_constant, std430) uniform Push {
	mat4 view_projection;
	Records records;
	Places places; // of all views
	vec2 origin, size; // of this view's part of the picture, pixels
	uint view, views;
} push;
