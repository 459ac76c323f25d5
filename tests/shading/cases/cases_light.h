/* cases_light: lights, their units and their cones as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_LIGHT_H
#define SHADE_CASES_LIGHT_H

#include "case_inputs.h"
#include "shading/shade_light.h"
#include "shading/shade_light_area.h"
#include "shading/shade_light_cone.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) Near the peak a chord is the root of 1 - tolerance / peak, where a quotient that is
 * one bit off counts for more: 3e-5. An arcus tangent: 1e-5. */
#define SHADE_CASES_LIGHT(X)                                                                                           \
	X(0, shade_intensity, 1e-5f, 1e-6f)                                                                                \
	X(1, shade_intensity_from_flux, 1e-5f, 1e-6f)                                                                      \
	X(2, shade_flux_from_intensity, 1e-5f, 1e-6f)                                                                      \
	X(3, shade_pi_folded, 1e-5f, 1e-6f)                                                                                \
	X(4, shade_watts_from_lumens, 1e-5f, 1e-6f)                                                                        \
	X(5, shade_hemisphere_irradiance, 1e-5f, 1e-6f)                                                                    \
	X(6, shade_hemisphere_share, 1e-5f, 1e-6f)                                                                         \
	X(7, shade_hemisphere_radiance, 1e-5f, 1e-6f)                                                                      \
	X(8, shade_falloff, 1e-5f, 1e-6f)                                                                                  \
	X(9, shade_tolerance_and_reach, 1e-5f, 1e-6f)                                                                      \
	X(10, shade_falloff_share, 1e-5f, 1e-6f)                                                                           \
	X(11, shade_light_falloff, 1e-5f, 1e-6f)                                                                           \
	X(12, shade_light_at, 1e-5f, 1e-6f)                                                                                \
	X(13, shade_cone_chord, 1e-5f, 1e-6f)                                                                              \
	X(14, shade_cone_phong, 1e-5f, 3e-5f)                                                                              \
	X(15, shade_cone_blinn_phong, 1e-5f, 3e-5f)                                                                        \
	X(16, shade_cone_ggx, 1e-5f, 3e-5f)                                                                                \
	X(17, shade_cone_mirrored, 1e-5f, 1e-6f)                                                                           \
	X(18, shade_cone_half_angle, 1e-5f, 1e-5f)                                                                         \
	X(19, shade_half_angle, 1e-5f, 1e-6f)                                                                              \
	X(20, shade_cone_across, 1e-5f, 1e-6f)                                                                             \
	X(21, shade_cone_union, 1e-5f, 1e-6f)                                                                              \
	X(22, shade_spot_share, 1e-5f, 1e-5f)                                                                              \
	X(23, shade_light_at_direction, 1e-5f, 1e-5f)                                                                      \
	X(24, shade_sphere_irradiance, 1e-4f, 1e-4f)                                                                       \
	X(25, shade_disk_and_rectangle_irradiance, 1e-4f, 1e-4f)                                                           \
	X(26, shade_area_irradiance, 1e-4f, 1e-4f)                                                                         \
	X(27, shade_area_pieces, 1e-5f, 1e-5f)                                                                             \
	X(28, shade_disk_pieces, 1e-4f, 1e-4f)                                                                             \
	X(29, shade_border_edge, 1e-4f, 1e-4f)
#define SHADE_CASES_LIGHT_COUNT 30

SHADE_FN shade_light shade_case_some_light(vec4 a, vec4 b)
{
	float radius = shade_case_range(a[3], 0.0f, 2.0f);
	float inner = shade_case_range(b[3], -0.5f, 1.0f);
	vec3 direction = shade_case_direction(b[0], b[1]);
	vec3 across = shade_case_direction(b[1], b[2]);
	shade_light light = {int(b[3] * 5.999f),
	                     int(a[2] * 3.999f),
	                     vec3(a) * 4.0f - 2.0f,
	                     direction,
	                     vec3(b) + 0.1f,
	                     inner,
	                     inner - 0.05f - 0.4f * b[2],
	                     radius,
	                     across * (0.1f + a[0]),
	                     cross(across, direction) * 0.3f,
	                     radius + 0.1f + 4.0f * b[2]};
	return light;
}

SHADE_FN vec4 shade_case_lights(int row, vec4 a, vec4 b)
{
	shade_light light = shade_case_some_light(a, b);
	vec3 position = vec3(3.0f * b[3] - 1.0f, 2.0f * a[0], 1.0f - a[1]);
	float square = shade_case_skewed(b[3], 0.0f, 100.0f);
	float cosine = 2.0f * a[1] - 1.0f;
	if (row == 8)
		return vec4(shade_falloff_sphere(square, light.radius), shade_falloff_disk(square, light.radius),
		            shade_falloff_window(0.2f * square, light.reach), shade_falloff_subtracted(2.0f * b[0], b[1]));
	if (row == 9)
		return vec4(shade_tolerance_from_reach(light.reach), shade_reach_from_error(a[0], a[1] + 1e-3f), 0.0f, 0.0f);
	if (row == 10)
		return vec4(shade_falloff_share(SHADE_FALLOFF_PHYSICAL, square, light.radius, light.reach),
		            shade_falloff_share(SHADE_FALLOFF_WINDOWED, 0.2f * square, light.radius, light.reach),
		            shade_falloff_share(SHADE_FALLOFF_SUBTRACTED, 0.2f * square, light.radius, light.reach),
		            shade_falloff_share(SHADE_FALLOFF_RANGED, 0.2f * square, light.radius, light.reach));
	if (row == 11)
		return vec4(shade_light_falloff(light, square + 0.1f, cosine), shade_rectangle_area(light.half_x, light.half_y),
		            shade_falloff_range(0.2f * square, light.reach), 0.0f);
	shade_sun seen = shade_light_at(light, position);
	if (row == 23)
		return vec4(seen.direction, 0.0f);
	return vec4(seen.irradiance, 0.0f);
}

SHADE_FN vec4 shade_case_units(int row, vec4 a, vec4 b)
{
	vec3 light = vec3(a) * shade_case_skewed(b[0], 0.0f, 1e4f);
	float radius = shade_case_range(b[1], 0.0f, 2.0f);
	float exponent = shade_case_skewed(b[2], 0.0f, 1e6f);
	if (row == 0)
		return vec4(shade_intensity_from_radiance(light, radius)[0], shade_radiance_from_intensity(light, radius)[1],
		            0.0f, 0.0f);
	if (row == 1)
		return vec4(shade_intensity_from_flux_sphere(light)[0], shade_intensity_from_flux_disk(light)[1], 0.0f, 0.0f);
	if (row == 2)
		return vec4(shade_flux_from_intensity_sphere(light)[0], shade_flux_from_intensity_disk(light)[1], 0.0f, 0.0f);
	if (row == 3)
		return vec4(shade_from_pi_folded(light)[0], shade_to_pi_folded(light)[1], 0.0f, 0.0f);
	if (row == 4)
		return vec4(shade_watts_from_lumens(1000.0f * b[3], vec3(a) + 1e-3f), 0.0f);
	if (row == 5)
		return vec4(shade_hemisphere_irradiance(2.0f * a[3] - 1.0f, vec3(a), vec3(b)), 0.0f);
	if (row == 6) // a wide lobe, and a narrow one at the horizon, where it has a share of both
		return vec4(shade_hemisphere_share(2.0f * a[3] - 1.0f, 8.0f * b[0]),
		            shade_hemisphere_share((2.0f * a[2] - 1.0f) * 4.0f / sqrt(exponent + 16.0f), exponent), 0.0f, 0.0f);
	return vec4(shade_hemisphere_radiance(2.0f * a[3] - 1.0f, 8.0f * b[3], vec3(a), vec3(b)), 0.0f);
}

SHADE_FN vec4 shade_case_cone_of(shade_cone cone)
{
	return vec4(cone.axis, cone.chord);
}

SHADE_FN vec4 shade_case_cones(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 v = shade_case_above(n, a[2], a[3]);
	float exponent = shade_case_skewed(b[0], 1e-2f, 2e6f);
	float alpha = shade_case_range(b[1], SHADE_ALPHA_MIN, 1.0f);
	float tolerance = shade_case_skewed(b[2], 1e-4f, 10.0f);
	float share = 2.0f * b[3] - 0.5f; // rounds once on both sides, since what counts is 1 - share
	if (row == 13)
		return vec4(shade_cone_chord_phong(share, exponent), shade_cone_chord_blinn_phong(share, exponent),
		            shade_cone_chord_ggx(share, alpha),
		            shade_cone_chord_of_facets(share) + shade_cone_depth(0.1f * tolerance + 1e-6f));
	if (row == 14)
		return shade_case_cone_of(shade_cone_phong(n, v, exponent, tolerance));
	if (row == 15)
		return shade_case_cone_of(shade_cone_blinn_phong(n, v, exponent, tolerance));
	if (row == 16)
		return shade_case_cone_of(shade_cone_ggx(n, v, alpha, tolerance));
	shade_cone cone = shade_cone_mirrored(n, v, 2.2f * b[0] - 0.1f);
	if (row == 17) // inside or outside by far more than rounding
		return vec4(cone.axis,
		            select(shade_cone_holds(cone, shade_case_direction(b[1], b[2])), 1.0f, 0.0f) + cone.chord);
	if (row == 18)
		return vec4(shade_cone_half_angle(cone), shade_cone_share(tolerance, 0.1f + b[3]), 0.0f, 0.0f);
	shade_half_angle p = shade_half_angle_from_chord(2.0f * a[2]);
	shade_half_angle q = shade_half_angle_from_chord(2.0f * a[3]);
	shade_half_angle both = shade_half_angle_sum(p, q);
	shade_half_angle left = shade_half_angle_difference(p, q);
	if (row == 19)
		return vec4(both.sine, both.cosine, left.sine, left.cosine);
	if (row == 20)
		return vec4(shade_cone_across(n, shade_case_direction(b[1], b[2])), 0.0f);
	shade_cone other = {shade_case_direction(b[1], b[2]), 2.1f * b[3] - 0.1f};
	if (a[3] < 0.5f)
		return shade_case_cone_of(shade_cone_union(cone, other));
	// The rows above order the cones themselves.
	return shade_case_cone_of(shade_cone_union_ordered(cone, shade_cone_mirrored(n, v, cone.chord * b[3])));
}

SHADE_FN vec4 shade_case_spots(vec4 a, vec4 b)
{
	float inner = shade_case_range(b[3], -0.5f, 1.0f);
	float outer = inner - 0.05f - 0.4f * b[2];
	return vec4(shade_spot_share(2.0f * a[0] - 1.0f, inner, outer), shade_spot_share(a[1], inner, inner), 0.0f, 0.0f);
}

SHADE_FN vec4 shade_case_areas(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[3], b[3]);
	if (row == 24)
		return vec4(shade_sphere_irradiance(2.0f * a[0] - 1.0f, 0.001f + 0.999f * a[1]), 0.0f, 0.0f, 0.0f);
	shade_light light = shade_case_some_light(a, b);
	vec3 direction = shade_case_direction(b[0], b[1]);
	vec3 x = normalize(cross(direction, vec3(0.3f, 0.5f, 0.8f))) * (0.1f + a[0]);
	vec3 y = cross(x, direction);
	vec3 center = 3.0f * vec3(b[2], a[1], a[2]) - 1.5f;
	if (row == 25)
		return vec4(shade_disk_irradiance(center, direction, 0.1f + a[0], n),
		            shade_rectangle_irradiance(center, direction, x, y, n), 0.0f, 0.0f);
	light.kind = SHADE_LIGHT_SPHERE + int(b[3] * 2.999f);
	light.half_x = x;
	light.half_y = y;
	return vec4(shade_area_irradiance(light, light.position - center, n) * 0.1f, 0.0f);
}

/* What the irradiance of disks and rectangles is made of. */
SHADE_FN vec4 shade_case_area_pieces(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[3], b[3]);
	float short_side = 0.1f + a[2];
	float long_side = short_side + b[2];
	if (row == 27)
		return vec4(shade_area_acos(2.0f * a[0] - 1.0f), shade_disk_ramp(2.0f * a[1] - 1.0f),
		            shade_rectangle_ramp((2.0f * a[3] - 1.0f) * (long_side + short_side), long_side, short_side),
		            select(shade_light_is_sized(int(b[3] * 5.999f)), 1.0f, 0.0f));
	if (row == 28) {
		shade_disk_seen disk = {n[0], n[1], n[2], 0.1f + 2.0f * a[0], 2.0f * b[0], 0.1f + a[1]};
		float left = disk.height * disk.height + disk.across * disk.across - disk.radius * disk.radius;
		float root = sqrt(left * left + 4.0f * disk.radius * disk.radius * disk.height * disk.height);
		float from = 3.0f * b[1] - 1.5f;
		return vec4(shade_disk_irradiance_whole(disk, root), shade_disk_arc(disk, root, from, from + 0.1f + b[2]),
		            shade_distant_share(n, vec3(0.1f * a[1], 0.0f, 0.0f), vec3(0.0f, 0.1f * b[2], 0.0f),
		                                vec3(a[0], 0.1f * b[1], a[2])),
		            0.0f);
	}
	shade_border border = {0.0f, vec3(0.0f), vec3(0.0f)};
	border = shade_border_edge(border, 3.0f * vec3(b[2], a[1], a[2]) - 1.5f, shade_case_direction(b[0], b[1]), n);
	return vec4(border.sum, border.set[0], border.rise[0], 0.0f);
}

SHADE_FN vec4 shade_case_light(int row, vec4 a, vec4 b)
{
	if (row > 26)
		return shade_case_area_pieces(row, a, b);
	if (row > 23)
		return shade_case_areas(row, a, b);
	if (row == 22)
		return shade_case_spots(a, b);
	if (row == 23)
		return shade_case_lights(row, a, b);
	if (row < 8)
		return shade_case_units(row, a, b);
	if (row < 13)
		return shade_case_lights(row, a, b);
	return shade_case_cones(row, a, b);
}

#include "shading/glsl_end.h"
#endif
