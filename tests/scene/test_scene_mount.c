/* Lights and cameras on nodes: after random edits they stand where a computation in double has them, those of nodes
 * that have not moved are as they were, builds and attachments mean the same, and each mistake is told in words. */
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/scene_internal.h"
#include "scene/scene_look.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define STEPS (TEST_ASAN || TEST_EMULATED ? 1000 : 4000)
#define NODES 7u
#define LIGHTS (2u * STILB_SCENE_LIGHT_KINDS)
#define CAMERAS 3u

static uint64_t random_index;

static uint32_t below(uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(23, random_index++) % bound);
}

static float between(float low, float high)
{
	return low + (high - low) * stilb_random_float(23, random_index++);
}

static stilb_scene_pose random_pose(void)
{
	float scale = between(0.6f, 1.5f);
	stilb_scene_pose pose = {.translation = {between(-2, 2), between(-2, 2), between(-2, 2)},
	                         .rotation = {between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)},
	                         .scale = {scale, scale, scale}};
	float *q = pose.rotation, length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	for (int i = 0; i < 4; i++)
		q[i] = length > 0.1f ? q[i] / length : (float)(i == 3);
	if (below(3) == 0)
		pose.scale[below(3)] *= below(2) ? -1.0f : 1.4f;
	return pose;
}

static stilb_scene_light light_of(uint32_t kind)
{
	float size = between(0.1f, 2.0f);
	return (stilb_scene_light){.kind = (stilb_scene_light_kind)kind,
	                           .position = {between(-1, 1), 2.0f, 0.5f},
	                           .direction = {0.6f, -0.8f, 0.0f},
	                           .intensity = {1.0f, 2.0f, 3.0f},
	                           .cos_inner = 0.9f,
	                           .cos_outer = 0.7f,
	                           .radius = size,
	                           .half_x = {0.8f * size, 0.6f * size, 0.0f},
	                           .half_y = {0.0f, 0.0f, 0.3f}};
}

static stilb_scene_camera camera_of(uint32_t index)
{
	return (stilb_scene_camera){.position = {1.0f, (float)index, 3.0f},
	                            .yaw = 0.7f * (float)index,
	                            .pitch = 0.4f - 0.3f * (float)index,
	                            .roll = 0.2f * (float)index,
	                            .fov_y = 0.9f,
	                            .near_z = 0.01f,
	                            .far_z = 100.0f};
}

/* A chain of nodes under a model, every second light and camera on the last node, the others on none. */
static stilb_scene *chain(void)
{
	static stilb_scene_vertex vertices[3] = {
		{{0, 0, 0}, {0, 0, 1}, {0, 0}}, {{1, 0, 0}, {0, 0, 1}, {0, 0}}, {{0, 1, 0}, {0, 0, 1}, {0, 0}}};
	static uint32_t indices[3] = {0, 1, 2};
	stilb_scene *scene;
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 3};
	stilb_scene_material paint = {.roughness = 0.5f};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &paint)};
	for (uint32_t n = 0; n < NODES; n++) {
		stilb_scene_pose pose = random_pose();
		stilb_scene_build_pose(build, n > 0 ? n - 1 : STILB_SCENE_NO_PARENT, &pose);
	}
	stilb_scene_build_model(build, 0, &part, 1);
	for (uint32_t i = 0; i < LIGHTS; i++) {
		stilb_scene_light light = light_of(i / 2);
		assert_int_equal(
			i % 2 ? stilb_scene_build_light_on(build, NODES - 1, &light) : stilb_scene_build_light(build, &light), i);
	}
	for (uint32_t c = 0; c < CAMERAS; c++) {
		stilb_scene_camera camera = camera_of(c);
		assert_int_equal(stilb_scene_build_named_camera(build, c == 1 ? "side" : "",
		                                                c % 2 ? STILB_SCENE_NO_PARENT : NODES - 1, &camera),
		                 c);
	}
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_int_equal(scene->light_count, LIGHTS);
	assert_int_equal(scene->camera_count, CAMERAS);
	assert_string_equal(scene->cameras[1].name, "side");
	return scene;
}

/* ---- truth, in double -------------------------------------------------------------------------------------------- */

static void turned(const stilb_mat4 *m, const float v[3], double out[3])
{
	for (int row = 0; row < 3; row++)
		out[row] = (double)m->m[row] * (double)v[0] + (double)m->m[4 + row] * (double)v[1] +
		           (double)m->m[8 + row] * (double)v[2];
}

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void assert_near(const float got[3], const double want[3], double scale)
{
	for (int i = 0; i < 3; i++)
		if (!(fabs((double)got[i] - want[i]) <= 2e-5 * scale))
			fail_msg("%g instead of %g", (double)got[i], want[i]);
}

static void assert_position(const stilb_mat4 *m, const float local[3], const float got[3])
{
	double at[3];
	turned(m, local, at);
	for (int i = 0; i < 3; i++)
		at[i] += (double)m->m[12 + i];
	assert_near(got, at, 1.0 + sqrt(dot(at, at)));
}

/* That `got` is a unit vector along `along`. */
static void assert_along(const double along[3], const float got[3])
{
	double length = sqrt(dot(along, along));
	const double unit[3] = {along[0] / length, along[1] / length, along[2] / length};
	assert_near(got, unit, 1.0);
}

static double volume(const stilb_mat4 *m)
{
	static const float axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	double c[3][3];
	for (int i = 0; i < 3; i++)
		turned(m, axes[i], c[i]);
	return c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) - c[1][0] * (c[0][1] * c[2][2] - c[0][2] * c[2][1]) +
	       c[2][0] * (c[0][1] * c[1][2] - c[0][2] * c[1][1]);
}

static void assert_rectangle(const stilb_mat4 *m, const stilb_scene_mount *mount, const stilb_scene_light *light)
{
	double x[3], y[3], ahead[3], across[3], normal[3];
	turned(m, mount->half_x, x);
	turned(m, mount->half_y, y);
	turned(m, mount->direction, ahead);
	for (int i = 0; i < 3; i++)
		across[i] = y[i] - x[i] * dot(x, y) / dot(x, x);
	for (int i = 0; i < 3; i++)
		normal[i] = x[(i + 1) % 3] * across[(i + 2) % 3] - x[(i + 2) % 3] * across[(i + 1) % 3];
	if (dot(normal, ahead) < 0.0)
		for (int i = 0; i < 3; i++)
			normal[i] = -normal[i];
	assert_near(light->half_x, x, 1.0 + sqrt(dot(x, x)));
	assert_near(light->half_y, across, 1.0 + sqrt(dot(y, y)));
	assert_along(normal, light->direction);
}

static void assert_light(const stilb_mat4 *m, const stilb_scene_mount *mount, const stilb_scene_light *light)
{
	double ahead[3];
	turned(m, mount->direction, ahead);
	assert_null(stilb_scene_light_mistake(light));
	if (light->kind != STILB_SCENE_LIGHT_DIRECTIONAL)
		assert_position(m, mount->position, light->position);
	if (light->kind == STILB_SCENE_LIGHT_RECTANGLE)
		assert_rectangle(m, mount, light);
	else if (light->kind != STILB_SCENE_LIGHT_POINT && light->kind != STILB_SCENE_LIGHT_SPHERE)
		assert_along(ahead, light->direction);
	if (light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK) {
		double radius = (double)mount->radius * cbrt(fabs(volume(m)));
		assert_true(fabs((double)light->radius - radius) <= 2e-5 * radius);
	}
}

/* That the picture of a camera looks along the mount's direction, and that `up` of the mount lies in the picture's
 * upper half, on the line through its middle. */
static void assert_camera(const stilb_mat4 *m, const stilb_scene_mount *mount, const stilb_scene_camera *camera)
{
	double ahead[3], up[3];
	turned(m, mount->direction, ahead);
	turned(m, mount->up, up);
	double yaw = (double)camera->yaw, pitch = (double)camera->pitch, roll = (double)camera->roll;
	const float view[3] = {(float)(-sin(yaw) * cos(pitch)), (float)sin(pitch), (float)(-cos(yaw) * cos(pitch))};
	const double right[3] = {cos(yaw), 0.0, -sin(yaw)};
	const double above[3] = {sin(yaw) * sin(pitch), cos(pitch), cos(yaw) * sin(pitch)};
	double x = dot(up, right), y = dot(up, above), length = sqrt(x * x + y * y);
	assert_position(m, mount->position, camera->position);
	assert_along(ahead, view);
	if (length > 0.1 * sqrt(dot(up, up))) { /* else the view is nearly along `up`, and the roll is of little worth */
		assert_true(fabs(x / length - sin(roll)) < 1e-3);
		assert_true(fabs(y / length - cos(roll)) < 1e-3);
	}
}

static void assert_mounts(const stilb_scene *scene)
{
	for (uint32_t i = 0; i < scene->light_count; i++)
		if (scene->light_mounts && scene->light_mounts[i].node)
			assert_light(&scene->nodes.to_world[scene->light_mounts[i].node - 1], &scene->light_mounts[i],
			             &scene->lights[i]);
	for (uint32_t c = 0; c < scene->camera_count; c++)
		if (scene->camera_mounts && scene->camera_mounts[c].node)
			assert_camera(&scene->nodes.to_world[scene->camera_mounts[c].node - 1], &scene->camera_mounts[c],
			              &scene->cameras[c].camera);
}

/* ---- random edits ------------------------------------------------------------------------------------------------ */

static stilb_result edit(stilb_scene *scene, uint32_t kind)
{
	uint32_t node = below(NODES), light = below(LIGHTS), camera = below(CAMERAS);
	stilb_scene_pose pose = random_pose();
	switch (kind) {
	case 0:
		return stilb_scene_set_node_pose(scene, node, &pose);
	case 1:
		return stilb_scene_set_node_parent(scene, node, below(3) ? below(NODES) : STILB_SCENE_NONE);
	case 2:
		scene->lights[light] = light_of((uint32_t)scene->lights[light].kind);
		return stilb_scene_attach_light(scene, light, below(3) ? node : STILB_SCENE_NONE);
	case 3:
		scene->cameras[camera].camera = camera_of(below(5));
		return stilb_scene_attach_camera(scene, camera, below(3) ? node : STILB_SCENE_NONE);
	default:
		scene->lights[light].intensity[1] += 1.0f; /* stays where nodes move */
		return STILB_OK;
	}
}

/* True if a node or one above it is in the set. */
static bool is_below(const stilb_scene *scene, uint32_t node, const bool set[NODES])
{
	for (; node != STILB_SCENE_NONE; node = scene->nodes.parent[node])
		if (set[node])
			return true;
	return false;
}

static void what_hangs_on_nodes_follows(void **state)
{
	(void)state;
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = {.worker_count = 2};
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	stilb_scene *scene = chain();
	uint32_t done[5] = {0}, refused[5] = {0};
	assert_mounts(scene);
	for (int step = 0; step < STEPS; step++) {
		uint32_t kind = below(5);
		stilb_result result = edit(scene, kind);
		done[kind] += result == STILB_OK;
		refused[kind] += result != STILB_OK;
		if (below(3) > 0)
			continue;
		stilb_scene_update_nodes(scene, below(2) ? pool : NULL, 0);
		assert_mounts(scene);
	}
	for (int kind = 0; kind < 5; kind++)
		assert_true(done[kind] > (uint32_t)STEPS / 20);
	assert_true(refused[1] > 0 && refused[0] + refused[2] + refused[3] == 0);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

/* What hangs on nodes that have not moved keeps what the program wrote, and readers see whether a light has moved. */
static void only_what_moved_is_written(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	for (uint32_t i = 0; i < LIGHTS; i++)
		assert_int_equal(stilb_scene_attach_light(scene, i, i % NODES), STILB_OK);
	for (uint32_t c = 0; c < CAMERAS; c++)
		assert_int_equal(stilb_scene_attach_camera(scene, c, 2 + c), STILB_OK);
	for (int round = 0; round < 60; round++) {
		bool moved[NODES] = {false};
		stilb_scene_light before[LIGHTS];
		uint64_t revision = stilb_scene_revisions_read(scene).lights;
		for (uint32_t i = 0; i < LIGHTS; i++)
			scene->lights[i].position[0] = before[i].position[0] = 77.0f;
		for (uint32_t c = 0; c < CAMERAS; c++)
			scene->cameras[c].camera.position[0] = 77.0f;
		memcpy(before, scene->lights, sizeof before);
		revision = stilb_scene_revisions_read(scene).lights;
		for (uint32_t n = 0; n < NODES && round > 0; n++) {
			stilb_scene_pose pose = random_pose();
			moved[n] = below(4) == 0;
			if (moved[n])
				assert_int_equal(stilb_scene_set_node_pose(scene, n, &pose), STILB_OK);
			if (moved[n] && round % 2)
				assert_int_equal(stilb_scene_set_node_parent(scene, n, n > 0 && below(2) ? below(n) : STILB_SCENE_NONE),
				                 STILB_OK);
		}
		uint64_t now = stilb_scene_revisions_read(scene).lights;
		assert_true((now != revision) == (memcmp(before, scene->lights, sizeof before) != 0));
		for (uint32_t i = 0; i < LIGHTS; i++) {
			if (!is_below(scene, i % NODES, moved))
				assert_memory_equal(&scene->lights[i], &before[i], sizeof before[i]);
			else
				assert_light(&scene->nodes.to_world[i % NODES], &scene->light_mounts[i], &scene->lights[i]);
		}
		for (uint32_t c = 0; c < CAMERAS; c++)
			if (is_below(scene, 2 + c, moved))
				assert_camera(&scene->nodes.to_world[2 + c], &scene->camera_mounts[c], &scene->cameras[c].camera);
			else
				assert_true(scene->cameras[c].camera.position[0] == 77.0f);
	}
	stilb_scene_destroy(scene);
}

/* ---- meaning ----------------------------------------------------------------------------------------------------- */

/* On a node that does nothing, everything stays where it was; a build and an attachment give the same bits. */
static void builds_and_attachments_mean_the_same(void **state)
{
	(void)state;
	stilb_scene *built = chain(), *attached = chain();
	stilb_scene_pose none = stilb_scene_pose_identity();
	uint32_t still;
	for (uint32_t n = 0; n < NODES; n++) {
		stilb_scene_pose pose = built->nodes.pose[n];
		assert_int_equal(stilb_scene_set_node_pose(attached, n, &pose), STILB_OK);
	}
	for (uint32_t i = 0; i < LIGHTS; i++) {
		stilb_scene_light light = built->lights[i];
		const stilb_scene_mount *mount = &built->light_mounts[i];
		memcpy(light.position, mount->position, sizeof light.position);
		memcpy(light.direction, mount->direction, sizeof light.direction);
		memcpy(light.half_x, mount->half_x, sizeof light.half_x);
		memcpy(light.half_y, mount->half_y, sizeof light.half_y);
		light.radius = mount->radius;
		attached->lights[i] = mount->node ? light : built->lights[i];
		assert_int_equal(stilb_scene_attach_light(attached, i, mount->node ? mount->node - 1 : STILB_SCENE_NONE),
		                 STILB_OK);
	}
	stilb_scene_update_nodes(attached, NULL, 0);
	for (uint32_t i = 0; i < LIGHTS; i++) {
		const stilb_scene_light *a = &attached->lights[i], *b = &built->lights[i];
		if (b->kind != STILB_SCENE_LIGHT_DIRECTIONAL)
			assert_memory_equal(a->position, b->position, sizeof a->position);
		if (b->kind != STILB_SCENE_LIGHT_POINT && b->kind != STILB_SCENE_LIGHT_SPHERE)
			assert_memory_equal(a->direction, b->direction, sizeof a->direction);
		if (b->kind == STILB_SCENE_LIGHT_RECTANGLE)
			assert_memory_equal(a->half_y, b->half_y, sizeof a->half_y);
	}
	assert_int_equal(stilb_scene_add_node(built, STILB_SCENE_NONE, &none, &still), STILB_OK);
	for (uint32_t c = 0; c < CAMERAS; c++) {
		stilb_scene_camera camera = camera_of(c);
		built->cameras[c].camera = camera;
		assert_int_equal(stilb_scene_attach_camera(built, c, still), STILB_OK);
		stilb_scene_update_nodes(built, NULL, 0);
		const stilb_scene_camera *now = &built->cameras[c].camera;
		assert_memory_equal(now->position, camera.position, sizeof camera.position);
		assert_true(fabsf(now->yaw - camera.yaw) < 1e-6f && fabsf(now->pitch - camera.pitch) < 1e-6f);
		assert_true(fabsf(now->roll - camera.roll) < 1e-6f && now->fov_y == camera.fov_y);
		assert_true(now->near_z == camera.near_z && now->far_z == camera.far_z);
	}
	stilb_scene_destroy(built);
	stilb_scene_destroy(attached);
}

/* A light that a node would make too small, or would put too far away, stays where it was. */
static void impossible_places_are_not_taken(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	stilb_scene_pose tiny = stilb_scene_pose_identity(), far = tiny;
	tiny.scale[0] = tiny.scale[1] = tiny.scale[2] = 1e-12f;
	far.scale[0] = far.scale[1] = far.scale[2] = 1e18f;
	const stilb_scene_pose *poses[2] = {&tiny, &far};
	for (int p = 0; p < 2; p++)
		for (uint32_t n = 0; n < 3; n++) {
			stilb_scene_light before[LIGHTS];
			memcpy(before, scene->lights, sizeof before);
			stilb_scene_camera camera = scene->cameras[0].camera;
			assert_int_equal(stilb_scene_set_node_pose(scene, n, poses[p]), STILB_OK);
			stilb_scene_update_nodes(scene, NULL, 0);
			for (uint32_t i = 0; i < LIGHTS; i++) {
				assert_null(stilb_scene_light_mistake(&scene->lights[i]));
				bool sized = scene->lights[i].kind >= STILB_SCENE_LIGHT_SPHERE;
				if (sized ? p == 0 || n > 0 : p == 1 && n > 0)
					assert_memory_equal(before[i].position, scene->lights[i].position, sizeof before[i].position);
			}
			if (p == 1 && n > 0)
				assert_memory_equal(&camera, &scene->cameras[0].camera, sizeof camera);
		}
	stilb_scene_destroy(scene);
}

#define REFUSED(call, words)                                                                                           \
	do {                                                                                                               \
		assert_int_equal(call, STILB_ERROR_ARGUMENT);                                                                  \
		assert_non_null(strstr(stilb_error_message(), words));                                                         \
	} while (0)

static void mistakes_are_told(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	REFUSED(stilb_scene_attach_light(scene, LIGHTS, 0), "there is no light 12");
	REFUSED(stilb_scene_attach_light(scene, 1, 9), "light 1: there is no node 9");
	REFUSED(stilb_scene_attach_camera(scene, 3, 0), "there is no camera 3");
	REFUSED(stilb_scene_attach_camera(scene, 1, 9), "camera 1: there is no node 9");
	REFUSED(stilb_scene_remove_node(scene, NODES - 1), "node 6 is in use by light 1; attach it elsewhere first");
	assert_int_equal(stilb_scene_set_lights(scene, scene->lights, 2), STILB_OK);
	assert_null(scene->light_mounts);
	REFUSED(stilb_scene_remove_node(scene, NODES - 1), "node 6 is in use by camera 0; attach it elsewhere first");
	assert_int_equal(stilb_scene_attach_camera(scene, 0, STILB_SCENE_NONE), STILB_OK);
	assert_int_equal(stilb_scene_attach_camera(scene, 2, STILB_SCENE_NONE), STILB_OK);
	assert_int_equal(stilb_scene_remove_node(scene, NODES - 1), STILB_OK);
	REFUSED(stilb_scene_attach_light(scene, 0, NODES - 1), "light 0: there is no node 6");
	assert_int_equal(stilb_scene_attach_light(scene, 0, 1), STILB_OK);
	assert_int_equal(stilb_scene_set_studio(scene, 0.0f), STILB_OK);
	assert_null(scene->light_mounts); /* whose lights hang on nothing */
	stilb_scene_destroy(scene);
}

static void refuse_build(stilb_scene_build *build, const char *words)
{
	stilb_scene *none;
	REFUSED(stilb_scene_build_end(build, &none), words);
}

static void mistakes_of_builds_are_told(void **state)
{
	(void)state;
	stilb_mat4 tiny = stilb_mat4_scale_translate(1e-12f, 0.0f, 0.0f, 0.0f);
	stilb_scene_light ball = light_of(STILB_SCENE_LIGHT_SPHERE);
	stilb_scene_camera camera = camera_of(0), wide = camera, out = camera;
	wide.fov_y = 4.0f;
	out.position[1] = 1e18f;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_light_on(build, 0, &ball);
	refuse_build(build, "light 0: there is no node 0");
	build = stilb_scene_build_begin();
	stilb_scene_build_light_on(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &tiny), &ball);
	refuse_build(build, "light 0: node 0 makes it too small or puts it too far away");
	build = stilb_scene_build_begin();
	ball.radius = 0.0f;
	stilb_scene_build_light_on(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &tiny), &ball);
	refuse_build(build, "light 0: its radius is not between");
	build = stilb_scene_build_begin();
	stilb_scene_build_named_camera(build, "wide", STILB_SCENE_NO_PARENT, &wide);
	refuse_build(build, "camera 0: the field of view 4 is not between 0 and pi");
	build = stilb_scene_build_begin();
	stilb_scene_build_named_camera(build, "", 2, &camera);
	refuse_build(build, "camera 0: there is no node 2");
	build = stilb_scene_build_begin();
	stilb_mat4 large = stilb_mat4_scale_translate(10.0f, 0.0f, 0.0f, 0.0f);
	stilb_scene_build_named_camera(build, "", stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &large), &out);
	refuse_build(build, "camera 0: node 0 puts it too far away");
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(what_hangs_on_nodes_follows),
		test_one_thread(only_what_moved_is_written),
		test_one_thread(builds_and_attachments_mean_the_same),
		test_one_thread(impossible_places_are_not_taken),
		test_one_thread(mistakes_are_told),
		test_one_thread(mistakes_of_builds_are_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
