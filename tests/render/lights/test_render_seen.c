/* What frames leave for later passes, in every way of lighting: depth, normals, models and velocities of what is seen,
 * against rays of this test; and the surroundings' light apart from all other. Under the validation layer. */
#include "render/device/render_images.h"
#include "shading/shade_brdf.h"
#include "shading/shade_impostor.h"

#include "render/lights/lights_surfaces.h" /* names a type as these name variables */

#define SIDE 48u
#define PIXELS (SIDE * SIDE)

/* ---- squares of every kind of surface ---------------------------------------------------------------------------- */

#define EDGE 0.012  /* so near to an edge a ray does not count: rasterizers round */
#define WALK 0.125f /* metres, of the camera from the frame before, to the right */

static bool is_plain(int kind)
{
	return kind == MATT || kind == GLOSSY || kind == UNLIT || kind == MASKED || kind == NORMALS;
}

static stilb_scene_light lamps[16];

static stage open_squares(uint32_t samples)
{
	stage s = stage_open((stilb_render_desc){.width = SIDE, .samples = samples}, 1);
	squares_show(&s, NORMALS);
	for (int i = 0; i < 16; i++)
		lamps[i] = (stilb_scene_light){.kind = i % 2 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_SPHERE,
		                               .falloff = STILB_SCENE_LIGHT_WINDOWED,
		                               .position = {0.5f * (float)(i % 4) - 0.8f, 0.9f, 0.5f * (float)(i / 4) - 0.7f},
		                               .direction = {0.0f, -1.0f, 0.0f},
		                               .intensity = {0.5f, 0.4f, 0.3f},
		                               .radius = 0.05f,
		                               .reach = 1.6f};
	s.view.lights = lamps;
	s.view.light_count = 16;
	s.view.shading = stilb_render_shading_default();
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	return s;
}

/* What a ray through a pixel's middle meets. */
typedef struct met {
	int seen, plain; /* the first square that does not blend; the first one that is plain; -1: none */
	double place[3]; /* of the former */
	bool covered;    /* what is not plain lies before the latter */
	bool near;       /* an edge is near */
} met;

/* -1: the ray misses the square of that kind at its height; 0: it is near an edge; 1: it meets it. */
static int meets(int kind, double x, double z)
{
	double across = fabs(x - square_place(kind, 0)), along = fabs(z - square_place(kind, 1));
	if (fabs(fmax(across, along) - SQUARE_HALF) < EDGE)
		return 0;
	if (fmax(across, along) > SQUARE_HALF)
		return -1;
	if (kind != MASKED)
		return 1;
	/* A texture of 2 x 2 texels, repeated, of which the first has alpha 0. */
	double weight = 1.0,
		   local[2] = {(x - square_place(kind, 0)) / SQUARE_HALF, (z - square_place(kind, 1)) / SQUARE_HALF};
	for (int i = 0; i < 2; i++) {
		double texel = local[i] + 1.0 - 0.5, part = texel - floor(texel);
		weight *= (int)floor(texel) % 2 == 0 ? 1.0 - part : part;
	}
	return fabs(weight - 0.5) < 0.05 ? 0 : weight > 0.5 ? -1 : 1;
}

static met meet(uint32_t px, uint32_t py)
{
	met m = {.seen = -1, .plain = -1};
	double x0 = 2.0 * (px + 0.5) / SIDE - 1.0, z0 = 2.0 * (py + 0.5) / SIDE - 1.0;
	for (int k = SQUARES - 1; k >= 0; k--) {
		double height = SQUARE_ABOVE * k, x = x0 * (4.0 - height) / 4.0, z = z0 * (4.0 - height) / 4.0;
		int meeting = meets(k, x, z);
		m.near |= meeting == 0;
		if (meeting != 1)
			continue;
		if (k != BLENDS && m.seen < 0) {
			m.seen = k;
			memcpy(m.place, (double[3]){x, height, z}, sizeof m.place);
		}
		if (is_plain(k) && m.plain < 0)
			m.plain = k;
		m.covered |= !is_plain(k) && m.plain < 0;
	}
	return m;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static void read_image(stage *s, const char *name, size_t bytes, void *out)
{
	const stilb_gpu_plan *plan = stilb_render_plan(s->render);
	stilb_gpu *gpu = stilb_render_gpu(s->render);
	uint64_t ticket, frame;
	const void *got;
	uint16_t image = stilb_gpu_plan_find(plan, name);
	if (image == 0)
		fail_msg("there is no '%s'", name);
	if (stilb_gpu_read_begin(gpu, plan, image, 0, 0, &ticket) != STILB_OK ||
	    stilb_gpu_read_get(gpu, ticket, true, &got, &frame) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	memcpy(out, got, bytes);
	stilb_gpu_read_end(gpu, ticket);
}

/* The name of the depth by which velocities were decided. */
static const char *seen_depth(const stage *s)
{
	bool own = stilb_gpu_plan_find(stilb_render_plan(s->render), STILB_RENDER_IMAGE_VELOCITY_DEPTH) != 0;
	return own ? STILB_RENDER_IMAGE_VELOCITY_DEPTH : STILB_RENDER_IMAGE_DEPTH;
}

static const char *way_name(const stage *s)
{
	return stilb_render_lighting_names[s->view.lighting];
}

/* ---- what is seen ------------------------------------------------------------------------------------------------ */

/* Of a normal, each axis: rg16_u has steps of 2^-15 on the map, on which lengths are up to sqrt(3) longer; and texels
 * of 8 bits are taken as floats. */
#define NORMAL_OFF 1e-4
/* Of 1 / w and so of depth: floats. */
#define DEPTH_OFF 1e-5
/* Pixels: half floats of up to 8 have steps of 2^-8, and floats place the pixel to 1e-4. */
#define VELOCITY_OFF (1.0 / 128.0)

static struct {
	uint16_t normal[PIXELS][2], velocity[PIXELS][2];
	uint32_t id[PIXELS];
	float depth[PIXELS];
} left;

static void project(const stilb_mat4 *m, const double place[3], double clip[4])
{
	for (int r = 0; r < 4; r++) {
		clip[r] = (double)m->m[12 + r];
		for (int c = 0; c < 3; c++)
			clip[r] += (double)m->m[4 * c + r] * place[c];
	}
}

static void check_normal(const stage *s, uint32_t i, int kind)
{
	double want[3] = {0.0, 1.0, 0.0}, local[3], length = 0.0;
	for (int c = 0; c < 3; c++) {
		local[c] = surface_bumped[c] / 255.0 * 2.0 - 1.0;
		length += local[c] * local[c];
	}
	/* The tangent is +X, the bitangent their cross product, -Z. */
	if (kind == NORMALS)
		memcpy(want, (double[3]){local[0] / sqrt(length), local[2] / sqrt(length), -local[1] / sqrt(length)},
		       sizeof want);
	stilb_vec2 place = {(float)left.normal[i][0] / 65535.0f * 2.0f - 1.0f,
	                    (float)left.normal[i][1] / 65535.0f * 2.0f - 1.0f};
	stilb_vec3 n = shade_direction_from_octahedral(place);
	for (int c = 0; c < 3; c++)
		if (!(fabs((double)n[c] - want[c]) <= NORMAL_OFF))
			fail_msg("%s, pixel %u, kind %d: normal %g %g %g, not %g %g %g", way_name(s), i, kind, (double)n[0],
			         (double)n[1], (double)n[2], want[0], want[1], want[2]);
}

/* Compares what a frame has left with rays; returns how many pixels were of kinds that the picture must show. */
static void check_seen(stage *s)
{
	uint32_t of_kind[SQUARES] = {0}, holes = 0;
	read_image(s, STILB_RENDER_IMAGE_SURFACE_NORMAL, sizeof left.normal, left.normal);
	read_image(s, STILB_RENDER_IMAGE_VELOCITY, sizeof left.velocity, left.velocity);
	read_image(s, STILB_RENDER_IMAGE_ID, sizeof left.id, left.id);
	read_image(s, seen_depth(s), sizeof left.depth, left.depth);
	for (uint32_t i = 0; i < PIXELS; i++) {
		met m = meet(i % SIDE, i / SIDE);
		double now[4], last[4], pixel[2] = {i % SIDE + 0.5, i / SIDE + 0.5};
		if (m.near)
			continue;
		if (left.id[i] != (uint32_t)(m.seen + 1))
			fail_msg("%s, pixel %u: model %u, not %d", way_name(s), i, left.id[i], m.seen + 1);
		holes += m.seen < 0;
		if (m.seen < 0) {
			assert_true(left.depth[i] == 0.0f && left.normal[i][0] == 0 && left.normal[i][1] == 0);
			continue;
		}
		of_kind[m.seen]++;
		check_normal(s, i, m.seen);
		project(&s->view.view_projection, m.place, now);
		project(s->view.last, m.place, last);
		assert_near("depth", (double)left.depth[i], now[2] / now[3], DEPTH_OFF);
		for (int c = 0; c < 2; c++)
			assert_near("velocity", reference_half(left.velocity[i][c]),
			            (last[c] / last[3] * 0.5 + 0.5) * SIDE - pixel[c], VELOCITY_OFF);
	}
	for (int k = 0; k < SQUARES; k++)
		if (k == BLENDS ? of_kind[k] != 0 : of_kind[k] < 30)
			fail_msg("%s: %u pixels show kind %d", way_name(s), of_kind[k], k);
	assert_true(holes > 20);
}

static void what_is_seen(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stage s = open_squares(samples);
		reference_camera camera = reference_camera_at((dvec){-(double)WALK, 4, 0}, (dvec){-(double)WALK, 0, 0},
		                                              (dvec){0, 0, -1}, 4.0, SIDE, SIDE);
		stilb_mat4 last = reference_matrix(&camera);
		s.view.last = &last;
		s.view.surfaces = true;
		for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
			if (samples > 1 && way != STILB_RENDER_LIGHTING_FORWARD)
				continue; /* the passes are the same ones */
			s.view.lighting = (stilb_render_lighting)way;
			stage_frame(&s);
			check_seen(&s);
		}
		stage_close(&s);
	}
}

/* ---- beside the picture, or in rows of their own ----------------------------------------------------------------- */

/* What a frame leaves besides its picture, and how large a texel of it is. */
static const struct {
	const char *name;
	uint32_t bytes;
} kinds_left[] = {{STILB_RENDER_IMAGE_VELOCITY, 4},       {STILB_RENDER_IMAGE_ID, 4},
                  {STILB_RENDER_IMAGE_SURFACE_NORMAL, 4}, {STILB_RENDER_IMAGE_AMBIENT, 8},
                  {STILB_RENDER_IMAGE_REFLECTION, 8},     {STILB_RENDER_IMAGE_MIRROR, 4},
                  {STILB_RENDER_IMAGE_MIRROR_NORMAL, 4}};

enum { LEFT = sizeof kinds_left / sizeof *kinds_left };

typedef struct frame_left {
	stilb_image picture;
	uint64_t texels[LEFT][PIXELS];
	float depth[PIXELS];
	bool there[LEFT];
	uint32_t alone; /* rows that draw triangles for what is left alone */
} frame_left;

static void draw_left(stage *s, bool own_rows, frame_left *out)
{
	s->render->device->own_rows = own_rows;
	*out = (frame_left){.picture = stage_picture(s)};
	const stilb_gpu_plan *plan = stilb_render_plan(s->render);
	for (uint32_t i = 0; i < LEFT; i++) {
		out->there[i] = stilb_gpu_plan_find(plan, kinds_left[i].name) != 0;
		if (out->there[i])
			read_image(s, kinds_left[i].name, kinds_left[i].bytes * PIXELS, out->texels[i]);
	}
	if (s->view.surfaces)
		read_image(s, seen_depth(s), sizeof out->depth, out->depth);
	for (uint32_t row = 0; row < stilb_gpu_plan_passes(plan); row++) {
		const char *name = stilb_gpu_plan_row(plan, row)->name, *end = strrchr(name, ' ');
		out->alone += end && (strcmp(end, " velocity") == 0 || strcmp(end, " ambient") == 0);
	}
}

static void check_beside(stage *s)
{
	static frame_left alone, beside;
	draw_left(s, true, &alone);
	draw_left(s, false, &beside);
	bool deferred =
		s->view.lighting == STILB_RENDER_LIGHTING_DEFERRED || s->view.lighting == STILB_RENDER_LIGHTING_TILED_DEFERRED;
	uint32_t own = deferred ? (uint32_t)s->view.surfaces + s->view.mirrors : 0;
	if (alone.alone != 2 || beside.alone != own)
		fail_msg("%s: %u and %u rows of their own", way_name(s), alone.alone, beside.alone);
	for (uint32_t i = 0; i < LEFT; i++) {
		if (alone.there[i] != beside.there[i])
			fail_msg("%s: '%s' is there in one alone", way_name(s), kinds_left[i].name);
		if (memcmp(alone.texels[i], beside.texels[i], sizeof alone.texels[i]) != 0)
			fail_msg("%s: '%s' has other bits", way_name(s), kinds_left[i].name);
	}
	assert_memory_equal(alone.depth, beside.depth, sizeof alone.depth);
	assert_memory_equal(alone.picture.pixels, beside.picture.pixels, stilb_image_size(&alone.picture));
	stilb_image_finish(&alone.picture);
	stilb_image_finish(&beside.picture);
}

/* Bit for bit what rows of their own draw, and where there is room no such rows. */
static void beside_the_picture(void **state)
{
	(void)state;
	stage s = open_squares(1);
	reference_camera camera = reference_camera_at((dvec){-(double)WALK, 4, 0}, (dvec){-(double)WALK, 0, 0},
	                                              (dvec){0, 0, -1}, 4.0, SIDE, SIDE);
	stilb_mat4 last = reference_matrix(&camera);
	s.view.last = &last;
	s.view.ids = s.view.ambient_apart = s.view.surroundings.glossy = true;
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_FORWARD, STILB_RENDER_LIGHTING_DEFERRED};
	for (int w = 0; w < 2; w++) {
		s.view.lighting = ways[w];
		s.view.surfaces = s.view.mirrors = w == 0;
		check_beside(&s);
	}
	stage_close(&s);
}

/* Who asks for nothing gets nothing, and what is left changes no bit of the picture. */
static void nothing_unless_asked(void **state)
{
	(void)state;
	static const char *const images[] = {STILB_RENDER_IMAGE_SURFACE_NORMAL, STILB_RENDER_IMAGE_ID,
	                                     STILB_RENDER_IMAGE_VELOCITY, STILB_RENDER_IMAGE_AMBIENT,
	                                     STILB_RENDER_IMAGE_REFLECTION};
	stage s = open_squares(1);
	stilb_mat4 last = s.view.view_projection;
	stilb_image without = stage_picture(&s);
	for (uint32_t i = 0; i < sizeof images / sizeof *images; i++)
		assert_int_equal(stilb_gpu_plan_find(stilb_render_plan(s.render), images[i]), 0);
	s.view.last = &last;
	s.view.surfaces = true;
	stilb_image with = stage_picture(&s);
	assert_memory_equal(with.pixels, without.pixels, stilb_image_size(&with));
	stilb_image_finish(&with);
	stilb_image_finish(&without);
	stage_close(&s);
}

/* ---- the surroundings' light ------------------------------------------------------------------------------------- */

/* What the sum may be off by, a share of it: all other light, both parts and the sum are rounded to half floats, whose
 * steps are 2^-10 at most, in whatever direction; so is the frame that it is compared with. Ways that add light to
 * what is drawn round the two in other places: twice as much. */
#define SUM_OFF (3.0 / 1024.0)
#define SUM_FLOOR 1e-6

static struct {
	uint16_t ambient[PIXELS][4], reflection[PIXELS][4];
} parts;

static void read_parts(stage *s)
{
	read_image(s, STILB_RENDER_IMAGE_AMBIENT, sizeof parts.ambient, parts.ambient);
	read_image(s, STILB_RENDER_IMAGE_REFLECTION, sizeof parts.reflection, parts.reflection);
}

/* Each part has what it should: alpha where plain surfaces are, nothing where these have no such light, and together
 * what the frame has more than one without. dark: that one, or NULL. */
static void check_parts(stage *s, const stilb_image *whole, const stilb_image *dark, double times)
{
	double most[2] = {0.0, 0.0};
	for (uint32_t i = 0; i < PIXELS; i++) {
		met m = meet(i % SIDE, i / SIDE);
		if (m.near)
			continue;
		for (int c = 0; c < 4; c++) {
			double even = reference_half(parts.ambient[i][c]), mirrored = reference_half(parts.reflection[i][c]);
			if (c == 3 || m.plain < 0 || m.plain == UNLIT) {
				double want = c == 3 && m.plain >= 0 ? 1.0 : 0.0;
				if (even != want || mirrored != want)
					fail_msg("%s, pixel %u, channel %d: %g and %g, not %g", way_name(s), i, c, even, mirrored, want);
				continue;
			}
			if (m.plain == MATT && !s->view.surroundings.panorama.pixels && mirrored != 0.0)
				fail_msg("%s, pixel %u: a matt surface mirrors %g", way_name(s), i, mirrored);
			most[0] = fmax(most[0], even);
			most[1] = fmax(most[1], mirrored);
			if (m.covered || !dark)
				continue;
			double sum = picture_value(whole, i % SIDE, i / SIDE, c), rest = picture_value(dark, i % SIDE, i / SIDE, c);
			if (!(fabs(sum - rest - even - mirrored) <= times * SUM_OFF * sum + SUM_FLOOR))
				fail_msg("%s, pixel %u, channel %d: %g is not %g + %g + %g", way_name(s), i, c, sum, rest, even,
				         mirrored);
		}
	}
	assert_true(most[0] > 0.01 && (most[1] > 0.01 || !s->view.surroundings.glossy));
}

static void check_sum(stage *s, const stilb_image *whole, const stilb_image *sum, double times)
{
	for (uint32_t i = 0; i < PIXELS; i++)
		for (int c = 0; c < 3; c++) {
			double want = picture_value(whole, i % SIDE, i / SIDE, c), got = picture_value(sum, i % SIDE, i / SIDE, c);
			if (!(fabs(got - want) <= times * SUM_OFF * want + SUM_FLOOR))
				fail_msg("%s, ambient %s, pixel %u, channel %d: %g, not %g", way_name(s),
				         stilb_render_ambient_names[s->view.ambient], i, c, got, want);
		}
}

static void check_way(stage *s, stilb_render_lighting way)
{
	bool adds = way != STILB_RENDER_LIGHTING_AUTO && way != STILB_RENDER_LIGHTING_FORWARD &&
	            way != STILB_RENDER_LIGHTING_CLUSTERED;
	bool lamps_stay = !s->view.surroundings.panorama.pixels; /* else ambient none leaves out the panorama's */
	stilb_render_ambient ambient = s->view.ambient;
	stilb_image dark = {0};
	s->view.lighting = way;
	stilb_image whole = stage_picture(s);
	if (lamps_stay) {
		s->view.ambient = STILB_RENDER_AMBIENT_NONE;
		dark = stage_picture(s);
		s->view.ambient = ambient;
	}
	s->view.ambient_apart = true;
	stilb_image sum = stage_picture(s);
	read_parts(s);
	s->view.ambient_apart = false;
	check_sum(s, &whole, &sum, adds ? 2.0 : 1.0);
	check_parts(s, &whole, lamps_stay ? &dark : NULL, adds ? 2.0 : 1.0);
	stilb_image_finish(&whole);
	stilb_image_finish(&dark);
	stilb_image_finish(&sum);
}

static void parts_and_their_sum(void **state)
{
	(void)state;
	stage s = open_squares(1);
	s.view.surroundings.glossy = true;
	reference_set3(s.view.surroundings.ground, 0.3f, 0.2f, 0.1f);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++)
		check_way(&s, (stilb_render_lighting)way);
	s.view.ambient = STILB_RENDER_AMBIENT_SH_VERTEX;
	check_way(&s, STILB_RENDER_LIGHTING_FORWARD);
	s.view.ambient = STILB_RENDER_AMBIENT_SH_PIXEL;
	check_way(&s, STILB_RENDER_LIGHTING_DEFERRED);
	stage_close(&s);
}

/* Of a panorama, which has a lamp, a sun of two texels, half of it below the horizon. */
static void parts_of_a_panorama(void **state)
{
	(void)state;
	enum { WIDE = 512, HIGH = 256 };
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_CLUSTERED, STILB_RENDER_LIGHTING_DEFERRED,
	                                             STILB_RENDER_LIGHTING_PRELIGHT};
	stage s = open_squares(1);
	stilb_image panorama;
	assert_int_equal(stilb_image_create(&panorama, WIDE, HIGH, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 3 * WIDE * HIGH; i++)
		((float *)panorama.pixels)[i] = 0.5f + 0.4f * (float)(i % 7) / 7.0f;
	for (int row = HIGH / 2 - 1; row <= HIGH / 2; row++)
		for (int c = 0; c < 3; c++)
			((float *)panorama.pixels)[3 * (row * WIDE + 160) + c] = 50000.0f;
	s.view.surroundings.panorama = panorama;
	for (uint32_t w = 0; w < sizeof ways / sizeof *ways; w++)
		check_way(&s, ways[w]);
	assert_int_not_equal(s.render->panorama.lamp_count, 0);
	stage_close(&s);
	stilb_image_finish(&panorama);
}

/* A program's pass between may take the place of either part. */
static stilb_result take_the_other(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	assert_string_equal(stilb_gpu_plan_name(plan, *image), STILB_RENDER_IMAGE_AMBIENT);
	*image = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_REFLECTION);
	(void)user;
	return STILB_OK;
}

static void a_part_that_is_replaced(void **state)
{
	(void)state;
	stage s = open_squares(1);
	s.view.surroundings.glossy = true;
	s.view.ambient = STILB_RENDER_AMBIENT_NONE;
	stilb_image dark = stage_picture(&s);
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_AMBIENT, .add = take_the_other, .user = &s};
	assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
	s.view.ambient = STILB_RENDER_AMBIENT_ENVIRONMENT;
	s.view.ambient_apart = true;
	stilb_image sum = stage_picture(&s);
	read_image(&s, STILB_RENDER_IMAGE_REFLECTION, sizeof parts.reflection, parts.reflection);
	uint32_t checked = 0;
	for (uint32_t i = 0; i < PIXELS; i++) {
		met m = meet(i % SIDE, i / SIDE);
		for (int c = 0; c < 3 && !m.near && m.plain >= 0 && !m.covered; c++, checked++) {
			double want = picture_value(&dark, i % SIDE, i / SIDE, c) + 2.0 * reference_half(parts.reflection[i][c]);
			assert_near("twice the reflection", picture_value(&sum, i % SIDE, i / SIDE, c), want,
			            SUM_OFF * want + SUM_FLOOR);
		}
	}
	assert_true(checked > 1000);
	stilb_image_finish(&dark);
	stilb_image_finish(&sum);
	stage_close(&s);
}

/* With several samples a pixel there are no parts, and the picture is the same. */
static void not_of_several_samples(void **state)
{
	(void)state;
	stage s = open_squares(4);
	stilb_image whole = stage_picture(&s);
	s.view.ambient_apart = true;
	stilb_image same = stage_picture(&s);
	assert_memory_equal(whole.pixels, same.pixels, stilb_image_size(&whole));
	assert_int_equal(stilb_gpu_plan_find(stilb_render_plan(s.render), STILB_RENDER_IMAGE_AMBIENT), 0);
	stilb_image_finish(&whole);
	stilb_image_finish(&same);
	stage_close(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_seen),           cmocka_unit_test(beside_the_picture),
		cmocka_unit_test(nothing_unless_asked),   cmocka_unit_test(parts_and_their_sum),
		cmocka_unit_test(parts_of_a_panorama),    cmocka_unit_test(a_part_that_is_replaced),
		cmocka_unit_test(not_of_several_samples),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
