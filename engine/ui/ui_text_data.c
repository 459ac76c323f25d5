/* The typefaces, embedded in the program as they are on disk; CMakeLists.txt finds the files. */
#include "ui/ui_internal.h"

/* Defines NAME, which ui_internal.h declares, as the bytes of FILE. */
#define EMBED(NAME, FILE)                                                                                              \
	__asm__(".pushsection .rodata\n"                                                                                   \
	        ".balign 16\n"                                                                                             \
	        ".globl " #NAME "\n"                                                                                       \
	        ".hidden " #NAME "\n" #NAME ":\n"                                                                          \
	        ".incbin \"" FILE "\"\n"                                                                                   \
	        ".popsection")

EMBED(ui_text_sans, UI_FONT_SANS);
EMBED(ui_text_bold, UI_FONT_BOLD);
