/* own_debug [PICTURE.png]: lines, boxes, spheres, axes and text in the world, drawn by jobs of many threads at once.
 * Needs no window. */
#include <math.h>
#include <stdio.h>
#include <stilb/engine.h>

typedef struct program {
	stilb_engine *engine;
	stilb_scene *scene;
} program;

/* Draws the bounds of every fourth model, with its number. Runs on all threads of the pool. */
static void draw_bounds(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const program *p = context;
	stilb_debug *debug = stilb_engine_debug(p->engine);
	const stilb_scene_bounds *b = &p->scene->bounds;
	(void)worker;
	for (uint32_t m = begin; m < end; m++) {
		float r = b->radius[m], center[3] = {b->x[m], b->y[m], b->z[m]};
		float low[3] = {center[0] - r, center[1] - r, center[2] - r}, above[3] = {center[0], center[1] + r, center[2]};
		float high[3] = {center[0] + r, center[1] + r, center[2] + r};
		if (m % 4 != 0)
			continue;
		stilb_debug_box(debug, low, high, NULL, (stilb_debug_style){.rgba = 0x40ff60ff});
		stilb_debug_text(debug, above, (stilb_debug_style){.rgba = 0xffffffff}, "model %u", m);
	}
}

/* Called in each frame: everything that is drawn here, or by jobs, is seen in this frame. */
static void on_update(void *user, const stilb_engine_update *update)
{
	program *p = user;
	stilb_debug *debug = stilb_engine_debug(p->engine);
	stilb_mat4 origin = stilb_mat4_identity();
	stilb_debug_style yellow = {.rgba = 0xffe040ff, .width = 3.0f}, on_top = {.rgba = 0xffffffff, .on_top = true};
	float last[3] = {0}, next[3];
	(void)update;
	stilb_job_parallel_for(stilb_engine_pool(p->engine), p->scene->model_count, 8, draw_bounds, p, 0);
	for (int i = 0; i <= 200; i++, last[0] = next[0], last[1] = next[1], last[2] = next[2]) {
		float angle = 0.1f * (float)i;
		next[0] = 12.0f * cosf(angle);
		next[1] = 0.08f * (float)(i - 100);
		next[2] = 12.0f * sinf(angle);
		if (i > 0)
			stilb_debug_line(debug, last, next, yellow); /* the scene hides parts of it */
	}
	stilb_debug_sphere(debug, next, 2.0f, yellow);
	on_top.width = 3.0f;
	stilb_debug_axes(debug, &origin, 6.0f, on_top); /* nothing hides these */
	stilb_debug_text(debug, (float[3]){0, 6.3f, 0}, on_top, "%u models around the origin", p->scene->model_count);
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "own_debug.png";
	program p = {NULL, NULL};
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine_report report;
	desc.width = 960;
	desc.height = 540;
	desc.samples = 4;
	desc.update = on_update;
	desc.user = &p;
	stilb_result result = stilb_scene_create_stress(300, 1, &p.scene);
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &p.engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(p.engine, p.scene);
	if (result == STILB_OK)
		result = stilb_engine_frame(p.engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(p.engine, path);
	if (result == STILB_OK)
		printf("%u lines and parts of letters drawn: %s\n", stilb_debug_count(stilb_engine_debug(p.engine)), path);
	else
		fprintf(stderr, "%s\n", stilb_error_message());
	stilb_engine_destroy(p.engine);
	stilb_scene_destroy(p.scene);
	return result == STILB_OK ? 0 : 1;
}
