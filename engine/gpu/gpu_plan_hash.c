/* gpu_plan: the rows as one number. Each member is hashed as a value of a fixed width, so that padding, addresses and
 * the order of members in memory do not matter. Numbers of resources are replaced by what they stand for. */
#include "gpu/gpu_plan_internal.h"

#include <string.h>

static uint64_t add_text(uint64_t hash, const char *text)
{
	return stilb_hash_fnv1a64(hash, text, strlen(text) + 1);
}

/* Little-endian, on any processor. */
static uint64_t add(uint64_t hash, uint32_t value)
{
	uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
	return stilb_hash_fnv1a64(hash, bytes, sizeof bytes);
}

static uint64_t add_float(uint64_t hash, float value)
{
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	return add(hash, bits);
}

/* All that is known of a resource: name, kind and sizes. */
static uint64_t add_resource(uint64_t hash, const stilb_gpu_plan *plan, uint16_t number)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	const stilb_gpu_extent *extent = &resource->extent;
	hash = add_text(hash, resource->name);
	hash = add(add(hash, (uint32_t)extent->format), (uint32_t)extent->shape);
	hash = add(add(add(hash, extent->width), extent->height), extent->depth);
	hash = add(add(add(hash, extent->layers), extent->mips), extent->samples);
	hash = add(add(hash, (uint32_t)resource->bytes), (uint32_t)(resource->bytes >> 32));
	uint32_t stays = resource->image.keep | resource->image.output << 1 | (resource->image.owned != 0) << 2;
	return add(hash, stays);
}

static uint64_t add_attachment(uint64_t hash, const stilb_gpu_plan *plan, const stilb_gpu_attachment *attachment)
{
	if (attachment->image == 0)
		return add(hash, attachment->load);
	hash = add_resource(hash, plan, attachment->image);
	if (attachment->resolve != 0)
		hash = add_resource(hash, plan, attachment->resolve);
	hash = add(add(hash, attachment->mip), attachment->layer);
	hash = add(add(hash, attachment->layers > 0 ? attachment->layers : 1), attachment->load);
	hash = add(hash, attachment->read_only);
	bool clears = attachment->load == STILB_GPU_LOAD_CLEAR || attachment->load == STILB_GPU_LOAD_CLEAR_AREA;
	for (uint32_t i = 0; clears && i < 4; i++)
		hash = add_float(hash, attachment->clear[i]);
	return hash;
}

static uint64_t add_use(uint64_t hash, const stilb_gpu_plan *plan, const stilb_gpu_use *use)
{
	stilb_gpu_range range = stilb_gpu_plan_range(plan, use);
	hash = add_resource(hash, plan, use->resource);
	hash = add(add(add(hash, use->how), use->previous | (uint32_t)use->array << 1), use->slot);
	hash = add(add(add(add(hash, range.mip), range.mips), range.layer), range.layers);
	return use->how == STILB_GPU_USE_UNIFORM ? add(add(hash, use->first), use->bytes) : hash;
}

/* Constants, with zeros where the device writes the addresses of buffers. */
static uint64_t add_constants(uint64_t hash, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	uint8_t bytes[STILB_GPU_MAX_CONSTANTS];
	memcpy(bytes, pass->constants, sizeof bytes);
	for (uint32_t i = 0; i < pass->use_count; i++) {
		const stilb_gpu_use *use = &pass->uses[i];
		bool address = gpu_plan_resource(plan, use->resource)->buffer && use->how >= STILB_GPU_USE_STORAGE_READ &&
		               use->how <= STILB_GPU_USE_STORAGE && use->slot != STILB_GPU_NO_SLOT;
		if (address)
			memset(bytes + use->slot, 0, 8);
	}
	return stilb_hash_fnv1a64(add(hash, pass->constant_bytes), bytes, pass->constant_bytes);
}

static uint64_t add_pass(uint64_t hash, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	hash = add(add_text(hash, pass->name), pass->kind);
	hash = add(add(hash, pass->color_count), pass->use_count);
	if (pass->kind == STILB_GPU_PASS_DRAWS)
		hash = add(hash, pass->draws);
	if (pass->queue != STILB_GPU_QUEUE_MAIN)
		hash = add(hash, 0x100 + pass->queue);
	for (uint32_t i = 0; i < 3; i++)
		hash = add(hash, pass->groups[i]);
	for (uint32_t i = 0; i < 4 && gpu_pass_has_area(pass); i++)
		hash = add(hash, 0x10000 + pass->area[i]);
	for (uint32_t i = 0; i < pass->color_count; i++)
		hash = add_attachment(hash, plan, &pass->color[i]);
	hash = add(hash, pass->depth.image != 0);
	if (pass->depth.image != 0)
		hash = add_attachment(hash, plan, &pass->depth);
	for (uint32_t i = 0; i < pass->use_count; i++)
		hash = add_use(hash, plan, &pass->uses[i]);
	return add_constants(hash, plan, pass);
}

uint64_t stilb_gpu_plan_hash(const stilb_gpu_plan *plan)
{
	STILB_ASSERT(plan && plan->made);
	const stilb_gpu_step *steps = plan->steps.items;
	uint64_t hash = add(add(STILB_FNV1A64_START, plan->size[0]), plan->size[1]);
	for (uint32_t i = 0; i < plan->step_count; i++)
		hash = add_pass(hash, plan, gpu_plan_row(plan, steps[i].pass));
	return hash;
}
