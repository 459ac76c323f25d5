#include "gi/light/gi_light_shape.h"

#include "gi/gi_surface.h"
#include "gi/gi_vector.h"
#include "shading/shade_constants.h"

#include <math.h>
#include <string.h>

#define NEAR 0.2f             /* area over squared distance, above which sampling by solid angle is worth its time */
#define SOLID_ANGLE_MIN 0.01f /* sr: below it, rounding errors of the angles would be visible */
/* Two triangles count as a rectangle if the cosine between its edges, and the gap between the corners that they share,
 * relative to the edges' length, are at most this. */
#define SQUARE_ANGLE 1e-5f
#define BELOW_ONE 0.99999994f /* the largest float below 1 */
#define SQUARE_MIN 1e-14f     /* lower bound of divisors */

/* ---- making ------------------------------------------------------------------------------------------------------ */

gi_light_shape gi_light_shape_make(const gi_emitter *emitter)
{
	const float(*p)[3] = emitter->position;
	gi_light_shape shape = {
		.corner = gi_vector(p[0]),
		.edge_1 = gi_vector(p[1]) - gi_vector(p[0]),
		.edge_2 = gi_vector(p[2]) - gi_vector(p[0]),
		.emission = gi_vector(emitter->emission),
		.error = gi_triangle_error(p[0], p[1], p[2]),
		.unmet = emitter->unmet,
	};
	shape.center = shape.corner + (shape.edge_1 + shape.edge_2) * (1.0f / 3.0f);
	stilb_vec3 normal = stilb_vec3_cross(shape.edge_1, shape.edge_2);
	float twice = gi_length(normal);
	if (twice > 0.0f && isfinite(twice)) {
		shape.normal = normal * (1.0f / twice);
		shape.area = 0.5f * twice;
	}
	return shape;
}

/* The corner of one triangle that the other lacks; 3: they do not share exactly two corners. */
static int lonely_corner(const gi_emitter *one, const gi_emitter *other)
{
	int lonely = 3, shared = 0;
	for (int i = 0; i < 3; i++) {
		bool found = false;
		for (int j = 0; j < 3; j++)
			found |= memcmp(one->position[i], other->position[j], sizeof one->position[i]) == 0;
		shared += found;
		lonely = found ? lonely : i;
	}
	return shared == 2 ? lonely : 3;
}

bool gi_light_shape_join(const gi_emitter *first, const gi_emitter *second, gi_light_shape *shape)
{
	int a = lonely_corner(first, second), b = lonely_corner(second, first);
	if (a == 3 || b == 3 || first->glow.maps.surface || second->glow.maps.surface || first->unmet != second->unmet ||
	    memcmp(first->emission, second->emission, sizeof first->emission) != 0)
		return false;
	gi_light_shape one = gi_light_shape_make(first), two = gi_light_shape_make(second);
	one.corner = gi_vector(first->position[a]);
	one.edge_1 = gi_vector(first->position[(a + 1) % 3]) - one.corner;
	one.edge_2 = gi_vector(first->position[(a + 2) % 3]) - one.corner;
	float length_1 = gi_length(one.edge_1), length_2 = gi_length(one.edge_2);
	stilb_vec3 gap = one.corner + one.edge_1 + one.edge_2 - gi_vector(second->position[b]);
	if (!(fabsf(stilb_vec3_dot(one.edge_1, one.edge_2)) <= SQUARE_ANGLE * length_1 * length_2) ||
	    !(gi_length(gap) <= SQUARE_ANGLE * fminf(length_1, length_2)) ||
	    !(stilb_vec3_dot(one.normal, two.normal) > 0.0f))
		return false;
	one.length_1 = length_1;
	one.length_2 = length_2;
	one.unit_1 = one.edge_1 * (1.0f / length_1);
	one.unit_2 = one.edge_2 * (1.0f / length_2);
	one.center = one.corner + (one.edge_1 + one.edge_2) * 0.5f;
	one.area *= 2.0f;
	one.error = fmaxf(one.error, two.error);
	one.rectangle = true;
	*shape = one;
	return true;
}

/* ---- solid angles ------------------------------------------------------------------------------------------------ */

typedef int32_t lanes_mask __attribute__((vector_size(16)));

static stilb_vec4 root4(stilb_vec4 x)
{
	return (stilb_vec4){sqrtf(x[0]), sqrtf(x[1]), sqrtf(x[2]), sqrtf(x[3])};
}

/* Arc cosine of four numbers, |x| <= 1. The error is at most 2e-8 and rounding. Source: Abramowitz and Stegun,
 * "Handbook of Mathematical Functions" (1964), 4.4.46. */
static stilb_vec4 arc_cosine4(stilb_vec4 x)
{
	lanes_mask below = x < 0.0f, sign = below & INT32_MIN;
	stilb_vec4 size = (stilb_vec4)((lanes_mask)x & INT32_MAX);
	stilb_vec4 p = 0.0066700901f - 0.0012624911f * size;
	p = -0.0170881256f + p * size;
	p = 0.0308918810f + p * size;
	p = -0.0501743046f + p * size;
	p = 0.0889789874f + p * size;
	p = -0.2145988016f + p * size;
	p = 1.5707963050f + p * size;
	stilb_vec4 angle = root4(1.0f - size) * p,
			   pi = (stilb_vec4)((lanes_mask)(stilb_vec4){SHADE_PI, SHADE_PI, SHADE_PI, SHADE_PI} & below);
	return pi + (stilb_vec4)((lanes_mask)angle ^ sign);
}

/* A rectangle as seen from a point above its plane, with that point as the origin, x along edge_1 and y along edge_2:
 * it is [x0, x1] x [y0, y1]. Names of Urena, Fajardo and King. normal_z: z of the normals of the planes through the
 * point and the edges at y0, x1, y1, x0. The sum of the angles between neighbouring planes less 2 pi is the solid
 * angle. */
typedef struct spherical_rectangle {
	float x0, x1, y0, y1;
	stilb_vec4 normal_z, angles; /* angles[i]: from plane i to the next */
	float solid_angle;
} spherical_rectangle;

static spherical_rectangle rectangle_seen(const gi_light_shape *shape, stilb_vec3 to_corner, float height)
{
	spherical_rectangle seen;
	seen.x0 = stilb_vec3_dot(to_corner, shape->unit_1);
	seen.x1 = seen.x0 + shape->length_1;
	seen.y0 = stilb_vec3_dot(to_corner, shape->unit_2);
	seen.y1 = seen.y0 + shape->length_2;
	stilb_vec4 side = {-seen.y0, seen.x1, seen.y1, -seen.x0};
	seen.normal_z = side / root4(side * side + height * height);
	stilb_vec4 next = {seen.normal_z[1], seen.normal_z[2], seen.normal_z[3], seen.normal_z[0]};
	seen.angles = arc_cosine4(-seen.normal_z * next);
	seen.solid_angle = seen.angles[0] + seen.angles[1] - (2.0f * SHADE_PI - seen.angles[2] - seen.angles[3]);
	return seen;
}

/* Solid angle of a triangle, seen from a point. height: of the point above its plane, > 0. a: vector from the point to
 * the shape's corner. Source: Van Oosterom and Strackee (gi_light_shape.h). */
static float triangle_angle(const gi_light_shape *shape, stilb_vec3 a, float height)
{
	stilb_vec3 b = a + shape->edge_1, c = a + shape->edge_2;
	float la = gi_length(a), lb = gi_length(b), lc = gi_length(c), det = 2.0f * shape->area * height;
	float below = la * lb * lc + stilb_vec3_dot(a, b) * lc + stilb_vec3_dot(b, c) * la + stilb_vec3_dot(c, a) * lb;
	return 2.0f * atan2f(det, below);
}

static bool is_near(const gi_light_shape *shape, stilb_vec3 position)
{
	stilb_vec3 to_center = shape->center - position;
	return shape->area > NEAR * stilb_vec3_dot(to_center, to_center);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

/* A point of the shape, uniform by area, as a vector from the point that sees it. */
static stilb_vec3 point_by_area(const gi_light_shape *shape, stilb_vec3 to_corner, stilb_vec2 u)
{
	if (shape->rectangle)
		return to_corner + shape->edge_1 * u[0] + shape->edge_2 * u[1];
	float root = sqrtf(u[0]);
	return to_corner + shape->edge_1 * (root * (1.0f - u[1])) + shape->edge_2 * (root * u[1]);
}

static float limited(float x, float low, float high)
{
	return x < low ? low : x > high ? high : x;
}

/* A point of the rectangle, uniform by solid angle: first that x for which the part of the rectangle from x0 to x has
 * the share u[0] of the solid angle, then y, uniform in the sine of its angle as seen from the point. The source
 * (Urena, Fajardo, King) has x = cu height / sqrt(1 - cu^2), with cu = +-1 / sqrt(fu^2 + b0^2) and fu = across / sine;
 * here it is rewritten with one square root. */
static stilb_vec3 point_of_rectangle(const gi_light_shape *shape, stilb_vec3 to_corner, float height,
                                     const spherical_rectangle *seen, stilb_vec2 u)
{
	STILB_ASSERT(shape->rectangle);
	float b0 = seen->normal_z[0], b1 = seen->normal_z[2], x0 = seen->x0, y0 = seen->y0, y1 = seen->y1;
	float au = u[0] * seen->solid_angle + (2.0f * SHADE_PI - seen->angles[2] - seen->angles[3]);
	float sine = sinf(au), across = cosf(au) * b0 - b1, height2 = height * height;
	/* 1 - b0^2 is height2 / (height2 + y0 * y0) */
	float below = across * across - sine * sine * (height2 / (height2 + y0 * y0));
	float size = height * fabsf(sine) / sqrtf(below > SQUARE_MIN ? below : SQUARE_MIN);
	float xu = limited(across * sine < 0.0f ? -size : size, x0, seen->x1), d2 = xu * xu + height2;
	float h0 = y0 / sqrtf(d2 + y0 * y0), h1 = y1 / sqrtf(d2 + y1 * y1), hv = h0 + u[1] * (h1 - h0);
	float rest = 1.0f - hv * hv;
	float yv = limited(hv * sqrtf(d2 / (rest > SQUARE_MIN ? rest : SQUARE_MIN)), y0, y1);
	return to_corner + shape->unit_1 * (xu - x0) + shape->unit_2 * (yv - y0);
}

/* The part of v that is perpendicular to the unit vector a, normalised. */
static stilb_vec3 across(stilb_vec3 v, stilb_vec3 a)
{
	stilb_vec3 part = v - a * stilb_vec3_dot(v, a);
	float size2 = stilb_vec3_dot(part, part);
	return part * (1.0f / sqrtf(size2 > 1e-30f ? size2 : 1e-30f));
}

/* A point of the triangle, uniform by solid angle, in Arvo's names: a, b, c are the corners on the sphere, alpha is
 * the angle at a. The corner c moves to p on the arc from a to c until the triangle has the share u[0] of its solid
 * angle; the point lies on the arc from b to p. */
static stilb_vec3 point_of_triangle(const gi_light_shape *shape, stilb_vec3 to_corner, float height, float angle,
                                    stilb_vec2 u)
{
	STILB_ASSERT(!shape->rectangle);
	stilb_vec3 a = stilb_vec3_normalize(to_corner), b = stilb_vec3_normalize(to_corner + shape->edge_1);
	stilb_vec3 c = stilb_vec3_normalize(to_corner + shape->edge_2);
	stilb_vec3 c_side = across(c, a);
	float cos_alpha = limited(stilb_vec3_dot(across(b, a), c_side), -BELOW_ONE, BELOW_ONE);
	float sin_alpha = gi_sine(cos_alpha);
	/* phi is the smaller triangle's solid angle - alpha + pi. */
	float s = sinf(u[0] * angle), co = cosf(u[0] * angle);
	float sin_phi = co * sin_alpha - s * cos_alpha, cos_phi = -co * cos_alpha - s * sin_alpha;
	float k1 = cos_phi + cos_alpha, k2 = sin_phi - sin_alpha * stilb_vec3_dot(a, b);
	float below = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
	float q = below != 0.0f ? (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / below : 1.0f;
	float cos_p = limited(q, -1.0f, 1.0f);
	stilb_vec3 p = a * cos_p + c_side * gi_sine(cos_p);
	float z = 1.0f - u[1] * (1.0f - stilb_vec3_dot(p, b));
	stilb_vec3 direction = b * z + across(p, b) * gi_sine(z);
	float cosine = -stilb_vec3_dot(direction, shape->normal);
	return direction * (height / (cosine > 1e-20f ? cosine : 1e-20f));
}

/* ---- sampling ---------------------------------------------------------------------------------------------------- */

/* Sets point to one of the shape that is uniform by solid angle. Returns the solid angle, or 0, without a point, if it
 * is too small to be computed well. */
static float near_point(const gi_light_shape *shape, stilb_vec3 to_corner, float height, stilb_vec2 u,
                        stilb_vec3 *point)
{
	if (shape->rectangle) {
		spherical_rectangle seen = rectangle_seen(shape, to_corner, height);
		if (!(seen.solid_angle > SOLID_ANGLE_MIN))
			return 0.0f;
		*point = point_of_rectangle(shape, to_corner, height, &seen, u);
		return seen.solid_angle;
	}
	float angle = triangle_angle(shape, to_corner, height);
	if (!(angle > SOLID_ANGLE_MIN))
		return 0.0f;
	*point = point_of_triangle(shape, to_corner, height, angle, u);
	return angle;
}

/* Density per steradian of a point that is uniform by area: distance^2 / (cosine area), cosine = height / distance. */
static float density_by_area(const gi_light_shape *shape, float height, float distance)
{
	return distance * distance * distance / (height * shape->area);
}

/* What a point of the triangle emits at this cosine. from_corner: the point. */
static stilb_vec3 point_emission(const gi_light_shape *shape, stilb_vec3 from_corner, float cosine)
{
	float scale = 0.5f / shape->area;
	float u = stilb_vec3_dot(stilb_vec3_cross(from_corner, shape->edge_2), shape->normal) * scale;
	float v = stilb_vec3_dot(stilb_vec3_cross(shape->edge_1, from_corner), shape->normal) * scale;
	return gi_glow_towards(shape->glow, u, v, cosine);
}

bool gi_light_shape_sample(const gi_light_shape *shape, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample)
{
	STILB_ASSERT(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
	stilb_vec3 to_corner = shape->corner - position;
	float height = -stilb_vec3_dot(to_corner, shape->normal);
	if (!(height > 0.0f))
		return false;
	stilb_vec3 to_light;
	float angle = is_near(shape, position) ? near_point(shape, to_corner, height, u, &to_light) : 0.0f;
	if (angle == 0.0f)
		to_light = point_by_area(shape, to_corner, u);
	float distance = gi_length(to_light);
	float scale = 1.0f / distance;
	sample->direction = to_light * scale;
	sample->distance = gi_shadow_distance(distance, shape->error, height * scale);
	sample->radiance = shape->glow ? point_emission(shape, to_light - to_corner, height * scale) : shape->emission;
	sample->pdf = angle > 0.0f ? 1.0f / angle : density_by_area(shape, height, distance);
	sample->delta = shape->unmet;
	return sample->pdf < INFINITY;
}

float gi_light_shape_density(const gi_light_shape *shape, stilb_vec3 position, float distance)
{
	STILB_ASSERT(!(distance < 0.0f));
	stilb_vec3 to_corner = shape->corner - position;
	float height = -stilb_vec3_dot(to_corner, shape->normal);
	if (!(height > 0.0f))
		return 0.0f;
	if (is_near(shape, position)) {
		float angle = shape->rectangle ? rectangle_seen(shape, to_corner, height).solid_angle
		                               : triangle_angle(shape, to_corner, height);
		if (angle > SOLID_ANGLE_MIN)
			return 1.0f / angle;
	}
	float density = density_by_area(shape, height, distance);
	return density < INFINITY ? density : 0.0f;
}
