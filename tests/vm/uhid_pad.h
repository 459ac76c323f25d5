/*
 * uhid_pad: a simulated pad. It is plugged in through /dev/uhid, and the kernel treats it like hardware: driver, hidraw
 * node, sysfs, reports. For the tests in the virtual machine.
 *
 * Threads.  A pad has a thread that answers the kernel. All functions are called by one thread, except that send may be
 *           called by another.
 */
#ifndef STILB_UHID_PAD_H
#define STILB_UHID_PAD_H

#include "support/input_descriptors.h"

#include <stdbool.h>

typedef struct uhid_pad uhid_pad;

/* Plugs a pad in and waits until the kernel has it. unique is its serial number or Bluetooth address. A failure ends
 * the program with a message, because it is not what is tested. */
uhid_pad *uhid_pad_create(const input_test_descriptor *kind, const char *unique);

/* Unplugs the pad. NULL is allowed. */
void uhid_pad_destroy(uhid_pad *pad);

/* Sends a report. */
void uhid_pad_send(uhid_pad *pad, const uint8_t *report, size_t size);

/* Number of output reports sent to the pad that begin with these bytes; the kernel's drivers may send others. */
uint32_t uhid_pad_outputs(uhid_pad *pad, const uint8_t *start, size_t size);

/* Number of feature reports that were requested. */
uint32_t uhid_pad_features(uhid_pad *pad);

#endif
