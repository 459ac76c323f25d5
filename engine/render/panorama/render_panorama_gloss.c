/* What highlights mirror of a panorama: a cube of its cells without the lamps, and the table beside it. */
#include "numeric/numeric_dfg.h"
#include "render/panorama/render_panorama_work.h"

#include <math.h>
#include <stdlib.h>

/* Stages: the cells, those of the cube, the table. */
#define GLOSS_CUBE 1u
#define GLOSS_TABLE (GLOSS_CUBE + STILB_NUMERIC_PREFILTER_STAGES)
#define GLOSS_SLOW 24u
#define SLOW_COST 1100000.0
static_assert(GLOSS_TABLE + 1 == PANORAMA_GLOSS_STAGES, "see render_panorama_work.h");

static const stilb_numeric_prefilter_settings gloss_settings = {
	.face = RENDER_PANORAMA_FACE, .mips = RENDER_PANORAMA_MIPS, .halves = true};

bool render_panorama_gloss_begin(render_panorama_work *work)
{
	stilb_image cells = {PANORAMA_ACROSS, PANORAMA_DOWN, 3, STILB_IMAGE_F32_LINEAR, work->cells, 0};
	stilb_numeric_prefilter_source source = {.panorama = &cells};
	size_t bytes = RENDER_PANORAMA_CUBE * sizeof *work->cube;
	STILB_ASSERT(stilb_numeric_prefilter_offset(&gloss_settings, RENDER_PANORAMA_MIPS, 0) == bytes);
	work->cube = stilb_memory_alloc(1, bytes);
	return work->cube && stilb_numeric_prefilter_create(&source, &gloss_settings, work->cube, &work->gloss) == STILB_OK;
}

uint32_t render_panorama_gloss_rows(const render_panorama_work *work, uint32_t stage, double *cost)
{
	/* Of a row, as measured, some 2 ns each. The first rows of the cube's last stage make its first mip. */
	static const double costs[PANORAMA_GLOSS_STAGES] = {800.0,   350000.0, 160000.0, 28000.0,
	                                                    20000.0, 3000.0,   7500.0,   530000.0};
	bool slow = stage == GLOSS_TABLE - 1 && work->row < GLOSS_SLOW;
	*cost = slow ? SLOW_COST : costs[stage];
	if (work->kept)
		return 0;
	if (stage == 0)
		return PANORAMA_DOWN;
	if (stage < GLOSS_TABLE)
		return stilb_numeric_prefilter_rows(work->gloss, stage - GLOSS_CUBE);
	return work->dfg_shown ? 0 : RENDER_PANORAMA_DFG;
}

/* Radiance in the place of light. */
static void gloss_cells(render_panorama_work *work, uint32_t begin, uint32_t end)
{
	for (uint32_t row = begin; row < end; row++) {
		double top = cos(M_PI * row / PANORAMA_DOWN), bottom = cos(M_PI * (row + 1.0) / PANORAMA_DOWN);
		float scale = (float)(PANORAMA_ACROSS / (2.0 * M_PI * (top - bottom)));
		for (uint32_t i = 0; i < PANORAMA_ACROSS * 3; i++)
			work->cells[row][i / 3][i % 3] *= scale;
	}
}

static void gloss_table(render_panorama_work *work, uint32_t begin, uint32_t end)
{
	float values[RENDER_PANORAMA_DFG * RENDER_PANORAMA_DFG * 2];
	stilb_numeric_dfg_rows(values, RENDER_PANORAMA_DFG, begin, end);
	for (uint32_t row = begin; row < end; row++)
		for (uint32_t i = 0; i < RENDER_PANORAMA_DFG * 2; i++)
			work->dfg[row][i / 2][i % 2] = stilb_image_half_from_float(values[row * RENDER_PANORAMA_DFG * 2 + i]);
}

void render_panorama_gloss_run(render_panorama_work *work, uint32_t stage, uint32_t begin, uint32_t end)
{
	if (stage == 0)
		gloss_cells(work, begin, end);
	else if (stage < GLOSS_TABLE)
		stilb_numeric_prefilter_run(work->gloss, stage - GLOSS_CUBE, begin, end);
	else
		gloss_table(work, begin, end);
}

void render_panorama_gloss_end(render_panorama_work *work)
{
	stilb_numeric_prefilter_destroy(work->gloss);
	free(work->cube);
	work->gloss = NULL;
	work->cube = NULL;
}
