/* GPU times: timestamps before and after the frame and each of its passes, read when the slot is used again (two frames
 * later, so nobody waits for them), and shown as zones of a lane of the profiler.
 *
 * The GPU's clock differs from the CPU's. Once a frame both are read together (VK_EXT_calibrated_timestamps). The
 * driver tells how far apart the two reads may be, and readings that were interrupted are not used. Without the
 * extension a frame is shown at the time of its submission, and the lane's name says "uncalibrated". */
#include "render/vulkan/vulkan_internal.h"

#define TIMES_FRAME 2u /* timestamps of a frame: its begin and end; after them two for each pass */
#define TIMES_QUERIES (TIMES_FRAME + 2u * STILB_RENDER_MAX_PASSES)

#define TIMES_TRIES 4
#define TIMES_GOOD_NS 5000u   /* two clocks read at most so far apart: taken at once */
#define TIMES_WORST_NS 50000u /* read farther apart than this: not used */

STILB_PROF_SITE(times_frame_site, "frame", 0);

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* True when the GPU's clock and CLOCK_MONOTONIC can be read together. */
static bool times_can_calibrate(const vulkan_device *device)
{
	VkTimeDomainEXT domains[16];
	uint32_t count = 16;
	PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsEXT get =
		(PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsEXT)vkGetInstanceProcAddr(
			device->instance, "vkGetPhysicalDeviceCalibrateableTimeDomainsEXT");
	if (!device->calibrates || !get || get(device->gpu, &count, domains) < 0)
		return false;
	bool gpu = false, cpu = false;
	for (uint32_t d = 0; d < count; d++) {
		gpu |= domains[d] == VK_TIME_DOMAIN_DEVICE_EXT;
		cpu |= domains[d] == VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT;
	}
	return gpu && cpu;
}

stilb_result vulkan_times_create(vulkan_device *device)
{
	vulkan_times *times = &device->times;
	if (!device->timestamp_mask)
		return STILB_OK;
	VkQueryPoolCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
		.queryType = VK_QUERY_TYPE_TIMESTAMP,
		.queryCount = TIMES_QUERIES * VULKAN_SLOTS,
	};
	VkResult error = vkCreateQueryPool(device->device, &info, device->allocator, &times->queries);
	if (error != VK_SUCCESS)
		return vulkan_fail(device, error, "make timestamps");
	stilb_result result = STILB_OK;
	for (int i = 0; i < VULKAN_SLOTS && result == STILB_OK; i++)
		result = vulkan_buffer_create(device, TIMES_QUERIES * sizeof(uint64_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
		                              VULKAN_MEMORY_READBACK, &device->slots[i].times.results);
	if (times_can_calibrate(device))
		times->read_clocks =
			(PFN_vkGetCalibratedTimestampsEXT)vkGetDeviceProcAddr(device->device, "vkGetCalibratedTimestampsEXT");
	/* If there is no memory for the lane, frames are timed but not shown. */
	if (result == STILB_OK)
		stilb_prof_lane_create(times->read_clocks ? "GPU" : "GPU (uncalibrated)", &times->lane);
	return result;
}

void vulkan_times_destroy(vulkan_device *device)
{
	for (int i = 0; i < VULKAN_SLOTS; i++)
		vulkan_buffer_destroy(device, &device->slots[i].times.results);
	vkDestroyQueryPool(device->device, device->times.queries, device->allocator);
	stilb_prof_lane_destroy(device->times.lane);
}

/* ---- recording --------------------------------------------------------------------------------------------------- */

static void times_write(vulkan_device *device, uint32_t query, VkPipelineStageFlags2 stage)
{
	if (device->times.queries)
		vkCmdWriteTimestamp2(vulkan_slot_now(device)->draw, stage, device->times.queries,
		                     TIMES_QUERIES * device->slot + query);
}

void vulkan_times_begin(vulkan_device *device)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	slot->times.passes = 0;
	if (device->times.queries)
		vkCmdResetQueryPool(slot->draw, device->times.queries, TIMES_QUERIES * device->slot, TIMES_QUERIES);
	times_write(device, 0, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
}

void vulkan_times_pass_begin(vulkan_device *device, const stilb_prof_site *name)
{
	vulkan_slot_times *times = &vulkan_slot_now(device)->times;
	STILB_ASSERT(times->passes < STILB_RENDER_MAX_PASSES && name);
	times->sites[times->passes] = name;
	times_write(device, TIMES_FRAME + 2 * times->passes, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
}

void vulkan_times_pass_end(vulkan_device *device)
{
	vulkan_slot_times *times = &vulkan_slot_now(device)->times;
	times_write(device, TIMES_FRAME + 2 * times->passes + 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
	times->passes++;
}

/* Records the copy of the timestamps to memory: vkGetQueryPoolResults waits for the whole device in some drivers. */
void vulkan_times_end(vulkan_device *device)
{
	vulkan_slot *slot = vulkan_slot_now(device);
	if (!device->times.queries)
		return;
	times_write(device, 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
	vkCmdCopyQueryPoolResults(slot->draw, device->times.queries, TIMES_QUERIES * device->slot,
	                          TIMES_FRAME + 2 * slot->times.passes, slot->times.results.buffer, 0, sizeof(uint64_t),
	                          VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
	vulkan_host_barrier(slot->draw);
}

/* ---- both clocks ------------------------------------------------------------------------------------------------- */

/* Reads both clocks a few times and keeps the reading in which they lie closest. If every one was interrupted between
 * the clocks, the reading of an earlier frame stays. */
static void times_calibrate(vulkan_device *device)
{
	static const VkCalibratedTimestampInfoEXT clocks[2] = {
		{.sType = VK_STRUCTURE_TYPE_CALIBRATED_TIMESTAMP_INFO_EXT, .timeDomain = VK_TIME_DOMAIN_DEVICE_EXT},
		{.sType = VK_STRUCTURE_TYPE_CALIBRATED_TIMESTAMP_INFO_EXT, .timeDomain = VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT},
	};
	uint64_t best = TIMES_WORST_NS + 1;
	for (int i = 0; i < TIMES_TRIES && best > TIMES_GOOD_NS; i++) {
		uint64_t now[2], deviation;
		if (device->times.read_clocks(device->device, 2, clocks, now, &deviation) != VK_SUCCESS)
			return;
		if (deviation >= best)
			continue;
		best = deviation;
		device->times.moment = (vulkan_moment){.ticks = now[0], .ns = now[1]};
	}
}

void vulkan_times_submitted(vulkan_device *device, bool good)
{
	vulkan_slot_times *times = &vulkan_slot_now(device)->times;
	times->taken = good && device->times.queries;
	if (!times->taken || !device->times.lane)
		return;
	if (device->times.read_clocks)
		times_calibrate(device);
	times->moment = device->times.moment;
	times->submitted_ns = stilb_time_ns();
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Nanoseconds from one timestamp to another, negative if `to` is earlier. The difference is taken modulo the number of
 * valid bits: a clock with few bits wraps within minutes. */
static double times_between(const vulkan_device *device, uint64_t from, uint64_t to)
{
	uint64_t mask = device->timestamp_mask, passed = (to - from) & mask;
	int64_t ticks = (int64_t)(passed > mask >> 1 ? passed | ~mask : passed);
	return (double)ticks * (double)device->properties.limits.timestampPeriod;
}

static uint64_t times_clamp(uint64_t ns, uint64_t low, uint64_t high)
{
	return ns < low ? low : ns > high ? high : ns;
}

/* Adds the frame's zones to the lane. A pass may begin before the pass before it has ended: the overlap is shown as
 * part of the earlier one. */
static void times_show(vulkan_device *device, const vulkan_slot_times *times, uint64_t now)
{
	const uint64_t *ticks = times->results.mapped;
	vulkan_moment moment = times->moment;
	uint64_t done = device->times.shown_ns;
	if (moment.ns == 0) /* the clocks were never read together: the frame cannot have begun before its submission */
		moment = (vulkan_moment){ticks[0], times->submitted_ns};
#define TIMES_AT(query, low)                                                                                           \
	times_clamp(moment.ns + (uint64_t)(int64_t)times_between(device, moment.ticks, ticks[query]), low, now)
	uint64_t begin = TIMES_AT(0, done);
	done = begin;
	for (uint32_t p = 0; p < times->passes; p++) {
		uint64_t pass_begin = TIMES_AT(TIMES_FRAME + 2 * p, done);
		done = TIMES_AT(TIMES_FRAME + 2 * p + 1, pass_begin);
		stilb_prof_lane_zone(device->times.lane, times->sites[p], 1, pass_begin, done);
	}
	device->times.shown_ns = TIMES_AT(1, done);
	stilb_prof_lane_zone(device->times.lane, &times_frame_site, 0, begin, device->times.shown_ns);
#undef TIMES_AT
}

void vulkan_times_read(vulkan_device *device, vulkan_slot *slot)
{
	vulkan_slot_times *times = &slot->times;
	if (!times->taken)
		return;
	const uint64_t *ticks = times->results.mapped;
	STILB_ASSERT(ticks && times->passes <= STILB_RENDER_MAX_PASSES);
	times->taken = false;
	device->base.stats.gpu_ms = times_between(device, ticks[0], ticks[1]) * 1e-6;
	if (device->times.lane)
		times_show(device, times, stilb_time_ns());
}
