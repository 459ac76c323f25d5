/*
 * Included by force before every source of jobs/ that the simulator compiles: what they call of libc and of the CPU
 * goes to the simulated machine. Functions that the simulation does not change, such as snprintf, are libc's.
 */
#ifndef SIM_LIBC_H
#define SIM_LIBC_H

#include <dirent.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

void *sim_libc_malloc(size_t size);
void *sim_libc_calloc(size_t count, size_t size);
void *sim_libc_aligned_alloc(size_t alignment, size_t size);
void sim_libc_free(void *block);
long sim_libc_syscall(long number, ...);
int sim_libc_yield(void);
int sim_libc_getcpu(void);
int sim_libc_getaffinity(pid_t thread, size_t size, cpu_set_t *set);
int sim_libc_setaffinity(pid_t thread, size_t size, const cpu_set_t *set);
int sim_libc_nanosleep(const struct timespec *time, struct timespec *left);
int sim_libc_clock(clockid_t clock, struct timespec *now);
unsigned long long sim_libc_ticks(void);
void sim_libc_pause(void);
int sim_libc_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int sim_libc_join(pthread_t thread, void **result);
pthread_t sim_libc_self(void);
/* Files that describe the machine; no other file exists. */
FILE *sim_libc_fopen(const char *path, const char *mode);
DIR *sim_libc_opendir(const char *path);
struct dirent *sim_libc_readdir(DIR *stream);
int sim_libc_closedir(DIR *stream);

#define malloc(size) sim_libc_malloc(size)
#define calloc(count, size) sim_libc_calloc(count, size)
#define aligned_alloc(alignment, size) sim_libc_aligned_alloc(alignment, size)
#define free(block) sim_libc_free(block)
#define syscall(...) sim_libc_syscall(__VA_ARGS__)
#define sched_yield() sim_libc_yield()
#define sched_getcpu() sim_libc_getcpu()
#define sched_getaffinity(thread, size, set) sim_libc_getaffinity(thread, size, set)
#define sched_setaffinity(thread, size, set) sim_libc_setaffinity(thread, size, set)
#define nanosleep(time, left) sim_libc_nanosleep(time, left)
#define clock_gettime(clock, now) sim_libc_clock(clock, now)
#define __builtin_ia32_rdtsc() sim_libc_ticks()
#define __builtin_ia32_pause() sim_libc_pause()
#define pthread_create(thread, attributes, fn, data) sim_libc_create(thread, attributes, fn, data)
#define pthread_join(thread, result) sim_libc_join(thread, result)
#define pthread_self() sim_libc_self()
#define pthread_setname_np(thread, name) ((void)(thread), (void)(name))
#define fopen(path, mode) sim_libc_fopen(path, mode)
#define opendir(path) sim_libc_opendir(path)
#define readdir(stream) sim_libc_readdir(stream)
#define closedir(stream) sim_libc_closedir(stream)

#endif
