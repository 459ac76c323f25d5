// The C++ header: lambdas run, nothing leaks, and exceptions arrive at the wait. Without cmocka, which leaves a test by
// longjmp, past destructors.
#include <stilb/job.hpp>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

static void check(bool good, const char *what)
{
	if (!good) {
		std::printf("failed: %s\n", what);
		std::exit(1);
	}
}

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool = nullptr;
	desc.worker_count = workers;
	check(stilb_job_pool_create(&desc, &pool) == 0, "create");
	return pool;
}

/* The text of the exception that f throws; "none" if it returns. */
template <typename F> static std::string thrown(F f)
{
	try {
		f();
	} catch (const std::exception &e) {
		return e.what();
	}
	return "none";
}

static void jobs_run_and_own_their_captures(stilb_job_pool *pool)
{
	auto alive = std::make_shared<int>(7);
	std::atomic<int> sum{0};
	{
		stilb::job_group group(pool, 0);
		for (int i = 0; i < 100; i++)
			group.submit([&sum, alive, i](uint32_t) { sum += *alive + i; });
		check(thrown([&] { group.wait(); }) == "none", "wait");
		check(sum == 100 * 7 + 99 * 100 / 2, "sum");
		for (int i = 0; i < 100; i++)
			group.submit([&sum, kept = std::make_unique<int>(1)](uint32_t) { sum += *kept; });
	} // the destructor waits
	check(sum == 100 * 7 + 99 * 100 / 2 + 100, "sum after the destructor");
	check(alive.use_count() == 1, "captures are destroyed");
}

static void exceptions_arrive_at_the_wait(stilb_job_pool *pool)
{
	auto alive = std::make_shared<int>(0);
	for (int turn = 0; turn < 50; turn++) {
		stilb::job_group group(pool, 0);
		std::atomic<int> ran{0};
		for (int i = 0; i < 20; i++)
			group.submit([&ran, alive, i, turn](uint32_t) {
				ran++;
				if (i == turn % 20)
					throw std::runtime_error("job " + std::to_string(i));
			});
		check(thrown([&] { group.wait(); }) == "job " + std::to_string(turn % 20), "the exception of the job");
		check(ran >= 1 && ran <= 20, "jobs run at most once");
		group.submit([&ran](uint32_t) { ran = 1000; });
		check(thrown([&] { group.wait(); }) == "none" && ran == 1000, "the group is as good as new");
	}
	check(alive.use_count() == 1, "captures of dropped jobs are destroyed");
}

static void loops_throw(stilb_job_pool *pool)
{
	std::atomic<uint32_t> items{0};
	auto body = [&](uint32_t begin, uint32_t end, uint32_t) {
		items += end - begin;
		if (begin <= 500 && 500 < end)
			throw std::runtime_error("slice");
	};
	check(thrown([&] { stilb::parallel_for(pool, 500, 7, body, 0); }) == "none" && items == 500, "loop");
	items = 0;
	check(thrown([&] { stilb::parallel_for(pool, 100000, 7, body, 0); }) == "slice", "the exception of a slice");
	check(items >= 1 && items <= 100000, "slices run at most once");
	check(stilb_job_pool_worker_count(pool) > 0 || items == 504, "no slice begins after the exception");
}

static void graphs_run_and_throw(stilb_job_pool *pool)
{
	stilb::job_graph graph;
	int culled = 0, drawn = 0, shown = 0;
	bool fails = false;
	uint32_t cull = graph.add([&](uint32_t) { culled++; }, "cull");
	uint32_t draw = graph.add(
		[&](uint32_t) {
			if (fails)
				throw std::runtime_error("draw");
			drawn = culled;
		},
		"draw");
	uint32_t show = graph.add([&](uint32_t) { shown++; }, "show");
	graph.edge(cull, draw);
	graph.edge(draw, show);
	graph.build();
	stilb::job_group group(pool, 0);
	for (int frame = 1; frame <= 20; frame++) {
		graph.run(group);
		group.wait();
		check(shown == frame && drawn == frame, "a frame");
	}
	fails = true;
	graph.run(group);
	check(thrown([&] { group.wait(); }) == "draw", "the exception of a node");
	check(culled == 21 && shown == 20, "nodes after the exception are dropped");
	graph.edge(show, cull);
	std::string text = thrown([&] { graph.build(); });
	check(text.find("cull -> draw -> show") != std::string::npos ||
	          text.find("draw -> show -> cull") != std::string::npos ||
	          text.find("show -> cull -> draw") != std::string::npos,
	      "the cycle is named");
}

static void ranges_are_lambdas(stilb_job_pool *pool)
{
	std::atomic<uint64_t> sum{0};
	stilb::parallel_for_64(
		pool, UINT64_MAX, uint64_t{1} << 60, [&](uint64_t begin, uint64_t end, uint32_t) { sum += end - begin; }, 0);
	check(sum == UINT64_MAX, "every index of a long range");
	sum = 0;
	stilb::parallel_for_tiles(
		pool, 100, 70, 0, 9,
		[&](stilb_job_tile t, uint32_t) { sum += uint64_t{t.x_end - t.x_begin} * (t.y_end - t.y_begin); }, 0);
	check(sum == 7000, "every point of a rectangle");
	auto add = [](uint64_t begin, uint64_t end, double &value, uint32_t) {
		for (uint64_t i = begin; i < end; i++)
			value += static_cast<double>(i);
	};
	auto plus = [](double left, double right) { return left + right; };
	check(stilb::reduce(pool, 1000, 3, 0.0, add, plus, 0) == 499500.0, "sum");

	std::atomic<int> calls{0};
	auto fail = [&](auto &&...) {
		calls++;
		throw std::runtime_error("range");
	};
	auto fail_plus = [](double, double) -> double { throw std::runtime_error("combine"); };
	int threads = static_cast<int>(stilb_job_pool_worker_count(pool)) + 1;
	check(thrown([&] { stilb::parallel_for_64(pool, 100, 1, fail, 0); }) == "range", "exception of a range");
	check(thrown([&] { stilb::parallel_for_tiles(pool, 99, 99, 9, 9, fail, 0); }) == "range", "exception of a tile");
	check(thrown([&] { stilb::reduce(pool, 100, 1, 0.0, fail, plus, 0); }) == "range", "exception of a fold");
	check(calls <= 3 * threads, "no slice begins after an exception");
	check(thrown([&] { stilb::reduce(pool, 100, 1, 0.0, add, fail_plus, 0); }) == "combine", "of a combine");
}

/* An item that counts how many there are. */
struct counted {
	int number;
	static std::atomic<int> alive;
	explicit counted(int n) : number(n)
	{
		alive++;
	}
	~counted()
	{
		alive--;
	}
};
std::atomic<int> counted::alive{0};

using std::chrono::milliseconds;
using stilb::job_status;

static void queues_own_their_items(stilb_job_queue_kind kind)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.kind = kind;
	desc.capacity = 2;
	desc.thread_count = 2;
	{
		stilb::job_queue<counted> queue(desc);
		std::unique_ptr<counted> item;
		check(queue.pop(item, 0) == job_status::again && !item, "pop from an empty queue");
		check(queue.pop_wait(item, 0, milliseconds(1)) == job_status::timed_out && !item, "nothing comes");
		for (int i = 0; i < 2; i++)
			check(queue.push(std::make_unique<counted>(i), 0) == job_status::done, "push");
		item = std::make_unique<counted>(2);
		check(queue.push(std::move(item), 0) == job_status::again && item, "a full queue leaves the item");
		check(queue.push_wait(std::move(item), 0, milliseconds(-1)) == job_status::timed_out && item, "still full");
		check(thrown([&] { queue.push(nullptr, 0); }) != "none", "no null items");
		check(counted::alive == 3, "three items");
		std::unique_ptr<counted> first;
		check(queue.pop(first, 1) == job_status::done && first->number == 0, "the oldest item");
		check(queue.pop_wait(first, 1) == job_status::done && first->number == 1, "the next one");
		check(counted::alive == 2, "a pop deletes what was there before");
		check(queue.push_wait(std::move(item), 0) == job_status::done && !item, "push where there is room");
		queue.close();
		item = std::make_unique<counted>(3);
		check(queue.push(std::move(item), 0) == job_status::closed && item, "a closed queue leaves the item");
		check(queue.push_wait(std::move(item), 0) == job_status::closed && item, "also after a wait");
	} // deletes item 2
	check(counted::alive == 0, "no item leaks");
	desc.capacity = 0;
	check(thrown([&] { stilb::job_queue<counted> none(desc); }) != "none", "settings out of range");
}

static void spsc_owns_its_items()
{
	{
		stilb::job_spsc<counted> queue;
		std::unique_ptr<counted> item;
		check(queue.pop(item) == job_status::again, "pop from an empty queue");
		check(queue.pop_wait(item, milliseconds(1)) == job_status::timed_out, "nothing comes");
		for (int i = 0; i < 3; i++)
			check(queue.push(std::make_unique<counted>(i)) == job_status::done, "push");
		check(queue.pop_wait(item) == job_status::done && item->number == 0, "the oldest item");
		check(queue.pop(item) == job_status::done && item->number == 1, "the next one");
		queue.close();
		item = std::make_unique<counted>(3);
		check(queue.push(std::move(item)) == job_status::closed && item, "a closed queue leaves the item");
	} // deletes item 2
	check(counted::alive == 0, "no item leaks");
	stilb::job_spsc<counted> closed;
	closed.close();
	std::unique_ptr<counted> none;
	check(closed.pop(none) == job_status::closed && closed.pop_wait(none) == job_status::closed, "closed and empty");
}

static void *no_memory(void *, size_t, size_t)
{
	return nullptr;
}

static void no_release(void *, void *, size_t)
{
}

static void queues_without_memory_throw()
{
	stilb_job_allocator none = {no_memory, no_release, nullptr};
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.allocator = &none;
	check(thrown([&] { stilb::job_queue<counted> queue(desc); }) == "std::bad_alloc", "no memory for a queue");
	check(thrown([&] { stilb::job_spsc<counted> queue(&none); }) == "std::bad_alloc", "no memory for a spsc");
}

struct pair {
	int key, place;
};

static void sorts_take_lambdas(stilb_job_pool *pool)
{
	auto by_key = [](const pair &a, const pair &b) { return a.key < b.key; };
	std::vector<pair> values;
	for (int i = 0; i < 20000; i++)
		values.push_back({i * 7919 % 100, i});
	stilb::sort(pool, values, by_key, 0);
	bool sorted = true;
	for (size_t i = 1; i < values.size(); i++)
		sorted = sorted && (values[i - 1].key < values[i].key ||
		                    (values[i - 1].key == values[i].key && values[i - 1].place < values[i].place));
	check(sorted, "sorted, and stable");
	int few[] = {3, 1, 2};
	stilb::sort(pool, few, 2, std::less<int>(), 0);
	check(few[0] == 1 && few[1] == 3 && few[2] == 2, "the first two of an array");
	stilb::sort(pool, few, std::greater<int>(), 0);
	check(few[0] == 3 && few[1] == 2 && few[2] == 1, "an array, descending");
	std::atomic<int> calls{0};
	auto fails = [&](const pair &, const pair &) -> bool {
		calls++;
		throw std::runtime_error("compare");
	};
	check(thrown([&] { stilb::sort(pool, values, fails, 0); }) == "compare", "exception of a comparison");
	check(calls <= static_cast<int>(stilb_job_pool_worker_count(pool)) + 1, "no comparison after an exception");
}

int main()
{
	queues_own_their_items(STILB_JOB_QUEUE_LOW_LOCK);
	queues_own_their_items(STILB_JOB_QUEUE_LOCK_FREE);
	spsc_owns_its_items();
	queues_without_memory_throw();
	for (uint32_t workers = 0; workers < 4; workers++) {
		stilb_job_pool *pool = pool_of(workers);
		jobs_run_and_own_their_captures(pool);
		exceptions_arrive_at_the_wait(pool);
		loops_throw(pool);
		ranges_are_lambdas(pool);
		graphs_run_and_throw(pool);
		sorts_take_lambdas(pool);
		stilb_job_pool_destroy(pool);
	}
	std::puts("all is well");
	return 0;
}
