/* gpu: elements with numbers. */
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

#define INDEX_MASK ((1u << GPU_INDEX_BITS) - 1)

void *gpu_table_at(const gpu_table *table, uint32_t index)
{
	if (index >= table->count)
		return NULL;
	gpu_entry *entry =
		(gpu_entry *)((char *)table->chunks[index / GPU_TABLE_CHUNK] + index % GPU_TABLE_CHUNK * table->element);
	return entry->used ? entry : NULL;
}

/* The element, used or not. */
static gpu_entry *table_element(const gpu_table *table, uint32_t index)
{
	return (gpu_entry *)((char *)table->chunks[index / GPU_TABLE_CHUNK] + index % GPU_TABLE_CHUNK * table->element);
}

void *gpu_table_add(gpu_table *table, uint32_t id_bits, uint64_t *id)
{
	STILB_ASSERT(table->element >= sizeof(gpu_entry) && id_bits > GPU_INDEX_BITS);
	uint32_t index = table->unused;
	if (index > 0)
		table->unused = table_element(table, --index)->next;
	else {
		index = table->count;
		if (index >= GPU_TABLE_CHUNK * GPU_TABLE_CHUNKS - 1)
			return NULL;
		void **chunk = &table->chunks[index / GPU_TABLE_CHUNK];
		if (!*chunk)
			*chunk = calloc(GPU_TABLE_CHUNK, table->element);
		if (!*chunk)
			return NULL;
		table->count++;
	}
	gpu_entry *entry = table_element(table, index);
	uint32_t most = id_bits >= 52 ? UINT32_MAX : (1u << (id_bits - GPU_INDEX_BITS)) - 1;
	uint32_t generation = entry->generation < most ? entry->generation + 1 : 1;
	memset(entry, 0, table->element);
	*entry = (gpu_entry){.generation = generation, .used = true};
	*id = (uint64_t)generation << GPU_INDEX_BITS | (index + 1);
	table->used++;
	return entry;
}

void *gpu_table_get(const gpu_table *table, uint64_t id)
{
	uint32_t index = (uint32_t)(id & INDEX_MASK);
	if (index == 0 || !table->chunks[(index - 1) / GPU_TABLE_CHUNK])
		return NULL;
	gpu_entry *entry = table_element(table, index - 1);
	return entry->used && entry->generation == id >> GPU_INDEX_BITS ? entry : NULL;
}

void gpu_table_hide(gpu_table *table, void *element)
{
	(void)table;
	gpu_entry *entry = element;
	entry->hidden = true;
	entry->generation++; /* the id after this one skips a number, which harms nobody */
}

void gpu_table_drop(gpu_table *table, void *element, uint32_t index)
{
	gpu_entry *entry = element;
	STILB_ASSERT(entry->used && table_element(table, index) == entry);
	entry->used = false;
	entry->next = table->unused;
	table->unused = index + 1;
	table->used--;
}

void gpu_table_finish(gpu_table *table)
{
	for (uint32_t c = 0; c < GPU_TABLE_CHUNKS; c++)
		free(table->chunks[c]);
	*table = (gpu_table){0};
}

bool gpu_array_reserve(gpu_array *array, size_t count, size_t size)
{
	if (array->items && count <= array->capacity)
		return true;
	size_t capacity = array->capacity < 16 ? 16 : array->capacity * 2;
	capacity = capacity < count ? count : capacity;
	void *items = capacity > SIZE_MAX / size ? NULL : realloc(array->items, capacity * size);
	if (!items)
		return false;
	array->items = items;
	array->capacity = capacity;
	return true;
}
