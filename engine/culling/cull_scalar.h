/* Plain C that the files of several instruction sets include, so that each compiles it with its own flags. */
#ifndef STILB_CULL_SCALAR_H
#define STILB_CULL_SCALAR_H

#include "culling/cull_kernels.h"

#include <string.h>

/* The reference test of one sphere: all other code must give this result. */
static inline bool scalar_visible(cull_spheres spheres, uint32_t i, const stilb_plane *planes, uint32_t plane_count)
{
	bool visible = true;
	for (uint32_t p = 0; p < plane_count; p++) {
		stilb_plane plane = planes[p];
		float signed_distance =
			((spheres.x[i] * plane.x + spheres.y[i] * plane.y) + spheres.z[i] * plane.z) + plane.distance;
		visible &= signed_distance >= -spheres.radius[i];
	}
	return visible;
}

/* Copies the planes of the mask to the front of chosen, and returns their number. */
static inline uint32_t scalar_choose_planes(const stilb_frustum *frustum, uint32_t planes,
                                            stilb_plane chosen[CULL_PLANES])
{
	uint32_t count = 0;
	STILB_ASSERT(planes && !(planes & ~CULL_ALL_PLANES));
	for (uint32_t p = 0; p < CULL_PLANES; p++) {
		chosen[count] = frustum->planes[p]; /* branchless: overwritten by the next if p is not in the mask */
		count += planes >> p & 1;
	}
	return count;
}

static inline uint32_t scalar_gather(uint64_t *bits, size_t stride, uint32_t count, uint32_t words)
{
	uint32_t found = 0;
	STILB_ASSERT(count > 0 && words % CULL_BITS_WORDS == 0 && (count == 1 || stride >= words));
	for (uint32_t set = 1; set < count; set++) {
		uint64_t *from = bits + set * stride;
		for (uint32_t word = 0; word < words; word++) {
			bits[word] |= from[word];
			from[word] = 0;
		}
	}
	for (uint32_t word = 0; word < words; word++)
		found += (uint32_t)__builtin_popcountll(bits[word]);
	return found;
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "two ids are written as one number");

/* Writes the positions of the two lowest bits of *set, each plus an id (`first` holds that id in both halves), and
 * clears them in *set. It always writes two ids; where *set has fewer bits, what stands for the missing ones is not an
 * id and is to be overwritten or ignored. */
static inline void scalar_write_two(uint64_t *set, uint64_t first, uint32_t *ids)
{
	uint64_t low = (uint64_t)__builtin_ctzll(*set | 1ull << 63), rest = *set & (*set - 1);
	uint64_t two = first + (low | (uint64_t)__builtin_ctzll(rest | 1ull << 63) << 32);
	memcpy(ids, &two, sizeof two);
	*set = rest & (rest - 1);
}

/* Writes first_id plus the position of each set bit; returns their number. When culling rejects much, most words have
 * few bits: ids are always written four at a time, so that one branch is left, which is well predicted.
 * Source: Langdale and Lemire, "Parsing gigabytes of JSON per second", 2019, section 3.1.1. */
static inline uint32_t scalar_expand_word(uint64_t set, uint32_t first_id, uint32_t *ids)
{
	uint32_t count = (uint32_t)__builtin_popcountll(set);
	uint64_t first = (uint64_t)first_id << 32 | first_id;
	for (uint32_t done = 0; done < count; done += 4) {
		scalar_write_two(&set, first, ids + done);
		scalar_write_two(&set, first, ids + done + 2);
	}
	return count;
}

static inline uint32_t scalar_expand(uint64_t *bits, uint32_t words, uint32_t first_id, uint32_t *ids)
{
	uint32_t found = 0;
	STILB_ASSERT(words % CULL_BITS_WORDS == 0);
	for (uint32_t word = 0; word < words; word++) {
		if (!bits[word])
			continue;
		found += scalar_expand_word(bits[word], first_id + word * 64, ids + found);
		bits[word] = 0;
	}
	return found;
}

#endif
