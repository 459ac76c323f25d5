/* The innermost loops with AVX2: eight spheres or ids, sixteen cells at a time. */
#include "culling/cull_scalar.h"

#if defined(__x86_64__)
#include <immintrin.h>

/* For functions that must be inlined so that their loops over planes are unrolled. */
#define INLINE static inline __attribute__((always_inline))

/* Planes, each component broadcast to all lanes. */
typedef struct avx2_planes {
	__m256 x[CULL_PLANES], y[CULL_PLANES], z[CULL_PLANES], distance[CULL_PLANES];
} avx2_planes;

INLINE void avx2_load_planes(avx2_planes *out, const stilb_plane *planes, uint32_t count)
{
	for (uint32_t p = 0; p < count; p++) {
		out->x[p] = _mm256_set1_ps(planes[p].x);
		out->y[p] = _mm256_set1_ps(planes[p].y);
		out->z[p] = _mm256_set1_ps(planes[p].z);
		out->distance[p] = _mm256_set1_ps(planes[p].distance);
	}
}

/* A mask of which of the spheres at .. at + 7 are visible: bit i is sphere at + i. */
INLINE uint32_t avx2_test(cull_spheres spheres, uint32_t at, const avx2_planes *planes, uint32_t plane_count)
{
	__m256 x = _mm256_loadu_ps(spheres.x + at), y = _mm256_loadu_ps(spheres.y + at);
	__m256 z = _mm256_loadu_ps(spheres.z + at);
	__m256 least = _mm256_xor_ps(_mm256_loadu_ps(spheres.radius + at), _mm256_set1_ps(-0.0f));
	__m256 visible = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
	for (uint32_t p = 0; p < plane_count; p++) {
		__m256 sum = _mm256_add_ps(_mm256_mul_ps(x, planes->x[p]), _mm256_mul_ps(y, planes->y[p]));
		sum = _mm256_add_ps(_mm256_add_ps(sum, _mm256_mul_ps(z, planes->z[p])), planes->distance[p]);
		visible = _mm256_and_ps(visible, _mm256_cmp_ps(sum, least, _CMP_GE_OQ));
	}
	return (uint32_t)_mm256_movemask_ps(visible);
}

/* avx2_picks[mask]: the positions of the set bits of an 8-bit mask, lowest first, a byte each. */
#define BELOW(MASK, BIT) __builtin_popcount((MASK) & ((1u << (BIT)) - 1))
#define PICK(MASK, BIT) ((uint64_t)(((MASK) >> (BIT)) & 1u) * (BIT) << 8 * BELOW(MASK, BIT))
#define ROW(MASK)                                                                                                      \
	(PICK(MASK, 1) | PICK(MASK, 2) | PICK(MASK, 3) | PICK(MASK, 4) | PICK(MASK, 5) | PICK(MASK, 6) | PICK(MASK, 7))
#define ROWS4(MASK) ROW(MASK), ROW((MASK) + 1), ROW((MASK) + 2), ROW((MASK) + 3)
#define ROWS16(MASK) ROWS4(MASK), ROWS4((MASK) + 4), ROWS4((MASK) + 8), ROWS4((MASK) + 12)
#define ROWS64(MASK) ROWS16(MASK), ROWS16((MASK) + 16), ROWS16((MASK) + 32), ROWS16((MASK) + 48)
static const uint64_t avx2_picks[256] = {ROWS64(0u), ROWS64(64u), ROWS64(128u), ROWS64(192u)};

/* Writes the ids of visible lanes side by side and returns their number, as vpcompressd of AVX-512 does. */
INLINE uint32_t avx2_append(uint32_t *ids, uint32_t visible, __m256i id)
{
	__m256i picks = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)&avx2_picks[visible]));
	_mm256_storeu_si256((__m256i *)ids, _mm256_permutevar8x32_epi32(id, picks));
	return (uint32_t)__builtin_popcount(visible);
}

static uint32_t avx2_flat(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t *ids)
{
	avx2_planes planes;
	avx2_load_planes(&planes, frustum->planes, CULL_PLANES);
	uint32_t found = 0, at = 0;
	__m256i id = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
	for (; at + 8 <= count; at += 8) {
		found += avx2_append(ids + found, avx2_test(spheres, at, &planes, CULL_PLANES), id);
		id = _mm256_add_epi32(id, _mm256_set1_epi32(8));
	}
	for (; at < count; at++) {
		ids[found] = at;
		found += scalar_visible(spheres, at, frustum->planes, CULL_PLANES);
	}
	return found;
}

static void avx2_all(uint32_t count, uint32_t *ids)
{
	__m256i id = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
	for (uint32_t i = 0; i < count; i += 8) {
		_mm256_storeu_si256((__m256i *)(ids + i), id);
		id = _mm256_add_epi32(id, _mm256_set1_epi32(8));
	}
}

INLINE void avx2_test_planes(cull_spheres spheres, uint32_t count, const stilb_plane *chosen, uint32_t plane_count,
                             uint64_t *bits)
{
	avx2_planes planes;
	avx2_load_planes(&planes, chosen, plane_count);
	for (uint32_t first = 0; first < count; first += 64) {
		uint64_t set = 0;
		uint32_t at = first, end = count < first + 64 ? count : first + 64;
		for (; at + 8 <= end; at += 8)
			set |= (uint64_t)avx2_test(spheres, at, &planes, plane_count) << (at - first);
		for (; at < end; at++)
			set |= (uint64_t)scalar_visible(spheres, at, chosen, plane_count) << (at - first);
		bits[first / 64] = set;
	}
}

static void avx2_test_bits(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes,
                           uint64_t *bits)
{
	stilb_plane chosen[CULL_PLANES];
	STILB_ASSERT(count > 0);
	switch (scalar_choose_planes(frustum, planes, chosen)) {
	case 1:
		avx2_test_planes(spheres, count, chosen, 1, bits);
		return;
	case 2:
		avx2_test_planes(spheres, count, chosen, 2, bits);
		return;
	case 3:
		avx2_test_planes(spheres, count, chosen, 3, bits);
		return;
	case 4:
		avx2_test_planes(spheres, count, chosen, 4, bits);
		return;
	case 5:
		avx2_test_planes(spheres, count, chosen, 5, bits);
		return;
	default:
		avx2_test_planes(spheres, count, chosen, 6, bits);
	}
}

static void avx2_sixteen(cull_sixteen *cells, const cull_level *level, uint32_t planes)
{
	__m256d zero = _mm256_setzero_pd();
	uint32_t rejected = 0;
	STILB_ASSERT((uintptr_t)level % _Alignof(cull_level) == 0 && !(planes & ~CULL_ALL_PLANES));
	for (uint32_t plane = 0; plane < CULL_PLANES; plane++)
		cells->inside[plane] = 0;
	for (; planes; planes &= planes - 1) {
		uint32_t plane = (uint32_t)__builtin_ctz(planes), inside = 0;
		for (uint32_t i = 0; i < CULL_WIDTH; i += 4) {
			uint32_t family = i / CULL_CHILDREN, child = i % CULL_CHILDREN;
			__m256d center = _mm256_set1_pd(cells->center[family][plane]);
			__m256d reach = _mm256_cvtps_pd(_mm_loadu_ps(cells->reach[family] + child));
			__m256d most = _mm256_add_pd(_mm256_add_pd(center, _mm256_load_pd(&level->high[plane][child])), reach);
			__m256d least = _mm256_add_pd(center, _mm256_load_pd(&level->low[plane][child]));
			rejected |= (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(most, zero, _CMP_LT_OQ)) << i;
			inside |= (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(least, zero, _CMP_GE_OQ)) << i;
		}
		cells->inside[plane] = (uint16_t)inside;
	}
	cells->rejected = (uint16_t)rejected;
}

static uint32_t avx2_gather(uint64_t *bits, size_t stride, uint32_t count, uint32_t words)
{
	return scalar_gather(bits, stride, count, words);
}

static uint32_t avx2_expand(uint64_t *bits, uint32_t words, uint32_t first_id, uint32_t *ids)
{
	return scalar_expand(bits, words, first_id, ids);
}

const cull_kernels cull_kernels_avx2 = {
	.flat = avx2_flat,
	.all = avx2_all,
	.test = avx2_test_bits,
	.sixteen = avx2_sixteen,
	.gather = avx2_gather,
	.expand = avx2_expand,
};
#endif
