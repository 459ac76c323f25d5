/*
 * gi_packet: sixteen rays transposed between the two layouts: one struct a ray, as integrators keep them, and one row a
 * number (gi_ray_hit16), as intersectors trace packets. [any-thread]
 */
#ifndef STILB_GI_PACKET_H
#define STILB_GI_PACKET_H

#include "base/base_math.h"
#include "gi/trace/gi_trace.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

/* Transposes a 4 x 4 matrix. */
static inline void gi_packet_transpose(stilb_vec4 m[4])
{
	stilb_vec4 a = __builtin_shufflevector(m[0], m[1], 0, 4, 1, 5), b = __builtin_shufflevector(m[2], m[3], 0, 4, 1, 5);
	stilb_vec4 c = __builtin_shufflevector(m[0], m[1], 2, 6, 3, 7), d = __builtin_shufflevector(m[2], m[3], 2, 6, 3, 7);
	m[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
	m[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
	m[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
	m[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

/* Reads four structs that lie stride bytes apart: the four 4-byte numbers at `from` in the first, and at the same place
 * in the others. Number i of struct k goes to row i, lane k of `rows`; rows are sixteen numbers long. */
static inline void gi_packet_gather(const void *from, size_t stride, void *rows)
{
	stilb_vec4 m[4];
	for (int i = 0; i < 4; i++)
		memcpy(&m[i], (const char *)from + (size_t)i * stride, sizeof m[i]);
	gi_packet_transpose(m);
	for (int i = 0; i < 4; i++)
		memcpy((char *)rows + (size_t)i * 16 * sizeof(float), &m[i], sizeof m[i]);
}

/* The inverse of gi_packet_gather. */
static inline void gi_packet_scatter(const void *rows, void *to, size_t stride)
{
	stilb_vec4 m[4];
	for (int i = 0; i < 4; i++)
		memcpy(&m[i], (const char *)rows + (size_t)i * 16 * sizeof(float), sizeof m[i]);
	gi_packet_transpose(m);
	for (int i = 0; i < 4; i++)
		memcpy((char *)to + (size_t)i * stride, &m[i], sizeof m[i]);
}

static_assert(sizeof(gi_ray) == sizeof(float[12]), "12 numbers a ray");
static_assert(sizeof(gi_ray16) == sizeof(float[12][16]), "12 rows of 16 lanes");
static_assert(offsetof(gi_ray_hit, hit) == sizeof(float[12]) && sizeof(gi_ray_hit) == sizeof(float[20]), "8 a hit");
static_assert(offsetof(gi_ray_hit16, hit) == sizeof(float[12][16]) && sizeof(gi_ray_hit16) == sizeof(float[20][16]),
              "8 rows of 16 lanes");

/* Sixteen rays, stride bytes apart, into a packet. */
static inline void gi_packet_load_rays(const gi_ray *rays, size_t stride, gi_ray16 *packet)
{
	for (size_t lane = 0; lane < 16; lane += 4)
		for (size_t row = 0; row < 12; row += 4)
			gi_packet_gather((const char *)rays + lane * stride + row * 4, stride,
			                 (char *)packet + row * 64 + lane * 4);
}

#ifdef __AVX512F__
/* gi_packet_scatter for all sixteen lanes: each quarter of a register transposes a 4 x 4 matrix. */
static inline void gi_packet_scatter_all(const void *rows, void *to, size_t stride)
{
	typedef float row __attribute__((vector_size(64)));
	row r[4];
	memcpy(r, rows, sizeof r);
	row a = __builtin_shufflevector(r[0], r[1], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
	row b = __builtin_shufflevector(r[2], r[3], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
	row c = __builtin_shufflevector(r[0], r[1], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
	row d = __builtin_shufflevector(r[2], r[3], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
	row m[4] = {__builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
	            __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31),
	            __builtin_shufflevector(c, d, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
	            __builtin_shufflevector(c, d, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)};
	for (uint32_t i = 0; i < 4; i++) {
		stilb_vec4 quarter[4] = {
			__builtin_shufflevector(m[i], m[i], 0, 1, 2, 3), __builtin_shufflevector(m[i], m[i], 4, 5, 6, 7),
			__builtin_shufflevector(m[i], m[i], 8, 9, 10, 11), __builtin_shufflevector(m[i], m[i], 12, 13, 14, 15)};
		for (uint32_t k = 0; k < 4; k++)
			memcpy((char *)to + (4 * k + i) * stride, &quarter[k], sizeof quarter[k]);
	}
}
#else
/* gi_packet_scatter for all sixteen lanes. */
static inline void gi_packet_scatter_all(const void *rows, void *to, size_t stride)
{
	for (uint32_t lane = 0; lane < 16; lane += 4)
		gi_packet_scatter((const char *)rows + lane * sizeof(float), (char *)to + lane * stride, stride);
}
#endif

/* A packet into sixteen rays and their hits. */
static inline void gi_packet_store_hits(const gi_ray_hit16 *packet, gi_ray_hit rays[16])
{
	for (size_t row = 0; row < 20; row += 4)
		gi_packet_scatter_all((const char *)packet + row * 64, (char *)rays + row * 4, sizeof *rays);
}

#endif
