/* Embree behind gi_tracer against every triangle tested in double: triangles of the world and of instances, single
 * rays, packets and streams; and the same hits however many workers built the tree. */

#include "gi/film/gi_camera.h"
#include "gi_world_fixture.h"
#include "scene/scene_pick.h"

/* The address sanitizer sees the same with fewer; a multiple of 16. */
#define RAYS (TEST_ASAN ? 1008 : 4000)
#define RAYS_LONG (TEST_ASAN ? 80 : 250) /* where each meets a hundred thousand triangles */

static gi_ray_hit embree_rays[RAYS], brute_rays[RAYS];

static void random_rays(gi_ray_hit *rays, float reach)
{
	shade_proof_random random = {.seed = 7};
	for (uint32_t i = 0; i < RAYS; i++) {
		stilb_vec3 origin = world_direction(&random) * (reach * shade_proof_uniform(&random));
		rays[i] = gi_ray_hit_make(origin, world_direction(&random));
	}
}

static void trace_all(const stilb_gi_scene *gi, gi_ray_hit *rays)
{
	for (uint32_t i = 0; i < RAYS; i++)
		gi->tracer.intersect(&gi->tracer, &rays[i]);
}

/* Within this of an edge the one may hit where the other misses. */
static bool near_edge(const gi_ray_hit *ray)
{
	float u = ray->hit.u, v = ray->hit.v;
	return gi_is_hit(ray) && fminf(fminf(u, v), 1.0f - u - v) < 1e-4f;
}

static bool same_triangle(const gi_ray_hit *a, const gi_ray_hit *b)
{
	return gi_is_hit(a) == gi_is_hit(b) &&
	       (!gi_is_hit(a) || (a->hit.part == b->hit.part && a->hit.triangle == b->hit.triangle));
}

static void assert_normals_agree(const gi_ray_hit *a, const gi_ray_hit *b)
{
	stilb_vec3 x = stilb_vec3_normalize(stilb_vec3_make(a->hit.normal[0], a->hit.normal[1], a->hit.normal[2]));
	stilb_vec3 y = stilb_vec3_normalize(stilb_vec3_make(b->hit.normal[0], b->hit.normal[1], b->hit.normal[2]));
	SHADE_PROOF_NEAR3(x, (double)y[0], (double)y[1], (double)y[2], 0.0, 2e-4);
}

static uint32_t assert_hits_agree(const stilb_gi_scene *embree, const stilb_gi_scene *brute, float reach)
{
	random_rays(embree_rays, reach);
	memcpy(brute_rays, embree_rays, sizeof embree_rays);
	trace_all(embree, embree_rays);
	trace_all(brute, brute_rays);
	uint32_t hits = 0, apart = 0;
	for (uint32_t i = 0; i < RAYS; i++) {
		const gi_ray_hit *a = &embree_rays[i], *b = &brute_rays[i];
		if (!same_triangle(a, b)) {
			assert_true(near_edge(a) || near_edge(b));
			apart++;
		} else if (gi_is_hit(a)) {
			float grazing = fabsf(a->ray.direction[0] * b->hit.normal[0] + a->ray.direction[1] * b->hit.normal[1] +
			                      a->ray.direction[2] * b->hit.normal[2]);
			hits++;
			if (grazing < 1e-2f * sqrtf(b->hit.normal[0] * b->hit.normal[0] + b->hit.normal[1] * b->hit.normal[1] +
			                            b->hit.normal[2] * b->hit.normal[2]))
				continue;
			SHADE_PROOF_NEAR(a->ray.t_max, (double)b->ray.t_max, 1e-4, 1e-4 * (double)reach);
			SHADE_PROOF_NEAR(a->hit.u, (double)b->hit.u, 0.0, 1e-3);
			SHADE_PROOF_NEAR(a->hit.v, (double)b->hit.v, 0.0, 1e-3);
			assert_normals_agree(a, b);
		}
	}
	assert_in_range(apart, 0, RAYS / 200);
	return hits;
}

/* shear: how far from turning nothing; one in two is a mirror. */
static stilb_mat4 random_transform(shade_proof_random *random, float shear)
{
	stilb_mat4 m = stilb_mat4_identity();
	m.m[0] = shade_proof_uniform(random) < 0.5f ? -1.0f : 1.0f;
	for (int column = 0; column < 3; column++)
		for (int row = 0; row < 3; row++)
			m.m[column * 4 + row] += shade_proof_range(random, -shear, shear);
	for (int row = 0; row < 3; row++)
		m.m[12 + row] = shade_proof_range(random, -10.0f, 10.0f);
	return m;
}

static stilb_scene *soup_scene(uint32_t parts, uint32_t triangles, float shear)
{
	shade_proof_random random = {.seed = 3};
	stilb_scene *scene = world_scene(parts, 1, 1);
	world_soup(&scene->meshes[0], triangles, &random);
	for (uint32_t part = 0; part < parts; part++)
		scene->part_transform[part] = random_transform(&random, shear);
	return scene;
}

static void triangles_of_the_world(void **state)
{
	(void)state;
	stilb_scene *scene = soup_scene(20, 50, 1.0f);
	world_fixture embree = world_trace(scene, &stilb_gi_embree, 1), brute = world_trace(scene, &stilb_gi_brute, 0);
	assert_false(embree.gi->parts[0].instance);
	assert_in_range(assert_hits_agree(embree.gi, brute.gi, 15.0f), RAYS / 10, RAYS);
	world_untrace(&brute);
	world_finish(&embree);
}

/* Half of them turned inside out by their transform. */
static void triangles_of_instances(void **state)
{
	(void)state;
	stilb_scene *scene = soup_scene(20, 5000, 0.25f);
	world_fixture embree = world_trace(scene, &stilb_gi_embree, 1), brute = world_trace(scene, &stilb_gi_brute, 0);
	assert_true(embree.gi->parts[0].instance);
	assert_int_equal(stilb_gi_scene_info_of(embree.gi)->triangles, 20 * 5000);
	assert_int_equal(embree.gi->mesh_count, 1);
	random_rays(embree_rays, 15.0f);
	uint32_t hits = 0;
	for (uint32_t i = 0; i < RAYS_LONG; i++) {
		gi_ray_hit a = embree_rays[i], b = a;
		embree.gi->tracer.intersect(&embree.gi->tracer, &a);
		brute.gi->tracer.intersect(&brute.gi->tracer, &b);
		assert_true(same_triangle(&a, &b) || near_edge(&a) || near_edge(&b) ||
		            fabsf(a.ray.t_max - b.ray.t_max) < 1e-4f);
		if (!gi_is_hit(&a) || !same_triangle(&a, &b))
			continue;
		hits++;
		SHADE_PROOF_NEAR(a.ray.t_max, (double)b.ray.t_max, 1e-3, 1e-3);
	}
	assert_in_range(hits, RAYS_LONG / 16, RAYS_LONG);
	world_untrace(&brute);
	world_finish(&embree);
}

/* The same part as an instance and as triangles of its own: the same side is the front. */
static void instances_have_the_same_front(void **state)
{
	(void)state;
	for (int mirrored = 0; mirrored < 2; mirrored++) {
		stilb_scene *many = world_scene(60, 1, 1), *one = world_scene(1, 1, 1);
		assert_int_equal(stilb_scene_mesh_sphere(3, &many->meshes[0]), STILB_OK);
		assert_int_equal(stilb_scene_mesh_sphere(3, &one->meshes[0]), STILB_OK);
		for (uint32_t part = 0; part < 60; part++) {
			many->part_transform[part] = stilb_mat4_scale_translate(1.0f, 4.0f * (float)part, 0.0f, 0.0f);
			many->part_transform[part].m[0] = mirrored ? -2.0f : 2.0f;
		}
		one->part_transform[0] = many->part_transform[0];
		world_fixture a = world_trace(many, &stilb_gi_embree, 0), b = world_trace(one, &stilb_gi_embree, 0);
		assert_true(a.gi->parts[0].instance);
		assert_false(b.gi->parts[0].instance);
		gi_ray_hit x = gi_ray_hit_make(stilb_vec3_make(0.1f, 0.2f, 5.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f)), y = x;
		a.gi->tracer.intersect(&a.gi->tracer, &x);
		b.gi->tracer.intersect(&b.gi->tracer, &y);
		gi_surface s, t;
		assert_true(gi_is_hit(&x) && gi_is_hit(&y));
		gi_surface_at(a.gi, &x, &s);
		gi_surface_at(b.gi, &y, &t);
		assert_true(s.front && t.front);
		for (int k = 0; k < 3; k++) {
			SHADE_PROOF_NEAR(s.position[k], (double)t.position[k], 0.0, 1e-5);
			SHADE_PROOF_NEAR(s.geometric[k], (double)t.geometric[k], 0.0, 1e-5);
			SHADE_PROOF_NEAR(s.normal[k], (double)t.normal[k], 0.0, 1e-3); /* turned after or before the blend */
		}
		world_finish(&a);
		world_finish(&b);
	}
}

/* What scene_pick finds on its own under the pixels of a picture is what rays meet there. It looks at every triangle of
 * the models under a pixel, so of the 4,800 pixels every thirteenth is asked, in all columns and rows; fewer
 * with the address sanitizer. */
static void picking_meets_the_same(void **state)
{
	(void)state;
	static const char *const names[] = {"spheres", "cornell", "outdoor"};
	for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
		stilb_scene *scene;
		assert_int_equal(stilb_scene_open(names[n], &scene), STILB_OK);
		world_fixture world = world_trace(scene, &stilb_gi_embree, 1);
		gi_camera camera = gi_camera_make(&scene->camera, &(stilb_gi_lens){0}, 80, 60);
		uint32_t same = 0, edges = 0;
		for (uint32_t i = 0; i < 80 * 60; i += TEST_ASAN ? 61 : 13) {
			float x = (float)(i % 80) + 0.37f, y = (float)(i / 80) + 0.61f; /* off the edges of symmetric scenes */
			stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, 80, 60, (double)x, (double)y);
			stilb_scene_hit hit = {.part = GI_NO_PART};
			gi_ray_hit traced;
			gi_camera_ray(&camera, x, y, (stilb_vec2){0}, &traced);
			world.gi->tracer.intersect(&world.gi->tracer, &traced);
			bool found = stilb_scene_pick(scene, &ray, &hit);
			if (found != gi_is_hit(&traced) || hit.part != traced.hit.part ||
			    (found && hit.triangle != traced.hit.triangle)) {
				edges++; /* an edge, or a silhouette, closer than float tells */
				continue;
			}
			same++;
			if (!found)
				continue;
			SHADE_PROOF_NEAR(traced.ray.t_max, hit.distance, 1e-5, 1e-5);
			SHADE_PROOF_NEAR(hit.u, (double)traced.hit.u, 0.0, 2e-3);
			SHADE_PROOF_NEAR(hit.v, (double)traced.hit.v, 0.0, 2e-3);
			uint32_t model = hit.model;
			assert_true(scene->first_part[model] <= hit.part && hit.part < scene->first_part[model + 1]);
		}
		assert_in_range(edges, 0, TEST_ASAN ? 1 : same / 300);
		world_finish(&world);
	}
}

/* Packets and streams answer as single rays do. */
static void packets_and_streams(void **state)
{
	(void)state;
	const stilb_gi_intersector *const intersectors[] = {&stilb_gi_embree, &stilb_gi_brute};
	for (int which = 0; which < 2; which++) {
		stilb_scene *scene = soup_scene(20, 50, 1.0f);
		world_fixture world = world_trace(scene, intersectors[which], 0);
		const gi_tracer *tracer = &world.gi->tracer;
		random_rays(embree_rays, 15.0f);
		memcpy(brute_rays, embree_rays, sizeof embree_rays);
		trace_all(world.gi, embree_rays);
		static gi_ray shadow[RAYS];
		for (uint32_t i = 0; i < RAYS; i++) {
			shadow[i] = brute_rays[i].ray;
			if (gi_is_hit(&embree_rays[i]) && i % 2)
				shadow[i].t_max = 0.99f * embree_rays[i].ray.t_max;
		}
		tracer->occluded(tracer, shadow, RAYS);
		for (uint32_t i = 0; i < RAYS; i++)
			assert_int_equal(shadow[i].t_max < 0.0f, gi_is_hit(&embree_rays[i]) && i % 2 == 0);
		for (uint32_t first = 0; first < RAYS; first += 16) {
			gi_ray_hit16 packet;
			int valid[16] __attribute__((aligned(64)));
			memset(&packet, 0, sizeof packet);
			for (uint32_t i = 0; i < 16; i++) {
				const gi_ray_hit *ray = &brute_rays[first + i];
				valid[i] = i == 5 ? 0 : -1;
				packet.ray.origin[0][i] = ray->ray.origin[0];
				packet.ray.origin[1][i] = ray->ray.origin[1];
				packet.ray.origin[2][i] = ray->ray.origin[2];
				packet.ray.direction[0][i] = ray->ray.direction[0];
				packet.ray.direction[1][i] = ray->ray.direction[1];
				packet.ray.direction[2][i] = ray->ray.direction[2];
				packet.ray.t_max[i] = INFINITY;
				packet.ray.mask[i] = UINT32_MAX;
				packet.hit.part[i] = GI_NO_PART;
			}
			tracer->intersect16(tracer, valid, &packet);
			for (uint32_t i = 0; i < 16; i++) {
				gi_ray_hit ray = gi_ray_of(&packet, i);
				if (i == 5)
					assert_false(gi_is_hit(&ray));
				else
					assert_true(same_triangle(&ray, &embree_rays[first + i]) || near_edge(&ray) ||
					            near_edge(&embree_rays[first + i]));
			}
		}
		world_finish(&world);
	}
}

static void workers_build_the_same_tree(void **state)
{
	(void)state;
	static gi_ray_hit first[RAYS], other[RAYS];
	for (uint32_t workers = 0; workers < 8; workers = 2 * workers + 1) {
		world_fixture world = world_trace(soup_scene(400, 100, 1.0f), &stilb_gi_embree, workers);
		gi_ray_hit *rays = workers ? other : first;
		random_rays(rays, 15.0f);
		trace_all(world.gi, rays);
		assert_memory_equal(rays, first, sizeof first);
		world_finish(&world);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(triangles_of_the_world),        cmocka_unit_test(triangles_of_instances),
		cmocka_unit_test(instances_have_the_same_front), cmocka_unit_test(picking_meets_the_same),
		cmocka_unit_test(packets_and_streams),           cmocka_unit_test(workers_build_the_same_tree),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
