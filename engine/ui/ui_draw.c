/* The draw list: colours, memory, clips, and rectangles, which most drawing is made of. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- colours ----------------------------------------------------------------------------------------------------- */

stilb_ui_color stilb_ui_fade(stilb_ui_color color, float opacity)
{
	color.a = (uint8_t)((float)color.a * ui_clamp(opacity, 0.0f, 1.0f) + 0.5f);
	return color;
}

static uint8_t mix_channel(uint8_t from, uint8_t to, float t)
{
	return (uint8_t)((float)from + ((float)to - (float)from) * t + 0.5f);
}

stilb_ui_color stilb_ui_mix(stilb_ui_color from, stilb_ui_color to, float t)
{
	t = ui_clamp(t, 0.0f, 1.0f);
	return (stilb_ui_color){mix_channel(from.r, to.r, t), mix_channel(from.g, to.g, t), mix_channel(from.b, to.b, t),
	                        mix_channel(from.a, to.a, t)};
}

/* sRGB to linear light by a cubic polynomial with an error below 0.003, which is enough to choose between black and
 * white. */
static float color_linear(uint8_t code)
{
	float c = (float)code / 255.0f;
	return c * (c * (c * 0.305306011f + 0.682171111f) + 0.012522878f);
}

stilb_ui_color stilb_ui_text_color_on(stilb_ui_color background)
{
	float luminance = 0.2126f * color_linear(background.r) + 0.7152f * color_linear(background.g) +
	                  0.0722f * color_linear(background.b);
	/* The contrast to black is (L + 0.05) / 0.05, to white 1.05 / (L + 0.05); they are equal at L = 0.179. */
	return stilb_ui_rgb(luminance > 0.179f ? 0x000000 : 0xffffff);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

bool ui_reserve(void **memory, uint32_t *capacity, uint32_t count, uint32_t more, size_t size)
{
	STILB_ASSERT(count <= *capacity);
	STILB_ASSERT(*memory || *capacity == 0);
	if (more <= *capacity - count)
		return true;
	uint64_t wanted = (uint64_t)count + more, larger = (uint64_t)*capacity * 2;
	if (larger < wanted)
		larger = wanted + 1024;
	void *grown = larger <= UINT32_MAX ? realloc(*memory, larger * size) : NULL;
	if (!grown)
		return false;
	*memory = grown;
	*capacity = (uint32_t)larger;
	return true;
}

/* The command that the next triangles belong to: the last one if it has the current clip, else a new one. NULL: no
 * memory. */
static stilb_ui_draw_command *list_command(stilb_ui_draw_list *list)
{
	stilb_ui_rect clip = stilb_ui_clip(list);
	float wanted[4] = {clip.x0, clip.y0, clip.x1, clip.y1};
	if (list->command_count > 0) {
		stilb_ui_draw_command *last = &list->commands[list->command_count - 1];
		if (memcmp(last->clip, wanted, sizeof wanted) == 0)
			return last;
	}
	if (!ui_reserve((void **)&list->commands, &list->command_capacity, list->command_count, 1, sizeof *list->commands))
		return NULL;
	stilb_ui_draw_command *command = &list->commands[list->command_count++];
	*command = (stilb_ui_draw_command){.first_index = list->index_count};
	memcpy(command->clip, wanted, sizeof wanted);
	return command;
}

bool ui_list_add(stilb_ui_draw_list *list, uint32_t vertex_count, uint32_t index_count, ui_mesh *mesh)
{
	STILB_ASSERT(vertex_count > 0 && index_count > 0 && index_count % 3 == 0);
	stilb_ui_draw_command *command = NULL;
	if (!ui_reserve((void **)&list->vertices, &list->vertex_capacity, list->vertex_count, vertex_count,
	                sizeof *list->vertices) ||
	    !ui_reserve((void **)&list->indices, &list->index_capacity, list->index_count, index_count,
	                sizeof *list->indices) ||
	    !(command = list_command(list))) {
		list->out_of_memory = true;
		return false;
	}
	*mesh = (ui_mesh){list->vertices + list->vertex_count, list->indices + list->index_count, list->vertex_count};
	list->vertex_count += vertex_count;
	list->index_count += index_count;
	command->index_count += index_count;
	return true;
}

bool ui_list_is_sound(const stilb_ui_draw_list *list)
{
	uint32_t index = 0;
	for (uint32_t c = 0; c < list->command_count; c++) {
		const stilb_ui_draw_command *command = &list->commands[c];
		if (command->first_index != index || command->index_count == 0 || command->index_count % 3 != 0 ||
		    (c > 0 && memcmp(command->clip, command[-1].clip, sizeof command->clip) == 0))
			return false;
		index += command->index_count;
	}
	for (uint32_t i = 0; i < list->index_count; i++)
		if (list->indices[i] >= list->vertex_count)
			return false;
	return index == list->index_count && list->vertex_count <= list->vertex_capacity;
}

void stilb_ui_list_begin(stilb_ui_draw_list *list, float width, float height)
{
	STILB_ASSERT(width >= 0.0f && height >= 0.0f);
	list->vertex_count = list->index_count = list->command_count = 0;
	list->out_of_memory = false;
	list->clips[0] = (stilb_ui_rect){0.0f, 0.0f, ceilf(width), ceilf(height)};
	list->clip_count = 1;
}

void stilb_ui_list_finish(stilb_ui_draw_list *list)
{
	if (!list)
		return;
	free(list->vertices);
	free(list->indices);
	free(list->commands);
	*list = (stilb_ui_draw_list){0};
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

stilb_ui_rect stilb_ui_intersection(stilb_ui_rect a, stilb_ui_rect b)
{
	return (stilb_ui_rect){ui_max(a.x0, b.x0), ui_max(a.y0, b.y0), ui_min(a.x1, b.x1), ui_min(a.y1, b.y1)};
}

stilb_ui_rect stilb_ui_clip(const stilb_ui_draw_list *list)
{
	STILB_ASSERT(list->clip_count > 0 && "the list has begun");
	return list->clips[list->clip_count - 1];
}

void stilb_ui_clip_push(stilb_ui_draw_list *list, stilb_ui_rect rect)
{
	STILB_ASSERT(list->clip_count < STILB_UI_CLIP_DEPTH);
	stilb_ui_rect whole = {floorf(rect.x0), floorf(rect.y0), ceilf(rect.x1), ceilf(rect.y1)};
	list->clips[list->clip_count] = stilb_ui_intersection(whole, stilb_ui_clip(list));
	list->clip_count++;
}

void stilb_ui_clip_pop(stilb_ui_draw_list *list)
{
	STILB_ASSERT(list->clip_count > 1 && "a clip was pushed");
	list->clip_count--;
}

bool ui_list_sees(const stilb_ui_draw_list *list, float x0, float y0, float x1, float y1)
{
	stilb_ui_rect clip = stilb_ui_clip(list);
	return x1 > clip.x0 && x0 < clip.x1 && y1 > clip.y0 && y0 < clip.y1 && clip.x1 > clip.x0 && clip.y1 > clip.y0;
}

/* ---- rectangles -------------------------------------------------------------------------------------------------- */

/* Fills quadrilateral number `quad` of a mesh made of quadrilaterals: four vertices and six indices each. */
static void mesh_quad(const ui_mesh *mesh, size_t quad, stilb_ui_rect rect, stilb_ui_color color)
{
	stilb_render_vertex_2d *vertices = mesh->vertices + 4 * quad;
	uint32_t first = mesh->first + 4 * (uint32_t)quad;
	vertices[0] = ui_vertex(rect.x0, rect.y0, color);
	vertices[1] = ui_vertex(rect.x1, rect.y0, color);
	vertices[2] = ui_vertex(rect.x1, rect.y1, color);
	vertices[3] = ui_vertex(rect.x0, rect.y1, color);
	ui_quad_indices(mesh->indices + 6 * quad, first, first + 1, first + 2, first + 3);
}

/* Consecutive pixels along one axis that are covered by the same share. */
typedef struct draw_slice {
	float from, to; /* pixel boundaries between which the pixels lie */
	float share;    /* how much of each is covered, 0..1 */
} draw_slice;

/* Cuts the interval [from, to] at pixel boundaries into the pixels at its ends, which it covers in part, and those
 * between, which it covers wholly. Returns the number of slices, 1..3. */
static uint32_t slice_pixels(float from, float to, draw_slice slices[3])
{
	STILB_ASSERT(from < to);
	float first = floorf(from), last = floorf(to);
	uint32_t count = 0;
	if (first == last) {
		slices[count++] = (draw_slice){first, first + 1.0f, to - from};
		return count;
	}
	if (from > first) {
		slices[count++] = (draw_slice){first, first + 1.0f, first + 1.0f - from};
		first += 1.0f;
	}
	if (last > first)
		slices[count++] = (draw_slice){first, last, 1.0f};
	if (to > last)
		slices[count++] = (draw_slice){last, last + 1.0f, to - last};
	return count;
}

/* The share of a pixel that a rectangle covers is the product of the shares that it covers across and down. So it is
 * cut along pixel boundaries into at most nine parts, in each of which all pixels have the same share, and is drawn
 * exactly. */
static void draw_rect_exact(stilb_ui_draw_list *list, stilb_ui_rect rect, stilb_ui_color color)
{
	draw_slice across[3], down[3];
	uint32_t columns = slice_pixels(rect.x0, rect.x1, across), rows = slice_pixels(rect.y0, rect.y1, down);
	ui_mesh mesh;
	if (!ui_list_add(list, 4 * columns * rows, 6 * columns * rows, &mesh))
		return;
	for (uint32_t y = 0; y < rows; y++)
		for (uint32_t x = 0; x < columns; x++)
			mesh_quad(&mesh, y * columns + x, (stilb_ui_rect){across[x].from, down[y].from, across[x].to, down[y].to},
			          stilb_ui_fade(color, across[x].share * down[y].share));
}

void stilb_ui_draw_rect(stilb_ui_draw_list *list, stilb_ui_rect rect, stilb_ui_color color)
{
	if (stilb_ui_is_empty(rect) || !ui_list_sees(list, rect.x0 - 1.0f, rect.y0 - 1.0f, rect.x1 + 1.0f, rect.y1 + 1.0f))
		return;
	if (list->aa == STILB_UI_AA_ARTICLE) {
		stilb_ui_point corners[4] = {{rect.x0, rect.y0}, {rect.x1, rect.y0}, {rect.x1, rect.y1}, {rect.x0, rect.y1}};
		stilb_ui_draw_convex(list, corners, 4, color);
		return;
	}
	rect = stilb_ui_intersection(rect, stilb_ui_clip(list)); /* clips end at whole pixels: what is left is unchanged */
	if (stilb_ui_is_empty(rect))
		return;
	ui_mesh mesh;
	if (list->aa == STILB_UI_AA_FEATHER)
		draw_rect_exact(list, rect, color);
	else if (ui_list_add(list, 4, 6, &mesh))
		mesh_quad(&mesh, 0, rect, color);
}

void stilb_ui_draw_rect_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float width, stilb_ui_color color)
{
	width = ui_min(width, 0.5f * ui_min(rect.x1 - rect.x0, rect.y1 - rect.y0));
	if (!(width > 0.0f))
		return;
	stilb_ui_rect inside = stilb_ui_inset(rect, width);
	stilb_ui_draw_rect(list, (stilb_ui_rect){rect.x0, rect.y0, rect.x1, inside.y0}, color);
	stilb_ui_draw_rect(list, (stilb_ui_rect){rect.x0, inside.y1, rect.x1, rect.y1}, color);
	stilb_ui_draw_rect(list, (stilb_ui_rect){rect.x0, inside.y0, inside.x0, inside.y1}, color);
	stilb_ui_draw_rect(list, (stilb_ui_rect){inside.x1, inside.y0, rect.x1, inside.y1}, color);
}
