/* The figures of the suite `animate`: a tube along a chain of joints, made by hand, and copies of it. */
#include "bench/animate/animate_scene.h"

#include "bench/harness/bench_child.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <string.h>

#define KEYS 61u
#define CLIP_SECONDS 2.0f

void animate_check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

/* A chain of joints, the first of which stands on node 0, which shows the mesh. */
static void make_joints(stilb_scene *scene, uint32_t joints)
{
	stilb_scene_animation *a = scene->animation;
	animate_check(scene_add_nodes(scene, joints + 1));
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
	static const uint32_t widths[ANIMATE_CHANNELS] = {3, 4, 3};
	uint32_t value = 0;
	for (uint32_t k = 0; k < KEYS; k++)
		a->times[k] = CLIP_SECONDS * (float)k / (float)(KEYS - 1);
	for (uint32_t c = 0; c < joints * ANIMATE_CHANNELS; c++) {
		uint32_t path = c % ANIMATE_CHANNELS;
		a->channels[c] = (stilb_scene_channel){.node = 1 + c / ANIMATE_CHANNELS,
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
	a->clips[0] = (stilb_scene_clip){"sway", CLIP_SECONDS, 0, joints * ANIMATE_CHANNELS};
}

/* A tube along the joints; without vertices a triangle. torn: its vertices in no order. */
static void make_mesh(stilb_scene *scene, uint32_t joints, uint32_t vertices, bool torn)
{
	stilb_scene_deform *deform = &scene->animation->deforms[0];
	stilb_scene_mesh *mesh = &scene->meshes[0];
	uint32_t count = vertices > 3 ? vertices : 3;
	animate_check(scene_mesh_create(mesh, count, 3 * (count - 2)));
	*deform = (stilb_scene_deform){.mesh = 0, .influences = 4};
	animate_check(scene_deform_create(deform, count, false, false));
	for (uint32_t v = 0; v < count; v++) {
		uint32_t place = torn ? (uint32_t)(v * 2654435761ull % count) : v;
		float along = (float)place / (float)count * (float)(joints - 1), angle = 0.7f * (float)v;
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

stilb_scene *animate_scene(uint32_t figures, uint32_t joints, uint32_t vertices, bool torn)
{
	stilb_scene *scene;
	animate_check(scene_create(1, 1, 1, 1, &scene));
	stilb_scene_animation counts = {.node_count = joints + 1,
	                                .clip_count = 1,
	                                .channel_count = joints * ANIMATE_CHANNELS,
	                                .skin_count = 1,
	                                .joint_count = joints,
	                                .deform_count = 1,
	                                .time_count = KEYS,
	                                .value_count = joints * KEYS * 10};
	animate_check(scene_animation_create(&counts, &scene->animation));
	make_joints(scene, joints);
	make_clip(scene->animation, joints);
	make_mesh(scene, joints, vertices, torn);
	scene->first_part[1] = 1;
	scene->part_transform[0] = stilb_mat4_identity();
	scene->materials[0] = stilb_scene_material_make((float[3]){1, 1, 1}, (float[3]){0, 0, 0}, 1.0f);
	scene_fit_all_bounds(scene);
	if (!scene_is_sound(scene))
		bench_child_fail("the scene is unsound");
	animate_check(scene_play_begin(scene));
	for (uint32_t f = 0; f < figures; f++) {
		stilb_scene_play play = stilb_scene_play_make(0);
		stilb_scene_pose place = stilb_scene_pose_identity();
		uint32_t figure = 0;
		place.translation[0] = (float)(f % 100);
		place.translation[2] = (float)(f / 100);
		if (f > 0)
			animate_check(stilb_scene_add_figure(scene, &place, &figure));
		play.time = 0.013 * f;
		animate_check(stilb_scene_set_plays(scene, figure, &play, 1));
	}
	return scene;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static uint64_t clock_ns(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

animate_cpu animate_cpu_now(void)
{
	return (animate_cpu){clock_ns(CLOCK_THREAD_CPUTIME_ID), clock_ns(CLOCK_PROCESS_CPUTIME_ID)};
}

double animate_busier_ns(animate_cpu since)
{
	animate_cpu now = animate_cpu_now();
	uint64_t own = now.own_ns - since.own_ns, all = now.all_ns - since.all_ns, other = all > own ? all - own : 0;
	return (double)(own > other ? own : other);
}
