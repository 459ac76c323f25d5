/*
 * Off the CPU: when a thread was not running, and if it slept or was preempted, recorded by the kernel; this needs no
 * privileges. If the kernel refuses, a snapshot says why.
 *
 * Prints: the sleep shows as time off the CPU, or it is said why not: yes
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>
#include <time.h>

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_switches_set(true); /* for threads that begin from now on */
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	{
		PROFILE("wait");
		nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	if (lane->no_switches)
		fprintf(stderr, "no context switches: %s\n", lane->no_switches);
	printf("the sleep shows as time off the CPU, or it is said why not: %s\n",
	       lane->no_switches || lane->zones[0].off_cpu_ns > 4000000 ? "yes" : "no");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
