/* Hands the draw list to the renderer: copies all triangles once, and adds a draw with the texture of the glyphs for
 * each command of the list. */
#include "ui/ui_internal.h"

#include <stdlib.h>

stilb_result ui_texture_create(stilb_ui *ui, stilb_render *render)
{
	STILB_ASSERT(!ui->render && ui->fonts.coverage);
	size_t count = (size_t)ui->fonts.width * ui->fonts.height;
	uint8_t *pixels = stilb_memory_alloc(count, 4);
	if (!pixels)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the texture of the glyphs");
	for (size_t i = 0; i < count; i++) {
		pixels[4 * i] = pixels[4 * i + 1] = pixels[4 * i + 2] = 255;
		pixels[4 * i + 3] = ui->fonts.coverage[i];
	}
	stilb_image image = {ui->fonts.width, ui->fonts.height, 4, STILB_IMAGE_U8_SRGB, pixels, 0};
	stilb_result result = stilb_render_texture_create(render, &image, &ui->texture);
	free(pixels);
	if (result == STILB_OK)
		ui->render = render;
	return result;
}

static void record_list(const stilb_ui *ui, stilb_render_context *context)
{
	const stilb_ui_draw_list *list = &ui->list;
	if (list->index_count == 0)
		return;
	uint32_t first =
		stilb_render_geometry_2d(context, list->vertices, list->vertex_count, list->indices, list->index_count);
	for (uint32_t i = 0; i < list->command_count; i++) {
		const stilb_ui_draw_command *command = &list->commands[i];
		stilb_render_draw_2d(context, first + command->first_index, command->index_count, command->clip, ui->texture);
	}
}

stilb_result stilb_ui_record(stilb_ui *ui, uint32_t pass, uint32_t worker)
{
	STILB_ASSERT(!ui->in_frame && "after end");
	if (!ui->render)
		return stilb_fail(STILB_ERROR_ARGUMENT, "this user interface was created without a renderer to record for");
	stilb_result result = stilb_render_pass_begin(ui->render, pass, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_context *context = stilb_render_context_get(ui->render, worker);
	stilb_render_segment_begin(context, pass, 0);
	record_list(ui, context);
	stilb_render_segment_end(context);
	result = stilb_render_pass_end(ui->render, pass);
	if (result == STILB_OK && ui->list.out_of_memory)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what the user interface draws");
	return result;
}
