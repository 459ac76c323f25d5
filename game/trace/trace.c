/* stilb trace: the command; see trace.h for its parts. */
#include "trace.h"

#include "game/cli/flags.h"
#include "game/commands.h"

#include <string.h>

static bool trace_is_help(const char *word)
{
	return strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0;
}

/* True if the first argument is a flag. Files must come first: a word behind a flag could be the flag's value or a
 * file. */
static bool trace_begins_with_a_flag(int argc, char **argv)
{
	return argc > 0 && argv[0][0] == '-' && argv[0][1] != '\0' && !trace_is_help(argv[0]);
}

int trace_command(int argc, char **argv)
{
	static const struct {
		const char *name, *files;
		int (*run)(int argc, char **argv);
	} parts[] = {
		{"top", "FILE", trace_top_command}, {"diff", "A B", trace_diff_command}, {"show", "FILE", trace_show_command}};
	for (size_t i = 0; argc > 0 && i < sizeof parts / sizeof *parts; i++) {
		if (strcmp(argv[0], parts[i].name) != 0)
			continue;
		if (!trace_begins_with_a_flag(argc - 1, argv + 1))
			return parts[i].run(argc - 1, argv + 1);
		stilb_log("trace %s: the flag '%s' stands before the file; give stilb trace %s %s [FLAGS]", parts[i].name,
		          argv[1], parts[i].name, parts[i].files);
		return EXIT_REFUSED;
	}
	if (argc > 0 && trace_is_help(argv[0])) {
		printf("stilb trace: analyses a trace that 'stilb demo --trace FILE' wrote.\n\n"
		       "  top FILE   the zones that take the most time\n"
		       "  diff A B   the zones that got slower from A to B\n"
		       "  show FILE  the timeline in a window, or as a picture\n\n"
		       "'stilb trace PART --help' lists a part's flags\n");
		return EXIT_DONE;
	}
	if (argc == 0)
		stilb_log("trace: no part; give top, diff or show, 'stilb trace --help' explains them");
	else
		stilb_log("trace: '%s' is not known; give top, diff or show, 'stilb trace --help' explains them", argv[0]);
	return EXIT_REFUSED;
}
