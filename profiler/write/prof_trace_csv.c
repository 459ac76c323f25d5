/* CSV: one row per frame. A column for each name of zones, in the order of their first occurrence, then one for each
 * counter. */
#include "profiler/prof_internal.h"
#include "profiler/write/prof_text.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define CSV_NONE UINT32_MAX

typedef struct csv_column {
	const char *name;
	bool counter;
	uint32_t open; /* number of zones of this column that are on the stack */
} csv_column;

typedef union csv_cell {
	uint64_t ns;
	double value;
} csv_cell;

typedef struct csv {
	const stilb_prof_snapshot *snapshot;
	csv_column *columns;
	uint32_t column_count;
	uint32_t *zone_columns, *counter_columns; /* by label: the column, or CSV_NONE */
	csv_cell *cells;                          /* one row per frame */
	bool *filled;                             /* by cell: it holds the value of a counter */
	uint32_t *stack;                          /* columns of the zone being added and the zones around it */
	size_t stack_capacity;
} csv;

/* ---- columns ----------------------------------------------------------------------------------------------------- */

/* Gives the label its column. Labels of the same name share one; the search is linear, since names are few. */
static void csv_use(csv *c, uint32_t *of_label, uint32_t label, bool counter)
{
	assert(label < c->snapshot->label_count && c->column_count <= 2 * c->snapshot->label_count);
	const char *name = c->snapshot->labels[label].name;
	if (of_label[label] != CSV_NONE)
		return;
	uint32_t i = 0;
	while (i < c->column_count && (c->columns[i].counter != counter || strcmp(c->columns[i].name, name) != 0))
		i++;
	if (i == c->column_count)
		c->columns[c->column_count++] = (csv_column){.name = name, .counter = counter};
	of_label[label] = i;
}

static bool csv_make_columns(csv *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	size_t labels = (size_t)s->label_count + 1;
	c->columns = calloc(2 * labels, sizeof *c->columns);
	c->zone_columns = malloc(labels * sizeof *c->zone_columns);
	c->counter_columns = malloc(labels * sizeof *c->counter_columns);
	if (!c->columns || !c->zone_columns || !c->counter_columns)
		return false;
	memset(c->zone_columns, 0xff, labels * sizeof *c->zone_columns);
	memset(c->counter_columns, 0xff, labels * sizeof *c->counter_columns);
	for (uint32_t i = 0; i < s->lane_count; i++)
		for (uint32_t j = 0; j < s->lanes[i].zone_count; j++) {
			prof_give_way(j);
			csv_use(c, c->zone_columns, s->lanes[i].zones[j].label, false);
		}
	for (uint32_t i = 0; i < s->point_count; i++)
		if (s->points[i].counter)
			csv_use(c, c->counter_columns, s->points[i].label, true);
	size_t cells = (size_t)s->frame_count * c->column_count + 1;
	c->cells = calloc(cells, sizeof *c->cells);
	c->filled = calloc(cells, sizeof *c->filled);
	return c->cells && c->filled;
}

/* ---- cells ------------------------------------------------------------------------------------------------------- */

/* Removes from the stack all but the ancestors of the zone being added, as many as its level, and pushes the zone's
 * column. False: no memory. */
static bool csv_push(csv *c, uint32_t *depth, uint32_t level, uint32_t column)
{
	while (*depth > level)
		c->columns[c->stack[--*depth]].open--;
	assert(*depth == level && "a zone stands behind its parent");
	if (*depth == c->stack_capacity) {
		size_t capacity = c->stack_capacity > 0 ? 2 * c->stack_capacity : 64;
		uint32_t *stack = realloc(c->stack, capacity * sizeof *stack);
		if (!stack)
			return false;
		c->stack = stack;
		c->stack_capacity = capacity;
	}
	c->stack[(*depth)++] = column;
	c->columns[column].open++;
	return true;
}

static bool csv_add_lane(csv *c, const stilb_prof_lane *lane)
{
	uint32_t depth = 0;
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		uint32_t column = c->zone_columns[zone->label];
		assert(column < c->column_count);
		prof_give_way(i);
		if (!csv_push(c, &depth, zone->level, column))
			return false;
		if (zone->frame < c->snapshot->frame_count && c->columns[column].open == 1)
			c->cells[(size_t)zone->frame * c->column_count + column].ns += zone->end_ns - zone->begin_ns;
	}
	while (depth > 0)
		c->columns[c->stack[--depth]].open--;
	return true;
}

static void csv_add_counters(csv *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	uint32_t frame = 0;
	for (uint32_t i = 0; i < s->point_count; i++) {
		const stilb_prof_point *point = &s->points[i];
		while (frame < s->frame_count && s->frames[frame].end_ns <= point->ns)
			frame++;
		if (!point->counter || !isfinite(point->value) || frame == s->frame_count ||
		    point->ns < s->frames[frame].begin_ns)
			continue;
		assert(c->counter_columns[point->label] < c->column_count);
		size_t cell = (size_t)frame * c->column_count + c->counter_columns[point->label];
		c->cells[cell].value = point->value;
		c->filled[cell] = true;
	}
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

static void csv_quoted(prof_text *text, const char *name)
{
	prof_text_add(text, "\"");
	for (; *name != 0; name++)
		if (*name == '"')
			prof_text_add(text, "\"\"");
		else
			prof_text_bytes(text, name, 1);
	prof_text_add(text, "\"");
}

static void csv_head(const csv *c, prof_text *text)
{
	prof_text_add(text, "frame,begin_ms,ms");
	for (uint32_t i = 0; i < c->column_count; i++) {
		prof_text_add(text, ",");
		csv_quoted(text, c->columns[i].name);
	}
	prof_text_add(text, "\r\n");
}

static void csv_row(const csv *c, prof_text *text, uint32_t row)
{
	const stilb_prof_frame *frame = &c->snapshot->frames[row];
	prof_text_u64(text, frame->number);
	prof_text_add(text, ",");
	prof_text_ms(text, frame->begin_ns);
	prof_text_add(text, ",");
	prof_text_ms(text, frame->end_ns - frame->begin_ns);
	for (uint32_t i = 0; i < c->column_count; i++) {
		size_t cell = (size_t)row * c->column_count + i;
		prof_text_add(text, ",");
		if (!c->columns[i].counter)
			prof_text_ms(text, c->cells[cell].ns);
		else if (c->filled[cell])
			prof_text_double(text, c->cells[cell].value);
	}
	prof_text_add(text, "\r\n");
}

int stilb_prof_trace_write_frames_csv(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink)
{
	assert(snapshot && sink.write);
	csv c = {.snapshot = snapshot};
	prof_text *text = prof_text_create(sink);
	bool good = text && csv_make_columns(&c);
	for (uint32_t i = 0; i < snapshot->lane_count && good; i++)
		good = csv_add_lane(&c, &snapshot->lanes[i]);
	if (good) {
		csv_add_counters(&c);
		csv_head(&c, text);
		for (uint32_t i = 0; i < snapshot->frame_count && text->error == 0; i++)
			csv_row(&c, text, i);
	}
	free(c.stack);
	free(c.filled);
	free(c.cells);
	free(c.counter_columns);
	free(c.zone_columns);
	free(c.columns);
	return prof_text_finish(text, good ? 0 : -ENOMEM);
}
