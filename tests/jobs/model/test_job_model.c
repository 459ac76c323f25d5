/*
 * All interleavings of the real pool for few threads and few jobs: deques, inboxes, groups, loops, parking. job_model.h
 * tells what that covers. The shared queues are checked by tests of their own; here an object with indivisible
 * operations replaces them. Copies of the sources with one planted fault each are run with the arguments of
 * model_arguments: some scenario must fail.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A smaller JOB_LINE (distance between data of different threads), so that the states that the checker saves are
 * small. */
#define STILB_JOB_LINE_H
#define JOB_LINE 16
#define JOB_RECORD_LIST 2
#define JOB_RECORD_SLAB 3
#define JOB_DEQUE_CAPACITY 2
#define JOB_LOOP_DEPTH 2
#define JOB_GUESTS 1
#define JOB_RATES 1
#define JOB_WATCH_NS 0 /* time stands still, so a nap would never end */
#define SHARED_FIRST 1
#define JOBS_IN_A_ROW 2
#define JOB_BATCH_SHARES 1
#define JOB_GRAPH_FEW 2
#define JOB_TALLIES 0
#define JOB_TEAM_MOST threads_of_a_team
static unsigned threads_of_a_team = 8;
#include "job_model_sys.h"

/* The array of nodes or edges of a graph is made once, with room for all of them; nodes have no names. */
#define realloc(block, size) ((void)(block), model_aligned_alloc(JOB_LINE, size))
#include "jobs/job_deque.c"
#include "jobs/job_record.c"

#include "jobs/job_park.c"

#include "jobs/job_for.c"
#pragma push_macro("snprintf") /* not called, since there is no cycle */
#undef snprintf
#include "jobs/job_graph.c"
#pragma pop_macro("snprintf")
#undef realloc
#include "jobs/job_submit.c"
#include "jobs/job_wait.c"
#include "jobs/job_work.c"

/* No spinning: a spin only looks for work some times more, and the sources look again before they sleep anyway. */
#undef job_sys_ticks_in
#define job_sys_ticks_in(nanoseconds) UINT64_C(0)
#include "jobs/job_pool.c"
#include "jobs/queue/job_event.c"
#include "jobs/queue/job_queue.c"
#include "support/test.h"

#undef free
#undef malloc

uint32_t stilb_job_cpu_count(void)
{
	return 2;
}

uint32_t job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max)
{
	(void)list, (void)here, (void)cpus, (void)max;
	return 0;
}

bool job_cpu_allows(job_cpu_list list, uint32_t cpu)
{
	(void)list, (void)cpu;
	return true;
}

static bool no_threads; /* the workers do not start: the scenario runs in their place */

/* Workers have neither names nor CPUs. */
const char *stilb_job_pool_desc_error(const stilb_job_pool_desc *desc)
{
	(void)desc;
	return NULL;
}

void job_worker_prepare(stilb_job_pool *pool, const stilb_job_pool_desc *desc, uint32_t *cpus)
{
	(void)pool, (void)desc, (void)cpus;
}

int job_worker_create(stilb_job_pool *pool, uint32_t index, void *(*main)(void *))
{
	return no_threads ? 0 : pthread_create(&pool->slot[index].thread, NULL, main, &pool->slot[index]);
}

void job_worker_begin(job_slot *slot)
{
	(void)slot;
}

void job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache)
{
	(void)cpus, (void)count, (void)cpu_dirs, (void)cache;
}

int job_queue_low_lock_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	(void)desc;
	(void)queue;
	return -ENOMEM;
}

int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	(void)desc;
	(void)queue;
	return -ENOMEM;
}

/* ---- the replacement of the shared queues ---------------------------------------------------------------------- */

/* One step for each call. On a machine with store buffers a call is over before its stores are in memory: they drain in
 * order, as those of a queue under a lock do. */
typedef struct plain_queue {
	stilb_job_queue base;
	void *item[4];
	uint32_t held;
	_Atomic uint32_t count;
} plain_queue;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

static void plain_take(plain_queue *self)
{
	model_block_until(&self->held, 0);
	self->held = 1;
}

static void plain_give(plain_queue *self, uint32_t count)
{
	model_store(&self->count, sizeof self->count, count, memory_order_release);
	model_store(&self->held, sizeof self->held, 0, memory_order_release);
}

static uint32_t plain_count(const plain_queue *self)
{
	return *(const _Atomic uint32_t *)model_load(&self->count);
}

static int plain_push(stilb_job_queue *queue, void *item, uint32_t thread)
{
	plain_queue *self = (plain_queue *)queue;
	(void)thread;
	plain_take(self);
	uint32_t count = plain_count(self);
	fail_unless(count < 4, "the model's queue is too small");
	self->item[count] = item;
	plain_give(self, count + 1);
	return 0;
}

static int plain_pop(stilb_job_queue *queue, void **item, uint32_t thread)
{
	plain_queue *self = (plain_queue *)queue;
	(void)thread;
	plain_take(self);
	uint32_t count = plain_count(self);
	if (count > 0) {
		*item = self->item[0];
		memmove(self->item, self->item + 1, sizeof self->item - sizeof self->item[0]);
		self->item[--count] = NULL;
		plain_give(self, count);
		return 0;
	}
	plain_give(self, 0);
	return -EAGAIN;
}

static bool plain_empty(stilb_job_queue *queue, uint32_t thread)
{
	(void)thread;
	model_step(queue, "empty", __LINE__);
	return plain_count((plain_queue *)queue) == 0;
}

static void plain_rest(stilb_job_queue *queue, uint32_t thread)
{
	(void)queue;
	(void)thread;
}

static void plain_destroy(stilb_job_queue *queue)
{
	model_free(queue);
}

static stilb_job_queue *plain_make(void)
{
	static const job_queue_ops ops = {
		.push = plain_push, .pop = plain_pop, .empty = plain_empty, .rest = plain_rest, .destroy = plain_destroy};
	plain_queue *queue = model_malloc(sizeof *queue);
	*queue = (plain_queue){.base.ops = &ops};
	return &queue->base;
}

/* ---- scenarios ------------------------------------------------------------------------------------------------- */

static struct shared {
	stilb_job_pool *pool;
	uint32_t ran;
	uint32_t nodes; /* of the graph: a bit for each one that has run */
	uint32_t first_done;
	uint32_t outside_done;
	uint32_t dropped;
	uint32_t started, ready, released; /* flags of the scenarios with buried jobs */
	uint32_t slice_runs[4];
	stilb_job_group group, first;
	job_idle_list list; /* for spinner_main */
	job_parker parker;
	_Atomic uint32_t published;
} shared;

/* Parameters of a scenario, and what workers did in all interleavings together: the checker does not save and restore
 * this when it goes back to an earlier state. */
static struct {
	uint32_t workers, jobs;
	bool stays; /* the pool is not destroyed */
} with;
static uint64_t worker_runs, owner_runs;

static void count_run(void *data, uint32_t worker)
{
	(void)data;
	(*(worker ? &worker_runs : &owner_runs))++;
	shared.ran++; /* atomic here, since the checker changes threads only at operations of job_model.h */
}

static void add(stilb_job_fn *fn, stilb_job_group *group, uint32_t worker)
{
	fail_unless(stilb_job_submit(shared.pool, fn, NULL, group, worker) == 0, "submit");
}

static void add_with(stilb_job_fn *fn, stilb_job_group *group, stilb_job_options options, uint32_t worker)
{
	fail_unless(stilb_job_submit_with(shared.pool, fn, NULL, group, &options, worker) == 0, "submit");
}

static void begin(void)
{
	stilb_job_pool_desc desc = {.worker_count = with.workers};
	fail_unless(job_pool_create_over(&desc, plain_make, &shared.pool) == 0, "create");
}

static void end(void)
{
	fail_unless(shared.ran == with.jobs, "a wait returned too early");
	if (!with.stays)
		stilb_job_pool_destroy(shared.pool);
}

/* The owner does not help: the workers, woken by the submits, must run everything, and then the run ends. */
static void workers_alone(void)
{
	model_block_until(&shared.ran, with.jobs);
}

static void submit_main(void)
{
	begin();
	for (uint32_t i = 0; i < with.jobs; i++)
		add(count_run, NULL, 0);
	workers_alone();
}

static void submit_shared_main(void)
{
	begin();
	for (uint32_t i = 0; i < with.jobs; i++)
		add_with(count_run, NULL, (stilb_job_options){.priority = i ? STILB_JOB_LOW : STILB_JOB_HIGH}, 0);
	workers_alone();
}

static void submit_pinned_main(void)
{
	begin();
	for (uint32_t i = 0; i < with.jobs; i++)
		add_with(count_run, NULL, (stilb_job_options){.pinned = true, .target = with.workers}, 0);
	workers_alone();
}

static void destroy_main(void)
{
	begin();
	for (uint32_t i = 0; i < with.jobs; i++)
		add(count_run, NULL, 0);
	stilb_job_pool_destroy(shared.pool);
}

static void submit_child(void *data, uint32_t worker)
{
	count_run(data, worker);
	add(count_run, NULL, worker);
}

static void submit_grandchild(void *data, uint32_t worker)
{
	count_run(data, worker);
	add(submit_child, NULL, worker);
}

/* Jobs submit further jobs while the pool is being destroyed. */
static void destroy_child_main(void)
{
	begin();
	add(with.jobs == 2 ? submit_child : submit_grandchild, NULL, 0);
	stilb_job_pool_destroy(shared.pool);
}

static void cancel_main(void)
{
	begin();
	add(count_run, &shared.group, 0);
	stilb_job_pool_cancel(shared.pool);
	stilb_job_wait(shared.pool, &shared.group, 0);
	shared.ran = with.jobs; /* as the check at the end of the run wants; after a cancel fewer may have run */
	end();
}

static void count_dropped(void *data, uint32_t worker)
{
	count_run(data, worker);
	shared.dropped = 1;
}

/* The owner cancels a group while a worker may be at its jobs: each runs or is handed back. Then the group is used
 * again, and nothing is dropped. */
static void cancel_group_main(void)
{
	begin();
	shared.group.dropped = count_dropped;
	add(count_run, &shared.group, 0);
	stilb_job_group_cancel(shared.pool, &shared.group);
	stilb_job_wait(shared.pool, &shared.group, 0);
	shared.dropped = 0;
	add(count_run, &shared.group, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	fail_unless(!shared.dropped, "a job of a group that is not cancelled was dropped");
	model_block_until((const uint32_t *)&shared.pool->cancels, 0); /* lowered a moment after the group has finished */
	end();
}

static void wait_main(void)
{
	begin();
	for (uint32_t i = 0; i < with.jobs; i++)
		add(count_run, &shared.group, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

/* A job that submits another one to a group on its own stack, and waits for it. */
static void submit_and_wait(void *data, uint32_t worker)
{
	(void)data;
	stilb_job_group inner = {0};
	add(count_run, &inner, worker);
	stilb_job_wait(shared.pool, &inner, worker);
	fail_unless(shared.ran >= 1, "inner wait returned too early");
	shared.ran++;
}

/* Two jobs submitted together while the worker goes to sleep. */
static void batch_main(void)
{
	begin();
	fail_unless(stilb_job_submit_n(shared.pool, count_run, NULL, 0, with.jobs, NULL, 0) == 0, "submit");
	workers_alone();
}

/* The first job of the newest record does not end before all others have run. */
static void run_while_others(void *data, uint32_t worker)
{
	if ((uintptr_t)data == with.jobs / 2)
		model_block_until(&shared.ran, with.jobs - 1);
	(*(worker ? &worker_runs : &owner_runs))++;
	shared.ran++;
}

/* A batch in two records: the second job of a record must be found while the first one runs. */
static void batch_records_main(void)
{
	begin();
	fail_unless(stilb_job_submit_n(shared.pool, run_while_others, NULL, 1, with.jobs, &shared.group, 0) == 0, "submit");
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

static void nested_main(void)
{
	begin();
	add(submit_and_wait, &shared.group, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

static void count_first(void *data, uint32_t worker)
{
	count_run(data, worker);
	shared.first_done = 1;
}

static void count_after_first(void *data, uint32_t worker)
{
	fail_unless(shared.first_done == 1, "a follower started before its group had finished");
	count_run(data, worker);
}

/* data: the number of a node, and above it a bit for each one that comes before. */
static void graph_job(void *data, uint32_t worker)
{
	uint32_t number = (uintptr_t)data & 0xff, before = (uint32_t)((uintptr_t)data >> 8);
	(*(worker ? &worker_runs : &owner_runs))++;
	fail_unless((shared.nodes & before) == before, "a node ran before one that it comes after");
	fail_unless(!(shared.nodes & 1u << number), "a node ran twice");
	shared.nodes |= 1u << number;
	shared.ran++;
}

/* A graph of `nodes` nodes; each edge is a node and one that comes after it. */
static stilb_job_graph *make_graph(uint32_t nodes, const uint8_t (*edge)[2], uint32_t edges)
{
	stilb_job_graph *graph;
	fail_unless(stilb_job_graph_create(&graph) == 0, "graph create");
	for (uint32_t i = 0, node; i < nodes; i++) {
		uintptr_t before = 0;
		for (uint32_t k = 0; k < edges; k++)
			before |= edge[k][1] == i ? (uintptr_t)1 << edge[k][0] : 0;
		fail_unless(stilb_job_graph_add_node(graph, graph_job, (void *)(before << 8 | i), NULL, &node) == 0, "node");
	}
	for (uint32_t k = 0; k < edges; k++)
		fail_unless(stilb_job_graph_add_edge(graph, edge[k][0], edge[k][1]) == 0, "add edge");
	fail_unless(stilb_job_graph_build(graph, NULL, 0) == 0, "build");
	return graph;
}

static void run_graph(stilb_job_graph *graph)
{
	shared.nodes = 0;
	fail_unless(stilb_job_graph_run(graph, shared.pool, &shared.group, 0) == 0, "run");
	stilb_job_wait(shared.pool, &shared.group, 0);
}

/* 0 and 1; 2 after 0, 3 after both. */
static const uint8_t diamond[][2] = {{0, 2}, {0, 3}, {1, 3}};

/* A graph that is destroyed as soon as the wait has returned. */
static void graph_main(void)
{
	begin();
	stilb_job_graph *graph = make_graph(4, diamond, 3);
	run_graph(graph);
	stilb_job_graph_destroy(graph);
	end();
}

/* Runs the nodes of the record and what they make ready, as the thread of this slot. */
static void run_nodes(uint32_t thread, job_record *record)
{
	job_slot *slot = &shared.pool->slot[thread];
	for (; record; record = job_deque_pop(&slot->deque))
		while ((record = job_graph_run(slot, record, NULL, NULL)))
			;
}

/* In the place of the worker, which has no thread here: looks once into the owner's deque. */
static void *steal_nodes(void *data)
{
	(void)data;
	int64_t top;
	job_record *record = job_deque_oldest(&shared.pool->slot[0].deque, &top);
	if (record && job_deque_steal(&shared.pool->slot[0].deque, top))
		run_nodes(1, record);
	return NULL;
}

/* Two runs by the owner, without the states of a pool that looks for work and sleeps. Another thread may take nodes. */
static void graph_twice(stilb_job_graph *graph)
{
	model_spawn(steal_nodes, NULL);
	for (uint32_t jobs = with.jobs / 2; jobs <= with.jobs; jobs += with.jobs / 2) {
		shared.nodes = 0;
		fail_unless(stilb_job_graph_run(graph, shared.pool, &shared.group, 0) == 0, "run");
		run_nodes(0, job_deque_pop(&shared.pool->slot[0].deque));
		model_block_until((const uint32_t *)&shared.group.state, 0);
		fail_unless(shared.ran == jobs, "a run ended too early");
	}
}

static void graph_thief_main(void)
{
	begin();
	graph_twice(make_graph(4, diamond, 3));
}

/* 1, then 2, which counts two edges from it, and 0: between these two and 3 and 4 build puts a join. */
static void graph_join_main(void)
{
	static const uint8_t edge[][2] = {{1, 2}, {1, 2}, {0, 3}, {0, 4}, {2, 3}, {2, 4}};
	begin();
	stilb_job_graph *graph = make_graph(5, edge, 6);
	fail_unless(graph->run_count == 6, "no join");
	graph_twice(graph);
}

/* A job that follows a group which may finish before, during or after the submit. */
static void after_main(void)
{
	begin();
	add(count_first, &shared.first, 0);
	add_with(count_after_first, &shared.group, (stilb_job_options){.after = &shared.first}, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

/* A group is used again after its followers have run. */
static void after_again_main(void)
{
	begin();
	add(count_first, &shared.first, 0);
	add_with(count_after_first, &shared.group, (stilb_job_options){.after = &shared.first}, 0);
	stilb_job_wait(shared.pool, &shared.first, 0);
	add(count_run, &shared.first, 0);
	add(count_run, &shared.first, 0);
	stilb_job_wait(shared.pool, &shared.first, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

/* Two jobs follow a group on which a thread also waits, and whose memory is freed after the wait. */
static void after_gone_main(void)
{
	begin();
	stilb_job_group first = {0};
	add(count_first, &first, 0);
	add_with(count_after_first, &shared.group, (stilb_job_options){.after = &first}, 0);
	stilb_job_wait(shared.pool, &first, 0);
	fail_unless(shared.first_done == 1, "the wait for the first group returned too early");
	memset(&first, 0xee, sizeof first);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

static void wait_for_first(void *data, uint32_t worker)
{
	stilb_job_wait(shared.pool, &shared.first, worker);
	fail_unless(shared.first_done == 1, "the wait returned too early");
	count_run(data, worker);
}

/* A job waits for another one in a queue that waits do not touch: the only worker must run it nevertheless. */
static void rescue_main(void)
{
	begin();
	add(count_first, &shared.first, STILB_JOB_OUTSIDE);
	add(wait_for_first, NULL, 0);
	workers_alone();
}

static void pin_to_owner(void *data, uint32_t worker)
{
	count_run(data, worker);
	add_with(count_run, &shared.group, (stilb_job_options){.pinned = true, .target = 0}, worker);
}

/* The owner sleeps in a wait when a job arrives that only it may run. */
static void pinned_owner_main(void)
{
	begin();
	add(pin_to_owner, &shared.group, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	end();
}

/* As in rescue_main, but the awaited job arrives when the worker already sleeps: it follows a group that ends with a
 * job pinned to the owner. The worker waits inside a job of high priority, where it takes no others of that kind. */
static void rescue_later_main(void)
{
	begin();
	add_with(count_run, &shared.group, (stilb_job_options){.pinned = true, .target = 0}, 0);
	add_with(count_first, &shared.first, (stilb_job_options){.priority = STILB_JOB_HIGH, .after = &shared.group}, 0);
	add_with(wait_for_first, NULL, (stilb_job_options){.priority = STILB_JOB_HIGH}, 0);
	stilb_job_run_pinned(shared.pool, 0);
	workers_alone();
}

/* An unrelated job that takes longer than the wait that must not wait for it. */
static void run_until_released(void *data, uint32_t worker)
{
	model_block_until(&shared.released, 1);
	count_run(data, worker);
}

/* Waits for shared.first while unrelated jobs run, and then lets them end. */
static void wait_for_buried(void)
{
	stilb_job_wait(shared.pool, &shared.first, 0);
	fail_unless(shared.first_done == 1, "the wait returned too early");
	shared.released = 1;
	workers_alone();
}

/* Takes the oldest job of the owner's deque, as another worker would, unless it is the one waited for. */
static void *thief(void *data)
{
	(void)data;
	job_deque *deque = &shared.pool->slot[0].deque;
	int64_t top;
	job_record *record = job_deque_oldest(deque, &top);
	if (record && atomic_load_explicit(&record->root, memory_order_relaxed) == 0 && job_deque_steal(deque, top))
		shared.ran++;
	return NULL;
}

/* The job that the owner waits for lies in its deque, below one and above the others. */
static void submit_between(void)
{
	begin();
	for (uint32_t i = 2; i < with.jobs; i++)
		add(run_until_released, NULL, 0);
	add(count_first, &shared.first, 0);
	add(run_until_released, NULL, 0);
}

static void buried_main(void)
{
	submit_between();
	wait_for_buried();
}

/* The worker may look for jobs while the owner hides some of them, and the others are stolen. */
static void buried_thief_main(void)
{
	submit_between();
	model_spawn(thief, NULL);
	wait_for_buried();
}

/* The job that the owner waits for is submitted with low priority. */
static void buried_low_main(void)
{
	begin();
	add_with(run_until_released, NULL, (stilb_job_options){.priority = STILB_JOB_LOW}, 0);
	add_with(count_first, &shared.first, (stilb_job_options){.priority = STILB_JOB_LOW}, 0);
	wait_for_buried();
}

static void submit_buried(void *data, uint32_t worker)
{
	shared.started = 1;
	model_block_until(&shared.ready, 1);
	add(run_until_released, NULL, worker);
	add(count_first, &shared.first, worker);
	add(run_until_released, NULL, worker);
	count_run(data, worker);
}

/* The job that the owner waits for comes to lie in the worker's deque during the wait, between jobs that keep the
 * worker busy. The pinned job is there so that the wait begins before. */
static void buried_elsewhere_main(void)
{
	begin();
	add(submit_buried, NULL, 0);
	model_block_until(&shared.started, 1);
	add_with(count_run, &shared.first, (stilb_job_options){.pinned = true, .target = 1}, 0);
	shared.ready = 1;
	wait_for_buried();
}

/* Waits for a job that only the owner may run, then submits another one that the owner must run. */
static void wait_and_submit(void *data, uint32_t worker)
{
	(void)data;
	stilb_job_wait(shared.pool, &shared.first, worker);
	add(count_run, &shared.group, worker);
	model_block_until(&shared.ran, with.jobs);
}

/* The owner goes to sleep, or does not, while the worker wakes up and has a job for it. */
static void wait_and_submit_main(void)
{
	begin();
	add_with(count_run, &shared.first, (stilb_job_options){.pinned = true, .target = 0}, 0);
	add_with(wait_and_submit, &shared.group, (stilb_job_options){.pinned = true, .target = 1}, 0);
	model_block_until(&shared.pool->idle.waiting, 1);
	stilb_job_run_pinned(shared.pool, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	workers_alone();
}

static void *wait_on_list(void *data)
{
	(void)data;
	job_idler idler = {.parker = &shared.parker, .scope = {.jobs = true, .root = 64}, .worker = true};
	job_idle_enter(&shared.list, &idler, false);
	if (!atomic_load_explicit(&shared.published, memory_order_seq_cst))
		job_parker_sleep(&shared.parker);
	job_idle_leave(&shared.list, &shared.parker);
	shared.ran++;
	return NULL;
}

/* A spinner that is busy for ever does not stand for a thread that waits for jobs of the new job's root. */
static void spinner_main(void)
{
	job_idle_init(&shared.list, 2);
	fail_unless(job_idle_spin_start(&shared.list, 1), "no spinner");
	model_spawn(wait_on_list, NULL);
	atomic_exchange_explicit(&shared.published, 1, memory_order_seq_cst);
	if (job_idle_wanted(&shared.list, 64))
		job_idle_wake(&shared.list, &(job_work){.kind = JOB_WORK_JOB, .root = 64, .level = 1});
	owner_runs++;
	workers_alone();
}

static void *outside(void *data)
{
	(void)data;
	add(count_run, &shared.first, STILB_JOB_OUTSIDE);
	stilb_job_wait(shared.pool, &shared.first, STILB_JOB_OUTSIDE);
	fail_unless(shared.ran == 1, "wait returned too early");
	shared.outside_done = 1;
	return NULL;
}

static void outside_main(void)
{
	begin();
	model_spawn(outside, NULL);
	model_block_until(&shared.outside_done, 1);
	end();
}

static void run_slice(uint32_t begin_at, uint32_t end_at, uint32_t worker, void *context)
{
	(void)context;
	(*(worker ? &worker_runs : &owner_runs))++;
	for (uint32_t i = begin_at; i < end_at; i++) {
		model_step(NULL, "slice", __LINE__); /* other threads may run in the middle of a slice */
		shared.slice_runs[i]++;
	}
}

static void loop_main(void)
{
	begin();
	stilb_job_parallel_for(shared.pool, with.jobs, 1, run_slice, NULL, 0);
	for (uint32_t i = 0; i < with.jobs; i++)
		fail_unless(shared.slice_runs[i] == 1, "a slice lost, run twice or not finished");
	shared.ran = with.jobs;
	end();
}

static void run_other_slice(uint32_t begin_at, uint32_t end_at, uint32_t worker, void *context)
{
	(void)context;
	(*(worker ? &worker_runs : &owner_runs))++;
	for (uint32_t i = begin_at; i < end_at; i++)
		shared.slice_runs[2 + i]++;
}

/* Two successive loops in one slot: a helper of the first may still be there during the second. */
static void loops_main(void)
{
	begin();
	stilb_job_parallel_for(shared.pool, 2, 1, run_slice, NULL, 0);
	stilb_job_parallel_for(shared.pool, 2, 1, run_other_slice, NULL, 0);
	for (uint32_t i = 0; i < 4; i++)
		fail_unless(shared.slice_runs[i] == 1, "a slice lost, run twice or not finished");
	shared.ran = with.jobs;
	end();
}

static void array_main(void)
{
	begin();
	stilb_job_submit_array(shared.pool, with.jobs, 1, run_slice, NULL, &shared.group, 0);
	stilb_job_wait(shared.pool, &shared.group, 0);
	for (uint32_t i = 0; i < with.jobs; i++)
		fail_unless(shared.slice_runs[i] == 1, "a slice lost, run twice or not finished");
	shared.ran = with.jobs;
	end();
}

static void all_ran(void)
{
	fail_unless(shared.ran == with.jobs, "a job lost or run twice");
}

/* After destroy nothing is left on the heap. */
static void all_gone(void)
{
	all_ran();
	fail_unless(model_heap_blocks() == 0, "leaked blocks");
}

/* ---- tests ----------------------------------------------------------------------------------------------------- */

typedef struct scenario {
	const char *name;
	void (*main)(void);
	uint32_t workers, jobs;
	enum {
		WORKERS = 1, /* they, the owner or both must run part of it in some interleaving */
		OWNER = 2,
		BOTH = 3,
		UNTIL_OWNER_ENDS = 4,
		IN_ORDER = 8, /* checked on MODEL_SC: weaker machines have too many states */
		TSO = 16,     /* the same, on MODEL_TSO */
		TEAMS = 32,   /* each thread is a team of its own */
		NO_THREADS = 64
	} who;
} scenario;

static const scenario scenarios[] = {
	{"destroy runs all", destroy_main, 0, 2, OWNER},
	{"destroy runs children", destroy_child_main, 0, 2, OWNER},
	{"wait", wait_main, 0, 2, OWNER},
	{"nested wait", nested_main, 0, 2, OWNER},
	{"after", after_main, 0, 2, OWNER},
	{"loop", loop_main, 0, 2, OWNER},
	{"graph", graph_main, 0, 4, OWNER},
	{"graph, a thief", graph_thief_main, 1, 8, BOTH | UNTIL_OWNER_ENDS | NO_THREADS},
	{"graph, a join", graph_join_main, 1, 10, BOTH | UNTIL_OWNER_ENDS | NO_THREADS},
	{"submit wakes", submit_main, 1, 1, WORKERS | UNTIL_OWNER_ENDS},
	{"submit wakes", submit_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"shared queues wake", submit_shared_main, 1, 1, WORKERS | UNTIL_OWNER_ENDS},
	{"shared queues wake", submit_shared_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"pinned wakes", submit_pinned_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"rescue", rescue_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"rescue later", rescue_later_main, 1, 3, WORKERS | UNTIL_OWNER_ENDS},
	{"wide loop", loop_main, 1, 4, BOTH | TEAMS | UNTIL_OWNER_ENDS | TSO},
	{"submit after a wait", wait_and_submit_main, 1, 2,
     OWNER | UNTIL_OWNER_ENDS | TEAMS | IN_ORDER}, /* 1,500,000 states on TSO */
	{"batch wakes", batch_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"batch in records", batch_records_main, 1, 4, WORKERS},
	{"buried", buried_main, 1, 4, WORKERS | UNTIL_OWNER_ENDS},
	{"buried, with a thief", buried_thief_main, 1, 3, WORKERS | UNTIL_OWNER_ENDS},
	{"buried, low priority", buried_low_main, 1, 2, WORKERS | UNTIL_OWNER_ENDS},
	{"buried elsewhere", buried_elsewhere_main, 1, 5, WORKERS | UNTIL_OWNER_ENDS},
	{"spinner", spinner_main, 0, 1, OWNER | UNTIL_OWNER_ENDS},
	{"outside", outside_main, 1, 1, WORKERS},
	{"destroy runs all", destroy_main, 1, 1, BOTH},
	{"loop", loop_main, 1, 2, BOTH},
	{"loop", loop_main, 1, 3, BOTH},
	{"cancel", cancel_main, 1, 1, WORKERS},
	{"cancel a group", cancel_group_main, 1, 2, BOTH},
	{"wait", wait_main, 1, 1, BOTH},
	{"wait", wait_main, 1, 2, BOTH},
	{"pinned to the owner", pinned_owner_main, 1, 2, BOTH},
	{"loops", loops_main, 1, 2, BOTH},
	{"after a group that goes", after_gone_main, 1, 2, BOTH},
	{"after", after_main, 1, 2, BOTH},
	{"destroy runs children", destroy_child_main, 1, 2, BOTH},
	{"destroy runs children", destroy_child_main, 1, 3, BOTH},
	{"nested wait", nested_main, 1, 2, BOTH},
	{"array", array_main, 1, 2, BOTH | UNTIL_OWNER_ENDS | TSO},
	{"after a group used again", after_again_main, 1, 4,
     BOTH | UNTIL_OWNER_ENDS | IN_ORDER}, /* 1,900,000 states on TSO */
	{"submit wakes", submit_main, 2, 1,
     WORKERS | UNTIL_OWNER_ENDS | IN_ORDER}, /* 6,000,000 states, 11,000,000 on TSO */
};

enum { STATES_MAX = 12000000 };

static model_arguments arguments;

static model_result explore(const scenario *s)
{
	with.workers = s->workers;
	with.jobs = s->jobs;
	with.stays = s->who & UNTIL_OWNER_ENDS;
	threads_of_a_team = s->who & TEAMS ? 1 : 8;
	no_threads = s->who & NO_THREADS;
	worker_runs = owner_runs = 0;
	model_memory weakest = s->who & IN_ORDER ? MODEL_SC : s->who & TSO ? MODEL_TSO : MODEL_PSO;
	model_scenario model = {.memory = arguments.memory < weakest ? arguments.memory : weakest,
	                        .main = s->main,
	                        .check = s->who & UNTIL_OWNER_ENDS ? all_ran : all_gone,
	                        .data = &shared,
	                        .data_size = sizeof shared,
	                        .main_ends_all = s->who & UNTIL_OWNER_ENDS,
	                        .max_states = STATES_MAX};
	model_result result = model_run(&model, !arguments.must_fail);
	print_message("%-24s %u workers, %u jobs: %8u states %8u steps, path %u: %s\n", s->name, s->workers, s->jobs,
	              result.states, result.steps, result.depth, result.failure ? result.failure : "ends well");
	return result;
}

static void test_scenarios(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++) {
		const scenario *s = &scenarios[i];
		if (!model_chosen(&arguments, s->name))
			continue;
		model_result result = explore(s);
		if (arguments.must_fail && result.failure && result.states < STATES_MAX)
			return; /* with too many states the planted fault has not been found */
		assert_null(result.failure);
		assert_true(!(s->who & WORKERS) || worker_runs > 0);
		assert_true(!(s->who & OWNER) || owner_runs > 0);
	}
	assert_false(arguments.must_fail);
}

int main(int argc, char **argv)
{
	if (!model_available())
		return 77;
	arguments = model_arguments_of(argc, argv);
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_scenarios)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
