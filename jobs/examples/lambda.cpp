/*
 * The pool from C++, with the header job.hpp: a parallel loop and jobs that are lambdas, and an exception that leaves a
 * job and arrives where the program waits.
 *
 * Prints: 168 primes below 1000, 2 halves counted, and no number can be read from "seven"
 */
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <stilb/job.hpp>
#include <string>
#include <vector>

struct pool_destroy {
	void operator()(stilb_job_pool *pool) const
	{
		stilb_job_pool_destroy(pool);
	}
};
using pool_pointer = std::unique_ptr<stilb_job_pool, pool_destroy>;

static int number_of(const std::string &text)
{
	if (text.find_first_not_of("0123456789") != std::string::npos)
		throw std::runtime_error("no number can be read from \"" + text + "\"");
	return std::stoi(text);
}

int main()
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *created;
	if (stilb_job_pool_create(&desc, &created) != 0)
		return 1;
	pool_pointer pool(created);

	std::vector<char> prime(1000, 0); /* not vector<bool>, whose elements share bytes */
	auto sieve = [&](uint32_t begin, uint32_t end, uint32_t) {
		for (uint32_t n = begin; n < end; ++n) {
			prime[n] = n > 1;
			for (uint32_t d = 2; d * d <= n; ++d)
				if (n % d == 0)
					prime[n] = 0;
		}
	};
	stilb::parallel_for(pool.get(), 1000, 16, sieve, 0);

	stilb::job_group group(pool.get(), 0);
	long low = 0, high = 0;
	group.submit([&](uint32_t) { low = std::count(prime.begin(), prime.begin() + 500, 1); });
	group.submit([&](uint32_t) { high = std::count(prime.begin() + 500, prime.end(), 1); });
	group.wait();
	std::printf("%ld primes below 1000, 2 halves counted, ", low + high);

	group.submit([](uint32_t) { number_of("seven"); });
	try {
		group.wait();
	} catch (const std::runtime_error &error) {
		std::printf("and %s\n", error.what());
	}
	return 0;
}
