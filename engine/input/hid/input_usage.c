/* Usages as words, for people who read a descriptor. Source: HID Usage Tables 1.12, sections 3 to 15. */
#include "input/hid/input_descriptor.h"

#include <stdio.h>

typedef struct usage_name {
	uint32_t usage; /* page << 16 | usage; in usage_pages the page alone */
	const char *name;
} usage_name;

static const usage_name usage_pages[] = {
	{0x01, "Generic Desktop"},
	{0x02, "Simulation"},
	{0x03, "VR"},
	{0x04, "Sport"},
	{0x05, "Game"},
	{0x06, "Generic Device"},
	{0x07, "Keyboard"},
	{0x08, "LED"},
	{0x09, "Button"},
	{0x0a, "Ordinal"},
	{0x0b, "Telephony"},
	{0x0c, "Consumer"},
	{0x0d, "Digitizer"},
	{0x0f, "Physical Input Device"},
	{0x14, "Alphanumeric Display"},
	{0x20, "Sensor"},
	{0x40, "Medical"},
	{0x84, "Power"},
	{0x85, "Battery System"},
};

static const usage_name usage_names[] = {
	{0x10001, "Pointer"},
	{0x10002, "Mouse"},
	{0x10004, "Joystick"},
	{0x10005, "Game Pad"},
	{0x10006, "Keyboard"},
	{0x10007, "Keypad"},
	{0x10008, "Multi-axis Controller"},
	{0x10030, "X"},
	{0x10031, "Y"},
	{0x10032, "Z"},
	{0x10033, "Rx"},
	{0x10034, "Ry"},
	{0x10035, "Rz"},
	{0x10036, "Slider"},
	{0x10037, "Dial"},
	{0x10038, "Wheel"},
	{0x10039, "Hat switch"},
	{0x1003d, "Start"},
	{0x1003e, "Select"},
	{0x10040, "Vx"},
	{0x10041, "Vy"},
	{0x10042, "Vz"},
	{0x10043, "Vbrx"},
	{0x10044, "Vbry"},
	{0x10045, "Vbrz"},
	{0x10080, "System Control"},
	{0x10085, "System Main Menu"},
	{0x10090, "D-pad Up"},
	{0x10091, "D-pad Down"},
	{0x10092, "D-pad Right"},
	{0x10093, "D-pad Left"},
	{0x200ba, "Rudder"},
	{0x200bb, "Throttle"},
	{0x200c4, "Accelerator"},
	{0x200c5, "Brake"},
	{0x200c8, "Steering"},
	{0x60020, "Battery Strength"},
	{0xc0001, "Consumer Control"},
	{0xc00b2, "Record"},
	{0xc0223, "AC Home"},
	{0xc0224, "AC Back"},
};

static const char *usage_find(const usage_name *names, size_t count, uint32_t usage)
{
	for (size_t i = 0; i < count; i++)
		if (names[i].usage == usage)
			return names[i].name;
	return NULL;
}

const char *stilb_input_usage_text(uint32_t usage, char *text, size_t size)
{
	STILB_ASSERT(text && size > 0);
	uint32_t page = usage >> 16, id = usage & 0xffff;
	const char *page_name = usage_find(usage_pages, sizeof usage_pages / sizeof *usage_pages, page);
	const char *name = usage_find(usage_names, sizeof usage_names / sizeof *usage_names, usage);
	if (usage == 0)
		snprintf(text, size, "none");
	else if (!page_name)
		snprintf(text, size, "0x%04x / 0x%02x", page, id);
	else if (name)
		snprintf(text, size, "%s / %s", page_name, name);
	else
		snprintf(text, size, page == 0x09 ? "%s / %u" : "%s / 0x%02x", page_name, id);
	return text;
}
