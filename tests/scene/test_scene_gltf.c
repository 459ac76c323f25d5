/*
 * glTF files with known contents: each feature in a file of its own that the test writes, what is not shown and is
 * named, and files that are damaged in one place. Materials are in test_scene_gltf_materials.c, the files of all
 * formats in test_scene_import.c.
 */
#include "glb_made.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/scene_animation.h"

#include <meshoptimizer.h>
#include <stdarg.h>

/* ---- accessors --------------------------------------------------------------------------------------------------- */

static void sparse_accessors(void **state)
{
	(void)state;
	/* Element 1 is replaced; the second mesh's accessor has no view: its other elements are 0. */
	begin();
	put(triangle, sizeof triangle);
	put((const uint8_t[]){1, 2}, 2);
	put((const float[]){5, 6, 7, 8, 9, 10}, 24);
	stilb_scene *scene =
		open_glb("\"nodes\":[{\"mesh\":0},{\"mesh\":1}],\"scenes\":[{\"nodes\":[0,1]}],"
	             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]},"
	             "{\"primitives\":[{\"attributes\":{\"POSITION\":1}}]}],\"accessors\":["
	             "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
	             "\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{\"bufferView\":2}}},"
	             "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
	             "\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{\"bufferView\":2}}}]");
	assert_triangles(&scene->meshes[0], (const float[][2]){{0, 0}, {5, 6}, {0, 1}}, 3);
	assert_triangles(&scene->meshes[1], (const float[][2]){{0, 0}, {5, 6}, {8, 9}}, 3);
	stilb_scene_destroy(scene);
}

/* KHR_mesh_quantization: positions of any integers, normalised or not, with a stride; and indices of each size. */
static void every_component_type(void **state)
{
	(void)state;
	static const struct {
		const char *type;
		int bytes;
		int32_t most;
	} types[] = {{"5120", 1, 127}, {"5121", 1, 255}, {"5122", 2, 32767}, {"5123", 2, 65535}};
	for (int t = 0; t < 4; t++)
		for (int normalized = 0; normalized < 2; normalized++) {
			unsigned char positions[3][8] = {{0}};
			char json[512];
			int32_t most = normalized ? types[t].most : 100;
			memcpy(positions[1], &most, (size_t)types[t].bytes); /* little endian */
			memcpy(positions[2] + types[t].bytes, &most, (size_t)types[t].bytes);
			begin();
			put_with(positions, sizeof positions, ",\"byteStride\":8");
			snprintf(json, sizeof json,
			         NODE "," TRIANGLE ",\"accessors\":[{\"bufferView\":0,\"componentType\":%s,\"count\":3,"
			              "\"type\":\"VEC3\",\"normalized\":%s}]",
			         types[t].type, normalized ? "true" : "false");
			float one = normalized ? 1 : 100;
			stilb_scene *scene = open_glb(json);
			assert_triangles(&scene->meshes[0], (const float[][2]){{0, 0}, {one, 0}, {0, one}}, 3);
			stilb_scene_destroy(scene);
		}
	static const uint8_t bytes[] = {2, 1, 0};
	static const uint16_t halves[] = {2, 1, 0};
	static const uint32_t words[] = {2, 1, 0};
	static const void *const indices[] = {bytes, halves, words};
	for (int t = 0; t < 3; t++) {
		char json[512];
		begin();
		put(triangle, sizeof triangle);
		put(indices[t], 3u << t);
		snprintf(json, sizeof json,
		         NODE ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"accessors\":["
		              "%s,{\"bufferView\":1,\"componentType\":%d,\"count\":3,\"type\":\"SCALAR\"}]",
		         VEC3(0),
		         t == 0   ? 5121
		         : t == 1 ? 5123
		                  : 5125);
		stilb_scene *scene = open_glb(json);
		assert_triangles(&scene->meshes[0], (const float[][2]){{0, 1}, {1, 0}, {0, 0}}, 3);
		stilb_scene_destroy(scene);
	}
}

/* ---- primitives -------------------------------------------------------------------------------------------------- */

static void strips_fans_lines_and_points(void **state)
{
	(void)state;
	/* A zigzag; the fourth index repeats the third, which turns the strip and makes no triangle. */
	static const float zigzag[] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0};
	static const uint8_t turned[] = {0, 1, 2, 2, 3, 4};
	begin();
	put(zigzag, sizeof zigzag);
	put(turned, sizeof turned);
	stilb_scene *scene = open_glb(
		NODE ",\"meshes\":[{\"name\":\"all\",\"primitives\":["
			 "{\"mode\":5,\"attributes\":{\"POSITION\":0}},{\"mode\":6,\"attributes\":{\"POSITION\":0}},"
			 "{\"mode\":5,\"attributes\":{\"POSITION\":0},\"indices\":1},{\"mode\":1,\"attributes\":{\"POSITION\":0}},"
			 "{\"mode\":0,\"attributes\":{\"POSITION\":0}},{\"attributes\":{}}]}],\"accessors\":["
			 "{\"bufferView\":0,\"componentType\":5126,\"count\":5,\"type\":\"VEC3\"},"
			 "{\"bufferView\":1,\"componentType\":5121,\"count\":6,\"type\":\"SCALAR\"}]");
	assert_int_equal(scene->mesh_count, 3);
	assert_triangles(&scene->meshes[0],
	                 (const float[][2]){{0, 0}, {0, 1}, {1, 0}, {0, 1}, {1, 1}, {1, 0}, {1, 0}, {1, 1}, {2, 0}}, 9);
	assert_triangles(&scene->meshes[1],
	                 (const float[][2]){{0, 1}, {1, 0}, {0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {2, 0}, {0, 0}}, 9);
	/* Triangle 3 of the strip 0 1 2 2 3 4 is odd: its corners are 2 4 3. */
	assert_triangles(&scene->meshes[2], (const float[][2]){{0, 0}, {0, 1}, {1, 0}, {1, 0}, {2, 0}, {1, 1}}, 6);
	assert_said("points and lines are not drawn: 2 meshes ('all', ...)");
	assert_said("what has no positions is not drawn: 1 mesh ('all')");
	stilb_scene_destroy(scene);
}

/* Without normals a mesh is flat; with them vertices are shared, and only those that are used are kept. */
static void normals(void **state)
{
	(void)state;
	static const float bent[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 9, 9, 9};
	static const uint8_t two[] = {0, 1, 2, 0, 2, 3};
	static const int8_t packed[5][4] = {{0, 0, 127}, {0, 0, 127}, {0, 127, 0}, {0, 0, 0}, {1, 1, 1}};
	begin();
	put(bent, sizeof bent);
	put(two, sizeof two);
	put_with(packed, sizeof packed, ",\"byteStride\":4");
	stilb_scene *scene =
		open_glb(NODE ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1},"
	                  "{\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"indices\":1}]}],\"accessors\":["
	                  "{\"bufferView\":0,\"componentType\":5126,\"count\":5,\"type\":\"VEC3\"},"
	                  "{\"bufferView\":1,\"componentType\":5121,\"count\":6,\"type\":\"SCALAR\"},"
	                  "{\"bufferView\":2,\"componentType\":5120,\"count\":5,\"type\":\"VEC3\",\"normalized\":true}]");
	assert_int_equal(scene->meshes[0].vertex_count, 6);
	assert_numbers(scene->meshes[0].vertices[0].normal, (const float[]){0, 0, 1}, 3);
	assert_numbers(scene->meshes[0].vertices[3].normal, (const float[]){1, 0, 0}, 3);
	assert_int_equal(scene->meshes[1].vertex_count, 4);
	assert_numbers(scene->meshes[1].vertices[2].normal, (const float[]){0, 1, 0}, 3);
	assert_numbers(scene->meshes[1].vertices[3].normal, (const float[]){1, 0, 0}, 3); /* its own is 0: its triangle's */
	stilb_scene_destroy(scene);
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

static void scenes_and_nodes(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	/* Scene 1 is shown: a parent that moves, a child that turns by 90 degrees about z and scales. */
	stilb_scene *scene = open_glb(TRIANGLE ",\"accessors\":[" VEC3(
		0) "],\"scene\":1,\"scenes\":[{\"name\":\"other\",\"nodes\":[2]},{\"nodes\":[0]}],"
	       "\"nodes\":[{\"name\":\"arm\",\"translation\":[10,20,30],\"children\":[1]},{\"mesh\":0,"
	       "\"rotation\":[0,0,0.70710678,0.70710678],\"scale\":[2,3,4]},{\"mesh\":0}]");
	assert_int_equal(scene->model_count, 1);
	assert_numbers(scene->part_transform[0].m, (const float[]){0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 10, 20, 30, 1}, 16);
	assert_said("scenes besides the one that is shown: 1 scene ('other')");
	assert_int_equal(scene->nodes.count, 2); /* of the scene that is shown */
	assert_true(scene->nodes.parent[0] == STILB_SCENE_NONE && scene->nodes.parent[1] == 0);
	assert_string_equal(scene->nodes.name[0], "arm");
	assert_string_equal(scene->nodes.name[1], "");
	assert_numbers(scene->nodes.pose[0].translation, (const float[]){10, 20, 30}, 3);
	assert_numbers(scene->nodes.pose[1].rotation, (const float[]){0, 0, 0.70710678f, 0.70710678f}, 4);
	assert_numbers(scene->nodes.pose[1].scale, (const float[]){2, 3, 4}, 3);
	assert_int_equal(scene->model_node[0], 2);
	assert_memory_equal(&scene->nodes.to_world[1], scene->part_transform, sizeof *scene->part_transform);
	stilb_scene_pose turned = scene->nodes.pose[0];
	turned.scale[2] = 2.0f;
	assert_int_equal(stilb_scene_set_node_pose(scene, 0, &turned), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	assert_numbers(&scene->part_transform[0].m[8], (const float[]){0, 0, 8}, 3);
	stilb_scene_destroy(scene);
	scene = open_glb(TRIANGLE ",\"accessors\":[" VEC3(
		0) "],\"nodes\":[{\"mesh\":0,\"matrix\":[2,0,0,0,0,2,0,0,0,0,2,0,1,2,3,1],\"children\":[1]},{\"mesh\":0}]");
	assert_int_equal(scene->model_count, 2); /* without scenes, all nodes; 1 is a child */
	assert_numbers(&scene->part_transform[1].m[12], (const float[]){1, 2, 3}, 3);
	stilb_scene_destroy(scene);
	assert_refused(TRIANGLE ",\"accessors\":[" VEC3(0) "],\"scenes\":[{\"nodes\":[0]}],"
	                                                   "\"nodes\":[{\"mesh\":0,\"children\":[0]}]",
	               "recursive");
	assert_refused(TRIANGLE ",\"accessors\":[" VEC3(0) "],\"scenes\":[{\"nodes\":[7]}],\"nodes\":[{\"mesh\":0}]",
	               "it names node 7, but there are 1");
}

static void instances(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){1, 0, 0, 0, 2, 0}, 24);
	put((const int16_t[]){0, 0, 0, 32767, 0, 0, 32767, 0}, 16); /* none, and half a turn about z */
	stilb_scene *scene = open_glb(
		"\"nodes\":[{\"mesh\":0,\"scale\":[2,2,2],\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
		"\"TRANSLATION\":1,\"ROTATION\":2}}}}],\"scenes\":[{\"nodes\":[0]}]," TRIANGLE ",\"accessors\":[" VEC3(
			0) ","
			   "{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"},"
			   "{\"bufferView\":2,\"componentType\":5122,\"count\":2,\"type\":\"VEC4\",\"normalized\":true}]");
	assert_int_equal(scene->mesh_count, 1);
	assert_int_equal(scene->model_count, 2);
	assert_int_equal(scene->nodes.count, 3); /* each instance is a node on the file's */
	assert_true(scene->nodes.parent[1] == 0 && scene->nodes.parent[2] == 0);
	assert_true(scene->model_node[0] == 2 && scene->model_node[1] == 3);
	assert_numbers(scene->nodes.pose[2].rotation, (const float[]){0, 0, 1, 0}, 4);
	assert_numbers(scene->part_transform[0].m, (const float[]){2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 2, 0, 0, 1}, 16);
	assert_numbers(scene->part_transform[1].m, (const float[]){-2, 0, 0, 0, 0, -2, 0, 0, 0, 0, 2, 0, 0, 4, 0, 1}, 16);
	stilb_scene_destroy(scene);
	assert_refused("\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
	               "\"TRANSLATION\":1,\"SCALE\":0}}}}],\"scenes\":[{\"nodes\":[0]}]," TRIANGLE ",\"accessors\":[" VEC3(
					   0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}]",
	               "accessor 0 has 3 elements for 2 instances");
}

/* A mesh's extras count for all nodes that show it, a node's for that node, instances included. Other extras, of any
 * kind, say nothing of it. */
static void extras_say_what_models_are(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){1, 0, 0, 0, 2, 0}, 24);
	stilb_scene *scene = open_glb(
		"\"nodes\":[{\"mesh\":0},{\"mesh\":1},{\"mesh\":1,\"extras\":{\"castShadow\":true,\"seen\":0}},"
		"{\"mesh\":0,\"extras\":{\"receiveShadow\":false,\"my\":[1]},\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
		"\"attributes\":{\"TRANSLATION\":1}}}},{\"mesh\":0,\"extras\":7},{\"mesh\":0,\"extras\":{\"seen\":\"no\"},"
		"\"name\":\"odd\"},{\"mesh\":0,\"extras\":{\"castShadow\":2}}],\"scenes\":[{\"nodes\":[0,1,2,3,4,5,6]}],"
		"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]},"
		"{\"primitives\":[{\"attributes\":{\"POSITION\":0}}],\"extras\":{\"castShadow\":false,\"receiveShadow\":1}}],"
		"\"accessors\":[" VEC3(0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}]");
	assert_int_equal(scene->model_count, 8);
	assert_memory_equal(scene->model_flags, ((const uint8_t[]){0, 2, 1, 4, 4, 0, 0, 0}), 8);
	assert_said(
		"seen, castShadow and receiveShadow of extras count where they are true or false: 2 nodes ('odd', ...)");
	stilb_scene_destroy(scene);
}

/* ---- compression ------------------------------------------------------------------------------------------------- */

/* Three views of buffer 1, vertices, triangles and normals; count: of the vertices. */
static void write_packed(const char *count, size_t vertex_size, size_t triangle_size, size_t normal_size)
{
	/* Buffer 0 has no data: it is only what readers without the extension would need. */
	char text[2048];
	snprintf(
		text, sizeof text,
		"{\"asset\":{\"version\":\"2.0\"}," NODE ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
		"\"NORMAL\":2},\"indices\":1}]}],\"buffers\":[{\"byteLength\":100},{\"byteLength\":%zu,\"uri\":\"packed.bin\"}]"
		","
		"\"bufferViews\":[{\"buffer\":0,\"byteLength\":64,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":1,"
		"\"byteLength\":%zu,\"byteStride\":16,\"count\":%s,\"mode\":\"ATTRIBUTES\"}}},"
		"{\"buffer\":0,\"byteLength\":12,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":1,\"byteOffset\":%zu,"
		"\"byteLength\":%zu,\"byteStride\":2,\"count\":6,\"mode\":\"TRIANGLES\"}}},"
		"{\"buffer\":0,\"byteLength\":16,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":1,\"byteOffset\":%zu,"
		"\"byteLength\":%zu,\"byteStride\":4,\"count\":4,\"mode\":\"ATTRIBUTES\",\"filter\":\"OCTAHEDRAL\"}}}],"
		"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
		"{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"},"
		"{\"bufferView\":2,\"componentType\":5120,\"count\":4,\"type\":\"VEC3\",\"normalized\":true}]}",
		vertex_size + triangle_size + normal_size, vertex_size, count, vertex_size, triangle_size,
		vertex_size + triangle_size, normal_size);
	write_file("packed.gltf", text, strlen(text));
}

static void meshopt(void **state)
{
	(void)state;
	static const float quad[4][4] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
	static const float up[4][4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}};
	static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};
	unsigned char vertices[512], triangles[512], normal_codes[512];
	int8_t filtered[4][4];
	size_t vertex_size = meshopt_encodeVertexBuffer(vertices, sizeof vertices, quad, 4, 16);
	size_t triangle_size = meshopt_encodeIndexBuffer(triangles, sizeof triangles, two, 6);
	meshopt_encodeFilterOct(filtered, 4, 4, 8, up[0]);
	size_t normal_size = meshopt_encodeVertexBuffer(normal_codes, sizeof normal_codes, filtered, 4, 4);
	assert_true(vertex_size > 0 && triangle_size > 0 && normal_size > 0);
	unsigned char all[1536];
	memcpy(all, vertices, vertex_size);
	memcpy(all + vertex_size, triangles, triangle_size);
	memcpy(all + vertex_size + triangle_size, normal_codes, normal_size);
	write_file("packed.bin", all, vertex_size + triangle_size + normal_size);
	write_packed("4", vertex_size, triangle_size, normal_size);
	stilb_scene *scene;
	if (open_file("packed.gltf", false, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const stilb_scene_mesh *mesh = &scene->meshes[0];
	assert_int_equal(mesh->index_count, 6);
	float area = 0;
	for (uint32_t i = 0; i < 6; i += 3) { /* the encoder may turn a triangle */
		const float *a = mesh->vertices[mesh->indices[i]].position, *b = mesh->vertices[mesh->indices[i + 1]].position,
					*c = mesh->vertices[mesh->indices[i + 2]].position;
		area += 0.5f * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
	}
	assert_true(near(area, 2.0f));
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		assert_numbers(mesh->vertices[v].normal,
		               up[mesh->vertices[v].position[0] == 0.0f && mesh->vertices[v].position[1] == 1.0f ? 3 : 0], 3);
	stilb_scene_destroy(scene);
	/* A damaged stream, and numbers that the format does not have. */
	all[0] ^= 0xff;
	write_file("packed.bin", all, vertex_size + triangle_size + normal_size);
	assert_int_equal(open_file("packed.gltf", false, &scene), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "buffer view 0 does not decompress"));
	write_packed("4000000", vertex_size, triangle_size, normal_size); /* no file of so few bytes holds so many */
	assert_int_equal(open_file("packed.gltf", false, &scene), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "impossible mode, count or stride"));
	remove("packed.gltf");
	remove("packed.bin");
}

/* A quad of 2 x 1 with texture coordinates, written by the Draco library with 11 and 10 bits. */
static const uint8_t draco_quad[] = {
	0x44, 0x52, 0x41, 0x43, 0x4f, 0x02, 0x02, 0x01, 0x01, 0x00, 0x00, 0x00, 0x04, 0x02, 0x01, 0x02, 0x00, 0x00, 0x01,
	0x1f, 0xff, 0x01, 0x11, 0xff, 0x01, 0x11, 0x02, 0xff, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x09, 0x03, 0x00,
	0x00, 0x02, 0x01, 0x03, 0x09, 0x02, 0x00, 0x01, 0x02, 0x01, 0x01, 0x01, 0x00, 0x0c, 0x03, 0x01, 0x20, 0x01, 0x10,
	0x1f, 0x01, 0x10, 0x03, 0x00, 0x14, 0x90, 0x08, 0xc0, 0xff, 0x01, 0x20, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0x07,
	0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x0b,
	0x01, 0x01, 0x01, 0x00, 0x03, 0x03, 0x01, 0x20, 0x01, 0x20, 0x03, 0x00, 0xf0, 0x83, 0xa6, 0x00, 0x00, 0x00, 0x00,
	0x00, 0xff, 0x03, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x0a};

#define DRACO                                                                                                          \
	NODE ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,"              \
		 "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0,"            \
		 "\"TEXCOORD_0\":1}}}}]}],\"accessors\":[{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"              \
		 "{\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},{\"componentType\":5125,\"count\":6,\"type\":"        \
		 "\"SCALAR\"}]"

static void draco(void **state)
{
	(void)state;
	begin();
	put(draco_quad, sizeof draco_quad);
	stilb_scene *scene = open_glb(DRACO);
	const stilb_scene_mesh *mesh = &scene->meshes[0];
	assert_int_equal(mesh->index_count, 6);
	for (uint32_t i = 0; i < 6; i++) {
		const stilb_scene_vertex *vertex = &mesh->vertices[mesh->indices[i]];
		float x = vertex->position[0], y = vertex->position[1];
		assert_true(fabsf(x * (2.0f - x)) < 0.01f && fabsf(y * (1.0f - y)) < 0.01f); /* a corner */
		assert_true(fabsf(vertex->uv[0] - 0.5f * x) < 0.01f && fabsf(vertex->uv[1] - (1.0f - y)) < 0.01f);
	}
	stilb_scene_destroy(scene);
	begin();
	put(draco_quad, sizeof draco_quad / 2);
	assert_refused(DRACO, "compressed by Draco, in buffer view 0: it is damaged");
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* A range ends the light where it says; cones are the cosines of their angles from the axis. */
static void lights(void **state)
{
	(void)state;
#define LIT "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":"
	static const char nodes[] = "{\"mesh\":0}," LIT "0}}}," LIT "1}}}," LIT "2}}}," LIT "3}}}";
	static const char list[] =
		"{\"type\":\"point\",\"range\":12.5},"
		"{\"type\":\"spot\",\"intensity\":3,\"spot\":{\"innerConeAngle\":0.25,\"outerConeAngle\":0.5}},"
		"{\"type\":\"directional\",\"range\":4},{\"name\":\"off\",\"type\":\"point\",\"intensity\":0}";
	char json[2048];
	snprintf(json, sizeof json,
	         "\"scenes\":[{\"nodes\":[0,1,2,3,4]}],\"nodes\":[%s],%s,\"accessors\":[%s],"
	         "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[%s]}}",
	         nodes, TRIANGLE, VEC3(0), list);
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(json);
	assert_int_equal(scene->light_count, 3);
	assert_int_equal(scene->lights[0].falloff, STILB_SCENE_LIGHT_RANGED);
	assert_true(scene->lights[0].reach == 12.5f);
	assert_int_equal(scene->lights[1].kind, STILB_SCENE_LIGHT_SPOT);
	assert_int_equal(scene->lights[1].falloff, STILB_SCENE_LIGHT_PHYSICAL);
	assert_numbers(&scene->lights[1].cos_inner, (const float[]){cosf(0.25f), cosf(0.5f)}, 2);
	assert_numbers(scene->lights[1].direction, (const float[]){0, 0, -1}, 3);
	assert_int_equal(scene->lights[2].kind, STILB_SCENE_LIGHT_DIRECTIONAL);
	assert_said("lights without brightness, or too far away, are left out: 1 light ('off')");
	for (uint32_t i = 0; i < 3; i++)
		assert_int_equal(scene->light_mounts[i].node, 2 + i);
	stilb_scene_destroy(scene);
}

/* A spot and a camera on a child of an arm; where the arm turns, they follow. */
static void lights_and_cameras_hang_on_their_nodes(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(TRIANGLE ",\"accessors\":[" VEC3(
		0) "],\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0},"
	       "{\"name\":\"arm\",\"translation\":[0,5,0],\"children\":[2]},{\"translation\":[1,0,0],\"camera\":0,"
	       "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
	       "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
	       "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\"}]}}");
	assert_true(scene->light_count == 1 && scene->camera_count == 1);
	assert_true(scene->light_mounts[0].node == 3 && scene->camera_mounts[0].node == 3);
	assert_numbers(scene->lights[0].position, (const float[]){1, 5, 0}, 3);
	assert_numbers(scene->cameras[0].camera.position, (const float[]){1, 5, 0}, 3);
	stilb_scene_pose turned = scene->nodes.pose[1]; /* a quarter of a turn to the left, seen from above */
	turned.rotation[1] = turned.rotation[3] = sqrtf(0.5f);
	turned.scale[0] = turned.scale[1] = turned.scale[2] = 2.0f;
	assert_int_equal(stilb_scene_set_node_pose(scene, 1, &turned), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	assert_numbers(scene->lights[0].position, (const float[]){0, 5, -2}, 3);
	assert_numbers(scene->lights[0].direction, (const float[]){-1, 0, 0}, 3);
	assert_numbers(scene->lights[0].intensity, (const float[]){1, 1, 1}, 3);
	const stilb_scene_camera *camera = &scene->cameras[0].camera;
	assert_numbers(camera->position, (const float[]){0, 5, -2}, 3);
	assert_true(fabsf(camera->yaw - 1.5707963f) < 1e-5f && fabsf(camera->pitch) < 1e-5f && camera->roll == 0.0f);
	assert_true(camera->fov_y == 0.8f);
	stilb_scene_destroy(scene);
}

/* ---- what moves -------------------------------------------------------------------------------------------------- */

/* Views: 0 positions, 1 indices that use vertices 2 1 0 alone, 2 joints, 3 weights, 4 matrices, 5 times, 6 values,
 * 7 what a target adds, 8 places of a sparse accessor. */
static void put_moving(void)
{
	static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}};
	static const uint8_t joints[4][4] = {{0, 1, 0, 0}, {1, 0, 200, 200}, {0, 0, 0, 0}, {255, 255, 255, 255}};
	static const float weights[4][4] = {{0.75f, 0.25f, 0, 0}, {1, 0, 0, 0}, {0.5f, 0, 0, -1}, {1, 1, 1, 1}};
	static const float binds[2][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1},
	                                   {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}};
	static const float times[4] = {0, 0.5f, 0.5f, 2};
	float values[48];
	for (int i = 0; i < 48; i++)
		values[i] = 0.125f * (float)i;
	begin();
	put(corners, sizeof corners);
	put((const uint8_t[]){2, 1, 0}, 3);
	put(joints, sizeof joints);
	put(weights, sizeof weights);
	put(binds, sizeof binds);
	put(times, sizeof times);
	put(values, sizeof values);
	put((const float[]){3, 4, 5}, 12);
	put((const uint8_t[]){1}, 1);
}

#define NUMBERS(view, type, count, shape)                                                                              \
	"{\"bufferView\":" #view ",\"componentType\":" #type ",\"count\":" #count ",\"type\":\"" shape "\"}"
#define MOVING_ACCESSORS                                                                                               \
	"\"accessors\":["                                                                                                  \
	"{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"                                         \
	"{\"bufferView\":1,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"},"                                       \
	"{\"bufferView\":2,\"componentType\":5121,\"count\":4,\"type\":\"VEC4\"},"                                         \
	"{\"bufferView\":3,\"componentType\":5126,\"count\":4,\"type\":\"VEC4\"},"                                         \
	"{\"bufferView\":4,\"componentType\":5126,\"count\":2,\"type\":\"MAT4\"},"                                         \
	"{\"bufferView\":5,\"componentType\":5126,\"count\":4,\"type\":\"SCALAR\"},"                                       \
	"{\"bufferView\":6,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"                                         \
	"{\"bufferView\":6,\"componentType\":5126,\"count\":12,\"type\":\"VEC4\"},"                                        \
	"{\"bufferView\":6,\"componentType\":5126,\"count\":8,\"type\":\"SCALAR\"},"                                       \
	"{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":8,"     \
	"\"componentType\":5121},\"values\":{\"bufferView\":7}}}"

#define MOVING_MESH                                                                                                    \
	"\"meshes\":[{\"weights\":[0.5,0.25],\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"JOINTS_0\":2," \
	"\"WEIGHTS_0\":3},\"indices\":1,\"targets\":[{\"POSITION\":9},{\"NORMAL\":9}]}]}]"

/* Node 0 is in no scene. The scene's nodes are 3, its child 1 and then 2, a grandchild. */
#define MOVING_NODES                                                                                                   \
	"\"scenes\":[{\"nodes\":[3]}],\"nodes\":[{},{\"name\":\"arm\",\"mesh\":0,\"skin\":0,\"translation\":[1,2,3],"      \
	"\"children\":[2]},{\"mesh\":0,\"weights\":[7],\"scale\":[2,2,2]},{\"name\":\"root\",\"children\":[1],"            \
	"\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,4,0,0,1]}]"

#define CHANNEL(sampler, node, path) "{\"sampler\":" #sampler ",\"target\":{\"node\":" #node ",\"path\":\"" path "\"}}"
#define CLIP(samplers, channels) "\"samplers\":[" samplers "],\"channels\":[" channels "]"
#define SAMPLER(input, output) "{\"input\":" #input ",\"output\":" #output "}"
#define MOVING_CLIP                                                                                                    \
	"\"name\":\"wave\"," CLIP("{\"input\":5,\"output\":6,\"interpolation\":\"STEP\"},"                                 \
	                          "{\"input\":5,\"output\":7,\"interpolation\":\"CUBICSPLINE\"}," SAMPLER(5, 8),           \
	                          CHANNEL(0, 1, "translation") "," CHANNEL(1, 2, "rotation") "," CHANNEL(                  \
								  2, 1, "weights") "," CHANNEL(0, 0, "scale") "," CHANNEL(0, 2, "scale"))
#define SCALES CHANNEL(0, 1, "scale")
#define MOVING_SKINS "\"skins\":[{\"name\":\"bones\",\"joints\":[2,3],\"inverseBindMatrices\":4}]"

static void assert_hierarchy(const stilb_scene_animation *a)
{
	assert_int_equal(a->node_count, 3);
	assert_string_equal(a->nodes[0].name, "root");
	assert_false(a->nodes[0].moves);
	assert_true(a->nodes[0].parent == STILB_SCENE_NONE && a->nodes[1].parent == 0 && a->nodes[2].parent == 1);
	assert_numbers(a->nodes[0].local.m + 12, (const float[]){4, 0, 0}, 3);
	assert_numbers(a->nodes[1].translation, (const float[]){1, 2, 3}, 3);
	assert_true(a->nodes[1].moves && a->nodes[1].skin == 0 && a->nodes[2].skin == STILB_SCENE_NONE);
	assert_true(a->nodes[0].model_count == 0 && a->nodes[1].model_count == 1 && a->nodes[2].first_model == 1);
	assert_int_equal(a->nodes[1].weight_count, 2);
	assert_numbers(a->weights + a->nodes[1].first_weight, (const float[]){0.5f, 0.25f}, 2);
	assert_numbers(a->weights + a->nodes[2].first_weight, (const float[]){7, 0}, 2);
}

/* The vertices that triangles use, in the order of the file: joints of a weight that is not above 0 are 0. */
static void assert_deform(const stilb_scene_deform *d)
{
	assert_true(d->mesh == 0 && d->influences == 4 && d->targets == 2);
	assert_memory_equal(d->joints, ((const uint16_t[]){0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}), 24);
	assert_numbers(d->weights, (const float[]){0.75f, 0.25f, 0, 0, 1, 0, 0, 0, 0.5f, 0, 0, 0}, 12);
	assert_numbers(d->positions, (const float[]){0, 0, 0, 3, 4, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 18);
	assert_numbers(d->normals, (const float[]){0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 4, 5, 0, 0, 0}, 18);
}

/* Channels share the times of their accessor, and one that moves what is in no scene is not there. */
static void assert_channels(const stilb_scene_animation *a)
{
	const stilb_scene_channel *c = a->channels;
	assert_int_equal(a->clip_count, 1);
	assert_string_equal(a->clips[0].name, "wave");
	assert_true(a->clips[0].duration == 2.0f && a->clips[0].channel_count == 4 && a->time_count == 4);
	assert_true(c[0].node == 1 && c[0].path == STILB_SCENE_PATH_TRANSLATION && c[0].interpolation == STILB_SCENE_STEP);
	assert_true(c[1].node == 2 && c[1].path == STILB_SCENE_PATH_ROTATION && c[1].interpolation == STILB_SCENE_CUBIC);
	assert_true(c[2].width == 2 && c[2].path == STILB_SCENE_PATH_WEIGHTS && c[2].interpolation == STILB_SCENE_LINEAR);
	assert_true(c[3].node == 2 && c[3].path == STILB_SCENE_PATH_SCALE && c[3].first_value == c[0].first_value);
	assert_numbers(a->times + c[2].first_time, (const float[]){0, 0.5f, 0.5f, 2}, 4);
	assert_int_equal(a->value_count, 12 + 48 + 8);
	assert_numbers(a->values + c[1].first_value + 47, (const float[]){47 * 0.125f}, 1);
}

static void clips_skins_and_targets_are_kept(void **state)
{
	(void)state;
	put_moving();
	stilb_scene *scene = open_glb(MOVING_NODES "," MOVING_MESH "," MOVING_ACCESSORS "]," MOVING_SKINS
	                                           ",\"animations\":[{" MOVING_CLIP "}]");
	const stilb_scene_animation *a = scene->animation;
	assert_non_null(a);
	assert_hierarchy(a);
	assert_true(a->deform_count == 1 && scene->meshes[0].vertex_count == 3);
	assert_deform(a->deforms);
	assert_true(a->skin_count == 1 && a->skins[0].joint_count == 2 && a->joints[0] == 2 && a->joints[1] == 0);
	assert_string_equal(a->skins[0].name, "bones");
	assert_numbers(a->inverse_binds[0].m + 12, (const float[]){5, 6, 7, 1}, 4);
	assert_numbers(a->inverse_binds[1].m, (const float[]){2, 0}, 2);
	assert_channels(a);
	stilb_scene_destroy(scene);
}

/* What targets add to tangents is kept where it is added to the file's own: those that are made, as without normals,
 * come out otherwise. */
static void targets_change_the_tangents_of_the_file(void **state)
{
	(void)state;
	static const struct {
		const char *attributes, *material;
		bool kept;
	} rows[] = {
		{"\"NORMAL\":1,\"TANGENT\":2,\"TEXCOORD_0\":4", ",\"material\":0", true},
		{"\"NORMAL\":1,\"TANGENT\":2,\"TEXCOORD_0\":4", "", false},
		{"\"NORMAL\":1,\"TEXCOORD_0\":4", ",\"material\":0", false},
		{"\"TANGENT\":2,\"TEXCOORD_0\":4", ",\"material\":0", false},
	};
	static const float up[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1}, tangents[12] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1};
	static const float added[9] = {0, 2, 0, 0, 3, 0, 0, 4, 5};
	write_picture("leaf.png");
	begin();
	put(triangle, sizeof triangle);
	put(up, sizeof up);
	put(tangents, sizeof tangents);
	put(added, sizeof added);
	put(triangle, 24);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		char json[2048];
		snprintf(json, sizeof json,
		         NODE ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,%s}%s,"
		              "\"targets\":[{\"NORMAL\":3},{\"TANGENT\":3}]}]}],\"textures\":[{\"source\":0}],"
		              "\"images\":[{\"uri\":\"leaf.png\"}],\"materials\":[{\"normalTexture\":{\"index\":0}}],"
		              "\"accessors\":[" VEC3(0) "," VEC3(1) ",%s," VEC3(3) ",%s]",
		         rows[i].attributes, rows[i].material, NUMBERS(2, 5126, 3, "VEC4"), NUMBERS(4, 5126, 3, "VEC2"));
		stilb_scene *scene = open_glb(json);
		assert_int_equal(scene->animation->deform_count, 1);
		const stilb_scene_deform *d = scene->animation->deforms;
		assert_int_equal(d->targets, 2);
		if (!d->tangents == rows[i].kept)
			fail_msg("row %zu: tangents are%s kept", i, d->tangents ? "" : " not");
		if (d->tangents) {
			assert_numbers(d->tangents, (const float[]){0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 3, 0, 0, 4, 5}, 18);
			assert_numbers(scene->meshes[0].extras[2].tangent, (const float[]){1, 0, 0, -1}, 4);
		}
		stilb_scene_destroy(scene);
	}
	remove("leaf.png");
}

#define MESH_OF(rest) "\"meshes\":[{\"primitives\":[{\"indices\":1," rest "}]}]"

/* What is damaged of it is left out and named with its reason; the rest of the file opens. */
static void damaged_motion_is_left_out(void **state)
{
	(void)state;
	static const struct {
		const char *skins, *clip, *mesh, *says;
		uint32_t clip_count, skin_count, deform_count;
	} rows[] = {
		{MOVING_SKINS, CLIP("", SCALES), MOVING_MESH,
	     "animations that are damaged are left out: 1 animation ('number 0: it has no sampler 0')", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(5, 8), SCALES), MOVING_MESH, "accessor 8 has 1 numbers an element", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(8, 6), SCALES), MOVING_MESH, "accessor 6 has 12 numbers for 8 keys of 3", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(6, 6), SCALES), MOVING_MESH, "accessor 6 has 3 numbers an element", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(5, 6), CHANNEL(0, 3, "scale")), MOVING_MESH, "it moves node 3, which has a matrix",
	     0, 1, 1},
		{MOVING_SKINS, CLIP("{\"input\":5,\"output\":6,\"interpolation\":\"BEZIER\"}", SCALES), MOVING_MESH,
	     "an unknown interpolation", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(10, 6), SCALES), MOVING_MESH, "the times of accessor 10 are negative or descend", 0,
	     1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(5, 99), SCALES), MOVING_MESH, "'output' is 99, but there are 12", 0, 1, 1},
		{MOVING_SKINS, CLIP(SAMPLER(5, 11), CHANNEL(0, 1, "rotation")), MOVING_MESH, "accessor 11 is NaN or infinite",
	     0, 1, 1},
		{"\"skins\":[{\"joints\":[0,2]}]", MOVING_CLIP, MOVING_MESH,
	     "skins that are damaged are left out: 1 skin ('number 0: joint 0 is not in the scene')", 1, 0, 1},
		{"\"skins\":[{\"joints\":[1,77]}]", MOVING_CLIP, MOVING_MESH, "joint 77 is not in the scene", 1, 0, 1},
		{"\"skins\":[{\"joints\":[1,2,3],\"inverseBindMatrices\":4}]", MOVING_CLIP, MOVING_MESH,
	     "accessor 4 has 2 matrices for 3 joints", 1, 0, 1},
		{"\"skins\":[{\"joints\":[2]}]", MOVING_CLIP, MOVING_MESH, "a vertex names joint 1 of 1", 1, 1, 1},
		{MOVING_SKINS, MOVING_CLIP, MESH_OF("\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1}]"),
	     "skins and morph targets of meshes that are damaged are left out: 1 mesh ('number 0: accessor 1 has 1", 1, 1,
	     0},
		{MOVING_SKINS, MOVING_CLIP, MESH_OF("\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2}"),
	     "JOINTS_0 and WEIGHTS_0 do not go together", 1, 1, 0},
		{MOVING_SKINS, MOVING_CLIP, MESH_OF("\"attributes\":{\"POSITION\":0,\"JOINTS_0\":11,\"WEIGHTS_0\":3}"),
	     "has joint nan with weight", 1, 1, 0},
	};
	put_moving();
	static const float descending[2] = {1, 0.5f};
	float nan[16];
	for (int i = 0; i < 16; i++)
		nan[i] = NAN;
	put(descending, sizeof descending);
	put(nan, sizeof nan);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		char json[8192];
		snprintf(json, sizeof json, "%s,%s,%s,%s,%s],%s,\"animations\":[{%s}]", MOVING_NODES, rows[i].mesh,
		         MOVING_ACCESSORS, NUMBERS(9, 5126, 2, "SCALAR"), NUMBERS(10, 5126, 4, "VEC4"), rows[i].skins,
		         rows[i].clip);
		stilb_scene *scene = open_glb(json);
		assert_said(rows[i].says);
		const stilb_scene_animation *a = scene->animation;
		uint32_t clips = a ? a->clip_count : 0, skins = a ? a->skin_count : 0, deforms = a ? a->deform_count : 0;
		if (clips != rows[i].clip_count || skins != rows[i].skin_count || deforms != rows[i].deform_count)
			fail_msg("row %zu: %u clips, %u skins, %u deforms", i, clips, skins, deforms);
		stilb_scene_destroy(scene);
	}
}

/* ---- what is not shown ------------------------------------------------------------------------------------------- */

#define EVERYTHING                                                                                                     \
	NODE ",\"accessors\":[" VEC3(                                                                                      \
		0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"                                \
		   "\"meshes\":[{\"name\":\"card\",\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":0,"             \
		   "\"TEXCOORD_0\":1},\"material\":0,\"targets\":[{\"POSITION\":0}]}]}],\"textures\":[{\"source\":0,"          \
		   "\"sampler\":0}],"                                                                                          \
		   "\"samplers\":[{\"wrapS\":33071,\"magFilter\":9728}],\"images\":[{\"uri\":\"leaf.png\"}],"                  \
		   "\"materials\":[{\"name\":\"leaf\",\"alphaMode\":\"MASK\",\"emissiveFactor\":[1,1,1],"                      \
		   "\"normalTexture\":{\"index\":0},\"occlusionTexture\":{\"index\":0},\"emissiveTexture\":{\"index\":0},"     \
		   "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}}}" \
		   ","                                                                                                         \
		   "{\"name\":\"glass\",\"alphaMode\":\"BLEND\"},{\"alphaMode\":\"BLEND\"}],"                                  \
		   "\"animations\":[{\"name\":\"walk\",\"channels\":[],\"samplers\":[]}],\"skins\":[{\"joints\":[0]}],"        \
		   "\"extensionsUsed\":[\"KHR_materials_dispersion\",\"KHR_texture_transform\",\"ACME_fur\"],"                 \
		   "\"extensionsRequired\":[\"ACME_fur\"],\"extensions\":{\"KHR_materials_variants\":{\"variants\":["          \
		   "{\"name\":\"red\"},{\"name\":\"green\"}]}}"

static void what_is_not_shown_is_named(void **state)
{
	(void)state;
	static const char *const lines[] = {
		"it requires extensions that are not shown, so it looks other than it should: ACME_fur\n",
		"it uses extensions that are not shown: KHR_materials_dispersion, ACME_fur\n",
		"its materials have variants: red, green\n",
		"animations move nothing of the scene: 1 animation ('walk')\n",
	};
	write_picture("leaf.png");
	begin();
	put(triangle, sizeof triangle);
	put(triangle, 24);
	stilb_scene *scene = open_glb(EVERYTHING);
	for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
		assert_said(lines[i]);
	/* The same picture is there twice, as a colour and as data. */
	assert_int_equal(scene->texture_count, 2);
	assert_int_equal(scene->surface_count, 3);
	const stilb_scene_surface *leaf = &scene->surfaces[scene->materials[0].surface - 1];
	for (int kind = 0; kind < STILB_SCENE_MAPS; kind++) {
		uint32_t texture = leaf->maps[kind].texture;
		assert_int_equal(texture > 0, kind <= STILB_SCENE_MAP_EMISSION);
		if (texture == 0)
			continue;
		bool color = kind == STILB_SCENE_MAP_COLOR || kind == STILB_SCENE_MAP_EMISSION;
		assert_int_equal(scene->textures[texture - 1].format, color ? STILB_IMAGE_U8_SRGB : STILB_IMAGE_U8_LINEAR);
		assert_int_equal(leaf->maps[kind].wrap_u, STILB_SCENE_CLAMP);
		assert_int_equal(leaf->maps[kind].wrap_v, STILB_SCENE_REPEAT);
		assert_true(leaf->maps[kind].nearest);
	}
	assert_memory_equal(scene->textures[0].pixels, scene->textures[1].pixels, stilb_image_size(scene->textures));
	assert_true(leaf->alpha == STILB_SCENE_MASK && leaf->cutoff == 0.5f && leaf->one_sided);
	assert_numbers(leaf->emission, (const float[]){1, 1, 1}, 3);
	assert_int_equal(scene->surfaces[1].alpha, STILB_SCENE_BLEND);
	assert_non_null(scene->meshes[0].extras);
	stilb_scene_destroy(scene);
	assert_int_equal(open_file("test.glb", true, &scene), STILB_OK);
	assert_string_equal(said, "");
	stilb_scene_destroy(scene);
	uint64_t bytes = 0;
	stilb_scene_open_options options = {.quiet = true, .import_bytes = &bytes};
	assert_int_equal(stilb_scene_open_with("test.glb", &options, &scene), STILB_OK);
	assert_true(bytes > 1u << 20 && bytes < 1u << 30);
	stilb_scene_destroy(scene);
	assert_int_equal(stilb_scene_open_with("cornell", &options, &scene), STILB_OK);
	assert_true(bytes == 0);
	stilb_scene_destroy(scene);
	remove("leaf.png");
}

/* ---- damaged files ----------------------------------------------------------------------------------------------- */

#define ONE(accessors) NODE "," TRIANGLE ",\"accessors\":[" accessors "]"

static void damaged_numbers_are_refused(void **state)
{
	(void)state;
	static const struct {
		const char *json, *says;
	} rows[] = {
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}"),
	     "accessor 0 needs 48 bytes from byte 0 on, but buffer view 0 has 36"},
		{ONE("{\"bufferView\":0,\"byteOffset\":9007199254740992,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}"),
	     "accessor 0 needs"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":9007199254740992,\"type\":\"VEC3\"}"),
	     "accessor 0 has 9007199254740992 elements"},
		{ONE("{\"componentType\":5126,\"count\":99999999,\"type\":\"VEC3\"}"), "99999999 elements without data"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":-3,\"type\":\"VEC3\"}"), "whole number"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":1.5,\"type\":\"VEC3\"}"), "whole number"},
		{ONE("{\"bufferView\":9,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}"), "there are 1 of these"},
		{ONE("{\"bufferView\":0,\"componentType\":5130,\"count\":3,\"type\":\"VEC3\"}"),
	     "accessor 0 has no known type"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}"), "accessor 0 has 2 numbers"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
	         "\"indices\":"
	         "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5125},\"values\":{\"bufferView\":0}}}"),
	     "accessor 0 is sparse and replaces its element"},
		{ONE("{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":4}}"),
	     "without sound indices"},
		{ONE(""), "'POSITION' is 0, but there are 0"},
		{NODE ",\"meshes\":3", "'meshes' is not of type array"},
		{NODE ",\"meshes\":[3]", "is not of type object"},
		{"\"nodes\":[{\"mesh\":0,\"scale\":[1,2]}]", "'scale' has 2 numbers instead of 3"},
		{"\"nodes\":[{\"mesh\":5}]", "'mesh' is 5, but there are 0"},
	};
	begin();
	put(triangle, sizeof triangle);
	((unsigned char *)data)[12] = 99; /* a sparse index */
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		assert_refused(rows[i].json, rows[i].says);
	snprintf(views, sizeof views, "{\"buffer\":0,\"byteOffset\":8,\"byteLength\":36}");
	assert_refused(ONE(VEC3(0)), "buffer view 0, 36 bytes from byte 8 on, is not inside buffer 0");
	snprintf(views, sizeof views, "{\"buffer\":0,\"byteLength\":36,\"byteStride\":99999}");
	assert_refused(ONE(VEC3(0)), "buffer view 0");
	snprintf(views, sizeof views, "{\"buffer\":3,\"byteLength\":36}");
	assert_refused(ONE(VEC3(0)), "'buffer' is 3, but there are 1");
	snprintf(views, sizeof views, "{\"buffer\":0,\"byteLength\":36},{\"byteLength\":4}");
	assert_refused(ONE(VEC3(1)), "buffer view 1 is of no buffer");
}

static void damaged_containers_are_refused(void **state)
{
	(void)state;
	static const struct {
		const char *text, *says;
	} rows[] = {
		{"{\"asset\":{\"version\":\"2.0\"},}", "JSON is damaged at line 1, column 28: expected a key in quotes"},
		{"{\"asset\":\n{\"version\":\"2.0\"", "line 2, column 17: expected ',' or '}'"},
		{"[1,2]", "is not an object"},
		{"", "it is empty"},
		{"{}", "does not name its version"},
		{"{\"asset\":{\"version\":\"3.0\"}}", "glTF version 3.0"},
		{"{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":9,\"uri\":\"no.bin\"}]}",
	     "'no.bin': there is no"},
		{"{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":9,\"uri\":\"data:,AAAA\"}]}",
	     "has 3 of its 9 bytes"},
		{"{\"asset\":{\"version\":\"2.0\"}}", "no triangles"},
		{"{\"asset\":{\"version\":\"2.0\"},\"x\":tru}", "expected a value"},
		{"{\"asset\":{\"version\":\"2.0\"},\"x\":1e}", "expected a digit"},
		{"{\"asset\":{\"version\":\"2.0\"}} x", "expected the end"},
	};
	stilb_scene *scene;
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		write_file("bad.gltf", rows[i].text, strlen(rows[i].text));
		assert_int_equal(open_file("bad.gltf", false, &scene), STILB_ERROR_FILE);
		if (!strstr(stilb_error_message(), rows[i].says))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), rows[i].says);
	}
	/* A million brackets: neither reading nor looking up recurses. */
	static char deep[1000000];
	memset(deep, '[', sizeof deep);
	write_file("bad.gltf", deep, sizeof deep);
	assert_int_equal(open_file("bad.gltf", false, &scene), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "nested more than"));
	remove("bad.gltf");
	/* A .glb cut off anywhere is refused with a reason. */
	begin();
	put(triangle, sizeof triangle);
	write_glb(ONE(VEC3(0)));
	assert_int_equal(open_file("test.glb", false, &scene), STILB_OK);
	stilb_scene_destroy(scene);
	unsigned char whole[1024];
	FILE *file = fopen("test.glb", "rb");
	assert_non_null(file);
	size_t size = fread(whole, 1, sizeof whole, file);
	fclose(file);
	for (size_t cut = 0; cut < size; cut += 29) {
		write_file("cut.glb", whole, cut);
		assert_int_equal(open_file("cut.glb", false, &scene), STILB_ERROR_FILE);
		assert_null(strstr(stilb_error_message(), "crashed"));
	}
	remove("cut.glb");
}

/* Names of buffers and of their data as exporters write them. */
static void buffers_by_any_name(void **state)
{
	(void)state;
	stilb_scene *scene;
	float longer[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 7, 7, 7};
	static const char *const names[] = {"a b\\u00e9.bin", "a%20b%C3%A9.bin"};
	write_file("a b\xC3\xA9.bin", longer, sizeof longer); /* longer than byteLength */
	for (int i = 0; i < 2; i++) {
		char text[512];
		snprintf(text, sizeof text,
		         "\xEF\xBB\xBF{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"%s\"}],"
		         "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],%s}",
		         names[i], ONE(VEC3(0)));
		write_file("named.gltf", text, strlen(text));
		if (open_file("named.gltf", false, &scene) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_triangles(&scene->meshes[0], (const float[][2]){{0, 0}, {1, 0}, {0, 1}}, 3);
		stilb_scene_destroy(scene);
	}
	remove("a b\xC3\xA9.bin");
	remove("named.gltf");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sparse_accessors),
		cmocka_unit_test(every_component_type),
		cmocka_unit_test(strips_fans_lines_and_points),
		cmocka_unit_test(normals),
		cmocka_unit_test(scenes_and_nodes),
		cmocka_unit_test(instances),
		cmocka_unit_test(extras_say_what_models_are),
		cmocka_unit_test(meshopt),
		cmocka_unit_test(draco),
		cmocka_unit_test(lights),
		cmocka_unit_test(lights_and_cameras_hang_on_their_nodes),
		cmocka_unit_test(clips_skins_and_targets_are_kept),
		cmocka_unit_test(targets_change_the_tangents_of_the_file),
		cmocka_unit_test(damaged_motion_is_left_out),
		cmocka_unit_test(what_is_not_shown_is_named),
		cmocka_unit_test(damaged_numbers_are_refused),
		cmocka_unit_test(damaged_containers_are_refused),
		cmocka_unit_test(buffers_by_any_name),
	};
	return cmocka_run_group_tests(tests, folder_make, glb_clear);
}
