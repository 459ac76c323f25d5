/*
 * The pool from C++: a thin wrapper makes a parallel loop of any callable, without an allocation. The callable must not
 * throw: an exception cannot pass through the C functions of the pool.
 *
 * Prints: 168 primes below 1000
 */
#include <stilb/job.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

struct pool_destroy {
	void operator()(stilb_job_pool *pool) const
	{
		stilb_job_pool_destroy(pool);
	}
};
using pool_pointer = std::unique_ptr<stilb_job_pool, pool_destroy>;

template <typename Body> void parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, Body body)
{
	auto slice = [](uint32_t begin, uint32_t end, uint32_t, void *context) {
		for (uint32_t i = begin; i < end; ++i)
			(*static_cast<Body *>(context))(i);
	};
	stilb_job_parallel_for(pool, count, grain, slice, &body, 0);
}

int main()
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *created;
	if (stilb_job_pool_create(&desc, &created) != 0)
		return 1;
	pool_pointer pool(created);

	std::vector<char> prime(1000, 0); /* not vector<bool>, whose elements share bytes */
	parallel_for(pool.get(), 1000, 16, [&](uint32_t n) {
		prime[n] = n > 1;
		for (uint32_t d = 2; d * d <= n; ++d)
			if (n % d == 0)
				prime[n] = 0;
	});
	std::printf("%d primes below 1000\n", static_cast<int>(std::count(prime.begin(), prime.end(), 1)));
	return 0;
}
