/*
 * job_line: how far apart data must lie that different threads write. Two cache lines: CPUs prefetch lines in pairs, so
 * data 64 bytes apart still travels together.
 */
#ifndef STILB_JOB_LINE_H
#define STILB_JOB_LINE_H

#define JOB_LINE 128

#endif
