/* raytrace [SCENE [PICTURE]]: a scene by ray tracing, without engine and device. PICTURE ends in .exr, .hdr or .png. */
#include <stdio.h>
#include <stilb/gi_render.h>

static stilb_result render(const stilb_scene *scene, stilb_job_pool *pool, const char *path)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.width = settings.height = 128;
	settings.samples = 16;
	stilb_gi_scene *traced;
	stilb_gi_render *gi = NULL;
	stilb_result result = stilb_gi_scene_create(scene, &desc, &traced);
	if (result == STILB_OK)
		result = stilb_gi_render_create(traced, &settings, pool, &gi);
	if (result == STILB_OK)
		result = stilb_gi_render_run(gi);
	if (result == STILB_OK)
		result = stilb_gi_render_save(gi, path);
	stilb_gi_render_destroy(gi);
	stilb_gi_scene_destroy(traced);
	return result;
}

int main(int argc, char **argv)
{
	const char *name = argc > 1 ? argv[1] : "cornell", *path = argc > 2 ? argv[2] : "raytrace.exr";
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	stilb_scene *scene;
	int error = stilb_job_pool_create(&desc, &pool);
	if (error != 0) {
		fprintf(stderr, "raytrace: no threads: error %d\n", -error);
		return 1;
	}
	stilb_result result = stilb_scene_open(name, &scene);
	if (result == STILB_OK) {
		result = render(scene, pool, path);
		stilb_scene_destroy(scene);
	}
	stilb_job_pool_destroy(pool);
	if (result == STILB_OK)
		printf("%s by 16 samples a pixel: %s\n", name, path);
	else
		fprintf(stderr, "raytrace: %s\n", stilb_error_message());
	return result != STILB_OK;
}
