/* Graphs of jobs: random graphs against their definition, runs from everywhere, cycles, drawing, failures. */
#include "jobs/job_graph.h"
#include "jobs/job_internal.h"

#include "job_pool_fixture.h"
#include "job_random.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- allocations that fail on demand; linked with -Wl,--wrap= of each of these ----------------------------------- */

/* The number of allocations that succeed before all later ones fail. Relaxed: the counter orders nothing. */
static _Atomic int64_t allocations_to_grant = INT64_MAX;

static bool granted(void)
{
	return atomic_fetch_sub_explicit(&allocations_to_grant, 1, memory_order_relaxed) > 0;
}

static void grant_allocations(int64_t count)
{
	atomic_store_explicit(&allocations_to_grant, count, memory_order_relaxed);
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return granted() ? __real_malloc(size) : NULL;
}

void *__real_realloc(void *block, size_t size);
void *__wrap_realloc(void *block, size_t size);
void *__wrap_realloc(void *block, size_t size)
{
	return granted() ? __real_realloc(block, size) : NULL;
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return granted() ? __real_aligned_alloc(alignment, size) : NULL;
}

/* ---- graphs whose nodes check the order in which they run -------------------------------------------------------- */

enum { MAX_NODES = 4096, MAX_EDGES = 16384 };

typedef struct sample sample;

/* What a node knows. Plain data: the run must order it, and the thread sanitizer sees if it does not. */
typedef struct sample_node {
	sample *of;
	uint32_t first, count; /* its predecessors: of->before[first] and on */
	uint32_t runs;         /* how often it has run */
} sample_node;

struct sample {
	stilb_job_graph *graph;
	uint32_t node_count, edge_count;
	uint32_t turn; /* number of the run in progress */
	sample_node node[MAX_NODES];
	uint32_t before[MAX_EDGES];
	counter ran, wrong;
};

static void sample_run(void *data, uint32_t worker)
{
	sample_node *own = data;
	(void)worker;
	bool right = own->runs + 1 == own->of->turn;
	for (uint32_t i = own->first; i < own->first + own->count; i++)
		right = right && own->of->node[own->of->before[i]].runs == own->of->turn;
	own->runs++;
	if (!right)
		count_up(&own->of->wrong);
	count_up(&own->of->ran);
}

static sample *sample_create(void)
{
	sample *s = calloc(1, sizeof *s);
	assert_non_null(s);
	assert_int_equal(stilb_job_graph_create(&s->graph), 0);
	return s;
}

static void sample_add_node(sample *s)
{
	uint32_t node = UINT32_MAX;
	s->node[s->node_count] = (sample_node){.of = s, .first = s->edge_count};
	assert_int_equal(stilb_job_graph_add_node(s->graph, sample_run, &s->node[s->node_count], NULL, &node), 0);
	assert_int_equal(node, s->node_count);
	s->node_count++;
}

/* An edge from node `before` to the node that was added last. */
static void sample_add_edge(sample *s, uint32_t before)
{
	s->before[s->edge_count++] = before;
	s->node[s->node_count - 1].count++;
	assert_int_equal(stilb_job_graph_add_edge(s->graph, before, s->node_count - 1), 0);
}

static void sample_build(sample *s)
{
	char cycle[8] = "x";
	assert_int_equal(stilb_job_graph_build(s->graph, cycle, sizeof cycle), 0);
	assert_string_equal(cycle, "");
}

/* A graph of `nodes` nodes, each with at most `most` edges from among the `reach` nodes before it. */
static sample *sample_random(uint64_t seed, uint32_t nodes, uint32_t most, uint32_t reach)
{
	sample *s = sample_create();
	for (uint32_t i = 0; i < nodes; i++) {
		sample_add_node(s);
		uint32_t edges = i == 0 ? 0 : (uint32_t)(next_random(&seed) % (most + 1));
		for (uint32_t k = 0; k < edges; k++)
			sample_add_edge(s, i - 1 - (uint32_t)(next_random(&seed) % (i < reach ? i : reach)));
	}
	sample_build(s);
	return s;
}

static void sample_start(sample *s, stilb_job_pool *pool, stilb_job_group *group, uint32_t worker)
{
	s->turn++;
	s->ran = 0;
	if (stilb_job_graph_run(s->graph, pool, group, worker) != 0)
		count_up(&s->wrong);
}

static void sample_check(sample *s)
{
	assert_int_equal(s->ran, s->node_count);
	assert_int_equal(s->wrong, 0);
	for (uint32_t i = 0; i < s->node_count; i++)
		assert_int_equal(s->node[i].runs, s->turn);
}

static void sample_run_once(sample *s, stilb_job_pool *pool)
{
	stilb_job_group group = {0};
	sample_start(s, pool, &group, 0);
	stilb_job_wait(pool, &group, 0);
	sample_check(s);
}

static void sample_destroy(sample *s)
{
	stilb_job_graph_destroy(s->graph);
	free(s);
}

static void test_random_graphs(void **state)
{
	(void)state;
	static const struct {
		uint32_t nodes, most, reach;
	} kinds[] = {{1, 0, 1},  {2, 1, 1},    {300, 1, 1},    {300, 0, 1},
	             {40, 3, 5}, {400, 2, 30}, {1000, 4, 200}, {1500, 1, 9}};
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s);
		for (uint32_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
			sample *graph = sample_random(i + 100 * s.workers, kinds[i].nodes, kinds[i].most, kinds[i].reach);
			for (uint32_t turns = 0; turns < (TEST_TSAN ? 4 : 20); turns++)
				sample_run_once(graph, pool);
			sample_destroy(graph);
		}
		stilb_job_pool_destroy(pool);
	}
}

/* Stages: each node comes after all of the stage before, as joins in the graph say it. With `seed`, some nodes have
 * further edges. */
static sample *sample_stages(const uint32_t *width, uint32_t stages, uint64_t seed)
{
	sample *s = sample_create();
	for (uint32_t stage = 0, begin = 0; stage<stages; begin += stage> 0 ? width[stage - 1] : 0, stage++)
		for (uint32_t i = 0, end = s->node_count; i < width[stage]; i++) {
			sample_add_node(s);
			for (uint32_t before = begin; before < end; before++)
				sample_add_edge(s, before);
			if (seed && end > 0 && next_random(&seed) % 3 == 0)
				sample_add_edge(s, (uint32_t)(next_random(&seed) % end));
		}
	sample_build(s);
	return s;
}

static void test_stages(void **state)
{
	(void)state;
	static const uint32_t width[][5] = {{2, 2},          {1, 3},          {3, 1, 4},
	                                    {2, 3, 2, 3, 2}, {7, 5, 1, 6, 3}, {40, 50, 30, 60, 2}};
	static const uint32_t stages[] = {2, 2, 3, 5, 5, 5};
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s);
		for (uint32_t i = 0; i < 3 * sizeof stages / sizeof *stages; i++) {
			sample *graph = sample_stages(width[i / 3], stages[i / 3], i % 3);
			for (uint32_t turns = 0; turns < 10; turns++)
				sample_run_once(graph, pool);
			sample_destroy(graph);
		}
		stilb_job_pool_destroy(pool);
	}
}

/* One node, many, one: all of the middle becomes ready at once. */
static sample *sample_fan(uint32_t width)
{
	sample *s = sample_create();
	sample_add_node(s);
	for (uint32_t i = 0; i < width; i++) {
		sample_add_node(s);
		sample_add_edge(s, 0);
	}
	sample_add_node(s);
	for (uint32_t i = 0; i < width; i++)
		sample_add_edge(s, 1 + i);
	sample_build(s);
	return s;
}

static void test_many_runs(void **state)
{
	(void)state;
	sample *random = sample_random(7, 60, 3, 20), *fan = sample_fan(37);
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s); /* the same graphs in one pool after the other */
		for (uint32_t turns = 0; turns < (TEST_TSAN ? 100 : 1000); turns++) {
			sample_run_once(random, pool);
			sample_run_once(fan, pool);
		}
		stilb_job_pool_destroy(pool);
	}
	sample_destroy(random);
	sample_destroy(fan);
}

static void test_two_graphs_at_once(void **state)
{
	(void)state;
	sample *a = sample_random(1, 500, 3, 50), *b = sample_fan(200);
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s);
		for (uint32_t turns = 0; turns < 20; turns++) {
			stilb_job_group group = {0};
			sample_start(a, pool, &group, 0);
			sample_start(b, pool, &group, 0);
			stilb_job_wait(pool, &group, 0);
			sample_check(a);
			sample_check(b);
		}
		stilb_job_pool_destroy(pool);
	}
	sample_destroy(a);
	sample_destroy(b);
}

/* A graph may be destroyed as soon as the wait has returned, whatever the other threads still do. */
static void test_destroyed_after_the_wait(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with((shape){.workers = 3});
	for (uint32_t i = 0; i < (TEST_TSAN ? 200 : 2000); i++) {
		sample *s = sample_random(i, 30, 3, 12);
		sample_run_once(s, pool);
		sample_destroy(s);
	}
	stilb_job_pool_destroy(pool);
}

static void test_grows_between_runs(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with((shape){.workers = 2});
	sample *s = sample_create();
	sample_build(s);
	sample_run_once(s, pool); /* no nodes: nothing to wait for */
	for (uint32_t i = 0; i < 70; i++) {
		sample_add_node(s);
		s->node[i].runs = s->turn;
		for (uint32_t k = 0; k < 3 && k < i; k++)
			sample_add_edge(s, i - 1 - k / 2 * (i / 3)); /* some edges twice */
		sample_build(s);
		sample_run_once(s, pool);
	}
	sample_destroy(s);
	stilb_job_pool_destroy(pool);
	stilb_job_graph_destroy(NULL);
}

/* ---- where runs come from ---------------------------------------------------------------------------------------- */

typedef struct starter {
	stilb_job_pool *pool;
	sample *graph;
	stilb_job_group *group;
	bool waits;
} starter;

static void start_from_job(void *data, uint32_t worker)
{
	starter *s = data;
	stilb_job_group own = {0};
	sample_start(s->graph, s->pool, s->waits ? &own : s->group, worker);
	if (s->waits)
		stilb_job_wait(s->pool, &own, worker);
}

static void *start_from_outside(void *data)
{
	starter *s = data;
	sample_start(s->graph, s->pool, s->group, STILB_JOB_OUTSIDE);
	stilb_job_wait(s->pool, s->group, STILB_JOB_OUTSIDE);
	return NULL;
}

static void test_started_anywhere(void **state)
{
	(void)state;
	sample *graph = sample_random(3, 200, 3, 20);
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s);
		for (uint32_t from = 0; from < 4; from++) {
			stilb_job_group group = {0};
			starter start = {.pool = pool, .graph = graph, .group = &group, .waits = from == 1};
			stilb_job_options after = {.after = &(stilb_job_group){0}};
			if (from == 3 && s.workers > 0)
				outside_run(start_from_outside, &start);
			else if (from == 2)
				assert_int_equal(stilb_job_submit_with(pool, start_from_job, &start, &group, &after, 0), 0);
			else
				assert_int_equal(stilb_job_submit(pool, start_from_job, &start, &group, 0), 0);
			stilb_job_wait(pool, &group, 0);
			sample_check(graph);
		}
		stilb_job_pool_destroy(pool);
	}
	sample_destroy(graph);
}

/* A node that runs another graph and waits for it, between two nodes. */
static void test_graph_in_a_node(void **state)
{
	(void)state;
	sample *inner = sample_fan(50);
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_pool *pool = pool_with(s);
		starter start = {.pool = pool, .graph = inner, .waits = true};
		sample *outer = sample_create();
		sample_add_node(outer);
		uint32_t node;
		assert_int_equal(stilb_job_graph_add_node(outer->graph, start_from_job, &start, "inner", &node), 0);
		assert_int_equal(stilb_job_graph_add_edge(outer->graph, 0, node), 0);
		sample_build(outer);
		for (int i = 0; i < 20; i++) {
			sample_run_once(outer, pool);
			sample_check(inner);
		}
		sample_destroy(outer);
		stilb_job_pool_destroy(pool);
	}
	sample_destroy(inner);
}

/* ---- no ready node is kept back ---------------------------------------------------------------------------------- */

typedef struct patient {
	counter ran, wrong;
	uint32_t others;
} patient;

static void patient_wait(void *data, uint32_t worker)
{
	patient *p = data;
	(void)worker;
	if (!await(&p->ran, p->others))
		count_up(&p->wrong);
}

static void patient_count(void *data, uint32_t worker)
{
	(void)worker;
	count_up(&((patient *)data)->ran);
}

static void do_nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

/* The node that starts first returns only when all others have run, so another thread must find them. */
static void test_ready_nodes_are_found(void **state)
{
	(void)state;
	for (uint32_t width = 2; width <= 40; width += 19)
		for (int sources = 0; sources < 2; sources++) {
			stilb_job_pool *pool = pool_with((shape){.workers = 1});
			patient p = {.others = width - 1};
			stilb_job_graph *graph;
			uint32_t node, first = 0;
			assert_int_equal(stilb_job_graph_create(&graph), 0);
			if (!sources)
				assert_int_equal(stilb_job_graph_add_node(graph, do_nothing, NULL, NULL, &first), 0);
			for (uint32_t i = 0; i < width; i++) {
				assert_int_equal(stilb_job_graph_add_node(graph, i ? patient_count : patient_wait, &p, NULL, &node), 0);
				if (!sources)
					assert_int_equal(stilb_job_graph_add_edge(graph, first, node), 0);
			}
			assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
			stilb_job_group group = {0};
			assert_int_equal(stilb_job_graph_run(graph, pool, &group, 0), 0);
			stilb_job_wait(pool, &group, 0);
			assert_int_equal(p.ran, width - 1);
			assert_int_equal(p.wrong, 0);
			stilb_job_graph_destroy(graph);
			stilb_job_pool_destroy(pool);
		}
}

typedef struct passer {
	stilb_job_pool *pool;
	stilb_job_group *group;
	counter nodes;
	uint32_t nodes_before; /* nodes that ran before the job of high priority */
} passer;

static void passer_job(void *data, uint32_t worker)
{
	passer *p = data;
	(void)worker;
	p->nodes_before = count_of(&p->nodes);
}

static void passer_node(void *data, uint32_t worker)
{
	passer *p = data;
	if (count_up(&p->nodes) == 4)
		submit_priority(p->pool, passer_job, p, p->group, STILB_JOB_HIGH, worker);
}

/* A chain of nodes does not keep a job of high priority waiting until it ends, nor a wait for another group. */
static void test_urgent_jobs_come_between(void **state)
{
	(void)state;
	stilb_job_group group = {0};
	passer p = {.pool = pool_with((shape){.workers = 0}), .group = &group};
	stilb_job_graph *graph;
	assert_int_equal(stilb_job_graph_create(&graph), 0);
	for (uint32_t i = 0, node; i < 100; i++) {
		assert_int_equal(stilb_job_graph_add_node(graph, passer_node, &p, NULL, &node), 0);
		if (i > 0)
			assert_int_equal(stilb_job_graph_add_edge(graph, i - 1, i), 0);
	}
	assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
	assert_int_equal(stilb_job_graph_run(graph, p.pool, &group, 0), 0);
	stilb_job_wait(p.pool, &group, 0);
	assert_int_equal(p.nodes, 100);
	assert_int_equal(p.nodes_before, 5);
	stilb_job_graph_destroy(graph);
	stilb_job_pool_destroy(p.pool);
}

/* ---- cancelled pools --------------------------------------------------------------------------------------------- */

typedef struct canceller {
	stilb_job_pool *pool;
	stilb_job_group *group; /* cancelled instead of the pool, unless NULL */
	counter ran, dropped;
} canceller;

static canceller *canceller_of_drops;

static void count_drop(void *data, uint32_t worker)
{
	(void)data, (void)worker;
	count_up(&canceller_of_drops->dropped);
}

static void cancel_node(void *data, uint32_t worker)
{
	canceller *c = data;
	(void)worker;
	if (count_up(&c->ran) != 5)
		return;
	if (c->group)
		stilb_job_group_cancel(c->pool, c->group);
	else
		stilb_job_pool_cancel(c->pool);
}

static void test_cancelled(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		canceller c = {.pool = pool_with(s)};
		canceller_of_drops = &c;
		stilb_job_graph *graph;
		uint32_t node;
		assert_int_equal(stilb_job_graph_create(&graph), 0);
		for (uint32_t i = 0; i < 100; i++) {
			assert_int_equal(stilb_job_graph_add_node(graph, cancel_node, &c, NULL, &node), 0);
			if (i > 0)
				assert_int_equal(stilb_job_graph_add_edge(graph, i - 1, i), 0);
		}
		assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
		for (int i = 0; i < 4; i++) {
			stilb_job_group group = {.dropped = count_drop};
			c.group = i < 2 ? &group : NULL; /* first the group alone, and so anew each time */
			c.ran = i < 3 ? 0 : c.ran;
			assert_int_equal(stilb_job_graph_run(graph, c.pool, &group, 0), 0);
			stilb_job_wait(c.pool, &group, 0);
			assert_int_equal(c.ran, 6); /* the nodes up to the one that cancelled; the last time none */
			assert_int_equal(c.dropped, 0);
		}
		stilb_job_graph_destroy(graph);
		stilb_job_pool_destroy(c.pool);
	}
}

/* ---- cycles ------------------------------------------------------------------------------------------------------ */

static stilb_job_graph *graph_of(const char *const *names, uint32_t nodes, const uint32_t (*edges)[2], uint32_t count)
{
	stilb_job_graph *graph;
	assert_int_equal(stilb_job_graph_create(&graph), 0);
	for (uint32_t i = 0, node; i < nodes; i++)
		assert_int_equal(stilb_job_graph_add_node(graph, sample_run, NULL, names ? names[i] : NULL, &node), 0);
	for (uint32_t i = 0; i < count; i++)
		assert_int_equal(stilb_job_graph_add_edge(graph, edges[i][0], edges[i][1]), 0);
	return graph;
}

/* A cycle may be named from any of its nodes: `expected` is the cycle twice, so that it contains every rotation. */
static void check_cycle(const char *const *names, uint32_t nodes, const uint32_t (*edges)[2], uint32_t count,
                        size_t length, const char *expected)
{
	char cycle[100];
	memset(cycle, 'x', sizeof cycle);
	stilb_job_graph *graph = graph_of(names, nodes, edges, count);
	assert_int_equal(stilb_job_graph_build(graph, cycle, sizeof cycle), -ELOOP);
	assert_int_equal(strlen(cycle), length);
	if (!strstr(expected, cycle))
		fail_msg("'%s' is not in '%s'", cycle, expected);
	assert_int_equal(stilb_job_graph_build(graph, NULL, 0), -ELOOP);
	char little[5] = "yyyyy";
	assert_int_equal(stilb_job_graph_build(graph, little, 4), -ELOOP);
	assert_int_equal(strlen(little), 3);
	assert_int_equal(little[4], 'y');
	assert_memory_equal(little, cycle, 3);
	stilb_job_graph_destroy(graph);
}

static void test_cycles_are_named(void **state)
{
	(void)state;
	static const char *const names[] = {"ab", "cd", "ef", "gh", "ij", "kl"};
	check_cycle(names, 1, (const uint32_t[][2]){{0, 0}}, 1, 8, "ab -> ab");
	check_cycle(NULL, 2, (const uint32_t[][2]){{0, 1}, {1, 0}}, 2, 14, "#0 -> #1 -> #0 -> #1");
	/* before, in and after a cycle of three, whose direction is that of the edges */
	check_cycle(names, 6, (const uint32_t[][2]){{0, 1}, {3, 4}, {1, 3}, {4, 1}, {4, 5}, {0, 5}, {2, 4}}, 7, 20,
	            "cd -> gh -> ij -> cd -> gh -> ij");
	/* a node behind the cycle has the lowest number */
	check_cycle(names, 4, (const uint32_t[][2]){{2, 1}, {1, 2}, {1, 0}, {0, 3}}, 4, 14, "cd -> ef -> cd -> ef");
}

static void test_cycle_in_random_graphs(void **state)
{
	(void)state;
	for (uint64_t seed = 0; seed < 300; seed++) {
		uint64_t random = seed;
		uint32_t nodes = 2 + (uint32_t)(next_random(&random) % 30);
		uint32_t edges[100][2], count = 20 + (uint32_t)(next_random(&random) % 60);
		bool linked[32][32] = {0};
		for (uint32_t i = 0; i < count; i++) {
			edges[i][0] = (uint32_t)(next_random(&random) % nodes);
			edges[i][1] = (uint32_t)(next_random(&random) % nodes);
			if (seed % 2 && edges[i][0] >= edges[i][1]) { /* every other graph has no cycle */
				edges[i][0] = 0;
				edges[i][1] = 1;
			}
			linked[edges[i][0]][edges[i][1]] = true;
		}
		char cycle[1000];
		stilb_job_graph *graph = graph_of(NULL, nodes, edges, count);
		int error = stilb_job_graph_build(graph, cycle, sizeof cycle);
		/* The reference: the transitive closure of the edges (Warshall, Journal of the ACM 9(1), 1962). */
		bool reach[32][32];
		memcpy(reach, linked, sizeof reach);
		for (uint32_t k = 0; k < nodes; k++)
			for (uint32_t i = 0; i < nodes; i++)
				for (uint32_t j = 0; j < nodes; j++)
					reach[i][j] = reach[i][j] || (reach[i][k] && reach[k][j]);
		bool circular = false;
		for (uint32_t i = 0; i < nodes; i++)
			circular = circular || reach[i][i];
		assert_int_equal(error, circular ? -ELOOP : 0);
		if (circular) {
			unsigned first, at, next, named = 0;
			int used;
			assert_int_equal(sscanf(cycle, "#%u%n", &first, &used), 1);
			at = first;
			for (const char *text = cycle + used; sscanf(text, " -> #%u%n", &next, &used) == 1; text += used, named++) {
				assert_true(next < nodes && linked[at][next]);
				at = next;
			}
			assert_int_equal(at, first);
			assert_in_range(named, 1, nodes);
		}
		stilb_job_graph_destroy(graph);
	}
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* Reads the string in quotes at `text` and undoes its escapes; returns the end. */
static const char *read_quoted(const char *text, char *out)
{
	assert_int_equal(*text++, '"');
	for (; *text != '"'; text++) {
		assert_true((unsigned char)*text >= ' ');
		bool escaped = *text == '\\';
		text += escaped;
		*out++ = (char)(escaped && *text == 'n' ? '\n' : *text);
	}
	*out = '\0';
	return text + 1;
}

static void test_dot_reads_back(void **state)
{
	(void)state;
	static const char *const names[] = {"plain", "with \"quotes\"", "back\\slash\\n", "two\nlines", "", "\xc3\xa4"};
	static const uint32_t edges[][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {3, 3}, {0, 5}, {0, 5}};
	stilb_job_graph *graph = graph_of(names, 6, edges, 7);
	uint32_t node;
	assert_int_equal(stilb_job_graph_add_node(graph, sample_run, NULL, NULL, &node), 0);
	char *text = NULL;
	size_t size;
	FILE *out = open_memstream(&text, &size);
	assert_non_null(out);
	stilb_job_graph_write_dot(graph, out);
	fclose(out);
	const char *at = text;
	int used = 0;
	sscanf(at, "digraph {%n", &used);
	assert_int_equal(used, 9);
	at += used;
	for (uint32_t i = 0; i < 7; i++) {
		unsigned number;
		char name[100];
		assert_int_equal(sscanf(at, " n%u [label=%n", &number, &used), 1);
		assert_int_equal(number, i);
		at = read_quoted(at + used, name);
		assert_string_equal(name, i < 6 ? names[i] : "#6");
		assert_memory_equal(at, "];\n", 3);
		at += 3;
	}
	for (uint32_t i = 0; i < 7; i++) {
		unsigned before, after;
		assert_int_equal(sscanf(at, " n%u -> n%u;%n", &before, &after, &used), 2);
		assert_int_equal(before, edges[i][0]);
		assert_int_equal(after, edges[i][1]);
		at += used;
	}
	assert_string_equal(at, "\n}\n");
	free(text);
	stilb_job_graph_destroy(graph);
}

/* ---- hooks ------------------------------------------------------------------------------------------------------- */

enum { HOOKED = 50 };

typedef struct hook_log {
	counter submits, begins, ends, node_begins, node_ends, wrong;
	uint64_t open_tag[MOST_THREADS]; /* of the job that the thread is in, plus one; each thread has its own */
	bool in_node[MOST_THREADS];
	uint32_t begun[HOOKED]; /* by node */
	uint32_t tags[1000];    /* how often a tag began */
} hook_log;

static uint64_t on_submit(void *user, uint32_t worker)
{
	(void)worker;
	return count_up(&((hook_log *)user)->submits);
}

static void on_job_begin(void *user, uint32_t worker, uint64_t tag)
{
	hook_log *log = user;
	count_up(&log->begins);
	if (log->open_tag[worker] || tag >= 1000 || log->tags[tag]++)
		count_up(&log->wrong);
	log->open_tag[worker] = tag + 1;
}

static void on_job_end(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->ends);
	if (!log->open_tag[worker] || log->in_node[worker])
		count_up(&log->wrong);
	log->open_tag[worker] = 0;
}

static void on_node_begin(void *user, uint32_t worker, const char *name, void **memo)
{
	hook_log *log = user;
	count_up(&log->node_begins);
	unsigned number = HOOKED;
	if (sscanf(name, "node %u", &number) != 1 || number >= HOOKED || !log->open_tag[worker])
		count_up(&log->wrong);
	else if (*memo != (log->begun[number] ? &log->begun[number] : NULL))
		count_up(&log->wrong);
	else
		*memo = &log->begun[number];
	log->begun[number < HOOKED ? number : 0]++;
	log->in_node[worker] = true;
}

static void on_node_end(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->node_ends);
	if (!log->in_node[worker])
		count_up(&log->wrong);
	log->in_node[worker] = false;
}

static void test_hooks(void **state)
{
	(void)state;
	enum { TURNS = 4 };
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		hook_log log = {0};
		stilb_job_pool *pool = pool_with_hooks(s, (stilb_job_hooks){.user = &log,
		                                                            .submit = on_submit,
		                                                            .job_begin = on_job_begin,
		                                                            .job_end = on_job_end,
		                                                            .node_begin = on_node_begin,
		                                                            .node_end = on_node_end});
		patient p = {0};
		stilb_job_graph *graph;
		uint64_t random = s.workers;
		assert_int_equal(stilb_job_graph_create(&graph), 0);
		for (uint32_t i = 0; i < HOOKED; i++) {
			char name[16];
			uint32_t node;
			snprintf(name, sizeof name, "node %u", i);
			assert_int_equal(stilb_job_graph_add_node(graph, patient_count, &p, i % 5 ? name : NULL, &node), 0);
			for (uint32_t k = 0; i > 0 && k < 2; k++)
				assert_int_equal(stilb_job_graph_add_edge(graph, (uint32_t)(next_random(&random) % i), i), 0);
		}
		assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
		for (uint32_t turn = 0; turn < TURNS; turn++) {
			stilb_job_group group = {0};
			assert_int_equal(stilb_job_graph_run(graph, pool, &group, 0), 0);
			stilb_job_wait(pool, &group, 0);
		}
		stilb_job_pool_destroy(pool);
		assert_int_equal(p.ran, TURNS * HOOKED);
		assert_int_equal(log.submits, TURNS * HOOKED); /* each node is one job */
		assert_int_equal(log.begins, TURNS * HOOKED);
		assert_int_equal(log.ends, TURNS * HOOKED);
		assert_int_equal(log.node_begins, TURNS * (HOOKED - HOOKED / 5));
		assert_int_equal(log.node_ends, TURNS * (HOOKED - HOOKED / 5));
		for (uint32_t i = 0; i < HOOKED; i++)
			assert_int_equal(log.begun[i], i % 5 ? TURNS : 0);
		assert_int_equal(log.wrong, 0);
		stilb_job_graph_destroy(graph);
	}
}

/* ---- out of memory ----------------------------------------------------------------------------------------------- */

/* Whatever call fails, and wherever in it: tried again, it succeeds, and the graph runs as if nothing had happened. */
static void test_making_without_memory(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with((shape){.workers = 1});
	uint32_t failures = 0;
	stilb_job_graph *graph = (stilb_job_graph *)&failures;
	grant_allocations(0);
	assert_int_equal(stilb_job_graph_create(&graph), -ENOMEM);
	assert_null(graph);
	grant_allocations(INT64_MAX);
	assert_int_equal(stilb_job_graph_create(&graph), 0);
	patient p = {0};
	for (uint32_t i = 0; i < 40; i++) {
		uint32_t node = UINT32_MAX;
		for (int64_t grant = 0; grant < 4 && node == UINT32_MAX; grant++) {
			grant_allocations(grant);
			int error = stilb_job_graph_add_node(graph, patient_count, &p, "n", &node);
			grant_allocations(INT64_MAX);
			failures += error == -ENOMEM;
			assert_true(error == 0 || (error == -ENOMEM && node == UINT32_MAX));
		}
		assert_int_equal(node, i);
		for (uint32_t before = 0; before < i; before += 7) {
			grant_allocations(0);
			int error = stilb_job_graph_add_edge(graph, before, i);
			grant_allocations(INT64_MAX);
			failures += error == -ENOMEM;
			if (error)
				assert_int_equal(stilb_job_graph_add_edge(graph, before, i), 0);
		}
	}
	grant_allocations(0);
	assert_int_equal(stilb_job_graph_build(graph, NULL, 0), -ENOMEM);
	grant_allocations(INT64_MAX);
	assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
	stilb_job_group group = {0};
	assert_int_equal(stilb_job_graph_run(graph, pool, &group, 0), 0);
	stilb_job_wait(pool, &group, 0);
	assert_int_equal(p.ran, 40);
	assert_true(failures >= 45); /* 40 names, and the arrays as they grow */
	stilb_job_graph_destroy(graph);
	stilb_job_pool_destroy(pool);
}

/* Takes all records of the owner but `spare`: they hold jobs that start after `gate`. No memory must be granted. */
static void hold_records(stilb_job_pool *pool, stilb_job_group *gate, uint32_t spare)
{
	stilb_job_options options = {.after = gate};
	uint32_t records = 0;
	job_group_add(gate, 1);
	while (stilb_job_submit_with(pool, do_nothing, NULL, NULL, &options, 0) == 0)
		records++;
	assert_true(records >= spare);
	job_group_finish(&pool->slot[0], gate, 1);
	while (job_work_help(&pool->slot[0], &job_scope_all, NULL))
		;
	job_group_add(gate, 1);
	for (uint32_t i = spare; i < records; i++)
		assert_int_equal(stilb_job_submit_with(pool, do_nothing, NULL, NULL, &options, 0), 0);
}

/* Runs with few records, fewer than there are nodes ready at the same time: either nothing starts, or all nodes run in
 * order. */
static void test_running_without_memory(void **state)
{
	(void)state;
	sample *graphs[] = {sample_fan(300), sample_random(4, 400, 3, 60), sample_random(9, 500, 1, 3)};
	for (uint32_t workers = 0; workers <= 2; workers++)
		for (uint32_t i = 0; i < 3; i++)
			for (uint32_t spare = 0; spare < 6; spare++) {
				blocker held = {0};
				stilb_job_group gate = {0}, group = {0}, holding = {0};
				stilb_job_pool *pool = pool_with((shape){.workers = workers});
				if (workers > 0) /* so that no worker takes one of the records meanwhile */
					hold_workers(pool, &held, &holding, 1, workers);
				submit_pinned(pool, do_nothing, NULL, NULL, 0, 0); /* so that the owner has records */
				assert_int_equal(stilb_job_run_pinned(pool, 0), 1);
				grant_allocations(0);
				hold_records(pool, &gate, spare);
				blocker_release(&held);
				graphs[i]->turn += spare > 0;
				graphs[i]->ran = spare > 0 ? 0 : graphs[i]->node_count;
				assert_int_equal(stilb_job_graph_run(graphs[i]->graph, pool, &group, 0), spare > 0 ? 0 : -ENOMEM);
				stilb_job_wait(pool, &group, 0);
				grant_allocations(INT64_MAX);
				stilb_job_wait(pool, &holding, 0);
				sample_check(graphs[i]);
				job_group_finish(&pool->slot[0], &gate, 1);
				stilb_job_pool_destroy(pool);
			}
	for (size_t i = 0; i < sizeof graphs / sizeof *graphs; i++)
		sample_destroy(graphs[i]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_random_graphs),
		cmocka_unit_test(test_stages),
		cmocka_unit_test(test_many_runs),
		cmocka_unit_test(test_destroyed_after_the_wait),
		cmocka_unit_test(test_two_graphs_at_once),
		cmocka_unit_test(test_grows_between_runs),
		cmocka_unit_test(test_started_anywhere),
		cmocka_unit_test(test_graph_in_a_node),
		cmocka_unit_test(test_ready_nodes_are_found),
		cmocka_unit_test(test_urgent_jobs_come_between),
		cmocka_unit_test(test_cancelled),
		cmocka_unit_test(test_cycles_are_named),
		test_one_thread(test_cycle_in_random_graphs),
		cmocka_unit_test(test_dot_reads_back),
		cmocka_unit_test(test_hooks),
		cmocka_unit_test(test_making_without_memory),
		cmocka_unit_test(test_running_without_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
