/* profiler_cases: the cases of the suite `profiler`, known to stilb-bench and to the programs of the subjects. */
#ifndef PROFILER_CASES_H
#define PROFILER_CASES_H

/* What is measured. */
typedef enum profiler_kind {
	PROFILER_ZONE,     /* an empty zone beside two bare reads of the clock, turn about */
	PROFILER_NEXT,     /* a zone that begins where the one before ends, the same way */
	PROFILER_PRECISE,  /* an empty zone whose end waits for the instructions before it */
	PROFILER_WORK,     /* work of 41 ns with and without a zone around it, turn about */
	PROFILER_OFF,      /* a loop with and without a zone in it, recording switched off */
	PROFILER_TWO,      /* an empty zone on one thread and on two at once, turn about */
	PROFILER_WORST,    /* the slowest of ten million zones */
	PROFILER_FRAME,    /* a frame mark */
	PROFILER_CAPTURE,  /* 300 frames of 2 threads of 5,000 zones captured while frames go on */
	PROFILER_FILE,     /* the same as a file: written, read back */
	PROFILER_LIVE,     /* what an overlay takes of every frame */
	PROFILER_SWITCHES, /* context switches seen beside those that the kernel counts */
} profiler_kind;

/* X(name, title, KIND) */
#define PROFILER_CASES(X)                                                                                              \
	X("zone", "an empty zone, capturing, beside two reads of the clock", ZONE)                                         \
	X("next", "a zone that begins where the one before ends", NEXT)                                                    \
	X("precise", "an empty zone that waits for what is in it", PRECISE)                                                \
	X("work", "what a zone adds to 41 ns of dependent work", WORK)                                                     \
	X("off", "what a zone adds to a loop while recording is off", OFF)                                                 \
	X("two", "an empty zone on two threads at once", TWO)                                                              \
	X("worst", "the slowest of 10,000,000 zones", WORST)                                                               \
	X("frame", "a frame mark", FRAME)                                                                                  \
	X("capture", "300 frames of 2 threads of 5,000 zones captured while frames go on", CAPTURE)                        \
	X("file", "these 300 frames as Chrome JSON, written and read back", FILE)                                          \
	X("live", "the last two frames of 500 zones, as an overlay takes them", LIVE)                                      \
	X("switches", "context switches seen, of those that the kernel counts", SWITCHES)

#endif
