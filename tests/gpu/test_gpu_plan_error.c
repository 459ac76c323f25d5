/* What is wrong with rows, each rule once: the whole message, which names the pass, the resource and the way out. */
#include "gpu_script.h"

#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct mistake {
	const char *rows, *message;
} mistake;

/* Rows that scripts can write. */
static const mistake mistakes[] = {
	/* images and buffers */
	{"image a none", "image 'a' has no format: 0 is none of stilb_gpu_format"},
	{"image a rgba8_u scale -1", "image 'a' has the scale -1: give a share of the picture's size, or 0"},
	{"image a rgba8_u 8x8 scale 0.5", "image 'a' has a scale, 0.5, and a size, 8 x 8: only one of both counts"},
	{"image a rgba8_u scale 1000", "image 'a' is 1000 times a picture of 64 x 64: a side has at most 16384 texels"},
	{"image a rgba8_u 16385x1", "image 'a' is 16385 x 1 x 1: a side has at most 16384 texels"},
	{"image a rgba8_u 8x8 layers 2049", "image 'a' has 2049 layers: 2048 are the most"},
	{"image a rgba8_u 8x2 1d", "image 'a' is 1-D and 2 texels high: its height is 1"},
	{"image a rgba8_u 8x4 cube", "image 'a' is a cube of 8 x 4 texels: a cube's sides are equal"},
	{"image a rgba8_u 8x8 cube layers 7", "image 'a' is a cube of 7 layers: give a multiple of six"},
	{"image a rgba8_u 8x8 3d 4 layers 2", "image 'a' is 3-D with 2 layers: its slices are its depth"},
	{"image a rgba8_u 8x4 mips 5", "image 'a' has 5 mips: one of 8 x 4 x 1 has at most 4 (STILB_GPU_ALL)"},
	{"image a rgba8_u 8x4 samples 3", "image 'a' has 3 samples a texel: give 1, 2, 4 or 8"},
	{"image a rgba8_u 8x8 samples 4 mips 2", "image 'a' has 4 samples a texel: such images are 2-D and have one mip"},
	{"image a d32_f 8x8 3d 4", "image 'a' has the format d32_f, which only 2-D images and cubes have"},
	{"image a bc1_u 8x8 samples 4", "image 'a' has the format bc1_u, which has one sample a texel, not 4"},
	{"image a rgba8_u keep owned 5", "image 'a' is owned and kept: what is owned stays anyway, leave keep out"},
	{"image a rgba8_u\nbuffer a 16", "two resources, 1 and 2, have the name 'a': each has one of its own"},
	{"image a rgba8_u owned 5\nimage b rgba8_u owned 5", "'a' and 'b' are the same owned image: name it once"},
	{"buffer a 0", "buffer 'a' has no size: give its bytes"},
	{"image a rgba8_u output", "image 'a' is an output, and no pass writes it: add one, or leave it out"},
	{"image a rgba8_u\nshow a", "image 'a' is shown, and no pass writes it: add one, or leave it out"},

	/* kinds of passes */
	{"draws p", "pass 1 'p' draws into nothing: give it a colour or depth attachment, or make it a dispatch"},
	{"image a rgba8_u\ndispatch p clear:a",
     "pass 1 'p' is of kind dispatch and has attachments: only draws and fullscreen passes have"},
	{"image a rgba8_u\ndispatch p groups:0 store:a",
     "pass 1 'p' dispatches no groups: give three counts, or a buffer with them as an INDIRECT use"},
	{"buffer b 64 owned 1\nimage a rgba8_u\ndispatch p store:a indirect:b",
     "pass 1 'p' has groups, 1 x 1 x 1, and an INDIRECT use: only one of both counts"},

	/* attachments */
	{"buffer a 16\nimage b rgba8_u output\ndraws p clear:b over:a",
     "pass 1 'p' has the buffer 'a' as colour attachment, which is an image"},
	{"image a bc1_u\ndraws p clear:a", "pass 1 'p' has 'a' as colour attachment, whose format bc1_u is compressed"},
	{"image a rgba8_u owned 1\ndraws p test:a",
     "pass 1 'p' has 'a' as read-only colour attachment: only depth can be; sample it instead"},
	{"image a rgba8_u 8x8 3d 4\ndraws p clear:a",
     "pass 1 'p' has the 3-D image 'a' as colour attachment: write it by a dispatch"},
	{"image a rgba8_u 8x8 mips 2\ndraws p clear:a[2]", "pass 1 'p' draws into mip 2 of 'a', which has 2"},
	{"image a rgba8_u 8x8 layers 2\ndraws p clear:a[0/1-2]", "pass 1 'p' draws into layers 1 to 2 of 'a', which has 2"},
	{"image a rgba8_u 8x8\nimage b rgba8_u 8x4\ndraws p clear:a clear:b",
     "pass 1 'p' draws into 'a' of 8 x 8 texels and into 'b' of 8 x 4: attachments of a pass have one size"},
	{"image a rgba8_u 8x8\nimage b rgba8_u 8x8 layers 2\ndraws p clear:a clear:b[0/0-1]",
     "pass 1 'p' draws into 1 layers of 'a' and into 2 of 'b': attachments of a pass have one number of layers"},
	{"image a rgba8_u samples 4\nimage depth d32_f\ndraws p clear:a clear:depth",
     "pass 1 'p' draws into 'a' with 4 samples a texel and into 'depth' with 1: attachments of a pass have one number"},
	{"image a rgba8_u\nimage b rgba8_u\ndraws p clear:a>b",
     "pass 1 'p' resolves 'a', which has one sample a texel: leave the resolve out, or give it more"},
	{"image a rgba8_u samples 4\nimage b rgba8_u samples 2\ndraws p clear:a>b",
     "pass 1 'p' resolves 'a' into 'b', which has 2 samples a texel: it must have one"},
	{"image a rgba8_u samples 4\nimage b rgba16_f\ndraws p clear:a>b",
     "pass 1 'p' resolves 'a' of format rgba8_u into 'b' of format rgba16_f: they must have one format"},
	{"image a r32_ui samples 4\nimage b r32_ui\ndraws p clear:a>b",
     "pass 1 'p' resolves 'a' of format r32_ui: integers have no mean"},
	{"image a rgba8_u samples 4 layers 2\nimage b rgba8_u\ndraws p clear:a[0/0-1]>b",
     "pass 1 'p' resolves 2 layers of 'a': only one can be resolved"},
	{"image a rgba8_u 8x8 samples 4\nimage b rgba8_u 8x4\ndraws p clear:a>b",
     "pass 1 'p' draws into 'a' of 8 x 8 texels and into 'b' of 8 x 4: attachments of a pass have one size"},
	{"image a rgba8_u 8x8 samples 4\nimage b rgba8_u 8x8 3d 2\ndraws p clear:a>b",
     "pass 1 'p' resolves 'a' into the 3-D image 'b': it must be 2-D"},
	{"image a d32_f samples 4\nimage b d32_f\ndraws p clear:a>b",
     "pass 1 'p' resolves the depths of 'a', which have no mean"},

	/* uses */
	{"image a rgba8_u owned 1\ndispatch p from:a", "pass 1 'p' copies from 'a', which no pass of kind dispatch does"},
	{"image a rgba8_u owned 1\nimage b rgba8_u\ncopy p sample:a to:b",
     "pass 1 'p' samples 'a', which no pass of kind copy does"},
	{"buffer a 64 owned 1\nimage b rgba8_u\nscreen p fresh:b vertices:a",
     "pass 1 'p' takes vertices from 'a', which no pass of kind fullscreen does"},
	{"buffer a 64 owned 1\ndispatch p sample:a", "pass 1 'p' samples the buffer 'a': only images are sampled"},
	{"image a rgba8_u owned 1\nimage b rgba8_u\ndraws p clear:b vertices:a",
     "pass 1 'p' takes vertices from the image 'a': it must be a buffer"},
	{"image a rgba8_u\ndispatch p sample:a'",
     "pass 1 'p' reads last frame's 'a', which is not kept: set keep in its row"},
	{"image a rgba8_u keep\ndispatch p store:a'", "pass 1 'p' writes last frame's 'a', which can only be read"},
	{"image a rgba8_u 8x8 mips 2 owned 1\ndispatch p sample:a[1-2]",
     "pass 1 'p' samples mips 1 to 2 of 'a', which has 2"},
	{"image a rgba8_u 8x8 layers 2 owned 1\ndispatch p sample:a[0/2]",
     "pass 1 'p' samples layers 2 to 2 of 'a', which has 2"},
	{"buffer a 64 owned 1\ndispatch p load:a[1]", "pass 1 'p' reads mips or layers of the buffer 'a', which has none"},
	{"image a d32_f\ndispatch p store:a",
     "pass 1 'p' writes 'a' as a storage image, whose format d32_f is one of depths: take another, or draw into it"},
	{"image a rgba8_srgb owned 1\ndispatch p load:a",
     "pass 1 'p' reads 'a' as a storage image, whose format rgba8_srgb is sRGB: sample it instead"},
	{"image a bc1_u owned 1\ndispatch p load:a",
     "pass 1 'p' reads 'a' as a storage image, whose format bc1_u is compressed: sample it instead"},
	{"image a rgba8_u samples 4 owned 1\ndispatch p load:a",
     "pass 1 'p' reads 'a' as a storage image, which has 4 samples a texel: one is all it can have"},
	{"image a rgba8_u 8x8 mips 2\ndispatch p store:a",
     "pass 1 'p' writes 2 mips of 'a' as one storage image: each is a use of its own, set mips to 1"},
	{"buffer b 8 owned 1\nimage a rgba8_u\ndispatch p groups:0 store:a indirect:b",
     "pass 1 'p' takes commands from byte 0 of 'b', which has 8: it needs 12 there, at a multiple of 4"},
	{"buffer b 64 owned 1\nbuffer c 64 owned 2\nimage a rgba8_u\ndraws p clear:a indirect:b indirect:c",
     "pass 1 'p' takes commands from 'b' and from 'c': only one can be"},

	/* copies */
	{"image a rgba8_u owned 1\ncopy p from:a", "pass 1 'p' copies by 1 uses: it must have two, COPY_FROM and COPY_TO"},
	{"image a rgba8_u samples 4 owned 1\nimage b rgba8_u\ncopy p from:a to:b",
     "pass 1 'p' copies 'a', which has 4 samples a texel: resolve it instead"},
	{"image a rgba8_u 8x8 mips 2 owned 1\nimage b rgba8_u 8x8\ncopy p from:a to:b",
     "pass 1 'p' copies 2 mips and 1 layers of 'a' to 1 mips and 1 layers of 'b': they must be as many"},
	{"image a rgba8_u 8x8 3d 4 owned 1\nimage b rgba8_u 8x8\ncopy p from:a to:b",
     "pass 1 'p' copies between 'a' and 'b', of which only one is 3-D"},
	{"image a d32_f 8x8 owned 1\nimage b d32_f 4x4\ncopy p from:a to:b",
     "pass 1 'p' copies 'a' of format d32_f to 'b' of format d32_f, of another size or format, which takes a filter: "
     "it "
     "has none for depths, integers and compressed formats"},
	{"image a rgba8_u 8x8 owned 1\nbuffer b 255\ncopy p from:a to:b",
     "pass 1 'p' copies 'a' of 256 bytes to 'b' of 255: the buffer is too small"},
	{"buffer a 255 owned 1\nimage b rgba8_u 8x8\ncopy p from:a to:b",
     "pass 1 'p' copies 'a' of 255 bytes to 'b' of 256: the buffer is too small"},

	/* who writes, who reads */
	{"image a rgba8_u\nimage b rgba8_u output\nscreen p fresh:b sample:a",
     "pass 1 'p' samples 'a', which no pass writes: add one before it, or own it"},
	{"image a rgba8_u keep\nimage b rgba8_u output\nscreen p fresh:b sample:a",
     "pass 1 'p' samples 'a', which no pass writes: add one before it, or own it, or read last frame's (previous)"},
	{"image a rgba8_u\nimage b rgba8_u output\nscreen p fresh:b sample:a\nscreen q over:b\nscreen r fresh:a",
     "pass 1 'p' samples 'a', which only a later row writes, pass 3 'r': change their order, or keep it and read last "
     "frame's (previous)"},
	{"image a rgba8_u 8x8 mips 3\nimage b rgba8_u output\nscreen p fresh:a[0]\nscreen q fresh:a[2]\nscreen r fresh:b "
     "sample:a",
     "pass 3 'r' samples mip 1, layer 0 of 'a', which no pass writes: add one before it, or own it"},
	{"image a rgba8_u output\ndraws p over:a",
     "pass 1 'p' draws over 'a', which no earlier pass writes: clear or discard it first, or own it"},
	{"image depth d32_f\nimage a rgba8_u\ndraws p clear:a test:depth",
     "pass 1 'p' tests against 'depth', which no pass writes: add one before it, or own it"},
	{"buffer a 64 output\ndispatch p modify:a",
     "pass 1 'p' reads and writes 'a', which no earlier pass writes: clear or discard it first, or own it"},
	{"image a rgba8_u output\ndraws p clear:a\nscreen q over:a sample:a",
     "pass 2 'q' draws over and samples 'a': what a pass writes it can use in no other way, take two images or two "
     "passes"},
	{"image a rgba8_u 8x8 mips 2 output\ndraws p clear:a[0]\nscreen q fresh:a[1] sample:a",
     "pass 2 'q' draws into and samples mip 1, layer 0 of 'a': what a pass writes it can use in no other way, take two "
     "images or two passes"},
	{"image a rgba8_u output\ndraws p clear:a clear:a",
     "pass 1 'p' draws into and draws into 'a': what a pass writes it can use in no other way, take two images or two "
     "passes"},
	{"buffer a 64 output\nhost p host:a",
     "pass 1 'p' reads and writes 'a', which is the plan's own: give it a buffer of the program's (owned)"},
	{"image a rgba8_u owned 1\nbuffer b 64 output\ndispatch p sample:a load:a store:b",
     "pass 1 'p' samples and reads 'a', sampled and as a storage image: read it in one of both ways"},
};

static void expect(stilb_gpu_plan *plan, const char *message)
{
	stilb_result result = stilb_gpu_plan_make(plan, NULL);
	if (result != STILB_ERROR_ARGUMENT || strcmp(stilb_error_message(), message) != 0)
		fail_msg("result %d, '%s'\nand not\n'%s'", (int)result, stilb_error_message(), message);
	const stilb_gpu_step *steps;
	assert_int_equal(stilb_gpu_plan_steps(plan, &steps), 0);
}

static void test_scripts(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
		for (uint32_t twice = 0; twice < 2; twice++) { /* also where the rows are those of the frame before */
			stilb_gpu_plan_begin(plan, 64, 64);
			script_rows(plan, mistakes[i].rows);
			expect(plan, mistakes[i].message);
		}
		script_make(plan, "image a rgba8_u output\ndraws p clear:a"); /* and a good frame in between */
	}
	stilb_gpu_plan_destroy(plan);
}

/* ---- rows that scripts cannot write ---------------------------------------------------------------------------- */

/* A plan with an owned 8 x 8 image (1), an owned buffer of 64 bytes (2) and an image (3). */
static stilb_gpu_plan *begin(void)
{
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, "image own rgba8_u 8x8 owned 1\nbuffer data 64 owned 2\nimage a rgba8_u 8x8");
	return plan;
}

static void no_function(void *user)
{
	(void)user;
}

static void expect_pass(stilb_gpu_pass pass, const char *message)
{
	stilb_gpu_plan *plan = begin();
	stilb_gpu_plan_pass(plan, &pass);
	expect(plan, message);
	stilb_gpu_plan_destroy(plan);
}

static void expect_image(stilb_gpu_plan_image_row row, const char *message)
{
	stilb_gpu_plan *plan = begin();
	assert_int_equal(stilb_gpu_plan_image(plan, &row), 0);
	expect(plan, message);
	stilb_gpu_plan_destroy(plan);
}

static const stilb_gpu_pass good = {.name = "p",
                                    .kind = STILB_GPU_PASS_FULLSCREEN,
                                    .program = 1,
                                    .color = {{.image = 3, .load = STILB_GPU_LOAD_CLEAR}},
                                    .color_count = 1};

static void test_passes(void **state)
{
	(void)state;
	stilb_gpu_pass pass = good;
	pass.name = NULL;
	expect_pass(pass, "pass 1 has no name");
	pass = good;
	pass.kind = 9;
	expect_pass(pass, "pass 1 'p' has the kind 9: it is none of stilb_gpu_pass_kind");
	pass = good;
	pass.color_count = 9;
	expect_pass(pass, "pass 1 'p' has 9 colour attachments: 8 are the most");
	pass = good;
	pass.use_count = 13;
	expect_pass(pass, "pass 1 'p' has 13 uses: 12 are the most");
	pass = good;
	pass.constant_bytes = 6;
	expect_pass(pass, "pass 1 'p' has 6 bytes of constants: give a multiple of 4, at most 128");
	pass.constant_bytes = 132;
	expect_pass(pass, "pass 1 'p' has 132 bytes of constants: give a multiple of 4, at most 128");
	pass = good;
	pass.program = 0;
	expect_pass(pass, "pass 1 'p' is of kind fullscreen and has no program");
	pass = good;
	pass.groups[1] = 1;
	expect_pass(pass, "pass 1 'p' is of kind fullscreen and has groups: they are a dispatch's");
	pass = (stilb_gpu_pass){.name = "p", .kind = STILB_GPU_PASS_DISPATCH, .program = 1, .groups = {4, 0, 1}};
	expect_pass(pass, "pass 1 'p' dispatches 4 x 0 x 1 groups, which are none: each count is at least 1");
	pass = (stilb_gpu_pass){.name = "p", .kind = STILB_GPU_PASS_COPY, .program = 1};
	expect_pass(pass, "pass 1 'p' is of kind copy and has a program: leave it 0");
	pass = (stilb_gpu_pass){.name = "p", .kind = STILB_GPU_PASS_COPY, .constant_bytes = 4};
	expect_pass(pass, "pass 1 'p' is of kind copy and has constants: leave them out");
	pass = (stilb_gpu_pass){.name = "p", .kind = STILB_GPU_PASS_HOST};
	expect_pass(pass, "pass 1 'p' is of kind host and has no function: passes of kind host have one, and no others do");
	pass.host = no_function;
	pass.program = 1;
	expect_pass(pass, "pass 1 'p' is of kind host and has a program: leave it 0");
	pass = good;
	pass.host = no_function;
	expect_pass(pass,
	            "pass 1 'p' is of kind fullscreen and has a function: passes of kind host have one, and no others "
	            "do");
}

static void test_areas(void **state)
{
	(void)state;
	stilb_gpu_pass pass = good;
	memcpy(pass.area, (uint16_t[4]){1, 2, 8, 6}, sizeof pass.area);
	expect_pass(pass, "pass 1 'p' fills 8 x 6 texels at 1, 2, and 'a' has 8 x 8: make it smaller");
	memcpy(pass.area, (uint16_t[4]){1, 3, 7, 6}, sizeof pass.area);
	expect_pass(pass, "pass 1 'p' fills 7 x 6 texels at 1, 3, and 'a' has 8 x 8: make it smaller");
	memcpy(pass.area, (uint16_t[4]){65535, 0, 65535, 1}, sizeof pass.area);
	expect_pass(pass, "pass 1 'p' fills 65535 x 1 texels at 65535, 0, and 'a' has 8 x 8: make it smaller");
	memcpy(pass.area, (uint16_t[4]){1, 2, 0, 6}, sizeof pass.area);
	expect_pass(pass, "pass 1 'p' fills 0 x 6 texels at 1, 2: give it sides above 0, or four zeros for all");
	pass = (stilb_gpu_pass){
		.name = "p", .kind = STILB_GPU_PASS_DISPATCH, .program = 1, .groups = {1, 1, 1}, .area = {0, 0, 1, 1}};
	expect_pass(pass, "pass 1 'p' is of kind dispatch and has an area: only draws and fullscreen passes have");
}

/* The whole image is a possible area, and the hash tells areas apart. */
static void test_areas_that_fit(void **state)
{
	(void)state;
	static const uint16_t areas[][4] = {{0, 0, 0, 0}, {0, 0, 8, 8}, {7, 7, 1, 1}, {0, 0, 1, 1}, {0, 1, 1, 1}};
	uint64_t hashes[5];
	for (uint32_t i = 0; i < 5; i++) {
		stilb_gpu_plan *plan = begin();
		stilb_gpu_pass pass = good;
		memcpy(pass.area, areas[i], sizeof pass.area);
		stilb_gpu_plan_show(plan, 3);
		stilb_gpu_plan_pass(plan, &pass);
		if (stilb_gpu_plan_make(plan, NULL) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		hashes[i] = stilb_gpu_plan_hash(plan);
		for (uint32_t j = 0; j < i; j++)
			assert_true(hashes[i] != hashes[j]);
		stilb_gpu_plan_destroy(plan);
	}
}

static void test_attachments(void **state)
{
	(void)state;
	stilb_gpu_pass pass = good;
	pass.color[0].image = 0;
	expect_pass(pass, "pass 1 'p' has a colour attachment without an image");
	pass.color[0].load = STILB_GPU_LOAD_NONE;
	expect_pass(pass, "pass 1 'p' draws into nothing: give it a colour or depth attachment, or make it a dispatch");
	pass.color[0].load = STILB_GPU_LOAD_CLEAR;
	pass.color[0].image = 4;
	expect_pass(pass, "pass 1 'p' has resource 4 as colour attachment, and the plan has 3: numbers are those of this "
	                  "frame's rows");
	pass = good;
	pass.color[0].load = 7;
	expect_pass(pass, "pass 1 'p' loads 'a' by 7: it is none of stilb_gpu_load");
	pass = good;
	pass.depth.image = 1;
	expect_pass(pass, "pass 1 'p' has 'own' as depth attachment, whose format rgba8_u is none of depths: take d32_f or "
	                  "d16");
	stilb_gpu_plan *plan = begin();
	pass = good;
	pass.depth = (stilb_gpu_attachment){
		.image = stilb_gpu_plan_image(
			plan,
			&(stilb_gpu_plan_image_row){.name = "d", .format = STILB_GPU_D16, .width = 8, .height = 8, .owned = 9}),
		.load = STILB_GPU_LOAD_CLEAR,
		.read_only = true};
	stilb_gpu_plan_pass(plan, &pass);
	expect(plan, "pass 1 'p' has 'd' as read-only depth attachment and does not keep what it holds");
	stilb_gpu_plan_begin(plan, 64, 64);
	pass.depth.image = 0;
	pass.color[0] = (stilb_gpu_attachment){
		.image = stilb_gpu_plan_image(
			plan, &(stilb_gpu_plan_image_row){.name = "d", .format = STILB_GPU_D16, .width = 8, .height = 8}),
		.load = STILB_GPU_LOAD_CLEAR};
	stilb_gpu_plan_pass(plan, &pass);
	expect(plan, "pass 1 'p' has 'd' as colour attachment, whose format d16 is one of depths");
	stilb_gpu_plan_destroy(plan);
}

static void test_uses(void **state)
{
	(void)state;
	stilb_gpu_pass pass = good;
	pass.use_count = 1;
	expect_pass(pass, "pass 1 'p' uses resource 0, and the plan has 1 to 3: numbers are those of this frame's rows");
	pass.uses[0] = (stilb_gpu_use){.resource = 1, .how = 10};
	expect_pass(pass, "pass 1 'p' uses 'own' by 10: it is none of stilb_gpu_use_kind");
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_STORAGE_READ, .sampler = 1};
	pass.constant_bytes = 16;
	expect_pass(pass, "pass 1 'p' reads 'data' with a sampler, which only sampled images have");
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_STORAGE_READ, .slot = 12};
	expect_pass(pass, "pass 1 'p' reads 'data' by an address at byte 12 of 16 bytes of constants: it takes 8, at a "
	                  "multiple of 8");
	pass.uses[0].slot = 16;
	expect_pass(pass, "pass 1 'p' reads 'data' by an address at byte 16 of 16 bytes of constants: it takes 8, at a "
	                  "multiple of 8");
	pass.uses[0].slot = 8;
	pass.uses[1] = pass.uses[0];
	pass.use_count = 2;
	expect_pass(pass, "pass 1 'p' has 'data' and 'data' at the slot 8: each has one of its own");
	pass.uses[0] = pass.uses[1] = (stilb_gpu_use){.resource = 1, .how = STILB_GPU_USE_SAMPLED, .slot = 3};
	expect_pass(pass, "pass 1 'p' has 'own' and 'own' at the slot 3: each has one of its own");
	pass.uses[0] = pass.uses[1] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_UNIFORM, .slot = 1};
	expect_pass(pass, "pass 1 'p' has 'data' and 'data' at the slot 1: each has one of its own");
	pass.use_count = 1;
	pass.uses[0].resource = 1;
	expect_pass(pass, "pass 1 'p' reads the image 'own': it must be a buffer");
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_UNIFORM, .first = 256, .bytes = 1u << 30};
	expect_pass(pass, "pass 1 'p' reads bytes 256 + 1073741824 of 'data' as a uniform buffer, which has 64");
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_HOST};
	expect_pass(pass, "pass 1 'p' reads and writes 'data', which no pass of kind fullscreen does");
	stilb_gpu_pass host = {.name = "p", .kind = STILB_GPU_PASS_HOST, .host = no_function, .use_count = 1};
	host.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_STORAGE};
	expect_pass(host, "pass 1 'p' reads and writes 'data', which no pass of kind host does");
	host.uses[0].how = STILB_GPU_USE_HOST;
	host.uses[0].resource = 1;
	expect_pass(host, "pass 1 'p' reads and writes the image 'own': it must be a buffer");
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_STORAGE_READ, .slot = 8, .bytes = 16};
	expect_pass(pass, "pass 1 'p' reads bytes 0 + 16 of 'data': only uniform buffers are parts");
	pass.kind = STILB_GPU_PASS_DRAWS;
	pass.uses[0] = (stilb_gpu_use){.resource = 2, .how = STILB_GPU_USE_VERTICES, .slot = 8};
	expect_pass(pass, "pass 1 'p' takes vertices from 'data' with the slot 8, which says nothing here: leave it 0");
}

static void test_resources(void **state)
{
	(void)state;
	expect_image((stilb_gpu_plan_image_row){.format = STILB_GPU_R8_U, .width = 1}, "image 4 has no name");
	char name[80];
	memset(name, 'x', sizeof name);
	name[64] = '\0';
	char message[200] = "the image's name '";
	strcat(strcat(message, name), "' has 64 bytes: 63 are the most");
	expect_image((stilb_gpu_plan_image_row){.name = name, .format = STILB_GPU_R8_U, .width = 1}, message);
	expect_image((stilb_gpu_plan_image_row){.name = "b", .format = STILB_GPU_R8_U, .width = 1, .shape = 4},
	             "image 'b' has the shape 4: it is none of stilb_gpu_shape");
	expect_image((stilb_gpu_plan_image_row){.name = "b", .format = STILB_GPU_R8_U, .scale = NAN},
	             "image 'b' has the scale nan: give a share of the picture's size, or 0");
	expect_image((stilb_gpu_plan_image_row){.name = "b", .format = STILB_GPU_R8_U, .width = 1, .depth = 2},
	             "image 'b' has the depth 2 and is not 3-D: give layers, or the shape 3-D");
	expect_image((stilb_gpu_plan_image_row){.name = "b", .format = STILB_GPU_R8_U, .height = 8},
	             "image 'b' has no size: give a scale, or a width in texels");
	stilb_gpu_plan *plan = begin();
	assert_int_equal(stilb_gpu_plan_buffer(plan, &(stilb_gpu_plan_buffer_row){.name = "b", .bytes = 1ull << 41}), 0);
	expect(plan, "buffer 'b' has 2199023255552 bytes: 1099511627776 are the most");
	stilb_gpu_plan_destroy(plan);
}

static void test_counts(void **state)
{
	(void)state;
	static char names[STILB_GPU_PLAN_MAX_RESOURCES + 1][8];
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	for (uint32_t more = 0; more < 2; more++) {
		stilb_gpu_plan_begin(plan, 1, 1);
		for (uint32_t i = 0; i < STILB_GPU_PLAN_MAX_RESOURCES + more; i++) {
			snprintf(names[i], sizeof names[i], "i%u", i);
			uint16_t number = stilb_gpu_plan_image(
				plan, &(stilb_gpu_plan_image_row){.name = names[i], .format = STILB_GPU_R8_U, .width = 1});
			assert_int_equal(number, i < STILB_GPU_PLAN_MAX_RESOURCES ? i + 1 : 0);
		}
		stilb_gpu_pass pass = good;
		for (uint32_t i = 0; i < STILB_GPU_PLAN_MAX_PASSES; i++) {
			pass.color[0].image = (uint16_t)(i + 1);
			stilb_gpu_plan_pass(plan, &pass);
		}
		if (more == 0)
			assert_int_equal(stilb_gpu_plan_make(plan, NULL), STILB_OK);
		else
			expect(plan, "the plan has more than 4096 resources");
	}
	stilb_gpu_plan_begin(plan, 1, 1);
	script_rows(plan, "image a rgba8_u");
	stilb_gpu_pass pass = good;
	pass.color[0].image = 1;
	for (uint32_t i = 0; i <= STILB_GPU_PLAN_MAX_PASSES; i++)
		stilb_gpu_plan_pass(plan, &pass);
	expect(plan, "the plan has more than 4096 passes");
	stilb_gpu_plan_destroy(plan);
}

/* ---- the device's answers, and rows of noise ------------------------------------------------------------------- */

static stilb_result no_such_image(void *user, const stilb_gpu_extent *extent, stilb_gpu_needs *needs)
{
	(void)user, (void)needs;
	return stilb_fail(STILB_ERROR_ARGUMENT, "this device has no image of %u texels", extent->width);
}

static const char *no_such_program(void *user, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	(void)plan;
	return strcmp(pass->name, user) == 0 ? "has a program that this device has not" : NULL;
}

static void test_device(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, "image a rgba8_u\nimage b rgba8_u output\ndraws one clear:a\nscreen two fresh:b sample:a");
	stilb_gpu_planner planner = {.image_needs = no_such_image};
	assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), "this device has no image of 64 texels");
	char name[] = "two";
	planner = (stilb_gpu_planner){.mistake = no_such_program, .user = name};
	assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), "pass 2 'two' has a program that this device has not");
	planner = (stilb_gpu_planner){0};
	assert_int_equal(stilb_gpu_plan_make(plan, &planner), STILB_OK);
	stilb_gpu_plan_destroy(plan);
}

/* Rows whose bytes are random, or nearly good: a result, and no crash. */
static void test_noise(void **state)
{
	(void)state;
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	uint32_t good_ones = 0;
	for (uint64_t i = 0; i < (TEST_ASAN ? 5000 : 30000); i++) {
		stilb_gpu_plan_begin(plan, 64, 64);
		script_rows(plan, "image a rgba8_u 8x8 mips 2 layers 2 keep\nimage b rgba8_u 8x8 samples 4\n"
		                  "image c rgba8_u 8x8 owned 3\nimage d d32_f 8x8 owned 4\nbuffer e 64 owned 5\n"
		                  "image f rgba8_u 8x8 output\ndraws all clear:f");
		for (uint64_t k = 0; k < 3; k++) {
			stilb_gpu_pass pass = good;
			uint8_t *bytes = (uint8_t *)&pass;
			uint64_t noise = stilb_random_u64(i, k);
			pass.use_count = (uint8_t)(k == 0 && noise % 4 == 0);
			for (uint64_t n = 0; k == 0 && n < 1 + noise / 4 % 3; n++) {
				uint64_t where = stilb_random_u64(i * 8 + k, n);
				size_t begin_at = offsetof(stilb_gpu_pass, kind), area = n % 2 == 0 ? 60 : sizeof pass - begin_at;
				if (n % 3 == 2)
					bytes[offsetof(stilb_gpu_pass, uses) + where % 40] = (uint8_t)(where >> 32) % 8;
				else
					bytes[begin_at + where % area] =
						where >> 40 & 1 ? (uint8_t)(where >> 32) % 8 : (uint8_t)(where >> 32);
			}
			/* A bool has no third value. */
			for (uint32_t b = 0; b < STILB_GPU_MAX_COLORS; b++)
				bytes[offsetof(stilb_gpu_pass, color) + b * sizeof pass.color[0] +
				      offsetof(stilb_gpu_attachment, read_only)] &= 1;
			bytes[offsetof(stilb_gpu_pass, depth) + offsetof(stilb_gpu_attachment, read_only)] &= 1;
			for (uint32_t b = 0; b < STILB_GPU_MAX_USES; b++)
				bytes[offsetof(stilb_gpu_pass, uses) + b * sizeof pass.uses[0] + offsetof(stilb_gpu_use, previous)] &=
					1;
			stilb_gpu_plan_pass(plan, &pass);
		}
		stilb_result result = stilb_gpu_plan_make(plan, NULL);
		assert_true(result == STILB_OK || result == STILB_ERROR_ARGUMENT);
		good_ones += result == STILB_OK;
	}
	print_message("%u of them good\n", good_ones);
	assert_true(good_ones > 500);
	stilb_gpu_plan_destroy(plan);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_scripts),   cmocka_unit_test(test_areas),       cmocka_unit_test(test_areas_that_fit),
		cmocka_unit_test(test_passes),    cmocka_unit_test(test_attachments), cmocka_unit_test(test_uses),
		cmocka_unit_test(test_resources), cmocka_unit_test(test_counts),      cmocka_unit_test(test_device),
		test_one_thread(test_noise),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
