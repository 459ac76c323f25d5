// A zone in C++, whose sites no linker gathers.
#include <stilb/prof.h>

extern "C" void zone_in_cpp();

void zone_in_cpp()
{
	PROFILE("in C++");
}
