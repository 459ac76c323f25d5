/* What the engine does with news of shaders: each is logged, and told by a toast, or by a panel if something is
 * wrong. */
#include "engine_internal.h"
#include "watch/engine_watch.h"

#include <stdlib.h>
#include <string.h>

void engine_watch_start(stilb_engine *engine)
{
	const stilb_engine_desc *desc = &engine->desc;
	if (desc->watch_shaders == STILB_ENGINE_WATCH_OFF)
		return;
	engine->watch = engine_watch_create(stilb_render_gpu(engine->render), desc->shaders);
	if (!engine->watch && desc->watch_shaders == STILB_ENGINE_WATCH_ON)
		stilb_log("%s", stilb_error_message());
}

/* Logs a text line by line. */
static void watch_log(const char *text)
{
	for (const char *end; *text; text = *end ? end + 1 : end) {
		end = strchrnul(text, '\n');
		stilb_log("%.*s", (int)(end - text), text);
	}
}

static void watch_forget(stilb_engine *engine)
{
	free(engine->overlay.shader_error);
	engine->overlay.shader_error = NULL;
}

void engine_watch_finish(stilb_engine *engine)
{
	engine_watch_destroy(engine->watch);
	engine->watch = NULL;
	watch_forget(engine);
}

void engine_watch_tell(stilb_engine *engine)
{
	engine_watch_news news;
	while (engine->watch && engine_watch_look(engine->watch, &news)) {
		bool shown = engine->window || engine->input.is_given;
		watch_log(news.text);
		engine->shadows.valid = engine->shadows.valid && !news.good; /* they may look otherwise now */
		watch_forget(engine);
		if (news.good || !shown || engine_overlay_create(engine) != STILB_OK) {
			if (news.good)
				stilb_engine_tell(engine, news.text);
			free(news.text);
			continue;
		}
		engine->overlay.shader_error = news.text;
	}
}
