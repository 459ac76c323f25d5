/*
 * job_line: the distance in bytes between data that different threads write. Two 64-byte cache lines, because CPUs
 * prefetch lines in pairs: data 64 bytes apart would still move between cores together.
 */
#ifndef STILB_JOB_LINE_H
#define STILB_JOB_LINE_H

#define JOB_LINE 128

#endif
