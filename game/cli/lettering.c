#include "lettering.h"

#include "shading/shade_srgb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct lettering {
	stilb_ui *ui; /* owns the glyphs */
	stilb_ui_draw_list list;
};

stilb_result lettering_create(float scale, lettering **letters)
{
	stilb_ui_desc desc = stilb_ui_desc_default();
	desc.scale = scale;
	STILB_ASSERT(letters);
	*letters = calloc(1, sizeof **letters);
	if (!*letters)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the letters of a picture");
	stilb_result result = stilb_ui_create(&desc, &(*letters)->ui);
	if (result != STILB_OK) {
		free(*letters);
		*letters = NULL;
	}
	return result;
}

void lettering_destroy(lettering *letters)
{
	if (!letters)
		return;
	stilb_ui_list_finish(&letters->list);
	stilb_ui_destroy(letters->ui);
	free(letters);
}

/* Blends one glyph into the part of the picture inside clip, which is x0, y0, x1, y1 in pixels. The glyph's corners lie
 * on pixels, and each texel of its coverage is one pixel: nothing is resampled. */
static void blend_glyph(const stilb_ui *ui, stilb_image *picture, const float clip[4],
                        const stilb_render_vertex_2d *corners)
{
	uint32_t width, height;
	const uint8_t *coverage = stilb_ui_glyphs(ui, &width, &height);
	const stilb_render_vertex_2d *first = &corners[0], *last = &corners[2];
	float color[3], alpha = (float)first->color[3] / 255.0f;
	for (uint32_t k = 0; k < 3; k++)
		color[k] = shade_srgb_to_linear((float)first->color[k] / 255.0f);
	uint32_t u = (uint32_t)(first->uv[0] * (float)width + 0.5f), v = (uint32_t)(first->uv[1] * (float)height + 0.5f);
	int32_t left = (int32_t)first->position[0], top = (int32_t)first->position[1];
	int32_t right = (int32_t)last->position[0], bottom = (int32_t)last->position[1];
	for (int32_t y = top; y < bottom; y++)
		for (int32_t x = left; x < right; x++) {
			if ((float)x < clip[0] || (float)y < clip[1] || (float)x >= clip[2] || (float)y >= clip[3])
				continue;
			uint32_t row = v + (uint32_t)(y - top), column = u + (uint32_t)(x - left);
			float share = alpha * (float)coverage[row * width + column] / 255.0f;
			float *pixel = (float *)picture->pixels + ((size_t)y * picture->width + (size_t)x) * picture->channels;
			for (uint32_t k = 0; k < 3 && k < picture->channels; k++)
				pixel[k] += share * (color[k] - pixel[k]);
		}
}

/* Blends all glyphs of the list, which holds nothing else: each has four vertices and six indices, the first of which
 * names its upper left corner. */
static void blend(lettering *letters, stilb_image *picture)
{
	const stilb_ui_draw_list *list = &letters->list;
	for (uint32_t d = 0; d < list->command_count; d++) {
		const stilb_ui_draw_command *command = &list->commands[d];
		for (uint32_t i = 0; i < command->index_count; i += 6)
			blend_glyph(letters->ui, picture, command->clip, &list->vertices[list->indices[command->first_index + i]]);
	}
}

stilb_result lettering_write(lettering *letters, stilb_image *picture, stilb_ui_text_kind kind, stilb_ui_rect rect,
                             stilb_ui_align align, stilb_ui_color color, const char *text)
{
	STILB_ASSERT(picture->format == STILB_IMAGE_F32_LINEAR && picture->pixels);
	const stilb_ui_font *font = stilb_ui_font_get(letters->ui, kind);
	uint32_t lines = 1;
	for (const char *c = text; *c; c++)
		lines += *c == '\n';
	float line = stilb_ui_font_line(font);
	float top = 0.5f * (rect.y0 + rect.y1 - line * (float)lines);
	stilb_ui_list_begin(&letters->list, (float)picture->width, (float)picture->height);
	for (const char *at = text; lines-- > 0; top += line) {
		char words[256];
		size_t length = strcspn(at, "\n");
		snprintf(words, sizeof words, "%.*s", (int)length, at);
		at += length + 1;
		stilb_ui_rect place = {rect.x0, top, rect.x1, top + line};
		stilb_ui_draw_text(&letters->list, font, place, align, color, words);
	}
	if (letters->list.out_of_memory)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the letters of a picture");
	blend(letters, picture);
	return STILB_OK;
}
