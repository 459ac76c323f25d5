/* Records draws into a command buffer, with a bind command before a draw wherever its state differs from that of the
 * draw before. Any thread, one at a time for a command buffer. */
#include "render/vulkan/vulkan_internal.h"

/* ---- binding ----------------------------------------------------------------------------------------------------- */

static void draws_bind_buffers_2d(vulkan_device *device, VkCommandBuffer commands)
{
	const vulkan_slot *slot = vulkan_slot_now(device);
	vulkan_push_2d push = {
		.scale = {2.0f / (float)device->base.width, 2.0f / (float)device->base.height},
		.rows = slot->memory[RENDER_MEMORY_ROWS].address,
	};
	vkCmdPushConstants(commands, device->pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
	                   sizeof push, &push);
	vkCmdBindVertexBuffers(commands, 0, 1, &slot->memory[RENDER_MEMORY_VERTICES_2D].buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(commands, slot->memory[RENDER_MEMORY_INDICES_2D].buffer, 0, VK_INDEX_TYPE_UINT32);
}

static void draws_bind_indices(const vulkan_device *device, VkCommandBuffer commands, uint64_t state)
{
	bool wide = state & RENDER_STATE_WIDE;
	vkCmdBindIndexBuffer(commands, device->heaps[wide ? RENDER_HEAP_INDICES : RENDER_HEAP_INDICES_16].buffer, 0,
	                     wide ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_UINT16);
}

static void draws_bind_buffers(vulkan_device *device, VkCommandBuffer commands, uint64_t state)
{
	const vulkan_slot *slot = vulkan_slot_now(device);
	vulkan_push push = {
		.view = slot->views.address + device->pass * sizeof(vulkan_view),
		.rows = device->rows,
		.frame_rows = slot->memory[RENDER_MEMORY_ROWS].address,
		.materials = device->heaps[RENDER_HEAP_MATERIALS].address,
		.vertices = device->heaps[RENDER_HEAP_VERTICES].address,
	};
	vkCmdPushConstants(commands, device->pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
	                   sizeof push, &push);
	vkCmdBindVertexBuffers(commands, 0, 1, &device->heaps[RENDER_HEAP_VERTICES].buffer, &(VkDeviceSize){0});
	draws_bind_indices(device, commands, state);
}

/* Binds the descriptor sets of the state's texture and material, if it has any. */
static void draws_bind_sets(vulkan_device *device, VkCommandBuffer commands, uint64_t state)
{
	uint32_t texture = render_state_texture(state), first = texture ? 0 : 1, count = 0, offsets = 0;
	VkDeviceSize offset = 0;
	VkDescriptorSet sets[2];
	STILB_ASSERT(texture < STILB_RENDER_MAX_TEXTURES && (!texture || device->textures[texture].set));
	if (texture)
		sets[count++] = device->textures[texture].set;
	if (device->base.materials == STILB_RENDER_MATERIALS_BIND && !(state & RENDER_STATE_2D)) {
		sets[count++] = vulkan_slot_now(device)->material_set;
		offset = render_state_material(state) * vulkan_material_stride(device);
		STILB_ASSERT(offset < device->heaps[RENDER_HEAP_MATERIALS].size && offset <= UINT32_MAX);
		offsets = 1;
	}
	if (count > 0)
		vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, device->pipeline_layout, first, count, sets,
		                        offsets, &(uint32_t){(uint32_t)offset});
}

/* Records the bindings between two states; returns how many there were. */
static uint32_t draws_bind(vulkan_device *device, VkCommandBuffer commands, uint64_t from, uint64_t to)
{
	uint32_t binds = render_binds_between(device->base.materials, from, to);
	if (binds & RENDER_BIND_PIPELINE)
		vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, vulkan_pipeline_for(device, to));
	if (binds & RENDER_BIND_BUFFERS && to & RENDER_STATE_2D)
		draws_bind_buffers_2d(device, commands);
	else if (binds & RENDER_BIND_BUFFERS)
		draws_bind_buffers(device, commands, to);
	if (binds & RENDER_BIND_INDICES)
		draws_bind_indices(device, commands, to);
	if (binds & RENDER_BIND_MATERIAL)
		draws_bind_sets(device, commands, to);
	return (uint32_t)__builtin_popcount(binds);
}

/* ---- draws ------------------------------------------------------------------------------------------------------- */

vulkan_sent vulkan_draws_direct(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream,
                                render_part part)
{
	vulkan_sent sent = {0};
	uint64_t state = RENDER_NO_STATE;
	for (const render_run *run = stream->runs + part.run; sent.draws < part.count; run++, part.offset = 0) {
		STILB_ASSERT(run < stream->runs + stream->run_count && part.offset < run->count);
		uint64_t left = part.count - sent.draws;
		uint32_t count = run->count - part.offset;
		count = count < left ? count : (uint32_t)left;
		sent.binds += draws_bind(device, commands, state, run->state);
		state = run->state;
		const render_command *command = stream->commands + run->first + part.offset;
		for (uint32_t i = 0; i < count; i++, command++)
			vkCmdDrawIndexed(commands, command->index_count, 1, command->first_index, command->vertex_offset,
			                 command->row);
		sent.draws += count;
	}
	return sent;
}

vulkan_sent vulkan_draws_indirect(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream)
{
	vulkan_sent sent = {0};
	uint64_t state = RENDER_NO_STATE;
	uint32_t most = device->gpu->properties.limits.maxDrawIndirectCount;
	const gpu_vulkan_buffer *buffer = &vulkan_slot_now(device)->memory[RENDER_MEMORY_COMMANDS];
	for (const render_run *run = stream->runs; run < stream->runs + stream->run_count; run++) {
		STILB_ASSERT(((VkDeviceSize)run->first + run->count) * sizeof(render_command) <= buffer->size);
		sent.binds += draws_bind(device, commands, state, run->state);
		state = run->state;
		for (uint32_t done = 0, count; done < run->count; done += count) {
			count = run->count - done < most ? run->count - done : most;
			vkCmdDrawIndexedIndirect(commands, buffer->buffer,
			                         (run->first + (VkDeviceSize)done) * sizeof(render_command), count,
			                         sizeof(render_command));
			sent.draws++;
		}
	}
	return sent;
}
