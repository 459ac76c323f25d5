/* stilb shade list, plot and catalog: lists the names of all plots, draws the one of a name, or draws all. */
#include "shade.h"

#include "base/base_file.h"
#include "game/cli/gnuplot.h"
#include "numeric/numeric_catalog.h"
#include "shade_plots.h"
#include "shade_strip.h"
#include "shade_table.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const plot_topic *const plot_topics[] = {&shade_plots_brdf, &shade_plots_light, &shade_plots_sg,
                                                &shade_plots_sh,   &shade_plots_color, &shade_plots_sampling};
static const uint32_t plot_topic_count = sizeof plot_topics / sizeof plot_topics[0];

static const plot *plot_find(const char *name)
{
	for (uint32_t t = 0; t < plot_topic_count; t++)
		for (uint32_t i = 0; i < plot_topics[t]->count; i++)
			if (strcmp(plot_topics[t]->plots[i].name, name) == 0)
				return &plot_topics[t]->plots[i];
	return NULL;
}

/* ---- list -------------------------------------------------------------------------------------------------------- */

static void list_row(const stilb_numeric_row *row)
{
	char name[64], formula[256];
	shade_plot_typed(name, sizeof name, row->name);
	shade_plot_typed(formula, sizeof formula, row->formula);
	printf("  %-34s %s\n", name, formula);
}

static void list_rows(stilb_numeric_kind kind, const char *heading)
{
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	printf("\n%s\n", heading);
	for (size_t i = 0; i < count; i++) {
		if (rows[i].kind == kind)
			list_row(&rows[i]);
	}
}

int shade_list_command(int argc, char **argv)
{
	flags_result parsed = flags_parse(NULL, 0, argc, argv);
	if (parsed == FLAGS_HELP)
		printf("stilb shade list: lists the names that 'stilb shade plot' accepts, by topic.\n");
	if (parsed != FLAGS_OK)
		return parsed == FLAGS_HELP ? EXIT_DONE : EXIT_REFUSED;
	for (uint32_t t = 0; t < plot_topic_count; t++) {
		printf("%s%s\n", t > 0 ? "\n" : "", plot_topics[t]->name);
		for (uint32_t i = 0; i < plot_topics[t]->count; i++)
			printf("  %-34s %s\n", plot_topics[t]->plots[i].name, plot_topics[t]->plots[i].title);
	}
	list_rows(STILB_NUMERIC_DISTRIBUTION, "distributions");
	list_rows(STILB_NUMERIC_BRDF, "reflection models");
	list_rows(STILB_NUMERIC_SAMPLER, "samplers");
	return EXIT_DONE;
}

/* ---- plot -------------------------------------------------------------------------------------------------------- */

/* Removes the first word that is neither a flag nor the value of -o from the arguments and returns it; NULL: there is
 * none. */
static const char *take_name(int *argc, char **argv)
{
	for (int i = 0; i < *argc; i++) {
		const char *word = argv[i];
		if (word[0] == '-' || (i > 0 && strcmp(argv[i - 1], "-o") == 0))
			continue;
		for (int k = i + 1; k < *argc; k++)
			argv[k - 1] = argv[k];
		(*argc)--;
		return word;
	}
	return NULL;
}

#define NAME_SIZE 64
#define NEAR_NAMES 6 /* similar names that the message about an unknown one offers at most */

/* The least number of letters to insert, remove or change that turns a into b. Upper case letters of a count as lower
 * case; b has only lower case ones. Source: Levenshtein (1965). */
static int edits(const char *a, const char *b)
{
	STILB_ASSERT(strlen(b) < NAME_SIZE);
	int row[NAME_SIZE]; /* row[k]: edits from the part of a that was read so far to the first k letters of b */
	int length = (int)strlen(b);
	for (int k = 0; k <= length; k++)
		row[k] = k;
	for (int i = 0; a[i]; i++) {
		int diagonal = row[0]++;
		for (int k = 1; k <= length; k++) {
			int change = diagonal + (tolower((unsigned char)a[i]) != b[k - 1]);
			int step = (row[k] < row[k - 1] ? row[k] : row[k - 1]) + 1;
			diagonal = row[k];
			row[k] = change < step ? change : step;
		}
	}
	return row[length];
}

/* The ways in which a name may be near to a typed word, in the order in which names are offered: it begins with the
 * word, contains it, or differs by a few letters. */
typedef enum nearness { NEAR_BEGINS, NEAR_CONTAINS, NEAR_MISTYPED, NEAR_KINDS } nearness;

static bool is_near(const char *name, const char *typed, nearness how)
{
	const char *at = strcasestr(name, typed);
	if (how == NEAR_MISTYPED)
		return !at && 3 * edits(typed, name) <= (int)strlen(typed) + 1;
	return at && (at == name) == (how == NEAR_BEGINS);
}

typedef struct near_names {
	const char *typed;
	nearness how;
	char words[NEAR_NAMES * (NAME_SIZE + 2)]; /* the names that are offered: "a, b" */
	size_t length;                            /* of words */
	int count;
} near_names;

/* Appends the name, with '-' for each '_', if it is near to the typed word and fewer than NEAR_NAMES are there yet. */
static void offer(near_names *near, const char *name)
{
	char word[NAME_SIZE];
	shade_plot_typed(word, sizeof word, name);
	if (near->count == NEAR_NAMES || !is_near(word, near->typed, near->how))
		return;
	near->length += (size_t)snprintf(near->words + near->length, sizeof near->words - near->length, "%s%s",
	                                 near->count > 0 ? ", " : "", word);
	near->count++;
}

static void refuse_name(const char *name)
{
	char typed[NAME_SIZE];
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	shade_plot_typed(typed, sizeof typed, name);
	near_names near = {.typed = typed};
	for (near.how = 0; near.how < NEAR_KINDS; near.how++) {
		for (uint32_t t = 0; t < plot_topic_count; t++)
			for (uint32_t i = 0; i < plot_topics[t]->count; i++)
				offer(&near, plot_topics[t]->plots[i].name);
		for (size_t i = 0; i < count; i++)
			offer(&near, rows[i].name);
	}
	if (near.count > 0)
		stilb_log("shade plot: '%s' is not known; similar: %s; 'stilb shade list' lists all names", name, near.words);
	else
		stilb_log("shade plot: '%s' is not known; 'stilb shade list' lists the names", name);
}

int shade_plot_command(int argc, char **argv)
{
	const char *name = take_name(&argc, argv), *second = take_name(&argc, argv), *output = NULL;
	const flag flags[] = {{"-o", FLAG_TEXT, &output, "FILE", "the picture: .svg or .png", 0, 0, NULL}};
	flags_result parsed = flags_parse(flags, 1, argc, argv);
	if (parsed == FLAGS_HELP) {
		printf(
			"stilb shade plot NAME -o FILE: draws the lobes, the albedo and other curves of a formula with gnuplot.\n"
			"'stilb shade list' lists the names.\n\n");
		flags_print(flags, 1);
		return EXIT_DONE;
	}
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	row_plot of_row;
	const plot *p = name ? plot_find(name) : NULL;
	if (name && !p && shade_plot_of_row(name, &of_row))
		p = &of_row.plot;
	if (!name)
		stilb_log("shade plot: no name; give stilb shade plot NAME -o FILE; 'stilb shade list' lists them");
	else if (second)
		stilb_log("shade plot: '%s' is a second name after '%s'; give one name, the picture is -o FILE", second, name);
	else if (!p)
		refuse_name(name);
	else if (!output)
		stilb_log("shade plot: no output; give -o FILE.svg or FILE.png");
	else if (!gnuplot_found())
		stilb_log("shade plot: " GNUPLOT_MISSING);
	else if (plot_path_check(output) != STILB_OK)
		stilb_log("%s", stilb_error_message());
	else if (plot_save(p, output) != STILB_OK)
		return shade_complain(EXIT_FAILED);
	else {
		fprintf(stilb_file_is_stdout(output) ? stderr : stdout, "picture: %s\n", output);
		return EXIT_DONE;
	}
	return EXIT_REFUSED;
}

/* ---- catalog ----------------------------------------------------------------------------------------------------- */

/* The formulas of numeric's catalogue (numeric_catalog.h) that get a picture each. The other microfacet models, each a
 * pair of a distribution D and a shadowing term G, are in the table alone. */
static const char *const catalog_rows[] = {
	"d-blinn",
	"d-beckmann",
	"d-ggx",
	"d-ggx-anisotropic",
	"d-blinn-phong",
	"d-heightfield",
	"d-vmf",
	"lambert",
	"wrapped",
	"phong",
	"phong-modified",
	"blinn-phong",
	"blinn-phong-modified",
	"minimalist",
	"ggx-smith-ggx",
	"ggx-smith-beckmann",
};

static stilb_result catalog_path(char path[PATH_MAX], const char *folder, const char *name, const char *extension)
{
	if (snprintf(path, PATH_MAX, "%s/%s%s", folder, name, extension) >= PATH_MAX)
		return stilb_fail(STILB_ERROR_ARGUMENT, "-o: '%s' is too long", folder);
	return STILB_OK;
}

static stilb_result catalog_plot(const plot *p, const char *name, const char *folder)
{
	char path[PATH_MAX];
	stilb_result result = catalog_path(path, folder, name, p->cloud ? ".png" : ".svg");
	if (result == STILB_OK)
		result = plot_save(p, path);
	if (result == STILB_OK)
		printf("%s\n", path);
	return result;
}

static stilb_result catalog_plots(const char *folder)
{
	stilb_result result = STILB_OK;
	for (uint32_t t = 0; t < plot_topic_count; t++)
		for (uint32_t i = 0; i < plot_topics[t]->count && result == STILB_OK; i++)
			result = catalog_plot(&plot_topics[t]->plots[i], plot_topics[t]->plots[i].name, folder);
	for (size_t i = 0; i < sizeof catalog_rows / sizeof *catalog_rows && result == STILB_OK; i++) {
		row_plot of_row;
		if (shade_plot_of_row(catalog_rows[i], &of_row))
			result = catalog_plot(&of_row.plot, catalog_rows[i], folder);
	}
	return result;
}

/* Width of a sphere in pixels; the documentation shows the pictures without scaling. */
#define CATALOG_SPHERE 64.0f

static stilb_result catalog_strips(const char *folder)
{
	stilb_result result = STILB_OK;
	for (int i = 0; i < strip_count && result == STILB_OK; i++) {
		char path[PATH_MAX], name[64];
		uint32_t size[2];
		strip_size(&strips[i], CATALOG_SPHERE, size);
		snprintf(name, sizeof name, "spheres-%s", strips[i].name);
		result = catalog_path(path, folder, name, ".png");
		if (result == STILB_OK)
			result = strip_save(&strips[i], size, FLAG_WORKERS_AUTO, path);
		if (result == STILB_OK)
			printf("%s\n", path);
	}
	return result;
}

static stilb_result catalog_table(const char *folder)
{
	char path[PATH_MAX];
	stilb_result result = catalog_path(path, folder, "table", ".md");
	if (result == STILB_OK)
		result = shade_table_save(path);
	if (result == STILB_OK)
		printf("%s\n", path);
	return result;
}

int shade_catalog_command(int argc, char **argv)
{
	const char *folder = NULL;
	const flag flags[] = {
		{"-o", FLAG_TEXT, &folder, "FOLDER", "folder for the files; it is made if its parent exists", 0, 0, NULL}};
	flags_result parsed = flags_parse(flags, 1, argc, argv);
	if (parsed == FLAGS_HELP) {
		printf("stilb shade catalog -o FOLDER: makes every picture and the table of docs/shading.md.\n\n");
		flags_print(flags, 1);
		return EXIT_DONE;
	}
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (!folder) {
		stilb_log("shade catalog: no output; give -o FOLDER");
		return EXIT_REFUSED;
	}
	if (!gnuplot_found()) {
		stilb_log("shade catalog: " GNUPLOT_MISSING);
		return EXIT_REFUSED;
	}
	if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
		stilb_log("-o: cannot make the folder '%s': %s", folder,
		          errno == ENOENT ? "its parent does not exist; create that first" : strerror(errno));
		return EXIT_REFUSED;
	}
	stilb_result result = catalog_plots(folder);
	if (result == STILB_OK)
		result = catalog_strips(folder);
	if (result == STILB_OK)
		result = catalog_table(folder);
	return result == STILB_OK ? EXIT_DONE : shade_complain(EXIT_FAILED);
}
