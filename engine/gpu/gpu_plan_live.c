/* gpu_plan: what is read was written before; which passes nobody needs; the steps, and from which to which a resource
 * lives. All of it for each mip and layer, in marks that resources with one state for all have one of. */
#include "gpu/gpu_plan_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- states: how many, and which record says how they begin ------------------------------------------------------ */

static bool same_thing(const gpu_record *record, const gpu_resource *resource)
{
	const stilb_gpu_extent *a = &record->extent, *b = &resource->extent;
	return record->name_hash == resource->name_hash && record->owned == resource->image.owned &&
	       record->bytes == resource->bytes && a->format == b->format && a->shape == b->shape && a->width == b->width &&
	       a->height == b->height && a->depth == b->depth && a->layers == b->layers && a->mips == b->mips &&
	       a->samples == b->samples && strcmp(record->name, resource->name) == 0;
}

uint32_t gpu_plan_find_record(const stilb_gpu_plan *plan, const gpu_resource *resource, uint32_t hint)
{
	const gpu_record *records = plan->left.records.items;
	uint32_t count = plan->left.record_count;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t at = hint + i < count ? hint + i : hint + i - count;
		if (same_thing(&records[at], resource))
			return at;
	}
	return GPU_NO_RECORD;
}

bool gpu_sub_equal(const gpu_sub *a, const gpu_sub *b)
{
	return a->readers == b->readers && a->visible == b->visible && a->write == b->write && a->last == b->last &&
	       a->layout == b->layout && a->now == b->now && a->old == b->old && a->zeros == b->zeros;
}

/* The states of a record, the other one's of two included, are those of its first. */
static bool is_uniform(const stilb_gpu_plan *plan, const gpu_record *record)
{
	const gpu_sub *subs = (const gpu_sub *)plan->left.subs.items + record->first_sub;
	uint32_t count = record->keep ? 2 * record->subs : record->subs;
	for (uint32_t i = 0; i < count; i++)
		if (!gpu_sub_equal(&subs[i], &subs[i < record->subs ? 0 : record->subs]))
			return false;
	return true;
}

static stilb_result assign_subs(stilb_gpu_plan *plan)
{
	size_t sum = 0;
	uint32_t hint = 0;
	if (!gpu_array_reserve(&plan->placed, plan->resource_count + 1, sizeof(stilb_gpu_placed)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u resources", plan->resource_count);
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		gpu_resource *resource = gpu_plan_resource(plan, i);
		resource->record = GPU_NO_RECORD;
		if (gpu_resource_counts(resource) && plan->left.record_count > 0) {
			resource->record = gpu_plan_find_record(plan, resource, hint);
			if (resource->record != GPU_NO_RECORD)
				hint = resource->record + 1 < plan->left.record_count ? resource->record + 1 : 0;
		}
		bool one = resource->whole;
		if (one && resource->record != GPU_NO_RECORD)
			one = is_uniform(plan, (const gpu_record *)plan->left.records.items + resource->record);
		resource->first_sub = (uint32_t)sum;
		resource->subs = one ? 1 : (uint32_t)resource->extent.layers * resource->extent.mips;
		sum += resource->image.keep ? 2 * (size_t)resource->subs : resource->subs;
		resource->first_write = resource->last_previous = UINT32_MAX;
		resource->written = false;
		*gpu_plan_placed(plan, i) = (stilb_gpu_placed){.extent = resource->extent,
		                                               .bytes = resource->bytes,
		                                               .owned = resource->image.owned,
		                                               .first_step = UINT32_MAX};
	}
	if (sum >= UINT32_MAX || !gpu_array_reserve(&plan->marks, sum, sizeof(gpu_mark)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan whose images have %zu mips and layers", sum);
	plan->sub_count = (uint32_t)sum;
	memset(plan->marks.items, 0, sum * sizeof(gpu_mark));
	return STILB_OK;
}

/* ---- walks over the mips and layers of a touch ------------------------------------------------------------------- */

typedef struct walk {
	const gpu_resource *resource;
	uint32_t mip, layer; /* of the range, from 0 */
	uint32_t mips, layers, first, stride;
} walk;

static walk walk_begin(const gpu_resource *resource, const gpu_touch *touch)
{
	uint32_t half = touch->previous ? resource->subs : 0;
	walk w = {.resource = resource, .mips = 1, .layers = 1, .first = resource->first_sub + half};
	if (resource->subs > 1) {
		w.mips = touch->range.mips;
		w.layers = touch->range.layers;
		w.stride = resource->extent.mips;
		w.first += touch->range.layer * w.stride + touch->range.mip;
	}
	return w;
}

/* Sets *index to the next mark; false: there is none. */
static inline bool walk_next(walk *w, uint32_t *index)
{
	if (w->layer == w->layers)
		return false;
	*index = w->first + w->layer * w->stride + w->mip;
	w->mip++;
	if (w->mip == w->mips) {
		w->mip = 0;
		w->layer++;
	}
	return true;
}

/* ---- messages ---------------------------------------------------------------------------------------------------- */

/* "'color'", or "mip 1, layer 0 of 'color'". */
static const char *part_text(const gpu_resource *resource, uint32_t index, char *text, size_t size)
{
	uint32_t sub = (index - resource->first_sub) % resource->subs;
	if (resource->subs == 1)
		snprintf(text, size, "'%s'", resource->name);
	else
		snprintf(text, size, "mip %u, layer %u of '%s'", sub % resource->extent.mips, sub / resource->extent.mips,
		         resource->name);
	return text;
}

/* The first row from `row` on that writes a part; row_count: none. */
static uint32_t find_writer(const stilb_gpu_plan *plan, uint32_t row, const gpu_resource *resource, uint32_t index)
{
	for (; row < plan->row_count; row++) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		for (uint32_t i = 0; i < count; i++) {
			if (!touches[i].writes || gpu_plan_resource(plan, touches[i].resource) != resource)
				continue;
			walk w = walk_begin(resource, &touches[i]);
			for (uint32_t at; walk_next(&w, &at);)
				if (at == index)
					return row;
		}
	}
	return plan->row_count;
}

static stilb_result fail_unwritten(const stilb_gpu_plan *plan, uint32_t row, const gpu_touch *touch, uint32_t index)
{
	const gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	const stilb_gpu_pass *pass = gpu_plan_row(plan, row);
	const char *verb = gpu_touch_verb(pass, touch);
	char part[STILB_GPU_MAX_NAME + 64];
	part_text(resource, index, part, sizeof part);
	uint32_t writer = find_writer(plan, row, resource, index);
	if (writer == row) /* reads and writes it, as nobody before has */
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "pass %u '%s' %s %s, which no earlier pass writes: clear or discard it first, or own it",
		                  row + 1, pass->name, verb, part);
	if (writer < plan->row_count)
		return stilb_fail(
			STILB_ERROR_ARGUMENT,
			"pass %u '%s' %s %s, which only a later row writes, pass %u '%s': change their order, or keep "
			"it and read last frame's (previous)",
			row + 1, pass->name, verb, part, writer + 1, gpu_plan_row(plan, writer)->name);
	return stilb_fail(STILB_ERROR_ARGUMENT, "pass %u '%s' %s %s, which no pass writes: add one before it, or own it%s",
	                  row + 1, pass->name, verb, part, resource->image.keep ? ", or read last frame's (previous)" : "");
}

static stilb_result fail_twice(const stilb_gpu_plan *plan, uint32_t row, const gpu_touch *touch, uint32_t index)
{
	const gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	const stilb_gpu_pass *pass = gpu_plan_row(plan, row);
	char part[STILB_GPU_MAX_NAME + 64];
	part_text(resource, index, part, sizeof part);
	uint32_t count;
	const gpu_touch *other = gpu_plan_touches(plan, row, &count);
	while (other->resource != touch->resource || other->previous != touch->previous)
		other++;
	if (!touch->writes && !((const gpu_mark *)plan->marks.items)[index].wrote)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "pass %u '%s' %s and %s %s, sampled and as a storage image: read it in one of both ways",
		                  row + 1, pass->name, gpu_touch_verb(pass, other), gpu_touch_verb(pass, touch), part);
	return stilb_fail(
		STILB_ERROR_ARGUMENT,
		"pass %u '%s' %s and %s %s: what a pass writes it can use in no other way, take two images or two passes",
		row + 1, pass->name, gpu_touch_verb(pass, other), gpu_touch_verb(pass, touch), part);
}

/* ---- reading what was written ------------------------------------------------------------------------------------ */

static stilb_result check_touch(stilb_gpu_plan *plan, uint32_t row, const gpu_touch *touch)
{
	const gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	bool must_be = touch->reads && resource->image.owned == 0;
	gpu_mark *marks = plan->marks.items;
	walk w = walk_begin(resource, touch);
	for (uint32_t at; walk_next(&w, &at);) {
		gpu_mark *mark = &marks[at];
		if (mark->pass == row + 1 && (mark->wrote || touch->writes || mark->layout != touch->layout))
			return fail_twice(plan, row, touch, at);
		if (must_be && !mark->written)
			return fail_unwritten(plan, row, touch, at);
		mark->pass = row + 1;
		mark->layout = touch->layout;
		mark->wrote = touch->writes;
	}
	return STILB_OK;
}

static void mark_written(stilb_gpu_plan *plan, const gpu_touch *touch)
{
	gpu_mark *marks = plan->marks.items;
	gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	resource->written = true;
	walk w = walk_begin(resource, touch);
	for (uint32_t at; walk_next(&w, &at);)
		marks[at].written = true;
}

/* Also marks what somebody reads after the frame. */
static stilb_result check_order(stilb_gpu_plan *plan)
{
	gpu_mark *marks = plan->marks.items;
	for (uint32_t row = 0; row < plan->row_count; row++) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		for (uint32_t i = 0; i < count; i++) {
			stilb_result result = check_touch(plan, row, &touches[i]);
			if (result != STILB_OK)
				return result;
		}
		for (uint32_t i = 0; i < count; i++)
			if (touches[i].writes)
				mark_written(plan, &touches[i]);
	}
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		gpu_resource *resource = gpu_plan_resource(plan, i);
		if ((resource->image.output || resource->shown) && resource->image.owned == 0 && !resource->written)
			return stilb_fail(STILB_ERROR_ARGUMENT, "%s '%s' is %s, and no pass writes it: add one, or leave it out",
			                  gpu_resource_word(resource), resource->name,
			                  resource->image.output ? "an output" : "shown");
		resource->written = false;
		for (uint32_t s = 0; gpu_resource_counts(resource) && s < resource->subs; s++)
			marks[resource->first_sub + s].needed = true;
	}
	return STILB_OK;
}

/* ---- passes that count ------------------------------------------------------------------------------------------- */

/* Goes back through the rows with the parts that somebody reads later. */
static stilb_result find_needed(stilb_gpu_plan *plan)
{
	if (!gpu_array_reserve(&plan->live, plan->row_count, sizeof(bool)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u passes", plan->row_count);
	bool *live = plan->live.items;
	gpu_mark *marks = plan->marks.items;
	for (uint32_t row = plan->row_count; row-- > 0;) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		live[row] = false;
		for (uint32_t i = 0; i < count; i++) {
			walk w = walk_begin(gpu_plan_resource(plan, touches[i].resource), &touches[i]);
			for (uint32_t at; touches[i].writes && walk_next(&w, &at);)
				live[row] = live[row] || marks[at].needed;
		}
		for (uint32_t i = 0; live[row] && i < count; i++) {
			if (touches[i].previous || (!touches[i].reads && !touches[i].replaces))
				continue;
			walk w = walk_begin(gpu_plan_resource(plan, touches[i].resource), &touches[i]);
			for (uint32_t at; walk_next(&w, &at);)
				marks[at].needed = touches[i].reads;
		}
	}
	return STILB_OK;
}

/* ---- steps ------------------------------------------------------------------------------------------------------- */

static void step_touch(stilb_gpu_plan *plan, uint32_t step, const stilb_gpu_pass *pass, const gpu_touch *touch)
{
	gpu_resource *resource = gpu_plan_resource(plan, touch->resource);
	stilb_gpu_placed *placed = gpu_plan_placed(plan, touch->resource);
	if (placed->first_step == UINT32_MAX)
		placed->first_step = step;
	placed->last_step = step;
	placed->extent.uses |= touch->role >= GPU_ROLE_USE ? (uint16_t)(1u << pass->uses[touch->role - GPU_ROLE_USE].how)
	                                                   : (uint16_t)STILB_GPU_EXTENT_ATTACHMENT;
	if (touch->previous)
		resource->last_previous = step;
	if (touch->writes) {
		resource->written = true;
		if (resource->first_write == UINT32_MAX)
			resource->first_write = step;
	}
}

/* Size and samples of what a pass draws into. */
static void step_area(const stilb_gpu_plan *plan, const stilb_gpu_pass *pass, stilb_gpu_step *step)
{
	const stilb_gpu_attachment *attachment = pass->color_count > 0 ? &pass->color[0] : &pass->depth;
	if (attachment->image == 0)
		return;
	const stilb_gpu_extent *extent = &gpu_plan_resource(plan, attachment->image)->extent;
	step->area[0] = gpu_mip_side(extent->width, attachment->mip);
	step->area[1] = gpu_mip_side(extent->height, attachment->mip);
	step->samples = extent->samples;
}

static stilb_result find_steps(stilb_gpu_plan *plan)
{
	if (!gpu_array_reserve(&plan->steps, plan->row_count, sizeof(stilb_gpu_step)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u passes", plan->row_count);
	stilb_gpu_step *steps = plan->steps.items;
	const bool *live = plan->live.items;
	plan->step_count = 0;
	for (uint32_t row = 0; row < plan->row_count; row++) {
		if (!live[row])
			continue;
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		const stilb_gpu_pass *pass = gpu_plan_row(plan, row);
		for (uint32_t i = 0; i < count; i++)
			step_touch(plan, plan->step_count, pass, &touches[i]);
		steps[plan->step_count] = (stilb_gpu_step){.pass = row};
		step_area(plan, pass, &steps[plan->step_count]);
		plan->step_count++;
	}
	return STILB_OK;
}

/* What stays, and which of it are two. */
static void find_staying(stilb_gpu_plan *plan)
{
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		const gpu_resource *resource = gpu_plan_resource(plan, i);
		stilb_gpu_placed *placed = gpu_plan_placed(plan, i);
		bool untouched = placed->first_step == UINT32_MAX;
		placed->two = resource->last_previous != UINT32_MAX && resource->first_write <= resource->last_previous;
		if ((resource->image.output || resource->shown) && !resource->buffer)
			placed->extent.uses |= 1u << STILB_GPU_USE_COPY_FROM;
		if (untouched || !gpu_resource_stays(resource))
			continue;
		if (resource->record != GPU_NO_RECORD)
			placed->stay = ((const gpu_record *)plan->left.records.items)[resource->record].stay;
		else
			placed->stay = ++plan->next_stay;
	}
}

stilb_result gpu_plan_find_live(stilb_gpu_plan *plan)
{
	stilb_result result = assign_subs(plan);
	result = result == STILB_OK ? check_order(plan) : result;
	result = result == STILB_OK ? find_needed(plan) : result;
	result = result == STILB_OK ? find_steps(plan) : result;
	if (result == STILB_OK)
		find_staying(plan);
	return result;
}
