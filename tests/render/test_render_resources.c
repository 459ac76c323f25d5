/* Meshes, textures and materials that are created and destroyed: by all workers while frames are drawn, without memory,
 * with bad input, and until no index is left. The linker sends allocations here (--wrap), to let them fail. */
#include "support/render_gpu.h"
#include "support/test.h"

#include <pthread.h>
#include <sched.h>
#include <stddef.h>
#include <sys/mman.h>

/* ---- memory that runs out once ---------------------------------------------------------------------------------- */

/* Allocations left until the one that fails. Relaxed: only the number matters. */
static _Atomic int64_t allocations_left = INT64_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__real_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);

static bool allocation_fails(void)
{
	return atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) == 1;
}

static void allocation_fail(int64_t number)
{
	atomic_store_explicit(&allocations_left, number, memory_order_relaxed);
}

/* True if the allocation that allocations_left counted down to has been made, and failed. */
static bool allocation_failed(void)
{
	return atomic_load_explicit(&allocations_left, memory_order_relaxed) <= 0;
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_stilb_memory_alloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	return allocation_fails() ? NULL : __real_realloc(memory, size);
}

void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset)
{
	return allocation_fails() ? MAP_FAILED : __real_mmap(address, size, protection, flags, file, offset);
}

/* ---- ranges ----------------------------------------------------------------------------------------------------- */

#define RANGE_BITS 300u

/* Checks a set of ranges against an array with a flag for each element: each range is an unbroken sequence of set
 * flags, as long as it can be, in ascending order. */
static void assert_ranges(const render_ranges *ranges, const bool *bits)
{
	uint32_t r = 0;
	for (uint32_t b = 0; b < RANGE_BITS;) {
		uint32_t end = b;
		while (end < RANGE_BITS && bits[end])
			end++;
		if (end > b) {
			assert_true(r < ranges->count);
			assert_int_equal(ranges->items[r].first, b);
			assert_int_equal(ranges->items[r++].count, end - b);
		}
		b = end + 1;
	}
	assert_int_equal(ranges->count, r);
}

/* The first position of `count` consecutive set bits; RANGE_BITS: there is none. */
static uint32_t first_place(const bool *bits, uint32_t count)
{
	uint32_t length = 0;
	for (uint32_t b = 0; b < RANGE_BITS; b++) {
		length = bits[b] ? length + 1 : 0;
		if (length == count)
			return b + 1 - count;
	}
	return RANGE_BITS;
}

static void take_and_compare(render_ranges *ranges, bool *bits, uint32_t count)
{
	uint32_t expected = first_place(bits, count), first = RANGE_BITS;
	assert_true(render_ranges_take(ranges, count, &first) == (expected < RANGE_BITS));
	assert_int_equal(first, expected);
	for (uint32_t b = first; b < first + count && first < RANGE_BITS; b++)
		bits[b] = false;
}

static void add_and_compare(render_ranges *ranges, bool *bits, uint32_t first, uint32_t count, bool memory)
{
	allocation_fail(memory ? INT64_MAX : 1);
	bool added = render_ranges_add(ranges, (render_range){first, count});
	bool failed = allocation_failed();
	allocation_fail(INT64_MAX);
	assert_true(added != failed);
	for (uint32_t b = first; b < first + count && added; b++)
		bits[b] = true;
}

static void ranges_are_sets(void **state)
{
	(void)state;
	for (uint64_t seed = 0; seed < 40; seed++) {
		render_ranges ranges = {0};
		bool bits[RANGE_BITS] = {0};
		uint32_t longest = seed % 2 ? 3 : 30, failures = 0;
		for (uint64_t step = 0; step < 2000; step++) {
			uint64_t random = stilb_random_u64(seed, step);
			uint32_t count = 1 + (uint32_t)(random >> 32) % longest;
			uint32_t first = (uint32_t)random % (RANGE_BITS + 1 - count);
			bool memory = random >> 60 != 0;
			if (step % 200 < 100 + seed % 50)
				add_and_compare(&ranges, bits, first, count, memory);
			else
				take_and_compare(&ranges, bits, count);
			failures += !memory;
			assert_ranges(&ranges, bits);
		}
		assert_true(failures > 0);
		free(ranges.items);
	}
}

/* ---- frames ----------------------------------------------------------------------------------------------------- */

static const stilb_render_pass one_pass = {.name = "main"};
static const stilb_render_view one_view;

static stilb_result replay(stilb_render *render, stilb_job_pool *pool)
{
	return stilb_render_replay(render, &one_pass, 1, &one_view, 1, pool, 0);
}

static stilb_result record_things(stilb_render *render, const gpu_thing *things, uint32_t count)
{
	stilb_result result = stilb_render_pass_begin(render, 0, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 0, 0);
	for (uint32_t t = 0; t < count; t++) {
		fixture_draw draw = gpu_thing_draw(&things[t]);
		fixture_record(context, &draw);
	}
	stilb_render_segment_end(context);
	return stilb_render_pass_end(render, 0);
}

/* A frame that draws these things; without workers. */
static stilb_result draw_things(stilb_render *render, const gpu_thing *things, uint32_t count)
{
	stilb_result result = stilb_render_frame_begin(render);
	if (result == STILB_OK)
		result = record_things(render, things, count);
	return result == STILB_OK ? replay(render, NULL) : result;
}

static uint64_t hash_things(const gpu_thing *things, uint32_t count)
{
	uint64_t hash = REFERENCE_HASH_PASS;
	for (uint32_t t = 0; t < count; t++) {
		fixture_draw draw = gpu_thing_draw(&things[t]);
		hash = fixture_hash(hash, &draw);
	}
	return hash;
}

static void assert_things_drawn(stilb_render *render, const gpu_thing *things, uint32_t count)
{
	uint64_t seen = gpu.draws_seen;
	assert_int_equal(draw_things(render, things, count), STILB_OK);
	assert_true(gpu.draws_seen == seen + count);
	assert_int_equal(gpu.wrong, 0);
	assert_true(stilb_render_stream_hash(render) == hash_things(things, count));
}

/* Runs frames until all destroyed resources are released, a thousand in each frame. */
static void frames_pass(stilb_render *render)
{
	uint32_t frames = STILB_GPU_FRAMES + render->resources.retired_count / 1000;
	for (uint32_t f = 0; f < frames; f++)
		assert_int_equal(draw_things(render, NULL, 0), STILB_OK);
}

/* ---- the tables of render_resources ----------------------------------------------------------------------------- */

static void mark(uint8_t *marks, uint32_t size, uint32_t first, uint32_t count)
{
	assert_true(first <= size && count <= size - first);
	for (uint32_t i = first; i < first + count; i++)
		assert_int_equal(marks[i]++, 0);
}

/* Every element of the heap is free, or belongs to one mesh. */
static void assert_heap(const render_resources *resources, render_heap_kind kind, const uint8_t *used)
{
	const render_heap *heap = &resources->heaps[kind];
	uint8_t *marks = calloc(heap->size + 1, 1);
	assert_non_null(marks);
	for (uint32_t r = 0; r < heap->free.count; r++)
		mark(marks, heap->size, heap->free.items[r].first, heap->free.items[r].count);
	for (uint32_t m = 0; m < resources->indices[RENDER_RESOURCE_MESH].next_unused; m++) {
		const render_mesh_slot *slot = &resources->meshes[m];
		const render_levels *levels = resources->levels[m];
		bool own = kind == (slot->flags & RENDER_MESH_WIDE ? RENDER_HEAP_INDICES : RENDER_HEAP_INDICES_16);
		assert_true(!used[m] || !levels == !(slot->flags & RENDER_MESH_LEVELS));
		if (used[m] && levels && kind == RENDER_HEAP_VERTICES)
			mark(marks, heap->size, levels->first_vertex, levels->heap_vertices);
		else if (used[m] && levels)
			mark(marks, heap->size, levels->indices[kind == RENDER_HEAP_INDICES_16].first,
			     levels->indices[kind == RENDER_HEAP_INDICES_16].count);
		else if (used[m] && kind == RENDER_HEAP_VERTICES)
			mark(marks, heap->size, (uint32_t)slot->vertex_offset, slot->vertex_count);
		else if (used[m] && own)
			mark(marks, heap->size, slot->first_index, slot->index_count);
	}
	for (uint32_t i = 0; i < heap->size; i++)
		assert_int_equal(marks[i], 1);
	free(marks);
}

/* Sets used[index] for every index of a kind that is not free; returns their number. */
static uint32_t indices_used(const render_resources *resources, render_resource_kind kind, uint8_t *used)
{
	const render_indices *indices = &resources->indices[kind];
	uint32_t first = kind == RENDER_RESOURCE_TEXTURE;
	assert_true(indices->next_unused <= indices->capacity && indices->free_count <= indices->free_capacity);
	memset(used + first, 1, indices->next_unused - first);
	for (uint32_t f = 0; f < indices->free_count; f++) {
		assert_true(indices->free[f] >= first && indices->free[f] < indices->next_unused);
		assert_int_equal(used[indices->free[f]], 1);
		used[indices->free[f]] = 0;
	}
	return indices->next_unused - first - indices->free_count;
}

static void assert_books(const stilb_render *render)
{
	const render_resources *resources = &render->resources;
	uint32_t most = 1;
	for (int kind = 0; kind < RENDER_RESOURCE_KINDS; kind++)
		most = resources->indices[kind].next_unused > most ? resources->indices[kind].next_unused : most;
	uint8_t *used = calloc(1, most);
	assert_non_null(used);
	uint32_t live = indices_used(resources, RENDER_RESOURCE_TEXTURE, used);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		assert_int_equal(used[resources->uploads[u].texture], 1);
	memset(used, 0, resources->indices[RENDER_RESOURCE_TEXTURE].next_unused);
	live += indices_used(resources, RENDER_RESOURCE_MATERIAL, used);
	memset(used, 0, resources->indices[RENDER_RESOURCE_MATERIAL].next_unused);
	live += indices_used(resources, RENDER_RESOURCE_MESH, used);
	assert_int_equal(live, resources->live);
	assert_true(resources->retired_count <= resources->live);
	assert_heap(resources, RENDER_HEAP_VERTICES, used);
	assert_heap(resources, RENDER_HEAP_INDICES, used);
	assert_heap(resources, RENDER_HEAP_INDICES_16, used);
	free(used);
}

static void assert_nothing_lives(const stilb_render *render)
{
	assert_books(render);
	assert_int_equal(render->resources.live, 0);
	assert_int_equal(render->resources.retired_count, 0);
	for (uint32_t t = 0; t < render->resources.indices[RENDER_RESOURCE_TEXTURE].next_unused; t++)
		assert_int_equal(render->device->textures[t].image.id, 0);
}

/* ---- ten thousand of each, from all workers --------------------------------------------------------------------- */

#define CHURN_FRAMES (TEST_TSAN || TEST_ASAN ? 10u : 50u)
#define CHURN_SEGMENTS 40u
#define CHURN_EACH 5u    /* resources of each kind that a segment creates */
#define CHURN_BESIDE 20u /* created in a frame by the thread outside the pool */
#define CHURN_STAYS 2u   /* a thing is drawn in its first frame and in so many more, and destroyed in the last */
#define CHURN_SEGMENT_DRAWS ((CHURN_STAYS + 1) * CHURN_EACH)
#define CHURN_MOST_INDICES 8192u

static_assert(CHURN_FRAMES * CHURN_SEGMENTS * CHURN_EACH == (TEST_TSAN || TEST_ASAN ? 2000 : 10000), "of each kind");

typedef struct churn {
	stilb_render *render;
	stilb_job_pool *pool;
	uint32_t frame;
	gpu_thing things[CHURN_FRAMES][CHURN_SEGMENTS][CHURN_EACH];
	fixture_draw draws[CHURN_SEGMENTS][CHURN_SEGMENT_DRAWS];
	uint32_t draw_counts[CHURN_SEGMENTS];
	/* [kind][index]: 1 while a resource has the index. A creation must find 0, and get another id than the last
	 * resource there had. Relaxed: the lock of render's resources orders a destruction before the next creation with
	 * its index. */
	_Atomic uint32_t owned[RENDER_RESOURCE_KINDS][CHURN_MOST_INDICES];
	uint32_t last_ids[RENDER_RESOURCE_KINDS][CHURN_MOST_INDICES];
	_Atomic uint32_t clashes; /* relaxed: read when all threads are done */
	_Atomic uint32_t begun;   /* frames begun. Relaxed: it only keeps the thread outside the pool from running ahead */
	_Atomic bool stop;        /* relaxed: no data goes with it */
} churn;

static void churn_own(churn *c, render_resource_kind kind, uint32_t id)
{
	uint32_t index = fixture_index(id);
	assert_true(id != 0 && index < CHURN_MOST_INDICES);
	bool clash = atomic_exchange_explicit(&c->owned[kind][index], 1, memory_order_relaxed) != 0;
	clash |= c->last_ids[kind][index] == id;
	c->last_ids[kind][index] = id;
	atomic_fetch_add_explicit(&c->clashes, clash, memory_order_relaxed);
}

static void churn_disown(churn *c, render_resource_kind kind, uint32_t id)
{
	atomic_store_explicit(&c->owned[kind][fixture_index(id)], 0, memory_order_relaxed);
}

static void churn_create(churn *c, uint32_t number, gpu_thing *thing)
{
	gpu_thing_create(c->render, number, thing);
	churn_own(c, RENDER_RESOURCE_MESH, thing->mesh.id);
	churn_own(c, RENDER_RESOURCE_MATERIAL, thing->material.id);
	churn_own(c, RENDER_RESOURCE_TEXTURE, thing->texture.id);
}

static void churn_destroy(churn *c, const gpu_thing *thing)
{
	churn_disown(c, RENDER_RESOURCE_MESH, thing->mesh.id);
	churn_disown(c, RENDER_RESOURCE_MATERIAL, thing->material.id);
	churn_disown(c, RENDER_RESOURCE_TEXTURE, thing->texture.id);
	gpu_thing_destroy(c->render, thing);
}

static void churn_draw(churn *c, stilb_render_context *context, uint32_t segment, const gpu_thing *thing)
{
	fixture_draw draw = gpu_thing_draw(thing);
	c->draws[segment][c->draw_counts[segment]++] = draw;
	fixture_record(context, &draw);
}

/* Draws new things and those of the last frames, and destroys the oldest. */
static void churn_segment(churn *c, uint32_t segment, uint32_t worker)
{
	stilb_render_context *context = stilb_render_context_get(c->render, worker);
	c->draw_counts[segment] = 0;
	stilb_render_segment_begin(context, 0, segment);
	for (uint32_t i = 0; i < CHURN_EACH; i++) {
		gpu_thing *thing = &c->things[c->frame][segment][i];
		churn_create(c, 1 + (c->frame * CHURN_SEGMENTS + segment) * CHURN_EACH + i, thing);
		for (uint32_t age = 0; age <= CHURN_STAYS && age <= c->frame; age++)
			churn_draw(c, context, segment, &c->things[c->frame - age][segment][i]);
		if (c->frame >= CHURN_STAYS)
			churn_destroy(c, &c->things[c->frame - CHURN_STAYS][segment][i]);
	}
	stilb_render_segment_end(context);
}

static void churn_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	for (uint32_t segment = begin; segment < end; segment++)
		churn_segment(context, segment, worker);
}

/* Creates and destroys resources on a thread outside the pool, at any time, also during replay; some in each frame. */
static void *churn_beside(void *data)
{
	churn *c = data;
	for (uint32_t number = 0x400000; !atomic_load_explicit(&c->stop, memory_order_relaxed);) {
		sched_yield();
		if (number - 0x400000 >= CHURN_BESIDE * atomic_load_explicit(&c->begun, memory_order_relaxed))
			continue;
		gpu_thing thing;
		churn_create(c, number++, &thing);
		sched_yield();
		churn_destroy(c, &thing);
	}
	return NULL;
}

static void churn_frame(churn *c)
{
	atomic_fetch_add_explicit(&c->begun, 1, memory_order_relaxed);
	assert_int_equal(stilb_render_frame_begin(c->render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(c->render, 0, CHURN_SEGMENTS), STILB_OK);
	stilb_job_parallel_for(c->pool, CHURN_SEGMENTS, 1, churn_slice, c, 0);
	assert_int_equal(stilb_render_pass_end(c->render, 0), STILB_OK);
	assert_int_equal(replay(c->render, c->pool), STILB_OK);
	uint64_t hash = REFERENCE_HASH_PASS;
	for (uint32_t s = 0; s < CHURN_SEGMENTS; s++)
		hash = fixture_hash_all(hash, c->draws[s], c->draw_counts[s]);
	assert_true(stilb_render_stream_hash(c->render) == hash);
	assert_int_equal(gpu.wrong, 0);
}

/* The number of indices ever used stays near the number that live at once. */
static void assert_no_growth(const stilb_render *render)
{
	const render_resources *resources = &render->resources;
	uint32_t frames = CHURN_STAYS + 1 + STILB_GPU_FRAMES, things = CHURN_SEGMENTS * CHURN_EACH * frames;
	for (int kind = 0; kind < RENDER_RESOURCE_MAPS; kind++)
		assert_in_range(resources->indices[kind].next_unused, things / 2, 2 * things);
	assert_in_range(resources->heaps[RENDER_HEAP_VERTICES].size, 1, 2 * things * GPU_THING_MOST_VERTICES / 2);
	assert_in_range(resources->heaps[RENDER_HEAP_INDICES_16].size, 1, 2 * things * 30);
	assert_in_range(resources->retired_capacity, 1, 16 * things);
}

static void churn_run(uint32_t workers, int replay_mode, int materials)
{
	churn *c = calloc(1, sizeof *c);
	assert_non_null(c);
	c->pool = fixture_pool(workers, (stilb_job_hooks){0});
	c->render = fixture_render(workers + 1, replay_mode, materials);
	gpu_attach(c->render);
	pthread_t beside;
	assert_int_equal(pthread_create(&beside, NULL, churn_beside, c), 0);
	for (; c->frame < CHURN_FRAMES; c->frame++)
		churn_frame(c);
	atomic_store_explicit(&c->stop, true, memory_order_relaxed);
	assert_int_equal(pthread_join(beside, NULL), 0);
	assert_int_equal(atomic_load_explicit(&c->clashes, memory_order_relaxed), 0);
	assert_no_growth(c->render);
	assert_books(c->render);
	for (uint32_t f = CHURN_FRAMES - CHURN_STAYS; f < CHURN_FRAMES; f++)
		for (uint32_t t = 0; t < CHURN_SEGMENTS * CHURN_EACH; t++)
			churn_destroy(c, &c->things[f][t / CHURN_EACH][t % CHURN_EACH]);
	frames_pass(c->render);
	assert_nothing_lives(c->render);
	gpu_detach(c->render);
	stilb_render_destroy(c->render);
	stilb_job_pool_destroy(c->pool);
	free(c);
}

static void ten_thousand_of_each(void **state)
{
	(void)state;
	churn_run(0, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_INDEX);
	churn_run(3, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_BIND);
	churn_run(8, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_PIPELINE);
	churn_run(2, STILB_RENDER_REPLAY_SECONDARY, STILB_RENDER_MATERIALS_INDEX);
}

/* ---- life times ------------------------------------------------------------------------------------------------- */

#define THINGS 60u

static void things_create(stilb_render *render, gpu_thing *things, uint32_t first, uint32_t count)
{
	for (uint32_t t = first; t < first + count; t++)
		gpu_thing_create(render, t + 1, &things[t]);
}

static void things_destroy(stilb_render *render, const gpu_thing *things, uint32_t first, uint32_t count)
{
	for (uint32_t t = first; t < first + count; t++)
		gpu_thing_destroy(render, &things[t]);
}

/* An index is reused when the frames in flight are done, with another generation. */
static void indices_come_back_later(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_thing things[2] = {0}, next[2] = {0};
	gpu_attach(render);
	things_create(render, things, 0, 2);
	assert_things_drawn(render, things, 2);
	things_destroy(render, things, 1, 1); /* in the frame that draws it */
	uint32_t used = render->resources.heaps[RENDER_HEAP_VERTICES].size;
	for (uint32_t f = 0; f < STILB_GPU_FRAMES - 1; f++) {
		assert_things_drawn(render, things, 1);
		assert_int_equal(render->resources.retired_count, 3);
	}
	things_create(render, next, 0, 1);
	assert_true(fixture_index(next[0].mesh.id) == 2 && fixture_index(next[0].texture.id) == 3);
	assert_true(render->resources.heaps[RENDER_HEAP_VERTICES].size > used);
	assert_things_drawn(render, things, 1);
	assert_int_equal(render->resources.retired_count, 0);
	gpu_thing_create(render, things[1].number, &next[1]);
	assert_int_equal(fixture_index(next[1].mesh.id), fixture_index(things[1].mesh.id));
	assert_int_equal(fixture_index(next[1].texture.id), fixture_index(things[1].texture.id));
	assert_int_equal(fixture_index(next[1].material.id), fixture_index(things[1].material.id));
	assert_true(next[1].mesh.id != things[1].mesh.id && next[1].texture.id != things[1].texture.id);
	assert_true(next[1].material.id != things[1].material.id);
	assert_things_drawn(render, next, 2);
	assert_books(render);
	gpu_detach(render);
	stilb_render_destroy(render);
}

/* An index gives 255 different handles before they repeat, and never 0. */
static void generations_come_round(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_attach(render);
	bool seen[256] = {0};
	for (uint32_t life = 0; life < 600; life++) {
		gpu_thing thing;
		gpu_thing_create(render, 5, &thing);
		uint32_t generation = thing.mesh.id >> 24;
		assert_true(fixture_index(thing.mesh.id) == 0 && generation >= 1);
		assert_true(thing.material.id >> 24 == generation && thing.texture.id >> 24 == generation);
		assert_true(seen[generation] == (life >= 255));
		seen[generation] = true;
		assert_things_drawn(render, &thing, 1);
		gpu_thing_destroy(render, &thing);
		frames_pass(render);
	}
	assert_nothing_lives(render);
	gpu_detach(render);
	stilb_render_destroy(render);
}

static void zero_is_no_handle(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	stilb_render_mesh_destroy(render, (stilb_render_mesh){0});
	stilb_render_texture_destroy(render, (stilb_render_texture){0});
	stilb_render_material_destroy(render, (stilb_render_material){0});
	assert_int_equal(render->resources.retired_count, 0);
	stilb_render_destroy(render);
}

static void assert_scene_is_set(stilb_render *render, const stilb_scene *scene)
{
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		stilb_render_mesh mesh = stilb_render_scene_mesh(render, m);
		assert_int_equal(render->resources.meshes[fixture_index(mesh.id)].index_count, scene->meshes[m].index_count);
	}
	for (uint32_t m = 0; m < scene->material_count; m++) {
		stilb_render_material material = stilb_render_scene_material(render, m);
		uint32_t texture = render->resources.materials[fixture_index(material.id)] & RENDER_INDEX_MASK;
		assert_int_equal(texture > 0, scene->materials[m].diffuse_texture > 0);
	}
}

/* A scene among other resources, in turn with another one, and at last none. */
static void scenes_replace_one_another(void **state)
{
	(void)state;
	stilb_scene *scenes[] = {fixture_scene(40), fixture_scene(7)};
	stilb_image picture;
	assert_int_equal(stilb_image_create(&picture, 2, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	scenes[1]->textures = &picture;
	scenes[1]->texture_count = 1;
	scenes[1]->materials[3].diffuse_texture = 1;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_thing things[16];
	gpu_attach(render);
	things_create(render, things, 0, 16);
	things_destroy(render, things, 0, 16);
	frames_pass(render);
	for (int turn = 0; turn < 200; turn++) {
		assert_scene_is_set(render, scenes[turn % 2]);
		frames_pass(render);
	}
	for (int kind = 0; kind < RENDER_RESOURCE_MAPS; kind++) /* no more than two scenes ever needed */
		assert_in_range(render->resources.indices[kind].next_unused, 1, 16 + 2 * 80 + 2 * 14);
	assert_int_equal(stilb_render_set_scene(render, NULL), STILB_OK);
	frames_pass(render);
	assert_nothing_lives(render);
	gpu_detach(render);
	stilb_render_destroy(render);
	scenes[1]->textures = NULL;
	scenes[1]->texture_count = 0;
	stilb_image_finish(&picture);
	for (int i = 0; i < 2; i++)
		stilb_scene_destroy(scenes[i]);
}

/* ---- frames that are lost or not replayed ----------------------------------------------------------------------- */

static void a_lost_frame_is_made_up_for(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_thing things[THINGS] = {0};
	gpu_attach(render);
	things_create(render, things, 0, 20);
	gpu.losing = true;
	assert_int_equal(draw_things(render, things, 20), STILB_ERROR_DEVICE);
	assert_things_drawn(render, things, 20);
	things_create(render, things, 20, 20);
	things_destroy(render, things, 0, 10);
	gpu.losing = true;
	assert_int_equal(draw_things(render, things + 10, 30), STILB_ERROR_DEVICE);
	things_create(render, things, 40, 20);
	assert_things_drawn(render, things + 10, 50);
	assert_things_drawn(render, things + 10, 50);
	assert_int_equal(render->resources.upload_count, 0);
	assert_books(render);
	gpu_detach(render);
	stilb_render_destroy(render);
}

/* Frames that are begun but never replayed, as when a window is minimised: textures are released before their
 * upload. */
static void frames_without_replay(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_thing things[THINGS];
	gpu_attach(render);
	things_create(render, things, 0, 10);
	for (uint32_t f = 0; f < 2 * STILB_GPU_FRAMES; f++) {
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		if (f == 0)
			things_destroy(render, things, 0, 5);
		assert_books(render);
	}
	things_create(render, things, 0, 3); /* they get the indices of the released ones */
	assert_things_drawn(render, things + 5, 5);
	assert_things_drawn(render, things, 3);
	gpu_detach(render);
	stilb_render_destroy(render);
}

static void a_texture_that_the_device_refuses(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_thing things[2];
	gpu_attach(render);
	things_create(render, things, 0, 1);
	for (int i = 0; i < 20; i++) {
		stilb_render_texture texture = {77};
		atomic_store_explicit(&gpu.texture_result, STILB_ERROR_DEVICE, memory_order_relaxed);
		assert_int_equal(gpu_texture_create(render, 1, &texture), STILB_ERROR_DEVICE);
		assert_int_equal(texture.id, 0);
		assert_books(render);
	}
	things_create(render, things, 1, 1);
	assert_int_equal(fixture_index(things[1].texture.id), 2);
	assert_things_drawn(render, things, 2);
	gpu_detach(render);
	stilb_render_destroy(render);
}

/* ---- no memory -------------------------------------------------------------------------------------------------- */

/* Repeats a call that may run out of memory: after the error everything is as before, and the second try succeeds. */
#define TWICE(render, call)                                                                                            \
	do {                                                                                                               \
		stilb_result first_try = (call);                                                                               \
		assert_true(first_try == STILB_OK || first_try == STILB_ERROR_MEMORY);                                         \
		assert_true(first_try == STILB_OK || allocation_failed());                                                     \
		assert_books(render);                                                                                          \
		if (first_try != STILB_OK) {                                                                                   \
			assert_non_null(strstr(stilb_error_message(), "memory for"));                                              \
			assert_int_equal((call), STILB_OK);                                                                        \
		}                                                                                                              \
	} while (0)

static void things_create_twice(stilb_render *render, gpu_thing *things, uint32_t first, uint32_t count)
{
	for (uint32_t t = first; t < first + count; t++) {
		things[t].number = t + 1;
		TWICE(render, gpu_texture_create(render, t + 1, &things[t].texture));
		TWICE(render, gpu_material_create(render, t + 1, things[t].texture, &things[t].material));
		TWICE(render, gpu_mesh_create(render, t + 1, &things[t].mesh));
	}
}

/* A run in which allocation `number` fails; false: there were fewer. */
static bool a_life_without_memory(const stilb_scene *scene, int64_t number)
{
	gpu_thing things[THINGS] = {0};
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_attach(render);
	allocation_fail(number);
	TWICE(render, stilb_render_set_scene(render, scene));
	things_create_twice(render, things, 0, 20);
	TWICE(render, draw_things(render, things, 20));
	things_destroy(render, things, 5, 10);
	TWICE(render, draw_things(render, things, 5));
	TWICE(render, draw_things(render, things, 5));
	TWICE(render, draw_things(render, things, 5));
	things_create_twice(render, things, 20, 40);
	TWICE(render, draw_things(render, things + 15, 45));
	bool failed = allocation_failed();
	allocation_fail(INT64_MAX);
	assert_things_drawn(render, things + 15, 45);
	things_destroy(render, things, 0, 5);
	things_destroy(render, things, 15, 45);
	frames_pass(render);
	assert_books(render);
	assert_int_equal(render->resources.live, scene->mesh_count + scene->material_count);
	gpu_detach(render);
	stilb_render_destroy(render);
	return failed;
}

static void every_allocation_fails_once(void **state)
{
	(void)state;
	stilb_scene *scene = fixture_scene(20);
	int64_t number = 1;
	while (a_life_without_memory(scene, number))
		number++;
	assert_true(number > 60); /* among others for copies of the pictures */
	stilb_scene_destroy(scene);
}

static void creation_without_memory(void **state)
{
	(void)state;
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL, .width = 8, .height = 8, .context_count = 1};
	stilb_result result = STILB_ERROR_MEMORY;
	int64_t number = 1;
	for (; result != STILB_OK; number++) {
		stilb_render *render;
		allocation_fail(number);
		result = stilb_render_create(&desc, &render);
		allocation_fail(INT64_MAX);
		assert_true(result == STILB_OK || (result == STILB_ERROR_MEMORY && !render));
		stilb_render_destroy(render);
	}
	assert_true(number > 5); /* for the renderer, contexts, three tables */
}

/* ---- bad input -------------------------------------------------------------------------------------------------- */

static void assert_said(stilb_result result, stilb_result expected, const char *part)
{
	assert_int_equal(result, expected);
	if (!strstr(stilb_error_message(), part))
		fail_msg("no '%s' in '%s'", part, stilb_error_message());
}

static void assert_mesh_refused(stilb_render *render, stilb_scene_mesh source, const char *part)
{
	stilb_render_mesh mesh = {7};
	assert_said(stilb_render_mesh_create(render, &source, &mesh), STILB_ERROR_ARGUMENT, part);
	assert_int_equal(mesh.id, 0);
}

static void bad_meshes(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	stilb_scene_vertex vertices[3] = {0};
	uint32_t indices[6] = {0, 1, 2, 2, 3, 0};
	assert_mesh_refused(
		render, (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 6},
		"index 4 of a mesh is vertex 3");
	assert_mesh_refused(
		render, (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 6},
		"3 vertices");
	indices[4] = UINT32_MAX;
	assert_mesh_refused(
		render, (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 6},
		"4294967295");
	assert_mesh_refused(
		render, (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 0, .index_count = 6},
		"0 vertices");
	assert_mesh_refused(
		render, (stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 0},
		"0 indices");
	stilb_scene *scene = fixture_scene(5);
	uint32_t last = scene->meshes[1].index_count - 1, held = scene->meshes[1].indices[last];
	scene->meshes[1].indices[last] = 12345;
	assert_said(stilb_render_set_scene(render, scene), STILB_ERROR_ARGUMENT, "12345");
	scene->meshes[1].indices[last] = held;
	frames_pass(render);
	assert_int_equal(render->resources.live, 0);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	stilb_render_destroy(render);
	stilb_scene_destroy(scene);
}

static void bad_textures(void **state)
{
	(void)state;
	static const struct {
		stilb_image image;
		const char *said;
	} bad[] = {
		{{0, 0, 4, STILB_IMAGE_U8_SRGB, NULL, 0}, "0x0"},
		{{0, 5, 4, STILB_IMAGE_U8_SRGB, NULL, 0}, "0x5"},
		{{20000, 1, 4, STILB_IMAGE_U8_SRGB, NULL, 0}, "20000x1"},
		{{1, 16385, 4, STILB_IMAGE_U8_SRGB, NULL, 0}, "1x16385"},
		{{4, 4, 0, STILB_IMAGE_U8_SRGB, NULL, 0}, "0 channels"},
		{{4, 4, 5, STILB_IMAGE_U8_SRGB, NULL, 0}, "5 channels"},
		{{4, 4, 4, STILB_IMAGE_FORMAT_COUNT, NULL, 0}, "format 14: there are 1..4 and 0..13"},
	};
	stilb_render *render = fixture_render(1, 0, 0);
	for (size_t b = 0; b < sizeof bad / sizeof *bad; b++) {
		stilb_render_texture texture = {7};
		assert_said(stilb_render_texture_create(render, &bad[b].image, &texture), STILB_ERROR_ARGUMENT, bad[b].said);
		assert_int_equal(texture.id, 0);
	}
	assert_int_equal(render->resources.live, 0);
	stilb_render_destroy(render);
}

static void pictures_get_four_channels(void **state)
{
	(void)state;
	static const uint8_t from[4] = {10, 20, 30, 40};
	static const uint8_t to[5][4] = {{0}, {10, 10, 10, 255}, {10, 10, 10, 20}, {10, 20, 30, 255}, {10, 20, 30, 40}};
	stilb_render *render = fixture_render(1, 0, 0);
	for (uint32_t channels = 1; channels <= 4; channels++)
		for (uint32_t format = 0; format <= STILB_IMAGE_U16_LINEAR; format++) {
			uint8_t u8[4];
			uint16_t u16[4];
			float f32[4];
			for (int c = 0; c < 4; c++) {
				u8[c] = from[c];
				u16[c] = from[c];
				f32[c] = (float)from[c];
			}
			bool bytes = format == STILB_IMAGE_U8_SRGB || format == STILB_IMAGE_U8_LINEAR;
			bool floats = format == STILB_IMAGE_F32_LINEAR, srgb = format == STILB_IMAGE_U16_SRGB;
			void *pixels = bytes ? (void *)u8 : floats ? (void *)f32 : u16;
			stilb_image image = {1, 1, channels, (stilb_image_format)format, pixels, 0};
			stilb_render_texture texture;
			assert_int_equal(stilb_render_texture_create(render, &image, &texture), STILB_OK);
			const stilb_image *got = &render->resources.uploads[render->resources.upload_count - 1].pixels.image;
			assert_true(got->channels == 4 && got->width == 1 && got->height == 1);
			assert_int_equal(got->format, srgb ? STILB_IMAGE_F16_LINEAR : image.format);
			for (int c = 0; c < 4; c++) {
				bool one = to[channels][c] == 255, alpha = c == 3;
				uint16_t half = got->format == STILB_IMAGE_F16_LINEAR ? 0x3c00 : 65535;
				/* such small codes are on the transfer's straight part */
				uint16_t word =
					srgb ? stilb_image_half_from_float((float)to[channels][c] / 65535.0f / (alpha ? 1.0f : 12.92f))
						 : to[channels][c];
				if (bytes)
					assert_int_equal(((const uint8_t *)got->pixels)[c], to[channels][c]);
				else if (floats)
					assert_true(((const float *)got->pixels)[c] == (one ? 1.0f : (float)to[channels][c]));
				else
					assert_int_equal(((const uint16_t *)got->pixels)[c], one ? half : word);
			}
		}
	static uint8_t block[8] = {51, 0}; /* BC4: all 51 / 255 */
	stilb_image blocks = {1, 1, 1, STILB_IMAGE_BC4_LINEAR, block, 0};
	stilb_render_texture decoded;
	assert_int_equal(stilb_render_texture_create(render, &blocks, &decoded), STILB_OK);
	const stilb_image *got = &render->resources.uploads[render->resources.upload_count - 1].pixels.image;
	assert_int_equal(got->format, STILB_IMAGE_BC4_LINEAR);
	assert_memory_equal(got->pixels, block, 8);
	render->device->gpu->formats[STILB_GPU_BC4_U] = 0; /* a device without it */
	assert_int_equal(stilb_render_texture_create(render, &blocks, &decoded), STILB_OK);
	got = &render->resources.uploads[render->resources.upload_count - 1].pixels.image;
	assert_int_equal(got->format, STILB_IMAGE_U16_LINEAR);
	assert_memory_equal(got->pixels, ((uint16_t[]){13107, 13107, 13107, 65535}), 8);
	blocks.channels = 2;
	assert_int_equal(stilb_render_texture_create(render, &blocks, &decoded), STILB_ERROR_ARGUMENT);
	stilb_render_destroy(render);
}

/* ---- no index left ---------------------------------------------------------------------------------------------- */

static void no_more_textures(void **state)
{
	(void)state;
	static stilb_render_texture textures[4096];
	stilb_render *render = fixture_render(1, 0, 0);
	gpu_attach(render);
	render->resources.indices[RENDER_RESOURCE_TEXTURE].capacity = 4096; /* a smaller limit */
	uint32_t count = 0;
	stilb_result result;
	while ((result = gpu_texture_create(render, count + 1, &textures[count])) == STILB_OK)
		count++;
	assert_int_equal(count, 4095); /* index 0 means no texture */
	for (int again = 0; again < 3; again++) {
		assert_int_equal(result, STILB_ERROR_ARGUMENT);
		assert_int_equal(textures[count].id, 0);
		assert_non_null(strstr(stilb_error_message(), "no id for another texture"));
		result = gpu_texture_create(render, 9, &textures[count]);
		assert_books(render);
	}
	stilb_render_texture_destroy(render, textures[1000]);
	assert_int_equal(gpu_texture_create(render, 9, &textures[count]),
	                 STILB_ERROR_ARGUMENT); /* the destroyed one is still used by a frame in flight */
	frames_pass(render);
	assert_int_equal(gpu_texture_create(render, 9, &textures[count]), STILB_OK);
	assert_int_equal(fixture_index(textures[count].id), fixture_index(textures[1000].id));
	assert_int_equal(gpu_texture_create(render, 9, &textures[0]), STILB_ERROR_ARGUMENT);
	gpu_detach(render);
	stilb_render_destroy(render);
}

/* As above for meshes and materials, with smaller limits. */
static void no_more_meshes_or_materials(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	stilb_render_mesh mesh;
	stilb_render_material material;
	render->resources.indices[RENDER_RESOURCE_MESH].capacity = 30;
	render->resources.indices[RENDER_RESOURCE_MATERIAL].capacity = 40;
	for (uint32_t i = 0; i < 30; i++)
		assert_int_equal(gpu_mesh_create(render, i, &mesh), STILB_OK);
	for (uint32_t i = 0; i < 40; i++)
		assert_int_equal(gpu_material_create(render, i, (stilb_render_texture){0}, &material), STILB_OK);
	assert_int_equal(gpu_mesh_create(render, 1, &mesh), STILB_ERROR_MEMORY);
	assert_non_null(strstr(stilb_error_message(), "no id for another mesh"));
	assert_int_equal(gpu_material_create(render, 1, (stilb_render_texture){0}, &material), STILB_ERROR_MEMORY);
	assert_non_null(strstr(stilb_error_message(), "no id for another material: at most 40 can exist"));
	assert_true(mesh.id == 0 && material.id == 0);
	assert_books(render);
	stilb_render_destroy(render);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		test_one_thread(ranges_are_sets),
		cmocka_unit_test(ten_thousand_of_each),
		cmocka_unit_test(indices_come_back_later),
		cmocka_unit_test(generations_come_round),
		cmocka_unit_test(zero_is_no_handle),
		cmocka_unit_test(scenes_replace_one_another),
		cmocka_unit_test(a_lost_frame_is_made_up_for),
		cmocka_unit_test(frames_without_replay),
		cmocka_unit_test(a_texture_that_the_device_refuses),
		test_one_thread(every_allocation_fails_once),
		cmocka_unit_test(creation_without_memory),
		cmocka_unit_test(bad_meshes),
		cmocka_unit_test(bad_textures),
		cmocka_unit_test(pictures_get_four_channels),
		cmocka_unit_test(no_more_textures),
		cmocka_unit_test(no_more_meshes_or_materials),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
