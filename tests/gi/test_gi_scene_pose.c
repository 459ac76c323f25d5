/* Scenes made ready for rays that follow poses: hits, lights and pictures are those of a scene that is made now, and
 * what is built for that is the trees alone. */
#include "gi/gi_scene_hash.h"
#include "gi_render_fixture.h"
#include "gi_world_fixture.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"
#include "tests/scene/play/glb_moving.h"

#define RAYS 400

static int creates, updates;

static stilb_result counted_create(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                                   stilb_gi_scene_info *info)
{
	creates++;
	return stilb_gi_embree.create(gi, desc, tracer, info);
}

static stilb_result counted_update(const stilb_gi_scene *gi, const uint32_t *moved, uint32_t moved_count,
                                   const stilb_gi_scene_desc *desc, gi_tracer *tracer, stilb_gi_scene_info *info)
{
	updates++;
	return stilb_gi_embree.update(gi, moved, moved_count, desc, tracer, info);
}

static void counted_destroy(gi_tracer *tracer)
{
	stilb_gi_embree.destroy(tracer);
}

static const stilb_gi_intersector counted = {
	.name = "counted", .create = counted_create, .update = counted_update, .destroy = counted_destroy};

static stilb_job_pool *pool;

static int group_begin(void **state)
{
	return folder_make(state) == 0 ? stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &pool) : -1;
}

static int group_end(void **state)
{
	stilb_job_pool_destroy(pool);
	remove("leaf.png");
	return glb_clear(state);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

#define ALL (MOVING_STEP | MOVING_LINEAR | MOVING_CUBIC)

static const moving_file files[] = {
	{"skin and targets", ALL | MOVING_NORMALS | MOVING_OWN, 8, 1, 2, 6, 0, 1, 1},
	{"instances", ALL | MOVING_INSTANCES | MOVING_TWO_SKINS, 8, 1, 2, 6, 0, 1, 1},
	{"targets", ALL | MOVING_SPARSE, 3, 0, 3, 6, 0, 1, 1},
};

#define FILES (sizeof files / sizeof *files)

/* shines: its materials are lights, else a sky lights it. */
static stilb_scene *open_moving(size_t file, bool shines)
{
	stilb_scene *scene;
	write_picture("leaf.png");
	moving_write(&files[file], 70 + file);
	if (stilb_scene_open_with("test.glb", &(stilb_scene_open_options){.quiet = true, .dark = true}, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (uint32_t i = 0; i < scene->material_count; i++)
		scene->materials[i] = (stilb_scene_material){
			.diffuse = {0.7f, 0.5f, 0.3f}, .emission = {shines, shines, 2 * shines}, .roughness = 0.7f};
	stilb_scene_set_sky(scene, (const float[3]){0.3f, 0.4f, 0.5f});
	scene->camera = (stilb_scene_camera){.position = {0, 1, 14}, .fov_y = 0.8f, .near_z = 0.1f, .far_z = 100.0f};
	return scene;
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

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

/* Rays from around the scene into its middle. Returns how many hit. */
static uint32_t hits_of(const stilb_gi_scene *gi, gi_ray_hit *rays)
{
	const stilb_gi_scene_info *info = stilb_gi_scene_info_of(gi);
	shade_proof_random random = {.seed = 5};
	uint32_t hits = 0;
	for (uint32_t i = 0; i < RAYS; i++) {
		stilb_vec3 middle, from = world_direction(&random) * 9.0f, to = world_direction(&random);
		for (int axis = 0; axis < 3; axis++)
			middle[axis] = info->low[axis] <= info->high[axis] ? 0.5f * (info->low[axis] + info->high[axis]) : 0.0f;
		middle[3] = 0.0f;
		rays[i] = gi_ray_hit_make(middle + from, stilb_vec3_normalize(to - from));
		gi->tracer.intersect(&gi->tracer, &rays[i]);
		hits += gi_is_hit(&rays[i]);
	}
	return hits;
}

/* Everything that can be asked of the scene is as of one that is made now. Returns the picture's hash. */
static uint64_t assert_is_as_new(const stilb_gi_scene *gi, const stilb_scene *scene, stilb_gi_scene_desc desc,
                                 uint32_t *hits)
{
	static gi_ray_hit got[RAYS], want[RAYS];
	stilb_gi_scene *fresh;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &fresh), STILB_OK);
	const stilb_gi_scene_info *a = stilb_gi_scene_info_of(gi), *b = stilb_gi_scene_info_of(fresh);
	assert_int_equal(a->triangles, b->triangles);
	assert_int_equal(a->flat, b->flat);
	assert_int_equal(a->invalid, b->invalid);
	assert_int_equal(a->lights, b->lights);
	assert_memory_equal(a->low, b->low, sizeof a->low);
	assert_memory_equal(a->high, b->high, sizeof a->high);
	assert_int_equal(gi_scene_hash(gi), gi_scene_hash(fresh));
	*hits = hits_of(gi, got);
	hits_of(fresh, want);
	assert_memory_equal(got, want, sizeof got);
	uint64_t hash = picture_of(gi, scene);
	assert_int_equal(hash, picture_of(fresh, scene));
	stilb_gi_scene_destroy(fresh);
	return hash;
}

/* Brings the scene for rays up to date and compares it. anew: whether all may be built. */
static void assert_follows(stilb_gi_scene *gi, const stilb_scene *scene, stilb_gi_scene_desc desc, bool anew,
                           uint64_t *picture)
{
	uint32_t hits;
	creates = updates = 0;
	assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
	assert_true(anew ? creates + updates == 1 : creates == 0 && updates == 1);
	uint64_t now = assert_is_as_new(gi, scene, desc, &hits);
	assert_true(now != *picture && hits > RAYS / 20);
	*picture = now;
	creates = updates = 0; /* nothing has changed since */
	assert_int_equal(stilb_gi_scene_update(gi, scene, &desc), STILB_OK);
	assert_int_equal(creates + updates, 0);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Clips move nodes and vertices; where the scene is movable, only trees are built for that. */
static void clips_are_followed(void **state)
{
	(void)state;
	for (size_t i = 0; i < 4 * FILES; i++) {
		bool movable = i % 2, shines = i / 2 % 2;
		stilb_scene *scene = open_moving(i / 4, shines);
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = movable};
		stilb_gi_scene *gi;
		stilb_scene_play play = stilb_scene_play_make(0);
		uint64_t picture = 0;
		assert_int_equal(stilb_scene_set_plays(scene, 0, &play, 1), STILB_OK);
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		for (int frame = 0; frame < 5; frame++) {
			stilb_scene_advance(scene, 0.17, pool, 0);
			stilb_scene_update_nodes(scene, pool, 0);
			assert_follows(gi, scene, desc, true, &picture);
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

static uint32_t node_of_targets(const stilb_scene *scene)
{
	uint32_t node = 0;
	while (scene->animation->nodes[node].weight_count == 0)
		node++;
	return node;
}

static void set_weights(stilb_scene *scene, float a, float b, float c)
{
	const float weights[3] = {a, b, c};
	assert_int_equal(stilb_scene_set_weights(scene, 0, node_of_targets(scene), weights, 3), STILB_OK);
	stilb_scene_update_nodes(scene, NULL, 0);
}

/* Targets alone move: no scene is built anew for that, and lights follow. */
static void vertices_alone_cost_trees_alone(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		stilb_scene *scene = open_moving(2, i / 2);
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = i % 2};
		stilb_gi_scene *gi;
		uint64_t picture = 0;
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		for (int step = 1; step < 5; step++) {
			set_weights(scene, 0.3f * (float)step, -0.2f * (float)step, 0.5f);
			assert_follows(gi, scene, desc, false, &picture);
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

/* Makes target 0 one that takes all vertices but three, which are a triangle, to the origin. */
static void make_flattening(stilb_scene *scene)
{
	set_weights(scene, 0.0f, 0.0f, 0.0f);
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		const stilb_scene_mesh *mesh = &scene->meshes[m];
		float *deltas = scene->animation->deforms[0].positions;
		for (uint32_t v = 3; stilb_scene_mesh_is_posed(scene, m) && v < mesh->vertex_count; v++)
			for (uint32_t i = 0; i < 3; i++)
				deltas[3 * v + i] = -mesh->vertices[v].position[i];
	}
}

/* Triangles that a pose makes flat are left out, and come back with the next. */
static void what_is_flat_comes_back(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		stilb_scene *scene = open_moving(2, i / 2);
		stilb_gi_scene_desc desc = {.pool = pool, .intersector = &counted, .movable = i % 2};
		stilb_gi_scene *gi;
		uint64_t picture = 0;
		make_flattening(scene);
		assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
		uint64_t triangles = stilb_gi_scene_info_of(gi)->triangles;
		for (int step = 0; step < 3; step++) {
			set_weights(scene, (float)(step != 1), 0.0f, 0.1f * (float)(step == 1));
			assert_follows(gi, scene, desc, false, &picture);
			assert_true((stilb_gi_scene_info_of(gi)->triangles + 9 < triangles) == (step != 1));
		}
		stilb_gi_scene_destroy(gi);
		stilb_scene_destroy(scene);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(clips_are_followed),
		cmocka_unit_test(vertices_alone_cost_trees_alone),
		cmocka_unit_test(what_is_flat_comes_back),
	};
	return cmocka_run_group_tests(tests, group_begin, group_end);
}
