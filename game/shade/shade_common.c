/* The function that the parts of stilb shade share; see shade.h. */
#include "shade.h"

int shade_complain(int code)
{
	stilb_log("%s", stilb_error_message());
	return code;
}
