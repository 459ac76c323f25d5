/* The CPU's idea of what random plans do on the device: images and buffers with their contents, and the values that the
 * shaders random.frag and random.comp make of them. */
#ifndef GPU_MIX_H
#define GPU_MIX_H

#include "gpu/gpu_plan.h"

#define MIX_SUBS 18u            /* mips times layers at most: six layers of three mips */
#define MIX_TEXELS (4099u * 3u) /* of a mip and layer at most */
#define MIX_WORDS 64u           /* of a buffer: that many are mixed */

typedef enum mix_kind {
	MIX_FLAT,    /* r32_ui, 2-D, mips and layers */
	MIX_COLOR,   /* rgba8_u, 2-D, one sample */
	MIX_CUBE,    /* r32_ui, mips */
	MIX_SAMPLES, /* rgba8_u, four samples, which all have one value */
	MIX_BUFFER,
	MIX_KINDS,
} mix_kind;

/* An image or buffer. Contents are by sub: layer * mips + mip; rgba8_u as bytes of a word. */
typedef struct mix_thing {
	const char *name;
	mix_kind kind;
	bool keep, output;
	uint64_t owned;                        /* its contents stay */
	uint32_t width, height, mips, layers;  /* of buffers MIX_WORDS, 1, 1, 1 */
	uint16_t id;                           /* in the plan of this frame */
	bool written[MIX_SUBS];                /* in this frame, or owned */
	uint32_t now[MIX_SUBS][MIX_TEXELS];    /* of this frame */
	uint32_t before[MIX_SUBS][MIX_TEXELS]; /* last frame's, for `previous` uses */
} mix_thing;

/* What a pass reads of a thing. */
typedef struct mix_input {
	const mix_thing *thing;
	uint32_t mip, mips, layer, layers;
	bool previous;
} mix_input;

static inline uint32_t mix_step(uint32_t hash, uint32_t value)
{
	return (hash ^ value) * 16777619u;
}

static inline uint32_t mix_sub(const mix_thing *thing, uint32_t mip, uint32_t layer)
{
	return layer * thing->mips + mip;
}

static inline uint32_t mix_side(uint32_t side, uint32_t mip)
{
	return side >> mip > 0 ? side >> mip : 1;
}

#define MIX_INPUT_FLAT 0u
#define MIX_INPUT_COLOR 1u
#define MIX_INPUT_ARRAY 2u
#define MIX_INPUT_CUBE 3u
#define MIX_INPUT_SAMPLES 4u
#define MIX_INPUT_BUFFER 5u
#define MIX_INPUTS 6u

/* Fills width x height values: inputs as the shaders' bindings 0 to 4, and the buffer that they read. */
void mix_values(const mix_input inputs[MIX_INPUTS], uint32_t number, uint32_t layer, uint32_t width, uint32_t height,
                uint32_t *values);
#endif
