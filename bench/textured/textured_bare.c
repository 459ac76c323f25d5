/* The plain Vulkan program's set, pipeline and frames. */
#include "bench/textured/textured_bare.h"

#include "bench/record/record_child.h"
#include "image/image.h"
#include "render/maps/render_maps.h"
#include "shading/shade_gltf.h"

static const uint32_t straight_frag[] =
#include "textured.frag.inc"
	;
static const uint32_t arrays_frag[] =
#include "textured_arrays.frag.inc"
	;
static const uint32_t address_frag[] =
#include "textured_address.frag.inc"
	;
static const uint32_t sampled_frag[] =
#include "textured_sampled.frag.inc"
	;
static const uint32_t fetched_frag[] =
#include "textured_fetched.frag.inc"
	;
static const uint32_t handed_frag[] =
#include "textured_handed.frag.inc"
	;
static const uint32_t extras_frag[] =
#include "textured_extras.frag.inc"
	;
static const uint32_t sides_frag[] =
#include "textured_sides.frag.inc"
	;
static const uint32_t habits_frag[] =
#include "textured_habits.frag.inc"
	;
static const uint32_t straight_vert[] =
#include "textured.vert.inc"
	;
static const uint32_t view_vert[] =
#include "textured_view.vert.inc"
	;
static const uint32_t handed_vert[] =
#include "textured_handed.vert.inc"
	;
static const uint32_t extras_vert[] =
#include "textured_extras.vert.inc"
	;
static const uint32_t habits_vert[] =
#include "textured_habits.vert.inc"
	;
/* Variants that change pixels alone, or vertices. */
#define view_frag straight_frag
#define fetched_vert straight_vert
#define arrays_vert straight_vert
#define address_vert straight_vert
#define sampled_vert straight_vert
#define sides_vert straight_vert

static const struct code {
	const uint32_t *words[2]; /* vertex, fragment */
	size_t sizes[2];
} codes[TEXTURED_COUNT] = {
#define CODE(ID, name, ...) [TEXTURED_##ID] = {{name##_vert, name##_frag}, {sizeof name##_vert, sizeof name##_frag}},
	TEXTURED_VARIANTS(CODE)
#undef CODE
};

/* ---- buffers ----------------------------------------------------------------------------------------------------- */

#define BY_ADDRESS (VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)

static void make_buffers(textured_bare *b)
{
	const stilb_scene *scene = b->scene;
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[0]];
	const stilb_scene_surface *surface = &scene->surfaces[scene->materials[scene->part_material[0]].surface - 1];
	b->extras =
		bare_make_buffer(&b->bare, mesh->vertex_count * sizeof *mesh->extras, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
	memcpy(b->extras.mapped, mesh->extras, mesh->vertex_count * sizeof *mesh->extras);
	b->packed = bare_make_buffer(&b->bare, mesh->vertex_count * sizeof(render_extra), BY_ADDRESS);
	render_extras_pack(mesh->extras, mesh->vertex_count, b->packed.mapped);
	b->material =
		bare_make_buffer(&b->bare, sizeof(textured_material), BY_ADDRESS | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
	b->view = bare_make_buffer(&b->bare, sizeof b->push, BY_ADDRESS);
	textured_material material = {
		.roughness = surface->roughness,
		.metalness = surface->metalness,
		.normal_scale = surface->normal_scale,
		.occlusion = surface->occlusion,
		.turn = {sinf(scene->surroundings.rotation), cosf(scene->surroundings.rotation)},
		.table = b->table.address,
		.record = b->material.address,
		.extras = b->packed.address,
		.view = b->view.address,
	};
	for (int i = 0; i < 3; i++) {
		material.color[i] = surface->color[i];
		material.emission[i] = surface->emission[i];
		material.specular[i] =
			fminf(surface->specular[i] * shade_gltf_reflectance(surface->ior), 1.0f) * surface->specular_weight;
	}
	memcpy(b->material.mapped, &material, sizeof material);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, (float)TEXTURED_WIDTH / (float)TEXTURED_HEIGHT);
	memcpy(b->push.view_projection, matrix.m, sizeof b->push.view_projection);
	memcpy(b->push.camera, scene->camera.position, sizeof scene->camera.position);
	for (int row = 0; row < 3; row++)
		for (int column = 0; column < 4; column++)
			b->push.transform[row][column] = scene->part_transform[0].m[4 * column + row];
	memcpy(b->view.mapped, &b->push, sizeof b->push);
}

/* ---- the set ----------------------------------------------------------------------------------------------------- */

#define UNIFORM TEXTURED_IMAGES
#define STORAGE (TEXTURED_IMAGES + 1)
#define BINDINGS (TEXTURED_IMAGES + 2)

static VkDescriptorType binding_type(uint32_t binding)
{
	return binding == UNIFORM   ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
	       : binding == STORAGE ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
	                            : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

static void make_samplers(textured_bare *b)
{
	for (int i = 0; i < 2; i++) {
		VkSamplerAddressMode wrap = i == 0 ? VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE : VK_SAMPLER_ADDRESS_MODE_REPEAT;
		VkSamplerCreateInfo info = {
			.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
			.magFilter = VK_FILTER_LINEAR,
			.minFilter = VK_FILTER_LINEAR,
			.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
			.addressModeU = wrap,
			.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
			.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
			.maxLod = VK_LOD_CLAMP_NONE,
		};
		bare_check(vkCreateSampler(b->bare.device, &info, NULL, &b->samplers[i]), "vkCreateSampler");
	}
}

static void make_set_layout(textured_bare *b)
{
	VkDescriptorSetLayoutBinding bindings[BINDINGS];
	for (uint32_t i = 0; i < BINDINGS; i++)
		bindings[i] =
			(VkDescriptorSetLayoutBinding){.binding = i,
		                                   .descriptorType = binding_type(i),
		                                   .descriptorCount = 1,
		                                   .stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
	VkDescriptorSetLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
		.bindingCount = BINDINGS,
		.pBindings = bindings,
	};
	bare_check(vkCreateDescriptorSetLayout(b->bare.device, &layout, NULL, &b->set_layout),
	           "vkCreateDescriptorSetLayout");
	const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, TEXTURED_IMAGES},
	                                      {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
	                                      {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}};
	VkDescriptorPoolCreateInfo pool = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
		.maxSets = 1,
		.poolSizeCount = 3,
		.pPoolSizes = sizes,
	};
	bare_check(vkCreateDescriptorPool(b->bare.device, &pool, NULL, &b->pool), "vkCreateDescriptorPool");
}

static void make_set(textured_bare *b)
{
	VkWriteDescriptorSet writes[BINDINGS];
	VkDescriptorImageInfo images[TEXTURED_IMAGES];
	VkDescriptorBufferInfo buffers[2] = {{b->material.buffer, 0, VK_WHOLE_SIZE}, {b->table.buffer, 0, VK_WHOLE_SIZE}};
	VkDescriptorSetAllocateInfo set = {
		.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
		.descriptorPool = b->pool,
		.descriptorSetCount = 1,
		.pSetLayouts = &b->set_layout,
	};
	bare_check(vkAllocateDescriptorSets(b->bare.device, &set, &b->set), "vkAllocateDescriptorSets");
	for (uint32_t i = 0; i < BINDINGS; i++) {
		writes[i] = (VkWriteDescriptorSet){
			.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
			.dstSet = b->set,
			.dstBinding = i,
			.descriptorCount = 1,
			.descriptorType = binding_type(i),
		};
		if (i < TEXTURED_IMAGES) {
			images[i] = (VkDescriptorImageInfo){b->samplers[i == TEXTURED_IMAGES - 1], b->images[i].view,
			                                    VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
			writes[i].pImageInfo = &images[i];
		} else {
			writes[i].pBufferInfo = &buffers[i - TEXTURED_IMAGES];
		}
	}
	vkUpdateDescriptorSets(b->bare.device, BINDINGS, writes, 0, NULL);
}

/* ---- the pipeline ------------------------------------------------------------------------------------------------ */

static void make_pipeline(textured_bare *b, textured_variant variant)
{
	static const VkVertexInputBindingDescription bindings[2] = {
		{.binding = 0, .stride = sizeof(stilb_scene_vertex)},
		{.binding = 1, .stride = sizeof(stilb_scene_vertex_extra)},
	};
	static const VkVertexInputAttributeDescription attributes[4] = {
		{.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, position)},
		{.location = 1, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(stilb_scene_vertex, normal)},
		{.location = 2, .format = VK_FORMAT_R32G32_SFLOAT, .offset = offsetof(stilb_scene_vertex, uv)},
		{.location = 3,
	     .binding = 1,
	     .format = VK_FORMAT_R32G32B32A32_SFLOAT,
	     .offset = offsetof(stilb_scene_vertex_extra, tangent)},
	};
	static const bare_vertices vertices = {2, 4, bindings, attributes};
	VkPushConstantRange range = {
		.stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
		.size = sizeof(textured_push),
	};
	VkPipelineLayoutCreateInfo layout = {
		.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
		.setLayoutCount = 1,
		.pSetLayouts = &b->set_layout,
		.pushConstantRangeCount = 1,
		.pPushConstantRanges = &range,
	};
	bare_check(vkCreatePipelineLayout(b->bare.device, &layout, NULL, &b->layout), "vkCreatePipelineLayout");
	bare_program program = {.codes = {codes[variant].words[0], codes[variant].words[1]},
	                        .sizes = {codes[variant].sizes[0], codes[variant].sizes[1]},
	                        .vertices = &vertices,
	                        .format = VK_FORMAT_R16G16B16A16_SFLOAT,
	                        .layout = b->layout,
	                        .width = TEXTURED_WIDTH,
	                        .height = TEXTURED_HEIGHT};
	b->pipeline = bare_make_pipeline(&b->bare, &program);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

bool textured_bare_open(textured_bare *b, const stilb_scene *scene, textured_variant variant)
{
	*b = (textured_bare){.scene = scene};
	if (scene->part_count != 1 || !scene->meshes[scene->part_mesh[0]].extras ||
	    scene->materials[scene->part_material[0]].surface == 0)
		bench_child_fail("the scene is not one part with tangents and a surface");
	if (!bare_open(&b->bare))
		return false;
	bare_prepare(&b->bare, scene, TEXTURED_WIDTH, TEXTURED_HEIGHT);
	b->bare.dither = true;
	textured_bare_make_images(b, variant == TEXTURED_ARRAYS || variant == TEXTURED_HABITS);
	make_buffers(b);
	make_samplers(b);
	make_set_layout(b);
	make_set(b);
	make_pipeline(b, variant);
	return true;
}

void textured_bare_frame(textured_bare *b)
{
	const bare_frame *frame = &b->bare.frames[b->frames++ % BARE_FRAMES];
	VkCommandBuffer commands = frame->commands;
	bare_frame_wait(&b->bare, frame);
	bare_frame_begin(&b->bare, frame, b->scene->backdrop.color);
	vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->pipeline);
	vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->layout, 0, 1, &b->set, 0, NULL);
	vkCmdPushConstants(commands, b->layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
	                   sizeof b->push, &b->push);
	vkCmdBindVertexBuffers(commands, 0, 2, (VkBuffer[]){b->bare.vertices.buffer, b->extras.buffer},
	                       (VkDeviceSize[]){0, 0});
	vkCmdBindIndexBuffer(commands, b->bare.indices.buffer, 0, VK_INDEX_TYPE_UINT32);
	vkCmdDrawIndexed(commands, b->bare.meshes[b->scene->part_mesh[0]].index_count, 1, 0, 0, 0);
	bare_frame_end(&b->bare, frame);
}

void textured_bare_picture(textured_bare *b, stilb_image *image)
{
	const bare_frame *frame = &b->bare.frames[(b->frames - 1) % BARE_FRAMES];
	bare_frame_wait(&b->bare, frame);
	if (stilb_image_create(image, TEXTURED_WIDTH, TEXTURED_HEIGHT, 3, STILB_IMAGE_U8_SRGB) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	for (size_t i = 0; i < (size_t)TEXTURED_WIDTH * TEXTURED_HEIGHT; i++)
		memcpy((uint8_t *)image->pixels + 3 * i, (const uint8_t *)frame->picture.mapped + 4 * i, 3);
}

void textured_bare_close(textured_bare *b)
{
	VkDevice device = b->bare.device;
	vkDeviceWaitIdle(device);
	for (uint32_t i = 0; i < TEXTURED_IMAGES; i++)
		bare_free_image(&b->bare, &b->images[i]);
	bare_free_buffer(&b->bare, &b->extras);
	bare_free_buffer(&b->bare, &b->packed);
	bare_free_buffer(&b->bare, &b->view);
	bare_free_buffer(&b->bare, &b->table);
	bare_free_buffer(&b->bare, &b->material);
	vkDestroySampler(device, b->samplers[0], NULL);
	vkDestroySampler(device, b->samplers[1], NULL);
	vkDestroyPipeline(device, b->pipeline, NULL);
	vkDestroyPipelineLayout(device, b->layout, NULL);
	vkDestroyDescriptorPool(device, b->pool, NULL);
	vkDestroyDescriptorSetLayout(device, b->set_layout, NULL);
	bare_close(&b->bare);
}
