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
	const float *tangent[4];          /* NULL: there are none */
	const play_rows *joints;          /* of the skin; NULL: the vertices stay where they are */
	const float *weights;             /* [count to the next eight][influences], of sum 1 */
	const uint16_t *indices;          /* the same of joints */
	uint32_t influences, count;       /* influences: a multiple of 4 */
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

/* Rows of four, of the vertices i and i + 4 side by side, become columns. */
PLAY_INLINE void play_transpose_four(const play_lanes r[4], play_lanes to[4])
{
	play_lanes a = PLAY_PAIR(r[0], r[1]), b = PLAY_PAIR_HIGH(r[0], r[1]);
	play_lanes c = PLAY_PAIR(r[2], r[3]), d = PLAY_PAIR_HIGH(r[2], r[3]);
	to[0] = PLAY_FOUR(a, c);
	to[1] = PLAY_FOUR_HIGH(a, c);
	to[2] = PLAY_FOUR(b, d);
	to[3] = PLAY_FOUR_HIGH(b, d);
}

/* The matrices of eight vertices: element [4 * row + column] of each. */
PLAY_INLINE void play_blend(const play_skin *skin, uint32_t first, play_lanes m[12])
{
	play_lanes upper[8];
	play_half lower[8];
	for (uint32_t v = 0; v < PLAY_LANES; v++) {
		const float *weights = skin->weights + (size_t)(first + v) * skin->influences;
		const uint16_t *indices = skin->indices + (size_t)(first + v) * skin->influences;
		play_lanes rows, sum = {0};
		play_half row, rest = {0};
		for (uint32_t i = 0; i < 4; i++) {
			rows = *(const play_lanes_at *)skin->joints[indices[i]].m;
			row = *(const play_half_at *)(skin->joints[indices[i]].m + 8);
			sum += weights[i] * rows;
			rest += weights[i] * row;
		}
		for (uint32_t i = 4; i < skin->influences; i++) {
			if (weights[i] == 0.0f)
				continue;
			rows = *(const play_lanes_at *)skin->joints[indices[i]].m;
			row = *(const play_half_at *)(skin->joints[indices[i]].m + 8);
			sum += weights[i] * rows;
			rest += weights[i] * row;
		}
		upper[v] = sum;
		lower[v] = rest;
	}
	play_transpose(upper);
	for (int i = 0; i < 8; i++)
		m[i] = upper[i];
	play_lanes pairs[4];
	for (int i = 0; i < 4; i++)
		pairs[i] = __builtin_shufflevector(lower[i], lower[i + 4], 0, 1, 2, 3, 4, 5, 6, 7);
	play_transpose_four(pairs, m + 8);
}

PLAY_INLINE void play_choose(const play_mask *mask, const play_lanes *a, play_lanes *b)
{
	play_mask x, y;
	memcpy(&x, a, sizeof x);
	memcpy(&y, b, sizeof y);
	y = (x & *mask) | (y & ~*mask);
	memcpy(b, &y, sizeof y);
}

/* Makes directions unit; those without a length become the others. */
PLAY_INLINE void play_unit(play_lanes v[3], const play_lanes other[3])
{
	play_lanes square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
	play_mask good = (square > 1e-36f) & (square < 1e36f);
	play_lanes one = square - square + 1.0f, scale = one;
	play_choose(&good, &square, &scale);
	play_root(&scale);
	scale = 1.0f / scale;
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
	play_mask mirrored = determinant < 0.0f;
	play_lanes side = determinant - determinant + 1.0f, minus = -side;
	play_choose(&mirrored, &minus, &side);
	for (size_t i = 0; i < 3; i++) {
		n[i] = (c[3 * i] * normal[0] + c[3 * i + 1] * normal[1] + c[3 * i + 2] * normal[2]) * side;
		rest[i] = normal[i];
	}
	play_unit(n, rest);
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
	play_unit(n, rest);
	for (size_t i = 0; i < 3; i++)
		tangent[i] = n[i];
	tangent[3] = tangent[3] * side; /* a matrix that mirrors turns the bitangent round */
}

/* Writes eight vertices, or those that there are. */
PLAY_INLINE void play_write(play_skin *skin, uint32_t first, const play_lanes position[3], const play_lanes normal[3],
                            const play_lanes tangent[4])
{
	uint32_t count = skin->count - first < PLAY_LANES ? skin->count - first : PLAY_LANES;
	play_lanes rows[8] = {position[0], position[1], position[2], normal[0], normal[1], normal[2]};
	play_load(skin->uv[0] + first, &rows[6]);
	play_load(skin->uv[1] + first, &rows[7]);
	play_transpose(rows);
	for (uint32_t v = 0; v < count; v++)
		*(play_lanes_at *)skin->vertices[first + v].position = rows[v];
	for (uint32_t v = 0; skin->tangent[0] && v < count; v++)
		for (int i = 0; i < 4; i++)
			skin->extras[first + v].tangent[i] = tangent[i][v];
}

static_assert(sizeof(stilb_scene_vertex) == sizeof(play_lanes), "a vertex is position, normal and uv");

/* Adds eight positions to a box, the first one again for those that are too many. */
PLAY_INLINE void play_enclose(const play_lanes position[3], uint32_t count, play_lanes low[3], play_lanes high[3])
{
	for (int i = 0; i < 3; i++) {
		play_lanes p = position[i];
		for (uint32_t v = count; v < PLAY_LANES; v++)
			p[v] = p[0];
		play_mask below = p<low[i], above = p> high[i];
		play_choose(&below, &p, &low[i]);
		play_choose(&above, &p, &high[i]);
	}
}

PLAY_INLINE void play_skin_run(play_skin *skin, bool tangents)
{
	play_lanes low[3], high[3];
	for (int i = 0; i < 3; i++) {
		low[i] = (play_lanes){INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY};
		high[i] = -low[i];
	}
	for (uint32_t first = 0; first < skin->count; first += PLAY_LANES) {
		play_lanes m[12], position[3], normal[3], tangent[4] = {{0}};
		uint32_t count = skin->count - first < PLAY_LANES ? skin->count - first : PLAY_LANES;
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
		play_write(skin, first, position, normal, tangent);
		play_enclose(position, count, low, high);
	}
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
