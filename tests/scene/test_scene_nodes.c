/* The hierarchy of a scene in the import process, listed from Assimp's: order, transforms, holes, and no memory. */
#include "scene/importer/importer.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>

/* The allocation that fails, counted from 1; 0: none. */
static uint32_t fails, allocations;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size)
{
	return ++allocations == fails ? NULL : __real_malloc(size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	return ++allocations == fails ? NULL : __real_realloc(memory, size);
}

static struct aiNode moved(float x)
{
	return (struct aiNode){.mTransformation = {.a1 = 1, .b2 = 1, .c3 = 1, .d4 = 1, .a4 = x}};
}

static stilb_result list(importer *import, struct aiNode *root)
{
	static struct aiScene scene;
	scene.mRootNode = root;
	*import = (importer){.from = &scene};
	allocations = 0;
	return importer_list_nodes(import);
}

/* A root at 1 with a node at 10, which has one at 100, a hole, a node at NaN, and a node at 20. */
static void nodes_follow_their_parents(void **state)
{
	(void)state;
	importer import;
	struct aiNode root = moved(1), first = moved(10), below = moved(100), nowhere = moved(NAN), last = moved(20);
	root.mChildren = (struct aiNode *[]){&first, NULL, &nowhere, &last};
	root.mNumChildren = 4;
	first.mChildren = (struct aiNode *[]){&below};
	first.mNumChildren = 1;
	nowhere.mChildren = (struct aiNode *[]){&below};
	nowhere.mNumChildren = 1;
	assert_int_equal(list(&import, &root), STILB_OK);
	assert_int_equal(import.node_count, 4);
	assert_int_equal(import.bad_nodes, 1);
	static const float x[] = {1, 11, 21, 111};
	for (uint32_t i = 0; i < 4; i++)
		assert_true(importer_point(&import.nodes[i], stilb_vec3_make(0, 0, 0))[0] == x[i]);
	free(import.nodes);
}

#define MANY 3000 /* more than the list has room for at first */

static void without_memory_there_is_no_hierarchy(void **state)
{
	(void)state;
	importer import;
	struct aiNode root = moved(1), leaf = moved(2), *leaves[MANY];
	for (int i = 0; i < MANY; i++)
		leaves[i] = &leaf;
	root.mChildren = leaves;
	root.mNumChildren = MANY;
	assert_int_equal(list(&import, &root), STILB_OK);
	assert_int_equal(import.node_count, MANY + 1);
	free(import.nodes);
	uint32_t all = allocations;
	assert_in_range(all, 2, 10);
	for (uint32_t i = 1; i <= all; i++) {
		fails = i;
		stilb_result result = list(&import, &root);
		fails = 0;
		assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_string_equal(stilb_error_message(), "no memory for its hierarchy");
		free(import.nodes);
	}
	assert_int_equal(list(&import, NULL), STILB_ERROR_FILE);
	free(import.nodes);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nodes_follow_their_parents),
		cmocka_unit_test(without_memory_there_is_no_hierarchy),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
