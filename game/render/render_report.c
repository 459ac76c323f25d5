#include "render_report.h"
#include "render_progress.h"

#include "base/base_json.h"
#include "engine.h"
#include "game/cli/jobs_json.h"

#include <inttypes.h>
#include <math.h>

static double report_rate(const stilb_gi_progress *progress)
{
	return progress->seconds > 0.0 ? (double)progress->rays / progress->seconds : 0.0;
}

/* Returns why the render ended; "failure": an error ended it before it was finished. */
static const char *report_end(const offline_result *result)
{
	if (result->code != EXIT_DONE && result->progress.end == STILB_GI_END_NOT)
		return "failure";
	static const char *const ends[] = {[STILB_GI_END_NOT] = "stopped",
	                                   [STILB_GI_END_SAMPLES] = "samples",
	                                   [STILB_GI_END_SECONDS] = "time",
	                                   [STILB_GI_END_ERROR] = "error",
	                                   [STILB_GI_END_STOPPED] = "stopped"};
	return result->stopped ? "stopped" : ends[result->progress.end];
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static void report_put_choice(stilb_json *json, const char *name, const char *choice)
{
	char text[FLAG_CHOICE_SIZE];
	stilb_json_string(json, name, flags_choice(text, choice));
}

static void report_put_model(stilb_json *json, shade_brdf_model model)
{
	report_put_choice(json, "brdf", stilb_engine_brdf_names[model.kind]);
	if (model.kind != SHADE_BRDF_MICROFACET)
		return;
	report_put_choice(json, "ndf", stilb_engine_ndf_names[model.ndf]);
	report_put_choice(json, "g", stilb_engine_g_names[model.g]);
	report_put_choice(json, "f", stilb_engine_f_names[model.f]);
}

static void report_put_cache(stilb_json *json, const stilb_gi_cache_settings *cache, uint32_t records)
{
	stilb_json_begin(json, "cache", '{');
	stilb_json_string(json, "mode", cache->mode == STILB_GI_CACHE_LIVE ? "live" : "frozen");
	stilb_json_string(json, "radius", offline_cache_radii[cache->radius]);
	stilb_json_double(json, "error", (double)cache->error);
	stilb_json_int(json, "rays", cache->rays);
	stilb_json_bool(json, "gradients", cache->gradients);
	stilb_json_bool(json, "overture", cache->overture);
	stilb_json_int(json, "records", records);
	stilb_json_end(json, '}');
}

static void report_put_scene(stilb_json *json, const char *name, const stilb_gi_scene_info *scene)
{
	stilb_json_begin(json, "scene", '{');
	stilb_json_string(json, "name", name);
	stilb_json_int(json, "triangles", (int64_t)scene->triangles);
	stilb_json_int(json, "flat", (int64_t)scene->flat);
	stilb_json_int(json, "invalid", (int64_t)scene->invalid);
	stilb_json_int(json, "lights", scene->lights);
	stilb_json_int(json, "bytes", (int64_t)scene->bytes);
	stilb_json_double(json, "tree_s", scene->build_s);
	stilb_json_end(json, '}');
}

/* Writes position, yaw, pitch and field of view in metres and degrees, as --camera takes them. */
static void report_put_camera(stilb_json *json, const stilb_scene_camera *camera)
{
	double degrees = 180.0 / M_PI;
	stilb_json_begin(json, "camera", '[');
	for (int i = 0; i < 3; i++)
		stilb_json_double(json, NULL, (double)camera->position[i]);
	stilb_json_double(json, NULL, (double)camera->yaw * degrees);
	stilb_json_double(json, NULL, (double)camera->pitch * degrees);
	stilb_json_double(json, NULL, (double)camera->fov_y * degrees);
	stilb_json_end(json, ']');
}

static void report_put_passes(stilb_json *json, const stilb_gi_progress *progress)
{
	stilb_json_begin(json, "passes", '[');
	for (uint32_t i = 0; i < progress->pass_count; i++) {
		const stilb_gi_pass *pass = &progress->passes[i];
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "block", pass->block);
		stilb_json_int(json, "first_sample", pass->first_sample);
		stilb_json_int(json, "samples", pass->sample_count);
		stilb_json_double(json, "seconds", pass->seconds);
		stilb_json_bool(json, "finished", pass->finished);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static void report_put_settings(stilb_json *json, const stilb_gi_settings *s)
{
	char seed[24];
	snprintf(seed, sizeof seed, "%" PRIu64, s->seed);
	report_put_choice(json, "integrator", rays_integrators[s->integrator]);
	if (s->integrator == STILB_GI_INTEGRATOR_CHANNEL)
		report_put_choice(json, "channel", stilb_scene_channel_names[s->channel]);
	report_put_choice(json, "sampler", offline_samplers[s->sampler]);
	report_put_choice(json, "filter", offline_filters[s->filter]);
	stilb_json_int(json, "width", s->width);
	stilb_json_int(json, "height", s->height);
	stilb_json_string(json, "seed", seed); /* many readers of JSON hold numbers as double, 53 bits */
	stilb_json_int(json, "depth", s->depth);
	stilb_json_int(json, "rays_per_hit", s->rays);
	stilb_json_string(json, "only", s->only == STILB_GI_ONLY_INDIRECT ? "indirect" : "all");
	stilb_json_string(json, "fireflies", s->firefly_weight ? "weight" : "keep");
	stilb_json_bool(json, "denoise", s->denoise);
	report_put_model(json, s->model);
	report_put_camera(json, &s->camera);
	stilb_json_double(json, "exposure", (double)s->exposure);
	stilb_json_double(json, "aperture", (double)s->lens.radius);
	stilb_json_double(json, "focus", (double)s->lens.focus);
}

/* A run that failed before the scene was ready: its scene's name, the time spent, and the reason. */
static void report_put_failure(stilb_json *json, const offline_options *o, const offline_result *result)
{
	stilb_json_begin(json, "scene", '{');
	stilb_json_string(json, "name", o->scene);
	stilb_json_end(json, '}');
	stilb_json_double(json, "open_s", result->open_s);
	stilb_json_string(json, "end", report_end(result));
	stilb_json_string(json, "message", result->message);
	stilb_json_bool(json, "finished", false);
}

static void report_put_run(stilb_json *json, const offline_options *o, const offline_result *result)
{
	const stilb_gi_progress *progress = &result->progress;
	report_put_scene(json, o->scene, &result->scene);
	stilb_json_double(json, "open_s", result->open_s);
	stilb_json_int(json, "import_bytes", (int64_t)result->import_bytes);
	stilb_json_double(json, "build_s", result->build_s);
	stilb_json_double(json, "render_s", progress->seconds);
	if (result->settings.denoise)
		stilb_json_double(json, "denoise_s", result->denoise_s);
	stilb_json_double(json, "save_s", result->save_s);
	stilb_json_string(json, "end", report_end(result));
	if (result->message[0])
		stilb_json_string(json, "message", result->message);
	stilb_json_bool(json, "finished", progress->finished);
	stilb_json_double(json, "done", progress->done);
	stilb_json_int(json, "spp", progress->samples);
	stilb_json_double(json, "error", progress->error);
	stilb_json_int(json, "rays", (int64_t)progress->rays);
	stilb_json_int(json, "camera_rays", (int64_t)progress->camera_rays);
	stilb_json_int(json, "shadow_rays", (int64_t)progress->shadow_rays);
	stilb_json_int(json, "bad_samples", (int64_t)progress->bad_samples);
	stilb_json_double(json, "mrays_per_s", report_rate(progress) * 1e-6);
	stilb_json_int(json, "workers", result->workers);
	stilb_json_int(json, "ranks", result->ranks > 0 ? result->ranks : 1);
	stilb_json_string(json, "isa", result->scene.isa);
	jobs_json_put(json, &result->jobs);
	report_put_settings(json, &result->settings);
	if (result->settings.integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE)
		report_put_cache(json, &result->settings.cache, progress->records);
	report_put_passes(json, progress);
}

stilb_result offline_report_save(const offline_options *o, const offline_result *result)
{
	STILB_ASSERT(o->stats && (result->prepared || result->code != EXIT_DONE || result->stopped));
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	if (result->prepared)
		report_put_run(&json, o, result);
	else
		report_put_failure(&json, o, result);
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->stats);
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

/* Writes a count with three digits, "1.25 M". */
static void report_count(double count, char *text, size_t size)
{
	static const char *const powers[] = {"", " k", " M", " G", " T"};
	size_t power = 0;
	for (; count >= 1000.0 && power + 1 < sizeof powers / sizeof *powers; power++)
		count /= 1000.0;
	snprintf(text, size, power > 0 ? "%.3g%s" : "%.0f%s", count, powers[power]);
}

void offline_report_print(const offline_options *o, const offline_result *result)
{
	STILB_ASSERT(result->prepared);
	FILE *out = offline_message_stream(o);
	const stilb_gi_progress *progress = &result->progress;
	const stilb_gi_settings *s = &result->settings;
	char integrator[FLAG_CHOICE_SIZE], sampler[FLAG_CHOICE_SIZE], samples[64], rays[32], rate[32];
	report_count((double)progress->rays, rays, sizeof rays);
	report_count(report_rate(progress), rate, sizeof rate);
	fprintf(out, "%s: %" PRIu64 " triangle%s, %" PRIu32 " light%s, ready in %.2f s\n", o->scene,
	        result->scene.triangles, result->scene.triangles == 1 ? "" : "s", result->scene.lights,
	        result->scene.lights == 1 ? "" : "s", result->open_s + result->build_s);
	offline_progress_samples(progress, samples, sizeof samples);
	fprintf(out, "%s, %ux%u, %s (%s); %u worker%s, %s\n", flags_choice(integrator, rays_integrators[s->integrator]),
	        s->width, s->height, samples, flags_choice(sampler, offline_samplers[s->sampler]), result->workers,
	        result->workers == 1 ? "" : "s", result->scene.isa);
	if (result->shares[0])
		fprintf(out, "%s\n", result->shares);
	if (o->part)
		fprintf(out, "part %" PRIu32 " of %" PRIu32 "\n", o->part_index, o->part_of);
	if (s->integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE)
		fprintf(out, "%" PRIu32 " records in the cache\n", progress->records);
	fprintf(out, "%s rays in %.2f s: %s rays/s\n", rays, progress->seconds, rate);
	if (result->denoise_s > 0.0)
		fprintf(out, "denoised in %.2f s\n", result->denoise_s);
	if (result->metered)
		fprintf(out, "exposure: %.2f EV, metered\n", (double)s->exposure);
	if (o->frames)
		fprintf(out, "%" PRIu32 " of %" PRIu32 " pictures were written\n", result->frames,
		        o->frame_last - o->frame_first + 1);
	else if (result->saved)
		fprintf(out, "%s: %s\n", o->part ? "part" : "picture", o->output);
	if (result->stopped && result->checkpointed)
		fprintf(out, "stopped at %.0f %%; the same command with --resume continues it\n", 100.0 * progress->done);
}
