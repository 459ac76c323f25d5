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

/* Which resources have a state for each mip and layer, and which count. */
static stilb_result assign_subs(stilb_gpu_plan *plan)
{
	size_t sum = 0;
	uint32_t hint = 0;
	plan->counted_count = 0;
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		gpu_resource *resource = gpu_plan_resource(plan, i);
		gpu_life *life = gpu_plan_life(plan, i);
		bool one = !life->partial;
		resource->record = GPU_NO_RECORD;
		if (gpu_resource_counts(resource)) {
			((uint16_t *)plan->counted.items)[plan->counted_count++] = (uint16_t)i;
			resource->record = plan->left.record_count > 0 ? gpu_plan_find_record(plan, resource, hint) : GPU_NO_RECORD;
			if (resource->record != GPU_NO_RECORD)
				hint = resource->record + 1 < plan->left.record_count ? resource->record + 1 : 0;
		}
		if (one && resource->record != GPU_NO_RECORD)
			one = is_uniform(plan, (const gpu_record *)plan->left.records.items + resource->record);
		resource->first_sub = life->first_sub = (uint32_t)sum;
		resource->subs = one ? 1 : (uint32_t)resource->extent.layers * resource->extent.mips;
		life->many = resource->subs > 1;
		sum += resource->image.keep ? 2 * (size_t)resource->subs : resource->subs;
		if (sum >= UINT32_MAX)
			break;
	}
	if (sum >= UINT32_MAX || !gpu_array_reserve(&plan->marks, sum, sizeof(gpu_mark)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan whose images have %zu mips and layers", sum);
	plan->sub_count = (uint32_t)sum;
	memset(plan->marks.items, 0, sum * sizeof(gpu_mark));
	return STILB_OK;
}

/* Tells the touches which states are theirs. */
static void find_states(stilb_gpu_plan *plan, gpu_touch *touches, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		gpu_touch *touch = &touches[i];
		const gpu_life *life = gpu_plan_life(plan, touch->resource);
		touch->many = life->many;
		touch->first = life->first_sub;
		if (touch->many)
			touch->first +=
				touch->range.layer * gpu_plan_resource(plan, touch->resource)->extent.mips + touch->range.mip;
	}
}

static stilb_result find_subs(stilb_gpu_plan *plan)
{
	uint32_t count = plan->resource_count;
	if (!gpu_array_reserve(&plan->placed, count + 1, sizeof(stilb_gpu_placed)) ||
	    !gpu_array_reserve(&plan->lives, count + 1, sizeof(gpu_life)) ||
	    !gpu_array_reserve(&plan->counted, count, sizeof(uint16_t)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u resources", count);
	memset(plan->lives.items, 0, (count + 1) * sizeof(gpu_life));
	const gpu_span *spans = plan->spans.items;
	gpu_touch *touches = plan->touches.items;
	for (uint32_t row = 0; row < plan->row_count; row++)
		for (uint32_t i = spans[row].first; i < spans[row].first + spans[row].count; i++)
			if (touches[i].partial)
				gpu_plan_life(plan, touches[i].resource)->partial = true;
	stilb_result result = assign_subs(plan);
	for (uint32_t row = 0; row < plan->row_count && result == STILB_OK; row++)
		find_states(plan, touches + spans[row].first, spans[row].count);
	return result;
}

/* ---- walks over the mips and layers of a touch ------------------------------------------------------------------- */

typedef struct walk {
	uint32_t mip, layer; /* of the range, from 0 */
	uint32_t mips, layers, first, stride;
} walk;

static inline walk walk_begin(const stilb_gpu_plan *plan, const gpu_touch *touch)
{
	walk w = {.mips = 1, .layers = 1, .first = touch->first};
	if (touch->many) {
		w.mips = touch->range.mips;
		w.layers = touch->range.layers;
		w.stride = gpu_plan_resource(plan, touch->resource)->extent.mips;
	}
	if (touch->previous)
		w.first += gpu_plan_resource(plan, touch->resource)->subs;
	return w;
}

/* It has one mark, touch->first. */
static inline bool is_plain(const gpu_touch *touch)
{
	return !touch->many && !touch->previous;
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

/* The first of the rows from `row` to before `end` that writes a part; row_count: none. */
static uint32_t find_writer(const stilb_gpu_plan *plan, uint32_t row, uint32_t end, const gpu_resource *resource,
                            uint32_t index)
{
	for (; row < end; row++) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		for (uint32_t i = 0; i < count; i++) {
			if (!touches[i].writes || gpu_plan_resource(plan, touches[i].resource) != resource)
				continue;
			walk w = walk_begin(plan, &touches[i]);
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
	uint32_t writer = find_writer(plan, row, plan->row_count, resource, index);
	uint32_t behind = find_writer(plan, plan->cut[0], plan->cut[1], resource, index);
	if (row >= plan->cut[1] && behind < plan->row_count)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "pass %u '%s' %s %s, which pass %u '%s' writes, and the frame is cut before it: cut it later",
		                  row + 1, pass->name, verb, part, behind + 1, gpu_plan_row(plan, behind)->name);
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

/* Looks at one mark of a touch, and marks it. */
static inline stilb_result check_mark(const stilb_gpu_plan *plan, uint32_t row, const gpu_touch *touch, uint32_t at)
{
	gpu_mark *mark = (gpu_mark *)plan->marks.items + at;
	if (mark->pass == row + 1 && (mark->wrote || touch->writes || mark->layout != touch->layout))
		return fail_twice(plan, row, touch, at);
	if (touch->reads && !touch->owned && !mark->written)
		return fail_unwritten(plan, row, touch, at);
	mark->pass = row + 1;
	mark->layout = touch->layout;
	mark->wrote = touch->writes;
	return STILB_OK;
}

static stilb_result check_touch(const stilb_gpu_plan *plan, uint32_t row, const gpu_touch *touch)
{
	if (is_plain(touch))
		return check_mark(plan, row, touch, touch->first);
	walk w = walk_begin(plan, touch);
	stilb_result result = STILB_OK;
	for (uint32_t at; result == STILB_OK && walk_next(&w, &at);)
		result = check_mark(plan, row, touch, at);
	return result;
}

static void mark_written(const stilb_gpu_plan *plan, const gpu_touch *touch)
{
	gpu_mark *marks = plan->marks.items;
	gpu_plan_life(plan, touch->resource)->written = true;
	marks[touch->first].written = true;
	if (is_plain(touch))
		return;
	walk w = walk_begin(plan, touch);
	for (uint32_t at; walk_next(&w, &at);)
		marks[at].written = true;
}

/* Marks what somebody reads after the frame. */
static void mark_counted(const stilb_gpu_plan *plan)
{
	gpu_mark *marks = plan->marks.items;
	for (uint32_t c = 0; c < plan->counted_count; c++) {
		const gpu_resource *resource = gpu_plan_resource(plan, ((const uint16_t *)plan->counted.items)[c]);
		for (uint32_t s = 0; s < resource->subs; s++)
			marks[resource->first_sub + s].needed = true;
	}
}

/* A row behind the cut writes the resource. */
static bool cut_writes(const stilb_gpu_plan *plan, const gpu_resource *resource)
{
	for (uint32_t s = 0; s < resource->subs; s++)
		if (find_writer(plan, plan->cut[0], plan->cut[1], resource, resource->first_sub + s) < plan->row_count)
			return true;
	return false;
}

static stilb_result check_order(stilb_gpu_plan *plan)
{
	for (uint32_t row = 0; row < plan->row_count; row++) {
		if (gpu_plan_cuts(plan, row))
			continue;
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
	for (uint32_t c = 0; c < plan->counted_count; c++) {
		uint32_t number = ((const uint16_t *)plan->counted.items)[c];
		const gpu_resource *resource = gpu_plan_resource(plan, number);
		gpu_life *life = gpu_plan_life(plan, number);
		if ((resource->image.output || resource->shown) && resource->image.owned == 0 && !life->written &&
		    !cut_writes(plan, resource))
			return stilb_fail(STILB_ERROR_ARGUMENT, "%s '%s' is %s, and no pass writes it: add one, or leave it out",
			                  gpu_resource_word(resource), resource->name,
			                  resource->image.output ? "an output" : "shown");
		life->written = false;
	}
	return STILB_OK;
}

/* ---- passes that count ------------------------------------------------------------------------------------------- */

/* Somebody reads later what a touch writes. */
static bool touch_needed(const stilb_gpu_plan *plan, const gpu_touch *touch)
{
	const gpu_mark *marks = plan->marks.items;
	bool needed = marks[touch->first].needed;
	if (is_plain(touch))
		return needed;
	walk w = walk_begin(plan, touch);
	for (uint32_t at; !needed && walk_next(&w, &at);)
		needed = marks[at].needed;
	return needed;
}

/* What a pass that runs reads is needed before it; what it replaces is not. */
static void touch_needs(const stilb_gpu_plan *plan, const gpu_touch *touch)
{
	gpu_mark *marks = plan->marks.items;
	if (is_plain(touch)) {
		marks[touch->first].needed = touch->reads;
		return;
	}
	walk w = walk_begin(plan, touch);
	for (uint32_t at; walk_next(&w, &at);)
		marks[at].needed = touch->reads;
}

/* Goes back through the rows from before `end` to `first` with the parts that somebody reads later. */
static void walk_back(stilb_gpu_plan *plan, uint32_t first, uint32_t end)
{
	bool *live = plan->live.items;
	for (uint32_t row = end; row-- > first;) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		live[row] = row + 1 == plan->cut[0];
		for (uint32_t i = 0; i < count && !live[row]; i++)
			live[row] = touches[i].writes && touch_needed(plan, &touches[i]);
		for (uint32_t i = 0; live[row] && i < count; i++)
			if (!touches[i].previous && (touches[i].reads || touches[i].replaces))
				touch_needs(plan, &touches[i]);
	}
}

/* Rows that are cut out do not run, but what they need of the rows before them counts as read, as if nothing had been
 * added behind them: so the rows before them are those that run without the cut, and what the rows behind need. */
static void walk_back_cut(stilb_gpu_plan *plan)
{
	gpu_mark *marks = plan->marks.items;
	for (uint32_t s = 0; s < plan->sub_count; s++) {
		marks[s].later = marks[s].needed;
		marks[s].needed = false;
	}
	mark_counted(plan);
	walk_back(plan, plan->cut[0], plan->cut[1]);
	memset((bool *)plan->live.items + plan->cut[0], 0, plan->cut[1] - plan->cut[0]);
	for (uint32_t s = 0; s < plan->sub_count; s++)
		marks[s].needed |= marks[s].later;
}

static stilb_result find_needed(stilb_gpu_plan *plan)
{
	if (!gpu_array_reserve(&plan->live, plan->row_count, sizeof(bool)))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u passes", plan->row_count);
	mark_counted(plan);
	walk_back(plan, plan->cut[1], plan->row_count);
	if (plan->cut[0] == 0)
		return STILB_OK;
	walk_back_cut(plan);
	walk_back(plan, 0, plan->cut[0]);
	return STILB_OK;
}

/* ---- steps ------------------------------------------------------------------------------------------------------- */

static void step_touch(const stilb_gpu_plan *plan, uint32_t step, const gpu_touch *touch)
{
	gpu_life *life = gpu_plan_life(plan, touch->resource);
	life->first = life->first > 0 ? life->first : step + 1;
	life->last = step + 1;
	life->uses |= touch->use;
	if (touch->previous)
		life->last_previous = step + 1;
	if (touch->writes) {
		life->written = true;
		life->first_write = life->first_write > 0 ? life->first_write : step + 1;
	}
}

/* Size and samples of what a pass draws into. */
static void step_area(const stilb_gpu_plan *plan, const stilb_gpu_pass *pass, stilb_gpu_step *step)
{
	uint32_t first = 0;
	while (first < pass->color_count && gpu_attachment_is_none(&pass->color[first]))
		first++;
	const stilb_gpu_attachment *attachment = first < pass->color_count ? &pass->color[first] : &pass->depth;
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
	plan->queued = false;
	for (uint32_t row = 0; row < plan->row_count; row++) {
		if (!live[row])
			continue;
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
		for (uint32_t i = 0; i < count; i++)
			step_touch(plan, plan->step_count, &touches[i]);
		steps[plan->step_count] = (stilb_gpu_step){.pass = row};
		step_area(plan, gpu_plan_row(plan, row), &steps[plan->step_count]);
		plan->queued = plan->queued || gpu_plan_row(plan, row)->queue != STILB_GPU_QUEUE_MAIN;
		plan->step_count++;
	}
	return STILB_OK;
}

/* Lifetimes; what stays, and which of it are two. */
static void find_places(stilb_gpu_plan *plan)
{
	for (uint32_t i = 1; i <= plan->resource_count; i++) {
		const gpu_resource *resource = gpu_plan_resource(plan, i);
		const gpu_life *life = gpu_plan_life(plan, i);
		stilb_gpu_placed *placed = gpu_plan_placed(plan, i);
		*placed = (stilb_gpu_placed){.extent = resource->extent,
		                             .bytes = resource->bytes,
		                             .owned = resource->image.owned,
		                             .queues = life->first > 0 ? 1u << STILB_GPU_QUEUE_MAIN : 0,
		                             .first_step = life->first - 1, /* UINT32_MAX: none */
		                             .last_step = life->first > 0 ? life->last - 1 : 0};
		placed->extent.uses = life->uses;
		if ((resource->image.output || resource->shown) && !resource->buffer)
			placed->extent.uses |= 1u << STILB_GPU_USE_COPY_FROM;
		/* Written, if at all, before the last of the reads of last frame's, or by the same step. */
		placed->two = life->last_previous > 0 && life->first_write > 0 && life->first_write <= life->last_previous;
		if (life->first == 0 || !gpu_resource_stays(resource))
			continue;
		if (resource->record != GPU_NO_RECORD)
			placed->stay = ((const gpu_record *)plan->left.records.items)[resource->record].stay;
		else
			placed->stay = ++plan->next_stay;
	}
}

stilb_result gpu_plan_find_live(stilb_gpu_plan *plan)
{
	stilb_result result = find_subs(plan);
	result = result == STILB_OK ? check_order(plan) : result;
	result = result == STILB_OK ? find_needed(plan) : result;
	result = result == STILB_OK ? find_steps(plan) : result;
	if (result == STILB_OK)
		find_places(plan);
	return result;
}
