/* Allocations that are counted and fail when told to; realloc always moves, and what it leaves behind is overwritten
 * and freed, so that an old pointer that is still used shows. For tests linked with --wrap=malloc, --wrap=calloc and
 * --wrap=realloc; include it in one file of a test. */
#ifndef FAILING_MEMORY_H
#define FAILING_MEMORY_H

#include <malloc.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static int fail_allocation = -1; /* so many succeed, then one fails; -1: never */
static int allocations __attribute__((unused));

static bool allocation_fails(void)
{
	allocations++;
	return fail_allocation >= 0 && fail_allocation-- == 0;
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size)
{
	return allocation_fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	if (allocation_fails())
		return NULL;
	size_t old_size = memory ? malloc_usable_size(memory) : 0;
	void *moved = __real_malloc(size);
	if (moved && memory) {
		memcpy(moved, memory, old_size < size ? old_size : size);
		memset(memory, 0xdd, old_size);
		free(memory);
	}
	return moved;
}

#endif
