/* own_surface [PICTURE.png]: a material with a function of the program's own, shaders/dissolve.glsl: a striped ball
 * that dissolves while frames are drawn. The function runs where colour is drawn, and where depth alone is. Needs no
 * window. */
#include "dissolve.surface.h" /* made by stilb_surface() of CMakeLists.txt */

#include <stdio.h>
#include <stilb/engine.h>
#include <stilb/scene_build.h>
#include <string.h>

#define FRAMES 48

/* A ball with the function, over a floor, under a sun. */
static stilb_result make_scene(stilb_scene **scene)
{
	static const float white[3] = {0.7f, 0.7f, 0.65f}, blue[3] = {0.05f, 0.15f, 0.5f}, glow[3] = {8.0f, 2.0f, 0.2f};
	static const float grey[3] = {0.4f, 0.4f, 0.4f}, shine[3] = {0.04f, 0.04f, 0.04f};
	stilb_mat4 above = stilb_mat4_scale_translate(1.0f, 0.0f, 1.0f, 0.0f);
	stilb_mat4 wide = stilb_mat4_scale_translate(4.0f, 0.0f, 0.0f, 0.0f);
	stilb_scene_camera camera = {
		.position = {0.0f, 1.8f, 4.5f}, .pitch = -0.17f, .fov_y = 0.7f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.6f, -0.64f}, .intensity = {3.0f, 3.0f, 3.0f}};
	stilb_scene_mesh sphere = {0}, plane = {0};
	stilb_result result = stilb_scene_mesh_sphere(5, &sphere);
	if (result == STILB_OK)
		result = stilb_scene_mesh_plane(&plane);
	if (result == STILB_OK) {
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_part ball, floor;
		stilb_scene_surface surface = stilb_scene_surface_make(); /* what the function changes */
		memcpy(surface.color, white, sizeof white);
		surface.roughness = 0.7f;
		surface.alpha = STILB_SCENE_MASK; /* where the function's alpha is below the cutoff, nothing is there */
		surface.function = 1 + stilb_scene_build_function(build, &dissolve);
		surface.parameters[0][0] = 2.0f; /* seconds */
		surface.parameters[0][1] = 8.0f; /* stripes */
		surface.parameters[0][2] = 3.0f; /* holes across a metre */
		memcpy(surface.parameters[1], blue, sizeof blue);
		memcpy(surface.parameters[2], glow, sizeof glow);
		stilb_scene_material paint =
			stilb_scene_material_make(white, shine, 0.7f); /* where maps are not read: its means */
		stilb_scene_material stone = stilb_scene_material_make(grey, shine, 0.8f);
		paint.surface = 1 + stilb_scene_build_surface(build, &surface);
		ball.mesh = stilb_scene_build_mesh(build, &sphere);
		ball.material = stilb_scene_build_material(build, &paint);
		floor.mesh = stilb_scene_build_mesh(build, &plane);
		floor.material = stilb_scene_build_material(build, &stone);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &above), &ball, 1);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &wide), &floor, 1);
		stilb_scene_build_light(build, &sun);
		stilb_scene_build_camera(build, &camera);
		result = stilb_scene_build_end(build, scene); /* says what is wrong with the scene, or the function */
	}
	if (result == STILB_OK)
		(*scene)->both_sides = true; /* one looks into it */
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&plane);
	return result;
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "own_surface.png";
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 480;
	desc.height = 360;
	stilb_scene *scene = NULL;
	stilb_engine *engine = NULL;
	stilb_engine_report report;
	stilb_result result = make_scene(&scene);
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	for (int frame = 0; frame < FRAMES && result == STILB_OK; frame++) /* without a window each is 1/60 s later */
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(engine, path);
	if (result == STILB_OK)
		printf("%d frames of a ball that dissolves: %s\n", FRAMES, path);
	else
		fprintf(stderr, "own_surface: %s\n", stilb_error_message());
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	return result != STILB_OK;
}
