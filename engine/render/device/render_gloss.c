/* A panorama on the device: the table of its light, which shaders read by address, and the images of that, of its gloss
 * and of its texels, which are sent once it is complete. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- gloss ------------------------------------------------------------------------------------------------------- */

static stilb_result gloss_image(render_device *device, const char *name, stilb_gpu_extent extent,
                                stilb_gpu_image *image)
{
	extent.depth = 1;
	extent.samples = 1;
	extent.uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO;
	stilb_gpu_image_desc desc = {.name = name, .extent = extent};
	return image->id != 0 ? STILB_OK : stilb_gpu_image_create(device->gpu, &desc, image);
}

static stilb_result gloss_make(render_device *device)
{
	stilb_gpu_sampler_desc smooth = {.linear = true, .mip_linear = true, .mips = true};
	stilb_gpu_extent cube = {.format = STILB_GPU_RGBA16_F,
	                         .shape = STILB_GPU_SHAPE_CUBE,
	                         .width = RENDER_PANORAMA_FACE,
	                         .height = RENDER_PANORAMA_FACE,
	                         .layers = 6,
	                         .mips = RENDER_PANORAMA_MIPS};
	stilb_gpu_extent dfg = {.format = STILB_GPU_RG16_F,
	                        .width = RENDER_PANORAMA_DFG,
	                        .height = RENDER_PANORAMA_DFG,
	                        .layers = 1,
	                        .mips = 1};
	stilb_gpu_extent light = {.format = STILB_GPU_RGBA32_F,
	                          .width = RENDER_PANORAMA_COLUMNS,
	                          .height = RENDER_PANORAMA_ROWS,
	                          .layers = 1,
	                          .mips = 1};
	stilb_result result = stilb_gpu_sampler_get(device->gpu, &smooth, &device->cube_sampler);
	if (result == STILB_OK)
		result = gloss_image(device, "panorama cube", cube, &device->next_cube);
	if (result == STILB_OK)
		result = gloss_image(device, "panorama light", light, &device->next_light);
	return result == STILB_OK ? gloss_image(device, "gloss table", dfg, &device->dfg) : result;
}

/* Sends a mip of a layer: texels, size bytes each. */
static stilb_result gloss_send(render_device *device, stilb_gpu_upload to, size_t size, const void *from)
{
	to.depth = 1;
	to.bytes = (uint64_t)to.width * to.height * size;
	return render_device_send(device, &to, from);
}

static stilb_result gloss_send_all(render_device *device, const render_panorama_gloss *gloss)
{
	const uint16_t(*from)[4] = gloss->cube;
	stilb_gpu_upload light = {
		.image = device->next_light, .width = RENDER_PANORAMA_COLUMNS, .height = RENDER_PANORAMA_ROWS};
	stilb_gpu_upload dfg = {.image = device->dfg, .width = RENDER_PANORAMA_DFG, .height = RENDER_PANORAMA_DFG};
	stilb_result result = gloss_send(device, light, sizeof(float[4]), gloss->light);
	if (gloss->dfg && result == STILB_OK)
		result = gloss_send(device, dfg, sizeof **gloss->dfg, gloss->dfg);
	for (uint32_t part = 0; part < 6 * RENDER_PANORAMA_MIPS && result == STILB_OK; part++) {
		uint32_t mip = part / 6, side = RENDER_PANORAMA_FACE >> mip;
		stilb_gpu_upload to = {.image = device->next_cube,
		                       .mip = (uint16_t)mip,
		                       .layer = (uint16_t)(part % 6),
		                       .width = side,
		                       .height = side};
		result = gloss_send(device, to, sizeof *from, from);
		from += (size_t)side * side;
	}
	STILB_ASSERT(result != STILB_OK || from == gloss->cube + RENDER_PANORAMA_CUBE);
	return result;
}

/* ---- panoramas --------------------------------------------------------------------------------------------------- */

void *render_device_panorama_make(render_device *device, size_t bytes)
{
	free(device->next_panorama);
	device->next_panorama = gloss_make(device) == STILB_OK ? stilb_memory_alloc(bytes, 1) : NULL;
	return device->next_panorama;
}

/* Makes the image of the texels and sends them, some rows at a time. */
static stilb_result panorama_send(render_device *device, const render_panorama_gloss *gloss, stilb_gpu_image *image)
{
	stilb_gpu_extent extent = {
		.format = STILB_GPU_RGBA16_F, .width = gloss->width, .height = gloss->height, .layers = 1, .mips = 1};
	size_t row = gloss->width * sizeof *gloss->texels;
	uint32_t part = (uint32_t)(stilb_gpu_upload_most(device->gpu) / 4 / row);
	stilb_result result = gloss_image(device, "panorama", extent, image);
	STILB_ASSERT(part > 0);
	for (uint32_t y = 0; y < gloss->height && result == STILB_OK; y += part) {
		uint32_t rows = gloss->height - y < part ? gloss->height - y : part;
		stilb_gpu_upload to = {.image = *image, .y = y, .width = gloss->width, .height = rows};
		result = gloss_send(device, to, sizeof *gloss->texels, gloss->texels + (size_t)y * gloss->width);
	}
	return result;
}

stilb_result render_device_panorama_show(render_device *device, const render_panorama_gloss *gloss)
{
	STILB_ASSERT(device->next_panorama && device->next_cube.id != 0);
	stilb_gpu_image texels = {0};
	render_buffer table = {0};
	stilb_result result = render_buffer_make(device, "panorama", sizeof *gloss->light, STILB_GPU_MEMORY_WRITE,
	                                         STILB_GPU_BUFFER_ADDRESS, &table);
	if (result == STILB_OK)
		result = gloss_send_all(device, gloss);
	if (result == STILB_OK)
		result = panorama_send(device, gloss, &texels);
	if (result != STILB_OK) {
		if (texels.id != 0)
			stilb_gpu_image_destroy(device->gpu, texels);
		render_buffer_drop(device, &table);
		return result;
	}
	memcpy(table.mapped, gloss->light, sizeof *gloss->light);
	stilb_gpu_image_destroy(device->gpu, device->cube);
	stilb_gpu_image_destroy(device->gpu, device->light);
	stilb_gpu_image_destroy(device->gpu, device->texels);
	device->cube = device->next_cube;
	device->light = device->next_light;
	device->texels = texels;
	device->next_cube = device->next_light = (stilb_gpu_image){0};
	render_buffer_drop(device, &device->panorama);
	device->panorama = table;
	free(device->next_panorama);
	device->next_panorama = NULL;
	return STILB_OK;
}
