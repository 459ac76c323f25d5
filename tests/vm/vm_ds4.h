/* vm_ds4: input reports of a DualShock 4, each with a number in it by which a test recognises it. */
#ifndef STILB_VM_DS4_H
#define STILB_VM_DS4_H

#include "input/hid/input_layout.h"

#include <string.h>

#define VM_DS4_USB_BYTES 64u
#define VM_DS4_BLUETOOTH_BYTES 78u

/* The pad at rest except for the left stick's y, 0 up, 128 rest, 255 down; the report's time field holds the number. */
static inline void vm_ds4_body(uint32_t number, uint8_t left_y, uint8_t *body)
{
	static const uint8_t rest[] = {128, 128, 128, 128, 8};
	memcpy(body, rest, sizeof rest);
	body[1] = left_y;
	body[9] = (uint8_t)number;
	body[10] = (uint8_t)(number >> 8);
}

static inline size_t vm_ds4_usb(uint32_t number, uint8_t left_y, uint8_t *report)
{
	memset(report, 0, VM_DS4_USB_BYTES);
	report[0] = 0x01;
	vm_ds4_body(number, left_y, report + 1);
	return VM_DS4_USB_BYTES;
}

static inline size_t vm_ds4_bluetooth(uint32_t number, uint8_t left_y, uint8_t *report)
{
	memset(report, 0, VM_DS4_BLUETOOTH_BYTES);
	report[0] = 0x11;
	report[1] = 0xc0;
	vm_ds4_body(number, left_y, report + 3);
	uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, "\xa1", 1), report, VM_DS4_BLUETOOTH_BYTES - 4);
	memcpy(report + VM_DS4_BLUETOOTH_BYTES - 4, &crc, 4);
	return VM_DS4_BLUETOOTH_BYTES;
}

/* The number of a report of either kind; for vm_fixture.number. */
static inline uint32_t vm_ds4_number(const uint8_t *report, size_t size)
{
	if (size == VM_DS4_USB_BYTES && report[0] == 0x01)
		return report[10] | (uint32_t)report[11] << 8;
	if (size == VM_DS4_BLUETOOTH_BYTES && report[0] == 0x11)
		return report[12] | (uint32_t)report[13] << 8;
	return 0;
}

#endif
