/* Random tables. A pass begins with what its kind asks for, and is then given uses one by one, of which those that
 * would be mistakes are left out. What was written so far, and what the pass touches, is known for each mip and layer.
 */
#include "gpu_random.h"

#include "support/test.h"

#include <string.h>

typedef struct builder {
	random_table *table;
	uint64_t seed, index;
	bool written[RANDOM_RESOURCES + 1][RANDOM_SUBS];
	uint32_t touched[RANDOM_RESOURCES + 1][2]
					[RANDOM_SUBS]; /* by the pass; layout + 1, or 0x100 if written; [1]: previous */
} builder;

static uint32_t pick(builder *b, uint32_t below)
{
	return (uint32_t)(stilb_random_u64(b->seed, b->index++) % below);
}

static bool chance(builder *b, uint32_t percent)
{
	return pick(b, 100) < percent;
}

bool random_keeps(const random_table *table, uint32_t r)
{
	return table->buffer[r] ? table->buffers[r].keep : table->images[r].keep;
}

bool random_outputs(const random_table *table, uint32_t r)
{
	return table->buffer[r] ? table->buffers[r].output : table->images[r].output;
}

uint64_t random_owned(const random_table *table, uint32_t r)
{
	return table->buffer[r] ? table->buffers[r].owned : table->images[r].owned;
}

stilb_gpu_format_kind random_kind(const random_table *table, uint32_t r)
{
	return table->buffer[r] ? STILB_GPU_FORMAT_COLOR : stilb_gpu_format_describe(table->images[r].format)->kind;
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

static const char *const names[RANDOM_RESOURCES + 1] = {"", "r1", "r2", "r3", "r4", "r5", "r6", "r7", "r8"};

static void make_image(builder *b, uint32_t r)
{
	static const stilb_gpu_format formats[] = {STILB_GPU_RGBA8_U, STILB_GPU_RGBA16_F, STILB_GPU_R32_UI, STILB_GPU_D32_F,
	                                           STILB_GPU_RGBA8_SRGB};
	stilb_gpu_plan_image_row *row = &b->table->images[r];
	*row = (stilb_gpu_plan_image_row){.name = names[r], .format = formats[pick(b, 5)], .width = 16, .height = 16};
	uint32_t shape = pick(b, 10);
	if (shape == 0 && row->format != STILB_GPU_D32_F) {
		row->shape = STILB_GPU_SHAPE_3D;
		row->depth = 4;
	} else if (shape == 1) {
		row->shape = STILB_GPU_SHAPE_CUBE;
	} else if (shape < 4) {
		row->samples = 4;
		row->layers = (uint16_t)(1 + pick(b, 2));
	} else {
		row->layers = (uint16_t)(1 + pick(b, 3));
	}
	if (row->samples == 0)
		row->mips = (uint16_t)(1 + pick(b, 3));
	b->table->mips[r] = row->mips > 0 ? row->mips : 1;
	b->table->layers[r] = row->shape == STILB_GPU_SHAPE_CUBE ? 6 : row->layers > 0 ? row->layers : 1;
}

static void make_resources(builder *b)
{
	random_table *table = b->table;
	table->resource_count = 2 + pick(b, RANDOM_RESOURCES - 1);
	for (uint32_t r = 1; r <= table->resource_count; r++) {
		uint32_t stay = pick(b, 100);
		bool keep = stay < 20, output = (stay >= 15 && stay < 40) || r == 1;
		uint64_t owned = stay >= 90 ? 100 + r : 0;
		table->buffer[r] = chance(b, 25);
		table->mips[r] = table->layers[r] = 1;
		if (table->buffer[r]) {
			table->buffers[r] = (stilb_gpu_plan_buffer_row){
				.name = names[r], .bytes = 256 << pick(b, 8), .keep = keep, .output = output, .owned = owned};
			continue;
		}
		make_image(b, r);
		table->images[r].keep = keep;
		table->images[r].output = output;
		table->images[r].owned = owned;
	}
}

/* ---- what a pass touches ----------------------------------------------------------------------------------------- */

static uint32_t add_range(const random_table *table, random_access *out, random_access one, stilb_gpu_range range)
{
	uint32_t count = 0;
	(void)table;
	for (uint32_t layer = range.layer; layer < (uint32_t)range.layer + range.layers; layer++)
		for (uint32_t mip = range.mip; mip < (uint32_t)range.mip + range.mips; mip++) {
			out[count] = one;
			out[count].mip = mip;
			out[count].layer = layer;
			count++;
		}
	return count;
}

static uint32_t add_attachment(const random_table *table, random_access *out, const stilb_gpu_attachment *a, bool depth)
{
	stilb_gpu_access access = !depth         ? STILB_GPU_ACCESS_COLOR
	                          : a->read_only ? STILB_GPU_ACCESS_DEPTH_READ
	                                         : STILB_GPU_ACCESS_DEPTH;
	bool keep = a->load == STILB_GPU_LOAD_KEEP;
	stilb_gpu_range range = {a->mip, 1, a->layer, a->layers > 0 ? a->layers : 1};
	uint32_t count = add_range(
		table, out, (random_access){.resource = a->image, .access = access, .reads = keep, .replaces = !keep}, range);
	if (a->resolve != 0)
		count +=
			add_range(table, out + count,
		              (random_access){.resource = a->resolve, .access = STILB_GPU_ACCESS_RESOLVE, .replaces = true},
		              (stilb_gpu_range){0, 1, 0, 1});
	return count;
}

static stilb_gpu_access access_of(uint32_t how, bool compute)
{
	static const stilb_gpu_access table[STILB_GPU_USE_KINDS][2] = {
		[STILB_GPU_USE_SAMPLED] = {STILB_GPU_ACCESS_SAMPLED_FRAGMENT, STILB_GPU_ACCESS_SAMPLED_COMPUTE},
		[STILB_GPU_USE_STORAGE_READ] = {STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS, STILB_GPU_ACCESS_STORAGE_READ_COMPUTE},
		[STILB_GPU_USE_STORAGE_WRITE] = {STILB_GPU_ACCESS_STORAGE_GRAPHICS, STILB_GPU_ACCESS_STORAGE_COMPUTE},
		[STILB_GPU_USE_STORAGE] = {STILB_GPU_ACCESS_STORAGE_GRAPHICS, STILB_GPU_ACCESS_STORAGE_COMPUTE},
		[STILB_GPU_USE_VERTICES] = {STILB_GPU_ACCESS_VERTICES, STILB_GPU_ACCESS_VERTICES},
		[STILB_GPU_USE_INDIRECT] = {STILB_GPU_ACCESS_INDIRECT, STILB_GPU_ACCESS_INDIRECT},
		[STILB_GPU_USE_COPY_FROM] = {STILB_GPU_ACCESS_COPY_FROM, STILB_GPU_ACCESS_COPY_FROM},
		[STILB_GPU_USE_COPY_TO] = {STILB_GPU_ACCESS_COPY_TO, STILB_GPU_ACCESS_COPY_TO},
		[STILB_GPU_USE_UNIFORM] = {STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS, STILB_GPU_ACCESS_STORAGE_READ_COMPUTE},
		[STILB_GPU_USE_HOST] = {STILB_GPU_ACCESS_HOST, STILB_GPU_ACCESS_HOST},
	};
	return table[how][compute];
}

static stilb_gpu_range range_of(const random_table *table, const stilb_gpu_use *use)
{
	return (stilb_gpu_range){use->mip, (uint8_t)(use->mips > 0 ? use->mips : table->mips[use->resource] - use->mip),
	                         use->layer,
	                         (uint16_t)(use->layers > 0 ? use->layers : table->layers[use->resource] - use->layer)};
}

static uint32_t add_use(const random_table *table, random_access *out, const stilb_gpu_use *use, bool compute)
{
	bool writes_alone = use->how == STILB_GPU_USE_STORAGE_WRITE || use->how == STILB_GPU_USE_COPY_TO;
	return add_range(table, out,
	                 (random_access){.resource = use->resource,
	                                 .access = access_of(use->how, compute),
	                                 .reads = !writes_alone,
	                                 .replaces = use->how == STILB_GPU_USE_COPY_TO && !table->buffer[use->resource],
	                                 .previous = use->previous},
	                 range_of(table, use));
}

uint32_t random_accesses(const random_table *table, const stilb_gpu_pass *pass, random_access *accesses)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < pass->color_count; i++)
		count += add_attachment(table, accesses + count, &pass->color[i], false);
	if (pass->depth.image != 0)
		count += add_attachment(table, accesses + count, &pass->depth, true);
	for (uint32_t i = 0; i < pass->use_count; i++)
		count += add_use(table, accesses + count, &pass->uses[i], pass->kind == STILB_GPU_PASS_DISPATCH);
	return count;
}

/* True, and remembered, if a pass may do this besides what it does already. */
static bool may_touch(builder *b, const random_access *accesses, uint32_t count)
{
	const random_table *table = b->table;
	for (uint32_t i = 0; i < count; i++) {
		const random_access *a = &accesses[i];
		bool writes = stilb_gpu_access_writes(a->access);
		uint32_t sub = a->layer * table->mips[a->resource] + a->mip;
		uint32_t layout = (uint32_t)stilb_gpu_access_layout(a->access, random_kind(table, a->resource)) + 1;
		uint32_t before = b->touched[a->resource][a->previous][sub];
		if (before != 0 && (writes || before == 0x100 || (before != layout && !table->buffer[a->resource])))
			return false;
		if (a->reads && !a->previous && !b->written[a->resource][sub] && random_owned(table, a->resource) == 0)
			return false;
	}
	for (uint32_t i = 0; i < count; i++) {
		const random_access *a = &accesses[i];
		uint32_t layout = (uint32_t)stilb_gpu_access_layout(a->access, random_kind(table, a->resource)) + 1;
		b->touched[a->resource][a->previous][a->layer * table->mips[a->resource] + a->mip] =
			stilb_gpu_access_writes(a->access) ? 0x100 : layout;
	}
	return true;
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

static void try_attachment(builder *b, stilb_gpu_pass *pass, uint32_t r, uint32_t samples, uint32_t mip)
{
	const random_table *table = b->table;
	const stilb_gpu_plan_image_row *row = &table->images[r];
	if (table->buffer[r] || row->shape == STILB_GPU_SHAPE_3D || (row->samples == 4 ? 4u : 1u) != samples ||
	    mip >= table->mips[r])
		return;
	bool depth = row->format == STILB_GPU_D32_F;
	if (depth ? pass->depth.image != 0 : pass->color_count == STILB_GPU_MAX_COLORS)
		return;
	stilb_gpu_attachment a = {.image = (uint16_t)r, .mip = (uint8_t)mip, .layer = (uint16_t)pick(b, table->layers[r])};
	a.load = (uint8_t)pick(b, 3);
	a.read_only = depth && a.load == STILB_GPU_LOAD_KEEP && chance(b, 50);
	uint32_t to = 1 + pick(b, table->resource_count);
	const stilb_gpu_plan_image_row *target = &table->images[to];
	if (samples == 4 && !depth && row->format != STILB_GPU_R32_UI && !table->buffer[to] &&
	    target->format == row->format && target->samples == 0 && target->shape != STILB_GPU_SHAPE_3D)
		a.resolve = (uint16_t)to;
	random_access accesses[4];
	uint32_t count = add_attachment(table, accesses, &a, depth);
	if (!may_touch(b, accesses, count))
		return;
	if (depth)
		pass->depth = a;
	else
		pass->color[pass->color_count++] = a;
}

static void try_use(builder *b, stilb_gpu_pass *pass)
{
	const random_table *table = b->table;
	uint32_t r = 1 + pick(b, table->resource_count), how = pick(b, STILB_GPU_USE_COPY_FROM);
	bool storage = how >= STILB_GPU_USE_STORAGE_READ && how <= STILB_GPU_USE_STORAGE, buffer = table->buffer[r];
	const stilb_gpu_plan_image_row *row = &table->images[r];
	if (buffer ? how == STILB_GPU_USE_SAMPLED : !storage && how != STILB_GPU_USE_SAMPLED)
		return;
	if (how == STILB_GPU_USE_VERTICES && pass->kind != STILB_GPU_PASS_DRAWS)
		return;
	if (how == STILB_GPU_USE_INDIRECT && pass->kind == STILB_GPU_PASS_FULLSCREEN)
		return;
	for (uint32_t i = 0; i < pass->use_count && how == STILB_GPU_USE_INDIRECT; i++)
		if (pass->uses[i].how == how)
			return;
	if (!buffer && storage &&
	    (row->format == STILB_GPU_D32_F || row->format == STILB_GPU_RGBA8_SRGB || row->samples == 4))
		return;
	stilb_gpu_use use = {.resource = (uint16_t)r, .how = (uint8_t)how};
	bool reads = how != STILB_GPU_USE_STORAGE_WRITE && how != STILB_GPU_USE_STORAGE;
	use.previous = reads && random_keeps(table, r) && chance(b, 60);
	if (!buffer && chance(b, 60)) {
		use.mip = (uint8_t)pick(b, table->mips[r]);
		use.mips = (uint8_t)(storage ? 1 : 1 + pick(b, table->mips[r] - use.mip));
		use.layer = (uint16_t)pick(b, table->layers[r]);
		use.layers = (uint16_t)(1 + pick(b, table->layers[r] - use.layer));
	} else if (!buffer && storage) {
		use.mips = 1;
	}
	use.slot = storage && buffer               ? pass->constant_bytes
	           : how == STILB_GPU_USE_INDIRECT ? 0
	           : buffer                        ? 0
	                                           : pass->use_count;
	random_access accesses[RANDOM_SUBS];
	uint32_t count = add_use(table, accesses, &use, pass->kind == STILB_GPU_PASS_DISPATCH);
	if (!may_touch(b, accesses, count))
		return;
	if (storage && buffer)
		pass->constant_bytes = (uint8_t)(pass->constant_bytes + 8);
	if (how == STILB_GPU_USE_INDIRECT)
		pass->groups[0] = pass->groups[1] = pass->groups[2] = 0;
	pass->uses[pass->use_count++] = use;
}

/* True if the pass is a copy that can be. */
static bool try_copy(builder *b, stilb_gpu_pass *pass)
{
	const random_table *table = b->table;
	uint32_t from = 1 + pick(b, table->resource_count), to = 1 + pick(b, table->resource_count);
	stilb_gpu_use in = {.resource = (uint16_t)from, .how = STILB_GPU_USE_COPY_FROM};
	stilb_gpu_use out = {.resource = (uint16_t)to, .how = STILB_GPU_USE_COPY_TO};
	in.previous = random_keeps(table, from) && chance(b, 50);
	const stilb_gpu_plan_image_row *a = &table->images[from], *c = &table->images[to];
	if (table->buffer[from] != table->buffer[to])
		return false;
	if (table->buffer[from]) {
		if (table->buffers[from].bytes > table->buffers[to].bytes)
			return false;
	} else {
		bool filtered =
			random_kind(table, from) == STILB_GPU_FORMAT_COLOR && random_kind(table, to) == STILB_GPU_FORMAT_COLOR;
		if (a->samples == 4 || c->samples == 4 || (a->shape == STILB_GPU_SHAPE_3D) != (c->shape == STILB_GPU_SHAPE_3D))
			return false;
		in.mip = (uint8_t)pick(b, table->mips[from]);
		out.mip = (uint8_t)pick(b, table->mips[to]);
		if (!filtered && (a->format != c->format || in.mip != out.mip))
			return false;
		in.mips = out.mips = 1;
		in.layer = (uint16_t)pick(b, table->layers[from]);
		out.layer = (uint16_t)pick(b, table->layers[to]);
		in.layers = out.layers = 1;
	}
	random_access accesses[2];
	add_use(table, &accesses[0], &in, false);
	add_use(table, &accesses[1], &out, false);
	if ((from == to && in.mip == out.mip && in.layer == out.layer && !in.previous) || !may_touch(b, accesses, 2))
		return false;
	pass->uses[0] = in;
	pass->uses[1] = out;
	pass->use_count = 2;
	return true;
}

static void no_function(void *user)
{
	(void)user;
}

/* True if the pass is a function that uses a buffer. */
static bool try_host(builder *b, stilb_gpu_pass *pass)
{
	for (uint32_t r = 1; r <= b->table->resource_count; r++) {
		random_access access;
		stilb_gpu_use use = {.resource = (uint16_t)r, .how = STILB_GPU_USE_HOST};
		if (!b->table->buffer[r] || random_owned(b->table, r) == 0 || chance(b, 50))
			continue;
		add_use(b->table, &access, &use, false);
		if (may_touch(b, &access, 1))
			pass->uses[pass->use_count++] = use;
	}
	return pass->use_count > 0;
}

static void end_pass(builder *b, const stilb_gpu_pass *pass)
{
	random_access accesses[RANDOM_ACCESSES];
	uint32_t count = random_accesses(b->table, pass, accesses);
	for (uint32_t i = 0; i < count; i++)
		if (stilb_gpu_access_writes(accesses[i].access))
			b->written[accesses[i].resource]
					  [accesses[i].layer * b->table->mips[accesses[i].resource] + accesses[i].mip] = true;
	b->table->passes[b->table->pass_count++] = *pass;
}

static void try_pass(builder *b)
{
	memset(b->touched, 0, sizeof b->touched);
	stilb_gpu_pass pass = {.name = "pass", .kind = (uint8_t)pick(b, STILB_GPU_PASS_KINDS), .program = 1};
	if (pass.kind == STILB_GPU_PASS_COPY) {
		pass.program = 0;
		if (try_copy(b, &pass))
			end_pass(b, &pass);
		return;
	}
	if (pass.kind == STILB_GPU_PASS_HOST) {
		pass.program = 0;
		pass.host = no_function;
		if (try_host(b, &pass))
			end_pass(b, &pass);
		return;
	}
	if (pass.kind == STILB_GPU_PASS_DISPATCH) {
		pass.groups[0] = pass.groups[1] = pass.groups[2] = 1 + pick(b, 3);
	} else {
		uint32_t samples = chance(b, 25) ? 4 : 1, mip = chance(b, 60) ? 0 : pick(b, 3);
		for (uint32_t i = 1 + pick(b, 4); i > 0; i--)
			try_attachment(b, &pass, 1 + pick(b, b->table->resource_count), samples, mip);
		if (pass.color_count == 0 && pass.depth.image == 0)
			return;
	}
	for (uint32_t i = pick(b, 6); i > 0; i--)
		try_use(b, &pass);
	end_pass(b, &pass);
}

/* Outputs must be written. */
static void fill(builder *b, uint32_t r)
{
	const random_table *table = b->table;
	const stilb_gpu_plan_image_row *row = &table->images[r];
	for (uint32_t i = 0; i < RANDOM_SUBS; i++)
		if (b->written[r][i])
			return;
	stilb_gpu_pass pass = {.name = "fill", .kind = STILB_GPU_PASS_DRAWS, .program = 1};
	if (table->buffer[r] || row->shape == STILB_GPU_SHAPE_3D) {
		if (!table->buffer[r] && row->format == STILB_GPU_RGBA8_SRGB) {
			b->table->images[r].output = false; /* only a copy could write it */
			return;
		}
		pass.kind = STILB_GPU_PASS_DISPATCH;
		pass.groups[0] = pass.groups[1] = pass.groups[2] = 1;
		pass.constant_bytes = 8;
		pass.use_count = 1;
		pass.uses[0] = (stilb_gpu_use){
			.resource = (uint16_t)r, .how = STILB_GPU_USE_STORAGE_WRITE, .mips = table->buffer[r] ? 0 : 1};
	} else {
		stilb_gpu_attachment a = {
			.image = (uint16_t)r, .load = STILB_GPU_LOAD_CLEAR, .layers = (uint16_t)table->layers[r]};
		if (row->format == STILB_GPU_D32_F)
			pass.depth = a;
		else
			pass.color[pass.color_count++] = a;
	}
	end_pass(b, &pass);
}

void random_make(random_table *table, uint64_t resources, uint64_t passes)
{
	memset(table, 0, sizeof *table);
	builder b = {.table = table, .seed = resources};
	make_resources(&b);
	b.seed = passes;
	b.index = 0;
	for (uint32_t i = 2 + pick(&b, RANDOM_PASSES - RANDOM_RESOURCES - 1); i > 0; i--)
		try_pass(&b);
	for (uint32_t r = 1; r <= table->resource_count; r++)
		if (random_outputs(table, r) && random_owned(table, r) == 0)
			fill(&b, r);
}

void random_add(const random_table *table, stilb_gpu_plan *plan)
{
	for (uint32_t r = 1; r <= table->resource_count; r++) {
		uint16_t number = table->buffer[r] ? stilb_gpu_plan_buffer(plan, &table->buffers[r])
		                                   : stilb_gpu_plan_image(plan, &table->images[r]);
		if (number != r)
			return; /* told by stilb_gpu_plan_make */
	}
	for (uint32_t i = 0; i < table->pass_count; i++)
		stilb_gpu_plan_pass(plan, &table->passes[i]);
}
