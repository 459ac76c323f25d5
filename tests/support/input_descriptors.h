/* input_descriptors: the HID report descriptors of real pads, as they were read from them by others; the source of each
 * stands at its bytes. */
#ifndef STILB_INPUT_DESCRIPTORS_H
#define STILB_INPUT_DESCRIPTORS_H

#include <stddef.h>
#include <stdint.h>

typedef struct input_test_descriptor {
	const char *name; /* "DualShock 4, USB" */
	const uint8_t *bytes;
	size_t size;
	uint16_t bus, vendor, product;
} input_test_descriptor;

extern const input_test_descriptor input_test_descriptors[];
extern const size_t input_test_descriptor_count;

/* The first of these; NULL: there is none. */
const input_test_descriptor *input_test_descriptor_find(uint16_t bus, uint16_t vendor, uint16_t product);

#endif
