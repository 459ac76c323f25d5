/* What highlights mirror of a panorama, on disk: the same bits as those that are made; what is damaged, of another
 * panorama, or cannot be written costs time alone. */
#include "base/base_cache.h"
#include "render/render_panorama.h"
#include "support/test.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEADER 48u   /* bytes; the last 16 are the checksum of the rest */
#define CHECKSUM 32u /* where it begins */
#define CUBE (sizeof(uint16_t[4]) * RENDER_PANORAMA_CUBE)
#define TABLE (sizeof(uint16_t[2]) * RENDER_PANORAMA_DFG * RENDER_PANORAMA_DFG)
#define SIZE (HEADER + CUBE + TABLE)

static char folder[] = "/tmp/test_render_panorama_cache.XXXXXX";

/* ---- made -------------------------------------------------------------------------------------------------------- */

typedef struct made {
	render_panorama panorama;
	void *shown, *next;
	unsigned char cube[CUBE], table[TABLE];
	uint32_t tables; /* how often it was sent */
} made;

static void *made_make(void *user, size_t bytes)
{
	made *m = user;
	free(m->next);
	m->next = calloc(1, bytes);
	return m->next;
}

static stilb_result made_show(void *user, const render_panorama_gloss *gloss)
{
	made *m = user;
	memcpy(m->cube, gloss->cube, CUBE);
	if (gloss->dfg) {
		memcpy(m->table, gloss->dfg, TABLE);
		m->tables++;
	}
	free(m->shown);
	m->shown = m->next;
	m->next = NULL;
	return STILB_OK;
}

/* Shows the panorama; how many slices it took. */
static uint32_t made_show_next(made *m, const stilb_image *map)
{
	render_panorama_memory memory = {made_make, made_show, m};
	uint32_t slices = 0;
	do {
		assert_int_equal(render_panorama_update(&m->panorama, map, memory, true, NULL, 0), STILB_OK);
		slices++;
	} while (m->panorama.next);
	return slices;
}

static void made_finish(made *m)
{
	render_panorama_finish(&m->panorama);
	free(m->shown);
	free(m->next);
	*m = (made){0};
}

static stilb_image map_of(float light)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, 16, 8, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 16 * 8 * 3; i++)
		((float *)map.pixels)[i] = light * (float)(i % 17);
	return map;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void within(const char *name, char path[512])
{
	snprintf(path, 512, "%s/stilb/panoramas%s%.64s", folder, name[0] ? "/" : "", name);
}

/* How many files the cache has; path: of the last one. */
static uint32_t files(char path[512])
{
	char place[512];
	within("", place);
	DIR *d = opendir(place);
	uint32_t count = 0;
	for (const struct dirent *entry; d && (entry = readdir(d));)
		if (entry->d_name[0] != '.') {
			within(entry->d_name, path);
			count++;
		}
	if (d)
		closedir(d);
	return count;
}

static void clear(void)
{
	char path[512];
	while (files(path) > 0)
		assert_int_equal(unlink(path), 0);
}

static void read_file(const char *path, unsigned char bytes[SIZE])
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	assert_int_equal(fread(bytes, 1, SIZE, file), SIZE);
	assert_int_equal(fgetc(file), EOF);
	fclose(file);
}

static void write_file(const char *path, const unsigned char *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	fclose(file);
}

static void set_checksum(unsigned char bytes[SIZE])
{
	stilb_cache_hash hash = stilb_cache_hash_start();
	uint64_t sums[2];
	stilb_cache_hash_add(&hash, bytes + HEADER, CUBE);
	stilb_cache_hash_add(&hash, bytes + HEADER + CUBE, TABLE);
	stilb_cache_hash_end(&hash, sums);
	memcpy(bytes + CHECKSUM, sums, sizeof sums);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void assert_same(const made *a, const made *b)
{
	assert_memory_equal(a->cube, b->cube, CUBE);
	assert_memory_equal(a->table, b->table, TABLE);
}

/* Made, kept and read are the same bits; each content has a file of its own. */
static void what_is_read_is_what_was_made(void **state)
{
	(void)state;
	static made without, cold, warm, other;
	stilb_image map = map_of(0.1f), second = map_of(0.1f);
	char path[512];
	clear();
	setenv("STILB_CACHE", "off", 1);
	made_show_next(&without, &map);
	unsetenv("STILB_CACHE");
	assert_int_equal(files(path), 0);
	uint32_t made_in = made_show_next(&cold, &map), read_in = made_show_next(&warm, &map);
	print_message("%u slices, from disk %u\n", made_in, read_in);
	assert_int_equal(files(path), 1);
	assert_true(read_in * 4 < made_in);
	assert_int_equal(warm.tables, 1);
	assert_same(&without, &cold);
	assert_same(&without, &warm);
	((float *)second.pixels)[100] += 1e-3f;
	made_show_next(&other, &second);
	assert_int_equal(files(path), 2);
	assert_true(memcmp(other.cube, cold.cube, CUBE) != 0);
	assert_memory_equal(other.table, cold.table, TABLE);
	/* It is really read. */
	static unsigned char bytes[SIZE];
	clear();
	made_finish(&cold);
	made_show_next(&cold, &map);
	assert_int_equal(files(path), 1);
	read_file(path, bytes);
	bytes[HEADER] ^= 1;
	bytes[HEADER + CUBE] ^= 1;
	set_checksum(bytes);
	write_file(path, bytes, SIZE);
	made_finish(&warm);
	made_show_next(&warm, &map);
	assert_memory_equal(warm.cube, bytes + HEADER, CUBE);
	assert_memory_equal(warm.table, bytes + HEADER + CUBE, TABLE);
	made_finish(&without);
	made_finish(&cold);
	made_finish(&warm);
	made_finish(&other);
	stilb_image_finish(&map);
	stilb_image_finish(&second);
}

/* A byte of each number of the header and some of the rest, changed; shorter and longer files: made anew, and kept. */
static void what_is_damaged_is_made_anew(void **state)
{
	(void)state;
	static made good, again;
	static unsigned char whole[SIZE + 4], bad[SIZE + 4], kept[SIZE];
	stilb_image map = map_of(0.2f), another = map_of(0.3f);
	char path[512];
	clear();
	made_show_next(&good, &map);
	assert_int_equal(files(path), 1);
	read_file(path, whole);
	for (uint32_t i = 0; i < HEADER + 8; i++) {
		size_t at = i < HEADER ? i : HEADER + stilb_random_u64(1, i) % (CUBE + TABLE), length = SIZE;
		if (i < HEADER && i % (TEST_ASAN ? 16 : 4) != i / 16)
			continue;
		memcpy(bad, whole, sizeof bad);
		if (i == HEADER)
			length = at;
		else if (i == HEADER + 1)
			length = SIZE + 1;
		else
			bad[at] ^= (unsigned char)(1u << stilb_random_u64(2, i) % 8);
		write_file(path, bad, length);
		made_finish(&again);
		made_show_next(&again, &map);
		assert_same(&again, &good);
		read_file(path, kept);
		assert_memory_equal(kept, whole, SIZE);
	}
	/* A damaged file does not touch the table that is shown already. */
	made_show_next(&again, &another);
	memcpy(bad, whole, SIZE);
	bad[HEADER + CUBE + 7] ^= 1;
	write_file(path, bad, SIZE);
	made_show_next(&again, &map);
	assert_same(&again, &good);
	read_file(path, kept);
	assert_memory_equal(kept, whole, SIZE);
	made_finish(&good);
	made_finish(&again);
	stilb_image_finish(&map);
	stilb_image_finish(&another);
}

/* Places that cannot be written, that are no folder, that are not told: no file, and the same light. */
static void without_a_place_there_is_none(void **state)
{
	(void)state;
	static const char *const places[] = {"/proc/nowhere", "/dev/null", "relative", ""};
	static made good, again;
	stilb_image map = map_of(0.4f);
	char path[512];
	clear();
	made_show_next(&good, &map);
	clear();
	setenv("HOME", "", 1);
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		setenv("XDG_CACHE_HOME", places[i], 1);
		made_show_next(&again, &map);
		assert_same(&again, &good);
		made_finish(&again);
	}
	setenv("XDG_CACHE_HOME", folder, 1);
	assert_int_equal(files(path), 0);
	made_finish(&good);
	stilb_image_finish(&map);
}

#define OLD 70u /* files of 1 MiB; 64 MiB are kept */

/* The files that were not used for longest go, others stay. */
static void the_oldest_go(void **state)
{
	(void)state;
	static made m;
	stilb_image map = map_of(0.5f);
	char path[512], name[64];
	clear();
	made_show_next(&m, &map);
	clear(); /* the folder is there */
	for (uint32_t i = 0; i < OLD; i++) {
		snprintf(name, sizeof name, "%032x.panorama", i);
		within(name, path);
		write_file(path, (const unsigned char *)"", 0);
		assert_int_equal(truncate(path, 1 << 20), 0);
		struct timespec times[2] = {{.tv_sec = 1000 + (time_t)i}, {.tv_sec = 1000 + (time_t)i}};
		assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
	}
	within("of somebody else", path);
	write_file(path, (const unsigned char *)"", 0);
	assert_int_equal(truncate(path, 90 << 20), 0);
	made_finish(&m);
	made_show_next(&m, &map);
	assert_int_equal(files(path), 1 + 1 + 62); /* that one, the new one of 1.02 MiB, and the newest before */
	snprintf(name, sizeof name, "%032x.panorama", OLD - 62);
	within(name, path);
	assert_int_equal(access(path, F_OK), 0);
	made_finish(&m);
	clear();
	stilb_image_finish(&map);
}

static int set_up(void **state)
{
	(void)state;
	unsetenv("STILB_CACHE");
	return mkdtemp(folder) && setenv("XDG_CACHE_HOME", folder, 1) == 0 ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	char path[512];
	clear();
	within("", path);
	int failed = rmdir(path);
	snprintf(path, sizeof path, "%s/stilb", folder);
	failed |= rmdir(path);
	return failed | rmdir(folder);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_read_is_what_was_made),
		cmocka_unit_test(what_is_damaged_is_made_anew),
		cmocka_unit_test(without_a_place_there_is_none),
		cmocka_unit_test(the_oldest_go),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
