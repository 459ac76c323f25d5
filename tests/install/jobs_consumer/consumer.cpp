// The public headers are valid C++, and a C++ program can be linked with the library.
#include "consumer.c"
