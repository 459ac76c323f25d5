/* The typefaces, put into the program as they are on disk: CMakeLists.txt finds them. */
#include "ui/ui_internal.h"

/* NAME and NAME_end around the bytes of FILE; extern in ui_internal.h. */
#define EMBED(NAME, FILE)                                                                                              \
	__asm__(".pushsection .rodata\n"                                                                                   \
	        ".balign 16\n"                                                                                             \
	        ".globl " #NAME "\n"                                                                                       \
	        ".hidden " #NAME "\n" #NAME ":\n"                                                                          \
	        ".incbin \"" FILE "\"\n"                                                                                   \
	        ".globl " #NAME "_end\n"                                                                                   \
	        ".hidden " #NAME "_end\n" #NAME "_end:\n"                                                                  \
	        ".byte 0\n"                                                                                                \
	        ".popsection")

EMBED(ui_text_sans, UI_FONT_SANS);
EMBED(ui_text_bold, UI_FONT_BOLD);
