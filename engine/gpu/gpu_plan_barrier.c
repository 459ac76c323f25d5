/*
 * gpu_plan: barriers, and what a frame leaves for the next.
 *
 * Between two barriers, a part of a resource is written once, or read in one layout any number of times. So a barrier
 * is needed before each write, and before the first read after a write or in another layout; a later read that the
 * barrier did not name is added to it, as nothing has changed in between. Only reads that last frame's barrier made
 * possible cannot be added to it: another way of reading then needs a barrier of its own.
 *
 * A barrier orders one access after those since the barrier before it. What happened earlier still is ordered by that
 * one: execution dependencies chain, and memory that was once made available stays so (Vulkan 1.3 specification,
 * "Execution and Memory Dependencies").
 */
#include "gpu/gpu_plan_internal.h"

#include <string.h>

/* ---- heaps: what used a part of them last ------------------------------------------------------------------------ */

/* How a resource's memory was used last. */
static uint32_t last_accesses(const stilb_gpu_plan *plan, uint16_t number)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	const gpu_sub *subs = (const gpu_sub *)plan->subs.items + resource->first_sub;
	uint32_t accesses = 0;
	for (uint32_t i = 0; i < resource->subs; i++)
		if (subs[i].last != STILB_GPU_ACCESS_NONE)
			accesses |= subs[i].readers != 0 ? subs[i].readers : 1u << subs[i].write;
	return accesses;
}

static uint32_t region_accesses(const stilb_gpu_plan *plan, const gpu_region *region)
{
	return region->resource != 0 ? last_accesses(plan, region->resource) : region->accesses;
}

/* Gives begin..end of a heap to a resource, and returns what used it before. Regions are sorted by heap and place, and
 * do not overlap. False: no memory. */
static bool take_region(stilb_gpu_plan *plan, gpu_region taken, uint32_t *before)
{
	gpu_left *next = &plan->next;
	if (!gpu_array_reserve(&next->regions, next->region_count + 2, sizeof(gpu_region)))
		return false;
	gpu_region *regions = next->regions.items;
	uint32_t low = 0, high = next->region_count; /* the first that ends after `begin` */
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		const gpu_region *region = &regions[middle];
		if (region->heap < taken.heap || (region->heap == taken.heap && region->end <= taken.begin))
			low = middle + 1;
		else
			high = middle;
	}
	uint32_t accesses = 0;
	gpu_region parts[3]; /* what is left of the first, the new one, what is left of the last */
	uint32_t part_count = 0, end = low;
	for (; end < next->region_count && regions[end].heap == taken.heap && regions[end].begin < taken.end; end++)
		accesses |= region_accesses(plan, &regions[end]);
	if (end > low && regions[low].begin < taken.begin) {
		parts[part_count] = regions[low];
		parts[part_count++].end = taken.begin;
	}
	parts[part_count++] = taken;
	if (end > low && regions[end - 1].end > taken.end) {
		parts[part_count] = regions[end - 1];
		parts[part_count++].begin = taken.end;
	}
	if (part_count != end - low) /* most often one takes the place of one */
		memmove(&regions[low + part_count], &regions[end], (next->region_count - end) * sizeof *regions);
	for (uint32_t i = 0; i < part_count; i++)
		regions[low + i] = parts[i];
	next->region_count += part_count - (end - low);
	*before = accesses;
	return true;
}

static bool begin_regions(stilb_gpu_plan *plan)
{
	gpu_left *next = &plan->next;
	if (!gpu_array_reserve(&next->regions, plan->left.region_count, sizeof(gpu_region)))
		return false;
	next->region_count = plan->left.region_count;
	if (next->region_count > 0)
		memcpy(next->regions.items, plan->left.regions.items, next->region_count * sizeof(gpu_region));
	return true;
}

/* Puts accesses in place of this frame's resources, and joins neighbours with the same. */
static void end_regions(stilb_gpu_plan *plan)
{
	gpu_region *regions = plan->next.regions.items;
	uint32_t left = 0;
	for (uint32_t i = 0; i < plan->next.region_count; i++) {
		gpu_region region = regions[i];
		region.accesses = region_accesses(plan, &region);
		region.resource = 0;
		gpu_region *before = left > 0 ? &regions[left - 1] : NULL;
		if (before && before->heap == region.heap && before->end == region.begin && before->accesses == region.accesses)
			before->end = region.end;
		else
			regions[left++] = region;
	}
	plan->next.region_count = left;
}

/* ---- states at the frame's start --------------------------------------------------------------------------------- */

/* Nothing has touched it. */
static gpu_sub fresh_sub(const gpu_resource *resource)
{
	if (resource->image.owned == 0)
		return (gpu_sub){.layout = STILB_GPU_LAYOUT_NONE};
	if (resource->buffer)
		return (gpu_sub){.layout = STILB_GPU_LAYOUT_NONE, .visible = UINT32_MAX, .now = true};
	return (gpu_sub){.layout = GPU_LAYOUT_UNKNOWN, .now = true};
}

/* Copies one half of a record's states. A record with one state for all fills as many as there are, and the other way
 * round if all are the same, which gpu_plan_live.c has made sure of. */
static void copy_half(gpu_sub *to, const gpu_resource *resource, const gpu_sub *from, const gpu_record *record)
{
	for (uint32_t i = 0; i < resource->subs; i++)
		to[i] = from[record->subs == 1 ? 0 : i];
}

static void begin_resource(stilb_gpu_plan *plan, uint32_t number)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	gpu_sub *subs = (gpu_sub *)plan->subs.items + resource->first_sub, *other = subs + resource->subs;
	bool two = gpu_plan_placed(plan, number)->two;
	uint32_t count = resource->image.keep ? 2 * resource->subs : resource->subs;
	if (resource->record == GPU_NO_RECORD || !two) {
		gpu_sub fresh = fresh_sub(resource);
		for (uint32_t i = 0; i < count; i++)
			subs[i] = fresh;
	}
	if (resource->record == GPU_NO_RECORD)
		return;
	const gpu_record *record = (const gpu_record *)plan->left.records.items + resource->record;
	const gpu_sub *from = (const gpu_sub *)plan->left.subs.items + record->first_sub;
	copy_half(two ? other : subs, resource, from, record);
	if (two && record->two)
		copy_half(subs, resource, from + record->subs, record);
	else if (two)
		for (uint32_t i = 0; i < resource->subs; i++)
			subs[i] = fresh_sub(resource);
}

static bool begin_states(stilb_gpu_plan *plan)
{
	if (!gpu_array_reserve(&plan->subs, plan->sub_count, sizeof(gpu_sub)) || !begin_regions(plan))
		return false;
	/* What lives within the frame begins as zeros: fresh_sub. */
	static_assert(STILB_GPU_LAYOUT_NONE == 0 && STILB_GPU_ACCESS_NONE == 0, "states of zeros");
	memset(plan->subs.items, 0, plan->sub_count * sizeof(gpu_sub));
	for (uint32_t c = 0; c < plan->counted_count; c++)
		begin_resource(plan, ((const uint16_t *)plan->counted.items)[c]);
	return true;
}

/* ---- one touch --------------------------------------------------------------------------------------------------- */

/* A touch while its barriers are found. */
typedef struct touched {
	stilb_gpu_plan *plan;
	const gpu_touch *touch;
	gpu_sub *subs;   /* of mip 0, layer 0 */
	uint32_t stride; /* of layers; 0: one state for all */
	uint32_t accesses;
	bool replaces; /* content that may be there is not needed */
	bool writes;
	bool content_alone; /* parts that this frame has not written are left alone */
} touched;

/* How the memory of what a touch is of was used before. */
static uint32_t memory_readers(const touched *t)
{
	return gpu_plan_life(t->plan, t->touch->resource)->memory_readers;
}

/* What a state has been made visible to. */
static uint32_t visible_to(const stilb_gpu_plan *plan, const gpu_sub *sub)
{
	const stilb_gpu_barrier *barriers = plan->barriers.items;
	return sub->barrier != 0 ? sub->visible | barriers[sub->barrier - 1].to_all : sub->visible;
}

static bool drops_content(const touched *t, const gpu_sub *sub)
{
	return t->replaces && !(sub->now && !t->touch->replaces);
}

/* The device has to fill it with zeros: last frame has left nothing, nor zeros. */
static bool needs_zeros(const touched *t, const gpu_sub *sub)
{
	return t->touch->previous && !sub->old && !sub->zeros;
}

/* 0: no barrier; else equal for states that one barrier can serve: those that come from one layout, or from any, and
 * are filled with zeros, or not. */
static uint8_t sub_key(const touched *t, const gpu_sub *sub)
{
	const gpu_touch *touch = t->touch;
	bool zero = needs_zeros(t, sub);
	if (t->writes) {
		bool buffer = touch->layout == STILB_GPU_LAYOUT_NONE;
		bool nobody = buffer && sub->readers == 0 && sub->write == STILB_GPU_ACCESS_NONE;
		if (nobody && (memory_readers(t) == 0 || sub->last != STILB_GPU_ACCESS_NONE))
			return 0;
	} else if (!zero && sub->layout == touch->layout) {
		if ((t->accesses & ~visible_to(t->plan, sub)) == 0 || sub->barrier != 0)
			return 0;
	}
	if (zero || drops_content(t, sub))
		return (uint8_t)(zero ? 0x42 : 0x41);
	return (uint8_t)(0x80 | (sub->layout & 0x3f));
}

/* Accesses that a barrier has to wait for. */
static uint32_t sub_before(const touched *t, const gpu_sub *sub)
{
	if (sub->last == STILB_GPU_ACCESS_NONE)
		return memory_readers(t);
	uint32_t write = sub->write != STILB_GPU_ACCESS_NONE ? 1u << sub->write : 0;
	if (sub->readers == 0)
		return write;
	bool more_readers = !t->writes && sub->layout == t->touch->layout && !needs_zeros(t, sub);
	return more_readers ? sub->readers | write : sub->readers;
}

/* The access itself. barrier: index + 1; 0: it needs none. */
static void sub_access(const touched *t, gpu_sub *sub, uint32_t barrier)
{
	const gpu_touch *touch = t->touch;
	if (t->writes) {
		sub->write = touch->access;
		sub->readers = sub->visible = 0;
		sub->barrier = 0;
		sub->now = true;
		sub->zeros = false;
	} else if (barrier != 0) {
		bool more_readers = sub->layout == touch->layout && !needs_zeros(t, sub);
		sub->readers = more_readers ? sub->readers | t->accesses : t->accesses;
		sub->visible = more_readers ? sub->visible : 0;
		sub->barrier = barrier;
	} else {
		sub->readers |= t->accesses;
		if (sub->barrier != 0)
			((stilb_gpu_barrier *)t->plan->barriers.items)[sub->barrier - 1].to_all |= t->accesses;
	}
	sub->zeros = sub->zeros || needs_zeros(t, sub);
	sub->last = touch->access;
	sub->layout = touch->layout;
}

/* ---- barriers of ranges ------------------------------------------------------------------------------------------ */

static bool same_way(const stilb_gpu_barrier *a, const stilb_gpu_barrier *b, stilb_gpu_format_kind kind)
{
	return a->resource == b->resource && a->discard == b->discard && a->zero == b->zero && a->previous == b->previous &&
	       a->memory == b->memory &&
	       (a->discard || ((a->from == STILB_GPU_ACCESS_NONE) == (b->from == STILB_GPU_ACCESS_NONE) &&
	                       stilb_gpu_access_layout(a->from, kind) == stilb_gpu_access_layout(b->from, kind))) &&
	       stilb_gpu_access_layout(a->to, kind) == stilb_gpu_access_layout(b->to, kind);
}

/* Makes one of two ranges that lie side by side; false: they do not. */
static bool join_ranges(stilb_gpu_barrier *a, const stilb_gpu_barrier *b)
{
	if (a->layer == b->layer && a->layers == b->layers && (a->mip + a->mips == b->mip || b->mip + b->mips == a->mip)) {
		a->mip = a->mip < b->mip ? a->mip : b->mip;
		a->mips = (uint8_t)(a->mips + b->mips);
		return true;
	}
	if (a->mip == b->mip && a->mips == b->mips &&
	    (a->layer + a->layers == b->layer || b->layer + b->layers == a->layer)) {
		a->layer = a->layer < b->layer ? a->layer : b->layer;
		a->layers = (uint16_t)(a->layers + b->layers);
		return true;
	}
	return false;
}

/* States that wait for barrier `from` wait for barrier `to` instead; both are index + 1. */
static void rename_barrier(stilb_gpu_plan *plan, uint16_t number, uint32_t from, uint32_t to)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	gpu_sub *subs = (gpu_sub *)plan->subs.items + resource->first_sub;
	uint32_t count = resource->image.keep ? 2 * resource->subs : resource->subs;
	for (uint32_t i = 0; i < count; i++)
		if (subs[i].barrier == from)
			subs[i].barrier = to;
}

/* Makes one of two barriers of a step if it can be; they keep their order. */
static bool join(stilb_gpu_plan *plan, uint32_t a, uint32_t b)
{
	stilb_gpu_barrier *barriers = plan->barriers.items;
	if (barriers[b].resource != barriers[a].resource)
		return false;
	const gpu_resource *resource = gpu_plan_resource(plan, barriers[a].resource);
	if (resource->subs == 1 ||
	    !same_way(&barriers[a], &barriers[b], stilb_gpu_format_describe(resource->extent.format)->kind) ||
	    !join_ranges(&barriers[a], &barriers[b]))
		return false;
	barriers[a].from_all |= barriers[b].from_all;
	barriers[a].to_all |= barriers[b].to_all;
	rename_barrier(plan, barriers[b].resource, b + 1, a + 1);
	for (uint32_t i = b + 1; i < plan->barrier_count; i++) {
		rename_barrier(plan, barriers[i].resource, i + 1, i);
		barriers[i - 1] = barriers[i];
	}
	plan->barrier_count--;
	return true;
}

/* A step's uses of one image may need barriers that are one together. */
static void join_step(stilb_gpu_plan *plan, uint32_t first_of_step)
{
	for (uint32_t b = first_of_step + 1; b < plan->barrier_count; b++)
		for (uint32_t a = first_of_step; a < b; a++)
			if (join(plan, a, b)) {
				b = first_of_step; /* the wider one may now join others */
				break;
			}
}

/* Adds a barrier for the states in a range, which have one key, and returns its index + 1. Written member by member
 * where it stays: a copy that is read in larger pieces than it was written in would wait for them. */
static uint32_t add_barrier(const touched *t, stilb_gpu_range range, uint8_t key)
{
	const gpu_touch *touch = t->touch;
	uint32_t from_all = 0;
	uint8_t from = STILB_GPU_ACCESS_NONE;
	bool first = true, memory = false;
	for (uint32_t layer = range.layer; layer < (uint32_t)range.layer + range.layers; layer++)
		for (uint32_t mip = range.mip; mip < (uint32_t)range.mip + range.mips; mip++) {
			const gpu_sub *sub = &t->subs[layer * t->stride + (t->stride > 0 ? mip : 0)];
			if (t->stride == 0 && !first)
				continue;
			from_all |= sub_before(t, sub);
			from = first ? sub->last : from;
			memory = memory || (sub->last == STILB_GPU_ACCESS_NONE && memory_readers(t) != 0);
			first = false;
		}
	stilb_gpu_barrier *barrier = (stilb_gpu_barrier *)t->plan->barriers.items + t->plan->barrier_count;
	barrier->resource = touch->resource;
	barrier->from = from;
	barrier->to = touch->access;
	barrier->from_all = from_all;
	barrier->to_all = t->accesses;
	barrier->discard = !(key & 0x80);
	barrier->zero = key == 0x42;
	barrier->previous = touch->previous && gpu_plan_placed(t->plan, touch->resource)->two;
	barrier->memory = memory;
	barrier->mip = range.mip;
	barrier->mips = range.mips;
	barrier->layer = range.layer;
	barrier->layers = range.layers;
	return ++t->plan->barrier_count;
}

/* The largest range from a corner on, within `within`, whose keys are that of the corner. */
static stilb_gpu_range grow(const touched *t, const uint8_t *keys, stilb_gpu_range within, uint32_t layer, uint32_t mip,
                            bool mips_first)
{
	uint32_t stride = t->stride;
	uint8_t key = keys[layer * stride + mip];
	uint32_t last_mip = (uint32_t)within.mip + within.mips, last_layer = (uint32_t)within.layer + within.layers;
	uint32_t mips = 1, layers = 1;
	for (uint32_t pass = 0; pass < 2; pass++) {
		bool along_mips = mips_first == (pass == 0);
		for (bool same = true; same;) {
			if (along_mips ? mip + mips == last_mip : layer + layers == last_layer)
				break;
			uint32_t across = along_mips ? layers : mips;
			for (uint32_t i = 0; i < across && same; i++)
				same = key == (along_mips ? keys[(layer + i) * stride + mip + mips]
				                          : keys[(layer + layers) * stride + mip + i]);
			if (same && along_mips)
				mips++;
			else if (same)
				layers++;
		}
	}
	return (stilb_gpu_range){(uint8_t)mip, (uint8_t)mips, (uint16_t)layer, (uint16_t)layers};
}

/* Cuts what has keys into ranges, adds their barriers if `add`, and returns their number. Clears keys. */
static uint32_t cut(const touched *t, uint8_t *keys, bool mips_first, bool add)
{
	stilb_gpu_range within = t->touch->range;
	uint32_t stride = t->stride, count = 0;
	for (uint32_t layer = within.layer; layer < (uint32_t)within.layer + within.layers; layer++)
		for (uint32_t mip = within.mip; mip < (uint32_t)within.mip + within.mips; mip++) {
			uint8_t key = keys[layer * stride + mip];
			if (key == 0)
				continue;
			stilb_gpu_range range = grow(t, keys, within, layer, mip, mips_first);
			uint32_t barrier = add ? add_barrier(t, range, key) : 0;
			for (uint32_t l = layer; l < layer + range.layers; l++)
				for (uint32_t m = mip; m < mip + range.mips; m++) {
					keys[l * stride + m] = 0;
					if (add)
						sub_access(t, &t->subs[l * stride + m], barrier);
				}
			count++;
		}
	return count;
}

/* A touch of a resource with a state for each mip and layer. */
static bool touch_parts(const touched *t)
{
	stilb_gpu_plan *plan = t->plan;
	stilb_gpu_range range = t->touch->range;
	uint32_t stride = t->stride, count = gpu_plan_resource(plan, t->touch->resource)->subs;
	if (!gpu_array_reserve(&plan->keys, 2 * (size_t)count, 1) ||
	    !gpu_array_reserve(&plan->barriers, plan->barrier_count + (size_t)range.mips * range.layers,
	                       sizeof(stilb_gpu_barrier)))
		return false;
	uint8_t *keys = plan->keys.items, *tried = keys + count;
	for (uint32_t layer = range.layer; layer < (uint32_t)range.layer + range.layers; layer++)
		for (uint32_t mip = range.mip; mip < (uint32_t)range.mip + range.mips; mip++) {
			uint32_t at = layer * stride + mip;
			bool skip = t->content_alone && !t->subs[at].now;
			keys[at] = tried[at] = skip ? 0 : sub_key(t, &t->subs[at]);
			if (keys[at] == 0 && !skip)
				sub_access(t, &t->subs[at], 0);
		}
	bool mips_first = true;
	if (range.mips > 1 && range.layers > 1) {
		uint32_t mips = cut(t, tried, true, false);
		memcpy(tried, keys, count);
		mips_first = mips <= cut(t, tried, false, false);
	}
	cut(t, keys, mips_first, true);
	return true;
}

static bool touch_one(stilb_gpu_plan *plan, const gpu_touch *touch)
{
	touched t = {
		.plan = plan,
		.touch = touch,
		.subs = (gpu_sub *)plan->subs.items + touch->first,
		.accesses = 1u << touch->access,
		.replaces = touch->replaces || (touch->writes && !touch->reads && !touch->owned),
		.writes = touch->writes,
		.content_alone = touch->access == STILB_GPU_ACCESS_OUTPUT,
	};
	if (touch->previous && gpu_plan_placed(plan, touch->resource)->two)
		t.subs += gpu_plan_resource(plan, touch->resource)->subs;
	if (touch->many) {
		t.stride = gpu_plan_resource(plan, touch->resource)->extent.mips;
		t.subs -= touch->range.layer * t.stride + touch->range.mip;
		return touch_parts(&t);
	}
	if (t.content_alone && !t.subs->now)
		return true; /* an output without content, in a frame that is cut */
	if (!gpu_array_reserve(&plan->barriers, (size_t)plan->barrier_count + 1, sizeof(stilb_gpu_barrier)))
		return false;
	uint8_t key = sub_key(&t, t.subs);
	uint32_t barrier = key != 0 ? add_barrier(&t, touch->range, key) : 0;
	sub_access(&t, t.subs, barrier);
	return true;
}

/* ---- the frame --------------------------------------------------------------------------------------------------- */

/* Before a transient resource's first step: what its memory was used for. */
static bool begin_memory(stilb_gpu_plan *plan, uint16_t number)
{
	const stilb_gpu_placed *placed = gpu_plan_placed(plan, number);
	if (!placed->shared)
		return true;
	return take_region(
		plan,
		(gpu_region){
			.begin = placed->offset, .end = placed->offset + placed->bytes, .heap = placed->heap, .resource = number},
		&gpu_plan_life(plan, number)->memory_readers);
}

/* The same for all that a step is the first to touch. */
static bool begin_memories(stilb_gpu_plan *plan, const gpu_touch *touches, uint32_t count, uint32_t step)
{
	for (uint32_t i = 0; i < count; i++) {
		bool begins = gpu_plan_life(plan, touches[i].resource)->first == step + 1;
		for (uint32_t k = 0; k < i && begins; k++)
			begins = touches[k].resource != touches[i].resource; /* else it has its memory already */
		if (begins && !begin_memory(plan, touches[i].resource))
			return false;
	}
	return true;
}

static bool walk_steps(stilb_gpu_plan *plan)
{
	stilb_gpu_step *steps = plan->steps.items;
	for (uint32_t s = 0; s < plan->step_count; s++) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, steps[s].pass, &count);
		steps[s].first_barrier = plan->barrier_count;
		if (!begin_memories(plan, touches, count, s))
			return false;
		for (uint32_t i = 0; i < count; i++)
			if (!touch_one(plan, &touches[i]))
				return false;
		join_step(plan, steps[s].first_barrier);
		steps[s].barrier_count = plan->barrier_count - steps[s].first_barrier;
	}
	return true;
}

/* Outputs as they are read after the frame: what of them has content. */
static bool walk_outputs(stilb_gpu_plan *plan)
{
	plan->last_barrier = plan->barrier_count;
	for (uint32_t c = 0; c < plan->counted_count; c++) {
		uint16_t number = ((const uint16_t *)plan->counted.items)[c];
		const gpu_resource *resource = gpu_plan_resource(plan, number);
		const stilb_gpu_extent *extent = &resource->extent;
		if (!resource->image.output && !resource->shown)
			continue;
		gpu_touch touch = {.resource = number,
		                   .access = STILB_GPU_ACCESS_OUTPUT,
		                   .layout = resource->buffer ? STILB_GPU_LAYOUT_NONE : STILB_GPU_LAYOUT_COPY_FROM,
		                   .owned = resource->image.owned != 0,
		                   .many = resource->subs > 1,
		                   .range = {0, (uint8_t)extent->mips, 0, extent->layers},
		                   .first = resource->first_sub};
		if (!touch_one(plan, &touch))
			return false;
	}
	return true;
}

/* ---- what is left ------------------------------------------------------------------------------------------------ */

static gpu_sub sub_left(const stilb_gpu_plan *plan, const gpu_resource *resource, gpu_sub sub)
{
	sub.visible = visible_to(plan, &sub);
	sub.barrier = 0;
	sub.old = sub.now && resource->image.keep;
	sub.now = resource->image.owned != 0;
	return sub;
}

static bool leave(stilb_gpu_plan *plan)
{
	gpu_left *next = &plan->next;
	if (!gpu_array_reserve(&next->records, plan->counted_count, sizeof(gpu_record)) ||
	    !gpu_array_reserve(&next->subs, plan->sub_count, sizeof(gpu_sub)))
		return false;
	next->record_count = next->sub_count = 0;
	for (uint32_t c = 0; c < plan->counted_count; c++) {
		uint32_t i = ((const uint16_t *)plan->counted.items)[c];
		const gpu_resource *resource = gpu_plan_resource(plan, i);
		const stilb_gpu_placed *placed = gpu_plan_placed(plan, i);
		if (placed->first_step == UINT32_MAX && resource->record == GPU_NO_RECORD)
			continue;
		if (placed->stay == 0 && placed->owned == 0)
			continue;
		gpu_record *record = (gpu_record *)next->records.items + next->record_count;
		memset(record, 0, sizeof *record);
		memcpy(record->name, resource->name, sizeof record->name);
		record->name_hash = resource->name_hash;
		record->owned = placed->owned;
		record->bytes = resource->bytes;
		record->stay = placed->stay;
		record->extent = resource->extent;
		record->first_sub = next->sub_count;
		record->subs = resource->subs;
		record->two = placed->two;
		record->keep = resource->image.keep;
		record->written = gpu_plan_life(plan, i)->written;
		next->record_count++;
		uint32_t count = resource->image.keep ? 2 * resource->subs : resource->subs;
		gpu_sub *to = (gpu_sub *)next->subs.items + next->sub_count;
		const gpu_sub *from = (const gpu_sub *)plan->subs.items + resource->first_sub;
		for (uint32_t s = 0; s < count; s++)
			to[s] = sub_left(plan, resource, from[s]);
		next->sub_count += count;
	}
	end_regions(plan);
	return true;
}

static bool record_equal(const gpu_record *a, const gpu_record *b)
{
	return a->stay == b->stay && a->owned == b->owned && a->subs == b->subs && a->two == b->two && a->keep == b->keep &&
	       a->written == b->written && strcmp(a->name, b->name) == 0;
}

/* The frame leaves everything as it found it: another one with the same rows has the same barriers. */
static bool left_as_found(const stilb_gpu_plan *plan)
{
	const gpu_left *a = &plan->left, *b = &plan->next;
	if (a->record_count != b->record_count || a->sub_count != b->sub_count || a->region_count != b->region_count)
		return false;
	for (uint32_t i = 0; i < a->record_count; i++)
		if (!record_equal((const gpu_record *)a->records.items + i, (const gpu_record *)b->records.items + i))
			return false;
	for (uint32_t i = 0; i < a->sub_count; i++)
		if (!gpu_sub_equal((const gpu_sub *)a->subs.items + i, (const gpu_sub *)b->subs.items + i))
			return false;
	const gpu_region *x = a->regions.items, *y = b->regions.items;
	for (uint32_t i = 0; i < a->region_count; i++)
		if (x[i].begin != y[i].begin || x[i].end != y[i].end || x[i].heap != y[i].heap ||
		    x[i].accesses != y[i].accesses)
			return false;
	return true;
}

stilb_result gpu_plan_find_barriers(stilb_gpu_plan *plan)
{
	plan->barrier_count = plan->last_barrier = 0;
	if (!begin_states(plan) || !walk_steps(plan) || !walk_outputs(plan) || !leave(plan))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the barriers of a plan of %u passes", plan->row_count);
	plan->steady = left_as_found(plan);
	return STILB_OK;
}
