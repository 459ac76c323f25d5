/* Groups of maps, and their classes. */
#include "render/maps/render_groups.h"

#include "render/render_internal.h"

#include <string.h>

static render_keyed *table_item(const render_table *table, uint32_t index)
{
	return (render_keyed *)(void *)(table->items + index * table->item);
}

static uint32_t *table_chain(render_table *table, const void *key)
{
	return &table->chains[stilb_hash_fnv1a64(STILB_FNV1A64_START, key, table->key) % RENDER_CHAINS];
}

/* The link to the entry with this key, or to 0. */
static uint32_t *table_link(render_table *table, const void *key)
{
	uint32_t *link = table_chain(table, key);
	while (*link > 0 && memcmp(table_item(table, *link - 1) + 1, key, table->key) != 0)
		link = &table_item(table, *link - 1)->next;
	return link;
}

/* Finds the entry with this key, or makes one that has no users. False: no memory. */
static bool table_get(render_table *table, render_indices *indices, const void *key, uint32_t *index, bool *made)
{
	uint32_t *link = table_link(table, key);
	*made = *link == 0;
	if (!*made) {
		*index = *link - 1;
		return true;
	}
	if (!render_index_take(indices, index))
		return false;
	render_keyed *item = table_item(table, *index);
	memset(item, 0, table->item);
	memcpy(item + 1, key, table->key);
	*link = *index + 1;
	return true;
}

static void table_remove(render_table *table, render_indices *indices, uint32_t index)
{
	render_keyed *item = table_item(table, index);
	uint32_t *link = table_link(table, item + 1);
	STILB_ASSERT(*link == index + 1 && item->users == 0);
	*link = item->next;
	memset(item, 0, table->item);
	render_index_give_back(indices, index);
}

/* Fills in both keys. */
static void group_keys(const render_device *device, const render_maps *maps, uint32_t maps_index,
                       struct render_class_key *class, struct render_group_key *group)
{
	*class = (struct render_class_key){.bits = maps->bits};
	*group = (struct render_group_key){.bits = maps->bits};
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		if (!(maps->bits >> i & 1u))
			continue;
		const render_device_texture *texture = &device->textures[maps->textures[i] & RENDER_INDEX_MASK];
		STILB_ASSERT(texture->array > 0 && "textures of maps are made with mips");
		const render_array *array = &device->arrays.items[texture->array - 1];
		class->sizes[i] = (array->kind.width - 1) | (array->kind.height - 1) << 16;
		class->formats[i] = (uint8_t)array->kind.format;
		class->samplers[i] = group->samplers[i] = maps->samplers[i];
		group->arrays[i] = array->serial;
		if (render_array_is_large(&array->kind))
			class->alone = group->alone = maps_index + 1;
	}
}

stilb_result render_group_join(stilb_render *render, const render_maps *maps, uint32_t maps_index, uint32_t *index)
{
	render_resources *resources = &render->resources;
	struct render_class_key class_key;
	struct render_group_key key;
	uint32_t class;
	bool made, made_class;
	STILB_ASSERT_LOCKED(&resources->lock);
	group_keys(render->device, maps, maps_index, &class_key, &key);
	if (!table_get(&resources->classes, &resources->indices[RENDER_RESOURCE_CLASS], &class_key, &class, &made_class))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another kind of surface");
	stilb_result result = STILB_OK;
	if (!table_get(&resources->groups, &resources->indices[RENDER_RESOURCE_GROUP], &key, index, &made))
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for another kind of surface");
	if (result == STILB_OK && made) {
		result = render_device_maps_set(render->device, *index, maps);
		if (result != STILB_OK)
			table_remove(&resources->groups, &resources->indices[RENDER_RESOURCE_GROUP], *index);
	}
	if (result != STILB_OK) {
		if (made_class)
			table_remove(&resources->classes, &resources->indices[RENDER_RESOURCE_CLASS], class);
		return result;
	}
	render_group *group = render_group_of(resources, *index);
	if (made) {
		bool blends = (maps->bits & (RENDER_MAPS_BLEND | RENDER_MAPS_THROUGH)) == RENDER_MAPS_BLEND;
		group->class = class;
		resources->group_classes[*index] = blends ? RENDER_CLASS_BLENDS : class;
		table_item(&resources->classes, class)->users++;
		resources->live++;
	}
	group->head.users++;
	return STILB_OK;
}

static void group_remove(stilb_render *render, uint32_t index)
{
	render_resources *resources = &render->resources;
	uint32_t class = render_group_of(resources, index)->class;
	render_device_maps_drop(render->device, index);
	table_remove(&resources->groups, &resources->indices[RENDER_RESOURCE_GROUP], index);
	if (--table_item(&resources->classes, class)->users == 0)
		table_remove(&resources->classes, &resources->indices[RENDER_RESOURCE_CLASS], class);
	resources->live--;
}

void render_group_leave(stilb_render *render, uint32_t index, bool lives)
{
	render_resources *resources = &render->resources;
	render_group *group = render_group_of(resources, index);
	STILB_ASSERT_LOCKED(&resources->lock);
	STILB_ASSERT(group->head.users > 0);
	group->head.users--;
	group->left = lives ? resources->frame : group->left;
	if (group->head.users > 0 || group->retired)
		return;
	if (group->left + STILB_GPU_FRAMES <= resources->frame) {
		group_remove(render, index);
		return;
	}
	group->retired = true;
	render_resource_retire(resources, RENDER_RESOURCE_GROUP, index);
}

bool render_group_release(stilb_render *render, uint32_t index)
{
	render_resources *resources = &render->resources;
	render_group *group = render_group_of(resources, index);
	STILB_ASSERT_LOCKED(&resources->lock);
	STILB_ASSERT(group->retired);
	group->retired = false;
	if (group->head.users > 0)
		return true;
	if (group->left + STILB_GPU_FRAMES > resources->frame) {
		group->retired = true; /* it was joined and left again meanwhile */
		return false;
	}
	group_remove(render, index);
	return true;
}
