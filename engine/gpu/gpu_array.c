/* gpu_plan: arrays that grow. */
#include "gpu/gpu_plan_internal.h"

#include <stdlib.h>

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
