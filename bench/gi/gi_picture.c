/* Pictures of the Cornell box, and their error against a reference picture that this program renders, too. */
#include "bench/gi/gi_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PIXELS ((size_t)GI_RUN_SIDE * GI_RUN_SIDE)
#define FLOATS (3 * PIXELS)
#define VISIBLE_LIGHT 4.0f
#define LEFT_OUT_AROUND 2
#define REFERENCE_SEED 0x5eed

gi_run_clock gi_run_now(void)
{
	struct timespec cpu, thread;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &thread);
	return (gi_run_clock){1e-9 * (double)bench_child_now_ns(), (double)cpu.tv_sec + 1e-9 * (double)cpu.tv_nsec,
	                      (double)thread.tv_sec + 1e-9 * (double)thread.tv_nsec};
}

gi_run_picture gi_run_render(const gi_run_world *world, const stilb_gi_settings *settings)
{
	stilb_gi_render *render;
	gi_run_check(stilb_gi_render_create(world->gi, settings, world->pool, &render), "a render");
	gi_run_clock begin = gi_run_now();
	gi_run_check(stilb_gi_render_run(render), "rendering");
	gi_run_clock end = gi_run_now();
	gi_run_picture picture = {.seconds = end.seconds - begin.seconds,
	                          .cpu_seconds = end.cpu_seconds - begin.cpu_seconds,
	                          .thread_seconds = end.thread_seconds - begin.thread_seconds};
	stilb_gi_progress progress;
	stilb_gi_render_progress(render, &progress);
	picture.rays = progress.rays;
	picture.records = progress.records;
	size_t bytes = 3 * sizeof(float) * settings->width * settings->height;
	picture.rgb = malloc(bytes);
	if (!picture.rgb)
		bench_child_fail("no memory for a picture");
	memcpy(picture.rgb, stilb_gi_render_film(render).radiance, bytes);
	stilb_gi_render_destroy(render);
	return picture;
}

void gi_run_picture_finish(gi_run_picture *picture)
{
	free(picture->rgb);
	picture->rgb = NULL;
}

stilb_gi_settings gi_run_cornell(const stilb_scene *scene)
{
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = STILB_GI_INTEGRATOR_PATH;
	settings.width = settings.height = GI_RUN_SIDE;
	settings.depth = 64;
	return settings;
}

/* ---- the reference ----------------------------------------------------------------------------------------------- */

/* Renders two independent pictures and stores their mean; returns the mean square error of the mean, estimated from the
 * pictures' difference. */
static double reference_half(const gi_run_world *world, stilb_gi_settings settings, float *mean)
{
	gi_run_picture a = gi_run_render(world, &settings);
	settings.seed++;
	gi_run_picture b = gi_run_render(world, &settings);
	double noise = 0.0;
	for (size_t i = 0; i < FLOATS; i++) {
		double difference = 0.5 * ((double)a.rgb[i] - (double)b.rgb[i]);
		mean[i] = 0.5f * (a.rgb[i] + b.rgb[i]);
		noise += mean[i] < VISIBLE_LIGHT ? difference * difference : 0.0;
	}
	gi_run_picture_finish(&a);
	gi_run_picture_finish(&b);
	return noise / FLOATS;
}

static FILE *open_reference(const char *path, const char *mode)
{
	FILE *file = path ? fopen(path, mode) : NULL;
	if (!file)
		bench_child_fail("%s: cannot open the reference", path ? path : "no path");
	return file;
}

static float *picture_alloc(void)
{
	float *rgb = malloc(FLOATS * sizeof(float));
	if (!rgb)
		bench_child_fail("no memory for a picture");
	return rgb;
}

void gi_run_reference_write(const char *path, uint32_t samples)
{
	stilb_scene *scene;
	gi_run_check(stilb_scene_open("cornell", &scene), "cornell");
	gi_run_world world = gi_run_world_make(scene, bench_child_cpu_count() - 1);
	stilb_gi_settings settings = gi_run_cornell(world.scene);
	settings.seed = REFERENCE_SEED;
	settings.samples = samples;
	float *rgb = picture_alloc();
	FILE *file = open_reference(path, "wb");
	for (int indirect = 0; indirect < 2; indirect++) {
		settings.only = indirect ? STILB_GI_ONLY_INDIRECT : STILB_GI_ALL_LIGHT;
		double noise = reference_half(&world, settings, rgb);
		if (fwrite(&noise, sizeof noise, 1, file) != 1 || fwrite(rgb, sizeof(float), FLOATS, file) != FLOATS)
			bench_child_fail("%s: cannot write the reference", path);
	}
	if (fclose(file) != 0)
		bench_child_fail("%s: cannot write the reference", path);
	free(rgb);
	gi_run_world_finish(&world);
}

void gi_run_leave_out(bool *left_out, const float *rgb, uint32_t pixels)
{
	int side = (int)pixels, around = LEFT_OUT_AROUND;
	for (int y = 0; y < side; y++)
		for (int x = 0; x < side; x++) {
			if (rgb[3 * (size_t)(y * side + x)] <= VISIBLE_LIGHT)
				continue;
			for (int v = y < around ? 0 : y - around; v <= y + around && v < side; v++)
				for (int u = x < around ? 0 : x - around; u <= x + around && u < side; u++)
					left_out[v * side + u] = true;
		}
}

gi_run_reference gi_run_reference_read(const char *path)
{
	gi_run_reference reference = {.all = picture_alloc(), .indirect = picture_alloc()};
	FILE *file = open_reference(path, "rb");
	if (fread(&reference.all_noise, sizeof(double), 1, file) != 1 ||
	    fread(reference.all, sizeof(float), FLOATS, file) != FLOATS ||
	    fread(&reference.indirect_noise, sizeof(double), 1, file) != 1 ||
	    fread(reference.indirect, sizeof(float), FLOATS, file) != FLOATS)
		bench_child_fail("%s: the reference is incomplete", path);
	fclose(file);
	reference.left_out = calloc(PIXELS, sizeof(bool));
	if (!reference.left_out)
		bench_child_fail("no memory for a picture");
	gi_run_leave_out(reference.left_out, reference.all, GI_RUN_SIDE);
	return reference;
}

gi_run_error gi_run_compare(const gi_run_reference *reference, const float *rgb, bool indirect)
{
	const float *truth = indirect ? reference->indirect : reference->all;
	double square = 0.0, sum = 0.0, expected = 0.0;
	size_t count = 0;
	for (size_t i = 0; i < FLOATS; i++) {
		if (reference->left_out[i / 3])
			continue;
		double difference = (double)rgb[i] - (double)truth[i];
		square += difference * difference;
		sum += (double)rgb[i];
		expected += (double)truth[i];
		count++;
	}
	double noise = indirect ? reference->indirect_noise : reference->all_noise;
	return (gi_run_error){.square = fmax(square / (double)count - noise, 1e-12),
	                      .bias = 100.0 * (sum / expected - 1.0)};
}
