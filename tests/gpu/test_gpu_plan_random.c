/*
 * Random plans against a device of the simplest kind: it knows, for each mip and layer and each way of access, after
 * which other ways what was done counts as done, and which content lies there. The plan's barriers alone change that.
 * So a barrier that is missing, or of a wrong range, or too late, shows as an access that is not ordered after an
 * earlier one, in a wrong layout, or to lost content. One that is not needed shows when nothing is wrong without it.
 *
 * Nothing here is shared with the planner but its headers: what a pass touches is found out from its row
 * (gpu_random.c), which passes count is found by going forward with the sets of passes that went into each content, and
 * content is compared with what the rows mean when they run one after the other.
 */
#include "gpu_random.h"
#include "gpu_script.h"

#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FRAMES 4u
#define INSTANCES (RANDOM_RESOURCES * (FRAMES + 1))
#define TRANSITION STILB_GPU_ACCESSES /* an event besides the accesses: a barrier that changes the layout */
#define UNKNOWN 0xffu                 /* layout of an owned image */
#define GARBAGE UINT64_MAX

/* A mip and layer, or a buffer, in memory. */
typedef struct part {
	uint32_t after[STILB_GPU_ACCESSES + 1]; /* accesses that come after all that was done in this way */
	uint32_t done;                          /* ways in which it was accessed, ever */
	uint64_t content;
	uint8_t layout;
} part;

/* A resource's memory. Transient ones have a new one each frame, which may overlap others of the same heap. */
typedef struct instance {
	bool shared;
	uint64_t stay, owned; /* whose it is, if it stays */
	uint64_t begin, end;
	part parts[RANDOM_SUBS];
} instance;

typedef struct device {
	instance instances[INSTANCES];
	uint32_t count;
} device;

/* A frame that is run. */
typedef struct frame {
	const random_table *table;
	const stilb_gpu_plan *plan;
	device *device;
	uint32_t cut[2]; /* passes cut[0] .. cut[1] - 1 do not run; both 0: all do */
	uint32_t current[RANDOM_RESOURCES + 1], other[RANDOM_RESOURCES + 1]; /* instances; other: last frame's of two */
	uint64_t number;
	/* what contents should be, as if nothing overlapped; 0: not written in this frame, or zeros */
	uint64_t wanted[RANDOM_RESOURCES + 1][RANDOM_SUBS], wanted_previous[RANDOM_RESOURCES + 1][RANDOM_SUBS];
	char *wrong; /* the first thing that is; 200 bytes */
} frame;

static uint32_t sub_of(const random_table *table, uint32_t resource, uint32_t mip, uint32_t layer)
{
	return layer * table->mips[resource] + mip;
}

__attribute__((format(printf, 2, 3))) static void wrong(frame *f, const char *format, ...)
{
	if (f->wrong[0] != '\0')
		return;
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(f->wrong, 200, format, arguments);
	va_end(arguments);
}

/* ---- the device -------------------------------------------------------------------------------------------------- */

static bool is_write(uint32_t event)
{
	return event == TRANSITION || stilb_gpu_access_writes((stilb_gpu_access)event);
}

/* Execution dependencies chain: what was ordered before one of `from` is ordered before all of `to`. */
static void order(part *p, uint32_t from, uint32_t to)
{
	for (uint32_t e = 0; e <= STILB_GPU_ACCESSES; e++)
		if ((p->done & 1u << e) && ((from & 1u << e) || (p->after[e] & from)))
			p->after[e] |= to;
}

/* All that was done before is ordered before an access, or, for reads, all writes are. */
static bool is_ordered(const part *p, uint32_t access)
{
	for (uint32_t e = 0; e <= STILB_GPU_ACCESSES; e++)
		if ((p->done & 1u << e) && (is_write(e) || is_write(access)) && !(p->after[e] & 1u << access))
			return false;
	return true;
}

static bool overlaps(const instance *a, const instance *b)
{
	return a != b && a->shared && b->shared && a->begin < b->end && b->begin < a->end;
}

static void event(part *p, uint32_t access)
{
	p->done |= 1u << access;
	p->after[access] = 0;
}

static void barrier_part(frame *f, instance *in, uint32_t sub, const stilb_gpu_barrier *b, uint8_t layout, bool buffer)
{
	part *p = &in->parts[sub];
	const char *name = stilb_gpu_plan_name(f->plan, b->resource);
	uint8_t from = (uint8_t)stilb_gpu_access_layout((stilb_gpu_access)b->from, random_kind(f->table, b->resource));
	if (!buffer && !b->discard && p->layout != UNKNOWN && from != p->layout)
		wrong(f, "a barrier of %s comes from layout %u, which is %u", name, from, p->layout);
	if (!buffer && !b->discard && p->layout == UNKNOWN && b->from != STILB_GPU_ACCESS_NONE)
		wrong(f, "a barrier of %s comes from layout %u, which nobody knows", name, from);
	bool change = b->zero || (!buffer && (b->discard || p->layout != layout));
	for (uint32_t e = 0; change && e <= STILB_GPU_ACCESSES; e++)
		if ((p->done & 1u << e) && !(b->from_all & 1u << e) && !(p->after[e] & b->from_all))
			wrong(f, "the layout of %s changes before %u is done", name, e);
	order(p, b->from_all, b->to_all);
	for (uint32_t i = 0; i < f->device->count; i++) {
		instance *before = &f->device->instances[i];
		for (uint32_t s = 0; overlaps(in, before) && s < RANDOM_SUBS; s++) {
			for (uint32_t e = 0; change && e <= STILB_GPU_ACCESSES; e++)
				if ((before->parts[s].done & 1u << e) && !(b->from_all & 1u << e) &&
				    !(before->parts[s].after[e] & b->from_all))
					wrong(f, "%s is made ready before others have done with its memory", name);
			order(&before->parts[s], b->from_all, b->to_all);
		}
	}
	if (b->discard)
		p->content = GARBAGE;
	if (b->zero)
		p->content = 0;
	if (change) {
		event(p, TRANSITION);
		p->after[TRANSITION] = b->to_all;
	}
	p->layout = buffer ? 0 : layout;
}

static void run_barrier(frame *f, const stilb_gpu_barrier *b)
{
	const random_table *table = f->table;
	instance *in = &f->device->instances[b->previous ? f->other[b->resource] : f->current[b->resource]];
	uint8_t layout = (uint8_t)stilb_gpu_access_layout((stilb_gpu_access)b->to, random_kind(table, b->resource));
	for (uint32_t layer = b->layer; layer < (uint32_t)b->layer + b->layers; layer++)
		for (uint32_t mip = b->mip; mip < (uint32_t)b->mip + b->mips; mip++)
			barrier_part(f, in, sub_of(table, b->resource, mip, layer), b, layout, table->buffer[b->resource]);
	if (!(b->to_all & 1u << b->to) || (b->from != 0 && !(b->from_all & 1u << b->from)))
		wrong(f, "a barrier of %s does not name its own accesses", stilb_gpu_plan_name(f->plan, b->resource));
}

static instance *instance_of(frame *f, const random_access *a)
{
	bool two = stilb_gpu_plan_place(f->plan, (uint16_t)a->resource)->two;
	return &f->device->instances[a->previous && two ? f->other[a->resource] : f->current[a->resource]];
}

/* An access finds what it needs. */
static void check_access(frame *f, const random_access *a)
{
	const random_table *table = f->table;
	instance *in = instance_of(f, a);
	uint32_t sub = sub_of(table, a->resource, a->mip, a->layer);
	part *p = &in->parts[sub];
	const char *name = stilb_gpu_plan_name(f->plan, (uint16_t)a->resource), *how = stilb_gpu_access_name(a->access);
	uint8_t layout = (uint8_t)stilb_gpu_access_layout(a->access, random_kind(table, a->resource));
	if (!is_ordered(p, a->access))
		wrong(f, "%s of %s, mip %u, layer %u, is not ordered after what was before", how, name, a->mip, a->layer);
	if (!table->buffer[a->resource] && p->layout != layout)
		wrong(f, "%s of %s, mip %u, layer %u, finds layout %u", how, name, a->mip, a->layer, p->layout);
	for (uint32_t i = 0; i < f->device->count; i++)
		for (uint32_t s = 0; overlaps(in, &f->device->instances[i]) && s < RANDOM_SUBS; s++)
			for (uint32_t e = 0; e <= STILB_GPU_ACCESSES; e++)
				if ((f->device->instances[i].parts[s].done & 1u << e) &&
				    !(f->device->instances[i].parts[s].after[e] & 1u << a->access))
					wrong(f, "%s of %s begins before others have done with its memory", how, name);
	uint64_t content = a->previous ? f->wanted_previous[a->resource][sub] : f->wanted[a->resource][sub];
	bool adds = is_write(a->access) && !a->replaces && !a->reads && content != 0;
	if ((a->reads || adds) && p->content != content)
		wrong(f, "%s of %s, mip %u, layer %u, finds content %llx, not %llx", how, name, a->mip, a->layer,
		      (unsigned long long)p->content, (unsigned long long)content);
}

static void do_access(frame *f, const random_access *a, uint64_t content)
{
	instance *in = instance_of(f, a);
	uint32_t sub = sub_of(f->table, a->resource, a->mip, a->layer);
	event(&in->parts[sub], a->access);
	if (!is_write(a->access))
		return;
	in->parts[sub].content = f->wanted[a->resource][sub] = content;
	for (uint32_t i = 0; i < f->device->count; i++)
		for (uint32_t s = 0; overlaps(in, &f->device->instances[i]) && s < RANDOM_SUBS; s++)
			f->device->instances[i].parts[s].content = GARBAGE;
}

/* Runs all steps and what comes after; barrier number `without` is left out. */
static void run_frame(frame *f, uint32_t without)
{
	const random_table *table = f->table;
	const stilb_gpu_step *steps;
	const stilb_gpu_barrier *barriers;
	random_access accesses[RANDOM_ACCESSES];
	uint32_t count = stilb_gpu_plan_steps(f->plan, &steps), sum = stilb_gpu_plan_barriers(f->plan, &barriers), first;
	for (uint32_t s = 0; s < count; s++) {
		for (uint32_t b = 0; b < steps[s].barrier_count; b++)
			if (steps[s].first_barrier + b != without)
				run_barrier(f, &barriers[steps[s].first_barrier + b]);
		uint32_t accessed = random_accesses(table, &table->passes[steps[s].pass], accesses);
		for (uint32_t i = 0; i < accessed; i++)
			check_access(f, &accesses[i]);
		for (uint32_t i = 0; i < accessed; i++)
			do_access(f, &accesses[i], f->number << 8 | (s + 1));
		if (f->wrong[0] != '\0')
			return;
	}
	stilb_gpu_plan_last_barriers(f->plan, &first);
	for (uint32_t b = first; b < sum; b++)
		if (b != without)
			run_barrier(f, &barriers[b]);
	for (uint32_t r = 1; r <= table->resource_count; r++)
		for (uint32_t s = 0; random_outputs(table, r) && s < table->mips[r] * table->layers[r]; s++) {
			random_access a = {.resource = r,
			                   .mip = s % table->mips[r],
			                   .layer = s / table->mips[r],
			                   .access = STILB_GPU_ACCESS_OUTPUT,
			                   .reads = true};
			bool content = f->wanted[r][s] != 0;
			if (content != stilb_gpu_plan_ready(f->plan, (uint16_t)r, (uint8_t)a.mip, (uint16_t)a.layer))
				wrong(f, "%s is %s to be read", stilb_gpu_plan_name(f->plan, (uint16_t)r),
				      content ? "not ready" : "ready");
			if (content)
				check_access(f, &a);
			if (content)
				do_access(f, &a, 0);
		}
}

/* ---- what the plan must be like besides -------------------------------------------------------------------------- */

/* Of the passes whose bits are in `rows`: those that went into what somebody keeps, owns or reads after the frame, and
 * into pass `last` (UINT32_MAX: none), itself included. */
static uint64_t passes_that_count(const random_table *table, uint64_t rows, uint32_t last)
{
	uint64_t all = 0;
	static uint64_t made_by[RANDOM_RESOURCES + 1][RANDOM_SUBS];
	memset(made_by, 0, sizeof made_by);
	random_access accesses[RANDOM_ACCESSES];
	for (uint32_t i = 0; i < table->pass_count; i++) {
		if (!(rows & 1ull << i))
			continue;
		uint32_t count = random_accesses(table, &table->passes[i], accesses);
		uint64_t read = 1ull << i;
		for (uint32_t k = 0; k < count; k++)
			if (accesses[k].reads && !accesses[k].previous)
				read |= made_by[accesses[k].resource]
							   [sub_of(table, accesses[k].resource, accesses[k].mip, accesses[k].layer)];
		all |= i == last ? read : 0;
		for (uint32_t k = 0; k < count; k++) {
			uint64_t *by =
				&made_by[accesses[k].resource][sub_of(table, accesses[k].resource, accesses[k].mip, accesses[k].layer)];
			if (is_write(accesses[k].access))
				*by = accesses[k].replaces ? read : *by | read;
		}
	}
	for (uint32_t r = 1; r <= table->resource_count; r++)
		for (uint32_t s = 0; s < RANDOM_SUBS; s++)
			if (random_keeps(table, r) || random_outputs(table, r) || random_owned(table, r) != 0)
				all |= made_by[r][s];
	return all;
}

static void check_steps(const frame *f)
{
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(f->plan, &steps);
	uint64_t all = 0;
	for (uint32_t s = 0; s < count; s++) {
		assert_true(s == 0 || steps[s].pass > steps[s - 1].pass);
		all |= 1ull << steps[s].pass;
	}
	uint64_t before = (1ull << f->cut[0]) - 1, not_behind = (1ull << f->cut[1]) - 1;
	uint64_t wanted = passes_that_count(f->table, ~(not_behind & ~before), f->cut[0] - 1);
	if (f->cut[0] > 0) /* and what runs before the cut if nothing is cut or added */
		wanted |= passes_that_count(f->table, not_behind, UINT32_MAX) & before;
	assert_int_equal(all, wanted);
}

/* Lifetimes are those of the steps, and what lives at the same time shares no memory. */
static void check_places(const frame *f)
{
	const random_table *table = f->table;
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(f->plan, &steps);
	uint32_t first[RANDOM_RESOURCES + 1], last[RANDOM_RESOURCES + 1];
	memset(first, 0xff, sizeof first);
	memset(last, 0, sizeof last);
	random_access accesses[RANDOM_ACCESSES];
	for (uint32_t s = 0; s < count; s++) {
		uint32_t accessed = random_accesses(table, &table->passes[steps[s].pass], accesses);
		for (uint32_t i = 0; i < accessed; i++) {
			uint32_t r = accesses[i].resource;
			first[r] = first[r] == UINT32_MAX ? s : first[r];
			last[r] = s;
		}
	}
	for (uint32_t r = 1; r <= table->resource_count; r++) {
		const stilb_gpu_placed *a = stilb_gpu_plan_place(f->plan, (uint16_t)r);
		assert_int_equal(a->first_step, first[r]);
		assert_int_equal(a->last_step, last[r]);
		bool used = first[r] <= last[r], stays = random_keeps(table, r) || random_outputs(table, r);
		assert_int_equal(a->shared, used && !stays && random_owned(table, r) == 0);
		assert_int_equal(a->stay != 0, used && stays && random_owned(table, r) == 0);
		if (!a->shared)
			continue;
		assert_int_equal(a->offset % 256, 0);
		assert_true(a->offset + a->bytes <= stilb_gpu_plan_heap_bytes(f->plan, 0));
		for (uint32_t q = 1; q < r; q++) {
			const stilb_gpu_placed *b = stilb_gpu_plan_place(f->plan, (uint16_t)q);
			bool together = b->shared && first[q] <= last[r] && first[r] <= last[q];
			if (together && a->offset < b->offset + b->bytes && b->offset < a->offset + a->bytes)
				fail_msg("r%u and r%u are used at the same time, and share memory", q, r);
		}
	}
}

/* No two barriers of a step could be one. */
static void check_ranges(const frame *f)
{
	const stilb_gpu_step *steps;
	const stilb_gpu_barrier *barriers;
	uint32_t count = stilb_gpu_plan_steps(f->plan, &steps);
	stilb_gpu_plan_barriers(f->plan, &barriers);
	for (uint32_t s = 0; s < count; s++)
		for (uint32_t i = 0; i < steps[s].barrier_count; i++)
			for (uint32_t k = 0; k < i; k++) {
				const stilb_gpu_barrier *a = &barriers[steps[s].first_barrier + i],
										*b = &barriers[steps[s].first_barrier + k];
				bool same = a->resource == b->resource && a->from == b->from && a->to == b->to &&
				            a->discard == b->discard && a->zero == b->zero && a->previous == b->previous &&
				            a->memory == b->memory;
				bool beside = (a->layer == b->layer && a->layers == b->layers &&
				               (a->mip + a->mips == b->mip || b->mip + b->mips == a->mip)) ||
				              (a->mip == b->mip && a->mips == b->mips &&
				               (a->layer + a->layers == b->layer || b->layer + b->layers == a->layer));
				if (same && beside)
					fail_msg("two barriers of r%u could be one", a->resource);
			}
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* What a frame has left, by the rules of gpu_plan.h. */
typedef struct history {
	random_table table;
	bool any, used[RANDOM_RESOURCES + 1], written[RANDOM_RESOURCES + 1];
	uint64_t content[RANDOM_RESOURCES + 1][RANDOM_SUBS];
	uint64_t stay[RANDOM_RESOURCES + 1];
	bool two[RANDOM_RESOURCES + 1];
	uint32_t instance[RANDOM_RESOURCES + 1], spare[RANDOM_RESOURCES + 1];
	device device;
} history;

static bool same_resource(const random_table *a, const random_table *b, uint32_t r)
{
	if (r > a->resource_count || r > b->resource_count || a->buffer[r] != b->buffer[r])
		return false;
	if (a->buffer[r])
		return a->buffers[r].bytes == b->buffers[r].bytes && a->buffers[r].owned == b->buffers[r].owned;
	const stilb_gpu_plan_image_row *x = &a->images[r], *y = &b->images[r];
	return x->format == y->format && x->shape == y->shape && x->depth == y->depth && a->layers[r] == b->layers[r] &&
	       a->mips[r] == b->mips[r] && x->samples == y->samples && x->owned == y->owned;
}

static uint32_t new_instance(device *d, bool owned_image)
{
	assert_true(d->count < INSTANCES);
	instance *in = &d->instances[d->count];
	memset(in, 0, sizeof *in);
	for (uint32_t s = 0; s < RANDOM_SUBS; s++) {
		in->parts[s].layout = owned_image ? UNKNOWN : 0;
		in->parts[s].content = GARBAGE;
	}
	return d->count++;
}

static void give_memory(frame *f, const history *before, uint32_t r)
{
	const random_table *table = f->table;
	const stilb_gpu_placed *placed = stilb_gpu_plan_place(f->plan, (uint16_t)r);
	bool same = before->any && before->used[r] && same_resource(&before->table, table, r);
	if (placed->shared) {
		f->current[r] = new_instance(f->device, false);
		instance *in = &f->device->instances[f->current[r]];
		in->shared = true;
		in->begin = placed->offset;
		in->end = placed->offset + placed->bytes;
		return;
	}
	uint64_t owned = random_owned(table, r);
	bool stayed = same && (owned != 0 || (before->stay[r] != 0 && placed->stay != 0));
	if (placed->stay != 0)
		assert_int_equal(placed->stay == before->stay[r], stayed);
	f->current[r] = stayed ? before->instance[r] : new_instance(f->device, owned != 0 && !table->buffer[r]);
	if (owned != 0 && !stayed)
		for (uint32_t s = 0; s < RANDOM_SUBS; s++)
			f->device->instances[f->current[r]].parts[s].content = owned;
	if (!placed->two)
		return;
	f->other[r] = f->current[r];
	f->current[r] = stayed && before->two[r] ? before->spare[r] : new_instance(f->device, false);
}

/* Contents that are there at the frame's start, and stilb_gpu_plan_kept. */
static void want(frame *f, const history *before)
{
	const random_table *table = f->table;
	for (uint32_t r = 1; r <= table->resource_count; r++) {
		bool same = before->any && before->used[r] && same_resource(&before->table, table, r);
		uint64_t owned = random_owned(table, r);
		bool kept = same && random_keeps(table, r) && random_keeps(&before->table, r) && before->written[r];
		assert_int_equal(stilb_gpu_plan_kept(f->plan, (uint16_t)r), kept);
		for (uint32_t s = 0; s < RANDOM_SUBS; s++) {
			f->wanted[r][s] = owned == 0 ? 0 : same ? before->content[r][s] : owned;
			f->wanted_previous[r][s] = kept ? before->content[r][s] : 0;
		}
	}
}

static void remember(const frame *f, history *left)
{
	const random_table *table = f->table;
	left->any = true;
	for (uint32_t r = 1; r <= RANDOM_RESOURCES; r++) {
		bool used_before = left->used[r];
		left->used[r] = left->written[r] = false;
		if (r > table->resource_count)
			continue;
		const stilb_gpu_placed *placed = stilb_gpu_plan_place(f->plan, (uint16_t)r);
		bool owned = random_owned(table, r) != 0;
		bool known = owned && used_before && same_resource(&left->table, table, r);
		left->used[r] = placed->first_step <= placed->last_step || known;
		left->stay[r] = placed->stay;
		left->two[r] = placed->two;
		left->instance[r] = f->current[r];
		left->spare[r] = f->other[r];
		for (uint32_t s = 0; s < RANDOM_SUBS; s++) {
			left->content[r][s] = f->wanted[r][s];
			left->written[r] = left->written[r] || f->wanted[r][s] != 0;
		}
	}
	left->table = *table;
}

typedef struct totals {
	uint64_t plans, barriers, left_out, dropped, removed, previous, zero, memory, two, cut, added;
} totals;

static void count_barriers(const frame *f, totals *sum)
{
	const stilb_gpu_barrier *barriers;
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_barriers(f->plan, &barriers);
	sum->plans++;
	sum->barriers += count;
	sum->left_out += f->table->pass_count - stilb_gpu_plan_steps(f->plan, &steps);
	for (uint32_t i = 0; i < count; i++) {
		sum->previous += barriers[i].previous;
		sum->zero += barriers[i].zero;
		sum->memory += barriers[i].memory;
	}
	for (uint32_t r = 1; r <= f->table->resource_count; r++)
		sum->two += stilb_gpu_plan_place(f->plan, (uint16_t)r)->two;
}

/* Each barrier is needed: without it something is wrong. */
static void check_needed(const frame *f, const device *start, totals *sum)
{
	const stilb_gpu_barrier *barriers;
	uint32_t count = stilb_gpu_plan_barriers(f->plan, &barriers);
	static device scratch;
	static frame again;
	for (uint32_t without = 0; without < count; without++) {
		char text[200] = "";
		/* What orders two resources in memory that a third used before orders that, too: here it may do for both. */
		if (barriers[without].memory && f->table->buffer[barriers[without].resource])
			continue;
		scratch = *start;
		again = *f;
		again.device = &scratch;
		again.wrong = text;
		run_frame(&again, without);
		if (text[0] == '\0')
			fail_msg("barrier %u, of r%u, is not needed\n%s", without, barriers[without].resource,
			         script_barriers(f->plan));
		sum->removed++;
	}
}

/* Adds the rows of a frame that is cut by chance, and makes the plan. Rows that are added behind the cut may need what
 * is cut out: then nothing is added. */
static void make_cut(frame *f, stilb_gpu_plan *plan, uint64_t dice, totals *sum)
{
	random_table first = *f->table;
	uint32_t count = f->table->pass_count, pass = (uint32_t)(dice % count);
	uint32_t end = pass + 1 + (uint32_t)(dice / 64 % (count - pass));
	for (;; end = count) {
		stilb_gpu_plan_begin(plan, 100, 50);
		first.pass_count = end;
		random_add(&first, plan);
		stilb_gpu_plan_cut(plan, pass);
		for (uint32_t i = end; i < count; i++)
			stilb_gpu_plan_pass(plan, &f->table->passes[i]);
		stilb_result result = stilb_gpu_plan_make(plan, NULL);
		bool needs = result != STILB_OK && end < count && strstr(stilb_error_message(), "is cut before it");
		if (result == STILB_OK)
			break;
		if (!needs)
			fail_msg("%s", stilb_error_message());
	}
	f->cut[0] = pass + 1;
	f->cut[1] = end;
	sum->cut++;
	sum->added += end < count;
}

/* One frame. dropped: it does not count. */
static void play(stilb_gpu_plan *plan, const random_table *table, history *before, bool needed, bool dropped,
                 uint64_t number, totals *sum)
{
	static frame f;
	static device start;
	char text[200] = "";
	memset(&f, 0, sizeof f);
	f.table = table;
	f.plan = plan;
	f.number = number;
	f.wrong = text;
	uint64_t dice = stilb_random_u64(78, sum->plans);
	if (dice % 4 == 0 && table->pass_count > 0) {
		make_cut(&f, plan, dice / 4, sum);
	} else {
		stilb_gpu_plan_begin(plan, 100, 50);
		random_add(table, plan);
		if (stilb_gpu_plan_make(plan, NULL) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	check_steps(&f);
	check_places(&f);
	check_ranges(&f);
	history *left = before;
	static history thrown_away;
	if (dropped) {
		thrown_away = *before;
		left = &thrown_away;
	}
	f.device = &left->device;
	want(&f, before);
	for (uint32_t r = 1; r <= table->resource_count; r++)
		give_memory(&f, left, r);
	if (needed) {
		start = left->device;
		check_needed(&f, &start, sum);
	}
	run_frame(&f, UINT32_MAX);
	if (text[0] != '\0')
		fail_msg("frame %llu: %s\n%s", (unsigned long long)number, text, script_barriers(plan));
	count_barriers(&f, sum);
	remember(&f, left);
	if (dropped)
		stilb_gpu_plan_dropped(plan);
	sum->dropped += dropped;
}

static void test_random(void **state)
{
	(void)state;
	uint64_t sequences = TEST_ASAN || TEST_EMULATED ? 4000 : 25000;
	static history before;
	static random_table table;
	totals sum = {0};
	for (uint64_t i = 0; i < sequences; i++) {
		stilb_gpu_plan *plan = stilb_gpu_plan_create();
		assert_non_null(plan);
		memset(&before, 0, sizeof before);
		uint64_t resources = 10 * i, passes = 10 * i;
		for (uint64_t n = 0; n < FRAMES; n++) {
			uint64_t dice = stilb_random_u64(77, i * FRAMES + n);
			if (n > 0 && dice % 8 == 0)
				resources++;
			if (n > 0 && dice % 8 < 3)
				passes++;
			random_make(&table, resources, passes);
			play(plan, &table, &before, i % 16 == 0, dice / 8 % 10 == 0, n + 1, &sum);
		}
		stilb_gpu_plan_destroy(plan);
	}
	print_message(
		"%llu plans, %llu barriers (%llu of memory, %llu of last frame's, %llu with zeros), %llu removed to see; "
		"%llu passes left out, %llu resources twice, %llu frames dropped, %llu cut, %llu of them with passes behind\n",
		(unsigned long long)sum.plans, (unsigned long long)sum.barriers, (unsigned long long)sum.memory,
		(unsigned long long)sum.previous, (unsigned long long)sum.zero, (unsigned long long)sum.removed,
		(unsigned long long)sum.left_out, (unsigned long long)sum.two, (unsigned long long)sum.dropped,
		(unsigned long long)sum.cut, (unsigned long long)sum.added);
	assert_true(sum.cut > sum.plans / 5 && sum.added > sum.plans / 40);
	assert_true(sum.memory > sum.plans / 10 && sum.previous > 0 && sum.zero > 0 && sum.left_out > 0 && sum.two > 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {test_one_thread(test_random)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
