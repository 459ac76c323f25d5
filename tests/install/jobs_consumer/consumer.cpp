// The public headers are valid C++ and link from it.
#include "consumer.c"
