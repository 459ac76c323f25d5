/* GPU times: timestamps before and after the frame and each of its passes, read when the slot is used again (two frames
 * later, so nobody waits for them), and shown as zones of a lane of the profiler.
 *
 * The GPU's clock differs from the CPU's. Once a frame both are read together (VK_EXT_calibrated_timestamps). The
 * driver tells how far apart the two reads may be, and readings that were interrupted are not used. Without the
 * extension a frame is shown at the time of its submission, and the lane's name says "uncalibrated". */
#include "gpu/vulkan/gpu_vulkan_internal.h"

#include <stdlib.h>

#define TIMES_FRAME 2u /* timestamps of a frame: its begin and end; after them two for each pass */

#define TIMES_FIRST_PASSES 16u /* for so many a slot has timestamps at first */
#define TIMES_TRIES 4
#define TIMES_GOOD_NS 5000u   /* two clocks read at most so far apart: taken at once */
#define TIMES_WORST_NS 50000u /* read farther apart than this: not used */

STILB_PROF_SITE(times_frame_site, "frame", 0);

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* True when the GPU's clock and CLOCK_MONOTONIC can be read together. */
static bool times_can_calibrate(const gpu_vulkan *gpu)
{
	VkTimeDomainEXT domains[16];
	uint32_t count = 16;
	PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsEXT get =
		(PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsEXT)vkGetInstanceProcAddr(
			gpu->instance, "vkGetPhysicalDeviceCalibrateableTimeDomainsEXT");
	if (!gpu->calibrates || !get || get(gpu->physical, &count, domains) < 0)
		return false;
	bool device = false, cpu = false;
	for (uint32_t d = 0; d < count; d++) {
		device |= domains[d] == VK_TIME_DOMAIN_DEVICE_EXT;
		cpu |= domains[d] == VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT;
	}
	return device && cpu;
}

stilb_result gpu_vulkan_times_create(gpu_vulkan *gpu)
{
	gpu_vulkan_times *times = &gpu->times;
	if (!gpu->timestamp_mask)
		return STILB_OK;
	if (times_can_calibrate(gpu))
		times->read_clocks =
			(PFN_vkGetCalibratedTimestampsEXT)vkGetDeviceProcAddr(gpu->device, "vkGetCalibratedTimestampsEXT");
	/* If there is no memory for the lane, frames are timed but not shown. */
	stilb_prof_lane_create(times->read_clocks ? "GPU" : "GPU (uncalibrated)", &times->lane);
	return STILB_OK;
}

static void slot_times_destroy(gpu_vulkan *gpu, gpu_vulkan_slot_times *times)
{
	gpu_vulkan_buffer_destroy(gpu, &times->results);
	vkDestroyQueryPool(gpu->device, times->queries, gpu->allocator);
	free(times->sites);
	*times = (gpu_vulkan_slot_times){0};
}

void gpu_vulkan_times_destroy(gpu_vulkan *gpu)
{
	for (uint32_t i = 0; i < STILB_GPU_FRAMES; i++)
		slot_times_destroy(gpu, &gpu->slots[i].times);
	stilb_prof_lane_destroy(gpu->times.lane);
}

static uint32_t times_queries(uint32_t passes)
{
	return TIMES_FRAME + 2 * passes;
}

/* Makes a slot's timestamps last for this many passes. The slot's last frame has been read. */
static stilb_result slot_times_fit(gpu_vulkan *gpu, gpu_vulkan_slot_times *times, uint32_t passes)
{
	if (times->queries && passes <= times->capacity)
		return STILB_OK;
	slot_times_destroy(gpu, times);
	uint32_t capacity = passes < TIMES_FIRST_PASSES ? TIMES_FIRST_PASSES : passes + passes / 2;
	VkQueryPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
		.queryType = VK_QUERY_TYPE_TIMESTAMP,
		.queryCount = times_queries(capacity),
	};
	times->sites = calloc(capacity, sizeof(*times->sites));
	if (!times->sites)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the times of %u passes", capacity);
	stilb_result result =
		gpu_vulkan_buffer_create(gpu, times_queries(capacity) * sizeof(uint64_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
	                             STILB_GPU_MEMORY_READ, &times->results);
	if (result == STILB_OK) {
		VkResult error = vkCreateQueryPool(gpu->device, &info, gpu->allocator, &times->queries);
		result = error == VK_SUCCESS ? STILB_OK : gpu_vulkan_fail(gpu, error, "make timestamps");
	}
	if (result == STILB_OK)
		times->capacity = capacity;
	else
		slot_times_destroy(gpu, times);
	return result;
}

/* ---- recording --------------------------------------------------------------------------------------------------- */

static void times_write(const gpu_vulkan_slot *slot, uint32_t query, VkPipelineStageFlags2 stage)
{
	if (slot->times.queries)
		vkCmdWriteTimestamp2(slot->draw, stage, slot->times.queries, query);
}

stilb_result gpu_vulkan_times_begin(gpu_vulkan *gpu, uint32_t passes)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	STILB_ASSERT(!slot->times.taken && "the slot's last frame was read");
	if (!gpu->timestamp_mask)
		return STILB_OK;
	stilb_result result = slot_times_fit(gpu, &slot->times, passes);
	if (result != STILB_OK)
		return result;
	slot->times.passes = 0;
	vkCmdResetQueryPool(slot->draw, slot->times.queries, 0, times_queries(passes));
	times_write(slot, 0, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
	return STILB_OK;
}

void gpu_vulkan_times_pass_begin(gpu_vulkan *gpu, const stilb_prof_site *name)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	if (!slot->times.queries)
		return;
	STILB_ASSERT(slot->times.passes < slot->times.capacity && name);
	slot->times.sites[slot->times.passes] = name;
	times_write(slot, TIMES_FRAME + 2 * slot->times.passes, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
}

void gpu_vulkan_times_pass_end(gpu_vulkan *gpu)
{
	gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	times_write(slot, TIMES_FRAME + 2 * slot->times.passes + 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
	slot->times.passes++;
}

/* Records the copy of the timestamps to memory: vkGetQueryPoolResults waits for the whole device in some drivers. */
void gpu_vulkan_times_end(gpu_vulkan *gpu)
{
	const gpu_vulkan_slot *slot = gpu_vulkan_slot_now(gpu);
	if (!slot->times.queries) {
		gpu_vulkan_host_barrier(slot->draw); /* also of buffers that programs write for the CPU */
		return;
	}
	times_write(slot, 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
	vkCmdCopyQueryPoolResults(slot->draw, slot->times.queries, 0, times_queries(slot->times.passes),
	                          slot->times.results.buffer, 0, sizeof(uint64_t),
	                          VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
	gpu_vulkan_host_barrier(slot->draw);
}

/* ---- both clocks ------------------------------------------------------------------------------------------------- */

/* Reads both clocks a few times and keeps the reading in which they lie closest. If every one was interrupted between
 * the clocks, the reading of an earlier frame stays. */
static void times_calibrate(gpu_vulkan *gpu)
{
	static const VkCalibratedTimestampInfoEXT clocks[2] = {
		{.sType = VK_STRUCTURE_TYPE_CALIBRATED_TIMESTAMP_INFO_EXT, .timeDomain = VK_TIME_DOMAIN_DEVICE_EXT},
		{.sType = VK_STRUCTURE_TYPE_CALIBRATED_TIMESTAMP_INFO_EXT, .timeDomain = VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT},
	};
	uint64_t best = TIMES_WORST_NS + 1;
	for (int i = 0; i < TIMES_TRIES && best > TIMES_GOOD_NS; i++) {
		uint64_t now[2], deviation;
		if (gpu->times.read_clocks(gpu->device, 2, clocks, now, &deviation) != VK_SUCCESS)
			return;
		if (deviation >= best)
			continue;
		best = deviation;
		gpu->times.moment = (gpu_vulkan_moment){.ticks = now[0], .ns = now[1]};
	}
}

void gpu_vulkan_times_submitted(gpu_vulkan *gpu, bool good)
{
	gpu_vulkan_slot_times *times = &gpu_vulkan_slot_now(gpu)->times;
	times->taken = good && times->queries;
	if (!times->taken || !gpu->times.lane)
		return;
	if (gpu->times.read_clocks)
		times_calibrate(gpu);
	times->moment = gpu->times.moment;
	times->submitted_ns = stilb_time_ns();
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Nanoseconds from one timestamp to another, negative if `to` is earlier. The difference is taken modulo the number of
 * valid bits: a clock with few bits wraps within minutes. */
static double times_between(const gpu_vulkan *gpu, uint64_t from, uint64_t to)
{
	uint64_t mask = gpu->timestamp_mask, passed = (to - from) & mask;
	int64_t ticks = (int64_t)(passed > mask >> 1 ? passed | ~mask : passed);
	return (double)ticks * (double)gpu->properties.limits.timestampPeriod;
}

static uint64_t times_clamp(uint64_t ns, uint64_t low, uint64_t high)
{
	return ns < low ? low : ns > high ? high : ns;
}

/* Adds the frame's zones to the lane. A pass may begin before the pass before it has ended: the overlap is shown as
 * part of the earlier one. */
static void times_show(gpu_vulkan *gpu, const gpu_vulkan_slot_times *times, uint64_t now)
{
	const uint64_t *ticks = times->results.mapped;
	gpu_vulkan_moment moment = times->moment;
	uint64_t done = gpu->times.shown_ns;
	if (moment.ns == 0) /* the clocks were never read together: the frame cannot have begun before its submission */
		moment = (gpu_vulkan_moment){ticks[0], times->submitted_ns};
#define TIMES_AT(query, low)                                                                                           \
	times_clamp(moment.ns + (uint64_t)(int64_t)times_between(gpu, moment.ticks, ticks[query]), low, now)
	uint64_t begin = TIMES_AT(0, done);
	done = begin;
	for (uint32_t p = 0; p < times->passes; p++) {
		uint64_t pass_begin = TIMES_AT(TIMES_FRAME + 2 * p, done);
		done = TIMES_AT(TIMES_FRAME + 2 * p + 1, pass_begin);
		stilb_prof_lane_zone(gpu->times.lane, times->sites[p], 1, pass_begin, done);
	}
	gpu->times.shown_ns = TIMES_AT(1, done);
	stilb_prof_lane_zone(gpu->times.lane, &times_frame_site, 0, begin, gpu->times.shown_ns);
#undef TIMES_AT
}

void gpu_vulkan_times_read(gpu_vulkan *gpu, gpu_vulkan_slot *slot)
{
	gpu_vulkan_slot_times *times = &slot->times;
	if (!times->taken)
		return;
	const uint64_t *ticks = times->results.mapped;
	STILB_ASSERT(ticks && times->passes <= times->capacity);
	times->taken = false;
	gpu->base.gpu_ms = times_between(gpu, ticks[0], ticks[1]) * 1e-6;
	if (gpu->times.lane)
		times_show(gpu, times, stilb_time_ns());
}
