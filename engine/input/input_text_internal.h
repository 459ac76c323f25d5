/*
 * input_text: names from outside (reported by a device, or read from a file) made fit to be shown in terminals and
 * windows and to be written as a line of a text file: valid UTF-8 without control characters.
 *
 * Pure function of its arguments. [any-thread]
 */
#ifndef STILB_INPUT_TEXT_INTERNAL_H
#define STILB_INPUT_TEXT_INTERNAL_H

#include <stddef.h>

/* Copies length bytes of from into to, an array of size > 0 bytes: as many whole characters as fit before the final
 * zero. '?' replaces each byte that is not valid UTF-8 and each control character (C0, DEL, C1). from may be NULL if
 * length is 0. */
void input_text_copy(char *to, size_t size, const char *from, size_t length);

#endif
