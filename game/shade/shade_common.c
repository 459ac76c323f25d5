/* shade_common: what the parts of stilb shade share. */
#include "shade.h"

int shade_complain(int code)
{
	stilb_log("%s", stilb_error_message());
	return code;
}
