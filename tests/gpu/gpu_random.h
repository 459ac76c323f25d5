/* Random tables of images, buffers and passes without a mistake. */
#ifndef GPU_RANDOM_H
#define GPU_RANDOM_H

#include "gpu/gpu_plan.h"

#define RANDOM_RESOURCES 8u
#define RANDOM_PASSES 24u /* at most; those that fill outputs included */
#define RANDOM_SUBS 18u   /* mips times layers of a resource, at most */

typedef struct random_table {
	uint32_t resource_count, pass_count;
	bool buffer[RANDOM_RESOURCES + 1]; /* by the number that the plan gives */
	stilb_gpu_plan_image_row images[RANDOM_RESOURCES + 1];
	stilb_gpu_plan_buffer_row buffers[RANDOM_RESOURCES + 1];
	uint32_t mips[RANDOM_RESOURCES + 1], layers[RANDOM_RESOURCES + 1]; /* 1 of buffers */
	stilb_gpu_pass passes[RANDOM_PASSES];
} random_table;

/* What a pass does with one mip and layer of a resource, found out from its row alone. */
typedef struct random_access {
	uint32_t resource, mip, layer;
	stilb_gpu_access access;
	bool reads;    /* its content must be what was written */
	bool replaces; /* all of its content */
	bool previous;
} random_access;
#define RANDOM_ACCESSES 512u

/* resources, passes: seeds. Tables of the same resources have the same ones. */
void random_make(random_table *table, uint64_t resources, uint64_t passes);

/* Adds the rows to a plan that has begun. */
void random_add(const random_table *table, stilb_gpu_plan *plan);

/* Fills accesses, at most RANDOM_ACCESSES, and returns their number. */
uint32_t random_accesses(const random_table *table, const stilb_gpu_pass *pass, random_access *accesses);

/* Flags of a resource. */
bool random_keeps(const random_table *table, uint32_t resource);
bool random_outputs(const random_table *table, uint32_t resource);
uint64_t random_owned(const random_table *table, uint32_t resource);
stilb_gpu_format_kind random_kind(const random_table *table, uint32_t resource);

#endif
