#include "live_gamepads.h"

/* Prints the line on a gamepad that is new. A gamepad of a recording may have no path. */
static void live_gamepads_came(const stilb_input_control_pad *pad, FILE *out)
{
	const char *path = pad->info->path;
	fprintf(out, "gamepad: %s%s%s, %s\n", pad->name, path[0] ? " at " : "", path, pad->recognised);
}

void live_gamepads_say(live_gamepads *gamepads, const stilb_engine *engine, bool replayed, FILE *out)
{
	STILB_ASSERT(out && gamepads->count <= STILB_INPUT_PADS_MAX);
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_engine_gamepads(engine, pads);
	live_gamepads now = {.replayed = replayed};
	for (uint32_t i = 0; i < count; i++) {
		if (pads[i].denied)
			continue;
		bool told = false;
		for (uint32_t k = 0; k < gamepads->count; k++)
			told |= gamepads->told[k].pad == pads[i].pad;
		if (!told)
			live_gamepads_came(&pads[i], out);
		now.told[now.count].pad = pads[i].pad;
		snprintf(now.told[now.count].name, sizeof now.told[now.count].name, "%s", pads[i].name);
		now.count++;
	}
	if (replayed && !gamepads->replayed)
		fprintf(out, "recording ended\n"); /* instead of "gamepad gone" for each of its pads */
	for (uint32_t k = 0; !replayed && k < gamepads->count; k++) {
		bool there = false;
		for (uint32_t i = 0; i < now.count; i++)
			there |= now.told[i].pad == gamepads->told[k].pad;
		if (!there)
			fprintf(out, "gamepad gone: %s\n", gamepads->told[k].name);
	}
	*gamepads = now;
}
