#include "input/input_look.h"

#include "input/device/input_device_internal.h"

#include <string.h>

stilb_result stilb_input_look(const char *path, stilb_input_pad_info *info)
{
	static const input_roots roots = {.sys = "/sys", .dev = "/dev"};
	static const char start[] = "/dev/hidraw";
	STILB_ASSERT(path && info);
	const char *digits = path + sizeof start - 1;
	if (strncmp(path, start, sizeof start - 1) != 0 || !*digits || digits[strspn(digits, "0123456789")] != '\0')
		return stilb_fail(STILB_ERROR_DEVICE, "'%s' is not the path of a hidraw node like /dev/hidraw3", path);
	int error = input_device_info(&roots, path + strlen("/dev/"), info);
	if (error == 0)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_DEVICE, "cannot look at '%s': %s; 'stilb pads' lists what is plugged in", path,
	                  strerror(-error));
}
