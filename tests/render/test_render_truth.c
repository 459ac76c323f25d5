/* Frames against the path tracer: live pictures without shadows equal `render --integrator direct --shadows off` within
 * 1e-3 of the largest value, silhouettes aside, for each kind of light alone: without a size under any model, with one
 * and under the sky or a panorama on Lambert. Frames shade eight by eight points of a pixel, of which the mean is
 * compared. With STILB_TRUTH_PICTURES=FOLDER in the environment the pictures and their difference, times 100, are
 * written there. */
#include "gi/film/gi_camera.h"
#include "gi/gi_render.h"
#include "gi/gi_surface.h"
#include "gi/trace/gi_ray.h"
#include "numeric/numeric_albedo.h"
#include "numeric/numeric_catalog.h"
#include "panorama_exact.h"
#include "render/render.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 72u
#define HEIGHT 54u
#define FINE 8u /* points of a frame along a side of a pixel */
#define SAMPLES 64u
#define SAMPLES_NOISY 256u
#define BLOCK 9u /* pixels; divides WIDTH and HEIGHT */
#define BOUND 1e-3

static stilb_job_pool *pool;
static stilb_scene_camera camera; /* of the scenes */
static const stilb_scene_camera camera_default = {
	.position = {0.3f, 2.6f, 5.2f}, .yaw = 0.05f, .pitch = -0.35f, .fov_y = 0.75f, .near_z = 0.1f, .far_z = 100.0f};

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static uint32_t add_model(stilb_scene_build *build, uint32_t mesh, const stilb_scene_material *material, stilb_mat4 at)
{
	stilb_scene_build_part part = {mesh, stilb_scene_build_material(build, material)};
	return stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &at), &part, 1);
}

static const stilb_scene_material *look; /* of all parts; NULL: their own */
static const stilb_scene_surface *coat;  /* of the first sphere; NULL: none */

/* Two spheres over a floor, one of which emits a little, in this light; NULL: none. */
static stilb_scene *scene_of(const stilb_scene_light *light, const stilb_scene_surroundings *surroundings)
{
	static const float red[3] = {0.6f, 0.25f, 0.2f}, green[3] = {0.2f, 0.5f, 0.3f}, grey[3] = {0.5f, 0.5f, 0.55f};
	static const float shine[3] = {0.25f, 0.22f, 0.2f};
	stilb_scene_material paint = stilb_scene_material_make(red, shine, 0.55f), glow = paint;
	stilb_scene_material floor = stilb_scene_material_make(grey, shine, 0.7f);
	memcpy(glow.diffuse, green, sizeof green);
	glow.emission[2] = 0.02f;
	if (look)
		paint = glow = floor = *look;
	stilb_scene_mesh sphere, plane;
	assert_int_equal(stilb_scene_mesh_sphere(5, &sphere), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t ball = stilb_scene_build_mesh(build, &sphere), ground = stilb_scene_build_mesh(build, &plane);
	if (coat)
		paint.surface = 1 + stilb_scene_build_surface(build, coat);
	add_model(build, ball, &paint, stilb_mat4_scale_translate(1.0f, -1.1f, 1.0f, 0.0f));
	add_model(build, ball, &glow, stilb_mat4_scale_translate(0.8f, 1.0f, 0.8f, 0.4f));
	add_model(build, ground, &floor, stilb_mat4_scale_translate(4.0f, 0.0f, 0.0f, 0.0f));
	if (light)
		stilb_scene_build_light(build, light);
	if (surroundings)
		stilb_scene_build_surroundings(build, surroundings);
	stilb_scene_build_camera(build, &camera);
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&plane);
	return scene;
}

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

typedef struct picture {
	double value[HEIGHT][WIDTH][3];
} picture;

/* A half float above 0. */
static double half(uint16_t bits)
{
	int exponent = bits >> 10 & 31, mantissa = bits & 1023;
	return exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
}

static stilb_render_ambient ambient; /* of frames */

/* The frame's points, HEIGHT * FINE rows of WIDTH * FINE; to be freed. */
static stilb_image frame_of(stilb_render *render, const stilb_scene *scene, const stilb_render_shading *shading)
{
	stilb_render_pass pass = {.name = "scene"};
	stilb_render_view view = {
		.view_projection = stilb_scene_camera_matrix(&scene->camera, (float)WIDTH / HEIGHT),
		.lights = scene->lights,
		.light_count = scene->light_count,
		.surroundings = scene->surroundings,
		.ambient = ambient,
		.shading = *shading,
	};
	memcpy(view.camera_position, scene->camera.position, sizeof view.camera_position);
	uint32_t ids[3] = {0, 1, 2}, count = scene->model_count;
	stilb_image image = {0};
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, count, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	assert_int_equal(image.format, STILB_IMAGE_F16_LINEAR);
	return image;
}

static const uint16_t *point_of(const stilb_image *image, uint32_t x, uint32_t y)
{
	return (const uint16_t *)image->pixels + 3 * ((size_t)y * image->width + x);
}

static void live_picture(stilb_render *render, const stilb_scene *scene, const stilb_render_shading *shading,
                         picture *out)
{
	stilb_image image = frame_of(render, scene, shading);
	memset(out, 0, sizeof *out);
	for (uint32_t y = 0; y < HEIGHT * FINE; y++)
		for (uint32_t x = 0; x < WIDTH * FINE; x++)
			for (int c = 0; c < 3; c++)
				out->value[y / FINE][x / FINE][c] += half(point_of(&image, x, y)[c]) / (FINE * FINE);
	stilb_image_finish(&image);
}

static void traced_picture_of(const stilb_scene *scene, const stilb_render_shading *shading, uint32_t samples,
                              uint64_t seed, picture *out)
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
	settings.samples = samples;
	settings.seed = seed;
	settings.model = (shade_brdf_model){(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
	assert_int_equal(stilb_gi_render_create(gi, &settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	const float *radiance = stilb_gi_render_film(render).radiance;
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
		out->value[i / 3 / WIDTH][i / 3 % WIDTH][i % 3] = (double)radiance[i];
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
}

static void traced_picture(const stilb_scene *scene, const stilb_render_shading *shading, uint32_t samples,
                           picture *out)
{
	traced_picture_of(scene, shading, samples, stilb_gi_settings_default(scene).seed, out);
}

/* Pixels all of whose points, and those of the pixels around, show one part: inside[y][x]. Found in a frame in which
 * each part emits a value of its own. */
static bool inside[HEIGHT][WIDTH];
static int shown[HEIGHT][WIDTH]; /* 1 + the part's material; 0: none */

/* background: pixels that show no part. */
static void find_inside_of(stilb_render *render, bool background)
{
	stilb_scene *scene = scene_of(NULL, NULL);
	for (uint32_t m = 0; m < scene->material_count; m++)
		scene->materials[m] = (stilb_scene_material){.emission = {(float)(m + 1), 0, 0}, .roughness = 1.0f};
	stilb_image image = frame_of(render, scene, &(stilb_render_shading){0});
	uint32_t count = 0;
	for (uint32_t y = 1; y < HEIGHT - 1; y++)
		for (uint32_t x = 1; x < WIDTH - 1; x++) {
			uint16_t id = point_of(&image, x * FINE, y * FINE)[0];
			inside[y][x] = (id == 0) == background;
			shown[y][x] = (int)half(id);
			for (uint32_t v = (y - 1) * FINE; v < (y + 2) * FINE; v++)
				for (uint32_t u = (x - 1) * FINE; u < (x + 2) * FINE; u++)
					inside[y][x] &= point_of(&image, u, v)[0] == id;
			count += inside[y][x];
		}
	assert_true(count > WIDTH * HEIGHT / (background ? 10 : 2));
	stilb_image_finish(&image);
	stilb_scene_destroy(scene);
}

static void find_inside(stilb_render *render)
{
	find_inside_of(render, false);
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

static void save(const char *folder, const char *name, const char *kind, const picture *a, const picture *b)
{
	char path[512];
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) {
		double first = ((const double *)a->value)[i], second = b ? ((const double *)b->value)[i] : 0.0;
		((float *)image.pixels)[i] = (float)(b ? 100.0 * fabs(first - second) : first);
	}
	snprintf(path, sizeof path, "%s/%s-%s.exr", folder, name, kind);
	assert_int_equal(stilb_image_save(&image, path), STILB_OK);
	stilb_image_finish(&image);
}

/* The largest difference of means over blocks of size x size pixels, of those inside, as a share of the largest value.
 * Blocks of which less than half is inside do not count. */
static double difference(const picture *live, const picture *traced, uint32_t size)
{
	double most = 0.0, apart = 0.0;
	for (uint32_t top = 0; top < HEIGHT; top += size)
		for (uint32_t left = 0; left < WIDTH; left += size)
			for (int c = 0; c < 3; c++) {
				double difference = 0.0;
				uint32_t count = 0;
				for (uint32_t y = top; y < top + size; y++)
					for (uint32_t x = left; x < left + size; x++)
						if (inside[y][x]) {
							count++;
							difference += live->value[y][x][c] - traced->value[y][x][c];
							most = fmax(most, traced->value[y][x][c]);
						}
				if (2 * count >= size * size)
					apart = fmax(apart, fabs(difference) / count);
			}
	assert_true(most > 0.05);
	return apart / most;
}

/* block: see difference. Where rays are noisy, means over blocks are compared; with STILB_TRUTH_SAMPLES=N each pixel
 * after N samples, of which 20,000 bring the standard error below 2e-4. */
static void compare_within(stilb_render *render, const stilb_scene *scene, const stilb_render_shading *shading,
                           uint32_t block, double bound, const char *name)
{
	static picture live, traced;
	const char *folder = getenv("STILB_TRUTH_PICTURES"), *wanted = getenv("STILB_TRUTH_SAMPLES");
	uint32_t samples = block > 1 ? SAMPLES_NOISY : SAMPLES;
	if (wanted && block > 1) {
		samples = (uint32_t)strtoul(wanted, NULL, 10);
		block = 1;
	}
	live_picture(render, scene, shading, &live);
	traced_picture(scene, shading, samples, &traced);
	if (folder) {
		save(folder, name, "live", &live, NULL);
		save(folder, name, "traced", &traced, NULL);
		save(folder, name, "error", &live, &traced);
	}
	double apart = difference(&live, &traced, block);
	printf("%-24s %.1e\n", name, apart);
	assert_true(apart <= bound);
}

static void compare(stilb_render *render, const stilb_scene *scene, const stilb_render_shading *shading, uint32_t block,
                    const char *name)
{
	compare_within(render, scene, shading, block, BOUND, name);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static stilb_render *render_sized(uint32_t width, uint32_t height)
{
	stilb_render_desc desc = {
		.output = STILB_RENDER_OUTPUT_LINEAR, .width = width, .height = height, .samples = 1, .context_count = 1};
	stilb_render *render;
	if (stilb_render_create(&desc, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return render;
}

static stilb_render *render_make(void)
{
	return render_sized(WIDTH * FINE, HEIGHT * FINE);
}

static const struct {
	const char *name;
	stilb_scene_light light;
} lights[] = {
	{"point", {.kind = STILB_SCENE_LIGHT_POINT, .position = {0.2f, 3.0f, 1.5f}, .intensity = {6.0f, 7.0f, 8.0f}}},
	{"point-windowed",
     {.kind = STILB_SCENE_LIGHT_POINT,
      .position = {0.2f, 2.4f, 1.5f},
      .intensity = {6.0f, 7.0f, 8.0f},
      .falloff = STILB_SCENE_LIGHT_WINDOWED,
      .reach = 4.0f}},
	{"point-ranged",
     {.kind = STILB_SCENE_LIGHT_POINT,
      .position = {0.2f, 2.4f, 1.5f},
      .intensity = {6.0f, 7.0f, 8.0f},
      .falloff = STILB_SCENE_LIGHT_RANGED,
      .reach = 4.0f}},
	{"spot",
     {.kind = STILB_SCENE_LIGHT_SPOT,
      .position = {0.5f, 4.0f, 3.0f},
      .direction = {0.0f, -0.8f, -0.6f},
      .intensity = {30.0f, 25.0f, 20.0f},
      .cos_inner = 0.97f,
      .cos_outer = 0.8f}},
	{"directional",
     {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.48f, -0.6f, -0.64f}, .intensity = {3.0f, 2.8f, 2.5f}}},
};

/* With the address sanitizer each light has one of the models, and every third case is drawn: the code is the same. */
enum { MODEL_STEP = TEST_ASAN ? 3 : 1, CASE_STEP = TEST_ASAN ? 3 : 1 };

static void lights_without_a_size_are_as_traced(void **state)
{
	(void)state;
	static const stilb_render_shading models[] = {
		{.brdf = SHADE_BRDF_LAMBERT},
		{.brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED},
		{.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK},
	};
	static const char *const words[] = {"lambert", "blinn-phong", "ggx"};
	stilb_render *render = render_make();
	find_inside(render);
	for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
		stilb_scene *scene = scene_of(&lights[i].light, NULL);
		for (size_t m = i % MODEL_STEP; m < sizeof models / sizeof *models; m += MODEL_STEP) {
			char name[64];
			snprintf(name, sizeof name, "%s-%s", lights[i].name, words[m]);
			compare(render, scene, &models[m], 1, name);
		}
		stilb_scene_destroy(scene);
	}
	stilb_render_destroy(render);
}

/* A light with a size above the floor, and one that the horizons of the spheres and the floor cut. */
static void lights_with_a_size_are_as_traced(void **state)
{
	(void)state;
#define LOW .position = {-0.2f, 1.2f, 2.0f}, .direction = {0.0f, -0.6f, -0.8f}, .intensity = { 4.0f, 5.0f, 6.0f }
#define HIGH .position = {0.5f, 4.0f, 0.5f}, .direction = {0.0f, -1.0f, 0.0f}, .intensity = {30.0f, 25.0f, 20.0f}
	static const struct {
		const char *name;
		stilb_scene_light light;
	} sized[] = {
		{"sphere-high", {.kind = STILB_SCENE_LIGHT_SPHERE, HIGH, .radius = 0.7f}},
		{"sphere-low", {.kind = STILB_SCENE_LIGHT_SPHERE, LOW, .radius = 0.6f}},
		{"disk-high", {.kind = STILB_SCENE_LIGHT_DISK, HIGH, .radius = 1.0f}},
		{"disk-low", {.kind = STILB_SCENE_LIGHT_DISK, LOW, .radius = 0.7f}},
		{"rectangle-high",
	     {.kind = STILB_SCENE_LIGHT_RECTANGLE, HIGH, .half_x = {1.5f, 0.0f, 0.0f}, .half_y = {0.0f, 0.0f, 0.4f}}},
		{"rectangle-low",
	     {.kind = STILB_SCENE_LIGHT_RECTANGLE, LOW, .half_x = {0.9f, 0.0f, 0.0f}, .half_y = {0.0f, 0.64f, -0.48f}}},
		{"sphere-subtracted",
	     {.kind = STILB_SCENE_LIGHT_SPHERE,
	      HIGH,
	      .radius = 0.7f,
	      .falloff = STILB_SCENE_LIGHT_SUBTRACTED,
	      .reach = 6.0f}},
	};
	stilb_render *render = render_make();
	find_inside(render);
	for (size_t i = 0; i < sizeof sized / sizeof *sized; i += CASE_STEP) {
		stilb_scene *scene = scene_of(&sized[i].light, NULL);
		compare(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, BLOCK, sized[i].name);
		stilb_scene_destroy(scene);
	}
	stilb_render_destroy(render);
}

static void surroundings_are_as_traced(void **state)
{
	(void)state;
	stilb_scene_surroundings around = {.sky = {0.6f, 0.8f, 1.2f}, .ground = {0.4f, 0.3f, 0.2f}};
	stilb_render *render = render_make();
	find_inside(render);
	for (int even = 0; even < (TEST_ASAN ? 1 : 2); even++) {
		stilb_scene *scene = scene_of(NULL, &around);
		const char *name = even ? "constant" : "sky";
		compare(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, BLOCK, name);
		stilb_scene_destroy(scene);
		memcpy(around.ground, around.sky, sizeof around.ground);
	}
	stilb_render_destroy(render);
}

/* Sky and ground behind the scene meet at the horizon, also where the camera is not level. */
static void the_ground_is_seen_below_the_horizon(void **state)
{
	(void)state;
	stilb_scene_surroundings around = {.sky = {0.6f, 0.8f, 1.2f}, .ground = {0.4f, 0.3f, 0.2f}};
	static const float looks[][2] = {{-0.2f, 0.0f}, {0.05f, 0.6f}, {-1.0f, 0.0f}, {1.2f, 2.0f}}; /* pitch, roll */
	stilb_render *render = render_make();
	for (size_t i = 0; i < sizeof looks / sizeof *looks; i += CASE_STEP) {
		camera.pitch = looks[i][0];
		camera.roll = looks[i][1];
		camera.position[1] = looks[i][0] < -0.9f ? -1.0f : 2.6f;
		stilb_scene *scene = scene_of(NULL, &around);
		find_inside_of(render, true);
		compare(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, BLOCK, "sky-background");
		stilb_scene_destroy(scene);
	}
	stilb_render_destroy(render);
}

/* Radiance of Lambert's model under the scene's panorama, without noise, where a point of a frame in the middle of
 * pixel x, y is: the ray's surface, and all of the panorama's texels. */
static void exact_at(const stilb_scene *scene, const stilb_gi_scene *gi, uint32_t x, uint32_t y, double out[3])
{
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	gi_camera eye = gi_camera_make(&scene->camera, &settings.lens, WIDTH, HEIGHT);
	gi_ray_hit ray;
	gi_surface surface;
	float middle = ((float)(FINE / 2) + 0.5f) / (float)FINE;
	gi_camera_ray(&eye, (float)x + middle, (float)y + middle, (stilb_vec2){0.5f, 0.5f}, &ray);
	gi->tracer.intersect(&gi->tracer, &ray);
	assert_true(gi_is_hit(&ray));
	gi_surface_at(gi, &ray, &surface);
	double n[3] = {(double)surface.normal[0], (double)surface.normal[1], (double)surface.normal[2]};
	panorama_exact(&scene->surroundings.panorama, (double)scene->surroundings.rotation, n, out);
	for (int c = 0; c < 3; c++)
		out[c] = out[c] * (double)surface.diffuse[c] / M_PI + (double)surface.emission[c];
}

/* The largest difference of a frame's points from what they are exactly, as a share of the largest value. */
static double difference_exact(stilb_render *render, const stilb_scene *scene, uint32_t step)
{
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	stilb_gi_scene *gi;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	stilb_image image = frame_of(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT});
	double most = 0.0, apart = 0.0, squares = 0.0, count = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y += step)
		for (uint32_t x = y / step % 2; x < WIDTH; x += step) {
			double exact[3];
			if (!inside[y][x])
				continue;
			exact_at(scene, gi, x, y, exact);
			for (int c = 0; c < 3; c++, count++) {
				double d = fabs(half(point_of(&image, x * FINE + FINE / 2, y * FINE + FINE / 2)[c]) - exact[c]);
				apart = fmax(apart, d);
				squares += d * d;
				most = fmax(most, exact[c]);
			}
		}
	assert_true(most > 0.05 && count > 150.0);
	printf("rms %.1e of %g values, worst %.1e\n", sqrt(squares / count) / most, count, apart / most);
	stilb_image_finish(&image);
	stilb_gi_scene_destroy(gi);
	return apart / most;
}

/* A day: a sky that grows darker to the zenith over a brown ground, with a sun of half a degree in half of its texel,
 * or without; or a night: three windows of different size and colour, and faint noise. Or a dim sky with a lamp of two
 * degrees that the floor's horizon halves; or light without edges. */
typedef enum panorama_kind { PANORAMA_EVEN, PANORAMA_SUN, PANORAMA_ROOM, PANORAMA_LOW, PANORAMA_SMOOTH } panorama_kind;

static void panorama_texel(panorama_kind kind, uint32_t x, uint32_t y, uint32_t width, uint32_t height, float out[3])
{
	float phi = 6.2831853f * ((float)x + 0.5f) / (float)width,
		  up = cosf(3.1415927f * ((float)y + 0.5f) / (float)height);
	static const float windows[3][7] = {{0.10f, 0.22f, 0.35f, 0.55f, 9.0f, 8.0f, 6.0f},
	                                    {0.55f, 0.58f, 0.30f, 0.60f, 2.0f, 4.0f, 9.0f},
	                                    {0.80f, 0.81f, 0.20f, 0.22f, 300.0f, 90.0f, 30.0f}};
	float u = ((float)x + 0.5f) / (float)width, v = ((float)y + 0.5f) / (float)height;
	for (int c = 0; c < 3; c++) {
		out[c] = up > 0.0f ? 0.4f + 0.2f * (float)c - 0.25f * up + 0.1f * cosf(phi) : 0.3f - 0.05f * (float)c;
		if (kind == PANORAMA_SUN && x == width * 7 / 10 && y == height / 5)
			out[c] = 30000.0f - 4000.0f * (float)c;
		if (kind == PANORAMA_LOW)
			out[c] = x / 2 == width / 14 && y + 2 >= height / 2 && y < height / 2 + 2 ? 400.0f : 0.05f;
		if (kind == PANORAMA_SMOOTH)
			out[c] = 0.5f + 0.1f * (float)c * up + 0.2f * up * up * up + 0.15f * cosf(phi) * sqrtf(1.0f - up * up);
		if (kind != PANORAMA_ROOM)
			continue;
		out[c] = 0.02f * (float)((x * 7 + y * 13 + (uint32_t)c * 5) % 11);
		for (int w = 0; w < 3; w++)
			if (u > windows[w][0] && u < windows[w][1] && v > windows[w][2] && v < windows[w][3])
				out[c] = windows[w][4 + c];
	}
}

static stilb_scene_surroundings panorama_of(panorama_kind kind, uint32_t width)
{
	stilb_scene_surroundings around = {.rotation = 1.0f};
	uint32_t height = width / 2;
	assert_int_equal(stilb_image_create(&around.panorama, width, height, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++)
			panorama_texel(kind, x, y, width, height, (float *)around.panorama.pixels + 3 * ((size_t)y * width + x));
	return around;
}

/* Matt surfaces under panoramas of any size, turned, and the panoramas behind them. */
static void panoramas_are_as_traced(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		panorama_kind kind;
		uint32_t width;
		double
			bound; /* measured 1.2e-3, 8.7e-4 and 3.7e-3, mostly noise: with 4,096 samples 8.5e-4, 4.8e-4 and 1.2e-3 */
	} cases[] = {{"panorama-even", PANORAMA_EVEN, 90, 1.6e-3},
	             {"panorama-sun", PANORAMA_SUN, 720, 1.2e-3},
	             {"panorama-room", PANORAMA_ROOM, 500, 4.5e-3}};
	stilb_render *render = render_make();
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		stilb_scene_surroundings around = panorama_of(cases[i].kind, cases[i].width);
		stilb_scene *scene = scene_of(NULL, &around);
		find_inside(render);
		compare_within(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, BLOCK, cases[i].bound,
		               cases[i].name);
		assert_true(difference_exact(render, scene, 4) <= BOUND);
		stilb_scene_destroy(scene);
		stilb_image_finish(&around.panorama);
	}
	stilb_scene_surroundings low = panorama_of(PANORAMA_LOW, 720);
	stilb_scene *lit = scene_of(NULL, &low);
	find_inside(render);
	assert_true(difference_exact(render, lit, 4) <= BOUND);
	stilb_scene_destroy(lit);
	stilb_image_finish(&low.panorama);
	stilb_scene_surroundings around = panorama_of(PANORAMA_ROOM, 90);
	stilb_scene *scene = scene_of(NULL, &around);
	find_inside_of(render, true);
	compare(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, BLOCK, "panorama-background");
	stilb_scene_destroy(scene);
	stilb_image_finish(&around.panorama);
	stilb_render_destroy(render);
}

/* ---- furnace ----------------------------------------------------------------------------------------------------- */

#define FURNACE_LIGHTS 3000u
#define FURNACE_WIDTH 16u /* points of the picture; as wide for its height as the others */
#define FURNACE_HEIGHT 12u

/* A white ball of this material in light. */
static stilb_scene *furnace_of(const stilb_scene_material *white, const stilb_scene_light *lamps, uint32_t count,
                               const stilb_scene_surroundings *around)
{
	stilb_scene_mesh sphere;
	assert_int_equal(stilb_scene_mesh_sphere(5, &sphere), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	add_model(build, stilb_scene_build_mesh(build, &sphere), white, stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f));
	for (uint32_t i = 0; i < count; i++)
		stilb_scene_build_light(build, &lamps[i]);
	if (around)
		stilb_scene_build_surroundings(build, around);
	stilb_scene_build_camera(
		build, &(stilb_scene_camera){.position = {0.0f, 0.0f, 3.0f}, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 10.0f});
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_mesh_finish(&sphere);
	return scene;
}

/* A matt white ball in surroundings of radiance 1 is not seen: every point of the frame is 1. By two colours and by a
 * panorama, with a texel of which is brighter by nothing. */
static void a_matt_ball_vanishes_in_the_furnace(void **state)
{
	(void)state;
	stilb_scene_material white = stilb_scene_material_make((float[3]){1, 1, 1}, (float[3]){0, 0, 0}, 1.0f);
	stilb_scene_surroundings around = {.sky = {1, 1, 1}, .ground = {1, 1, 1}};
	stilb_render *render = render_make();
	for (int panorama = 0; panorama < 2; panorama++) {
		if (panorama) {
			assert_int_equal(stilb_image_create(&around.panorama, 30, 15, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
			for (uint32_t i = 0; i < 30 * 15 * 3; i++)
				((float *)around.panorama.pixels)[i] = 1.0f;
		}
		stilb_scene *scene = furnace_of(&white, NULL, 0, &around);
		stilb_image image = frame_of(render, scene, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT});
		double apart = 0.0;
		for (uint32_t y = 0; y < HEIGHT * FINE; y++)
			for (uint32_t x = 0; x < WIDTH * FINE; x++)
				for (int c = 0; c < 3; c++)
					apart = fmax(apart, fabs(half(point_of(&image, x, y)[c]) - 1.0));
		printf("furnace-lambert-%s %.1e\n", panorama ? "panorama" : "sky", apart);
		assert_true(apart <= (panorama ? BOUND : 0x1p-11)); /* a half float below 1 */
		stilb_image_finish(&image);
		stilb_scene_destroy(scene);
	}
	stilb_image_finish(&around.panorama);
	stilb_render_destroy(render);
}

/* Light of radiance 1 from everywhere, as directional lights evenly over the sphere (Fibonacci's spiral). */
static void furnace_lights(stilb_scene_light *lamps)
{
	for (uint32_t i = 0; i < FURNACE_LIGHTS; i++) {
		float height = 1.0f - (2.0f * (float)i + 1.0f) / (float)FURNACE_LIGHTS;
		float level = sqrtf(1.0f - height * height), turn = (float)fmod(2.399963229728653 * i, 2.0 * M_PI);
		float light = 4.0f * 3.14159265f / (float)FURNACE_LIGHTS;
		lamps[i] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
		                               .direction = {level * cosf(turn), height, level * sinf(turn)},
		                               .intensity = {light, light, light}};
	}
}

/* The albedo, by quadrature, of the ball's surface that a point shows; 0: it shows none, or a slanted one. */
static double furnace_albedo(const stilb_gi_scene *gi, const gi_camera *eye, const shade_brdf_model *model,
                             const shade_brdf_parameters *parameters, uint32_t x, uint32_t y)
{
	gi_ray_hit ray;
	gi_surface surface;
	gi_camera_ray(eye, (float)x + 0.5f, (float)y + 0.5f, (stilb_vec2){0.5f, 0.5f}, &ray);
	gi->tracer.intersect(&gi->tracer, &ray);
	if (!gi_is_hit(&ray))
		return 0.0;
	gi_surface_at(gi, &ray, &surface);
	double cosine = -(double)stilb_vec3_dot(surface.normal, gi_ray_direction(&ray.ray));
	if (cosine < 0.3)
		return 0.0;
	return stilb_numeric_albedo_of_view(model, parameters, (stilb_numeric_angles){.polar = acos(fmin(cosine, 1.0))});
}

/* In frames a ball of a glossy model under even light is as bright as the model's albedo says. The light comes from
 * some thousand directions, so the bound is theirs: highlights that are narrower need more. */
static void glossy_balls_have_their_albedo(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		float roughness;
		shade_brdf_model model;
	} cases[] = {
		{"blinn-phong", 0.6f, {.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED}},
		{"phong", 0.7f, {.kind = SHADE_BRDF_PHONG_MODIFIED}},
		{"ggx", 0.5f, {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK}},
		{"ggx", 1.0f, {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK}},
	};
	static stilb_scene_light lamps[FURNACE_LIGHTS];
	stilb_render *render = render_sized(FURNACE_WIDTH, FURNACE_HEIGHT);
	furnace_lights(lamps);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i += CASE_STEP) {
		stilb_scene_material white =
			stilb_scene_material_make((float[3]){0, 0, 0}, (float[3]){1, 1, 1}, cases[i].roughness);
		stilb_render_shading shading = {.brdf = (uint32_t)cases[i].model.kind,
		                                .ndf = (uint32_t)cases[i].model.ndf,
		                                .g = (uint32_t)cases[i].model.g,
		                                .f = (uint32_t)cases[i].model.f};
		stilb_scene *scene = furnace_of(&white, lamps, FURNACE_LIGHTS, NULL);
		stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		stilb_gi_settings settings = stilb_gi_settings_default(scene);
		gi_camera eye = gi_camera_make(&scene->camera, &settings.lens, FURNACE_WIDTH, FURNACE_HEIGHT);
		shade_brdf_parameters parameters = stilb_numeric_white(cases[i].roughness, 0.0f);
		stilb_image image = frame_of(render, scene, &shading);
		double apart = 0.0, least = 2.0, most = 0.0;
		for (uint32_t y = 0; y < FURNACE_HEIGHT; y++)
			for (uint32_t x = 0; x < FURNACE_WIDTH; x++) {
				double albedo = furnace_albedo(gi, &eye, &cases[i].model, &parameters, x, y);
				if (albedo > 0.0)
					apart = fmax(apart, fabs(half(point_of(&image, x, y)[1]) - albedo));
				least = albedo > 0.0 ? fmin(least, albedo) : least;
				most = fmax(most, albedo);
			}
		printf("furnace-%s-%.1f albedo %.3f..%.3f, %.1e\n", cases[i].name, (double)cases[i].roughness, least, most,
		       apart / most);
		assert_true(most > 0.3 && apart <= BOUND * most);
		stilb_image_finish(&image);
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
	stilb_render_destroy(render);
}

/* ---- gloss under panoramas --------------------------------------------------------------------------------------- */

static const stilb_render_shading ggx = {
	.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};

/* A white metal ball under a panorama of 1 has the albedo of its model, so it shines at most as bright. */
static void a_metal_ball_stays_dark_in_the_furnace(void **state)
{
	(void)state;
	static const float roughness[] = {0.05f, 0.3f, 0.6f, 1.0f};
	static const shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
	stilb_scene_surroundings around = {.rotation = 0.5f};
	assert_int_equal(stilb_image_create(&around.panorama, 30, 15, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 30 * 15 * 3; i++)
		((float *)around.panorama.pixels)[i] = 1.0f;
	stilb_render *render = render_sized(FURNACE_WIDTH, FURNACE_HEIGHT);
	for (size_t i = 0; i < sizeof roughness / sizeof *roughness; i++) {
		stilb_scene_material white = stilb_scene_material_make((float[3]){0, 0, 0}, (float[3]){1, 1, 1}, roughness[i]);
		stilb_scene *scene = furnace_of(&white, NULL, 0, &around);
		stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		stilb_gi_settings settings = stilb_gi_settings_default(scene);
		gi_camera eye = gi_camera_make(&scene->camera, &settings.lens, FURNACE_WIDTH, FURNACE_HEIGHT);
		shade_brdf_parameters parameters = stilb_numeric_white(roughness[i], 0.0f);
		stilb_image image = frame_of(render, scene, &ggx);
		double apart = 0.0, most = 0.0;
		for (uint32_t y = 0; y < FURNACE_HEIGHT; y++)
			for (uint32_t x = 0; x < FURNACE_WIDTH; x++) {
				double value = half(point_of(&image, x, y)[1]);
				double albedo = furnace_albedo(gi, &eye, &model, &parameters, x, y);
				apart = albedo > 0.0 ? fmax(apart, fabs(value - albedo)) : apart;
				most = fmax(most, value);
			}
		printf("furnace-panorama-%.2f %.1e from its albedo, %.4f at most\n", (double)roughness[i], apart, most);
		assert_true(most <= 1.0 + 2e-3 && apart <= 2e-3);
		stilb_image_finish(&image);
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
	stilb_image_finish(&around.panorama);
	stilb_render_destroy(render);
}

/* Two balls of GGX over a floor without gloss: a metal and a dielectric of this roughness. surface: the metal is a
 * file's. */
static stilb_scene *gloss_balls(float roughness, bool surface, const stilb_scene_surroundings *around)
{
	static const float gold[4] = {0.95f, 0.8f, 0.5f, 1.0f}, none[3] = {0, 0, 0};
	stilb_scene_surface metal = stilb_scene_surface_make();
	memcpy(metal.color, gold, sizeof gold);
	metal.metalness = 1.0f;
	metal.roughness = roughness;
	coat = surface ? &metal : NULL;
	stilb_scene *scene = scene_of(NULL, around);
	coat = NULL;
	assert_int_equal(scene->material_count, 3);
	uint32_t kept = scene->materials[0].surface;
	assert_int_equal(kept, surface);
	scene->materials[0] = stilb_scene_material_make(none, gold, roughness);
	scene->materials[0].surface = kept;
	scene->materials[1] =
		stilb_scene_material_make((float[3]){0.2f, 0.4f, 0.3f}, (float[3]){0.04f, 0.04f, 0.04f}, roughness);
	scene->materials[2] = stilb_scene_material_make((float[3]){0.5f, 0.5f, 0.5f}, none, 1.0f);
	return scene;
}

/* Of the pixels inside that show one ball: as a share of its largest value. */
typedef struct gloss_apart {
	double rms, worst;
} gloss_apart;

static gloss_apart gloss_compare(const picture *live, const picture *traced, int ball)
{
	double most = 0.0, count = 0.0;
	gloss_apart apart = {0.0, 0.0};
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int c = 0; c < 3 && inside[y][x] && shown[y][x] == ball + 1; c++, count++) {
				double d = fabs(live->value[y][x][c] - traced->value[y][x][c]);
				apart.worst = fmax(apart.worst, d);
				apart.rms += d * d;
				most = fmax(most, traced->value[y][x][c]);
			}
	assert_true(count > 300.0 && most > 0.05);
	return (gloss_apart){sqrt(apart.rms / count) / most, apart.worst / most};
}

/* Gloss under turned panoramas: one without edges, a day, and the day with a sun. */
static void gloss_under_panoramas_is_as_traced(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		panorama_kind kind;
		float roughness;
		double rms[2], worst[2]; /* bounds of metal and dielectric */
		bool surface;
	} cases[] = {
		{"smooth", PANORAMA_SMOOTH, 0.2f, {0.01, 0.01}, {0.03, 0.03}, false},
		{"smooth", PANORAMA_SMOOTH, 0.5f, {0.01, 0.01}, {0.03, 0.03}, false},
		{"smooth", PANORAMA_SMOOTH, 0.8f, {0.01, 0.01}, {0.03, 0.03}, false},
		{"day", PANORAMA_EVEN, 0.5f, {0.0125, 0.01}, {0.05, 0.06}, false},
		{"sun", PANORAMA_SUN, 0.2f, {0.0125, 0.0125}, {0.2, 0.2}, false}, /* noise */
		{"sun", PANORAMA_SUN, 0.5f, {0.01, 0.01}, {0.05, 0.05}, true},
		{"sun", PANORAMA_SUN, 0.8f, {0.01, 0.01}, {0.05, 0.05}, false},
	};
	static picture live, traced;
	const char *folder = getenv("STILB_TRUTH_PICTURES"), *wanted = getenv("STILB_TRUTH_SAMPLES");
	uint32_t samples = wanted ? (uint32_t)strtoul(wanted, NULL, 10) : SAMPLES_NOISY;
	stilb_render *render = render_make();
	find_inside(render);
	bool good = true;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		stilb_scene_surroundings around = panorama_of(cases[i].kind, cases[i].kind == PANORAMA_SUN ? 720 : 90);
		stilb_scene *scene = gloss_balls(cases[i].roughness, cases[i].surface, &around);
		live_picture(render, scene, &ggx, &live);
		traced_picture(scene, &ggx, samples, &traced);
		for (int ball = 0; ball < 2; ball++) {
			gloss_apart apart = gloss_compare(&live, &traced, ball);
			printf("gloss-%s-%s-%.1f rms %.2f %%, worst %.1f %%\n", cases[i].name, ball ? "dielectric" : "metal",
			       (double)cases[i].roughness, 100.0 * apart.rms, 100.0 * apart.worst);
			good &= apart.rms <= cases[i].rms[ball] && apart.worst <= cases[i].worst[ball];
		}
		if (folder) {
			char name[64];
			snprintf(name, sizeof name, "gloss-%s-%.1f", cases[i].name, (double)cases[i].roughness);
			save(folder, name, "live", &live, NULL);
			save(folder, name, "traced", &traced, NULL);
		}
		stilb_scene_destroy(scene);
		stilb_image_finish(&around.panorama);
	}
	assert_true(good);
	stilb_render_destroy(render);
}

/* ---- the table of docs/rendering.md ------------------------------------------------------------------------------ */

#define GLOSS_ROUGHNESSES 4
#define GLOSS_SIDE 2u /* pixels of a pixel in the pictures */

static const struct {
	const char *name;
	stilb_render_shading shading;
} gloss_models[] = {
	{"phong-modified", {.brdf = SHADE_BRDF_PHONG_MODIFIED}},
	{"blinn-phong-modified", {.brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED}},
	{"microfacet (ggx)",
     {.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK}},
};

static const float gloss_roughness[GLOSS_ROUGHNESSES] = {0.1f, 0.3f, 0.6f, 1.0f};

/* Light of the scenes, of which one member is used. */
typedef struct gloss_light {
	const char *name;
	stilb_scene_light light;
	bool sky;
	panorama_kind panorama;
} gloss_light;

static const gloss_light gloss_lights[] = {
#define GLOSS_AREA .position = {0.5f, 3.0f, 1.0f}, .direction = {0.0f, -0.8f, -0.6f}, .intensity = {12.0f, 10.0f, 8.0f}
	{"sphere", {.kind = STILB_SCENE_LIGHT_SPHERE, GLOSS_AREA, .radius = 0.5f}, false, PANORAMA_EVEN},
	{"disk", {.kind = STILB_SCENE_LIGHT_DISK, GLOSS_AREA, .radius = 0.6f}, false, PANORAMA_EVEN},
	{"rectangle",
     {.kind = STILB_SCENE_LIGHT_RECTANGLE, GLOSS_AREA, .half_x = {1.0f, 0.0f, 0.0f}, .half_y = {0.0f, 0.18f, -0.24f}},
     false,
     PANORAMA_EVEN},
	{"two-colour sky", {.intensity = {0.0f}}, true, PANORAMA_EVEN},
	{"panorama with a sun", {.intensity = {0.0f}}, true, PANORAMA_SUN},
	{"panorama of a room", {.intensity = {0.0f}}, true, PANORAMA_ROOM},
};

#define GLOSS_LIGHTS (sizeof gloss_lights / sizeof *gloss_lights)
#define GLOSS_MODELS (sizeof gloss_models / sizeof *gloss_models)

static stilb_scene *gloss_scene(const gloss_light *light)
{
	stilb_scene_surroundings around = {.sky = {0.6f, 0.8f, 1.2f}, .ground = {0.4f, 0.3f, 0.2f}, .glossy = true};
	if (light->panorama != PANORAMA_EVEN) {
		around = panorama_of(light->panorama, 500);
		around.glossy = false;
	}
	stilb_scene *scene = light->sky ? scene_of(NULL, &around) : scene_of(&light->light, NULL);
	stilb_image_finish(&around.panorama);
	return scene;
}

typedef struct gloss_error {
	double rms, worst, noise;
} gloss_error;

/* Of frames against two pictures of rays, whose difference tells the noise of their mean; shares of the largest value
 * of a pixel. */
static gloss_error gloss_measure(const picture *live, const picture *one, const picture *two)
{
	gloss_error e = {0};
	double most = 0.0, count = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int c = 0; c < 3 && inside[y][x]; c++, count++) {
				double mean = 0.5 * (one->value[y][x][c] + two->value[y][x][c]), d = fabs(live->value[y][x][c] - mean);
				double noise = 0.5 * (one->value[y][x][c] - two->value[y][x][c]);
				most = fmax(most, mean);
				e.worst = fmax(e.worst, d);
				e.rms += d * d;
				e.noise += noise * noise;
			}
	return (gloss_error){sqrt(e.rms / count) / most, e.worst / most, sqrt(e.noise / count) / most};
}

/* Writes frames, rays and five times their difference side by side, with the mean of the models at a quarter, to row
 * `row` of a sheet of sRGB codes. */
static void gloss_draw(stilb_image *sheet, uint32_t row, const picture *live, const picture *traced)
{
	double sum = 0.0, count = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			for (int c = 0; c < 3 && inside[y][x]; c++, count++)
				sum += traced->value[y][x][c];
	double factor = 0.25 * count / sum;
	for (uint32_t y = 0; y < HEIGHT * GLOSS_SIDE; y++)
		for (uint32_t x = 0; x < 3 * WIDTH * GLOSS_SIDE; x++)
			for (uint32_t c = 0; c < 3; c++) {
				const double *a = live->value[y / GLOSS_SIDE][x / GLOSS_SIDE % WIDTH];
				const double *b = traced->value[y / GLOSS_SIDE][x / GLOSS_SIDE % WIDTH];
				uint32_t which = x / (WIDTH * GLOSS_SIDE);
				double value = which == 0 ? a[c] : which == 1 ? b[c] : 5.0 * fabs(a[c] - b[c]);
				size_t at = ((size_t)(row * HEIGHT * GLOSS_SIDE + y) * sheet->width + x) * 3 + c;
				((uint8_t *)sheet->pixels)[at] = (uint8_t)(255.0 * pow(fmin(factor * value, 1.0), 1.0 / 2.2) + 0.5);
			}
}

/* Prints frames against rays for every kind of light, model and roughness, as Markdown; folder: pictures are written
 * there, of GGX and roughness 0.3. samples: of a pixel, for each of two pictures by rays. */
static void gloss_table(uint32_t samples, const char *folder)
{
	static picture live, one, two;
	stilb_render *render = render_make();
	stilb_image sheet;
	double noise = 0.0;
	assert_int_equal(
		stilb_image_create(&sheet, 3 * WIDTH * GLOSS_SIDE, GLOSS_LIGHTS * HEIGHT * GLOSS_SIDE, 3, STILB_IMAGE_U8_SRGB),
		STILB_OK);
	find_inside(render);
	printf("| light | BRDF | 0.1 | 0.3 | 0.6 | 1.0 |\n|---|---|---|---|---|---|\n");
	for (uint32_t l = 0; l < GLOSS_LIGHTS; l++)
		for (uint32_t m = 0; m < GLOSS_MODELS; m++) {
			printf("| %s | %s |", gloss_lights[l].name, gloss_models[m].name);
			for (int r = 0; r < GLOSS_ROUGHNESSES; r++) {
				stilb_scene_material material = stilb_scene_material_make(
					(float[3]){0.3f, 0.3f, 0.3f}, (float[3]){0.5f, 0.5f, 0.5f}, gloss_roughness[r]);
				look = &material;
				stilb_scene *scene = gloss_scene(&gloss_lights[l]);
				live_picture(render, scene, &gloss_models[m].shading, &live);
				traced_picture_of(scene, &gloss_models[m].shading, samples, 1, &one);
				traced_picture_of(scene, &gloss_models[m].shading, samples, 2, &two);
				gloss_error e = gloss_measure(&live, &one, &two);
				noise = fmax(noise, e.noise);
				printf(" %.1f %% (%.0f %%) |", 100.0 * e.rms, 100.0 * e.worst);
				fflush(stdout);
				if (m == GLOSS_MODELS - 1 && r == 1)
					gloss_draw(&sheet, l, &live, &one);
				stilb_scene_destroy(scene);
				look = NULL;
			}
			printf("\n");
		}
	printf("\nNoise of the rays: %.2f %% at most (RMS).\n", 100.0 * noise);
	char path[512];
	snprintf(path, sizeof path, "%s/gloss.png", folder ? folder : ".");
	if (folder)
		assert_int_equal(stilb_image_save(&sheet, path), STILB_OK);
	stilb_image_finish(&sheet);
	stilb_render_destroy(render);
}

/* ---- ambient light ----------------------------------------------------------------------------------------------- */

typedef struct ambient_case {
	const char *name;
	bool panorama;
	panorama_kind kind;
	double off; /* of matt surfaces by SH_PIXEL: of the largest value, RMS */
} ambient_case;

/* Three bands hold 99.2 % of the cosine's square, so that of one narrow light, the worst case, a root of the mean
 * square of 3.7 % of the largest irradiance is left; where it is blurred lest it be negative, up to 15.6 %, the loss
 * where a surface faces it. Of sky and ground they are exact, and it is the noise of rays. */
static const ambient_case ambient_cases[] = {
	{"sky and ground", false, PANORAMA_EVEN, 1e-3},
	{"light without edges", true, PANORAMA_SMOOTH, 0.037},
	{"sky with a sun", true, PANORAMA_SUN, 0.037}, /* which is a light */
	{"room with windows", true, PANORAMA_ROOM, 0.156},
};

#define AMBIENT_CASES (sizeof ambient_cases / sizeof *ambient_cases)

static stilb_scene *ambient_scene(const ambient_case *c)
{
	stilb_scene_surroundings around = {.sky = {0.6f, 0.8f, 1.2f}, .ground = {0.4f, 0.3f, 0.2f}, .glossy = true};
	if (c->panorama)
		around = panorama_of(c->kind, 360);
	stilb_scene *scene = scene_of(NULL, &around);
	stilb_image_finish(&around.panorama);
	return scene;
}

static const stilb_scene_material ambient_matt = {.diffuse = {0.7f, 0.6f, 0.5f}, .roughness = 1.0f};

/* How far frames by each kind are from rays. */
static void ambient_measure(stilb_render *render, const ambient_case *c, const stilb_scene_material *material,
                            const stilb_render_shading *shading, uint32_t samples,
                            gloss_error errors[STILB_RENDER_AMBIENT_KINDS])
{
	static picture live, one, two;
	look = material;
	stilb_scene *scene = ambient_scene(c);
	traced_picture_of(scene, shading, samples, 1, &one);
	traced_picture_of(scene, shading, samples, 2, &two);
	for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
		ambient = (stilb_render_ambient)kind;
		live_picture(render, scene, shading, &live);
		errors[kind] = gloss_measure(&live, &one, &two);
	}
	ambient = STILB_RENDER_AMBIENT_ENVIRONMENT;
	stilb_scene_destroy(scene);
	look = NULL;
}

static void ambient_light_is_as_traced(void **state)
{
	(void)state;
	stilb_render *render = render_make();
	find_inside(render);
	for (size_t i = 0; i < AMBIENT_CASES; i++) {
		gloss_error errors[STILB_RENDER_AMBIENT_KINDS];
		const ambient_case *c = &ambient_cases[i];
		ambient_measure(render, c, &ambient_matt, &(stilb_render_shading){.brdf = SHADE_BRDF_LAMBERT}, SAMPLES_NOISY,
		                errors);
		double noise = errors[0].noise;
		for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++)
			printf("%-20s %-12s %.1e\n", c->name, stilb_render_ambient_names[kind], errors[kind].rms);
		printf("%-20s %-12s %.1e\n", c->name, "noise", noise);
		assert_true(errors[STILB_RENDER_AMBIENT_ENVIRONMENT].rms <= BOUND + noise);
		assert_true(errors[STILB_RENDER_AMBIENT_SH_PIXEL].rms <= c->off + noise);
		assert_true(errors[STILB_RENDER_AMBIENT_SH_VERTEX].rms <= c->off + noise);
		assert_true(errors[STILB_RENDER_AMBIENT_SH_PIXEL].rms < errors[STILB_RENDER_AMBIENT_CONSTANT].rms);
		if (!c->panorama)
			assert_true(errors[STILB_RENDER_AMBIENT_HEMISPHERE].rms <= BOUND + noise);
	}
	stilb_render_destroy(render);
}

/* Prints how far frames by each kind are from rays, as Markdown. samples: of a pixel, for each of two pictures. */
static void ambient_table(uint32_t samples)
{
	static const stilb_scene_material metal = {.specular = {0.9f, 0.7f, 0.4f}, .roughness = 0.3f},
									  rough = {.specular = {0.9f, 0.7f, 0.4f}, .roughness = 0.7f};
	static const struct {
		const char *name;
		const stilb_scene_material *material;
		stilb_render_shading shading;
	} looks[] = {
		{"matt", &ambient_matt, {.brdf = SHADE_BRDF_LAMBERT}},
		{"metal, roughness 0.7",
	     &rough,
	     {.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK}},
		{"metal, roughness 0.3",
	     &metal,
	     {.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK}},
	};
	stilb_render *render = render_make();
	double noise = 0.0;
	find_inside(render);
	printf("| surroundings | surface |");
	for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++)
		printf(" %s |", stilb_render_ambient_names[kind]);
	printf("\n|---|---|---|---|---|---|---|---|\n");
	for (size_t i = 0; i < AMBIENT_CASES; i++)
		for (size_t l = 0; l < sizeof looks / sizeof *looks; l++) {
			gloss_error errors[STILB_RENDER_AMBIENT_KINDS];
			ambient_measure(render, &ambient_cases[i], looks[l].material, &looks[l].shading, samples, errors);
			printf("| %s | %s |", ambient_cases[i].name, looks[l].name);
			for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++)
				printf(" %.1f %% |", 100.0 * errors[kind].rms);
			printf("\n");
			fflush(stdout);
			noise = fmax(noise, errors[0].noise);
		}
	printf("\nNoise of the rays: %.2f %% at most (RMS).\n", 100.0 * noise);
	stilb_render_destroy(render);
}

static int level(void **state)
{
	(void)state;
	camera = camera_default;
	return 0;
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

/* With `gloss [SAMPLES]` it prints the table of how far highlights in frames are from rays, with `ambient [SAMPLES]`
 * that of ambient light. */
int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(lights_without_a_size_are_as_traced, level),
		cmocka_unit_test_setup(lights_with_a_size_are_as_traced, level),
		cmocka_unit_test_setup(surroundings_are_as_traced, level),
		cmocka_unit_test_setup(the_ground_is_seen_below_the_horizon, level),
		cmocka_unit_test_setup(TEST_ASAN ? test_skip : panoramas_are_as_traced, level), /* test_render_panorama */
		cmocka_unit_test(a_matt_ball_vanishes_in_the_furnace),
		cmocka_unit_test(a_metal_ball_stays_dark_in_the_furnace),
		cmocka_unit_test_setup(TEST_ASAN ? test_skip : gloss_under_panoramas_is_as_traced, level),
		cmocka_unit_test(glossy_balls_have_their_albedo),
		cmocka_unit_test_setup(TEST_ASAN ? test_skip : ambient_light_is_as_traced, level),
	};
	if (argc > 1 && strcmp(argv[1], "gloss") == 0) {
		set_up(NULL);
		level(NULL);
		gloss_table(argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 1024, getenv("STILB_TRUTH_PICTURES"));
		return tear_down(NULL);
	}
	if (argc > 1 && strcmp(argv[1], "ambient") == 0) {
		set_up(NULL);
		level(NULL);
		ambient_table(argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 1024);
		return tear_down(NULL);
	}
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
