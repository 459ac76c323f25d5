/* Surfaces on the device, against closed forms: texels, wraps, transforms and both uv, factors, normals, occlusion,
 * emission, colours of vertices, one-sided and unlit ones, and edits; the same bits in all modes; under the validation
 * layer. */
#include "shading/shade_brdf.h"
#include "shading/shade_gltf.h"
#include "shading/shade_srgb.h"

#include "maps_stage.h" /* names a type as these name variables */

#define HALF 1e-3 /* a half float is off by 2^-11 of the value */

/* ---- texels ------------------------------------------------------------------------------------------------------ */

#define TEXELS 6u

static uint32_t texel_code(uint32_t x, uint32_t y, uint32_t c)
{
	return (41 * x + 89 * y + 59 * c + 13 * x * y) % 256;
}

static stilb_image texel_image(stilb_image_format format, uint32_t channels, uint32_t width, uint32_t height)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, width, height, channels, format), STILB_OK);
	for (uint32_t i = 0; i < width * height * channels; i++) {
		uint32_t pixel = i / channels, code = texel_code(pixel % width, pixel / width, i % channels);
		if (format == STILB_IMAGE_U8_SRGB || format == STILB_IMAGE_U8_LINEAR)
			((uint8_t *)image.pixels)[i] = (uint8_t)code;
		else if (format == STILB_IMAGE_U16_SRGB || format == STILB_IMAGE_U16_LINEAR)
			((uint16_t *)image.pixels)[i] = (uint16_t)(code * 257);
		else if (format == STILB_IMAGE_F16_LINEAR)
			((uint16_t *)image.pixels)[i] = stilb_image_half_from_float((float)code / 256.0f);
		else
			((float *)image.pixels)[i] = (float)code / 256.0f;
	}
	return image;
}

static double texel_value(stilb_image_format format, uint32_t channels, uint32_t x, uint32_t y, uint32_t c)
{
	uint32_t code = texel_code(x, y, channels < 3 ? 0 : c);
	if (format == STILB_IMAGE_F16_LINEAR || format == STILB_IMAGE_F32_LINEAR)
		return code / 256.0;
	double v = code / 255.0; /* the sRGB transfer, IEC 61966-2-1 */
	if (format == STILB_IMAGE_U8_LINEAR || format == STILB_IMAGE_U16_LINEAR)
		return v;
	return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* The picture shows the texels as squares, a whole number of pixels each. */
static void assert_texels(const stilb_image *image, stilb_image_format format, uint32_t channels, uint32_t width,
                          uint32_t height)
{
	for (uint32_t y = 0; y < image->height; y++)
		for (uint32_t x = 0; x < image->width; x++)
			for (int c = 0; c < 3; c++) {
				double want =
					texel_value(format, channels, x * width / image->width, y * height / image->height, (uint32_t)c);
				/* lavapipe decodes 8-bit sRGB by a polynomial. */
				double off = format == STILB_IMAGE_U8_SRGB ? 1.2e-3 : 1e-4;
				assert_near("a texel", picture_value(image, x, y, c), want, 1e-3 * want + off);
			}
}

static void texels_of_every_format(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	for (uint32_t kind = 0; kind < 4 * STILB_IMAGE_BC1_SRGB; kind += 1 + 4 * TEST_ASAN) {
		stilb_image_format format = (stilb_image_format)(kind % STILB_IMAGE_BC1_SRGB);
		uint32_t channels = 1 + kind / STILB_IMAGE_BC1_SRGB;
		stilb_image image = texel_image(format, channels, TEXELS, TEXELS);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
		surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
		stage_show_square(&s, &q, &surface, &image, 1);
		stilb_image picture = stage_picture(&s);
		assert_texels(&picture, format, channels, TEXELS, TEXELS);
		stilb_image_finish(&picture);
		stilb_image_finish(&image);
	}
	stage_close(&s);
}

/* Widths and heights that are odd, or 1. */
static void texels_of_odd_sizes(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{1, 1}, {3, 1}, {1, 4}, {3, 2}, {8, 3}, {12, 24}};
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
		stilb_image image = texel_image(STILB_IMAGE_U8_LINEAR, 3, sides[i][0], sides[i][1]);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
		surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
		stage_show_square(&s, &q, &surface, &image, 1);
		stilb_image picture = stage_picture(&s);
		assert_texels(&picture, STILB_IMAGE_U8_LINEAR, 3, sides[i][0], sides[i][1]);
		stilb_image_finish(&picture);
		stilb_image_finish(&image);
	}
	stage_close(&s);
}

/* Stripes along u, while a pixel covers 42 texels along v: mips blur them, anisotropy does not. */
static void anisotropy_keeps_stripes(void **state)
{
	(void)state;
	stilb_image stripes;
	assert_int_equal(stilb_image_create(&stripes, 64, 64, 1, STILB_IMAGE_U8_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 64 * 64; i++)
		((uint8_t *)stripes.pixels)[i] = i / 16 % 2 ? 255 : 0;
	square q;
	square_make(&q, 1.0f);
	for (uint32_t turn = 0; turn < 3; turn++) { /* of the device's choice: none, in software */
		stage s = stage_open((stilb_render_desc){.max_anisotropy = turn == 2 ? 16 : turn}, 0);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR] = (stilb_scene_map){.texture = 1, .to_u = {1, 0, 0}, .to_v = {0, 16, 0}};
		stage_show_square(&s, &q, &surface, &stripes, 1);
		stilb_image picture = stage_picture(&s);
		double contrast = picture_value(&picture, 9, 12, 0) - picture_value(&picture, 14, 12, 0);
		bool kept = turn == 2 || (turn == 0 && !stilb_render_device_is_software(s.render));
		if (kept ? contrast < 0.8 : contrast > 0.3)
			fail_msg("contrast %.3f with anisotropy %u", contrast, turn);
		stilb_image_finish(&picture);
		stage_close(&s);
	}
	stilb_image_finish(&stripes);
}

/* Textures of one size are layers of an image; each square shows its own, also when others have changed or are drawn
 * without a surface. */
static void every_layer_is_its_own(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (uint32_t t = 0; t < 16; t++) {
		const uint8_t value[4] = {(uint8_t)(10 * t), (uint8_t)(255 - 10 * t), 7, 255};
		stilb_image image = image_even(4, value, STILB_IMAGE_U8_LINEAR);
		stilb_scene_surface surface = surface_unlit();
		stilb_scene_build_texture(build, &image);
		stilb_image_finish(&image);
		surface.maps[STILB_SCENE_MAP_COLOR].texture = t + 1;
		stilb_mat4 place = stilb_mat4_identity();
		place.m[0] = place.m[10] = 0.25f;
		place.m[12] = (float)(t % 4) * 0.5f - 0.75f;
		place.m[14] = (float)(t / 4) * 0.5f - 0.75f;
		stage_model(build, mesh, stage_material(build, &surface), place);
	}
	stage_show(&s, build);
	for (int turn = 0; turn < 2; turn++) {
		stilb_image picture = stage_picture(&s);
		for (uint32_t t = 0; t < 16; t++) {
			uint32_t x = t % 4 * STAGE_SIDE / 4 + 3, y = t / 4 * STAGE_SIDE / 4 + 3;
			double red = turn == 1 && t == 5 ? 200.0 : 10.0 * t;
			assert_near("a layer's red", picture_value(&picture, x, y, 0), red / 255, 2e-3);
			assert_near("a layer's green", picture_value(&picture, x, y, 1), (255 - 10.0 * t) / 255, 2e-3);
		}
		stilb_image_finish(&picture);
		const uint8_t other[4] = {200, 205, 7, 255};
		stilb_image image = image_even(4, other, STILB_IMAGE_U8_LINEAR);
		assert_int_equal(stilb_scene_set_texture(s.scene, 5, &image), STILB_OK);
		stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
		assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
		stilb_scene_changes_clear(s.scene);
		stilb_image_finish(&image);
	}
	assert_int_equal(s.render->device->arrays.count, 1);
	stilb_scene_material plain = stilb_scene_material_make((float[3]){0.5f, 0.5f, 0.5f}, (float[3]){0}, 0.5f);
	plain.diffuse_texture = 10; /* a layer by itself */
	assert_int_equal(stilb_scene_set_material(s.scene, 9, &plain), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	stilb_image picture = stage_picture(&s);
	double ratio = picture_value(&picture, 9, 15, 0) / picture_value(&picture, 9, 15, 1);
	assert_near("a layer by itself", ratio, 90.0 / 165.0, 5e-3);
	stilb_image_finish(&picture);
	stage_close(&s);
}

/* Bilinear between two texels, trilinear where the picture is smaller: a checker seen from afar is its mean. */
static void filters(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	static const uint8_t ends[6] = {0, 0, 0, 255, 255, 255};
	stilb_image two = {.width = 2, .height = 1, .channels = 3, .format = STILB_IMAGE_U8_LINEAR, .pixels = (void *)ends};
	stilb_scene_surface surface = surface_unlit();
	stilb_scene_map *map = &surface.maps[STILB_SCENE_MAP_COLOR];
	*map = (stilb_scene_map){.texture = 1, .wrap_u = STILB_SCENE_CLAMP, .to_u = {1, 0, 0}, .to_v = {0, 1, 0}};
	stage_show_square(&s, &q, &surface, &two, 1);
	stilb_image picture = stage_picture(&s);
	for (uint32_t x = 0; x < STAGE_SIDE; x++) {
		double u = (x + 0.5) / STAGE_SIDE * 2.0 - 0.5;
		assert_near("between two texels", picture_value(&picture, x, 3, 0), fmin(fmax(u, 0.0), 1.0), 0.005);
	}
	stilb_image_finish(&picture);
	stilb_image checker;
	assert_int_equal(stilb_image_create(&checker, 512, 512, 1, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (uint32_t i = 0; i < 512 * 512; i++)
		((uint8_t *)checker.pixels)[i] = (i + i / 512) % 2 ? 255 : 0;
	map->wrap_u = STILB_SCENE_REPEAT;
	stage_show_square(&s, &q, &surface, &checker, 1);
	assert_shows(&s, 0.5, 0.5, 0.5, 0.004);
	stilb_image_finish(&checker);
	stage_close(&s);
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* The texel of a row of n that a place shows. */
static uint32_t wrapped(double u, uint32_t n, uint32_t wrap)
{
	double t = floor(u * n);
	if (wrap == STILB_SCENE_CLAMP)
		return (uint32_t)fmin(fmax(t, 0.0), n - 1.0);
	double period = wrap == STILB_SCENE_MIRROR ? 2.0 * n : n, r = t - period * floor(t / period);
	return (uint32_t)(r < n ? r : 2.0 * n - 1.0 - r);
}

/* u from -1 to 2 and v from -2 to 1, each by each wrap, turned by a quarter, and of either uv. */
static void wraps_and_transforms(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 0.5f);
	stilb_image image = texel_image(STILB_IMAGE_U8_LINEAR, 3, 4, 4);
	for (uint32_t kind = 0; kind < 2 * STILB_SCENE_WRAPS * STILB_SCENE_WRAPS; kind += 1 + 4 * TEST_ASAN) {
		stilb_scene_surface surface = surface_unlit();
		uint32_t set = kind & 1, wrap_u = kind / 2 % 3, wrap_v = kind / 6;
		float scale = set ? 2.0f : 1.0f; /* which takes the second uv's half back */
		stilb_scene_map *map = &surface.maps[STILB_SCENE_MAP_COLOR];
		*map = (stilb_scene_map){.texture = 1,
		                         .set = (uint8_t)set,
		                         .nearest = true,
		                         .wrap_u = (uint8_t)wrap_u,
		                         .wrap_v = (uint8_t)wrap_v,
		                         .to_u = {0, 3 * scale, -1},
		                         .to_v = {-3 * scale, 0, 1}};
		stage_show_square(&s, &q, &surface, &image, 1);
		stilb_image picture = stage_picture(&s);
		for (uint32_t y = 0; y < STAGE_SIDE; y++)
			for (uint32_t x = 0; x < STAGE_SIDE; x++) {
				double u = 3.0 * (y + 0.5) / STAGE_SIDE - 1.0, v = 1.0 - 3.0 * (x + 0.5) / STAGE_SIDE;
				uint32_t i = wrapped(u, 4, wrap_u), j = wrapped(v, 4, wrap_v);
				for (int c = 0; c < 3; c++)
					assert_near("a wrapped texel", picture_value(&picture, x, y, c),
					            texel_value(STILB_IMAGE_U8_LINEAR, 3, i, j, (uint32_t)c), HALF);
			}
		stilb_image_finish(&picture);
	}
	stilb_image_finish(&image);
	stage_close(&s);
}

/* ---- factors ----------------------------------------------------------------------------------------------------- */

/* Colours of vertices multiply colour; between vertices they are interpolated. A mesh without extras has none. */
static void colours_of_vertices(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_unlit();
	surface.color[1] = 0.5f;
	for (int v = 0; v < 4; v++) {
		q.extras[v].color[0] = q.vertices[v].uv[0];
		q.extras[v].color[2] = 0.25f;
	}
	stage_show_square(&s, &q, &surface, NULL, 0);
	stilb_image picture = stage_picture(&s);
	for (uint32_t x = 0; x < STAGE_SIDE; x++) {
		assert_near("red", picture_value(&picture, x, 7, 0), (x + 0.5) / STAGE_SIDE, HALF);
		assert_near("green", picture_value(&picture, x, 7, 1), 0.5, HALF);
		assert_near("blue", picture_value(&picture, x, 7, 2), 0.25, HALF);
	}
	stilb_image_finish(&picture);
	q.mesh.extras = NULL;
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, 1.0, 0.5, 1.0, HALF);
	stage_close(&s);
}

/* Under a sky a matt surface shows its colour; metal and its map take it away, and occlusion dims it; emission adds. */
static void factors_under_a_sky(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	static const uint8_t codes[4] = {51, 102, 153, 204}; /* 0.2, 0.4, 0.6, 0.8 */
	stilb_image data = image_even(4, codes, STILB_IMAGE_U8_LINEAR), color = image_even(4, codes, STILB_IMAGE_U8_SRGB);
	stilb_image both[2] = {data, color};
	stilb_scene_surface surface = surface_matt();
	surface.color[0] = 0.5f;
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, 0.5, 1.0, 1.0, HALF);

	surface.metalness = 0.5f; /* of which the map leaves 0.6 */
	surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 1;
	stage_show_square(&s, &q, &surface, both, 2);
	assert_shows(&s, 0.35, 0.7, 0.7, HALF);

	surface.occlusion = 0.5f; /* of a texel of 0.2 leaves 0.6 */
	surface.maps[STILB_SCENE_MAP_OCCLUSION].texture = 1;
	stage_show_square(&s, &q, &surface, both, 2);
	assert_shows(&s, 0.35 * 0.6, 0.7 * 0.6, 0.7 * 0.6, HALF);

	reference_set3(surface.emission, 1.0f, 2.0f, 4.0f);
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 2;
	stage_show_square(&s, &q, &surface, both, 2);
	double red = (double)shade_srgb_to_linear(0.2f), green = (double)shade_srgb_to_linear(0.4f);
	double blue = (double)shade_srgb_to_linear(0.6f);
	assert_shows(&s, 0.21 + red, 0.42 + 2 * green, 0.42 + 4 * blue, 2e-3);

	surface = stilb_scene_surface_make();
	surface.workflow = STILB_SCENE_SPECULAR; /* what the strongest of 0.8 * 0.6 leaves */
	reference_set3(surface.specular, 0.8f, 0.8f, 0.8f);
	surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 1;
	stage_show_square(&s, &q, &surface, both, 2);
	assert_shows(&s, 0.52, 0.52, 0.52, HALF);

	surface = stilb_scene_surface_make(); /* the dielectric's highlight takes 0.04 */
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, 0.96, 0.96, 0.96, HALF);
	stilb_image_finish(&data);
	stilb_image_finish(&color);
	stage_close(&s);
}

/* Roughness and gloss: the highlight of a sun at the mirror's angle, against a material of constants. */
static void roughness_of_maps(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	static const uint8_t codes[4] = {255, 128, 255, 64};
	stilb_image data = image_even(4, codes, STILB_IMAGE_U8_LINEAR);
	stilb_scene_light sun = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .intensity = {1, 1, 1}};
	s.view.lights = &sun;
	s.view.light_count = 1;
	s.view.shading = stilb_render_shading_default();
	for (int gloss = 0; gloss < 2; gloss++) {
		float rough = gloss ? 1.0f - 0.9f * 64.0f / 255.0f : 0.9f * 128.0f / 255.0f;
		stilb_scene_surface surface = stilb_scene_surface_make(), plain = surface;
		plain.roughness = rough;
		surface.roughness = gloss ? 0.1f : 0.9f;
		surface.workflow = plain.workflow = gloss ? STILB_SCENE_SPECULAR : STILB_SCENE_METALLIC;
		reference_set3(surface.specular, 0.3f, 0.3f, 0.3f);
		reference_set3(plain.specular, 0.3f, gloss ? 0.3f * 128.0f / 255.0f : 0.3f, 0.3f);
		surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 1;
		stage_show_square(&s, &q, &plain, NULL, 0);
		stilb_image want = stage_picture(&s);
		stage_show_square(&s, &q, &surface, &data, 1);
		stilb_image got = stage_picture(&s);
		double least = 1e9, most = 0.0;
		for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
			double a = picture_value(&want, i % STAGE_SIDE, i / STAGE_SIDE, 0);
			double b = picture_value(&got, i % STAGE_SIDE, i / STAGE_SIDE, 0);
			assert_near("a highlight", b, a, 2e-3 * a + 1e-4);
			least = fmin(least, a);
			most = fmax(most, a);
		}
		assert_true(most > 1.001 * least); /* there is one */
		stilb_image_finish(&want);
		stilb_image_finish(&got);
	}
	stilb_image_finish(&data);
	stage_close(&s);
}

/* ---- normals ----------------------------------------------------------------------------------------------------- */

static const stilb_scene_light slanted = {
	.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.8f, 0.36f}, .intensity = {3, 3, 3}};

/* What a white matt surface with this normal shows of the light. */
static double lambert(dvec n)
{
	dvec l = dvec_mad((dvec){0, 0, 0}, -1.0, dvec_of(slanted.direction));
	return 3.0 / REFERENCE_PI * fmax(dvec_dot(dvec_unit(n), l), 0.0);
}

static double code_normal(uint8_t code)
{
	return code / 255.0 * 2.0 - 1.0;
}

static stage normal_stage(void)
{
	stage s = stage_open((stilb_render_desc){0}, 0);
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	s.view.lights = &slanted;
	s.view.light_count = 1;
	return s;
}

/* A map of one normal turns the surface as if it were tilted: x to the right, y up in the picture, which is -z. */
static void a_constant_normal_tilts(void **state)
{
	(void)state;
	static const uint8_t codes[4] = {178, 76, 231, 0};
	double x = code_normal(codes[0]), y = code_normal(codes[1]), z = code_normal(codes[2]);
	stage s = normal_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_image map = image_even(3, codes, STILB_IMAGE_U8_LINEAR), two = image_even(2, codes, STILB_IMAGE_U8_LINEAR);
	stilb_scene_surface surface = surface_matt();
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, lambert((dvec){0, 1, 0}), lambert((dvec){0, 1, 0}), lambert((dvec){0, 1, 0}), HALF);

	surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	stage_show_square(&s, &q, &surface, &map, 1);
	double want = lambert((dvec){x, z, -y});
	assert_true(fabs(want - lambert((dvec){0, 1, 0})) > 0.05 && fabs(want - lambert((dvec){x, z, y})) > 0.05);
	assert_shows(&s, want, want, want, HALF);

	surface.normal_scale = 0.5f;
	stage_show_square(&s, &q, &surface, &map, 1);
	want = lambert((dvec){x / 2, z, -y / 2});
	assert_shows(&s, want, want, want, HALF);

	surface.normal_scale = 1.0f; /* of two channels z is made */
	stage_show_square(&s, &q, &surface, &two, 1);
	want = lambert((dvec){x, sqrt(1.0 - x * x - y * y), -y});
	assert_shows(&s, want, want, want, HALF);

	q.mesh.extras = NULL; /* without tangents the map is left out */
	stage_show_square(&s, &q, &surface, &map, 1);
	want = lambert((dvec){0, 1, 0});
	assert_shows(&s, want, want, want, HALF);
	square_make(&q, 1.0f);
	for (int v = 0; v < 4; v++)
		memset(q.extras[v].tangent, 0, sizeof q.extras[v].tangent);
	stage_show_square(&s, &q, &surface, &map, 1);
	assert_shows(&s, want, want, want, HALF);
	stilb_image_finish(&map);
	stilb_image_finish(&two);
	stage_close(&s);
}

/* Shows the map on a square whose tangent has this sign, with this transform, seen from both sides. */
static void show_tilted(stage *s, const stilb_image *map, float sign, stilb_mat4 place)
{
	square q;
	square_make(&q, 1.0f);
	for (int v = 0; v < 4; v++)
		q.extras[v].tangent[3] = sign;
	stilb_scene_surface surface = surface_matt();
	surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_texture(build, map);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	stage_model(build, mesh, stage_material(build, &surface), place);
	stage_show(s, build);
}

/* Mirrored uv have the sign -1; a transform that mirrors or turns takes the map's normal with it. */
static void tangents_turn_with_the_mesh(void **state)
{
	(void)state;
	static const uint8_t codes[4] = {178, 76, 231, 0};
	double x = code_normal(codes[0]), y = code_normal(codes[1]), z = code_normal(codes[2]);
	stilb_image map = image_even(3, codes, STILB_IMAGE_U8_LINEAR);
	stage s = normal_stage();
	s.view.both_sides = true;
	show_tilted(&s, &map, -1.0f, stilb_mat4_identity());
	double want = lambert((dvec){x, z, y});
	assert_shows(&s, want, want, want, HALF);

	stilb_mat4 mirror = stilb_mat4_identity();
	mirror.m[0] = -1.0f; /* x to -x */
	show_tilted(&s, &map, 1.0f, mirror);
	want = lambert((dvec){-x, z, -y});
	assert_shows(&s, want, want, want, HALF);

	stilb_mat4 quarter = stilb_mat4_identity(); /* x to -z, z to x: to the left, seen from above */
	quarter.m[0] = quarter.m[10] = 0.0f;
	quarter.m[2] = -1.0f;
	quarter.m[8] = 1.0f;
	show_tilted(&s, &map, 1.0f, quarter);
	want = lambert((dvec){-y, z, -x});
	assert_shows(&s, want, want, want, HALF);

	stilb_mat4 over = stilb_mat4_identity(); /* turned over about x: its back is seen */
	over.m[5] = over.m[10] = -1.0f;
	show_tilted(&s, &map, 1.0f, over);
	want = lambert((dvec){-x, z, -y}); /* the normal is (x, -z, y), and the side that is seen the other one */
	assert_shows(&s, want, want, want, HALF);

	show_tilted(&s, &map, 1.0f, stilb_mat4_scale_translate(3.0f, 0.0f, 0.0f, 0.0f)); /* normals scale by 9 */
	want = lambert((dvec){x, z, -y});
	assert_shows(&s, want, want, want, HALF);

	stilb_mat4 flat = stilb_mat4_identity(); /* seen from above nothing changes, but along y */
	flat.m[5] = 4.0f;
	show_tilted(&s, &map, 1.0f, flat);
	want = lambert((dvec){x, z, -y});
	assert_shows(&s, want, want, want, HALF);
	stilb_image_finish(&map);
	stage_close(&s);
}

/* ---- sides ------------------------------------------------------------------------------------------------------- */

static void one_sided_ones_have_no_back(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	s.view.both_sides = true;
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	square q;
	square_make(&q, 1.0f);
	stilb_mat4 over = stilb_mat4_identity();
	over.m[5] = over.m[10] = -1.0f;
	for (int kind = 0; kind < 4; kind++) {
		stilb_scene_surface surface = surface_unlit();
		surface.one_sided = kind & 1;
		stilb_scene_build *build = stilb_scene_build_begin();
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
		stage_model(build, mesh, stage_material(build, &surface), kind & 2 ? over : stilb_mat4_identity());
		stage_show(&s, build);
		double want = kind == 3 ? 0.0 : 1.0;
		assert_shows(&s, want, want, want, HALF);
	}
	stage_close(&s);
}

/* ---- edits ------------------------------------------------------------------------------------------------------- */

static void update(stage *s)
{
	stilb_scene_changes changes = stilb_scene_changes_read(s->scene);
	if (stilb_render_update_scene(s->render, s->scene, &changes) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_changes_clear(s->scene);
}

/* The next frame shows another surface, another texture in its place, of another size, and a material without one. */
static void edits(void **state)
{
	(void)state;
	static const uint8_t dark[4] = {51, 51, 51, 255}, bright[4] = {204, 204, 204, 255};
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_image first = image_even(4, dark, STILB_IMAGE_U8_LINEAR),
				second = image_even(4, bright, STILB_IMAGE_U8_LINEAR);
	stilb_scene_surface surface = surface_unlit();
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	stage_show_square(&s, &q, &surface, &first, 1);
	assert_shows(&s, 0.2, 0.2, 0.2, HALF);
	uint64_t hash = stilb_render_stream_hash(s.render);

	surface.color[0] = 0.5f;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	update(&s);
	assert_shows(&s, 0.1, 0.2, 0.2, HALF);
	assert_true(stilb_render_stream_hash(s.render) != hash);

	assert_int_equal(stilb_scene_set_texture(s.scene, 0, &second), STILB_OK);
	update(&s);
	assert_shows(&s, 0.4, 0.8, 0.8, HALF);

	stilb_image larger = texel_image(STILB_IMAGE_U8_LINEAR, 3, 5, 3);
	memset(larger.pixels, 51, stilb_image_size(&larger));
	assert_int_equal(stilb_scene_set_texture(s.scene, 0, &larger), STILB_OK);
	update(&s);
	assert_shows(&s, 0.1, 0.2, 0.2, HALF);
	stilb_image_finish(&larger);

	stilb_scene_material material = s.scene->materials[0], plain = material;
	plain.surface = 0;
	assert_int_equal(stilb_scene_set_material(s.scene, 0, &plain), STILB_OK);
	update(&s);
	assert_shows(&s, 0.25, 0.25, 0.25, HALF);
	for (int f = 0; f < 4; f++) /* the surface's set is freed */
		stage_frame(&s);
	assert_int_equal(stilb_scene_set_material(s.scene, 0, &material), STILB_OK);
	update(&s);
	assert_shows(&s, 0.1, 0.2, 0.2, HALF);
	stilb_image_finish(&first);
	stilb_image_finish(&second);
	stage_close(&s);
}

/* A texture that a material without a surface has shown gets mips when a surface names it. */
static void a_texture_gets_mips_later(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_image checker;
	assert_int_equal(stilb_image_create(&checker, 512, 512, 1, STILB_IMAGE_U8_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 512 * 512; i++)
		((uint8_t *)checker.pixels)[i] = (i + i / 512) % 2 ? 255 : 0;
	stilb_scene_build *build = stilb_scene_build_begin();
	static const float white[3] = {1, 1, 1}, none[3] = {0};
	stilb_scene_material material = stilb_scene_material_make(white, none, 1.0f);
	material.diffuse_texture = 1 + stilb_scene_build_texture(build, &checker);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), made[2];
	for (int m = 0; m < 2; m++)
		made[m] = stilb_scene_build_material(build, &material);
	stage_model(build, mesh, made[0], stilb_mat4_identity());
	stage_show(&s, build);
	stage_frame(&s);
	stilb_scene_surface surface = surface_unlit();
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	uint32_t id;
	assert_int_equal(stilb_scene_add_surface(s.scene, &surface, &id), STILB_OK);
	material.diffuse_texture = 0;
	material.surface = 1 + id;
	assert_int_equal(stilb_scene_set_material(s.scene, made[0], &material), STILB_OK);
	update(&s);
	assert_shows(&s, 0.5, 0.5, 0.5, 0.003);
	stilb_image_finish(&checker);
	stage_close(&s);
}

/* ---- the spread of normals --------------------------------------------------------------------------------------- */

/* Four normals by turns, each this far from the surface's own; a pixel covers hundreds of them. */
static stilb_image bumps_of(double angle, uint32_t channels)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 512, 512, channels, STILB_IMAGE_U8_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 512 * 512; i++) {
		uint8_t *out = (uint8_t *)image.pixels + (size_t)i * channels;
		double x = (i % 2 ? 1 : -1) * sin(angle) * sqrt(0.5), y = (i / 512 % 2 ? 1 : -1) * sin(angle) * sqrt(0.5);
		out[0] = (uint8_t)(127.5 + 127.5 * x + 0.5);
		out[1] = (uint8_t)(127.5 + 127.5 * y + 0.5);
		if (channels > 2)
			out[2] = (uint8_t)(127.5 + 127.5 * cos(angle) + 0.5);
		if (channels > 3)
			out[3] = (uint8_t)i; /* nothing of a map of normals */
	}
	return image;
}

/* The largest difference of two pictures, as a share of the largest value. */
static double apart_of(const stilb_image *a, const stilb_image *b)
{
	double most = 0.0, largest = 0.0;
	for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
		double x = picture_value(a, i % STAGE_SIDE, i / STAGE_SIDE, 0);
		double y = picture_value(b, i % STAGE_SIDE, i / STAGE_SIDE, 0);
		most = fmax(most, fabs(x - y));
		largest = fmax(largest, fmax(x, y));
	}
	return most / largest;
}

static stage spread_stage(stilb_render_specular_aa aa)
{
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .intensity = {1, 1, 1}};
	stage s = stage_open((stilb_render_desc){.specular_aa = aa}, 0);
	s.view.lights = &sun;
	s.view.light_count = 1;
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	return s;
}

static stilb_image spread_picture(stage *s, square *q, const stilb_scene_surface *surface, const stilb_image *map)
{
	stage_show_square(s, q, surface, map, map ? 1 : 0);
	return stage_picture(s);
}

/* Bumps that are too small to be seen look like a rougher surface; without widening, like a smooth one. */
static void small_bumps_are_rough(void **state)
{
	(void)state;
	double angle = 0.25;
	float spread = (float)sqrt(2.0 * (1.0 - cos(angle))); /* 1 / sharpness is the variance, of narrow lobes */
	square q;
	square_make(&q, 1.0f);
	for (int turn = 0; turn < 6; turn++) { /* even: base; odd: coat. Then two channels, then four and half as steep */
		bool coat = turn % 2;
		stilb_image map = bumps_of(angle, turn / 2 == 0 ? 3 : turn / 2 == 1 ? 2 : 4);
		stage with = spread_stage(STILB_RENDER_SPECULAR_AA_VMF), without = spread_stage(STILB_RENDER_SPECULAR_AA_OFF);
		float scale = turn / 2 == 2 ? 0.5f : 1.0f, *roughness;
		stilb_scene_surface surface = stilb_scene_surface_make();
		roughness = coat ? &surface.clearcoat_roughness : &surface.roughness;
		surface.metalness = coat ? 0.0f : 1.0f;
		surface.clearcoat = coat ? 1.0f : 0.0f;
		*roughness = 0.3f;
		stilb_image smooth = spread_picture(&with, &q, &surface, NULL);
		*roughness = shade_gltf_widened(0.3f, spread * scale);
		stilb_image want = spread_picture(&with, &q, &surface, NULL);
		*roughness = 0.3f;
		surface.normal_scale = surface.clearcoat_normal_scale = scale;
		surface.maps[coat ? STILB_SCENE_MAP_CLEARCOAT_NORMAL : STILB_SCENE_MAP_NORMAL].texture = 1;
		stilb_image got = spread_picture(&with, &q, &surface, &map), off = spread_picture(&without, &q, &surface, &map);
		double near = apart_of(&got, &want), far = apart_of(&smooth, &want), left = apart_of(&off, &smooth);
		if (!(near < 0.03 && far > 0.1 + 4.0 * near && left < 0.1))
			fail_msg("turn %d: %.4f from the rougher one, which is %.4f from the smooth one; off: %.4f", turn, near,
			         far, left);
		stilb_image *pictures[] = {&smooth, &want, &got, &off, &map};
		for (int i = 0; i < 5; i++)
			stilb_image_finish(pictures[i]);
		stage_close(&with);
		stage_close(&without);
	}
}

/* A flat map is drawn with the same bits whether normals widen or not. */
static void flat_maps_change_no_bit(void **state)
{
	(void)state;
	stilb_image flat, pictures[2];
	square q;
	square_make(&q, 1.0f);
	assert_int_equal(stilb_image_create(&flat, 100, 60, 3, STILB_IMAGE_U8_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 100 * 60 * 3; i++)
		((uint8_t *)flat.pixels)[i] = i % 3 == 0 ? 141 : i % 3 == 1 ? 120 : 254;
	for (int turn = 0; turn < 2; turn++) {
		stage s = spread_stage(turn ? STILB_RENDER_SPECULAR_AA_OFF : STILB_RENDER_SPECULAR_AA_VMF);
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.roughness = 0.37f;
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
		pictures[turn] = spread_picture(&s, &q, &surface, &flat);
		stage_close(&s);
	}
	assert_memory_equal(pictures[0].pixels, pictures[1].pixels, stilb_image_size(&pictures[0]));
	stilb_image_finish(&pictures[0]);
	stilb_image_finish(&pictures[1]);
	stilb_image_finish(&flat);
}

/* A map of normals whose alpha another map reads keeps it, and does not widen; from an edit on, too. */
static void shared_maps_do_not_widen(void **state)
{
	(void)state;
	stilb_image map = bumps_of(0.25, 4);
	stage s = spread_stage(STILB_RENDER_SPECULAR_AA_VMF);
	square q;
	square_make(&q, 1.0f);
	for (uint32_t i = 0; i < 512 * 512; i++)
		((uint8_t *)map.pixels)[4 * i + 3] = 128;
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.metalness = 1.0f;
	surface.roughness = 0.3f;
	stilb_image smooth = spread_picture(&s, &q, &surface, NULL);
	surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	stilb_image rough = spread_picture(&s, &q, &surface, &map);
	surface.maps[STILB_SCENE_MAP_SHEEN_ROUGHNESS].texture = 1; /* which shows nothing: there is no sheen */
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	stilb_scene_material material = s.scene->materials[0];
	assert_int_equal(stilb_scene_set_material(s.scene, 0, &material), STILB_OK);
	update(&s);
	stilb_image shared = stage_picture(&s), again = spread_picture(&s, &q, &surface, &map);
	assert_true(apart_of(&smooth, &rough) > 0.2);
	assert_true(apart_of(&smooth, &shared) < 0.1); /* half a code more makes the mean tilt */
	assert_memory_equal(shared.pixels, again.pixels, stilb_image_size(&again));
	stilb_image *pictures[] = {&smooth, &rough, &shared, &again, &map};
	for (int i = 0; i < 5; i++)
		stilb_image_finish(pictures[i]);
	stage_close(&s);
}

/* ---- all modes --------------------------------------------------------------------------------------------------- */

#define CELLS 6u

/* Many squares with different surfaces, some without extras or without a surface. */
static void show_many(stage *s, const stilb_image *image)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t texture = 1 + stilb_scene_build_texture(build, image), meshes[2], materials[CELLS];
	static const float grey[3] = {0.5f, 0.4f, 0.3f}, none[3] = {0};
	square q;
	square_make(&q, 2.0f);
	meshes[0] = stilb_scene_build_mesh(build, &q.mesh);
	q.mesh.extras = NULL;
	meshes[1] = stilb_scene_build_mesh(build, &q.mesh);
	for (uint32_t m = 0; m < CELLS; m++) {
		stilb_scene_surface surface = m % 2 ? surface_matt() : surface_unlit();
		surface.color[0] = (float)(m + 1) / (float)CELLS;
		surface.maps[m % RENDER_MAPS].texture = texture;
		surface.maps[STILB_SCENE_MAP_COLOR].texture = m % 3 ? texture : 0;
		stilb_scene_material material = stilb_scene_material_make(grey, none, 0.5f);
		material.diffuse_texture = texture;
		materials[m] = m == 4 ? stilb_scene_build_material(build, &material) : stage_material(build, &surface);
	}
	for (uint32_t cell = 0; cell < CELLS * CELLS; cell++) {
		float scale = 1.0f / (float)CELLS;
		stage_model(build, meshes[cell % 5 == 0], materials[(cell * 5 + cell / CELLS) % CELLS],
		            stilb_mat4_scale_translate(scale, -1.0f + (float)(2 * (cell % CELLS) + 1) * scale, 0.0f,
		                                       -1.0f + (float)(2 * (cell / CELLS) + 1) * scale));
	}
	stage_show(s, build);
}

static void the_same_bits_in_all_modes(void **state)
{
	(void)state;
	stilb_image image = texel_image(STILB_IMAGE_U8_SRGB, 3, 8, 8), first = {0};
	uint64_t hash = 0;
	for (uint32_t kind = 0; kind < 18; kind += 1 + 4 * TEST_ASAN) {
		stilb_render_desc desc = {.replay = (stilb_render_replay_mode)(kind % 3),
		                          .materials = (stilb_render_materials)(kind / 3 % 3)};
		stage s = stage_open(desc, kind / 9 * 3);
		show_many(&s, &image);
		stilb_image picture = stage_picture(&s);
		if (!first.pixels) {
			first = picture;
			hash = stilb_render_stream_hash(s.render);
		} else {
			assert_memory_equal(picture.pixels, first.pixels, stilb_image_size(&first));
			assert_true(stilb_render_stream_hash(s.render) == hash);
			stilb_image_finish(&picture);
		}
		stage_close(&s);
	}
	stilb_image_finish(&first);
	stilb_image_finish(&image);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(texels_of_every_format),
		cmocka_unit_test(texels_of_odd_sizes),
		cmocka_unit_test(every_layer_is_its_own),
		cmocka_unit_test(filters),
		cmocka_unit_test(anisotropy_keeps_stripes),
		cmocka_unit_test(wraps_and_transforms),
		cmocka_unit_test(colours_of_vertices),
		cmocka_unit_test(factors_under_a_sky),
		cmocka_unit_test(roughness_of_maps),
		cmocka_unit_test(a_constant_normal_tilts),
		cmocka_unit_test(tangents_turn_with_the_mesh),
		cmocka_unit_test(one_sided_ones_have_no_back),
		cmocka_unit_test(edits),
		cmocka_unit_test(a_texture_gets_mips_later),
		cmocka_unit_test(small_bumps_are_rough),
		cmocka_unit_test(flat_maps_change_no_bit),
		cmocka_unit_test(shared_maps_do_not_widen),
		cmocka_unit_test(the_same_bits_in_all_modes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
