/* stilb shade: what the formulas of engine/shading look like. One part a file. */
#include "shade.h"

#include "game/commands.h"

#include <stdio.h>
#include <string.h>

static const struct shade_part {
	const char *name;
	int (*run)(int argc, char **argv);
	const char *help;
} parts[] = {
	{"list", shade_list_command, "the names of all plots"},
	{"plot", shade_plot_command, "lobes, albedo and other curves of one formula"},
	{"table", shade_table_command, "measures, flags and albedos of the catalogue, as Markdown"},
	{"catalog", shade_catalog_command, "all pictures and the table of docs/shading.md"},
	{"spheres", shade_spheres_command, "rows of spheres as a picture: roughness, energy conservation, models"},
};

#define PARTS (sizeof parts / sizeof *parts)

static void shade_help(void)
{
	printf("stilb shade: what the formulas of engine/shading look like.\n\n");
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
		stilb_log("shade: nothing to do; 'stilb shade --help' lists its parts");
	else
		stilb_log("shade: '%s' is not known; 'stilb shade --help' lists its parts", argv[0]);
	return EXIT_REFUSED;
}
