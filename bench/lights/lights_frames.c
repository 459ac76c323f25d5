#include "bench/lights/lights_frames.h"

#include "image/image.h"
#include "jobs/job.h"
#include "render/render.h"
#include "scene/scene_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 640u
#define HEIGHT 360u
#define LAMPS 1000u
#define HALF_FLOOR 30.0f     /* metres */
#define ON_FLOOR 8.0f        /* lamps that reach a point of the floor, on average */
#define LAMP_HEIGHT 0.5f     /* above it */
#define MOST_EVERYWHERE 256u /* lights that every pixel asks */

typedef struct frames {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_mat4 view_projection;
	float eye[3];
	stilb_scene_light lamps[LAMPS], everywhere[MOST_EVERYWHERE];
} frames;

static void require(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static stilb_scene_light lamp(float x, float z, float reach)
{
	return (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
	                           .position = {x, LAMP_HEIGHT, z},
	                           .intensity = {0.5f, 0.4f, 0.3f},
	                           .falloff = STILB_SCENE_LIGHT_WINDOWED,
	                           .reach = reach};
}

static stilb_scene *floor_make(void)
{
	stilb_scene_mesh plane;
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material material = {
		.diffuse = {0.5f, 0.5f, 0.5f}, .specular = {0.04f, 0.04f, 0.04f}, .roughness = 0.4f};
	stilb_mat4 place = stilb_mat4_scale_translate(HALF_FLOOR, 0.0f, 0.0f, 0.0f);
	require(stilb_scene_mesh_plane(&plane));
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &plane), stilb_scene_build_material(build, &material)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	stilb_scene_mesh_finish(&plane);
	require(stilb_scene_build_end(build, &scene));
	return scene;
}

static void frames_open(frames *f)
{
	/* As many lamps as ON_FLOOR lie in a circle of this radius. */
	float side = 2.0f * HALF_FLOOR, square = ON_FLOOR * side * side / ((float)LAMPS * 3.14159265f);
	float reach = sqrtf(square + LAMP_HEIGHT * LAMP_HEIGHT);
	for (uint32_t i = 0; i < LAMPS; i++)
		f->lamps[i] = lamp(side * (stilb_random_float(25, 2 * i) - 0.5f),
		                   side * (stilb_random_float(25, 2 * i + 1) - 0.5f), reach);
	for (uint32_t i = 0; i < MOST_EVERYWHERE; i++)
		f->everywhere[i] = lamp((float)(i % 16) - 8.0f, (float)(i / 16) - 8.0f, 1000.0f);
	f->scene = floor_make();
	memcpy(f->eye, (float[3]){0.0f, 12.0f, 18.0f}, sizeof f->eye);
	stilb_mat4 eye = stilb_mat4_view(stilb_vec3_make(f->eye[0], f->eye[1], f->eye[2]), 0.0f, -0.8f);
	f->view_projection =
		stilb_mat4_multiply(stilb_mat4_perspective(0.7f, (float)WIDTH / (float)HEIGHT, 0.1f, 200.0f), eye);
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_VULKAN, .width = WIDTH, .height = HEIGHT, .samples = 1, .context_count = 1};
	if (stilb_job_pool_create(&(stilb_job_pool_desc){0}, &f->pool) != 0)
		bench_child_fail("no pool");
	require(stilb_render_create(&desc, &f->render));
	require(stilb_render_set_scene(f->render, f->scene));
}

static void frame_draw(frames *f, stilb_render_lighting way, stilb_render_light_lists who, stilb_render_show show,
                       const stilb_scene_light *lights, uint32_t count)
{
	stilb_render_view view = {.view_projection = f->view_projection,
	                          .lights = lights,
	                          .light_count = count,
	                          .lighting = way,
	                          .light_lists = who,
	                          .show = show,
	                          .shading = stilb_render_shading_default()};
	stilb_render_pass pass = {.name = "floor"};
	uint32_t id = 0;
	memcpy(view.camera_position, f->eye, sizeof f->eye);
	require(stilb_render_frame_begin(f->render));
	require(stilb_render_record(f->render, 0, f->scene, &id, 1, f->pool, 0));
	require(stilb_render_replay(f->render, &pass, 1, &view, 1, f->pool, 0));
}

/* The device's time of a frame, ms. */
static double frame_ms(frames *f, stilb_render_lighting way, stilb_render_light_lists who,
                       const stilb_scene_light *lights, uint32_t count)
{
	frame_draw(f, way, who, STILB_RENDER_SHOW_SHADED, lights, count);
	require(stilb_render_wait(f->render));
	return stilb_render_stats_get(f->render).gpu_ms;
}

/* Lights that a pixel asks, the mean of those that show the floor. */
static double mean_list(frames *f)
{
	stilb_image image;
	uint16_t texel[4] = {0};
	double lights = 0.0, shown = 0.0;
	frame_draw(f, STILB_RENDER_LIGHTING_CLUSTERED, STILB_RENDER_LIGHT_LISTS_JOBS, STILB_RENDER_SHOW_LIGHTS, f->lamps,
	           LAMPS);
	require(stilb_render_read_radiance(f->render, &image));
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		memcpy(texel, (const uint16_t *)image.pixels + 3 * (size_t)i, 3 * sizeof *texel);
		stilb_render_light_counts counts = stilb_render_count_lights((const uint16_t(*)[4]) & texel, 1);
		lights += counts.lights;
		shown += (double)counts.shown;
	}
	stilb_image_finish(&image);
	if (shown < 0.99 * WIDTH * HEIGHT)
		bench_child_fail("the floor does not fill the picture");
	return lights / shown;
}

void lights_frames_measure(const bench_child *child)
{
	static frames f;
	/* What a frame is lit by: a way and lamps, or so many lights everywhere. */
	struct {
		const char *name;
		stilb_render_lighting way;
		uint32_t everywhere;
		stilb_render_light_lists lists;
		double ms;
	} kinds[] = {
		{"eight", STILB_RENDER_LIGHTING_FORWARD, 8, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"mean_forward", STILB_RENDER_LIGHTING_FORWARD, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"clustered", STILB_RENDER_LIGHTING_CLUSTERED, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"by_compute", STILB_RENDER_LIGHTING_CLUSTERED, 0, STILB_RENDER_LIGHT_LISTS_COMPUTE, HUGE_VAL},
		{"tiled_forward", STILB_RENDER_LIGHTING_TILED_FORWARD, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"indexed", STILB_RENDER_LIGHTING_INDEXED, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"deferred", STILB_RENDER_LIGHTING_DEFERRED, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"tiled_deferred", STILB_RENDER_LIGHTING_TILED_DEFERRED, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
		{"prelight", STILB_RENDER_LIGHTING_PRELIGHT, 0, STILB_RENDER_LIGHT_LISTS_JOBS, HUGE_VAL},
	};
	frames_open(&f);
	double mean = mean_list(&f);
	kinds[1].everywhere = (uint32_t)lround(fmin(mean, MOST_EVERYWHERE));
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int round = 0; round < 3 || bench_child_now_ns() < end; round++)
		for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
			bool few = kinds[k].everywhere > 0;
			double ms = frame_ms(&f, kinds[k].way, kinds[k].lists, few ? f.everywhere : f.lamps,
			                     few ? kinds[k].everywhere : LAMPS);
			if (round > 0) /* programs were compiled */
				kinds[k].ms = fmin(kinds[k].ms, ms);
		}
	bench_child_metric("list", mean);
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
		bench_child_metric(kinds[k].name, kinds[k].ms);
	bench_child_metric("lists", kinds[3].ms - kinds[2].ms);
	bench_child_metric("to_eight", kinds[2].ms / kinds[0].ms);
	bench_child_metric("to_mean", kinds[2].ms / kinds[1].ms);
	stilb_render_destroy(f.render);
	stilb_scene_destroy(f.scene);
	stilb_job_pool_destroy(f.pool);
}
