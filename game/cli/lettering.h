/* lettering: text in pictures that are computed here, in the typeface of the user interface. [one-writer] */
#ifndef STILB_LETTERING_H
#define STILB_LETTERING_H

#include "image/image.h"
#include "ui/ui.h"

typedef struct lettering lettering;

/* scale as stilb_ui_desc's. STILB_ERROR_ARGUMENT, STILB_ERROR_MEMORY; then *letters is NULL. */
stilb_result lettering_create(float scale, lettering **letters);

/* NULL is fine. */
void lettering_destroy(lettering *letters);

/* Blends text into rect of the picture, which is F32_LINEAR: placed as stilb_ui_draw_text places it, in lines where it
 * has a '\n', and cut short where it is too long. STILB_ERROR_MEMORY. */
stilb_result lettering_write(lettering *letters, stilb_image *picture, stilb_ui_text_kind kind, stilb_ui_rect rect,
                             stilb_ui_align align, stilb_ui_color color, const char *text);

#endif
