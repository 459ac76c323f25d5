/* profiler_own: the cases of the suite `profiler` that only Stilb's profiler has (profiler_cases.h). Each function runs
 * one case, if it has a parameter `seconds` for about that long, prints its metrics and returns the exit status.
 * [main-thread] */
#ifndef PROFILER_OWN_H
#define PROFILER_OWN_H

int profiler_own_capture(void);
int profiler_own_file(void);
int profiler_own_live(double seconds);
int profiler_own_switches(double seconds);

#endif
