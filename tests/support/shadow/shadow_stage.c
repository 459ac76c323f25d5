#include "support/shadow/shadow_stage.h"

#include "engine_internal.h"
#include "shading/shade_frame.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FLOOR_HALF 8.0f
#define HALL_HEIGHT 4.0f
#define DARK 1e-3f /* radiance of which a share says nothing */

double shadow_stage_random(uint64_t *state, double low, double high)
{
	*state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
	return low + (high - low) * (double)(*state >> 11) * 0x1p-53;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

typedef struct stage_pieces {
	stilb_scene_build *build;
	stilb_scene_build_part plane, box, ball;
} stage_pieces;

/* The cube from -1 to 1, each side with vertices of its own. */
static stilb_scene_build_part cube(stilb_scene_build *build, uint32_t material)
{
	stilb_scene_vertex vertices[24];
	uint32_t indices[36];
	memset(vertices, 0, sizeof vertices);
	for (uint32_t side = 0; side < 6; side++) {
		uint32_t axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
		float sign = side % 2 == 0 ? 1.0f : -1.0f;
		for (uint32_t c = 0; c < 4; c++) {
			stilb_scene_vertex *vertex = &vertices[4 * side + c];
			float across = c == 1 || c == 2 ? 1.0f : -1.0f;
			vertex->normal[axis] = vertex->position[axis] = sign;
			vertex->position[u] = across * sign; /* counterclockwise as seen from outside */
			vertex->position[v] = c >= 2 ? 1.0f : -1.0f;
		}
		static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
		for (uint32_t i = 0; i < 6; i++)
			indices[6 * side + i] = 4 * side + corners[i];
	}
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 24, .index_count = 36};
	return (stilb_scene_build_part){stilb_scene_build_mesh(build, &mesh), material};
}

static void place(const stage_pieces *pieces, stilb_scene_build_part part, const stilb_mat4 *matrix)
{
	stilb_scene_build_model(pieces->build, stilb_scene_build_node(pieces->build, STILB_SCENE_NO_PARENT, matrix), &part,
	                        1);
}

static void place_box(const stage_pieces *pieces, float x, float y, float z, float half_x, float half_y, float half_z)
{
	stilb_mat4 matrix = stilb_mat4_scale_translate(1.0f, x, y, z);
	matrix.m[0] = half_x;
	matrix.m[5] = half_y;
	matrix.m[10] = half_z;
	place(pieces, pieces->box, &matrix);
}

static void place_ball(const stage_pieces *pieces, float x, float y, float z, float radius)
{
	stilb_mat4 matrix = stilb_mat4_scale_translate(radius, x, y, z);
	place(pieces, pieces->ball, &matrix);
}

static void place_floor(const stage_pieces *pieces)
{
	stilb_mat4 matrix = stilb_mat4_scale_translate(FLOOR_HALF, 0.0f, 0.0f, 0.0f);
	place(pieces, pieces->plane, &matrix);
}

static float between(uint64_t *state, double low, double high)
{
	return (float)shadow_stage_random(state, low, high);
}

static void build_balls(const stage_pieces *pieces, uint64_t *state)
{
	place_floor(pieces);
	for (int i = 0; i < 14; i++) {
		float radius = between(state, 0.2, 0.8), x = between(state, -5.0, 5.0), z = between(state, -5.0, 5.0);
		place_ball(pieces, x, i % 3 == 0 ? radius + between(state, 0.1, 1.5) : radius, z, radius);
	}
	for (int i = 0; i < 6; i++) {
		float half = between(state, 0.2, 0.6);
		place_box(pieces, between(state, -5.0, 5.0), half, between(state, -5.0, 5.0), half, half, 0.5f * half);
	}
}

static void build_hall(const stage_pieces *pieces, uint64_t *state)
{
	float half = 0.5f * HALL_HEIGHT, wall = FLOOR_HALF - 0.1f;
	place_floor(pieces);
	for (int side = -1; side <= 1; side += 2) {
		place_box(pieces, (float)side * wall, half, 0.0f, 0.1f, half, FLOOR_HALF);
		place_box(pieces, 0.0f, half, (float)side * wall, FLOOR_HALF, half, 0.1f);
		place_box(pieces, (float)side * 4.8f, HALL_HEIGHT + 0.1f, 0.0f, 3.2f, 0.1f, FLOOR_HALF);
		for (int i = 0; i < 4; i++)
			place_box(pieces, (float)side * 2.5f, half, 3.0f * (float)i - 4.5f, 0.2f, half, 0.2f);
	}
	for (int i = 0; i < 5; i++)
		place_ball(pieces, between(state, -2.0, 2.0), 0.5f, between(state, -5.0, 5.0), 0.5f);
}

static void build_clutter(const stage_pieces *pieces, uint64_t *state)
{
	place_floor(pieces);
	for (int i = 0; i < 40; i++) {
		float at[3] = {between(state, -5.0, 5.0), between(state, 0.1, 3.0), between(state, -5.0, 5.0)};
		if (i % 3 == 0) {
			place_ball(pieces, at[0], at[1], at[2], between(state, 0.1, 0.6));
			continue;
		}
		stilb_mat4 turn =
			stilb_mat4_view(stilb_vec3_make(0, 0, 0), between(state, 0.0, 6.28), between(state, -1.5, 1.5));
		stilb_mat4 matrix = stilb_mat4_scale_translate(1.0f, at[0], at[1], at[2]);
		stilb_mat4 size = stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f);
		size.m[0] = between(state, 0.05, 0.7);
		size.m[5] = between(state, 0.05, 0.7);
		size.m[10] = i % 3 == 1 ? 0.05f : between(state, 0.1, 0.7);
		turn = stilb_mat4_multiply(turn, size);
		matrix = stilb_mat4_multiply(matrix, turn);
		place(pieces, pieces->box, &matrix);
	}
}

static void build_board(const stage_pieces *pieces)
{
	place_floor(pieces);
	stilb_mat4 matrix = stilb_mat4_scale_translate(4.0f, -4.0f, 1.0f, 0.0f);
	place(pieces, pieces->plane, &matrix);
}

/* A wall without thickness that stands on the floor, 1 m high. */
static void build_wall(const stage_pieces *pieces)
{
	place_floor(pieces);
	stilb_mat4 matrix = {.m = {0, 0.5f, 0, 0, -1, 0, 0, 0, 0, 0, 4, 0, 0, 0.5f, 0, 1}}; /* y up to -x, x to y */
	place(pieces, pieces->plane, &matrix);
}

stilb_scene *shadow_stage_scene(shadow_stage_kind kind, uint64_t seed, const stilb_scene_light *light)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_material matt = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene_mesh meshes[2] = {{0}};
	stilb_scene *scene;
	uint64_t state = seed;
	stage_pieces pieces = {.build = stilb_scene_build_begin()};
	uint32_t material = stilb_scene_build_material(pieces.build, &matt);
	assert_int_equal(stilb_scene_mesh_plane(&meshes[0]), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(4, &meshes[1]), STILB_OK);
	pieces.plane = (stilb_scene_build_part){stilb_scene_build_mesh(pieces.build, &meshes[0]), material};
	pieces.ball = (stilb_scene_build_part){stilb_scene_build_mesh(pieces.build, &meshes[1]), material};
	pieces.box = cube(pieces.build, material);
	if (kind == SHADOW_STAGE_BALLS)
		build_balls(&pieces, &state);
	else if (kind == SHADOW_STAGE_HALL)
		build_hall(&pieces, &state);
	else if (kind == SHADOW_STAGE_CLUTTER)
		build_clutter(&pieces, &state);
	else if (kind == SHADOW_STAGE_WALL)
		build_wall(&pieces);
	else
		build_board(&pieces);
	stilb_scene_build_light(pieces.build, light);
	stilb_scene_surroundings dark = {0};
	stilb_scene_build_surroundings(pieces.build, &dark);
	if (stilb_scene_build_end(pieces.build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (int i = 0; i < 2; i++)
		stilb_scene_mesh_finish(&meshes[i]);
	scene->both_sides = true; /* cameras may be within a box */
	return scene;
}

stilb_scene_light shadow_stage_light(uint64_t *state, stilb_scene_light_kind kind, float radius)
{
	stilb_scene_light light = {
		.kind = kind,
		.intensity = {30.0f, 30.0f, 30.0f},
		.position = {between(state, -2.0, 2.0), between(state, 2.2, 3.6), between(state, -2.0, 2.0)},
		.direction = {between(state, -0.6, 0.6), -1.0f, between(state, -0.6, 0.6)},
		.cos_inner = 0.8f,
		.cos_outer = 0.65f,
		.radius = radius};
	float *d = light.direction, length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
	for (int i = 0; i < 3; i++)
		d[i] /= length;
	shade_frame frame = shade_frame_from_normal(stilb_vec3_make(d[0], d[1], d[2]));
	for (int i = 0; i < 3; i++) {
		light.half_x[i] = radius * frame.t[i];
		light.half_y[i] = radius * frame.b[i];
	}
	assert_null(stilb_scene_light_mistake(&light));
	return light;
}

stilb_scene_camera shadow_stage_camera(uint64_t *state)
{
	float at[3] = {between(state, -5.0, 5.0), between(state, 0.6, 3.5), between(state, -5.0, 5.0)};
	float to[3] = {between(state, -1.5, 1.5), between(state, 0.0, 1.5), between(state, -1.5, 1.5)};
	float x = to[0] - at[0], y = to[1] - at[1], z = to[2] - at[2];
	return (stilb_scene_camera){.position = {at[0], at[1], at[2]},
	                            .yaw = atan2f(-x, -z),
	                            .pitch = atan2f(y, hypotf(x, z)),
	                            .fov_y = between(state, 0.6, 1.2),
	                            .near_z = 0.05f,
	                            .far_z = 100.0f};
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

shadow_stage shadow_stage_open(shadow_stage_kind kind, uint64_t seed, const stilb_scene_light *light,
                               stilb_engine_shadows shadows, uint32_t width, uint32_t height)
{
	shadow_stage stage = {
		.scene = shadow_stage_scene(kind, seed, light), .width = width, .height = height, .shadows = shadows};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.width = width;
	desc.height = height;
	desc.samples = 1;
	desc.shadows = shadows;
	stage.lit = malloc(sizeof(float) * width * height);
	stage.share = malloc(sizeof(float) * width * height);
	assert_true(stage.lit && stage.share);
	if (stilb_engine_create(&desc, &stage.engine) != STILB_OK ||
	    stilb_engine_set_scene(stage.engine, stage.scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return stage;
}

void shadow_stage_close(shadow_stage *stage)
{
	stilb_engine_destroy(stage->engine);
	stilb_scene_destroy(stage->scene);
	free(stage->lit);
	free(stage->share);
	*stage = (shadow_stage){0};
}

/* The red radiance of a frame's pixels. */
static void radiance(const shadow_stage *stage, float *out)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(stage->engine, &report) != STILB_OK ||
	    stilb_render_read_radiance(stage->engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(image.width == stage->width && image.height == stage->height);
	const uint16_t *pixels = image.pixels;
	for (uint32_t i = 0; i < stage->width * stage->height; i++)
		out[i] = stilb_image_half_to_float(pixels[i * image.channels]);
	stilb_image_finish(&image);
}

const float *shadow_stage_share_again(shadow_stage *stage)
{
	stage->engine->desc.shadows = stage->shadows;
	radiance(stage, stage->share);
	for (uint32_t i = 0; i < stage->width * stage->height; i++)
		stage->share[i] = stage->lit[i] > DARK ? stage->share[i] / stage->lit[i] : NAN;
	return stage->share;
}

const float *shadow_stage_share(shadow_stage *stage)
{
	stage->engine->desc.shadows.kind = STILB_ENGINE_SHADOWS_OFF;
	radiance(stage, stage->lit);
	return shadow_stage_share_again(stage);
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

/* Texels of the map's side to the nearest edge at a point, and how many metres one has there; < 0: outside. */
static float place_in(const stilb_shadow_map *map, const float at[3], float *texel)
{
	const float *m = map->view_projection.m;
	float clip[4], ahead = 0.0f, square = 0.0f, x = 0.0f;
	for (int r = 0; r < 4; r++)
		clip[r] = m[r] * at[0] + m[4 + r] * at[1] + m[8 + r] * at[2] + m[12 + r];
	for (int c = 0; c < 3; c++) {
		ahead += m[4 * c + 3] * m[4 * c];
		square += m[4 * c + 3] * m[4 * c + 3];
		x += m[4 * c] * m[4 * c];
	}
	x -= square > 0.0f ? ahead * ahead / square : 0.0f;
	*texel = 2.0f * clip[3] / (sqrtf(x) * (float)map->area[2]);
	float side = 0.5f * (float)map->area[2], most = fmaxf(fabsf(clip[0]), fabsf(clip[1])) / clip[3];
	return clip[3] > 0.0f ? side * (1.0f - most) : -1.0f;
}

float shadow_stage_texel(const shadow_stage *stage, const float at[3])
{
	const stilb_shadow_plan *plan = &stage->engine->shadows.plan;
	const stilb_scene_light *light = &stage->scene->lights[0];
	assert_true(plan->light_count == 1);
	const stilb_shadow_map *maps = plan->maps + plan->lights[0].first;
	uint32_t count = plan->lights[0].count, filter = stage->engine->shadows.shadows.filter;
	float texel = 0.0f, least = 0.0f;
	if (count == 0)
		return 0.0f;
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL) {
		const float *eye = stage->scene->camera.position;
		float away = hypotf(hypotf(at[0] - eye[0], at[1] - eye[1]), at[2] - eye[2]);
		for (uint32_t c = 0; c < count; c++) {
			float edge = place_in(&maps[c], at, &texel) - (float)filter;
			if (maps[c].far > 0.0f)
				edge = fminf(edge, 2.0f * (maps[c].far - away) / texel);
			if (edge >= maps[c].blend && edge >= 0.0f)
				return texel; /* of the last one that takes part */
		}
		return texel;
	}
	if (count == 1) {
		place_in(maps, at, &texel);
		return texel;
	}
	for (uint32_t m = 0; m < count; m++) { /* of those of a cube that see it, the coarser one's */
		float edge = place_in(&maps[m], at, &texel);
		least = edge >= 0.0f ? fmaxf(least, texel) : least;
	}
	return least;
}
