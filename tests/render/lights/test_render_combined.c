/* Lights combined in one pass (render_combined.h): with four lights or fewer at each model the same bits as forward
 * lighting, for every kind of surface, models that move and impostors; with more the sum is the one that the shading
 * headers have; how far pictures of matt scenes are off; a lamp that passes by never changes a pixel by more than a
 * sixteenth of what the crossing is; the same bits for any number of workers. Under the validation layer. */
#include "geometry/geometry_impostor.h"
#include "geometry/geometry_lights.h"
#include "light/light.h"
#include "scene/scene_impostor.h"
#include "scene/scene_light_shade.h"
#include "shading/shade_brdf.h"
#include "shading/shade_sh.h"

#include "render/lights/lights_surfaces.h" /* names a type as these name variables */

#define WIDTH 96u
#define HEIGHT 64u

/* A stress test's models under lamps. */
typedef struct balls {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_scene_light *lights; /* [view.light_count] */
	stilb_render_view view;
	uint32_t *ids; /* [scene->model_count] */
} balls;

static balls balls_open(uint32_t models, uint64_t seed, uint32_t lamps, uint32_t workers)
{
	balls b = {0};
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_VULKAN,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .samples = 1,
	                          .output = STILB_RENDER_OUTPUT_LINEAR,
	                          .context_count = workers + 1,
	                          .validate = true};
	if (stilb_render_create(&desc, &b.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &b.pool), 0);
	assert_int_equal(stilb_scene_create_stress(models, seed, &b.scene), STILB_OK);
	assert_int_equal(stilb_scene_stress_add_lamps(b.scene, lamps), STILB_OK);
	assert_int_equal(stilb_render_set_scene(b.render, b.scene), STILB_OK);
	b.lights = calloc(lamps, sizeof *b.lights);
	b.ids = calloc(b.scene->model_count, sizeof *b.ids);
	assert_true(b.lights && b.ids);
	memcpy(b.lights, b.scene->lights + 1, lamps * sizeof *b.lights); /* without the moon */
	for (uint32_t m = 0; m < b.scene->model_count; m++)
		b.ids[m] = m;
	reference_camera camera =
		reference_camera_at((dvec){1, 2.5, 12}, (dvec){0, 0, 3}, (dvec){0, 1, 0}, 1.2, WIDTH, HEIGHT);
	b.view = (stilb_render_view){.view_projection = reference_matrix(&camera),
	                             .camera_position = {1.0f, 2.5f, 12.0f},
	                             .lights = b.lights,
	                             .light_count = lamps,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS},
	                             .shading = stilb_render_shading_default()};
	return b;
}

static void balls_close(balls *b)
{
	assert_int_equal(stilb_render_wait(b->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(b->render), 0);
	stilb_render_destroy(b->render);
	stilb_scene_destroy(b->scene);
	stilb_job_pool_destroy(b->pool);
	free(b->lights);
	free(b->ids);
}

/* A frame of the scene, recorded with the view, lit in that way. */
static stilb_image frame_of(stilb_render *render, const stilb_scene *scene, const uint32_t *ids,
                            stilb_render_view *view, stilb_job_pool *pool, stilb_render_lighting lighting)
{
	stilb_image image = {0};
	stilb_render_pass pass = {.name = "main"};
	view->lighting = lighting;
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	stilb_result result = stilb_render_record_view(render, 0, scene, ids, scene->model_count, view, pool, 0);
	if (result == STILB_OK)
		result = stilb_render_replay(render, &pass, 1, view, 1, pool, 0);
	if (result != STILB_OK || stilb_render_read_image(render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static stilb_image balls_picture(balls *b, stilb_render_lighting lighting)
{
	return frame_of(b->render, b->scene, b->ids, &b->view, b->pool, lighting);
}

static bool same_bits(const stilb_image *a, const stilb_image *b)
{
	return stilb_image_size(a) == stilb_image_size(b) && memcmp(a->pixels, b->pixels, stilb_image_size(a)) == 0;
}

/* The share of the picture's pixels that lights reach. */
static double lit_share(const stilb_image *image)
{
	double lit = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++)
			lit +=
				picture_value(image, x, y, 0) + picture_value(image, x, y, 1) + picture_value(image, x, y, 2) > 0.003;
	return lit / (WIDTH * HEIGHT);
}

/* Pictures of forward and combined lighting are the same bits, or not. */
static void balls_assert(balls *b, const char *what, bool same)
{
	stilb_image forward = balls_picture(b, STILB_RENDER_LIGHTING_FORWARD);
	stilb_image combined = balls_picture(b, STILB_RENDER_LIGHTING_COMBINED);
	if (b->view.light_count > 2 && lit_share(&forward) < 0.05)
		fail_msg("%s: %.3f of the pixels are lit", what, lit_share(&forward));
	if (same_bits(&forward, &combined) != same)
		fail_msg("%s: pictures %s", what, same ? "differ" : "are the same");
	stilb_image_finish(&forward);
	stilb_image_finish(&combined);
}

/* The most lights whose spheres touch a model's. */
static uint32_t most_reaching(const balls *b)
{
	uint32_t most = 0;
	const stilb_scene_bounds *models = &b->scene->bounds;
	for (uint32_t m = 0; m < b->scene->model_count; m++) {
		uint32_t count = 0;
		for (uint32_t l = 0; l < b->view.light_count; l++) {
			stilb_sphere s = stilb_light_bounds_of(&b->lights[l]).sphere;
			double x = (double)s.x - (double)models->x[m], y = (double)s.y - (double)models->y[m];
			double z = (double)s.z - (double)models->z[m], r = (double)s.radius + (double)models->radius[m];
			count += x * x + y * y + z * z <= r * r * 1.001;
		}
		most = count > most ? count : most;
	}
	return most;
}

static void balls_grow(balls *b, float factor)
{
	for (uint32_t l = 0; l < b->view.light_count; l++) {
		b->lights[l].reach *= factor;
		assert_null(stilb_scene_light_mistake(&b->lights[l]));
	}
}

/* Lamps of several kinds, so far from each other that at most four touch a model. */
static void balls_four(balls *b)
{
	b->view.light_count = 16;
	for (uint32_t l = 0; l < 16; l++) {
		stilb_scene_light light = {.kind = l % 3 == 0   ? STILB_SCENE_LIGHT_POINT
		                                   : l % 3 == 1 ? STILB_SCENE_LIGHT_SPHERE
		                                                : STILB_SCENE_LIGHT_SPOT,
		                           .position = {4.0f * (float)(l % 4) - 6.3f, 1.4f, 4.0f * (float)(l / 4) - 5.6f},
		                           .direction = {0.0f, -1.0f, 0.0f},
		                           .intensity = {2.0f + (float)(l % 5), 3.0f, 1.0f + (float)(l % 2)},
		                           .cos_inner = 0.7f,
		                           .cos_outer = 0.3f,
		                           .radius = 0.1f,
		                           .falloff = STILB_SCENE_LIGHT_WINDOWED,
		                           .reach = 2.4f};
		b->lights[l] = light;
	}
	uint32_t most = most_reaching(b);
	if (most < 3 || most > 4)
		fail_msg("%u lamps touch a model", most);
}

/* ---- four lights or fewer ---------------------------------------------------------------------------------------- */

/* A sun and lamps of every kind, in the scene's order not the brightest first; then many lamps of which few reach a
 * model; then more than four. */
static void four_lights_are_all_of_them(void **state)
{
	(void)state;
	balls b = balls_open(64, 7, 60, 1);
	b.view.shading.brdf = SHADE_BRDF_MICROFACET;
	balls_four(&b);
	balls_assert(&b, "lamps of small reach", true);
	for (uint32_t m = 0; m < 64; m += 3) { /* models that move have rows of the frame */
		stilb_mat4 place = b.scene->part_transform[b.scene->first_part[m]];
		place.m[12] += 0.3f;
		assert_int_equal(stilb_scene_set_transform(b.scene, m, &place), STILB_OK);
	}
	balls_four(&b);
	balls_assert(&b, "models that move", true);
	b.scene->moved_count = 0;
	balls_grow(&b, 2.5f);
	balls_assert(&b, "lamps of large reach", false);
	memmove(b.lights, b.lights + 9, 4 * sizeof *b.lights);
	b.view.light_count = 4;
	b.lights[2] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.6f, -0.8f, 0.0f}, .intensity = {0.1f, 0.1f, 0.2f}};
	b.lights[3].falloff = STILB_SCENE_LIGHT_PHYSICAL;
	for (uint32_t count = 0; count <= 4; count++) {
		b.view.light_count = count;
		/* The frame before had more lights, and lights come and go over sixteen frames. */
		for (int i = 0; i < 16; i++) {
			stilb_image image = balls_picture(&b, STILB_RENDER_LIGHTING_COMBINED);
			stilb_image_finish(&image);
		}
		balls_assert(&b, "four lights or fewer", true);
	}
	balls_close(&b);
}

static stilb_scene_light lamp_at(float x, float y, float z, float brightness)
{
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_POINT,
	                           .position = {x, y, z},
	                           .intensity = {brightness, 0.8f * brightness, 0.6f * brightness}};
	assert_null(stilb_scene_light_mistake(&light));
	return light;
}

static void surfaces_of_every_kind(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.width = 48}, 1);
	squares_show(&s, SHEEN);
	stilb_scene_light lamps[10]; /* the first four send the most to every square */
	for (int i = 0; i < 10; i++)
		lamps[i] = i < 4 ? lamp_at(0.6f * (float)(i % 2) - 0.3f, 1.5f, 0.6f * (float)(i / 2) - 0.3f, 5.0f)
		                 : lamp_at(0.6f * (float)(i % 3) - 0.6f, 1.5f, 0.5f * (float)(i / 6) - 0.3f, 1.0f);
	uint32_t ids[SQUARES];
	for (uint32_t k = 0; k < SQUARES; k++)
		ids[k] = k;
	s.view.lights = lamps;
	s.view.shading = stilb_render_shading_default();
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	stilb_image pictures[2][2]; /* with four lights and with ten; forward and combined */
	for (int many = 0; many < 2; many++)
		for (int way = 0; way < 2; way++) {
			s.view.light_count = many ? 10 : 4;
			pictures[many][way] = frame_of(s.render, s.scene, ids, &s.view, s.pool,
			                               way ? STILB_RENDER_LIGHTING_COMBINED : STILB_RENDER_LIGHTING_FORWARD);
		}
	if (!same_bits(&pictures[0][0], &pictures[0][1]))
		fail_msg("surfaces: pictures differ");
	for (int k = 0; k < SQUARES; k++) { /* a pixel in the middle of each: brighter than by its four, not as by ten */
		uint32_t x = (uint32_t)(24.0f + 14.4f * (float)(k % 3 - 1)), y = (uint32_t)(24.0f + 14.4f * (float)(k / 3 - 1));
		double own = picture_value(&pictures[0][0], x, y, 1), got = picture_value(&pictures[1][1], x, y, 1);
		double want = picture_value(&pictures[1][0], x, y, 1);
		if (k == UNLIT ? got != want : !(got > 1.02 * own && got < 1.02 * want && got != want))
			fail_msg("surface %d: %.5f, by its four %.5f, forward %.5f", k, got, own, want);
	}
	for (int i = 0; i < 4; i++)
		stilb_image_finish(&pictures[i / 2][i % 2]);
	stage_close(&s);
}

/* Impostors have the lights of their models, and meshes that are drawn by hand have all. */
static void impostors_and_draws_by_hand(void **state)
{
	(void)state;
	balls b = balls_open(64, 7, 60, 1);
	stilb_geometry_impostor_desc desc = {.grid = 3, .side = 96, .samples = 1};
	for (uint32_t m = 0; m < b.scene->model_count; m++) {
		stilb_scene_impostor baked;
		uint32_t id;
		assert_int_equal(stilb_geometry_impostor_of_model(b.scene, m, &desc, b.pool, 0, &baked), STILB_OK);
		assert_int_equal(stilb_scene_add_impostor(b.scene, &baked, &id), STILB_OK);
		assert_int_equal(stilb_scene_set_impostor(b.scene, m, id + 1), STILB_OK);
	}
	assert_int_equal(stilb_render_set_scene(b.render, b.scene), STILB_OK);
	b.view.impostors = true;
	b.view.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 100.0f};
	balls_four(&b);
	balls_assert(&b, "impostors", true);
	balls_grow(&b, 2.5f);
	balls_assert(&b, "impostors under more lamps", false);
	b.view.detail.mode = STILB_RENDER_DETAIL_OFF;
	stilb_image pictures[2];
	for (int way = 0; way < 2; way++) {
		stilb_render_pass pass = {.name = "main"};
		b.view.lighting = way ? STILB_RENDER_LIGHTING_COMBINED : STILB_RENDER_LIGHTING_FORWARD;
		assert_int_equal(stilb_render_frame_begin(b.render), STILB_OK);
		assert_int_equal(stilb_render_record(b.render, 0, b.scene, b.ids, 64, b.pool, 0), STILB_OK);
		if (stilb_render_replay(b.render, &pass, 1, &b.view, 1, b.pool, 0) != STILB_OK ||
		    stilb_render_read_image(b.render, &pictures[way]) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	if (!same_bits(&pictures[0], &pictures[1]))
		fail_msg("recorded without a view: pictures differ");
	stilb_image_finish(&pictures[0]);
	stilb_image_finish(&pictures[1]);
	balls_close(&b);
}

/* ---- more lights ------------------------------------------------------------------------------------------------- */

/* How far a picture is off: the root of the mean square and the worst, as shares of those of the forward picture. */
static void pictures_off(const stilb_image *forward, const stilb_image *combined, double *rms, double *worst)
{
	double squares = 0.0, all = 0.0, largest = 0.0, most = 0.0;
	for (uint32_t y = 0; y < forward->height; y++)
		for (uint32_t x = 0; x < forward->width; x++)
			for (int c = 0; c < 3; c++) {
				double want = picture_value(forward, x, y, c), off = fabs(picture_value(combined, x, y, c) - want);
				squares += off * off;
				all += want * want;
				largest = fmax(largest, want);
				most = fmax(most, off);
			}
	*rms = sqrt(squares / all);
	*worst = most / largest;
}

static void balls_off(balls *b, double *rms, double *worst)
{
	b->view.shading.brdf = SHADE_BRDF_LAMBERT;
	stilb_image forward = balls_picture(b, STILB_RENDER_LIGHTING_FORWARD);
	stilb_image combined = balls_picture(b, STILB_RENDER_LIGHTING_COMBINED);
	pictures_off(&forward, &combined, rms, worst);
	stilb_image_finish(&forward);
	stilb_image_finish(&combined);
}

/* Tiles two metres wide, of which each lamp near them lights a spot: the worst case of a sum as seen from one point.
 * Nothing was chosen by the second scene. */
static void matt_scenes(void **state)
{
	(void)state;
	static const struct {
		uint32_t models, lamps;
		uint64_t seed;
		double rms, worst;
	} scenes[] = {{64, 60, 7, 0.22, 0.105}, {144, 150, 11, 0.041, 0.014}};
	for (int i = 0; i < 2; i++) {
		double rms, worst;
		balls b = balls_open(scenes[i].models, scenes[i].seed, scenes[i].lamps, 1);
		balls_off(&b, &rms, &worst);
		print_message("%u balls, %u lamps: RMS %.4f, worst %.4f\n", scenes[i].models, scenes[i].lamps, rms, worst);
		assert_true(rms <= scenes[i].rms && worst <= scenes[i].worst);
		balls_close(&b);
	}
}

/* A floor of two triangles under eighteen lamps, and cut into pieces at their bounds: by how much it is off, and what
 * the cuts add. The forward pictures of both are the same but for rounding: no piece is missing, and none overlap. */
static void a_floor_that_is_cut(void **state)
{
	(void)state;
	enum { LAMPS = 18, SIDE = 96 };
	stage s = stage_open((stilb_render_desc){.width = SIDE}, 1);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface white = surface_matt();
	stilb_scene_light lamps[LAMPS];
	stilb_sphere spheres[LAMPS];
	for (uint32_t l = 0; l < LAMPS; l++) {
		lamps[l] = lamp_at(2.0f * stilb_random_float(3, 2 * l) - 1.0f, 0.15f,
		                   2.0f * stilb_random_float(3, 2 * l + 1) - 1.0f, 0.05f);
		lamps[l].falloff = STILB_SCENE_LIGHT_WINDOWED;
		lamps[l].reach = 0.5f;
		spheres[l] = stilb_light_bounds_of(&lamps[l]).sphere;
	}
	stilb_image forward[2];
	double rms[2], worst[2];
	for (int few = 0; few < 2; few++) {
		stilb_geometry_lights_desc desc = {
			.lights = spheres, .light_count = LAMPS, .enough = few ? RENDER_COMBINED_OWN : LAMPS, .least = 0.05f};
		stilb_geometry_pieces pieces;
		assert_int_equal(stilb_geometry_cut_at_lights(&q.mesh, &desc, &pieces), STILB_OK);
		print_message("%u triangles, %u draws, at most %u lights: ", pieces.triangles, pieces.count, pieces.most);
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_mat4 here = stilb_mat4_identity();
		uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here);
		stilb_geometry_build_pieces(build, node, stage_material(build, &white), &pieces);
		stage_show(&s, build);
		memset(&s.view.surroundings, 0, sizeof s.view.surroundings);
		s.view.shading = stilb_render_shading_default();
		s.view.shading.brdf = SHADE_BRDF_LAMBERT;
		s.view.lights = lamps;
		s.view.light_count = LAMPS;
		uint32_t *ids = calloc(s.scene->model_count, sizeof *ids);
		assert_non_null(ids);
		for (uint32_t m = 0; m < s.scene->model_count; m++)
			ids[m] = m;
		forward[few] = frame_of(s.render, s.scene, ids, &s.view, s.pool, STILB_RENDER_LIGHTING_FORWARD);
		stilb_image combined = frame_of(s.render, s.scene, ids, &s.view, s.pool, STILB_RENDER_LIGHTING_COMBINED);
		pictures_off(&forward[few], &combined, &rms[few], &worst[few]);
		print_message("RMS %.4f, worst %.4f\n", rms[few], worst[few]);
		stilb_image_finish(&combined);
		stilb_geometry_pieces_finish(&pieces);
		free(ids);
	}
	double same, most;
	pictures_off(&forward[0], &forward[1], &same, &most);
	assert_true(most < 2e-3);
	assert_true(rms[1] < 0.2 * rms[0] && worst[1] < 0.5 * worst[0]);
	stilb_image_finish(&forward[0]);
	stilb_image_finish(&forward[1]);
	stage_close(&s);
}

/* ---- crossing ---------------------------------------------------------------------------------------------------- */

#define CROSSING_LAMPS 6
#define CROSSING_FRAMES 110

/* What a lamp adds to the square (matt white) as part of the sum. */
static double crossing_in_sum(const stilb_scene_light *light, int channel)
{
	shade_sun seen = shade_light_at(scene_light_shade(light), stilb_vec3_make(0.0f, 0.0f, 0.0f));
	shade_sh sh =
		shade_sh_window(shade_sh_directional(seen.direction, seen.irradiance[channel]), SHADE_SH_WINDOW_IRRADIANCE);
	return (double)shade_sh_irradiance(sh, stilb_vec3_make(0.0f, 1.0f, 0.0f)) / REFERENCE_PI;
}

typedef struct crossing {
	stage s;
	stilb_scene_light lamps[CROSSING_LAMPS];
	stilb_image alone[CROSSING_LAMPS]; /* the square under each lamp alone, by forward lighting */
	int shares[CROSSING_LAMPS];        /* sixteenths of its own shape, which each lamp should have */
	bool begun;
} crossing;

/* Of a frame. */
typedef struct crossing_frame {
	stilb_image image, flying; /* the square under all lamps, and under the one that flies */
	double in_sum[3];          /* that one's form in the sum */
	int shares[CROSSING_LAMPS];
} crossing_frame;

static stilb_image crossing_picture(crossing *c, stilb_render_lighting lighting)
{
	return frame_of(c->s.render, c->s.scene, (const uint32_t[1]){0}, &c->s.view, c->s.pool, lighting);
}

static stilb_image crossing_alone(crossing *c, int lamp)
{
	c->s.view.lights = &c->lamps[lamp];
	c->s.view.light_count = 1;
	stilb_image image = crossing_picture(c, STILB_RENDER_LIGHTING_FORWARD);
	c->s.view.lights = c->lamps;
	c->s.view.light_count = CROSSING_LAMPS;
	return image;
}

/* Which lamps are wanted: the four that send the most, where an eighth is added for those that have shares. */
static void crossing_wanted(const crossing *c, bool wanted[CROSSING_LAMPS])
{
	double weights[CROSSING_LAMPS];
	for (int l = 0; l < CROSSING_LAMPS; l++) {
		shade_sun seen = shade_light_at(scene_light_shade(&c->lamps[l]), stilb_vec3_make(0.0f, 0.0f, 0.0f));
		weights[l] = (double)shade_luminance(seen.irradiance) * (c->shares[l] > 0 ? 1.125 : 1.0);
	}
	for (int l = 0; l < CROSSING_LAMPS; l++) {
		int before = 0;
		for (int o = 0; o < CROSSING_LAMPS; o++)
			before += weights[o] > weights[l];
		wanted[l] = before < 4;
	}
}

/* The shares of the next frame. */
static void crossing_step(crossing *c)
{
	bool wanted[CROSSING_LAMPS];
	int used = 0;
	crossing_wanted(c, wanted);
	for (int l = 0; l < CROSSING_LAMPS; l++) {
		if (!c->begun)
			c->shares[l] = wanted[l] ? 16 : 0;
		else if (c->shares[l] > 0)
			c->shares[l] += !wanted[l] ? -1 : c->shares[l] < 16;
		used += c->shares[l] > 0;
	}
	for (int l = 0; l < CROSSING_LAMPS && used < 4; l++)
		if (c->shares[l] == 0 && wanted[l]) {
			c->shares[l] = 1;
			used++;
		}
	c->begun = true;
}

/* The picture is what the shares make of it; and since the frame before it has changed by no more than a sixteenth of
 * what the two forms of a lamp that crosses are apart, and what the flight has changed in one of the lamp's. */
static void crossing_assert(const crossing *c, const crossing_frame *before, const crossing_frame *now, int number)
{
	for (uint32_t y = 0; y < STAGE_SIDE; y += 3)
		for (uint32_t x = 0; x < STAGE_SIDE; x += 3)
			for (int k = 0; k < 3; k++) {
				double want = 0.0, crosses = 0.0, got = picture_value(&now->image, x, y, k);
				for (int l = 0; l < CROSSING_LAMPS; l++) {
					double own = picture_value(&c->alone[l], x, y, k), sum = crossing_in_sum(&c->lamps[l], k);
					want += (now->shares[l] * own + (16 - now->shares[l]) * sum) / 16.0;
					crosses += before && now->shares[l] != before->shares[l] ? fabs(own - sum) / 16.0 : 0.0;
				}
				if (!(fabs(got - want) <= 1e-3 * want)) /* half floats: seven of 2^-12 */
					fail_msg("frame %d, pixel %u, %u: %.6f, not %.6f", number, x, y, got, want);
				if (!before)
					continue;
				double own = picture_value(&now->flying, x, y, k) - picture_value(&before->flying, x, y, k);
				double flown = fmax(fabs(own), fabs(now->in_sum[k] - before->in_sum[k]));
				double change = fabs(got - picture_value(&before->image, x, y, k));
				if (!(change <= crosses + flown + 1e-3 * want))
					fail_msg("frame %d, pixel %u, %u changes by %.6f, not %.6f", number, x, y, change, crosses + flown);
			}
}

static crossing crossing_open(void)
{
	crossing c = {.s = stage_open((stilb_render_desc){.width = STAGE_SIDE}, 1)};
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface white = surface_matt();
	memcpy(white.color, (float[4]){1.0f, 1.0f, 1.0f, 1.0f}, sizeof white.color);
	stilb_scene_build *build = stilb_scene_build_begin();
	stage_model(build, stilb_scene_build_mesh(build, &q.mesh), stage_material(build, &white), stilb_mat4_identity());
	stage_show(&c.s, build);
	memset(&c.s.view.surroundings, 0, sizeof c.s.view.surroundings);
	c.s.view.shading = stilb_render_shading_default();
	c.s.view.shading.brdf = SHADE_BRDF_LAMBERT;
	for (int l = 0; l < 5; l++) {
		c.lamps[l] = lamp_at(1.5f - 0.6f * (float)l, 1.2f, 0.5f * (float)(l % 3) - 0.5f, 5.0f - 0.5f * (float)l);
		c.alone[l] = crossing_alone(&c, l);
	}
	return c;
}

/* A lamp flies past a square that has five others. In the frame in which it sends an eighth more to the middle than the
 * fourth of them, that one begins to leave, a sixteenth a frame; then this one comes likewise. When it has passed, they
 * cross again. */
static void a_lamp_flies_past(void **state)
{
	(void)state;
	crossing c = crossing_open();
	crossing_frame frames[2] = {0};
	int changes = 0;
	for (int number = 0; number < CROSSING_FRAMES; number++) {
		crossing_frame *now = &frames[number % 2], *before = number > 0 ? &frames[(number + 1) % 2] : NULL;
		stilb_image_finish(&now->image);
		stilb_image_finish(&now->flying);
		c.lamps[5] = lamp_at(-4.0f + 0.1f * (float)number, 1.0f, 0.2f, 4.0f);
		crossing_step(&c);
		now->flying = crossing_alone(&c, 5);
		now->image = crossing_picture(&c, STILB_RENDER_LIGHTING_COMBINED);
		c.alone[5] = now->flying;
		memcpy(now->shares, c.shares, sizeof now->shares);
		for (int k = 0; k < 3; k++)
			now->in_sum[k] = crossing_in_sum(&c.lamps[5], k);
		crossing_assert(&c, before, now, number);
		for (int l = 0; before && l < CROSSING_LAMPS; l++)
			changes += now->shares[l] != before->shares[l];
	}
	if (changes < 50) /* one lamp out, one in, and back */
		fail_msg("%d changes of a share", changes);
	for (int i = 0; i < 2; i++) {
		stilb_image_finish(&frames[i].image);
		stilb_image_finish(&frames[i].flying);
	}
	for (int l = 0; l < 5; l++)
		stilb_image_finish(&c.alone[l]);
	stage_close(&c.s);
}

/* ---- workers ----------------------------------------------------------------------------------------------------- */

static void any_number_of_workers(void **state)
{
	(void)state;
	stilb_image first = {0};
	for (uint32_t workers = 0; workers < 4; workers += 3) {
		balls b = balls_open(400, 3, 200, workers);
		stilb_image image = {0};
		for (int frame = 0; frame < 6; frame++) {
			for (uint32_t l = 0; l < b.view.light_count; l++)
				b.lights[l].position[0] += 0.3f;
			stilb_image_finish(&image);
			image = balls_picture(&b, STILB_RENDER_LIGHTING_COMBINED);
		}
		if (workers == 0)
			first = image;
		else if (!same_bits(&first, &image))
			fail_msg("%u workers: pictures differ", workers);
		if (workers > 0)
			stilb_image_finish(&image);
		balls_close(&b);
	}
	stilb_image_finish(&first);
}

/* A panorama with two small suns, which are lamps of the list, beside two lamps of the scene: four lights in all,
 * whatever the surroundings are taken for; of NONE two. */
static void lamps_of_a_panorama(void **state)
{
	(void)state;
	balls b = balls_open(16, 5, 2, 1);
	stilb_image panorama;
	assert_int_equal(stilb_image_create(&panorama, 256, 128, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *texels = panorama.pixels;
	for (uint32_t i = 0; i < 256 * 128 * 3; i++)
		texels[i] = 0.05f;
	for (int c = 0; c < 3; c++) {
		texels[3 * (256 * 30 + 40) + c] = 4000.0f;
		texels[3 * (256 * 40 + 170) + c] = 3000.0f - 900.0f * (float)c;
	}
	b.view.surroundings.panorama = panorama;
	b.lights[0].falloff = b.lights[1].falloff = STILB_SCENE_LIGHT_PHYSICAL;
	/* NONE first: later there are other frames' lights behind its own. */
	for (int i = 0; i < STILB_RENDER_AMBIENT_KINDS; i++) {
		b.view.ambient = (stilb_render_ambient)((STILB_RENDER_AMBIENT_NONE + i) % STILB_RENDER_AMBIENT_KINDS);
		balls_assert(&b, stilb_render_ambient_names[b.view.ambient], true);
	}
	balls_close(&b);
	stilb_image_finish(&panorama);
}

static uint32_t nearest_model(const balls *b, const float at[3])
{
	const stilb_scene_bounds *models = &b->scene->bounds;
	uint32_t nearest = 0;
	float least = INFINITY;
	for (uint32_t m = 0; m < b->scene->model_count; m++) {
		float away = hypotf(models->x[m] - at[0], models->z[m] - at[2]);
		nearest = away < least ? m : nearest;
		least = fminf(least, away);
	}
	return nearest;
}

/* Lights that fade: those that are gone reach nothing, and the others send what they do in the other ways. */
static void lights_that_fade(void **state)
{
	(void)state;
	balls b = balls_open(64, 7, 60, 1);
	balls_four(&b);
	b.view.light_count = 60;
	for (uint32_t l = 16; l < 60; l++) { /* more than four at a model, but small ones, which are gone */
		b.lights[l] = b.lights[12 + l % 4];
		b.lights[l].kind = STILB_SCENE_LIGHT_POINT;
		b.lights[l].reach = 0.6f;
		uint32_t m = nearest_model(&b, b.lights[l].position);
		b.lights[l].position[0] = b.scene->bounds.x[m];
		b.lights[l].position[1] = b.scene->bounds.y[m] + 0.2f;
		b.lights[l].position[2] = b.scene->bounds.z[m];
	}
	balls_assert(&b, "whole", false);
	stilb_image whole = balls_picture(&b, STILB_RENDER_LIGHTING_COMBINED);
	b.view.light_fade = 8.0f;
	for (int frame = 0; frame < 40; frame++) { /* until those that had a place have crossed over */
		stilb_image image = balls_picture(&b, STILB_RENDER_LIGHTING_COMBINED);
		stilb_image_finish(&image);
	}
	balls_assert(&b, "fading", true);
	stilb_image faded = balls_picture(&b, STILB_RENDER_LIGHTING_COMBINED);
	stilb_render_stats stats = stilb_render_stats_get(b.render);
	printf("%.0f lights, %.0f fade, %.0f are gone\n", (double)stats.lights, (double)stats.light_faded,
	       (double)stats.light_gone);
	assert_true(stats.light_gone > 44 && stats.light_faded > stats.light_gone && stats.light_faded < stats.lights);
	assert_false(same_bits(&whole, &faded));
	stilb_image_finish(&whole);
	stilb_image_finish(&faded);
	balls_close(&b);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(lamps_of_a_panorama),
		cmocka_unit_test(four_lights_are_all_of_them),
		cmocka_unit_test(surfaces_of_every_kind),
		cmocka_unit_test(impostors_and_draws_by_hand),
		cmocka_unit_test(matt_scenes),
		cmocka_unit_test(a_floor_that_is_cut),
		cmocka_unit_test(a_lamp_flies_past),
		cmocka_unit_test(lights_that_fade),
		cmocka_unit_test(any_number_of_workers),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
