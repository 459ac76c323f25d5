/* The device: opening, resizing and closing it, the memory of frames, and what is read of them. */
#include "render/device/render_images.h"
#include "render/render_internal.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static_assert(sizeof((render_slot *)0)->memory / sizeof(render_buffer) == RENDER_MEMORY_KINDS, "one of each kind");

/* ---- buffers ----------------------------------------------------------------------------------------------------- */

stilb_result render_buffer_make(render_device *device, const char *name, uint64_t bytes, stilb_gpu_memory memory,
                                uint32_t uses, render_buffer *buffer)
{
	stilb_gpu_buffer_desc desc = {.name = name, .bytes = bytes, .memory = memory, .uses = uses};
	*buffer = (render_buffer){0};
	stilb_result result = stilb_gpu_buffer_create(device->gpu, &desc, &buffer->buffer);
	if (result != STILB_OK)
		return result;
	buffer->bytes = bytes;
	buffer->mapped = stilb_gpu_buffer_mapped(device->gpu, buffer->buffer);
	if (uses & STILB_GPU_BUFFER_ADDRESS)
		buffer->address = stilb_gpu_buffer_address(device->gpu, buffer->buffer);
	return STILB_OK;
}

void render_buffer_drop(render_device *device, render_buffer *buffer)
{
	stilb_gpu_buffer_destroy(device->gpu, buffer->buffer);
	*buffer = (render_buffer){0};
}

/* ---- size -------------------------------------------------------------------------------------------------------- */

/* Checks the GPU's limits for pictures of this size. */
static stilb_result device_check_size(const render_device *device)
{
	uint32_t most = stilb_gpu_limits_get(device->gpu)->attachment_side;
	if (device->width <= most && device->height <= most)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' draws pictures of up to %ux%u, not %ux%u; use a smaller --size",
	                  stilb_gpu_name(device->gpu), most, most, device->width, device->height);
}

stilb_result render_device_resize(render_device *device, uint32_t width, uint32_t height)
{
	device->width = width;
	device->height = height;
	device->drawn = device->lit = false;
	return device_check_size(device);
}

static stilb_result device_choose_samples(render_device *device, uint32_t wanted)
{
	uint32_t possible = stilb_gpu_limits_get(device->gpu)->samples;
	STILB_ASSERT(wanted == 0 || wanted == 1 || wanted == 4);
	bool one = device->null || stilb_gpu_is_software(device->gpu) || !(possible & 4);
	device->samples = wanted ? wanted : one ? 1 : 4;
	if (device->samples > 1 && !(possible & device->samples))
		return stilb_fail(STILB_ERROR_DEVICE, "GPU '%s' has no %u samples per pixel; use --msaa 1",
		                  stilb_gpu_name(device->gpu), device->samples);
	return STILB_OK;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void device_choose_anisotropy(render_device *device, uint32_t wanted)
{
	float most = stilb_gpu_limits_get(device->gpu)->anisotropy;
	uint32_t own = stilb_gpu_is_software(device->gpu) ? 1 : 8;
	device->anisotropy = (float)(wanted > 0 ? wanted : own);
	if (device->anisotropy <= most)
		return;
	if (wanted > 0)
		stilb_log("GPU '%s' has anisotropy of up to %g, which is used in the place of %u", stilb_gpu_name(device->gpu),
		          (double)most, wanted);
	device->anisotropy = most;
}

static stilb_result device_open(render_device *device, const stilb_render_desc *desc)
{
	stilb_gpu_desc gpu = {
		.kind = device->null ? STILB_GPU_KIND_NULL : STILB_GPU_KIND_VULKAN,
		.name = desc->gpu,
		.surface = desc->surface,
		.presentation = desc->presentation,
		.width = desc->width,
		.height = desc->height,
		.validate = desc->validate,
		.faults = {desc->faults.allocation, desc->faults.lost_frame, desc->faults.surface_lost,
	               desc->faults.texture_side},
	};
	stilb_gpu_sampler_desc sampler = {.linear = true, .wrap = {STILB_GPU_WRAP_REPEAT, STILB_GPU_WRAP_REPEAT}};
	stilb_gpu_sampler_desc linear = {.linear = true, .wrap = {STILB_GPU_WRAP_CLAMP, STILB_GPU_WRAP_CLAMP}};
	stilb_result result = stilb_gpu_create(&gpu, &device->gpu);
	if (result == STILB_OK)
		result = device_choose_samples(device, desc->samples);
	if (result == STILB_OK)
		device_choose_anisotropy(device, desc->max_anisotropy);
	if (result == STILB_OK)
		result = device_check_size(device);
	if (result == STILB_OK)
		result = stilb_gpu_sampler_get(device->gpu, &sampler, &device->sampler);
	if (result == STILB_OK)
		result = stilb_gpu_sampler_get(device->gpu, &linear, &device->linear);
	if (result == STILB_OK)
		result = render_programs_create(device);
	for (uint32_t i = 0; i < STILB_GPU_FRAMES && result == STILB_OK; i++)
		result = render_buffer_make(device, "views", STILB_RENDER_MAX_PASSES * sizeof(render_view_data),
		                            STILB_GPU_MEMORY_WRITE, STILB_GPU_BUFFER_ADDRESS, &device->slots[i].views);
	return result;
}

stilb_result render_device_create(const stilb_render_desc *desc, render_device **out)
{
	render_device *device = calloc(1, sizeof *device);
	*out = device;
	if (!device)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the device");
	device->null = desc->device == STILB_RENDER_DEVICE_NULL;
	device->most_room = UINT32_MAX;
	memset(device->pairs, 0xff, sizeof device->pairs);
	device->width = desc->width;
	device->height = desc->height;
	device->replay = desc->replay;
	device->materials = desc->materials;
	device->output = desc->output;
	device->packed = !desc->float_vertices;
	device->layout = render_layout_make(&stilb_scene_vertex_streams, device->packed);
	device->textures = calloc(STILB_RENDER_MAX_TEXTURES, sizeof *device->textures);
	/* Zeros, whose pages get memory when they are first written: calloc may write them all. */
	void *maps = mmap(NULL, RENDER_MAX_MAPS * sizeof *device->maps, PROT_READ | PROT_WRITE,
	                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
	device->maps = maps == MAP_FAILED ? NULL : maps;
	device->plan = stilb_gpu_plan_create();
	stilb_result result = device->textures && device->maps && device->plan
	                          ? device_open(device, desc)
	                          : stilb_fail(STILB_ERROR_MEMORY, "no memory for the device");
	if (result != STILB_OK) {
		render_device_destroy(device);
		*out = NULL;
	}
	return result;
}

void render_device_destroy(render_device *device)
{
	if (!device)
		return;
	stilb_gpu_plan_destroy(device->plan);
	render_programs_destroy(device);
	stilb_gpu_destroy(device->gpu); /* and all that is there */
	free(device->next_panorama);
	free(device->textures);
	if (device->maps)
		munmap(device->maps, RENDER_MAX_MAPS * sizeof *device->maps);
	render_arrays_finish(&device->arrays);
	for (uint32_t l = 0; l < RENDER_MAX_LISTS; l++) {
		free(device->lists[l].bindings);
		free(device->lists[l].maps);
	}
	free(device->runs);
	free(device);
}

/* ---- a frame's memory -------------------------------------------------------------------------------------------- */

stilb_result render_device_frame_begin(render_device *device, render_memory *memory)
{
	STILB_ASSERT(memory);
	stilb_result result = device_check_size(device);
	if (result == STILB_OK)
		result = stilb_gpu_frame_begin(device->gpu);
	if (result != STILB_OK)
		return result;
	device->slot = (device->slot + 1) % STILB_GPU_FRAMES;
	device->frame = (render_frame){0};
	device->drawn = device->lit = false; /* what there was is in the plan that this frame makes anew */
	device->stats.gpu_ms = stilb_gpu_stats_get(device->gpu).gpu_ms;
	const render_slot *slot = render_slot_now(device);
	for (uint32_t kind = 0; kind < RENDER_MEMORY_KINDS && result == STILB_OK; kind++) {
		const render_buffer *buffer = &slot->memory[kind];
		memory[kind].data = buffer->mapped;
		memory[kind].capacity = (uint32_t)(buffer->bytes / memory[kind].element);
		if (!buffer->mapped && memory[kind].first_capacity > 0)
			result = render_device_grow(device, &memory[kind], kind, memory[kind].first_capacity, 0);
	}
	return result;
}

/* Rows and geometry are written once and read by the GPU. The CPU reads commands again when it sorts them or replays
 * them one by one, so they lie in memory that it caches; the GPU reads only 20 bytes of each. */
static const struct {
	const char *name;
	uint32_t uses;
	stilb_gpu_memory memory;
} frame_memory[RENDER_MEMORY_KINDS] = {
	[RENDER_MEMORY_COMMANDS] = {"draws", STILB_GPU_BUFFER_INDIRECT, STILB_GPU_MEMORY_SHARED},
	[RENDER_MEMORY_ROWS] = {"rows", STILB_GPU_BUFFER_ADDRESS, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_VERTICES_2D] = {"2D vertices", STILB_GPU_BUFFER_VERTICES, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_INDICES_2D] = {"2D indices", STILB_GPU_BUFFER_INDICES, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_LIGHTS] = {"lights", STILB_GPU_BUFFER_ADDRESS, STILB_GPU_MEMORY_WRITE},
	[RENDER_MEMORY_LIGHT_LISTS] = {"lists of lights", STILB_GPU_BUFFER_ADDRESS, STILB_GPU_MEMORY_WRITE},
};

stilb_result render_device_grow(render_device *device, render_memory *memory, uint32_t kind, uint32_t capacity,
                                uint32_t keep)
{
	STILB_ASSERT(kind < RENDER_MEMORY_KINDS);
	render_buffer *buffer = &render_slot_now(device)->memory[kind], grown;
	STILB_ASSERT(capacity > 0 && keep <= capacity && (uint64_t)keep * memory->element <= buffer->bytes);
	stilb_result result = render_buffer_make(device, frame_memory[kind].name, (uint64_t)capacity * memory->element,
	                                         frame_memory[kind].memory, frame_memory[kind].uses, &grown);
	if (result == STILB_ERROR_MEMORY)
		return stilb_fail(result, "no memory for %u %s; try fewer models", capacity, frame_memory[kind].name);
	if (result != STILB_OK)
		return result;
	if (keep > 0)
		memcpy(grown.mapped, buffer->mapped, (size_t)keep * memory->element);
	render_buffer_drop(device, buffer);
	*buffer = grown;
	memory->data = grown.mapped;
	memory->capacity = capacity;
	return STILB_OK;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

stilb_result render_device_present(render_device *device)
{
	STILB_ASSERT(device->drawn);
	return stilb_gpu_present(device->gpu, device->plan, device->frame.picture);
}

/* Copies pixels of four channels to an image of as many or of three. */
static void read_take(stilb_image *image, const uint8_t *from, size_t channel)
{
	size_t pixels = (size_t)image->width * image->height, to = image->channels * channel;
	STILB_ASSERT(stilb_image_size(image) == pixels * to);
	uint8_t *out = image->pixels;
	if (image->channels == 4)
		memcpy(out, from, pixels * to);
	for (size_t i = 0; i < pixels && image->channels == 3; i++)
		memcpy(out + i * to, from + i * 4 * channel, to);
}

/* Where a pixel is partly covered its colour is premultiplied: codes are divided by alpha, as linear light. */
static void read_divide(stilb_image *image)
{
	size_t size = stilb_image_size(image);
	uint8_t *codes = image->pixels;
	for (size_t i = 0; i < size; i += 4)
		for (size_t c = 0; c < 3 && codes[i + 3] > 0 && codes[i + 3] < 255; c++) {
			float light = shade_srgb_to_linear((float)codes[i + c] / 255.0f) * 255.0f / (float)codes[i + 3];
			codes[i + c] = (uint8_t)(shade_srgb_from_linear(fminf(light, 1.0f)) * 255.0f + 0.5f);
		}
}

/* Makes an image of an output of the last frame: of the picture or the main light. */
static stilb_result device_read(render_device *device, uint16_t resource, stilb_image_format format, stilb_image *image)
{
	uint64_t ticket, frame;
	const void *bytes;
	const render_frame_target *main = render_target_main(device);
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(device->plan, resource);
	uint32_t channels = main && main->transparent ? 4 : 3;
	stilb_result result = stilb_gpu_read_begin(device->gpu, device->plan, resource, 0, 0, &ticket);
	if (result != STILB_OK)
		return result;
	result = stilb_gpu_read_get(device->gpu, ticket, true, &bytes, &frame);
	if (result == STILB_OK)
		result = stilb_image_create(image, extent.width, extent.height, channels, format);
	if (result == STILB_OK)
		read_take(image, bytes, format == STILB_IMAGE_F16_LINEAR ? 2 : 1);
	stilb_gpu_read_end(device->gpu, ticket);
	return result;
}

static stilb_result read_check(const render_device *device, bool there, const char *what)
{
	if (device->null)
		return stilb_fail(STILB_ERROR_DEVICE, "the null device draws no picture; use --device vulkan for a screenshot");
	return there ? STILB_OK : stilb_fail(STILB_ERROR_DEVICE, "no frame %sof this size has been drawn yet", what);
}

stilb_result render_device_read_picture(render_device *device, stilb_image *image)
{
	bool display = device->output == STILB_RENDER_OUTPUT_DISPLAY;
	stilb_result result = read_check(device, device->drawn, "");
	if (result == STILB_OK)
		result =
			device_read(device, device->frame.picture, display ? STILB_IMAGE_U8_SRGB : STILB_IMAGE_F16_LINEAR, image);
	if (result == STILB_OK && display && image->channels == 4)
		read_divide(image);
	return result;
}

stilb_result render_device_read_light(render_device *device, stilb_image *image)
{
	if (device->drawn && !device->lit && device->until[0] != '\0')
		return stilb_fail(STILB_ERROR_DEVICE,
		                  "'" STILB_RENDER_IMAGE_COLOR "' has no light yet where frames end, after pass '%s'; save the "
		                  "picture, as .png, or end them later",
		                  device->until);
	stilb_result result = read_check(device, device->drawn && device->lit, "with a scene ");
	if (result != STILB_OK)
		return result;
	const render_frame_target *main = render_target_main(device);
	bool error = main->tone == RENDER_TONE_ERROR;
	uint16_t light = error ? stilb_gpu_plan_find(device->plan, STILB_RENDER_IMAGE_ERROR) : main->color;
	return device_read(device, light, STILB_IMAGE_F16_LINEAR, image);
}
