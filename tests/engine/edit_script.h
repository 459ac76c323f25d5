/* A scene and a program that edits it: the same edits in every run. */
#ifndef STILB_TEST_EDIT_SCRIPT_H
#define STILB_TEST_EDIT_SCRIPT_H

#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "support/test.h"

#include <math.h>

#define SCRIPT_MODELS 60u
#define SCRIPT_GRID 9u /* vertices along a side of the sheet that waves */

/* Random numbers of the script. */
typedef struct edit_script {
	uint64_t seed, index;
	uint32_t sheet; /* the mesh whose vertices change in each frame; another model may show it too */
} edit_script;

static inline uint32_t script_below(edit_script *script, uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(script->seed, script->index++) % bound);
}

static inline float script_between(edit_script *script, float low, float high)
{
	return low + (high - low) * stilb_random_float(script->seed, script->index++);
}

static inline stilb_mat4 script_place(edit_script *script)
{
	return stilb_mat4_scale_translate(script_between(script, 0.2f, 1.2f), script_between(script, -12.0f, 12.0f),
	                                  script_between(script, 0.0f, 3.0f), script_between(script, -12.0f, 12.0f));
}

static inline stilb_scene_material script_paint(edit_script *script, uint32_t texture)
{
	return (stilb_scene_material){
		.diffuse = {script_between(script, 0.2f, 0.9f), script_between(script, 0.2f, 0.9f), 0.4f},
		.roughness = 0.5f,
		.diffuse_texture = texture};
}

/* Row `row` of the sheet at a time, to the vertices given. */
static inline void script_sheet_row(uint32_t row, float time, stilb_scene_vertex *vertices)
{
	for (uint32_t i = 0; i < SCRIPT_GRID; i++) {
		float x = (float)i / (float)(SCRIPT_GRID - 1) * 2.0f - 1.0f,
			  z = (float)row / (float)(SCRIPT_GRID - 1) * 2.0f - 1.0f;
		vertices[i] = (stilb_scene_vertex){
			{x, 0.4f * sinf(3.0f * x + time), z}, {0.0f, 1.0f, 0.0f}, {0.5f * x + 0.5f, 0.5f * z + 0.5f}};
	}
}

static inline stilb_scene_mesh script_sheet(void)
{
	static stilb_scene_vertex vertices[SCRIPT_GRID * SCRIPT_GRID];
	static uint32_t indices[(SCRIPT_GRID - 1) * (SCRIPT_GRID - 1) * 6];
	uint32_t count = 0;
	for (uint32_t row = 0; row < SCRIPT_GRID; row++)
		script_sheet_row(row, 0.0f, vertices + (size_t)row * SCRIPT_GRID);
	for (uint32_t row = 0; row + 1 < SCRIPT_GRID; row++)
		for (uint32_t i = 0; i + 1 < SCRIPT_GRID; i++) {
			uint32_t a = row * SCRIPT_GRID + i, b = a + SCRIPT_GRID, quad[6] = {a, b, b + 1, a, b + 1, a + 1};
			for (int k = 0; k < 6; k++)
				indices[count++] = quad[k];
		}
	return (stilb_scene_mesh){
		.vertices = vertices, .indices = indices, .vertex_count = SCRIPT_GRID * SCRIPT_GRID, .index_count = count};
}

static inline stilb_image script_image(edit_script *script, uint32_t side)
{
	static uint8_t pixels[16 * 16 * 3];
	for (uint32_t i = 0; i < side * side * 3; i++)
		pixels[i] = (uint8_t)script_below(script, 256);
	return (stilb_image){.pixels = pixels, .width = side, .height = side, .channels = 3, .format = STILB_IMAGE_U8_SRGB};
}

/* Balls and sheets under a sky, seen from above. */
static inline stilb_scene *script_begin(edit_script *script, uint64_t seed)
{
	stilb_scene_mesh ball, sheet = script_sheet();
	stilb_scene *scene;
	*script = (edit_script){.seed = seed};
	stilb_image image = script_image(script, 8);
	assert_int_equal(stilb_scene_mesh_sphere(1, &ball), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t ball_mesh = stilb_scene_build_mesh(build, &ball), texture = stilb_scene_build_texture(build, &image);
	script->sheet = stilb_scene_build_mesh(build, &sheet);
	stilb_scene_material plain = script_paint(script, 0), textured = script_paint(script, texture + 1);
	uint32_t paints[2] = {stilb_scene_build_material(build, &plain), stilb_scene_build_material(build, &textured)};
	for (uint32_t m = 0; m < SCRIPT_MODELS; m++) {
		stilb_mat4 place = script_place(script);
		stilb_scene_build_part parts[2] = {{m % 4 == 0 ? script->sheet : ball_mesh, paints[m % 2]},
		                                   {ball_mesh, paints[0]}};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), parts, 1 + m % 2);
	}
	stilb_scene_camera camera = {
		.position = {0.0f, 9.0f, 14.0f}, .pitch = -0.6f, .fov_y = 0.9f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.8f, 0.0f}, .intensity = {1.5f, 1.4f, 1.2f}};
	stilb_scene_build_camera(build, &camera);
	stilb_scene_build_light(build, &sun);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_scene_mesh_finish(&ball);
	scene->surroundings = (stilb_scene_surroundings){.sky = {0.8f, 0.9f, 1.0f}, .ground = {0.2f, 0.2f, 0.2f}};
	return scene;
}

/* ---- edits ------------------------------------------------------------------------------------------------------- */

/* An edit may be refused, because it names what is not there or is in use; it may not fail otherwise. */
static inline void script_note(stilb_result result)
{
	assert_true(result == STILB_OK || result == STILB_ERROR_ARGUMENT);
}

static inline void script_edit_model(edit_script *script, stilb_scene *scene)
{
	uint32_t model = script_below(script, scene->model_count), id, kind = script_below(script, 8);
	stilb_mat4 place = script_place(script);
	stilb_scene_build_part parts[2] = {
		{script_below(script, scene->mesh_count), script_below(script, scene->material_count)},
		{script_below(script, scene->mesh_count), script_below(script, scene->material_count)}};
	if (kind < 2)
		script_note(stilb_scene_add_model(scene, &place, parts, 1 + script_below(script, 2), &id));
	else if (kind < 3)
		script_note(stilb_scene_remove_model(scene, model));
	else if (kind < 5)
		script_note(stilb_scene_show_model(scene, model, script_below(script, 2)));
	else if (kind < 6)
		script_note(stilb_scene_set_part(scene, model, 0, parts[0]));
	else
		script_note(stilb_scene_set_transform(scene, model, &place));
}

static inline void script_edit_resource(edit_script *script, stilb_scene *scene)
{
	uint32_t id, mesh = script_below(script, scene->mesh_count), material = script_below(script, scene->material_count);
	uint32_t texture = script_below(script, scene->texture_count), kind = script_below(script, 9);
	stilb_scene_mesh sheet = script_sheet();
	stilb_image image = script_image(script, script_below(script, 2) ? 8 : 16);
	stilb_scene_material paint = script_paint(script, script_below(script, scene->texture_count + 1));
	sheet.index_count -= 6 * script_below(script, 20);
	switch (kind) {
	case 0:
		script_note(stilb_scene_add_mesh(scene, &sheet, &id));
		break;
	case 1:
		script_note(mesh == script->sheet ? STILB_OK : stilb_scene_set_mesh(scene, mesh, &sheet));
		break;
	case 2:
		script_note(mesh == script->sheet ? STILB_OK : stilb_scene_remove_mesh(scene, mesh));
		break;
	case 3:
		script_note(stilb_scene_add_material(scene, &paint, &id));
		break;
	case 4:
		script_note(stilb_scene_set_material(scene, material, &paint));
		break;
	case 5:
		script_note(stilb_scene_remove_material(scene, material));
		break;
	case 6:
		script_note(stilb_scene_add_texture(scene, &image, &id));
		break;
	case 7:
		script_note(stilb_scene_set_texture(scene, texture, &image));
		break;
	default:
		script_note(stilb_scene_remove_texture(scene, texture));
		break;
	}
}

static inline stilb_scene_pose script_pose(edit_script *script)
{
	float angle = script_between(script, -3.0f, 3.0f);
	return (stilb_scene_pose){
		.translation = {script_between(script, -4.0f, 4.0f), script_between(script, 0.0f, 2.0f),
	                    script_between(script, -4.0f, 4.0f)},
		.rotation = {0.0f, sinf(0.5f * angle), 0.0f, cosf(0.5f * angle)},
		.scale = {script_between(script, 0.3f, 1.2f), script_between(script, 0.3f, 1.2f), 1.0f},
	};
}

static inline void script_edit_node(edit_script *script, stilb_scene *scene)
{
	uint32_t count = scene->nodes.count, node = script_below(script, count), other = script_below(script, count + 1),
			 id;
	uint32_t model = script_below(script, scene->model_count), kind = script_below(script, 8);
	stilb_scene_pose pose = script_pose(script);
	other = other == count ? STILB_SCENE_NONE : other;
	switch (kind) {
	case 0:
		script_note(stilb_scene_add_node(scene, other, &pose, &id));
		break;
	case 1:
		script_note(stilb_scene_remove_node(scene, node));
		break;
	case 2:
		script_note(stilb_scene_set_node_parent(scene, node, other));
		break;
	case 3:
	case 4:
		script_note(stilb_scene_attach_model(scene, model, other));
		break;
	default:
		script_note(stilb_scene_set_node_pose(scene, node, &pose));
		break;
	}
}

/* A light of any kind; some shine through the part of a model, which may go. */
static inline stilb_scene_light script_light(edit_script *script, const stilb_scene *scene)
{
	stilb_scene_light light = {
		.kind = (stilb_scene_light_kind)script_below(script, STILB_SCENE_LIGHT_KINDS),
		.position = {script_between(script, -9.0f, 9.0f), 6.0f, script_between(script, -9.0f, 9.0f)},
		.direction = {0.0f, -1.0f, 0.0f},
		.intensity = {script_between(script, 0.0f, 9.0f), 4.0f, 2.0f},
		.cos_inner = 0.9f,
		.cos_outer = 0.6f,
		.radius = 0.5f,
		.half_x = {0.5f, 0.0f, 0.0f},
		.half_y = {0.0f, 0.0f, script_between(script, 0.1f, 1.0f)},
		.reach = 20.0f,
		.falloff = (stilb_scene_light_falloff)script_below(script, STILB_SCENE_LIGHT_FALLOFFS),
		.use = (stilb_scene_light_use)script_below(script, STILB_SCENE_LIGHT_USES),
	};
	if (script_below(script, 3) == 0) {
		light.falloff = STILB_SCENE_LIGHT_PHYSICAL;
		light.face = 1 + script_below(script, scene->part_count);
	}
	return light;
}

/* Lights come, change and go, and the surroundings are others. */
static inline void script_edit_light(edit_script *script, stilb_scene *scene)
{
	stilb_scene_light lights[7] = {{0}};
	uint32_t count = scene->light_count < 6 ? scene->light_count : 6, kind = script_below(script, 4);
	for (uint32_t l = 0; l < count; l++)
		lights[l] = scene->lights[l];
	if (kind == 0)
		lights[count++] = script_light(script, scene);
	else if (kind == 1 && count > 0)
		lights[script_below(script, count)] = lights[count - 1];
	else if (count > 0)
		scene->lights[script_below(script, count)].intensity[1] = script_between(script, 0.0f, 9.0f);
	if (kind < 2)
		script_note(stilb_scene_set_lights(scene, lights, kind == 1 && count > 0 ? count - 1 : count));
	scene->surroundings.sky[kind % 3] = script_between(script, 0.1f, 1.0f);
	scene->surroundings.glossy = script_below(script, 2);
}

/* The edits before frame number `frame`. */
static inline void script_step(edit_script *script, stilb_scene *scene, uint32_t frame)
{
	stilb_scene_vertex row[SCRIPT_GRID];
	for (int i = 0; i < 12; i++)
		script_edit_model(script, scene);
	for (int i = 0; i < 4; i++)
		script_edit_resource(script, scene);
	for (int i = 0; i < 10; i++)
		script_edit_node(script, scene);
	script_edit_light(script, scene);
	for (uint32_t r = 0; r < SCRIPT_GRID; r += 1 + frame % 3) { /* every row, or every second or third */
		script_sheet_row(r, (float)frame, row);
		script_note(stilb_scene_set_vertices(scene, script->sheet, r * SCRIPT_GRID, SCRIPT_GRID, row));
	}
	scene->camera.yaw = 0.1f * sinf((float)frame);
}

#endif
