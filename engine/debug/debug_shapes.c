/* Shapes as lines. */
#include "debug/debug_internal.h"

#define CIRCLE_LINES 48u
#define SHAPE_LINES 64u /* that are handed over together, at least CIRCLE_LINES */

void stilb_debug_lines(stilb_debug *debug, const float (*points)[3], uint32_t count, stilb_debug_style style)
{
	STILB_ASSERT(points || count == 0);
	debug_record records[SHAPE_LINES];
	uint32_t word = debug_word(style);
	for (uint32_t done = 0, some; done < count; done += some) {
		some = count - done < SHAPE_LINES ? count - done : SHAPE_LINES;
		for (uint32_t i = 0; i < some; i++)
			records[i] =
				debug_line_of(points[2 * (size_t)(done + i)], points[2 * (size_t)(done + i) + 1], style.rgba, word);
		debug_put(debug, records, some, style.seconds);
	}
}

/* The point under a transform, which may be projective. */
static void shape_transform(const stilb_mat4 *transform, float point[3])
{
	const float *m = transform->m;
	float x = point[0], y = point[1], z = point[2];
	float w = m[3] * x + m[7] * y + m[11] * z + m[15];
	for (int r = 0; r < 3; r++)
		point[r] = (m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]) / w;
}

void stilb_debug_box(stilb_debug *debug, const float low[3], const float high[3], const stilb_mat4 *transform,
                     stilb_debug_style style)
{
	float corners[8][3]; /* bit a of the number: at the high end along axis a */
	for (uint32_t c = 0; c < 8; c++) {
		for (uint32_t a = 0; a < 3; a++)
			corners[c][a] = c >> a & 1u ? high[a] : low[a];
		if (transform)
			shape_transform(transform, corners[c]);
	}
	debug_record records[12];
	uint32_t word = debug_word(style), count = 0;
	for (uint32_t c = 0; c < 8; c++)
		for (uint32_t a = 0; a < 3; a++)
			if (!(c >> a & 1u))
				records[count++] = debug_line_of(corners[c], corners[c | 1u << a], style.rgba, word);
	debug_put(debug, records, count, style.seconds);
}

/* A circle in the plane of two unit vectors that are perpendicular. */
static void shape_circle(stilb_debug *debug, const float center[3], stilb_vec3 u, stilb_vec3 v, float radius,
                         stilb_debug_style style)
{
	STILB_ASSERT(radius >= 0.0f);
	float points[CIRCLE_LINES + 1][3];
	debug_record records[CIRCLE_LINES];
	uint32_t word = debug_word(style);
	for (uint32_t i = 0; i < CIRCLE_LINES; i++) {
		float angle = (float)i * (6.28318531f / CIRCLE_LINES), x = radius * cosf(angle), y = radius * sinf(angle);
		for (int a = 0; a < 3; a++)
			points[i][a] = center[a] + x * u[a] + y * v[a];
	}
	for (int a = 0; a < 3; a++)
		points[CIRCLE_LINES][a] = points[0][a];
	for (uint32_t i = 0; i < CIRCLE_LINES; i++)
		records[i] = debug_line_of(points[i], points[i + 1], style.rgba, word);
	debug_put(debug, records, CIRCLE_LINES, style.seconds);
}

void stilb_debug_circle(stilb_debug *debug, const float center[3], const float axis[3], float radius,
                        stilb_debug_style style)
{
	stilb_vec3 n = stilb_vec3_normalize(stilb_vec3_make(axis[0], axis[1], axis[2]));
	stilb_vec3 other = {0}; /* the axis of the world that is farthest from it */
	int least = fabsf(n[0]) <= fabsf(n[1]) ? 0 : 1;
	other[fabsf(n[2]) < fabsf(n[least]) ? 2 : least] = 1.0f;
	stilb_vec3 u = stilb_vec3_normalize(stilb_vec3_cross(n, other));
	shape_circle(debug, center, u, stilb_vec3_cross(n, u), radius, style);
}

void stilb_debug_sphere(stilb_debug *debug, const float center[3], float radius, stilb_debug_style style)
{
	stilb_vec3 x = stilb_vec3_make(1, 0, 0), y = stilb_vec3_make(0, 1, 0), z = stilb_vec3_make(0, 0, 1);
	shape_circle(debug, center, y, z, radius, style);
	shape_circle(debug, center, z, x, radius, style);
	shape_circle(debug, center, x, y, radius, style);
}

void stilb_debug_axes(stilb_debug *debug, const stilb_mat4 *transform, float length, stilb_debug_style style)
{
	static const uint32_t colors[3] = {0xff4050ffu, 0x40c040ffu, 0x4080ffffu};
	STILB_ASSERT(transform);
	debug_record records[3];
	uint32_t word = debug_word(style);
	float origin[3] = {0}, ends[3][3] = {{length, 0, 0}, {0, length, 0}, {0, 0, length}};
	shape_transform(transform, origin);
	for (uint32_t a = 0; a < 3; a++) {
		shape_transform(transform, ends[a]);
		records[a] = debug_line_of(origin, ends[a], (colors[a] & ~0xffu) | (style.rgba & 0xffu), word);
	}
	debug_put(debug, records, 3, style.seconds);
}
