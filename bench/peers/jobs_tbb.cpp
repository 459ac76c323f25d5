/* oneTBB as a subject of the suite `jobs`. A case runs inside an arena of the requested number of threads, since the
 * default arena has no more threads than there are CPUs. */
#include "bench/jobs/jobs_subject.h"

#include <atomic>
#include <memory>
#include <optional>
#include <tbb/blocked_range2d.h>
#include <tbb/flow_graph.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#include <thread>
#include <vector>

namespace
{
std::optional<tbb::global_control> limit;
std::optional<tbb::task_arena> arena;
std::optional<tbb::task_group> group;

using node = tbb::flow::continue_node<tbb::flow::continue_msg>;
std::optional<tbb::flow::graph> graph;
std::vector<std::unique_ptr<node>> nodes;
std::vector<node *> sources; // nodes without predecessors, which each run starts

bool open(uint32_t threads, bool)
{
	limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
	arena.emplace(static_cast<int>(threads));
	group.emplace();
	return true;
}

void close()
{
	nodes.clear();
	graph.reset();
	group.reset();
	arena.reset();
	limit.reset();
}

void inside(void (*body)(void *), void *context)
{
	arena->execute([=] { body(context); });
}

void spawn(jobs_fn *fn, char *data, uint32_t count)
{
	tbb::task_group jobs;
	for (uint32_t i = 0; i < count; ++i)
		jobs.run([=] { fn(data + i, 0); });
	jobs.wait();
}

template <typename Partitioner> void parallel_for(jobs_range_fn *fn, void *context, uint32_t count)
{
	tbb::parallel_for(
		tbb::blocked_range<uint32_t>(0, count, 1),
		[=](const tbb::blocked_range<uint32_t> &range) { fn(range.begin(), range.end(), 0, context); }, Partitioner());
}

void range(jobs_range_64_fn *fn, void *context, uint64_t count)
{
	tbb::parallel_for(tbb::blocked_range<uint64_t>(0, count, 1),
	                  [=](const tbb::blocked_range<uint64_t> &part) { fn(part.begin(), part.end(), 0, context); });
}

void tiles(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height)
{
	tbb::parallel_for(
		tbb::blocked_range2d<uint32_t>(0, height, 64, 0, width, 64), [=](const tbb::blocked_range2d<uint32_t> &tile) {
			fn(tile.cols().begin(), tile.cols().end(), tile.rows().begin(), tile.rows().end(), 0, context);
		});
}

/* The one of two whose result does not depend on the threads, as ours. */
double reduce(jobs_fold_fn *fn, void *context, uint64_t count)
{
	return tbb::parallel_deterministic_reduce(
		tbb::blocked_range<uint64_t>(0, count, JOBS_REDUCE_GRAIN), 0.0,
		[=](const tbb::blocked_range<uint64_t> &part, double sum) {
			fn(part.begin(), part.end(), &sum, context);
			return sum;
		},
		[](double left, double right) { return left + right; });
}

void sort(jobs_element *elements, uint32_t count)
{
	tbb::parallel_sort(elements, elements + count,
	                   [](const jobs_element &a, const jobs_element &b) { return a.key < b.key; });
}

uint64_t fib(uint32_t n)
{
	if (n < 2)
		return n;
	uint64_t a;
	tbb::task_group jobs;
	jobs.run([&a, n] { a = fib(n - 1); });
	uint64_t b = fib(n - 2);
	jobs.wait();
	return a + b;
}

void graph_run()
{
	for (node *source : sources)
		source->try_put(tbb::flow::continue_msg());
	graph->wait_for_all();
}

void graph_make(jobs_fn *fn, char *data, uint32_t count, const uint32_t (*edge)[2], uint32_t edges)
{
	std::vector<bool> follows(count);
	graph.emplace();
	for (uint32_t i = 0; i < count; ++i)
		nodes.push_back(std::make_unique<node>(*graph, [=](const tbb::flow::continue_msg &) { fn(data + i, 0); }));
	for (uint32_t i = 0; i < edges; ++i) {
		tbb::flow::make_edge(*nodes[edge[i][0]], *nodes[edge[i][1]]);
		follows[edge[i][1]] = true;
	}
	for (uint32_t i = 0; i < count; ++i)
		if (!follows[i])
			sources.push_back(nodes[i].get());
	graph_run();
}

void submit(jobs_fn *fn, void *data)
{
	group->run([=] { fn(data, 0); });
}

void wait()
{
	group->wait();
}

/* The calling thread does not belong to the arena: it enqueues its jobs and waits for a counter of its own. */
void outside(jobs_fn *fn, char *data, uint32_t count)
{
	std::atomic<uint32_t> left(count);
	for (uint32_t i = 0; i < count; ++i)
		arena->enqueue([=, &left] {
			fn(data + i, 0);
			left.fetch_sub(1, std::memory_order_release); // pairs with the acquire in the loop below
		});
	while (left.load(std::memory_order_acquire) != 0) // pairs with the release in the job
		std::this_thread::yield();
}

jobs_subject describe()
{
	jobs_subject tbb = {};
	tbb.name = "tbb";
	tbb.open = open;
	tbb.close = close;
	tbb.inside = inside;
	tbb.spawn = spawn;
	tbb.outside = outside;
	tbb.array = parallel_for<tbb::simple_partitioner>;
	tbb.join = parallel_for<tbb::simple_partitioner>;
	tbb.loop = parallel_for<tbb::auto_partitioner>;
	tbb.range = range;
	tbb.tiles = tiles;
	tbb.reduce = reduce;
	tbb.sort = sort;
	tbb.fib = fib;
	tbb.graph_make = graph_make;
	tbb.graph_run = graph_run;
	tbb.submit = submit;
	tbb.wait = wait;
	return tbb;
}

/* oneTBB with the static partitioner, which gives every thread an equal part of a loop in advance. */
jobs_subject describe_static()
{
	jobs_subject tbb = {};
	tbb.name = "tbb-static";
	tbb.open = open;
	tbb.close = close;
	tbb.inside = inside;
	tbb.join = parallel_for<tbb::static_partitioner>;
	tbb.loop = parallel_for<tbb::static_partitioner>;
	return tbb;
}

const jobs_subject tbb_subject = describe();
const jobs_subject tbb_static_subject = describe_static();
} // namespace

const jobs_subject *const jobs_subjects[] = {&tbb_subject, &tbb_static_subject, nullptr};
