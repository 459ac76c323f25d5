/* Clips in an engine: frames move them by their number, a pause and steps come to the same poses, keys and the window
 * of clips do what they say, and the program's own poses count. */
#include "engine.h"
#include "scene/play/scene_play.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIGURES 3u
#define MODELS 4u

typedef struct stage {
	stilb_engine *engine;
	stilb_scene *scene;
} stage;

static stage stage_open(uint32_t workers, stilb_engine_update_fn *update, void *user)
{
	stage s;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = workers;
	desc.profile = false;
	desc.width = 320;
	desc.height = 240;
	desc.update = update;
	desc.user = user;
	assert_int_equal(stilb_scene_create_stress(MODELS, 7, &s.scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_figures(s.scene, FIGURES), STILB_OK);
	assert_int_equal(stilb_engine_create(&desc, &s.engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	return s;
}

static void stage_close(stage *s)
{
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
}

static void stage_frame(const stage *s)
{
	stilb_engine_report report;
	assert_int_equal(stilb_engine_frame(s->engine, &report), STILB_OK);
}

/* A frame in which this happened in the window. */
static void stage_frame_with(const stage *s, stilb_window_state state)
{
	state.width = 320;
	state.height = 240;
	state.focused = true;
	assert_int_equal(stilb_engine_input(s->engine, &state), STILB_OK);
	stage_frame(s);
	assert_int_equal(stilb_engine_input(s->engine, &(stilb_window_state){.width = 320, .height = 240, .focused = true}),
	                 STILB_OK);
}

static void stage_type(const stage *s, uint32_t character)
{
	stage_frame_with(s, (stilb_window_state){.typed = {character}, .typed_count = 1});
}

static void stage_press(const stage *s, stilb_window_key key)
{
	stilb_window_state state = {0};
	state.pressed[key] = 1;
	state.held[key] = true;
	stage_frame_with(s, state);
}

static double time_of(const stage *s, uint32_t figure)
{
	uint32_t count;
	const stilb_scene_play *plays = stilb_scene_plays_of(s->scene, figure, &count);
	assert_int_equal(count, 1);
	return plays[0].time;
}

/* Seconds in the clip of the figures, which begins anew. */
static double wrapped(double seconds)
{
	double duration = (double)1.1f;
	return seconds - duration * floor(seconds / duration);
}

static uint64_t poses_of(const stage *s)
{
	uint64_t hash = 14695981039346656037u;
	for (uint32_t m = 0; m < s->scene->mesh_count; m++) {
		const unsigned char *bytes = (const unsigned char *)s->scene->meshes[m].vertices;
		for (size_t i = 0; i < s->scene->meshes[m].vertex_count * sizeof(stilb_scene_vertex); i++)
			hash = (hash ^ bytes[i]) * 1099511628211u;
	}
	return hash;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static void frames_move_clips_by_their_number(void **state)
{
	(void)state;
	stage s = stage_open(1, NULL, NULL);
	double begin[FIGURES + 1];
	for (uint32_t f = 1; f <= FIGURES; f++)
		begin[f] = time_of(&s, f);
	uint64_t before = 0;
	for (int frame = 0; frame < 100; frame++) {
		stage_frame(&s);
		for (uint32_t f = 1; f <= FIGURES; f++)
			assert_true(fabs(time_of(&s, f) - wrapped(begin[f] + frame / 60.0)) < 1e-9 ||
			            fabs(fabs(time_of(&s, f) - wrapped(begin[f] + frame / 60.0)) - 1.1) < 1e-6);
		uint64_t now = poses_of(&s);
		assert_true(now != before); /* all vertices follow in that frame */
		before = now;
	}
	stage_close(&s);
}

static void the_same_bits_for_any_number_of_workers(void **state)
{
	(void)state;
	uint64_t poses[3];
	static const uint32_t workers[3] = {0, 1, 4};
	for (int w = 0; w < 3; w++) {
		stage s = stage_open(workers[w], NULL, NULL);
		for (int frame = 0; frame < 7; frame++)
			stage_frame(&s);
		poses[w] = poses_of(&s);
		stage_close(&s);
	}
	assert_true(poses[0] == poses[1] && poses[1] == poses[2]);
}

static void a_pause_and_steps_equal_running(void **state)
{
	(void)state;
	stage runs = stage_open(1, NULL, NULL), steps = stage_open(1, NULL, NULL);
	stage_frame(&runs);
	stage_frame(&steps);
	stilb_engine_set_pace(steps.engine, 0.0f);
	for (int frame = 1; frame < 12; frame++) {
		uint64_t still = poses_of(&steps);
		stage_frame(&steps); /* a paused frame changes nothing */
		assert_true(poses_of(&steps) == still);
		assert_int_equal(stilb_scene_play_counts_of(steps.scene).sampled, 0);
		stilb_engine_step(steps.engine, (frame + 1) / 60.0 - frame / 60.0);
		stage_frame(&runs);
		stage_frame(&steps);
		assert_true(fabs(time_of(&steps, 1) - time_of(&runs, 1)) < 1e-12);
	}
	/* Back by the same steps, and on as fast again. */
	stilb_engine_step(steps.engine, -5.0 / 60.0);
	stage_frame(&steps);
	assert_true(fabs(wrapped(time_of(&steps, 1) + 5.0 / 60.0) - time_of(&runs, 1)) < 1e-9);
	stilb_engine_set_pace(steps.engine, 2.0f);
	double at = time_of(&steps, 1);
	stage_frame(&steps);
	assert_true(fabs(time_of(&steps, 1) - wrapped(at + 2.0 / 60.0)) < 1e-9);
	stage_close(&runs);
	stage_close(&steps);
}

static void another_scene_begins_at_its_beginning(void **state)
{
	(void)state;
	stage s = stage_open(0, NULL, NULL), other = stage_open(0, NULL, NULL);
	double begin = time_of(&other, 1);
	for (int frame = 0; frame < 9; frame++)
		stage_frame(&s);
	assert_int_equal(stilb_engine_set_scene(s.engine, other.scene), STILB_OK);
	stage_frame(&s);
	assert_true(time_of(&other, 1) == begin);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	stage_close(&other);
	stage_close(&s);
}

/* ---- the user ---------------------------------------------------------------------------------------------------- */

static void keys_pause_and_step(void **state)
{
	(void)state;
	stage s = stage_open(1, NULL, NULL);
	stage_frame(&s);
	stage_press(&s, STILB_WINDOW_KEY_SPACE); /* that frame still moves: keys come before clips, so it does not */
	assert_true(stilb_engine_pace(s.engine) == 0.0f);
	double at = time_of(&s, 1);
	stage_frame(&s);
	assert_true(time_of(&s, 1) == at);
	stage_type(&s, '.');
	assert_true(fabs(time_of(&s, 1) - wrapped(at + 1.0 / 60.0)) < 1e-9);
	stage_type(&s, ',');
	stage_type(&s, ',');
	assert_true(fabs(wrapped(time_of(&s, 1) + 1.0 / 60.0) - wrapped(at)) < 1e-9);
	stage_press(&s, STILB_WINDOW_KEY_SPACE);
	assert_true(stilb_engine_pace(s.engine) == 1.0f);
	stage_close(&s);
}

/* Looks for a place of the window of clips whose click changes what figure 0 plays. */
static bool click_changes(const stage *s, float x, float y)
{
	uint32_t before, after;
	stilb_scene_plays_of(s->scene, 0, &before);
	stilb_window_state state = {.pointer = true, .pointer_x = x, .pointer_y = y};
	stage_frame_with(s, state);
	state.button = true;
	state.clicks = 1;
	stage_frame_with(s, state);
	state.button = false;
	state.clicks = 0;
	stage_frame_with(s, state);
	stage_frame_with(s, state);
	stilb_scene_plays_of(s->scene, 0, &after);
	return before != after;
}

static void the_window_of_clips_starts_and_ends_one(void **state)
{
	(void)state;
	stage s = stage_open(1, NULL, NULL);
	uint32_t count;
	stilb_scene_plays_of(s.scene, 0, &count);
	assert_int_equal(count, 0); /* the file's own figure stands still */
	stage_frame(&s);
	stage_press(&s, STILB_WINDOW_KEY_F4);
	stage_frame(&s);
	float found = -1.0f; /* the row of the only clip */
	for (float y = 230.0f; y > 60.0f && found < 0.0f; y -= 6.0f)
		found = click_changes(&s, 24.0f, y) ? y : -1.0f;
	assert_true(found > 0.0f);
	const stilb_scene_play *plays = stilb_scene_plays_of(s.scene, 0, &count);
	assert_int_equal(count, 1);
	assert_true(plays[0].clip == 0 && plays[0].weight == 1.0f);
	assert_true(click_changes(&s, 24.0f, found));
	stilb_scene_plays_of(s.scene, 0, &count);
	assert_int_equal(count, 0);
	stage_press(&s, STILB_WINDOW_KEY_F4); /* closed again, the click reaches nothing */
	stage_frame(&s);
	assert_false(click_changes(&s, 24.0f, found));
	stage_close(&s);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

typedef struct program {
	stilb_scene *scene;
	uint32_t node;
	stilb_scene_pose pose;
} program;

static void program_update(void *user, const stilb_engine_update *update)
{
	program *p = user;
	(void)update;
	if (p->scene)
		assert_int_equal(stilb_scene_set_node_pose(p->scene, p->node, &p->pose), STILB_OK);
}

static void poses_of_the_program_count(void **state)
{
	(void)state;
	program p = {0};
	stage s = stage_open(1, program_update, &p);
	stage_frame(&s);
	p.scene = s.scene;
	p.node = stilb_scene_figure_node(s.scene, 1, 1); /* the hips, which the clip moves, too */
	assert_int_not_equal(p.node, STILB_SCENE_NONE);
	p.pose = s.scene->nodes.pose[p.node];
	p.pose.translation[1] += 5.0f;
	float highest = 0.0f, before = 0.0f;
	uint32_t model = s.scene->model_count - FIGURES;
	before = s.scene->bounds.y[model] + s.scene->bounds.radius[model];
	stage_frame(&s);
	highest = s.scene->bounds.y[model] + s.scene->bounds.radius[model];
	assert_true(highest > before + 4.0f); /* bounds hold the pose */
	p.scene = NULL;
	stage_frame(&s);
	assert_true(s.scene->bounds.y[model] + s.scene->bounds.radius[model] < before + 1.0f);
	stage_close(&s);
}

static void figures_that_look_small_wait(void **state)
{
	(void)state;
	stage s = stage_open(1, NULL, NULL);
	stilb_scene_rates rates = {.angle = 1e3f};
	assert_int_equal(stilb_scene_set_rates(s.scene, &rates), STILB_OK);
	stage_frame(&s);
	uint32_t sampled = 0;
	for (int frame = 0; frame < 16; frame++) {
		stage_frame(&s);
		stilb_scene_play_counts counts = stilb_scene_play_counts_of(s.scene);
		assert_int_equal(counts.sampled + counts.waiting, FIGURES);
		sampled += counts.sampled;
	}
	assert_int_equal(sampled, 2 * FIGURES); /* each eighth frame */
	rates = (stilb_scene_rates){.still = 1e3f};
	assert_int_equal(stilb_scene_set_rates(s.scene, &rates), STILB_OK);
	stage_frame(&s);
	stilb_scene_play_counts counts = stilb_scene_play_counts_of(s.scene);
	assert_int_equal(counts.sampled, FIGURES);
	assert_true(counts.channels == 0 && counts.still > 0);
	rates.still = NAN;
	assert_int_equal(stilb_scene_set_rates(s.scene, &rates), STILB_ERROR_ARGUMENT);
	stage_close(&s);
}

/* A lamp in a figure's hand is moved however small the figure looks; so is all between it and the hips, and no more. */
static void what_carries_a_light_never_stands_still(void **state)
{
	(void)state;
	stage s = stage_open(0, NULL, NULL);
	stilb_scene_rates rates = {.still = 1e3f};
	assert_int_equal(stilb_scene_attach_light(s.scene, 0, stilb_scene_figure_node(s.scene, 0, 5)), STILB_OK);
	assert_int_equal(stilb_scene_set_rates(s.scene, &rates), STILB_OK);
	stage_frame(&s);
	assert_true(stilb_scene_play_counts_of(s.scene).still == 0); /* other plays take hold in all nodes */
	stage_frame(&s);
	stilb_scene_play_counts counts = stilb_scene_play_counts_of(s.scene);
	assert_int_equal(counts.channels, FIGURES * 5); /* hand, arm, chest, and two channels of the hips */
	assert_int_equal(counts.channels + counts.still, FIGURES * 12);
	stage_close(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(frames_move_clips_by_their_number),
		cmocka_unit_test(the_same_bits_for_any_number_of_workers),
		cmocka_unit_test(a_pause_and_steps_equal_running),
		cmocka_unit_test(another_scene_begins_at_its_beginning),
		cmocka_unit_test(keys_pause_and_step),
		cmocka_unit_test(the_window_of_clips_starts_and_ends_one),
		cmocka_unit_test(poses_of_the_program_count),
		cmocka_unit_test(figures_that_look_small_wait),
		cmocka_unit_test(what_carries_a_light_never_stands_still),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
