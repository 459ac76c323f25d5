/* A frame that ends with one of its passes, and what is seen of it then. */
#include "render/device/render_images.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the pass ---------------------------------------------------------------------------------------------------- */

/* Index of the row that device->until names: a name comes before a number. UINT32_MAX: there is none. */
static uint32_t until_row(const render_device *device)
{
	uint32_t count = stilb_gpu_plan_passes(device->plan);
	for (uint32_t row = count; row-- > 0;)
		if (strcmp(stilb_gpu_plan_row(device->plan, row)->name, device->until) == 0)
			return row;
	char *end;
	unsigned long number = strtoul(device->until, &end, 10);
	bool digits = device->until[0] >= '0' && device->until[0] <= '9' && *end == '\0';
	return digits && number >= 1 && number <= count ? (uint32_t)number - 1 : UINT32_MAX;
}

/* Sets a message that names the frame's passes. */
static stilb_result until_unknown(const render_device *device)
{
	char names[768] = "";
	size_t used = 0;
	uint32_t count = stilb_gpu_plan_passes(device->plan), row = 0;
	for (; row < count && used + 32 < sizeof names; row++)
		used += (size_t)snprintf(names + used, sizeof names - used, "%s%u %.20s", row > 0 ? ", " : "", row + 1,
		                         stilb_gpu_plan_row(device->plan, row)->name);
	return stilb_fail(STILB_ERROR_ARGUMENT, "there is no pass '%s' for the frame to end with; this frame has %s%s",
	                  device->until, names, row < count ? ", ..." : "");
}

/* ---- what it holds ----------------------------------------------------------------------------------------------- */

static bool until_range_has(stilb_gpu_range range, const stilb_render_shown *shown)
{
	return shown->mip >= range.mip && shown->mip - range.mip < range.mips && shown->layer >= range.layer &&
	       shown->layer - range.layer < range.layers;
}

static bool until_attachment_has(const stilb_gpu_attachment *a, uint16_t image, const stilb_render_shown *shown)
{
	stilb_gpu_range range = {a->mip, 1, a->layer, a->layers > 0 ? a->layers : 1};
	return (a->image == image && !a->read_only && until_range_has(range, shown)) ||
	       (a->resolve == image && until_range_has((stilb_gpu_range){0, 1, 0, 1}, shown));
}

static bool until_use_writes(const stilb_gpu_use *use)
{
	return use->how == STILB_GPU_USE_STORAGE_WRITE || use->how == STILB_GPU_USE_STORAGE ||
	       use->how == STILB_GPU_USE_COPY_TO;
}

/* The pass writes that mip and layer of the image. */
static bool until_writes(const stilb_gpu_plan *plan, uint32_t row, uint16_t image, const stilb_render_shown *shown)
{
	const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, row);
	bool writes = until_attachment_has(&pass->depth, image, shown);
	for (uint32_t c = 0; c < pass->color_count; c++)
		writes = writes || until_attachment_has(&pass->color[c], image, shown);
	for (uint32_t u = 0; u < pass->use_count; u++)
		writes = writes || (pass->uses[u].resource == image && until_use_writes(&pass->uses[u]) &&
		                    until_range_has(stilb_gpu_plan_range(plan, &pass->uses[u]), shown));
	return writes;
}

/* What the pass draws into: its first colour attachment, else its depth, else the first image that it writes. Returns
 * the resource; 0: none. */
static uint16_t until_drawn(const stilb_gpu_plan *plan, const stilb_gpu_pass *pass, stilb_render_shown *shown)
{
	uint32_t first = 0;
	while (first < pass->color_count && pass->color[first].load == STILB_GPU_LOAD_NONE)
		first++;
	const stilb_gpu_attachment *a = first < pass->color_count ? &pass->color[first] : &pass->depth;
	if (a->image != 0 && !a->read_only) {
		shown->mip = a->mip;
		shown->layer = a->layer;
		return a->image;
	}
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const stilb_gpu_use *use = &pass->uses[u];
		if (!until_use_writes(use) || stilb_gpu_plan_extent(plan, use->resource)->format == STILB_GPU_NONE)
			continue;
		shown->mip = use->mip;
		shown->layer = use->layer;
		return use->resource;
	}
	return 0;
}

/* Finds what the picture is to show. *image: the resource; 0: there is none of that name. */
static stilb_result until_find(const render_device *device, uint32_t row, stilb_render_shown *shown, uint16_t *image)
{
	const stilb_gpu_pass *pass = stilb_gpu_plan_row(device->plan, row);
	*shown = device->shown;
	if (shown->name) {
		bool picture = strcmp(shown->name, STILB_RENDER_IMAGE_PICTURE) == 0;
		*image = picture ? device->frame.picture : stilb_gpu_plan_find(device->plan, shown->name);
		if (*image != 0 || !shown->optional)
			return STILB_OK;
	}
	*image = until_drawn(device->plan, pass, shown);
	if (*image == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "pass %u '%s', which the frame ends with, draws into no image; show one by its name (--show)",
		                  row + 1, pass->name);
	shown->name = stilb_gpu_plan_name(device->plan, *image);
	return STILB_OK;
}

stilb_result render_until(render_device *device)
{
	stilb_gpu_plan *plan = device->plan;
	uint32_t row = until_row(device), writer = 0;
	stilb_render_shown shown;
	uint16_t image;
	if (row == UINT32_MAX)
		return until_unknown(device);
	stilb_result result = until_find(device, row, &shown, &image);
	if (result != STILB_OK)
		return result;
	while (image != 0 && writer <= row && !until_writes(plan, writer, image, &shown))
		writer++;
	const stilb_gpu_extent *extent = image != 0 ? stilb_gpu_plan_extent(plan, image) : NULL;
	if (extent && writer > row && shown.mip < extent->mips && shown.layer < extent->layers)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "image '%s' has no content yet after pass %u '%s', which the frame ends with; show another "
		                  "one, or end it later",
		                  shown.name, row + 1, stilb_gpu_plan_row(plan, row)->name);
	stilb_gpu_plan_cut(plan, row);
	return image == device->frame.picture ? STILB_OK : render_show_image(device, &shown);
}
