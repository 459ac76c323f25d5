#include "bench/sim/sim_costs.h"

#include <stdlib.h>
#include <string.h>

typedef struct cost {
	const char *name;
	size_t offset; /* in sim_machine */
	bool whole;    /* uint32_t, else double */
	double least, most;
} cost;

#define COST_MOST 1e9 /* a second, ns */

#define WHOLE(member)                                                                                                  \
	{                                                                                                                  \
#member, offsetof(sim_machine, member), true, 1, SIM_CPUS_MAX                                                  \
	}
#define TIME(member)                                                                                                   \
	{                                                                                                                  \
#member, offsetof(sim_machine, member), false, 0, COST_MOST                                                    \
	}
static const cost costs[] = {
	WHOLE(cores), WHOLE(sockets), WHOLE(threads), WHOLE(cluster), TIME(smt),    TIME(near),
	TIME(socket), TIME(far),      TIME(rmw),      TIME(pause),    TIME(block),  TIME(function),
	TIME(call),   TIME(wake),     TIME(latency),  TIME(sleep),    TIME(create), TIME(timeslice),
};
enum { COSTS = sizeof costs / sizeof *costs };

static void set(sim_machine *machine, const cost *c, double value)
{
	char *at = (char *)machine + c->offset;
	if (c->whole)
		*(uint32_t *)at = (uint32_t)value;
	else
		*(double *)at = value;
}

static double get(const sim_machine *machine, const cost *c)
{
	const char *at = (const char *)machine + c->offset;
	return c->whole ? *(const uint32_t *)at : *(const double *)at;
}

/* The index of the cost of this name, COSTS if there is none. */
static size_t find(const char *name)
{
	size_t i = 0;
	while (i < COSTS && strcmp(costs[i].name, name) != 0)
		i++;
	return i;
}

/* What is wrong with a line, or NULL; notes which costs it has set. */
static const char *read_line(sim_machine *machine, char *line, bool found[COSTS])
{
	char name[32], rest;
	double value;
	line[strcspn(line, "#\n")] = '\0';
	int words = sscanf(line, "%31s %lf %c", name, &value, &rest);
	if (words <= 0)
		return NULL;
	size_t i = words == 2 ? find(name) : COSTS;
	if (words != 2)
		return "is not a name and a number";
	if (i == COSTS)
		return "has a name that is no cost of a machine (bench/sim/sim.h lists them)";
	if (!(value >= costs[i].least && value <= costs[i].most) || (costs[i].whole && value != (double)(uint32_t)value))
		return costs[i].whole ? "has a number that is not whole or not in 1..256"
		                      : "has a time that is not in 0..1e9 ns";
	if (found[i])
		return "has a cost that an earlier line has";
	found[i] = true;
	set(machine, &costs[i], value);
	return NULL;
}

static bool refuse(const char *path, const char *what, const char *more)
{
	fprintf(stderr, "stilb-bench-sim: --costs: %s: %s%s\n", path, what, more);
	return false;
}

bool sim_costs_read(sim_machine *machine, const char *path)
{
	FILE *in = fopen(path, "re");
	char line[256], what[300];
	bool found[COSTS] = {false};
	if (!in)
		return refuse(path, "cannot be opened", "");
	const char *wrong = NULL;
	for (int number = 1; !wrong && fgets(line, sizeof line, in); number++) {
		wrong = read_line(machine, line, found);
		snprintf(what, sizeof what, "line %d ", number);
	}
	fclose(in);
	if (wrong)
		return refuse(path, what, wrong);
	for (size_t i = 0; i < COSTS; i++)
		if (!found[i])
			return refuse(path, "has no line for ", costs[i].name);
	if (machine->cores % machine->cluster != 0)
		return refuse(path, "cores is no multiple of cluster", "");
	if (!(machine->near <= machine->socket && machine->socket <= machine->far))
		return refuse(path, "near, socket and far are not in rising order", "");
	return true;
}

void sim_costs_write(FILE *out, const sim_machine *machine)
{
	for (size_t i = 0; i < COSTS; i++)
		fprintf(out, "%-9s %.10g\n", costs[i].name, get(machine, &costs[i]));
}
