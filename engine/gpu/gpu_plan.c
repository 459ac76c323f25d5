/* gpu_plan: life of a plan, rows that are added, and its results. Rows are compared with last frame's as they come, so
 * that making the same plan again costs nothing. */
#include "gpu/gpu_plan_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- arrays that grow -------------------------------------------------------------------------------------------- */

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_gpu_plan *stilb_gpu_plan_create(void)
{
	return calloc(1, sizeof(stilb_gpu_plan));
}

void stilb_gpu_plan_destroy(stilb_gpu_plan *plan)
{
	if (!plan)
		return;
	gpu_array *arrays[] = {
		&plan->resources, &plan->rows,         &plan->shown,        &plan->names,     &plan->left.records,
		&plan->left.subs, &plan->left.regions, &plan->next.records, &plan->next.subs, &plan->next.regions,
		&plan->touches,   &plan->spans,        &plan->marks,        &plan->subs,      &plan->live,
		&plan->placed,    &plan->steps,        &plan->barriers,     &plan->items,     &plan->placing,
		&plan->keys,      &plan->lives,        &plan->counted,      &plan->orders,    &plan->users,
		&plan->clocks,    &plan->waits,
	};
	for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
		free(arrays[i]->items);
	for (uint32_t i = 0; i < GPU_PLACEMENTS; i++)
		free(plan->placements[i].items.items);
	free(plan);
}

/* What the last plan left is what the next one finds. */
static void take_over(stilb_gpu_plan *plan)
{
	if (plan->next_counts && !plan->dropped) {
		gpu_left left = plan->left;
		plan->left = plan->next;
		plan->next = left;
	}
	if (plan->next_counts && plan->dropped)
		plan->made = false; /* what was made went on from another state */
	plan->next_counts = plan->dropped = false;
}

void stilb_gpu_plan_begin(stilb_gpu_plan *plan, uint32_t width, uint32_t height)
{
	STILB_ASSERT(plan && width > 0 && width <= STILB_GPU_MAX_SIDE && height > 0 && height <= STILB_GPU_MAX_SIDE);
	take_over(plan);
	bool same = plan->planned && plan->size[0] == width && plan->size[1] == height;
	plan->resources_known = same ? plan->resource_count : 0;
	plan->rows_known = same ? plan->row_count : 0;
	plan->shown_known = same ? plan->shown_count : 0;
	memcpy(plan->cut_known, plan->cut, sizeof plan->cut_known);
	plan->cut[0] = plan->cut[1] = 0;
	plan->size[0] = width;
	plan->size[1] = height;
	plan->resource_count = plan->row_count = plan->shown_count = 0;
	plan->changed = plan->rows_changed = false;
	plan->begun = true;
	plan->planned = false;
	plan->row_error = STILB_OK;
}

void stilb_gpu_plan_dropped(stilb_gpu_plan *plan)
{
	STILB_ASSERT(plan);
	plan->dropped = true;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

static uint64_t hash_owned(uint64_t owned)
{
	return owned * 0x9e3779b97f4a7c15u ^ owned >> 29;
}

static void name_insert(stilb_gpu_plan *plan, uint64_t hash, uint16_t number)
{
	uint16_t *names = plan->names.items;
	uint64_t at = hash;
	while (names[at & plan->name_mask] != 0)
		at++;
	names[at & plan->name_mask] = number;
}

static uint16_t name_find(const stilb_gpu_plan *plan, const char *name, uint64_t hash)
{
	const uint16_t *names = plan->names.items;
	for (uint64_t at = hash; names && names[at & plan->name_mask] != 0; at++) {
		uint16_t number = names[at & plan->name_mask];
		if (number > plan->resource_count)
			continue;
		const gpu_resource *resource = gpu_plan_resource(plan, number);
		if (resource->name_hash == hash && strcmp(resource->name, name) == 0)
			return number;
	}
	return 0;
}

static uint16_t owned_find(const stilb_gpu_plan *plan, uint64_t owned, bool buffer)
{
	const uint16_t *names = plan->names.items;
	for (uint64_t at = hash_owned(owned); names && names[at & plan->name_mask] != 0; at++) {
		const gpu_resource *resource = gpu_plan_resource(plan, names[at & plan->name_mask]);
		if (resource->image.owned == owned && resource->buffer == buffer)
			return names[at & plan->name_mask];
	}
	return 0;
}

static void name_add(stilb_gpu_plan *plan, uint16_t number)
{
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	name_insert(plan, resource->name_hash, number);
	if (resource->image.owned != 0)
		name_insert(plan, hash_owned(resource->image.owned), number);
}

/* Makes the table anew, of the rows so far, with room for `more`: at most half full, with two entries a resource. */
static bool names_rebuild(stilb_gpu_plan *plan, uint32_t more)
{
	size_t size = 64;
	while (size < 4 * (size_t)(plan->resource_count + more))
		size *= 2;
	if (!gpu_array_reserve(&plan->names, size, sizeof(uint16_t)))
		return false;
	plan->name_mask = (uint32_t)size - 1;
	memset(plan->names.items, 0, size * sizeof(uint16_t));
	for (uint32_t i = 1; i <= plan->resource_count; i++)
		name_add(plan, (uint16_t)i);
	return true;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* The first mistake counts. */
static uint16_t remember_error(stilb_gpu_plan *plan, stilb_result result)
{
	if (plan->row_error == STILB_OK) {
		plan->row_error = result;
		strncpy(plan->row_message, stilb_error_message(), sizeof plan->row_message - 1);
	}
	return 0;
}

/* From this row on the resources are others. */
static bool change(stilb_gpu_plan *plan)
{
	if (plan->changed)
		return true;
	plan->changed = true;
	plan->made = false;
	return names_rebuild(plan, plan->resources_known > plan->resource_count ? plan->resources_known : 64);
}

static bool same_image(const gpu_resource *resource, const stilb_gpu_plan_image_row *row)
{
	const stilb_gpu_plan_image_row *known = &resource->image;
	return !resource->buffer && row->format == known->format && row->shape == known->shape &&
	       row->scale == known->scale && row->width == known->width && row->height == known->height &&
	       row->depth == known->depth && row->layers == known->layers && row->mips == known->mips &&
	       row->samples == known->samples && row->keep == known->keep && row->output == known->output &&
	       row->owned == known->owned && row->name && strcmp(row->name, resource->name) == 0;
}

static bool same_buffer(const gpu_resource *resource, const stilb_gpu_plan_buffer_row *row)
{
	return resource->buffer && row->bytes == resource->bytes && row->keep == resource->image.keep &&
	       row->output == resource->image.output && row->owned == resource->image.owned && row->name &&
	       strcmp(row->name, resource->name) == 0;
}

/* Checks what all resources have, and makes room. NULL: refused. */
static gpu_resource *begin_resource_row(stilb_gpu_plan *plan, const char *name, const char *word, uint64_t owned)
{
	uint32_t number = plan->resource_count + 1;
	stilb_result result = STILB_OK;
	if (!change(plan) || !gpu_array_reserve(&plan->resources, number + 1, sizeof(gpu_resource)) ||
	    (plan->name_mask < 4 * number && !names_rebuild(plan, number)))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u resources", number);
	else if (number > STILB_GPU_PLAN_MAX_RESOURCES)
		result = stilb_fail(STILB_ERROR_ARGUMENT, "the plan has more than %u resources", STILB_GPU_PLAN_MAX_RESOURCES);
	else if (!name || name[0] == '\0')
		result = stilb_fail(STILB_ERROR_ARGUMENT, "%s %u has no name", word, number);
	else if (strlen(name) > STILB_GPU_MAX_NAME)
		result = stilb_fail(STILB_ERROR_ARGUMENT, "the %s's name '%.80s' has %zu bytes: %u are the most", word, name,
		                    strlen(name), STILB_GPU_MAX_NAME);
	if (result != STILB_OK) {
		remember_error(plan, result);
		return NULL;
	}
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, name, strlen(name));
	uint16_t other = name_find(plan, name, hash);
	uint16_t same = owned != 0 ? owned_find(plan, owned, word[0] == 'b') : 0;
	if (other != 0)
		result =
			stilb_fail(STILB_ERROR_ARGUMENT, "two resources, %u and %u, have the name '%s': each has one of its own",
		               other, number, name);
	else if (same != 0)
		result = stilb_fail(STILB_ERROR_ARGUMENT, "'%s' and '%s' are the same owned %s: name it once",
		                    gpu_plan_resource(plan, same)->name, name, word);
	if (result != STILB_OK) {
		remember_error(plan, result);
		return NULL;
	}
	gpu_resource *resource = (gpu_resource *)plan->resources.items + number;
	memset(resource, 0, sizeof *resource);
	memcpy(resource->name, name, strlen(name));
	resource->name_hash = hash;
	return resource;
}

static uint16_t end_resource_row(stilb_gpu_plan *plan, stilb_result result)
{
	if (result != STILB_OK)
		return remember_error(plan, result);
	plan->resource_count++;
	name_add(plan, (uint16_t)plan->resource_count);
	return (uint16_t)plan->resource_count;
}

uint16_t stilb_gpu_plan_image(stilb_gpu_plan *plan, const stilb_gpu_plan_image_row *row)
{
	STILB_ASSERT(plan && row && plan->begun);
	uint32_t number = plan->resource_count + 1;
	if (!plan->changed && number <= plan->resources_known &&
	    same_image((const gpu_resource *)plan->resources.items + number, row))
		return (uint16_t)++plan->resource_count;
	gpu_resource *resource = begin_resource_row(plan, row->name, "image", row->owned);
	if (!resource)
		return 0;
	resource->image = *row;
	resource->image.name = NULL;
	return end_resource_row(plan, gpu_resource_check_image(resource, plan->size));
}

uint16_t stilb_gpu_plan_buffer(stilb_gpu_plan *plan, const stilb_gpu_plan_buffer_row *row)
{
	STILB_ASSERT(plan && row && plan->begun);
	uint32_t number = plan->resource_count + 1;
	if (!plan->changed && number <= plan->resources_known &&
	    same_buffer((const gpu_resource *)plan->resources.items + number, row))
		return (uint16_t)++plan->resource_count;
	gpu_resource *resource = begin_resource_row(plan, row->name, "buffer", row->owned);
	if (!resource)
		return 0;
	resource->buffer = true;
	resource->bytes = row->bytes;
	resource->image.keep = row->keep;
	resource->image.output = row->output;
	resource->image.owned = row->owned;
	return end_resource_row(plan, gpu_resource_check_buffer(resource));
}

/* All that the plan depends on: not names, constants and clear values. Member by member where padding lies between. */
static bool same_attachment(const stilb_gpu_attachment *a, const stilb_gpu_attachment *b)
{
	return memcmp(a, b, offsetof(stilb_gpu_attachment, read_only)) == 0 && a->read_only == b->read_only;
}

static bool same_use(const stilb_gpu_use *a, const stilb_gpu_use *b)
{
	return memcmp(a, b, offsetof(stilb_gpu_use, mips)) == 0 && a->mips == b->mips && a->array == b->array &&
	       a->layer == b->layer && a->layers == b->layers && a->first == b->first && a->bytes == b->bytes;
}

static bool same_pass(const stilb_gpu_pass *a, const stilb_gpu_pass *b)
{
	size_t first = offsetof(stilb_gpu_pass, kind), end = offsetof(stilb_gpu_pass, color);
	if (memcmp((const char *)a + first, (const char *)b + first, end - first) != 0 || !a->name != !b->name)
		return false;
	if (a->color_count > STILB_GPU_MAX_COLORS || a->use_count > STILB_GPU_MAX_USES)
		return false;
	for (uint32_t i = 0; i < a->color_count; i++)
		if (!same_attachment(&a->color[i], &b->color[i]))
			return false;
	for (uint32_t i = 0; i < a->use_count; i++)
		if (!same_use(&a->uses[i], &b->uses[i]))
			return false;
	return same_attachment(&a->depth, &b->depth);
}

/* What does not matter to the plan. */
static void take_values(stilb_gpu_pass *known, const stilb_gpu_pass *row)
{
	known->name = row->name;
	for (uint32_t i = 0; i < row->color_count; i++)
		memcpy(known->color[i].clear, row->color[i].clear, sizeof known->color[i].clear);
	memcpy(known->depth.clear, row->depth.clear, sizeof known->depth.clear);
	memcpy(known->constants, row->constants, row->constant_bytes);
}

void stilb_gpu_plan_pass(stilb_gpu_plan *plan, const stilb_gpu_pass *row)
{
	STILB_ASSERT(plan && row && plan->begun);
	bool known = plan->row_count < plan->rows_known;
	stilb_gpu_pass *rows = plan->rows.items;
	if (known && same_pass(&rows[plan->row_count], row)) {
		take_values(&rows[plan->row_count], row);
		plan->row_count++;
		return;
	}
	if (plan->row_count == STILB_GPU_PLAN_MAX_PASSES) {
		remember_error(plan,
		               stilb_fail(STILB_ERROR_ARGUMENT, "the plan has more than %u passes", STILB_GPU_PLAN_MAX_PASSES));
		return;
	}
	plan->rows_changed = true;
	if (!gpu_array_reserve(&plan->rows, plan->row_count + 1, sizeof(stilb_gpu_pass)) ||
	    !gpu_array_reserve(&plan->spans, plan->row_count + 1, sizeof(gpu_span))) {
		remember_error(plan, stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u passes", plan->row_count + 1));
		return;
	}
	((stilb_gpu_pass *)plan->rows.items)[plan->row_count] = *row;
	gpu_span *span = (gpu_span *)plan->spans.items + plan->row_count;
	if (!known)
		*span = (gpu_span){0};
	span->checked = false;
	plan->row_count++;
}

uint32_t stilb_gpu_plan_mips(stilb_gpu_plan *plan, uint16_t image, uint16_t first_layer, uint16_t layers)
{
	STILB_ASSERT(plan && plan->begun);
	uint32_t mips = image > 0 && image <= plan->resource_count ? gpu_plan_resource(plan, image)->extent.mips : 0;
	for (uint32_t mip = 1; mip < mips; mip++) {
		stilb_gpu_use use = {.resource = image, .mip = (uint8_t)mip, .mips = 1, .layer = first_layer, .layers = layers};
		stilb_gpu_pass pass = {.name = "mips", .kind = STILB_GPU_PASS_COPY, .uses = {use, use}, .use_count = 2};
		pass.uses[0].how = STILB_GPU_USE_COPY_FROM;
		pass.uses[0].mip--;
		pass.uses[1].how = STILB_GPU_USE_COPY_TO;
		stilb_gpu_plan_pass(plan, &pass);
	}
	return mips > 0 ? mips - 1 : 0;
}

uint16_t stilb_gpu_plan_find(const stilb_gpu_plan *plan, const char *name)
{
	STILB_ASSERT(plan && name);
	return name_find(plan, name, stilb_hash_fnv1a64(STILB_FNV1A64_START, name, strlen(name)));
}

const stilb_gpu_extent *stilb_gpu_plan_extent(const stilb_gpu_plan *plan, uint16_t resource)
{
	STILB_ASSERT(plan);
	return &gpu_plan_resource(plan, resource)->extent;
}

bool stilb_gpu_plan_kept(const stilb_gpu_plan *plan, uint16_t number)
{
	STILB_ASSERT(plan);
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	if (!resource->image.keep || plan->left.record_count == 0)
		return false;
	uint32_t at = gpu_plan_find_record(plan, resource, 0);
	const gpu_record *records = plan->left.records.items;
	return at != GPU_NO_RECORD && records[at].keep && records[at].written;
}

void stilb_gpu_plan_show(stilb_gpu_plan *plan, uint16_t resource)
{
	STILB_ASSERT(plan && plan->begun);
	if (resource == 0)
		return; /* its row was a mistake */
	STILB_ASSERT(resource <= plan->resource_count);
	uint16_t *shown = plan->shown.items;
	bool same = !plan->changed && plan->shown_count < plan->shown_known && shown[plan->shown_count] == resource;
	if (!same && (!change(plan) || !gpu_array_reserve(&plan->shown, plan->shown_count + 1, sizeof *shown))) {
		remember_error(plan, stilb_fail(STILB_ERROR_MEMORY, "no memory for another resource that is shown"));
		return;
	}
	shown = plan->shown.items;
	shown[plan->shown_count] = resource;
	plan->shown_count++;
}

void stilb_gpu_plan_cut(stilb_gpu_plan *plan, uint32_t pass)
{
	STILB_ASSERT(plan && plan->begun);
	STILB_ASSERT(pass < plan->row_count);
	STILB_ASSERT(plan->cut[0] == 0 && "once a frame");
	plan->cut[0] = pass + 1;
	plan->cut[1] = plan->row_count;
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* Asks for mistakes of the rows that run and have changed. */
static stilb_result ask_mistakes(stilb_gpu_plan *plan)
{
	const stilb_gpu_step *steps = plan->steps.items;
	gpu_span *spans = plan->spans.items;
	for (uint32_t s = 0; plan->planner.mistake && s < plan->step_count; s++) {
		if (spans[steps[s].pass].asked)
			continue;
		const stilb_gpu_pass *pass = gpu_plan_row(plan, steps[s].pass);
		const char *mistake = plan->planner.mistake(plan->planner.user, plan, pass);
		if (mistake)
			return stilb_fail(STILB_ERROR_ARGUMENT, "pass %u '%s' %s", steps[s].pass + 1, pass->name, mistake);
		spans[steps[s].pass].asked = true;
	}
	return STILB_OK;
}

/* stays: what was made of the table before is the plan of this one, too, if all touches are the same. */
static stilb_result make(stilb_gpu_plan *plan, bool stays)
{
	for (uint32_t i = 1; i <= plan->resource_count && plan->changed; i++)
		gpu_plan_resource(plan, i)->shown = false;
	for (uint32_t i = 0; i < plan->shown_count && plan->changed; i++)
		gpu_plan_resource(plan, ((const uint16_t *)plan->shown.items)[i])->shown = true;
	bool same;
	stilb_result result = gpu_plan_check_passes(plan, &same);
	if (result == STILB_OK && same && stays)
		return ask_mistakes(plan);
	plan->next_counts = true;
	plan->step_count = plan->barrier_count = plan->last_barrier = plan->wait_count = 0;
	result = result == STILB_OK ? gpu_plan_find_live(plan) : result;
	result = result == STILB_OK ? ask_mistakes(plan) : result;
	result = result == STILB_OK ? gpu_plan_place_memory(plan) : result;
	result = result == STILB_OK ? gpu_plan_find_barriers(plan) : result;
	return result == STILB_OK ? gpu_plan_find_waits(plan) : result;
}

static bool same_planner(const stilb_gpu_planner *a, const stilb_gpu_planner *b)
{
	return a->user == b->user && a->version == b->version && a->image_needs == b->image_needs &&
	       a->buffer_needs == b->buffer_needs && a->mistake == b->mistake;
}

/* Another device is asked anew. */
static void forget_answers(stilb_gpu_plan *plan)
{
	for (uint32_t i = 1; i <= plan->resource_count; i++)
		gpu_plan_resource(plan, i)->needs.bytes = 0;
	for (uint32_t row = 0; row < plan->row_count; row++)
		((gpu_span *)plan->spans.items)[row].asked = false;
}

stilb_result stilb_gpu_plan_make(stilb_gpu_plan *plan, const stilb_gpu_planner *planner)
{
	STILB_ASSERT(plan && plan->begun);
	static const stilb_gpu_planner nobody = {0};
	planner = planner ? planner : &nobody;
	if (plan->resource_count != plan->resources_known || plan->shown_count != plan->shown_known ||
	    memcmp(plan->cut, plan->cut_known, sizeof plan->cut) != 0)
		plan->changed = true;
	if (plan->row_count != plan->rows_known)
		plan->rows_changed = true;
	bool same = same_planner(planner, &plan->planner);
	bool stays = !plan->changed && plan->made && plan->steady && same;
	if (stays && !plan->rows_changed) {
		plan->planned = true;
		return STILB_OK;
	}
	plan->made = plan->planned = plan->next_counts = false;
	plan->planner = *planner;
	if (!same)
		forget_answers(plan);
	stilb_result result = plan->row_error;
	if (result != STILB_OK)
		stilb_fail(result, "%s", plan->row_message);
	else
		result = make(plan, stays);
	plan->made = plan->planned = result == STILB_OK;
	if (result == STILB_OK)
		return STILB_OK;
	plan->next_counts = false;
	plan->step_count = plan->barrier_count = plan->last_barrier = plan->wait_count = 0;
	return result;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

uint32_t stilb_gpu_plan_steps(const stilb_gpu_plan *plan, const stilb_gpu_step **steps)
{
	STILB_ASSERT(plan && steps);
	*steps = plan->steps.items;
	return plan->step_count;
}

uint32_t stilb_gpu_plan_barriers(const stilb_gpu_plan *plan, const stilb_gpu_barrier **barriers)
{
	STILB_ASSERT(plan && barriers);
	*barriers = plan->barriers.items;
	return plan->barrier_count;
}

uint32_t stilb_gpu_plan_last_barriers(const stilb_gpu_plan *plan, uint32_t *first)
{
	STILB_ASSERT(plan && first);
	*first = plan->last_barrier;
	return plan->barrier_count - plan->last_barrier;
}

uint32_t stilb_gpu_plan_waits(const stilb_gpu_plan *plan, const stilb_gpu_queue_wait **waits)
{
	STILB_ASSERT(plan && waits);
	*waits = plan->waits.items;
	return plan->wait_count;
}

const stilb_gpu_pass *stilb_gpu_plan_row(const stilb_gpu_plan *plan, uint32_t pass)
{
	STILB_ASSERT(plan);
	return gpu_plan_row(plan, pass);
}

uint32_t stilb_gpu_plan_passes(const stilb_gpu_plan *plan)
{
	STILB_ASSERT(plan);
	return plan->row_count;
}

uint32_t stilb_gpu_plan_resources(const stilb_gpu_plan *plan)
{
	STILB_ASSERT(plan);
	return plan->resource_count;
}

const stilb_gpu_placed *stilb_gpu_plan_place(const stilb_gpu_plan *plan, uint16_t resource)
{
	STILB_ASSERT(plan && plan->made && resource > 0 && resource <= plan->resource_count);
	return gpu_plan_placed(plan, resource);
}

const char *stilb_gpu_plan_name(const stilb_gpu_plan *plan, uint16_t resource)
{
	STILB_ASSERT(plan);
	return gpu_plan_resource(plan, resource)->name;
}

bool stilb_gpu_plan_ready(const stilb_gpu_plan *plan, uint16_t number, uint8_t mip, uint16_t layer)
{
	STILB_ASSERT(plan && plan->made);
	const gpu_resource *resource = gpu_plan_resource(plan, number);
	if (mip >= resource->extent.mips || layer >= resource->extent.layers)
		return false;
	uint32_t at = resource->subs == 1 ? 0 : (uint32_t)layer * resource->extent.mips + mip;
	return (resource->image.output || resource->shown) &&
	       ((const gpu_sub *)plan->subs.items)[resource->first_sub + at].now;
}

uint32_t stilb_gpu_plan_heaps(const stilb_gpu_plan *plan)
{
	STILB_ASSERT(plan);
	return plan->placements[plan->placement].heap_count;
}

uint64_t stilb_gpu_plan_heap_bytes(const stilb_gpu_plan *plan, uint32_t heap)
{
	STILB_ASSERT(plan && heap < stilb_gpu_plan_heaps(plan));
	return plan->placements[plan->placement].heap_bytes[heap];
}
