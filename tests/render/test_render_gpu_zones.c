/* The profiler's lane "GPU" has a zone for each frame, and inside it one for each pass, which lie between the
 * submission and the end of the wait by the CPU's clock. Tested with clocks that can be read together, with interrupted
 * readings, and without the extension (VK_EXT_calibrated_timestamps). The linker sends the Vulkan loader's look-up of
 * functions here (--wrap), so that one can be hidden. */
#include "base/base.h"
#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "profiler/prof_snapshot.h"
#include "render/render_internal.h"
#include "support/picture_reference.h"

#define SIZE 96u
#define FRAMES 12u
#define SLACK_NS 60000u /* largest error: how far apart both clocks are read, and the profiler's conversion */

/* ---- a loader that hides an extension's function ----------------------------------------------------------------- */

static bool hide_clocks;

PFN_vkVoidFunction __real_vkGetInstanceProcAddr(VkInstance instance, const char *name);
PFN_vkVoidFunction __wrap_vkGetInstanceProcAddr(VkInstance instance, const char *name);
PFN_vkVoidFunction __wrap_vkGetInstanceProcAddr(VkInstance instance, const char *name)
{
	bool hidden = hide_clocks && strcmp(name, "vkGetPhysicalDeviceCalibrateableTimeDomainsEXT") == 0;
	return hidden ? NULL : __real_vkGetInstanceProcAddr(instance, name);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

typedef struct stage {
	stilb_render *render;
	gpu_vulkan *gpu;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_render_view view;
	uint64_t begin[FRAMES], end[FRAMES],
		gpu_ns[FRAMES]; /* CLOCK_MONOTONIC before the submission and after the wait; GPU time */
	uint32_t frames;
} stage;

static stage stage_open(stilb_render_desc desc)
{
	stage s = {.scene = reference_scene(1)};
	desc.width = desc.height = SIZE;
	desc.samples = 1;
	desc.context_count = 2;
	desc.validate = true;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	s.gpu = (gpu_vulkan *)s.render->device->gpu;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &s.pool), 0);
	reference_camera camera = reference_camera_at((dvec){0, 3, 2}, (dvec){0, 0, 0}, (dvec){0, 1, 0}, 2.0, SIZE, SIZE);
	s.view = (stilb_render_view){.view_projection = reference_matrix(&camera)};
	assert_int_equal(stilb_render_set_scene(s.render, s.scene), STILB_OK);
	return s;
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_job_pool_destroy(s->pool);
	stilb_scene_destroy(s->scene);
}

/* Two scene passes, and a 2D pass with a rectangle if `overlay`. */
static stilb_result stage_frame(stage *s, bool overlay)
{
	static const stilb_render_pass passes[3] = {
		{.name = "overlay", .kind = STILB_RENDER_PASS_2D}, {.name = "near", .order = 1}, {.name = "far", .order = 2}};
	static const stilb_render_vertex_2d corners[3] = {{.position = {0, 0}}, {.position = {9, 0}}, {.position = {0, 9}}};
	static const uint32_t indices[3] = {0, 1, 2}, model = 0;
	static const float clip[4] = {0, 0, SIZE, SIZE};
	stilb_prof_frame_mark();
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	stilb_render_segment_begin(context, 0, 0);
	if (overlay)
		stilb_render_draw_2d(context, stilb_render_geometry_2d(context, corners, 3, indices, 3), 3, clip,
		                     (stilb_render_texture){0});
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	for (uint32_t p = 1; p < 3; p++)
		assert_int_equal(stilb_render_record(s->render, p, s->scene, &model, 1, s->pool, 0), STILB_OK);
	return stilb_render_replay(s->render, passes, 3, &s->view, 1, s->pool, 0);
}

static void stage_timed_frame(stage *s, bool overlay)
{
	uint32_t f = s->frames++;
	assert_true(f < FRAMES);
	s->begin[f] = stilb_time_ns();
	assert_int_equal(stage_frame(s, overlay), STILB_OK);
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	s->end[f] = stilb_time_ns();
	s->gpu_ns[f] = (uint64_t)(stilb_render_stats_get(s->render).gpu_ms * 1e6);
}

/* ---- the profiler's data ----------------------------------------------------------------------------------------- */

static const stilb_prof_lane *find_lane(const stilb_prof_snapshot *snapshot, const char *name)
{
	for (uint32_t l = 0; l < snapshot->lane_count; l++)
		if (snapshot->lanes[l].kind == STILB_PROF_LANE_DEVICE && strcmp(snapshot->lanes[l].name, name) == 0)
			return &snapshot->lanes[l];
	fail_msg("no lane %s", name);
	return NULL;
}

/* Collects the frames since `since` in order, and checks that each has its passes inside, one after the other. */
static uint32_t take_frames(stilb_prof_snapshot *snapshot, const char *name, uint64_t since, bool overlay,
                            stilb_prof_zone *frames)
{
	static const char *const passes[4] = {"near", "far", "tone map", "overlay"};
	assert_int_equal(stilb_prof_snapshot_take(snapshot, NULL), 0);
	const stilb_prof_lane *lane = find_lane(snapshot, name);
	uint32_t count = 0;
	uint64_t last_end = 0;
	for (uint32_t z = 0; z < lane->zone_count; z += lane->zones[z].size) {
		const stilb_prof_zone *frame = &lane->zones[z];
		assert_int_equal(frame->level, 0);
		assert_string_equal(snapshot->labels[frame->label].name, "frame");
		assert_true(frame->begin_ns >= last_end);
		last_end = frame->end_ns;
		if (snapshot->epoch_ns + frame->begin_ns + SLACK_NS < since)
			continue;
		assert_int_equal(frame->size, overlay ? 5 : 4);
		uint64_t done = frame->begin_ns;
		for (uint32_t p = 0; p + 1 < frame->size; p++) {
			const stilb_prof_zone *pass = frame + 1 + p;
			assert_int_equal(pass->level, 1);
			assert_string_equal(snapshot->labels[pass->label].name, passes[p]);
			assert_true(pass->begin_ns >= done && pass->end_ns >= pass->begin_ns);
			done = pass->end_ns;
		}
		assert_true(done <= frame->end_ns && frame->begin_ns < frame->end_ns);
		assert_true(count < FRAMES);
		frames[count++] = *frame;
	}
	return count;
}

/* Every frame is in the lane, between its submission and the end of its wait. */
static void assert_timed(const stage *s, const char *name, bool overlay)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_zone frames[FRAMES];
	assert_int_equal(take_frames(&snapshot, name, s->begin[0], overlay, frames), s->frames);
	for (uint32_t f = 0; f < s->frames; f++) {
		uint64_t begin = snapshot.epoch_ns + frames[f].begin_ns, end = snapshot.epoch_ns + frames[f].end_ns;
		if (begin + SLACK_NS < s->begin[f] || end > s->end[f] + SLACK_NS)
			fail_msg("frame %u: %lld .. %lld ns, handed over and waited for within 0 .. %lld", f,
			         (long long)(begin - s->begin[f]), (long long)(end - s->begin[f]),
			         (long long)(s->end[f] - s->begin[f]));
		assert_true(end - begin > 0 && end - begin <= s->gpu_ns[f] + 2000);
	}
	stilb_prof_snapshot_finish(&snapshot);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void frames_are_where_they_were(void **state)
{
	(void)state;
	for (int replay = 0; replay < 3; replay++) {
		stage s = stage_open((stilb_render_desc){.replay = (stilb_render_replay_mode)replay});
		for (uint32_t f = 0; f < FRAMES; f++)
			stage_timed_frame(&s, true);
		assert_timed(&s, "GPU", true);
		stage_close(&s);
	}
}

/* Frames without a wait are read when their slot is used again, the last ones by a wait; none is read twice. */
static void frames_in_flight_are_read_in_order(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_zone frames[FRAMES];
	uint64_t since = stilb_time_ns();
	for (uint32_t f = 0; f < FRAMES - 1; f++)
		assert_int_equal(stage_frame(&s, false), STILB_OK);
	assert_int_equal(take_frames(&snapshot, "GPU", since, false, frames), FRAMES - 1 - STILB_GPU_FRAMES);
	for (int again = 0; again < 2; again++) {
		assert_int_equal(stilb_render_wait(s.render), STILB_OK);
		assert_int_equal(take_frames(&snapshot, "GPU", since, false, frames), FRAMES - 1);
	}
	stilb_prof_snapshot_finish(&snapshot);
	stage_close(&s);
}

/* A frame that was lost with the device has no zone. */
static void a_lost_frame_is_none(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.faults.lost_frame = 3});
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_zone frames[FRAMES];
	uint64_t since = stilb_time_ns();
	for (uint32_t f = 1; f <= 5; f++)
		assert_int_equal(stage_frame(&s, false), f == 3 ? STILB_ERROR_DEVICE_LOST : STILB_OK);
	assert_int_equal(stilb_render_wait(s.render), STILB_OK);
	assert_int_equal(take_frames(&snapshot, "GPU", since, false, frames), 4);
	stilb_prof_snapshot_finish(&snapshot);
	stage_close(&s);
}

/* Most clocks have fewer than 64 bits. */
static void a_short_clock(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	s.gpu->timestamp_mask = UINT64_MAX >> 32; /* wraps every 4.3 s */
	for (uint32_t f = 0; f < FRAMES; f++)
		stage_timed_frame(&s, true);
	assert_timed(&s, "GPU", true);
	stage_close(&s);
}

static void without_common_clocks_it_says_so(void **state)
{
	(void)state;
	hide_clocks = true;
	stage s = stage_open((stilb_render_desc){0});
	hide_clocks = false;
	for (uint32_t f = 0; f < FRAMES; f++)
		stage_timed_frame(&s, true);
	assert_timed(&s, "GPU (uncalibrated)", true);
	stage_close(&s);
}

/* Zones of a name that began at `since` or later, on all threads. */
static uint32_t count_zones(const char *name, uint64_t since)
{
	stilb_prof_snapshot snapshot = {0};
	uint32_t count = 0;
	assert_int_equal(stilb_prof_snapshot_take(&snapshot, NULL), 0);
	for (uint32_t l = 0; l < snapshot.lane_count; l++)
		for (uint32_t z = 0; z < snapshot.lanes[l].zone_count; z++) {
			const stilb_prof_zone *zone = &snapshot.lanes[l].zones[z];
			bool named = strcmp(snapshot.labels[zone->label].name, name) == 0;
			count += named && snapshot.epoch_ns + zone->begin_ns >= since;
		}
	stilb_prof_snapshot_finish(&snapshot);
	return count;
}

/* The frame that is slow because it makes a pipeline shows why. */
static void making_a_pipeline_is_a_zone(void **state)
{
	(void)state;
	uint64_t since = stilb_time_ns();
	stage s = stage_open((stilb_render_desc){0});
	for (uint32_t made = 1; made <= 2; made++) {
		for (int again = 0; again < 2; again++) {
			assert_int_equal(stage_frame(&s, false), STILB_OK);
			assert_int_equal(count_zones("make a pipeline", since), made + 4); /* once the tone map's and 2D ones */
		}
		s.view.shading.brdf++; /* other formulas */
	}
	stage_close(&s);
}

/* ---- interrupted readings ---------------------------------------------------------------------------------------- */

/* Deviations of successive readings, ns; the last one is repeated for all later readings. */
static uint64_t deviations[8];
static uint32_t deviation_count, reads;
static PFN_vkGetCalibratedTimestampsEXT real_read;

/* A reading whose GPU time is wrong by exactly its deviation. */
static VKAPI_ATTR VkResult VKAPI_CALL interrupted_read(VkDevice device, uint32_t count,
                                                       const VkCalibratedTimestampInfoEXT *infos, uint64_t *now,
                                                       uint64_t *deviation)
{
	VkResult result = real_read(device, count, infos, now, deviation);
	*deviation = deviations[reads < deviation_count ? reads : deviation_count - 1];
	now[1] += *deviation;
	reads++;
	return result;
}

static void interrupt_reads(stage *s, uint32_t count, const uint64_t *values)
{
	if (s->gpu->times.read_clocks != interrupted_read)
		real_read = s->gpu->times.read_clocks; /* of this device: the layer is loaded again for each device */
	s->gpu->times.read_clocks = interrupted_read;
	memcpy(deviations, values, count * sizeof *values);
	deviation_count = count;
	reads = 0;
}

static void the_best_of_four_tries(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	/* A reading with a deviation below TIMES_GOOD_NS is not repeated. */
	interrupt_reads(&s, 1, (uint64_t[]){300});
	stage_timed_frame(&s, true);
	assert_int_equal(reads, 1);
	/* No good reading: four tries, and the best is taken. */
	interrupt_reads(&s, 4, (uint64_t[]){45000, 20000, 30000, 49000});
	uint64_t before = s.gpu->times.moment.ns;
	stage_timed_frame(&s, true);
	assert_int_equal(reads, 4);
	assert_true(s.gpu->times.moment.ns > before);
	/* Only unusable readings: four tries, and the last frame's reading stays. */
	interrupt_reads(&s, 1, (uint64_t[]){1000000000});
	gpu_vulkan_moment last = s.gpu->times.moment;
	stage_timed_frame(&s, true);
	assert_int_equal(reads, 4);
	assert_memory_equal(&s.gpu->times.moment, &last, sizeof last);
	assert_timed(&s, "GPU", true);
	stage_close(&s);
}

/* No usable reading since the start: frames are placed at their submission. */
static void hopeless_from_the_start(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	interrupt_reads(&s, 1, (uint64_t[]){1000000000});
	for (uint32_t f = 0; f < 3; f++)
		stage_timed_frame(&s, true);
	assert_int_equal(reads, 12);
	assert_timed(&s, "GPU", true);
	stage_close(&s);
}

int main(void)
{
#ifdef STILB_PROFILE_OFF
	printf("skipped: built with STILB_PROFILE=OFF, so there are no zones\n");
	return 77;
#endif
	struct CMUnitTest tests[] = {
		cmocka_unit_test(frames_are_where_they_were),  cmocka_unit_test(frames_in_flight_are_read_in_order),
		cmocka_unit_test(a_lost_frame_is_none),        cmocka_unit_test(a_short_clock),
		cmocka_unit_test(making_a_pipeline_is_a_zone), cmocka_unit_test(the_best_of_four_tries),
		cmocka_unit_test(hopeless_from_the_start),     cmocka_unit_test(without_common_clocks_it_says_so),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
