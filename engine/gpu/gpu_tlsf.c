/* gpu: two-level segregated fit. */
#include "gpu/gpu_tlsf_internal.h"

#include <stdlib.h>
#include <string.h>

#define TLSF_SECOND_BITS 4u

static_assert(GPU_TLSF_SECOND == 1u << TLSF_SECOND_BITS, "lists of a power of two");

/* ---- lists by size ----------------------------------------------------------------------------------------------- */

typedef struct tlsf_list {
	uint32_t first, second;
} tlsf_list;

/* The list of holes of so many units: with all sizes up to 15 units one list each, then 16 for each power of two. */
static tlsf_list list_of(uint32_t units)
{
	if (units < GPU_TLSF_SECOND)
		return (tlsf_list){0, units};
	uint32_t power = 31u - (uint32_t)__builtin_clz(units);
	return (tlsf_list){power - TLSF_SECOND_BITS + 1, units >> (power - TLSF_SECOND_BITS) & (GPU_TLSF_SECOND - 1)};
}

/* The first list of which every hole has at least so many units. *fits: there is one. */
static tlsf_list list_at_least(uint32_t units, bool *fits)
{
	*fits = true;
	if (units < GPU_TLSF_SECOND)
		return list_of(units);
	uint32_t power = 31u - (uint32_t)__builtin_clz(units);
	uint32_t step = (1u << (power - TLSF_SECOND_BITS)) - 1u;
	*fits = units <= UINT32_MAX - step;
	return list_of(*fits ? units + step : units);
}

static void list_add(gpu_tlsf *tlsf, uint32_t index)
{
	gpu_tlsf_range *range = &tlsf->ranges[index];
	tlsf_list list = list_of(range->count);
	uint32_t *head = &tlsf->lists[list.first][list.second];
	range->free = true;
	range->last = GPU_TLSF_NONE;
	range->next = *head;
	if (*head != GPU_TLSF_NONE)
		tlsf->ranges[*head].last = index;
	*head = index;
	tlsf->first_bits |= 1u << list.first;
	tlsf->second_bits[list.first] = (uint16_t)(tlsf->second_bits[list.first] | 1u << list.second);
	tlsf->free_units += range->count;
}

static void list_remove(gpu_tlsf *tlsf, uint32_t index)
{
	gpu_tlsf_range *range = &tlsf->ranges[index];
	tlsf_list list = list_of(range->count);
	STILB_ASSERT(range->free);
	if (range->next != GPU_TLSF_NONE)
		tlsf->ranges[range->next].last = range->last;
	if (range->last != GPU_TLSF_NONE)
		tlsf->ranges[range->last].next = range->next;
	else
		tlsf->lists[list.first][list.second] = range->next;
	if (tlsf->lists[list.first][list.second] == GPU_TLSF_NONE) {
		tlsf->second_bits[list.first] = (uint16_t)(tlsf->second_bits[list.first] & ~(1u << list.second));
		if (tlsf->second_bits[list.first] == 0)
			tlsf->first_bits &= ~(1u << list.first);
	}
	range->free = false;
	tlsf->free_units -= range->count;
}

/* A hole of at least so many units. */
static uint32_t list_find(const gpu_tlsf *tlsf, uint32_t units)
{
	bool fits;
	tlsf_list list = list_at_least(units, &fits);
	if (!fits)
		return GPU_TLSF_NONE;
	uint32_t second = tlsf->second_bits[list.first] & ~0u << list.second;
	if (second == 0) {
		uint32_t first = list.first + 1 < 32 ? tlsf->first_bits & ~0u << (list.first + 1) : 0;
		if (first == 0)
			return GPU_TLSF_NONE;
		list.first = (uint32_t)__builtin_ctz(first);
		second = tlsf->second_bits[list.first];
	}
	return tlsf->lists[list.first][__builtin_ctz(second)];
}

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

/* Makes the array have at least two unused elements, as taking a range needs. */
static bool ranges_reserve(gpu_tlsf *tlsf)
{
	if (tlsf->unused != GPU_TLSF_NONE && tlsf->ranges[tlsf->unused].next != GPU_TLSF_NONE)
		return true;
	if (tlsf->capacity > UINT32_MAX / 2)
		return false;
	uint32_t larger = tlsf->capacity ? tlsf->capacity * 2 : 8;
	gpu_tlsf_range *grown = realloc(tlsf->ranges, larger * sizeof *grown);
	if (!grown)
		return false;
	tlsf->ranges = grown;
	for (uint32_t r = tlsf->capacity; r < larger; r++) {
		grown[r] = (gpu_tlsf_range){.next = tlsf->unused};
		tlsf->unused = r;
	}
	tlsf->capacity = larger;
	return true;
}

/* An element for a range; there is one. */
static uint32_t range_new(gpu_tlsf *tlsf)
{
	uint32_t index = tlsf->unused;
	STILB_ASSERT(index != GPU_TLSF_NONE);
	tlsf->unused = tlsf->ranges[index].next;
	return index;
}

static void range_drop(gpu_tlsf *tlsf, uint32_t index)
{
	tlsf->ranges[index] = (gpu_tlsf_range){.next = tlsf->unused};
	tlsf->unused = index;
}

/* Cuts a range that is in no list behind its first `units`; returns the new one, which is in no list, either. */
static uint32_t range_cut(gpu_tlsf *tlsf, uint32_t index, uint32_t units)
{
	uint32_t cut = range_new(tlsf);
	gpu_tlsf_range *range = &tlsf->ranges[index];
	STILB_ASSERT(units > 0 && units < range->count);
	tlsf->ranges[cut] = (gpu_tlsf_range){
		.first = range->first + units,
		.count = range->count - units,
		.before = index,
		.behind = range->behind,
		.last = GPU_TLSF_NONE,
		.next = GPU_TLSF_NONE,
	};
	if (range->behind != GPU_TLSF_NONE)
		tlsf->ranges[range->behind].before = cut;
	range->behind = cut;
	range->count = units;
	return cut;
}

/* Makes a range part of the one before it; both are in no list. */
static void range_join(gpu_tlsf *tlsf, uint32_t before, uint32_t index)
{
	gpu_tlsf_range *range = &tlsf->ranges[index];
	tlsf->ranges[before].count += range->count;
	tlsf->ranges[before].behind = range->behind;
	if (range->behind != GPU_TLSF_NONE)
		tlsf->ranges[range->behind].before = before;
	range_drop(tlsf, index);
}

/* ---- for others -------------------------------------------------------------------------------------------------- */

bool gpu_tlsf_create(gpu_tlsf *tlsf, uint64_t bytes)
{
	STILB_ASSERT(bytes > 0 && bytes % GPU_TLSF_UNIT == 0 && bytes / GPU_TLSF_UNIT < UINT32_MAX);
	*tlsf = (gpu_tlsf){.units = (uint32_t)(bytes / GPU_TLSF_UNIT), .unused = GPU_TLSF_NONE};
	memset(tlsf->lists, 0xff, sizeof tlsf->lists);
	if (!ranges_reserve(tlsf))
		return false;
	uint32_t all = range_new(tlsf);
	tlsf->ranges[all] =
		(gpu_tlsf_range){.count = tlsf->units, .before = GPU_TLSF_NONE, .behind = GPU_TLSF_NONE, .next = GPU_TLSF_NONE};
	list_add(tlsf, all);
	return true;
}

void gpu_tlsf_finish(gpu_tlsf *tlsf)
{
	free(tlsf->ranges);
	*tlsf = (gpu_tlsf){0};
}

uint32_t gpu_tlsf_take(gpu_tlsf *tlsf, uint64_t bytes, uint64_t align, uint64_t *offset)
{
	STILB_ASSERT(bytes > 0 && align > 0 && (align & (align - 1)) == 0);
	uint64_t units = (bytes + GPU_TLSF_UNIT - 1) / GPU_TLSF_UNIT;
	uint64_t step = align > GPU_TLSF_UNIT ? align / GPU_TLSF_UNIT : 1;
	if (bytes > UINT64_MAX - GPU_TLSF_UNIT || units > tlsf->free_units || step > tlsf->units || !ranges_reserve(tlsf))
		return GPU_TLSF_NONE;
	uint64_t wanted = units + step - 1; /* in any such hole there is an aligned place */
	uint32_t index = wanted <= tlsf->free_units ? list_find(tlsf, (uint32_t)wanted) : GPU_TLSF_NONE;
	if (index == GPU_TLSF_NONE)
		return GPU_TLSF_NONE;
	list_remove(tlsf, index);
	uint32_t skip = (uint32_t)((step - tlsf->ranges[index].first % step) % step);
	if (skip > 0) {
		uint32_t rest = range_cut(tlsf, index, skip);
		list_add(tlsf, index);
		index = rest;
	}
	if (tlsf->ranges[index].count > units)
		list_add(tlsf, range_cut(tlsf, index, (uint32_t)units));
	tlsf->used_ranges++;
	*offset = (uint64_t)tlsf->ranges[index].first * GPU_TLSF_UNIT;
	return index;
}

void gpu_tlsf_give(gpu_tlsf *tlsf, uint32_t index)
{
	STILB_ASSERT(index < tlsf->capacity && tlsf->ranges[index].count > 0 && !tlsf->ranges[index].free);
	uint32_t behind = tlsf->ranges[index].behind, before = tlsf->ranges[index].before;
	if (behind != GPU_TLSF_NONE && tlsf->ranges[behind].free) {
		list_remove(tlsf, behind);
		range_join(tlsf, index, behind);
	}
	if (before != GPU_TLSF_NONE && tlsf->ranges[before].free) {
		list_remove(tlsf, before);
		range_join(tlsf, before, index);
		index = before;
	}
	list_add(tlsf, index);
	tlsf->used_ranges--;
}

uint64_t gpu_tlsf_largest(const gpu_tlsf *tlsf)
{
	if (tlsf->first_bits == 0)
		return 0;
	uint32_t first = 31u - (uint32_t)__builtin_clz(tlsf->first_bits), largest = 0;
	uint32_t second = 31u - (uint32_t)__builtin_clz(tlsf->second_bits[first]);
	for (uint32_t r = tlsf->lists[first][second]; r != GPU_TLSF_NONE; r = tlsf->ranges[r].next)
		largest = tlsf->ranges[r].count > largest ? tlsf->ranges[r].count : largest;
	return (uint64_t)largest * GPU_TLSF_UNIT;
}
