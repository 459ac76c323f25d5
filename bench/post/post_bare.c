/* Bare programs in the place of an effect: the rows of a frame that has it are taken down, and repeated without it. */
#include "bench/post/post_bare.h"

#include "bench/harness/bench_child.h"

#include <stdlib.h>
#include <string.h>

static const uint32_t bare_1_frag[] =
#include "bare_1.frag.inc"
	;
static const uint32_t bare_2_frag[] =
#include "bare_2.frag.inc"
	;
static const uint32_t bare_3_frag[] =
#include "bare_3.frag.inc"
	;
static const uint32_t bare_4_frag[] =
#include "bare_4.frag.inc"
	;
static const uint32_t bare_temporal_frag[] =
#include "bare_temporal.frag.inc"
	;

#define BARE_ROWS 48u
#define BARE_READS 7u
#define BARE_COLORS 3u

/* What a row reads: colour `color` of row `row`, or, with row BARE_ROWS, the frame's image of that name. */
typedef struct bare_read {
	uint32_t row, color;
	char name[STILB_GPU_MAX_NAME + 1];
	bool previous;
} bare_read;

typedef struct bare_row {
	stilb_gpu_extent colors[BARE_COLORS];
	uint16_t from[BARE_COLORS]; /* resources of the plan that was taken down */
	bool keep;                  /* a frame reads them that comes later */
	bare_read reads[BARE_READS];
	uint32_t color_count, read_count;
} bare_row;

struct post_bare {
	bare_row rows[BARE_ROWS];
	uint32_t count;
	bool on;
	stilb_gpu_program programs[5]; /* of so many images - 1; the last one: of temporal antialiasing */
};

/* ---- taking down ------------------------------------------------------------------------------------------------- */

static bool bare_is_new(const stilb_gpu_pass *pass, const char (*without)[64], uint32_t count)
{
	for (uint32_t n = 0; n < count; n++)
		if (strncmp(pass->name, without[n], sizeof *without - 1) == 0)
			return false;
	return pass->kind == STILB_GPU_PASS_FULLSCREEN;
}

/* The row and the colour that draw a resource. False: none of these does. */
static bool bare_source(const post_bare *bare, uint16_t resource, bare_read *read)
{
	for (uint32_t r = 0; r < bare->count; r++)
		for (uint32_t c = 0; c < bare->rows[r].color_count; c++)
			if (bare->rows[r].from[c] == resource) {
				read->row = r;
				read->color = c;
				return true;
			}
	return false;
}

static void bare_take_writes(post_bare *bare, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	bool reads = (pass->use_count >= 1 && pass->use_count <= 4) || pass->use_count == BARE_READS;
	if (bare->count == BARE_ROWS || pass->color_count > BARE_COLORS || !reads)
		bench_child_fail("row '%s' has no bare one: make room in post_bare.c", pass->name);
	bare_row *row = &bare->rows[bare->count++];
	row->color_count = pass->color_count;
	row->read_count = pass->use_count;
	for (uint32_t c = 0; c < pass->color_count; c++) {
		row->from[c] = pass->color[c].image;
		row->colors[c] = *stilb_gpu_plan_extent(plan, pass->color[c].image);
	}
}

static void bare_take_reads(post_bare *bare, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass, bare_row *row)
{
	for (uint32_t u = 0; u < pass->use_count; u++) {
		bare_read *read = &row->reads[u];
		const stilb_gpu_use *use = &pass->uses[u];
		read->previous = use->previous;
		if (bare_source(bare, use->resource, read)) {
			bare->rows[read->row].keep |= use->previous;
			continue;
		}
		read->row = BARE_ROWS;
		strcpy(read->name, stilb_gpu_plan_name(plan, use->resource));
	}
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static stilb_result bare_add(void *user, stilb_gpu_plan *plan, uint16_t *light)
{
	const post_bare *bare = user;
	uint16_t images[BARE_ROWS][BARE_COLORS];
	(void)light;
	for (uint32_t r = 0; bare->on && r < bare->count; r++)
		for (uint32_t c = 0; c < bare->rows[r].color_count; c++) {
			const stilb_gpu_extent *extent = &bare->rows[r].colors[c];
			char name[32];
			snprintf(name, sizeof name, "bare %u %u", r, c);
			stilb_gpu_plan_image_row row = {.name = name,
			                                .format = extent->format,
			                                .width = extent->width,
			                                .height = extent->height,
			                                .keep = bare->rows[r].keep,
			                                .output = r + 1 == bare->count};
			images[r][c] = stilb_gpu_plan_image(plan, &row);
		}
	for (uint32_t r = 0; bare->on && r < bare->count; r++) {
		const bare_row *row = &bare->rows[r];
		const int32_t size[2] = {(int32_t)row->colors[0].width, (int32_t)row->colors[0].height};
		stilb_gpu_pass pass = {.name = "bare",
		                       .kind = STILB_GPU_PASS_FULLSCREEN,
		                       .program = bare->programs[row->read_count == BARE_READS ? 4 : row->read_count - 1].id,
		                       .color_count = (uint8_t)row->color_count,
		                       .use_count = (uint8_t)row->read_count,
		                       .constant_bytes = sizeof size};
		memcpy(pass.constants, size, sizeof size);
		for (uint32_t c = 0; c < row->color_count; c++)
			pass.color[c] = (stilb_gpu_attachment){.image = images[r][c], .load = STILB_GPU_LOAD_DISCARD};
		for (uint32_t u = 0; u < row->read_count; u++) {
			const bare_read *read = &row->reads[u];
			uint16_t from =
				read->row < BARE_ROWS ? images[read->row][read->color] : stilb_gpu_plan_find(plan, read->name);
			pass.uses[u] = (stilb_gpu_use){
				.resource = from, .how = STILB_GPU_USE_SAMPLED, .slot = (uint16_t)u, .previous = read->previous};
		}
		stilb_gpu_plan_pass(plan, &pass);
	}
	return STILB_OK;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void bare_programs(post_bare *bare, stilb_gpu *gpu)
{
	static const struct {
		stilb_gpu_shader code;
		uint8_t samplers;
	} kinds[5] = {{{bare_1_frag, sizeof bare_1_frag, NULL}, 1},
	              {{bare_2_frag, sizeof bare_2_frag, NULL}, 2},
	              {{bare_3_frag, sizeof bare_3_frag, NULL}, 3},
	              {{bare_4_frag, sizeof bare_4_frag, NULL}, 4},
	              {{bare_temporal_frag, sizeof bare_temporal_frag, NULL}, 7}};
	for (uint32_t k = 0; k < 5; k++) {
		stilb_gpu_program_desc desc = {.name = "bare", .fragment = kinds[k].code, .samplers = kinds[k].samplers};
		if (stilb_gpu_program_create(gpu, &desc, &bare->programs[k]) != STILB_OK)
			bench_child_fail("%s", stilb_error_message());
	}
}

post_bare *post_bare_learn(stilb_engine *engine, const char (*without)[64], uint32_t count)
{
	const stilb_gpu_plan *plan = stilb_engine_plan(engine);
	post_bare *bare = calloc(1, sizeof *bare);
	if (!bare)
		bench_child_fail("no memory for bare programs");
	for (uint32_t p = 0; p < stilb_gpu_plan_passes(plan); p++)
		if (bare_is_new(stilb_gpu_plan_row(plan, p), without, count))
			bare_take_writes(bare, plan, stilb_gpu_plan_row(plan, p));
	for (uint32_t p = 0, r = 0; p < stilb_gpu_plan_passes(plan); p++)
		if (bare_is_new(stilb_gpu_plan_row(plan, p), without, count))
			bare_take_reads(bare, plan, stilb_gpu_plan_row(plan, p), &bare->rows[r++]);
	bare_programs(bare, stilb_engine_gpu(engine));
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_LIGHT, .add = bare_add, .user = bare};
	if (bare->count == 0 || stilb_engine_add_feature(engine, &feature) != STILB_OK)
		bench_child_fail("an effect without rows");
	return bare;
}

void post_bare_switch(post_bare *bare, bool on)
{
	bare->on = on;
}

void post_bare_destroy(post_bare *bare, stilb_engine *engine)
{
	for (uint32_t k = 0; bare && k < 5; k++)
		stilb_gpu_program_destroy(stilb_engine_gpu(engine), bare->programs[k]);
	free(bare);
}
