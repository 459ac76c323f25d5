// The public headers are valid C++, and none needs another to be included before it.
#include <stilb/job_prof.h>

#include <stilb/prof.h>

#include <stilb/prof_capture.h>

#include <stilb/prof_diff.h>

#include <stilb/prof_read.h>

#include <stilb/prof_stats.h>

#include <stilb/prof_trace.h>

#include <stilb/prof_snapshot.h>

#include <stilb/job_spsc.h>

#include <stilb/job_queue.h>

#include <stilb/job.h>
