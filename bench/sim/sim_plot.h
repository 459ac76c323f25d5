/* The picture of simulated costs against the number of CPUs. */
#ifndef SIM_PLOT_H
#define SIM_PLOT_H

#include "bench/sim/sim_cases.h"

/* One result. */
typedef struct sim_point {
	const sim_machine *machine;
	const sim_case *which;
	uint32_t cpus;
	double value;
	bool before; /* of earlier sources, to compare with */
} sim_point;

enum { SIM_POINTS_MAX = 4096 };

typedef struct sim_points {
	sim_point point[SIM_POINTS_MAX];
	size_t count;
} sim_points;

/* The machine and the case of this name; NULL: there is none. */
const sim_machine *sim_machine_named(const char *name);
const sim_case *sim_case_named(const char *name);

/* Appends a result; false: there is no room. */
bool sim_points_add(sim_points *points, sim_point point);

/* Appends the results that an earlier run of the program has printed into the file, as those of earlier sources. False
 * after a line on stderr. */
bool sim_points_read(sim_points *points, const char *path);

/* Draws phase, look, join-64, and join-64 / join-8. False after a line on stderr. */
bool sim_plot(const sim_points *points, const char *path);

#endif
