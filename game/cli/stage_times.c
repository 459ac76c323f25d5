#include "stage_times.h"

#include <stdlib.h>
#include <string.h>

const char *const stage_names[STAGE_COUNT] = {"frame", "cull", "record", "ui", "replay", "present", "gpu", "pad"};

static bool stage_times_grow(stage_times *times)
{
	uint32_t capacity = times->capacity ? times->capacity * 2 : 1024;
	capacity = capacity < STAGE_TIMES_MAX ? capacity : STAGE_TIMES_MAX;
	void *grown = realloc(times->frames, capacity * sizeof *times->frames);
	if (!grown)
		return false;
	times->frames = grown;
	times->capacity = capacity;
	return true;
}

bool stage_times_add(stage_times *times, const stilb_engine_times *frame)
{
	STILB_ASSERT(times->capacity <= STAGE_TIMES_MAX && (!times->frames == !times->capacity));
	if (times->count == times->capacity && times->capacity < STAGE_TIMES_MAX && !stage_times_grow(times))
		return false;
	float *out = times->frames[times->count % times->capacity];
	out[STAGE_FRAME] = (float)frame->frame;
	out[STAGE_CULL] = (float)frame->cull;
	out[STAGE_RECORD] = (float)frame->record;
	out[STAGE_UI] = (float)frame->ui;
	out[STAGE_REPLAY] = (float)frame->replay;
	out[STAGE_PRESENT] = (float)frame->present;
	out[STAGE_GPU] = (float)frame->gpu;
	out[STAGE_PAD] = (float)frame->pad;
	times->count++;
	return true;
}

void stage_times_last_gpu(stage_times *times, double ms)
{
	if (times->count > 0)
		times->frames[(times->count - 1) % times->capacity][STAGE_GPU] = (float)ms;
}

static int compare_floats(const void *a, const void *b)
{
	float x = *(const float *)a, y = *(const float *)b;
	return (x > y) - (x < y);
}

/* Returns the quantile `share`, 0..1 (0.5: the median), of `count` > 0 ascending values by nearest rank: always one of
 * the values, never a mean of two. */
static double quantile(const float *sorted, uint64_t count, double share)
{
	STILB_ASSERT(count > 0 && share >= 0.0 && share <= 1.0);
	uint64_t rank = (uint64_t)(share * (double)(count - 1) + 0.5);
	return (double)sorted[rank];
}

bool stage_times_summarise(const stage_times *times, stage_summary summary[STAGE_COUNT], uint64_t *warmup)
{
	uint64_t kept = times->count < times->capacity ? times->count : times->capacity;
	uint64_t overwritten = times->count - kept; /* the first ones of the run, so they count as warm-up */
	*warmup = times->count / 10;
	uint64_t skip = *warmup > overwritten ? *warmup - overwritten : 0, count = kept - skip;
	memset(summary, 0, STAGE_COUNT * sizeof *summary);
	float *values = malloc((count ? count : 1) * sizeof *values);
	if (!values)
		return false;
	for (int s = 0; s < STAGE_COUNT; s++) {
		uint64_t known = 0;
		for (uint64_t i = 0; i < count; i++) {
			float ms = times->frames[(times->count - count + i) % times->capacity][s];
			if (s < STAGE_GPU || ms > 0.0f)
				values[known++] = ms;
		}
		qsort(values, known, sizeof *values, compare_floats);
		if (known > 0)
			summary[s] =
				(stage_summary){quantile(values, known, 0.5), quantile(values, known, 0.99), (double)values[0]};
	}
	free(values);
	return true;
}

void stage_times_finish(stage_times *times)
{
	free(times->frames);
	*times = (stage_times){0};
}
