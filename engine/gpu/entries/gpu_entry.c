/* gpu: what is made and destroyed has an entry of a table; what was destroyed is freed once no frame can use it. */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>

void gpu_name_copy(char to[GPU_NAME], const char *name)
{
	snprintf(to, GPU_NAME, "%s", name ? name : "");
}

void gpu_program_forget(gpu_program *program)
{
	for (int s = 0; s < GPU_STAGES; s++) {
		free((void *)program->code[s].words);
		program->code[s] = (stilb_gpu_shader){0};
	}
}

void gpu_entry_free(stilb_gpu *gpu, gpu_kind kind, void *entry)
{
	switch (kind) {
	case GPU_BUFFER:
		gpu->functions->buffer_free(gpu, entry);
		break;
	case GPU_IMAGE:
		gpu->functions->image_free(gpu, entry);
		free(((gpu_image *)entry)->layouts);
		break;
	case GPU_SET:
		gpu->functions->set_free(gpu, entry);
		break;
	default:
		gpu->functions->program_free(gpu, entry);
		gpu_program_forget(entry);
		break;
	}
}

void *gpu_entry_add(stilb_gpu *gpu, gpu_kind kind, uint64_t *id)
{
	stilb_lock_take(&gpu->lock);
	void *entry = gpu_table_add(&gpu->tables[kind], kind == GPU_SET || kind == GPU_PROGRAM ? 32 : 52, id);
	stilb_lock_give(&gpu->lock);
	if (!entry)
		stilb_fail(STILB_ERROR_MEMORY, "no memory for one more resource of the device, or there are 2^20 already");
	return entry;
}

void gpu_entry_drop(stilb_gpu *gpu, gpu_kind kind, void *entry, uint64_t id)
{
	stilb_lock_take(&gpu->lock);
	gpu_table_drop(&gpu->tables[kind], entry, gpu_entry_index(id));
	stilb_lock_give(&gpu->lock);
}

void gpu_entry_retire_hidden(stilb_gpu *gpu, gpu_kind kind, uint32_t index)
{
	STILB_ASSERT_LOCKED(&gpu->lock);
	if (gpu->retired_count == gpu->retired_capacity) {
		uint32_t larger = gpu->retired_capacity ? 2 * gpu->retired_capacity : 64;
		gpu_retired *grown = realloc(gpu->retired, larger * sizeof *grown);
		if (!grown)
			return;
		gpu->retired = grown;
		gpu->retired_capacity = larger;
	}
	gpu->retired[gpu->retired_count++] = (gpu_retired){kind, index, gpu->frame};
}

void gpu_entry_retire(stilb_gpu *gpu, gpu_kind kind, uint64_t id)
{
	if (id == 0)
		return;
	stilb_lock_take(&gpu->lock);
	void *entry = gpu_table_get(&gpu->tables[kind], id);
	STILB_ASSERT(entry && "it was created and not destroyed");
	if (entry) {
		gpu_table_hide(&gpu->tables[kind], entry);
		gpu_entry_retire_hidden(gpu, kind, gpu_entry_index(id));
	}
	stilb_lock_give(&gpu->lock);
}

void gpu_retired_free(stilb_gpu *gpu, uint64_t done)
{
	stilb_lock_take(&gpu->lock);
	uint32_t kept = 0;
	for (uint32_t r = 0; r < gpu->retired_count; r++) {
		gpu_retired item = gpu->retired[r];
		void *entry = gpu_table_at(&gpu->tables[item.kind], item.index);
		if (item.frame > done || (item.kind == GPU_PROGRAM && ((gpu_program *)entry)->pins > 0)) {
			gpu->retired[kept++] = item;
			continue;
		}
		gpu_entry_free(gpu, item.kind, entry);
		gpu_table_drop(&gpu->tables[item.kind], entry, item.index);
	}
	gpu->retired_count = kept;
	stilb_lock_give(&gpu->lock);
}
