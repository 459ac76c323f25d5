/* Arrays that grow. */
#ifndef STILB_PROF_ARRAY_H
#define STILB_PROF_ARRAY_H

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Makes room for count > 0 items of size bytes each. array is the address of the pointer to the items; if they move, it
 * is stored at once together with the capacity, so that a caller that fails later leaves no pointer to freed memory.
 * False: no memory, and nothing has changed. */
static inline bool prof_array_room(void *array, size_t size, size_t count, size_t *capacity)
{
	assert(array && size > 0 && count > 0);
	if (count <= *capacity)
		return true;
	size_t more = *capacity + *capacity / 2 + 64, wanted = count > more ? count : more;
	void *items;
	memcpy(&items, array, sizeof items); /* a pointer to any type */
	items = wanted <= PTRDIFF_MAX / size ? realloc(items, wanted * size) : NULL;
	if (!items)
		return false;
	memcpy(array, &items, sizeof items);
	*capacity = wanted;
	return true;
}

#endif
