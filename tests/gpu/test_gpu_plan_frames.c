/* A plan over several frames: what is kept, what stays, what a change of rows or sizes does; passes that are left out;
 * the plan as a number, as text, as a drawing; and no memory. */
#include "gpu_random.h"
#include "gpu_script.h"

#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- memory that can be refused (linked with --wrap=realloc) ----------------------------------------------------- */

static uint32_t reallocs, refused; /* refused: the number of the one that fails; 0: none */

void *__real_realloc(void *memory, size_t bytes);
void *__wrap_realloc(void *memory, size_t bytes);
void *__wrap_realloc(void *memory, size_t bytes)
{
	reallocs++;
	return reallocs == refused ? NULL : __real_realloc(memory, bytes);
}

static void expect_barriers(const stilb_gpu_plan *plan, const char *wanted)
{
	char *found = script_barriers(plan);
	if (strcmp(found, wanted) != 0)
		fail_msg("there is\n%sand not\n%s", found, wanted);
	free(found);
}

static const stilb_gpu_placed *place(const stilb_gpu_plan *plan, const char *name)
{
	return stilb_gpu_plan_place(plan, stilb_gpu_plan_find(plan, name));
}

static bool kept(const stilb_gpu_plan *plan, const char *name)
{
	return stilb_gpu_plan_kept(plan, stilb_gpu_plan_find(plan, name));
}

/* ---- last frame's ------------------------------------------------------------------------------------------------ */

static const char temporal[] = "image new rgba16_f\n"
							   "image mixed rgba16_f keep\n"
							   "image picture rgba8_u output\n"
							   "draws scene clear:new\n"
							   "screen mix fresh:mixed sample:mixed' sample:new\n"
							   "screen tone fresh:picture sample:mixed\n";

static void test_two(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, temporal);
	assert_true(place(plan, "mixed")->two);
	assert_false(kept(plan, "mixed"));
	uint64_t stay = place(plan, "mixed")->stay;
	assert_true(stay != 0);
	expect_barriers(plan, "scene: new none > color discard\n"
	                      "mix: mixed none > color discard\n"
	                      "mix: mixed none > sampled_fragment discard zero previous\n"
	                      "mix: new color > sampled_fragment\n"
	                      "tone: picture none > color discard\n"
	                      "tone: mixed color > sampled_fragment\n"
	                      "end: picture color > output\n");
	for (uint32_t frame = 1; frame < 5; frame++) {
		script_make(plan, temporal);
		assert_true(kept(plan, "mixed"));
		assert_int_equal(place(plan, "mixed")->stay, stay);
		/* What the last frame wrote was sampled by it already, and is sampled again; the other of the two was, too. */
		expect_barriers(plan, "scene: new sampled_fragment > color discard memory\n"
		                      "mix: mixed sampled_fragment > color discard\n"
		                      "mix: new color > sampled_fragment\n"
		                      "tone: picture output > color discard\n"
		                      "tone: mixed color > sampled_fragment\n"
		                      "end: picture color > output\n");
	}
	stilb_gpu_plan_destroy(plan);
}

static void test_resize(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	uint64_t stay[4];
	uint32_t sizes[4] = {64, 64, 65, 64};
	bool wanted[4] = {false, true, false, false};
	for (uint32_t frame = 0; frame < 4; frame++) {
		stilb_gpu_plan_begin(plan, sizes[frame], 64);
		script_rows(plan, temporal);
		assert_int_equal(kept(plan, "mixed"), wanted[frame]);
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
		assert_int_equal(kept(plan, "mixed"), wanted[frame]);
		assert_int_equal(place(plan, "mixed")->extent.width, sizes[frame]);
		stay[frame] = place(plan, "mixed")->stay;
	}
	assert_int_equal(stay[0], stay[1]);
	assert_true(stay[1] != stay[2] && stay[2] != stay[3] && stay[1] != stay[3]);
	stilb_gpu_plan_destroy(plan);
}

/* Each change of what is kept, and whether there is something afterwards. */
static void test_kept(void **state)
{
	(void)state;
	static const struct {
		const char *rows;
		bool kept;
	} frames[] = {
		{"image a rgba8_u keep\ndraws p clear:a", false},
		{"image a rgba8_u keep\ndraws p clear:a", true},
		{"image b r8_u output\nimage a rgba8_u keep\ndraws p clear:a\ndraws q clear:b", true}, /* another number */
		{"image a rgba8_u keep\nimage b rgba8_u output\nscreen p fresh:b sample:a'", true},
		{"image a rgba8_u keep\ndraws p clear:a", false}, /* was only read */
		{"image a rgba16_f keep\ndraws p clear:a", false},
		{"image b rgba8_u output\ndraws p clear:b", false},
		{"image a rgba16_f keep\ndraws p clear:a", false}, /* was not there */
		{"image a rgba16_f output\ndraws p clear:a", false},
		{"image a rgba16_f keep\ndraws p clear:a", false}, /* was not kept */
		{"image a rgba16_f keep\ndraws p clear:a", true},
		{"buffer a 64 keep\ndispatch p store:a", false},
		{"buffer a 64 keep\ndispatch p store:a", true},
		{"buffer a 65 keep\ndispatch p store:a", false},
	};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
		script_make(plan, frames[i].rows);
		uint16_t number = stilb_gpu_plan_find(plan, "a");
		if ((number != 0 && stilb_gpu_plan_kept(plan, number)) != frames[i].kept)
			fail_msg("frame %zu", i);
	}
	stilb_gpu_plan_destroy(plan);
}

/* A frame that did not run, and one that was wrong, leave no trace. */
static void test_dropped(void **state)
{
	(void)state;
	static const char written[] = "image a rgba8_u output\ndraws p clear:a";
	static const char copied[] =
		"image a rgba8_u output\nimage b rgba8_u owned 1\ndraws p clear:a\ncopy q from:a to:b\n"
		"screen r fresh:a sample:b";
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, copied);
	stilb_gpu_plan_dropped(plan);
	script_make(plan, written);
	expect_barriers(plan, "p: a none > color discard\nend: a color > output\n");
	stilb_gpu_plan_dropped(plan);
	script_make(plan, written);
	expect_barriers(plan, "p: a none > color discard\nend: a color > output\n");
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, "image a rgba8_u output");
	assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_ERROR_ARGUMENT);
	script_make(plan, written);
	expect_barriers(plan, "p: a output > color discard\nend: a color > output\n");
	stilb_gpu_plan_destroy(plan);
}

/* A layout in between ends what an earlier frame's barrier had made ready. */
static void test_layout_between(void **state)
{
	(void)state;
	static const char both[] = "image a rgba8_u owned 7\nimage b rgba8_u output\nscreen p fresh:b sample:a\n"
							   "dispatch q modify:b sample:a";
	static const char copied[] = "image a rgba8_u owned 7\nimage b rgba8_u output\ncopy p from:a to:b\n"
								 "screen q over:b sample:a";
	static const char compute[] = "image a rgba8_u owned 7\nimage b rgba8_u output\ndispatch p store:b sample:a";
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, both);
	script_make(plan, copied);
	script_make(plan, compute);
	expect_barriers(plan, "p: b output > storage_compute discard\n"
	                      "p: a sampled_fragment > sampled_compute\n"
	                      "end: b storage_compute > output\n");
	stilb_gpu_plan_destroy(plan);
}

static stilb_result count_needs(void *user, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	(*(uint32_t *)user)++;
	*needs = (stilb_gpu_needs){.bytes = extent->width, .align = 1};
	return STILB_OK;
}

/* The same rows for another device, or one whose answers have changed, are asked about again. */
static void test_planner(void **state)
{
	(void)state;
	static const char rows[] = "image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a";
	uint32_t asked[2] = {0, 0};
	static const struct {
		uint32_t device;
		uint64_t version;
		uint32_t wanted[2];
	} frames[] = {{0, 0, {1, 0}}, {0, 0, {1, 0}}, {0, 0, {1, 0}}, {0, 1, {2, 0}}, {1, 1, {2, 1}}, {1, 1, {2, 1}}};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
		stilb_gpu_planner planner = {
			.user = &asked[frames[i].device], .version = frames[i].version, .image_needs = count_needs};
		stilb_gpu_plan_begin(plan, 64, 64);
		script_rows(plan, rows);
		assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_OK);
		assert_int_equal(asked[0], frames[i].wanted[0]);
		assert_int_equal(asked[1], frames[i].wanted[1]);
	}
	stilb_gpu_plan_destroy(plan);
}

static const char *count_mistakes(void *user, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	(void)plan;
	(*(uint32_t *)user)++;
	return pass->program == 13 ? "has the unlucky program" : NULL;
}

/* Two passes, and what they have besides images. */
static stilb_result make_two(stilb_gpu_plan *plan, uint32_t *asked, uint32_t first, uint32_t second, bool sampled)
{
	stilb_gpu_planner planner = {.user = asked, .mistake = count_mistakes};
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, "image a rgba8_u\nimage b rgba8_u output");
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "p",
	                                            .kind = STILB_GPU_PASS_FULLSCREEN,
	                                            .program = first,
	                                            .color = {{.image = 1, .load = STILB_GPU_LOAD_CLEAR}},
	                                            .color_count = 1});
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "q",
	                                            .kind = STILB_GPU_PASS_FULLSCREEN,
	                                            .program = second,
	                                            .color = {{.image = 2, .load = STILB_GPU_LOAD_CLEAR}},
	                                            .color_count = 1,
	                                            .uses = {{.resource = 1, .how = STILB_GPU_USE_SAMPLED}},
	                                            .use_count = sampled});
	return stilb_gpu_plan_make(plan, &planner);
}

/* A pass with another program has the same plan, and is asked about alone; the plan holds the new row. */
static void test_programs(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	uint32_t asked = 0;
	for (uint32_t frame = 0; frame < 3; frame++)
		assert_int_equal(make_two(plan, &asked, 1, 2, true), STILB_OK);
	assert_int_equal(asked, 2);
	char *before = script_barriers(plan);
	assert_int_equal(make_two(plan, &asked, 1, 3, true), STILB_OK);
	assert_int_equal(asked, 3);
	assert_int_equal(stilb_gpu_plan_row(plan, 1)->program, 3);
	expect_barriers(plan, before);
	free(before);
	assert_int_equal(make_two(plan, &asked, 13, 3, true), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "pass 1 'p' has the unlucky program"));
	const stilb_gpu_step *steps;
	assert_int_equal(stilb_gpu_plan_steps(plan, &steps), 0);
	assert_int_equal(make_two(plan, &asked, 1, 3, true), STILB_OK);
	/* Without the sample nobody needs the first pass, whose program is then not asked about. */
	assert_int_equal(make_two(plan, &asked, 13, 3, false), STILB_OK);
	assert_int_equal(stilb_gpu_plan_steps(plan, &steps), 1);
	assert_int_equal(make_two(plan, &asked, 13, 3, true), STILB_ERROR_ARGUMENT);
	stilb_gpu_plan_destroy(plan);
}

/* Of many tables in turn, each has the plan that it had before, and no more memory is needed. */
static void test_turns(void **state)
{
	(void)state;
	static const char *const uses[] = {"sample:a", "sample:b", "sample:c", "sample:a sample:b", "sample:b sample:c"};
	enum { TURNS = 5, FRAMES = 4000 };
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	char *barriers[TURNS] = {0};
	uint32_t before = 0;
	for (uint32_t frame = 0; frame < FRAMES; frame++) {
		char rows[300];
		snprintf(rows, sizeof rows,
		         "image a rgba8_u\nimage b r8_u\nimage c rgba16_f\nimage d rgba8_u output\ndraws p clear:a\n"
		         "draws q clear:b\ndraws r clear:c\nscreen s fresh:d %s\n",
		         uses[frame % TURNS]);
		script_make(plan, rows);
		if (frame == FRAMES / 2)
			before = reallocs;
		if (frame < TURNS || frame >= FRAMES - TURNS) {
			uint32_t taken = reallocs;
			char *text = script_barriers(plan);
			reallocs = taken;
			if (frame >= FRAMES - TURNS && frame % TURNS > 0) /* the first table followed none */
				assert_string_equal(text, barriers[frame % TURNS]);
			free(barriers[frame % TURNS]);
			barriers[frame % TURNS] = text;
		}
	}
	assert_int_equal(reallocs, before);
	for (uint32_t i = 0; i < TURNS; i++)
		free(barriers[i]);
	stilb_gpu_plan_destroy(plan);
}

/* Places are those of lifetimes, also where only the first step of one or only the last has changed. */
static void test_lifetimes(void **state)
{
	(void)state;
	static const char *const passes[3] = {
		"draws p clear:a\nscreen q fresh:o sample:a\ndraws r clear:b\nscreen s over:o sample:b",
		"draws p clear:a\nscreen q fresh:b sample:a\ndraws r clear:o\nscreen s over:o sample:b",
		"draws p clear:a\nscreen q fresh:o sample:a\ndraws r clear:b sample:a\nscreen s over:o sample:b"};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (uint32_t frame = 0; frame < 9; frame++) {
		char rows[300];
		snprintf(rows, sizeof rows, "image a rgba8_u\nimage b rgba8_u\nimage o rgba8_u output\n%s", passes[frame % 3]);
		script_make(plan, rows);
		assert_int_equal(place(plan, "a")->offset == place(plan, "b")->offset, frame % 3 == 0);
	}
	stilb_gpu_plan_destroy(plan);
}

/* What is shown live in some frames and not in others. */
static void test_shown(void **state)
{
	(void)state;
	static const char *const rows[2] = {
		"image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a",
		"image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a\nshow a"};
	static const bool shown_in[] = {false, false, false, true, true, true, false, true};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (size_t i = 0; i < sizeof shown_in / sizeof *shown_in; i++) {
		script_make(plan, rows[shown_in[i]]);
		assert_int_equal(place(plan, "a")->shared, !shown_in[i]);
		assert_int_equal(place(plan, "a")->stay != 0, shown_in[i]);
		assert_int_equal(stilb_gpu_plan_ready(plan, stilb_gpu_plan_find(plan, "a"), 0, 0), shown_in[i]);
	}
	stilb_gpu_plan_destroy(plan);
}

/* Made again and again, a plan is what a new one with the same past would be, and needs no more memory. */
static void test_steady(void **state)
{
	(void)state;
	static random_table table;
	for (uint64_t i = 0; i < 200; i++) {
		random_make(&table, i, i);
		stilb_gpu_plan *plan = stilb_gpu_plan_create();
		char *steady = NULL;
		uint32_t before = 0;
		for (uint32_t frame = 0; frame < 8; frame++) {
			if (frame == 5)
				before = reallocs;
			stilb_gpu_plan_begin(plan, 100, 50);
			random_add(&table, plan);
			assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
			if (frame >= 5)
				assert_int_equal(reallocs, before);
			char *text = script_barriers(plan);
			if (steady)
				assert_string_equal(text, steady);
			if (frame == 4)
				steady = text;
			else
				free(text);
			if (frame >= 5) /* what script_barriers has taken */
				before = reallocs;
		}
		free(steady);
		stilb_gpu_plan_destroy(plan);
	}
}

/* ---- passes that are left out ------------------------------------------------------------------------------------ */

static void expect_steps(const char *rows, const char *wanted)
{
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, rows);
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps);
	char found[200] = "";
	for (uint32_t i = 0; i < count; i++)
		strcat(strcat(found, i > 0 ? " " : ""), stilb_gpu_plan_row(plan, steps[i].pass)->name);
	assert_string_equal(found, wanted);
	stilb_gpu_plan_destroy(plan);
}

static void test_left_out(void **state)
{
	(void)state;
	expect_steps("image a rgba8_u\ndraws p clear:a", "");
	expect_steps("image a rgba8_u output\ndraws p clear:a", "p");
	expect_steps("image a rgba8_u keep\ndraws p clear:a", "p");
	expect_steps("image a rgba8_u\ndraws p clear:a\nshow a", "p");
	expect_steps("image a rgba8_u owned 1\ndraws p clear:a", "p");
	expect_steps("image a rgba8_u\nimage b rgba8_u\ndraws p clear:a\nscreen q fresh:b sample:a", "");
	expect_steps("image a rgba8_u\nimage b rgba8_u output\ndraws p clear:a\nscreen q fresh:b sample:a", "p q");
	expect_steps("image a rgba8_u output\ndraws p clear:a\ndraws q clear:a", "q");
	expect_steps("image a rgba8_u output\ndraws p clear:a\ndraws q over:a", "p q");
	expect_steps("image a rgba8_u output\ndraws p clear:a\nscreen q fresh:a", "q");
	expect_steps("image a rgba8_u 8x8 mips 2 output\ndraws p clear:a[0]\ndraws q clear:a[1]\ndraws r clear:a[0]",
	             "q r");
	expect_steps("buffer a 64 output\ndispatch p store:a\ndispatch q store:a", "p q"); /* it may write a part alone */
	expect_steps("buffer a 64 owned 1\nimage b rgba8_u\ndraws p clear:b load:a", "");
	expect_steps("image a rgba8_u samples 4\nimage b rgba8_u output\ndraws p clear:a>b", "p");
	expect_steps("image a rgba8_u samples 4\nimage b rgba8_u output\ndraws p clear:a>b\ndraws q clear:b", "q");
}

/* ---- as a number ------------------------------------------------------------------------------------------------- */

static uint64_t hash_of(const char *rows)
{
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, rows);
	uint64_t hash = stilb_gpu_plan_hash(plan);
	stilb_gpu_plan_destroy(plan);
	return hash;
}

/* ---- frames that are cut ----------------------------------------------------------------------------------------- */

#define CUT_FRAME                                                                                                      \
	"image light rgba16_f samples 4\n"                                                                                 \
	"image color rgba16_f output\n"                                                                                    \
	"image depth d32_f samples 4\n"                                                                                    \
	"image picture rgba8_u output\n"                                                                                   \
	"screen sky fresh:light\n"                                                                                         \
	"draws scene over:light clear:depth\n"                                                                             \
	"screen resolve fresh:color sample:light\n"                                                                        \
	"screen tone fresh:picture sample:color\n"

static void test_cut(void **state)
{
	(void)state;
	/* the pass runs though nobody reads it; outputs that only passes behind it write are none */
	expect_steps(CUT_FRAME "cut sky\n", "sky");
	expect_steps(CUT_FRAME "cut scene\n", "sky scene");
	expect_steps(CUT_FRAME "cut resolve\n", "sky scene resolve");
	expect_steps(CUT_FRAME "cut tone\n", "sky scene resolve tone");
	expect_steps(CUT_FRAME "cut scene\nscreen show fresh:picture sample:depth\n", "sky scene show");
	/* what the frame runs without the cut runs with it, read or not; what it leaves out stays out */
	expect_steps("image a rgba8_u output\nimage b rgba8_u\nimage c rgba8_u\nimage d rgba8_u\ndraws p clear:b\n"
	             "draws q clear:c\ndraws out clear:d\ndraws r clear:c\nscreen s fresh:a sample:b sample:c\ncut r\n"
	             "screen show fresh:a sample:c\n",
	             "p r show");
	/* but what the last pass, or one that is added, needs */
	expect_steps(
		"image a rgba8_u output\nimage b rgba8_u\nimage c rgba8_u\ndraws p clear:b\nscreen q fresh:c sample:b\n"
		"draws r clear:a\ncut q\n",
		"p q");
	expect_steps("image a rgba8_u output\nimage b rgba8_u\ndraws p clear:b\ndraws q clear:a\ndraws r clear:a\ncut q\n"
	             "screen show fresh:a sample:b\n",
	             "p q show");
	expect_steps("image a rgba8_u output\ndraws p clear:a\ndraws q clear:a\ncut p\n", "p");
	/* parts */
	expect_steps("image a rgba8_u 8x8 mips 2 output\ndraws p clear:a[0]\ndraws q clear:a[1]\ncut p\n", "p");
}

static void expect_error(const char *rows, const char *wanted)
{
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, rows);
	assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), wanted);
	stilb_gpu_plan_destroy(plan);
}

static void test_cut_mistakes(void **state)
{
	(void)state;
	expect_error(CUT_FRAME "cut sky\nscreen show fresh:picture sample:depth\n",
	             "pass 5 'show' samples 'depth', which pass 2 'scene' writes, and the frame is cut before it: cut it "
	             "later");
	expect_error("image a rgba8_u output\nimage b rgba8_u\nimage c rgba8_u output\ndraws p clear:b\ndraws q clear:c\n"
	             "cut p\n",
	             "image 'a' is an output, and no pass writes it: add one, or leave it out");
	expect_error(
		"image a rgba8_u output\nimage b rgba8_u\nscreen p fresh:a sample:b\ndraws q clear:b\ndraws r clear:b\n"
		"cut q\n",
		"pass 1 'p' samples 'b', which only a later row writes, pass 2 'q': change their order, or keep it and "
		"read last frame's (previous)");
}

/* Whatever the frames before were cut after, a frame has the barriers of one that comes first. */
static void test_cut_frames(void **state)
{
	(void)state;
	static const char *const frames[] = {
		CUT_FRAME,
		CUT_FRAME "cut sky\nscreen show fresh:picture sample:light\n",
		CUT_FRAME "cut scene\nscreen show fresh:picture sample:light\n",
		CUT_FRAME "cut scene\nscreen show fresh:picture sample:depth\n",
		CUT_FRAME "screen show fresh:picture sample:depth\n",
		CUT_FRAME "cut tone\n",
	};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (uint32_t i = 0; i < 60; i++) {
		const char *rows = frames[stilb_random_u64(3, i) % 6];
		script_make(plan, rows);
		const stilb_gpu_step *steps, *wanted;
		stilb_gpu_plan *alone = stilb_gpu_plan_create();
		script_make(alone, rows);
		uint32_t count = stilb_gpu_plan_steps(plan, &steps);
		assert_int_equal(count, stilb_gpu_plan_steps(alone, &wanted));
		for (uint32_t s = 0; s < count; s++)
			assert_int_equal(steps[s].pass, wanted[s].pass);
		assert_true(stilb_gpu_plan_hash(plan) == stilb_gpu_plan_hash(alone));
		stilb_gpu_plan_destroy(alone);
	}
	script_make(plan, frames[1]);
	script_make(plan, frames[1]);
	expect_barriers(plan, "sky: light sampled_fragment > color discard memory\n"
	                      "show: picture output > color discard\n"
	                      "show: light color > sampled_fragment\n"
	                      "end: picture color > output\n");
	assert_true(stilb_gpu_plan_ready(plan, stilb_gpu_plan_find(plan, "picture"), 0, 0));
	assert_false(stilb_gpu_plan_ready(plan, stilb_gpu_plan_find(plan, "color"), 0, 0));
	char *text;
	assert_int_equal(stilb_gpu_plan_text(plan, &text), STILB_OK);
	assert_non_null(strstr(text, "  5 show, fullscreen"));
	assert_non_null(strstr(text, "left out\n  2 scene: the frame is cut after pass 1, sky\n"
	                             "  3 resolve: the frame is cut after pass 1, sky\n"
	                             "  4 tone: the frame is cut after pass 1, sky\n"));
	free(text);
	stilb_gpu_plan_destroy(plan);
	/* what a pass behind the cut would have kept, the next frame does not find */
	plan = stilb_gpu_plan_create();
	script_make(plan, temporal);
	script_make(plan, temporal);
	assert_true(kept(plan, "mixed"));
	char cut_frame[400];
	snprintf(cut_frame, sizeof cut_frame, "%scut scene\n", temporal);
	script_make(plan, cut_frame);
	script_make(plan, temporal);
	assert_false(kept(plan, "mixed"));
	stilb_gpu_plan_destroy(plan);
}

static void test_hash(void **state)
{
	(void)state;
	static const char rows[] = "buffer b 64 owned 3\nimage a rgba8_u output\ndraws p clear:a load:b";
	uint64_t hash = hash_of(rows);
	assert_int_equal(hash, hash_of(rows));
	/* what does not count: rows that nobody needs, the order of resources, which owned buffer it is */
	assert_int_equal(hash, hash_of("image x r8_u\nbuffer b 64 owned 3\nimage a rgba8_u output\ndraws q clear:x\n"
	                               "draws p clear:a load:b"));
	assert_int_equal(hash, hash_of("image a rgba8_u output\nbuffer b 64 owned 4\ndraws p clear:a load:b"));
	/* what does */
	static const char *const others[] = {
		"buffer c 64 owned 3\nimage a rgba8_u output\ndraws p clear:a load:c",
		"buffer b 65 owned 3\nimage a rgba8_u output\ndraws p clear:a load:b",
		"buffer b 64 owned 3\nimage a rgba16_f output\ndraws p clear:a load:b",
		"buffer b 64 owned 3\nimage a rgba8_u scale 0.5 output\ndraws p clear:a load:b",
		"buffer b 64 owned 3\nimage a rgba8_u output\ndraws q clear:a load:b",
		"buffer b 64 owned 3\nimage a rgba8_u output\nscreen p clear:a load:b",
		"buffer b 64 owned 3\nimage a rgba8_u output\ndraws p fresh:a load:b",
		"buffer b 64 owned 3\nimage a rgba8_u output\ndraws p clear:a modify:b",
		"buffer b 64 owned 3\nimage a rgba8_u output\ndraws p clear:a load:b\ndraws p over:a",
	};
	for (size_t i = 0; i < sizeof others / sizeof *others; i++)
		if (hash_of(others[i]) == hash)
			fail_msg("%s", others[i]);
}

/* Constants and clear values count, but not where the device writes an address. */
static void test_hash_constants(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	uint64_t hash[4];
	for (uint32_t i = 0; i < 4; i++) {
		stilb_gpu_plan_begin(plan, 64, 64);
		script_rows(plan, "buffer b 64 owned 3\nimage a rgba8_u output");
		stilb_gpu_pass pass = {.name = "p",
		                       .kind = STILB_GPU_PASS_FULLSCREEN,
		                       .program = 1,
		                       .color = {{.image = 2, .load = STILB_GPU_LOAD_CLEAR}},
		                       .color_count = 1,
		                       .uses = {{.resource = 1, .how = STILB_GPU_USE_STORAGE_READ, .slot = 8}},
		                       .use_count = 1,
		                       .constant_bytes = 16};
		pass.constants[i == 1 ? 12 : i == 2 ? 4 : 20] = 1; /* 1: in the address, 2: before it, 3: after the constants */
		pass.color[0].clear[2] = i == 3 ? 0.5f : 0.0f;
		stilb_gpu_plan_pass(plan, &pass);
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
		hash[i] = stilb_gpu_plan_hash(plan);
	}
	assert_int_equal(hash[0], hash[1]);
	assert_true(hash[0] != hash[2] && hash[0] != hash[3] && hash[2] != hash[3]);
	stilb_gpu_plan_destroy(plan);
}

/* ---- as text and as a drawing ------------------------------------------------------------------------------------ */

static const char shown[] = "image color rgba16_f\n"
							"image depth d32_f samples 4\n"
							"image many rgba16_f samples 4\n"
							"image old rgba16_f keep\n"
							"image chain r8_u 8x8 mips 3 layers 2\n"
							"buffer <& 4096 owned 4\n"
							"image picture rgba8_srgb output\n"
							"draws scene clear:many>color clear:depth load:<&\n"
							"screen shrink fresh:chain[1/1] sample:color\n"
							"screen waste fresh:chain[2/0] sample:chain[1/1]\n"
							"screen early fresh:picture\n"
							"dispatch idle sample:color\n"
							"copy mix from:color to:old\n"
							"screen tone fresh:picture sample:chain[1/1] sample:old\n";

static void test_text(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	script_make(plan, shown);
	char *text;
	assert_int_equal(stilb_gpu_plan_text(plan, &text), STILB_OK);
	assert_string_equal(text, "picture 64 x 64, 4 passes, 11 barriers, 224.0 KiB of shared memory for 224.2 KiB\n"
	                          "  1 scene, draws, 64 x 64, 4 samples\n"
	                          "    barrier  many: nothing > color, content dropped\n"
	                          "    barrier  color: nothing > resolve, content dropped\n"
	                          "    barrier  depth: nothing > depth, content dropped\n"
	                          "    draws into many\n"
	                          "    resolves into color\n"
	                          "    draws into depth\n"
	                          "    reads <&\n"
	                          "  2 shrink, fullscreen, 4 x 4\n"
	                          "    barrier  chain mip 1, layer 1: color > color, memory used before, content dropped\n"
	                          "    barrier  color: resolve > sampled_fragment\n"
	                          "    draws into chain mip 1, layer 1\n"
	                          "    samples color\n"
	                          "  6 mix, copy\n"
	                          "    barrier  color: sampled_fragment > copy_from\n"
	                          "    barrier  old: nothing > copy_to, content dropped\n"
	                          "    copies from color\n"
	                          "    copies to old\n"
	                          "  7 tone, fullscreen, 64 x 64\n"
	                          "    barrier  picture: nothing > color, content dropped\n"
	                          "    barrier  chain mip 1, layer 1: color > sampled_fragment\n"
	                          "    barrier  old: copy_to > sampled_fragment\n"
	                          "    draws into picture\n"
	                          "    samples chain mip 1, layer 1\n"
	                          "    samples old\n"
	                          "    after the frame\n"
	                          "    barrier  picture: color > output\n"
	                          "left out\n"
	                          "  3 waste: nobody reads chain mip 2, layer 0 after it\n"
	                          "  4 early: nobody reads picture before tone replaces it\n"
	                          "  5 idle: it writes nothing\n"
	                          "resources\n"
	                          "    color, rgba16_f 64 x 64, 32.0 KiB, passes 1 to 6, heap 0 at 196608\n"
	                          "    depth, d32_f 64 x 64 4 samples, 64.0 KiB, passes 1 to 1, heap 0 at 131072\n"
	                          "    many, rgba16_f 64 x 64 4 samples, 128.0 KiB, passes 1 to 1, heap 0 at 0\n"
	                          "    old, rgba16_f 64 x 64, 32.0 KiB, passes 6 to 7, kept\n"
	                          "    chain, r8_u 8 x 8 2 layers 3 mips, 168 B, passes 2 to 7, heap 0 at 0\n"
	                          "    <&, buffer, 4.0 KiB, passes 1 to 1, owned\n"
	                          "    picture, rgba8_srgb 64 x 64, 16.0 KiB, passes 7 to 7, output\n");
	free(text);
	stilb_gpu_plan_destroy(plan);
}

/* Every element that is opened is closed, in order, and no text has a bare & or <. */
static void check_xml(const char *text)
{
	char open[32][16];
	uint32_t depth = 0;
	for (const char *at = text; *at; at++) {
		if (*at == '&')
			assert_true(at[1] == '#' && strchr(at, ';') && strspn(at + 2, "0123456789") > 0);
		if (*at != '<')
			continue;
		const char *end = strchr(at, '>');
		assert_non_null(end);
		assert_null(memchr(at + 1, '<', (size_t)(end - at - 1)));
		char name[16] = "";
		sscanf(at[1] == '/' ? at + 2 : at + 1, "%15[a-z]", name);
		assert_true(name[0] != '\0');
		if (at[1] == '/') {
			assert_true(depth > 0);
			assert_string_equal(name, open[--depth]);
		} else if (end[-1] != '/') {
			assert_true(depth < 32);
			strcpy(open[depth++], name);
		}
		at = end;
	}
	assert_int_equal(depth, 0);
}

static void test_svg(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	char *text;
	script_make(plan, shown);
	assert_int_equal(stilb_gpu_plan_svg(plan, &text), STILB_OK);
	check_xml(text);
	static const char *const wanted[] = {">1 scene</text>",
	                                     ">after the frame</text>",
	                                     ">&#60;&#38;</text>",
	                                     "<title>barrier of chain mip 1, layer 1: color &#62; sampled_fragment</title>",
	                                     "3 left out: waste: nobody reads chain mip 2, layer 0 after it",
	                                     ">heap 0<"};
	for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
		if (!strstr(text, wanted[i]))
			fail_msg("no '%s' in\n%s", wanted[i], text);
	free(text);
	static random_table table;
	for (uint64_t i = 0; i < 100; i++) { /* any plan */
		stilb_gpu_plan_begin(plan, 100, 50);
		random_make(&table, i, i);
		random_add(&table, plan);
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
		assert_int_equal(stilb_gpu_plan_svg(plan, &text), STILB_OK);
		check_xml(text);
		free(text);
		assert_int_equal(stilb_gpu_plan_text(plan, &text), STILB_OK);
		free(text);
	}
	stilb_gpu_plan_begin(plan, 1, 1); /* also one without a row */
	assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
	assert_int_equal(stilb_gpu_plan_svg(plan, &text), STILB_OK);
	check_xml(text);
	free(text);
	stilb_gpu_plan_destroy(plan);
}

/* ---- sizes, and no memory ---------------------------------------------------------------------------------------- */

static void test_sizes(void **state)
{
	(void)state;
	static const struct {
		uint32_t width, height;
		float scale;
		uint32_t wanted[2], mips;
	} sizes[] = {{1, 1, 1.0f, {1, 1}, 1},
	             {1, 1, 0.25f, {1, 1}, 1},
	             {4099, 3, 0.5f, {2050, 2}, 12},
	             {4099, 3, 1.0f, {4099, 3}, 13},
	             {16384, 16384, 1.0f, {16384, 16384}, 15},
	             {100, 50, 2.0f, {200, 100}, 8}};
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		stilb_gpu_plan_begin(plan, sizes[i].width, sizes[i].height);
		uint16_t a = stilb_gpu_plan_image(
			plan,
			&(stilb_gpu_plan_image_row){
				.name = "a", .format = STILB_GPU_R8_U, .scale = sizes[i].scale, .mips = STILB_GPU_ALL, .owned = 1});
		const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, a);
		assert_int_equal(extent->width, sizes[i].wanted[0]);
		assert_int_equal(extent->height, sizes[i].wanted[1]);
		assert_int_equal(extent->mips, sizes[i].mips);
		stilb_gpu_range range = stilb_gpu_plan_range(plan, &(stilb_gpu_use){.resource = a});
		assert_int_equal(range.mips, sizes[i].mips);
		assert_int_equal(range.layers, 1);
		assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
	}
	stilb_gpu_plan_destroy(plan);
	assert_int_equal(stilb_gpu_format_bytes(STILB_GPU_BC1_U, 5, 5, 1), 4 * 8);
	assert_int_equal(stilb_gpu_format_bytes(STILB_GPU_RGBA16_F, 5, 5, 2), 400);
	assert_int_equal(stilb_gpu_format_bytes(STILB_GPU_R8_U, 16384, 16384, 16384), 1ull << 42);
}

static stilb_result make_table(stilb_gpu_plan *plan, const random_table *table)
{
	stilb_gpu_plan_begin(plan, 64, 64);
	random_add(table, plan);
	return stilb_gpu_plan_make(plan, NULL);
}

/* Each allocation of a plan fails once: an error, and then the plan is that of a first frame. */
static void test_no_memory(void **state)
{
	(void)state;
	static random_table table;
	random_make(&table, 5, 5);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	assert_int_equal(make_table(plan, &table), STILB_OK);
	char *wanted = script_barriers(plan);
	stilb_gpu_plan_destroy(plan);
	bool failed = true;
	uint32_t failures = 0;
	for (uint32_t n = 1; failed; n++) {
		plan = stilb_gpu_plan_create();
		assert_non_null(plan);
		reallocs = 0;
		refused = n;
		stilb_result result = make_table(plan, &table);
		failed = reallocs >= n;
		refused = 0;
		failures += failed;
		assert_int_equal(result, failed ? STILB_ERROR_MEMORY : STILB_OK);
		if (failed) {
			assert_int_equal(make_table(plan, &table), STILB_OK);
			expect_barriers(plan, wanted);
		}
		stilb_gpu_plan_destroy(plan);
	}
	assert_true(failures > 10);
	free(wanted);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_two),      cmocka_unit_test(test_layout_between), cmocka_unit_test(test_planner),
		cmocka_unit_test(test_programs), cmocka_unit_test(test_turns),          cmocka_unit_test(test_lifetimes),
		cmocka_unit_test(test_shown),    cmocka_unit_test(test_resize),         cmocka_unit_test(test_kept),
		cmocka_unit_test(test_dropped),  test_one_thread(test_steady),          cmocka_unit_test(test_left_out),
		cmocka_unit_test(test_hash),     cmocka_unit_test(test_hash_constants), cmocka_unit_test(test_text),
		cmocka_unit_test(test_svg),      cmocka_unit_test(test_sizes),          cmocka_unit_test(test_no_memory),
		cmocka_unit_test(test_cut),      cmocka_unit_test(test_cut_mistakes),   cmocka_unit_test(test_cut_frames),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
