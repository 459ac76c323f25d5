#include "jobs_json.h"

void jobs_json_put(stilb_json *json, const stilb_job_pool_stats *stats)
{
	const stilb_job_thread_stats *all = &stats->all;
	stilb_json_begin(json, "jobs", '{');
	stilb_json_int(json, "submitted", (int64_t)all->submitted);
	stilb_json_int(json, "jobs", (int64_t)all->jobs);
	stilb_json_int(json, "steals", (int64_t)all->steals);
	stilb_json_int(json, "loops_helped", (int64_t)all->loops_helped);
	stilb_json_int(json, "slices", (int64_t)all->slices);
	stilb_json_int(json, "parks", (int64_t)all->parks);
	stilb_json_int(json, "wakes", (int64_t)all->wakes);
	stilb_json_double(json, "spin_ms", (double)all->spin_ns * 1e-6);
	stilb_json_int(json, "deque", (int64_t)all->deque);
	stilb_json_int(json, "high", (int64_t)stats->high);
	stilb_json_int(json, "shared", (int64_t)stats->shared);
	stilb_json_int(json, "low", (int64_t)stats->low);
	stilb_json_end(json, '}');
}
