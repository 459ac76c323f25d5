/* What rays find of clear coat, sheen, brushing and transmission: factors times texels at a hit. */

#include "gi/gi_path_fixture.h"
#include "gi/gi_render_fixture.h"
#include "gi_maps_fixture.h"

#include "gi/trace/gi_through.h"
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

/* ---- what goes through ------------------------------------------------------------------------------------------- */

/* Adds a square of this surface at height z, facing up or down, its side so many metres. */
static void add_square(stilb_scene_build *build, const stilb_scene_surface *surface, float z, bool up, float side)
{
	maps_square square;
	maps_square_make(&square, 1.0f);
	float s = 0.5f * side, turn = up ? s : -s;
	stilb_mat4 place = {{s, 0, 0, 0, 0, turn, 0, 0, 0, 0, turn, 0, 0, 0, z, 1}};
	maps_add(build, &square.mesh, surface, &place);
}

static stilb_scene_surface glass(float roughness, float ior, float thickness)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.transmission = 1.0f;
	surface.roughness = roughness;
	surface.ior = ior;
	surface.thickness = thickness;
	surface.one_sided = thickness > 0.0f; /* as most files are */
	return surface;
}

/* What the integrator sees along one ray: mean and error of n samples, by samples of the camera's ray in it. */
static path_mean seen_along(const path_fixture *fixture, stilb_gi_integrator integrator, stilb_vec3 origin,
                            stilb_vec3 direction, uint32_t n)
{
	gi_view view = path_view(fixture, integrator, 16, n);
	path_samples *samples = stilb_memory_alloc(1, sizeof *samples);
	path_mean mean = {.count = 0};
	assert_non_null(samples);
	view.settings.rays = 1;
	for (uint32_t first = 0; first < n; first += GI_BATCH) {
		stilb_vec3 left[GI_BATCH];
		uint64_t traced = 0;
		samples->count = n - first < GI_BATCH ? n - first : GI_BATCH;
		for (uint32_t i = 0; i < samples->count; i++) {
			samples->points[i] = gi_sampler_point(&view.sampler, 3, 5, first + i);
			float chance = gi_sample_2d(&view.sampler, samples->points[i], GI_DIMENSION_SEEN)[0];
			samples->rays[i] = gi_ray_hit_make_by(origin, stilb_vec3_normalize(direction), chance);
			left[i] = gi_through_intersect(view.scene, &samples->rays[i], &traced);
		}
		path_samples_shade(&view, samples);
		for (uint32_t i = 0; i < samples->count; i++)
			path_mean_add(&mean, samples->radiance[i] * left[i]);
	}
	free(samples);
	return mean;
}

static const float white_sky[3] = {1.0f, 1.0f, 1.0f};

/* In a white world white glass is white: panes, frosted walls, volumes of several indices, seen at several angles, by
 * all integrators. It is white behind what absorbs nothing because each lobe's share is right and no ray is lost. */
static void white_glass_in_a_white_world(void **state)
{
	(void)state;
	static const stilb_gi_integrator integrators[] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_MONTECARLO};
	static const struct {
		float roughness, ior, thickness;
		double
			least; /* roughness loses what facets shadow, an index of 1 the highlight that it has at grazing angles */
	} rows[] = {{0.0f, 1.5f, 0.0f, 0.999}, {0.3f, 1.5f, 0.0f, 0.97}, {0.0f, 1.5f, 1.0f, 0.99},
	            {0.0f, 1.0f, 1.0f, 0.99},  {0.0f, 2.4f, 1.0f, 0.98}, {0.3f, 1.5f, 1.0f, 0.9}};
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		stilb_scene_surface surface = glass(rows[r].roughness, rows[r].ior, rows[r].thickness);
		stilb_scene_build *build = stilb_scene_build_begin();
		add_square(build, &surface, 0.0f, true, 1000.0f);
		if (rows[r].thickness > 0.0f)
			add_square(build, &surface, -1.0f, false, 1000.0f);
		stilb_scene *scene = maps_end(build);
		stilb_scene_set_sky(scene, white_sky);
		path_fixture fixture = path_fixture_make(scene);
		for (int i = 0; i < 6; i++) {
			stilb_vec3 from = stilb_vec3_make(0.5f * (float)(i / 2), 0.0f, 1.0f);
			path_mean mean = seen_along(&fixture, integrators[i % 2], from, -from, 4096);
			double off = path_mean_of(&mean, 0) - 1.0, sigma = path_mean_error(&mean, 0);
			if (off > 4.5 * sigma + 1e-4 || off < rows[r].least - 1.0 - 4.5 * sigma)
				fail_msg("roughness %g, index %g, thickness %g, view %d: %g +- %g", (double)rows[r].roughness,
				         (double)rows[r].ior, (double)rows[r].thickness, i, off + 1.0, sigma);
		}
		path_fixture_finish(&fixture);
	}
}

/* A slab of an index of about 1 leaves of the light behind it what Beer's law says of the way inside, also of a slab
 * that is one-sided, and scaled. */
static void volumes_absorb(void **state)
{
	(void)state;
	stilb_scene_surface surface = glass(0.0f, 1.0f, 1.0f);
	surface.attenuation[0] = 0.5f;
	surface.attenuation[1] = 0.25f;
	surface.attenuation_distance = 2.0f;
	for (int i = 0; i < 4; i++) {
		float slant = 0.75f * (float)(i % 2), depth = i < 2 ? 1.0f : 3.0f;
		stilb_scene_build *build = stilb_scene_build_begin();
		add_square(build, &surface, 0.0f, true, 100.0f);
		add_square(build, &surface, -depth, false, 100.0f);
		stilb_scene *scene = maps_end(build);
		stilb_scene_set_sky(scene, white_sky);
		path_fixture fixture = path_fixture_make(scene);
		path_mean mean = seen_along(&fixture, STILB_GI_INTEGRATOR_PATH, stilb_vec3_make(0.0f, 0.0f, 2.0f),
		                            stilb_vec3_make(slant, 0.0f, -1.0f), 256);
		double way = (double)depth * sqrt(1.0 + (double)(slant * slant));
		SHADE_PROOF_NEAR(path_mean_of(&mean, 0), pow(0.5, way / 2.0), 5e-3, 0.0);
		SHADE_PROOF_NEAR(path_mean_of(&mean, 1), pow(0.25, way / 2.0), 5e-3, 0.0);
		SHADE_PROOF_NEAR(path_mean_of(&mean, 2), 1.0, 5e-3, 0.0);
		path_fixture_finish(&fixture);
	}
}

/* A white floor under panes, in the light of a directional light and of the sky, seen through them: each pane leaves
 * its tint times what its facets let through, on the way to the light and on the way to the eye, and the sky's light
 * does the same by chance. direct is path of depth 1. */
static void panes_tint(void **state)
{
	(void)state;
	for (int i = 0; i < 8; i++) {
		bool sky = i & 1, direct = i & 2;
		int panes = 1 + (i >> 2);
		stilb_scene_surface floor = stilb_scene_surface_make(), surface = glass(0.0f, 1.0f, 0.0f);
		floor.specular_weight = 0.0f;
		surface.color[0] = 0.5f;
		surface.color[1] = 0.25f;
		stilb_scene_build *build = stilb_scene_build_begin();
		add_square(build, &floor, 0.0f, true, 1000.0f);
		for (int k = 0; k < panes; k++)
			add_square(build, &surface, 0.5f + 0.25f * (float)k, k % 2 == 0, 1000.0f);
		stilb_scene_light sun = {
			.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, 0.0f, -1.0f}, .intensity = {M_PI, M_PI, M_PI}};
		if (!sky)
			stilb_scene_build_light(build, &sun);
		stilb_scene *scene = maps_end(build);
		stilb_scene_set_sky(scene, sky ? white_sky : (float[3]){0});
		path_fixture fixture = path_fixture_make(scene);
		path_mean mean = seen_along(&fixture, direct ? STILB_GI_INTEGRATOR_DIRECT : STILB_GI_INTEGRATOR_PATH,
		                            stilb_vec3_make(0.0f, 0.0f, 2.0f), stilb_vec3_make(0.2f, 0.0f, -1.0f), 16384);
		for (int c = 0; c < 3; c++) {
			/* an index of 1 reflects at grazing angles only, by Schlick's term: 1 / 21 of the sky, by the cosine */
			double tint = c == 0 ? 0.5 : c == 1 ? 0.25 : 1.0, left = sky ? 1.0 - 1.0 / 21.0 : 1.0;
			double wanted = pow(tint, 2 * panes) * (panes == 1 ? left : left * left + 0.01);
			SHADE_PROOF_NEAR(path_mean_of(&mean, c), wanted, 0.06, 4.5 * path_mean_error(&mean, c));
		}
		path_fixture_finish(&fixture);
	}
}

/* Light that is found by asking, by chance, and weighed of both is the same behind frosted glass: path and montecarlo,
 * which only looks; and a lamp without size, which is asked through it. */
static void frosted_glass_by_two_ways(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		stilb_scene_surface surface = glass(i & 1 ? 0.8f : 0.5f, 1.5f, 0.0f), lamp = stilb_scene_surface_make();
		surface.color[1] = 0.5f;
		surface.transmission = 0.75f;
		lamp.emission[0] = lamp.emission[1] = lamp.emission[2] = 4.0f;
		for (int c = 0; c < 3; c++)
			lamp.color[c] = 0.0f;
		lamp.ior = 1.0f;
		stilb_scene_build *build = stilb_scene_build_begin();
		add_square(build, &surface, 0.0f, true, 1000.0f);
		add_square(build, &lamp, i & 2 ? 0.7f : -0.7f, !(i & 2), 1.0f);
		stilb_scene *scene = maps_end(build);
		stilb_scene_set_sky(scene, (float[3]){0.1f, 0.1f, 0.1f});
		path_fixture fixture = path_fixture_make(scene);
		stilb_vec3 from = stilb_vec3_make(0.9f, 0.3f, 1.0f), to = stilb_vec3_make(-0.6f, -0.3f, -1.0f);
		path_mean asked = seen_along(&fixture, STILB_GI_INTEGRATOR_PATH, from, to, 8192);
		path_mean found = seen_along(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, from, to, 65536);
		path_mean direct = seen_along(&fixture, STILB_GI_INTEGRATOR_DIRECT, from, to, 8192);
		for (int c = 0; c < 2; c++) {
			double sigma = hypot(path_mean_error(&asked, c), path_mean_error(&found, c));
			double off = path_mean_of(&asked, c) - path_mean_of(&found, c);
			if (fabs(off) > 4.5 * sigma || fabs(sigma) > 0.03 * path_mean_of(&found, c))
				fail_msg("%d, channel %d: %g asked, %g found, +- %g", i, c, path_mean_of(&asked, c),
				         path_mean_of(&found, c), sigma);
			SHADE_PROOF_NEAR(path_mean_of(&direct, c), path_mean_of(&asked, c), 0.0,
			                 4.5 * hypot(path_mean_error(&asked, c), path_mean_error(&direct, c)));
		}
		path_fixture_finish(&fixture);
	}
}

/* What a coat leaves of a lamp's light, most of which goes aside, is the same asked and found. */
static void coated_lamps(void **state)
{
	(void)state;
	for (int i = 0; i < 2; i++) {
		stilb_scene_surface floor = stilb_scene_surface_make(), lamp = stilb_scene_surface_make();
		floor.specular_weight = 0.0f;
		for (int c = 0; c < 3; c++) {
			lamp.emission[c] = 1.0f;
			lamp.color[c] = 0.0f;
		}
		lamp.ior = 1.0f;
		lamp.clearcoat = (float)i;
		stilb_scene_build *build = stilb_scene_build_begin();
		add_square(build, &floor, 0.0f, true, 1000.0f);
		add_square(build, &lamp, 1.0f, false, 1000.0f);
		stilb_scene *scene = maps_end(build);
		stilb_scene_set_sky(scene, (float[3]){0});
		path_fixture fixture = path_fixture_make(scene);
		stilb_vec3 from = stilb_vec3_make(0.0f, 0.0f, 0.5f), to = stilb_vec3_make(0.0f, 0.0f, -1.0f);
		double coat = i ? 0.04 + 0.96 / 21.0 : 0.0; /* by the cosine */
		path_mean asked = seen_along(&fixture, STILB_GI_INTEGRATOR_DIRECT, from, to, 16384);
		SHADE_PROOF_NEAR(path_mean_of(&asked, 0), 1.0 - coat, 2e-3, 4.5 * path_mean_error(&asked, 0));
		path_fixture_finish(&fixture);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(factors_times_texels),
		cmocka_unit_test(nothing_of_factors_0),
		cmocka_unit_test(normals_of_coats),
		cmocka_unit_test(directions_of_brushing),
		cmocka_unit_test(white_glass_in_a_white_world),
		cmocka_unit_test(volumes_absorb),
		cmocka_unit_test(panes_tint),
		cmocka_unit_test(frosted_glass_by_two_ways),
		cmocka_unit_test(coated_lamps),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
