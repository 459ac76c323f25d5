/*
 * farm_part: results of a range of units as a file: a line that identifies the format; the length of the identity, and
 * the identity; stilb_farm_head; the results in the order of their units; and the FNV-1a hash of all that.
 */
#include "farm/farm.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PART_MAGIC "stilb part 1\n"
#define PART_BUFFER (1u << 20) /* bytes of results that are read or written together, about */

stilb_farm_range stilb_farm_share(uint32_t units, uint32_t index, uint32_t of)
{
	STILB_ASSERT(index >= 1 && index <= of);
	uint32_t first = (uint32_t)((uint64_t)units * (index - 1) / of);
	uint32_t end = (uint32_t)((uint64_t)units * index / of);
	return (stilb_farm_range){first, end - first};
}

/* ---- identity ---------------------------------------------------------------------------------------------------- */

static pthread_once_t binary_once = PTHREAD_ONCE_INIT;
static uint64_t binary_hash; /* written by binary_read, read after pthread_once */

static void binary_read(void)
{
	FILE *stream = fopen("/proc/self/exe", "rb");
	if (!stream)
		return;
	static char block[1 << 16];
	uint64_t hash = STILB_FNV1A64_START;
	for (size_t got; (got = fread(block, 1, sizeof block, stream)) > 0;)
		hash = stilb_hash_fnv1a64(hash, block, got);
	binary_hash = ferror(stream) ? 0 : hash;
	fclose(stream);
}

uint64_t stilb_farm_binary(void)
{
	pthread_once(&binary_once, binary_read);
	return binary_hash;
}

static int line_length(const char *text)
{
	return (int)strcspn(text, "\n");
}

const char *stilb_farm_value(const char *identity, const char *name, int *length)
{
	size_t name_length = strlen(name);
	for (const char *line = identity; *line;) {
		int all = line_length(line);
		if (strncmp(line, name, name_length) == 0 && line[name_length] == ' ') {
			*length = all - (int)name_length - 1;
			return line + name_length + 1;
		}
		line += all + (line[all] == '\n');
	}
	*length = 0;
	return NULL;
}

static bool line_is_in(const char *line, const char *identity)
{
	int length = line_length(line);
	for (const char *other = identity; *other;) {
		int all = line_length(other);
		if (all == length && memcmp(line, other, (size_t)length) == 0)
			return true;
		other += all + (other[all] == '\n');
	}
	return false;
}

/* Describes a line of `from` that `other` lacks or has with another value. */
static stilb_farm_difference difference_of(const char *line, const char *other)
{
	char name[64];
	int length = line_length(line), name_length = (int)strcspn(line, " \n");
	snprintf(name, sizeof name, "%.*s", name_length, line);
	stilb_farm_difference difference = {.name = line, .name_length = name_length};
	difference.a_length = length > name_length ? length - name_length - 1 : 0;
	difference.a = line + length - difference.a_length;
	difference.b = stilb_farm_value(other, name, &difference.b_length);
	return difference;
}

bool stilb_farm_differ(const char *a, const char *b, stilb_farm_difference *difference)
{
	if (strcmp(a, b) == 0)
		return false;
	for (const char *line = a; *line; line += line_length(line) + (line[line_length(line)] == '\n'))
		if (!line_is_in(line, b)) {
			*difference = difference_of(line, b);
			return true;
		}
	for (const char *line = b; *line; line += line_length(line) + (line[line_length(line)] == '\n'))
		if (!line_is_in(line, a)) {
			stilb_farm_difference turned = difference_of(line, a);
			*difference = (stilb_farm_difference){.name = turned.name,
			                                      .name_length = turned.name_length,
			                                      .a = turned.b,
			                                      .a_length = turned.b_length,
			                                      .b = turned.a,
			                                      .b_length = turned.a_length};
			return true;
		}
	*difference = (stilb_farm_difference){.name = "order", .name_length = 5, .a = "", .b = ""};
	return true;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void part_put(stilb_file *file, uint64_t *hash, const void *data, size_t size)
{
	*hash = stilb_hash_fnv1a64(*hash, data, size);
	stilb_file_write(file, data, size); /* its failure is reported by stilb_file_commit later */
}

/* How many results are read or written together, of so many. */
static uint32_t part_together(uint32_t unit_size, uint32_t count)
{
	uint32_t fitting = unit_size < PART_BUFFER ? PART_BUFFER / unit_size : 1;
	return count < fitting ? count : fitting;
}

stilb_result stilb_farm_part_save(const stilb_farm_work *work, uint32_t index, uint32_t of,
                                  const uint64_t notes[STILB_FARM_NOTES], const char *path)
{
	STILB_ASSERT(work && path && work->unit_size > 0 && work->unit_size % 8 == 0);
	stilb_farm_head head = {.index = index, .of = of, .unit_count = work->unit_count, .unit_size = work->unit_size};
	head.range = stilb_farm_share(work->unit_count, index, of);
	memcpy(head.notes, notes, sizeof head.notes);
	uint32_t length = (uint32_t)strlen(work->identity), together = part_together(work->unit_size, head.range.count);
	STILB_ASSERT(length < STILB_FARM_MAX_IDENTITY);
	char *results = stilb_memory_alloc(together, work->unit_size);
	if (!results)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK) {
		free(results);
		return result;
	}
	uint64_t hash = STILB_FNV1A64_START;
	part_put(&file, &hash, PART_MAGIC, sizeof PART_MAGIC - 1);
	part_put(&file, &hash, &length, sizeof length);
	part_put(&file, &hash, work->identity, length);
	part_put(&file, &hash, &head, sizeof head);
	for (uint32_t done = 0; done < head.range.count;) {
		uint32_t left = head.range.count - done, count = left < together ? left : together;
		for (uint32_t i = 0; i < count; i++)
			work->get(work->user, head.range.first + done + i, results + (size_t)i * work->unit_size);
		part_put(&file, &hash, results, (size_t)count * work->unit_size);
		done += count;
	}
	stilb_file_write(&file, &hash, sizeof hash);
	free(results);
	return stilb_file_commit(&file);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool part_get(stilb_farm_part *part, void *data, size_t size)
{
	if (size > part->left || fread(data, 1, size, part->stream) != size)
		return false;
	part->left -= size;
	part->hash = stilb_hash_fnv1a64(part->hash, data, size);
	return true;
}

static stilb_result part_refuse(const stilb_farm_part *part, const char *why)
{
	return stilb_fail(STILB_ERROR_FILE, "'%s' %s", part->path, why);
}

#define PART_DAMAGED "is damaged or cut short; make this part again"

static bool head_is_possible(const stilb_farm_head *head)
{
	if (head->of == 0 || head->index == 0 || head->index > head->of || head->unit_count == 0 || head->unit_size == 0 ||
	    head->unit_size % 8 != 0)
		return false;
	stilb_farm_range range = stilb_farm_share(head->unit_count, head->index, head->of);
	return range.first == head->range.first && range.count == head->range.count;
}

static stilb_result part_read_head(stilb_farm_part *part)
{
	struct stat info;
	char magic[sizeof PART_MAGIC - 1];
	uint32_t length;
	part->left = fstat(fileno(part->stream), &info) == 0 && info.st_size > 0 ? (uint64_t)info.st_size : 0;
	if (!part_get(part, magic, sizeof magic) || memcmp(magic, PART_MAGIC, sizeof magic) != 0)
		return part_refuse(part, "is no part of this version; --part I/N makes one");
	if (!part_get(part, &length, sizeof length) || length >= sizeof part->identity ||
	    !part_get(part, part->identity, length) || !part_get(part, &part->head, sizeof part->head) ||
	    !head_is_possible(&part->head))
		return part_refuse(part, PART_DAMAGED);
	part->identity[length] = '\0';
	uint64_t results = (uint64_t)part->head.range.count * part->head.unit_size;
	return part->left == results + sizeof part->hash ? STILB_OK : part_refuse(part, PART_DAMAGED);
}

stilb_result stilb_farm_part_open(const char *path, stilb_farm_part **out)
{
	STILB_ASSERT(path && out);
	*out = NULL;
	stilb_farm_part *part = calloc(1, sizeof *part);
	if (part)
		part->path = strdup(path);
	stilb_result result = part && part->path ? stilb_file_read_open(path, &part->stream)
	                                         : stilb_fail(STILB_ERROR_MEMORY, "no memory to read '%s'", path);
	if (result != STILB_OK) {
		stilb_farm_part_close(part);
		return result;
	}
	part->hash = STILB_FNV1A64_START;
	result = part_read_head(part);
	part->offset = ftello(part->stream);
	fclose(part->stream); /* of thousands of parts not all can be open at once */
	part->stream = NULL;
	if (result == STILB_OK)
		*out = part;
	else
		stilb_farm_part_close(part);
	return result;
}

void stilb_farm_part_close(stilb_farm_part *part)
{
	if (!part)
		return;
	free(part->path);
	free(part);
}

/* The results that follow the head, and the hash. results: memory for `together` of them. */
static bool part_read_results(stilb_farm_part *part, const stilb_farm_work *work, char *results, uint32_t together)
{
	bool whole = fseeko(part->stream, part->offset, SEEK_SET) == 0;
	for (uint32_t done = 0; whole && done < part->head.range.count;) {
		uint32_t left = part->head.range.count - done, count = left < together ? left : together;
		whole = part_get(part, results, (size_t)count * work->unit_size);
		for (uint32_t i = 0; whole && i < count; i++)
			whole =
				work->set(work->user, part->head.range.first + done + i, results + (size_t)i * work->unit_size, true);
		done += count;
	}
	uint64_t hash = part->hash, written = 0;
	return whole && part_get(part, &written, sizeof written) && written == hash;
}

stilb_result stilb_farm_part_merge(stilb_farm_part *part, const stilb_farm_work *work)
{
	STILB_ASSERT(part && work);
	STILB_ASSERT(part->head.unit_count == work->unit_count && part->head.unit_size == work->unit_size);
	uint32_t together = part_together(work->unit_size, part->head.range.count);
	char *results = stilb_memory_alloc(together, work->unit_size);
	if (!results)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", part->path);
	stilb_result result = stilb_file_read_open(part->path, &part->stream);
	if (result == STILB_OK) {
		bool whole = part_read_results(part, work, results, together);
		fclose(part->stream);
		part->stream = NULL;
		result = whole ? STILB_OK : part_refuse(part, PART_DAMAGED);
	}
	free(results);
	return result;
}

/* ---- do they belong together? ------------------------------------------------------------------------------------ */

static stilb_result part_is_foreign(const stilb_farm_part *part, const stilb_farm_part *first)
{
	stilb_farm_difference d;
	if (!stilb_farm_differ(part->identity, first->identity, &d))
		return stilb_fail(STILB_ERROR_ARGUMENT, "'%s' and '%s' are not of the same work", part->path, first->path);
	if (strncmp(d.name, "scene ", 6) == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "'%s' is of another scene than '%s'; merge parts of one picture",
		                  part->path, first->path);
	if (strncmp(d.name, "binary ", 7) == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "'%s' was made by another build of the program than '%s'; their last bits may differ: make "
		                  "all parts with one",
		                  part->path, first->path);
	return stilb_fail(STILB_ERROR_ARGUMENT, "'%s' does not belong to '%s': its %.*s is %.*s, not %.*s", part->path,
	                  first->path, d.name_length, d.name, d.a_length, d.a_length ? d.a : "", d.b_length,
	                  d.b_length ? d.b : "");
}

static bool parts_are_of_one_count(stilb_farm_part *const *parts, uint32_t count)
{
	for (uint32_t i = 1; i < count; i++)
		if (parts[i]->head.of != parts[0]->head.of)
			return false;
	return true;
}

/* Names the shares that no part holds: by their numbers if all parts are of the same N. */
static stilb_result parts_are_missing(stilb_farm_part *const *parts, uint32_t count, stilb_farm_range gap)
{
	uint32_t of = parts[0]->head.of, units = parts[0]->head.unit_count, missing = 0;
	if (!parts_are_of_one_count(parts, count))
		return stilb_fail(STILB_ERROR_ARGUMENT, "no part holds the share of the work from %.4g to %.4g %%; make it",
		                  100.0 * gap.first / units, 100.0 * ((double)gap.first + gap.count) / units);
	char list[160] = "";
	for (uint32_t index = 1; index <= of; index++) {
		bool held = stilb_farm_share(units, index, of).count == 0;
		for (uint32_t i = 0; i < count && !held; i++)
			held = parts[i]->head.index == index;
		size_t length = strlen(list);
		if (!held && ++missing <= 8)
			snprintf(list + length, sizeof list - length, "%s%" PRIu32 "/%" PRIu32, missing > 1 ? ", " : "", index, of);
	}
	return stilb_fail(STILB_ERROR_ARGUMENT, "%" PRIu32 " of %" PRIu32 " parts %s missing: %s%s", missing, of,
	                  missing == 1 ? "is" : "are", list, missing > 8 ? ", ..." : "");
}

static int part_compare(const void *a, const void *b)
{
	const stilb_farm_range *x = &(*(stilb_farm_part *const *)a)->head.range;
	const stilb_farm_range *y = &(*(stilb_farm_part *const *)b)->head.range;
	if (x->first != y->first)
		return x->first < y->first ? -1 : 1;
	return x->count < y->count ? -1 : x->count > y->count;
}

/* parts: sorted by their first unit. */
static stilb_result parts_cover(stilb_farm_part *const *parts, uint32_t count)
{
	uint32_t end = 0;
	const stilb_farm_part *last = NULL; /* that holds units */
	for (uint32_t i = 0; i < count; i++) {
		const stilb_farm_head *head = &parts[i]->head;
		if (head->range.count == 0)
			continue;
		if (head->range.first < end)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "'%s', part %" PRIu32 "/%" PRIu32 ", and '%s', part %" PRIu32 "/%" PRIu32
			                  ", hold the same units; leave out one",
			                  last->path, last->head.index, last->head.of, parts[i]->path, head->index, head->of);
		if (head->range.first > end)
			return parts_are_missing(parts, count, (stilb_farm_range){end, head->range.first - end});
		end = head->range.first + head->range.count;
		last = parts[i];
	}
	uint32_t units = parts[0]->head.unit_count;
	return end == units ? STILB_OK : parts_are_missing(parts, count, (stilb_farm_range){end, units - end});
}

stilb_result stilb_farm_parts_check(stilb_farm_part *const *parts, uint32_t count)
{
	STILB_ASSERT(parts && count >= 1);
	for (uint32_t i = 1; i < count; i++)
		if (strcmp(parts[i]->identity, parts[0]->identity) != 0 ||
		    parts[i]->head.unit_count != parts[0]->head.unit_count ||
		    parts[i]->head.unit_size != parts[0]->head.unit_size)
			return part_is_foreign(parts[i], parts[0]);
	stilb_farm_part **sorted = malloc(count * sizeof *sorted);
	if (!sorted)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %" PRIu32 " parts", count);
	memcpy(sorted, parts, count * sizeof *sorted);
	qsort(sorted, count, sizeof *sorted, part_compare);
	stilb_result result = parts_cover(sorted, count);
	free(sorted);
	return result;
}
