/*
 * Flows: an arrow from where a job was submitted to where it ran, on any thread. Its length is the time that the job
 * was queued. The job is charged to the frame that submitted it, even if it runs in a later one.
 *
 * Prints: job from main to worker, submitted before it ran: yes, charged to frame 0
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <pthread.h>
#include <stdio.h>

STILB_PROF_FLOW(flow_job, "job", 0x40a040);

static void *run_worker(void *id)
{
	if (stilb_prof_thread_begin("worker") != 0)
		return NULL;
	{
		PROFILE("job");
		stilb_prof_flow_end(flow_job, *(uint64_t *)id);
	}
	stilb_prof_thread_end();
	return NULL;
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	pthread_t worker;
	uint64_t id;
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	stilb_prof_frame_mark();
	{
		PROFILE("submit");
		id = stilb_prof_flow_begin(flow_job);
	}
	stilb_prof_frame_mark(); /* the job runs in the second frame */
	if (pthread_create(&worker, NULL, run_worker, &id) != 0 || pthread_join(worker, NULL) != 0)
		return 1;
	stilb_prof_frame_mark();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0 || snapshot.flow_count != 1 || snapshot.lane_count != 2)
		return 1;
	const stilb_prof_flow *flow = &snapshot.flows[0];
	const stilb_prof_zone *job = &snapshot.lanes[flow->to_lane].zones[0];
	printf("%s from %s to %s, submitted before it ran: %s, charged to frame %llu\n", snapshot.labels[flow->label].name,
	       snapshot.lanes[flow->from_lane].name, snapshot.lanes[flow->to_lane].name,
	       flow->from_ns < flow->to_ns ? "yes" : "no", (unsigned long long)snapshot.frames[job->frame].number);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
