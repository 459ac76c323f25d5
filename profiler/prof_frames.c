/* The lengths of the last frames, and which of them are spikes: longer than a limit (prof_frames.h). */
#include "profiler/prof_frames.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define PROF_WINDOW_ENOUGH 20 /* with fewer the median says little: the start of a program is no spike */

static_assert(PROF_WINDOW_FRAMES == STILB_PROF_STATS_FRAMES, "one window");

static bool prof_window_is_sound(const prof_frame_window *window)
{
	bool sound = window->count <= PROF_WINDOW_FRAMES && window->next < PROF_WINDOW_FRAMES;
	for (uint32_t i = 1; sound && i < window->count; i++)
		sound = window->sorted[i - 1] <= window->sorted[i];
	return sound;
}

/* The index of the first value in sorted that is not less than ns. */
static uint32_t prof_window_find(const prof_frame_window *window, uint64_t ns)
{
	uint32_t at = 0;
	while (at < window->count && window->sorted[at] < ns)
		at++;
	return at;
}

void prof_frame_window_add(prof_frame_window *window, uint64_t ns)
{
	uint64_t *sorted = window->sorted;
	if (window->count == PROF_WINDOW_FRAMES) {
		uint32_t old = prof_window_find(window, window->ns[window->next]);
		assert(sorted[old] == window->ns[window->next] && "the oldest is among the sorted ones");
		window->count--;
		memmove(sorted + old, sorted + old + 1, (window->count - old) * sizeof *sorted);
	}
	uint32_t at = prof_window_find(window, ns);
	memmove(sorted + at + 1, sorted + at, (window->count - at) * sizeof *sorted);
	sorted[at] = ns;
	window->count++;
	window->ns[window->next] = ns;
	window->next = (window->next + 1) % PROF_WINDOW_FRAMES;
	PROF_CHECK(prof_window_is_sound(window));
}

uint64_t prof_frame_window_rank(const prof_frame_window *window, uint32_t percent)
{
	assert(percent >= 1 && percent <= 100);
	return window->count > 0 ? window->sorted[(window->count * percent + 99) / 100 - 1] : 0;
}

double prof_frame_window_limit_ms(const prof_frame_window *window, double budget_ms)
{
	if (window->count < PROF_WINDOW_ENOUGH)
		return (double)INFINITY;
	double twice_ms = 2e-6 * (double)prof_frame_window_rank(window, 50);
	return twice_ms > budget_ms ? twice_ms : budget_ms;
}

void stilb_prof_frame_stats_make(stilb_prof_frame_stats *stats, const stilb_prof_frame *frames, uint32_t count,
                                 double budget_ms)
{
	assert(stats && (frames || count == 0) && budget_ms >= 0);
	prof_frame_window window = {0};
	*stats = (stilb_prof_frame_stats){.limit_ms = (double)INFINITY};
	count = count < PROF_WINDOW_FRAMES ? count : PROF_WINDOW_FRAMES;
	for (uint32_t i = 0; i < count; i++) {
		assert(frames[i].begin_ns <= frames[i].end_ns && "frames end after they begin");
		uint64_t ns = frames[i].end_ns - frames[i].begin_ns;
		prof_frame_window_add(&window, ns);
		stats->ms[i] = 1e-6 * (double)ns;
		stats->mean_ms += stats->ms[i] / count;
	}
	if (count == 0)
		return;
	stats->count = count;
	stats->last = frames[count - 1].number;
	stats->p50_ms = 1e-6 * (double)prof_frame_window_rank(&window, 50);
	stats->p99_ms = 1e-6 * (double)prof_frame_window_rank(&window, 99);
	stats->max_ms = 1e-6 * (double)prof_frame_window_rank(&window, 100);
	stats->limit_ms = prof_frame_window_limit_ms(&window, budget_ms);
	stats->spike = stats->ms[count - 1] > stats->limit_ms;
}

void stilb_prof_frame_stats_take(stilb_prof_frame_stats *stats, double budget_ms)
{
	uint64_t begin_ns[PROF_WINDOW_FRAMES + 1], first = 0;
	uint32_t marks = prof_frames_last(begin_ns, PROF_WINDOW_FRAMES + 1, &first);
	stilb_prof_frame frames[PROF_WINDOW_FRAMES];
	for (uint32_t i = 1; i < marks; i++)
		frames[i - 1] = (stilb_prof_frame){first + i - 1, begin_ns[i - 1], begin_ns[i]};
	stilb_prof_frame_stats_make(stats, frames, marks > 0 ? marks - 1 : 0, budget_ms);
}
