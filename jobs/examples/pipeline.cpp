/*
 * Queues and the sort from C++, with the header job.hpp: two threads load pictures and push them, and wait while four
 * of them lie in the queue; the main thread pops them, and sorts them by size on all threads. The queue owns the
 * pictures on their way; `close` tells the main thread that no more will come.
 *
 * Prints: 200 pictures, from 1 x 1 to 100 x 100, those of one size in the order of their names
 */
#include <cstdio>
#include <memory>
#include <stilb/job.hpp>
#include <thread>
#include <vector>

struct picture {
	int side, name;
};

static void load(stilb::job_queue<picture> &queue, uint32_t number)
{
	for (int i = 0; i < 100; i++) {
		int side = 1 + i * 37 % 100; /* each from 1 to 100 once */
		auto made = std::make_unique<picture>(picture{side, i + 100 * static_cast<int>(number)});
		if (queue.push_wait(std::move(made), number) != stilb::job_status::done)
			return; /* closed: the picture is still this thread's, and is deleted here */
	}
}

int main()
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.capacity = 4;
	desc.thread_count = 3;
	stilb::job_queue<picture> queue(desc);
	std::thread first(load, std::ref(queue), 0), second(load, std::ref(queue), 1);
	std::thread closer([&] {
		first.join();
		second.join();
		queue.close();
	});
	std::vector<picture> all;
	std::unique_ptr<picture> next;
	while (queue.pop_wait(next, 2) == stilb::job_status::done)
		all.push_back(*next);
	closer.join();

	stilb_job_pool_desc settings = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&settings, &pool) != 0)
		return 1;
	stilb::sort(
		pool, all, [](const picture &a, const picture &b) { return a.name < b.name; }, 0);
	stilb::sort(
		pool, all, [](const picture &a, const picture &b) { return a.side < b.side; }, 0);
	stilb_job_pool_destroy(pool);
	bool stable = true;
	for (size_t i = 0; i < all.size(); i += 2)
		stable = stable && all[i].side == all[i + 1].side && all[i].name < all[i + 1].name;
	std::printf("%zu pictures, from %d x %d to %d x %d", all.size(), all[0].side, all[0].side, all.back().side,
	            all.back().side);
	std::puts(stable ? ", those of one size in the order of their names" : "");
	return 0;
}
