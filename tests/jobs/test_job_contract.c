/* Calls that break a rule of the job headers on purpose: each must end in an assert with the expected text. */
#include "jobs/job_graph.h"
#include "jobs/job_internal.h"
#include "jobs/job_spsc.h"
#include "jobs/range/job_range.h"
#include "jobs/range/job_sort.h"
#include "support/contract.h"
#include "support/test.h"

/* ---- calls inside an allocation; linked with -Wl,--wrap=malloc,--wrap=aligned_alloc ------------------------------ */

static void (*inside_allocation)(void);

static void allocation_begins(void)
{
	void (*call)(void) = inside_allocation;
	inside_allocation = NULL;
	if (call)
		call();
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	allocation_begins();
	return __real_malloc(size);
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	allocation_begins();
	return __real_aligned_alloc(alignment, size);
}

/* ---- allocators -------------------------------------------------------------------------------------------------- */

static const stilb_job_allocator c_library;

/* Blocks at every eighth byte. */
static void *allocate_anywhere(void *user, size_t size, size_t alignment)
{
	char *block = aligned_alloc(alignment, (size + 2 * alignment - 1) / alignment * alignment);
	(void)user;
	return block + 8;
}

static void keep(void *user, void *block, size_t size)
{
	(void)user;
	(void)block;
	(void)size;
}

static int create_anywhere(void)
{
	stilb_job_allocator anywhere = {.allocate = allocate_anywhere, .release = keep};
	stilb_job_pool_desc desc = {.allocator = &anywhere};
	stilb_job_pool *pool;
	return stilb_job_pool_create(&desc, &pool);
}

static void an_allocator_aligns(void **state)
{
	(void)state;
	contract_breaks("the allocator returns aligned blocks", create_anywhere());
}

/* ---- the pool ---------------------------------------------------------------------------------------------------- */

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	stilb_job_pool *pool = NULL;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		_exit(0);
	return pool;
}

static void nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

static void no_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin;
	(void)end;
	(void)worker;
	(void)context;
}

static void a_call_takes_the_callers_index(void **state)
{
	(void)state;
	contract_breaks("the calling thread's own index", stilb_job_submit(pool_of(1), nothing, NULL, NULL, 1));
	contract_breaks("the index of a thread of the pool", stilb_job_submit(pool_of(1), nothing, NULL, NULL, 2));
	contract_breaks("a thread of the pool passes its index",
	                (stilb_job_parallel_for(pool_of(0), 1, 1, no_slice, NULL, STILB_JOB_OUTSIDE), 0));
	contract_breaks("the calling thread's own index", stilb_job_run_pinned(pool_of(1), 1));
}

static void *submit_as_owner(void *pool)
{
	stilb_job_submit(pool, nothing, NULL, NULL, 0);
	return NULL;
}

static void *destroy(void *pool)
{
	stilb_job_pool_destroy(pool);
	return NULL;
}

static void on_another_thread(void *(*fn)(void *), stilb_job_pool *pool)
{
	pthread_t thread;
	if (pthread_create(&thread, NULL, fn, pool) == 0)
		pthread_join(thread, NULL);
}

static void the_owner_is_one_thread(void **state)
{
	(void)state;
	contract_breaks("the calling thread's own index", (on_another_thread(submit_as_owner, pool_of(0)), 0));
	contract_breaks("destroyed by its owner", (on_another_thread(destroy, pool_of(0)), 0));
}

static void destroy_pool(void *data, uint32_t worker)
{
	(void)worker;
	stilb_job_pool_destroy(data);
}

static void destroy_inside_a_job(void)
{
	stilb_job_pool *pool = pool_of(0);
	stilb_job_group group = {0};
	stilb_job_submit(pool, destroy_pool, pool, &group, 0);
	stilb_job_wait(pool, &group, 0);
}

static void a_pool_is_destroyed_outside_of_jobs(void **state)
{
	(void)state;
	contract_breaks("not from inside a job", (destroy_inside_a_job(), 0));
}

static void statistics_are_told_of_threads(void **state)
{
	(void)state;
	stilb_job_thread_stats stats;
	contract_breaks("the index of a thread of the pool", (stilb_job_pool_get_thread_stats(pool_of(1), 2, &stats), 0));
	contract_breaks("pool && stats", (stilb_job_pool_get_stats(pool_of(0), NULL), 0));
}

static void settings_are_told_of_workers(void **state)
{
	(void)state;
	stilb_job_worker_info info;
	contract_breaks("the index of a worker", (stilb_job_pool_worker_info(pool_of(1), 0, &info), 0));
	contract_breaks("the index of a worker", (stilb_job_pool_worker_info(pool_of(1), 2, &info), 0));
	contract_breaks("desc", (bool)stilb_job_pool_desc_error(NULL));
}

static void a_phase_ends_after_it_has_begun(void **state)
{
	(void)state;
	contract_breaks("a phase ends after it has begun", (stilb_job_phase_end(pool_of(0)), 0));
}

static void a_job_has_a_function(void **state)
{
	(void)state;
	contract_breaks("a job has a function", stilb_job_submit(pool_of(0), NULL, NULL, NULL, 0));
	contract_breaks("a job has a function", stilb_job_submit_array(pool_of(0), 8, 1, NULL, NULL, NULL, 0));
	contract_breaks("fn", (stilb_job_parallel_for(pool_of(0), 8, 1, NULL, NULL, 0), 0));
}

static void a_reduction_is_whole(void **state)
{
	(void)state;
	int value = 0;
	stilb_job_reduction none = {.size = sizeof value, .identity = &value};
	contract_breaks("a reduction is whole", stilb_job_reduce(pool_of(0), 8, 1, &none, &value, 0));
	contract_breaks("fn", (stilb_job_parallel_for_64(pool_of(0), 8, 1, NULL, NULL, 0), 0));
	contract_breaks("fn", (stilb_job_parallel_for_tiles(pool_of(0), 8, 8, 1, 1, NULL, NULL, 0), 0));
}

static int all_equal(const void *a, const void *b, void *context)
{
	(void)a;
	(void)b;
	(void)context;
	return 0;
}

static void a_sort_has_elements_and_their_order(void **state)
{
	(void)state;
	int values[2] = {0};
	contract_breaks("pool && compare", stilb_job_sort(NULL, values, 2, sizeof *values, all_equal, NULL, 0));
	contract_breaks("pool && compare", stilb_job_sort(pool_of(0), values, 2, sizeof *values, NULL, NULL, 0));
	contract_breaks("base || count == 0", stilb_job_sort(pool_of(0), NULL, 2, sizeof *values, all_equal, NULL, 0));
	contract_breaks("an element has a size", stilb_job_sort(pool_of(0), values, 2, 0, all_equal, NULL, 0));
	contract_breaks("the array is an object", stilb_job_sort(pool_of(0), values, SIZE_MAX / 2, 4, all_equal, NULL, 0));
}

/* ---- graphs ------------------------------------------------------------------------------------------------------ */

/* A graph of one node. */
static stilb_job_graph *graph_of(bool built)
{
	stilb_job_graph *graph;
	uint32_t node;
	if (stilb_job_graph_create(&graph) != 0 || stilb_job_graph_add_node(graph, nothing, NULL, NULL, &node) != 0 ||
	    (built && stilb_job_graph_build(graph, NULL, 0) != 0))
		_exit(0);
	return graph;
}

static int run_graph(stilb_job_graph *graph)
{
	static stilb_job_group group;
	return stilb_job_graph_run(graph, pool_of(0), &group, 0);
}

static stilb_job_graph *running_graph(void)
{
	stilb_job_graph *graph = graph_of(true);
	if (run_graph(graph) != 0) /* nobody waits, and the pool has no worker: it has not ended */
		_exit(0);
	return graph;
}

static void a_graph_runs_once_at_a_time(void **state)
{
	(void)state;
	uint32_t node;
	contract_breaks("one thread at a time", run_graph(running_graph()));
	contract_breaks("destroyed when no run is in progress", (stilb_job_graph_destroy(running_graph()), 0));
	contract_breaks("changed when no run is in progress",
	                stilb_job_graph_add_node(running_graph(), nothing, NULL, NULL, &node));
	contract_breaks("changed when no run is in progress", stilb_job_graph_add_edge(running_graph(), 0, 0));
	contract_breaks("built when no run is in progress", stilb_job_graph_build(running_graph(), NULL, 0));
}

static int run_after_change(void)
{
	stilb_job_graph *graph = graph_of(true);
	uint32_t node;
	if (stilb_job_graph_add_node(graph, nothing, NULL, NULL, &node) != 0)
		_exit(0);
	return run_graph(graph);
}

static int run_after_edge(void)
{
	stilb_job_graph *graph = graph_of(true);
	if (stilb_job_graph_add_edge(graph, 0, 0) != 0)
		_exit(0);
	return run_graph(graph);
}

static int run_with_cycle(void)
{
	stilb_job_graph *graph = graph_of(true);
	if (stilb_job_graph_add_edge(graph, 0, 0) != 0 || stilb_job_graph_build(graph, NULL, 0) == 0)
		_exit(0);
	return run_graph(graph);
}

static void a_graph_is_built_before_it_runs(void **state)
{
	(void)state;
	uint32_t node;
	contract_breaks("built since its last change", run_graph(graph_of(false)));
	contract_breaks("built since its last change", run_after_change());
	contract_breaks("built since its last change", run_after_edge());
	contract_breaks("built since its last change", run_with_cycle());
	contract_breaks("numbers of nodes of this graph", stilb_job_graph_add_edge(graph_of(true), 0, 1));
	contract_breaks("numbers of nodes of this graph", stilb_job_graph_add_edge(graph_of(true), 1, 0));
	contract_breaks("fn", stilb_job_graph_add_node(graph_of(true), NULL, NULL, NULL, &node));
	contract_breaks("group", stilb_job_graph_run(graph_of(true), pool_of(0), NULL, 0));
	contract_breaks("cycle || size == 0", stilb_job_graph_build(graph_of(true), NULL, 1));
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

static void run_in_group(uint64_t state)
{
	stilb_job_pool *pool = pool_of(0);
	stilb_job_group group = {.state = state};
	stilb_job_submit(pool, nothing, NULL, &group, 0);
	stilb_job_wait(pool, &group, 0);
}

static void wait_as_outsider(void)
{
	stilb_job_pool *pool = pool_of(0);
	stilb_job_group group = {0};
	stilb_job_submit(pool, nothing, NULL, &group, 0);
	stilb_job_wait(pool, &group, STILB_JOB_OUTSIDE);
}

static void finish_what_has_not_begun(void)
{
	stilb_job_group group = {0};
	job_group_finish(&pool_of(0)->slot[0], &group, 1);
}

static void groups_are_whole(void **state)
{
	(void)state;
	contract_breaks("was the group zero-initialised?", (run_in_group(UINT32_MAX), 0));
	contract_breaks("all jobs and waits of a group are in one pool", (run_in_group((uint64_t)7 << 32), 0));
	contract_breaks("a thread of the pool waits with its index", (wait_as_outsider(), 0));
	contract_breaks("a job finishes once", (finish_what_has_not_begun(), 0));
}

/* ---- queues ------------------------------------------------------------------------------------------------------ */

static stilb_job_queue *queue;
static stilb_job_spsc *spsc;
static int item;

static void queue_create(stilb_job_queue_kind kind)
{
	stilb_job_queue_desc desc = {.kind = kind, .capacity = SIZE_MAX, .thread_count = 2};
	if (stilb_job_queue_create(&desc, &queue) != 0)
		_exit(0);
}

static void push_with_number(uint32_t thread)
{
	queue_create(STILB_JOB_QUEUE_LOCK_FREE);
	stilb_job_queue_push(queue, &item, thread);
}

static void pop_with_number_0(void)
{
	void *popped;
	stilb_job_queue_pop(queue, &popped, 0);
}

/* Imitates two threads with one number: the second call is made while the first one allocates a segment. */
static void use_a_number_twice(void)
{
	queue_create(STILB_JOB_QUEUE_LOCK_FREE);
	inside_allocation = pop_with_number_0;
	while (inside_allocation)
		stilb_job_queue_push(queue, &item, 0);
}

static void thread_numbers_of_a_queue(void **state)
{
	(void)state;
	contract_breaks("thread < queue->thread_count", (push_with_number(2), 0));
	contract_breaks("one thread at a time", (use_a_number_twice(), 0));
}

static void push_item(void)
{
	stilb_job_spsc_push(spsc, &item);
}

static void push_as_two_threads(void)
{
	if (stilb_job_spsc_create(&spsc) != 0)
		_exit(0);
	inside_allocation = push_item;
	while (inside_allocation)
		push_item();
}

static void *wait_for_item(void *data)
{
	void *popped;
	stilb_job_queue_pop_wait(data, &popped, 0, UINT64_MAX);
	return NULL;
}

/* Destroys a queue on which a thread sleeps. */
static void destroy_while_waiting(void)
{
	queue_create(STILB_JOB_QUEUE_LOW_LOCK);
	pthread_t thread;
	if (pthread_create(&thread, NULL, wait_for_item, queue) != 0)
		_exit(0);
	/* Relaxed: only waits until the other thread is counted. */
	while (atomic_load_explicit(&queue->items.waiters, memory_order_relaxed) == 0)
		sched_yield();
	stilb_job_queue_destroy(queue);
}

static void pop_nowhere(stilb_job_queue_kind kind)
{
	queue_create(kind);
	stilb_job_queue_pop(queue, NULL, 0);
}

static void an_end_has_one_thread(void **state)
{
	(void)state;
	contract_breaks("one thread at a time", (push_as_two_threads(), 0));
	contract_breaks("queue && item", stilb_job_spsc_pop(NULL, NULL));
	contract_breaks("queue && item", (pop_nowhere(STILB_JOB_QUEUE_LOW_LOCK), 0));
	contract_breaks("nobody_waits(queue)", (destroy_while_waiting(), 0));
	contract_breaks("queue && item", stilb_job_queue_pop_wait(queue, NULL, 0, UINT64_MAX));
	contract_breaks("queue && item", stilb_job_spsc_pop_wait(NULL, NULL, UINT64_MAX));
}

/* ---- internal parts ---------------------------------------------------------------------------------------------- */

static void take_twice(void)
{
	job_lock lock = {0};
	job_lock_take(&lock);
	job_lock_take(&lock);
}

static void give_free(void)
{
	job_lock lock = {0};
	job_lock_give(&lock);
}

static void a_lock_knows_its_holder(void **state)
{
	(void)state;
	contract_breaks("the lock is not taken twice", (take_twice(), 0));
	contract_breaks("the caller holds the lock", (give_free(), 0));
}

static void push_into_damaged_deque(void)
{
	static job_record record;
	job_deque deque = {0};
	if (job_deque_init(&deque, &c_library) != 0)
		_exit(0);
	deque.top_seen = 1; /* more than top, which it must never exceed */
	job_deque_push(&deque, &record);
}

static void finish_full_deque(void)
{
	static job_record record;
	job_deque deque = {0};
	if (job_deque_init(&deque, &c_library) != 0)
		_exit(0);
	job_deque_push(&deque, &record);
	job_deque_finish(&deque);
}

static void a_deque_is_sound(void **state)
{
	(void)state;
	contract_breaks("job_deque_is_sound(deque)", (push_into_damaged_deque(), 0));
	contract_breaks("a record left here would never run", (finish_full_deque(), 0));
}

static void give_twice(void)
{
	job_record_store store;
	job_record_cache cache = {0};
	job_record_store_init(&store, &c_library);
	job_record *record = job_record_take(&store, &cache);
	job_record_give(&store, &cache, record);
	job_record_give(&store, &cache, record);
}

static void a_record_is_given_back_once(void **state)
{
	(void)state;
	contract_breaks("a record is given back once", (give_twice(), 0));
}

static void enter_twice(void)
{
	static job_idle_list list;
	job_parker parker = {0};
	job_idler idler = {.parker = &parker, .scope.all = true, .worker = true};
	job_idle_init(&list, 2);
	job_idle_enter(&list, &idler, false);
	job_idle_enter(&list, &idler, false);
}

static void enter_miscounted(void)
{
	static job_idle_list list;
	job_parker parker = {0};
	job_idler idler = {.parker = &parker, .scope.all = true, .worker = true};
	job_idle_init(&list, 2);
	list.waiting = 1; /* although the list is empty */
	job_idle_enter(&list, &idler, false);
}

static void stop_spinning_unasked(void)
{
	static job_idle_list list;
	job_idle_init(&list, 2);
	job_idle_spin_stop(&list);
}

static void the_idle_list_is_sound(void **state)
{
	(void)state;
	contract_breaks("a thread is on the list once", (enter_twice(), 0));
	contract_breaks("list_is_sound(list)", (enter_miscounted(), 0));
	contract_breaks("a spinner stops once", (stop_spinning_unasked(), 0));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_allocator_aligns),
		cmocka_unit_test(a_call_takes_the_callers_index),
		cmocka_unit_test(the_owner_is_one_thread),
		cmocka_unit_test(a_pool_is_destroyed_outside_of_jobs),
		cmocka_unit_test(statistics_are_told_of_threads),
		cmocka_unit_test(settings_are_told_of_workers),
		cmocka_unit_test(a_phase_ends_after_it_has_begun),
		cmocka_unit_test(a_job_has_a_function),
		cmocka_unit_test(a_reduction_is_whole),
		cmocka_unit_test(a_sort_has_elements_and_their_order),
		cmocka_unit_test(a_graph_runs_once_at_a_time),
		cmocka_unit_test(a_graph_is_built_before_it_runs),
		cmocka_unit_test(groups_are_whole),
		cmocka_unit_test(thread_numbers_of_a_queue),
		cmocka_unit_test(an_end_has_one_thread),
		cmocka_unit_test(a_lock_knows_its_holder),
		cmocka_unit_test(a_deque_is_sound),
		cmocka_unit_test(a_record_is_given_back_once),
		cmocka_unit_test(the_idle_list_is_sound),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
