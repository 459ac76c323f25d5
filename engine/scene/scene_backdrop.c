/* What pictures show where no model is: surroundings out of focus, and a floor that takes the models' shadow. */
#include "scene/scene_internal.h"
#include "scene/scene_look.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FLOOR_SIDE STILB_SCENE_FLOOR_SIDE
#define FLOOR_DIRECTIONS 24 /* in which a point of the floor looks around */
#define FLOOR_EMPTY FLT_MAX /* the low end of a column without a model */

void scene_backdrop_finish(stilb_scene_backdrop *backdrop)
{
	free(backdrop->map);
	free(backdrop->floor);
	*backdrop = (stilb_scene_backdrop){0};
}

/* ---- the floor --------------------------------------------------------------------------------------------------- */

/* The models over a cell of the floor fill the heights from low to high, in cells; gaps between them do not count. */
typedef struct floor_column {
	float low, high;
} floor_column;

typedef struct floor_columns {
	floor_column cells[FLOOR_SIDE][FLOOR_SIDE]; /* [z][x] */
	float origin[3];                            /* the floor's corner, metres */
	float scale;                                /* cells in a metre */
} floor_columns;

static void floor_add(floor_columns *columns, float x, float y, float z)
{
	if (!(x >= 0.0f && z >= 0.0f && x < FLOOR_SIDE && z < FLOOR_SIDE))
		return;
	floor_column *cell = &columns->cells[(int)z][(int)x];
	cell->low = fminf(cell->low, y);
	cell->high = fmaxf(cell->high, y);
}

/* Adds points along an edge, so close together that no cell is missed. */
static void floor_add_edge(floor_columns *columns, stilb_vec3 a, stilb_vec3 b)
{
	stilb_vec3 along = b - a;
	float cells = fminf(fmaxf(fabsf(along[0]), fabsf(along[2])), 4.0f * FLOOR_SIDE);
	int steps = (int)(2.0f * cells) + 1;
	for (int i = 0; i < steps; i++) {
		stilb_vec3 at = a + along * ((float)i / (float)steps);
		floor_add(columns, at[0], at[1], at[2]);
	}
}

static int floor_bound(float value)
{
	return value < 0.0f ? 0 : value > FLOOR_SIDE ? FLOOR_SIDE : (int)value;
}

/* Adds a triangle, its corners in cells: its edges, and the centres of cells that it covers seen from above. */
static void floor_add_triangle(floor_columns *columns, const stilb_vec3 p[3])
{
	for (int i = 0; i < 3; i++)
		floor_add_edge(columns, p[i], p[(i + 1) % 3]);
	float area = (p[1][0] - p[0][0]) * (p[2][2] - p[0][2]) - (p[2][0] - p[0][0]) * (p[1][2] - p[0][2]);
	if (!(fabsf(area) > 1e-9f))
		return;
	int left = floor_bound(fminf(fminf(p[0][0], p[1][0]), p[2][0]));
	int right = floor_bound(fmaxf(fmaxf(p[0][0], p[1][0]), p[2][0]) + 1.0f);
	int near = floor_bound(fminf(fminf(p[0][2], p[1][2]), p[2][2]));
	int far = floor_bound(fmaxf(fmaxf(p[0][2], p[1][2]), p[2][2]) + 1.0f);
	for (int z = near; z < far; z++)
		for (int x = left; x < right; x++) {
			float px = (float)x + 0.5f - p[0][0], pz = (float)z + 0.5f - p[0][2];
			float u = (px * (p[2][2] - p[0][2]) - (p[2][0] - p[0][0]) * pz) / area;
			float v = ((p[1][0] - p[0][0]) * pz - px * (p[1][2] - p[0][2])) / area;
			if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f)
				floor_add(columns, (float)x + 0.5f, p[0][1] + u * (p[1][1] - p[0][1]) + v * (p[2][1] - p[0][1]),
				          (float)z + 0.5f);
		}
}

static void floor_add_part(floor_columns *columns, const stilb_scene *scene, uint32_t part)
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	const float *m = scene->part_transform[part].m;
	for (uint32_t i = 0; i + 2 < mesh->index_count; i += 3) {
		stilb_vec3 p[3] = {0};
		for (uint32_t c = 0; c < 3; c++) {
			const float *v = mesh->vertices[mesh->indices[i + c]].position;
			for (int k = 0; k < 3; k++)
				p[c][k] =
					(m[k] * v[0] + m[4 + k] * v[1] + m[8 + k] * v[2] + m[12 + k] - columns->origin[k]) * columns->scale;
		}
		floor_add_triangle(columns, p);
	}
}

/* The height of the lowest vertex, metres; of a scene without vertices the lower end of its sphere. */
static float floor_height(const stilb_scene *scene, const stilb_sphere *sphere)
{
	float low = FLT_MAX;
	for (uint32_t model = 0; model < scene->model_count; model++)
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++) {
			if (isnan(scene->bounds.radius[model]) || scene->part_mesh[part] == STILB_SCENE_NONE)
				continue;
			const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
			const float *m = scene->part_transform[part].m;
			for (uint32_t i = 0; i < mesh->index_count; i++) {
				const float *v = mesh->vertices[mesh->indices[i]].position;
				float y = m[1] * v[0] + m[5] * v[1] + m[9] * v[2] + m[13];
				low = y < low ? y : low; /* a NaN is left out */
			}
		}
	return low < FLT_MAX && low > sphere->y - 1.1f * sphere->radius ? low : sphere->y - sphere->radius;
}

/* The square of the sine of the elevation of what is `height` above and `distance` away. */
static float floor_sine(float height, float distance)
{
	return height > 0.0f ? height * height / (height * height + distance * distance) : 0.0f;
}

/* The share of the hemisphere above the cell's centre, weighted by the cosine, that columns hide. In each direction
 * they hide what lies between the lowest low end and the highest high end that are seen: of elevations a to b the
 * weighted share is sin^2 b - sin^2 a. */
static float floor_covered(const floor_columns *columns, int x, int z)
{
	float sum = 0.0f;
	const floor_column *own = &columns->cells[z][x];
	for (int d = 0; d < FLOOR_DIRECTIONS; d++) {
		float angle = 6.2831853f * (float)d / FLOOR_DIRECTIONS, step_x = cosf(angle), step_z = sinf(angle);
		float from = 1.0f, to = 0.0f;
		if (own->low < FLOOR_EMPTY) {
			from = floor_sine(own->low, 0.5f);
			to = 1.0f;
		}
		for (int i = 1; i < FLOOR_SIDE; i++) {
			float px = (float)x + 0.5f + step_x * (float)i, pz = (float)z + 0.5f + step_z * (float)i;
			if (!(px >= 0.0f && pz >= 0.0f && px < FLOOR_SIDE && pz < FLOOR_SIDE))
				break;
			const floor_column *cell = &columns->cells[(int)pz][(int)px];
			if (cell->low >= FLOOR_EMPTY)
				continue;
			from = fminf(from, floor_sine(cell->low, (float)i));
			to = fmaxf(to, floor_sine(cell->high, (float)i));
		}
		sum += fmaxf(to - from, 0.0f);
	}
	return sum / FLOOR_DIRECTIONS;
}

/* Takes the cells' steps out of the shadow's edge: each becomes a mean with its neighbours, of weights 1 2 1, along x
 * and then along z. */
static void floor_smooth(stilb_scene_floor *floor)
{
	for (int pass = 0; pass < 2; pass++)
		for (int line = 0; line < FLOOR_SIDE; line++) {
			float before = 0.0f;
			for (int i = 0; i < FLOOR_SIDE; i++) {
				float *cell = pass == 0 ? &floor->covered[line][i] : &floor->covered[i][line], own = *cell;
				float after = i + 1 == FLOOR_SIDE ? 0.0f : cell[pass == 0 ? 1 : FLOOR_SIDE];
				*cell = 0.25f * (before + 2.0f * own + after);
				before = own;
			}
		}
}

bool scene_floor_cover(const stilb_scene *scene, const stilb_sphere *sphere, stilb_scene_floor *floor)
{
	STILB_ASSERT(scene && sphere && sphere->radius > 0.0f && floor);
	floor_columns *columns = malloc(sizeof *columns);
	if (!columns)
		return false;
	float half = STILB_SCENE_FLOOR_REACH * sphere->radius;
	bool often = scene_is_placed_often(scene); /* then it has no shadow, rather than one that takes seconds */
	floor->center[0] = sphere->x;
	floor->center[1] = often ? sphere->y - sphere->radius : floor_height(scene, sphere);
	floor->center[2] = sphere->z;
	floor->radius = sphere->radius;
	columns->scale = FLOOR_SIDE / (2.0f * half);
	for (int k = 0; k < 3; k++)
		columns->origin[k] = floor->center[k] - (k == 1 ? 0.0f : half);
	for (int z = 0; z < FLOOR_SIDE; z++)
		for (int x = 0; x < FLOOR_SIDE; x++)
			columns->cells[z][x] = (floor_column){FLOOR_EMPTY, 0.0f};
	for (uint32_t model = 0; model < scene->model_count && !often; model++) {
		bool casts = (scene->model_flags[model] & STILB_SCENE_MODEL_CASTS_NO_SHADOW) == 0;
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1] && casts; part++)
			if (!isnan(scene->bounds.radius[model]) && scene->part_mesh[part] != STILB_SCENE_NONE)
				floor_add_part(columns, scene, part);
	}
	for (int z = 0; z < FLOOR_SIDE; z++)
		for (int x = 0; x < FLOOR_SIDE; x++)
			floor->covered[z][x] = floor_covered(columns, x, z);
	floor_smooth(floor);
	free(columns);
	return true;
}

/* ---- surroundings out of focus ----------------------------------------------------------------------------------- */

#define BLUR_WIDTH STILB_SCENE_BACKDROP_WIDTH
#define BLUR_HEIGHT STILB_SCENE_BACKDROP_HEIGHT
#define BLUR_CELLS ((size_t)BLUR_WIDTH * BLUR_HEIGHT)
#define BLUR_SHARPNESS 40.0f /* k of the lobe exp(k (cos - 1)), whose standard deviation is 9 degrees */

/* The surroundings as cells of a panorama. */
typedef struct blur_cells {
	stilb_vec3 direction[BLUR_CELLS]; /* of their middles, in the world */
	float solid[BLUR_CELLS];          /* relative solid angle */
	float radiance[BLUR_CELLS][3];
} blur_cells;

/* The direction of a cell's middle in a panorama that is turned by this angle: as gi_environment.c has it. */
static stilb_vec3 blur_direction(uint32_t x, uint32_t y, float rotation)
{
	float phi = 6.2831853f * (((float)x + 0.5f) / BLUR_WIDTH - 0.5f),
		  theta = 3.1415927f * ((float)y + 0.5f) / BLUR_HEIGHT;
	float right = sinf(theta) * sinf(phi), back = -sinf(theta) * cosf(phi), s = sinf(rotation), c = cosf(rotation);
	return stilb_vec3_make(c * right + s * back, cosf(theta), c * back - s * right);
}

/* The means of the panorama's pixels in each cell; where there are fewer pixels than cells, the nearest. row: room for
 * a row of the panorama as floats. */
static void blur_read(const stilb_image *panorama, float *row, blur_cells *cells)
{
	uint32_t channels = panorama->channels, rows = panorama->height > BLUR_HEIGHT ? panorama->height : BLUR_HEIGHT;
	uint32_t columns = panorama->width > BLUR_WIDTH ? panorama->width : BLUR_WIDTH, read = UINT32_MAX;
	float weights[BLUR_HEIGHT][BLUR_WIDTH] = {{0}};
	for (uint32_t j = 0; j < rows; j++) {
		uint32_t y = (uint32_t)((uint64_t)j * panorama->height / rows),
				 to_y = (uint32_t)((uint64_t)j * BLUR_HEIGHT / rows);
		if (y != read)
			stilb_image_row_to_light(panorama, read = y, row);
		for (uint32_t i = 0; i < columns; i++) {
			const float *from = row + (size_t)channels * ((uint64_t)i * panorama->width / columns);
			uint32_t to_x = (uint32_t)((uint64_t)i * BLUR_WIDTH / columns);
			float *to = cells->radiance[to_y * BLUR_WIDTH + to_x];
			for (int c = 0; c < 3; c++)
				to[c] += fminf(fmaxf(from[channels < 3 ? 0 : c], 0.0f), 1e15f);
			weights[to_y][to_x] += 1.0f;
		}
	}
	for (uint32_t i = 0; i < BLUR_CELLS; i++)
		for (int c = 0; c < 3; c++)
			cells->radiance[i][c] /= weights[i / BLUR_WIDTH][i % BLUR_WIDTH];
}

static bool blur_gather(const stilb_scene_surroundings *around, blur_cells *cells)
{
	const stilb_image *panorama = &around->panorama;
	for (uint32_t i = 0; i < BLUR_CELLS; i++) {
		uint32_t x = i % BLUR_WIDTH, y = i / BLUR_WIDTH;
		cells->direction[i] = blur_direction(x, y, panorama->pixels ? around->rotation : 0.0f);
		cells->solid[i] = sinf(3.1415927f * ((float)y + 0.5f) / BLUR_HEIGHT);
		for (int c = 0; c < 3; c++)
			cells->radiance[i][c] = panorama->pixels                ? 0.0f
			                        : cells->direction[i][1] < 0.0f ? around->ground[c]
			                                                        : around->sky[c];
	}
	if (!panorama->pixels)
		return true;
	float *row = stilb_memory_alloc((size_t)panorama->width * panorama->channels, sizeof *row);
	if (row)
		blur_read(panorama, row, cells);
	free(row);
	return row;
}

static void blur_make(const blur_cells *cells, float *map)
{
	for (uint32_t i = 0; i < BLUR_CELLS; i++) {
		stilb_vec3 to = blur_direction(i % BLUR_WIDTH, i / BLUR_WIDTH, 0.0f);
		float sum[3] = {0.0f, 0.0f, 0.0f}, weights = 0.0f;
		for (uint32_t k = 0; k < BLUR_CELLS; k++) {
			float cosine = stilb_vec3_dot(to, cells->direction[k]);
			if (cosine < 0.5f) /* the lobe is below 1e-8 there */
				continue;
			float weight = cells->solid[k] * expf(BLUR_SHARPNESS * (cosine - 1.0f));
			for (int c = 0; c < 3; c++)
				sum[c] += weight * cells->radiance[k][c];
			weights += weight;
		}
		for (int c = 0; c < 3; c++)
			map[3 * (size_t)i + (size_t)c] = sum[c] / weights;
	}
}

stilb_result stilb_scene_show_surroundings(stilb_scene *scene, bool blurred)
{
	STILB_ASSERT(scene);
	float *map = blurred ? malloc(3 * BLUR_CELLS * sizeof *map) : NULL;
	blur_cells *cells = blurred ? malloc(sizeof *cells) : NULL;
	bool good = !blurred || (map && cells && blur_gather(&scene->surroundings, cells));
	if (good && blurred)
		blur_make(cells, map);
	free(cells);
	if (!good) {
		free(map);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the background");
	}
	scene_backdrop_finish(&scene->backdrop);
	scene->backdrop.map = map;
	scene->backdrop.kind = blurred ? STILB_SCENE_BACKDROP_MAP : STILB_SCENE_BACKDROP_SURROUNDINGS;
	return STILB_OK;
}

void stilb_scene_set_backdrop(stilb_scene *scene, const float color[3])
{
	STILB_ASSERT(scene);
	scene_backdrop_finish(&scene->backdrop);
	scene->backdrop.kind = color ? STILB_SCENE_BACKDROP_COLOR : STILB_SCENE_BACKDROP_NOTHING;
	for (int i = 0; color && i < 3; i++) {
		STILB_ASSERT(color[i] >= 0.0f && isfinite(color[i]));
		scene->backdrop.color[i] = color[i];
	}
}
