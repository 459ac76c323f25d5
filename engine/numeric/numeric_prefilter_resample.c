/* Mip 0 of a prefiltered cube: a panorama's texels spread over the cube's, band by band.
 *
 * A part of a panorama's texel is shared out to the texels of a face around it, each of its points as bilinear
 * interpolation would weigh them, and a texel is the mean of what it was given: no light is lost, however small its
 * source. Parts are at most half a texel of a face's middle wide. A band of rows of a face looks for its parts row by
 * row of the panorama: there they lie in a range of longitudes to both sides of the face's axis. */
#include "numeric/numeric_prefilter_internal.h"

#include "shading/shade_environment.h"

#include <string.h>

#define BAND_GROUP_MAX 16u /* texels of a panorama along a side that count as one part */

uint32_t numeric_prefilter_band_rows(uint32_t face)
{
	uint32_t rows = PREFILTER_BAND_TEXELS / face;
	return rows < face ? rows : face;
}

void numeric_prefilter_make_columns(stilb_numeric_prefilter *work)
{
	for (uint32_t k = 0; k < work->parts_across; k++) {
		double angle = 2.0 * M_PI * (k + 0.5) / work->parts_across;
		work->columns[k] = (prefilter_turn){(float)cos(angle), (float)sin(angle)};
	}
}

/* ---- which parts ------------------------------------------------------------------------------------------------- */

typedef struct band {
	uint32_t number, side, first, rows; /* of the face; texels */
	uint32_t across, down;              /* parts of the whole panorama */
	double low, high, reach;            /* between which t lies, and how far |s|: 1.5 texels beyond the band */
	double axis;                        /* longitude, from the panorama's left side */
	float angle_across, angle_down;     /* of a part */
	bool narrow;                        /* a part is less than a quarter of a texel of the face's middle: a point */
	stilb_vec4 *sums;                   /* [rows][side] */
} band;

/* Offsets of longitude from the face's axis; none if end < begin. */
typedef struct band_range {
	double begin, end;
} band_range;

/* On +Y and -Y, where the ring at this angle from the pole is the circle t = -tan(angle) cos(offset). */
static band_range range_on_pole(const band *b, double theta)
{
	double tangent = tan(b->number == 2 ? theta : M_PI - theta);
	if (cos(theta) * (b->number == 2 ? 1.0 : -1.0) <= 0.0 || tangent > 1.4143 * b->reach)
		return (band_range){1.0, 0.0};
	double begin = -b->low / tangent, end = -b->high / tangent;
	if (begin < -1.0 || end > 1.0)
		return (band_range){1.0, 0.0};
	return (band_range){acos(fmin(begin, 1.0)), acos(fmax(end, -1.0))};
}

/* On the other faces, where the ring is t = -cot(theta) q with q = 1 / cos(offset). */
static band_range range_on_side(const band *b, double theta)
{
	double cotangent = cos(theta) / sin(theta), most = sqrt(1.0 + b->reach * b->reach), begin = 1.0, end = most;
	if (fabs(cotangent) > 1e-9) {
		double low = -b->low / cotangent, high = -b->high / cotangent;
		begin = fmax(begin, fmin(low, high));
		end = fmin(end, fmax(low, high));
	} else if (b->low > 0.0 || b->high < 0.0) {
		return (band_range){1.0, 0.0};
	}
	if (end < begin)
		return (band_range){1.0, 0.0};
	return (band_range){acos(1.0 / begin), acos(1.0 / end)};
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Integral of the weights of bilinear interpolation, 1 - |x|, up to x. */
static float band_tent(float x)
{
	float rest = 1.0f - fminf(fabsf(x), 1.0f), tail = 0.5f * rest * rest;
	return x < 0.0f ? tail : 1.0f - tail;
}

/* The texels first to first + 2 along a side, and what they get of a part. */
typedef struct band_share {
	int first;
	float share[3];
} band_share;

/* Of a part of this width, at most 1 texel, about `at`, texels from the middle of the first one. */
static band_share band_share_of(float at, float width)
{
	float low = at - 0.5f * width, high = at + 0.5f * width, first = ceilf(low - 1.0f), scale = 1.0f / width;
	band_share of = {(int)first, {0}};
	for (int i = 0; i < 3; i++)
		of.share[i] = (band_tent(high - first - (float)i) - band_tent(low - first - (float)i)) * scale;
	return of;
}

/* Of a part without width. */
static band_share band_share_of_point(float at)
{
	float first = floorf(at);
	return (band_share){(int)first, {first + 1.0f - at, at - first, 0.0f}};
}

static void band_add(const band *b, band_share x, band_share y, stilb_vec4 value)
{
	for (int i = 0; i < 3; i++) {
		int row = y.first + i - (int)b->first;
		if (row < 0 || row >= (int)b->rows)
			continue;
		stilb_vec4 *sums = b->sums + (size_t)row * b->side, part = value * y.share[i];
		for (int k = 0; k < 3; k++)
			if (x.first + k >= 0 && x.first + k < (int)b->side)
				sums[x.first + k] += part * x.share[k];
	}
}

/* Squares of the sides of a box that has the same spread along s and t as a part of these angles has, whose own sides
 * are not along s and t. */
typedef struct band_box {
	float s2, t2;
} band_box;

static band_box band_box_of(shade_cube_place at, float across, float down)
{
	float s2 = at.s * at.s, t2 = at.t * at.t, across2 = across * across, down2 = down * down;
	if (at.face == 2 || at.face == 3) {
		float r2 = s2 + t2, along2 = down2 * (1.0f + r2) * (1.0f + r2) / fmaxf(r2, 1e-12f);
		return (band_box){along2 * s2 + across2 * t2, along2 * t2 + across2 * s2};
	}
	float q2 = 1.0f + s2, long2 = (q2 + t2) * (q2 + t2);
	return (band_box){across2 * q2 * q2, down2 * long2 / q2 + across2 * s2 * t2};
}

static void band_add_part(const band *b, shade_cube_place at, stilb_vec4 value)
{
	float half = 0.5f * (float)b->side;
	if (b->narrow) {
		band_add(b, band_share_of_point((at.s + 1.0f) * half - 0.5f), band_share_of_point((at.t + 1.0f) * half - 0.5f),
		         value);
		return;
	}
	band_box box = band_box_of(at, b->angle_across * half, b->angle_down * half);
	float wide = fminf(fmaxf(sqrtf(box.s2), 1e-3f), 1.0f), high = fminf(fmaxf(sqrtf(box.t2), 1e-3f), 1.0f);
	band_add(b, band_share_of((at.s + 1.0f) * half - 0.5f, wide), band_share_of((at.t + 1.0f) * half - 0.5f, high),
	         value);
}

/* Where a direction lies in the plane of a face, also beyond its sides. */
static shade_cube_place band_place(int face, float x, float y, float z)
{
	static const int normal[6] = {0, 0, 1, 1, 2, 2};
	float d[3] = {x, y, z}, scale = 1.0f / fabsf(d[normal[face]]), side = face % 2 == 0 ? 1.0f : -1.0f;
	if (face < 2)
		return (shade_cube_place){face, -side * z * scale, -y * scale};
	if (face < 4)
		return (shade_cube_place){face, x * scale, side * z * scale};
	return (shade_cube_place){face, side * x * scale, -y * scale};
}

/* The texels of a part, in rows with their weights. */
typedef struct band_group {
	uint32_t top, rows, columns; /* of the panorama */
	uint32_t parts;              /* of a column, where columns is 1 */
	float solid[BAND_GROUP_MAX]; /* of a row, over the longitude's share */
} band_group;

static band_group band_group_of(const band *b, const stilb_image *map, uint32_t row)
{
	band_group group = {.rows = map->height > b->down ? map->height / b->down : 1,
	                    .columns = map->width > b->across ? map->width / b->across : 1,
	                    .parts = map->width > b->across ? 1 : b->across / map->width};
	group.top = map->height > b->down ? row * group.rows : row / (b->down / map->height);
	double below = cos(M_PI * row / b->down);
	for (uint32_t i = 0; i < group.rows; i++) {
		double above = below;
		below = cos(M_PI * (row + (i + 1.0) / group.rows) / b->down);
		group.solid[i] = (float)(above - below) / (float)group.columns;
	}
	return group;
}

static stilb_vec4 band_group_light(const stilb_numeric_prefilter *work, const band_group *group, uint32_t part)
{
	stilb_vec4 sum = {0.0f, 0.0f, 0.0f, 0.0f};
	uint32_t left = group->parts == 1 ? part * group->columns : part / group->parts;
	for (uint32_t i = 0; i < group->rows; i++)
		for (uint32_t k = 0; k < group->columns; k++)
			sum += numeric_prefilter_texel(work, &work->source[0], left + k, group->top + i) * group->solid[i];
	return sum;
}

/* Adds parts first to last - 1 of a row of parts; numbers beyond the panorama's sides go on at the other one. */
static void band_add_parts(const stilb_numeric_prefilter *work, const band *b, uint32_t row, int32_t first,
                           int32_t last)
{
	band_group group = band_group_of(b, &work->source[0], row);
	double theta = M_PI * (row + 0.5) / b->down;
	float sine = (float)sin(theta), cosine = (float)cos(theta);
	for (int32_t part = first; part < last; part++) {
		uint32_t column = (uint32_t)(part + (int32_t)b->across) % b->across;
		prefilter_turn turn = work->columns[column]; /* of the longitude from the panorama's left side, +Z */
		band_add_part(b, band_place((int)b->number, -sine * turn.im, cosine, sine * turn.re),
		              band_group_light(work, &group, column));
	}
}

static int32_t limited(double number, int32_t low, int32_t high)
{
	return number < low ? low : number > high ? high : (int32_t)number;
}

static void band_add_row(const stilb_numeric_prefilter *work, const band *b, uint32_t row)
{
	double theta = M_PI * (row + 0.5) / b->down, step = 2.0 * M_PI / b->across;
	band_range range = b->number == 2 || b->number == 3 ? range_on_pole(b, theta) : range_on_side(b, theta);
	if (range.end < range.begin)
		return;
	/* The first part right of the axis, and how many there are on a side at most. */
	int32_t middle = (int32_t)ceil(b->axis / step - 0.5), half = (int32_t)(b->across / 2);
	int32_t near = limited(range.begin / step - 2.0, 0, half), far = limited(range.end / step + 2.0, 0, half);
	band_add_parts(work, b, row, middle + near, middle + far);
	band_add_parts(work, b, row, middle - far, middle - near);
}

/* ---- bands ------------------------------------------------------------------------------------------------------- */

/* An even number of parts of so many texels, `least` or more: several of a texel; or one of several texels, if there
 * are twice as many still. */
static uint32_t band_parts(uint32_t texels, uint32_t least)
{
	uint32_t most = texels / (2 * least);
	for (uint32_t each = most < BAND_GROUP_MAX ? most : BAND_GROUP_MAX; each > 1; each--)
		if (texels % (2 * each) == 0)
			return texels / each;
	uint32_t each = (least + texels - 1) / texels;
	return texels * (each + (texels % 2 == 1 && each % 2 == 1));
}

/* The middle of a face has texels of 2 / side radians. */
uint32_t numeric_prefilter_parts(uint32_t texels, uint32_t face, bool across)
{
	return band_parts(texels, (across ? 2 : 1) * (face * 15 / 4));
}

void numeric_prefilter_resample(const stilb_numeric_prefilter *work, uint32_t number, uint32_t first, stilb_vec4 *sums)
{
	uint32_t side = work->settings.face, rows = numeric_prefilter_band_rows(side);
	static const double axes[6] = {1.5 * M_PI, 0.5 * M_PI, M_PI, 0.0, 0.0, M_PI};
	double texel = 2.0 / side, top = first * texel - 1.0;
	band b = {.number = number,
	          .side = side,
	          .first = first,
	          .rows = rows,
	          .across = work->parts_across,
	          .down = numeric_prefilter_parts(work->source[0].height, side, false),
	          .low = top - 1.5 * texel,
	          .high = top + (rows + 1.5) * texel,
	          .reach = 1.0 + 1.5 * texel,
	          .axis = axes[number],
	          .sums = sums};
	b.angle_across = (float)(2.0 * M_PI / b.across);
	b.angle_down = (float)(M_PI / b.down);
	b.narrow = fmaxf(b.angle_across, b.angle_down) * (float)side < 0.5f;
	memset(sums, 0, (size_t)rows * side * sizeof *sums);
	for (uint32_t row = 0; row < b.down; row++)
		band_add_row(work, &b, row);
}
