/* A scene that is edited: a reader that applies the lists of changes has what the scene has, bounds hold the vertices,
 * each mistake is told in words, and nothing changes without memory. */
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "support/failing_memory.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>

#define STEPS (TEST_ASAN || TEST_EMULATED ? 6000 : 30000)
#define MOST_LIVING 40 /* models at once, of 1 to 3 parts: as many ids of each size are given out at most */
#define MOST_MODELS 120
#define MOST_OTHERS 24 /* meshes, materials, textures */
#define MOST_VERTICES 12

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_stilb_memory_alloc(count, size);
}

/* ---- random things ----------------------------------------------------------------------------------------------- */

static uint64_t random_index;

static uint32_t below(uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(18, random_index++) % bound);
}

static float between(float low, float high)
{
	return low + (high - low) * stilb_random_float(18, random_index++);
}

static stilb_scene_vertex random_vertex(void)
{
	return (stilb_scene_vertex){
		{between(-2.0f, 2.0f), between(-2.0f, 2.0f), between(-2.0f, 2.0f)}, {0.0f, 1.0f, 0.0f}, {between(0, 1), 0.0f}};
}

/* Shared arrays, valid until the next call. */
static stilb_scene_mesh random_mesh(void)
{
	static stilb_scene_vertex vertices[MOST_VERTICES];
	static uint32_t indices[6];
	stilb_scene_mesh mesh = {.vertices = vertices,
	                         .indices = indices,
	                         .vertex_count = 1 + below(MOST_VERTICES),
	                         .index_count = below(2) ? 3 : 6};
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		vertices[v] = random_vertex();
	for (uint32_t i = 0; i < mesh.index_count; i++)
		indices[i] = below(mesh.vertex_count);
	return mesh;
}

/* Turned, stretched and sheared, and moved. */
static stilb_mat4 random_transform(void)
{
	stilb_mat4 transform =
		stilb_mat4_scale_translate(between(0.1f, 3.0f), between(-9, 9), between(-9, 9), between(-9, 9));
	for (int i = 0; i < 12; i++)
		transform.m[i] += (i + 1) % 4 && below(2) ? between(-1.0f, 1.0f) : 0.0f;
	return transform;
}

static stilb_scene_material random_material(uint32_t textures)
{
	return (stilb_scene_material){.diffuse = {between(0, 1), 0.2f, 0.1f}, .diffuse_texture = below(textures + 1)};
}

static stilb_image random_image(void)
{
	static uint8_t pixels[2 * 2 * 3];
	for (size_t i = 0; i < sizeof pixels; i++)
		pixels[i] = (uint8_t)below(256);
	return (stilb_image){
		.pixels = pixels, .width = 1 + below(2), .height = 1 + below(2), .channels = 3, .format = STILB_IMAGE_U8_SRGB};
}

/* ---- a reader ---------------------------------------------------------------------------------------------------- */

/* What a renderer and the octree would have: brought up to date with the lists of changes alone. */
typedef struct reader {
	stilb_sphere bounds[MOST_MODELS];
	stilb_scene_vertex vertices[MOST_OTHERS][MOST_VERTICES];
	uint32_t vertex_count[MOST_OTHERS];
	stilb_scene_material materials[MOST_OTHERS];
	uint64_t textures[MOST_OTHERS]; /* hash of the pixels; 0: none */
} reader;

static stilb_sphere bounds_of(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *b = &scene->bounds;
	return (stilb_sphere){b->x[model], b->y[model], b->z[model], b->radius[model]};
}

static uint64_t texture_hash(const stilb_image *image)
{
	return image->pixels ? stilb_hash_fnv1a64(image->width, image->pixels, stilb_image_size(image)) : 0;
}

static void reader_apply(reader *r, stilb_scene *scene)
{
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	for (uint32_t i = 0; i < scene->moved_count; i++)
		r->bounds[scene->moved[i]] = bounds_of(scene, scene->moved[i]);
	for (uint32_t i = 0; i < changes.mesh_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[changes.meshes[i]];
		r->vertex_count[changes.meshes[i]] = mesh->vertex_count;
		if (mesh->vertex_count > 0)
			memcpy(r->vertices[changes.meshes[i]], mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
	}
	for (uint32_t i = 0; i < changes.vertices_count; i++) {
		stilb_scene_vertices range = changes.vertices[i];
		for (uint32_t m = 0; m < changes.mesh_count; m++)
			assert_int_not_equal(changes.meshes[m], range.mesh);
		assert_true(range.count > 0 && range.first + range.count <= r->vertex_count[range.mesh]);
		memcpy(r->vertices[range.mesh] + range.first, scene->meshes[range.mesh].vertices + range.first,
		       range.count * sizeof(stilb_scene_vertex));
	}
	for (uint32_t i = 0; i < changes.material_count; i++)
		r->materials[changes.materials[i]] = scene->materials[changes.materials[i]];
	for (uint32_t i = 0; i < changes.texture_count; i++)
		r->textures[changes.textures[i]] = texture_hash(&scene->textures[changes.textures[i]]);
	stilb_scene_changes_clear(scene);
}

/* Every vertex of a model that is shown lies in its bounds. */
static void assert_bounds(const stilb_scene *scene, uint32_t model)
{
	stilb_sphere s = bounds_of(scene, model);
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1] && !isnan(s.radius); p++) {
		const float *m = scene->part_transform[p].m;
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		for (uint32_t v = 0; v < mesh->vertex_count; v++) {
			const float *at = mesh->vertices[v].position;
			float d[3];
			for (int row = 0; row < 3; row++)
				d[row] = m[row] * at[0] + m[4 + row] * at[1] + m[8 + row] * at[2] + m[12 + row];
			d[0] -= s.x;
			d[1] -= s.y;
			d[2] -= s.z;
			assert_true(sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) <= s.radius);
		}
	}
}

static void assert_same(const reader *r, const stilb_scene *scene)
{
	for (uint32_t m = 0; m < scene->model_count; m++) {
		stilb_sphere bounds = bounds_of(scene, m);
		assert_int_equal(isnan(bounds.radius), isnan(r->bounds[m].radius));
		if (!isnan(bounds.radius)) /* a model that is hidden may move without being listed */
			assert_memory_equal(&r->bounds[m], &bounds, sizeof bounds);
		assert_bounds(scene, m);
	}
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		const stilb_scene_mesh *mesh = &scene->meshes[m];
		assert_int_equal(r->vertex_count[m], mesh->vertex_count);
		if (mesh->vertex_count > 0)
			assert_memory_equal(r->vertices[m], mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
	}
	assert_memory_equal(r->materials, scene->materials, scene->material_count * sizeof *scene->materials);
	for (uint32_t t = 0; t < scene->texture_count; t++)
		assert_true(r->textures[t] == texture_hash(&scene->textures[t]));
}

/* ---- random edits ------------------------------------------------------------------------------------------------ */

typedef struct counts {
	uint32_t done, refused;
} counts;

static void note(counts *c, stilb_result result)
{
	assert_true(result == STILB_OK || result == STILB_ERROR_ARGUMENT);
	c->done += result == STILB_OK;
	c->refused += result != STILB_OK;
}

static uint32_t living_models(const stilb_scene *scene)
{
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++)
		count += scene->part_mesh[scene->first_part[m]] != STILB_SCENE_NONE;
	return count;
}

static stilb_result edit_model(stilb_scene *scene, uint32_t kind)
{
	uint32_t model = below(scene->model_count + 1), part_count = 1 + below(3);
	stilb_mat4 transforms[3] = {random_transform(), random_transform(), random_transform()};
	stilb_scene_build_part parts[3];
	for (int i = 0; i < 3; i++)
		parts[i] = (stilb_scene_build_part){below(scene->mesh_count + 1), below(scene->material_count + 1)};
	switch (kind) {
	case 0:
		return living_models(scene) < MOST_LIVING ? stilb_scene_add_model(scene, transforms, parts, part_count, &model)
		                                          : STILB_OK;
	case 1:
		return stilb_scene_remove_model(scene, model);
	case 2:
		return stilb_scene_show_model(scene, model, below(2));
	case 3:
		return stilb_scene_set_part(scene, model, below(3), parts[0]);
	case 4:
		return stilb_scene_set_part_transforms(scene, model, transforms);
	default:
		return stilb_scene_set_transform(scene, model, transforms);
	}
}

/* Living meshes, materials and textures. */
static void count_others(const stilb_scene *scene, uint32_t living[3])
{
	living[0] = living[1] = living[2] = 0;
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		living[0] += scene->meshes[m].vertex_count > 0;
	for (uint32_t m = 0; m < scene->material_count; m++)
		living[1] += scene->materials[m].diffuse[1] > 0.0f;
	for (uint32_t t = 0; t < scene->texture_count; t++)
		living[2] += scene->textures[t].width > 0;
}

static stilb_result edit_mesh(stilb_scene *scene, uint32_t kind)
{
	uint32_t living[3], id = below(scene->mesh_count + 1), first = below(MOST_VERTICES), count = below(4);
	count_others(scene, living);
	stilb_scene_mesh mesh = random_mesh();
	stilb_scene_vertex vertices[4] = {random_vertex(), random_vertex(), random_vertex(), random_vertex()};
	switch (kind) {
	case 0:
		return living[0] < MOST_OTHERS ? stilb_scene_add_mesh(scene, &mesh, &id) : STILB_OK;
	case 1:
		return stilb_scene_remove_mesh(scene, id);
	case 2:
		return stilb_scene_set_mesh(scene, id, &mesh);
	default:
		return stilb_scene_set_vertices(scene, id, first, count, vertices);
	}
}

static stilb_result edit_surface(stilb_scene *scene, uint32_t kind)
{
	uint32_t living[3], material = below(scene->material_count + 1), texture = below(scene->texture_count + 1);
	count_others(scene, living);
	stilb_scene_material paint = random_material(scene->texture_count);
	stilb_image image = random_image();
	switch (kind) {
	case 0:
		return living[1] < MOST_OTHERS ? stilb_scene_add_material(scene, &paint, &material) : STILB_OK;
	case 1:
		return stilb_scene_remove_material(scene, material);
	case 2:
		return stilb_scene_set_material(scene, material, &paint);
	case 3:
		return living[2] < MOST_OTHERS ? stilb_scene_add_texture(scene, &image, &texture) : STILB_OK;
	case 4:
		return stilb_scene_remove_texture(scene, texture);
	default:
		return stilb_scene_set_texture(scene, texture, &image);
	}
}

/* A scene of two balls, one of which was built, so that arrays of a built scene grow too. */
static stilb_scene *small_scene(void)
{
	stilb_scene *scene;
	stilb_mat4 place = stilb_mat4_identity();
	stilb_scene_mesh mesh = random_mesh();
	stilb_image image = random_image();
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_texture(build, &image);
	stilb_scene_material paint = {.diffuse = {0.5f, 0.5f, 0.5f}, .diffuse_texture = 1};
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &paint)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	return scene;
}

static void reader_has_what_the_scene_has(void **state)
{
	(void)state;
	static reader r;
	counts models[6] = {0}, meshes[4] = {0}, surfaces[6] = {0};
	stilb_scene *scene = small_scene();
	r = (reader){.bounds = {bounds_of(scene, 0)},
	             .vertex_count = {scene->meshes[0].vertex_count},
	             .materials = {scene->materials[0]},
	             .textures = {texture_hash(&scene->textures[0])}};
	memcpy(r.vertices[0], scene->meshes[0].vertices, scene->meshes[0].vertex_count * sizeof(stilb_scene_vertex));
	for (int step = 0; step < STEPS; step++) {
		static const uint8_t model_kinds[8] = {0, 0, 0, 1, 2, 3, 4, 5}, other_kinds[8] = {0, 0, 0, 2, 3, 4, 5, 5};
		uint32_t turn = below(24), kind = model_kinds[turn % 8],
				 other = below(12) == 0 ? 1 + 3 * below(2) : other_kinds[turn % 8];
		if (turn < 8)
			note(&models[kind], edit_model(scene, kind));
		else if (turn < 16)
			note(&meshes[other % 4], edit_mesh(scene, other % 4));
		else
			note(&surfaces[other], edit_surface(scene, other));
		if (below(8) == 0) {
			reader_apply(&r, scene);
			assert_same(&r, scene);
		}
	}
	for (int i = 0; i < 6; i++)
		assert_true(models[i].done > STEPS / 150 && surfaces[i].done > 0 && meshes[i % 4].done > STEPS / 500);
	assert_true(scene->model_count > 20 && models[1].refused > 0 && meshes[1].refused > 0 && surfaces[4].refused > 0);
	stilb_scene_destroy(scene);
}

/* What the lists say of edits one by one. */
static void lists_name_what_has_changed(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_mat4 place = stilb_mat4_identity();
	stilb_scene_build_part part = {0, 0};
	stilb_scene_vertex vertex = random_vertex();
	uint32_t model, again;
	assert_int_equal(stilb_scene_changes_read(scene).mesh_count + scene->moved_count, 0);
	assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &model), STILB_OK);
	assert_int_equal(model, 1);
	assert_int_equal(stilb_scene_show_model(scene, model, false), STILB_OK);
	assert_int_equal(stilb_scene_set_transform(scene, model, &place), STILB_OK);
	assert_int_equal(scene->moved_count, 1);
	assert_int_equal(scene->moved[0], 1);
	assert_true(isnan(scene->bounds.radius[1]));
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_scene_set_transform(scene, model, &place), STILB_OK);
	assert_int_equal(scene->moved_count, 0); /* it is hidden */
	assert_int_equal(stilb_scene_set_model_flags(scene, model, STILB_SCENE_MODEL_UNSEEN), STILB_OK);
	assert_int_equal(scene->model_flags[model], STILB_SCENE_MODEL_UNSEEN);
	assert_int_equal(stilb_scene_remove_model(scene, model), STILB_OK);
	assert_int_equal(scene->part_mesh[1], STILB_SCENE_NONE);
	assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &again), STILB_OK);
	assert_int_equal(again, model); /* the id is free again */
	assert_int_equal(scene->model_flags[model], 0);
	assert_true(scene->bounds.radius[1] > 0.0f);
	assert_int_equal(stilb_scene_changes_read(scene).vertices_count, 0);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 0, 1, &vertex), STILB_OK);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 0, 1, &vertex), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	assert_int_equal(changes.vertices_count, 1); /* joined */
	assert_int_equal(changes.vertices[0].count, 1);
	assert_int_equal(changes.mesh_count + changes.material_count + changes.texture_count, 0);
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_scene_changes_read(scene).vertices_count, 0);
	stilb_scene_mesh long_mesh = random_mesh();
	long_mesh.vertex_count = MOST_VERTICES;
	for (uint32_t v = 0; v < MOST_VERTICES; v++)
		long_mesh.vertices[v] = vertex;
	assert_int_equal(stilb_scene_set_mesh(scene, 0, &long_mesh), STILB_OK);
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 5, 1, &vertex), STILB_OK);
	assert_int_equal(stilb_scene_set_vertices(scene, 0, 0, 1, &vertex), STILB_OK);
	assert_int_equal(stilb_scene_changes_read(scene).vertices_count, 2); /* not what lies between them */
	stilb_scene_destroy(scene);
}

/* ---- revisions --------------------------------------------------------------------------------------------------- */

enum {
	MODELS = 1,
	PLACES = 2,
	GEOMETRY = 4,
	MATERIALS = 8,
	LIGHTS = 16,
	SURROUNDINGS = 32,
	CAMERA = 64,
	TEXTURES = 128
};

/* The kinds whose count is another one than at the last call. */
static int revised(stilb_scene *scene, stilb_scene_revisions *last)
{
	stilb_scene_revisions now = stilb_scene_revisions_read(scene);
	int kinds = (now.models != last->models) * MODELS | (now.places != last->places) * PLACES |
	            (now.geometry != last->geometry) * GEOMETRY | (now.materials != last->materials) * MATERIALS |
	            (now.lights != last->lights) * LIGHTS | (now.surroundings != last->surroundings) * SURROUNDINGS |
	            (now.camera != last->camera) * CAMERA | (now.textures != last->textures) * TEXTURES;
	*last = now;
	return kinds;
}

#define REVISED(edit, kinds)                                                                                           \
	do {                                                                                                               \
		assert_int_equal(edit, STILB_OK);                                                                              \
		assert_int_equal(revised(scene, &last), kinds);                                                                \
		assert_int_equal(revised(scene, &last), 0);                                                                    \
	} while (0)

static void edits_count_what_changes(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_mat4 place = random_transform();
	stilb_scene_build_part parts[2] = {{0, 0}, {0, 0}};
	stilb_scene_mesh mesh = random_mesh();
	stilb_scene_vertex vertex = random_vertex();
	stilb_scene_material paint = {.roughness = 0.5f};
	stilb_image image = random_image();
	uint32_t model, id;
	stilb_scene_revisions last = stilb_scene_revisions_read(scene);
	REVISED(stilb_scene_add_model(scene, &place, parts, 2, &model), MODELS);
	REVISED(stilb_scene_set_transform(scene, model, &place), PLACES);
	REVISED(stilb_scene_show_model(scene, model, true), 0); /* it is shown already */
	REVISED(stilb_scene_show_model(scene, model, false), PLACES);
	REVISED(stilb_scene_set_transform(scene, model, &place), PLACES); /* seen by who keeps the places of hidden ones */
	REVISED(stilb_scene_set_part(scene, model, 1, parts[0]), MODELS);
	REVISED(stilb_scene_set_model_flags(scene, model, 6), MODELS);
	REVISED(stilb_scene_set_model_flags(scene, model, 6), 0); /* it has them already */
	REVISED(stilb_scene_remove_model(scene, model), MODELS);
	REVISED(stilb_scene_add_mesh(scene, &mesh, &id), GEOMETRY);
	REVISED(stilb_scene_set_mesh(scene, id, &mesh), GEOMETRY);
	REVISED(stilb_scene_set_vertices(scene, id, 0, 0, &vertex), 0);
	REVISED(stilb_scene_set_vertices(scene, id, 0, 1, &vertex), GEOMETRY);
	REVISED(stilb_scene_remove_mesh(scene, id), GEOMETRY);
	REVISED(stilb_scene_add_material(scene, &paint, &id), MATERIALS);
	REVISED(stilb_scene_set_material(scene, id, &paint), MATERIALS);
	REVISED(stilb_scene_remove_material(scene, id), MATERIALS);
	REVISED(stilb_scene_add_texture(scene, &image, &id), MATERIALS | TEXTURES);
	REVISED(stilb_scene_set_texture(scene, id, &image), MATERIALS | TEXTURES);
	REVISED(stilb_scene_remove_texture(scene, id), MATERIALS | TEXTURES);
	assert_int_not_equal(stilb_scene_remove_mesh(scene, 0), STILB_OK); /* refused: nothing has changed */
	assert_int_equal(revised(scene, &last), 0);
	stilb_scene_destroy(scene);
}

/* What programs assign is noticed down to the last bit of the last member. */
static void assigned_values_are_noticed(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_scene_light lights[3] = {{.radius = 1.0f}, {.face = 1}, {.use = STILB_SCENE_LIGHT_LIVE}};
	uint32_t codes[2] = {0};
	scene->lights = lights;
	stilb_scene_revisions last = stilb_scene_revisions_read(scene);
	for (uint32_t count = 3; count-- > 0;) { /* also lights that are all zeros come and go */
		memset(lights, 0, sizeof lights);
		scene->light_count = count + 1;
		REVISED(STILB_OK, LIGHTS);
	}
	scene->light_count = 3;
	REVISED(STILB_OK, LIGHTS);
	for (size_t byte = 0; byte < sizeof lights; byte++) {
		((unsigned char *)lights)[byte] ^= 1;
		REVISED(STILB_OK, LIGHTS);
	}
	for (size_t byte = 0; byte < sizeof scene->camera; byte++) {
		((unsigned char *)&scene->camera)[byte] ^= 1;
		REVISED(STILB_OK, CAMERA);
	}
	stilb_scene_surroundings *around = &scene->surroundings;
	float *numbers[] = {around->sky, around->sky + 2, around->ground, around->ground + 2, &around->rotation};
	for (int i = 0; i < 5; i++) {
		*numbers[i] += 1.0f;
		REVISED(STILB_OK, SURROUNDINGS);
	}
	around->glossy = !around->glossy;
	REVISED(STILB_OK, SURROUNDINGS);
	around->panorama.pixels = codes;
	REVISED(STILB_OK, SURROUNDINGS);
	around->panorama = (stilb_image){0};
	REVISED(STILB_OK, SURROUNDINGS);
	stilb_scene_set_sky(scene, around->sky);
	REVISED(STILB_OK, SURROUNDINGS);
	scene->lights = NULL;
	scene->light_count = 0;
	stilb_scene_destroy(scene);
}

/* A light that is shown by a part of a model which goes; the one whose face stays keeps it. */
static void lights_lose_their_faces(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_mat4 place = stilb_mat4_identity();
	stilb_scene_build_part parts[2] = {{0, 0}, {0, 0}};
	uint32_t model;
	assert_int_equal(stilb_scene_add_model(scene, &place, parts, 2, &model), STILB_OK);
	stilb_scene_light lights[4] = {{.face = 1}, {.face = 2}, {.face = 3}, {.face = 0}}, *none = scene->lights;
	scene->lights = lights;
	scene->light_count = 4;
	assert_int_equal(stilb_scene_remove_model(scene, model), STILB_OK);
	assert_int_equal(lights[0].face, 1);
	assert_int_equal(lights[1].face + lights[2].face + lights[3].face, 0);
	scene->lights = none;
	scene->light_count = 0;
	stilb_scene_destroy(scene);
}

/* More ranges than the list holds: the mesh is listed as a whole. */
static void ranges_are_bounded(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_scene_mesh mesh = random_mesh();
	stilb_scene_vertex vertex = random_vertex();
	uint32_t other;
	assert_int_equal(stilb_scene_add_mesh(scene, &mesh, &other), STILB_OK);
	stilb_scene_changes_clear(scene);
	for (int i = 0; i < 5000; i++)
		assert_int_equal(stilb_scene_set_vertices(scene, i % 2 ? other : 0, 0, 1, &vertex), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	assert_true(changes.vertices_count <= 4096 && changes.mesh_count >= 1 && changes.mesh_count <= 2);
	stilb_scene_destroy(scene);
}

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

#define REFUSED(call, words)                                                                                           \
	do {                                                                                                               \
		assert_int_equal(call, STILB_ERROR_ARGUMENT);                                                                  \
		assert_non_null(strstr(stilb_error_message(), words));                                                         \
	} while (0)

static void mistakes_are_told(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_mat4 place = stilb_mat4_identity(), bent = place, far = place;
	stilb_scene_build_part part = {0, 0}, no_mesh = {7, 0}, no_material = {0, 9};
	stilb_scene_mesh mesh = random_mesh();
	stilb_scene_vertex vertex = random_vertex(), wrong = vertex;
	stilb_scene_material paint = {.diffuse_texture = 5}, bright = {.diffuse = {2.0f}};
	stilb_image image = random_image(), empty = image;
	uint32_t id = 0;
	bent.m[3] = 1.0f;
	far.m[12] = 1e18f;
	far.m[13] = 1e18f;
	wrong.normal[1] = 2.0f;
	empty.width = 0;
	REFUSED(stilb_scene_add_model(scene, &place, &part, 0, &id), "model 1: it has no parts");
	REFUSED(stilb_scene_add_model(scene, &place, &no_mesh, 1, &id), "there is no mesh 7");
	REFUSED(stilb_scene_add_model(scene, &place, &no_material, 1, &id), "there is no material 9");
	REFUSED(stilb_scene_add_model(scene, &bent, &part, 1, &id), "not affine");
	REFUSED(stilb_scene_add_model(scene, &far, &part, 1, &id), "farther than 1e18");
	REFUSED(stilb_scene_set_transform(scene, 0, &far), "model 0: mesh 0 reaches farther");
	for (int i = 0; i < 16; i++) {
		stilb_mat4 wrong_number = place;
		wrong_number.m[i] = i % 2 ? (float)NAN : INFINITY;
		REFUSED(stilb_scene_set_transform(scene, 0, &wrong_number), "model 0: its transform is not affine");
	}
	REFUSED(stilb_scene_set_transform(scene, 1, &place), "there is no model 1");
	REFUSED(stilb_scene_set_part(scene, 0, 1, part), "model 0: there is no part 1");
	REFUSED(stilb_scene_set_part(scene, 0, 0, no_mesh), "there is no mesh 7");
	REFUSED(stilb_scene_show_model(scene, 4, true), "there is no model 4");
	REFUSED(stilb_scene_set_model_flags(scene, 4, 0), "there is no model 4");
	REFUSED(stilb_scene_set_model_flags(scene, 0, 8), "model 0: its flags are 8");
	REFUSED(stilb_scene_remove_mesh(scene, 0), "mesh 0 is in use by 1 part;");
	REFUSED(stilb_scene_remove_material(scene, 0), "material 0 is in use by 1 part;");
	REFUSED(stilb_scene_remove_texture(scene, 0), "texture 0 is in use by 1 material or surface;");
	REFUSED(stilb_scene_set_vertices(scene, 0, scene->meshes[0].vertex_count, 1, &vertex), "mesh 0: it has ");
	REFUSED(stilb_scene_set_vertices(scene, 0, UINT32_MAX, UINT32_MAX, &vertex), "not 8589934590");
	REFUSED(stilb_scene_set_vertices(scene, 0, 0, 1, &wrong), "normal 0, 2, 0 of vertex 0 is not unit");
	REFUSED(stilb_scene_set_vertices(scene, 3, 0, 1, &vertex), "there is no mesh 3");
	REFUSED(stilb_scene_add_material(scene, &paint, &id), "material 1: there is no texture 4");
	REFUSED(stilb_scene_set_material(scene, 0, &bright), "material 0: diffuse and specular");
	REFUSED(stilb_scene_set_texture(scene, 0, &empty), "texture 0: 0x");
	REFUSED(stilb_scene_set_texture(scene, 1, &image), "there is no texture 1");
	mesh.index_count = 2;
	REFUSED(stilb_scene_add_mesh(scene, &mesh, &id), "mesh 1: 2 indices");
	assert_int_equal(id, 0);
	assert_int_equal(scene->model_count + scene->mesh_count + scene->material_count + scene->texture_count, 4);
	assert_int_equal(stilb_scene_remove_model(scene, 0), STILB_OK);
	REFUSED(stilb_scene_remove_model(scene, 0), "there is no model 0");
	assert_int_equal(stilb_scene_remove_mesh(scene, 0), STILB_OK);
	REFUSED(stilb_scene_remove_mesh(scene, 0), "there is no mesh 0");
	assert_int_equal(stilb_scene_remove_material(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_remove_texture(scene, 0), STILB_OK);
	REFUSED(stilb_scene_add_model(scene, &place, &part, 1, &id), "there is no mesh 0");
	stilb_scene_destroy(scene);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* A hash of everything in the scene that edits change, but for addresses. */
static uint64_t scene_hash(const stilb_scene *scene)
{
	const stilb_scene_bounds *b = &scene->bounds;
	const struct {
		const void *data;
		size_t size;
	} all[] = {{b->x, scene->model_count * sizeof *b->x},
	           {b->y, scene->model_count * sizeof *b->y},
	           {b->radius, scene->model_count * sizeof *b->radius},
	           {scene->first_part, (scene->model_count + 1) * sizeof *scene->first_part},
	           {scene->moved, scene->moved_count * sizeof *scene->moved},
	           {scene->part_mesh, scene->part_count * sizeof *scene->part_mesh},
	           {scene->part_transform, scene->part_count * sizeof *scene->part_transform},
	           {scene->materials, scene->material_count * sizeof *scene->materials},
	           {scene->nodes.parent, scene->nodes.count * sizeof *scene->nodes.parent},
	           {scene->nodes.local, scene->nodes.count * sizeof *scene->nodes.local}};
	uint64_t hash = STILB_FNV1A64_START;
	for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
		hash = stilb_hash_fnv1a64(hash, &all[i].size, sizeof all[i].size);
		hash = stilb_hash_fnv1a64(hash, all[i].data, all[i].size);
	}
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		hash = stilb_hash_fnv1a64(hash, scene->meshes[m].vertices,
		                          scene->meshes[m].vertex_count * sizeof(stilb_scene_vertex));
	for (uint32_t t = 0; t < scene->texture_count; t++)
		hash += texture_hash(&scene->textures[t]);
	return hash;
}

/* Surfaces come, change, name textures and go; who names a changed one has changed. */
static void surfaces_are_edited(void **state)
{
	(void)state;
	stilb_scene *scene = small_scene();
	stilb_scene_surface surface = stilb_scene_surface_make();
	stilb_image image = random_image();
	uint32_t texture, id, again, paint;
	assert_int_equal(stilb_scene_add_texture(scene, &image, &texture), STILB_OK);
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 2 + texture;
	REFUSED(stilb_scene_add_surface(scene, &surface, &id), "surface 0: there is no texture");
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1 + texture;
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 1 + texture;
	assert_int_equal(stilb_scene_add_surface(scene, &surface, &id), STILB_OK);
	REFUSED(stilb_scene_remove_texture(scene, texture), "is in use by 2 material or surfaces;");
	stilb_scene_material material = {.roughness = 0.5f, .surface = 2 + id};
	REFUSED(stilb_scene_add_material(scene, &material, &paint), "there is no surface 1");
	material.surface = 1 + id;
	material.diffuse_texture = 1 + texture;
	REFUSED(stilb_scene_add_material(scene, &material, &paint), "both a surface and a diffuse_texture");
	material.diffuse_texture = 0;
	assert_int_equal(stilb_scene_add_material(scene, &material, &paint), STILB_OK);
	REFUSED(stilb_scene_remove_surface(scene, id), "surface 0 is in use by 1 material;");
	stilb_scene_changes_clear(scene);
	stilb_scene_revisions last = stilb_scene_revisions_read(scene);
	surface.maps[STILB_SCENE_MAP_EMISSION].texture = 0;
	surface.unlit = true;
	assert_int_equal(stilb_scene_set_surface(scene, id, &surface), STILB_OK);
	assert_true(scene->surfaces[id].unlit);
	assert_int_equal(stilb_scene_changes_read(scene).material_count, 1);
	assert_int_equal(stilb_scene_changes_read(scene).materials[0], paint);
	assert_true(stilb_scene_revisions_read(scene).materials != last.materials);
	surface.cutoff = -1.0f;
	REFUSED(stilb_scene_set_surface(scene, id, &surface), "surface 0: its cutoff");
	assert_int_equal(stilb_scene_remove_material(scene, paint), STILB_OK);
	assert_int_equal(stilb_scene_remove_surface(scene, id), STILB_OK);
	REFUSED(stilb_scene_set_surface(scene, id, &surface), "there is no surface 0");
	assert_int_equal(stilb_scene_remove_texture(scene, texture), STILB_OK);
	surface = stilb_scene_surface_make();
	assert_int_equal(stilb_scene_add_surface(scene, &surface, &again), STILB_OK);
	assert_int_equal(again, id);
	for (int i = 0; i < 20; i++) { /* the scene's own: its array moves meanwhile */
		assert_int_equal(stilb_scene_add_surface(scene, &scene->surfaces[0], &again), STILB_OK);
		assert_int_equal(stilb_scene_add_material(scene, &scene->materials[0], &again), STILB_OK);
		assert_int_equal(stilb_scene_add_texture(scene, &scene->textures[0], &again), STILB_OK);
		assert_int_equal(stilb_scene_add_mesh(scene, &scene->meshes[0], &again), STILB_OK);
	}
	stilb_scene_destroy(scene);
}

/* Edit number `edit` of a scene; its random numbers are the same each time. */
static stilb_result edit_number(stilb_scene *scene, int edit)
{
	uint32_t id;
	random_index = 1000;
	stilb_mat4 place = random_transform();
	stilb_scene_mesh mesh = random_mesh();
	stilb_image image = random_image();
	stilb_scene_material paint = {.roughness = 0.5f};
	stilb_scene_build_part parts[17] = {{0, 0}}; /* more than arrays of a built scene have room for */
	stilb_scene_vertex vertex = random_vertex();
	stilb_scene_pose pose = stilb_scene_pose_identity();
	switch (edit) {
	case 0:
		return stilb_scene_add_model(scene, &place, parts, 17, &id);
	case 1:
		return stilb_scene_add_mesh(scene, &mesh, &id);
	case 2:
		return stilb_scene_set_mesh(scene, 0, &mesh);
	case 3:
		return stilb_scene_add_material(scene, &paint, &id);
	case 4:
		return stilb_scene_add_texture(scene, &image, &id);
	case 5:
		return stilb_scene_set_texture(scene, 0, &image);
	case 6:
		return stilb_scene_remove_model(scene, 0);
	case 7:
		return stilb_scene_add_node(scene, 0, &pose, &id);
	default:
		return stilb_scene_set_vertices(scene, 0, 0, 1, &vertex);
	}
}

static void without_memory_nothing_changes(void **state)
{
	(void)state;
	for (int edit = 0; edit < 9; edit++) {
		int failures = 0;
		for (int failed = 0;; failed++) {
			random_index = 0;
			stilb_scene *scene = small_scene();
			uint64_t before = scene_hash(scene);
			fail_allocation = failed;
			stilb_result result = edit_number(scene, edit);
			bool ran_out = fail_allocation < 0;
			fail_allocation = -1;
			if (result != STILB_OK) {
				assert_int_equal(result, STILB_ERROR_MEMORY);
				assert_true(scene_hash(scene) == before);
				assert_int_equal(edit_number(scene, edit), STILB_OK);
				failures++;
			}
			assert_true(scene_hash(scene) != before);
			stilb_scene_destroy(scene);
			if (!ran_out)
				break;
		}
		assert_true(failures >= 5);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(reader_has_what_the_scene_has),
		cmocka_unit_test(lists_name_what_has_changed),
		cmocka_unit_test(edits_count_what_changes),
		cmocka_unit_test(assigned_values_are_noticed),
		cmocka_unit_test(lights_lose_their_faces),
		cmocka_unit_test(ranges_are_bounded),
		cmocka_unit_test(surfaces_are_edited),
		cmocka_unit_test(mistakes_are_told),
		cmocka_unit_test(without_memory_nothing_changes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
