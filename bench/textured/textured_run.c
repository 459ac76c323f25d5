/* The program of the suite `textured`: the engine and the plain Vulkan program draw the same model. Every run
 * ends with a comparison of its picture with that of vulkan-bare. */
#include "bench/record/record_child.h"
#include "bench/textured/textured_bare.h"

#include "engine.h"
#include "image/image_compare.h"
#include "profiler/prof.h"
#include "scene/scene_look.h"
#include "shading/shade_brdf.h"
#include "shading/shade_tonemap.h"
#include "tests/engine/answers/gltf_models.h"

#include <unistd.h>

/* Of light. What rounds otherwise makes some 5e-5; a pixel of a silhouette may be another one. */
#define RMS_MOST 5e-4

static void expect(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static const char *const files[] = {"helmet.gltf",           "helmet.bin",        "helmet-color.png",
                                    "helmet-reflection.png", "helmet-normal.png", "helmet-occlusion.png",
                                    "helmet-emission.png",   "room.exr"};

/* Writes the model into a folder of its own, opens it and removes the files. */
static stilb_scene *make_scene(void)
{
	char folder[] = "/tmp/stilb-bench-textured-XXXXXX";
	stilb_scene *scene;
	if (!mkdtemp(folder) || chdir(folder) != 0)
		bench_child_fail("cannot make a folder for the model");
	stilb_result result = STILB_ERROR_FILE;
	if (gltf_model_helmet(TEXTURED_SIDE) && gltf_model_room("room.exr", 512))
		result = stilb_scene_open("helmet.gltf", &scene);
	if (result == STILB_OK)
		result = stilb_scene_set_environment(scene, "room.exr");
	for (size_t i = 0; i < sizeof files / sizeof *files; i++)
		unlink(files[i]);
	if (chdir("/") != 0 || rmdir(folder) != 0)
		bench_child_fail("cannot remove the folder of the model");
	expect(result);
	stilb_scene_set_backdrop(scene, (const float[3]){0.1f, 0.1f, 0.1f}); /* as the plain program's clear colour */
	scene->camera.tone = SHADE_TONE_KNEE;
	scene->camera.exposure = 0.0f;
	return scene;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static record_samples samples;

/* Compares a picture with that of vulkan-bare. */
static void verify(const stilb_image *own, const stilb_scene *scene)
{
	static textured_bare plain;
	stilb_image other;
	stilb_image_comparison apart;
	const char *folder = getenv("STILB_BENCH_PICTURES");
	if (!textured_bare_open(&plain, scene, TEXTURED_STRAIGHT))
		exit(BENCH_CHILD_SKIP);
	textured_bare_frame(&plain);
	textured_bare_picture(&plain, &other);
	textured_bare_close(&plain);
	expect(stilb_image_compare(own, &other, NULL, 0.0, &apart));
	if (folder && chdir(folder) == 0) {
		expect(stilb_image_save(own, "textured-own.png"));
		expect(stilb_image_save(&other, "textured-bare.png"));
	}
	bench_child_metric("rms", apart.rms_all);
	if (!(apart.rms_all <= RMS_MOST))
		bench_child_fail("wrong picture: it is %g from the plain program's (root of the mean square), at most %g",
		                 apart.rms_all, RMS_MOST);
	stilb_image_finish(&other);
}

static void draw_plain(const stilb_scene *scene, textured_variant variant, double seconds)
{
	static textured_bare plain;
	record_picture_times times = {0};
	stilb_image image;
	if (!textured_bare_open(&plain, scene, variant))
		exit(BENCH_CHILD_SKIP);
	uint64_t until = record_deadline(seconds);
	do
		textured_bare_frame(&plain);
	while (record_picture_frame(&times, &samples, until));
	textured_bare_picture(&plain, &image);
	textured_bare_close(&plain);
	record_picture_print(&times, &samples);
	verify(&image, scene);
	stilb_image_finish(&image);
}

/* The last frame's picture, by way of a file. */
static void read_picture(stilb_engine *engine, stilb_image *image)
{
	char path[] = "/tmp/stilb-bench-textured-XXXXXX.png";
	int file = mkstemps(path, 4);
	if (file < 0)
		bench_child_fail("cannot make a file for the picture");
	close(file);
	stilb_result result = stilb_engine_screenshot(engine, path);
	if (result == STILB_OK)
		result = stilb_image_load(path, image);
	unlink(path);
	expect(result);
}

static void draw_engine(stilb_scene *scene, double seconds)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_image image;
	record_picture_times times = {0};
	desc.gpu = "llvmpipe";
	desc.width = TEXTURED_WIDTH;
	desc.height = TEXTURED_HEIGHT;
	desc.workers = 1;
	desc.shadows.kind = STILB_ENGINE_SHADOWS_OFF; /* nor has the other program any */
	desc.shading.brdf = SHADE_BRDF_MICROFACET;    /* as stilb view has it */
	stilb_result result = stilb_engine_create(&desc, &engine);
	if (result == STILB_ERROR_DEVICE) {
		fprintf(stderr, "%s\n", stilb_error_message());
		exit(BENCH_CHILD_SKIP);
	}
	expect(result);
	expect(stilb_engine_set_scene(engine, scene));
	uint64_t until = record_deadline(seconds);
	do
		expect(stilb_engine_frame(engine, &report));
	while (record_picture_frame(&times, &samples, until));
	record_picture_print(&times, &samples);
	read_picture(engine, &image);
	stilb_engine_destroy(engine);
	verify(&image, scene);
	stilb_image_finish(&image);
}

static const char *const variants[TEXTURED_COUNT] = {
#define NAME(ID, identifier, subject, ...) [TEXTURED_##ID] = subject,
	TEXTURED_VARIANTS(NAME)
#undef NAME
};

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	stilb_prof_record_set(false); /* else the cost of recording profiler zones would be measured, too */
	stilb_scene *scene = make_scene();
	if (strcmp(child.subject, "stilb") == 0)
		draw_engine(scene, child.seconds);
	for (int v = 0; v < TEXTURED_COUNT; v++)
		if (strcmp(child.subject, variants[v]) == 0)
			draw_plain(scene, (textured_variant)v, child.seconds);
	stilb_scene_destroy(scene);
	return 0;
}
