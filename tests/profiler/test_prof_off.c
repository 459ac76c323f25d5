/* STILB_PROFILE_OFF leaves nothing behind: the code of an object with macros is that of an object without. The
 * arguments are the objects of test_prof_off_object.c: on, off, none. */
#include "support/test.h"

#include <elf.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char **paths;

typedef struct object {
	char *bytes;
	size_t size;
} object;

static object object_load(const char *path)
{
	object o = {.bytes = malloc(1 << 20)};
	FILE *file = fopen(path, "rb");
	assert_non_null(o.bytes);
	assert_non_null(file);
	o.size = fread(o.bytes, 1, 1 << 20, file);
	fclose(file);
	assert_in_range(o.size, sizeof(Elf64_Ehdr), (1 << 20) - 1);
	assert_memory_equal(o.bytes, ELFMAG, SELFMAG);
	return o;
}

static const Elf64_Shdr *object_section(const object *o, const char *name)
{
	const Elf64_Ehdr *header = (const Elf64_Ehdr *)o->bytes;
	const Elf64_Shdr *sections = (const Elf64_Shdr *)(o->bytes + header->e_shoff);
	const char *names = o->bytes + sections[header->e_shstrndx].sh_offset;
	for (unsigned i = 0; i < header->e_shnum; i++)
		if (strcmp(names + sections[i].sh_name, name) == 0)
			return &sections[i];
	return NULL;
}

/* True if the object has a symbol whose name contains word. */
static bool object_has_symbol(const object *o, const char *word)
{
	const Elf64_Shdr *names = object_section(o, ".strtab");
	assert_non_null(names);
	return memmem(o->bytes + names->sh_offset, names->sh_size, word, strlen(word));
}

/* True if both objects have a section of this name, with the same bytes. */
static bool same_section(const object *a, const object *b, const char *name)
{
	const Elf64_Shdr *x = object_section(a, name), *y = object_section(b, name);
	assert_non_null(x);
	assert_non_null(y);
	return x->sh_size == y->sh_size && memcmp(a->bytes + x->sh_offset, b->bytes + y->sh_offset, x->sh_size) == 0;
}

static void off_is_the_same_code_as_none(void **state)
{
	(void)state;
	object on = object_load(paths[0]), off = object_load(paths[1]), none = object_load(paths[2]);
	assert_true(object_section(&none, ".text")->sh_size > 0);
	assert_true(same_section(&off, &none, ".text"));
	assert_false(object_has_symbol(&off, "stilb_prof_"));
	assert_null(object_section(&off, "stilb_prof_section"));
	/* For the object with zones both checks give the opposite: so they can fail. */
	assert_false(same_section(&on, &none, ".text"));
	assert_true(object_has_symbol(&on, "stilb_prof_"));
	assert_non_null(object_section(&on, "stilb_prof_section"));
	free(on.bytes);
	free(off.bytes);
	free(none.bytes);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(off_is_the_same_code_as_none),
	};
	if (argc != 4) {
		fprintf(stderr, "usage: test_prof_off on.o off.o none.o\n");
		return 1;
	}
	paths = argv + 1;
	return cmocka_run_group_tests(tests, NULL, NULL);
}
