/* SCENE.lights.json: what it says of a file's lights is what the opened scene has, what is changed is saved and read
 * back bit for bit, lights can be taken back to what their file has, and each damaged file is refused by its name. */
#include "scene/open/scene_lights.h"

#include "glb_made.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/scene_look.h"
#include "shading/shade_luminance.h"

#include <locale.h>
#include <sys/stat.h>

#define LIGHTS_FILE "test.glb.lights.json"
#define HUNG(LIGHT, REST) "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":" #LIGHT "}}" REST "}"

/* A lamp at (0, 3, 0), a spot that hangs on a node which is turned by half about y and twice as large, and a sun. */
static const char scene_json[] = "\"nodes\":[{\"mesh\":0}," HUNG(0, ",\"translation\":[0,3,0]") "," HUNG(
	1, ",\"translation\":[1,2,3],\"rotation\":["
	   "0,1,0,0],\"scale\":[2,2,2]") "," HUNG(2, "") "],\"scenes\":[{\"nodes\":[0,1,2,3]}]," TRIANGLE
													 ",\"accessors\":[" VEC3(
														 0) "],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
															"{\"type\":\"point\",\"intensity\":40,\"range\":9,"
															"\"color\":[1,0.5,0.25]},"
															"{\"type\":\"spot\",\"intensity\":80,\"spot\":{}},"
															"{\"type\":\"directional\",\"intensity\":3}]}}";

static void write_lights(const char *text)
{
	write_file(LIGHTS_FILE, text, strlen(text));
}

static stilb_scene *open_lit(const char *lights)
{
	if (lights)
		write_lights(lights);
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(scene_json);
	assert_int_equal(scene->light_count, 3);
	return scene;
}

static void assert_light(const stilb_scene *scene, uint32_t light, const float intensity[3], const float position[3])
{
	assert_numbers(scene->lights[light].intensity, intensity, 3);
	if (position)
		assert_numbers(scene->lights[light].position, position, 3);
}

static void a_scene_without_a_file_is_as_it_is(void **state)
{
	(void)state;
	stilb_scene *scene = open_lit(NULL);
	assert_null(strstr(said, "lights.json"));
	assert_light(scene, 0, (const float[]){40, 20, 10}, (const float[]){0, 3, 0});
	assert_light(scene, 1, (const float[]){80, 80, 80}, (const float[]){1, 2, 3});
	assert_light(scene, 2, (const float[]){3, 3, 3}, NULL);
	stilb_scene_destroy(scene);
}

static void a_file_says_what_lights_are(void **state)
{
	(void)state;
	stilb_scene *scene = open_lit(
		"{\"lights\": [{\"light\": 0, \"kind\": \"point\", \"unit\": \"cd\", \"place\": [4, 5, 6]},\n"
		"{\"light\": 2, \"unit\": \"lx\", \"color\": [0, 4, 2]},"
		"{\"light\": 1, \"kind\": \"spot\", \"intensity\": 7.5, \"temperature\": 2856, \"place\": [0.5, 1, 0.25]}]}");
	assert_said(LIGHTS_FILE ": 3 lights as this file has them");
	assert_light(scene, 0, (const float[]){40, 20, 10}, (const float[]){4, 8, 6});
	assert_light(scene, 2, (const float[]){0, 3, 1.5f}, NULL);
	stilb_vec3 glow = shade_color_of_temperature(2856.0f) * 7.5f;
	assert_light(scene, 1, (const float[]){7.5f, glow[1], glow[2]}, (const float[]){0, 4, 2.5f}); /* turned, doubled */
	stilb_scene_lights_restore(scene, 0);
	stilb_scene_lights_restore(scene, 1);
	assert_light(scene, 0, (const float[]){40, 20, 10}, (const float[]){0, 3, 0});
	assert_light(scene, 1, (const float[]){80, 80, 80}, (const float[]){1, 2, 3});
	stilb_scene_destroy(scene);
	assert_int_equal(open_file("test.glb", true, &scene), STILB_OK);
	assert_null(strstr(said, "lights.json"));
	stilb_scene_destroy(scene);
	remove(LIGHTS_FILE);
}

static void what_is_changed_comes_back(void **state)
{
	(void)state;
	static const float place[3] = {0.1f, -2e-7f, 3e4f}, lamp[3] = {1.0f / 3.0f, 1e-9f, 0.0f}, out[3] = {0, 0, 0};
	const char *path;
	stilb_scene *scene = open_lit(NULL), *again;
	assert_int_equal(stilb_scene_lights_save(scene, &path), STILB_OK); /* nothing */
	assert_true(stilb_scene_move_light(scene, 1, place));
	assert_numbers(scene->lights[1].position, place, 3);
	assert_numbers(scene->light_mounts[1].position, (const float[]){0.45f, -1.0f, -14998.5f}, 3);
	memcpy(scene->lights[0].intensity, lamp, sizeof lamp);
	memcpy(scene->lights[2].intensity, out, sizeof out); /* put out */
	setlocale(LC_ALL, "de_DE.UTF-8");                    /* where there is one, whose point is a comma */
	assert_int_equal(stilb_scene_lights_save(scene, &path), STILB_OK);
	assert_non_null(strstr(path, LIGHTS_FILE));
	assert_false(stilb_scene_lights_changed(scene));
	assert_int_equal(open_file("test.glb", false, &again), STILB_OK);
	assert_false(stilb_scene_lights_changed(again));
	setlocale(LC_ALL, "C");
	assert_said("3 lights");
	assert_memory_equal(again->lights[0].intensity, lamp, sizeof lamp);
	assert_memory_equal(again->lights[2].intensity, out, sizeof out);
	assert_memory_equal(again->lights[1].position, scene->lights[1].position, sizeof place);
	assert_memory_equal(again->lights[1].intensity, scene->lights[1].intensity, sizeof lamp);
	assert_memory_equal(&again->light_mounts[1], &scene->light_mounts[1], sizeof *scene->light_mounts);
	/* The node takes the light along. */
	stilb_scene_pose pose = again->nodes.pose[again->light_mounts[1].node - 1];
	pose.translation[1] += 10.0f;
	assert_int_equal(stilb_scene_set_node_pose(again, again->light_mounts[1].node - 1, &pose), STILB_OK);
	stilb_scene_update_nodes(again, NULL, 0);
	assert_true(near(again->lights[1].position[1], scene->lights[1].position[1] + 10.0f));
	/* Taken back and saved: nothing is left in the file. */
	for (uint32_t i = 0; i < 3; i++)
		stilb_scene_lights_restore(again, i);
	assert_int_equal(stilb_scene_lights_save(again, NULL), STILB_OK);
	assert_false(stilb_scene_lights_changed(again));
	assert_true(stilb_scene_lights_changed(scene)); /* which has not written that */
	stilb_scene_destroy(again);
	assert_int_equal(open_file("test.glb", false, &again), STILB_OK);
	assert_said("0 lights");
	assert_light(again, 0, (const float[]){40, 20, 10}, (const float[]){0, 3, 0});
	stilb_scene_destroy(again);
	stilb_scene_destroy(scene);
	remove(LIGHTS_FILE);
}

static void what_cannot_be_saved_is_refused(void **state)
{
	(void)state;
	stilb_scene *scene = open_lit(NULL);
	static const float far[3] = {0, 2e18f, 0};
	assert_false(stilb_scene_move_light(scene, 0, far));
	assert_false(stilb_scene_move_light(scene, 1, far));
	assert_false(stilb_scene_move_light(scene, 2, (const float[]){0, 0, 0})); /* the sun */
	assert_light(scene, 0, (const float[]){40, 20, 10}, (const float[]){0, 3, 0});
	assert_light(scene, 1, (const float[]){80, 80, 80}, (const float[]){1, 2, 3});
	/* Other lights, or lights that hang on no node any more, are not the file's, and are not taken back to it. */
	stilb_scene_light kept[3];
	memcpy(kept, scene->lights, sizeof kept);
	assert_int_equal(stilb_scene_set_lights(scene, kept, 3), STILB_OK);
	scene->lights[0].intensity[0] = 5.0f;
	assert_int_equal(stilb_scene_lights_save(scene, NULL), STILB_ERROR_ARGUMENT);
	stilb_scene_lights_restore(scene, 0);
	assert_true(scene->lights[0].intensity[0] == 5.0f);
	assert_int_equal(stilb_scene_set_lights(scene, scene->lights, 2), STILB_OK);
	assert_int_equal(stilb_scene_lights_save(scene, NULL), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "has 3"));
	stilb_scene_destroy(scene);
	assert_int_equal(stilb_scene_open("cornell", &scene), STILB_OK);
	assert_int_equal(stilb_scene_lights_save(scene, NULL), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "of none"));
	assert_false(stilb_scene_lights_changed(scene));
	stilb_scene_destroy(scene);
}

static void damaged_files_are_refused_by_name(void **state)
{
	(void)state;
	static const struct {
		const char *text, *words;
	} cases[] = {
		{"", "expected a value"},
		{"{\"lights\": [{\"light\": 0}", "line 1, column 25"},
		{"[]", "not of type object"},
		{"{}", "no list 'lights'"},
		{"{\"lights\": 3}", "not of type array"},
		{"{\"lights\": [{}]}", "which light"},
		{"{\"lights\": [7]}", "not of type object"},
		{"{\"lights\": [{\"light\": 3}]}", "the scene has 3"},
		{"{\"lights\": [{\"light\": -1}]}", "whole number"},
		{"{\"lights\": [{\"light\": 1}, {\"light\": 1}]}", "was there before"},
		{"{\"lights\": [{\"light\": 1, \"kind\": \"point\"}]}", "of another scene"},
		{"{\"lights\": [{\"light\": 1, \"unit\": \"lx\"}]}", "of another scene"},
		{"{\"lights\": [{\"light\": 1, \"intensity\": -1}]}", "'intensity' is no number"},
		{"{\"lights\": [{\"light\": 1, \"intensity\": \"4\"}]}", "'intensity' is no number"},
		{"{\"lights\": [{\"light\": 1, \"intensity\": 1e39}]}", "'intensity' is no number"},
		{"{\"lights\": [{\"light\": 1, \"temperature\": 900}]}", "1000 to 15000"},
		{"{\"lights\": [{\"light\": 1, \"temperature\": 2000, \"color\": [1,1,1]}]}", "leave one out"},
		{"{\"lights\": [{\"light\": 1, \"color\": [0,0,0]}]}", "one of them above 0"},
		{"{\"lights\": [{\"light\": 1, \"color\": [1,-1,0]}]}", "one of them above 0"},
		{"{\"lights\": [{\"light\": 1, \"color\": [1,1]}]}", "2 numbers instead of 3"},
		{"{\"lights\": [{\"light\": 1, \"place\": [1,1,2e18]}]}", "within 1e18"},
		{"{\"lights\": [{\"light\": 2, \"place\": [1,1,1]}]}", "has no place"},
		{"{\"lights\": [\n{\"light\": 1, \"colour\": [1,1,1]}]}", "line 2"},
		{"{\"lights\": [], \"extra\": 1}", "all that it may have"},
		{"{\"lights\": [], \"lights\": [{\"light\": 9}]}", "all that it may have"},
		{"{\"lights\": [{\"light\": 1, \"intensity\": 1, \"intensity\": 2}]}", "'intensity' was there before"},
		{"{\"lights\": [{\"light\": 1, \"light\": 2}]}", "'light' was there before"},
		{"{\"lights\": [{\"light\": 1, \"kind\": \"spot\\u0000x\"}]}", "of another scene"},
		{"{\"lights\": [{\"light\": 1,\n\"intensity\": "
	     "0.00000000000000000000000000000000000000000000000000000000000001}]}",
	     "line 2, column 14: expected a number of 63 signs at most"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		write_lights(cases[i].text);
		begin();
		put(triangle, sizeof triangle);
		assert_refused(scene_json, LIGHTS_FILE);
		if (!strstr(stilb_error_message(), cases[i].words))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), cases[i].words);
	}
	remove(LIGHTS_FILE);
	assert_int_equal(mkdir(LIGHTS_FILE, 0700), 0);
	assert_refused(scene_json, LIGHTS_FILE);
	assert_int_equal(rmdir(LIGHTS_FILE), 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_scene_without_a_file_is_as_it_is), cmocka_unit_test(a_file_says_what_lights_are),
		cmocka_unit_test(what_is_changed_comes_back),         cmocka_unit_test(what_cannot_be_saved_is_refused),
		cmocka_unit_test(damaged_files_are_refused_by_name),
	};
	return cmocka_run_group_tests_name("scene_lights", tests, folder_make, glb_clear);
}
