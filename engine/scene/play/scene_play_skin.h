/*
 * scene_play_skin: carries vertices with joints, eight at a time, on vectors of the compiler's, so that every
 * instruction set makes the same bits of it. Inside play/; included by one file for each instruction set.
 *
 * A vertex goes by the sum of weight * joint over its influences, a matrix of three rows. Its normal goes by the
 * inverse transpose of that, up to a positive factor: the cofactors, with the sign of the determinant. Both are made
 * unit; a direction that comes to nothing stays what it was at rest.
 */
#ifndef STILB_SCENE_PLAY_SKIN_H
#define STILB_SCENE_PLAY_SKIN_H

#include "scene/scene.h"

#include <math.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define PLAY_LANES 8u

/* A joint: the first three rows of its matrix, whose last one is 0 0 0 1. */
typedef struct play_rows {
	float m[12];
} play_rows;

/* Vertices to carry. Streams hold a number of each vertex, and can be read to the end of the last eight. */
typedef struct play_skin {
	const float *position[3], *normal[3], *uv[2];
	const float *tangent[4]; /* NULL: there are none */
	const play_rows *joints; /* of the skin; NULL: the vertices stay where they are */
	const uint32_t *starts;  /* [eights + 1] where the joints of each eight vertices begin; one at least */
	const uint16_t *indices; /* [starts[eights]] these joints */
	const float *weights;    /* [starts[eights]][8] what each weighs for the eight; their sum is 1 */
	uint32_t count;
	stilb_scene_vertex *vertices;     /* [count] out */
	stilb_scene_vertex_extra *extras; /* [count] out: the tangents alone */
	float low[3], high[3];            /* out: their box */
} play_skin;

typedef void play_skin_fn(play_skin *skin);
extern play_skin_fn *const scene_play_skin_avx2; /* NULL: not for this architecture */
play_skin_fn scene_play_skin_plain;

/* The fastest for this CPU. */
play_skin_fn *scene_play_skin_choose(void);

#define PLAY_INLINE static inline __attribute__((always_inline))

typedef float play_lanes __attribute__((vector_size(32)));
typedef int32_t play_mask __attribute__((vector_size(32)));
typedef float play_half __attribute__((vector_size(16)));
/* The same in memory, at any place: a load of one of these is one instruction, where memcpy may become several. */
typedef float play_lanes_at __attribute__((vector_size(32), aligned(4), may_alias));
typedef float play_half_at __attribute__((vector_size(16), aligned(4), may_alias));

/* Of vectors that are passed by pointer alone: their registers depend on the instruction set. */
PLAY_INLINE void play_load(const float *from, play_lanes *to)
{
	*to = *(const play_lanes_at *)from;
}

PLAY_INLINE void play_root(play_lanes *x)
{
#if defined(__AVX__)
	__m256 root = _mm256_sqrt_ps((__m256)*x);
	memcpy(x, &root, sizeof root);
#elif defined(__x86_64__)
	__m128 half[2];
	memcpy(half, x, sizeof half);
	half[0] = _mm_sqrt_ps(half[0]);
	half[1] = _mm_sqrt_ps(half[1]);
	memcpy(x, half, sizeof half);
#else
	for (int i = 0; i < 8; i++)
		(*x)[i] = sqrtf((*x)[i]);
#endif
}

/* Rows become columns. */
PLAY_INLINE void play_transpose(play_lanes r[8])
{
#define PLAY_PAIR(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define PLAY_PAIR_HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define PLAY_FOUR(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define PLAY_FOUR_HIGH(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define PLAY_HALVES(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define PLAY_HALVES_HIGH(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)
	play_lanes p[8], q[8];
	for (int i = 0; i < 8; i += 2) {
		p[i] = PLAY_PAIR(r[i], r[i + 1]);
		p[i + 1] = PLAY_PAIR_HIGH(r[i], r[i + 1]);
	}
	for (int i = 0; i < 8; i += 4) {
		q[i] = PLAY_FOUR(p[i], p[i + 2]);
		q[i + 1] = PLAY_FOUR_HIGH(p[i], p[i + 2]);
		q[i + 2] = PLAY_FOUR(p[i + 1], p[i + 3]);
		q[i + 3] = PLAY_FOUR_HIGH(p[i + 1], p[i + 3]);
	}
	for (int i = 0; i < 4; i++) {
		r[i] = PLAY_HALVES(q[i], q[i + 4]);
		r[i + 4] = PLAY_HALVES_HIGH(q[i], q[i + 4]);
	}
}

/* The matrices of eight vertices: element [4 * row + column] of each. Neighbours share most of their joints, so that
 * it pays to go through the joints of all eight: a lane that one does not carry adds zeros, and nothing is gathered. */
PLAY_INLINE void play_blend(const play_skin *skin, uint32_t first, play_lanes m[12])
{
	uint32_t at = skin->starts[first / PLAY_LANES], end = skin->starts[first / PLAY_LANES + 1];
	const float *joint = skin->joints[skin->indices[at]].m;
	play_lanes weight = *(const play_lanes_at *)(skin->weights + (size_t)at * PLAY_LANES);
	for (int i = 0; i < 12; i++)
		m[i] = weight * joint[i];
	while (++at < end) {
		joint = skin->joints[skin->indices[at]].m;
		weight = *(const play_lanes_at *)(skin->weights + (size_t)at * PLAY_LANES);
		for (int i = 0; i < 12; i++)
			m[i] += weight * joint[i];
	}
}

/* Where the mask is set, b becomes a. */
PLAY_INLINE void play_choose(const play_mask *mask, const play_lanes *a, play_lanes *b)
{
#if defined(__AVX__)
	__m256 chosen = _mm256_blendv_ps((__m256)*b, (__m256)*a, (__m256)*mask);
	memcpy(b, &chosen, sizeof chosen);
#else
	play_mask x, y;
	memcpy(&x, a, sizeof x);
	memcpy(&y, b, sizeof y);
	y = (x & *mask) | (y & ~*mask);
	memcpy(b, &y, sizeof y);
#endif
}

/* Changes the sign where the mask has that of a number. */
PLAY_INLINE void play_turn(const play_mask *signs, play_lanes *x)
{
	play_mask bits;
	memcpy(&bits, x, sizeof bits);
	bits ^= *signs;
	memcpy(x, &bits, sizeof bits);
}

/* Makes directions unit, turned round where `signs` says so; those without a length become the others. */
PLAY_INLINE void play_unit(play_lanes v[3], const play_mask *signs, const play_lanes other[3])
{
	play_lanes square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
	play_mask good = (square > 1e-36f) & (square < 1e36f);
	play_lanes one = square - square + 1.0f, scale = one;
	play_choose(&good, &square, &scale);
	play_root(&scale);
	scale = 1.0f / scale;
	play_turn(signs, &scale);
	for (int i = 0; i < 3; i++) {
		play_lanes unit = v[i] * scale;
		v[i] = other[i];
		play_choose(&good, &unit, &v[i]);
	}
}

/* What the matrices make of positions, normals and tangents. */
PLAY_INLINE void play_carry(const play_lanes m[12], play_lanes position[3], play_lanes normal[3], play_lanes tangent[4],
                            bool tangents)
{
	play_lanes at[3], n[3], rest[3], c[9];
	for (size_t i = 0; i < 3; i++) {
		at[i] = m[4 * i] * position[0] + m[4 * i + 1] * position[1] + m[4 * i + 2] * position[2] + m[4 * i + 3];
		size_t a = 4 * ((i + 1) % 3), b = 4 * ((i + 2) % 3);
		for (size_t k = 0; k < 3; k++) /* cofactors of row i */
			c[3 * i + k] = m[a + (k + 1) % 3] * m[b + (k + 2) % 3] - m[a + (k + 2) % 3] * m[b + (k + 1) % 3];
	}
	play_lanes determinant = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
	play_mask mirrored = (determinant < 0.0f) & INT32_MIN, none = {0};
	for (size_t i = 0; i < 3; i++) {
		n[i] = c[3 * i] * normal[0] + c[3 * i + 1] * normal[1] + c[3 * i + 2] * normal[2];
		rest[i] = normal[i];
	}
	play_unit(n, &mirrored, rest);
	for (size_t i = 0; i < 3; i++) {
		position[i] = at[i];
		normal[i] = n[i];
	}
	if (!tangents)
		return;
	for (size_t i = 0; i < 3; i++) {
		n[i] = m[4 * i] * tangent[0] + m[4 * i + 1] * tangent[1] + m[4 * i + 2] * tangent[2];
		rest[i] = tangent[i];
	}
	play_unit(n, &none, rest);
	for (size_t i = 0; i < 3; i++)
		tangent[i] = n[i];
	play_turn(&mirrored, &tangent[3]); /* a matrix that mirrors turns the bitangent round */
}

/* Writes eight vertices, or those that there are. */
PLAY_INLINE void play_write(play_skin *skin, uint32_t first, uint32_t count, const play_lanes position[3],
                            const play_lanes normal[3], const play_lanes tangent[4], bool tangents)
{
	play_lanes rows[8] = {position[0], position[1], position[2], normal[0], normal[1], normal[2]};
	play_load(skin->uv[0] + first, &rows[6]);
	play_load(skin->uv[1] + first, &rows[7]);
	play_transpose(rows);
	for (uint32_t v = 0; v < count; v++)
		*(play_lanes_at *)skin->vertices[first + v].position = rows[v];
	for (uint32_t v = 0; tangents && v < count; v++)
		for (int i = 0; i < 4; i++)
			skin->extras[first + v].tangent[i] = tangent[i][v];
}

static_assert(sizeof(stilb_scene_vertex) == sizeof(play_lanes), "a vertex is position, normal and uv");

/* Adds eight positions to a box, the first one again for those that are too many. NaN are left out. */
PLAY_INLINE void play_enclose(const play_lanes position[3], uint32_t count, play_lanes low[3], play_lanes high[3])
{
	for (int i = 0; i < 3; i++) {
		play_lanes p = position[i];
		for (uint32_t v = count; v < PLAY_LANES; v++)
			p[v] = p[0];
#if defined(__AVX__)
		low[i] = (play_lanes)_mm256_min_ps((__m256)p, (__m256)low[i]);
		high[i] = (play_lanes)_mm256_max_ps((__m256)p, (__m256)high[i]);
#else
		play_mask below = p<low[i], above = p> high[i];
		play_choose(&below, &p, &low[i]);
		play_choose(&above, &p, &high[i]);
#endif
	}
}

/* Carries eight vertices, or those that there are, and adds them to a box. */
PLAY_INLINE void play_eight(play_skin *skin, uint32_t first, uint32_t count, bool tangents, play_lanes low[3],
                            play_lanes high[3])
{
	play_lanes m[12], position[3], normal[3], tangent[4] = {{0}};
	for (int i = 0; i < 3; i++) {
		play_load(skin->position[i] + first, &position[i]);
		play_load(skin->normal[i] + first, &normal[i]);
	}
	for (int i = 0; tangents && i < 4; i++)
		play_load(skin->tangent[i] + first, &tangent[i]);
	if (skin->joints) {
		play_blend(skin, first, m);
		play_carry(m, position, normal, tangent, tangents);
	}
	play_write(skin, first, count, position, normal, tangent, tangents);
	play_enclose(position, count, low, high);
}

PLAY_INLINE void play_skin_run(play_skin *skin, bool tangents)
{
	play_lanes low[3], high[3];
	uint32_t first = 0;
	for (int i = 0; i < 3; i++) {
		low[i] = (play_lanes){INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY};
		high[i] = -low[i];
	}
	for (; skin->count - first >= PLAY_LANES; first += PLAY_LANES)
		play_eight(skin, first, PLAY_LANES, tangents, low, high);
	if (first < skin->count) /* apart, so that above the vertices stay in registers */
		play_eight(skin, first, skin->count - first, tangents, low, high);
	for (int i = 0; i < 3; i++) {
		skin->low[i] = low[i][0];
		skin->high[i] = high[i][0];
		for (int v = 1; v < (int)PLAY_LANES; v++) {
			skin->low[i] = low[i][v] < skin->low[i] ? low[i][v] : skin->low[i];
			skin->high[i] = high[i][v] > skin->high[i] ? high[i][v] : skin->high[i];
		}
	}
}

#endif
