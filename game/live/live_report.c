#include "live_report.h"

#include "base/base_json.h"
#include "game/cli/jobs_json.h"
#include "shading/shade_brdf.h"

#include <inttypes.h>

/* Returns the stage with the greatest median time among those that can limit the frame rate by their work. Presenting
 * is not among them: it waits for the screen. */
static stage live_bound(const stage_summary *summary)
{
	stage bound = STAGE_CULL;
	static const stage candidates[] = {STAGE_RECORD, STAGE_UI, STAGE_REPLAY, STAGE_GPU};
	for (size_t i = 0; i < sizeof candidates / sizeof *candidates; i++)
		if (summary[candidates[i]].median > summary[bound].median)
			bound = candidates[i];
	return bound;
}

static const char *live_bound_name(stage bound)
{
	static const char *const names[STAGE_COUNT] = {[STAGE_CULL] = "culling",
	                                               [STAGE_RECORD] = "recording",
	                                               [STAGE_UI] = "overlay",
	                                               [STAGE_REPLAY] = "replay",
	                                               [STAGE_GPU] = "GPU"};
	return names[bound];
}

static void live_put_choice(stilb_json *json, const char *name, const char *choice)
{
	char text[FLAG_CHOICE_SIZE];
	stilb_json_string(json, name, flags_choice(text, choice));
}

static void live_put_shading(stilb_json *json, stilb_render_shading shading, const stilb_engine_choice *light)
{
	live_put_choice(json, "brdf", stilb_engine_brdf_names[shading.brdf]);
	if (shading.brdf == SHADE_BRDF_MICROFACET) {
		live_put_choice(json, "ndf", stilb_engine_ndf_names[shading.ndf]);
		live_put_choice(json, "g", stilb_engine_g_names[shading.g]);
		live_put_choice(json, "f", stilb_engine_f_names[shading.f]);
	}
	if (light)
		live_put_choice(json, "light_model", light->names[light->chosen]);
	stilb_json_begin(json, "added", '{');
	stilb_json_double(json, "roughness", (double)shading.roughness);
	stilb_json_double(json, "anisotropy", (double)shading.anisotropy);
	stilb_json_double(json, "wrap", (double)shading.wrap);
	stilb_json_double(json, "specular", (double)shading.specular);
	stilb_json_end(json, '}');
}

#define LIVE_UNSHADOWED 2u

/* Names what frames show of lights without shadows, whatever maps there are. Returns how many. */
static uint32_t live_unshadowed(const live_report *report, const char *names[LIVE_UNSHADOWED])
{
	const stilb_scene *scene = stilb_engine_scene(report->engine);
	uint32_t count = 0;
	if (stilb_engine_lighting(report->engine) == STILB_RENDER_LIGHTING_COMBINED)
		names[count++] = "the sum of a model's further lights";
	if (scene && scene->surroundings.panorama.pixels &&
	    stilb_engine_ambient(report->engine) != STILB_RENDER_AMBIENT_NONE)
		names[count++] = "the panorama's lamps";
	return count;
}

/* What keeps lights from surfaces; of maps, those of the last frame. */
static void live_put_shadows(stilb_json *json, const live_report *report)
{
	stilb_engine_shadows shadows = stilb_engine_shadows_used(report->engine);
	stilb_json_begin(json, "shadows", '{');
	live_put_choice(json, "kind", stilb_engine_shadow_names[shadows.kind]);
	if (shadows.kind != STILB_ENGINE_SHADOWS_OFF) {
		stilb_json_int(json, "cascades", shadows.cascades);
		stilb_json_int(json, "cascade_size", shadows.size);
		stilb_json_int(json, "samples", shadows.samples);
		stilb_json_int(json, "maps", report->last.shadow_maps);
		stilb_json_int(json, "drawn", report->last.shadow_maps_drawn);
		stilb_json_int(json, "lights_left_out", report->last.shadow_lights_left);
		stilb_json_int(json, "buffer_lights", (int64_t)report->last.render.shadow_terms);
		stilb_json_int(json, "buffer_bytes", (int64_t)report->last.render.shadow_bytes);
		stilb_json_int(json, "lights_faded_out", report->last.shadow_lights_faded);
		const char *names[LIVE_UNSHADOWED];
		uint32_t count = live_unshadowed(report, names);
		stilb_json_begin(json, "unshadowed", '[');
		for (uint32_t i = 0; i < count; i++)
			stilb_json_string(json, NULL, names[i]);
		stilb_json_end(json, ']');
	}
	stilb_json_end(json, '}');
}

static void live_put_gamepads(stilb_json *json, const live_report *report)
{
	stilb_engine_gamepad_counts counts = stilb_engine_gamepad_counts_get(report->engine);
	const stage_summary *latency = &report->summary[STAGE_PAD];
	stilb_json_begin(json, "gamepads", '{');
	stilb_json_int(json, "reports", (int64_t)counts.reports);
	stilb_json_int(json, "corrupt", (int64_t)counts.corrupt);
	stilb_json_int(json, "lost", (int64_t)counts.lost);
	stilb_json_begin(json, "latency_ms", '{');
	stilb_json_double(json, "median", latency->median);
	stilb_json_double(json, "p99", latency->p99);
	stilb_json_double(json, "min", latency->min);
	stilb_json_end(json, '}');
	stilb_json_end(json, '}');
}

static uint32_t live_models(const live_report *report)
{
	const stilb_scene *scene = stilb_engine_scene(report->engine);
	return scene ? scene->model_count : 0;
}

/* Lights that a pixel asked that shows something, with --show lights. */
static double live_lights_a_pixel(const live_report *report)
{
	return report->last.light_counts.lights / (double)report->last.light_counts.shown;
}

/* How often it was lit. */
static double live_overdraw(const live_report *report)
{
	return report->last.light_counts.shadings / (double)report->last.light_counts.shown;
}

stilb_result live_report_save(const live_report *report)
{
	STILB_ASSERT(report->options->stats && report->frames > 0);
	const live_options *o = report->options;
	const stilb_render_stats *render = &report->last.render;
	const stage_summary *summary = report->summary;
	char hash[17];
	snprintf(hash, sizeof hash, "%016" PRIx64, stilb_engine_stream_hash(report->engine));
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_int(&json, "models", live_models(report));
	stilb_json_int(&json, "visible", report->last.visible);
	stilb_json_int(&json, "draws", (int64_t)render->draws);
	stilb_json_int(&json, "workers", stilb_engine_workers(report->engine));
	stilb_json_int(&json, "frames", (int64_t)report->frames);
	stilb_json_string(&json, "device", picture_device_choices[o->picture.device]);
	stilb_json_string(&json, "device_name", stilb_engine_device_name(report->engine));
	stilb_json_string(&json, "replay", picture_replay_choices[o->picture.replay]);
	stilb_json_string(&json, "materials", picture_materials_choices[o->picture.materials]);
	stilb_json_string(&json, "cull", live_cull_choices[o->cull]);
	stilb_json_string(&json, "culled_by", live_cull_choices[report->last.cull]);
	stilb_json_string(&json, "stream_hash", hash);
	live_put_shading(&json, stilb_engine_shading(report->engine), report->light);
	stilb_json_begin(&json, "commands", '{');
	stilb_json_int(&json, "draw", (int64_t)render->draw_commands);
	stilb_json_int(&json, "draw_indirect", (int64_t)render->indirect_commands);
	stilb_json_int(&json, "execute", (int64_t)render->execute_commands);
	stilb_json_int(&json, "binds_asked", (int64_t)render->binds_asked);
	stilb_json_int(&json, "binds_sent", (int64_t)render->binds_sent);
	stilb_json_end(&json, '}');
	stilb_json_int(&json, "recorded_bytes", (int64_t)render->recorded_bytes);
	stilb_json_begin(&json, "lights", '{');
	stilb_json_int(&json, "shown", (int64_t)(render->lights - render->light_gone));
	stilb_json_int(&json, "faded_out", (int64_t)render->light_gone);
	stilb_json_int(&json, "pairs", (int64_t)render->light_pairs);
	stilb_json_int(&json, "left_out", (int64_t)render->light_left_out);
	if (report->last.light_counts.shown > 0) {
		stilb_json_double(&json, "a_pixel", live_lights_a_pixel(report));
		stilb_json_double(&json, "overdraw", live_overdraw(report));
	}
	if (report->last.light_error.pixels > 0) {
		stilb_json_double(&json, "error_rms", report->last.light_error.rms);
		stilb_json_double(&json, "error_most", report->last.light_error.most);
		stilb_json_double(&json, "error_share", report->last.light_error.share);
	}
	stilb_json_end(&json, '}');
	stilb_json_string(&json, "hdr", stilb_render_hdr_names[render->hdr]);
	stilb_json_double(&json, "exposure", (double)report->last.exposure);
	live_put_shadows(&json, report);
	stilb_job_pool_stats jobs = stilb_engine_job_stats(report->engine);
	jobs_json_put(&json, &jobs);
	stilb_json_begin(&json, "stages", '{');
	for (int s = 0; s < STAGE_GPU; s++) {
		stilb_json_begin(&json, stage_names[s], '{');
		stilb_json_double(&json, "median", summary[s].median);
		stilb_json_double(&json, "p99", summary[s].p99);
		stilb_json_double(&json, "min", summary[s].min);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, '}');
	stilb_json_double(&json, "gpu_ms", summary[STAGE_GPU].median);
	live_put_gamepads(&json, report);
	stilb_json_string(&json, "bound", live_bound_name(live_bound(summary)));
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->stats);
}

static void live_print_shadows(const live_report *report, FILE *out)
{
	const char *names[LIVE_UNSHADOWED];
	stilb_engine_shadows shadows = stilb_engine_shadows_used(report->engine);
	const stilb_engine_report *last = &report->last;
	uint32_t count = live_unshadowed(report, names);
	for (uint32_t i = 0; i < count && shadows.kind != STILB_ENGINE_SHADOWS_OFF; i++)
		fprintf(out, "shadows: %s: none\n", names[i]);
	if (shadows.kind == STILB_ENGINE_SHADOWS_OFF ||
	    (last->shadow_maps + last->shadow_lights_left + last->shadow_lights_faded == 0))
		return;
	const picture_flags *picture = &report->options->picture;
	char coarser[48] = "";
	if (stilb_engine_device_is_software(report->engine) && (picture->cascades == 0 || picture->cascade_size == 0))
		snprintf(coarser, sizeof coarser, " (on a GPU %u of %u)",
		         picture->cascades > 0     ? (uint32_t)picture->cascades
		         : picture->shadow_objects ? 1u
		                                   : 4u,
		         picture->cascade_size > 0 ? (uint32_t)picture->cascade_size : 2048u);
	fprintf(out, "shadows: %u maps, %u of them drawn in the last frame; %u cascades of %u texels%s\n",
	        last->shadow_maps, last->shadow_maps_drawn, shadows.cascades, shadows.size, coarser);
	if (last->shadow_lights_left + last->shadow_lights_faded > 0)
		fprintf(out, "shadows: of %u lights that are seen none has room, of %u they have faded out\n",
		        last->shadow_lights_left, last->shadow_lights_faded);
}

/* What passes kept light in, if that was asked for. */
static void live_print_hdr(const live_report *report, FILE *out)
{
	stilb_render_hdr asked = (stilb_render_hdr)report->options->picture.hdr, used = report->last.render.hdr;
	if (asked == STILB_RENDER_HDR_HALF)
		return;
	if (used == asked)
		fprintf(out, "light: passes kept it as %s, 4 bytes a sample in place of 8\n", stilb_render_hdr_names[used]);
	else
		fprintf(out, "light: passes kept it in half floats, not as %s: the last frame blends or adds light\n",
		        stilb_render_hdr_names[asked]);
}

void live_report_print(const live_report *report)
{
	const live_options *o = report->options;
	const stage_summary *summary = report->summary;
	FILE *out = live_message_stream(o);
	bool software = stilb_engine_device_is_software(report->engine);
	uint32_t width, height, workers = stilb_engine_workers(report->engine),
							samples = stilb_engine_samples(report->engine);
	stilb_engine_size(report->engine, &width, &height);
	fprintf(out, "%u model%s, %u visible, %" PRIu64 " draws; %s%s%s culling, %s replay, %u worker%s\n",
	        live_models(report), live_models(report) == 1 ? "" : "s", report->last.visible, report->last.render.draws,
	        live_cull_choices[o->cull], o->cull == STILB_CULL_AUTO ? ": " : "",
	        o->cull == STILB_CULL_AUTO ? live_cull_choices[report->last.cull] : "",
	        picture_replay_choices[o->picture.replay], workers, workers == 1 ? "" : "s");
	fprintf(out, "%s%s, %ux%u, %u sample%s per pixel\n", stilb_engine_device_name(report->engine),
	        software ? " (software: it draws on the CPU)" : "", width, height, samples, samples == 1 ? "" : "s");
	fprintf(out, "%" PRIu64 " frame%s, the first %" PRIu64 " not counted; milliseconds:\n", report->frames,
	        report->frames == 1 ? "" : "s", report->warmup);
	fprintf(out, "  %-8s %9s %9s %9s\n", "stage", "median", "p99", "min");
	for (int s = 0; s < STAGE_COUNT; s++)
		if (s < STAGE_GPU || (s == STAGE_GPU && o->picture.device != STILB_RENDER_DEVICE_NULL) ||
		    (s == STAGE_PAD && summary[s].median > 0.0))
			fprintf(out, "  %-8s %9.3f %9.3f %9.3f\n", stage_names[s], summary[s].median, summary[s].p99,
			        summary[s].min);
	const stilb_render_stats *render = &report->last.render;
	if (o->picture.light_fade > 0.0f && render->lights > 0)
		fprintf(out, "lights: %" PRIu64 ", of which %" PRIu64 " (%.1f %%) are faded out and %" PRIu64 " fade\n",
		        render->lights, render->light_gone, 100.0 * (double)render->light_gone / (double)render->lights,
		        render->light_faded - render->light_gone);
	if (o->picture.light_tolerance > 0.0f)
		fprintf(out, "lights: %" PRIu64 " pairs of light and cell, %" PRIu64 " left out\n", render->light_pairs,
		        render->light_left_out);
	if (report->last.light_counts.shown > 0)
		fprintf(out, "lights: a pixel that shows something asked %.2f and was lit %.2f times\n",
		        live_lights_a_pixel(report), live_overdraw(report));
	if (report->last.light_counts.cut > 0)
		fprintf(out, "lights: %" PRIu64 " pixels asked more than 65,504, which is counted\n",
		        report->last.light_counts.cut);
	const stilb_render_error *error = &report->last.light_error;
	if (error->pixels > 0)
		fprintf(out,
		        "lights: off from forward by %.3g / 255 of white (RMS), at most by %.3g; %.3g %% of the pixels by more "
		        "than 1\n",
		        255.0 * error->rms, 255.0 * error->most, 100.0 * error->share);
	if (picture_flags_adapt(&o->picture))
		fprintf(out, "exposure: %+.2f EV, adapted\n", (double)report->last.exposure);
	live_print_hdr(report, out);
	live_print_shadows(report, out);
	stage bound = live_bound(summary);
	stilb_engine_gamepad_counts pads = stilb_engine_gamepad_counts_get(report->engine);
	if (pads.reports > 0)
		fprintf(out, "gamepads: %" PRIu64 " reports, %" PRIu64 " corrupt, %" PRIu64 " lost\n", pads.reports,
		        pads.corrupt, pads.lost);
	fprintf(out, "bound by: %s, %.3f ms\n", live_bound_name(bound), summary[bound].median);
}
