#include "farm/farm_link.h"

#include "base/base_file.h"

#include <dlfcn.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

bool stilb_farm_link_is_asked(void)
{
	/* Open MPI's mpirun sets the first in every process that it starts; PMIx, by which batch systems start them
	 * themselves, the second. One process alone needs nobody. */
	const char *size = getenv("OMPI_COMM_WORLD_SIZE");
	return size ? atoi(size) > 1 : (bool)getenv("PMIX_RANK");
}

bool stilb_farm_link_is_host(void)
{
	const char *rank = getenv("OMPI_COMM_WORLD_RANK");
	rank = rank ? rank : getenv("PMIX_RANK");
	return !rank || atoi(rank) == 0;
}

/* Undoes the binding that nobody asked for; what the system forbids stays forbidden. */
static void link_unbind(void)
{
	cpu_set_t all;
	if (getenv("OMPI_MCA_hwloc_base_binding_policy"))
		return;
	memset(&all, 0xff, sizeof all);
	sched_setaffinity(0, sizeof all, &all);
}

stilb_result stilb_farm_link_open(stilb_farm_link *link)
{
	STILB_ASSERT(link);
	char path[STILB_FILE_PART_MAX], why[256] = "";
	*link = (stilb_farm_link){0};
	if (!stilb_file_find_part(FARM_MPI_FILE, path))
		return stilb_fail(STILB_ERROR_FILE,
		                  "started by mpirun, but this build has no " FARM_MPI_FILE " (" STILB_FILE_PART_PLACES
		                  "): build with libopenmpi-dev installed, or make parts with --part");
	/* Stays loaded. Global: Open MPI's own modules look for its functions in it. */
	void *module = dlopen(path, RTLD_NOW | RTLD_GLOBAL);
	farm_mpi_open_fn *open = NULL;
	if (module)
		*(void **)&open = dlsym(module, FARM_MPI_SYMBOL);
	if (!open)
		return stilb_fail(STILB_ERROR_FILE, "cannot load '%s': %s", path, dlerror());
	if (!open(link, why, sizeof why))
		return stilb_fail(STILB_ERROR_DEVICE, "cannot join the processes that mpirun started: %s", why);
	const char *neighbours = getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
	int number = neighbours ? atoi(neighbours) : 1;
	link->neighbours = number > 1 ? (uint32_t)number : 1;
	link_unbind();
	STILB_ASSERT(link->count >= 1 && link->machine < link->count && link->send && link->receive && link->close);
	return STILB_OK;
}
