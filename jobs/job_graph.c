#include "jobs/job_graph.h"
#include "jobs/job_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/*
 * A run. Each node counts the edges from nodes that have not finished (`pending`). The thread that finishes a node
 * subtracts one from each successor; those that come to 0 are ready. Their numbers go to graph->ready, where every node
 * has a place for as many numbers as it has successors, so that no two threads write to the same place and a set of
 * ready nodes is a range of that array. A job_record holds one such range. The record of the node that has just
 * finished is used again for the nodes which that has made ready; before it runs the first of them, the thread halves
 * the range, and halves the half, and pushes the other halves into its deque as records of their own: every node that
 * is ready and not running can be stolen. So the threads need few records at a time, and a chain of nodes needs one.
 *
 * Without memory for a record nothing is lost: the nodes are chained to the record in hand, and this thread runs them
 * one after the other. So it does in a pool without workers, where nobody could steal them.
 *
 * Where many nodes all come before the same others, as one stage of a frame before the next, a run does not count each
 * of their edges: build puts a node without a function between, a join. The nodes before count down the join alone, and
 * the last of them goes on for it.
 *
 * The thread that brings a count to 0 sets it to the number of edges again, for the next run. No pass over the nodes is
 * needed: the next run begins after the last node has finished, and that is after all of these stores.
 */

#ifndef JOB_GRAPH_MAX_NODES
#define JOB_GRAPH_MAX_NODES ((uint32_t)1 << 30)
#define JOB_GRAPH_MAX_EDGES (((uint32_t)1 << 31) - 1)
#endif

#define NO_NODE UINT32_MAX

/* Set in graph->successor for a node that has no other predecessor, which is ready without counting. */
#define ONLY_EDGE ((uint32_t)1 << 31)

/* A node as add_node has made it. */
typedef struct graph_node {
	stilb_job_fn *fn;
	void *data;
	char *name; /* NULL: none */
	void *memo; /* belongs to the hook node_begin */
} graph_node;

typedef struct graph_edge {
	uint32_t before, after;
} graph_edge;

/* Most nodes have no more successors than this, which then lie in the node itself. */
#ifndef JOB_GRAPH_FEW
#define JOB_GRAPH_FEW 8
#endif

/* A node as a run needs it: a cache line, so that threads that run neighbours do not write to the same one. */
typedef struct job_graph_node {
	stilb_job_fn *fn;
	void *data;
	uint32_t first, end;   /* its successors are graph->successor[first] to [end - 1] */
	uint32_t predecessors; /* number of edges that lead to it */
	/* Edges from nodes that have not finished. Acquire-release by each thread that subtracts: the last one sees what
	 * all the nodes before have written. Of a node in the chain of a record: the next one there, or NO_NODE. */
	_Atomic uint32_t pending;
	uint32_t few[JOB_GRAPH_FEW]; /* the successors, if there are so few */
} job_graph_node;

static_assert(sizeof(job_graph_node) == 32 + JOB_GRAPH_FEW * sizeof(uint32_t), "64 bytes with 8");

struct stilb_job_graph {
	/* The nodes and edges in the order in which they were added. */
	graph_node *node;
	graph_edge *edge;
	uint32_t node_count, node_capacity;
	uint32_t edge_count, edge_capacity;
	bool built; /* since the last change */
	stilb_job_allocator memory;
	/* One block of memory, made by build. The numbers of joins follow those of the nodes. */
	job_graph_node *run;
	uint32_t run_count;  /* nodes and joins */
	uint32_t link_count; /* edges of a run: those from and to joins instead of those that they replace */
	uint32_t *successor; /* link_count numbers of nodes */
	/* One place for each link, and behind them the nodes without predecessors. For build: memory for all nodes. */
	uint32_t *ready;
	uint32_t source_count;  /* nodes without predecessors */
	uint32_t sink_count;    /* nodes without successors */
	stilb_job_group *group; /* of the run in progress */
	job_exclusive running;
	/* Sinks that have not finished. Like job_graph_node.pending: as if one more node came after all of them. */
	alignas(JOB_LINE) _Atomic uint32_t unfinished;
};

/* ---- building -------------------------------------------------------------------------------------------------- */

/* For asserts: no run is in progress. Always true with NDEBUG. */
static bool graph_is_idle(const stilb_job_graph *graph)
{
	return atomic_load_explicit(&graph->running.threads, memory_order_relaxed) == 0; /* as in job_exclusive_begin */
}

int stilb_job_graph_create(stilb_job_graph **graph)
{
	return stilb_job_graph_create_with(NULL, graph);
}

int stilb_job_graph_create_with(const stilb_job_allocator *allocator, stilb_job_graph **out)
{
	assert(out);
	*out = NULL;
	if (!job_allocator_is_whole(allocator))
		return -EINVAL;
	stilb_job_allocator memory = job_allocator_of(allocator);
	stilb_job_graph *graph = job_allocate(&memory, sizeof *graph, JOB_LINE);
	if (!graph)
		return -ENOMEM;
	*graph = (stilb_job_graph){.memory = memory};
	*out = graph;
	return 0;
}

/* The size of the block of memory for runs, in bytes. ready: there are at most as many sources as nodes. Never 0, also
 * for an empty graph. */
static size_t block_size(size_t nodes, size_t links)
{
	return nodes * sizeof(job_graph_node) + (2 * links + nodes + 1) * sizeof(uint32_t);
}

/* The size of a node's name, in bytes; it may be NULL. */
static size_t name_size(const char *name)
{
	return name ? strlen(name) + 1 : 0;
}

void stilb_job_graph_destroy(stilb_job_graph *graph)
{
	if (!graph)
		return;
	JOB_CHECK(graph_is_idle(graph) && "destroyed when no run is in progress");
	stilb_job_allocator memory = graph->memory;
	for (uint32_t i = 0; i < graph->node_count; i++)
		job_release(&memory, graph->node[i].name, name_size(graph->node[i].name));
	job_release(&memory, graph->node, graph->node_capacity * sizeof *graph->node);
	job_release(&memory, graph->edge, graph->edge_capacity * sizeof *graph->edge);
	job_release(&memory, graph->run, block_size(graph->run_count, graph->link_count));
	job_release(&memory, graph, sizeof *graph);
}

/* Makes room for one more element in an array of `count` elements of the given size. 0 or -ENOMEM. */
static int reserve(stilb_job_graph *graph, void **array, uint32_t count, uint32_t *capacity, size_t size)
{
	if (count < *capacity)
		return 0;
	uint32_t wanted = *capacity ? *capacity * 2 : 16;
	void *larger = job_reallocate(&graph->memory, *array, *capacity * size, wanted * size, alignof(graph_node));
	if (!larger)
		return -ENOMEM;
	*array = larger;
	*capacity = wanted;
	return 0;
}

int stilb_job_graph_add_node(stilb_job_graph *graph, stilb_job_fn *fn, void *data, const char *name, uint32_t *node)
{
	assert(graph && fn && node);
	JOB_CHECK(graph_is_idle(graph) && "changed when no run is in progress");
	if (graph->node_count == JOB_GRAPH_MAX_NODES)
		return -EOVERFLOW;
	void *nodes = graph->node;
	int error = reserve(graph, &nodes, graph->node_count, &graph->node_capacity, sizeof *graph->node);
	graph->node = nodes;
	char *copy = name && !error ? job_allocate(&graph->memory, name_size(name), 1) : NULL;
	if (error || (name && !copy))
		return -ENOMEM;
	if (copy)
		memcpy(copy, name, name_size(name));
	graph->node[graph->node_count] = (graph_node){.fn = fn, .data = data, .name = copy};
	*node = graph->node_count++;
	graph->built = false;
	return 0;
}

int stilb_job_graph_add_edge(stilb_job_graph *graph, uint32_t before, uint32_t after)
{
	assert(graph);
	JOB_CHECK(graph_is_idle(graph) && "changed when no run is in progress");
	assert(before < graph->node_count && after < graph->node_count && "numbers of nodes of this graph");
	if (graph->edge_count == JOB_GRAPH_MAX_EDGES)
		return -EOVERFLOW;
	void *edges = graph->edge;
	int error = reserve(graph, &edges, graph->edge_count, &graph->edge_capacity, sizeof *graph->edge);
	graph->edge = edges;
	if (error)
		return error;
	graph->edge[graph->edge_count++] = (graph_edge){.before = before, .after = after};
	graph->built = false;
	return 0;
}

/* Makes the block of memory for runs, in place of the one before. 0 or -ENOMEM. */
static int make_block(stilb_job_graph *graph, size_t nodes, size_t links)
{
	job_graph_node *run = job_allocate(&graph->memory, block_size(nodes, links), JOB_LINE);
	if (!run)
		return -ENOMEM;
	job_release(&graph->memory, graph->run, block_size(graph->run_count, graph->link_count));
	graph->run = run;
	graph->run_count = (uint32_t)nodes;
	graph->link_count = (uint32_t)links;
	graph->successor = (uint32_t *)(run + nodes);
	graph->ready = graph->successor + links;
	return 0;
}

/* Makes graph->run but for pending, and graph->successor, for so many nodes and joins. 0 or -ENOMEM. */
static int link_nodes(stilb_job_graph *graph, uint32_t nodes, const graph_edge *link, uint32_t links)
{
	if (make_block(graph, nodes, links) != 0)
		return -ENOMEM;
	job_graph_node *run = graph->run;
	for (uint32_t i = 0; i < graph->node_count; i++)
		run[i] = (job_graph_node){.fn = graph->node[i].fn, .data = graph->node[i].data};
	for (uint32_t i = graph->node_count; i < nodes; i++)
		run[i] = (job_graph_node){.fn = NULL};
	/* A counting sort of the edges by `before`, which keeps their order. `end` counts the successors, then it ends
	 * those that are stored. */
	for (uint32_t i = 0; i < links; i++) {
		run[link[i].before].end++;
		run[link[i].after].predecessors++;
	}
	for (uint32_t i = 0, first = 0; i < nodes; i++) {
		run[i].first = first;
		first += run[i].end;
		run[i].end = run[i].first;
	}
	for (uint32_t i = 0; i < links; i++)
		graph->successor[run[link[i].before].end++] = link[i].after;
	return 0;
}

/* Subtracts one edge; true if it was the last one. alone: no other thread runs nodes of this graph. */
static inline bool count_down(_Atomic uint32_t *pending, bool alone)
{
	if (!alone)
		/* Release: passes on what the node before has written; acquire: the last one sees that of all. */
		return atomic_fetch_sub_explicit(pending, 1, memory_order_acq_rel) == 1;
	uint32_t left =
		atomic_load_explicit(pending, memory_order_relaxed) - 1; /* relaxed, both: no other thread reads it */
	atomic_store_explicit(pending, left, memory_order_relaxed);
	return left == 0;
}

/* Counts the nodes that a run would reach. Those that it would not have pending > 0 afterwards. Kahn, "Topological
 * Sorting of Large Networks", Communications of the ACM 5(11), 1962. */
static uint32_t count_reachable(stilb_job_graph *graph)
{
	job_graph_node *run = graph->run;
	uint32_t *queue = graph->ready;
	uint32_t reached = 0;
	for (uint32_t i = 0; i < graph->node_count; i++) {
		atomic_init(&run[i].pending, run[i].predecessors);
		if (run[i].predecessors == 0)
			queue[reached++] = i;
	}
	for (uint32_t at = 0; at < reached; at++)
		for (uint32_t i = run[queue[at]].first; i < run[queue[at]].end; i++)
			if (count_down(&run[graph->successor[i]].pending, true))
				queue[reached++] = graph->successor[i];
	return reached;
}

/* Finds a cycle among the nodes with pending > 0, one of which is `from`. Returns a node of it; from there `next` leads
 * round the cycle in the direction of the edges. */
static uint32_t find_cycle(const stilb_job_graph *graph, uint32_t from, uint32_t *next)
{
	/* Each of these nodes waits for another one of them. Going from each to one that it waits for never ends, so it
	 * comes to a cycle. */
	for (uint32_t i = 0; i < graph->edge_count; i++)
		if (atomic_load_explicit(&graph->run[graph->edge[i].before].pending, memory_order_relaxed) > 0)
			next[graph->edge[i].after] = graph->edge[i].before;
	for (uint32_t i = 0; i < graph->node_count; i++)
		from = next[from];
	/* Turns the links round. */
	uint32_t at = from, after = from;
	do {
		uint32_t before = next[at];
		if (at != from)
			next[at] = after;
		after = at;
		at = before;
	} while (at != from);
	next[from] = after;
	return from;
}

/* Appends the node's name, or its number, to the string in text; cuts it to size bytes. */
static void append_name(const stilb_job_graph *graph, uint32_t node, const char *before, char *text, size_t size)
{
	size_t length = strlen(text);
	if (graph->node[node].name)
		snprintf(text + length, size - length, "%s%s", before, graph->node[node].name);
	else
		snprintf(text + length, size - length, "%s#%u", before, node);
}

static void write_cycle(stilb_job_graph *graph, char *text, size_t size)
{
	uint32_t from = 0, *next = graph->ready;
	while (atomic_load_explicit(&graph->run[from].pending, memory_order_relaxed) == 0) /* no other thread uses it */
		from++;
	from = find_cycle(graph, from, next);
	append_name(graph, from, "", text, size);
	uint32_t at = from;
	do {
		at = next[at];
		append_name(graph, at, " -> ", text, size);
	} while (at != from);
}

/* ---- joins ----------------------------------------------------------------------------------------------------- */

/* A place in a hash table of nodes by their lists of successors; node: NO_NODE if it is free. */
typedef struct join_place {
	uint32_t hash, node;
} join_place;

static uint32_t successor_count(const stilb_job_graph *graph, uint32_t node)
{
	return graph->run[node].end - graph->run[node].first;
}

static bool same_successors(const stilb_job_graph *graph, uint32_t a, uint32_t b)
{
	uint32_t count = successor_count(graph, a);
	return successor_count(graph, b) == count &&
	       memcmp(&graph->successor[graph->run[a].first], &graph->successor[graph->run[b].first],
	              count * sizeof *graph->successor) == 0;
}

/* The place of a node with the same successors, in the same order, or else a free one. The table has 2^bits places,
 * more than there are nodes. The hash is that of Fowler, Noll and Vo with another multiplier, of 32 bits at a time. */
static join_place *find_place(const stilb_job_graph *graph, join_place *table, uint32_t bits, uint32_t node)
{
	uint64_t hash = 0;
	for (uint32_t i = graph->run[node].first; i < graph->run[node].end; i++)
		hash = (hash ^ graph->successor[i]) * UINT64_C(0x9E3779B97F4A7C15);
	uint32_t at = (uint32_t)(hash >> (64 - bits)), mask = (uint32_t)((UINT64_C(1) << bits) - 1);
	for (;; at = (at + 1) & mask) {
		join_place *place = &table[at];
		if (place->node == NO_NODE)
			place->hash = (uint32_t)hash;
		if (place->node == NO_NODE || (place->hash == (uint32_t)hash && same_successors(graph, place->node, node)))
			return place;
	}
}

/* For each two or more nodes with the same two or more successors, in the same order: sets join[node] to the number of
 * their join, that of others to NO_NODE, and stores the links from the joins to the successors, no more than they
 * replace. Returns the number of joins, and that of the links in *links. */
static uint32_t make_joins(const stilb_job_graph *graph, join_place *table, uint32_t bits, uint32_t *join,
                           graph_edge *link, uint32_t *links)
{
	uint32_t joins = 0;
	for (uint32_t i = 0; i < graph->node_count; i++) {
		join[i] = NO_NODE;
		if (successor_count(graph, i) < 2)
			continue;
		join_place *place = find_place(graph, table, bits, i);
		if (place->node == NO_NODE) {
			place->node = i;
			continue;
		}
		join[i] = join[place->node];
		if (join[i] != NO_NODE)
			continue;
		join[i] = join[place->node] = graph->node_count + joins++;
		for (uint32_t k = graph->run[i].first; k < graph->run[i].end; k++)
			link[(*links)++] = (graph_edge){join[i], graph->successor[k]};
	}
	return joins;
}

/* Puts joins between nodes that have the same successors, and those. 0 or -ENOMEM. */
static int join_nodes(stilb_job_graph *graph)
{
	uint32_t bits = 1;
	while (UINT64_C(1) << bits < graph->node_count + (uint64_t)graph->node_count / 2)
		bits++;
	size_t table_size = sizeof(join_place) << bits, link_size = (graph->edge_count + (size_t)1) * sizeof(graph_edge);
	join_place *table = job_allocate(&graph->memory, table_size, alignof(join_place));
	graph_edge *link = job_allocate(&graph->memory, link_size, alignof(graph_edge));
	int error = table && link ? 0 : -ENOMEM;
	if (!error)
		memset(table, 0xff, table_size); /* NO_NODE */
	uint32_t links = 0, *join = graph->ready, joins = error ? 0 : make_joins(graph, table, bits, join, link, &links);
	if (joins > 0) {
		for (uint32_t i = 0; i < graph->edge_count; i++)
			if (join[graph->edge[i].before] == NO_NODE)
				link[links++] = graph->edge[i];
		for (uint32_t i = 0; i < graph->node_count; i++)
			if (join[i] != NO_NODE)
				link[links++] = (graph_edge){i, join[i]};
		error = link_nodes(graph, graph->node_count + joins, link, links);
	}
	job_release(&graph->memory, table, table_size);
	job_release(&graph->memory, link, link_size);
	return error;
}

/* Sets what every run finds: the counts, and the nodes to begin with. */
static void prepare_run(stilb_job_graph *graph)
{
	job_graph_node *run = graph->run;
	graph->source_count = graph->sink_count = 0;
	for (uint32_t i = 0; i < graph->run_count; i++) {
		atomic_init(&run[i].pending, run[i].predecessors);
		if (run[i].predecessors == 0)
			graph->ready[graph->link_count + graph->source_count++] = i;
		graph->sink_count += run[i].first == run[i].end;
	}
	for (uint32_t i = 0; i < graph->link_count; i++)
		if (run[graph->successor[i]].predecessors == 1)
			graph->successor[i] |= ONLY_EDGE;
	for (uint32_t i = 0; i < graph->run_count; i++)
		if (run[i].end - run[i].first <= JOB_GRAPH_FEW)
			for (uint32_t k = run[i].first; k < run[i].end; k++)
				run[i].few[k - run[i].first] = graph->successor[k];
	atomic_init(&graph->unfinished, graph->sink_count);
}

int stilb_job_graph_build(stilb_job_graph *graph, char *cycle, size_t size)
{
	assert(graph && (cycle || size == 0));
	JOB_CHECK(graph_is_idle(graph) && "built when no run is in progress");
	if (size > 0)
		cycle[0] = '\0';
	graph->built = false;
	int error = link_nodes(graph, graph->node_count, graph->edge, graph->edge_count);
	if (error)
		return error;
	if (count_reachable(graph) < graph->node_count) {
		if (size > 0)
			write_cycle(graph, cycle, size);
		return -ELOOP;
	}
	error = join_nodes(graph);
	if (error)
		return error;
	prepare_run(graph);
	graph->built = true;
	return 0;
}

/* ---- running --------------------------------------------------------------------------------------------------- */

int stilb_job_graph_run(stilb_job_graph *graph, stilb_job_pool *pool, stilb_job_group *group, uint32_t worker)
{
	assert(graph && pool && group);
	assert(graph->built && "built since its last change");
	if (graph->node_count == 0)
		return 0;
	job_exclusive_begin(&graph->running);
	graph->group = group;
	int error = job_submit_graph(pool, graph, graph->link_count, graph->source_count, group, worker);
	if (error)
		job_exclusive_end(&graph->running);
	return error;
}

static bool record_is_empty(const job_record *record)
{
	return record->count == 0 && record->chain == NO_NODE;
}

/* Puts ready nodes, those of graph->ready[first] and on and a chain, into a record like the given one, for any thread
 * to run. False if there is no memory, or no other thread. */
static bool publish(job_slot *slot, const job_record *like, uint32_t first, uint32_t count, uint32_t chain)
{
	stilb_job_pool *pool = slot->pool;
	job_record *record = pool->worker_count > 0 ? job_record_take(&pool->records, &slot->records) : NULL;
	if (!record)
		return false;
	record->fn = like->fn;
	record->group = NULL;
	record->count = count;
	record->grain = first;
	record->chain = chain;
	record->target = JOB_ANYONE;
	record->priority = STILB_JOB_NORMAL;
	record->kind = JOB_NODES;
	/* Relaxed, both: the push publishes them. slot has the root and level of the given record. */
	atomic_store_explicit(&record->root, slot->root, memory_order_relaxed);
	atomic_store_explicit(&record->level, slot->level, memory_order_relaxed);
	if (pool->hooks.submit)
		record->tag = pool->hooks.submit(pool->hooks.user, slot->index);
	job_count(&slot->submitted, 1);
	job_submit_record(slot, record);
	return true;
}

/* Publishes graph->ready[first] and on, count nodes, in halves, the largest first. Returns how many are left, the first
 * ones, because there is no memory or no other thread. */
static uint32_t publish_range(job_slot *slot, const job_record *like, uint32_t first, uint32_t count)
{
	for (uint32_t half; count > 0; count -= half) {
		half = (count + 1) / 2;
		if (!publish(slot, like, first + count - half, half, NO_NODE))
			break;
	}
	return count;
}

/* Adds a ready node, which no other thread uses now, to the chain of the record. */
static void chain_node(stilb_job_graph *graph, job_record *record, uint32_t node)
{
	atomic_store_explicit(&graph->run[node].pending, record->chain,
	                      memory_order_relaxed); /* no other thread reads it */
	record->chain = node;
}

/* Takes one node out of the record, and publishes the others of its range. */
static job_graph_node *take_node(job_slot *slot, stilb_job_graph *graph, job_record *record)
{
	assert(!record_is_empty(record));
	if (record->count > 0) {
		job_graph_node *node = &graph->run[graph->ready[record->grain++]];
		record->count = publish_range(slot, record, record->grain, record->count - 1);
		return node;
	}
	job_graph_node *node = &graph->run[record->chain];
	record->chain = atomic_load_explicit(&node->pending, memory_order_relaxed); /* see chain_node */
	return node;
}

/* For the next run, which is ordered after this one by its group. Relaxed: nobody counts until then. With a single
 * predecessor nothing is counted, see release_successors. */
static void rearm(job_graph_node *node)
{
	if (node->predecessors > 1)
		atomic_store_explicit(&node->pending, node->predecessors, memory_order_relaxed);
}

/* Subtracts a node from its successors; those that are ready then go to `ready`. Returns their number. If it is 0, the
 * graph may be gone. */
static inline __attribute__((always_inline)) uint32_t
release_successors(stilb_job_graph *graph, const uint32_t *successor, uint32_t count, uint32_t *ready, bool alone)
{
	uint32_t found = 0;
	for (uint32_t i = 0; i < count; i++) {
		/* Stored whether ready or not, so that there is no branch that the CPU could not foresee. */
		uint32_t one = successor[i], number = one & ~ONLY_EDGE;
		ready[found] = number;
		found += one & ONLY_EDGE || count_down(&graph->run[number].pending, alone);
	}
	return found;
}

/* For nodes that have become ready: publishes them, or puts those for which there is no memory or no other thread into
 * the record. `ready` lies in graph->ready or, if there are few nodes, anywhere. */
static void add_ready(job_slot *slot, stilb_job_graph *graph, job_record *record, const uint32_t *ready, uint32_t count)
{
	bool many = count > JOB_GRAPH_FEW;
	if (many) {
		uint32_t first = (uint32_t)(ready - graph->ready);
		count = publish_range(slot, record, first, count);
		if (record_is_empty(record)) {
			record->grain = first;
			record->count = count;
			return;
		}
	}
	for (; count > 0; count--) {
		/* Relaxed: see chain_node; the push publishes it. */
		atomic_store_explicit(&graph->run[ready[count - 1]].pending, NO_NODE, memory_order_relaxed);
		if (many || !publish(slot, record, 0, 0, ready[count - 1]))
			chain_node(graph, record, ready[count - 1]);
	}
}

/* The node has finished, or is dropped. Returns one of those that it has made ready, and publishes the others. NULL:
 * there is none, and unless the record has nodes, the graph may be gone. *last: it was the last one of the run. */
static job_graph_node *leave_node(job_slot *slot, stilb_job_graph *graph, job_record *record,
                                  const job_graph_node *node, bool *last)
{
	bool alone = slot->pool->worker_count == 0;
	uint32_t few[JOB_GRAPH_FEW];
	uint32_t count = node->end - node->first, found;
	if (count == 0) { /* acquire-release, as in count_down */
		*last = atomic_fetch_sub_explicit(&graph->unfinished, 1, memory_order_acq_rel) == 1;
		return NULL;
	}
	for (;; count = node->end - node->first) {
		uint32_t *ready = few;
		if (count <= JOB_GRAPH_FEW) {
			found = release_successors(graph, node->few, count, ready, alone);
		} else {
			ready = graph->ready + node->first;
			found = release_successors(graph, graph->successor + node->first, count, ready, alone);
		}
		if (found == 0)
			return NULL;
		job_graph_node *next = &graph->run[ready[0]];
		if (next->fn) {
			if (found > 1)
				add_ready(slot, graph, record, ready + 1, found - 1);
			return next;
		}
		assert(found == 1 && "a node before a join has no other successor");
		rearm(next);
		node = next;
	}
}

/* Calls the function of a node between the pool's hooks. */
static void call_hooked(job_slot *slot, const job_record *record, const job_graph_node *node)
{
	const stilb_job_hooks *hooks = &slot->pool->hooks;
	graph_node *named = &record->fn.graph->node[node - record->fn.graph->run];
	if (hooks->job_begin)
		hooks->job_begin(hooks->user, slot->index, record->tag);
	if (hooks->node_begin && named->name)
		hooks->node_begin(hooks->user, slot->index, named->name, &named->memo);
	node->fn(node->data, slot->index);
	if (hooks->node_end && named->name)
		hooks->node_end(hooks->user, slot->index);
	if (hooks->job_end)
		hooks->job_end(hooks->user, slot->index);
}

/* Runs a node, unless it is dropped. */
static void call_node(job_slot *slot, const job_record *record, const job_graph_node *node, bool hooked)
{
	/* Relaxed: see job_internal.h. A node that is dropped has finished all the same, so that the run ends. */
	if (job_drops(slot->pool, record->fn.graph->group))
		return;
	if (hooked)
		call_hooked(slot, record, node);
	else
		node->fn(node->data, slot->index);
}

static void give_back(job_slot *slot, job_record *record)
{
	job_record_give(&slot->pool->records, &slot->records, record);
	job_count(&slot->finished, 1);
}

/* The last node has finished. */
static void end_run(job_slot *slot, stilb_job_graph *graph)
{
	stilb_job_group *group = graph->group;
	atomic_store_explicit(&graph->unfinished, graph->sink_count, memory_order_relaxed); /* as in take_node */
	job_exclusive_end(&graph->running);
	job_group_finish(slot, group, 1);
}

job_record *job_graph_run(job_slot *slot, job_record *record, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_graph *graph = record->fn.graph;
	const stilb_job_hooks *hooks = &slot->pool->hooks;
	bool hooked = hooks->job_begin || hooks->job_end || hooks->node_begin || hooks->node_end, last = false;
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	slot->level = atomic_load_explicit(&record->level, memory_order_relaxed);
	slot->root = atomic_load_explicit(&record->root, memory_order_relaxed);
	job_record *next = NULL;
	job_graph_node *node = NULL;
	for (uint32_t nodes = 1;; nodes++) {
		if (!node)
			node = take_node(slot, graph, record);
		rearm(node);
		call_node(slot, record, node, hooked);
		node = leave_node(slot, graph, record, node, &last);
		bool more = node || !record_is_empty(record);
		if (more && hooks->submit)
			record->tag = hooks->submit(hooks->user, slot->index);
		if (last || !scope || nodes == JOBS_IN_A_ROW || job_work_urgent(slot) || (until && job_group_done(until)))
			break;
		if (more)
			continue;
		next = job_work_take_own(slot, scope);
		if (!next || next->kind != JOB_NODES || next->fn.graph != graph)
			break;
		give_back(slot, record);
		record = next;
		next = NULL;
	}
	slot->level = outer_level;
	slot->root = outer_root;
	if (node)
		chain_node(graph, record, (uint32_t)(node - graph->run));
	if (!record_is_empty(record))
		return record;
	give_back(slot, record);
	if (last)
		end_run(slot, graph);
	return next;
}

/* ---- drawing --------------------------------------------------------------------------------------------------- */

/* Writes text as the inside of a quoted string of the DOT language. */
static void write_quoted(const char *text, FILE *out)
{
	for (; *text; text++) {
		if (*text == '"' || *text == '\\')
			fputc('\\', out);
		if (*text == '\n')
			fputs("\\n", out);
		else
			fputc(*text, out);
	}
}

void stilb_job_graph_write_dot(const stilb_job_graph *graph, FILE *out)
{
	assert(graph && out);
	fputs("digraph {\n", out);
	for (uint32_t i = 0; i < graph->node_count; i++) {
		fprintf(out, "\tn%u [label=\"", i);
		if (graph->node[i].name)
			write_quoted(graph->node[i].name, out);
		else
			fprintf(out, "#%u", i);
		fputs("\"];\n", out);
	}
	for (uint32_t i = 0; i < graph->edge_count; i++)
		fprintf(out, "\tn%u -> n%u;\n", graph->edge[i].before, graph->edge[i].after);
	fputs("}\n", out);
}
