/*
 * The files of Debian's package assimp-testmodels: scenes of some forty formats, damaged scenes, and files that are no
 * scenes. Each gives a scene that can be used, or a message with its name and a reason. The results of some files are
 * listed.
 */
#include "scene/open/scene_import.h"
#include "scene/play/scene_play.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <fts.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models"

static uint32_t lights_on_nodes, cameras_on_nodes; /* of all files */

/* Lights and cameras that hang on nodes stand where these have them, bit for bit. */
static void assert_mounts(const stilb_scene *scene)
{
	const stilb_mat4 *places = scene->nodes.to_world;
	for (uint32_t i = 0; i < scene->light_count; i++) {
		const stilb_scene_mount *mount = &scene->light_mounts[i];
		stilb_scene_light light = scene->lights[i];
		light.position[0] += light.kind == STILB_SCENE_LIGHT_DIRECTIONAL ? 0.0f : 1.0f;
		light.direction[1] += light.kind == STILB_SCENE_LIGHT_POINT ? 0.0f : 1.0f;
		assert_true(mount->node <= scene->nodes.count);
		if (mount->node && scene_mount_light(mount, &places[mount->node - 1], &light))
			assert_memory_equal(&light, &scene->lights[i], sizeof light);
		lights_on_nodes += mount->node > 0;
	}
	for (uint32_t c = 0; c < scene->camera_count; c++) {
		const stilb_scene_mount *mount = &scene->camera_mounts[c];
		stilb_scene_camera camera = scene->cameras[c].camera;
		camera.yaw = camera.pitch = camera.roll = camera.position[2] = 7.0f;
		assert_true(mount->node <= scene->nodes.count);
		if (mount->node && scene_mount_camera(mount, &places[mount->node - 1], &camera))
			assert_memory_equal(&camera, &scene->cameras[c].camera, sizeof camera);
		cameras_on_nodes += mount->node > 0;
	}
}

/* Every model without a skin hangs on a node and has its place, which is the product of the matrices from the root. */
static void assert_nodes(const stilb_scene *scene)
{
	const stilb_scene_nodes *nodes = &scene->nodes;
	for (uint32_t n = 0; n < nodes->count; n++) {
		stilb_mat4 place = nodes->local[n];
		assert_true(nodes->parent[n] < n || nodes->parent[n] == STILB_SCENE_NONE);
		if (nodes->parent[n] != STILB_SCENE_NONE)
			place = stilb_mat4_multiply(nodes->to_world[nodes->parent[n]], place);
		assert_memory_equal(&nodes->to_world[n], &place, sizeof place);
	}
	for (uint32_t m = 0; m < scene->model_count; m++) {
		bool posed = stilb_scene_mesh_is_posed(scene, scene->part_mesh[scene->first_part[m]]);
		if (posed && scene->model_node[m] == 0)
			continue; /* a skin carries it */
		assert_true(scene->model_node[m] > 0 && scene->model_node[m] <= nodes->count);
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1]; p++)
			assert_memory_equal(&scene->part_transform[p], &nodes->to_world[scene->model_node[m] - 1],
			                    sizeof(stilb_mat4));
	}
	assert_mounts(scene);
}

static void assert_usable(const stilb_scene *scene)
{
	uint64_t triangles = 0;
	for (uint32_t p = 0; p < scene->part_count; p++)
		triangles += scene->meshes[scene->part_mesh[p]].index_count / 3;
	assert_true(triangles > 0);
	for (uint32_t m = 0; m < scene->model_count; m++)
		assert_true(isfinite(scene->bounds.x[m] + scene->bounds.y[m] + scene->bounds.z[m] + scene->bounds.radius[m]));
	for (uint32_t m = 0; m < scene->material_count; m++) {
		const stilb_scene_material *material = &scene->materials[m];
		assert_true(material->diffuse_texture <= scene->texture_count);
		assert_true(material->roughness >= 0.0f && material->roughness <= 1.0f);
		for (int i = 0; i < 3; i++)
			assert_true(material->diffuse[i] >= 0.0f && material->specular[i] >= 0.0f &&
			            material->diffuse[i] + material->specular[i] <= 1.0001f && material->emission[i] >= 0.0f &&
			            isfinite(material->emission[i]));
	}
	for (uint32_t t = 0; t < scene->texture_count; t++)
		assert_true(scene->textures[t].channels >= 1 && scene->textures[t].channels <= 4 && scene->textures[t].pixels);
	for (uint32_t i = 0; i < scene->light_count; i++)
		for (int k = 0; k < 3; k++)
			assert_true(isfinite(scene->lights[i].position[k]) && isfinite(scene->lights[i].direction[k]) &&
			            scene->lights[i].intensity[k] >= 0.0f && isfinite(scene->lights[i].intensity[k]));
	const stilb_scene_camera *camera = &scene->camera;
	assert_true(camera->fov_y > 0.0f && camera->fov_y < 3.2f && camera->near_z > 0.0f && isfinite(camera->far_z));
	for (int i = 0; i < 3; i++)
		assert_true(isfinite(camera->position[i]));
	assert_true(isfinite(camera->yaw + camera->pitch + camera->roll));
	assert_nodes(scene);
}

/* ---- named ones -------------------------------------------------------------------------------------------------- */

static const struct {
	const char *name;
	const char *says; /* of the refusal; NULL: it opens */
} models_named[] = {
	{"glTF2/IndexOutOfRange/IndexOutOfRange.gltf", NULL},
	{"glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf", "no triangles"},
	{"glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "no triangles"},
	{"glTF2/RecursiveNodes/RecursiveNodes.gltf", "recursive"},
	{"glTF2/MissingBin/BoxTextured.gltf", "BoxTextured0.bin"},
	{"glTF2/wrongTypes/badArray.gltf", "not of type"},
	{"glTF2/wrongTypes/badNumber.gltf", "'scale' is not of type number"},
	{"glTF2/wrongTypes/badUint.gltf", "not of type"},
	{"invalid/OutOfMemory.off", "memory"},
	{"invalid/malformed.obj", "index"},
	{"invalid/readme.txt", "no such format"},
	{"OBJ/spider.obj", NULL},
	{"RAW/WithColor.raw", NULL},
	{"Collada/duck.dae", NULL},
};

static void named_files_end_as_they_should(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof models_named / sizeof *models_named; i++) {
		char path[512];
		stilb_scene *scene;
		if (TEST_ASAN && strstr(models_named[i].name, "OutOfMemory"))
			continue; /* there is no limit of memory under sanitizers */
		snprintf(path, sizeof path, MODELS "/%s", models_named[i].name);
		stilb_result result = stilb_scene_open(path, &scene);
		if (!models_named[i].says != (result == STILB_OK))
			fail_msg("%s: %s", path, result == STILB_OK ? "opens" : stilb_error_message());
		if (result != STILB_OK && !strstr(stilb_error_message(), models_named[i].says))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), models_named[i].says);
		if (result == STILB_OK)
			assert_usable(scene);
		stilb_scene_destroy(scene);
	}
}

static void cameras_and_lights_stand_where_they_should(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open(MODELS "/glTF2/cameras/Cameras.gltf", &scene), STILB_OK);
	assert_true(fabsf(scene->camera.position[2] - 3.0f) < 1e-5f && fabsf(scene->camera.fov_y - 0.7f) < 1e-5f);
	stilb_scene_destroy(scene);
	/* Blender's start-up scene: its z, which is up there, is our y. */
	assert_int_equal(stilb_scene_open(MODELS "/BLEND/BlenderDefault_250.blend", &scene), STILB_OK);
	assert_true(fabsf(scene->camera.position[1] - 5.34367f) < 1e-4f);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, 1.0f);
	assert_true(fabsf(matrix.m[4]) < 0.05f && matrix.m[5] < -0.5f); /* +y is up in the picture; clip y is down */
	assert_int_equal(scene->light_count, 1);
	stilb_scene_destroy(scene);
	/* Edges of boxes are sharp, also where a file shares their corners. */
	static const char *const boxes[] = {"OFF/Cube.off", "PLY/cube.ply", "3MF/box.3mf", "BLEND/box.blend"};
	for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
		char path[512];
		snprintf(path, sizeof path, MODELS "/%s", boxes[i]);
		assert_int_equal(stilb_scene_open(path, &scene), STILB_OK);
		const stilb_scene_mesh *mesh = &scene->meshes[0];
		assert_int_equal(mesh->vertex_count, 24);
		for (uint32_t v = 0; v < 24; v++) {
			const float *n = mesh->vertices[v].normal;
			assert_true(fmaxf(fmaxf(fabsf(n[0]), fabsf(n[1])), fabsf(n[2])) > 0.999f);
		}
		stilb_scene_destroy(scene);
	}
	/* Two of its lights are areas, one of 0.5 x 2. */
	assert_int_equal(stilb_scene_open(MODELS "/BLEND/AreaLight_269.blend", &scene), STILB_OK);
	uint32_t areas = 0;
	bool found = false;
	for (uint32_t i = 0; i < scene->light_count; i++) {
		const stilb_scene_light *light = &scene->lights[i];
		const float *x = light->half_x, *y = light->half_y;
		float width = 2.0f * sqrtf(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
		float height = 2.0f * sqrtf(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
		if (light->kind != STILB_SCENE_LIGHT_RECTANGLE)
			continue;
		areas++;
		found |= fabsf(width - 0.5f) < 0.01f && fabsf(height - 2.0f) < 0.01f;
	}
	assert_true(areas == 2 && found);
	stilb_scene_destroy(scene);
	/* A file that names no texture has none: the name that Assimp gives is not the file's. */
	assert_int_equal(stilb_scene_open(MODELS "/MD2/faerie.md2", &scene), STILB_OK);
	assert_true(scene->texture_count == 0 && scene->materials[0].diffuse[1] == scene->materials[0].diffuse[0]);
	stilb_scene_destroy(scene);
	/* A grail stands on its foot: it is as wide as deep. */
	assert_int_equal(stilb_scene_open(MODELS "/SMD/holy_grailref.smd", &scene), STILB_OK);
	float low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f};
	for (uint32_t v = 0; v < scene->meshes[0].vertex_count; v++) {
		const float *p = scene->meshes[0].vertices[v].position, *m = scene->part_transform[0].m;
		for (int i = 0; i < 3; i++) {
			float at = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
			low[i] = fminf(low[i], at), high[i] = fmaxf(high[i], at);
		}
	}
	assert_true(high[1] - low[1] > 1.2f * (high[0] - low[0]) && high[1] - low[1] > 1.2f * (high[2] - low[2]));
	stilb_scene_destroy(scene);
}

/* ---- losses ------------------------------------------------------------------------------------------------------ */

static void collect(void *user, const char *line)
{
	char *said = user;
	size_t size = strlen(said);
	if (size + strlen(line) + 2 < 4096)
		snprintf(said + size, 4096 - size, "%s\n", line);
}

/* A scan's colours are those of displays, and its material shows them. */
static void colours_of_vertices_are_kept(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open(MODELS "/PLY/float-color.ply", &scene), STILB_OK);
	const stilb_scene_mesh *mesh = &scene->meshes[0];
	assert_non_null(mesh->extras);
	assert_int_equal(scene->materials[scene->part_material[0]].surface, 1);
	bool colored = false;
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const float *color = mesh->extras[v].color;
		colored |= color[0] != color[1] || color[1] != color[2];
		assert_true(color[0] >= 0.0f && color[0] <= 1.0f && color[3] == 1.0f);
	}
	assert_true(colored);
	stilb_scene_destroy(scene);
}

static void what_assimp_gives_and_is_not_shown_is_named(void **state)
{
	(void)state;
	static const struct {
		const char *name, *says;
	} rows[] = {
		{"X/anim_test.x",
	     "skins that are damaged are left out: 2 skins ('pCylinder1: bone 'joint3' is no node of the scene', "},
		{"LWS/move_x_oldformat_56.lws",
	     "animations that are damaged are left out: 1 animation ('LWSMasterAnim: the times of "},
		{"LWS/move_x.lws", "lights fade with the square of the distance, not as the file says: 1 light"},
		{"OpenGEX/camera.ogex", "lights without brightness, or too far away, are left out: 2 lights ('Lamp', ...)\n"},
		{"BLEND/BlenderMaterial_269.blend", "mirrors beside a highlight"},
		{"DXF/lineTest.dxf", "points and lines are not drawn: 1 mesh ('1')\n"},
		{"Collada/lights.dae", "it has no meshes: spikes stand for its nodes\n"},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		char path[512], said[4096] = "";
		stilb_scene *scene;
		snprintf(path, sizeof path, MODELS "/%s", rows[i].name);
		stilb_log_set(collect, said);
		stilb_result result = stilb_scene_open(path, &scene);
		stilb_log_set(NULL, NULL);
		if (result != STILB_OK || !strstr(said, rows[i].says))
			fail_msg("%s: '%s' does not say '%s'", path, result == STILB_OK ? said : stilb_error_message(),
			         rows[i].says);
		stilb_scene_destroy(scene);
	}
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* True if a file is left out: unless all are wanted (the program was started with an argument) only about every third
 * is read, chosen by a hash of its path. */
static bool models_skip(const char *path, bool all)
{
	return !all && stilb_hash_fnv1a64(STILB_FNV1A64_START, path, strlen(path)) % 3 != 0;
}

static bool models_all;

static void every_file_ends_in_a_scene_or_a_message(void **state)
{
	(void)state;
	char *roots[] = {MODELS, NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL, NULL);
	int files = 0, scenes = 0;
	assert_non_null(walk);
	for (FTSENT *entry; (entry = fts_read(walk));) {
		stilb_scene *scene;
		if (entry->fts_info != FTS_F || models_skip(entry->fts_path, models_all) ||
		    (TEST_ASAN && strstr(entry->fts_path, "OutOfMemory")))
			continue;
		files++;
		if (stilb_scene_open(entry->fts_path, &scene) == STILB_OK) {
			assert_usable(scene);
			scenes++;
		} else if (!strstr(stilb_error_message(), entry->fts_path) || strstr(stilb_error_message(), "crashed") ||
		           strstr(stilb_error_message(), "exit status") || strstr(stilb_error_message(), "broke off")) {
			fail_msg("%s: %s", entry->fts_path, stilb_error_message());
		}
		stilb_scene_destroy(scene);
	}
	fts_close(walk);
	print_message("%d of %d files are scenes, with %u lights and %u cameras on nodes\n", scenes, files, lights_on_nodes,
	              cameras_on_nodes);
	assert_true(lights_on_nodes > 10 && cameras_on_nodes > 10);
	assert_true(scenes * 3 > files); /* of all files it is 55 % */
}

int main(int argc, char **argv)
{
	(void)argv;
	models_all = argc > 1;
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(named_files_end_as_they_should),
		cmocka_unit_test(cameras_and_lights_stand_where_they_should),
		cmocka_unit_test(colours_of_vertices_are_kept),
		cmocka_unit_test(what_assimp_gives_and_is_not_shown_is_named),
		cmocka_unit_test(every_file_ends_in_a_scene_or_a_message),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
