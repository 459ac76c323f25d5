#include "render_crew.h"

#include "jobs/job.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { NOTE_SAMPLES, NOTE_RAYS, NOTE_CAMERA_RAYS, NOTE_SHADOW_RAYS, NOTE_BAD_SAMPLES };

bool offline_crew_is_guest(void)
{
	return stilb_farm_link_is_asked() && !stilb_farm_link_is_host();
}

bool offline_crew_join(offline_crew *crew)
{
	*crew = (offline_crew){0};
	if (!stilb_farm_link_is_asked())
		return true;
	crew->many = stilb_farm_link_open(&crew->link) == STILB_OK;
	if (!crew->many)
		stilb_log("%s", stilb_error_message());
	return crew->many;
}

uint32_t offline_crew_threads(const offline_crew *crew)
{
	uint32_t cpus = stilb_job_cpu_count();
	if (!crew->many || crew->link.neighbours <= 1)
		return cpus;
	return cpus > crew->link.neighbours ? cpus / crew->link.neighbours : 1;
}

/* stilb_farm_crew_desc.stop */
static void crew_stop(void *user)
{
	offline_crew *crew = user;
	if (crew->render)
		stilb_gi_render_stop(crew->render);
}

/* stilb_farm_crew_desc.count */
static void crew_count(void *user, uint64_t notes[STILB_FARM_NOTES])
{
	offline_crew *crew = user;
	if (!crew->render)
		return;
	if (crew->link.machine == 0) {
		stilb_gi_farm_count(crew->render, &(stilb_gi_farm_counts){.samples = notes[NOTE_SAMPLES],
		                                                          .rays = notes[NOTE_RAYS],
		                                                          .camera_rays = notes[NOTE_CAMERA_RAYS],
		                                                          .shadow_rays = notes[NOTE_SHADOW_RAYS],
		                                                          .bad_samples = notes[NOTE_BAD_SAMPLES]});
		return;
	}
	stilb_gi_farm_counts counts = stilb_gi_farm_counted(crew->render);
	notes[NOTE_SAMPLES] = counts.samples;
	notes[NOTE_RAYS] = counts.rays;
	notes[NOTE_CAMERA_RAYS] = counts.camera_rays;
	notes[NOTE_SHADOW_RAYS] = counts.shadow_rays;
	notes[NOTE_BAD_SAMPLES] = counts.bad_samples;
}

stilb_result offline_crew_begin(offline_crew *crew, stilb_gi_render *render, uint32_t threads, const char *trouble)
{
	if (!crew->many)
		return STILB_OK;
	if (!trouble) {
		crew->render = render;
		crew->work = stilb_gi_farm_work(render);
		trouble = crew->work.identity ? NULL : "out of memory";
	}
	stilb_farm_crew_desc desc = {.link = &crew->link,
	                             .work = trouble ? NULL : &crew->work,
	                             .trouble = trouble,
	                             .threads = threads > 0 ? threads : 1,
	                             .stop = crew_stop,
	                             .count = crew_count,
	                             .user = crew};
	stilb_result result = stilb_farm_crew_start(&desc, &crew->crew);
	if (result != STILB_OK || trouble)
		return result;
	stilb_farm_feed feed = stilb_farm_crew_feed(crew->crew);
	stilb_gi_farm_feed(render, &feed);
	return STILB_OK;
}

bool offline_crew_trouble(offline_crew *crew, char *text, size_t size)
{
	return crew->crew && stilb_farm_crew_trouble(crew->crew, text, size);
}

void offline_crew_hold(offline_crew *crew)
{
	if (crew->crew)
		stilb_farm_crew_hold(crew->crew);
}

void offline_crew_release(offline_crew *crew)
{
	if (crew->crew)
		stilb_farm_crew_release(crew->crew);
}

void offline_crew_shares(offline_crew *crew, char *text, size_t size)
{
	text[0] = '\0';
	if (!crew->crew || crew->link.machine != 0 || crew->work.unit_count == 0)
		return;
	snprintf(text, size, "%" PRIu32 " ranks rendered", crew->link.count);
	for (uint32_t i = 0; i < crew->link.count; i++) {
		double share = 100.0 * stilb_farm_crew_count(crew->crew, i) / crew->work.unit_count;
		size_t length = strlen(text);
		if (i == 16 && crew->link.count > 17) {
			snprintf(text + length, size - length, ", ...");
			break;
		}
		snprintf(text + length, size - length, "%s %.1f", i > 0 ? "," : "", share);
	}
	size_t length = strlen(text);
	snprintf(text + length, size - length, " %% of the picture");
}

void offline_crew_end(offline_crew *crew)
{
	crew->ended_all = stilb_farm_crew_end(crew->crew);
	crew->crew = NULL;
}

void offline_crew_leave(offline_crew *crew, int code)
{
	if (!crew->many)
		return;
	if (!crew->ended_all)
		crew->link.abort(crew->link.user, code);
	crew->link.close(crew->link.user);
}
