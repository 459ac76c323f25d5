/* The light of a panorama's cells: the lamps among them, and the irradiance of the rest by the normal. */
#include "base/base_contract.h"
#include "render/panorama/render_panorama_work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LAMP_SHARE 0.005  /* of all light: less is no lamp */
#define LAMP_RADIUS 0.021 /* radians about a lamp's middle that it may fill */
#define LAMP_CLEAR 0.0315 /* radians up to which there is little light around it: */
#define LAMP_AROUND 0.2   /* at most this share of its own */
#define LAMP_TRIES 400u   /* places that are looked at */
#define LAMP_CELLS 4096u  /* cells that may lie within LAMP_CLEAR, at the poles */

#define CELL_ANGLE (2.0 * M_PI / PANORAMA_ACROSS) /* radians; along both sides */
static_assert(PANORAMA_ACROSS == 2 * PANORAMA_DOWN, "cells are square");
static_assert(PANORAMA_ACROSS == 2 * RENDER_PANORAMA_COLUMNS && RENDER_PANORAMA_COLUMNS % 4 == 0, "see panorama_sums");

static double brightness_of(const float light[3])
{
	return 0.2126 * (double)light[0] + 0.7152 * (double)light[1] + 0.0722 * (double)light[2];
}

static void direction_of(double theta, double phi, double out[3])
{
	out[0] = sin(theta) * sin(phi);
	out[1] = cos(theta);
	out[2] = -sin(theta) * cos(phi);
}

static double dot_of(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Solid angle between two heights of the panorama's side, 0..1, and two places across it. */
static double solid_of(double top, double bottom, double width)
{
	return 2.0 * M_PI * width * (cos(M_PI * top) - cos(M_PI * bottom));
}

/* ---- lamps ------------------------------------------------------------------------------------------------------- */

/* A cell that may be the middle of a lamp; radiance: mean brightness of its light. */
typedef struct lamp_place {
	double radiance;
	uint32_t row, column;
} lamp_place;

static int lamp_brighter(const void *a, const void *b)
{
	const lamp_place *first = a, *second = b;
	if (first->radiance != second->radiance)
		return first->radiance > second->radiance ? -1 : 1;
	uint32_t i = first->row * PANORAMA_ACROSS + first->column, j = second->row * PANORAMA_ACROSS + second->column;
	return i < j ? -1 : 1;
}

/* Cells whose middles lie within LAMP_CLEAR of a direction, the nearest of them within LAMP_RADIUS. */
typedef struct lamp_cells {
	uint32_t count;
	uint16_t row[LAMP_CELLS], column[LAMP_CELLS];
	bool near[LAMP_CELLS];
} lamp_cells;

static void lamp_look_around(const double middle[3], lamp_cells *cells)
{
	double theta = acos(fmin(fmax(middle[1], -1.0), 1.0)), phi = atan2(middle[0], -middle[2]);
	int row = (int)(theta / CELL_ANGLE), column = (int)floor((phi + M_PI) / CELL_ANGLE);
	int down = (int)(LAMP_CLEAR / CELL_ANGLE) + 1, rows = (int)PANORAMA_DOWN, columns = (int)PANORAMA_ACROSS;
	cells->count = 0;
	for (int r = row > down ? row - down : 0; r <= row + down && r < rows; r++) {
		double sine = sin((r + 0.5) * CELL_ANGLE);
		double reach = LAMP_CLEAR / (sine * CELL_ANGLE) * 1.1 + 1.0; /* arcs of a small circle are a little longer */
		int most = columns / 2, half = reach < most ? (int)reach : most;
		for (int c = column - half; c < column + half + (half < most); c++) {
			double own[3];
			direction_of((r + 0.5) * CELL_ANGLE, (c + 0.5) * CELL_ANGLE - M_PI, own);
			double cosine = dot_of(middle, own);
			if (cosine < cos(LAMP_CLEAR) || cells->count == LAMP_CELLS)
				continue;
			cells->row[cells->count] = (uint16_t)r;
			cells->column[cells->count] = (uint16_t)((c + columns) % columns);
			cells->near[cells->count++] = cosine > cos(LAMP_RADIUS);
		}
	}
}

/* The middle of the light of a place and of what is near it. */
static void lamp_center(const render_panorama_work *work, const lamp_place *place, lamp_cells *cells, double middle[3])
{
	double sum[3] = {0.0, 0.0, 0.0};
	direction_of((place->row + 0.5) * CELL_ANGLE, (place->column + 0.5) * CELL_ANGLE - M_PI, middle);
	lamp_look_around(middle, cells);
	for (uint32_t i = 0; i < cells->count; i++) {
		double own[3], light = brightness_of(work->cells[cells->row[i]][cells->column[i]]);
		direction_of((cells->row[i] + 0.5) * CELL_ANGLE, (cells->column[i] + 0.5) * CELL_ANGLE - M_PI, own);
		for (int c = 0; c < 3 && cells->near[i]; c++)
			sum[c] += light * own[c];
	}
	double length = sqrt(dot_of(sum, sum));
	for (int c = 0; c < 3 && length > 0.0; c++)
		middle[c] = sum[c] / length;
}

/* Sums over the light of a lamp. */
typedef struct lamp_sums {
	double irradiance[3], brightness, toward[3], squares[3][3];
} lamp_sums;

/* Adds a piece of a texel, from top to bottom and from left to right as shares of the sides; its own extent counts. */
static void lamp_add(lamp_sums *sums, const float texel[3], panorama_overlap across, panorama_overlap down)
{
	double phi = 2.0 * M_PI * (0.5 * (across.begin + across.end) - 0.5), theta = 0.5 * M_PI * (down.begin + down.end);
	double solid = solid_of(down.begin, down.end, across.end - across.begin), sine = sin(theta), d[3];
	double wide = 2.0 * M_PI * (across.end - across.begin) * sine, high = M_PI * (down.end - down.begin);
	double right[3] = {cos(phi), 0.0, sin(phi)};
	double lower[3] = {cos(theta) * sin(phi), -sine, -cos(theta) * cos(phi)};
	panorama_v4 value = {texel[0], texel[1], texel[2], 0.0f};
	value = panorama_valid(value);
	float light[3] = {value[0], value[1], value[2]};
	double brightness = brightness_of(light) * solid;
	direction_of(theta, phi, d);
	sums->brightness += brightness;
	for (int i = 0; i < 3; i++) {
		sums->irradiance[i] += (double)light[i] * solid;
		sums->toward[i] += brightness * d[i];
		for (int j = 0; j < 3; j++)
			sums->squares[i][j] += brightness * (d[i] * d[j] + right[i] * right[j] * wide * wide / 12.0 +
			                                     lower[i] * lower[j] * high * high / 12.0);
	}
}

/* Adds the light of a cell, piece by piece. */
static void lamp_add_cell(const render_panorama_work *work, uint32_t row, uint32_t column, lamp_sums *sums)
{
	const stilb_image *map = &work->map;
	uint32_t top = (uint32_t)((uint64_t)row * map->height / PANORAMA_DOWN);
	uint32_t left = (uint32_t)((uint64_t)column * map->width / PANORAMA_ACROSS);
	for (uint32_t y = top; y < map->height; y++) {
		panorama_overlap down = panorama_overlap_of(y, map->height, row, PANORAMA_DOWN);
		if (down.end <= down.begin && y > top)
			break;
		for (uint32_t x = left; x < map->width && down.end > down.begin; x++) {
			panorama_overlap across = panorama_overlap_of(x, map->width, column, PANORAMA_ACROSS);
			if (across.end > across.begin)
				lamp_add(sums, panorama_texel(map, x, y), across, down);
			else if (x > left)
				break;
		}
	}
}

/* The product a m b of the spread m about the mean direction. */
static double lamp_spread(const lamp_sums *sums, const double a[3], const double b[3])
{
	double sum = 0.0;
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			sum += a[i] * b[j] *
			       (sums->squares[i][j] / sums->brightness -
			        sums->toward[i] * sums->toward[j] / (sums->brightness * sums->brightness));
	return sum;
}

/* The rectangle with the same axes of spread: evenly lit, a side of half length h has the variance h^2 / 3. */
static render_panorama_lamp lamp_make(const lamp_sums *sums)
{
	double length = sqrt(dot_of(sums->toward, sums->toward)) / sums->brightness, d[3], right[3], up[3];
	for (int c = 0; c < 3; c++)
		d[c] = sums->toward[c] / (sums->brightness * length);
	double level = sqrt(d[0] * d[0] + d[2] * d[2]);
	right[0] = level > 1e-9 ? -d[2] / level : 1.0;
	right[1] = 0.0;
	right[2] = level > 1e-9 ? d[0] / level : 0.0;
	up[0] = right[1] * d[2] - right[2] * d[1];
	up[1] = right[2] * d[0] - right[0] * d[2];
	up[2] = right[0] * d[1] - right[1] * d[0];
	double xx = lamp_spread(sums, right, right), yy = lamp_spread(sums, up, up), xy = lamp_spread(sums, right, up);
	double mean = 0.5 * (xx + yy), apart = sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
	double turn = 0.5 * atan2(2.0 * xy, xx - yy);
	double longer = sqrt(3.0 * fmax(mean + apart, 0.0)), shorter = sqrt(3.0 * fmax(mean - apart, 0.0));
	render_panorama_lamp lamp;
	for (int c = 0; c < 3; c++) {
		lamp.direction[c] = (float)d[c];
		lamp.irradiance[c] = (float)(sums->irradiance[c] * length);
		lamp.half_x[c] = (float)((cos(turn) * right[c] + sin(turn) * up[c]) * longer);
		lamp.half_y[c] = (float)((cos(turn) * up[c] - sin(turn) * right[c]) * shorter);
	}
	return lamp;
}

/* Takes a lamp at this place out of the cells. False: there is none; then no other is looked for close by. */
static bool lamp_take(render_panorama_work *work, const lamp_place *place, double least, lamp_cells *cells,
                      uint8_t (*seen)[PANORAMA_ACROSS])
{
	double middle[3], inside = 0.0, around = 0.0;
	lamp_center(work, place, cells, middle);
	lamp_look_around(middle, cells);
	for (uint32_t i = 0; i < cells->count; i++) {
		double light = brightness_of(work->cells[cells->row[i]][cells->column[i]]);
		inside += cells->near[i] ? light : 0.0;
		around += cells->near[i] ? 0.0 : light;
		seen[cells->row[i]][cells->column[i]] |= cells->near[i];
	}
	seen[place->row][place->column] = 1;
	if (inside < least || around > LAMP_AROUND * inside)
		return false;
	lamp_sums sums = {.brightness = 0.0};
	for (uint32_t i = 0; i < cells->count; i++)
		if (cells->near[i] && brightness_of(work->cells[cells->row[i]][cells->column[i]]) > 0.0) { /* not taken yet */
			lamp_add_cell(work, cells->row[i], cells->column[i], &sums);
			memset(work->cells[cells->row[i]][cells->column[i]], 0, sizeof(float[3]));
		}
	work->lamps[work->lamp_count++] = lamp_make(&sums);
	return true;
}

/* Places whose radiance a lamp's mean may have, in falling order. Their number. */
static uint32_t lamp_places(const render_panorama_work *work, double least, lamp_place *places)
{
	uint32_t count = 0;
	for (uint32_t row = 0; row < PANORAMA_DOWN; row++) {
		double solid = solid_of((double)row / PANORAMA_DOWN, (row + 1.0) / PANORAMA_DOWN, 1.0 / PANORAMA_ACROSS);
		for (uint32_t column = 0; column < PANORAMA_ACROSS; column++) {
			double radiance = brightness_of(work->cells[row][column]) / solid;
			if (radiance * M_PI * LAMP_RADIUS * LAMP_RADIUS > 0.5 * least)
				places[count++] = (lamp_place){radiance, row, column};
		}
	}
	if (count > 0)
		qsort(places, count, sizeof *places, lamp_brighter);
	return count;
}

/* What finding lamps needs besides; lies in the sums, which are made after it. */
typedef struct lamp_room {
	lamp_place places[PANORAMA_DOWN * PANORAMA_ACROSS];
	lamp_cells cells;
	uint8_t seen[PANORAMA_DOWN][PANORAMA_ACROSS];
} lamp_room;

static_assert(sizeof(lamp_room) < PANORAMA_DOWN * sizeof(panorama_sums[3]), "it fits into the sums");

void render_panorama_find_lamps(render_panorama_work *work)
{
	lamp_room *room = (lamp_room *)(void *)work->sums;
	double all = 0.0;
	for (uint32_t row = 0; row < PANORAMA_DOWN; row++)
		for (uint32_t column = 0; column < PANORAMA_ACROSS; column++)
			all += brightness_of(work->cells[row][column]);
	double least = LAMP_SHARE * all;
	uint32_t count = all > 0.0 ? lamp_places(work, least, room->places) : 0;
	memset(room->seen, 0, sizeof room->seen);
	work->lamp_count = 0;
	for (uint32_t i = 0, tries = 0; i < count && tries < LAMP_TRIES && work->lamp_count < RENDER_PANORAMA_LAMPS; i++) {
		const lamp_place *place = &room->places[i];
		if (room->seen[place->row][place->column])
			continue;
		tries++;
		lamp_take(work, place, least, &room->cells, room->seen);
	}
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Means of the cosine and the sine of the longitude over the cell behind each edge. */
typedef struct sum_angles {
	double cosine[PANORAMA_EDGES], sine[PANORAMA_EDGES];
} sum_angles;

static sum_angles sum_angles_of(void)
{
	sum_angles angles;
	for (uint32_t edge = 0; edge < PANORAMA_EDGES; edge++) {
		double phi = -2.0 * M_PI + edge * CELL_ANGLE;
		angles.cosine[edge] = (sin(phi + CELL_ANGLE) - sin(phi)) / CELL_ANGLE;
		angles.sine[edge] = (cos(phi) - cos(phi + CELL_ANGLE)) / CELL_ANGLE;
	}
	return angles;
}

static void sum_row(render_panorama_work *work, uint32_t row, const sum_angles *angles)
{
	for (int c = 0; c < 3; c++) {
		panorama_sums *sums = &work->sums[row][c];
		double light = 0.0, cosine = 0.0, sine = 0.0;
		for (uint32_t edge = 0; edge < PANORAMA_EDGES; edge++) {
			/* Edge number 256 is at the panorama's left side, whose longitude is -pi. */
			double own = (double)work->cells[row][(edge + PANORAMA_ACROSS / 2) % PANORAMA_ACROSS][c];
			sums->light[edge % 2][edge / 2] = (float)light;
			sums->cosine[edge % 2][edge / 2] = (float)cosine;
			sums->sine[edge % 2][edge / 2] = (float)sine;
			sums->cell[edge % 2][edge / 2] = (float)own;
			light += own;
			cosine += own * angles->cosine[edge];
			sine += own * angles->sine[edge];
		}
	}
}

void render_panorama_sum_rows(render_panorama_work *work, uint32_t begin, uint32_t end)
{
	sum_angles angles = sum_angles_of();
	for (uint32_t row = begin; row < end; row++)
		sum_row(work, row, &angles);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

/* How a row of cells lights the normals of a row of the table: where cos(angle) = level + swing cos(apart), apart being
 * the difference of longitudes, is above 0. That is `cells` whole cells to both sides, and of the cells behind them the
 * light times `part`. cells 0: nothing of it. */
typedef struct fill_way {
	float level, swing, part;
	uint32_t cells;
} fill_way;

static fill_way fill_way_of(double level, double swing)
{
	fill_way way = {(float)level, (float)swing, 0.0f, 0};
	if (level >= swing)
		way.cells = PANORAMA_ACROSS / 2;
	if (level >= swing || level <= -swing)
		return way;
	double apart = acos(-level / swing), cells = floor(apart / CELL_ANGLE), inner = cells * CELL_ANGLE;
	way.cells = (uint32_t)cells;
	way.part = (float)((level * (apart - inner) + swing * (sin(apart) - sin(inner))) / CELL_ANGLE);
	return way;
}

static panorama_v4 fill_load(const float *from)
{
	panorama_v4 value;
	memcpy(&value, from, sizeof value);
	return value;
}

/* Sines and cosines of the table's longitudes, and the means of those of the cells' angles from the pole over the solid
 * angle of each row. */
typedef struct fill_angles {
	float sine[RENDER_PANORAMA_COLUMNS], cosine[RENDER_PANORAMA_COLUMNS];
	double row_sine[PANORAMA_DOWN], row_cosine[PANORAMA_DOWN];
} fill_angles;

static fill_angles fill_angles_of(void)
{
	fill_angles angles;
	for (uint32_t j = 0; j < RENDER_PANORAMA_COLUMNS; j++) {
		double phi = 2.0 * M_PI * ((double)j / RENDER_PANORAMA_COLUMNS - 0.5);
		angles.sine[j] = (float)sin(phi);
		angles.cosine[j] = (float)cos(phi);
	}
	for (uint32_t row = 0; row < PANORAMA_DOWN; row++) {
		double top = row * CELL_ANGLE, bottom = (row + 1) * CELL_ANGLE;
		angles.row_cosine[row] = 0.5 * (cos(top) + cos(bottom));
		angles.row_sine[row] =
			(0.5 * CELL_ANGLE - 0.25 * (sin(2.0 * bottom) - sin(2.0 * top))) / (cos(top) - cos(bottom));
	}
	return angles;
}

/* Adds the light of a row's colour to the columns. */
static void fill_add(const panorama_sums *s, fill_way way, const fill_angles *columns, float *sum)
{
	/* A column's edge is number 256 + 2 j; the edges 2 j + 256 + cells and 2 j + 256 - cells have the same parity. */
	uint32_t odd = way.cells % 2, middle = PANORAMA_ACROSS / 2, behind = way.cells == middle ? 0 : way.cells;
	uint32_t high = (middle + way.cells) / 2, low = (middle - way.cells) / 2;
	const float *after = s->cell[behind % 2] + (middle + behind) / 2;
	const float *before = s->cell[(behind + 1) % 2] + (middle - behind - 1) / 2;
	for (uint32_t j = 0; j < RENDER_PANORAMA_COLUMNS; j += 4) {
		panorama_v4 light = fill_load(s->light[odd] + high + j) - fill_load(s->light[odd] + low + j);
		panorama_v4 cosine = fill_load(s->cosine[odd] + high + j) - fill_load(s->cosine[odd] + low + j);
		panorama_v4 sine = fill_load(s->sine[odd] + high + j) - fill_load(s->sine[odd] + low + j);
		panorama_v4 ends = fill_load(after + j) + fill_load(before + j);
		panorama_v4 turned = fill_load(columns->cosine + j) * cosine + fill_load(columns->sine + j) * sine;
		panorama_v4 total = fill_load(sum + j) + light * way.level + turned * way.swing + ends * way.part;
		memcpy(sum + j, &total, sizeof total);
	}
}

void render_panorama_fill_rows(render_panorama_work *work, uint32_t begin, uint32_t end)
{
	fill_angles angles = fill_angles_of();
	for (uint32_t y = begin; y < end; y++) {
		float sums[3][RENDER_PANORAMA_COLUMNS] = {{0}};
		double level = cos(M_PI * y / (RENDER_PANORAMA_ROWS - 1)), swing = sin(M_PI * y / (RENDER_PANORAMA_ROWS - 1));
		for (uint32_t row = 0; row < PANORAMA_DOWN; row++) {
			fill_way way = fill_way_of(level * angles.row_cosine[row], swing * angles.row_sine[row]);
			for (int c = 0; c < 3 && (way.cells > 0 || way.part > 0.0f); c++)
				fill_add(&work->sums[row][c], way, &angles, sums[c]);
		}
		for (uint32_t j = 0; j < RENDER_PANORAMA_COLUMNS; j++)
			for (int c = 0; c < 4; c++)
				(*work->light)[y][j][c] = c < 3 ? fmaxf(sums[c][j], 0.0f) : 0.0f;
	}
}
