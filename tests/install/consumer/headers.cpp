// The public headers are valid C++, and none needs another before it.
#include <stilb/prof.h>

#include <stilb/job_spsc.h>

#include <stilb/job_queue.h>

#include <stilb/job.h>
