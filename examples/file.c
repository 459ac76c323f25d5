/* file SCENE [PICTURE.png]: opens a scene file of any format that Stilb reads, says what is in it, and saves a picture
 * in which meshes far away have fewer triangles. What Stilb has to say about the file comes through a function of the
 * program. */
#include <inttypes.h>
#include <stdio.h>
#include <stilb/engine.h>
#include <stilb/geometry_detail.h>

static void on_line(void *user, const char *line)
{
	uint32_t *lines = user;
	printf("note %" PRIu32 ": %s\n", ++*lines, line);
}

static void describe(const stilb_scene *scene)
{
	uint64_t triangles = 0;
	for (uint32_t part = 0; part < scene->part_count; part++)
		triangles += scene->meshes[scene->part_mesh[part]].index_count / 3;
	printf("%" PRIu32 " models, %" PRIu64 " triangles, %" PRIu32 " materials, %" PRIu32 " textures\n",
	       scene->model_count, triangles, scene->material_count, scene->texture_count);
}

static stilb_result draw(stilb_scene *scene, const char *path)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 480;
	desc.height = 270;
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_result result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	if (result == STILB_OK)
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(engine, path);
	stilb_engine_destroy(engine); /* before the scene */
	return result;
}

int main(int argc, char **argv)
{
	uint32_t lines = 0;
	stilb_scene *scene;
	if (argc < 2) {
		fprintf(stderr, "usage: file SCENE [PICTURE.png]\n");
		return 2;
	}
	stilb_log_set(on_line, &lines);
	stilb_result result = stilb_scene_open(argv[1], &scene);
	if (result == STILB_OK) {
		describe(scene);
		if (argc > 2) {
			stilb_geometry_detail_make(scene); /* coarser levels of large meshes: made now, or read from the cache */
			result = draw(scene, argv[2]);
		}
		stilb_scene_destroy(scene);
	}
	if (result != STILB_OK)
		fprintf(stderr, "file: %s\n", stilb_error_message());
	return result != STILB_OK;
}
