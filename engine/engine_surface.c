/*
 * The surface of a window of the engine's. A driver may lose it while the window lives, as when the session is switched
 * or the compositor starts anew: then another one is made of the same window.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#define SURFACE_TRY_NS UINT64_C(100000000)   /* between two tries */
#define SURFACE_GONE_NS UINT64_C(1000000000) /* of tries in vain, after which the window counts as gone */

stilb_gpu_surface engine_surface_of(stilb_window *window)
{
	STILB_ASSERT(window);
	return (stilb_gpu_surface){window, stilb_window_surface_extensions, stilb_window_surface_create};
}

/* Tries to make another surface, unless the last try was a moment ago. Errors of the window are no errors: until there
 * is a surface, pictures are copied to memory. */
static stilb_result surface_regain(engine_surface *surface, stilb_render *render, stilb_window *window)
{
	uint64_t now = stilb_time_ns();
	if (surface->tried_ns && now - surface->tried_ns < SURFACE_TRY_NS)
		return STILB_OK;
	PROFILE("make a surface");
	surface->tried_ns = now;
	stilb_gpu_surface own = engine_surface_of(window);
	stilb_result result = stilb_render_set_surface(render, &own);
	if (result != STILB_OK)
		return result == STILB_ERROR_DEVICE_LOST ? result : STILB_OK;
	*surface = (engine_surface){0};
	stilb_log("the window's surface was lost; there is another one");
	return STILB_OK;
}

stilb_result engine_surface_present(engine_surface *surface, stilb_render *render, stilb_window *window)
{
	stilb_result result = surface->lost && window ? surface_regain(surface, render, window) : STILB_OK;
	if (result == STILB_OK)
		result = stilb_render_present(render);
	if (result != STILB_ERROR_WINDOW)
		return result;
	*surface = (engine_surface){.lost = true, .since_ns = stilb_time_ns()};
	return window ? surface_regain(surface, render, window) : STILB_OK;
}

bool engine_surface_is_gone(const engine_surface *surface, const stilb_window *window)
{
	return surface->lost && (!window || stilb_time_ns() - surface->since_ns > SURFACE_GONE_NS);
}

stilb_result stilb_engine_set_surface(stilb_engine *engine, const stilb_gpu_surface *surface)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(!engine->window && "the engine has a window of its own");
	stilb_result result = stilb_render_set_surface(engine->render, surface);
	engine->surface = (engine_surface){.lost = result != STILB_OK && surface};
	return result;
}
