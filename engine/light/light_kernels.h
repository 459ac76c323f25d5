/*
 * The innermost loops of light lists: a table of functions for each instruction set. All tables give the same results,
 * bit for bit: float operations in the order of light_scalar.c, without fused multiply-add. Only light_avx2.c and
 * light_avx512.c are compiled for more than the baseline of the architecture.
 *
 * Space is that of clip coordinates: a point is its x, y, w there and its depth. The signed distance of a point from
 * the plane between two rows is y * inverse - w * offset, metres, positive towards the later ones; of columns alike. A
 * sphere whose centre is outside a plane is replaced by the smaller sphere around the circle in which it meets the
 * plane: that one holds all of the sphere that is inside. So a light's sphere shrinks to what of it is in a slice, then
 * to what of that is in a row, and the planes through the eye that touch this are the ends of a span of columns. These
 * planes may touch outside of the slice: a span also ends where clip x of the sphere, over the slice's w, does.
 * Sources: Persson, Olsson, "Practical Clustered Deferred and Forward Shading" (2013); the tangents: derived here.
 */
#ifndef LIGHT_KERNELS_H
#define LIGHT_KERNELS_H

#include "base/base.h"
#include "light/light.h"

#define LIGHT_CHUNK 512u              /* lights that are worked on together; a multiple of LIGHT_LANES */
#define LIGHT_PICKED 1024u            /* most lights that are picked before rows are made of them */
#define LIGHT_LANES 16u               /* of the widest vector; kernels write up to so many elements more */
#define LIGHT_SQUARE_GROWTH 1.000002f /* of a squared radius: covers the rounding of r^2 - e^2 */
#define LIGHT_TANGENT_LIMIT 1.1f      /* w^2 over r^2 below which a sphere is too near to the eye for tangents */
#define LIGHT_TANGENT_GROWTH 0x1p-17f /* of a tangent, for rounding: a share of its terms */
#define LIGHT_COLUMN_GROWTH 1e-3f     /* of a span, for rounding: columns */
#define LIGHT_INVERSE_MAX 1e20f       /* one over w: of a slice that begins at the eye */
#define LIGHT_ACROSS_MIN 1e-20f       /* metres: keeps a quotient finite */
#define LIGHT_DENSE 32u       /* lights times columns of a row, over its pairs, up to which it is filled by columns */
#define LIGHT_BLOCK 12u       /* columns of a row that are filled together */
#define LIGHT_BLOCK_ROW 4096u /* most lights of a row that is filled so */
#define LIGHT_WITH_CONE 0x80000000u /* flag of a light's number: it has a cone */

/* Planes between columns or rows. */
typedef struct light_planes {
	float *inverse, *offset; /* [count of columns or rows + 1, padded by LIGHT_LANES with the last] */
	float *x, *w;            /* of rows: change of clip x and w for one metre along the plane's normal */
} light_planes;

/* The planes x = n w of clip space, [-1, 1]: |gradient|^2 = xx - 2 xw n + ww n^2. */
typedef struct light_columns {
	light_planes planes;
	uint32_t count;
	float xx, xw, ww;
	float area;         /* xx ww - xw^2 */
	float length;       /* root of xx: change of clip x for one metre, at most */
	float scale, shift; /* column of n: n * scale + shift */
} light_columns;

/* Depths between which slices lie, metres; the last one ends at infinity. */
typedef struct light_depths {
	float near_z[STILB_LIGHT_SLICES_MAX], far_z[STILB_LIGHT_SLICES_MAX];
	uint32_t count;
} light_depths;

/* A slice of the view. */
typedef struct light_slab {
	const light_planes *rows;
	const light_columns *columns;
	uint32_t slice;
	float near_z, far_z; /* depths between which it lies */
	/* One over the least and the greatest w of its points, finite. Of an orthographic view, whose w tells nothing,
	 * large numbers of both signs. */
	float inverse_near, inverse_far;
	float along[3]; /* change of clip x, y and w for one metre along the view */
} light_slab;

/* Lights, an array for each component. */
typedef struct light_chunk {
	const float *x, *y, *w, *depth, *radius; /* padded by LIGHT_LANES lights of no slice */
	const uint8_t *first_slice, *last_slice; /* of the slices that the light reaches; first > last: none */
	const uint32_t *number;
	uint32_t count;
} light_chunk;

/* Lights that reach a slice: the spheres around what of theirs is in it. */
typedef struct light_picked {
	float x[LIGHT_PICKED + LIGHT_LANES], y[LIGHT_PICKED + LIGHT_LANES], w[LIGHT_PICKED + LIGHT_LANES];
	float square[LIGHT_PICKED + LIGHT_LANES]; /* squared radius */
	uint32_t number[LIGHT_PICKED + LIGHT_LANES];
	uint32_t count;
} light_picked;

/* The points of cells: pixel (nx, ny), [-1, 1], shows at the depth z
 * base + nx base_x + ny base_y + z (ray + nx ray_x + ny ray_y). Of a perspective view base_x and base_y are 0, of an
 * orthographic one ray_x and ray_y are. */
typedef struct light_rays {
	float base_x[3], base_y[3], ray[3], ray_x[3], ray_y[3];
	float *edge_x, *edge_y; /* [columns + 1], [rows + 1], padded as the planes: nx and ny between them */
} light_rays;

/* A cone of at most half space. */
typedef struct light_cone {
	float base[3], axis[3]; /* base: from the apex to light_rays' base; axis: unit */
	float cosine, sine;     /* of the half angle, [0, 1] */
	float slack;            /* metres: what lies so far outside counts as inside */
	bool some;              /* false: there is none */
} light_cone;

/* A cone and the cells of one row of one slice. */
typedef struct light_cone_row {
	const light_rays *rays;
	const light_cone *cone;
	float y0, y1, near_z, far_z;
	/* From the axis to the middle of the cell whose middle is nx, perpendicular to the axis: across + nx across_x. */
	float across[3], across_x[3];
} light_cone_row;

/* Columns first .. last, both included, of one row that a light reaches; first > last: none. */
typedef struct light_span {
	uint16_t first, last;
} light_span;

#define LIGHT_SPAN_NONE ((light_span){1, 0})

typedef struct light_kernels {
	/* The first and the last slice that lights reach. Arrays are as long as the next multiple of LIGHT_LANES. */
	void (*slices)(const light_depths *depths, const float *depth, const float *radius, uint32_t count, uint8_t *first,
	               uint8_t *last);
	/* Adds the chunk's lights that reach the slice, and the rows first_row .. end_row - 1, in their order. */
	void (*pick)(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_chunk *chunk,
	             light_picked *picked);
	/* Copies those of `from` that reach the rows first_row .. end_row - 1. */
	void (*narrow)(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_picked *from,
	               light_picked *to);
	/* Writes the lights that reach a row and what they reach of it, and returns their number. */
	uint32_t (*spans)(const light_slab *slab, const light_picked *picked, uint32_t row, uint32_t *numbers,
	                  light_span *spans);
	/* Shortens a span to the columns whose cells the cone meets; to LIGHT_SPAN_NONE if there is none. */
	light_span (*trim)(const light_cone_row *row, light_span span);
	/* light_fill for rows with many pairs: block after block of LIGHT_BLOCK columns the lights that reach it, each with
	 * a bit for each of its columns; of these, column after column those that have its bit. May write up to
	 * ids[end - 1] what the cells that come later will overwrite, and to numbers and spans beyond the last
	 * LIGHT_LANES - 1 elements. */
	void (*fill_dense)(uint32_t *numbers, light_span *spans, uint32_t count, uint32_t *cursors, uint32_t columns,
	                   uint32_t end, uint32_t *ids);
} light_kernels;

extern const light_kernels light_kernels_scalar, light_kernels_avx2, light_kernels_avx512;

/* Appends each light to the lists of its cells: cursors are the places in ids where each column's list goes on. */
void light_fill(const uint32_t *numbers, const light_span *spans, uint32_t count, uint32_t *cursors, uint32_t *ids);

/* The function `trim` of AVX2, also of AVX-512: most spans are short. */
light_span light_trim_avx2(const light_cone_row *row, light_span span);

/* The table for an instruction set, which this CPU must have. */
const light_kernels *light_kernels_for(stilb_isa isa);

#endif
