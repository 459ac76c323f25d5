/* gi_packet: rays one by one, as integrators keep them, to packets of sixteen, as Embree traces them fastest, and back.
 * [any-thread] */
#ifndef STILB_GI_PACKET_H
#define STILB_GI_PACKET_H

#include "base/base_math.h"
#include "gi/trace/gi_trace.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

/* Rows become columns. */
static inline void gi_packet_turn(stilb_vec4 m[4])
{
	stilb_vec4 a = __builtin_shufflevector(m[0], m[1], 0, 4, 1, 5), b = __builtin_shufflevector(m[2], m[3], 0, 4, 1, 5);
	stilb_vec4 c = __builtin_shufflevector(m[0], m[1], 2, 6, 3, 7), d = __builtin_shufflevector(m[2], m[3], 2, 6, 3, 7);
	m[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
	m[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
	m[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
	m[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

/* Four floats of each of four rays from one place to four rows of a packet. Both are arrays of 4-byte numbers. */
static inline void gi_packet_gather(const void *from, size_t stride, void *rows)
{
	stilb_vec4 m[4];
	for (int i = 0; i < 4; i++)
		memcpy(&m[i], (const char *)from + (size_t)i * stride, sizeof m[i]);
	gi_packet_turn(m);
	for (int i = 0; i < 4; i++)
		memcpy((char *)rows + (size_t)i * 16 * sizeof(float), &m[i], sizeof m[i]);
}

/* ... and back. */
static inline void gi_packet_scatter(const void *rows, void *to, size_t stride)
{
	stilb_vec4 m[4];
	for (int i = 0; i < 4; i++)
		memcpy(&m[i], (const char *)rows + (size_t)i * 16 * sizeof(float), sizeof m[i]);
	gi_packet_turn(m);
	for (int i = 0; i < 4; i++)
		memcpy((char *)to + (size_t)i * stride, &m[i], sizeof m[i]);
}

static_assert(offsetof(RTCRay, dir_x) == 16 && offsetof(RTCRay, tfar) == 32 && sizeof(RTCRay) == 48, "as below");
static_assert(offsetof(RTCRayHit, hit) == 48 && sizeof(RTCRayHit) == 80, "as below");
static_assert(offsetof(RTCRayHit16, hit) == 12 * 64 && sizeof(RTCRayHit16) == 20 * 64, "as below");

static inline void gi_packet_load_rays(const RTCRay rays[16], struct RTCRay16 *packet)
{
	for (uint32_t lane = 0; lane < 16; lane += 4)
		for (uint32_t row = 0; row < 12; row += 4)
			gi_packet_gather((const char *)&rays[lane] + row * 4, sizeof *rays, (char *)packet + row * 64 + lane * 4);
}

#ifdef __AVX512F__
/* gi_packet_scatter of sixteen rays: four are turned in each quarter of a register. */
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
static inline void gi_packet_scatter_all(const void *rows, void *to, size_t stride)
{
	for (uint32_t lane = 0; lane < 16; lane += 4)
		gi_packet_scatter((const char *)rows + lane * sizeof(float), (char *)to + lane * stride, stride);
}
#endif

static inline void gi_packet_store_hits(const RTCRayHit16 *packet, RTCRayHit rays[16])
{
	for (uint32_t row = 0; row < 20; row += 4)
		gi_packet_scatter_all((const char *)packet + row * 64, (char *)rays + row * 4, sizeof *rays);
}

#endif
