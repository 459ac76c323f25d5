/* own_scene [PICTURE.png]: a scene made in C, drawn by the engine, and saved as a picture. Needs no window. */
#include <stdio.h>
#include <stilb/engine.h>
#include <stilb/scene_build.h>

/* A red ball on a grey floor, under a sun. */
static stilb_result make_scene(stilb_scene **scene)
{
	static const float red[3] = {0.6f, 0.1f, 0.1f}, grey[3] = {0.5f, 0.5f, 0.5f}, shine[3] = {0.04f, 0.04f, 0.04f};
	stilb_mat4 above = stilb_mat4_scale_translate(1.0f, 0.0f, 1.0f, 0.0f); /* radius 1, its centre at (0, 1, 0) */
	stilb_mat4 wide = stilb_mat4_scale_translate(4.0f, 0.0f, 0.0f, 0.0f);
	stilb_scene_camera camera = {
		.position = {0.0f, 1.8f, 5.0f}, .pitch = -0.15f, .fov_y = 0.7f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -0.8f, -0.6f}, .intensity = {3.0f, 3.0f, 3.0f}};
	stilb_scene_material paint = stilb_scene_material_make(red, shine, 0.3f);
	stilb_scene_material stone = stilb_scene_material_make(grey, shine, 0.8f);
	stilb_scene_mesh sphere = {0}, plane = {0};
	stilb_result result = stilb_scene_mesh_sphere(4, &sphere);
	if (result == STILB_OK)
		result = stilb_scene_mesh_plane(&plane);
	if (result == STILB_OK) {
		stilb_scene_build *build = stilb_scene_build_begin(); /* what is wrong with the scene, build_end says */
		stilb_scene_build_part ball, floor;
		ball.mesh = stilb_scene_build_mesh(build, &sphere);
		ball.material = stilb_scene_build_material(build, &paint);
		floor.mesh = stilb_scene_build_mesh(build, &plane);
		floor.material = stilb_scene_build_material(build, &stone);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &above), &ball, 1);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &wide), &floor, 1);
		stilb_scene_build_light(build, &sun);
		stilb_scene_build_camera(build, &camera);
		result = stilb_scene_build_end(build, scene);
	}
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&plane);
	return result;
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "own_scene.png";
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 480;
	desc.height = 270;
	stilb_scene *scene = NULL;
	stilb_engine *engine = NULL;
	stilb_engine_report report;
	stilb_result result = make_scene(&scene);
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	if (result == STILB_OK)
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(engine, path);
	if (result == STILB_OK)
		printf("%u of %u models drawn: %s\n", report.visible, scene->model_count, path);
	else
		fprintf(stderr, "own_scene: %s\n", stilb_error_message());
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	return result != STILB_OK;
}
