/* Violations of the contracts of render on the null device, planted: each must die with the assert's text. */
#include "support/contract.h"
#include "support/render_fixture.h"
#include "support/test.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

static const stilb_render_desc good_desc = {
	.device = STILB_RENDER_DEVICE_NULL, .width = 64, .height = 64, .context_count = 1};

static void create(stilb_render_desc desc)
{
	stilb_render *render;
	stilb_render_create(&desc, &render);
}

static void creation(void **state)
{
	(void)state;
	stilb_render_desc desc = good_desc;
	desc.width = 0;
	contract_breaks("1..16384 pixels a side", create(desc));
	desc = good_desc;
	desc.samples = 2;
	contract_breaks("desc->samples == 0", create(desc));
	desc = good_desc;
	desc.context_count = 0;
	contract_breaks("desc->context_count >= 1", create(desc));
	desc = good_desc;
	desc.replay = (stilb_render_replay_mode)7;
	contract_breaks("desc->replay", create(desc));
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

static void *begin_frame(void *render)
{
	stilb_render_frame_begin(render);
	return NULL;
}

static void *end_segment(void *context)
{
	stilb_render_segment_end(context);
	return NULL;
}

static void elsewhere(void *(*fn)(void *), void *user)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, fn, user), 0);
	pthread_join(thread, NULL);
}

static void threads(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	contract_breaks("called on the owner's thread", elsewhere(begin_frame, render));
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 0, 0);
	contract_breaks("called on the owner's thread", elsewhere(end_segment, context));
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	stilb_render_destroy(render);
}

static void locks(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	contract_breaks("the caller holds the lock", render_device_update(render->device, &render->resources));
	stilb_render_destroy(render);
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

static stilb_render_mesh make_mesh(stilb_render *render)
{
	static stilb_scene_vertex vertices[3];
	static uint32_t indices[3] = {0, 1, 2};
	stilb_scene_mesh mesh = {.vertices = vertices, .vertex_count = 3, .indices = indices, .index_count = 3};
	stilb_render_mesh out;
	assert_int_equal(stilb_render_mesh_create(render, &mesh, &out), STILB_OK);
	return out;
}

static stilb_render_material make_material(stilb_render *render)
{
	stilb_scene_material material = {.roughness = 1.0f};
	stilb_render_material out;
	assert_int_equal(stilb_render_material_create(render, &material, (stilb_render_texture){0}, &out), STILB_OK);
	return out;
}

static void draw(stilb_render_context *context, stilb_render_mesh mesh, stilb_render_material material, float last)
{
	stilb_mat4 transform = {.m = {[0] = 1.0f, [5] = 1.0f, [10] = 1.0f, [15] = last}};
	stilb_render_draw(context, mesh, material, &transform);
}

/* ---- the order of calls ------------------------------------------------------------------------------------------ */

static void begin_twice(stilb_render *render, uint32_t pass)
{
	stilb_render_pass_begin(render, pass, 0);
	stilb_render_pass_begin(render, pass, 0);
}

static void frame_inside_a_pass(stilb_render *render)
{
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_frame_begin(render);
}

static void same_segment_twice(stilb_render *render)
{
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_pass_begin(render, 0, 1);
	for (int i = 0; i < 2; i++) {
		stilb_render_segment_begin(context, 0, 0);
		stilb_render_segment_end(context);
	}
}

static void segment_of_no_pass(stilb_render *render)
{
	stilb_render_pass_begin(render, 0, 1);
	stilb_render_segment_begin(stilb_render_context_get(render, 0), 0, 1);
}

static void replay(stilb_render *render, stilb_render_pass pass, uint32_t views)
{
	stilb_render_view view = {.shading = stilb_render_shading_default()};
	stilb_render_replay(render, &pass, 1, &view, views, NULL, 0);
}

static void replay_without_segment(stilb_render *render)
{
	stilb_render_pass_begin(render, 0, 1);
	stilb_render_pass_end(render, 0);
	replay(render, (stilb_render_pass){0}, 1);
}

static void replay_with_wrong_view(stilb_render *render)
{
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	replay(render, (stilb_render_pass){.view = 1}, 1);
}

static void replay_a_damaged_run(stilb_render *render)
{
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_pass_begin(render, 0, 1);
	stilb_render_segment_begin(context, 0, 0);
	draw(context, make_mesh(render), make_material(render), 1.0f);
	stilb_render_segment_end(context);
	stilb_render_pass_end(render, 0);
	/* A run that ends behind the only chunk of commands that is claimed. */
	context->runs[0].count = RENDER_COMMAND_CHUNK + 1;
	replay(render, (stilb_render_pass){0}, 1);
}

static void sorted_2d_pass(stilb_render *render)
{
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	replay(render, (stilb_render_pass){.kind = STILB_RENDER_PASS_2D, .sort = true}, 1);
}

static void replay_with_target(stilb_render *render, stilb_render_target target)
{
	stilb_render_pass pass = {0};
	stilb_render_view view = {.view_projection = stilb_mat4_identity(), .target = &target};
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	stilb_render_replay(render, &pass, 1, &view, 1, NULL, 0);
}

static void replay_with_area(stilb_render *render, stilb_render_target_kind kind, uint16_t layer, uint16_t left,
                             uint16_t width)
{
	stilb_render_target target = {
		.name = "maps", .kind = kind, .width = 8, .height = 8, .layers = kind == STILB_RENDER_TARGET_DEPTH ? 2 : 0};
	stilb_render_pass pass = {0};
	stilb_render_view view = {
		.view_projection = stilb_mat4_identity(), .target = &target, .layer = layer, .area = {left, 0, width, width}};
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	stilb_render_replay(render, &pass, 1, &view, 1, NULL, 0);
}

/* One light with shadow maps in a target of 16 x 16 texels and two layers. */
static void replay_with_shadows(stilb_render *render, stilb_render_shadow_map map, stilb_render_shadow of,
                                uint32_t filter)
{
	stilb_render_target target = {
		.name = "maps", .kind = STILB_RENDER_TARGET_DEPTH, .width = 16, .height = 16, .layers = 2};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -1.0f, 0.0f}, .intensity = {1.0f, 1.0f, 1.0f}};
	map.view_projection = stilb_mat4_identity();
	stilb_render_shadows shadows = {.target = &target, .maps = &map, .lights = &of, .map_count = 1, .filter = filter};
	stilb_render_pass pass = {0};
	stilb_render_view view = {
		.view_projection = stilb_mat4_identity(), .lights = &sun, .light_count = 1, .shadows = &shadows};
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	stilb_render_replay(render, &pass, 1, &view, 1, NULL, 0);
}

static void shadows(stilb_render *render)
{
	stilb_render_shadow_map whole = {.area = {0, 0, 16, 16}}, part = {.area = {0, 0, 8, 8}};
	contract_breaks("replay_area_is_sound", replay_with_area(render, STILB_RENDER_TARGET_LIGHT, 0, 0, 4));
	contract_breaks("replay_area_is_sound", replay_with_area(render, STILB_RENDER_TARGET_LIGHT, 1, 0, 0));
	contract_breaks("replay_area_is_sound", replay_with_area(render, STILB_RENDER_TARGET_DEPTH, 2, 0, 0));
	contract_breaks("replay_area_is_sound", replay_with_area(render, STILB_RENDER_TARGET_DEPTH, 1, 5, 4));
	contract_breaks("shadows_are_sound", replay_with_shadows(render, whole, (stilb_render_shadow){.map_count = 1},
	                                                         STILB_RENDER_MAX_SHADOW_FILTER + 1));
	contract_breaks("shadows_are_sound",
	                replay_with_shadows(render, (stilb_render_shadow_map){.layer = 2, .area = {0, 0, 16, 16}},
	                                    (stilb_render_shadow){.map_count = 1}, 2));
	contract_breaks("shadows_are_sound", replay_with_shadows(render, (stilb_render_shadow_map){.area = {0, 0, 4, 4}},
	                                                         (stilb_render_shadow){.map_count = 1}, 2));
	contract_breaks("shadow_is_sound", replay_with_shadows(render, whole, (stilb_render_shadow){.map_count = 2}, 2));
	contract_breaks("shadow_is_sound", replay_with_shadows(render, part, (stilb_render_shadow){.map_count = 1}, 2));
}

/* A frame of a view with one light, of which the caller has made something wrong. */
static void replay_lit(stilb_render *render, stilb_render_view view, stilb_scene_light light)
{
	stilb_render_pass pass = {0};
	view.view_projection = stilb_mat4_identity();
	view.shading = stilb_render_shading_default();
	view.lights = &light;
	view.light_count = 1;
	stilb_render_frame_begin(render);
	stilb_render_pass_begin(render, 0, 0);
	stilb_render_pass_end(render, 0);
	stilb_render_replay(render, &pass, 1, &view, 1, NULL, 0);
}

/* What only a program can get wrong of lights; what users type and files have is refused with a message. */
static void lights(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	stilb_scene_light good = {.kind = STILB_SCENE_LIGHT_POINT, .intensity = {1, 1, 1}}, bad = good;
	contract_breaks("light_tolerance", replay_lit(render, (stilb_render_view){.light_tolerance = -1.0f}, good));
	contract_breaks("light_tolerance", replay_lit(render, (stilb_render_view){.light_tolerance = NAN}, good));
	contract_breaks("light_fade", replay_lit(render, (stilb_render_view){.light_fade = -1.0f}, good));
	contract_breaks("stilb_render_light_peak", replay_lit(render, (stilb_render_view){.light_tolerance = 0.5f}, good));
	contract_breaks("scene && shading", stilb_render_light_peak(NULL, NULL) > 0.0f);
	bad.intensity[0] = NAN;
	contract_breaks("stilb_scene_light_mistake", replay_lit(render, (stilb_render_view){0}, bad));
	bad = good;
	bad.intensity[1] = -1.0f;
	contract_breaks("stilb_scene_light_mistake", replay_lit(render, (stilb_render_view){0}, bad));
	contract_breaks("lighting_is_known", stilb_render_prepare_view(render, &(stilb_render_view){.lighting = 99}));
	contract_breaks("way <", stilb_render_lighting_is_of_one_sample(STILB_RENDER_LIGHTING_WAYS));
	contract_breaks("texels", stilb_render_count_lights(NULL, 1).pixels);
	stilb_render_destroy(render);
}

static void order(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	contract_breaks("render->state == RENDER_FRAME_BEGUN", stilb_render_pass_begin(render, 0, 0));
	contract_breaks("render->state == RENDER_FRAME_REPLAYED", stilb_render_present(render));
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	contract_breaks("a pass is recorded once a frame", begin_twice(render, 3));
	contract_breaks("pass < 256", begin_twice(render, STILB_RENDER_MAX_PASSES));
	contract_breaks("every pass that was begun has ended", frame_inside_a_pass(render));
	contract_breaks("a segment is recorded once", same_segment_twice(render));
	contract_breaks("segment < lists->segment_count", segment_of_no_pass(render));
	contract_breaks("pass_end follows pass_begin", stilb_render_pass_end(render, 0));
	contract_breaks("every segment is recorded", replay_without_segment(render));
	contract_breaks("every replayed pass is recorded", replay(render, (stilb_render_pass){0}, 1));
	contract_breaks("pass->view < view_count", replay_with_wrong_view(render));
	static const stilb_render_target wrong[] = {
		{.name = NULL, .width = 8, .height = 8},
		{.name = "", .width = 8, .height = 8},
		{.name = "a name of forty-nine bytes, which is one too many", .width = 8, .height = 8},
		{.name = "wide", .width = 16385, .height = 8},
		{.name = "flat", .width = 8},
		{.name = "odd", .kind = (stilb_render_target_kind)2, .width = 8, .height = 8},
		{.name = "depth in the picture",
	     .kind = STILB_RENDER_TARGET_DEPTH,
	     .width = 8,
	     .height = 8,
	     .place = {0, 0, 8, 8}},
		{.name = "many", .kind = STILB_RENDER_TARGET_DEPTH, .width = 8, .height = 8, .layers = 257},
		{.name = "layers of light", .width = 8, .height = 8, .layers = 2},
	};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
		contract_breaks("replay_target_is_sound", replay_with_target(render, wrong[i]));
	shadows(render);
	contract_breaks("replay_lists_is_sound", replay_a_damaged_run(render));
	contract_breaks("!pass->sort", sorted_2d_pass(render));
	contract_breaks("worker < render->context_count", stilb_render_context_get(render, 1));
	stilb_render_destroy(render);
}

/* ---- draws and handles ------------------------------------------------------------------------------------------- */

static void mesh_destroy_twice(stilb_render *render, stilb_render_mesh mesh)
{
	stilb_render_mesh_destroy(render, mesh);
	stilb_render_mesh_destroy(render, mesh);
}

static void geometry(stilb_render_context *context)
{
	stilb_render_vertex_2d corners[3] = {0};
	stilb_render_geometry_2d(context, corners, 3, (uint32_t[]){0, 1, 3}, 3);
}

static void draws(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	stilb_render_mesh mesh = make_mesh(render), gone = make_mesh(render);
	stilb_render_material material = make_material(render);
	stilb_render_mesh_destroy(render, gone);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	contract_breaks("context->segment", draw(context, mesh, material, 1.0f));
	stilb_render_segment_begin(context, 0, 0);
	draw(context, mesh, material, 1.0f); /* a correct draw */
	contract_breaks("the transform is affine", draw(context, mesh, material, 2.0f));
	contract_breaks("a mesh that exists", draw(context, gone, material, 1.0f));
	contract_breaks("a mesh that exists", draw(context, (stilb_render_mesh){0}, material, 1.0f));
	contract_breaks("a material that exists", draw(context, mesh, (stilb_render_material){0}, 1.0f));
	contract_breaks("most < vertex_count", geometry(context));
	contract_breaks("texture.id != 0",
	                (stilb_render_draw_picture(context, (float[4]){0.0f, 0.0f, 9.0f, 9.0f},
	                                           (float[4]){0.0f, 0.0f, 9.0f, 9.0f}, (stilb_render_texture){0}, 1.0f, 0),
	                 0));
	contract_breaks("between frames", stilb_render_resize(render, 32, 32));
	contract_breaks("between frames", stilb_render_set_surface(render, NULL));
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	stilb_render_destroy(render);
}

static void handles(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX);
	stilb_render_mesh mesh = make_mesh(render);
	stilb_render_material out;
	contract_breaks("destroyed once", mesh_destroy_twice(render, mesh));
	contract_breaks("texture_is_valid", stilb_render_texture_destroy(render, (stilb_render_texture){1u << 24 | 1u}));
	contract_breaks("texture_is_valid",
	                stilb_render_material_create(render, &(stilb_scene_material){0}, (stilb_render_texture){5}, &out));
	contract_breaks("id < render->scene.mesh_count", stilb_render_scene_mesh(render, 0));
	stilb_render_destroy(render);
}

static void sets_of_ranges(void **state)
{
	(void)state;
	render_range touching[2] = {{0, 2}, {2, 1}};
	render_ranges ranges = {.items = touching, .count = 2, .capacity = 2};
	assert_false(render_ranges_is_sound(&ranges));
	touching[1].first = 3;
	assert_true(render_ranges_is_sound(&ranges));
	uint32_t first;
	contract_breaks("range.count > 0", render_ranges_add(&ranges, (render_range){9, 0}));
	contract_breaks("count > 0", render_ranges_take(&ranges, 0, &first));
	touching[1].first = 1;
	contract_breaks("render_ranges_is_sound(ranges)", render_ranges_take(&ranges, 1, &first));
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(creation), cmocka_unit_test(threads),        cmocka_unit_test(locks),
		cmocka_unit_test(order),    cmocka_unit_test(lights),         cmocka_unit_test(draws),
		cmocka_unit_test(handles),  cmocka_unit_test(sets_of_ranges),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
