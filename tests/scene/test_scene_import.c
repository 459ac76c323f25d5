/*
 * Scene files: the contents of glTF and OBJ files in the scene, and files that are missing or damaged, or take too long
 * or too much memory. The test writes all files itself.
 */
#include "scene/open/scene_files.h"
#include "scene/open/scene_import.h"
#include "scene/open/scene_stream.h"
#include "scene/scene.h"
#include "support/test.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[] = "/tmp/test_scene_import_XXXXXX";

static const char *in_folder(const char *name)
{
	static char path[4][512];
	static unsigned turn;
	char *out = path[turn++ % 4];
	snprintf(out, sizeof path[0], "%s/%s", folder, name);
	return out;
}

static const char *write_bytes(const char *name, const void *data, size_t size)
{
	const char *path = in_folder(name);
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(data, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
	return path;
}

static const char *write_text(const char *name, const char *text)
{
	return write_bytes(name, text, strlen(text));
}

/* A PNG of one colour. */
static const char *write_picture(const char *name, uint8_t red, uint8_t green, uint8_t blue)
{
	const char *path = in_folder(name);
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 4, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (int i = 0; i < 24; i++)
		((uint8_t *)image.pixels)[i] = i % 3 == 0 ? red : i % 3 == 1 ? green : blue;
	assert_int_equal(stilb_image_save(&image, path), STILB_OK);
	stilb_image_finish(&image);
	return path;
}

static size_t read_file(const char *path, unsigned char *out, size_t room)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(out, 1, room, file);
	fclose(file);
	return size;
}

static void base64(const void *data, size_t size, char *out)
{
	static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
	const unsigned char *in = data;
	for (size_t i = 0; i < size; i += 3) {
		uint32_t three =
			(uint32_t)in[i] << 16 | (i + 1 < size ? (uint32_t)in[i + 1] << 8 : 0) | (i + 2 < size ? in[i + 2] : 0);
		for (int k = 0; k < 4; k++)
			*out++ = i + (size_t)k > size ? '=' : digits[three >> (18 - 6 * k) & 63];
	}
	*out = '\0';
}

static bool near(float a, float b)
{
	return fabsf(a - b) < 1e-4f * fmaxf(1.0f, fabsf(b));
}

static void assert_three(const float *got, float a, float b, float c)
{
	if (!near(got[0], a) || !near(got[1], b) || !near(got[2], c))
		fail_msg("%g %g %g instead of %g %g %g", (double)got[0], (double)got[1], (double)got[2], (double)a, (double)b,
		         (double)c);
}

static stilb_scene *open_scene(const char *path)
{
	stilb_scene *scene;
	if (stilb_scene_open(path, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

/* Opening fails with this result, and with a message that names the file and contains `says`. */
static void assert_refused(const char *path, stilb_result result, const char *says)
{
	stilb_scene *scene = (stilb_scene *)&scene;
	assert_int_equal(stilb_scene_open(path, &scene), result);
	assert_null(scene);
	if (!strstr(stilb_error_message(), path) || !strstr(stilb_error_message(), says))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), says);
}

/* ---- glTF -------------------------------------------------------------------------------------------------------- */

/* A triangle in the plane z = 0, twice as large and moved by its node; a second node mirrors it. Materials: %s is
 * inserted as the rest of the material. */
static const char *gltf(const char *name, const char *material, const char *rest)
{
	static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
	static const float uvs[6] = {0.25f, 0.5f, 1, 0, 0, 0};
	unsigned char buffer[60];
	char data[128], *text;
	memcpy(buffer, positions, 36);
	memcpy(buffer + 36, uvs, 24);
	base64(buffer, sizeof buffer, data);
	assert_true(asprintf(&text,
	                     "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
	                     "\"nodes\":[{\"mesh\":0,\"scale\":[2,2,2],\"translation\":[1,2,3]},"
	                     "{\"mesh\":0,\"scale\":[-1,1,1]},{\"name\":\"third\"},{\"name\":\"fourth\"}],"
	                     "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},"
	                     "\"material\":0}]}],\"materials\":[{\"name\":\"paint\",%s}],"
	                     "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,%s\"}],"
	                     "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36},"
	                     "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24}],"
	                     "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
	                     "\"min\":[0,0,0],\"max\":[1,1,0]},"
	                     "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}]%s}",
	                     material, data, rest) > 0);
	const char *path = write_text(name, text);
	free(text);
	return path;
}

static void gltf_geometry_and_metal(void **state)
{
	(void)state;
	const char *path = gltf("metal.gltf",
	                        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.4,0.2,1],\"metallicFactor\":0.25,"
	                        "\"roughnessFactor\":0.3},\"emissiveFactor\":[1,0.5,0]",
	                        "");
	stilb_scene *scene = open_scene(path);
	assert_int_equal(scene->model_count, 2);
	assert_int_equal(scene->part_count, 2);
	assert_int_equal(scene->mesh_count, 1);
	assert_int_equal(scene->meshes[0].index_count, 3);
	assert_three(&scene->part_transform[0].m[12], 1, 2, 3);
	assert_true(scene->part_transform[0].m[0] == 2.0f && scene->part_transform[1].m[0] == -1.0f);
	assert_three(scene->meshes[0].vertices[0].normal, 0, 0, 1); /* computed, since the file has none */
	/* (0, 0) is the top left in glTF and in Stilb. */
	for (uint32_t v = 0; v < 3; v++)
		if (scene->meshes[0].vertices[v].position[0] == 0.0f && scene->meshes[0].vertices[v].position[1] == 0.0f)
			assert_true(near(scene->meshes[0].vertices[v].uv[0], 0.25f) &&
			            near(scene->meshes[0].vertices[v].uv[1], 0.5f));
	const stilb_scene_material *paint = &scene->materials[scene->part_material[0]];
	assert_three(paint->diffuse, 0.8f * 0.75f * 0.96f, 0.4f * 0.75f * 0.96f, 0.2f * 0.75f * 0.96f);
	assert_three(paint->specular, 0.03f + 0.2f, 0.03f + 0.1f, 0.03f + 0.05f);
	assert_true(near(paint->roughness, 0.3f));
	assert_three(paint->emission, 1, 0.5f, 0);
	/* What it emits falls on nothing, so a sky is added; the camera that is added sees everything. */
	assert_three(scene->surroundings.sky, 1, 1, 1);
	assert_true(scene->unlit);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, 1.0f);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	for (uint32_t m = 0; m < 2; m++)
		for (int p = 0; p < 6; p++) {
			const stilb_plane *plane = &frustum.planes[p];
			assert_true(plane->x * scene->bounds.x[m] + plane->y * scene->bounds.y[m] + plane->z * scene->bounds.z[m] +
			                plane->distance >=
			            -1e-3f);
		}
	stilb_scene_destroy(scene);
}

static void gltf_camera_and_light(void **state)
{
	(void)state;
	/* The camera stands at (0, 0, 5) turned by 30 degrees about its view: quaternion (0, 0, sin 15, cos 15). Turned to
	 * the left about +z means that its right side rises. */
	const char *path = gltf(
		"camera.gltf", "\"doubleSided\":true",
		",\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.6,\"aspectRatio\":1.5,\"znear\":0.1}},"
		"{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0.1,\"zfar\":9}},"
		"{\"type\":\"perspective\",\"name\":\"From\\u0007above\",\"perspective\":{\"yfov\":0.9,\"znear\":0.1}}],"
		"\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
		"{\"type\":\"point\",\"color\":[1,0.5,0.25],\"intensity\":8},"
		"{\"type\":\"spot\",\"intensity\":2,\"spot\":{\"innerConeAngle\":0.2,\"outerConeAngle\":0.5}},"
		"{\"type\":\"directional\",\"intensity\":3}]}}");
	unsigned char text[4096];
	size_t size = read_file(path, text, sizeof text - 1);
	text[size] = '\0';
	/* Nodes 2 and 3 become a camera, and lights with two more cameras. */
	char *made;
	char *third = strstr((char *)text, "{\"name\":\"third\"},{\"name\":\"fourth\"}");
	*third = '\0';
	assert_true(
		asprintf(&made,
	             "%s{\"camera\":0,\"translation\":[0,0,5],\"rotation\":[0,0,0.2588190451,0.9659258263]},"
	             "{\"name\":\"lamps\",\"children\":[4,5,6,7,8],\"scale\":[2,2,2],\"translation\":[10,0,0]},"
	             "{\"name\":\"a\",\"translation\":[1,2,3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
	             "{\"name\":\"b\",\"rotation\":[-0.70710678,0,0,0.70710678],"
	             "\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
	             "{\"name\":\"c\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
	             "{\"camera\":1},{\"camera\":2,\"translation\":[0,7,0]}%s",
	             text, third + strlen("{\"name\":\"third\"},{\"name\":\"fourth\"}")) > 0);
	stilb_scene *scene = open_scene(write_text("camera.gltf", made));
	free(made);
	assert_three(scene->camera.position, 0, 0, 5);
	assert_three((const float[3]){scene->camera.yaw, scene->camera.pitch, scene->camera.roll}, 0, 0, -0.52359878f);
	assert_true(near(scene->camera.fov_y, 0.6f));
	assert_int_equal(scene->camera_count, 2); /* the orthographic one is left out */
	assert_memory_equal(&scene->cameras[0].camera, &scene->camera, sizeof scene->camera);
	assert_string_equal(scene->cameras[0].name, "number 0");
	assert_string_equal(scene->cameras[1].name, "From above");  /* a control character would move a terminal's cursor */
	assert_three(scene->cameras[1].camera.position, 10, 14, 0); /* in its parent */
	assert_true(near(scene->cameras[1].camera.fov_y, 0.9f) && !scene->framed);
	assert_int_equal(scene->names.material_count, scene->material_count);
	assert_string_equal(scene->names.materials[0], "paint");
	assert_int_equal(scene->light_count, 3);
	const stilb_scene_light *light = scene->lights;
	for (uint32_t i = 0; i < 3; i++, light++) {
		assert_int_equal(light->unit, STILB_SCENE_LIGHT_PHOTOMETRIC); /* candela and lux */
		if (light->kind == STILB_SCENE_LIGHT_POINT) {
			assert_three(light->position, 12, 4, 6); /* in its parent */
			assert_three(light->intensity, 8, 4, 2);
		} else if (light->kind == STILB_SCENE_LIGHT_SPOT) {
			assert_three(light->direction, 0, -1, 0);
			assert_three(light->intensity, 2, 2, 2);
			assert_true(near(light->cos_inner, cosf(0.2f)) && near(light->cos_outer, cosf(0.5f)));
		} else {
			assert_three(light->direction, 0, 0, -1);
			assert_three(light->intensity, 3, 3, 3);
		}
	}
	stilb_scene_destroy(scene);
}

static void gltf_texture_in_the_file(void **state)
{
	(void)state;
	unsigned char png[4096];
	char coded[6000], rest[7000];
	size_t size = read_file(write_picture("inside.png", 255, 0, 128), png, sizeof png);
	base64(png, size, coded);
	snprintf(rest, sizeof rest, ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"data:image/png;base64,%s\"}]",
	         coded);
	stilb_scene *scene = open_scene(gltf(
		"inside.gltf", "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicFactor\":1}", rest));
	assert_int_equal(scene->texture_count, 1);
	assert_int_equal(scene->textures[0].width, 4);
	assert_int_equal(scene->textures[0].channels, 3);
	assert_memory_equal(scene->textures[0].pixels, ((const uint8_t[]){255, 0, 128}), 3);
	const stilb_scene_material *paint = &scene->materials[scene->part_material[0]];
	assert_int_equal(paint->diffuse_texture, 0);
	assert_int_equal(paint->surface, 1);
	assert_int_equal(scene->surfaces[0].maps[STILB_SCENE_MAP_COLOR].texture, 1);
	assert_int_equal(scene->textures[0].format, STILB_IMAGE_U8_SRGB);
	assert_three(paint->diffuse, 0, 0, 0);            /* metal */
	assert_three(paint->specular, 1, 0, 0.21586051f); /* in the texture's mean colour */
	stilb_scene_destroy(scene);
}

/* ---- OBJ --------------------------------------------------------------------------------------------------------- */

#define SQUARE                                                                                                         \
	"mtllib square.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl one\n"              \
	"f 1/1 2/2 3/3 4/4\n"

static void obj_material_and_texture(void **state)
{
	(void)state;
	write_text("square.mtl", "newmtl one\nKd 0.5 0.25 1\nKs 0.5 0.5 0.5\nNs 30\nmap_Kd sub\\PAINT.png\n");
	assert_int_equal(mkdir(in_folder("Sub"), 0700), 0);
	write_picture("Sub/paint.png", 10, 20, 30); /* other upper and lower case, and backslashes */
	stilb_scene *scene = open_scene(write_text("square.obj", SQUARE));
	const stilb_scene_mesh *mesh = &scene->meshes[0];
	assert_int_equal(mesh->index_count, 6);           /* the square in triangles */
	for (uint32_t v = 0; v < mesh->vertex_count; v++) /* OBJ's (0, 0) is the bottom left */
		assert_true(near(mesh->vertices[v].uv[1], 1.0f - mesh->vertices[v].position[1]));
	const stilb_scene_material *one = &scene->materials[scene->part_material[0]];
	const stilb_scene_surface *shown = &scene->surfaces[one->surface - 1];
	float left = 1.0f - 0.04f;                                   /* of the highlight */
	assert_three(shown->color, 0.5f / left, 0.25f / left, 1.0f); /* at most 1 with its highlight */
	assert_three(shown->specular, 0.04f, 0.04f, 0.04f / 1.04f);
	assert_true(near(one->roughness, powf(2.0f / 32.0f, 0.25f)) && near(shown->roughness, one->roughness));
	assert_int_equal(shown->maps[STILB_SCENE_MAP_COLOR].texture, 1);
	assert_three(one->diffuse, 0.5f * 0.0030353f, 0.25f * 0.0069954f, 0.96f * 0.0129830f); /* the mean */
	assert_memory_equal(scene->textures[0].pixels, ((const uint8_t[]){10, 20, 30}), 3);
	assert_true(scene->surroundings.sky[0] > 0.0f); /* added, since there is no other light */
	stilb_scene_destroy(scene);
	write_text("square.mtl", "newmtl one\nKd 0 0 0\nKs 1 1 1\nNs 30\nmap_Kd Sub/paint.png\n");
	scene = open_scene(in_folder("square.obj"));
	one = &scene->materials[scene->part_material[0]];
	shown = &scene->surfaces[one->surface - 1];
	assert_three(shown->color, 1, 1, 1); /* black with a texture becomes white with a texture */
	stilb_scene_destroy(scene);
	write_text("square.mtl", "newmtl one\nKd 0 0 0\nKs 0.9 0.8 0.7\nNs 30\n");
	scene = open_scene(in_folder("square.obj"));
	one = &scene->materials[scene->part_material[0]];
	assert_three(one->specular, 0.9f, 0.8f, 0.7f); /* black without a texture is metal */
	stilb_scene_destroy(scene);
}

/* Two faces that meet at the y axis: a file without normals gets smooth ones where it is bent by less than 60
 * degrees. */
static void edges_are_smooth_unless_sharp(void **state)
{
	(void)state;
	static const float bends[2] = {0.5f, 1.4f};
	for (int i = 0; i < 2; i++) {
		char text[256];
		snprintf(text, sizeof text, "v 0 0 0\nv 0 1 0\nv -1 0 0\nv %g 0 %g\nf 1 2 3\nf 1 4 2\n", (double)cosf(bends[i]),
		         (double)-sinf(bends[i]));
		stilb_scene *scene = open_scene(write_text("bend.obj", text));
		const stilb_scene_mesh *mesh = &scene->meshes[0];
		assert_int_equal(mesh->vertex_count, i == 0 ? 4 : 6);
		for (uint32_t v = 0; v < mesh->vertex_count; v++)
			if (i == 0 && mesh->vertices[v].position[0] == 0.0f)
				assert_three(mesh->vertices[v].normal, sinf(0.25f), 0, cosf(0.25f));
		stilb_scene_destroy(scene);
	}
}

static void what_lacks_its_texture_is_magenta(void **state)
{
	(void)state;
	write_text("square.mtl", "newmtl one\nKd 1 1 1\nmap_Kd nowhere.png\n");
	stilb_scene *scene = open_scene(in_folder("square.obj"));
	assert_int_equal(scene->texture_count, 0);
	assert_three(scene->materials[scene->part_material[0]].diffuse, 1, 0, 1);
	stilb_scene_destroy(scene);
	write_text("square.mtl", "newmtl one\nKd 1 1 1\nmap_Kd broken.png\n");
	write_text("broken.png", "\x89PNG is how it begins");
	scene = open_scene(in_folder("square.obj"));
	assert_three(scene->materials[scene->part_material[0]].diffuse, 1, 0, 1);
	stilb_scene_destroy(scene);
}

static void numbers_that_are_none_go_no_further(void **state)
{
	(void)state;
	static const char path_text[] = "v nan 0 0\nv 1 inf 0\nv 0 1e38 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
	stilb_scene *scene = open_scene(write_text("numbers.obj", path_text));
	assert_int_equal(scene->meshes[0].index_count, 3); /* the triangle that lies nowhere is left out */
	for (uint32_t m = 0; m < scene->model_count; m++)
		assert_true(scene->bounds.radius[m] < 1e19f && scene->bounds.x[m] < 1e19f); /* and no NaN */
	for (uint32_t v = 0; v < scene->meshes[0].vertex_count; v++)
		for (int i = 0; i < 3; i++)
			assert_true(fabsf(scene->meshes[0].vertices[v].normal[i]) <= 1.0f);
	assert_true(scene->camera.position[2] > 0.0f && scene->camera.position[2] < 1e21f);
	stilb_scene_destroy(scene);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void files_that_are_no_scenes(void **state)
{
	(void)state;
	assert_refused("/nonexistent/house.obj", STILB_ERROR_ARGUMENT, "no such file");
	assert_refused(folder, STILB_ERROR_ARGUMENT, "folder");
	assert_int_equal(mkfifo(in_folder("pipe.obj"), 0600), 0);
	assert_refused(in_folder("pipe.obj"), STILB_ERROR_ARGUMENT, "not a regular file"); /* and does not wait */
	assert_refused("/dev/zero", STILB_ERROR_ARGUMENT, "not a regular file");
	assert_refused(write_text("empty.obj", ""), STILB_ERROR_FILE, "it is empty");
	assert_refused(write_text("letter.txt", "Dear Sir or Madam"), STILB_ERROR_FILE, "knows no such format; give glTF");
	assert_refused(write_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"), STILB_ERROR_FILE, "no triangles");
	assert_refused(write_text("range.obj", "v 0 0 0\nf 1 2 3\n"), STILB_ERROR_FILE, "index");
	assert_refused(write_text("half.gltf", "{\"asset\":{\"version\":\"2.0\"},\"sce"), STILB_ERROR_FILE, "damaged");
	assert_refused(write_text("loop.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
	                                       "\"nodes\":[{\"children\":[0]}]}"),
	               STILB_ERROR_FILE, "recursive");
}

/* Assimp 5.2 takes the index of a PLY file as it is, and crashes. */
static void a_crash_is_an_error(void **state)
{
	(void)state;
	const char *path = write_text("crash.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
	                                           "property float y\nproperty float z\nelement face 1\n"
	                                           "property list uchar int vertex_indices\nend_header\n"
	                                           "0 0 0\n1 0 0\n0 1 0\n3 0 1 999999999\n");
	assert_refused(path, STILB_ERROR_FILE, TEST_ASAN ? "ended early" : "Assimp crashed on it (Segmentation fault)");
}

/* A file that claims a billion vertices, and limits of almost no time and memory. */
static void memory_and_time_have_an_end(void **state)
{
	(void)state;
	stilb_scene *scene;
	scene_import_limits quick = {.bytes = 8ull << 30, .seconds = 1e-4};
	assert_int_equal(scene_import_within(in_folder("square.obj"), &quick, &scene), STILB_ERROR_FILE);
	assert_null(scene);
	assert_non_null(strstr(stilb_error_message(), "STILB_IMPORT_SECONDS"));
	if (TEST_ASAN)
		return; /* there is no limit of memory under sanitizers */
	assert_refused(write_text("large.off", "OFF\n999999999 6 0\n0 0 0\n"), STILB_ERROR_MEMORY, "memory");
	scene_import_limits small = {.bytes = 1 << 20, .seconds = 60};
	assert_int_not_equal(scene_import_within(in_folder("square.obj"), &small, &scene), STILB_OK);
	assert_null(scene);
	assert_non_null(strstr(stilb_error_message(), "square.obj"));
	print_message("with one MiB: %s\n", stilb_error_message());
}

/* Whatever Assimp does with a damaged file, the result is a scene or a message. */
static void damaged_files_end_in_a_scene_or_a_message(void **state)
{
	(void)state;
	unsigned char whole[8192], damaged[8192];
	size_t size = read_file(gltf("whole.gltf", "\"doubleSided\":true", ""), whole, sizeof whole);
	int scenes = 0, tried = TEST_ASAN ? 10 : 24;
	for (int i = 0; i < tried; i++) {
		stilb_scene *scene;
		memcpy(damaged, whole, size);
		for (uint64_t k = 0; k < 3; k++)
			damaged[stilb_random_u64(7, (uint64_t)i * 8 + k) % size] =
				(unsigned char)stilb_random_u64(8, (uint64_t)i * 8 + k);
		const char *path = write_bytes("damaged.gltf", damaged, i % 4 == 3 ? size * (size_t)i / 32 : size);
		if (stilb_scene_open(path, &scene) == STILB_OK)
			scenes++;
		else
			assert_non_null(strstr(stilb_error_message(), path));
		stilb_scene_destroy(scene);
	}
	assert_true(scenes < tried);
}

static void the_library_has_a_version(void **state)
{
	(void)state;
	int major, minor, patch;
	stilb_scene_import_info info = stilb_scene_import_query();
	assert_int_equal(sscanf(info.assimp, "%d.%d.%d", &major, &minor, &patch), 3);
	assert_true(major >= 5);
	assert_int_equal(sscanf(info.openimageio, "%d.%d.%d", &major, &minor, &patch), 3);
	assert_true(info.privileges && info.limits);      /* every kernel has them */
	assert_int_equal(waitpid(-1, NULL, WNOHANG), -1); /* its process has ended */
	assert_int_equal(errno, ECHILD);
}

static int folder_make(void **state)
{
	(void)state;
	return mkdtemp(folder) ? 0 : -1;
}

static int folder_remove(void **state)
{
	(void)state;
	char command[256];
	snprintf(command, sizeof command, "rm -r '%s'", folder);
	return system(command);
}

/* ---- what a file may name ---------------------------------------------------------------------------------------- */

/* Opens a square whose material names this texture. Returns the number of textures, and what was logged. */
static uint32_t textures_of(const char *name, bool allow_outside, char said[static 1024])
{
	stilb_scene *scene;
	char material[512];
	snprintf(material, sizeof material, "newmtl one\nKd 1 1 1\nmap_Kd %s\n", name);
	write_text("deep/scene/square.mtl", material);
	FILE *log = tmpfile();
	assert_non_null(log);
	int real = dup(STDERR_FILENO);
	dup2(fileno(log), STDERR_FILENO);
	stilb_result result = stilb_scene_open_with(in_folder("deep/scene/square.obj"),
	                                            &(stilb_scene_open_options){.allow_outside = allow_outside}, &scene);
	dup2(real, STDERR_FILENO);
	close(real);
	said[pread(fileno(log), said, 1023, 0)] = '\0';
	fclose(log);
	assert_int_equal(result, STILB_OK); /* a refused texture is no error */
	uint32_t count = scene->texture_count;
	stilb_scene_destroy(scene);
	return count;
}

/* Materials that Assimp reads name what of them is not shown, one line for each kind. */
static void losses_of_other_formats_are_named(void **state)
{
	(void)state;
	char said[1024];
	mkdir(in_folder("deep"), 0700);
	mkdir(in_folder("deep/scene"), 0700);
	write_text("deep/scene/square.obj", SQUARE);
	write_picture("deep/scene/bump.png", 128, 128, 255);
	textures_of("bump.png\nd 0.5\nmap_Bump bump.png\nmap_d other.png\nmap_Ks bump.png", false, said);
	if (!strstr(said, "bump maps of heights are not shown: 1 material ('one')\n") ||
	    !strstr(said, "surfaces cut out by a picture of their own are shown whole: 1 material ('one')\n") ||
	    !strstr(said, "maps of specular reflection are not shown: 1 material ('one')\n"))
		fail_msg("'%s'", said);
}

/* Factors of layers, as OBJ's materials have them. */
static void layers_of_other_formats(void **state)
{
	(void)state;
	stilb_scene *scene;
	mkdir(in_folder("deep"), 0700);
	mkdir(in_folder("deep/scene"), 0700);
	write_text("deep/scene/square.obj", SQUARE);
	write_text("deep/scene/square.mtl", "newmtl one\nPm 0\nPr 0.5\nPc 0.75\nPcr 0.25\nPs 0.5 0.5 0.25\n");
	if (stilb_scene_open(in_folder("deep/scene/square.obj"), &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(scene->surface_count, 1);
	const stilb_scene_surface *s = &scene->surfaces[0];
	const float got[] = {s->clearcoat, s->clearcoat_roughness, s->sheen_color[0], s->sheen_color[1], s->sheen_color[2]};
	const float wanted[] = {0.75f, 0.25f, 0.5f, 0.5f, 0.25f};
	for (int i = 0; i < 5; i++)
		if (got[i] != wanted[i])
			fail_msg("%d: %g, not %g", i, (double)got[i], (double)wanted[i]);
	stilb_scene_destroy(scene);
}

/* Opacity, a mask by the colour's own picture, a map of normals with tangents for it, an emission's picture. */
static void surfaces_of_other_formats(void **state)
{
	(void)state;
	char material[512];
	write_picture("paint.png", 200, 100, 50);
	snprintf(material, sizeof material,
	         "newmtl one\nKd 1 1 1\nKe 1 0.5 0\nmap_Kd paint.png\nmap_d paint.png\nnorm paint.png\nmap_Ke paint.png\n");
	write_text("square.mtl", material);
	stilb_scene *scene = open_scene(write_text("square.obj", SQUARE));
	const stilb_scene_surface *s = &scene->surfaces[scene->materials[scene->part_material[0]].surface - 1];
	assert_int_equal(s->alpha, STILB_SCENE_MASK);
	assert_three(s->emission, 1, 0.5f, 0);
	assert_true(s->maps[STILB_SCENE_MAP_EMISSION].texture == s->maps[STILB_SCENE_MAP_COLOR].texture);
	uint32_t normals = s->maps[STILB_SCENE_MAP_NORMAL].texture;
	assert_true(normals > 0 && normals != s->maps[STILB_SCENE_MAP_COLOR].texture);
	assert_int_equal(scene->textures[normals - 1].format, STILB_IMAGE_U8_LINEAR);
	assert_three(scene->meshes[0].extras[0].tangent, 1, 0, 0);
	assert_true(scene->meshes[0].extras[0].tangent[3] == 1.0f);
	stilb_scene_destroy(scene);
	write_text("square.mtl", "newmtl one\nKd 1 1 1\nd 0.25\n");
	scene = open_scene(in_folder("square.obj"));
	s = &scene->surfaces[scene->materials[scene->part_material[0]].surface - 1];
	assert_true(s->alpha == STILB_SCENE_BLEND && s->color[3] == 0.25f);
	stilb_scene_destroy(scene);
	write_text("square.mtl", "newmtl one\nKd 1 1 1\n");
	scene = open_scene(in_folder("square.obj"));
	assert_int_equal(scene->surface_count, 0);
	stilb_scene_destroy(scene);
}

static void files_stay_in_their_folder(void **state)
{
	(void)state;
	char said[1024], name[600];
	mkdir(in_folder("deep"), 0700);
	mkdir(in_folder("deep/scene"), 0700);
	mkdir(in_folder("deep/scene/sub"), 0700);
	mkdir(in_folder("deep/beside"), 0700);
	write_text("deep/scene/square.obj", SQUARE);
	write_picture("deep/scene/sub/in.png", 1, 2, 3);
	write_picture("deep/beside/near.png", 1, 2, 3);
	write_picture("far.png", 1, 2, 3);
	assert_int_equal(symlink("sub/in.png", in_folder("deep/scene/inward.png")), 0);
	assert_int_equal(symlink("../../far.png", in_folder("deep/scene/outward.png")), 0);
	assert_int_equal(symlink("../..", in_folder("deep/scene/up")), 0);
	static const char *const read[] = {
		"sub/in.png",          "./sub/../sub/in.png",      "SUB\\In.PNG", "inward.png", "../beside/near.png",
		"../scene/sub/in.png", "sub/../../beside/near.png"};
	for (size_t i = 0; i < sizeof read / sizeof *read; i++)
		if (textures_of(read[i], false, said) != 1)
			fail_msg("%s is not read: %s", read[i], said);
	snprintf(name, sizeof name, "%s", in_folder("far.png"));
	const char *const refused[] = {"../../far.png", "sub/../../../far.png", "outward.png", "up/far.png", name,
	                               "/etc/passwd"};
	for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
		assert_int_equal(textures_of(refused[i], false, said), 0);
		if (!strstr(said, "--allow-outside") || !strstr(said, refused[i]))
			fail_msg("%s: %s", refused[i], said);
	}
	for (size_t i = 0; i < 5; i++)
		if (textures_of(refused[i], true, said) != 1)
			fail_msg("%s is not read: %s", refused[i], said);
	/* A path on another disk, whose last name lies in the folder. */
	assert_int_equal(textures_of("/home/somebody/textures/inward.png", false, said), 1);
	assert_int_equal(textures_of("../../../textures/inward.png", false, said), 1);
	assert_int_equal(mkfifo(in_folder("deep/scene/fifo.png"), 0600), 0);
	assert_int_equal(textures_of("fifo.png", false, said), 0);
	assert_non_null(strstr(said, "not a regular file"));
}

/* 0 is a descriptor as any other, in a program that was started without a standard input. */
static void no_descriptor_stays_open(void **state)
{
	(void)state;
	scene_files files;
	char why[256];
	int input = dup(STDIN_FILENO);
	write_text("square.mtl", "");
	close(STDIN_FILENO);
	stilb_result result = scene_files_init(&files, in_folder("square.obj"), false);
	int file = scene_files_open(&files, "square.mtl", why), folder_file = files.folder;
	scene_files_finish(&files);
	bool open_still = fcntl(folder_file, F_GETFD) >= 0;
	dup2(input, STDIN_FILENO);
	close(input);
	close(file);
	assert_int_equal(result, STILB_OK);
	assert_int_equal(folder_file, 0);
	assert_true(file > 0);
	assert_false(open_still);
}

/* Assimp does not read ".5" as a number. */
static void numbers_may_begin_with_a_point(void **state)
{
	(void)state;
	stilb_scene *scene =
		open_scene(write_text("point.obj", "# .5\nv .5 -.25 +.125\nv\t1 .0 0\nv 0 1e-1 .5\nvt .5 .5\nf 1/1 2/1 3/1\n"));
	bool found = false;
	for (uint32_t v = 0; v < scene->meshes[0].vertex_count; v++) {
		const float *p = scene->meshes[0].vertices[v].position;
		found |= p[0] == 0.5f && p[1] == -0.25f && p[2] == 0.125f;
	}
	assert_true(found);
	stilb_scene_destroy(scene);
}

/* ---- many requests ----------------------------------------------------------------------------------------------- */

static void one_process_serves_many(void **state)
{
	(void)state;
	scene_importer *importer;
	stilb_image image;
	stilb_scene *scene;
	char picture[512], square[512], crash[512];
	scene_import_limits limits = scene_import_limits_default();
	snprintf(picture, sizeof picture, "%s", write_picture("one.png", 255, 0, 128));
	write_text("square.mtl", "newmtl one\nKd 1 1 1\nmap_Kd one.png\n");
	snprintf(square, sizeof square, "%s", write_text("square.obj", SQUARE));
	snprintf(crash, sizeof crash, "%s", in_folder("crash.ply"));
	assert_int_equal(scene_importer_start(&limits, &importer), STILB_OK);
	for (int i = 0; i < 3; i++) {
		assert_int_equal(scene_importer_picture(importer, picture, true, &image), STILB_OK);
		assert_int_equal(image.format, STILB_IMAGE_F32_LINEAR);
		assert_three(image.pixels, 1, 0, 0.21586051f);
		stilb_image_finish(&image);
		assert_int_equal(scene_importer_picture(importer, picture, false, &image), STILB_OK);
		assert_int_equal(image.format, STILB_IMAGE_U8_SRGB);
		assert_memory_equal(image.pixels, ((const uint8_t[]){255, 0, 128}), 3);
		stilb_image_finish(&image);
		assert_int_equal(scene_importer_scene(importer, square, &scene), STILB_OK);
		assert_int_equal(scene->texture_count, 1);
		stilb_scene_destroy(scene);
		assert_int_equal(scene_importer_picture(importer, square, true, &image), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "not a picture of a supported format"));
		if (i == 1) /* it is started again for the next */
			assert_int_equal(scene_importer_scene(importer, crash, &scene), STILB_ERROR_FILE);
	}
	scene_importer_stop(importer);
	scene_importer_stop(NULL);
}

/* One process decodes pictures of different sizes, one after the other, and all that it sent stay as they were. */
static void pictures_follow_each_other(void **state)
{
	(void)state;
	static const uint32_t sides[] = {40, 300, 7, 2300, 300, 40}; /* 2300: too large to be lent */
	scene_importer *importer;
	stilb_image sent[sizeof sides / sizeof *sides];
	scene_import_limits limits = scene_import_limits_default();
	assert_int_equal(scene_importer_start(&limits, &importer), STILB_OK);
	for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
		stilb_image image;
		assert_int_equal(stilb_image_create(&image, sides[i], sides[i], 4, STILB_IMAGE_U8_SRGB), STILB_OK);
		memset(image.pixels, (int)(10 + i), stilb_image_size(&image));
		assert_int_equal(stilb_image_save(&image, in_folder("next.png")), STILB_OK);
		stilb_image_finish(&image);
		assert_int_equal(scene_importer_picture(importer, in_folder("next.png"), false, &sent[i]), STILB_OK);
		assert_int_equal(scene_importer_picture(importer, in_folder("nowhere.png"), false, &image), STILB_ERROR_FILE);
	}
	for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
		assert_int_equal(stilb_image_size(&sent[i]), 4 * sides[i] * sides[i]);
		for (size_t k = 0; k < stilb_image_size(&sent[i]); k++)
			if (((uint8_t *)sent[i].pixels)[k] != 10 + i)
				fail_msg("byte %zu of picture %zu", k, i);
		stilb_image_finish(&sent[i]);
	}
	scene_importer_stop(importer);
}

/* A header that claims 30,000 x 30,000 pixels is refused before decoding: the file holds nothing else. */
static void large_surroundings_are_refused_by_their_header(void **state)
{
	(void)state;
	static const unsigned char png[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x75\x30\0\0\x75\x30\x8\x2\0\0\0"
									   "\xe9\x45\x6f\xed\0\0\0\0IDAT\x35\xaf\x06\x1e";
	stilb_scene *scene = open_scene("furnace:0.5");
	const char *path = write_bytes("large.png", png, sizeof png - 1);
	assert_int_equal(stilb_scene_set_environment(scene, path), STILB_ERROR_FILE);
	if (!strstr(stilb_error_message(), "30000 x 30000") || !strstr(stilb_error_message(), "4 GiB"))
		fail_msg("%s", stilb_error_message());
	assert_null(scene->surroundings.panorama.pixels);
	assert_int_equal(stilb_scene_set_environment(scene, in_folder("nowhere.png")), STILB_ERROR_FILE);
	assert_int_equal(stilb_scene_set_environment(scene, write_picture("sky.png", 255, 0, 128)), STILB_OK);
	assert_three(scene->surroundings.panorama.pixels, 1, 0, 0.21586051f);
	stilb_scene_destroy(scene);
}

/* A taken-over import process that answers with one channel although three were asked for. */
static bool takes_grey;

stilb_result __real_scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                              stilb_image *picture);
stilb_result __wrap_scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                              stilb_image *picture);

stilb_result __wrap_scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                              stilb_image *picture)
{
	stilb_result result = __real_scene_stream_take_picture(stream, message, file, picture);
	if (result == STILB_OK && takes_grey) {
		stilb_image_finish(picture);
		result = stilb_image_create(picture, 4, 2, 1, STILB_IMAGE_F32_LINEAR);
	}
	return result;
}

/* The errno of every start of a process; 0: it is started. */
static int spawn_error;
static pid_t spawned; /* the process started last */

#define STRIP 4000 /* vertices */

int __real_posix_spawn(pid_t *id, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const arguments[], char *const environment[]);
int __wrap_posix_spawn(pid_t *id, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const arguments[], char *const environment[]);

int __wrap_posix_spawn(pid_t *id, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const arguments[], char *const environment[])
{
	int error = spawn_error ? spawn_error : __real_posix_spawn(id, path, actions, attributes, arguments, environment);
	spawned = error ? 0 : *id;
	return error;
}

/* The memory that a process has mapped, bytes. */
static uint64_t memory_of(pid_t id)
{
	char path[64];
	unsigned long long pages = 0;
	snprintf(path, sizeof path, "/proc/%d/statm", (int)id);
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	assert_int_equal(fscanf(file, "%llu", &pages), 1);
	fclose(file);
	return (uint64_t)pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

/* The limit of memory is one for each scene, not for all that a process reads: nothing of a scene stays. */
static void scenes_leave_no_memory(void **state)
{
	(void)state;
	scene_importer *importer;
	scene_import_limits limits = scene_import_limits_default();
	uint64_t before = 0;
	char path[512];
	if (TEST_ASAN)
		return; /* what is freed stays mapped */
	snprintf(path, sizeof path, "%s", in_folder("strip.obj"));
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	for (int i = 0; i < STRIP; i++)
		fprintf(file, "v %d %d 0\n", i / 2, i % 2);
	for (int i = 0; i + 2 < STRIP; i++)
		fprintf(file, "f %d %d %d\n", i + 1, i + 2, i + 3);
	assert_int_equal(fclose(file), 0);
	assert_int_equal(scene_importer_start(&limits, &importer), STILB_OK);
	for (int i = 0; i < 12; i++) {
		stilb_scene *scene;
		assert_int_equal(scene_importer_scene(importer, path, &scene), STILB_OK);
		assert_in_range(scene->meshes[0].vertex_count, STRIP, 3 * STRIP);
		stilb_scene_destroy(scene);
		if (i == 3) /* by then the allocator has what it needs */
			before = memory_of(spawned);
	}
	uint64_t grown = memory_of(spawned) - before, scene_bytes = STRIP * sizeof(stilb_scene_vertex);
	if ((int64_t)grown > (int64_t)(4 * scene_bytes))
		fail_msg("%llu bytes more for 8 scenes of %llu", (unsigned long long)grown, (unsigned long long)scene_bytes);
	scene_importer_stop(importer);
}

/* The reason is that the process cannot be started, not how the one before it ended. */
static void a_restart_that_fails_says_why(void **state)
{
	(void)state;
	scene_importer *importer;
	stilb_scene *scene;
	char square[512];
	snprintf(square, sizeof square, "%s", write_text("square.obj", SQUARE));
	scene_import_limits limits = scene_import_limits_default();
	assert_int_equal(scene_importer_start(&limits, &importer), STILB_OK);
	assert_int_equal(scene_importer_scene(importer, in_folder("crash.ply"), &scene), STILB_ERROR_FILE);
	spawn_error = EAGAIN;
	assert_int_equal(scene_importer_scene(importer, square, &scene), STILB_ERROR_FILE);
	spawn_error = 0;
	assert_non_null(strstr(stilb_error_message(), "cannot be started"));
	assert_int_equal(scene_importer_scene(importer, square, &scene), STILB_OK);
	stilb_scene_destroy(scene);
	scene_importer_stop(importer);
}

static bool give_up_at_once(void *user)
{
	int *asked = user;
	*asked += 1;
	return true;
}

static void a_user_gives_up(void **state)
{
	(void)state;
	int asked = 0;
	stilb_scene *scene;
	stilb_scene_open_options options = {.give_up = give_up_at_once, .user = &asked};
	const char *path = write_text("square.obj", SQUARE);
	assert_int_equal(stilb_scene_open_with(path, &options, &scene), STILB_ERROR_FILE);
	assert_null(scene);
	assert_non_null(strstr(stilb_error_message(), "was given up"));
	assert_true(asked > 0);
}

typedef struct told {
	int times;
	float last;
	float give_up_at;
} told;

static void keep_progress(void *user, float done)
{
	told *so_far = user;
	assert_true(done > so_far->last && done <= 1.0f);
	so_far->times++;
	so_far->last = done;
}

static bool is_far_enough(void *user)
{
	const told *so_far = user;
	return so_far->give_up_at > 0.0f && so_far->last >= so_far->give_up_at;
}

/* An OBJ of so many objects, each a fan of some thousand triangles. */
static const char *write_objects(uint32_t objects)
{
	size_t size = (size_t)objects * 200000, at = 0;
	char *text = malloc(size);
	assert_non_null(text);
	for (uint32_t o = 0, first = 1; o < objects; o++, first += 2000) {
		at += (size_t)snprintf(text + at, size - at, "o object%u\n", o);
		for (int v = 0; v < 2000; v++)
			at += (size_t)snprintf(text + at, size - at, "v %d %u %d\n", v, o, v * v % 97);
		for (uint32_t t = 1; t + 1 < 2000; t++)
			at += (size_t)snprintf(text + at, size - at, "f %u %u %u\n", first, first + t, first + t + 1);
		assert_true(at < size);
	}
	const char *path = write_text("objects.obj", text);
	free(text);
	return path;
}

/* Progress grows to 1, and what is given up on the way leaves no scene. */
static void progress_is_told(void **state)
{
	(void)state;
	stilb_scene *scene;
	told so_far = {0};
	stilb_scene_open_options options = {.progress = keep_progress, .give_up = is_far_enough, .user = &so_far};
	const char *path = write_objects(40);
	assert_int_equal(stilb_scene_open_with(path, &options, &scene), STILB_OK);
	assert_true(so_far.last == 1.0f);
	assert_true(so_far.times >= 2); /* the first mesh is told, whatever the time */
	stilb_scene_destroy(scene);
	so_far = (told){.give_up_at = 1e-6f};
	assert_int_equal(stilb_scene_open_with(path, &options, &scene), STILB_ERROR_FILE);
	assert_null(scene);
	assert_true(so_far.last > 0.0f && so_far.last < 1.0f);
	assert_non_null(strstr(stilb_error_message(), "was given up"));
}

static void surroundings_have_three_channels(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("furnace:0.5");
	const char *path = write_picture("sky.png", 255, 0, 128);
	takes_grey = true;
	stilb_result result = stilb_scene_set_environment(scene, path);
	takes_grey = false;
	assert_int_equal(result, STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "not three channels of light"));
	assert_null(scene->surroundings.panorama.pixels);
	stilb_scene_destroy(scene);
}

static void assert_projects(const stilb_scene_camera *camera)
{
	assert_true(camera->fov_y > 0.0f && camera->fov_y < 3.1415927f);
	assert_true(camera->near_z > 0.0f && camera->near_z < camera->far_z && isfinite(camera->far_z));
	assert_true(isfinite(camera->yaw) && isfinite(camera->pitch) && isfinite(camera->roll));
}

/* Scenes that are one point, without a camera and with one in that point. */
static void cameras_of_points_project(void **state)
{
	(void)state;
	static const char camera_in_the_point[] =
		"{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
		"\"nodes\":[{\"mesh\":0},{\"camera\":0}],"
		"\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.6,\"aspectRatio\":1.5,\"znear\":0.1}}],"
		"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
		"\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
		"AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA\"}],"
		"\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36}],"
		"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
		"\"min\":[0,0,0],\"max\":[0,0,0]}]}";
	static const char *const points[] = {"v 0 0 0\n", "v 1e10 1e10 1e10\n", "v 1e-30 0 0\n"};
	for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
		char text[256];
		snprintf(text, sizeof text, "%s%s%sf 1 2 3\n", points[i], points[i], points[i]);
		stilb_scene *scene = open_scene(write_text("point.obj", text));
		assert_projects(&scene->camera);
		assert_true(scene->camera.pitch < -0.1f); /* it looks down on the point, however far out that is */
		stilb_scene_destroy(scene);
	}
	stilb_scene *scene = open_scene(write_text("point.gltf", camera_in_the_point));
	assert_projects(&scene->camera);
	assert_three(scene->camera.position, 0, 0, 0);
	stilb_scene_destroy(scene);
}

/* 16 bits, halves, floats, and the channels of the file. */
static void textures_keep_their_precision(void **state)
{
	(void)state;
	static const unsigned char grey[] = {
		/* a PNG of one pixel, 16 bits of grey and of alpha: 0x1234, 0xabcd */
		0x89, 'P',  'N',  'G',  '\r', '\n', 0x1a, '\n', 0,    0,    0,    13,   'I',  'H',  'D',  'R',  0,    0,
		0,    1,    0,    0,    0,    1,    16,   4,    0,    0,    0,    0xe5, 0x8c, 0xd0, 0x41, 0,    0,    0,
		13,   'I',  'D',  'A',  'T',  0x78, 0x9c, 0x63, 0x10, 0x32, 0x59, 0x7d, 0x16, 0x00, 0x03, 0x0c, 0x01, 0xbf,
		0x6e, 0xb9, 0xc6, 0x5d, 0,    0,    0,    0,    'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};
	stilb_image image;
	write_bytes("grey.png", grey, sizeof grey);
	for (int i = 0; i < 3; i++) {
		static const char *const names[] = {"grey.png", "half.exr", "float.exr"};
		static const stilb_image_format formats[] = {STILB_IMAGE_U16_SRGB, STILB_IMAGE_F16_LINEAR,
		                                             STILB_IMAGE_F32_LINEAR};
		if (i > 0) {
			assert_int_equal(stilb_image_create(&image, 3, 2, 4, formats[i]), STILB_OK);
			memset(image.pixels, 0x3c, stilb_image_size(&image));
			assert_int_equal(stilb_image_save(&image, in_folder(names[i])), STILB_OK);
			stilb_image_finish(&image);
		}
		char material[64];
		snprintf(material, sizeof material, "newmtl one\nKd 1 1 1\nmap_Kd %s\n", names[i]);
		write_text("square.mtl", material);
		stilb_scene *scene = open_scene(write_text("square.obj", SQUARE));
		assert_int_equal(scene->texture_count, 1);
		assert_int_equal(scene->textures[0].format, formats[i]);
		assert_int_equal(scene->textures[0].channels, i ? 4 : 2);
		if (i == 0)
			assert_memory_equal(scene->textures[0].pixels, ((const uint16_t[]){0x1234, 0xabcd}), 4);
		if (i > 0)
			assert_int_equal(((const uint8_t *)scene->textures[0].pixels)[0], 0x3c);
		stilb_scene_destroy(scene);
	}
}

/* DDS stays blocks with their levels, as colour and as data of the same bytes; what is cut off is told. */
static void blocks_stay_blocks(void **state)
{
	(void)state;
	unsigned char file[128 + 56] = {'D', 'D', 'S', ' ', 124, 0, 0, 0, 7, 0x10};
	static const uint32_t sides[3][2] = {{9, 6}, {4, 3}, {2, 1}};
	file[12] = 6, file[16] = 9, file[28] = 3; /* height, width, levels */
	file[76] = 32, file[80] = 4;
	memcpy(file + 84, "DXT1", 4);
	for (int i = 0; i < 64 - 8; i++)
		file[128 + i] = (unsigned char)(i * 5);
	write_text("square.mtl", "newmtl one\nKd 1 1 1\nmap_Kd blocks.dds\nnorm blocks.dds\n");
	write_bytes("blocks.dds", file, sizeof file); /* 3 x 2 blocks are 48 bytes, and there is none of the others */
	stilb_scene *scene = open_scene(write_text("square.obj", SQUARE));
	assert_int_equal(scene->texture_count, 0); /* test_image_dds has the message */
	assert_three(scene->materials[scene->part_material[0]].diffuse, 1, 0, 1);
	stilb_scene_destroy(scene);
	unsigned char whole[128 + 64] = {0};
	memcpy(whole, file, sizeof file);
	memset(whole + 128 + 56, 77, 8);
	write_bytes("blocks.dds", whole, sizeof whole);
	scene = open_scene(write_text("square.obj", SQUARE));
	const stilb_scene_surface *s = &scene->surfaces[scene->materials[scene->part_material[0]].surface - 1];
	assert_int_equal(scene->texture_count, 2);
	for (int data = 0; data < 2; data++) {
		stilb_scene_map_kind kind = data ? STILB_SCENE_MAP_NORMAL : STILB_SCENE_MAP_COLOR;
		const stilb_image *image = &scene->textures[s->maps[kind].texture - 1];
		assert_int_equal(image->format, data ? STILB_IMAGE_BC1_LINEAR : STILB_IMAGE_BC1_SRGB);
		assert_int_equal(stilb_image_level_count(image), 3);
		assert_memory_equal(image->pixels, whole + 128, 64);
		for (uint32_t l = 0; l < 3; l++) {
			stilb_image level = stilb_image_level(image, l);
			assert_true(level.width == sides[l][0] && level.height == sides[l][1]);
		}
	}
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(gltf_geometry_and_metal),
		cmocka_unit_test(gltf_camera_and_light),
		cmocka_unit_test(gltf_texture_in_the_file),
		cmocka_unit_test(obj_material_and_texture),
		cmocka_unit_test(edges_are_smooth_unless_sharp),
		cmocka_unit_test(what_lacks_its_texture_is_magenta),
		cmocka_unit_test(numbers_that_are_none_go_no_further),
		cmocka_unit_test(files_that_are_no_scenes),
		cmocka_unit_test(a_crash_is_an_error),
		cmocka_unit_test(memory_and_time_have_an_end),
		cmocka_unit_test(damaged_files_end_in_a_scene_or_a_message),
		cmocka_unit_test(the_library_has_a_version),
		cmocka_unit_test(losses_of_other_formats_are_named),
		cmocka_unit_test(layers_of_other_formats),
		cmocka_unit_test(surfaces_of_other_formats),
		cmocka_unit_test(files_stay_in_their_folder),
		cmocka_unit_test(no_descriptor_stays_open),
		cmocka_unit_test(numbers_may_begin_with_a_point),
		cmocka_unit_test(one_process_serves_many),
		cmocka_unit_test(pictures_follow_each_other),
		cmocka_unit_test(large_surroundings_are_refused_by_their_header),
		cmocka_unit_test(scenes_leave_no_memory),
		cmocka_unit_test(a_restart_that_fails_says_why),
		cmocka_unit_test(a_user_gives_up),
		cmocka_unit_test(progress_is_told),
		cmocka_unit_test(surroundings_have_three_channels),
		cmocka_unit_test(cameras_of_points_project),
		cmocka_unit_test(textures_keep_their_precision),
		cmocka_unit_test(blocks_stay_blocks),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
