/* Tables of colours: reading .cube files, and looking colours up. */
#include "post/post_table.h"

#include "base/base_contract.h"
#include "base/base_file.h"

#include <ctype.h>
#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TABLE_LINE 250u          /* bytes of a line, at most */
#define TABLE_SAME (1e-3f / 255) /* codes that are taken for equal */
#define TABLE_FILE_MAX (1u << 30)

/* ---- lines ------------------------------------------------------------------------------------------------------- */

typedef struct table_reader {
	const char *name;
	const char *at, *end; /* what is left of the text */
	uint32_t line;        /* number of the one that was read last, from 1 on */
	char text[TABLE_LINE + 1];
	stilb_post_table *table;
	bool low, high; /* the domain's ends were given */
	uint64_t rows;  /* colours so far */
} table_reader;

static stilb_result table_refuse(const table_reader *r, const char *what)
{
	return stilb_fail(STILB_ERROR_FILE, "%s: line %u: %s", r->name, r->line, what);
}

/* Reads the next line that says something, without blanks around it. *more is false at the end. */
static stilb_result table_line(table_reader *r, bool *more)
{
	*more = false;
	while (r->at < r->end) {
		const char *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
		const char *from = r->at, *to = end ? end : r->end;
		r->at = end ? end + 1 : r->end;
		r->line++;
		while (from < to && isspace((unsigned char)*from))
			from++;
		while (to > from && isspace((unsigned char)to[-1]))
			to--;
		if (from == to || *from == '#')
			continue;
		if ((size_t)(to - from) > TABLE_LINE || memchr(from, '\0', (size_t)(to - from)))
			return table_refuse(r, "it is no text of at most 250 bytes");
		memcpy(r->text, from, (size_t)(to - from));
		r->text[to - from] = '\0';
		*more = true;
		return STILB_OK;
	}
	return STILB_OK;
}

/* Reads `count` finite numbers, with points whatever the program's locale has, and nothing behind them. */
static bool table_numbers(const char *text, uint32_t count, float *numbers)
{
	char local[TABLE_LINE + 1];
	snprintf(local, sizeof local, "%s", text);
	for (char *c = local; *c != '\0'; c++)
		if (*c == '.')
			*c = *localeconv()->decimal_point;
	const char *at = local;
	for (uint32_t i = 0; i < count; i++) {
		char *end;
		at += strspn(at, " \t");
		if (!strchr("+-.,0123456789", *at) || *at == '\0')
			return false;
		numbers[i] = strtof(at, &end);
		if (end == at || !isfinite(numbers[i]) || (*end != '\0' && !isspace((unsigned char)*end)))
			return false;
		at = end;
	}
	return at[strspn(at, " \t")] == '\0';
}

/* ---- what lines say ---------------------------------------------------------------------------------------------- */

static uint64_t table_colors(const stilb_post_table *t)
{
	return t->curves ? t->size : (uint64_t)t->size * t->size * t->size;
}

static stilb_result table_make(const char *name, stilb_post_table *t)
{
	uint64_t colors = table_colors(t);
	t->values = malloc(colors * 3 * sizeof *t->values);
	return t->values ? STILB_OK
	                 : stilb_fail(STILB_ERROR_MEMORY, "%s: no memory for %.1f MiB of colours; take a smaller table",
	                              name, (double)colors * 12.0 / 1048576.0);
}

static stilb_result table_size(table_reader *r, bool curves, const char *text)
{
	stilb_post_table *t = r->table;
	uint32_t most = curves ? STILB_POST_TABLE_CURVES : STILB_POST_TABLE_CUBE;
	char *end;
	unsigned long size = strtoul(text, &end, 10);
	if (t->size > 0)
		return table_refuse(r, "the size was given before; a file has one table");
	if (!isdigit((unsigned char)text[0]) || *end != '\0' || size < 2 || size > most)
		return table_refuse(r, curves ? "LUT_1D_SIZE is not a number in 2..65536" : "LUT_3D_SIZE is not in 2..256");
	t->size = (uint32_t)size;
	t->curves = curves;
	return table_make(r->name, t);
}

static stilb_result table_title(table_reader *r, const char *text)
{
	size_t length = strlen(text);
	if (length < 2 || text[0] != '"' || text[length - 1] != '"')
		return table_refuse(r, "TITLE is no text in quotes");
	snprintf(r->table->title, sizeof r->table->title, "%.*s", (int)(length - 2), text + 1);
	return STILB_OK;
}

static stilb_result table_domain(table_reader *r, bool *given, const char *text, float *ends)
{
	if (*given)
		return table_refuse(r, "this end of the domain was given before");
	*given = true;
	return table_numbers(text, 3, ends) ? STILB_OK : table_refuse(r, "the domain's end is not three numbers");
}

/* Both ends of the domain, the same for all channels. */
static stilb_result table_range(table_reader *r, const char *text)
{
	float ends[2];
	if (r->low || r->high)
		return table_refuse(r, "the domain was given before");
	if (!table_numbers(text, 2, ends))
		return table_refuse(r, "the range is not two numbers");
	for (int c = 0; c < 3; c++) {
		r->table->low[c] = ends[0];
		r->table->high[c] = ends[1];
	}
	r->low = r->high = true;
	return STILB_OK;
}

static stilb_result table_color(table_reader *r)
{
	stilb_post_table *t = r->table;
	if (t->size == 0)
		return table_refuse(r, "colours come behind LUT_3D_SIZE or LUT_1D_SIZE, which is missing");
	if (r->rows == table_colors(t))
		return table_refuse(r, "there are more colours than the size says");
	if (!table_numbers(r->text, 3, t->values + 3 * r->rows))
		return table_refuse(r, "a colour is three finite numbers");
	r->rows++;
	return STILB_OK;
}

/* The text behind a keyword, or NULL: the line has another one. */
static const char *table_after(const char *text, const char *keyword)
{
	size_t length = strlen(keyword);
	if (strncmp(text, keyword, length) != 0 || (text[length] != '\0' && !isspace((unsigned char)text[length])))
		return NULL;
	text += length;
	return text + strspn(text, " \t");
}

static stilb_result table_say(table_reader *r)
{
	stilb_post_table *t = r->table;
	const char *rest;
	if (strchr("+-.0123456789", r->text[0]))
		return table_color(r);
	if (r->rows > 0)
		return table_refuse(r, "words come before the colours");
	if ((rest = table_after(r->text, "TITLE")))
		return table_title(r, rest);
	if ((rest = table_after(r->text, "LUT_3D_SIZE")))
		return table_size(r, false, rest);
	if ((rest = table_after(r->text, "LUT_1D_SIZE")))
		return table_size(r, true, rest);
	if ((rest = table_after(r->text, "DOMAIN_MIN")))
		return table_domain(r, &r->low, rest, t->low);
	if ((rest = table_after(r->text, "DOMAIN_MAX")))
		return table_domain(r, &r->high, rest, t->high);
	if ((rest = table_after(r->text, "LUT_3D_INPUT_RANGE")) || (rest = table_after(r->text, "LUT_1D_INPUT_RANGE")))
		return table_range(r, rest);
	return table_refuse(r, "it begins with no word of Cube LUT 1.0 and with no number");
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static stilb_post_table *table_new(void)
{
	stilb_post_table *t = calloc(1, sizeof *t);
	for (int c = 0; t && c < 3; c++)
		t->high[c] = 1.0f;
	return t;
}

static stilb_result table_complete(const table_reader *r)
{
	const stilb_post_table *t = r->table;
	if (t->size == 0)
		return stilb_fail(STILB_ERROR_FILE, "%s: it has no LUT_3D_SIZE and no LUT_1D_SIZE: it is no .cube file",
		                  r->name);
	if (r->rows < table_colors(t))
		return stilb_fail(STILB_ERROR_FILE, "%s: line %u: it ends after %llu of %llu colours", r->name, r->line,
		                  (unsigned long long)r->rows, (unsigned long long)table_colors(t));
	for (int c = 0; c < 3; c++)
		if (!(t->low[c] < t->high[c]))
			return stilb_fail(STILB_ERROR_FILE, "%s: DOMAIN_MIN %g is not below DOMAIN_MAX %g", r->name,
			                  (double)t->low[c], (double)t->high[c]);
	return STILB_OK;
}

stilb_result stilb_post_table_parse(const char *name, const char *text, size_t size, stilb_post_table **table)
{
	STILB_ASSERT(name && (text || size == 0) && table);
	table_reader r = {.name = name, .at = text, .end = text + size, .table = table_new()};
	*table = NULL;
	if (!r.table)
		return stilb_fail(STILB_ERROR_MEMORY, "%s: no memory for a table of colours", name);
	bool more = true;
	stilb_result result = table_line(&r, &more);
	while (result == STILB_OK && more) {
		result = table_say(&r);
		if (result == STILB_OK)
			result = table_line(&r, &more);
	}
	if (result == STILB_OK)
		result = table_complete(&r);
	if (result != STILB_OK) {
		stilb_post_table_destroy(r.table);
		return result;
	}
	*table = r.table;
	return STILB_OK;
}

/* All bytes of a file; to be freed. */
static stilb_result table_read(const char *path, char **text, size_t *size)
{
	FILE *file;
	*text = NULL;
	stilb_result result = stilb_file_read_open(path, &file);
	if (result != STILB_OK)
		return result;
	long bytes = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
	if (bytes < 0 || bytes > (long)TABLE_FILE_MAX) {
		fclose(file);
		return stilb_fail(STILB_ERROR_FILE, "%s: it is larger than 1 GiB: it is no .cube file", path);
	}
	rewind(file);
	*text = malloc((size_t)bytes + 1);
	*size = *text ? fread(*text, 1, (size_t)bytes, file) : 0;
	bool failed = ferror(file) != 0;
	int error = errno;
	fclose(file);
	if (!*text)
		return stilb_fail(STILB_ERROR_MEMORY, "%s: no memory for its %ld bytes", path, bytes);
	if (!failed)
		return STILB_OK;
	free(*text);
	return stilb_fail(STILB_ERROR_FILE, "%s: cannot be read: %s", path, strerror(error));
}

stilb_result stilb_post_table_open(const char *path, stilb_post_table **table)
{
	STILB_ASSERT(path && table);
	char *text;
	size_t size;
	*table = NULL;
	stilb_result result = table_read(path, &text, &size);
	if (result != STILB_OK)
		return result;
	result = stilb_post_table_parse(path, text, size, table);
	free(text);
	return result;
}

void stilb_post_table_destroy(stilb_post_table *table)
{
	if (!table)
		return;
	free(table->values);
	free(table);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

stilb_result stilb_post_table_identity(uint32_t size, stilb_post_table **table)
{
	STILB_ASSERT(size >= 2 && size <= STILB_POST_TABLE_CUBE && table);
	stilb_post_table *t = table_new();
	*table = NULL;
	if (!t)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a table of colours");
	t->size = size;
	stilb_result result = table_make("a table of colours", t);
	if (result != STILB_OK) {
		stilb_post_table_destroy(t);
		return result;
	}
	for (uint32_t i = 0; i < size * size * size; i++) {
		const uint32_t at[3] = {i % size, i / size % size, i / (size * size)};
		for (int c = 0; c < 3; c++)
			t->values[3 * (size_t)i + (size_t)c] = (float)at[c] / (float)(size - 1);
	}
	*table = t;
	return STILB_OK;
}

/* The entry of a cube. */
static const float *table_entry(const stilb_post_table *t, const uint32_t at[3])
{
	return t->values + 3 * (((size_t)at[2] * t->size + at[1]) * t->size + at[0]);
}

/* Adds entries on the way from the cell's first corner to its last one, along the axes, the longest way first. */
static void table_cell(const stilb_post_table *t, const uint32_t first[3], const float beside[3], float out[3])
{
	uint32_t at[3] = {first[0], first[1], first[2]};
	bool gone[3] = {false};
	float before = 1.0f;
	out[0] = out[1] = out[2] = 0.0f;
	for (int step = 0; step < 4; step++) {
		int next = -1;
		for (int c = 0; c < 3; c++)
			if (!gone[c] && (next < 0 || beside[c] > beside[next]))
				next = c;
		float after = next < 0 ? 0.0f : beside[next];
		const float *entry = table_entry(t, at);
		for (int c = 0; c < 3; c++)
			out[c] += entry[c] * (before - after);
		if (next < 0)
			return;
		gone[next] = true;
		at[next]++;
		before = after;
	}
}

void stilb_post_table_at(const stilb_post_table *table, const float code[3], float out[3])
{
	STILB_ASSERT(table && code && out);
	uint32_t first[3];
	float beside[3], last = (float)(table->size - 1);
	for (int c = 0; c < 3; c++) {
		float at = (code[c] - table->low[c]) * (last / (table->high[c] - table->low[c]));
		at = fminf(fmaxf(at, 0.0f), last);
		first[c] = (uint32_t)fminf(at, last - 1.0f);
		beside[c] = at - (float)first[c];
	}
	if (!table->curves) {
		table_cell(table, first, beside, out);
		return;
	}
	for (int c = 0; c < 3; c++) {
		const float *from = table->values + 3 * (size_t)first[c] + c;
		out[c] = from[0] * (1.0f - beside[c]) + from[3] * beside[c];
	}
}

bool stilb_post_table_is_identity(const stilb_post_table *table)
{
	STILB_ASSERT(table);
	uint32_t size = table->size;
	uint64_t colors = table_colors(table);
	for (int c = 0; c < 3; c++)
		if (table->low[c] > 0.0f || table->high[c] < 1.0f)
			return false;
	for (uint64_t i = 0; i < colors; i++) {
		const uint64_t cube[3] = {i % size, i / size % size, i / ((uint64_t)size * size)};
		for (int c = 0; c < 3; c++) {
			float share = (float)(table->curves ? i : cube[c]) / (float)(size - 1);
			float code = table->low[c] + share * (table->high[c] - table->low[c]);
			if (fabsf(table->values[3 * i + (uint64_t)c] - code) > TABLE_SAME)
				return false;
		}
	}
	return true;
}
