/*
 * failing_preload: loaded with LD_PRELOAD, makes one allocation of the main program fail, those of libraries never.
 *
 * STILB_FAIL_AT=N       the N-th allocation fails, counted from 0; not given: none does.
 * STILB_FAIL_MARK=FILE  created when it does, so that a test knows when N is past the last allocation.
 * Threads may allocate at once; which allocation has number N then differs from run to run.
 */
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

#define EXPORTED __attribute__((visibility("default")))

/* glibc's own, under names that nothing else defines. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static uintptr_t program_begin, program_end; /* where the main program is mapped; written before main */
static long fail_at = -1;
static atomic_long allocations;

static int note_program(struct dl_phdr_info *info, size_t size, void *data)
{
	(void)size, (void)data;
	program_begin = UINTPTR_MAX;
	for (int i = 0; i < info->dlpi_phnum; i++) {
		const ElfW(Phdr) *part = &info->dlpi_phdr[i];
		uintptr_t begin = info->dlpi_addr + part->p_vaddr, end = begin + part->p_memsz;
		if (part->p_type != PT_LOAD)
			continue;
		program_begin = begin < program_begin ? begin : program_begin;
		program_end = end > program_end ? end : program_end;
	}
	return 1; /* the first one is the main program */
}

__attribute__((constructor)) static void begin(void)
{
	const char *at = getenv("STILB_FAIL_AT");
	dl_iterate_phdr(note_program, NULL);
	fail_at = at ? strtol(at, NULL, 10) : -1;
	unsetenv("LD_PRELOAD"); /* the program's children are not meant */
}

static bool fails(const void *caller)
{
	uintptr_t place = (uintptr_t)caller;
	if (fail_at < 0 || place < program_begin || place >= program_end)
		return false;
	/* Relaxed: all that matters is that each allocation gets a number of its own. */
	if (atomic_fetch_add_explicit(&allocations, 1, memory_order_relaxed) != fail_at)
		return false;
	const char *mark = getenv("STILB_FAIL_MARK");
	int file = mark ? open(mark, O_CREAT | O_WRONLY | O_CLOEXEC, 0666) : -1;
	if (file >= 0)
		close(file);
	errno = ENOMEM;
	return true;
}

EXPORTED void *malloc(size_t size)
{
	return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

EXPORTED void *calloc(size_t count, size_t size)
{
	return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

EXPORTED void *realloc(void *memory, size_t size)
{
	return fails(__builtin_return_address(0)) ? NULL : __libc_realloc(memory, size);
}

EXPORTED void *aligned_alloc(size_t alignment, size_t size)
{
	return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}
