/* Which lights models have of their own, and the sum of the others: see render_combined.h. */
#include "render/combined/render_combined.h"

#include "render/render_internal.h"
#include "scene/scene_light_shade.h"
#include "shading/shade_sh.h"

#include <math.h>
#include <string.h>

#define COMBINED_LANES 4u
#define COMBINED_GRAIN 64u      /* models in a step of the loop: some 30 us */
#define COMBINED_STAYS 1.125f   /* what another light must send, as a multiple of what is there */
#define COMBINED_FIRST_FRAME 2u /* of a pass, so that the states {0} are of no frame before it */
#define COMBINED_PARTS (sizeof(render_combined_record) / sizeof(float[4]))

typedef float combined_four __attribute__((vector_size(16)));
typedef int32_t combined_mask __attribute__((vector_size(16)));

/* A light that reaches a model. */
typedef struct combined_light {
	shade_sun seen; /* from the model's centre */
	float weight;   /* luminance of its irradiance */
	uint32_t light; /* place among the view's lights */
	uint32_t share; /* of its own shape, in RENDER_COMBINED_SHARE */
} combined_light;

/* Those of the model that a worker is at, ascending. */
struct render_combined_reaching {
	combined_light *lights; /* [count] */
	uint32_t count, capacity;
	bool failed; /* no memory */
};

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static stilb_result combined_no_memory(uint32_t models)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lights of %u models", models);
}

static void combined_drop_reaching(render_combined *combined)
{
	for (uint32_t w = 0; w < combined->worker_count; w++)
		free(combined->reaching[w].lights);
	free(combined->reaching);
	combined->reaching = NULL;
	combined->worker_count = 0;
}

static void combined_drop_lights(render_combined *combined)
{
	free(combined->x);
	free(combined->lights);
	free(combined->bounds);
	combined->x = NULL;
	combined->lights = NULL;
	combined->bounds = NULL;
	combined->capacity = 0;
}

void render_combined_finish(render_combined *combined)
{
	combined_drop_lights(combined);
	combined_drop_reaching(combined);
}

/* Makes room for so many lights and workers. False: no memory. */
static bool combined_fit(render_combined *combined, uint32_t lights, uint32_t workers)
{
	if (workers > combined->worker_count) {
		combined_drop_reaching(combined);
		combined->reaching = calloc(workers, sizeof *combined->reaching);
		if (!combined->reaching)
			return false;
		combined->worker_count = workers;
	}
	if (lights <= combined->capacity)
		return true;
	combined_drop_lights(combined);
	size_t capacity = ((size_t)lights + lights / 4 + COMBINED_LANES) / COMBINED_LANES * COMBINED_LANES;
	combined->x = stilb_memory_alloc(4 * capacity, sizeof *combined->x);
	combined->lights = stilb_memory_alloc(capacity, sizeof *combined->lights);
	combined->bounds = stilb_memory_alloc(capacity, sizeof *combined->bounds);
	if (!combined->x || !combined->lights || !combined->bounds) {
		combined_drop_lights(combined);
		return false;
	}
	combined->y = combined->x + capacity;
	combined->z = combined->y + capacity;
	combined->radius = combined->z + capacity;
	combined->capacity = (uint32_t)capacity;
	return true;
}

/* ---- the lights -------------------------------------------------------------------------------------------------- */

static void combined_put(render_combined *combined, uint32_t place, shade_light light, stilb_light_bounds bounds)
{
	bool nowhere = bounds.sphere.radius < 0.0f;
	combined->lights[place] = light;
	combined->bounds[place] = bounds;
	combined->x[place] = nowhere ? NAN : bounds.sphere.x;
	combined->y[place] = bounds.sphere.y;
	combined->z[place] = bounds.sphere.z;
	combined->radius[place] = bounds.sphere.radius;
}

/* Takes over the lights in the order in which the frame's memory has them (render_lights.c): so many. */
static void combined_take_lights(render_combined *combined, const stilb_render_view *view,
                                 const render_panorama *panorama, const render_lights_fade *fade, uint32_t count)
{
	uint32_t place = 0;
	for (uint32_t i = 0; i < render_view_lamps(view, panorama); i++) {
		const render_panorama_lamp *lamp = &panorama->lamps[i];
		stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL};
		render_panorama_turn(lamp->direction, view->surroundings.rotation, light.direction);
		for (int c = 0; c < 3; c++)
			light.direction[c] = -light.direction[c];
		memcpy(light.intensity, lamp->irradiance, sizeof light.intensity);
		combined_put(combined, place++, scene_light_shade(&light), stilb_light_bounds_of(&light));
	}
	for (int ends = 0; ends < 2; ends++)
		for (uint32_t i = 0; i < view->light_count; i++) {
			stilb_scene_light light = view->lights[i];
			if (light.use == STILB_SCENE_LIGHT_BAKED || render_light_ends(&light) != (bool)ends)
				continue;
			float left = render_light_left(fade, &light); /* where it is 0 the light reaches nothing */
			for (int c = 0; c < 3; c++)
				light.intensity[c] *= left;
			combined_put(combined, place++, scene_light_shade(&light), stilb_light_bounds_of(&light));
		}
	STILB_ASSERT(place == count);
	for (; place % COMBINED_LANES != 0; place++) /* what fills the last four reaches nothing */
		combined->x[place] = NAN;
}

/* ---- a model ----------------------------------------------------------------------------------------------------- */

/* What the jobs share. */
typedef struct combined_job {
	render_combined *combined;
	render_combined_pass *pass;
	uint32_t light_count;
	uint32_t *words;                 /* of the frame */
	render_combined_record *records; /* [model_count] of the frame */
	uint32_t first;                  /* the first record's place */
} combined_job;

/* True if the light's cone touches the sphere: the distance of its centre from the cone's side, and from its apex. */
static bool combined_in_cone(const stilb_light_bounds *bounds, const render_combined_model *model)
{
	if (bounds->cos_angle < 0.0f)
		return true; /* none, or one that is wider than half of space: its sphere is close enough */
	float along = 0.0f, square = 0.0f;
	for (int i = 0; i < 3; i++) {
		float d = model->center[i] - bounds->apex[i];
		along += d * bounds->axis[i];
		square += d * d;
	}
	float across = sqrtf(fmaxf(square - along * along, 0.0f));
	float sine = sqrtf(1.0f - bounds->cos_angle * bounds->cos_angle);
	float slack = 1e-5f * (sqrtf(square) + model->radius);
	return across * bounds->cos_angle - along * sine <= model->radius + slack && along >= -model->radius - slack;
}

static void combined_reach(const combined_job *job, const render_combined_model *model,
                           render_combined_reaching *reaching, uint32_t light)
{
	const render_combined *combined = job->combined;
	if (light >= job->light_count || !combined_in_cone(&combined->bounds[light], model))
		return;
	if (!render_reserve((void **)&reaching->lights, &reaching->capacity, reaching->count + 1,
	                    sizeof *reaching->lights)) {
		reaching->failed = true;
		return;
	}
	stilb_vec3 center = stilb_vec3_make(model->center[0], model->center[1], model->center[2]);
	shade_sun seen = shade_light_at(combined->lights[light], center);
	reaching->lights[reaching->count++] =
		(combined_light){.seen = seen, .weight = shade_luminance(seen.irradiance), .light = light};
}

/* Finds the lights whose spheres and cones touch the model's sphere. */
static void combined_find(const combined_job *job, const render_combined_model *model,
                          render_combined_reaching *reaching)
{
	const render_combined *combined = job->combined;
	reaching->count = 0;
	for (uint32_t l = 0; l < job->light_count; l += COMBINED_LANES) {
		combined_four x, y, z, r;
		memcpy(&x, combined->x + l, sizeof x);
		memcpy(&y, combined->y + l, sizeof y);
		memcpy(&z, combined->z + l, sizeof z);
		memcpy(&r, combined->radius + l, sizeof r);
		x -= model->center[0];
		y -= model->center[1];
		z -= model->center[2];
		r += model->radius;
		combined_mask touches = x * x + y * y + z * z <= r * r * 1.0001f;
		int64_t halves[2];
		memcpy(halves, &touches, sizeof halves);
		if ((halves[0] | halves[1]) == 0)
			continue;
		for (uint32_t i = 0; i < COMBINED_LANES; i++)
			if (touches[i])
				combined_reach(job, model, reaching, l + i);
	}
}

/* The light among those that reach the model; NULL: it does not. */
static combined_light *combined_of(const render_combined_reaching *reaching, uint32_t light)
{
	uint32_t first = 0, end = reaching->count;
	while (first < end) {
		uint32_t middle = first + (end - first) / 2;
		if (reaching->lights[middle].light < light)
			first = middle + 1;
		else
			end = middle;
	}
	return first < reaching->count && reaching->lights[first].light == light ? &reaching->lights[first] : NULL;
}

/* The lights that the model shall have of its own, brightest first. Those that have shares already stay where they are
 * nearly as bright. */
static uint32_t combined_wanted(const render_combined_reaching *reaching, combined_light *wanted[RENDER_COMBINED_OWN])
{
	float weights[RENDER_COMBINED_OWN];
	uint32_t count = 0;
	for (uint32_t i = 0; i < reaching->count; i++) {
		combined_light *light = &reaching->lights[i];
		float weight = light->share > 0 ? light->weight * COMBINED_STAYS : light->weight;
		if (count == RENDER_COMBINED_OWN && !(weight > weights[count - 1]))
			continue;
		uint32_t at = count < RENDER_COMBINED_OWN ? count++ : count - 1;
		for (; at > 0 && weight > weights[at - 1]; at--) {
			wanted[at] = wanted[at - 1];
			weights[at] = weights[at - 1];
		}
		wanted[at] = light;
		weights[at] = weight;
	}
	return count;
}

/* Sets the shares of the lights that reach the model, and keeps them. */
static void combined_share(const combined_job *job, render_combined_state *state,
                           const render_combined_reaching *reaching)
{
	combined_light *wanted[RENDER_COMBINED_OWN], *own[RENDER_COMBINED_OWN];
	bool goes_on = state->frame + 1 == job->pass->frame;
	bool had_all = goes_on && state->reaching <= RENDER_COMBINED_OWN;
	uint32_t count = 0;
	for (uint32_t s = 0; goes_on && s < RENDER_COMBINED_OWN && state->share[s] > 0; s++) {
		combined_light *light = combined_of(reaching, state->light[s]);
		if (!light)
			continue;
		light->share = state->share[s];
		own[count++] = light;
	}
	uint32_t wanted_count = combined_wanted(reaching, wanted), kept = 0;
	for (uint32_t s = 0; s < count; s++) {
		bool stays = false;
		for (uint32_t w = 0; w < wanted_count; w++)
			stays |= wanted[w] == own[s];
		if (!stays)
			own[s]->share--;
		else if (own[s]->share < RENDER_COMBINED_SHARE)
			own[s]->share++;
		if (own[s]->share > 0)
			own[kept++] = own[s];
	}
	for (uint32_t w = 0; w < wanted_count && kept < RENDER_COMBINED_OWN; w++)
		if (wanted[w]->share == 0) {
			wanted[w]->share = goes_on && !had_all ? 1 : RENDER_COMBINED_SHARE;
			own[kept++] = wanted[w];
		}
	*state = (render_combined_state){.frame = job->pass->frame, .reaching = reaching->count};
	for (uint32_t s = 0; s < kept; s++) {
		state->light[s] = own[s]->light;
		state->share[s] = (uint8_t)own[s]->share;
	}
}

/* The sum of what is not the lights' own. False: there is none. */
static bool combined_sum(const render_combined_reaching *reaching, render_combined_record *record)
{
	shade_sh_rgb sum = {0};
	bool some = false;
	for (uint32_t i = 0; i < reaching->count; i++) {
		const combined_light *light = &reaching->lights[i];
		if (light->share == RENDER_COMBINED_SHARE || !(light->weight > 0.0f))
			continue;
		float rest = (float)(RENDER_COMBINED_SHARE - light->share) / (float)RENDER_COMBINED_SHARE;
		sum = shade_sh_rgb_add(sum, shade_sh_rgb_directional(light->seen.direction, light->seen.irradiance * rest));
		some = true;
	}
	if (!some)
		return false;
	sum = shade_sh_rgb_window(sum, SHADE_SH_WINDOW_IRRADIANCE);
	shade_sh channels[3] = {shade_sh_convolve_cosine(sum.r), shade_sh_convolve_cosine(sum.g),
	                        shade_sh_convolve_cosine(sum.b)};
	for (int c = 0; c < 3; c++) {
		memcpy(record->sum[c], channels[c].c, sizeof record->sum[c]);
		record->last[c] = channels[c].c[8];
	}
	return true;
}

/* The lights that have shares, in the order in which all lights are added up. */
static void combined_list(const render_combined_reaching *reaching, render_combined_record *record)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < reaching->count; i++)
		if (reaching->lights[i].share > 0) {
			STILB_ASSERT(count < RENDER_COMBINED_OWN);
			record->light[count] = reaching->lights[i].light;
			record->share[count++] = (float)reaching->lights[i].share / (float)RENDER_COMBINED_SHARE;
		}
	for (; count < RENDER_COMBINED_OWN; count++)
		record->light[count] = RENDER_COMBINED_NONE;
}

static void combined_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("combine lights");
	const combined_job *job = context;
	render_combined_reaching *reaching = &job->combined->reaching[worker];
	for (uint32_t i = begin; i < end; i++) {
		const render_combined_model *model = &job->pass->models[i];
		render_combined_record record = {0};
		combined_find(job, model, reaching);
		combined_share(job, &job->pass->states[model->model], reaching);
		combined_list(reaching, &record);
		bool sum = combined_sum(reaching, &record);
		uint32_t place = job->first + i * (uint32_t)COMBINED_PARTS;
		job->records[i] = record; /* the device's memory: written once, from front to back */
		job->words[model->model] = place | (sum ? RENDER_COMBINED_SUM : 0);
	}
}

/* ---- a pass ------------------------------------------------------------------------------------------------------ */

stilb_result render_combined_place(stilb_render *render, const stilb_render_view *view, const render_panorama *panorama,
                                   render_combined_pass *pass, render_view_lights *lights, stilb_job_pool *pool,
                                   uint32_t worker)
{
	render_combined *combined = &render->combined;
	uint64_t words = ((uint64_t)pass->scene_models + 3) / 4, parts = words + pass->model_count * COMBINED_PARTS;
	uint32_t workers = pool ? stilb_job_pool_worker_count(pool) + 1 : 1;
	float(*out)[4] = parts < RENDER_COMBINED_SUM && combined_fit(combined, lights->count, workers)
	                     ? render_claim(render, RENDER_MEMORY_LIGHT_LISTS, (uint32_t)parts, &lights->lists)
	                     : NULL;
	if (!out)
		return combined_no_memory(pass->model_count);
	render_lights_fade fade = render_lights_fade_of(render, view);
	combined_take_lights(combined, view, panorama, &fade, lights->count);
	pass->frame = pass->frame >= COMBINED_FIRST_FRAME ? pass->frame + 1 : COMBINED_FIRST_FRAME;
	combined_job job = {.combined = combined,
	                    .pass = pass,
	                    .light_count = lights->count,
	                    .words = (uint32_t *)out[0],
	                    .records = (render_combined_record *)(void *)out[words],
	                    .first = (uint32_t)words};
	if (pool)
		stilb_job_parallel_for(pool, pass->model_count, COMBINED_GRAIN, combined_slice, &job, worker);
	else
		combined_slice(0, pass->model_count, 0, &job);
	bool failed = false;
	for (uint32_t w = 0; w < workers; w++) {
		failed |= combined->reaching[w].failed;
		combined->reaching[w].failed = false;
	}
	return failed ? combined_no_memory(pass->model_count) : STILB_OK;
}
