/* The innermost loops with AVX-512: sixteen lights at a time. */
#include "light/light_scalar.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define LANES 16u

static __m512 avx512_set(float x)
{
	return _mm512_set1_ps(x);
}

/* Those of count lanes, from lane 0 on. */
static __mmask16 avx512_lanes(uint32_t count)
{
	return (__mmask16)(count >= LANES ? 0xffffu : (1u << count) - 1);
}

/* Squared distance by which a point lies outside two planes; *lower: outside the second. */
static __m512 avx512_beyond(__m512 y, __m512 w, const light_planes *rows, uint32_t first, uint32_t end,
                            __mmask16 *lower)
{
	__m512 above = _mm512_sub_ps(_mm512_mul_ps(w, avx512_set(rows->offset[first])),
	                             _mm512_mul_ps(y, avx512_set(rows->inverse[first])));
	__m512 below = _mm512_sub_ps(_mm512_mul_ps(y, avx512_set(rows->inverse[end])),
	                             _mm512_mul_ps(w, avx512_set(rows->offset[end])));
	*lower = _mm512_cmp_ps_mask(below, above, _CMP_GT_OQ);
	return _mm512_max_ps(_mm512_max_ps(below, above), _mm512_setzero_ps());
}

static void avx512_slices(const light_depths *depths, const float *depth, const float *radius, uint32_t count,
                          uint8_t *first, uint8_t *last)
{
	__m512i one = _mm512_set1_epi32(1);
	for (uint32_t i = 0; i < count; i += LANES) {
		__m512 at = _mm512_loadu_ps(depth + i), reach = _mm512_loadu_ps(radius + i);
		__m512 from = _mm512_sub_ps(at, reach), to = _mm512_add_ps(at, reach);
		__m512i ended = _mm512_setzero_si512(), begun = ended;
		for (uint32_t k = 0; k + 1 < depths->count; k++) {
			__mmask16 before = _mm512_cmp_ps_mask(avx512_set(depths->far_z[k]), from, _CMP_LT_OQ);
			__mmask16 behind = _mm512_cmp_ps_mask(avx512_set(depths->near_z[k + 1]), to, _CMP_LE_OQ);
			ended = _mm512_mask_add_epi32(ended, before, ended, one);
			begun = _mm512_mask_add_epi32(begun, behind, begun, one);
		}
		_mm_storeu_si128((__m128i *)(first + i), _mm512_cvtepi32_epi8(ended));
		_mm_storeu_si128((__m128i *)(last + i), _mm512_cvtepi32_epi8(begun));
	}
}

/* Stores the lanes of the mask side by side. */
static void avx512_keep(light_picked *to, uint32_t at, __mmask16 in, __m512 x, __m512 y, __m512 w, __m512 square,
                        __m512i number)
{
	_mm512_storeu_ps(to->x + at, _mm512_maskz_compress_ps(in, x));
	_mm512_storeu_ps(to->y + at, _mm512_maskz_compress_ps(in, y));
	_mm512_storeu_ps(to->w + at, _mm512_maskz_compress_ps(in, w));
	_mm512_storeu_ps(to->square + at, _mm512_maskz_compress_ps(in, square));
	_mm512_storeu_si512(to->number + at, _mm512_maskz_compress_epi32(in, number));
}

static void avx512_pick(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_chunk *chunk,
                        light_picked *picked)
{
	__m128i slice = _mm_set1_epi8((char)slab->slice);
	__m512 zero = _mm512_setzero_ps();
	uint32_t count = picked->count;
	for (uint32_t i = 0; i < chunk->count; i += LANES) {
		__mmask16 in = _mm_mask_cmple_epu8_mask(avx512_lanes(chunk->count - i),
		                                        _mm_loadu_si128((const __m128i *)(chunk->first_slice + i)), slice);
		in = _mm_mask_cmpge_epu8_mask(in, _mm_loadu_si128((const __m128i *)(chunk->last_slice + i)), slice);
		if (!in)
			continue;
		__m512 depth = _mm512_loadu_ps(chunk->depth + i), radius = _mm512_loadu_ps(chunk->radius + i);
		__m512 step = _mm512_sub_ps(_mm512_max_ps(_mm512_sub_ps(avx512_set(slab->near_z), depth), zero),
		                            _mm512_max_ps(_mm512_sub_ps(depth, avx512_set(slab->far_z)), zero));
		__m512 x = _mm512_add_ps(_mm512_loadu_ps(chunk->x + i), _mm512_mul_ps(step, avx512_set(slab->along[0])));
		__m512 y = _mm512_add_ps(_mm512_loadu_ps(chunk->y + i), _mm512_mul_ps(step, avx512_set(slab->along[1])));
		__m512 w = _mm512_add_ps(_mm512_loadu_ps(chunk->w + i), _mm512_mul_ps(step, avx512_set(slab->along[2])));
		__m512 square = _mm512_mul_ps(_mm512_mul_ps(radius, radius), avx512_set(LIGHT_SQUARE_GROWTH));
		square = _mm512_sub_ps(square, _mm512_mul_ps(step, step));
		__mmask16 lower;
		__m512 beyond = avx512_beyond(y, w, slab->rows, first_row, end_row, &lower);
		in = _mm512_mask_cmp_ps_mask(in, _mm512_mul_ps(beyond, beyond), square, _CMP_LE_OQ);
		avx512_keep(picked, count, in, x, y, w, square, _mm512_loadu_si512(chunk->number + i));
		count += (uint32_t)__builtin_popcount(in);
	}
	picked->count = count;
}

static void avx512_narrow(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_picked *from,
                          light_picked *to)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < from->count; i += LANES) {
		__m512 y = _mm512_loadu_ps(from->y + i), w = _mm512_loadu_ps(from->w + i);
		__m512 square = _mm512_loadu_ps(from->square + i);
		__mmask16 lower, in = avx512_lanes(from->count - i);
		__m512 beyond = avx512_beyond(y, w, slab->rows, first_row, end_row, &lower);
		in = _mm512_mask_cmp_ps_mask(in, _mm512_mul_ps(beyond, beyond), square, _CMP_LE_OQ);
		avx512_keep(to, count, in, _mm512_loadu_ps(from->x + i), y, w, square, _mm512_loadu_si512(from->number + i));
		count += (uint32_t)__builtin_popcount(in);
	}
	to->count = count;
}

/* Spheres of one row. */
typedef struct avx512_row {
	__m512 x, w, square;
	__mmask16 in;
} avx512_row;

static avx512_row avx512_shrink(const light_slab *slab, const light_picked *picked, uint32_t at, uint32_t row)
{
	const light_planes *rows = slab->rows;
	__m512 y = _mm512_loadu_ps(picked->y + at), w = _mm512_loadu_ps(picked->w + at);
	__mmask16 lower;
	__m512 beyond = avx512_beyond(y, w, rows, row, row + 1, &lower);
	__m512 square = _mm512_sub_ps(_mm512_loadu_ps(picked->square + at), _mm512_mul_ps(beyond, beyond));
	__m512 along_x = _mm512_mask_blend_ps(lower, avx512_set(rows->x[row]), avx512_set(-rows->x[row + 1]));
	__m512 along_w = _mm512_mask_blend_ps(lower, avx512_set(rows->w[row]), avx512_set(-rows->w[row + 1]));
	return (avx512_row){
		.x = _mm512_add_ps(_mm512_loadu_ps(picked->x + at), _mm512_mul_ps(beyond, along_x)),
		.w = _mm512_add_ps(w, _mm512_mul_ps(beyond, along_w)),
		.square = square,
		.in = _mm512_mask_cmp_ps_mask(avx512_lanes(picked->count - at), square, _mm512_setzero_ps(), _CMP_GE_OQ),
	};
}

/* Spans as pairs of 16 bits, for the lanes of row->in; takes those away that reach no column. */
static __m512i avx512_tangents(const light_slab *slab, avx512_row *row)
{
	const light_columns *c = slab->columns;
	__m512 zero = _mm512_setzero_ps(), end = avx512_set((float)c->count);
	__m512 x = row->x, w = row->w, square = row->square;
	__m512 ww = _mm512_mul_ps(w, w), xw = _mm512_mul_ps(x, w);
	__m512 inverse = _mm512_div_ps(avx512_set(1.0f), _mm512_sub_ps(ww, _mm512_mul_ps(avx512_set(c->ww), square)));
	__m512 middle = _mm512_mul_ps(_mm512_sub_ps(xw, _mm512_mul_ps(avx512_set(c->xw), square)), inverse);
	__m512 gradient = _mm512_sub_ps(_mm512_mul_ps(avx512_set(c->xx), ww), _mm512_mul_ps(avx512_set(c->xw + c->xw), xw));
	gradient = _mm512_add_ps(gradient, _mm512_mul_ps(avx512_set(c->ww), _mm512_mul_ps(x, x)));
	__m512 root = _mm512_max_ps(_mm512_sub_ps(gradient, _mm512_mul_ps(avx512_set(c->area), square)), zero);
	__m512 radius = _mm512_sqrt_ps(square), half = _mm512_mul_ps(_mm512_mul_ps(radius, _mm512_sqrt_ps(root)), inverse);
	__m512 terms = _mm512_add_ps(_mm512_abs_ps(middle), half);
	half = _mm512_add_ps(half, _mm512_mul_ps(terms, avx512_set(LIGHT_TANGENT_GROWTH)));
	__m512 near = avx512_set(slab->inverse_near), far = avx512_set(slab->inverse_far);
	__m512 reach = _mm512_mul_ps(radius, avx512_set(c->length));
	__m512 low = _mm512_sub_ps(x, reach), high = _mm512_add_ps(x, reach);
	__m512 least = _mm512_min_ps(_mm512_mul_ps(low, near), _mm512_mul_ps(low, far));
	__m512 most = _mm512_max_ps(_mm512_mul_ps(high, near), _mm512_mul_ps(high, far));
	__m512 scale = avx512_set(c->scale);
	__m512 first = _mm512_add_ps(_mm512_mul_ps(_mm512_max_ps(_mm512_sub_ps(middle, half), least), scale),
	                             avx512_set(c->shift - LIGHT_COLUMN_GROWTH));
	__m512 last = _mm512_add_ps(_mm512_mul_ps(_mm512_min_ps(_mm512_add_ps(middle, half), most), scale),
	                            avx512_set(c->shift + LIGHT_COLUMN_GROWTH));
	row->in = _mm512_mask_cmp_ps_mask(row->in, first, end, _CMP_LT_OQ);
	row->in = _mm512_mask_cmp_ps_mask(row->in, last, zero, _CMP_GE_OQ);
	row->in = _mm512_mask_cmp_ps_mask(row->in, first, last, _CMP_LE_OQ);
	__m512i from = _mm512_cvttps_epi32(_mm512_max_ps(first, zero));
	__m512i to = _mm512_cvttps_epi32(_mm512_min_ps(last, _mm512_sub_ps(end, avx512_set(1.0f))));
	return _mm512_or_si512(from, _mm512_slli_epi32(to, 16));
}

/* The span of one sphere too near to the eye for tangents: by the distance from each plane. */
static bool avx512_span_near(const light_columns *c, float x, float w, float square, light_span *span)
{
	__m512 radius = avx512_set(sqrtf(square)), least = _mm512_sub_ps(_mm512_setzero_ps(), radius);
	uint32_t first = c->count, last = 0;
	for (uint32_t i = 0; i < c->count; i += LANES) {
		__m512 left = _mm512_sub_ps(_mm512_mul_ps(avx512_set(x), _mm512_loadu_ps(c->planes.inverse + i)),
		                            _mm512_mul_ps(avx512_set(w), _mm512_loadu_ps(c->planes.offset + i)));
		__m512 right = _mm512_sub_ps(_mm512_mul_ps(avx512_set(x), _mm512_loadu_ps(c->planes.inverse + i + 1)),
		                             _mm512_mul_ps(avx512_set(w), _mm512_loadu_ps(c->planes.offset + i + 1)));
		__mmask16 in = _mm512_mask_cmp_ps_mask(avx512_lanes(c->count - i), left, least, _CMP_GE_OQ);
		in = _mm512_mask_cmp_ps_mask(in, right, radius, _CMP_LE_OQ);
		if (!in)
			continue;
		first = first < i ? first : i + (uint32_t)__builtin_ctz(in);
		last = i + 31 - (uint32_t)__builtin_clz(in);
	}
	*span = (light_span){(uint16_t)first, (uint16_t)last};
	return first <= last;
}

/* Adds the spans of lanes of which some are near. */
static void avx512_spans_near(const light_slab *slab, const avx512_row *row, const uint32_t *from, uint32_t *numbers,
                              light_span *spans, uint32_t *count)
{
	const light_columns *columns = slab->columns;
	float x[LANES], w[LANES], square[LANES];
	_mm512_storeu_ps(x, row->x);
	_mm512_storeu_ps(w, row->w);
	_mm512_storeu_ps(square, row->square);
	for (uint32_t left = row->in; left; left &= left - 1) {
		uint32_t i = (uint32_t)__builtin_ctz(left);
		bool far = scalar_is_far(columns, w[i], square[i]);
		if (far ? scalar_span_far(slab, x[i], w[i], square[i], &spans[*count])
		        : avx512_span_near(columns, x[i], w[i], square[i], &spans[*count]))
			numbers[(*count)++] = from[i];
	}
}

static uint32_t avx512_spans(const light_slab *slab, const light_picked *picked, uint32_t row, uint32_t *numbers,
                             light_span *spans)
{
	const light_columns *columns = slab->columns;
	uint32_t count = 0;
	for (uint32_t i = 0; i < picked->count; i += LANES) {
		avx512_row lanes = avx512_shrink(slab, picked, i, row);
		if (!lanes.in)
			continue;
		__m512 limit =
			_mm512_mul_ps(_mm512_mul_ps(avx512_set(columns->ww), lanes.square), avx512_set(LIGHT_TANGENT_LIMIT));
		__mmask16 far = _mm512_mask_cmp_ps_mask(lanes.in, _mm512_mul_ps(lanes.w, lanes.w), limit, _CMP_GT_OQ);
		far = _mm512_mask_cmp_ps_mask(far, lanes.w, _mm512_setzero_ps(), _CMP_GT_OQ);
		if (far != lanes.in) {
			avx512_spans_near(slab, &lanes, picked->number + i, numbers, spans, &count);
			continue;
		}
		__m512i found = avx512_tangents(slab, &lanes);
		_mm512_storeu_si512(spans + count, _mm512_maskz_compress_epi32(lanes.in, found));
		_mm512_storeu_si512(numbers + count,
		                    _mm512_maskz_compress_epi32(lanes.in, _mm512_loadu_si512(picked->number + i)));
		count += (uint32_t)__builtin_popcount(lanes.in);
	}
	return count;
}

/* A span (first, last) holds a column c if neither half of (first, ~last) exceeds that of (c, ~c). */
static void avx512_fill_dense(uint32_t *numbers, light_span *spans, uint32_t count, uint32_t *cursors, uint32_t columns,
                              uint32_t end, uint32_t *ids)
{
	__m512i flip = _mm512_set1_epi32((int)0xffff0000u);
	for (uint32_t i = count; i % LANES != 0; i++)
		spans[i] = LIGHT_SPAN_NONE;
	for (uint32_t c = 0; c < columns; c++) {
		__m512i column = _mm512_set1_epi32((int)(c | (0xffffu - c) << 16));
		uint32_t at = cursors[c];
		for (uint32_t i = 0; i < count; i += LANES) {
			__m512i beyond = _mm512_subs_epu16(_mm512_xor_si512(_mm512_loadu_si512(spans + i), flip), column);
			__mmask16 in = _mm512_testn_epi32_mask(beyond, beyond);
			__m512i lights = _mm512_maskz_compress_epi32(in, _mm512_loadu_si512(numbers + i));
			uint32_t found = (uint32_t)__builtin_popcount(in);
			if (at + LANES <= end)
				_mm512_storeu_si512(ids + at, lights);
			else
				_mm512_mask_storeu_epi32(ids + at, avx512_lanes(found), lights);
			at += found;
		}
	}
}

const light_kernels light_kernels_avx512 = {
	.slices = avx512_slices,
	.pick = avx512_pick,
	.narrow = avx512_narrow,
	.spans = avx512_spans,
	.trim = light_trim_avx2,
	.fill_dense = avx512_fill_dense,
};
#endif
