/* Arrays that grow. */
#ifndef STILB_PROF_ARRAY_H
#define STILB_PROF_ARRAY_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* The items with room for count > 0 of that size, maybe elsewhere; NULL: no memory, and all stays as it was. */
static inline void *prof_array_room(void *items, size_t size, size_t count, size_t *capacity)
{
	if (count <= *capacity)
		return items;
	const size_t more = *capacity + *capacity / 2 + 64, wanted = count > more ? count : more;
	void *grown = wanted <= PTRDIFF_MAX / size ? realloc(items, wanted * size) : NULL;
	if (grown != NULL)
		*capacity = wanted;
	return grown;
}

#endif
