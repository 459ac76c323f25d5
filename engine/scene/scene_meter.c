/* The exposure that suits the light on what a camera sees. */
#include "scene/scene_internal.h"
#include "scene/scene_light_shade.h"
#include "scene/scene_look.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stdlib.h>

#define METER_SIDE 96 /* pixels of the picture that is metered */
#define METER_PIXELS ((size_t)METER_SIDE * METER_SIDE)
#define METER_TRIANGLES (1u << 22) /* looked at, at most */
#define METER_SHARE 0.9            /* of the lit pixels have at most the irradiance that is exposed for */
#define METER_STOPS 32.0f          /* the largest exposure, and the smallest is its negative */

/* What is seen at a pixel. */
typedef struct meter_pixel {
	float nearness; /* 1 / z of the nearest triangle; 0: there is none */
	uint32_t part, triangle;
} meter_pixel;

typedef struct meter {
	const stilb_scene *scene;
	stilb_mat4 view; /* world to the camera's axes: x right, y up, z backwards */
	float scale;     /* half a picture over the tangent of half its angle: pixels at z = 1 */
	float near_z;
	float sky[3], ground[3]; /* surroundings as two halves */
	meter_pixel *pixels;     /* [METER_PIXELS] */
	float *values;           /* [METER_PIXELS] */
} meter;

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

/* The mean radiance of rows first .. end - 1 of a panorama, weighted by their solid angles. row: [width][channels]. */
static void meter_mean(const stilb_image *panorama, uint32_t first, uint32_t end, float *row, float mean[3])
{
	double sum[3] = {0.0, 0.0, 0.0}, weights = 0.0;
	for (uint32_t y = first; y < end; y++) {
		double weight = sin(M_PI * (y + 0.5) / panorama->height);
		stilb_image_row_to_light(panorama, y, row);
		for (uint32_t x = 0; x < panorama->width; x++)
			for (uint32_t c = 0; c < 3; c++)
				sum[c] += weight * (double)row[x * panorama->channels + (panorama->channels < 3 ? 0 : c)];
		weights += weight * panorama->width;
	}
	for (int c = 0; c < 3; c++)
		mean[c] = weights > 0.0 ? (float)(sum[c] / weights) : 0.0f;
}

bool scene_panorama_halves(const stilb_image *panorama, float above[3], float below[3])
{
	STILB_ASSERT(panorama->pixels);
	float *row = stilb_memory_alloc((size_t)panorama->width * panorama->channels, sizeof *row);
	if (!row)
		return false;
	meter_mean(panorama, 0, (panorama->height + 1) / 2, row, above);
	meter_mean(panorama, panorama->height / 2, panorama->height, row, below);
	free(row);
	return true;
}

static bool meter_surroundings(meter *m)
{
	const stilb_scene_surroundings *around = &m->scene->surroundings;
	const stilb_image *panorama = &around->panorama;
	for (int i = 0; i < 3; i++) {
		m->sky[i] = around->sky[i];
		m->ground[i] = around->ground[i];
	}
	return !panorama->pixels || scene_panorama_halves(panorama, m->sky, m->ground);
}

/* ---- which triangle is seen at each pixel ------------------------------------------------------------------------ */

/* A corner in the camera's axes, z ahead. */
static stilb_vec3 meter_corner(const stilb_mat4 *full, const float p[3])
{
	const float *m = full->m;
	stilb_vec3 at = {0};
	for (int k = 0; k < 3; k++)
		at[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
	at[2] = -at[2];
	return at;
}

/* Cuts the triangle off at the near plane: a polygon of up to four corners. Returns their number; 0: none is left. */
static int meter_clip(const stilb_vec3 corner[3], float near_z, stilb_vec3 out[4])
{
	int count = 0;
	for (int i = 0; i < 3; i++) {
		stilb_vec3 a = corner[i], b = corner[(i + 1) % 3];
		bool a_in = a[2] > near_z, b_in = b[2] > near_z;
		if (a_in)
			out[count++] = a;
		if (a_in != b_in) {
			stilb_vec3 cut = a + (b - a) * ((near_z - a[2]) / (b[2] - a[2]));
			cut[2] = near_z;
			out[count++] = cut;
		}
	}
	return count;
}

static int meter_bound(float value)
{
	return value < 0.0f ? 0 : value > METER_SIDE ? METER_SIDE : (int)value;
}

/* Draws a triangle that lies before the camera: pixels whose centre it covers. */
static void meter_draw(meter *m, const stilb_vec3 corner[3], uint32_t part, uint32_t triangle)
{
	float x[3], y[3], w[3];
	for (int i = 0; i < 3; i++) {
		w[i] = 1.0f / corner[i][2];
		x[i] = 0.5f * METER_SIDE + m->scale * corner[i][0] * w[i];
		y[i] = 0.5f * METER_SIDE - m->scale * corner[i][1] * w[i];
	}
	int left = meter_bound(fminf(fminf(x[0], x[1]), x[2])), right = meter_bound(fmaxf(fmaxf(x[0], x[1]), x[2]) + 1.0f);
	int top = meter_bound(fminf(fminf(y[0], y[1]), y[2])), bottom = meter_bound(fmaxf(fmaxf(y[0], y[1]), y[2]) + 1.0f);
	float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
	if (!(fabsf(area) > 1e-12f))
		return;
	for (int row = top; row < bottom; row++)
		for (int column = left; column < right; column++) {
			float px = (float)column + 0.5f, py = (float)row + 0.5f;
			float u = ((px - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (py - y[0])) / area;
			float v = ((x[1] - x[0]) * (py - y[0]) - (px - x[0]) * (y[1] - y[0])) / area;
			float nearness = w[0] + u * (w[1] - w[0]) + v * (w[2] - w[0]);
			meter_pixel *pixel = &m->pixels[row * METER_SIDE + column];
			if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f && nearness > pixel->nearness)
				*pixel = (meter_pixel){nearness, part, triangle};
		}
}

/* step: every so manieth triangle is drawn. */
static void meter_draw_part(meter *m, uint32_t part, uint32_t step)
{
	const stilb_scene *scene = m->scene;
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	stilb_mat4 full = stilb_mat4_multiply(m->view, scene->part_transform[part]);
	for (uint32_t t = part % step; t < mesh->index_count / 3; t += step) {
		stilb_vec3 corner[3], kept[4];
		for (int i = 0; i < 3; i++)
			corner[i] = meter_corner(&full, mesh->vertices[mesh->indices[3 * (size_t)t + (size_t)i]].position);
		int count = meter_clip(corner, m->near_z, kept);
		if (count >= 3)
			meter_draw(m, kept, part, t);
		if (count == 4)
			meter_draw(m, (stilb_vec3[3]){kept[0], kept[2], kept[3]}, part, t);
	}
}

static void meter_draw_scene(meter *m)
{
	const stilb_scene *scene = m->scene;
	uint64_t triangles = 0;
	for (uint32_t p = 0; p < scene->part_count; p++)
		if (scene->part_mesh[p] != STILB_SCENE_NONE)
			triangles += scene->meshes[scene->part_mesh[p]].index_count / 3;
	uint32_t step = (uint32_t)(triangles / METER_TRIANGLES) + 1;
	for (uint32_t model = 0; model < scene->model_count; model++) {
		if (isnan(scene->bounds.radius[model]) || scene->model_flags[model] & STILB_SCENE_MODEL_UNSEEN)
			continue;
		for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++)
			if (scene->part_mesh[p] != STILB_SCENE_NONE)
				meter_draw_part(m, p, step);
	}
}

/* ---- light at a pixel -------------------------------------------------------------------------------------------- */

/* The luminance of the irradiance at a point with this unit normal. */
static float meter_irradiance(const meter *m, stilb_vec3 at, stilb_vec3 normal)
{
	const stilb_scene *scene = m->scene;
	stilb_vec3 sky = stilb_vec3_make(m->sky[0], m->sky[1], m->sky[2]);
	stilb_vec3 ground = stilb_vec3_make(m->ground[0], m->ground[1], m->ground[2]);
	float sum = shade_luminance(shade_hemisphere_irradiance(normal[1], sky, ground));
	for (uint32_t i = 0; i < scene->light_count; i++) {
		shade_sun seen = shade_light_at(scene_light_shade(&scene->lights[i]), at);
		sum += fmaxf(stilb_vec3_dot(normal, seen.direction), 0.0f) * shade_luminance(seen.irradiance);
	}
	return sum;
}

/* Where the pixel's ray meets its triangle, in the world, and the triangle's unit normal towards the camera. False: it
 * has none. */
static bool meter_surface(const meter *m, uint32_t index, const float camera[3], stilb_vec3 *at, stilb_vec3 *normal)
{
	const stilb_scene *scene = m->scene;
	const meter_pixel *pixel = &m->pixels[index];
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[pixel->part]];
	const stilb_mat4 *to_world = &scene->part_transform[pixel->part];
	stilb_vec3 corner[3];
	for (int i = 0; i < 3; i++) {
		corner[i] =
			meter_corner(to_world, mesh->vertices[mesh->indices[3 * (size_t)pixel->triangle + (size_t)i]].position);
		corner[i][2] = -corner[i][2];
	}
	float z = 1.0f / pixel->nearness;
	uint32_t column = index % METER_SIDE, row = index / METER_SIDE;
	float x = ((float)column + 0.5f - 0.5f * METER_SIDE) / m->scale * z;
	float y = (0.5f * METER_SIDE - (float)row - 0.5f) / m->scale * z;
	for (size_t i = 0; i < 3; i++)
		(*at)[i] = camera[i] + x * m->view.m[4 * i] + y * m->view.m[4 * i + 1] - z * m->view.m[4 * i + 2];
	stilb_vec3 a = corner[1] - corner[0], b = corner[2] - corner[0];
	stilb_vec3 across =
		stilb_vec3_make(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
	float length = sqrtf(stilb_vec3_dot(across, across));
	stilb_vec3 to_camera = stilb_vec3_make(camera[0], camera[1], camera[2]) - *at;
	*normal = across * ((stilb_vec3_dot(across, to_camera) < 0.0f ? -1.0f : 1.0f) / length);
	return length > 0.0f && isfinite(length);
}

const char *const stilb_scene_tone_names[] = {
	[SHADE_TONE_KNEE] = "knee",           [SHADE_TONE_NONE] = "none",
	[SHADE_TONE_NEUTRAL] = "neutral",     [SHADE_TONE_FILMIC] = "filmic",
	[SHADE_TONE_LUMINANCE] = "luminance", [SHADE_TONE_PIECEWISE] = "piecewise",
	[SHADE_TONE_HABLE] = "hable",         [SHADE_TONE_COUNT] = NULL,
};

/* ---- the exposure ------------------------------------------------------------------------------------------------ */

static int meter_compare(const void *a, const void *b)
{
	float x = *(const float *)a, y = *(const float *)b;
	return (x > y) - (x < y);
}

/* The value that a tenth of the values above 0 exceeds; 0: there are none. Reorders them. */
static float meter_percentile(float *values, uint32_t count)
{
	if (count == 0)
		return 0.0f;
	qsort(values, count, sizeof *values, meter_compare);
	return values[(uint32_t)(METER_SHARE * (count - 1))];
}

static float meter_radiance(meter *m, const float camera[3])
{
	uint32_t count = 0;
	stilb_vec3 at = {0}, normal = {0};
	for (uint32_t i = 0; i < METER_PIXELS; i++) {
		if (!(m->pixels[i].nearness > 0.0f) || !meter_surface(m, i, camera, &at, &normal))
			continue;
		float irradiance = meter_irradiance(m, at, normal);
		if (irradiance > 0.0f && isfinite(irradiance))
			m->values[count++] = irradiance;
	}
	if (count > 0)
		return meter_percentile(m->values, count) * SHADE_INV_PI;
	for (uint32_t i = 0; i < METER_PIXELS; i++) {
		if (!(m->pixels[i].nearness > 0.0f))
			continue;
		const float *e = m->scene->materials[m->scene->part_material[m->pixels[i].part]].emission;
		float radiance = shade_luminance(stilb_vec3_make(e[0], e[1], e[2]));
		if (radiance > 0.0f && isfinite(radiance))
			m->values[count++] = radiance;
	}
	return meter_percentile(m->values, count);
}

stilb_result stilb_scene_meter(const stilb_scene *scene, const stilb_scene_camera *camera, float *exposure)
{
	STILB_ASSERT(scene && camera && exposure);
	STILB_ASSERT(camera->fov_y > 0.0f && camera->near_z > 0.0f);
	*exposure = 0.0f;
	meter m = {.scene = scene, .near_z = camera->near_z, .scale = 0.5f * METER_SIDE / tanf(0.5f * camera->fov_y)};
	m.view = stilb_mat4_view(stilb_vec3_make(camera->position[0], camera->position[1], camera->position[2]),
	                         camera->yaw, camera->pitch); /* roll turns the picture, and the meter reads all of it */
	m.pixels = calloc(METER_PIXELS, sizeof *m.pixels);
	m.values = calloc(METER_PIXELS, sizeof *m.values);
	bool good = m.pixels && m.values && meter_surroundings(&m);
	if (good) {
		meter_draw_scene(&m);
		float radiance = meter_radiance(&m, camera->position);
		if (radiance > 0.0f)
			*exposure =
				fminf(fmaxf((float)(-rint(100.0 * (double)log2f(radiance)) / 100.0), -METER_STOPS), METER_STOPS);
	}
	free(m.pixels);
	free(m.values);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory to meter the light");
}
