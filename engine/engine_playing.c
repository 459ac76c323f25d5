/* How fast the clips of the scene play. */
#include "engine_internal.h"

#include <math.h>

void stilb_engine_set_pace(stilb_engine *engine, float pace)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(isfinite(pace));
	engine->playing.pace = pace;
}

float stilb_engine_pace(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->playing.pace;
}

void stilb_engine_step(stilb_engine *engine, double seconds)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(isfinite(seconds));
	engine->playing.step += seconds;
}

void engine_playing_pause(stilb_engine *engine)
{
	engine_playing *playing = &engine->playing;
	if (playing->pace != 0.0f) {
		playing->pace_before = playing->pace;
		playing->pace = 0.0f;
	} else {
		playing->pace = playing->pace_before != 0.0f ? playing->pace_before : 1.0f;
	}
}
