#include "numeric/numeric_sh.h"

#include <math.h>
#include <stdlib.h>

/* ---- functions --------------------------------------------------------------------------------------------------- */

typedef struct product {
	stilb_numeric_direction_function *f;
	const void *context;
	int index; /* of the basis function */
} product;

static double product_at(const double direction[3], const void *context)
{
	const product *p = context;
	stilb_vec3 d = stilb_vec3_make((float)direction[0], (float)direction[1], (float)direction[2]);
	return p->f(direction, p->context) * (double)shade_sh_basis(d).c[p->index];
}

shade_sh stilb_numeric_sh_project(stilb_numeric_direction_function *f, const void *context, int panels)
{
	STILB_ASSERT(f && panels >= 1);
	shade_sh sh;
	for (int i = 0; i < 9; i++) {
		product p = {f, context, i};
		sh.c[i] = (float)stilb_numeric_integrate_sphere(product_at, &p, -1.0, 1.0, panels);
	}
	return sh;
}

/* ---- environment maps -------------------------------------------------------------------------------------------- */

/* theta is the angle from +Y, phi the one from -Z towards +X. */
void stilb_numeric_latlong_direction(double u, double v, double direction[3])
{
	STILB_ASSERT(u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0);
	double theta = M_PI * v, phi = 2.0 * M_PI * (u - 0.5);
	direction[0] = sin(theta) * sin(phi);
	direction[1] = cos(theta);
	direction[2] = -sin(theta) * cos(phi);
}

/* Integrals of 1, sin(phi), cos(phi), sin(2 phi) and cos(2 phi) over the azimuths phi of one column of the map, or sums
 * of such integrals times radiance. In phi all nine basis functions are made of these five, so a row takes five sums
 * for each channel, and the factors that depend on theta are applied once for each row. */
typedef struct around {
	double one, sin1, cos1, sin2, cos2;
} around;

static around column_integrals(uint32_t column, uint32_t width)
{
	STILB_ASSERT(column < width);
	double a = 2.0 * M_PI * ((double)column / width - 0.5), b = 2.0 * M_PI * ((column + 1.0) / width - 0.5);
	return (around){
		.one = b - a,
		.sin1 = cos(a) - cos(b),
		.cos1 = sin(b) - sin(a),
		.sin2 = 0.5 * (cos(2.0 * a) - cos(2.0 * b)),
		.cos2 = 0.5 * (sin(2.0 * b) - sin(2.0 * a)),
	};
}

static void add_texel(around *sum, const around *column, double radiance)
{
	sum->one += column->one * radiance;
	sum->sin1 += column->sin1 * radiance;
	sum->cos1 += column->cos1 * radiance;
	sum->sin2 += column->sin2 * radiance;
	sum->cos2 += column->cos2 * radiance;
}

/* Adds one channel's row to its nine coefficients: each basis function is a product of functions of theta and phi,
 * and its theta part times sin(theta) is integrated over the row's height. */
static void add_row(double sh[9], const around *row, uint32_t y, uint32_t height)
{
	STILB_ASSERT(y < height);
	double a = M_PI * y / height, b = M_PI * (y + 1.0) / height;
	double ca = cos(a), cb = cos(b), sa = sin(a), sb = sin(b);
	double s = ca - cb;                                              /* integral of sin */
	double sc = 0.5 * (sb * sb - sa * sa);                           /* of sin cos */
	double ss = 0.5 * (b - a) - 0.5 * (sb * cb - sa * ca);           /* of sin^2 */
	double ssc = (sb * sb * sb - sa * sa * sa) / 3.0;                /* of sin^2 cos */
	double scc = (ca * ca * ca - cb * cb * cb) / 3.0, sss = s - scc; /* of sin cos^2, of sin^3 */
	sh[0] += (double)SHADE_SH_Y0 * s * row->one;
	sh[1] -= (double)SHADE_SH_Y1 * sc * row->one;         /* y = cos(theta) */
	sh[2] -= (double)SHADE_SH_Y1 * ss * row->cos1;        /* z = -sin(theta) cos(phi) */
	sh[3] -= (double)SHADE_SH_Y1 * ss * row->sin1;        /* x = sin(theta) sin(phi) */
	sh[4] += (double)SHADE_SH_Y2 * ssc * row->sin1;       /* x y */
	sh[5] += (double)SHADE_SH_Y2 * ssc * row->cos1;       /* -y z */
	sh[7] += (double)SHADE_SH_Y2 * sss * 0.5 * row->sin2; /* -z x */
	/* x^2 and z^2 are sin^2(theta) (1 -+ cos(2 phi)) / 2. */
	double xx = 0.5 * sss * (row->one - row->cos2), yy = scc * row->one, zz = 0.5 * sss * (row->one + row->cos2);
	sh[6] += (double)SHADE_SH_Y2_0 * (2.0 * zz - xx - yy);
	sh[8] += (double)SHADE_SH_Y2_2 * (xx - yy);
}

static stilb_result project_map(const stilb_image *map, const around *columns, double sh[3][9])
{
	uint32_t colors = map->channels < 3 ? 1 : 3;
	const float *texel = map->pixels;
	for (uint32_t y = 0; y < map->height; y++) {
		around row[3] = {{0}};
		for (uint32_t x = 0; x < map->width; x++, texel += map->channels) {
			for (uint32_t color = 0; color < colors; color++) {
				if (!(fabsf(texel[color]) <= STILB_NUMERIC_SH_LIMIT))
					return stilb_fail(STILB_ERROR_ARGUMENT,
					                  "the environment map holds %g at column %u, row %u; give it values up to %g",
					                  (double)texel[color], x, y, (double)STILB_NUMERIC_SH_LIMIT);
				add_texel(&row[color], &columns[x], (double)texel[color]);
			}
		}
		for (uint32_t color = 0; color < 3; color++)
			add_row(sh[color], &row[color % colors], y, map->height);
	}
	return STILB_OK;
}

static shade_sh rounded(const double sh[9])
{
	shade_sh f;
	for (int i = 0; i < 9; i++)
		f.c[i] = (float)sh[i];
	return f;
}

stilb_result stilb_numeric_sh_project_map(const stilb_image *map, shade_sh_rgb *sh)
{
	STILB_ASSERT(map && map->pixels && sh);
	STILB_ASSERT(map->channels >= 1 && map->channels <= 4);
	if (map->format != STILB_IMAGE_F32_LINEAR)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "an environment map needs linear floats, which this picture lacks; give it as .exr");
	around *columns = stilb_memory_alloc(map->width, sizeof *columns);
	if (!columns)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for an environment map %u wide", map->width);
	for (uint32_t x = 0; x < map->width; x++)
		columns[x] = column_integrals(x, map->width);
	double sum[3][9] = {{0}};
	stilb_result result = project_map(map, columns, sum);
	free(columns);
	if (result == STILB_OK)
		*sh = (shade_sh_rgb){rounded(sum[0]), rounded(sum[1]), rounded(sum[2])};
	return result;
}
