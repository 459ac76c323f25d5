/* jobs_json: what the threads of a job pool have done, as JSON. [one-writer] */
#ifndef STILB_JOBS_JSON_H
#define STILB_JOBS_JSON_H

#include "base/base_json.h"
#include "jobs/job.h"

/* Adds an object "jobs" with the fields of stilb_job_thread_stats, summed over all threads, and the entries of the
 * shared queues. */
void jobs_json_put(stilb_json *json, const stilb_job_pool_stats *stats);

#endif
