/* Exposure that adapts: the device counts pixels by luminance, the CPU finds what shows them well, and goes there. */
#include "post/post_internal.h"

#include <math.h>
#include <string.h>

#define EXPOSURE_LOWEST (-16.0) /* log2 of the luminance that the first class begins with */
#define EXPOSURE_STEPS 16u      /* classes a stop, of equal width in luminance */
#define EXPOSURE_PIXELS 4096u   /* that a work group counts, at least */
#define EXPOSURE_MOST 32.0f     /* stops, either way */

/* ---- settings ---------------------------------------------------------------------------------------------------- */

static bool exposure_is_pace(float value)
{
	return value >= 0.0f && isfinite(value);
}

/* Both 0, or within bounds and in order. */
static bool exposure_is_range(float low, float high, float least, float most)
{
	return (low == 0.0f && high == 0.0f) || (low >= least && low < high && high <= most);
}

bool post_exposure_is_valid(const stilb_post_settings *settings)
{
	return exposure_is_range(settings->exposure_low, settings->exposure_high, 0.0f, 1.0f) &&
	       exposure_is_pace(settings->exposure_speed) && exposure_is_pace(settings->exposure_rate) &&
	       exposure_is_range(settings->exposure_darkest, settings->exposure_brightest, -EXPOSURE_MOST, EXPOSURE_MOST);
}

void post_exposure_defaults(stilb_post_settings *settings)
{
	if (settings->exposure_high == 0.0f) {
		settings->exposure_low = 0.7f;
		settings->exposure_high = 0.97f;
	}
	if (settings->exposure_speed == 0.0f)
		settings->exposure_speed = 2.0f;
	if (settings->exposure_rate == 0.0f)
		settings->exposure_rate = 4.0f;
	if (settings->exposure_darkest == 0.0f && settings->exposure_brightest == 0.0f) {
		settings->exposure_darkest = -16.0f;
		settings->exposure_brightest = 16.0f;
	}
}

/* ---- what the counts mean ---------------------------------------------------------------------------------------- */

/* log2 of the luminance in the middle of a class. */
static double exposure_middle(uint32_t at)
{
	uint32_t stop = at / EXPOSURE_STEPS;
	return EXPOSURE_LOWEST + stop + log2(1.0 + (at % EXPOSURE_STEPS + 0.5) / EXPOSURE_STEPS);
}

bool post_exposure_of(const uint64_t *counts, const stilb_post_settings *settings, float *stops)
{
	uint64_t all = 0;
	for (uint32_t c = 0; c < POST_EXPOSURE_CLASSES; c++)
		all += counts[c];
	double low = (double)settings->exposure_low * (double)all, high = (double)settings->exposure_high * (double)all;
	double below = 0.0, sum = 0.0;
	for (uint32_t c = 0; c < POST_EXPOSURE_CLASSES; c++) {
		double end = below + (double)counts[c];
		sum += fmax(fmin(end, high) - fmax(below, low), 0.0) * exposure_middle(c);
		below = end;
	}
	if (all == 0)
		return false;
	double wanted = log2(POST_EXPOSURE_GREY) - sum / (high - low);
	wanted = fmin(fmax(wanted, (double)settings->exposure_darkest), (double)settings->exposure_brightest);
	*stops = (float)wanted;
	return true;
}

float post_exposure_step(float from, float to, float seconds, const stilb_post_settings *settings)
{
	double speed = (double)settings->exposure_speed, rate = (double)settings->exposure_rate, left = (double)seconds;
	double away = fabs((double)to - (double)from), near = rate / speed; /* within `near` it is slower than the rate */
	if (away > near) {
		double steady = fmin(left, (away - near) / rate);
		away -= rate * steady;
		left -= steady;
	}
	if (away <= near)
		away *= exp(-speed * left);
	return (float)((double)to - copysign(away, (double)to - (double)from));
}

/* ---- the device's part ------------------------------------------------------------------------------------------- */

stilb_result post_exposure_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t light)
{
	const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, light);
	uint64_t pixels = (uint64_t)extent->width * extent->height;
	uint64_t groups = (pixels + EXPOSURE_PIXELS - 1) / EXPOSURE_PIXELS;
	post_meter *meter = &post->meter;
	stilb_gpu_program program;
	stilb_result result = post_program_get(post, POST_EXPOSURE, &program);
	if (result != STILB_OK)
		return result;
	meter->groups = groups < POST_EXPOSURE_GROUPS ? (uint32_t)groups : POST_EXPOSURE_GROUPS;
	stilb_gpu_plan_buffer_row row = {.name = POST_EXPOSURE_COUNTS,
	                                 .bytes = (uint64_t)meter->groups * POST_EXPOSURE_CLASSES * sizeof(uint32_t),
	                                 .output = true};
	uint16_t counts = stilb_gpu_plan_buffer(plan, &row);
	stilb_gpu_pass pass = {
		.name = "exposure",
		.kind = STILB_GPU_PASS_DISPATCH,
		.program = program.id,
		.groups = {meter->groups, 1, 1},
		.uses = {{.resource = light, .how = STILB_GPU_USE_SAMPLED},
	             {.resource = counts, .how = STILB_GPU_USE_STORAGE_WRITE}},
		.use_count = 2,
		.constant_bytes = sizeof(uint64_t),
	};
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

/* Asks for the counts of the last replayed frame; 0: it has none. */
static post_counts exposure_ask(const stilb_post *post)
{
	const stilb_gpu_plan *plan = stilb_render_plan(post->render);
	post_counts counts = {.groups = post->meter.groups};
	uint16_t resource = stilb_gpu_plan_find(plan, POST_EXPOSURE_COUNTS);
	if (resource == 0 || stilb_gpu_read_begin(stilb_render_gpu(post->render), plan, resource, 0, 0, &counts.ticket) !=
	                         STILB_OK) /* the frame was not drawn */
		counts.ticket = 0;
	return counts;
}

/* Takes counts that were asked for. *found: they say something, which is then in meter->wanted. */
static stilb_result exposure_take(stilb_post *post, post_counts counts, bool *found)
{
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	const void *bytes = NULL;
	uint64_t frame, sums[POST_EXPOSURE_CLASSES] = {0};
	*found = false;
	if (counts.ticket == 0)
		return STILB_OK;
	stilb_result result = stilb_gpu_read_get(gpu, counts.ticket, true, &bytes, &frame);
	const uint32_t *rows = bytes;
	for (uint32_t i = 0; rows && i < counts.groups * POST_EXPOSURE_CLASSES; i++)
		sums[i % POST_EXPOSURE_CLASSES] += rows[i];
	stilb_gpu_read_end(gpu, counts.ticket);
	*found = result == STILB_OK && post_exposure_of(sums, &post->settings, &post->meter.wanted);
	return result;
}

void post_exposure_finish(stilb_post *post)
{
	if (post->meter.coming.ticket != 0)
		stilb_gpu_read_end(stilb_render_gpu(post->render), post->meter.coming.ticket);
	post->meter = (post_meter){0};
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

stilb_result stilb_post_adapt(stilb_post *post, float seconds)
{
	STILB_ASSERT(post);
	STILB_ASSERT(seconds >= 0.0f);
	STILB_ASSERT(isfinite(seconds));
	post_meter *meter = &post->meter;
	if (!post->settings.exposure_adapts)
		return STILB_OK;
	bool found;
	post_counts counts = meter->coming;
	meter->coming = exposure_ask(post);
	stilb_result result = exposure_take(post, counts, &found);
	if (meter->known)
		meter->exposure = post_exposure_step(meter->exposure, meter->wanted, seconds, &post->settings);
	else if (found)
		meter->exposure = meter->wanted;
	meter->known |= found;
	return result;
}

float stilb_post_exposure(const stilb_post *post)
{
	STILB_ASSERT(post);
	return post->meter.exposure + post->grading.exposure;
}

bool stilb_post_is_blind(const stilb_post *post)
{
	STILB_ASSERT(post);
	return post->settings.exposure_adapts && !post->meter.known;
}

stilb_result stilb_post_look(stilb_post *post)
{
	STILB_ASSERT(post);
	bool found;
	stilb_result result = exposure_take(post, exposure_ask(post), &found);
	if (found)
		post->meter.exposure = post->meter.wanted;
	else
		post->meter.wanted = post->meter.exposure;
	post->meter.known = true;
	post->forgotten = true; /* the frame that is seen moves from the one before, not from this one */
	return result;
}

void stilb_post_forget(stilb_post *post)
{
	STILB_ASSERT(post);
	post->forgotten = true;
	float exposure = post->meter.exposure; /* until the new scene has counts */
	post_exposure_finish(post);
	post->meter.exposure = exposure;
}
