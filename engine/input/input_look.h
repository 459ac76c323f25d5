/*
 * input_look: what the system says of one hidraw node, pad or not, without opening it and without permission to.
 *
 * Reads a few small files of sysfs. [any-thread]
 */
#ifndef STILB_INPUT_LOOK_H
#define STILB_INPUT_LOOK_H

#include "input/input_pad.h"

/* path is "/dev/hidraw3". STILB_ERROR_DEVICE: it is no such node, or gone. */
stilb_result stilb_input_look(const char *path, stilb_input_pad_info *info);

#endif
