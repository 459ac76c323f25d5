/* stilb shade: the command; see shade.h for its parts. */
#include "shade.h"

#include "game/commands.h"

#include <stdio.h>
#include <string.h>

static const struct shade_part {
	const char *name;
	int (*run)(int argc, char **argv);
	const char *help;
} parts[] = {
	{"list", shade_list_command, "list the names of all plots"},
	{"plot", shade_plot_command, "draw the lobes, the albedo and other curves of one formula"},
	{"table", shade_table_command, "measure the formulas of the catalogue, as a table in Markdown"},
	{"catalog", shade_catalog_command, "make all pictures and the table of docs/shading.md"},
	{"spheres", shade_spheres_command, "draw rows of spheres: roughness, energy conservation, models"},
};

#define PARTS (sizeof parts / sizeof *parts)

static void shade_help(void)
{
	printf("stilb shade: shows what the formulas of engine/shading look like.\n\n");
	for (size_t i = 0; i < PARTS; i++)
		printf("  %-8s  %s\n", parts[i].name, parts[i].help);
	printf("\n'stilb shade PART --help' lists a part's flags\n");
}

int shade_command(int argc, char **argv)
{
	for (size_t i = 0; argc > 0 && i < PARTS; i++)
		if (strcmp(argv[0], parts[i].name) == 0)
			return parts[i].run(argc - 1, argv + 1);
	if (argc > 0 && (strcmp(argv[0], "--help") == 0 || strcmp(argv[0], "-h") == 0)) {
		shade_help();
		return EXIT_DONE;
	}
	if (argc == 0)
		stilb_log("shade: no part; 'stilb shade --help' lists them");
	else
		stilb_log("shade: '%s' is not known; 'stilb shade --help' lists the parts", argv[0]);
	return EXIT_REFUSED;
}
