/* A shared object with a profiler of its own, for test_prof_unload. */
#include "profiler/prof.h"

__attribute__((visibility("default"))) void module_record(void);

void module_record(void)
{
	PROFILE("zone of a module");
}
