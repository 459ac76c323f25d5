/* The lights' window: F5 opens it, a light is picked in its list, put out and lit again, moved, coloured, shown alone,
 * taken back, and saved beside the scene's file, as its controls say. */
#include "engine.h"
#include "engine_internal.h"
#include "scene/edit/scene_edit.h"
#include "support/folder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 400u
#define HEIGHT 600u
#define LAMPS 5u

typedef struct stage {
	stilb_engine *engine;
	stilb_scene *scene;
} stage;

static stage stage_of(stilb_scene *scene)
{
	stage s = {.scene = scene};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.profile = false;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	assert_int_equal(stilb_engine_create(&desc, &s.engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	return s;
}

static stage stage_open(void)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(9, 7, &scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(scene, LAMPS), STILB_OK);
	return stage_of(scene);
}

static void stage_close(stage *s)
{
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
}

/* A frame in which this happened in the window. */
static void stage_frame_with(const stage *s, stilb_window_state state)
{
	stilb_engine_report report;
	state.width = WIDTH;
	state.height = HEIGHT;
	state.focused = true;
	assert_int_equal(stilb_engine_input(s->engine, &state), STILB_OK);
	assert_int_equal(stilb_engine_frame(s->engine, &report), STILB_OK);
}

static void stage_press(const stage *s, stilb_window_key key)
{
	stilb_window_state state = {0};
	state.pressed[key] = 1;
	state.held[key] = true;
	stage_frame_with(s, state);
	stage_frame_with(s, (stilb_window_state){0});
}

/* Presses the button at (x, y), drags to the right by `drag` pixels and lets go. */
static void stage_drag(const stage *s, float x, float y, float drag)
{
	stilb_window_state state = {.pointer = true, .pointer_x = x, .pointer_y = y};
	stage_frame_with(s, state);
	state.button = true;
	state.clicks = 1;
	stage_frame_with(s, state);
	state.clicks = 0;
	state.pointer_x += drag;
	stage_frame_with(s, state);
	state.button = false;
	stage_frame_with(s, state);
	stage_frame_with(s, state);
}

/* The first light whose bytes differ; the count: none. */
static uint32_t changed(const stage *s, const stilb_scene_light *before)
{
	uint32_t i = 0;
	while (i < s->scene->light_count && memcmp(&before[i], &s->scene->lights[i], sizeof *before) == 0)
		i++;
	return i;
}

/* Picks a light by its row, a click somewhere in the list, and finds the controls by what dragging at each height
 * changes: [0] on, [1] intensity, [2] temperature, [3..5] colour, [6..8] place. They lie one below the other. */
typedef struct controls {
	float y[9];
	uint32_t light;
} controls;

static bool is_dark(const stilb_scene_light *light)
{
	return !(light->intensity[0] > 0.0f || light->intensity[1] > 0.0f || light->intensity[2] > 0.0f);
}

static controls find_controls(const stage *s, float row_y)
{
	controls found = {.light = UINT32_MAX};
	stilb_scene_light before[LAMPS + 1];
	uint32_t count = 0;
	float last = 0.0f;
	stage_drag(s, 60.0f, row_y, 0.0f);
	for (float y = row_y; y < 560.0f && count < 9; y += 4.0f) {
		memcpy(before, s->scene->lights, s->scene->light_count * sizeof *before);
		stage_drag(s, count == 0 ? 22.0f : 120.0f, y, count == 0 ? 0.0f : 31.0f);
		uint32_t light = changed(s, before);
		if (light == s->scene->light_count)
			continue;
		memcpy(s->scene->lights, before, s->scene->light_count * sizeof *before);
		stilb_scene_move_light(s->scene, light, before[light].position); /* also on its node */
		stage_frame_with(s, (stilb_window_state){0});
		if (count > 0 && y - last < 20.0f)
			continue;
		last = y;
		found.light = light;
		found.y[count++] = y + 4.0f;
	}
	assert_int_equal(count, 9);
	return found;
}

static void controls_do_what_they_say(void **state)
{
	(void)state;
	stage s = stage_open();
	stilb_scene_light before[LAMPS + 1];
	stage_frame_with(&s, (stilb_window_state){0});
	stage_press(&s, STILB_WINDOW_KEY_F5);
	controls c = find_controls(&s, 60.0f);
	stilb_scene_light *light = &s.scene->lights[c.light];
	memcpy(before, s.scene->lights, sizeof before);
	const stilb_scene_light *was = &before[c.light];
	stage_drag(&s, 22.0f, c.y[0], 0.0f); /* out */
	assert_true(is_dark(light));
	stage_drag(&s, 22.0f, c.y[0], 0.0f); /* and on, as it was */
	for (int i = 0; i < 3; i++)
		assert_true(fabsf(light->intensity[i] - was->intensity[i]) <= 1e-6f * was->intensity[0]);
	stage_drag(&s, 120.0f, c.y[1], 31.0f); /* another intensity of the same colour */
	assert_true(light->intensity[0] != was->intensity[0] && light->intensity[0] > 0.0f);
	for (int i = 1; i < 3; i++)
		assert_true(fabsf(light->intensity[i] * was->intensity[0] - was->intensity[i] * light->intensity[0]) <
		            1e-4f * light->intensity[0] * was->intensity[0]);
	float brightest = fmaxf(light->intensity[0], fmaxf(light->intensity[1], light->intensity[2]));
	stage_drag(&s, 60.0f, c.y[2], 1.0f); /* warm, as bright in its brightest channel */
	assert_true(light->intensity[0] > light->intensity[1] && light->intensity[1] > light->intensity[2]);
	assert_true(fabsf(light->intensity[0] - brightest) < 1e-5f * brightest);
	assert_memory_equal(light->position, was->position, sizeof was->position);
	for (int i = 0; i < 3; i++) { /* one coordinate each */
		stilb_scene_light now = *light;
		stage_drag(&s, 120.0f, c.y[6 + i], 31.0f);
		for (int k = 0; k < 3; k++)
			assert_true((light->position[k] != now.position[k]) == (k == i));
	}
	for (uint32_t i = 0; i <= LAMPS; i++) /* no other light */
		assert_true(i == c.light || memcmp(&before[i], &s.scene->lights[i], sizeof *before) == 0);
	stage_press(&s, STILB_WINDOW_KEY_F5); /* closed again, a drag reaches nothing */
	memcpy(before, s.scene->lights, sizeof before);
	stage_drag(&s, 120.0f, c.y[1], 31.0f);
	assert_int_equal(changed(&s, before), s.scene->light_count);
	stage_close(&s);
}

/* The stream's hash has the lights that a frame shows. */
static uint64_t shown(const stage *s)
{
	stage_frame_with(s, (stilb_window_state){0});
	return stilb_engine_stream_hash(s->engine);
}

static void a_light_alone(void **state)
{
	(void)state;
	stage s = stage_open();
	stage_frame_with(&s, (stilb_window_state){0});
	stage_press(&s, STILB_WINDOW_KEY_F5);
	controls c = find_controls(&s, 60.0f);
	uint64_t all = shown(&s);
	stage_drag(&s, 190.0f, c.y[0], 0.0f);
	uint64_t alone = shown(&s);
	assert_true(alone != all);
	stilb_scene_light one = s.scene->lights[c.light];
	assert_int_equal(stilb_scene_set_lights(s.scene, &one, 1), STILB_OK);
	stage_press(&s, STILB_WINDOW_KEY_F5); /* all lights that there are, now */
	assert_true(shown(&s) == alone);
	stage_close(&s);
}

/* A file with a lamp. */
static void write_scene(void)
{
	FILE *file = fopen("lamp.gltf", "w");
	assert_non_null(file);
	fputs(
		"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0},{\"translation\":[0,2,"
		"0],"
		"\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
		"{\"type\":\"point\",\"intensity\":40}]}},\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
		"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"bufferViews\":["
		"{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
		"octet-stream;base64,"
		"AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
		file);
	assert_int_equal(fclose(file), 0);
}

static void changes_are_saved_and_taken_back(void **state)
{
	(void)state;
	stilb_scene *scene, *again;
	write_scene();
	assert_int_equal(stilb_scene_open("lamp.gltf", &scene), STILB_OK);
	stage s = stage_of(scene);
	stage_frame_with(&s, (stilb_window_state){0});
	stage_press(&s, STILB_WINDOW_KEY_F5);
	controls c = find_controls(&s, 42.0f);
	stage_drag(&s, 120.0f, c.y[1], 31.0f);
	stage_drag(&s, 120.0f, c.y[7], 31.0f);
	stilb_scene_light want = s.scene->lights[0];
	float below = c.y[8] + (c.y[8] - c.y[7]);
	for (float y = below - 8.0f; y <= below + 8.0f && access("lamp.gltf.lights.json", F_OK) != 0; y += 4.0f)
		stage_drag(&s, 250.0f, y, 0.0f);
	assert_int_equal(stilb_scene_open("lamp.gltf", &again), STILB_OK);
	assert_memory_equal(again->lights[0].intensity, want.intensity, sizeof want.intensity);
	assert_memory_equal(again->lights[0].position, want.position, sizeof want.position);
	assert_true(want.intensity[0] != 40.0f && want.position[1] != 2.0f);
	stilb_scene_destroy(again);
	for (float y = below - 8.0f; y <= below + 8.0f && s.scene->lights[0].intensity[0] != 40.0f; y += 4.0f)
		stage_drag(&s, 80.0f, y, 0.0f);
	assert_true(s.scene->lights[0].intensity[0] == 40.0f && s.scene->lights[0].position[1] == 2.0f);
	stage_close(&s);
	remove("lamp.gltf.lights.json");
	remove("lamp.gltf");
}

/* Three lamps of each figure hang on its head and hands and go with them; lamps over the tiles stay their own. */
static void figures_carry_lamps(void **state)
{
	(void)state;
	enum { FIGURES = 4, CARRIED = FIGURES * STILB_SCENE_CARRIED };
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(9, 7, &scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_figures(scene, FIGURES), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(scene, LAMPS), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_carried(scene), STILB_OK);
	stage s = stage_of(scene);
	stilb_scene_light before[1 + LAMPS + CARRIED];
	uint32_t moved = 0;
	for (int frame = 0; frame < 12; frame++) {
		stage_frame_with(&s, (stilb_window_state){0});
		stilb_scene_stress_set_light(scene, STILB_SCENE_STRESS_LIGHT_NIGHT); /* as stilb demo does each frame */
		assert_int_equal(scene->light_count, 1 + LAMPS + CARRIED);
		for (uint32_t i = 0; i < CARRIED; i++) {
			const stilb_scene_light *lamp = &scene->lights[1 + LAMPS + i];
			const stilb_scene_mount *mount = &scene->light_mounts[1 + LAMPS + i];
			uint32_t joint = i % 3 == 0 ? 3 : i % 3 == 1 ? 5 : 7; /* head, left hand, right hand */
			assert_null(stilb_scene_light_mistake(lamp));
			assert_int_equal(mount->node, 1 + stilb_scene_figure_node(scene, 1 + i / 3, joint));
			const float *m = scene->nodes.to_world[mount->node - 1].m, *p = mount->position;
			for (int k = 0; k < 3; k++)
				assert_true(fabsf(lamp->position[k] - (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k])) <
				            1e-5f);
			assert_true(i % 3 == 0 ? lamp->position[1] > 0.8f : lamp->position[1] < 0.7f);
			moved += frame > 0 && memcmp(lamp->position, before[1 + LAMPS + i].position, sizeof lamp->position) != 0;
		}
		memcpy(before, scene->lights, sizeof before);
	}
	assert_true(moved > 11 * CARRIED / 2);
	for (uint32_t i = 0; i <= LAMPS; i++)
		assert_int_equal(scene->light_mounts[i].node, 0);
	stage_close(&s);
}

/* How bright surfaces can be is read again only if a material, a surface or the shading has changed. */
static void the_peak_is_kept(void **state)
{
	(void)state;
	stilb_engine_report report;
	stage s = stage_open();
	stilb_engine *engine = s.engine;
	stilb_render_shading shading = stilb_engine_shading(engine);
	stilb_engine_set_light_tolerance(engine, 0.1f);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	float first = engine->views[0].light_peak;
	assert_true(first == stilb_render_light_peak(s.scene, &shading));
	engine->peak.value = 7.0f; /* what is not read again stays */
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(engine->views[0].light_peak == 7.0f);
	stilb_scene_material material = s.scene->materials[0];
	material.roughness = 0.02f;
	stilb_engine_set_light_tolerance(engine, 0.0f); /* a change that no peak is asked for */
	assert_int_equal(stilb_scene_set_material(s.scene, 0, &material), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	stilb_engine_set_light_tolerance(engine, 0.1f);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	float second = engine->views[0].light_peak;
	assert_true(second == stilb_render_light_peak(s.scene, &shading) && second > 2.0f * first);
	shading.roughness = 0.5f;
	stilb_engine_set_shading(engine, &shading);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(engine->views[0].light_peak == stilb_render_light_peak(s.scene, &shading));
	assert_true(engine->views[0].light_peak < second);
	stage_close(&s);
}

/* Temporal antialiasing moves what is drawn by parts of a pixel, and no light for it: the streams of frames are those
 * without, though lights lie at the edge of the view, and some fade. */
static void jitter_moves_no_light(void **state)
{
	(void)state;
	enum { FRAMES = 3, MANY = 400 };
	uint64_t hashes[2][FRAMES];
	for (int jitters = 0; jitters < 2; jitters++) {
		stilb_engine_desc desc = stilb_engine_desc_default();
		desc.device = STILB_RENDER_DEVICE_NULL;
		desc.profile = false;
		desc.width = 64;
		desc.height = 40;
		desc.light_fade = 3.0f;
		desc.post.aa = jitters ? STILB_POST_AA_TEMPORAL : STILB_POST_AA_NONE;
		stage s = {0};
		stilb_engine_report report;
		assert_int_equal(stilb_engine_create(&desc, &s.engine), STILB_OK);
		assert_int_equal(stilb_scene_create_stress(400, 7, &s.scene), STILB_OK);
		assert_int_equal(stilb_scene_stress_add_lamps(s.scene, MANY), STILB_OK);
		assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
		for (int frame = 0; frame < FRAMES; frame++) {
			assert_int_equal(stilb_engine_frame(s.engine, &report), STILB_OK);
			hashes[jitters][frame] = stilb_engine_stream_hash(s.engine);
			assert_int_equal(s.engine->views[0].jitter[0] != 0.0f, jitters);
		}
		stage_close(&s);
	}
	assert_memory_equal(hashes[0], hashes[1], sizeof hashes[0]);
}

static int lights_leave(void **state)
{
	(void)state;
	return folder_remove();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(controls_do_what_they_say),
		cmocka_unit_test(a_light_alone),
		cmocka_unit_test(changes_are_saved_and_taken_back),
		cmocka_unit_test(figures_carry_lamps),
		cmocka_unit_test(the_peak_is_kept),
		cmocka_unit_test(jitter_moves_no_light),
	};
	return cmocka_run_group_tests_name("engine_lights", tests, folder_make, lights_leave);
}
