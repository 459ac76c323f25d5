/* A panorama on the device: the memory that its light is made in, which shaders read by address, and the images of its
 * gloss and its light, which are sent once it is complete. */
#include "render/render_internal.h"

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
	if (device->next_panorama.bytes != bytes) {
		render_buffer_drop(device, &device->next_panorama);
		render_buffer_make(device, "panorama", bytes, STILB_GPU_MEMORY_WRITE, STILB_GPU_BUFFER_ADDRESS,
		                   &device->next_panorama);
	}
	bool made = device->next_panorama.mapped && gloss_make(device) == STILB_OK;
	return made ? device->next_panorama.mapped : NULL;
}

stilb_result render_device_panorama_show(render_device *device, const render_panorama_gloss *gloss)
{
	STILB_ASSERT(device->next_panorama.mapped && device->next_cube.id != 0);
	stilb_result result = gloss_send_all(device, gloss);
	if (result != STILB_OK)
		return result;
	stilb_gpu_image_destroy(device->gpu, device->cube);
	stilb_gpu_image_destroy(device->gpu, device->light);
	device->cube = device->next_cube;
	device->light = device->next_light;
	device->next_cube = device->next_light = (stilb_gpu_image){0};
	render_buffer_drop(device, &device->panorama);
	device->panorama = device->next_panorama;
	device->next_panorama = (render_buffer){0};
	return STILB_OK;
}
