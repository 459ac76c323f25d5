#include "jobs/job_internal.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

/* The most that stilb_job_pool_desc.nice may add: from one end of the kernel's -20..19 to the other. */
#define MOST_NICE 39

/* ---- the settings ---------------------------------------------------------------------------------------------- */

stilb_job_pool_desc stilb_job_pool_desc_default(void)
{
	uint32_t cpus = stilb_job_cpu_count();
	uint32_t workers = cpus > 1 ? cpus - 1 : 1;
	return (stilb_job_pool_desc){.worker_count = workers < STILB_JOB_MAX_WORKERS ? workers : STILB_JOB_MAX_WORKERS};
}

/* What is wrong with the CPUs, or NULL. */
static const char *cpus_error(const stilb_job_pool_desc *desc)
{
	if (desc->affinity == STILB_JOB_AFFINITY_EACH && desc->cpu_count != desc->worker_count)
		return "affinity is EACH, and cpu_count is not worker_count";
	if (desc->cpu_count > STILB_JOB_MAX_CPUS)
		return "cpu_count is more than STILB_JOB_MAX_CPUS";
	if (desc->cpu_count > 0 && !desc->cpus)
		return "cpu_count is not 0, and cpus is NULL";
	for (uint32_t i = 0; i < desc->cpu_count; i++)
		if (desc->cpus[i] >= STILB_JOB_MAX_CPUS)
			return "cpus has a number that is not below STILB_JOB_MAX_CPUS";
	return NULL;
}

const char *stilb_job_pool_desc_error(const stilb_job_pool_desc *desc)
{
	assert(desc);
	if (desc->worker_count > STILB_JOB_MAX_WORKERS)
		return "worker_count is more than STILB_JOB_MAX_WORKERS";
	if ((uint32_t)desc->queue > STILB_JOB_QUEUE_LOCK_FREE)
		return "queue is not a stilb_job_queue_kind";
	if ((uint32_t)desc->affinity > STILB_JOB_AFFINITY_EACH)
		return "affinity is not a stilb_job_affinity";
	if (desc->stack_size > 0 && desc->stack_size < (size_t)PTHREAD_STACK_MIN)
		return "stack_size is less than PTHREAD_STACK_MIN";
	if (desc->stack_size > PTRDIFF_MAX)
		return "stack_size is more than PTRDIFF_MAX";
	if (desc->nice < -MOST_NICE || desc->nice > MOST_NICE)
		return "nice is not in -39..39";
	if (!job_allocator_is_whole(desc->allocator))
		return "allocator has only one of its functions";
	return cpus_error(desc);
}

/* ---- before the threads start ---------------------------------------------------------------------------------- */

/* The CPUs that workers may use if they are not bound to one of them. */
static job_cpu_list cpus_of(const job_worker_desc *worker)
{
	return (job_cpu_list){worker->cpus, worker->cpu_count};
}

void job_worker_prepare(stilb_job_pool *pool, const stilb_job_pool_desc *desc, uint32_t *cpus)
{
	job_worker_desc *worker = &pool->worker;
	snprintf(worker->name, sizeof worker->name, "%s", desc->name && *desc->name ? desc->name : "stilb-worker");
	worker->stack_size = desc->stack_size;
	worker->nice = desc->nice;
	worker->cpus = cpus;
	worker->cpu_count = desc->cpu_count;
	if (desc->cpu_count > 0) {
		memcpy(cpus, desc->cpus, desc->cpu_count * sizeof *cpus);
		uint32_t most = job_cpu_different(cpus_of(worker)) + 1; /* one more for the owner */
		pool->cpus = pool->cpus < most ? pool->cpus : most;
		pool->oversubscribed = desc->worker_count >= pool->cpus;
	}
	for (uint32_t i = 1; i <= desc->worker_count && desc->affinity == STILB_JOB_AFFINITY_EACH; i++)
		pool->slot[i].cpu = cpus[i - 1];
}

/* Sets the stack size in the attributes, in whole pages. */
static int set_stack_size(pthread_attr_t *attributes, size_t bytes)
{
	size_t page = (size_t)sysconf(_SC_PAGESIZE);
	return pthread_attr_setstacksize(attributes, (bytes + page - 1) / page * page);
}

int job_worker_create(stilb_job_pool *pool, uint32_t index, void *(*main)(void *))
{
	pthread_attr_t attributes;
	job_slot *slot = &pool->slot[index];
	if (pool->worker.stack_size == 0)
		return pthread_create(&slot->thread, NULL, main, slot) ? -EAGAIN : 0;
	if (pthread_attr_init(&attributes) != 0)
		return -EAGAIN;
	bool refused = set_stack_size(&attributes, pool->worker.stack_size) != 0 ||
	               pthread_create(&slot->thread, &attributes, main, slot) != 0;
	pthread_attr_destroy(&attributes);
	return refused ? -EAGAIN : 0;
}

/* ---- the thread itself ----------------------------------------------------------------------------------------- */

/* Cuts the name, so that the index fits into the 15 characters that the kernel keeps. */
static void set_name(const job_slot *slot)
{
	char index[12], name[16];
	int digits = snprintf(index, sizeof index, "-%u", slot->index);
	snprintf(name, sizeof name, "%.*s%s", (int)sizeof name - 1 - digits, slot->pool->worker.name, index);
	pthread_setname_np(pthread_self(), name);
}

/* Linux has a nice value for each thread; PRIO_PROCESS with 0 means the calling one. The kernel cuts a value beyond
 * -20..19 to that range. */
static void set_nice(job_slot *slot)
{
	int32_t more = slot->pool->worker.nice;
	if (more != 0 && setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + more) != 0)
		slot->info.nice_error = -errno;
	slot->info.nice = getpriority(PRIO_PROCESS, 0);
}

static void set_cpu(job_slot *slot)
{
	job_cpu_list list = cpus_of(&slot->pool->worker);
	if (slot->cpu != JOB_NO_CPU)
		list = (job_cpu_list){&slot->cpu, 1};
	if (list.count > 0)
		slot->info.affinity_error = job_cpu_bind(list);
	if (slot->cpu != JOB_NO_CPU && slot->info.affinity_error == 0)
		job_idle_bound(&slot->pool->idle, &slot->parker, slot->cpu);
}

void job_worker_begin(job_slot *slot)
{
	set_name(slot);
	set_nice(slot);
	set_cpu(slot);
	atomic_store_explicit(&slot->started, true, memory_order_release); /* pairs with stilb_job_pool_worker_info */
}

void stilb_job_pool_worker_info(stilb_job_pool *pool, uint32_t worker, stilb_job_worker_info *info)
{
	assert(pool && info);
	assert(worker > 0 && worker <= pool->worker_count && "the index of a worker");
	uint32_t rounds = 0;
	/* Acquire pairs with the release in job_worker_begin. */
	while (!atomic_load_explicit(&pool->slot[worker].started, memory_order_acquire))
		job_sys_relax(&rounds);
	*info = pool->slot[worker].info;
}
