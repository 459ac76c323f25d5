/* The innermost loops in plain C: one plane at a time over arrays, without branches, which compilers turn into SIMD. */
#include "culling/cull_scalar.h"

#include <string.h>

#define SCALAR_PIECE 256u /* spheres at a time: their flags, a byte each, stay in the first-level cache */

/* Clears visible[i] where sphere first + i is not visible for the plane; i in 0 .. count - 1. */
static void scalar_plane(cull_spheres spheres, uint32_t first, uint32_t count, stilb_plane plane,
                         uint8_t *restrict visible)
{
	const float *restrict x = spheres.x + first, *restrict y = spheres.y + first, *restrict z = spheres.z + first;
	const float *restrict radius = spheres.radius + first;
	for (uint32_t i = 0; i < count; i++) {
		float signed_distance = ((x[i] * plane.x + y[i] * plane.y) + z[i] * plane.z) + plane.distance;
		visible[i] &= signed_distance >= -radius[i];
	}
}

/* visible[i] = 1 if sphere first + i is visible for all planes of the mask, else 0. */
static void scalar_piece(cull_spheres spheres, uint32_t first, uint32_t count, const stilb_frustum *frustum,
                         uint32_t planes, uint8_t visible[SCALAR_PIECE])
{
	STILB_ASSERT(count <= SCALAR_PIECE && planes);
	memset(visible, 1, SCALAR_PIECE);
	for (; planes; planes &= planes - 1)
		scalar_plane(spheres, first, count, frustum->planes[__builtin_ctz(planes)], visible);
}

static uint32_t scalar_least(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

static uint32_t scalar_flat(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t *ids)
{
	uint32_t found = 0;
	uint8_t visible[SCALAR_PIECE];
	for (uint32_t first = 0; first < count; first += SCALAR_PIECE) {
		uint32_t piece = scalar_least(count - first, SCALAR_PIECE);
		scalar_piece(spheres, first, piece, frustum, CULL_ALL_PLANES, visible);
		for (uint32_t i = 0; i < piece; i++) {
			ids[found] = first + i;
			found += visible[i];
		}
	}
	return found;
}

static void scalar_all(uint32_t count, uint32_t *ids)
{
	for (uint32_t i = 0; i < count; i++)
		ids[i] = i;
}

static void scalar_test(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes,
                        uint64_t *bits)
{
	uint8_t visible[SCALAR_PIECE];
	STILB_ASSERT(count > 0);
	for (uint32_t first = 0; first < count; first += SCALAR_PIECE) {
		uint32_t piece = scalar_least(count - first, SCALAR_PIECE);
		scalar_piece(spheres, first, piece, frustum, planes, visible);
		memset(visible + piece, 0, SCALAR_PIECE - piece);
		for (uint32_t word = 0; word * 64 < piece; word++) {
			uint64_t set = 0;
			for (uint32_t i = 0; i < 64; i++)
				set |= (uint64_t)visible[word * 64 + i] << i;
			bits[first / 64 + word] = set;
		}
	}
}

static void scalar_sixteen(cull_sixteen *cells, const cull_level *level, uint32_t planes)
{
	STILB_ASSERT(planes && !(planes & ~CULL_ALL_PLANES));
	cells->rejected = 0;
	memset(cells->inside, 0, sizeof cells->inside);
	for (; planes; planes &= planes - 1) {
		uint32_t plane = (uint32_t)__builtin_ctz(planes), rejected = 0, inside = 0;
		for (uint32_t i = 0; i < CULL_WIDTH; i++) {
			uint32_t family = i / CULL_CHILDREN, child = i % CULL_CHILDREN;
			double center = cells->center[family][plane], reach = (double)cells->reach[family][child];
			rejected |= (uint32_t)((center + level->high[plane][child]) + reach < 0.0) << i;
			inside |= (uint32_t)(center + level->low[plane][child] >= 0.0) << i;
		}
		cells->rejected |= (uint16_t)rejected;
		cells->inside[plane] = (uint16_t)inside;
	}
}

const cull_kernels cull_kernels_scalar = {
	.flat = scalar_flat,
	.all = scalar_all,
	.test = scalar_test,
	.sixteen = scalar_sixteen,
	.gather = scalar_gather,
	.expand = scalar_expand,
};

const cull_kernels *cull_kernels_for(stilb_isa isa)
{
	STILB_ASSERT((uint32_t)isa <= (uint32_t)stilb_cpu_widest_isa() && "this CPU has it");
#if defined(__x86_64__)
	if (isa == STILB_ISA_AVX512)
		return &cull_kernels_avx512;
	if (isa == STILB_ISA_AVX2)
		return &cull_kernels_avx2;
#endif
	(void)isa;
	return &cull_kernels_scalar;
}
