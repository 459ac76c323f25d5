/* Functions of surfaces on the device: each member that they may change and each that they are given, against closed
 * forms; masks, also where depth alone is drawn; parameters, time, two functions side by side, edits and removal; the
 * identity keeps the bits of every kind of surface in every mode; what is no such code is an error with a line; under
 * the validation layer. */
#include "render/maps/maps_stage.h"
#include "render/render_dump_format.h"
#include "scene/edit/scene_edit.h"
#include "shading/shade_impostor.h"

#include "identity.surface.h"
#include "probe.surface.h"

#include <stdio.h>

#define HALF 1e-3

/* ---- what a function changes and is given ------------------------------------------------------------------------ */

enum {
	PROBE_COLOR = 1,
	PROBE_ALPHA,
	PROBE_NORMAL,
	PROBE_EMISSION,
	PROBE_TIME,
	PROBE_POSITION,
	PROBE_UV,
	PROBE_LOCAL,
	PROBE_NAN,
	PROBE_VERTEX_COLOR,
	PROBE_REST,
	PROBE_PARAMETERS,
	PROBE_POINT_NORMAL,
	PROBE_SURFACE_NORMAL,
	PROBE_VIEWER,
};

/* The surface with the probe, which is function 0, and its second parameter. */
static stilb_scene_surface probed(stilb_scene_surface surface, int what, float x, float y, float z)
{
	surface.function = 1;
	surface.parameters[0][0] = (float)what;
	reference_set3(surface.parameters[1], x, y, z);
	return surface;
}

/* As stage_show_square, with functions. */
static void show_square(stage *s, square *q, const stilb_scene_surface *surface,
                        const stilb_scene_function *const *functions, uint32_t count, stilb_mat4 place)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t f = 0; f < count; f++)
		stilb_scene_build_function(build, functions[f]);
	uint32_t mesh = stilb_scene_build_mesh(build, &q->mesh);
	stage_model(build, mesh, stage_material(build, surface), place);
	stage_show(s, build);
}

static void show_probe(stage *s, square *q, const stilb_scene_surface *surface)
{
	const stilb_scene_function *functions[] = {&probe};
	show_square(s, q, surface, functions, 1, stilb_mat4_identity());
}

/* The place in the square of a pixel's middle: u, v in 0..1. */
static double place_of(uint32_t pixel)
{
	return (pixel + 0.5) / STAGE_SIDE;
}

static void functions_change_members(void **state)
{
	(void)state;
	for (int extras = 0; extras < 2; extras++) {
		stage s = stage_open((stilb_render_desc){.float_vertices = extras}, 0);
		square q;
		square_make(&q, 1.0f);
		q.mesh.extras = extras ? q.extras : NULL;
		stilb_scene_surface surface = probed(surface_unlit(), PROBE_COLOR, 0.25f, 0.5f, 0.75f);
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0.25, 0.5, 0.75, HALF);
		surface = probed(surface_unlit(), 0, 0, 0, 0);
		show_probe(&s, &q, &surface);
		assert_shows(&s, 1, 1, 1, HALF);
		surface = probed(surface_matt(), PROBE_EMISSION, 0.5f, 2.0f, -1.0f); /* below 0 counts as 0 */
		show_probe(&s, &q, &surface);
		assert_shows(&s, 1.5, 3, 1, 4 * HALF);
		/* The ground is black: of the sky a normal at 60 degrees sees (1 + cos) / 2. Its length does not count. */
		surface = probed(surface_matt(), PROBE_NORMAL, 0, 3 * 0.5f, -3 * 0.8660254f);
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0.75, 0.75, 0.75, HALF);
		surface = probed(surface_matt(), PROBE_REST, 0, 1, 0.25f); /* occlusion */
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0.25, 0.25, 0.25, HALF);
		surface =
			probed(surface_matt(), PROBE_REST, 1, 1, 1); /* a metal has no diffuse light, and the sky no highlight */
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0, 0, 0, HALF);
		surface = probed(surface_matt(), PROBE_NAN, 0, 7, 0); /* colour NaN, 7, -1 */
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0, 0, 0, HALF);
		surface.unlit = true;
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0, 1, 0, HALF);
		stage_close(&s);
	}
}

static void functions_are_given_places(void **state)
{
	(void)state;
	const stilb_scene_function *functions[] = {&probe};
	stilb_mat4 half = stilb_mat4_scale_translate(2.0f, 0.5f, 0.0f, 0.0f); /* x' = 2 x + 0.5 */
	for (int extras = 0; extras < 2; extras++) {
		stage s = stage_open((stilb_render_desc){0}, 0);
		square q;
		square_make(&q, 0.5f);
		for (int v = 0; v < 4; v++)
			q.extras[v].color[3] = 0.5f;
		q.mesh.extras = extras ? q.extras : NULL;
		for (int what = PROBE_POSITION; what <= PROBE_LOCAL; what++) {
			stilb_scene_surface surface = probed(surface_unlit(), what, 0, 0, 0);
			show_square(&s, &q, &surface, functions, 1, what == PROBE_LOCAL ? half : stilb_mat4_identity());
			stilb_image picture = stage_picture(&s);
			for (uint32_t y = 0; y < STAGE_SIDE; y += 3)
				for (uint32_t x = 0; x < STAGE_SIDE; x += 3) {
					double u = place_of(x), v = place_of(y), world[2] = {2 * u - 1, 2 * v - 1};
					double want[3] = {0.5 + 0.25 * world[0], 0.5, 0.5 + 0.25 * world[1]};
					if (what == PROBE_LOCAL) {
						want[0] = 0.5 + 0.25 * (world[0] - 0.5) / 2;
						want[2] = 0.5 + 0.25 * world[1] / 2;
					} else if (what == PROBE_UV) {
						want[0] = u;
						want[1] = v;
						want[2] = extras ? 0.5 * u : 0.0;
					}
					for (int c = 0; c < 3; c++)
						assert_near("a place", picture_value(&picture, x, y, c), want[c], 2e-3);
				}
			stilb_image_finish(&picture);
		}
		stilb_scene_surface surface = probed(surface_unlit(), PROBE_VERTEX_COLOR, 0, 0, 0);
		show_probe(&s, &q, &surface);
		double color = extras ? 0.5 : 1.0;
		assert_shows(&s, color, color, color, HALF);
		surface = probed(surface_unlit(), PROBE_POINT_NORMAL, 0, 0, 0);
		show_probe(&s, &q, &surface);
		assert_shows(&s, 0.5, 1, 0.5, HALF);
		stilb_image picture;
		surface = probed(surface_unlit(), PROBE_VIEWER, 0, 0, 0);
		show_probe(&s, &q, &surface);
		picture = stage_picture(&s);
		double x = 2 * place_of(2) - 1, z = 2 * place_of(20) - 1, length = sqrt(x * x + z * z + 16);
		assert_near("to the viewer", picture_value(&picture, 2, 20, 0), 0.5 - 0.5 * x / length, HALF);
		assert_near("to the viewer", picture_value(&picture, 2, 20, 1), 0.5 + 2 / length, HALF);
		assert_near("to the viewer", picture_value(&picture, 2, 20, 2), 0.5 - 0.5 * z / length, HALF);
		stilb_image_finish(&picture);
		stage_close(&s);
	}
}

/* The surface's normal has the map; the point's has not. */
static void functions_are_given_maps(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	uint8_t along[4] = {178, 128, 244, 255}; /* about (0.4, 0, 0.9): what it mirrors is above the square */
	stilb_image image = image_even(3, along, STILB_IMAGE_U8_LINEAR);
	square q;
	square_make(&q, 1.0f);
	for (int what = PROBE_POINT_NORMAL; what <= PROBE_SURFACE_NORMAL; what++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_texture(build, &image);
		stilb_scene_build_function(build, &probe);
		stilb_scene_surface surface = probed(surface_unlit(), what, 0, 0, 0);
		surface.unlit = false;
		surface.specular_weight = 0.0f;
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = 1;
		surface.occlusion = 0.0f;
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
		stage_model(build, mesh, stage_material(build, &surface), stilb_mat4_identity());
		stage_show(&s, build);
		s.view.show = STILB_RENDER_SHOW_BASE; /* what the function makes of it */
		double x = 178 / 255.0 * 2 - 1, z = 244 / 255.0 * 2 - 1, y = 128 / 255.0 * 2 - 1,
			   l = sqrt(x * x + y * y + z * z);
		if (what == PROBE_SURFACE_NORMAL)
			assert_shows(&s, 0.5 + 0.5 * x / l, 0.5 + 0.5 * z / l, 0.5 - 0.5 * y / l, 3e-3);
		else
			assert_shows(&s, 0.5, 1, 0.5, HALF);
		s.view.show = STILB_RENDER_SHOW_NORMAL; /* and the normal itself */
		assert_shows(&s, 0.5 + 0.5 * x / l, 0.5 + 0.5 * z / l, 0.5 - 0.5 * y / l, 3e-3);
		s.view.show = STILB_RENDER_SHOW_SHADED;
	}
	stilb_image_finish(&image);
	stage_close(&s);
}

/* Channels show what the function has made of each member. */
static void channels_show_what_functions_make(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = probed(surface_matt(), PROBE_REST, 0.25f, 0.5f, 0.75f);
	show_probe(&s, &q, &surface);
	s.view.show = STILB_RENDER_SHOW_METALNESS;
	assert_shows(&s, 0.25, 0.25, 0.25, HALF);
	s.view.show = STILB_RENDER_SHOW_ROUGHNESS;
	assert_shows(&s, 0.5, 0.5, 0.5, HALF);
	s.view.show = STILB_RENDER_SHOW_OCCLUSION;
	assert_shows(&s, 0.75, 0.75, 0.75, HALF);
	surface = probed(surface_matt(), PROBE_EMISSION, 0.5f, 2.0f, 0.0f);
	show_probe(&s, &q, &surface);
	s.view.show = STILB_RENDER_SHOW_EMISSION;
	assert_shows(&s, 0.5, 2, 0, 2 * HALF);
	surface = probed(surface_matt(), PROBE_ALPHA, 0, 1, 0); /* 1 at this time; blending is left out */
	surface.alpha = STILB_SCENE_BLEND;
	show_probe(&s, &q, &surface);
	s.view.time = 0.75f;
	s.view.show = STILB_RENDER_SHOW_ALPHA;
	assert_shows(&s, 1, 1, 1, HALF);
	s.view.time = 0.25f;
	assert_shows(&s, 0, 0, 0, HALF);
	stage_close(&s);
}

static void time_and_parameters(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = probed(surface_unlit(), PROBE_TIME, 0, 0, 0);
	show_probe(&s, &q, &surface);
	s.view.time = 0.75f;
	assert_shows(&s, 0.75, 0.75, 0, HALF);
	s.view.time = 100.25f; /* the same records: nothing was set anew */
	assert_shows(&s, 1, 0.25, 0, HALF);
	surface = probed(surface_unlit(), PROBE_PARAMETERS, 1, 0, 0);
	surface.parameters[1][0] = 0.0f;
	reference_set3(surface.parameters[2], 0.25f, 0.0f, 0.125f);
	reference_set3(surface.parameters[3], 0.0f, 0.5f, 0.125f);
	surface.parameters[3][3] = 0.125f; /* number 9 is number 3 */
	show_probe(&s, &q, &surface);
	assert_shows(&s, 0.375, 0.625, 0.375, HALF);
	for (int edit = 0; edit < 3; edit++) { /* as a program edits them, frame by frame */
		surface.parameters[2][1] = 0.1f * (float)edit;
		assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
		stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
		assert_int_equal(changes.material_count, 1);
		assert_int_equal(changes.function_count, 0);
		assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
		stilb_scene_changes_clear(s.scene);
		assert_shows(&s, 0.375, 0.625 + 0.1 * edit, 0.375, HALF);
	}
	surface.parameters[0][3] = (float)NAN;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "parameter"));
	stage_close(&s);
}

/* ---- alpha ------------------------------------------------------------------------------------------------------- */

static bool stripe_is_there(uint32_t x, double time)
{
	double at = 4 * place_of(x) + time;
	return at - floor(at) >= 0.5;
}

/* A mask by the function, seen and where depth alone or velocities are drawn; opaque materials do not look at alpha. */
static void masks_by_functions(void **state)
{
	(void)state;
	for (int kind = 0; kind < 8; kind++) {
		bool extras = kind & 1, masked = kind & 2, layers = kind & 4;
		stage s = stage_open((stilb_render_desc){0}, 0);
		square q;
		square_make(&q, 1.0f);
		q.mesh.extras = extras ? q.extras : NULL;
		stilb_scene_surface surface = probed(surface_matt(), PROBE_ALPHA, 4, 1, 0);
		surface.alpha = masked ? STILB_SCENE_MASK : STILB_SCENE_OPAQUE;
		surface.sheen_color[0] = layers ? 0.5f : 0.0f;
		show_probe(&s, &q, &surface);
		s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
		s.view.time = 0.25f;
		stilb_image picture = stage_picture(&s);
		for (uint32_t x = 0; x < STAGE_SIDE; x++)
			assert_int_equal(picture_value(&picture, x, 7, 1) > 0.1, !masked || stripe_is_there(x, 0.25));
		stilb_image_finish(&picture);
		stilb_render_target target = {.name = "shadow",
		                              .kind = STILB_RENDER_TARGET_DEPTH,
		                              .width = STAGE_SIDE,
		                              .height = STAGE_SIDE,
		                              .output = true};
		s.view.target = &target;
		stage_frame(&s);
		stilb_gpu *gpu = stilb_render_gpu(s.render);
		const stilb_gpu_plan *plan = stilb_render_plan(s.render);
		uint64_t ticket, frame;
		const void *bytes;
		assert_int_equal(stilb_gpu_read_begin(gpu, plan, stilb_gpu_plan_find(plan, "shadow"), 0, 0, &ticket), STILB_OK);
		assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
		for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
			bool there = !masked || stripe_is_there(i % STAGE_SIDE, 0.25);
			assert_near("a depth", (double)((const float *)bytes)[i], there ? 0.05 / 4.0 : 0.0, 1e-6);
		}
		stilb_gpu_read_end(gpu, ticket);
		stilb_mat4 last = s.view.view_projection; /* the camera was half a metre aside */
		for (int r = 0; r < 4; r++)
			last.m[12 + r] += 0.5f * last.m[r];
		s.view.target = NULL;
		s.view.last = &last;
		stage_frame(&s);
		plan = stilb_render_plan(s.render);
		uint16_t image = stilb_gpu_plan_find(plan, "velocity");
		assert_int_equal(stilb_gpu_read_begin(gpu, plan, image, 0, 0, &ticket), STILB_OK);
		assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
		for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
			bool there = !masked || stripe_is_there(i % STAGE_SIDE, 0.25);
			uint32_t size = ((const uint16_t *)bytes)[2 * i] & 0x7fffu;
			assert_true(there ? size > 0x3800 : size < 0x1400); /* half a pixel; a thousandth */
		}
		stilb_gpu_read_end(gpu, ticket);
		stage_close(&s);
	}
}

/* Frames leave the normal that the function says, of what its alpha leaves; with layers and without. */
static void normals_that_frames_leave(void **state)
{
	(void)state;
	static const double want[3] = {0.0, 0.5, -0.8660254};
	for (int layers = 0; layers < 2; layers++) {
		stage s = stage_open((stilb_render_desc){0}, 0);
		square q;
		square_make(&q, 1.0f);
		stilb_scene_surface surface = probed(surface_matt(), PROBE_NORMAL, 0, 3 * 0.5f, -3 * 0.8660254f);
		surface.clearcoat = layers ? 0.5f : 0.0f;
		show_probe(&s, &q, &surface);
		stilb_mat4 last = s.view.view_projection;
		s.view.last = &last;
		s.view.surfaces = true;
		stage_frame(&s);
		stilb_gpu *gpu = stilb_render_gpu(s.render);
		const stilb_gpu_plan *plan = stilb_render_plan(s.render);
		uint16_t image = stilb_gpu_plan_find(plan, "surface normal");
		uint64_t ticket, frame;
		const void *bytes;
		assert_int_equal(stilb_gpu_read_begin(gpu, plan, image, 0, 0, &ticket), STILB_OK);
		assert_int_equal(stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame), STILB_OK);
		for (uint32_t i = 0; i < STAGE_SIDE * STAGE_SIDE; i++) {
			const uint16_t *place = (const uint16_t *)bytes + 2 * (size_t)i;
			stilb_vec3 n = shade_direction_from_octahedral(
				(stilb_vec2){(float)place[0] / 32767.5f - 1.0f, (float)place[1] / 32767.5f - 1.0f});
			for (int c = 0; c < 3; c++)
				assert_near("a normal", (double)n[c], want[c], 1e-4);
		}
		stilb_gpu_read_end(gpu, ticket);
		stage_close(&s);
	}
}

/* With several samples a pixel the mask's edge drops samples, and what blends covers by the function's alpha. */
static void alpha_with_samples(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.samples = 4}, 0);
	square q;
	square_make(&q, 1.0f);
	s.view.backdrop.kind = STILB_SCENE_BACKDROP_COLOR;
	stilb_scene_surface surface = probed(surface_unlit(), PROBE_ALPHA, 4, 0, 0);
	for (int blends = 0; blends < 2; blends++) {
		surface.alpha = blends ? STILB_SCENE_BLEND : STILB_SCENE_MASK;
		show_probe(&s, &q, &surface);
		stilb_image picture = stage_picture(&s);
		for (uint32_t x = 1; x < STAGE_SIDE; x++)
			if (x % 3 == 1) /* of stripes three pixels wide the middle: no edge is near */
				assert_near("a stripe", picture_value(&picture, x, 7, 0), stripe_is_there(x, 0), HALF);
		stilb_image_finish(&picture);
	}
	stage_close(&s);
}

/* ---- the identity ------------------------------------------------------------------------------------------------ */

/* A surface with everything that another kind of program reads. */
static stilb_scene_surface surface_of_kind(uint32_t kind)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	float dim[4] = {0.7f, 0.4f, 0.3f, 1.0f};
	memcpy(surface.color, dim, sizeof dim);
	surface.roughness = 0.4f;
	surface.metalness = 0.3f;
	reference_set3(surface.emission, 0.05f, 0.1f, 0.0f);
	surface.alpha = kind & 1 ? STILB_SCENE_MASK : STILB_SCENE_OPAQUE;
	if (kind & 2) {
		surface.clearcoat = 0.8f;
		surface.clearcoat_roughness = 0.2f;
		reference_set3(surface.sheen_color, 0.2f, 0.1f, 0.3f);
		surface.anisotropy = 0.5f;
	}
	if (kind & 4) {
		surface.workflow = STILB_SCENE_SPECULAR;
		reference_set3(surface.specular, 0.3f, 0.2f, 0.1f);
	}
	for (int i = 0; i < STILB_SCENE_MAPS; i++)
		if (i < 5 || kind & 2)
			surface.maps[i].texture = 1 + (i % 2 == 0);
	if (kind & 8) {
		surface.transmission = 0.5f;
		surface.roughness = 0.6f;
	}
	if (kind & 16)
		surface.alpha = STILB_SCENE_BLEND;
	return surface;
}

#define IDENTITY_KINDS 9u

/* Squares with a surface of each kind, tilted, in a grid; turn: which of them have extras. */
static void show_kinds(stage *s, bool function, uint32_t turn)
{
	stilb_image images[2];
	for (uint32_t t = 0; t < 2; t++) {
		assert_int_equal(stilb_image_create(&images[t], 8, 8, 4, t ? STILB_IMAGE_U8_SRGB : STILB_IMAGE_U8_LINEAR),
		                 STILB_OK);
		for (uint32_t i = 0; i < 8 * 8 * 4; i++)
			((uint8_t *)images[t].pixels)[i] = (uint8_t)(i % 4 == 2 ? 200 + i % 40 : 60 + 37 * i % 190);
	}
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_texture(build, &images[0]);
	stilb_scene_build_texture(build, &images[1]);
	if (function)
		stilb_scene_build_function(build, &identity);
	square q;
	square_make(&q, 1.0f);
	for (int v = 0; v < 4; v++)
		reference_set3(q.extras[v].color, 0.5f + 0.1f * (float)v, 0.9f, 0.7f);
	uint32_t meshes[2];
	meshes[1] = stilb_scene_build_mesh(build, &q.mesh);
	q.mesh.extras = NULL;
	meshes[0] = stilb_scene_build_mesh(build, &q.mesh);
	/* Metal and gloss, masks, layers, transmission, blending. */
	static const uint32_t kinds[IDENTITY_KINDS] = {0, 1, 2, 3, 4, 5, 9, 10, 16};
	for (uint32_t k = 0; k < IDENTITY_KINDS; k++) {
		stilb_scene_surface surface = surface_of_kind(kinds[k]);
		surface.function = function;
		stilb_mat4 place =
			stilb_mat4_scale_translate(0.3f, -0.66f + 0.66f * (float)(k % 3), 0.0f, -0.66f + 0.66f * (float)(k / 3));
		place.m[1] = 0.05f;
		stage_model(build, meshes[(k + turn) % 2], stage_material(build, &surface), place);
	}
	stage_show(s, build);
	stilb_image_finish(&images[0]);
	stilb_image_finish(&images[1]);
}

static stilb_image panorama_make(void)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 32, 16, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t i = 0; i < 32 * 16 * 3; i++)
		((float *)image.pixels)[i] = 0.2f + 0.01f * (float)(i * 7 % 91);
	return image;
}

static void identity_keeps_bits(void **state)
{
	(void)state;
	stilb_image panorama = panorama_make();
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_POINT, .position = {1, 3, 0.5f}, .intensity = {9, 8, 7}};
	/* The last ones show channels. Software devices take a second for each of the larger programs. */
	for (uint32_t mode = 0; mode < 20; mode += TEST_ASAN ? 7 : mode < 8 ? 1 : 2) {
		stilb_render_desc desc = {.width = 96,
		                          .samples = mode & 1 ? 4 : 1,
		                          .materials = (stilb_render_materials)(mode % 3),
		                          .replay = (stilb_render_replay_mode)(mode / 3 % 3),
		                          .float_vertices = mode & 2};
		stage s = stage_open(desc, mode % 2);
		s.view.lights = &light;
		s.view.light_count = 1;
		s.view.both_sides = mode & 4;
		s.view.shading = stilb_render_shading_default();
		s.view.shading.brdf = mode & 2 ? 5 : s.view.shading.brdf;
		if (mode & 4)
			s.view.surroundings.panorama = panorama;
		s.view.show = mode >= 8 ? (stilb_render_show)(STILB_RENDER_SHOW_BASE + mode - 8) : STILB_RENDER_SHOW_SHADED;
		show_kinds(&s, false, mode / 2);
		stilb_image without = stage_picture(&s);
		show_kinds(&s, true, mode / 2);
		stilb_image with = stage_picture(&s);
		uint32_t lit = 0;
		size_t size = stilb_image_size(&with) / (with.width * with.height);
		for (uint32_t i = 0; i < with.width * with.height; i++) {
			lit += memcmp((char *)with.pixels + i * size, (char *)with.pixels, size) != 0;
			if (memcmp((char *)with.pixels + i * size, (char *)without.pixels + i * size, size) != 0)
				fail_msg("mode %u, pixel %u, %u: %.7f %.7f %.7f, without function %.7f %.7f %.7f", mode, i % with.width,
				         i / with.width, picture_value(&with, i % with.width, i / with.width, 0),
				         picture_value(&with, i % with.width, i / with.width, 1),
				         picture_value(&with, i % with.width, i / with.width, 2),
				         picture_value(&without, i % with.width, i / with.width, 0),
				         picture_value(&without, i % with.width, i / with.width, 1),
				         picture_value(&without, i % with.width, i / with.width, 2));
		}
		assert_true(lit > 500 || s.view.show == STILB_RENDER_SHOW_WIREFRAME);
		stilb_image_finish(&with);
		stilb_image_finish(&without);
		stage_close(&s);
	}
	stilb_image_finish(&panorama);
}

/* ---- several, edits, removal ------------------------------------------------------------------------------------- */

/* Reads the scene's changes into the renderer. */
static stilb_result update(stage *s)
{
	stilb_scene_changes changes = stilb_scene_changes_read(s->scene);
	stilb_result result = stilb_render_update_scene(s->render, s->scene, &changes);
	if (result == STILB_OK)
		stilb_scene_changes_clear(s->scene);
	return result;
}

/* Programs that the renderer has for this function. */
static uint32_t programs_of(const stage *s, uint32_t index)
{
	const render_programs *programs = &s->render->device->programs;
	uint32_t count = 0;
	for (uint32_t c = 0; c < programs->choice_count; c++)
		for (uint32_t m = 0; m < programs->choices[c]->map_count; m++)
			count += render_maps_function(programs->choices[c]->maps[m].key >> 5) == index;
	return count;
}

/* Functions come, are replaced and go while frames are drawn; two are side by side; those of one are one run. */
static void functions_come_and_go(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_unlit();
	stage_show_square(&s, &q, &surface, NULL, 0);
	assert_shows(&s, 1, 1, 1, HALF);
	uint32_t first, second;
	surface = probed(surface_unlit(), PROBE_COLOR, 0.5f, 0.25f, 0);
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), "surface 0: there is no function 0");
	assert_int_equal(stilb_scene_add_function(s.scene, &probe, &first), STILB_OK);
	assert_int_equal(first, 0);
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(update(&s), STILB_OK);
	assert_shows(&s, 0.5, 0.25, 0, HALF);
	uint32_t index = s.render->scene.functions[0].index;
	assert_true(index > 0 && programs_of(&s, index) == 1);
	assert_int_equal(stilb_scene_remove_function(s.scene, 0), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), "surface function 0 is in use by 1 surface; remove these first");
	/* Two side by side: a second square above the right half. */
	uint32_t material, model, surface_id;
	stilb_scene_material paint = s.scene->materials[0];
	stilb_scene_surface other = surface_unlit();
	other.function = 2;
	other.color[1] = 0.75f;
	assert_int_equal(stilb_scene_add_function(s.scene, &identity, &second), STILB_OK);
	assert_int_equal(second, 1);
	assert_int_equal(stilb_scene_add_surface(s.scene, &other, &surface_id), STILB_OK);
	paint.surface = 1 + surface_id;
	assert_int_equal(stilb_scene_add_material(s.scene, &paint, &material), STILB_OK);
	stilb_scene_build_part part = {0, material};
	stilb_mat4 right = stilb_mat4_scale_translate(1.0f, 1.05f, 0.02f, 0.0f);
	assert_int_equal(stilb_scene_add_model(s.scene, &right, &part, 1, &model), STILB_OK);
	assert_int_equal(update(&s), STILB_OK);
	stilb_image picture = stage_picture(&s);
	assert_near("left", picture_value(&picture, 2, 9, 1), 0.25, HALF);
	assert_near("right", picture_value(&picture, 20, 9, 1), 0.75, HALF);
	assert_near("right", picture_value(&picture, 20, 9, 2), 1, HALF);
	stilb_image_finish(&picture);
	/* The first one goes: the surface has none in the same edit. */
	surface.function = 0;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(stilb_scene_remove_function(s.scene, first), STILB_OK);
	assert_int_equal(stilb_scene_remove_function(s.scene, first), STILB_ERROR_ARGUMENT);
	assert_null(s.scene->functions[0].codes[0].words);
	assert_int_equal(update(&s), STILB_OK);
	picture = stage_picture(&s);
	assert_near("left", picture_value(&picture, 2, 9, 1), 1, HALF);
	assert_near("right", picture_value(&picture, 20, 9, 1), 0.75, HALF);
	stilb_image_finish(&picture);
	for (int f = 0; f < 4; f++)
		stage_frame(&s);
	assert_null(s.render->device->programs.functions[index]);
	assert_int_equal(programs_of(&s, index), 0);
	/* Another one in its place, with the same id and index: it is that one that is shown. */
	surface.function = 1;
	assert_int_equal(stilb_scene_add_function(s.scene, &identity, &first), STILB_OK);
	assert_int_equal(first, 0);
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(update(&s), STILB_OK);
	assert_int_equal(s.render->scene.functions[0].index, index);
	picture = stage_picture(&s);
	assert_near("left", picture_value(&picture, 2, 9, 1), 1, HALF);
	stilb_image_finish(&picture);
	/* In one update one that a surface names gives way to another with its id. */
	surface.function = 0;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(stilb_scene_remove_function(s.scene, first), STILB_OK);
	assert_int_equal(stilb_scene_add_function(s.scene, &probe, &first), STILB_OK);
	assert_int_equal(first, 0);
	surface.function = 1;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(update(&s), STILB_OK);
	picture = stage_picture(&s);
	assert_near("left", picture_value(&picture, 2, 9, 1), 0.25, HALF);
	stilb_image_finish(&picture);
	stage_close(&s);
}

/* Six materials of one function with parameters of their own are drawn with one bind. */
static void functions_batch(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	square q;
	square_make(&q, 1.0f);
	uint64_t binds[2];
	for (uint32_t many = 0; many < 2; many++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_function(build, &probe);
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
		for (uint32_t i = 0; i < (many ? 6u : 1u); i++) {
			stilb_scene_surface surface = probed(surface_unlit(), PROBE_COLOR, 0.125f * (float)i, 0, 0);
			stage_model(build, mesh, stage_material(build, &surface),
			            stilb_mat4_scale_translate(1.0f / 6, -1 + (2 * (float)i + 1) / 6, 0, 0));
		}
		stage_show(&s, build);
		stilb_image picture = stage_picture(&s);
		for (uint32_t i = 0; i < (many ? 6u : 1u); i++)
			assert_near("a square", picture_value(&picture, 4 * i + 2, 12, 0), 0.125 * i, HALF);
		stilb_image_finish(&picture);
		stilb_render_stats stats = stilb_render_stats_get(s.render);
		binds[many] = stats.binds_sent;
	}
	assert_int_equal(binds[0], binds[1]);
	stage_close(&s);
}

/* Two renderers show one scene, each by its own copy of the code. What a view needs of functions is made before its
 * first frame. */
static void renderers_share_a_scene(void **state)
{
	(void)state;
	stage s[2];
	for (int i = 0; i < 2; i++) {
		s[i] = stage_open((stilb_render_desc){0}, 0);
		s[i].view.shading = stilb_render_shading_default();
	}
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = probed(surface_unlit(), PROBE_COLOR, 0.5f, 0.25f, 0);
	show_probe(&s[0], &q, &surface);
	s[1].scene = s[0].scene;
	assert_int_equal(stilb_render_set_scene(s[1].render, s[0].scene), STILB_OK);
	assert_int_equal(stilb_render_prepare_view(s[1].render, &s[1].view), STILB_OK);
	uint32_t made = programs_of(&s[1], 1);
	assert_true(made > 0);
	for (int i = 0; i < 2; i++)
		assert_shows(&s[i], 0.5, 0.25, 0, HALF);
	assert_int_equal(programs_of(&s[1], 1), made);
	surface.parameters[1][0] = 1.0f;
	assert_int_equal(stilb_scene_set_surface(s[0].scene, 0, &surface), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s[0].scene);
	for (int i = 0; i < 2; i++)
		assert_int_equal(stilb_render_update_scene(s[i].render, s[0].scene, &changes), STILB_OK);
	for (int i = 0; i < 2; i++)
		assert_shows(&s[i], 1, 0.25, 0, HALF);
	assert_int_equal(stilb_render_set_scene(s[1].render, NULL), STILB_OK);
	s[1].scene = NULL;
	assert_shows(&s[0], 1, 0.25, 0, HALF);
	stage_close(&s[1]);
	stage_close(&s[0]);
}

/* ---- what is no such code ---------------------------------------------------------------------------------------- */

/* The probe with another word in one of its codes, and with so many bytes of that; 0: all. */
static void refused(const char *what, uint32_t code, uint32_t word, uint32_t value, size_t bytes, const char *reason)
{
	stilb_scene_function broken = probe;
	uint32_t *words = malloc(probe.codes[code].bytes);
	assert_non_null(words);
	memcpy(words, probe.codes[code].words, probe.codes[code].bytes);
	words[word] = value;
	broken.codes[code] = (stilb_scene_function_code){words, bytes ? bytes : probe.codes[code].bytes};
	const char *mistake = stilb_scene_function_mistake(&broken);
	if (!mistake || !strstr(mistake, reason))
		fail_msg("%s: '%s', not '%s'", what, mistake ? mistake : "nothing", reason);
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_function(build, &broken);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "surface function 0, 'probe': "));
	assert_non_null(strstr(stilb_error_message(), reason));
	free(words);
}

static void broken_code_is_refused(void **state)
{
	(void)state;
	assert_null(stilb_scene_function_mistake(&probe));
	assert_null(stilb_scene_function_mistake(&identity));
	refused("magic", 0, 0, 0x03022307, 0, "not SPIR-V");
	refused("version", 5, 1, 0x00010700, 0, "another version");
	refused("version", 5, 1, 0x00020000, 0, "another version");
	refused("bound", 27, 3, 0, 0, "header is damaged");
	refused("bound", 27, 3, UINT32_MAX, 0, "header is damaged");
	refused("size", 9, 2, 0, 402, "no multiple of 4");
	refused("cut off", 3, 2, 0, probe.codes[3].bytes - 4, "cut off");
	refused("header alone", 3, 2, 0, 16, "not SPIR-V");
	refused("no instruction", 3, 2, 0, 20, "no entry point");
	refused("length of 0", 8, 5, 17, 0, "cut off, or its instructions");
	stilb_scene_function broken = probe;
	broken.codes[12].words = NULL;
	assert_string_equal(stilb_scene_function_mistake(&broken), "a shader is missing");
	broken = probe;
	broken.codes[12].bytes = 0;
	assert_string_equal(stilb_scene_function_mistake(&broken), "a shader is missing");
	broken = probe;
	broken.shaders++;
	assert_non_null(strstr(stilb_scene_function_mistake(&broken), "another Stilb"));
	static const char *const names[] = {NULL, "", "a b", "a\n",
	                                    "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"};
	for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
		broken = probe;
		broken.name = names[n];
		assert_non_null(strstr(stilb_scene_function_mistake(&broken), "its name"));
	}
}

/* Sound SPIR-V at a place where it does not fit. */
static void other_interfaces_are_refused(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	static const struct {
		uint32_t place, code;
		const char *reason;
	} cases[] = {
		{0, 24, "writes other colours"},  /* of depth alone where colour is */
		{24, 28, "writes other colours"}, /* and the other way round */
		{24, 0, "binding 0 of set 0"},    /* shadow maps that are not there */
		{0, 1, "reads location"},         /* extras that the mesh has not */
		{0, 8, "binding 5 of set 1"},     /* layers where there are none */
		{0, 4, "binding 1 of set 0"},     /* a panorama that is not there */
		{8, 16, "binding 1 of set 0"},    /* what is behind */
		{16, 18, "binding 2 of set 0"},   /* both */
	};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
		stilb_scene_function broken = probe;
		broken.codes[cases[c].place] = probe.codes[cases[c].code];
		assert_null(stilb_scene_function_mistake(&broken));
		square q;
		square_make(&q, 1.0f);
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_function(build, &broken);
		stilb_scene_surface surface = probed(surface_unlit(), PROBE_COLOR, 1, 0, 0);
		stage_model(build, stilb_scene_build_mesh(build, &q.mesh), stage_material(build, &surface),
		            stilb_mat4_identity());
		stilb_scene *scene;
		assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
		assert_int_equal(stilb_render_set_scene(s.render, scene), STILB_ERROR_ARGUMENT);
		const char *said = stilb_error_message();
		if (!strstr(said, "surface function probe") || !strstr(said, cases[c].reason))
			fail_msg("'%s', not '%s'", said, cases[c].reason);
		stilb_scene_destroy(scene);
	}
	/* In an edit it is told once; the material is shown without it, and what else changed is there. */
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_unlit();
	stage_show_square(&s, &q, &surface, NULL, 0);
	stilb_scene_function broken = probe;
	broken.codes[0] = probe.codes[24];
	uint32_t id;
	assert_int_equal(stilb_scene_add_function(s.scene, &broken, &id), STILB_OK);
	surface = probed(surface_unlit(), PROBE_COLOR, 1, 0, 0);
	surface.color[2] = 0.5f;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	assert_int_equal(update(&s), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "surface function probe"));
	assert_int_equal(update(&s), STILB_OK);
	assert_shows(&s, 1, 1, 0.5, HALF);
	stage_close(&s);
}

/* ---- dumps ------------------------------------------------------------------------------------------------------- */

#define DUMP_PATH "test_render_functions.dump"

static uint8_t *file_read(const char *path, size_t *size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	assert_int_equal(fseek(file, 0, SEEK_END), 0);
	*size = (size_t)ftell(file);
	rewind(file);
	uint8_t *bytes = malloc(*size);
	assert_non_null(bytes);
	assert_int_equal(fread(bytes, 1, *size, file), *size);
	fclose(file);
	return bytes;
}

/* A frame of two functions is played with the same pixels, at its time, and dumped again with the same bytes; damaged
 * functions are refused. */
static void dumps_hold_functions(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	s.view.shading = stilb_render_shading_default();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_function(build, &identity); /* no material names it */
	stilb_scene_build_function(build, &probe);
	stilb_scene_build_function(build, &identity);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (uint32_t i = 0; i < 2; i++) {
		stilb_scene_surface surface = probed(surface_unlit(), PROBE_TIME, 0, 0, 0);
		surface.function = 3 - i;
		surface.color[2] = 0.25f;
		stage_model(build, mesh, stage_material(build, &surface),
		            stilb_mat4_scale_translate(0.5f, -0.5f + (float)i, 0, 0));
	}
	stage_show(&s, build);
	s.view.time = 0.625f;
	stilb_image picture = stage_picture(&s);
	assert_near("time", picture_value(&picture, 18, 12, 1), 0.625, HALF);
	assert_near("identity", picture_value(&picture, 6, 12, 2), 0.25, HALF);
	stilb_render_pass pass = {.name = "main"};
	if (stilb_render_dump_save(s.render, &pass, 1, &s.view, 1, DUMP_PATH) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	uint64_t hash = stilb_render_stream_hash(s.render);
	stilb_scene_surface surface = s.scene->surfaces[1];
	surface.parameters[2][2] = 1.0f; /* parameters are part of the stream's hash */
	assert_int_equal(stilb_scene_set_surface(s.scene, 1, &surface), STILB_OK);
	assert_int_equal(update(&s), STILB_OK);
	stage_frame(&s);
	assert_int_not_equal(hash, stilb_render_stream_hash(s.render));
	stage_close(&s);
	size_t size, again_size;
	uint8_t *bytes = file_read(DUMP_PATH, &size);
	stilb_render_dump *dump;
	if (stilb_render_dump_load(DUMP_PATH, &dump) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(dump->header->functions, 2);
	s = stage_open((stilb_render_desc){0}, 0);
	assert_int_equal(stilb_render_dump_upload(dump, s.render), STILB_OK);
	stilb_image played = {0};
	assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, s.render, s.pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, s.render, s.pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(s.render, &played), STILB_OK);
	assert_int_equal(hash, stilb_render_stream_hash(s.render));
	assert_memory_equal(played.pixels, picture.pixels, stilb_image_size(&picture));
	assert_int_equal(stilb_render_dump_save(s.render, dump->pass_table, 1, dump->view_table, 1, DUMP_PATH), STILB_OK);
	uint8_t *again = file_read(DUMP_PATH, &again_size);
	assert_int_equal(size, again_size);
	assert_memory_equal(bytes, again, size);
	stilb_render_dump_destroy(dump);
	stilb_image_finish(&played);
	stilb_image_finish(&picture);
	stage_close(&s);
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	assert_true(render_dump_layout((const render_dump_header *)(const void *)bytes, begin));
	static const struct {
		render_dump_part part;
		size_t offset;
		uint32_t value;
		const char *reason;
	} damages[] = {
		{RENDER_DUMP_FUNCTIONS, 0, 0x20202020, "surface function 0: its name is not"},
		{RENDER_DUMP_FUNCTIONS, offsetof(render_dump_function, shaders), 7, "surface function 0: it was compiled with"},
		{RENDER_DUMP_FUNCTIONS, offsetof(render_dump_function, bytes), 401, "no multiple of 4"},
		{RENDER_DUMP_FUNCTIONS, offsetof(render_dump_function, bytes), 400, "bytes of surface functions, but these"},
		{RENDER_DUMP_CODE, 0, 0, "surface function 0: a shader is not SPIR-V"},
		{RENDER_DUMP_CODE, 20, 0, "surface function 0: a shader is cut off, or its instructions"},
		{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, function), 3, "surface 0: its function is not there"},
	};
	for (size_t d = 0; d < sizeof damages / sizeof *damages; d++) {
		memcpy(bytes, again, size);
		memcpy(bytes + begin[damages[d].part] + damages[d].offset, &damages[d].value, sizeof(uint32_t));
		uint64_t sum = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, begin[RENDER_DUMP_CHECKSUM]);
		memcpy(bytes + begin[RENDER_DUMP_CHECKSUM], &sum, sizeof sum);
		uint8_t *copy = malloc(size);
		assert_non_null(copy);
		memcpy(copy, bytes, size);
		assert_int_equal(render_dump_read(copy, size, "a.dump", &dump), STILB_ERROR_FILE);
		if (!strstr(stilb_error_message(), damages[d].reason))
			fail_msg("'%s', not '%s'", stilb_error_message(), damages[d].reason);
	}
	free(bytes);
	free(again);
	remove(DUMP_PATH);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(functions_change_members),     cmocka_unit_test(functions_are_given_places),
		cmocka_unit_test(functions_are_given_maps),     cmocka_unit_test(channels_show_what_functions_make),
		cmocka_unit_test(time_and_parameters),          cmocka_unit_test(masks_by_functions),
		cmocka_unit_test(normals_that_frames_leave),    cmocka_unit_test(alpha_with_samples),
		cmocka_unit_test(functions_come_and_go),        cmocka_unit_test(functions_batch),
		cmocka_unit_test(renderers_share_a_scene),      cmocka_unit_test(broken_code_is_refused),
		cmocka_unit_test(other_interfaces_are_refused), cmocka_unit_test(dumps_hold_functions),
		cmocka_unit_test(identity_keeps_bits),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
