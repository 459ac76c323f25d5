/* Inside post/cpu/: the rows of occlusion, for the instruction set of the file that includes this. The names are those
 * of the shaders, which say why each step is as it is. */
#ifndef POST_CPU_OCCLUSION_ROWS_H
#define POST_CPU_OCCLUSION_ROWS_H

#include "post/cpu/post_cpu_lanes.h"
#include "post/cpu/post_cpu_occlusion.h"

#include "base/base.h"

#define SLICES 2
#define STEPS 6
#define LOOKS 2
#define MOST 0.25f
#define PI 3.14159265f

/* Where the middle of a pixel and its depth are, from the camera. */
LANES_INLINE lanes3 rows_place(const occlusion_work *work, lanes x, lanes y, lanes depth)
{
	const float *m = work->from_clip;
	lanes right = x * (2.0f / (float)work->width) - 1.0f, down = y * (2.0f / (float)work->height) - 1.0f;
	lanes w = 1.0f / (m[3] * right + m[7] * down + m[11] * depth + m[15]);
	return (lanes3){(m[0] * right + m[4] * down + m[8] * depth + m[12]) * w,
	                (m[1] * right + m[5] * down + m[9] * depth + m[13]) * w,
	                (m[2] * right + m[6] * down + m[10] * depth + m[14]) * w};
}

/* Depth of pixels with whole coordinates, which are clamped to the picture. */
LANES_INLINE lanes rows_depth(const occlusion_work *work, lanes x, lanes y)
{
	lanes_int column = lanes_to_int(lanes_clamp(x, 0.0f, (float)(work->width - 1)));
	lanes_int row = lanes_to_int(lanes_clamp(y, 0.0f, (float)(work->height - 1)));
	return lanes_gather(work->depth, row * (int32_t)work->width + column);
}

LANES_INLINE lanes3 rows_place_at(const occlusion_work *work, lanes x, lanes y)
{
	return rows_place(work, x + 0.5f, y + 0.5f, rows_depth(work, x, y));
}

LANES_INLINE lanes3 rows_along(const occlusion_work *work, lanes x, lanes y, lanes3 place, float right, float down)
{
	lanes3 after = lanes3_subtract(rows_place_at(work, x + right, y + down), place);
	lanes3 before = lanes3_subtract(place, rows_place_at(work, x - right, y - down));
	return lanes3_select(lanes3_dot(after, after) < lanes3_dot(before, before), after, before);
}

/* What the texels of a slice have in common. */
typedef struct rows_slice {
	lanes x, y; /* whole coordinates of the pixels */
	lanes3 place, view, normal;
	lanes first, reach, share;
} rows_slice;

/* The slice's part on one side of the view's direction; bent: the normal's angle to that side, with its cosine and
 * sine. And what is hidden of it so far. */
typedef struct rows_side {
	lanes step_x, step_y, bent, bent_cos, bent_sin, by_share;
	lanes sum, highest, open;
} rows_side;

/* What lies so far along it: its distance, the angle at which it rises, the integral up to there. */
typedef struct rows_seen {
	lanes_int inside;
	lanes far, angle, left;
} rows_seen;

LANES_INLINE rows_seen rows_look(const occlusion_work *work, const rows_slice *s, const rows_side *side, lanes away)
{
	rows_seen seen;
	lanes x = s->x + lanes_round(side->step_x * away), y = s->y + lanes_round(side->step_y * away);
	seen.inside = (x >= 0.0f) & (y >= 0.0f) & (x < (float)work->width) & (y < (float)work->height);
	lanes depth = lanes_max(rows_depth(work, x, y), lanes_all(work->smallest));
	lanes3 there = lanes3_subtract(rows_place(work, x + 0.5f, y + 0.5f, depth), s->place);
	seen.far = lanes_max(lanes_root(lanes3_dot(there, there)), lanes_all(1e-9f));
	lanes by_far = 1.0f / seen.far, up = lanes_clamp(lanes3_dot(there, s->view) * by_far, -1.0f, 1.0f);
	lanes_int behind = (side->bent < 0.0f) | (up < side->bent_cos);
	lanes from_normal = lanes_clamp(lanes3_dot(there, s->normal) * by_far * side->by_share, -1.0f, 1.0f);
	lanes cosine = lanes_select(behind, from_normal, up), angle = lanes_acos(cosine);
	lanes twice_sin = 2.0f * cosine * lanes_root(1.0f - cosine * cosine);
	/* The cosine of twice the angle less bent. */
	lanes twice =
		side->bent_cos * (2.0f * cosine * cosine - 1.0f) + side->bent_sin * lanes_select(behind, -twice_sin, twice_sin);
	seen.angle = lanes_select(behind, side->bent + angle, angle);
	seen.left = 0.25f * (side->bent_cos + 2.0f * seen.angle * side->bent_sin - twice);
	return seen;
}

/* For those texels that `here` has. */
LANES_INLINE void rows_hide(const occlusion_work *work, rows_side *side, const rows_seen *seen, lanes_int here)
{
	lanes weight = lanes_clamp(1.0f - seen->far * (1.0f / work->radius), 0.0f, 1.0f);
	lanes_int higher = here & (seen->angle < side->highest);
	side->sum += lanes_select(higher, weight * (side->open - seen->left), lanes_all(0.0f));
	side->highest = lanes_select(higher, seen->angle, side->highest);
	side->open = lanes_select(higher, seen->left, side->open);
}

LANES_INLINE lanes rows_hidden(const occlusion_work *work, const rows_slice *s, rows_side *side)
{
	lanes_int inside = {-1, -1, -1, -1, -1, -1, -1, -1};
	lanes before = lanes_all(0.0f);
	side->by_share = 1.0f / s->share;
	side->highest = side->bent + 0.5f * PI;
	side->open = 0.5f * (side->bent_cos + side->highest * side->bent_sin);
	side->sum = before;
	for (int i = 0; i < STEPS; i++) {
		lanes part = ((float)i + s->first) / (float)STEPS;
		lanes away = lanes_max(part * part * s->reach, lanes_all((float)(i + 1))), low = before, high = away;
		rows_seen seen = rows_look(work, s, side, away);
		inside &= seen.inside;
		for (int k = 0; k < LOOKS; k++) {
			lanes_int between = inside & (seen.angle < side->highest) & (high - low > 1.0f);
			if (!lanes_any(between))
				break;
			lanes middle = 0.5f * (low + high);
			rows_seen nearer = rows_look(work, s, side, middle);
			rows_hide(work, side, &nearer, between);
			lanes_int within = nearer.far < work->radius;
			low = lanes_select(within, middle, low);
			high = lanes_select(within, high, middle);
		}
		rows_hide(work, side, &seen, inside);
		before = away;
	}
	return side->sum;
}

/* Visibility in one of the slices of eight texels. */
LANES_INLINE lanes rows_visible(const occlusion_work *work, rows_slice *s, lanes depth, lanes across, lanes down)
{
	lanes3 there = rows_place(work, s->x + 0.5f + across, s->y + 0.5f + down, depth);
	lanes3 tangent = lanes3_subtract(there, s->place);
	tangent = lanes3_unit(lanes3_subtract(tangent, lanes3_scale(s->view, lanes3_dot(tangent, s->view))));
	lanes3 axis = lanes3_cross(tangent, s->view);
	lanes3 projected = lanes3_subtract(s->normal, lanes3_scale(axis, lanes3_dot(s->normal, axis)));
	s->share = lanes_max(lanes_root(lanes3_dot(projected, projected)), lanes_all(1e-6f));
	lanes bent_cos = lanes_clamp(lanes3_dot(projected, s->view) / s->share, 0.0f, 1.0f), bent = lanes_acos(bent_cos);
	lanes bent_sin = lanes_root(1.0f - bent_cos * bent_cos);
	lanes_int other = lanes3_dot(projected, tangent) < 0.0f;
	bent = lanes_select(other, -bent, bent);
	bent_sin = lanes_select(other, -bent_sin, bent_sin);
	rows_side ahead = {.step_x = across, .step_y = down, .bent = bent, .bent_cos = bent_cos, .bent_sin = bent_sin};
	rows_side back = {.step_x = -across, .step_y = -down, .bent = -bent, .bent_cos = bent_cos, .bent_sin = -bent_sin};
	return s->share * (bent_cos + bent * bent_sin - rows_hidden(work, s, &ahead) - rows_hidden(work, s, &back));
}

/* Half turns of the texels of a cell of four times four, and how far their first step goes. */
static const float rows_turns[4][OCCLUSION_LANES] = {
	{0 / 16.0f, 4 / 16.0f, 8 / 16.0f, 12 / 16.0f, 0 / 16.0f, 4 / 16.0f, 8 / 16.0f, 12 / 16.0f},
	{9 / 16.0f, 13 / 16.0f, 1 / 16.0f, 5 / 16.0f, 9 / 16.0f, 13 / 16.0f, 1 / 16.0f, 5 / 16.0f},
	{2 / 16.0f, 6 / 16.0f, 10 / 16.0f, 14 / 16.0f, 2 / 16.0f, 6 / 16.0f, 10 / 16.0f, 14 / 16.0f},
	{11 / 16.0f, 15 / 16.0f, 3 / 16.0f, 7 / 16.0f, 11 / 16.0f, 15 / 16.0f, 3 / 16.0f, 7 / 16.0f}};
static const float rows_firsts[2][OCCLUSION_LANES] = {{0.125f, 0.375f, 0.625f, 0.875f, 0.125f, 0.375f, 0.625f, 0.875f},
                                                      {0.625f, 0.875f, 0.125f, 0.375f, 0.625f, 0.875f, 0.125f, 0.375f}};

/* Repeats the ends of a row. */
static void rows_margins(float *row, uint32_t count)
{
	for (uint32_t i = 0; i < OCCLUSION_MARGIN; i++) {
		row[-1 - (int32_t)i] = row[0];
		row[count + i] = row[count - 1];
	}
}

static void rows_ask(const occlusion_work *work, uint32_t row)
{
	float *asked = work->asked + (size_t)row * work->stride + OCCLUSION_MARGIN;
	float *distance = work->distance + (size_t)row * work->stride + OCCLUSION_MARGIN;
	lanes count = {0, 1, 2, 3, 4, 5, 6, 7}, across[SLICES], down[SLICES];
	for (int i = 0; i < SLICES; i++)
		for (uint32_t lane = 0; lane < OCCLUSION_LANES; lane++) {
			float angle = PI * ((float)i + rows_turns[row & 3][lane]) / (float)SLICES;
			across[i][lane] = cosf(angle);
			down[i][lane] = sinf(angle);
		}
	rows_slice s = {.first = lanes_load(rows_firsts[row & 1])};
	s.y = lanes_all((float)(2 * row < work->height ? 2 * row : work->height - 1));
	for (uint32_t texel = 0; texel < work->half_width; texel += OCCLUSION_LANES) {
		s.x = lanes_min(2.0f * ((float)texel + count), lanes_all((float)(work->width - 1)));
		lanes depth = rows_depth(work, s.x, s.y), middle_x = s.x + 0.5f, middle_y = s.y + 0.5f;
		lanes_int something = depth >= work->smallest;
		lanes visible = lanes_all(1.0f), far = lanes_all(65504.0f);
		if (lanes_any(something)) {
			lanes safe = lanes_max(depth, lanes_all(work->smallest));
			s.place = rows_place(work, middle_x, middle_y, safe);
			s.view = lanes3_unit(lanes3_subtract(rows_place(work, middle_x, middle_y, lanes_all(1.0f)), s.place));
			lanes3 beside = lanes3_subtract(rows_place(work, middle_x + 1.0f, middle_y, safe), s.place);
			lanes metres = lanes_root(lanes3_dot(beside, beside));
			s.reach = lanes_min(work->radius / metres, lanes_all(MOST * (float)work->height));
			far = lanes_select(something, lanes_min(lanes_root(lanes3_dot(s.place, s.place)), far), far);
			lanes3 normal = lanes3_unit(lanes3_cross(rows_along(work, s.x, s.y, s.place, 0.0f, 1.0f),
			                                         rows_along(work, s.x, s.y, s.place, 1.0f, 0.0f)));
			s.normal = lanes3_select(lanes3_dot(normal, s.view) < 0.0f, lanes3_scale(normal, lanes_all(-1.0f)), normal);
			lanes sum = lanes_all(0.0f);
			for (int i = 0; i < SLICES; i++)
				sum += rows_visible(work, &s, safe, across[i], down[i]);
			visible = lanes_select(something & (s.reach >= 1.0f), sum / (float)SLICES, visible);
		}
		lanes_store(visible, asked + texel);
		lanes_store(far, distance + texel);
	}
	rows_margins(asked, work->half_width);
	rows_margins(distance, work->half_width);
}

/* By how much distance changes from a texel to the next, on that side on which it changes less. */
LANES_INLINE lanes rows_slope(lanes before, lanes here, lanes after)
{
	lanes next = after - here, last = here - before;
	return lanes_select(lanes_abs(next) < lanes_abs(last), next, last);
}

LANES_INLINE uint32_t rows_clamp(int64_t row, uint32_t count)
{
	return row < 0 ? 0 : row >= count ? count - 1 : (uint32_t)row;
}

static void rows_smooth(const occlusion_work *work, uint32_t row)
{
	const float *asked[4], *distance[4]; /* of the rows from two above to the one below */
	for (int i = 0; i < 4; i++) {
		size_t at = (size_t)rows_clamp((int64_t)row - 2 + i, work->half_height) * work->stride + OCCLUSION_MARGIN;
		asked[i] = work->asked + at;
		distance[i] = work->distance + at;
	}
	float *smooth = work->smooth + (size_t)row * work->stride + OCCLUSION_MARGIN;
	for (uint32_t texel = 0; texel < work->half_width; texel += OCCLUSION_LANES) {
		const float *own = distance[2] + texel;
		lanes here = lanes_load(own);
		lanes across = rows_slope(lanes_load(own - 1), here, lanes_load(own + 1));
		lanes down = rows_slope(lanes_load(distance[1] + texel), here, lanes_load(distance[3] + texel));
		lanes sum = lanes_all(0.0f), weights = sum;
		for (int y = 0; y < 4; y++)
			for (int x = -2; x < 2; x++) {
				lanes rise = across * (float)x + down * (float)(y - 2);
				lanes off = lanes_abs(lanes_load(distance[y] + texel + x) - here - rise) /
				            (0.02f * here + 0.5f * lanes_abs(rise));
				lanes weight = lanes_max(1.0f - off, lanes_all(0.0f));
				sum += weight * lanes_load(asked[y] + texel + x);
				weights += weight;
			}
		lanes visible = lanes_select(weights > 0.0f, sum / weights, lanes_load(asked[2] + texel));
		lanes_store(visible, smooth + texel);
	}
	rows_margins(smooth, work->half_width);
}

static void rows_share(const occlusion_work *work, uint32_t row, float *shares)
{
	static const lanes_int one = {1, 1, 1, 1, 1, 1, 1, 1};
	lanes count = {0, 1, 2, 3, 4, 5, 6, 7}, y = lanes_all((float)row + 0.5f);
	uint32_t rows[2] = {row / 2, rows_clamp((int64_t)(row + 1) / 2, work->half_height)};
	for (uint32_t pixel = 0; pixel < work->width; pixel += OCCLUSION_LANES) {
		lanes x = lanes_min((float)pixel + count, lanes_all((float)(work->width - 1)));
		lanes depth = lanes_gather(work->depth + (size_t)row * work->width, lanes_to_int(x));
		lanes3 place = rows_place(work, x + 0.5f, y, lanes_max(depth, lanes_all(work->smallest)));
		lanes here = lanes_root(lanes3_dot(place, place)), sum = lanes_all(0.0f), weights = sum;
		lanes_int columns[2] = {lanes_to_int(x) >> 1,
		                        (lanes_to_int(x) + one) >> 1}; /* the second may be in the margin */
		for (int i = 0; i < 4; i++) {
			size_t first = (size_t)rows[i >> 1] * work->stride + OCCLUSION_MARGIN;
			lanes off = lanes_abs(lanes_gather(work->distance + first, columns[i & 1]) - here) / (0.01f * here);
			lanes weight = 1.0f / (0.01f + off * off);
			sum += weight * lanes_gather(work->smooth + first, columns[i & 1]);
			weights += weight;
		}
		lanes open = lanes_min(sum / weights, lanes_all(1.0f));
		lanes share = (1.0f - work->strength) + work->strength * open;
		lanes_store(lanes_select(depth < work->smallest, lanes_all(1.0f), share), shares + pixel);
	}
}

#endif
