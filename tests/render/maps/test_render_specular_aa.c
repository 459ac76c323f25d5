/* Specular antialiasing over a camera's path: a bumpy ground that is seen at a slant, a sample a pixel, beside the mean
 * of 1,024 samples a pixel. Shimmer is the standard deviation of a pixel over the path; error the root of the mean
 * square against the truth. Both are of x / (x + the truth's mean), as eyes and tone maps have it, so that a few
 * sparkles do not outweigh the picture.
 *
 *   test_render_specular_aa N                      N frames of the path
 *   STILB_TRUTH_PICTURES=FOLDER ...                writes specular-aa.png there: of each ground off, vmf, truth */
#include "shading/shade_brdf.h"
#include "shading/shade_srgb.h"

#include "maps_stage.h" /* names a type as these name variables */

#define SIDE 64u
#define FINE 32u /* a pixel of the truth is FINE x FINE samples */
#define BUMPS 256u

static uint32_t frames = 6;

/* ---- reliefs ----------------------------------------------------------------------------------------------------- */

/* A number in [0, 1] for a place of a lattice that repeats. */
static double lattice(int x, int y, int period)
{
	uint32_t h = (uint32_t)(x & (period - 1)) * 73856093u ^ (uint32_t)(y & (period - 1)) * 19349663u ^
	             (uint32_t)period * 83492791u;
	h = (h ^ h >> 15) * 0x85ebca6bu;
	h = (h ^ h >> 13) * 0xc2b2ae35u;
	return (double)((h ^ h >> 16) & 0xffffu) / 65535.0;
}

/* Between the numbers of a lattice of period x period. u, v: one period is 1. */
static double noise(double u, double v, int period)
{
	double x = u * period, y = v * period;
	int i = (int)floor(x), j = (int)floor(y);
	double s = x - i, t = y - j;
	s *= s * (3.0 - 2.0 * s), t *= t * (3.0 - 2.0 * t);
	double above = lattice(i, j, period) + (lattice(i + 1, j, period) - lattice(i, j, period)) * s;
	double below = lattice(i, j + 1, period) + (lattice(i + 1, j + 1, period) - lattice(i, j + 1, period)) * s;
	return above + (below - above) * t;
}

/* Hammered metal. */
static double hammered(double u, double v)
{
	return 0.016 * noise(u, v, 8) + 0.008 * noise(u, v, 16) + 0.004 * noise(u, v, 32);
}

/* Round cobbles, in rows that are shifted. */
static double cobbles(double u, double v)
{
	double row = floor(v * 8.0), x = u * 8.0 + 0.5 * fmod(row, 2.0), y = v * 8.0;
	x -= floor(x) + 0.5, y -= floor(y) + 0.5;
	return 0.06 * sqrt(fmax(0.25 - x * x - y * y, 0.0)) + 0.002 * noise(u, v, 64);
}

typedef double relief(double u, double v);

/* The map of normals of a relief whose side is 1. */
static stilb_image relief_map(relief *height)
{
	stilb_image image;
	double step = 0.25 / BUMPS;
	assert_int_equal(stilb_image_create(&image, BUMPS, BUMPS, 3, STILB_IMAGE_U8_LINEAR), STILB_OK);
	uint8_t *out = image.pixels;
	for (uint32_t y = 0; y < BUMPS; y++)
		for (uint32_t x = 0; x < BUMPS; x++) {
			double u = (x + 0.5) / BUMPS, v = (y + 0.5) / BUMPS;
			dvec n = {(height(u - step, v) - height(u + step, v)) / (2.0 * step),
			          (height(u, v + step) - height(u, v - step)) / (2.0 * step), 1.0};
			n = dvec_unit(n);
			const double value[3] = {n.x, n.y, n.z};
			for (int c = 0; c < 3; c++)
				*out++ = (uint8_t)(127.5 + 127.5 * value[c] + 0.5);
		}
	return image;
}

/* ---- the path ---------------------------------------------------------------------------------------------------- */

typedef struct ground {
	const char *name;
	relief *height;
	float metalness, roughness;
	bool lamps; /* lit by a panorama of lamps; false: by a sun */
} ground;

static const ground grounds[] = {{"hammered metal under a sun", hammered, 1.0f, 0.25f, false},
                                 {"wet cobbles under lamps", cobbles, 0.0f, 0.2f, true}};

/* Three lamps in a dim room. */
static stilb_image lamps(void)
{
	stilb_image image;
	static const double directions[3][3] = {{0.1, 0.35, -0.93}, {-0.6, 0.5, -0.62}, {0.7, 0.6, 0.38}};
	assert_int_equal(stilb_image_create(&image, 256, 128, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t y = 0; y < 128; y++)
		for (uint32_t x = 0; x < 256; x++) {
			double longitude = 2.0 * REFERENCE_PI * ((x + 0.5) / 256 - 0.5), latitude = REFERENCE_PI * (y + 0.5) / 128;
			dvec d = {sin(latitude) * sin(longitude), cos(latitude), -sin(latitude) * cos(longitude)};
			double light = 0.1 + 0.1 * d.y;
			for (int l = 0; l < 3; l++)
				light += dvec_dot(d, dvec_unit((dvec){directions[l][0], directions[l][1], directions[l][2]})) > 0.985
				             ? 12.0
				             : 0.0;
			for (int c = 0; c < 3; c++)
				((float *)image.pixels)[3 * (y * 256 + x) + (uint32_t)c] = (float)light;
		}
	return image;
}

/* The luminance of all pixels of the path, each the mean of fine x fine samples. */
static float *path_picture(const ground *g, uint32_t fine, stilb_render_specular_aa aa)
{
	stage s = stage_open((stilb_render_desc){.width = SIDE * fine, .specular_aa = aa}, 0);
	square q;
	stilb_image bumps = relief_map(g->height), room = lamps();
	stilb_scene_surface surface = stilb_scene_surface_make();
	stilb_scene_light sun = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -0.4961f, 0.8682f}};
	float *values = calloc((size_t)frames * SIDE * SIDE, sizeof *values);
	assert_non_null(values);
	square_make(&q, 1.0f);
	reference_set3(sun.intensity, 3.0f, 3.0f, 3.0f);
	reference_set3(s.view.surroundings.sky, 0.1f, 0.1f, 0.1f);
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	s.view.lights = &sun;
	s.view.light_count = g->lamps ? 0 : 1;
	if (g->lamps)
		s.view.surroundings.panorama = room;
	surface.metalness = g->metalness;
	surface.roughness = g->roughness;
	surface.color[0] = surface.color[1] = surface.color[2] = 0.5f;
	surface.maps[STILB_SCENE_MAP_NORMAL] = (stilb_scene_map){.texture = 1, .to_u = {24, 0, 0}, .to_v = {0, 24, 0}};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_texture(build, &bumps);
	stilb_mat4 place = stilb_mat4_identity();
	place.m[0] = place.m[10] = 6.0f;
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	stage_model(build, mesh, stage_material(build, &surface), place);
	stage_show(&s, build);
	for (uint32_t f = 0; f < frames; f++) {
		dvec eye = {0.013 * f, 1.6, 5.0 - 0.029 * f}, target = {0.013 * f, 0.0, 1.0 - 0.029 * f};
		reference_camera camera = reference_camera_at(eye, target, (dvec){0, 1, 0}, 2.4, SIDE, SIDE);
		s.view.view_projection = reference_matrix(&camera);
		for (int i = 0; i < 3; i++)
			s.view.camera_position[i] = (float)(i == 0 ? eye.x : i == 1 ? eye.y : eye.z);
		stilb_image picture = stage_picture(&s);
		for (uint32_t y = 0; y < SIDE * fine; y++)
			for (uint32_t x = 0; x < SIDE * fine; x++)
				values[((size_t)f * SIDE + y / fine) * SIDE + x / fine] +=
					(float)picture_value(&picture, x, y, 1) / (float)(fine * fine);
		stilb_image_finish(&picture);
	}
	stage_close(&s);
	stilb_image_finish(&bumps);
	stilb_image_finish(&room);
	return values;
}

typedef struct path_numbers {
	double shimmer, error, mean;
} path_numbers;

static double path_mean(const float *values)
{
	size_t count = (size_t)SIDE * SIDE * frames;
	double mean = 0.0;
	for (size_t i = 0; i < count; i++)
		mean += (double)values[i] / (double)count;
	return mean;
}

static path_numbers path_measure(const float *values, const float *truth)
{
	size_t pixels = (size_t)SIDE * SIDE, count = pixels * frames;
	path_numbers numbers = {0};
	double mean = path_mean(truth);
	for (size_t p = 0; p < pixels; p++) {
		double sum = 0.0, squares = 0.0;
		for (size_t i = p; i < count; i += pixels) {
			double x = (double)values[i] / ((double)values[i] + mean), t = (double)truth[i] / ((double)truth[i] + mean);
			sum += x / frames;
			squares += x * x / frames;
			numbers.error += (x - t) * (x - t) / (double)count;
			numbers.mean += (double)values[i] / (double)count / mean;
		}
		numbers.shimmer += fmax(squares - sum * sum, 0.0) / (double)pixels;
	}
	numbers.shimmer = sqrt(numbers.shimmer);
	numbers.error = sqrt(numbers.error);
	return numbers;
}

#define LARGER 3u /* a pixel of the picture is LARGER x LARGER of the file */

/* Puts the path's first frame into a picture of sRGB. mean: the truth's. */
static void picture_put(const stilb_image *picture, uint32_t column, uint32_t row, const float *values, double mean)
{
	for (uint32_t y = 0; y < SIDE * LARGER; y++)
		for (uint32_t x = 0; x < SIDE * LARGER; x++) {
			float value = values[y / LARGER * SIDE + x / LARGER];
			uint8_t code = (uint8_t)(255.0f * shade_srgb_from_linear(value / (value + 2.0f * (float)mean)) + 0.5f);
			size_t at = (size_t)(row * SIDE * LARGER + y) * picture->width + column * SIDE * LARGER + x;
			memset((uint8_t *)picture->pixels + 3 * at, code, 3);
		}
}

static void highlights_do_not_shimmer(void **state)
{
	(void)state;
	static const char *const names[] = {"vmf", "toksvig", "off"};
	const char *folder = getenv("STILB_TRUTH_PICTURES");
	stilb_image picture;
	assert_int_equal(stilb_image_create(&picture, 3 * SIDE * LARGER, 2 * SIDE * LARGER, 3, STILB_IMAGE_U8_SRGB),
	                 STILB_OK);
	for (size_t g = 0; g < sizeof grounds / sizeof *grounds; g++) {
		path_numbers numbers[3];
		float *truth = path_picture(&grounds[g], FINE, STILB_RENDER_SPECULAR_AA_OFF);
		print_message("%s: shimmer, error, mean\n", grounds[g].name);
		for (int aa = STILB_RENDER_SPECULAR_AA_VMF; aa <= STILB_RENDER_SPECULAR_AA_OFF; aa++) {
			float *values = path_picture(&grounds[g], 1, (stilb_render_specular_aa)aa);
			numbers[aa] = path_measure(values, truth);
			print_message("  %-8s %.4f %.4f %.3f\n", names[aa], numbers[aa].shimmer, numbers[aa].error,
			              numbers[aa].mean);
			if (aa != STILB_RENDER_SPECULAR_AA_TOKSVIG)
				picture_put(&picture, aa == STILB_RENDER_SPECULAR_AA_OFF ? 0 : 1, (uint32_t)g, values,
				            path_mean(truth));
			free(values);
		}
		picture_put(&picture, 2, (uint32_t)g, truth, path_mean(truth));
		path_numbers still = path_measure(truth, truth);
		print_message("  %-8s %.4f\n", "truth", still.shimmer);
		free(truth);
		assert_true(numbers[0].error < 0.6 * numbers[2].error && numbers[0].error < 1.05 * numbers[1].error);
		assert_true(numbers[0].shimmer < 0.9 * numbers[2].shimmer && numbers[0].shimmer < 1.05 * numbers[1].shimmer);
		assert_true(fabs(numbers[0].mean - 1.0) < 0.13 && numbers[2].mean > 1.1);
	}
	char path[4096];
	snprintf(path, sizeof path, "%s/specular-aa.png", folder ? folder : "");
	assert_true(!folder || stilb_image_save(&picture, path) == STILB_OK);
	stilb_image_finish(&picture);
}

int main(int argc, char **argv)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(highlights_do_not_shimmer),
	};
	frames = argc > 1 ? (uint32_t)atoi(argv[1]) : frames;
	return cmocka_run_group_tests(tests, NULL, NULL);
}
