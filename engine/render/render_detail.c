/* The choice of levels, by projected error. See render_detail.h. */
#include "render/render_detail.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the view ---------------------------------------------------------------------------------------------------- */

static float detail_length(const stilb_mat4 *m, int row)
{
	float x = m->m[row], y = m->m[4 + row], z = m->m[8 + row];
	return sqrtf(x * x + y * y + z * z);
}

/* Distance of the near plane along the camera's axis, where the depth is 1: there row 2 of the matrix is row 3. */
static float detail_near(const stilb_mat4 *m, const float position[3], float w_length)
{
	float along = 0.0f, depth = m->m[14];
	for (int i = 0; i < 3; i++) {
		along += m->m[4 * i + 2] * m->m[4 * i + 3];
		depth += m->m[4 * i + 2] * position[i];
	}
	float near = depth / (w_length - along / w_length);
	return near > 1e-6f && isfinite(near) ? near : 1e-6f;
}

render_detail_view render_detail_view_make(const stilb_render_view *view, uint32_t width, uint32_t height)
{
	const stilb_mat4 *m = &view->view_projection;
	float w = detail_length(m, 3);
	float pixels = fmaxf(render_view_scale(m, 0) * (float)width, render_view_scale(m, 1) * (float)height) * 0.5f;
	render_detail_view out = {.mode = view->detail.mode, .shows = view->show == STILB_RENDER_SHOW_LEVELS};
	if (out.mode == STILB_RENDER_DETAIL_OFF && !out.shows)
		return out;
	if (out.mode == STILB_RENDER_DETAIL_OFF) /* no level but the mesh in full has any room */
		return (render_detail_view){
			.mode = STILB_RENDER_DETAIL_POP, .shows = true, .near = 1.0f, .scale = -1.0f, .constant = 0.0f};
	STILB_ASSERT(view->detail.error > 0.0f && pixels > 0.0f);
	if (out.shows)
		out.mode = STILB_RENDER_DETAIL_POP;
	float meters = view->detail.error / pixels; /* of a pixel row, with perspective at a distance of 1 m */
	memcpy(out.position, view->camera_position, sizeof out.position);
	out.error2 = view->detail.error * view->detail.error;
	out.scale = meters * w * meters * w;
	out.near = w > 0.0f ? detail_near(m, out.position, w) : 0.0f;
	out.constant = w > 0.0f ? 0.0f : meters * meters;
	return out;
}

/* ---- room -------------------------------------------------------------------------------------------------------- */

void render_detail_rooms_scalar(const render_detail_view *view, const stilb_scene_bounds *bounds, const uint32_t *ids,
                                uint32_t count, float *rooms)
{
	for (uint32_t i = 0; i < count; i++) {
		uint32_t m = ids[i];
		float x = bounds->x[m] - view->position[0], y = bounds->y[m] - view->position[1];
		float z = bounds->z[m] - view->position[2], d = sqrtf(x * x + y * y + z * z) - bounds->radius[m];
		d = d > view->near ? d : view->near; /* also for a NaN */
		rooms[i] = view->constant > 0.0f ? view->constant : d * d * view->scale;
	}
}

#if defined(__SSE2__)
/* Four components by id; ids that follow one another, as most do, are one load. */
static inline __m128 detail_gather(const float *values, const uint32_t *ids)
{
	return _mm_set_ps(values[ids[3]], values[ids[2]], values[ids[1]], values[ids[0]]);
}

static inline __m128 detail_rooms_of(const render_detail_view *view, __m128 x, __m128 y, __m128 z, __m128 radius)
{
	x = _mm_sub_ps(x, _mm_set1_ps(view->position[0]));
	y = _mm_sub_ps(y, _mm_set1_ps(view->position[1]));
	z = _mm_sub_ps(z, _mm_set1_ps(view->position[2]));
	__m128 square = _mm_add_ps(_mm_add_ps(_mm_mul_ps(x, x), _mm_mul_ps(y, y)), _mm_mul_ps(z, z));
	__m128 d = _mm_max_ps(_mm_sub_ps(_mm_sqrt_ps(square), radius), _mm_set1_ps(view->near));
	return _mm_mul_ps(_mm_mul_ps(d, d), _mm_set1_ps(view->scale));
}

void render_detail_rooms(const render_detail_view *view, const stilb_scene_bounds *bounds, const uint32_t *ids,
                         uint32_t count, float *rooms)
{
	uint32_t i = 0;
	for (; i + 4 <= count && view->constant == 0.0f; i += 4) {
		const uint32_t *four = ids + i;
		uint32_t m = four[0];
		__m128 out = four[3] - m == 3 && four[1] - m == 1 && four[2] - m == 2
		                 ? detail_rooms_of(view, _mm_loadu_ps(bounds->x + m), _mm_loadu_ps(bounds->y + m),
		                                   _mm_loadu_ps(bounds->z + m), _mm_loadu_ps(bounds->radius + m))
		                 : detail_rooms_of(view, detail_gather(bounds->x, four), detail_gather(bounds->y, four),
		                                   detail_gather(bounds->z, four), detail_gather(bounds->radius, four));
		_mm_storeu_ps(rooms + i, out);
	}
	render_detail_rooms_scalar(view, bounds, ids + i, count - i, rooms + i);
}
#else
void render_detail_rooms(const render_detail_view *view, const stilb_scene_bounds *bounds, const uint32_t *ids,
                         uint32_t count, float *rooms)
{
	render_detail_rooms_scalar(view, bounds, ids, count, rooms);
}
#endif

/* ---- transitions ------------------------------------------------------------------------------------------------- */

#define DETAIL_BACK 1.2345679f /* (1 / 0.9)^2: a coarser level must fit into nine tenths of the error */
#define DETAIL_CUT                                                                                                     \
	16.0f /* 4^2: a level with an error of four times the bound belongs to another view; it gives way at once */

static uint16_t detail_history(uint32_t level, uint32_t from, uint32_t sixteenths)
{
	STILB_ASSERT(level <= STILB_SCENE_MAX_LEVELS && from <= STILB_SCENE_MAX_LEVELS && sixteenths >= 1 &&
	             sixteenths < STILB_RENDER_FADE_FRAMES);
	return (uint16_t)((level + 1) | (from + 1) << 6 | sixteenths << 12);
}

/* A part that fades to `level` goes on, or turns back if the level that gives way is wanted again. */
static uint16_t detail_go_on(uint32_t level, uint32_t from, uint32_t sixteenths, uint32_t wanted)
{
	bool back = wanted == from;
	uint32_t next = (back ? STILB_RENDER_FADE_FRAMES - sixteenths : sixteenths) + 1;
	uint32_t to = back ? from : level;
	return next < STILB_RENDER_FADE_FRAMES ? detail_history(to, back ? level : from, next) : render_detail_rest(to);
}

uint16_t render_detail_step(uint16_t history, stilb_render_detail_mode mode, const render_levels *levels,
                            uint32_t allowed, float stretch, float room)
{
	uint32_t level = (history & 63u) - 1, from = (history >> 6 & 63u) - 1, sixteenths = history >> 12;
	bool fades = render_detail_fades(history);
	if (!fades && history >= RENDER_DETAIL_PLACE) /* it has morphed until now */
		level = (history - RENDER_DETAIL_PLACE) / 64u;
	/* Never drawn before, or another mesh's. */
	if (level > levels->count || (fades && from > levels->count))
		return render_detail_rest(allowed);
	const float *squared = render_levels_squared(levels);
	uint32_t sure = render_detail_allowed(levels, stretch * DETAIL_BACK, room);
	uint32_t wanted = level < sure ? sure : level > allowed ? allowed : level;
	bool cut = level > 0 && squared[level - 1] * stretch > room * DETAIL_CUT;
	if (mode == STILB_RENDER_DETAIL_POP || cut)
		return render_detail_rest(wanted);
	if (fades)
		return detail_go_on(level, from, sixteenths, wanted);
	return wanted == level ? render_detail_rest(level) : detail_history(wanted, level, 1);
}

/* ---- impostors --------------------------------------------------------------------------------------------------- */

uint8_t render_detail_impostor(uint8_t history, const render_detail_view *view, uint32_t side, float radius, float room)
{
	/* The square of the pixels that so many texels are wide, times the square of the allowed error: so far the
	 * model is away where it is the room. */
	float texels = 2.0f * radius * STILB_SCENE_IMPOSTOR_TEXELS / (float)side, square = texels * texels * view->error2;
	bool may = square <= room, must_not = !may, sure = square * DETAIL_BACK <= room;
	bool was = history == IMPOSTOR_ALONE || (history > IMPOSTOR_COMING && history < IMPOSTOR_GOING);
	bool wanted = history == 0 ? may : was ? !must_not : sure;
	uint8_t rest = wanted ? IMPOSTOR_ALONE : IMPOSTOR_MESHES;
	bool cut = square > room * DETAIL_CUT;
	if (history == 0 || cut || view->mode == STILB_RENDER_DETAIL_POP || history == rest)
		return rest;
	/* Of one that fades and turns back, what comes is now in the rest of the pixels. */
	uint32_t done = history < IMPOSTOR_COMING ? 0 : history % 16u;
	done = done > 0 && was != wanted ? STILB_RENDER_FADE_FRAMES - done : done;
	uint8_t direction = wanted ? IMPOSTOR_COMING : IMPOSTOR_GOING;
	return done + 1 < STILB_RENDER_FADE_FRAMES ? (uint8_t)(direction + done + 1) : rest;
}
