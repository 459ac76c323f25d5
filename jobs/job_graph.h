/*
 * job_graph: a graph of jobs that depend on one another, built once and run as often as the program likes, for example
 * once a frame. A node is a function and a pointer, as in stilb_job_submit; an edge says that one node runs after
 * another. A run needs no memory of its own and costs a few tens of nanoseconds a node.
 *
 * Life cycle.   stilb_job_graph_create -> add_node and add_edge -> build -> run and wait, any number of times ->
 *               stilb_job_graph_destroy. Nodes and edges may be added between two runs; the graph is then built again.
 * Example.      Shadows and the scene are drawn at the same time, after culling and before the picture is shown.
 *
 *                   stilb_job_graph *graph;
 *                   uint32_t cull, shadows, scene, show;
 *                   char cycle[256];
 *                   if (stilb_job_graph_create(&graph) != 0 ||
 *                       stilb_job_graph_add_node(graph, cull_fn, &frame, "cull", &cull) != 0 ||
 *                       stilb_job_graph_add_node(graph, shadows_fn, &frame, "shadows", &shadows) != 0 ||
 *                       stilb_job_graph_add_node(graph, scene_fn, &frame, "scene", &scene) != 0 ||
 *                       stilb_job_graph_add_node(graph, show_fn, &frame, "show", &show) != 0 ||
 *                       stilb_job_graph_add_edge(graph, cull, shadows) != 0 ||
 *                       stilb_job_graph_add_edge(graph, cull, scene) != 0 ||
 *                       stilb_job_graph_add_edge(graph, shadows, show) != 0 ||
 *                       stilb_job_graph_add_edge(graph, scene, show) != 0)
 *                       return false;
 *                   if (stilb_job_graph_build(graph, cycle, sizeof cycle) != 0)
 *                       return false; // if it was -ELOOP, cycle says which nodes wait for one another
 *                   while (frame_begin(&frame)) {
 *                       stilb_job_group group = {0};
 *                       if (stilb_job_graph_run(graph, pool, &group, 0) == 0)
 *                           stilb_job_wait(pool, &group, 0);
 *                   }
 *                   stilb_job_graph_destroy(graph);
 *
 * Stages.       If many nodes all come before the same others, as one stage of a frame before the next, a run costs a
 *               count for each node and not for each edge. For that they need the edges in the same order.
 * A run.        Each node runs exactly once, after all nodes from which an edge leads to it, and sees everything that
 *               these have written. The thread that finishes a node goes on with the first of the nodes which that has
 *               made ready, in the order in which the edges were added, and other threads may take the others: no node
 *               that is ready is kept back behind one that is running. A node is a job of normal priority, one level
 *               below the caller of run (see job.h): it may submit jobs, run loops and wait for both.
 * Threads.      A graph is changed by one thread at a time and not while it runs. It may be run in one pool now and in
 *               another one later, but has one run at a time (asserted).
 * Profiler.     Each node is a job to the pool's hooks; a node with a name is also told to node_begin and node_end.
 */
#ifndef STILB_JOB_GRAPH_H
#define STILB_JOB_GRAPH_H

#include "job.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Created by stilb_job_graph_create. */
typedef struct stilb_job_graph stilb_job_graph;

/* Stores an empty graph in *graph. -ENOMEM: no memory, and *graph is NULL. [any-thread] */
int stilb_job_graph_create(stilb_job_graph **graph);

/* stilb_job_graph_create with memory from a copy of the allocator (job_memory.h), which the calls that change, build or
 * destroy the graph use; NULL: the C library. -EINVAL: it has only one of its functions. [any-thread] */
int stilb_job_graph_create_with(const stilb_job_allocator *allocator, stilb_job_graph **graph);

/* Frees the graph, which is not running (asserted). graph may be NULL. A wait for the group of the last run may have
 * returned a moment ago. [any-thread] */
void stilb_job_graph_destroy(stilb_job_graph *graph);

/* Adds a node that runs fn(data, worker) and stores its number in *node: 0 for the first, then 1 and so on. name is
 * copied; NULL: the node has none. -ENOMEM: no memory; -EOVERFLOW: there are 2^30 nodes. After an error the graph is
 * unchanged. [any-thread] */
int stilb_job_graph_add_node(stilb_job_graph *graph, stilb_job_fn *fn, void *data, const char *name, uint32_t *node);

/* Node `after` runs when node `before` has finished; both are numbers of nodes of this graph (asserted). The same edge
 * may be added twice, which changes nothing. -ENOMEM: no memory; -EOVERFLOW: there are 2^31 - 1 edges. After an error
 * the graph is unchanged. [any-thread] */
int stilb_job_graph_add_edge(stilb_job_graph *graph, uint32_t before, uint32_t after);

/* Prepares the graph for running, which every change makes necessary again. Takes time in proportion to nodes and
 * edges, times the logarithm of their number at most. -ELOOP: some nodes wait for one another, and `cycle`, of size
 * bytes, says which: "a -> b -> a", cut to fit, always with a zero at the end; a node without a name is written as its
 * number, "#7". cycle may be NULL if size is 0, and is an empty string after every other result. -ENOMEM: no memory.
 * After an error the graph cannot run, and is unchanged otherwise. [any-thread] */
int stilb_job_graph_build(stilb_job_graph *graph, char *cycle, size_t size);

/* Starts a run and returns at once. The run counts as one job of group, which therefore finishes when all nodes have;
 * group must not be NULL. If the group or the pool is cancelled, the run finishes, but nodes that have not started do
 * not run; group->dropped is not called for them, since their data stay the graph's. The graph must have been built
 * since its last change and must not be running (both asserted). worker is the caller's own index or STILB_JOB_OUTSIDE.
 * -ENOMEM: nothing was started or counted; a run that has started cannot fail. [any-thread] */
int stilb_job_graph_run(stilb_job_graph *graph, stilb_job_pool *pool, stilb_job_group *group, uint32_t worker);

/* Writes the graph in Graphviz' DOT language, also if it has cycles: `dot -Tsvg` draws it. Write errors are left to
 * ferror(out). The graph may be running. [any-thread] */
void stilb_job_graph_write_dot(const stilb_job_graph *graph, FILE *out);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
