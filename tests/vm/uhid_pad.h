/*
 * uhid_pad: a pad that is made of software: the kernel is told through /dev/uhid that it was plugged in, and does
 * with it what it does with one of plastic: driver, hidraw node, sysfs, reports. For the tests in the virtual
 * machine.
 *
 * Threads.  A pad has a thread that answers the kernel. The functions belong to one thread, but for send, which may be
 *           another's.
 */
#ifndef STILB_UHID_PAD_H
#define STILB_UHID_PAD_H

#include "support/input_descriptors.h"

#include <stdbool.h>

typedef struct uhid_pad uhid_pad;

/* Plugs one in and waits until the kernel has it. unique is its serial number or Bluetooth address. Ends the program
 * with a message where it fails: the tests are about what comes after. */
uhid_pad *uhid_pad_create(const input_test_descriptor *kind, const char *unique);

/* Pulls it. NULL is fine. */
void uhid_pad_destroy(uhid_pad *pad);

/* It reports. */
void uhid_pad_send(uhid_pad *pad, const uint8_t *report, size_t size);

/* How many of the output reports that it was sent begin with these bytes: drivers of the kernel write their own. */
uint32_t uhid_pad_outputs(uhid_pad *pad, const uint8_t *start, size_t size);

/* Feature reports that it was asked for. */
uint32_t uhid_pad_features(uhid_pad *pad);

#endif
