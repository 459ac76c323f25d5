/* together [TRACE.json]: a program with a job pool, the profiler and the engine side by side. Its own jobs move models
 * between frames, and one trace shows them beside the engine's threads. The null device draws nothing, so this runs
 * everywhere. */
#include <stdio.h>
#include <stilb/engine.h>
#include <stilb/job_prof.h>
#include <stilb/prof.h>

typedef struct crowd {
	stilb_job_pool *pool;
	stilb_scene *scene;
	float height; /* of all models in this frame, metres */
} crowd;

static void raise_models(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("raise models"); /* in the lane of the thread that runs this slice */
	crowd *c = context;
	(void)worker;
	for (uint32_t m = begin; m < end; m++) {
		c->scene->bounds.y[m] += c->height;
		for (uint32_t part = c->scene->first_part[m]; part < c->scene->first_part[m + 1]; part++)
			c->scene->part_transform[part].m[13] += c->height;
		c->scene->moved[m] = m;
	}
}

static void on_update(void *user, const stilb_engine_update *update)
{
	crowd *c = user;
	c->height = update->frame % 2 ? 0.1f : -0.1f;
	stilb_job_parallel_for(c->pool, c->scene->model_count, 64, raise_models, c, 0);
	c->scene->moved_count = c->scene->model_count;
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
	return result != STILB_OK;
}
