/* Shadows of a board above a floor against geometry: where the light must arrive and where it must not, but within what
 * a map's texels and its filter may blur; edges as wide as a lamp's size makes them; all ways of lighting alike. Under
 * the validation layer. */
#include "engine.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WIDTH 160
#define HEIGHT 100
#define BOARD_HEIGHT 1.5
#define BOARD_HALF 0.8
#define FLOOR_HALF 6.0

typedef struct stage {
	stilb_engine *engine;
	stilb_scene *scene;
} stage;

static stilb_scene *board_scene(const stilb_scene_light *lights, uint32_t count)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0.0f, 0.0f, 0.0f};
	stilb_scene *scene;
	stilb_scene_mesh plane = {0};
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	float half = 0.0f;
	for (uint32_t v = 0; v < plane.vertex_count; v++)
		half = fmaxf(half, fabsf(plane.vertices[v].position[0]));
	stilb_mat4 wide = stilb_mat4_scale_translate((float)FLOOR_HALF / half, 0.0f, 0.0f, 0.0f);
	stilb_mat4 above = stilb_mat4_scale_translate((float)BOARD_HALF / half, 0.0f, (float)BOARD_HEIGHT, 0.0f);
	stilb_scene_material stone = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, &plane)};
	part.material = stilb_scene_build_material(build, &stone);
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &wide), &part, 1);
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &above), &part, 1);
	for (uint32_t l = 0; l < count; l++)
		stilb_scene_build_light(build, &lights[l]);
	stilb_scene_surroundings dark = {0};
	stilb_scene_build_surroundings(build, &dark);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_scene_mesh_finish(&plane);
	scene->camera = (stilb_scene_camera){
		.position = {0.5f, 5.0f, 7.0f}, .pitch = -0.62f, .fov_y = 0.9f, .near_z = 0.1f, .far_z = 100.0f};
	return scene;
}

static stilb_render_gbuffer stage_gbuffer = STILB_RENDER_GBUFFER_WIDE; /* of stages that are opened */

static stage stage_open(const stilb_scene_light *lights, uint32_t count, stilb_engine_shadows shadows,
                        stilb_render_lighting way)
{
	stage s = {.scene = board_scene(lights, count)};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.lighting = way;
	desc.deferred.gbuffer = stage_gbuffer;
	desc.shadows = shadows;
	desc.validate = true;
	if (stilb_engine_create(&desc, &s.engine) != STILB_OK || stilb_engine_set_scene(s.engine, s.scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return s;
}

static void stage_close(stage *s)
{
	double ms;
	assert_int_equal(stilb_engine_wait(s->engine, &ms), STILB_OK);
	assert_int_equal(stilb_engine_validation_messages(s->engine), 0);
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
}

/* The red radiance of a frame's pixels. */
static stilb_engine_report radiance(const stage *s, float out[HEIGHT * WIDTH])
{
	stilb_engine_report report;
	stilb_image image;
	if (stilb_engine_frame(s->engine, &report) != STILB_OK ||
	    stilb_engine_screenshot(s->engine, "shadows.exr") != STILB_OK ||
	    stilb_image_load("shadows.exr", &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const float *pixels = image.pixels;
	for (int i = 0; i < HEIGHT * WIDTH; i++)
		out[i] = pixels[i * (int)image.channels];
	stilb_image_finish(&image);
	assert_int_equal(remove("shadows.exr"), 0);
	return report;
}

/* Where the pixel's middle sees the floor. False: it does not. */
static bool floor_of(const stilb_scene *scene, int x, int y, double p[3])
{
	stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, WIDTH, HEIGHT, x + 0.5, y + 0.5);
	double origin[3], d[3];
	memcpy(origin, ray.origin, sizeof origin);
	memcpy(d, ray.direction, sizeof d);
	if (d[1] >= 0.0)
		return false;
	double board = (BOARD_HEIGHT - origin[1]) / d[1];
	bool hidden =
		fabs(origin[0] + board * d[0]) < BOARD_HALF + 0.1 && fabs(origin[2] + board * d[2]) < BOARD_HALF + 0.1;
	double t = -origin[1] / d[1];
	for (int i = 0; i < 3; i++)
		p[i] = origin[i] + t * d[i];
	return !hidden && fabs(p[0]) < FLOOR_HALF - 0.1 && fabs(p[2]) < FLOOR_HALF - 0.1;
}

/* How far the floor's point lies within the shadow that a point of a light casts, metres on the floor; negative:
 * outside. */
static double within(const stilb_scene_light *light, const double from[3], const double p[3])
{
	double d[3];
	for (int i = 0; i < 3; i++)
		d[i] = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL ? -(double)light->direction[i] : from[i] - p[i];
	double t = BOARD_HEIGHT / d[1], stretch = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL ? 1.0 : 1.0 / (1.0 - t);
	return stretch * (BOARD_HALF - fmax(fabs(p[0] + t * d[0]), fabs(p[2] + t * d[2])));
}

/* Lights high enough above the board. */
static stilb_scene_light light_of(stilb_scene_light_kind kind, double radius)
{
	stilb_scene_light light = {.kind = kind,
	                           .position = {0.7f, 4.0f, -0.4f},
	                           .direction = {-0.15f, -0.95f, 0.1f},
	                           .intensity = {30.0f, 30.0f, 30.0f},
	                           .cos_inner = 0.8f,
	                           .cos_outer = 0.6f,
	                           .radius = (float)radius};
	float length = sqrtf(light.direction[0] * light.direction[0] + light.direction[1] * light.direction[1] +
	                     light.direction[2] * light.direction[2]);
	for (int i = 0; i < 3; i++)
		light.direction[i] /= length;
	if (kind == STILB_SCENE_LIGHT_DIRECTIONAL) {
		light.direction[0] = 0.48f, light.direction[1] = -0.8f, light.direction[2] = 0.36f;
		light.intensity[0] = light.intensity[1] = light.intensity[2] = 3.0f;
	}
	assert_null(stilb_scene_light_mistake(&light));
	return light;
}

static const stilb_engine_shadows map = {.kind = STILB_ENGINE_SHADOWS_MAP}, off = {0};

/* Pixels of the floor are lit or not as geometry has it. The camera goes on by a part of a texel each time. */
static void light_arrives_where_it_must(void **state)
{
	(void)state;
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_SPOT,
	                                               STILB_SCENE_LIGHT_POINT};
	static float with[HEIGHT * WIDTH], without[HEIGHT * WIDTH];
	for (int k = 0; k < 3; k++) {
		stilb_scene_light light = light_of(kinds[k], 0.0);
		const double from[3] = {(double)light.position[0], (double)light.position[1], (double)light.position[2]};
		stage shadowed = stage_open(&light, 1, map, STILB_RENDER_LIGHTING_AUTO);
		stage free = stage_open(&light, 1, off, STILB_RENDER_LIGHTING_AUTO);
		uint32_t dark = 0, lit = 0;
		for (int step = 0; step < 7; step++) {
			shadowed.scene->camera.position[0] = free.scene->camera.position[0] = 0.5f + 0.0131f * (float)step;
			radiance(&shadowed, with);
			radiance(&free, without);
			for (int i = 0; i < HEIGHT * WIDTH; i++) {
				double p[3];
				if (!floor_of(shadowed.scene, i % WIDTH, i / WIDTH, p) || !(without[i] > 1e-3f))
					continue;
				/* A texel, two of the filter, and one more as they lie at a slant: of a sun's 1,024 texels over 19 m;
				 * and 256 and 128 over the 10.6 and 8 m that a spot and a cube's side see of the floor. */
				double deep = within(&light, from, p), blurred = k == 0 ? 0.075 : k == 1 ? 0.2 : 0.3;
				float share = with[i] / without[i];
				if (fabs(deep) < blurred)
					continue;
				dark += deep > 0.0;
				lit += deep < 0.0;
				if (fabsf(share - (deep > 0.0 ? 0.0f : 1.0f)) > 1e-3f)
					fail_msg("kind %d, step %d, pixel %d, %d: %f of the light arrives, %f m within the shadow", k, step,
					         i % WIDTH, i / WIDTH, (double)share, deep);
			}
		}
		assert_true(dark > 500 && lit > 10000);
		stage_close(&shadowed);
		stage_close(&free);
	}
}

/* The share of a sphere that the board leaves, by 400 points of its disc. */
static double share_of_sphere(const stilb_scene_light *light, const double p[3])
{
	double ahead[3], right[3], up[3], length = 0.0, seen = 0.0;
	for (int i = 0; i < 3; i++) {
		ahead[i] = (double)light->position[i] - p[i];
		length += ahead[i] * ahead[i];
	}
	for (int i = 0; i < 3; i++)
		ahead[i] /= sqrt(length);
	double flat = hypot(ahead[0], ahead[1]);
	right[0] = ahead[1] / flat, right[1] = -ahead[0] / flat, right[2] = 0.0;
	for (int i = 0; i < 3; i++)
		up[i] = ahead[(i + 1) % 3] * right[(i + 2) % 3] - ahead[(i + 2) % 3] * right[(i + 1) % 3];
	for (int s = 0; s < 400; s++) {
		double r = (double)light->radius * sqrt((s + 0.5) / 400.0), angle = 2.39996323 * s, from[3];
		for (int i = 0; i < 3; i++)
			from[i] = (double)light->position[i] + r * (cos(angle) * right[i] + sin(angle) * up[i]);
		seen += within(light, from, p) < 0.0;
	}
	return seen / 400.0;
}

/* A lamp's size widens its shadow's edge: the picture is off by less than half of what an edge without width is. */
static void lamps_have_soft_edges(void **state)
{
	(void)state;
	static float with[HEIGHT * WIDTH], without[HEIGHT * WIDTH];
	stilb_scene_light light = light_of(STILB_SCENE_LIGHT_SPHERE, 0.4);
	const double from[3] = {(double)light.position[0], (double)light.position[1], (double)light.position[2]};
	stage shadowed = stage_open(&light, 1, map, STILB_RENDER_LIGHTING_AUTO);
	stage free = stage_open(&light, 1, off, STILB_RENDER_LIGHTING_AUTO);
	radiance(&shadowed, with);
	radiance(&free, without);
	double soft = 0.0, hard = 0.0;
	uint32_t between = 0;
	for (int i = 0; i < HEIGHT * WIDTH; i++) {
		double p[3];
		if (!floor_of(shadowed.scene, i % WIDTH, i / WIDTH, p) || !(without[i] > 1e-3f))
			continue;
		double share = (double)(with[i] / without[i]), want = share_of_sphere(&light, p);
		double edge = within(&light, from, p) > 0.0 ? 0.0 : 1.0;
		between += want > 0.1 && want < 0.9;
		soft += (share - want) * (share - want);
		hard += (edge - want) * (edge - want);
	}
	assert_true(between > 200);
	if (!(sqrt(soft) < 0.5 * sqrt(hard)))
		fail_msg("off by %f, without widths by %f", sqrt(soft), sqrt(hard));
	stage_close(&shadowed);
	stage_close(&free);
}

/* Every way of lighting reads the same maps. Highlights, which PREPASS and PRELIGHT have of their own, are black. */
static void ways_show_the_same(void **state)
{
	(void)state;
	static float want[HEIGHT * WIDTH], got[HEIGHT * WIDTH];
	stilb_scene_light lights[3] = {light_of(STILB_SCENE_LIGHT_DIRECTIONAL, 0.0), light_of(STILB_SCENE_LIGHT_SPOT, 0.0),
	                               light_of(STILB_SCENE_LIGHT_POINT, 0.0)};
	lights[2].position[0] = -1.5f;
	lights[2].falloff = STILB_SCENE_LIGHT_WINDOWED;
	lights[2].reach = 9.0f;
	for (int way = STILB_RENDER_LIGHTING_FORWARD; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		stage s = stage_open(lights, 3, map, (stilb_render_lighting)way);
		radiance(&s, way == STILB_RENDER_LIGHTING_FORWARD ? want : got);
		bool rough = way == STILB_RENDER_LIGHTING_PREPASS; /* normals of 8 bits, positions of 16 */
		uint32_t off_edges = 0;
		for (int i = 0; i < HEIGHT * WIDTH; i++) {
			double p[3];
			if (way != STILB_RENDER_LIGHTING_FORWARD && floor_of(s.scene, i % WIDTH, i / WIDTH, p))
				off_edges += fabsf(got[i] - want[i]) > (rough ? 0.05f : 0.02f) * (want[i] + 0.05f);
		}
		if (off_edges > (rough ? 60u : 12u)) /* pixels within an edge, where a rounded place matters */
			fail_msg("%s differs in %u pixels", stilb_render_lighting_names[way], off_edges);
		stage_close(&s);
	}
}

/* Pixels that differ by more than a share of the light. */
static uint32_t differing(const float *a, const float *b, float share)
{
	uint32_t count = 0;
	for (int i = 0; i < HEIGHT * WIDTH; i++)
		count += fabsf(a[i] - b[i]) > share * (b[i] + 0.05f);
	return count;
}

/* No shadow falls on a model that receives none, from one frame to the next: as if nothing cast any. In all ways that
 * keep surfaces in images, and in one that does not. */
static void receivers_may_refuse(void **state)
{
	(void)state;
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_FORWARD, STILB_RENDER_LIGHTING_DEFERRED,
	                                             STILB_RENDER_LIGHTING_PREPASS, STILB_RENDER_LIGHTING_PRELIGHT,
	                                             STILB_RENDER_LIGHTING_DEFERRED};
	static float dark[HEIGHT * WIDTH], refused[HEIGHT * WIDTH], again[HEIGHT * WIDTH], open[HEIGHT * WIDTH];
	stilb_scene_light lights[2] = {light_of(STILB_SCENE_LIGHT_DIRECTIONAL, 0.0), light_of(STILB_SCENE_LIGHT_SPOT, 0.0)};
	for (int w = 0; w < 5; w++) {
		stage_gbuffer = w == 4 ? STILB_RENDER_GBUFFER_RGBA8 : STILB_RENDER_GBUFFER_WIDE;
		stage s = stage_open(lights, 2, map, ways[w]);
		radiance(&s, dark);
		assert_int_equal(stilb_scene_set_model_flags(s.scene, 0, STILB_SCENE_MODEL_RECEIVES_NO_SHADOW), STILB_OK);
		radiance(&s, refused);
		assert_int_equal(stilb_scene_set_model_flags(s.scene, 0, 0), STILB_OK);
		radiance(&s, again);
		assert_int_equal(stilb_scene_set_model_flags(s.scene, 1, STILB_SCENE_MODEL_CASTS_NO_SHADOW), STILB_OK);
		radiance(&s, open);
		bool rough = w == 4 || ways[w] == STILB_RENDER_LIGHTING_PREPASS; /* depth by steps of 5e-4 */
		if (differing(dark, open, 0.3f) < 300 ||
		    differing(refused, open, rough ? 0.03f : 0.0005f) > 4) /* of the board itself */
			fail_msg("%s: %u pixels are in shadow, %u of a model without any", stilb_render_lighting_names[ways[w]],
			         differing(dark, open, 0.3f), differing(refused, open, rough ? 0.03f : 0.0005f));
		assert_memory_equal(dark, again, sizeof dark);
		stage_close(&s);
	}
	stage_gbuffer = STILB_RENDER_GBUFFER_WIDE;
}

/* The share of all light on the picture that the lamp's shadow takes, seen from so far that the lamp's reach has so
 * many pixels. */
static double taken(const stage *shadowed, const stage *free, float pixels, stilb_engine_report *report)
{
	static float with[HEIGHT * WIDTH], without[HEIGHT * WIDTH];
	const stilb_scene_light *light = &free->scene->lights[0];
	stilb_scene_camera camera = free->scene->camera;
	double sums[2] = {0.0, 0.0};
	float away = light->reach * (float)HEIGHT / (tanf(0.5f * camera.fov_y) * pixels);
	camera.pitch = -1.0f;
	camera.yaw = 0.0f;
	camera.position[0] = light->position[0];
	camera.position[1] = light->position[1] + away * sinf(1.0f);
	camera.position[2] = light->position[2] + away * cosf(1.0f);
	camera.far_z = 1000.0f;
	shadowed->scene->camera = free->scene->camera = camera;
	*report = radiance(shadowed, with);
	radiance(free, without);
	for (int i = 0; i < HEIGHT * WIDTH; i++) {
		sums[0] += (double)with[i];
		sums[1] += (double)without[i];
	}
	return 1.0 - sums[0] / sums[1];
}

/* The shadow of a lamp that goes away fades before it loses its maps. */
static void far_lamps_lose_their_shadows(void **state)
{
	(void)state;
	stilb_scene_light light = light_of(STILB_SCENE_LIGHT_POINT, 0.0);
	light.falloff = STILB_SCENE_LIGHT_WINDOWED;
	light.reach = 9.0f;
	stage shadowed = stage_open(&light, 1, map, STILB_RENDER_LIGHTING_FORWARD);
	stage free = stage_open(&light, 1, off, STILB_RENDER_LIGHTING_FORWARD);
	stilb_engine_report report;
	double whole = taken(&shadowed, &free, 32.5f, &report), half = taken(&shadowed, &free, 24.0f, &report);
	assert_int_equal(report.shadow_maps, 6);
	assert_int_equal(report.shadow_lights_faded, 0);
	if (!(whole > 0.02) || !(fabs(half / whole - 0.5) < 0.1))
		fail_msg("the shadow takes %f of the light, half way away %f", whole, half);
	assert_true(taken(&shadowed, &free, 16.2f, &report) < 0.05 * whole);
	assert_true(taken(&shadowed, &free, 15.8f, &report) == 0.0);
	assert_int_equal(report.shadow_maps, 0);
	assert_int_equal(report.shadow_lights_faded, 1);
	assert_true(taken(&shadowed, &free, 32.5f, &report) == whole);
	stage_close(&shadowed);
	stage_close(&free);
}

/* A frame of the stage, and the same of an engine that has drawn nothing before. Returns how many maps the first one
 * drew. */
static uint32_t drawn_maps(const stage *s)
{
	static float kept[HEIGHT * WIDTH], fresh[HEIGHT * WIDTH];
	stilb_engine_report report = radiance(s, kept);
	stage anew = {.scene = s->scene};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.shadows = map;
	assert_int_equal(stilb_engine_create(&desc, &anew.engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(anew.engine, s->scene), STILB_OK);
	assert_int_equal(radiance(&anew, fresh).shadow_maps_drawn, report.shadow_maps);
	stilb_engine_destroy(anew.engine);
	for (int i = 0; i < HEIGHT * WIDTH; i++)
		if (kept[i] != fresh[i])
			fail_msg("pixel %d, %d: %f with maps that stayed, %f with new ones", i % WIDTH, i / WIDTH, (double)kept[i],
			         (double)fresh[i]);
	return report.shadow_maps_drawn;
}

/* Only what has changed is drawn, and pictures are as if all were. Two cascades, a spot on the board, and one that sees
 * the floor's edge alone. */
static void maps_stay(void **state)
{
	(void)state;
	stilb_scene_light lights[3] = {light_of(STILB_SCENE_LIGHT_DIRECTIONAL, 0.0), light_of(STILB_SCENE_LIGHT_SPOT, 0.0),
	                               light_of(STILB_SCENE_LIGHT_SPOT, 0.0)};
	lights[1].cos_inner = 0.9f;
	lights[1].cos_outer = 0.8f;
	lights[2].position[0] = -4.5f;
	lights[2].cos_inner = 0.99f;
	lights[2].cos_outer = 0.98f;
	memcpy(lights[2].direction, (float[3]){0.0f, -1.0f, 0.0f}, sizeof lights[2].direction);
	stage s = stage_open(lights, 3, map, STILB_RENDER_LIGHTING_AUTO);
	assert_int_equal(drawn_maps(&s), 4);
	assert_int_equal(drawn_maps(&s), 0);
	stilb_mat4 lower = s.scene->part_transform[1];
	lower.m[13] -= 0.5f;
	assert_int_equal(stilb_scene_set_transform(s.scene, 1, &lower), STILB_OK); /* of the board */
	assert_int_equal(drawn_maps(&s), 3);
	assert_int_equal(drawn_maps(&s), 0);
	lower.m[12] += 4.6f;
	lower.m[14] -= 4.6f;
	assert_int_equal(stilb_scene_set_transform(s.scene, 1, &lower), STILB_OK); /* out of the spot: its shadow goes */
	assert_int_equal(drawn_maps(&s), 3);
	/* There it throws no shadow on what is seen up to the end of the first cascade. */
	assert_int_equal(stilb_scene_show_model(s.scene, 1, false), STILB_OK);
	assert_int_equal(drawn_maps(&s), 1);
	assert_int_equal(stilb_scene_show_model(s.scene, 1, true), STILB_OK);
	assert_int_equal(drawn_maps(&s), 1);
	s.scene->lights[2].position[2] += 0.1f;
	assert_int_equal(drawn_maps(&s), 1);
	s.scene->camera.position[0] += 1.0f; /* the first cascade goes with it */
	assert_int_equal(drawn_maps(&s), 1);
	stage_close(&s);
}

/* A scene that was away meanwhile, and changed, is drawn anew; so is another one in its place. */
static void scenes_come_and_go(void **state)
{
	(void)state;
	stilb_scene_light sun = light_of(STILB_SCENE_LIGHT_DIRECTIONAL, 0.0);
	stage s = stage_open(&sun, 1, map, STILB_RENDER_LIGHTING_AUTO);
	stilb_engine_report report;
	assert_int_equal(drawn_maps(&s), 2);
	assert_int_equal(stilb_engine_set_scene(s.engine, NULL), STILB_OK);
	assert_int_equal(stilb_engine_frame(s.engine, &report), STILB_OK);
	assert_int_equal(report.shadow_maps, 0);
	stilb_mat4 lower = s.scene->part_transform[1];
	lower.m[12] -= 1.0f;
	assert_int_equal(stilb_scene_set_transform(s.scene, 1, &lower), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	assert_int_equal(drawn_maps(&s), 2);
	assert_int_equal(drawn_maps(&s), 0);
	stage_close(&s);
}

/* Triangles of a frame of the stress test on the null device. */
static double stress_triangles(stilb_engine_shadow_kind kind, stilb_render_detail_mode mode)
{
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.profile = false;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.detail = (stilb_render_detail){mode, 0.5f};
	desc.shadows = (stilb_engine_shadows){.kind = kind, .cascades = 3, .size = 1024};
	stress_engine stress = {.models = 2000, .seed = 1, .view = STILB_SCENE_VIEW_ALL};
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(report.shadow_maps_drawn, kind == STILB_ENGINE_SHADOWS_OFF ? 0 : 3);
	assert_int_equal(report.shadow_lights_drawn, kind == STILB_ENGINE_SHADOWS_OFF ? 0 : 1);
	double triangles = (double)stilb_engine_triangles(engine);
	stress_engine_destroy(engine);
	return triangles;
}

/* Three cascades of 1024 texels have no more triangles than the picture of 1280 x 720, and, as they have levels of
 * their own, two fifths of those of a picture without levels. */
static void maps_are_no_dearer_than_the_picture(void **state)
{
	(void)state;
	const stilb_render_detail_mode modes[] = {STILB_RENDER_DETAIL_POP, STILB_RENDER_DETAIL_OFF};
	const double most[] = {1.0, 0.4};
	for (int m = 0; m < 2; m++) {
		double without = stress_triangles(STILB_ENGINE_SHADOWS_OFF, modes[m]);
		double with = stress_triangles(STILB_ENGINE_SHADOWS_MAP, modes[m]);
		assert_true(with - without > 0.05 * without && with - without <= most[m] * without);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(light_arrives_where_it_must),  cmocka_unit_test(lamps_have_soft_edges),
		cmocka_unit_test(ways_show_the_same),           cmocka_unit_test(receivers_may_refuse),
		cmocka_unit_test(far_lamps_lose_their_shadows), cmocka_unit_test(maps_stay),
		cmocka_unit_test(scenes_come_and_go),           cmocka_unit_test(maps_are_no_dearer_than_the_picture),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
