/*
 * Which level of a mesh is drawn, and how far a transition has come. Inside render/.
 *
 * Sizes.    The nearest point of a model's sphere is `near` metres from the camera, where a metre takes pixels / near
 *           pixels. A level whose error is e metres in its mesh's space, in a part whose transform stretches by at most
 *           s, may be drawn if e s pixels / near <= error. Both sides are squared: e^2 s^2 <= room, with
 *           room = (near error / pixels)^2, which is computed once a model, four models at a time.
 * History.  16 bits a part: bits 0..5 1 + the level that is drawn, bits 6..11 1 + the level that gives way to it, bits
 *           12..15 in how many sixteenths of the pixels it is drawn already; 0 in both if nothing fades, and 0 in all
 *           if the part was never drawn. Of a part that morphs RENDER_DETAIL_PLACE plus its place
 *           (render_detail_follow), which none of the others can be. Each is written by the worker that records the
 *           part.
 * Impostors. A model that has one is drawn as it, in place of its parts, from where STILB_SCENE_IMPOSTOR_TEXELS texels
 *           of its pictures are a pixel wide or less. 8 bits a model: IMPOSTOR_MESHES or IMPOSTOR_ALONE; or
 *           IMPOSTOR_COMING or IMPOSTOR_GOING plus in how many sixteenths of the pixels what comes is drawn; 0: never
 *           drawn.
 * Row word. What the shaders get to know of it rides above the row's number in the word that the GPU reads as
 *           firstInstance: see RENDER_DETAIL_SHIFT.
 */
#ifndef STILB_RENDER_DETAIL_H
#define STILB_RENDER_DETAIL_H

#include "render/render_internal.h"

#include <math.h>

/* What is the same for all models of a pass. */
typedef struct render_detail_view {
	stilb_render_detail_mode mode;
	bool shows;        /* levels, in colours */
	float position[3]; /* of the camera */
	float near;        /* metres, of the near plane, > 0 */
	float scale;       /* (error / pixels)^2 */
	float constant;    /* > 0: the room of all models, of a view without perspective */
	float error2;      /* the square of the error, pixels */
} render_detail_view;

/* The view's camera and bound for a picture of this size. */
render_detail_view render_detail_view_make(const stilb_render_view *view, uint32_t width, uint32_t height);

/* Room of models ids[0 .. count - 1]. [any-thread] */
void render_detail_rooms(const render_detail_view *view, const stilb_scene_bounds *bounds, const uint32_t *ids,
                         uint32_t count, float *rooms);
/* The same, one by one, for tests. */
void render_detail_rooms_scalar(const render_detail_view *view, const stilb_scene_bounds *bounds, const uint32_t *ids,
                                uint32_t count, float *rooms);

/* The next history of a part that is not at rest in level `allowed`, the coarsest one that may be drawn. stretch: s^2.
 * [any-thread] */
uint16_t render_detail_step(uint16_t history, stilb_render_detail_mode mode, const render_levels *levels,
                            uint32_t allowed, float stretch, float room);

enum { IMPOSTOR_MESHES = 1, IMPOSTOR_ALONE = 2, IMPOSTOR_COMING = 16, IMPOSTOR_GOING = 32 };

/* The next history of a model. side: of the impostor's pictures; radius: of the model's bounding sphere.
 * [any-thread] */
uint8_t render_detail_impostor(uint8_t history, const render_detail_view *view, uint32_t side, float radius,
                               float room);

#define RENDER_DETAIL_PACE 4    /* 64ths of a level by which a morph goes on in a frame at most */
#define RENDER_DETAIL_PLACE 128 /* more than 64 above the history of any level at rest */
static_assert(RENDER_DETAIL_PLACE >= STILB_SCENE_MAX_LEVELS + 1 + 64, "no place is near one at rest");
static_assert(RENDER_DETAIL_PLACE + 64 * STILB_SCENE_MAX_LEVELS + 64 < 1 << 12, "or near one that fades");

/* The history of a part at rest in a level. */
static inline uint16_t render_detail_rest(uint32_t level)
{
	return (uint16_t)(level + 1);
}

static inline bool render_detail_fades(uint16_t history)
{
	return history >> 12;
}

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* Number of the levels' errors that are at most sqrt(room / stretch): the coarsest level that may be drawn. */
static inline uint32_t render_detail_allowed(const render_levels *levels, float stretch, float room)
{
	const float *squared = render_levels_squared(levels);
	uint32_t allowed = 0;
#if defined(__SSE2__)
	__m128 s = _mm_set1_ps(stretch), most = _mm_set1_ps(room);
	for (; allowed < 4 * levels->groups; allowed += 4) {
		uint32_t fit = (uint32_t)_mm_movemask_ps(_mm_cmple_ps(_mm_mul_ps(_mm_load_ps(squared + allowed), s), most));
		if (fit != 15)
			return allowed + (uint32_t)__builtin_ctz(~fit); /* errors ascend, so the set bits are the lowest */
	}
#else
	while (allowed < levels->count && squared[allowed] * stretch <= room)
		allowed++;
#endif
	return allowed;
}

/* How far a part that may be drawn in level `allowed` should have morphed to the next one, in 64ths; 0: not at all. It
 * begins where the next one's error is twice what is allowed, or where the level itself begins if that is nearer, and
 * ends where the next one's is allowed. In between it goes by the logarithm of the distance, so that it takes 70 frames
 * when the distance grows by 1 % in each. The bits of a float are a logarithm in straight pieces, which costs no root;
 * with it one frame's step is at most 1/50. Where the next one's error is x times what is allowed, what
 * is drawn is off by at most x (1 - log2 x) times that, which is at most once. inverse: 1 / room. Compilers make
 * branches of plain C, which nobody could predict (measured: 8 ns a part). */
static inline uint32_t render_detail_morph(const render_levels *levels, uint32_t allowed, float stretch, float inverse)
{
	const render_morph *morph = &render_levels_begins(levels)[allowed];
	/* > 1, or the level would be allowed; infinite if there is no next one. */
	float square = render_levels_squared(levels)[allowed] * stretch * inverse;
#if defined(__SSE2__)
	int32_t bits = _mm_cvtsi128_si32(_mm_castps_si128(_mm_set_ss(square)));
	float gone = (float)(morph->begin - bits) * morph->pace;
	return (uint32_t)_mm_cvttss_si32(_mm_min_ss(_mm_max_ss(_mm_set_ss(gone), _mm_setzero_ps()), _mm_set_ss(63.0f)));
#else
	int32_t bits;
	memcpy(&bits, &square, sizeof bits);
	float gone = (float)(morph->begin - bits) * morph->pace;
	gone = gone > 0.0f ? gone : 0.0f;
	return (uint32_t)(gone < 63.0f ? gone : 63.0f);
#endif
}

/* The next place of a part that morphs, 64 times its level plus the 64ths that it has gone on from there, and its
 * history. target: the place where it belongs. At most a sixteenth of a level a frame; from a level away or more, where
 * another view begins, or if it was never drawn or not morphed, at once. Without branches, as above. */
static inline uint32_t render_detail_follow(uint16_t *history, uint32_t most, uint32_t target)
{
	int32_t place = (int32_t)*history - RENDER_DETAIL_PLACE, way = (int32_t)target - place, step = way;
	step = step < RENDER_DETAIL_PACE ? step : RENDER_DETAIL_PACE;
	step = step > -RENDER_DETAIL_PACE ? step : -RENDER_DETAIL_PACE;
	int32_t next = (uint32_t)(way + 63) < 127 ? place + step : (int32_t)target;
	next = next < (int32_t)most ? next : (int32_t)most; /* of a mesh that had more levels */
	*history = (uint16_t)(next + RENDER_DETAIL_PLACE);
	return (uint32_t)next;
}

#endif
