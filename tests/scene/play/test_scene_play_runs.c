/*
 * Scenes that play on: pauses and steps, figures that come, go and stand elsewhere, edits in between, and files that
 * are extreme: clips of no length and of 30 years, 100,000 nodes, keys at the same time.
 */
#include "glb_moving.h"
#include "play_check.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/open/scene_import.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"

#define ALL (MOVING_STEP | MOVING_LINEAR | MOVING_CUBIC)
#define FRAME (1.0 / 60.0)

static const moving_file files[] = {
	{"skin and targets", ALL | MOVING_NORMALS | MOVING_OWN, 8, 1, 2, 6, 0, 1, 1},
	{"instances", ALL | MOVING_INSTANCES | MOVING_TWO_SKINS, 8, 1, 2, 6, 0, 1, 1},
	{"matrices", ALL | MOVING_MATRIX | MOVING_SPARSE, 9, 0, 3, 6, 0, 1, 1},
};

#define FILES (sizeof files / sizeof *files)

static stilb_scene *open_scene(void)
{
	stilb_scene *scene;
	if (stilb_scene_open_with("test.glb", &(stilb_scene_open_options){.quiet = true}, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static stilb_scene *open_rest(void)
{
	scene_import_limits limits = scene_import_limits_default();
	stilb_scene *rest;
	if (scene_import_within("test.glb", &limits, &rest) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return rest;
}

/* All that is shown, in bits. */
static uint64_t hash_shown(const stilb_scene *scene)
{
	uint64_t hash = STILB_FNV1A64_START;
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		hash = stilb_hash_fnv1a64(hash, scene->meshes[m].vertices,
		                          scene->meshes[m].vertex_count * sizeof *scene->meshes[m].vertices);
	hash = stilb_hash_fnv1a64(hash, scene->part_transform, scene->part_count * sizeof *scene->part_transform);
	hash = stilb_hash_fnv1a64(hash, scene->bounds.x, scene->model_count * sizeof *scene->bounds.x);
	return stilb_hash_fnv1a64(hash, scene->bounds.radius, scene->model_count * sizeof *scene->bounds.radius);
}

static void step(stilb_scene *scene, double seconds)
{
	stilb_scene_advance(scene, seconds, NULL, 0);
	stilb_scene_update_nodes(scene, NULL, 0);
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static void pauses_and_steps_equal_running(void **state)
{
	(void)state;
	for (size_t i = 0; i < FILES; i++) {
		moving_write(&files[i], 500 + i);
		stilb_scene *runs = open_scene(), *pauses = open_scene();
		stilb_scene_play plays[2] = {stilb_scene_play_make(0), stilb_scene_play_make(1)};
		plays[1].weight = 0.5f;
		plays[1].speed = -0.75f;
		assert_int_equal(stilb_scene_set_plays(runs, 0, plays, 2), STILB_OK);
		assert_int_equal(stilb_scene_set_plays(pauses, 0, plays, 2), STILB_OK);
		uint64_t last = 0;
		for (int frame = 0; frame < 90; frame++) {
			step(runs, FRAME);
			step(pauses, FRAME);
			uint64_t shown = hash_shown(pauses);
			assert_true(hash_shown(runs) == shown && shown != last);
			last = shown;
			for (int k = 0; k < frame % 3; k++)
				step(pauses, 0.0);
			if (frame % 7 == 0) { /* another way to pause, with the times that it has come to */
				uint32_t count;
				stilb_scene_play held[2];
				memcpy(held, stilb_scene_plays_of(pauses, 0, &count), sizeof held);
				float speeds[2] = {held[0].speed, held[1].speed};
				held[0].speed = held[1].speed = 0.0f;
				assert_int_equal(stilb_scene_set_plays(pauses, 0, held, count), STILB_OK);
				step(pauses, 10.0);
				held[0].speed = speeds[0];
				held[1].speed = speeds[1];
				assert_int_equal(stilb_scene_set_plays(pauses, 0, held, count), STILB_OK);
			}
			assert_true(hash_shown(pauses) == shown);
		}
		stilb_scene_destroy(runs);
		stilb_scene_destroy(pauses);
	}
}

/* ---- figures ----------------------------------------------------------------------------------------------------- */

/* Figures are what figure 0 would be there: moved, turned, mirrored, and each with its own clips. */
static void figures_stand_where_they_are_put(void **state)
{
	(void)state;
	static const stilb_scene_pose places[] = {
		{{7, -2, 3}, {0, 0, 0, 1}, {1, 1, 1}},
		{{0, 9, 1}, {0.5f, -0.5f, 0.5f, 0.5f}, {2, 2, 2}},
		{{-6, 0, 2}, {0.6f, 0, 0.8f, 0}, {-1, 1, 0.5f}},
	};
	for (size_t i = 0; i < FILES; i++) {
		moving_write(&files[i], 600 + i);
		stilb_scene *rest = open_rest(), *scene = open_scene();
		uint32_t figures[4] = {0}, gone;
		stilb_mat4 where[4] = {stilb_mat4_identity()};
		stilb_scene_play plays[4][2];
		assert_int_equal(stilb_scene_add_figure(scene, &places[0], &gone), STILB_OK);
		for (uint32_t f = 0; f < 4; f++) {
			if (f > 0) {
				assert_int_equal(stilb_scene_add_figure(scene, &places[f - 1], &figures[f]), STILB_OK);
				where[f] = stilb_scene_pose_matrix(&places[f - 1]);
			}
			if (f == 2) /* the next one takes its number */
				assert_int_equal(stilb_scene_remove_figure(scene, gone), STILB_OK);
			for (uint32_t p = 0; p < 2; p++) {
				plays[f][p] = stilb_scene_play_make(p);
				plays[f][p].time = 0.2 + 0.11 * f + 0.07 * p;
				plays[f][p].weight = p ? 0.6f : 0.3f * (float)f;
			}
			assert_int_equal(stilb_scene_set_plays(scene, figures[f], plays[f], 2), STILB_OK);
		}
		assert_int_equal(figures[3], gone);
		step(scene, 0.25);
		play_errors errors = {0};
		for (uint32_t f = 0; f < 4; f++) {
			uint32_t count;
			const stilb_scene_play *now = stilb_scene_plays_of(scene, figures[f], &count);
			assert_true(count == 2 && fabs(now[0].time - plays[f][0].time - 0.25) < 1e-12);
			play_compare(rest, scene, figures[f], &where[f], now, count, files[i].name, &errors);
		}
		play_assert(&errors, files[i].name);
		stilb_scene_destroy(rest);
		stilb_scene_destroy(scene);
	}
}

/* The models of a figure have the flags of the file's. */
static void figures_have_the_flags_of_the_file(void **state)
{
	(void)state;
	moving_write(&files[0], 600);
	stilb_scene *scene = open_scene();
	stilb_scene_pose place = stilb_scene_pose_identity();
	uint32_t count = scene->model_count, figure;
	for (uint32_t m = 0; m < count; m++)
		assert_int_equal(stilb_scene_set_model_flags(scene, m, STILB_SCENE_MODEL_CASTS_NO_SHADOW), STILB_OK);
	assert_int_equal(stilb_scene_add_figure(scene, &place, &figure), STILB_OK);
	assert_true(scene->model_count > count);
	for (uint32_t m = count; m < scene->model_count; m++)
		assert_int_equal(scene->model_flags[m], STILB_SCENE_MODEL_CASTS_NO_SHADOW);
	stilb_scene_destroy(scene);
}

/* Wherever a figure stands, 10 km away too, and whoever moves it, its meshes have the bits that figure 0's have. */
static void places_change_no_bit_of_a_shape(void **state)
{
	(void)state;
	moving_write(&files[0], 650);
	stilb_scene *scene = open_scene();
	uint32_t figures[2] = {0};
	stilb_scene_pose place = {{9123.25f, -77.7f, 1234.5f}, {0.6f, 0, 0.8f, 0}, {1.25f, 0.5f, -2}};
	stilb_scene_play play = stilb_scene_play_make(0);
	assert_int_equal(stilb_scene_add_figure(scene, &place, &figures[1]), STILB_OK);
	for (int f = 0; f < 2; f++)
		assert_int_equal(stilb_scene_set_plays(scene, figures[f], &play, 1), STILB_OK);
	for (int frame = 0; frame < 20; frame++) {
		place.translation[0] += 1.1f;
		assert_int_equal(
			stilb_scene_set_node_pose(scene, stilb_scene_figure_node(scene, figures[1], STILB_SCENE_NONE), &place),
			STILB_OK);
		step(scene, frame % 2 ? FRAME : 0.0);
		for (uint32_t p = 0; p < scene->figures->shared.posed_count; p++) {
			const stilb_scene_mesh *own = &scene->meshes[scene->figures->figures[0].meshes[p].mesh];
			const stilb_scene_mesh *far = &scene->meshes[scene->figures->figures[figures[1]].meshes[p].mesh];
			assert_memory_equal(own->vertices, far->vertices, own->vertex_count * sizeof *own->vertices);
			assert_memory_equal(own->extras, far->extras, own->vertex_count * sizeof *own->extras);
		}
	}
	stilb_scene_destroy(scene);
}

/* Hung elsewhere, a joint is where its new parent takes it. */
static void joints_can_hang_elsewhere(void **state)
{
	(void)state;
	moving_write(&files[0], 660);
	stilb_scene *rest = open_rest(), *scene = open_scene();
	stilb_scene_pose place = {{7, -2, 3}, {0, 0.6f, 0, 0.8f}, {1, 2, 1}};
	uint32_t figure, joint = rest->animation->joints[2];
	assert_int_equal(stilb_scene_add_figure(scene, &place, &figure), STILB_OK);
	uint32_t node = stilb_scene_figure_node(scene, figure, joint);
	step(scene, 0.0);
	/* It goes below the world, to where it is already: nothing of what is shown changes. */
	stilb_mat4 where = scene->nodes.to_world[node];
	assert_int_equal(stilb_scene_set_node_parent(scene, node, STILB_SCENE_NONE), STILB_OK);
	assert_int_equal(stilb_scene_set_node_matrix(scene, node, &where), STILB_OK);
	step(scene, 0.0);
	stilb_mat4 stands = stilb_scene_pose_matrix(&place);
	play_errors errors = {0};
	play_compare(rest, scene, figure, &stands, NULL, 0, files[0].name, &errors);
	play_assert(&errors, files[0].name);
	uint64_t shown = hash_shown(scene);
	where.m[12] += 1.0f; /* and then away */
	assert_int_equal(stilb_scene_set_node_matrix(scene, node, &where), STILB_OK);
	step(scene, 0.0);
	assert_true(hash_shown(scene) != shown);
	stilb_scene_destroy(rest);
	stilb_scene_destroy(scene);
}

/* Each node is where its parent and its own matrix take it. */
static void assert_placed(const stilb_scene *scene)
{
	const stilb_scene_nodes *nodes = &scene->nodes;
	for (uint32_t n = 0; n < nodes->count; n++) {
		if (scene->edits->nodes.next[n] != EDIT_IN_USE)
			continue;
		stilb_mat4 world = nodes->local[n];
		if (nodes->parent[n] != STILB_SCENE_NONE)
			world = stilb_mat4_multiply(nodes->to_world[nodes->parent[n]], nodes->local[n]);
		for (int i = 0; i < 16; i++)
			assert_true(fabsf(world.m[i] - nodes->to_world[n].m[i]) <= 1e-5f * (1.0f + fabsf(world.m[i])));
	}
}

/* A joint that clips move goes below another node, and clips still move it there, and all that hangs on it. */
static void clips_move_what_hangs_elsewhere(void **state)
{
	(void)state;
	moving_write(&files[0], 661);
	stilb_scene *scene = open_scene();
	const play_shared *shared = &scene->figures->shared;
	stilb_scene_pose place = {{7, -2, 3}, {0, 0.6f, 0, 0.8f}, {1, 2, 1}};
	stilb_scene_play play = stilb_scene_play_make(0);
	uint32_t figure, hook, moves = 0;
	assert_int_equal(stilb_scene_add_figure(scene, &place, &figure), STILB_OK);
	assert_int_equal(stilb_scene_add_node(scene, STILB_SCENE_NONE, &place, &hook), STILB_OK);
	assert_int_equal(stilb_scene_set_plays(scene, figure, &play, 1), STILB_OK);
	assert_true(shared->top_count > 0 && shared->top_count < shared->moved_count);
	uint32_t node = stilb_scene_figure_node(scene, figure, shared->moved[shared->top_count]);
	for (int frame = 0; frame < 12; frame++) {
		if (frame == 4 || frame == 8)
			assert_int_equal(stilb_scene_set_node_parent(scene, node, frame == 4 ? hook : STILB_SCENE_NONE), STILB_OK);
		stilb_mat4 before = scene->nodes.to_world[node];
		step(scene, (double)scene->animation->clips[0].duration / 13.0);
		moves += memcmp(&before, &scene->nodes.to_world[node], sizeof before) != 0;
		assert_placed(scene);
	}
	assert_true(moves > 6);
	stilb_scene_destroy(scene);
}

static bool is_moved(const play_shared *shared, uint32_t node)
{
	bool moved = false;
	for (uint32_t i = 0; i < shared->moved_count; i++)
		moved |= shared->moved[i] == node;
	return moved;
}

/* Nodes from which the places of all that clips move follow: those that hang on none that clips move. */
static void places_follow_from_the_topmost(void **state)
{
	(void)state;
	uint32_t below = 0;
	for (uint64_t seed = 670; seed < 682; seed++) {
		moving_write(&files[2], seed);
		stilb_scene *scene = open_scene();
		const play_shared *shared = &scene->figures->shared;
		for (uint32_t i = 0; i < shared->moved_count; i++) {
			uint32_t parent = scene->animation->nodes[shared->moved[i]].parent;
			assert_true((i < shared->top_count) == !is_moved(shared, parent));
			below += i < shared->top_count && parent != STILB_SCENE_NONE;
		}
		stilb_scene_destroy(scene);
	}
	assert_true(below > 3);
}

/* The reach of a joint is the distance of the farthest vertex that it, or a joint below it, carries. */
static void joints_reach_what_they_carry(void **state)
{
	(void)state;
	moving_write(&(moving_file){"skin", ALL | MOVING_NORMALS, 8, 1, 0, 6, 0, 1, 1}, 662);
	stilb_scene *rest = open_rest(), *scene = open_scene();
	const stilb_scene_animation *a = scene->animation;
	const play_shared *shared = &scene->figures->shared;
	stilb_mat4 *places = calloc(a->node_count, sizeof *places);
	float *reach = calloc(a->node_count, sizeof *reach);
	assert_true(places && reach);
	assert_int_equal(stilb_scene_set_rates(scene, &(stilb_scene_rates){0}), STILB_OK);
	for (uint32_t n = 0; n < a->node_count; n++)
		places[n] = a->nodes[n].parent == STILB_SCENE_NONE
		                ? a->nodes[n].local
		                : stilb_mat4_multiply(places[a->nodes[n].parent], a->nodes[n].local);
	for (uint32_t p = 0; p < shared->posed_count; p++) {
		const stilb_scene_deform *deform = &a->deforms[shared->posed[p].deform];
		const stilb_scene_skin *skin = &a->skins[shared->posed[p].skin];
		for (uint32_t k = 0; k < rest->meshes[deform->mesh].vertex_count * deform->influences; k++) {
			const float *at = rest->meshes[deform->mesh].vertices[k / deform->influences].position;
			uint32_t joint = skin->first_joint + deform->joints[k];
			stilb_mat4 to = stilb_mat4_multiply(places[a->joints[joint]], a->inverse_binds[joint]);
			for (uint32_t n = a->joints[joint]; n != STILB_SCENE_NONE && deform->weights[k] > 0.0f;
			     n = a->nodes[n].parent) {
				float square = 0.0f;
				for (int i = 0; i < 3; i++) {
					float x = to.m[i] * at[0] + to.m[4 + i] * at[1] + to.m[8 + i] * at[2] + to.m[12 + i] -
					          places[n].m[12 + i];
					square += x * x;
				}
				reach[n] = fmaxf(reach[n], sqrtf(square));
			}
		}
	}
	uint32_t checked = 0;
	for (uint32_t n = 0; n < a->node_count; n++) {
		if (isinf(shared->reach[n]))
			continue;
		assert_true(fabsf(shared->reach[n] - reach[n]) <= 1e-5f * reach[n]);
		checked += reach[n] > 0.0f;
	}
	assert_true(checked >= 3);
	free(places);
	free(reach);
	stilb_scene_destroy(rest);
	stilb_scene_destroy(scene);
}

/* A figure that the program adds, plays and takes apart. */
static void change_something(stilb_scene *scene, uint32_t *figures, uint32_t *count)
{
	uint32_t f = *count > 0 ? moving_below(*count) : 0, kind = moving_below(8), ended;
	stilb_scene_play plays[3];
	for (uint32_t p = 0; p < 3; p++) {
		plays[p] = stilb_scene_play_make(moving_below(2));
		plays[p].time = (double)moving_between(-3, 3);
		plays[p].speed = moving_between(-2, 2);
		plays[p].weight = moving_between(0, 1);
		plays[p].repeat = moving_below(2) ? STILB_SCENE_LOOP : STILB_SCENE_ONCE;
	}
	stilb_scene_pose pose = stilb_scene_pose_identity();
	moving_random(pose.translation, 3, 5.0f);
	if (kind < 2 && *count < 10) {
		assert_int_equal(stilb_scene_add_figure(scene, &pose, &figures[*count]), STILB_OK);
		*count += 1;
	} else if (*count == 0) {
		return;
	} else if (kind < 3) {
		assert_int_equal(stilb_scene_remove_figure(scene, figures[f]), STILB_OK);
		figures[f] = figures[--*count];
	} else if (kind < 5) {
		assert_int_equal(stilb_scene_set_plays(scene, figures[f], plays, moving_below(4)), STILB_OK);
	} else if (kind == 5) {
		const play_figure *figure = &scene->figures->figures[figures[f]];
		uint32_t model = figure->models[moving_below(scene->figures->shared.model_count)];
		if (model != STILB_SCENE_NONE)
			assert_int_equal(stilb_scene_remove_model(scene, model), STILB_OK);
	} else if (kind == 6) {
		uint32_t node = stilb_scene_figure_node(scene, figures[f], moving_below(scene->animation->node_count));
		if (node != STILB_SCENE_NONE && moving_below(2))
			stilb_scene_remove_node(scene, node); /* refused while things hang on it */
		else if (node != STILB_SCENE_NONE)
			assert_int_equal(stilb_scene_set_node_pose(scene, node, &pose), STILB_OK);
	} else {
		const play_figure *figure = &scene->figures->figures[figures[f]];
		ended = figure->meshes[moving_below(scene->figures->shared.posed_count)].mesh;
		if (ended != STILB_SCENE_NONE && stilb_scene_remove_mesh(scene, ended) != STILB_OK)
			assert_int_equal(
				stilb_scene_set_mesh(scene, ended, &scene->meshes[scene->figures->figures[0].meshes[0].mesh]),
				STILB_OK);
	}
}

static void figures_come_and_go_while_they_play(void **state)
{
	(void)state;
	for (size_t i = 0; i < FILES; i++) {
		moving_write(&files[i], 700 + i);
		stilb_scene *rest = open_rest(), *scene = open_scene();
		uint32_t figures[10], count = 0;
		stilb_mat4 world = stilb_mat4_identity();
		play_errors errors = {0};
		stilb_scene_play plays[2] = {stilb_scene_play_make(0), stilb_scene_play_make(1)};
		assert_int_equal(stilb_scene_set_plays(scene, 0, plays, 2), STILB_OK);
		for (int frame = 0; frame < 400; frame++) {
			change_something(scene, figures, &count);
			if (frame % 50 == 13) { /* it is framed meanwhile, for all that a clip does */
				assert_int_equal(stilb_scene_sweep(scene, moving_below(2)), STILB_OK);
				assert_true(isfinite(stilb_scene_frame(scene, 0.4f, -0.3f, 1.5f).position[0]));
			}
			step(scene, frame % 5 ? FRAME : 0.0);
			if (frame % 20 == 0) {
				uint32_t playing;
				const stilb_scene_play *now = stilb_scene_plays_of(scene, 0, &playing);
				play_compare(rest, scene, 0, &world, now, playing, files[i].name, &errors);
			}
		}
		play_assert(&errors, files[i].name);
		assert_int_equal(stilb_scene_remove_figure(scene, 0), STILB_ERROR_ARGUMENT);
		while (count > 0)
			assert_int_equal(stilb_scene_remove_figure(scene, figures[--count]), STILB_OK);
		step(scene, FRAME);
		stilb_scene_destroy(rest);
		stilb_scene_destroy(scene);
	}
}

/* ---- extremes ---------------------------------------------------------------------------------------------------- */

#define ONE_NODE                                                                                                       \
	"\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"meshes\":[{\"primitives\":[{\"attributes\":{"             \
	"\"POSITION\":0}}]}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,"     \
	"\"target\":{\"node\":0,\"path\":\"translation\"}}]}],\"accessors\":[" VEC3(                                       \
		0) ",{\"bufferView\":1,"                                                                                       \
		   "\"componentType\":5126,\"count\":%u,\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5126,"        \
		   "\"count\":%u,"                                                                                             \
		   "\"type\":\"VEC3\"}]"

/* A triangle that moves along x through these keys. */
static stilb_scene *open_slide(const float *times, const float *places, uint32_t count)
{
	char json[2048];
	float values[8][3] = {{0}};
	for (uint32_t k = 0; k < count; k++)
		values[k][0] = places[k];
	begin();
	put(triangle, sizeof triangle);
	put(times, count * sizeof *times);
	put(values, count * sizeof *values);
	snprintf(json, sizeof json, ONE_NODE, count, count);
	write_glb(json);
	return open_scene();
}

static float slid(const stilb_scene *scene)
{
	return scene->part_transform[0].m[12];
}

static void play_from(stilb_scene *scene, double time, stilb_scene_repeat repeat)
{
	stilb_scene_play play = stilb_scene_play_make(0);
	play.time = time;
	play.repeat = repeat;
	assert_int_equal(stilb_scene_set_plays(scene, 0, &play, 1), STILB_OK);
	step(scene, 0.0);
}

static void clips_have_any_length(void **state)
{
	(void)state;
	/* None: there is one time. */
	stilb_scene *scene = open_slide((const float[]){0, 0}, (const float[]){3, 4}, 2);
	assert_true(scene->animation->clips[0].duration == 0.0f);
	for (int repeat = 0; repeat < STILB_SCENE_REPEATS; repeat++)
		for (double time = -2; time < 3; time++) {
			play_from(scene, time, (stilb_scene_repeat)repeat);
			assert_true(slid(scene) == 4.0f);
			step(scene, 1e9);
			assert_true(slid(scene) == 4.0f);
		}
	stilb_scene_destroy(scene);
	/* 10^9 s, with a step of a millisecond at its middle. */
	scene = open_slide((const float[]){0, 1e9f}, (const float[]){0, 1e6f}, 2);
	play_from(scene, 0.4e9, STILB_SCENE_LOOP);
	assert_true(slid(scene) == 0.4e6f);
	play_from(scene, 1e9 + 5e8, STILB_SCENE_LOOP);
	assert_true(slid(scene) == 0.5e6f);
	uint32_t count;
	step(scene, 1e-3);
	assert_true(stilb_scene_plays_of(scene, 0, &count)->time == 5e8 + 1e-3);
	step(scene, 1e9);
	assert_true(fabs(stilb_scene_plays_of(scene, 0, &count)->time - 5e8) < 0.01);
	play_from(scene, 2e9, STILB_SCENE_ONCE);
	assert_true(slid(scene) == 1e6f);
	stilb_scene_destroy(scene);
	/* Several keys at a time: the last of them counts from there on. */
	scene = open_slide((const float[]){0, 1, 1, 1, 2}, (const float[]){0, 10, 50, 20, 30}, 5);
	static const struct {
		double time;
		float place;
	} rows[] = {{0.5, 5}, {0.999, 9.99f}, {1, 20}, {1.5, 25}, {2, 30}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		play_from(scene, rows[i].time, STILB_SCENE_ONCE);
		assert_true(fabsf(slid(scene) - rows[i].place) < 1e-5f);
	}
	stilb_scene_destroy(scene);
	/* The same where keys are far from evenly spaced. */
	scene =
		open_slide((const float[]){0, 0.1f, 0.2f, 0.3f, 3, 3, 3, 10}, (const float[]){0, 1, 2, 3, 30, 50, 20, 90}, 8);
	play_from(scene, 3, STILB_SCENE_ONCE);
	assert_true(slid(scene) == 20.0f);
	play_from(scene, 6.5, STILB_SCENE_ONCE);
	assert_true(slid(scene) == 55.0f);
	stilb_scene_destroy(scene);
}

#define MANY (TEST_ASAN ? 20000u : 100000u)

/* So many nodes below one, or each below the one before; the first and the last are moved. */
static void files_have_many_nodes(void **state)
{
	(void)state;
	for (int deep = 0; deep < 2; deep++) {
		size_t room = MANY * 64ull + 4096, used = 0;
		char *json = malloc(room);
#define ADD(...) used += (size_t)snprintf(json + used, room - used, __VA_ARGS__)
		ADD("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
		for (uint32_t n = 0; n < MANY; n++) {
			ADD("%s{%s", n ? "," : "", n + 1 == MANY ? "\"mesh\":0" : "\"translation\":[0,0,0.0001]");
			if (deep && n + 1 < MANY)
				ADD(",\"children\":[%u]", n + 1);
			for (uint32_t c = 1; !deep && n == 0 && c < MANY; c++)
				ADD("%s%u%s", c == 1 ? ",\"children\":[" : ",", c, c + 1 == MANY ? "]" : "");
			ADD("}");
		}
		ADD("],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"animations\":[{\"samplers\":[{"
		    "\"input\":1,"
		    "\"output\":2}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}},{"
		    "\"sampler\":0,"
		    "\"target\":{\"node\":%u,\"path\":\"translation\"}}]}],\"accessors\":[" VEC3(
				0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"},{\"bufferView\":2,"
		           "\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}]",
		    MANY - 1);
		assert_true(used < room);
		begin();
		put(triangle, sizeof triangle);
		put((const float[]){0, 2}, 8);
		put((const float[]){0, 0, 0, 8, 0, 0}, 24);
		write_glb(json);
		free(json);
		stilb_scene *scene = open_scene();
		assert_int_equal(scene->animation->node_count, MANY);
		play_from(scene, 1.0, STILB_SCENE_ONCE);
		assert_true(slid(scene) == 8.0f);
		assert_true(fabsf(scene->part_transform[0].m[14] - (deep ? (float)(MANY - 2) * 1e-4f : 0.0f)) < 1e-2f);
		stilb_scene_destroy(scene);
#undef ADD
	}
}

/* What a program asks for that cannot be is refused with a reason. */
static void mistakes_are_named(void **state)
{
	(void)state;
	moving_write(&files[0], 800);
	stilb_scene *scene = open_scene();
	uint64_t shown = hash_shown(scene);
	stilb_scene_play good = stilb_scene_play_make(0), bad[STILB_SCENE_MAX_PLAYS + 1];
	for (size_t p = 0; p < sizeof bad / sizeof *bad; p++)
		bad[p] = good;
	assert_int_equal(stilb_scene_set_plays(scene, 0, bad, STILB_SCENE_MAX_PLAYS + 1), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_set_plays(scene, 1, &good, 1), STILB_ERROR_ARGUMENT);
	bad[0].clip = 2;
	bad[1].time = (double)NAN;
	bad[2].speed = INFINITY;
	bad[3].weight = -0.5f;
	bad[4].weight = NAN;
	bad[5].repeat = STILB_SCENE_REPEATS;
	for (size_t p = 0; p < 6; p++) {
		assert_int_equal(stilb_scene_set_plays(scene, 0, &bad[p], 1), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "play 0 of figure 0"));
	}
	const float weights[2] = {1, NAN};
	assert_int_equal(stilb_scene_set_weights(scene, 0, 9, weights, 2), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_set_weights(scene, 0, 9, weights, 1), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_set_weights(scene, 0, 1000, weights, 0), STILB_ERROR_ARGUMENT);
	step(scene, 0.0);
	assert_true(hash_shown(scene) == shown);
	stilb_scene_destroy(scene);
}

static int group_begin(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	write_picture("leaf.png");
	return 0;
}

static int group_end(void **state)
{
	remove("leaf.png");
	return glb_clear(state);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pauses_and_steps_equal_running),
		cmocka_unit_test(figures_stand_where_they_are_put),
		cmocka_unit_test(figures_have_the_flags_of_the_file),
		cmocka_unit_test(places_change_no_bit_of_a_shape),
		cmocka_unit_test(joints_can_hang_elsewhere),
		cmocka_unit_test(clips_move_what_hangs_elsewhere),
		cmocka_unit_test(places_follow_from_the_topmost),
		cmocka_unit_test(joints_reach_what_they_carry),
		cmocka_unit_test(figures_come_and_go_while_they_play),
		cmocka_unit_test(clips_have_any_length),
		cmocka_unit_test(files_have_many_nodes),
		cmocka_unit_test(mistakes_are_named),
	};
	return cmocka_run_group_tests(tests, group_begin, group_end);
}
