/* The program of the suite `animate`: makes a scene of figures by hand, and times the stages of a frame in which all of
 * them move. The poses of one thread and of two must have the same bits. */
#include "bench/animate/animate_cases.h"
#include "bench/harness/bench_child.h"
#include "jobs/job.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define KEYS 61u
#define CLIP_SECONDS 2.0f
#define CHANNELS 3u /* of a joint */

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

/* A chain of joints, the first of which stands on node 0, which shows the mesh. */
static void make_joints(stilb_scene *scene, uint32_t joints)
{
	stilb_scene_animation *a = scene->animation;
	check(scene_add_nodes(scene, joints + 1));
	for (uint32_t n = 0; n <= joints; n++) {
		stilb_scene_pose pose = stilb_scene_pose_identity();
		pose.translation[1] = n > 1 ? 0.1f : 0.0f;
		stilb_scene_rest *rest = &a->nodes[n];
		*rest = (stilb_scene_rest){.parent = n < 2 ? STILB_SCENE_NONE : n - 1,
		                           .local = stilb_scene_pose_matrix(&pose),
		                           .translation = {0, pose.translation[1], 0},
		                           .rotation = {0, 0, 0, 1},
		                           .scale = {1, 1, 1},
		                           .moves = true,
		                           .model_count = n == 0,
		                           .skin = n == 0 ? 0 : STILB_SCENE_NONE};
		scene->nodes.parent[n] = rest->parent;
		scene->nodes.pose[n] = pose;
		scene->nodes.local[n] = rest->local;
		scene->nodes.to_world[n] = stilb_mat4_scale_translate(1.0f, 0.0f, n > 1 ? 0.1f * (float)(n - 1) : 0.0f, 0.0f);
		if (n == 0)
			continue;
		a->joints[n - 1] = n;
		a->inverse_binds[n - 1] = stilb_mat4_scale_translate(1.0f, 0.0f, -0.1f * (float)(n - 1), 0.0f);
	}
	a->skins[0] = (stilb_scene_skin){"skin", 0, joints};
	scene->model_node[0] = 1;
}

/* Each joint turns to and fro, and moves and grows a little. */
static void make_clip(stilb_scene_animation *a, uint32_t joints)
{
	static const uint32_t widths[CHANNELS] = {3, 4, 3};
	uint32_t value = 0;
	for (uint32_t k = 0; k < KEYS; k++)
		a->times[k] = CLIP_SECONDS * (float)k / (float)(KEYS - 1);
	for (uint32_t c = 0; c < joints * CHANNELS; c++) {
		uint32_t path = c % CHANNELS;
		a->channels[c] = (stilb_scene_channel){.node = 1 + c / CHANNELS,
		                                       .path = (stilb_scene_path)path,
		                                       .interpolation = STILB_SCENE_LINEAR,
		                                       .key_count = KEYS,
		                                       .width = widths[path],
		                                       .first_value = value};
		for (uint32_t k = 0; k < KEYS; k++) {
			float angle = 0.4f * sinf(6.2831853f * (float)k / (float)(KEYS - 1) + (float)c);
			float *at = a->values + value;
			if (path == STILB_SCENE_PATH_ROTATION)
				memcpy(at, (float[4]){sinf(angle), 0.0f, 0.0f, cosf(angle)}, 4 * sizeof(float));
			else if (path == STILB_SCENE_PATH_TRANSLATION)
				memcpy(at, (float[3]){0.0f, 0.1f + 0.01f * angle, 0.0f}, 3 * sizeof(float));
			else
				memcpy(at, (float[3]){1.0f + 0.01f * angle, 1.0f, 1.0f}, 3 * sizeof(float));
			value += widths[path];
		}
	}
	a->clips[0] = (stilb_scene_clip){"sway", CLIP_SECONDS, 0, joints * CHANNELS};
}

/* A tube along the joints; without vertices a triangle. */
static void make_mesh(stilb_scene *scene, uint32_t joints, uint32_t vertices)
{
	stilb_scene_deform *deform = &scene->animation->deforms[0];
	stilb_scene_mesh *mesh = &scene->meshes[0];
	uint32_t count = vertices > 3 ? vertices : 3;
	check(scene_mesh_create(mesh, count, 3 * (count - 2)));
	*deform = (stilb_scene_deform){.mesh = 0, .influences = 4};
	check(scene_deform_create(deform, count, false, false));
	for (uint32_t v = 0; v < count; v++) {
		float along = (float)v / (float)count * (float)(joints - 1), angle = 0.7f * (float)v;
		mesh->vertices[v] = (stilb_scene_vertex){
			{0.1f * cosf(angle), 0.1f * along, 0.1f * sinf(angle)}, {cosf(angle), 0.0f, sinf(angle)}, {0.0f, 0.0f}};
		for (uint32_t i = 0; i < 4; i++) {
			uint32_t joint = (uint32_t)along + i;
			deform->joints[4 * v + i] = (uint16_t)(joint < joints ? joint : joints - 1);
			deform->weights[4 * v + i] = 0.4f - 0.1f * (float)i;
		}
	}
	for (uint32_t i = 0; i < mesh->index_count; i++)
		mesh->indices[i] = i / 3 + i % 3;
}

static stilb_scene *make_scene(uint32_t figures, uint32_t joints, uint32_t vertices)
{
	stilb_scene *scene;
	check(scene_create(1, 1, 1, 1, &scene));
	stilb_scene_animation counts = {.node_count = joints + 1,
	                                .clip_count = 1,
	                                .channel_count = joints * CHANNELS,
	                                .skin_count = 1,
	                                .joint_count = joints,
	                                .deform_count = 1,
	                                .time_count = KEYS,
	                                .value_count = joints * KEYS * 10};
	check(scene_animation_create(&counts, &scene->animation));
	make_joints(scene, joints);
	make_clip(scene->animation, joints);
	make_mesh(scene, joints, vertices);
	scene->first_part[1] = 1;
	scene->part_transform[0] = stilb_mat4_identity();
	scene->materials[0] = stilb_scene_material_make((float[3]){1, 1, 1}, (float[3]){0, 0, 0}, 1.0f);
	scene_fit_all_bounds(scene);
	if (!scene_is_sound(scene))
		bench_child_fail("the scene is unsound");
	check(scene_play_begin(scene));
	for (uint32_t f = 0; f < figures; f++) {
		stilb_scene_play play = stilb_scene_play_make(0);
		stilb_scene_pose place = stilb_scene_pose_identity();
		uint32_t figure = 0;
		place.translation[0] = (float)(f % 100);
		place.translation[2] = (float)(f / 100);
		if (f > 0)
			check(stilb_scene_add_figure(scene, &place, &figure));
		play.time = 0.013 * f;
		check(stilb_scene_set_plays(scene, figure, &play, 1));
	}
	return scene;
}

/* ---- times ------------------------------------------------------------------------------------------------------- */

typedef struct times {
	double sample, nodes, pose, all; /* ns */
} times;

/* The time of this thread alone, which other programs do not lengthen; with a pool the clock's. */
static uint64_t now_ns(const stilb_job_pool *pool)
{
	struct timespec now;
	clock_gettime(pool ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static times frame(stilb_scene *scene, double step, stilb_job_pool *pool)
{
	times t;
	uint64_t start = now_ns(pool);
	stilb_scene_advance(scene, step, pool, 0);
	uint64_t sampled = now_ns(pool);
	scene_edit_update_places(scene, pool, 0);
	uint64_t placed = now_ns(pool);
	stilb_scene_update_nodes(scene, pool, 0);
	uint64_t posed = now_ns(pool);
	t.sample = (double)(sampled - start);
	t.nodes = (double)(placed - sampled);
	t.pose = (double)(posed - placed);
	t.all = (double)(posed - start);
	stilb_scene_changes_clear(scene);
	return t;
}

static void keep_least(times *least, times t)
{
	least->sample = fmin(least->sample, t.sample);
	least->nodes = fmin(least->nodes, t.nodes);
	least->pose = fmin(least->pose, t.pose);
	least->all = fmin(least->all, t.all);
}

/* Copies the mesh at rest over all posed ones, as many bytes as poses write. */
static void copy_meshes(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_scene *scene = context;
	const play_rest *rest = &scene->figures->shared.rests[0];
	(void)worker;
	for (uint32_t f = begin; f < end; f++)
		memcpy(scene->meshes[scene->figures->figures[f].meshes[0].mesh].vertices, rest->streams,
		       rest->vertex_count * sizeof(stilb_scene_vertex));
}

static uint64_t hash_of(const stilb_scene *scene)
{
	uint64_t hash = 1469598103934665603u;
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		const unsigned char *bytes = (const unsigned char *)scene->meshes[m].vertices;
		for (size_t i = 0; i < scene->meshes[m].vertex_count * sizeof(stilb_scene_vertex); i += 8) {
			uint64_t word;
			memcpy(&word, bytes + i, sizeof word);
			hash = (hash ^ word) * 1099511628211u;
		}
	}
	return hash;
}

static void run(const bench_child *child, uint32_t figures, uint32_t joints, uint32_t vertices)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no worker starts");
	stilb_scene *scene = make_scene(figures, joints, vertices);
	frame(scene, 0.0, NULL);
	double never = (double)INFINITY;
	times one = {never, never, never, never}, two = one;
	double copy = (double)INFINITY, still = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 4 || bench_child_now_ns() < end; i++) {
		keep_least(&one, frame(scene, 1.0 / 64, NULL));
		uint64_t was = hash_of(scene);
		frame(scene, -1.0 / 64, pool);
		keep_least(&two, frame(scene, 1.0 / 64, pool));
		if (hash_of(scene) != was)
			bench_child_fail("two threads make other poses than one");
		uint64_t start = now_ns(NULL);
		copy_meshes(0, figures, 0, scene);
		copy = fmin(copy, (double)(now_ns(NULL) - start));
		still = fmin(still, frame(scene, 0.0, pool).all);
	}
	double count = (double)figures * joints;
	bench_child_metric("channel", one.sample / count / CHANNELS);
	bench_child_metric("joint", one.sample / count);
	bench_child_metric("two", one.sample / two.sample);
	bench_child_metric("nodes", one.nodes / count);
	bench_child_metric("frame", two.all * 1e-6);
	bench_child_metric("still", still * 1e-3);
	if (vertices > 0) {
		bench_child_metric("vertex", one.pose / figures / vertices);
		bench_child_metric("copy", copy / figures / vertices);
		bench_child_metric("share", copy / one.pose);
	}
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES)                                                                   \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, FIGURES, JOINTS, VERTICES);                                                                        \
		return 0;                                                                                                      \
	}
	ANIMATE_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
