/* Plays a frame dump: opens a device of its own, records and replays the dump's draws. */
#include "replay.h"

#include "base/base_contract.h"
#include "image/image.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define REPLAY_OWNER 0u /* the main thread's worker index */

struct stilb_engine_replay {
	char *path;
	stilb_render_dump *dump;
	stilb_job_pool *pool;
	stilb_render *render;
	bool compared;     /* the stream hash has been compared with the dump's */
	stilb_owner owner; /* the main thread: the one that created it */
};

static stilb_result replay_start(stilb_engine_replay *replay, const stilb_engine_replay_desc *desc)
{
	stilb_result result = stilb_render_dump_load(desc->path, &replay->dump);
	if (result != STILB_OK)
		return result;
	stilb_render_dump_info info = stilb_render_dump_info_get(replay->dump);
	stilb_render_desc render = {
		.device = desc->device,
		.replay = desc->replay,
		.materials = desc->materials,
		.output = desc->output ? *desc->output : info.output,
		.gpu = desc->gpu,
		.width = desc->width ? desc->width : info.width,
		.height = desc->height ? desc->height : info.height,
		.samples = info.samples,
		.context_count = desc->workers + 1,
		.validate = desc->validate,
		.morph = info.morph,
	};
	result = stilb_render_create(&render, &replay->render);
	if (result != STILB_OK)
		return result;
	stilb_job_pool_desc pool = {.worker_count = desc->workers};
	int error = stilb_job_pool_create(&pool, &replay->pool);
	if (error != 0)
		return stilb_fail_threads(desc->workers, -error);
	stilb_render_show_image(replay->render, desc->shown);
	stilb_render_until(replay->render, desc->until);
	return stilb_render_dump_upload(replay->dump, replay->render);
}

stilb_result stilb_engine_replay_create(const stilb_engine_replay_desc *desc, stilb_engine_replay **out)
{
	STILB_ASSERT(desc && out);
	STILB_ASSERT(desc->path);
	*out = NULL;
	stilb_engine_replay *replay = calloc(1, sizeof *replay);
	if (!replay || !(replay->path = strdup(desc->path))) {
		free(replay);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a replay");
	}
	stilb_owner_take(&replay->owner);
	stilb_result result = replay_start(replay, desc);
	if (result == STILB_OK)
		*out = replay;
	else
		stilb_engine_replay_destroy(replay);
	return result;
}

void stilb_engine_replay_destroy(stilb_engine_replay *replay)
{
	if (!replay)
		return;
	STILB_ASSERT_OWNER(replay->owner);
	stilb_job_pool_destroy(replay->pool);
	stilb_render_destroy(replay->render);
	stilb_render_dump_destroy(replay->dump);
	free(replay->path);
	free(replay);
}

/* Compares the stream hash of the frame just recorded with the dump's: if they differ, times and picture would be those
 * of another frame. */
static stilb_result replay_compare(stilb_engine_replay *replay)
{
	uint64_t expected = stilb_render_dump_info_get(replay->dump).stream_hash;
	uint64_t found = stilb_render_stream_hash(replay->render);
	replay->compared = true;
	if (found == expected)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_FILE,
	                  "cannot play '%s': its draws have the stream hash %016" PRIx64 ", but the frame had %016" PRIx64,
	                  replay->path, found, expected);
}

static double replay_ms(uint64_t from, uint64_t to)
{
	return (double)(to - from) * 1e-6;
}

stilb_result stilb_engine_replay_frame(stilb_engine_replay *replay, stilb_engine_times *times)
{
	STILB_ASSERT_OWNER(replay->owner);
	STILB_ASSERT(times);
	stilb_render *render = replay->render;
	uint64_t start = stilb_time_ns();
	stilb_result result = stilb_render_frame_begin(render);
	uint64_t begun = stilb_time_ns();
	if (result == STILB_OK)
		result = stilb_render_dump_record(replay->dump, render, replay->pool, REPLAY_OWNER);
	uint64_t recorded = stilb_time_ns();
	if (result == STILB_OK)
		result = stilb_render_dump_replay(replay->dump, render, replay->pool, REPLAY_OWNER);
	uint64_t replayed = stilb_time_ns();
	*times = (stilb_engine_times){.frame = replay_ms(start, replayed),
	                              .record = replay_ms(begun, recorded),
	                              .replay = replay_ms(recorded, replayed),
	                              .gpu = stilb_render_stats_get(render).gpu_ms};
	return result == STILB_OK && !replay->compared ? replay_compare(replay) : result;
}

stilb_result stilb_engine_replay_wait(stilb_engine_replay *replay, double *gpu_ms)
{
	STILB_ASSERT_OWNER(replay->owner);
	STILB_ASSERT(gpu_ms);
	stilb_result result = stilb_render_wait(replay->render);
	*gpu_ms = stilb_render_stats_get(replay->render).gpu_ms;
	return result;
}

stilb_result stilb_engine_replay_screenshot(stilb_engine_replay *replay, const char *path)
{
	STILB_ASSERT_OWNER(replay->owner);
	STILB_ASSERT(path);
	stilb_image image = {0};
	stilb_result result = stilb_render_read_for_file(replay->render, path, &image);
	if (result == STILB_OK)
		result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}

stilb_result stilb_engine_replay_save_plan(stilb_engine_replay *replay, const char *path)
{
	STILB_ASSERT_OWNER(replay->owner);
	STILB_ASSERT(path);
	return stilb_gpu_plan_save(stilb_render_plan(replay->render), path);
}

stilb_result stilb_engine_replay_measure(stilb_engine_replay *replay, double seconds, stilb_render_dump_costs *costs)
{
	STILB_ASSERT_OWNER(replay->owner);
	STILB_ASSERT(seconds > 0.0 && costs);
	stilb_render_show_image(replay->render, NULL);
	stilb_render_until(replay->render, NULL);
	return stilb_render_dump_measure(replay->dump, replay->render, replay->pool, REPLAY_OWNER, seconds, costs);
}

stilb_render_dump_info stilb_engine_replay_info(const stilb_engine_replay *replay)
{
	STILB_ASSERT_OWNER(replay->owner);
	return stilb_render_dump_info_get(replay->dump);
}

const stilb_render *stilb_engine_replay_render(const stilb_engine_replay *replay)
{
	STILB_ASSERT_OWNER(replay->owner);
	return replay->render;
}
