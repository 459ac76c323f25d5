/* Figures for the stress test: one of limbs with a skin, made here, and copies of it, each at a time of its own. */
#include "scene/edit/scene_edit.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIGURE_HEIGHT 0.9f /* metres */
#define FIGURE_SIDES 8u    /* of a limb */
#define FIGURE_RINGS 6u
#define FIGURE_KEYS 17u  /* of a step, the last as the first */
#define FIGURE_STEP 1.1f /* seconds */
#define FIGURE_INFLUENCES 4u
#define FIGURE_TURN 6.2831853f

/* Joints of a figure 1 high, which looks along +Z: where they are, what they hang on, and where their limb ends. */
typedef struct figure_joint {
	float at[3], end[3];
	uint32_t parent; /* another joint; STILB_SCENE_NONE: the figure itself */
	float width, end_width;
} figure_joint;

enum {
	HIPS,
	CHEST,
	HEAD,
	LEFT_ARM,
	LEFT_HAND,
	RIGHT_ARM,
	RIGHT_HAND,
	LEFT_LEG,
	LEFT_FOOT,
	RIGHT_LEG,
	RIGHT_FOOT,
	JOINTS
};

static const figure_joint figure_joints[JOINTS] = {
	[HIPS] = {{0, 0.52f, 0}, {0, 0.6f, 0}, STILB_SCENE_NONE, 0.085f, 0.075f},
	[CHEST] = {{0, 0.6f, 0}, {0, 0.83f, 0}, HIPS, 0.075f, 0.1f},
	[HEAD] = {{0, 0.85f, 0}, {0, 1.0f, 0}, CHEST, 0.05f, 0.06f},
	[LEFT_ARM] = {{0.13f, 0.81f, 0}, {0.16f, 0.62f, 0}, CHEST, 0.035f, 0.028f},
	[LEFT_HAND] = {{0.16f, 0.62f, 0}, {0.17f, 0.42f, 0}, LEFT_ARM, 0.028f, 0.02f},
	[RIGHT_ARM] = {{-0.13f, 0.81f, 0}, {-0.16f, 0.62f, 0}, CHEST, 0.035f, 0.028f},
	[RIGHT_HAND] = {{-0.16f, 0.62f, 0}, {-0.17f, 0.42f, 0}, RIGHT_ARM, 0.028f, 0.02f},
	[LEFT_LEG] = {{0.06f, 0.52f, 0}, {0.065f, 0.27f, 0}, HIPS, 0.055f, 0.04f},
	[LEFT_FOOT] = {{0.065f, 0.27f, 0}, {0.065f, 0.02f, 0}, LEFT_LEG, 0.04f, 0.028f},
	[RIGHT_LEG] = {{-0.06f, 0.52f, 0}, {-0.065f, 0.27f, 0}, HIPS, 0.055f, 0.04f},
	[RIGHT_FOOT] = {{-0.065f, 0.27f, 0}, {-0.065f, 0.02f, 0}, RIGHT_LEG, 0.04f, 0.028f},
};

/* Angles about X, radians, at a share of the step: legs swing and knees bend as they come forward, arms go against the
 * legs of their side. */
static float figure_angle(uint32_t joint, float share)
{
	float phase = FIGURE_TURN * share;
	switch (joint) {
	case LEFT_LEG:
		return -0.55f * sinf(phase);
	case RIGHT_LEG:
		return 0.55f * sinf(phase);
	case LEFT_FOOT:
		return 0.45f * (1.0f - cosf(phase + 0.6f));
	case RIGHT_FOOT:
		return 0.45f * (1.0f + cosf(phase + 0.6f));
	case LEFT_ARM:
		return 0.5f * sinf(phase);
	case RIGHT_ARM:
		return -0.5f * sinf(phase);
	case LEFT_HAND:
	case RIGHT_HAND:
		return -0.4f;
	case CHEST:
		return 0.06f;
	default:
		return 0.0f;
	}
}

/* ---- the mesh ---------------------------------------------------------------------------------------------------- */

#define LIMB_VERTICES (FIGURE_SIDES * FIGURE_RINGS + 2u)
#define LIMB_TRIANGLES (2u * FIGURE_SIDES * FIGURE_RINGS)

/* A vertex of a limb; near its beginning the joint before carries it, too. */
static void figure_vertex(stilb_scene_mesh *mesh, stilb_scene_deform *deform, uint32_t joint, uint32_t vertex,
                          float along, float out, float side)
{
	const figure_joint *from = &figure_joints[joint];
	uint32_t v = joint * LIMB_VERTICES + vertex;
	float width = (from->width + along * (from->end_width - from->width)) * out, angle = FIGURE_TURN * side;
	stilb_scene_vertex *to = &mesh->vertices[v];
	for (int i = 0; i < 3; i++)
		to->position[i] = FIGURE_HEIGHT * (from->at[i] + along * (from->end[i] - from->at[i]));
	to->position[0] += FIGURE_HEIGHT * width * cosf(angle);
	to->position[2] += FIGURE_HEIGHT * width * sinf(angle);
	bool tip = out == 0.0f;
	float up = from->end[1] > from->at[1] ? 1.0f : -1.0f, tilt = tip ? (along > 0.5f ? up : -up) : 0.0f;
	memcpy(to->normal, (float[3]){tip ? 0.0f : cosf(angle), tilt, tip ? 0.0f : sinf(angle)}, sizeof to->normal);
	to->uv[0] = side;
	to->uv[1] = along;
	float shared = from->parent == STILB_SCENE_NONE ? 0.0f : fmaxf(0.5f - 2.0f * along, 0.0f);
	deform->joints[(size_t)v * FIGURE_INFLUENCES] = (uint16_t)joint;
	deform->weights[(size_t)v * FIGURE_INFLUENCES] = 1.0f - shared;
	if (shared > 0.0f) {
		deform->joints[(size_t)v * FIGURE_INFLUENCES + 1] = (uint16_t)from->parent;
		deform->weights[(size_t)v * FIGURE_INFLUENCES + 1] = shared;
	}
}

static void figure_triangles(uint32_t *indices, uint32_t first, bool up)
{
	uint32_t low = first + FIGURE_SIDES * FIGURE_RINGS, high = low + 1;
	for (uint32_t ring = 0; ring <= FIGURE_RINGS; ring++)
		for (uint32_t s = 0; s < FIGURE_SIDES; s++) {
			uint32_t next = (s + 1) % FIGURE_SIDES, below = first + (ring - 1) * FIGURE_SIDES,
					 above = below + FIGURE_SIDES;
			uint32_t a = ring > 0 ? below + s : low, b = ring > 0 ? below + next : low;
			uint32_t c = ring < FIGURE_RINGS ? above + next : high, d = ring < FIGURE_RINGS ? above + s : high;
			uint32_t corners[2][3] = {{a, d, c}, {a, c, b}};
			for (int t = 0; t < 2; t++) {
				if ((t == 0 && ring == FIGURE_RINGS) || (t == 1 && ring == 0))
					continue; /* at the ends there is one triangle for each side */
				*indices++ = corners[t][0];
				*indices++ = corners[t][up ? 1 : 2];
				*indices++ = corners[t][up ? 2 : 1];
			}
		}
}

static stilb_result figure_mesh(stilb_scene_mesh *mesh, stilb_scene_deform *deform)
{
	stilb_result result = scene_mesh_create(mesh, JOINTS * LIMB_VERTICES, JOINTS * 3 * LIMB_TRIANGLES);
	deform->influences = FIGURE_INFLUENCES;
	if (result == STILB_OK)
		result = scene_deform_create(deform, mesh->vertex_count, false, false);
	for (uint32_t j = 0; result == STILB_OK && j < JOINTS; j++) {
		uint32_t first_index = 3u * LIMB_TRIANGLES * j;
		for (uint32_t v = 0; v < FIGURE_SIDES * FIGURE_RINGS; v++) {
			uint32_t ring = v / FIGURE_SIDES, side = v % FIGURE_SIDES;
			float along = (float)ring / (float)(FIGURE_RINGS - 1);
			figure_vertex(mesh, deform, j, v, along, 1.0f, (float)side / (float)FIGURE_SIDES);
		}
		figure_vertex(mesh, deform, j, FIGURE_SIDES * FIGURE_RINGS, 0.0f, 0.0f, 0.0f);
		figure_vertex(mesh, deform, j, FIGURE_SIDES * FIGURE_RINGS + 1, 1.0f, 0.0f, 0.0f);
		figure_triangles(mesh->indices + first_index, j * LIMB_VERTICES,
		                 figure_joints[j].end[1] > figure_joints[j].at[1]);
	}
	return result;
}

/* ---- the clip ---------------------------------------------------------------------------------------------------- */

/* Node 0 shows the mesh; joint j is node 1 + j. */
static void figure_nodes(stilb_scene *scene, uint32_t model)
{
	stilb_scene_animation *a = scene->animation;
	for (uint32_t n = 0; n <= JOINTS; n++) {
		const figure_joint *joint = n > 0 ? &figure_joints[n - 1] : NULL;
		bool root = !joint || joint->parent == STILB_SCENE_NONE;
		stilb_scene_pose pose = stilb_scene_pose_identity();
		for (int i = 0; joint && i < 3; i++)
			pose.translation[i] = FIGURE_HEIGHT * (joint->at[i] - (root ? 0.0f : figure_joints[joint->parent].at[i]));
		stilb_scene_rest *rest = &a->nodes[n];
		*rest = (stilb_scene_rest){.parent = root ? STILB_SCENE_NONE : 1 + joint->parent,
		                           .local = stilb_scene_pose_matrix(&pose),
		                           .rotation = {0, 0, 0, 1},
		                           .scale = {1, 1, 1},
		                           .moves = true,
		                           .first_model = model,
		                           .model_count = n == 0,
		                           .skin = n == 0 ? 0 : STILB_SCENE_NONE};
		memcpy(rest->translation, pose.translation, sizeof rest->translation);
		scene->nodes.parent[n] = rest->parent;
		scene->nodes.pose[n] = pose;
		scene->nodes.local[n] = scene->nodes.to_world[n] = rest->local;
		if (!root)
			scene->nodes.to_world[n] = stilb_mat4_multiply(scene->nodes.to_world[rest->parent], rest->local);
		if (!joint)
			continue;
		a->joints[n - 1] = n;
		a->inverse_binds[n - 1] = stilb_mat4_scale_translate(
			1.0f, -FIGURE_HEIGHT * joint->at[0], -FIGURE_HEIGHT * joint->at[1], -FIGURE_HEIGHT * joint->at[2]);
	}
	a->skins[0] = (stilb_scene_skin){"figure", 0, JOINTS};
}

/* A channel for each joint's rotation, and one that lifts and lowers the hips. */
static void figure_clip(stilb_scene_animation *a)
{
	uint32_t value = 0;
	for (uint32_t k = 0; k < FIGURE_KEYS; k++)
		a->times[k] = FIGURE_STEP * (float)k / (float)(FIGURE_KEYS - 1);
	for (uint32_t c = 0; c <= JOINTS; c++) {
		bool lift = c == JOINTS;
		a->channels[c] = (stilb_scene_channel){.node = 1 + (lift ? HIPS : c),
		                                       .path = lift ? STILB_SCENE_PATH_TRANSLATION : STILB_SCENE_PATH_ROTATION,
		                                       .interpolation = STILB_SCENE_LINEAR,
		                                       .key_count = FIGURE_KEYS,
		                                       .width = lift ? 3 : 4,
		                                       .first_value = value};
		for (uint32_t k = 0; k < FIGURE_KEYS; k++) {
			float share = (float)k / (float)(FIGURE_KEYS - 1), half = lift ? 0.0f : 0.5f * figure_angle(c, share);
			float up = FIGURE_HEIGHT * (figure_joints[HIPS].at[1] - 0.015f * (1.0f - cosf(2.0f * FIGURE_TURN * share)));
			float turn[4] = {sinf(half), 0.0f, 0.0f, cosf(half)}, move[3] = {0.0f, up, 0.0f};
			memcpy(a->values + value, lift ? move : turn, (lift ? 3 : 4) * sizeof(float));
			value += lift ? 3 : 4;
		}
	}
	a->clips[0] = (stilb_scene_clip){"walk", FIGURE_STEP, 0, JOINTS + 1};
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* Figure 0, which its scene has not yet. */
static stilb_result figure_first(stilb_scene *scene)
{
	static const stilb_scene_animation counts = {.node_count = JOINTS + 1,
	                                             .clip_count = 1,
	                                             .channel_count = JOINTS + 1,
	                                             .skin_count = 1,
	                                             .joint_count = JOINTS,
	                                             .deform_count = 1,
	                                             .time_count = FIGURE_KEYS,
	                                             .value_count = FIGURE_KEYS * (4 * JOINTS + 3)};
	stilb_mat4 world = stilb_mat4_identity();
	stilb_scene_mesh mesh = {0};
	uint32_t id = 0, model = 0;
	stilb_result result = scene_add_nodes(scene, JOINTS + 1);
	if (result == STILB_OK)
		result = scene_animation_create(&counts, &scene->animation);
	if (result == STILB_OK)
		result = figure_mesh(&mesh, &scene->animation->deforms[0]);
	if (result == STILB_OK)
		result = stilb_scene_add_mesh(scene, &mesh, &id);
	stilb_scene_mesh_finish(&mesh);
	stilb_scene_build_part part = {id, 0};
	if (result == STILB_OK)
		result = stilb_scene_add_model(scene, &world, &part, 1, &model);
	if (result != STILB_OK)
		return result;
	scene->animation->deforms[0].mesh = id;
	figure_nodes(scene, model);
	figure_clip(scene->animation);
	STILB_CHECK(scene_animation_is_sound(scene));
	return scene_play_begin(scene);
}

/* Figures stand where four tiles meet, between the spheres, and look into any direction. */
static stilb_scene_pose figure_place(const stilb_scene *scene, uint32_t figure, uint32_t count)
{
	uint64_t side = (uint64_t)ceil(sqrt((double)scene->stress_models)) + 1;
	uint64_t corner = (uint64_t)figure * (side * side) / count, row = corner / side, column = corner % side;
	stilb_scene_pose pose = stilb_scene_pose_identity();
	float half = 3.14159265f * stilb_random_float(scene->seed + 1, figure);
	pose.translation[0] = STILB_SCENE_TILE * ((float)column - 0.5f * (float)(side - 1));
	pose.translation[2] = STILB_SCENE_TILE * ((float)row - 0.5f * (float)(side - 1));
	pose.rotation[1] = sinf(half);
	pose.rotation[3] = cosf(half);
	return pose;
}

stilb_result stilb_scene_stress_add_figures(stilb_scene *scene, uint32_t count)
{
	STILB_ASSERT(scene && scene->stress_models > 0 && !scene->animation && !scene->edits && count > 0);
	stilb_result result = figure_first(scene);
	stilb_scene_play play = stilb_scene_play_make(0);
	for (uint32_t f = 0; result == STILB_OK && f < count; f++) {
		uint32_t figure;
		stilb_scene_pose place = figure_place(scene, f, count);
		result = stilb_scene_add_figure(scene, &place, &figure);
		play.time = (double)(FIGURE_STEP * stilb_random_float(scene->seed + 2, f));
		if (result == STILB_OK)
			result = stilb_scene_set_plays(scene, figure, &play, 1);
		if (result == STILB_OK)
			result =
				stilb_scene_set_part(scene, scene->model_count - 1, 0,
			                         (stilb_scene_build_part){scene->mesh_count - 1, 2 * (f % scene->stress_models)});
	}
	if (result == STILB_OK)
		result = stilb_scene_show_model(scene, scene->animation->nodes[0].first_model, false);
	return result;
}
