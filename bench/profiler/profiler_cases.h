/* profiler_cases: the cases (measurements) of the suite `profiler`; included by stilb-bench and by the programs that it
 * starts, one for each subject (a profiler). A zone is a named span of code whose begin and end are recorded. */
#ifndef PROFILER_CASES_H
#define PROFILER_CASES_H

/* The kinds of measurement. "In turns": the two loops that are compared alternate in one process. */
typedef enum profiler_kind {
	PROFILER_ZONE,     /* an empty zone and two bare reads of the clock, in turns */
	PROFILER_NEXT,     /* a zone that begins where the last one ended, and bare reads of the clock, in turns */
	PROFILER_PRECISE,  /* an empty zone whose end waits for the instructions before it, and bare reads, in turns */
	PROFILER_WORK,     /* work of 41 ns with and without a zone around it, in turns */
	PROFILER_OFF,      /* a loop with and without a zone in it, in turns, while recording is off */
	PROFILER_TWO,      /* an empty zone on one thread and on two at once, in turns: do threads slow each other? */
	PROFILER_WORST,    /* the slowest of ten million zones */
	PROFILER_FRAME,    /* a frame mark, which ends one frame of the program and begins the next */
	PROFILER_CAPTURE,  /* capturing 300 frames of 2 x 5,000 zones (2 threads), while further frames are recorded */
	PROFILER_FILE,     /* writing such a capture to a file, and reading it back */
	PROFILER_LIVE,     /* the snapshot that an overlay takes in every frame */
	PROFILER_SWITCHES, /* the share of the kernel's context switches that the profiler records */
} profiler_kind;

/* X(name, title, KIND) */
#define PROFILER_CASES(X)                                                                                              \
	X("zone", "an empty zone while recording, beside two reads of the clock", ZONE)                                    \
	X("next", "a zone that begins where the one before ends", NEXT)                                                    \
	X("precise", "an empty zone whose end waits for the instructions in it", PRECISE)                                  \
	X("work", "time that a zone adds to 41 ns of dependent work", WORK)                                                \
	X("off", "time that a zone adds to a loop while recording is off", OFF)                                            \
	X("two", "an empty zone on two threads at once", TWO)                                                              \
	X("worst", "the slowest of 10,000,000 zones", WORST)                                                               \
	X("frame", "a frame mark", FRAME)                                                                                  \
	X("capture", "capturing 300 frames of 2 threads with 5,000 zones each, while recording goes on", CAPTURE)          \
	X("file", "the same 300 frames as Chrome JSON: written, and read back", FILE)                                      \
	X("live", "snapshot of the last two frames of 500 zones, as an overlay takes it", LIVE)                            \
	X("switches", "context switches recorded, beside the kernel's count", SWITCHES)

#endif
