/* Bloom on jobs: the levels of post_bloom.c. */
#include "post/cpu/post_cpu_internal.h"

#include "profiler/prof.h"

#include <math.h>

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static inline uint32_t cpu_clamp(int64_t i, uint32_t count)
{
	return i < 0 ? 0 : i >= count ? count - 1 : (uint32_t)i;
}

/* A row of half the size from four, which weigh 1, 3, 3, 1 eighths, as four columns do. */
static void cpu_halve_row(const post_texel *const rows[4], uint32_t width, post_texel *to, uint32_t to_width)
{
	uint32_t at = 0;
#define COLUMN(x)                                                                                                      \
	(at = cpu_clamp((int64_t)(x), width), 0.125f * (rows[0][at] + rows[3][at]) + 0.375f * (rows[1][at] + rows[2][at]))
	post_texel first = COLUMN(-1), second = COLUMN(0);
	for (uint32_t x = 0; x < to_width; x++) {
		post_texel third = COLUMN(2 * x + 1), fourth = COLUMN(2 * x + 2);
		to[x] = 0.125f * (first + fourth) + 0.375f * (second + third);
		first = third;
		second = fourth;
	}
#undef COLUMN
}

/* Each texel of a row in twice the size: three quarters of the nearest one and a quarter of the one beside it, each
 * way. share: of that, the rest is of what `to` holds. near, far: the rows of `from` above and below. */
static void cpu_double_row(const post_texel *near, const post_texel *far, uint32_t width, post_texel share,
                           post_texel *to, uint32_t to_width)
{
	post_texel rest = 1.0f - share;
	post_texel before = 0.75f * near[0] + 0.25f * far[0], here = before;
	for (uint32_t x = 0; 2 * x < to_width; x++) {
		uint32_t next = x + 1 < width ? x + 1 : x;
		post_texel behind = 0.75f * near[next] + 0.25f * far[next];
		post_texel *two = to + (size_t)2 * x;
		two[0] = rest * two[0] + share * (0.75f * here + 0.25f * before);
		if (2 * x + 1 < to_width)
			two[1] = rest * two[1] + share * (0.75f * here + 0.25f * behind);
		before = here;
		here = behind;
	}
}

/* Light that is no number or infinite scatters nothing, nor does what is below 0. */
static void cpu_clean_row(post_texel *row, uint32_t width)
{
	for (uint32_t x = 0; x < width; x++) {
		post_texel t = row[x];
		bool finite = isfinite(t[0]) && isfinite(t[1]) && isfinite(t[2]);
		for (uint32_t c = 0; c < 3; c++)
			row[x][c] = finite && t[c] > 0.0f ? t[c] : 0.0f;
		row[x][3] = 0.0f;
	}
}

/* ---- loops over rows --------------------------------------------------------------------------------------------- */

typedef struct cpu_step {
	post_cpu *cpu;
	uint32_t level;   /* that is written */
	post_texel share; /* of what is written; of alpha nothing */
} cpu_step;

/* Level 0 from the light. */
static void cpu_halve_light(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const cpu_step *step = context;
	const post_cpu *cpu = step->cpu;
	const cpu_picture *to = &cpu->halved[0];
	post_texel *scratch = cpu->scratch + (size_t)4 * cpu->width * worker;
	int64_t filled = 2 * (int64_t)begin - 2; /* the last row of the light that is among the four */
	for (uint32_t y = begin; y < end; y++) {
		const post_texel *rows[4];
		for (; filled < 2 * (int64_t)y + 2; filled++) {
			uint32_t from = cpu_clamp(filled + 1, cpu->height);
			post_texel *row = scratch + (size_t)((filled + 1) & 3) * cpu->width;
			cpu->rows->widen(cpu->light + (size_t)4 * from * cpu->width, cpu->width, row);
			cpu_clean_row(row, cpu->width);
		}
		for (uint32_t i = 0; i < 4; i++)
			rows[i] = scratch + (size_t)((2 * (int64_t)y - 1 + i) & 3) * cpu->width;
		cpu_halve_row(rows, cpu->width, to->texels + (size_t)y * to->width, to->width);
	}
}

static void cpu_halve_level(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const cpu_step *step = context;
	const cpu_picture *to = &step->cpu->halved[step->level], *from = to - 1;
	(void)worker;
	for (uint32_t y = begin; y < end; y++) {
		const post_texel *rows[4];
		for (uint32_t i = 0; i < 4; i++)
			rows[i] = from->texels + (size_t)cpu_clamp(2 * (int64_t)y - 1 + i, from->height) * from->width;
		cpu_halve_row(rows, from->width, to->texels + (size_t)y * to->width, to->width);
	}
}

/* The two rows of `from` that a row of twice the size lies between. */
static void cpu_double(const cpu_picture *from, uint32_t y, post_texel share, post_texel *to, uint32_t to_width)
{
	uint32_t near = y / 2, far = cpu_clamp((int64_t)near + (y % 2 ? 1 : -1), from->height);
	cpu_double_row(from->texels + (size_t)near * from->width, from->texels + (size_t)far * from->width, from->width,
	               share, to, to_width);
}

static void cpu_sum_level(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const cpu_step *step = context;
	const cpu_picture *to = &step->cpu->halved[step->level], *wider = to + 1;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		cpu_double(wider, y, step->share, to->texels + (size_t)y * to->width, to->width);
}

static void cpu_add_light(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const cpu_step *step = context;
	const post_cpu *cpu = step->cpu;
	post_texel *row = cpu->scratch + (size_t)4 * cpu->width * worker;
	for (uint32_t y = begin; y < end; y++) {
		uint16_t *light = cpu->light + (size_t)4 * y * cpu->width;
		cpu->rows->widen(light, cpu->width, row);
		cpu_double(&cpu->halved[0], y, step->share, row, cpu->width);
		cpu->rows->narrow(row, cpu->width, light);
	}
}

static post_texel cpu_share(float share)
{
	return (post_texel){share, share, share, 0.0f};
}

void post_cpu_bloom(post_cpu *cpu, const stilb_post_settings *settings, uint16_t *texels)
{
	PROFILE("bloom on the CPU");
	const post_levels *levels = &cpu->levels;
	STILB_ASSERT(settings->bloom > 0.0f && texels && levels->count > 0 && "after post_cpu_fit");
	cpu->light = texels;
	cpu_step step = {.cpu = cpu};
	for (uint32_t l = 0; l < levels->count; l++) {
		step.level = l;
		post_cpu_loop(cpu, l == 0 ? cpu_halve_light : cpu_halve_level, levels->sizes[l][0], levels->sizes[l][1], &step);
	}
	for (uint32_t l = levels->count - 1; l-- > 0;) {
		step.level = l;
		step.share = cpu_share(l < levels->first ? 1.0f : settings->bloom_width);
		post_cpu_loop(cpu, cpu_sum_level, levels->sizes[l][0], levels->sizes[l][1], &step);
	}
	step.share = cpu_share(settings->bloom);
	post_cpu_loop(cpu, cpu_add_light, cpu->width, cpu->height, &step);
}
