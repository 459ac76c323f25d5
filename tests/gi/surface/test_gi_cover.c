/* What rays go through: texels that a mask cuts out, a share of what blends, the backs of what is one-sided; by single
 * rays, packets and shadow rays, of copies and instances, the same by Embree and by brute force. */

#include "gi/gi_path_fixture.h"
#include "gi/gi_render_fixture.h"
#include "gi_maps_fixture.h"

static const stilb_mat4 here = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
static const stilb_mat4 elsewhere = {{-1.5f, 0.5f, 0, 0, 0.5f, 1.5f, 0, 0, 0, 0, 2, 0, 0.3f, -0.2f, 1, 1}};

static const stilb_mat4 far_away = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 500, 0, 0, 1}};

#define CHECKS 8

static uint8_t check_texels[CHECKS][CHECKS][4];

/* White; alpha is 1 and 0 in turn. */
static stilb_image checkers(void)
{
	memset(check_texels, 255, sizeof check_texels);
	for (int y = 0; y < CHECKS; y++)
		for (int x = 0; x < CHECKS; x++)
			check_texels[y][x][3] = (x + y) % 2 ? 0 : 255;
	return (stilb_image){CHECKS, CHECKS, 4, STILB_IMAGE_U8_SRGB, check_texels, 0};
}

/* Alpha at (x, y) of the square; NaN: too near to an edge. */
static float check_at(double x, double y)
{
	double u = (0.5 + 0.5 * x) * CHECKS, v = (0.5 - 0.5 * y) * CHECKS;
	if (fabs(u - round(u)) < 1e-3 || fabs(v - round(v)) < 1e-3)
		return NAN;
	return ((int)u + (int)v) % 2 ? 0.0f : 1.0f;
}

static stilb_scene_surface checked(stilb_scene_alpha alpha)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.alpha = alpha;
	surface.ior = 1.0f;
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	surface.maps[STILB_SCENE_MAP_COLOR].nearest = true;
	return surface;
}

static world_fixture cover_trace(stilb_scene *scene, const stilb_gi_intersector *intersector, bool movable)
{
	world_fixture fixture = {.scene = scene};
	stilb_job_pool_desc pool = stilb_job_pool_desc_default();
	pool.worker_count = 0;
	assert_int_equal(stilb_job_pool_create(&pool, &fixture.pool), 0);
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = intersector, .movable = movable};
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &fixture.gi), STILB_OK);
	return fixture;
}

/* The distances that rays go, infinite for a miss, by single rays; packets of sixteen and shadow rays must agree. */
static void distances(const stilb_gi_scene *gi, const gi_ray_hit rays[16], float out[16])
{
	const gi_tracer *tracer = &gi->tracer;
	static gi_ray_hit16 packet;
	static int valid[16] __attribute__((aligned(64)));
	gi_ray shadows[16];
	memset(&packet, 0, sizeof packet);
	for (uint32_t i = 0; i < 16; i++) {
		const gi_ray *ray = &rays[i].ray;
		valid[i] = -1;
		shadows[i] = *ray;
		for (int k = 0; k < 3; k++) {
			packet.ray.origin[k][i] = ray->origin[k];
			packet.ray.direction[k][i] = ray->direction[k];
		}
		packet.ray.time[i] = ray->time;
		packet.ray.t_max[i] = ray->t_max;
		packet.ray.mask[i] = UINT32_MAX;
		packet.hit.part[i] = packet.hit.instance[i] = GI_NO_PART;
	}
	tracer->intersect16(tracer, valid, &packet);
	tracer->occluded(tracer, shadows, 16);
	for (uint32_t i = 0; i < 16; i++) {
		gi_ray_hit ray = rays[i];
		tracer->intersect(tracer, &ray);
		out[i] = gi_is_hit(&ray) ? ray.ray.t_max : INFINITY;
		assert_true(packet.hit.part[i] == ray.hit.part);
		SHADE_PROOF_NEAR(gi_is_hit(&ray) ? packet.ray.t_max[i] - out[i] : 0.0f, 0.0, 0.0, 1e-6);
		assert_int_equal(shadows[i].t_max < 0.0f, gi_is_hit(&ray));
	}
}

static stilb_vec3 moved(const stilb_mat4 *m, stilb_vec3 v, float place)
{
	stilb_vec3 out = {0};
	for (int i = 0; i < 3; i++)
		out[i] = m->m[i] * v[0] + m->m[4 + i] * v[1] + m->m[8 + i] * v[2] + m->m[12 + i] * place;
	return out;
}

/* ---- masks ------------------------------------------------------------------------------------------------------- */

static void masks_cut_texels_out(void **state)
{
	(void)state;
	stilb_image image = checkers();
	stilb_scene_surface surface = checked(STILB_SCENE_MASK);
	for (int i = 0; i < 16; i++) {
		bool second = __builtin_parity((unsigned)i); /* by the second uv; the first ones run the other way then */
		maps_square square;
		maps_square_make(&square, second ? -1.0f : 1.0f);
		surface.maps[STILB_SCENE_MAP_COLOR].set = second;
		bool brute = i & 1, movable = i & 2, behind = i & 4;
		const stilb_mat4 *place = i & 8 ? &elsewhere : &here;
		const stilb_gi_intersector *intersector = brute ? &stilb_gi_brute : &stilb_gi_embree;
		stilb_scene_surface solid = stilb_scene_surface_make(); /* the first part, far behind */
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_texture(build, &image);
		maps_add(build, &square.mesh, &solid, &far_away);
		maps_add(build, &square.mesh, &surface, place);
		world_fixture world = cover_trace(maps_end(build), intersector, movable);
		shade_proof_random random = {.seed = 4};
		uint32_t there = 0, count = 0;
		for (int batch = 0; batch < 64; batch++) {
			gi_ray_hit rays[16];
			float want[16], got[16];
			for (int k = 0; k < 16; k++) {
				float x = shade_proof_range(&random, -0.999f, 0.999f), y = shade_proof_range(&random, -0.999f, 0.999f);
				stilb_vec3 axis = stilb_vec3_make(0.2f, 0.1f, behind ? -1.0f : 1.0f);
				want[k] = check_at((double)x, (double)y);
				rays[k] = gi_ray_hit_make_by(moved(place, stilb_vec3_make(x, y, 0.0f) + axis, 1.0f),
				                             moved(place, -axis, 0.0f), shade_proof_uniform(&random));
			}
			distances(world.gi, rays, got);
			for (int k = 0; k < 16; k++)
				if (!isnan(want[k])) {
					assert_int_equal(isfinite(got[k]), want[k] == 1.0f);
					there += want[k] == 1.0f;
					count++;
				}
		}
		assert_in_range(there * 100 / count, 45, 55);
		world_finish(&world);
	}
}

/* Factor, vertices' alpha and texel are multiplied, and it is there from the cutoff on. */
static void masks_multiply(void **state)
{
	(void)state;
	static float texel[4] = {1.0f, 1.0f, 1.0f, 0.5f};
	stilb_image image = {1, 1, 4, STILB_IMAGE_F32_LINEAR, texel, 0};
	static const struct {
		float cutoff, factor, vertex;
		bool there;
	} rows[] = {{0.25f, 1.0f, 0.5f, true}, {0.2501f, 1.0f, 0.5f, false}, {0.2f, 0.5f, 0.75f, false},
	            {0.0f, 0.0f, 1.0f, true},  {0.6f, 1.0f, 1.0f, false},    {0.5f, 1.0f, 1.0f, true},
	            {2.0f, 1.0f, 1.0f, false}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		for (int kind = 0; kind < 3; kind++) { /* all three, the factor alone, factor and vertices */
			maps_square square;
			maps_square_make(&square, 1.0f);
			stilb_scene_surface surface = checked(STILB_SCENE_MASK);
			surface.cutoff = rows[i].cutoff;
			surface.color[3] = rows[i].factor * (kind > 0 ? 0.5f : 1.0f) * (kind == 1 ? rows[i].vertex : 1.0f);
			surface.maps[STILB_SCENE_MAP_COLOR].texture = kind == 0;
			for (int k = 0; k < 4 && kind != 1; k++)
				square.extras[k].color[3] = rows[i].vertex;
			world_fixture world = maps_trace(maps_scene(&square, &surface, &image, 1, &here), false);
			gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.1f, 0.2f, 1.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
			world.gi->tracer.intersect(&world.gi->tracer, &ray);
			assert_int_equal(gi_is_hit(&ray), rows[i].there);
			world_finish(&world);
		}
}

/* ---- blends ------------------------------------------------------------------------------------------------------ */

/* Three layers of alpha 0.5 in one part and one of 0.75 in another: their shares of rays are those of independent
 * choices, the same for each way of asking. */
static void blends_let_shares_through(void **state)
{
	(void)state;
	enum { RAYS = 160000 };
	stilb_scene_vertex vertices[12];
	uint32_t indices[18];
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (uint32_t layer = 0; layer < 3; layer++) {
		for (uint32_t i = 0; i < 4; i++) {
			vertices[4 * layer + i] = square.vertices[i];
			vertices[4 * layer + i].position[2] = -(float)layer;
		}
		for (uint32_t i = 0; i < 6; i++)
			indices[6 * layer + i] = square.indices[i] + 4 * layer;
	}
	stilb_scene_mesh layers = {.vertices = vertices, .indices = indices, .vertex_count = 12, .index_count = 18};
	static const stilb_mat4 behind = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -3, 1}};
	stilb_scene_surface half = stilb_scene_surface_make(), most = half;
	half.alpha = most.alpha = STILB_SCENE_BLEND;
	half.color[3] = 0.5f;
	most.color[3] = 0.75f;
	uint32_t found[2][5] = {{0}};
	for (int brute = 0; brute < 2; brute++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		maps_add(build, &layers, &half, &here);
		maps_add(build, &square.mesh, &most, &behind);
		world_fixture world = cover_trace(maps_end(build), brute ? &stilb_gi_brute : &stilb_gi_embree, false);
		assert_true(world.gi->blends);
		shade_proof_random random = {.seed = 6};
		for (int batch = 0; batch < RAYS / 16; batch++) {
			gi_ray_hit rays[16];
			float got[16];
			for (int k = 0; k < 16; k++)
				rays[k] = gi_ray_hit_make_by(stilb_vec3_make(0.3f, 0.1f, 1.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f),
				                             shade_proof_uniform(&random));
			distances(world.gi, rays, got);
			for (int k = 0; k < 16; k++) {
				long layer = isfinite(got[k]) ? lrintf(got[k]) - 1 : 4;
				assert_in_range(layer, 0, 4);
				found[brute][layer]++;
			}
		}
		world_finish(&world);
	}
	static const double shares[5] = {0.5, 0.25, 0.125, 0.125 * 0.75, 0.125 * 0.25};
	for (int i = 0; i < 5; i++) {
		double sigma = sqrt(shares[i] * (1.0 - shares[i]) / RAYS);
		SHADE_PROOF_NEAR((float)found[0][i] / RAYS, shares[i], 0.0, 5.0 * sigma);
		assert_int_equal(found[0][i], found[1][i]);
	}
}

/* The picture of a square of alpha 0.3 before another, both unlit, by the camera's own numbers. */
static void blends_mix_pictures(void **state)
{
	(void)state;
	static const stilb_mat4 behind = {{9, 0, 0, 0, 0, 9, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1}};
	static const stilb_gi_sampler_kind samplers[] = {STILB_GI_SAMPLER_RANDOM, STILB_GI_SAMPLER_SOBOL,
	                                                 STILB_GI_SAMPLER_STRATIFIED, STILB_GI_SAMPLER_BLUE_NOISE};
	stilb_scene_surface front = stilb_scene_surface_make(), back = front;
	front.unlit = back.unlit = true;
	front.alpha = STILB_SCENE_BLEND;
	front.color[3] = 0.3f;
	back.color[0] = 0.2f;
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_camera camera = {.position = {0.0f, 0.0f, 5.0f}, .fov_y = 0.3f, .near_z = 0.1f, .far_z = 100.0f};
	maps_add(build, &square.mesh, &front, &here);
	maps_add(build, &square.mesh, &back, &behind);
	stilb_scene_build_camera(build, &camera);
	world_fixture world = cover_trace(maps_end(build), &stilb_gi_embree, false);
	render_fixture fixture = {.pool = world.pool, .scene = world.scene, .gi = world.gi};
	for (size_t i = 0; i < sizeof samplers / sizeof *samplers; i++) {
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.width = settings.height = 33;
		settings.samples = 16;
		settings.sampler = samplers[i];
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		stilb_gi_film film = stilb_gi_render_film(render);
		double sum = 0.0, square_sum = 0.0, count = 33.0 * 33.0;
		for (uint32_t p = 0; p < 33 * 33; p++) {
			double x = (double)film.radiance[3 * p];
			sum += x / count;
			square_sum += x * x / count;
		}
		double sigma = 0.8 * sqrt(0.3 * 0.7 / (count * 16.0)), spread = sqrt(square_sum - sum * sum);
		SHADE_PROOF_NEAR((float)sum, 0.3 + 0.7 * 0.2, 0.0, 5.0 * sigma);
		assert_true(spread > 0.3 * sigma * sqrt(count)); /* pixels choose for themselves */
		stilb_gi_render_destroy(render);
	}
	world_finish(&world);
}

/* In a furnace white squares of any alpha change nothing: L = 1 / (1 - 0.5) everywhere. */
static void furnaces_with_alpha(void **state)
{
	(void)state;
	static const stilb_mat4 tilted = {{0.4f, 0, 0.3f, 0, 0, 0.5f, 0, 0, -0.3f, 0, 0.4f, 0, 0, 0, 0, 1}};
	stilb_image image = checkers();
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_mesh ball;
	for (int alpha = STILB_SCENE_MASK; alpha <= STILB_SCENE_BLEND; alpha++) {
		stilb_scene_surface surface = checked((stilb_scene_alpha)alpha);
		surface.color[3] = 0.75f;
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_texture(build, &image);
		maps_add(build, &square.mesh, &surface, &tilted);
		assert_int_equal(stilb_scene_mesh_sphere(3, &ball), STILB_OK);
		for (uint32_t i = 0; i + 2 < ball.index_count; i += 3) { /* its front is inside */
			uint32_t second = ball.indices[i + 1];
			ball.indices[i + 1] = ball.indices[i + 2];
			ball.indices[i + 2] = second;
		}
		stilb_scene_material shining = {.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f, .emission = {1, 1, 1}};
		stilb_scene_build_part part = {stilb_scene_build_mesh(build, &ball),
		                               stilb_scene_build_material(build, &shining)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
		stilb_scene_camera camera = {.position = {0, 0, 0.8f}, .fov_y = 1.2f, .near_z = 0.01f, .far_z = 10};
		stilb_scene_build_camera(build, &camera);
		path_fixture fixture = path_fixture_make(maps_end(build));
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 24, 16);
		path_mean mean = path_picture_mean(&view);
		SHADE_PROOF_NEAR((float)path_mean_of(&mean, 0), 2.0, 0.0, 5.0 * path_mean_error(&mean, 0) + 1e-4);
		assert_true(path_mean_error(&mean, 0) < 0.02);
		path_fixture_finish(&fixture);
		stilb_scene_mesh_finish(&ball);
	}
}

/* ---- integrators ------------------------------------------------------------------------------------------------- */

/* The mean radiance of a floor below a black roof of this alpha, which covers all that the floor sees: an open sky, or,
 * for indirect light, a ceiling with a lamp below it. */
static double floor_below_a_roof(float alpha, stilb_gi_integrator integrator, stilb_gi_only only)
{
	static const stilb_mat4 roof = {{90, 0, 0, 0, 0, 90, 0, 0, 0, 0, -1, 0, 0, 0, 0.5f, 1}};
	static const stilb_mat4 ceiling = {{3, 0, 0, 0, 0, 3, 0, 0, 0, 0, -1, 0, 0, 0, 2, 1}};
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface black = stilb_scene_surface_make(), floor = black;
	black.color[0] = black.color[1] = black.color[2] = 0.0f;
	black.ior = 1.0f;
	black.alpha = STILB_SCENE_BLEND;
	black.color[3] = alpha;
	floor.metalness = only == STILB_GI_ONLY_INDIRECT ? 0.0f : 0.5f;
	floor.roughness = 0.5f;
	floor.ior = only == STILB_GI_ONLY_INDIRECT ? 1.0f : 1.5f;
	stilb_scene_build *build = stilb_scene_build_begin();
	maps_add(build, &square.mesh, &floor, &here);
	maps_add(build, &square.mesh, &black, &roof);
	stilb_scene_surroundings sky = {.sky = {1, 1, 1}, .ground = {1, 1, 1}};
	stilb_scene_light lamp = {.kind = STILB_SCENE_LIGHT_POINT, .position = {0.2f, 0.1f, 1.5f}, .intensity = {1, 1, 1}};
	if (only == STILB_GI_ONLY_INDIRECT) {
		maps_add(build, &square.mesh, &floor, &ceiling);
		stilb_scene_build_light(build, &lamp);
	} else {
		stilb_scene_build_surroundings(build, &sky);
	}
	stilb_scene_camera camera = {.position = {0, 0, 0.4f}, .fov_y = 0.8f, .near_z = 0.01f, .far_z = 10};
	stilb_scene_build_camera(build, &camera);
	world_fixture world = cover_trace(maps_end(build), &stilb_gi_embree, false);
	render_fixture fixture = {.pool = world.pool, .scene = world.scene, .gi = world.gi};
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.width = settings.height = 16;
	settings.samples = 128;
	settings.integrator = integrator;
	settings.only = only;
	settings.depth = 2;
	settings.ao_distance = 0.0f;
	settings.cache.rays = 4096;
	settings.cache.error = 0.05f;
	settings.cache.gradients = false; /* of records of so few rays they are noise */
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	stilb_gi_film film = stilb_gi_render_film(render);
	double sum = 0.0;
	for (uint32_t p = 0; p < 256; p++)
		sum += (double)film.radiance[3 * p] / 256.0;
	stilb_gi_render_destroy(render);
	world_finish(&world);
	return sum;
}

/* A roof of 0.3 lets 0.7 of the light through, for every integrator. Not a half: one of its two triangles would be
 * that. */
static void roofs_let_their_share_through(void **state)
{
	(void)state;
	static const struct {
		stilb_gi_integrator integrator;
		stilb_gi_only only;
		double bound;
	} rows[] = {{STILB_GI_INTEGRATOR_PATH, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_DIRECT, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_AO, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_MONTECARLO, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_SPLIT, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_IRRADIANCE_CACHE, STILB_GI_ALL_LIGHT, 0.01},
	            {STILB_GI_INTEGRATOR_PATH, STILB_GI_ONLY_INDIRECT, 0.02},
	            {STILB_GI_INTEGRATOR_IRRADIANCE_CACHE, STILB_GI_ONLY_INDIRECT, 0.04}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		double open = floor_below_a_roof(0.0f, rows[i].integrator, rows[i].only);
		double less = floor_below_a_roof(0.3f, rows[i].integrator, rows[i].only);
		assert_true(open > 0.01);
		SHADE_PROOF_NEAR((float)(less / open), 0.7, rows[i].bound, 0.0);
	}
}

/* ---- backs ------------------------------------------------------------------------------------------------------- */

static void backs_are_not_there(void **state)
{
	(void)state;
	stilb_scene_surface surface = stilb_scene_surface_make();
	maps_square square;
	maps_square_make(&square, 1.0f);
	for (int i = 0; i < 32; i++) {
		bool brute = i & 1, movable = i & 2, behind = i & 4, one_sided = i & 16;
		const stilb_mat4 *place = i & 8 ? &elsewhere : &here; /* mirrored */
		surface.one_sided = one_sided;
		world_fixture world = cover_trace(maps_scene(&square, &surface, NULL, 0, place),
		                                  brute ? &stilb_gi_brute : &stilb_gi_embree, movable);
		stilb_vec3 axis = stilb_vec3_make(0.1f, 0.2f, behind ? -1.0f : 1.0f);
		gi_ray_hit rays[16];
		float got[16];
		for (int k = 0; k < 16; k++)
			rays[k] = gi_ray_hit_make(moved(place, axis * (1.0f + 0.1f * (float)k), 1.0f), moved(place, -axis, 0.0f));
		distances(world.gi, rays, got);
		for (int k = 0; k < 16; k++)
			assert_int_equal(isfinite(got[k]), !(one_sided && behind));
		world_finish(&world);
	}
}

/* ---- updates and workers ----------------------------------------------------------------------------------------- */

/* After an edit of alpha, cutoff or sides rays go through the surface where it is not there, and nowhere else. */
static void updates_change_what_rays_go_through(void **state)
{
	(void)state;
	stilb_image image = checkers();
	maps_square square;
	maps_square_make(&square, 1.0f);
	stilb_scene_surface surface = checked(STILB_SCENE_OPAQUE);
	for (int movable = 0; movable < 2; movable++) {
		world_fixture world = cover_trace(maps_scene(&square, &surface, &image, 1, &here), &stilb_gi_embree, movable);
		stilb_gi_scene_desc desc = {.pool = world.pool, .intersector = &stilb_gi_embree, .movable = movable};
		for (int step = 0; step < 5; step++) {
			stilb_scene_surface *s = &world.scene->surfaces[0];
			s->alpha = step == 1 || step == 2 ? STILB_SCENE_MASK : step == 3 ? STILB_SCENE_BLEND : STILB_SCENE_OPAQUE;
			s->cutoff = step == 2 ? 0.0f : 0.5f;
			s->one_sided = step == 4;
			assert_int_equal(stilb_gi_scene_update(world.gi, world.scene, &desc), STILB_OK);
			assert_int_equal(world.gi->blends, step == 3);
			gi_ray_hit hole = gi_ray_hit_make(stilb_vec3_make(0.05f, 0.1f, step == 4 ? -1.0f : 1.0f),
			                                  stilb_vec3_make(0.0f, 0.0f, step == 4 ? 1.0f : -1.0f));
			assert_true(check_at(0.05, 0.1) == 0.0f);
			world.gi->tracer.intersect(&world.gi->tracer, &hole);
			assert_int_equal(gi_is_hit(&hole), step == 0 || step == 2);
		}
		world_finish(&world);
	}
}

static void same_bits_for_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	static const stilb_gi_integrator integrators[] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_AO,
	                                                  STILB_GI_INTEGRATOR_MONTECARLO,
	                                                  STILB_GI_INTEGRATOR_IRRADIANCE_CACHE};
	static const stilb_mat4 floor = {{3, 0, 0, 0, 0, 0, -3, 0, 0, 1, 0, 0, 0, -1, 0, 1}};
	stilb_image image = checkers();
	stilb_scene_surface surface = checked(STILB_SCENE_BLEND), white = stilb_scene_surface_make();
	surface.maps[STILB_SCENE_MAP_COLOR].nearest = false;
	surface.color[3] = 0.6f;
	maps_square square;
	maps_square_make(&square, 1.0f);
	uint64_t first[4] = {0};
	for (size_t w = 0; w < sizeof workers / sizeof *workers; w++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		stilb_scene_build_texture(build, &image);
		maps_add(build, &square.mesh, &surface, &here);
		maps_add(build, &square.mesh, &white, &floor);
		stilb_scene_surroundings sky = {.sky = {1, 1, 1}};
		stilb_scene_build_surroundings(build, &sky);
		world_fixture world = world_trace(maps_end(build), &stilb_gi_embree, workers[w]);
		render_fixture fixture = {.pool = world.pool, .scene = world.scene, .gi = world.gi};
		for (int i = 0; i < 4; i++) {
			stilb_gi_settings settings = render_fixture_settings(&fixture);
			settings.integrator = integrators[i];
			settings.depth = 2;
			uint64_t hash = render_whole(&fixture, &settings);
			first[i] = w == 0 ? hash : first[i];
			assert_true(hash == first[i]);
		}
		render_fixture_finish(&fixture);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(masks_cut_texels_out),      cmocka_unit_test(masks_multiply),
		cmocka_unit_test(blends_let_shares_through), cmocka_unit_test(blends_mix_pictures),
		cmocka_unit_test(furnaces_with_alpha),       cmocka_unit_test(roofs_let_their_share_through),
		cmocka_unit_test(backs_are_not_there),       cmocka_unit_test(updates_change_what_rays_go_through),
		cmocka_unit_test(same_bits_for_workers),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
