/* Plans as text; gpu_script.h has the words. */
#include "gpu_script.h"

#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCRIPTS 16 /* whose texts stay */
static char texts[SCRIPTS][8192];
static uint32_t text_count;

static stilb_gpu_format format_named(const char *name)
{
	for (uint32_t i = 0; i < STILB_GPU_FORMAT_COUNT; i++)
		if (strcmp(stilb_gpu_format_describe((stilb_gpu_format)i)->name, name) == 0)
			return (stilb_gpu_format)i;
	fail_msg("no format is called '%s'", name);
	return STILB_GPU_NONE;
}

static uint32_t number_after(char **rest)
{
	char *word = strtok_r(NULL, " ", rest);
	assert_non_null(word);
	return (uint32_t)strtoul(word, NULL, 10);
}

static void add_image(stilb_gpu_plan *plan, char **rest)
{
	stilb_gpu_plan_image_row row = {.name = strtok_r(NULL, " ", rest)};
	row.format = format_named(strtok_r(NULL, " ", rest));
	for (char *word; (word = strtok_r(NULL, " ", rest));) {
		if (sscanf(word, "%ux%u", &row.width, &row.height) == 2)
			continue;
		if (strcmp(word, "scale") == 0)
			row.scale = strtof(strtok_r(NULL, " ", rest), NULL);
		else if (strcmp(word, "cube") == 0)
			row.shape = STILB_GPU_SHAPE_CUBE;
		else if (strcmp(word, "1d") == 0)
			row.shape = STILB_GPU_SHAPE_1D;
		else if (strcmp(word, "3d") == 0)
			row.shape = STILB_GPU_SHAPE_3D, row.depth = number_after(rest);
		else if (strcmp(word, "mips") == 0)
			row.mips = (uint16_t)number_after(rest);
		else if (strcmp(word, "layers") == 0)
			row.layers = (uint16_t)number_after(rest);
		else if (strcmp(word, "samples") == 0)
			row.samples = (uint8_t)number_after(rest);
		else if (strcmp(word, "keep") == 0)
			row.keep = true;
		else if (strcmp(word, "output") == 0)
			row.output = true;
		else if (strcmp(word, "owned") == 0)
			row.owned = number_after(rest);
		else
			fail_msg("no image is '%s'", word);
	}
	if (row.width == 0 && row.scale == 0.0f)
		row.scale = 1.0f;
	stilb_gpu_plan_image(plan, &row);
}

static void add_buffer(stilb_gpu_plan *plan, char **rest)
{
	stilb_gpu_plan_buffer_row row = {.name = strtok_r(NULL, " ", rest)};
	row.bytes = number_after(rest);
	for (char *word; (word = strtok_r(NULL, " ", rest));) {
		if (strcmp(word, "keep") == 0)
			row.keep = true;
		else if (strcmp(word, "output") == 0)
			row.output = true;
		else if (strcmp(word, "owned") == 0)
			row.owned = number_after(rest);
		else
			fail_msg("no buffer is '%s'", word);
	}
	stilb_gpu_plan_buffer(plan, &row);
}

/* "1-3/0-1", "a/2" and the like: first and count of mips, of layers. */
static void read_range(const char *text, uint32_t range[4])
{
	const char *layers = strchr(text, '/');
	uint32_t first = 0, last = 0;
	if (text[0] != 'a') {
		int numbers = sscanf(text, "%u-%u", &first, &last);
		range[0] = first;
		range[1] = numbers == 2 ? last - first + 1 : 1;
	}
	if (layers) {
		int numbers = sscanf(layers + 1, "%u-%u", &first, &last);
		range[2] = first;
		range[3] = numbers == 2 ? last - first + 1 : 1;
	}
}

static uint16_t find(const stilb_gpu_plan *plan, const char *name)
{
	uint16_t resource = stilb_gpu_plan_find(plan, name);
	if (resource == 0)
		fail_msg("no resource is called '%s'", name);
	return resource;
}

static const char *const use_words[STILB_GPU_USE_KINDS] = {"sample",   "load", "store", "modify",  "vertices",
                                                           "indirect", "from", "to",    "uniform", "host"};
static const char *const load_words[] = {"over", "clear", "fresh", "test"};

static void add_attachment(stilb_gpu_plan *plan, stilb_gpu_pass *pass, uint32_t load, uint16_t image,
                           const uint32_t *range, const char *resolve)
{
	stilb_gpu_attachment attachment = {.image = image,
	                                   .mip = (uint8_t)range[0],
	                                   .layer = (uint16_t)range[2],
	                                   .layers = (uint16_t)range[3],
	                                   .load = (uint8_t)(load == 3 ? STILB_GPU_LOAD_KEEP : load),
	                                   .read_only = load == 3,
	                                   .resolve = resolve ? find(plan, resolve) : 0};
	stilb_gpu_format format = stilb_gpu_plan_extent(plan, image)->format;
	if (stilb_gpu_format_describe(format)->kind == STILB_GPU_FORMAT_DEPTH)
		pass->depth = attachment;
	else
		pass->color[pass->color_count++] = attachment;
}

static void add_item(stilb_gpu_plan *plan, stilb_gpu_pass *pass, char *item)
{
	char *name = strchr(item, ':');
	assert_non_null(name);
	*name++ = '\0';
	if (strcmp(item, "groups") == 0) {
		pass->groups[0] = pass->groups[1] = pass->groups[2] = (uint32_t)strtoul(name, NULL, 10);
		return;
	}
	if (strcmp(item, "queue") == 0) {
		pass->queue = strcmp(name, "compute") == 0 ? STILB_GPU_QUEUE_COMPUTE : STILB_GPU_QUEUE_COPY;
		return;
	}
	uint32_t range[4] = {0, 0, 0, 0};
	char *resolve = strchr(name, '>');
	if (resolve)
		*resolve++ = '\0';
	char *bracket = strchr(name, '[');
	if (bracket) {
		*bracket = '\0';
		read_range(bracket + 1, range);
	}
	size_t length = strlen(name);
	bool previous = length > 0 && name[length - 1] == '\'';
	if (previous)
		name[length - 1] = '\0';
	uint16_t resource = find(plan, name);
	for (uint32_t i = 0; i < 4; i++)
		if (strcmp(item, load_words[i]) == 0) {
			add_attachment(plan, pass, i, resource, range, resolve);
			return;
		}
	for (uint32_t how = 0; how < STILB_GPU_USE_KINDS; how++) {
		if (strcmp(item, use_words[how]) != 0)
			continue;
		bool storage =
			how == STILB_GPU_USE_STORAGE_READ || how == STILB_GPU_USE_STORAGE_WRITE || how == STILB_GPU_USE_STORAGE;
		bool buffer = stilb_gpu_plan_extent(plan, resource)->format == STILB_GPU_NONE;
		uint16_t slot = 0;
		if (how == STILB_GPU_USE_SAMPLED || (storage && !buffer))
			slot = pass->use_count;
		if (storage && buffer) {
			slot = pass->constant_bytes;
			pass->constant_bytes = (uint8_t)(pass->constant_bytes + 8);
		}
		pass->uses[pass->use_count++] = (stilb_gpu_use){.resource = resource,
		                                                .how = (uint8_t)how,
		                                                .previous = previous,
		                                                .slot = slot,
		                                                .mip = (uint8_t)range[0],
		                                                .mips = (uint8_t)range[1],
		                                                .layer = (uint16_t)range[2],
		                                                .layers = (uint16_t)range[3]};
		return;
	}
	fail_msg("no item is '%s'", item);
}

static void no_function(void *user)
{
	(void)user;
}

static void add_pass(stilb_gpu_plan *plan, stilb_gpu_pass_kind kind, char **rest)
{
	stilb_gpu_pass pass = {.name = strtok_r(NULL, " ", rest), .kind = (uint8_t)kind};
	pass.program = kind == STILB_GPU_PASS_COPY || kind == STILB_GPU_PASS_HOST ? 0 : 1;
	pass.host = kind == STILB_GPU_PASS_HOST ? no_function : NULL;
	if (kind == STILB_GPU_PASS_DISPATCH)
		pass.groups[0] = pass.groups[1] = pass.groups[2] = 1;
	for (char *item; (item = strtok_r(NULL, " ", rest));)
		add_item(plan, &pass, item);
	stilb_gpu_plan_pass(plan, &pass);
}

static void cut(stilb_gpu_plan *plan, const char *name)
{
	uint32_t row = 0;
	while (strcmp(stilb_gpu_plan_row(plan, row)->name, name) != 0)
		row++;
	stilb_gpu_plan_cut(plan, row);
}

void script_rows(stilb_gpu_plan *plan, const char *script)
{
	static const char *const kinds[STILB_GPU_PASS_KINDS] = {"draws", "screen", "dispatch", "copy", "host"};
	char *text = texts[text_count++ % SCRIPTS];
	assert_true(strlen(script) < sizeof texts[0]);
	strcpy(text, script);
	char *lines = NULL;
	for (char *line = strtok_r(text, "\n", &lines); line; line = strtok_r(NULL, "\n", &lines)) {
		char *rest = NULL, *word = strtok_r(line, " ", &rest);
		if (!word)
			continue;
		if (strcmp(word, "image") == 0)
			add_image(plan, &rest);
		else if (strcmp(word, "buffer") == 0)
			add_buffer(plan, &rest);
		else if (strcmp(word, "show") == 0)
			stilb_gpu_plan_show(plan, find(plan, strtok_r(NULL, " ", &rest)));
		else if (strcmp(word, "cut") == 0)
			cut(plan, strtok_r(NULL, " ", &rest));
		for (uint32_t kind = 0; kind < STILB_GPU_PASS_KINDS; kind++)
			if (strcmp(word, kinds[kind]) == 0)
				add_pass(plan, (stilb_gpu_pass_kind)kind, &rest);
	}
}

void script_make(stilb_gpu_plan *plan, const char *script)
{
	stilb_gpu_plan_begin(plan, 64, 64);
	script_rows(plan, script);
	if (stilb_gpu_plan_make(plan, NULL) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* ---- barriers ---------------------------------------------------------------------------------------------------- */

static void print_accesses(FILE *out, uint32_t all)
{
	bool first = true;
	for (uint32_t i = 0; i < STILB_GPU_ACCESSES; i++)
		if (all & 1u << i) {
			fprintf(out, "%s%s", first ? "" : "+", stilb_gpu_access_name((stilb_gpu_access)i));
			first = false;
		}
	if (first)
		fprintf(out, "none");
}

static void print_part(FILE *out, const char *all, uint32_t first, uint32_t count, uint32_t total)
{
	if (first == 0 && count == total)
		fprintf(out, "%s", all);
	else if (count == 1)
		fprintf(out, "%u", first);
	else
		fprintf(out, "%u-%u", first, first + count - 1);
}

static void print_barrier(FILE *out, const stilb_gpu_plan *plan, const char *pass, const stilb_gpu_barrier *barrier)
{
	const stilb_gpu_extent *extent = &stilb_gpu_plan_place(plan, barrier->resource)->extent;
	fprintf(out, "%s: %s", pass, stilb_gpu_plan_name(plan, barrier->resource));
	if (extent->mips > 1 || extent->layers > 1) {
		fprintf(out, "[");
		print_part(out, "a", barrier->mip, barrier->mips, extent->mips);
		if (extent->layers > 1) {
			fprintf(out, "/");
			print_part(out, "a", barrier->layer, barrier->layers, extent->layers);
		}
		fprintf(out, "]");
	}
	fprintf(out, " ");
	print_accesses(out, barrier->from_all);
	fprintf(out, " > ");
	print_accesses(out, barrier->to_all);
	fprintf(out, "%s%s%s%s\n", barrier->discard ? " discard" : "", barrier->zero ? " zero" : "",
	        barrier->previous ? " previous" : "", barrier->memory ? " memory" : "");
}

char *script_barriers(const stilb_gpu_plan *plan)
{
	char *text = NULL;
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	assert_non_null(out);
	const stilb_gpu_step *steps;
	const stilb_gpu_barrier *barriers;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps), sum = stilb_gpu_plan_barriers(plan, &barriers), first;
	for (uint32_t s = 0; s < count; s++)
		for (uint32_t b = 0; b < steps[s].barrier_count; b++)
			print_barrier(out, plan, stilb_gpu_plan_row(plan, steps[s].pass)->name,
			              &barriers[steps[s].first_barrier + b]);
	uint32_t last = stilb_gpu_plan_last_barriers(plan, &first);
	assert_int_equal(first + last, sum);
	for (uint32_t b = first; b < sum; b++)
		print_barrier(out, plan, "end", &barriers[b]);
	fclose(out);
	return text;
}

char *script_waits(const stilb_gpu_plan *plan)
{
	char *text = NULL;
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	assert_non_null(out);
	const stilb_gpu_step *steps;
	const stilb_gpu_queue_wait *waits;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps), sum = stilb_gpu_plan_waits(plan, &waits);
	for (uint32_t i = 0; i < sum; i++)
		fprintf(out, "%s waits for %s\n",
		        waits[i].step == count ? "end" : stilb_gpu_plan_row(plan, steps[waits[i].step].pass)->name,
		        stilb_gpu_plan_row(plan, steps[waits[i].before].pass)->name);
	fclose(out);
	return text;
}
