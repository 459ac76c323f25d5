/*
 * job.hpp: the job system (job.h, job_graph.h, job_range.h, job_sort.h, job_queue.h, job_spsc.h) for C++17. Jobs,
 * slices, nodes and comparisons are lambdas or other callables, and queues own their items. An exception that leaves
 * one is stopped before it reaches the C functions of the pool, and thrown again where the program waits. A header
 * alone, over the C interface, which may be used beside it.
 *
 * Example.
 *                   stilb::job_group group(pool, 0);
 *                   group.submit([&](uint32_t) { load(textures); });
 *                   group.submit([&](uint32_t) { load(meshes); });
 *                   group.wait(); // throws what the first failing job threw
 *
 *                   stilb::job_graph frame;
 *                   uint32_t cull = frame.add([&](uint32_t) { scene.cull(); }, "cull");
 *                   uint32_t draw = frame.add([&](uint32_t) { scene.draw(); }, "draw");
 *                   frame.edge(cull, draw);
 *                   frame.build();
 *                   while (running) {
 *                       frame.run(group);
 *                       group.wait();
 *                   }
 *
 *                   stilb::job_queue<picture> queue; // a thread pushes std::unique_ptr<picture>, and this one pops
 *                   std::unique_ptr<picture> item;
 *                   while (queue.pop_wait(item, 0) == stilb::job_status::done)
 *                       show(*item);
 *
 *                   stilb::sort(pool, draws, [](const draw &a, const draw &b) { return a.depth < b.depth; }, 0);
 *
 * Exceptions.   The first one is kept, the jobs and nodes of the same group that have not started are dropped, and
 *               later exceptions are lost. Calls that find no memory throw std::bad_alloc.
 * Threads.      As in job.h. A group belongs to the thread that has made it, whose index it keeps; its jobs may not use
 *               it, and make groups of their own to submit and wait.
 * Memory.       One allocation for each job and node; loops make none, reduce and sort at most one.
 *               Queues make none of their own.
 */
#ifndef STILB_JOB_HPP
#define STILB_JOB_HPP

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <stdexcept>
#include <stilb/job_graph.h>
#include <stilb/job_queue.h>
#include <stilb/job_range.h>
#include <stilb/job_sort.h>
#include <stilb/job_spsc.h>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace stilb
{

/* The first exception of several jobs. */
class job_failure
{
  public:
	/* Keeps the exception that is being handled, unless there is one already. [any-thread] */
	void keep_current() noexcept
	{
		// Relaxed: only decides who writes `first`, which is read after the wait for the jobs.
		if (!any_.exchange(true, std::memory_order_relaxed))
			first_ = std::current_exception();
	}

	/* True if there is one. Relaxed: may be out of date while jobs run. [any-thread] */
	bool any() const noexcept
	{
		return any_.load(std::memory_order_relaxed);
	}

	/* Throws the exception, if there is one, and forgets it. To be called when the jobs have finished. */
	void rethrow()
	{
		if (any_.exchange(false, std::memory_order_relaxed)) // as in keep_current
			std::rethrow_exception(std::exchange(first_, nullptr));
	}

  private:
	std::atomic<bool> any_{false};
	std::exception_ptr first_;
};

/* A callable with its type erased; for job_group and job_graph. */
struct job_call {
	virtual ~job_call() = default;
	virtual void call(uint32_t worker) = 0;

	template <typename F> static std::unique_ptr<job_call> make(F &&f)
	{
		using function = std::decay_t<F>;
		struct holder final : job_call {
			function f;
			explicit holder(F &&from) : f(std::forward<F>(from))
			{
			}
			void call(uint32_t worker) override
			{
				f(worker);
			}
		};
		return std::make_unique<holder>(std::forward<F>(f));
	}
};

/* stilb_job_group with lambdas. Its destructor waits, and drops an exception that no wait has thrown. */
class job_group
{
  public:
	/* worker is the index of the calling thread, to which the group belongs from now on; or STILB_JOB_OUTSIDE. */
	job_group(stilb_job_pool *pool, uint32_t worker) : pool_(pool), worker_(worker)
	{
		group_.dropped = [](void *data, uint32_t) { delete static_cast<job *>(data); };
	}

	~job_group()
	{
		stilb_job_wait(pool_, &group_, worker_);
	}

	job_group(const job_group &) = delete;
	job_group &operator=(const job_group &) = delete;

	/* Submits a job that calls f(worker) with the index of the thread that runs it. */
	template <typename F> void submit(F &&f)
	{
		std::unique_ptr<job> made(new job{this, job_call::make(std::forward<F>(f))});
		if (stilb_job_submit(pool_, run, made.get(), &group_, worker_) != 0)
			throw std::bad_alloc();
		made.release(); // the job deletes it, and may have done so
	}

	/* Returns when all jobs and graphs of the group have finished; throws the first exception of one of them. */
	void wait()
	{
		stilb_job_wait(pool_, &group_, worker_);
		failure_.rethrow();
	}

  private:
	friend class job_graph;

	struct job {
		job_group *group;
		std::unique_ptr<job_call> function;
	};

	static void run(void *data, uint32_t worker)
	{
		std::unique_ptr<job> own(static_cast<job *>(data));
		own->group->guard([&] { own->function->call(worker); });
	}

	/* Calls f; an exception is kept and cancels the group. */
	template <typename F> void guard(F f) noexcept
	{
		try {
			f();
		} catch (...) {
			failure_.keep_current();
			stilb_job_group_cancel(pool_, &group_);
		}
	}

	stilb_job_pool *pool_;
	uint32_t worker_;
	stilb_job_group group_ = {};
	job_failure failure_;
};

/* stilb_job_graph with lambdas; see job_graph.h for what a node, an edge and a run are. */
class job_graph
{
  public:
	/* allocator: for the graph itself, as for stilb_job_graph_create_with; nodes come from operator new. */
	explicit job_graph(const stilb_job_allocator *allocator = nullptr)
	{
		if (stilb_job_graph_create_with(allocator, &graph_) != 0)
			throw std::bad_alloc();
	}

	/* No run is in progress (asserted). */
	~job_graph()
	{
		stilb_job_graph_destroy(graph_);
	}

	job_graph(const job_graph &) = delete;
	job_graph &operator=(const job_graph &) = delete;

	/* Adds a node that calls f(worker), and returns its number. */
	template <typename F> uint32_t add(F &&f, const char *name = nullptr)
	{
		uint32_t number;
		nodes_.push_back(std::unique_ptr<node>(new node{this, job_call::make(std::forward<F>(f))}));
		int error = stilb_job_graph_add_node(graph_, run_node, nodes_.back().get(), name, &number);
		if (error)
			nodes_.pop_back();
		check(error);
		return number;
	}

	/* Node `after` runs when node `before` has finished. */
	void edge(uint32_t before, uint32_t after)
	{
		check(stilb_job_graph_add_edge(graph_, before, after));
	}

	/* Prepares the graph for running. Throws std::logic_error if nodes wait for one another; what() names them. */
	void build()
	{
		char cycle[512];
		int error = stilb_job_graph_build(graph_, cycle, sizeof cycle);
		if (error == -ELOOP)
			throw std::logic_error(std::string("nodes wait for one another: ") + cycle);
		check(error);
	}

	/* Starts a run in the group, whose wait throws the first exception of a node. */
	void run(job_group &group)
	{
		group_ = &group;
		check(stilb_job_graph_run(graph_, group.pool_, &group.group_, group.worker_));
	}

	/* The graph of the C interface, for example to draw it. */
	const stilb_job_graph *get() const
	{
		return graph_;
	}

  private:
	struct node {
		job_graph *graph;
		std::unique_ptr<job_call> function;
	};

	static void run_node(void *data, uint32_t worker)
	{
		node *own = static_cast<node *>(data);
		own->graph->group_->guard([&] { own->function->call(worker); });
	}

	static void check(int error)
	{
		if (error == -EOVERFLOW)
			throw std::length_error("too many nodes or edges");
		if (error)
			throw std::bad_alloc();
	}

	stilb_job_graph *graph_ = nullptr;
	std::vector<std::unique_ptr<node>> nodes_;
	job_group *group_ = nullptr; /* of the run in progress */
};

/* A callable that a loop shares: calls it on any thread until it has thrown, and keeps the exception. */
template <typename F> class job_guarded
{
  public:
	explicit job_guarded(F &f) : f_(f)
	{
	}

	template <typename... Arguments> void operator()(Arguments &&...arguments) noexcept
	{
		if (failure.any())
			return;
		try {
			f_(std::forward<Arguments>(arguments)...);
		} catch (...) {
			failure.keep_current();
		}
	}

	job_failure failure;

  private:
	F &f_;
};

/* Calls f(begin, end, worker) for slices as stilb_job_parallel_for does. After an exception no further slice is begun,
 * and when those that run have finished it is thrown. */
template <typename F> void parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, F &&f, uint32_t worker)
{
	using guarded = job_guarded<std::remove_reference_t<F>>;
	guarded own(f);
	auto slice = [](uint32_t begin, uint32_t end, uint32_t index, void *context) {
		(*static_cast<guarded *>(context))(begin, end, index);
	};
	stilb_job_parallel_for(pool, count, grain, slice, &own, worker);
	own.failure.rethrow();
}

/* The same for stilb_job_parallel_for_64. */
template <typename F> void parallel_for_64(stilb_job_pool *pool, uint64_t count, uint64_t grain, F &&f, uint32_t worker)
{
	using guarded = job_guarded<std::remove_reference_t<F>>;
	guarded own(f);
	auto slice = [](uint64_t begin, uint64_t end, uint32_t index, void *context) {
		(*static_cast<guarded *>(context))(begin, end, index);
	};
	stilb_job_parallel_for_64(pool, count, grain, slice, &own, worker);
	own.failure.rethrow();
}

/* Calls f(tile, worker) for tiles as stilb_job_parallel_for_tiles does, exceptions as in parallel_for. */
template <typename F>
void parallel_for_tiles(stilb_job_pool *pool, uint32_t width, uint32_t height, uint32_t tile_width,
                        uint32_t tile_height, F &&f, uint32_t worker)
{
	using guarded = job_guarded<std::remove_reference_t<F>>;
	guarded own(f);
	auto run = [](stilb_job_tile tile, uint32_t index, void *context) {
		(*static_cast<guarded *>(context))(tile, index);
	};
	stilb_job_parallel_for_tiles(pool, width, height, tile_width, tile_height, run, &own, worker);
	own.failure.rethrow();
}

/* stilb_job_reduce with lambdas: returns identity combined with every slice, in the order of the indices.
 * fold(begin, end, value, worker) adds a range to `T &value`; combine(left, right) returns the T of both. Exceptions as
 * in parallel_for; std::bad_alloc only if a T is larger than STILB_JOB_REDUCE_STACK. */
template <typename T, typename Fold, typename Combine>
T reduce(stilb_job_pool *pool, uint64_t count, uint64_t grain, const T &identity, Fold &&fold, Combine &&combine,
         uint32_t worker)
{
	static_assert(std::is_trivially_copyable_v<T>, "values are copied as bytes");
	auto join = [&](T &left, const T &right) { left = combine(left, right); };
	struct both {
		job_guarded<std::remove_reference_t<Fold>> fold;
		job_guarded<decltype(join)> combine;
	} own{job_guarded<std::remove_reference_t<Fold>>(fold), job_guarded<decltype(join)>(join)};
	stilb_job_reduction reduction = {};
	reduction.size = sizeof(T);
	reduction.identity = &identity;
	reduction.fold = [](uint64_t begin, uint64_t end, void *value, uint32_t index, void *context) {
		static_cast<both *>(context)->fold(begin, end, *static_cast<T *>(value), index);
	};
	reduction.combine = [](void *left, const void *right, void *context) {
		static_cast<both *>(context)->combine(*static_cast<T *>(left), *static_cast<const T *>(right));
	};
	reduction.context = &own;
	T result = identity;
	if (stilb_job_reduce(pool, count, grain, &reduction, &result, worker) != 0)
		throw std::bad_alloc();
	own.fold.failure.rethrow();
	own.combine.failure.rethrow();
	return result;
}

/* stilb_job_sort: sorts count elements from `first` on, stably. before(a, b) is true if a must come before b, as for
 * std::sort. It is called through a pointer and so is not inlined, as it is in std::stable_sort. Elements are copied as
 * bytes. After an exception the array has some of its elements, perhaps some of them twice; std::bad_alloc leaves it
 * unchanged. */
template <typename T, typename Before>
void sort(stilb_job_pool *pool, T *first, size_t count, Before &&before, uint32_t worker)
{
	static_assert(std::is_trivially_copyable_v<T>, "elements are copied as bytes");
	static_assert(alignof(T) <= STILB_JOB_MAX_ALIGNMENT, "the copy is aligned so far");
	struct comparison {
		std::remove_reference_t<Before> &before;
		job_failure failure;
	} own{before, {}};
	auto compare = [](const void *a, const void *b, void *context) noexcept -> int {
		comparison &by = *static_cast<comparison *>(context);
		if (by.failure.any())
			return 0;
		try {
			return by.before(*static_cast<const T *>(b), *static_cast<const T *>(a)); // more than 0 is all that counts
		} catch (...) {
			by.failure.keep_current();
			return 0;
		}
	};
	if (stilb_job_sort(pool, first, count, sizeof(T), compare, &own, worker) != 0)
		throw std::bad_alloc();
	own.failure.rethrow();
}

/* The same for all elements of a vector, an array or a span. */
template <typename Elements, typename Before>
void sort(stilb_job_pool *pool, Elements &&elements, Before &&before, uint32_t worker)
{
	sort(pool, std::data(elements), std::size(elements), std::forward<Before>(before), worker);
}

/* How a push or pop has ended. Without memory it throws std::bad_alloc. */
enum class job_status {
	done,
	again,     /* the queue is full, or empty */
	timed_out, /* it was so all the time */
	closed     /* and, for a pop, empty for good */
};

inline job_status job_status_of(int error)
{
	switch (error) {
	case 0:
		return job_status::done;
	case -EAGAIN:
		return job_status::again;
	case -ETIMEDOUT:
		return job_status::timed_out;
	case -EPIPE:
		return job_status::closed;
	case -EINVAL:
		throw std::invalid_argument("a queue's settings, or an item that is null");
	default:
		throw std::bad_alloc();
	}
}

/* As a time limit: none. */
inline constexpr std::chrono::nanoseconds job_no_limit = std::chrono::nanoseconds::max();

inline uint64_t job_limit_ns(std::chrono::nanoseconds limit)
{
	return limit == job_no_limit ? UINT64_MAX : limit.count() > 0 ? static_cast<uint64_t>(limit.count()) : 0;
}

/* The result of a push, which has taken the item if it succeeded. */
template <typename T> job_status job_pushed(int error, std::unique_ptr<T> &item)
{
	job_status status = job_status_of(error);
	if (status == job_status::done)
		(void)item.release(); // the thread that pops it may have deleted it already
	return status;
}

/* Calls pop(&pointer), and stores the item in `item` if there was one. */
template <typename T, typename Pop> job_status job_popped(std::unique_ptr<T> &item, Pop pop)
{
	void *popped = nullptr;
	job_status status = job_status_of(pop(&popped));
	if (status == job_status::done)
		item.reset(static_cast<T *>(popped));
	return status;
}

/* stilb_job_queue of items that it owns. A push takes the item only if it returns done, and a pop replaces `item` only
 * then. thread: the caller's number, see job_queue.h. */
template <typename T> class job_queue
{
  public:
	explicit job_queue(const stilb_job_queue_desc &desc = stilb_job_queue_desc_default())
	{
		job_status_of(stilb_job_queue_create(&desc, &queue_));
	}

	/* Deletes the items that are left. No other call is in progress. */
	~job_queue()
	{
		void *item;
		while (stilb_job_queue_pop(queue_, &item, 0) == 0)
			delete static_cast<T *>(item);
		stilb_job_queue_destroy(queue_);
	}

	job_queue(const job_queue &) = delete;
	job_queue &operator=(const job_queue &) = delete;

	/* done, again or closed. */
	job_status push(std::unique_ptr<T> &&item, uint32_t thread)
	{
		return job_pushed(stilb_job_queue_push(queue_, item.get(), thread), item);
	}

	/* Waits while the queue is full. done, timed_out or closed. */
	job_status push_wait(std::unique_ptr<T> &&item, uint32_t thread, std::chrono::nanoseconds limit = job_no_limit)
	{
		return job_pushed(stilb_job_queue_push_wait(queue_, item.get(), thread, job_limit_ns(limit)), item);
	}

	/* done, again or closed. */
	job_status pop(std::unique_ptr<T> &item, uint32_t thread)
	{
		return job_popped(item, [&](void **to) { return stilb_job_queue_pop(queue_, to, thread); });
	}

	/* Waits while the queue is empty. done, timed_out or closed. */
	job_status pop_wait(std::unique_ptr<T> &item, uint32_t thread, std::chrono::nanoseconds limit = job_no_limit)
	{
		return job_popped(item,
		                  [&](void **to) { return stilb_job_queue_pop_wait(queue_, to, thread, job_limit_ns(limit)); });
	}

	void close()
	{
		stilb_job_queue_close(queue_);
	}

	/* The queue of the C interface, for example for stilb_job_queue_rest. */
	stilb_job_queue *get() const
	{
		return queue_;
	}

  private:
	stilb_job_queue *queue_ = nullptr;
};

/* stilb_job_spsc of items that it owns, as job_queue. One thread pushes and closes, one other thread pops. */
template <typename T> class job_spsc
{
  public:
	/* allocator: as for stilb_job_spsc_create_with. */
	explicit job_spsc(const stilb_job_allocator *allocator = nullptr)
	{
		job_status_of(stilb_job_spsc_create_with(allocator, &queue_));
	}

	/* Deletes the items that are left. No other call is in progress. */
	~job_spsc()
	{
		void *item;
		while (stilb_job_spsc_pop(queue_, &item) == 0)
			delete static_cast<T *>(item);
		stilb_job_spsc_destroy(queue_);
	}

	job_spsc(const job_spsc &) = delete;
	job_spsc &operator=(const job_spsc &) = delete;

	/* done or closed. */
	job_status push(std::unique_ptr<T> &&item)
	{
		return job_pushed(stilb_job_spsc_push(queue_, item.get()), item);
	}

	/* done, again or closed. */
	job_status pop(std::unique_ptr<T> &item)
	{
		return job_popped(item, [&](void **to) { return stilb_job_spsc_pop(queue_, to); });
	}

	/* Waits while the queue is empty. done, timed_out or closed. */
	job_status pop_wait(std::unique_ptr<T> &item, std::chrono::nanoseconds limit = job_no_limit)
	{
		return job_popped(item, [&](void **to) { return stilb_job_spsc_pop_wait(queue_, to, job_limit_ns(limit)); });
	}

	void close()
	{
		stilb_job_spsc_close(queue_);
	}

  private:
	stilb_job_spsc *queue_ = nullptr;
};

} // namespace stilb
#endif
