/* Inside debug/: records, and how threads hand them over. */
#ifndef DEBUG_INTERNAL_H
#define DEBUG_INTERNAL_H

#include "base/base_contract.h"
#include "debug/debug_draw.h"
#include "ui/ui_internal.h"

#include <math.h>
#include <stdatomic.h>

/* ---- records ----------------------------------------------------------------------------------------------------- */

/* A line or a letter as the vertex shader reads it (shaders/debug.vert). */
typedef struct debug_record {
	float from[3]; /* of a line; of a letter the text's place */
	uint32_t rgba;
	union {
		float to[3]; /* of a line */
		struct {
			int16_t x, y; /* the letter's left upper corner from the pixel of the text's place */
			uint16_t texel_x, texel_y, width, height; /* its rectangle in the picture of the glyphs */
		} letter;
	};
	uint32_t word; /* DEBUG_...; below them a line's width in 1/256 pixel */
} debug_record;

static_assert(sizeof(debug_record) == 32 && sizeof(debug_record) == STILB_GPU_DRAW_STRIDE, "the shader's layout");

#define DEBUG_WIDTH_ONE 256.0f
#define DEBUG_HALO (1u << 29)   /* of a letter: around it, below it */
#define DEBUG_LETTER (1u << 30) /* else a line */
#define DEBUG_ON_TOP (1u << 31)

/* What a style says of the scene, the width and the kind. */
static inline uint32_t debug_word(stilb_debug_style style)
{
	STILB_ASSERT(style.width >= 0.0f && style.width <= STILB_DEBUG_MAX_WIDTH);
	uint32_t width = (uint32_t)((style.width > 0.0f ? style.width : 1.0f) * DEBUG_WIDTH_ONE + 0.5f);
	return width | (style.on_top ? DEBUG_ON_TOP : 0);
}

/* For asserts. */
static inline bool debug_is_finite(const float v[3])
{
	return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

static inline debug_record debug_line_of(const float from[3], const float to[3], uint32_t rgba, uint32_t word)
{
	STILB_ASSERT(debug_is_finite(from) && debug_is_finite(to));
	return (debug_record){.from = {from[0], from[1], from[2]}, .rgba = rgba, .to = {to[0], to[1], to[2]}, .word = word};
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

#define DEBUG_CHUNK_BITS 10u
#define DEBUG_CHUNK (1u << DEBUG_CHUNK_BITS) /* records */

typedef struct debug_chunk {
	debug_record records[DEBUG_CHUNK]; /* in lists of what stays, each is followed by its seconds, in from[0] */
	struct debug_chunk *_Atomic next;  /* release by the thread that writes, acquire by the frame's */
	_Atomic uint32_t count;            /* written records; likewise */
	struct debug_chunk *unused;        /* the next one of a list of chunks that nobody writes */
} debug_chunk;

/* The chunks of one thread. It writes the last one, and the frame's thread reads as far as it is written. */
typedef struct debug_list {
	debug_chunk *_Atomic first; /* release by the thread that writes, acquire by the frame's; may be freed since */
	debug_chunk *last;          /* the writing thread's; NULL: none */
	uint32_t used;              /* the writing thread's: records of the last chunk */
	uint32_t taken;             /* the frame's: records of `read` that earlier frames had */
	debug_chunk *read;          /* the frame's; NULL: it is the first */
} debug_list;

/* What a thread writes to. */
typedef struct debug_slot {
	_Alignas(STILB_CACHE_LINE) debug_list once, stays; /* for one frame; for some seconds */
} debug_slot;

/* Records that follow one another. */
typedef struct debug_block {
	const debug_record *records; /* [count] */
	uint32_t count;              /* 1..DEBUG_CHUNK */
	uint32_t first;              /* records of the frame before these */
} debug_block;

typedef struct debug_blocks {
	debug_block *blocks; /* [count] */
	uint32_t count, capacity;
} debug_blocks;

/* What a frame in flight reads: a debug_place for each view, the draws' commands, and behind them the records. */
typedef struct debug_buffer {
	stilb_gpu_buffer buffer;
	uint32_t capacity; /* records */
} debug_buffer;

/* A view of the frame and the part of the picture that shows it. */
typedef struct debug_view {
	stilb_mat4 view_projection;
	char depth[STILB_GPU_MAX_NAME + 1]; /* the plan's image of its depth */
	uint16_t place[4];                  /* left, top, width, height, pixels */
	uint16_t border;                    /* pixels at its edges in which nothing is drawn */
} debug_view;

/* The same as the fragment shader reads it (shaders/cover.glsl): pixels left, top, right, bottom. */
typedef struct debug_place {
	uint32_t place[4], inner[4];
} debug_place;

static_assert(sizeof(debug_place) == sizeof(debug_record), "all in one buffer");

/* A record's place in the frame's order: (key << 32 | index), see debug_frame.c. */
typedef uint64_t debug_item;

struct stilb_debug {
	debug_slot slots[STILB_DEBUG_THREADS];
	stilb_lock lock;       /* guards the next */
	debug_chunk *unused;   /* chunks that no list has */
	stilb_lock fonts_lock; /* of who makes the next, which does not change then */
	ui_fonts fonts;        /* {0}: nobody has drawn text */
	/* fonts are there. Release by who has made them, acquire by who reads them. */
	_Atomic bool has_fonts;
	/* A call had no memory; or there were more threads than numbers. Relaxed: the frame alone looks at them, and they
	 * order nothing. */
	_Atomic bool failed, too_many;

	/* The frame's; main thread. */
	stilb_owner owner;
	stilb_render *render;
	debug_blocks once, stays; /* that this frame has taken; then the first are all that it draws */
	debug_chunk *done;        /* chunks of these that their threads have left */
	debug_record *kept;       /* [kept_count] what stays */
	double *ends;             /* [kept_count] when it goes */
	uint32_t kept_count, kept_capacity, ends_capacity;
	debug_item *items, *spare; /* [count] */
	uint32_t item_capacity, spare_capacity;
	uint32_t count;
	debug_view views[STILB_RENDER_MAX_PASSES]; /* [view_count] */
	uint32_t view_count;

	/* The device's. */
	debug_buffer buffers[STILB_GPU_FRAMES];
	uint32_t buffer; /* of this frame */
	bool ready;      /* the last stilb_debug_frame has records for the plan */
	bool added;      /* as a feature of the renderer */
	stilb_gpu_buffer indices;
	stilb_gpu_program programs[2]; /* of a depth image with one sample, with several */
	uint32_t samples;              /* for which programs[1] is */
	stilb_gpu_image glyphs;        /* {0}: nobody has drawn text */
	stilb_gpu_set set;             /* of them */
	stilb_gpu_binding binding;     /* the list of draws */
	stilb_gpu_run run;
};

/* Makes *data hold so many elements; false: no memory. */
bool debug_reserve(void **data, uint32_t *capacity, uint64_t count, size_t element);

/* Adds records that are drawn once, or for `seconds` > 0. [any-thread] */
void debug_put(stilb_debug *debug, const debug_record *records, uint32_t count, float seconds);

/* Takes what threads have drawn since the call before: once and stays; false: no memory. [main-thread] */
bool debug_take(stilb_debug *debug);

/* That was used: threads may write its chunks again. [main-thread] */
void debug_give(stilb_debug *debug);

/* False: no memory. */
bool debug_blocks_add(debug_blocks *blocks, const debug_record *records, uint32_t count);

/* ---- the device (debug_device.c) [main-thread] ------------------------------------------------------------------- */

/* Of records; [1]: the scene's depth has several samples a pixel. */
extern const stilb_gpu_shader debug_shader_vertex, debug_shader_fragment[2];

/* Makes what drawing needs, and room for `count` records; *records is where they go. */
stilb_result debug_device_begin(stilb_debug *debug, uint32_t count, debug_record **records);

/* The records have been written: the next plan draws them. */
void debug_device_end(stilb_debug *debug, uint32_t count);

void debug_device_finish(stilb_debug *debug);

#endif
