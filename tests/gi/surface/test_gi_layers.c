/* What rays find of clear coat, sheen, brushing and transmission: factors times texels at a hit. */

#include "gi/gi_path_fixture.h"
#include "gi/gi_render_fixture.h"
#include "gi_maps_fixture.h"

#include "shading/shade_layers.h"

static const stilb_mat4 here = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

/* ---- what is read ------------------------------------------------------------------------------------------------ */

/* Each factor times the channel of its map that counts, of one texel with four different channels. */
static void factors_times_texels(void **state)
{
	(void)state;
	float texel[4] = {0.5f, 0.25f, 0.75f, 0.125f};
	stilb_image image = {1, 1, 4, STILB_IMAGE_F32_LINEAR, texel, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.clearcoat = 0.9f;
	surface.clearcoat_roughness = 0.8f;
	surface.sheen_roughness = 0.7f;
	surface.anisotropy = 0.6f;
	for (int i = 0; i < 3; i++) {
		surface.sheen_color[i] = 0.5f;
		surface.emission[i] = 2.0f;
	}
	for (int mapped = 0; mapped < 2; mapped++) {
		for (int kind = STILB_SCENE_MAP_CLEARCOAT; mapped && kind < STILB_SCENE_MAPS; kind++)
			surface.maps[kind].texture = kind == STILB_SCENE_MAP_CLEARCOAT_NORMAL ? 0 : 1;
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
		gi_surface at = maps_at_point(world.gi, 0.3f, 0.2f);
		assert_true(at.layered);
		const gi_layers *layers = &at.layers;
		float one[4] = {1.0f, 1.0f, 1.0f, 1.0f}, *t = mapped ? texel : one;
		SHADE_PROOF_NEAR(layers->coat, (double)(0.9f * t[0]), 1e-6, 0.0);
		SHADE_PROOF_NEAR(layers->coat_roughness, (double)(0.8f * t[1]), 1e-6, 0.0);
		SHADE_PROOF_NEAR(layers->sheen_roughness, (double)(0.7f * t[3]), 1e-6, 0.0);
		SHADE_PROOF_NEAR3(layers->sheen, 0.5 * (double)t[0], 0.5 * (double)t[1], 0.5 * (double)t[2], 1e-6, 0.0);
		SHADE_PROOF_NEAR(layers->anisotropy, (double)(0.6f * t[2]), 1e-6, 0.0);
		SHADE_PROOF_NEAR(at.emission[0], 2.0 * (double)(1.0f - shade_coat_share(0.9f * t[0], 1.0f)), 1e-6, 0.0);
		world_finish(&world);
	}
}

/* Without layers, or with all factors 0, nothing is layered. */
static void nothing_of_factors_0(void **state)
{
	(void)state;
	float texel[4] = {1.0f, 1.0f, 1.0f, 1.0f};
	stilb_image image = {1, 1, 4, STILB_IMAGE_F32_LINEAR, texel, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = stilb_scene_surface_make();
	for (int kind = 0; kind < STILB_SCENE_MAPS; kind++)
		surface.maps[kind].texture = 1;
	world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
	assert_false(maps_at_point(world.gi, 0.3f, 0.2f).layered);
	world_finish(&world);
}

/* The coat has the mesh's normal where the base has a map of its own, and its own map's where it has one. */
static void normals_of_coats(void **state)
{
	(void)state;
	static const float tilt[3] = {0.36f, 0.48f, 0.8f};
	float texel[3] = {0.5f + 0.5f * tilt[0], 0.5f + 0.5f * tilt[1], 0.5f + 0.5f * tilt[2]};
	stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (int i = 0; i < 4; i++) {
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.clearcoat = 1.0f;
		surface.maps[STILB_SCENE_MAP_NORMAL].texture = i & 1;
		surface.maps[STILB_SCENE_MAP_CLEARCOAT_NORMAL].texture = i >> 1;
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
		gi_surface at = maps_at_point(world.gi, 0.3f, 0.2f);
		SHADE_PROOF_NEAR(at.normal[0], i & 1 ? (double)tilt[0] : 0.0, 0.0, 2e-6);
		SHADE_PROOF_NEAR(at.layers.coat_normal[0], i >> 1 ? (double)tilt[0] : 0.0, 0.0, 2e-6);
		SHADE_PROOF_NEAR(at.layers.coat_normal[1], i >> 1 ? (double)tilt[1] : 0.0, 0.0, 2e-6);
		world_finish(&world);
	}
}

/* The direction of brushing is turned from the tangent by the rotation and by the map, on squares of every place,
 * mirrored or not, from both sides; without tangents it is that of frames. */
static void directions_of_brushing(void **state)
{
	(void)state;
	static const float angles[2] = {0.5f, 1.1f}; /* of the factor, of the map */
	float texel[3] = {0.5f + 0.5f * cosf(angles[1]), 0.5f + 0.5f * sinf(angles[1]), 1.0f};
	stilb_image image = {1, 1, 3, STILB_IMAGE_F32_LINEAR, texel, 0};
	for (int i = 0; i < 32; i++) {
		float sign = i & 1 ? -1.0f : 1.0f;
		bool mapped = i & 2, behind = i & 4, movable = i & 8, bare = i & 16;
		maps_square square;
		maps_square_make(&square, sign);
		square.mesh.extras = bare ? NULL : square.extras;
		stilb_scene_surface surface = stilb_scene_surface_make();
		surface.anisotropy = 1.0f;
		surface.anisotropy_rotation = angles[0];
		surface.maps[STILB_SCENE_MAP_ANISOTROPY].texture = mapped;
		stilb_mat4 place = {{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0.5f, 0, 0, 1}};
		world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &place), movable);
		float side = behind ? -1.0f : 1.0f, angle = angles[0] + (mapped ? angles[1] : 0.0f);
		gi_surface at = maps_look(world.gi, stilb_vec3_make(0.3f, 0.2f, side), stilb_vec3_make(0.0f, 0.0f, -side));
		stilb_vec3 got = stilb_vec3_normalize(at.layers.brushed);
		/* u runs along sign X; the bitangent is cross(normal, tangent) times the sign, +Y; bare: tangent sideways X */
		double x = bare ? (double)side : (double)sign, y = bare ? (double)side : 1.0;
		SHADE_PROOF_NEAR3(got, x * cos((double)angle), y * sin((double)angle), 0.0, 0.0, 1e-5);
		world_finish(&world);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(factors_times_texels),
		cmocka_unit_test(nothing_of_factors_0),
		cmocka_unit_test(normals_of_coats),
		cmocka_unit_test(directions_of_brushing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
