/* Pictures of one or few models against closed forms: positions, depth order, brightness. */
#include "support/picture_reference.h"
#include "tests/engine/stress_engine.h"

#include "engine_internal.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#define SIZE 96u

static const dvec north = {0, 0, -1}, above = {0, 1, 0};

/* A camera at `height` metres above the origin that looks straight down; -Z is up in the picture. */
static reference_camera from_above(double height, double focal, uint32_t size)
{
	return reference_camera_at((dvec){0, height, 0}, (dvec){0, 0, 0}, north, focal, size, size);
}

static reference_camera from_aside(void)
{
	return reference_camera_at((dvec){1.7, 2.6, 3.1}, (dvec){0.1, 0.3, -0.1}, above, 1.6, SIZE + 32, SIZE);
}

/* A sphere over a tile, as in the stress test, in a light to which every term of the formula contributes. */
static stilb_scene *model_scene(float radius, float height, float specular)
{
	stilb_scene *scene = reference_scene(2);
	scene->part_mesh[1] = 1;
	scene->part_transform[0] = stilb_mat4_scale_translate(radius, 0.0f, height, 0.0f);
	for (int p = 0; p < 2; p++)
		reference_set3(scene->materials[p].specular, specular, 0.5f * specular, 0.25f * specular);
	reference_set3(scene->materials[0].diffuse, 0.7f, 0.2f, 0.1f);
	reference_set3(scene->materials[1].diffuse, 0.1f, 0.3f, 0.6f);
	reference_sun_from(scene, 0.48f, 0.8f, 0.36f);
	reference_set3(scene->lights[0].intensity, 3.0f, 2.5f, 2.0f);
	reference_set3(scene->surroundings.sky, 0.3f, 0.45f, 4.0f);
	reference_set3(scene->surroundings.ground, 0.2f, 0.1f, 0.05f);
	return scene;
}

/* Moves the sphere below the tile, which hides it from above. */
static void without_sphere(stilb_scene *scene)
{
	scene->part_transform[0] = stilb_mat4_scale_translate(0.001f, 0.0f, -5.0f, 0.0f);
}

static void without_tile(stilb_scene *scene)
{
	scene->part_transform[1] = stilb_mat4_scale_translate(0.001f, 0.0f, -5.0f, 0.0f);
}

/* ---- positions --------------------------------------------------------------------------------------------------- */

static const picture_desc linear = {.output = STILB_RENDER_OUTPUT_LINEAR};

/* A tile of 2 m seen from h above is a square of focal / h * SIZE pixels; without highlight every point of it has the
 * radiance diffuse / pi E (n.l) + diffuse * sky, n = +Y. */
static void a_tile_is_its_square(void **state)
{
	(void)state;
	stilb_scene *scene = model_scene(1.0f, 0.0f, 0.0f);
	without_sphere(scene);
	double heights[] = {2.7, 4.0, 6.1}, focal = 1.9;
	for (size_t i = 0; i < sizeof heights / sizeof *heights; i++) {
		reference_camera camera = from_above(heights[i], focal, SIZE);
		stilb_image image = picture_make(scene, &camera, linear);
		double want[3], half = 0.5 * SIZE * focal / heights[i];
		uint32_t covered = 0;
		for (int c = 0; c < 3; c++) {
			double diffuse = (double)scene->materials[1].diffuse[c];
			want[c] = diffuse / REFERENCE_PI * (double)scene->lights[0].intensity[c] *
			              -(double)scene->lights[0].direction[1] +
			          diffuse * (double)scene->surroundings.sky[c];
		}
		for (uint32_t y = 0; y < SIZE; y++)
			for (uint32_t x = 0; x < SIZE; x++) {
				bool inside = fabs(x + 0.5 - 0.5 * SIZE) < half && fabs(y + 0.5 - 0.5 * SIZE) < half;
				covered += !picture_is_sky(&image, scene, x, y);
				if (inside)
					assert_pixel(&image, x, y, want, 1e-3);
				else
					assert_true(picture_is_sky(&image, scene, x, y));
			}
		double side = 2.0 * floor(half + 0.5);
		assert_true(covered == side * side);
		stilb_image_finish(&image);
	}
	stilb_scene_destroy(scene);
}

/* The least distance of the sphere mesh from its centre: corners have distance 1, the middles of faces less. */
static double mesh_inner_radius(const stilb_scene_mesh *mesh)
{
	double inner = 1.0;
	for (const uint32_t *k = mesh->indices; k < mesh->indices + mesh->index_count; k += 3) {
		dvec p[3];
		for (int i = 0; i < 3; i++)
			p[i] = dvec_of(mesh->vertices[k[i]].position);
		dvec n = dvec_unit(dvec_cross(dvec_mad(p[1], -1.0, p[0]), dvec_mad(p[2], -1.0, p[0])));
		inner = fmin(inner, dvec_dot(n, p[0]));
	}
	return inner;
}

/* Rays that pass nearer than the inner radius hit the mesh, rays that miss the sphere miss it. */
static void a_sphere_is_its_disc(void **state)
{
	(void)state;
	dvec eyes[] = {{0, 3, 0}, {0.9, 2.4, 0.7}, {-2.2, 1.0, 1.5}};
	float radius = 0.8f, height = 0.3f;
	stilb_scene *scene = model_scene(radius, height, 0.0f);
	without_tile(scene);
	double inner = (double)radius * mesh_inner_radius(&scene->meshes[0]), outer = (double)radius;
	assert_true(inner > 0.96 * outer && inner < outer);
	for (size_t e = 0; e < sizeof eyes / sizeof *eyes; e++) {
		reference_camera camera = reference_camera_at(eyes[e], (dvec){0.2, 0.1, 0}, north, 1.5, SIZE, SIZE);
		stilb_image image = picture_make(scene, &camera, linear);
		dvec to_center = dvec_mad((dvec){0, (double)height, 0}, -1.0, eyes[e]);
		uint32_t low = 0, covered = 0, high = 0;
		for (uint32_t y = 0; y < SIZE; y++)
			for (uint32_t x = 0; x < SIZE; x++) {
				dvec d = dvec_unit(reference_ray(&camera, x + 0.5, y + 0.5)), off = dvec_cross(d, to_center);
				double passes = sqrt(dvec_dot(off, off));
				bool sky = picture_is_sky(&image, scene, x, y);
				assert_true(passes >= inner * (1.0 - 1e-4) || !sky);
				assert_true(passes <= outer * (1.0 + 1e-4) || sky);
				low += passes < inner;
				high += passes < outer;
				covered += !sky;
			}
		assert_true(low <= covered && covered <= high && high - low < covered / 10 && covered > 500);
		stilb_image_finish(&image);
	}
	stilb_scene_destroy(scene);
}

typedef struct traced_pixel {
	uint32_t part;
	bool sure; /* the same part is seen a hundredth of a pixel beside its centre */
	double low[3], high[3];
} traced_pixel;

/* Traces the pixel's centre and four points a hundredth of a pixel beside it; low and high are the least and the
 * highest radiance. A rasteriser snaps vertices to a grid of 1/256 pixel, so a pixel may show a point beside its
 * centre. */
static traced_pixel trace_pixel(const stilb_scene *scene, const reference_camera *camera, uint32_t x, uint32_t y)
{
	static const double places[5][2] = {{0.5, 0.5}, {0.49, 0.49}, {0.51, 0.49}, {0.49, 0.51}, {0.51, 0.51}};
	traced_pixel out = {.sure = true};
	for (int i = 0; i < 5; i++) {
		dvec ray = reference_ray(camera, x + places[i][0], y + places[i][1]);
		reference_hit hit = reference_trace(scene, camera->position, ray);
		dvec v = dvec_unit(dvec_mad(camera->position, -1.0, hit.position));
		out.part = i == 0 ? hit.part : out.part;
		out.sure &= hit.part == out.part;
		for (int c = 0; c < 3; c++) {
			double value = hit.part == REFERENCE_MISS
			                   ? (double)scene->surroundings.sky[c]
			                   : reference_radiance(scene, &scene->materials[hit.part], c, hit.normal, v);
			out.low[c] = i == 0 ? value : fmin(out.low[c], value);
			out.high[c] = i == 0 ? value : fmax(out.high[c], value);
		}
	}
	return out;
}

static void assert_traced(const stilb_scene *scene, const reference_camera *camera, double tolerance)
{
	stilb_image image = picture_make(scene, camera, linear);
	uint32_t seen[2] = {0}, sky = 0, unsure = 0;
	uint32_t step = TEST_ASAN ? 4 : 1; /* rays are this test's own: with the address sanitizer in every fourth row */
	for (uint32_t y = 0; y < camera->height; y += step)
		for (uint32_t x = 0; x < camera->width; x++) {
			traced_pixel want = trace_pixel(scene, camera, x, y);
			if (want.sure)
				assert_pixel_between(&image, x, y, want.low, want.high, tolerance);
			*(!want.sure ? &unsure : want.part == REFERENCE_MISS ? &sky : &seen[want.part]) += 1;
		}
	assert_true(seen[0] > 200 / step && seen[1] > 200 / step && sky > 200 / step);
	assert_true(unsure < camera->width * camera->height / step / 50);
	stilb_image_finish(&image);
}

static void every_pixel_is_as_traced(void **state)
{
	(void)state;
	reference_camera camera = from_aside(), top = from_above(4.0, 1.7, SIZE);
	stilb_scene *scene = model_scene(0.6f, 0.75f, 0.0f);
	assert_traced(scene, &camera, 1e-3);
	assert_traced(scene, &top, 1e-3);
	stilb_scene_destroy(scene);
	/* With highlights the tolerance is larger: the GPU's pow is less accurate. */
	scene = model_scene(0.6f, 0.75f, 0.5f);
	scene->materials[0].roughness = reference_roughness(40.0);
	assert_traced(scene, &camera, 2e-3);
	/* Normals of stretched and rotated models. */
	static const float stretched[16] = {0.3f, 0.2f, 0, 0, -0.3f, 0.5f, 0.1f, 0, 0, 0.1f, 0.9f, 0, 0, 0.9f, 0, 1};
	memcpy(scene->part_transform[0].m, stretched, sizeof stretched);
	assert_traced(scene, &camera, 2e-3);
	stilb_scene_destroy(scene);
}

/* ---- brightness -------------------------------------------------------------------------------------------------- */

/* Sun, camera and normal are collinear: n.h = 1, so the highlight is specular * factor * E. */
static void the_highlight_at_its_peak(void **state)
{
	(void)state;
	uint32_t size = 33; /* odd: the middle pixel looks straight at the sphere's pole, a corner of the mesh */
	stilb_scene *scene = model_scene(0.8f, 0.0f, 0.3f);
	without_tile(scene);
	scene->materials[0].roughness = reference_roughness(24.0);
	reference_sun_from(scene, 0.0f, 1.0f, 0.0f);
	reference_camera camera = from_above(3.0, 1.5, size);
	stilb_image image = picture_make(scene, &camera, linear);
	double factor = (24.0 + 2.0) * (24.0 + 4.0) / (8.0 * REFERENCE_PI * (1.0 / 4096.0 + 24.0)), want[3];
	for (int c = 0; c < 3; c++) {
		double diffuse = (double)scene->materials[0].diffuse[c], e = (double)scene->lights[0].intensity[c];
		want[c] = diffuse * e / REFERENCE_PI + (double)scene->materials[0].specular[c] * factor * e +
		          diffuse * (double)scene->surroundings.sky[c];
	}
	assert_pixel(&image, size / 2, size / 2, want, 1e-3);
	stilb_image_finish(&image);
	stilb_scene_destroy(scene);
}

/* The 8-bit code of a radiance, as a number: Karis's tone curve on the largest channel (linear to 0.6, limit 1), then
 * sRGB (IEC 61966-2-1). */
static double display_code(const double rgb[3], int channel)
{
	double largest = fmax(rgb[0], fmax(rgb[1], rgb[2])), a = 0.6, b = 1.0;
	double bent = largest <= a ? largest : (a * a - b * largest) / (2.0 * a - b - largest);
	double light = rgb[channel] * (largest > 0.0 ? bent / largest : 1.0);
	return 255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055);
}

static void display_codes_follow_the_curve(void **state)
{
	(void)state;
	reference_camera camera = from_aside();
	stilb_scene *scene = model_scene(0.6f, 0.75f, 0.3f);
	for (int dim = 0; dim < 2; dim++) {
		stilb_image radiance = picture_make(scene, &camera, linear);
		stilb_image codes = picture_make(scene, &camera, (picture_desc){.output = STILB_RENDER_OUTPUT_DISPLAY});
		const uint8_t *code = codes.pixels;
		assert_int_equal(codes.format, STILB_IMAGE_U8_SRGB);
		uint32_t bright = 0;
		for (uint32_t i = 0; i < codes.width * codes.height; i++) {
			double rgb[3];
			for (int c = 0; c < 3; c++)
				rgb[c] = picture_value(&radiance, i % codes.width, i / codes.width, c);
			for (int c = 0; c < 3; c++)
				assert_true(fabs(code[3 * i + (uint32_t)c] - display_code(rgb, c)) <= 1.0);
			bright += rgb[0] > 0.6 || rgb[1] > 0.6 || rgb[2] > 0.6;
		}
		assert_true(dim ? bright == 0 : bright > 1000); /* the linear part of the curve alone, or the bent one too */
		stilb_image_finish(&radiance);
		stilb_image_finish(&codes);
		for (int c = 0; c < 3; c++) {
			scene->lights[0].intensity[c] *= 0.04f;
			scene->surroundings.sky[c] *= 0.04f;
		}
	}
	stilb_scene_destroy(scene);
}

/* ---- depth ------------------------------------------------------------------------------------------------------- */

static void the_nearer_wins_whatever_the_order(void **state)
{
	(void)state;
	reference_camera camera = from_aside(), top = from_above(4.0, 1.7, SIZE);
	stilb_scene *scene = model_scene(0.6f, 0.75f, 0.0f);
	stilb_image before = picture_make(scene, &camera, linear);
	/* The tile first, the sphere second; each keeps its material. */
	stilb_mat4 sphere = scene->part_transform[0];
	scene->part_transform[0] = scene->part_transform[1];
	scene->part_transform[1] = sphere;
	scene->part_mesh[0] = scene->part_material[0] = 1;
	scene->part_mesh[1] = scene->part_material[1] = 0;
	stilb_image after = picture_make(scene, &camera, linear);
	assert_memory_equal(before.pixels, after.pixels, stilb_image_size(&before));
	stilb_image_finish(&before);
	stilb_image_finish(&after);
	/* Below the tile the sphere is not seen. */
	scene->part_transform[1] = stilb_mat4_scale_translate(0.6f, 0.0f, -0.75f, 0.0f);
	before = picture_make(scene, &top, linear);
	scene->part_transform[1] = stilb_mat4_scale_translate(0.001f, 0.0f, -5.0f, 0.0f);
	after = picture_make(scene, &top, linear);
	assert_memory_equal(before.pixels, after.pixels, stilb_image_size(&before));
	stilb_image_finish(&before);
	stilb_image_finish(&after);
	stilb_scene_destroy(scene);
}

static void assert_all_sky(const stilb_scene *scene, const reference_camera *camera)
{
	stilb_image image = picture_make(scene, camera, linear);
	for (uint32_t y = 0; y < camera->height; y++)
		for (uint32_t x = 0; x < camera->width; x++)
			assert_true(picture_is_sky(&image, scene, x, y));
	stilb_image_finish(&image);
}

static void from_behind_nothing_is_seen(void **state)
{
	(void)state;
	stilb_scene *scene = model_scene(0.9f, 3.0f, 0.0f);
	reference_camera below = reference_camera_at((dvec){0, -2, 0}, (dvec){0, 0, 0}, north, 2.5, SIZE, SIZE);
	reference_camera within = reference_camera_at((dvec){0, 3, 0}, (dvec){1, 3.1, 0}, above, 0.7, SIZE, SIZE);
	stilb_scene *lone = model_scene(0.9f, 3.0f, 0.0f);
	without_tile(lone);
	without_sphere(scene);
	assert_all_sky(scene, &below);
	assert_all_sky(lone, &within);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(lone);
}

/* ---- no holes ---------------------------------------------------------------------------------------------------- */

#define GRID 20

/* The stress test's tiles, each with a colour of its own, without the spheres. The sky has a colour of no tile. */
static stilb_scene *grid_scene(void)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(GRID * GRID, 1, &scene), STILB_OK);
	for (uint32_t m = 0; m < GRID * GRID; m++) {
		scene->part_transform[2 * m] = stilb_mat4_scale_translate(0.0001f, 0.0f, -5.0f, 0.0f);
		scene->materials[2 * m + 1] =
			(stilb_scene_material){{(float)(m + 1) / 512.0f, 0.25f, 0.5f}, {0}, .roughness = 1.0f};
	}
	scene->surroundings = (stilb_scene_surroundings){0};
	reference_set3(scene->surroundings.sky, 0.0f, 0.0f, 9.0f);
	reference_sun_from(scene, 0.0f, 1.0f, 0.0f);
	reference_set3(scene->lights[0].intensity, 3.0f, 3.0f, 0.0f);
	return scene;
}

static int grid_place(double coordinate)
{
	return (int)floor((coordinate + GRID) / 2.0);
}

/* True if the pixel's red is that of the tile at p or, close to the tile's edge, that of a neighbour. */
static bool grid_color_fits(const stilb_image *image, uint32_t x, uint32_t y, dvec p, double reach)
{
	double red = picture_value(image, x, y, 0) * REFERENCE_PI / 3.0 * 512.0 - 1.0;
	for (int side = 0; side < 4; side++) {
		int column = grid_place(p.x + (side & 1 ? reach : -reach)), row = grid_place(p.z + (side & 2 ? reach : -reach));
		if (fabs(red - (row * GRID + column)) < 0.3)
			return true;
	}
	return false;
}

static void assert_no_holes(const stilb_scene *scene, reference_camera camera)
{
	stilb_image image = picture_make(scene, &camera, linear);
	uint32_t tiles = 0, sky = 0;
	for (uint32_t y = 0; y < camera.height; y++)
		for (uint32_t x = 0; x < camera.width; x++) {
			dvec d = reference_ray(&camera, x + 0.5, y + 0.5);
			double t = d.y < 0.0 ? -camera.position.y / d.y : HUGE_VAL;
			dvec p = dvec_mad(camera.position, t, d);
			/* Metres on the ground that a fraction of a pixel covers. */
			double reach = 0.02 * t * (1.0 + t / camera.position.y) * 2.0 / camera.height;
			double edge = fmax(fabs(p.x), fabs(p.z));
			bool is_sky = picture_is_sky(&image, scene, x, y);
			if (t < HUGE_VAL && edge < GRID - reach) {
				if (is_sky || !grid_color_fits(&image, x, y, p, reach))
					fail_msg("pixel %u, %u: %s at x %.3f z %.3f", x, y, is_sky ? "a hole" : "another tile", p.x, p.z);
				tiles++;
			} else if (t == HUGE_VAL || edge > GRID + reach) {
				assert_true(is_sky);
				sky++;
			}
		}
	if (tiles < 10000 || sky < 1000)
		fail_msg("%u of tiles, %u of sky: not much of a test", tiles, sky);
	stilb_image_finish(&image);
}

static void no_holes_between_tiles(void **state)
{
	(void)state;
	stilb_scene *scene = grid_scene();
	assert_no_holes(scene, from_above(42.0, 1.9, 256));
	assert_no_holes(scene, reference_camera_at((dvec){0.3, 9, 30}, (dvec){0, 0, 0}, above, 1.3, 320, 200));
	assert_no_holes(scene, reference_camera_at((dvec){13, 1.1, 17}, (dvec){-4, 0.4, -3}, above, 1.1, 320, 200));
	assert_no_holes(scene,
	                reference_camera_at((dvec){-31, 14, 7.7}, (dvec){0, 0, 1}, (dvec){0.2, 1, 0}, 1.4, 301, 211));
	stilb_scene_destroy(scene);
}

/* ---- equal pictures ---------------------------------------------------------------------------------------------- */

/* Every model has two materials of its own, so the material changes with every draw. So does the pipeline: spheres have
 * even materials, tiles odd ones. */
static void assert_commands(const stilb_render_stats *stats, picture_desc how, uint64_t draws)
{
	bool direct = how.replay == STILB_RENDER_REPLAY_DIRECT, secondary = how.replay == STILB_RENDER_REPLAY_SECONDARY;
	bool index = how.materials == STILB_RENDER_MATERIALS_INDEX;
	uint64_t buffers = secondary ? how.workers + 1 : 1;
	assert_int_equal(stats->draws, draws);
	assert_int_equal(stats->draw_commands, direct || secondary ? draws : 0);
	assert_int_equal(stats->execute_commands, secondary ? buffers : 0);
	assert_int_equal(stats->binds_asked, 3 * draws);
	/* A program and indices for each buffer, and a material for each draw: its address, or another program. */
	bool bind = how.materials == STILB_RENDER_MATERIALS_BIND;
	assert_int_equal(stats->binds_sent, index ? 2 * buffers : (bind ? 2 : 1) * buffers + draws);
	if (direct || secondary)
		assert_int_equal(stats->indirect_commands, 0);
	else if (index)
		assert_in_range(stats->indirect_commands, 1, 8); /* one for each sequence of chunks claimed in a row */
	else
		assert_int_equal(stats->indirect_commands, draws);
}

static void the_same_however_it_was_drawn(void **state)
{
	(void)state;
	uint32_t models = 900;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(models, 5, &scene), STILB_OK);
	/* The second half lies at the same place as the first, in other colours. At equal depth the first one drawn wins,
	 * so a changed order changes the picture. */
	for (uint32_t part = 0; part < models; part++)
		scene->part_transform[models + part] = scene->part_transform[part];
	reference_camera camera = reference_camera_at((dvec){9, 11, 30}, (dvec){0, 0, 0}, above, 1.5, 160, 90);
	static const uint32_t workers[] = {0, 1, 3};
	stilb_image first = picture_make(scene, &camera, (picture_desc){.replay = STILB_RENDER_REPLAY_DIRECT});
	for (int way = 0; way < 27; way++) {
		if (TEST_ASAN && way % 13 != 0)
			continue; /* each replay, each kind of materials and each number of workers once */
		stilb_render_stats stats;
		picture_desc how = {
			.replay = (stilb_render_replay_mode)(way % 3),
			.materials = (stilb_render_materials)(way / 3 % 3),
			.workers = workers[way / 9],
			.stats = &stats,
		};
		stilb_image other = picture_make(scene, &camera, how);
		assert_memory_equal(first.pixels, other.pixels, stilb_image_size(&first));
		assert_commands(&stats, how, 2 * models);
		stilb_image_finish(&other);
	}
	stilb_image_finish(&first);
	stilb_scene_destroy(scene);
}

/* Frame number `frames` of the engine. */
static stilb_image engine_picture(stilb_cull_method cull, uint32_t workers, bool present, int frames)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stress_engine stress = {.models = 400, .seed = 1, .view = STILB_SCENE_VIEW_HALF, .animate = true};
	desc.workers = workers;
	desc.cull = cull;
	desc.present = present;
	desc.width = 120;
	desc.height = 80;
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_image image = {0};
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_OK);
	for (int f = 0; f < frames; f++)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(report.visible > 100 && report.visible < 300);
	assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_OK);
	stress_engine_destroy(engine);
	return image;
}

static void the_same_from_the_engine(void **state)
{
	(void)state;
	stilb_image first = engine_picture(STILB_CULL_OCTREE, 0, true, 4),
				earlier = engine_picture(STILB_CULL_OCTREE, 0, true, 3);
	assert_memory_not_equal(first.pixels, earlier.pixels, stilb_image_size(&first)); /* it moves */
	stilb_image_finish(&earlier);
	for (int way = 1; way < 6; way++) {
		stilb_cull_method cull = way & 1 ? STILB_CULL_FLAT : STILB_CULL_OCTREE;
		stilb_image other = engine_picture(cull, (uint32_t)way / 2, way < 4, 4);
		assert_memory_equal(first.pixels, other.pixels, stilb_image_size(&first));
		stilb_image_finish(&other);
	}
	stilb_image_finish(&first);
}

/* ---- four samples ------------------------------------------------------------------------------------------------ */

/* The largest channel of a pixel. */
static double largest_value(const stilb_image *image, uint32_t x, uint32_t y)
{
	return fmax(picture_value(image, x, y, 0), fmax(picture_value(image, x, y, 1), picture_value(image, x, y, 2)));
}

/* Inside of faces the picture is the same; a pixel on an edge is a mixture of both sides in quarters, each with the
 * weight 1 / (1 + its largest channel). */
static void four_samples_soften_edges_alone(void **state)
{
	(void)state;
	stilb_scene *scene = model_scene(1.0f, 0.0f, 0.0f);
	without_sphere(scene);
	double height = 4.0, focal = 1.9;
	reference_camera camera = from_above(height, focal, SIZE);
	stilb_image image = picture_make(scene, &camera, (picture_desc){.output = linear.output, .samples = 4});
	double half = 0.5 * SIZE * focal / height, covered = 0.0;
	double tile = picture_value(&image, SIZE / 2, SIZE / 2, 1), sky = picture_value(&image, 0, 0, 1);
	double tile_weight = 1.0 / (1.0 + largest_value(&image, SIZE / 2, SIZE / 2));
	double sky_weight = 1.0 / (1.0 + largest_value(&image, 0, 0));
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			double far = fmax(fabs(x + 0.5 - 0.5 * SIZE), fabs(y + 0.5 - 0.5 * SIZE));
			double value = picture_value(&image, x, y, 1);
			double more = sky_weight * (value - sky), less = tile_weight * (tile - value);
			double share = more / (more + less);
			assert_true(fabs(share * 4.0 - round(share * 4.0)) < 0.05);
			if (far < half - 0.5)
				assert_true(round(share * 4.0) == 4.0);
			if (far > half + 0.5)
				assert_true(round(share * 4.0) == 0.0);
			covered += round(share * 4.0) / 4.0;
		}
	/* Four samples in a pixel tell how much of it lies on one side of an edge to an eighth. */
	assert_true(fabs(covered - 4.0 * half * half) < 8.0 * half / 8.0 + 1.0);
	stilb_image_finish(&image);
	stilb_scene_destroy(scene);
}

/* ---- from light to codes ----------------------------------------------------------------------------------------- */

/* A frame of one colour of radiance, without models: its codes, and its radiance as it is read back. */
static void tone_frame(stilb_render *render, const float color[3], uint32_t tone, bool dither, stilb_image *codes,
                       stilb_image *radiance)
{
	static const stilb_render_pass pass = {.name = "main"};
	stilb_render_view view = {.view_projection = stilb_mat4_identity(),
	                          .shading = stilb_render_shading_default(),
	                          .backdrop = {.kind = STILB_SCENE_BACKDROP_COLOR},
	                          .exposure = 1.0f,
	                          .tone = tone,
	                          .dither = dither};
	memcpy(view.backdrop.color, color, sizeof view.backdrop.color);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 0), STILB_OK);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, NULL, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, codes), STILB_OK);
	assert_int_equal(stilb_render_read_radiance(render, radiance), STILB_OK);
}

/* Each tone map of the header is that of frames, whose radiance stays what it is. With dither the mean of the codes is
 * the code before it was rounded, to a fifth of a code, and each is one of its two
 * neighbours; lavapipe's encoding of sRGB was seen to be off by a tenth of a code. */
static void tone_maps_are_those_of_the_header(void **state)
{
	(void)state;
	static const float colors[][3] = {{0.0f, 0.0f, 0.0f},  {0.01f, 0.003f, 0.02f}, {0.1f, 0.2f, 0.05f},
	                                  {0.3f, 0.25f, 0.4f}, {2.0f, 0.5f, 0.7f},     {1e4f, 1e4f, 1e4f}};
	stilb_render_desc desc = {.width = 64, .height = 64, .samples = 1, .context_count = 1, .validate = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	for (uint32_t i = 0; i < sizeof colors / sizeof *colors * SHADE_TONE_COUNT * 2; i++) {
		const float *color = colors[i / (2 * SHADE_TONE_COUNT)];
		uint32_t tone = i / 2 % SHADE_TONE_COUNT;
		stilb_image codes, radiance;
		tone_frame(render, color, tone, i % 2, &codes, &radiance);
		float is_lit[3]; /* the colour in half floats */
		for (int c = 0; c < 3; c++)
			is_lit[c] = (float)picture_value(&radiance, 5, 9, c);
		stilb_vec3 shown = shade_tone((int)tone, stilb_vec3_make(is_lit[0], is_lit[1], is_lit[2]) * 2.0f);
		for (uint32_t c = 0; c < 3; c++) {
			double code = (double)shade_srgb_from_linear(shown[c]) * 255.0, sum = 0.0;
			for (uint32_t p = 0; p < 64 * 64; p++) {
				double is = ((const uint8_t *)codes.pixels)[3 * p + c];
				assert_true(fabs(is - code) <= (i % 2 ? 1.2 : 0.7));
				sum += is / (64.0 * 64.0);
			}
			assert_true(fabs(sum - code) <= (i % 2 ? 0.2 : 0.7));
			assert_true(fabsf(is_lit[c] - color[c]) <= 1e-3f * color[c]);
		}
		stilb_image_finish(&codes);
		stilb_image_finish(&radiance);
	}
	stilb_render_destroy(render);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	struct CMUnitTest tests[] = {
		cmocka_unit_test(a_tile_is_its_square),
		cmocka_unit_test(a_sphere_is_its_disc),
		cmocka_unit_test(every_pixel_is_as_traced),
		cmocka_unit_test(the_highlight_at_its_peak),
		cmocka_unit_test(display_codes_follow_the_curve),
		cmocka_unit_test(the_nearer_wins_whatever_the_order),
		cmocka_unit_test(from_behind_nothing_is_seen),
		cmocka_unit_test(no_holes_between_tiles),
		cmocka_unit_test(the_same_however_it_was_drawn),
		cmocka_unit_test(the_same_from_the_engine),
		cmocka_unit_test(four_samples_soften_edges_alone),
		cmocka_unit_test(tone_maps_are_those_of_the_header),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
