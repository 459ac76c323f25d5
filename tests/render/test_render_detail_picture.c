/* Fades and morphs in pictures: every pixel of a fade is one level's or the other's, nothing opens between neighbouring
 * levels in a thousand views, a morph ends where the next level begins, and all of it is the same however it is
 * replayed. */
#include "image/image_compare.h"
#include "render/render_internal.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 512u
#define CELLS 16u /* spheres along a side, each turned in its own way: as many views of one sphere */
#define LEVELS 4u /* of the stress test's spheres, with the mesh in full */

static stilb_job_pool *pool;

static int pool_make(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = {.worker_count = 1};
	return stilb_job_pool_create(&desc, &pool);
}

static int pool_free(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

/* ---- views of a sphere, by hand ---------------------------------------------------------------------------------- */

typedef struct stage {
	stilb_render *render;
	stilb_render_mesh sphere;
	stilb_render_material paint;
	stilb_mat4 places[CELLS * CELLS];
} stage;

static float random_between(uint64_t number, float low, float high)
{
	return low + (high - low) * stilb_random_float(11, number);
}

/* A sphere of about 13 pixels' radius somewhere in a cell, turned at random. */
static stilb_mat4 place_of(uint32_t cell, uint32_t round)
{
	uint64_t number = 8 * (uint64_t)(round * CELLS * CELLS + cell);
	float q[4], length = 0.0f, size = random_between(number, 9.0f, 14.0f);
	for (int i = 0; i < 4; i++) {
		q[i] = random_between(number + 1 + (uint64_t)i, -1.0f, 1.0f);
		length += q[i] * q[i];
	}
	stilb_scene_pose pose = {.scale = {size, size, size}};
	for (int i = 0; i < 4; i++)
		pose.rotation[i] = q[i] / sqrtf(length);
	float cell_side = (float)SIDE / CELLS;
	pose.translation[0] = ((float)(cell % CELLS) + 0.5f) * cell_side + random_between(number + 5, -1.0f, 1.0f);
	pose.translation[1] = ((float)(cell / CELLS) + 0.5f) * cell_side + random_between(number + 6, -1.0f, 1.0f);
	return stilb_scene_pose_matrix(&pose);
}

/* samples: a pixel; devices differ in how many they take by themselves. */
static void stage_open(stage *s, uint32_t samples)
{
	stilb_render_desc desc = {.width = SIDE, .height = SIDE, .samples = samples, .context_count = 2, .morph = true};
	stilb_scene_mesh mesh;
	stilb_scene_material paint = {.diffuse = {0.6f, 0.3f, 0.2f}, .roughness = 0.6f, .emission = {0.05f, 0.05f, 0.05f}};
	assert_int_equal(stilb_scene_mesh_sphere(LEVELS - 2, &mesh), STILB_OK);
	if (stilb_render_create(&desc, &s->render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_mesh_create(s->render, &mesh, &s->sphere), STILB_OK);
	assert_int_equal(stilb_render_material_create(s->render, &paint, (stilb_render_texture){0}, &s->paint), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
}

static void stage_turn(stage *s, uint32_t round)
{
	for (uint32_t c = 0; c < CELLS * CELLS; c++)
		s->places[c] = place_of(c, round);
}

/* How all spheres are drawn. */
typedef struct look {
	uint32_t level, detail, kind;
} look;

static stilb_render_context *picture_begin(const stage *s)
{
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	stilb_render_segment_begin(context, 0, 0);
	return context;
}

static stilb_image picture_end(const stage *s, stilb_render_context *context)
{
	static const stilb_render_pass pass = {.name = "spheres"};
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.48f, 0.64f, -0.6f}, .intensity = {2, 2, 2}};
	stilb_render_view view = {
		.view_projection = {{2.0f / SIDE, 0, 0, 0, 0, 2.0f / SIDE, 0, 0, 0, 0, 0.01f, 0, -1, -1, 0.5f, 1}},
		.camera_position = {SIDE / 2.0f, SIDE / 2.0f, 1e6f},
		.backdrop = {.kind = STILB_SCENE_BACKDROP_COLOR},
		.shading = stilb_render_shading_default(),
		.lights = &sun,
		.light_count = 1,
		.both_sides = true}; /* the view is mirrored */
	stilb_image image;
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(s->render, &image), STILB_OK);
	assert_int_equal(image.channels, 3);
	return image;
}

/* A picture in which each sphere is drawn in these ways. */
static stilb_image picture(const stage *s, const look *looks, uint32_t count)
{
	stilb_render_context *context = picture_begin(s);
	for (uint32_t l = 0; l < count; l++)
		for (uint32_t c = 0; c < CELLS * CELLS; c++)
			render_draw_level(context, 0, s->sphere, s->paint, &s->places[c], looks[l].level, looks[l].detail,
			                  looks[l].kind);
	return picture_end(s, context);
}

static const uint8_t *pixel(const stilb_image *image, uint32_t i)
{
	return (const uint8_t *)image->pixels + 3 * (size_t)i;
}

/* Drivers compile each pipeline anew, and may round otherwise: two pictures of the same differ by one at most. */
static bool is_same(const uint8_t *a, const uint8_t *b)
{
	for (int c = 0; c < 3; c++)
		if (abs(a[c] - b[c]) > 1)
			return false;
	return true;
}

static bool is_covered(const stilb_image *image, uint32_t i)
{
	return pixel(image, i)[0] > 0;
}

#define KIND_FADE 1
#define KIND_MORPH 2

static const int thresholds[64] = {
#include "render/shaders/fade_thresholds.inc"
};

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void every_pixel_of_a_fade_is_one_levels(void **state)
{
	(void)state;
	stage s;
	stage_open(&s, 1);
	stage_turn(&s, 0);
	for (uint32_t level = 0; level + 1 < LEVELS; level++) {
		stilb_image fine = picture(&s, &(look){level, 0, 0}, 1), coarse = picture(&s, &(look){level + 1, 0, 0}, 1);
		uint32_t differing = 0;
		for (uint32_t share = 2; share < 32; share += level == 0 ? 14 : 7) {
			const look both[2] = {{level, share, KIND_FADE}, {level + 1, RENDER_DETAIL_OUT + share, KIND_FADE}};
			stilb_image fade = picture(&s, both, 2);
			for (uint32_t i = 0; i < SIDE * SIDE; i++) {
				bool in = thresholds[i / SIDE % 8 * 8 + i % SIDE % 8] < (int)(2 * share);
				const uint8_t *wanted = pixel(in ? &fine : &coarse, i);
				if (!is_same(pixel(&fade, i), wanted))
					fail_msg("levels %u and %u at share %u: pixel %u, %u", level, level + 1, share, i % SIDE, i / SIDE);
				differing += !is_same(pixel(&fine, i), pixel(&coarse, i));
			}
			stilb_image_finish(&fade);
		}
		assert_true(differing > 1000);
		stilb_image_finish(&fine);
		stilb_image_finish(&coarse);
	}
	stilb_render_destroy(s.render);
}

/* Both levels cover the pixel and those beside it. At the silhouette itself a morph may lose a pixel's centre, because
 * devices move vertices to a grid of 1/256 pixel. */
static bool is_inside(const stilb_image *fine, const stilb_image *coarse, uint32_t i)
{
	const uint32_t around[5] = {i, i - 1, i + 1, i - SIDE, i + SIDE};
	for (int k = 0; k < 5; k++)
		if (!is_covered(fine, around[k]) || !is_covered(coarse, around[k]))
			return false;
	return true;
}

/* No background shows inside both levels, at any time of a morph or a fade: 1,024 views of each pair. */
static void nothing_opens_between_levels(void **state)
{
	(void)state;
	stage s;
	stage_open(&s, 1);
	for (uint32_t round = 0; round < 4; round++) {
		stage_turn(&s, round);
		for (uint32_t level = 0; level + 1 < LEVELS; level++) {
			stilb_image fine = picture(&s, &(look){level, 0, 0}, 1), coarse = picture(&s, &(look){level + 1, 0, 0}, 1);
			uint32_t share = 3 + 7 * round;
			look moving = {level, 5 + 17 * round, KIND_MORPH};
			const look both[2] = {{level + 1, share, KIND_FADE}, {level, RENDER_DETAIL_OUT + share, KIND_FADE}};
			stilb_image morph = picture(&s, &moving, 1), fade = picture(&s, both, 2);
			uint32_t covered = 0, open = 0;
			for (uint32_t i = SIDE; i < SIDE * (SIDE - 1); i++)
				if (is_inside(&fine, &coarse, i)) {
					covered++;
					open += !is_covered(&morph, i) || !is_covered(&fade, i);
				}
			assert_true(covered > CELLS * CELLS * 100);
			assert_int_equal(open, 0);
			stilb_image_finish(&fine);
			stilb_image_finish(&coarse);
			stilb_image_finish(&morph);
			stilb_image_finish(&fade);
		}
	}
	stilb_render_destroy(s.render);
}

/* Root of the mean square, in codes. */
static double difference(const stilb_image *a, const stilb_image *b)
{
	stilb_image of_a = *a, of_b = *b;
	stilb_image_comparison apart;
	of_a.format = stilb_image_format_as_data(a->format);
	of_b.format = stilb_image_format_as_data(b->format);
	assert_int_equal(stilb_image_compare(&of_a, &of_b, NULL, 0.0, &apart), STILB_OK);
	return 255.0 * apart.rms_all;
}

/* A morph begins at the level itself and comes nearer to the next one with each step, up to the last 64th. */
static void a_morph_goes_from_level_to_level(void **state)
{
	(void)state;
	stage s;
	stage_open(&s, 1);
	stage_turn(&s, 9);
	for (uint32_t level = 0; level + 1 < LEVELS; level++) {
		stilb_image fine = picture(&s, &(look){level, 0, 0}, 1), coarse = picture(&s, &(look){level + 1, 0, 0}, 1);
		stilb_image none = picture(&s, &(look){level, 0, KIND_MORPH}, 1);
		assert_memory_equal(fine.pixels, none.pixels, 3 * SIDE * SIDE);
		double whole = difference(&fine, &coarse), last = whole;
		static const uint32_t steps[] = {1, 16, 32, 48, 63};
		for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
			stilb_image morph = picture(&s, &(look){level, steps[i], KIND_MORPH}, 1);
			double left = difference(&morph, &coarse);
			assert_true(left <= last);
			assert_true(i > 0 || difference(&morph, &fine) < 0.25 * whole);
			last = left;
			stilb_image_finish(&morph);
		}
		if (last > 0.25 * whole)
			fail_msg("level %u: %g is left of %g", level, last, whole);
		stilb_image_finish(&none);
		stilb_image_finish(&fine);
		stilb_image_finish(&coarse);
	}
	stilb_render_destroy(s.render);
}

/* ---- small triangles --------------------------------------------------------------------------------------------- */

#define STRIPS 1000u

/* A plane of strips 0.3 pixels wide. Across each, normals turn from one angle about y to another. */
static stilb_image strips(const stage *s, float from, float to)
{
	static stilb_scene_vertex vertices[4 * STRIPS];
	static uint32_t indices[6 * STRIPS];
	for (uint32_t i = 0; i < 4 * STRIPS; i++) {
		float angle = i % 2 ? to : from;
		vertices[i] =
			(stilb_scene_vertex){.position = {100.0f + 0.3f * (float)(i / 4 + i % 2), i % 4 < 2 ? 0.0f : SIDE},
		                         .normal = {sinf(angle), 0.0f, cosf(angle)}};
	}
	for (uint32_t i = 0; i < 6 * STRIPS; i++)
		indices[i] = i / 6 * 4 + (uint32_t[]){0, 1, 3, 0, 3, 2}[i % 6];
	stilb_scene_mesh mesh = {
		.vertices = vertices, .indices = indices, .vertex_count = 4 * STRIPS, .index_count = 6 * STRIPS};
	stilb_render_mesh made;
	assert_int_equal(stilb_render_mesh_create(s->render, &mesh, &made), STILB_OK);
	stilb_render_context *context = picture_begin(s);
	stilb_mat4 place = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
	stilb_render_draw(context, made, s->paint, &place);
	stilb_image image = picture_end(s, context);
	stilb_render_mesh_destroy(s->render, made);
	return image;
}

/* With several samples a pixel, one of which a triangle covers, it is lit as at a point of the triangle and not as at
 * the pixel's centre, where its normal would have turned further than it does. */
static void pixels_are_lit_inside_of_triangles(void **state)
{
	(void)state;
	stage s;
	stage_open(&s, 4);
	stilb_image turning = strips(&s, -1.1f, 0.0f), low = strips(&s, -1.1f, -1.1f), high = strips(&s, 0.0f, 0.0f);
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		if (i % SIDE < 102 || i % SIDE >= 398)
			continue;
		const uint8_t *it = pixel(&turning, i), *a = pixel(&low, i), *b = pixel(&high, i);
		for (int c = 0; c < 3; c++)
			if (it[c] + 1 < (a[c] < b[c] ? a[c] : b[c]))
				fail_msg("pixel %u, %u: %d where its darkest point has %d or %d", i % SIDE, i / SIDE, it[c], a[c],
				         b[c]);
	}
	assert_true(pixel(&low, SIDE * SIDE / 2 + 256)[0] > 20);
	stilb_image_finish(&turning);
	stilb_image_finish(&low);
	stilb_image_finish(&high);
	stilb_render_destroy(s.render);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static const stilb_render_view *scene_view(const stilb_scene *scene, float height, stilb_render_detail_mode mode,
                                           stilb_render_view *view)
{
	stilb_scene_camera camera = scene->camera;
	camera.position[1] *= height;
	camera.position[2] *= height;
	*view = (stilb_render_view){.view_projection = stilb_scene_camera_matrix(&camera, 1.5f),
	                            .lights = scene->lights,
	                            .light_count = scene->light_count,
	                            .surroundings = scene->surroundings,
	                            .shading = stilb_render_shading_default(),
	                            .detail = {mode, 0.5f}};
	memcpy(view->camera_position, camera.position, sizeof camera.position);
	return view;
}

/* Both ways to give materials are tried with one sample a pixel, the other ways to replay with four. */
static stilb_render_desc other_way(uint32_t samples, int way)
{
	stilb_render_desc desc = {.samples = samples};
	if (samples == 4)
		desc.replay = (stilb_render_replay_mode)way;
	else
		desc.materials = (stilb_render_materials)way;
	return desc;
}

/* Two frames from near and three from farther, the last one's picture. */
static stilb_image flight(const stilb_scene *scene, stilb_render_desc desc, stilb_render_detail_mode mode)
{
	static const stilb_render_pass pass = {.name = "scene"};
	uint32_t ids[64];
	stilb_render *render;
	stilb_render_view view;
	stilb_image image;
	for (uint32_t i = 0; i < 64; i++)
		ids[i] = i;
	desc.width = 96;
	desc.height = 64;
	desc.context_count = 2;
	desc.morph = mode == STILB_RENDER_DETAIL_MORPH;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	for (uint32_t frame = 0; frame < 5; frame++) {
		scene_view(scene, frame < 2 ? 0.4f : 1.0f, mode, &view);
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_record_view(render, 0, scene, ids, 64, &view, pool, 0), STILB_OK);
		assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	}
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	stilb_render_destroy(render);
	return image;
}

static void pictures_do_not_depend_on_how_they_are_replayed(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(64, 5, &scene), STILB_OK);
	for (uint32_t samples = 1; samples <= 4; samples += 3)
		for (int mode = STILB_RENDER_DETAIL_FADE; mode <= STILB_RENDER_DETAIL_MORPH; mode++) {
			stilb_image first = flight(scene, (stilb_render_desc){.samples = samples}, (stilb_render_detail_mode)mode);
			stilb_image off = flight(scene, (stilb_render_desc){.samples = samples}, STILB_RENDER_DETAIL_OFF);
			assert_true(memcmp(first.pixels, off.pixels, stilb_image_size(&off)) != 0);
			stilb_image_finish(&off);
			for (int way = 1; way < 3; way++) {
				stilb_image image = flight(scene, other_way(samples, way), (stilb_render_detail_mode)mode);
				assert_memory_equal(image.pixels, first.pixels, stilb_image_size(&first));
				stilb_image_finish(&image);
			}
			stilb_image_finish(&first);
		}
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_no_asan(every_pixel_of_a_fade_is_one_levels),
		test_no_asan(nothing_opens_between_levels),
		cmocka_unit_test(a_morph_goes_from_level_to_level),
		cmocka_unit_test(pixels_are_lit_inside_of_triangles),
		cmocka_unit_test(pictures_do_not_depend_on_how_they_are_replayed),
	};
	return cmocka_run_group_tests(tests, pool_make, pool_free);
}
