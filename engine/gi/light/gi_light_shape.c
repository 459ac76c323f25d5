#include "gi/light/gi_light_shape.h"

#include "gi/gi_surface.h"
#include "gi/gi_vector.h"
#include "gi/light/gi_light_rectangle.h"
#include "shading/shade_constants.h"

#include <math.h>
#include <string.h>

/* Two triangles count as a rectangle if the cosine between its edges, and the gap between the corners that they share,
 * relative to the edges' length, are at most this. */
#define SQUARE_ANGLE 1e-5f
#define BELOW_ONE 0.99999994f /* the largest float below 1 */

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

/* The rectangle as seen from a point above its plane. */
static gi_rectangle_seen rectangle_seen(const gi_light_shape *shape, stilb_vec3 to_corner, float height)
{
	STILB_ASSERT(shape->rectangle);
	return gi_rectangle_see(stilb_vec3_dot(to_corner, shape->unit_1), stilb_vec3_dot(to_corner, shape->unit_2),
	                        shape->length_1, shape->length_2, height);
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
	return shape->area > GI_LIGHT_NEAR * stilb_vec3_dot(to_center, to_center);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

/* A point of the triangle, uniform by area, as a vector from the point that sees it. */
static stilb_vec3 point_by_area(const gi_light_shape *shape, stilb_vec3 to_corner, stilb_vec2 u)
{
	float root = sqrtf(u[0]);
	return to_corner + shape->edge_1 * (root * (1.0f - u[1])) + shape->edge_2 * (root * u[1]);
}

static float limited(float x, float low, float high)
{
	return x < low ? low : x > high ? high : x;
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

/* Sets to_light to a point of the rectangle, as a vector from the point that sees it. Returns the solid angle if it is
 * uniform by that; 0: it is uniform by area. */
static float rectangle_point(const gi_light_shape *shape, stilb_vec3 to_corner, float height, stilb_vec2 u,
                             stilb_vec3 *to_light)
{
	gi_rectangle_seen seen = rectangle_seen(shape, to_corner, height);
	bool by_angle = gi_rectangle_is_near(&seen, shape->area) && seen.solid_angle > GI_LIGHT_ANGLE_MIN;
	float x = u[0] * shape->length_1, y = u[1] * shape->length_2;
	if (by_angle)
		gi_rectangle_by_angle(&seen, u[0], u[1], &x, &y);
	*to_light = to_corner + shape->unit_1 * x + shape->unit_2 * y;
	return by_angle ? seen.solid_angle : 0.0f;
}

/* As rectangle_point, of a triangle. */
static float triangle_point(const gi_light_shape *shape, stilb_vec3 position, stilb_vec3 to_corner, float height,
                            stilb_vec2 u, stilb_vec3 *to_light)
{
	float angle = is_near(shape, position) ? triangle_angle(shape, to_corner, height) : 0.0f;
	if (angle > GI_LIGHT_ANGLE_MIN) {
		*to_light = point_of_triangle(shape, to_corner, height, angle, u);
		return angle;
	}
	*to_light = point_by_area(shape, to_corner, u);
	return 0.0f;
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
	float angle = shape->rectangle ? rectangle_point(shape, to_corner, height, u, &to_light)
	                               : triangle_point(shape, position, to_corner, height, u, &to_light);
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
	float angle = 0.0f;
	if (shape->rectangle) {
		gi_rectangle_seen seen = rectangle_seen(shape, to_corner, height);
		angle = gi_rectangle_is_near(&seen, shape->area) ? seen.solid_angle : 0.0f;
	} else if (is_near(shape, position)) {
		angle = triangle_angle(shape, to_corner, height);
	}
	if (angle > GI_LIGHT_ANGLE_MIN)
		return 1.0f / angle;
	float density = density_by_area(shape, height, distance);
	return density < INFINITY ? density : 0.0f;
}
