#include "render_progress.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define PROGRESS_BAR_NS 100000000u    /* between two updates of the bar */
#define PROGRESS_LINE_NS 10000000000u /* between two plain lines */
#define PROGRESS_BAR_MAX 40
#define PROGRESS_BAR_MIN 8

void offline_progress_begin(offline_progress *progress)
{
	const char *kind = getenv("TERM");
	bool simple = kind && strcmp(kind, "dumb") == 0;
	*progress = (offline_progress){.terminal = isatty(STDERR_FILENO) && !simple, .last_ns = stilb_time_ns()};
}

void offline_progress_clear(void)
{
	if (isatty(STDERR_FILENO))
		fputs("\r\033[K", stderr);
}

/* Writes a time as "1:02:03" or "4:05"; at most 10,000 hours. */
static void progress_time(double seconds, char *text, size_t size)
{
	uint64_t all = seconds < 3.6e7 ? (uint64_t)(seconds + 0.5) : 36000000u;
	if (all >= 3600)
		snprintf(text, size, "%" PRIu64 ":%02" PRIu64 ":%02" PRIu64, all / 3600, all / 60 % 60, all % 60);
	else
		snprintf(text, size, "%" PRIu64 ":%02" PRIu64, all / 60, all % 60);
}

static void progress_note_start(offline_progress *progress, offline_stage stage, const stilb_gi_progress *at)
{
	if (stage != RENDER_RENDERING || progress->first_ns != 0)
		return;
	progress->first_ns = stilb_time_ns();
	progress->first_done = at->done;
}

/* Estimated seconds to the end, at the rate so far; negative if it is too early to tell. */
static double progress_left(const offline_progress *progress, const stilb_gi_progress *at)
{
	double passed = (double)(stilb_time_ns() - progress->first_ns) * 1e-9;
	double done = at->done - progress->first_done;
	return passed > 0.3 && done > 0.0 ? passed * (1.0 - at->done) / done : -1.0;
}

/* The number of samples in a pixel that has any, after the last complete pass; coarse passes leave pixels out. */
static uint32_t progress_pass_samples(const stilb_gi_progress *at)
{
	uint32_t samples = 0;
	for (uint32_t i = 0; i < at->pass_count; i++)
		if (at->passes[i].finished)
			samples = at->passes[i].first_sample + at->passes[i].sample_count;
	return samples;
}

void offline_progress_samples(const stilb_gi_progress *at, char *text, size_t size)
{
	STILB_ASSERT(size >= 64);
	uint32_t samples = at->samples > 0 ? at->samples : progress_pass_samples(at);
	const char *many = samples == 1 ? "" : "s";
	const stilb_gi_pass *last = at->pass_count > 0 ? &at->passes[at->pass_count - 1] : NULL;
	uint32_t more = last && !last->finished && last->block == 1 ? last->first_sample + last->sample_count : 0;
	int share = (int)(at->pass_done * 100.0);
	if (at->samples > 0 && more > at->samples && share > 0)
		snprintf(text, size, "%" PRIu32 " sample%s a pixel, %" PRIu32 " in %d %% of them", samples, many, more, share);
	else if (at->samples > 0)
		snprintf(text, size, "%" PRIu32 " sample%s a pixel", samples, many);
	else if (at->block > 0)
		snprintf(text, size, "%" PRIu32 " sample%s in 1 of %" PRIu32 " pixels", samples, many, at->block * at->block);
	else if (more > 0 && share > 0)
		snprintf(text, size, "%" PRIu32 " sample%s in %d %% of the pixels", more, more == 1 ? "" : "s", share);
	else
		snprintf(text, size, "the first pixels");
}

/* Writes the state without the percentage: "pass 9, 64 samples a pixel, 5.31 Mrays/s, 0:12 left". */
static void progress_describe(const offline_progress *progress, offline_stage stage, const stilb_gi_progress *at,
                              char *text, size_t size)
{
	static const char *const stages[] = {[RENDER_OPENING] = "opening the scene",
	                                     [RENDER_BUILDING] = "preparing the scene",
	                                     [RENDER_WRITING] = "writing the picture",
	                                     [RENDER_DONE] = "done"};
	if (stage != RENDER_RENDERING) {
		snprintf(text, size, "%s", stages[stage]);
		return;
	}
	char left[32] = "?";
	double seconds = progress_left(progress, at);
	if (seconds >= 0.0)
		progress_time(seconds, left, sizeof left);
	double rate = at->seconds > 0.0 ? (double)at->rays / at->seconds * 1e-6 : 0.0;
	char samples[64];
	offline_progress_samples(at, samples, sizeof samples);
	snprintf(text, size, "%s, %s, %.2f Mrays/s, %s left", at->stage, samples, rate, left);
}

static int progress_percent(offline_stage stage, const stilb_gi_progress *at)
{
	return stage < RENDER_WRITING ? (int)(at->done * 100.0) : 100;
}

void offline_progress_words(const offline_progress *progress, offline_stage stage, const stilb_gi_progress *at,
                            char *text, size_t size)
{
	STILB_ASSERT(size >= 160);
	char words[160];
	progress_describe(progress, stage, at, words, sizeof words);
	snprintf(text, size, "%d %%, %s", progress_percent(stage, at), words);
}

static int progress_columns(void)
{
	struct winsize size;
	return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/* Draws "[####....] words" over the terminal's line; in a narrow terminal the words alone. */
static void progress_bar(int percent, const char *words)
{
	STILB_ASSERT(percent >= 0 && percent <= 100);
	char bar[PROGRESS_BAR_MAX + 1];
	int columns = progress_columns(), room = columns - (int)strlen(words) - 4;
	int length = room > PROGRESS_BAR_MAX ? PROGRESS_BAR_MAX : room;
	if (length < PROGRESS_BAR_MIN) {
		fprintf(stderr, "\r%.*s\033[K", columns > 1 ? columns - 1 : 0, words);
		return;
	}
	int full = percent * length / 100;
	memset(bar, '#', (size_t)full);
	memset(bar + full, '.', (size_t)(length - full));
	bar[length] = '\0';
	fprintf(stderr, "\r[%s] %s\033[K", bar, words);
}

void offline_progress_show(offline_progress *progress, offline_stage stage, const stilb_gi_progress *at)
{
	char words[192];
	uint64_t now = stilb_time_ns();
	progress_note_start(progress, stage, at);
	if (now - progress->last_ns < (progress->terminal ? PROGRESS_BAR_NS : PROGRESS_LINE_NS))
		return;
	progress->last_ns = now;
	offline_progress_words(progress, stage, at, words, sizeof words);
	if (progress->terminal)
		progress_bar(progress_percent(stage, at), words);
	else
		fprintf(stderr, "%s\n", words);
	fflush(stderr);
}
