/* Functions that the parts of stilb pads share; see pads.h. */
#include "pads.h"

#include "base/base_file.h"

#include <string.h>

const char *const pads_backends[] = {"hidraw", "hidapi", NULL};

FILE *pads_message_stream(const pads_options *o)
{
	if (o->json && stilb_file_is_stdout(o->json))
		return NULL;
	return o->record && stilb_file_is_stdout(o->record) ? stderr : stdout;
}

stilb_result pads_open(const pads_options *o, stilb_input_pads **pads)
{
	stilb_input_pads_desc desc = {.backend = (stilb_input_backend)o->backend};
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
	struct sigaction once = {.sa_handler = pads_on_signal, .sa_flags = SA_RESETHAND};
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
	STILB_ASSERT(strlen(title) < PADS_COLUMNS);
	size_t indent = strlen(title), room = PADS_COLUMNS - indent;
	fputs(title, out);
	while (strlen(text) > room) {
		size_t length = room;
		while (length > 0 && text[length] != ' ')
			length--;
		if (length == 0) /* a word longer than the line */
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
	size_t length = strlen(own) < 50 ? strlen(own) : 50; /* a layout's name repeats at most 50 bytes of the pad's */
	bool repeated = length > 0 && strncmp(pad->name, own, length) == 0;
	if (repeated && (pad->name[length] == ',' || pad->name[length] == '\0'))
		snprintf(text, PADS_RECOGNISED_SIZE, "%s", pad->recognised);
	else
		snprintf(text, PADS_RECOGNISED_SIZE, "%s: %s", pad->name, pad->recognised);
	return text;
}

bool pads_has_rumble(const stilb_input_pad_info *info)
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
