/* The hierarchy of a scene in the import process, listed from Assimp's: order, transforms, holes, no memory, and which
 * way is up. */
#include "scene/importer/importer.h"
#include "support/test.h"

#include <assimp/commonMetaData.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The allocation that fails, counted from 1; 0: none. */
static uint32_t fails, allocations;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size)
{
	return ++allocations == fails ? NULL : __real_malloc(size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	return ++allocations == fails ? NULL : __real_realloc(memory, size);
}

static struct aiNode moved(float x)
{
	return (struct aiNode){.mTransformation = {.a1 = 1, .b2 = 1, .c3 = 1, .d4 = 1, .a4 = x}};
}

static stilb_result list(importer *import, struct aiNode *root)
{
	static struct aiScene scene;
	scene.mRootNode = root;
	*import = (importer){.from = &scene, .world.to_world = stilb_mat4_identity()};
	allocations = 0;
	return importer_list_nodes(import);
}

/* A root at 1 with a node at 10, which has one at 100, a hole, a node at NaN, and a node at 20. */
static void nodes_follow_their_parents(void **state)
{
	(void)state;
	importer import;
	struct aiNode root = moved(1), first = moved(10), below = moved(100), nowhere = moved(NAN), last = moved(20);
	root.mChildren = (struct aiNode *[]){&first, NULL, &nowhere, &last};
	root.mNumChildren = 4;
	first.mChildren = (struct aiNode *[]){&below};
	first.mNumChildren = 1;
	nowhere.mChildren = (struct aiNode *[]){&below};
	nowhere.mNumChildren = 1;
	assert_int_equal(list(&import, &root), STILB_OK);
	assert_int_equal(import.node_count, 4);
	assert_int_equal(import.bad_nodes, 1);
	static const float x[] = {1, 11, 21, 111};
	for (uint32_t i = 0; i < 4; i++)
		assert_true(importer_point(&import.nodes[i], stilb_vec3_make(0, 0, 0))[0] == x[i]);
	free(import.nodes);
}

static void a_root_is_somewhere(void **state)
{
	(void)state;
	importer import;
	struct aiNode root = moved(INFINITY);
	assert_int_equal(list(&import, &root), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "the transform of its root is NaN or infinite"));
	free(import.nodes);
}

#define MANY 3000 /* more than the list has room for at first */

static void without_memory_there_is_no_hierarchy(void **state)
{
	(void)state;
	importer import;
	struct aiNode root = moved(1), leaf = moved(2), *leaves[MANY];
	for (int i = 0; i < MANY; i++)
		leaves[i] = &leaf;
	root.mChildren = leaves;
	root.mNumChildren = MANY;
	assert_int_equal(list(&import, &root), STILB_OK);
	assert_int_equal(import.node_count, MANY + 1);
	free(import.nodes);
	uint32_t all = allocations;
	assert_in_range(all, 2, 10);
	for (uint32_t i = 1; i <= all; i++) {
		fails = i;
		stilb_result result = list(&import, &root);
		fails = 0;
		assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_string_equal(stilb_error_message(), "no memory for its hierarchy");
		free(import.nodes);
	}
	assert_int_equal(list(&import, NULL), STILB_ERROR_FILE);
	free(import.nodes);
}

/* ---- axes -------------------------------------------------------------------------------------------------------- */

/* A scene of this format, with the settings that an FBX file has; NULL: no settings. */
static const struct aiScene *scene_of(const char *format, const int32_t settings[6])
{
	static const char *const keys[] = {"UpAxis",        "UpAxisSign", "FrontAxis",
	                                   "FrontAxisSign", "CoordAxis",  "CoordAxisSign"};
	static struct aiString names[7], name;
	static struct aiMetadataEntry values[7];
	static int32_t numbers[6];
	static struct aiMetadata data;
	static struct aiScene scene;
	strcpy(name.data, format);
	strcpy(names[0].data, AI_METADATA_SOURCE_FORMAT);
	values[0] = (struct aiMetadataEntry){AI_AISTRING, &name};
	for (int i = 0; i < 6 && settings; i++) {
		numbers[i] = settings[i];
		strcpy(names[i + 1].data, keys[i]);
		values[i + 1] = (struct aiMetadataEntry){AI_INT32, &numbers[i]};
	}
	data = (struct aiMetadata){.mNumProperties = settings ? 7 : 1, .mKeys = names, .mValues = values};
	scene.mMetaData = &data;
	return &scene;
}

/* What (1, 2, 3) of the file is in the world. */
static void assert_axes(const struct aiScene *scene, bool up_is_y, float x, float y, float z)
{
	importer_node world = {.to_world = importer_axes(scene, up_is_y)};
	stilb_vec3 p = importer_point(&world, stilb_vec3_make(1, 2, 3));
	if (p[0] != x || p[1] != y || p[2] != z)
		fail_msg("(1, 2, 3) is (%g, %g, %g)", (double)p[0], (double)p[1], (double)p[2]);
}

static void y_is_up(void **state)
{
	(void)state;
	static const char *const z_up[] = {"Blender 3D Importer (http://www.blender3d.org)", "Valve SMD Importer",
	                                   "TrueSpace Object Importer", "3mf Importer", "Quick3D Importer"};
	static const struct aiScene none;
	for (size_t i = 0; i < sizeof z_up / sizeof *z_up; i++)
		assert_axes(scene_of(z_up[i], NULL), false, 1, 3, -2);
	assert_axes(scene_of("Wavefront Object Importer", NULL), false, 1, 2, 3);
	assert_axes(&none, false, 1, 2, 3);
	/* OpenGEX says it in its text, and means z if it does not. */
	static const struct {
		const char *path, *text;
		bool up_is_y;
	} rows[] = {
		{"a.ogex", "Metric (key = \"up\") {string {\"z\"}}", false},
		{"a.OGEX", "Metric (key = \"up\") {string {\"y\"}}", true},
		{"a.ogex", "Metric (key = \"time\") {float {1.0}}", false},
		{"a.ogex", "Metric (key = \"up\"", false},
		{"a.ogex", "\"up\"\"", false},
		{"a.obj", "Metric (key = \"up\") {string {\"y\"}}", false},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		importer_bytes bytes = {(unsigned char *)rows[i].text, strlen(rows[i].text)};
		assert_int_equal(importer_up_is_y(rows[i].path, &bytes), rows[i].up_is_y);
	}
	assert_axes(scene_of("Open Game Engine Exchange", NULL), true, 1, 2, 3);
	assert_axes(scene_of("Open Game Engine Exchange", NULL), false, 1, 3, -2);
	/* FBX: as Maya, as 3ds Max, and as a program that mirrors; damaged ones stay as they are. */
	assert_axes(scene_of("Autodesk FBX Importer", (const int32_t[]){1, 1, 2, 1, 0, 1}), false, 1, 2, 3);
	assert_axes(scene_of("Autodesk FBX Importer", (const int32_t[]){2, 1, 1, -1, 0, 1}), false, 1, 3, -2);
	assert_axes(scene_of("Autodesk FBX Importer", (const int32_t[]){0, 1, 2, 1, 1, -1}), false, -2, 1, 3);
	assert_axes(scene_of("Autodesk FBX Importer", (const int32_t[]){2, 1, 2, -1, 0, 1}), false, 1, 2, 3);
	assert_axes(scene_of("Autodesk FBX Importer", (const int32_t[]){3, 1, 1, -1, -1, 1}), false, 1, 2, 3);
	assert_axes(scene_of("Autodesk FBX Importer", NULL), false, 1, 2, 3);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nodes_follow_their_parents),
		cmocka_unit_test(a_root_is_somewhere),
		cmocka_unit_test(without_memory_there_is_no_hierarchy),
		cmocka_unit_test(y_is_up),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
