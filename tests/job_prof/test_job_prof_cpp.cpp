// The header in C++: the same hooks record the same.
#include <stilb/job_prof.h>
#include <stilb/prof_snapshot.h>

#include <cstdio>
#include <cstring>

static void work(void *, uint32_t)
{
	PROFILE("work");
}

static bool run_jobs()
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool = nullptr;
	stilb_job_group group = {};
	desc.worker_count = 2;
	desc.hooks = stilb_job_prof_hooks("worker");
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return false;
	bool good = true;
	for (int i = 0; i < 50; i++)
		good &= stilb_job_submit(pool, work, nullptr, &group, 0) == 0;
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool);
	return good;
}

int main()
{
	stilb_prof_snapshot s = {};
	if (!run_jobs() || stilb_prof_snapshot_take(&s, nullptr) != 0)
		return 1;
	unsigned jobs = 0, inside = 0;
	for (uint32_t l = 0; l < s.lane_count; l++) {
		const stilb_prof_lane &lane = s.lanes[l];
		for (uint32_t i = 0; i < lane.zone_count; i++) {
			const stilb_prof_zone &zone = lane.zones[i];
			jobs += std::strcmp(s.labels[zone.label].name, "job") == 0;
			inside += std::strcmp(s.labels[zone.label].name, "work") == 0 && zone.parent != STILB_PROF_NONE &&
			          std::strcmp(s.labels[lane.zones[zone.parent].label].name, "job") == 0;
		}
	}
	std::printf("%u jobs, %u with their work inside, %u arrows\n", jobs, inside, s.flow_count);
	const bool good = jobs == 50 && inside == 50 && s.flow_count == 50;
	stilb_prof_snapshot_finish(&s);
	stilb_prof_shutdown();
	return good ? 0 : 1;
}
