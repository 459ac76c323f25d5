/* gpu_plan: a plan as lines of text. */
#include "gpu/gpu_plan_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const kinds[STILB_GPU_PASS_KINDS] = {"draws", "fullscreen", "dispatch", "copy", "host"};

/* "3 passes", "1 pass". */
static void print_number(FILE *out, uint32_t count, const char *word, const char *plural)
{
	fprintf(out, "%u %s%s", count, word, count == 1 ? "" : plural);
}

void gpu_print_bytes(FILE *out, uint64_t bytes)
{
	if (bytes < 1024)
		fprintf(out, "%llu B", (unsigned long long)bytes);
	else if (bytes < 1048576)
		fprintf(out, "%.1f KiB", (double)bytes / 1024);
	else
		fprintf(out, "%.1f MiB", (double)bytes / 1048576);
}

/* "color+resolve", or "nothing". */
static void print_accesses(FILE *out, uint32_t all)
{
	if (all == 0)
		fprintf(out, "nothing");
	for (uint32_t i = 0, n = 0; i < STILB_GPU_ACCESSES; i++)
		if (all & 1u << i)
			fprintf(out, "%s%s", n++ > 0 ? "+" : "", stilb_gpu_access_name((stilb_gpu_access)i));
}

/* " mips 1 to 3, layer 0", or nothing if it is all. */
static void print_range(FILE *out, const gpu_resource *resource, stilb_gpu_range range)
{
	const stilb_gpu_extent *extent = &resource->extent;
	const char *comma = "";
	if (range.mips != extent->mips) {
		fprintf(out, range.mips == 1 ? " mip %u" : " mips %u to %u", range.mip, range.mip + range.mips - 1);
		comma = ",";
	}
	if (range.layers != extent->layers)
		fprintf(out, range.layers == 1 ? "%s layer %u" : "%s layers %u to %u", comma, range.layer,
		        range.layer + range.layers - 1);
}

void gpu_print_barrier(FILE *out, const stilb_gpu_plan *plan, const stilb_gpu_barrier *barrier)
{
	const gpu_resource *resource = gpu_plan_resource(plan, barrier->resource);
	fprintf(out, "%s", resource->name);
	print_range(out, resource, (stilb_gpu_range){barrier->mip, barrier->mips, barrier->layer, barrier->layers});
	fprintf(out, ": ");
	print_accesses(out, barrier->from_all);
	fprintf(out, " > ");
	print_accesses(out, barrier->to_all);
	if (barrier->previous)
		fprintf(out, ", last frame's");
	if (barrier->memory)
		fprintf(out, ", memory used before");
	if (barrier->zero)
		fprintf(out, ", filled with zeros");
	else if (barrier->discard)
		fprintf(out, ", content dropped");
}

static void print_barriers(FILE *out, const stilb_gpu_plan *plan, uint32_t first, uint32_t count)
{
	const stilb_gpu_barrier *barriers = plan->barriers.items;
	for (uint32_t i = first; i < first + count; i++) {
		fprintf(out, "    barrier  ");
		gpu_print_barrier(out, plan, &barriers[i]);
		fprintf(out, "\n");
	}
}

/* What a step waits for, of other queues; step_count: the frame's end. */
static void print_waits(FILE *out, const stilb_gpu_plan *plan, uint32_t step)
{
	const stilb_gpu_step *steps = plan->steps.items;
	const stilb_gpu_queue_wait *waits = plan->waits.items;
	for (uint32_t i = 0; i < plan->wait_count; i++)
		if (waits[i].step == step)
			fprintf(out, "    waits for pass %u '%s'\n", steps[waits[i].before].pass + 1,
			        gpu_plan_row(plan, steps[waits[i].before].pass)->name);
}

static void print_step(FILE *out, const stilb_gpu_plan *plan, const stilb_gpu_step *step)
{
	const stilb_gpu_pass *pass = gpu_plan_row(plan, step->pass);
	fprintf(out, "%3u %s, %s", step->pass + 1, pass->name, kinds[pass->kind]);
	if (step->area[0] > 0)
		fprintf(out, ", %u x %u", step->area[0], step->area[1]);
	if (gpu_pass_has_area(pass))
		fprintf(out, ", of it %u x %u at %u, %u", pass->area[2], pass->area[3], pass->area[0], pass->area[1]);
	if (step->samples > 1)
		fprintf(out, ", %u samples", step->samples);
	if (pass->kind == STILB_GPU_PASS_DISPATCH && pass->groups[0] > 0)
		fprintf(out, ", %u x %u x %u groups", pass->groups[0], pass->groups[1], pass->groups[2]);
	if (pass->queue != STILB_GPU_QUEUE_MAIN)
		fprintf(out, ", on the queue %s", pass->queue == STILB_GPU_QUEUE_COMPUTE ? "compute" : "copy");
	fprintf(out, "\n");
	print_waits(out, plan, (uint32_t)(step - (const stilb_gpu_step *)plan->steps.items));
	print_barriers(out, plan, step->first_barrier, step->barrier_count);
	uint32_t count;
	const gpu_touch *touches = gpu_plan_touches(plan, step->pass, &count);
	for (uint32_t i = 0; i < count; i++) {
		const gpu_resource *resource = gpu_plan_resource(plan, touches[i].resource);
		fprintf(out, "    %s %s", gpu_touch_verb(pass, &touches[i]), resource->name);
		print_range(out, resource, touches[i].range);
		fprintf(out, "%s\n", touches[i].previous ? ", last frame's" : "");
	}
}

/* ---- what is left out -------------------------------------------------------------------------------------------- */

static bool ranges_meet(stilb_gpu_range a, stilb_gpu_range b)
{
	return a.mip < b.mip + b.mips && b.mip < a.mip + a.mips && a.layer < b.layer + b.layers &&
	       b.layer < a.layer + a.layers;
}

/* A later pass that runs and replaces what a pass writes there; NULL: none. */
static const stilb_gpu_pass *find_replacer(const stilb_gpu_plan *plan, uint32_t row, const gpu_touch *written)
{
	const bool *live = plan->live.items;
	for (uint32_t later = row + 1; later < plan->row_count; later++) {
		uint32_t count;
		const gpu_touch *touches = gpu_plan_touches(plan, later, &count);
		for (uint32_t i = 0; live[later] && i < count; i++)
			if (touches[i].resource == written->resource && touches[i].replaces &&
			    ranges_meet(touches[i].range, written->range))
				return gpu_plan_row(plan, later);
	}
	return NULL;
}

void gpu_print_left_out(FILE *out, const stilb_gpu_plan *plan, uint32_t row)
{
	uint32_t count, i = 0;
	const gpu_touch *touches = gpu_plan_touches(plan, row, &count);
	fprintf(out, "%s: ", gpu_plan_row(plan, row)->name);
	if (gpu_plan_cuts(plan, row)) {
		fprintf(out, "the frame is cut after pass %u, %s", plan->cut[0], gpu_plan_row(plan, plan->cut[0] - 1)->name);
		return;
	}
	while (i < count && !touches[i].writes)
		i++;
	if (i == count) {
		fprintf(out, "it writes nothing");
		return;
	}
	const gpu_resource *resource = gpu_plan_resource(plan, touches[i].resource);
	const stilb_gpu_pass *replacer = find_replacer(plan, row, &touches[i]);
	fprintf(out, "nobody reads %s", resource->name);
	print_range(out, resource, touches[i].range);
	if (replacer)
		fprintf(out, " before %s replaces it", replacer->name);
	else
		fprintf(out, " after it");
}

static void print_left_outs(FILE *out, const stilb_gpu_plan *plan)
{
	const bool *live = plan->live.items;
	if (plan->step_count < plan->row_count)
		fprintf(out, "left out\n");
	for (uint32_t row = 0; row < plan->row_count; row++)
		if (!live[row]) {
			fprintf(out, "%3u ", row + 1);
			gpu_print_left_out(out, plan, row);
			fprintf(out, "\n");
		}
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

void gpu_print_extent(FILE *out, const gpu_resource *resource)
{
	const stilb_gpu_extent *extent = &resource->extent;
	if (resource->buffer) {
		fprintf(out, "buffer");
		return;
	}
	fprintf(out, "%s %u x %u", stilb_gpu_format_describe(extent->format)->name, extent->width, extent->height);
	if (extent->depth > 1)
		fprintf(out, " x %u", extent->depth);
	if (extent->shape == STILB_GPU_SHAPE_CUBE)
		fprintf(out, " cube");
	if (extent->layers > (extent->shape == STILB_GPU_SHAPE_CUBE ? 6 : 1))
		fprintf(out, " %u layers", extent->layers);
	if (extent->mips > 1)
		fprintf(out, " %u mips", extent->mips);
	if (extent->samples > 1)
		fprintf(out, " %u samples", extent->samples);
}

static void print_resource(FILE *out, const stilb_gpu_plan *plan, uint32_t number)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	const stilb_gpu_placed *placed = gpu_plan_placed(plan, number);
	const stilb_gpu_step *steps = plan->steps.items;
	fprintf(out, "    %s, ", resource->name);
	gpu_print_extent(out, resource);
	fprintf(out, ", ");
	gpu_print_bytes(out, placed->bytes);
	if (placed->first_step > placed->last_step) {
		fprintf(out, ", used by no pass\n");
		return;
	}
	fprintf(out, ", passes %u to %u", steps[placed->first_step].pass + 1, steps[placed->last_step].pass + 1);
	if (placed->shared)
		fprintf(out, ", heap %u at %llu", placed->heap, (unsigned long long)placed->offset);
	fprintf(out, "%s%s%s%s%s\n", placed->owned != 0 ? ", owned" : "", resource->image.keep ? ", kept" : "",
	        placed->two ? " twice" : "", resource->image.output ? ", output" : "", resource->shown ? ", shown" : "");
}

/* What the resources in shared memory would take without sharing. */
static uint64_t alone_bytes(const stilb_gpu_plan *plan)
{
	uint64_t bytes = 0;
	for (uint32_t i = 1; i <= plan->resource_count; i++)
		bytes += gpu_plan_placed(plan, i)->shared ? gpu_plan_placed(plan, i)->bytes : 0;
	return bytes;
}

void gpu_print_title(FILE *out, const stilb_gpu_plan *plan)
{
	uint64_t bytes = 0;
	for (uint32_t i = 0; i < stilb_gpu_plan_heaps(plan); i++)
		bytes += stilb_gpu_plan_heap_bytes(plan, i);
	fprintf(out, "picture %u x %u, ", plan->size[0], plan->size[1]);
	print_number(out, plan->step_count, "pass", "es");
	fprintf(out, ", ");
	print_number(out, plan->barrier_count, "barrier", "s");
	fprintf(out, ", ");
	gpu_print_bytes(out, bytes);
	fprintf(out, " of shared memory for ");
	gpu_print_bytes(out, alone_bytes(plan));
}

stilb_result stilb_gpu_plan_text(const stilb_gpu_plan *plan, char **text)
{
	STILB_ASSERT(plan && plan->made && text);
	size_t size = 0;
	*text = NULL;
	FILE *out = open_memstream(text, &size);
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the text of a plan");
	gpu_print_title(out, plan);
	fprintf(out, "\n");
	for (uint32_t i = 0; i < plan->step_count; i++)
		print_step(out, plan, (const stilb_gpu_step *)plan->steps.items + i);
	const stilb_gpu_queue_wait *waits = plan->waits.items;
	bool joins = plan->wait_count > 0 && waits[plan->wait_count - 1].step == plan->step_count;
	if (plan->last_barrier < plan->barrier_count || joins)
		fprintf(out, "    after the frame\n");
	print_waits(out, plan, plan->step_count);
	print_barriers(out, plan, plan->last_barrier, plan->barrier_count - plan->last_barrier);
	print_left_outs(out, plan);
	fprintf(out, "resources\n");
	for (uint32_t i = 1; i <= plan->resource_count; i++)
		print_resource(out, plan, i);
	bool failed = ferror(out);
	failed = fclose(out) != 0 || failed;
	if (!failed)
		return STILB_OK;
	free(*text);
	*text = NULL;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the text of a plan");
}
