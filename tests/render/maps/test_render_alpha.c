/* Surfaces with masks and surfaces that blend, against closed forms: which pixels are there, also where depth alone is
 * drawn; what lies over what, whatever the order of the models; with several samples a pixel; under the validation
 * layer. */
#include "render/maps/maps_stage.h"

#define HALF 1e-3

/* ---- masks ------------------------------------------------------------------------------------------------------- */

/* Columns whose alpha is 0, 1/3, 2/3 and 1; green. */
static stilb_image stripes(void)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 4, 1, 4, STILB_IMAGE_U8_LINEAR), STILB_OK);
	for (uint32_t x = 0; x < 4; x++) {
		uint8_t *texel = (uint8_t *)image.pixels + 4 * (size_t)x;
		texel[0] = texel[2] = 0;
		texel[1] = 255;
		texel[3] = (uint8_t)(85 * x);
	}
	return image;
}

static stilb_scene_surface striped(stilb_scene_alpha alpha)
{
	stilb_scene_surface surface = surface_unlit();
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
	surface.alpha = alpha;
	return surface;
}

/* Which columns are there by cutoff, factor and the vertices' alpha. */
static void masks_cut(void **state)
{
	(void)state;
	static const struct {
		float cutoff, factor, vertex;
		uint32_t first; /* column that is there */
	} cases[] = {{0.5f, 1, 1, 2}, {0.0f, 1, 1, 0},    {0.3f, 1, 1, 1},   {0.9f, 1, 1, 3},
	             {1.1f, 1, 1, 4}, {0.5f, 0.6f, 1, 3}, {0.5f, 1, 0.6f, 3}};
	for (int extras = 0; extras < 2; extras++) {
		stage s = stage_open((stilb_render_desc){0}, 0);
		s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
		s.view.backdrop.color[0] = 0.25f;
		stilb_image image = stripes();
		square q;
		square_make(&q, 1.0f);
		for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
			if (!extras && cases[i].vertex != 1.0f)
				continue;
			for (int v = 0; v < 4; v++)
				q.extras[v].color[3] = cases[i].vertex;
			q.mesh.extras = extras ? q.extras : NULL;
			stilb_scene_surface surface = striped(STILB_SCENE_MASK);
			surface.cutoff = cases[i].cutoff;
			surface.color[3] = cases[i].factor;
			stage_show_square(&s, &q, &surface, &image, 1);
			stilb_image picture = stage_picture(&s);
			for (uint32_t x = 0; x < STAGE_SIDE; x++) {
				bool there = x * 4 / STAGE_SIDE >= cases[i].first;
				assert_near("red behind", picture_value(&picture, x, 9, 0), there ? 0.0 : 0.25, HALF);
				assert_near("green", picture_value(&picture, x, 9, 1), there ? 1.0 : 0.0, HALF);
			}
			stilb_image_finish(&picture);
		}
		stilb_image_finish(&image);
		stage_close(&s);
	}
}

/* Where depth alone is drawn masks are cut, too, and what blends is not there. */
static void depth_alone(void **state)
{
	(void)state;
	stilb_image image = stripes();
	for (int kind = 0; kind < 4; kind++) {
		bool extras = kind & 1, blends = kind & 2;
		stage s = stage_open((stilb_render_desc){0}, 0);
		square q;
		square_make(&q, 1.0f);
		q.mesh.extras = extras ? q.extras : NULL;
		stilb_render_target target = {.name = "shadow",
		                              .kind = STILB_RENDER_TARGET_DEPTH,
		                              .width = STAGE_SIDE,
		                              .height = STAGE_SIDE,
		                              .output = true};
		s.view.target = &target;
		stilb_scene_surface surface = striped(blends ? STILB_SCENE_BLEND : STILB_SCENE_MASK);
		stage_show_square(&s, &q, &surface, &image, 1);
		stage_frame(&s);
		stilb_gpu *gpu = stilb_render_gpu(s.render);
		const stilb_gpu_plan *plan = stilb_render_plan(s.render);
		uint64_t ticket, frame;
		const void *bytes;
		assert_int_equal(stilb_gpu_read_begin(gpu, plan, stilb_gpu_plan_find(plan, "shadow"), 0, 0, &ticket), STILB_OK);
		assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
		const float *depths = bytes;
		for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
			bool there = !blends && i % STAGE_SIDE * 4 / STAGE_SIDE >= 2;
			assert_near("a depth", (double)depths[i], there ? 0.05 / 4.0 : 0.0, 1e-6);
		}
		stilb_gpu_read_end(gpu, ticket);
		stage_close(&s);
	}
	stilb_image_finish(&image);
}

/* With four samples an edge of a mask is as soft as one of a triangle: alpha rises over the whole square, and where it
 * passes the cutoff the pixel is partly covered. */
static void masks_with_samples(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.samples = 4}, 0);
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	square q;
	square_make(&q, 1.0f);
	/* Alpha rises by 1/24 a pixel: at pixel 7 it passes from 7/24 to 8/24, and three samples of four are there. The
	 * mean of samples weighs each by 1 / (1 + its largest channel): 3/2 of 5/2. */
	for (int v = 0; v < 4; v++)
		q.extras[v].color[3] = q.vertices[v].uv[0];
	stilb_scene_surface surface = surface_unlit();
	surface.alpha = STILB_SCENE_MASK;
	surface.cutoff = 7.25f / 24.0f;
	stage_show_square(&s, &q, &surface, NULL, 0);
	stilb_image picture = stage_picture(&s);
	for (uint32_t x = 0; x < STAGE_SIDE; x++)
		assert_near("a covered share", picture_value(&picture, x, 11, 0), x < 7 ? 0.0 : x > 7 ? 1.0 : 0.6, HALF);
	stilb_image_finish(&picture);
	stage_close(&s);
}

/* ---- blending ---------------------------------------------------------------------------------------------------- */

#define LAYERS 4u

typedef struct layer {
	float height, color[3], alpha;
} layer;

static const layer layers[LAYERS] = {{0.0f, {0.5f, 0.5f, 0.5f}, 1.0f}, /* opaque */
                                     {0.1f, {1, 0, 0}, 0.5f},
                                     {0.2f, {0, 1, 0}, 0.25f},
                                     {0.3f, {0, 0, 1}, 0.75f}};

/* Squares above one another, as models in this order; those below layer `lowest` are left out. */
static void show_layers(stage *s, const uint32_t order[LAYERS], uint32_t lowest)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	square q;
	square_make(&q, 1.0f);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), materials[LAYERS];
	for (uint32_t l = 0; l < LAYERS; l++) {
		stilb_scene_surface surface = surface_unlit();
		memcpy(surface.color, layers[l].color, sizeof layers[l].color);
		surface.color[3] = layers[l].alpha;
		surface.alpha = layers[l].alpha < 1.0f ? STILB_SCENE_BLEND : STILB_SCENE_OPAQUE;
		materials[l] = stage_material(build, &surface);
	}
	for (uint32_t l = 0; l < LAYERS; l++) {
		const layer *at = &layers[order[l]];
		if (order[l] >= lowest)
			stage_model(build, mesh, materials[order[l]], stilb_mat4_scale_translate(1.2f, 0.0f, at->height, 0.0f));
	}
	stage_show(s, build);
}

/* Lays a layer's light over what lies behind it. */
static void layer_over(const layer *at, double light[3])
{
	for (int c = 0; c < 3; c++)
		light[c] += (double)at->alpha * ((double)at->color[c] - light[c]);
}

static void layers_lie_over_one_another(void **state)
{
	(void)state;
	static const uint32_t orders[][LAYERS] = {{0, 1, 2, 3}, {3, 2, 1, 0}, {2, 0, 3, 1}, {1, 3, 0, 2}};
	double want[3] = {0};
	for (uint32_t l = 0; l < LAYERS; l++)
		layer_over(&layers[l], want);
	for (uint32_t kind = 0; kind < 12; kind += TEST_ASAN ? 5 : 1) {
		stilb_render_desc desc = {.replay = (stilb_render_replay_mode)(kind % 3), .samples = kind < 6 ? 1 : 4};
		stage s = stage_open(desc, kind % 2);
		s.sort = kind == 5;
		for (size_t o = 0; o < sizeof orders / sizeof *orders; o++) {
			show_layers(&s, orders[o], 0);
			assert_shows(&s, want[0], want[1], want[2], 2e-3);
		}
		stage_close(&s);
	}
}

/* Of a parallel projection, too, and from below, where the order is the other way round. */
static void order_follows_the_view(void **state)
{
	(void)state;
	static const uint32_t order[LAYERS] = {2, 0, 3, 1};
	double above[3] = {0}, below[3] = {0};
	for (uint32_t l = 0; l < LAYERS; l++)
		layer_over(&layers[l], above);
	for (uint32_t l = LAYERS - 1; l > 0; l--)
		layer_over(&layers[l], below);
	stage s = stage_open((stilb_render_desc){0}, 0);
	show_layers(&s, order, 0);
	/* x to the right, z down, y from -1 (depth 0) to 1 (depth 1). */
	stilb_mat4 parallel = {.m = {1, 0, 0, 0, 0, 0, 0.5f, 0, 0, 1, 0, 0, 0, 0, 0.5f, 1}};
	s.view.view_projection = parallel;
	assert_shows(&s, above[0], above[1], above[2], 2e-3);
	reference_camera camera =
		reference_camera_at((dvec){0, -4, 0}, (dvec){0, 0, 0}, (dvec){0, 0, -1}, 4.0, STAGE_SIDE, STAGE_SIDE);
	s.view.view_projection = reference_matrix(&camera);
	s.view.both_sides = true;
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	assert_shows(&s, 0.5, 0.5, 0.5, HALF); /* the opaque one is in front */
	show_layers(&s, order, 1);
	assert_shows(&s, below[0], below[1], below[2], 2e-3);
	stage_close(&s);
}

/* Two squares of meshes of their own, moved past one another by writing their vertices. */
static void order_follows_written_vertices(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	stilb_scene_build *build = stilb_scene_build_begin();
	square q[2];
	for (int l = 0; l < 2; l++) {
		stilb_scene_surface surface = surface_unlit();
		surface.color[l] = 0.0f;
		surface.color[3] = 0.5f;
		surface.alpha = STILB_SCENE_BLEND;
		square_make(&q[l], 1.0f);
		uint32_t mesh = stilb_scene_build_mesh(build, &q[l].mesh);
		stage_model(build, mesh, stage_material(build, &surface),
		            stilb_mat4_scale_translate(1.2f, 0.0f, 0.1f * (float)l, 0.0f));
	}
	stage_show(&s, build);
	assert_shows(&s, 0.5, 0.25, 0.75, HALF);
	for (int v = 0; v < 4; v++)
		q[0].vertices[v].position[1] = 0.25f;
	assert_int_equal(stilb_scene_set_vertices(s.scene, 0, 1, 3, q[0].vertices + 1), STILB_OK);
	assert_int_equal(stilb_scene_set_vertices(s.scene, 0, 0, 1, q[0].vertices), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	assert_int_equal(changes.vertices_count, 1);
	assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	stilb_scene_changes_clear(s.scene);
	assert_shows(&s, 0.25, 0.5, 0.75, HALF);
	stage_close(&s);
}

/* What is equally far follows the ids of materials, whatever the order of models. */
static void ids_break_ties(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	for (uint32_t swapped = 0; swapped < 2; swapped++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		square q;
		square_make(&q, 1.0f);
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), materials[2];
		for (int l = 0; l < 2; l++) {
			stilb_scene_surface surface = surface_unlit();
			surface.color[l] = 0.0f;
			surface.color[3] = 0.5f;
			surface.alpha = STILB_SCENE_BLEND;
			materials[l] = stage_material(build, &surface);
		}
		for (uint32_t l = 0; l < 2; l++)
			stage_model(build, mesh, materials[l ^ swapped], stilb_mat4_identity());
		stage_show(&s, build);
		assert_shows(&s, 0.5, 0.25, 0.75, HALF);
	}
	stage_close(&s);
}

/* Of two squares that go through one another the nearer middle comes last, in all pixels: neither writes depth. */
static void what_blends_hides_nothing(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	stilb_scene_build *build = stilb_scene_build_begin();
	square q;
	square_make(&q, 1.0f);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	stilb_mat4 places[2] = {stilb_mat4_scale_translate(1.5f, 0.0f, 0.1f, 0.0f),
	                        stilb_mat4_scale_translate(1.5f, 0.0f, 0.2f, 0.0f)};
	places[1].m[1] = 0.5f; /* y rises with x: at the left it is below the other one */
	for (int l = 1; l >= 0; l--) {
		stilb_scene_surface surface = surface_unlit();
		surface.color[l] = 0.0f;
		surface.color[3] = 0.5f;
		surface.alpha = STILB_SCENE_BLEND;
		stage_model(build, mesh, stage_material(build, &surface), places[l]);
	}
	stage_show(&s, build);
	assert_shows(&s, 0.5, 0.25, 0.75, HALF);
	stage_close(&s);
}

/* What blends is lit: the sky's light is there by alpha. */
static void what_blends_is_lit(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_matt();
	surface.alpha = STILB_SCENE_BLEND;
	surface.color[0] = 0.5f;
	surface.color[3] = 0.5f;
	reference_set3(surface.emission, 0.0f, 1.0f, 0.0f);
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, 0.25, 1.0, 0.5, HALF);
	stage_close(&s);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(masks_cut),
		cmocka_unit_test(depth_alone),
		cmocka_unit_test(masks_with_samples),
		cmocka_unit_test(layers_lie_over_one_another),
		cmocka_unit_test(order_follows_the_view),
		cmocka_unit_test(order_follows_written_vertices),
		cmocka_unit_test(ids_break_ties),
		cmocka_unit_test(what_blends_hides_nothing),
		cmocka_unit_test(what_blends_is_lit),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
