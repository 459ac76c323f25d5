/* Splits points into parts that are close together: halves along the longest side of their box, and again. */
#include "geometry/geometry_clusters.h"

#include <float.h>
#include <math.h>

#define AXIS_CHANCE 0.5f /* jitter: how much longer a side may count than another one */
#define CUT_CHANCE 0.3f  /* jitter: how far a cut may be from the middle, parts of all */

static inline bool is_before(const geometry_spot *a, const geometry_spot *b, uint32_t axis)
{
	return a->at[axis] != b->at[axis] ? a->at[axis] < b->at[axis] : a->id < b->id;
}

static inline void exchange(geometry_spot *a, geometry_spot *b)
{
	geometry_spot other = *a;
	*a = *b;
	*b = other;
}

/* Of three places by chance the one with the middle spot. */
static uint32_t choose_divider(const geometry_spot *spots, uint32_t low, uint32_t high, uint32_t axis)
{
	uint64_t chance = stilb_random_u64(low, high);
	uint32_t n = high - low, a = low + (uint32_t)(chance & 0xffffff) % n, b = low + (uint32_t)(chance >> 40) % n;
	uint32_t c = low + n / 2;
	if (is_before(&spots[b], &spots[a], axis)) {
		uint32_t other = a;
		a = b;
		b = other;
	}
	return is_before(&spots[c], &spots[a], axis) ? a : is_before(&spots[b], &spots[c], axis) ? b : c;
}

/* Moves the `first` spots that come first along an axis to the front. Source: Hoare, "Algorithm 65: Find", 1961. */
static void select_first(geometry_spot *spots, uint32_t count, uint32_t first, uint32_t axis)
{
	uint32_t low = 0, high = count; /* the border is in between */
	while (first > low && first < high) {
		exchange(&spots[low], &spots[choose_divider(spots, low, high, axis)]);
		geometry_spot divider = spots[low];
		uint32_t i = low, j = high - 1;
		for (;;) {
			while (is_before(&spots[i], &divider, axis))
				i++;
			while (is_before(&divider, &spots[j], axis))
				j--;
			if (i >= j)
				break;
			exchange(&spots[i++], &spots[j--]);
		}
		if (first <= j) /* what is before j + 1 is at most the divider, the others are at least that */
			high = j + 1;
		else
			low = j + 1;
	}
}

static uint32_t longest_axis(const geometry_spot *spots, uint32_t count, const float weight[3])
{
	float lower[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, upper[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t axis = 0; axis < 3; axis++) {
			float at = spots[i].at[axis];
			lower[axis] = at < lower[axis] ? at : lower[axis];
			upper[axis] = at > upper[axis] ? at : upper[axis];
		}
	uint32_t best = 0;
	for (uint32_t axis = 1; axis < 3; axis++)
		if ((upper[axis] - lower[axis]) * weight[axis] > (upper[best] - lower[best]) * weight[best])
			best = axis;
	return best;
}

/* The parts from `from` to `to`. */
static void split_parts(geometry_spot *spots, uint32_t count, uint32_t parts, uint32_t from, uint32_t to,
                        uint32_t jitter)
{
	if (to - from < 2)
		return;
	uint32_t begin = (uint32_t)((uint64_t)count * from / parts), end = (uint32_t)((uint64_t)count * to / parts);
	float weight[3] = {1.0f, 1.0f, 1.0f}, place = 0.5f;
	if (jitter > 0) {
		uint64_t node = (uint64_t)from << 32 | to;
		for (uint32_t axis = 0; axis < 3; axis++)
			weight[axis] += AXIS_CHANCE * stilb_random_float(jitter, 4 * node + axis);
		place += CUT_CHANCE * (stilb_random_float(jitter, 4 * node + 3) - 0.5f);
	}
	uint32_t middle = from + (uint32_t)((float)(to - from) * place + 0.5f);
	middle = middle <= from ? from + 1 : middle >= to ? to - 1 : middle;
	uint32_t cut = (uint32_t)((uint64_t)count * middle / parts);
	select_first(spots + begin, end - begin, cut - begin, longest_axis(spots + begin, end - begin, weight));
	split_parts(spots, count, parts, from, middle, jitter);
	split_parts(spots, count, parts, middle, to, jitter);
}

void geometry_split(geometry_spot *spots, uint32_t count, uint32_t parts, uint32_t jitter)
{
	STILB_ASSERT(parts >= 1 && parts <= (count > 0 ? count : 1));
	split_parts(spots, count, parts, 0, parts, jitter);
}
