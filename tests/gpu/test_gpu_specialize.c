/* Shaders without what their specialization constants never reach: what is left is whole, and broken modules do no
 * harm. That it computes the same is tested by test_gpu_vulkan, under the validation layer. */
#include "gpu/spirv/gpu_specialize.h"
#include "support/test.h"

#include <stdlib.h>
#include <string.h>

static const uint32_t paths_frag[] =
#include "paths.frag.inc"
	;

#define WORDS (sizeof paths_frag / sizeof *paths_frag)

enum { PHI = 245, LOOP_MERGE, SELECTION_MERGE, LABEL, BRANCH, BRANCH_CONDITIONAL, SWITCH };

static stilb_gpu_program_desc paths_desc(uint32_t kind, uint32_t bits)
{
	return (stilb_gpu_program_desc){.constant_count = 3, .constants = {{1, 1}, {3, kind}, {7, bits}}};
}

/* Whether the block with this label goes to another. */
static bool goes(const uint32_t *words, size_t count, uint32_t from, uint32_t to)
{
	bool here = false;
	for (size_t at = 5; at < count; at += words[at] >> 16) {
		uint32_t op = words[at] & 0xffff, length = words[at] >> 16;
		if (op == LABEL)
			here = words[at + 1] == from;
		if (here && op == BRANCH && words[at + 1] == to)
			return true;
		if (here && op == BRANCH_CONDITIONAL && (words[at + 2] == to || words[at + 3] == to))
			return true;
		for (uint32_t i = 2; here && op == SWITCH && i < length; i += 2)
			if (words[at + i] == to)
				return true;
	}
	return false;
}

static uint32_t labels_of(const uint32_t *words, size_t count, uint32_t label)
{
	uint32_t found = 0;
	for (size_t at = 5; at < count; at += words[at] >> 16)
		found += (words[at] & 0xffff) == LABEL && words[at + 1] == label;
	return found;
}

/* Merge instructions name blocks that exist and stand right before branches; phis have a value for each block that goes
 * to theirs and for no other; no block is there twice. */
static void assert_whole(const uint32_t *words, size_t count)
{
	uint32_t block = 0;
	for (size_t at = 5, end; at < count; at = end) {
		uint32_t op = words[at] & 0xffff, length = words[at] >> 16;
		end = at + length;
		assert_true(length > 0 && end <= count);
		if (op == LABEL) {
			block = words[at + 1];
			assert_int_equal(labels_of(words, count, block), 1);
		}
		if (op == LOOP_MERGE || op == SELECTION_MERGE) {
			uint32_t next = words[end] & 0xffff;
			assert_true(next == BRANCH_CONDITIONAL || (op == SELECTION_MERGE ? next == SWITCH : next == BRANCH));
			for (uint32_t i = 1; i <= (op == LOOP_MERGE ? 2u : 1u); i++)
				assert_int_equal(labels_of(words, count, words[at + i]), 1);
		}
		if (op != PHI)
			continue;
		uint32_t come = 0;
		for (size_t l = 5; l < count; l += words[l] >> 16)
			come += (words[l] & 0xffff) == LABEL && goes(words, count, words[l + 1], block);
		assert_int_equal(come, (length - 3) / 2);
		for (uint32_t i = 3; i < length; i += 2)
			assert_true(goes(words, count, words[at + i + 1], block));
	}
}

static void what_is_left_is_whole(void **state)
{
	(void)state;
	for (uint32_t kind = 0; kind < 5; kind++)
		for (uint32_t bits = 0; bits < 512; bits += 5) {
			stilb_gpu_program_desc desc = paths_desc(kind, bits);
			size_t count = 0;
			uint32_t *words = gpu_specialize(paths_frag, WORDS, &desc, &count);
			assert_non_null(words);
			assert_in_range(count, WORDS / 4, WORDS * 3 / 4);
			assert_memory_equal(words, paths_frag, 5 * sizeof *words);
			assert_whole(words, count);
			/* All of it is reached. */
			size_t again = 0;
			assert_null(gpu_specialize(words, count, &desc, &again));
			free(words);
		}
}

/* Without constants of the program's own those of the shader count: it is not asked for paths. */
static void constants_of_the_shader(void **state)
{
	(void)state;
	stilb_gpu_program_desc none = {0};
	size_t few = 0, more = 0;
	uint32_t *words = gpu_specialize(paths_frag, WORDS, &none, &few);
	assert_non_null(words);
	assert_whole(words, few);
	free(words);
	stilb_gpu_program_desc desc = paths_desc(0, 0);
	free(gpu_specialize(paths_frag, WORDS, &desc, &more));
	assert_true(few < more && few < WORDS / 2);
}

/* Where both sides of a branch end, the block behind them is one that is never reached. */
static void behind_what_ends(void **state)
{
	(void)state;
	stilb_gpu_program_desc desc = {.constant_count = 2, .constants = {{1, 0}, {2, 1}}};
	size_t count = 0;
	uint32_t *words = gpu_specialize(paths_frag, WORDS, &desc, &count);
	assert_non_null(words);
	assert_whole(words, count);
	free(words);
}

/* Instructions: an opcode, how many words it has, and its operands. */
typedef uint32_t instruction[7];

static uint32_t *specialize(const instruction *code, size_t instructions, uint32_t bound, size_t *count)
{
	uint32_t words[128] = {0x07230203, 0x00010600, 0, bound, 0};
	size_t end = 5;
	for (size_t i = 0; i < instructions; i++) {
		words[end] = code[i][1] << 16 | code[i][0];
		for (uint32_t word = 1; word < code[i][1]; word++)
			words[end + word] = code[i][word + 1];
		end += code[i][1];
	}
	stilb_gpu_program_desc desc = {.constant_count = 1, .constants = {{1, 1}}};
	return gpu_specialize(words, end, &desc, count);
}

/* if (constant) { if (other) goto end; } else {} end: with `leaves` the inner branch leaves both, which structured
 * control flow allows to nothing but a switch and a loop: the outer one has to stay. */
static uint32_t *nested(bool leaves, size_t *count)
{
	enum { BOOL = 1, CONSTANT, OTHER, FUNCTION, ENTRY, ONE_SIDE, OTHER_SIDE, INNER, END, GONE, BOUND };
	const instruction code[] = {
		{71, 4, CONSTANT, 1, 1},    /* OpDecorate SpecId 1 */
		{71, 3, GONE, 42},          /* OpDecorate NoContraction */
		{20, 2, BOOL},              /* OpTypeBool */
		{49, 3, BOOL, CONSTANT},    /* OpSpecConstantFalse */
		{54, 5, BOOL, FUNCTION, 0}, /* OpFunction, without its type */
		{LABEL, 2, ENTRY},
		{1, 3, BOOL, OTHER}, /* OpUndef */
		{SELECTION_MERGE, 3, END},
		{BRANCH_CONDITIONAL, 4, CONSTANT, ONE_SIDE, OTHER_SIDE},
		{LABEL, 2, ONE_SIDE},
		{SELECTION_MERGE, 3, INNER},
		{BRANCH_CONDITIONAL, 4, OTHER, leaves ? END : INNER, INNER},
		{LABEL, 2, INNER},
		{BRANCH, 2, END},
		{LABEL, 2, OTHER_SIDE},
		{1, 3, BOOL, GONE},
		{BRANCH, 2, END},
		{LABEL, 2, END},
		{253, 1}, /* OpReturn */
		{56, 1},  /* OpFunctionEnd */
	};
	uint32_t *left = specialize(code, sizeof code / sizeof *code, BOUND, count);
	for (size_t at = 5; left && at < *count; at += left[at] >> 16) {
		assert_false((left[at] & 0xffff) == LABEL && left[at + 1] == OTHER_SIDE);
		assert_false((left[at] & 0xffff) == 71 && left[at + 1] == GONE);
	}
	return left;
}

/* The literals of a switch on an integer of 64 bits have two words each: this one's upper half is the number of a
 * block. Such a module stays as it is; with 32 bits the side that is not taken goes. */
static void wide_switches(void **state)
{
	(void)state;
	enum { BOOL = 1, TRUE, INT, VALUE, FUNCTION, ENTRY, SIDE, CHOICE, CASE, END, BOUND };
	for (uint32_t wide = 0; wide < 2; wide++) {
		const instruction code[] = {
			{20, 2, BOOL},
			{41, 3, BOOL, TRUE},
			{21, 4, INT, wide ? 64 : 32, 0},
			{54, 5, INT, FUNCTION, 0},
			{LABEL, 2, ENTRY},
			{1, 3, INT, VALUE},
			{SELECTION_MERGE, 3, CHOICE},
			{BRANCH_CONDITIONAL, 4, TRUE, CHOICE, SIDE},
			{LABEL, 2, SIDE},
			{BRANCH, 2, CHOICE},
			{LABEL, 2, CHOICE},
			{SELECTION_MERGE, 3, END},
			{SWITCH, wide ? 6 : 5, VALUE, END, 7, wide ? END : CASE, CASE},
			{LABEL, 2, CASE},
			{BRANCH, 2, END},
			{LABEL, 2, END},
			{253, 1},
			{56, 1},
		};
		size_t count = 0;
		uint32_t *words = specialize(code, sizeof code / sizeof *code, BOUND, &count);
		assert_int_equal(!words, wide);
		assert_int_equal(labels_of(words, count, CASE), !wide);
		assert_int_equal(labels_of(words, count, SIDE), 0);
		free(words);
	}
}

/* Merge instructions that name blocks before their own: nothing is left out, and the search for constructs ends. And
 * phis without a value from where their loop comes back. */
static void constructs_inside_out(void **state)
{
	(void)state;
	enum { BOOL = 1, CONSTANT, FUNCTION, ENTRY, INNER, SIDE, END, LOOP, BACK, PHIS, BOUND = PHIS + 24 };
	instruction code[40] = {
		{71, 4, CONSTANT, 1, 1},
		{20, 2, BOOL},
		{49, 3, BOOL, CONSTANT},
		{54, 5, BOOL, FUNCTION, 0},
		{LABEL, 2, ENTRY},
		{SELECTION_MERGE, 3, END},
		{BRANCH_CONDITIONAL, 4, CONSTANT, INNER, SIDE},
		{LABEL, 2, INNER},
		{SELECTION_MERGE, 3, ENTRY},
		{BRANCH_CONDITIONAL, 4, CONSTANT, END, SIDE},
		{LABEL, 2, SIDE},
		{BRANCH, 2, END},
		{LABEL, 2, END},
		{253, 1},
		{56, 1},
	};
	size_t count = 0;
	assert_null(specialize(code, 15, BOUND, &count));
	const instruction loop[] = {
		{71, 4, CONSTANT, 1, 1}, {20, 2, BOOL},     {49, 3, BOOL, CONSTANT}, {54, 5, BOOL, FUNCTION, 0},
		{LABEL, 2, ENTRY},       {BRANCH, 2, LOOP}, {LABEL, 2, LOOP},
	};
	const instruction rest[] = {
		{LOOP_MERGE, 4, END, BACK},
		{BRANCH_CONDITIONAL, 4, CONSTANT, END, BACK},
		{LABEL, 2, BACK},
		{BRANCH, 2, LOOP},
		{LABEL, 2, END},
		{253, 1},
		{56, 1},
	};
	memcpy(code, loop, sizeof loop);
	for (uint32_t i = 0; i < 24; i++)
		memcpy(code[7 + i], (instruction){PHI, 3, BOOL, PHIS + i}, sizeof *code);
	memcpy(code[31], rest, sizeof rest);
	uint32_t *words = specialize(code, 38, BOUND, &count);
	assert_non_null(words); /* the sanitizers see whether there was room */
	free(words);
}

static void selections_that_are_left_from_within(void **state)
{
	(void)state;
	size_t count = 0;
	uint32_t *words = nested(false, &count);
	assert_non_null(words);
	assert_whole(words, count);
	free(words);
	assert_null(nested(true, &count));
}

/* Nothing is left out of what has no function, is cut off, or is no SPIR-V. Where a word is wrong, whatever is read
 * lies in the module: the sanitizers look. */
static void broken_modules(void **state)
{
	(void)state;
	stilb_gpu_program_desc desc = paths_desc(1, 255);
	size_t count = 0;
	uint32_t *copy = malloc(sizeof paths_frag);
	for (size_t cut = 0; cut < WORDS; cut++) {
		uint32_t *part = malloc((cut + 1) * sizeof *part);
		memcpy(part, paths_frag, cut * sizeof *part);
		uint32_t *words = gpu_specialize(part, cut, &desc, &count);
		if (cut < WORDS - 1) /* without OpFunctionEnd all blocks are there */
			assert_null(words);
		free(words);
		free(part);
	}
	uint32_t seed = 1;
	for (uint32_t i = 0; i < 20000; i++) {
		memcpy(copy, paths_frag, sizeof paths_frag);
		for (uint32_t change = 0; change <= i % 3; change++) {
			seed = seed * 1664525u + 1013904223u;
			uint32_t at = (uint32_t)((uint64_t)seed * WORDS >> 32);
			seed = seed * 1664525u + 1013904223u;
			copy[at] = i & 4 ? seed : copy[at] ^ 1u << (seed >> 27);
		}
		free(gpu_specialize(copy, WORDS, &desc, &count));
	}
	free(copy);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_left_is_whole), cmocka_unit_test(constants_of_the_shader),
		cmocka_unit_test(behind_what_ends),      cmocka_unit_test(selections_that_are_left_from_within),
		cmocka_unit_test(constructs_inside_out), cmocka_unit_test(wide_switches),
		cmocka_unit_test(broken_modules),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
