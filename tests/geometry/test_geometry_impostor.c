/* Impostors, baked: a sphere against its closed form, an asymmetrical model against rays through its triangles,
 * textures and sides, the same bits for any number of workers, and everything that is refused.
 * The linker sends the modules' calls of stilb_memory_alloc here (--wrap), to let them fail. */
#include "support/test.h"

#include "geometry/geometry_impostor.h"
#include "shading/shade_impostor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t allocations_left = UINT32_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	if (allocations_left == 0)
		return NULL;
	allocations_left -= allocations_left != UINT32_MAX;
	return __real_stilb_memory_alloc(count, size);
}

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static stilb_scene_material paint(float red, float green, float blue, float roughness)
{
	float diffuse[3] = {red, green, blue}, specular[3] = {0.04f, 0.04f, 0.04f};
	return stilb_scene_material_make(diffuse, specular, roughness);
}

/* Bakes with one worker, which must succeed, and returns the maps as floats, [height][width][4]; free it. */
static float *bake(const stilb_geometry_impostor_part *parts, uint32_t count, const stilb_geometry_impostor_desc *desc,
                   stilb_scene_impostor *impostor)
{
	stilb_job_pool *pool = pool_of(1);
	stilb_result result = stilb_geometry_impostor_bake(parts, count, desc, pool, 0, impostor);
	if (result != STILB_OK)
		print_message("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
	assert_null(stilb_scene_impostor_mistake(impostor));
	stilb_job_pool_destroy(pool);
	float *maps = malloc(sizeof(float) * 4 * impostor->maps.width * impostor->maps.height);
	assert_non_null(maps);
	for (uint32_t y = 0; y < impostor->maps.height; y++)
		stilb_image_row_to_light(&impostor->maps, y, maps + 4 * (size_t)y * impostor->maps.width);
	return maps;
}

/* A texel of picture (gx, gy): its colour and coverage; lower: its normal, height and roughness. */
static const float *texel(const stilb_scene_impostor *impostor, const float *maps, uint32_t gx, uint32_t gy, uint32_t x,
                          uint32_t y, bool lower)
{
	uint32_t row = gy * impostor->side + y + (lower ? impostor->maps.height / 2 : 0);
	return maps + 4 * ((size_t)row * impostor->maps.width + gx * impostor->side + x);
}

static shade_frame frame_of(uint32_t gx, uint32_t gy, uint32_t grid)
{
	return shade_frame_from_normal(shade_impostor_direction((stilb_vec2){(float)gx, (float)gy}, (float)grid));
}

/* ---- the sphere -------------------------------------------------------------------------------------------------- */

static void check_sphere_picture(const stilb_scene_impostor *impostor, const float *maps, uint32_t gx, uint32_t gy)
{
	shade_frame frame = frame_of(gx, gy, impostor->grid);
	float side = (float)impostor->side, covered = 0.0f, scale = 0.5f * side - 1.0f;
	for (uint32_t y = 0; y < impostor->side; y++)
		for (uint32_t x = 0; x < impostor->side; x++) {
			const float *upper = texel(impostor, maps, gx, gy, x, y, false);
			const float *lower = texel(impostor, maps, gx, gy, x, y, true);
			stilb_vec2 at = shade_impostor_plate((stilb_vec2){(float)x + 0.5f, (float)y + 0.5f}, side);
			float r2 = at[0] * at[0] + at[1] * at[1];
			covered += upper[3];
			assert_float_equal(upper[0], 0.5f, 1e-3f);
			assert_float_equal(lower[3], 0.25f, 1e-3f);
			if (r2 > 0.85f)
				continue;
			assert_float_equal(upper[3], 1.0f, 0.0f); /* no gap between triangles */
			float height = sqrtf(1.0f - r2);
			stilb_vec3 normal = shade_direction_from_octahedral((stilb_vec2){lower[0], lower[1]});
			assert_float_equal(lower[2], height, 4e-3f);
			assert_float_equal(normal[0], at[0], 8e-3f);
			assert_float_equal(normal[1], at[1], 8e-3f);
			assert_float_equal(normal[2], height, 8e-3f);
			assert_true(stilb_vec3_dot(shade_frame_to_world(frame, normal), frame.n) > 0.0f);
		}
	assert_float_equal(covered / (3.14159265f * scale * scale), 1.0f, 0.01f);
}

static void test_sphere(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	stilb_scene_material material = paint(0.5f, 0.5f, 0.5f, 0.25f);
	stilb_mat4 transform = stilb_mat4_scale_translate(3.0f, 10.0f, -20.0f, 30.0f);
	stilb_geometry_impostor_part part = {.mesh = &mesh, .material = &material, .transform = &transform};
	stilb_geometry_impostor_desc desc = {.grid = TEST_TSAN ? 3 : 7, .side = 48, .samples = 4};
	stilb_scene_impostor impostor;
	float *maps = bake(&part, 1, &desc, &impostor);
	assert_float_equal(impostor.radius, 3.0f, 0.06f);
	assert_float_equal(impostor.center[0], 10.0f, 0.06f);
	assert_float_equal(impostor.center[1], -20.0f, 0.06f);
	assert_float_equal(impostor.center[2], 30.0f, 0.06f);
	for (int axis = 0; axis < 3; axis++)
		assert_float_equal(impostor.half[axis], 3.0f, 0.03f);
	assert_float_equal(impostor.material.specular[1], 0.04f, 1e-6f);
	for (uint32_t i = 0; i < desc.grid * desc.grid; i++)
		check_sphere_picture(&impostor, maps, i % desc.grid, i / desc.grid);
	free(maps);
	stilb_scene_impostor_finish(&impostor);
	stilb_scene_mesh_finish(&mesh);
}

/* ---- an asymmetrical model against rays -------------------------------------------------------------------------- */

#define BLOCKS 4
#define RAYS 25 /* through a texel, the first through its middle */

/* Tetrahedra of different colours, sizes and places: no rotation or mirroring takes the model to itself. */
typedef struct four_blocks {
	stilb_scene_vertex vertices[12];
	uint32_t indices[12];
	stilb_scene_mesh mesh;
	stilb_scene_material materials[BLOCKS];
	stilb_mat4 transforms[BLOCKS];
	stilb_geometry_impostor_part parts[BLOCKS];
} four_blocks;

static void blocks_make(four_blocks *blocks)
{
	static const float corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	static const uint32_t face[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
	static const float color[BLOCKS][3] = {{0.9f, 0.1f, 0.1f}, {0.1f, 0.9f, 0.1f}, {0.1f, 0.1f, 0.9f}, {0.8f, 0.8f, 0}};
	static const float place[BLOCKS][4] = {{2, 0, 0, 0}, {1, 3, 0, 0}, {1.5f, 0, 3, 0.5f}, {1, -1, 0.5f, 3.5f}};
	for (uint32_t f = 0; f < 4; f++)
		for (uint32_t c = 0; c < 3; c++) {
			stilb_scene_vertex *v = &blocks->vertices[3 * f + c];
			*v = (stilb_scene_vertex){.normal = {0, 0, 0}};
			memcpy(v->position, corner[face[f][c]], sizeof v->position);
			blocks->indices[3 * f + c] = 3 * f + c;
		}
	blocks->mesh = (stilb_scene_mesh){
		.vertices = blocks->vertices, .indices = blocks->indices, .vertex_count = 12, .index_count = 12};
	for (uint32_t b = 0; b < BLOCKS; b++) {
		blocks->materials[b] = paint(color[b][0], color[b][1], color[b][2], 0.1f * (float)(b + 1));
		blocks->transforms[b] = stilb_mat4_scale_translate(place[b][0], place[b][1], place[b][2], place[b][3]);
		blocks->parts[b] = (stilb_geometry_impostor_part){
			.mesh = &blocks->mesh, .material = &blocks->materials[b], .transform = &blocks->transforms[b]};
	}
	blocks->transforms[1].m[4] = 0.7f; /* it leans */
	blocks->transforms[3].m[9] = -0.4f;
}

/* The first triangle that a ray from outside meets: its block, or -1. *height: along -direction from the plane through
 * origin. Moeller and Trumbore, in double. */
static int ray_first(const four_blocks *blocks, const double origin[3], const double direction[3], double *height,
                     double normal[3])
{
	int found = -1;
	*height = -1e30;
	for (int b = 0; b < BLOCKS; b++)
		for (int t = 0; t < 4; t++) {
			double p[3][3], e1[3], e2[3], s[3], h[3], q[3];
			for (int c = 0; c < 3; c++)
				for (int i = 0; i < 3; i++) {
					const float *m = blocks->transforms[b].m, *from = blocks->vertices[3 * t + c].position;
					p[c][i] = (double)m[i] * (double)from[0] + (double)m[4 + i] * (double)from[1] +
					          (double)m[8 + i] * (double)from[2] + (double)m[12 + i];
				}
			for (int i = 0; i < 3; i++) {
				e1[i] = p[1][i] - p[0][i];
				e2[i] = p[2][i] - p[0][i];
				s[i] = origin[i] - p[0][i];
			}
#define CROSS(out, a, b)                                                                                               \
	(out)[0] = (a)[1] * (b)[2] - (a)[2] * (b)[1], (out)[1] = (a)[2] * (b)[0] - (a)[0] * (b)[2],                        \
	(out)[2] = (a)[0] * (b)[1] - (a)[1] * (b)[0]
#define DOT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])
			CROSS(h, direction, e2);
			double det = DOT(e1, h);
			if (det < 1e-12) /* from behind, or along it */
				continue;
			CROSS(q, s, e1);
			double u = DOT(s, h) / det, v = DOT(direction, q) / det, at = -DOT(e2, q) / det;
			if (u < 0 || v < 0 || u + v > 1 || at <= *height)
				continue;
			*height = at;
			found = b;
			CROSS(normal, e1, e2);
		}
	return found;
}

/* How many texels were compared; those whose own and neighbouring rays do not meet the same block are left out. */
static uint32_t check_rays(const four_blocks *blocks, const stilb_scene_impostor *impostor, const float *maps,
                           uint32_t gx, uint32_t gy)
{
	shade_frame frame = frame_of(gx, gy, impostor->grid);
	double direction[3] = {-(double)frame.n[0], -(double)frame.n[1], -(double)frame.n[2]};
	uint32_t compared = 0;
	for (uint32_t i = 0; i < impostor->side * impostor->side; i++) {
		uint32_t x = i % impostor->side, y = i / impostor->side;
		int block[RAYS];
		double height[RAYS], normal[RAYS][3];
		for (int tap = 0; tap < RAYS; tap++) {
			float across = 0.25f * (float)((tap + RAYS / 2) % 5 - 2),
				  down = 0.25f * (float)((tap + RAYS / 2) % RAYS / 5 - 2);
			stilb_vec2 at = shade_impostor_plate((stilb_vec2){(float)x + 0.5f + across, (float)y + 0.5f + down},
			                                     (float)impostor->side);
			double origin[3];
			for (int a = 0; a < 3; a++)
				origin[a] = (double)impostor->center[a] +
				            (double)impostor->radius *
				                ((double)at[0] * (double)frame.t[a] + (double)at[1] * (double)frame.b[a]);
			block[tap] = ray_first(blocks, origin, direction, &height[tap], normal[tap]);
		}
		bool same = true;
		for (int tap = 1; tap < RAYS; tap++)
			same = same && block[tap] == block[0] &&
			       (block[0] < 0 || DOT(normal[tap], normal[0]) > 0.999 * DOT(normal[0], normal[0]));
		if (!same)
			continue;
		compared++;
		const float *upper = texel(impostor, maps, gx, gy, x, y, false),
					*lower = texel(impostor, maps, gx, gy, x, y, true);
		assert_float_equal(upper[3], block[0] >= 0 ? 1.0f : 0.0f, 0.07f); /* a tip between the rays */
		if (block[0] < 0)
			continue;
		for (int c = 0; c < 3; c++)
			assert_float_equal(upper[c], blocks->materials[block[0]].diffuse[c], 1e-3f);
		assert_float_equal(lower[2], (float)(height[0] / (double)impostor->radius), 2e-3f);
		assert_float_equal(lower[3], blocks->materials[block[0]].roughness, 1e-3f);
		stilb_vec3 n = shade_frame_to_world(frame, shade_direction_from_octahedral((stilb_vec2){lower[0], lower[1]}));
		double length = sqrt(DOT(normal[0], normal[0]));
		for (int c = 0; c < 3; c++)
			assert_float_equal(n[c], (float)(normal[0][c] / length), 4e-3f);
	}
	return compared;
}

static void test_blocks(void **state)
{
	(void)state;
	four_blocks blocks;
	blocks_make(&blocks);
	stilb_geometry_impostor_desc desc = {.grid = TEST_TSAN ? 3 : 7, .side = 32, .samples = 4};
	stilb_scene_impostor impostor;
	float *maps = bake(blocks.parts, BLOCKS, &desc, &impostor);
	uint32_t compared = 0;
	for (uint32_t i = 0; i < desc.grid * desc.grid; i++)
		compared += check_rays(&blocks, &impostor, maps, i % desc.grid, i / desc.grid);
	assert_true(compared > desc.grid * desc.grid * desc.side * desc.side / 2);
	free(maps);
	stilb_scene_impostor_finish(&impostor);
}

/* ---- textures and sides ------------------------------------------------------------------------------------------ */

/* The plane's square of four colours as its picture from above has them: u to the right as x, v with z. */
static void test_texture(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_plane(&mesh), STILB_OK);
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 256, 256, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *pixels = image.pixels;
	for (uint32_t y = 0; y < 256; y++)
		for (uint32_t x = 0; x < 256; x++) {
			float *p = pixels + 3 * (256 * y + x);
			p[0] = x < 128 ? 0.0f : 1.0f;
			p[1] = y < 128 ? 0.0f : 1.0f;
			p[2] = (float)((x + y) % 2); /* far finer than a texel of the picture: 0.5 */
		}
	stilb_scene_material material = paint(0.5f, 0.5f, 0.5f, 1.0f);
	stilb_geometry_impostor_part part = {.mesh = &mesh, .material = &material, .texture = &image};
	stilb_geometry_impostor_desc desc = {.grid = 9, .side = 32, .samples = 2, .both_sides = true};
	stilb_scene_impostor impostor;
	float *maps = bake(&part, 1, &desc, &impostor);
	uint32_t checked = 0;
	for (uint32_t g = 0; g < 81; g++) {
		shade_frame frame = frame_of(g % 9, g / 9, 9);
		for (uint32_t i = 0; i < 32 * 32 && fabsf(frame.n[1]) > 0.5f; i++) {
			stilb_vec2 at = shade_impostor_plate((stilb_vec2){(float)(i % 32) + 0.5f, (float)(i / 32) + 0.5f}, 32.0f);
			const float *upper = texel(&impostor, maps, g % 9, g / 9, i % 32, i / 32, false);
			const float *lower = texel(&impostor, maps, g % 9, g / 9, i % 32, i / 32, true);
			stilb_vec3 p = (frame.t * at[0] + frame.b * at[1] + frame.n * lower[2]) * impostor.radius;
			if (upper[3] < 1.0f || fabsf(fabsf(p[0]) - 0.55f) > 0.25f || fabsf(fabsf(p[2]) - 0.55f) > 0.25f)
				continue;
			checked++;
			assert_float_equal(p[1], 0.0f, 4e-3f);
			assert_float_equal(upper[0], p[0] < 0.0f ? 0.0f : 0.5f, 1e-3f);
			assert_float_equal(upper[1], p[2] < 0.0f ? 0.0f : 0.5f, 1e-3f);
			assert_float_equal(upper[2], 0.25f, 1e-3f);
			stilb_vec3 n =
				shade_frame_to_world(frame, shade_direction_from_octahedral((stilb_vec2){lower[0], lower[1]}));
			assert_float_equal(n[1], frame.n[1] > 0.0f ? 1.0f : -1.0f, 4e-3f); /* towards the viewer */
		}
	}
	assert_true(checked > 2000);
	free(maps);
	stilb_scene_impostor_finish(&impostor);
	/* One side alone: nothing is seen from below, and of what is not covered nothing is known. */
	desc.both_sides = false;
	maps = bake(&part, 1, &desc, &impostor);
	for (uint32_t g = 0; g < 81; g++) {
		float covered = 0.0f, all = 0.0f;
		for (uint32_t i = 0; i < 32 * 32; i++)
			for (uint32_t c = 0; c < 4; c++) {
				all += texel(&impostor, maps, g % 9, g / 9, i % 32, i / 32, false)[c];
				covered += c == 3 ? texel(&impostor, maps, g % 9, g / 9, i % 32, i / 32, false)[c] : 0.0f;
			}
		float facing = frame_of(g % 9, g / 9, 9).n[1];
		assert_true(facing > 0.1f ? covered > 10.0f : facing < -0.01f ? all == 0.0f : true);
	}
	free(maps);
	stilb_scene_impostor_finish(&impostor);
	stilb_image_finish(&image);
	stilb_scene_mesh_finish(&mesh);
}

/* Texels beside the model have its colour, not black: filtering at the border mixes nothing else in. */
static void test_spread(void **state)
{
	(void)state;
	four_blocks blocks;
	blocks_make(&blocks);
	stilb_geometry_impostor_desc desc = {.grid = 3, .side = 24, .samples = 3};
	stilb_scene_impostor impostor;
	float *maps = bake(blocks.parts, BLOCKS, &desc, &impostor);
	uint32_t bare = 0;
	for (uint32_t g = 0; g < 9; g++)
		for (uint32_t i = 0; i < 24 * 24; i++) {
			const float *upper = texel(&impostor, maps, g % 3, g / 3, i % 24, i / 24, false);
			uint32_t x = i % 24, y = i / 24;
			assert_true(x > 0 && y > 0 && x < 23 && y < 23 ? true : upper[3] == 0.0f); /* the margin */
			bare += upper[3] == 0.0f;
			assert_true(upper[0] + upper[1] + upper[2] > 1.0f);
		}
	assert_true(bare > 1000);
	free(maps);
	stilb_scene_impostor_finish(&impostor);
}

/* ---- workers, models, refusals ----------------------------------------------------------------------------------- */

static void test_same_bits(void **state)
{
	(void)state;
	four_blocks blocks;
	blocks_make(&blocks);
	stilb_geometry_impostor_desc desc = {.grid = 5, .side = 16, .samples = 2, .both_sides = true};
	stilb_scene_impostor first = {0};
	for (uint32_t workers = 0; workers < 5; workers++) {
		stilb_job_pool *pool = pool_of(workers);
		stilb_scene_impostor impostor;
		assert_int_equal(stilb_geometry_impostor_bake(blocks.parts, BLOCKS, &desc, pool, 0, &impostor), STILB_OK);
		stilb_job_pool_destroy(pool);
		if (workers == 0) {
			first = impostor;
			continue;
		}
		assert_memory_equal(impostor.maps.pixels, first.maps.pixels, stilb_image_size(&first.maps));
		assert_memory_equal(&impostor.material, &first.material, sizeof first.material);
		assert_memory_equal(impostor.center, first.center, sizeof first.center);
		stilb_scene_impostor_finish(&impostor);
	}
	stilb_scene_impostor_finish(&first);
}

/* A model's impostor lies in the space of its first part, wherever the model stands. */
static void test_model(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(50, 3, &scene), STILB_OK);
	stilb_job_pool *pool = pool_of(1);
	stilb_geometry_impostor_desc desc = {.grid = 3, .side = 16, .samples = 2};
	stilb_scene_impostor a, b;
	assert_int_equal(stilb_geometry_impostor_of_model(scene, 7, &desc, pool, 0, &a), STILB_OK);
	for (uint32_t p = scene->first_part[7]; p < scene->first_part[8]; p++)
		for (int i = 12; i < 15; i++)
			scene->part_transform[p].m[i] += 64.0f;
	assert_int_equal(stilb_geometry_impostor_of_model(scene, 7, &desc, pool, 0, &b), STILB_OK);
	float scale = scene->part_transform[scene->first_part[7]].m[0];
	assert_float_equal(a.radius * scale, scene->bounds.radius[7], 0.2f * scene->bounds.radius[7]);
	for (int axis = 0; axis < 3; axis++)
		assert_float_equal(a.center[axis], b.center[axis], 1e-3f);
	assert_float_equal(a.radius, b.radius, 1e-3f);
	stilb_scene_impostor_finish(&a);
	stilb_scene_impostor_finish(&b);
	float still[16];
	memcpy(still, scene->part_transform[scene->first_part[9]].m, sizeof still);
	memset(scene->part_transform[scene->first_part[9]].m, 0, 12 * sizeof(float));
	assert_int_equal(stilb_geometry_impostor_of_model(scene, 9, &desc, pool, 0, &a), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "no inverse"));
	assert_null(a.maps.pixels);
	stilb_job_pool_destroy(pool);
	stilb_scene_destroy(scene);
}

static void refuses(const stilb_geometry_impostor_part *parts, uint32_t count, stilb_geometry_impostor_desc desc,
                    const char *words)
{
	stilb_job_pool *pool = pool_of(0);
	stilb_scene_impostor impostor;
	memset(&impostor, 0xff, sizeof impostor);
	assert_int_equal(stilb_geometry_impostor_bake(parts, count, &desc, pool, 0, &impostor), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), words))
		print_message("'%s' does not say '%s'\n", stilb_error_message(), words);
	assert_non_null(strstr(stilb_error_message(), words));
	assert_null(impostor.maps.pixels);
	stilb_job_pool_destroy(pool);
}

static void test_refusals(void **state)
{
	(void)state;
	four_blocks blocks;
	stilb_geometry_impostor_desc good = {.grid = 3, .side = 8, .samples = 1}, desc;
#define REFUSES(words, change)                                                                                         \
	blocks_make(&blocks);                                                                                              \
	desc = good;                                                                                                       \
	change;                                                                                                            \
	refuses(blocks.parts, BLOCKS, desc, words)
	REFUSES("grid of 4 directions", desc.grid = 4);
	REFUSES("grid of 1 directions", desc.grid = 1);
	REFUSES("4 texels a side at least, not 3", desc.side = 3);
	REFUSES("wider than 4096 texels", desc.side = 2048);
	REFUSES("wider than 4096 texels", desc.grid = UINT32_MAX);
	REFUSES("0 x 0 points", desc.samples = 0);
	REFUSES("17 x 17 points", desc.samples = 17);
	REFUSES("more than 4096 a side", (desc.side = 1024, desc.samples = 5));
	REFUSES("the position of vertex 5 of part 0", blocks.vertices[5].position[1] = NAN);
	REFUSES("the normal of vertex 3 of part 0", blocks.vertices[3].normal[0] = INFINITY);
	REFUSES("the texture coordinate of vertex 11", blocks.vertices[11].uv[1] = -NAN);
	REFUSES("index 4 of part 0 of an impostor is vertex 12", blocks.indices[4] = 12);
	REFUSES("the transform of part 2", blocks.transforms[2].m[13] = NAN);
	REFUSES("the material of part 3 of an impostor is out of range", blocks.materials[3].diffuse[1] = 2.0f);
	REFUSES("the material of part 1 emits", blocks.materials[1].emission[2] = 1.0f);
	REFUSES("no triangles", blocks.mesh.index_count = 0);
	REFUSES("with an extent", memset(blocks.transforms, 0, sizeof blocks.transforms));
	REFUSES("has no pixels", blocks.parts[2].texture = &(stilb_image){0});
	REFUSES("with an extent", for (int b = 0; b < BLOCKS; b++) blocks.transforms[b].m[12] = 9e17f);
#undef REFUSES
}

/* Triangles without area show nothing and disturb nothing; one triangle alone is a model. */
static void test_degenerate(void **state)
{
	(void)state;
	four_blocks blocks;
	blocks_make(&blocks);
	stilb_geometry_impostor_desc desc = {.grid = 3, .side = 16, .samples = 2, .both_sides = true};
	stilb_scene_impostor plain, more;
	uint32_t indices[21];
	memcpy(indices, (uint32_t[]){0, 0, 0, 1, 1, 2, 3, 4, 3}, 9 * sizeof *indices);
	memcpy(indices + 9, blocks.indices, sizeof blocks.indices);
	float *a = bake(blocks.parts, BLOCKS, &desc, &plain);
	blocks.mesh.indices = indices;
	blocks.mesh.index_count = 21;
	float *b = bake(blocks.parts, BLOCKS, &desc, &more);
	assert_memory_equal(plain.maps.pixels, more.maps.pixels, stilb_image_size(&plain.maps));
	free(a);
	free(b);
	stilb_scene_impostor_finish(&more);
	blocks.mesh.indices = blocks.indices;
	blocks.mesh.index_count = 3;
	a = bake(blocks.parts, 1, &desc, &more);
	float covered = 0.0f;
	for (uint32_t i = 0; i < more.maps.width * more.maps.width; i++)
		covered += a[4 * i + 3];
	assert_true(covered > 30.0f);
	free(a);
	stilb_scene_impostor_finish(&plain);
	stilb_scene_impostor_finish(&more);
}

static void test_no_memory(void **state)
{
	(void)state;
	four_blocks blocks;
	blocks_make(&blocks);
	stilb_image image = {
		.width = 2, .height = 2, .channels = 1, .format = STILB_IMAGE_U8_SRGB, .pixels = (uint8_t[4]){0}};
	blocks.parts[1].texture = blocks.parts[2].texture = &image;
	stilb_geometry_impostor_desc desc = {.grid = 3, .side = 8, .samples = 1};
	stilb_job_pool *pool = pool_of(1);
	stilb_scene_impostor impostor;
	stilb_result result = STILB_ERROR_MEMORY;
	uint32_t allowed = 0;
	for (; result != STILB_OK && allowed < 100; allowed++) {
		allocations_left = allowed;
		result = stilb_geometry_impostor_bake(blocks.parts, BLOCKS, &desc, pool, 0, &impostor);
		allocations_left = UINT32_MAX;
		assert_true(result == STILB_OK || (result == STILB_ERROR_MEMORY && !impostor.maps.pixels));
	}
	assert_in_range(allowed, 10, 99);
	stilb_scene_impostor_finish(&impostor);
	stilb_job_pool_destroy(pool);
}

static void test_mistakes(void **state)
{
	(void)state;
	stilb_scene_impostor good = {.radius = 1.0f, .grid = 3, .side = 4}, bad;
	uint16_t pixels[12 * 24 * 4] = {0};
	good.maps = (stilb_image){12, 24, 4, STILB_IMAGE_F16_LINEAR, pixels, 0};
	assert_null(stilb_scene_impostor_mistake(&good));
#define MISTAKE(words, change)                                                                                         \
	bad = good;                                                                                                        \
	change;                                                                                                            \
	assert_non_null(stilb_scene_impostor_mistake(&bad));                                                               \
	assert_non_null(strstr(stilb_scene_impostor_mistake(&bad), words))
	MISTAKE("centre", bad.center[2] = NAN);
	MISTAKE("box", bad.half[1] = -1.0f);
	MISTAKE("box", bad.half[0] = NAN);
	MISTAKE("radius", bad.radius = 0.0f);
	MISTAKE("radius", bad.radius = INFINITY);
	MISTAKE("grid", bad.grid = 2);
	MISTAKE("grid", bad.grid = 1);
	MISTAKE("fewer than 4", bad.side = 3);
	MISTAKE("4096", bad.side = 2048);
	MISTAKE("16-bit", bad.maps.format = STILB_IMAGE_F32_LINEAR);
	MISTAKE("16-bit", bad.maps.channels = 3);
	MISTAKE("16-bit", bad.maps.pixels = NULL);
	MISTAKE("twice as high", bad.maps.height = 12);
#undef MISTAKE
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sphere),  cmocka_unit_test(test_blocks),    test_one_thread(test_texture),
		cmocka_unit_test(test_spread),  cmocka_unit_test(test_same_bits), cmocka_unit_test(test_model),
		test_one_thread(test_refusals), test_one_thread(test_degenerate), test_one_thread(test_no_memory),
		test_one_thread(test_mistakes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
