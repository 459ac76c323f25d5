/* Indices of 16 bits where a mesh or a level of it uses few enough vertices, and of 32 bits where not: what lies in the
 * heaps, which of them a draw's state names, and what a dump makes of it. On the null device. */
#include "render/render_dump.h"
#include "render/render_internal.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MORE 70000u /* vertices, of a mesh whose indices have 32 bits */

static stilb_render *make_render(bool morph, stilb_render_materials materials)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
	                          .replay = STILB_RENDER_REPLAY_DIRECT,
	                          .materials = materials,
	                          .width = 64,
	                          .height = 64,
	                          .context_count = 1,
	                          .morph = morph};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

/* Two triangles of each of the last vertices, and levels of which each uses so many vertices as listed. */
static stilb_scene_mesh make_mesh(uint32_t vertices, const uint32_t *levels, uint32_t level_count, bool morph)
{
	stilb_scene_mesh mesh = {.vertex_count = vertices, .index_count = 6 + 3 * level_count, .level_count = level_count};
	mesh.vertices = calloc(vertices, sizeof *mesh.vertices);
	mesh.indices = calloc(mesh.index_count, sizeof *mesh.indices);
	mesh.levels = calloc(level_count + 1, sizeof *mesh.levels);
	mesh.level_indices = calloc(mesh.index_count * (level_count + 1), sizeof *mesh.level_indices);
	mesh.morph = morph ? calloc(vertices, sizeof *mesh.morph) : NULL;
	assert_true(mesh.vertices && mesh.indices && mesh.levels && mesh.level_indices && (mesh.morph || !morph));
	for (uint32_t v = 0; v < vertices; v++) {
		mesh.vertices[v].position[0] = (float)v;
		mesh.vertices[v].normal[1] = 1.0f;
		if (morph)
			mesh.morph[v] = mesh.vertices[v];
	}
	for (uint32_t i = 0; i < mesh.index_count; i++)
		mesh.indices[i] = vertices - 1 - i;
	for (uint32_t l = 0; l < level_count; l++) {
		mesh.levels[l] = (stilb_scene_level){.first_index = mesh.level_index_count,
		                                     .index_count = mesh.index_count - 3 * (l + 1),
		                                     .vertex_count = levels[l],
		                                     .error = 0.1f * (float)(l + 1)};
		for (uint32_t i = 0; i < mesh.levels[l].index_count; i++)
			mesh.level_indices[mesh.level_index_count++] = levels[l] - 1 - i;
	}
	return mesh;
}

static uint32_t heap_index(const stilb_render *render, bool wide, uint32_t at)
{
	const render_heap *heap = &render->resources.heaps[wide ? RENDER_HEAP_INDICES : RENDER_HEAP_INDICES_16];
	assert_in_range(at, 0, heap->size - 1);
	return wide ? ((const uint32_t *)heap->data)[at] : ((const uint16_t *)heap->data)[at];
}

static const render_mesh_slot *slot_of(const stilb_render *render, stilb_render_mesh mesh)
{
	return &render->resources.meshes[mesh.id & RENDER_INDEX_MASK];
}

/* 65,536 vertices are the most for 16 bits. */
static void meshes_of_each_size(void **state)
{
	(void)state;
	stilb_render *render = make_render(false, STILB_RENDER_MATERIALS_INDEX);
	static const uint32_t counts[] = {6, 65535, 65536, 65537, MORE};
	for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
		stilb_scene_mesh mesh = make_mesh(counts[c], NULL, 0, false);
		stilb_render_mesh made;
		assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_OK);
		const render_mesh_slot *slot = slot_of(render, made);
		bool wide = counts[c] > 65536;
		assert_int_equal(slot->flags, wide ? RENDER_MESH_WIDE : 0);
		for (uint32_t i = 0; i < 6; i++)
			assert_int_equal(heap_index(render, wide, slot->first_index + i), counts[c] - 1 - i);
		stilb_scene_mesh_finish(&mesh);
	}
	assert_int_equal(render->resources.heaps[RENDER_HEAP_INDICES].size, 2 * 6);
	assert_int_equal(render->resources.heaps[RENDER_HEAP_INDICES_16].size, 3 * 6);
	assert_int_equal(render->resources.heaps[RENDER_HEAP_INDICES_16].element, 2);
	stilb_render_destroy(render);
}

/* A level uses the first vertices alone, so its indices may have 16 bits where the mesh's have not. Pairs of vertices
 * count twice. */
static void levels_of_each_size(void **state)
{
	(void)state;
	static const uint32_t counts[] = {65537, 65536, 32769, 32768, 40};
	for (int morph = 0; morph < 2; morph++) {
		stilb_render *render = make_render(morph, STILB_RENDER_MATERIALS_INDEX);
		stilb_scene_mesh mesh = make_mesh(MORE, counts, 5, morph);
		stilb_render_mesh made;
		assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_OK);
		const render_levels *levels = render->resources.levels[made.id & RENDER_INDEX_MASK];
		assert_int_equal(slot_of(render, made)->flags, RENDER_MESH_WIDE | RENDER_MESH_LEVELS);
		assert_int_equal(levels->wide, morph ? 4 : 2);
		for (uint32_t l = 0; l <= 5; l++) {
			const render_level *level = &render_levels_level(levels)[l];
			assert_int_equal(render_state_of_level(levels, l), l < levels->wide ? RENDER_STATE_WIDE : 0);
			for (uint32_t i = 0; i < level->index_count; i++) {
				uint32_t vertex = (l == 0 ? MORE : counts[l - 1]) - 1 - i, times = morph ? 2 : 1;
				assert_int_equal(heap_index(render, l < levels->wide, level->first_index + i), times * vertex);
				if (morph && l < 5)
					assert_int_equal(heap_index(render, l < levels->wide, level[6].first_index + i),
					                 2 * vertex + (vertex >= counts[l]));
			}
		}
		/* What is destroyed is used again. */
		uint32_t sizes[2] = {render->resources.heaps[RENDER_HEAP_INDICES].size,
		                     render->resources.heaps[RENDER_HEAP_INDICES_16].size};
		stilb_render_mesh_destroy(render, made);
		for (int frame = 0; frame < 4; frame++)
			assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_OK);
		assert_int_equal(render->resources.heaps[RENDER_HEAP_INDICES].size, sizes[0]);
		assert_int_equal(render->resources.heaps[RENDER_HEAP_INDICES_16].size, sizes[1]);
		stilb_scene_mesh_finish(&mesh);
		stilb_render_destroy(render);
	}
}

/* ---- draws ------------------------------------------------------------------------------------------------------- */

/* A narrow mesh, a wide one, and a wide one whose level is narrow. */
typedef struct drawn {
	stilb_render *render;
	stilb_render_mesh meshes[3];
	stilb_render_material material;
} drawn;

static drawn make_drawn(bool morph)
{
	static const uint32_t levels[] = {60, 30};
	drawn d = {.render = make_render(morph, STILB_RENDER_MATERIALS_INDEX)};
	stilb_scene_material material = {.roughness = 0.5f};
	stilb_scene_mesh meshes[3] = {make_mesh(60, NULL, 0, false), make_mesh(MORE, NULL, 0, false),
	                              make_mesh(MORE, levels, 2, morph)};
	for (int m = 0; m < 3; m++) {
		assert_int_equal(stilb_render_mesh_create(d.render, &meshes[m], &d.meshes[m]), STILB_OK);
		stilb_scene_mesh_finish(&meshes[m]);
	}
	assert_int_equal(stilb_render_material_create(d.render, &material, (stilb_render_texture){0}, &d.material),
	                 STILB_OK);
	return d;
}

typedef struct draw_of {
	uint32_t mesh, level, detail, kind;
	uint64_t key;
} draw_of;

static const draw_of list[] = {{0, 0, 0, 0, 5}, {0, 0, 0, 0, 1}, {1, 0, 0, 0, 5}, {2, 0, 0, 0, 2},
                               {2, 1, 0, 0, 2}, {2, 2, 0, 0, 1}, {2, 0, 9, 2, 1}, {2, 1, 9, 2, 5}};
#define DRAWS (sizeof list / sizeof *list)

static bool is_wide(const draw_of *draw)
{
	return draw->mesh > 0 && draw->level == 0;
}

static void draw_list(drawn *d, bool sort, const char *dump)
{
	stilb_render_pass pass = {.name = "scene", .sort = sort};
	stilb_render_view view = {.view_projection = stilb_mat4_identity(), .shading = stilb_render_shading_default()};
	stilb_mat4 transform = stilb_mat4_identity();
	assert_int_equal(stilb_render_frame_begin(d->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(d->render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(d->render, 0);
	stilb_render_segment_begin(context, 0, 0);
	for (size_t i = 0; i < DRAWS; i++)
		render_draw_level(context, list[i].key, d->meshes[list[i].mesh], d->material, &transform, list[i].level,
		                  list[i].detail, list[i].kind);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(d->render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(d->render, &pass, 1, &view, 1, NULL, 0), STILB_OK);
	if (dump)
		assert_int_equal(stilb_render_dump_save(d->render, &pass, 1, &view, 1, dump), STILB_OK);
}

/* Each run's draws have indices of its own kind, whether the pass is sorted or not. */
static void states_name_the_heap(void **state)
{
	(void)state;
	drawn d = make_drawn(true);
	for (int sort = 0; sort < 2; sort++) {
		draw_list(&d, sort, NULL);
		const render_pass_lists *lists = &d.render->passes[0];
		uint32_t seen = 0, wide = 0;
		for (uint32_t r = 0; r < lists->run_count; r++)
			for (uint32_t c = 0; c < lists->runs[r].count; c++, seen++) {
				const render_command *command = &render_commands(d.render)[lists->runs[r].first + c];
				const draw_of *draw = NULL;
				for (size_t i = 0; i < DRAWS && !draw; i++)
					draw = render_command_row(command) == i ? &list[i] : NULL;
				assert_non_null(draw);
				assert_true(sort || draw == &list[seen]);
				assert_int_equal((lists->runs[r].state & RENDER_STATE_WIDE) != 0, is_wide(draw));
				wide += is_wide(draw);
			}
		assert_int_equal(seen, DRAWS);
		assert_int_equal(wide, 3);
	}
	stilb_render_destroy(d.render);
}

static void binds_between_kinds(void **state)
{
	(void)state;
	assert_int_equal(render_binds_between(STILB_RENDER_MATERIALS_INDEX, 0, RENDER_STATE_WIDE), RENDER_BIND_INDICES);
	assert_int_equal(render_binds_between(STILB_RENDER_MATERIALS_INDEX, RENDER_STATE_WIDE | 7, 7), RENDER_BIND_INDICES);
	assert_int_equal(render_binds_between(STILB_RENDER_MATERIALS_INDEX, RENDER_STATE_WIDE | 7, RENDER_STATE_WIDE | 7),
	                 0);
	assert_int_equal(render_binds_between(STILB_RENDER_MATERIALS_INDEX, RENDER_NO_STATE, RENDER_STATE_WIDE) &
	                     RENDER_BIND_INDICES,
	                 0);
}

/* A dump has the same draws, of the same levels, with indices of the same kinds. */
static void dumps_hold_both_kinds(void **state)
{
	(void)state;
	char path[64];
	snprintf(path, sizeof path, "/tmp/test_render_index.%d", getpid());
	drawn d = make_drawn(true);
	draw_list(&d, false, path);
	uint64_t hash = stilb_render_stream_hash(d.render);
	stilb_render_destroy(d.render);
	stilb_render *render = make_render(true, STILB_RENDER_MATERIALS_INDEX);
	stilb_job_pool_desc none = {0};
	stilb_job_pool *pool;
	stilb_render_dump *dump;
	assert_int_equal(stilb_job_pool_create(&none, &pool), 0);
	assert_int_equal(stilb_render_dump_load(path, &dump), STILB_OK);
	assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, render, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, render, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_stream_hash(render), hash);
	uint32_t wide = 0;
	const render_pass_lists *lists = &render->passes[0];
	for (uint32_t r = 0; r < lists->run_count; r++)
		wide += lists->runs[r].state & RENDER_STATE_WIDE ? lists->runs[r].count : 0;
	assert_int_equal(wide, 3);
	stilb_render_dump_destroy(dump);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	unlink(path);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(meshes_of_each_size),   cmocka_unit_test(levels_of_each_size),
		cmocka_unit_test(states_name_the_heap),  cmocka_unit_test(binds_between_kinds),
		cmocka_unit_test(dumps_hold_both_kinds),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
