/* Calls that break what game/cli and game/shade/shade_plot.h demand of their callers; each must end in the right
 * assert. */
#include "game/cli/flags.h"
#include "game/cli/gnuplot.h"
#include "game/cli/stage_times.h"
#include "game/cli/trace_path.h"
#include "game/shade/shade_plot.h"
#include "support/contract.h"
#include "support/test.h"

static uint64_t number;
static bool given;
static int choice;
static flag_list list;

static flags_result parse(flag row)
{
	return flags_parse(&row, 1, 0, NULL);
}

static void test_tables_of_flags(void **state)
{
	(void)state;
	static const flag twice[] = {
		{"--number", FLAG_NUMBER, &number, "N", "a number", 1, 9, NULL},
		{"--number", FLAG_SWITCH, &given, NULL, "the same name", 0, 0, NULL},
	};
	static const char *const none[] = {NULL};
	assert_int_equal(parse(twice[0]), FLAGS_OK);
	contract_breaks("flags_are_sound", flags_parse(twice, 2, 0, NULL));
	contract_breaks("flags_are_sound", parse((flag){"number", FLAG_NUMBER, &number, "N", "no dashes", 1, 9, NULL}));
	contract_breaks("flags_are_sound", parse((flag){"--number", FLAG_NUMBER, &number, "N", "range", 9, 1, NULL}));
	contract_breaks("flags_are_sound", parse((flag){"--number", FLAG_NUMBER, NULL, "N", "no value", 1, 9, NULL}));
	contract_breaks("flags_are_sound", parse((flag){"--number", FLAG_NUMBER, &number, NULL, "no N", 1, 9, NULL}));
	contract_breaks("flags_are_sound", parse((flag){"--given", FLAG_SWITCH, &given, "N", "takes none", 0, 0, NULL}));
	contract_breaks("flags_are_sound", parse((flag){"--choice", FLAG_CHOICE, &choice, "A", "of none", 0, 0, none}));
	contract_breaks("flags_are_sound", parse((flag){"--list", FLAG_LIST, &list, "X,Y", "too long", 1, 9, NULL}));
	contract_breaks("argc >= 0", flags_parse(twice, 1, 1, NULL));
	contract_breaks("find_flag", flags_given(twice, 1, 0, NULL, "--nmber"));
	contract_breaks("low <= high", flags_numbers("1,2", 3, 2, &list));
	contract_breaks("high <= 8", flags_numbers("1,2", 1, FLAG_LIST_MAX + 1, &list));
}

static void test_stage_times(void **state)
{
	(void)state;
	stage_times torn = {.capacity = 8};
	stilb_engine_times frame = {0};
	contract_breaks("!times->frames == !times->capacity", stage_times_add(&torn, &frame));
}

static void test_names_of_traces(void **state)
{
	(void)state;
	assert_true(trace_path_check("--trace", NULL));
	contract_breaks("flag", trace_path_check(NULL, NULL));
}

/* ---- plots ------------------------------------------------------------------------------------------------------- */

/* Replaces game/cli/gnuplot.c, which would leave its temporary folder behind when the script aborts. */
stilb_result gnuplot_save(const char *path, const char *terminal, const char *svg_title, gnuplot_script *script,
                          const void *context)
{
	(void)path, (void)terminal, (void)svg_title;
	script(tmpfile(), context);
	return STILB_OK;
}

static const plot_panel empty = {.title = "empty"};

static plot_point unit(double t, const void *context)
{
	(void)context;
	return (plot_point){t, 1.0};
}

static void draw_outside(plot_page *page, const void *subject)
{
	(void)subject;
	plot_curve(page, unit, NULL, 0.0, 1.0, 2, NULL, "%s", "");
}

static void draw_nested(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &empty);
	plot_panel_begin(page, &empty);
}

static void draw_nothing(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &empty);
	plot_panel_end(page);
}

static void draw_point(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &empty);
	plot_curve(page, unit, NULL, 0.0, 1.0, 1, NULL, "%s", "");
}

static void draw_log_of_zero(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "log", .logarithmic = "x"});
	plot_curve(page, unit, NULL, 0.0, 1.0, 2, NULL, "%s", "");
}

static stilb_result save(void (*draw)(plot_page *page, const void *subject))
{
	plot p = {.name = "p", .title = "p", .formula = "", .source = "", .columns = 1, .rows = 1, .draw = draw};
	return plot_save(&p, "contract.svg");
}

static void test_plots(void **state)
{
	(void)state;
	contract_breaks("p->columns > 0 && p->rows > 0 && p->draw", save(NULL));
	contract_breaks("curves belong into a panel", save(draw_outside));
	contract_breaks("the panel before has not been ended", save(draw_nested));
	contract_breaks("page->open && page->clauses[0]", save(draw_nothing));
	contract_breaks("points >= 2", save(draw_point));
	contract_breaks("from > 0.0", save(draw_log_of_zero));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_tables_of_flags),
		cmocka_unit_test(test_stage_times),
		cmocka_unit_test(test_names_of_traces),
		cmocka_unit_test(test_plots),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
