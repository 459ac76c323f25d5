/*
 * lettering: text in pictures that are computed on the CPU, in the typeface of the user interface.
 *
 *   lettering *letters;
 *   if (lettering_create(1.0f, &letters) == STILB_OK)
 *       lettering_write(letters, &picture, STILB_UI_TEXT_NORMAL, (stilb_ui_rect){0.0f, 0.0f, 200.0f, 20.0f},
 *                       STILB_UI_ALIGN_LEFT, stilb_ui_rgb(0xffffff), "radiance");
 *   lettering_destroy(letters);
 *
 * Threads.  All [one-writer]: one thread at a time uses a lettering and the picture that it writes into.
 */
#ifndef STILB_LETTERING_H
#define STILB_LETTERING_H

#include "image/image.h"
#include "ui/ui.h"

typedef struct lettering lettering;

/* Renders the glyphs. scale: as stilb_ui_desc's, 1 for letters of the size of the user interface.
 * STILB_ERROR_ARGUMENT: scale; STILB_ERROR_MEMORY. After an error *letters is NULL. */
stilb_result lettering_create(float scale, lettering **letters);

/* letters may be NULL. */
void lettering_destroy(lettering *letters);

/* Blends text into a picture of the format F32_LINEAR. rect is in pixels from the picture's upper left corner; the
 * lines of text, separated by '\n', stand one below another in the middle of its height. A line that is wider than rect
 * is cut short with an ellipsis; a line has at most 255 bytes. color is sRGB; its alpha is the text's opacity.
 * STILB_ERROR_MEMORY: the picture is unchanged. */
stilb_result lettering_write(lettering *letters, stilb_image *picture, stilb_ui_text_kind kind, stilb_ui_rect rect,
                             stilb_ui_align align, stilb_ui_color color, const char *text);

#endif
