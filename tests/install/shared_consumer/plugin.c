/* A shared object with a zone. */
#include <stilb/prof.h>

void zone_in_plugin(void);

__attribute__((visibility("default"))) void zone_in_plugin(void)
{
	PROFILE("in a plugin");
}
