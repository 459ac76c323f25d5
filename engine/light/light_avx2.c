/* The innermost loops with AVX2: eight lights at a time. */
#include "light/light_scalar.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define LANES 8u

static __m256 avx2_set(float x)
{
	return _mm256_set1_ps(x);
}

/* All bits of those of count lanes, from lane 0 on. */
static __m256 avx2_lanes(uint32_t count)
{
	__m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
	return _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32((int)(count < LANES ? count : LANES)), lane));
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

/* Where the lanes of a mask go to stand side by side. */
static __m256i avx2_order(uint32_t mask)
{
	return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)&avx2_picks[mask]));
}

static void avx2_store(float *to, __m256 lanes, __m256i order)
{
	_mm256_storeu_ps(to, _mm256_permutevar8x32_ps(lanes, order));
}

/* Distance by which a point lies outside two planes; *lower: outside the second. */
static __m256 avx2_beyond(__m256 y, __m256 w, const light_planes *rows, uint32_t first, uint32_t end, __m256 *lower)
{
	__m256 above = _mm256_sub_ps(_mm256_mul_ps(w, avx2_set(rows->offset[first])),
	                             _mm256_mul_ps(y, avx2_set(rows->inverse[first])));
	__m256 below =
		_mm256_sub_ps(_mm256_mul_ps(y, avx2_set(rows->inverse[end])), _mm256_mul_ps(w, avx2_set(rows->offset[end])));
	*lower = _mm256_cmp_ps(below, above, _CMP_GT_OQ);
	return _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
}

/* All bits of the lanes whose lights reach the slice. */
static __m256 avx2_in_slice(const light_slab *slab, const light_chunk *chunk, uint32_t at)
{
	__m128i slice = _mm_set1_epi8((char)slab->slice);
	__m128i first = _mm_loadl_epi64((const __m128i *)(chunk->first_slice + at));
	__m128i last = _mm_loadl_epi64((const __m128i *)(chunk->last_slice + at));
	__m128i in = _mm_and_si128(_mm_cmpeq_epi8(_mm_min_epu8(first, slice), first),
	                           _mm_cmpeq_epi8(_mm_max_epu8(last, slice), last));
	return _mm256_and_ps(_mm256_castsi256_ps(_mm256_cvtepi8_epi32(in)), avx2_lanes(chunk->count - at));
}

/* Stores the lanes of the mask side by side. */
static void avx2_keep(light_picked *to, uint32_t at, uint32_t mask, __m256 x, __m256 y, __m256 w, __m256 square,
                      __m256 number)
{
	__m256i order = avx2_order(mask);
	avx2_store(to->x + at, x, order);
	avx2_store(to->y + at, y, order);
	avx2_store(to->w + at, w, order);
	avx2_store(to->square + at, square, order);
	avx2_store((float *)(to->number + at), number, order);
}

static void avx2_pick(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_chunk *chunk,
                      light_picked *picked)
{
	__m256 zero = _mm256_setzero_ps();
	uint32_t count = picked->count;
	for (uint32_t i = 0; i < chunk->count; i += LANES) {
		__m256 in = avx2_in_slice(slab, chunk, i);
		if (_mm256_testz_ps(in, in))
			continue;
		__m256 depth = _mm256_loadu_ps(chunk->depth + i), radius = _mm256_loadu_ps(chunk->radius + i);
		__m256 step = _mm256_sub_ps(_mm256_max_ps(_mm256_sub_ps(avx2_set(slab->near_z), depth), zero),
		                            _mm256_max_ps(_mm256_sub_ps(depth, avx2_set(slab->far_z)), zero));
		__m256 x = _mm256_add_ps(_mm256_loadu_ps(chunk->x + i), _mm256_mul_ps(step, avx2_set(slab->along[0])));
		__m256 y = _mm256_add_ps(_mm256_loadu_ps(chunk->y + i), _mm256_mul_ps(step, avx2_set(slab->along[1])));
		__m256 w = _mm256_add_ps(_mm256_loadu_ps(chunk->w + i), _mm256_mul_ps(step, avx2_set(slab->along[2])));
		__m256 square = _mm256_mul_ps(_mm256_mul_ps(radius, radius), avx2_set(LIGHT_SQUARE_GROWTH));
		square = _mm256_sub_ps(square, _mm256_mul_ps(step, step));
		__m256 lower, beyond = avx2_beyond(y, w, slab->rows, first_row, end_row, &lower);
		in = _mm256_and_ps(in, _mm256_cmp_ps(_mm256_mul_ps(beyond, beyond), square, _CMP_LE_OQ));
		uint32_t mask = (uint32_t)_mm256_movemask_ps(in);
		avx2_keep(picked, count, mask, x, y, w, square, _mm256_loadu_ps((const float *)(chunk->number + i)));
		count += (uint32_t)__builtin_popcount(mask);
	}
	picked->count = count;
}

static void avx2_narrow(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_picked *from,
                        light_picked *to)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < from->count; i += LANES) {
		__m256 y = _mm256_loadu_ps(from->y + i), w = _mm256_loadu_ps(from->w + i);
		__m256 square = _mm256_loadu_ps(from->square + i);
		__m256 lower, beyond = avx2_beyond(y, w, slab->rows, first_row, end_row, &lower);
		__m256 in = _mm256_cmp_ps(_mm256_mul_ps(beyond, beyond), square, _CMP_LE_OQ);
		uint32_t mask = (uint32_t)_mm256_movemask_ps(_mm256_and_ps(in, avx2_lanes(from->count - i)));
		avx2_keep(to, count, mask, _mm256_loadu_ps(from->x + i), y, w, square,
		          _mm256_loadu_ps((const float *)(from->number + i)));
		count += (uint32_t)__builtin_popcount(mask);
	}
	to->count = count;
}

/* Spheres of one row. */
typedef struct avx2_row {
	__m256 x, w, square;
	__m256 in;
} avx2_row;

static avx2_row avx2_shrink(const light_slab *slab, const light_picked *picked, uint32_t at, uint32_t row)
{
	const light_planes *rows = slab->rows;
	__m256 y = _mm256_loadu_ps(picked->y + at), w = _mm256_loadu_ps(picked->w + at);
	__m256 lower, beyond = avx2_beyond(y, w, rows, row, row + 1, &lower);
	__m256 square = _mm256_sub_ps(_mm256_loadu_ps(picked->square + at), _mm256_mul_ps(beyond, beyond));
	__m256 along_x = _mm256_blendv_ps(avx2_set(rows->x[row]), avx2_set(-rows->x[row + 1]), lower);
	__m256 along_w = _mm256_blendv_ps(avx2_set(rows->w[row]), avx2_set(-rows->w[row + 1]), lower);
	return (avx2_row){
		.x = _mm256_add_ps(_mm256_loadu_ps(picked->x + at), _mm256_mul_ps(beyond, along_x)),
		.w = _mm256_add_ps(w, _mm256_mul_ps(beyond, along_w)),
		.square = square,
		.in = _mm256_and_ps(avx2_lanes(picked->count - at), _mm256_cmp_ps(square, _mm256_setzero_ps(), _CMP_GE_OQ)),
	};
}

/* Spans as pairs of 16 bits, for the lanes of row->in; takes those away that reach no column. */
static __m256i avx2_tangents(const light_slab *slab, avx2_row *row)
{
	const light_columns *c = slab->columns;
	__m256 zero = _mm256_setzero_ps(), end = avx2_set((float)c->count), sign = avx2_set(-0.0f);
	__m256 x = row->x, w = row->w, square = row->square;
	__m256 ww = _mm256_mul_ps(w, w), xw = _mm256_mul_ps(x, w);
	__m256 inverse = _mm256_div_ps(avx2_set(1.0f), _mm256_sub_ps(ww, _mm256_mul_ps(avx2_set(c->ww), square)));
	__m256 middle = _mm256_mul_ps(_mm256_sub_ps(xw, _mm256_mul_ps(avx2_set(c->xw), square)), inverse);
	__m256 gradient = _mm256_sub_ps(_mm256_mul_ps(avx2_set(c->xx), ww), _mm256_mul_ps(avx2_set(c->xw + c->xw), xw));
	gradient = _mm256_add_ps(gradient, _mm256_mul_ps(avx2_set(c->ww), _mm256_mul_ps(x, x)));
	__m256 root = _mm256_max_ps(_mm256_sub_ps(gradient, _mm256_mul_ps(avx2_set(c->area), square)), zero);
	__m256 radius = _mm256_sqrt_ps(square), half = _mm256_mul_ps(_mm256_mul_ps(radius, _mm256_sqrt_ps(root)), inverse);
	__m256 terms = _mm256_add_ps(_mm256_andnot_ps(sign, middle), half);
	half = _mm256_add_ps(half, _mm256_mul_ps(terms, avx2_set(LIGHT_TANGENT_GROWTH)));
	__m256 near = avx2_set(slab->inverse_near), far = avx2_set(slab->inverse_far);
	__m256 reach = _mm256_mul_ps(radius, avx2_set(c->length));
	__m256 low = _mm256_sub_ps(x, reach), high = _mm256_add_ps(x, reach);
	__m256 least = _mm256_min_ps(_mm256_mul_ps(low, near), _mm256_mul_ps(low, far));
	__m256 most = _mm256_max_ps(_mm256_mul_ps(high, near), _mm256_mul_ps(high, far));
	__m256 scale = avx2_set(c->scale);
	__m256 first = _mm256_add_ps(_mm256_mul_ps(_mm256_max_ps(_mm256_sub_ps(middle, half), least), scale),
	                             avx2_set(c->shift - LIGHT_COLUMN_GROWTH));
	__m256 last = _mm256_add_ps(_mm256_mul_ps(_mm256_min_ps(_mm256_add_ps(middle, half), most), scale),
	                            avx2_set(c->shift + LIGHT_COLUMN_GROWTH));
	__m256 some = _mm256_and_ps(_mm256_cmp_ps(first, end, _CMP_LT_OQ), _mm256_cmp_ps(last, zero, _CMP_GE_OQ));
	row->in = _mm256_and_ps(row->in, _mm256_and_ps(some, _mm256_cmp_ps(first, last, _CMP_LE_OQ)));
	__m256i from = _mm256_cvttps_epi32(_mm256_max_ps(first, zero));
	__m256i to = _mm256_cvttps_epi32(_mm256_min_ps(last, _mm256_sub_ps(end, avx2_set(1.0f))));
	return _mm256_or_si256(from, _mm256_slli_epi32(to, 16));
}

/* The span of one sphere too near to the eye for tangents: by the distance from each plane. */
static bool avx2_span_near(const light_columns *c, float x, float w, float square, light_span *span)
{
	__m256 radius = avx2_set(sqrtf(square)), least = _mm256_sub_ps(_mm256_setzero_ps(), radius);
	uint32_t first = c->count, last = 0;
	for (uint32_t i = 0; i < c->count; i += LANES) {
		__m256 left = _mm256_sub_ps(_mm256_mul_ps(avx2_set(x), _mm256_loadu_ps(c->planes.inverse + i)),
		                            _mm256_mul_ps(avx2_set(w), _mm256_loadu_ps(c->planes.offset + i)));
		__m256 right = _mm256_sub_ps(_mm256_mul_ps(avx2_set(x), _mm256_loadu_ps(c->planes.inverse + i + 1)),
		                             _mm256_mul_ps(avx2_set(w), _mm256_loadu_ps(c->planes.offset + i + 1)));
		__m256 reached =
			_mm256_and_ps(_mm256_cmp_ps(left, least, _CMP_GE_OQ), _mm256_cmp_ps(right, radius, _CMP_LE_OQ));
		uint32_t in = (uint32_t)_mm256_movemask_ps(_mm256_and_ps(reached, avx2_lanes(c->count - i)));
		if (in == 0)
			continue;
		first = first < i ? first : i + (uint32_t)__builtin_ctz(in);
		last = i + 31 - (uint32_t)__builtin_clz(in);
	}
	*span = (light_span){(uint16_t)first, (uint16_t)last};
	return first <= last;
}

/* Adds the spans of lanes of which some are near. */
static void avx2_spans_near(const light_slab *slab, const avx2_row *row, const uint32_t *from, uint32_t *numbers,
                            light_span *spans, uint32_t *count)
{
	const light_columns *columns = slab->columns;
	float x[LANES], w[LANES], square[LANES];
	_mm256_storeu_ps(x, row->x);
	_mm256_storeu_ps(w, row->w);
	_mm256_storeu_ps(square, row->square);
	for (uint32_t left = (uint32_t)_mm256_movemask_ps(row->in); left; left &= left - 1) {
		uint32_t i = (uint32_t)__builtin_ctz(left);
		bool far = scalar_is_far(columns, w[i], square[i]);
		if (far ? scalar_span_far(slab, x[i], w[i], square[i], &spans[*count])
		        : avx2_span_near(columns, x[i], w[i], square[i], &spans[*count]))
			numbers[(*count)++] = from[i];
	}
}

static uint32_t avx2_spans(const light_slab *slab, const light_picked *picked, uint32_t row, uint32_t *numbers,
                           light_span *spans)
{
	const light_columns *columns = slab->columns;
	uint32_t count = 0;
	for (uint32_t i = 0; i < picked->count; i += LANES) {
		avx2_row lanes = avx2_shrink(slab, picked, i, row);
		if (_mm256_testz_ps(lanes.in, lanes.in))
			continue;
		__m256 limit = _mm256_mul_ps(_mm256_mul_ps(avx2_set(columns->ww), lanes.square), avx2_set(LIGHT_TANGENT_LIMIT));
		__m256 far = _mm256_and_ps(_mm256_cmp_ps(_mm256_mul_ps(lanes.w, lanes.w), limit, _CMP_GT_OQ),
		                           _mm256_cmp_ps(lanes.w, _mm256_setzero_ps(), _CMP_GT_OQ));
		if (!_mm256_testc_ps(far, lanes.in)) {
			avx2_spans_near(slab, &lanes, picked->number + i, numbers, spans, &count);
			continue;
		}
		__m256i found = avx2_tangents(slab, &lanes);
		uint32_t mask = (uint32_t)_mm256_movemask_ps(lanes.in);
		__m256i order = avx2_order(mask);
		_mm256_storeu_si256((__m256i *)(spans + count), _mm256_permutevar8x32_epi32(found, order));
		avx2_store((float *)(numbers + count), _mm256_loadu_ps((const float *)(picked->number + i)), order);
		count += (uint32_t)__builtin_popcount(mask);
	}
	return count;
}

static void avx2_slices(const light_depths *depths, const float *depth, const float *radius, uint32_t count,
                        uint8_t *first, uint8_t *last)
{
	for (uint32_t i = 0; i < count; i += LANES) {
		__m256 at = _mm256_loadu_ps(depth + i), reach = _mm256_loadu_ps(radius + i);
		__m256 from = _mm256_sub_ps(at, reach), to = _mm256_add_ps(at, reach);
		__m256i ended = _mm256_setzero_si256(), begun = ended;
		for (uint32_t k = 0; k + 1 < depths->count; k++) { /* a comparison that holds is -1 */
			__m256 before = _mm256_cmp_ps(avx2_set(depths->far_z[k]), from, _CMP_LT_OQ);
			__m256 behind = _mm256_cmp_ps(avx2_set(depths->near_z[k + 1]), to, _CMP_LE_OQ);
			ended = _mm256_sub_epi32(ended, _mm256_castps_si256(before));
			begun = _mm256_sub_epi32(begun, _mm256_castps_si256(behind));
		}
		__m256i zero = _mm256_setzero_si256();
		__m256i words = _mm256_permute4x64_epi64(_mm256_packus_epi32(ended, begun), 0xd8);
		__m256i bytes = _mm256_permute4x64_epi64(_mm256_packus_epi16(words, zero), 0x08);
		_mm_storel_epi64((__m128i *)(first + i), _mm256_castsi256_si128(bytes));
		_mm_storel_epi64((__m128i *)(last + i), _mm_srli_si128(_mm256_castsi256_si128(bytes), 8));
	}
}

static __m256 avx2_dot(const __m256 a[3], const float b[3])
{
	__m256 sum = _mm256_add_ps(_mm256_mul_ps(a[0], avx2_set(b[0])), _mm256_mul_ps(a[1], avx2_set(b[1])));
	return _mm256_add_ps(sum, _mm256_mul_ps(a[2], avx2_set(b[2])));
}

/* a * b, or a * c if that is less. */
static __m256 avx2_least(__m256 a, __m256 b, __m256 c)
{
	return _mm256_min_ps(_mm256_mul_ps(b, a), _mm256_mul_ps(c, a));
}

/* So many bits, from bit 0 on. */
static uint32_t avx2_low_bits(uint32_t count)
{
	return count < LANES ? (1u << count) - 1 : 0xffu;
}

/* Which of the columns from `column` on meet the cone. */
static inline uint32_t avx2_cone_meets(const light_cone_row *row, uint32_t column)
{
	const light_rays *rays = row->rays;
	const light_cone *cone = row->cone;
	__m256 x0 = _mm256_loadu_ps(rays->edge_x + column), x1 = _mm256_loadu_ps(rays->edge_x + column + 1), normal[3];
	__m256 y0 = avx2_set(row->y0), y1 = avx2_set(row->y1);
	__m256 x = _mm256_mul_ps(avx2_set(0.5f), _mm256_add_ps(x0, x1));
	for (int i = 0; i < 3; i++)
		normal[i] = _mm256_add_ps(avx2_set(row->across[i]), _mm256_mul_ps(x, avx2_set(row->across_x[i])));
	__m256 square = _mm256_add_ps(_mm256_mul_ps(normal[0], normal[0]), _mm256_mul_ps(normal[1], normal[1]));
	__m256 length = _mm256_sqrt_ps(_mm256_add_ps(square, _mm256_mul_ps(normal[2], normal[2])));
	__m256 toward = _mm256_div_ps(avx2_set(cone->cosine), _mm256_max_ps(length, avx2_set(LIGHT_ACROSS_MIN)));
	for (int i = 0; i < 3; i++)
		normal[i] = _mm256_sub_ps(_mm256_mul_ps(toward, normal[i]), avx2_set(cone->sine * cone->axis[i]));
	__m256 base = _mm256_add_ps(avx2_dot(normal, cone->base), avx2_least(avx2_dot(normal, rays->base_x), x0, x1));
	base = _mm256_add_ps(base, avx2_least(avx2_dot(normal, rays->base_y), y0, y1));
	__m256 ray = _mm256_add_ps(avx2_dot(normal, rays->ray), avx2_least(avx2_dot(normal, rays->ray_x), x0, x1));
	ray = _mm256_add_ps(ray, avx2_least(avx2_dot(normal, rays->ray_y), y0, y1));
	__m256 toward_eye = _mm256_cmp_ps(ray, _mm256_setzero_ps(), _CMP_LT_OQ);
	__m256 z = _mm256_blendv_ps(avx2_set(row->near_z), avx2_set(row->far_z), toward_eye);
	__m256 least = _mm256_add_ps(base, _mm256_mul_ps(z, ray));
	return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(least, avx2_set(cone->slack), _CMP_LE_OQ));
}

light_span light_trim_avx2(const light_cone_row *row, light_span span)
{
	uint32_t first = span.first, end = span.last + 1u, in = 0;
	for (; first < end && in == 0; first += LANES)
		in = avx2_cone_meets(row, first) & avx2_low_bits(end - first);
	if (in == 0)
		return LIGHT_SPAN_NONE;
	if (first >= end) /* the lanes that it began with were the last ones */
		return (light_span){(uint16_t)(first - LANES + (uint32_t)__builtin_ctz(in)),
		                    (uint16_t)(first - LANES + 31 - (uint32_t)__builtin_clz(in))};
	first += (uint32_t)__builtin_ctz(in) - LANES;
	for (in = 0; in == 0; end -= LANES) { /* ends at `first` at the latest; lanes before it do not matter */
		uint32_t at = end - first < LANES ? first : end - LANES;
		in = avx2_cone_meets(row, at) & avx2_low_bits(end - at);
		if (in != 0)
			return (light_span){(uint16_t)first, (uint16_t)(at + 31 - (uint32_t)__builtin_clz(in))};
	}
	return LIGHT_SPAN_NONE;
}

/* Lights that reach a block of columns. */
typedef struct avx2_block {
	uint32_t numbers[LIGHT_BLOCK_ROW + LANES];
	uint32_t columns[LIGHT_BLOCK_ROW + LANES]; /* a bit for each that they reach */
	uint32_t count;
} avx2_block;

/* count: padded to LANES by spans of no column. */
static void avx2_block_find(const uint32_t *numbers, const light_span *spans, uint32_t count, uint32_t column,
                            avx2_block *block)
{
	__m256i zero = _mm256_setzero_si256(), all = _mm256_set1_epi32((1 << LIGHT_BLOCK) - 1);
	__m256i begin = _mm256_set1_epi32((int)column), end = _mm256_set1_epi32((int)(column + LIGHT_BLOCK - 1));
	uint32_t at = 0;
	for (uint32_t i = 0; i < count; i += LANES) {
		__m256i span = _mm256_loadu_si256((const __m256i *)(spans + i));
		__m256i first = _mm256_and_si256(span, _mm256_set1_epi32(0xffff)), last = _mm256_srli_epi32(span, 16);
		__m256i from = _mm256_sllv_epi32(all, _mm256_max_epi32(_mm256_sub_epi32(first, begin), zero));
		__m256i to = _mm256_srlv_epi32(all, _mm256_max_epi32(_mm256_sub_epi32(end, last), zero));
		__m256i columns = _mm256_and_si256(from, to);
		uint32_t some = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(columns, zero)));
		__m256i order = avx2_order(some);
		avx2_store((float *)(block->numbers + at), _mm256_loadu_ps((const float *)(numbers + i)), order);
		avx2_store((float *)(block->columns + at), _mm256_castsi256_ps(columns), order);
		at += (uint32_t)__builtin_popcount(some);
	}
	block->count = at;
	_mm256_storeu_si256((__m256i *)(block->columns + at), zero);
}

/* Writes the list of a block's column, of which `bit` is the number. end: of ids. */
static void avx2_block_fill(const avx2_block *block, uint32_t bit, uint32_t at, uint32_t end, uint32_t *ids)
{
	__m128i up = _mm_cvtsi32_si128((int)(31 - bit));
	for (uint32_t i = 0; i < block->count; i += LANES) {
		__m256i columns = _mm256_sll_epi32(_mm256_loadu_si256((const __m256i *)(block->columns + i)), up);
		uint32_t in = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(columns));
		if (at + LANES <= end)
			avx2_store((float *)(ids + at), _mm256_loadu_ps((const float *)(block->numbers + i)), avx2_order(in));
		else
			for (uint32_t left = in, to = at; left; left &= left - 1)
				ids[to++] = block->numbers[i + (uint32_t)__builtin_ctz(left)];
		at += (uint32_t)__builtin_popcount(in);
	}
}

static void avx2_fill_dense(uint32_t *numbers, light_span *spans, uint32_t count, uint32_t *cursors, uint32_t columns,
                            uint32_t end, uint32_t *ids)
{
	avx2_block block;
	if (count > LIGHT_BLOCK_ROW) {
		light_fill(numbers, spans, count, cursors, ids);
		return;
	}
	for (uint32_t i = count; i % LANES != 0; i++)
		spans[i] = LIGHT_SPAN_NONE;
	for (uint32_t first = 0; first < columns; first += LIGHT_BLOCK) {
		avx2_block_find(numbers, spans, count, first, &block);
		for (uint32_t c = first; c < columns && c < first + LIGHT_BLOCK; c++)
			avx2_block_fill(&block, c - first, cursors[c], end, ids);
	}
}

const light_kernels light_kernels_avx2 = {
	.slices = avx2_slices,
	.pick = avx2_pick,
	.narrow = avx2_narrow,
	.spans = avx2_spans,
	.trim = light_trim_avx2,
	.fill_dense = avx2_fill_dense,
};
#endif
