/* The whole engine, seen by engine.c and frame.c alone. */
#ifndef STILB_ENGINE_INTERNAL_H
#define STILB_ENGINE_INTERNAL_H

#include "engine.h"
#include "window/window.h"

#define ENGINE_MAX_VIEWS 4u

struct stilb_engine {
	stilb_engine_desc desc;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_cull *cull;
	stilb_window *window; /* NULL when headless */
	stilb_render *render;

	/* What is drawn, as data: frame.c runs cull once per view, and record and replay once per pass. */
	stilb_render_view views[ENGINE_MAX_VIEWS];
	stilb_cull_visible visible[ENGINE_MAX_VIEWS]; /* what each sees this frame */
	uint32_t view_count;
	stilb_render_pass passes[STILB_RENDER_MAX_PASSES];
	uint32_t pass_count;

	uint64_t frame;   /* frames done */
	uint64_t last_ns; /* when the frame before began; 0 before the first */
	double seconds;   /* the scene's time */
	float step;       /* of this frame, seconds */
	stilb_engine_report report;
};

#endif
