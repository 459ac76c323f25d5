/* BC7 (BPTC): blocks of 4 x 4 texels in 16 bytes, in one of eight modes. Sources: Khronos Data Format Specification,
 * "BPTC Compressed Texture Image Formats"; Microsoft, "BC7 Format". Where the specification's bold entries and its
 * tables of anchors differ (partition 35 of two subsets, 1 of three), the tables are right. */
#include "image/image_blocks.h"

#include <string.h>

typedef struct bc7_mode {
	uint8_t subsets, partition_bits, rotation_bits, selection_bits;
	uint8_t color_bits, alpha_bits;  /* of a channel of an endpoint */
	uint8_t own_p, shared_p;         /* bits below those: one for each endpoint, or one for both of a subset */
	uint8_t index_bits, second_bits; /* of a texel; second_bits 0: there is one index for all channels */
} bc7_mode;

static const bc7_mode bc7_modes[8] = {
	{3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0}, {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
	{2, 6, 0, 0, 7, 0, 1, 0, 2, 0}, {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
	{1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
};

/* The subset of texel t is bit t of two subsets' partition, bits 2 t and 2 t + 1 of three subsets'. */
static const uint16_t bc7_halves[64] = {
	0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80, 0xe800, 0xffe8,
	0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310, 0x3100, 0x8cce, 0x088c, 0x3110,
	0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c, 0xaaaa, 0xf0f0, 0x5a5a, 0x33cc, 0x3c3c, 0x55aa, 0x9696,
	0xa55a, 0x73ce, 0x13c8, 0x324c, 0x3bdc, 0x6996, 0xc33c, 0x9966, 0x0660, 0x0272, 0x04e4, 0x4e40, 0x2720,
	0xc936, 0x936c, 0x39c6, 0x639c, 0x9336, 0x9cc6, 0x817e, 0xe718, 0xccf0, 0x0fcc, 0x7744, 0xee22,
};

static const uint32_t bc7_thirds[64] = {
	0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050,
	0xaa550000, 0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494, 0xa4a4a4a4, 0xa9a59450, 0x2a0a4250,
	0xa5945040, 0x0a425054, 0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500,
	0x0050a4a4, 0xaaa59090, 0x14696914, 0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200,
	0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424, 0x00aa5500, 0x24924924, 0x24499224, 0x50a50a50,
	0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0, 0x69286928, 0x44aaaa44, 0x66666600,
	0xaa444444, 0x54a854a8, 0x95809580, 0x96969600, 0xa85454a8, 0x80959580, 0xaa141414, 0x96960000,
	0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44, 0x2a4a5254,
};

/* The texel of the second subset whose index has a bit less, and of the second and the third of three; of the first
 * subset it is texel 0. */
static const uint8_t bc7_half_anchors[64] = {
	15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2,  8, 2,  2, 8,
	8,  15, 2,  8,  2,  2,  8,  8,  2,  2,  15, 15, 6,  8,  2,  8,  15, 15, 2, 8,  2, 2,
	2,  15, 15, 6,  6,  2,  6,  8,  15, 15, 2,  2,  15, 15, 15, 15, 15, 2,  2, 15,
};
static const uint8_t bc7_third_anchors[2][64] = {
	{
		3,  3,  15, 15, 8, 3,  15, 15, 8,  8,  6, 6,  6, 5,  3, 3,  3,  3,  8,  15, 3,  3,
		6,  10, 5,  8,  8, 6,  8,  5,  15, 15, 8, 15, 3, 5,  6, 10, 8,  15, 15, 3,  15, 5,
		15, 15, 15, 15, 3, 15, 5,  5,  5,  8,  5, 10, 5, 10, 8, 13, 15, 12, 3,  3,
	},
	{
		15, 8, 8, 3,  15, 15, 3,  8,  15, 15, 15, 15, 15, 15, 15, 8,  15, 8,  15, 3,  15, 8,
		15, 8, 3, 15, 6,  10, 15, 15, 10, 8,  15, 3,  15, 10, 10, 8,  9,  10, 6,  15, 8,  15,
		3,  6, 6, 8,  15, 3,  15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3,  15, 15, 8,
	}};

/* The bits of a block that are still to be read, the lowest first. */
typedef struct bc7_bits {
	uint64_t low, high;
} bc7_bits;

/* The next count bits, 0..8. */
static uint32_t bc7_take(bc7_bits *bits, uint32_t count)
{
	STILB_ASSERT(count <= 8);
	if (count == 0)
		return 0;
	uint32_t value = (uint32_t)(bits->low & ((1u << count) - 1));
	bits->low = bits->low >> count | bits->high << (64 - count);
	bits->high >>= count;
	return value;
}

/* A number of count bits, 4..8, as one of 8: its upper bits are repeated below. */
static uint32_t bc7_widen(uint32_t value, uint32_t count)
{
	STILB_ASSERT(count >= 4 && count <= 8 && value < 1u << count);
	value <<= 8 - count;
	return value | value >> count;
}

typedef struct bc7_ends {
	uint32_t values[6][4]; /* of each subset the first and the second endpoint: red, green, blue, alpha in 8 bits */
} bc7_ends;

static void bc7_take_ends(bc7_bits *bits, const bc7_mode *mode, bc7_ends *ends)
{
	uint32_t count = 2u * mode->subsets, p[6] = {0};
	uint32_t sizes[4] = {mode->color_bits, mode->color_bits, mode->color_bits, mode->alpha_bits};
	for (uint32_t c = 0; c < 4; c++)
		for (uint32_t e = 0; e < count; e++)
			ends->values[e][c] = bc7_take(bits, sizes[c]);
	for (uint32_t e = 0; e < count && mode->own_p; e++)
		p[e] = bc7_take(bits, 1);
	for (size_t s = 0; s < mode->subsets && mode->shared_p; s++)
		p[2 * s] = p[2 * s + 1] = bc7_take(bits, 1);
	uint32_t extra = mode->own_p | mode->shared_p;
	for (uint32_t e = 0; e < count; e++)
		for (uint32_t c = 0; c < 4; c++)
			ends->values[e][c] =
				sizes[c] ? bc7_widen(ends->values[e][c] << extra | (extra ? p[e] : 0), sizes[c] + extra) : 255;
}

/* Of each texel its subset; and which texels are anchors. */
typedef struct bc7_partition {
	uint8_t subset[16];
	bool anchor[16];
} bc7_partition;

static void bc7_divide(uint32_t subsets, uint32_t number, bc7_partition *out)
{
	STILB_ASSERT(number < 64);
	memset(out, 0, sizeof *out);
	out->anchor[0] = true;
	for (uint32_t t = 0; t < 16 && subsets == 2; t++)
		out->subset[t] = bc7_halves[number] >> t & 1;
	for (uint32_t t = 0; t < 16 && subsets == 3; t++)
		out->subset[t] = bc7_thirds[number] >> 2 * t & 3;
	if (subsets == 2)
		out->anchor[bc7_half_anchors[number]] = true;
	if (subsets == 3)
		out->anchor[bc7_third_anchors[0][number]] = out->anchor[bc7_third_anchors[1][number]] = true;
}

static void bc7_take_indices(bc7_bits *bits, uint32_t count, const bc7_partition *partition, uint8_t indices[16])
{
	for (uint32_t t = 0; t < 16; t++)
		indices[t] = (uint8_t)bc7_take(bits, count - (count > 0 && partition->anchor[t]));
}

static uint8_t bc7_mix(uint32_t first, uint32_t second, uint32_t index, uint32_t bits)
{
	static const uint8_t weights[3][16] = {
		{0, 21, 43, 64},
		{0, 9, 18, 27, 37, 46, 55, 64},
		{0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64},
	};
	STILB_ASSERT(bits >= 2 && bits <= 4 && index < 1u << bits);
	uint32_t weight = weights[bits - 2][index];
	return (uint8_t)(((64 - weight) * first + weight * second + 32) >> 6);
}

void image_block_bc7(const uint8_t block[16], uint8_t texels[16][4])
{
	bc7_bits bits;
	memcpy(&bits.low, block, 8); /* little endian, as all machines that this runs on */
	memcpy(&bits.high, block + 8, 8);
	memset(texels, 0, 64);
	if (block[0] == 0)
		return; /* a reserved mode: the specification has it black and clear */
	uint32_t number = (uint32_t)__builtin_ctz(block[0]);
	const bc7_mode *mode = &bc7_modes[number];
	bc7_ends ends;
	bc7_partition partition;
	uint8_t first[16], second[16];
	bc7_take(&bits, number + 1);
	bc7_divide(mode->subsets, bc7_take(&bits, mode->partition_bits), &partition);
	uint32_t rotation = bc7_take(&bits, mode->rotation_bits), swapped = bc7_take(&bits, mode->selection_bits);
	bc7_take_ends(&bits, mode, &ends);
	bc7_take_indices(&bits, mode->index_bits, &partition, first);
	bc7_take_indices(&bits, mode->second_bits, &partition, second);
	bool two = mode->second_bits > 0;
	const uint8_t *color = two && swapped ? second : first, *alpha = two && !swapped ? second : first;
	uint32_t color_bits = two && swapped ? mode->second_bits : mode->index_bits;
	uint32_t alpha_bits = two && !swapped ? mode->second_bits : mode->index_bits;
	for (uint32_t t = 0; t < 16; t++) {
		size_t pair = 2 * (size_t)partition.subset[t];
		const uint32_t *from = ends.values[pair], *to = ends.values[pair + 1];
		for (uint32_t c = 0; c < 3; c++)
			texels[t][c] = bc7_mix(from[c], to[c], color[t], color_bits);
		texels[t][3] = bc7_mix(from[3], to[3], alpha[t], alpha_bits);
		if (rotation > 0) {
			uint8_t turned = texels[t][rotation - 1];
			texels[t][rotation - 1] = texels[t][3];
			texels[t][3] = turned;
		}
	}
}
