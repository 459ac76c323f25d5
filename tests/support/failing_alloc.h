/* stilb_memory_alloc, counted, and one call fails when told to. For tests linked with --wrap=stilb_memory_alloc;
 * include it in one file of a test. Of one thread. */
#ifndef FAILING_ALLOC_H
#define FAILING_ALLOC_H

#include <stddef.h>

static int fail_after = -1; /* so many allocations succeed, then one fails; -1: none does */
static int allocated __attribute__((unused));

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	allocated++;
	return fail_after >= 0 && fail_after-- == 0 ? NULL : __real_stilb_memory_alloc(count, size);
}

#endif
