/* What a frame shows where no model is: drawn before its first pass, by one triangle over the whole picture. A backdrop
 * of one colour needs none: the light is cleared to it. */
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

/* As the shader's buffer. */
typedef struct backdrop_data {
	float ahead[4], across[4], down[4];
	float camera[4];
	float color[4];
	float floor_radius[4];
	float sky[4], ground[4]; /* [3] of the sky: 1: these two are shown, else 0 */
	float covered[STILB_SCENE_FLOOR_SIDE][STILB_SCENE_FLOOR_SIDE];
	float map[STILB_SCENE_BACKDROP_HEIGHT * STILB_SCENE_BACKDROP_WIDTH][4];
	uint32_t size[2];  /* of the panorama; 0: it is not shown */
	float turn[2];     /* sine and cosine of its rotation */
	uint64_t panorama; /* its texels */
} backdrop_data;

static_assert(STILB_SCENE_FLOOR_SIDE == 64 && STILB_SCENE_BACKDROP_HEIGHT == 32 && STILB_SCENE_BACKDROP_WIDTH == 64,
              "as in backdrop.frag");

/* ---- what is seen ------------------------------------------------------------------------------------------------ */

/* Sets out to what a step of 1 in clip space along an axis, a row of the matrix from world to clip space, adds to a
 * direction: rows are the camera's axes, scaled. */
static void backdrop_axis(const float matrix[16], size_t row, float out[4])
{
	float square = 0.0f;
	for (size_t i = 0; i < 3; i++)
		square += matrix[4 * i + row] * matrix[4 * i + row];
	for (size_t i = 0; i < 3; i++)
		out[i] = matrix[4 * i + row] / square;
	out[3] = 0.0f;
}

/* Which of the two colours a view shows at the corners of its picture. */
typedef struct backdrop_sides {
	bool sky, ground;
} backdrop_sides;

static backdrop_sides backdrop_sides_of(const stilb_render_view *view)
{
	float ahead[4], across[4], down[4];
	backdrop_sides sides = {false, false};
	backdrop_axis(view->view_projection.m, 3, ahead);
	backdrop_axis(view->view_projection.m, 0, across);
	backdrop_axis(view->view_projection.m, 1, down);
	for (int corner = 0; corner < 4; corner++) {
		float height = ahead[1] + (corner & 1 ? across[1] : -across[1]) + (corner & 2 ? down[1] : -down[1]);
		sides.sky |= height >= 0.0f;
		sides.ground |= height < 0.0f;
	}
	return sides;
}

bool render_backdrop_is_drawn(const stilb_render_view *view, const render_panorama *panorama)
{
	const stilb_scene_backdrop *backdrop = &view->backdrop;
	if (backdrop->kind == STILB_SCENE_BACKDROP_SURROUNDINGS) {
		backdrop_sides sides = backdrop_sides_of(view);
		bool differ = memcmp(view->surroundings.sky, view->surroundings.ground, sizeof view->surroundings.sky) != 0;
		return panorama || (differ && sides.sky && sides.ground);
	}
	return (backdrop->kind == STILB_SCENE_BACKDROP_MAP && backdrop->map) ||
	       (backdrop->kind == STILB_SCENE_BACKDROP_COLOR && backdrop->floor);
}

void render_backdrop_clear(const stilb_render_view *view, float color[4])
{
	const stilb_scene_backdrop *backdrop = &view->backdrop;
	memset(color, 0, 4 * sizeof *color);
	if (backdrop->kind == STILB_SCENE_BACKDROP_NOTHING)
		return;
	backdrop_sides sides = backdrop_sides_of(view);
	const float *around = sides.ground && !sides.sky ? view->surroundings.ground : view->surroundings.sky;
	const float *shown = backdrop->kind == STILB_SCENE_BACKDROP_COLOR ? backdrop->color : around;
	memcpy(color, shown, 3 * sizeof *color);
	color[3] = 1.0f;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

static void backdrop_write(const render_device *device, const stilb_render_view *view, const render_panorama *panorama,
                           backdrop_data *out)
{
	const stilb_scene_backdrop *from = &view->backdrop;
	backdrop_axis(view->view_projection.m, 3, out->ahead); /* a unit row: where the camera looks */
	backdrop_axis(view->view_projection.m, 0, out->across);
	backdrop_axis(view->view_projection.m, 1, out->down);
	memcpy(out->camera, view->camera_position, sizeof view->camera_position);
	memcpy(out->color, from->color, sizeof from->color);
	memset(out->floor_radius, 0, sizeof out->floor_radius);
	if (from->kind == STILB_SCENE_BACKDROP_COLOR) {
		memcpy(out->floor_radius, from->floor->center, sizeof from->floor->center);
		out->floor_radius[3] = from->floor->radius;
		memcpy(out->covered, from->floor->covered, sizeof out->covered);
		return;
	}
	memset(out->size, 0, sizeof out->size);
	memcpy(out->sky, view->surroundings.sky, sizeof view->surroundings.sky);
	memcpy(out->ground, view->surroundings.ground, sizeof view->surroundings.ground);
	out->sky[3] = from->kind == STILB_SCENE_BACKDROP_SURROUNDINGS && !panorama ? 1.0f : 0.0f;
	out->ground[3] = 0.0f;
	if (out->sky[3] > 0.0f)
		return;
	if (from->kind == STILB_SCENE_BACKDROP_SURROUNDINGS) {
		out->size[0] = panorama->width;
		out->size[1] = panorama->height;
		out->turn[0] = sinf(view->surroundings.rotation);
		out->turn[1] = cosf(view->surroundings.rotation);
		out->panorama = device->panorama.address + sizeof(render_panorama_table);
		return;
	}
	for (size_t i = 0; i < sizeof out->map / sizeof *out->map; i++)
		memcpy(out->map[i], from->map + 3 * i, sizeof(float[3]));
}

stilb_result render_backdrop_write(render_device *device, const stilb_render_view *view,
                                   const render_panorama *panorama, uint64_t *address)
{
	render_buffer *buffer = &render_slot_now(device)->backdrops[device->frame.backdrops++];
	STILB_ASSERT(device->frame.backdrops <= STILB_RENDER_MAX_PASSES && render_backdrop_is_drawn(view, panorama));
	stilb_result result = STILB_OK;
	if (!buffer->mapped)
		result = render_buffer_make(device, "backdrop", sizeof(backdrop_data), STILB_GPU_MEMORY_WRITE,
		                            STILB_GPU_BUFFER_ADDRESS, buffer);
	if (result == STILB_OK)
		backdrop_write(device, view, panorama, buffer->mapped);
	*address = buffer->address;
	return result;
}
