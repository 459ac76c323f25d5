/* many_lights [PICTURE.png]: a floor under 64 small coloured lights that fly around for 10 frames; then a picture. */
#include <math.h>
#include <stdio.h>
#include <stilb/engine.h>
#include <stilb/scene_build.h>

#define LIGHTS 64u

/* In rings over the floor, each light at its own angle and in its own colour. */
static void place_lights(stilb_scene *scene, double seconds)
{
	for (uint32_t i = 0; i < scene->light_count; i++) {
		float ring = 1.0f + (float)(i % 8), angle = (float)(i / 8) * 0.785f + ring + (float)seconds;
		scene->lights[i].position[0] = 1.2f * ring * cosf(angle);
		scene->lights[i].position[1] = 0.8f;
		scene->lights[i].position[2] = 1.2f * ring * sinf(angle);
	}
}

/* In each frame, before anything reads the scene. */
static void on_update(void *user, const stilb_engine_update *update)
{
	place_lights(user, update->seconds);
}

static stilb_result make_scene(stilb_scene **scene)
{
	static const float white[3] = {0.8f, 0.8f, 0.8f}, shine[3] = {0.04f, 0.04f, 0.04f};
	stilb_mat4 wide = stilb_mat4_scale_translate(10.0f, 0.0f, 0.0f, 0.0f);
	stilb_scene_camera camera = {
		.position = {0.0f, 6.0f, 12.0f}, .pitch = -0.46f, .fov_y = 0.9f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_scene_material stone = stilb_scene_material_make(white, shine, 0.5f);
	stilb_scene_mesh plane;
	stilb_result result = stilb_scene_mesh_plane(&plane);
	if (result != STILB_OK)
		return result;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part floor;
	floor.mesh = stilb_scene_build_mesh(build, &plane);
	floor.material = stilb_scene_build_material(build, &stone);
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &wide), &floor, 1);
	stilb_scene_build_camera(build, &camera);
	for (uint32_t i = 0; i < LIGHTS; i++) {
		stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_POINT};
		for (int c = 0; c < 3; c++)
			light.intensity[c] = (i + (uint32_t)c) % 3 == 0 ? 1.0f : 0.1f; /* W / sr */
		stilb_scene_build_light(build, &light);
	}
	stilb_scene_mesh_finish(&plane); /* the build has copied it */
	result = stilb_scene_build_end(build, scene);
	if (result == STILB_OK)
		place_lights(*scene, 0.0);
	return result;
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "many_lights.png";
	stilb_scene *scene = NULL;
	stilb_engine *engine = NULL;
	stilb_engine_report report = {0};
	stilb_result result = make_scene(&scene);
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 320;
	desc.height = 180;
	desc.update = on_update;
	desc.user = scene;
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	while (result == STILB_OK && report.frame < 10)
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(engine, path);
	if (result == STILB_OK)
		printf("%u lights, %u frames: %s\n", scene->light_count, (unsigned)report.frame, path);
	else
		fprintf(stderr, "many_lights: %s\n", stilb_error_message());
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	return result != STILB_OK;
}
