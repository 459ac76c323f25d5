#include "bench/sim/sim_plot.h"

#include "game/cli/gnuplot.h"

#include <string.h>

const sim_machine *sim_machine_named(const char *name)
{
	for (size_t i = 0; i < sim_machine_count; i++)
		if (strcmp(sim_machines[i].name, name) == 0)
			return &sim_machines[i];
	return NULL;
}

const sim_case *sim_case_named(const char *name)
{
	for (size_t i = 0; i < sim_case_count; i++)
		if (strcmp(sim_cases[i].name, name) == 0)
			return &sim_cases[i];
	return NULL;
}

bool sim_points_add(sim_points *points, sim_point point)
{
	if (points->count == SIM_POINTS_MAX)
		return false;
	points->point[points->count++] = point;
	return true;
}

bool sim_points_read(sim_points *points, const char *path)
{
	FILE *file = fopen(path, "re");
	char line[256], machine[64], name[64];
	if (!file) {
		stilb_log("cannot read %s", path);
		return false;
	}
	bool fits = true;
	while (fits && fgets(line, sizeof line, file)) {
		sim_point point = {.before = true};
		if (sscanf(line, "%63s %u %63s %lf", machine, &point.cpus, name, &point.value) != 4)
			continue; /* not a result */
		point.machine = sim_machine_named(machine);
		point.which = sim_case_named(name);
		if (point.machine && point.which)
			fits = sim_points_add(points, point);
	}
	fclose(file);
	if (!fits)
		stilb_log("%s: too many results", path);
	return fits;
}

/* The value for this machine and number of CPUs; 0: there is none. */
static double value_of(const sim_points *points, const char *name, const sim_point *like)
{
	for (size_t i = 0; i < points->count; i++) {
		const sim_point *p = &points->point[i];
		if (p->before == like->before && p->machine == like->machine && p->cpus == like->cpus &&
		    strcmp(p->which->name, name) == 0)
			return p->value;
	}
	return 0.0;
}

typedef struct panel {
	const char *title, *unit;
	const char *name, *divided_by; /* the case; NULL, or the case whose value divides it */
	double goal;                   /* at 64 CPUs; 0: none */
} panel;

static const panel panels[] = {
	{"from the begin of a phase until all workers are awake", "us", "phase", NULL, 200.0},
	{"a look for work that finds none", "ns", "look", NULL, 200.0},
	{"fork-join of 64 slices of 1 us in a phase", "us", "join-64", NULL, 0.0},
	{"fork-join of 64 slices / of 8 slices", "ratio", "join-64", "join-8", 1.5},
};

/* Writes the line of one machine, before or after, as the data block $NAME; false: it has no points. */
static bool write_line(FILE *out, const sim_points *points, const panel *p, const sim_machine *machine, bool before,
                       const char *name)
{
	bool any = false;
	fprintf(out, "$%s << END\n", name);
	for (uint32_t cpus = 2; cpus <= SIM_CPUS_MAX; cpus *= 2) {
		sim_point like = {.machine = machine, .cpus = cpus, .before = before};
		double value = value_of(points, p->name, &like);
		double divisor = p->divided_by ? value_of(points, p->divided_by, &like) : 1.0;
		if (value <= 0.0 || divisor <= 0.0)
			continue;
		fprintf(out, "%u %.6g\n", cpus, value / divisor);
		any = true;
	}
	fprintf(out, "END\n");
	return any;
}

static void write_panel(FILE *out, const sim_points *points, const panel *p, size_t number)
{
	static const char *const colours[] = {"#0050b0", "#c00000", "#007030", "#404040"};
	bool there[2][8] = {{false}};
	char name[64];
	for (size_t before = 0; before < 2; before++)
		for (size_t m = 0; m < sim_machine_count; m++) {
			snprintf(name, sizeof name, "panel%zu_%zu_%zu", number, before, m);
			there[before][m] = write_line(out, points, p, &sim_machines[m], before, name);
		}
	fprintf(out, "set title \"%s\"\nset ylabel \"%s (less is better)\"\nunset arrow\nset key %s Left reverse\n",
	        p->title, p->unit, strcmp(p->name, "join-64") == 0 ? "left bottom" : "left top");
	if (p->goal > 0.0)
		fprintf(out, "set arrow from 2,%g to 64,%g nohead dashtype 3 linecolor rgb '#808080'\n", p->goal, p->goal);
	const char *word = "plot ";
	for (size_t before = 0; before < 2; before++)
		for (size_t m = 0; m < sim_machine_count; m++)
			if (there[before][m]) {
				fprintf(out,
				        "%s$panel%zu_%zu_%zu using 1:2 with linespoints linewidth 2 pointtype %zu dashtype %d "
				        "linecolor rgb '%s' title \"%s%s\"",
				        word, number, before, m, 5 + 2 * m, before ? 2 : 1, colours[m % 4], sim_machines[m].name,
				        before ? ", before" : "");
				word = ", ";
			}
	fputs(word[0] == 'p' ? "plot NaN notitle\n" : "\n", out);
}

static void write_script(FILE *out, const void *context)
{
	fprintf(out,
	        "set multiplot layout 2,2 title \"The job system on simulated machines, by number of CPUs; dotted: the "
	        "goal at 64\" font ',13'\nset grid linecolor rgb '#e0e0e0'\n"
	        "set logscale x 2\nset logscale y\nset xrange [1.8:290]\nset xtics (2, 4, 8, 16, 32, 64, 128, 256)\n"
	        "set xlabel 'CPUs'\n");
	for (size_t i = 0; i < sizeof panels / sizeof *panels; i++)
		write_panel(out, context, &panels[i], i);
	fprintf(out, "unset multiplot\n");
}

bool sim_plot(const sim_points *points, const char *path)
{
	if (gnuplot_save(path, "pngcairo size 1500,1000 font 'sans,11' noenhanced", NULL, write_script, points) == STILB_OK)
		return true;
	stilb_log("%s", stilb_error_message());
	return false;
}
