/* The contracts of scene, each broken on purpose. */
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/edit/scene_variant.h"
#include "scene/open/scene_builtin.h"
#include "scene/open/scene_files.h"
#include "scene/open/scene_import.h"
#include "scene/open/scene_stream.h"
#include "scene/scene_build.h"
#include "scene/scene_internal.h"
#include "scene/scene_look.h"
#include "scene/scene_pick.h"
#include "scene/tangents/scene_tangents.h"
#include "support/contract.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

static const float grey[3] = {0.5f, 0.5f, 0.5f};

static void meshes(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	contract_breaks("index_count % 3 == 0", scene_mesh_create(&mesh, 3, 4));
	contract_breaks("`mesh'", scene_mesh_create(NULL, 3, 3));
	contract_breaks("splits <= 6", stilb_scene_mesh_sphere(7, &mesh));
	contract_breaks("`mesh'", stilb_scene_mesh_finish(NULL));
}

static void scenes(void **state)
{
	(void)state;
	stilb_scene *scene, *other;
	assert_int_equal(stilb_scene_open("spheres", &scene), STILB_OK);
	contract_breaks("model_count <=", scene_create(STILB_SCENE_MAX_MODELS + 1, 1, 1, 1, &other));
	contract_breaks("textures are added once", scene_add_textures(scene, 1));
	contract_breaks("lights are added once", scene_add_lights(scene, 1));
	contract_breaks("model < scene->model_count", scene_fit_bounds(scene, 1));
	contract_breaks("scene && radiance", stilb_scene_set_sky(scene, NULL));
	contract_breaks("transform && ", stilb_scene_add_model(scene, NULL, NULL, 0, NULL));
	contract_breaks("`transforms'", stilb_scene_set_part_transforms(scene, 0, NULL));
	contract_breaks("vertices || count == 0", stilb_scene_set_vertices(scene, 0, 0, 1, NULL));
	contract_breaks("`mesh && id'", stilb_scene_add_mesh(scene, NULL, NULL));
	contract_breaks("`material'", stilb_scene_set_material(scene, 0, NULL));
	contract_breaks("`image'", stilb_scene_set_texture(scene, 0, NULL));
	contract_breaks("scene && ray && hit", stilb_scene_pick(scene, &(stilb_scene_ray){0}, NULL));
	contract_breaks("scene && ray && hit", stilb_scene_pick_indexed(scene, &(stilb_scene_ray){0}, NULL, NULL));
	contract_breaks("width > 0 && height > 0", stilb_scene_camera_ray(&scene->camera, 0, 1, 0.0, 0.0));
	contract_breaks("(radiance[i])", stilb_scene_set_sky(scene, (const float[3]){1, INFINITY, 1}));
	contract_breaks("radiance[i] >= 0", stilb_scene_set_sky(scene, (const float[3]){1, -1, 1}));
	contract_breaks("diffuse && specular", stilb_scene_material_make(NULL, grey, 0.5f));
	contract_breaks("scene && path", stilb_scene_set_environment(scene, NULL));
	contract_breaks("name && options && scene", stilb_scene_open(NULL, &other));
	contract_breaks("name && options && scene", stilb_scene_open_with("cornell", NULL, &other));
	contract_breaks("reflectance < 1", scene_create_furnace(1.0f, &other));
	stilb_scene_destroy(scene);
}

static void looks(void **state)
{
	(void)state;
	stilb_scene *scene;
	stilb_scene_camera no_view = {.near_z = 0.1f};
	float exposure;
	assert_int_equal(stilb_scene_open("spheres", &scene), STILB_OK);
	contract_breaks("scene && camera && exposure", stilb_scene_meter(scene, &scene->camera, NULL));
	contract_breaks("camera->fov_y > 0.0f", stilb_scene_meter(scene, &no_view, &exposure));
	contract_breaks("(yaw)", stilb_scene_set_studio(scene, NAN));
	contract_breaks("color[i] >= 0.0f", (stilb_scene_set_backdrop(scene, (const float[3]){0, -1, 0}), 0));
	contract_breaks("scene && name", stilb_scene_show_variant_named(scene, NULL));
	contract_breaks("`scene'", stilb_scene_show_variant(NULL, 0));
	contract_breaks("`scene'", stilb_scene_revisions_read(NULL));
	contract_breaks("lights || count == 0", stilb_scene_set_lights(scene, NULL, 1));
	stilb_scene_destroy(scene);
}

static void nodes(void **state)
{
	(void)state;
	stilb_scene *scene;
	stilb_scene_pose pose = stilb_scene_pose_identity();
	uint32_t id;
	assert_int_equal(stilb_scene_open("spheres", &scene), STILB_OK);
	contract_breaks("pose && id", stilb_scene_add_node(scene, STILB_SCENE_NONE, NULL, &id));
	contract_breaks("pose && id", stilb_scene_add_node(scene, STILB_SCENE_NONE, &pose, NULL));
	contract_breaks("`scene'", stilb_scene_add_node(NULL, STILB_SCENE_NONE, &pose, &id));
	contract_breaks("`pose'", stilb_scene_set_node_pose(scene, 0, NULL));
	contract_breaks("`local'", stilb_scene_set_node_matrix(scene, 0, NULL));
	contract_breaks("scene && name", stilb_scene_find_node(scene, NULL));
	contract_breaks("`scene'", (stilb_scene_update_nodes(NULL, NULL, 0), 0));
	contract_breaks("`pose'", (stilb_scene_pose_matrix(NULL), 0));
	contract_breaks("`matrix'", (stilb_scene_pose_of(NULL), 0));
	stilb_scene_destroy(scene);
}

static void cameras(void **state)
{
	(void)state;
	stilb_vec3 here = stilb_vec3_make(1, 2, 3), there = stilb_vec3_make(4, 5, 6);
	contract_breaks("distance > 0.0f", scene_camera_look(here, here, 1.0f));
	contract_breaks("fov_y > 0.0f", scene_camera_look(here, there, 0.0f));
	contract_breaks("fov_y <", scene_camera_along(here, there, 3.2f));
	contract_breaks("`camera'", stilb_scene_camera_matrix(NULL, 1.0f));
}

static void the_stress_test(void **state)
{
	(void)state;
	stilb_scene *scene, *cornell;
	assert_int_equal(stilb_scene_create_stress(20, 1, &scene), STILB_OK);
	assert_int_equal(stilb_scene_open("cornell", &cornell), STILB_OK);
	contract_breaks("model_count >= 1", stilb_scene_create_stress(0, 1, &scene));
	contract_breaks("`out'", stilb_scene_create_stress(1, 1, NULL));
	contract_breaks("a scene of stilb_scene_create_stress", stilb_scene_animate(cornell, 0.0));
	contract_breaks("(seconds)", stilb_scene_animate(scene, (double)NAN));
	contract_breaks("a scene of stilb_scene_create_stress", stilb_scene_stress_camera(cornell, 0, 1.0f));
	contract_breaks("view <=", stilb_scene_stress_camera(scene, (stilb_scene_stress_view)3, 1.0f));
	contract_breaks("aspect > 0.0f", stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 0.0f));
	stilb_scene_destroy(scene);
	stilb_scene_destroy(cornell);
}

static void importing(void **state)
{
	(void)state;
	scene_files files = {.folder = -1, .parent = -1};
	scene_importer *importer;
	scene_message message = {.kind = SCENE_MESSAGE_OPEN};
	scene_stream stream = {.file = 0, .limit = 1, .taken = 2, .deadline_ns = UINT64_MAX};
	stilb_image picture;
	stilb_scene *scene;
	char why[256];
	int passed;
	contract_breaks("files && scene", scene_files_init(&files, NULL, false));
	contract_breaks("initialised", scene_files_open(&files, "a.png", why));
	contract_breaks("limits->seconds > 0.0", scene_importer_start(&(scene_import_limits){.bytes = 1}, &importer));
	contract_breaks("limits && importer", scene_importer_start(NULL, &importer));
	contract_breaks("importer && path", scene_importer_scene(NULL, "a.obj", &scene));
	contract_breaks("importer && path", scene_importer_picture(NULL, "a.png", true, &picture));
	contract_breaks("kind == SCENE_MESSAGE_PICTURE", scene_stream_take_picture(&stream, &message, -1, &picture));
	contract_breaks("file >= 0 && message", scene_stream_write_message(-1, &message, -1));
	contract_breaks("stream && message", scene_stream_read_message(&stream, NULL, &passed));
	contract_breaks("stream && scene", scene_stream_read(&stream, NULL, 1, &scene));
	contract_breaks("stream->taken <= stream->limit", scene_stream_read(&stream, NULL, 0, &scene));
	memset(message.text, 'x', sizeof message.text);
	contract_breaks("text ends with 0", scene_stream_write_message(0, &message, -1));
}

static void builds(void **state)
{
	(void)state;
	stilb_scene_build *build = stilb_scene_build_begin();
	contract_breaks("`mesh'", stilb_scene_build_mesh(build, NULL));
	contract_breaks("`image'", stilb_scene_build_texture(build, NULL));
	contract_breaks("`material'", stilb_scene_build_material(build, NULL));
	contract_breaks("`local'", stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, NULL));
	contract_breaks("parts || part_count == 0", stilb_scene_build_model(build, 0, NULL, 1));
	contract_breaks("`light'", stilb_scene_build_light(build, NULL));
	contract_breaks("`light'", stilb_scene_build_light_on(build, 0, NULL));
	contract_breaks("`camera'", stilb_scene_build_camera(build, NULL));
	contract_breaks("name && camera", stilb_scene_build_named_camera(build, NULL, 0, NULL));
	contract_breaks("`scene'", stilb_scene_build_end(build, NULL));
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_scene_destroy(scene);
}

static void tangents(void **state)
{
	(void)state;
	static const float numbers[9] = {0};
	static const uint32_t indices[3] = {0, 1, 2};
	float made[4][4] = {{0}};
	const float(*given)[4] = (const float(*)[4])made;
	scene_tangents_split split;
	scene_tangents_mesh good = {
		.positions = numbers,
		.normals = numbers,
		.uvs = numbers,
		.indices = indices,
		.vertex_count = 3,
		.index_count = 3,
	};
	scene_tangents_mesh mesh = good;
	assert_int_equal(scene_tangents_make(&mesh, made), STILB_OK);
	contract_breaks("mesh && (tangents || ", scene_tangents_make(NULL, made));
	contract_breaks("mesh && (tangents || ", scene_tangents_make(&mesh, NULL));
	contract_breaks("mesh && split && ", scene_tangents_split_make(NULL, given, &split));
	contract_breaks("mesh && split && ", scene_tangents_split_make(&mesh, NULL, &split));
	contract_breaks("mesh && split && ", scene_tangents_split_make(&mesh, given, NULL));
	contract_breaks("`split'", (scene_tangents_split_finish(NULL), 0));
	mesh.index_count = 2;
	contract_breaks("a list of triangles", scene_tangents_make(&mesh, made));
	mesh = good;
	mesh.vertex_count = 2;
	contract_breaks("index < mesh->vertex_count", scene_tangents_make(&mesh, made));
	contract_breaks("index < mesh->vertex_count", scene_tangents_split_make(&mesh, given, &split));
	mesh = good;
	mesh.normal_stride = 6;
	contract_breaks("mesh->normal_stride % 4 == 0", scene_tangents_make(&mesh, made));
	mesh = good;
	mesh.uvs = NULL;
	contract_breaks("mesh->normals && mesh->uvs", scene_tangents_make(&mesh, made));
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(meshes),          cmocka_unit_test(scenes),    cmocka_unit_test(builds),
		cmocka_unit_test(looks),           cmocka_unit_test(nodes),     cmocka_unit_test(cameras),
		cmocka_unit_test(the_stress_test), cmocka_unit_test(importing), cmocka_unit_test(tangents),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
