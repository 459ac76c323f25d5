/*
 * gpu_plan: how a plan is kept and made.
 *
 *   gpu_plan.c           life, rows that are added (compared with last frame's), the order of the steps below, results
 *   gpu_plan_resource.c  rows of images and buffers: checks, sizes
 *   gpu_plan_pass.c      rows of passes: checks; what each touches, as gpu_touch
 *   gpu_plan_live.c      who reads what was written; passes that are left out; lifetimes; which kept ones are two
 *   gpu_plan_memory.c    places in shared memory
 *   gpu_plan_queue.c     waits between queues
 *   gpu_plan_barrier.c   barriers, and what the frame leaves for the next
 *   gpu_plan_hash.c, gpu_plan_text.c, gpu_plan_svg.c   results in other forms
 *
 * A table whose passes touch the same parts of the same resources in the same ways as last frame's, whatever their
 * programs, constants, clear values and names are, has the same plan, if last frame has also left everything as it
 * found it (`steady`): then nothing is made anew. Else all is, but for the checks of rows that are last frame's.
 */
#ifndef STILB_GPU_PLAN_INTERNAL_H
#define STILB_GPU_PLAN_INTERNAL_H

#include "gpu/gpu_plan.h"

#include <stdio.h>

#define GPU_MAX_HEAPS 64u
#define GPU_LAYOUT_UNKNOWN 0xffu /* of an owned image that this plan has not touched */
#define GPU_NO_RECORD UINT32_MAX

static_assert(STILB_GPU_ACCESSES <= 32, "accesses are bits of 32");

/* An array that grows, and never shrinks. */
typedef struct gpu_array {
	void *items;
	size_t capacity; /* items */
} gpu_array;

/* Makes room for `count` items of `size` bytes; what is there stays. False: no memory. */
bool gpu_array_reserve(gpu_array *array, size_t count, size_t size);

/* A resource's row, and what follows from it alone. */
typedef struct gpu_resource {
	char name[STILB_GPU_MAX_NAME + 1]; /* the rest is 0 */
	uint64_t name_hash;
	stilb_gpu_plan_image_row image; /* as it was given, but for the name; of a buffer keep, output, owned */
	stilb_gpu_extent extent;        /* format NONE: a buffer */
	uint64_t bytes;                 /* of all texels, or of the buffer */
	bool buffer;
	stilb_gpu_needs needs; /* the device's answer for these uses; bytes 0: not asked */
	uint16_t needs_uses;
	/* what plans of this table have in common */
	bool shown;
	uint32_t first_sub; /* of this frame's content; kept: as many again for last frame's, if there are two */
	uint32_t subs;      /* states: one for each mip and layer, or one for all */
	uint32_t record;    /* in plan->left, or GPU_NO_RECORD */
} gpu_resource;

/* What the walks over all touches ask of a resource: few bytes, so that all of them stay in the nearest cache. */
typedef struct gpu_life {
	uint32_t first, last;    /* steps + 1; first 0: none touches it */
	uint32_t first_write;    /* step + 1; 0: none */
	uint32_t last_previous;  /* step + 1; 0: no `previous` use */
	uint16_t uses;           /* as of stilb_gpu_extent */
	uint32_t memory_readers; /* accesses of what the memory was used for before */
	uint32_t first_sub;      /* as in gpu_resource */
	bool many;               /* a state for each mip and layer */
	bool partial;            /* a use is not of all mips and layers */
	bool written;            /* by a pass that is not left out */
} gpu_life;

/* What a pass does with a part of a resource. */
typedef struct gpu_touch {
	uint16_t resource;
	uint8_t access; /* stilb_gpu_access */
	uint8_t layout; /* stilb_gpu_layout */
	bool reads;     /* content that earlier passes have written must be there */
	bool writes;
	bool replaces; /* all of what was there */
	bool previous;
	bool owned;    /* the resource is */
	bool partial;  /* not of all mips and layers */
	bool many;     /* the resource has a state for each mip and layer */
	uint8_t role;  /* where the row says so: a colour attachment's index, or GPU_ROLE_... */
	uint8_t queue; /* stilb_gpu_queue */
	uint16_t use;  /* bit of stilb_gpu_extent.uses */
	stilb_gpu_range range;
	uint32_t first; /* state of the range's first mip and layer, of this frame's content */
} gpu_touch;
#define GPU_ROLE_RESOLVE 8u /* + index of the colour attachment */
#define GPU_ROLE_DEPTH 16u
#define GPU_ROLE_USE 17u /* + index of the use */

/* The touches of a row. */
typedef struct gpu_span {
	uint32_t first, count;
	bool checked; /* they are those of the row as it is; else of that of the table before, if it had one */
	bool asked;   /* the planner was asked for mistakes of the row as it is */
} gpu_span;

/* State of a mip and layer between two passes. */
typedef struct gpu_sub {
	uint32_t readers; /* accesses that have read since the last write or change of layout */
	uint32_t visible; /* accesses that need no barrier to read, besides those that `barrier` names */
	uint32_t barrier; /* index + 1 of the barrier of this frame before the first of the readers; 0: none */
	uint8_t write;    /* the last write's access */
	uint8_t last;     /* the last access */
	uint8_t layout;   /* stilb_gpu_layout, GPU_LAYOUT_UNKNOWN */
	bool now;         /* this frame has written content */
	bool old;         /* last frame has left content */
	bool zeros;       /* it holds zeros that the device has filled in, as last frame had left nothing */
} gpu_sub;

/* Marks of a mip and layer while rows are checked. */
typedef struct gpu_mark {
	uint32_t pass; /* + 1: the last that touched it */
	uint8_t layout;
	bool wrote; /* that pass */
	bool written;
	bool needed; /* by a pass or somebody after the point at which the search is */
	bool later;  /* likewise, by one of the rows behind a cut frame's */
} gpu_mark;

/* What a frame leaves of a resource that stays. */
typedef struct gpu_record {
	char name[STILB_GPU_MAX_NAME + 1];
	uint64_t name_hash, owned, bytes, stay;
	stilb_gpu_extent extent; /* uses: 0 */
	uint32_t first_sub, subs;
	bool two, keep, written;
} gpu_record;

/* Part of a heap, and what used it last. */
typedef struct gpu_region {
	uint64_t begin, end;
	uint32_t heap;
	uint16_t resource; /* of this frame; 0: `readers` tells */
	uint32_t accesses;
} gpu_region;

/* What a frame leaves. */
typedef struct gpu_left {
	gpu_array records, subs, regions;
	uint32_t record_count, sub_count, region_count;
} gpu_left;

/* An item of shared memory. */
typedef struct gpu_item {
	uint64_t bytes, align;
	uint32_t first, last; /* steps, both included */
	uint32_t heap;
	uint16_t resource;
	uint64_t offset; /* the result */
} gpu_item;

/* Items that were placed: a table that goes back to what it was some frames ago finds its places again. */
#define GPU_PLACEMENTS 4u
typedef struct gpu_placement {
	gpu_array items; /* gpu_item */
	uint32_t count;
	uint64_t heap_bytes[GPU_MAX_HEAPS];
	uint32_t heap_count;
} gpu_placement;

struct stilb_gpu_plan {
	uint32_t size[2];
	/* rows */
	gpu_array resources, rows; /* gpu_resource from index 1 on; stilb_gpu_pass */
	uint32_t resource_count, row_count;
	uint32_t resources_known, rows_known; /* of the table before */
	gpu_array shown;                      /* uint16_t */
	uint32_t shown_count, shown_known;
	gpu_array names; /* uint16_t: resources by name and by `owned`; open addressing, 0: empty */
	uint32_t name_mask;
	uint32_t cut[2], cut_known[2]; /* rows cut[0] .. cut[1] - 1 do not run; both 0: the frame is not cut */
	bool changed;                  /* the images, buffers, what is shown or the cut are not those of the table before */
	bool rows_changed;             /* passes are not */
	bool begun;
	bool made;    /* there is a plan of the rows */
	bool planned; /* in this frame */
	stilb_result row_error;
	char row_message[1024];
	/* how the last plan was made */
	bool steady; /* it left everything as it found it */
	bool dropped;
	stilb_gpu_planner planner;
	uint64_t next_stay;
	gpu_left left, next; /* by the frame before; by this plan */
	bool next_counts;    /* `next` is to become `left` */
	/* scratch and results */
	gpu_array touches, spans;    /* gpu_touch; gpu_span of each row */
	uint32_t touch_count;        /* also of rows as they were: each that changes has its touches at the end */
	gpu_array marks, subs, live; /* gpu_mark, gpu_sub; bool for each row */
	uint32_t sub_count;
	gpu_array lives;   /* gpu_life from index 1 on */
	gpu_array counted; /* uint16_t: resources that somebody reads after the frame */
	uint32_t counted_count;
	gpu_array placed; /* stilb_gpu_placed from index 1 on */
	gpu_array steps, barriers;
	uint32_t step_count, barrier_count, last_barrier; /* last_barrier: the first after the last step */
	gpu_array items;                                  /* gpu_item */
	uint32_t item_count;
	gpu_placement placements[GPU_PLACEMENTS];
	uint32_t placement, next_placement; /* the one of this plan; the one that the next new one takes the place of */
	gpu_array placing;                  /* scratch of gpu_place */
	gpu_array orders, users, clocks;    /* of gpu_plan_queue.c: by state; by resource, twice; by step */
	gpu_array waits;                    /* stilb_gpu_queue_wait */
	uint32_t wait_count;
	bool queued;    /* a step is on another queue than the main one */
	gpu_array keys; /* scratch of barriers: uint8_t for each mip and layer */
};

/* ---- small things that all files use ----------------------------------------------------------------------------- */

static inline gpu_resource *gpu_plan_resource(const stilb_gpu_plan *plan, uint32_t resource)
{
	STILB_ASSERT(resource > 0 && resource <= plan->resource_count);
	return (gpu_resource *)plan->resources.items + resource;
}

static inline stilb_gpu_pass *gpu_plan_row(const stilb_gpu_plan *plan, uint32_t row)
{
	STILB_ASSERT(row < plan->row_count);
	return (stilb_gpu_pass *)plan->rows.items + row;
}

static inline stilb_gpu_placed *gpu_plan_placed(const stilb_gpu_plan *plan, uint32_t resource)
{
	return (stilb_gpu_placed *)plan->placed.items + resource;
}

static inline gpu_life *gpu_plan_life(const stilb_gpu_plan *plan, uint32_t resource)
{
	return (gpu_life *)plan->lives.items + resource;
}

/* Touches of a row. */
static inline const gpu_touch *gpu_plan_touches(const stilb_gpu_plan *plan, uint32_t row, uint32_t *count)
{
	const gpu_span *span = (const gpu_span *)plan->spans.items + row;
	*count = span->count;
	return (const gpu_touch *)plan->touches.items + span->first;
}

/* It stays from frame to frame, in memory of its own. */
static inline bool gpu_resource_stays(const gpu_resource *resource)
{
	return resource->image.owned == 0 && (resource->image.keep || resource->image.output || resource->shown);
}

/* Somebody reads it after the frame. */
static inline bool gpu_resource_counts(const gpu_resource *resource)
{
	return resource->image.owned != 0 || resource->image.keep || resource->image.output || resource->shown;
}

/* The frame ends before this row. */
static inline bool gpu_plan_cuts(const stilb_gpu_plan *plan, uint32_t row)
{
	return row >= plan->cut[0] && row < plan->cut[1];
}

/* It fills a part of its attachments. */
static inline bool gpu_pass_has_area(const stilb_gpu_pass *pass)
{
	return (pass->area[2] | pass->area[3]) > 0;
}

/* What programs draw at its place is dropped. */
static inline bool gpu_attachment_is_none(const stilb_gpu_attachment *color)
{
	return color->image == 0 && color->load == STILB_GPU_LOAD_NONE;
}

/* Texels of a mip along a side. */
static inline uint32_t gpu_mip_side(uint32_t side, uint32_t mip)
{
	return side >> mip > 0 ? side >> mip : 1;
}

/* The word for messages: "image", "buffer". */
static inline const char *gpu_resource_word(const gpu_resource *resource)
{
	return resource->buffer ? "buffer" : "image";
}

/* ---- words of text and drawing, gpu_plan_text.c ------------------------------------------------------------------ */

void gpu_print_title(FILE *out, const stilb_gpu_plan *plan);
void gpu_print_bytes(FILE *out, uint64_t bytes);                /* "12 B", "1.5 MiB" */
void gpu_print_extent(FILE *out, const gpu_resource *resource); /* "rgba8_u 64 x 64 cube 3 mips" */
void gpu_print_barrier(FILE *out, const stilb_gpu_plan *plan, const stilb_gpu_barrier *barrier);
void gpu_print_left_out(FILE *out, const stilb_gpu_plan *plan, uint32_t row); /* why a pass does not run */

/* ---- steps of making a plan, in their order ---------------------------------------------------------------------- */

/* Fills extent and bytes from the row; width and height are the picture's. STILB_ERROR_ARGUMENT: the row is wrong. */
stilb_result gpu_resource_check_image(gpu_resource *resource, const uint32_t picture[2]);
stilb_result gpu_resource_check_buffer(gpu_resource *resource);

/* "samples", "draws over", ...: what a pass does with what it touches. Static. */
const char *gpu_touch_verb(const stilb_gpu_pass *pass, const gpu_touch *touch);

/* Checks the passes that have changed, or all if the resources have, and fills plan->touches and spans. *same: all
 * touches are those of the table before. */
stilb_result gpu_plan_check_passes(stilb_gpu_plan *plan, bool *same);

bool gpu_sub_equal(const gpu_sub *a, const gpu_sub *b);

/* What last frame has left of a resource; searched from record `hint` on. GPU_NO_RECORD: nothing. */
uint32_t gpu_plan_find_record(const stilb_gpu_plan *plan, const gpu_resource *resource, uint32_t hint);

/* Checks that what is read was written; fills plan->live and steps, uses and lifetimes of plan->placed. */
stilb_result gpu_plan_find_live(stilb_gpu_plan *plan);

/* Asks the device what transient resources need, and gives them places. */
stilb_result gpu_plan_place_memory(stilb_gpu_plan *plan);

/* Fills plan->barriers and `next`, and sets `steady`. */
stilb_result gpu_plan_find_barriers(stilb_gpu_plan *plan);

/* Fills plan->waits, and queues of plan->placed if there are several. */
stilb_result gpu_plan_find_waits(stilb_gpu_plan *plan);

/* Sets the offsets of items of one heap, which are sorted by `first`; returns the bytes of them all. Items whose steps
 * overlap share no byte. scratch: grows. UINT64_MAX: no memory. */
uint64_t gpu_place(gpu_item *items, uint32_t count, gpu_array *scratch);

#endif
