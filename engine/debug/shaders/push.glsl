// What the two stages of debug drawing share.

// As debug_record: floats as bits, since letters have other things there.
struct Record {
	uvec4 from, to;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Records { Record records[]; };

#define HALO (1u << 29)
#define LETTER (1u << 30)
#define ON_TOP (1u << 31)

// As device_push.
layout(push_constant, std430) uniform Push {
	mat4 view_projection;
	Records records;
	vec2 size; // of the picture, pixels
} push;
