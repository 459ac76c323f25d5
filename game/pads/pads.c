/* stilb pads: the command and what its parts share. */
#include "pads.h"

#include "game/cli/flags.h"
#include "game/commands.h"

#include "base/base_file.h"

#include <string.h>

const char *const pads_backends[] = {"hidraw", "hidapi", NULL};
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
	     "shake one pad after the other for half a second, and say how it went", 0, 0, NULL},
		{"--describe", FLAG_TEXT, &o->describe, "FILE",
	     "fields and mapping of a report descriptor, a recording or /dev/hidrawN", 0, 0, NULL},
		{"--id", FLAG_TEXT, &o->id, "VVVV:PPPP", "vendor and product of the descriptor in FILE, hexadecimal", 0, 0,
	     NULL},
		{"--bus", FLAG_CHOICE, &o->bus, "NAME", "and its bus: usb (default), bluetooth", 0, 0, pads_buses},
		{"--backend", FLAG_CHOICE, &o->backend, "NAME",
	     "what reads: hidraw (default), the kernel's interface, or hidapi", 0, 0, pads_backends},
		{"--json", FLAG_TEXT, &o->json, "FILE", "list, description or replay as JSON; - is standard output", 0, 0,
	     NULL},
	};
	const flags_result result = flags_parse(flags, PADS_FLAGS, argc, argv);
	if (result == FLAGS_HELP) {
		printf(
			"stilb pads: the gamepads of this machine: which there are, how they were recognised, what they say.\n\n");
		flags_print(flags, PADS_FLAGS);
	}
	for (int i = 0; result == FLAGS_OK && i < PADS_FLAGS; i++)
		given[i] = flags_given(flags, PADS_FLAGS, argc, argv, pads_flag_names[i]);
	return result;
}

/* Which flags make no sense together: the first one given decides, in this order. */
static bool pads_check_together(const bool given[PADS_FLAGS])
{
	enum { WATCH, RECORD, REPLAY, SECONDS, RUMBLE, DESCRIBE, ID, BUS, BACKEND, JSON };
	static const struct {
		int flag;
		uint32_t without; /* bits of what does not go with it */
	} rules[] = {
		{DESCRIBE, 1u << WATCH | 1u << RECORD | 1u << REPLAY | 1u << SECONDS | 1u << RUMBLE | 1u << BACKEND},
		{REPLAY, 1u << RUMBLE | 1u << BACKEND},
		{WATCH, 1u << JSON},
	};
	for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
		for (int other = 0; given[rules[i].flag] && other < PADS_FLAGS; other++)
			if (given[other] && (rules[i].without >> other & 1)) {
				stilb_log("%s does not go with %s", pads_flag_names[other], pads_flag_names[rules[i].flag]);
				return false;
			}
	if (!given[DESCRIBE] && (given[ID] || given[BUS])) {
		stilb_log("%s is of the descriptor that --describe shows; give --describe FILE", given[ID] ? "--id" : "--bus");
		return false;
	}
	if (given[SECONDS] && !given[WATCH] && !given[RECORD]) {
		stilb_log("--seconds ends --watch and --record; give one of them");
		return false;
	}
	if (given[RECORD] && given[JSON] && !given[REPLAY]) {
		stilb_log("--json does not go with --record; give --replay FILE --json for the JSON of a recording");
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
		stilb_log("--watch shows on standard output, where --record %s writes; give --record a file", o->record);
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
	const flags_result parsed = pads_parse(&o, argc, argv, given);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !pads_check_together(given) || !pads_check_files(&o))
		return EXIT_REFUSED;
	if (o.describe)
		return pads_describe(&o);
	return o.watch || o.record || o.replay ? pads_follow(&o) : pads_list(&o);
}

/* ---- shared -------------------------------------------------------------------------------------------------------- */

FILE *pads_words(const pads_options *o)
{
	if (o->json && stilb_file_is_stdout(o->json))
		return NULL;
	return o->record && stilb_file_is_stdout(o->record) ? stderr : stdout;
}

stilb_result pads_open(const pads_options *o, stilb_input_pads **pads)
{
	const stilb_input_pads_desc desc = {.backend = (stilb_input_backend)o->backend};
	return stilb_input_pads_create(&desc, pads);
}

volatile sig_atomic_t pads_interrupted;

static void pads_on_signal(int signal_number)
{
	(void)signal_number;
	pads_interrupted = 1;
}

void pads_catch_signals(void)
{
	static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
	const struct sigaction once = {.sa_handler = pads_on_signal, .sa_flags = SA_RESETHAND};
	for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
		sigaction(signals[i], &once, NULL);
}

const char *pads_bus_text(uint16_t bus, char text[16])
{
	if (bus == STILB_INPUT_BUS_USB)
		return "USB";
	if (bus == STILB_INPUT_BUS_BLUETOOTH)
		return "Bluetooth";
	snprintf(text, 16, "bus 0x%02x", bus);
	return text;
}

const char *pads_buttons_text(uint32_t buttons, char text[PADS_BUTTONS_SIZE])
{
	size_t length = 0;
	for (int i = 0; i < STILB_INPUT_BUTTON_COUNT; i++)
		if (buttons >> i & 1)
			length += (size_t)snprintf(text + length, PADS_BUTTONS_SIZE - length, "%s%s", length ? "," : "",
			                           stilb_input_button_names[i]);
	if (length == 0)
		snprintf(text, PADS_BUTTONS_SIZE, "-");
	return text;
}

void pads_print_wrapped(FILE *out, const char *title, const char *text)
{
	const size_t indent = strlen(title), room = PADS_COLUMNS - indent;
	fputs(title, out);
	while (strlen(text) > room) {
		size_t length = room;
		while (length > 0 && text[length] != ' ')
			length--;
		if (length == 0) /* a word that is longer than the line */
			length = strcspn(text, " ");
		if (text[length] == '\0')
			break;
		fprintf(out, "%.*s\n%*s", (int)length, text, (int)indent, "");
		text += length + 1;
	}
	fprintf(out, "%s\n", text);
}

const char *pads_recognised_text(const stilb_input_control_pad *pad, char text[PADS_RECOGNISED_SIZE])
{
	const char *own = pad->info->name;
	const size_t length = strlen(own) < 50 ? strlen(own) : 50; /* what a layout's name keeps of it */
	const char after = strncmp(pad->name, own, length) == 0 ? pad->name[length] : '?';
	if (length > 0 && (after == ',' || after == '\0'))
		snprintf(text, PADS_RECOGNISED_SIZE, "%s", pad->recognised);
	else
		snprintf(text, PADS_RECOGNISED_SIZE, "%s: %s", pad->name, pad->recognised);
	return text;
}

bool pads_shakes(const stilb_input_pad_info *info)
{
	static stilb_input_layout layout;
	return stilb_input_layout_find(info, &layout) == STILB_OK && layout.rumble != STILB_INPUT_RUMBLE_NONE;
}

void pads_print_rule(FILE *out, const stilb_input_pad_info *info)
{
	char rule[512];
	fprintf(out,
	        "  no permission to read %s. As root, put this line into\n"
	        "  /etc/udev/rules.d/70-stilb-pads.rules, run 'udevadm control --reload', and plug\n"
	        "  the pad in again:\n\n    %s\n\n",
	        info->path, stilb_input_udev_rule(info, rule, sizeof rule));
}

void pads_json_info(stilb_json *json, const stilb_input_pad_info *info)
{
	char text[16];
	stilb_json_string(json, "path", info->path);
	stilb_json_string(json, "name", info->name);
	stilb_json_string(json, "bus", pads_bus_text(info->bus, text));
	snprintf(text, sizeof text, "%04x", info->vendor);
	stilb_json_string(json, "vendor", text);
	snprintf(text, sizeof text, "%04x", info->product);
	stilb_json_string(json, "product", text);
}
