/* What a frame shows where no model is: drawn before its first pass, by one triangle over the whole picture. A backdrop
 * of one colour needs none: the light is cleared to it. */
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

/* As the shader's buffer, of a floor and of a map. */
typedef struct backdrop_data {
	float covered[STILB_SCENE_FLOOR_SIDE][STILB_SCENE_FLOOR_SIDE];
	float map[STILB_SCENE_BACKDROP_HEIGHT * STILB_SCENE_BACKDROP_WIDTH][4];
} backdrop_data;

static_assert(sizeof(render_backdrop_push) == 120, "std430");
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
		out[i] = square > 0.0f ? matrix[4 * i + row] / square : 0.0f; /* parallel views look nowhere */
	out[3] = 0.0f;
}

void render_backdrop_axes(const stilb_render_view *view, float ahead[4], float across[4], float down[4])
{
	stilb_mat4 straight = stilb_render_view_drawn(view);
	float *m = straight.m, shift[2];
	backdrop_axis(m, 3, ahead);   /* a unit row: where the camera looks */
	for (int r = 0; r < 2; r++) { /* by how much the middle of the picture lies beside it */
		shift[r] = m[r] * ahead[0] + m[4 + r] * ahead[1] + m[8 + r] * ahead[2];
		for (int c = 0; c < 3; c++)
			m[4 * c + r] -= shift[r] * m[4 * c + 3];
	}
	backdrop_axis(m, 0, across);
	backdrop_axis(m, 1, down);
	for (int c = 0; c < 3; c++)
		ahead[c] -= shift[0] * across[c] + shift[1] * down[c];
}

/* Which of the two colours a view shows at the corners of its picture. */
typedef struct backdrop_sides {
	bool sky, ground;
} backdrop_sides;

static backdrop_sides backdrop_sides_of(const stilb_render_view *view)
{
	float ahead[4], across[4], down[4];
	backdrop_sides sides = {false, false};
	render_backdrop_axes(view, ahead, across, down);
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

/* The buffer of the next backdrop of the frame. */
static stilb_result backdrop_buffer(render_device *device, render_buffer **buffer)
{
	*buffer = &render_slot_now(device)->backdrops[device->frame.backdrops++];
	STILB_ASSERT(device->frame.backdrops <= STILB_RENDER_MAX_PASSES);
	return (*buffer)->mapped ? STILB_OK
	                         : render_buffer_make(device, "backdrop", sizeof(backdrop_data), STILB_GPU_MEMORY_WRITE,
	                                              STILB_GPU_BUFFER_ADDRESS, *buffer);
}

static void backdrop_write_floor(const stilb_render_view *view, backdrop_data *data, render_backdrop_push *push)
{
	const stilb_scene_backdrop *from = &view->backdrop;
	memcpy(push->camera, view->camera_position, sizeof view->camera_position);
	memcpy(push->color, from->color, sizeof from->color);
	memcpy(push->floor_radius, from->floor->center, sizeof from->floor->center);
	push->floor_radius[3] = from->floor->radius;
	memcpy(data->covered, from->floor->covered, sizeof data->covered);
}

stilb_result render_backdrop_write(render_device *device, const stilb_render_view *view,
                                   const render_panorama *panorama, render_backdrop_push *push)
{
	STILB_ASSERT(render_backdrop_is_drawn(view, panorama));
	render_backdrop_kind kind = render_backdrop_kind_of(view, panorama);
	*push = (render_backdrop_push){.turn = {sinf(view->surroundings.rotation), cosf(view->surroundings.rotation)},
	                               .exposure = exp2f(view->exposure)};
	render_backdrop_axes(view, push->ahead, push->across, push->down);
	if (kind == RENDER_BACKDROP_SKY) {
		memcpy(push->color, view->surroundings.sky, sizeof view->surroundings.sky);
		memcpy(push->floor_radius, view->surroundings.ground, sizeof view->surroundings.ground);
		return STILB_OK;
	}
	if (kind == RENDER_BACKDROP_PANORAMA)
		return STILB_OK;
	render_buffer *buffer;
	stilb_result result = backdrop_buffer(device, &buffer);
	if (result != STILB_OK)
		return result;
	backdrop_data *data = buffer->mapped;
	push->data = buffer->address;
	if (kind == RENDER_BACKDROP_FLOOR)
		backdrop_write_floor(view, data, push);
	else
		for (size_t i = 0; i < sizeof data->map / sizeof *data->map; i++)
			memcpy(data->map[i], view->backdrop.map + 3 * i, sizeof(float[3]));
	return STILB_OK;
}
