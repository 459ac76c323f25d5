/* Allocations that are counted and fail when told to. For tests linked with --wrap=malloc, --wrap=calloc and
 * --wrap=realloc; include it in one file of a test. */
#ifndef FAILING_MEMORY_H
#define FAILING_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

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
	return allocation_fails() ? NULL : __real_realloc(memory, size);
}

#endif
