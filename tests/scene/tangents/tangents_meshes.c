#include "tangents_meshes.h"

#include <math.h>
#include <string.h>

/* ---- building ---------------------------------------------------------------------------------------------------- */

/* Numbers of a mesh, one after the other. */
typedef struct tangents_dice {
	uint64_t seed, drawn;
} tangents_dice;

static int draw(tangents_dice *dice, int count)
{
	return (int)(stilb_random_u64(dice->seed, dice->drawn++) % (uint64_t)count);
}

static bool chance(tangents_dice *dice, int percent)
{
	return draw(dice, 100) < percent;
}

/* The normal is made unit unless it is zero; sqrt and / are rounded in one way. */
static uint32_t add_vertex(tangents_mesh *mesh, const double position[3], const double normal[3], const double uv[2])
{
	uint32_t v = mesh->vertex_count++;
	double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	for (int i = 0; i < 3; i++) {
		mesh->positions[v][i] = (float)position[i];
		mesh->normals[v][i] = length > 0.0 ? (float)(normal[i] / length) : 0.0f;
	}
	mesh->uvs[v][0] = (float)uv[0];
	mesh->uvs[v][1] = (float)uv[1];
	return v;
}

static void add_triangle(tangents_mesh *mesh, uint32_t a, uint32_t b, uint32_t c)
{
	mesh->indices[mesh->index_count++] = a;
	mesh->indices[mesh->index_count++] = b;
	mesh->indices[mesh->index_count++] = c;
}

/* The triangle that shares nothing. */
static void add_guard(tangents_mesh *mesh)
{
	double up[3] = {0, 0, 1};
	uint32_t a = add_vertex(mesh, (double[3]){100, 0, 0}, up, (double[2]){0, 0});
	uint32_t b = add_vertex(mesh, (double[3]){101, 0, 0}, up, (double[2]){1, 0});
	uint32_t c = add_vertex(mesh, (double[3]){100, 1, 0}, up, (double[2]){0, 1});
	add_triangle(mesh, a, b, c);
}

scene_tangents_mesh tangents_view(const tangents_mesh *mesh)
{
	return (scene_tangents_mesh){
		.positions = mesh->positions[0],
		.normals = mesh->normals[0],
		.uvs = mesh->uvs[0],
		.position_stride = sizeof mesh->positions[0],
		.normal_stride = sizeof mesh->normals[0],
		.uv_stride = sizeof mesh->uvs[0],
		.indices = mesh->indices,
		.vertex_count = mesh->vertex_count,
		.index_count = mesh->index_count,
	};
}

/* ---- random meshes ----------------------------------------------------------------------------------------------- */

/* A multiple of 1/step in -range .. range; a zero has either sign. */
static double draw_lattice(tangents_dice *dice, int range, int step)
{
	double value = (double)(draw(dice, 2 * range * step + 1) - range * step) / step;
	return value == 0.0 && chance(dice, 50) ? -0.0 : value;
}

static void draw_normal(tangents_dice *dice, double normal[3])
{
	bool zero = chance(dice, 3), axis = chance(dice, 30);
	for (int i = 0; i < 3; i++)
		normal[i] = zero || axis ? 0.0 : draw_lattice(dice, 5, 1);
	if (axis && !zero)
		normal[draw(dice, 3)] = chance(dice, 50) ? 1.0 : -1.0;
}

/* A vertex of its own; in one case of five, one that exists with another number, partly or wholly the same. */
static uint32_t draw_vertex(tangents_mesh *mesh, tangents_dice *dice)
{
	double position[3], normal[3], uv[2];
	for (int i = 0; i < 3; i++)
		position[i] = draw_lattice(dice, 2, 2);
	for (int i = 0; i < 2; i++)
		uv[i] = draw_lattice(dice, 1, 4);
	draw_normal(dice, normal);
	uint32_t v = add_vertex(mesh, position, normal, uv);
	if (v == 0 || !chance(dice, 20))
		return v;
	uint32_t other = (uint32_t)draw(dice, (int)v);
	memcpy(mesh->positions[v], mesh->positions[other], sizeof mesh->positions[v]);
	if (chance(dice, 70))
		memcpy(mesh->normals[v], mesh->normals[other], sizeof mesh->normals[v]);
	if (chance(dice, 70))
		memcpy(mesh->uvs[v], mesh->uvs[other], sizeof mesh->uvs[v]);
	return v;
}

/* Any triangles over few vertices. */
static void fill_soup(tangents_mesh *mesh, tangents_dice *dice)
{
	uint32_t vertices = 4 + (uint32_t)draw(dice, 24), triangles = 6 + (uint32_t)draw(dice, 40);
	for (uint32_t i = 0; i < vertices; i++)
		draw_vertex(mesh, dice);
	for (uint32_t i = 0; i < triangles; i++) {
		uint32_t corner[3];
		for (int k = 0; k < 3; k++)
			corner[k] = (uint32_t)draw(dice, (int)vertices);
		add_triangle(mesh, corner[0], corner[1], corner[2]);
	}
}

/* u along a row of the patch: it turns back at some columns, and stays at some. */
static void draw_profile(tangents_dice *dice, double *profile, int count)
{
	double step = 0.25;
	for (int i = 0; i < count; i++) {
		profile[i] = i == 0 ? 0.0 : profile[i - 1] + step;
		if (chance(dice, 25))
			step = -step;
		if (chance(dice, 10))
			step = step == 0.0 ? 0.25 : 0.0;
	}
}

/* A patch of squares with mirrored parts; some triangles are missing, some are turned over. */
static void fill_patch(tangents_mesh *mesh, tangents_dice *dice)
{
	int columns = 3 + draw(dice, 6), rows = 3 + draw(dice, 5);
	bool flat = chance(dice, 40), loose = chance(dice, 30);
	double us[16], vs[16];
	draw_profile(dice, us, columns);
	draw_profile(dice, vs, rows);
	for (int y = 0; y < rows; y++)
		for (int x = 0; x < columns; x++) {
			double height = flat ? 0.0 : draw_lattice(dice, 1, 4), normal[3] = {0, 0, 4};
			for (int i = 0; i < 2 && !flat; i++)
				normal[i] = draw_lattice(dice, 2, 1);
			add_vertex(mesh, (double[3]){x, chance(dice, 5) ? y + 1 : y, height}, normal, (double[2]){us[x], vs[y]});
		}
	for (int y = 0; y + 1 < rows; y++)
		for (int x = 0; x + 1 < columns; x++) {
			uint32_t a = (uint32_t)(y * columns + x), b = a + 1, c = a + (uint32_t)columns, d = c + 1;
			bool diagonal = chance(dice, 50), turned = loose && chance(dice, 20);
			uint32_t triangles[2][3] = {{a, b, diagonal ? d : c}, {diagonal ? a : b, d, c}};
			for (int i = 0; i < 2; i++)
				if (!loose || chance(dice, 90))
					add_triangle(mesh, triangles[i][turned ? 1 : 0], triangles[i][turned ? 0 : 1], triangles[i][2]);
		}
}

/* Triangles around one vertex, closed or not, whose directions are all alike, turn with the fan or are random. */
static void fill_fan(tangents_mesh *mesh, tangents_dice *dice)
{
	int count = 3 + draw(dice, 40), kind = draw(dice, 3);
	double up[3] = {0, 0, 1}, slope = draw_lattice(dice, 1, 2);
	uint32_t centre = add_vertex(mesh, (double[3]){0, 0, slope}, up, (double[2]){0, 0});
	for (int i = 0; i <= count; i++) {
		/* Twice around the square |x| + |y| = 8 at most. */
		int at = 32 * i / (count + 1) % 32, side = at / 8, along = at % 8;
		double x[4] = {8 - along, -along, along - 8, along}, y[4] = {along, 8 - along, -along, along - 8};
		double uv[2] = {x[side] / 8, y[side] / 8};
		if (kind == 1) { /* u around, v outwards */
			uv[0] = i / 8.0;
			uv[1] = 1;
		} else if (kind == 2)
			for (int k = 0; k < 2; k++)
				uv[k] = draw_lattice(dice, 1, 4);
		add_vertex(mesh, (double[3]){x[side], y[side], 0}, up, uv);
	}
	for (int i = 0; i < count; i++)
		if (!chance(dice, 3))
			add_triangle(mesh, centre, centre + 1 + (uint32_t)i, centre + 2 + (uint32_t)i);
	if (chance(dice, 50))
		add_triangle(mesh, centre, centre + 1 + (uint32_t)count, centre + 1);
}

/* Many triangles along the same edges, in both directions. */
static void fill_sheets(tangents_mesh *mesh, tangents_dice *dice)
{
	uint32_t spine = 2 + (uint32_t)draw(dice, 4), sheets = 2 + (uint32_t)draw(dice, 6);
	for (uint32_t i = 0; i < spine * (sheets + 1); i++)
		draw_vertex(mesh, dice);
	for (uint32_t i = 0; i + 1 < spine; i++)
		for (uint32_t s = 0; s < sheets; s++) {
			uint32_t far = spine + s * spine + i;
			bool turned = chance(dice, 50);
			add_triangle(mesh, turned ? i : i + 1, turned ? i + 1 : i, far);
			if (chance(dice, 60))
				add_triangle(mesh, turned ? i + 1 : far, turned ? far : i + 1, far + 1);
		}
}

/* Puts triangles of which two corners are one, or are at one position, between the others. */
static void add_degenerate(tangents_mesh *mesh, tangents_dice *dice)
{
	uint32_t vertices = mesh->vertex_count;
	for (int i = draw(dice, 4); i > 0; i--) {
		uint32_t at = 3 * (uint32_t)draw(dice, (int)(mesh->index_count / 3) + 1), *here = mesh->indices + at;
		memmove(here + 3, here, (mesh->index_count - at) * sizeof *here);
		for (int k = 0; k < 3; k++)
			here[k] = (uint32_t)draw(dice, (int)vertices);
		here[1 + draw(dice, 2)] = here[0];
		mesh->index_count += 3;
	}
}

void tangents_random(tangents_mesh *mesh, uint32_t seed)
{
	tangents_dice dice = {.seed = seed};
	*mesh = (tangents_mesh){0};
	switch (seed % 4) {
	case 0:
		fill_soup(mesh, &dice);
		break;
	case 1:
		fill_patch(mesh, &dice);
		break;
	case 2:
		fill_fan(mesh, &dice);
		break;
	default:
		fill_sheets(mesh, &dice);
		break;
	}
	add_degenerate(mesh, &dice);
	add_guard(mesh);
}

/* ---- classic meshes ---------------------------------------------------------------------------------------------- */

/* A point of the circle: twice the angle of the slope t, by the rational form of sine and cosine. */
static void circle(double t, double *cosine, double *sine)
{
	*cosine = (1 - t * t) / (1 + t * t);
	*sine = 2 * t / (1 + t * t);
}

/* columns x rows squares over vertices that begin at `first`, row by row. */
static void add_squares(tangents_mesh *mesh, uint32_t first, uint32_t columns, uint32_t rows, bool mirrored)
{
	for (uint32_t y = 0; y < rows; y++)
		for (uint32_t x = 0; x < columns; x++) {
			uint32_t a = first + y * (columns + 1) + x, b = a + 1, c = a + columns + 1, d = c + 1;
			add_triangle(mesh, a, mirrored ? d : b, mirrored ? b : d);
			add_triangle(mesh, a, mirrored ? c : d, mirrored ? d : c);
		}
}

static void fill_helmet(tangents_mesh *mesh)
{
	for (int half = 0; half < 2; half++) {
		uint32_t first = mesh->vertex_count;
		for (int y = 0; y <= 4; y++)
			for (int x = 0; x <= 4; x++) {
				double across, out, up, level;
				circle(x / 4.0, &out, &across);
				circle((y - 2) / 4.0, &level, &up);
				double place[3] = {(half == 0 ? 1 : -1) * across * level, up, out * level};
				add_vertex(mesh, place, place, (double[2]){x / 4.0, 1 - y / 4.0});
			}
		add_squares(mesh, first, 4, 4, half == 1);
	}
}

/* Columns from -180 to 180 degrees, the first and the last at the same place; the poles have a vertex a column. */
static void fill_sphere(tangents_mesh *mesh)
{
	for (int y = 0; y <= 4; y++)
		for (int x = 0; x <= 8; x++) {
			double cosine, sine, level, up;
			circle((x % 4 - 2) / 2.0, &cosine, &sine); /* -90 .. 90 degrees; then turned by half */
			circle((y - 2) / 2.0, &level, &up);
			double sign = x / 4 % 2 == 0 ? 1 : -1, place[3] = {sign * level * sine, up, sign * level * cosine};
			add_vertex(mesh, place, place, (double[2]){x / 8.0, 1 - y / 4.0});
		}
	add_squares(mesh, 0, 8, 4, false);
}

static void fill_four_squares(tangents_mesh *mesh)
{
	double normal[3] = {0, 0, 1};
	for (int square = 0; square < 4; square++) {
		uint32_t first = mesh->vertex_count;
		for (int y = 0; y <= 2; y++)
			for (int x = 0; x <= 2; x++) {
				double u = x / 2.0, v = y / 2.0;
				double uv[4][2] = {{u, v}, {1 - u, v}, {u, 1 - v}, {1 - v, u}};
				add_vertex(mesh, (double[3]){2 * (square % 2) + x, 2 * (square / 2) + y, 0}, normal, uv[square]);
			}
		add_squares(mesh, first, 2, 2, false);
	}
}

static void fill_cube(tangents_mesh *mesh)
{
	for (int face = 0; face < 6; face++) {
		int axis = face / 2, first = (axis + 1) % 3, second = (axis + 2) % 3;
		double side = face % 2 == 0 ? 1 : -1, normal[3] = {0};
		uint32_t start = mesh->vertex_count;
		normal[axis] = side;
		for (int i = 0; i < 4; i++) {
			double place[3];
			place[axis] = side;
			place[first] = i % 2 == 0 ? -side : side;
			place[second] = i / 2 == 0 ? -1 : 1;
			add_vertex(mesh, place, normal, (double[2]){i % 2, i / 2});
		}
		add_squares(mesh, start, 1, 1, false);
	}
}

void tangents_make_classic(tangents_mesh *mesh, tangents_classic classic)
{
	static void (*const fill[TANGENTS_CLASSICS])(tangents_mesh *) = {
		[TANGENTS_HELMET] = fill_helmet,
		[TANGENTS_SPHERE] = fill_sphere,
		[TANGENTS_SQUARES] = fill_four_squares,
		[TANGENTS_CUBE] = fill_cube,
	};
	*mesh = (tangents_mesh){0};
	fill[classic](mesh);
	add_guard(mesh);
}
