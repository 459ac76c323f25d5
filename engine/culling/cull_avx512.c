/* The innermost loops with AVX-512 F, VL, BW and DQ: sixteen spheres, sixteen ids or sixteen cells at a time. */
#include "culling/cull_scalar.h"

#if defined(__x86_64__)
#include <immintrin.h>
#include <string.h>

#define AVX512_PIECE 256u /* words of bits that are expanded at a time */

/* For functions that must be inlined so that their loops over planes are unrolled. */
#define INLINE static inline __attribute__((always_inline))

/* Planes, each component broadcast to all lanes. */
typedef struct avx512_planes {
	__m512 x[CULL_PLANES], y[CULL_PLANES], z[CULL_PLANES], distance[CULL_PLANES];
} avx512_planes;

INLINE void avx512_load_planes(avx512_planes *out, const stilb_plane *planes, uint32_t count)
{
	for (uint32_t p = 0; p < count; p++) {
		out->x[p] = _mm512_set1_ps(planes[p].x);
		out->y[p] = _mm512_set1_ps(planes[p].y);
		out->z[p] = _mm512_set1_ps(planes[p].z);
		out->distance[p] = _mm512_set1_ps(planes[p].distance);
	}
}

/* A mask of the first `left` lanes; at most 16. */
INLINE uint32_t avx512_lanes(uint32_t left)
{
	return left >= 16 ? 0xffffu : (1u << left) - 1;
}

/* Sixteen spheres. */
typedef struct avx512_spheres {
	__m512 x, y, z, radius;
} avx512_spheres;

INLINE void avx512_load(avx512_spheres *out, cull_spheres spheres, uint32_t at)
{
	out->x = _mm512_loadu_ps(spheres.x + at);
	out->y = _mm512_loadu_ps(spheres.y + at);
	out->z = _mm512_loadu_ps(spheres.z + at);
	out->radius = _mm512_loadu_ps(spheres.radius + at);
}

/* avx512_load for the end of the arrays: lanes outside the mask are not read. */
INLINE void avx512_load_lanes(avx512_spheres *out, cull_spheres spheres, uint32_t at, uint32_t lanes)
{
	out->x = _mm512_maskz_loadu_ps((__mmask16)lanes, spheres.x + at);
	out->y = _mm512_maskz_loadu_ps((__mmask16)lanes, spheres.y + at);
	out->z = _mm512_maskz_loadu_ps((__mmask16)lanes, spheres.z + at);
	out->radius = _mm512_maskz_loadu_ps((__mmask16)lanes, spheres.radius + at);
}

/* A mask of which spheres are visible, a bit for each lane; lanes outside the mask `lanes` are 0. */
INLINE uint32_t avx512_test(const avx512_spheres *spheres, uint32_t lanes, const avx512_planes *planes,
                            uint32_t plane_count)
{
	__mmask16 visible = (__mmask16)lanes;
	__m512 least = _mm512_xor_ps(spheres->radius, _mm512_set1_ps(-0.0f));
	for (uint32_t p = 0; p < plane_count; p++) {
		__m512 sum = _mm512_add_ps(_mm512_mul_ps(spheres->x, planes->x[p]), _mm512_mul_ps(spheres->y, planes->y[p]));
		sum = _mm512_add_ps(_mm512_add_ps(sum, _mm512_mul_ps(spheres->z, planes->z[p])), planes->distance[p]);
		visible = _mm512_mask_cmp_ps_mask(visible, sum, least, _CMP_GE_OQ);
	}
	return visible;
}

/* Writes the ids of visible lanes side by side and returns their number. vpcompressd with a memory destination takes
 * over a hundred cycles on some CPUs, so it compresses into a register. */
INLINE uint32_t avx512_append(uint32_t *ids, uint32_t visible, __m512i id)
{
	_mm512_storeu_si512(ids, _mm512_maskz_compress_epi32((__mmask16)visible, id));
	return (uint32_t)__builtin_popcount(visible);
}

INLINE __m512i avx512_iota(uint32_t first)
{
	return _mm512_add_epi32(_mm512_set1_epi32((int)first),
	                        _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
}

static uint32_t avx512_flat(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t *ids)
{
	avx512_planes planes;
	avx512_spheres sixteen;
	avx512_load_planes(&planes, frustum->planes, CULL_PLANES);
	uint32_t found = 0, at = 0;
	__m512i id = avx512_iota(0);
	for (; at + 16 <= count; at += 16) {
		avx512_load(&sixteen, spheres, at);
		found += avx512_append(ids + found, avx512_test(&sixteen, 0xffff, &planes, CULL_PLANES), id);
		id = _mm512_add_epi32(id, _mm512_set1_epi32(16));
	}
	uint32_t lanes = avx512_lanes(count - at);
	avx512_load_lanes(&sixteen, spheres, at, lanes);
	return found + avx512_append(ids + found, avx512_test(&sixteen, lanes, &planes, CULL_PLANES), id);
}

static void avx512_all(uint32_t count, uint32_t *ids)
{
	__m512i id = avx512_iota(0);
	for (uint32_t i = 0; i < count; i += 16) {
		_mm512_storeu_si512(ids + i, id);
		id = _mm512_add_epi32(id, _mm512_set1_epi32(16));
	}
}

INLINE void avx512_test_planes(cull_spheres spheres, uint32_t count, const stilb_plane *chosen, uint32_t plane_count,
                               uint64_t *bits)
{
	avx512_planes planes;
	avx512_spheres sixteen;
	uint32_t at = 0;
	avx512_load_planes(&planes, chosen, plane_count);
	bits[(count - 1) / 64] = 0;
	for (; at < count; at += 16) {
		uint32_t lanes = avx512_lanes(count - at);
		if (lanes == 0xffff)
			avx512_load(&sixteen, spheres, at);
		else
			avx512_load_lanes(&sixteen, spheres, at, lanes);
		uint16_t visible = (uint16_t)avx512_test(&sixteen, lanes, &planes, plane_count);
		memcpy((char *)bits + at / 8, &visible, sizeof visible);
	}
}

static void avx512_test_bits(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes,
                             uint64_t *bits)
{
	stilb_plane chosen[CULL_PLANES];
	STILB_ASSERT(count > 0);
	switch (scalar_choose_planes(frustum, planes, chosen)) {
	case 1:
		avx512_test_planes(spheres, count, chosen, 1, bits);
		return;
	case 2:
		avx512_test_planes(spheres, count, chosen, 2, bits);
		return;
	case 3:
		avx512_test_planes(spheres, count, chosen, 3, bits);
		return;
	case 4:
		avx512_test_planes(spheres, count, chosen, 4, bits);
		return;
	case 5:
		avx512_test_planes(spheres, count, chosen, 5, bits);
		return;
	default:
		avx512_test_planes(spheres, count, chosen, 6, bits);
	}
}

static void avx512_sixteen(cull_sixteen *cells, const cull_level *level, uint32_t planes)
{
	__m512d zero = _mm512_setzero_pd();
	__m512d reach0 = _mm512_cvtps_pd(_mm256_loadu_ps(cells->reach[0]));
	__m512d reach1 = _mm512_cvtps_pd(_mm256_loadu_ps(cells->reach[1]));
	uint32_t rejected = 0;
	STILB_ASSERT((uintptr_t)level % _Alignof(cull_level) == 0 && !(planes & ~CULL_ALL_PLANES));
	for (uint32_t plane = 0; plane < CULL_PLANES; plane++)
		cells->inside[plane] = 0;
	for (; planes; planes &= planes - 1) {
		uint32_t plane = (uint32_t)__builtin_ctz(planes);
		__m512d high = _mm512_load_pd(level->high[plane]), low = _mm512_load_pd(level->low[plane]);
		__m512d center0 = _mm512_set1_pd(cells->center[0][plane]), center1 = _mm512_set1_pd(cells->center[1][plane]);
		__m512d most0 = _mm512_add_pd(_mm512_add_pd(center0, high), reach0);
		__m512d most1 = _mm512_add_pd(_mm512_add_pd(center1, high), reach1);
		rejected |= (uint32_t)_mm512_cmp_pd_mask(most0, zero, _CMP_LT_OQ) |
		            (uint32_t)_mm512_cmp_pd_mask(most1, zero, _CMP_LT_OQ) << 8;
		uint32_t inside = (uint32_t)_mm512_cmp_pd_mask(_mm512_add_pd(center0, low), zero, _CMP_GE_OQ) |
		                  (uint32_t)_mm512_cmp_pd_mask(_mm512_add_pd(center1, low), zero, _CMP_GE_OQ) << 8;
		cells->inside[plane] = (uint16_t)inside;
	}
	cells->rejected = (uint16_t)rejected;
}

static uint32_t avx512_gather(uint64_t *bits, size_t stride, uint32_t count, uint32_t words)
{
	return scalar_gather(bits, stride, count, words);
}

INLINE uint32_t avx512_expand_word(uint64_t set, uint32_t first_id, uint32_t *ids)
{
	uint32_t count = (uint32_t)__builtin_popcountll(set);
	if (count <= 4)
		return scalar_expand_word(set, first_id, ids);
	__m512i id = avx512_iota(first_id);
	for (uint32_t part = 0; part < 4; part++, set >>= 16) {
		ids += avx512_append(ids, (uint32_t)set & 0xffffu, id);
		id = _mm512_add_epi32(id, _mm512_set1_epi32(16));
	}
	return count;
}

/* Words of bits that are not zero, and the id that the first bit of each stands for; eight more, because collecting
 * stores eight at a time. */
typedef struct avx512_words {
	uint64_t word[AVX512_PIECE + 8];
	uint32_t first[AVX512_PIECE + 8];
} avx512_words;

/* Moves the words that are not zero to out, clears them in bits, and returns their number. It has no branch for each
 * word, which would be mispredicted. */
INLINE uint32_t avx512_collect(avx512_words *out, uint64_t *bits, uint32_t words, uint32_t first)
{
	uint32_t count = 0;
	__m256i firsts =
		_mm256_add_epi32(_mm256_set1_epi32((int)first), _mm256_setr_epi32(0, 64, 128, 192, 256, 320, 384, 448));
	for (uint32_t at = 0; at < words; at += 8) {
		__m512i eight = _mm512_loadu_si512(bits + at);
		__mmask8 full = _mm512_test_epi64_mask(eight, eight);
		_mm512_storeu_si512(out->word + count, _mm512_maskz_compress_epi64(full, eight));
		_mm256_storeu_si256((__m256i *)(out->first + count), _mm256_maskz_compress_epi32(full, firsts));
		_mm512_storeu_si512(bits + at, _mm512_setzero_si512());
		count += (uint32_t)__builtin_popcount(full);
		firsts = _mm256_add_epi32(firsts, _mm256_set1_epi32(512));
	}
	return count;
}

static uint32_t avx512_expand(uint64_t *bits, uint32_t words, uint32_t first_id, uint32_t *ids)
{
	avx512_words full;
	uint32_t found = 0;
	STILB_ASSERT(words % CULL_BITS_WORDS == 0);
	for (uint32_t at = 0; at < words; at += AVX512_PIECE) {
		uint32_t piece = words - at < AVX512_PIECE ? words - at : AVX512_PIECE;
		uint32_t count = avx512_collect(&full, bits + at, piece, first_id + at * 64);
		for (uint32_t i = 0; i < count; i++)
			found += avx512_expand_word(full.word[i], full.first[i], ids + found);
	}
	return found;
}

const cull_kernels cull_kernels_avx512 = {
	.flat = avx512_flat,
	.all = avx512_all,
	.test = avx512_test_bits,
	.sixteen = avx512_sixteen,
	.gather = avx512_gather,
	.expand = avx512_expand,
};
#endif
