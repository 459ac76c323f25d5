/*
 * sim: a discrete-event simulation of the job system on machines that are not here. The real sources of jobs/ run on
 * simulated CPUs: every thread is a coroutine, every CPU has a clock of its own, and the CPU with the smallest clock
 * runs next. So a run is deterministic, and 256 CPUs need one.
 *
 *   sim_run(&sim_machines[0], 64, scenario, &data);        runs scenario(&data) as the first thread, on CPU 0
 *
 * Accesses.  The sources are compiled with -fsanitize=thread and linked with sim_access.c in place of the thread
 *            sanitizer: the compiler reports every access to memory that other threads might see, plain and atomic,
 *            and with -fsanitize-coverage=trace-pc every basic block.
 * Lines.     Each line of 64 bytes has an owner or sharers, as under MESI, and a time until which it is busy. A hit
 *            costs next to nothing. A miss takes the line from where it is, for the published time of a transfer
 *            over that distance: to the other thread of the core, within the cluster that shares a cache, within the
 *            socket, between sockets. A write waits for the farthest sharer. Requests for a line that is on its way
 *            wait for it, first come, first served. The request reaches the line's owner after half of the transfer;
 *            until then the owner goes on using it, so that a thread does several read-modify-writes in a row.
 * Stores.    A store that is not seq_cst costs its thread nothing but the instruction; the line follows by itself, and
 *            the thread's next read-modify-write waits for it.
 * Order.     The sources run sequentially consistent. A CPU may run ahead of the others by one transfer as long as it
 *            hits, since nothing that another CPU does can reach it sooner.
 * Kernel.    Futexes, sleeps, yields, affinity and the creation of threads cost what the machine's table says. A woken
 *            thread starts after the wake latency and preempts the one that runs on its CPU; threads that share a CPU
 *            take turns.
 * Instructions. They cost what the basic blocks and the calls of functions cost in which they lie.
 * Not there: caches of limited size; several misses of one thread at a time; the limits of links and memory; power
 *            states; what the two threads of a core take from each other.
 *
 * Threads: none; one simulation at a time.
 */
#ifndef SIM_H
#define SIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SIM_CPUS_MAX = 256, SIM_THREADS_MAX = 320 };

/* A machine: what its CPUs share, and what things cost, in ns. */
typedef struct sim_machine {
	const char *name;
	const char *title;
	uint32_t cores;   /* of one socket */
	uint32_t sockets; /* of the machine as it is sold; simulations with more CPUs add some */
	uint32_t threads; /* of one core */
	uint32_t cluster; /* number of cores that share the last level of cache */
	/* A line's transfer: to the other thread of the core, within the cluster, within the socket, to another one. */
	double smt, near, socket, far;
	double rmw;       /* a read-modify-write of a line that the CPU owns */
	double pause;     /* the instruction with which loops wait */
	double block;     /* a basic block: instructions up to the next jump, or to where one goes */
	double function;  /* a call of a function */
	double call;      /* a system call that does little, such as a yield without another thread */
	double wake;      /* the caller of a futex wake */
	double latency;   /* from the call of a futex wake to the first instruction of the woken thread */
	double sleep;     /* of a futex wait, until the CPU may do something else */
	double create;    /* the creation of a thread */
	double timeslice; /* of threads that share a CPU */
} sim_machine;

extern const sim_machine sim_machines[];
extern const size_t sim_machine_count;

/* Runs main(data) as the first thread of a process that may use `cpus` CPUs: first one of each core, socket by socket,
 * then the second threads of the cores, if the machine has so many, or else cores of further sockets. Returns when main
 * has returned. At most SIM_CPUS_MAX. */
void sim_run(const sim_machine *machine, uint32_t cpus, void (*main)(void *), void *data);

/* ---- called by simulated threads --------------------------------------------------------------------------------- */

/* The CPU's clock in ns. */
double sim_now(void);

/* Computes for so many ns. */
void sim_work(double ns);

/* Sleeps for so many ns. */
void sim_sleep(double ns);

/* Accesses to memory, by the code at this address, which may be NULL. */
void sim_read(const volatile void *at, const void *code);
void sim_write(const volatile void *at, const void *code);
void sim_rmw(const volatile void *at, const void *code);

/* Runs a basic block; calls a function. */
void sim_block(void);
void sim_function(void);

/* Futexes; the waiter returns at once if *word is not expected, and after timeout_ns, UINT64_MAX for never. */
void sim_futex_wait(const volatile uint32_t *word, uint32_t expected, uint64_t timeout_ns);
uint32_t sim_futex_wake(const volatile uint32_t *word, uint32_t count);

void sim_yield(void);
void sim_pause(void);
void sim_membarrier(void);

/* A thread, numbered from 0 (the first). */
uint32_t sim_thread_create(void *(*fn)(void *), void *data);
void sim_thread_join(uint32_t thread);
uint32_t sim_thread(void);
void sim_thread_bind(uint32_t thread, uint32_t cpu);
uint32_t sim_cpu(void); /* that the calling thread runs on */

/* Memory, at the same addresses in every run; freed when the run ends. */
void *sim_allocate(size_t alignment, size_t size);

/* ---- the machine ------------------------------------------------------------------------------------------------- */

bool sim_running(void); /* the caller is a simulated thread */
const sim_machine *sim_this(void);
uint32_t sim_cpus(void); /* that the process may use */

/* The lowest CPU that shares the core, the cluster's cache with `cpu`, and its socket's number. */
typedef struct sim_place {
	uint32_t core, cluster, socket;
} sim_place;
sim_place sim_place_of(uint32_t cpu);

/* Counts since the last call, for tests and explanations: transfers of lines, wakes by futex. */
typedef struct sim_counts {
	uint64_t transfers, wakes;
} sim_counts;
sim_counts sim_take_counts(void);

/* Forgets what is known of lines' costs, and prints the lines that took most time since, with the code that missed
 * last. */
void sim_lines_reset(void);
void sim_lines_print(uint32_t count);

#endif
