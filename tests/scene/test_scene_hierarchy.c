/* Nodes that move, hang and go: places are the products of the matrices from the root, bit for bit, for any number of
 * workers; models and bounds follow; only changed subtrees are touched; each mistake is told in words. */
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define STEPS (TEST_TSAN ? 300 : TEST_ASAN || TEST_EMULATED ? 1500 : 4000)
#define MOST_NODES 60
#define MANY (TEST_TSAN || TEST_ASAN || TEST_EMULATED ? 9000u : 20000u) /* more than the pool is asked for */

static uint64_t random_index;

static uint32_t below(uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(22, random_index++) % bound);
}

static float between(float low, float high)
{
	return low + (high - low) * stilb_random_float(22, random_index++);
}

static stilb_scene_pose random_pose(void)
{
	stilb_scene_pose pose = {.translation = {between(-2, 2), between(-2, 2), between(-2, 2)},
	                         .rotation = {between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)},
	                         .scale = {between(-1.5f, 1.5f), between(0.2f, 1.5f), 1.0f}};
	float *q = pose.rotation, length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	for (int i = 0; i < 4; i++)
		q[i] = length > 0.1f ? q[i] / length : (float)(i == 3);
	return pose;
}

/* A triangle whose vertices are not about its origin. */
static stilb_scene_mesh triangle(float x)
{
	static stilb_scene_vertex vertices[3];
	static uint32_t indices[3] = {0, 1, 2};
	for (int i = 0; i < 3; i++)
		vertices[i] = (stilb_scene_vertex){{x + (float)i, (float)(i % 2), 0.5f}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f}};
	return (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 3};
}

/* Models 0..3 on nodes 0..3, a chain: node n hangs on node n - 1. */
static stilb_scene *chain(void)
{
	static const char *const names[4] = {"hip", "knee", "foot", "foot"};
	stilb_scene *scene;
	stilb_scene_mesh mesh = triangle(1.0f);
	stilb_scene_material paint = {.roughness = 0.5f};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part parts[2] = {
		{stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &paint)}};
	parts[1] = parts[0];
	for (uint32_t n = 0; n < 4; n++) {
		stilb_scene_pose pose = random_pose();
		stilb_mat4 matrix = stilb_scene_pose_matrix(&pose);
		uint32_t parent = n > 0 ? n - 1 : STILB_SCENE_NO_PARENT;
		uint32_t node =
			n % 2 ? stilb_scene_build_pose(build, parent, &pose) : stilb_scene_build_node(build, parent, &matrix);
		assert_int_equal(node, n);
		stilb_scene_build_name(build, node, names[n]);
		assert_int_equal(stilb_scene_build_model(build, node, parts, 1 + n % 2), n);
	}
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	return scene;
}

/* ---- truth ------------------------------------------------------------------------------------------------------- */

static bool lives(const stilb_scene *scene, uint32_t node)
{
	return scene->nodes.parent[node] != node;
}

/* The place of a node by the definition, from the root down. */
static stilb_mat4 place_of(const stilb_scene *scene, uint32_t node)
{
	uint32_t parent = scene->nodes.parent[node];
	if (parent == STILB_SCENE_NONE)
		return scene->nodes.local[node];
	return stilb_mat4_multiply(place_of(scene, parent), scene->nodes.local[node]);
}

static void assert_model(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *b = &scene->bounds;
	uint32_t node = scene->model_node[model];
	stilb_mat4 place = node ? place_of(scene, node - 1) : scene->part_transform[scene->first_part[model]];
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		if (node)
			assert_memory_equal(&scene->part_transform[p], &place, sizeof place);
		for (uint32_t v = 0; v < mesh->vertex_count && !isnan(b->radius[model]); v++) {
			const float *m = scene->part_transform[p].m, *at = mesh->vertices[v].position;
			float d[3];
			for (int row = 0; row < 3; row++)
				d[row] = m[row] * at[0] + m[4 + row] * at[1] + m[8 + row] * at[2] + m[12 + row];
			float x = d[0] - b->x[model], y = d[1] - b->y[model], z = d[2] - b->z[model];
			assert_true(sqrtf(x * x + y * y + z * z) <= b->radius[model]);
		}
	}
}

/* What a reader of the list of moved models would know of the bounds. */
static float known[4][64];

static void assert_scene(stilb_scene *scene, bool begin)
{
	float *bounds[4] = {scene->bounds.x, scene->bounds.y, scene->bounds.z, scene->bounds.radius};
	for (uint32_t n = 0; n < scene->nodes.count; n++) {
		if (!lives(scene, n))
			continue;
		stilb_mat4 place = place_of(scene, n);
		assert_memory_equal(&scene->nodes.to_world[n], &place, sizeof place);
	}
	assert_true(scene->model_count <= 64);
	for (uint32_t i = 0; i < scene->moved_count; i++)
		for (uint32_t j = 0; j < i; j++)
			assert_int_not_equal(scene->moved[i], scene->moved[j]);
	for (uint32_t i = 0; i < (begin ? scene->model_count : scene->moved_count); i++)
		for (int k = 0; k < 4; k++)
			known[k][begin ? i : scene->moved[i]] = bounds[k][begin ? i : scene->moved[i]];
	for (uint32_t m = 0; m < scene->model_count; m++) {
		assert_int_equal(isnan(known[3][m]), isnan(bounds[3][m]));
		for (int k = 0; k < 4 && !isnan(bounds[3][m]); k++)
			assert_true(known[k][m] == bounds[k][m]);
		if (scene->part_mesh[scene->first_part[m]] != STILB_SCENE_NONE)
			assert_model(scene, m);
	}
}

/* ---- random edits ------------------------------------------------------------------------------------------------ */

static stilb_result edit_node(stilb_scene *scene, uint32_t kind)
{
	uint32_t node = below(scene->nodes.count + 1), other = below(scene->nodes.count + 1), living = 0;
	stilb_scene_pose pose = random_pose();
	stilb_mat4 matrix = stilb_scene_pose_matrix(&pose);
	other = other == scene->nodes.count && below(2) ? STILB_SCENE_NONE : other;
	for (uint32_t n = 0; n < scene->nodes.count; n++)
		living += lives(scene, n);
	matrix.m[4] += 0.25f; /* sheared */
	switch (kind) {
	case 0:
		return living < MOST_NODES ? stilb_scene_add_node(scene, other, &pose, &node) : STILB_OK;
	case 1:
		return stilb_scene_remove_node(scene, node);
	case 2:
		return stilb_scene_set_node_pose(scene, node, &pose);
	case 3:
		return stilb_scene_set_node_matrix(scene, node, &matrix);
	default:
		return stilb_scene_set_node_parent(scene, node, other);
	}
}

static stilb_result edit_model(stilb_scene *scene, uint32_t kind)
{
	uint32_t model = below(scene->model_count + 1), node = below(scene->nodes.count + 1), living = 0;
	stilb_scene_pose pose = random_pose();
	stilb_mat4 matrix = stilb_scene_pose_matrix(&pose);
	stilb_scene_build_part parts[2] = {{0, 0}, {0, 0}};
	stilb_scene_mesh mesh = triangle(between(-3, 3));
	for (uint32_t m = 0; m < scene->model_count; m++)
		living += scene->part_mesh[scene->first_part[m]] != STILB_SCENE_NONE;
	switch (kind) {
	case 0:
		return stilb_scene_attach_model(scene, model, node == scene->nodes.count ? STILB_SCENE_NONE : node);
	case 1:
		return stilb_scene_set_transform(scene, model, &matrix);
	case 2:
		return stilb_scene_show_model(scene, model, below(2));
	case 3:
		return living < 20 ? stilb_scene_add_model(scene, &matrix, parts, 1 + below(2), &model) : STILB_OK;
	case 4:
		return below(4) == 0 ? stilb_scene_remove_model(scene, model) : STILB_OK;
	default:
		return below(8) == 0 ? stilb_scene_set_mesh(scene, 0, &mesh) : STILB_OK;
	}
}

static void places_are_products_from_the_root(void **state)
{
	(void)state;
	uint32_t done[11] = {0}, refused[11] = {0};
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = {.worker_count = 2};
	stilb_scene *scene = chain();
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	assert_scene(scene, true);
	for (int step = 0; step < STEPS; step++) {
		uint32_t kind = below(11);
		stilb_result result = kind < 5 ? edit_node(scene, kind) : edit_model(scene, kind - 5);
		assert_true(result == STILB_OK || result == STILB_ERROR_ARGUMENT);
		done[kind] += result == STILB_OK;
		refused[kind] += result != STILB_OK;
		if (below(4) > 0)
			continue;
		stilb_scene_revisions before = scene->revisions;
		if (below(2))
			stilb_scene_update_nodes(scene, below(2) ? pool : NULL, 0);
		stilb_scene_changes_read(scene); /* updates what is left, and the bounds of changed meshes */
		assert_scene(scene, false);
		stilb_scene_changes_clear(scene);
		stilb_scene_changes_read(scene);
		assert_int_equal(scene->moved_count, 0); /* no node is placed twice */
		assert_true(scene->revisions.places - before.places <= 1);
	}
	for (int kind = 0; kind < 11; kind++)
		assert_true(done[kind] > (uint32_t)STEPS / 100);
	assert_true(refused[1] > 0 && refused[4] > 0 && refused[5] > 0);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

/* ---- many nodes -------------------------------------------------------------------------------------------------- */

/* The parent of node n of MANY, for a chain, a star, a comb (a chain with a tooth at each link), a random tree, and one
 * whose ids stand in no order. */
static uint32_t shape_parent(int shape, uint32_t n)
{
	if (n == 0)
		return STILB_SCENE_NONE;
	switch (shape) {
	case 0:
		return n - 1;
	case 1:
		return 0;
	case 2:
		return n % 2 ? n - 1 : n - 2;
	default:
		return below(n < 400 ? n : 400); /* 400 nodes of many children */
	}
}

static stilb_scene *many_nodes(int shape)
{
	random_index = 77; /* the same nodes in each call */
	stilb_scene *scene = chain();
	stilb_scene_build_part part = {0, 0};
	stilb_mat4 place = stilb_mat4_identity();
	uint32_t first = scene->nodes.count, node, model;
	for (uint32_t n = 0; n < MANY; n++) {
		uint32_t parent = shape_parent(shape, n);
		stilb_scene_pose pose = stilb_scene_pose_identity();
		pose.translation[n % 3] = 0.01f;
		assert_int_equal(
			stilb_scene_add_node(scene, parent == STILB_SCENE_NONE ? parent : first + parent, &pose, &node), STILB_OK);
		assert_int_equal(node, first + n);
		if (n % 16)
			continue;
		assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &model), STILB_OK);
		assert_int_equal(stilb_scene_attach_model(scene, model, node), STILB_OK);
	}
	for (uint32_t n = 1; n < MANY / 2 && shape == 4; n++) /* parents with higher ids, and trees that change places */
		stilb_scene_set_node_parent(scene, first + n, first + MANY / 2 + below(MANY / 2));
	return scene;
}

static uint64_t hash_scene(const stilb_scene *scene)
{
	uint64_t hash = STILB_FNV1A64_START;
	const float *arrays[4] = {scene->bounds.x, scene->bounds.y, scene->bounds.z, scene->bounds.radius};
	for (int i = 0; i < 4; i++)
		hash = stilb_hash_fnv1a64(hash, arrays[i], scene->model_count * sizeof **arrays);
	hash = stilb_hash_fnv1a64(hash, scene->nodes.to_world, scene->nodes.count * sizeof *scene->nodes.to_world);
	hash = stilb_hash_fnv1a64(hash, scene->moved, scene->moved_count * sizeof *scene->moved);
	return stilb_hash_fnv1a64(hash, scene->part_transform, scene->part_count * sizeof *scene->part_transform);
}

/* Moves a part of the nodes; which: 0: the root of all, 1: one in ten, 2: a few, 3: all. */
static void move_nodes(stilb_scene *scene, int which)
{
	uint32_t first = 4, step = which == 1 ? 10 : which == 2 ? MANY / 3 : 1;
	for (uint32_t n = first + (which == 2); n < scene->nodes.count; n += step) {
		stilb_scene_pose pose = scene->nodes.pose[n];
		pose.translation[1] += 0.125f;
		assert_int_equal(stilb_scene_set_node_pose(scene, n, &pose), STILB_OK);
		if (which == 0)
			break;
	}
}

static void workers_change_no_bit(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	for (int shape = 0; shape < 5; shape += TEST_TSAN ? 2 : 1) {
		uint64_t expected[4];
		for (int w = -1; w < (TEST_TSAN ? 3 : 5); w++) {
			stilb_job_pool *pool = NULL;
			stilb_job_pool_desc desc = {.worker_count = w < 0 ? 0 : workers[w]};
			stilb_scene *scene = many_nodes(shape);
			if (w >= 0)
				assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
			for (int which = 0; which < 4; which++) {
				move_nodes(scene, which);
				stilb_scene_update_nodes(scene, pool, 0);
				if (w < 0)
					expected[which] = hash_scene(scene);
				assert_true(hash_scene(scene) == expected[which]);
				stilb_scene_changes_clear(scene);
			}
			for (uint32_t n = 0; n < scene->nodes.count && w < 0; n++) { /* each is right if its parent is */
				uint32_t parent = scene->nodes.parent[n];
				stilb_mat4 place = scene->nodes.local[n];
				if (parent != STILB_SCENE_NONE)
					place = stilb_mat4_multiply(scene->nodes.to_world[parent], place);
				assert_memory_equal(&scene->nodes.to_world[n], &place, sizeof place);
			}
			stilb_scene_destroy(scene);
			if (pool)
				stilb_job_pool_destroy(pool);
		}
	}
}

/* What has not changed is not written, and not listed. */
static void only_changed_subtrees_are_touched(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	stilb_scene_pose pose = random_pose();
	uint32_t beside;
	assert_int_equal(stilb_scene_add_node(scene, 0, &pose, &beside), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	stilb_scene_changes_clear(scene);
	for (uint32_t n = 0; n < 5; n++)
		scene->nodes.to_world[n].m[15] = 7.0f; /* no place has this */
	scene->nodes.to_world[1].m[15] = 1.0f;
	assert_int_equal(stilb_scene_set_node_pose(scene, 2, &pose), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	assert_true(scene->nodes.to_world[0].m[15] == 7.0f && scene->nodes.to_world[beside].m[15] == 7.0f);
	assert_true(scene->nodes.to_world[2].m[15] == 1.0f && scene->nodes.to_world[3].m[15] == 1.0f);
	assert_int_equal(scene->moved_count, 2);
	uint32_t roots[5];
	for (int r = 0; r < 5; r++)
		assert_int_equal(stilb_scene_add_node(scene, STILB_SCENE_NONE, &pose, &roots[r]), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	assert_int_equal(stilb_scene_set_node_pose(scene, roots[2], &pose), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	scene->nodes.to_world[roots[2]].m[15] = 7.0f;
	assert_int_equal(stilb_scene_set_node_pose(scene, roots[1], &pose), STILB_OK);
	assert_int_equal(stilb_scene_set_node_pose(scene, roots[4], &pose), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
	assert_true(scene->nodes.to_world[roots[2]].m[15] == 7.0f); /* which changed last time, between those of now */
	stilb_scene_destroy(scene);
}

/* Nodes that are added one by one move with those above them, wherever they stand. */
static void new_nodes_hang_on_their_parents(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	stilb_scene_pose pose = random_pose();
	uint32_t deep, deeper, root, late;
	stilb_scene_changes_read(scene);
	for (int again = 0; again < 3; again++) {
		assert_int_equal(stilb_scene_add_node(scene, 3, &pose, &deep), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		assert_int_equal(stilb_scene_add_node(scene, deep, &pose, &deeper), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		assert_int_equal(stilb_scene_set_node_pose(scene, 0, &pose), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		assert_scene(scene, true);
		assert_int_equal(stilb_scene_add_node(scene, STILB_SCENE_NONE, &pose, &root), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		assert_int_equal(stilb_scene_add_node(scene, 1, &pose, &late), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		pose = random_pose();
		assert_int_equal(stilb_scene_set_node_pose(scene, 0, &pose), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		assert_scene(scene, true);
	}
	stilb_scene_destroy(scene);
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

static void far_models_are_not_shown(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	stilb_scene_pose far = stilb_scene_pose_identity(), near = far;
	far.scale[0] = far.scale[1] = far.scale[2] = 1e18f;
	stilb_mat4 before = scene->part_transform[scene->first_part[2]];
	assert_int_equal(stilb_scene_set_node_pose(scene, 0, &far), STILB_OK);
	assert_int_equal(stilb_scene_set_node_pose(scene, 1, &far), STILB_OK);
	assert_int_equal(stilb_scene_set_node_pose(scene, 2, &far), STILB_OK); /* 1e54: infinite */
	stilb_scene_changes_read(scene);
	for (uint32_t m = 0; m < 4; m++)
		assert_true(isnan(scene->bounds.radius[m]));
	assert_int_equal(scene->moved_count, 4);
	assert_memory_equal(&scene->part_transform[scene->first_part[2]], &before, sizeof before); /* nothing reads NaN */
	assert_int_equal(stilb_scene_show_model(scene, 1, false), STILB_OK);
	assert_int_equal(stilb_scene_show_model(scene, 2, true), STILB_OK);
	assert_true(isnan(scene->bounds.radius[2]));
	assert_int_equal(stilb_scene_attach_model(scene, 3, STILB_SCENE_NONE), STILB_OK);
	assert_true(scene->bounds.radius[3] > 0.0f); /* where it was last */
	stilb_scene_changes_clear(scene);
	for (uint32_t n = 0; n < 3; n++)
		assert_int_equal(stilb_scene_set_node_pose(scene, n, &near), STILB_OK);
	stilb_scene_changes_read(scene);
	assert_true(scene->bounds.radius[0] > 0.0f && isnan(scene->bounds.radius[1]) && scene->bounds.radius[2] > 0.0f);
	assert_int_equal(scene->moved_count, 2);
	assert_int_equal(stilb_scene_show_model(scene, 1, true), STILB_OK);
	assert_true(scene->bounds.radius[1] > 0.0f);
	stilb_scene_destroy(scene);
}

static void poses_are_found_again(void **state)
{
	(void)state;
	for (int i = 0; i < 2000; i++) {
		stilb_scene_pose pose = random_pose();
		if (i % 5 == 0)
			pose.rotation[i % 4] = pose.rotation[(i + 1) % 4] = 0.0f;
		float *q = pose.rotation, length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
		for (int k = 0; k < 4; k++)
			q[k] = length > 0.01f ? q[k] / length : (float)(k == i % 4);
		if (i % 7 == 0)
			pose.scale[i % 3] = 0.0f;
		stilb_mat4 matrix = stilb_scene_pose_matrix(&pose);
		stilb_scene_pose found = stilb_scene_pose_of(&matrix);
		stilb_mat4 again = stilb_scene_pose_matrix(&found);
		for (int k = 0; k < 16; k++)
			if (!(fabsf(matrix.m[k] - again.m[k]) < 1e-5f))
				fail_msg("pose %d: element %d is %g instead of %g", i, k, (double)again.m[k], (double)matrix.m[k]);
		stilb_vec3 square = {found.rotation[0], found.rotation[1], found.rotation[2]};
		float unit = stilb_vec3_dot(square, square) + found.rotation[3] * found.rotation[3];
		assert_true(fabsf(unit - 1.0f) < 1e-5f);
	}
}

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

#define REFUSED(call, words)                                                                                           \
	do {                                                                                                               \
		assert_int_equal(call, STILB_ERROR_ARGUMENT);                                                                  \
		assert_non_null(strstr(stilb_error_message(), words));                                                         \
	} while (0)

static void mistakes_are_told(void **state)
{
	(void)state;
	stilb_scene *scene = chain();
	stilb_scene_pose pose = random_pose(), long_rotation = pose, endless = pose;
	stilb_mat4 bent = stilb_mat4_identity();
	uint32_t id;
	long_rotation.rotation[0] = 3.0f;
	endless.translation[2] = (float)NAN;
	bent.m[7] = 1.0f;
	REFUSED(stilb_scene_add_node(scene, 4, &pose, &id), "node 4: there is no node 4");
	REFUSED(stilb_scene_add_node(scene, 0, &endless, &id), "node 4: its translation or scale is not within 1e18");
	REFUSED(stilb_scene_set_node_pose(scene, 1, &long_rotation), "node 1: its rotation 3, ");
	REFUSED(stilb_scene_set_node_matrix(scene, 1, &bent), "node 1: its matrix is not affine");
	REFUSED(stilb_scene_set_node_parent(scene, 1, 3), "node 1: node 3 hangs on it");
	REFUSED(stilb_scene_set_node_parent(scene, 1, 1), "node 1: node 1 hangs on it");
	REFUSED(stilb_scene_set_node_parent(scene, 9, 1), "there is no node 9");
	REFUSED(stilb_scene_remove_node(scene, 1), "node 1 is in use by 1 node; remove these first");
	REFUSED(stilb_scene_remove_node(scene, 3), "node 3 is in use by model 3; attach it elsewhere first");
	REFUSED(stilb_scene_attach_model(scene, 0, 4), "model 0: there is no node 4");
	REFUSED(stilb_scene_attach_model(scene, 4, 0), "there is no model 4");
	assert_int_equal(scene->nodes.count, 4);
	assert_int_equal(stilb_scene_find_node(scene, "foot"), 2);
	assert_int_equal(stilb_scene_find_node(scene, "hand"), STILB_SCENE_NONE);
	assert_int_equal(stilb_scene_remove_model(scene, 3), STILB_OK);
	assert_int_equal(stilb_scene_remove_node(scene, 3), STILB_OK);
	REFUSED(stilb_scene_set_node_name(scene, 3, "hand"), "there is no node 3");
	assert_int_equal(stilb_scene_find_node(scene, ""), STILB_SCENE_NONE);
	assert_int_equal(stilb_scene_add_node(scene, 1, &pose, &id), STILB_OK);
	assert_int_equal(id, 3); /* the id is free again, the name is not */
	assert_int_equal(stilb_scene_find_node(scene, ""), 3);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_pose(build, STILB_SCENE_NO_PARENT, &long_rotation);
	stilb_scene *none;
	REFUSED(stilb_scene_build_end(build, &none), "node 0: its rotation");
	build = stilb_scene_build_begin();
	stilb_scene_build_name(build, 0, "hand");
	REFUSED(stilb_scene_build_end(build, &none), "the name 'hand': there is no node 0");
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(places_are_products_from_the_root),
		cmocka_unit_test(workers_change_no_bit),
		test_one_thread(new_nodes_hang_on_their_parents),
		test_one_thread(only_changed_subtrees_are_touched),
		test_one_thread(far_models_are_not_shown),
		test_one_thread(poses_are_found_again),
		test_one_thread(mistakes_are_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
