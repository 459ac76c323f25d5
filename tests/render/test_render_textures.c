/* Textures on the GPU: filtering, repeating, formats and positions on a mesh, against closed forms; and resources that
 * all workers create and destroy while frames are drawn, under the validation layer. */
#include "render/render_internal.h"
#include "support/picture_reference.h"

#define TEXELS 8u
#define SIZE (9u * TEXELS) /* the middle of a texel is the middle of a pixel */

/* ---- drawing by hand --------------------------------------------------------------------------------------------- */

typedef struct stage {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_render_view view;
} stage;

/* Looks straight down; the square x, z in [-1, 1] at y = 0 fills the picture, -Z is up. A sky of radiance 1 and no sun,
 * so the radiance of a surface that faces up is its diffuse reflectance. */
static stage stage_open(stilb_render_desc desc, uint32_t workers)
{
	stage s;
	desc.width = desc.width ? desc.width : SIZE;
	desc.height = desc.width;
	desc.samples = 1;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.context_count = workers + 1;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &s.pool), 0);
	reference_camera camera =
		reference_camera_at((dvec){0, 4, 0}, (dvec){0, 0, 0}, (dvec){0, 0, -1}, 4.0, desc.width, desc.width);
	s.view = (stilb_render_view){.view_projection = reference_matrix(&camera), .camera_position = {0.0f, 4.0f, 0.0f}};
	reference_set3(s.view.surroundings.sky, 1.0f, 1.0f, 1.0f);
	return s;
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_job_pool_destroy(s->pool);
}

typedef struct draw {
	stilb_render_mesh mesh;
	stilb_render_material material;
	stilb_mat4 transform;
} draw;

static void stage_draw(stage *s, const draw *draws, uint32_t count)
{
	stilb_render_pass pass = {.name = "main"};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	stilb_render_segment_begin(context, 0, 0);
	for (uint32_t d = 0; d < count; d++)
		stilb_render_draw(context, draws[d].mesh, draws[d].material, &draws[d].transform);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, &s->view, 1, s->pool, 0), STILB_OK);
}

static stilb_image stage_picture(stage *s)
{
	stilb_image image = {0};
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* The square x, z in [-1, 1], with texture coordinates u and v that run from `from` to `to` over it. */
static stilb_render_mesh make_plane(stage *s, float from, float to)
{
	stilb_scene_mesh mesh;
	stilb_render_mesh out;
	assert_int_equal(stilb_scene_mesh_plane(&mesh), STILB_OK);
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		for (int c = 0; c < 2; c++)
			mesh.vertices[v].uv[c] = from + (to - from) * mesh.vertices[v].uv[c];
	assert_int_equal(stilb_render_mesh_create(s->render, &mesh, &out), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
	return out;
}

static const float diffuse[3] = {0.8f, 0.6f, 0.4f};

static stilb_render_material make_material(stage *s, stilb_render_texture texture)
{
	stilb_scene_material material = {.diffuse = {diffuse[0], diffuse[1], diffuse[2]}, .roughness = 0.7f};
	stilb_render_material out;
	assert_int_equal(stilb_render_material_create(s->render, &material, texture, &out), STILB_OK);
	return out;
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

/* The value of texel x, y, channel c: all rows, columns and channels differ. */
static uint32_t texel_code(uint32_t x, uint32_t y, uint32_t c)
{
	return (37 * x + 91 * y + 53 * c + 11 * x * y) % 256;
}

static uint16_t half_of_256th(uint32_t k)
{
	uint32_t exponent = k ? 31u - (uint32_t)__builtin_clz(k) : 0;
	return k ? (uint16_t)((exponent + 7) << 10 | ((k - (1u << exponent)) << (10 - exponent))) : 0;
}

static stilb_image texel_image(stilb_image_format format, uint32_t channels)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, TEXELS, TEXELS, channels, format), STILB_OK);
	for (uint32_t i = 0; i < TEXELS * TEXELS * channels; i++) {
		uint32_t pixel = i / channels, code = texel_code(pixel % TEXELS, pixel / TEXELS, i % channels);
		if (format == STILB_IMAGE_U8_SRGB || format == STILB_IMAGE_U8_LINEAR)
			((uint8_t *)image.pixels)[i] = (uint8_t)code;
		else if (format == STILB_IMAGE_U16_SRGB || format == STILB_IMAGE_U16_LINEAR)
			((uint16_t *)image.pixels)[i] = (uint16_t)(code * 257);
		else if (format == STILB_IMAGE_F16_LINEAR)
			((uint16_t *)image.pixels)[i] = half_of_256th(code);
		else
			((float *)image.pixels)[i] = (float)code / 256.0f;
	}
	return image;
}

/* The linear value of a texel. Grey textures have one value for all three channels. */
static double texel_value(stilb_image_format format, uint32_t channels, int64_t x, int64_t y, int c)
{
	int64_t n = TEXELS;
	uint32_t code =
		texel_code((uint32_t)((x % n + n) % n), (uint32_t)((y % n + n) % n), channels < 3 ? 0 : (uint32_t)c);
	if (format == STILB_IMAGE_F16_LINEAR || format == STILB_IMAGE_F32_LINEAR)
		return code / 256.0;
	double v = code / 255.0; /* the sRGB transfer, IEC 61966-2-1 */
	if (format == STILB_IMAGE_U8_LINEAR || format == STILB_IMAGE_U16_LINEAR)
		return v;
	return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* Bilinear interpolation; u and v in texels. */
static double texel_filtered(stilb_image_format format, uint32_t channels, double u, double v, int c)
{
	double x = floor(u - 0.5), y = floor(v - 0.5), fx = u - 0.5 - x, fy = v - 0.5 - y, sum = 0.0;
	for (int k = 0; k < 4; k++) {
		double weight = (k & 1 ? fx : 1.0 - fx) * (k & 2 ? fy : 1.0 - fy);
		sum += weight * texel_value(format, channels, (int64_t)x + (k & 1), (int64_t)y + (k >> 1), c);
	}
	return sum;
}

/* Compares a picture over which u and v run from `from` to `to` with the texture filtered in double. The tolerance is
 * for GPUs whose filter weights have 8 bits. */
static void assert_texels(const stilb_image *image, stilb_image_format format, uint32_t channels, double from,
                          double to)
{
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++)
			for (int c = 0; c < 3; c++) {
				double u = (from + (to - from) * (x + 0.5) / SIZE) * TEXELS;
				double v = (from + (to - from) * (y + 0.5) / SIZE) * TEXELS;
				double want = (double)diffuse[c] * texel_filtered(format, channels, u, v, c);
				double got = picture_value(image, x, y, c);
				if (!(fabs(got - want) < 0.008))
					fail_msg("format %d, %u channels, pixel %u, %u, channel %d: %.4f, not %.4f", (int)format, channels,
					         x, y, c, got, want);
			}
}

#define TEXEL_FORMATS 6 /* those that are not blocks come first */

static void texels_of_every_format(void **state)
{
	(void)state;
	static const float spans[][2] = {{0.0f, 1.0f}, {-1.0f, 2.0f}};
	stage s = stage_open((stilb_render_desc){.validate = true}, 0);
	for (int kind = 0; kind < 8 * TEXEL_FORMATS; kind++) {
		stilb_image_format format = (stilb_image_format)(kind % TEXEL_FORMATS);
		uint32_t channels = 1 + (uint32_t)(kind / TEXEL_FORMATS) % 4;
		const float *span = spans[kind / (4 * TEXEL_FORMATS)];
		stilb_image image = texel_image(format, channels);
		stilb_render_texture texture;
		assert_int_equal(stilb_render_texture_create(s.render, &image, &texture), STILB_OK);
		stilb_image_finish(&image); /* the renderer has its own copy */
		draw tile = {make_plane(&s, span[0], span[1]), make_material(&s, texture), stilb_mat4_identity()};
		stage_draw(&s, &tile, 1);
		stilb_image picture = stage_picture(&s);
		assert_texels(&picture, format, channels, (double)span[0], (double)span[1]);
		stilb_image_finish(&picture);
		stilb_render_mesh_destroy(s.render, tile.mesh);
		stilb_render_material_destroy(s.render, tile.material);
		stilb_render_texture_destroy(s.render, texture);
	}
	stage_close(&s);
}

/* ---- on meshes --------------------------------------------------------------------------------------------------- */

/* A texture whose red is u and whose green is v. It is sampled between the centres of its texels, so that repeating
 * does not matter away from the edges. */
static stilb_render_texture make_ramp(stage *s)
{
	stilb_image image;
	stilb_render_texture texture;
	assert_int_equal(stilb_image_create(&image, 256, 128, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *pixel = image.pixels;
	for (uint32_t y = 0; y < 128; y++)
		for (uint32_t x = 0; x < 256; x++, pixel += 3)
			reference_set3(pixel, ((float)x + 0.5f) / 256.0f, ((float)y + 0.5f) / 128.0f, 1.0f);
	assert_int_equal(stilb_render_texture_create(s->render, &image, &texture), STILB_OK);
	stilb_image_finish(&image);
	return texture;
}

/* The sphere's upper half, seen from above: u is the longitude around +Y, v the latitude from the top. Blue is 1, so it
 * gives the light of the point. Triangles are flat: inside one, u and v deviate by a fraction of its size. */
static void longitude_and_latitude(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_scene_mesh mesh;
	draw sphere = {.transform = stilb_mat4_identity(), .material = make_material(&s, make_ramp(&s))};
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(s.render, &mesh, &sphere.mesh), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
	stage_draw(&s, &sphere, 1);
	stilb_image picture = stage_picture(&s);
	reference_camera camera = reference_camera_at((dvec){0, 4, 0}, (dvec){0, 0, 0}, (dvec){0, 0, -1}, 4.0, SIZE, SIZE);
	uint32_t checked = 0;
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			dvec d = dvec_unit(reference_ray(&camera, x + 0.5, y + 0.5));
			double along = -dvec_dot(camera.position, d), off = 16.0 - along * along;
			dvec p = dvec_mad(camera.position, along - sqrt(fmax(1.0 - off, 0.0)), d);
			bool seam = p.z < 0.1 && fabs(p.x) < 0.15, pole = p.x * p.x + p.z * p.z < 0.05;
			if (off > 0.9 || seam || pole)
				continue;
			double light = picture_value(&picture, x, y, 2) / (double)diffuse[2];
			double u = picture_value(&picture, x, y, 0) / (double)diffuse[0] / light;
			double v = picture_value(&picture, x, y, 1) / (double)diffuse[1] / light;
			assert_true(fabs(u - (0.5 + atan2(p.x, p.z) / (2.0 * REFERENCE_PI))) < 0.01);
			assert_true(fabs(v - acos(p.y) / REFERENCE_PI) < 0.01);
			checked++;
		}
	assert_true(checked > 2000);
	stilb_image_finish(&picture);
	stage_close(&s);
}

/* ---- all replay modes -------------------------------------------------------------------------------------------- */

#define CELLS 12u /* on each side */

static stilb_mat4 cell_transform(uint32_t cells, uint32_t cell)
{
	float scale = 1.0f / (float)cells;
	return stilb_mat4_scale_translate(scale, -1.0f + (float)(2 * (cell % cells) + 1) * scale, 0.0f,
	                                  -1.0f + (float)(2 * (cell / cells) + 1) * scale);
}

/* Cells with one of two textures or none, and materials that change with another period. */
static void fill_cells(stage *s, draw draws[CELLS * CELLS])
{
	stilb_image image = texel_image(STILB_IMAGE_U8_SRGB, 3);
	stilb_render_texture textures[3] = {{0}};
	stilb_render_mesh mesh = make_plane(s, 0.0f, 1.0f);
	stilb_render_material materials[12];
	textures[2] = make_ramp(s);
	assert_int_equal(stilb_render_texture_create(s->render, &image, &textures[1]), STILB_OK);
	stilb_image_finish(&image);
	for (uint32_t m = 0; m < 12; m++) {
		stilb_scene_material material = {.diffuse = {0.05f * (float)(m + 1), 0.5f, 0.9f}, .roughness = 0.7f};
		if (m == 8)
			stage_draw(s, NULL, 0); /* uploads the first eight textures; the others follow in a later frame */
		assert_int_equal(stilb_render_material_create(s->render, &material, textures[m % 3], &materials[m]), STILB_OK);
	}
	for (uint32_t c = 0; c < CELLS * CELLS; c++)
		draws[c] = (draw){mesh, materials[c * c / 5 % 12], cell_transform(CELLS, c)};
}

/* The expected number of binds, computed independently; the material determines the texture. */
static uint64_t expected_binds(stilb_render_materials how)
{
	uint64_t binds = 2 + (how == STILB_RENDER_MATERIALS_BIND);
	for (uint32_t c = 1; c < CELLS * CELLS; c++) {
		uint32_t from = (c - 1) * (c - 1) / 5 % 12, to = c * c / 5 % 12;
		bool pipeline = (from % 3 == 0) != (to % 3 == 0);
		pipeline |= how == STILB_RENDER_MATERIALS_PIPELINE && from % 2 != to % 2;
		bool material = to % 3 != 0 && (pipeline || from % 3 != to % 3);
		material |= how == STILB_RENDER_MATERIALS_BIND && (pipeline || from != to);
		binds += pipeline + material;
	}
	return binds;
}

/* All modes give the same pixels and the null device's statistics. */
static void the_same_in_every_mode(void **state)
{
	(void)state;
	stilb_image first = {0};
	draw draws[CELLS * CELLS];
	for (int way = 0; way < 9; way++) {
		if (TEST_ASAN && way % 3 != way / 3 % 3)
			continue; /* each replay and each kind of materials; test_render_picture has all pairs */
		stilb_render_desc desc = {
			.replay = (stilb_render_replay_mode)(way % 3),
			.materials = (stilb_render_materials)(way / 3 % 3),
			.validate = true,
		};
		stage s = stage_open(desc, 2);
		fill_cells(&s, draws);
		stage_draw(&s, draws, CELLS * CELLS);
		stilb_image picture = stage_picture(&s);
		stilb_render_stats stats = stilb_render_stats_get(s.render);
		stage_close(&s);
		if (way == 0)
			first = picture;
		assert_memory_equal(first.pixels, picture.pixels, stilb_image_size(&first));
		if (desc.replay != STILB_RENDER_REPLAY_SECONDARY)
			assert_int_equal(stats.binds_sent, expected_binds(desc.materials));
		desc.device = STILB_RENDER_DEVICE_NULL;
		s = stage_open(desc, 2);
		fill_cells(&s, draws);
		stage_draw(&s, draws, CELLS * CELLS);
		stilb_render_stats counted = stilb_render_stats_get(s.render);
		counted.gpu_ms = stats.gpu_ms;
		assert_memory_equal(&stats, &counted, sizeof stats);
		stage_close(&s);
		if (way > 0)
			stilb_image_finish(&picture);
	}
	stilb_image_finish(&first);
}

/* ---- resources created and destroyed in every frame -------------------------------------------------------------- */

#define BUSY 16u /* cells on each side */
#define BUSY_SEGMENT 8u
#define BUSY_FRAMES 5u
#define BUSY_WORKERS 3u

typedef struct busy {
	stage *stage;
	const stilb_scene_mesh *plane;
	uint32_t frame;
	bool failed[BUSY_WORKERS + 1]; /* by worker, since cmocka asserts only work on the main thread */
} busy;

static float busy_color(uint32_t frame, uint32_t cell, uint32_t channel)
{
	return (float)((cell * 7 + frame * 13 + channel * 31) % 250 + 1) / 256.0f;
}

static bool busy_textured(uint32_t cell)
{
	return cell % 4 == 1;
}

/* Creates everything that the cell needs, draws it, and destroys it at once. */
static bool busy_cell(busy *b, uint32_t cell, stilb_render_context *context)
{
	stilb_render *render = b->stage->render;
	uint8_t codes[4 * 3];
	memset(codes, 188, sizeof codes);
	stilb_image image = {2, 2, 3, STILB_IMAGE_U8_SRGB, codes, 0};
	stilb_scene_material material = {.roughness = 1.0f};
	stilb_mat4 transform = cell_transform(BUSY, cell);
	stilb_render_texture texture = {0};
	draw made;
	for (uint32_t c = 0; c < 3; c++)
		material.diffuse[c] = busy_color(b->frame, cell, c);
	if ((busy_textured(cell) && stilb_render_texture_create(render, &image, &texture) != STILB_OK) ||
	    stilb_render_mesh_create(render, b->plane, &made.mesh) != STILB_OK ||
	    stilb_render_material_create(render, &material, texture, &made.material) != STILB_OK)
		return false;
	stilb_render_draw(context, made.mesh, made.material, &transform);
	stilb_render_material_destroy(render, made.material);
	stilb_render_mesh_destroy(render, made.mesh);
	stilb_render_texture_destroy(render, texture);
	return true;
}

static void busy_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	busy *b = context;
	stilb_render_context *recorded = stilb_render_context_get(b->stage->render, worker);
	for (uint32_t segment = begin; segment < end; segment++) {
		stilb_render_segment_begin(recorded, 0, segment);
		for (uint32_t cell = segment * BUSY_SEGMENT; cell < (segment + 1) * BUSY_SEGMENT; cell++)
			b->failed[worker] |= !busy_cell(b, cell, recorded);
		stilb_render_segment_end(recorded);
	}
}

static void busy_frame(busy *b)
{
	stilb_render_pass pass = {.name = "main"};
	stage *s = b->stage;
	uint32_t segments = BUSY * BUSY / BUSY_SEGMENT;
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 0, segments), STILB_OK);
	stilb_job_parallel_for(s->pool, segments, 1, busy_slice, b, 0);
	for (uint32_t w = 0; w <= BUSY_WORKERS; w++)
		assert_false(b->failed[w]);
	assert_int_equal(stilb_render_pass_end(s->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(s->render, &pass, 1, &s->view, 1, s->pool, 0), STILB_OK);
}

static void assert_busy_picture(const busy *b)
{
	stilb_image picture = stage_picture(b->stage);
	uint32_t side = picture.width / BUSY;
	double texel = pow((188.0 / 255.0 + 0.055) / 1.055, 2.4);
	for (uint32_t cell = 0; cell < BUSY * BUSY; cell++) {
		double want[3];
		for (uint32_t c = 0; c < 3; c++)
			want[c] = (double)busy_color(b->frame, cell, c) * (busy_textured(cell) ? texel : 1.0);
		assert_pixel(&picture, cell % BUSY * side + side / 2, cell / BUSY * side + side / 2, want, 4e-3);
	}
	stilb_image_finish(&picture);
}

/* In all 45 frames 11,520 meshes, as many materials, and 2,880 textures. Most frames are not waited for. */
static void resources_come_and_go(void **state)
{
	(void)state;
	stilb_scene_mesh plane;
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	for (int way = 0; way < 9; way++) {
		stilb_render_desc desc = {
			.replay = (stilb_render_replay_mode)(way % 3),
			.materials = (stilb_render_materials)(way / 3),
			.width = 4 * BUSY,
			.validate = true,
		};
		stage s = stage_open(desc, BUSY_WORKERS);
		busy b = {.stage = &s, .plane = &plane};
		for (b.frame = 0; b.frame < BUSY_FRAMES; b.frame++) {
			busy_frame(&b);
			if (b.frame >= 2 &&
			    b.frame != 3) /* not waited for: in frame 1 the heaps outgrow their buffers while frame 0 is drawn */
				assert_busy_picture(&b);
			if (b.frame == 2)
				assert_int_equal(stilb_render_resize(s.render, 3 * BUSY, 3 * BUSY), STILB_OK);
		}
		/* Two frames later everything is released, and indices are reused. */
		for (int f = 0; f < 2; f++)
			stage_draw(&s, NULL, 0);
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		assert_int_equal(s.render->resources.live, 0);
		assert_in_range(s.render->resources.indices[RENDER_RESOURCE_MESH].next_unused, BUSY * BUSY, 3 * BUSY * BUSY);
		stage_close(&s);
	}
	stilb_scene_mesh_finish(&plane);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	struct CMUnitTest tests[] = {
		cmocka_unit_test(texels_of_every_format),
		cmocka_unit_test(longitude_and_latitude),
		cmocka_unit_test(the_same_in_every_mode),
		cmocka_unit_test(resources_come_and_go),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
