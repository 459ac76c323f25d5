/* Every way of stilb_render_lighting shows the same picture: lists of cells bit for bit, deferred lighting within what
 * its images can hold. A field of balls under lamps of every kind and falloff, surfaces of every kind, an impostor,
 * parallel views, a second pass into a target. Under the validation layer. */
#include "geometry/geometry_impostor.h"
#include "shading/shade_brdf.h"
#include "shading/shade_srgb.h"

#include "render/lights/lights_field.h" /* names a type as these name variables */
#include "render/lights/lights_surfaces.h"

/* From above: 16 x 10.8 m, depth 1 at y = 10 and 0 at y = -10. */
static const stilb_mat4 parallel_view = {{1 / 8.0f, 0, 0, 0, 0, 0, 0.05f, 0, 0, 1 / 5.4f, 0, 0, 0, 0, 0.5f, 1}};

/* The share of pixels that are apart by more than what several passes may be off by. */
static double share_off(const stilb_image *want, const stilb_image *got)
{
	uint32_t off = 0;
	for (uint32_t y = 0; y < want->height; y++)
		for (uint32_t x = 0; x < want->width; x++)
			for (int c = 0, apart = 0; c < 3 && !apart; c++) {
				double a = picture_value(want, x, y, c), b = picture_value(got, x, y, c);
				apart = fabs(a - b) > DEFERRED_ADDED * (DEFERRED_FLOOR + DEFERRED_OFF * a);
				off += (uint32_t)apart;
			}
	return off / ((double)want->width * want->height);
}

/* Deferred lighting with each coverage and each way to keep surfaces. */
static void all_coverages(field *f, const char *what, const stilb_image *forward)
{
	for (int coverage = 0; coverage < STILB_RENDER_COVERAGE_WAYS; coverage++) {
		f->view.deferred.coverage = (stilb_render_coverage)coverage;
		stilb_image deferred = field_picture(f, STILB_RENDER_LIGHTING_DEFERRED, 1);
		bool added = coverage == STILB_RENDER_COVERAGE_RECTANGLES || coverage == STILB_RENDER_COVERAGE_VOLUMES;
		char text[96];
		snprintf(text, sizeof text, "%s, %s", what, stilb_render_coverage_names[coverage]);
		assert_near_deferred(text, forward, &deferred, added ? DEFERRED_ADDED : 1.0);
		stilb_image_finish(&deferred);
	}
	f->view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
}

/* The field in every way, after that it is not dark: an eighth of the pixels at least are lit. */
static void all_ways(field *f, const char *what)
{
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	uint32_t lit = 0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			lit += picture_value(&forward, x, y, 1) > 0.03;
	if (lit <= WIDTH * HEIGHT / 8)
		fail_msg("%s: %u pixels are lit", what, lit);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		stilb_image picture = field_picture(f, (stilb_render_lighting)way, 1);
		assert_as_forward(what, (stilb_render_lighting)way, &forward, &picture);
		stilb_image_finish(&picture);
	}
	all_coverages(f, what, &forward);
	stilb_image_finish(&forward);
}

/* Jitter draws as another matrix would, and finds the same lights: lists, and the stream hash, are as without. */
static void moved_by_a_part_of_a_pixel(field *f)
{
	stilb_mat4 still = f->view.view_projection;
	float by[2] = {0.98f / WIDTH, -0.96f / HEIGHT};
	memcpy(f->view.jitter, by, sizeof by);
	static const stilb_render_lighting some[] = {STILB_RENDER_LIGHTING_DEFERRED, STILB_RENDER_LIGHTING_TILED_DEFERRED,
	                                             STILB_RENDER_LIGHTING_TILED_FORWARD};
	stilb_image jittered = field_picture(f, STILB_RENDER_LIGHTING_CLUSTERED, 1);
	uint64_t hash = stilb_render_stream_hash(f->render);
	f->view.view_projection = stilb_render_view_drawn(&f->view);
	memset(f->view.jitter, 0, sizeof f->view.jitter);
	stilb_image moved = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	assert_same_bits("moved by its matrix", &moved, &jittered);
	f->view.view_projection = still;
	memcpy(f->view.jitter, by, sizeof by);
	for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
		stilb_image picture = field_picture(f, some[i], 1);
		assert_as_forward("moved by a part of a pixel", some[i], &moved, &picture);
		stilb_image_finish(&picture);
	}
	memset(f->view.jitter, 0, sizeof f->view.jitter);
	stilb_image without = field_picture(f, STILB_RENDER_LIGHTING_CLUSTERED, 1);
	assert_int_equal(stilb_render_stream_hash(f->render), hash);
	assert_true(memcmp(without.pixels, jittered.pixels, stilb_image_size(&without)) != 0);
	stilb_image_finish(&without);
	stilb_image_finish(&moved);
	stilb_image_finish(&jittered);
}

static void a_field_of_balls(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	all_ways(&f, "from above");
	f.view.both_sides = true;
	all_ways(&f, "from both sides");
	f.view.both_sides = false;
	f.view.shading.brdf = SHADE_BRDF_MICROFACET;
	f.view.shading.wrap = 0.3f;
	f.view.shading.anisotropy = 0.4f;
	f.view.shading.ndf = SHADE_NDF_GGX_ANISOTROPIC;
	all_ways(&f, "anisotropic and wrapped");
	f.view.shading = stilb_render_shading_default();
	reference_camera inside =
		reference_camera_at((dvec){0.4, 0.9, 0.3}, (dvec){-4, 0.4, -9}, (dvec){0, 1, 0}, 0.7, WIDTH, HEIGHT);
	f.view.view_projection = reference_matrix(&inside);
	memcpy(f.view.camera_position, (float[3]){0.4f, 0.9f, 0.3f}, sizeof f.view.camera_position);
	all_ways(&f, "among the lamps");
	moved_by_a_part_of_a_pixel(&f);
	/* Lamps around the viewer that end beyond the far end. */
	stilb_mat4 eye = stilb_mat4_view(stilb_vec3_make(0.4f, 0.9f, 0.3f), 0.4f, -0.9f);
	f.view.view_projection =
		stilb_mat4_multiply(stilb_mat4_perspective(1.2f, (float)WIDTH / (float)HEIGHT, 0.1f, 2.0f), eye);
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	all_coverages(&f, "with a near end", &forward);
	stilb_image_finish(&forward);
	f.view.view_projection = parallel_view;
	memcpy(f.view.camera_position, (float[3]){0.0f, 1000.0f, 0.0f}, sizeof f.view.camera_position);
	all_ways(&f, "in parallel");
	field_close(&f);
}

/* The share of pixels that are off by more than 4 of 255 steps of what a display shows, and how far they are off on
 * average. */
static void steps_off(const stilb_image *want, const stilb_image *got, double *share, double *mean)
{
	*share = *mean = 0.0;
	for (uint32_t y = 0; y < want->height; y++)
		for (uint32_t x = 0; x < want->width; x++) {
			double off = 0.0;
			for (int c = 0; c < 3; c++) {
				double a = picture_value(want, x, y, c), b = picture_value(got, x, y, c);
				off = fmax(off, fabs((double)shade_srgb_from_linear((float)fmin(a, 1.0)) -
				                     (double)shade_srgb_from_linear((float)fmin(b, 1.0))));
			}
			*share += (off > 4.0 / 255.0) / ((double)want->width * want->height);
			*mean += off / ((double)want->width * want->height);
		}
}

/* Surfaces in 8 bits: matt ones are off by 4 of 255 steps of what a display shows in at most this share of the pixels,
 * and by a hundredth on average. */
static void assert_eight_bits(field *f, const char *what, double most)
{
	f->view.deferred = (stilb_render_deferred){0};
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	f->view.deferred.gbuffer = STILB_RENDER_GBUFFER_RGBA8;
	double far = 0.0, sum = 0.0;
	for (int coverage = 0; coverage < STILB_RENDER_COVERAGE_WAYS; coverage++) {
		f->view.deferred.coverage = (stilb_render_coverage)coverage;
		stilb_image narrow = field_picture(f, STILB_RENDER_LIGHTING_DEFERRED, 1);
		double share, mean;
		steps_off(&forward, &narrow, &share, &mean);
		far = fmax(far, share);
		sum = fmax(sum, mean);
		stilb_image_finish(&narrow);
	}
	if (far > most || !(sum < 0.01))
		fail_msg("%s: a share of %.5f is off by more than 4 steps, %.5f on average", what, far, sum);
	stilb_image_finish(&forward);
}

/* From cameras with a far end, without one, whose matrix is scaled, and in parallel. */
static void surfaces_in_eight_bits(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	f.view.shading.brdf = SHADE_BRDF_LAMBERT;
	stilb_mat4 eye = stilb_mat4_view(stilb_vec3_make(1.0f, 2.5f, 12.0f), 0.0f, -0.25f);
	stilb_mat4 ends = stilb_mat4_multiply(stilb_mat4_perspective(1.2f, (float)WIDTH / (float)HEIGHT, 0.1f, 40.0f), eye);
	f.view.view_projection = ends;
	assert_eight_bits(&f, "40 m", 0.001);
	f.view.view_projection =
		stilb_mat4_multiply(stilb_mat4_perspective(1.2f, (float)WIDTH / (float)HEIGHT, 0.001f, 1e5f), eye);
	assert_eight_bits(&f, "100 km", 0.001);
	for (int i = 0; i < 16; i++)
		f.view.view_projection.m[i] = 0.03f * ends.m[i];
	assert_eight_bits(&f, "scaled", 0.001);
	f.view.view_projection = parallel_view;
	memcpy(f.view.camera_position, (float[3]){0.0f, 1000.0f, 0.0f}, sizeof f.view.camera_position);
	assert_eight_bits(&f, "in parallel", 0.003); /* balls of six pixels: where z is near 0 it is coarse in x and y */
	field_close(&f);
}

/* Whatever finite matrix a dump has, each way draws a frame. */
static void matrices_that_show_nothing(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	stilb_mat4 good = f.view.view_projection;
	for (int kind = 0; kind < 3; kind++) {
		f.view.view_projection = good;
		for (int c = 0; c < 4; c++)
			if (kind == 0)
				f.view.view_projection.m[4 * c + 2] = 0.5f * good.m[4 * c + 3]; /* one depth everywhere */
			else if (kind == 1)
				memset(&f.view.view_projection, 0, sizeof f.view.view_projection);
			else
				f.view.view_projection.m[4 * c] = 1e30f;
		for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
			stilb_image image = field_picture(&f, (stilb_render_lighting)way, 1);
			for (uint32_t y = 0; y < HEIGHT; y++)
				for (uint32_t x = 0; x < WIDTH; x++)
					if (!isfinite(picture_value(&image, x, y, 0)))
						fail_msg("%s, matrix %d", stilb_render_lighting_names[way], kind);
			stilb_image_finish(&image);
		}
	}
	field_close(&f);
}

/* What displays show, by codes: the same, but for one step where deferred lights or several passes are rounded. */
static void as_displays_show_it(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_DISPLAY, 1, 1);
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		if (way_nearness((stilb_render_lighting)way) == OWN)
			continue;
		stilb_image other = field_picture(&f, (stilb_render_lighting)way, 1);
		bool rounds = way_nearness((stilb_render_lighting)way) != SAME_BITS;
		const uint8_t *a = forward.pixels, *b = other.pixels;
		int worst = 0;
		for (size_t i = 0; i < stilb_image_size(&forward); i++)
			worst = abs(a[i] - b[i]) > worst ? abs(a[i] - b[i]) : worst;
		if (worst > rounds)
			fail_msg("%s is off by %d codes", stilb_render_lighting_names[way], worst);
		stilb_image_finish(&other);
	}
	stilb_image_finish(&forward);
	field_close(&f);
}

/* With several samples a pixel the ways of one sample are clustered, and lists are the same bits, too. */
static void several_samples_as_forward(field *f, const char *what)
{
	static const stilb_render_lighting some[] = {STILB_RENDER_LIGHTING_CLUSTERED, STILB_RENDER_LIGHTING_DEFERRED,
	                                             STILB_RENDER_LIGHTING_TILED_FORWARD};
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	for (uint32_t i = 0; i < sizeof some / sizeof *some; i++) {
		stilb_image picture = field_picture(f, some[i], 1);
		assert_same_bits(what, &forward, &picture);
		stilb_image_finish(&picture);
	}
	stilb_image_finish(&forward);
}

static void several_samples(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 4);
	memcpy(f.view.jitter, (float[2]){0.98f / WIDTH, 0.98f / HEIGHT}, sizeof f.view.jitter);
	several_samples_as_forward(&f, "moved");
	memset(f.view.jitter, 0, sizeof f.view.jitter);
	several_samples_as_forward(&f, "still");
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	stilb_image multipass = field_picture(&f, STILB_RENDER_LIGHTING_MULTIPASS, 1);
	assert_true(share_off(&forward, &multipass) <
	            0.02); /* silhouettes: the middle of what is covered, not of what is seen */
	stilb_image_finish(&multipass);
	stilb_image_finish(&forward);
	field_close(&f);
}

/* A target's second pass is lit at once, and hides what lies behind it and is hidden by what lies before it. */
static void two_passes(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	f.target = (stilb_render_target){
		.name = "half", .width = 51, .height = 40, .place = {3, 2, 51, 40}, .kind = STILB_RENDER_TARGET_LIGHT};
	for (int other = 0; other < 2; other++) {
		f.view.target = other ? &f.target : NULL;
		stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 2);
		for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
			stilb_image picture = field_picture(&f, (stilb_render_lighting)way, 2);
			assert_as_forward("two passes", (stilb_render_lighting)way, &forward, &picture);
			stilb_image_finish(&picture);
		}
		stilb_image_finish(&forward);
	}
	field_close(&f);
}

/* Three views in one frame, each with lists of its own: the picture's, one into a target that is smaller than a tile,
 * and one into a target of odd sides. */
static void several_views(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	const stilb_render_target targets[2] = {
		{.name = "tiny", .width = 7, .height = 5, .place = {3, 2, 7, 5}, .kind = STILB_RENDER_TARGET_LIGHT},
		{.name = "odd", .width = 37, .height = 33, .place = {50, 20, 37, 33}, .kind = STILB_RENDER_TARGET_LIGHT}};
	const stilb_render_pass passes[3] = {{.name = "all"}, {.name = "tiny", .view = 1}, {.name = "odd", .view = 2}};
	stilb_image forward = {0};
	uint32_t ids[64];
	for (uint32_t m = 0; m < 64; m++)
		ids[m] = m;
	f.view.lights = f.lights;
	for (int way = STILB_RENDER_LIGHTING_FORWARD; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		f.view.lighting = (stilb_render_lighting)way;
		stilb_render_view views[3] = {f.view, f.view, f.view};
		views[1].target = &targets[0];
		views[2].target = &targets[1];
		reference_camera inside =
			reference_camera_at((dvec){0.4, 0.9, 0.3}, (dvec){-4, 0.4, -9}, (dvec){0, 1, 0}, 0.7, 37, 33);
		views[2].view_projection = reference_matrix(&inside);
		memcpy(views[2].camera_position, (float[3]){0.4f, 0.9f, 0.3f}, sizeof views[2].camera_position);
		assert_int_equal(stilb_render_frame_begin(f.render), STILB_OK);
		for (uint32_t p = 0; p < 3; p++)
			assert_int_equal(stilb_render_record(f.render, p, f.scene, ids, 64, f.pool, 0), STILB_OK);
		stilb_image picture;
		if (stilb_render_replay(f.render, passes, 3, views, 3, f.pool, 0) != STILB_OK ||
		    stilb_render_read_image(f.render, &picture) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		if (way == STILB_RENDER_LIGHTING_FORWARD) {
			forward = picture;
			continue;
		}
		assert_as_forward("three views", (stilb_render_lighting)way, &forward, &picture);
		stilb_image_finish(&picture);
	}
	stilb_image_finish(&forward);
	field_close(&f);
}

/* No light at all, and lights that are only baked; all in front of an empty sky. */
static void no_lights(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 0, 1);
	for (uint32_t i = 0; i < f.light_count; i++)
		f.lights[i].use = STILB_SCENE_LIGHT_BAKED;
	for (int none = 0; none < 2; none++) {
		f.view.light_count = none ? 0 : f.light_count;
		stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
		for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
			stilb_image picture = field_picture(&f, (stilb_render_lighting)way, 1);
			assert_as_forward("no lights", (stilb_render_lighting)way, &forward, &picture);
			if (way_nearness((stilb_render_lighting)way) == OWN) /* what they add up is nothing */
				assert_deferred("no lights", &forward, &picture);
			stilb_image_finish(&picture);
		}
		stilb_image_finish(&forward);
	}
	field_close(&f);
}

static void all_as_forward(const char *what, const stilb_image pictures[STILB_RENDER_LIGHTING_WAYS])
{
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++)
		assert_as_forward(what, (stilb_render_lighting)way, &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[way]);
}

static void check_tiles(stage *s, uint32_t model, float tolerance)
{
	s->view.shading.brdf = model;
	s->view.light_tolerance = 0.0f;
	stilb_image all = stage_picture(s);
	s->view.light_tolerance = tolerance;
	stilb_image some = stage_picture(s);
	double worst = 0.0;
	uint32_t darker = 0, values = 3 * all.width * all.height;
	for (uint32_t y = 0; y < all.height; y++)
		for (uint32_t x = 0; x < all.width; x++)
			for (int c = 0; c < 3; c++) {
				double a = picture_value(&all, x, y, c), off = a - picture_value(&some, x, y, c);
				worst = fmax(worst, off - DEFERRED_FLOOR - DEFERRED_OFF * a);
				darker += off > 0.0;
			}
	if (!(worst <= (double)tolerance) || darker < values / 16)
		fail_msg("model %u: %u of %u values are darker, by %g at most", model, darker, values, worst);
	stilb_image_finish(&all);
	stilb_image_finish(&some);
}

/* With a tolerance tiles leave lights out by their own surfaces, with the cone of their highlights, of each model that
 * has one: all together they send at most so much to any pixel. A floor under 64 lamps. */
static void tiles_with_a_tolerance(void **state)
{
	(void)state;
	static const uint32_t models[] = {SHADE_BRDF_LAMBERT, SHADE_BRDF_BLINN_PHONG_MODIFIED, SHADE_BRDF_PHONG_MODIFIED,
	                                  SHADE_BRDF_MICROFACET};
	stage s = stage_open((stilb_render_desc){.width = 128}, 1);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface glossy = stilb_scene_surface_make();
	glossy.roughness = 0.25f;
	glossy.metalness = 0.5f;
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), material = stage_material(build, &glossy);
	stage_model(build, mesh, material, stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f));
	stage_show(&s, build);
	stilb_scene_light lamps[64];
	for (int i = 0; i < 64; i++) {
		lamps[i] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_WINDOWED, 0.25f * (float)(i % 8) - 0.875f,
		                0.25f * (float)(i / 8) - 0.875f);
		lamps[i].position[1] = 0.3f;
		lamps[i].reach = 2.0f;
		for (int c = 0; c < 3; c++)
			lamps[i].intensity[c] = 0.05f;
	}
	s.view.lights = lamps;
	s.view.light_count = 64;
	s.view.lighting = STILB_RENDER_LIGHTING_TILED_DEFERRED;
	s.view.shading = stilb_render_shading_default();
	s.view.light_peak = 1e6f;
	for (size_t m = 0; m < sizeof models / sizeof *models; m++)
		check_tiles(&s, models[m], 0.3f);
	/* One lamp beside the viewer, in the middle of whose highlight it sends forty times the tolerance. */
	lamps[0].position[1] = 4.0f;
	lamps[0].reach = 12.0f;
	s.view.light_count = 1;
	for (size_t m = 0; m < sizeof models / sizeof *models; m++)
		check_tiles(&s, models[m], 0.01f);
	stage_close(&s);
}

/* ---- light that is added up before surfaces are drawn ------------------------------------------------------------ */

/* The pictures of PRELIGHT and PREPASS are those of FORWARD for what their images can hold, and else not. */
static void apart_off(field *f, stilb_render_lighting way, double *off, double *share)
{
	double mean;
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	for (int coverage = 0; coverage < STILB_RENDER_COVERAGE_WAYS; coverage++) {
		f->view.deferred.coverage = (stilb_render_coverage)coverage;
		stilb_image picture = field_picture(f, way, 1);
		double now = deferred_off(&forward, &picture), part;
		steps_off(&forward, &picture, &part, &mean);
		*off = coverage == 0 || now > *off ? now : *off;
		*share = coverage == 0 || part > *share ? part : *share;
		stilb_image_finish(&picture);
	}
	f->view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
	stilb_image_finish(&forward);
}

static void light_before_surfaces(void **state)
{
	(void)state;
	double off, share;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	f.view.shading.brdf = SHADE_BRDF_LAMBERT;
	apart_off(&f, STILB_RENDER_LIGHTING_PRELIGHT, &off, &share);
	if (!(off <= DEFERRED_ADDED))
		fail_msg("matt, prelight: off by %.2f", off);
	apart_off(&f, STILB_RENDER_LIGHTING_PREPASS, &off, &share);
	if (!(share <= 0.003))
		fail_msg("matt, prepass: a share of %.4f is off", share);
	f.view.shading = (stilb_render_shading){
		.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_NONE};
	apart_off(&f, STILB_RENDER_LIGHTING_PRELIGHT, &off, &share);
	if (!(off <= DEFERRED_ADDED))
		fail_msg("without Fresnel's term, prelight: off by %.2f", off);
	/* What they cannot hold is there to be seen: Fresnel's term of each light, and highlights of other roughness. */
	f.view.shading.f = SHADE_F_SCHLICK;
	apart_off(&f, STILB_RENDER_LIGHTING_PRELIGHT, &off, &share);
	assert_true(share > 0.02 && share < 0.2);
	apart_off(&f, STILB_RENDER_LIGHTING_PREPASS, &off, &share);
	assert_true(share > 0.02 && share < 0.2);
	field_close(&f);
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

/* Squares side by side and one behind the other, of each kind of surface; those that deferred lighting cannot hold are
 * lit at once. */
static void surfaces_of_every_kind(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.width = 48}, 1);
	squares_show(&s, NORMALS);
	stilb_scene_light lamps[16];
	for (int i = 0; i < 16; i++) {
		lamps[i] = lamp(i % 2 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_WINDOWED,
		                0.5f * (float)(i % 4) - 0.8f, 0.5f * (float)(i / 4) - 0.7f);
		lamps[i].reach = 1.6f;
	}
	s.view.lights = lamps;
	s.view.light_count = 16;
	s.view.shading = stilb_render_shading_default();
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	stilb_image pictures[STILB_RENDER_LIGHTING_WAYS];
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		s.view.lighting = (stilb_render_lighting)way;
		pictures[way] = stage_picture(&s);
	}
	all_as_forward("surfaces", pictures);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++)
		stilb_image_finish(&pictures[way]);
	stage_close(&s);
}

/* A floor under a red lamp and a green one: where the red highlight is strongest it has no green; the sum of scattered
 * light has, so that a highlight of PREPASS that was given the sum's colour would have some, too. */
static void colours_of_highlights_are_not_in_the_sum(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.width = 48}, 1);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface glossy = stilb_scene_surface_make();
	glossy.roughness = 0.4f;
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), material = stage_material(build, &glossy);
	stage_model(build, mesh, material, stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f));
	stage_show(&s, build);
	stilb_scene_light lamps[2];
	for (int i = 0; i < 2; i++) {
		lamps[i] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_PHYSICAL, i ? 0.7f : -0.7f, 0.0f);
		memcpy(lamps[i].intensity, (float[3]){i ? 0.0f : 1.0f, i ? 1.0f : 0.0f, 0.0f}, sizeof lamps[i].intensity);
	}
	s.view.lights = lamps;
	s.view.light_count = 2;
	s.view.lighting = STILB_RENDER_LIGHTING_FORWARD;
	memset(&s.view.surroundings, 0, sizeof s.view.surroundings);
	s.view.shading = stilb_render_shading_default();
	s.view.shading.brdf = SHADE_BRDF_LAMBERT;
	stilb_image scattered = stage_picture(&s);
	s.view.shading.brdf = SHADE_BRDF_PHONG_MODIFIED;
	stilb_image whole = stage_picture(&s);
	double brightest = 0.0, green = 0.0, divided = 0.0;
	for (uint32_t y = 0; y < whole.height; y++)
		for (uint32_t x = 0; x < whole.width; x++) {
			double d[2], h[2];
			for (int c = 0; c < 2; c++) {
				d[c] = picture_value(&scattered, x, y, c);
				h[c] = picture_value(&whole, x, y, c) - d[c];
			}
			if (h[0] <= brightest)
				continue;
			brightest = h[0];
			green = h[1] / h[0];
			divided = d[1] / d[0];
		}
	assert_true(brightest > 0.0 && green < 0.1 && divided > 0.25);
	stilb_image_finish(&scattered);
	stilb_image_finish(&whole);
	stage_close(&s);
}

/* A step of two floors within a tile, whose normals are the same, and a lamp between their heights, beside the tile: it
 * lights the lower one; then from below what light wraps around. */
static void a_step_within_a_tile(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.width = 48}, 1);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface matt = surface_matt();
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), material = stage_material(build, &matt);
	stage_model(build, mesh, material, stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f));
	stage_model(build, mesh, material, stilb_mat4_scale_translate(0.5f, -0.5f, 0.8f, 0.0f));
	stage_show(&s, build);
	stilb_scene_light lamps[9];
	for (int i = 0; i < 9; i++) {
		lamps[i] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_WINDOWED, 0.9f, 0.1f * (float)i - 0.4f);
		lamps[i].position[1] = 0.3f;
		lamps[i].reach = 1.6f;
	}
	s.view.lights = lamps;
	s.view.light_count = 9;
	s.view.shading = stilb_render_shading_default();
	for (int wrapped = 0; wrapped < 2; wrapped++) {
		for (int i = 0; wrapped && i < 9; i++)
			lamps[i].position[1] = -0.2f;
		s.view.shading.wrap = wrapped ? 0.5f : 0.0f;
		s.view.lighting = STILB_RENDER_LIGHTING_FORWARD;
		stilb_image forward = stage_picture(&s);
		s.view.lighting = STILB_RENDER_LIGHTING_TILED_DEFERRED;
		stilb_image tiled = stage_picture(&s);
		assert_as_forward(wrapped ? "a wrapped step" : "a step", STILB_RENDER_LIGHTING_TILED_DEFERRED, &forward,
		                  &tiled);
		stilb_image_finish(&forward);
		stilb_image_finish(&tiled);
	}
	stage_close(&s);
}

/* ---- impostors --------------------------------------------------------------------------------------------------- */

/* Of an impostor the point is lit that its pictures show, which lies before its plate or behind it. */
static void an_impostor(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 1);
	static const stilb_scene_material material = {
		.diffuse = {0.2f, 0.6f, 0.3f}, .specular = {0.1f, 0.1f, 0.1f}, .roughness = 0.5f};
	stilb_scene_mesh ball;
	assert_int_equal(stilb_scene_mesh_sphere(2, &ball), STILB_OK);
	stilb_geometry_impostor_part part = {.mesh = &ball, .material = &material};
	stilb_geometry_impostor_desc desc = {.grid = 5, .side = 24, .samples = 2};
	stilb_scene_impostor baked;
	stilb_render_impostor impostor;
	assert_int_equal(stilb_geometry_impostor_bake(&part, 1, &desc, f.pool, 0, &baked), STILB_OK);
	assert_int_equal(stilb_render_impostor_create(f.render, &baked, &impostor), STILB_OK);
	stilb_scene_impostor_finish(&baked);
	stilb_scene_mesh_finish(&ball);
	stilb_image pictures[STILB_RENDER_LIGHTING_WAYS + 1]; /* the last: deferred, in eight bits */
	for (int way = 0; way <= STILB_RENDER_LIGHTING_WAYS; way++) {
		stilb_render_pass pass = {.name = "main"};
		bool narrow = way == STILB_RENDER_LIGHTING_WAYS;
		f.view.lighting = narrow ? STILB_RENDER_LIGHTING_DEFERRED : (stilb_render_lighting)way;
		f.view.deferred.gbuffer = narrow ? STILB_RENDER_GBUFFER_RGBA8 : STILB_RENDER_GBUFFER_WIDE;
		f.view.lights = f.lights;
		assert_int_equal(stilb_render_frame_begin(f.render), STILB_OK);
		assert_int_equal(stilb_render_pass_begin(f.render, 0, 1), STILB_OK);
		stilb_render_context *context = stilb_render_context_get(f.render, 0);
		stilb_render_segment_begin(context, 0, 0);
		for (int i = 0; i < 5; i++) {
			stilb_mat4 place = stilb_mat4_scale_translate(0.9f, 2.0f * (float)i - 4.0f, 0.5f, 6.0f - (float)i);
			stilb_render_draw(context, impostor.mesh, impostor.material, &place);
		}
		stilb_render_segment_end(context);
		assert_int_equal(stilb_render_pass_end(f.render, 0), STILB_OK);
		if (stilb_render_replay(f.render, &pass, 1, &f.view, 1, f.pool, 0) != STILB_OK ||
		    stilb_render_read_image(f.render, &pictures[way]) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	all_as_forward("impostor", pictures);
	double share, mean;
	steps_off(&pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_WAYS], &share, &mean);
	if (!(share < 0.002 && mean < 0.003)) /* glossy */
		fail_msg("impostor in eight bits: a share of %.5f, %.5f on average", share, mean);
	for (int way = 0; way <= STILB_RENDER_LIGHTING_WAYS; way++)
		stilb_image_finish(&pictures[way]);
	field_close(&f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_field_of_balls),
		cmocka_unit_test(surfaces_in_eight_bits),
		cmocka_unit_test(matrices_that_show_nothing),
		cmocka_unit_test(as_displays_show_it),
		cmocka_unit_test(several_samples),
		cmocka_unit_test(two_passes),
		cmocka_unit_test(several_views),
		cmocka_unit_test(tiles_with_a_tolerance),
		cmocka_unit_test(light_before_surfaces),
		cmocka_unit_test(no_lights),
		cmocka_unit_test(surfaces_of_every_kind),
		cmocka_unit_test(colours_of_highlights_are_not_in_the_sum),
		cmocka_unit_test(a_step_within_a_tile),
		cmocka_unit_test(an_impostor),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
