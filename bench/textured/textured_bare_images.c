/* The images of the plain Vulkan program: maps with their mips, and what a panorama becomes. */
#include "bench/textured/textured_bare.h"

#include "bench/record/record_child.h"
#include "render/maps/render_maps.h"
#include "render/render_panorama.h"

/* ---- images ------------------------------------------------------------------------------------------------------ */

typedef struct picture {
	VkFormat format;
	uint32_t width, height, mips, layers, texel; /* texel: bytes */
	VkImageViewType view;
	const void *texels; /* [mip][layer], without gaps */
} picture;

static size_t picture_bytes(const picture *p)
{
	size_t texels = 0;
	for (uint32_t m = 0; m < p->mips; m++)
		texels += (size_t)(p->width >> m) * (p->height >> m) * p->layers;
	return texels * p->texel;
}

static void barrier(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to)
{
	VkImageMemoryBarrier2 all = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
		.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
		.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
		.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
		.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
		.oldLayout = from,
		.newLayout = to,
		.image = image,
		.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS},
	};
	vkCmdPipelineBarrier2(commands, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
	                                                    .imageMemoryBarrierCount = 1,
	                                                    .pImageMemoryBarriers = &all});
}

/* Copies the texels with the command buffer of a frame, which has not been used yet. */
static void fill(const bare *b, const picture *p, VkImage image)
{
	const bare_frame *frame = &b->frames[0];
	bare_buffer staging = bare_make_buffer((bare *)b, picture_bytes(p), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
	VkBufferImageCopy copies[16];
	VkDeviceSize at = 0;
	memcpy(staging.mapped, p->texels, picture_bytes(p));
	for (uint32_t m = 0; m < p->mips; m++) {
		copies[m] = (VkBufferImageCopy){.bufferOffset = at,
		                                .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, m, 0, p->layers},
		                                .imageExtent = {p->width >> m, p->height >> m, 1}};
		at += (VkDeviceSize)(p->width >> m) * (p->height >> m) * p->layers * p->texel;
	}
	VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
	bare_check(vkResetCommandPool(b->device, frame->pool, 0), "vkResetCommandPool");
	bare_check(vkBeginCommandBuffer(frame->commands, &begin), "vkBeginCommandBuffer");
	barrier(frame->commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
	vkCmdCopyBufferToImage(frame->commands, staging.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, p->mips,
	                       copies);
	barrier(frame->commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
	bare_check(vkEndCommandBuffer(frame->commands), "vkEndCommandBuffer");
	VkCommandBufferSubmitInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
	                                      .commandBuffer = frame->commands};
	VkSubmitInfo2 info = {
		.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commands};
	bare_check(vkQueueSubmit2(b->queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit2");
	bare_check(vkQueueWaitIdle(b->queue), "vkQueueWaitIdle");
	bare_free_buffer((bare *)b, &staging);
}

static bare_image make_image(bare *b, const picture *p)
{
	VkImageCreateInfo info = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
		.flags = p->view == VK_IMAGE_VIEW_TYPE_CUBE ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
		.imageType = VK_IMAGE_TYPE_2D,
		.format = p->format,
		.extent = {p->width, p->height, 1},
		.mipLevels = p->mips,
		.arrayLayers = p->layers,
		.samples = VK_SAMPLE_COUNT_1_BIT,
		.tiling = VK_IMAGE_TILING_OPTIMAL,
		.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
	};
	bare_image made = {0};
	bare_check(vkCreateImage(b->device, &info, NULL, &made.image), "vkCreateImage");
	made.memory = bare_image_memory(b, made.image);
	VkImageViewCreateInfo view = {
		.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
		.image = made.image,
		.viewType = p->view,
		.format = p->format,
		.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, p->mips, 0, p->layers},
	};
	bare_check(vkCreateImageView(b->device, &view, NULL, &made.view), "vkCreateImageView");
	fill(b, p, made.image);
	return made;
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* The texture as RGBA with mips, as the engine's renderer makes them. */
static bare_image make_map(bare *b, const stilb_image *texture, render_mips_kind kind, bool array)
{
	static render_mips_codes codes;
	bool srgb = texture->format == STILB_IMAGE_U8_SRGB;
	if (!srgb && texture->format != STILB_IMAGE_U8_LINEAR)
		bench_child_fail("a map of the model is not of 8 bits");
	if ((texture->width & (texture->width - 1)) || texture->width != texture->height)
		bench_child_fail("a map of the model is not a square of a power of two");
	picture p = {.format = srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
	             .width = texture->width,
	             .height = texture->height,
	             .mips = render_mip_count(texture->width, texture->height),
	             .layers = 1,
	             .texel = 4,
	             .view = array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D};
	uint8_t *texels = record_alloc(picture_bytes(&p), 1);
	stilb_image level = {p.width, p.height, 4, texture->format, texels, 0};
	for (size_t i = 0; i < (size_t)p.width * p.height; i++)
		for (uint32_t c = 0; c < 4; c++)
			texels[4 * i + c] =
				c < texture->channels ? ((const uint8_t *)texture->pixels)[i * texture->channels + c] : 255;
	render_mips_codes_make(texture->format, kind, STILB_RENDER_SPECULAR_AA_VMF, &codes);
	if (kind != RENDER_MIPS_MEANS)
		render_mips_prepare(&level, kind);
	for (uint32_t m = 1; m < p.mips; m++) {
		stilb_image next = {p.width >> m, p.height >> m, 4, texture->format, NULL, 0};
		next.pixels = (uint8_t *)level.pixels + stilb_image_size(&level);
		render_mips_rows(&codes, &level, 0, next.height, NULL, &next);
		level = next;
	}
	p.texels = texels;
	bare_image made = make_image(b, &p);
	free(texels);
	return made;
}

/* ---- the panorama ------------------------------------------------------------------------------------------------ */

typedef struct environment {
	textured_bare *b;
	float *table;
} environment;

static void *table_memory(void *user, size_t bytes)
{
	environment *e = user;
	return e->table = record_alloc(bytes, 1);
}

static stilb_result make_gloss(void *user, const render_panorama_gloss *gloss)
{
	textured_bare *b = ((environment *)user)->b;
	picture cube = {.format = VK_FORMAT_R16G16B16A16_SFLOAT,
	                .width = RENDER_PANORAMA_FACE,
	                .height = RENDER_PANORAMA_FACE,
	                .mips = RENDER_PANORAMA_MIPS,
	                .layers = 6,
	                .texel = 8,
	                .view = VK_IMAGE_VIEW_TYPE_CUBE,
	                .texels = gloss->cube};
	picture dfg = {.format = VK_FORMAT_R16G16_SFLOAT,
	               .width = RENDER_PANORAMA_DFG,
	               .height = RENDER_PANORAMA_DFG,
	               .mips = 1,
	               .layers = 1,
	               .texel = 4,
	               .view = VK_IMAGE_VIEW_TYPE_2D,
	               .texels = gloss->dfg};
	b->images[TEXTURED_MAPS] = make_image(&b->bare, &cube);
	b->images[TEXTURED_MAPS + 1] = make_image(&b->bare, &dfg);
	return STILB_OK;
}

static void make_environment(textured_bare *b)
{
	environment e = {.b = b};
	render_panorama panorama = {0};
	render_panorama_memory memory = {table_memory, make_gloss, &e};
	if (!render_panorama_is_good(&b->scene->surroundings.panorama))
		bench_child_fail("the scene has no panorama");
	if (render_panorama_update(&panorama, &b->scene->surroundings.panorama, memory, false, NULL, 0) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	if (panorama.lamp_count > 0)
		bench_child_fail("the panorama has lamps, which the plain program does not draw");
	picture irradiance = {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
	                      .width = RENDER_PANORAMA_COLUMNS,
	                      .height = RENDER_PANORAMA_ROWS,
	                      .mips = 1,
	                      .layers = 1,
	                      .texel = 16,
	                      .view = VK_IMAGE_VIEW_TYPE_2D,
	                      .texels = e.table};
	b->images[TEXTURED_MAPS + 2] = make_image(&b->bare, &irradiance);
	memcpy(b->table.mapped, e.table, sizeof(render_panorama_table));
	render_panorama_finish(&panorama);
	free(e.table);
}

void textured_bare_make_images(textured_bare *b, bool arrays)
{
	const stilb_scene *scene = b->scene;
	const stilb_scene_surface *surface = &scene->surfaces[scene->materials[scene->part_material[0]].surface - 1];
	for (uint32_t i = 0; i < TEXTURED_MAPS; i++) {
		if (surface->maps[i].texture == 0)
			bench_child_fail("the model lacks a map");
		render_mips_kind kind = i == STILB_SCENE_MAP_NORMAL ? RENDER_MIPS_NORMALS : RENDER_MIPS_MEANS;
		b->images[i] = make_map(&b->bare, &scene->textures[surface->maps[i].texture - 1], kind, arrays);
	}
	b->table = bare_make_buffer(&b->bare, sizeof(render_panorama_table),
	                            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
	make_environment(b);
}
