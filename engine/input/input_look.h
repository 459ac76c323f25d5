/*
 * input_look: what the system knows of the device behind one hidraw node (/dev/hidrawN, Linux's access to a HID device:
 * a gamepad, mouse or keyboard). The node is not opened, so no permission is needed; a few small files of sysfs are
 * read.
 *
 *     stilb_input_pad_info info;
 *     if (stilb_input_look("/dev/hidraw3", &info) == STILB_OK)
 *         printf("%s\n", info.name);
 *
 * Threads.  [any-thread]
 */
#ifndef STILB_INPUT_LOOK_H
#define STILB_INPUT_LOOK_H

#include "input/input_pad.h"

/* path is "/dev/hidraw" and a number. STILB_ERROR_DEVICE: it is another name, there is no such node, or the device was
 * unplugged meanwhile; *info is then unspecified. [any-thread] */
stilb_result stilb_input_look(const char *path, stilb_input_pad_info *info);

#endif
