#include "trace_path.h"

#include "base/base.h"
#include "base/base_file.h"
#include "profiler/prof_trace.h"

#include <sys/stat.h>

bool trace_path_check(const char *flag, const char *path)
{
	STILB_ASSERT(flag);
	struct stat info;
	if (!path || stilb_file_is_stdout(path) || stilb_prof_trace_is_named(path) ||
	    (stat(path, &info) == 0 && !S_ISREG(info.st_mode)))
		return true;
	stilb_log("%s: '%s' is not the name of a trace; give one that ends in .json, .folded or .csv", flag, path);
	return false;
}
