/* Files of other people, the same in both renderers: every file in the folder glTF2 of Debian's package
 * assimp-testmodels that opens is drawn by frames and by rays (`--integrator direct --shadows off`), under a
 * directional light, and held to the bounds of docs/materials.md; every other one is refused with the line that is
 * listed here. With STILB_TRUTH_PICTURES=FOLDER in the environment frame, rays and their difference, times 20, are
 * written there; with STILB_TRUTH_FILE=TEXT only files with TEXT in their path are read. */
#include "engine.h"
#include "engine_internal.h"
#include "framed.h"
#include "gi/gi_render.h"
#include "image/image_compare.h"
#include "scene/edit/scene_edit.h"
#include "support/test.h"

#include <fts.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models/glTF2/"

#define SIDE 160u
#define FINE 6u /* pixels of frames for one of these, along each side */
#define SAMPLES 144u
#define ENOUGH 400u /* pixels that must be compared, where models are */

/* The bounds of docs/materials.md for a directional light, shares of the largest value: of the root of the mean square,
 * on models alone, and of the worst pixel. The software device decodes sRGB with an error of up to 0.0015. */
#define BOUND_RMS 1e-3
#define BOUND_RMS_TEXTURED 1.3e-3
#define BOUND_WORST 1e-2

static stilb_engine *engine;
static stilb_job_pool *pool;
static char told[8192];

/* ---- what is expected -------------------------------------------------------------------------------------------- */

/* Files that are not shown, and what the line says: damaged ones, and those of points and lines alone. */
static const struct file_refused {
	const char *path, *says;
} file_refused[] = {
	{"BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "it has no triangles"},
	{"IndexOutOfRange/AllIndicesOutOfRange.gltf", "it has no triangles"},
	{"MissingBin/BoxTextured.gltf", "its file 'BoxTextured0.bin': there is no such file"},
	{"RecursiveNodes/RecursiveNodes.gltf", "node 0 has two parents"},
	{"SchemaFailures/sceneWrongType.gltf", "its file 'BoxTextured0.bin': there is no such file"},
	{"TestNoRootNode/NoScene.gltf", "'scene' is 0, but there are 0 of these"},
	{"TestNoRootNode/SceneWithoutNodes.gltf", "it has no triangles"},
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", "it has no triangles"}, /* points */
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_01.gltf", "it has no triangles"}, /* lines */
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_02.gltf", "it has no triangles"}, /* a loop */
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_03.gltf", "it has no triangles"}, /* a strip of them */
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_07.gltf", "it has no triangles"}, /* with indices */
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_08.gltf", "it has no triangles"},
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_09.gltf", "it has no triangles"},
	{"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_10.gltf", "it has no triangles"},
	{"wrongTypes/badArray.gltf", "'primitives' is not of type array"},
	{"wrongTypes/badExtension.gltf", "it is not of type object, in which 'texCoord' is looked for"},
	{"wrongTypes/badNumber.gltf", "'scale' is not of type number"},
	{"wrongTypes/badObject.gltf", "it is not of type object, in which 'baseColorTexture' is looked for"},
	{"wrongTypes/badUint.gltf", "it is not of type whole number >= 0"},
};

/* Files that open and are not shown as they should be, by both renderers alike, and the line that says so. */
static const struct file_exception {
	const char *path, *says;
} file_exceptions[] = {
	/* Its material is a shader of WebGL 1 in GLSL, an extension that glTF has given up. */
	{"BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf", "extensions that are not shown, so it looks other than it"},
};

/* Of what opens, lines that are told; of other files none. */
static const struct file_told {
	const char *path, *says;
} file_told[] = {
	{"IncorrectVertexArrays/Cube.gltf", "points and lines are not drawn: 4 meshes"},
	{"IndexOutOfRange/IndexOutOfRange.gltf", "triangles whose vertices do not exist are left out: 1 mesh"},
	{"cameras/Cameras.gltf", "cameras that are not perspective are left out: 1 camera"},
};

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const char *refusal_of(const char *path)
{
	for (size_t i = 0; i < COUNT(file_refused); i++)
		if (strcmp(file_refused[i].path, path) == 0)
			return file_refused[i].says;
	return NULL;
}

static const char *exception_of(const char *path)
{
	for (size_t i = 0; i < COUNT(file_exceptions); i++)
		if (strcmp(file_exceptions[i].path, path) == 0)
			return file_exceptions[i].says;
	return NULL;
}

static const char *told_of(const char *path)
{
	for (size_t i = 0; i < COUNT(file_told); i++)
		if (strcmp(file_told[i].path, path) == 0)
			return file_told[i].says;
	return exception_of(path);
}

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

static void take_log(void *user, const char *line)
{
	(void)user;
	size_t used = strlen(told);
	snprintf(told + used, sizeof told - used, "%s\n", line);
}

static int set_up(void **state)
{
	(void)state;
	stilb_job_pool_desc pool_desc = {.worker_count = 2, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = desc.height = SIDE * FINE;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.workers = 1;
	desc.shading = (stilb_render_shading){
		.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	stilb_log_set(take_log, NULL);
	if (stilb_job_pool_create(&pool_desc, &pool) != 0)
		return -1;
	return stilb_engine_create(&desc, &engine) == STILB_OK ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	int messages = (int)stilb_engine_validation_messages(engine);
	stilb_engine_destroy(engine);
	stilb_job_pool_destroy(pool);
	stilb_log_set(NULL, NULL);
	return messages > 0 ? -1 : 0;
}

/* Lights it from beside the camera, in place of the file's own light, and looks at all of it. One light: of several,
 * rays choose one for a sample, which is noise. */
static void light(stilb_scene *scene)
{
	static const float along[3] = {-0.35f, -0.4f, -1.0f}, black[3] = {0.0f, 0.0f, 0.0f}; /* right, up, back */
	if (scene->framed)
		scene->camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, 1.0f);
	float c = cosf(scene->camera.yaw), s = sinf(scene->camera.yaw);
	float length = sqrtf(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
	stilb_scene_light from = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
		.direction = {(c * along[0] + s * along[2]) / length, along[1] / length,
	                  (c * along[2] - s * along[0]) / length},
		.intensity = {2.5f, 2.5f, 2.5f},
	};
	if (stilb_scene_set_lights(scene, &from, 1) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_set_sky(scene, black);
}

/* The picture by rays, and a mask of the pixels of models that no silhouette touches. */
static stilb_image traced(const stilb_scene *scene, stilb_image *mask)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_render_shading shading = stilb_engine_shading(engine);
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	stilb_image image;
	if (stilb_gi_scene_create(scene, &desc, &gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.width = settings.height = SIDE;
	settings.samples = SAMPLES;
	settings.model = (shade_brdf_model){(int)shading.brdf, (int)shading.ndf, (int)shading.g, (int)shading.f};
	if (stilb_gi_render_create(gi, &settings, pool, &render) != STILB_OK || stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_film film = stilb_gi_render_film(render);
	assert_int_equal(stilb_image_create(&image, SIDE, SIDE, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memcpy(image.pixels, film.radiance, stilb_image_size(&image));
	stilb_image depth = {SIDE, SIDE, 1, STILB_IMAGE_F32_LINEAR, (void *)(uintptr_t)film.depth, 0};
	stilb_image normal = {SIDE, SIDE, 3, STILB_IMAGE_F32_LINEAR, (void *)(uintptr_t)film.normal, 0};
	assert_int_equal(stilb_image_mask_edges(&depth, 0.0f, 0.05f, 1, mask), STILB_OK);
	assert_int_equal(stilb_image_mask_edges(&normal, 0.1f, 0.0f, 1, mask), STILB_OK); /* edges of boxes */
	assert_int_equal(stilb_image_mask_edges(&image, 0.0f, 0.08f, 1, mask), STILB_OK); /* of texels */
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		if (isinf(film.depth[i]))
			((uint8_t *)mask->pixels)[i] = 0;
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	return image;
}

static void write_pictures(const char *path, const stilb_image *live, const stilb_image *rays, const stilb_image *mask)
{
	const char *folder = getenv("STILB_TRUTH_PICTURES");
	stilb_image three;
	char to_path[512];
	if (!folder || stilb_image_create(&three, 4 * SIDE, SIDE, 3, STILB_IMAGE_F32_LINEAR) != STILB_OK)
		return;
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		for (uint32_t c = 0; c < 3; c++) {
			float *to = (float *)three.pixels + 3 * (i / SIDE * 4 * SIDE + i % SIDE) + c;
			float a = ((float *)live->pixels)[3 * i + c], b = ((float *)rays->pixels)[3 * i + c];
			to[0] = a;
			to[(size_t)3 * SIDE] = b;
			to[(size_t)6 * SIDE] = 20.0f * fabsf(a - b);
			to[(size_t)9 * SIDE] = ((uint8_t *)mask->pixels)[i] ? 20.0f * fabsf(a - b) : 0.2f;
		}
	size_t used = (size_t)snprintf(to_path, sizeof to_path, "%s/", folder);
	snprintf(to_path + used, sizeof to_path - used, "%s.png", path);
	for (char *at = to_path + used; *at; at++)
		*at = *at == '/' ? '_' : *at;
	assert_int_equal(stilb_image_save(&three, to_path), STILB_OK);
	stilb_image_finish(&three);
}

/* A file that opened. False: a bound is passed. */
static bool agrees(const char *path, stilb_scene *scene)
{
	stilb_image mask = {0};
	stilb_image_comparison apart;
	light(scene);
	stilb_image rays = traced(scene, &mask), live = framed_by(engine, scene, FINE);
	assert_int_equal(stilb_image_compare(&live, &rays, &mask, 0.0, &apart), STILB_OK);
	write_pictures(path, &live, &rays, &mask);
	double rms = scene->texture_count > 0 ? BOUND_RMS_TEXTURED : BOUND_RMS;
	bool good = apart.pixels >= ENOUGH && apart.largest > 0.01 && apart.rms_all <= rms * apart.largest &&
	            apart.worst <= BOUND_WORST * apart.largest;
	print_message("%-70s rms %.5f worst %.4f of %.3f at %u, %u; %llu pixels%s\n", path, apart.rms_all / apart.largest,
	              apart.worst / apart.largest, apart.largest, apart.worst_x, apart.worst_y,
	              (unsigned long long)apart.pixels, good ? "" : "  <-- apart");
	stilb_image_finish(&rays);
	stilb_image_finish(&live);
	stilb_image_finish(&mask);
	return good;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Which answer a file gives. False: another one than it should. */
static bool is_as_it_should(const char *path, bool *opened)
{
	char whole[512];
	stilb_scene *scene;
	const char *refusal = refusal_of(path), *line = told_of(path);
	snprintf(whole, sizeof whole, MODELS "%s", path);
	told[0] = '\0';
	stilb_scene_open_options options = {.dark = true};
	*opened = stilb_scene_open_with(whole, &options, &scene) == STILB_OK;
	if (!*opened) {
		bool good = refusal && strstr(stilb_error_message(), refusal) && strstr(stilb_error_message(), path);
		print_message("%-70s %s%s\n", path, stilb_error_message(), good ? "" : "  <-- not as listed");
		return good;
	}
	bool good = !refusal && (line ? !!strstr(told, line) : told[0] == '\0');
	if (!good)
		print_message("%s: %s, told '%s'  <-- not as listed\n", path, refusal ? "opens" : "shown", told);
	good &= agrees(path, scene);
	stilb_scene_destroy(scene);
	return good;
}

static bool is_gltf(const char *name)
{
	const char *ending = strrchr(name, '.');
	return ending && (strcmp(ending, ".gltf") == 0 || strcmp(ending, ".glb") == 0);
}

static int by_name(const FTSENT **a, const FTSENT **b)
{
	return strcmp((*a)->fts_name, (*b)->fts_name);
}

static void every_file_is_shown_alike_or_refused(void **state)
{
	(void)state;
	const char *only = getenv("STILB_TRUTH_FILE");
	char *roots[] = {(char[]){MODELS}, NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL, by_name);
	size_t shown = 0, refused = 0, bad = 0, exceptions = 0;
	assert_non_null(walk);
	for (FTSENT *entry; (entry = fts_read(walk));) {
		bool opened;
		const char *path = entry->fts_path + strlen(MODELS);
		if (entry->fts_info != FTS_F || !is_gltf(entry->fts_name) || (only && !strstr(path, only)))
			continue;
		bad += !is_as_it_should(path, &opened);
		shown += opened;
		refused += !opened;
		exceptions += exception_of(path) ? 1 : 0;
	}
	fts_close(walk);
	print_message("%zu files are shown, %zu refused, %zu are other than they should be, %zu not as listed\n", shown,
	              refused, exceptions, bad);
	assert_int_equal(bad, 0);
	if (only)
		return;
	assert_int_equal(refused, COUNT(file_refused));
	assert_int_equal(exceptions, COUNT(file_exceptions));
	assert_true(shown > 20 && 20 * exceptions <= shown + refused);
}

int main(void)
{
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(every_file_is_shown_alike_or_refused)};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
