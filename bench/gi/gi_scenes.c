/* The scenes of the rows of the suite `gi`, which are small and each hard in its own way. Numbers are metres and
 * radiance. */
#include "bench/gi/gi_run.h"

#include "scene/scene_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float black[3] = {0};
static const float white[3] = {0.7f, 0.7f, 0.7f}, red[3] = {0.6f, 0.2f, 0.15f}, green[3] = {0.2f, 0.5f, 0.25f};

/* Quads of one material. */
typedef struct quads {
	stilb_scene_vertex *vertices;
	uint32_t *indices;
	uint32_t count, room;
} quads;

static quads quads_make(uint32_t room)
{
	quads q = {.room = room};
	q.vertices = stilb_memory_alloc(4 * (size_t)room, sizeof *q.vertices);
	q.indices = stilb_memory_alloc(6 * (size_t)room, sizeof *q.indices);
	if (!q.vertices || !q.indices)
		bench_child_fail("no memory for a scene");
	return q;
}

/* Its front is where x cross y points. */
static void quads_add(quads *q, stilb_vec3 corner, stilb_vec3 x, stilb_vec3 y)
{
	static const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
	STILB_ASSERT(q->count < q->room);
	stilb_vec3 n = stilb_vec3_normalize(stilb_vec3_cross(x, y));
	for (uint32_t k = 0; k < 4; k++) {
		float u = k == 1 || k == 2 ? 1.0f : 0.0f, v = k >= 2 ? 1.0f : 0.0f;
		stilb_vec3 p = corner + x * u + y * v;
		q->vertices[4 * q->count + k] =
			(stilb_scene_vertex){.position = {p[0], p[1], p[2]}, .normal = {n[0], n[1], n[2]}, .uv = {u, v}};
	}
	for (uint32_t i = 0; i < 6; i++)
		q->indices[6 * q->count + i] = 4 * q->count + quad[i];
	q->count++;
}

/* A box, seen from outside, turned about +Y. */
static void quads_add_box(quads *q, stilb_vec3 center, stilb_vec3 half, float turn)
{
	stilb_vec3 x = {half[0] * cosf(turn), 0.0f, -half[0] * sinf(turn)}, y = {0.0f, half[1], 0.0f};
	stilb_vec3 z = {half[2] * sinf(turn), 0.0f, half[2] * cosf(turn)};
	quads_add(q, center - x - y + z, x * 2.0f, y * 2.0f);
	quads_add(q, center + x - y - z, x * -2.0f, y * 2.0f);
	quads_add(q, center + x - y + z, z * -2.0f, y * 2.0f);
	quads_add(q, center - x - y - z, z * 2.0f, y * 2.0f);
	quads_add(q, center - x + y + z, x * 2.0f, z * -2.0f);
	quads_add(q, center - x - y - z, x * 2.0f, z * 2.0f);
}

static void place(stilb_scene_build *build, uint32_t mesh, uint32_t material, stilb_mat4 to_world)
{
	stilb_scene_build_part part = {mesh, material};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &to_world), &part, 1);
}

/* Adds the quads, and frees them. */
static void quads_end(quads *q, stilb_scene_build *build, const stilb_scene_material *material)
{
	stilb_scene_mesh mesh = {
		.vertices = q->vertices, .indices = q->indices, .vertex_count = 4 * q->count, .index_count = 6 * q->count};
	place(build, stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, material),
	      stilb_mat4_identity());
	free(q->vertices);
	free(q->indices);
	*q = (quads){0};
}

static void box(stilb_scene_build *build, const float color[3], stilb_vec3 center, stilb_vec3 half, float turn)
{
	quads q = quads_make(6);
	quads_add_box(&q, center, half, turn);
	stilb_scene_material material = stilb_scene_material_make(color, black, 1.0f);
	quads_end(&q, build, &material);
}

static void quad(stilb_scene_build *build, const float color[3], stilb_vec3 corner, stilb_vec3 x, stilb_vec3 y)
{
	quads q = quads_make(1);
	quads_add(&q, corner, x, y);
	stilb_scene_material material = stilb_scene_material_make(color, black, 1.0f);
	quads_end(&q, build, &material);
}

static void lamp(stilb_scene_build *build, float radiance, stilb_vec3 corner, stilb_vec3 x, stilb_vec3 y)
{
	quads q = quads_make(1);
	quads_add(&q, corner, x, y);
	stilb_scene_material material = stilb_scene_material_make(black, black, 1.0f);
	for (int i = 0; i < 3; i++)
		material.emission[i] = radiance;
	quads_end(&q, build, &material);
}

static void ball(stilb_scene_build *build, const stilb_scene_material *material, stilb_vec3 center, float radius)
{
	stilb_scene_mesh mesh;
	gi_run_check(stilb_scene_mesh_sphere(5, &mesh), "a ball");
	place(build, stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, material),
	      stilb_mat4_scale_translate(radius, center[0], center[1], center[2]));
	stilb_scene_mesh_finish(&mesh);
}

static void look(stilb_scene_build *build, stilb_vec3 from, stilb_vec3 to, float fov_y)
{
	stilb_vec3 d = stilb_vec3_normalize(to - from);
	stilb_scene_build_camera(build, &(stilb_scene_camera){.position = {from[0], from[1], from[2]},
	                                                      .yaw = atan2f(-d[0], -d[2]),
	                                                      .pitch = asinf(d[1]),
	                                                      .fov_y = fov_y,
	                                                      .near_z = 0.01f,
	                                                      .far_z = 1000.0f,
	                                                      .tone = 0});
}

static void sky(stilb_scene_build *build, float r, float g, float b)
{
	stilb_scene_build_surroundings(build,
	                               &(stilb_scene_surroundings){.sky = {r, g, b}, .ground = {r, g, b}, .name = "sky"});
}

static stilb_vec3 vec(float x, float y, float z)
{
	return stilb_vec3_make(x, y, z);
}

static float range(uint64_t seed, uint32_t *index, float low, float high)
{
	return low + (high - low) * stilb_random_float(seed, (*index)++);
}

/* ---- the scenes -------------------------------------------------------------------------------------------------- */

/* Balls and a box in a dim room that is a map, with a window 300 times as bright. */
static void panorama(stilb_scene_build *build)
{
	stilb_image map;
	gi_run_check(stilb_image_create(&map, 128, 64, 3, STILB_IMAGE_F32_LINEAR), "a map");
	float *texel = map.pixels;
	for (uint32_t y = 0; y < 64; y++)
		for (uint32_t x = 0; x < 128; x++, texel += 3) {
			bool window = x >= 20 && x < 28 && y >= 14 && y < 24 && x != 24 && y != 19;
			texel[0] = window ? 30.0f : y < 32 ? 0.10f : 0.05f;
			texel[1] = window ? 36.0f : y < 32 ? 0.10f : 0.04f;
			texel[2] = window ? 45.0f : y < 32 ? 0.12f : 0.03f;
		}
	stilb_scene_build_surroundings(build, &(stilb_scene_surroundings){.panorama = map, .name = "room"});
	stilb_image_finish(&map);
	quad(build, white, vec(-6, 0, 6), vec(12, 0, 0), vec(0, 0, -12));
	const float *colors[] = {white, red, green};
	for (uint32_t i = 0; i < 6; i++) {
		stilb_scene_material material = stilb_scene_material_make(colors[i % 3], black, 1.0f);
		ball(build, &material, vec(-2.4f + 1.6f * (float)(i % 4), 0.7f, i < 4 ? -1.0f : 1.2f), 0.7f);
	}
	box(build, white, vec(2.2f, 1.0f, 1.4f), vec(0.5f, 1.0f, 0.5f), 0.5f);
	look(build, vec(0.5f, 3.0f, 6.5f), vec(0, 0.5f, 0), 0.8f);
}

/* The same with a sun, a lamp and a point: something of every group of lights. */
static void mixed(stilb_scene_build *build)
{
	panorama(build);
	stilb_vec3 down = stilb_vec3_normalize(vec(-0.6f, -1.0f, 0.3f));
	stilb_scene_build_light(build, &(stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
	                                                    .direction = {down[0], down[1], down[2]},
	                                                    .intensity = {1.0f, 0.9f, 0.8f}});
	stilb_scene_build_light(build, &(stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
	                                                    .position = {-1.0f, 2.0f, 2.5f},
	                                                    .intensity = {1.0f, 0.8f, 0.5f}});
	lamp(build, 10.0f, vec(2, 3, -2), vec(0.7f, 0, 0), vec(0, 0, 0.7f));
}

/* Two rooms, 4 x 3 x 4 m each; the lamp is in the one behind the door. */
static void door(stilb_scene_build *build)
{
	quads q = quads_make(17);
	quads_add(&q, vec(-2, 0, 4), vec(4, 0, 0), vec(0, 0, -8));
	quads_add(&q, vec(-2, 3, -4), vec(4, 0, 0), vec(0, 0, 8));
	quads_add(&q, vec(-2, 0, 4), vec(0, 0, -8), vec(0, 3, 0));
	quads_add(&q, vec(-2, 0, -4), vec(4, 0, 0), vec(0, 3, 0));
	quads_add(&q, vec(2, 0, 4), vec(-4, 0, 0), vec(0, 3, 0));
	quads_add_box(&q, vec(-0.9f, 1.5f, 0), vec(1.1f, 1.5f, 0.05f), 0);
	quads_add_box(&q, vec(1.7f, 1.5f, 0), vec(0.3f, 1.5f, 0.05f), 0);
	stilb_scene_material material = stilb_scene_material_make(white, black, 1.0f);
	quads_end(&q, build, &material);
	quads r = quads_make(1);
	quads_add(&r, vec(2, 0, -4), vec(0, 0, 8), vec(0, 3, 0));
	quads_end(&r, build, &(stilb_scene_material){.diffuse = {0.6f, 0.2f, 0.15f}, .roughness = 1.0f});
	box(build, green, vec(-0.6f, 0.5f, 1.8f), vec(0.5f, 0.5f, 0.5f), 0.4f);
	lamp(build, 60.0f, vec(-1.2f, 2.99f, -2.6f), vec(0.6f, 0, 0), vec(0, 0, 0.6f));
	look(build, vec(-1.6f, 1.7f, 3.7f), vec(0.4f, 1.1f, 0.5f), 1.1f);
}

/* Balls from smooth to rough before a wall, under a small lamp, a large one and a dim sky. */
static void metals(stilb_scene_build *build)
{
	static const float gold[3] = {0.95f, 0.7f, 0.35f}, steel[3] = {0.6f, 0.6f, 0.62f}, shine[3] = {0.04f, 0.04f, 0.04f};
	quad(build, white, vec(-8, 0, 8), vec(16, 0, 0), vec(0, 0, -16));
	quad(build, green, vec(-8, 0, -3), vec(16, 0, 0), vec(0, 5, 0));
	for (uint32_t i = 0; i < 8; i++) {
		float roughness = 0.25f + 0.2f * (float)(i % 4);
		stilb_scene_material material = stilb_scene_material_make(black, i < 4 ? gold : steel, roughness);
		ball(build, &material, vec(-2.4f + 1.6f * (float)(i % 4), 0.7f, i < 4 ? -1.0f : 0.9f), 0.7f);
	}
	stilb_scene_material plastic = stilb_scene_material_make(red, shine, 0.3f);
	ball(build, &plastic, vec(0, 0.4f, 2.2f), 0.4f);
	lamp(build, 25.0f, vec(-3, 6, 1), vec(0.8f, 0, 0), vec(0, 0, 0.8f));
	lamp(build, 3.0f, vec(1, 5, -1), vec(4, 0, 0), vec(0, 1, 3));
	sky(build, 0.2f, 0.25f, 0.3f);
	look(build, vec(0, 3.0f, 7.5f), vec(0, 0.6f, 0), 0.75f);
}

#define MANY 1000u

/* 1,000 triangles that shine and 1,000 points in a room with pillars. Colours and sizes are random. */
static void lights(stilb_scene_build *build)
{
	uint32_t n = 0;
	quad(build, white, vec(-5, 0, 5), vec(10, 0, 0), vec(0, 0, -10));
	quad(build, white, vec(-5, 0, -5), vec(10, 0, 0), vec(0, 4, 0));
	quad(build, red, vec(-5, 0, 5), vec(0, 0, -10), vec(0, 4, 0));
	quad(build, green, vec(5, 0, -5), vec(0, 0, 10), vec(0, 4, 0));
	for (uint32_t i = 0; i < 9; i++)
		box(build, white, vec(-3.0f + 3.0f * (float)(i % 3), 0.8f, -3.0f + 3.0f * (float)(i / 3)),
		    vec(0.3f, 0.8f, 0.3f), 0.3f * (float)i);
	for (uint32_t i = 0; i < MANY; i++) {
		static const uint32_t indices[3] = {0, 1, 2};
		stilb_vec3 p = vec(range(1, &n, -4.9f, 4.9f), range(1, &n, 3.4f, 3.9f), range(1, &n, -4.9f, 4.9f));
		float size = range(1, &n, 0.02f, 0.08f), turn = range(1, &n, 0.0f, 6.28f), tilt = range(1, &n, -0.5f, 0.5f);
		stilb_vec3 x = vec(size * cosf(turn), size * tilt, size * sinf(turn));
		stilb_vec3 y = vec(-size * sinf(turn), 0, size * cosf(turn));
		stilb_vec3 normal = stilb_vec3_normalize(stilb_vec3_cross(x, y)), corners[3] = {p, p + x, p + y};
		stilb_scene_vertex vertices[3];
		for (int k = 0; k < 3; k++)
			vertices[k] = (stilb_scene_vertex){.position = {corners[k][0], corners[k][1], corners[k][2]},
			                                   .normal = {normal[0], normal[1], normal[2]}};
		stilb_scene_mesh mesh = {
			.vertices = vertices, .vertex_count = 3, .indices = (uint32_t *)indices, .index_count = 3};
		stilb_scene_material material = stilb_scene_material_make(black, black, 1.0f);
		float radiance = expf(range(1, &n, 0.0f, 4.0f));
		for (int k = 0; k < 3; k++)
			material.emission[k] = radiance * range(1, &n, 0.3f, 1.0f);
		place(build, stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &material),
		      stilb_mat4_identity());
	}
	for (uint32_t i = 0; i < MANY; i++) {
		float power = 0.01f * expf(range(1, &n, -2.0f, 2.0f));
		stilb_scene_light point = {.kind = STILB_SCENE_LIGHT_POINT};
		point.position[0] = range(1, &n, -4.6f, 4.6f);
		point.position[1] = range(1, &n, 2.0f, 3.3f);
		point.position[2] = range(1, &n, -4.6f, 4.6f);
		for (int k = 0; k < 3; k++)
			point.intensity[k] = power * range(1, &n, 0.3f, 1.0f);
		stilb_scene_build_light(build, &point);
	}
	look(build, vec(0, 2.8f, 6.0f), vec(0, 0.5f, -0.5f), 0.8f);
}

#define LEAVES 3000u

/* Leaves with a texture that is half holes, around a trunk, in the sun. */
static void foliage(stilb_scene_build *build)
{
	stilb_image leaf;
	uint32_t n = 0;
	gi_run_check(stilb_image_create(&leaf, 64, 64, 4, STILB_IMAGE_U8_LINEAR), "a texture");
	uint8_t *texel = leaf.pixels;
	for (int y = 0; y < 64; y++)
		for (int x = 0; x < 64; x++, texel += 4) {
			float v = ((float)y + 0.5f) / 64.0f, half = 0.42f * sinf(3.14159265f * v), u = ((float)x + 0.5f) / 64.0f;
			bool vein = abs(x - 32) < 2 || (y + abs(x - 32)) % 12 < 2;
			texel[0] = vein ? 120 : 50;
			texel[1] = vein ? 150 : 110;
			texel[2] = vein ? 60 : 25;
			texel[3] = fabsf(u - 0.5f) < half && !((x / 6 + y / 9) % 5 == 0) ? 255 : 0;
		}
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1 + stilb_scene_build_texture(build, &leaf);
	surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
	surface.alpha = STILB_SCENE_MASK;
	surface.cutoff = 0.5f;
	surface.specular_weight = 0.0f;
	stilb_image_finish(&leaf);
	stilb_scene_material material = stilb_scene_material_make(green, black, 1.0f);
	material.surface = 1 + stilb_scene_build_surface(build, &surface);
	quads q = quads_make(LEAVES);
	for (uint32_t i = 0; i < LEAVES; i++) {
		float turn = range(2, &n, 0, 6.2832f), up = range(2, &n, -1, 1), r = cbrtf(range(2, &n, 0.1f, 1)) * 1.6f;
		float flat = r * sqrtf(1.0f - up * up), a = range(2, &n, 0, 6.2832f), tilt = range(2, &n, -1, 1);
		stilb_vec3 x = vec(0.14f * cosf(a), 0.0f, 0.14f * sinf(a));
		stilb_vec3 y = vec(-0.3f * sinf(a) * cosf(tilt), 0.3f * sinf(tilt), 0.3f * cosf(a) * cosf(tilt));
		quads_add(&q, vec(flat * cosf(turn), 2.4f + r * up, flat * sinf(turn)), x, y);
	}
	quads_end(&q, build, &material);
	box(build, red, vec(0, 0.8f, 0), vec(0.12f, 0.8f, 0.12f), 0.2f);
	quad(build, white, vec(-8, 0, 8), vec(16, 0, 0), vec(0, 0, -16));
	sky(build, 0.3f, 0.4f, 0.6f);
	stilb_vec3 down = stilb_vec3_normalize(vec(0.5f, -1.0f, -0.4f));
	stilb_scene_build_light(build, &(stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
	                                                    .direction = {down[0], down[1], down[2]},
	                                                    .intensity = {4.0f, 3.8f, 3.4f}});
	look(build, vec(0.5f, 2.2f, 6.0f), vec(0, 1.6f, 0), 0.8f);
}

stilb_scene *gi_run_row_scene(const char *name)
{
	static const struct {
		const char *name;
		void (*make)(stilb_scene_build *build);
	} own[] = {{"panorama", panorama}, {"mixed", mixed},   {"door", door},
	           {"metals", metals},     {"lights", lights}, {"foliage", foliage}};
	stilb_scene *scene = strcmp(name, "million") == 0 ? gi_run_million() : NULL;
	for (size_t i = 0; i < sizeof own / sizeof *own; i++)
		if (strcmp(name, own[i].name) == 0) {
			stilb_scene_build *build = stilb_scene_build_begin();
			own[i].make(build);
			gi_run_check(stilb_scene_build_end(build, &scene), name);
		}
	if (!scene)
		gi_run_check(stilb_scene_open(strcmp(name, "open-sky") == 0 ? "outdoor" : name, &scene), name);
	return scene;
}
