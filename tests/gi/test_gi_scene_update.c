/* Scenes made ready for rays that follow edits: the same pictures and hits as of a scene that is made now, what is
 * built for that and what is not; and builds that are given up. */

#include "gi/gi_scene_hash.h"
#include "gi_render_fixture.h"
#include "gi_world_fixture.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_look.h"

#include <stdatomic.h>

#define RAYS 600
#define MODELS 8

static const stilb_gi_intersector *counted_as; /* what the counting intersector does its work with */
static int creates, updates;

static stilb_result counted_create(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                                   stilb_gi_scene_info *info)
{
	creates++;
	return counted_as->create(gi, desc, tracer, info);
}

static stilb_result counted_update(const stilb_gi_scene *gi, const uint32_t *moved, uint32_t moved_count,
                                   const stilb_gi_scene_desc *desc, gi_tracer *tracer, stilb_gi_scene_info *info)
{
	updates++;
	return counted_as->update(gi, moved, moved_count, desc, tracer, info);
}

static void counted_destroy(gi_tracer *tracer)
{
	counted_as->destroy(tracer);
}

static const stilb_gi_intersector counted = {
	.name = "counted", .create = counted_create, .update = counted_update, .destroy = counted_destroy};

static stilb_job_pool *pool;

static int pool_begin(void **state)
{
	(void)state;
	return stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &pool);
}

static int pool_end(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

/* A ball (mesh 0) and a tile (mesh 1) in eight models: five balls, a tile, a ball that shines and a ball that is
 * sheared too much for an instance. A small lamp and a sky. */
static stilb_scene *world_of_models(void)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(0, 0, 2, 3, &scene), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(2, &scene->meshes[0]), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&scene->meshes[1]), STILB_OK);
	for (uint32_t i = 0; i < 3; i++)
		scene->materials[i] = (stilb_scene_material){.diffuse = {0.6f, 0.4f, 0.2f}, .roughness = 0.8f};
	scene->materials[2].emission[1] = 3.0f;
	for (uint32_t i = 0; i < MODELS; i++) {
		stilb_mat4 place = stilb_mat4_scale_translate(i == 5 ? 4.0f : 0.5f, 1.2f * (float)i - 4.0f, 0.0f, 0.0f);
		place.m[4] = i == 7 ? 9.0f : 0.0f;
		place.m[13] = i == 5 ? -0.5f : 0.0f;
		stilb_scene_build_part part = {i == 5, i == 6 ? 2 : i % 2};
		uint32_t id;
		assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &id), STILB_OK);
	}
	stilb_scene_light lamp = {
		.kind = STILB_SCENE_LIGHT_SPHERE, .position = {0, 4, 2}, .intensity = {9, 9, 9}, .radius = 0.3f};
	assert_int_equal(stilb_scene_set_lights(scene, &lamp, 1), STILB_OK);
	stilb_scene_set_sky(scene, (const float[3]){0.3f, 0.4f, 0.5f});
	scene->camera = (stilb_scene_camera){.position = {0, 1, 9}, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};
	return scene;
}

static uint64_t picture_of(const stilb_gi_scene *gi, const stilb_scene *scene)
{
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	stilb_gi_render *render;
	settings.width = 33;
	settings.height = 17;
	settings.samples = 3;
	assert_int_equal(stilb_gi_render_create(gi, &settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	uint64_t hash = film_hash(render);
	stilb_gi_render_destroy(render);
	return hash;
}

static void hits_of(const stilb_gi_scene *gi, gi_ray_hit *rays)
{
	shade_proof_random random = {.seed = 5};
	for (uint32_t i = 0; i < RAYS; i++) {
		rays[i] = gi_ray_hit_make(world_direction(&random) * 6.0f, world_direction(&random));
		gi->tracer.intersect(&gi->tracer, &rays[i]);
	}
}

/* Everything that can be asked of the scene is as of one that is made now. */
static uint64_t assert_is_as_new(const stilb_gi_scene *gi, const stilb_scene *scene, stilb_gi_scene_desc desc)
{
	static gi_ray_hit got[RAYS], want[RAYS];
	stilb_gi_scene *fresh;
	desc.intersector = counted_as;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &fresh), STILB_OK);
	const stilb_gi_scene_info *a = stilb_gi_scene_info_of(gi), *b = stilb_gi_scene_info_of(fresh);
	assert_int_equal(a->triangles, b->triangles);
	assert_int_equal(a->flat, b->flat);
	assert_int_equal(a->invalid, b->invalid);
	assert_int_equal(a->lights, b->lights);
	assert_string_equal(a->isa, b->isa);
	assert_memory_equal(a->low, b->low, sizeof a->low);
	assert_memory_equal(a->high, b->high, sizeof a->high);
	assert_int_equal(gi_scene_hash(gi), gi_scene_hash(fresh));
	hits_of(gi, got);
	hits_of(fresh, want);
	assert_memory_equal(got, want, sizeof got);
	for (uint32_t i = 0; i < RAYS; i++) /* each model has one part */
		assert_true(!gi_is_hit(&got[i]) || !isnan(scene->bounds.radius[got[i].hit.part]));
	/* Brute is slow: its hits alone are compared. */
	uint64_t hash = counted_as == &stilb_gi_brute ? stilb_hash_fnv1a64(STILB_FNV1A64_START, got, sizeof got)
	                                              : picture_of(gi, scene);
	if (counted_as != &stilb_gi_brute)
		assert_int_equal(hash, picture_of(fresh, scene));
	stilb_gi_scene_destroy(fresh);
	return hash;
}

static void move(stilb_scene *scene, uint32_t model, float sx, float sy, float sz, float x, float y, float turn)
{
	stilb_mat4 m = stilb_mat4_identity();
	m.m[0] = sx * cosf(turn);
	m.m[1] = sx * sinf(turn);
	m.m[4] = -sy * sinf(turn);
	m.m[5] = sy * cosf(turn);
	m.m[10] = sz;
	m.m[12] = x;
	m.m[13] = y;
	assert_int_equal(stilb_scene_set_transform(scene, model, &m), STILB_OK);
}

/* Edits after which no tree of triangles is built, but those of parts that are no instances. Numbers of models: see
 * world_of_models. */
static void edit_places(stilb_scene *scene, int step)
{
	switch (step) {
	case 0: /* moved and turned */
		move(scene, 0, 0.5f, 0.5f, 0.5f, -2.0f, 1.5f, 0.3f);
		break;
	case 1: /* scaled, mirrored, turned inside out */
		move(scene, 1, 0.9f, 0.6f, 0.7f, -1.0f, 0.1f, 0.0f);
		move(scene, 2, -0.6f, 0.6f, 0.6f, 0.0f, 0.4f, 0.8f);
		move(scene, 3, -0.4f, -0.4f, -0.4f, 1.0f, 0.4f, 0.1f);
		break;
	case 2: /* the one that shines, and grows */
		move(scene, 6, 0.8f, 0.8f, 0.8f, 1.5f, 1.7f, 0.5f);
		break;
	case 3: /* the one that shines is mirrored, the sheared one moves, and another one hides */
		move(scene, 6, -0.8f, 0.3f, 0.4f, -1.5f, 1.1f, 0.5f);
		move(scene, 7, 9.0f, 0.2f, 0.3f, 0.0f, 3.0f, 0.4f);
		assert_int_equal(stilb_scene_show_model(scene, 4, false), STILB_OK);
		break;
	case 4: /* what is hidden moves; another one hides: the only one with its mesh */
		move(scene, 4, 0.7f, 0.7f, 0.7f, -0.5f, -0.2f, 0.2f);
		assert_int_equal(stilb_scene_show_model(scene, 5, false), STILB_OK);
		break;
	case 5: /* both are shown again; the one that shines is flattened: it has no triangles any more */
		assert_int_equal(stilb_scene_show_model(scene, 4, true), STILB_OK);
		assert_int_equal(stilb_scene_show_model(scene, 5, true), STILB_OK);
		move(scene, 6, 0.0f, 0.0f, 0.0f, -1.5f, 1.1f, 0.5f);
		break;
	default: /* and has some again */
		move(scene, 6, 0.3f, 0.3f, 0.3f, -1.5f, 1.1f, 0.5f);
		break;
	}
}

static void moved_is_as_made_anew(void **state)
{
	(void)state;
	const stilb_gi_intersector *const kinds[] = {&stilb_gi_embree, &stilb_gi_brute};
	for (int kind = 0; kind < 2; kind++) {
		stilb_scene *scene = world_of_models();
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = true};
		stilb_gi_scene *gi;
		counted_as = kinds[kind];
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		for (uint32_t part = 0; part < MODELS; part++)
			assert_int_equal(gi->parts[part].instance, part < 6);
		uint64_t last = assert_is_as_new(gi, scene, desc);
		for (int step = 0; step < 7; step++) {
			edit_places(scene, step);
			creates = updates = 0;
			assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
			assert_int_equal(creates, 0);
			assert_int_equal(updates, 1);
			uint64_t now = assert_is_as_new(gi, scene, desc);
			assert_true(kind == 1 || now != last); /* few rays may miss what has changed */
			assert_int_equal(stilb_gi_scene_info_of(gi)->high[2] < 3.0f, step == 4); /* the tile is hidden */
			last = now;
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

/* Edits of what is no triangle: materials, lights, what is around. */
static void edit_looks(stilb_scene *scene, int step)
{
	stilb_scene_material paint = {.diffuse = {0.1f, 0.8f, 0.3f}, .roughness = 0.3f}, shine = scene->materials[2];
	uint32_t added;
	shine.emission[0] = 2.0f;
	switch (step) {
	case 0:
		assert_int_equal(stilb_scene_set_material(scene, 1, &paint), STILB_OK);
		break;
	case 1:
		assert_int_equal(stilb_scene_add_material(scene, &paint, &added), STILB_OK);
		assert_int_equal(stilb_scene_set_part(scene, 0, 0, (stilb_scene_build_part){0, added}), STILB_OK);
		break;
	case 2:
		assert_int_equal(stilb_scene_set_material(scene, 2, &shine), STILB_OK);
		break;
	case 3:
		scene->lights[0].position[0] += 2.0f;
		break;
	case 4:
		scene->surroundings.sky[1] = 2.0f;
		break;
	case 5:
		stilb_scene_set_backdrop(scene, (const float[3]){0.2f, 0.1f, 0.4f});
		break;
	default:
		assert_int_equal(stilb_scene_set_lights(scene, NULL, 0), STILB_OK);
		break;
	}
}

static void nothing_is_built_for_looks(void **state)
{
	(void)state;
	counted_as = &stilb_gi_embree;
	for (int movable = 0; movable < 2; movable++) {
		stilb_scene *scene = world_of_models();
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = movable};
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		uint64_t last = picture_of(gi, scene);
		uint64_t bytes = stilb_gi_scene_info_of(gi)->bytes;
		for (int step = 0; step < 7; step++) {
			edit_looks(scene, step);
			creates = updates = 0;
			assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
			assert_int_equal(creates + updates, 0);
			uint64_t now = assert_is_as_new(gi, scene, desc);
			assert_true(now != last);
			assert_int_equal(stilb_gi_scene_info_of(gi)->bytes, bytes);
			assert_true(stilb_gi_scene_info_of(gi)->build_s == 0.0);
			last = now;
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

/* Edits after which meshes or their users are others: all is built anew, once. */
static void edit_shapes(stilb_scene *scene, int step)
{
	stilb_scene_mesh mesh = {0};
	stilb_scene_build_part part = {1, 0}, shining = {0, 2};
	stilb_mat4 place = stilb_mat4_scale_translate(0.3f, 0.0f, 2.0f, 0.0f);
	stilb_scene_vertex vertex = scene->meshes[0].vertices[3];
	uint32_t id;
	switch (step) {
	case 0:
		assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &id), STILB_OK);
		break;
	case 1:
		assert_int_equal(stilb_scene_mesh_sphere(1, &mesh), STILB_OK);
		assert_int_equal(stilb_scene_set_mesh(scene, 0, &mesh), STILB_OK);
		stilb_scene_mesh_finish(&mesh);
		break;
	case 2:
		vertex.position[1] *= 3.0f;
		assert_int_equal(stilb_scene_set_vertices(scene, 0, 3, 1, &vertex), STILB_OK);
		break;
	case 3:
		assert_int_equal(stilb_scene_set_part(scene, 1, 0, part), STILB_OK);
		break;
	case 4:
		assert_int_equal(stilb_scene_set_part(scene, 2, 0, shining), STILB_OK);
		break;
	case 5: /* the one that shines, which keeps its place among the meshes */
		assert_int_equal(stilb_scene_set_part(scene, 6, 0, (stilb_scene_build_part){1, 2}), STILB_OK);
		break;
	case 6: /* too much sheared for an instance */
		move(scene, 0, 0.02f, 3.0f, 0.5f, 0.0f, 1.0f, 0.3f);
		break;
	default:
		assert_int_equal(stilb_scene_remove_model(scene, 3), STILB_OK);
		break;
	}
}

static void all_else_is_built_anew(void **state)
{
	(void)state;
	counted_as = &stilb_gi_embree;
	stilb_scene *scene = world_of_models();
	stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = true};
	stilb_gi_scene *gi;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	for (int step = 0; step < 10; step++) {
		creates = updates = 0;
		if (step < 8)
			edit_shapes(scene, step);
		desc.movable = step < 8; /* at last: one that is not movable, in which something moves */
		if (step == 9)
			edit_places(scene, 0);
		assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
		assert_int_equal(creates, 1);
		assert_int_equal(updates, 0);
		assert_is_as_new(gi, scene, desc);
	}
	creates = 0;
	assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK); /* nothing has changed */
	assert_int_equal(creates + updates, 0);
	stilb_gi_scene_destroy(gi);
	stilb_scene_destroy(scene);
}

static void assert_normals_agree(const gi_ray_hit *a, const gi_ray_hit *b)
{
	stilb_vec3 x = stilb_vec3_normalize(stilb_vec3_make(a->hit.normal[0], a->hit.normal[1], a->hit.normal[2]));
	stilb_vec3 y = stilb_vec3_normalize(stilb_vec3_make(b->hit.normal[0], b->hit.normal[1], b->hit.normal[2]));
	SHADE_PROOF_NEAR3(x, (double)y[0], (double)y[1], (double)y[2], 0.0, 1e-5);
}

/* Movable or not, pictures are the same but for the rounding of numbers: here for that of a few hits. */
static void movable_sees_the_same(void **state)
{
	(void)state;
	static gi_ray_hit rays[2][RAYS];
	uint32_t apart = 0, hits = 0;
	stilb_scene *scene = world_of_models();
	for (int movable = 0; movable < 2; movable++) {
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &stilb_gi_embree, .movable = movable};
		stilb_gi_scene *gi;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		assert_int_equal(gi->parts[0].instance, movable);
		hits_of(gi, rays[movable]);
		stilb_gi_scene_destroy(gi);
	}
	for (uint32_t i = 0; i < RAYS; i++) {
		const gi_ray_hit *a = &rays[0][i], *b = &rays[1][i];
		bool same = a->hit.part == b->hit.part && (!gi_is_hit(a) || a->hit.triangle == b->hit.triangle);
		apart += !same;
		hits += gi_is_hit(a);
		if (same && gi_is_hit(a))
			SHADE_PROOF_NEAR(a->ray.t_max, (double)b->ray.t_max, 1e-5, 1e-5);
		if (same && gi_is_hit(a))
			assert_normals_agree(a, b);
		if (same && gi_is_hit(a) && a->hit.part > 5) /* both are triangles of the world */
			assert_memory_equal(a, b, offsetof(gi_ray_hit, hit.instance));
	}
	assert_in_range(apart, 0, 3);
	assert_in_range(hits, RAYS / 10, RAYS);
	stilb_scene_destroy(scene);
}

/* ---- giving up --------------------------------------------------------------------------------------------------- */

static _Atomic int asked;  /* how often; relaxed: threads that build only count */
static _Atomic int enough; /* from this question on the answer is yes; 0: never */

static bool is_enough(void *user)
{
	assert_ptr_equal(user, &asked);
	int now = atomic_fetch_add_explicit(&asked, 1, memory_order_relaxed) + 1, limit = atomic_load(&enough);
	return limit > 0 && now >= limit;
}

static stilb_scene *large_scene(void)
{
	stilb_scene *scene = world_scene(3, 1, 1);
	assert_int_equal(stilb_scene_mesh_sphere(5, &scene->meshes[0]), STILB_OK); /* 20,480 triangles */
	for (uint32_t part = 0; part < 3; part++)
		scene->part_transform[part] = stilb_mat4_scale_translate(1.0f, 3.0f * (float)part, 0.0f, 0.0f);
	return scene;
}

static void a_build_is_given_up(void **state)
{
	(void)state;
	static gi_ray_hit got[RAYS], want[RAYS];
	stilb_scene *scene = large_scene();
	stilb_gi_scene *gi;
	for (int movable = 0; movable < 2; movable++) {
		stilb_gi_scene_desc desc = {
			.intersector = &stilb_gi_embree, .movable = movable, .give_up = is_enough, .user = &asked, .pool = pool};
		atomic_store(&enough, 0);
		atomic_store(&asked, 0);
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		int questions = atomic_load(&asked);
		assert_true(questions > 40); /* of which most are asked within Embree's build */
		hits_of(gi, want);
		for (int limit = 1; limit < questions; limit += 1 + questions / 11) {
			scene->revisions.geometry++; /* as if a mesh had changed */
			atomic_store(&asked, 0);
			atomic_store(&enough, limit);
			assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_ERROR_GIVEN_UP);
			assert_in_range(atomic_load(&asked), limit, limit + 8); /* each thread may ask once more */
			assert_non_null(strstr(stilb_error_message(), "given up"));
		}
		stilb_gi_scene *none = gi;
		assert_int_equal(stilb_gi_scene_create(
							 scene,
							 &(stilb_gi_scene_desc){
								 .intersector = &stilb_gi_embree, .give_up = is_enough, .user = &asked, .pool = pool},
							 &none),
		                 STILB_ERROR_GIVEN_UP);
		assert_null(none);
		atomic_store(&enough, 0);
		assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK); /* all of it */
		hits_of(gi, got);
		assert_memory_equal(got, want, sizeof got);
		stilb_gi_scene_destroy(gi);
	}
	stilb_scene_destroy(scene);
}

/* A picture of random blocks, and its texels. */
static stilb_image blocks_make(stilb_image_format format, uint32_t seed, stilb_image *texels)
{
	stilb_image image;
	uint32_t channels = stilb_image_format_channels(format);
	assert_int_equal(stilb_image_create_levels(&image, 21, 150, channels, format, 2), STILB_OK);
	for (uint64_t i = 0; i < stilb_image_levels_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(stilb_random_u64(seed, i) >> 7) | (i % 16 ? 0 : 64);
	assert_int_equal(stilb_image_decode(&image, texels), STILB_OK);
	return image;
}

/* Adds pictures of the maps of a surface, as blocks or as texels, and gives it to two materials; a third one shows one
 * without a surface. */
static void show_pictures(stilb_scene *scene, bool blocks)
{
	static const stilb_image_format formats[4] = {STILB_IMAGE_BC1_SRGB, STILB_IMAGE_BC7_SRGB, STILB_IMAGE_BC5_LINEAR,
	                                              STILB_IMAGE_BC3_LINEAR};
	static const stilb_scene_map_kind maps[4] = {STILB_SCENE_MAP_COLOR, STILB_SCENE_MAP_EMISSION,
	                                             STILB_SCENE_MAP_NORMAL, STILB_SCENE_MAP_REFLECTION};
	stilb_scene_surface surface = stilb_scene_surface_make();
	uint32_t id;
	surface.emission[0] = surface.emission[1] = surface.emission[2] = 2.0f;
	surface.alpha = STILB_SCENE_MASK; /* BC1 has holes */
	surface.cutoff = 0.5f;
	for (uint32_t i = 0; i < 4; i++) {
		stilb_image texels, image = blocks_make(formats[i], i, &texels);
		assert_int_equal(stilb_scene_add_texture(scene, blocks ? &image : &texels, &id), STILB_OK);
		surface.maps[maps[i]].texture = 1 + id;
		stilb_image_finish(&image);
		stilb_image_finish(&texels);
	}
	assert_int_equal(stilb_scene_add_surface(scene, &surface, &id), STILB_OK);
	for (uint32_t m = 0; m < 3; m++) {
		stilb_scene_material material = scene->materials[m];
		material.surface = m < 2 ? 1 + id : 0;
		material.diffuse_texture = m < 2 ? 0 : 1;
		assert_int_equal(stilb_scene_set_material(scene, m, &material), STILB_OK);
	}
}

/* Rays see blocks as their texels, to the last bit, also when they are others later. */
static void blocks_are_as_their_texels(void **state)
{
	(void)state;
	stilb_scene *scenes[2] = {world_of_models(), world_of_models()};
	stilb_gi_scene_desc desc = {.pool = pool, .intersector = &stilb_gi_embree};
	stilb_gi_scene *gi[2];
	uint64_t first = 0;
	for (int i = 0; i < 2; i++) {
		show_pictures(scenes[i], i == 0);
		assert_int_equal(stilb_gi_scene_create(scenes[i], &desc, &gi[i]), STILB_OK);
	}
	for (int step = 0; step < 3; step++) {
		assert_int_equal(stilb_gi_scene_info_of(gi[0])->lights, stilb_gi_scene_info_of(gi[1])->lights);
		assert_int_equal(gi_scene_hash(gi[0]), gi_scene_hash(gi[1]));
		uint64_t hash = picture_of(gi[0], scenes[0]);
		assert_int_equal(hash, picture_of(gi[1], scenes[1]));
		assert_true(hash != first);
		first = hash;
		stilb_image texels, image = blocks_make(step ? STILB_IMAGE_BC4_LINEAR : STILB_IMAGE_BC3_SRGB, 9, &texels);
		for (int i = 0; i < 2; i++) {
			assert_int_equal(stilb_scene_set_texture(scenes[i], 0, i ? &texels : &image), STILB_OK);
			assert_int_equal(stilb_gi_scene_update(gi[i], scenes[i], &desc), STILB_OK);
		}
		stilb_image_finish(&image);
		stilb_image_finish(&texels);
	}
	for (int i = 0; i < 2; i++) {
		stilb_gi_scene_destroy(gi[i]);
		stilb_scene_destroy(scenes[i]);
	}
}

/* ---- functions of surfaces --------------------------------------------------------------------------------------- */

static char told[512];

static void told_add(void *user, const char *line)
{
	(void)user;
	strncat(told, line, sizeof told - strlen(told) - 1);
	strncat(told, "|", sizeof told - strlen(told) - 1);
}

/* Rays leave the functions of surfaces out, and say so once for each, also when the scene is made ready anew. Their
 * parameters change nothing that rays see. */
static void functions_are_told_once(void **state)
{
	(void)state;
	static const char *const names[] = {"stripes", "rust"};
	stilb_scene *scene = world_of_models();
	scene->functions = calloc(2, sizeof *scene->functions);
	assert_non_null(scene->functions);
	scene->function_count = 2;
	stilb_scene_surface surface = stilb_scene_surface_make();
	for (uint32_t f = 0; f < 2; f++) {
		uint32_t id;
		scene->functions[f].name = names[f];
		assert_int_equal(stilb_scene_add_surface(scene, &surface, &id), STILB_OK);
		stilb_scene_material material = scene->materials[f];
		material.surface = 1 + id;
		assert_int_equal(stilb_scene_set_material(scene, f, &material), STILB_OK);
	}
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = {.pool = pool, .intersector = &stilb_gi_embree, .movable = true};
	told[0] = '\0';
	stilb_log_set(told_add, NULL);
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	uint64_t hash = gi_scene_hash(gi), picture = picture_of(gi, scene);
	assert_string_equal(told, "");
	for (uint32_t f = 0; f < 2; f++) {
		scene->surfaces[f].function = 1 + f;
		scene->surfaces[f].parameters[1][2] = 5.0f;
	}
	assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
	assert_string_equal(told, "rays lack the surface function 'stripes': its materials are shown without it|"
	                          "rays lack the surface function 'rust': its materials are shown without it|");
	told[0] = '\0';
	scene->revisions.geometry++; /* all is built anew */
	scene->surfaces[0].parameters[0][0] = 6.0f;
	assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
	assert_string_equal(told, "");
	assert_int_equal(gi_scene_hash(gi), hash);
	assert_int_equal(picture_of(gi, scene), picture);
	stilb_log_set(NULL, NULL);
	stilb_gi_scene_destroy(gi);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(moved_is_as_made_anew),   cmocka_unit_test(nothing_is_built_for_looks),
		cmocka_unit_test(all_else_is_built_anew),  cmocka_unit_test(movable_sees_the_same),
		cmocka_unit_test(a_build_is_given_up),     cmocka_unit_test(blocks_are_as_their_texels),
		cmocka_unit_test(functions_are_told_once),
	};
	return cmocka_run_group_tests(tests, pool_begin, pool_end);
}
