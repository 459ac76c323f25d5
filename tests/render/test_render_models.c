/* Model files in frames and by rays: each is drawn without a message of the validation layer, and one without textures
 * looks as `render --integrator direct --shadows off` has it, to 1 % of the largest value, silhouettes aside, on
 * Lambert in its own light. A handful of formats; with STILB_MODELS=all in the environment every file of Debian's
 * package assimp-testmodels that opens, and with STILB_MODELS=FOLDER every one below that folder, a line for each.
 * With STILB_TRUTH_PICTURES=FOLDER the pictures and their difference, times 10, are written there. */
#include "gi/gi_render.h"
#include "image/image_compare.h"
#include "render/render.h"
#include "scene/scene.h"
#include "support/test.h"

#include <float.h>
#include <fts.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models"

#define WIDTH 96u
#define HEIGHT 72u
#define FINE 4u /* points of a frame along a side of a pixel */
#define SAMPLES 64u
#define BOUND 0.01 /* of the largest value, root of the mean square */
#define SILHOUETTE                                                                                                     \
	0.05 /* pixels whose points differ by more of the largest value are left out, with their neighbours */
#define MODEL_BEND 0.03   /* of traced normals: of more the pixel counts as a silhouette, too */
#define MODEL_BRIGHT 6e4f /* more does not fit into the frame's numbers, which are halves */

static stilb_job_pool *pool;

typedef struct picture {
	double value[HEIGHT][WIDTH][3];
	double spread[HEIGHT][WIDTH]; /* live: the largest difference of a pixel's points */
	double bend[HEIGHT][WIDTH];   /* traced: 1 - the length of the mean normal; 1: nothing is there */
} picture;

/* What was found of a file. */
typedef struct model_result {
	double rms, most; /* of the difference, relative to the largest value; the largest value */
	uint32_t inside;  /* pixels that were compared */
	bool textured, bright;
	uint32_t messages; /* of the validation layer */
} model_result;

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

/* A half float; negative, infinite and NaN are 0, and counted. */
static double half(uint16_t bits)
{
	int exponent = bits >> 10 & 31, mantissa = bits & 1023;
	if (bits >> 15 || exponent == 31)
		return 0.0;
	return exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
}

static void average(const stilb_image *image, picture *out)
{
	const uint16_t *points = image->pixels;
	memset(out, 0, sizeof *out);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int c = 0; c < 3; c++) {
				double low = DBL_MAX, high = -DBL_MAX, sum = 0.0;
				for (uint32_t p = 0; p < FINE * FINE; p++) {
					size_t row = y * FINE + p / FINE, column = x * FINE + p % FINE;
					double value = half(points[3 * (row * image->width + column) + (size_t)c]);
					low = fmin(low, value), high = fmax(high, value), sum += value;
				}
				out->value[y][x][c] = sum / (FINE * FINE);
				out->spread[y][x] = fmax(out->spread[y][x], high - low);
			}
}

static void live_picture(stilb_render *render, const stilb_scene *scene, picture *out)
{
	stilb_render_pass pass = {.name = "scene"};
	stilb_render_view view = {
		.view_projection = stilb_scene_camera_matrix(&scene->camera, (float)WIDTH / HEIGHT),
		.lights = scene->lights,
		.light_count = scene->light_count,
		.surroundings = scene->surroundings,
		.shading = {.brdf = SHADE_BRDF_LAMBERT},
		.both_sides = scene->both_sides,
	};
	memcpy(view.camera_position, scene->camera.position, sizeof view.camera_position);
	uint32_t *ids = malloc((scene->model_count + (size_t)1) * sizeof *ids);
	for (uint32_t i = 0; i < scene->model_count; i++)
		ids[i] = i;
	stilb_image image = {0};
	if (stilb_render_set_scene(render, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, scene->model_count, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	assert_int_equal(image.format, STILB_IMAGE_F16_LINEAR);
	average(&image, out);
	stilb_image_finish(&image);
	free(ids);
}

static void traced_picture(const stilb_scene *scene, picture *out)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_DIRECT;
	settings.no_shadows = true;
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = SAMPLES;
	settings.model = (shade_brdf_model){SHADE_BRDF_LAMBERT, 0, 0, 0};
	assert_int_equal(stilb_gi_render_create(gi, &settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	const float *radiance = stilb_gi_render_film(render).radiance;
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
		out->value[i / 3 / WIDTH][i / 3 % WIDTH][i % 3] = (double)radiance[i];
	const float *normal = stilb_gi_render_film(render).normal;
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++, normal += 3)
		out->bend[i / WIDTH][i % WIDTH] =
			1.0 - (double)sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

static void save(const char *path, const picture *a, const picture *b, double scale)
{
	char name[600];
	stilb_image image;
	snprintf(name, sizeof name, "%s.png", path);
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) {
		double first = ((const double *)a->value)[i], second = b ? ((const double *)b->value)[i] : 0.0;
		double shown = scale * (b ? 10.0 * fabs(first - second) : first);
		((uint8_t *)image.pixels)[i] = (uint8_t)(255.0 * pow(fmin(shown, 1.0), 1.0 / 2.2) + 0.5);
	}
	assert_int_equal(stilb_image_save(&image, name), STILB_OK);
	stilb_image_finish(&image);
}

static void save_all(const char *file, const picture *live, const picture *traced, double most)
{
	const char *folder = getenv("STILB_TRUTH_PICTURES"), *name = strrchr(file, '/');
	char path[512];
	if (!folder)
		return;
	name = name ? name + 1 : file;
	snprintf(path, sizeof path, "%s/%s-live", folder, name);
	save(path, live, NULL, 1.0 / most);
	snprintf(path, sizeof path, "%s/%s-traced", folder, name);
	save(path, traced, NULL, 1.0 / most);
	snprintf(path, sizeof path, "%s/%s-error", folder, name);
	save(path, live, traced, 1.0 / most);
}

/* True if the pixel and those around it show a smooth surface. */
static bool is_inside(const picture *live, const picture *traced, uint32_t x, uint32_t y, double most)
{
	bool inside = x > 0 && y > 0 && x + 1 < WIDTH && y + 1 < HEIGHT;
	for (uint32_t v = y - 1; inside && v <= y + 1; v++)
		for (uint32_t u = x - 1; inside && u <= x + 1; u++)
			inside = live->spread[v][u] <= SILHOUETTE * most && traced->bend[v][u] <= MODEL_BEND;
	return inside;
}

/* The mean of nine pixels, of which rays have a third of the noise of one. */
static double mean_around(const picture *of, uint32_t x, uint32_t y, int c)
{
	double sum = 0.0;
	for (uint32_t v = y - 1; v <= y + 1; v++)
		for (uint32_t u = x - 1; u <= x + 1; u++)
			sum += of->value[v][u][c] / 9.0;
	return sum;
}

static stilb_image made(uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, channels, format), STILB_OK);
	return image;
}

static void compare(const picture *live, const picture *traced, model_result *result)
{
	stilb_image means[2] = {made(3, STILB_IMAGE_F32_LINEAR), made(3, STILB_IMAGE_F32_LINEAR)};
	stilb_image mask = made(1, STILB_IMAGE_U8_LINEAR);
	stilb_image_comparison apart;
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
		result->most = fmax(result->most, ((const double *)traced->value)[i]);
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		uint32_t x = i % WIDTH, y = i / WIDTH;
		if (!is_inside(live, traced, x, y, result->most))
			continue;
		((uint8_t *)mask.pixels)[i] = 255;
		for (int c = 0; c < 3; c++) {
			((float *)means[0].pixels)[3 * i + (uint32_t)c] = (float)mean_around(live, x, y, c);
			((float *)means[1].pixels)[3 * i + (uint32_t)c] = (float)mean_around(traced, x, y, c);
		}
	}
	assert_int_equal(stilb_image_compare(&means[0], &means[1], &mask, 0.0, &apart), STILB_OK);
	result->inside = (uint32_t)apart.pixels;
	result->rms = result->most > 0.0 ? apart.rms_all / result->most : 0.0;
	stilb_image_finish(&means[0]);
	stilb_image_finish(&means[1]);
	stilb_image_finish(&mask);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static bool opens_quietly(const char *path, stilb_scene **scene)
{
	stilb_scene_open_options options = {.quiet = true};
	return stilb_scene_open_with(path, &options, scene) == STILB_OK;
}

/* What is black on Lambert, as metal, becomes grey, so that its normals count. */
static void whiten(stilb_scene *scene)
{
	for (uint32_t m = 0; m < scene->material_count; m++) {
		float *diffuse = scene->materials[m].diffuse;
		if (diffuse[0] + diffuse[1] + diffuse[2] < 0.3f)
			diffuse[0] = diffuse[1] = diffuse[2] = 0.5f;
		memset(scene->materials[m].specular, 0, sizeof scene->materials[m].specular);
	}
}

/* False: the file does not open. */
static bool measure(stilb_render *render, const char *path, model_result *result)
{
	static picture live, traced;
	stilb_scene *scene;
	*result = (model_result){0};
	if (!opens_quietly(path, &scene))
		return false;
	if (scene->framed)
		scene->camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, (float)WIDTH / HEIGHT);
	whiten(scene);
	result->textured = scene->texture_count > 0;
	uint32_t before = stilb_render_validation_messages(render);
	live_picture(render, scene, &live);
	result->messages = stilb_render_validation_messages(render) - before;
	traced_picture(scene, &traced);
	compare(&live, &traced, result);
	result->bright = result->most > (double)MODEL_BRIGHT;
	if (result->most > 0.0)
		save_all(path, &live, &traced, result->most);
	stilb_scene_destroy(scene);
	return true;
}

static bool is_good(const model_result *result)
{
	return result->messages == 0 && (result->textured || result->bright || result->rms <= BOUND);
}

static void tell(const char *path, const model_result *result)
{
	printf("%s %.2f %% of %.3g on %u pixels%s%s", path, 100.0 * result->rms, result->most, result->inside,
	       result->textured ? ", textured" : "", result->bright ? ", too bright" : "");
	printf(result->messages ? ", %u messages\n" : "\n", result->messages);
}

static stilb_render *render_make(void)
{
	stilb_render_desc desc = {.output = STILB_RENDER_OUTPUT_LINEAR,
	                          .width = WIDTH * FINE,
	                          .height = HEIGHT * FINE,
	                          .samples = 1,
	                          .context_count = 1,
	                          .validate = true};
	stilb_render *render;
	if (stilb_render_create(&desc, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return render;
}

static void models_look_as_traced(void **state)
{
	(void)state;
	static const char *const names[] = {"OBJ/spider.obj", "glTF2/simple_skin/simple_skin.gltf",
	                                    "BLEND/BlenderDefault_250.blend", "STL/Spider_binary.stl", "PLY/Wuson.ply"};
	stilb_render *render = render_make();
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		char path[512];
		model_result result;
		snprintf(path, sizeof path, MODELS "/%s", names[i]);
		if (!measure(render, path, &result))
			fail_msg("%s", stilb_error_message());
		tell(path, &result);
		assert_true(is_good(&result) && result.inside > 50);
	}
	stilb_render_destroy(render);
}

static void all_models_look_as_traced(void **state)
{
	(void)state;
	const char *wanted = getenv("STILB_MODELS");
	char *roots[] = {(char *)(strcmp(wanted, "all") == 0 ? MODELS : wanted), NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL, NULL);
	uint32_t files = 0, bad = 0, plain = 0;
	stilb_render *render = render_make();
	assert_non_null(walk);
	for (FTSENT *entry; (entry = fts_read(walk));) {
		model_result result;
		if (entry->fts_info != FTS_F || !measure(render, entry->fts_path, &result))
			continue;
		files++;
		plain += !result.textured;
		bad += !is_good(&result);
		tell(entry->fts_path, &result);
		fflush(stdout);
	}
	fts_close(walk);
	stilb_render_destroy(render);
	printf("%u files, %u without textures, %u differ or have messages\n", files, plain, bad);
	assert_true(files > 0 && bad == 0);
}

static int set_up(void **state)
{
	(void)state;
	return stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 0}, &pool);
}

static int tear_down(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

int main(void)
{
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	const struct CMUnitTest few[] = {cmocka_unit_test(models_look_as_traced)};
	const struct CMUnitTest all[] = {cmocka_unit_test(all_models_look_as_traced)};
	return getenv("STILB_MODELS") ? cmocka_run_group_tests_name("all models", all, set_up, tear_down)
	                              : cmocka_run_group_tests(few, set_up, tear_down);
}
