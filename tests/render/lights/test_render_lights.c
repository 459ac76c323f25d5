/* Every way of stilb_render_lighting shows the same picture: lists of cells bit for bit, deferred lighting within what
 * its images can hold. A field of balls under lamps of every kind and falloff, surfaces of every kind, an impostor,
 * parallel views, a second pass into a target. Under the validation layer. */
#include "geometry/geometry_impostor.h"
#include "shading/shade_brdf.h"
#include "shading/shade_srgb.h"

#include "render/maps/maps_stage.h" /* names a type as these name variables */

#define WIDTH 99u /* odd: the last cells of a row are narrow */
#define HEIGHT 67u
#define LAMPS 60u

/* What deferred lighting may be off by, a share of the light: reflectances in steps of 1 / 65535 with a rounding of
 * half a step, normals likewise, a half float's 11 bits, each taken twice as its pixel adds two. Highlights of the
 * least roughness here multiply an angle's error by some 50. */
#define DEFERRED_OFF 2e-3
#define DEFERRED_ADDED 3.0  /* times as much where each light is rounded: up to 16 a pixel, each by 2^-12 */
#define DEFERRED_FLOOR 1e-4 /* radiance: half floats are coarse beside nothing */

/* From above: 16 x 10.8 m, depth 1 at y = 10 and 0 at y = -10. */
static const stilb_mat4 parallel_view = {{1 / 8.0f, 0, 0, 0, 0, 0, 0.05f, 0, 0, 1 / 5.4f, 0, 0, 0, 0, 0.5f, 1}};

typedef struct field {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_scene_light lights[LAMPS + 8];
	uint32_t light_count;
	stilb_render_view view;
	stilb_render_target target;
} field;

static stilb_scene_light lamp(stilb_scene_light_kind kind, stilb_scene_light_falloff falloff, float x, float z)
{
	stilb_scene_light light = {.kind = kind,
	                           .position = {x, 1.2f, z},
	                           .direction = {0.0f, -1.0f, 0.0f},
	                           .intensity = {3.0f, 2.0f, 4.0f},
	                           .cos_inner = 0.9f,
	                           .cos_outer = 0.6f,
	                           .radius = 0.3f,
	                           .half_x = {0.3f, 0.0f, 0.0f},
	                           .half_y = {0.0f, 0.0f, 0.4f},
	                           .falloff = falloff,
	                           .reach = 2.5f};
	assert_null(stilb_scene_light_mistake(&light));
	return light;
}

/* Lamps as of stilb demo --lights, a light of each other kind with each falloff that ends, a sun among them, and a lamp
 * that ends nowhere. */
static void field_lights(field *f)
{
	memcpy(f->lights, f->scene->lights + 1, LAMPS * sizeof *f->lights);
	f->light_count = LAMPS;
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_SUBTRACTED, -3.0f, 2.0f);
	f->lights[f->light_count++] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.6f, -0.8f, 0.0f}, .intensity = {0.1f, 0.1f, 0.2f}};
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_RECTANGLE, STILB_SCENE_LIGHT_RANGED, 4.0f, 1.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_PHYSICAL, 0.0f, 6.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_RANGED, 1.0f, 7.0f);
	f->lights[f->light_count++] = lamp(STILB_SCENE_LIGHT_SPOT, STILB_SCENE_LIGHT_SUBTRACTED, -2.0f, 7.0f);
	f->lights[f->light_count] = lamp(STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_WINDOWED, 0.0f, 2.0f);
	f->lights[f->light_count++].use = STILB_SCENE_LIGHT_BAKED;
}

static field field_open(stilb_render_output output, uint32_t workers, uint32_t samples)
{
	field f = {0};
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_VULKAN,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .samples = samples,
	                          .output = output,
	                          .context_count = workers + 1,
	                          .validate = true};
	if (stilb_render_create(&desc, &f.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &f.pool), 0);
	assert_int_equal(stilb_scene_create_stress(64, 7, &f.scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(f.scene, LAMPS), STILB_OK);
	assert_int_equal(stilb_render_set_scene(f.render, f.scene), STILB_OK);
	field_lights(&f);
	reference_camera camera =
		reference_camera_at((dvec){1, 2.5, 12}, (dvec){0, 0, 3}, (dvec){0, 1, 0}, 1.2, WIDTH, HEIGHT);
	f.view = (stilb_render_view){.view_projection = reference_matrix(&camera),
	                             .camera_position = {1.0f, 2.5f, 12.0f},
	                             .light_count = f.light_count,
	                             .surroundings = f.scene->surroundings,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS},
	                             .shading = stilb_render_shading_default()};
	return f;
}

static void field_close(field *f)
{
	assert_int_equal(stilb_render_wait(f->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(f->render), 0);
	stilb_render_destroy(f->render);
	stilb_scene_destroy(f->scene);
	stilb_job_pool_destroy(f->pool);
}

/* Frames of the view lit in that way; passes: how often it draws the field into the same target. */
static void field_frame(field *f, stilb_render_lighting lighting, uint32_t passes)
{
	stilb_render_pass table[4] = {{.name = "main"}, {.name = "again"}, {.name = "once more"}};
	uint32_t ids[64];
	for (uint32_t m = 0; m < 64; m++)
		ids[m] = m;
	f->view.lighting = lighting;
	f->view.lights = f->lights;
	assert_int_equal(stilb_render_frame_begin(f->render), STILB_OK);
	for (uint32_t p = 0; p < passes; p++)
		assert_int_equal(stilb_render_record(f->render, p, f->scene, ids + 32 * p, passes == 1 ? 64 : 32, f->pool, 0),
		                 STILB_OK);
	if (stilb_render_replay(f->render, table, passes, &f->view, 1, f->pool, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static stilb_image field_picture(field *f, stilb_render_lighting lighting, uint32_t passes)
{
	stilb_image image;
	field_frame(f, lighting, passes);
	if (stilb_render_read_image(f->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static void assert_same_bits(const char *what, const stilb_image *a, const stilb_image *b)
{
	assert_int_equal(stilb_image_size(a), stilb_image_size(b));
	if (memcmp(a->pixels, b->pixels, stilb_image_size(a)) != 0)
		fail_msg("%s: pictures differ", what);
}

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

/* How far the pictures are apart, as a multiple of what deferred lighting may be off by; at most 1 is good. */
static double deferred_off(const stilb_image *want, const stilb_image *got)
{
	double worst = 0.0;
	for (uint32_t y = 0; y < want->height; y++)
		for (uint32_t x = 0; x < want->width; x++)
			for (int c = 0; c < 3; c++) {
				double a = picture_value(want, x, y, c), b = picture_value(got, x, y, c);
				worst = fmax(worst, fabs(a - b) / (DEFERRED_FLOOR + DEFERRED_OFF * a));
			}
	return worst;
}

/* times: what is allowed. */
static void assert_near_deferred(const char *what, const stilb_image *want, const stilb_image *got, double times)
{
	double off = deferred_off(want, got);
	if (!(off <= times))
		fail_msg("%s: off by %.2f, allowed are %.2f", what, off, times);
}

static void assert_deferred(const char *what, const stilb_image *want, const stilb_image *got)
{
	assert_near_deferred(what, want, got, 1.0);
}

/* Deferred lighting with each coverage and each way to keep surfaces. */
static void all_coverages(field *f, const char *what, const stilb_image *forward)
{
	for (int coverage = 0; coverage < STILB_RENDER_COVERAGE_WAYS; coverage++) {
		f->view.deferred.coverage = (stilb_render_coverage)coverage;
		stilb_image deferred = field_picture(f, STILB_RENDER_LIGHTING_DEFERRED, 1);
		assert_near_deferred(what, forward, &deferred,
		                     coverage == STILB_RENDER_COVERAGE_RECTANGLES ? DEFERRED_ADDED : 1.0);
		stilb_image_finish(&deferred);
	}
	f->view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
}

/* The field in every way, after that it is not dark: an eighth of the pixels at least are lit. */
static void all_ways(field *f, const char *what)
{
	stilb_image forward = field_picture(f, STILB_RENDER_LIGHTING_FORWARD, 1);
	stilb_image clustered = field_picture(f, STILB_RENDER_LIGHTING_CLUSTERED, 1);
	stilb_image by_itself = field_picture(f, STILB_RENDER_LIGHTING_AUTO, 1);
	stilb_image multipass = field_picture(f, STILB_RENDER_LIGHTING_MULTIPASS, 1);
	uint32_t lit = 0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			lit += picture_value(&forward, x, y, 1) > 0.03;
	if (lit <= WIDTH * HEIGHT / 8)
		fail_msg("%s: %u pixels are lit", what, lit);
	assert_same_bits(what, &forward, &clustered);
	assert_same_bits(what, &forward, &by_itself);
	assert_near_deferred(what, &forward, &multipass, DEFERRED_ADDED); /* rounded nine times */
	stilb_image_finish(&multipass);
	all_coverages(f, what, &forward);
	stilb_image_finish(&forward);
	stilb_image_finish(&clustered);
	stilb_image_finish(&by_itself);
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
					assert_true(isfinite(picture_value(&image, x, y, 0)));
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
		stilb_image other = field_picture(&f, (stilb_render_lighting)way, 1);
		bool rounds = way == STILB_RENDER_LIGHTING_MULTIPASS || way == STILB_RENDER_LIGHTING_DEFERRED;
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

/* With several samples a pixel there is no deferred lighting, and lists are the same bits, too. */
static void several_samples(void **state)
{
	(void)state;
	field f = field_open(STILB_RENDER_OUTPUT_LINEAR, 1, 4);
	stilb_image forward = field_picture(&f, STILB_RENDER_LIGHTING_FORWARD, 1);
	stilb_image clustered = field_picture(&f, STILB_RENDER_LIGHTING_CLUSTERED, 1);
	stilb_image deferred = field_picture(&f, STILB_RENDER_LIGHTING_DEFERRED, 1);
	assert_same_bits("four samples", &forward, &clustered);
	assert_same_bits("four samples, deferred", &forward, &deferred);
	stilb_image multipass = field_picture(&f, STILB_RENDER_LIGHTING_MULTIPASS, 1);
	assert_true(share_off(&forward, &multipass) <
	            0.02); /* silhouettes: the middle of what is covered, not of what is seen */
	stilb_image_finish(&multipass);
	stilb_image_finish(&forward);
	stilb_image_finish(&clustered);
	stilb_image_finish(&deferred);
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
		stilb_image clustered = field_picture(&f, STILB_RENDER_LIGHTING_CLUSTERED, 2);
		stilb_image multipass = field_picture(&f, STILB_RENDER_LIGHTING_MULTIPASS, 2);
		assert_near_deferred("two passes", &forward, &multipass, DEFERRED_ADDED);
		stilb_image_finish(&multipass);
		stilb_image deferred = field_picture(&f, STILB_RENDER_LIGHTING_DEFERRED, 2);
		assert_same_bits("two passes", &forward, &clustered);
		assert_deferred("two passes", &forward, &deferred);
		stilb_image_finish(&forward);
		stilb_image_finish(&clustered);
		stilb_image_finish(&deferred);
	}
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
		stilb_image clustered = field_picture(&f, STILB_RENDER_LIGHTING_CLUSTERED, 1);
		stilb_image deferred = field_picture(&f, STILB_RENDER_LIGHTING_DEFERRED, 1);
		assert_same_bits("no lights", &forward, &clustered);
		assert_deferred("no lights", &forward, &deferred);
		stilb_image_finish(&forward);
		stilb_image_finish(&clustered);
		stilb_image_finish(&deferred);
	}
	field_close(&f);
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

/* Squares side by side and one behind the other, of each kind of surface; those that deferred lighting cannot hold are
 * lit at once. */
static void surfaces_of_every_kind(void **state)
{
	(void)state;
	enum { MATT, GLOSSY, UNLIT, MASKED, BLENDS, COATED, BRUSHED, GLASS, NORMALS, KINDS };
	stage s = stage_open((stilb_render_desc){.width = 48}, 1);
	stilb_scene_surface kinds[KINDS];
	square q;
	square_make(&q, 1.0f);
	for (int k = 0; k < KINDS; k++) {
		kinds[k] = stilb_scene_surface_make();
		kinds[k].roughness = 0.4f;
		kinds[k].metalness = 0.3f;
		memcpy(kinds[k].color, (float[4]){0.8f, 0.5f + 0.05f * (float)k, 0.3f, 1.0f}, sizeof kinds[k].color);
	}
	kinds[MATT] = surface_matt();
	kinds[UNLIT].unlit = true;
	kinds[MASKED].alpha = STILB_SCENE_MASK;
	kinds[MASKED].maps[STILB_SCENE_MAP_COLOR].texture = 1;
	kinds[MASKED].cutoff = 0.5f;
	kinds[BLENDS].alpha = STILB_SCENE_BLEND;
	kinds[BLENDS].color[3] = 0.6f;
	kinds[COATED].clearcoat = 0.7f;
	kinds[BRUSHED].anisotropy = 0.8f;
	kinds[GLASS].transmission = 0.8f;
	kinds[NORMALS].maps[STILB_SCENE_MAP_NORMAL].texture = 2;
	stilb_image images[2] = {image_even(4, (uint8_t[4]){200, 180, 160, 255}, STILB_IMAGE_U8_SRGB),
	                         image_even(4, (uint8_t[4]){150, 110, 240, 255}, STILB_IMAGE_U8_LINEAR)};
	((uint8_t *)images[0].pixels)[3] = 0; /* a quarter of the mask is cut out */
	stilb_scene_build *build = stilb_scene_build_begin();
	for (int t = 0; t < 2; t++)
		stilb_scene_build_texture(build, &images[t]);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (int k = 0; k < KINDS; k++) /* nine in rows of three; each hides a little of the next */
		stage_model(
			build, mesh, stage_material(build, &kinds[k]),
			stilb_mat4_scale_translate(0.4f, 0.6f * (float)(k % 3 - 1), 0.05f * (float)k, 0.6f * (float)(k / 3 - 1)));
	stage_show(&s, build);
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
	assert_same_bits("surfaces", &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_CLUSTERED]);
	assert_deferred("surfaces", &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_DEFERRED]);
	assert_deferred("surfaces", &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_MULTIPASS]);
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++)
		stilb_image_finish(&pictures[way]);
	stage_close(&s);
	for (int t = 0; t < 2; t++)
		stilb_image_finish(&images[t]);
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
	assert_same_bits("impostor", &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_CLUSTERED]);
	assert_deferred("impostor", &pictures[STILB_RENDER_LIGHTING_FORWARD], &pictures[STILB_RENDER_LIGHTING_DEFERRED]);
	assert_near_deferred("impostor", &pictures[STILB_RENDER_LIGHTING_FORWARD],
	                     &pictures[STILB_RENDER_LIGHTING_MULTIPASS], DEFERRED_ADDED);
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
		cmocka_unit_test(no_lights),
		cmocka_unit_test(surfaces_of_every_kind),
		cmocka_unit_test(an_impostor),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
