/* Impostors on the GPU: pictures of a coloured model without symmetry from 26 directions against those of its meshes,
 * with their averages over 8 x 8 points a pixel; depth against a wall; mirrored and stretched transforms; the same
 * picture by every way to replay; four samples a pixel. Under the validation layer. With
 * STILB_IMPOSTOR_PICTURES=FOLDER the pictures are written there, meshes above impostors. */
#include "geometry/geometry_impostor.h"
#include "render/render_internal.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIZE 20u /* pixels of a picture's side; the model's sphere covers 16 */
#define FINE 8u  /* points of a pixel's side */
/* Root of the mean square of what pixels may differ by, of a brightest value of 1, over all directions. Boxes are the
 * hardest model: a face at a glance is in none of the next pictures. */
#define BOUND 0.045
#define STEP (TEST_ASAN ? 2 : 1) /* of the 26 directions */

static stilb_job_pool *pool;

/* ---- the model: boxes in the shape of an F with a foot, each of a colour ----------------------------------------- */

#define BOXES 4

typedef struct boxes {
	stilb_scene_vertex vertices[24];
	uint32_t indices[36];
	stilb_scene_mesh mesh; /* the cube from -1 to 1 */
	stilb_scene_material materials[BOXES];
	stilb_mat4 transforms[BOXES];
	stilb_geometry_impostor_part parts[BOXES];
} boxes;

static void boxes_make(boxes *out)
{
	static const float place[BOXES][6] = {{0, 0, 0, 0.5f, 3, 0.7f},
	                                      {1.2f, 2.5f, 0, 0.8f, 0.5f, 0.5f},
	                                      {1, 0.6f, 0, 0.6f, 0.4f, 0.4f},
	                                      {-0.2f, -2.6f, 1.5f, 0.7f, 0.4f, 1}};
	static const float color[BOXES][3] = {
		{0.8f, 0.75f, 0.7f}, {0.8f, 0.1f, 0.1f}, {0.1f, 0.6f, 0.2f}, {0.1f, 0.2f, 0.8f}};
	static const float dark[3] = {0.04f, 0.04f, 0.04f};
	for (uint32_t face = 0; face < 6; face++)
		for (uint32_t c = 0; c < 4; c++) {
			uint32_t axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
			float side = face % 2 ? 1.0f : -1.0f;
			stilb_scene_vertex *vertex = &out->vertices[4 * face + c];
			*vertex = (stilb_scene_vertex){0};
			vertex->position[axis] = vertex->normal[axis] = side;
			vertex->position[u] = (c == 1 || c == 2 ? 1.0f : -1.0f) * side;
			vertex->position[v] = c >= 2 ? 1.0f : -1.0f;
		}
	for (uint32_t i = 0; i < 36; i++)
		out->indices[i] = 4 * (i / 6) + (const uint32_t[]){0, 1, 2, 0, 2, 3}[i % 6];
	out->mesh =
		(stilb_scene_mesh){.vertices = out->vertices, .indices = out->indices, .vertex_count = 24, .index_count = 36};
	for (uint32_t b = 0; b < BOXES; b++) {
		out->materials[b] = stilb_scene_material_make(color[b], dark, 0.3f + 0.1f * (float)b);
		out->transforms[b] = stilb_mat4_identity();
		for (int axis = 0; axis < 3; axis++) {
			out->transforms[b].m[5 * axis] = place[b][3 + axis];
			out->transforms[b].m[12 + axis] = place[b][axis];
		}
		out->parts[b] = (stilb_geometry_impostor_part){
			.mesh = &out->mesh, .material = &out->materials[b], .transform = &out->transforms[b]};
	}
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* A renderer with the model both ways, and a wall. */
typedef struct stage {
	stilb_render *render;
	stilb_render_mesh mesh, wall_mesh;
	stilb_render_material materials[BOXES], wall;
	stilb_render_impostor impostor;
	const boxes *model;
	bool walled;
} stage;

static stage stage_open(const boxes *model, const stilb_scene_impostor *impostor, stilb_render_desc desc)
{
	stage s = {.model = model};
	static const stilb_scene_material grey = {.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	stilb_scene_mesh plane;
	desc.context_count = 3;
	desc.validate = true;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_mesh_create(s.render, &model->mesh, &s.mesh), STILB_OK);
	for (int b = 0; b < BOXES; b++)
		assert_int_equal(
			stilb_render_material_create(s.render, &model->materials[b], (stilb_render_texture){0}, &s.materials[b]),
			STILB_OK);
	assert_int_equal(stilb_render_impostor_create(s.render, impostor, &s.impostor), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(s.render, &plane, &s.wall_mesh), STILB_OK);
	assert_int_equal(stilb_render_material_create(s.render, &grey, (stilb_render_texture){0}, &s.wall), STILB_OK);
	stilb_scene_mesh_finish(&plane);
	return s;
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
}

/* The picture of the model under a transform, as meshes or as an impostor. */
static stilb_image stage_picture(stage *s, bool impostor, const stilb_mat4 *transform, const stilb_render_view *view)
{
	stilb_render_pass pass = {.name = "scene"};
	stilb_image image = {0};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	stilb_render_segment_begin(context, 0, 0);
	for (int b = 0; b < BOXES && !impostor; b++) {
		stilb_mat4 m = stilb_mat4_multiply(*transform, s->model->transforms[b]);
		stilb_render_draw(context, s->mesh, s->materials[b], &m);
	}
	if (impostor)
		stilb_render_draw(context, s->impostor.mesh, s->impostor.material, transform);
	if (s->walled) { /* through the model's middle, seen from above and below */
		stilb_mat4 wall = stilb_mat4_scale_translate(20.0f, 0.0f, 0.0f, 0.0f);
		stilb_render_draw(context, s->wall_mesh, s->wall, &wall);
	}
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, view, 1, pool, 0), STILB_OK);
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static const stilb_scene_light lights[2] = {
	{.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.64f, -0.48f}, .intensity = {1.5f, 1.4f, 1.2f}},
	{.kind = STILB_SCENE_LIGHT_POINT, .position = {6, 5, 4}, .intensity = {30, 40, 50}}};

/* Looks at a point from a direction, so far away that a sphere of this radius covers four fifths of the picture. */
static stilb_render_view view_from(stilb_vec3 direction, const float center[3], float radius)
{
	float far = radius / (0.8f * tanf(0.2f));
	stilb_scene_camera camera = {.yaw = atan2f(direction[0], direction[2]),
	                             .pitch = -asinf(direction[1]),
	                             .fov_y = 0.4f,
	                             .near_z = 0.1f * far,
	                             .far_z = 10.0f * far};
	for (int axis = 0; axis < 3; axis++)
		camera.position[axis] = center[axis] + direction[axis] * far;
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, 1.0f),
	                          .lights = lights,
	                          .light_count = 2,
	                          .surroundings = {.sky = {0.35f, 0.4f, 0.5f}, .ground = {0.15f, 0.13f, 0.1f}},
	                          .shading = stilb_render_shading_default(),
	                          .backdrop = {.kind = STILB_SCENE_BACKDROP_NOTHING}};
	memcpy(view.camera_position, camera.position, sizeof view.camera_position);
	return view;
}

/* The 26 directions to the faces, edges and corners of a cube, a little aside: no picture of the impostor is theirs. */
static stilb_vec3 direction_of(int i)
{
	int cell = i < 13 ? i : i + 1;
	return stilb_vec3_normalize(
		stilb_vec3_make((float)(cell % 3) - 0.87f, (float)(cell / 3 % 3) - 0.93f, (float)(cell / 9) - 1.05f));
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

/* Means of FINE x FINE points, premultiplied, with the share that is covered: [SIZE][SIZE][4]. */
static void average(const stilb_image *image, double out[SIZE * SIZE][4])
{
	assert_int_equal(image->channels, 4);
	assert_int_equal(image->width, SIZE * FINE);
	memset(out, 0, SIZE * SIZE * sizeof *out);
	for (uint32_t i = 0; i < image->width * image->height; i++) {
		const uint8_t *p = (const uint8_t *)image->pixels + 4 * (size_t)i;
		double *to = out[i / image->width / FINE * SIZE + i % image->width / FINE];
		for (int c = 0; c < 4; c++)
			to[c] += (c < 3 ? (double)p[c] * (double)p[3] / 255.0 : (double)p[3]) / 255.0 / (FINE * FINE);
	}
}

typedef struct difference {
	double rms;    /* over pixels that one of the pictures covers somewhere */
	double middle; /* over those that both cover everywhere */
	double area;   /* covered of the second picture for the first one's 1 */
} difference;

static difference compare(const stilb_image *a, const stilb_image *b)
{
	static double of_a[SIZE * SIZE][4], of_b[SIZE * SIZE][4];
	double sum = 0.0, inner = 0.0, area_a = 0.0, area_b = 0.0;
	uint32_t some = 0, all = 0;
	average(a, of_a);
	average(b, of_b);
	for (uint32_t i = 0; i < SIZE * SIZE; i++) {
		double square = 0.0;
		for (int c = 0; c < 3; c++)
			square += (of_a[i][c] - of_b[i][c]) * (of_a[i][c] - of_b[i][c]) / 3.0;
		area_a += of_a[i][3];
		area_b += of_b[i][3];
		bool whole = of_a[i][3] > 0.999 && of_b[i][3] > 0.999, any = of_a[i][3] > 0.0 || of_b[i][3] > 0.0;
		sum += any ? square : 0.0;
		inner += whole ? square : 0.0;
		some += any;
		all += whole;
	}
	assert_true(some > 10 && all > 0);
	return (difference){sqrt(sum / some), sqrt(inner / all), area_b / area_a};
}

static void write_pictures(const char *name, int i, const stilb_image *mesh, const stilb_image *impostor)
{
	const char *folder = getenv("STILB_IMPOSTOR_PICTURES");
	char path[512];
	for (int k = 0; k < 2 && folder; k++) {
		snprintf(path, sizeof path, "%s/%s_%02d_%s.png", folder, name, i, k ? "impostor" : "mesh");
		assert_int_equal(stilb_image_save(k ? impostor : mesh, path), STILB_OK);
	}
}

static stilb_scene_impostor baked(const boxes *model)
{
	stilb_geometry_impostor_desc desc = stilb_geometry_impostor_desc_default();
	stilb_scene_impostor impostor;
	assert_int_equal(stilb_geometry_impostor_bake(model->parts, BOXES, &desc, pool, 0, &impostor), STILB_OK);
	return impostor;
}

static stilb_vec3 moved(const stilb_mat4 *m, const float p[3])
{
	return stilb_vec3_make(m->m[0] * p[0] + m->m[4] * p[1] + m->m[8] * p[2] + m->m[12],
	                       m->m[1] * p[0] + m->m[5] * p[1] + m->m[9] * p[2] + m->m[13],
	                       m->m[2] * p[0] + m->m[6] * p[1] + m->m[10] * p[2] + m->m[14]);
}

/* Pictures from all directions under a transform that makes the sphere up to `stretch` times as large. */
static void check_directions(const char *name, const stilb_mat4 *transform, float stretch, bool walled, bool both_sides)
{
	boxes model;
	boxes_make(&model);
	stilb_scene_impostor impostor = baked(&model);
	stage s =
		stage_open(&model, &impostor, (stilb_render_desc){.width = SIZE * FINE, .height = SIZE * FINE, .samples = 1});
	stilb_vec3 at = moved(transform, impostor.center);
	float center[3] = {at[0], at[1], at[2]};
	double sum = 0.0;
	s.walled = walled;
	for (int i = 0; i < 26; i += STEP) {
		stilb_render_view view = view_from(direction_of(i), center, impostor.radius * stretch);
		view.both_sides = both_sides;
		stilb_image a = stage_picture(&s, false, transform, &view), b = stage_picture(&s, true, transform, &view);
		difference found = compare(&a, &b);
		write_pictures(name, i, &a, &b);
		stilb_image_finish(&a);
		stilb_image_finish(&b);
		sum += found.rms * found.rms;
		if (found.rms > 2.0 * BOUND || found.middle > BOUND || fabs(found.area - 1.0) > 0.06)
			fail_msg("%s, direction %d: RMS %.4f, %.4f where both cover all, area %.4f", name, i, found.rms,
			         found.middle, found.area);
	}
	double rms = sqrt(sum / (26 / STEP));
	print_message("%s: RMS %.4f\n", name, rms);
	assert_true(rms <= BOUND);
	stage_close(&s);
	stilb_scene_impostor_finish(&impostor);
}

static void test_directions(void **state)
{
	(void)state;
	stilb_mat4 still = stilb_mat4_identity();
	check_directions("still", &still, 1.0f, false, false);
}

/* Turned, stretched by twice in one direction, and elsewhere. */
static void test_transform(void **state)
{
	(void)state;
	stilb_mat4 transform = {{0.8f, 0.6f, 0, 0, -1.2f, 1.6f, 0, 0, 0, 0, 1, 0, 7, -3, 2, 1}};
	check_directions("turned", &transform, 2.0f, false, false);
}

/* A mirrored model's triangles face inwards: only with both sides it looks as it should. */
static void test_mirrored(void **state)
{
	(void)state;
	stilb_mat4 mirror = stilb_mat4_identity();
	mirror.m[0] = -1.0f;
	check_directions("mirrored", &mirror, 1.0f, false, true);
}

/* The ground goes through the model: what is below it is hidden, as of meshes. */
static void test_depth(void **state)
{
	(void)state;
	stilb_mat4 still = stilb_mat4_identity();
	check_directions("walled", &still, 1.0f, true, false);
}

/* ---- ways to draw ------------------------------------------------------------------------------------------------ */

static void test_replays(void **state)
{
	(void)state;
	boxes model;
	boxes_make(&model);
	stilb_scene_impostor impostor = baked(&model);
	stilb_mat4 still = stilb_mat4_identity();
	stilb_render_view view = view_from(direction_of(7), impostor.center, impostor.radius);
	stilb_image first = {0};
	uint64_t hash = 0;
	for (int way = 0; way < 9; way++) {
		if (TEST_ASAN && way % 3 != way / 3)
			continue; /* each replay and each kind of materials once; test_render_picture has all pairs */
		stage s = stage_open(&model, &impostor,
		                     (stilb_render_desc){.width = 64,
		                                         .height = 64,
		                                         .samples = 1,
		                                         .replay = (stilb_render_replay_mode)(way % 3),
		                                         .materials = (stilb_render_materials)(way / 3)});
		s.walled = true; /* another pipeline after it */
		stilb_image image = stage_picture(&s, true, &still, &view);
		if (way == 0) {
			first = image;
			hash = stilb_render_stream_hash(s.render);
		} else {
			assert_int_equal(stilb_render_stream_hash(s.render), hash);
			assert_memory_equal(image.pixels, first.pixels, stilb_image_size(&first));
			stilb_image_finish(&image);
		}
		stage_close(&s);
	}
	stilb_image_finish(&first);
	stilb_scene_impostor_finish(&impostor);
}

/* Four samples a pixel are covered as a quarter each: the picture is closer to the truth than that of one. */
static void test_samples(void **state)
{
	(void)state;
	boxes model;
	boxes_make(&model);
	stilb_scene_impostor impostor = baked(&model);
	stilb_mat4 still = stilb_mat4_identity();
	double error[2] = {0.0};
	stage fine =
		stage_open(&model, &impostor, (stilb_render_desc){.width = SIZE * FINE, .height = SIZE * FINE, .samples = 1});
	for (int many = 0; many < 2; many++) {
		stage s =
			stage_open(&model, &impostor, (stilb_render_desc){.width = SIZE, .height = SIZE, .samples = many ? 4 : 1});
		for (int i = 0; i < 26; i += STEP) {
			stilb_render_view view = view_from(direction_of(i), impostor.center, impostor.radius);
			stilb_image truth = stage_picture(&fine, false, &still, &view),
						image = stage_picture(&s, true, &still, &view);
			static double means[SIZE * SIZE][4];
			average(&truth, means);
			for (uint32_t p = 0; p < SIZE * SIZE; p++) {
				double covered = (double)((const uint8_t *)image.pixels)[4 * p + 3] / 255.0;
				error[many] += (covered - means[p][3]) * (covered - means[p][3]);
			}
			stilb_image_finish(&truth);
			stilb_image_finish(&image);
		}
		stage_close(&s);
	}
	print_message("error of coverage: one sample %.4f, four %.4f\n", error[0], error[1]);
	assert_true(error[1] < 0.4 * error[0]);
	stage_close(&fine);
	stilb_scene_impostor_finish(&impostor);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_directions), cmocka_unit_test(test_transform), cmocka_unit_test(test_mirrored),
		cmocka_unit_test(test_depth),      cmocka_unit_test(test_replays),   cmocka_unit_test(test_samples),
	};
	assert(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &pool) == 0);
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	stilb_job_pool_destroy(pool);
	return failed;
}
