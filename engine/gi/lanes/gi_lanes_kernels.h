/*
 * gi_lanes_kernels: loops over sixteen lanes in plain C, which the compiler vectorises. Included by one file for each
 * instruction set, which defines KERNELS as the name of its table.
 */
#ifndef STILB_GI_LANES_KERNELS_H
#define STILB_GI_LANES_KERNELS_H

#include "gi/lanes/gi_lanes.h"
#include "gi/light/gi_light_rectangle.h"
#include "gi/sample/gi_sampler.h"
#include "gi/trace/gi_packet.h"
#include "shading/shade_sampling.h"

typedef float lanes_row[GI_LANES];

/* Transposes the same vector of four lanes, from `first` on, into rows. */
GI_LANE void lanes_rows(const void *a, const void *b, const void *c, const void *d, uint32_t first, lanes_row rows[4])
{
	stilb_vec4 m[4];
	memcpy(&m[0], a, sizeof m[0]);
	memcpy(&m[1], b, sizeof m[1]);
	memcpy(&m[2], c, sizeof m[2]);
	memcpy(&m[3], d, sizeof m[3]);
	gi_packet_transpose(m);
	for (int i = 0; i < 4; i++)
		memcpy(&rows[i][first], &m[i], sizeof m[i]);
}

/* The four numbers that begin at this member of sixteen structs, as rows. */
#define LANES_GATHER(pointers, member, rows)                                                                           \
	for (uint32_t first = 0; first < GI_LANES; first += 4)                                                             \
	lanes_rows(&(pointers)[first]->member, &(pointers)[first + 1]->member, &(pointers)[first + 2]->member,             \
	           &(pointers)[first + 3]->member, first, rows)

/* ---- directions -------------------------------------------------------------------------------------------------- */

/* Sines and cosines as of shade_concentric, here without branches and calls. */
GI_LANE void lanes_cosine(float u, float v, float *x, float *y, float *z)
{
	float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
	int32_t steep = fabsf(b) >= fabsf(a);
	float radius = steep ? b : a, other = steep ? a : b;
	float ratio = other / (radius == 0.0f ? 1.0f : radius), angle = 0.25f * SHADE_PI * ratio;
	float sine = radius * gi_sine_small(angle), cosine = radius * gi_cosine_small(angle);
	float rest = (1.0f - radius) * (1.0f + radius);
	*x = steep ? sine : cosine;
	*y = steep ? cosine : sine;
	*z = sqrtf(rest > SHADE_COS2_MIN ? rest : SHADE_COS2_MIN);
}

static void lanes_leave(gi_lanes *lanes)
{
	lanes_row position[4], numbers[4], error, next[4];
	LANES_GATHER(lanes->surfaces, position, position);
	LANES_GATHER(lanes->surfaces, normal, lanes->rows_normal);
	LANES_GATHER(lanes->surfaces, geometric, lanes->rows_geometric);
	for (uint32_t first = 0; first < GI_LANES; first += 4)
		lanes_rows(lanes->numbers[first], lanes->numbers[first + 1], lanes->numbers[first + 2],
		           lanes->numbers[first + 3], first, numbers);
	for (uint32_t i = 0; i < GI_LANES; i++)
		error[i] = lanes->surfaces[i]->error;
	for (uint32_t i = 0; i < GI_LANES; i++) {
		float nx = lanes->rows_normal[0][i], ny = lanes->rows_normal[1][i], nz = lanes->rows_normal[2][i];
		float gx = lanes->rows_geometric[0][i], gy = lanes->rows_geometric[1][i], gz = lanes->rows_geometric[2][i];
		float x, y, z;
		lanes_cosine(numbers[GI_DIMENSION_DIRECTION][i], numbers[GI_DIMENSION_DIRECTION + 1][i], &x, &y, &z);
		/* shade_frame_from_normal */
		float s = nz < 0.0f ? -1.0f : 1.0f, a = -1.0f / (s + nz), c = nx * ny * a;
		float dx = (1.0f + s * nx * nx * a) * x + c * y + nx * z;
		float dy = s * c * x + (s + ny * ny * a) * y + ny * z;
		float dz = -s * nx * x - ny * y + nz * z;
		next[0][i] = dx;
		next[1][i] = dy;
		next[2][i] = dz;
		next[3][i] = gx * dx + gy * dy + gz * dz > 0.0f ? z * SHADE_INV_PI : 0.0f;
		lanes->rows_origin[0][i] = position[0][i] + gx * error[i];
		lanes->rows_origin[1][i] = position[1][i] + gy * error[i];
		lanes->rows_origin[2][i] = position[2][i] + gz * error[i];
		lanes->rows_origin[3][i] = 0.0f;
	}
	gi_packet_scatter_all(next, lanes->next, sizeof *lanes->next);
	gi_packet_scatter_all(lanes->rows_origin, lanes->origin, sizeof *lanes->origin);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* What a rectangle is, in rows. */
typedef struct rectangle_rows {
	lanes_row corner[4], normal[4], unit_1[4], unit_2[4];
	lanes_row sizes[4]; /* length_1, length_2, area, error */
} __attribute__((aligned(64))) rectangle_rows;

/* Points of the rectangles as of gi_light_shape_sample: light, and the density. */
GI_LANE void lanes_points(const gi_lanes *lanes, const rectangle_rows *rows, const lanes_row numbers[4],
                          lanes_row light[4], lanes_row pdf)
{
	for (uint32_t i = 0; i < GI_LANES; i++) {
		float cx = rows->corner[0][i] - lanes->rows_origin[0][i], cy = rows->corner[1][i] - lanes->rows_origin[1][i],
			  cz = rows->corner[2][i] - lanes->rows_origin[2][i];
		float ax = rows->unit_1[0][i], ay = rows->unit_1[1][i], az = rows->unit_1[2][i];
		float bx = rows->unit_2[0][i], by = rows->unit_2[1][i], bz = rows->unit_2[2][i];
		float u = numbers[GI_DIMENSION_LIGHT][i], v = numbers[GI_DIMENSION_LIGHT + 1][i], area = rows->sizes[2][i];
		float height = -(cx * rows->normal[0][i] + cy * rows->normal[1][i] + cz * rows->normal[2][i]);
		gi_rectangle_seen seen = gi_rectangle_see(cx * ax + cy * ay + cz * az, cx * bx + cy * by + cz * bz,
		                                          rows->sizes[0][i], rows->sizes[1][i], height);
		int32_t by_angle = gi_rectangle_is_near(&seen, area) & (seen.solid_angle > GI_LIGHT_ANGLE_MIN);
		float x, y;
		gi_rectangle_by_angle(&seen, u, v, &x, &y);
		x = gi_select(by_angle, x, u * rows->sizes[0][i]);
		y = gi_select(by_angle, y, v * rows->sizes[1][i]);
		float dx = cx + ax * x + bx * y, dy = cy + ay * x + by * y, dz = cz + az * x + bz * y;
		float distance = sqrtf(dx * dx + dy * dy + dz * dz), scale = 1.0f / distance;
		float density = gi_select(by_angle, 1.0f / seen.solid_angle, distance * distance * distance / (height * area));
		/* gi_shadow_distance without its asserts: where no light is asked, these are any numbers. */
		float end = distance - (rows->sizes[3][i] + 0x1p-21f * distance) / (height * scale);
		light[0][i] = dx * scale;
		light[1][i] = dy * scale;
		light[2][i] = dz * scale;
		light[3][i] = end > 0.0f ? end : 0.0f;
		pdf[i] = height > 0.0f ? density : INFINITY;
	}
}

static_assert(offsetof(gi_light_shape, length_2) == offsetof(gi_light_shape, length_1) + sizeof(float) &&
                  offsetof(gi_light_shape, area) == offsetof(gi_light_shape, length_1) + 2 * sizeof(float) &&
                  offsetof(gi_light_shape, error) == offsetof(gi_light_shape, length_1) + 3 * sizeof(float),
              "rectangle_rows.sizes are read at once");
static_assert(GI_DIMENSION_LIGHT + 1 < 4 && GI_DIMENSION_DIRECTION + 1 < 4, "of numbers the first four are read");

static void lanes_ask(gi_lanes *lanes)
{
	rectangle_rows rows;
	lanes_row numbers[4], light[4], pdf;
	LANES_GATHER(lanes->shapes, corner, rows.corner);
	LANES_GATHER(lanes->shapes, normal, rows.normal);
	LANES_GATHER(lanes->shapes, unit_1, rows.unit_1);
	LANES_GATHER(lanes->shapes, unit_2, rows.unit_2);
	LANES_GATHER(lanes->shapes, length_1, rows.sizes);
	for (uint32_t first = 0; first < GI_LANES; first += 4)
		lanes_rows(lanes->numbers[first], lanes->numbers[first + 1], lanes->numbers[first + 2],
		           lanes->numbers[first + 3], first, numbers);
	lanes_points(lanes, &rows, numbers, light, pdf);
	for (uint32_t i = 0; i < GI_LANES; i++) {
		float x = light[0][i], y = light[1][i], z = light[2][i];
		float cosine = lanes->rows_normal[0][i] * x + lanes->rows_normal[1][i] * y + lanes->rows_normal[2][i] * z;
		float above =
			lanes->rows_geometric[0][i] * x + lanes->rows_geometric[1][i] * y + lanes->rows_geometric[2][i] * z;
		/* The BRDF is reflectance / pi, `next` has the density cosine / pi; gi_direct_weight. */
		float ratio = cosine * SHADE_INV_PI / (pdf[i] * lanes->chance[i]);
		int32_t counts = (above > 0.0f) & (cosine > 0.0f) & (ratio < INFINITY);
		lanes->weight[i] = counts ? ratio / (1.0f + ratio * ratio) : 0.0f;
	}
	gi_packet_scatter_all(light, lanes->light, sizeof *lanes->light);
}

const gi_lanes_kernels KERNELS = {.leave = lanes_leave, .ask = lanes_ask};

#endif
