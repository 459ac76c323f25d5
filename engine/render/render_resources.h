/*
 * Meshes, textures (textures/render_textures.h) and materials: their handles, their data and its way to the device.
 * Inside render/.
 *
 * Handles.  The low 24 bits index a table, the high 8 are the entry's generation, so that a stale handle is noticed.
 *           Tables are reserved at their full size and never move: recording reads an entry without a lock.
 * Heaps.    Vertices, indices and materials lie in arrays that the device mirrors at the same offsets. Creating a
 *           resource writes into them under the lock and marks the range dirty; replay copies dirty ranges to the
 *           device. Indices of a mesh or level that uses at most 65,536 vertices have 16 bits, and an array of their
 *           own.
 * Retiring. A destroyed resource may belong to a frame that the device still draws, so its index and its ranges are
 *           reused only after that frame is done.
 * Threads.  Creation and destruction are [any-thread] and take the lock; the functions below are [main-thread].
 */
#ifndef STILB_RENDER_RESOURCES_H
#define STILB_RENDER_RESOURCES_H

#include "base/base_contract.h"
#include "render/maps/render_groups.h"
#include "render/maps/render_maps.h"
#include "render/render.h"
#include "render/render_vertex.h"
#include "render/textures/render_textures.h"

#define RENDER_INDEX_MASK 0xffffffu
#define RENDER_GENERATION_SHIFT 24u

/* The generation after this one: 1..255 and then 1 again, because 0 marks an entry that was never used. */
static inline uint32_t render_generation_after(uint32_t generation)
{
	return generation < 255 ? generation + 1 : 1;
}

static inline uint32_t render_handle_make(uint32_t generation, uint32_t index)
{
	STILB_ASSERT(generation >= 1 && generation <= 255 && index <= RENDER_INDEX_MASK);
	return generation << RENDER_GENERATION_SHIFT | index;
}

/* A level of a mesh: what its draws copy into the first 16 bytes of their render_command. */
typedef struct render_level {
	_Alignas(16) uint32_t index_count;
	uint32_t instance_count; /* 1 */
	uint32_t first_index;
	int32_t vertex_offset;
} render_level;

/* A mesh's ranges in the vertex and index heaps. It begins with the render_level of the mesh in full. */
typedef struct render_mesh_slot {
	_Alignas(32) uint32_t index_count;
	uint32_t instance_count; /* 1 */
	uint32_t first_index;
	int32_t vertex_offset;
	uint32_t vertex_count;
	uint32_t generation; /* equals the high 8 bits of a valid handle; 0: the slot was never used */
	uint32_t name;       /* what the stream hash and dumps call it: its id in the scene, else its index here */
	uint32_t flags;      /* RENDER_MESH_... */
} render_mesh_slot;

#define RENDER_MESH_LEVELS 1u /* render_resources.levels has an entry for it */
#define RENDER_MESH_WIDE 2u   /* its indices have 32 bits; of one with levels: those of the mesh in full */
#define RENDER_MESH_EXTRAS 4u /* its vertices have extras */
#define RENDER_MESH_CENTER 8u /* render_resources.centers has its middle */
#define RENDER_MESH_LAST 16u  /* render_resources.lasts has where its vertices were */

static_assert(sizeof(render_level) == 16 && sizeof(render_mesh_slot) == 32, "two slots in a cache line");

typedef struct render_clusters render_clusters; /* render_clusters.h */

/* Where the vertices of a mesh were. */
typedef struct render_last {
	uint32_t first; /* of its range in RENDER_HEAP_LAST */
	uint64_t drawn; /* render_resources.drawn when they were written: in a later frame they have not moved */
} render_last;

/* How the levels of a mesh morph to the next: see render_detail_morph. */
typedef struct render_morph {
	int32_t begin; /* bits of the float that is the square of the next one's error in terms of the allowed one */
	float pace;    /* 64ths of the way for each bit less */
} render_morph;

/* The levels of a mesh, and its clusters; constant from its creation to its release. Behind it lie float
 * squared[4 * groups], the squares of the levels' errors, ascending, and infinite beyond them; then render_level
 * level[count + 1], of which the first is the mesh in full; then with morphs render_level morph[count]; then uint32_t
 * vertices[count], how many of the mesh's first vertices each level uses; then render_morph begins[count + 1]. Indices
 * lie in their heaps in the order of the levels: those of the first levels, which may have too many vertices for 16
 * bits, in that of 32 bits, and those of the others in the other one. Those of clusters that are from groups lie in
 * that of 32 bits behind the last level. A mesh with clusters alone has no levels, count 0.
 *
 * With morphs, the mesh's vertices lie in the heap in pairs, from an even place on: the vertex, and where it morphs to.
 * Indices of a level name the first of a pair. morph[l] has the triangles of level[l], but names the second one for
 * vertices that level[l + 1] does not use. */
typedef struct render_levels {
	_Alignas(16) uint32_t count;          /* without the mesh in full */
	uint32_t groups, morphs;              /* 0: without morph, else 1 */
	uint32_t wide;                        /* the first so many levels have 32 bit indices; the mesh in full is one */
	uint32_t first_vertex, heap_vertices; /* its ranges in the heaps */
	struct {
		uint32_t first, count; /* 0: none */
	} indices[2];              /* of 32 bits; of 16 bits */
	render_clusters *clusters; /* NULL: none; else the mesh in full has 32 bit indices, and morphs is 0 */
} render_levels;

static_assert(sizeof(render_levels) == 48, "what lies behind it is aligned");

/* The largest number of vertices whose indices have 16 bits. */
#define RENDER_NARROW_VERTICES 65536u

static inline bool render_levels_have_clusters(const render_levels *levels)
{
	return levels && levels->clusters;
}

static inline const float *render_levels_squared(const render_levels *levels)
{
	return (const float *)(levels + 1);
}

static inline const render_level *render_levels_level(const render_levels *levels)
{
	return (const render_level *)(render_levels_squared(levels) + (size_t)4 * levels->groups);
}

static inline const uint32_t *render_levels_vertices(const render_levels *levels)
{
	return (const uint32_t *)(render_levels_level(levels) + 1 + levels->count + levels->morphs * (size_t)levels->count);
}

static inline const render_morph *render_levels_begins(const render_levels *levels)
{
	return (const render_morph *)(render_levels_vertices(levels) + levels->count);
}

/* A material as the fragment shader reads it (shaders/mesh.glsl). */
typedef struct render_material {
	float diffuse[3], roughness;
	float specular[3], anisotropy;
	float emission[3], wrap;
	uint32_t name; /* as a mesh's; no shader reads it */
	uint32_t maps; /* of one that has some: their index */
	uint32_t unused[2];
} render_material;

static_assert(sizeof(render_material) == 64, "std430: four vec4");

/* Elements first .. first + count - 1 of a heap. */
typedef struct render_range {
	uint32_t first, count;
} render_range;

/* A set of elements: not empty, ascending and disjoint ranges, of which no two touch. */
typedef struct render_ranges {
	render_range *items;
	uint32_t count, capacity;
} render_ranges;

typedef enum render_heap_kind {
	RENDER_HEAP_VERTICES,
	RENDER_HEAP_INDICES,    /* of 32 bits */
	RENDER_HEAP_INDICES_16, /* of 16 bits */
	RENDER_HEAP_MATERIALS,
	RENDER_HEAP_MAPS,         /* render_maps_stored, by index */
	RENDER_HEAP_EXTRAS,       /* render_extra */
	RENDER_HEAP_LAST,         /* three floats a vertex: where it was in the frame before; of meshes that move alone */
	RENDER_HEAP_EXTRA_PLACES, /* render_extra_place, by mesh; as long as the last mesh with extras needs it */
	RENDER_HEAPS,
} render_heap_kind;

typedef struct render_heap {
	uint8_t *data;
	uint32_t element;        /* bytes */
	uint32_t size, capacity; /* elements; in use or used before; that there is memory for */
	render_ranges free;      /* elements below size that no resource uses */
	render_ranges dirty;     /* to be copied to the device */
} render_heap;

typedef enum render_resource_kind {
	RENDER_RESOURCE_MESH,
	RENDER_RESOURCE_TEXTURE,
	RENDER_RESOURCE_MATERIAL,
	RENDER_RESOURCE_MAPS,  /* of materials */
	RENDER_RESOURCE_GROUP, /* of maps */
	RENDER_RESOURCE_CLASS, /* of groups; never among the retired ones */
	RENDER_RESOURCE_FUNCTION,
	RENDER_RESOURCE_KINDS,
} render_resource_kind;

/* The table indices of one kind of resource. */
typedef struct render_indices {
	uint32_t next_unused, capacity; /* the lowest index that was never used; the size of the table */
	uint32_t *free;                 /* a stack with space for all indices below next_unused: releasing cannot fail */
	uint32_t free_count, free_capacity;
} render_indices;

typedef struct render_retired {
	uint64_t frame; /* number of the last frame that may use it, as render_resources.frame counts */
	render_resource_kind kind;
	uint32_t index;
} render_retired;

struct render_resources {
	/* Read by draws without the lock: an entry is written only before its handle is returned and after its release. */
	render_mesh_slot *meshes; /* [STILB_RENDER_MAX_MESHES] */
	render_levels **levels;   /* [STILB_RENDER_MAX_MESHES] NULL: it has none */
	float (*centers)[3];      /* [STILB_RENDER_MAX_MESHES] of meshes with RENDER_MESH_CENTER: see render_mesh_center */
	render_last *lasts;       /* [STILB_RENDER_MAX_MESHES] of meshes with RENDER_MESH_LAST */
	bool keeps_last; /* the last frame shows velocities: render_mesh_write keeps where vertices were. Main thread's */
	uint64_t drawn;  /* frames that the device got so far. Main thread's */
	bool morph;      /* stilb_render_desc.morph */
	render_layout layout;   /* of the heap of vertices */
	uint32_t *materials;    /* [STILB_RENDER_MAX_MATERIALS]: high 8 bits generation, low 22 texture, 0: none; bit 23:
	                             RENDER_STATE_IMPOSTOR; bit 22: RENDER_STATE_MAPS, and the low ones are its group */
	render_maps_slot *maps; /* [RENDER_MAX_MAPS] */
	uint32_t *textures;     /* [STILB_RENDER_MAX_TEXTURES]: generation */

	render_table groups;     /* of render_group */
	uint32_t *group_classes; /* [RENDER_MAX_MAPS] class of a group, or RENDER_CLASS_BLENDS */

	stilb_lock lock; /* guards everything below */
	bool lock_made;
	render_indices indices[RENDER_RESOURCE_KINDS];
	render_heap heaps[RENDER_HEAPS];
	render_table classes; /* of render_class */
	render_texture_upload *uploads;
	uint32_t upload_count, upload_capacity;
	bool sending; /* a frame is between update and sent */
	/* Elements that the heaps will have soon, 0: unknown: the device's arrays then grow once. */
	uint32_t expected[RENDER_HEAPS];
	/* [STILB_RENDER_MAX_TEXTURES] uploaded pixels, with mips if several levels were given; NULL: not kept */
	render_pixels *pictures;
	render_retired *retired; /* destroyed, not yet released; capacity is at least `live` */
	uint32_t retired_count, retired_capacity;
	uint32_t retired_now; /* meshes, textures and surfaces that were destroyed since the last frame began */
	uint32_t live;        /* resources not yet released */
	uint64_t frame;       /* frames begun so far */
};

static inline render_group *render_group_of(const render_resources *resources, uint32_t index)
{
	return (render_group *)(void *)resources->groups.items + index;
}

/* Makes space in the list of retired resources for `more` resources more than there are, so that destroying them cannot
 * fail. False: no memory. The caller holds the lock. */
bool render_resource_reserve(render_resources *resources, uint32_t more);
/* The error of a resource that could not be added: no id is left, or no memory. The caller holds the lock. */
stilb_result render_resource_no_memory(const render_resources *resources, render_resource_kind kind);

/* Takes an index. False: no memory, or none is left. */
bool render_index_take(render_indices *indices, uint32_t *index);
void render_index_give_back(render_indices *indices, uint32_t index);
/* It is released once no frame can use it. Room for that was made when it came. */
void render_resource_retire(render_resources *resources, render_resource_kind kind, uint32_t index);

/* Overwrites *resources. keep_pictures: keep copies of all pixels uploaded to textures (resources->pictures). packed:
 * vertices are packed (render_vertex.h). After STILB_ERROR_MEMORY render_resources_destroy must still be called. */
stilb_result render_resources_create(render_resources *resources, bool keep_pictures, bool packed);

/* render_levels.c: what a mesh with levels puts into the heaps. */
typedef struct render_levels_data {
	stilb_scene_vertex *vertices; /* [vertex_count] in pairs with morph; else the mesh's own */
	uint32_t *indices;            /* [index_count] */
	uint16_t *narrow;             /* [narrow_count] */
	uint32_t vertex_count, index_count, narrow_count;
	render_levels *levels; /* whose places count from the beginning of the mesh's ranges */
} render_levels_data;

/* Makes it of a checked mesh that has levels or clusters. False: no memory. */
bool render_levels_make(const stilb_scene_mesh *mesh, bool morph, render_levels_data *data);
/* Accepts NULL. */
void render_levels_free(render_levels *levels);
/* Frees it without the levels. Accepts {0}. */
void render_levels_finish(render_levels_data *data, const stilb_scene_mesh *mesh);
/* STILB_ERROR_ARGUMENT: the mesh's levels or clusters do not name vertices and indices that there are. */
stilb_result render_levels_check(const stilb_scene_mesh *mesh);
/* Accepts a zeroed struct too. */
void render_resources_destroy(render_resources *resources);

/* Call when a frame has begun and the device is done with the frame STILB_GPU_FRAMES before it: releases
 * resources that were destroyed in that frame or earlier. [main-thread] */
void render_resources_frame(stilb_render *render);

/* Gives the device the dirty ranges and new textures, as part of the frame. [main-thread] */
stilb_result render_resources_update(stilb_render *render);

/* Ends an updated frame. submitted: the device got it; if not, everything is dirty again. [main-thread] */
void render_resources_sent(stilb_render *render, bool submitted);

/* Bytes that frames have yet to copy. [any-thread] */
uint64_t render_resources_pending(render_resources *resources);

/* Announces that the heaps will grow by so many elements; NULL: by no more. [any-thread] */
void render_resources_expect(render_resources *resources, const uint32_t more[RENDER_HEAPS]);

/* Sets what the stream hash and dumps call a mesh and a material, instead of their index. [main-thread], before a draw
 * uses them */
void render_mesh_name(stilb_render *render, stilb_render_mesh mesh, uint32_t name);
void render_material_name(stilb_render *render, stilb_render_material material, uint32_t name);

/* Writes into resources that exist; the next frame copies what was written, after the draws of the frames before it.
 * STILB_ERROR_MEMORY: nothing has changed. [main-thread], between frames or before replay
 *
 * render_mesh_write: vertices first .. first + count - 1, count > 0; extras: theirs, NULL: these stay.
 * render_material_write: texture {0}: none. */
stilb_result render_mesh_write(stilb_render *render, stilb_render_mesh mesh, uint32_t first, uint32_t count,
                               const stilb_scene_vertex *vertices, const stilb_scene_vertex_extra *extras);
stilb_result render_material_write(stilb_render *render, stilb_render_material material,
                                   const stilb_scene_material *from, stilb_render_texture texture);

/* True if the vertices of the mesh with this index have moved in the frame that is recorded, and where they were is
 * known; *shift: as of render_last_row. */
static inline bool render_mesh_last(const render_resources *resources, uint32_t index, uint32_t *shift)
{
	const render_mesh_slot *slot = &resources->meshes[index];
	const render_last *last = &resources->lasts[index];
	if (!(slot->flags & RENDER_MESH_LAST) || last->drawn != resources->drawn)
		return false;
	*shift = last->first - (uint32_t)slot->vertex_offset;
	return true;
}

/* The middle of the box around the vertices of the mesh with this index, in its space: [3]. It is found when it is
 * first asked for and after render_mesh_write, some nanoseconds a vertex: only draws that blend need it. The caller
 * holds the lock. [main-thread] */
const float *render_mesh_center(render_resources *resources, uint32_t index);

/* stilb_render_material_create for a material with a surface. STILB_ERROR_MEMORY, also if there are RENDER_MAX_MAPS.
 * [any-thread] */
stilb_result render_material_create_maps(stilb_render *render, const stilb_scene_material *material,
                                         const render_maps *maps, stilb_render_material *out);
/* render_material_write of a material that has or gets maps; NULL: it loses them. [main-thread] */
stilb_result render_material_write_maps(stilb_render *render, stilb_render_material material,
                                        const stilb_scene_material *from, stilb_render_texture texture,
                                        const render_maps *maps);

/* stilb_render_material_create for an impostor, whose maps are the texture. [any-thread] */
stilb_result render_material_create_impostor(stilb_render *render, const stilb_scene_material *material,
                                             stilb_render_texture texture, stilb_render_material *out);

/* Adds a range to the set; it joins those that it touches or overlaps. range.count > 0. False: no memory. */
bool render_ranges_add(render_ranges *ranges, render_range range);
/* Removes `count` > 0 elements from the first range that has as many (first fit); false: none has. */
bool render_ranges_take(render_ranges *ranges, uint32_t count, uint32_t *first);
/* Checks the invariant of render_ranges, for STILB_CHECK: time in proportion to ranges->count. */
bool render_ranges_is_sound(const render_ranges *ranges);

#endif
