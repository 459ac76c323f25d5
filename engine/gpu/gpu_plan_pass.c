/* gpu_plan: rows of passes: what is wrong with them, and what each of them touches. That what they read was written
 * before is checked in gpu_plan_live.c. */
#include "gpu/gpu_plan_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* A row while it is checked. */
typedef struct checked {
	stilb_gpu_plan *plan;
	const stilb_gpu_pass *pass;
	uint32_t row;
	gpu_touch *touches;
	uint32_t count;
	/* of the attachments so far; samples 0: none yet */
	uint32_t width, height, layers, samples;
	const char *sized_by; /* the image that they are of */
} checked;

/* Touches of a row at most: colour, resolve, depth, uses. */
#define MOST_TOUCHES (2 * STILB_GPU_MAX_COLORS + 1 + STILB_GPU_MAX_USES)

__attribute__((format(printf, 2, 3))) static stilb_result wrong(const checked *c, const char *format, ...)
{
	char text[800];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	return stilb_fail(STILB_ERROR_ARGUMENT, "pass %u '%s' %s", c->row + 1, c->pass->name, text);
}

static const char *const kind_names[STILB_GPU_PASS_KINDS] = {"draws", "fullscreen", "dispatch", "copy", "host"};

/* "samples", ...: what a use does with its resource. */
static const char *const use_verbs[STILB_GPU_USE_KINDS] = {
	[STILB_GPU_USE_SAMPLED] = "samples",
	[STILB_GPU_USE_STORAGE_READ] = "reads",
	[STILB_GPU_USE_STORAGE_WRITE] = "writes",
	[STILB_GPU_USE_STORAGE] = "reads and writes",
	[STILB_GPU_USE_VERTICES] = "takes vertices from",
	[STILB_GPU_USE_INDIRECT] = "takes commands from",
	[STILB_GPU_USE_COPY_FROM] = "copies from",
	[STILB_GPU_USE_COPY_TO] = "copies to",
	[STILB_GPU_USE_UNIFORM] = "reads",
	[STILB_GPU_USE_HOST] = "reads and writes",
};

const char *gpu_touch_verb(const stilb_gpu_pass *pass, const gpu_touch *touch)
{
	if (touch->role >= GPU_ROLE_USE)
		return use_verbs[pass->uses[touch->role - GPU_ROLE_USE].how];
	if (touch->access == STILB_GPU_ACCESS_RESOLVE)
		return "resolves into";
	if (touch->access == STILB_GPU_ACCESS_DEPTH_READ)
		return "tests against";
	return touch->reads ? "draws over" : "draws into";
}

static bool draws(const stilb_gpu_pass *pass)
{
	return pass->kind == STILB_GPU_PASS_DRAWS || pass->kind == STILB_GPU_PASS_FULLSCREEN;
}

static void touch_add(checked *c, gpu_touch touch)
{
	const gpu_resource *resource = gpu_plan_resource(c->plan, touch.resource);
	const stilb_gpu_extent *extent = &resource->extent;
	touch.layout =
		(uint8_t)(resource->buffer
	                  ? STILB_GPU_LAYOUT_NONE
	                  : stilb_gpu_access_layout(touch.access, stilb_gpu_format_describe(extent->format)->kind));
	touch.use = touch.role >= GPU_ROLE_USE ? (uint16_t)(1u << c->pass->uses[touch.role - GPU_ROLE_USE].how)
	                                       : (uint16_t)STILB_GPU_EXTENT_ATTACHMENT;
	touch.queue = (uint8_t)c->pass->queue;
	touch.owned = resource->image.owned != 0;
	touch.partial = touch.range.mips != extent->mips || touch.range.layers != extent->layers;
	c->touches[c->count] = touch;
	c->count++;
}

/* ---- what belongs to a kind of pass ------------------------------------------------------------------------------ */

static const stilb_gpu_use *use_of(const stilb_gpu_pass *pass, stilb_gpu_use_kind how)
{
	for (uint32_t i = 0; i < pass->use_count; i++)
		if (pass->uses[i].how == how)
			return &pass->uses[i];
	return NULL;
}

static stilb_result check_counts(const checked *c)
{
	const stilb_gpu_pass *pass = c->pass;
	if (pass->kind >= STILB_GPU_PASS_KINDS)
		return wrong(c, "has the kind %u: it is none of stilb_gpu_pass_kind", pass->kind);
	if (pass->color_count > STILB_GPU_MAX_COLORS)
		return wrong(c, "has %u colour attachments: %u are the most", pass->color_count, STILB_GPU_MAX_COLORS);
	if (pass->use_count > STILB_GPU_MAX_USES)
		return wrong(c, "has %u uses: %u are the most", pass->use_count, STILB_GPU_MAX_USES);
	if (pass->constant_bytes > STILB_GPU_MAX_CONSTANTS || pass->constant_bytes % 4 != 0)
		return wrong(c, "has %u bytes of constants: give a multiple of 4, at most %u", pass->constant_bytes,
		             STILB_GPU_MAX_CONSTANTS);
	return STILB_OK;
}

static stilb_result check_groups(const checked *c)
{
	const uint32_t *groups = c->pass->groups;
	bool none = groups[0] == 0 && groups[1] == 0 && groups[2] == 0;
	if (c->pass->kind != STILB_GPU_PASS_DISPATCH)
		return none ? STILB_OK
		            : wrong(c, "is of kind %s and has groups: they are a dispatch's", kind_names[c->pass->kind]);
	bool indirect = use_of(c->pass, STILB_GPU_USE_INDIRECT);
	if (none && !indirect)
		return wrong(c, "dispatches no groups: give three counts, or a buffer with them as an INDIRECT use");
	if (!none && indirect)
		return wrong(c, "has groups, %u x %u x %u, and an INDIRECT use: only one of both counts", groups[0], groups[1],
		             groups[2]);
	if (!none && (groups[0] == 0 || groups[1] == 0 || groups[2] == 0))
		return wrong(c, "dispatches %u x %u x %u groups, which are none: each count is at least 1", groups[0],
		             groups[1], groups[2]);
	return STILB_OK;
}

static stilb_result check_kind(const checked *c)
{
	const stilb_gpu_pass *pass = c->pass;
	const char *kind = kind_names[pass->kind];
	bool attached = pass->depth.image != 0;
	for (uint32_t i = 0; i < pass->color_count; i++)
		attached |= !gpu_attachment_is_none(&pass->color[i]);
	if (draws(pass) && !attached)
		return wrong(c, "draws into nothing: give it a colour or depth attachment, or make it a dispatch");
	if (!draws(pass) && attached)
		return wrong(c, "is of kind %s and has attachments: only draws and fullscreen passes have", kind);
	bool programless = pass->kind == STILB_GPU_PASS_COPY || pass->kind == STILB_GPU_PASS_HOST;
	if (programless && pass->program != 0)
		return wrong(c, "is of kind %s and has a program: leave it 0", kind);
	if ((pass->kind == STILB_GPU_PASS_FULLSCREEN || pass->kind == STILB_GPU_PASS_DISPATCH) && pass->program == 0)
		return wrong(c, "is of kind %s and has no program", kind);
	if (programless && pass->constant_bytes > 0)
		return wrong(c, "is of kind %s and has constants: leave them out", kind);
	if ((pass->kind == STILB_GPU_PASS_HOST) == !pass->host)
		return wrong(c, "is of kind %s and has %s function: passes of kind host have one, and no others do", kind,
		             pass->host ? "a" : "no");
	static const char *const queues[STILB_GPU_QUEUES] = {"main", "compute", "copy"};
	bool fits = pass->queue == STILB_GPU_QUEUE_MAIN || pass->kind == STILB_GPU_PASS_COPY ||
	            (pass->queue == STILB_GPU_QUEUE_COMPUTE && pass->kind == STILB_GPU_PASS_DISPATCH);
	if (pass->queue >= STILB_GPU_QUEUES)
		return wrong(c, "has the queue %u: it is none of stilb_gpu_queue", pass->queue);
	if (!fits)
		return wrong(c, "is of kind %s and on the queue %s, which has none: leave it on the main queue", kind,
		             queues[pass->queue]);
	return check_groups(c);
}

/* ---- attachments ------------------------------------------------------------------------------------------------- */

/* The image of an attachment. NULL: there is none, and the message is stored. */
static const gpu_resource *find_image(const checked *c, uint32_t number, const char *what)
{
	if (number == 0) {
		wrong(c, "has a %s without an image", what);
		return NULL;
	}
	if (number > c->plan->resource_count) {
		wrong(c, "has resource %u as %s, and the plan has %u: numbers are those of this frame's rows", number, what,
		      c->plan->resource_count);
		return NULL;
	}
	const gpu_resource *resource = gpu_plan_resource(c->plan, number);
	if (!resource->buffer)
		return resource;
	wrong(c, "has the buffer '%s' as %s, which is an image", resource->name, what);
	return NULL;
}

/* All attachments of a pass have one size, and all but resolves one number of samples. */
static stilb_result check_alike(checked *c, const gpu_resource *resource, uint32_t mip, uint32_t layers, bool resolve)
{
	const stilb_gpu_extent *extent = &resource->extent;
	uint32_t width = gpu_mip_side(extent->width, mip), height = gpu_mip_side(extent->height, mip);
	if (c->samples == 0) {
		c->width = width, c->height = height, c->layers = layers, c->samples = extent->samples;
		c->sized_by = resource->name;
		return STILB_OK;
	}
	if (width != c->width || height != c->height)
		return wrong(c,
		             "draws into '%s' of %u x %u texels and into '%s' of %u x %u: attachments of a pass have one size",
		             c->sized_by, c->width, c->height, resource->name, width, height);
	if (layers != c->layers)
		return wrong(
			c, "draws into %u layers of '%s' and into %u of '%s': attachments of a pass have one number of layers",
			c->layers, c->sized_by, layers, resource->name);
	if (!resolve && extent->samples != c->samples)
		return wrong(
			c, "draws into '%s' with %u samples a texel and into '%s' with %u: attachments of a pass have one number",
			c->sized_by, c->samples, resource->name, extent->samples);
	return STILB_OK;
}

static stilb_result check_attachment(checked *c, const stilb_gpu_attachment *attachment, const char *what,
                                     const gpu_resource *resource)
{
	const stilb_gpu_extent *extent = &resource->extent;
	uint32_t layers = attachment->layers > 0 ? attachment->layers : 1;
	if (extent->shape == STILB_GPU_SHAPE_3D)
		return wrong(c, "has the 3-D image '%s' as %s: write it by a dispatch", resource->name, what);
	if (attachment->load > STILB_GPU_LOAD_CLEAR_AREA)
		return wrong(c, "loads '%s' by %u: it is none of stilb_gpu_load", resource->name, attachment->load);
	if (attachment->mip >= extent->mips)
		return wrong(c, "draws into mip %u of '%s', which has %u", attachment->mip, resource->name, extent->mips);
	if (attachment->layer + layers > extent->layers)
		return wrong(c, "draws into layers %u to %u of '%s', which has %u", attachment->layer,
		             attachment->layer + layers - 1, resource->name, extent->layers);
	return check_alike(c, resource, attachment->mip, layers, false);
}

static void touch_attachment(checked *c, const stilb_gpu_attachment *attachment, stilb_gpu_access access, uint32_t role)
{
	bool stays = attachment->load == STILB_GPU_LOAD_KEEP || attachment->load == STILB_GPU_LOAD_CLEAR_AREA;
	touch_add(c, (gpu_touch){
					 .resource = attachment->image,
					 .access = (uint8_t)access,
					 .reads = stays,
					 .writes = access != STILB_GPU_ACCESS_DEPTH_READ,
					 .replaces = !stays,
					 .range = {attachment->mip, 1, attachment->layer, attachment->layers > 0 ? attachment->layers : 1},
					 .role = (uint8_t)role,
				 });
}

static stilb_result check_resolve(checked *c, const stilb_gpu_attachment *color, uint32_t index)
{
	const gpu_resource *to = find_image(c, color->resolve, "resolve");
	if (!to)
		return STILB_ERROR_ARGUMENT;
	const gpu_resource *from = gpu_plan_resource(c->plan, color->image);
	if (from->extent.samples == 1)
		return wrong(c, "resolves '%s', which has one sample a texel: leave the resolve out, or give it more",
		             from->name);
	if (to->extent.samples != 1)
		return wrong(c, "resolves '%s' into '%s', which has %u samples a texel: it must have one", from->name, to->name,
		             to->extent.samples);
	if (to->extent.format != from->extent.format)
		return wrong(c, "resolves '%s' of format %s into '%s' of format %s: they must have one format", from->name,
		             stilb_gpu_format_describe(from->extent.format)->name, to->name,
		             stilb_gpu_format_describe(to->extent.format)->name);
	if (stilb_gpu_format_describe(to->extent.format)->kind == STILB_GPU_FORMAT_INTEGER)
		return wrong(c, "resolves '%s' of format %s: integers have no mean", from->name,
		             stilb_gpu_format_describe(to->extent.format)->name);
	if (c->layers > 1)
		return wrong(c, "resolves %u layers of '%s': only one can be resolved", c->layers, from->name);
	if (to->extent.shape == STILB_GPU_SHAPE_3D)
		return wrong(c, "resolves '%s' into the 3-D image '%s': it must be 2-D", from->name, to->name);
	stilb_result result = check_alike(c, to, 0, 1, true);
	if (result == STILB_OK)
		touch_add(c, (gpu_touch){.resource = color->resolve,
		                         .access = STILB_GPU_ACCESS_RESOLVE,
		                         .writes = true,
		                         .replaces = true,
		                         .range = {0, 1, 0, 1},
		                         .role = (uint8_t)(GPU_ROLE_RESOLVE + index)});
	return result;
}

static stilb_result check_colors(checked *c)
{
	for (uint32_t i = 0; i < c->pass->color_count; i++) {
		const stilb_gpu_attachment *color = &c->pass->color[i];
		if (gpu_attachment_is_none(color))
			continue;
		const gpu_resource *resource = find_image(c, color->image, "colour attachment");
		if (!resource)
			return STILB_ERROR_ARGUMENT;
		const stilb_gpu_format_info *format = stilb_gpu_format_describe(resource->extent.format);
		if (format->kind == STILB_GPU_FORMAT_DEPTH || format->block_side > 1)
			return wrong(c, "has '%s' as colour attachment, whose format %s is %s", resource->name, format->name,
			             format->block_side > 1 ? "compressed" : "one of depths");
		if (color->read_only)
			return wrong(c, "has '%s' as read-only colour attachment: only depth can be; sample it instead",
			             resource->name);
		stilb_result result = check_attachment(c, color, "colour attachment", resource);
		if (result != STILB_OK)
			return result;
		touch_attachment(c, color, STILB_GPU_ACCESS_COLOR, i);
		if (color->resolve != 0)
			result = check_resolve(c, color, i);
		if (result != STILB_OK)
			return result;
	}
	return STILB_OK;
}

static stilb_result check_depth(checked *c)
{
	const stilb_gpu_attachment *depth = &c->pass->depth;
	if (depth->image == 0)
		return STILB_OK;
	const gpu_resource *resource = find_image(c, depth->image, "depth attachment");
	if (!resource)
		return STILB_ERROR_ARGUMENT;
	const stilb_gpu_format_info *format = stilb_gpu_format_describe(resource->extent.format);
	if (format->kind != STILB_GPU_FORMAT_DEPTH)
		return wrong(c, "has '%s' as depth attachment, whose format %s is none of depths: take d32_f or d16",
		             resource->name, format->name);
	if (depth->resolve != 0)
		return wrong(c, "resolves the depths of '%s', which have no mean", resource->name);
	stilb_result result = check_attachment(c, depth, "depth attachment", resource);
	if (result != STILB_OK)
		return result;
	if (depth->read_only && depth->load != STILB_GPU_LOAD_KEEP)
		return wrong(c, "has '%s' as read-only depth attachment and does not keep what it holds", resource->name);
	touch_attachment(c, depth, depth->read_only ? STILB_GPU_ACCESS_DEPTH_READ : STILB_GPU_ACCESS_DEPTH, GPU_ROLE_DEPTH);
	return STILB_OK;
}

static stilb_result check_area(const checked *c)
{
	const uint16_t *a = c->pass->area;
	if ((a[0] | a[1] | a[2] | a[3]) == 0)
		return STILB_OK;
	if (!draws(c->pass))
		return wrong(c, "is of kind %s and has an area: only draws and fullscreen passes have",
		             kind_names[c->pass->kind]);
	if (a[2] == 0 || a[3] == 0)
		return wrong(c, "fills %u x %u texels at %u, %u: give it sides above 0, or four zeros for all", a[2], a[3],
		             a[0], a[1]);
	if ((uint32_t)a[0] + a[2] > c->width || (uint32_t)a[1] + a[3] > c->height)
		return wrong(c, "fills %u x %u texels at %u, %u, and '%s' has %u x %u: make it smaller", a[2], a[3], a[0], a[1],
		             c->sized_by, c->width, c->height);
	return STILB_OK;
}

/* ---- uses -------------------------------------------------------------------------------------------------------- */

/* Which kinds of pass can have a use: bit by stilb_gpu_pass_kind. */
static const uint8_t use_passes[STILB_GPU_USE_KINDS] = {
	[STILB_GPU_USE_SAMPLED] = 7,   [STILB_GPU_USE_STORAGE_READ] = 7, [STILB_GPU_USE_STORAGE_WRITE] = 7,
	[STILB_GPU_USE_STORAGE] = 7,   [STILB_GPU_USE_VERTICES] = 1,     [STILB_GPU_USE_INDIRECT] = 5,
	[STILB_GPU_USE_COPY_FROM] = 8, [STILB_GPU_USE_COPY_TO] = 8,      [STILB_GPU_USE_UNIFORM] = 7,
	[STILB_GPU_USE_HOST] = 16,
};

static bool is_storage(const stilb_gpu_use *use)
{
	return use->how == STILB_GPU_USE_STORAGE || use->how == STILB_GPU_USE_STORAGE_READ ||
	       use->how == STILB_GPU_USE_STORAGE_WRITE;
}

static bool use_reads(const stilb_gpu_use *use)
{
	return use->how != STILB_GPU_USE_STORAGE_WRITE && use->how != STILB_GPU_USE_COPY_TO;
}

static bool use_writes(const stilb_gpu_use *use)
{
	return use->how == STILB_GPU_USE_STORAGE || use->how == STILB_GPU_USE_HOST || !use_reads(use);
}

static stilb_gpu_access use_access(const stilb_gpu_use *use, bool compute)
{
	switch ((stilb_gpu_use_kind)use->how) {
	case STILB_GPU_USE_SAMPLED:
		return compute ? STILB_GPU_ACCESS_SAMPLED_COMPUTE : STILB_GPU_ACCESS_SAMPLED_FRAGMENT;
	case STILB_GPU_USE_STORAGE_READ:
	case STILB_GPU_USE_UNIFORM:
		return compute ? STILB_GPU_ACCESS_STORAGE_READ_COMPUTE : STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS;
	case STILB_GPU_USE_STORAGE_WRITE:
	case STILB_GPU_USE_STORAGE:
		return compute ? STILB_GPU_ACCESS_STORAGE_COMPUTE : STILB_GPU_ACCESS_STORAGE_GRAPHICS;
	case STILB_GPU_USE_VERTICES:
		return STILB_GPU_ACCESS_VERTICES;
	case STILB_GPU_USE_INDIRECT:
		return STILB_GPU_ACCESS_INDIRECT;
	case STILB_GPU_USE_COPY_FROM:
		return STILB_GPU_ACCESS_COPY_FROM;
	case STILB_GPU_USE_HOST:
		return STILB_GPU_ACCESS_HOST;
	default:
		return STILB_GPU_ACCESS_COPY_TO;
	}
}

stilb_gpu_range stilb_gpu_plan_range(const stilb_gpu_plan *plan, const stilb_gpu_use *use)
{
	STILB_ASSERT(plan && use && use->resource > 0 && use->resource <= plan->resource_count);
	const stilb_gpu_extent *extent = &gpu_plan_resource(plan, use->resource)->extent;
	return (stilb_gpu_range){
		.mip = use->mip,
		.mips = (uint8_t)(use->mips > 0 ? use->mips : extent->mips - use->mip),
		.layer = use->layer,
		.layers = (uint16_t)(use->layers > 0 ? use->layers : extent->layers - use->layer),
	};
}

static stilb_result check_use_range(const checked *c, const stilb_gpu_use *use, const gpu_resource *resource)
{
	const stilb_gpu_extent *extent = &resource->extent;
	const char *verb = use_verbs[use->how], *name = resource->name;
	if (resource->buffer) {
		if (use->mip != 0 || use->mips != 0 || use->layer != 0 || use->layers != 0)
			return wrong(c, "%s mips or layers of the buffer '%s', which has none", verb, name);
		return STILB_OK;
	}
	uint32_t mips = use->mips > 0 ? use->mips : 1, layers = use->layers > 0 ? use->layers : 1;
	if (use->mip + mips > extent->mips)
		return wrong(c, "%s mips %u to %u of '%s', which has %u", verb, use->mip, use->mip + mips - 1, name,
		             extent->mips);
	if (use->layer + layers > extent->layers)
		return wrong(c, "%s layers %u to %u of '%s', which has %u", verb, use->layer, use->layer + layers - 1, name,
		             extent->layers);
	return STILB_OK;
}

static stilb_result check_storage_image(const checked *c, const stilb_gpu_use *use, const gpu_resource *resource)
{
	const stilb_gpu_format_info *format = stilb_gpu_format_describe(resource->extent.format);
	const char *verb = use_verbs[use->how], *name = resource->name;
	bool srgb = strstr(format->name, "srgb");
	if (format->kind == STILB_GPU_FORMAT_DEPTH || srgb || format->block_side > 1)
		return wrong(c, "%s '%s' as a storage image, whose format %s is %s%s", verb, name, format->name,
		             format->block_side > 1 ? "compressed"
		             : srgb                 ? "sRGB"
		                                    : "one of depths",
		             use_reads(use) && !use_writes(use) ? ": sample it instead" : ": take another, or draw into it");
	if (resource->extent.samples > 1)
		return wrong(c, "%s '%s' as a storage image, which has %u samples a texel: one is all it can have", verb, name,
		             resource->extent.samples);
	if (stilb_gpu_plan_range(c->plan, use).mips != 1)
		return wrong(c, "%s %u mips of '%s' as one storage image: each is a use of its own, set mips to 1", verb,
		             stilb_gpu_plan_range(c->plan, use).mips, name);
	return STILB_OK;
}

static stilb_result check_buffer_slot(const checked *c, const stilb_gpu_use *use, const gpu_resource *resource)
{
	const char *verb = use_verbs[use->how], *name = resource->name;
	uint64_t end = (uint64_t)use->first + (use->bytes > 0 ? use->bytes : 1);
	if (use->how != STILB_GPU_USE_UNIFORM && (use->first | use->bytes) != 0)
		return wrong(c, "%s bytes %u + %u of '%s': only uniform buffers are parts", verb, use->first, use->bytes, name);
	if (use->how == STILB_GPU_USE_UNIFORM && end > resource->bytes)
		return wrong(c, "%s bytes %u + %u of '%s' as a uniform buffer, which has %llu", verb, use->first, use->bytes,
		             name, (unsigned long long)resource->bytes);
	if (is_storage(use)) {
		if (use->slot == STILB_GPU_NO_SLOT)
			return STILB_OK;
		if (use->slot % 8 != 0 || use->slot + 8 > c->pass->constant_bytes)
			return wrong(c, "%s '%s' by an address at byte %u of %u bytes of constants: it takes 8, at a multiple of 8",
			             verb, name, use->slot, c->pass->constant_bytes);
	} else if (use->how == STILB_GPU_USE_INDIRECT) {
		uint32_t bytes = c->pass->kind == STILB_GPU_PASS_DISPATCH ? 12 : 20;
		if (use->slot % 4 != 0 || use->slot + bytes > resource->bytes)
			return wrong(c, "%s byte %u of '%s', which has %llu: it needs %u there, at a multiple of 4", verb,
			             use->slot, name, (unsigned long long)resource->bytes, bytes);
	} else if (use->how != STILB_GPU_USE_UNIFORM && use->slot != 0) {
		return wrong(c, "%s '%s' with the slot %u, which says nothing here: leave it 0", verb, name, use->slot);
	}
	return STILB_OK;
}

/* What a use's kind asks of its resource. */
static stilb_result check_use_kind(const checked *c, const stilb_gpu_use *use, const gpu_resource *resource)
{
	const char *verb = use_verbs[use->how], *name = resource->name;
	if (!(use_passes[use->how] & 1u << c->pass->kind))
		return wrong(c, "%s '%s', which no pass of kind %s does", verb, name, kind_names[c->pass->kind]);
	if (resource->buffer && use->how == STILB_GPU_USE_SAMPLED)
		return wrong(c, "samples the buffer '%s': only images are sampled", name);
	bool of_buffers = use->how == STILB_GPU_USE_VERTICES || use->how == STILB_GPU_USE_INDIRECT ||
	                  use->how == STILB_GPU_USE_UNIFORM || use->how == STILB_GPU_USE_HOST;
	if (!resource->buffer && of_buffers)
		return wrong(c, "%s the image '%s': it must be a buffer", verb, name);
	if (use->how == STILB_GPU_USE_HOST && resource->image.owned == 0)
		return wrong(c, "%s '%s', which is the plan's own: give it a buffer of the program's (owned)", verb, name);
	if (use->sampler != 0 && use->how != STILB_GPU_USE_SAMPLED)
		return wrong(c, "%s '%s' with a sampler, which only sampled images have", verb, name);
	if (use->previous && !resource->image.keep)
		return wrong(c, "reads last frame's '%s', which is not kept: set keep in its row", name);
	if (use->previous && use_writes(use))
		return wrong(c, "%s last frame's '%s', which can only be read", verb, name);
	stilb_result result = check_use_range(c, use, resource);
	if (result == STILB_OK && !resource->buffer && is_storage(use))
		result = check_storage_image(c, use, resource);
	if (result == STILB_OK && resource->buffer)
		result = check_buffer_slot(c, use, resource);
	return result;
}

/* A program's binding, or a place among the constants, is taken once. */
static stilb_result check_slots(const checked *c, uint32_t index)
{
	const stilb_gpu_use *use = &c->pass->uses[index];
	const gpu_resource *resource = gpu_plan_resource(c->plan, use->resource);
	for (uint32_t i = 0; i < index; i++) {
		const stilb_gpu_use *other = &c->pass->uses[i];
		const gpu_resource *before = gpu_plan_resource(c->plan, other->resource);
		bool sampled = use->how == STILB_GPU_USE_SAMPLED && other->how == STILB_GPU_USE_SAMPLED;
		bool uniform = use->how == STILB_GPU_USE_UNIFORM && other->how == STILB_GPU_USE_UNIFORM;
		bool storage = is_storage(use) && is_storage(other) && resource->buffer == before->buffer;
		bool bound = sampled || uniform || (storage && use->slot != STILB_GPU_NO_SLOT);
		if (bound && use->slot == other->slot)
			return wrong(c, "has '%s' and '%s' at the slot %u: each has one of its own", before->name, resource->name,
			             use->slot);
		if (use->how == STILB_GPU_USE_INDIRECT && other->how == STILB_GPU_USE_INDIRECT)
			return wrong(c, "takes commands from '%s' and from '%s': only one can be", before->name, resource->name);
	}
	return STILB_OK;
}

static stilb_result check_uses(checked *c)
{
	bool compute = c->pass->kind == STILB_GPU_PASS_DISPATCH;
	for (uint32_t i = 0; i < c->pass->use_count; i++) {
		const stilb_gpu_use *use = &c->pass->uses[i];
		if (use->resource == 0 || use->resource > c->plan->resource_count)
			return wrong(c, "uses resource %u, and the plan has 1 to %u: numbers are those of this frame's rows",
			             use->resource, c->plan->resource_count);
		if (use->how >= STILB_GPU_USE_KINDS)
			return wrong(c, "uses '%s' by %u: it is none of stilb_gpu_use_kind",
			             gpu_plan_resource(c->plan, use->resource)->name, use->how);
		const gpu_resource *resource = gpu_plan_resource(c->plan, use->resource);
		stilb_result result = check_use_kind(c, use, resource);
		if (result == STILB_OK)
			result = check_slots(c, i);
		if (result != STILB_OK)
			return result;
		touch_add(c, (gpu_touch){
						 .resource = use->resource,
						 .access = (uint8_t)use_access(use, compute),
						 .reads = use_reads(use) && !use->previous,
						 .writes = use_writes(use),
						 .replaces = use->how == STILB_GPU_USE_COPY_TO && !resource->buffer,
						 .previous = use->previous,
						 .range = stilb_gpu_plan_range(c->plan, use),
						 .role = (uint8_t)(GPU_ROLE_USE + i),
					 });
	}
	return STILB_OK;
}

/* ---- copies ------------------------------------------------------------------------------------------------------ */

/* Bytes of a range of an image's texels, tightly packed. */
static uint64_t range_bytes(const stilb_gpu_extent *extent, stilb_gpu_range range)
{
	uint64_t bytes = 0;
	for (uint32_t mip = range.mip; mip < (uint32_t)range.mip + range.mips; mip++)
		bytes += stilb_gpu_format_bytes(extent->format, gpu_mip_side(extent->width, mip),
		                                gpu_mip_side(extent->height, mip), gpu_mip_side(extent->depth, mip));
	return bytes * range.layers;
}

static stilb_result check_copy_images(const checked *c, const gpu_touch *from, const gpu_touch *to)
{
	const gpu_resource *source = gpu_plan_resource(c->plan, from->resource);
	const gpu_resource *target = gpu_plan_resource(c->plan, to->resource);
	const stilb_gpu_extent *a = &source->extent, *b = &target->extent;
	if (from->range.mips != to->range.mips || from->range.layers != to->range.layers)
		return wrong(c, "copies %u mips and %u layers of '%s' to %u mips and %u layers of '%s': they must be as many",
		             from->range.mips, from->range.layers, source->name, to->range.mips, to->range.layers,
		             target->name);
	if ((a->shape == STILB_GPU_SHAPE_3D) != (b->shape == STILB_GPU_SHAPE_3D))
		return wrong(c, "copies between '%s' and '%s', of which only one is 3-D", source->name, target->name);
	bool same = a->format == b->format;
	for (uint32_t i = 0; i < from->range.mips; i++) {
		uint32_t m = from->range.mip + i, n = to->range.mip + i;
		same = same && gpu_mip_side(a->width, m) == gpu_mip_side(b->width, n) &&
		       gpu_mip_side(a->height, m) == gpu_mip_side(b->height, n) &&
		       gpu_mip_side(a->depth, m) == gpu_mip_side(b->depth, n);
	}
	const stilb_gpu_format_info *in = stilb_gpu_format_describe(a->format), *out = stilb_gpu_format_describe(b->format);
	if (!same && (in->kind != STILB_GPU_FORMAT_COLOR || out->kind != STILB_GPU_FORMAT_COLOR || in->block_side > 1 ||
	              out->block_side > 1))
		return wrong(
			c,
			"copies '%s' of format %s to '%s' of format %s, of another size or format, which takes a filter: it "
			"has none for depths, integers and compressed formats",
			source->name, in->name, target->name, out->name);
	return STILB_OK;
}

static stilb_result check_copy(const checked *c)
{
	const stilb_gpu_use *from = use_of(c->pass, STILB_GPU_USE_COPY_FROM);
	const stilb_gpu_use *to = use_of(c->pass, STILB_GPU_USE_COPY_TO);
	if (!from || !to || c->pass->use_count != 2)
		return wrong(c, "copies by %u uses: it must have two, COPY_FROM and COPY_TO", c->pass->use_count);
	const gpu_touch *in = &c->touches[from == &c->pass->uses[0] ? 0 : 1];
	const gpu_touch *out = &c->touches[to == &c->pass->uses[0] ? 0 : 1];
	const gpu_resource *source = gpu_plan_resource(c->plan, from->resource);
	const gpu_resource *target = gpu_plan_resource(c->plan, to->resource);
	const gpu_resource *many = source->extent.samples > 1 ? source : target->extent.samples > 1 ? target : NULL;
	if (many)
		return wrong(c, "copies '%s', which has %u samples a texel: resolve it instead", many->name,
		             many->extent.samples);
	if (!source->buffer && !target->buffer)
		return check_copy_images(c, in, out);
	uint64_t taken = source->buffer ? source->bytes : range_bytes(&source->extent, in->range);
	uint64_t room = target->buffer ? target->bytes : range_bytes(&target->extent, out->range);
	bool fits = source->buffer && !target->buffer ? taken >= room : taken <= room;
	if (!fits)
		return wrong(c, "copies '%s' of %llu bytes to '%s' of %llu: the buffer is too small", source->name,
		             (unsigned long long)taken, target->name, (unsigned long long)room);
	return STILB_OK;
}

/* ---- all passes -------------------------------------------------------------------------------------------------- */

static stilb_result check_pass(checked *c)
{
	if (!c->pass->name || c->pass->name[0] == '\0')
		return stilb_fail(STILB_ERROR_ARGUMENT, "pass %u has no name", c->row + 1);
	stilb_result result = check_counts(c);
	result = result == STILB_OK ? check_kind(c) : result;
	result = result == STILB_OK ? check_colors(c) : result;
	result = result == STILB_OK ? check_depth(c) : result;
	result = result == STILB_OK ? check_area(c) : result;
	result = result == STILB_OK ? check_uses(c) : result;
	if (result == STILB_OK && c->pass->kind == STILB_GPU_PASS_COPY)
		result = check_copy(c);
	return result;
}

/* Member by member but for what gpu_plan_live.c fills in. */
static bool same_touch(const gpu_touch *a, const gpu_touch *b)
{
	return a->resource == b->resource && a->access == b->access && a->layout == b->layout && a->reads == b->reads &&
	       a->writes == b->writes && a->replaces == b->replaces && a->previous == b->previous && a->role == b->role &&
	       a->use == b->use && a->queue == b->queue && a->range.mip == b->range.mip && a->range.mips == b->range.mips &&
	       a->range.layer == b->range.layer && a->range.layers == b->range.layers;
}

/* Puts a row's touches where its span says, or at the end of all. *same: becomes false if they are others than before.
 */
static void set_touches(stilb_gpu_plan *plan, gpu_span *span, const gpu_touch *touches, uint32_t count, bool *same)
{
	gpu_touch *before = (gpu_touch *)plan->touches.items + span->first;
	bool equal = span->count == count;
	for (uint32_t i = 0; i < count && equal; i++)
		equal = same_touch(&before[i], &touches[i]);
	*same = *same && equal;
	if (equal)
		return;
	*span = (gpu_span){.first = plan->touch_count, .count = count};
	memcpy((gpu_touch *)plan->touches.items + span->first, touches, count * sizeof *touches);
	plan->touch_count += count;
}

/* Forgets all touches: they are of other resources, or too many are of rows as they were. */
static void forget_touches(stilb_gpu_plan *plan)
{
	gpu_span *spans = plan->spans.items;
	uint32_t used = 0;
	for (uint32_t row = 0; row < plan->row_count; row++)
		used += spans[row].count;
	if (!plan->changed && plan->touch_count <= 2 * used + 512)
		return;
	plan->touch_count = 0;
	memset(spans, 0, plan->row_count * sizeof *spans);
}

stilb_result gpu_plan_check_passes(stilb_gpu_plan *plan, bool *same)
{
	*same = !plan->changed && plan->row_count == plan->rows_known;
	if (plan->row_count > 0)
		forget_touches(plan);
	gpu_span *spans = plan->spans.items;
	for (uint32_t row = 0; row < plan->row_count; row++) {
		if (spans[row].checked)
			continue;
		if (!gpu_array_reserve(&plan->touches, plan->touch_count + MOST_TOUCHES, sizeof(gpu_touch)))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for a plan of %u passes", plan->row_count);
		gpu_touch touches[MOST_TOUCHES];
		checked c = {.plan = plan, .pass = gpu_plan_row(plan, row), .row = row, .touches = touches};
		stilb_result result = check_pass(&c);
		if (result != STILB_OK)
			return result;
		set_touches(plan, &spans[row], touches, c.count, same);
		spans[row].checked = true;
		spans[row].asked = false;
	}
	return STILB_OK;
}
