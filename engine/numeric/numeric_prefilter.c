#include "numeric/numeric_prefilter.h"

#include "numeric/numeric_prefilter_internal.h"
#include "shading/shade_specular.h"

#include <stdlib.h>

/* ---- the cube in memory ------------------------------------------------------------------------------------------ */

static bool settings_are_valid(const stilb_numeric_prefilter_settings *s)
{
	bool is_side = s->face >= STILB_NUMERIC_PREFILTER_FACE_MIN && s->face <= STILB_NUMERIC_PREFILTER_FACE_MAX &&
	               (s->face & (s->face - 1)) == 0;
	return is_side && s->mips >= 2 && s->mips <= PREFILTER_MIPS_MAX && s->face >> (s->mips - 1) >= 1 &&
	       s->firefly_range >= 0.0f;
}

size_t stilb_numeric_prefilter_offset(const stilb_numeric_prefilter_settings *settings, uint32_t mip, uint32_t face)
{
	STILB_ASSERT(settings_are_valid(settings) && mip <= settings->mips && face < 6);
	STILB_ASSERT(mip < settings->mips || face == 0);
	size_t texels = 0;
	for (uint32_t m = 0; m < mip; m++)
		texels += (size_t)6 * (settings->face >> m) * (settings->face >> m);
	texels += face * (size_t)(settings->face >> mip) * (settings->face >> mip);
	return texels * 4 * (settings->halves ? sizeof(uint16_t) : sizeof(float));
}

/* ---- create ------------------------------------------------------------------------------------------------------ */

/* Degree of the harmonics for a lobe of this width, over alpha; and the least, for the wide lobes, which end at the
 * horizon by a kink. */
#define DEGREE_OVER_ALPHA 6.0f
#define DEGREE_MIN 48u
/* Rings, and points on them, over the degree: the source is spread by cubics, mips are interpolated by them. */
#define RINGS_IN 4u
#define RINGS_OUT 3u
#define UNWRAP_OVER_FACE 4u /* rows of an unwrapped cube */
#define UNWRAP_MAX 4096u

static float roughness_of(const stilb_numeric_prefilter_settings *settings, uint32_t mip)
{
	return (float)mip / (float)(settings->mips - 1);
}

static uint32_t degree_of(const stilb_numeric_prefilter_settings *settings, uint32_t mip)
{
	float degree = ceilf(DEGREE_OVER_ALPHA / shade_alpha_from_roughness(roughness_of(settings, mip)));
	STILB_ASSERT(degree < (float)PREFILTER_DEGREE_MAX);
	return degree > (float)DEGREE_MIN ? (uint32_t)degree : DEGREE_MIN;
}

static prefilter_grid grid_of(uint32_t degree, uint32_t over)
{
	prefilter_grid grid = {.degree = degree, .columns = 2};
	grid.pairs = (degree * over / 2 + PREFILTER_BLOCK - 1) / PREFILTER_BLOCK * PREFILTER_BLOCK;
	while (grid.columns < degree * over)
		grid.columns *= 2;
	return grid;
}

static bool source_is_valid(const stilb_numeric_prefilter_source *source, stilb_result *result)
{
	const stilb_image *images = source->faces ? source->faces : source->panorama;
	*result = STILB_ERROR_ARGUMENT;
	for (uint32_t i = 0; i < (source->faces ? 6u : 1u); i++) {
		STILB_ASSERT(images[i].pixels && images[i].channels >= 1 && images[i].channels <= 4);
		if (images[i].format != STILB_IMAGE_F32_LINEAR && images[i].format != STILB_IMAGE_F16_LINEAR)
			stilb_fail_line("a prefiltered cube needs linear floats, which its source lacks; give it as .exr");
		else if (source->faces && (images[i].width != images[i].height || images[i].width != images[0].width))
			stilb_fail_line("face %u of a cube is %u x %u texels; give six squares of %u", i, images[i].width,
			                images[i].height, images[0].width);
		else
			continue;
		return false;
	}
	*result = STILB_OK;
	return true;
}

/* The plan, without memory. */
static stilb_numeric_prefilter plan_of(const stilb_numeric_prefilter_source *source,
                                       const stilb_numeric_prefilter_settings *settings, void *cube)
{
	stilb_numeric_prefilter plan = {.settings = *settings, .is_cube = !source->panorama};
	for (uint32_t i = 0; i < (plan.is_cube ? 6u : 1u); i++)
		plan.source[i] = plan.is_cube ? source->faces[i] : *source->panorama;
	plan.in = grid_of(degree_of(settings, 1), RINGS_IN);
	plan.turn_columns = plan.in.columns;
	for (uint32_t mip = 0; mip < settings->mips; mip++)
		plan.mips[mip] = (char *)cube + stilb_numeric_prefilter_offset(settings, mip, 0);
	for (uint32_t mip = 1; mip < settings->mips; mip++)
		plan.out[mip] = grid_of(degree_of(settings, mip), RINGS_OUT);
	if (!plan.is_cube)
		plan.parts_across = numeric_prefilter_parts(plan.source[0].width, settings->face, true);
	if (plan.is_cube) {
		uint32_t rows = plan.source[0].width * UNWRAP_OVER_FACE;
		rows = rows < 2 * plan.in.pairs ? 2 * plan.in.pairs : rows > UNWRAP_MAX ? UNWRAP_MAX : rows;
		plan.unwrapped = (stilb_image){2 * rows, rows, 4, STILB_IMAGE_F32_LINEAR, NULL, 0};
	}
	return plan;
}

static size_t waves_of(const prefilter_grid *grid)
{
	return (size_t)grid->pairs * grid->columns;
}

/* Gives the plan its memory, one block. False: there is none. */
static bool plan_allocate(stilb_numeric_prefilter *work)
{
	size_t harmonics = prefilter_order_begin(work->in.degree, work->in.degree + 1);
	size_t waves = harmonics + waves_of(&work->in), shares = 0;
	size_t unwrapped = (size_t)work->unwrapped.width * work->unwrapped.height;
	for (uint32_t mip = 1; mip < work->settings.mips; mip++) {
		waves += waves_of(&work->out[mip]);
		shares += work->out[mip].degree + 1;
	}
	size_t bytes = waves * sizeof(prefilter_wave) + unwrapped * sizeof(stilb_vec4) +
	               (work->turn_columns / 2 + work->parts_across) * sizeof(prefilter_turn) + shares * sizeof(float);
	char *memory = stilb_memory_alloc(1, bytes);
	if (!memory)
		return false;
	prefilter_wave *next = (prefilter_wave *)(void *)memory;
	work->harmonics = next;
	work->in.waves = next + harmonics;
	next = work->in.waves + waves_of(&work->in);
	for (uint32_t mip = 1; mip < work->settings.mips; mip++) {
		work->out[mip].waves = next;
		next += waves_of(&work->out[mip]);
	}
	work->unwrapped.pixels = next;
	work->turns = (prefilter_turn *)(void *)((stilb_vec4 *)(void *)next + unwrapped);
	work->columns = work->turns + work->turn_columns / 2;
	float *share = (float *)(void *)(work->columns + work->parts_across);
	for (uint32_t mip = 1; mip < work->settings.mips; mip++) {
		work->share[mip] = share;
		share += work->out[mip].degree + 1;
	}
	return true;
}

stilb_result stilb_numeric_prefilter_create(const stilb_numeric_prefilter_source *source,
                                            const stilb_numeric_prefilter_settings *settings, void *cube,
                                            stilb_numeric_prefilter **work)
{
	STILB_ASSERT(source && settings && cube && work);
	STILB_ASSERT(settings_are_valid(settings) && !source->panorama != !source->faces);
	STILB_ASSERT((uintptr_t)cube % sizeof(stilb_vec4) == 0);
	*work = NULL;
	stilb_result result;
	if (!source_is_valid(source, &result))
		return result;
	stilb_numeric_prefilter *made = stilb_memory_alloc(1, sizeof *made);
	if (made) {
		*made = plan_of(source, settings, cube);
		if (plan_allocate(made)) {
			numeric_prefilter_make_turns(made);
			numeric_prefilter_make_columns(made);
			*work = made;
			return STILB_OK;
		}
	}
	free(made);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for a prefiltered cube of %u x %u texels", settings->face,
	                  settings->face);
}

void stilb_numeric_prefilter_destroy(stilb_numeric_prefilter *work)
{
	if (!work)
		return;
	free(work->harmonics);
	free(work);
}

/* ---- stages ------------------------------------------------------------------------------------------------------ */

enum { STAGE_PREPARE, STAGE_GATHER, STAGE_ANALYSE, STAGE_SYNTHESISE, STAGE_TRANSFORM, STAGE_WRITE };

/* Rows of one mip in a stage that has rows of each; those of STAGE_PREPARE are followed by the unwrapped cube's. */
static uint32_t mip_rows(const stilb_numeric_prefilter *work, uint32_t stage, uint32_t mip)
{
	if (stage == STAGE_WRITE)
		return 6 * (work->settings.face >> mip) / (mip == 0 ? numeric_prefilter_band_rows(work->settings.face) : 1);
	if (mip == 0)
		return 0;
	if (stage == STAGE_PREPARE)
		return 1;
	return stage == STAGE_SYNTHESISE ? work->out[mip].degree + 1 : work->out[mip].pairs;
}

uint32_t stilb_numeric_prefilter_rows(const stilb_numeric_prefilter *work, uint32_t stage)
{
	STILB_ASSERT(work && stage < STILB_NUMERIC_PREFILTER_STAGES);
	if (stage == STAGE_GATHER)
		return work->in.pairs / PREFILTER_BLOCK;
	if (stage == STAGE_ANALYSE)
		return work->in.degree + 1;
	uint32_t rows = stage == STAGE_PREPARE ? work->unwrapped.height : 0;
	for (uint32_t mip = 0; mip < work->settings.mips; mip++)
		rows += mip_rows(work, stage, mip);
	return rows;
}

static void run_mip_row(stilb_numeric_prefilter *work, uint32_t stage, uint32_t mip, uint32_t row)
{
	if (stage == STAGE_PREPARE)
		numeric_prefilter_make_share(roughness_of(&work->settings, mip), work->out[mip].degree, work->share[mip]);
	else if (stage == STAGE_SYNTHESISE)
		numeric_prefilter_synthesise(work, mip, row);
	else if (stage == STAGE_TRANSFORM)
		numeric_prefilter_finish_pair(work, mip, row);
	else if (mip == 0)
		numeric_prefilter_write_band(work, row);
	else
		numeric_prefilter_write_row(work, mip, row);
}

static void run_row(stilb_numeric_prefilter *work, uint32_t stage, uint32_t row)
{
	if (stage == STAGE_GATHER || stage == STAGE_ANALYSE) {
		if (stage == STAGE_GATHER)
			numeric_prefilter_gather(work, row * PREFILTER_BLOCK);
		else
			numeric_prefilter_analyse(work, row);
		return;
	}
	uint32_t mip = 0;
	for (; mip < work->settings.mips && row >= mip_rows(work, stage, mip); mip++)
		row -= mip_rows(work, stage, mip);
	if (mip < work->settings.mips)
		run_mip_row(work, stage, mip, row);
	else
		numeric_prefilter_unwrap_row(work, row);
}

void stilb_numeric_prefilter_run(stilb_numeric_prefilter *work, uint32_t stage, uint32_t begin, uint32_t end)
{
	STILB_ASSERT(begin <= end && end <= stilb_numeric_prefilter_rows(work, stage));
	for (uint32_t row = begin; row < end; row++)
		run_row(work, stage, row);
}
