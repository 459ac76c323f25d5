// The zones of test_prof_cpp.c: every kind of function that C++ has, in one file, which g++ minds about sections.
#undef STILB_PROFILE_OFF
#include "profiler/prof.h"

#include <stdexcept>

extern "C" int test_prof_cpp_zones(void);

STILB_PROF_SITE(cpp_hook, "cpp hook", 0);

namespace
{
template <typename T> T in_template(T x)
{
	PROFILE("template");
	PROFILE_COLOR("template too", 0xff8800);
	return x + T(1);
}

struct member {
	int in_class(int x)
	{
		PROFILE_FUNCTION();
		return x;
	}
};

void throws()
{
	PROFILE("throws");
	throw std::runtime_error("out");
}
} // namespace

inline int in_inline(int x)
{
	PROFILE("inline");
	return x;
}

int test_prof_cpp_zones(void)
{
	PROFILE("plain");
	stilb_prof_zone_begin(&cpp_hook);
	stilb_prof_zone_end();
	const auto lambda = [](auto x) {
		PROFILE("lambda");
		return x;
	};
	try {
		throws();
	} catch (const std::runtime_error &) {
		PROFILE("catch");
	}
	return in_template(1) + static_cast<int>(in_template(2.0)) + in_inline(3) + member().in_class(4) + lambda(5);
}
