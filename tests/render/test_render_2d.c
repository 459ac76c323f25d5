/* 2D passes on the GPU against closed forms: colors, clips, blending, textures and order, pixel by pixel, for every
 * replay mode and both sample counts, over a scene and alone, under the validation layer. */
#include "render/render_internal.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"
#include "support/picture_reference.h"

#define WIDTH 64u
#define HEIGHT 48u

typedef struct color {
	uint8_t r, g, b, a;
} color;

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

typedef struct stage {
	stilb_render *render;
	stilb_job_pool *pool;
} stage;

static stage stage_open(stilb_render_desc desc)
{
	stage s;
	desc.width = desc.width ? desc.width : WIDTH;
	desc.height = desc.height ? desc.height : HEIGHT;
	desc.samples = desc.samples ? desc.samples : 1;
	desc.context_count = 3;
	desc.validate = true;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &s.pool), 0);
	return s;
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_job_pool_destroy(s->pool);
}

/* Way w, 0..5: replay mode w / 2, with one sample a pixel where w is even, with four where it is odd. */
#define WAYS 6
#define WAY_STEP (TEST_ASAN ? 3 : 1) /* the address sanitizer sees no more in the others */

static stilb_render_desc way(int w)
{
	static const stilb_render_materials materials[3] = {STILB_RENDER_MATERIALS_INDEX, STILB_RENDER_MATERIALS_BIND,
	                                                    STILB_RENDER_MATERIALS_PIPELINE};
	return (stilb_render_desc){
		.replay = (stilb_render_replay_mode)(w / 2), .materials = materials[w / 2], .samples = w % 2 ? 4 : 1};
}

/* The rectangle x0, y0, x1, y1 with a color for each corner: top left, top right, bottom right, bottom left. It shows
 * the whole texture. */
static void quad_corners(stilb_render_vertex_2d out[4], const float r[4], const color c[4])
{
	for (int v = 0; v < 4; v++) {
		bool right = v == 1 || v == 2, bottom = v >= 2;
		out[v] = (stilb_render_vertex_2d){.position = {r[right ? 2 : 0], r[bottom ? 3 : 1]},
		                                  .uv = {right, bottom},
		                                  .color = {c[v].r, c[v].g, c[v].b, c[v].a}};
	}
}

static const uint32_t quad_indices[6] = {0, 1, 2, 0, 2, 3};
static const float everywhere[4] = {-1e9f, -1e9f, 1e9f, 1e9f};

static void draw_quad(stilb_render_context *context, const float r[4], color c, const float clip[4],
                      stilb_render_texture texture)
{
	stilb_render_vertex_2d corners[4];
	quad_corners(corners, r, (color[4]){c, c, c, c});
	uint32_t first = stilb_render_geometry_2d(context, corners, 4, quad_indices, 6);
	stilb_render_draw_2d(context, first, 6, clip, texture);
}

static void frame_begin(stage *s, uint32_t pass)
{
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, pass, 1), STILB_OK);
	stilb_render_segment_begin(stilb_render_context_get(s->render, 0), pass, 0);
}

static const stilb_render_pass only_2d = {.name = "overlay", .kind = STILB_RENDER_PASS_2D};

static void frame_end(stage *s)
{
	stilb_render_segment_end(stilb_render_context_get(s->render, 0));
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &only_2d, 1, NULL, 0, s->pool, 0), STILB_OK);
}

static stilb_image read_picture(stage *s)
{
	stilb_image image = {0};
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static const uint8_t *pixel_at(const stilb_image *image, uint32_t x, uint32_t y)
{
	return (const uint8_t *)image->pixels + 3 * ((size_t)y * image->width + x);
}

static void assert_color(const stilb_image *image, uint32_t x, uint32_t y, color want, int tolerance)
{
	const uint8_t *got = pixel_at(image, x, y);
	if (abs(got[0] - want.r) > tolerance || abs(got[1] - want.g) > tolerance || abs(got[2] - want.b) > tolerance)
		fail_msg("pixel %u, %u: %u %u %u instead of %u %u %u", x, y, got[0], got[1], got[2], want.r, want.g, want.b);
}

/* ---- the expected colors: IEC 61966-2-1, blending in linear light ------------------------------------------------ */

static double to_linear(double code)
{
	return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

static uint8_t to_code(double light)
{
	return (uint8_t)lround(255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055));
}

static uint8_t over(uint8_t below, uint8_t above, double alpha)
{
	return to_code((1.0 - alpha) * to_linear(below / 255.0) + alpha * to_linear(above / 255.0));
}

static color color_over(color below, color above)
{
	double alpha = above.a / 255.0;
	return (color){over(below.r, above.r, alpha), over(below.g, above.g, alpha), over(below.b, above.b, alpha), 255};
}

/* ---- colors ------------------------------------------------------------------------------------------------------ */

static color any_color(uint64_t seed, uint32_t i)
{
	uint64_t random = stilb_random_u64(seed, i);
	return (color){(uint8_t)random, (uint8_t)(random >> 8), (uint8_t)(random >> 16), 255};
}

/* Every 8-bit value of every channel is drawn as itself. */
static void opaque_colors_are_exact(void **state)
{
	(void)state;
	for (int w = 0; w < WAYS; w += WAY_STEP) {
		stage s = stage_open(way(w));
		frame_begin(&s, 0);
		for (uint32_t i = 0; i < 256; i++) {
			float x = (float)(i % 16 * 4), y = (float)(i / 16 * 3);
			color c = {(uint8_t)i, (uint8_t)(255 - i), (uint8_t)(i * 7), 255};
			draw_quad(stilb_render_context_get(s.render, 0), (float[4]){x, y, x + 4, y + 3}, c, everywhere,
			          (stilb_render_texture){0});
		}
		frame_end(&s);
		stilb_image image = read_picture(&s);
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++) {
				uint32_t i = y / 3 * 16 + x / 4;
				assert_color(&image, x, y, (color){(uint8_t)i, (uint8_t)(255 - i), (uint8_t)(i * 7), 255}, 0);
			}
		stilb_image_finish(&image);
		stage_close(&s);
	}
}

/* In a linear picture colors are stored as linear light: neither tone mapped nor sRGB encoded. */
static void light_is_not_tone_mapped(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.output = STILB_RENDER_OUTPUT_LINEAR});
	frame_begin(&s, 0);
	draw_quad(stilb_render_context_get(s.render, 0), (float[4]){0, 0, WIDTH, HEIGHT}, (color){255, 188, 50, 255},
	          everywhere, (stilb_render_texture){0});
	frame_end(&s);
	stilb_image image = read_picture(&s);
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
		for (int c = 0; c < 3; c++) {
			static const double codes[3] = {255, 188, 50};
			double got = reference_half(((const uint16_t *)image.pixels)[3 * i + (uint32_t)c]);
			assert_true(fabs(got - to_linear(codes[c] / 255.0)) < 1e-3 * to_linear(codes[c] / 255.0));
		}
	stilb_image_finish(&image);
	stage_close(&s);
}

/* Light is interpolated linearly between corners, and premultiplied: a corner with alpha 0 adds no color. */
static void corners_blend_in_light(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	stilb_render_vertex_2d corners[4];
	frame_begin(&s, 0);
	stilb_render_context *context = stilb_render_context_get(s.render, 0);
	color left = {250, 20, 130, 255}, right = {10, 240, 130, 255}, clear = {255, 0, 0, 0};
	quad_corners(corners, (float[4]){0, 0, WIDTH, 8}, (color[4]){left, right, right, left});
	stilb_render_draw_2d(context, stilb_render_geometry_2d(context, corners, 4, quad_indices, 6), 6, everywhere,
	                     (stilb_render_texture){0});
	quad_corners(corners, (float[4]){0, 8, WIDTH, 16}, (color[4]){left, clear, clear, left});
	stilb_render_draw_2d(context, stilb_render_geometry_2d(context, corners, 4, quad_indices, 6), 6, everywhere,
	                     (stilb_render_texture){0});
	frame_end(&s);
	stilb_image image = read_picture(&s);
	for (uint32_t x = 0; x < WIDTH; x++) {
		double t = (x + 0.5) / WIDTH;
		color mixed = {over(left.r, right.r, t), over(left.g, right.g, t), over(left.b, right.b, t), 255};
		color faded = {over(left.r, 0, t), over(left.g, 0, t), over(left.b, 0, t), 255};
		assert_color(&image, x, 3, mixed, 1);
		assert_color(&image, x, 11, faded, 1);
		assert_color(&image, x, 16, (color){0, 0, 0, 255}, 0);
	}
	stilb_image_finish(&image);
	stage_close(&s);
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

/* A pixel is drawn if its centre is inside the clip: left and top edges are inside, right and bottom edges outside. */
static void clips_are_exact(void **state)
{
	(void)state;
	static const float clips[][4] = {
		{5, 7, 21, 30},       {0, 0, 1, 1},          {-50, -3, 2, 4},          {60, 40, 900, 900},
		{10, 10, 10, 20},     {30, 20, 12, 40},      {4.5f, 4.5f, 6.5f, 7.5f}, {4.6f, 4.4f, 6.6f, 7.6f},
		{100, 100, 200, 200}, {-1e30f, 3, 1e30f, 4},
	};
	color c = {200, 100, 50, 255};
	for (int w = 0; w < WAYS; w += WAY_STEP) {
		stage s = stage_open(way(w));
		for (size_t i = 0; i < sizeof clips / sizeof *clips; i++) {
			const float *k = clips[i];
			frame_begin(&s, 0);
			draw_quad(stilb_render_context_get(s.render, 0), (float[4]){-9, -9, 99, 99}, c, k,
			          (stilb_render_texture){0});
			frame_end(&s);
			stilb_image image = read_picture(&s);
			for (uint32_t y = 0; y < HEIGHT; y++)
				for (uint32_t x = 0; x < WIDTH; x++) {
					float px = (float)x + 0.5f, py = (float)y + 0.5f;
					bool inside = px >= k[0] && py >= k[1] && px < k[2] && py < k[3];
					assert_color(&image, x, y, inside ? c : (color){0, 0, 0, 255}, 0);
				}
			stilb_image_finish(&image);
		}
		stage_close(&s);
	}
}

/* ---- order, blending, textures ----------------------------------------------------------------------------------- */

/* A white texture with alpha, and an opaque colored one: each multiplies the color of the shape. */
static stilb_render_texture one_texel(stage *s, color c)
{
	uint8_t codes[4] = {c.r, c.g, c.b, c.a};
	stilb_image image = {1, 1, 4, STILB_IMAGE_U8_SRGB, codes, 0};
	stilb_render_texture out;
	assert_int_equal(stilb_render_texture_create(s->render, &image, &out), STILB_OK);
	return out;
}

typedef struct paint {
	float rect[4], clip[4];
	color c;
	int texture; /* 0: none; 1, 2: a texture of one texel, the color `glyph` or `tint` */
} paint;

static const color glyph = {255, 255, 255, 90}, tint = {188, 255, 0, 255};

static void random_rect(uint64_t seed, uint32_t i, float out[4])
{
	uint64_t r = stilb_random_u64(seed, i);
	out[0] = (float)(r % WIDTH);
	out[1] = (float)(r / 64 % HEIGHT);
	out[2] = out[0] + (float)(r / 4096 % 32);
	out[3] = out[1] + (float)(r / 131072 % 32);
}

static paint random_paint(uint32_t i)
{
	paint p = {.c = any_color(1, i), .texture = (int)(stilb_random_u64(3, i) % 3)};
	p.c.a = i % 3 ? (uint8_t)stilb_random_u64(2, i) : 255;
	random_rect(4, i, p.rect);
	random_rect(5, i, p.clip);
	return p;
}

static color textured(color c, int texture)
{
	if (texture == 1)
		c.a = (uint8_t)lround(c.a * glyph.a / 255.0);
	if (texture == 2)
		c = (color){to_code(to_linear(c.r / 255.0) * to_linear(188 / 255.0)), c.g, 0, c.a};
	return c;
}

static color painted(const paint *paints, uint32_t count, uint32_t x, uint32_t y)
{
	color c = {0, 0, 0, 255};
	float px = (float)x + 0.5f, py = (float)y + 0.5f;
	for (const paint *p = paints; p < paints + count; p++)
		if (px > p->rect[0] && px < p->rect[2] && py > p->rect[1] && py < p->rect[3] && px > p->clip[0] &&
		    px < p->clip[2] && py > p->clip[1] && py < p->clip[3])
			c = color_over(c, textured(p->c, p->texture));
	return c;
}

/* Overlapping rectangles in three segments, recorded by three contexts in reverse order. */
static void what_comes_later_is_above(void **state)
{
	(void)state;
	enum { PAINTS = 90, SEGMENTS = 3 };
	paint paints[PAINTS];
	for (uint32_t i = 0; i < PAINTS; i++)
		paints[i] = random_paint(i);
	for (int w = 0; w < WAYS; w += WAY_STEP) {
		stage s = stage_open(way(w));
		stilb_render_texture textures[3] = {{0}, one_texel(&s, glyph), one_texel(&s, tint)};
		for (int frame = 0; frame < 3; frame++) {
			assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
			assert_int_equal(stilb_render_pass_begin(s.render, 0, SEGMENTS), STILB_OK);
			for (uint32_t k = SEGMENTS; k-- > 0;) {
				stilb_render_context *context = stilb_render_context_get(s.render, k);
				stilb_render_segment_begin(context, 0, k);
				for (const paint *p = paints + k * (PAINTS / SEGMENTS); p < paints + (k + 1) * (PAINTS / SEGMENTS); p++)
					draw_quad(context, p->rect, p->c, p->clip, textures[p->texture]);
				stilb_render_segment_end(context);
			}
			assert_int_equal(stilb_render_pass_end(s.render, 0), STILB_OK);
			assert_int_equal(stilb_render_replay(s.render, &only_2d, 1, NULL, 0, s.pool, 0), STILB_OK);
		}
		stilb_image image = read_picture(&s);
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++)
				assert_color(&image, x, y, painted(paints, PAINTS, x, y), 1);
		stilb_image_finish(&image);
		stage_close(&s);
	}
}

/* One texel for each pixel: each pixel shows its texel, with its alpha. */
static void a_picture_at_its_own_size(void **state)
{
	(void)state;
	enum { SIDE = 16 };
	uint8_t codes[SIDE * SIDE * 4];
	for (uint32_t i = 0; i < sizeof codes; i++)
		codes[i] = (uint8_t)stilb_random_u64(9, i);
	stilb_image texels = {SIDE, SIDE, 4, STILB_IMAGE_U8_SRGB, codes, 0};
	stage s = stage_open((stilb_render_desc){0});
	stilb_render_texture texture;
	assert_int_equal(stilb_render_texture_create(s.render, &texels, &texture), STILB_OK);
	frame_begin(&s, 0);
	draw_quad(stilb_render_context_get(s.render, 0), (float[4]){20, 10, 20 + SIDE, 10 + SIDE},
	          (color){255, 255, 255, 255}, everywhere, texture);
	/* Destroyed while the frame is recorded: this frame still draws it. */
	stilb_render_texture_destroy(s.render, texture);
	frame_end(&s);
	stilb_image image = read_picture(&s);
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++) {
			const uint8_t *t = codes + 4 * (y * SIDE + x);
			assert_color(&image, 20 + x, 10 + y, color_over((color){0}, (color){t[0], t[1], t[2], t[3]}), 1);
		}
	assert_color(&image, 19, 12, (color){0}, 0);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* What a picture of radiance is shown as, in codes: as frames show radiance. */
static color shown_radiance(const float texel[4], float factor)
{
	stilb_vec3 light =
		shade_tonemap(stilb_vec3_make(texel[0], texel[1], texel[2]) * factor, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	uint8_t codes[3];
	for (int c = 0; c < 3; c++)
		codes[c] = (uint8_t)(255.0f * shade_srgb_from_linear(light[c]) + 0.5f);
	return (color){codes[0], codes[1], codes[2], 255};
}

/* A picture of radiance, twice as large as its texels in a clip, over what a glyph's texture has drawn, and that
 * again, by each way of replay. Where the output is radiance it comes out as it is, bit by bit. */
static void pictures_pixel_by_pixel(void **state)
{
	(void)state;
	enum { SIDE = 16 };
	float texels[SIDE * SIDE][4];
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		for (uint32_t c = 0; c < 4; c++) /* halves, from 0 to 31.875; alpha is not read */
			texels[i][c] = (float)(stilb_random_u64(8, 4 * i + c) % 256) / 8.0f * (i % 2 ? 1.0f : 1.0f / 16);
	uint8_t white[4] = {255, 255, 255, 255};
	stilb_image light = {SIDE, SIDE, 4, STILB_IMAGE_F32_LINEAR, texels, 0},
				dot = {1, 1, 4, STILB_IMAGE_U8_SRGB, white, 0};
	for (int w = 0; w < WAYS; w += 2) {
		stilb_render_desc desc = way(w);
		bool linear = w == WAYS - 2;
		desc.output = linear ? STILB_RENDER_OUTPUT_LINEAR : STILB_RENDER_OUTPUT_DISPLAY;
		stage s = stage_open(desc);
		stilb_render_texture picture, glyphs;
		assert_int_equal(stilb_render_texture_create(s.render, &light, &picture), STILB_OK);
		assert_int_equal(stilb_render_texture_create(s.render, &dot, &glyphs), STILB_OK);
		frame_begin(&s, 0);
		stilb_render_context *context = stilb_render_context_get(s.render, 0);
		draw_quad(context, (float[4]){0, 0, WIDTH, HEIGHT}, (color){255, 0, 0, 255}, everywhere, glyphs);
		stilb_render_draw_picture(context, (float[4]){8, 4, 8 + 2 * SIDE, 4 + 2 * SIDE},
		                          (float[4]){12, 0, WIDTH, HEIGHT}, picture, 0.5f, 0);
		draw_quad(context, (float[4]){0, 40, WIDTH, HEIGHT}, (color){0, 0, 255, 255}, everywhere, glyphs);
		frame_end(&s);
		stilb_image image = read_picture(&s);
		for (uint32_t y = 4; y < 4 + 2 * SIDE; y++)
			for (uint32_t x = 12; x < 8 + 2 * SIDE; x++) {
				const float *texel = texels[(y - 4) / 2 * SIDE + (x - 8) / 2];
				if (!linear)
					assert_color(&image, x, y, shown_radiance(texel, 0.5f), 1);
				for (uint32_t c = 0; linear && c < 3; c++)
					assert_true(reference_half(((const uint16_t *)image.pixels)[3 * (y * WIDTH + x) + c]) ==
					            (double)texel[c]);
			}
		if (!linear) {
			assert_color(&image, 11, 10, (color){255, 0, 0, 255}, 0);
			assert_color(&image, 40, 10, (color){255, 0, 0, 255}, 0);
			assert_color(&image, 30, 41, (color){0, 0, 255, 255}, 0);
		}
		stilb_image_finish(&image);
		stilb_render_texture_destroy(s.render, picture);
		stilb_render_texture_destroy(s.render, glyphs);
		stage_close(&s);
	}
}

/* With the factor 0 a picture is shown as it is, every code of it. */
static void pictures_as_they_are(void **state)
{
	(void)state;
	uint8_t codes[HEIGHT][WIDTH][4];
	for (uint32_t i = 0; i < sizeof codes; i++)
		(&codes[0][0][0])[i] = (uint8_t)stilb_random_u64(7, i);
	stilb_image texels = {WIDTH, HEIGHT, 4, STILB_IMAGE_U8_SRGB, codes, 0};
	stage s = stage_open((stilb_render_desc){0});
	stilb_render_texture texture;
	assert_int_equal(stilb_render_texture_create(s.render, &texels, &texture), STILB_OK);
	frame_begin(&s, 0);
	stilb_render_draw_picture(stilb_render_context_get(s.render, 0), (float[4]){0, 0, WIDTH, HEIGHT}, everywhere,
	                          texture, 0.0f, 0);
	frame_end(&s);
	stilb_image image = read_picture(&s);
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		const uint8_t *t = codes[i / WIDTH][i % WIDTH];
		assert_color(&image, i % WIDTH, i / WIDTH, (color){t[0], t[1], t[2], 255}, 0);
	}
	stilb_image_finish(&image);
	stilb_render_texture_destroy(s.render, texture);
	stage_close(&s);
}

/* ---- with a scene ------------------------------------------------------------------------------------------------ */

typedef struct scene_view {
	stilb_scene *scene;
	stilb_render_view view;
} scene_view;

static scene_view make_scene(void)
{
	scene_view v = {.scene = reference_scene(1)};
	stilb_scene *scene = v.scene;
	reference_camera camera =
		reference_camera_at((dvec){0, 3, 2}, (dvec){0, 0, 0}, (dvec){0, 1, 0}, 2.0, WIDTH, HEIGHT);
	reference_set3(scene->surroundings.sky, 0.4f, 0.5f, 0.6f);
	reference_set3(scene->lights[0].intensity, 2.0f, 2.0f, 2.0f);
	reference_set3(scene->materials[0].diffuse, 0.7f, 0.2f, 0.1f);
	v.view = (stilb_render_view){.view_projection = reference_matrix(&camera),
	                             .camera_position = {0.0f, 3.0f, 2.0f},
	                             .lights = scene->lights,
	                             .light_count = scene->light_count,
	                             .surroundings = scene->surroundings};
	return v;
}

/* One frame of the scene in two passes, with `quads` rectangles in a 2D pass that stands first in the table. */
static stilb_image scene_picture(stage *s, scene_view *v, uint32_t quads)
{
	stilb_render_pass passes[3] = {
		{.name = "overlay", .kind = STILB_RENDER_PASS_2D}, {.name = "main", .order = 1}, {.name = "again", .order = 2}};
	uint32_t model = 0;
	frame_begin(s, 0);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	for (uint32_t q = 0; q < quads; q++)
		draw_quad(context, (float[4]){20, 10, 40, 30}, (color){10, 200, 30, q ? 128 : 255}, everywhere,
		          (stilb_render_texture){0});
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	for (uint32_t p = 1; p < 3; p++)
		assert_int_equal(stilb_render_record(s->render, p, v->scene, &model, 1, s->pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, passes, 3, &v->view, 1, s->pool, 0), STILB_OK);
	return read_picture(s);
}

static void the_scene_is_below(void **state)
{
	(void)state;
	for (int w = 0; w < WAYS; w += WAY_STEP) {
		stage s = stage_open(way(w));
		scene_view v = make_scene();
		assert_int_equal(stilb_render_set_scene(s.render, v.scene), STILB_OK);
		stilb_image alone = scene_picture(&s, &v, 0);
		uint64_t hash = stilb_render_stream_hash(s.render);
		stilb_render_stats empty = stilb_render_stats_get(s.render);
		stilb_image both = scene_picture(&s, &v, 1);
		assert_true(stilb_render_stream_hash(s.render) == hash);
		assert_true(stilb_render_stats_get(s.render).draws == empty.draws + 1);
		assert_true(stilb_render_stats_get(s.render).execute_commands == empty.execute_commands);
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++) {
				const uint8_t *p = pixel_at(&alone, x, y);
				bool inside = x >= 20 && x < 40 && y >= 10 && y < 30;
				assert_color(&both, x, y, inside ? (color){10, 200, 30, 255} : (color){p[0], p[1], p[2], 255}, 0);
			}
		stilb_image_finish(&both);
		stilb_image_finish(&alone);
		stilb_scene_destroy(v.scene);
		stage_close(&s);
	}
}

/* ---- sizes ------------------------------------------------------------------------------------------------------- */

/* Rectangles of one pixel, all over the picture, in random colors: far more than a new frame's memory holds. */
static void draw_all_pixels(stage *s, uint64_t seed)
{
	uint32_t width, height;
	stilb_render_size(s->render, &width, &height);
	frame_begin(s, 0);
	for (uint32_t i = 0; i < width * height; i++) {
		float x = (float)(i % width), y = (float)(i / width);
		draw_quad(stilb_render_context_get(s->render, 0), (float[4]){x, y, x + 1, y + 1}, any_color(seed, i),
		          everywhere, (stilb_render_texture){0});
	}
	frame_end(s);
}

static void assert_all_pixels(stage *s, uint64_t seed)
{
	stilb_image image = read_picture(s);
	for (uint32_t i = 0; i < image.width * image.height; i++)
		assert_color(&image, i % image.width, i / image.width, any_color(seed, i), 0);
	stilb_image_finish(&image);
}

static void memory_grows_in_flight(void **state)
{
	(void)state;
	static const struct {
		uint32_t width, height;
	} sizes[] = {{1, 1}, {200, 100}, {3, 5}, {201, 99}, {64, 48}, {300, 150}};
	for (int w = 0; w < WAYS; w += 2) {
		stage s = stage_open(way(w));
		for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
			assert_int_equal(stilb_render_resize(s.render, sizes[i].width, sizes[i].height), STILB_OK);
			for (uint64_t frame = 0; frame < 3; frame++) {
				draw_all_pixels(&s, frame);
				if (frame == 1) /* frame 1 is not waited for: frame 2 begins while it is drawn */
					continue;
				assert_all_pixels(&s, frame);
			}
		}
		stage_close(&s);
	}
}

/* ---- empty passes ------------------------------------------------------------------------------------------------ */

static void an_empty_pass_is_black(void **state)
{
	(void)state;
	for (int w = 0; w < WAYS; w += WAY_STEP) {
		stage s = stage_open(way(w));
		frame_begin(&s, 0);
		draw_quad(stilb_render_context_get(s.render, 0), (float[4]){0, 0, WIDTH, HEIGHT}, (color){9, 9, 9, 255},
		          everywhere, (stilb_render_texture){0});
		frame_end(&s);
		frame_begin(&s, 0);
		frame_end(&s);
		stilb_image image = read_picture(&s);
		for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
			assert_color(&image, i % WIDTH, i / WIDTH, (color){0, 0, 0, 255}, 0);
		stilb_image_finish(&image);
		stage_close(&s);
	}
}

/* A pass without draws sends no command to the device. */
static void an_empty_pass_over_a_scene_costs_nothing(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0});
	scene_view v = make_scene();
	assert_int_equal(stilb_render_set_scene(s.render, v.scene), STILB_OK);
	stilb_image image = scene_picture(&s, &v, 0);
	uint64_t passes = stilb_gpu_stats_get(s.render->device->gpu).passes;
	stilb_image_finish(&image);
	image = scene_picture(&s, &v, 1);
	assert_int_equal(stilb_gpu_stats_get(s.render->device->gpu).passes, passes + 1);
	stilb_image_finish(&image);
	stilb_scene_destroy(v.scene);
	stage_close(&s);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(opaque_colors_are_exact),   cmocka_unit_test(light_is_not_tone_mapped),
		cmocka_unit_test(corners_blend_in_light),    cmocka_unit_test(clips_are_exact),
		cmocka_unit_test(what_comes_later_is_above), cmocka_unit_test(a_picture_at_its_own_size),
		cmocka_unit_test(the_scene_is_below),        cmocka_unit_test(memory_grows_in_flight),
		cmocka_unit_test(an_empty_pass_is_black),    cmocka_unit_test(an_empty_pass_over_a_scene_costs_nothing),
		cmocka_unit_test(pictures_pixel_by_pixel),   cmocka_unit_test(pictures_as_they_are),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
