/* Waits between queues: against lists written by hand, and of random plans against all pairs of steps: what must be
 * ordered is, and without any of the waits it is not. */
#include "gpu_random.h"
#include "gpu_script.h"

#include "support/test.h"

#include <stdlib.h>
#include <string.h>

typedef struct example {
	const char *rows, *waits;
} example;

static const example examples[] = {
	/* one queue */
	{"image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a", ""},
	/* there and back */
	{"image a rgba8_u\nimage b rgba8_u\nimage c rgba8_u output\ndraws p clear:a\n"
     "dispatch q store:b sample:a queue:compute\nscreen r fresh:c sample:b",
     "q waits for p\nr waits for q\n"},
	/* beside one another; the frame ends after both */
	{"image a rgba8_u output\nimage b rgba8_u output\ndraws p clear:a\ndispatch q store:b queue:compute",
     "end waits for q\n"},
	/* two readers of one layout do not wait for one another, but for the change of layout before the first */
	{"image a rgba8_u\nimage b rgba8_u output\nimage c rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a\n"
     "dispatch r store:c sample:a queue:compute",
     "r waits for q\nend waits for r\n"},
	/* readers of a buffer wait for its writer alone */
	{"buffer a 64\nimage b rgba8_u output\nimage c rgba8_u output\ndispatch p store:a\nscreen q fresh:b load:a\n"
     "dispatch r store:c load:a queue:compute",
     "r waits for p\nend waits for r\n"},
	/* whoever writes waits for readers */
	{"image a rgba8_u output\nimage b rgba8_u output\ndraws p clear:a\ndispatch q store:b sample:a queue:compute\n"
     "draws r clear:a",
     "q waits for p\nr waits for q\n"},
	/* a wait that another brings along is not needed */
	{"buffer a 64\nbuffer b 64\nbuffer c 64\nbuffer d 64 output\ndispatch p store:a\n"
     "copy q from:a to:b queue:copy\ndispatch r store:c load:b load:a queue:compute\ncopy s from:c to:d",
     "q waits for p\nr waits for q\ns waits for r\n"},
	/* mips apart */
	{"image a rgba8_u 8x8 mips 2 output\ndraws p clear:a[0]\ndispatch q store:a[1] queue:compute\nscreen r over:a[0]",
     "end waits for q\n"},
	/* memory that one queue has used and another takes over */
	{"buffer a 64\nbuffer b 64 output\nbuffer c 64\nbuffer d 64 output\ndispatch p store:a\ncopy q from:a to:b\n"
     "dispatch r store:c queue:compute\ncopy s from:c to:d queue:compute",
     "r waits for q\nend waits for s\n"},
};

static void test_examples(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
		stilb_gpu_plan *plan = stilb_gpu_plan_create();
		for (uint32_t frame = 0; frame < 3; frame++) {
			script_make(plan, examples[i].rows);
			char *waits = script_waits(plan);
			if (strcmp(waits, examples[i].waits) != 0)
				fail_msg("%s\nhas\n%sand not\n%s", examples[i].rows, waits, examples[i].waits);
			free(waits);
		}
		stilb_gpu_plan_destroy(plan);
	}
}

static void test_queues(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, examples[1].rows);
	assert_int_equal(stilb_gpu_plan_place(plan, 1)->queues, 3);
	assert_int_equal(stilb_gpu_plan_place(plan, 2)->queues, 3);
	assert_int_equal(stilb_gpu_plan_place(plan, 3)->queues, 1);
	script_make(plan, examples[0].rows);
	assert_int_equal(stilb_gpu_plan_place(plan, 1)->queues, 1);
	/* The same table but for the queue of a pass, which counts in the plan's hash and text. */
	static const char *const rows[2] = {
		"image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\ndispatch q store:b sample:a",
		"image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\ndispatch q store:b sample:a queue:compute"};
	uint64_t hashes[2];
	for (uint32_t frame = 0; frame < 12; frame++) {
		bool queued = frame / 3 % 2 == 1;
		script_make(plan, rows[queued]);
		char *waits = script_waits(plan), *text;
		assert_string_equal(waits, queued ? "q waits for p\nend waits for q\n" : "");
		assert_int_equal(stilb_gpu_plan_text(plan, &text), STILB_OK);
		assert_int_equal((bool)strstr(text, "on the queue compute\n    waits for pass 1 'p'\n"), queued);
		assert_int_equal((bool)strstr(text, "after the frame\n    waits for pass 2 'q'\n"), queued);
		free(waits);
		free(text);
		hashes[queued] = stilb_gpu_plan_hash(plan);
	}
	assert_true(hashes[0] != hashes[1]);
	static const struct {
		stilb_gpu_pass_kind kind;
		uint32_t queue;
		const char *says;
	} wrong[] = {{STILB_GPU_PASS_FULLSCREEN, STILB_GPU_QUEUE_COMPUTE, "is of kind fullscreen and on the queue compute"},
	             {STILB_GPU_PASS_FULLSCREEN, STILB_GPU_QUEUE_COPY, "is of kind fullscreen and on the queue copy"},
	             {STILB_GPU_PASS_FULLSCREEN, STILB_GPU_QUEUES, "has the queue 3"}};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		stilb_gpu_plan_begin(plan, 8, 8);
		script_rows(plan, "image a rgba8_u output");
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "p",
		                                            .kind = (uint8_t)wrong[i].kind,
		                                            .program = 1,
		                                            .queue = wrong[i].queue,
		                                            .color = {{.image = 1, .load = STILB_GPU_LOAD_CLEAR}},
		                                            .color_count = 1});
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), wrong[i].says));
	}
	stilb_gpu_plan_destroy(plan);
}

/* ---- random plans ------------------------------------------------------------------------------------------------ */

#define STEPS RANDOM_PASSES

/* Pairs of steps: [a][b], a before b. */
typedef struct pairs {
	bool is[STEPS + 1][STEPS + 1];
} pairs;

/* A barrier of a step changes the layout of a part. */
static bool changes(const random_table *table, const stilb_gpu_plan *plan, const stilb_gpu_step *step,
                    const random_access *a)
{
	const stilb_gpu_barrier *barriers;
	stilb_gpu_plan_barriers(plan, &barriers);
	bool two = stilb_gpu_plan_place(plan, (uint16_t)a->resource)->two;
	for (uint32_t i = step->first_barrier; i < step->first_barrier + step->barrier_count; i++) {
		const stilb_gpu_barrier *b = &barriers[i];
		bool part = b->resource == a->resource && a->mip - b->mip < b->mips && a->layer - b->layer < b->layers &&
		            b->previous == (two && a->previous);
		bool other =
			!table->buffer[a->resource] &&
			(b->discard || stilb_gpu_access_layout((stilb_gpu_access)b->from, random_kind(table, a->resource)) !=
		                       stilb_gpu_access_layout((stilb_gpu_access)b->to, random_kind(table, a->resource)));
		if (part && (other || b->zero))
			return true;
	}
	return false;
}

static bool shares_memory(const stilb_gpu_plan *plan, uint32_t a, uint32_t b)
{
	const stilb_gpu_placed *x = stilb_gpu_plan_place(plan, (uint16_t)a), *y = stilb_gpu_plan_place(plan, (uint16_t)b);
	return a != b && x->shared && y->shared && x->heap == y->heap && x->offset < y->offset + y->bytes &&
	       y->offset < x->offset + x->bytes;
}

/* Pairs that must be ordered, found from rows, barriers and places. */
static void find_conflicts(const random_table *table, const stilb_gpu_plan *plan, pairs *out)
{
	static random_access accesses[STEPS][RANDOM_ACCESSES];
	uint32_t counts[STEPS];
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps);
	memset(out, 0, sizeof *out);
	for (uint32_t s = 0; s < count; s++)
		counts[s] = random_accesses(table, &table->passes[steps[s].pass], accesses[s]);
	for (uint32_t b = 0; b < count; b++)
		for (uint32_t a = 0; a < b; a++)
			for (uint32_t i = 0; i < counts[a]; i++)
				for (uint32_t k = 0; k < counts[b] && !out->is[a][b]; k++) {
					const random_access *x = &accesses[a][i], *y = &accesses[b][k];
					bool two = stilb_gpu_plan_place(plan, (uint16_t)x->resource)->two;
					bool same = x->resource == y->resource && x->mip == y->mip && x->layer == y->layer &&
					            (!two || x->previous == y->previous);
					bool writes = stilb_gpu_access_writes(x->access) || stilb_gpu_access_writes(y->access) ||
					              changes(table, plan, &steps[a], x) || changes(table, plan, &steps[b], y);
					out->is[a][b] = (same && writes) || shares_memory(plan, x->resource, y->resource);
				}
	for (uint32_t a = 0; a < count; a++)
		out->is[a][count] = true;
}

/* Pairs that are ordered: by their queue, by waits but one, and by both in turn. */
static void find_order(const random_table *table, const stilb_gpu_plan *plan, uint32_t without, pairs *out)
{
	const stilb_gpu_step *steps;
	const stilb_gpu_queue_wait *waits;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps), wait_count = stilb_gpu_plan_waits(plan, &waits);
	memset(out, 0, sizeof *out);
	for (uint32_t b = 0; b <= count; b++)
		for (uint32_t a = 0; a < b; a++) {
			uint32_t queue = b == count ? STILB_GPU_QUEUE_MAIN : table->passes[steps[b].pass].queue;
			out->is[a][b] = table->passes[steps[a].pass].queue == queue;
		}
	for (uint32_t w = 0; w < wait_count; w++)
		if (w != without)
			out->is[waits[w].before][waits[w].step] = true;
	for (uint32_t m = 0; m <= count; m++)
		for (uint32_t a = 0; a < m; a++)
			for (uint32_t b = m + 1; b <= count; b++)
				out->is[a][b] = out->is[a][b] || (out->is[a][m] && out->is[m][b]);
}

static bool contains(const pairs *order, const pairs *conflicts)
{
	for (uint32_t a = 0; a <= STEPS; a++)
		for (uint32_t b = 0; b <= STEPS; b++)
			if (conflicts->is[a][b] && !order->is[a][b])
				return false;
	return true;
}

static void test_random(void **state)
{
	(void)state;
	static random_table table;
	static pairs conflicts, order;
	uint32_t plans = TEST_ASAN || TEST_EMULATED ? 1000 : 20000, sum = 0;
	for (uint64_t seed = 0; seed < plans; seed++) {
		stilb_gpu_plan *plan = stilb_gpu_plan_create();
		random_make(&table, seed, seed);
		for (uint32_t p = 0; p < table.pass_count; p++) {
			uint32_t dice = (uint32_t)stilb_random_u64(5, seed * STEPS + p) % 4;
			stilb_gpu_pass *pass = &table.passes[p];
			if (pass->kind == STILB_GPU_PASS_COPY)
				pass->queue = dice < STILB_GPU_QUEUES ? dice : STILB_GPU_QUEUE_COPY;
			else if (pass->kind == STILB_GPU_PASS_DISPATCH)
				pass->queue = dice < 2 ? STILB_GPU_QUEUE_MAIN : STILB_GPU_QUEUE_COMPUTE;
		}
		for (uint32_t frame = 0; frame < 3; frame++) {
			stilb_gpu_plan_begin(plan, 100, 50);
			random_add(&table, plan);
			if (stilb_gpu_plan_make(plan, NULL) != STILB_OK)
				fail_msg("%s", stilb_error_message());
			const stilb_gpu_queue_wait *waits;
			uint32_t count = stilb_gpu_plan_waits(plan, &waits);
			sum += count;
			find_conflicts(&table, plan, &conflicts);
			find_order(&table, plan, UINT32_MAX, &order);
			if (!contains(&order, &conflicts))
				fail_msg("seed %llu: a wait is missing\n%s", (unsigned long long)seed, script_waits(plan));
			for (uint32_t w = 0; w < count; w++) {
				assert_true(w == 0 || waits[w].step >= waits[w - 1].step);
				find_order(&table, plan, w, &order);
				if (contains(&order, &conflicts))
					fail_msg("seed %llu: wait %u is not needed\n%s", (unsigned long long)seed, w, script_waits(plan));
			}
		}
		stilb_gpu_plan_destroy(plan);
	}
	print_message("%u waits of %u plans\n", sum, 3 * plans);
	assert_true(sum > plans);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_examples), cmocka_unit_test(test_queues),
	                                   test_one_thread(test_random)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
