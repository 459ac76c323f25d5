/* stilb pads: the command and its flags. */
#include "pads.h"

#include "game/cli/flags.h"
#include "game/commands.h"

#include "base/base_file.h"

#include <string.h>

static const char *const pads_buses[] = {"usb", "bluetooth", NULL};

#define PADS_FLAGS 10

static const char *const pads_flag_names[PADS_FLAGS] = {"--watch",    "--record", "--replay", "--seconds", "--rumble",
                                                        "--describe", "--id",     "--bus",    "--backend", "--json"};

static flags_result pads_parse(pads_options *o, int argc, char **argv, bool given[PADS_FLAGS])
{
	const flag flags[PADS_FLAGS] = {
		{"--watch", FLAG_SWITCH, &o->watch, NULL, "axes and buttons, live, until Ctrl-C", 0, 0, NULL},
		{"--record", FLAG_TEXT, &o->record, "FILE", "write every report to FILE (hid-recorder's format); - is stdout",
	     0, 0, NULL},
		{"--replay", FLAG_TEXT, &o->replay, "FILE", "decode a recording; with --watch at its own pace; - is stdin", 0,
	     0, NULL},
		{"--seconds", FLAG_AMOUNT, &o->seconds, "S", "end --watch and --record after S seconds, 0..86400 (0: Ctrl-C)",
	     0, 86400, NULL},
		{"--rumble", FLAG_SWITCH, &o->rumble, NULL,
	     "make each pad rumble in turn for half a second, and say whether it did", 0, 0, NULL},
		{"--describe", FLAG_TEXT, &o->describe, "FILE",
	     "fields and mapping of a report descriptor, a recording or /dev/hidrawN", 0, 0, NULL},
		{"--id", FLAG_TEXT, &o->id, "VVVV:PPPP", "vendor and product of the descriptor in FILE, hexadecimal", 0, 0,
	     NULL},
		{"--bus", FLAG_CHOICE, &o->bus, "NAME", "bus of the descriptor in FILE: usb (default), bluetooth", 0, 0,
	     pads_buses},
		{"--backend", FLAG_CHOICE, &o->backend, "NAME",
	     "how pads are read: hidraw (default), the kernel's interface, or hidapi", 0, 0, pads_backends},
		{"--json", FLAG_TEXT, &o->json, "FILE", "list, description or replay as JSON; - is standard output", 0, 0,
	     NULL},
	};
	flags_result result = flags_parse(flags, PADS_FLAGS, argc, argv);
	if (result == FLAGS_HELP) {
		printf("stilb pads: lists the gamepads of this machine, how they were recognised, and what they report.\n\n");
		flags_print(flags, PADS_FLAGS);
	}
	for (int i = 0; result == FLAGS_OK && i < PADS_FLAGS; i++)
		given[i] = flags_given(flags, PADS_FLAGS, argc, argv, pads_flag_names[i]);
	return result;
}

/* Refuses flags that contradict each other. */
static bool pads_check_together(const bool given[PADS_FLAGS])
{
	enum { WATCH, RECORD, REPLAY, SECONDS, RUMBLE, DESCRIBE, ID, BUS, BACKEND, JSON };
	static const struct {
		int flag;
		uint32_t without; /* a bit for each flag that cannot be combined with `flag` */
	} rules[] = {
		{DESCRIBE, 1u << WATCH | 1u << RECORD | 1u << REPLAY | 1u << SECONDS | 1u << RUMBLE | 1u << BACKEND},
		{REPLAY, 1u << RUMBLE | 1u << BACKEND},
		{WATCH, 1u << JSON},
	};
	for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
		for (int other = 0; given[rules[i].flag] && other < PADS_FLAGS; other++)
			if (given[other] && (rules[i].without >> other & 1)) {
				stilb_log("%s cannot be combined with %s", pads_flag_names[other], pads_flag_names[rules[i].flag]);
				return false;
			}
	if (!given[DESCRIBE] && (given[ID] || given[BUS])) {
		stilb_log("%s says whose descriptor --describe shows; give --describe FILE", given[ID] ? "--id" : "--bus");
		return false;
	}
	if (given[SECONDS] && !given[WATCH] && !given[RECORD]) {
		stilb_log("--seconds ends --watch and --record; give one of them");
		return false;
	}
	if (given[RECORD] && given[JSON] && !given[REPLAY]) {
		stilb_log("--json cannot be combined with --record; record first, then give --replay FILE --json");
		return false;
	}
	return true;
}

static bool pads_check_files(const pads_options *o)
{
	const char *const outputs[] = {o->record, o->json};
	for (size_t i = 0; i < 2; i++)
		if (outputs[i] && stilb_file_check(outputs[i]) != STILB_OK) {
			stilb_log("%s", stilb_error_message());
			return false;
		}
	if (o->record && o->json && stilb_file_same(o->record, o->json)) {
		stilb_log("--record and --json are two outputs; '%s' cannot be both", o->json);
		return false;
	}
	if (o->record && o->watch && stilb_file_is_stdout(o->record)) {
		stilb_log("--watch prints to standard output, where --record %s writes; give --record a file", o->record);
		return false;
	}
	for (size_t i = 0; i < 2; i++) {
		const char *input = o->replay ? o->replay : o->describe;
		if (input && strcmp(input, "-") != 0 && outputs[i] && stilb_file_same(input, outputs[i])) {
			stilb_log("the output would replace '%s'; give it another name", input);
			return false;
		}
	}
	return true;
}

int pads_command(int argc, char **argv)
{
	pads_options o = {0};
	bool given[PADS_FLAGS] = {false};
	flags_result parsed = pads_parse(&o, argc, argv, given);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !pads_check_together(given) || !pads_check_files(&o))
		return EXIT_REFUSED;
	if (o.describe)
		return pads_describe(&o);
	return o.watch || o.record || o.replay ? pads_follow(&o) : pads_list(&o);
}
