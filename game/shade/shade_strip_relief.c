/* Strips of spheres with bumps and with normal maps. */
#include "shade_strip.h"

#include "image/image_normals.h"
#include "shading/shade_bump.h"

#include <math.h>
#include <stdio.h>

/* ---- bumps ------------------------------------------------------------------------------------------------------- */

#define BUMP_HEIGHT 0.07f
#define BUMP_WAVES 14.0f

/* Longitude and latitude of a normal, radians; u grows to the right, v upwards. */
static stilb_vec2 bump_uv(stilb_vec3 p)
{
	return (stilb_vec2){atan2f(p[0], p[2]), asinf(fminf(fmaxf(p[1], -1.0f), 1.0f))};
}

/* The height of a grid of hills above the smooth sphere, whose radius is 1. */
static float bump_height(stilb_vec2 uv)
{
	return BUMP_HEIGHT * (0.5f - 0.5f * cosf(BUMP_WAVES * uv[0])) * (0.5f - 0.5f * cosf(BUMP_WAVES * uv[1]));
}

static stilb_vec2 bump_derivatives(stilb_vec2 uv)
{
	float slope = 0.5f * BUMP_HEIGHT * BUMP_WAVES;
	return (stilb_vec2){slope * sinf(BUMP_WAVES * uv[0]) * (0.5f - 0.5f * cosf(BUMP_WAVES * uv[1])),
	                    slope * sinf(BUMP_WAVES * uv[1]) * (0.5f - 0.5f * cosf(BUMP_WAVES * uv[0]))};
}

/* The texture coordinates at a place, and the differences of the position p and of the coordinates uv between it and
 * the places one step to the right (dx) and one step down (dy). */
typedef struct bump_steps {
	stilb_vec3 dp_dx, dp_dy;
	stilb_vec2 uv, duv_dx, duv_dy;
} bump_steps;

static bump_steps bump_steps_at(strip_place place)
{
	stilb_vec3 here = strip_normal(place.x, place.y), right = strip_normal(place.x + place.step, place.y),
			   down = strip_normal(place.x, place.y - place.step);
	stilb_vec2 uv = bump_uv(here);
	return (bump_steps){right - here, down - here, uv, bump_uv(right) - uv, bump_uv(down) - uv};
}

static void bump_by_height(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness)
{
	(void)i;
	(void)roughness;
	bump_steps s = bump_steps_at(place);
	float h = bump_height(s.uv);
	*n = shade_bump_from_height(*n, s.dp_dx, s.dp_dy, bump_height(s.uv + s.duv_dx) - h,
	                            bump_height(s.uv + s.duv_dy) - h, sphere->relief_scale);
}

static void bump_by_derivatives(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n,
                                float *roughness)
{
	(void)i;
	(void)roughness;
	bump_steps s = bump_steps_at(place);
	*n = shade_bump_from_derivatives(*n, s.dp_dx, s.dp_dy, bump_derivatives(s.uv), s.duv_dx, s.duv_dy,
	                                 sphere->relief_scale);
}

/* Bumps the normal by the derivatives of position and height along the circles of longitude and latitude, which are
 * known at the point itself: no neighbouring pixel is needed. */
static void bump_by_uv(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness)
{
	(void)place;
	(void)i;
	(void)roughness;
	stilb_vec3 p = *n, dp_du = stilb_vec3_make(p[2], 0.0f, -p[0]);
	stilb_vec3 dp_dv = stilb_vec3_normalize(stilb_vec3_cross(p, dp_du));
	stilb_vec2 dh = bump_derivatives(bump_uv(p));
	*n = shade_bump_normal(p, shade_bump_gradient(p, dp_du, dp_dv, dh[0], dh[1]), sphere->relief_scale);
}

static void make_bump(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	float scale = 0.2f * (float)(column - 5);
	*sphere = (strip_sphere){
		.diffuse = stilb_vec3_make(0.34f, 0.30f, 0.10f),
		.diffuse_gain = 1.0f,
		.model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK},
		.highlight = {.specular = stilb_vec3_make(0.05f, 0.05f, 0.05f), .roughness = 0.4f},
		.highlight_gain = 1.0f,
		.mirror = 1.0f,
		.relief = row->relief,
		.relief_scale = scale,
		.relief_samples = row->relief_samples,
	};
	snprintf(words, sizeof(strip_words), "scale %.1f", (double)scale);
}

const strip_row strip_bump_rows[STRIP_BUMP_ROWS] = {
	{.caption = "Height, by differences\nbetween pixels",
     .make = make_bump,
     .relief = bump_by_height,
     .relief_samples = 1},
	{.caption = "Derivative map, by the\nchain rule",
     .make = make_bump,
     .relief = bump_by_derivatives,
     .relief_samples = 1},
	{.caption = "Gradient along u and v\n(as a tracer has it)",
     .make = make_bump,
     .relief = bump_by_uv,
     .relief_samples = 1},
};

/* ---- normal maps ------------------------------------------------------------------------------------------------- */

#define MAP_SIDE 256u
#define MAP_ROUGHNESS 0.25f
#define TRUTH_SIDE 6u /* strata along each side of a texel */

static stilb_image_normals chain; /* mip levels of the map; empty before strip_filter_prepare */

/* A normal map of bumps that are a few texels wide, without a larger pattern: random slopes, averaged over 3 x 3
 * texels. */
static stilb_vec3 map_normal(uint32_t x, uint32_t y)
{
	float slope[2] = {0.0f, 0.0f};
	for (uint32_t k = 0; k < 9; k++) {
		uint64_t at = (uint64_t)((y + k / 3) % MAP_SIDE) * MAP_SIDE + (x + k % 3) % MAP_SIDE;
		for (uint64_t axis = 0; axis < 2; axis++)
			slope[axis] += stilb_random_float(5 + axis, at) - 0.5f;
	}
	float strength = 0.28f;
	return stilb_vec3_normalize(stilb_vec3_make(strength * slope[0], strength * slope[1], 1.0f));
}

stilb_result strip_filter_prepare(void)
{
	stilb_image map;
	stilb_result result = stilb_image_create(&map, MAP_SIDE, MAP_SIDE, 3, STILB_IMAGE_F32_LINEAR);
	if (result != STILB_OK)
		return result;
	for (uint32_t i = 0; i < MAP_SIDE * MAP_SIDE; i++) {
		stilb_vec3 n = map_normal(i % MAP_SIDE, i / MAP_SIDE);
		for (uint32_t k = 0; k < 3; k++)
			((float *)map.pixels)[3 * i + k] = n[k];
	}
	stilb_image_normals_desc desc = stilb_image_normals_desc_default(&map);
	desc.constant_roughness = MAP_ROUGHNESS;
	result = stilb_image_normals_create(&desc, &chain);
	stilb_image_finish(&map);
	return result;
}

void strip_filter_finish(void)
{
	stilb_image_normals_finish(&chain);
}

/* Texture coordinates in [0, 1) of a normal: the map covers the visible half of the sphere. */
static stilb_vec2 map_uv(stilb_vec3 n)
{
	float u = atan2f(n[0], n[2]) / (float)M_PI + 0.5f;
	float v = 0.5f - asinf(fminf(fmaxf(n[1], -1.0f), 1.0f)) / (float)M_PI;
	return (stilb_vec2){u - floorf(u), v - floorf(v)};
}

static const float *map_texel(uint32_t level, float u, float v)
{
	const stilb_image *map = &chain.levels[level];
	uint32_t x = (uint32_t)(u * (float)map->width), y = (uint32_t)(v * (float)map->height);
	return (const float *)map->pixels + 4 * ((size_t)(y % map->height) * map->width + x % map->width);
}

/* Turns a normal of the map from the tangent frame at n into the space of the sphere. */
static stilb_vec3 map_turn(stilb_vec3 n, const float *texel)
{
	stilb_vec3 t = stilb_vec3_normalize(stilb_vec3_cross(stilb_vec3_make(0.0f, 1.0f, 0.0f), n));
	stilb_vec3 b = stilb_vec3_cross(n, t);
	return stilb_vec3_normalize(t * texel[0] + b * texel[1] + n * texel[2]);
}

static void map_filtered(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness)
{
	(void)place;
	(void)i;
	stilb_vec2 uv = map_uv(*n);
	const float *texel = map_texel(sphere->relief_level, uv[0], uv[1]);
	*n = map_turn(*n, texel);
	*roughness = texel[3];
}

static void map_normal_alone(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness)
{
	float before = *roughness;
	map_filtered(sphere, place, i, n, roughness);
	*roughness = before;
}

/* The reference: one texel of level 0 out of those that the texel at the sphere's mip level averages. Sample i selects
 * a stratum (a cell of a grid over the averaging texel), and the pixel selects a random point in the stratum. */
static void map_true(const strip_sphere *sphere, strip_place place, uint32_t i, stilb_vec3 *n, float *roughness)
{
	uint32_t side = TRUTH_SIDE, width = chain.levels[sphere->relief_level].width;
	uint64_t pixel = stilb_random_u64((uint64_t)(int64_t)(place.x * 1e6f), (uint64_t)(int64_t)(place.y * 1e6f));
	stilb_vec2 uv = map_uv(*n);
	float at[2];
	for (uint32_t axis = 0; axis < 2; axis++) {
		uint32_t stratum = axis == 0 ? i % side : i / side;
		float inside = ((float)stratum + stilb_random_float(pixel, 2 * i + axis)) / (float)side;
		at[axis] = (floorf(uv[axis] * (float)width) + inside) / (float)width;
	}
	*n = map_turn(*n, map_texel(0, at[0], at[1]));
	*roughness = MAP_ROUGHNESS;
}

static void make_map(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	*sphere = (strip_sphere){
		.diffuse_gain = 1.0f,
		.model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK},
		.highlight = {.specular = stilb_vec3_make(0.95f, 0.64f, 0.54f), .roughness = MAP_ROUGHNESS},
		.highlight_gain = 1.0f,
		.mirror = 1.0f,
		.relief = row->relief,
		.relief_level = (uint32_t)column,
		.relief_samples = row->relief_samples,
	};
	snprintf(words, sizeof(strip_words), "level %d", column);
}

const strip_row strip_filter_rows[STRIP_FILTER_ROWS] = {
	{.caption = "Normals averaged, the\nroughness kept: bumps\nturn into a mirror",
     .make = make_map,
     .relief = map_normal_alone,
     .relief_samples = 1},
	{.caption = "vMF: bumps turn into\nroughness", .make = make_map, .relief = map_filtered, .relief_samples = 1},
	{.caption = "Truth: the light of all\ntexels below, averaged",
     .make = make_map,
     .relief = map_true,
     .relief_samples = TRUTH_SIDE * TRUTH_SIDE},
};
