// The public headers are valid C++.
#include <stilb/job.h>
#include <stilb/prof.h>
