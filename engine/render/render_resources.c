/* Meshes and materials: their handles, the arrays they lie in, and what is still to be copied to the device. See
 * render_resources.h, and render_textures.h for textures. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

/* Index of the first range that ends at or behind `first`: the range to join, or the place to insert. */
static uint32_t ranges_find(const render_ranges *ranges, uint32_t first)
{
	uint32_t low = 0, high = ranges->count;
	while (low < high) {
		uint32_t middle = (low + high) / 2;
		if (ranges->items[middle].first + ranges->items[middle].count < first)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

bool render_ranges_is_sound(const render_ranges *ranges)
{
	for (uint32_t i = 0; i < ranges->count; i++) {
		const render_range *range = &ranges->items[i];
		bool apart = i == 0 || range[-1].first + range[-1].count < range->first;
		if (range->count == 0 || range->first > UINT32_MAX - range->count || !apart)
			return false;
	}
	return ranges->count <= ranges->capacity;
}

bool render_ranges_add(render_ranges *ranges, render_range range)
{
	STILB_ASSERT(range.count > 0 && range.first <= UINT32_MAX - range.count);
	uint32_t at = ranges_find(ranges, range.first), end = range.first + range.count, joined = 0;
	for (; at + joined < ranges->count && ranges->items[at + joined].first <= end; joined++) {
		render_range old = ranges->items[at + joined];
		range.first = old.first < range.first ? old.first : range.first;
		end = old.first + old.count > end ? old.first + old.count : end;
	}
	if (joined == 0 && !render_reserve((void **)&ranges->items, &ranges->capacity, ranges->count + 1, sizeof range))
		return false;
	range.count = end - range.first;
	memmove(ranges->items + at + 1, ranges->items + at + joined, (ranges->count - at - joined) * sizeof range);
	ranges->items[at] = range;
	ranges->count += 1 - joined;
	STILB_CHECK(render_ranges_is_sound(ranges));
	return true;
}

bool render_ranges_take(render_ranges *ranges, uint32_t count, uint32_t *first)
{
	STILB_ASSERT(count > 0);
	for (uint32_t i = 0; i < ranges->count; i++) {
		render_range *range = &ranges->items[i];
		if (range->count < count)
			continue;
		*first = range->first;
		range->first += count;
		range->count -= count;
		if (range->count == 0)
			memmove(range, range + 1, (--ranges->count - i) * sizeof *range);
		STILB_CHECK(render_ranges_is_sound(ranges));
		return true;
	}
	return false;
}

/* ---- heaps ------------------------------------------------------------------------------------------------------- */

/* Makes the heap at least `size` elements long. False: no memory, or more elements than a vertex offset can name. */
static bool heap_extend(render_heap *heap, uint64_t size)
{
	STILB_ASSERT(heap->element > 0 && heap->size <= heap->capacity);
	if (size > INT32_MAX) /* a vertex offset is an int32_t */
		return false;
	if (size > heap->capacity) {
		uint64_t larger = (uint64_t)heap->capacity * 2 > size ? (uint64_t)heap->capacity * 2 : size;
		uint8_t *data = realloc(heap->data, larger * heap->element);
		if (!data)
			return false;
		heap->data = data;
		heap->capacity = (uint32_t)larger;
	}
	heap->size = size > heap->size ? (uint32_t)size : heap->size;
	return true;
}

/* Takes the first free range of count elements, else extends the heap, and marks it dirty. live: the number of
 * resources so far, render_resources.live. */
static bool heap_take(render_heap *heap, uint32_t count, uint32_t live, uint32_t *first)
{
	/* Reserved now so that heap_give_back cannot fail: between and around the ranges of `live` resources there are at
	 * most live + 1 free ones, and the new resource may add one. */
	if (!render_reserve((void **)&heap->free.items, &heap->free.capacity, live + 2, sizeof(render_range)))
		return false;
	uint32_t size = heap->size;
	if (!render_ranges_take(&heap->free, count, first)) {
		*first = size;
		if (!heap_extend(heap, (uint64_t)size + count))
			return false;
	}
	if (!render_ranges_add(&heap->dirty, (render_range){*first, count})) {
		render_ranges_add(&heap->free, (render_range){*first, count});
		return false;
	}
	STILB_ASSERT((uint64_t)*first + count <= heap->size && "the range lies in the heap");
	return true;
}

static void heap_copy(render_heap *heap, uint32_t first, const void *data, uint32_t count)
{
	STILB_ASSERT((uint64_t)first + count <= heap->size);
	memcpy(heap->data + (size_t)first * heap->element, data, (size_t)count * heap->element);
}

/* Copies vertices to where they belong in their heap. pairs: as render_vertices_pack. */
static void heap_copy_vertices(render_resources *resources, uint32_t first, const stilb_scene_vertex *vertices,
                               uint32_t count, bool pairs)
{
	render_heap *heap = &resources->heaps[RENDER_HEAP_VERTICES];
	STILB_ASSERT((uint64_t)first + count <= heap->size);
	render_vertices_pack(&resources->layout, vertices, count, pairs, heap->data + (size_t)first * heap->element);
}

static void heap_give_back(render_heap *heap, uint32_t first, uint32_t count)
{
	STILB_ASSERT((uint64_t)first + count <= heap->size && heap->free.count < heap->free.capacity);
	render_ranges_add(&heap->free, (render_range){first, count}); /* cannot fail: see heap_add */
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

bool render_resource_reserve(render_resources *resources, uint32_t more)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	return render_reserve((void **)&resources->retired, &resources->retired_capacity, resources->live + more,
	                      sizeof *resources->retired);
}

stilb_result render_resource_no_memory(const render_resources *resources, render_resource_kind kind)
{
	static const char *const names[RENDER_RESOURCE_KINDS] = {"mesh",    "texture", "material",        "surface",
	                                                         "surface", "surface", "surface function"};
	STILB_ASSERT_LOCKED(&resources->lock);
	const render_indices *indices = &resources->indices[kind];
	uint32_t most = indices->capacity - (kind == RENDER_RESOURCE_TEXTURE); /* index 0 is no texture */
	if (indices->next_unused == indices->capacity && indices->free_count == 0)
		return stilb_fail(kind == RENDER_RESOURCE_TEXTURE ? STILB_ERROR_ARGUMENT : STILB_ERROR_MEMORY,
		                  "no id for another %s: at most %u can exist at once; remove some first", names[kind], most);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for another %s", names[kind]);
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

/* size bytes of zeros; pages get memory when they are first written. NULL: no address space. */
static void *table_reserve(size_t size)
{
	void *table = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
	return table == MAP_FAILED ? NULL : table;
}

#define TABLE_MESHES (STILB_RENDER_MAX_MESHES * sizeof(render_mesh_slot))
#define TABLE_LEVELS (STILB_RENDER_MAX_MESHES * sizeof(render_levels *))
#define TABLE_MATERIALS (STILB_RENDER_MAX_MATERIALS * sizeof(uint32_t))
#define TABLE_CENTERS (STILB_RENDER_MAX_MESHES * sizeof(float[3]))
#define TABLE_LASTS (STILB_RENDER_MAX_MESHES * sizeof(render_last))
#define TABLE_MAPS (RENDER_MAX_MAPS * sizeof(render_maps_slot))
#define TABLE_TEXTURES (STILB_RENDER_MAX_TEXTURES * sizeof(uint32_t))
#define TABLE_GROUPS (RENDER_MAX_MAPS * sizeof(render_group))
#define TABLE_GROUP_CLASSES (RENDER_MAX_MAPS * sizeof(uint32_t))
#define TABLE_CLASSES (RENDER_MAX_MAPS * sizeof(render_class))

stilb_result render_resources_create(render_resources *resources, bool keep_pictures, bool packed)
{
	render_layout layout = render_layout_make(&stilb_scene_vertex_streams, packed);
	*resources = (render_resources){
		.meshes = table_reserve(TABLE_MESHES),
		.levels = table_reserve(TABLE_LEVELS),
		.materials = table_reserve(TABLE_MATERIALS),
		.textures = table_reserve(TABLE_TEXTURES),
		.maps = table_reserve(TABLE_MAPS),
		.centers = table_reserve(TABLE_CENTERS),
		.lasts = table_reserve(TABLE_LASTS),
		.group_classes = table_reserve(TABLE_GROUP_CLASSES),
		.groups = {table_reserve(TABLE_GROUPS), sizeof(render_group), sizeof(struct render_group_key), {0}},
		.classes = {table_reserve(TABLE_CLASSES), sizeof(render_class), sizeof(struct render_class_key), {0}},
		.layout = layout,
		.indices = {[RENDER_RESOURCE_MESH] = {.capacity = STILB_RENDER_MAX_MESHES},
	                [RENDER_RESOURCE_TEXTURE] = {.next_unused = 1, .capacity = STILB_RENDER_MAX_TEXTURES}, /* 0: none */
	                [RENDER_RESOURCE_MATERIAL] = {.capacity = STILB_RENDER_MAX_MATERIALS},
	                [RENDER_RESOURCE_MAPS] = {.capacity = RENDER_MAX_MAPS},
	                [RENDER_RESOURCE_GROUP] = {.capacity = RENDER_MAX_MAPS},
	                [RENDER_RESOURCE_CLASS] = {.capacity = RENDER_MAX_MAPS},
	                [RENDER_RESOURCE_FUNCTION] = {.next_unused = 1, .capacity = RENDER_MAX_FUNCTIONS}}, /* 0: none */
		.heaps = {[RENDER_HEAP_VERTICES] = {.element = layout.size},
	              [RENDER_HEAP_INDICES] = {.element = sizeof(uint32_t)},
	              [RENDER_HEAP_INDICES_16] = {.element = sizeof(uint16_t)},
	              [RENDER_HEAP_MATERIALS] = {.element = sizeof(render_material)},
	              [RENDER_HEAP_MAPS] = {.element = sizeof(render_maps_stored)},
	              [RENDER_HEAP_EXTRAS] = {.element = sizeof(render_extra)},
	              [RENDER_HEAP_LAST] = {.element = sizeof(float[3])},
	              [RENDER_HEAP_EXTRA_PLACES] = {.element = sizeof(render_extra_place)}},
	};
	resources->lock_made = stilb_lock_init(&resources->lock);
	if (keep_pictures)
		resources->pictures = calloc(STILB_RENDER_MAX_TEXTURES, sizeof *resources->pictures);
	if (!resources->meshes || !resources->levels || !resources->materials || !resources->textures || !resources->maps ||
	    !resources->centers || !resources->lasts || !resources->groups.items || !resources->group_classes ||
	    !resources->classes.items || !resources->lock_made || (keep_pictures && !resources->pictures))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the tables of meshes and materials");
	return STILB_OK;
}

static void table_free(void *table, size_t size)
{
	if (table)
		munmap(table, size);
}

void render_resources_destroy(render_resources *resources)
{
	for (uint32_t m = 0; resources->levels && m < resources->indices[RENDER_RESOURCE_MESH].next_unused; m++)
		render_levels_free(resources->levels[m]);
	table_free(resources->meshes, TABLE_MESHES);
	table_free(resources->levels, TABLE_LEVELS);
	table_free(resources->materials, TABLE_MATERIALS);
	table_free(resources->textures, TABLE_TEXTURES);
	table_free(resources->maps, TABLE_MAPS);
	table_free(resources->centers, TABLE_CENTERS);
	table_free(resources->lasts, TABLE_LASTS);
	table_free(resources->groups.items, TABLE_GROUPS);
	table_free(resources->group_classes, TABLE_GROUP_CLASSES);
	table_free(resources->classes.items, TABLE_CLASSES);
	for (int h = 0; h < RENDER_HEAPS; h++) {
		free(resources->heaps[h].data);
		free(resources->heaps[h].free.items);
		free(resources->heaps[h].dirty.items);
	}
	for (int k = 0; k < RENDER_RESOURCE_KINDS; k++)
		free(resources->indices[k].free);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		render_upload_finish(&resources->uploads[u]);
	free(resources->uploads);
	for (uint32_t t = 0; resources->pictures && t < resources->indices[RENDER_RESOURCE_TEXTURE].next_unused; t++)
		render_pixels_finish(&resources->pictures[t]);
	free(resources->pictures);
	free(resources->retired);
	if (resources->lock_made)
		stilb_lock_finish(&resources->lock);
	*resources = (render_resources){0};
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* STILB_ERROR_ARGUMENT names the fault. */
static stilb_result mesh_check(const stilb_scene_mesh *mesh)
{
	if (mesh->vertex_count == 0 || mesh->index_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a mesh of %u vertices and %u indices draws nothing",
		                  mesh->vertex_count, mesh->index_count);
	for (uint32_t i = 0; i < mesh->index_count; i++)
		if (mesh->indices[i] >= mesh->vertex_count)
			return stilb_fail(STILB_ERROR_ARGUMENT, "index %u of a mesh is vertex %u, but it has %u vertices", i,
			                  mesh->indices[i], mesh->vertex_count);
	return render_levels_check(mesh);
}

/* A mesh's ranges in heaps; those of none have the count 0. */
typedef struct mesh_ranges {
	render_range heap[RENDER_HEAPS];
} mesh_ranges;

static void mesh_give_back(render_resources *resources, const mesh_ranges *ranges)
{
	for (int h = 0; h < RENDER_HEAPS; h++)
		if (ranges->heap[h].count > 0)
			heap_give_back(&resources->heaps[h], ranges->heap[h].first, ranges->heap[h].count);
}

/* Takes ranges in the heaps of so many elements as they count. False: no memory, nothing has changed. */
static bool mesh_take(render_resources *resources, mesh_ranges *ranges)
{
	mesh_ranges taken = {0};
	for (int h = 0; h < RENDER_HEAPS; h++) {
		uint32_t count = ranges->heap[h].count;
		if (count == 0)
			continue;
		if (!heap_take(&resources->heaps[h], count, resources->live, &taken.heap[h].first)) {
			mesh_give_back(resources, &taken);
			return false;
		}
		taken.heap[h].count = count;
	}
	*ranges = taken;
	return true;
}

/* The range of its extras. */
static render_range mesh_extras(const render_resources *resources, uint32_t index)
{
	const render_mesh_slot *mesh = &resources->meshes[index];
	if (!(mesh->flags & RENDER_MESH_EXTRAS))
		return (render_range){0};
	const render_extra_place *places = (const render_extra_place *)resources->heaps[RENDER_HEAP_EXTRA_PLACES].data;
	return (render_range){places[index].extra_pairs & ~RENDER_EXTRA_PAIRS, mesh->vertex_count};
}

/* The ranges of a mesh that exists. */
static mesh_ranges mesh_ranges_of(const render_resources *resources, uint32_t index)
{
	const render_mesh_slot *mesh = &resources->meshes[index];
	const render_levels *levels = resources->levels[index];
	mesh_ranges ranges = {.heap = {[RENDER_HEAP_EXTRAS] = mesh_extras(resources, index)}};
	if (mesh->flags & RENDER_MESH_LAST)
		ranges.heap[RENDER_HEAP_LAST] = (render_range){resources->lasts[index].first, mesh->vertex_count};
	if (levels) {
		ranges.heap[RENDER_HEAP_VERTICES] = (render_range){levels->first_vertex, levels->heap_vertices};
		for (int narrow = 0; narrow < 2; narrow++)
			ranges.heap[RENDER_HEAP_INDICES + narrow] =
				(render_range){levels->indices[narrow].first, levels->indices[narrow].count};
		return ranges;
	}
	bool narrow = !(mesh->flags & RENDER_MESH_WIDE);
	ranges.heap[RENDER_HEAP_VERTICES] = (render_range){(uint32_t)mesh->vertex_offset, mesh->vertex_count};
	ranges.heap[RENDER_HEAP_INDICES + narrow] = (render_range){mesh->first_index, mesh->index_count};
	return ranges;
}

static_assert(RENDER_HEAP_INDICES_16 == RENDER_HEAP_INDICES + 1, "the heap of narrow indices comes behind");

/* Takes ranges for a mesh with levels, copies it there, and moves its levels' places there. */
static bool mesh_place_levels(render_resources *resources, const render_levels_data *data)
{
	render_levels *levels = data->levels;
	uint32_t pairs = levels->morphs;
	/* One more vertex, so that the pairs can begin at an even place. */
	mesh_ranges ranges = {.heap = {[RENDER_HEAP_VERTICES] = {0, data->vertex_count + pairs},
	                               [RENDER_HEAP_INDICES] = {0, data->index_count},
	                               [RENDER_HEAP_INDICES_16] = {0, data->narrow_count}}};
	if (!mesh_take(resources, &ranges))
		return false;
	render_range vertices = ranges.heap[RENDER_HEAP_VERTICES];
	uint32_t first_vertex = vertices.first + (pairs & vertices.first & 1);
	heap_copy_vertices(resources, first_vertex, data->vertices, data->vertex_count, pairs);
	const void *const indices[2] = {data->indices, data->narrow};
	for (int narrow = 0; narrow < 2; narrow++) {
		render_range range = ranges.heap[RENDER_HEAP_INDICES + narrow];
		if (range.count > 0)
			heap_copy(&resources->heaps[RENDER_HEAP_INDICES + narrow], range.first, indices[narrow], range.count);
		levels->indices[narrow].first = range.first;
		levels->indices[narrow].count = range.count;
	}
	render_level *level = (render_level *)render_levels_level(levels);
	for (uint32_t l = 0; l <= levels->count + levels->morphs * levels->count; l++) {
		uint32_t own = l <= levels->count ? l : l - levels->count - 1;
		level[l].first_index += levels->indices[own >= levels->wide].first;
		level[l].vertex_offset = (int32_t)first_vertex;
	}
	levels->first_vertex = vertices.first;
	levels->heap_vertices = vertices.count;
	return true;
}

/* The same for a mesh without levels. *full: what its draws copy. */
static bool mesh_place(render_resources *resources, const stilb_scene_mesh *mesh, render_level *full)
{
	bool narrow = mesh->vertex_count <= RENDER_NARROW_VERTICES;
	mesh_ranges ranges = {.heap = {[RENDER_HEAP_VERTICES] = {0, mesh->vertex_count}}};
	ranges.heap[RENDER_HEAP_INDICES + narrow].count = mesh->index_count;
	if (!mesh_take(resources, &ranges))
		return false;
	uint32_t first_vertex = ranges.heap[RENDER_HEAP_VERTICES].first;
	uint32_t first_index = ranges.heap[RENDER_HEAP_INDICES + narrow].first;
	heap_copy_vertices(resources, first_vertex, mesh->vertices, mesh->vertex_count, false);
	uint16_t *out = (uint16_t *)resources->heaps[RENDER_HEAP_INDICES_16].data + (narrow ? first_index : 0);
	for (uint32_t i = 0; narrow && i < mesh->index_count; i++)
		out[i] = (uint16_t)mesh->indices[i];
	if (!narrow)
		heap_copy(&resources->heaps[RENDER_HEAP_INDICES], first_index, mesh->indices, mesh->index_count);
	*full = (render_level){mesh->index_count, 1, first_index, (int32_t)first_vertex};
	return true;
}

/* Makes room for the extras of a mesh that gets this index, if it has some. False: no memory. */
static bool mesh_take_extras(render_resources *resources, const stilb_scene_mesh *mesh, uint32_t index,
                             mesh_ranges *ranges)
{
	render_heap *places = &resources->heaps[RENDER_HEAP_EXTRA_PLACES];
	*ranges = (mesh_ranges){0};
	if (!mesh->extras)
		return true;
	ranges->heap[RENDER_HEAP_EXTRAS].count = mesh->vertex_count;
	return heap_extend(places, (uint64_t)index + 1) && render_ranges_add(&places->dirty, (render_range){index, 1}) &&
	       mesh_take(resources, ranges);
}

/* Puts them there. vertex, pairs: where the mesh's vertices begin, and whether they lie in pairs. */
static void mesh_put_extras(render_resources *resources, const render_extra *extras, uint32_t index,
                            const mesh_ranges *ranges, uint32_t vertex, bool pairs)
{
	render_range range = ranges->heap[RENDER_HEAP_EXTRAS];
	if (range.count == 0)
		return;
	render_extra_place *places = (render_extra_place *)resources->heaps[RENDER_HEAP_EXTRA_PLACES].data;
	heap_copy(&resources->heaps[RENDER_HEAP_EXTRAS], range.first, extras, range.count);
	places[index] =
		(render_extra_place){.vertex = vertex, .extra_pairs = range.first | (pairs ? RENDER_EXTRA_PAIRS : 0)};
}

/* data: of a mesh with levels, which it takes over, else NULL. packed: the mesh's extras. False: no memory or no id;
 * then nothing has changed. */
static bool mesh_add(render_resources *resources, const stilb_scene_mesh *mesh, const render_levels_data *data,
                     const render_extra *packed, uint32_t *handle)
{
	render_indices *ids = &resources->indices[RENDER_RESOURCE_MESH];
	uint32_t index;
	render_level full;
	mesh_ranges extras;
	if (!render_resource_reserve(resources, 1) || !render_index_take(ids, &index))
		return false;
	if (!mesh_take_extras(resources, mesh, index, &extras)) {
		render_index_give_back(ids, index);
		return false;
	}
	if (data ? !mesh_place_levels(resources, data) : !mesh_place(resources, mesh, &full)) {
		mesh_give_back(resources, &extras);
		render_index_give_back(ids, index);
		return false;
	}
	if (data)
		full = *render_levels_level(data->levels);
	mesh_put_extras(resources, packed, index, &extras, (uint32_t)full.vertex_offset, data && data->levels->morphs);
	bool wide = data ? data->levels->wide > 0 : mesh->vertex_count > RENDER_NARROW_VERTICES;
	resources->levels[index] = data ? data->levels : NULL;
	render_mesh_slot *slot = &resources->meshes[index];
	*slot = (render_mesh_slot){
		.first_index = full.first_index,
		.index_count = full.index_count,
		.instance_count = 1,
		.vertex_offset = full.vertex_offset,
		.vertex_count = mesh->vertex_count,
		.generation = slot->generation ? slot->generation : 1,
		.name = index,
		.flags =
			(data ? RENDER_MESH_LEVELS : 0) | (wide ? RENDER_MESH_WIDE : 0) | (mesh->extras ? RENDER_MESH_EXTRAS : 0),
	};
	resources->live++;
	*handle = render_handle_make(slot->generation, index);
	return true;
}

stilb_result stilb_render_mesh_create(stilb_render *render, const stilb_scene_mesh *mesh, stilb_render_mesh *out)
{
	STILB_ASSERT(mesh && out);
	render_resources *resources = &render->resources;
	render_levels_data data = {.vertices = mesh->vertices};
	*out = (stilb_render_mesh){0};
	stilb_result result = mesh_check(mesh);
	if (result != STILB_OK)
		return result;
	render_extra *extras = mesh->extras ? stilb_memory_alloc(mesh->vertex_count, sizeof *extras) : NULL;
	if (mesh->extras && !extras)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the tangents and colours of a mesh of %u vertices",
		                  mesh->vertex_count);
	if ((mesh->level_count > 0 || mesh->cluster_count > 0) && !render_levels_make(mesh, resources->morph, &data)) {
		free(extras);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of a mesh of %u vertices", mesh->vertex_count);
	}
	if (extras) /* before the lock, for which frames wait */
		render_extras_pack(mesh->extras, mesh->vertex_count, extras);
	stilb_lock_take(&resources->lock);
	if (!mesh_add(resources, mesh, data.levels ? &data : NULL, extras, &out->id)) {
		render_levels_free(data.levels);
		result = render_resource_no_memory(resources, RENDER_RESOURCE_MESH);
	}
	stilb_lock_give(&resources->lock);
	render_levels_finish(&data, mesh);
	free(extras);
	return result;
}

void render_mesh_name(stilb_render *render, stilb_render_mesh mesh, uint32_t name)
{
	render_mesh_slot *slot = &render->resources.meshes[mesh.id & RENDER_INDEX_MASK];
	STILB_ASSERT(slot->generation == mesh.id >> RENDER_GENERATION_SHIFT && "a mesh that exists");
	slot->name = name;
}

/* Keeps where all vertices of a mesh are, before some are written for the first time since the last frame. False: no
 * memory. */
static bool mesh_keep_last(render_resources *resources, uint32_t index)
{
	render_mesh_slot *slot = &resources->meshes[index];
	render_last *last = &resources->lasts[index];
	render_heap *heap = &resources->heaps[RENDER_HEAP_LAST];
	const render_heap *vertices = &resources->heaps[RENDER_HEAP_VERTICES];
	bool kept = slot->flags & RENDER_MESH_LAST;
	if (kept && last->drawn == resources->drawn)
		return true;
	if (kept ? !render_ranges_add(&heap->dirty, (render_range){last->first, slot->vertex_count})
	         : !heap_take(heap, slot->vertex_count, resources->live, &last->first))
		return false;
	slot->flags |= RENDER_MESH_LAST;
	last->drawn = resources->drawn;
	const uint8_t *from = vertices->data + (size_t)slot->vertex_offset * vertices->element;
	uint8_t *to = heap->data + (size_t)last->first * heap->element;
	STILB_ASSERT(!resources->layout.attributes[0].octahedral && resources->layout.attributes[0].components == 3);
	from += resources->layout.attributes[0].to;
	for (uint32_t v = 0; v < slot->vertex_count; v++, from += vertices->element, to += heap->element)
		memcpy(to, from, sizeof(float[3]));
	return true;
}

stilb_result render_mesh_write(stilb_render *render, stilb_render_mesh mesh, uint32_t first, uint32_t count,
                               const stilb_scene_vertex *vertices, const stilb_scene_vertex_extra *extras)
{
	render_resources *resources = &render->resources;
	render_mesh_slot *slot = &resources->meshes[mesh.id & RENDER_INDEX_MASK];
	STILB_ASSERT(slot->generation == mesh.id >> RENDER_GENERATION_SHIFT && "a mesh that exists");
	STILB_ASSERT(count > 0 && first <= slot->vertex_count && count <= slot->vertex_count - first);
	STILB_ASSERT(!(slot->flags & RENDER_MESH_LEVELS) && "whose errors would hold no longer");
	stilb_lock_take(&resources->lock);
	render_heap *heap = &resources->heaps[RENDER_HEAP_VERTICES];
	render_range range = {(uint32_t)slot->vertex_offset + first, count};
	bool listed = !resources->keeps_last || mesh_keep_last(resources, mesh.id & RENDER_INDEX_MASK);
	listed = listed && render_ranges_add(&heap->dirty, range);
	if (listed) {
		heap_copy_vertices(resources, range.first, vertices, count, false);
		slot->flags &= ~RENDER_MESH_CENTER;
	}
	if (listed && extras && slot->flags & RENDER_MESH_EXTRAS) {
		render_heap *own = &resources->heaps[RENDER_HEAP_EXTRAS];
		range.first = mesh_extras(resources, mesh.id & RENDER_INDEX_MASK).first + first;
		listed = render_ranges_add(&own->dirty, range);
		render_extras_pack(extras, count, (render_extra *)(void *)(own->data + (size_t)range.first * own->element));
	}
	stilb_lock_give(&resources->lock);
	return listed ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of changed vertices");
}

const float *render_mesh_center(render_resources *resources, uint32_t index)
{
	render_mesh_slot *slot = &resources->meshes[index];
	const render_levels *levels = resources->levels[index];
	float *center = resources->centers[index], low[3], high[3];
	STILB_ASSERT_LOCKED(&resources->lock);
	STILB_ASSERT(slot->vertex_count > 0);
	if (slot->flags & RENDER_MESH_CENTER)
		return center;
	const render_heap *heap = &resources->heaps[RENDER_HEAP_VERTICES];
	size_t step = heap->element * (levels && levels->morphs ? (size_t)2 : 1);
	const uint8_t *at = heap->data + (size_t)slot->vertex_offset * heap->element + resources->layout.attributes[0].to;
	STILB_ASSERT(!resources->layout.attributes[0].octahedral && resources->layout.attributes[0].components == 3);
	memcpy(low, at, sizeof low);
	memcpy(high, low, sizeof high);
	for (uint32_t v = 1; v < slot->vertex_count; v++) {
		float place[3];
		memcpy(place, at += step, sizeof place);
		for (int c = 0; c < 3; c++) {
			low[c] = place[c] < low[c] ? place[c] : low[c];
			high[c] = place[c] > high[c] ? place[c] : high[c];
		}
	}
	for (int c = 0; c < 3; c++)
		center[c] = 0.5f * low[c] + 0.5f * high[c];
	slot->flags |= RENDER_MESH_CENTER;
	return center;
}

/* ---- functions of surfaces --------------------------------------------------------------------------------------- */

stilb_result render_function_create(stilb_render *render, const stilb_scene_function *from, uint32_t *index)
{
	render_resources *resources = &render->resources;
	render_function *function;
	*index = 0;
	stilb_result result = render_function_make(render->device, from, &function);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&resources->lock);
	if (!render_resource_reserve(resources, 1) ||
	    !render_index_take(&resources->indices[RENDER_RESOURCE_FUNCTION], index))
		result = render_resource_no_memory(resources, RENDER_RESOURCE_FUNCTION);
	else {
		resources->live++;
		render_programs_set_function(render->device, *index, function);
	}
	stilb_lock_give(&resources->lock);
	if (result != STILB_OK)
		render_function_free(function);
	return result;
}

void render_function_destroy(stilb_render *render, uint32_t index)
{
	if (index == 0)
		return;
	stilb_lock_take(&render->resources.lock);
	render_resource_retire(&render->resources, RENDER_RESOURCE_FUNCTION, index);
	stilb_lock_give(&render->resources.lock);
}

void render_function_release(stilb_render *render, uint32_t index)
{
	STILB_ASSERT_LOCKED(&render->resources.lock);
	render_programs_set_function(render->device, index, NULL);
}

/* ---- maps of materials ------------------------------------------------------------------------------------------- */

/* Puts maps at an index that is taken, whose record's range is in the list of what has changed, and their material into
 * its group. */
static stilb_result maps_put(stilb_render *render, uint32_t index, const render_maps *maps)
{
	render_resources *resources = &render->resources;
	render_maps_slot *slot = &resources->maps[index];
	render_maps_stored *stored = (render_maps_stored *)resources->heaps[RENDER_HEAP_MAPS].data + index;
	uint32_t group;
	stilb_result result = render_group_join(render, maps, index, &group);
	if (result != STILB_OK)
		return result;
	if (slot->group > 0)
		render_group_leave(render, slot->group - 1, true);
	*stored = (render_maps_stored){.record = maps->record};
	memcpy(stored->parameters, maps->parameters, sizeof stored->parameters);
	for (uint32_t i = 0; i < RENDER_MAPS; i++)
		if (maps->bits >> i & 1u)
			stored->layers[i] = (float)render->device->textures[maps->textures[i] & RENDER_INDEX_MASK].layer;
	slot->hash = render_maps_hash(maps);
	slot->bits = maps->bits;
	slot->group = group + 1;
	memcpy(slot->textures, maps->textures, sizeof slot->textures);
	memcpy(slot->samplers, maps->samplers, sizeof slot->samplers);
	return STILB_OK;
}

static stilb_result maps_add(stilb_render *render, const render_maps *maps, uint32_t *index)
{
	render_resources *resources = &render->resources;
	render_heap *heap = &resources->heaps[RENDER_HEAP_MAPS];
	render_indices *ids = &resources->indices[RENDER_RESOURCE_MAPS];
	STILB_ASSERT_LOCKED(&resources->lock);
	if (!render_resource_reserve(resources, 3) || !render_index_take(ids, index)) /* with a group, and the material */
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the surface of a material, of which %u can have one",
		                  RENDER_MAX_MAPS);
	stilb_result result = STILB_OK;
	if (!heap_extend(heap, (uint64_t)*index + 1) || !render_ranges_add(&heap->dirty, (render_range){*index, 1}))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the surface of a material");
	if (result == STILB_OK)
		result = maps_put(render, *index, maps);
	if (result != STILB_OK)
		render_index_give_back(ids, *index);
	else
		resources->live++;
	return result;
}

static stilb_result maps_set(stilb_render *render, uint32_t index, const render_maps *maps)
{
	render_resources *resources = &render->resources;
	STILB_ASSERT_LOCKED(&resources->lock);
	if (!render_resource_reserve(resources, 1) ||
	    !render_ranges_add(&resources->heaps[RENDER_HEAP_MAPS].dirty, (render_range){index, 1}))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of changed surfaces");
	return maps_put(render, index, maps);
}

static void maps_release(stilb_render *render, uint32_t index)
{
	STILB_ASSERT_LOCKED(&render->resources.lock);
	render_group_leave(render, render->resources.maps[index].group - 1, false);
	render->resources.maps[index] = (render_maps_slot){0};
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

/* What a material that names maps has in its record and in its entry of render_resources.materials. */
typedef struct material_maps {
	uint32_t index, entry;
} material_maps;

static material_maps material_maps_of(const render_resources *resources, uint32_t index)
{
	return (material_maps){index, (resources->maps[index].group - 1) | RENDER_STATE_MAPS};
}

/* Index of the maps of a material whose entry has RENDER_STATE_MAPS. */
static uint32_t material_maps_index(const render_resources *resources, uint32_t material)
{
	return ((const render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data)[material].maps;
}

static render_material material_make(const stilb_scene_material *material, uint32_t name, uint32_t maps)
{
	render_material out = {.roughness = material->roughness,
	                       .anisotropy = material->anisotropy,
	                       .wrap = material->wrap,
	                       .name = name,
	                       .maps = maps};
	memcpy(out.diffuse, material->diffuse, sizeof out.diffuse);
	memcpy(out.specular, material->specular, sizeof out.specular);
	memcpy(out.emission, material->emission, sizeof out.emission);
	return out;
}

/* maps: their entry is that of render_resources.materials, without the generation, also of a material without maps.
 * False: no memory or no id; then nothing has changed. */
static bool material_add(render_resources *resources, const stilb_scene_material *material, material_maps maps,
                         uint32_t *handle)
{
	render_heap *heap = &resources->heaps[RENDER_HEAP_MATERIALS];
	render_indices *ids = &resources->indices[RENDER_RESOURCE_MATERIAL];
	uint32_t index;
	if (!render_resource_reserve(resources, 1) || !render_index_take(ids, &index))
		return false;
	if (!heap_extend(heap, (uint64_t)index + 1) || !render_ranges_add(&heap->dirty, (render_range){index, 1})) {
		render_index_give_back(ids, index);
		return false;
	}
	((render_material *)heap->data)[index] = material_make(material, index, maps.index);
	uint32_t generation = resources->materials[index] >> RENDER_GENERATION_SHIFT;
	generation = generation ? generation : 1;
	resources->materials[index] = render_handle_make(generation, maps.entry);
	resources->live++;
	*handle = render_handle_make(generation, index);
	return true;
}

/* kind: further bits of its draws' state. */
static stilb_result material_create(stilb_render *render, const stilb_scene_material *material,
                                    stilb_render_texture texture, uint32_t kind, stilb_render_material *out)
{
	STILB_ASSERT(material && out);
	render_resources *resources = &render->resources;
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	*out = (stilb_render_material){0};
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(texture.id == 0 || render_texture_is_valid(resources, texture.id));
	stilb_result result = STILB_OK;
	if (!material_add(resources, material, (material_maps){0, index | kind}, &out->id))
		result = render_resource_no_memory(resources, RENDER_RESOURCE_MATERIAL);
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result stilb_render_material_create(stilb_render *render, const stilb_scene_material *material,
                                          stilb_render_texture texture, stilb_render_material *out)
{
	return material_create(render, material, texture, 0, out);
}

stilb_result render_material_create_impostor(stilb_render *render, const stilb_scene_material *material,
                                             stilb_render_texture texture, stilb_render_material *out)
{
	STILB_ASSERT(texture.id != 0);
	return material_create(render, material, texture, RENDER_STATE_IMPOSTOR, out);
}

stilb_result render_material_create_maps(stilb_render *render, const stilb_scene_material *material,
                                         const render_maps *maps, stilb_render_material *out)
{
	STILB_ASSERT(material && maps && out);
	render_resources *resources = &render->resources;
	uint32_t index = 0;
	*out = (stilb_render_material){0};
	stilb_lock_take(&resources->lock);
	stilb_result result = maps_add(render, maps, &index);
	if (result == STILB_OK && !material_add(resources, material, material_maps_of(resources, index), &out->id)) {
		render_resource_retire(resources, RENDER_RESOURCE_MAPS,
		                       index); /* no frame has them, but may not free them now */
		result = render_resource_no_memory(resources, RENDER_RESOURCE_MATERIAL);
	}
	stilb_lock_give(&resources->lock);
	return result;
}

void render_material_name(stilb_render *render, stilb_render_material material, uint32_t name)
{
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock); /* another thread's new material may move the heap */
	((render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data)[material.id & RENDER_INDEX_MASK].name = name;
	stilb_lock_give(&resources->lock);
}

/* Writes a material's record and entry; the range is in the list of what has changed. */
static void material_put(render_resources *resources, uint32_t index, const stilb_scene_material *from,
                         material_maps maps)
{
	render_material *to = (render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data + index;
	uint32_t *now = &resources->materials[index], old = to->maps;
	bool loses = *now & RENDER_STATE_MAPS && !(maps.entry & RENDER_STATE_MAPS);
	*to = material_make(from, to->name, maps.index);
	*now = render_handle_make(*now >> RENDER_GENERATION_SHIFT, maps.entry);
	if (loses)
		render_resource_retire(resources, RENDER_RESOURCE_MAPS, old);
}

stilb_result render_material_write_maps(stilb_render *render, stilb_render_material material,
                                        const stilb_scene_material *from, stilb_render_texture texture,
                                        const render_maps *maps)
{
	render_resources *resources = &render->resources;
	uint32_t index = material.id & RENDER_INDEX_MASK, now = resources->materials[index], made = 0;
	STILB_ASSERT(now >> RENDER_GENERATION_SHIFT == material.id >> RENDER_GENERATION_SHIFT);
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(texture.id == 0 || (render_texture_is_valid(resources, texture.id) && !maps));
	stilb_result result = STILB_OK;
	if (!render_ranges_add(&resources->heaps[RENDER_HEAP_MATERIALS].dirty, (render_range){index, 1}))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of changed materials");
	else if (maps && now & RENDER_STATE_MAPS)
		result = maps_set(render, made = material_maps_index(resources, index), maps);
	else if (maps)
		result = maps_add(render, maps, &made);
	if (result == STILB_OK)
		material_put(resources, index, from,
		             maps ? material_maps_of(resources, made) : (material_maps){0, texture.id & RENDER_INDEX_MASK});
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result render_material_write(stilb_render *render, stilb_render_material material,
                                   const stilb_scene_material *from, stilb_render_texture texture)
{
	return render_material_write_maps(render, material, from, texture, NULL);
}

/* ---- destruction ------------------------------------------------------------------------------------------------- */

static void mesh_retire(render_resources *resources, uint32_t handle)
{
	uint32_t index = handle & RENDER_INDEX_MASK, *generation = &resources->meshes[index].generation;
	STILB_ASSERT(index < STILB_RENDER_MAX_MESHES && *generation && "a mesh that exists");
	STILB_ASSERT(*generation == handle >> RENDER_GENERATION_SHIFT && "destroyed once");
	*generation = render_generation_after(*generation);
	render_resource_retire(resources, RENDER_RESOURCE_MESH, index);
}

static void material_retire(render_resources *resources, uint32_t handle)
{
	uint32_t index = handle & RENDER_INDEX_MASK, *entry = &resources->materials[index];
	STILB_ASSERT(*entry >> RENDER_GENERATION_SHIFT && "a material that exists");
	STILB_ASSERT(*entry >> RENDER_GENERATION_SHIFT == handle >> RENDER_GENERATION_SHIFT && "destroyed once");
	*entry = render_handle_make(render_generation_after(*entry >> RENDER_GENERATION_SHIFT), *entry & RENDER_INDEX_MASK);
	if (*entry & RENDER_STATE_MAPS)
		render_resource_retire(resources, RENDER_RESOURCE_MAPS, material_maps_index(resources, index));
	render_resource_retire(resources, RENDER_RESOURCE_MATERIAL, index);
}

void stilb_render_mesh_destroy(stilb_render *render, stilb_render_mesh mesh)
{
	if (mesh.id == 0)
		return;
	stilb_lock_take(&render->resources.lock);
	mesh_retire(&render->resources, mesh.id);
	stilb_lock_give(&render->resources.lock);
}

void stilb_render_material_destroy(stilb_render *render, stilb_render_material material)
{
	if (material.id == 0)
		return;
	stilb_lock_take(&render->resources.lock);
	material_retire(&render->resources, material.id);
	stilb_lock_give(&render->resources.lock);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Of a group that is in use again nothing is released. False: it is not due yet. */
static bool resource_release(stilb_render *render, render_retired retired)
{
	render_resources *resources = &render->resources;
	STILB_ASSERT_LOCKED(&resources->lock);
	STILB_ASSERT(resources->live > 0);
	if (retired.kind == RENDER_RESOURCE_GROUP)
		return render_group_release(render, retired.index);
	if (retired.kind == RENDER_RESOURCE_MESH) {
		mesh_ranges ranges = mesh_ranges_of(resources, retired.index);
		mesh_give_back(resources, &ranges);
		render_levels_free(resources->levels[retired.index]);
		resources->levels[retired.index] = NULL;
	} else if (retired.kind == RENDER_RESOURCE_TEXTURE) {
		render_uploads_forget(resources, retired.index);
		render_device_texture_destroy(render->device, retired.index);
		if (resources->pictures)
			render_pixels_finish(&resources->pictures[retired.index]);
	} else if (retired.kind == RENDER_RESOURCE_MAPS) {
		maps_release(render, retired.index);
	} else if (retired.kind == RENDER_RESOURCE_FUNCTION) {
		render_function_release(render, retired.index);
	}
	render_index_give_back(&resources->indices[retired.kind], retired.index);
	resources->live--;
	return true;
}

/* At most so many meshes, textures and surfaces are released in one frame, which bounds its time when a large scene
 * goes: heap_give_back costs 60 ns in a heap of 1,000 holes and 1 us in one of 50,000. A material costs nothing. A
 * program that destroys more in each frame pays for that many: else what waits would grow without end. */
#define RESOURCES_RELEASED_A_FRAME 1024u

/* How many this frame may release: at least a quarter more than were destroyed since the last. */
static uint32_t resources_release_limit(render_resources *resources)
{
	uint32_t steady = resources->retired_now + resources->retired_now / 4;
	resources->retired_now = 0;
	return steady > RESOURCES_RELEASED_A_FRAME ? steady : RESOURCES_RELEASED_A_FRAME;
}

void render_resources_frame(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock);
	uint64_t frame = ++resources->frame;
	uint32_t kept = 0, released = 0, limit = resources_release_limit(resources);
	for (uint32_t i = 0; i < resources->retired_count; i++) {
		render_retired retired = resources->retired[i];
		bool due = retired.frame + STILB_GPU_FRAMES <= frame && released < limit;
		released += due && retired.kind != RENDER_RESOURCE_MATERIAL;
		if (!due || !resource_release(render, retired))
			resources->retired[kept++] = retired;
	}
	resources->retired_count = kept;
	stilb_lock_give(&resources->lock);
}

stilb_result render_resources_update(stilb_render *render)
{
	PROFILE("upload");
	STILB_ASSERT_OWNER(render->owner);
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock);
	render_uploads_choose(resources);
	stilb_result result = render_device_update(render->device, resources);
	resources->sending = true;
	for (int h = 0; h < RENDER_HEAPS; h++)
		resources->heaps[h].dirty.count = 0;
	stilb_lock_give(&resources->lock);
	return result;
}

void render_resources_sent(stilb_render *render, bool submitted)
{
	STILB_ASSERT_OWNER(render->owner);
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock);
	if (submitted) {
		render_uploads_sent(resources);
		resources->drawn++;
	}
	for (uint32_t u = 0; u < resources->upload_count; u++)
		resources->uploads[u].sent = 0;
	for (int h = 0; h < RENDER_HEAPS && !submitted; h++) {
		render_heap *heap = &resources->heaps[h];
		if (heap->dirty.capacity == 0)
			continue; /* nothing has ever been in this heap */
		heap->dirty.items[0] = (render_range){0, heap->size};
		heap->dirty.count = 1;
	}
	resources->sending = false;
	stilb_lock_give(&resources->lock);
}

uint64_t render_resources_pending(render_resources *resources)
{
	stilb_lock_take(&resources->lock);
	uint64_t bytes = render_uploads_left(resources);
	for (int h = 0; h < RENDER_HEAPS; h++)
		for (uint32_t r = 0; r < resources->heaps[h].dirty.count; r++)
			bytes += (uint64_t)resources->heaps[h].dirty.items[r].count * resources->heaps[h].element;
	stilb_lock_give(&resources->lock);
	return bytes;
}

void render_resources_expect(render_resources *resources, const uint32_t more[RENDER_HEAPS])
{
	stilb_lock_take(&resources->lock);
	for (int h = 0; h < RENDER_HEAPS; h++) {
		uint64_t size = more ? (uint64_t)resources->heaps[h].size + more[h] : 0;
		resources->expected[h] = size < UINT32_MAX ? (uint32_t)size : UINT32_MAX;
	}
	stilb_lock_give(&resources->lock);
}
