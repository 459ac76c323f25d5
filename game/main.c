/* The stilb program: finds the subcommand and runs it. */
#include "commands.h"
#include "game/cli/flags.h"
#include "game/cli/nearest.h"
#include "profiler/prof.h"

#include <limits.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

static const struct command {
	const char *name;
	int (*run)(int argc, char **argv);
	const char *help;
} commands[] = {
	{"demo", demo_command, "draw the stress test: thousands of models, recorded by many threads"},
	{"view", view_command, "show a scene in a window: a model of yours, or one that is built in"},
	{"render", offline_command, "make a picture of a scene by ray tracing: path tracer, irradiance cache, occlusion"},
	{"bake", bake_command, "unwrap a scene and bake the light on its surfaces: lightmaps, ambient occlusion"},
	{"bench", bench_command, "measure culling, recording, threads, queues and jobs on this machine"},
	{"replay", replay_command, "draw a frame that 'stilb demo --dump' wrote, and measure its commands"},
	{"trace", trace_command, "show what takes the time in a trace file, and what got slower in another"},
	{"shade", shade_command, "draw what the shading formulas look like: lobes, curves, spheres"},
	{"pads", pads_command, "list gamepads; watch, record and replay what they report; explain descriptors"},
	{"info", info_command, "show the CPU's features, the GPUs and the libraries, or what a scene has"},
};

static void print_help(void)
{
	printf("Stilb " STILB_VERSION ", a multithreaded render engine\n\nusage: stilb COMMAND [FLAGS]\n\n");
	for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
		printf("  %-10s %s\n", commands[i].name, commands[i].help);
	printf(
		"\n  --version  print the version\n  --help     print this; 'stilb COMMAND --help' lists a command's flags\n");
}

/* Returns the exit code of a command that ended with code: standard output that could not be written, to a full disk or
 * a closed pipe, is a failure too. */
static int finish(int code)
{
	if ((fflush(stdout) != 0 || ferror(stdout)) && code == EXIT_DONE) {
		stilb_log("cannot write to standard output");
		return EXIT_FAILED;
	}
	return code;
}

/* Keeps freed memory in the process. A Vulkan driver that draws on the CPU frees and allocates the same sizes in each
 * frame; returning them to the kernel in between takes a tenth of the frame's time or more. */
static void keep_freed_memory(void)
{
	mallopt(M_TRIM_THRESHOLD, INT_MAX);
	mallopt(M_MMAP_THRESHOLD, 32 << 20); /* bytes; the largest value that mallopt accepts */
}

int main(int argc, char **argv)
{
	keep_freed_memory();
	stilb_prof_record_set(false); /* commands that show or write a profile switch recording on */
	signal(SIGPIPE, SIG_IGN);     /* a closed pipe becomes an error of one output; the others are still written */
	if (argc < 2) {
		stilb_log("no command; 'stilb demo' runs the stress test, 'stilb --help' lists all");
		return EXIT_REFUSED;
	}
	if (strcmp(argv[1], "--version") == 0) {
		printf("stilb " STILB_VERSION "\n");
		return finish(EXIT_DONE);
	}
	if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
		print_help();
		return finish(EXIT_DONE);
	}
	for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
		if (strcmp(argv[1], commands[i].name) == 0)
			return finish(commands[i].run(argc - 2, argv + 2));
	nearest_word nearest = nearest_begin(argv[1], strlen(argv[1]));
	for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
		nearest_try(&nearest, commands[i].name);
	if (nearest.best)
		stilb_log("unknown command '%s'; did you mean 'stilb %s'? 'stilb --help' lists all", argv[1], nearest.best);
	else
		stilb_log("unknown command '%s'; 'stilb --help' lists them", argv[1]);
	return EXIT_REFUSED;
}
