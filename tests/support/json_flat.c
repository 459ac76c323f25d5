#include "json_flat.h"

#include "trace_check.c" /* its JSON half; what is a trace does not matter here */

typedef struct flat_parser {
	parser parser; /* first: what the parser hands back is this */
	json_flat *out;
	char path[512];
	size_t index[DEPTH_MAX + 2]; /* of the next element, per depth */
} flat_parser;

static bool flat_value(parser *p, int depth);

/* Parses one value inside an object or array; step (".key" or "[index]") is appended to the path meanwhile. */
static bool flat_step(flat_parser *f, const char *step, int depth)
{
	size_t length = strlen(f->path);
	snprintf(f->path + length, sizeof f->path - length, "%s", step);
	bool good = flat_value(&f->parser, depth);
	f->path[length] = '\0';
	return good;
}

static bool flat_member(parser *p, const char *key, int depth)
{
	flat_parser *f = (flat_parser *)p;
	char step[256];
	snprintf(step, sizeof step, "%s%s", f->path[0] ? "." : "", key);
	return flat_step(f, step, depth);
}

static bool flat_element(parser *p, int depth)
{
	flat_parser *f = (flat_parser *)p;
	char step[32];
	snprintf(step, sizeof step, "[%zu]", f->index[depth]++);
	return flat_step(f, step, depth);
}

static void flat_add(flat_parser *f, char kind, const char *text, size_t size)
{
	json_flat *out = f->out;
	out->values = grow(out->values, out->count, &out->capacity, sizeof *out->values);
	out->values[out->count++] = (json_flat_value){strdup(f->path), strndup(text, size), kind};
}

static bool flat_value(parser *p, int depth)
{
	flat_parser *f = (flat_parser *)p;
	skip_space(p);
	const char *begin = p->at, *string;
	char c = begin < p->end ? *begin : 0;
	if (c == '{' || c == '[') {
		flat_add(f, c, c == '{' ? "{}" : "[]", 2);
		f->index[depth + 1] = 0;
		return c == '{' ? parse_object(p, flat_member, depth) : parse_array(p, flat_element, depth);
	}
	if (c == '"') {
		if (!parse_string(p, &string))
			return false;
		flat_add(f, c, string, strlen(string));
		return true;
	}
	if (!parse_value(p, depth))
		return false;
	flat_add(f, c == '-' || (c >= '0' && c <= '9') ? '0' : 'w', begin, (size_t)(p->at - begin));
	return true;
}

bool json_flat_text(const char *text, size_t size, json_flat *flat)
{
	trace_check_report report = {0};
	flat_parser f = {.parser = {.at = text, .end = text + size, .line = 1, .report = &report}, .out = flat};
	*flat = (json_flat){0};
	bool good = flat_value(&f.parser, 0);
	if (good && (skip_space(&f.parser), f.parser.at != f.parser.end))
		good = fail(&f.parser, "more text after the document");
	memcpy(flat->error, report.error, sizeof flat->error);
	for (size_t i = 0; i < f.parser.strings.capacity; i++)
		free(f.parser.strings.slot[i]);
	free(f.parser.strings.slot);
	free(f.parser.scratch);
	return good;
}

bool json_flat_file(const char *path, json_flat *flat)
{
	*flat = (json_flat){0};
	FILE *file = fopen(path, "rb");
	if (!file) {
		snprintf(flat->error, sizeof flat->error, "cannot open '%.200s'", path);
		return false;
	}
	char *text = NULL;
	size_t size = 0, capacity = 0, got;
	do {
		if (capacity - size < 65536)
			text = realloc(text, capacity += 1 << 20);
		if (!text)
			abort();
		got = fread(text + size, 1, 65536, file);
		size += got;
	} while (got > 0);
	fclose(file);
	bool good = json_flat_text(text, size, flat);
	free(text);
	return good;
}

void json_flat_finish(json_flat *flat)
{
	for (size_t i = 0; i < flat->count; i++) {
		free(flat->values[i].path);
		free(flat->values[i].text);
	}
	free(flat->values);
	*flat = (json_flat){0};
}

const json_flat_value *json_flat_find(const json_flat *flat, const char *path)
{
	for (size_t i = 0; i < flat->count; i++)
		if (strcmp(flat->values[i].path, path) == 0)
			return &flat->values[i];
	return NULL;
}
