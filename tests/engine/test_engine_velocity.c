/* The images of velocities, depth, normals and models: each pixel's is that of the point that it shows, which this test
 * finds by itself, in double, from the vertices, transforms and cameras of two frames. */
#include "engine_internal.h"
#include "geometry/geometry_impostor.h"
#include "render/device/render_images.h"
#include "render/render_internal.h"
#include "scene/edit/scene_edit.h"
#include "scene/play/scene_play.h"
#include "shading/shade_impostor.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 96u
#define HEIGHT 64u
#define MODELS 6u
#define FIGURES 3u
#define ALLOWED (1.0 / 16.0) /* pixels */

/* ---- a frame as it was ------------------------------------------------------------------------------------------- */

/* What the scene had in a frame. */
typedef struct moment {
	stilb_mat4 view_projection;
	float camera[3];
	float (*positions)[3]; /* of all meshes' vertices */
	uint32_t *first;       /* [mesh_count] of a mesh among them */
	stilb_mat4 *parts;     /* [part_count] */
} moment;

typedef struct stage {
	stilb_engine *engine;
	stilb_scene *scene;
	uint32_t frame;
	bool walks, plays, jumps; /* the camera, the figures, model 0 in the first frames */
	moment now, before;
	uint32_t hidden; /* a material that draws no velocity; STILB_SCENE_NONE: none */
	bool levels;     /* models but the first are not drawn in full: they do not count */
} stage;

static void moment_free(moment *m)
{
	free(m->positions);
	free(m->first);
	free(m->parts);
	*m = (moment){0};
}

static moment moment_of(const stage *s)
{
	const stilb_scene *scene = s->scene;
	uint32_t vertices = 0;
	moment m = {.view_projection = stilb_scene_camera_matrix(&scene->camera, (float)WIDTH / HEIGHT),
	            .first = calloc(scene->mesh_count, sizeof *m.first),
	            .parts = malloc(scene->part_count * sizeof *m.parts)};
	memcpy(m.camera, scene->camera.position, sizeof m.camera);
	memcpy(m.parts, scene->part_transform, scene->part_count * sizeof *m.parts);
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		m.first[i] = vertices;
		vertices += scene->meshes[i].vertex_count;
	}
	m.positions = malloc(vertices * sizeof *m.positions);
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		for (uint32_t v = 0; v < scene->meshes[i].vertex_count; v++)
			memcpy(m.positions[m.first[i] + v], scene->meshes[i].vertices[v].position, sizeof *m.positions);
	return m;
}

/* A point in clip space. */
static void moment_project(const moment *m, uint32_t part, const double local[3], double clip[4])
{
	double world[4] = {0, 0, 0, 1};
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			world[r] += (double)m->parts[part].m[4 * c + r] * (c < 3 ? local[c] : 1.0);
	for (int r = 0; r < 4; r++) {
		clip[r] = 0.0;
		for (int c = 0; c < 4; c++)
			clip[r] += (double)m->view_projection.m[4 * c + r] * world[c];
	}
}

/* ---- the truth --------------------------------------------------------------------------------------------------- */

#define SAMPLES 5u /* of a pixel: its middle, and four close by, which tell whether an edge is near */

typedef struct truth {
	double near[SAMPLES]; /* 1 / w of what is seen; 0: nothing */
	uint32_t part[SAMPLES];
	double velocity[2], depth, normal[3]; /* in the middle */
} truth;

static truth found[HEIGHT][WIDTH];

/* The place of a sample in the picture, pixels. */
static void sample_place(uint32_t x, uint32_t y, uint32_t sample, double place[2])
{
	static const double steps[SAMPLES][2] = {{0, 0}, {0.03, 0.03}, {-0.03, 0.03}, {0.03, -0.03}, {-0.03, -0.03}};
	place[0] = x + 0.5 + steps[sample][0];
	place[1] = y + 0.5 + steps[sample][1];
}

static void pixels_of(const double clip[4], double place[2])
{
	place[0] = (clip[0] / clip[3] + 1.0) * 0.5 * WIDTH;
	place[1] = (clip[1] / clip[3] + 1.0) * 0.5 * HEIGHT;
}

static double side_of(const double a[2], const double b[2], const double p[2])
{
	return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* The unit normal of a part's triangle, between its corners. */
static void find_normal(const stage *s, uint32_t part, const uint32_t corners[3], const double weights[3],
                        double out[3])
{
	const float *m = s->now.parts[part].m; /* its columns */
	const stilb_scene_vertex *vertices = s->scene->meshes[s->scene->part_mesh[part]].vertices;
	double n[3] = {0, 0, 0}, length = 0.0;
	for (int c = 0; c < 3; c++)
		for (int i = 0; i < 3; i++)
			n[i] += weights[c] * (double)vertices[corners[c]].normal[i];
	for (int i = 0; i < 3; i++) { /* by the cofactors */
		out[i] = 0.0;
		for (int k = 0; k < 3; k++) {
			int a = (i + 1) % 3, b = (i + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
			out[i] +=
				((double)m[4 * c + a] * (double)m[4 * d + b] - (double)m[4 * c + b] * (double)m[4 * d + a]) * n[k];
		}
		length += out[i] * out[i];
	}
	for (int i = 0; i < 3; i++)
		out[i] /= sqrt(length);
}

/* A triangle of a part: sets what its samples see where it is the nearest. */
static void find_triangle(const stage *s, uint32_t part, const uint32_t corners[3])
{
	double clip[3][4], at[3][2], local[3][3], last[3][3];
	uint32_t mesh = s->scene->part_mesh[part];
	for (int c = 0; c < 3; c++) {
		for (int i = 0; i < 3; i++) {
			local[c][i] = (double)s->now.positions[s->now.first[mesh] + corners[c]][i];
			last[c][i] = (double)s->before.positions[s->before.first[mesh] + corners[c]][i];
		}
		moment_project(&s->now, part, local[c], clip[c]);
		if (clip[c][3] < 0.05)
			return; /* cameras of this test keep away from surfaces */
		pixels_of(clip[c], at[c]);
	}
	double area = side_of(at[0], at[1], at[2]);
	if (area > -1e-12) /* seen from behind */
		return;
	int left = (int)floor(fmin(at[0][0], fmin(at[1][0], at[2][0]))) - 1;
	int right = (int)ceil(fmax(at[0][0], fmax(at[1][0], at[2][0]))) + 1;
	int top = (int)floor(fmin(at[0][1], fmin(at[1][1], at[2][1]))) - 1;
	int bottom = (int)ceil(fmax(at[0][1], fmax(at[1][1], at[2][1]))) + 1;
	for (int y = top < 0 ? 0 : top; y < bottom && y < (int)HEIGHT; y++)
		for (int x = left < 0 ? 0 : left; x < right && x < (int)WIDTH; x++)
			for (uint32_t sample = 0; sample < SAMPLES; sample++) {
				double place[2], share[3], near = 0.0;
				truth *t = &found[y][x];
				sample_place((uint32_t)x, (uint32_t)y, sample, place);
				share[0] = side_of(at[1], at[2], place) / area;
				share[1] = side_of(at[2], at[0], place) / area;
				share[2] = 1.0 - share[0] - share[1];
				if (share[0] < 0.0 || share[1] < 0.0 || share[2] < 0.0)
					continue;
				for (int c = 0; c < 3; c++)
					near += share[c] / clip[c][3];
				if (near <= t->near[sample])
					continue;
				t->near[sample] = near;
				t->part[sample] = part;
				double from[3] = {0, 0, 0}, to[4], then[2];
				for (int c = 0; c < 3; c++)
					for (int i = 0; i < 3; i++)
						from[i] += share[c] / clip[c][3] / near * last[c][i];
				moment_project(&s->before, part, from, to);
				pixels_of(to, then);
				for (int i = 0; sample == 0 && i < 2; i++)
					t->velocity[i] = then[i] - place[i];
				if (sample > 0)
					continue;
				double weights[3];
				t->depth = 0.0;
				for (int c = 0; c < 3; c++) {
					weights[c] = share[c] / clip[c][3] / near;
					t->depth += share[c] * clip[c][2] / clip[c][3];
				}
				find_normal(s, part, corners, weights, t->normal);
			}
}

/* What is seen where nothing is: the same direction, from the camera before. By the axes of the matrix's rows. */
static void find_far(const stage *s, uint32_t x, uint32_t y)
{
	const float *now = s->now.view_projection.m, *before = s->before.view_projection.m;
	double place[2], direction[3], clip[4] = {0}, then[2];
	sample_place(x, y, 0, place);
	double across = place[0] / WIDTH * 2.0 - 1.0, down = place[1] / HEIGHT * 2.0 - 1.0, squares[2] = {0, 0};
	for (int i = 0; i < 3; i++)
		for (int r = 0; r < 2; r++)
			squares[r] += (double)now[4 * i + r] * (double)now[4 * i + r];
	for (int i = 0; i < 3; i++)
		direction[i] = (double)now[4 * i + 3] + across * (double)now[4 * i] / squares[0] +
		               down * (double)now[4 * i + 1] / squares[1];
	for (int r = 0; r < 4; r++)
		for (int i = 0; i < 3; i++)
			clip[r] += (double)before[4 * i + r] * direction[i];
	pixels_of(clip, then);
	for (int i = 0; i < 2; i++)
		found[y][x].velocity[i] = then[i] - place[i];
}

static void find_all(const stage *s)
{
	const stilb_scene *scene = s->scene;
	memset(found, 0, sizeof found);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			find_far(s, x, y);
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1]; p++) {
			if (scene->part_material[p] == s->hidden || isnan(scene->bounds.radius[m]))
				continue; /* the latter: the scene does not show it */
			const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
			for (uint32_t i = 0; i < mesh->index_count; i += 3)
				find_triangle(s, p, mesh->indices + i);
		}
}

/* ---- a run ------------------------------------------------------------------------------------------------------- */

static void stage_move(void *user, const stilb_engine_update *update)
{
	stage *s = user;
	stilb_scene *scene = s->scene;
	float t = (float)s->frame;
	(void)update;
	if (s->walks) {
		scene->camera.position[0] += 0.05f;
		scene->camera.position[1] += 0.02f * t;
		scene->camera.yaw += 0.01f;
		scene->camera.pitch -= 0.004f;
	}
	if (s->jumps && s->frame < 4) {
		stilb_mat4 place = scene->part_transform[scene->first_part[0]];
		place.m[12] += 0.1f * t;
		place.m[13] += 0.3f;
		assert_int_equal(stilb_scene_set_transform(scene, 0, &place), STILB_OK);
	}
}

static stilb_render_detail detail; /* of stages that open; likewise the next two */
static stilb_render_lighting lighting;
static bool surfaces; /* normals and models, too */

static void stage_open(stage *s, uint32_t workers, uint32_t samples, bool velocity)
{
	*s = (stage){.hidden = STILB_SCENE_NONE, .walks = true, .plays = true, .jumps = true};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = samples;
	desc.workers = workers;
	desc.validate = true;
	desc.profile = false;
	desc.velocity = velocity;
	desc.surfaces = surfaces;
	desc.lighting = lighting;
	desc.detail = detail;
	desc.update = stage_move;
	desc.user = s;
	assert_int_equal(stilb_scene_create_stress(MODELS, 7, &s->scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_figures(s->scene, FIGURES), STILB_OK);
	s->scene->camera = stilb_scene_stress_camera(s->scene, STILB_SCENE_VIEW_ALL, (float)WIDTH / HEIGHT);
	if (stilb_engine_create(&desc, &s->engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* Has the camera look at the last figure from near by. */
static void stage_look(stage *s)
{
	const stilb_scene *scene = s->scene;
	uint32_t part = scene->part_count - 1;
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	const float *t = scene->part_transform[part].m;
	float low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f};
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int i = 0; i < 3; i++) {
			const float *p = mesh->vertices[v].position;
			float world = t[i] * p[0] + t[4 + i] * p[1] + t[8 + i] * p[2] + t[12 + i];
			low[i] = fminf(low[i], world);
			high[i] = fmaxf(high[i], world);
		}
	s->scene->camera.position[0] = 0.5f * (low[0] + high[0]);
	s->scene->camera.position[1] = 0.5f * (low[1] + high[1]);
	s->scene->camera.position[2] = high[2] + 1.3f * (high[1] - low[1]);
	s->scene->camera.yaw = s->scene->camera.pitch = 0.0f;
}

static void stage_show(stage *s)
{
	if (stilb_engine_set_scene(s->engine, s->scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_engine_validation_messages(s->engine), 0);
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
	moment_free(&s->now);
	moment_free(&s->before);
}

static void stage_frame(stage *s)
{
	stilb_engine_report report;
	stilb_engine_set_pace(s->engine, s->plays ? 1.0f : 0.0f);
	if (stilb_engine_frame(s->engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	s->frame++;
	moment_free(&s->before);
	s->before = s->now;
	s->now = moment_of(s);
}

/* Of a half float, which is no infinity. */
static double half_of(uint16_t bits)
{
	int exponent = bits >> 10 & 31, mantissa = bits & 1023;
	double size = exponent == 0 ? ldexp(mantissa, -24) : ldexp(mantissa + 1024, exponent - 25);
	assert_int_not_equal(exponent, 31);
	return bits & 0x8000 ? -size : size;
}

static double shown[HEIGHT][WIDTH][2];

/* A copy of an image of the last frame. */
static void stage_copy(stage *s, const char *name, size_t size, void *out)
{
	stilb_gpu *gpu = stilb_engine_gpu(s->engine);
	const stilb_gpu_plan *plan = stilb_engine_plan(s->engine);
	uint64_t ticket, frame;
	const void *bytes;
	uint16_t image = stilb_gpu_plan_find(plan, name);
	assert_int_not_equal(image, 0);
	assert_int_equal(stilb_gpu_read_begin(gpu, plan, image, 0, 0, &ticket), STILB_OK);
	assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
	memcpy(out, bytes, size);
	stilb_gpu_read_end(gpu, ticket);
}

static void stage_read(stage *s, const char *name)
{
	static uint16_t halves[2 * WIDTH * HEIGHT];
	stage_copy(s, name, sizeof halves, halves);
	for (uint32_t i = 0; i < 2 * WIDTH * HEIGHT; i++)
		(&shown[0][0][0])[i] = half_of(halves[i]);
}

/* What a comparison met. */
typedef struct outcome {
	uint32_t clear, moving; /* pixels away from edges; of these those of models that are somewhere else than before */
	double worst;           /* pixels */
} outcome;

/* True if no edge is near the pixel. */
static bool is_clear(const truth *t)
{
	bool clear = true;
	for (uint32_t i = 1; i < SAMPLES; i++)
		clear &= (t->near[i] > 0.0) == (t->near[0] > 0.0) &&
		         fabs(t->near[i] - t->near[0]) < 0.01 * t->near[0] + 1e-12 && t->part[i] == t->part[0];
	return clear;
}

/* Compares what the last frame has drawn with the truth. */
static outcome stage_compare(stage *s)
{
	outcome o = {0};
	stage_read(s, STILB_RENDER_IMAGE_VELOCITY);
	find_all(s);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			const truth *t = &found[y][x];
			if (!is_clear(t) || (s->levels && (t->near[0] == 0.0 || t->part[0] >= s->scene->first_part[1])))
				continue;
			double away = hypot(shown[y][x][0] - t->velocity[0], shown[y][x][1] - t->velocity[1]);
			o.clear++;
			o.moving += t->near[0] > 0.0 && hypot(t->velocity[0], t->velocity[1]) > 0.1;
			o.worst = away > o.worst ? away : o.worst;
		}
	return o;
}

/* The scene's model of a part. */
static uint32_t model_of(const stage *s, uint32_t part)
{
	uint32_t m = 0;
	while (s->scene->first_part[m + 1] <= part)
		m++;
	return m;
}

/* Compares normals, models and depth with the truth that stage_compare has found. Normals have 16 bits on their map,
 * and 2^-16 in meshes that are packed; those of coarse balls are bent towards the viewer where they look away. */
static void stage_compare_surfaces(stage *s)
{
	static uint16_t normals[HEIGHT][WIDTH][2];
	static uint32_t ids[HEIGHT][WIDTH];
	static float depths[HEIGHT][WIDTH];
	stage_copy(s, STILB_RENDER_IMAGE_SURFACE_NORMAL, sizeof normals, normals);
	stage_copy(s, STILB_RENDER_IMAGE_ID, sizeof ids, ids);
	bool own = stilb_gpu_plan_find(stilb_engine_plan(s->engine), STILB_RENDER_IMAGE_VELOCITY_DEPTH) != 0;
	stage_copy(s, own ? STILB_RENDER_IMAGE_VELOCITY_DEPTH : STILB_RENDER_IMAGE_DEPTH, sizeof depths, depths);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			const truth *t = &found[y][x];
			if (!is_clear(t))
				continue;
			uint32_t model = t->near[0] > 0.0 ? 1 + model_of(s, t->part[0]) : 0;
			if (ids[y][x] != model)
				fail_msg("way %d, pixel %u, %u: model %u, not %u", lighting, x, y, ids[y][x], model);
			if (!(fabs((double)depths[y][x] - t->depth) <= 1e-5 + 1e-4 * t->depth))
				fail_msg("way %d, pixel %u, %u: depth %g, not %g", lighting, x, y, (double)depths[y][x], t->depth);
			stilb_vec3 n = shade_direction_from_octahedral(
				(stilb_vec2){(float)normals[y][x][0] / 32767.5f - 1.0f, (float)normals[y][x][1] / 32767.5f - 1.0f});
			double along = 0.0;
			for (int i = 0; i < 3; i++)
				along += (double)n[i] * t->normal[i];
			if (model > 0 && !(along >= 1.0 - 1e-6))
				fail_msg("way %d, pixel %u, %u: a normal is off by %g radians", lighting, x, y, acos(along));
		}
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static stage it;

/* Camera, figures and a model move; then they stop, one after another. */
static void all_that_moves(void **state)
{
	(void)state;
	double worst = 0.0;
	for (uint32_t run = 0; run < 3; run++) {
		stage_open(&it, run == 1 ? 2 : 0, run == 2 ? 4 : 1, true);
		stage_show(&it);
		stage_frame(&it);
		stage_read(&it, STILB_RENDER_IMAGE_VELOCITY);
		for (uint32_t i = 0; i < 2 * WIDTH * HEIGHT; i++) /* nobody knows where anything was */
			assert_true(fabs((&shown[0][0][0])[i]) < 1e-3);
		for (uint32_t f = 0; f < 8; f++) {
			it.plays = f < 6;
			it.walks = f != 4 && f < 7;
			stage_frame(&it);
			if (f == 0)
				continue; /* vertices of posed meshes are known from then on */
			outcome o = stage_compare(&it);
			if (!(o.worst <= ALLOWED))
				fail_msg("run %u, frame %u: off by %g pixels", run, f, o.worst);
			assert_true(o.clear > WIDTH * HEIGHT / 2);
			assert_true(f == 7 ? o.moving == 0 : f == 4 || o.moving > 100);
			worst = o.worst > worst ? o.worst : worst;
		}
		stage_close(&it);
	}
	print_message("off by at most %.4f pixels\n", worst);
}

/* In every way of lighting a frame leaves the same behind. */
static void every_way(void **state)
{
	(void)state;
	surfaces = true;
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		lighting = (stilb_render_lighting)way;
		stage_open(&it, 0, way == STILB_RENDER_LIGHTING_CLUSTERED ? 4 : 1, false);
		assert_int_equal(stilb_scene_stress_add_lamps(it.scene, 12), STILB_OK);
		stage_show(&it);
		for (uint32_t f = 0; f < 4; f++)
			stage_frame(&it);
		outcome o = stage_compare(&it);
		if (!(o.worst <= ALLOWED))
			fail_msg("way %d: off by %g pixels", way, o.worst);
		assert_true(o.moving > 100);
		stage_compare_surfaces(&it);
		stage_close(&it);
	}
	surfaces = false;
	lighting = STILB_RENDER_LIGHTING_AUTO;
}

/* Figures alone: what stands still beside them has no velocity at all. */
static void figures_alone(void **state)
{
	(void)state;
	stage_open(&it, 0, 1, true);
	stage_look(&it);
	stage_show(&it);
	it.walks = it.jumps = false;
	uint32_t still = 0, moving = 0;
	for (uint32_t f = 0; f < 5; f++)
		stage_frame(&it);
	outcome o = stage_compare(&it);
	assert_true(o.worst <= ALLOWED);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			double size = hypot(shown[y][x][0], shown[y][x][1]);
			still += size < 1e-4;
			moving += size > 0.02;
		}
	assert_true(still > WIDTH * HEIGHT / 3 && moving > 50);
	stage_close(&it);
}

/* A material with a mask that leaves nothing, and one that blends, leave what lies behind them. */
static void masks_and_blends(void **state)
{
	(void)state;
	static const stilb_scene_alpha kinds[] = {STILB_SCENE_MASK, STILB_SCENE_BLEND};
	for (uint32_t k = 0; k < 3; k++) { /* the third: a mask that leaves all */
		stage_open(&it, 0, k == 0 ? 4 : 1, true);
		stilb_scene_surface surface = stilb_scene_surface_make();
		uint32_t id, material = it.scene->part_material[it.scene->first_part[0]];
		surface.alpha = kinds[k % 2];
		surface.color[3] = k == 2 ? 0.9f : 0.2f;
		surface.cutoff = 0.5f;
		assert_int_equal(stilb_scene_add_surface(it.scene, &surface, &id), STILB_OK);
		stilb_scene_material changed = it.scene->materials[material];
		changed.surface = 1 + id;
		changed.diffuse_texture = 0;
		assert_int_equal(stilb_scene_set_material(it.scene, material, &changed), STILB_OK);
		stage_show(&it);
		it.hidden = k < 2 ? material : STILB_SCENE_NONE;
		for (uint32_t f = 0; f < 4; f++)
			stage_frame(&it);
		outcome o = stage_compare(&it);
		if (!(o.worst <= ALLOWED))
			fail_msg("kind %u: off by %g pixels", k, o.worst);
		stage_close(&it);
	}
}

/* A model far away is drawn as its impostor, which stands for points of about the same place. */
static void impostors_move(void **state)
{
	(void)state;
	detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 1.0f};
	stage_open(&it, 0, 1, true);
	detail = (stilb_render_detail){0};
	uint32_t id;
	stilb_scene_impostor impostor;
	stilb_geometry_impostor_desc desc = stilb_geometry_impostor_desc_default();
	stilb_mat4 place = it.scene->part_transform[it.scene->first_part[0]]; /* of all parts, as they will move */
	assert_int_equal(stilb_scene_set_transform(it.scene, 0, &place), STILB_OK);
	assert_int_equal(stilb_geometry_impostor_of_model(it.scene, 0, &desc, it.engine->pool, 0, &impostor), STILB_OK);
	assert_int_equal(stilb_scene_add_impostor(it.scene, &impostor, &id), STILB_OK);
	assert_int_equal(stilb_scene_set_impostor(it.scene, 0, 1 + id), STILB_OK);
	stage_show(&it);
	it.levels = true;
	for (uint32_t f = 0; f < 4; f++)
		stage_frame(&it);
	assert_int_not_equal(it.engine->render->passes[0].impostors[0], 0); /* it is drawn */
	outcome o = stage_compare(&it);
	if (!(o.worst <= ALLOWED))
		fail_msg("off by %g pixels", o.worst);
	assert_true(o.moving > 20);
	stage_close(&it);
}

/* Velocities change nothing of the picture, and a second camera has its own. */
static void pictures_stay(void **state)
{
	(void)state;
	stilb_image images[2];
	for (int velocity = 0; velocity < 2; velocity++) {
		stage_open(&it, 1, 1, velocity);
		stage_show(&it);
		stilb_engine_camera camera = {.name = "beside", .camera = it.scene->camera, .width = WIDTH, .height = HEIGHT};
		stilb_engine_set_cameras(it.engine, &camera, 1);
		for (uint32_t f = 0; f < 4; f++)
			stage_frame(&it);
		assert_int_equal(stilb_engine_screenshot(it.engine, "velocity.png"), STILB_OK);
		assert_int_equal(stilb_image_load("velocity.png", &images[velocity]), STILB_OK);
		remove("velocity.png");
		if (velocity) {
			stage_compare(&it);
			stage_read(&it, "beside velocity");
			double corner = hypot(shown[0][0][0], shown[0][0][1]);
			assert_true(corner < 1e-3); /* this camera stands still */
		} else {
			assert_int_equal(stilb_gpu_plan_find(stilb_engine_plan(it.engine), STILB_RENDER_IMAGE_VELOCITY), 0);
		}
		stage_close(&it);
	}
	assert_memory_equal(images[0].pixels, images[1].pixels, (size_t)WIDTH * HEIGHT * 3);
	stilb_image_finish(&images[0]);
	stilb_image_finish(&images[1]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(all_that_moves),   cmocka_unit_test(every_way),      cmocka_unit_test(figures_alone),
		cmocka_unit_test(masks_and_blends), cmocka_unit_test(impostors_move), cmocka_unit_test(pictures_stay),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
