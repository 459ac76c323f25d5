/*
 * gpu_plan: waits between queues.
 *
 * Steps of one queue come one after the other. A step must come after an earlier one of another queue if both touch a
 * part of a resource and one of them writes it or changes its layout, or if it takes over memory that the other used.
 * What a step comes after anyway is known as a number for each queue: the last step of it that is done (a vector clock:
 * Mattern, "Virtual Time and Global States of Distributed Systems", 1989). So a wait is added only for what neither the
 * step before, nor another wait of the same step, brings along.
 */
#include "gpu/gpu_plan_internal.h"

#include <string.h>

/* Steps + 1, by queue; 0: none. */
typedef struct gpu_clock {
	uint32_t at[STILB_GPU_QUEUES];
} gpu_clock;

/* Who touched a mip and layer. */
typedef struct gpu_order {
	uint32_t write;  /* step + 1 that wrote it or changed its layout last */
	gpu_clock reads; /* since then */
} gpu_order;

static uint32_t queue_of(const stilb_gpu_plan *plan, uint32_t step)
{
	return gpu_plan_row(plan, ((const stilb_gpu_step *)plan->steps.items)[step].pass)->queue;
}

/* `needs` also contains step `before` - 1; 0: nothing. */
static void need(const stilb_gpu_plan *plan, gpu_clock *needs, uint32_t before)
{
	if (before == 0)
		return;
	uint32_t *at = &needs->at[queue_of(plan, before - 1)];
	*at = *at > before ? *at : before;
}

static void need_all(gpu_clock *needs, const gpu_clock *before)
{
	for (uint32_t q = 0; q < STILB_GPU_QUEUES; q++)
		needs->at[q] = needs->at[q] > before->at[q] ? needs->at[q] : before->at[q];
}

/* A barrier of the step changes the layout of a part, or fills it with zeros. */
static bool changes_layout(const stilb_gpu_plan *plan, const stilb_gpu_step *step, const gpu_touch *touch, uint32_t mip,
                           uint32_t layer)
{
	const stilb_gpu_barrier *barriers = (const stilb_gpu_barrier *)plan->barriers.items + step->first_barrier;
	const stilb_gpu_extent *extent = &gpu_plan_resource(plan, touch->resource)->extent;
	stilb_gpu_format_kind kind = stilb_gpu_format_describe(extent->format)->kind;
	for (uint32_t i = 0; i < step->barrier_count; i++) {
		const stilb_gpu_barrier *b = &barriers[i];
		bool covers = b->resource == touch->resource && b->mip <= mip && mip < (uint32_t)b->mip + b->mips &&
		              b->layer <= layer && layer < (uint32_t)b->layer + b->layers;
		bool other = extent->format != STILB_GPU_NONE &&
		             (b->discard || stilb_gpu_access_layout(b->from, kind) != stilb_gpu_access_layout(b->to, kind));
		if (covers && (other || b->zero) && b->previous == (touch->previous && gpu_plan_placed(plan, b->resource)->two))
			return true;
	}
	return false;
}

/* Finds who used the memory before that a resource takes over with its first step. */
static void find_owners(const stilb_gpu_plan *plan, uint32_t s, uint32_t number)
{
	const stilb_gpu_placed *placed = gpu_plan_placed(plan, number);
	if (!placed->shared || placed->first_step != s)
		return;
	gpu_clock *users = plan->users.items, *owners = users + plan->resource_count + 1 + number;
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		const stilb_gpu_placed *other = gpu_plan_placed(plan, i);
		if (other->shared && other->heap == placed->heap && other->last_step < s &&
		    other->offset < placed->offset + placed->bytes && placed->offset < other->offset + other->bytes)
			need_all(owners, &users[i]);
	}
}

/* What a touch must come after; and it is remembered. */
static void order_touch(const stilb_gpu_plan *plan, uint32_t s, const gpu_touch *touch, gpu_clock *needs)
{
	const stilb_gpu_step *step = (const stilb_gpu_step *)plan->steps.items + s;
	const gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	uint32_t queue = queue_of(plan, s), stride = touch->many ? resource->extent.mips : 0;
	gpu_order *orders = (gpu_order *)plan->orders.items + touch->first;
	if (touch->previous && gpu_plan_placed(plan, touch->resource)->two)
		orders += resource->subs;
	for (uint32_t layer = 0; layer < (touch->many ? touch->range.layers : 1u); layer++)
		for (uint32_t mip = 0; mip < (touch->many ? touch->range.mips : 1u); mip++) {
			gpu_order *order = &orders[layer * stride + mip];
			need(plan, needs, order->write);
			if (order->write == 0) /* the first touch of a part takes its memory over */
				need_all(needs, (const gpu_clock *)plan->users.items + plan->resource_count + 1 + touch->resource);
			bool changes =
				touch->writes || changes_layout(plan, step, touch, touch->range.mip + mip, touch->range.layer + layer);
			if (changes) {
				need_all(needs, &order->reads);
				*order = (gpu_order){.write = s + 1};
			} else {
				order->reads.at[queue] = s + 1;
			}
		}
}

/* Adds the waits of a step that does not come after all of `needs` yet, and returns what it then comes after. */
static bool add_waits(stilb_gpu_plan *plan, uint32_t s, gpu_clock needs, gpu_clock *known)
{
	const gpu_clock *clocks = plan->clocks.items;
	if (!gpu_array_reserve(&plan->waits, plan->wait_count + STILB_GPU_QUEUES, sizeof(stilb_gpu_queue_wait)))
		return false;
	for (uint32_t q = 0; q < STILB_GPU_QUEUES; q++) {
		bool waits = needs.at[q] > known->at[q];
		for (uint32_t p = 0; p < STILB_GPU_QUEUES && waits; p++) /* another wait brings it along */
			if (p != q && needs.at[p] > known->at[p])
				waits = clocks[needs.at[p] - 1].at[q] < needs.at[q];
		if (waits)
			((stilb_gpu_queue_wait *)plan->waits.items)[plan->wait_count++] =
				(stilb_gpu_queue_wait){s, needs.at[q] - 1};
	}
	gpu_clock before = *known;
	for (uint32_t q = 0; q < STILB_GPU_QUEUES; q++)
		if (needs.at[q] > before.at[q])
			need_all(known, &clocks[needs.at[q] - 1]);
	return true;
}

static bool find_waits(stilb_gpu_plan *plan)
{
	gpu_clock last[STILB_GPU_QUEUES], all = {0}; /* of each queue's last step; last steps */
	memset(last, 0, sizeof last);
	for (uint32_t s = 0; s < plan->step_count; s++) {
		uint32_t count, queue = queue_of(plan, s);
		const gpu_touch *touches = gpu_plan_touches(plan, ((const stilb_gpu_step *)plan->steps.items)[s].pass, &count);
		gpu_clock needs = {0};
		for (uint32_t i = 0; i < count; i++) {
			find_owners(plan, s, touches[i].resource);
			order_touch(plan, s, &touches[i], &needs);
		}
		for (uint32_t i = 0; i < count; i++) {
			((gpu_clock *)plan->users.items)[touches[i].resource].at[queue] = s + 1;
			gpu_plan_placed(plan, touches[i].resource)->queues |= 1u << queue;
		}
		needs.at[queue] = 0; /* comes before anyway, or is the step itself */
		if (!add_waits(plan, s, needs, &last[queue]))
			return false;
		last[queue].at[queue] = all.at[queue] = s + 1;
		((gpu_clock *)plan->clocks.items)[s] = last[queue];
	}
	return add_waits(plan, plan->step_count, all, &last[STILB_GPU_QUEUE_MAIN]);
}

stilb_result gpu_plan_find_waits(stilb_gpu_plan *plan)
{
	plan->wait_count = 0;
	if (!plan->queued)
		return STILB_OK;
	size_t resources = plan->resource_count + 1;
	if (!gpu_array_reserve(&plan->orders, plan->sub_count, sizeof(gpu_order)) ||
	    !gpu_array_reserve(&plan->users, 2 * resources, sizeof(gpu_clock)) ||
	    !gpu_array_reserve(&plan->clocks, plan->step_count, sizeof(gpu_clock)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the waits of a plan of %u passes", plan->row_count);
	memset(plan->orders.items, 0, plan->sub_count * sizeof(gpu_order));
	memset(plan->users.items, 0, 2 * resources * sizeof(gpu_clock));
	for (uint32_t i = 1; i < resources; i++)
		gpu_plan_placed(plan, i)->queues = 0;
	return find_waits(plan)
	           ? STILB_OK
	           : stilb_fail(STILB_ERROR_MEMORY, "no memory for the waits of a plan of %u passes", plan->row_count);
}
