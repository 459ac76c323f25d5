/* Many figures play on 0, 1, 2 and 5 workers: what is shown has the same bits. The scene is made here, so that the
 * thread sanitizer sees all of it. */
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_build.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define VERTICES (TEST_TSAN || TEST_EMULATED ? 900u : 3000u)
#define FIGURES (TEST_TSAN || TEST_EMULATED ? 40u : 150u)
#define FRAMES (TEST_TSAN ? 4 : 8)
#define JOINTS 3u
#define KEYS 4u

static uint64_t random_index;

static float between(float low, float high)
{
	return low + (high - low) * stilb_random_float(5, random_index++);
}

/* Nodes 0, 1, 2, a chain; 1 shows a mesh that all of them carry, with one morph target. A clip turns and moves all. */
static void add_animation(stilb_scene *scene)
{
	static const stilb_scene_animation counts = {.node_count = JOINTS,
	                                             .clip_count = 1,
	                                             .channel_count = 2 * JOINTS + 1,
	                                             .skin_count = 1,
	                                             .joint_count = JOINTS,
	                                             .deform_count = 1,
	                                             .time_count = KEYS,
	                                             .value_count = JOINTS * KEYS * 7 + KEYS,
	                                             .weight_count = 1};
	assert_int_equal(scene_animation_create(&counts, &scene->animation), STILB_OK);
	stilb_scene_animation *a = scene->animation;
	for (uint32_t k = 0; k < KEYS; k++)
		a->times[k] = 0.5f * (float)k;
	uint32_t value = 0;
	for (uint32_t n = 0; n < JOINTS; n++) {
		a->nodes[n] = (stilb_scene_rest){.parent = n ? n - 1 : STILB_SCENE_NONE,
		                                 .local = stilb_mat4_identity(),
		                                 .rotation = {0, 0, 0, 1},
		                                 .scale = {1, 1, 1},
		                                 .moves = true,
		                                 .model_count = n == 1,
		                                 .skin = n == 1 ? 0 : STILB_SCENE_NONE,
		                                 .weight_count = n == 1};
		a->joints[n] = n;
		a->inverse_binds[n] = stilb_mat4_identity();
		for (uint32_t path = 0; path < 2; path++) {
			a->channels[2 * n + path] = (stilb_scene_channel){.node = n,
			                                                  .path = (stilb_scene_path)path,
			                                                  .interpolation = STILB_SCENE_LINEAR,
			                                                  .key_count = KEYS,
			                                                  .width = 3 + path,
			                                                  .first_value = value};
			for (uint32_t k = 0; k < KEYS; k++) {
				float *q = a->values + value, square = 0.0f;
				for (uint32_t i = 0; i < 3 + path; i++) {
					q[i] = between(-1, 1);
					square += q[i] * q[i];
				}
				for (uint32_t i = 0; path == 1 && i < 4; i++)
					q[i] /= sqrtf(square);
				value += 3 + path;
			}
		}
	}
	a->channels[2 * JOINTS] = (stilb_scene_channel){.node = 1,
	                                                .path = STILB_SCENE_PATH_WEIGHTS,
	                                                .interpolation = STILB_SCENE_LINEAR,
	                                                .key_count = KEYS,
	                                                .width = 1,
	                                                .first_value = value};
	for (uint32_t k = 0; k < KEYS; k++)
		a->values[value++] = between(0, 1);
	a->clips[0] = (stilb_scene_clip){.name = "turn", .duration = 0.5f * (KEYS - 1), .channel_count = 2 * JOINTS + 1};
	a->skins[0] = (stilb_scene_skin){.joint_count = JOINTS};
	a->deforms[0] = (stilb_scene_deform){.influences = 4, .targets = 1};
	assert_int_equal(scene_deform_create(a->deforms, VERTICES, true, false), STILB_OK);
	for (uint32_t v = 0; v < VERTICES; v++)
		for (uint32_t i = 0; i < 3; i++) {
			a->deforms[0].joints[4 * v + i] = (uint16_t)i;
			a->deforms[0].weights[4 * v + i] = between(0.1f, 1);
			a->deforms[0].positions[3 * v + i] = between(-0.2f, 0.2f);
			a->deforms[0].normals[3 * v + i] = between(-0.2f, 0.2f);
		}
}

static stilb_scene *make(void)
{
	static stilb_scene_vertex vertices[3000];
	static uint32_t indices[3000];
	stilb_scene *scene;
	random_index = 0;
	for (uint32_t v = 0; v < VERTICES; v++) {
		vertices[v] = (stilb_scene_vertex){{between(-1, 1), between(-1, 1), between(-1, 1)}, {0, 0, 1}, {0, 0}};
		indices[v] = v;
	}
	stilb_scene_mesh mesh = {
		.vertices = vertices, .indices = indices, .vertex_count = VERTICES, .index_count = VERTICES / 3 * 3};
	stilb_scene_material paint = {.roughness = 0.5f};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &paint)};
	stilb_scene_pose pose = stilb_scene_pose_identity();
	uint32_t nodes[JOINTS];
	for (uint32_t n = 0; n < JOINTS; n++)
		nodes[n] = stilb_scene_build_pose(build, n ? nodes[n - 1] : STILB_SCENE_NO_PARENT, &pose);
	stilb_scene_build_model(build, nodes[1], &part, 1);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	add_animation(scene);
	assert_true(scene_animation_is_sound(scene));
	assert_int_equal(scene_play_begin(scene), STILB_OK);
	assert_non_null(scene->figures);
	for (uint32_t f = 0; f < FIGURES; f++) {
		uint32_t figure = 0;
		pose.translation[0] = 3.0f * (float)f;
		if (f > 0)
			assert_int_equal(stilb_scene_add_figure(scene, &pose, &figure), STILB_OK);
		stilb_scene_play play = stilb_scene_play_make(0);
		play.time = 0.013 * f;
		assert_int_equal(stilb_scene_set_plays(scene, figure, &play, 1), STILB_OK);
	}
	return scene;
}

static uint64_t hash_shown(const stilb_scene *scene)
{
	uint64_t hash = STILB_FNV1A64_START;
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		hash = stilb_hash_fnv1a64(hash, scene->meshes[m].vertices,
		                          scene->meshes[m].vertex_count * sizeof *scene->meshes[m].vertices);
	hash = stilb_hash_fnv1a64(hash, scene->nodes.to_world, scene->nodes.count * sizeof *scene->nodes.to_world);
	return stilb_hash_fnv1a64(hash, scene->bounds.radius, scene->model_count * sizeof *scene->bounds.radius);
}

static void workers_show_the_same_bits(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 5};
	uint64_t wanted[FRAMES];
	for (size_t w = 0; w < sizeof workers / sizeof *workers; w++) {
		stilb_job_pool *pool = NULL;
		stilb_job_pool_desc desc = {.worker_count = workers[w]};
		if (workers[w] > 0)
			assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
		stilb_scene *scene = make();
		for (int frame = 0; frame < FRAMES; frame++) {
			stilb_scene_advance(scene, 0.03, pool, 0);
			stilb_scene_update_nodes(scene, pool, 0);
			uint64_t hash = hash_shown(scene);
			if (w == 0)
				wanted[frame] = hash;
			assert_true(hash == wanted[frame] && (frame == 0 || hash != wanted[frame - 1]));
		}
		stilb_scene_destroy(scene);
		if (pool)
			stilb_job_pool_destroy(pool);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(workers_show_the_same_bits)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
