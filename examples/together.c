/* together [TRACE.json]: a program with a job pool, the profiler and the engine side by side. Its own jobs move models
 * between frames, and one trace shows them beside the engine's threads. The null device draws nothing, so this runs
 * everywhere. */
#include <stdio.h>
#include <stdlib.h>
#include <stilb/engine.h>
#include <stilb/job_prof.h>
#include <stilb/prof.h>
#include <stilb/scene_edit.h>

typedef struct crowd {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_mat4 *places; /* [part_count] where the parts shall be in this frame */
	float step;         /* metres that all models rise in this frame */
} crowd;

static void place_models(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("place models"); /* in the lane of the thread that runs this slice */
	crowd *c = context;
	(void)worker;
	for (uint32_t part = begin; part < end; part++) {
		c->places[part] = c->scene->part_transform[part];
		c->places[part].m[13] += c->step;
	}
}

/* Jobs compute, this thread edits: a scene has one writer. */
static void on_update(void *user, const stilb_engine_update *update)
{
	crowd *c = user;
	c->step = update->frame % 2 ? 0.1f : -0.1f;
	stilb_job_parallel_for(c->pool, c->scene->part_count, 64, place_models, c, 0);
	for (uint32_t m = 0; m < c->scene->model_count; m++)
		if (stilb_scene_set_part_transforms(c->scene, m, &c->places[c->scene->first_part[m]]) != STILB_OK)
			stilb_log("%s", stilb_error_message());
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "together.json";
	crowd c = {0};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.update = on_update;
	desc.user = &c;
	stilb_engine *engine = NULL;
	stilb_engine_report report = {0};
	stilb_job_pool_desc jobs = stilb_job_pool_desc_default();
	stilb_result result = stilb_engine_create(&desc, &engine); /* sets the profiler up: before our own threads */
	jobs.hooks = stilb_job_prof_hooks("mine");
	if (stilb_job_pool_create(&jobs, &c.pool) != 0)
		result = stilb_fail(STILB_ERROR_THREAD, "cannot start %u threads", jobs.worker_count);
	if (result == STILB_OK)
		result = stilb_scene_create_stress(1000, 1, &c.scene);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, c.scene);
	if (result == STILB_OK && !(c.places = malloc(c.scene->part_count * sizeof *c.places)))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for %u places", c.scene->part_count);
	while (result == STILB_OK && report.frame < 60)
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_trace(engine, path, 0);
	if (result == STILB_OK)
		printf("%u of %u models in frame %u: %s\n", report.visible, c.scene->model_count, (unsigned)report.frame, path);
	else
		fprintf(stderr, "together: %s\n", stilb_error_message());
	stilb_job_pool_destroy(c.pool);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(c.scene);
	free(c.places);
	return result != STILB_OK;
}
