/* The live view of stilb pads --watch: a few lines for each pad, drawn over the last ones. */
#include "pads.h"

#include <inttypes.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define VIEW_BAR 21             /* columns; odd, so that there is a middle for a stick at rest */
#define VIEW_RATE_NS 1000000000 /* time over which the rates of reports are measured */

/* The lines of all pads, composed here and written to the terminal in one go. */
typedef struct view_text {
	size_t length;
	int lines;
	char bytes[32768];
} view_text;

static void view_print(view_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void view_print(view_text *text, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	STILB_ASSERT(text->length < sizeof text->bytes);
	size_t room = sizeof text->bytes - text->length;
	int length = vsnprintf(text->bytes + text->length, room, format, arguments);
	va_end(arguments);
	text->length += length < 0 ? 0 : (size_t)length < room ? (size_t)length : room - 1;
}

/* Ends a line and clears what the line that it overwrites had to its right. */
static void view_end_line(view_text *text)
{
	view_print(text, "\033[K\n");
	text->lines++;
}

/* A bar of VIEW_BAR columns that is filled from `from` to `to`, 0 (left end) .. 1 (right end). */
static void view_print_bar(view_text *text, float from, float to)
{
	int first = (int)((from < to ? from : to) * (VIEW_BAR - 1) + 0.5f);
	int last = (int)((from < to ? to : from) * (VIEW_BAR - 1) + 0.5f);
	STILB_ASSERT(first >= 0 && last < VIEW_BAR);
	char bar[VIEW_BAR + 1];
	memset(bar, '.', VIEW_BAR);
	for (int i = first; i <= last; i++)
		bar[i] = '#';
	bar[VIEW_BAR] = '\0';
	view_print(text, "[%s]", bar);
}

static void view_print_stick(view_text *text, const char *name, const float axes[2])
{
	view_print(text, "  %-12s x %+.2f ", name, (double)axes[0]);
	view_print_bar(text, 0.5f, 0.5f + 0.5f * axes[0]);
	view_print(text, "  y %+.2f ", (double)axes[1]);
	view_print_bar(text, 0.5f, 0.5f + 0.5f * axes[1]);
	view_end_line(text);
}

static void view_print_triggers(view_text *text, const float axes[2])
{
	view_print(text, "  triggers     l  %.2f ", (double)axes[0]);
	view_print_bar(text, 0.0f, axes[0]);
	view_print(text, "  r  %.2f ", (double)axes[1]);
	view_print_bar(text, 0.0f, axes[1]);
	view_end_line(text);
}

static double view_rate(const pads_view *view, uint32_t pad)
{
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++)
		if (view->rates[i].pad == pad)
			return view->rates[i].rate;
	return 0.0;
}

/* Measures the report rate of each pad again every VIEW_RATE_NS. All reports of a new pad count as received since the
 * last measurement. */
static void view_measure(pads_view *view, const stilb_input_control_pad *pads, uint32_t count)
{
	uint64_t now = stilb_time_ns(), passed = now - view->rate_ns;
	if (passed < VIEW_RATE_NS)
		return;
	pads_view next = {.lines = view->lines, .rate_ns = now};
	for (uint32_t i = 0; i < count; i++) {
		uint64_t before = 0;
		for (uint32_t k = 0; k < STILB_INPUT_PADS_MAX; k++)
			if (view->rates[k].pad == pads[i].pad)
				before = view->rates[k].reports;
		next.rates[i].pad = pads[i].pad;
		next.rates[i].reports = pads[i].reports + pads[i].corrupt;
		next.rates[i].rate = (double)(next.rates[i].reports - before) / ((double)passed * 1e-9);
	}
	*view = next;
}

static void view_print_denied(view_text *text, const stilb_input_pad_info *info)
{
	char rule[512];
	view_print(text, "  no permission; 'stilb pads' says more. The udev rule that it needs:");
	view_end_line(text);
	view_print(text, "  %s", stilb_input_udev_rule(info, rule, sizeof rule));
	view_end_line(text);
}

static void view_print_pad(view_text *text, const pads_view *view, const stilb_input_control_pad *pad, int64_t time_us)
{
	char buttons[PADS_BUTTONS_SIZE];
	const float *axes = pad->state.axes;
	view_print(text, "%s (%s)%s%s%s", pad->info->name, pad->name, pad->info->path[0] ? " " : "", pad->info->path,
	           pad->leads ? ", leads" : "");
	view_end_line(text);
	if (pad->denied) {
		view_print_denied(text, pad->info);
		return;
	}
	view_print_stick(text, "left stick", &axes[STILB_INPUT_LEFT_X]);
	view_print_stick(text, "right stick", &axes[STILB_INPUT_RIGHT_X]);
	view_print_triggers(text, &axes[STILB_INPUT_LEFT_TRIGGER]);
	view_print(text, "  buttons      %s", pads_buttons_text(pad->state.buttons, buttons));
	view_end_line(text);
	view_print(text, "  reports      %" PRIu64 ", %.0f a second, %" PRIu64 " corrupt", pad->reports,
	           view_rate(view, pad->pad), pad->corrupt);
	if (pad->reports > 0)
		view_print(text, "; the last %.0f ms ago", (double)(time_us - pad->last_us) * 1e-3);
	view_end_line(text);
}

/* Returns the rows of the terminal. The view must have fewer lines, so that the cursor can go back to the first. */
static int view_rows(void)
{
	struct winsize size;
	return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1 ? size.ws_row : 24;
}

/* Drops the last lines if the text does not fit into a terminal of so many rows. */
static void view_cut(view_text *text, int rows)
{
	char *end = text->bytes;
	if (text->lines < rows)
		return;
	for (int line = 0; line < rows - 1; line++)
		end = strchr(end, '\n') + 1;
	text->length = (size_t)(end - text->bytes);
	text->lines = rows - 1;
}

void pads_view_begin(pads_view *view)
{
	*view = (pads_view){.rate_ns = stilb_time_ns()};
	fputs("\033[?25l\033[?7l", stdout); /* no cursor, no line wrap */
}

void pads_view_finish(void)
{
	fputs("\033[?7h\033[?25h", stdout);
	fflush(stdout);
}

void pads_view_draw(pads_view *view, const stilb_input_control *control, int64_t time_us)
{
	static view_text text;
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_input_control_pads(control, pads);
	view_measure(view, pads, count);
	text.length = 0;
	text.lines = 0;
	for (uint32_t i = 0; i < count; i++)
		view_print_pad(&text, view, &pads[i], time_us);
	view_print(&text, count == 0 ? "no gamepad yet: plug one in; Ctrl-C ends" : "Ctrl-C ends");
	view_end_line(&text);
	view_cut(&text, view_rows());
	if (view->lines > 0)
		printf("\033[%dA", view->lines);
	printf("\r%.*s\033[J", (int)text.length, text.bytes);
	fflush(stdout);
	view->lines = text.lines;
}
