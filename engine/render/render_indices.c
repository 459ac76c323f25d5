/* Indices of tables, and the list of what waits to be released. See render_resources.h. */
#include "render/render_internal.h"

bool render_index_take(render_indices *indices, uint32_t *index)
{
	STILB_ASSERT(indices->next_unused <= indices->capacity && indices->free_count <= indices->next_unused);
	/* Reserved now so that giving back cannot fail: at most all indices that were ever used are on the stack. */
	if (!render_reserve((void **)&indices->free, &indices->free_capacity, indices->next_unused + 1,
	                    sizeof *indices->free))
		return false;
	if (indices->free_count > 0)
		*index = indices->free[--indices->free_count];
	else if (indices->next_unused < indices->capacity)
		*index = indices->next_unused++;
	else
		return false;
	return true;
}

void render_index_give_back(render_indices *indices, uint32_t index)
{
	STILB_ASSERT(index < indices->next_unused && indices->free_count < indices->free_capacity);
	indices->free[indices->free_count++] = index;
}

void render_resource_retire(render_resources *resources, render_resource_kind kind, uint32_t index)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	STILB_ASSERT(resources->retired_count < resources->live && resources->live <= resources->retired_capacity);
	resources->retired[resources->retired_count++] = (render_retired){resources->frame, kind, index};
	resources->retired_now += kind != RENDER_RESOURCE_MATERIAL;
}
