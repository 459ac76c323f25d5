/*
 * gpu_plan: a plan as a drawing. Passes are columns in their order, resources are rows: a bar from the first pass that
 * touches one to the last, a disc where it is written, a ring where it is read, a stroke before the column where a
 * barrier stands. Below, shared memory: time to the right, offsets downwards. What has no room as text is shown by
 * viewers when the pointer rests on it. At the end: a plan as a file.
 */
#include "gpu/gpu_plan_internal.h"

#include "base/base_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define ROW 22.0        /* height of a resource's row, pixels */
#define LEFT 190.0      /* where the columns begin */
#define RIGHT 330.0     /* for what a resource is */
#define TITLE 40.0      /* height */
#define HEAP 160.0      /* height of a heap's drawing */
#define LEGEND 34.0     /* height */
#define LETTER 6.6      /* mean width of a letter, about */
#define NAME_LETTERS 26 /* of a resource's name that are shown */

typedef struct drawing {
	FILE *out;
	const stilb_gpu_plan *plan;
	double column; /* width */
	double head;   /* height of the passes' names */
	double width, height;
	uint32_t *rows, row_count; /* resources that passes touch, by their first step */
} drawing;

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* At most `most` letters of a name, with what XML wants written otherwise. */
static void put_text(FILE *out, const char *text, size_t most)
{
	size_t length = strlen(text);
	for (size_t i = 0; i < length && i < most; i++) {
		unsigned char c = (unsigned char)text[i];
		if (length > most && i + 1 == most)
			fprintf(out, "&#8230;");
		else if (c == '&' || c == '<' || c == '>' || c == '"' || c == '\'')
			fprintf(out, "&#%u;", c);
		else
			fputc(c < 32 || c > 126 ? '?' : c, out);
	}
}

static double column_x(const drawing *d, uint32_t step)
{
	return LEFT + d->column * step;
}

static double row_y(const drawing *d, uint32_t row)
{
	return TITLE + d->head + ROW * row;
}

/* What a pointer shows. */
static void put_barrier_title(const drawing *d, const stilb_gpu_barrier *barrier)
{
	char *text = NULL;
	size_t size = 0;
	FILE *line = open_memstream(&text, &size);
	if (!line)
		return;
	gpu_print_barrier(line, d->plan, barrier);
	if (fclose(line) == 0) {
		fprintf(d->out, "<title>barrier of ");
		put_text(d->out, text, SIZE_MAX);
		fprintf(d->out, "</title>");
	}
	free(text);
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

static void draw_passes(const drawing *d)
{
	const stilb_gpu_step *steps = d->plan->steps.items;
	double bottom = row_y(d, d->row_count);
	for (uint32_t s = 0; s <= d->plan->step_count; s++) {
		bool after = s == d->plan->step_count;
		double x = column_x(d, s) + d->column / 2;
		if (s % 2 == 0)
			fprintf(d->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#f3f5f8\"/>\n",
			        column_x(d, s), TITLE + d->head, d->column, bottom - TITLE - d->head);
		fprintf(d->out, "<text transform=\"translate(%.1f %.1f) rotate(-55)\"%s>", x + 2, TITLE + d->head - 6,
		        after ? " fill=\"#777\"" : "");
		if (!after)
			fprintf(d->out, "%u ", steps[s].pass + 1);
		put_text(d->out, after ? "after the frame" : gpu_plan_row(d->plan, steps[s].pass)->name, NAME_LETTERS);
		fprintf(d->out, "</text>\n");
	}
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

static const char *color_of(const stilb_gpu_placed *placed)
{
	return placed->owned != 0 ? "#c9c9c9" : placed->shared ? "#a9c8ef" : "#b5dfb0";
}

static void draw_resource(const drawing *d, uint32_t row)
{
	uint32_t number = d->rows[row];
	const gpu_resource *resource = gpu_plan_resource(d->plan, number);
	const stilb_gpu_placed *placed = gpu_plan_placed(d->plan, number);
	double y = row_y(d, row);
	bool after = resource->image.output || resource->shown;
	uint32_t steps = d->plan->step_count, last = after ? steps : placed->last_step;
	uint32_t first = placed->first_step < steps ? placed->first_step : steps;
	fprintf(d->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", LEFT - 10, y + 15);
	put_text(d->out, resource->name, NAME_LETTERS);
	fprintf(d->out, "</text>\n<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" rx=\"4\" fill=\"%s\"/>\n",
	        column_x(d, first) + 2, y + 4, d->column * (last - first + 1) - 4, ROW - 8, color_of(placed));
	fprintf(d->out, "<text x=\"%.1f\" y=\"%.1f\" fill=\"#555\">", column_x(d, d->plan->step_count + 1) + 10, y + 15);
	gpu_print_extent(d->out, resource);
	fprintf(d->out, ", ");
	gpu_print_bytes(d->out, placed->bytes);
	fprintf(d->out, "%s%s%s%s%s</text>\n", placed->owned != 0 ? ", owned" : "", resource->image.keep ? ", kept" : "",
	        placed->two ? " twice" : "", resource->image.output ? ", output" : "", resource->shown ? ", shown" : "");
}

static uint32_t row_of(const drawing *d, uint32_t resource)
{
	uint32_t row = 0;
	while (d->rows[row] != resource)
		row++;
	return row;
}

/* What a pass does with a resource: a disc, a ring, or a disc in a ring, for all its uses together. */
static void draw_touches(const drawing *d, uint32_t step)
{
	uint32_t count;
	const stilb_gpu_step *steps = d->plan->steps.items;
	const gpu_touch *touches = gpu_plan_touches(d->plan, steps[step].pass, &count);
	for (uint32_t i = 0; i < count; i++) {
		bool reads = false, writes = false, again = false;
		for (uint32_t k = 0; k < count; k++) {
			if (touches[k].resource != touches[i].resource)
				continue;
			reads = reads || touches[k].reads || touches[k].previous;
			writes = writes || touches[k].writes;
			again = again || k < i;
		}
		if (again)
			continue;
		double x = column_x(d, step) + d->column / 2, y = row_y(d, row_of(d, touches[i].resource)) + ROW / 2;
		if (reads)
			fprintf(
				d->out,
				"<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5.5\" fill=\"#fff\" stroke=\"#1d4f91\" stroke-width=\"1.6\"/>\n",
				x, y);
		if (writes)
			fprintf(d->out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" fill=\"#b3261e\"/>\n", x, y, reads ? "3" : "5.5");
	}
}

static void draw_barriers(const drawing *d, uint32_t step, uint32_t first, uint32_t count)
{
	const stilb_gpu_barrier *barriers = d->plan->barriers.items;
	for (uint32_t i = first; i < first + count; i++) {
		uint32_t before = 0; /* of the same resource: side by side */
		for (uint32_t k = first; k < i; k++)
			before += barriers[k].resource == barriers[i].resource;
		double x = column_x(d, step) + 2 + 3.0 * (before < 4 ? before : 4);
		double y = row_y(d, row_of(d, barriers[i].resource));
		fprintf(d->out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"2.4\" height=\"%.1f\" fill=\"%s\">", x - 1.2, y + 1,
		        ROW - 2, barriers[i].memory ? "#e08a00" : "#444");
		put_barrier_title(d, &barriers[i]);
		fprintf(d->out, "</rect>\n");
	}
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void draw_heap(const drawing *d, uint32_t heap, double top)
{
	double scale = HEAP / (double)stilb_gpu_plan_heap_bytes(d->plan, heap), bottom = top + HEAP;
	fprintf(d->out,
	        "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">heap %u</text>\n<text x=\"%.1f\" y=\"%.1f\" "
	        "text-anchor=\"end\" fill=\"#555\">",
	        LEFT - 10, top + 14, heap, LEFT - 10, top + 30);
	gpu_print_bytes(d->out, stilb_gpu_plan_heap_bytes(d->plan, heap));
	fprintf(d->out,
	        "</text>\n<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#fafafa\" stroke=\"#bbb\"/>\n",
	        LEFT, top, d->column * d->plan->step_count, HEAP);
	for (uint32_t i = 0; i < d->row_count; i++) {
		const stilb_gpu_placed *placed = gpu_plan_placed(d->plan, d->rows[i]);
		if (!placed->shared || placed->heap != heap)
			continue;
		const char *name = gpu_plan_resource(d->plan, d->rows[i])->name;
		double x = column_x(d, placed->first_step) + 1,
			   wide = d->column * (placed->last_step - placed->first_step + 1) - 2;
		double y = top + (double)placed->offset * scale, high = (double)placed->bytes * scale;
		high = y + high > bottom ? bottom - y : high;
		fprintf(d->out, "<g><title>");
		put_text(d->out, name, SIZE_MAX);
		fprintf(d->out, ", ");
		gpu_print_bytes(d->out, placed->bytes);
		fprintf(d->out,
		        " at %llu</title><rect x=\"%.1f\" y=\"%.2f\" width=\"%.1f\" height=\"%.2f\" fill=\"#a9c8ef\" "
		        "stroke=\"#1d4f91\" stroke-width=\"0.7\"/>",
		        (unsigned long long)placed->offset, x, y, wide, high);
		size_t letters = (size_t)(wide / LETTER);
		if (high >= 13 && letters >= 2) {
			fprintf(d->out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" font-size=\"11\">", x + wide / 2,
			        y + high / 2 + 4);
			put_text(d->out, name, letters);
			fprintf(d->out, "</text>");
		}
		fprintf(d->out, "</g>\n");
	}
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static void draw_legend(const drawing *d, double y)
{
	static const struct {
		const char *shape, *text;
	} entries[] = {
		{"<circle cx=\"6\" cy=\"-4\" r=\"5.5\" fill=\"#b3261e\"/>", "written"},
		{"<circle cx=\"6\" cy=\"-4\" r=\"5.5\" fill=\"#fff\" stroke=\"#1d4f91\" stroke-width=\"1.6\"/>", "read"},
		{"<rect x=\"5\" y=\"-13\" width=\"2.4\" height=\"18\" fill=\"#444\"/>", "barrier"},
		{"<rect x=\"5\" y=\"-13\" width=\"2.4\" height=\"18\" fill=\"#e08a00\"/>", "barrier, memory used before"},
		{"<rect x=\"0\" y=\"-11\" width=\"14\" height=\"13\" rx=\"3\" fill=\"#a9c8ef\"/>", "shared memory"},
		{"<rect x=\"0\" y=\"-11\" width=\"14\" height=\"13\" rx=\"3\" fill=\"#b5dfb0\"/>", "memory of its own"},
		{"<rect x=\"0\" y=\"-11\" width=\"14\" height=\"13\" rx=\"3\" fill=\"#c9c9c9\"/>", "owned by the program"},
	};
	double x = 14;
	for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
		fprintf(d->out, "<g transform=\"translate(%.1f %.1f)\">%s<text x=\"20\" y=\"0\">%s</text></g>\n", x, y,
		        entries[i].shape, entries[i].text);
		x += 42 + LETTER * (double)strlen(entries[i].text);
	}
}

static void draw_left_outs(const drawing *d, double y)
{
	const bool *live = d->plan->live.items;
	for (uint32_t row = 0; row < d->plan->row_count; row++) {
		if (live[row])
			continue;
		char *text = NULL;
		size_t size = 0;
		FILE *line = open_memstream(&text, &size);
		if (!line)
			return;
		gpu_print_left_out(line, d->plan, row);
		fprintf(d->out, "<text x=\"14\" y=\"%.1f\" fill=\"#777\">%u left out: ", y, row + 1);
		if (fclose(line) == 0)
			put_text(d->out, text, SIZE_MAX);
		fprintf(d->out, "</text>\n");
		free(text);
		y += 18;
	}
}

/* Sizes that follow from the plan. */
static void lay_out(drawing *d)
{
	const stilb_gpu_step *steps = d->plan->steps.items;
	uint32_t columns = d->plan->step_count + 1;
	d->column = 1400.0 / columns;
	d->column = d->column > 64 ? 64 : d->column < 16 ? 16 : d->column;
	size_t longest = strlen("after the frame");
	for (uint32_t s = 0; s < d->plan->step_count; s++) {
		size_t length = strlen(gpu_plan_row(d->plan, steps[s].pass)->name) + 4;
		length = length > NAME_LETTERS + 4 ? NAME_LETTERS + 4 : length;
		longest = length > longest ? length : longest;
	}
	d->head = 14 + 0.82 * LETTER * (double)longest;
	double legend = 1090, names = 0.58 * LETTER * (double)longest;
	d->width = LEFT + d->column * columns + (RIGHT > names ? RIGHT : names);
	d->width = d->width < legend ? legend : d->width;
	for (uint32_t s = 0; s <= d->plan->step_count; s++) /* at last what is read after the frame alone */
		for (uint32_t i = 1; i <= d->plan->resource_count; i++) {
			const gpu_resource *resource = gpu_plan_resource(d->plan, i);
			uint32_t first = gpu_plan_placed(d->plan, i)->first_step;
			bool after = first == UINT32_MAX && (resource->image.output || resource->shown);
			if (s < d->plan->step_count ? first == s : after)
				d->rows[d->row_count++] = i;
		}
}

static void draw(drawing *d)
{
	const stilb_gpu_plan *plan = d->plan;
	const stilb_gpu_step *steps = plan->steps.items;
	double y = row_y(d, d->row_count) + 18;
	uint32_t heaps = 0;
	for (uint32_t heap = 0; heap < stilb_gpu_plan_heaps(plan); heap++)
		heaps += stilb_gpu_plan_heap_bytes(plan, heap) > 0;
	d->height = y + heaps * (HEAP + 16) + LEGEND + 18.0 * (plan->row_count - plan->step_count);
	fprintf(d->out,
	        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
	        "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n"
	        "<text x=\"14\" y=\"24\" font-size=\"15\">",
	        d->width, d->height, d->width, d->height);
	gpu_print_title(d->out, plan);
	fprintf(d->out, "</text>\n");
	draw_passes(d);
	for (uint32_t row = 0; row < d->row_count; row++)
		draw_resource(d, row);
	for (uint32_t s = 0; s < plan->step_count; s++) {
		draw_barriers(d, s, steps[s].first_barrier, steps[s].barrier_count);
		draw_touches(d, s);
	}
	draw_barriers(d, plan->step_count, plan->last_barrier, plan->barrier_count - plan->last_barrier);
	for (uint32_t heap = 0; heap < stilb_gpu_plan_heaps(plan); heap++)
		if (stilb_gpu_plan_heap_bytes(plan, heap) > 0) {
			draw_heap(d, heap, y);
			y += HEAP + 16;
		}
	draw_legend(d, y + 10);
	draw_left_outs(d, y + LEGEND);
	fprintf(d->out, "</svg>\n");
}

stilb_result stilb_gpu_plan_svg(const stilb_gpu_plan *plan, char **text)
{
	STILB_ASSERT(plan && plan->made && text);
	size_t size = 0;
	*text = NULL;
	drawing d = {.plan = plan};
	d.rows = calloc(plan->resource_count + 1, sizeof *d.rows);
	d.out = d.rows ? open_memstream(text, &size) : NULL;
	bool failed = !d.out;
	if (!failed) {
		lay_out(&d);
		draw(&d);
		failed = ferror(d.out);
		failed = fclose(d.out) != 0 || failed;
	}
	free(d.rows);
	if (!failed)
		return STILB_OK;
	free(*text);
	*text = NULL;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the drawing of a plan");
}

stilb_result stilb_gpu_plan_save(const stilb_gpu_plan *plan, const char *path)
{
	STILB_ASSERT(plan && path);
	size_t length = strlen(path);
	char *text = NULL;
	if (plan->step_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no plan to write to '%s': no frame has been drawn", path);
	bool draws = length >= 4 && strcasecmp(path + length - 4, ".svg") == 0;
	stilb_result result = draws ? stilb_gpu_plan_svg(plan, &text) : stilb_gpu_plan_text(plan, &text);
	if (result != STILB_OK)
		return result;
	result = stilb_file_save(path, text, strlen(text));
	free(text);
	return result;
}
