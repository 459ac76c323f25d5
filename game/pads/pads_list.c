/* stilb pads without flags: lists what is plugged in; --rumble. */
#include "game/cli/flags.h"
#include "pads.h"

#include <string.h>
#include <time.h>

#define LIST_LOOK_MS 3000 /* longest wait; finding all pads takes milliseconds unless one does not answer */
#define LIST_NODES 64     /* nodes /dev/hidrawN at most: HIDRAW_MAX_DEVICES of Linux, drivers/hid/hidraw.c */

static void list_print_pad(FILE *out, const pads_options *o, const stilb_input_control_pad *pad)
{
	char bus[16], recognised[PADS_RECOGNISED_SIZE];
	const stilb_input_pad_info *info = pad->info;
	fprintf(out, "%s\n  path        %s\n  bus         %s, vendor %04x, product %04x\n",
	        info->name[0] ? info->name : "?", info->path, pads_bus_text(info->bus, bus), info->vendor, info->product);
	if (info->unique[0])
		fprintf(out, "  serial      %s\n", info->unique);
	pads_print_wrapped(out, "  recognised  ", pads_recognised_text(pad, recognised));
	if (pad->denied)
		pads_print_rule(out, info);
	else
		fprintf(out, "  read by     %s\n", pads_backends[o->backend]);
}

/* ---- other HID devices ------------------------------------------------------------------------------------------- */

static bool list_has(const stilb_input_control_pad *pads, uint32_t count, const char *path)
{
	for (uint32_t i = 0; i < count; i++)
		if (strcmp(pads[i].info->path, path) == 0)
			return true;
	return false;
}

/* Lists the HID devices that are not gamepads with the reason: a pad that was not recognised is among them. */
static void list_print_others(FILE *out, const stilb_input_control_pad *pads, uint32_t count)
{
	static stilb_input_pad_info info;
	static stilb_input_layout layout;
	bool title = false;
	for (int i = 0; i < LIST_NODES; i++) {
		char path[32];
		snprintf(path, sizeof path, "/dev/hidraw%d", i);
		if (list_has(pads, count, path) || stilb_input_look(path, &info) != STILB_OK ||
		    stilb_input_layout_find(&info, &layout) == STILB_OK)
			continue;
		fprintf(out, "%s  %s, %s\n", title ? "" : "\nnot gamepads:\n", path, info.name[0] ? info.name : "?");
		pads_print_wrapped(out, "    ", stilb_error_message());
		title = true;
	}
}

static void list_print(FILE *out, const pads_options *o, const stilb_input_control_pad *pads, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		list_print_pad(out, o, &pads[i]);
	if (count == 0)
		fprintf(out, "No gamepad was found. Plug one in by USB, or pair it by Bluetooth. Xbox pads on\n"
		             "USB have no hidraw device: they work in a window, in 'stilb demo'.\n");
	list_print_others(out, pads, count);
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static stilb_result list_save(const pads_options *o, const stilb_input_control_pad *pads, uint32_t count)
{
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "backend", pads_backends[o->backend]);
	stilb_json_begin(&json, "pads", '[');
	for (uint32_t i = 0; i < count; i++) {
		char rule[512];
		stilb_json_begin(&json, NULL, '{');
		pads_json_info(&json, pads[i].info);
		stilb_json_string(&json, "serial", pads[i].info->unique);
		stilb_json_string(&json, "device", pads[i].info->device);
		stilb_json_string(&json, "layout", pads[i].name);
		stilb_json_string(&json, "recognised", pads[i].recognised);
		stilb_json_bool(&json, "permission", !pads[i].denied);
		stilb_json_string(&json, "udev_rule", stilb_input_udev_rule(pads[i].info, rule, sizeof rule));
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->json);
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

/* Makes a pad rumble. Returns the result in words. After a signal the pad is closed, which stops its motors. */
static const char *list_rumble_pad(stilb_input_pads *pads, const stilb_input_control_pad *pad)
{
	struct timespec time = {.tv_nsec = (PADS_RUMBLE_MS + 100) * 1000000L};
	if (pad->denied)
		return "no permission";
	if (!pads_has_rumble(pad->info))
		return "has no known motors";
	uint64_t written = stilb_input_pads_stats_get(pads).written;
	stilb_input_pads_rumble(pads, pad->pad, 0.6f, 0.6f, PADS_RUMBLE_MS);
	nanosleep(&time, NULL);
	return stilb_input_pads_stats_get(pads).written > written ? "rumbled" : "refused the request";
}

/* Makes the pads rumble one after the other, so that the user can feel which is which. */
static void list_rumble(FILE *out, stilb_input_pads *pads, const stilb_input_control_pad *seen, uint32_t count)
{
	pads_catch_signals();
	for (uint32_t i = 0; i < count && !pads_interrupted; i++) {
		const char *what = list_rumble_pad(pads, &seen[i]);
		if (out)
			fprintf(out, "%s, %s: %s\n", seen[i].info->path, seen[i].info->name[0] ? seen[i].info->name : "?", what);
	}
}

static int list_run(const pads_options *o, stilb_input_pads *pads, stilb_input_control *control)
{
	stilb_input_control_pad seen[STILB_INPUT_PADS_MAX];
	stilb_input_event event;
	FILE *words = pads_message_stream(o);
	stilb_input_pads_wait(pads, LIST_LOOK_MS);
	while (stilb_input_pads_next(pads, INT64_MAX, &event))
		stilb_input_control_event(control, &event);
	uint32_t count = stilb_input_control_pads(control, seen);
	if (words)
		list_print(words, o, seen, count);
	if (o->json && list_save(o, seen, count) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	if (o->rumble)
		list_rumble(words, pads, seen, count);
	return EXIT_DONE;
}

int pads_list(const pads_options *o)
{
	static const stilb_input_pose still;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	stilb_input_control *control = NULL;
	stilb_input_pads *pads = NULL;
	int code = EXIT_FAILED;
	if (stilb_input_control_create(&settings, &still, 0, &control) == STILB_OK && pads_open(o, &pads) == STILB_OK)
		code = list_run(o, pads, control);
	else
		stilb_log("%s", stilb_error_message());
	stilb_input_pads_destroy(pads);
	stilb_input_control_destroy(control);
	return code;
}
