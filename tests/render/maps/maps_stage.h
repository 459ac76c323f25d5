/* What the tests of surfaces share: squares with extras that fill the picture, surfaces on them, and frames of such a
 * scene. */
#ifndef MAPS_STAGE_H
#define MAPS_STAGE_H

#include "render/render_internal.h"
#include "scene/scene_build.h"
#include "support/picture_reference.h"

#define STAGE_SIDE 24u /* pixels of the picture's side */

typedef struct stage {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_render_view view;
	bool sort;
} stage;

/* Looks straight down from 4 m; the square x, z in [-1, 1] at y = 0 fills the picture, -Z is up. A sky of radiance 1
 * and no other light: the radiance of a matt surface that faces up is its reflectance. */
static inline stage stage_open(stilb_render_desc desc, uint32_t workers)
{
	stage s = {0};
	desc.width = desc.width ? desc.width : STAGE_SIDE;
	desc.height = desc.width;
	desc.samples = desc.samples ? desc.samples : 1;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.context_count = workers + 1;
	desc.validate = desc.device == STILB_RENDER_DEVICE_VULKAN;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &s.pool), 0);
	reference_camera camera =
		reference_camera_at((dvec){0, 4, 0}, (dvec){0, 0, 0}, (dvec){0, 0, -1}, 4.0, desc.width, desc.width);
	s.view = (stilb_render_view){.view_projection = reference_matrix(&camera), .camera_position = {0.0f, 4.0f, 0.0f}};
	reference_set3(s.view.surroundings.sky, 1.0f, 1.0f, 1.0f);
	return s;
}

static inline void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_scene_destroy(s->scene);
	stilb_job_pool_destroy(s->pool);
}

/* The square x, z in [-1, 1] at y = 0, of 2 triangles, that faces up. uv runs from (0, 0) at the top left of the
 * picture to (1, 1); the second uv is what `second` makes of it, a scale. */
typedef struct square {
	stilb_scene_vertex vertices[4];
	stilb_scene_vertex_extra extras[4];
	uint32_t indices[6];
	stilb_scene_mesh mesh;
} square;

/* Do not copy it. */
static inline void square_make(square *q, float second)
{
	static const float corners[4][2] = {{-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	*q = (square){0};
	for (int v = 0; v < 4; v++) {
		float x = corners[v][0], z = corners[v][1];
		q->vertices[v] =
			(stilb_scene_vertex){.position = {x, 0, z}, .normal = {0, 1, 0}, .uv = {(x + 1) / 2, (z + 1) / 2}};
		q->extras[v] = (stilb_scene_vertex_extra){.tangent = {1, 0, 0, 1}, .color = {1, 1, 1, 1}};
		for (int c = 0; c < 2; c++)
			q->extras[v].uv[c] = second * q->vertices[v].uv[c];
	}
	memcpy(q->indices, indices, sizeof indices);
	q->mesh = (stilb_scene_mesh){
		.vertices = q->vertices, .extras = q->extras, .indices = q->indices, .vertex_count = 4, .index_count = 6};
}

/* A surface that shows its colour alone. */
static inline stilb_scene_surface surface_unlit(void)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.unlit = true;
	return surface;
}

/* A matt one without any highlight: under the sky it shows its colour, too. */
static inline stilb_scene_surface surface_matt(void)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.specular_weight = 0.0f;
	return surface;
}

/* Adds a material with the surface. */
static inline uint32_t stage_material(stilb_scene_build *build, const stilb_scene_surface *surface)
{
	static const float grey[3] = {0.25f, 0.25f, 0.25f}, none[3] = {0};
	stilb_scene_material material = stilb_scene_material_make(grey, none, 0.5f);
	material.surface = 1 + stilb_scene_build_surface(build, surface);
	return stilb_scene_build_material(build, &material);
}

/* Adds a model: the mesh with the material, placed. */
static inline void stage_model(stilb_scene_build *build, uint32_t mesh, uint32_t material, stilb_mat4 place)
{
	stilb_scene_build_part part = {mesh, material};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
}

/* Shows the scene that was built. */
static inline void stage_show(stage *s, stilb_scene_build *build)
{
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	if (stilb_render_set_scene(s->render, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_destroy(s->scene);
	s->scene = scene;
}

static inline void stage_frame(stage *s)
{
	stilb_render_pass pass = {.name = "main", .sort = s->sort};
	uint32_t ids[256];
	assert_true(s->scene->model_count <= 256);
	for (uint32_t m = 0; m < s->scene->model_count; m++)
		ids[m] = m;
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	stilb_result result =
		s->view.detail.mode != STILB_RENDER_DETAIL_OFF
			? stilb_render_record_view(s->render, 0, s->scene, ids, s->scene->model_count, &s->view, s->pool, 0)
			: stilb_render_record(s->render, 0, s->scene, ids, s->scene->model_count, s->pool, 0);
	if (result == STILB_OK)
		result = stilb_render_replay(s->render, &pass, 1, &s->view, 1, s->pool, 0);
	if (result != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* A frame's radiance; to be finished. */
static inline stilb_image stage_picture(stage *s)
{
	stilb_image image = {0};
	stage_frame(s);
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* One square over the whole picture with this surface. textures: [count], ids 0, 1, ... */
static inline void stage_show_square(stage *s, square *q, const stilb_scene_surface *surface,
                                     const stilb_image *textures, uint32_t count)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t t = 0; t < count; t++)
		stilb_scene_build_texture(build, &textures[t]);
	uint32_t mesh = stilb_scene_build_mesh(build, &q->mesh);
	stage_model(build, mesh, stage_material(build, surface), stilb_mat4_identity());
	stage_show(s, build);
}

static inline void assert_near(const char *what, double got, double want, double off)
{
	if (!(fabs(got - want) <= off))
		fail_msg("%s: %.6f, not %.6f", what, got, want);
}

/* All pixels are this, give or take `off`. */
static inline void assert_even(const stilb_image *image, double r, double g, double b, double off)
{
	const double want[3] = {r, g, b};
	for (uint32_t y = 0; y < image->height; y++)
		for (uint32_t x = 0; x < image->width; x++)
			for (int c = 0; c < 3; c++)
				if (!(fabs(picture_value(image, x, y, c) - want[c]) <= off))
					fail_msg("pixel %u, %u channel %d: %.6f, not %.6f", x, y, c, picture_value(image, x, y, c),
					         want[c]);
}

/* A frame shows this in all pixels. */
static inline void assert_shows(stage *s, double r, double g, double b, double off)
{
	stilb_image image = stage_picture(s);
	assert_even(&image, r, g, b, off);
	stilb_image_finish(&image);
}

/* A picture of data of one value. */
static inline stilb_image image_even(uint32_t channels, const uint8_t value[4], stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 2, 2, channels, format), STILB_OK);
	for (uint32_t i = 0; i < 4 * channels; i++)
		((uint8_t *)image.pixels)[i] = value[i % channels];
	return image;
}

#endif
