/*
 * input_text: names that strangers gave (a pad's own, a file's), made fit for terminals, windows and files of lines: valid
 * UTF-8 without control characters.
 *
 * Pure function of its arguments. [any-thread]
 */
#ifndef STILB_INPUT_TEXT_INTERNAL_H
#define STILB_INPUT_TEXT_INTERNAL_H

#include <stddef.h>

/* Copies length bytes of from into to, which has room for size, size > 0: as many whole characters as fit, and a zero.
 * '?' stands for each byte that is no UTF-8 and for each control character (C0, DEL, C1). */
void input_text_copy(char *to, size_t size, const char *from, size_t length);

#endif
