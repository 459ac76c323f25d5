/* profiler_own: what the files of Stilb's program in the suite `profiler` share. Each runs a case and returns the exit
 * status. */
#ifndef PROFILER_OWN_H
#define PROFILER_OWN_H

int profiler_own_capture(void);
int profiler_own_file(void);
int profiler_own_live(double seconds);
int profiler_own_switches(double seconds);

#endif
