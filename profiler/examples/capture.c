/*
 * Captures: a thread of the lowest priority writes the frames around a slow one to a file while the program goes on. A
 * call, a signal or a crash can ask for a capture too.
 *
 * Prints: frame 60 was slow; written: yes, with the frames before and after
 */
#include <stilb/prof.h>
#include <stilb/prof_capture.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static char said[128];

static void done(void *user, const stilb_prof_captured *captured)
{
	(void)user;
	if (captured->cause == STILB_PROF_CAUSE_SPIKE && captured->frame == 60)
		snprintf(said, sizeof said, "frame %llu was slow; written: %s, with the frames %s",
		         (unsigned long long)captured->frame, captured->error == 0 ? "yes" : "no",
		         captured->frame_count >= 41 ? "before and after" : "missing");
	unlink(captured->path);
}

static void frame(int number)
{
	PROFILE_FUNCTION();
	nanosleep(&(struct timespec){.tv_nsec = number == 60 ? 900000000 : 100000}, NULL);
}

int main(void)
{
	char folder[] = "/tmp/stilb-capture-XXXXXX", path[64];
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	if (!mkdtemp(folder) || stilb_prof_thread_begin("main") != 0)
		return 1;
	snprintf(path, sizeof path, "%s/slow.json", folder);
	desc.path = path;
	desc.spike = STILB_PROF_SPIKE_FIXED;
	desc.spike_ms = 800; /* a busy machine may delay other frames, too */
	desc.frames_before = 30;
	desc.frames_after = 10;
	desc.done = done;
	if (stilb_prof_capture_start(&desc) != 0)
		return 1;
	for (int i = 0; i < 100; i++) {
		stilb_prof_frame_mark();
		frame(i);
	}
	stilb_prof_capture_stop(); /* waits until the capture is written */
	printf("%s\n", said);
	rmdir(folder);
	stilb_prof_shutdown();
	return 0;
}
