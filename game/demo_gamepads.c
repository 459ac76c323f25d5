#include "demo_gamepads.h"

void demo_gamepads_say(demo_gamepads *gamepads, const stilb_engine *engine, FILE *out)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	const uint32_t count = stilb_engine_gamepads(engine, pads);
	demo_gamepads now = {0};
	for (uint32_t i = 0; i < count; i++) {
		if (pads[i].denied)
			continue;
		bool told = false;
		for (uint32_t k = 0; k < gamepads->count; k++)
			told |= gamepads->told[k].pad == pads[i].pad;
		if (!told)
			fprintf(out, "gamepad: %s at %s, %s\n", pads[i].name, pads[i].info->path, pads[i].recognised);
		now.told[now.count].pad = pads[i].pad;
		snprintf(now.told[now.count].name, sizeof now.told[now.count].name, "%s", pads[i].name);
		now.count++;
	}
	for (uint32_t k = 0; k < gamepads->count; k++) {
		bool there = false;
		for (uint32_t i = 0; i < now.count; i++)
			there |= now.told[i].pad == gamepads->told[k].pad;
		if (!there)
			fprintf(out, "gamepad gone: %s\n", gamepads->told[k].name);
	}
	*gamepads = now;
}
