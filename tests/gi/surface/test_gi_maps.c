/* Surfaces with maps: textures at places against tables and closed forms, what is shaded from factors and texels,
 * normals against geometry that is turned alike, and what files of results know of all that. */

#include "gi/gi_path_fixture.h"
#include "gi/gi_render_fixture.h"
#include "gi_maps_fixture.h"

#include "gi/gi_scene_hash.h"
#include "gi/gi_texture.h"
#include "shading/shade_srgb.h"

static const stilb_mat4 here = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* The first uv as it is. */
static stilb_scene_map map_of(uint32_t texture)
{
	return (stilb_scene_map){.texture = texture, .to_u = {1.0f, 0.0f, 0.0f}, .to_v = {0.0f, 1.0f, 0.0f}};
}

static float grey_at(const stilb_image *image, const stilb_scene_map *map, float u, float v)
{
	return gi_texture_map(image, map, (stilb_vec2){u, v})[0];
}

/* Four texels 0, 1, 2, 3 in a row: which one is nearest, and what is between, for each wrap. */
static void wraps_against_a_table(void **state)
{
	(void)state;
	static float texels[4] = {0.0f, 1.0f, 2.0f, 3.0f};
	static const struct {
		float at, nearest[3], between[3]; /* repeat, mirror, clamp */
	} rows[] = {
		{0.375f, {1, 1, 1}, {1, 1, 1}},       {0.5f, {2, 2, 2}, {1.5f, 1.5f, 1.5f}},
		{0.0f, {0, 0, 0}, {1.5f, 0, 0}},      {0.0625f, {0, 0, 0}, {0.75f, 0, 0}},
		{0.9375f, {3, 3, 3}, {2.25f, 3, 3}},  {1.0f, {0, 3, 3}, {1.5f, 3, 3}},
		{1.125f, {0, 3, 3}, {0, 3, 3}},       {1.375f, {1, 2, 3}, {1, 2, 3}},
		{1.75f, {3, 1, 3}, {2.5f, 0.5f, 3}},  {2.125f, {0, 0, 3}, {0, 0, 3}},
		{-0.125f, {3, 0, 0}, {3, 0, 0}},      {-0.375f, {2, 1, 0}, {2, 1, 0}},
		{-1.125f, {3, 3, 0}, {3, 3, 0}},      {-1.625f, {1, 1, 0}, {1, 1, 0}},
		{-2.25f, {3, 1, 0}, {2.5f, 0.5f, 0}}, {1e30f, {0, 0, 3}, {1.5f, 0, 3}},
		{-INFINITY, {0, 0, 0}, {1.5f, 0, 0}}, {INFINITY, {0, 0, 3}, {1.5f, 0, 3}},
		{NAN, {0, 0, 0}, {1.5f, 0, 0}},
	};
	stilb_image across = {4, 1, 1, STILB_IMAGE_F32_LINEAR, texels, 0};
	stilb_image down = {1, 4, 1, STILB_IMAGE_F32_LINEAR, texels, 0};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		for (uint8_t wrap = 0; wrap < STILB_SCENE_WRAPS; wrap++)
			for (int nearest = 0; nearest < 2; nearest++) {
				stilb_scene_map map = map_of(1);
				float want = nearest ? rows[i].nearest[wrap] : rows[i].between[wrap], other = 0.3f;
				map.nearest = nearest;
				map.to_u[1] = map.to_v[0] = 0.0f;
				map.wrap_u = wrap;
				/* NaN in one number of a place is in both of the texture's: 0 times NaN */
				if (isfinite(rows[i].at)) {
					SHADE_PROOF_NEAR(grey_at(&across, &map, rows[i].at, other), (double)want, 0.0, 1e-6);
					map.wrap_u = STILB_SCENE_REPEAT;
					map.wrap_v = wrap;
					SHADE_PROOF_NEAR(grey_at(&down, &map, other, rows[i].at), (double)want, 0.0, 1e-6);
				} else {
					map.to_u[0] = 0.0f;
					map.to_u[2] = rows[i].at;
					SHADE_PROOF_NEAR(grey_at(&across, &map, 0.0f, other), (double)want, 0.0, 1e-6);
				}
			}
}

/* Places that no float can hold, by a transform or a file, are some texel of the texture. */
static void any_place_is_a_texel(void **state)
{
	(void)state;
	static const float hostile[] = {NAN,        INFINITY, -INFINITY, 3e38f, -3e38f, 1e7f, -1e7f,      0x1p-126f,
	                                -0x1p-149f, -1e-9f,   1.0f,      2.0f,  -1.0f,  0.0f, 0.99999994f};
	static float texels[3][5][2];
	for (int i = 0; i < 30; i++)
		(&texels[0][0][0])[i] = 0.25f + 0.025f * (float)(i % 30);
	stilb_image image = {5, 3, 2, STILB_IMAGE_F32_LINEAR, texels, 0};
	uint32_t places = sizeof hostile / sizeof *hostile;
	for (uint32_t i = 0; i < places * places * 9 * 4; i++) {
		stilb_scene_map map = map_of(1);
		map.wrap_u = (uint8_t)(i % 3);
		map.wrap_v = (uint8_t)(i / 3 % 3);
		map.nearest = i / 9 % 2;
		map.to_u[0] = i / 18 % 2 ? 1e6f : 1.0f;
		stilb_vec4 got = gi_texture_map(&image, &map, (stilb_vec2){hostile[i / 36 % places], hostile[i / 36 / places]});
		assert_true(gi_texture_alpha(&image, &map, (stilb_vec2){hostile[i / 36 % places], hostile[i / 36 / places]}) ==
		            got[3]);
		for (int c = 0; c < 4; c++)
			assert_true(got[c] >= 0.2499f && got[c] <= 1.0f);
	}
}

/* Next to a texel that is infinite the others are what they are, and its light has a limit, as that of panoramas. */
static void infinite_texels(void **state)
{
	(void)state;
	static const float texels[2][2][4] = {{{1.0f, 2.0f, 3.0f, 0.5f}, {INFINITY, INFINITY, 1.0f, INFINITY}},
	                                      {{4.0f, 5.0f, 6.0f, 0.25f}, {NAN, 1e38f, 2e14f, 1.0f}}};
	stilb_image image = {2, 2, 4, STILB_IMAGE_F32_LINEAR, (void *)texels, 0};
	stilb_scene_map map = map_of(1);
	map.nearest = true;
	for (uint32_t i = 0; i < 4; i++) {
		stilb_vec2 at = {i % 2 ? 0.75f : 0.25f, i / 2 ? 0.75f : 0.25f};
		stilb_vec4 got = gi_texture_map(&image, &map, at);
		assert_memory_equal(&got, texels[i / 2][i % 2], sizeof got);
		assert_true(gi_texture_alpha(&image, &map, at) == got[3]);
	}
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.maps[STILB_SCENE_MAP_EMISSION] = map;
	surface.emission[0] = 0.0f;
	surface.emission[1] = 1e30f;
	surface.emission[2] = 2.0f;
	gi_maps maps = {&surface, &image, 1};
	gi_place place = {.uv = {{0.75f, 0.25f}}};
	SHADE_PROOF_NEAR3(gi_maps_emission(&maps, &place), 0.0, 1e15, 2.0, 1e-6, 0.0);
	place.uv[0][1] = 0.75f;
	SHADE_PROOF_NEAR3(gi_maps_emission(&maps, &place), 0.0, 1e15, 4e14, 1e-6, 0.0);
}

/* One texel of each format and number of channels: colour is decoded where it is sRGB, alpha never is. */
static void formats_and_channels(void **state)
{
	(void)state;
	static uint8_t bytes[4] = {188, 51, 255, 102};
	static uint16_t words[4] = {48316, 13107, 65535, 26214}, halves[4] = {0x3800, 0x3266, 0x3c00, 0x3666};
	static float floats[4] = {0.5f, 0.2f, 1.0f, 0.4f};
	struct {
		stilb_image_format format;
		void *pixels;
		double first, second, alpha;
	} rows[] = {
		{STILB_IMAGE_U8_SRGB, bytes, 0.50289, 0.033105, 0.4},  {STILB_IMAGE_U8_LINEAR, bytes, 0.737255, 0.2, 0.4},
		{STILB_IMAGE_U16_SRGB, words, 0.50289, 0.033105, 0.4}, {STILB_IMAGE_U16_LINEAR, words, 0.737255, 0.2, 0.4},
		{STILB_IMAGE_F16_LINEAR, halves, 0.5, 0.2, 0.4},       {STILB_IMAGE_F32_LINEAR, floats, 0.5, 0.2, 0.4}};
	stilb_scene_map map = map_of(1);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		for (uint32_t channels = 1; channels <= 4; channels++) {
			stilb_image image = {1, 1, channels, rows[i].format, rows[i].pixels, 0};
			stilb_vec4 got = gi_texture_map(&image, &map, (stilb_vec2){0.3f, 0.7f});
			bool grey = channels < 3;
			SHADE_PROOF_NEAR3(got, rows[i].first, grey ? rows[i].first : rows[i].second, grey ? rows[i].first : 1.0,
			                  0.0, 3e-4);
			double alpha = channels == 4 ? rows[i].alpha : channels == 2 ? 0.2 : 1.0;
			SHADE_PROOF_NEAR(got[3], alpha, 0.0, 3e-4);
			assert_true(gi_texture_alpha(&image, &map, (stilb_vec2){0.3f, 0.7f}) == got[3]);
		}
	SHADE_PROOF_NEAR(gi_texture_map(&(stilb_image){0}, &map, (stilb_vec2){0})[3], 1.0, 0.0, 0.0);
}

/* ---- what is shaded ---------------------------------------------------------------------------------------------- */

#define CHECKS 8

static uint8_t check_texels[CHECKS][CHECKS][4];

/* White and black fields; alpha is 1 on white. */
static stilb_image checkers(void)
{
	for (int y = 0; y < CHECKS; y++)
		for (int x = 0; x < CHECKS; x++)
			memset(check_texels[y][x], (x + y) % 2 ? 0 : 255, 4);
	return (stilb_image){CHECKS, CHECKS, 4, STILB_IMAGE_U8_SRGB, check_texels, 0};
}

/* Which field of a checker board that repeats; NaN: too near to an edge. */
static float check_at(double u, double v)
{
	double x = (u - floor(u)) * CHECKS, y = (v - floor(v)) * CHECKS;
	if (fabs(x - round(x)) < 1e-3 || fabs(y - round(y)) < 1e-3)
		return NAN;
	return ((int)x + (int)y) % 2 ? 0.0f : 1.0f;
}

static void checkers_by_transform_and_set(void **state)
{
	(void)state;
	stilb_image image = checkers();
	maps_square square;
	maps_square_make(&square, -1.0f); /* the two sets differ */
	for (int set = 0; set < 2; set++) {
		stilb_scene_surface surface = stilb_scene_surface_make();
		float turn = 0.4f, scale = 1.7f;
		surface.ior = 1.0f; /* no highlight */
		surface.color[1] = 0.5f;
		surface.maps[STILB_SCENE_MAP_COLOR] =
			(stilb_scene_map){.texture = 1,
		                      .set = (uint8_t)set,
		                      .nearest = true,
		                      .to_u = {cosf(turn) * scale, sinf(turn) * scale, 0.31f},
		                      .to_v = {-sinf(turn) * scale, cosf(turn) * scale, -0.77f}};
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), set == 1);
		shade_proof_random random = {.seed = 3};
		uint32_t white = 0, count = 0;
		for (int i = 0; i < 2000; i++) {
			float x = shade_proof_range(&random, -0.999f, 0.999f), y = shade_proof_range(&random, -0.999f, 0.999f);
			double u = 0.5 + (set == 0 ? -0.5 : 0.5) * (double)x, v = 0.5 - 0.5 * (double)y;
			const stilb_scene_map *map = &surface.maps[STILB_SCENE_MAP_COLOR];
			float want = check_at((double)map->to_u[0] * u + (double)map->to_u[1] * v + (double)map->to_u[2],
			                      (double)map->to_v[0] * u + (double)map->to_v[1] * v + (double)map->to_v[2]);
			if (isnan(want))
				continue;
			gi_surface at = maps_at_point(world.gi, x, y);
			SHADE_PROOF_NEAR3(at.diffuse, (double)want, 0.5 * (double)want, (double)want, 0.0, 1e-6);
			white += want > 0.5f;
			count++;
		}
		assert_in_range(white * 100 / count, 40, 60);
		world_finish(&world);
	}
}

static void colours_of_vertices_multiply(void **state)
{
	(void)state;
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (uint32_t i = 0; i < 4; i++) {
		square.extras[i].color[0] = i & 1 ? 1.0f : 0.0f; /* grows along x */
		square.extras[i].color[2] = 0.25f;
	}
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.ior = 1.0f;
	surface.color[0] = 0.5f;
	for (int movable = 0; movable < 2; movable++) {
		world_fixture world = maps_trace(maps_scene(&square, &surface, NULL, 0, &here), movable);
		SHADE_PROOF_NEAR3(maps_at_point(world.gi, 0.5f, 0.2f).diffuse, 0.375, 1.0, 0.25, 0.0, 1e-6);
		SHADE_PROOF_NEAR3(maps_at_point(world.gi, -0.5f, -0.9f).diffuse, 0.125, 1.0, 0.25, 0.0, 1e-6);
		world_finish(&world);
	}
}

/* Factors times texels, in both workflows, against the numbers that glTF's formulas have. */
static void workflows(void **state)
{
	(void)state;
	static float reflection[4] = {0.9f, 0.5f, 0.25f, 0.5f}, tint[4] = {0.5f, 1.0f, 2.0f, 0.5f},
				 glow[3] = {0.5f, -1.0f, 2.0f};
	stilb_image images[] = {{1, 1, 4, STILB_IMAGE_F32_LINEAR, reflection, 0},
	                        {1, 1, 4, STILB_IMAGE_F32_LINEAR, tint, 0},
	                        {1, 1, 3, STILB_IMAGE_F32_LINEAR, glow, 0}};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.color[0] = 0.8f;
	surface.color[1] = surface.color[2] = 0.5f;
	surface.metalness = 1.0f;
	surface.roughness = 0.6f;
	surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 1;
	surface.maps[STILB_SCENE_MAP_SPECULAR].texture = 2;
	surface.maps[STILB_SCENE_MAP_SPECULAR_COLOR].texture = 2;
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 3;
	surface.emission[0] = surface.emission[1] = surface.emission[2] = 4.0f;
	world_fixture world = maps_trace(maps_scene(&square, &surface, images, 3, &here), false);
	gi_surface at = maps_at_point(world.gi, 0.1f, 0.2f);
	/* dielectric: 0.04 tinted, times 0.5; metalness 0.25, roughness 0.3 */
	SHADE_PROOF_NEAR3(at.specular, 0.75 * 0.01 + 0.2, 0.75 * 0.02 + 0.125, 0.75 * 0.04 + 0.125, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(at.diffuse, 0.8 * 0.75 * 0.96, 0.5 * 0.75 * 0.96, 0.5 * 0.75 * 0.96, 0.0, 1e-6);
	SHADE_PROOF_NEAR(at.roughness, 0.3, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(at.emission, 2.0, 0.0, 8.0, 0.0, 1e-6);
	at = maps_look(world.gi, stilb_vec3_make(0.1f, 0.2f, -1.0f), stilb_vec3_make(0.0f, 0.0f, 1.0f));
	SHADE_PROOF_NEAR3(at.emission, 0.0, 0.0, 0.0, 0.0, 0.0);
	world_finish(&world);
	surface.workflow = STILB_SCENE_SPECULAR;
	surface.specular[0] = surface.specular[1] = surface.specular[2] = 0.5f;
	world = maps_trace(maps_scene(&square, &surface, images, 3, &here), false);
	at = maps_at_point(world.gi, 0.1f, 0.2f);
	SHADE_PROOF_NEAR3(at.specular, 0.45, 0.25, 0.125, 0.0, 1e-6);
	SHADE_PROOF_NEAR3(at.diffuse, 0.8 * 0.55, 0.5 * 0.55, 0.5 * 0.55, 0.0, 1e-6);
	SHADE_PROOF_NEAR(at.roughness, 1.0 - 0.4 * 0.5, 0.0, 1e-6);
	world_finish(&world);
}

/* A surface without maps is as one with a white map, and gi_primary's fast way has it. */
static void constants_are_the_surface(void **state)
{
	(void)state;
	static uint8_t white[4] = {255, 255, 255, 255};
	stilb_image image = {1, 1, 4, STILB_IMAGE_U8_SRGB, white, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.color[0] = 0.3f;
	surface.metalness = 0.4f;
	surface.roughness = 0.7f;
	surface.emission[2] = 1.5f;
	gi_surface at[2];
	for (uint32_t texture = 0; texture < 2; texture++) {
		surface.maps[STILB_SCENE_MAP_COLOR].texture = texture;
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
		assert_int_equal(world.gi->parts[0].plain, texture == 0);
		at[texture] = maps_at_point(world.gi, 0.3f, 0.4f);
		world_finish(&world);
	}
	for (int i = 0; i < 3; i++) {
		assert_true(at[0].diffuse[i] == at[1].diffuse[i] && at[0].specular[i] == at[1].specular[i]);
		assert_true(at[0].emission[i] == at[1].emission[i]);
	}
	assert_true(at[0].roughness == at[1].roughness && at[0].roughness == 0.7f);
}

/* ---- normals ----------------------------------------------------------------------------------------------------- */

/* Turned about an axis, scaled, and mirrored along x if mirror is -1. */
static stilb_mat4 placed(float about_x, float about_z, float scale, float mirror)
{
	float cx = cosf(about_x), sx = sinf(about_x), cz = cosf(about_z), sz = sinf(about_z);
	stilb_mat4 x = {{mirror * scale, 0, 0, 0, 0, cx * scale, sx * scale, 0, 0, -sx * scale, cx * scale, 0, 0, 0, 0, 1}};
	stilb_mat4 z = {{cz, sz, 0, 0, -sz, cz, 0, 0, 0, 0, 1, 0, 0.5f, 2.0f, -1.0f, 1}};
	return stilb_mat4_multiply(z, x);
}

static stilb_vec3 moved(const stilb_mat4 *m, stilb_vec3 v, float place)
{
	stilb_vec3 out = {0};
	for (int i = 0; i < 3; i++)
		out[i] = m->m[i] * v[0] + m->m[4 + i] * v[1] + m->m[8 + i] * v[2] + m->m[12 + i] * place;
	return out;
}

static const float tilt[3] = {0.36f, 0.48f, 0.8f}; /* towards +X and +Y of the square */

/* A map of one tilt on squares at every place, mirrored or not, as copies and as instances, with uv as they are and
 * mirrored, from the front and from behind, is the square's geometry tilted by that. channels 2: z is made of x, y. */
static void tilted_normals_are_tilted_geometry(void **state)
{
	(void)state;
	for (int i = 0; i < 64; i++) {
		float sign = i & 1 ? -1.0f : 1.0f, mirror = i & 2 ? -1.0f : 1.0f;
		bool movable = i & 4, behind = i & 8, two = i & 16, stretched = i & 32;
		float texel[3] = {0.5f + 0.5f * sign * tilt[0], 0.5f + 0.5f * tilt[1], 0.5f + 0.5f * tilt[2]};
		stilb_image image = {1, 1, two ? 2 : 3, STILB_IMAGE_F32_LINEAR, texel, 0};
		maps_square square;
		maps_square_make(&square, sign);
		for (int k = 0; k < 4; k++) /* a file may have both of any length */
			square.extras[k].tangent[3] = sign;
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
		stilb_mat4 place = placed(0.3f * (float)i, 0.9f * (float)i, stretched ? 2.5f : 0.2f, mirror);
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &place), movable);
		assert_int_equal(world.gi->parts[0].instance, movable);
		stilb_vec3 n = stilb_vec3_make(tilt[0], tilt[1], tilt[2]),
				   up = stilb_vec3_make(0.0f, 0.0f, behind ? -1.0f : 1.0f);
		stilb_vec3 target = moved(&place, stilb_vec3_make(0.2f, -0.3f, 0.0f), 1.0f), axis = moved(&place, up, 0.0f);
		gi_surface at = maps_look(world.gi, target + axis, -axis);
		stilb_vec3 want = stilb_vec3_normalize(moved(&place, behind ? -n : n, 0.0f));
		SHADE_PROOF_NEAR3(at.normal, (double)want[0], (double)want[1], (double)want[2], 0.0, 2e-6);
		assert_int_equal(at.front, !behind);
		world_finish(&world);
	}
}

/* Where a place is sheared, the tangent goes with the triangle's points and the normal stays across it; the map is in
 * the frame of both. */
static void sheared_frames(void **state)
{
	(void)state;
	static float texel[3] = {0.5f + 0.5f * 0.36f, 0.5f + 0.5f * 0.48f, 0.9f};
	static const stilb_mat4 sheared = {{1, 0.5f, 0, 0, 0.25f, 1, 0, 0, 0.1f, 0, 1, 0, 0, 0, 0, 1}};
	stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	for (int movable = 0; movable < 2; movable++) {
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &sheared), movable);
		assert_int_equal(world.gi->parts[0].instance, movable);
		stilb_vec3 t = stilb_vec3_normalize(stilb_vec3_make(1.0f, 0.5f, 0.0f)), n = stilb_vec3_make(0.0f, 0.0f, 1.0f);
		stilb_vec3 want = t * 0.36f + stilb_vec3_cross(n, t) * 0.48f + n * 0.8f;
		stilb_vec3 got = maps_at_point(world.gi, 0.1f, 0.1f).normal;
		SHADE_PROOF_NEAR3(got, (double)want[0], (double)want[1], (double)want[2], 0.0, 2e-6);
		world_finish(&world);
	}
}

/* The strength of a map; without a tangent it is left out. */
static void normals_scaled_or_without_tangent(void **state)
{
	(void)state;
	static float texel[3] = {0.5f + 0.5f * 0.36f, 0.5f + 0.5f * 0.48f, 0.9f};
	stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	surface.normal_scale = 0.5f;
	world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
	stilb_vec3 want = stilb_vec3_normalize(stilb_vec3_make(0.18f, 0.24f, 0.8f));
	SHADE_PROOF_NEAR3(maps_at_point(world.gi, 0.0f, 0.1f).normal, (double)want[0], (double)want[1], (double)want[2],
	                  0.0, 1e-6);
	world_finish(&world);
	for (int i = 0; i < 4; i++)
		memset(square.extras[i].tangent, 0, sizeof square.extras[i].tangent);
	world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
	SHADE_PROOF_NEAR3(maps_at_point(world.gi, 0.0f, 0.1f).normal, 0.0, 0.0, 1.0, 0.0, 1e-6);
	world_finish(&world);
}

/* Whatever a map says, the viewer and its mirrored direction are above normal and triangle; what is so already stays as
 * it is. */
static void mirrored_views_stay_above(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 8};
	uint32_t kept = 0, lifted = 0;
	for (int map = 0; map < 40; map++) {
		stilb_vec3 n = world_direction(&random);
		float texel[3] = {0.5f + 0.5f * n[0], 0.5f + 0.5f * n[1], 0.5f + 0.5f * n[2]};
		stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
		maps_square square;
		maps_square_make(&square, 1.0f);
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
		for (int i = 0; i < 200; i++) {
			stilb_vec3 v = world_direction(&random);
			v[2] = fabsf(v[2]) * (i % 4 ? 1.0f : 1e-2f) + 1e-4f;
			v = stilb_vec3_normalize(v);
			gi_surface at = maps_look(world.gi, stilb_vec3_make(0.1f, 0.1f, 0.0f) + v, -v);
			stilb_vec3 mirrored = at.normal * (2.0f * stilb_vec3_dot(at.normal, v)) - v;
			float before = 2.0f * stilb_vec3_dot(n, v) * n[2] - v[2];
			SHADE_PROOF_NEAR(stilb_vec3_dot(at.normal, at.normal), 1.0, 0.0, 1e-5);
			assert_true(stilb_vec3_dot(at.normal, v) > 0.0f && at.normal[2] > 0.0f);
			assert_true(mirrored[2] > 0.0f);
			if (stilb_vec3_dot(n, v) > 1.1f * GI_NORMAL_LOWEST && before > 1.1f * GI_NORMAL_LOWEST) {
				SHADE_PROOF_NEAR3(at.normal, (double)n[0], (double)n[1], (double)n[2], 0.0, 2e-6);
				kept++;
			} else {
				lifted++;
			}
		}
		world_finish(&world);
	}
	assert_true(kept > 500 && lifted > 500);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* A square and, from its lower edge towards the camera, a floor. */
static stilb_scene *corner_scene(const stilb_scene_surface *surface, const stilb_image *image)
{
	static const stilb_mat4 floor = {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, -1, 1, 1}};
	stilb_scene_surface white = stilb_scene_surface_make();
	stilb_scene_camera camera = {.position = {0.0f, 0.0f, 5.0f}, .fov_y = 0.5f, .near_z = 0.1f, .far_z = 100.0f};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	if (image)
		stilb_scene_build_texture(build, image);
	maps_add(build, &square.mesh, surface, &here);
	maps_add(build, &square.mesh, &white, &floor);
	stilb_scene_build_camera(build, &camera);
	return maps_end(build);
}

/* In the dark: camera rays see its colour, nothing is lit by it, and it reflects nothing. Indirect light has none. */
static void unlit_is_seen_and_lights_nothing(void **state)
{
	(void)state;
	static const stilb_gi_integrator integrators[] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_DIRECT,
	                                                  STILB_GI_INTEGRATOR_MONTECARLO, STILB_GI_INTEGRATOR_SPLIT,
	                                                  STILB_GI_INTEGRATOR_PATH};
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.unlit = true;
	surface.color[0] = 0.25f;
	surface.emission[1] = 3.0f;
	path_fixture fixture = path_fixture_make(corner_scene(&surface, NULL));
	path_samples *samples = stilb_memory_alloc(1, sizeof *samples);
	assert_non_null(samples);
	assert_int_equal(stilb_gi_scene_info_of(fixture.gi)->lights, 0);
	for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
		gi_view view = path_view(&fixture, integrators[i], 16, 1);
		uint32_t seen = 0, dark = 0;
		view.settings.only = i == 4 ? STILB_GI_ONLY_INDIRECT : STILB_GI_ALL_LIGHT;
		view.settings.rays = 4;
		view.settings.depth = 3;
		path_samples_take(&view, 0, 256, samples);
		path_samples_shade(&view, samples);
		for (uint32_t k = 0; k < samples->count; k++) {
			stilb_vec3 got = samples->radiance[k];
			bool color = got[0] == 0.25f && got[1] == 1.0f && got[2] == 1.0f;
			assert_true(color || (got[0] == 0.0f && got[1] == 0.0f && got[2] == 0.0f));
			assert_true(!color || samples->rays[k].hit.part == 0);
			seen += color;
			dark += gi_is_hit(&samples->rays[k]) && samples->rays[k].hit.part == 1;
		}
		assert_true(i == 4 ? seen == 0 : seen > 50);
		assert_true(dark > 10);
	}
	free(samples);
	path_fixture_finish(&fixture);
}

/* The albedo beside a picture, which denoisers want, has the texels, of packets of rays too. */
static void albedo_has_texels(void **state)
{
	(void)state;
	stilb_image image = checkers();
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.ior = 1.0f;
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
	for (int unlit = 0; unlit < 2; unlit++) {
		surface.unlit = unlit;
		render_fixture fixture = {.scene = corner_scene(&surface, &image)};
		world_fixture world = maps_trace(fixture.scene, false);
		fixture.pool = world.pool;
		fixture.gi = world.gi;
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.width = settings.height = 64;
		settings.samples = 1;
		settings.integrator = STILB_GI_INTEGRATOR_COLOR;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		stilb_gi_film film = stilb_gi_render_film(render);
		uint32_t white = 0, black = 0;
		for (uint32_t i = 0; i < 64 * 40; i++) { /* above the floor */
			if (!(film.depth[i] < 100.0f))
				continue;
			assert_true(film.albedo[3 * i] == film.radiance[3 * i]);
			white += film.albedo[3 * i] == 1.0f;
			black += film.albedo[3 * i] == 0.0f;
		}
		assert_true(white > 300 && black > 300);
		stilb_gi_render_destroy(render);
		render_fixture_finish(&fixture);
	}
}

static void same_bits_for_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	stilb_image image = checkers();
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.emission[0] = 1.0f;
	surface.maps[STILB_SCENE_MAP_COLOR].texture = surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 1;
	uint64_t first = 0;
	for (size_t w = 0; w < sizeof workers / sizeof *workers; w++) {
		world_fixture world = world_trace(corner_scene(&surface, &image), &stilb_gi_embree, workers[w]);
		render_fixture fixture = {.pool = world.pool, .scene = world.scene, .gi = world.gi};
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		uint64_t hash = render_whole(&fixture, &settings);
		first = w == 0 ? hash : first;
		assert_true(hash == first);
		render_fixture_finish(&fixture);
	}
}

/* ---- hashes ------------------------------------------------------------------------------------------------------ */

static uint64_t hash_of(const maps_square *square, const stilb_scene_surface *surface, const stilb_image *image)
{
	world_fixture world = maps_trace(maps_scene(square, surface, image, 1, &here), false);
	uint64_t hash = gi_scene_hash(world.gi);
	world_finish(&world);
	return hash;
}

/* Checkpoints and caches belong to a surface, its maps, and what vertices have besides; not to bytes between
 * members. */
static void hashes_know_surfaces(void **state)
{
	(void)state;
	stilb_image image = checkers();
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make(), other = surface;
	uint64_t hashes[12];
	uint32_t count = 0;
	hashes[count++] = hash_of(&square, &surface, &image);
	((char *)&other)[offsetof(stilb_scene_surface, unlit) + 1] ^= 0x3c;
	assert_true(hash_of(&square, &other, &image) == hashes[0]);
#define CHANGED(change)                                                                                                \
	other = surface;                                                                                                   \
	change;                                                                                                            \
	hashes[count++] = hash_of(&square, &other, &image)
	CHANGED(other.cutoff = 0.25f);
	CHANGED(other.one_sided = true);
	CHANGED(other.unlit = true);
	CHANGED(other.maps[STILB_SCENE_MAP_THICKNESS].texture = 1);
	CHANGED(other.maps[STILB_SCENE_MAP_COLOR].wrap_v = STILB_SCENE_CLAMP);
	CHANGED(other.attenuation_distance = 2.0f);
	CHANGED(other.anisotropy = 0.5f);
	CHANGED(other.color[3] = 0.5f);
#undef CHANGED
	square.extras[2].color[1] = 0.5f;
	hashes[count++] = hash_of(&square, &surface, &image);
	square.extras[2].uv[0] = 0.5f;
	hashes[count++] = hash_of(&square, &surface, &image);
	check_texels[1][2][3] ^= 1;
	hashes[count++] = hash_of(&square, &surface, &image);
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t k = 0; k < i; k++)
			assert_true(hashes[i] != hashes[k]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wraps_against_a_table),
		cmocka_unit_test(any_place_is_a_texel),
		cmocka_unit_test(infinite_texels),
		cmocka_unit_test(formats_and_channels),
		cmocka_unit_test(checkers_by_transform_and_set),
		cmocka_unit_test(colours_of_vertices_multiply),
		cmocka_unit_test(workflows),
		cmocka_unit_test(constants_are_the_surface),
		cmocka_unit_test(tilted_normals_are_tilted_geometry),
		cmocka_unit_test(sheared_frames),
		cmocka_unit_test(normals_scaled_or_without_tangent),
		cmocka_unit_test(mirrored_views_stay_above),
		cmocka_unit_test(unlit_is_seen_and_lights_nothing),
		cmocka_unit_test(albedo_has_texels),
		cmocka_unit_test(same_bits_for_workers),
		cmocka_unit_test(hashes_know_surfaces),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
