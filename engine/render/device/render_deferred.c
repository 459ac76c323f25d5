/* Deferred lighting: surfaces are drawn into images, with the radiance that comes from no light; then a pass over the
 * picture adds that of the lights. Source: Deering and others, "The Triangle Processor and Normal Vector Shader"
 * (1988); Karis, "Deferred rendering 2" (2009). */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEFERRED_FAR 1000.0f /* metres, of views that end nowhere */

static const char *const deferred_images[RENDER_GBUFFER_IMAGES] = {
	STILB_RENDER_IMAGE_NORMAL, STILB_RENDER_IMAGE_DIFFUSE, STILB_RENDER_IMAGE_SPECULAR};

/* Of PRELIGHT; PREPASS has the first one alone. */
static const char *const apart_images[RENDER_APART_IMAGES] = {STILB_RENDER_IMAGE_SCATTERED,
                                                              STILB_RENDER_IMAGE_HIGHLIGHTS};

float render_deferred_far(const stilb_render_view *view)
{
	/* Clip z and w are rows 2 and 3 of the matrix; where z is 0 is far. slope: z's change along the view. */
	const float *m = view->view_projection.m;
	float along = m[3] * m[3] + m[7] * m[7] + m[11] * m[11];
	float slope = m[2] * m[3] + m[6] * m[7] + m[10] * m[11];
	float at =
		m[2] * view->camera_position[0] + m[6] * view->camera_position[1] + m[10] * view->camera_position[2] + m[14];
	if (!(along > 0.0f))
		return m[15]; /* a parallel view */
	float far = -at * along / slope;
	return far > 0.0f && isfinite(far) ? far : DEFERRED_FAR * sqrtf(along);
}

void render_deferred_attach(render_device *device, const stilb_render_view *view, render_frame_target *target,
                            stilb_gpu_pass *row)
{
	bool apart = render_view_way(device, view).apart;
	uint32_t bits = render_gbuffer_bits(view, 0), first = apart ? 0 : 1, count = apart ? 1 : RENDER_GBUFFER_IMAGES;
	const stilb_gpu_format *formats =
		render_gbuffer_formats[bits & RENDER_LIGHTS_GBUFFER8 ? STILB_RENDER_GBUFFER_RGBA8 : STILB_RENDER_GBUFFER_WIDE];
	for (uint32_t i = 0; i < count; i++) {
		target->surfaces[i] = render_target_image(device, target, deferred_images[i], formats[1 + i], false);
		row->color[first + i] = (stilb_gpu_attachment){.image = target->surfaces[i], .load = STILB_GPU_LOAD_DISCARD};
	}
	row->color_count = (uint8_t)(first + count);
}

void render_deferred_use(const render_frame_target *target, uint8_t slot, stilb_gpu_pass *row)
{
	for (uint8_t i = 0; i < RENDER_APART_IMAGES; i++)
		row->uses[row->use_count++] =
			(stilb_gpu_use){.resource = target->apart[i], .how = STILB_GPU_USE_SAMPLED, .slot = (uint16_t)(slot + i)};
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* Where x / w or y / w of clip space lies for a sphere: the planes through the eye that touch it. row: of x or y, w: of
 * w. The distance of the centre c from the plane row - t w is r: (a - t b)^2 = r^2 |row - t w|^2. */
static bool deferred_span(const double row[4], const double w[4], const double center[3], double radius, double span[2])
{
	double a = row[3], b = w[3], A = 0.0, B = 0.0, C = 0.0;
	for (int i = 0; i < 3; i++) {
		a += row[i] * center[i];
		b += w[i] * center[i];
		A += row[i] * row[i];
		B += row[i] * w[i];
		C += w[i] * w[i];
	}
	double square = radius * radius, q = b * b - square * C, half = a * b - square * B;
	double root = half * half - q * (a * a - square * A);
	span[0] = -1.0;
	span[1] = 1.0;
	if (b < 0.0 && q > 0.0)
		return false; /* behind the viewer */
	if (!(q > 0.0) || !(root >= 0.0))
		return true; /* around the viewer */
	span[0] = fmax((half - sqrt(root)) / q, -1.0);
	span[1] = fmin((half + sqrt(root)) / q, 1.0);
	return span[0] < span[1];
}

/* The rectangle of pixels, of a picture of this size, that a light with a reach may light. False: none. */
static bool deferred_rectangle(const stilb_mat4 *matrix, const render_light *light, uint32_t width, uint32_t height,
                               uint16_t area[4])
{
	const uint32_t sizes[2] = {width, height};
	double rows[4][4], center[3];
	for (int r = 0; r < 4; r++)
		for (int c = 0; c < 4; c++)
			rows[r][c] = (double)matrix->m[4 * c + r];
	for (int i = 0; i < 3; i++)
		center[i] = (double)light->position[i];
	for (int axis = 0; axis < 2; axis++) {
		double span[2], size = (double)sizes[axis];
		if (!deferred_span(rows[axis], rows[3], center, (double)light->reach * 1.0001, span))
			return false;
		double first = floor((span[0] * 0.5 + 0.5) * size), end = ceil((span[1] * 0.5 + 0.5) * size);
		if (!(first < end))
			return false;
		area[axis] = (uint16_t)first;
		area[2 + axis] = (uint16_t)(end - first);
	}
	return true;
}

/* What the rows of a view's lights share. */
typedef struct deferred_rows {
	render_device *device;
	render_frame_target *target;
	const render_push *push;
	stilb_gpu_program program;
	stilb_gpu_use shadows;      /* render_shadow_use */
	const stilb_gpu_use *tiles; /* NULL: no lists of them */
	uint32_t bits;              /* render_deferred_bits */
	bool begun;                 /* of RENDER_LIGHTS_APART: the images have content */
} deferred_rows;

/* What the rows draw into, besides what is there. */
static void deferred_colors(deferred_rows *rows, stilb_gpu_pass *row)
{
	render_frame_target *target = rows->target;
	bool apart = rows->bits & RENDER_LIGHTS_APART;
	row->color_count = (uint8_t)render_deferred_colors(rows->bits);
	row->color[0] = (stilb_gpu_attachment){.image = target->color, .load = STILB_GPU_LOAD_KEEP};
	for (uint32_t i = 0; i < RENDER_APART_IMAGES && i < row->color_count && apart; i++) {
		if (target->apart[i] == 0)
			target->apart[i] = render_target_image(rows->device, target, apart_images[i], STILB_GPU_RGBA16_F, false);
		row->color[i] = (stilb_gpu_attachment){.image = target->apart[i],
		                                       .load = rows->begun ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR};
	}
	if (apart && row->color_count == 1)
		target->apart[1] = target->apart[0];
	rows->begun = true;
}

void render_deferred_use_surfaces(const render_frame_target *target, uint32_t bits, stilb_gpu_pass *row)
{
	uint8_t images = bits & RENDER_LIGHTS_APART ? 1 : RENDER_GBUFFER_IMAGES;
	row->uses[0] = (stilb_gpu_use){.resource = target->depth, .how = STILB_GPU_USE_SAMPLED};
	for (uint8_t i = 0; i < images; i++)
		row->uses[1 + i] =
			(stilb_gpu_use){.resource = target->surfaces[i], .how = STILB_GPU_USE_SAMPLED, .slot = (uint16_t)(1 + i)};
	row->use_count = 1 + images;
}

/* A row that adds light: what it reads and draws into. */
static stilb_gpu_pass deferred_pass(deferred_rows *rows)
{
	const render_frame_target *target = rows->target;
	stilb_gpu_pass row = {
		.name = target->lights,
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = rows->program.id,
		.constant_bytes = sizeof *rows->push,
	};
	deferred_colors(rows, &row);
	render_deferred_use_surfaces(target, rows->bits, &row);
	row.uses[row.use_count] = rows->shadows;
	row.uses[row.use_count].slot = row.use_count;
	row.use_count++;
	if (rows->tiles)
		row.uses[row.use_count++] = *rows->tiles;
	else
		render_cells_use(rows->device, offsetof(render_push, view.lists), &row);
	memcpy(row.constants, rows->push, sizeof *rows->push);
	return row;
}

/* Adds a row that adds the light of the push's lights first .. first + count - 1. area: NULL: to the whole picture. */
static void deferred_row(deferred_rows *rows, uint32_t first, uint32_t count, const uint16_t area[4])
{
	stilb_gpu_pass row = deferred_pass(rows);
	render_push own = *rows->push;
	own.view.lights += first * sizeof(render_light);
	own.view.light_count = count;
	if (area)
		memcpy(row.area, area, sizeof row.area);
	memcpy(row.constants, &own, sizeof own);
	stilb_gpu_plan_pass(rows->device->plan, &row);
}

/* Likewise, in as many rows as a software device needs. */
static void deferred_rows_add(deferred_rows *rows, uint32_t first, uint32_t count)
{
	uint32_t most = stilb_gpu_is_software(rows->device->gpu) ? RENDER_LIGHTS_LOOP : count;
	do {
		uint32_t part = count < most ? count : most;
		deferred_row(rows, first, part, NULL);
		first += part;
		count -= part;
	} while (count > 0);
}

stilb_result render_deferred_lights(render_device *device, const render_stream *stream, render_frame_target *target,
                                    const render_push *push)
{
	render_formula_programs *choice;
	const stilb_render_view *view = stream->view;
	const render_view_lights *lights = &stream->lights;
	render_way way = render_view_way(device, view);
	uint32_t bits = render_deferred_bits(view, lights->bits);
	bool volumes = render_view_has_volumes(device, view);
	stilb_gpu_use tiles;
	deferred_rows rows = {.device = device, .target = target, .push = push, .bits = bits};
	stilb_result result = render_programs_choose(device, &view->shading, bits,
	                                             lights->shadow_bits & (RENDER_SHADOW_HDR - 1), 0, 0, &choice);
	if (result == STILB_OK)
		result = render_programs_deferred(device, choice, volumes);
	if (result != STILB_OK || (lights->count == 0 && !way.apart))
		return result;
	stilb_gpu_pass reads = {0};
	result = render_shadow_use(device, stream, target, &reads);
	rows.shadows = reads.uses[0];
	if (result == STILB_OK && bits & RENDER_LIGHTS_TILES) {
		result = render_tiles_make(device, stream, target, push, &tiles);
		rows.tiles = &tiles;
	}
	if (result != STILB_OK)
		return result;
	snprintf(target->lights, sizeof target->lights, "%.*s lights", (int)(sizeof target->lights - sizeof " lights"),
	         stream->pass->name ? stream->pass->name : "pass");
	rows.program = choice->deferred;
	bool lists = way.tiles || view->deferred.coverage == STILB_RENDER_COVERAGE_CELLS;
	bool rectangles = !lists && !volumes && view->deferred.coverage != STILB_RENDER_COVERAGE_SCREEN;
	uint32_t ending = lights->count - lights->endless;
	uint32_t most = render_light_rows_left(device->frame.light_rows);
	uint32_t each = !rectangles ? 0 : ending < most ? ending : most;
	device->frame.light_rows += each;
	uint32_t whole = lists ? lights->everywhere : rectangles || volumes ? lights->endless : lights->count;
	if (bits & RENDER_LIGHTS_LISTS) /* with the lights of these */
		deferred_row(&rows, 0, whole, NULL);
	else if (whole > 0 || way.apart)
		deferred_rows_add(&rows, 0, whole);
	const render_light *written = stream->written;
	for (uint32_t i = 0; i < each; i++) {
		uint16_t area[4];
		if (deferred_rectangle(&view->view_projection, &written[lights->endless + i], target->width, target->height,
		                       area))
			deferred_row(&rows, lights->endless + i, 1, area);
	}
	if (each < ending && rectangles)
		deferred_rows_add(&rows, lights->endless + each, ending - each);
	if (!volumes || ending == 0)
		return STILB_OK;
	stilb_gpu_pass row = deferred_pass(&rows);
	return render_volumes_add(device, stream, target, choice, &row);
}
