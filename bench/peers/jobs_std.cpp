/* The sorts of the C++ standard library as subjects of the suite `jobs`: on one thread, and with std::execution::par,
 * which runs on oneTBB. */
#include "bench/jobs/jobs_subject.h"

#include <algorithm>
#include <execution>
#include <optional>
#include <tbb/global_control.h>

namespace
{
std::optional<tbb::global_control> limit;

bool open(uint32_t threads, bool)
{
	limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
	return true;
}

void close()
{
	limit.reset();
}

constexpr auto by_key = [](const jobs_element &a, const jobs_element &b) { return a.key < b.key; };

void sort(jobs_element *elements, uint32_t count)
{
	std::stable_sort(elements, elements + count, by_key);
}

void sort_par(jobs_element *elements, uint32_t count)
{
	std::stable_sort(std::execution::par, elements, elements + count, by_key);
}

jobs_subject describe(const char *name, void (*sort)(jobs_element *elements, uint32_t count))
{
	jobs_subject subject = {};
	subject.name = name;
	subject.open = open;
	subject.close = close;
	subject.sort = sort;
	return subject;
}

const jobs_subject one = describe("std", sort);
const jobs_subject par = describe("std-par", sort_par);
} // namespace

const jobs_subject *const jobs_subjects[] = {&one, &par, nullptr};
