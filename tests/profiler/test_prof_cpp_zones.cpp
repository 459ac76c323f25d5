// The zones of test_prof_cpp.c: every kind of function that C++ has, in one file, which g++ minds about sections.
#include "profiler/prof.h"

#include <stdexcept>

extern "C" int test_prof_cpp_zones(void);
extern "C" void test_prof_cpp_never(void);

STILB_PROF_SITE(cpp_hook, "cpp hook", 0);
STILB_PROF_FLOW(cpp_flow, "cpp flow", 0);

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
	template <typename T> static void in_static(T x)
	{
		PROFILE("static member");
		(void)x;
	}
};

void throws()
{
	PROFILE("throws");
	PROFILE_BEGIN("left open");
	throw std::runtime_error("out");
}

void others()
{
	STILB_PROF_SITE(local_hook, "local hook", 0);
	stilb_prof_zone_begin(&local_hook);
	stilb_prof_flow_end(cpp_flow, stilb_prof_flow_begin(cpp_flow));
	stilb_prof_zone_end();
	stilb_prof_zone_begin(stilb_prof_site_make("made", 0));
	stilb_prof_zone_end();
	PROFILE_BEGIN("begun");
	PROFILE_NEXT("next");
	PROFILE_END();
	PROFILE_COUNTER("counter", 1.5);
	PROFILE_INSTANT("instant");
	PROFILE_PRECISE("precise");
}
} // namespace

inline int in_inline(int x)
{
	PROFILE("inline");
	return x;
}

void test_prof_cpp_never(void)
{
	PROFILE("never");
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
	others();
	member::in_static(1);
	return in_template(1) + static_cast<int>(in_template(2.0)) + in_inline(3) + in_inline(3) + member().in_class(4) +
	       lambda(5);
}
