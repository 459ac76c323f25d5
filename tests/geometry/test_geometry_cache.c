/* Levels on disk: the same as those that are made; what is damaged, of somebody else, or cannot be written costs time
 * alone. */
#include "support/test.h"

#include "geometry/geometry_levels.h"
#include "geometry/geometry_plan.h"
#include "geometry/mesh_made.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/test_geometry_cache.XXXXXX";

static stilb_scene_mesh torus(void)
{
	return mesh_grid(50, 30, mesh_place_torus);
}

/* Writes the path of the only file of the cache; false: there is none. */
static bool only_file(char path[512])
{
	char levels[400];
	snprintf(levels, sizeof levels, "%s/stilb/levels", folder);
	DIR *d = opendir(levels);
	bool found = false;
	for (const struct dirent *entry; d && (entry = readdir(d));)
		if (entry->d_name[0] != '.') {
			assert_false(found);
			found = true;
			snprintf(path, 512, "%s/%.64s", levels, entry->d_name);
		}
	if (d)
		closedir(d);
	return found;
}

static void clear(void)
{
	char path[512];
	if (only_file(path))
		unlink(path);
}

static void assert_same(const stilb_scene_mesh *a, const stilb_scene_mesh *b)
{
	assert_int_equal(a->level_count, b->level_count);
	assert_int_equal(a->level_index_count, b->level_index_count);
	assert_memory_equal(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices);
	assert_memory_equal(a->indices, b->indices, a->index_count * sizeof *a->indices);
	assert_memory_equal(a->levels, b->levels, a->level_count * sizeof *a->levels);
	assert_memory_equal(a->level_indices, b->level_indices, a->level_index_count * sizeof *a->level_indices);
	assert_int_equal(!a->morph, !b->morph);
	if (a->morph)
		assert_memory_equal(a->morph, b->morph, a->vertex_count * sizeof *a->morph);
	assert_int_equal(a->cluster_count, b->cluster_count);
	assert_int_equal(a->group_count, b->group_count);
	assert_int_equal(a->cluster_index_count, b->cluster_index_count);
	if (a->cluster_count == 0)
		return;
	assert_memory_equal(a->clusters, b->clusters, a->cluster_count * sizeof *a->clusters);
	assert_memory_equal(a->groups, b->groups, a->group_count * sizeof *a->groups);
	assert_memory_equal(a->cluster_indices, b->cluster_indices, a->cluster_index_count * sizeof *a->cluster_indices);
}

static int by_number(const void *a, const void *b)
{
	uint64_t l = *(const uint64_t *)a, r = *(const uint64_t *)b;
	return (l > r) - (l < r);
}

/* Each bit of a mesh changes both numbers of its key, and no two bits change one to the same. */
static void test_key(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(5, 3, mesh_place_hills);
	mesh.vertex_count -= 1; /* neither array is a multiple of the blocks that are read */
	mesh.index_count = 81;
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	size_t values = mesh.vertex_count * sizeof *mesh.vertices, size = values + mesh.index_count * sizeof *mesh.indices;
	uint64_t *keys[2] = {malloc((8 * size + 1) * sizeof(uint64_t)), malloc((8 * size + 1) * sizeof(uint64_t))};
	assert_non_null(keys[0]);
	assert_non_null(keys[1]);
	for (size_t bit = 0; bit <= 8 * size; bit++) {
		size_t byte = bit / 8;
		unsigned char *at = byte < values ? (unsigned char *)mesh.vertices + byte
		                    : byte < size ? (unsigned char *)mesh.indices + byte - values
		                                  : NULL; /* the last: as it is */
		uint64_t key[2];
		if (at)
			*at ^= (unsigned char)(1u << bit % 8);
		geometry_cache_key(&stilb_scene_vertex_streams, mesh.vertices, desc.weights, &mesh, &desc, key);
		if (at)
			*at ^= (unsigned char)(1u << bit % 8);
		keys[0][bit] = key[0];
		keys[1][bit] = key[1];
	}
	for (int k = 0; k < 2; k++) {
		qsort(keys[k], 8 * size + 1, sizeof(uint64_t), by_number);
		for (size_t i = 0; i < 8 * size; i++)
			assert_true(keys[k][i] != keys[k][i + 1]);
		free(keys[k]);
	}
	stilb_scene_mesh_finish(&mesh);
}

static void check_same(uint32_t cluster_least)
{
	clear();
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = cluster_least;
	stilb_scene_mesh made = torus(), first = torus(), second = torus(), found = torus(), other = torus();
	char path[512];
	assert_int_equal(stilb_geometry_levels(&made, &desc, NULL, 0), STILB_OK);
	assert_false(only_file(path));
	assert_false(stilb_geometry_levels_find(&found, &desc));
	assert_int_equal(found.level_count, 0);
	assert_int_equal(stilb_geometry_levels_cached(&first, &desc, NULL, 0), STILB_OK);
	assert_true(only_file(path));
	assert_int_equal(stilb_geometry_levels_cached(&second, &desc, NULL, 0), STILB_OK);
	assert_true(stilb_geometry_levels_find(&found, &desc));
	assert_same(&made, &first);
	assert_same(&made, &second);
	assert_same(&made, &found);
	assert_true((made.cluster_count > 0) == (made.index_count / 3 > cluster_least));
	/* Another value, another setting: another file. */
	other.vertices[7].uv[1] += 1e-3f;
	assert_false(stilb_geometry_levels_find(&other, &desc));
	other.vertices[7].uv[1] -= 1e-3f;
	desc.least = 21;
	assert_false(stilb_geometry_levels_find(&other, &desc));
	desc.least = 20;
	desc.cluster_least++;
	assert_false(stilb_geometry_levels_find(&other, &desc));
	stilb_scene_mesh_finish(&made);
	stilb_scene_mesh_finish(&first);
	stilb_scene_mesh_finish(&second);
	stilb_scene_mesh_finish(&found);
	stilb_scene_mesh_finish(&other);
}

static void test_same(void **state)
{
	(void)state;
	check_same(100000);
	check_same(1000);
}

#define HEADER 72u /* bytes; the last eight of them are the checksum of the rest */

/* FNV-1a, to give a changed file the checksum that it should have. */
static void set_checksum(unsigned char *bytes, size_t size)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes + HEADER, size - HEADER);
	memcpy(bytes + HEADER - 8, &hash, sizeof hash);
}

static void write_file(const char *path, const unsigned char *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	fclose(file);
}

/* Clusters and groups that say what cannot be; the bytes of the file from the first cluster on. */
static void damage_cluster(uint32_t kind, unsigned char *at, uint32_t cluster_count, uint32_t group_count)
{
	stilb_scene_cluster last;
	stilb_scene_cluster_group group;
	unsigned char *cluster = at + (cluster_count - 1) * sizeof last;
	unsigned char *groups = at + cluster_count * sizeof last, *root = groups + (group_count - 1) * sizeof group;
	memcpy(&last, cluster, sizeof last);
	memcpy(&group, root, sizeof group);
	assert_int_not_equal(last.from, STILB_SCENE_NONE);
	if (kind == 0)
		last.from = group_count;
	if (kind == 1)
		last.from = group_count - 1; /* its own group */
	if (kind == 2)
		last.first_index -= 3;
	if (kind == 3)
		last.center[1] = NAN;
	if (kind == 4)
		group.error = 0.0f;
	if (kind == 5)
		group.cluster_count++;
	memcpy(cluster, &last, sizeof last);
	memcpy(root, &group, sizeof group);
}

/* Every byte of the header and many of the rest, changed with the right checksum and without; shorter and longer
 * files. Nothing crashes, and what is taken keeps within the mesh. */
static void check_damaged(uint32_t cluster_least)
{
	clear();
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = cluster_least;
	stilb_scene_mesh mesh = torus();
	assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
	char path[512];
	assert_true(only_file(path));
	static unsigned char good[1 << 20], bad[1 << 20];
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(good, 1, sizeof good, file);
	fclose(file);
	assert_in_range(size, 1000, sizeof good - 100);
	uint32_t refused = 0, taken = 0;
	for (uint32_t i = 0; i < (TEST_ASAN ? 200u : 700u); i++) {
		memcpy(bad, good, size);
		size_t at = i < HEADER ? i : HEADER + stilb_random_u64(1, i) % (i % 3 ? 400 : size - HEADER), length = size;
		bad[at] ^= (unsigned char)(1u << stilb_random_u64(2, i) % 8);
		if (i % 2 && i >= HEADER)
			set_checksum(bad, size);
		if (i % 17 == 5)
			length = at;
		if (i % 17 == 6)
			length = size + 4;
		write_file(path, bad, length);
		mesh = torus();
		if (!stilb_geometry_levels_find(&mesh, &desc)) {
			refused++;
			assert_int_equal(mesh.level_count, 0);
		} else {
			taken++;
			assert_true(i % 2 == 1 && i >= HEADER); /* with a right checksum alone */
			for (uint32_t k = 0; k < mesh.index_count; k++)
				assert_true(mesh.indices[k] < mesh.vertex_count);
			for (uint32_t l = 0; l < mesh.level_count; l++)
				for (uint32_t k = 0; k < mesh.levels[l].index_count; k++)
					assert_true(mesh.level_indices[mesh.levels[l].first_index + k] < mesh.levels[l].vertex_count);
			for (uint32_t k = 0; k < mesh.cluster_index_count; k++)
				assert_true(mesh.cluster_indices[k] < mesh.vertex_count);
			for (uint32_t c = 0; c < mesh.cluster_count; c++)
				assert_true(mesh.clusters[c].from == STILB_SCENE_NONE || mesh.clusters[c].from < mesh.group_count);
		}
		stilb_scene_mesh_finish(&mesh);
	}
	assert_true(refused > 100 && taken > 0);
	/* Counts that are not the mesh's but have the right sum, and a vertex that stands twice. */
	for (uint32_t kind = 0; kind < 2; kind++) {
		memcpy(bad, good, size);
		uint32_t counts[3];
		memcpy(counts, bad + 32, sizeof counts);
		if (kind == 0) {
			counts[0]--;
			counts[1] += 2;
			memcpy(bad + 32, counts, sizeof counts);
		} else {
			unsigned char *order = bad + HEADER + counts[2] * sizeof(stilb_scene_level);
			memcpy(order, order + 4, 4);
		}
		set_checksum(bad, size);
		write_file(path, bad, size);
		mesh = torus();
		assert_false(stilb_geometry_levels_find(&mesh, &desc));
		stilb_scene_mesh_finish(&mesh);
	}
	uint32_t counts[7];
	memcpy(counts, good + 32, sizeof counts);
	for (uint32_t kind = 0; kind < 6 && counts[4] > 0; kind++) {
		memcpy(bad, good, size);
		damage_cluster(kind,
		               bad + HEADER + counts[2] * sizeof(stilb_scene_level) +
		                   4 * ((size_t)counts[0] + counts[1] + counts[3]),
		               counts[4], counts[5]);
		set_checksum(bad, size);
		write_file(path, bad, size);
		mesh = torus();
		assert_false(stilb_geometry_levels_find(&mesh, &desc));
		stilb_scene_mesh_finish(&mesh);
	}
	/* A damaged file is replaced. */
	write_file(path, good, size / 2);
	mesh = torus();
	assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
	stilb_scene_mesh again = torus();
	assert_true(stilb_geometry_levels_find(&again, &desc));
	assert_same(&mesh, &again);
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_mesh_finish(&again);
}

static void test_damaged(void **state)
{
	(void)state;
	check_damaged(100000);
	check_damaged(1000);
}

/* A place that cannot be written, that is no folder, that is not told; a full disk. */
static void test_no_place(void **state)
{
	(void)state;
	static const char *const places[] = {"/proc/nowhere", "/dev/null", "relative", "", "/dev/full"};
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	char home[600];
	snprintf(home, sizeof home, "%s/none", folder);
	setenv("HOME", "", 1);
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		setenv("XDG_CACHE_HOME", places[i], 1);
		stilb_scene_mesh mesh = torus();
		assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
		assert_true(mesh.level_count > 3);
		stilb_scene_mesh_finish(&mesh);
	}
	unsetenv("XDG_CACHE_HOME");
	assert_int_equal(mkdir(home, 0700), 0);
	setenv("HOME", home, 1);
	stilb_scene_mesh mesh = torus(), again = torus();
	assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
	assert_true(stilb_geometry_levels_find(&again, &desc)); /* in $HOME/.cache */
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_mesh_finish(&again);
	setenv("XDG_CACHE_HOME", folder, 1);
}

/* A mesh of which no level can be made is known to be one. */
static void test_none(void **state)
{
	(void)state;
	clear();
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	stilb_scene_mesh mesh = torus(), again = torus();
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		mesh.vertices[v].position[0] = again.vertices[v].position[0] = NAN;
	assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
	assert_int_equal(mesh.level_count, 0);
	assert_true(stilb_geometry_levels_find(&again, &desc));
	assert_int_equal(again.level_count, 0);
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_mesh_finish(&again);
}

/* Old files go when there are too many bytes, those used last stay; what is no file of the cache stays, too. */
static void test_bounded(void **state)
{
	(void)state;
	static const char *const names[] = {"00000000000000000000000000000001.levels",
	                                    "00000000000000000000000000000002.levels",
	                                    "00000000000000000000000000000003.levels", "somebody else's"};
	const bool stays[] = {false, true, false, true};
	clear();
	char path[512];
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		snprintf(path, sizeof path, "%s/stilb/levels/%s", folder, names[i]);
		write_file(path, (const unsigned char *)"", 0);
		assert_int_equal(truncate(path, (off_t)STILB_GEOMETRY_CACHE_BYTES / 5 * 2), 0); /* without any blocks */
		struct timespec times[2] = {{0}, {.tv_sec = i == 1 ? 2000 : 1000}};
		assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
	}
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	stilb_scene_mesh mesh = torus(), again = torus();
	assert_int_equal(stilb_geometry_levels_cached(&mesh, &desc, NULL, 0), STILB_OK);
	uint32_t left = 0;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		snprintf(path, sizeof path, "%s/stilb/levels/%s", folder, names[i]);
		bool is_there = access(path, F_OK) == 0;
		left += is_there;
		assert_true(is_there || !stays[i]);
		unlink(path);
	}
	assert_int_equal(left, 3); /* one of the oldest was enough */
	assert_true(stilb_geometry_levels_find(&again, &desc));
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_mesh_finish(&again);
}

static int start(void **state)
{
	(void)state;
	return mkdtemp(folder) ? setenv("XDG_CACHE_HOME", folder, 1) : -1;
}

static int finish(void **state)
{
	(void)state;
	char command[128];
	snprintf(command, sizeof command, "rm -rf %s", folder);
	return system(command) == 0 ? 0 : -1;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_same), cmocka_unit_test(test_damaged), cmocka_unit_test(test_no_place),
		cmocka_unit_test(test_none), cmocka_unit_test(test_bounded), cmocka_unit_test(test_key),
	};
	return cmocka_run_group_tests(tests, start, finish);
}
