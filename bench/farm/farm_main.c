/* The program stilb-bench-farm: how well a picture is shared by 1 to 4,096 simulated machines, and by units of which
 * size. Its numbers are computed, not measured: they are the same everywhere. */
#include "bench/farm/farm_sim.h"
#include "game/cli/flags.h"
#include "game/cli/gnuplot.h"

#include <stdio.h>
#include <string.h>

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))
#define MOST_MACHINES 13 /* 1, 2, 4, ..., 4096 */

typedef struct curve {
	const char *title;
	farm_sim_desc desc;
	double efficiency[MOST_MACHINES];
} curve;

typedef struct study {
	curve curves[6];
	size_t curve_count;
	uint32_t sides[6];
	double of_side[2][6]; /* equal machines, uneven machines */
} study;

static study study_run(uint64_t seed)
{
	farm_sim_desc equal = farm_sim_default(), uneven, failing, few, slow;
	equal.seed = seed;
	uneven = failing = few = slow = equal;
	uneven.speed_sigma = 0.5;
	failing.speed_sigma = 0.5;
	failing.failing = 0.05;
	few.samples = 512;
	slow.network_bytes_s = 1.25e8;
	study s = {.curves = {{.title = "4,096 samples, equal machines", .desc = equal},
	                      {.title = "4,096 samples, uneven machines", .desc = uneven},
	                      {.title = "uneven, 5 % of them fail", .desc = failing},
	                      {.title = "4,096 samples, host with 1 Gbit/s", .desc = slow},
	                      {.title = "512 samples, equal machines", .desc = few}},
	           .curve_count = 5,
	           .sides = {4, 8, 16, 32, 64, 128}};
	for (size_t c = 0; c < s.curve_count; c++)
		for (int i = 0; i < MOST_MACHINES; i++) {
			s.curves[c].desc.machines = 1u << i;
			s.curves[c].efficiency[i] = farm_sim_run(&s.curves[c].desc).efficiency;
		}
	for (size_t i = 0; i < COUNT(s.sides); i++)
		for (int k = 0; k < 2; k++) {
			farm_sim_desc desc = k ? uneven : equal;
			desc.unit = s.sides[i];
			s.of_side[k][i] = farm_sim_run(&desc).efficiency;
		}
	return s;
}

static void study_print(const study *s)
{
	printf("efficiency: time if all cores always computed / time; 3840x2160, machines of 8 cores\n\n%-36s", "machines");
	for (int i = 0; i < MOST_MACHINES; i++)
		printf(" %6u", 1u << i);
	for (size_t c = 0; c < s->curve_count; c++) {
		printf("\n%-36s", s->curves[c].title);
		for (int i = 0; i < MOST_MACHINES; i++)
			printf(" %6.3f", s->curves[c].efficiency[i]);
	}
	printf("\n\n1,024 machines, 4,096 samples, by the side of a unit\n\n%-36s", "pixels");
	for (size_t i = 0; i < COUNT(s->sides); i++)
		printf(" %6u", s->sides[i]);
	for (int k = 0; k < 2; k++) {
		printf("\n%-36s", k ? "uneven machines" : "equal machines");
		for (size_t i = 0; i < COUNT(s->sides); i++)
			printf(" %6.3f", s->of_side[k][i]);
	}
	printf("\n");
}

static void study_plot(FILE *out, const void *context)
{
	static const char *const colors[] = {"#c00000", "#0050b0", "#e08000", "#606060", "#007030"};
	const study *s = context;
	for (size_t c = 0; c < s->curve_count; c++) {
		fprintf(out, "$curve%zu << END\n", c);
		for (int i = 0; i < MOST_MACHINES; i++)
			fprintf(out, "%u %.4f\n", 1u << i, s->curves[c].efficiency[i]);
		fprintf(out, "END\n");
	}
	for (int k = 0; k < 2; k++) {
		fprintf(out, "$side%d << END\n", k);
		for (size_t i = 0; i < COUNT(s->sides); i++)
			fprintf(out, "%u %.4f\n", s->sides[i], s->of_side[k][i]);
		fprintf(out, "END\n");
	}
	fprintf(out, "set multiplot layout 1,2\nset grid\nset yrange [0:1.02]\nset logscale x 2\nset key bottom left\n"
	             "set title '4K picture, machines of 8 cores'\nset xlabel 'machines'\nset ylabel 'efficiency'\nplot ");
	for (size_t c = 0; c < s->curve_count; c++)
		fprintf(out,
		        "%s$curve%zu using 1:2 with linespoints linewidth 1.6 pointtype 7 pointsize 0.6 linecolor rgb '%s' "
		        "title '%s'",
		        c ? ", " : "", c, colors[c], s->curves[c].title);
	fprintf(out,
	        "\nset title '1,024 machines, 4,096 samples'\nset xlabel 'side of a unit, pixels'\nunset ylabel\n"
	        "plot $side0 using 1:2 with linespoints linewidth 1.6 pointtype 7 pointsize 0.6 linecolor rgb '%s' title "
	        "'equal machines', $side1 using 1:2 with linespoints linewidth 1.6 pointtype 7 pointsize 0.6 linecolor rgb "
	        "'%s' title 'uneven machines'\nunset multiplot\n",
	        colors[0], colors[1]);
}

int main(int argc, char **argv)
{
	uint64_t seed = 1;
	const char *plot = NULL;
	const flag flags[] = {
		{"--seed", FLAG_NUMBER, &seed, "N", "of speeds, costs, latencies and failures (1)", 0, UINT64_MAX, NULL},
		{"--plot", FLAG_TEXT, &plot, "FILE.svg", "draw it, by gnuplot", 0, 0, NULL},
	};
	flags_result parsed = flags_parse(flags, COUNT(flags), argc - 1, argv + 1);
	if (parsed == FLAGS_HELP) {
		printf("stilb-bench-farm: a picture shared by simulated machines\n");
		flags_print(flags, COUNT(flags));
		return EXIT_DONE;
	}
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	study s = study_run(seed);
	study_print(&s);
	if (plot && !gnuplot_found())
		stilb_log("--plot: " GNUPLOT_MISSING);
	else if (!plot || gnuplot_save(plot, "svg size 1000,420 background '#ffffff' font 'sans-serif,12'",
	                               "Efficiency of simulated machines", study_plot, &s) == STILB_OK)
		return EXIT_DONE;
	else
		stilb_log("%s", stilb_error_message());
	return EXIT_FAILED;
}
